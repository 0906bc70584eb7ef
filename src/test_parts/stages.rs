//! The stages up to the raw mid-complex in their order, for tests that need what came before.

use super::voxels::Filled;
use crate::medial::Medial;
use crate::model::complex::MidComplex;
use crate::model::decomposition::{Collapsed, Decomposition, FaceRoles, Grade, Passage};
use crate::model::ids::{IndexVec, TetEdgeId, WallId};
use crate::model::sighting::Sighting;
use crate::model::tet_graph::TetGraph;
use crate::model::walls::{Aag, Pairing};
use crate::stage::pair::PairOptions;
use crate::stage::{adjacency, collapse, decompose, extract, pair, role, widen};

/// All results up to the collapse.
pub(crate) struct Stages<'a> {
    pub solid: &'a Filled,
    pub aag: Aag,
    pub sightings: Vec<Sighting>,
    pub pairing: Pairing,
    pub roles: FaceRoles,
    pub graph: TetGraph,
    pub decomposition: Decomposition,
    pub grade: IndexVec<TetEdgeId, Grade>,
    pub protected: IndexVec<TetEdgeId, bool>,
    /// Before widening.
    pub collapsed: Collapsed,
}

/// Runs them.
pub(crate) fn stages(solid: &Filled) -> Stages<'_> {
    let brep = &solid.brep;
    let aag = adjacency::adjacency(brep);
    let sightings = pair::sight(brep);
    let pairing = pair::pair(brep, &aag, &sightings, &PairOptions::default());
    let roles = role::roles(&aag, &pairing);
    let graph = TetGraph::new(&solid.tets);
    let decomposition = decompose::decompose(brep, &graph, &pairing, &roles);
    let passage = &decomposition.passage;
    let grade: IndexVec<TetEdgeId, Grade> = passage.iter().map(|&p| p as Grade).collect();
    let protected: IndexVec<TetEdgeId, bool> =
        passage.iter().map(|&p| p != Passage::Along).collect();
    let collapsed = collapse::collapse(&graph, brep.vertices.len(), &protected, &grade);
    Stages {
        solid,
        aag,
        sightings,
        pairing,
        roles,
        graph,
        decomposition,
        grade,
        protected,
        collapsed,
    }
}

impl Stages<'_> {
    pub fn medial(&self) -> Medial<'_> {
        Medial::new(&self.solid.brep, &self.aag, &self.pairing)
    }

    /// Collapses again with bars widened, until there is nothing to widen or ten rounds are over.
    pub fn widened(&self) -> Collapsed {
        let mut protected = self.protected.clone();
        let mut collapsed = self.collapsed.clone();
        for _ in 0..10 {
            let more = widen::widen(&self.graph, &collapsed, &self.grade);
            if more.is_empty() {
                break;
            }
            for e in more {
                protected[e] = true;
            }
            let vertices = self.solid.brep.vertices.len();
            collapsed = collapse::collapse(&self.graph, vertices, &protected, &self.grade);
        }
        collapsed
    }

    /// The wall of every living cell, and how many had to ask their neighbours.
    pub fn cell_walls(&self, medial: &Medial<'_>) -> (IndexVec<TetEdgeId, Option<WallId>>, usize) {
        let cells = &self.widened().cells;
        let (brep, decomposition) = (&self.solid.brep, &self.decomposition);
        extract::cell_walls(
            brep,
            &self.graph,
            &self.pairing,
            decomposition,
            cells,
            medial,
        )
    }

    /// The placed complex.
    pub fn complex(&self) -> MidComplex {
        let medial = self.medial();
        let (walls, _) = self.cell_walls(&medial);
        extract::extract(
            &self.solid.brep,
            &self.graph,
            &self.pairing,
            &walls,
            &medial,
        )
    }
}
