"""The solid, exact: rays through its tessellation find the face, Gmsh's OpenCASCADE kernel gives the distance to its surface."""
import gmsh
import numpy as np
from scipy.spatial import cKDTree

WALL_COS = np.cos(np.radians(30))  # two sides of a wall are parallel to within this (the steepest fixture is off by 6 degrees)


class Solid:
    """A solid with walls of at most `thickest`, tessellated at that size."""

    def __init__(self, path, thickest=None):
        if not gmsh.isInitialized():
            gmsh.initialize(["gmsh", "-nopopup"], interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.clear()
        gmsh.model.occ.importShapes(path, highestDimOnly=False)
        gmsh.model.occ.synchronize()
        volumes = [t for _, t in gmsh.model.getEntities(3)]
        if not volumes:
            raise ValueError(f"{path}: no solid")
        self.solids = len(volumes)
        self.volume = sum(gmsh.model.occ.getMass(3, t) for t in volumes)
        self.faces = [t for _, t in gmsh.model.getEntities(2)]
        self.loose = sum(not len(gmsh.model.getAdjacencies(2, t)[0]) for t in self.faces)
        surface = sum(gmsh.model.occ.getMass(2, t) for t in self.faces)
        self.thickest = thickest or 3 * 2 * self.volume / surface
        # Round a hole much narrower than the wall a quarter of the thickness leaves too few edges to be a ring: then a finer one.
        for finest in (4, 16, 64):
            self._tessellate(volumes, self.thickest / finest)
            if self.closed:
                break

    def _tessellate(self, volumes, finest):
        gmsh.model.mesh.clear()
        for name, value in (("MeshSizeMax", self.thickest), ("MeshSizeMin", finest), ("MeshSizeFromCurvature", 36),
                            ("ElementOrder", 1), ("Algorithm", 6), ("RandomSeed", 1)):
            gmsh.option.setNumber("Mesh." + name, value)
        gmsh.model.mesh.generate(2)
        tags, xyz, _ = gmsh.model.mesh.getNodes()
        row = np.full(int(tags.max()) + 1, -1)
        row[tags.astype(int)] = np.arange(len(tags))
        self.X = xyz.reshape(-1, 3)
        tri, face = [], []
        for t in self.faces:
            kinds, _, nodes = gmsh.model.mesh.getElements(2, t)
            for n in nodes:
                part = row[n.astype(int)].reshape(-1, 3)
                tri.append(part)
                face.append(np.full(len(part), t))
        self.tri, self.face = np.vstack(tri), np.concatenate(face)
        self._orient(volumes)
        a, b, c = (self.X[self.tri[:, i]] for i in range(3))
        cross = np.cross(b - a, c - a)
        self.area = np.linalg.norm(cross, axis=1) / 2
        self.normal = cross / np.maximum(2 * self.area, np.finfo(float).tiny)[:, None]
        self.centre = (a + b + c) / 3
        self.reach = float(np.linalg.norm(np.stack([a, b, c]) - self.centre, axis=2).max())
        self.tree = cKDTree(self.centre)

    def _orient(self, volumes):
        """all triangles outward: faces are turned to agree across their edges, then each shell of each solid by the sign of its volume"""
        ends = np.vstack([self.tri[:, [0, 1]], self.tri[:, [1, 2]], self.tri[:, [2, 0]]])
        owner = np.tile(np.arange(len(self.tri)), 3)
        edges, which, uses = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
        self.closed = bool((uses == 2).all())
        self.euler = (len(np.unique(self.tri)) - len(edges) + len(self.tri)) / 2
        if not self.closed:
            return
        order = np.argsort(which.ravel(), kind="stable").reshape(-1, 2)
        same = (ends[order[:, 0], 0] == ends[order[:, 1], 0])
        f, g = self.face[owner[order[:, 0]]], self.face[owner[order[:, 1]]]
        links = {}
        for p, q, s in set(zip(f.tolist(), g.tolist(), same.tolist())):
            if p != q:
                links.setdefault(p, []).append((q, s))
                links.setdefault(q, []).append((p, s))
        turn, shell = {}, {}
        for seed in self.faces:
            if seed in turn:
                continue
            turn[seed], shell[seed], todo = False, seed, [seed]
            while todo:
                p = todo.pop()
                for q, s in links.get(p, []):
                    if q not in turn:
                        turn[q], shell[q] = turn[p] ^ s, seed
                        todo.append(q)
        flip = np.array([turn[t] for t in self.face])
        self.tri[flip] = self.tri[flip][:, ::-1]
        part = np.array([shell[t] for t in self.face])
        a, b, c = (self.X[self.tri[:, i]] for i in range(3))
        six = np.sum(a * np.cross(b, c), axis=1)
        volume = {s: six[part == s].sum() / 6 for s in np.unique(part)}
        for solid in volumes:
            own = {shell[t] for _, t in gmsh.model.getBoundary([(3, solid)], oriented=False)}
            outer = max(own, key=lambda s: abs(volume[s]))
            for s in own:
                if (volume[s] < 0) != (s != outer):  # a void's shell looks into the void
                    self.tri[part == s] = self.tri[part == s][:, ::-1]

    def first_hit(self, p, d, reach):
        """distance and triangle (-1: none) where rays from p along unit d first meet the boundary within reach; where two solids touch the
        face by which the ray leaves the one, not that by which it enters the other"""
        touch = 1e-6 * self.thickest
        best, hit = np.full(len(p), np.inf), np.full(len(p), -1)
        for lo in range(0, len(p), 1000):
            near = self.tree.query_ball_point(p[lo:lo + 1000], reach + self.reach)
            n = np.array([len(k) for k in near])
            if not n.sum():
                continue
            ray = np.repeat(np.arange(lo, lo + len(n)), n)
            tri = np.concatenate([np.array(k, int) for k in near if k])
            w = self.centre[tri] - p[ray]
            along = np.sum(w * d[ray], axis=1)
            close = (np.sum(w * w, axis=1) - along**2 <= self.reach**2) & (along >= -self.reach)
            ray, tri = ray[close], tri[close]
            a, b, c = (self.X[self.tri[tri, i]] for i in range(3))
            e1, e2 = b - a, c - a
            h = np.cross(d[ray], e2)
            det = np.sum(e1 * h, axis=1)
            with np.errstate(divide="ignore", invalid="ignore"):  # a ray in the triangle's plane misses it
                s = p[ray] - a
                u = np.sum(s * h, axis=1) / det
                q = np.cross(s, e1)
                v = np.sum(d[ray] * q, axis=1) / det
                t = np.sum(e2 * q, axis=1) / det
                slack = 1e-9  # of a triangle's size, so that no ray slips between two neighbours
                ok = (u >= -slack) & (v >= -slack) & (u + v <= 1 + slack) & (t >= 0) & (t <= reach)
            ray, tri, t = ray[ok], tri[ok], t[ok]
            enters = np.sum(self.normal[tri] * d[ray], axis=1) < 0
            first = np.lexsort((tri, t + np.where(enters, touch, 0), ray))
            ray, tri, t = ray[first], tri[first], t[first]
            keep = np.r_[True, ray[1:] != ray[:-1]] if len(ray) else np.zeros(0, bool)
            best[ray[keep]], hit[ray[keep]] = t[keep], tri[keep]
        return best, hit

    def onto(self, tri, p):
        """nearest points to p on the exact surfaces of the faces of triangles tri, and their normals (turned as the triangle's)"""
        q, n = np.array(p), self.normal[tri].copy()
        for t in np.unique(self.face[tri]):
            i = np.where(self.face[tri] == t)[0]
            c, uv = gmsh.model.getClosestPoint(2, int(t), p[i].ravel())
            q[i] = np.asarray(c).reshape(-1, 3)
            m = np.asarray(gmsh.model.getNormal(int(t), uv)).reshape(-1, 3)
            side = np.sum(m * n[i], axis=1)
            good = np.abs(side) > 0.5  # a pole has no normal: keep the triangle's
            n[i[good]] = (m * np.sign(side)[:, None])[good]
        return q, n

    def sample(self, rng, n):
        """n random triangles by area and a point on each"""
        return _scatter(rng, self.X, self.tri, self.area, n)

    def walls(self, rng, n):
        """n random boundary points: their triangle; whether a wall begins there; its mid-point and thickness where one does"""
        k, p = self.sample(rng, n)
        start = 1e-6 * self.thickest
        d, hit = self.first_hit(p - start * self.normal[k], -self.normal[k], 1.6 * self.thickest)
        wall = hit >= 0
        mid, t = np.full((n, 3), np.nan), np.full(n, np.nan)
        q, m = self.onto(k[wall], p[wall])
        foot, opposite = self.onto(hit[wall], q - m * (d[wall] + start)[:, None])
        t[wall] = np.linalg.norm(foot - q, axis=1)
        mid[wall] = q - m * (t[wall] / 2)[:, None]
        wall[np.where(wall)[0][np.sum(m * opposite, axis=1) > -WALL_COS]] = False
        return k, p, wall, mid, t


def _scatter(rng, X, tri, area, n):
    k = rng.choice(len(tri), n, p=area / area.sum())
    u, v = rng.random(n), rng.random(n)
    over = u + v > 1
    u[over], v[over] = 1 - u[over], 1 - v[over]
    a, b, c = (X[tri[k, i]] for i in range(3))
    return k, a + u[:, None] * (b - a) + v[:, None] * (c - a)


def distance_to_triangles(p, limit, X, tri):
    """distance from each p to the nearest of the triangles; inf where it is greater than the point's limit"""
    a, b, c = (X[tri[:, i]] for i in range(3))
    centre = (a + b + c) / 3
    radius = float(np.linalg.norm(np.stack([a, b, c]) - centre, axis=2).max())
    near = cKDTree(centre).query_ball_point(p, limit + radius)
    n = np.array([len(k) for k in near])
    out = np.full(len(p), np.inf)
    if not n.sum():
        return out
    who = np.repeat(np.arange(len(p)), n)
    k = np.concatenate([np.array(x, int) for x in near if x])
    a, b, c, q = a[k], b[k], c[k], p[who]
    cross = np.cross(b - a, c - a)
    unit = cross / np.maximum(np.linalg.norm(cross, axis=1), np.finfo(float).tiny)[:, None]
    inside = np.ones(len(k), bool)
    best = np.full(len(k), np.inf)
    for s, e in ((a, b), (b, c), (c, a)):
        inside &= np.sum(np.cross(e - s, q - s) * unit, axis=1) >= 0
        f = np.clip(np.sum((q - s) * (e - s), axis=1) / np.maximum(np.sum((e - s) ** 2, axis=1), np.finfo(float).tiny), 0, 1)
        best = np.minimum(best, np.linalg.norm(q - s - f[:, None] * (e - s), axis=1))
    best = np.where(inside, np.abs(np.sum((q - a) * unit, axis=1)), best)
    np.minimum.at(out, who, best)
    return np.where(out <= limit, out, np.inf)
