//! H with some of its places solved for: principal pivots by the sweep operator.
//!
//! After J. H. Goodnight, "A tutorial on the SWEEP operator", The American Statistician 33(3), 1979, with the signs that keep it
//! symmetric. With the free places F pivoted and B the others, the tableau is
//!
//! > ⎡ −H_FF⁻¹       H_FF⁻¹ H_FB              ⎤
//! > ⎣ H_BF H_FF⁻¹   H_BB − H_BF H_FF⁻¹ H_FB  ⎦
//!
//! whatever the order of the pivots was, and a second pivot on a place undoes its first.

use crate::lanes::Lanes;

/// The tableau, row by row, and the bounds of its pivots.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tableau<const N: usize, const FUSED: bool> {
    rows: [Lanes<N, FUSED>; N],
    /// d: no pivot of diag(d) + Jᵀ W J is smaller, but for rounding.
    least: [f64; N],
    /// 1/Hᵢᵢ: nor one of its inverse than this.
    least_inverse: [f64; N],
}

impl<const N: usize, const FUSED: bool> Tableau<N, FUSED> {
    /// Nothing solved for yet.
    #[inline(always)]
    pub fn new(rows: [Lanes<N, FUSED>; N], least: [f64; N]) -> Self {
        let mut least_inverse = [0.0; N];
        for i in 0..N {
            least_inverse[i] = 1.0 / rows[i].0[i];
        }
        Self { rows, least, least_inverse }
    }

    #[inline(always)]
    pub fn row(&self, i: usize) -> Lanes<N, FUSED> {
        self.rows[i]
    }

    /// Solves for place k, or undoes it.
    #[inline(always)]
    pub fn pivot(&mut self, k: usize) {
        let row = self.rows[k];
        let given = row.0[k];
        let pivot = if given >= 0.0 { given.max(self.least[k]) } else { given.min(-self.least_inverse[k]) };
        let inverse = 1.0 / pivot;
        let (mut others, mut keep) = (row, Lanes::splat(1.0));
        for l in 0..N {
            others.0[l] = if l == k { -pivot.signum() } else { row.0[l] };
            keep.0[l] = if l == k { 0.0 } else { 1.0 };
        }
        for i in 0..N {
            // T_ij − T_ik T_kj / T_kk, and T_ik / |T_kk| in column k.
            self.rows[i] = others.mul_add(Lanes::splat(-(row.0[i] * inverse)), self.rows[i] * keep);
        }
        self.rows[k] = others * Lanes::splat(inverse.abs());
    }
}
