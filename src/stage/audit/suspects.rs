//! What gives rise to each doubt: elements, edges, nodes, samples of bare walls.

use super::coverage::Coverage;
use super::homology::{Homology, Void};
use super::places::{Finding, heaviest, node_key};
use super::skin::Skin;
use super::topology::Topology;
use super::walls::{Astray, Measure, Walls};
use crate::model::brep::Brep;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{ElementId, NodeId};
use crate::model::report::{AuditLimits, DoubtRule, Place};
use crate::model::shell::ShellMesh;
use glam::DVec3;
use std::collections::BTreeMap;

/// All that was seen of a mesh and its solids.
pub(super) struct Seen<'a> {
    pub pieces: &'a [&'a Brep],
    pub skin: &'a Skin,
    pub mesh: &'a ShellMesh,
    pub topology: &'a Topology,
    pub homology: Option<&'a Homology>,
    pub voids: &'a [Void],
    pub measure: &'a Measure<'a>,
    pub walls: &'a Walls,
    pub coverage: &'a Coverage,
    pub limits: AuditLimits,
}

impl Seen<'_> {
    /// What speaks for a doubt by this rule.
    pub fn findings(&self, rule: DoubtRule) -> Vec<Finding> {
        let topology = self.topology;
        match rule {
            DoubtRule::Euler => self.euler(),
            DoubtRule::Pieces => self.pieces(),
            DoubtRule::RError => self.astray(Astray::Middle, self.limits.r_error),
            DoubtRule::Thickness | DoubtRule::Mass => {
                self.astray(Astray::Thickness, self.limits.thickness_error)
            }
            DoubtRule::Outside => self.astray(Astray::Outside, 0.0),
            DoubtRule::Cover => self.coverage.bare.clone(),
            DoubtRule::FreeEdges => self.coverage.off_rim.clone(),
            DoubtRule::Flipped => self.elements(&topology.flipped),
            DoubtRule::NotFinite => self.elements(&topology.not_finite),
            DoubtRule::Orientation => {
                let edges = topology.misoriented.iter();
                edges.map(|(edge, two)| self.edge(edge, two)).collect()
            }
            DoubtRule::Orphans => topology.orphans.iter().map(|n| self.node(*n)).collect(),
            DoubtRule::Unmeasured => {
                let all: Vec<ElementId> = self.mesh.elements.ids().collect();
                self.elements(&all)
            }
            DoubtRule::Voids => self.voids(),
        }
    }

    fn astray(&self, what: Astray, limit: f64) -> Vec<Finding> {
        self.measure.astray(self.walls, what, limit)
    }

    fn elements(&self, ids: &[ElementId]) -> Vec<Finding> {
        ids.iter().map(|id| self.element(*id)).collect()
    }

    fn element(&self, id: ElementId) -> Finding {
        let element = &self.mesh.elements[id];
        let nodes = element.corners.as_slice();
        Finding {
            at: self.centre(nodes),
            value: 1.0,
            weight: 1.0,
            faces: element.source_faces.to_vec(),
            elements: vec![id],
            keys: nodes.iter().map(|n| node_key(*n)).collect(),
        }
    }

    /// Mean of those nodes that are there and finite.
    fn centre(&self, nodes: &[NodeId]) -> DVec3 {
        let points = nodes.iter().filter_map(|n| self.mesh.nodes.get(*n));
        let (sum, count) = points
            .filter(|p| p.is_finite())
            .fold((DVec3::ZERO, 0.0), |(sum, n), p| (sum + *p, n + 1.0));
        sum / f64::max(count, 1.0)
    }

    fn edge(&self, edge: &[NodeId; 2], elements: &[ElementId]) -> Finding {
        let faces = elements
            .iter()
            .flat_map(|e| self.mesh.elements[*e].source_faces);
        Finding {
            at: self.centre(edge),
            value: 1.0,
            weight: 1.0,
            faces: faces.collect(),
            elements: elements.to_vec(),
            keys: edge.map(node_key).to_vec(),
        }
    }

    fn node(&self, node: NodeId) -> Finding {
        Finding {
            at: self.centre(&[node]),
            value: 1.0,
            weight: 1.0,
            faces: Vec::new(),
            elements: Vec::new(),
            keys: vec![node_key(node)],
        }
    }

    /// A tear is a loop of free edges with material where its hole should be; a slit has free edges on no rim; a lost wall is bare; a hole that was closed
    /// has mesh outside. The first of these that is there; where none is, the smallest loops, holes that the solid may not have.
    fn euler(&self) -> Vec<Finding> {
        let loops = self.loops();
        let torn = loops.iter().filter(|l| self.skin.holds(l.at, 0.0)).cloned();
        let mut few = heaviest(torn.collect(), Place::MOST);
        if few.is_empty() {
            few = self.coverage.off_rim.clone();
        }
        if few.is_empty() {
            few = self.coverage.bare.clone();
            few.extend(self.astray(Astray::Outside, 0.0));
        }
        if few.is_empty() {
            few = heaviest(loops, Place::MOST);
        }
        few
    }

    /// The loops of free edges, the smaller the weightier: rims round whole sheets, which may have material in their middle too, come last.
    fn loops(&self) -> Vec<Finding> {
        let free = self.topology.free.iter();
        let free: Vec<_> = free
            .filter(|(edge, _)| self.mesh.nodes.get(edge[1]).is_some())
            .collect();
        let mut sets = Disjoint::new(self.mesh.nodes.len());
        for ([a, b], _) in &free {
            sets.join(a.0, b.0);
        }
        let mut loops: BTreeMap<u32, Vec<Finding>> = BTreeMap::new();
        for (edge, element) in free {
            let of = loops.entry(sets.find(edge[0].0)).or_default();
            of.push(self.edge(edge, &[*element]));
        }
        let whole = |edges: Vec<Finding>| {
            let count = edges.len() as f64;
            Finding {
                at: edges.iter().fold(DVec3::ZERO, |sum, f| sum + f.at) / count,
                value: 1.0,
                weight: 1.0 / count,
                faces: edges.iter().flat_map(|f| f.faces.clone()).collect(),
                elements: edges.into_iter().flat_map(|f| f.elements).collect(),
                keys: Vec::new(),
            }
        };
        loops.into_values().map(whole).collect()
    }

    /// The elements of all pieces but the largest, as many as there are solids; where pieces are missing, the solids without mesh.
    fn pieces(&self) -> Vec<Finding> {
        let mut of: BTreeMap<ElementId, Vec<ElementId>> = BTreeMap::new();
        for (id, piece) in self.mesh.elements.ids().zip(&self.topology.piece_of) {
            of.entry(*piece).or_default().push(id);
        }
        let mut pieces: Vec<Vec<ElementId>> = of.into_values().collect();
        pieces.sort_by_key(|p| std::cmp::Reverse(p.len()));
        let spare = pieces.iter().skip(self.pieces.len());
        let mut all: Vec<Finding> = spare.flat_map(|p| self.elements(p)).collect();
        let mut meshed: Vec<i32> = (self.mesh.elements.iter())
            .filter_map(|e| self.mesh.sheets.get(e.sheet))
            .map(|s| s.solid_tag)
            .collect();
        meshed.sort_unstable();
        meshed.dedup();
        if pieces.len() < self.pieces.len() {
            let bare = self.pieces.iter();
            all.extend(
                bare.filter(|s| meshed.binary_search(&s.solid_tag).is_err())
                    .map(|s| whole_solid(s)),
            );
        }
        all
    }

    /// The closed sets of elements where there are too many; the solid's voids where there are too few.
    fn voids(&self) -> Vec<Finding> {
        let closed = self.homology.map_or(&[][..], |h| &h.closed[..]);
        if closed.len() > self.voids.len() {
            return closed.iter().flat_map(|e| self.elements(e)).collect();
        }
        let void = |v: &Void| Finding {
            at: v.centre,
            value: 1.0,
            weight: v.reach,
            faces: v.faces.clone(),
            elements: Vec::new(),
            keys: Vec::new(),
        };
        self.voids.iter().map(void).collect()
    }
}

/// A solid of which nothing is meshed.
fn whole_solid(solid: &Brep) -> Finding {
    let corners = || solid.facets.ids().flat_map(|f| solid.corners(f));
    let (low, high) = corners().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| {
        (l.min(p), h.max(p))
    });
    Finding {
        at: if low.is_finite() {
            (low + high) / 2.0
        } else {
            DVec3::ZERO
        },
        value: 1.0,
        weight: 1.0,
        faces: solid.faces.iter().map(|f| f.tag).collect(),
        elements: Vec::new(),
        keys: Vec::new(),
    }
}
