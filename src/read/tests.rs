//! Readers against what writers here and elsewhere make, and against everything else that a file may hold.

use super::*;
use crate::export::{ExportOptions, Format, render};
use crate::geom::random::Pcg;
use crate::model::shell::Corners;
use crate::test_parts::{drum_mesh, plate_mesh};

fn read(format: MeshFormat, text: impl AsRef<[u8]>) -> ReadMesh {
    let bytes = text.as_ref();
    format
        .parse(bytes)
        .unwrap_or_else(|e| panic!("{format:?}: {e}\n{}", String::from_utf8_lossy(bytes)))
}

#[track_caller]
fn refused(format: MeshFormat, text: impl AsRef<[u8]>, words: &[&str]) {
    let error = format.parse(text.as_ref()).unwrap_err();
    let told = format!("{error} | {}", error.remedy());
    for word in words {
        assert!(told.contains(word), "'{word}' not in: {told}");
    }
}

/// The formats that are both written and read.
const BOTH: [(Format, MeshFormat); 5] = [
    (Format::Vtu, MeshFormat::Vtu),
    (Format::Msh, MeshFormat::Msh),
    (Format::Abaqus, MeshFormat::Inp),
    (Format::Calculix, MeshFormat::Inp),
    (Format::Nastran, MeshFormat::Bdf),
];

fn tapered() -> ShellMesh {
    let mut mesh = plate_mesh(4, 3);
    // A triangle among the quads, and a thickness that varies.
    let Corners::Quad([a, b, c, d]) = mesh.elements.as_slice()[0].corners else {
        panic!("not a quad")
    };
    let mut half = mesh.elements.as_slice()[0].clone();
    half.corners = Corners::Triangle([a, c, d]);
    mesh.elements.as_mut_slice()[0].corners = Corners::Triangle([a, b, c]);
    mesh.elements.push(half);
    let at = mesh.nodes.clone();
    for element in mesh.elements.iter_mut() {
        let corners = element.corners;
        for (k, node) in corners.as_slice().iter().enumerate() {
            element.thickness[k] = 1.0 + at[*node].x / 100.0;
        }
        if !corners.is_quad() {
            element.thickness[3] = element.thickness[2];
        }
    }
    for (to, p) in mesh.node_thickness.iter_mut().zip(at.iter()) {
        *to = 1.0 + p.x / 100.0;
    }
    mesh
}

#[test]
fn what_is_written_here_is_read_again() {
    for mesh in [plate_mesh(4, 3), drum_mesh(false), tapered()] {
        for (format, reader) in BOTH {
            let bytes = render(format, &mesh, &ExportOptions::default()).unwrap();
            let seen = read(reader, &bytes);
            assert_eq!(seen.without_thickness, 0, "{format:?}");
            assert_eq!(seen.mesh.nodes.len(), mesh.nodes.len(), "{format:?}");
            assert_eq!(seen.mesh.elements.len(), mesh.elements.len(), "{format:?}");
            assert_eq!((seen.mesh.rims.len(), seen.mesh.junctions.len()), {
                let bare = assemble::assemble(bare(&mesh)).unwrap().mesh;
                (bare.rims.len(), bare.junctions.len())
            });
            for (a, b) in mesh.nodes.iter().zip(seen.mesh.nodes.iter()) {
                assert!(a.distance(*b) < 1e-9, "{format:?}: {a} {b}");
            }
            // Decks list triangles before quads.
            for (number, element) in seen.element_numbers.iter().zip(seen.mesh.elements.iter()) {
                let own = &mesh.elements.as_slice()[*number as usize - 1];
                assert_eq!(element.corners, own.corners, "{format:?}, {number}");
                let off = (element.mean_thickness() - own.mean_thickness()).abs();
                assert!(off < 1e-9, "{format:?}, {number}: {element:?} {own:?}");
            }
        }
    }
}

