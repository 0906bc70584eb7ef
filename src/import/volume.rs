//! Whether a filling has the volume of its solid.
//!
//! The volume that the CAD kernel measures shows a face that was lost or a solid turned inside out. It is not always right: its quadrature has a fixed number of points a face, and a
//! long closed profile swept into one face needs more. So where two different surface meshes that lack no face enclose the same volume, they are believed.

use super::Piece;
use super::error::MeshFault;
use super::script::{Attempt, SolidFacts};
use crate::geom::six_node::facet_volumes;
use crate::model::ids::FaceId;
use std::collections::BTreeSet;

/// Most that the volume of a mesh may differ from the solid's, or from that of another mesh: six-node facets are better than that by far.
const TOLERANCE: f64 = 0.005;

/// What the user is told where two meshes were believed.
pub(super) const OUTVOTED: &str = "the volume that the CAD kernel measures differs from that of two different meshes, which agree; the finer one was taken";

/// Volume inside the six-node facets, mm³.
fn volume(piece: &Piece) -> f64 {
    facet_volumes(&piece.brep).sum()
}

/// Faces that have facets.
fn faces(piece: &Piece) -> usize {
    let all: BTreeSet<FaceId> = piece.brep.facets.iter().map(|f| f.face).collect();
    all.len()
}

/// The fault of a filling whose facets enclose another volume than the CAD kernel measures.
pub(super) fn fault(piece: &Piece, solids: &[SolidFacts]) -> Option<MeshFault> {
    let solid = piece.brep.solid_tag;
    let facts = solids.iter().find(|s| s.tag == solid && s.volume > 0.0)?;
    departs(piece, facts.volume)
}

/// The fault of a filling whose facets enclose another volume than this, mm³.
pub(super) fn departs(piece: &Piece, wanted: f64) -> Option<MeshFault> {
    let (solid, share) = (piece.brep.solid_tag, volume(piece) / wanted);
    (!agree(share, 1.0)).then_some(MeshFault::Volume { solid, share })
}

fn agree(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() <= TOLERANCE
}

/// Fillings that contradict the CAD kernel.
#[derive(Default)]
pub(super) struct Doubted {
    all: Vec<(Attempt, Vec<Piece>)>,
}

impl Doubted {
    /// Whether such a filling has the surface mesh of this attempt: it would have the same volume.
    pub fn knows_surface_of(&self, attempt: &Attempt) -> bool {
        self.all.iter().any(|(a, _)| a.has_surface_of(attempt))
    }

    /// Keeps one more. Where one that is known already agrees with it and none of the part's `surfaces` lacks, the finer of the two.
    pub fn agree(
        &mut self,
        attempt: Attempt,
        pieces: Vec<Piece>,
        surfaces: usize,
    ) -> Option<Vec<Piece>> {
        let faces: usize = pieces.iter().map(faces).sum();
        let facets = |pieces: &[Piece]| pieces.iter().map(|p| p.brep.facets.len()).sum::<usize>();
        let alike = |old: &[Piece]| {
            faces >= surfaces
                && old.len() == pieces.len()
                && (old.iter().zip(&pieces)).all(|(a, b)| agree(volume(a), volume(b)))
        };
        let known =
            (self.all.iter()).position(|(a, old)| !a.has_surface_of(&attempt) && alike(old));
        match known {
            Some(place) => {
                let (_, old) = self.all.swap_remove(place);
                Some(if facets(&old) > facets(&pieces) {
                    old
                } else {
                    pieces
                })
            }
            None => {
                self.all.push((attempt, pieces));
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::script::ATTEMPTS;
    use super::*;
    use crate::test_parts::{box_brep, tube_brep};
    use glam::DVec3;

    fn filling(brep: crate::model::brep::Brep) -> Vec<Piece> {
        vec![Piece {
            brep,
            ..Piece::default()
        }]
    }

    #[test]
    fn a_box_has_its_volume_and_a_box_without_a_slice_is_a_fault() {
        let [piece] = &filling(box_brep(DVec3::new(2.0, 3.0, 4.0)))[..] else {
            panic!("one piece");
        };
        let facts = |volume: f64| SolidFacts {
            tag: piece.brep.solid_tag,
            volume,
            area: 52.0,
            diagonal: 5.0,
        };
        assert_eq!(fault(piece, &[facts(24.0)]), None);
        assert_eq!(fault(piece, &[facts(24.1)]), None);
        let Some(MeshFault::Volume { share, .. }) = fault(piece, &[facts(25.0)]) else {
            panic!("a twenty-fifth is missing");
        };
        assert!((share - 0.96).abs() < 1e-12);
        // Of another solid nothing is known.
        assert_eq!(fault(piece, &[]), None);
    }

    #[test]
    fn two_different_surfaces_that_agree_are_believed_and_the_finer_one_is_taken() {
        let [first, other] = [ATTEMPTS[0], ATTEMPTS[0]].map(|a| a);
        let fine = Attempt {
            even: Some(0.5),
            ..other
        };
        let tube = |n| filling(tube_brep(10.0, 8.0, 20.0, n));
        let mut doubted = Doubted::default();
        assert!(doubted.agree(first, tube(64), 4).is_none());
        // The same surface says nothing new, a wrong volume agrees with none.
        assert!(doubted.knows_surface_of(&other) && !doubted.knows_surface_of(&fine));
        assert!(doubted.agree(other, tube(64), 4).is_none());
        let wrong = filling(tube_brep(10.0, 7.0, 20.0, 64));
        assert!(doubted.agree(fine, wrong, 4).is_none());
        let finer = Attempt {
            even: Some(0.25),
            ..other
        };
        // One face is not in it.
        assert!(doubted.agree(finer, tube(128), 5).is_none());
        let mut doubted = Doubted::default();
        assert!(doubted.agree(first, tube(64), 4).is_none());
        let taken = doubted.agree(finer, tube(128), 4).unwrap();
        assert_eq!(taken[0].brep.facets.len(), tube(128)[0].brep.facets.len());
    }
}
