"""Reads meshes with other people's code and prints what it saw as JSON, one object a file.

    read_back.py READER FILE...

READER is vtu-meshio, msh-meshio, msh-gmsh, bdf-pynastran or inp-meshio. What a reader does not tell is null. Nothing is computed here but
the numbering from 1: comparing is the caller's affair.
"""

import json
import sys
import tempfile

# Element types with three and four corners, by their names in meshio.
SHELLS = ("triangle", "quad")


def node(number, at, thickness=None, normal=None):
    at = [float(x) for x in at]
    return {"number": number, "at": at, "thickness": thickness, "normal": normal}


def element(number, corners, mean=None, at_corners=None, sheet=None, faces=None):
    return {
        "number": number,
        "corners": [[float(x) for x in corner] for corner in corners],
        "mean_thickness": mean,
        "corner_thickness": at_corners,
        "sheet": sheet,
        "source_faces": faces,
    }


def seen(nodes, elements, element_sets=None, node_sets=None, edges=None, warnings=()):
    return {
        "nodes": nodes,
        "elements": elements,
        "element_sets": element_sets,
        "node_sets": node_sets,
        "edges": edges,
        "warnings": list(warnings),
    }


def vtu_meshio(path):
    import meshio

    mesh = meshio.read(path)
    thickness, normals = mesh.point_data["thickness"], mesh.point_data["normal"]
    nodes = [
        node(k + 1, at, float(thickness[k]), [float(x) for x in normals[k]])
        for k, at in enumerate(mesh.points)
    ]
    elements = []
    for b, block in enumerate(mesh.cells):
        for k, corners in enumerate(block.data):
            field = {name: values[b][k] for name, values in mesh.cell_data.items()}
            faces = [int(field["source_face_a"]), int(field["source_face_b"])]
            sheet, mean = int(field["sheet"]), float(field["thickness"])
            elements.append(element(None, mesh.points[corners], mean, None, sheet, faces))
    return seen(nodes, elements)


def msh_meshio(path):
    import meshio

    mesh = meshio.read(path)
    thickness = mesh.point_data["thickness"].reshape(-1)
    nodes = [node(None, at, float(thickness[k])) for k, at in enumerate(mesh.points)]
    names = {(int(d), int(tag)): name for name, (tag, d) in mesh.field_data.items()}
    elements, edges = [], {}
    for b, block in enumerate(mesh.cells):
        for k, corners in enumerate(block.data):
            physical = int(mesh.cell_data["gmsh:physical"][b][k])
            at = mesh.points[corners]
            if block.type in SHELLS:
                name = names[2, physical]
                mean = float(mesh.cell_data["thickness"][b].reshape(-1)[k])
                elements.append(element(None, at, mean, None, int(name.split("_")[1])))
            else:
                edges.setdefault(names[1, physical], []).append(at.tolist())
    return seen(nodes, elements, edges=edges)


def msh_gmsh(path):
    import gmsh

    gmsh.initialize(["gmsh", "-v", "2"], readConfigFiles=False)
    gmsh.logger.start()
    gmsh.open(path)
    views = {}
    for tag in gmsh.view.getTags():
        kind, tags, data, _, _ = gmsh.view.getModelData(tag, 0)
        views[kind] = {int(t): [float(x) for x in d] for t, d in zip(tags, data)}
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    at = {int(t): coordinates[3 * k : 3 * k + 3] for k, t in enumerate(tags)}
    nodes = [node(t, at[t], views["NodeData"][t][0]) for t in sorted(at)]
    elements, edges = [], {}
    for dimension, entity in gmsh.model.getEntities():
        for group in gmsh.model.getPhysicalGroupsForEntity(dimension, entity):
            name = gmsh.model.getPhysicalName(dimension, group)
            for kind, numbers, corners in zip(*gmsh.model.mesh.getElements(dimension, entity)):
                count = len(corners) // len(numbers)
                for k, number in enumerate(numbers):
                    places = [at[int(c)] for c in corners[count * k : count * (k + 1)]]
                    if dimension == 1:
                        edges.setdefault(name, []).append([[float(x) for x in p] for p in places])
                        continue
                    number, sheet = int(number), int(name.split("_")[1])
                    mean, each = views["ElementData"][number][0], views["ElementNodeData"][number]
                    elements.append(element(number, places, mean, each, sheet))
    words = ("warning", "error")
    warnings = [line for line in gmsh.logger.get() if line.lower().startswith(words)]
    gmsh.logger.stop()
    gmsh.finalize()
    return seen(nodes, elements, edges=edges, warnings=warnings)


def bdf_pynastran(path):
    from pyNastran.bdf.bdf import BDF

    model = BDF(debug=None, log=None)
    # Cross-referencing fails on any card that names what is not there.
    model.read_bdf(path, xref=True)
    nodes = [node(number, n.get_position()) for number, n in sorted(model.nodes.items())]
    elements = []
    for number, e in sorted(model.elements.items()):
        plate = e.pid_ref.t
        each = [e.T1, e.T2, e.T3] + ([e.T4] if e.type == "CQUAD4" else [])
        each = [plate if t is None else t for t in each]
        assert e.pid_ref.mid1_ref.mid == e.pid_ref.mid2_ref.mid == e.pid_ref.mid3_ref.mid
        corners = [n.get_position() for n in e.nodes_ref]
        elements.append(element(number, corners, None, each, e.pid))
    sets = {"ELEMENTS": {}, "NODES": {}}
    for s in model.sets.values():
        kind, name = s.comment.split()[-2:]
        sets[kind][name] = sorted(s.ids)
    return seen(nodes, elements, sets["ELEMENTS"], sets["NODES"])


def inp_meshio(path):
    import meshio

    # meshio knows six-node triangles by Abaqus' name alone.
    with open(path) as deck, tempfile.NamedTemporaryFile("w", suffix=".inp") as copy:
        copy.write(deck.read().replace("TYPE=S6,", "TYPE=STRI65,"))
        copy.flush()
        mesh = meshio.read(copy.name)
    # Nodes in the middle of sides are no nodes of the mesh: the corners come first in an element.
    count = {"triangle": 3, "quad": 4, "triangle6": 3, "quad8": 4}
    cells = [c[: count[block.type]] for block in mesh.cells for c in block.data]
    corners = {int(k) for c in cells for k in c}
    nodes = [node(k + 1, at) for k, at in enumerate(mesh.points) if k in corners]
    elements = [element(None, mesh.points[c]) for c in cells]
    node_sets = {
        name: sorted(int(k) + 1 for k in of if int(k) in corners)
        for name, of in mesh.point_sets.items()
    }
    return seen(nodes, elements, None, node_sets)


READERS = {
    "vtu-meshio": vtu_meshio,
    "msh-meshio": msh_meshio,
    "msh-gmsh": msh_gmsh,
    "bdf-pynastran": bdf_pynastran,
    "inp-meshio": inp_meshio,
}

if __name__ == "__main__":
    reader = READERS[sys.argv[1]]
    answers = [reader(path) for path in sys.argv[2:]]
    # Readers may print on the way: the answer is the last line.
    print("\n" + json.dumps(answers))