fn bare(mesh: &ShellMesh) -> raw::Raw {
    let mut raw = raw::Raw {
        nodes: (1..).zip(mesh.nodes.iter().copied()).collect(),
        ..raw::Raw::default()
    };
    for element in mesh.elements.iter() {
        let nodes: Vec<u32> = element.corners.as_slice().iter().map(|n| n.0).collect();
        raw.shell(1, nodes.len(), &nodes, None);
    }
    raw
}

/// A quad and two triangles, as meshio 5.3.5 writes them.
const MESHIO_ZLIB: &str = r#"<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" compressor="vtkZLibDataCompressor">
<!--This file was created by meshio v5.3.5-->
<UnstructuredGrid>
<Piece NumberOfPoints="6" NumberOfCells="3">
<Points>
<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="binary">
AQAAAACAAACQAAAAGgAAAA==eJxjYMAHPtjjFyckDwcOOCxwQFcPALDiBmw=
</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="binary">
AQAAAACAAABQAAAAGwAAAA==eJxjYIAARijNBKWZ0cRZ0ORhfFY0cQADkAAZ
</DataArray>
<DataArray type="Int64" Name="offsets" format="binary">
AQAAAACAAAAYAAAAEAAAAA==eJxjYYAAdijNBaUBATgAFg==
</DataArray>
<DataArray type="Int64" Name="types" format="binary">
AQAAAACAAAAYAAAADgAAAA==eJzjZIAAVjQaAAFoABQ=
</DataArray>
</Cells>
<CellData>
<DataArray type="Float64" Name="thickness" format="binary">
AQAAAACAAAAYAAAAFAAAAA==eJxjYACBD/YMEOAAoTgcABe3Abg=
</DataArray>
</CellData>
</Piece>
</UnstructuredGrid>
</VTKFile>
"#;

/// The same as text.
const MSH_TEXT: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 2 0 0\n6 2 1 0\n$EndNodes\n$Elements\n3\n1 3 2 0 0 1 2 3 4\n2 2 2 0 0 2 5 3\n3 2 2 0 0 5 6 3\n$EndElements\n$ElementData\n1\n\"thickness\"\n1\n0.0\n3\n0\n1\n3\n1 1.0\n2 2.0\n3 3.0\n$EndElementData\n";

const INP_TEXT: &str = "*HEADING\n a plate, of sorts\n** a comment\n*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1.\n4, 0., 1.0D0\n5, 2.\n6, 2., 1.\n*ELEMENT, TYPE=S4R, ELSET=A\n1, 1, 2, 3, 4\n*Element, elset=B, type=S3\n2, 2, 5, 3\n3, 5, 6, 3\n*SHELL SECTION, ELSET=A, MATERIAL=M\n1.0, 5\n*Elset, elset=C, generate\n3, 3\n*SHELL SECTION, ELSET=B, MATERIAL=M\n2.,\n*SHELL SECTION, ELSET=C, COMPOSITE\n1., 3, M, 0.\n2., 3, M, 90.\n";

const BDF_TEXT: &str = "BEGIN BULK\nGRID    1               0.      0.      0.\nGRID,2,,1.,0.,0.\nGRID*   3                               1.              1.\n*       0.\nGRID    4               0.      1.0+0\nGRID    5               2.\nGRID    6               2.      1.      0.\nCQUAD4  1       1       1       2       3       4\nCTRIA3  2       2       2       5       3\n                1       1.      1.      1.\nCTRIA3  3       3       5       6       3\nPSHELL  1       1       1.      1               1\nPSHELL  2       1       2.      1               1\nPCOMP   3\n        1       1.      0.      YES     1       2.      90.     YES\nENDDATA\n";

