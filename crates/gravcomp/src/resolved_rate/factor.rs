//! Small symmetric systems: L D Lᵀ without square roots, for several right-hand sides side by side.

use crate::lanes::Lanes;

/// Rows of the largest system: those of a task.
pub(super) const ROWS: usize = 6;

/// Right-hand sides of a solution.
pub(super) const SIDES: usize = 4;

/// A symmetric matrix, of which the lower triangle is read.
pub(super) type Matrix = [[f64; ROWS]; ROWS];

/// One number of each right-hand side per row.
pub(super) type Sides<const FUSED: bool> = [Lanes<SIDES, FUSED>; ROWS];

/// Pivots below this share of the largest diagonal entry are rounding.
const ROUNDING: f64 = 1e-14;

/// Pivots below this belong to no arm.
const NOTHING: f64 = 1e-30;

/// L D Lᵀ = A + λ² 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factor {
    /// L below the diagonal, 1/D on it.
    entries: Matrix,
    /// The smallest pivot, at least the smallest eigenvalue.
    pub(super) least: f64,
    /// The determinant.
    pub(super) determinant: f64,
}

impl Factor {
    /// Of a positive semidefinite matrix. A pivot that rounding has taken is replaced by rounding's size.
    #[inline(always)]
    pub(super) fn of<const FUSED: bool>(matrix: &Matrix, damping: f64) -> Self {
        let mut a = *matrix;
        let mut largest = 0.0;
        for k in 0..ROWS {
            a[k][k] += damping;
            largest = if a[k][k] > largest { a[k][k] } else { largest };
        }
        let floor = largest * ROUNDING + NOTHING;
        let (mut least, mut determinant) = (f64::INFINITY, 1.0);
        for k in 0..ROWS {
            let pivot = if a[k][k] > floor { a[k][k] } else { floor };
            least = if pivot < least { pivot } else { least };
            determinant *= pivot;
            let inverse = 1.0 / pivot;
            a[k][k] = inverse;
            for i in k + 1..ROWS {
                let l = Lanes::<1, FUSED>([a[i][k] * inverse]);
                for j in k + 1..i {
                    a[i][j] = l.neg_mul_add(Lanes([a[j][k]]), Lanes([a[i][j]])).0[0];
                }
                a[i][i] = l.neg_mul_add(Lanes([a[i][k]]), Lanes([a[i][i]])).0[0];
            }
            for i in k + 1..ROWS {
                a[i][k] *= inverse;
            }
        }
        Self { entries: a, least, determinant }
    }

    /// X with (A + λ² 1) X = B, in its place.
    #[inline(always)]
    pub(super) fn solve<const FUSED: bool>(&self, b: &mut Sides<FUSED>) {
        for k in 0..ROWS {
            for i in k + 1..ROWS {
                b[i] = b[k].neg_mul_add(self.entries[i][k].into(), b[i]);
            }
        }
        for k in 0..ROWS {
            b[k] *= self.entries[k][k].into();
        }
        for k in (0..ROWS).rev() {
            for i in 0..k {
                b[i] = b[k].neg_mul_add(self.entries[k][i].into(), b[i]);
            }
        }
    }
}
