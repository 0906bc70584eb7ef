//! From welded triangles to closed, outward oriented solids, or to the reason why there are none.
//!
//! **Orientation** spreads over sides that two triangles share; the volume of a shell decides its sign, and how deep it lies in others whether it bounds
//! material or a void. Sides with more than two triangles are parted (`sides`), so that bodies that touch are solids of their own. Bodies that cut each other
//! (`cuts`) are told as such, a surface that cuts itself is refused.
//! **Holes** are closed where their border is no longer than [`HOLE`] of the part's diagonal: what a lost facet leaves; a longer border is a surface
//! that was never a solid, and to guess its missing part would be to invent one.

use std::collections::{BTreeMap, VecDeque};

use glam::DVec3;

use super::cuts::{Cut, cuts};
use super::sides::{OpenSide, Use, mates, runs, uses};
use super::soup::{Soup, triangulate};
use super::weld::{extent, sorted};
use crate::model::disjoint::Disjoint;
use crate::spatial::TriangleBvh;

/// Longest border of a hole that is closed, in diagonals of the part.
pub const HOLE: f64 = 0.1;
/// Pieces with less than this share of the whole area are crumbs and left out, if they are open or enclose nothing.
const CRUMB: f64 = 1e-3;
/// A shell that encloses less than this share of its area times its diagonal has no inside: two skins on one another.
const FLAT: f64 = 1e-7;
/// Bodies cut each other where one enters the other by more than this share of the diagonal: chords of a common round side enter by less.
const ENTERED: f64 = 1e-4;
/// A surface cuts itself where it goes through by more than this share of its mean thickness: less is a fold of poor facets, which changes no wall.
const SELF_ENTERED: f64 = 0.5;
/// Corners of a shell that are asked whether they lie in another.
const ASKED: usize = 64;
/// Places that a refusal names.
const PLACES: usize = 4;

/// Why facets bound no solid. Places are in the file's coordinates.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShellFault {
    /// Holes too large to be closed by guess.
    #[error(
        "{count} open borders are too long to be closed, {length:.3} in all; they pass {}",
        shown(places)
    )]
    Open {
        /// How many borders.
        count: usize,
        /// Their length.
        length: f64,
        /// A point of each of the longest.
        places: Vec<DVec3>,
    },
    /// A one-sided surface, such as a Moebius strip.
    #[error(
        "the facets cannot all be turned outwards: {count} sides disagree, at {}",
        shown(places)
    )]
    NotOrientable {
        /// How many sides.
        count: usize,
        /// Some of them.
        places: Vec<DVec3>,
    },
    /// Closed, but nothing inside.
    #[error("the facets enclose no volume")]
    NoVolume,
    /// A surface that goes through itself.
    #[error("the surface cuts through itself {count} times, at {}", shown(places))]
    SelfCut {
        /// How many sides of triangles go through others.
        count: usize,
        /// Where.
        places: Vec<DVec3>,
    },
    /// Bodies that cut each other.
    #[error(
        "{count} pairs of closed bodies cut through each other, at {}",
        shown(places)
    )]
    Overlap {
        /// How many pairs.
        count: usize,
        /// A corner of one inside the other.
        places: Vec<DVec3>,
    },
}

fn shown(places: &[DVec3]) -> String {
    let list: Vec<String> = places
        .iter()
        .map(|p| format!("({:.3}, {:.3}, {:.3})", p.x, p.y, p.z))
        .collect();
    list.join(" ")
}

/// What was mended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Mended {
    /// Triangles that were turned.
    pub turned: usize,
    /// Holes that were closed.
    pub holes: usize,
    /// Pieces that were left out.
    pub crumbs: usize,
    /// Sides with more than two triangles.
    pub forked: usize,
}

/// Closed facets of one solid, turned outwards.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Solid {
    /// The facets, with only the points that they use.
    pub facets: Soup,
    /// Where it is made of bodies that cut each other: no Delaunay mesher can fill it.
    pub cut: Option<ShellFault>,
}

/// The solids, in order of their first triangle. Bodies that cut each other are one.
pub fn solids(welded: Soup) -> Result<(Vec<Solid>, Mended), ShellFault> {
    let mut mended = Mended::default();
    let mut soup = welded;
    mended.turned = turn_alike(&mut soup)?;
    close_holes(&mut soup, &mut mended)?;
    let shells = shells(&soup, &mut mended);
    let between = cuts_between(&soup, &shells)?;
    let solids = nest(&soup, &shells, between, &mut mended);
    if solids.is_empty() {
        return Err(ShellFault::NoVolume);
    }
    Ok((solids, mended))
}

