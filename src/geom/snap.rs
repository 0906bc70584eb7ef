//! Rounding to a binary grid, so that ties stay ties.
//!
//! Regular parts are full of ties (four nodes on a circle, two ways of equal length); rounding errors would break them differently in every
//! position of the part. Values on a grid that is coarse beside the errors and fine beside the part come out the same.

use glam::DVec2;

/// Grid width over the size of the thing: far above the rounding errors of a sparse solve (1e-13), far below any feature.
const RELATIVE: f64 = 1e-9;

/// A grid whose width is a power of two, so that snapping is exact and does not depend on small errors of the size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Snap {
    width: f64,
}

impl Snap {
    /// The grid for things of about this size; no snapping where the size is not a positive number.
    pub fn for_size(size: f64) -> Self {
        let width = if size.is_finite() && size > 0.0 {
            (size * RELATIVE).log2().round().exp2()
        } else {
            0.0
        };
        Self { width }
    }

    /// The nearest value of the grid.
    #[inline]
    pub fn value(&self, x: f64) -> f64 {
        if self.width > 0.0 {
            // Adding zero turns minus zero into zero.
            (x / self.width).round() * self.width + 0.0
        } else {
            x
        }
    }

    /// The nearest point of the grid.
    #[inline]
    pub fn place(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.value(p.x), self.value(p.y))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_vanishes_and_features_stay() {
        let snap = Snap::for_size(100.0);
        assert_eq!(snap, Snap::for_size(100.0 * (1.0 + 1e-12)));
        let x = 12.3;
        assert_eq!(snap.value(x), snap.value(x + 1e-13));
        assert!((snap.value(x) - x).abs() < 1e-7);
        assert_ne!(snap.value(x), snap.value(x + 1e-6));
        assert_eq!(snap.value(snap.value(x)), snap.value(x));
    }

    #[test]
    fn sums_on_the_grid_are_exact() {
        let snap = Snap::for_size(1.0);
        let parts = [0.1, 0.2, 0.3].map(|x| snap.value(x));
        assert_eq!(
            (parts[0] + parts[1]) + parts[2],
            parts[0] + (parts[1] + parts[2])
        );
    }

    #[test]
    fn no_size_means_no_snapping() {
        assert_eq!(Snap::for_size(0.0).value(0.1), 0.1);
        assert_eq!(Snap::for_size(f64::NAN).place(DVec2::ONE), DVec2::ONE);
    }
}
