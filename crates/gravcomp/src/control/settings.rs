//! What is declared about the law, the drives and the encoders; checked once.

use super::law::Law;
use crate::constants::MAX_JOINTS;
use crate::error::{SettingsError, within};
use crate::robot::Joints;
use crate::transmission::Transmission;

/// No gain is larger (SI); what is, could overflow.
const LARGEST_GAIN: f64 = 1e30;

/// Where positions are measured and gains act, or where torques go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Side {
    /// The robot's coordinates q: rad or m, N·m or N.
    #[default]
    Joint,
    /// The motors m of its transmission, q = C m + c₀.
    Motor,
}

/// What the latched fault leads to, always within the limits of torque and rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum OnFault {
    /// The torque that holds the arm at its last good pose.
    #[default]
    Gravity,
    /// No torque.
    Decay,
}

/// Declarations. Numbers of one kind stand in the order of the coordinates, motors or encoders; entries beyond are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Which terms the torque has.
    pub law: Law,
    /// Coordinates of the robot.
    pub coordinates: usize,
    /// Cycles per second.
    pub rate_hz: f64,
    /// Kp at the side of `feedback`, N·m/rad or N/m.
    pub kp: Joints,
    /// Kd at the side of `feedback`, N·m·s/rad or N·s/m.
    pub kd: Joints,
    /// Where positions are measured and gains act.
    pub feedback: Side,
    /// Where torques go, and their limits hold.
    pub output: Side,
    /// From motors to coordinates, where there are motors.
    pub transmission: Option<Transmission>,
    /// Largest torque at the side of `output`, N·m or N; infinite where there is no limit.
    pub tau_max: Joints,
    /// How fast the torque may move, N·m/s or N/s; infinite where there is no limit.
    pub tau_rate_max: Joints,
    /// Lower and upper limits of the coordinates, rad or m; infinite where there is none.
    pub limits: (Joints, Joints),
    /// How far an encoder can move in one cycle, rad or m; infinite for any distance.
    pub jump: Joints,
    /// After what an encoder starts anew, rad or m; infinite for one that does not wrap.
    pub modulus: Joints,
    /// How long arming takes, and every other change between laws, s.
    pub ramp_s: f64,
    /// How long the last good pose stands in for a missing one, s.
    pub hold_s: f64,
    /// What the latched fault leads to.
    pub on_fault: OnFault,
}

impl Settings {
    /// A law for an arm of so many coordinates at 1 kHz, at the joints, without gains and without any limit.
    #[must_use]
    pub const fn of(law: Law, coordinates: usize) -> Self {
        let infinite = Joints([f64::INFINITY; MAX_JOINTS]);
        Self {
            law,
            coordinates,
            rate_hz: 1000.0,
            kp: Joints([0.0; MAX_JOINTS]),
            kd: Joints([0.0; MAX_JOINTS]),
            feedback: Side::Joint,
            output: Side::Joint,
            transmission: None,
            tau_max: infinite,
            tau_rate_max: infinite,
            limits: (Joints([f64::NEG_INFINITY; MAX_JOINTS]), infinite),
            jump: infinite,
            modulus: infinite,
            ramp_s: 1.0,
            hold_s: 0.05,
            on_fault: OnFault::Gravity,
        }
    }

    /// The same if they make sense together.
    ///
    /// # Errors
    /// [`SettingsError`] says which field, of which joint, its value, and what would be right.
    pub fn checked(self) -> Result<Self, SettingsError> {
        self.check_numbers()?;
        self.check_transmission()?;
        for j in 0..self.coordinates {
            self.check_joint(j).map_err(|error| error.of_joint(j))?;
        }
        Ok(self)
    }

    /// The same with numbers that change nothing beyond the arm's own places.
    pub(super) fn padded(mut self) -> Self {
        let none = Self::of(self.law, self.coordinates);
        for j in self.coordinates..MAX_JOINTS {
            (self.kp[j], self.kd[j]) = (none.kp[j], none.kd[j]);
            (self.tau_max[j], self.tau_rate_max[j]) = (none.tau_max[j], none.tau_rate_max[j]);
            (self.limits.0[j], self.limits.1[j]) = (none.limits.0[j], none.limits.1[j]);
            (self.jump[j], self.modulus[j]) = (none.jump[j], none.modulus[j]);
        }
        self
    }

    /// Time between two cycles, s.
    pub(super) fn period(&self) -> f64 {
        1.0 / self.rate_hz
    }

    fn check_numbers(&self) -> Result<(), SettingsError> {
        #[allow(clippy::cast_precision_loss)] // only sizes far beyond the capacity lose precision
        within("coordinates", self.coordinates as f64, 1.0, MAX_JOINTS as f64, "1 to 16, those of the robot")?;
        within("rate_hz", self.rate_hz, 1.0, 1e5, "a rate of 1 to 1e5 cycles per second")?;
        within("ramp_s", self.ramp_s, 0.0, 3600.0, "zero (no ramp) to 3600 s")?;
        within("hold_s", self.hold_s, 0.0, 10.0, "zero to 10 s")
    }

    fn check_transmission(&self) -> Result<(), SettingsError> {
        let error = |field, value, wanted| Err(SettingsError { field, joint: None, value, wanted });
        #[allow(clippy::cast_precision_loss)] // at most 16
        match &self.transmission {
            None if self.feedback == Side::Motor => {
                error("feedback", f64::NAN, "at the joints, as the robot has no transmission")
            }
            None if self.output == Side::Motor => {
                error("output", f64::NAN, "at the joints, as the robot has no transmission")
            }
            Some(transmission) if transmission.motors() != self.coordinates => {
                error("transmission (motors)", transmission.motors() as f64, "as many motors as coordinates")
            }
            _ => Ok(()),
        }
    }

    fn check_joint(&self, j: usize) -> Result<(), SettingsError> {
        let (infinite, tiny) = (f64::INFINITY, f64::MIN_POSITIVE);
        within("kp", self.kp[j], 0.0, LARGEST_GAIN, "zero or positive, at most 1e30")?;
        within("kd", self.kd[j], 0.0, LARGEST_GAIN, "zero or positive, at most 1e30")?;
        within("tau_max", self.tau_max[j], 0.0, infinite, "zero or positive, infinite for no limit")?;
        let rate = "positive, infinite for no limit: a torque that may not move cannot hold anything";
        within("tau_rate_max", self.tau_rate_max[j], tiny, infinite, rate)?;
        within("jump", self.jump[j], tiny, infinite, "positive, infinite for no check")?;
        within("wrap", self.modulus[j], tiny, infinite, "positive, infinite for an encoder that does not wrap")?;
        let half = 0.5 * self.modulus[j];
        if half.is_finite() && self.jump[j].is_finite() {
            within("jump", self.jump[j], tiny, half, "at most half the modulus of an encoder that wraps (wrap / 2)")?;
        }
        let (lower, upper) = (self.limits.0[j], self.limits.1[j]);
        within("limits (lower)", lower, -infinite, f64::MAX, "a number, or -infinity for none")?;
        within("limits (upper)", upper, f64::MIN, infinite, "a number, or infinity for none")?;
        if lower < upper {
            return Ok(());
        }
        Err(SettingsError { field: "limits (upper)", joint: None, value: upper, wanted: "above the lower limit" })
    }
}
