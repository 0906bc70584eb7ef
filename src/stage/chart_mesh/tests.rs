use super::*;
use crate::model::complex::MidComplex;
use crate::model::ids::PatchId;
use crate::stage::flatten::flatten;
use crate::stage::patch::patches;
use crate::stage::test_shapes::{self as shapes, Onto, Stay};
use glam::DVec2;
use std::f64::consts::TAU;

fn only(complex: &MidComplex) -> Patch {
    patches(complex)[PatchId(0)].clone()
}

/// All corners of a mesh in space.
fn corner(patch: &Patch, mesh: &PatchMesh, i: u32) -> DVec3 {
    let i = i as usize;
    let n = patch.points.len();
    if i < n {
        patch.points[i]
    } else {
        mesh.points[i - n]
    }
}

fn has_edge(mesh: &PatchMesh, e: [u32; 2]) -> bool {
    let holds = |t: &[u32; 3]| t.contains(&e[0]) && t.contains(&e[1]);
    mesh.triangles.iter().any(holds)
}

#[test]
fn a_square_gets_as_many_triangles_as_equilateral_ones_have_room() {
    let patch = only(&shapes::sheet(20, 20, |u, v| {
        DVec3::new(20.0 * u, 20.0 * v, 0.0)
    }));
    let chart = flatten(&patch).unwrap();
    let mesh = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(1.0),
        &Stay,
    )
    .unwrap();
    let ideal = 400.0 / (0.75f64.sqrt() / 2.0);
    let count = mesh.triangles.len() as f64;
    assert!((count / ideal - 1.0).abs() < 0.06, "{count} for {ideal}");
    let area: f64 = (mesh.triangles.iter())
        .map(|t| {
            let [a, b, c] = t.map(|i| corner(&patch, &mesh, i));
            assert!((b - a).cross(c - a).z > 0.0);
            (b - a).cross(c - a).z / 2.0
        })
        .sum();
    assert!((area - 400.0).abs() < 1e-9);
    assert!(patch.boundary().all(|e| has_edge(&mesh, e)));
}

#[test]
fn a_square_has_room_for_as_many_squares_as_it_should() {
    let patch = only(&shapes::sheet(20, 20, |u, v| {
        DVec3::new(20.0 * u, 20.0 * v, 0.0)
    }));
    let chart = flatten(&patch).unwrap();
    let mesh = triangulate(
        &patch,
        &chart,
        Pattern::Squares,
        &|_, _| Lengths::equal(1.0),
        &Stay,
    )
    .unwrap();
    assert_eq!(mesh.triangles.len(), 800);
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| corner(&patch, &mesh, i));
        let mut sides = [a.distance(b), b.distance(c), c.distance(a)];
        sides.sort_unstable_by(f64::total_cmp);
        // Places in the chart lie on a fine grid.
        assert!((sides[1] - 1.0).abs() < 1e-6 && (sides[2] - 2f64.sqrt()).abs() < 1e-6);
    }
}

#[test]
fn kept_edges_and_corners_stay() {
    let c = shapes::rib_on_plate(0.5);
    let patch = only(&c);
    let chart = flatten(&patch).unwrap();
    let mesh = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(2.0),
        &Stay,
    )
    .unwrap();
    assert_eq!(patch.kept_edges.len(), 10);
    assert!(patch.kept_edges.iter().all(|e| has_edge(&mesh, *e)));
}

#[test]
fn a_strip_of_one_element_gets_no_new_points() {
    let patch = only(&shapes::sheet(30, 1, |u, v| DVec3::new(30.0 * u, v, 0.0)));
    let chart = flatten(&patch).unwrap();
    let mesh = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(1.0),
        &Stay,
    )
    .unwrap();
    assert_eq!((mesh.points.len(), mesh.triangles.len()), (0, 60));
}

#[test]
fn a_size_that_is_no_number_leaves_the_spacing_of_the_boundary() {
    let patch = only(&shapes::sheet(8, 8, |u, v| DVec3::new(u, v, 0.0)));
    let chart = flatten(&patch).unwrap();
    for size in [f64::NAN, 0.0, -1.0, f64::INFINITY] {
        let mesh = triangulate(
            &patch,
            &chart,
            Pattern::Triangles,
            &|_, _| Lengths::equal(size),
            &Stay,
        )
        .unwrap();
        assert!((100..200).contains(&mesh.triangles.len()));
    }
}

