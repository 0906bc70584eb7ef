//! Takes away fins that contractions have folded.
//!
//! A blind pocket of a block may hang on its wall by one edge. Meshed, its rim is drawn together to a ring of three nodes and the sheet is a cone on that edge: no move, flip or contraction
//! unfolds it, and the wall goes on without it. `prune` knows such sheets, but at its time they were still larger than fins, or met other walls.
//!
//! Guarantees: those of `prune` (elementary collapses only), and fewer folds than before or no change at all.

use super::tidy::folds;
use crate::geom::placer::Placer;
use crate::model::complex::MidComplex;
use crate::stage::prune::prune;

/// The complex without its folded fins.
pub(super) fn unfinned(complex: MidComplex, medial: &dyn Placer) -> MidComplex {
    let before = folds(&complex);
    if before == 0 {
        return complex;
    }
    let (pruned, _) = prune(complex.clone(), medial);
    // What stands for no wall and is not folded does not stop a solver.
    if folds(&pruned) < before {
        pruned
    } else {
        complex
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ids::WallId;
    use crate::stage::test_shapes::{Build, Stay};
    use glam::DVec3;

    /// A plate 4 x 4 with a cone on the edge from (1, 1) to (3, 1): its apex there, and a ring of three through the other end.
    fn with_cone(ring: [DVec3; 2]) -> MidComplex {
        let mut b = Build::default();
        b.sheet(0, 2, 2, |u, v| {
            DVec3::new(4.0 * u - 1.0, 4.0 * v - 1.0, 0.0)
        });
        let (apex, end) = (DVec3::new(3.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 0.0));
        let [p, q] = ring;
        for corners in [[end, p, apex], [p, q, apex], [q, end, apex]] {
            b.triangle(WallId(0), corners);
        }
        b.complex
    }

    #[test]
    fn a_cone_drawn_together_goes_and_the_plate_stays() {
        let complex = with_cone([DVec3::new(1.02, 1.01, 0.0), DVec3::new(1.01, 1.03, 0.0)]);
        assert!(folds(&complex) > 0);
        let left = unfinned(complex.clone(), &Stay);
        assert_eq!((folds(&left), left.triangles.len()), (0, 8));
        assert_eq!((left.euler(), left.pieces()), (complex.euler(), 1));
        assert!(left.check().is_empty());
    }

    #[test]
    fn an_open_cone_stays() {
        let complex = with_cone([DVec3::new(4.0, 2.5, 1.0), DVec3::new(4.0, -0.5, 1.0)]);
        assert_eq!(folds(&complex), 0);
        assert_eq!(unfinned(complex.clone(), &Stay), complex);
    }
}
