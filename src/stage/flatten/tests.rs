use super::*;
use crate::model::complex::MidComplex;
use crate::model::ids::PatchId;
use crate::stage::patch::patches;
use crate::stage::test_shapes as shapes;

fn only(complex: &MidComplex) -> Patch {
    patches(complex)[PatchId(0)].clone()
}

fn chart(complex: &MidComplex) -> (Patch, Chart) {
    let patch = only(complex);
    let chart = flatten(&patch).unwrap();
    assert_eq!(chart.check(&patch), vec![]);
    (patch, chart)
}

fn worst_stretch(patch: &Patch, chart: &Chart) -> f64 {
    (0..patch.triangles.len())
        .map(|t| stretch(patch, chart, t))
        .map(|s| (s.long - 1.0).abs().max((s.short - 1.0).abs()))
        .fold(0.0, f64::max)
}

#[test]
fn the_harmonic_map_reproduces_linear_maps() {
    let patch = only(&shapes::plate_with_holes(4.0));
    let linear = |p: DVec3| DVec2::new(2.0 * p.x - p.y + 3.0, 0.5 * p.x + 4.0 * p.y);
    let given: Vec<(u32, DVec2)> = patch
        .boundary()
        .map(|e| (e[0], linear(patch.points[e[0] as usize])))
        .collect();
    let places = harmonic(&patch, &given).unwrap();
    for (p, q) in patch.points.iter().zip(places) {
        assert!(linear(*p).distance(q) < 1e-10 * 400.0);
    }
}

#[test]
fn a_flat_plate_keeps_its_lengths_anywhere_in_space() {
    for c in [
        shapes::plate_with_holes(4.0),
        shapes::moved(&shapes::plate_with_holes(4.0)),
    ] {
        let (patch, chart) = chart(&c);
        assert_eq!(chart.kind, ChartKind::Plane);
        assert!(worst_stretch(&patch, &chart) < 1e-7);
    }
}

#[test]
fn half_a_cylinder_unrolls_without_stretch() {
    for c in [
        shapes::half_cylinder(40, 30),
        shapes::moved(&shapes::half_cylinder(12, 9)),
    ] {
        let (patch, chart) = chart(&c);
        assert_eq!(chart.kind, ChartKind::Free);
        assert!(worst_stretch(&patch, &chart) < 1e-6);
    }
}

#[test]
fn a_cone_unrolls_without_stretch() {
    // A regular frustum of 24 sides over 3/4 turn: its sides are flat, so the faceted surface is developable exactly.
    let c = shapes::sheet(24, 12, |u, v| {
        let (s, c) = (1.5 * std::f64::consts::PI * u).sin_cos();
        let r = 5.0 + 10.0 * v;
        DVec3::new(r * c, r * s, 12.0 * v)
    });
    let (patch, chart) = chart(&c);
    assert!(worst_stretch(&patch, &chart) < 1e-6);
}

#[test]
fn a_hemisphere_has_a_chart_without_folds() {
    let (patch, chart) = chart(&shapes::sphere(12, true));
    assert!(distorted_share(&patch, &chart) <= SLIVER_SHARE);
    assert!(worst_stretch(&patch, &chart) < 1.0);
}

#[test]
fn both_disc_maps_of_a_hemisphere_and_of_a_plate_with_holes_have_no_folds() {
    for c in [shapes::sphere(8, true), shapes::plate_with_holes(5.0)] {
        let patch = only(&c);
        let shapes = shape::shapes(&patch);
        for places in [
            harmonic::cotangent_disc(&patch, &shapes).unwrap(),
            harmonic::positive_disc(&patch, &shapes).unwrap(),
        ] {
            let kind = ChartKind::Disc;
            assert_eq!(Chart { places, kind }.check(&patch), vec![]);
        }
    }
}

#[test]
fn a_closed_patch_is_refused() {
    let patch = only(&shapes::sphere(4, false));
    assert_eq!(
        flatten(&patch),
        Err(FlattenError::Topology { euler: 2, loops: 0 })
    );
}

#[test]
fn a_long_tube_is_too_distorted_for_one_chart() {
    let patch = only(&shapes::tube(24, 40, 120.0));
    assert!(matches!(
        flatten(&patch),
        Err(FlattenError::Distorted { .. } | FlattenError::Folds { .. })
    ));
}

#[test]
fn a_small_fold_is_opened_again() {
    let patch = only(&shapes::sheet(6, 6, |u, v| DVec3::new(u, v, 0.0)));
    let mut chart = flatten(&patch).unwrap();
    let inner = (0..patch.nodes.len())
        .find(|&c| patch.points[c].distance(DVec3::new(0.5, 0.5, 0.0)) < 1e-9)
        .unwrap();
    chart.places[inner] += DVec2::new(0.3, 0.1);
    assert!(!chart.check(&patch).is_empty());
    unfold(&patch, &mut chart);
    assert!(chart.check(&patch).is_empty());
}

#[test]
fn a_hundred_thousand_triangles() {
    let patch = only(&shapes::half_cylinder(250, 200));
    assert_eq!(patch.triangles.len(), 100_000);
    let chart = flatten(&patch).unwrap();
    assert!(worst_stretch(&patch, &chart) < 1e-6);
}