/// Turns triangles so that both at a side run against each other; how many were turned.
fn turn_alike(soup: &mut Soup) -> Result<usize, ShellFault> {
    let all = uses(&soup.triangles);
    let wrong = |r: &[Use]| r.len() == 2 && r[0].3 == r[1].3;
    if !runs(&all).any(wrong) {
        return Ok(0);
    }
    let mut around: Vec<Vec<(u32, bool)>> = vec![Vec::new(); soup.triangles.len()];
    for run in runs(&all) {
        if let &[p, q] = run {
            around[p.2 as usize].push((q.2, p.3 == q.3));
            around[q.2 as usize].push((p.2, p.3 == q.3));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; soup.triangles.len()];
    for seed in 0..soup.triangles.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut queue = VecDeque::from([seed]);
        let mut members = vec![seed];
        while let Some(t) = queue.pop_front() {
            for &(mate, odd) in &around[t] {
                let mate = mate as usize;
                if turned[mate].is_none() {
                    turned[mate] = turned[t].map(|s| s ^ odd);
                    queue.push_back(mate);
                    members.push(mate);
                }
            }
        }
        // The file's own sense is taken from the majority.
        let count = members.iter().filter(|&&m| turned[m] == Some(true)).count();
        if 2 * count > members.len() {
            for m in members {
                turned[m] = turned[m].map(|s| !s);
            }
        }
    }
    for (t, s) in soup.triangles.iter_mut().zip(&turned) {
        if *s == Some(true) {
            t.swap(1, 2);
        }
    }
    let all = uses(&soup.triangles);
    let places: Vec<DVec3> = runs(&all)
        .filter(|r| wrong(r))
        .map(|r| soup.points[r[0].0 as usize])
        .collect();
    if places.is_empty() {
        Ok(turned.iter().filter(|s| **s == Some(true)).count())
    } else {
        Err(ShellFault::NotOrientable {
            count: places.len(),
            places: places.into_iter().take(PLACES).collect(),
        })
    }
}