#[test]
fn four_formats_tell_of_one_mesh() {
    for (format, text) in [
        (MeshFormat::Vtu, MESHIO_ZLIB),
        (MeshFormat::Msh, MSH_TEXT),
        (MeshFormat::Inp, INP_TEXT),
        (MeshFormat::Bdf, BDF_TEXT),
    ] {
        let seen = read(format, text);
        let mesh = &seen.mesh;
        assert_eq!(
            (mesh.nodes.len(), mesh.elements.len()),
            (6, 3),
            "{format:?}"
        );
        let corners: Vec<Vec<u32>> = (mesh.elements.iter())
            .map(|e| e.corners.as_slice().iter().map(|n| n.0).collect())
            .collect();
        assert_eq!(
            corners,
            [vec![0, 1, 2, 3], vec![1, 4, 2], vec![4, 5, 2]],
            "{format:?}"
        );
        let thickness: Vec<f64> = mesh.elements.iter().map(|e| e.mean_thickness()).collect();
        assert_eq!(thickness, [1.0, 2.0, 3.0], "{format:?}");
        assert_eq!(seen.element_numbers, [1, 2, 3], "{format:?}");
        assert_eq!(
            mesh.nodes.as_slice()[5].to_array(),
            [2.0, 1.0, 0.0],
            "{format:?}"
        );
        assert_eq!(
            (mesh.sheets.len(), seen.sheets_named),
            (1, false),
            "{format:?}"
        );
        assert_eq!(
            (mesh.rims.len(), seen.notes.len()),
            (6, 0),
            "{format:?}: {:?}",
            seen.notes
        );
    }
}

#[test]
fn no_bytes_make_a_reader_panic() {
    let stl = b"solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n".to_vec();
    let mut files: Vec<(MeshFormat, Vec<u8>)> = vec![
        (MeshFormat::Vtu, MESHIO_ZLIB.into()),
        (MeshFormat::Msh, MSH_TEXT.into()),
        (MeshFormat::Inp, INP_TEXT.into()),
        (MeshFormat::Bdf, BDF_TEXT.into()),
        (MeshFormat::Stl, stl),
    ];
    for (format, reader) in BOTH {
        let bytes = render(format, &plate_mesh(2, 1), &ExportOptions::default()).unwrap();
        files.push((reader, bytes));
    }
    files.push((MeshFormat::Msh, binary_msh()));
    let mut random = Pcg::new(5);
    for (format, bytes) in files {
        for end in 0..bytes.len() {
            let _ = format.parse(&bytes[..end]);
        }
        for _ in 0..2000 {
            let mut spoilt = bytes.clone();
            for _ in 0..1 + random.bits() % 4 {
                let at = random.bits() as usize % spoilt.len();
                spoilt[at] = (random.bits() >> 7) as u8;
            }
            let _ = format.parse(&spoilt);
        }
        for other in MeshFormat::ALL {
            let _ = other.parse(&bytes);
        }
    }
}

/// The triangle of three nodes in binary MSH 4.1.
fn binary_msh() -> Vec<u8> {
    let mut out = b"$MeshFormat\n4.1 1 8\n".to_vec();
    let int = |out: &mut Vec<u8>, n: i32| out.extend(n.to_le_bytes());
    let size = |out: &mut Vec<u8>, n: u64| out.extend(n.to_le_bytes());
    int(&mut out, 1);
    out.extend(b"\n$EndMeshFormat\n$Nodes\n");
    for n in [1, 3, 10, 30] {
        size(&mut out, n);
    }
    for n in [2, 1, 0] {
        int(&mut out, n);
    }
    for n in [3, 10, 20, 30] {
        size(&mut out, n);
    }
    let at = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f64];
    out.extend(at.iter().flat_map(|x| x.to_le_bytes()));
    out.extend(b"\n$EndNodes\n$Elements\n");
    for n in [1, 1, 7, 7] {
        size(&mut out, n);
    }
    for n in [2, 1, 2] {
        int(&mut out, n);
    }
    for n in [1, 7, 10, 20, 30] {
        size(&mut out, n);
    }
    out.extend(b"\n$EndElements\n");
    out
}

#[test]
fn binary_msh_keeps_its_numbers() {
    let seen = read(MeshFormat::Msh, binary_msh());
    assert_eq!(
        (seen.node_numbers, seen.element_numbers),
        (vec![10, 20, 30], vec![7])
    );
    assert_eq!(seen.without_thickness, 1);
}

