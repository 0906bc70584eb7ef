#!/usr/bin/env python3
"""Ideal meshes: the mid-surface of every fixture drawn by hand, meshed by Gmsh, to prove that the facts hold and can be met.

    measure_ideal.py NAME out.vtu --size H [--size-curvature N] [--plant DEFECT]

They know the fixtures' dimensions from fixtures/gen/NAME.geo, and nothing of the product. DEFECT spoils the mesh:
  shift    moved by a tenth of the thickness             hole     one inner element missing
  half     half of the elements missing                  thick    thickness 10 % too great
  seam     torn open along a line through the middle      flip     one inner element turned over
  needle   one node moved until an element is a needle   crease   one inner node pulled out of the surface
  torn     every sheet by itself, its junctions unmerged  wide     a fifth wider than the solid
  label    sheet numbers that do not follow the sheets   fold     one node pushed over the far edge of its element
"""
import argparse
import math

import gmsh
import numpy as np

import measure_vtu


class Draft:
    """Surfaces with a thickness each; junctions and creases come from their being cut by one another."""

    def __init__(self):
        self.o = gmsh.model.occ
        self.parts = []  # (surface tag, thickness or function of (x, y, z))

    def add(self, tags, t):
        self.parts += [(tag, t) for tag in np.atleast_1d(tags)]

    def rect(self, corner, u, v, t):
        """the parallelogram of edges u and v"""
        p = [np.array(corner, float), np.add(corner, u), np.add(np.add(corner, u), v), np.add(corner, v)]
        k = [self.o.addPoint(*q) for q in p]
        lines = [self.o.addLine(k[i], k[(i + 1) % 4]) for i in range(4)]
        self.add(self.o.addPlaneSurface([self.o.addCurveLoop(lines)]), t)

    def sweep(self, curves, along, t):
        """curves carried along a vector"""
        out = self.o.extrude([(1, c) for c in curves], *along)
        self.add([tag for d, tag in out if d == 2], t)

    def spin(self, curves, angle, t):
        """curves turned about the z axis"""
        out = self.o.revolve([(1, c) for c in curves], 0, 0, 0, 0, 0, 1, angle)
        self.add([tag for d, tag in out if d == 2], t)

    def line(self, a, b):
        return self.o.addLine(self.o.addPoint(*a), self.o.addPoint(*b))

    def profile(self, corners, r, width, t):
        """a polyline in the plane y = 0 with all its inner corners rounded to radius r, carried along y"""
        c = [np.array([x, 0, z], float) for x, z in corners]
        at, curves = self.o.addPoint(*c[0]), []
        for i in range(1, len(c) - 1):
            a, b = (c[i - 1] - c[i]), (c[i + 1] - c[i])
            a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
            p, q, m = (self.o.addPoint(*x) for x in (c[i] + r * a, c[i] + r * b, c[i] + r * (a + b)))
            curves += [self.o.addLine(at, p), self.o.addCircleArc(p, m, q)]
            at = q
        curves.append(self.o.addLine(at, self.o.addPoint(*c[-1])))
        self.sweep(curves, (0, width, 0), t)

    def cut(self, drop=None):
        """all surfaces cut by one another; drop(box) tells which pieces go"""
        if len(self.parts) > 1:
            _, images = self.o.fragment([(2, k) for k, _ in self.parts], [])
            self.o.synchronize()
            kept = {}
            for (_, t), image in zip(self.parts, images):
                for _, tag in image:
                    kept[tag] = t
            self.parts = list(kept.items())
        self.o.synchronize()
        if drop:
            gone = [k for k, _ in self.parts if drop(gmsh.model.getBoundingBox(2, k))]
            self.o.remove([(2, k) for k in gone], recursive=True)
            self.o.synchronize()
            self.parts = [(k, t) for k, t in self.parts if k not in gone]


def ribs(d, L, W, T, t, H, b, x0=0.0, k=None):
    """a plate with one rib along x"""
    d.rect((0, 0, T / 2), (L, 0, 0), (0, W, 0), t)
    d.rect((x0, W / 2, T / 2), (k or L, 0, 0), (0, 0, H + T / 2), b)