#[test]
fn new_nodes_lie_where_the_placer_puts_them() {
    let patch = only(&shapes::sphere(8, true));
    let chart = flatten(&patch).unwrap();
    let round = Onto(|p: DVec3| 10.0 * p.normalize());
    let mesh = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(2.0),
        &round,
    )
    .unwrap();
    assert!(!mesh.points.is_empty());
    assert!(
        mesh.points
            .iter()
            .all(|p| (p.length() - 10.0).abs() < 1e-12)
    );
}

#[test]
fn a_chart_that_runs_over_itself_is_refused() {
    // A strip wound one and a quarter times round a ring: no triangle folds, but the ends overlap.
    let patch = only(&shapes::sheet(50, 2, |u, v| {
        DVec3::new(100.0 * u, 4.0 * v, 0.0)
    }));
    let mut chart = flatten(&patch).unwrap();
    for (place, p) in chart.places.iter_mut().zip(&patch.points) {
        *place = DVec2::from_angle(1.25 * TAU * p.x / 100.0) * (14.0 - p.y);
    }
    assert_eq!(chart.check(&patch), vec![]);
    let refused = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(2.0),
        &Stay,
    );
    assert!(
        matches!(refused, Err(MeshError::Cdt(_) | MeshError::Overlap { .. })),
        "{refused:?}"
    );
}

#[test]
fn a_planted_fold_is_refused() {
    let patch = only(&shapes::sheet(6, 6, |u, v| DVec3::new(u, v, 0.0)));
    let mut chart = flatten(&patch).unwrap();
    chart.places.iter_mut().for_each(|p| p.x = -p.x);
    let refused = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(0.2),
        &Stay,
    );
    assert_eq!(refused, Err(MeshError::Folded(72)));
}

#[test]
fn triangles_turned_over_by_the_placer_are_refused() {
    let patch = only(&shapes::sheet(10, 10, |u, v| DVec3::new(u, v, 0.0)));
    let chart = flatten(&patch).unwrap();
    let mirror = Onto(|p: DVec3| DVec3::new(1.0 - p.x, p.y, p.z));
    let refused = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(0.1),
        &mirror,
    );
    assert!(matches!(refused, Err(MeshError::Inverted(_))));
    let nowhere = Onto(|_| DVec3::NAN);
    let refused = triangulate(
        &patch,
        &chart,
        Pattern::Triangles,
        &|_, _| Lengths::equal(0.1),
        &nowhere,
    );
    assert!(matches!(refused, Err(MeshError::Inverted(_))));
}

#[test]
fn steps_in_the_chart_and_in_space_are_inverse() {
    let patch = only(&shapes::sphere(8, true));
    let chart = flatten(&patch).unwrap();
    let surface = Surface::new(&patch, &chart);
    for (i, t) in patch.triangles.iter().enumerate() {
        let [a, b, c] = t.map(|k| chart.places[k as usize]);
        let spot = surface.locate((a + b + c) / 3.0).unwrap();
        assert_eq!(spot.triangle, i as u32);
        let [p, q, r] = patch.triangle_points(i);
        assert!(surface.lift(&spot).distance((p + q + r) / 3.0) < 1e-9);
        assert!(surface.push(i as u32, b - a).distance(q - p) < 1e-9);
        assert!(surface.pull(i as u32, q - p).distance(b - a) < 1e-9);
    }
    assert!(surface.locate(DVec2::splat(1e3)).is_none());
}

#[test]
fn the_long_diagonal_of_a_flat_quad_flips_unless_kept() {
    let places = [(0.0, 0.0), (2.0, -0.5), (4.0, 0.0), (2.0, 0.5)].map(DVec2::from);
    let points = places.map(|place| Point { place, size: 1.0 });
    let positions = places.map(|p| p.extend(0.0));
    let start = [[0, 1, 2], [0, 2, 3]];
    let run = |fixed: usize, kept: &[[u32; 2]]| {
        let mut triangles = start;
        flip::flip(&points, &positions, &[], fixed, kept, &mut triangles);
        triangles
    };
    let flipped = run(0, &[]);
    assert!(flipped.iter().all(|t| t.contains(&1) && t.contains(&3)));
    assert_eq!(run(0, &[[0, 2]]), start);
    assert_eq!(run(4, &[]), start);
}
