//! Small symmetric systems: L D Lᵀ without square roots.
//!
//! A system waits for the divisions of its pivots, each of which waits for the one before it. Here pivots come in pairs: with
//! the determinant of a pair's block, d₂ = det/d₁, its two divisions run side by side.

use super::task::{Six, Vector};
use crate::lanes::Lanes;

/// Rows of the largest system: those of a task.
pub(super) const ROWS: usize = 6;

/// Pivots below this share of the diagonal's sum are rounding.
const ROUNDING: f64 = 1e-14;

/// Pivots below this belong to no arm.
const NOTHING: f64 = 1e-30;

/// One number.
type Number<const FUSED: bool> = Lanes<1, FUSED>;

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
    pub(super) fn diagonal(numbers: [f64; ROWS]) -> Self {
        let mut matrix = Self { upper: [Lanes::ZERO; 3], lower: [Lanes::ZERO; ROWS] };
        for k in 0..ROWS {
            matrix.set(k, k, numbers[k]);
        }
        matrix
    }

    /// The same numbers, from another kernel.
    #[inline(always)]
    pub(super) fn like<const OTHER: bool>(other: &Matrix<OTHER>) -> Self {
        let mut matrix = Self { upper: [Lanes::ZERO; 3], lower: [Lanes::ZERO; ROWS] };
        for k in 0..3 {
            matrix.upper[k] = Lanes(other.upper[k].0);
        }
        for k in 0..ROWS {
            matrix.lower[k] = Lanes(other.lower[k].0);
        }
        matrix
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
}

/// L D Lᵀ = A + λ² 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factor<const FUSED: bool> {
    /// L below the diagonal, by rows; before a pair of columns is done, what is left of A there.
    rows: [[Number<FUSED>; ROWS]; ROWS],
    /// D
    pivots: [f64; ROWS],
    /// 1/D
    inverse: [Number<FUSED>; ROWS],
}

impl<const FUSED: bool> Factor<FUSED> {
    /// Of a positive semidefinite matrix. A pivot that rounding has taken is replaced by rounding's size.
    #[inline(always)]
    pub(super) fn of(matrix: &Matrix<FUSED>, damping: f64) -> Self {
        let mut factor = Self { rows: [[Lanes::ZERO; ROWS]; ROWS], pivots: [0.0; ROWS], inverse: [Lanes::ZERO; ROWS] };
        for i in 0..ROWS {
            for j in 0..=i {
                factor.rows[i][j] = matrix.entry(i, j).into();
            }
            factor.rows[i][i] += damping.into();
        }
        let floor = matrix.trace() * ROUNDING + NOTHING;
        factor.eliminate::<0>(floor);
        factor.eliminate::<2>(floor);
        factor.eliminate::<4>(floor);
        factor
    }

    /// Columns K and K + 1 of L, and what they leave of the columns behind them. A text per pair: its loops have constant
    /// lengths.
    #[inline(always)]
    fn eliminate<const K: usize>(&mut self, floor: f64) {
        let first = at_least(self.rows[K][K], floor);
        let across = self.rows[K + 1][K];
        let block = across.neg_mul_add(across, first * self.rows[K + 1][K + 1]);
        let determinant = at_least(block, (first * floor.into()).0[0]);
        let (one, two) = (reciprocal(first), first * reciprocal(determinant));
        (self.inverse[K], self.inverse[K + 1]) = (one, two);
        (self.pivots[K], self.pivots[K + 1]) = (first.0[0], (determinant * one).0[0]);
        let a = &mut self.rows;
        for i in K + 2..ROWS {
            let share = a[i][K] * one;
            a[i][K + 1] = share.neg_mul_add(across, a[i][K + 1]);
            for j in K + 2..=i {
                a[i][j] = share.neg_mul_add(a[j][K], a[i][j]);
                a[i][j] = two.neg_mul_add(a[i][K + 1] * a[j][K + 1], a[i][j]);
            }
        }
        a[K + 1][K] *= one;
        for i in K + 2..ROWS {
            a[i][K] *= one;
            a[i][K + 1] *= two;
        }
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

    /// x with (A + λ² 1) x = b.
    #[inline(always)]
    pub(super) fn solve(&self, [upper, lower]: &Six<FUSED>) -> Six<FUSED> {
        let mut x: [Number<FUSED>; ROWS] = [Lanes::ZERO; ROWS];
        for k in 0..3 {
            (x[k], x[k + 3]) = (upper.0[k].into(), lower.0[k].into());
        }
        self.forward::<0>(&mut x);
        self.forward::<1>(&mut x);
        self.forward::<2>(&mut x);
        self.forward::<3>(&mut x);
        self.forward::<4>(&mut x);
        for k in 0..ROWS {
            x[k] *= self.inverse[k];
        }
        self.backward::<5>(&mut x);
        self.backward::<4>(&mut x);
        self.backward::<3>(&mut x);
        self.backward::<2>(&mut x);
        self.backward::<1>(&mut x);
        let [x, y, z, u, v, w] = x.map(|x| x.0[0]);
        [Lanes::of_three([x, y, z]), Lanes::of_three([u, v, w])]
    }

    #[inline(always)]
    fn forward<const K: usize>(&self, x: &mut [Number<FUSED>; ROWS]) {
        for i in K + 1..ROWS {
            x[i] = self.rows[i][K].neg_mul_add(x[K], x[i]);
        }
    }

    #[inline(always)]
    fn backward<const K: usize>(&self, x: &mut [Number<FUSED>; ROWS]) {
        for i in 0..K {
            x[i] = self.rows[K][i].neg_mul_add(x[K], x[i]);
        }
    }
}

/// The number, or the floor where that is more, or where it is none.
#[inline(always)]
fn at_least<const FUSED: bool>(number: Number<FUSED>, floor: f64) -> Number<FUSED> {
    if number.0[0] > floor { number } else { floor.into() }
}

#[inline(always)]
fn reciprocal<const FUSED: bool>(number: Number<FUSED>) -> Number<FUSED> {
    Lanes([1.0 / number.0[0]])
}
