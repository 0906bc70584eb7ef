"""Writes one small shell mesh with other people's programs, in every way that a reader of shell meshes meets.

    write_meshes.py FOLDER

The mesh: a strip of 4 x 3 quads of which the last column is cut into triangles, bent, with a thickness an element where the writer has room for one. Prints the
files as JSON, each with whether thickness came along. solid-* are meshes of solids, nan.vtu has a node that is no number.
"""

import json
import sys

import meshio
import numpy as np
import pyvista
import vtk

NU, NV = 4, 3


def strip():
    points = np.array([[2.0 * i, 1.5 * j, 0.1 * i * i] for j in range(NV + 1) for i in range(NU + 1)])
    quads, triangles = [], []
    for j in range(NV):
        for i in range(NU):
            a = j * (NU + 1) + i
            b, c, d = a + 1, a + NU + 2, a + NU + 1
            if i + 1 < NU:
                quads.append([a, b, c, d])
            else:
                triangles += [[a, b, c], [a, c, d]]
    return points, np.array(quads), np.array(triangles)


def with_meshio(folder):
    points, quads, triangles = strip()
    cells = [("quad", quads), ("triangle", triangles)]
    thickness = {"thickness": [1.0 + 0.1 * np.arange(len(c)) for _, c in cells]}
    mesh = meshio.Mesh(points, cells, cell_data=thickness)
    every = meshio.Mesh(points, [("triangle", np.vstack([quads[:, :3], quads[:, [0, 2, 3]], triangles]))])
    files = []

    def put(name, has_thickness, write, of=mesh):
        write(f"{folder}/{name}", of)
        files.append([name, has_thickness])

    put("meshio-zlib.vtu", True, lambda f, m: meshio.vtu.write(f, m, binary=True, compression="zlib"))
    put("meshio-plain.vtu", True, lambda f, m: meshio.vtu.write(f, m, binary=True, compression=None))
    put("meshio-text.vtu", True, lambda f, m: meshio.vtu.write(f, m, binary=False))
    put("meshio-22.msh", True, lambda f, m: meshio.gmsh.write(f, m, "2.2", binary=False))
    put("meshio-22-binary.msh", True, lambda f, m: meshio.gmsh.write(f, m, "2.2", binary=True))
    put("meshio.inp", False, meshio.abaqus.write)
    put("meshio-large.bdf", False, lambda f, m: meshio.nastran.write(f, m, point_format="fixed-large"))
    put("meshio-small.bdf", False, lambda f, m: meshio.nastran.write(f, m, point_format="fixed-small"))
    put("meshio-free.nas", False, lambda f, m: meshio.nastran.write(f, m, point_format="free"))
    # One kind of cell: meshio wants entities for more, and STL has only one.
    put("triangles-41.msh", False, lambda f, m: meshio.gmsh.write(f, m, "4.1", binary=False), every)
    put("triangles-41-binary.msh", False, lambda f, m: meshio.gmsh.write(f, m, "4.1", binary=True), every)
    put("triangles.stl", False, lambda f, m: meshio.stl.write(f, m, binary=False), every)
    put("triangles-binary.stl", False, lambda f, m: meshio.stl.write(f, m, binary=True), every)
    solid = meshio.Mesh(np.vstack([points, [[0, 0, 5.0]]]), [("tetra", [[0, 1, 5, len(points)]]), ("line", [[0, 1]])])
    meshio.vtu.write(f"{folder}/solid.vtu", solid)
    meshio.gmsh.write(f"{folder}/solid.msh", solid, "2.2", binary=False)
    meshio.abaqus.write(f"{folder}/solid.inp", solid)
    meshio.nastran.write(f"{folder}/solid.bdf", solid)
    lost = points.copy()
    lost[3, 1] = np.nan
    meshio.vtu.write(f"{folder}/nan.vtu", meshio.Mesh(lost, cells))
    return files


