//! Denavit-Hartenberg rows and explicit joint frames, lowered to one form.
//!
//! Whatever the convention, a link becomes two constant poses with the joint between them:
//! parent link frame → `before` → joint (about or along z) → `after` → link frame. No algorithm knows about conventions.

use crate::error::ModelError;
use crate::joint::{Joint, frame_with_z};
use crate::spatial::Pose;
use nalgebra::{ComplexField, Matrix3, Vector3};

/// The constant poses before and after a joint's own motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// The joint's frame at coordinate zero in the parent's link frame.
    pub before: Pose,
    /// The link frame in the joint's moved frame.
    pub after: Pose,
}

/// One row of a Denavit-Hartenberg table: angles in rad, lengths in m.
///
/// `theta` (`d` for a prismatic joint) is the value at coordinate zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DhRow {
    /// Twist between consecutive joint axes.
    pub alpha: f64,
    /// Length of the common normal.
    pub a: f64,
    /// Offset along the joint's axis.
    pub d: f64,
    /// Angle about the joint's axis.
    pub theta: f64,
}

impl DhRow {
    /// `Rz(θ) Tz(d) Tx(a) Rx(α)`: the joint moves about z of the parent's frame, the link frame is distal.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`].
    pub fn standard(&self) -> Result<Placement, ModelError> {
        self.check()?;
        let before = along_and_about_z(self.d, self.theta);
        Ok(Placement { before, after: along_and_about_x(self.a, self.alpha) })
    }

    /// `Rx(α) Tx(a) Rz(θ) Tz(d)` (Craig): the joint moves about z of the link's own frame.
    ///
    /// # Errors
    /// [`ModelError::NotFinite`].
    pub fn modified(&self) -> Result<Placement, ModelError> {
        self.check()?;
        let before = along_and_about_x(self.a, self.alpha) * along_and_about_z(self.d, self.theta);
        Ok(Placement { before, after: Pose::IDENTITY })
    }

    fn check(&self) -> Result<(), ModelError> {
        for (field, x) in [("alpha", self.alpha), ("a", self.a), ("d", self.d), ("theta", self.theta)] {
            if !x.is_finite() {
                return Err(ModelError::NotFinite { field });
            }
        }
        Ok(())
    }
}

/// An explicit joint frame in the parent's link frame, and the axis in it, as URDF has it.
///
/// # Errors
/// Those of [`frame_with_z`].
pub fn explicit(origin: Pose, axis: &Vector3<f64>, joint: Joint) -> Result<Placement, ModelError> {
    if joint == Joint::Fixed {
        return Ok(Placement { before: origin, after: Pose::IDENTITY });
    }
    let turned = frame_with_z(axis)?;
    Ok(Placement { before: origin * turned, after: turned.inverse() })
}

/// `Tz(d) Rz(θ)`; the two commute.
fn along_and_about_z(d: f64, theta: f64) -> Pose {
    let (s, c) = (ComplexField::sin(theta), ComplexField::cos(theta));
    Pose::from_parts(Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0), Vector3::new(0.0, 0.0, d))
}

/// `Tx(a) Rx(α)`; the two commute.
fn along_and_about_x(a: f64, alpha: f64) -> Pose {
    let (s, c) = (ComplexField::sin(alpha), ComplexField::cos(alpha));
    Pose::from_parts(Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c), Vector3::new(a, 0.0, 0.0))
}
