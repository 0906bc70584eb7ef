//! Sparse symmetric positive definite systems: factor once, solve for many right-hand sides.
//!
//! The one module that knows the linear algebra library (`faer`).
//!
//! **Guarantees.** A matrix that is not positive definite is an error, never a wrong answer; the result does not depend on the
//! number of threads (the factorisation is sequential).
//! **Limits.** A nearly singular matrix is not detected: the solution then loses as many digits as its condition number has.
//! **Cost.** Fill-reducing (approximate minimum degree) Cholesky; for the graph of a surface mesh about O(n log n) memory and O(n^1.5) time.

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use glam::DVec2;

/// Why a system could not be factored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// An entry lies outside the matrix.
    #[error("entry ({row}, {column}) lies outside a matrix of size {size}")]
    OutOfRange {
        /// Row of the entry.
        row: u32,
        /// Column of the entry.
        column: u32,
        /// Rows of the matrix.
        size: usize,
    },
    /// An entry is not a finite number.
    #[error("entry ({row}, {column}) is not finite")]
    NotFinite {
        /// Row of the entry.
        row: u32,
        /// Column of the entry.
        column: u32,
    },
    /// The matrix has an eigenvalue that is not positive (or memory ran out).
    #[error("matrix of size {size} is not positive definite")]
    NotPositive {
        /// Rows of the matrix.
        size: usize,
    },
}

/// The Cholesky factor of a sparse symmetric positive definite matrix.
#[derive(Clone, Debug)]
pub struct SpdSolver {
    size: usize,
    factor: Option<Llt<usize, f64>>,
}

impl SpdSolver {
    /// Factors the `size` by `size` matrix given by `(row, column, value)`; only entries on and below the diagonal are read, entries at
    /// the same place add up.
    ///
    /// # Errors
    /// An entry outside the matrix or not finite; a matrix that is not positive definite.
    pub fn factor(size: usize, triplets: &[(u32, u32, f64)]) -> Result<Self, SolveError> {
        if size == 0 {
            return Ok(Self { size, factor: None });
        }
        let mut entries = Vec::with_capacity(triplets.len());
        for &(row, column, value) in triplets {
            if row as usize >= size || column as usize >= size {
                return Err(SolveError::OutOfRange { row, column, size });
            }
            if !value.is_finite() {
                return Err(SolveError::NotFinite { row, column });
            }
            if row >= column {
                entries.push(Triplet::new(row as usize, column as usize, value));
            }
        }
        let refused = SolveError::NotPositive { size };
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(size, size, &entries)
            .map_err(|_| refused.clone())?;
        let factor = matrix.sp_cholesky(Side::Lower).map_err(|_| refused)?;
        Ok(Self {
            size,
            factor: Some(factor),
        })
    }

    /// The solution for `rhs` (one value a row; missing values count as zero).
    pub fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let Some(factor) = &self.factor else {
            return Vec::new();
        };
        let mut x =
            faer::Mat::<f64>::from_fn(self.size, 1, |i, _| rhs.get(i).copied().unwrap_or_default());
        factor.solve_in_place(&mut x);
        (0..self.size).map(|i| x[(i, 0)]).collect()
    }

    /// The solutions for both coordinates at once (missing points count as zero).
    pub fn solve_pairs(&self, rhs: &[DVec2]) -> Vec<DVec2> {
        let Some(factor) = &self.factor else {
            return Vec::new();
        };
        let mut x = faer::Mat::<f64>::from_fn(self.size, 2, |i, k| {
            rhs.get(i).map(|p| p[k]).unwrap_or_default()
        });
        factor.solve_in_place(&mut x);
        (0..self.size)
            .map(|i| DVec2::new(x[(i, 0)], x[(i, 1)]))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// -u'' = 1 on (0, 1), u = 0 at both ends: central differences are exact for the parabola x (1 - x) / 2.
    #[test]
    fn poisson_on_a_line_is_the_parabola() {
        let n = 99;
        let h = 1.0 / (n + 1) as f64;
        let mut triplets = Vec::new();
        for i in 0..n as u32 {
            triplets.push((i, i, 2.0 / h / h));
            if i > 0 {
                triplets.push((i, i - 1, -1.0 / h / h));
            }
        }
        let solver = SpdSolver::factor(n, &triplets).unwrap();
        let u = solver.solve(&vec![1.0; n]);
        for (i, u) in u.iter().enumerate() {
            let x = (i + 1) as f64 * h;
            assert!((u - x * (1.0 - x) / 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn pairs_are_solved_as_one_by_one() {
        let entries = [(0, 0, 2.0), (1, 0, -1.0), (1, 1, 3.0), (2, 2, 1.0)];
        let solver = SpdSolver::factor(3, &entries).unwrap();
        let pairs = [DVec2::new(1.0, -2.0), DVec2::new(0.5, 4.0), DVec2::ZERO];
        let both = solver.solve_pairs(&pairs);
        for k in 0..2 {
            let one = solver.solve(&pairs.map(|p| p[k]));
            assert!(both.iter().zip(one).all(|(b, o)| (b[k] - o).abs() < 1e-14));
        }
    }

    #[test]
    fn entries_at_one_place_add_up() {
        let s = SpdSolver::factor(1, &[(0, 0, 1.5), (0, 0, 2.5)]).unwrap();
        assert_eq!(s.solve(&[8.0]), vec![2.0]);
        assert!(SpdSolver::factor(0, &[]).unwrap().solve(&[1.0]).is_empty());
    }

    #[test]
    fn an_indefinite_matrix_is_refused() {
        let entries = [(0, 0, 1.0), (1, 0, 2.0), (1, 1, 1.0)];
        assert_eq!(
            SpdSolver::factor(2, &entries).unwrap_err(),
            SolveError::NotPositive { size: 2 }
        );
        assert!(SpdSolver::factor(1, &[(0, 0, 0.0)]).is_err());
    }

    #[test]
    fn entries_outside_or_not_finite_are_refused() {
        assert!(matches!(
            SpdSolver::factor(1, &[(1, 0, 1.0)]),
            Err(SolveError::OutOfRange { .. })
        ));
        assert!(matches!(
            SpdSolver::factor(1, &[(0, 0, f64::NAN)]),
            Err(SolveError::NotFinite { .. })
        ));
    }
}
