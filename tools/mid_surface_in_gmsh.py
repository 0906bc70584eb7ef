#!/usr/bin/env python3
"""The mid-surface of a part as discrete geometry of Gmsh: faces, curves and points made of triangles.

    mid_surface_in_gmsh.py JOB.json

A job is one attempt to mesh it (see `attempt`); it runs in a process of its own because Gmsh may hang or crash on discrete geometry, and prints one line of JSON.
tools/quads_beside_gmsh.py makes the geometry (`write`) and starts the jobs.

The triangles are midshell's, finer than the mesh that is wanted. A face ends where a sheet does: at rims, junctions and steps, and at creases within a sheet. Faces that Gmsh could
not lay flat (closed, with handles, meeting themselves, deep for their outline) are halved until it can. Curves end where more or fewer than two meet, and at corners. Nodes are shared, so that junctions stay whole.
"""
import heapq
import json
import sys
import time
from pathlib import Path

import gmsh
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests/python"))
import measure_vtu  # noqa: E402

# Degrees. The triangles turn by ten at most from one to the next along a bend, or along a round rim.
CREASE = CORNER = 40
# Chains of creases and faces that are smaller than this many edge lengths are noise.
LEAST = 3
# A face is laid flat onto a disk: what lies further inside than half its outline shrinks to less than a twentieth.
DEPTH = 0.5


def jacobians(p):
    """#Q least scaled Jacobians of quads with corners p, #Q by 4 by 3, as Verdict has them; 0 where a side has no length"""
    edge = np.roll(p, -1, axis=1) - p
    length = np.linalg.norm(edge, axis=2)
    corner = np.cross(np.roll(edge, 1, axis=1), edge)
    centre = np.cross(edge[:, 0] - edge[:, 2], edge[:, 1] - edge[:, 3])
    with np.errstate(divide="ignore", invalid="ignore"):
        centre /= np.linalg.norm(centre, axis=1)[:, None]
        found = (np.einsum("qkc,qc->qk", corner, centre) / (np.roll(length, 1, axis=1) * length)).min(axis=1)
    return np.nan_to_num(found, nan=0.0)


def areas(points, tris, quads):
    """of triangles, then of quads"""
    half = lambda a, b, c: np.linalg.norm(np.cross(points[b] - points[a], points[c] - points[a]), axis=1) / 2
    return half(*tris.T), half(*quads[:, :3].T) + half(*quads[:, [0, 2, 3]].T)


class Sides:
    """The edges of triangles: ends (#E by 2, sorted), and the triangles at each, `of[e]`"""

    def __init__(self, tris):
        every = np.concatenate([tris[:, [0, 1]], tris[:, [1, 2]], tris[:, [2, 0]]])
        self.ends, number, self.count = np.unique(np.sort(every, axis=1), axis=0, return_inverse=True, return_counts=True)
        number = number.ravel()
        order = np.argsort(number, kind="stable")
        owner = np.tile(np.arange(len(tris)), 3)[order]
        self.of = np.split(owner, np.cumsum(self.count)[:-1])
        self.two = np.flatnonzero(self.count == 2)
        first = np.r_[0, np.cumsum(self.count)[:-1]][self.two]
        self.pair = np.stack([owner[first], owner[first + 1]], axis=1)


def groups(n, links):
    """numbers of the connected groups of n things"""
    up = np.arange(n)

    def root(i):
        while up[i] != i:
            up[i] = up[up[i]]
            i = up[i]
        return i

    for a, b in links:
        a, b = root(a), root(b)
        up[max(a, b)] = min(a, b)
    return np.unique([root(i) for i in range(n)], return_inverse=True)[1] if n else np.zeros(0, int)


