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
        let mut factor = Self { entries: a, least: f64::INFINITY, determinant: 1.0 };
        factor.eliminate::<0, FUSED>(floor);
        factor.eliminate::<1, FUSED>(floor);
        factor.eliminate::<2, FUSED>(floor);
        factor.eliminate::<3, FUSED>(floor);
        factor.eliminate::<4, FUSED>(floor);
        factor.eliminate::<5, FUSED>(floor);
        factor
    }

    /// Column K of L, and what it leaves of the columns behind it. A text per column: its loops have constant lengths.
    #[inline(always)]
    fn eliminate<const K: usize, const FUSED: bool>(&mut self, floor: f64) {
        let a = &mut self.entries;
        let pivot = if a[K][K] > floor { a[K][K] } else { floor };
        self.least = if pivot < self.least { pivot } else { self.least };
        self.determinant *= pivot;
        let inverse = 1.0 / pivot;
        a[K][K] = inverse;
        for i in K + 1..ROWS {
            let whole = Lanes::<1, FUSED>([a[i][K]]);
            a[i][K] *= inverse;
            // Rows j ≤ i are scaled already.
            for j in K + 1..=i {
                a[i][j] = whole.neg_mul_add(Lanes([a[j][K]]), Lanes([a[i][j]])).0[0];
            }
        }
    }

    /// X with (A + λ² 1) X = B, in its place.
    #[inline(always)]
    pub(super) fn solve<const FUSED: bool>(&self, b: &mut Sides<FUSED>) {
        self.forward::<0, FUSED>(b);
        self.forward::<1, FUSED>(b);
        self.forward::<2, FUSED>(b);
        self.forward::<3, FUSED>(b);
        self.forward::<4, FUSED>(b);
        for k in 0..ROWS {
            b[k] *= self.entries[k][k].into();
        }
        self.backward::<5, FUSED>(b);
        self.backward::<4, FUSED>(b);
        self.backward::<3, FUSED>(b);
        self.backward::<2, FUSED>(b);
        self.backward::<1, FUSED>(b);
    }

    #[inline(always)]
    fn forward<const K: usize, const FUSED: bool>(&self, b: &mut Sides<FUSED>) {
        for i in K + 1..ROWS {
            b[i] = b[K].neg_mul_add(self.entries[i][K].into(), b[i]);
        }
    }

    #[inline(always)]
    fn backward<const K: usize, const FUSED: bool>(&self, b: &mut Sides<FUSED>) {
        for i in 0..K {
            b[i] = b[K].neg_mul_add(self.entries[K][i].into(), b[i]);
        }
    }
}
