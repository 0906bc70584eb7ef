//! Facets to faces: regions of one curvature, with borders at sharp sides and where the curvature jumps.
//!
//! A tessellated cylinder is a row of flat strips. What tells it from a fold between two plates is that every strip turns on both its sides, the same way and
//! by about the same angle a length. So the facets are gathered into **flats** first (within two degrees of their seed), each flat gets the curvature tensor of its sides
//! (D. Cohen-Steiner, J.-M. Morvan, Restricted Delaunay triangulations and normal cycle, SoCG 2003, doi:10.1145/777792.777839), and flats are joined
//! over a side where their greatest curvatures agree and, unless the side hardly turns, both go on turning beyond it.
//! Strips narrower than the wall that hardly bend and meet a neighbour smoothly are the tessellation's, not the part's: a twisted surface is cut into triangles that turn
//! to and fro by some degrees. They join that neighbour. Crumbs of a region join the neighbour with the longest common border that is not sharp. A region that would hold both sides of a wall is cut by the turn of its normals.
//!
//! Guarantees: every facet is in one region, every region hangs together over sides; numbers ascend with the first facet. The result depends neither on size nor place.
//! Limits: a fillet of less than three chords is a chamfer here; two plates that meet at less than three degrees are one face.

use std::collections::VecDeque;

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen};

use super::soup::Soup;
use crate::model::disjoint::Disjoint;
use crate::spatial::TriangleBvh;

/// No triangle beyond this side, or more than one.
pub(super) const NONE: u32 = u32::MAX;

/// A side that turns more is an edge of the part: a quarter turn in three chords turns 30 degrees a side.
pub(super) const SHARP: f64 = 40.0 * DEGREE;
/// A flat's facets turn less than this from its seed: rounding of coordinates turns small facets by a degree.
const FLAT: f64 = 2.0 * DEGREE;
/// A side that turns less joins whatever has the same curvature.
const GENTLE: f64 = 3.0 * DEGREE;
/// A flat goes on turning where its farther sides turn by more than this share of the side in question: the last chord of a fillet turns half.
const GOES_ON: f64 = 0.3;
/// Curvatures agree within this factor: chords of one arc differ by up to three where the last one ends.
const AGREE: f64 = 4.0;
/// Two flats whose radius is more than this many mean thicknesses are both plane for a shell.
const PLANE_RADIUS: f64 = 200.0;
/// A region smaller than a square of this many thicknesses is a crumb.
const CRUMB: f64 = 0.3;
/// A region that turns less than this from its mean normal is a strip, if it is narrow.
const STRAIGHT: f64 = 10.0 * DEGREE;
/// A region narrower than this many mean thicknesses is narrow.
const NARROW: f64 = 1.0;
/// A facet lower than this share of its longest side takes the normal of its neighbour over that side.
const SLIVER: f64 = 1e-3;
/// A region is cut where this share of its samples sees the region itself across material.
const SELF_SEEN: f64 = 0.05;
/// The pieces of such a region turn less than this from their middle.
const CONE: f64 = 70.0 * DEGREE;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

/// The triangle beyond each side (k, k + 1); [`NONE`] where there is not exactly one.
pub(super) fn neighbours(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut sides: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(3 * triangles.len());
    for (t, tri) in (0u32..).zip(triangles) {
        for k in 0..3 {
            let (a, b) = (tri[k], tri[(k + 1) % 3]);
            sides.push((a.min(b), a.max(b), t, k as u8));
        }
    }
    sides.sort_unstable();
    let mut beyond = vec![[NONE; 3]; triangles.len()];
    for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        if let &[p, q] = run {
            beyond[p.2 as usize][p.3 as usize] = q.2;
            beyond[q.2 as usize][q.3 as usize] = p.2;
        }
    }
    beyond
}

/// Facets with their faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Segmented {
    /// #T regions.
    pub region: Vec<u32>,
    /// How many there are.
    pub regions: usize,
    /// #T unit normals; those of slivers are their neighbours'.
    pub normal: Vec<DVec3>,
    /// Greatest curvature of each region in the mean over its area, 1/mm.
    pub curvature: Vec<f64>,
}

