//! The mesh measured from itself: is it midway, inside, and as thick as it says?

use super::places::{Finding, node_key};
use super::sampling::{Sample, median, quantile, spread};
use super::skin::Skin;
use crate::model::ids::{ElementId, NodeId};
use crate::model::shell::{Corners, ShellMesh};
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Nearer to a junction or a fold than so many thicknesses a point is not midway between two walls; the second number is for parts so
/// small that the first leaves next to nothing.
const AWAY: [f64; 2] = [1.5, 0.75];
/// What "next to nothing" means.
const ENOUGH: f64 = 0.05;
/// A point may be outside by this share of the thickness: facets sag, and so do elements.
const OUTSIDE: f64 = 0.1;
/// Upper ends of the R-error bins; the last is open.
const BINS: [f64; 4] = [0.005, 0.01, 0.1, 0.2];

/// The mesh as triangles; a quad is two.
pub(super) struct Flat {
    pub triangles: Vec<[DVec3; 3]>,
    pub areas: Vec<f64>,
    pub normals: Vec<DVec3>,
    /// Mean thickness of the element that each came from.
    pub thickness: Vec<f64>,
    pub elements: Vec<ElementId>,
}

impl Flat {
    /// The triangles of the elements that are `sound`.
    pub fn new(mesh: &ShellMesh, sound: impl Fn(ElementId) -> bool) -> Self {
        let (mut triangles, mut elements) = (Vec::new(), Vec::new());
        for (id, element) in mesh.elements.enumerated() {
            if !sound(id) {
                continue;
            }
            let mut add = |n: [NodeId; 3]| {
                triangles.push(n.map(|n| mesh.nodes[n]));
                elements.push(id);
            };
            match element.corners {
                Corners::Triangle(n) => add(n),
                Corners::Quad([a, b, c, d]) => {
                    add([a, b, c]);
                    add([a, c, d]);
                }
            }
        }
        let vectors: Vec<DVec3> = triangles
            .iter()
            .map(|[a, b, c]| (*b - *a).cross(*c - *a))
            .collect();
        Self {
            areas: vectors.iter().map(|v| v.length() / 2.0).collect(),
            normals: vectors.iter().map(|v| v.normalize_or_zero()).collect(),
            thickness: elements
                .iter()
                .map(|e| mesh.elements[*e].mean_thickness())
                .collect(),
            triangles,
            elements,
        }
    }

    /// Area of all.
    pub fn area(&self) -> f64 {
        self.areas.iter().sum()
    }
    /// Sum of area times thickness.
    pub fn material(&self) -> f64 {
        self.areas
            .iter()
            .zip(&self.thickness)
            .map(|(a, t)| a * t)
            .sum()
    }
    /// Share of the area in elements that pass `test`.
    pub fn share(&self, test: impl Fn(ElementId) -> bool) -> f64 {
        let part: f64 = self
            .areas
            .iter()
            .zip(&self.elements)
            .filter(|(_, e)| test(**e))
            .map(|(a, _)| a)
            .sum();
        if part > 0.0 { part / self.area() } else { 0.0 }
    }
}

/// What was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Walls {
    pub r50: Option<f64>,
    pub r95: Option<f64>,
    pub r_bins: [f64; 5],
    pub judged_share: f64,
    pub outside: f64,
    pub thickness_error: Option<f64>,
    /// The samples, for [`Measure::astray`].
    probes: Vec<Probe>,
    /// How far from junctions and folds samples must be to be judged, in thicknesses.
    away: f64,
}

/// One sample's answer.
#[derive(Clone, Debug, PartialEq)]
struct Probe {
    triangle: usize,
    at: DVec3,
    inside: bool,
    /// Distance to the nearest junction or fold, in thicknesses.
    away: f64,
    /// R-error and relative error of the thickness, where both sides were hit.
    errors: Option<[f64; 2]>,
}

/// What a sample may be found to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Astray {
    /// Off the middle.
    Middle,
    /// Of wrong thickness.
    Thickness,
    /// Outside the solid; the value is 1.
    Outside,
}

impl Walls {
    /// Share of the judged samples with a greater R-error than `limit`.
    pub fn off_middle(&self, limit: f64) -> f64 {
        let judged = || self.judged().map(|errors| errors[0]);
        judged().filter(|r| *r > limit).count() as f64 / judged().count().max(1) as f64
    }

    /// The errors of the samples away from junctions and folds.
    fn judged(&self) -> impl Iterator<Item = [f64; 2]> {
        let counts = |p: &&Probe| p.inside && p.away > self.away;
        self.probes.iter().filter(counts).filter_map(|p| p.errors)
    }
}

/// The mesh held against the skin.
pub(super) struct Measure<'a> {
    skin: &'a Skin,
    mesh: &'a ShellMesh,
    flat: &'a Flat,
    lines: TriangleBvh,
}

