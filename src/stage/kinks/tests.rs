use super::*;
use crate::geom::placer::Placer;
use crate::stage::adjacency::adjacency;
use crate::stage::pair::{PairOptions, pair, sight};
use crate::stage::test_shapes::sheet;
use crate::test_parts::voxels::{Filled, filled, lines, plate, step_plate};
use glam::DVec3;

/// A sheet over x from 12 to 30 and y from 0 to 24 of a plate, at height 1.5, cut at its kinks.
fn cut(solid: &Filled) -> (MidComplex, Option<Kinked>) {
    cut_with(solid, [7, 9], 1.5)
}

/// The same with so many cells along x and y, at a height.
fn cut_with(solid: &Filled, cells: [usize; 2], z: f64) -> (MidComplex, Option<Kinked>) {
    let aag = adjacency(&solid.brep);
    let options = PairOptions::default();
    let pairing = pair(&solid.brep, &aag, &sight(&solid.brep), &options);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let complex = sheet(cells[0], cells[1], |u, v| {
        DVec3::new(12.0 + 18.0 * u, 24.0 * v, z)
    });
    let kinked = kinks(&complex, &solid.brep, &aag, &pairing, &medial);
    (complex, kinked)
}

#[test]
fn a_step_is_cut_where_the_parabola_meets_the_thick_middle() {
    // From 2 to 4 at x = 20: the middle climbs as 1 + (x - 20)² / 4, and comes to 2 at x = 22.
    let solid = step_plate();
    let (before, kinked) = cut(&solid);
    let kinked = kinked.unwrap();
    let complex = &kinked.complex;
    assert_eq!(complex.check(), vec![]);
    assert_eq!(complex.euler(), before.euler());
    let aag = adjacency(&solid.brep);
    let medial = Medial::new(&solid.brep, &aag, &kinked.pairing);
    let mut length = 0.0;
    for edge in complex.edges() {
        let walls = edge.triangles.iter().map(|&t| complex.triangles[t].wall);
        let walls: Vec<WallId> = walls.collect();
        if walls.len() == 2 && walls[0] != walls[1] {
            let [a, b] = edge.ends.map(|n| {
                let node = &complex.nodes[n];
                medial.place(node.point, &node.supports)
            });
            for p in [a, b] {
                assert!((p.x - 22.0).abs() < 1e-6 && (p.z - 2.0).abs() < 1e-6, "{p}");
            }
            length += a.distance(b);
        }
    }
    assert!((length - 24.0).abs() < 1e-9, "{length}");
    // The pieces have their own thicknesses, and are one wall again in the end.
    let mut thick: Vec<f64> = (complex.triangles.iter())
        .map(|t| kinked.pairing.walls[t.wall].thickness)
        .collect();
    thick.sort_by(f64::total_cmp);
    assert!((thick[0] - 2.0).abs() < 1e-9 && (thick[thick.len() - 1] - 4.0).abs() < 1e-9);
    let joined = kinked.pieces.joined(complex.clone());
    assert!(joined.triangles.iter().all(|t| t.wall == WallId(0)));
}

#[test]
fn round_the_corner_of_a_pocket_a_kink_is_an_arc() {
    // A pocket with its corner at (20, 12), from 4 down to 3. From height 1.75 the corner, 1.25 above, is as near as the top, 2.25 above, at a radius of √3.5.
    let grid = [
        lines(&[(40.0, 10)]),
        lines(&[(24.0, 6)]),
        lines(&[(3.0, 1), (4.0, 1)]),
    ];
    let solid = filled(grid, |p| p.z < 3.0 || p.x > 20.0 || p.y > 12.0);
    // Cells of six: one chord across all of the arc comes as near as half the radius, where the middle turns by 18 degrees.
    let (before, kinked) = cut_with(&solid, [3, 4], 1.75);
    let complex = kinked.unwrap().complex;
    assert_eq!(complex.check(), vec![]);
    assert_eq!(complex.euler(), before.euler());
    let radius = 3.5_f64.sqrt();
    let mut count = 0;
    for edge in complex.edges() {
        let walls = edge.triangles.iter().map(|&t| complex.triangles[t].wall);
        let walls: Vec<WallId> = walls.collect();
        if walls.len() == 2 && walls[0] != walls[1] {
            let [a, b] = edge.ends.map(|n| complex.nodes[n].point);
            let beyond = (a.midpoint(b) - DVec3::new(20.0, 12.0, 1.75)).max(DVec3::ZERO);
            let share = beyond.length() / radius;
            assert!((0.58..1.001).contains(&share), "{a} {b}: {share}");
            count += 1;
        }
    }
    assert!(count > 4, "{count} chords");
}

#[test]
fn a_plate_and_a_step_on_both_sides_have_no_kink() {
    assert!(cut(&plate(1)).1.is_none());
    // Thicker by as much above as below: the middle runs straight on.
    let straight = filled(
        [
            lines(&[(40.0, 10)]),
            lines(&[(24.0, 6)]),
            lines(&[(0.5, 1), (2.5, 2), (3.0, 1)]),
        ],
        |p| p.x > 20.0 || (0.5..2.5).contains(&p.z),
    );
    assert!(cut(&straight).1.is_none());
}

#[test]
fn islands_go_to_the_piece_round_about() {
    let solid = plate(1);
    let aag = adjacency(&solid.brep);
    let options = PairOptions::default();
    let pairing = pair(&solid.brep, &aag, &sight(&solid.brep), &options);
    let medial = Medial::new(&solid.brep, &aag, &pairing);
    let complex = sheet(20, 12, |u, v| DVec3::new(40.0 * u, 24.0 * v, 1.0));
    // One triangle of 2 mm² in a wall 2 thick is noise; the half of the plate is not.
    let label = |t: TriangleId| Some(u32::from(t == TriangleId(70)) + 2 * u32::from(t.0 >= 240));
    let mut labels: IndexVec<TriangleId, Option<Class>> =
        complex.triangles.ids().map(label).collect();
    absorb(&complex, &mut labels, &medial);
    assert_eq!(labels[TriangleId(70)], Some(0));
    assert_eq!(labels.iter().filter(|l| **l == Some(2)).count(), 240);
}
