//! Contractions that would change the topology are refused.

use super::super::contract::keeps_topology;
use super::super::strata::classify;
use super::super::surface::{Class, Surface};
use super::cases::{plate, tube, v};
use super::forms::{Builder, Form, Forms, topology};
use super::{RemeshOptions, clean, remesh};
use crate::model::complex::MidComplex;
use crate::model::ids::NodeId;
use glam::DVec3;

fn surface(c: MidComplex) -> Surface {
    let mut s = Surface::new(c);
    classify(&mut s, 0.9, &|_| 0.0);
    s
}

fn allowed(s: &Surface) -> Vec<[NodeId; 2]> {
    s.edges()
        .into_iter()
        .filter(|&[a, b]| keeps_topology(s, a, b) || keeps_topology(s, b, a))
        .collect()
}

fn flat() -> Forms {
    Forms {
        walls: vec![Form::Plane(DVec3::ZERO, DVec3::Z); 2],
        faces: vec![],
        thickness: 0.1,
    }
}

/// A square ring round a hole of three edges.
fn three_edged_hole(radius: f64) -> MidComplex {
    let mut b = Builder::default();
    let at = |r: f64, k: usize, n: usize| {
        let a = std::f64::consts::TAU * k as f64 / n as f64;
        v(r * a.cos(), r * a.sin(), 0.0)
    };
    for k in 0..3 {
        let (i, j) = (at(radius, k, 3), at(radius, k + 1, 3));
        let (o, p, q) = (
            at(4.0, 2 * k, 6),
            at(4.0, 2 * k + 1, 6),
            at(4.0, 2 * k + 2, 6),
        );
        b.triangle([i, o, p], 0);
        b.triangle([i, p, j], 0);
        b.triangle([j, p, q], 0);
    }
    b.finish(&flat())
}

#[test]
fn a_hole_of_three_edges_stays() {
    let c = three_edged_hole(0.01);
    let s = surface(c.clone());
    for [a, b] in s.edges() {
        if s.length(a, b) < 0.1 {
            assert!(!keeps_topology(&s, a, b));
        }
    }
    for out in [
        clean(c.clone(), &|_, _| 1.0, &flat()),
        remesh(c.clone(), &|_, _| 1.0, &flat(), &RemeshOptions::default()).0,
    ] {
        assert_eq!(out.check(), vec![]);
        assert_eq!(topology(&out), topology(&c));
    }
}

#[test]
fn a_bubble_stays() {
    // The four faces of a tetrahedron on one wall: every edge has its two apexes, but all contractions flatten it.
    let mut b = Builder::default();
    let p = [
        v(0.0, 0.0, 0.0),
        v(1.0, 0.0, 0.0),
        v(0.0, 1.0, 0.0),
        v(0.0, 0.0, 1.0),
    ];
    for t in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] {
        b.triangle(t.map(|i| p[i]), 0);
    }
    let s = surface(b.finish(&flat()));
    assert!(s.class.iter().all(|&c| c == Class::Sheet));
    assert_eq!(allowed(&s), Vec::<[NodeId; 2]>::new());
}

#[test]
fn a_neck_of_three_edges_stays() {
    let (c, forms) = tube(3, 6);
    let s = surface(c.clone());
    for [a, b] in s.edges() {
        let level = (s.points[a].z - s.points[b].z).abs() < 1e-9;
        if level {
            assert!(!keeps_topology(&s, a, b) && !keeps_topology(&s, b, a));
        }
    }
    let (thin, _) = tube(12, 40);
    let out = remesh(
        thin.clone(),
        &|_, _| 30.0,
        &forms,
        &RemeshOptions::default(),
    )
    .0;
    assert_eq!(topology(&out), topology(&thin));
}

#[test]
fn a_chord_between_two_rims_stays_and_a_rim_chord_too() {
    // A strip one triangle wide: contracting across it would pinch it.
    let (c, _) = plate(10, 1);
    let s = surface(c);
    for [a, b] in s.edges() {
        if (s.points[a].y - s.points[b].y).abs() > 1.0 {
            assert!(!keeps_topology(&s, a, b) && !keeps_topology(&s, b, a));
        }
    }
    assert!(!allowed(&s).is_empty());
}

#[test]
fn a_pinched_node_is_a_corner() {
    let mut b = Builder::default();
    let o = DVec3::ZERO;
    for side in [-1.0, 1.0] {
        let p = [
            v(side, -1.0, side),
            v(side, 1.0, side),
            v(side, 0.0, 2.0 * side),
        ];
        for k in 0..3 {
            b.triangle([o, p[k], p[(k + 1) % 3]], 0);
        }
    }
    let s = surface(b.finish(&flat()));
    assert_eq!(s.class[NodeId(0)], Class::Corner);
}
