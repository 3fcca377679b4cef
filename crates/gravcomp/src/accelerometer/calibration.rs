//! From what the sensor sends to what it feels.

use crate::error::{SettingsError, within};
use nalgebra::{Matrix3, Vector3};

/// Bias, scale and misalignment, in the sensor's axes: f = S (s − b), ω = ω_s − b_ω.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// b: what the accelerometer sends when it feels nothing, m/s².
    pub bias: Vector3<f64>,
    /// S: the inverse of scale and misalignment; close to the identity.
    pub correction: Matrix3<f64>,
    /// b_ω: what the gyroscope sends at rest, rad/s.
    pub gyro_bias: Vector3<f64>,
}

impl Default for Calibration {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Calibration {
    /// The sensor says what it feels.
    pub const IDENTITY: Self = Self {
        bias: Vector3::new(0.0, 0.0, 0.0),
        correction: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        gyro_bias: Vector3::new(0.0, 0.0, 0.0),
    };

    /// f = S (s − b), m/s².
    pub(super) fn specific_force(&self, sent: &Vector3<f64>) -> Vector3<f64> {
        self.correction * (sent - self.bias)
    }

    /// ω = ω_s − b_ω, rad/s.
    pub(super) fn angular_velocity(&self, sent: &Vector3<f64>) -> Vector3<f64> {
        sent - self.gyro_bias
    }

    /// Larger numbers are a wrong unit or a wrong matrix; they also keep every product finite.
    pub(super) fn check(&self) -> Result<(), SettingsError> {
        for bias in &self.bias {
            within("bias", *bias, -5.0, 5.0, "within 5 m/s^2 of zero")?;
        }
        for bias in &self.gyro_bias {
            within("gyro_bias", *bias, -1.0, 1.0, "within 1 rad/s of zero")?;
        }
        for (i, entry) in self.correction.iter().enumerate() {
            let ideal = if i % 4 == 0 { 1.0 } else { 0.0 };
            within(
                "correction",
                *entry,
                ideal - 0.3,
                ideal + 0.3,
                "within 0.3 of the identity (unit and axes go elsewhere)",
            )?;
        }
        Ok(())
    }
}
