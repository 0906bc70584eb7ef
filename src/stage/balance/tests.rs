use super::*;
use crate::geom::random::Pcg;
use crate::model::complex::Support;
use crate::stage::test_shapes::{Build, edge_census, moved, plate_with_holes, sheet, sphere, tube};
use glam::DMat3;
use std::f64::consts::TAU;

const THICKNESS: f64 = 2.0;

/// Surfaces in closed form: the normal, and the way to the surface along it.
struct Closed<F: Fn(DVec3, WallId) -> Option<Way> + Sync>(F);

impl<F: Fn(DVec3, WallId) -> Option<Way> + Sync> Placer for Closed<F> {
    fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
        (self.0)(start, WallId(0)).map_or(start, |(n, d)| start + n * d)
    }
    fn normal(&self, point: DVec3, wall: WallId) -> Option<DVec3> {
        (self.0)(point, wall).map(|w| w.0)
    }
    fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
        Some(THICKNESS)
    }
    fn curvature_radius(&self, _: DVec3, _: WallId) -> f64 {
        f64::INFINITY
    }
    fn to_middle(&self, point: DVec3, wall: WallId) -> Option<Way> {
        (self.0)(point, wall)
    }
}

/// The cylinder of radius 10 round the z axis.
fn round(p: DVec3, _: WallId) -> Option<Way> {
    let out = DVec3::new(p.x, p.y, 0.0);
    Some((out.normalize(), 10.0 - out.length()))
}

/// The sphere of radius 10.
fn ball(p: DVec3, _: WallId) -> Option<Way> {
    Some((p.normalize(), 10.0 - p.length()))
}

/// The mean and the largest way to the surface over the mesh, by area.
fn errors(complex: &MidComplex, placer: &dyn Placer) -> (f64, f64) {
    let mut rng = Pcg::new(5);
    let (mut sum, mut all, mut most) = (0.0, 0.0, 0.0f64);
    for t in complex.triangles.iter() {
        let [a, b, c] = t.nodes.map(|n| complex.nodes[n].point);
        let area = (b - a).cross(c - a).length();
        for _ in 0..20 {
            let (mut u, mut v) = (rng.unit(), rng.unit());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let p = a + (b - a) * u + (c - a) * v;
            let (_, d) = placer.to_middle(p, t.wall).unwrap();
            sum += area * d;
            all += area;
            most = most.max(d.abs());
        }
    }
    (sum / all, most)
}

fn points(complex: &MidComplex) -> Vec<DVec3> {
    complex.nodes.iter().map(|n| n.point).collect()
}

#[track_caller]
fn same(a: &MidComplex, b: &MidComplex, within: f64) {
    for (p, q) in points(a).into_iter().zip(points(b)) {
        assert!(p.distance(q) < within, "{p} {q}");
    }
}

#[test]
fn on_a_tube_the_error_is_halved_and_has_both_signs() {
    // Chords of 15 degrees: the sagitta is R (1 - cos 7.5°).
    let chord = 10.0 * (1.0 - 7.5f64.to_radians().cos());
    let complex = tube(24, 12, 30.0);
    let before = errors(&complex, &Closed(round));
    assert!((before.1 / chord - 1.0).abs() < 0.02, "{before:?}");
    let after = errors(&balance(complex, &Closed(round)), &Closed(round));
    assert!(after.1 < 0.7 * before.1, "{after:?}");
    assert!(after.0.abs() < 0.02 * chord, "{after:?}");
}

#[test]
fn on_a_sphere_the_mean_error_vanishes() {
    let complex = sphere(6, false);
    let before = errors(&complex, &Closed(ball));
    let after = errors(&balance(complex, &Closed(ball)), &Closed(ball));
    assert!(before.0 > 0.4 * before.1, "{before:?}");
    assert!(after.0.abs() < 0.05 * before.0, "{after:?} {before:?}");
    assert!(after.1 < 0.8 * before.1, "{after:?} {before:?}");
}

#[test]
fn flat_walls_stay_to_the_bit() {
    let complex = plate_with_holes(8.0);
    let flat = Closed(|p: DVec3, _| Some((DVec3::Z, -p.z)));
    assert_eq!(balance(complex.clone(), &flat), complex);
}

#[test]
fn topology_walls_and_supports_stay() {
    let before = tube(24, 12, 30.0);
    let after = balance(before.clone(), &Closed(round));
    assert_eq!(after.triangles, before.triangles);
    assert_eq!(edge_census(&after), edge_census(&before));
    let supports = |c: &MidComplex| {
        c.nodes
            .iter()
            .map(|n| n.supports.clone())
            .collect::<Vec<_>>()
    };
    assert_eq!(supports(&after), supports(&before));
}

