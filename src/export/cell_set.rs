//! Triangles, quads and tets with fields of numbers as VTU: what a stage made, to be looked at.

use super::vtu::{array, begin, end, reals};
use glam::DVec3;
use smallvec::SmallVec;

/// Cells of three corners (triangles) or four (tets, or quads).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellSet {
    /// #P positions.
    pub points: Vec<DVec3>,
    /// #C cells, each the indices of its corners.
    pub cells: Vec<SmallVec<[u32; 4]>>,
    /// Fields: a name and #C numbers.
    pub fields: Vec<(&'static str, Vec<f64>)>,
    /// Whether cells of four corners are quads.
    pub four_are_quads: bool,
}

/// The bytes of a VTU file.
pub fn render_cells(set: &CellSet) -> Vec<u8> {
    let mut out = String::new();
    begin(&mut out, set.points.len(), set.cells.len());
    out.push_str("<Points>\n");
    let coordinates = set.points.iter().flat_map(|p| p.to_array());
    reals(&mut out, "Points", 3, coordinates);
    out.push_str("</Points>\n<Cells>\n");
    let corners = set.cells.iter().flatten().map(|&n| i64::from(n));
    let bytes = corners.flat_map(i64::to_le_bytes);
    array(&mut out, "Int64", "connectivity", 1, bytes);
    let offsets = set.cells.iter().scan(0_i64, |end, cell| {
        *end += cell.len() as i64;
        Some(*end)
    });
    let bytes = offsets.flat_map(i64::to_le_bytes);
    array(&mut out, "Int64", "offsets", 1, bytes);
    // VTK's numbers for a triangle, a quad and a tetrahedron.
    let of_four = if set.four_are_quads { 9 } else { 10 };
    let types = (set.cells.iter()).map(|c| if c.len() == 3 { 5_u8 } else { of_four });
    array(&mut out, "UInt8", "types", 1, types);
    out.push_str("</Cells>\n<CellData>\n");
    for (name, values) in &set.fields {
        reals(&mut out, name, 1, values.iter().copied());
    }
    out.push_str("</CellData>\n");
    end(&mut out);
    out.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_types_and_fields_are_there() {
        let set = CellSet {
            points: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            cells: vec![[0, 1, 2].as_slice().into(), [0, 1, 2, 3].as_slice().into()],
            fields: vec![("face", vec![7.0, 8.0])],
            four_are_quads: false,
        };
        let text = String::from_utf8(render_cells(&set)).unwrap();
        for want in [
            "NumberOfPoints=\"4\" NumberOfCells=\"2\"",
            // Two bytes, 5 and 10, behind their length.
            "AgAAAAAAAAAFCg==",
            "Name=\"face\"",
        ] {
            assert!(text.contains(want), "{want} not in\n{text}");
        }
        let four_are_quads = true;
        let quads = CellSet {
            four_are_quads,
            ..set
        };
        let text = String::from_utf8(render_cells(&quads)).unwrap();
        assert!(text.contains("AgAAAAAAAAAFCQ=="), "{text}");
    }
}
