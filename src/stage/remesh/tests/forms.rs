//! Closed-form placers, complexes over them, and what must hold after a remeshing.

use super::super::shape::{angles, area_vector, edge_ratio};
use super::super::surface::{Class, Surface};
use crate::geom::placer::Placer;
use crate::model::complex::{EdgeKind, MidComplex, MidNode, MidTriangle, Support, Supports};
use crate::model::ids::{FaceId, Id, NodeId, WallId};
use glam::DVec3;
use std::collections::BTreeMap;

#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A point and the unit normal.
    Plane(DVec3, DVec3),
    /// A point of the axis, its unit direction, the radius.
    Cylinder(DVec3, DVec3, f64),
    /// Centre, radius.
    Sphere(DVec3, f64),
}

impl Form {
    /// Signed distance and unit normal.
    pub fn distance(&self, p: DVec3) -> (f64, DVec3) {
        match *self {
            Form::Plane(o, n) => ((p - o).dot(n), n),
            Form::Cylinder(o, a, r) => {
                let d = (p - o) - a * (p - o).dot(a);
                (d.length() - r, d.normalize_or_zero())
            }
            Form::Sphere(o, r) => ((p - o).length() - r, (p - o).normalize_or_zero()),
        }
    }
    pub fn moved(&self, map: &dyn Fn(DVec3) -> DVec3, scale: f64) -> Self {
        let turn = |o: DVec3, n: DVec3| (map(o + n) - map(o)) / scale;
        match *self {
            Form::Plane(o, n) => Form::Plane(map(o), turn(o, n)),
            Form::Cylinder(o, a, r) => Form::Cylinder(map(o), turn(o, a), r * scale),
            Form::Sphere(o, r) => Form::Sphere(map(o), r * scale),
        }
    }
}

/// Walls and lateral faces by closed forms.
#[derive(Clone, Debug)]
pub struct Forms {
    pub walls: Vec<Form>,
    pub faces: Vec<Form>,
    pub thickness: f64,
}

impl Placer for Forms {
    fn place(&self, start: DVec3, supports: &[Support]) -> DVec3 {
        let mut p = start;
        for _ in 0..60 {
            for s in supports {
                let form = match s {
                    Support::Mid(w) => self.walls[w.index()],
                    Support::Face(f) => self.faces[f.index()],
                    Support::Edge(_) | Support::Pin(_) => continue,
                };
                let (d, n) = form.distance(p);
                p -= n * d;
            }
            if supports.len() < 2 {
                break;
            }
        }
        p
    }
    fn normal(&self, point: DVec3, wall: WallId) -> Option<DVec3> {
        Some(self.walls[wall.index()].distance(point).1)
    }
    fn thickness(&self, _: DVec3, _: WallId) -> Option<f64> {
        Some(self.thickness)
    }
    fn curvature_radius(&self, _: DVec3, wall: WallId) -> f64 {
        match self.walls[wall.index()] {
            Form::Plane(..) => f64::INFINITY,
            Form::Cylinder(_, _, r) | Form::Sphere(_, r) => r,
        }
    }
}

/// Collects triangles by their corner positions.
#[derive(Default)]
pub struct Builder {
    ids: BTreeMap<[i64; 3], NodeId>,
    pub complex: MidComplex,
}

