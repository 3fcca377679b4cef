//! What is declared about the task, its damping and the joints' limits; checked once.

use super::factor::ROWS;
use crate::constants::MAX_JOINTS;
use crate::error::{SettingsError, within};
use crate::robot::{Frame, Joints};
use nalgebra::Vector3;

/// No rate, length or acceleration of an arm is larger (SI); what is, could overflow.
const LARGEST: f64 = 1e9;

/// What is to be moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Task {
    /// The frame: linear and angular velocity, those rows of them that [`Settings::rows`] names.
    #[default]
    Twist,
    /// The frame's origin.
    Position,
    /// The frame's origin, and where its pointing axis points; the turn about that axis is free.
    Pointing,
    /// The frame's origin, with the shaft along its pointing axis through the trocar.
    RemoteCentre,
}

impl Task {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Twist, Self::Position, Self::Pointing, Self::RemoteCentre];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Twist => "twist",
            Self::Position => "position",
            Self::Pointing => "pointing",
            Self::RemoteCentre => "remote_centre",
        }
    }

    /// How many numbers its twist has.
    #[must_use]
    pub const fn twist_len(self) -> usize {
        match self {
            Self::Position => 3,
            Self::Twist | Self::Pointing | Self::RemoteCentre => 6,
        }
    }
}

/// How a task near a singularity is damped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Damping {
    /// λ² = λ_max² (1 − σ²/ε²) where the smallest singular value σ < ε (Chiaverini, Siciliano, Egeland 1994); σ is tracked
    /// (Maciejewski, Klein 1988).
    #[default]
    Adaptive,
    /// The same λ, but only along the direction of σ (numerical filtering).
    Filtered,
    /// λ² = λ_max² (1 − w/ε)² where w = √det(J Jᵀ) < ε (Nakamura, Hanafusa 1986).
    Manipulability,
    /// λ = λ_max (Wampler 1986), at every pose, so that it is no event.
    Constant,
    /// Each singular direction is cut to what it does for the task (Buss, Kim 2005).
    Selective,
}

impl Damping {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Adaptive, Self::Filtered, Self::Manipulability, Self::Constant, Self::Selective];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Adaptive => "adaptive",
            Self::Filtered => "filtered",
            Self::Manipulability => "manipulability",
            Self::Constant => "constant",
            Self::Selective => "selective",
        }
    }
}

/// What the joints do that does not move the task.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum NullSpace {
    /// As little as possible.
    #[default]
    Still,
    /// They go to the middle between their limits.
    Limits,
    /// They go to [`Settings::posture`].
    Posture,
    /// They go where the task's manipulability grows, by its logarithm (Yoshikawa 1985).
    Manipulability,
}

impl NullSpace {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Still, Self::Limits, Self::Posture, Self::Manipulability];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Still => "none",
            Self::Limits => "limits",
            Self::Posture => "posture",
            Self::Manipulability => "manipulability",
        }
    }
}

/// What gives way at the limits of the joints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Priority {
    /// The speed: the motion is slowed down as a whole and keeps its direction.
    #[default]
    Direction,
    /// As little of the task as can be: the joints that are left do what those at their limits cannot, by least squares
    /// within the limits.
    Task,
    /// As Task, and the task is traded for manipulability (Haviland, Corke 2020).
    Manipulability,
}

impl Priority {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Direction, Self::Task, Self::Manipulability];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Direction => "scale",
            Self::Task => "qp",
            Self::Manipulability => "manipulability",
        }
    }
}

/// Declarations. Numbers of one kind stand in the order of the coordinates; entries beyond are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// What is to be moved.
    pub task: Task,
    /// Which rows a [`Task::Twist`] has, linear first, in base axes.
    pub rows: [bool; ROWS],
    /// Whose motion it is; the robot's tool, as it is at each step, where there is none.
    pub frame: Option<Frame>,
    /// How a task near a singularity is damped.
    pub damping: Damping,
    /// ε: where damping begins, a singular value or √det(J Jᵀ).
    pub eps: f64,
    /// λ_max.
    pub lambda_max: f64,
    /// Coordinates of the robot.
    pub coordinates: usize,
    /// Steps per second, as planned; each step says how long it is.
    pub rate_hz: f64,
    /// Largest rate, rad/s or m/s; infinite where there is no limit.
    pub qd_max: Joints,
    /// Largest acceleration, rad/s² or m/s²; infinite where there is no limit.
    pub qdd_max: Joints,
    /// Largest jerk, rad/s³ or m/s³; infinite where there is no limit.
    pub qddd_max: Joints,
    /// Limits of the positions, rad or m; infinite where there is none.
    pub limits: (Joints, Joints),
    /// How fast the distance of a joint from a limit of its position may decay, 1/s.
    pub damper: f64,
    /// What gives way at the limits.
    pub priority: Priority,
    /// What the joints do that does not move the task.
    pub null_space: NullSpace,
    /// How fast they do it, 1/s.
    pub null_gain: f64,
    /// Where they go with [`NullSpace::Posture`], rad or m.
    pub posture: Joints,
    /// The length that weighs as much as a radian, m.
    pub characteristic_length: f64,
    /// Where the trocar is at first, base axes, m.
    pub remote_centre: Vector3<f64>,
    /// The axis that points, in the frame's own axes; of any length.
    pub pointing_axis: Vector3<f64>,
    /// How fast position errors decay, 1/s.
    pub gain: f64,
    /// How fast orientation errors decay, 1/s.
    pub turning_gain: f64,
    /// Largest speed that a position error makes, m/s; infinite where there is no limit.
    pub speed_max: f64,
    /// Largest speed that an orientation error makes, rad/s; infinite where there is no limit.
    pub turning_max: f64,
    /// J is taken half a step ahead, where the arm is on average.
    pub midpoint: bool,
}

