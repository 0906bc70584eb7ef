//! Whole remeshings over closed forms.

mod cases;
mod forms;
mod topology;

use super::{RemeshOptions, clean, remesh};
use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, MidNode, MidTriangle, Support};
use crate::model::ids::{NodeId, WallId};
use cases::{book, plate, rectangle, sphere, tee, tube, v, washer, wedge};
use forms::{Builder, Form, Forms, area, assert_good, quality, roughen};
use glam::{DQuat, DVec3};
use proptest::prelude::*;

fn at_size(complex: &MidComplex, forms: &Forms, size: f64) -> MidComplex {
    remesh(
        complex.clone(),
        &|_, _| size,
        forms,
        &RemeshOptions::default(),
    )
    .0
}

fn edge_lengths(c: &MidComplex) -> impl Iterator<Item = f64> + '_ {
    let point = |n| c.nodes[n].point;
    let edges = c.edges().into_iter();
    edges.map(move |e| point(e.ends[0]).distance(point(e.ends[1])))
}

/// Whether edge lengths are as asked for, on the mean.
fn assert_size(c: &MidComplex, size: f64) {
    let mean = edge_lengths(c).sum::<f64>() / c.edges().len() as f64;
    assert!(
        mean > 0.8 * size && mean < 1.2 * size,
        "mean {mean}, wanted {size}"
    );
}

fn has_node_at(c: &MidComplex, p: DVec3) -> bool {
    c.nodes.iter().any(|n| n.point.distance(p) < 1e-6)
}

#[test]
fn plates_finer_and_coarser_than_asked() {
    for cells in [(1, 1), (2, 7), (40, 40)] {
        let (c, forms) = plate(cells.0, cells.1);
        for size in [0.4, 1.0] {
            let out = at_size(&c, &forms, size);
            assert_good(&c, &out, &forms);
            assert_size(&out, size);
            assert!((area(&out) - 60.0).abs() < 1e-6);
            for p in [
                v(0.0, 0.0, 0.0),
                v(10.0, 0.0, 0.0),
                v(10.0, 6.0, 0.0),
                v(0.0, 6.0, 0.0),
            ] {
                assert!(has_node_at(&out, p));
            }
        }
    }
}

#[test]
fn junctions_of_three_four_and_five_sheets() {
    for (c, forms) in [
        tee(5),
        book(&[0.0, 90.0, 180.0, 270.0], 6),
        book(&[0.0, 50.0, 120.0, 200.0, 290.0], 6),
        book(&[0.0, 90.0], 3),
    ] {
        let out = at_size(&c, &forms, 0.5);
        assert_good(&c, &out, &forms);
        assert_size(&out, 0.5);
        assert!((area(&out) - area(&c)).abs() < 1e-6);
    }
}

#[test]
fn curved_sheets_keep_their_area() {
    let (c, forms) = tube(60, 30);
    let out = at_size(&c, &forms, 0.6);
    assert_good(&c, &out, &forms);
    let truth = std::f64::consts::TAU * 3.0 * 8.0;
    assert!((area(&out) - truth).abs() < 0.01 * truth);
    let (c, forms) = sphere(12);
    let out = at_size(&c, &forms, 0.5);
    assert_good(&c, &out, &forms);
    let truth = 2.0 * std::f64::consts::TAU * 9.0;
    assert!((area(&out) - truth).abs() < 0.01 * truth);
}

#[test]
fn a_hole_stays_round_though_the_size_is_large() {
    let (c, forms) = washer(200, 30);
    let out = at_size(&c, &forms, 1.0);
    assert_good(&c, &out, &forms);
    let truth = std::f64::consts::PI * 24.0;
    assert!((area(&out) - truth).abs() < 0.005 * truth, "{}", area(&out));
    let rim = std::f64::consts::TAU * 6.0;
    assert!((length_of_rims(&out) - rim).abs() < 0.005 * rim);
}

fn length_of_rims(c: &MidComplex) -> f64 {
    forms::length(c, EdgeKind::Rim)
}

#[test]
fn a_raw_complex_becomes_clean_and_then_good() {
    for (c, forms) in [
        plate(30, 20),
        tee(12),
        tube(60, 30),
        washer(120, 20),
        book(&[0.0, 50.0, 120.0, 200.0, 290.0], 12),
    ] {
        let raw = roughen(c, &forms, 6000, 0.05);
        assert!(quality(&raw, &forms).worst > 1000.0);
        let cleaned = clean(raw.clone(), &|_, _| 0.15, &forms);
        assert_eq!(cleaned.check(), vec![]);
        assert_eq!(forms::topology(&cleaned), forms::topology(&raw));
        // Of what is short, folded or flat only single places are left.
        let count = cleaned.triangles.len();
        let short = edge_lengths(&cleaned).filter(|&l| l < 0.15).count();
        let dust = edge_lengths(&cleaned).filter(|&l| l < 0.0075).count();
        assert!(short < count / 100 && dust == 0, "{short}, {dust}");
        let q = quality(&cleaned, &forms);
        assert!(q.flipped < count / 50 && q.long < 0.25, "{q:?}");
        let out = at_size(&cleaned, &forms, 0.6);
        assert_good(&raw, &out, &forms);
        // Without the cleaning, too.
        assert_good(&raw, &at_size(&raw, &forms, 0.6), &forms);
    }
}