fn close_holes(soup: &mut Soup, mended: &mut Mended) -> Result<(), ShellFault> {
    let (_, open, forked) = mates(soup);
    mended.forked = forked;
    if open.is_empty() {
        return Ok(());
    }
    drop_open_crumbs(soup, mended);
    let (_, open, _) = mates(soup);
    let (low, high) = extent(&soup.points);
    let longest = HOLE * (high - low).length();
    let (mut count, mut length, mut places) = (0, 0.0, Vec::new());
    for border in loops(&open) {
        let at = |k: usize| soup.points[border[k % border.len()] as usize];
        let own: f64 = (0..border.len()).map(|k| at(k).distance(at(k + 1))).sum();
        if own <= longest && border.len() >= 3 {
            // The hole's triangles run against the border of its neighbours.
            let reversed: Vec<u32> = border.iter().rev().copied().collect();
            triangulate(&soup.points, &reversed, &mut soup.triangles);
            mended.holes += 1;
        } else {
            count += 1;
            length += own;
            places.push((own, at(0)));
        }
    }
    let (_, left, _) = mates(soup);
    if count == 0 && left.is_empty() {
        return Ok(());
    }
    if count == 0 {
        count = left.len();
        places = left
            .iter()
            .map(|(s, _)| (0.0, soup.points[s[0] as usize]))
            .collect();
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    Err(ShellFault::Open {
        count,
        length,
        places: places.into_iter().take(PLACES).map(|p| p.1).collect(),
    })
}

/// Chains of open sides. A chain that comes back to a vertex it has passed is cut there, so that loops that touch in a point are two.
fn loops(open: &[OpenSide]) -> Vec<Vec<u32>> {
    let mut from: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &([a, b], _) in open {
        from.entry(a).or_default().push(b);
    }
    let mut found = Vec::new();
    while let Some((&start, _)) = from.first_key_value() {
        let mut chain = vec![start];
        let mut place: BTreeMap<u32, usize> = BTreeMap::from([(start, 0)]);
        while let Some(&last) = chain.last() {
            let Some(list) = from.get_mut(&last) else {
                // A dead end: sides with an odd number of triangles leave such.
                found.push(std::mem::take(&mut chain));
                break;
            };
            let next = list.pop().unwrap_or(last);
            if list.is_empty() {
                from.remove(&last);
            }
            if let Some(&k) = place.get(&next) {
                let cut: Vec<u32> = chain.drain(k + 1..).collect();
                for v in &cut {
                    place.remove(v);
                }
                let mut border = vec![next];
                border.extend(cut);
                found.push(border);
                if k == 0 && !from.contains_key(&next) {
                    break;
                }
            } else {
                place.insert(next, chain.len());
                chain.push(next);
            }
        }
    }
    found
}

fn area(soup: &Soup, triangles: &[u32]) -> f64 {
    triangles
        .iter()
        .map(|&t| {
            let [a, b, c] = soup.corners(t as usize);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum()
}

/// Pieces that hang together, by ascending first triangle.
fn pieces(soup: &Soup, pairs: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut sets = Disjoint::new(soup.triangles.len());
    for &[a, b] in pairs {
        sets.join(a, b);
    }
    let mut lists: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for t in 0..soup.triangles.len() as u32 {
        lists.entry(sets.find(t)).or_default().push(t);
    }
    lists.into_values().collect()
}

/// Leaves out small pieces with an open border: loose facets.
fn drop_open_crumbs(soup: &mut Soup, mended: &mut Mended) {
    let (pairs, open, _) = mates(soup);
    let lists = pieces(soup, &pairs);
    let total: f64 = lists.iter().map(|l| area(soup, l)).sum();
    let mut is_open = vec![false; soup.triangles.len()];
    for &(_, t) in &open {
        is_open[t as usize] = true;
    }
    let mut stay: Vec<u32> = Vec::new();
    for list in lists {
        let loose = list.iter().any(|&t| is_open[t as usize]);
        if loose && area(soup, &list) < CRUMB * total {
            mended.crumbs += 1;
        } else {
            stay.extend(list);
        }
    }
    stay.sort_unstable();
    soup.triangles = stay.iter().map(|&t| soup.triangles[t as usize]).collect();
}

/// A closed shell and the volume that it encloses, with the sign of its orientation.
struct Shell {
    triangles: Vec<u32>,
    volume: f64,
}

fn shells(soup: &Soup, mended: &mut Mended) -> Vec<Shell> {
    let (pairs, _, _) = mates(soup);
    let (low, high) = extent(&soup.points);
    let (middle, diagonal) = ((low + high) / 2.0, (high - low).length());
    let mut found = Vec::new();
    for triangles in pieces(soup, &pairs) {
        let triangles = without_slits(soup, triangles);
        let volume: f64 = triangles
            .iter()
            .map(|&t| {
                let [a, b, c] = soup.corners(t as usize).map(|p| p - middle);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
        if volume.abs() > FLAT * area(soup, &triangles) * diagonal {
            found.push(Shell { triangles, volume });
        } else {
            mended.crumbs += 1;
        }
    }
    found
}

/// A piece without its triangles that face another of its own on the same corners: walls and gaps without thickness.
fn without_slits(soup: &Soup, piece: Vec<u32>) -> Vec<u32> {
    let mut keyed: Vec<([u32; 3], bool, u32)> = (piece.iter())
        .map(|&t| {
            let (key, even) = sorted(soup.triangles[t as usize]);
            (key, even, t)
        })
        .collect();
    keyed.sort_unstable();
    let mut stay: Vec<u32> = Vec::with_capacity(keyed.len());
    for run in keyed.chunk_by(|a, b| a.0 == b.0) {
        let odd = run.iter().filter(|r| !r.1).count();
        let pairs = odd.min(run.len() - odd);
        // Odd ones come first: the pairs lie round their end.
        stay.extend(run[..odd - pairs].iter().map(|r| r.2));
        stay.extend(run[odd + pairs..].iter().map(|r| r.2));
    }
    stay.sort_unstable();
    stay
}

/// Pairs of shells that cut each other, once each, with a place; a shell that cuts itself is an error.
fn cuts_between(soup: &Soup, shells: &[Shell]) -> Result<Vec<([u32; 2], DVec3)>, ShellFault> {
    let mut of = vec![None; soup.triangles.len()];
    for (i, shell) in (0u32..).zip(shells) {
        for &t in &shell.triangles {
            of[t as usize] = Some(i);
        }
    }
    let thickness: Vec<f64> = shells
        .iter()
        .map(|s| 2.0 * s.volume.abs() / area(soup, &s.triangles).max(f64::MIN_POSITIVE))
        .collect();
    let (low, high) = extent(&soup.points);
    let entered = ENTERED * (high - low).length();
    let mut own: Vec<Cut> = Vec::new();
    let mut between: BTreeMap<[u32; 2], DVec3> = BTreeMap::new();
    for cut in cuts(
        soup,
        thickness
            .iter()
            .fold(entered, |m, t| m.min(SELF_ENTERED * t)),
    ) {
        let [Some(i), Some(j)] = cut.triangles.map(|t| of[t as usize]) else {
            continue;
        };
        if i != j && cut.depth > entered {
            between.entry([i.min(j), i.max(j)]).or_insert(cut.place);
        } else if i == j && cut.depth > SELF_ENTERED * thickness[i as usize] {
            own.push(cut);
        }
    }
    if own.is_empty() {
        Ok(between.into_iter().collect())
    } else {
        Err(ShellFault::SelfCut {
            count: own.len(),
            places: own.iter().take(PLACES).map(|c| c.place).collect(),
        })
    }
}

/// Sorts shells into solids with their voids.
fn nest(
    soup: &Soup,
    shells: &[Shell],
    between: Vec<([u32; 2], DVec3)>,
    mended: &mut Mended,
) -> Vec<Solid> {
    let n = shells.len();
    let corners = |s: &Shell| -> Vec<[DVec3; 3]> {
        s.triangles
            .iter()
            .map(|&t| soup.corners(t as usize))
            .collect()
    };
    let boxes: Vec<(DVec3, DVec3)> = shells
        .iter()
        .map(|s| extent(&corners(s).concat()))
        .collect();
    // Which shells a shell lies in.
    let mut inside: Vec<Vec<usize>> = vec![Vec::new(); n];
    let mut cuts: Vec<(usize, DVec3)> = Vec::new();
    let mut together = Disjoint::new(n);
    for ([i, j], place) in between {
        cuts.push((i as usize, place));
        together.join(i, j);
    }
    for outer in 0..n {
        let near: Vec<usize> = (0..n)
            .filter(|&i| {
                i != outer
                    && boxes[i].0.cmplt(boxes[outer].1).all()
                    && boxes[i].1.cmpgt(boxes[outer].0).all()
            })
            .collect();
        if near.is_empty() {
            continue;
        }
        let bvh = TriangleBvh::new(&corners(&shells[outer]));
        // Corners that touch the other shell say nothing.
        let touch = 1e-6 * (boxes[outer].1 - boxes[outer].0).length();
        for i in near {
            let step = shells[i].triangles.len().div_ceil(ASKED);
            let asked: Vec<DVec3> = shells[i]
                .triangles
                .iter()
                .step_by(step)
                .flat_map(|&t| soup.corners(t as usize))
                .filter(|&p| bvh.any_within(p, touch).is_none())
                .collect();
            let within: Vec<DVec3> = asked.iter().copied().filter(|&p| bvh.inside(p)).collect();
            if !within.is_empty() && within.len() == asked.len() {
                inside[i].push(outer);
            } else if !within.is_empty() {
                cuts.push((i, within[0]));
                together.join(i as u32, outer as u32);
            }
        }
    }
    let mut parts: Vec<(u32, Vec<[u32; 3]>)> = Vec::new();
    for (i, shell) in shells.iter().enumerate() {
        let is_void = inside[i].len() % 2 == 1;
        let turn = (shell.volume < 0.0) != is_void;
        mended.turned += if turn { shell.triangles.len() } else { 0 };
        let own = shell.triangles.iter().map(|&t| {
            let [a, b, c] = soup.triangles[t as usize];
            if turn { [a, c, b] } else { [a, b, c] }
        });
        // A void belongs to the solid next around it: the one that lies in most others.
        let host = if is_void {
            inside[i].iter().copied().max_by_key(|&o| inside[o].len())
        } else {
            None
        };
        parts.push((together.find(host.unwrap_or(i) as u32), own.collect()));
    }
    parts.sort_by_key(|s| s.0);
    parts
        .chunk_by(|a, b| a.0 == b.0)
        .map(|run| {
            let own: Vec<DVec3> = cuts
                .iter()
                .filter(|c| together.find(c.0 as u32) == run[0].0)
                .map(|c| c.1)
                .collect();
            let triangles: Vec<[u32; 3]> = run.iter().flat_map(|s| s.1.clone()).collect();
            Solid {
                facets: compact(&soup.points, triangles),
                cut: (!own.is_empty()).then(|| ShellFault::Overlap {
                    count: own.len(),
                    places: own.into_iter().take(PLACES).collect(),
                }),
            }
        })
        .collect()
}

/// The triangles with only the points that they use, in the order of the points.
pub(super) fn compact(points: &[DVec3], mut triangles: Vec<[u32; 3]>) -> Soup {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let mut number = vec![u32::MAX; points.len()];
    for (i, &v) in (0u32..).zip(&used) {
        number[v as usize] = i;
    }
    for t in &mut triangles {
        *t = t.map(|v| number[v as usize]);
    }
    Soup {
        points: used.iter().map(|&v| points[v as usize]).collect(),
        triangles,
    }
}
