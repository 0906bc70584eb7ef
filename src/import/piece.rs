//! From a mesh file to one [`Piece`] a solid.
//!
//! Guarantees for every piece: the facets are exactly the faces that belong to one tet of the solid, oriented outwards, so that they
//! are closed and consistently oriented whatever way gmsh turned its surfaces; all tets are oriented alike, positively but for
//! those flatter than rounding; every vertex is a corner of a tet, those on the boundary come first, each group in the order of the file; faces and curves in
//! the order of their numbers. A face that two solids share is in both pieces.
//!
//! Limits: a curve without length (the pole of a sphere) is left out. A mid-side point that lies further from the straight side than a
//! half circle over that side is moved back onto the straight side.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::Piece;
use super::ears;
use super::msh::{ElementBlock, ElementKind, Msh, MshEntity};
use crate::model::brep::{Brep, BrepFault, Curve, Face, Facet};
use crate::model::ids::{CurveId, FaceId, Id, IndexVec, VertexId};
use crate::model::tets::{Tets, TetsFault};

/// Why a mesh file holds no filled solids. Numbers of solids, faces and curves are those of the file; nodes are counted from 0.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PieceError {
    /// There is no volume in the file.
    #[error("the mesh has no volume")]
    NoVolume,
    /// A volume without tets.
    #[error("solid {solid} has no tets")]
    NotFilled {
        /// The solid.
        solid: i32,
    },
    /// The tets cannot be oriented alike, or more than two share a face.
    #[error("the tets of solid {solid} overlap at the face of nodes {nodes:?}")]
    Overlap {
        /// The solid.
        solid: i32,
        /// The face's nodes.
        nodes: [u32; 3],
    },
    /// A triangle of a face is not on the boundary of the tets.
    #[error(
        "a triangle of face {face} is no boundary face of a tet of solid {solid} (nodes {nodes:?})"
    )]
    LooseFacet {
        /// The solid.
        solid: i32,
        /// The face.
        face: i32,
        /// The triangle's nodes.
        nodes: [u32; 3],
    },
    /// The boundary of the tets has triangles that belong to no face.
    #[error("{count} boundary faces of the tets of solid {solid} lie on no face")]
    BareTets {
        /// The solid.
        solid: i32,
        /// How many.
        count: usize,
    },
    /// A piece of a curve is no side of a facet.
    #[error("a piece of curve {curve} is no side of a facet of solid {solid} (nodes {nodes:?})")]
    LooseSegment {
        /// The solid.
        solid: i32,
        /// The curve.
        curve: i32,
        /// The ends.
        nodes: [u32; 2],
    },
    /// The boundary breaks a law of [`Brep`].
    #[error("solid {solid}: {} faults of its boundary, the first: {}", faults.len(), faults[0])]
    Brep {
        /// The solid.
        solid: i32,
        /// All faults, at least one.
        faults: Vec<BrepFault>,
    },
    /// The tets break a law of [`Tets`].
    #[error("solid {solid}: {} faults of its tets, the first: {}", faults.len(), faults[0])]
    Tets {
        /// The solid.
        solid: i32,
        /// All faults, at least one.
        faults: Vec<TetsFault>,
    },
}

/// The faces of a tet seen from outside, as positions of its corners, for a positive tet.
pub(super) const OUTWARD: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/// One piece a volume, in the order of their numbers.
pub fn build_pieces(msh: &Msh) -> Result<Vec<Piece>, PieceError> {
    let mut volumes: Vec<&MshEntity> = msh.entities[3].iter().collect();
    volumes.sort_by_key(|v| v.tag);
    if volumes.is_empty() {
        return Err(PieceError::NoVolume);
    }
    volumes
        .into_iter()
        .map(|volume| build_piece(msh, volume))
        .collect()
}

