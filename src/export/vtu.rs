//! VTK XML unstructured grid (`.vtu`): inline base64, little endian, `UInt64` length headers, so that every `f64` is exact.
//!
//! Triangles are cell type 5, quads 9. Point fields: `thickness` (mm), `normal`. Cell fields: `thickness` (mean of the corners, mm), `sheet`, `wall`
//! (numbered from 1), `solid`, `source_face_a` and `source_face_b` (tags of the source file, on the side of the normal and on the other; 0 for none), `unsure` (0 or 1), `quality`,
//! `doubt` and the extra fields of the options.
//!
//! `doubt` is 0 where the audit has nothing against an element; else the sum of euler 1, pieces 2, r-error 4, cover 8, outside 16, thickness 32, free-edges 64,
//! flipped 128, orientation 256, not-finite 512, orphans 1024, unmeasured 2048, voids 4096, mass 8192
//! ([`DoubtRule::bit`](crate::model::report::DoubtRule::bit)). A wall without mesh has no cell: the report names its faces.
//!
//! Reference: VTK file formats, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use super::{ExportOptions, number_of};
use crate::model::shell::{Corners, Element, ShellMesh};

pub(super) fn render(mesh: &ShellMesh, options: &ExportOptions<'_>) -> Vec<u8> {
    let mut out = String::new();
    begin(&mut out, mesh.nodes.len(), mesh.elements.len());
    points(&mut out, mesh);
    cells(&mut out, mesh);
    point_data(&mut out, mesh);
    cell_data(&mut out, mesh, options);
    end(&mut out);
    out.into_bytes()
}

/// Everything before the points.
pub(super) fn begin(out: &mut String, points: usize, cells: usize) {
    out.push_str("<?xml version=\"1.0\"?>\n");
    out.push_str("<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n");
    out.push_str(&format!(
        "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">\n"
    ));
}

/// Everything behind the fields.
pub(super) fn end(out: &mut String) {
    out.push_str("</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

fn points(out: &mut String, mesh: &ShellMesh) {
    out.push_str("<Points>\n");
    let coordinates = mesh.nodes.iter().flat_map(|p| p.to_array());
    reals(out, "Points", 3, coordinates);
    out.push_str("</Points>\n");
}

fn cells(out: &mut String, mesh: &ShellMesh) {
    out.push_str("<Cells>\n");
    let corners = || mesh.elements.iter().map(|e| e.corners.as_slice());
    let connectivity = corners().flatten().map(|n| i64::from(n.0));
    array(
        out,
        "Int64",
        "connectivity",
        1,
        connectivity.flat_map(i64::to_le_bytes),
    );
    let offsets = corners().scan(0_i64, |end, corners| {
        *end += corners.len() as i64;
        Some(*end)
    });
    array(
        out,
        "Int64",
        "offsets",
        1,
        offsets.flat_map(i64::to_le_bytes),
    );
    let types = mesh.elements.iter().map(|e| match e.corners {
        Corners::Triangle(_) => 5_u8,
        Corners::Quad(_) => 9,
    });
    array(out, "UInt8", "types", 1, types);
    out.push_str("</Cells>\n");
}

fn point_data(out: &mut String, mesh: &ShellMesh) {
    out.push_str("<PointData Scalars=\"thickness\" Normals=\"normal\">\n");
    reals(out, "thickness", 1, mesh.node_thickness.iter().copied());
    let normals = mesh.node_normals.iter().flat_map(|n| n.to_array());
    reals(out, "normal", 3, normals);
    out.push_str("</PointData>\n");
}

fn cell_data(out: &mut String, mesh: &ShellMesh, options: &ExportOptions<'_>) {
    out.push_str("<CellData Scalars=\"thickness\">\n");
    reals(
        out,
        "thickness",
        1,
        mesh.elements.iter().map(Element::mean_thickness),
    );
    let mut integers = |name: &str, value: &dyn Fn(&Element) -> i32| {
        let bytes = mesh.elements.iter().flat_map(|e| value(e).to_le_bytes());
        array(out, "Int32", name, 1, bytes);
    };
    integers("sheet", &|e| number_of(e.sheet) as i32);
    integers("wall", &|e| number_of(mesh.sheets[e.sheet].wall) as i32);
    integers("solid", &|e| mesh.sheets[e.sheet].solid_tag);
    integers("source_face_a", &|e| e.source_faces[0]);
    integers("source_face_b", &|e| e.source_faces[1]);
    let unsure = mesh.elements.iter().map(|e| u8::from(e.unsure));
    array(out, "UInt8", "unsure", 1, unsure);
    if let Some(quality) = options.cell_quality {
        reals(out, "quality", 1, quality.iter().copied());
    }
    if let Some(doubts) = options.cell_doubts {
        let bytes = doubts.iter().flat_map(|d| d.to_le_bytes());
        array(out, "UInt32", "doubt", 1, bytes);
    }
    for (name, values) in &options.cell_fields {
        reals(out, name, 1, values.iter().copied());
    }
    out.push_str("</CellData>\n");
}

pub(super) fn reals(
    out: &mut String,
    name: &str,
    components: usize,
    values: impl Iterator<Item = f64>,
) {
    array(
        out,
        "Float64",
        name,
        components,
        values.flat_map(f64::to_le_bytes),
    );
}

/// One `DataArray`: the byte count and the bytes in a single base64 run.
pub(super) fn array(
    out: &mut String,
    kind: &str,
    name: &str,
    components: usize,
    bytes: impl Iterator<Item = u8>,
) {
    let mut block = vec![0; size_of::<u64>()];
    block.extend(bytes);
    let length = (block.len() - size_of::<u64>()) as u64;
    block[..size_of::<u64>()].copy_from_slice(&length.to_le_bytes());
    out.push_str(&format!(
        "<DataArray type=\"{kind}\" Name=\"{}\" NumberOfComponents=\"{components}\" format=\"binary\">\n",
        escaped(name)
    ));
    base64(out, &block);
    out.push_str("\n</DataArray>\n");
}

/// `text` as the value of an XML attribute.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push('_'),
            c => out.push(c),
        }
    }
    out
}

