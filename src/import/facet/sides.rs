//! Sides of triangles, and which two of the triangles at a side bound the same material.
//!
//! **Sides with more than two triangles** are parted by body, where every body that meets there can close itself, so that bodies that touch stay apart even
//! where their facets lie on one another; else by angle, so that what hangs together through material stays together.

use std::collections::BTreeMap;

use glam::DVec3;

use super::soup::Soup;
use crate::model::disjoint::Disjoint;

/// Triangles round a side whose directions differ by less than this lie on one another, rad: far above rounding, far below any wedge that is made.
const TOUCHING: f64 = 1e-3;
/// One use of a side by a triangle: lower end, upper end, triangle, whether it runs up.
pub(super) type Use = (u32, u32, u32, bool);

pub(super) fn uses(triangles: &[[u32; 3]]) -> Vec<Use> {
    let mut all: Vec<Use> = Vec::with_capacity(3 * triangles.len());
    for (i, &[a, b, c]) in (0u32..).zip(triangles) {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            all.push((p.min(q), p.max(q), i, p < q));
        }
    }
    all.sort_unstable();
    all
}

pub(super) fn runs(all: &[Use]) -> impl Iterator<Item = &[Use]> {
    all.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
}

/// A side as its only triangle runs it, and the triangle.
pub(super) type OpenSide = ([u32; 2], u32);

/// Pairs of triangles that bound the same material at a side, and the sides (from, to) that are left over.
pub(super) fn mates(soup: &Soup) -> (Vec<[u32; 2]>, Vec<OpenSide>, usize) {
    let all = uses(&soup.triangles);
    let (mut pairs, mut open, mut forked) = (Vec::new(), Vec::new(), 0);
    let mut bodies = Disjoint::new(soup.triangles.len());
    for run in runs(&all) {
        if let &[p, q] = run
            && p.3 != q.3
        {
            bodies.join(p.2, q.2);
        }
    }
    for run in runs(&all) {
        let directed = |u: &Use| {
            if u.3 { [u.0, u.1] } else { [u.1, u.0] }
        };
        match *run {
            [one] => open.push((directed(&one), one.2)),
            [p, q] if p.3 != q.3 => pairs.push([p.2, q.2]),
            _ => {
                forked += usize::from(run.len() > 2);
                for group in by_body(run, &mut bodies) {
                    let (found, left) = part(soup, &group);
                    pairs.extend(found);
                    open.extend(left.iter().map(|u| (directed(u), u.2)));
                }
            }
        }
    }
    (pairs, open, forked)
}

/// The triangles at a side, apart for each body if each has as many that run up as run down; all together otherwise.
fn by_body(run: &[Use], bodies: &mut Disjoint) -> Vec<Vec<Use>> {
    let mut groups: BTreeMap<u32, Vec<Use>> = BTreeMap::new();
    for &u in run {
        groups.entry(bodies.find(u.2)).or_default().push(u);
    }
    let closes = |group: &Vec<Use>| 2 * group.iter().filter(|u| u.3).count() == group.len();
    if groups.values().all(closes) {
        groups.into_values().collect()
    } else {
        vec![run.to_vec()]
    }
}

/// Parts the triangles round a side: seen along the side, material lies from each that runs down to the next that runs up. Where triangles lie on one another
/// two bodies touch, so that the one's material ends before the other's begins.
fn part(soup: &Soup, run: &[Use]) -> (Vec<[u32; 2]>, Vec<Use>) {
    let (a, b) = (
        soup.points[run[0].0 as usize],
        soup.points[run[0].1 as usize],
    );
    let axis = (b - a).normalize_or_zero();
    let x = axis.any_orthonormal_vector_or_x();
    let y = axis.cross(x);
    let mut round: Vec<(f64, Use)> = run
        .iter()
        .map(|&u| {
            let apex = soup.triangles[u.2 as usize]
                .into_iter()
                .find(|&v| v != u.0 && v != u.1)
                .map_or(a, |v| soup.points[v as usize]);
            ((apex - a).dot(y).atan2((apex - a).dot(x)), u)
        })
        .collect();
    round.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
    let gap = |k: usize| {
        let before = round[(k + round.len() - 1) % round.len()].0;
        (round[k].0 - before).rem_euclid(std::f64::consts::TAU)
    };
    // Begun at the widest gap, no group of triangles that touch lies across the beginning.
    let first = (0..round.len()).fold(0, |m, k| if gap(k) > gap(m) { k } else { m });
    let apart: Vec<bool> = (0..round.len())
        .map(|k| gap((first + k) % round.len()) > TOUCHING)
        .collect();
    round.rotate_left(first);
    let mut at = 0;
    while at < round.len() {
        let end = (at + 1..round.len()).find(|&k| apart[k]);
        let end = end.unwrap_or(round.len());
        round[at..end].sort_by_key(|u| !u.1.3);
        at = end;
    }
    // Like brackets: what is nested in another pair is taken first. Twice round, since a pair may lie across the beginning.
    let n = round.len();
    let mut used = vec![false; n];
    let mut down: Vec<usize> = Vec::new();
    let mut pairs = Vec::new();
    for k in (0..n).chain(0..n) {
        if used[k] || down.contains(&k) {
            continue;
        }
        if !round[k].1.3 {
            down.push(k);
        } else if let Some(before) = down.pop() {
            (used[before], used[k]) = (true, true);
            pairs.push([round[before].1.2, round[k].1.2]);
        }
    }
    let left = (0..n).filter(|&k| !used[k]).map(|k| round[k].1).collect();
    (pairs, left)
}

trait AnyOrthonormal {
    fn any_orthonormal_vector_or_x(self) -> DVec3;
}

impl AnyOrthonormal for DVec3 {
    fn any_orthonormal_vector_or_x(self) -> DVec3 {
        if self.is_normalized() {
            self.any_orthonormal_vector()
        } else {
            DVec3::X
        }
    }
}