#[test]
fn what_is_no_shell_mesh_is_told_as_what_it_is() {
    let tet = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4\n1,1,2,3,4\n";
    refused(
        MeshFormat::Inp,
        tet,
        &["1 solid elements", "solid mesh", "midshell mesh"],
    );
    refused(
        MeshFormat::Bdf,
        "GRID,1\nGRID,2,,1.\nCBAR,1,1,1,2\n",
        &["no shell element", "2 nodes"],
    );
    refused(
        MeshFormat::Bdf,
        "GRID,1\nCTETRA,1,1,1,2,3,4\n",
        &["solid mesh"],
    );
    let tetra = MSH_TEXT.replace(
        "1 3 2 0 0 1 2 3 4\n2 2 2 0 0 2 5 3\n3 2 2 0 0 5 6 3",
        "1 4 2 0 0 1 2 3 4\n2 15 2 0 0 5\n3 1 2 0 0 5 6",
    );
    refused(MeshFormat::Msh, &tetra, &["solid mesh"]);
    refused(
        MeshFormat::Inp,
        INP_TEXT.replace("5, 2.\n", "5, nan\n"),
        &["node 5", "finite"],
    );
    refused(
        MeshFormat::Msh,
        MSH_TEXT.replace("5 2 0 0", "5 inf 0 0"),
        &["node 5", "of 6 nodes 1"],
    );
    for format in MeshFormat::ALL
        .into_iter()
        .filter(|f| *f != MeshFormat::Inp)
    {
        assert!(format.parse(b"hello\n").is_err(), "{format:?}");
        assert!(format.parse(b"").is_err(), "{format:?}");
    }
}

#[test]
fn mistakes_are_told_with_their_line_and_a_remedy() {
    use MeshFormat::{Bdf, Inp, Msh, Vtu};
    for (format, from, to, words) in [
        (
            Inp,
            "*HEADING",
            "*INCLUDE, INPUT=nodes.inc",
            &[
                "line 1",
                "nodes.inc".to_uppercase().as_str(),
                "in the place",
            ][..],
        ),
        (
            Inp,
            "*NODE\n",
            "*NODE, INPUT=a\n",
            &["line 4", "another file"],
        ),
        (
            Inp,
            "*HEADING",
            "*PART, NAME=A\n*PART, NAME=B",
            &["line 2", "several parts"],
        ),
        (
            Inp,
            "2, 2, 5, 3\n",
            "2, 2, 9, 3\n",
            &["line 14", "element 2 names node 9"],
        ),
        (
            Inp,
            "2, 1., 0., 0.",
            "2, x, 0., 0.",
            &["line 6", "a coordinate is expected, not 'x'"],
        ),
        (
            Inp,
            "3, 5, 6, 3\n",
            "2, 5, 6, 3\n",
            &["line 15", "element 2 is defined twice"],
        ),
        (
            Inp,
            "5, 2.\n",
            "4, 2.\n",
            &["line 9", "node 4 is defined twice"],
        ),
        (
            Inp,
            "1, 1, 2, 3, 4\n",
            "1, 1, 2, 3\n",
            &["element 1 has too few nodes"],
        ),
        (
            Inp,
            "*ELEMENT, TYPE=S4R",
            "*ELGEN\n*ELEMENT, TYPE=S4R",
            &["*ELGEN"],
        ),
        (
            Bdf,
            "GRID,2,,1.",
            "GRID,2,7,1.",
            &["line 3", "coordinate system 7"],
        ),
        (
            Bdf,
            "GRID,2,,1.",
            "GRID,2,,1.x",
            &["line 3", "'1.x in GRID 2'"],
        ),
        (
            Bdf,
            "GRID,2,",
            "GRID,1,",
            &["line 3", "node 1 is defined twice"],
        ),
        (
            Bdf,
            "BEGIN BULK\n",
            "BEGIN BULK\nINCLUDE 'a.bdf'\n",
            &["line 2", "includes"],
        ),
        (
            Bdf,
            "CTRIA3  3       3       5       6       3",
            "CTRIA3  2       3       5       6       3",
            &["element 2 is defined twice"],
        ),
        (
            Bdf,
            "CTRIA3  3       3       5       6       3",
            "CTRIA3  3       3       5       6       8",
            &["names node 8"],
        ),
        (
            Bdf,
            "CTRIA3  3       3       5       6       3",
            "CTRIA3  3       3       5       6",
            &["too few corners"],
        ),
        (Msh, "2.2 0 8", "4.0 0 8", &["version 4.0", "msh41"]),
        (Msh, "2 2 2 0 0 2 5 3", "2 2 2 0 0 2 9 3", &["names node 9"]),
        (Msh, "$MeshFormat", "(1 \"fluent\")", &["Fluent"]),
        (Msh, "2 1 0 0", "1 1 0 0", &["node 1 is defined twice"]),
        (Msh, "2 2 2 0 0 2 5 3", "2 99 2 0 0 2 5 3", &["type 99"]),
        (
            Vtu,
            "vtkZLibDataCompressor",
            "vtkLZ4DataCompressor",
            &["vtkLZ4DataCompressor", "zlib"],
        ),
        (
            Vtu,
            "type=\"UnstructuredGrid\"",
            "type=\"PolyData\"",
            &["PolyData"],
        ),
        (
            Vtu,
            "eJxjYYAAdijNBaUBATgAFg==",
            "eJxjYYAAdijNBbUBATgAFg==",
            &["zlib"],
        ),
        (
            Vtu,
            "Name=\"types\"",
            "Name=\"kinds\"",
            &["a piece has no types"],
        ),
    ] {
        let text = match format {
            Inp => INP_TEXT,
            Bdf => BDF_TEXT,
            Msh => MSH_TEXT,
            _ => MESHIO_ZLIB,
        };
        assert!(text.contains(from), "{from}");
        refused(format, text.replacen(from, to, 1), words);
    }
    let short = &MESHIO_ZLIB[..MESHIO_ZLIB.len() / 2];
    refused(Vtu, short, &["the file ends inside"]);
}

