//! The gradient d (x − p) + Jᵀ W (J x − v), how large its rounding can be, and the matrix H that it changes by.

use super::{Problem, ROWS};
use crate::lanes::Lanes;

/// What is computed once from a problem.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope<'p, const N: usize, const FUSED: bool> {
    problem: &'p Problem<N>,
    /// d |p| + |Jᵀ| W |v|: the size of the terms that do not depend on x.
    pub constant: Lanes<N, FUSED>,
}

impl<'p, const N: usize, const FUSED: bool> Slope<'p, N, FUSED> {
    #[inline(always)]
    pub fn of(problem: &'p Problem<N>) -> Self {
        let mut constant = absolute(Lanes(problem.weight) * Lanes(problem.wish));
        for k in 0..ROWS {
            let pull = (problem.row_weight[k] * problem.target[k]).abs();
            constant = absolute(Lanes(problem.rows[k])).mul_add(Lanes::splat(pull), constant);
        }
        Self { problem, constant }
    }

    /// The gradient at x.
    #[inline(always)]
    pub fn at(&self, x: Lanes<N, FUSED>) -> Lanes<N, FUSED> {
        let p = self.problem;
        let mut g = Lanes(p.weight) * (x - Lanes(p.wish));
        for k in 0..ROWS {
            let row = Lanes(p.rows[k]);
            let missing = sum(row * x) - p.target[k];
            g = row.mul_add(Lanes::splat(p.row_weight[k] * missing), g);
        }
        g
    }

    /// H = diag(d) + Jᵀ W J, row by row.
    #[inline(always)]
    pub fn curvature(&self) -> [Lanes<N, FUSED>; N] {
        let p = self.problem;
        let mut rows = [Lanes::ZERO; N];
        for i in 0..N {
            for k in 0..ROWS {
                let along = p.row_weight[k] * p.rows[k][i];
                rows[i] = Lanes(p.rows[k]).mul_add(Lanes::splat(along), rows[i]);
            }
            rows[i].0[i] += p.weight[i];
        }
        rows
    }
}

/// |x|, place by place.
#[inline(always)]
pub(super) fn absolute<const N: usize, const FUSED: bool>(mut x: Lanes<N, FUSED>) -> Lanes<N, FUSED> {
    for x in &mut x.0 {
        *x = x.abs();
    }
    x
}

/// Σ xᵢ, by halves.
#[inline(always)]
pub(crate) fn sum<const N: usize, const FUSED: bool>(mut x: Lanes<N, FUSED>) -> f64 {
    let mut width = N / 2;
    while width > 0 {
        for i in 0..width {
            x.0[i] += x.0[i + width];
        }
        width /= 2;
    }
    x.0[0]
}
