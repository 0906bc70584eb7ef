"""Reads and writes VTK unstructured grids (.vtu) of triangles and quads, without the product's code and without meshio.

Read: `ascii`, inline `binary` and `appended` (base64 or raw) arrays, with or without zlib blocks, little endian.
Written: `ascii`, for meshes made by hand in tests.
Reference: VTK file formats, https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html
"""
import base64
import re
import xml.etree.ElementTree as ET
import zlib

import numpy as np

DTYPE = {"Float32": "<f4", "Float64": "<f8", "Int8": "<i1", "UInt8": "<u1", "Int16": "<i2", "UInt16": "<u2",
         "Int32": "<i4", "UInt32": "<u4", "Int64": "<i8", "UInt64": "<u8"}
TRIANGLE, QUAD = 5, 9


class Grid:
    """points (n,3); tris (a,3) and quads (b,4) of point numbers; point and cell arrays by name, cells in file order;
    tri_cells and quad_cells say which cell of the file each came from."""

    def __init__(self, points, cells, point_data, cell_data):
        self.points = points
        self.point_data, self.cell_data = point_data, cell_data
        three = [i for i, c in enumerate(cells) if len(c) == 3]
        four = [i for i, c in enumerate(cells) if len(c) == 4]
        self.tri_cells, self.quad_cells = np.array(three, int), np.array(four, int)
        self.tris = np.array([cells[i] for i in three], int).reshape(-1, 3)
        self.quads = np.array([cells[i] for i in four], int).reshape(-1, 4)


def _unpack(raw, header, compressed):
    """the bytes of one array, its length header (and zlib blocks) taken off"""
    w = np.dtype(header).itemsize
    if not compressed:
        n = int(np.frombuffer(raw[:w], header)[0])
        return raw[w:w + n]
    blocks = int(np.frombuffer(raw[:w], header)[0])
    sizes = np.frombuffer(raw[3 * w:(3 + blocks) * w], header)
    out, at = b"", (3 + blocks) * w
    for n in sizes:
        out += zlib.decompress(raw[at:at + int(n)])
        at += int(n)
    return out


def _base64(text, header, compressed):
    """base64 in which the header may be padded apart from the data, as VTK does"""
    text = b"".join(text.split())
    w = np.dtype(header).itemsize
    if compressed:
        first = base64.b64decode(text[:4 * ((w + 2) // 3)])
        head = 3 * w + int(np.frombuffer(first[:w], header)[0]) * w
    else:
        head = w
    chars = 4 * ((head + 2) // 3)
    if text[:chars].rstrip(b"=") != text[:chars] or head % 3 == 0:
        return base64.b64decode(text[:chars])[:head] + base64.b64decode(text[chars:] + b"==")
    return base64.b64decode(text + b"==")


def read(path):
    """the mesh in the file at path, as a Grid"""
    data = open(path, "rb").read()
    appended, coding = b"", "raw"
    m = re.search(rb"<AppendedData[^>]*>\s*_", data)
    if m:
        coding = "base64" if b'"base64"' in m.group(0) else "raw"
        end = data.rindex(b"</AppendedData>")
        appended = data[m.end():end]
        data = data[:m.end() - 1] + data[end:]
    root = ET.fromstring(data)
    if root.get("byte_order", "LittleEndian") != "LittleEndian":
        raise ValueError(f"{path}: big endian data")
    header = DTYPE[root.get("header_type", "UInt32")]
    packed = root.get("compressor") is not None
    arrays = list(root.iter("DataArray"))
    offsets = sorted(int(a.get("offset")) for a in arrays if a.get("format") == "appended") + [len(appended)]

    def values(a):
        dtype, form = DTYPE[a.get("type")], a.get("format")
        if form == "ascii":
            out = np.array((a.text or "").split(), dtype=dtype)
        else:
            if form == "binary":
                raw = _base64((a.text or "").encode(), header, packed)
            else:
                at = int(a.get("offset"))
                raw = appended[at:next((o for o in offsets if o > at), len(appended))]
                raw = _base64(raw, header, packed) if coding == "base64" else raw
            out = np.frombuffer(_unpack(raw, header, packed), dtype)
        width = int(a.get("NumberOfComponents", "1"))
        return out.reshape(-1, width) if width > 1 else out

    piece = root.find("UnstructuredGrid/Piece")
    points = values(piece.find("Points/DataArray")).astype(float).reshape(-1, 3)
    parts = {a.get("Name"): values(a) for a in piece.find("Cells")}
    ends = parts["offsets"].astype(int)
    starts = np.r_[0, ends[:-1]]
    odd = set(np.unique(parts["types"])) - {TRIANGLE, QUAD}
    if odd:
        raise ValueError(f"{path}: cell types {sorted(map(int, odd))} are neither triangles nor quads")
    cells = [parts["connectivity"][a:b].astype(int) for a, b in zip(starts, ends)]
    data_of = lambda tag: {a.get("Name"): values(a) for a in (piece.find(tag) if piece.find(tag) is not None else [])}
    return Grid(points, cells, data_of("PointData"), data_of("CellData"))


def write(path, points, cells, point_data, cell_data):
    """an ascii file of the mesh; cells is a list of three or four point numbers each"""
    def array(name, v, kind):
        v = np.asarray(v)
        body = " ".join(repr(float(x)) if kind == "Float64" else str(int(x)) for x in v.ravel())
        width = v.shape[1] if v.ndim > 1 else 1
        return f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" format="ascii">{body}</DataArray>'

    flat = np.concatenate([np.asarray(c) for c in cells])
    kind = lambda v: "Int64" if np.asarray(v).dtype.kind in "iu" else "Float64"
    with open(path, "w") as f:
        f.write('<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian">\n')
        f.write(f'<UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(cells)}">\n')
        f.write("<Points>" + array("Points", points, "Float64") + "</Points>\n<Cells>")
        f.write(array("connectivity", flat, "Int64"))
        f.write(array("offsets", np.cumsum([len(c) for c in cells]), "Int64"))
        f.write(array("types", [TRIANGLE if len(c) == 3 else QUAD for c in cells], "UInt8") + "</Cells>\n")
        for tag, d in (("PointData", point_data), ("CellData", cell_data)):
            f.write(f"<{tag}>" + "".join(array(k, v, kind(v)) for k, v in d.items()) + f"</{tag}>\n")
        f.write("</Piece></UnstructuredGrid></VTKFile>\n")
