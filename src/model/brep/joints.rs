//! Which facets of a boundary hang together across a side, also where the boundary touches itself.
//!
//! Two facets meet at a side of a surface. Where there are four, two surfaces touch along the side, as across a narrow hole that its facets pinch:
//! then those two hang together that have the same material between them.

use super::Brep;
use crate::model::ids::{FacetId, VertexId};
use glam::DVec3;

/// A side of a facet: from one corner to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct FacetSide {
    facet: FacetId,
    corner: u32,
}

impl FacetSide {
    /// Number of its first corner among those of all facets.
    pub(super) fn start(self) -> u32 {
        3 * self.facet.0 + self.corner
    }

    /// Number of its second corner among those of all facets.
    pub(super) fn end(self) -> u32 {
        3 * self.facet.0 + (self.corner + 1) % 3
    }
}

/// A side as it lies in the boundary: lower and higher end, whether it runs from the higher to the lower, whose it is.
type Lie = (VertexId, VertexId, bool, FacetSide);

/// All pairs of facets' sides that lie on one another, run opposite ways and have the same material between them. Sorted by the ends of the sides.
pub(super) fn joints(brep: &Brep) -> Vec<[FacetSide; 2]> {
    let mut lies: Vec<Lie> = Vec::with_capacity(3 * brep.facets.len());
    for (facet, f) in brep.facets.enumerated() {
        for corner in 0..3 {
            let (a, b) = (
                f.corners[corner as usize],
                f.corners[(corner as usize + 1) % 3],
            );
            lies.push((a.min(b), a.max(b), a > b, FacetSide { facet, corner }));
        }
    }
    lies.sort_unstable();
    let mut found = Vec::with_capacity(lies.len() / 2);
    for run in lies.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        match run {
            [one, other] if one.2 != other.2 => found.push([one.3, other.3]),
            _ => found.extend(parted(brep, run)),
        }
    }
    found
}

/// The pairs among several facets at one side. Seen along it, material lies clockwise of a facet that runs upwards and anticlockwise of one that runs downwards; so going
/// round anticlockwise the latter opens a wedge of material that the next of the former closes.
fn parted(brep: &Brep, run: &[Lie]) -> Vec<[FacetSide; 2]> {
    let (low, high) = (brep.vertices[run[0].0], brep.vertices[run[0].1]);
    let axis = (high - low).normalize_or_zero();
    let away = |side: FacetSide| -> DVec3 {
        let apex = brep.facets[side.facet].corners[(side.corner as usize + 2) % 3];
        let d = brep.vertices[apex] - low;
        d - axis * d.dot(axis)
    };
    let x = away(run[0].3).normalize_or_zero();
    let y = axis.cross(x);
    let mut round: Vec<(f64, bool, FacetSide)> = run
        .iter()
        .map(|&(_, _, down, side)| {
            let d = away(side);
            (d.dot(y).atan2(d.dot(x)), down, side)
        })
        .collect();
    // Of two that lie on one another the gap between them is empty, so that the closing one comes first.
    round.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut open: Vec<FacetSide> = Vec::new();
    let mut found = Vec::new();
    let mut closed = vec![false; round.len()];
    // Twice round: a wedge may be open where the count begins.
    for (i, &(_, down, side)) in round.iter().chain(&round).enumerate() {
        if down && i < round.len() {
            open.push(side);
        } else if !down
            && !closed[i % round.len()]
            && let Some(other) = open.pop()
        {
            closed[i % round.len()] = true;
            found.push([other, side]);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::brep::Facet;
    use crate::model::ids::FaceId;

    /// The surfaces of boxes from `low` to `high` on a grid, glued where they have corners in the same place.
    fn boxes(all: &[[[i32; 3]; 2]]) -> Brep {
        let mut brep = Brep::default();
        let mut places: Vec<[i32; 3]> = Vec::new();
        for [low, high] in all {
            let mut corner = |k: usize| {
                let p = [0, 1, 2].map(|i| if k >> i & 1 == 0 { low[i] } else { high[i] });
                let at = places.iter().position(|&q| q == p).unwrap_or_else(|| {
                    places.push(p);
                    brep.vertices.push(DVec3::from_array(p.map(f64::from)));
                    places.len() - 1
                });
                VertexId(at as u32)
            };
            let c: Vec<VertexId> = (0..8).map(&mut corner).collect();
            for [p, q, r, s] in [
                [0, 2, 3, 1],
                [4, 5, 7, 6],
                [0, 1, 5, 4],
                [2, 6, 7, 3],
                [0, 4, 6, 2],
                [1, 3, 7, 5],
            ] {
                for corners in [[c[p], c[q], c[r]], [c[p], c[r], c[s]]] {
                    brep.facets.push(Facet {
                        corners,
                        mids: [DVec3::ZERO; 3],
                        face: FaceId(0),
                    });
                }
            }
        }
        assert_eq!(brep.check(), vec![]);
        brep
    }

    #[test]
    fn bodies_that_touch_count_as_if_they_did_not() {
        let one = [[0, 0, 0], [1, 1, 1]];
        assert_eq!(boxes(&[one]).euler(), 2);
        // Apart, along an edge, at a corner: two spheres.
        for other in [[5, 5, 5], [1, 1, 0], [1, 1, 1]] {
            let two = boxes(&[one, [other, other.map(|x| x + 1)]]);
            assert_eq!(two.euler(), 4, "{other:?}");
            let sides = joints(&two);
            assert_eq!(sides.len(), 36);
            assert!(
                sides
                    .iter()
                    .all(|[a, b]| (a.facet.0 < 12) == (b.facet.0 < 12)),
                "{other:?}"
            );
        }
    }

    #[test]
    fn a_hole_that_its_facets_pinch_is_still_a_hole() {
        // The same boxes inside out are two hollows that touch: the material goes round the touching edge, and its wall is one surface pinched along it.
        let mut two = boxes(&[[[0, 0, 0], [1, 1, 1]], [[1, 1, 0], [2, 2, 1]]]);
        for f in two.facets.as_mut_slice() {
            f.corners.swap(1, 2);
        }
        // Two spheres glued along an edge: the joint runs through it, as one sphere's.
        assert_eq!(two.euler(), 2);
        assert!(
            joints(&two)
                .iter()
                .any(|[a, b]| (a.facet.0 < 12) != (b.facet.0 < 12))
        );
    }
}