def draw(name, d):
    """the mid-surface of fixture `name`; returns what is left to do to the nodes, if anything, and which pieces to drop"""
    o, pi = d.o, math.pi
    lift, drop = None, None
    if name in ("flat_plate", "split_plate", "strip_plate"):
        d.rect((0, 0, 1.5), (60, 0, 0), (0, 40, 0), 3.0)
    elif name == "plate_holes":
        d.rect((0, 0, 1.5), (80, 0, 0), (0, 50, 0), 3.0)
        tools = [o.addDisk(20, 25, 1.5, 8, 8), o.addDisk(42, 14, 1.5, 5, 5), o.addRectangle(55, 28, 1.5, 14, 10)]
        out, _ = o.cut([(2, d.parts[0][0])], [(2, k) for k in tools])
        d.parts = [(out[0][1], 3.0)]
    elif name == "plate_web":
        d.rect((0, 0, 0.75), (100, 0, 0), (0, 60, 0), 1.5)
        out, _ = o.cut([(2, d.parts[0][0])], [(2, o.addDisk(x, 30, 0.75, 6, 6)) for x in (25, 75)])
        d.parts = [(out[0][1], 1.5)]
        d.rect((50, 0, 0.75), (0, 60, 0), (0, 0, 25.75), 1.5)
    elif name == "wedge":
        k = math.tan(math.atan(4 / 60) / 2)
        d.rect((0, 0, 30 * k), (60, 0, 60 * k), (0, 40, 0), lambda x, y, z: 2 * (x + 30) * k)
    elif name == "l_sharp":
        d.rect((1.5, 0, 1.5), (38.5, 0, 0), (0, 25, 0), 3.0)
        d.rect((1.5, 0, 1.5), (0, 0, 28.5), (0, 25, 0), 3.0)
    elif name == "l_bend":
        d.profile([(30, 1.5), (1.5, 1.5), (1.5, 24)], 3.5, 15, 3.0)
    elif name == "u_bend":
        d.profile([(1.5, 20), (1.5, 1.5), (28.5, 1.5), (28.5, 20)], 3.5, 15, 3.0)
    elif name == "z_bend":
        d.profile([(0, 1.5), (18.5, 1.5), (18.5, 23.5), (37, 23.5)], 3.5, 15, 3.0)
    elif name == "hat_bend":
        d.profile([(0, 1.5), (12.5, 1.5), (12.5, 18.5), (35.5, 18.5), (35.5, 1.5), (48, 1.5)], 3.5, 12, 3.0)
    elif name in ("t_sharp", "t_fillet", "fillet_variable", "fillet_stepped"):
        ribs(d, 60, 40, 3, 3.0, 20, 2.0)
    elif name == "rib_partial":
        ribs(d, 60, 40, 3, 3.0, 20, 2.0, 15, 30)
    elif name == "rib_partial_fillet":
        d.rect((0, 0, 1.5), (60, 0, 0), (0, 40, 0), 3.0)
        p = [(15, 1.5), (45, 1.5), (45, 3), (47, 3), (45, 5), (45, 23), (15, 23), (15, 5), (13, 3), (15, 3)]
        # the wedge of plate under the end of the fillet has no sheet of its own: the foot is as long as the rib
        p = [q for q in p if q not in ((45, 3), (15, 3))]
        k = [o.addPoint(x, 20, z) for x, z in p]
        right, left = o.addPoint(47, 20, 5), o.addPoint(13, 20, 5)
        c = [o.addLine(k[0], k[1]), o.addLine(k[1], k[2]), o.addCircleArc(k[2], right, k[3]), o.addLine(k[3], k[4]),
             o.addLine(k[4], k[5]), o.addLine(k[5], k[6]), o.addCircleArc(k[6], left, k[7]), o.addLine(k[7], k[0])]
        d.add(o.addPlaneSurface([o.addCurveLoop(c)]), 2.0)
    elif name == "x_cross":
        d.rect((-20, 0, 0), (40, 0, 0), (0, 30, 0), 2.0)
        d.rect((0, 0, -25), (0, 0, 50), (0, 30, 0), 3.0)
    elif name == "y_plates":
        for i in range(3):
            d.rect((0, 0, 0), (25 * math.cos(i * 2 * pi / 3), 25 * math.sin(i * 2 * pi / 3), 0), (0, 0, 30), 3.0)
    elif name == "ribs_crossing":
        ribs(d, 60, 60, 3, 3.0, 15, 2.0)
        d.rect((30, 0, 1.5), (0, 60, 0), (0, 0, 16.5), 2.0)
    elif name == "egg_crate":
        for i in (20, 40, 60):
            d.rect((0, i, 0), (80, 0, 0), (0, 0, 15), 2.0)
            d.rect((i, 0, 0), (0, 80, 0), (0, 0, 15), 2.0)
    elif name == "boss_ribs":
        d.rect((-30, -30, 1.5), (60, 0, 0), (0, 60, 0), 3.0)
        d.sweep([o.addCircle(0, 0, 1.5, 5)], (0, 0, 10.5), 3.0)
        for u in ((1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0)):
            d.rect((5 * u[0], 5 * u[1], 1.5), (15 * u[0], 15 * u[1], 0), (0, 0, 7.5), 2.0)
    elif name in ("open_box", "closed_box"):
        h = 19 if name == "open_box" else 28
        d.rect((1, 1, 1), (48, 0, 0), (0, 38, 0), 2.0)
        if name == "closed_box":
            d.rect((1, 1, 29), (48, 0, 0), (0, 38, 0), 2.0)
        for p, u in (((1, 1, 1), (48, 0, 0)), ((1, 39, 1), (48, 0, 0)), ((1, 1, 1), (0, 38, 0)), ((49, 1, 1), (0, 38, 0))):
            d.rect(p, u, (0, 0, h), 2.0)
    elif name == "tube":
        d.sweep([o.addCircle(0, 0, 0, 18)], (0, 0, 24), 4.0)
    elif name == "cone_shell":
        a = math.radians(20)
        d.spin([d.line((10, 0, 0), (10 + 16 * math.sin(a), 0, 16 * math.cos(a)))], 2 * pi, 4.0)
    elif name == "half_sphere":
        a, c, b = o.addPoint(17.5, 0, 0), o.addPoint(0, 0, 0), o.addPoint(0, 0, 17.5)
        d.spin([o.addCircleArc(a, c, b)], 2 * pi, 5.0)
    elif name == "torus_shell":
        k = o.addCircle(16, 0, 0, 6)
        o.rotate([(1, k)], 16, 0, 0, 1, 0, 0, pi / 2)
        d.spin([k], pi / 2, 4.0)
    elif name == "tubes_t":
        k = o.addCircle(-14, 0, 0, 10)
        o.rotate([(1, k)], -14, 0, 0, 0, 1, 0, pi / 2)
        d.sweep([k], (28, 0, 0), 5.0)
        d.sweep([o.addCircle(0, 0, 0, 5)], (0, 0, 22), 4.0)
        e = 0.1
        inner = lambda b: b[0] > -5 - e and b[3] < 5 + e  # within the branch in x
        drop = lambda b: inner(b) and (b[5] < 10 + e)
    elif name == "step_symmetric":
        d.rect((0, 0, 0), (60, 0, 0), (0, 40, 0), 3.0)
        d.rect((60, 0, 0), (60, 0, 0), (0, 40, 0), 5.0)
    elif name == "step_flush":
        for x, w in ((0, 60), (60, math.sqrt(3)), (60 + math.sqrt(3), 60 - math.sqrt(3))):
            d.rect((x, 0, 0), (w, 0, 0), (0, 40, 0), lambda x, y, z: 2 * z)
        lift = lambda p: np.c_[p[:, :2], 1.5 + np.clip(p[:, 0] - 60, 0, math.sqrt(3)) ** 2 / 6]
    elif name == "plate_pocket":
        r = math.sqrt(3)
        d.add(o.addRectangle(0, 0, 0, 160, 110), lambda x, y, z: 2 * z)
        d.add(o.addRectangle(62, 43, 0, 36, 24), lambda x, y, z: 2 * z)
        d.add(o.addRectangle(62 - r, 43 - r, 0, 36 + 2 * r, 24 + 2 * r, -1, r), lambda x, y, z: 2 * z)
        def lift(p):
            out = np.maximum(np.abs(p[:, :2] - [80, 55]) - [18, 12], 0)
            return np.c_[p[:, :2], 1.5 + np.minimum(np.linalg.norm(out, axis=1), r) ** 2 / 6]
    elif name == "rib_tapered":
        c = math.cos(math.atan(1 / 20))
        ribs(d, 60, 40, 3, 3.0, 20, lambda x, y, z: (4 - 0.1 * (z - 3)) * c)
    elif name == "bspline_shell":
        d.rect((-30, 0, 0), (60, 0, 0), (0, 30, 0), 3.0)
        lift = lambda p: np.c_[p[:, :2], p[:, 0] ** 2 / 80]
    elif name == "bspline_bowl":
        d.spin([d.line((6, 0, 0), (18, 0, 0))], math.radians(150), 3.0)
        lift = lambda p: np.c_[p[:, :2], (p[:, 0] ** 2 + p[:, 1] ** 2) / 40]
    elif name == "two_thickness":
        ribs(d, 80, 60, 6, 6.0, 25, 1.0)
    elif name == "rounded_rim":
        d.rect((0, 0, 1.5), (40, 0, 0), (0, 70, 0), lambda x, y, z: 3 - 2 * np.maximum(1.5 - y, 0))
    elif name == "blade":
        k = 2 * 3 / 60
        d.rect((-3, 0, 0), (3, 0, 0), (0, 30, 0), lambda x, y, z: 6 + 2 * x)
        d.rect((0, 0, 0), (60, 0, 0), (0, 30, 0), lambda x, y, z: (60 - x) * k)
    elif name == "slanted_rim":
        d.rect((0, 0, 1.5), (60, 0, 0), (0, 40, 0), 3.0)
    elif name == "chamfered_rim":
        k = math.tan(pi / 8)
        fold, low = 60 - (1.5 - 1.2 * k) / k, 1.2 * k
        d.rect((0, 0, 1.5), (fold, 0, 0), (0, 40, 0), 3.0)
        d.rect((fold, 0, 1.5), (60 - fold, 0, low - 1.5), (0, 40, 0), lambda x, y, z: 2 * z)
    elif name == "quarter_round":
        # a parabola is a Bezier curve of degree 2: from the crest of the middle, where it is flat, down to the edge at 45 degrees
        k = [o.addPoint(x, 0, z) for x, z in ((0, 1.5), (57, 1.5), (58.5, 1.5), (60, 0))]
        d.sweep([o.addLine(k[0], k[1]), o.addBezier(k[1:])], (0, 40, 0), lambda x, y, z: 2 * z)
    elif name in ("fillet_one_side", "chamfer_t"):
        ribs(d, 60, 40, 3, 3.0, 20, 2.0)
    elif name == "fillet_wide":
        ribs(d, 20, 160, 1.5, 1.5, 80, 1.5)
    elif name == "flange_thin_web_thick":
        ribs(d, 60, 70, 2, 2.0, 40, 6.0)
    elif name == "rib_draft":
        a = math.radians(2)
        ribs(d, 60, 40, 3, 3.0, 20, lambda x, y, z: (2 + 2 * (23 - z) * math.tan(a)) * math.cos(a))
    elif name in ("joggle", "emboss"):
        # two arcs of radius 5 and the flats at their ends, from (0, z) with a step of `up`
        def section(first, up, last, z):
            k = [o.addPoint(x, 0, z + up * h) for x, h in ((0, 0), (first, 0), (first + 3, 1), (first + 6, 2), (last, 2))]
            a, b = o.addPoint(first, 0, z + 5 * up), o.addPoint(first + 6, 0, z - 3 * up)
            return [o.addLine(k[0], k[1]), o.addCircleArc(k[1], a, k[2]), o.addCircleArc(k[2], b, k[3]), o.addLine(k[3], k[4])]
        if name == "joggle":
            d.sweep(section(20, 1, 46, 1), (0, 12, 0), 2.0)
        else:
            d.spin(section(5, -1, 13, 3), 2 * pi, 2.0)
            out, _ = o.cut([(2, o.addRectangle(-23, -23, 1, 46, 46))], [(2, o.addDisk(0, 0, 1, 13, 13))])
            d.add([k for _, k in out], 2.0)
    elif name == "perforated":
        tools = [o.addDisk(6 * i, 6 * j, 0.75, 1.2, 1.2) for i in range(1, 13) for j in range(1, 11)]
        out, _ = o.cut([(2, o.addRectangle(0, 0, 0.75, 78, 66))], [(2, k) for k in tools])
        d.add([k for _, k in out], 1.5)
    elif name == "slots":
        tools = []
        for x, y in ((x, 1 + 8 * j) for x in (10, 46) for j in range(1, 6)):
            tools += [o.addRectangle(x, y - 2, 1, 24, 4), o.addDisk(x, y, 1, 2, 2), o.addDisk(x + 24, y, 1, 2, 2)]
        out, _ = o.cut([(2, o.addRectangle(0, 0, 1, 80, 50))], [(2, k) for k in tools])
        d.add([k for _, k in out], 2.0)
    elif name == "spiral":
        b, n = 3.5 / pi, 120
        q = np.linspace(0, 2.5 * pi, n + 1)
        at = np.c_[(10 + b * q) * np.cos(q), (10 + b * q) * np.sin(q)]
        along = np.c_[b * np.cos(q) - at[:, 1], b * np.sin(q) + at[:, 0]] / np.hypot(10 + b * q, b)[:, None]
        k = [o.addPoint(*p, 0) for p in at]
        ends = [o.addPoint(*(at[0] - 2 * along[0]), 0), o.addPoint(*(at[-1] + 2 * along[-1]), 0)]
        d.sweep([o.addLine(ends[0], k[0]), o.addSpline(k), o.addLine(k[-1], ends[1])], (0, 0, 10), 4.0)
    elif name == "lens_duct":
        x = math.sqrt(59**2 - 45**2)
        k = [o.addPoint(*p) for p in ((-x, 0, 0), (x, 0, 0), (0, 0, -45), (0, 0, 45))]
        d.sweep([o.addCircleArc(k[0], k[2], k[1]), o.addCircleArc(k[1], k[3], k[0])], (0, 40, 0), 2.0)
    elif name == "c_tube":
        d.spin([d.line((18, 0, 0), (18, 0, 24))], 2 * pi - pi / 9, 4.0)
    elif name == "hollow_sphere":
        k = [o.addPoint(*p) for p in ((0, 0, -10), (10, 0, 0), (0, 0, 10), (0, 0, 0))]
        d.spin([o.addCircleArc(k[0], k[3], k[1]), o.addCircleArc(k[1], k[3], k[2])], 2 * pi, 5.0)
    elif name == "bottle":
        c = math.sqrt(0.5)
        s = 4.5 / c - 8 * (1 / c - 1)
        top = 12 + 8 * c + s * c
        k = [o.addPoint(x, 0, z) for x, z in ((0, 0), (6, 0), (10, 4), (10, 12), (6 + 4 * c, 12 + 4 * c), (9.5 - 4 * c, top - 4 * c),
                                              (5.5, top), (5.5, top + 4))]
        m = [o.addPoint(x, 0, z) for x, z in ((6, 4), (6, 12), (9.5, top))]
        arc = lambda i, j: o.addCircleArc(k[i], m[j], k[i + 1])
        line = lambda i: o.addLine(k[i], k[i + 1])
        d.spin([line(0), arc(1, 0), line(2), arc(3, 1), line(4), arc(5, 2), line(6)], 2 * pi, 4.0)
    elif name == "two_solids":
        for y, a, h in ((0, 40, 30), (20, 20, 15)):
            d.rect((1.5, y, 1.5), (a - 1.5, 0, 0), (0, 15, 0), 3.0)
            d.rect((1.5, y, 1.5), (0, 0, h - 1.5), (0, 15, 0), 3.0)
    elif name == "five_arms":
        for i in range(5):
            d.rect((0, 0, 0), (25 * math.cos(i * 2 * pi / 5), 25 * math.sin(i * 2 * pi / 5), 0), (0, 0, 30), 3.0)
    elif name == "rib_shallow":
        d.rect((0, 0, 1.5), (80, 0, 0), (0, 50, 0), 3.0)
        k = 40 * math.tan(math.radians(12.5))
        for y in (k, -k):
            d.rect((0, 25 - y, 1.5), (80, 2 * y, 0), (0, 0, 16.5), 2.0)
    elif name == "boss_on_rib":
        d.rect((-30, -20, 1.5), (60, 0, 0), (0, 40, 0), 3.0)
        d.sweep([o.addCircle(0, 0, 1.5, 5)], (0, 0, 17.5), 3.0)
        for u in (1, -1):
            d.rect((5 * u, 0, 1.5), (25 * u, 0, 0), (0, 0, 11.5), 2.0)
    elif name == "rib_to_fillet":
        ribs(d, 60, 90, 3, 3.0, 40, 2.0)
        d.rect((30, 0, 1.5), (0, 45, 0), (0, 0, 4.5), 1.0)
    elif name == "countersunk":
        tools = [o.addDisk(x, y, 1, 2, 2) for x in (22.5, 67.5) for y in (17.5, 52.5)]
        out, _ = o.cut([(2, o.addRectangle(0, 0, 1, 90, 70))], [(2, k) for k in tools])
        d.add([k for _, k in out], 2.0)
    elif name == "countersunk_wide":
        k = math.tan(pi / 8)
        q, low = 2 + 1 / k - 1.5, 1.5 * k
        places = [(x, y) for x in (22.5, 67.5) for y in (17.5, 52.5)]
        out, _ = o.cut([(2, o.addRectangle(0, 0, 1, 90, 70))], [(2, o.addDisk(x, y, 1, q, q)) for x, y in places])
        d.add([k for _, k in out], 2.0)
        for x, y in places:
            out = o.revolve([(1, d.line((x + 2, y, low), (x + q, y, 1)))], x, y, 0, 0, 0, 1, 2 * pi)
            d.add([tag for dim, tag in out if dim == 2], lambda x, y, z: 2 * z)
    elif name == "slot_rim":
        tools = [o.addRectangle(20, 5, 1, 40, 6), o.addDisk(20, 8, 1, 3, 3), o.addDisk(60, 8, 1, 3, 3)]
        out, _ = o.cut([(2, o.addRectangle(0, 0, 1, 80, 40))], [(2, k) for k in tools])
        d.add([k for _, k in out], 2.0)
    elif name == "pinhole":
        out, _ = o.cut([(2, o.addRectangle(0, 0, 2, 60, 40))], [(2, o.addDisk(25, 18, 2, 0.5, 0.5))])
        d.add([k for _, k in out], 4.0)
    elif name == "touching":
        d.rect((0, 0, 1.5), (40, 0, 0), (0, 30, 0), 3.0)
        d.rect((3, 8, 4.5), (40, 0, 0), (0, 30, 0), 3.0)
    elif name == "nut_pocket":
        r, q = math.sqrt(3), 5 / math.sqrt(3)
        def hexagon(grow):
            """the hexagon carried out by `grow`, its corners round"""
            c = [(30 + 2 * q * math.cos(i * pi / 3), 25 + 2 * q * math.sin(i * pi / 3)) for i in range(6)]
            n = [(math.cos((2 * i + 1) * pi / 6), math.sin((2 * i + 1) * pi / 6)) for i in range(6)]
            at = lambda i, j: o.addPoint(c[i][0] + grow * n[j][0], c[i][1] + grow * n[j][1], 0)
            ends = [(at(i, i), at((i + 1) % 6, i)) for i in range(6)] if grow else None
            if not grow:
                k = [o.addPoint(*p, 0) for p in c]
                return o.addPlaneSurface([o.addCurveLoop([o.addLine(k[i], k[(i + 1) % 6]) for i in range(6)])])
            curves = []
            for i in range(6):
                curves += [o.addLine(*ends[i]), o.addCircleArc(ends[i][1], o.addPoint(*c[(i + 1) % 6], 0), ends[(i + 1) % 6][0])]
            return o.addPlaneSurface([o.addCurveLoop(curves)])
        shapes = [o.addRectangle(0, 0, 0, 60, 50), hexagon(r), hexagon(0)]
        for k in shapes:
            out, _ = o.cut([(2, k)], [(2, o.addDisk(30, 25, 0, 2.2, 2.2))])
            d.add([tag for _, tag in out], lambda x, y, z: 2 * z)
        def lift(p):
            # in the sector of the side: beyond its ends the distance is that to a corner
            w = p[:, :2] - [30, 25]
            a = np.mod(np.arctan2(w[:, 1], w[:, 0]), pi / 3) - pi / 6
            rho = np.hypot(w[:, 0], w[:, 1])
            off, along = rho * np.cos(a) - 5, np.abs(rho * np.sin(a)) - q
            far = np.where(off > 0, np.hypot(off, np.maximum(along, 0)), 0)
            return np.c_[p[:, :2], 1.5 + np.minimum(far, r) ** 2 / 6]
    elif name == "nut_boss":
        out, _ = o.cut([(2, o.addRectangle(-25, -20, 1.5, 50, 40))], [(2, o.addDisk(0, 0, 1.5, 2.1, 2.1))])
        d.add([k for _, k in out], 3.0)
        k = [o.addPoint(10 / math.sqrt(3) * math.cos(i * pi / 3), 10 / math.sqrt(3) * math.sin(i * pi / 3), 1.5) for i in range(6)]
        d.sweep([o.addLine(k[i], k[(i + 1) % 6]) for i in range(6)], (0, 0, 9.5), 2.0)
    elif name == "spot_tray":
        wall, low, c = 2.5, -3.25, 1.0
        floor, rings = o.addRectangle(0, 0, low, 20, 16), []
        for big, small in ((4 + c, 4), (4, 1.5)):
            out, _ = o.cut([(2, o.addDisk(10, 8, low, big, big))], [(2, o.addDisk(10, 8, low, small, small))])
            rings += [k for _, k in out]
        out, _ = o.cut([(2, floor)], [(2, o.addDisk(10, 8, low, 4 + c, 4 + c))])
        d.add([k for _, k in out], wall)
        d.add(rings, lambda x, y, z: 2 * (z + 4.5))
        def lift(p):
            far = np.hypot(p[:, 0] - 10, p[:, 1] - 8)
            floor = (p[:, 2] < low + 1e-9) & (far < 4 + c + 1e-9)
            return np.c_[p[:, :2], np.where(floor, low - 0.25 + np.clip(far - 4, 0, c) ** 2 / 4, p[:, 2])]
        corners = [(0, 0, pi), (20, 0, -pi / 2), (20, 16, 0), (0, 16, pi / 2)]
        for i, (x, y, a) in enumerate(corners):
            u, v = corners[i - 1][:2]
            p, q = x - low * math.cos(a), y - low * math.sin(a)
            k = [o.addPoint(*at) for at in ((x, y, low), (x, y, 0), (p, q, 0), (p, q, 2))]
            section = [o.addCircleArc(k[0], k[1], k[2]), o.addLine(k[2], k[3])]
            turned = o.revolve(o.copy([(1, e) for e in section]), x, y, 0, 0, 0, 1, pi / 2)
            d.add([tag for dim, tag in turned if dim == 2], wall)
            d.sweep(section, (u - x, v - y, 0), wall)
    elif name == "split_tube":
        d.sweep([o.addCircle(0, 0, 0, 10.5)], (0, 0, 16), 3.0)
    elif name == "wide_rim":
        ribs(d, 60, 40, 3, 3.0, 3.6, 3.0)
    elif name == "tight_bend":
        d.profile([(30, 1.5), (1.5, 1.5), (1.5, 24)], 2.7, 15, 3.0)
    elif name == "meeting_point":
        ribs(d, 60, 50, 3, 3.0, 20, 2.0)
        d.rect((30, 25, 1.5), (0, 25, 0), (0, 0, 21.5), 2.0)
    elif name == "wing_skin":
        a = math.radians(25)
        x, y, z = 10.5 / math.sin(a), 10.5 * math.sin(a), 10.5 * math.cos(a)
        k = [o.addPoint(*p) for p in ((x, 0, 0), (y, 0, z), (-10.5, 0, 0), (y, 0, -z), (0, 0, 0))]
        d.sweep([o.addLine(k[0], k[1]), o.addCircleArc(k[1], k[4], k[2]), o.addCircleArc(k[2], k[4], k[3]), o.addLine(k[3], k[0])], (0, 16, 0), 3.0)
    elif name == "sliver_rim":
        d.rect((0, 0, 1.5), (50, 0, 0), (0, 40, 0), 3.0)
    else:
        raise SystemExit(f"no ideal mesh for {name}")
    return lift, drop


