//! Joints: one degree of freedom about or along the z-axis of the body that the joint carries.

use crate::error::ModelError;
use crate::spatial::Pose;
use nalgebra::{ComplexField, Matrix3, Vector3};

/// How a link is carried by its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// Turns about its axis; the coordinate is an angle, rad, the effort a torque, N·m.
    Revolute,
    /// Slides along its axis; the coordinate is a length, m, the effort a force, N.
    Prismatic,
    /// Rigidly attached.
    Fixed,
}

/// A rotation whose z-axis is `axis`, exact for the coordinate axes.
///
/// # Errors
/// [`ModelError::NotFinite`] or [`ModelError::ZeroAxis`].
pub fn frame_with_z(axis: &Vector3<f64>) -> Result<Pose, ModelError> {
    if !axis.iter().copied().all(f64::is_finite) {
        return Err(ModelError::NotFinite { field: "axis" });
    }
    let length = ComplexField::sqrt(axis.norm_squared());
    if length == 0.0 {
        return Err(ModelError::ZeroAxis);
    }
    let z = axis / length;
    // The coordinate axis farthest from z completes the frame without loss of digits.
    let x = match z.iamin() {
        0 => Vector3::x(),
        1 => Vector3::y(),
        _ => Vector3::z(),
    };
    let y = z.cross(&x);
    let y = y / ComplexField::sqrt(y.norm_squared());
    Ok(Pose::from_parts(Matrix3::from_columns(&[y.cross(&z), y, z]), Vector3::zeros()))
}