/// What a region looks like.
#[derive(Clone, Copy, Debug, Default)]
struct Form {
    area: f64,
    /// Length of its borders.
    outline: f64,
    /// Most that a facet turns from the mean normal, rad.
    bend: f64,
}

/// All sides between two regions, seen from one of them.
struct Border {
    from: u32,
    to: u32,
    length: f64,
    /// Mean turn over it, rad; turns to and fro cancel.
    turn: f64,
    /// Length of the sides that are not sharp.
    smooth: f64,
}

struct Work<'a> {
    soup: &'a Soup,
    beyond: Vec<[u32; 3]>,
    normal: Vec<DVec3>,
    area: Vec<f64>,
    thickness: f64,
}

/// The faces of a closed solid.
pub fn segment(soup: &Soup, thickness: f64) -> Segmented {
    let beyond = neighbours(&soup.triangles);
    let (normal, area) = normals(soup, &beyond);
    let work = Work {
        soup,
        beyond,
        normal,
        area,
        thickness,
    };
    let flats = work.flats();
    let (region, bent) = work.join(&flats);
    let region = work.without_strips(region);
    let region = work.without_crumbs(region);
    let region = work.cut_self_seeing(region);
    let (region, regions) = work.connected(&region);
    let mut curvature = vec![(0.0, 0.0); regions];
    for (t, &r) in region.iter().enumerate() {
        let (sum, area) = &mut curvature[r as usize];
        *sum += bent[t] * work.area[t];
        *area += work.area[t];
    }
    Segmented {
        region,
        regions,
        normal: work.normal,
        curvature: curvature
            .into_iter()
            .map(|(sum, area)| if area > 0.0 { sum / area } else { 0.0 })
            .collect(),
    }
}

fn normals(soup: &Soup, beyond: &[[u32; 3]]) -> (Vec<DVec3>, Vec<f64>) {
    let n = soup.triangles.len();
    let mut normal = Vec::with_capacity(n);
    let mut area = Vec::with_capacity(n);
    // Slivers with the side over which their neighbour is asked, lowest of their kind last.
    let mut poor = Vec::new();
    for t in 0..n {
        let [a, b, c] = soup.corners(t);
        let cross = (b - a).cross(c - a);
        let lengths = [a.distance(b), b.distance(c), c.distance(a)];
        let k = (0..3).fold(0, |m, k| if lengths[k] > lengths[m] { k } else { m });
        normal.push(cross.normalize_or_zero());
        area.push(cross.length() / 2.0);
        if cross.length() < SLIVER * lengths[k] * lengths[k] {
            poor.push((t, k));
        }
    }
    let is_poor: std::collections::BTreeSet<usize> = poor.iter().map(|p| p.0).collect();
    for &(t, mut k) in &poor {
        // Slivers lie beside slivers: a few steps lead out of most heaps of them.
        let mut at = t;
        for _ in 0..8 {
            let next = beyond[at][k];
            if next == NONE {
                break;
            }
            let from = at;
            at = next as usize;
            if !is_poor.contains(&at) {
                normal[t] = normal[at];
                break;
            }
            let [a, b, c] = soup.corners(at);
            let lengths = [a.distance(b), b.distance(c), c.distance(a)];
            let other = |j: usize| beyond[at][j] as usize != from;
            k = (0..3)
                .filter(|&j| other(j))
                .fold(3, |m, j| {
                    if m == 3 || lengths[j] > lengths[m] {
                        j
                    } else {
                        m
                    }
                })
                .min(2);
        }
    }
    (normal, area)
}

