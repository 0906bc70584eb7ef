//! The surface of one solid, as gmsh meshed it without filling it: facets with their faces, and the curves between the faces.
//!
//! Limits: the facets need not be closed, nor oriented alike; they may overlap.

use std::collections::BTreeMap;

use glam::DVec3;

use super::msh::{Msh, MshEntity};
use super::piece::{PieceError, blocks, face_name, middles, own_entities};
use crate::geom::six_node::QuadraticTriangle;
use crate::model::brep::Face;

/// A curve between faces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SkinCurve {
    pub(super) tag: i32,
    /// Positions in [`Skin::faces`].
    pub(super) faces: Vec<u32>,
    pub(super) segments: Vec<[DVec3; 2]>,
}

/// The surface of one solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Skin {
    pub(super) solid_tag: i32,
    /// In the order of their numbers.
    pub(super) faces: Vec<Face>,
    /// The curved facets of each face.
    pub(super) facets: Vec<Vec<QuadraticTriangle>>,
    /// In the order of their numbers.
    pub(super) curves: Vec<SkinCurve>,
}

impl Skin {
    /// Points and triangles of the whole surface. A facet that bends by more than `sag` (mm) is cut into four at its mid-side points: those lie on
    /// the CAD surface, so that the cut facets sag a quarter as much. Gaps beside facets that are not cut are no wider than `sag`.
    pub(super) fn triangles(&self, sag: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (mut points, mut triangles) = (Vec::new(), Vec::new());
        for facet in self.facets.iter().flatten() {
            let first = points.len() as u32;
            points.extend(facet.corners);
            if facet.is_flat(sag) {
                triangles.push([first, first + 1, first + 2]);
                continue;
            }
            points.extend(facet.mids);
            let cut = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
            triangles.extend(cut.map(|t| t.map(|k| first + k)));
        }
        (points, triangles)
    }
}

/// The surface of every solid of a file, in the order of their numbers.
pub(super) fn skins(msh: &Msh) -> Result<Vec<Skin>, PieceError> {
    let mut volumes: Vec<&MshEntity> = msh.entities[3].iter().collect();
    volumes.sort_by_key(|v| v.tag);
    if volumes.is_empty() {
        return Err(PieceError::NoVolume);
    }
    Ok(volumes.into_iter().map(|v| skin(msh, v)).collect())
}

fn skin(msh: &Msh, volume: &MshEntity) -> Skin {
    let surfaces = own_entities(&msh.entities[2], &volume.boundary);
    let mut faces = Vec::new();
    let mut facets = Vec::new();
    let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (at, surface) in (0u32..).zip(&surfaces) {
        faces.push(Face {
            tag: surface.tag,
            name: face_name(msh, surface),
            curves: Vec::new(),
        });
        let mut own = Vec::new();
        for block in blocks(msh, 2, surface.tag) {
            for nodes in block.nodes.chunks_exact(block.kind.node_count()) {
                if let Some(corners) = nodes.first_chunk::<3>() {
                    own.push(QuadraticTriangle {
                        corners: corners.map(|n| msh.nodes[n as usize]),
                        mids: middles(msh, block.kind, nodes),
                    });
                }
            }
        }
        facets.push(own);
        for curve in &surface.boundary {
            let list = around.entry(curve.unsigned_abs()).or_default();
            if list.last() != Some(&at) {
                list.push(at);
            }
        }
    }
    let curves = around.into_iter().filter_map(|(tag, faces)| {
        let tag = i32::try_from(tag).ok()?;
        let segments = blocks(msh, 1, tag)
            .flat_map(|b| b.nodes.chunks_exact(b.kind.node_count()))
            .filter_map(|n| Some([*n.first()?, *n.get(1)?].map(|n| msh.nodes[n as usize])))
            .collect();
        Some(SkinCurve {
            tag,
            faces,
            segments,
        })
    });
    Skin {
        solid_tag: volume.tag,
        faces,
        facets,
        curves: curves.collect(),
    }
}