/// RFC 4648, with padding.
fn base64(out: &mut String, bytes: &[u8]) {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    out.reserve(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |k: usize| u32::from(group.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            // Three bytes make four characters; missing bytes are shown by padding.
            if k <= group.len() {
                let sextet = bits >> (18 - 6 * k) & 0x3f;
                out.push(char::from(ALPHABET[sextet as usize]));
            } else {
                out.push('=');
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{quad, text};
    use super::super::{Format, render};
    use super::*;

    #[test]
    fn base64_of_the_rfc() {
        let encoded = |plain: &str| {
            let mut out = String::new();
            base64(&mut out, plain.as_bytes());
            out
        };
        let rfc4648 = [
            "", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy",
        ];
        for (n, expected) in rfc4648.into_iter().enumerate() {
            assert_eq!(encoded(&"foobar"[..n]), expected);
        }
    }

    #[test]
    fn names_are_escaped_and_quality_comes_only_when_given() {
        let mesh = quad([1.0; 4]);
        assert!(!text(Format::Vtu, &mesh).contains("quality"));
        assert!(!text(Format::Vtu, &mesh).contains("doubt"));
        let options = ExportOptions {
            cell_quality: Some(&[0.5]),
            cell_doubts: Some(&[65]),
            cell_fields: vec![("a<\"b\"".into(), vec![1.0])],
            ..ExportOptions::default()
        };
        let vtu = String::from_utf8(render(Format::Vtu, &mesh, &options).unwrap()).unwrap();
        assert!(vtu.contains("Name=\"quality\""));
        // Eight bytes of length, four of the value.
        let field = "\"UInt32\" Name=\"doubt\" NumberOfComponents=\"1\" format=\"binary\">\nBAAAAAAAAABBAAAA\n";
        assert!(vtu.contains(field), "{vtu}");
        assert!(vtu.contains("Name=\"a&lt;&quot;b&quot;\""));
    }
}