impl<'a> Measure<'a> {
    /// `special` are the junctions and folds.
    pub fn new(
        skin: &'a Skin,
        mesh: &'a ShellMesh,
        flat: &'a Flat,
        special: &[[DVec3; 2]],
    ) -> Self {
        let lines: Vec<[DVec3; 3]> = special.iter().map(|[a, b]| [*a, *b, *b]).collect();
        Self {
            skin,
            mesh,
            flat,
            lines: TriangleBvh::new(&lines),
        }
    }

    /// The elements with a sample or a centre beyond `limit`, weighted by their area. Samples alone would leave most of a fine mesh unseen.
    pub fn astray(&self, walls: &Walls, what: Astray, limit: f64) -> Vec<Finding> {
        let third = [1.0 / 3.0; 3];
        let centres: Vec<Probe> = (0..self.flat.triangles.len())
            .into_par_iter()
            .map(|triangle| {
                let weights = third;
                self.probe(&Sample { triangle, weights })
            })
            .collect();
        let value = |p: &Probe| match what {
            Astray::Outside => f64::from(u8::from(!p.inside)),
            _ if !p.inside || p.away <= walls.away => 0.0,
            Astray::Middle => p.errors.map_or(0.0, |e| e[0]),
            Astray::Thickness => p.errors.map_or(0.0, |e| e[1]),
        };
        let mut worst: BTreeMap<ElementId, (f64, DVec3)> = BTreeMap::new();
        for probe in walls.probes.iter().chain(&centres) {
            let found = value(probe);
            let best = worst
                .entry(self.flat.elements[probe.triangle])
                .or_insert((limit, probe.at));
            if found > best.0 {
                *best = (found, probe.at);
            }
        }
        worst
            .into_iter()
            .filter(|(_, (value, _))| *value > limit)
            .map(|(id, (value, at))| {
                let element = &self.mesh.elements[id];
                Finding {
                    at,
                    value,
                    weight: area_of(self.mesh, id),
                    faces: element.source_faces.to_vec(),
                    elements: vec![id],
                    keys: element
                        .corners
                        .as_slice()
                        .iter()
                        .map(|n| node_key(*n))
                        .collect(),
                }
            })
            .collect()
    }

    /// Measures `count` samples.
    pub fn samples(&self, count: usize, seed: u64) -> Walls {
        let samples = spread(&self.flat.areas, count, seed);
        let probes: Vec<Probe> = samples.par_iter().map(|s| self.probe(s)).collect();
        if probes.is_empty() {
            return Walls::default();
        }
        let n = probes.len() as f64;
        let share =
            |test: &dyn Fn(&Probe) -> bool| probes.iter().filter(|p| test(p)).count() as f64 / n;
        let away = AWAY
            .into_iter()
            .find(|k| share(&|p| p.away > *k) > ENOUGH)
            .unwrap_or(f64::NEG_INFINITY);
        let outside = share(&|p| !p.inside);
        let walls = Walls {
            outside,
            away,
            probes,
            ..Walls::default()
        };
        let judged: Vec<[f64; 2]> = walls.judged().collect();
        let mut r: Vec<f64> = judged.iter().map(|e| e[0]).collect();
        r.sort_unstable_by(f64::total_cmp);
        let mut r_bins = [0.0; 5];
        for value in &r {
            let bin = BINS.iter().take_while(|end| value >= *end).count();
            r_bins[bin] += 1.0 / r.len() as f64;
        }
        Walls {
            r50: quantile(&r, 0.5),
            r95: quantile(&r, 0.95),
            r_bins,
            judged_share: judged.len() as f64 / n,
            thickness_error: median(judged.iter().map(|e| e[1]).collect()),
            ..walls
        }
    }

    fn probe(&self, sample: &Sample) -> Probe {
        let Self {
            skin, flat, lines, ..
        } = self;
        let i = sample.triangle;
        let p = sample.of(flat.triangles[i]);
        let thickness = flat.thickness[i];
        let distance = |direction: DVec3| {
            let hit = skin.hit(p, direction, 0.0)?;
            Some(skin.across(p, &hit))
        };
        let normal = flat.normals[i];
        let errors = match (distance(normal), distance(-normal)) {
            (Some(a), Some(b)) if a + b > 0.0 => {
                Some([(a - b).abs() / (a + b), (thickness - a - b).abs() / (a + b)])
            }
            _ => None,
        };
        Probe {
            triangle: i,
            at: p,
            inside: skin.holds(p, OUTSIDE * thickness),
            away: lines
                .nearest(p)
                .map_or(f64::INFINITY, |near| near.distance / thickness),
            errors,
        }
    }
}

/// Area of an element.
fn area_of(mesh: &ShellMesh, id: ElementId) -> f64 {
    let at = |n: NodeId| mesh.nodes[n];
    match mesh.elements[id].corners {
        Corners::Triangle([a, b, c]) => (at(b) - at(a)).cross(at(c) - at(a)).length() / 2.0,
        Corners::Quad([a, b, c, d]) => (at(c) - at(a)).cross(at(d) - at(b)).length() / 2.0,
    }
}
