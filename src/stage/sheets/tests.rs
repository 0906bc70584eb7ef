use super::*;
use crate::model::complex::MidNode;
use crate::model::ids::NodeId;
use crate::model::shell::{Corners, Element, Sheet};
use crate::stage::test_shapes::Build;

/// A plate cut in two by a rib off its middle; `cells` to a side of each piece, walls in this order of building.
fn ribbed(cells: usize, order: [usize; 3]) -> MidComplex {
    let mut build = Build::default();
    for piece in order {
        let (wall, to) = [
            (0, DVec3::new(0.0, 14.0, 0.0)),
            (0, DVec3::new(0.0, -6.0, 0.0)),
            (1, DVec3::new(0.0, 0.0, 8.0)),
        ][piece];
        build.sheet(wall, cells, cells, |s, t| {
            DVec3::new(30.0 * s, 0.0, 0.0) + t * to
        });
    }
    build.complex
}

fn areas(pieces: &[Piece]) -> Vec<f64> {
    pieces.iter().map(|p| p.area().round()).collect()
}

#[test]
fn the_largest_comes_first_in_whatever_mesh() {
    let want = [420.0, 240.0, 180.0];
    let fine = ribbed(12, [2, 1, 0]);
    let sheets = Sheets::new(&fine);
    assert_eq!(sheets.count(), 3);
    assert_eq!(areas(&sheets.of_complex(&fine)), want);
    for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
        let coarse = ribbed(3, order);
        let found = sheets.of_complex(&coarse);
        assert_eq!(areas(&found), want);
        let walls: Vec<u32> = found.iter().map(|p| p.wall.0).collect();
        assert_eq!(walls, [0, 1, 0]);
        assert!((found[0].centre() - DVec3::new(15.0, 7.0, 0.0)).length() < 1e-9);
    }
}

#[test]
fn the_number_is_that_of_the_place_not_of_the_size() {
    // Pieces that change places in size when the part is meshed keep their numbers.
    let two = |far: f64, near: f64| {
        let mut build = Build::default();
        build.sheet(0, 4, 4, |s, t| DVec3::new(30.0 * s, far * t, 0.0));
        build.sheet(0, 4, 4, |s, t| DVec3::new(30.0 * s, -near * t, 0.0));
        build.sheet(1, 4, 4, |s, t| DVec3::new(30.0 * s, 0.0, 5.0 * t));
        build.complex
    };
    let sheets = Sheets::new(&two(10.1, 10.0));
    assert_eq!(
        areas(&sheets.of_complex(&two(9.9, 10.2))),
        [297.0, 306.0, 150.0]
    );
}

#[test]
fn equal_sheets_keep_their_order_and_rounding_does_not_part_them() {
    let pair = |more: f64| {
        let mut build = Build::default();
        build.sheet(0, 2, 2, |s, t| DVec3::new(10.0 * s, 10.0 * t, 0.0));
        build.sheet(1, 2, 2, |s, t| {
            DVec3::new(10.0 * s + 50.0, (10.0 + more) * t, 0.0)
        });
        let numbered = Sheets::new(&build.complex);
        numbered.of_complex(&build.complex)[0].wall
    };
    assert_eq!(pair(0.0), WallId(0));
    assert_eq!(pair(1e-9), WallId(0));
    assert_eq!(pair(1e-3), WallId(1));
}

#[test]
fn what_is_parted_comes_last_and_crumbs_move_nothing() {
    let fine = ribbed(12, [0, 1, 2]);
    let sheets = Sheets::new(&fine);
    // Of the largest sheet a strip is cut off: no junction, no crease, only a gap.
    let mut cut = Build::default();
    cut.sheet(0, 3, 3, |s, t| DVec3::new(30.0 * s, 10.0 * t, 0.0));
    cut.sheet(0, 3, 3, |s, t| DVec3::new(30.0 * s, 11.0 + 3.0 * t, 0.0));
    cut.sheet(0, 3, 3, |s, t| DVec3::new(30.0 * s, -6.0 * t, 0.0));
    cut.sheet(1, 3, 3, |s, t| DVec3::new(30.0 * s, 0.0, 8.0 * t));
    assert_eq!(
        areas(&sheets.of_complex(&cut.complex)),
        [300.0, 240.0, 180.0, 90.0]
    );
    // A crumb that cleaning takes away has the last number.
    let mut crumbs = Build::default();
    crumbs.complex = fine.clone();
    crumbs.sheet(2, 1, 1, |s, t| DVec3::new(0.1 * s, 0.1 * t, 9.0));
    let with = Sheets::new(&crumbs.complex);
    assert_eq!(with.count(), 4);
    assert_eq!(
        areas(&with.of_complex(&fine)),
        areas(&sheets.of_complex(&fine))
    );
}

#[test]
fn a_shell_comes_in_the_order_of_the_numbers_with_all_that_it_had() {
    let complex = ribbed(2, [1, 2, 0]);
    let sheets = Sheets::new(&complex);
    let first_of = complex.sheets(&complex.edges());
    let mut firsts: Vec<TriangleId> = first_of.iter().copied().collect();
    firsts.sort_unstable();
    firsts.dedup();
    let shell = |nodes: &IndexVec<NodeId, MidNode>| ShellMesh {
        nodes: nodes.iter().map(|n| n.point).collect(),
        elements: (complex.triangles.enumerated())
            .map(|(t, triangle)| Element {
                corners: Corners::Triangle(triangle.nodes),
                sheet: SheetId::new(firsts.iter().position(|f| *f == first_of[t]).unwrap()),
                thickness: [f64::from(t.0); 4],
                source_faces: [1, 2],
                unsure: false,
            })
            .collect(),
        sheets: (firsts.iter())
            .map(|&t| Sheet {
                solid_tag: 1,
                wall: complex.triangles[t].wall,
                sides: [vec![t.0 as i32], vec![]],
            })
            .collect(),
        ..ShellMesh::default()
    };
    let old = shell(&complex.nodes);
    let new = sheets.in_order(old.clone());
    assert_eq!(new.nodes, old.nodes);
    let mut area = [0.0; 3];
    for e in &new.elements {
        area[e.sheet.index()] += new.doubled_area(e).length() / 2.0;
        // Its sheet is the one that it had.
        let was = old
            .elements
            .iter()
            .find(|o| o.corners == e.corners)
            .unwrap();
        assert_eq!(new.sheets[e.sheet], old.sheets[was.sheet]);
        assert_eq!(e.thickness, was.thickness);
    }
    assert_eq!(area.map(f64::round), [420.0, 240.0, 180.0]);
    let order: Vec<SheetId> = new.elements.iter().map(|e| e.sheet).collect();
    assert!(order.is_sorted());
    assert_eq!(sheets.in_order(new.clone()), new);
}
