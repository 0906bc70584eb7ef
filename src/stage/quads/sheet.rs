//! One sheet: from its triangles to cells, and from cells to triangles with diagonals.

use super::cells::{Cells, Ground, Place, Ring};
use super::insert::{insert, relieve};
use super::matching::{self, Edge};
use super::smooth::{Effort, mean_edge, smooth};
use super::stretch::{stretches, undone};
use super::transport::transport;
use super::valence::clean_up;
use crate::geom::fold;
use crate::geom::placer::Placer;
use crate::geom::quality::quad_quality;
use crate::model::complex::{MidComplex, MidEdge, Support, pin};
use crate::model::ids::{IndexVec, NodeId, TriangleId, WallId};
use crate::spatial::{Hint, TriangleBvh};
use glam::DVec3;
use smallvec::SmallVec;
use std::collections::BTreeSet;

/// Rounds of pairing up single triangles and cleaning up: what one round left in the way the next may pass.
const ROUNDS: usize = 2;
/// A pair with an angle of no use to a solver, or turned over, is none.
const USABLE: f64 = 0.1;
/// A node may be put this far from where smoothing left it, in mean edge lengths: further is another branch of the surface.
const NEAR: f64 = 0.3;

/// Cells at a node on the outer circle of a washer, beside the two of the washer.
const AT_PINS: u8 = 2;

/// The triangles of a sheet, with its nodes counted anew: held ones first.
pub(super) struct Sheet {
    pub wall: WallId,
    pub source: Vec<TriangleId>,
    nodes: Vec<NodeId>,
    /// How many of the nodes are held; those come first.
    held: usize,
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    kept: Vec<[u32; 2]>,
    /// The sheets of the held nodes.
    owners: Vec<Owners>,
    /// Nodes with places of their own: a washer's quads will come to them from the other side.
    pinned: Vec<u32>,
}

/// The sheets that a node belongs to, by their first triangles.
pub(super) type Owners = SmallVec<[u32; 3]>;

/// A sheet of quads, as triangles.
pub(super) struct Made {
    pub points: Vec<DVec3>,
    /// Which nodes are in use.
    pub lives: Vec<bool>,
    pub triangles: Vec<[u32; 3]>,
    pub diagonals: Vec<[u32; 2]>,
}

/// Whether the triangles at an inner edge meet at a fold, or are wound against each other.
pub(super) fn is_fold(complex: &MidComplex, edge: &MidEdge) -> bool {
    let [s, t] = [0, 1].map(|i| &complex.triangles[edge.triangles[i]]);
    let [n, m] = [s, t].map(|t| complex.area_vector(t).normalize_or_zero());
    s.runs(edge.ends) == t.runs(edge.ends) || fold::is_fold(n, m)
}

impl Sheet {
    pub(super) fn new(
        complex: &MidComplex,
        members: &[TriangleId],
        held: &IndexVec<NodeId, bool>,
        owners: &IndexVec<NodeId, Owners>,
        kept: &BTreeSet<[NodeId; 2]>,
    ) -> Self {
        let corners = || members.iter().flat_map(|&t| complex.triangles[t].nodes);
        let mut nodes: Vec<NodeId> = corners().collect();
        nodes.sort_unstable_by_key(|&n| (!held[n], n));
        nodes.dedup();
        let count = nodes.partition_point(|&n| held[n]);
        let place = |n: NodeId| nodes.partition_point(|&m| (!held[m], m) < (!held[n], n)) as u32;
        let triangles: Vec<[u32; 3]> = (members.iter())
            .map(|&t| complex.triangles[t].nodes.map(place))
            .collect();
        let mut own: Vec<[u32; 2]> = (members.iter())
            .flat_map(|&t| {
                let n = complex.triangles[t].nodes;
                [[n[0], n[1]], [n[1], n[2]], [n[2], n[0]]]
            })
            .filter(|[a, b]| kept.contains(&[*a.min(b), *a.max(b)]))
            .map(|e| {
                let [a, b] = e.map(place);
                [a.min(b), a.max(b)]
            })
            .collect();
        own.sort_unstable();
        own.dedup();
        Self {
            wall: complex.triangles[members[0]].wall,
            source: members.to_vec(),
            points: nodes.iter().map(|&n| complex.nodes[n].point).collect(),
            owners: nodes[..count].iter().map(|&n| owners[n].clone()).collect(),
            pinned: (0..count as u32)
                .filter(|&i| pin(&complex.nodes[nodes[i as usize]].supports).is_some())
                .collect(),
            nodes,
            held: count,
            triangles,
            kept: own,
        }
    }