def build(name, size, curvature):
    """points, triangles, sheet number a triangle, thickness at its corners"""
    gmsh.initialize(["gmsh", "-nopopup"], interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    d = Draft()
    lift, drop = draw(name, d)
    d.cut(drop)
    for key, value in (("MeshSizeMax", size), ("MeshSizeFromCurvature", curvature or 0), ("Algorithm", 6), ("RandomSeed", 1)):
        gmsh.option.setNumber("Mesh." + key, value)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.removeDuplicateNodes()
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    row = np.full(int(tags.max()) + 1, -1)
    row[tags.astype(int)] = np.arange(len(tags))
    X = xyz.reshape(-1, 3)
    X = lift(X) if lift else X
    T, sheet, thick = [], [], []
    for k, (tag, t) in enumerate(sorted(d.parts, key=lambda part: part[0])):
        _, _, nodes = gmsh.model.mesh.getElements(2, tag)
        tri = row[np.concatenate(nodes).astype(int)].reshape(-1, 3)
        p = X[tri]
        T.append(tri)
        sheet.append(np.full(len(tri), k))
        thick.append(t(p[..., 0], p[..., 1], p[..., 2]) if callable(t) else np.full(tri.shape, t))
    gmsh.finalize()
    T, sheet, thick = _agree(X, np.vstack(T), np.concatenate(sheet), np.vstack(thick))
    used = np.unique(T)
    new = np.full(len(X), -1)
    new[used] = np.arange(len(used))
    return X[used], new[T], sheet, thick


def _agree(X, T, sheet, thick):
    """triangles turned so that smooth neighbours agree, and sheets numbered by smooth connection"""
    from measure_mesh import CREASE_DEG
    ends = np.sort(np.vstack([T[:, [0, 1]], T[:, [1, 2]], T[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(T)), 3)
    n = np.cross(X[T[:, 1]] - X[T[:, 0]], X[T[:, 2]] - X[T[:, 0]])
    n /= np.linalg.norm(n, axis=1)[:, None]
    at = {}
    for e, k in zip(map(tuple, ends), owner):
        at.setdefault(e, []).append(k)
    links = [[] for _ in T]
    for pair in at.values():
        if len(pair) == 2 and abs(n[pair[0]] @ n[pair[1]]) > math.cos(math.radians(CREASE_DEG)):
            links[pair[0]].append(pair[1])
            links[pair[1]].append(pair[0])
    T, thick, number = T.copy(), thick.copy(), np.full(len(T), -1)
    next_number = 0
    for seed in range(len(T)):
        if number[seed] >= 0:
            continue
        number[seed], todo = next_number, [seed]
        while todo:
            a = todo.pop()
            for b in links[a]:
                if number[b] < 0:
                    number[b] = next_number
                    if n[a] @ n[b] < 0:
                        n[b] = -n[b]
                        T[b], thick[b] = T[b][::-1], thick[b][::-1]
                    todo.append(b)
        next_number += 1
    return T, number, thick


def plant(X, T, sheet, thick, defect):
    """the mesh with one defect"""
    X, T, sheet, thick = X.copy(), T.copy(), sheet.copy(), thick.copy()
    centre = X[T].mean(axis=1)
    edge_use = {}
    for t in T:
        for i in range(3):
            e = tuple(sorted((t[i], t[(i + 1) % 3])))
            edge_use[e] = edge_use.get(e, 0) + 1
    border = {v for e, n in edge_use.items() if n != 2 for v in e}
    inner = next(k for k in np.argsort(np.linalg.norm(centre - centre[sheet == 0].mean(axis=0), axis=1))
                 if not border & set(T[k]) and sheet[k] == 0)
    normal = np.cross(X[T[inner, 1]] - X[T[inner, 0]], X[T[inner, 2]] - X[T[inner, 0]])
    normal /= np.linalg.norm(normal)
    if defect == "shift":
        X = X + 0.1 * thick[inner, 0] * normal
    elif defect == "hole":
        T, sheet, thick = (np.delete(a, inner, axis=0) for a in (T, sheet, thick))
    elif defect == "half":
        keep = centre[:, 0] < np.median(centre[:, 0])
        T, sheet, thick = T[keep], sheet[keep], thick[keep]
    elif defect == "thick":
        thick = 1.1 * thick
    elif defect in ("seam", "torn"):
        part = sheet if defect == "torn" else (centre[:, 0] < np.median(centre[:, 0])).astype(int)
        key, new = np.unique(np.c_[np.repeat(part, 3), T.ravel()], axis=0, return_inverse=True)
        X, T = X[key[:, 1]], new.reshape(-1, 3)
    elif defect == "flip":
        T[inner] = T[inner][::-1]
    elif defect == "needle":
        a, b = T[inner, 0], T[inner, 1]
        X[a] = X[b] + 0.05 * (X[a] - X[b])
    elif defect == "crease":
        X[T[inner, 0]] += 3 * np.linalg.norm(X[T[inner, 1]] - X[T[inner, 0]]) * normal
    elif defect == "fold":
        a, b, c = X[T[inner]]
        foot = b + (c - b) * ((a - b) @ (c - b)) / ((c - b) @ (c - b))
        X[T[inner, 0]] = a + 1.3 * (foot - a)
    elif defect == "wide":
        X[:, 0] = 1.2 * (X[:, 0] - X[:, 0].mean()) + X[:, 0].mean()
    elif defect == "label":
        sheet = (centre[:, 0] < np.median(centre[:, 0])).astype(int)
    else:
        raise SystemExit(f"no defect {defect}")
    return X, T, sheet, thick


def main():
    a = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    a.add_argument("name")
    a.add_argument("out")
    a.add_argument("--size", type=float, required=True)
    a.add_argument("--size-curvature", type=float)
    a.add_argument("--plant")
    a = a.parse_args()
    X, T, sheet, thick = build(a.name, a.size, a.size_curvature)
    if a.plant:
        X, T, sheet, thick = plant(X, T, sheet, thick, a.plant)
    total, n = np.zeros(len(X)), np.zeros(len(X))
    np.add.at(total, T, thick)
    np.add.at(n, T, 1)
    measure_vtu.write(a.out, X, list(T), {"thickness": total / np.maximum(n, 1)}, {"thickness": thick.mean(axis=1), "sheet": sheet})


if __name__ == "__main__":
    main()
