//! Cuts a patch that no chart can hold.
//!
//! Two seeds grow over the patch, nearest first; where they meet is the cut (Dijkstra 1959; Lloyd-like charts as in Levy et al. 2002).
//! A patch with two loops or more (a tube) is seeded along two opposite paths from its longest loop to the next, so that both halves
//! run from end to end and are open; any other patch at two places far apart. The cut runs along edges of the patch, so that both
//! sides share its nodes.

use super::assemble::{Link, Links, Soup, restrict};
use crate::geom::snap::Snap;
use crate::model::ids::NodeId;
use crate::model::patch::Patch;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The pieces of a patch after one cut: two or more, unless it has a single triangle. The cut keeps away from the nodes of `avoid`
/// (sorted) where it can choose: cuts through a mesh that itself came from a cut fall elsewhere.
pub fn cut(patch: &Patch, avoid: &[NodeId]) -> Vec<Patch> {
    if patch.triangles.len() < 2 {
        return vec![patch.clone()];
    }
    let links = links(patch);
    let avoided: Vec<bool> = patch
        .nodes
        .iter()
        .map(|n| avoid.binary_search(n).is_ok())
        .collect();
    let (first, second) =
        opposite_paths(patch, &avoided).unwrap_or_else(|| far_triangles(patch, &links, &avoided));
    let mut side = grow(patch, &links, &first, &second);
    smooth(&links, &mut side);
    pieces(&side, &links)
        .iter()
        .map(|members| part(patch, &links, members))
        .collect()
}

/// The links of a patch, found by its edges.
fn links(patch: &Patch) -> Vec<Links> {
    let mut half: Vec<([u32; 2], u32, u8)> = Vec::with_capacity(3 * patch.triangles.len());
    for (t, c) in patch.triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            half.push(([a.min(b), a.max(b)], t as u32, k as u8));
        }
    }
    half.sort_unstable();
    let mut links: Vec<Links> = vec![[None; 3]; patch.triangles.len()];
    for pair in half.windows(2) {
        let ((e, t, k), (f, u, j)) = (pair[0], pair[1]);
        if e == f {
            let kept = patch.kept_edges.binary_search(&e).is_ok();
            links[t as usize][k as usize] = Some(Link::new(u, j, kept));
            links[u as usize][j as usize] = Some(Link::new(t, k, kept));
        }
    }
    links
}

/// Triangles along two opposite paths between the two longest loops; `None` where there are not two.
fn opposite_paths(patch: &Patch, avoided: &[bool]) -> Option<(Vec<u32>, Vec<u32>)> {
    let (from, to) = (patch.loops.first()?, patch.loops.get(1)?);
    let around = neighbours(patch);
    let start = from
        .iter()
        .find(|&&c| avoided[c as usize])
        .or(from.first())?;
    let path = |start: u32| {
        let (distance, parent) = corner_distances(patch, &around, &[start], avoided);
        let end = to
            .iter()
            .min_by(|a, b| distance[**a as usize].total_cmp(&distance[**b as usize]))?;
        let mut path = vec![*end];
        while let Some(&at) = path.last()
            && parent[at as usize] != u32::MAX
        {
            path.push(parent[at as usize]);
        }
        Some(path)
    };
    let first = path(*start)?;
    let (distance, _) = corner_distances(patch, &around, &first, &[]);
    let far = from
        .iter()
        .max_by(|a, b| distance[**a as usize].total_cmp(&distance[**b as usize]))?;
    let second = path(*far)?;
    let touching = |path: &[u32], but: &[u32]| {
        let mut on = vec![0u8; patch.nodes.len()];
        path.iter().for_each(|&c| on[c as usize] |= 1);
        but.iter().for_each(|&c| on[c as usize] |= 2);
        (0..patch.triangles.len() as u32)
            .filter(|&t| {
                let marks = patch.triangles[t as usize].map(|c| on[c as usize]);
                marks.iter().any(|m| m & 1 != 0) && marks.iter().all(|m| m & 2 == 0)
            })
            .collect::<Vec<_>>()
    };
    let seeds = (touching(&first, &second), touching(&second, &first));
    (!seeds.0.is_empty() && !seeds.1.is_empty()).then_some(seeds)
}

/// Two triangles far from each other, on avoided nodes where there are any.
fn far_triangles(patch: &Patch, links: &[Links], avoided: &[bool]) -> (Vec<u32>, Vec<u32>) {
    let on_avoided = |t: &u32| {
        patch.triangles[*t as usize]
            .iter()
            .any(|&c| avoided[c as usize])
    };
    let mut candidates: Vec<u32> = (0..patch.triangles.len() as u32)
        .filter(on_avoided)
        .collect();
    if candidates.len() < 2 {
        candidates = (0..patch.triangles.len() as u32).collect();
    }
    let farthest = |from: u32| {
        let (distance, _) = triangle_distances(patch, links, &[(from, 0)]);
        let by = |a: &&u32, b: &&u32| distance[**a as usize].total_cmp(&distance[**b as usize]);
        candidates.iter().max_by(by).copied().unwrap_or(from)
    };
    let first = farthest(candidates[0]);
    let second = farthest(first);
    if first == second {
        let other = candidates.iter().find(|&&t| t != first);
        return (vec![first], vec![other.copied().unwrap_or(first)]);
    }
    (vec![first], vec![second])
}

/// Which seed is nearer to each triangle.
fn grow(patch: &Patch, links: &[Links], first: &[u32], second: &[u32]) -> Vec<u8> {
    let seeds: Vec<(u32, u8)> = first
        .iter()
        .map(|&t| (t, 0))
        .chain(second.iter().map(|&t| (t, 1)))
        .collect();
    triangle_distances(patch, links, &seeds).1
}

