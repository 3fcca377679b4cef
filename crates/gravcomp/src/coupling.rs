//! Affine coupling: what the user commands and what the mechanism's joints do.
//!
//! q_mechanism = C q + c₀ (mimic joints, parallelograms). Virtual work maps efforts the other way: τ = Cᵀ τ_mechanism.

use crate::constants::MAX_JOINTS;
use crate::error::ModelError;

/// A coupling of `bodies` joints to `coordinates` user coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    bodies: usize,
    coordinates: usize,
    /// `matrix[j][i]` = ∂q_mechanism_i / ∂q_j: one row per coordinate, as the kernels read it.
    matrix: [[f64; MAX_JOINTS]; MAX_JOINTS],
    offset: [f64; MAX_JOINTS],
}

impl Coupling {
    /// From C in row-major order (`bodies` rows of `coordinates` numbers) and c₀.
    ///
    /// # Errors
    /// [`ModelError::CouplingShape`], [`ModelError::NotFinite`] or [`ModelError::CouplingRank`].
    pub fn new(matrix: &[f64], offset: &[f64], coordinates: usize) -> Result<Self, ModelError> {
        let bodies = offset.len();
        let possible = (1..=bodies).contains(&coordinates) && bodies <= MAX_JOINTS;
        if !possible || matrix.len() != bodies * coordinates {
            let rows = matrix.len().checked_div(coordinates).unwrap_or(0);
            return Err(ModelError::CouplingShape { found: (rows, coordinates), bodies });
        }
        if !matrix.iter().chain(offset).all(|x| x.is_finite()) {
            return Err(ModelError::NotFinite { field: "coupling" });
        }
        let mut coupling =
            Self { bodies, coordinates, matrix: [[0.0; MAX_JOINTS]; MAX_JOINTS], offset: [0.0; MAX_JOINTS] };
        for (i, (row, &c0)) in matrix.chunks_exact(coordinates).zip(offset).enumerate() {
            coupling.offset[i] = c0;
            for (j, &c) in row.iter().enumerate() {
                coupling.matrix[j][i] = c;
            }
        }
        if coupling.full_rank() { Ok(coupling) } else { Err(ModelError::CouplingRank) }
    }

    /// Rows of C: the mechanism's moving bodies.
    #[must_use]
    pub const fn bodies(&self) -> usize {
        self.bodies
    }

    /// Columns of C: the user's coordinates.
    #[must_use]
    pub const fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// ∂q_mechanism / ∂q_j for each coordinate j.
    pub(crate) fn columns(&self) -> &[[f64; MAX_JOINTS]] {
        &self.matrix[..self.coordinates.min(MAX_JOINTS)]
    }

    /// c₀.
    pub(crate) const fn offset(&self) -> &[f64; MAX_JOINTS] {
        &self.offset
    }

    /// Columns stay longer than 1e-12 of themselves after the earlier ones are taken out (Gram-Schmidt).
    fn full_rank(&self) -> bool {
        let mut basis = self.matrix;
        for j in 0..self.coordinates {
            let before = dot(&basis[j], &basis[j]);
            for k in 0..j {
                let (done, rest) = basis.split_at_mut(j);
                let along = dot(&done[k], &rest[0]) / dot(&done[k], &done[k]);
                for (x, u) in rest[0].iter_mut().zip(&done[k]) {
                    *x -= along * u;
                }
            }
            if dot(&basis[j], &basis[j]) <= 1e-24 * before {
                return false;
            }
        }
        true
    }
}

fn dot(a: &[f64; MAX_JOINTS], b: &[f64; MAX_JOINTS]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