impl Settings {
    /// The tool's twist for an arm of so many coordinates at 1 kHz, without any limit.
    #[must_use]
    pub const fn of(coordinates: usize) -> Self {
        let infinite = Joints([f64::INFINITY; MAX_JOINTS]);
        Self {
            task: Task::Twist,
            rows: [true; ROWS],
            frame: None,
            damping: Damping::Adaptive,
            eps: 0.04,
            lambda_max: 0.04,
            coordinates,
            rate_hz: 1000.0,
            qd_max: infinite,
            qdd_max: infinite,
            qddd_max: infinite,
            limits: (Joints([f64::NEG_INFINITY; MAX_JOINTS]), infinite),
            damper: 20.0,
            priority: Priority::Direction,
            null_space: NullSpace::Still,
            null_gain: 1.0,
            posture: Joints([0.0; MAX_JOINTS]),
            characteristic_length: 1.0,
            remote_centre: Vector3::new(0.0, 0.0, 0.0),
            pointing_axis: Vector3::new(0.0, 0.0, 1.0),
            gain: 50.0,
            turning_gain: 50.0,
            speed_max: f64::INFINITY,
            turning_max: f64::INFINITY,
            midpoint: false,
        }
    }
}

impl Settings {
    /// The same if they make sense together.
    ///
    /// # Errors
    /// [`SettingsError`] says which field, of which coordinate, its value, and what would be right.
    pub fn checked(self) -> Result<Self, SettingsError> {
        self.check_task()?;
        self.check_numbers()?;
        for j in 0..self.coordinates {
            self.check_joint(j).map_err(|error| error.of_joint(j))?;
        }
        Ok(self)
    }

    /// The same with numbers that change nothing beyond the arm's own places.
    pub(super) fn padded(mut self) -> Self {
        let none = Self::of(self.coordinates);
        for j in self.coordinates..MAX_JOINTS {
            self.qd_max[j] = none.qd_max[j];
            (self.qdd_max[j], self.qddd_max[j]) = (none.qdd_max[j], none.qddd_max[j]);
            (self.limits.0[j], self.limits.1[j]) = (none.limits.0[j], none.limits.1[j]);
            self.posture[j] = 0.0;
        }
        self
    }

    fn check_task(&self) -> Result<(), SettingsError> {
        if self.task == Task::Twist && !self.rows.contains(&true) {
            return Err(SettingsError {
                field: "rows",
                joint: None,
                value: 0.0,
                wanted: "true for one to six of them",
            });
        }
        let climbs = self.null_space == NullSpace::Manipulability || self.priority == Priority::Manipulability;
        let cut = self.task == Task::Twist && self.rows.contains(&false);
        if climbs && (cut || self.task == Task::RemoteCentre) {
            let wanted = "a whole twist, a position or a pointing task where manipulability is to grow";
            return Err(SettingsError { field: "task", joint: None, value: f64::NAN, wanted });
        }
        // Sums, not the largest: that overlooks NaN.
        let length = self.pointing_axis.abs().sum();
        within("pointing_axis", length, 1e-9, LARGEST, "a direction: finite numbers, not all zero")?;
        let far = self.remote_centre.abs().sum();
        within("remote_centre", far, 0.0, LARGEST, "a point, in m")
    }

    fn check_numbers(&self) -> Result<(), SettingsError> {
        let infinite = f64::INFINITY;
        #[allow(clippy::cast_precision_loss)] // only sizes far beyond the capacity lose precision
        within("coordinates", self.coordinates as f64, 1.0, MAX_JOINTS as f64, "1 to 16, those of the robot")?;
        within("rate_hz", self.rate_hz, 1.0, 1e5, "a rate of 1 to 1e5 steps per second")?;
        within("eps", self.eps, 1e-6, 1e6, "positive: a singular value of the task's Jacobian, 0.04 is usual")?;
        within("lambda_max", self.lambda_max, 1e-6, 1e6, "positive, 0.04 is usual")?;
        within("characteristic_length", self.characteristic_length, 1e-6, 1e6, "positive, in m")?;
        within("damper", self.damper, 1e-3, self.rate_hz, "positive, at most rate_hz")?;
        within("null_gain", self.null_gain, 0.0, self.rate_hz, "zero to rate_hz: more than that overshoots")?;
        within("gain", self.gain, 0.0, self.rate_hz, "zero to rate_hz: more than that overshoots")?;
        within("turning_gain", self.turning_gain, 0.0, self.rate_hz, "zero to rate_hz: more than that overshoots")?;
        within("speed_max", self.speed_max, f64::MIN_POSITIVE, infinite, "positive, infinite for no limit")?;
        within("turning_max", self.turning_max, f64::MIN_POSITIVE, infinite, "positive, infinite for no limit")
    }

    fn check_joint(&self, j: usize) -> Result<(), SettingsError> {
        let (infinite, tiny) = (f64::INFINITY, f64::MIN_POSITIVE);
        within("qd_max", self.qd_max[j], tiny, infinite, "positive, infinite for no limit")?;
        within("qdd_max", self.qdd_max[j], tiny, infinite, "positive, infinite for no limit")?;
        within("qddd_max", self.qddd_max[j], tiny, infinite, "positive, infinite for no limit")?;
        within("posture", self.posture[j], -LARGEST, LARGEST, "a position, rad or m")?;
        let (lower, upper) = (self.limits.0[j], self.limits.1[j]);
        within("q_min", lower, -infinite, f64::MAX, "a number, or -infinity for none")?;
        within("q_max", upper, f64::MIN, infinite, "a number, or infinity for none")?;
        if lower < upper {
            return Ok(());
        }
        Err(SettingsError { field: "q_max", joint: None, value: upper, wanted: "above q_min" })
    }
}
