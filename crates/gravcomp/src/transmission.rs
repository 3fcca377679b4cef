//! Actuators to coordinates: cables, gears and differentials that couple motors.
//!
//! q = C m + c₀ for motor positions m, hence τ_motor = Cᵀ τ by virtual work: exactly, not by the diagonal of C.

use crate::constants::MAX_JOINTS;
use crate::error::ModelError;
use crate::robot::Joints;

type Square = [[f64; MAX_JOINTS]; MAX_JOINTS];

/// An invertible map between as many motors as coordinates.
///
/// C and C⁻¹ are kept by rows and by columns: a sum of rows times numbers runs side by side in the processor's lanes. Rows
/// begin where cache lines do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Transmission {
    joint_per_motor: Square,
    joint_per_motor_columns: Square,
    motor_per_joint: Square,
    motor_per_joint_columns: Square,
    offset: Joints,
    motors: usize,
}

impl Transmission {
    /// From C = ∂q/∂m in row-major order (one row per coordinate) and c₀.
    ///
    /// # Errors
    /// [`ModelError::TransmissionShape`], [`ModelError::NotFinite`] or [`ModelError::TransmissionSingular`].
    pub fn new(joint_per_motor: &[f64], offset: &[f64]) -> Result<Self, ModelError> {
        let motors = offset.len();
        if motors == 0 || motors > MAX_JOINTS || joint_per_motor.len() != motors * motors {
            return Err(ModelError::TransmissionShape { entries: joint_per_motor.len(), motors });
        }
        if !joint_per_motor.iter().chain(offset).all(|x| x.is_finite()) {
            return Err(ModelError::NotFinite { field: "transmission" });
        }
        let mut matrix = [[0.0; MAX_JOINTS]; MAX_JOINTS];
        for (row, given) in matrix.iter_mut().zip(joint_per_motor.chunks_exact(motors)) {
            row[..motors].copy_from_slice(given);
        }
        let motor_per_joint = inverse(matrix, motors).ok_or(ModelError::TransmissionSingular)?;
        Ok(Self {
            joint_per_motor: matrix,
            joint_per_motor_columns: columns(&matrix),
            motor_per_joint,
            motor_per_joint_columns: columns(&motor_per_joint),
            offset: Joints::from_slice(offset),
            motors,
        })
    }

    /// Motors, hence coordinates.
    #[must_use]
    pub const fn motors(&self) -> usize {
        self.motors
    }

    /// Motor efforts for efforts at the coordinates: Cᵀ τ.
    #[must_use]
    pub fn motor_efforts(&self, tau: &Joints) -> Joints {
        Joints(self.motor_efforts_of(&tau.0))
    }

    /// Efforts at the coordinates for motor efforts: C⁻ᵀ τ_motor.
    #[must_use]
    pub fn joint_efforts(&self, tau_motor: &Joints) -> Joints {
        Joints(self.joint_efforts_of(&tau_motor.0))
    }

    /// Coordinates for motor positions: C m + c₀.
    #[must_use]
    pub fn joint_positions(&self, motors: &Joints) -> Joints {
        Joints(self.joint_positions_of(&motors.0))
    }

    /// Motor positions for coordinates: C⁻¹ (q − c₀).
    #[must_use]
    pub fn motor_positions(&self, q: &Joints) -> Joints {
        Joints(self.motor_positions_of(&q.0))
    }

    /// Motor rates for rates of the coordinates: C⁻¹ q̇.
    #[must_use]
    pub fn motor_rates(&self, qd: &Joints) -> Joints {
        Joints(self.motor_rates_of(&qd.0))
    }
}

/// The same for the first `N` ≥ motors numbers side by side, in the instructions of the caller.
impl Transmission {
    #[inline(always)]
    pub(crate) fn motor_efforts_of<const N: usize>(&self, tau: &[f64; N]) -> [f64; N] {
        sum(&self.joint_per_motor, tau, self.motors)
    }

    #[inline(always)]
    pub(crate) fn joint_efforts_of<const N: usize>(&self, tau_motor: &[f64; N]) -> [f64; N] {
        sum(&self.motor_per_joint, tau_motor, self.motors)
    }

    #[inline(always)]
    pub(crate) fn joint_positions_of<const N: usize>(&self, motors: &[f64; N]) -> [f64; N] {
        let mut q = sum(&self.joint_per_motor_columns, motors, self.motors);
        for i in 0..N {
            q[i] += self.offset[i];
        }
        q
    }

    #[inline(always)]
    pub(crate) fn joint_rates_of<const N: usize>(&self, motor_rates: &[f64; N]) -> [f64; N] {
        sum(&self.joint_per_motor_columns, motor_rates, self.motors)
    }

    #[inline(always)]
    pub(crate) fn motor_positions_of<const N: usize>(&self, q: &[f64; N]) -> [f64; N] {
        let mut from_zero = *q;
        for i in 0..N {
            from_zero[i] -= self.offset[i];
        }
        sum(&self.motor_per_joint_columns, &from_zero, self.motors)
    }

    #[inline(always)]
    pub(crate) fn motor_rates_of<const N: usize>(&self, qd: &[f64; N]) -> [f64; N] {
        sum(&self.motor_per_joint_columns, qd, self.motors)
    }
}

fn columns(matrix: &Square) -> Square {
    core::array::from_fn(|j| matrix.map(|row| row[j]))
}

/// Σ rowᵢ xᵢ over the first n: `Aᵀ x` for the rows of A, `A x` for its columns.
#[inline(always)]
fn sum<const N: usize>(rows: &Square, x: &[f64; N], n: usize) -> [f64; N] {
    let mut y = [0.0; N];
    for (row, factor) in rows.iter().zip(x).take(n) {
        for j in 0..N {
            y[j] += row[j] * factor;
        }
    }
    y
}

/// Gauss-Jordan elimination with row pivots; `None` where a pivot is below 1e-13 of its column.
fn inverse(mut a: Square, n: usize) -> Option<Square> {
    let mut inverse = [[0.0; MAX_JOINTS]; MAX_JOINTS];
    for (i, row) in inverse.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    for column in 0..n {
        let scale = (0..n).fold(0.0, |most: f64, i| most.max(a[i][column].abs()));
        let pivot = (column..n).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()))?;
        if a[pivot][column].abs() <= 1e-13 * scale {
            return None;
        }
        a.swap(column, pivot);
        inverse.swap(column, pivot);
        let divisor = a[column][column];
        for j in 0..n {
            a[column][j] /= divisor;
            inverse[column][j] /= divisor;
        }
        let (own, own_inverse) = (a[column], inverse[column]);
        for i in (0..n).filter(|&i| i != column) {
            let factor = a[i][column];
            for j in 0..n {
                a[i][j] -= factor * own[j];
                inverse[i][j] -= factor * own_inverse[j];
            }
        }
    }
    Some(inverse)
}
