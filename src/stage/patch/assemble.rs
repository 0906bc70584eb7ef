//! Triangles with their neighbours made into a patch: oriented, corners told apart, boundary walked.

use crate::geom::snap::Snap;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{NodeId, TriangleId, WallId};
use crate::model::patch::Patch;
use glam::DVec3;

/// What lies across an edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Link {
    /// The triangle there.
    pub triangle: u32,
    /// Which of its edges it is (from corner k to k + 1).
    pub edge: u8,
    /// Whether the edge must stay.
    pub kept: bool,
}

impl Link {
    pub(super) fn new(triangle: u32, edge: u8, kept: bool) -> Self {
        Self {
            triangle,
            edge,
            kept,
        }
    }
}

/// The links over the edges of a triangle; `None` at the boundary.
pub(super) type Links = [Option<Link>; 3];

/// The links among some triangles, counted anew in their order (`members` is sorted).
pub(super) fn restrict(links: &[Links], members: &[u32]) -> Vec<Links> {
    members
        .iter()
        .map(|&t| {
            links[t as usize].map(|link| {
                let link = link?;
                let place = members.binary_search(&link.triangle).ok()?;
                Some(Link::new(place as u32, link.edge, link.kept))
            })
        })
        .collect()
}

/// Connected triangles with their links.
pub(super) struct Soup {
    pub wall: WallId,
    pub corners: Vec<[NodeId; 3]>,
    pub source: Vec<TriangleId>,
    pub links: Vec<Links>,
}

impl Soup {
    /// The patch; `point` and `must_stay` tell about a node.
    pub(super) fn assemble(
        mut self,
        point: impl Fn(NodeId) -> DVec3,
        must_stay: impl Fn(NodeId) -> bool,
    ) -> Patch {
        self.orient();
        let corner = self.fans();
        // A corner has one number a patch, given in order of first use.
        let mut number = vec![u32::MAX; corner.len()];
        let (mut nodes, mut points) = (Vec::new(), Vec::new());
        let mut triangles = Vec::with_capacity(self.corners.len());
        for (t, names) in self.corners.iter().enumerate() {
            triangles.push([0, 1, 2].map(|k| {
                let fan = corner[3 * t + k] as usize;
                if number[fan] == u32::MAX {
                    number[fan] = nodes.len() as u32;
                    nodes.push(names[k]);
                    points.push(point(names[k]));
                }
                number[fan]
            }));
        }
        let (loops, on_boundary) = self.loops(&triangles, &points);
        let mut kept_edges = Vec::new();
        for (t, links) in self.links.iter().enumerate() {
            for k in 0..3 {
                if links[k].is_some_and(|l| l.kept && l.triangle as usize > t) {
                    let (a, b) = (triangles[t][k], triangles[t][(k + 1) % 3]);
                    kept_edges.push([a.min(b), a.max(b)]);
                }
            }
        }
        kept_edges.sort_unstable();
        let mut kept_corners: Vec<u32> = kept_edges.iter().flatten().copied().collect();
        kept_corners.extend((0..nodes.len() as u32).filter(|&c| must_stay(nodes[c as usize])));
        kept_corners.retain(|&c| !on_boundary[c as usize]);
        kept_corners.sort_unstable();
        kept_corners.dedup();
        Patch {
            wall: self.wall,
            nodes,
            points,
            triangles,
            source: self.source,
            loops,
            kept_edges,
            kept_corners,
        }
    }

    /// Turns triangles so that neighbours agree with the first one; where they cannot, the link between them is cut.
    fn orient(&mut self) {
        let n = self.corners.len();
        let mut turned: Vec<Option<bool>> = vec![None; n];
        for start in 0..n {
            if turned[start].is_some() {
                continue;
            }
            turned[start] = Some(false);
            let mut queue = std::collections::VecDeque::from([start]);
            while let Some(t) = queue.pop_front() {
                for k in 0..3 {
                    let Some(link) = self.links[t][k] else {
                        continue;
                    };
                    let (u, j) = (link.triangle as usize, link.edge as usize);
                    let against = self.corners[t][k] != self.corners[u][j];
                    let wanted = Some((turned[t] == Some(true)) ^ !against);
                    if turned[u].is_none() {
                        turned[u] = wanted;
                        queue.push_back(u);
                    } else if turned[u] != wanted {
                        self.links[t][k] = None;
                        self.links[u][j] = None;
                    }
                }
            }
        }
        let is_turned = |t: u32| turned[t as usize] == Some(true);
        for t in 0..n {
            for link in self.links[t].iter_mut().flatten() {
                if is_turned(link.triangle) {
                    link.edge = 2 - link.edge;
                }
            }
            if is_turned(t as u32) {
                self.corners[t].swap(1, 2);
                self.links[t].swap(0, 2);
            }
        }
    }

    /// For every corner of every triangle (3 t + k) the lowest one that is joined to it round a node.
    fn fans(&self) -> Vec<u32> {
        let count = 3 * self.corners.len();
        let mut sets = Disjoint::new(count);
        for (t, links) in self.links.iter().enumerate() {
            for (k, link) in links.iter().enumerate() {
                let Some(l) = *link else { continue };
                let (u, j) = (l.triangle as usize, l.edge as usize);
                for (a, b) in [
                    (3 * t + k, 3 * u + (j + 1) % 3),
                    (3 * t + (k + 1) % 3, 3 * u + j),
                ] {
                    sets.join(a as u32, b as u32);
                }
            }
        }
        (0..count as u32).map(|i| sets.find(i)).collect()
    }

    /// The boundary loops, longest first, and which corners lie on them.
    fn loops(&self, triangles: &[[u32; 3]], points: &[DVec3]) -> (Vec<Vec<u32>>, Vec<bool>) {
        let mut next = vec![u32::MAX; points.len()];
        for (t, links) in self.links.iter().enumerate() {
            for (k, link) in links.iter().enumerate() {
                if link.is_none() {
                    next[triangles[t][k] as usize] = triangles[t][(k + 1) % 3];
                }
            }
        }
        let on_boundary: Vec<bool> = next.iter().map(|&n| n != u32::MAX).collect();
        let mut loops: Vec<(f64, Vec<u32>)> = Vec::new();
        for start in 0..next.len() {
            let (mut list, mut length) = (Vec::new(), 0.0);
            let mut at = start;
            while next[at] != u32::MAX {
                list.push(at as u32);
                let to = std::mem::replace(&mut next[at], u32::MAX) as usize;
                length += points[at].distance(points[to]);
                at = to;
            }
            if !list.is_empty() {
                loops.push((length, list));
            }
        }
        let snap = Snap::for_size(loops.iter().map(|l| l.0).sum());
        loops.sort_by(|a, b| snap.value(b.0).total_cmp(&snap.value(a.0)));
        (loops.into_iter().map(|l| l.1).collect(), on_boundary)
    }
}