fn build_piece(msh: &Msh, volume: &MshEntity) -> Result<Piece, PieceError> {
    let solid = volume.tag;
    let mut tets = read_tets(msh, solid);
    if tets.is_empty() {
        return Err(PieceError::NotFilled { solid });
    }
    let boundary = orient(msh, solid, &mut tets)?;
    let surfaces = own_entities(&msh.entities[2], &volume.boundary);
    let triangles = read_facets(msh, solid, &surfaces, &boundary)?;

    let mut vertex_of = vec![u32::MAX; msh.nodes.len()];
    let mut order: Vec<u32> = triangles.iter().flat_map(|t| t.corners).collect();
    order.sort_unstable();
    order.dedup();
    let mut inner: Vec<u32> = tets.iter().flatten().copied().collect();
    inner.sort_unstable();
    inner.dedup();
    inner.retain(|n| order.binary_search(n).is_err());
    order.extend(inner);
    for (vertex, &node) in (0u32..).zip(&order) {
        vertex_of[node as usize] = vertex;
    }
    let vertex = |node: u32| VertexId(vertex_of[node as usize]);

    let (curves, faces) = read_curves(msh, solid, &surfaces, &triangles, vertex)?;
    let mut brep = Brep {
        solid_tag: solid,
        vertices: order.iter().map(|&n| msh.nodes[n as usize]).collect(),
        facets: triangles
            .iter()
            .map(|t| Facet {
                corners: t.corners.map(vertex),
                mids: t.mids,
                face: t.face,
            })
            .collect(),
        faces,
        curves,
    };
    ears::hand_over(&mut brep);
    let tets = Tets {
        cells: tets.iter().map(|t| t.map(vertex)).collect(),
    };
    checked(solid, brep, tets)
}

/// A piece whose two halves are sound; `solid`: its tag, for the error.
pub(super) fn checked(solid: i32, brep: Brep, tets: Tets) -> Result<Piece, PieceError> {
    let faults = brep.check();
    if !faults.is_empty() {
        return Err(PieceError::Brep { solid, faults });
    }
    let faults = tets.check(brep.vertices.len());
    if !faults.is_empty() {
        return Err(PieceError::Tets { solid, faults });
    }
    Ok(Piece { brep, tets })
}

pub(super) fn blocks(
    msh: &Msh,
    dimension: usize,
    entity: i32,
) -> impl Iterator<Item = &ElementBlock> {
    msh.elements
        .iter()
        .filter(move |b| b.dimension == dimension && b.entity == entity)
}

/// The entities named by signed numbers, each once, in the order of their numbers.
pub(super) fn own_entities<'a>(all: &'a [MshEntity], signed: &[i32]) -> Vec<&'a MshEntity> {
    let mut tags: Vec<u32> = signed.iter().map(|t| t.unsigned_abs()).collect();
    tags.sort_unstable();
    tags.dedup();
    let mut own: Vec<&MshEntity> = all
        .iter()
        .filter(|e| tags.binary_search(&e.tag.unsigned_abs()).is_ok())
        .collect();
    own.sort_by_key(|e| e.tag);
    own
}

fn read_tets(msh: &Msh, solid: i32) -> Vec<[u32; 4]> {
    let mut tets = Vec::new();
    for block in blocks(msh, 3, solid) {
        let per = block.kind.node_count();
        for nodes in block.nodes.chunks_exact(per) {
            if let Some(corners) = nodes.first_chunk::<4>() {
                tets.push(*corners);
            }
        }
    }
    tets
}

fn det(msh: &Msh, [a, b, c, d]: [u32; 4]) -> f64 {
    let p = |n: u32| msh.nodes[n as usize];
    let origin = p(a);
    (p(b) - origin).dot((p(c) - origin).cross(p(d) - origin))
}

/// A boundary face of the tets: its nodes sorted, its nodes seen from outside.
type TetSide = ([u32; 3], [u32; 3]);

fn sorted<const N: usize>(mut nodes: [u32; N]) -> [u32; N] {
    nodes.sort_unstable();
    nodes
}

/// Whether two orders of the same three nodes run the same way round.
fn same_turn(a: [u32; 3], b: [u32; 3]) -> bool {
    (0..3).any(|k| a == [b[k], b[(k + 1) % 3], b[(k + 2) % 3]])
}

