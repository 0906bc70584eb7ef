"""Element metrics as Verdict computes them, through VTK: the judge of src/geom/quality.

    verdict.py SEED COUNT FOLDER

Writes FOLDER/random.vtu, COUNT random triangles and COUNT random convex quads each with nodes of its own, and prints one JSON object: for each of our metrics
that Verdict has with the same definition the values of all cells, null where the metric is of the other shape. Through pyvista's cell_quality where it
knows the measure, else through vtkMeshQuality.
"""

import json
import sys

import numpy as np
import pyvista
import vtk

import measure_vtu

# Our name: Verdict's, by shape.
TRIANGLE = {"scaled_jacobian": "scaled_jacobian", "aspect_ratio": "aspect_ratio", "radius_ratio": "radius_ratio",
            "min_angle_deg": "min_angle", "max_angle_deg": "max_angle", "area": "area"}
QUAD = {"scaled_jacobian": "scaled_jacobian", "aspect_ratio": "aspect_ratio", "skew": "skew", "taper": "taper",
        "warpage": "warpage", "shape": "shape", "condition": "condition", "min_angle_deg": "min_angle",
        "max_angle_deg": "max_angle", "area": "area"}
# Those that pyvista has no name for.
DIRECT = {"edge_ratio": ("SetTriangleQualityMeasureToEdgeRatio", "SetQuadQualityMeasureToEdgeRatio"),
          "equiangle_skew": (None, "SetQuadQualityMeasureToEquiangleSkew")}


def convex(p):
    """whether every corner of the quad turns the same way, seen along its mean normal, by more than rounding"""
    n = np.cross(p[2] - p[0], p[3] - p[1])
    n /= np.linalg.norm(n)
    return all(np.dot(np.cross(p[k] - p[k - 1], p[(k + 1) % 4] - p[k]), n) > 0.02 for k in range(4))


def shapes(seed, count):
    rng = np.random.default_rng(seed)
    triangles, quads = [], []
    while len(triangles) < count:
        p = rng.normal(size=(3, 3))
        if np.linalg.norm(np.cross(p[1] - p[0], p[2] - p[0])) > 0.05:
            triangles.append(p)
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    while len(quads) < count:
        p = square * [rng.uniform(0.3, 3), 1, 1] + rng.normal(scale=0.25, size=(4, 3))
        if convex(p):
            turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            quads.append(p @ turn * rng.uniform(0.1, 10))
    return triangles, quads


def main(seed, count, folder):
    triangles, quads = shapes(seed, count)
    points = np.vstack(triangles + quads)
    cells, at = [], 0
    for p in triangles + quads:
        cells.append(list(range(at, at + len(p))))
        at += len(p)
    path = f"{folder}/random.vtu"
    measure_vtu.write(path, points, cells, {}, {})
    grid = pyvista.read(path)
    n, m = len(triangles), len(quads)
    answer = {}
    for ours in dict.fromkeys([*TRIANGLE, *QUAD]):
        values = [None] * (n + m)
        for names, part in ((TRIANGLE, range(n)), (QUAD, range(n, n + m))):
            if ours in names:
                of = grid.cell_quality(names[ours]).cell_data[names[ours]]
                for k in part:
                    values[k] = float(of[k])
        answer[ours] = values
    for ours, (triangle, quad) in DIRECT.items():
        judge = vtk.vtkMeshQuality()
        judge.SetInputData(grid)
        values = [None] * (n + m)
        for setter, part in ((triangle, range(n)), (quad, range(n, n + m))):
            if setter is None:
                continue
            getattr(judge, setter)()
            judge.Update()
            of = judge.GetOutput().GetCellData().GetArray("Quality")
            for k in part:
                values[k] = of.GetValue(k)
        answer[ours] = values
    print("\n" + json.dumps(answer))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3])