    /// The node of the complex that a held one is.
    pub(super) fn held_node(&self, node: u32) -> Option<NodeId> {
        let node = node as usize;
        (node < self.held).then(|| self.nodes[node])
    }

    /// The held nodes: each one's number here, and its own.
    pub(super) fn held_nodes(&self) -> impl Iterator<Item = (u32, NodeId)> + '_ {
        (0u32..).zip(self.nodes[..self.held].iter().copied())
    }

    /// The ground that its nodes stay on.
    pub(super) fn ground(&self) -> Facets {
        let triangles: Vec<[DVec3; 3]> = (self.triangles.iter())
            .map(|t| t.map(|n| self.points[n as usize]))
            .collect();
        Facets::new(&triangles, stretches(&self.points, &self.triangles))
    }

    /// The sheet in quads.
    pub(super) fn quadded(&self, ground: &dyn Ground) -> Cells {
        let mut cells = self.paired(ground);
        for _ in 0..ROUNDS {
            transport(&mut cells, ground);
            insert(&mut cells, ground);
            relieve(&mut cells, ground);
            clean_up(&mut cells, ground);
            smooth(&mut cells, ground, Effort::Brief);
        }
        cells
    }

    /// Triangles paired into as many quads as can be.
    fn paired(&self, ground: &dyn Ground) -> Cells {
        let rings: Vec<Ring> = (self.triangles.iter())
            .map(|t| t.iter().copied().collect())
            .collect();
        let held = (0..self.points.len()).map(|n| n < self.held).collect();
        // At a fold the normal is that of both sides together, so that neither is against it.
        let mut normals = vec![DVec3::ZERO; self.points.len()];
        for t in &self.triangles {
            let [a, b, c] = t.map(|n| self.points[n as usize]);
            t.iter()
                .for_each(|&n| normals[n as usize] += (b - a).cross(c - a));
        }
        let places = (self.points.iter().zip(normals))
            .map(|(&point, normal)| Place {
                point,
                normal: normal.normalize_or_zero(),
                ..ground.foot(point, None)
            })
            .collect();
        let mut cells = Cells::new(places, held, rings, self.kept.clone());
        cells.owners = self.owners.clone();
        for &n in &self.pinned {
            cells.expect(n, AT_PINS);
        }

        let mut edges = Vec::new();
        let mut rings: Vec<(u32, u32, Ring)> = Vec::new();
        for cell in 0..self.triangles.len() as u32 {
            for k in 0..3 {
                let Some(other) = cells.across(cell, k).filter(|&o| o > cell) else {
                    continue;
                };
                let t = self.triangles[cell as usize];
                let Some(apex) = (self.triangles[other as usize].into_iter())
                    .find(|n| *n != t[k] && *n != t[(k + 1) % 3])
                else {
                    continue;
                };
                let ring = [t[(k + 2) % 3], t[k], apex, t[(k + 1) % 3]];
                if apex == t[(k + 2) % 3] {
                    continue;
                }
                if cells.worth(&ring) < USABLE {
                    continue;
                }
                // Rows along a bend that are laid a little beside each other are none the worse for it.
                let stretch = cells.place(ring[0]).stretch;
                let even = ring.map(|n| undone(self.points[n as usize], stretch));
                edges.push(Edge {
                    ends: [cell, other],
                    weight: (1.0 - quad_quality(even).equiangle_skew).max(0.0),
                });
                rings.push((cell, other, ring.into_iter().collect()));
            }
        }
        let mate = matching::pair(self.triangles.len(), &edges);
        for (a, b, ring) in rings {
            if mate[a as usize] == Some(b) && cells.lives[a as usize] {
                cells.exchange(&[a, b], &[ring]);
            }
        }
        cells
    }

    /// Free nodes onto the exact mid-surface, where that turns nothing over.
    pub(super) fn place(&self, cells: &mut Cells, placer: &dyn Placer) {
        let supports = [Support::Mid(self.wall)];
        for n in 0..cells.points.len() as u32 {
            if cells.held[n as usize] || cells.star(n).is_empty() {
                continue;
            }
            let star = cells.star(n).clone();
            let place = cells.place(n);
            let here = place.point;
            let reach = mean_edge(cells, n);
            let before = cells.worst(&star);
            let placed = placer.place(here, &supports);
            if !(placed.is_finite() && placed.distance(here) < NEAR * reach) {
                continue;
            }
            let point = placed;
            cells.put(n, Place { point, ..place });
            if cells.worst(&star) < before.min(USABLE) {
                cells.put(n, place);
            }
        }
    }

    /// Cells as triangles: quads along the shorter diagonal, unless an edge joins its ends already; bad quads as two triangles of their own, and those whose ends are all joined
    /// already as four with a node in their middle. `None` where a cell is neither triangle nor quad.
    pub(super) fn halved(&self, cells: &Cells) -> Option<Made> {
        let mut triangles = Vec::new();
        let mut diagonals: BTreeSet<[u32; 2]> = BTreeSet::new();
        let mut own: BTreeSet<[u32; 2]> = BTreeSet::new();
        let mut points = cells.points.clone();
        let mut lives = vec![false; cells.points.len()];
        for c in cells.living() {
            let ring = cells.ring(c);
            ring.iter().for_each(|&n| lives[n as usize] = true);
            if let &[a, b, c] = ring.as_slice() {
                triangles.push([a, b, c]);
                continue;
            }
            let &[p, q, r, s] = ring.as_slice() else {
                return None;
            };
            let length =
                |a: u32, b: u32| cells.points[a as usize].distance(cells.points[b as usize]);
            let fits = |&[a, _, b, _]: &[u32; 4]| {
                let edge = [a.min(b), a.max(b)];
                let new = !diagonals.contains(&edge) && !own.contains(&edge);
                new && cells.may_join(a, b) && !cells.joined(a, b)
            };
            let worth =
                |&[a, b, c, d]: &[u32; 4]| cells.worth(&[a, b, c]).min(cells.worth(&[a, c, d]));
            // Of two equal ones rounding must not decide.
            let first = length(p, r) <= length(q, s) * (1.0 + 1e-6);
            let ways = [[p, q, r, s], [q, r, s, p]];
            let ways = if first { ways } else { [ways[1], ways[0]] };
            let mut open = ways.into_iter().filter(fits);
            let good = cells.worth(ring) >= USABLE;
            let best = if good {
                open.next()
            } else {
                open.reduce(|a, b| if worth(&b) > worth(&a) { b } else { a })
            };
            let Some([a, b, c, d]) = best else {
                let middle = points.len() as u32;
                points.push(
                    ring.iter()
                        .map(|&n| cells.points[n as usize])
                        .sum::<DVec3>()
                        / 4.0,
                );
                lives.push(true);
                triangles.extend([
                    [p, q, middle],
                    [q, r, middle],
                    [r, s, middle],
                    [s, p, middle],
                ]);
                continue;
            };
            triangles.extend([[a, b, c], [a, c, d]]);
            if good {
                diagonals.insert([a.min(c), a.max(c)]);
            } else {
                own.insert([a.min(c), a.max(c)]);
            }
        }
        Some(Made {
            points,
            lives,
            triangles,
            diagonals: diagonals.into_iter().collect(),
        })
    }
}