#[test]
fn higher_orders_lose_their_middles_and_solids_beside_shells_are_left_out() {
    let deck = "*NODE\n1,0,0\n2,2,0\n3,2,2\n4,0,2\n5,1,0\n6,2,1\n7,1,2\n8,0,1\n9,9,9\n10,0,0,1\n*ELEMENT,TYPE=S8R\n1,1,2,3,4,5,6,\n7,8\n*ELEMENT,TYPE=C3D4\n2,1,2,3,10\n*ELEMENT,TYPE=SPRINGA\n3,1,2\n";
    let seen = read(MeshFormat::Inp, deck);
    // Node 9 is nobody's: it is for the audit to find.
    assert_eq!(seen.node_numbers, [1, 2, 3, 4, 9]);
    let notes = seen.notes.join("; ");
    for word in [
        "1 solid elements",
        "1 lines, points",
        "1 elements of higher order",
    ] {
        assert!(notes.contains(word), "{notes}");
    }
    let bdf = "GRID,1\nGRID,2,,1.\nGRID,3,,0.,1.\nGRID,4,,.5,0.\nCTRIA6,1,1,1,2,3,4\n,,,1.,2.,3.\nPSHELL,1,1,5.\n";
    let seen = read(MeshFormat::Bdf, bdf);
    assert_eq!(seen.node_numbers, [1, 2, 3]);
    assert_eq!(
        seen.mesh.elements.as_slice()[0].thickness,
        [1.0, 2.0, 3.0, 3.0]
    );
}