/// Orients the tets alike and returns their boundary, sorted by nodes.
///
/// The orientation spreads from tet to tet over shared faces, and the volume of all that hang together decides the sign: meshers write flat tets, whose own
/// volume is rounding or zero, in any order.
fn orient(msh: &Msh, solid: i32, tets: &mut [[u32; 4]]) -> Result<Vec<TetSide>, PieceError> {
    let overlap = |nodes| PieceError::Overlap { solid, nodes };
    let mut sides: Vec<([u32; 3], [u32; 3], u32)> = tets
        .par_iter()
        .enumerate()
        .flat_map_iter(|(tet, t)| {
            OUTWARD.map(|f| {
                let seen = f.map(|k| t[k]);
                (sorted(seen), seen, tet as u32)
            })
        })
        .collect();
    sides.par_sort_unstable();

    // Over each face of a tet the tet beyond it, and whether one of both has to be turned.
    let mut beyond: Vec<[Option<(u32, bool)>; 4]> = vec![[None; 4]; tets.len()];
    let mut boundary = Vec::new();
    for run in sides.chunk_by(|a, b| a.0 == b.0) {
        match *run {
            [one] => boundary.push(one),
            [(nodes, a, one), (_, b, other)] => {
                let odd = same_turn(a, b);
                for (from, to) in [(one, other), (other, one)] {
                    let free = beyond[from as usize].iter_mut().find(|s| s.is_none());
                    *free.ok_or_else(|| overlap(nodes))? = Some((to, odd));
                }
            }
            _ => return Err(overlap(run[0].0)),
        }
    }

    let mut turned: Vec<Option<bool>> = vec![None; tets.len()];
    for seed in 0..tets.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut together = vec![seed];
        let mut volume = 0.0;
        let mut next = 0;
        while let Some(&tet) = together.get(next) {
            next += 1;
            let flip = turned[tet] == Some(true);
            volume += det(msh, tets[tet]) * if flip { -1.0 } else { 1.0 };
            for (mate, odd) in beyond[tet].iter().flatten() {
                let (mate, flip) = (*mate as usize, flip ^ odd);
                match turned[mate] {
                    None => {
                        turned[mate] = Some(flip);
                        together.push(mate);
                    }
                    Some(found) if found != flip => {
                        let [a, b, c, _] = tets[mate];
                        return Err(overlap([a, b, c]));
                    }
                    Some(_) => {}
                }
            }
        }
        if volume < 0.0 {
            for tet in together {
                turned[tet] = turned[tet].map(|flip| !flip);
            }
        }
    }
    for (tet, flip) in tets.iter_mut().zip(&turned) {
        if *flip == Some(true) {
            tet.swap(0, 1);
        }
    }
    Ok(boundary
        .into_iter()
        .map(|(nodes, [a, b, c], tet)| {
            let flip = turned[tet as usize] == Some(true);
            (nodes, if flip { [a, c, b] } else { [a, b, c] })
        })
        .collect())
}

struct Triangle {
    corners: [u32; 3],
    mids: [DVec3; 3],
    face: FaceId,
}

/// The triangles of the solid's faces, turned outwards; each boundary face of the tets exactly once.
fn read_facets(
    msh: &Msh,
    solid: i32,
    surfaces: &[&MshEntity],
    boundary: &[TetSide],
) -> Result<Vec<Triangle>, PieceError> {
    let mut used = vec![false; boundary.len()];
    let mut triangles = Vec::with_capacity(boundary.len());
    for (face, surface) in surfaces.iter().enumerate() {
        for block in blocks(msh, 2, surface.tag) {
            for nodes in block.nodes.chunks_exact(block.kind.node_count()) {
                let Some(&corners) = nodes.first_chunk::<3>() else {
                    continue;
                };
                let loose = PieceError::LooseFacet {
                    solid,
                    face: surface.tag,
                    nodes: corners,
                };
                let Ok(at) = boundary.binary_search_by_key(&sorted(corners), |b| b.0) else {
                    return Err(loose);
                };
                if std::mem::replace(&mut used[at], true) {
                    return Err(loose);
                }
                let mids = middles(msh, block.kind, nodes);
                let turned = same_turn(boundary[at].1, corners);
                let ([a, b, c], [ab, bc, ca]) = (corners, mids);
                triangles.push(Triangle {
                    corners: if turned { corners } else { [a, c, b] },
                    mids: if turned { mids } else { [ca, bc, ab] },
                    face: FaceId::new(face),
                });
            }
        }
    }
    match used.iter().filter(|u| !**u).count() {
        0 => Ok(triangles),
        count => Err(PieceError::BareTets { solid, count }),
    }
}