impl Builder {
    fn node(&mut self, p: DVec3) -> NodeId {
        let key = [p.x, p.y, p.z].map(|x| (x * 1e7).round() as i64);
        *self.ids.entry(key).or_insert_with(|| {
            self.complex.nodes.push(MidNode {
                point: p,
                supports: Supports::new(),
            })
        })
    }
    pub fn triangle(&mut self, p: [DVec3; 3], wall: u32) {
        let nodes = p.map(|p| self.node(p));
        if nodes[0] != nodes[1] && nodes[1] != nodes[2] && nodes[2] != nodes[0] {
            self.complex.triangles.push(MidTriangle {
                nodes,
                wall: WallId(wall),
            });
        }
    }
    /// The image of the unit square in `nu` by `nv` cells.
    pub fn grid(&mut self, nu: usize, nv: usize, wall: u32, map: impl Fn(f64, f64) -> DVec3) {
        let at = |i: usize, j: usize| map(i as f64 / nu as f64, j as f64 / nv as f64);
        for i in 0..nu {
            for j in 0..nv {
                let p = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                if (i + j) % 2 == 0 {
                    self.triangle([p[0], p[1], p[2]], wall);
                    self.triangle([p[0], p[2], p[3]], wall);
                } else {
                    self.triangle([p[0], p[1], p[3]], wall);
                    self.triangle([p[1], p[2], p[3]], wall);
                }
            }
        }
    }
    /// Supports from the walls of the triangles and the faces that rim nodes lie on.
    pub fn finish(mut self, forms: &Forms) -> MidComplex {
        let c = &mut self.complex;
        let edges = c.edges();
        for t in c.triangles.iter() {
            for n in t.nodes {
                c.nodes[n].supports.push(Support::Mid(t.wall));
            }
        }
        for e in edges.iter().filter(|e| e.triangles.len() == 1) {
            for n in e.ends {
                for (f, form) in forms.faces.iter().enumerate() {
                    if form.distance(c.nodes[n].point).0.abs() < 1e-7 {
                        let s = Support::Face(FaceId::new(f));
                        c.nodes[n].supports.push(s);
                    }
                }
            }
        }
        for n in c.nodes.iter_mut() {
            n.supports.sort_unstable();
            n.supports.dedup();
        }
        self.complex
    }
}

/// A small generator of numbers in 0..1 that are the same on every run.
pub struct Dice(pub u64);

