//! The motion of the base, in types that keep the sign straight.
//!
//! [`Gravity`] points down (level: −z); [`SpecificForce`] is what an accelerometer reads, f = a − g (level and at rest: +z).

use crate::constants::STANDARD_GRAVITY;
use crate::error::ModelError;
use crate::spatial::Pose;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

/// The gravity field g in base axes, m/s². Level and at rest it is (0, 0, −9.80665). The paper's ˢg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity(pub Vector3<f64>);

/// What an ideal accelerometer at the base origin reads, f = a − g, in base axes, m/s². Level and at rest (0, 0, +9.80665).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpecificForce(pub Vector3<f64>);

impl Gravity {
    /// The nominal vector of a level base.
    pub const LEVEL: Self = Self(Vector3::new(0.0, 0.0, -STANDARD_GRAVITY));

    /// The field on a base that stands level and is then turned by `angle` (rad) about an axis (base axes, unit length).
    #[must_use]
    pub fn tilted(angle: f64, axis: Unit<Vector3<f64>>) -> Self {
        Self(Rotation3::from_axis_angle(&axis, -angle) * Self::LEVEL.0)
    }
}

impl From<SpecificForce> for Gravity {
    /// The gravity that a base at rest would need to feel the same: g = −f. Base acceleration counts as gravity.
    fn from(f: SpecificForce) -> Self {
        Self(-f.0)
    }
}

impl From<Gravity> for SpecificForce {
    /// What the accelerometer of a base at rest reads: f = −g.
    fn from(g: Gravity) -> Self {
        Self(-g.0)
    }
}

/// How the base moves, all in base axes at the base origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseMotion {
    /// f = a − g, m/s².
    pub specific_force: SpecificForce,
    /// ω, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// dω/dt, rad/s².
    pub angular_acceleration: Vector3<f64>,
}

impl BaseMotion {
    /// A base that neither turns nor accelerates.
    #[must_use]
    pub fn at_rest(gravity: Gravity) -> Self {
        Self {
            specific_force: gravity.into(),
            angular_velocity: Vector3::zeros(),
            angular_acceleration: Vector3::zeros(),
        }
    }

    /// From one sample of an inertial sensor mounted on the base and the base's angular acceleration.
    ///
    /// A sensor at `r` reads the base's motion there: f₀ = R f_s − dω × r − ω × (ω × r), ω = R ω_s.
    #[must_use]
    pub fn from_imu(sample: &ImuSample, mounting: &Mounting) -> Self {
        let (R, r) = (mounting.pose.rotation(), mounting.pose.translation());
        let w = R * sample.angular_velocity;
        let dw = R * sample.angular_acceleration;
        let f = R * sample.specific_force - dw.cross(r) - w.cross(&w.cross(r));
        Self { specific_force: SpecificForce(f), angular_velocity: w, angular_acceleration: dw }
    }
}

/// One reading of an inertial sensor, in the sensor's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImuSample {
    /// Accelerometer, m/s².
    pub specific_force: Vector3<f64>,
    /// Gyroscope, rad/s.
    pub angular_velocity: Vector3<f64>,
    /// Derivative of the gyroscope's reading, rad/s²; zero where unknown.
    pub angular_acceleration: Vector3<f64>,
}

/// Where an inertial sensor sits on the base: `R_BS` maps sensor axes to base axes, `r` is its place, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mounting {
    pose: Pose,
}

impl Mounting {
    /// A checked mounting.
    ///
    /// # Errors
    /// [`ModelError::Mirrored`] for a matrix with determinant −1 (the sign trap of z-down sensors),
    /// [`ModelError::NotARotation`], [`ModelError::NotFinite`].
    #[allow(non_snake_case)]
    pub fn new(R_BS: Matrix3<f64>, position: Vector3<f64>) -> Result<Self, ModelError> {
        Ok(Self { pose: Pose::new(R_BS, position, "sensor mounting")? })
    }

    /// The sensor's frame seen from the base.
    #[must_use]
    pub const fn pose(&self) -> &Pose {
        &self.pose
    }
}
