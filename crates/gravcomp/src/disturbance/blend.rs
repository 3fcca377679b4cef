//! Which way a joint moves, without a step at rest.

use crate::error::{SettingsError, within};
use nalgebra::ComplexField;

/// For which direction of motion a polynomial holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Direction {
    /// Either: weight 1.
    #[default]
    Both,
    /// Positive: weight α = (1 + blend)/2.
    Positive,
    /// Negative: weight 1 − α.
    Negative,
}

/// From the velocity to the direction of motion, −ratio to ratio, as the published controller of the dVRK blends it.
///
/// 0 within the dead band, ±ratio from the saturation on, and between them a straight line, or a hyperbolic tangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    /// Slower is rest, rad/s or m/s.
    pub dead_band: f64,
    /// Above the dead band: the scale of velocities, rad/s or m/s.
    pub saturation: f64,
    /// How much of the difference between the directions is compensated, 0 to 1.
    pub ratio: f64,
    /// ratio · tanh((|v| − dead band)/(saturation − dead band)) in place of the straight line.
    pub smooth: bool,
}

impl Blend {
    pub(super) fn checked(self) -> Result<Self, SettingsError> {
        let (low, high) = (self.dead_band, super::LARGEST);
        within("dead_band", low, 0.0, high, "zero or positive, rad/s or m/s")?;
        within("saturation", self.saturation, low, high, "more than the dead band, rad/s or m/s")?;
        let width = self.saturation - low;
        within("saturation", width, f64::MIN_POSITIVE, high, "more than the dead band, rad/s or m/s")?;
        within("ratio", self.ratio, 0.0, 1.0, "0 to 1")?;
        Ok(self)
    }

    /// −ratio to ratio.
    #[inline(always)]
    pub(super) fn of(&self, v: f64) -> f64 {
        let beyond = v.abs() - self.dead_band;
        let width = self.saturation - self.dead_band;
        if beyond > 0.0 {
            let share = if self.smooth {
                self.ratio * ComplexField::tanh(beyond / width)
            } else if v.abs() >= self.saturation {
                self.ratio
            } else {
                self.ratio * beyond / width
            };
            share.copysign(v)
        } else {
            0.0 * v
        }
    }

    /// How much of a polynomial for `direction` counts.
    #[inline(always)]
    pub(super) fn weight(&self, direction: Direction, v: f64) -> f64 {
        match direction {
            Direction::Both => 1.0,
            Direction::Positive => 0.5 + 0.5 * self.of(v),
            Direction::Negative => 1.0 - (0.5 + 0.5 * self.of(v)),
        }
    }
}
