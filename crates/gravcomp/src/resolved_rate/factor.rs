//! Small symmetric systems: L D Lᵀ without square roots, for several right-hand sides side by side.
//!
//! Columns lie in halves of three rows, so that what a pivot takes off the columns behind it is a product of vectors.

use super::task::{Six, Vector};
use crate::lanes::Lanes;

/// Rows of the largest system: those of a task.
pub(super) const ROWS: usize = 6;

/// Right-hand sides of a solution, and a place that stays empty.
const SIDES: usize = 4;

/// Pivots below this share of the diagonal's sum are rounding.
const ROUNDING: f64 = 1e-14;

/// Pivots below this belong to no arm.
const NOTHING: f64 = 1e-30;

/// A symmetric matrix by columns, of which the lower triangle is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Matrix<const FUSED: bool> {
    /// The upper rows of the first three columns.
    pub upper: [Vector<FUSED>; 3],
    /// The lower rows of all columns.
    pub lower: [Vector<FUSED>; ROWS],
}

impl<const FUSED: bool> Matrix<FUSED> {
    /// With these numbers on the diagonal.
    #[inline(always)]
    pub(super) fn diagonal([a, b, c, d, e, f]: [f64; ROWS]) -> Self {
        let zero = Lanes::ZERO;
        let third =
            |a, b, c| [Lanes::of_three([a, 0.0, 0.0]), Lanes::of_three([0.0, b, 0.0]), Lanes::of_three([0.0, 0.0, c])];
        let [d, e, f] = third(d, e, f);
        Self { upper: third(a, b, c), lower: [zero, zero, zero, d, e, f] }
    }

    /// The entry in row i ≥ j of column j.
    #[inline(always)]
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        if i < 3 { self.upper[j].0[i] } else { self.lower[j].0[i - 3] }
    }

    /// Sets the entry in row i ≥ j of column j.
    #[inline(always)]
    pub(super) fn set(&mut self, i: usize, j: usize, x: f64) {
        if i < 3 { self.upper[j].0[i] = x } else { self.lower[j].0[i - 3] = x }
    }

    /// The sum of the diagonal.
    #[inline(always)]
    pub(super) fn trace(&self) -> f64 {
        let mut sums = [0.0; 3];
        for k in 0..3 {
            sums[k] = self.upper[k].0[k] + self.lower[k + 3].0[k];
        }
        sums[0] + sums[1] + sums[2]
    }

    /// The same with λ² more on the diagonal.
    #[inline(always)]
    fn damped(&self, squared: f64) -> Self {
        let mut damped = *self;
        for k in 0..3 {
            damped.upper[k].0[k] += squared;
            damped.lower[k + 3].0[k] += squared;
        }
        damped
    }
}

/// L D Lᵀ = A + λ² 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factor<const FUSED: bool> {
    /// L below the diagonal.
    columns: Matrix<FUSED>,
    /// D
    pivots: [f64; ROWS],
    /// 1/D
    inverse: [f64; ROWS],
}

impl<const FUSED: bool> Factor<FUSED> {
    /// Of a positive semidefinite matrix. A pivot that rounding has taken is replaced by rounding's size.
    #[inline(always)]
    pub(super) fn of(matrix: &Matrix<FUSED>, damping: f64) -> Self {
        let columns = matrix.damped(damping);
        let floor = columns.trace() * ROUNDING + NOTHING;
        let mut factor = Self { columns, pivots: [0.0; ROWS], inverse: [0.0; ROWS] };
        factor.eliminate_upper::<0>(floor);
        factor.eliminate_upper::<1>(floor);
        factor.eliminate_upper::<2>(floor);
        factor.eliminate_lower::<0>(floor);
        factor.eliminate_lower::<1>(floor);
        factor.eliminate_lower::<2>(floor);
        factor
    }