/// A node in the middle of the riser leaves the rim as it was, but its turn at either end only to rounding.
#[test]
fn a_tiny_step_in_a_rim_goes_wherever_the_part_lies() {
    let mut c = MidComplex::default();
    let high = [0.0, 2.0, 4.0, 4.0, 4.0, 6.0, 8.0];
    let step = [0.0, 0.0, 0.0, 0.01, 0.02, 0.02, 0.02];
    let low = [0.0, 2.0, 5.0, 6.0, 8.0];
    for p in (high.iter().zip(step)).map(|(&x, y)| v(x, y, 0.0)) {
        c.nodes.push(MidNode {
            point: p,
            supports: Default::default(),
        });
    }
    for x in low {
        c.nodes.push(MidNode {
            point: v(x, -2.0, 0.0),
            supports: Default::default(),
        });
    }
    for nodes in [
        [0, 7, 1],
        [1, 7, 8],
        [1, 8, 2],
        [2, 8, 9],
        [2, 9, 3],
        [3, 9, 4],
        [4, 9, 10],
        [4, 10, 5],
        [5, 10, 11],
        [5, 11, 6],
    ] {
        c.triangles.push(MidTriangle {
            nodes: nodes.map(NodeId),
            wall: WallId(0),
        });
    }
    for k in 0..20 {
        let turn = DQuat::from_axis_angle(v(1.0, 2.0, 2.0) / 3.0, 0.3 * f64::from(k));
        let mut there = c.clone();
        for n in there.nodes.iter_mut() {
            n.point = turn * n.point + v(37.0, -53.0, 71.0);
        }
        let out = clean(there, &|_, _| 0.5, &Blind);
        let short = edge_lengths(&out).filter(|&l| l < 0.5).count();
        assert_eq!(short, 0, "turned by {k} times 0.3");
        assert_eq!(out.nodes.len(), c.nodes.len() - 2);
    }
}

#[test]
fn the_size_field_is_followed() {
    let (c, forms) = plate(20, 12);
    let field = |p: DVec3, _| 0.1 + 0.1 * p.x;
    let (out, _) = remesh(c.clone(), &field, &forms, &RemeshOptions::default());
    assert_good(&c, &out, &forms);
    for e in out.edges() {
        let [p, q] = e.ends.map(|n| out.nodes[n].point);
        let wanted = 0.1 + 0.05 * (p.x + q.x);
        let ratio = p.distance(q) / wanted;
        assert!(ratio > 0.4 && ratio < 2.2, "{ratio} at {p}");
    }
}

#[test]
fn one_thread_and_four_give_the_same() {
    let (c, forms) = tee(10);
    let raw = roughen(c, &forms, 2000, 0.05);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| at_size(&clean(raw.clone(), &|_, _| 0.1, &forms), &forms, 0.5))
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn the_checks_of_these_tests_fail_on_planted_defects() {
    let (c, forms) = plate(10, 6);
    let mut turned = c.clone();
    turned.triangles[crate::model::ids::TriangleId(5)]
        .nodes
        .swap(0, 1);
    assert_eq!(quality(&turned, &forms).flipped, 1);
    let mut torn = c.clone();
    let mut triangles = torn.triangles.into_vec();
    triangles.remove(40);
    torn.triangles = triangles.into();
    assert_ne!(forms::topology(&torn), forms::topology(&c));
}

#[test]
fn a_strip_narrower_than_the_size_gets_triangles_of_its_width() {
    let (c, forms) = rectangle(v(10.0, 0.3, 0.0), 40, 2);
    let out = at_size(&c, &forms, 1.0);
    assert_good(&c, &out, &forms);
    assert!(out.triangles.len() < 400, "{}", out.triangles.len());
}