impl Work<'_> {
    fn side(&self, t: usize, k: usize) -> DVec3 {
        let tri = self.soup.triangles[t];
        self.soup.points[tri[(k + 1) % 3] as usize] - self.soup.points[tri[k] as usize]
    }

    /// Signed turn over a side, rad; positive where the solid is convex.
    fn turn(&self, t: usize, k: usize) -> f64 {
        let mate = self.beyond[t][k];
        if mate == NONE {
            return std::f64::consts::PI;
        }
        let (n, m) = (self.normal[t], self.normal[mate as usize]);
        let along = self.side(t, k).normalize_or_zero();
        n.cross(m).dot(along).atan2(n.dot(m))
    }

    /// A flat for every facet: grown from the largest facets, within a narrow cone of normals.
    fn flats(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.area.len() as u32).collect();
        order.sort_by(|&a, &b| {
            self.area[b as usize]
                .total_cmp(&self.area[a as usize])
                .then(a.cmp(&b))
        });
        let limit = FLAT.cos();
        let mut flat = vec![NONE; self.area.len()];
        let mut count = 0;
        for seed in order {
            if flat[seed as usize] != NONE {
                continue;
            }
            flat[seed as usize] = count;
            let mut queue = VecDeque::from([seed as usize]);
            while let Some(t) = queue.pop_front() {
                for mate in self.beyond[t] {
                    if mate != NONE
                        && flat[mate as usize] == NONE
                        && self.normal[mate as usize].dot(self.normal[seed as usize]) > limit
                    {
                        flat[mate as usize] = count;
                        queue.push_back(mate as usize);
                    }
                }
            }
            count += 1;
        }
        flat
    }

    /// Joins flats of one curvature; a region and a curvature for every facet.
    fn join(&self, flat: &[u32]) -> (Vec<u32>, Vec<f64>) {
        let count = flat.iter().max().map_or(0, |m| *m as usize + 1);
        let mut tensor = vec![Matrix3::<f64>::zeros(); count];
        let mut area = vec![0.0; count];
        // (flat, flat, length, length x turn), both ways.
        let mut borders: Vec<(u32, u32, f64, f64)> = Vec::new();
        for t in 0..flat.len() {
            area[flat[t] as usize] += self.area[t];
            for k in 0..3 {
                let mate = self.beyond[t][k];
                let turn = self.turn(t, k);
                if mate == NONE || turn.abs() > SHARP {
                    continue;
                }
                let side = self.side(t, k);
                let length = side.length();
                let e = side.normalize_or_zero();
                let e = nalgebra::Vector3::new(e.x, e.y, e.z);
                // Each triangle has half of the side.
                tensor[flat[t] as usize] += e * e.transpose() * (turn * length / 2.0);
                let other = flat[mate as usize];
                if other != flat[t] {
                    borders.push((flat[t], other, length, length * turn));
                }
            }
        }
        let curvature: Vec<f64> = tensor
            .iter()
            .zip(&area)
            .map(|(m, &a)| {
                let eigen = SymmetricEigen::try_new(*m, f64::EPSILON, 100);
                let most = eigen.map_or(0.0, |e| e.eigenvalues.amax());
                if a > 0.0 { most / a } else { 0.0 }
            })
            .collect();
        borders.sort_by_key(|b| (b.0, b.1));
        let arcs: Vec<(u32, u32, f64, f64)> = borders
            .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
            .map(|run| {
                let length: f64 = run.iter().map(|r| r.2).sum();
                let turn = run.iter().map(|r| r.3).sum::<f64>() / length.max(f64::MIN_POSITIVE);
                (run[0].0, run[0].1, length, turn)
            })
            .collect();
        let of = |f: u32| {
            let first = arcs.partition_point(|a| a.0 < f);
            arcs[first..].iter().take_while(move |a| a.0 == f)
        };
        let goes_on = |f: u32, from: u32, turn: f64| {
            of(f).any(|a| a.1 != from && a.3 * turn > 0.0 && a.3.abs() > GOES_ON * turn.abs())
        };
        let floor = 1.0 / (PLANE_RADIUS * self.thickness);
        let mut sets = Disjoint::new(count);
        for &(f, g, _, turn) in arcs.iter().filter(|a| a.0 < a.1) {
            let (p, q) = (
                curvature[f as usize].max(floor),
                curvature[g as usize].max(floor),
            );
            let alike = p.max(q) < AGREE * p.min(q);
            let both = || goes_on(f, g, turn) && goes_on(g, f, turn);
            if alike && (turn.abs() < GENTLE || both()) {
                sets.join(f, g);
            }
        }
        let region = flat.iter().map(|&f| sets.find(f)).collect();
        (
            region,
            flat.iter().map(|&f| curvature[f as usize]).collect(),
        )
    }

    /// Gives narrow straight regions to the larger neighbour that they meet over the longest smooth border.
    fn without_strips(&self, region: Vec<u32>) -> Vec<u32> {
        self.merged(region, |borders, forms| {
            let mut best: Vec<Option<(f64, u32)>> = vec![None; forms.len()];
            for of_one in borders.chunk_by(|a, b| a.from == b.from) {
                let form = &forms[of_one[0].from as usize];
                let narrow = 2.0 * form.area < NARROW * self.thickness * form.outline;
                if !narrow || form.bend > STRAIGHT {
                    continue;
                }
                let smooth: Vec<&Border> = of_one.iter().filter(|b| b.turn < SHARP).collect();
                for b in &smooth {
                    // Between two faces a strip is a bevel, unless it hardly turns; within one face it is noise.
                    let limit = if smooth.len() > 1 { GENTLE } else { STRAIGHT };
                    let slot = &mut best[b.from as usize];
                    if b.turn < limit && slot.is_none_or(|s| b.length > s.0) {
                        *slot = Some((b.length, b.to));
                    }
                }
            }
            best
        })
    }

    /// Gives small regions to the neighbour with the longest common border that is not sharp.
    fn without_crumbs(&self, region: Vec<u32>) -> Vec<u32> {
        let limit = (CRUMB * self.thickness).powi(2);
        self.merged(region, |borders, forms| {
            let mut best: Vec<Option<(f64, u32)>> = vec![None; forms.len()];
            for b in borders {
                let slot = &mut best[b.from as usize];
                if forms[b.from as usize].area <= limit
                    && b.smooth > 0.0
                    && slot.is_none_or(|s| b.smooth > s.0)
                {
                    *slot = Some((b.smooth, b.to));
                }
            }
            best
        })
    }

    /// Joins every region to the neighbour that `choose` names (with the length of their border) if that is larger, in rounds until none is left.
    fn merged(
        &self,
        region: Vec<u32>,
        choose: impl Fn(&[Border], &[Form]) -> Vec<Option<(f64, u32)>>,
    ) -> Vec<u32> {
        let (mut region, mut count) = self.connected(&region);
        for _ in 0..8 {
            let forms = self.forms(&region, count);
            let best = choose(&self.borders(&region), &forms);
            let mut sets = Disjoint::new(count);
            let mut merged = false;
            // A crumb goes to a larger region, so that a fillet of crumbs is not swallowed from both ends by itself.
            for (r, b) in (0u32..).zip(&best) {
                let area = |r: u32| forms[r as usize].area;
                if let Some((_, to)) = *b
                    && (area(to), to) > (area(r), r)
                {
                    sets.join(r, to);
                    merged = true;
                }
            }
            if !merged {
                break;
            }
            let joined: Vec<u32> = region.iter().map(|&r| sets.find(r)).collect();
            (region, count) = self.connected(&joined);
        }
        region
    }

    fn forms(&self, region: &[u32], count: usize) -> Vec<Form> {
        let mut forms = vec![Form::default(); count];
        let mut mean = vec![DVec3::ZERO; count];
        for (t, &r) in region.iter().enumerate() {
            forms[r as usize].area += self.area[t];
            mean[r as usize] += self.normal[t] * self.area[t];
            for k in 0..3 {
                let mate = self.beyond[t][k];
                if mate == NONE || region[mate as usize] != r {
                    forms[r as usize].outline += self.side(t, k).length();
                }
            }
        }
        for (t, &r) in region.iter().enumerate() {
            let cos = self.normal[t].dot(mean[r as usize].normalize_or_zero());
            let form = &mut forms[r as usize];
            form.bend = form.bend.max(cos.clamp(-1.0, 1.0).acos());
        }
        forms
    }

    /// Borders between regions, both ways, by ascending numbers.
    fn borders(&self, region: &[u32]) -> Vec<Border> {
        let mut sides: Vec<(u32, u32, f64, f64)> = Vec::new();
        for t in 0..region.len() {
            for k in 0..3 {
                let mate = self.beyond[t][k];
                if mate != NONE && region[mate as usize] != region[t] {
                    let length = self.side(t, k).length();
                    sides.push((region[t], region[mate as usize], length, self.turn(t, k)));
                }
            }
        }
        sides.sort_by_key(|s| (s.0, s.1));
        sides
            .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
            .map(|run| {
                let length: f64 = run.iter().map(|s| s.2).sum();
                let turned: f64 = run.iter().map(|s| s.2 * s.3).sum();
                Border {
                    from: run[0].0,
                    to: run[0].1,
                    length,
                    turn: (turned / length.max(f64::MIN_POSITIVE)).abs(),
                    smooth: (run.iter().filter(|s| s.3.abs() < SHARP))
                        .map(|s| s.2)
                        .sum(),
                }
            })
            .collect()
    }

    /// Cuts regions that hold both sides of a wall.
    fn cut_self_seeing(&self, region: Vec<u32>) -> Vec<u32> {
        let (mut region, count) = self.connected(&region);
        let triangles: Vec<[DVec3; 3]> = (0..region.len()).map(|t| self.soup.corners(t)).collect();
        let bvh = TriangleBvh::new(&triangles);
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); count];
        for (t, &r) in region.iter().enumerate() {
            members[r as usize].push(t);
        }
        let mut next = count as u32;
        for list in members.iter().filter(|l| l.len() > 2) {
            // Systematic samples by area: a sample a step.
            let total: f64 = list.iter().map(|&t| self.area[t]).sum();
            let step = total / 200.0;
            let (mut passed, mut mark) = (0.0, step / 2.0);
            let (mut asked, mut own) = (0.0, 0.0);
            for &t in list {
                passed += self.area[t];
                if mark >= passed {
                    continue;
                }
                mark = passed + step;
                let [a, b, c] = triangles[t];
                let inward = -self.normal[t];
                let start = (a + b + c) / 3.0 + inward * (1e-4 * self.thickness);
                asked += 1.0;
                if let Some((hit, _)) = bvh.first_hit(start, inward)
                    && region[hit] == region[t]
                    && self.normal[hit].dot(inward) > 0.5
                {
                    own += 1.0;
                }
            }
            if own <= SELF_SEEN * asked {
                continue;
            }
            let mut order = list.clone();
            order.sort_by(|&a, &b| self.area[b].total_cmp(&self.area[a]).then(a.cmp(&b)));
            let whole = region[list[0]];
            for seed in order {
                if region[seed] != whole {
                    continue;
                }
                region[seed] = next;
                let mut queue = VecDeque::from([seed]);
                while let Some(t) = queue.pop_front() {
                    for mate in self.beyond[t] {
                        if mate != NONE
                            && region[mate as usize] == whole
                            && self.normal[mate as usize].dot(self.normal[seed]) > CONE.cos()
                        {
                            region[mate as usize] = next;
                            queue.push_back(mate as usize);
                        }
                    }
                }
                next += 1;
            }
        }
        region
    }

    /// Regions that hang together over sides, numbered by their first facet.
    fn connected(&self, region: &[u32]) -> (Vec<u32>, usize) {
        let mut number = vec![NONE; region.len()];
        let mut count = 0;
        for seed in 0..region.len() {
            if number[seed] != NONE {
                continue;
            }
            number[seed] = count;
            let mut stack = vec![seed];
            while let Some(t) = stack.pop() {
                for mate in self.beyond[t] {
                    if mate != NONE
                        && number[mate as usize] == NONE
                        && region[mate as usize] == region[t]
                    {
                        number[mate as usize] = count;
                        stack.push(mate as usize);
                    }
                }
            }
            count += 1;
        }
        (number, count as usize)
    }
}
