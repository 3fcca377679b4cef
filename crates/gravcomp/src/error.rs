//! What can be wrong with a robot, or with what is declared. Only construction and re-configuration can fail; a cycle cannot.

use crate::constants::MAX_JOINTS;
use core::fmt;

/// A number, frame or table that no robot can have. `link` counts from 0 in the order in which links were added.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// No moving body, or more than [`MAX_JOINTS`].
    BodyCount {
        /// Bodies asked for.
        found: usize,
    },
    /// A number is NaN or infinite.
    NotFinite {
        /// Which quantity.
        field: &'static str,
    },
    /// A mass below zero.
    NegativeMass {
        /// The mass, kg.
        mass: f64,
    },
    /// Without mass there is no inertia.
    InertiaWithoutMass,
    /// Principal moments of inertia that no body can have: one is negative, or one exceeds the sum of the others.
    ImpossibleInertia {
        /// Principal moments about the centre of mass, ascending, kg·m².
        principal: [f64; 3],
    },
    /// A matrix that is not orthonormal.
    NotARotation {
        /// Which frame.
        field: &'static str,
        /// Largest entry of `RᵀR − 1`.
        error: f64,
    },
    /// An orthonormal matrix with determinant −1: a left-handed frame.
    Mirrored {
        /// Which frame.
        field: &'static str,
    },
    /// A joint axis of length zero.
    ZeroAxis,
    /// A coupling with the wrong number of rows or columns.
    CouplingShape {
        /// Rows and columns found.
        found: (usize, usize),
        /// Moving bodies, hence rows wanted.
        bodies: usize,
    },
    /// A transmission matrix that is not square, or of another size than its offset.
    TransmissionShape {
        /// Numbers in the matrix.
        entries: usize,
        /// Motors, by the offset's length.
        motors: usize,
    },
    /// A transmission that cannot be inverted: two motors move the coordinates alike.
    TransmissionSingular,
    /// A coupling with linearly dependent columns: two coordinates move the mechanism alike.
    CouplingRank,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BodyCount { found } => write!(f, "{found} moving bodies; a robot has 1 to {MAX_JOINTS}"),
            Self::NotFinite { field } => write!(f, "{field} is not finite"),
            Self::NegativeMass { mass } => write!(f, "mass is {mass} kg; a mass is zero or positive"),
            Self::InertiaWithoutMass => write!(f, "inertia without mass; give the link a mass or no inertia"),
            Self::ImpossibleInertia { principal: [a, b, c] } => write!(
                f,
                "principal moments of inertia {a:e}, {b:e}, {c:e} kg m^2 belong to no body; none is negative and none \
                 exceeds the sum of the other two (is the inertia given about the centre of mass?)"
            ),
            Self::NotARotation { field, error } => {
                write!(f, "{field} is not a rotation: R^T R differs from 1 by {error:e} (at most 1e-9)")
            }
            Self::Mirrored { field } => {
                write!(f, "{field} is a mirror (determinant -1), not a rotation; one axis has the wrong sign")
            }
            Self::ZeroAxis => write!(f, "joint axis has length zero"),
            Self::CouplingShape { found: (rows, columns), bodies } => write!(
                f,
                "coupling matrix is {rows} x {columns}; it has one row per moving body ({bodies}) and 1 to {bodies} columns"
            ),
            Self::TransmissionShape { entries, motors } => write!(
                f,
                "transmission matrix has {entries} numbers for {motors} motors; it is square, with 1 to {MAX_JOINTS} motors"
            ),
            Self::TransmissionSingular => {
                write!(f, "transmission matrix is singular; two motors move the joints alike")
            }
            Self::CouplingRank => write!(f, "columns of the coupling matrix are linearly dependent"),
        }
    }
}

impl core::error::Error for ModelError {}

/// A declaration that cannot be meant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SettingsError {
    /// Which field, by the name that Python gives it or translates.
    pub field: &'static str,
    /// Of which coordinate, motor or encoder, from 0, where it is about one.
    pub joint: Option<usize>,
    /// What it was, in the unit that `wanted` speaks of; NaN also for what is no number.
    pub value: f64,
    /// What would be right.
    pub wanted: &'static str,
}

impl SettingsError {
    /// The same, about one coordinate.
    pub(crate) const fn of_joint(self, joint: usize) -> Self {
        Self { joint: Some(joint), ..self }
    }
}

impl fmt::Display for SettingsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (field, value, wanted) = (self.field, self.value, self.wanted);
        match self.joint {
            Some(joint) => write!(f, "{field} of joint {joint} is {value:?}; it should be {wanted}"),
            None => write!(f, "{field} is {value:?}; it should be {wanted}"),
        }
    }
}

impl core::error::Error for SettingsError {}

/// Refuses what is not between `low` and `high`, NaN included.
pub(crate) fn within(
    field: &'static str,
    value: f64,
    low: f64,
    high: f64,
    wanted: &'static str,
) -> Result<(), SettingsError> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(SettingsError { field, joint: None, value, wanted }) }
}
