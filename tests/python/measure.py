#!/usr/bin/env python3
"""Measures a shell mesh against the solid that it stands for, with none of the product's code.

    measure.py solid part.step                           facts of the solid alone
    measure.py mesh part.step mesh.vtu [--thickest T] [--scale F]

--thickest: greatest wall thickness, mm (else three times twice volume over surface). --scale: multiplies the mesh first, so
that the mesh of a scaled part can be measured against the part. One JSON object on standard output:

euler, pieces, sheets, junction_curves, crease_curves   of the mesh; sheets are told apart by junctions and creases
sheet_labels, labels_astray  values of the cell array `sheet`; those that reach over several sheets
area, edge_ratio, flipped    total area; greatest longest edge over shortest; elements folded or turned against a neighbour
r50, r95, r99, samples       R-error |d1 - d2| / (d1 + d2) at random points of the mesh at least 1.5 thicknesses away from junctions
                             and creases, d1 and d2 the distances to the exact faces on either side; outside the solid it counts 1
t95, t_area                  the same points' relative thickness error, but those from where the nearest points of both sides lie the same way: before
                             the crest of a full rounding a wall's thickness is that of no ball between two sides, and carrying its sides
                             on, the distance to the rounding and the chord through it are three answers; area by cell thickness:
                             [[thickness, area], ...]
cover                        share of the wall area of the solid whose mid-point is within a quarter thickness of the mesh
free_off, free_length        length of free edges further than a fifth of the thickness from the solid's surface, and of all: a rim lies on
                             a lateral face, a seam torn open half a thickness deep (one on a wall's side fails by R-error and cover)
"""
import argparse
import json

import numpy as np
from scipy.spatial import cKDTree

import measure_mesh
from measure_solid import Solid, _scatter, distance_to_triangles

SAMPLES = 3600  # of which at least 2000 are left away from junctions on every fixture
SEED = 20240607


def geometry(solid, mesh, rng):
    """R-error and thickness at random points of the mesh"""
    k, p = _scatter(rng, mesh.P, mesh.T, mesh.area, SAMPLES)
    away = np.ones(len(p), bool)
    special = np.r_[mesh.junction, mesh.crease, mesh.folded]
    if len(special):
        parts = 8
        points, t = mesh.along(special, parts), np.repeat(mesh.thick_at(special), parts + 1)
        # few distinct thicknesses: one tree each
        for value in np.unique(np.round(t, 6)):
            away &= cKDTree(points[np.abs(t - value) < 1e-6]).query(p)[0] > 1.5 * value
    k, p = k[away], p[away]
    n, e = mesh.normal[k], mesh.element[k]
    reach = 1.6 * solid.thickest
    side, ways = [], []
    inside = np.ones(len(p), bool)
    for d in (n, -n):
        t, hit = solid.first_hit(p, d, reach)
        leaves = np.zeros(len(p), bool)
        got = hit >= 0
        leaves[got] = np.sum(solid.normal[hit[got]] * d[got], axis=1) > 0
        inside &= leaves
        far = np.full(len(p), np.nan)
        foot, _ = solid.onto(hit[leaves], p[leaves])
        way = np.zeros((len(p), 3))
        way[leaves] = foot - p[leaves]
        far[leaves] = np.linalg.norm(way[leaves], axis=1)
        side.append(far)
        ways.append(way)
    whole = side[0] + side[1]
    r = np.where(inside, np.abs(side[0] - side[1]) / whole, 1.0)
    # a node on a junction has a thickness for every sheet: only there take the element's own
    touched = np.zeros(len(mesh.P), bool)
    touched[mesh.edges[special].ravel()] = True
    own = touched[mesh.T[k]].any(axis=1)
    t = np.where(own, mesh.t_element[e], _interpolate(mesh, k, p))
    wrong = np.where(inside, np.abs(t - whole) / whole, 1.0)
    # what is outside the solid has no ways, and counts
    wrong = wrong[np.sum(ways[0] * ways[1], axis=1) <= 0]
    q = lambda v, x: float(np.percentile(v, x)) if len(v) else 1.0
    return dict(samples=len(p), r50=q(r, 50), r95=q(r, 95), r99=q(r, 99), t95=q(wrong, 95))