def with_vtk(folder):
    points, quads, triangles = strip()
    grid = pyvista.UnstructuredGrid({9: quads, 5: triangles}, points)
    grid.cell_data["thickness"] = np.hstack([1.0 + 0.1 * np.arange(len(c)) for c in (quads, triangles)]).astype(np.float32)
    files = []
    for name, setters in {
        "text": ["SetDataModeToAscii"],
        "binary": ["SetDataModeToBinary"],
        "appended": ["SetDataModeToAppended", "EncodeAppendedDataOff"],
        "encoded": ["SetDataModeToAppended", "EncodeAppendedDataOn"],
        "plain": ["SetDataModeToAppended", "EncodeAppendedDataOff", "SetCompressorTypeToNone"],
        "plain-encoded": ["SetDataModeToAppended", "EncodeAppendedDataOn", "SetCompressorTypeToNone"],
        "plain-binary": ["SetDataModeToBinary", "SetCompressorTypeToNone"],
        "big-endian": ["SetDataModeToAppended", "EncodeAppendedDataOff", "SetByteOrderToBigEndian"],
        "short-header": ["SetDataModeToBinary", "SetHeaderTypeToUInt32"],
        "short-ids": ["SetDataModeToBinary", "SetIdTypeToInt32"],
    }.items():
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetInputData(grid)
        writer.SetFileName(f"{folder}/vtk-{name}.vtu")
        # Small blocks, so that there are several.
        writer.SetBlockSize(96)
        for setter in setters:
            getattr(writer, setter)()
        writer.Write()
        files.append([f"vtk-{name}.vtu", True])
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(grid)
    writer.SetFileName(f"{folder}/lz4.vtu")
    writer.SetCompressorTypeToLZ4()
    writer.Write()
    return files


def with_gmsh(folder):
    import gmsh

    points, quads, triangles = strip()
    gmsh.initialize(["gmsh", "-v", "1"], readConfigFiles=False)
    files = []
    for surface, (kind, cells) in enumerate([(3, quads), (2, triangles)], 1):
        gmsh.model.addDiscreteEntity(2, surface)
        if surface == 1:
            gmsh.model.mesh.addNodes(2, 1, range(1, len(points) + 1), points.ravel())
        first = 1 if surface == 1 else 1 + len(quads)
        gmsh.model.mesh.addElements(2, surface, [kind], [range(first, first + len(cells))], [(cells + 1).ravel()])
    for version in ("2.2", "4.1"):
        for binary in (0, 1):
            gmsh.option.setNumber("Mesh.MshFileVersion", float(version))
            gmsh.option.setNumber("Mesh.Binary", binary)
            name = f"gmsh-{version}-{'binary' if binary else 'text'}.msh"
            gmsh.write(f"{folder}/{name}")
            files.append([name, False])
    for name in ("gmsh.inp", "gmsh.bdf"):
        gmsh.option.setNumber("Mesh.SaveAll", 1)
        gmsh.write(f"{folder}/{name}")
        files.append([name, False])
    gmsh.finalize()
    return files


def with_pynastran(folder):
    from pyNastran.bdf.bdf import BDF

    points, quads, triangles = strip()
    model = BDF(debug=None, log=None)
    model.add_mat1(1, 210000.0, None, 0.3)
    for k, p in enumerate(points):
        model.add_grid(k + 1, [float(x) for x in p])
    number = 0
    for cells, add in ((quads, model.add_cquad4), (triangles, model.add_ctria3)):
        for k, cell in enumerate(cells):
            number += 1
            model.add_pshell(number, mid1=1, t=float(1.0 + 0.1 * k))
            add(number, number, [int(n) + 1 for n in cell])
    files = []
    for name, size in (("pynastran-8.bdf", 8), ("pynastran-16.bdf", 16)):
        model.write_bdf(f"{folder}/{name}", size=size, close=True)
        files.append([name, True])
    return files


if __name__ == "__main__":
    folder = sys.argv[1]
    made = with_meshio(folder) + with_vtk(folder) + with_gmsh(folder) + with_pynastran(folder)
    print("\n" + json.dumps(made))