/// Distance over centroids to the nearest seed, mm, and its mark.
fn triangle_distances(patch: &Patch, links: &[Links], seeds: &[(u32, u8)]) -> (Vec<f64>, Vec<u8>) {
    let centre = |t: u32| {
        let [a, b, c] = patch.triangle_points(t as usize);
        (a + b + c) / 3.0
    };
    let snap = Snap::for_size(patch.area().sqrt());
    let mut distance = vec![f64::INFINITY; patch.triangles.len()];
    let mut mark = vec![0u8; patch.triangles.len()];
    let mut heap = BinaryHeap::new();
    for &(t, m) in seeds {
        distance[t as usize] = 0.0;
        mark[t as usize] = m;
        heap.push(Reverse((Total(0.0), t)));
    }
    while let Some(Reverse((Total(d), t))) = heap.pop() {
        if d > distance[t as usize] {
            continue;
        }
        for link in links[t as usize].iter().flatten() {
            let u = link.triangle;
            let reach = d + snap.value(centre(t).distance(centre(u)));
            if reach < distance[u as usize] {
                distance[u as usize] = reach;
                mark[u as usize] = mark[t as usize];
                heap.push(Reverse((Total(reach), u)));
            }
        }
    }
    (distance, mark)
}

/// Distance along edges to the nearest of `from`, mm, and the corner before on the way. Ways between avoided corners count half: a
/// seed path lies on an old cut where there is one, so that the new cut lies far from it.
fn corner_distances(
    patch: &Patch,
    around: &[Vec<u32>],
    from: &[u32],
    avoided: &[bool],
) -> (Vec<f64>, Vec<u32>) {
    let snap = Snap::for_size(patch.area().sqrt());
    let mut distance = vec![f64::INFINITY; patch.nodes.len()];
    let mut parent = vec![u32::MAX; patch.nodes.len()];
    let mut heap = BinaryHeap::new();
    for &c in from {
        distance[c as usize] = 0.0;
        heap.push(Reverse((Total(0.0), c)));
    }
    let on = |c: u32| avoided.get(c as usize).copied().unwrap_or(false);
    while let Some(Reverse((Total(d), c))) = heap.pop() {
        if d > distance[c as usize] {
            continue;
        }
        for &n in &around[c as usize] {
            let length = patch.points[c as usize].distance(patch.points[n as usize]);
            let length = 2.0 * snap.value(length / 2.0);
            let reach = d + if on(c) && on(n) { 0.5 * length } else { length };
            if reach < distance[n as usize] {
                distance[n as usize] = reach;
                parent[n as usize] = c;
                heap.push(Reverse((Total(reach), n)));
            }
        }
    }
    (distance, parent)
}

fn neighbours(patch: &Patch) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); patch.nodes.len()];
    for t in &patch.triangles {
        for k in 0..3 {
            around[t[k] as usize].extend([t[(k + 1) % 3], t[(k + 2) % 3]]);
        }
    }
    for list in &mut around {
        list.sort_unstable();
        list.dedup();
    }
    around
}

/// Takes teeth off the cut: a triangle goes to the side that two of its neighbours are on.
fn smooth(links: &[Links], side: &mut [u8]) {
    let before = side.to_vec();
    // Teeth on teeth need a few rounds; more would only let the cut creep.
    for _ in 0..4 {
        for t in 0..side.len() {
            let other = 1 - side[t];
            let near = links[t].iter().flatten();
            if near.filter(|l| side[l.triangle as usize] == other).count() >= 2 {
                side[t] = other;
            }
        }
    }
    if side.iter().all(|s| *s == side[0]) {
        side.copy_from_slice(&before);
    }
}

/// Connected sets of triangles on one side, each sorted, in order of their lowest triangle.
fn pieces(side: &[u8], links: &[Links]) -> Vec<Vec<u32>> {
    let mut seen = vec![false; side.len()];
    let mut pieces = Vec::new();
    for start in 0..side.len() {
        if seen[start] {
            continue;
        }
        seen[start] = true;
        let mut list = vec![start as u32];
        let mut at = 0;
        while at < list.len() {
            for link in links[list[at] as usize].iter().flatten() {
                let u = link.triangle as usize;
                if !seen[u] && side[u] == side[start] {
                    seen[u] = true;
                    list.push(u as u32);
                }
            }
            at += 1;
        }
        list.sort_unstable();
        pieces.push(list);
    }
    pieces
}

/// The patch of some triangles of a patch.
fn part(patch: &Patch, links: &[Links], members: &[u32]) -> Patch {
    let mut place: Vec<(NodeId, u32)> = Vec::with_capacity(3 * members.len());
    for &t in members {
        place.extend(patch.triangles[t as usize].map(|c| (patch.nodes[c as usize], c)));
    }
    place.sort_unstable();
    place.dedup();
    let corner_of = |n: NodeId| {
        let at = place.partition_point(|p| p.0 < n);
        place.get(at).map_or(0, |p| p.1)
    };
    let soup = Soup {
        wall: patch.wall,
        corners: members
            .iter()
            .map(|&t| patch.triangles[t as usize].map(|c| patch.nodes[c as usize]))
            .collect(),
        source: members.iter().map(|&t| patch.source[t as usize]).collect(),
        links: restrict(links, members),
    };
    soup.assemble(
        |n| patch.points[corner_of(n) as usize],
        |n| patch.kept_corners.binary_search(&corner_of(n)).is_ok(),
    )
}

/// A length that can be ordered.
#[derive(Clone, Copy, PartialEq)]
struct Total(f64);
impl Eq for Total {}
impl PartialOrd for Total {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Total {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}
