use super::*;
use crate::geom::placer::Lengths;
use crate::model::ids::WallId;
use crate::stage::chart_mesh::Pattern;
use crate::stage::test_shapes::{self as shapes, Onto, Stay};
use glam::DVec3;

/// Edge ratio and angles (degrees) of a triangle.
fn quality(complex: &MidComplex, t: &MidTriangle) -> (f64, f64, f64) {
    let p = t.nodes.map(|n| complex.nodes[n].point);
    let sides = [0, 1, 2].map(|k| p[k].distance(p[(k + 1) % 3]));
    let angles = [0, 1, 2].map(|k| {
        let (a, b) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        a.angle_between(b).to_degrees()
    });
    let most = |v: [f64; 3]| v[0].max(v[1]).max(v[2]);
    let least = |v: [f64; 3]| v[0].min(v[1]).min(v[2]);
    (most(sides) / least(sides), least(angles), most(angles))
}

/// Share of triangles out of the limits (ratio 2.5, angles 30 to 110 degrees), and mean edge length.
fn census(complex: &MidComplex) -> (f64, f64, f64) {
    let all: Vec<_> = complex
        .triangles
        .iter()
        .map(|t| quality(complex, t))
        .collect();
    let bad = all
        .iter()
        .filter(|q| q.0 > 2.5 || q.1 < 30.0 || q.2 > 110.0);
    let share = bad.count() as f64 / all.len() as f64;
    let mean_least = all.iter().map(|q| q.1).sum::<f64>() / all.len() as f64;
    let edges = complex.edges();
    let length = |e: &crate::model::complex::MidEdge| {
        complex.nodes[e.ends[0]]
            .point
            .distance(complex.nodes[e.ends[1]].point)
    };
    let mean = edges.iter().map(length).sum::<f64>() / edges.len() as f64;
    (share, mean_least, mean)
}

fn area(complex: &MidComplex) -> f64 {
    complex
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.nodes.map(|n| complex.nodes[n].point);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum()
}

/// Meshes, and checks what must always hold.
fn run(complex: &MidComplex, size: f64, placer: &dyn Placer) -> Outcome {
    let out = mesh_charts(
        complex,
        Pattern::Triangles,
        &|_, _| Lengths::equal(size),
        placer,
    );
    assert_eq!(out.complex.check(), vec![]);
    assert_eq!(out.complex.euler(), complex.euler());
    assert_eq!(out.complex.pieces(), complex.pieces());
    assert_eq!(
        shapes::edge_census(&out.complex),
        shapes::edge_census(complex)
    );
    // Every feature edge is there, with its nodes where they were.
    let edges = out.complex.edges();
    for e in complex.edges() {
        if e.triangles.len() != 2 {
            let mut ends = e.ends.map(|n| out.nodes[n].unwrap());
            ends.sort();
            assert!(
                edges
                    .iter()
                    .any(|f| f.ends == ends && f.triangles.len() == e.triangles.len())
            );
        }
    }
    for (id, n) in complex.nodes.enumerated() {
        if let Some(new) = out.nodes[id] {
            assert_eq!(&out.complex.nodes[new], n);
        }
    }
    out
}

fn onto_cylinder(p: DVec3) -> DVec3 {
    let r = 10.0 / p.x.hypot(p.y);
    DVec3::new(p.x * r, p.y * r, p.z)
}

#[test]
fn a_plate_with_holes_gets_good_triangles() {
    let c = shapes::plate_with_holes(3.0);
    let out = run(&c, 3.0, &Stay);
    assert_eq!((out.patches, out.cut, out.kept.len()), (1, 0, 0));
    assert!((area(&out.complex) - area(&c)).abs() < 1e-9 * area(&c));
    let (share, least, mean) = census(&out.complex);
    assert!(share < 0.01 && least > 50.0, "{share} {least}");
    assert!((mean / 3.0 - 1.0).abs() < 0.1, "{mean}");
}

#[test]
fn half_a_cylinder_stays_round() {
    let c = shapes::half_cylinder(16, 15);
    let out = run(&c, 2.0, &Onto(onto_cylinder));
    assert!(out.kept.is_empty());
    assert!(
        out.complex
            .nodes
            .iter()
            .all(|n| (n.point.x.hypot(n.point.y) - 10.0).abs() < 1e-9)
    );
    let (share, least, _) = census(&out.complex);
    assert!(share < 0.01 && least > 50.0, "{share} {least}");
}

#[test]
fn a_hemisphere() {
    let c = shapes::sphere(10, true);
    let out = run(&c, 1.6, &Onto(|p| 10.0 * p.normalize()));
    assert!(out.kept.is_empty());
    let (share, least, _) = census(&out.complex);
    assert!(share < 0.02 && least > 48.0, "{share} {least}");
}

#[test]
fn a_tube_is_cut_and_no_trace_of_the_cut_is_left() {
    let c = shapes::tube(24, 60, 120.0);
    let out = run(&c, 2.6, &Onto(onto_cylinder));
    assert!(out.cut >= 1 && out.kept.is_empty());
    let (share, least, _) = census(&out.complex);
    assert!(share < 0.02 && least > 48.0, "{share} {least}");
}