def faces_of(points, tris, sheet, size):
    """numbers of faces, one a triangle: sheets cut along their creases"""
    sides = Sides(tris)
    normal = np.cross(points[tris[:, 1]] - points[tris[:, 0]], points[tris[:, 2]] - points[tris[:, 0]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    a, b = sides.pair.T
    same = sheet[a] == sheet[b]
    sharp = same & (np.einsum("ij,ij->i", normal[a], normal[b]) < np.cos(np.radians(CREASE)))
    ends = sides.ends[sides.two]
    length = np.linalg.norm(points[ends[:, 0]] - points[ends[:, 1]], axis=1)
    # Chains that are long enough.
    chains = np.flatnonzero(sharp)
    at = {}
    for i, e in enumerate(chains):
        for v in ends[e]:
            at.setdefault(v, []).append(i)
    chain = groups(len(chains), [(l[0], j) for l in at.values() for j in l[1:]])
    long = np.bincount(chain, length[chains]) if len(chains) else np.zeros(0)
    sharp[chains[long[chain] < LEAST * size] if len(chains) else []] = False
    area, _ = areas(points, tris, np.zeros((0, 4), int))
    while True:
        face = groups(len(tris), sides.pair[same & ~sharp])
        # The creases round the smallest face that is noise are no creases, and neither are those that part nothing.
        sharp &= face[a] != face[b]
        share = np.bincount(face, area)
        border = np.zeros(len(share))
        np.add.at(border, face[a[sharp]], 1)
        np.add.at(border, face[b[sharp]], 1)
        small = [f for f in np.argsort(share) if share[f] < (LEAST * size) ** 2 and border[f]]
        if not small:
            return face
        round_it = sharp & ((face[a] == small[0]) | (face[b] == small[0]))
        other = np.where(face[a] == small[0], face[b], face[a])
        longest = np.argmax(np.bincount(other[round_it], length[round_it]))
        sharp[round_it & (other == longest)] = False


def flat_or_not(points, tris):
    """whether Gmsh can lay these triangles flat"""
    sides = Sides(tris)
    if sides.count.max() > 2 or sides.count.min() > 1:
        return False
    nodes, local = np.unique(tris, return_inverse=True)
    local = local.reshape(-1, 3)
    rim = sides.ends[sides.count == 1]
    # At each node of the rim two sides end; more where the face meets itself.
    if (np.bincount(rim.ravel())[np.unique(rim)] != 2).any():
        return False
    number = np.searchsorted(nodes, rim)
    used, inside = np.unique(number, return_inverse=True)
    loop = groups(len(used), inside.reshape(-1, 2))
    loops = loop.max() + 1
    if len(nodes) - len(sides.ends) + len(tris) != 2 - loops:
        return False
    at = loop[inside.reshape(-1, 2)[:, 0]]
    outline = np.bincount(at, np.linalg.norm(points[rim[:, 0]] - points[rim[:, 1]], axis=1))
    outer = nodes[used[loop == np.argmax(outline)]]
    return distance(points, sides, outer).max() <= DEPTH * outline.max()


def distance(points, sides, sources):
    """along edges, from the sources to each node that has a triangle"""
    beside = {}
    for (a, b), l in zip(sides.ends.tolist(), np.linalg.norm(points[sides.ends[:, 0]] - points[sides.ends[:, 1]], axis=1).tolist()):
        beside.setdefault(a, []).append((b, l))
        beside.setdefault(b, []).append((a, l))
    far = dict.fromkeys(beside, np.inf)
    heap = [(0.0, int(v)) for v in sources]
    far.update({v: d for d, v in heap})
    while heap:
        d, v = heapq.heappop(heap)
        if d > far[v]:
            continue
        for w, l in beside[v]:
            if d + l < far[w]:
                far[w] = d + l
                heapq.heappush(heap, (d + l, w))
    return np.array([far[v] for v in sorted(far)])


def halve(points, tris):
    """which of the triangles lie nearer to one end than to the other"""
    sides = Sides(tris)
    nodes = np.unique(tris)
    one = nodes[np.argmax(distance(points, sides, nodes[:1]))]
    from_one = distance(points, sides, [one])
    two = nodes[np.argmax(np.where(np.isfinite(from_one), from_one, -1))]
    nearer = from_one - distance(points, sides, [two])
    return nearer[np.searchsorted(nodes, tris)].mean(axis=1) < 0


def parted(points, tris, face):
    """faces that can be laid flat, and which faces they were"""
    out, parent = np.full(len(tris), -1), []
    todo = [(f, np.flatnonzero(face == f)) for f in range(face.max() + 1)]
    while todo:
        f, mine = todo.pop()
        if len(mine) > 1 and not flat_or_not(points, tris[mine]):
            nearer = halve(points, tris[mine])
            if nearer.any() and not nearer.all():
                for half in (mine[nearer], mine[~nearer]):
                    s = Sides(tris[half])
                    piece = groups(len(half), s.pair)
                    todo += [(f, half[piece == k]) for k in range(piece.max() + 1)]
                continue
        out[mine] = len(parent)
        parent.append(f)
    return out, np.array(parent)


def curves_of(points, tris, face, parent, size):
    """chains of nodes, each with the faces that it bounds"""
    sides = Sides(tris)
    at, kind = {}, {}
    for (a, b), of in zip(sides.ends.tolist(), sides.of):
        round_it = tuple(sorted(face[of].tolist()))
        if len(of) == 2 and round_it[0] == round_it[1]:
            continue
        at.setdefault(a, []).append(b)
        at.setdefault(b, []).append(a)
        kind[a, b] = kind[b, a] = round_it
    # Where a face was only halved, the curve between its halves zigzags and has no corners.
    seam = lambda a, b: len(kind[a, b]) == 2 and parent[kind[a, b][0]] == parent[kind[a, b][1]]
    def ahead(v, a):
        """where the curve that leaves v by a is after half a size, or where it ends before"""
        went, last = np.linalg.norm(points[a] - points[v]), v
        while went < size / 2 and len(at[a]) == 2 and a != v:
            last, a = a, at[a][0] if at[a][1] == last else at[a][1]
            went += np.linalg.norm(points[a] - points[last])
        return a

    def turn(v, a, b):
        """cosine of the angle by which the way over v from a to b turns"""
        u, w = points[v] - points[a], points[b] - points[v]
        return u @ w / max(np.linalg.norm(u) * np.linalg.norm(w), 1e-300)

    stops, corners = set(), []
    for v, beside in at.items():
        a, b = beside[0], beside[-1]
        if len(beside) != 2 or kind[a, v] != kind[v, b]:
            stops.add(v)
        elif not seam(a, v):
            # From near and from further off: small holes are round from near, and rough rims straight from afar.
            turns = turn(v, a, b), turn(v, ahead(v, a), ahead(v, b))
            if max(turns) < np.cos(np.radians(CORNER)):
                corners.append((sum(turns), v))
    # Of corners that are nearer to each other the sharper.
    taken = np.zeros((0, 3))
    for _, v in sorted(corners):
        if (np.linalg.norm(taken - points[v], axis=1) >= size / 2).all():
            stops.add(v)
            taken = np.vstack([taken, points[v]])
    curves, done = [], set()
    # From every end; then the closed ones, from any node.
    for start in [*sorted(stops), *sorted(at)]:
        for following in at[start]:
            if (start, following) in done:
                continue
            chain = [start, following]
            while chain[-1] not in stops and chain[-1] != start:
                a, b = at[chain[-1]]
                chain.append(b if a == chain[-2] else a)
            done.update(zip(chain, chain[1:]))
            done.update(zip(chain[1:], chain))
            curves.append((chain, kind[start, following]))
            stops.add(start)
    return curves


def write(path, points, tris, sheet, size):
    """the geometry as an MSH file; number of faces and of curves"""
    used, tris = np.unique(tris, return_inverse=True)
    points, tris = points[used], tris.reshape(-1, 3)
    face, parent = parted(points, tris, faces_of(points, tris, sheet, size))
    curves = curves_of(points, tris, face, parent, size)
    gmsh.initialize(["gmsh", "-nopopup"], interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.add("mid-surface")
        placed = np.zeros(len(points), bool)

        def place(dim, tag, nodes):
            nodes = np.unique([v for v in nodes if not placed[v]]).astype(int)
            placed[nodes] = True
            if len(nodes):
                gmsh.model.mesh.addNodes(dim, tag, nodes + 1, points[nodes].ravel())

        element = 1
        ends = {v: i + 1 for i, v in enumerate(sorted({v for chain, _ in curves for v in (chain[0], chain[-1])}))}
        for v, tag in ends.items():
            gmsh.model.addDiscreteEntity(0, tag)
            place(0, tag, [v])
            gmsh.model.mesh.addElementsByType(tag, 15, [element], [v + 1])
            element += 1
        bounds, inside = {}, {}
        for tag, (chain, of) in enumerate(curves, 1):
            gmsh.model.addDiscreteEntity(1, tag, [ends[chain[0]], ends[chain[-1]]])
            place(1, tag, chain)
            lines = np.stack([chain[:-1], chain[1:]], axis=1).ravel() + 1
            gmsh.model.mesh.addElementsByType(tag, 1, np.arange(element, element + len(chain) - 1), lines)
            element += len(chain) - 1
            for f in set(of):
                (bounds if of.count(f) == 1 else inside).setdefault(f, []).append(tag)
        for f in range(len(parent)):
            gmsh.model.addDiscreteEntity(2, f + 1, bounds.get(f, []))
            mine = tris[face == f]
            place(2, f + 1, mine.ravel())
            gmsh.model.mesh.addElementsByType(f + 1, 2, np.arange(element, element + len(mine)), mine.ravel() + 1)
            element += len(mine)
        for f, curves_inside in inside.items():
            gmsh.model.mesh.embed(1, curves_inside, 2, f + 1)
        gmsh.option.setNumber("Mesh.SaveAll", 1)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return len(parent), len(curves)


def attempt(job):
    """One way to mesh: `geometry` (MSH file), `algorithm`, `recombination`, `size` (edge length, or None for that of `sizes`, an NPZ file: triangles, and the sizes at their corners),
    `scale` (of either), `divisions` (number of sides by curve, where Gmsh may not choose it). Writes the mesh to `out`, if named. Numbers of quads and triangles, least and mean scaled Jacobian, seconds of meshing alone, share of the area that is meshed, faces left empty."""
    gmsh.initialize(["gmsh", "-nopopup"], interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    # Read from a file: of a model made through the interface Gmsh does not know the extent, and bounds all sizes by 1.
    gmsh.open(job["geometry"])
    whole = sum(a.sum() for a in areas(*mesh_in_gmsh()))
    gmsh.model.mesh.createGeometry()
    options = {"Algorithm": job["algorithm"], "RecombineAll": 1, "RecombinationAlgorithm": job["recombination"], "RandomSeed": 1}
    if job["size"] is None:
        sizes = np.load(job["sizes"])
        view = gmsh.view.add("size")
        rows = np.concatenate([sizes["corners"].transpose(0, 2, 1).reshape(-1, 9), job["scale"] * sizes["at"]], axis=1)
        gmsh.view.addListData(view, "ST", len(rows), rows.ravel())
        field = gmsh.model.mesh.field.add("PostView")
        gmsh.model.mesh.field.setNumber(field, "ViewTag", view)
        gmsh.model.mesh.field.setNumber(field, "UseClosest", 1)
        gmsh.model.mesh.field.setAsBackgroundMesh(field)
        # Inside faces algorithm 9 looks at the bounds alone.
        least, greatest = job["scale"] * sizes["at"].min(), job["scale"] * sizes["at"].max()
        options |= {"MeshSizeFromPoints": 0, "MeshSizeFromCurvature": 0, "MeshSizeExtendFromBoundary": 0, "MeshSizeMin": least, "MeshSizeMax": greatest}
    else:
        options |= dict.fromkeys(("MeshSizeMin", "MeshSizeMax"), job["scale"] * job["size"])
    for key, value in options.items():
        gmsh.option.setNumber("Mesh." + key, value)
    for curve, sides in job["divisions"]:
        gmsh.model.mesh.setTransfiniteCurve(curve, sides + 1)
    began = time.monotonic()
    try:
        gmsh.model.mesh.generate(2)
    except Exception as refusal:
        # Full quads want even numbers of sides, and Gmsh itself gives short curves three.
        sides = [(curve, len(gmsh.model.mesh.getElements(1, curve)[1][0])) for _, curve in gmsh.model.getEntities(1)]
        return {"refused": str(refusal), "odd": [(curve, max(n - 1, 2)) for curve, n in sides if n % 2]}
    seconds = time.monotonic() - began
    try:
        points, tris, quads = mesh_in_gmsh()
    except ValueError as broken:
        return {"incomplete": str(broken)}
    empty = sum(not len(gmsh.model.mesh.getElements(2, tag)[0]) for _, tag in gmsh.model.getEntities(2))
    if job.get("out"):
        measure_vtu.write(job["out"], points, [*tris, *quads], {}, {})
    worth = jacobians(points[quads]) if len(quads) else np.zeros(1)
    covered = sum(a.sum() for a in areas(points, tris, quads)) / whole
    return dict(quads=len(quads), triangles=len(tris), least=worth.min(), mean=worth.mean(), seconds=seconds, covered=covered, empty=empty)


def mesh_in_gmsh():
    """points, triangles and quads of the model"""
    tags, xyz, _ = gmsh.model.mesh.getNodes()
    row = np.zeros(int(tags.max()) + 1, int)
    row[tags.astype(int)] = np.arange(len(tags))
    kinds, _, nodes = gmsh.model.mesh.getElements(2)
    if not np.isin(np.concatenate([*nodes, tags[:1]]), tags).all():
        # Of a face that it could not mesh Gmsh keeps the old elements, not their nodes.
        raise ValueError("elements without nodes")
    of = {int(kind): row[n.astype(int)] for kind, n in zip(kinds, nodes)}
    none = np.zeros(0, int)
    return xyz.reshape(-1, 3), of.get(2, none).reshape(-1, 3), of.get(3, none).reshape(-1, 4)


if __name__ == "__main__":
    try:
        print(json.dumps(attempt(json.loads(Path(sys.argv[1]).read_text()))), flush=True)
    except Exception as refusal:  # what the binding raises
        print(json.dumps({"refused": str(refusal)}), flush=True)