impl Dice {
    pub fn roll(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Splits random edges at random, often extreme, places: needles of every length, as marching through tets makes them. Then moves
/// sheet nodes off the surface by `noise`.
pub fn roughen(complex: MidComplex, forms: &Forms, splits: usize, noise: f64) -> MidComplex {
    let mut dice = Dice(7);
    let mut s = Surface::new(complex);
    for _ in 0..4 {
        let edges = s.edges();
        for _ in 0..splits / 4 {
            let [a, b] = edges[(dice.roll() * edges.len() as f64) as usize];
            let ring = s.around(a, b);
            if ring.is_empty() {
                continue;
            }
            let f = [1e-6, 1e-3, 0.03, 0.5][(dice.roll() * 4.0) as usize];
            let mut supports: Supports = s.supports[a]
                .iter()
                .copied()
                .filter(|x| s.supports[b].contains(x))
                .collect();
            supports.retain(|x| match x {
                Support::Face(_) | Support::Edge(_) | Support::Pin(_) => ring.len() == 1,
                Support::Mid(w) => ring.iter().any(|&t| s.triangle(t).wall == *w),
            });
            let p = forms.place(s.points[a].lerp(s.points[b], f), &supports);
            s.split([a, b], p, supports, Class::Sheet);
        }
    }
    for n in s.live_nodes().collect::<Vec<_>>() {
        if s.feature_neighbours(n).is_empty() {
            let room = s
                .neighbours(n)
                .iter()
                .map(|&m| s.length(n, m))
                .fold(noise, f64::min);
            let off = DVec3::new(dice.roll(), dice.roll(), dice.roll()) - 0.5;
            s.points[n] += off * room;
        }
    }
    s.finish()
}

/// Numbers that no remeshing may change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topology {
    pub euler: i64,
    pub pieces: usize,
    /// For rims, junctions, creases: components and independent loops.
    pub curves: [[i64; 2]; 3],
    /// Nodes where the number of feature edges is not two, by that number.
    pub forks: Vec<usize>,
}

pub fn topology(c: &MidComplex) -> Topology {
    let mut curves = [[0; 2]; 3];
    let mut degree = vec![0; c.nodes.len()];
    for (k, kind) in [EdgeKind::Rim, EdgeKind::Junction, EdgeKind::Crease]
        .into_iter()
        .enumerate()
    {
        let edges: Vec<_> = c
            .edges()
            .into_iter()
            .filter(|e| c.kind(e) == kind)
            .map(|e| e.ends)
            .collect();
        let mut root: Vec<usize> = (0..c.nodes.len()).collect();
        fn find(root: &mut [usize], mut x: usize) -> usize {
            while root[x] != x {
                root[x] = root[root[x]];
                x = root[x];
            }
            x
        }
        let mut nodes: Vec<NodeId> = edges.iter().flatten().copied().collect();
        nodes.sort_unstable();
        nodes.dedup();
        let mut components = nodes.len() as i64;
        for [a, b] in &edges {
            degree[a.index()] += 1;
            degree[b.index()] += 1;
            let (x, y) = (find(&mut root, a.index()), find(&mut root, b.index()));
            if x != y {
                root[x.max(y)] = x.min(y);
                components -= 1;
            }
        }
        let loops = edges.len() as i64 - nodes.len() as i64 + components;
        curves[k] = [components, loops];
    }
    let mut forks: Vec<usize> = degree.into_iter().filter(|&d| d != 0 && d != 2).collect();
    forks.sort_unstable();
    Topology {
        euler: c.euler(),
        pieces: c.pieces(),
        curves,
        forks,
    }
}

/// Summed length of the edges of a kind.
pub fn length(c: &MidComplex, kind: EdgeKind) -> f64 {
    c.edges()
        .iter()
        .filter(|e| c.kind(e) == kind)
        .map(|e| c.nodes[e.ends[0]].point.distance(c.nodes[e.ends[1]].point))
        .sum()
}

pub fn area(c: &MidComplex) -> f64 {
    c.triangles
        .iter()
        .map(|t| area_vector(t.nodes.map(|n| c.nodes[n].point)).length() / 2.0)
        .sum()
}

/// Share of triangles with edge ratio above 2.5, share with angles outside 30..110, worst edge ratio, triangles turned over.
#[derive(Debug)]
pub struct Quality {
    pub long: f64,
    pub angled: f64,
    pub worst: f64,
    pub flipped: usize,
    pub worst_at: DVec3,
}

pub fn quality(c: &MidComplex, placer: &dyn Placer) -> Quality {
    let mut q = Quality {
        long: 0.0,
        angled: 0.0,
        worst: 1.0,
        flipped: 0,
        worst_at: DVec3::ZERO,
    };
    for t in c.triangles.iter() {
        let p = t.nodes.map(|n| c.nodes[n].point);
        let ratio = edge_ratio(p);
        let [least, most] = angles(p).map(f64::to_degrees);
        q.long += (ratio > 2.5) as u8 as f64;
        q.angled += (least < 30.0 || most > 110.0) as u8 as f64;
        let centre = (p[0] + p[1] + p[2]) / 3.0;
        if ratio > q.worst {
            q.worst = ratio;
            q.worst_at = centre;
        }
        if let Some(n) = placer.normal(centre, t.wall) {
            q.flipped += (area_vector(p).dot(n) <= 0.0) as usize;
        }
    }
    q.long /= c.triangles.len() as f64;
    q.angled /= c.triangles.len() as f64;
    q
}

/// All that must hold after a remeshing, as one assertion each.
pub fn assert_good(before: &MidComplex, after: &MidComplex, forms: &Forms) {
    assert_eq!(after.check(), vec![]);
    assert_eq!(topology(after), topology(before));
    for kind in [EdgeKind::Rim, EdgeKind::Junction, EdgeKind::Crease] {
        let (x, y) = (length(before, kind), length(after, kind));
        assert!((x - y).abs() <= 0.005 * x, "{kind:?}: {x} became {y}");
    }
    let q = quality(after, forms);
    assert_eq!(q.flipped, 0, "{q:?}");
    assert!(
        q.long <= 0.01 && q.worst <= 5.0,
        "{q:?} of {}",
        after.triangles.len()
    );
    assert!(q.angled <= 0.02, "{q:?} of {}", after.triangles.len());
    for n in after.nodes.iter() {
        let off = forms.place(n.point, &n.supports).distance(n.point);
        assert!(off < 1e-6 * forms.thickness, "{n:?} is off by {off}");
    }
}