#[test]
fn a_torus() {
    let c = shapes::torus(60, 18);
    let onto = |p: DVec3| {
        let ring = 20.0 * DVec3::new(p.x, p.y, 0.0).normalize();
        ring + 6.0 * (p - ring).normalize()
    };
    let out = run(&c, 2.0, &Onto(onto));
    assert!(out.kept.is_empty());
    let (share, least, _) = census(&out.complex);
    assert!(share < 0.03 && least > 46.0, "{share} {least}");
}

#[test]
fn a_sphere() {
    let c = shapes::sphere(10, false);
    let out = run(&c, 1.6, &Onto(|p| 10.0 * p.normalize()));
    assert!(out.cut >= 1 && out.kept.is_empty());
    let (share, least, _) = census(&out.complex);
    assert!(share < 0.03 && least > 46.0, "{share} {least}");
}

#[test]
fn t_junctions_through_and_partial() {
    for share in [1.0, 0.5] {
        let c = shapes::rib_on_plate(share);
        let out = run(&c, 2.0, &Stay);
        assert_eq!((out.cut, out.kept.len()), (0, 0));
        let (share, least, _) = census(&out.complex);
        assert!(share < 0.01 && least > 50.0, "{share} {least}");
    }
}

#[test]
fn a_twisted_strip_keeps_its_topology() {
    let _ = run(&shapes::moebius(), 1.8, &Stay);
}

#[test]
fn sizes_grow_from_a_fine_rim() {
    let c = shapes::plate_with_holes(2.0);
    let out = mesh_charts(&c, Pattern::Triangles, &|_, _| Lengths::equal(8.0), &Stay);
    assert!(out.kept.is_empty());
    let (share, least, _) = census(&out.complex);
    assert!(least > 45.0, "{least}");
    assert!(share < 0.05, "{share}");
    assert!(out.complex.triangles.len() < 1600);
}

#[test]
fn the_same_for_any_number_of_threads() {
    let c = shapes::torus(40, 14);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| mesh_charts(&c, Pattern::Triangles, &|_, _| Lengths::equal(3.0), &Stay))
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn counts_do_not_change_when_the_part_is_moved() {
    for c in [
        shapes::plate_with_holes(4.0),
        shapes::rib_on_plate(0.5),
        shapes::half_cylinder(16, 15),
        shapes::tube(24, 20, 40.0),
        shapes::torus(40, 14),
        shapes::sphere(8, true),
    ] {
        let a = mesh_charts(&c, Pattern::Triangles, &|_, _| Lengths::equal(4.0), &Stay);
        let b = mesh_charts(
            &shapes::moved(&c),
            Pattern::Triangles,
            &|_, _| Lengths::equal(4.0),
            &Stay,
        );
        assert_eq!((a.patches, a.cut), (b.patches, b.cut));
        assert_eq!(a.complex.nodes.len(), b.complex.nodes.len());
        assert_eq!(a.complex.triangles.len(), b.complex.triangles.len());
    }
}

/// A placer that turns the surface inside out must not spoil it.
#[test]
fn old_triangles_stay_where_the_new_ones_fail() {
    let c = shapes::rib_on_plate(1.0);
    struct Wild;
    impl Placer for Wild {
        fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
            start + 30.0 * DVec3::new((start.y * 7.0).sin(), (start.x * 9.0).cos(), 0.0)
        }
        fn normal(&self, _: DVec3, _: WallId) -> Option<DVec3> {
            None
        }
        fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
            None
        }
        fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
            f64::INFINITY
        }
    }
    let out = mesh_charts(&c, Pattern::Triangles, &|_, _| Lengths::equal(2.0), &Wild);
    assert!(!out.kept.is_empty());
    assert_eq!(out.complex.check(), vec![]);
    assert_eq!(out.complex.euler(), c.euler());
}

/// Where a cut is only a few edges from the next, two pieces could draw the same chord: one edge of four triangles.
#[test]
fn small_closed_things_keep_their_topology() {
    for around in [3, 4, 5, 6, 8, 10] {
        let c = shapes::tube(around, 12, 60.0);
        let _ = run(&c, 60.0 / around as f64, &Stay);
        let _ = run(&c, 20.0, &Stay);
    }
    for n in [1, 2, 3] {
        let _ = run(&shapes::sphere(n, false), 14.0 / n as f64, &Stay);
        let _ = run(&shapes::sphere(n, false), 30.0, &Stay);
    }
    for across in [3, 4, 6] {
        let _ = run(
            &shapes::torus(4 * across, across),
            36.0 / across as f64,
            &Stay,
        );
    }
}

#[test]
fn two_pieces_that_draw_one_chord_both_step_back() {
    // Two squares side by side, each meshed with a diagonal chord; renaming makes both chords join the same nodes.
    let c = shapes::sheet(1, 1, |u, v| DVec3::new(u, v, 0.0));
    let patch = patches(&c)[PatchId(0)].clone();
    let mesh = Some(PatchMesh {
        points: vec![],
        triangles: patch.triangles.clone(),
    });
    let piece = || Piece {
        patch: patch.clone(),
        mesh: mesh.clone(),
    };
    let mut alone = [piece()];
    drop_clashes(&mut alone);
    assert!(alone[0].mesh.is_some());
    let mut both = [piece(), piece()];
    drop_clashes(&mut both);
    assert!(both.iter().all(|p| p.mesh.is_none()));
}
