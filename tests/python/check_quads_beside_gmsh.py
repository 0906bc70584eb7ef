"""Checks tools/quads_beside_gmsh.py and what it gives to Gmsh, on mid-surfaces made by hand. Run by tests/beside_gmsh.rs; needs gmsh and numpy, no binary of ours."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

TOOLS = Path(__file__).resolve().parent.parent.parent / "tools"
sys.path.insert(0, str(TOOLS))
import measure_vtu  # noqa: E402
import mid_surface_in_gmsh as discrete  # noqa: E402
import quads_beside_gmsh as beside  # noqa: E402


def grid(origin, u, v, nu, nv):
    """corners of the triangles of a parallelogram, #T by 3 by 3"""
    origin, u, v = (np.array(x, float) for x in (origin, u, v))
    at = lambda i, j: origin + u * i / nu + v * j / nv
    square = lambda i, j: [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    return np.array([t for i in range(nu) for j in range(nv) for t in square(i, j)])


def welded(*patches):
    """points, triangles, and the number of the patch of each"""
    corners = np.concatenate(patches)
    points, tris = np.unique(corners.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    return points, tris.reshape(-1, 3), np.repeat(np.arange(len(patches)), [len(p) for p in patches])


def ball(n):
    """a sphere of radius 10 of the triangles of an octahedron's faces, divided n times a side"""
    faces = []
    for x in (-1, 1):
        for y in (-1, 1):
            for z in (-1, 1):
                a, b, c = np.diag([x, y, z]).astype(float)
                at = lambda i, j: a * (n - i - j) / n + b * i / n + c * j / n
                faces += [[at(i, j), at(i + 1, j), at(i, j + 1)] for i in range(n) for j in range(n - i)]
                faces += [[at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for i in range(n - 1) for j in range(n - 1 - i)]
    corners = np.array(faces)
    return corners * 10 / np.linalg.norm(corners, axis=2)[:, :, None]


class Geometry(unittest.TestCase):
    def meshed(self, patches, size, sheet=None, recombination=1):
        """(faces, curves) and the mesh that Gmsh makes"""
        points, tris, number = welded(*patches)
        with tempfile.TemporaryDirectory() as folder:
            path, out = str(Path(folder) / "part.msh"), str(Path(folder) / "out.vtu")
            made = discrete.write(path, points, tris, number if sheet is None else np.full(len(tris), sheet), size)
            job = dict(geometry=path, algorithm=9, recombination=recombination, size=size, scale=1, divisions=[], out=out)
            found, why, _ = beside.attempt(job, folder, 60)
            self.assertIsNone(why)
            return made, found, measure_vtu.read(out)

    def test_a_rib_that_ends_within_its_plate_stays_on_it(self):
        patches = grid((0, 0, 0), (40, 0, 0), (0, 20, 0), 20, 10), grid((10, 10, 0), (20, 0, 0), (0, 0, 10), 10, 5)
        (faces, _), _, mesh = self.meshed(patches, 4)
        self.assertEqual(faces, 2)
        every = np.sort(np.concatenate([np.stack([c, np.roll(c, -1, axis=1)], axis=2).reshape(-1, 2) for c in (mesh.tris, mesh.quads)]), axis=1)
        edges, count = np.unique(every, axis=0, return_counts=True)
        ends = mesh.points[edges[count == 3]]
        self.assertAlmostEqual(np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum(), 20, 6)
        self.assertEqual(count.max(), 3)

    def test_creases_are_curves_and_square_faces_get_squares(self):
        floor = grid((0, 0, 0), (20, 0, 0), (0, 20, 0), 5, 5)
        walls = [grid(o, u, (0, 0, 20), 5, 5) for o, u in (((0, 0, 0), (20, 0, 0)), ((20, 0, 0), (0, 20, 0)), ((20, 20, 0), (-20, 0, 0)), ((0, 20, 0), (0, -20, 0)))]
        made, (quads, triangles, least, mean, _), _ = self.meshed((floor, *walls), 5, sheet=0)
        self.assertEqual(made, (5, 12))
        self.assertEqual((quads, triangles), (80, 0))
        self.assertGreater(least, 0.999)

    def test_what_is_closed_is_halved(self):
        (faces, _), _, _ = self.meshed((ball(8),), 3)
        self.assertGreater(faces, 1)

    def test_a_strip_that_meets_itself_is_parted(self):
        ring = [np.array([10 * np.cos(a), 10 * np.sin(a), 0]) for a in np.linspace(0, 2 * np.pi, 24, endpoint=False)]
        bands = [grid(a, b - a, (0, 0, 8), 1, 4) for a, b in zip(ring, [*ring[1:], ring[0]])]
        tail = grid(ring[0], (10, 0, 0), (0, 0, 8), 5, 4)
        (faces, _), _, _ = self.meshed((*bands, tail), 2, sheet=0)
        self.assertGreater(faces, 1)


class Measures(unittest.TestCase):
    def test_scaled_jacobians_are_those_of_verdict(self):
        square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        slanted = [(0, 0, 0), (1, 0, 0), (1.5, np.sqrt(0.75), 0), (0.5, np.sqrt(0.75), 0)]
        caved = [(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)]
        flat = [(0, 0, 0), (0, 0, 0), (1, 1, 0), (0, 1, 0)]
        found = discrete.jacobians(np.array([square, slanted, caved, caved[::-1], flat], float))
        np.testing.assert_allclose(found, [1, np.sqrt(0.75), -0.8, -0.8, 0], atol=1e-12)

    def test_the_best_way_has_convex_quads_where_any_has(self):
        ways = {"caved": (9, 0, -0.1, 0.99, 1), "poor": (9, 0, 0.01, 0.7, 1), "good": (9, 0, 0.5, 0.8, 1)}
        self.assertEqual(beside.best_of(ways), "good")
        self.assertEqual(beside.best_of({k: ways[k] for k in ("caved", "poor")}), "poor")

    def test_one_size_gives_as_many_squares(self):
        points = np.array([(x, y, 0) for y in range(4) for x in range(5)], float) * 3
        quads = np.array([(5 * y + x, 5 * y + x + 1, 5 * y + x + 6, 5 * y + x + 5) for y in range(3) for x in range(4)])
        grid = measure_vtu.Grid(points, list(quads), {}, {})
        at, even = beside.sizes_of(grid)
        np.testing.assert_allclose(at, 3)
        self.assertAlmostEqual(even, 3)

    def test_what_takes_too_long_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(beside.attempt({}, folder, 0.01)[1], "out of time")

    def test_a_geometry_that_is_missing_is_told(self):
        with tempfile.TemporaryDirectory() as folder:
            job = dict(geometry=str(Path(folder) / "none.msh"), algorithm=9, recombination=1, size=1, scale=1, divisions=[])
            self.assertRegex(beside.attempt(job, folder, 60)[1], "^(refused|crashed)")


class Usage(unittest.TestCase):
    def refused(self, *arguments):
        run = subprocess.run([sys.executable, str(TOOLS / "quads_beside_gmsh.py"), *map(str, arguments)], capture_output=True, text=True, timeout=60)
        self.assertEqual(run.returncode, 2, run.stderr)
        return run.stderr

    def test_what_is_missing_is_named(self):
        here = Path(__file__)
        self.assertIn("no such part: none.step", self.refused("--parts", "none.step"))
        self.assertIn("no binary at /none", self.refused("--midshell", "/none", "--parts", here))
        self.assertIn("no fixture none", self.refused("none"))
        self.assertIn("has no markers for quad parts", self.refused("--midshell", sys.executable, "--page", here, "--parts", here))
        self.assertIn("not both", self.refused("slots", "--parts", here))


if __name__ == "__main__":
    unittest.main(warnings="ignore")
