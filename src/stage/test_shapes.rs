//! Closed-form mid-complexes for the tests of the chart stages.

use crate::geom::cdt::triangulate_region;
use crate::geom::placer::Placer;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support};
use crate::model::ids::{NodeId, WallId};
use glam::{DMat3, DVec2, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// Leaves every point where it is.
pub struct Stay;

impl Placer for Stay {
    fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
        start
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

/// Puts points on a surface given by its nearest point.
pub struct Onto<F: Fn(DVec3) -> DVec3 + Sync>(pub F);

impl<F: Fn(DVec3) -> DVec3 + Sync> Placer for Onto<F> {
    fn place(&self, start: DVec3, _: &[Support]) -> DVec3 {
        self.0(start)
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

/// Builds a complex from loose triangles; points that lie within 1e-9 are one node.
#[derive(Default)]
pub struct Build {
    places: BTreeMap<[i64; 3], NodeId>,
    pub complex: MidComplex,
}

impl Build {
    pub fn node(&mut self, p: DVec3) -> NodeId {
        let key = (p * 1e6).round().to_array().map(|x| x as i64);
        let complex = &mut self.complex;
        *self.places.entry(key).or_insert_with(|| {
            complex.nodes.push(MidNode {
                point: p,
                supports: Default::default(),
            })
        })
    }

    pub fn triangle(&mut self, wall: WallId, points: [DVec3; 3]) {
        let nodes = points.map(|p| self.node(p));
        if nodes[0] == nodes[1] || nodes[1] == nodes[2] || nodes[2] == nodes[0] {
            return;
        }
        self.complex.triangles.push(MidTriangle { nodes, wall });
        for n in nodes {
            let s = &mut self.complex.nodes[n].supports;
            if !s.contains(&Support::Mid(wall)) {
                s.push(Support::Mid(wall));
                s.sort();
            }
        }
    }

    /// The image of the unit square under `f`, in `nu` by `nv` cells, diagonals alternating.
    pub fn sheet(&mut self, wall: u32, nu: usize, nv: usize, f: impl Fn(f64, f64) -> DVec3) {
        for i in 0..nu {
            for j in 0..nv {
                let p = |a: usize, b: usize| f(a as f64 / nu as f64, b as f64 / nv as f64);
                let (a, b, c, d) = (p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1));
                let halves = if (i + j) % 2 == 0 {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                };
                for t in halves {
                    self.triangle(WallId(wall), t);
                }
            }
        }
    }
}

pub fn sheet(nu: usize, nv: usize, f: impl Fn(f64, f64) -> DVec3) -> MidComplex {
    let mut b = Build::default();
    b.sheet(0, nu, nv, f);
    b.complex
}

/// Half of a cylinder of radius 10 and length 30.
pub fn half_cylinder(around: usize, along: usize) -> MidComplex {
    sheet(around, along, |u, v| {
        let (s, c) = (PI * u).sin_cos();
        DVec3::new(10.0 * c, 10.0 * s, 30.0 * v)
    })
}

/// A tube of radius 10 and the given length, open at both ends.
pub fn tube(around: usize, along: usize, length: f64) -> MidComplex {
    sheet(around, along, |u, v| {
        let (s, c) = (TAU * u).sin_cos();
        DVec3::new(10.0 * c, 10.0 * s, length * v)
    })
}

/// A torus of radii 20 and 6.
pub fn torus(around: usize, across: usize) -> MidComplex {
    sheet(around, across, |u, v| {
        let ((s, c), (t, d)) = ((TAU * u).sin_cos(), (TAU * v).sin_cos());
        let r = 20.0 + 6.0 * d;
        DVec3::new(r * c, r * s, 6.0 * t)
    })
}

/// A sphere of radius 10 from a divided octahedron; the upper half only if `half`.
pub fn sphere(n: usize, half: bool) -> MidComplex {
    let mut b = Build::default();
    for sx in [1.0, -1.0] {
        for sy in [1.0, -1.0] {
            for sz in if half { &[1.0][..] } else { &[1.0, -1.0][..] } {
                let at = |i: usize, j: usize| {
                    let k = n - i - j;
                    let p = DVec3::new(i as f64 * sx, j as f64 * sy, k as f64 * sz);
                    10.0 * p.normalize()
                };
                for i in 0..n {
                    for j in 0..n - i {
                        let mut all = vec![[at(i, j), at(i + 1, j), at(i, j + 1)]];
                        if i + j + 2 <= n {
                            all.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                        }
                        for mut t in all {
                            if sx * sy * sz < 0.0 {
                                t.swap(1, 2);
                            }
                            b.triangle(WallId(0), t);
                        }
                    }
                }
            }
        }
    }
    b.complex
}

/// A 100 x 60 plate with three round holes whose rims are divided at `size`; inside, old triangles of the same wall without any order.
pub fn plate_with_holes(size: f64) -> MidComplex {
    let mut points: Vec<DVec2> = Vec::new();
    let mut edges: Vec<[u32; 2]> = Vec::new();
    let mut ring = |loop_points: Vec<DVec2>, points: &mut Vec<DVec2>| {
        let (first, n) = (points.len() as u32, loop_points.len() as u32);
        edges.extend((0..n).map(|i| [first + i, first + (i + 1) % n]));
        points.extend(loop_points);
    };
    let (w, h) = (100.0, 60.0);
    let corners = [(0.0, 0.0), (w, 0.0), (w, h), (0.0, h)].map(DVec2::from);
    let mut outer = Vec::new();
    for k in 0..4 {
        let (a, b) = (corners[k], corners[(k + 1) % 4]);
        let n = (a.distance(b) / size).round() as usize;
        outer.extend((0..n).map(|i| a.lerp(b, i as f64 / n as f64)));
    }
    ring(outer, &mut points);
    for (x, y, r) in [(25.0, 30.0, 10.0), (60.0, 40.0, 8.0), (75.0, 15.0, 6.0)] {
        let n = (TAU * r / size).round() as usize;
        let circle = (0..n).map(|i| {
            let (s, c) = (TAU * i as f64 / n as f64).sin_cos();
            DVec2::new(x + r * c, y + r * s)
        });
        ring(circle.collect(), &mut points);
    }
    // Old inner nodes: a skewed lattice, far from good.
    for i in 0..12 {
        for j in 0..7 {
            let p = DVec2::new(4.0 + 8.3 * i as f64, 3.0 + 8.1 * j as f64 + (i % 3) as f64);
            if points.iter().all(|q| q.distance(p) > 1.0)
                && [(25.0, 30.0, 10.0), (60.0, 40.0, 8.0), (75.0, 15.0, 6.0)]
                    .iter()
                    .all(|(x, y, r)| p.distance(DVec2::new(*x, *y)) > r + 0.5)
            {
                points.push(p);
            }
        }
    }
    let names: Vec<u32> = (0..points.len() as u32).collect();
    let triangles = triangulate_region(&points, &names, &edges, &[]).unwrap();
    let mut b = Build::default();
    for t in triangles {
        b.triangle(WallId(0), t.map(|i| points[i as usize].extend(0.0)));
    }
    b.complex
}

/// A plate 40 x 20 with a rib 10 high along its middle (wall 1), as long as `share` of the plate from x = 0.
pub fn rib_on_plate(share: f64) -> MidComplex {
    let mut b = Build::default();
    b.sheet(0, 20, 10, |u, v| DVec3::new(40.0 * u, 20.0 * v, 0.0));
    let n = (20.0 * share).round() as usize;
    b.sheet(1, n, 5, |u, v| {
        DVec3::new(2.0 * n as f64 * u, 10.0, 10.0 * v)
    });
    b.complex
}

/// A strip with half a twist.
pub fn moebius() -> MidComplex {
    sheet(60, 4, |u, v| {
        let ((s, c), (t, d)) = ((TAU * u).sin_cos(), (PI * u).sin_cos());
        let r = 20.0 + 6.0 * (v - 0.5) * d;
        DVec3::new(r * c, r * s, 6.0 * (v - 0.5) * t)
    })
}

/// The complex turned and moved.
pub fn moved(complex: &MidComplex) -> MidComplex {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -3.0).normalize(), 1.234);
    let mut moved = complex.clone();
    for n in moved.nodes.iter_mut() {
        n.point = turn * n.point + DVec3::new(100.0, -50.0, 7.0);
    }
    moved
}

/// How often each count of triangles round an edge occurs.
pub fn edge_census(complex: &MidComplex) -> BTreeMap<usize, usize> {
    let mut census = BTreeMap::new();
    for e in complex.edges() {
        if e.triangles.len() != 2 {
            *census.entry(e.triangles.len()).or_default() += 1;
        }
    }
    census
}