/// The mid-side points of a triangle of three or six nodes.
pub(super) fn middles(msh: &Msh, kind: ElementKind, nodes: &[u32]) -> [DVec3; 3] {
    let p = |k: usize| msh.nodes[nodes[k] as usize];
    [(0, 1), (1, 2), (2, 0)].map(|(i, j)| {
        let straight = p(i).midpoint(p(j));
        if kind != ElementKind::Triangle6 {
            return straight;
        }
        // Further out than half the side is more than a half circle: a projection that found the wrong part of the surface.
        let mid = p(3 + i);
        if mid.distance(straight) <= p(i).distance(p(j)) / 2.0 {
            mid
        } else {
            straight
        }
    })
}

type CurvesAndFaces = (IndexVec<CurveId, Curve>, IndexVec<FaceId, Face>);

fn read_curves(
    msh: &Msh,
    solid: i32,
    surfaces: &[&MshEntity],
    triangles: &[Triangle],
    vertex: impl Fn(u32) -> VertexId,
) -> Result<CurvesAndFaces, PieceError> {
    let mut sides: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|t| (0..3).map(|k| sorted([t.corners[k], t.corners[(k + 1) % 3]])))
        .collect();
    sides.sort_unstable();
    sides.dedup();

    let mut around: BTreeMap<u32, Vec<FaceId>> = BTreeMap::new();
    for (face, surface) in surfaces.iter().enumerate() {
        for curve in &surface.boundary {
            let list = around.entry(curve.unsigned_abs()).or_default();
            if list.last() != Some(&FaceId::new(face)) {
                list.push(FaceId::new(face));
            }
        }
    }
    let mut faces: IndexVec<FaceId, Face> = surfaces
        .iter()
        .map(|s| Face {
            tag: s.tag,
            name: face_name(msh, s),
            curves: Vec::new(),
        })
        .collect();
    let mut curves: IndexVec<CurveId, Curve> = IndexVec::new();
    for (tag, mates) in around {
        let Ok(tag) = i32::try_from(tag) else {
            continue;
        };
        let mut segments = Vec::new();
        for block in blocks(msh, 1, tag) {
            for nodes in block.nodes.chunks_exact(block.kind.node_count()) {
                let [a, b] = [nodes[0], nodes[nodes.len().min(2) - 1]];
                if a == b {
                    continue;
                }
                if sides.binary_search(&sorted([a, b])).is_err() {
                    return Err(PieceError::LooseSegment {
                        solid,
                        curve: tag,
                        nodes: [a, b],
                    });
                }
                segments.push([vertex(a), vertex(b)]);
            }
        }
        if segments.is_empty() {
            continue;
        }
        for &face in &mates {
            faces[face].curves.push(CurveId::new(curves.len()));
        }
        curves.push(Curve {
            tag,
            faces: mates,
            segments,
        });
    }
    Ok((curves, faces))
}

pub(super) fn face_name(msh: &Msh, surface: &MshEntity) -> Option<String> {
    surface.physical.iter().find_map(|group| {
        msh.physical_names
            .iter()
            .find(|(dimension, tag, _)| *dimension == 2 && tag == group)
            .map(|(_, _, name)| name.clone())
    })
}

#[cfg(test)]
#[path = "piece_tests.rs"]
mod tests;