#[test]
fn an_assembly_has_numbers_of_its_own() {
    let deck = format!(
        "*Part, name=P\n{}*End Part\n*Assembly, name=A\n*Instance, name=P-1, part=P\n 5., 0., 0.\n*End Instance\n*Node\n 1, 7., 7., 7.\n*Nset, nset=R\n 1,\n*End Assembly\n",
        INP_TEXT.trim_start_matches("*HEADING\n a plate, of sorts\n")
    );
    let seen = read(MeshFormat::Inp, deck);
    assert_eq!(seen.mesh.nodes.as_slice()[0].to_array(), [0.0; 3]);
    assert!(seen.notes[0].contains("moved"), "{:?}", seen.notes);
}

#[test]
fn sheets_are_named_or_hang_together() {
    // Two quads at a fold: one piece by their edge, two where the file says so.
    let points = "0 0 0  1 0 0  1 1 0  0 1 0  1 0 1  1 1 1";
    let file = |data: &str| {
        format!(
            "<VTKFile type='UnstructuredGrid' byte_order='LittleEndian'><UnstructuredGrid><Piece><Points><DataArray type='Float32' NumberOfComponents='3' format='ascii'>{points}</DataArray></Points>\
             <Cells><DataArray type='Int32' Name='connectivity' format='ascii'>0 1 2 3 1 4 2 5</DataArray><DataArray type='Int32' Name='offsets' format='ascii'>4 8</DataArray>\
             <DataArray type='UInt8' Name='types' format='ascii'>9 8</DataArray></Cells>{data}</Piece></UnstructuredGrid></VTKFile>"
        )
    };
    let plain = read(MeshFormat::Vtu, file(""));
    assert_eq!(
        (
            plain.mesh.sheets.len(),
            plain.mesh.creases.len(),
            plain.sheets_named
        ),
        (1, 0, false)
    );
    // A pixel runs row by row.
    let corners = plain.mesh.elements.as_slice()[1].corners;
    assert_eq!(
        corners.as_slice().iter().map(|n| n.0).collect::<Vec<_>>(),
        [1, 4, 5, 2]
    );
    let named = "<CellData><DataArray type='Int32' Name='sheet' format='ascii'>7 -2</DataArray></CellData><PointData><DataArray type='Float64' Name='Thickness' format='ascii'>1 2 2 1 3 3</DataArray></PointData>";
    let named = read(MeshFormat::Vtu, file(named));
    assert_eq!(
        (
            named.mesh.sheets.len(),
            named.mesh.creases.len(),
            named.sheets_named
        ),
        (2, 1, true)
    );
    let thickness: Vec<[f64; 4]> = named.mesh.elements.iter().map(|e| e.thickness).collect();
    assert_eq!(thickness, [[1.0, 2.0, 2.0, 1.0], [2.0, 3.0, 3.0, 2.0]]);
    assert_eq!(named.mesh.elements.as_slice()[0].sheet.0, 1);
}

#[test]
fn corners_of_an_stl_are_joined_where_they_are_the_same() {
    let mut bytes = vec![0u8; 80];
    bytes.extend(2u32.to_le_bytes());
    let facets: [[[f32; 3]; 3]; 2] = [
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
        [[-0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]],
    ];
    for facet in facets {
        bytes.extend([0; 12]);
        facet
            .as_flattened()
            .iter()
            .for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    let seen = read(MeshFormat::Stl, bytes);
    assert_eq!(
        (
            seen.mesh.nodes.len(),
            seen.mesh.rims.len(),
            seen.without_thickness
        ),
        (4, 4, 2)
    );
    assert!(seen.notes[0].contains("of 6 corners 2"), "{:?}", seen.notes);
}

#[test]
fn extensions_lead_to_formats() {
    for (extension, format) in [
        ("vtu", MeshFormat::Vtu),
        ("MSH", MeshFormat::Msh),
        ("inp", MeshFormat::Inp),
        ("bdf", MeshFormat::Bdf),
        ("nas", MeshFormat::Bdf),
        ("fem", MeshFormat::Bdf),
        ("Stl", MeshFormat::Stl),
    ] {
        assert_eq!(MeshFormat::from_extension(extension), Some(format));
    }
    assert_eq!(MeshFormat::from_extension("step"), None);
}
