//! Welding: corners at one place become one vertex, and what bounds nothing goes.
//!
//! A facet file with single precision repeats a corner to the last bit, or to rounding where it was moved. So corners that agree exactly
//! are welded first, then those within rounding of single precision; only where borders stay open wider tolerances are tried, each kept
//! where it closes some border.

use std::collections::HashMap;

use glam::DVec3;

use super::soup::Soup;

/// Welding tolerances in shares of the diagonal: rounding of single precision, then what exporters of poor files leave.
const TOLERANCES: [f64; 3] = [5e-7, 1e-5, 1e-4];

/// What welding took away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Triangles with two corners at one place.
    pub degenerate: usize,
    /// Triangles that were there twice.
    pub double: usize,
}

/// The box of the points: low and high corner; equal where there are none.
pub(super) fn extent(points: &[DVec3]) -> (DVec3, DVec3) {
    let low = points.iter().fold(DVec3::INFINITY, |m, &p| m.min(p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |m, &p| m.max(p));
    if points.is_empty() {
        (DVec3::ZERO, DVec3::ZERO)
    } else {
        (low, high)
    }
}

/// The welded triangles, without degenerate and double ones.
pub fn weld(soup: &Soup) -> (Soup, Dropped) {
    let exact = merge_equal(soup);
    let (low, high) = extent(&exact.points);
    let diagonal = (high - low).length();
    // Coordinates far from the origin are rounded more coarsely than the part's size says.
    let rounding = 2.0 * f64::from(f32::EPSILON) * low.abs().max(high.abs()).max_element();
    let mut best: Option<(usize, Soup, Dropped)> = None;
    for share in TOLERANCES {
        let (welded, dropped) = tidy(merge_near(&exact, (share * diagonal).max(rounding)));
        let open = open_sides(&welded);
        let better = best
            .as_ref()
            .is_none_or(|b| open < b.0 && welded.triangles.len() * 2 > soup.triangles.len());
        if better {
            best = Some((open, welded, dropped));
        }
        if best.as_ref().is_some_and(|b| b.0 == 0) {
            break;
        }
    }
    best.map_or_else(Default::default, |(_, welded, dropped)| (welded, dropped))
}

/// Sides of triangles that no other triangle has.
pub(super) fn open_sides(soup: &Soup) -> usize {
    let mut sides: Vec<[u32; 2]> = soup
        .triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[p, q]| [p.min(q), p.max(q)]))
        .collect();
    sides.sort_unstable();
    sides
        .chunk_by(|a, b| a == b)
        .filter(|r| r.len() == 1)
        .count()
}

fn merge_equal(soup: &Soup) -> Soup {
    // Only looked up, never walked: numbers follow the order of the points.
    let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(soup.points.len() / 4);
    let mut points = Vec::new();
    let number: Vec<u32> = soup
        .points
        .iter()
        .map(|p| {
            // Adding zero makes one of both zeros.
            let key = (*p + DVec3::ZERO).to_array().map(f64::to_bits);
            *known.entry(key).or_insert_with(|| {
                points.push(*p);
                points.len() as u32 - 1
            })
        })
        .collect();
    renumbered(&soup.triangles, points, &number)
}

fn renumbered(triangles: &[[u32; 3]], points: Vec<DVec3>, number: &[u32]) -> Soup {
    Soup {
        points,
        triangles: triangles
            .iter()
            .map(|t| t.map(|v| number[v as usize]))
            .collect(),
    }
}

/// Every point goes to the first point before it within the tolerance.
fn merge_near(soup: &Soup, tolerance: f64) -> Soup {
    if tolerance <= 0.0 || !tolerance.is_finite() {
        return soup.clone();
    }
    let cell = |p: DVec3| (p / tolerance).floor().to_array().map(|x| x as i64);
    let mut kept: HashMap<[i64; 3], Vec<u32>> = HashMap::with_capacity(soup.points.len());
    let mut points: Vec<DVec3> = Vec::new();
    let number: Vec<u32> = soup
        .points
        .iter()
        .map(|&p| {
            let [x, y, z] = cell(p);
            let mut found = u32::MAX;
            for i in 0..27 {
                let key = [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1];
                for &q in kept.get(&key).into_iter().flatten() {
                    if points[q as usize].distance(p) <= tolerance {
                        found = found.min(q);
                    }
                }
            }
            if found == u32::MAX {
                found = points.len() as u32;
                points.push(p);
                kept.entry([x, y, z]).or_default().push(found);
            }
            found
        })
        .collect();
    renumbered(&soup.triangles, points, &number)
}

/// A triangle's corners in ascending order, and whether it runs round them that way.
pub(super) fn sorted(corners: [u32; 3]) -> ([u32; 3], bool) {
    let mut key = corners;
    key.sort_unstable();
    let even = (0..3).any(|k| [corners[k], corners[(k + 1) % 3]] == [key[0], key[1]]);
    (key, even)
}

/// Without degenerate triangles; of several on the same corners one stays, or one each way where as many face one way as the other: there two bodies
/// touch, or a wall has no thickness, and only the bodies tell which.
fn tidy(soup: Soup) -> (Soup, Dropped) {
    let mut dropped = Dropped::default();
    let mut keyed: Vec<([u32; 3], bool, u32)> = Vec::with_capacity(soup.triangles.len());
    for (i, &[a, b, c]) in soup.triangles.iter().enumerate() {
        if a == b || b == c || c == a {
            dropped.degenerate += 1;
            continue;
        }
        let (key, even) = sorted([a, b, c]);
        keyed.push((key, even, i as u32));
    }
    keyed.sort_unstable();
    let mut stay: Vec<u32> = Vec::with_capacity(keyed.len());
    for run in keyed.chunk_by(|a, b| a.0 == b.0) {
        let even = run.iter().filter(|r| r.1).count();
        let odd = run.len() - even;
        let first = |way: bool| run.iter().find(|r| r.1 == way).map(|r| r.2);
        let kept = [
            first(true).filter(|_| even >= odd),
            first(false).filter(|_| odd >= even),
        ];
        let kept = kept.into_iter().flatten();
        dropped.double += run.len() - kept.clone().count();
        stay.extend(kept);
    }
    stay.sort_unstable();
    let triangles = stay.iter().map(|&i| soup.triangles[i as usize]).collect();
    (
        Soup {
            points: soup.points,
            triangles,
        },
        dropped,
    )
}