def _interpolate(mesh, k, p):
    a, b, c = (mesh.P[mesh.T[k, i]] for i in range(3))
    n = mesh.normal[k] / np.maximum(2 * mesh.area[k], np.finfo(float).tiny)[:, None]
    u = np.sum(np.cross(c - b, p - b) * n, axis=1)
    v = np.sum(np.cross(a - c, p - c) * n, axis=1)
    t = mesh.t_point[mesh.T[k]]
    return u * t[:, 0] + v * t[:, 1] + (1 - u - v) * t[:, 2]


def walls(solid, mesh, rng):
    """coverage of the walls, and free edges that lie on no lateral face"""
    k, p, wall, mid, t = solid.walls(rng, 2 * SAMPLES)
    limit = 0.25 * t[wall]  # a wall that was lost is half a thickness away at least
    d = distance_to_triangles(mid[wall], limit, mesh.P, mesh.T)
    out = dict(cover=float(np.isfinite(d).mean()) if wall.any() else 0.0, wall_share=float(wall.mean()))
    length = np.linalg.norm(mesh.P[mesh.edges[mesh.free, 0]] - mesh.P[mesh.edges[mesh.free, 1]], axis=1)
    off = 0.0
    if len(mesh.free):
        parts = 4
        points = mesh.along(mesh.free, parts)
        # where a wall ends in an edge its thickness goes to nothing, but not the chord errors of the solid's tessellation: 10 degrees and
        # `thickest` at most
        chord = (1 - np.cos(np.radians(5))) / np.radians(10) * solid.thickest
        limit = np.repeat(np.maximum(0.2 * mesh.thick_at(mesh.free), chord), parts + 1)
        far = ~np.isfinite(distance_to_triangles(points, limit, solid.X, solid.tri))
        # where a blind rib dives into the plate its rim leaves the rib's end face: half the plate's thickness deep, or a little
        # more under a fillet
        at, t = mesh.junction_ends()
        for p, r in zip(at, t):
            far &= np.linalg.norm(points - p, axis=1) > 0.75 * r
        off = float((length * far.reshape(-1, parts + 1).mean(axis=1)).sum())
    out.update(free_length=float(length.sum()), free_off=off)
    return out


def measure(step, vtu, thickest=None, scale=1.0):
    solid, mesh = Solid(step, thickest), measure_mesh.load(vtu, scale)
    out = mesh.report()
    rng = np.random.default_rng(SEED)
    out.update(geometry(solid, mesh, rng))
    out.update(walls(solid, mesh, rng))
    value, index = np.unique(np.round(mesh.t_element / solid.thickest, 6), return_inverse=True)
    area = np.bincount(index.ravel(), mesh.element_area)
    out["t_area"] = [[float(v * solid.thickest), float(a)] for v, a in zip(value, area)]
    return out


def facts(step):
    s = Solid(step)
    return dict(solids=s.solids, volume=s.volume, euler=s.euler, closed=s.closed, faces=len(s.faces), loose=s.loose)


def main():
    top = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    verbs = top.add_subparsers(dest="verb", required=True)
    verbs.add_parser("solid").add_argument("step")
    m = verbs.add_parser("mesh")
    m.add_argument("step")
    m.add_argument("vtu")
    m.add_argument("--thickest", type=float)
    m.add_argument("--scale", type=float, default=1.0)
    a = top.parse_args()
    print(json.dumps(facts(a.step) if a.verb == "solid" else measure(a.step, a.vtu, a.thickest, a.scale)))


if __name__ == "__main__":
    main()
