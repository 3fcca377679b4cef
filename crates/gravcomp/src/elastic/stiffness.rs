//! Joint stiffness K: springs one by one, or springs that cables couple.

use crate::constants::MAX_JOINTS;
use crate::robot::Joints;
use core::fmt;
use nalgebra::ComplexField;

type Square = [[f64; MAX_JOINTS]; MAX_JOINTS];

/// How far (relative) K may be from symmetric: rounding, no more.
const SYMMETRY: f64 = 1e-9;

/// A pivot smaller than this share of its diagonal entry is none.
const PIVOT: f64 = 1e-12;

/// K, held as the compliance K⁻¹ that a cycle needs. N·m/rad, N/m, and N or N·m/m where they couple.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    joints: usize,
    /// Diagonal of K⁻¹.
    each: Joints,
    /// K⁻¹ where it is not diagonal.
    coupled: Option<Square>,
}

/// Numbers that are no joint stiffness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StiffnessError {
    /// Neither one number per joint nor a square of them.
    Shape {
        /// Numbers given.
        entries: usize,
    },
    /// A spring that does not pull back; an infinite one is rigid.
    NotPositive {
        /// Which joint, from 0.
        joint: usize,
        /// Its stiffness.
        value: f64,
    },
    /// An entry of a matrix is NaN or infinite.
    NotFinite,
    /// A matrix that differs from its transpose.
    NotSymmetric {
        /// Where, from 0.
        at: (usize, usize),
    },
    /// A symmetric matrix that is not positive definite: some displacement meets no resistance.
    NotDefinite,
}

impl fmt::Display for StiffnessError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape { entries } => {
                write!(f, "{entries} numbers; give one per joint, or a square matrix, for 1 to {MAX_JOINTS} joints")
            }
            Self::NotPositive { joint, value } => {
                write!(f, "joint {joint} has {value:e}; a stiffness is positive (infinite for a rigid joint)")
            }
            Self::NotFinite => write!(f, "an entry of the matrix is not finite"),
            Self::NotSymmetric { at: (i, j) } => {
                write!(f, "the matrix is not symmetric: entries ({i}, {j}) and ({j}, {i}) differ")
            }
            Self::NotDefinite => {
                write!(f, "the matrix is not positive definite: some displacement meets no resistance")
            }
        }
    }
}

impl core::error::Error for StiffnessError {}

impl Stiffness {
    /// One spring per joint; infinite for a rigid one.
    ///
    /// # Errors
    /// [`StiffnessError::Shape`] or [`StiffnessError::NotPositive`].
    pub fn each(stiffness: &[f64]) -> Result<Self, StiffnessError> {
        let entries = stiffness.len();
        if !(1..=MAX_JOINTS).contains(&entries) {
            return Err(StiffnessError::Shape { entries });
        }
        if let Some(joint) = stiffness.iter().position(|&k| !(k > 0.0 && (1.0 / k).is_finite())) {
            return Err(StiffnessError::NotPositive { joint, value: stiffness[joint] });
        }
        let mut each = Joints::from_slice(stiffness);
        for k in &mut each[..entries] {
            *k = 1.0 / *k;
        }
        Ok(Self { joints: entries, each, coupled: None })
    }

    /// A symmetric positive definite K for `joints` joints, row by row.
    ///
    /// # Errors
    /// [`StiffnessError`] says what is wrong with it.
    pub fn coupled(stiffness: &[f64], joints: usize) -> Result<Self, StiffnessError> {
        if !(1..=MAX_JOINTS).contains(&joints) || stiffness.len() != joints * joints {
            return Err(StiffnessError::Shape { entries: stiffness.len() });
        }
        if !stiffness.iter().copied().all(f64::is_finite) {
            return Err(StiffnessError::NotFinite);
        }
        let mut k = [[0.0; MAX_JOINTS]; MAX_JOINTS];
        for (row, given) in k.iter_mut().zip(stiffness.chunks_exact(joints)) {
            row[..joints].copy_from_slice(given);
        }
        if let Some(at) = asymmetry(&k, joints) {
            return Err(StiffnessError::NotSymmetric { at });
        }
        let compliance = inverse(&k, joints).ok_or(StiffnessError::NotDefinite)?;
        let each = Joints(core::array::from_fn(|i| compliance[i][i]));
        Ok(Self { joints, each, coupled: Some(compliance) })
    }

    /// Joints.
    #[must_use]
    pub const fn joints(&self) -> usize {
        self.joints
    }

    /// K⁻¹ τ: how far the links hang behind their motors (rad, m) under efforts `tau`.
    #[inline]
    #[must_use]
    pub fn sag(&self, tau: &Joints) -> Joints {
        let n = self.joints.min(MAX_JOINTS);
        let mut sag = Joints::default();
        for i in 0..n {
            sag[i] = match &self.coupled {
                None => self.each[i] * tau[i],
                Some(compliance) => compliance[i][..n].iter().zip(&tau[..n]).map(|(c, tau)| c * tau).sum(),
            };
        }
        sag
    }
}

fn asymmetry(k: &Square, n: usize) -> Option<(usize, usize)> {
    let most = k.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (j, i)));
    pairs.into_iter().find(|&(i, j)| (k[i][j] - k[j][i]).abs() > SYMMETRY * most)
}

/// K⁻¹ = L⁻ᵀ L⁻¹ with K = L Lᵀ; `None` where K is not positive definite, or hardly so.
fn inverse(k: &Square, n: usize) -> Option<Square> {
    let l = inverse_of_lower(&cholesky(k, n)?, n);
    let mut inverse = [[0.0; MAX_JOINTS]; MAX_JOINTS];
    for i in 0..n {
        for j in 0..n {
            inverse[i][j] = (i.max(j)..n).map(|m| l[m][i] * l[m][j]).sum();
        }
    }
    inverse.iter().flatten().copied().all(f64::is_finite).then_some(inverse)
}

/// L with K = L Lᵀ.
fn cholesky(k: &Square, n: usize) -> Option<Square> {
    let mut l = [[0.0; MAX_JOINTS]; MAX_JOINTS];
    for j in 0..n {
        for i in j..n {
            let done: f64 = (0..j).map(|m| l[i][m] * l[j][m]).sum();
            let rest = 0.5 * (k[i][j] + k[j][i]) - done;
            if i > j {
                l[i][j] = rest / l[j][j];
            } else if rest > PIVOT * k[j][j] {
                l[j][j] = ComplexField::sqrt(rest);
            } else {
                return None;
            }
        }
    }
    Some(l)
}

fn inverse_of_lower(l: &Square, n: usize) -> Square {
    let mut inverse = [[0.0; MAX_JOINTS]; MAX_JOINTS];
    for j in 0..n {
        for i in j..n {
            let own = if i == j { 1.0 } else { 0.0 };
            let done: f64 = (j..i).map(|m| l[i][m] * inverse[m][j]).sum();
            inverse[i][j] = (own - done) / l[i][i];
        }
    }
    inverse
}