/// The triangles of a sheet as the ground that its nodes stay on.
pub(super) struct Facets {
    bvh: TriangleBvh,
    normals: Vec<DVec3>,
    /// Which way the cells on each triangle are to be long, see [`Place`].
    stretches: Vec<DVec3>,
    /// A point and the normal, where all of them lie in one plane.
    plane: Option<(DVec3, DVec3)>,
}

/// Flat to rounding, as a share of the sheet's size.
const FLAT: f64 = 1e-10;

impl Facets {
    fn new(triangles: &[[DVec3; 3]], stretches: Vec<DVec3>) -> Self {
        let doubled = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a);
        let normal = (triangles.iter().map(doubled).sum::<DVec3>()).normalize_or_zero();
        let origin = triangles.first().map_or(DVec3::ZERO, |t| t[0]);
        let corners = || triangles.iter().flatten().map(|p| p - origin);
        let size = corners().map(DVec3::length).fold(0.0, f64::max);
        let flat = corners().all(|p| p.dot(normal).abs() <= FLAT * size);
        Self {
            bvh: TriangleBvh::new(triangles),
            normals: triangles
                .iter()
                .map(|t| doubled(t).normalize_or_zero())
                .collect(),
            stretches,
            plane: flat.then_some((origin, normal)),
        }
    }
}

impl Ground for Facets {
    fn foot(&self, p: DVec3, near: Option<Hint>) -> Place {
        if let Some((origin, normal)) = self.plane {
            return Place {
                point: p - normal * (p - origin).dot(normal),
                normal,
                hint: None,
                stretch: DVec3::ZERO,
            };
        }
        match self.bvh.nearest_from(p, near) {
            Some(found) => Place {
                point: found.point,
                normal: self.normals[found.index],
                hint: Some(found.hint),
                stretch: self.stretches[found.index],
            },
            None => Place {
                point: p,
                normal: DVec3::Z,
                hint: None,
                stretch: DVec3::ZERO,
            },
        }
    }
}