#[test]
fn a_bent_rim_where_the_wall_has_no_thickness_is_not_split_without_end() {
    // The side at x = 10 bulges by 4.5 thousandths, far more than any share of the thickness there.
    let (_, mut forms) = plate(4, 4);
    forms.thickness = 1e-9;
    forms.faces[1] = Form::Cylinder(v(-1000.0, 3.0, 0.0), DVec3::Z, 1010.0);
    let mut b = Builder::default();
    let end = |y: f64| -1000.0 + (1010f64.powi(2) - (y - 3.0).powi(2)).sqrt();
    b.grid(20, 12, 0, |s, t| v(s * end(6.0 * t), 6.0 * t, 0.0));
    let out = at_size(&b.finish(&forms), &forms, 1.0);
    let rim = (out.nodes.iter()).filter(|n| n.point.x > 9.99).count();
    assert!((5..=10).contains(&rim), "{rim} nodes");
}

#[test]
fn a_sharp_wedge_is_not_refined_without_end() {
    let (c, forms) = wedge(20.0);
    let out = at_size(&c, &forms, 0.5);
    assert_eq!(out.check(), vec![]);
    assert_eq!(forms::topology(&out), forms::topology(&c));
    let q = quality(&out, &forms);
    // Only the triangle in the tip must have its angle.
    assert!(q.flipped == 0 && q.worst < 5.0 && q.long <= 0.02, "{q:?}");
    assert!(out.triangles.len() < 300, "{}", out.triangles.len());
}

/// A placer that knows nothing but the thickness.
struct Blind;

impl Placer for Blind {
    fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
        start
    }
    fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
        None
    }
    fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
        Some(0.2)
    }
    fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
        f64::INFINITY
    }
}

#[test]
fn without_any_geometry_the_shape_stays_all_the_same() {
    let (c, forms) = washer(200, 30);
    let (mut out, stats) = remesh(c.clone(), &|_, _| 0.6, &Blind, &RemeshOptions::default());
    assert_eq!(stats.unplaced, 0);
    // A wall without normals keeps the winding that it had.
    super::orient(&mut out, &forms);
    let mut forms = forms;
    // Rim nodes are checked against circles with what the slack allows: nodes of the blind placer lie on the chords of the input.
    forms.thickness *= 1e4;
    assert_good(&c, &out, &forms);
    let (c, _) = tube(80, 30);
    let out = remesh(c.clone(), &|_, _| 0.6, &Blind, &RemeshOptions::default()).0;
    assert_eq!(out.check(), vec![]);
    assert_eq!(forms::topology(&out), forms::topology(&c));
    let (before, after) = (length_of_rims(&c), length_of_rims(&out));
    assert!(
        (before - after).abs() < 0.01 * before,
        "{before} became {after}"
    );
}

fn mapped(
    c: &MidComplex,
    forms: &Forms,
    map: &dyn Fn(DVec3) -> DVec3,
    scale: f64,
) -> (MidComplex, Forms) {
    let mut c = c.clone();
    for n in c.nodes.iter_mut() {
        n.point = map(n.point);
    }
    let all = |list: &[Form]| list.iter().map(|f| f.moved(map, scale)).collect();
    let forms = Forms {
        walls: all(&forms.walls),
        faces: all(&forms.faces),
        thickness: forms.thickness * scale,
    };
    (c, forms)
}

#[test]
fn a_scale_by_a_power_of_two_changes_no_bit_of_the_result() {
    let (c, forms) = tee(8);
    let raw = roughen(c, &forms, 800, 0.05);
    let scale = 1.0 / 1024.0;
    let (small, small_forms) = mapped(&raw, &forms, &|p| p * scale, scale);
    let whole = at_size(&clean(raw, &|_, _| 0.1, &forms), &forms, 0.5);
    let cleaned = clean(small, &|_, _| 0.1 * scale, &small_forms);
    let part = at_size(&cleaned, &small_forms, 0.5 * scale);
    assert_eq!(part.triangles, whole.triangles);
    for (p, q) in part.nodes.iter().zip(whole.nodes.iter()) {
        assert_eq!(p.point / scale, q.point);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_motion_and_a_scale_keep_the_counts(angle in 0.1..3.0f64, shift in -50.0..50.0f64, power in -3..4i32) {
        let (c, forms) = tee(8);
        let raw = roughen(c, &forms, 800, 0.05);
        let here = at_size(&raw, &forms, 0.5);
        let scale = 10f64.powi(power);
        let turn = DQuat::from_axis_angle(v(1.0, 2.0, 2.0) / 3.0, angle);
        let (there, there_forms) = mapped(&raw, &forms, &|p| (turn * p + shift) * scale, scale);
        let out = at_size(&there, &there_forms, 0.5 * scale);
        assert_good(&there, &out, &there_forms);
        let (x, y) = (here.triangles.len() as f64, out.triangles.len() as f64);
        prop_assert!((x - y).abs() < 0.05 * x, "{} and {}", x, y);
    }
}
