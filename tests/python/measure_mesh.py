"""A shell mesh seen as a cell complex: what it is made of and how good its elements are. It knows nothing of the solid."""
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import measure_vtu

# Angle between the normals of two neighbours. Elements on the fixtures' bends turn by at most 15 degrees each, the flattest
# crease of a fixture by 60; beyond 150 an element lies folded back on its neighbour.
CREASE_DEG, FOLDED_DEG = 40.0, 150.0


class Mesh:
    """Triangles and quads with their edges, after points that no element uses are dropped.

    T (n,3): triangles that cover all elements, element[k] the element of triangle k. Elements: triangles, then quads."""

    def __init__(self, grid, scale=1.0):
        used = np.unique(np.r_[grid.tris.ravel(), grid.quads.ravel()])
        if not len(used):
            raise ValueError("the mesh has no element")
        new = np.full(len(grid.points), -1)
        new[used] = np.arange(len(used))
        self.unused = len(grid.points) - len(used)
        self.P = grid.points[used] * scale
        tris, quads = new[grid.tris], new[grid.quads]
        self.loops = [tris, quads]
        self.count = len(tris) + len(quads)
        order = np.r_[grid.tri_cells, grid.quad_cells]
        self.t_element = np.asarray(grid.cell_data["thickness"], float)[order] * scale
        self.t_point = np.asarray(grid.point_data["thickness"], float)[used] * scale
        self.label = np.asarray(grid.cell_data["sheet"]).astype(int)[order]
        e = np.arange(len(tris), self.count)
        self.T = np.vstack([tris, quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        self.element = np.r_[np.arange(len(tris)), e, e]
        a, b, c = (self.P[self.T[:, i]] for i in range(3))
        cross = np.cross(b - a, c - a)
        self.area = np.linalg.norm(cross, axis=1) / 2
        self.normal = cross / np.maximum(2 * self.area, np.finfo(float).tiny)[:, None]
        total = np.zeros((self.count, 3))
        np.add.at(total, self.element, cross)
        self.element_area = np.linalg.norm(total, axis=1) / 2
        self.element_normal = total / np.maximum(np.linalg.norm(total, axis=1), np.finfo(float).tiny)[:, None]
        self._edges()
        self._classify()

    def _edges(self):
        ends, owner = [], []
        first = 0
        for loop in self.loops:
            k = loop.shape[1]
            for i in range(k):
                ends.append(loop[:, [i, (i + 1) % k]])
                owner.append(first + np.arange(len(loop)))
            first += len(loop)
        ends, self.owner = np.vstack(ends), np.concatenate(owner)
        self.forward = ends[:, 0] < ends[:, 1]
        self.edges, self.edge_of, self.uses = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
        self.edge_of = self.edge_of.ravel()
        by_edge = np.argsort(self.edge_of, kind="stable")
        self.first_use = np.r_[0, np.cumsum(self.uses)]
        self.by_edge = by_edge

    def _classify(self):
        """edges: free, smooth, crease, folded, junction"""
        two = np.where(self.uses == 2)[0]
        u, v = self.by_edge[self.first_use[two]], self.by_edge[self.first_use[two] + 1]
        a, b = self.owner[u], self.owner[v]
        # run the same way along the edge, two elements have opposite orientations
        sign = np.where(self.forward[u] != self.forward[v], 1.0, -1.0)
        angle = np.degrees(np.arccos(np.clip(sign * np.sum(self.element_normal[a] * self.element_normal[b], axis=1), -1, 1)))
        smooth = angle <= CREASE_DEG
        folded = angle > FOLDED_DEG
        self.crease = two[~smooth & ~folded]
        self.folded = two[folded]
        self.junction = np.where(self.uses > 2)[0]
        self.free = np.where(self.uses == 1)[0]
        flat = smooth | folded
        graph = coo_matrix((np.ones(flat.sum()), (a[flat], b[flat])), shape=(self.count,) * 2)
        self.sheets, self.sheet = connected_components(graph, directed=False)
        self.turned = int((sign[flat] < 0).sum())
        incidence = coo_matrix((np.ones(len(self.owner)), (self.owner, self.edge_of)), shape=(self.count, len(self.edges))).tocsr()
        self.pieces = connected_components(incidence @ incidence.T, directed=False)[0]

    def euler(self):
        return len(self.P) - len(self.edges) + self.count

    def chains(self, edge_ids):
        """number of maximal chains of the given edges between points where other than two of them meet; a closed one counts 1"""
        e = self.edges[edge_ids]
        if not len(e):
            return 0
        degree = np.bincount(e.ravel(), minlength=len(self.P))
        ends = np.where(degree == 2, np.arange(len(self.P)), -1)
        # every edge gets a private copy of an end point that closes a chain
        copies = e.copy()
        fresh = len(self.P)
        for i, j in zip(*np.where(ends[e] < 0)):
            copies[i, j] = fresh
            fresh += 1
        n, part = connected_components(coo_matrix((np.ones(len(e)), copies.T), shape=(fresh,) * 2), directed=False)
        return len(np.unique(part[copies.ravel()]))

    def thick_at(self, edge_ids):
        """the greatest thickness of the elements at each of the edges"""
        t = np.zeros(len(self.edges))
        np.maximum.at(t, self.edge_of, self.t_element[self.owner])
        return t[edge_ids]

    def junction_ends(self):
        """points where a junction ends within a sheet, and the greatest thickness there"""
        e = self.edges[self.junction]
        degree = np.bincount(e.ravel(), minlength=len(self.P))
        t = np.zeros(len(self.P))
        np.maximum.at(t, e, self.thick_at(self.junction)[:, None])
        ends = np.where(degree == 1)[0]
        return self.P[ends], t[ends]

    def along(self, edge_ids, parts):
        """points along the edges, the ends among them: (edges * (parts + 1), 3)"""
        a, b = self.P[self.edges[edge_ids, 0]], self.P[self.edges[edge_ids, 1]]
        f = np.linspace(0, 1, parts + 1)[None, :, None]
        return (a[:, None] * (1 - f) + b[:, None] * f).reshape(-1, 3)

    def edge_ratio(self):
        """greatest of longest edge over shortest, over all elements"""
        length = np.linalg.norm(self.P[self.edges[:, 0]] - self.P[self.edges[:, 1]], axis=1)[self.edge_of]
        low, high = np.full(self.count, np.inf), np.zeros(self.count)
        np.minimum.at(low, self.owner, length)
        np.maximum.at(high, self.owner, length)
        return float((high / np.maximum(low, np.finfo(float).tiny)).max())

    def corner_turned(self):
        """quads that are not convex as seen along their normal"""
        q = self.loops[1]
        if not len(q):
            return 0
        n = self.element_normal[len(self.loops[0]):]
        bad = np.zeros(len(q), bool)
        for i in range(4):
            p, o, s = (self.P[q[:, k % 4]] for k in (i + 3, i, i + 1))
            bad |= np.sum(np.cross(s - o, p - o) * n, axis=1) <= 0
        return int(bad.sum())

    def labels(self):
        """number of sheet labels, and of labels that reach over more than one sheet"""
        pairs = np.unique(np.c_[self.label, self.sheet], axis=0)
        names, n = np.unique(pairs[:, 0], return_counts=True)
        return len(names), int((n > 1).sum())

    def report(self):
        names, astray = self.labels()
        return dict(nodes=len(self.P), elements=self.count, unused_points=self.unused, euler=int(self.euler()), pieces=int(self.pieces),
                    sheets=int(self.sheets), sheet_labels=names, labels_astray=astray, junction_curves=self.chains(self.junction),
                    crease_curves=self.chains(self.crease), area=float(self.area.sum()), edge_ratio=self.edge_ratio(),
                    flipped=int(len(self.folded)) + self.turned + self.corner_turned())


def load(path, scale=1.0):
    return Mesh(measure_vtu.read(path), scale)