#[test]
fn turning_moving_scaling_and_swapping_the_sides_change_nothing() {
    let here = balance(tube(24, 12, 30.0), &Closed(round));
    let swapped = Closed(|p, w| round(p, w).map(|(n, d)| (-n, -d)));
    same(&balance(tube(24, 12, 30.0), &swapped), &here, 1e-12);

    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -3.0).normalize(), 1.234);
    let shift = DVec3::new(100.0, -50.0, 7.0);
    let there = Closed(|p: DVec3, w| {
        let (n, d) = round(turn.transpose() * (p - shift), w)?;
        Some((turn * n, d))
    });
    same(
        &balance(moved(&tube(24, 12, 30.0)), &there),
        &moved(&here),
        1e-9,
    );

    let mut small = tube(24, 12, 30.0);
    for node in small.nodes.iter_mut() {
        node.point *= 0.125;
    }
    let tiny = Closed(|p: DVec3, w| round(p * 8.0, w).map(|(n, d)| (n, d / 8.0)));
    let small = balance(small, &tiny);
    for (p, q) in points(&small).into_iter().zip(points(&here)) {
        assert!((p * 8.0).distance(q) < 1e-12);
    }
}

#[test]
fn where_a_tube_stands_on_a_plate_the_junction_stays_in_the_plate() {
    let at = |r: f64, u: f64, z: f64| {
        let (s, c) = (TAU * u).sin_cos();
        DVec3::new(r * c, r * s, z)
    };
    let mut build = Build::default();
    build.sheet(0, 24, 4, |u, v| at(10.0 + 8.0 * v, u, 0.0));
    build.sheet(1, 24, 4, |u, v| at(10.0, u, 8.0 * v));
    let both = Closed(|p, w| {
        if w == WallId(0) {
            Some((DVec3::Z, -p.z))
        } else {
            round(p, w)
        }
    });
    let before = build.complex;
    let after = balance(before.clone(), &both);
    let mut moved = 0;
    for (p, q) in points(&before).into_iter().zip(points(&after)) {
        if p.z == 0.0 {
            assert!(q.z.abs() < 1e-12, "{q}");
            let out = q.truncate().length() - p.truncate().length();
            assert!(out >= -1e-12, "{p} {q}");
            moved += usize::from(out > 1e-3);
        }
    }
    assert_eq!(moved, 24, "the foot of the tube goes with the tube");
}

#[test]
fn what_does_not_follow_the_wall_is_left_alone() {
    let complex = tube(24, 12, 30.0);
    let far = Closed(|p, w| round(p, w).map(|(n, d)| (n, d + 1.01 * BENT * THICKNESS)));
    assert_eq!(balance(complex.clone(), &far), complex);
    let nowhere = Closed(|_, _| None);
    assert_eq!(balance(complex.clone(), &nowhere), complex);
}

#[test]
fn no_triangle_is_turned() {
    // A ledge of a twentieth of the thickness under cells that grow from nothing to twice the thickness: the small ones would have to stand up.
    let ledge = Closed(|p: DVec3, _| {
        let height = if p.x > 0.0 { 0.1 } else { 0.0 };
        Some((DVec3::Z, height - p.z))
    });
    let complex = sheet(21, 2, |u, v| {
        DVec3::new(20.0 * (2.0 * u - 1.0).powi(3), 10.0 * v, 0.0)
    });
    let after = balance(complex.clone(), &ledge);
    let normal = |c: &MidComplex, t: TriangleId| {
        let [a, b, d] = c.triangles[t].nodes.map(|n| c.nodes[n].point);
        (b - a).cross(d - a).normalize()
    };
    for t in complex.triangles.ids() {
        assert!(normal(&after, t).dot(normal(&complex, t)) >= STEADY);
    }
    let free = ways(&complex, &ledge);
    assert!(
        free.iter().any(|w| w.is_some_and(|w| w.1 > 0.09)),
        "the ledge asks for it"
    );
    assert!(
        points(&after).iter().any(|p| p.z > 0.09),
        "away from the ledge it is followed"
    );
}

#[test]
fn no_triangle_is_folded() {
    // A crumpled sheet, some of whose triangles stand nearly upright on their neighbours, over a surface that wants every place elsewhere.
    let mut complex = sheet(40, 40, |u, v| DVec3::new(40.0 * u, 40.0 * v, 0.0));
    let mut rng = Pcg::new(3);
    for node in complex.nodes.iter_mut() {
        node.point.z = 1.6 * rng.unit();
    }
    let wild = Closed(|p: DVec3, _| {
        let away = BENT * THICKNESS * (37.0 * p.x + 91.0 * p.y).sin();
        Some((DVec3::new(0.0, 0.6, 0.8), away))
    });
    let before = folded(&complex);
    let unguarded = {
        let (ways, stars, area) = (ways(&complex, &wild), complex.stars(), areas(&complex));
        let shifts: Vec<DVec3> = stars.iter().map(|s| shift(s, &ways, &area)).collect();
        let mut shifts = shifts.into();
        steady(&complex, &area, &mut shifts);
        super::moved(&complex, &shifts)
    };
    let new = |c: &MidComplex| {
        let all = folded(c);
        all.iter()
            .filter(|t| before.binary_search(t).is_err())
            .count()
    };
    assert!(new(&unguarded) > 0, "the case needs the guard");
    let after = balance(complex.clone(), &wild);
    assert_eq!(new(&after), 0);
    assert!(points(&after) != points(&complex));
}