    /// Column K of L, one of the first three, and what it leaves of the columns behind it. A text per column: its loops have
    /// constant lengths.
    #[inline(always)]
    fn eliminate_upper<const K: usize>(&mut self, floor: f64) {
        let (upper, lower) = (self.columns.upper[K], self.columns.lower[K]);
        let inverse = self.pivot(K, upper.0[K], floor);
        let (of_upper, of_lower) = (upper * inverse, lower * inverse);
        let a = &mut self.columns;
        for j in K + 1..3 {
            let x = Lanes::splat(upper.0[j]);
            a.upper[j] = of_upper.neg_mul_add(x, a.upper[j]);
            a.lower[j] = of_lower.neg_mul_add(x, a.lower[j]);
        }
        for j in 0..3 {
            a.lower[j + 3] = of_lower.neg_mul_add(Lanes::splat(lower.0[j]), a.lower[j + 3]);
        }
        (a.upper[K], a.lower[K]) = (of_upper, of_lower);
    }

    /// The same of one of the last three columns.
    #[inline(always)]
    fn eliminate_lower<const K: usize>(&mut self, floor: f64) {
        let lower = self.columns.lower[K + 3];
        let of_lower = lower * self.pivot(K + 3, lower.0[K], floor);
        let a = &mut self.columns;
        for j in K + 1..3 {
            a.lower[j + 3] = of_lower.neg_mul_add(Lanes::splat(lower.0[j]), a.lower[j + 3]);
        }
        a.lower[K + 3] = of_lower;
    }

    /// Notes a pivot and gives 1/D.
    #[inline(always)]
    fn pivot(&mut self, k: usize, found: f64, floor: f64) -> Vector<FUSED> {
        let pivot = if found > floor { found } else { floor };
        self.pivots[k] = pivot;
        self.inverse[k] = 1.0 / pivot;
        Lanes::splat(self.inverse[k])
    }

    /// The smallest pivot, at least the smallest eigenvalue.
    #[inline(always)]
    pub(super) fn least(&self) -> f64 {
        let mut least = self.pivots[0];
        for pivot in self.pivots {
            least = if pivot < least { pivot } else { least };
        }
        least
    }

    /// The determinant.
    #[inline(always)]
    pub(super) fn determinant(&self) -> f64 {
        self.pivots.iter().product()
    }

    /// X with (A + λ² 1) X = B for three right-hand sides B.
    #[inline(always)]
    pub(super) fn solve(&self, sides: [Six<FUSED>; 3]) -> [Six<FUSED>; 3] {
        let [[a, d], [b, e], [c, f]] = sides;
        let ([x, y, z], [u, v, w]) = (across([a, b, c]), across([d, e, f]));
        let mut b = [x, y, z, u, v, w];
        self.forward::<0>(&mut b);
        self.forward::<1>(&mut b);
        self.forward::<2>(&mut b);
        self.forward::<3>(&mut b);
        self.forward::<4>(&mut b);
        for k in 0..ROWS {
            b[k] *= self.inverse[k].into();
        }
        self.backward::<5>(&mut b);
        self.backward::<4>(&mut b);
        self.backward::<3>(&mut b);
        self.backward::<2>(&mut b);
        self.backward::<1>(&mut b);
        let [x, y, z, u, v, w] = b;
        let ([a, b, c], [d, e, f]) = (across([x, y, z]), across([u, v, w]));
        [[a, d], [b, e], [c, f]]
    }

    #[inline(always)]
    fn forward<const K: usize>(&self, b: &mut [Lanes<SIDES, FUSED>; ROWS]) {
        for i in K + 1..ROWS {
            b[i] = b[K].neg_mul_add(self.columns.entry(i, K).into(), b[i]);
        }
    }

    #[inline(always)]
    fn backward<const K: usize>(&self, b: &mut [Lanes<SIDES, FUSED>; ROWS]) {
        for i in 0..K {
            b[i] = b[K].neg_mul_add(self.columns.entry(K, i).into(), b[i]);
        }
    }
}

/// Three vectors of three as three others: what was a row is a column.
#[inline(always)]
fn across<const FUSED: bool>([a, b, c]: [Vector<FUSED>; 3]) -> [Vector<FUSED>; 3] {
    let row = |k: usize| Lanes([a.0[k], b.0[k], c.0[k], 0.0]);
    [row(0), row(1), row(2)]
}
