//! What is declared about the sensor, its mounting and the base; checked once.

use super::calibration::Calibration;
use super::clock::seconds;
use super::state::Policy;
use crate::base::Mounting;
use crate::constants::STANDARD_GRAVITY;
use crate::error::{SettingsError, within};
use nalgebra::Vector3;

/// No step of a gyroscope at rest is as large as this, rad/s: ten times the noise of a poor one.
const GYRO_NOISE: f64 = 0.1;

/// Declarations, with the defaults of the paper's sensor: a BMA180 at ±2 g and 100 samples per second.
///
/// Limits are about the base, not the sensor: how far it tilts, how suddenly it moves. The defaults fit a table that is
/// rocked by 10-20° at 1 Hz with an order of magnitude to spare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Samples per second.
    pub sample_rate_hz: f64,
    /// Full scale of each axis of the accelerometer, m/s². Readings from 98.9 % of it on are taken as saturated.
    pub range: f64,
    /// Full scale of each axis of the gyroscope, rad/s.
    pub gyro_range: f64,
    /// Bandwidth of the sensor's own filter, Hz, where known; refused above half the rate, where vibration folds down.
    pub bandwidth_hz: Option<f64>,
    /// From what the sensor sends to what it feels.
    pub calibration: Calibration,
    /// Where the sensor sits on the base.
    pub mounting: Mounting,
    /// Up in base axes when the base is level, any length. The nominal gravity is −9.80665 m/s² along it.
    pub up: Vector3<f64>,
    /// Cut-off of the second-order Butterworth low-pass, Hz; without it samples pass as they are.
    pub cutoff_hz: Option<f64>,
    /// What happens when the sensor cannot be trusted.
    pub policy: Policy,

    /// Shortest and longest specific force that the base can feel, m/s².
    pub norm: (f64, f64),
    /// How far the mean of the specific force may be from standard gravity, relative.
    pub norm_tolerance: f64,
    /// Standard deviation of a sample at rest, m/s²: ten of it are no jump.
    pub noise: f64,
    /// How hard the base origin can accelerate, m/s². Where a gyroscope shows the turning, nothing else moves gravity.
    pub linear_acceleration: f64,
    /// How fast the specific force can change, m/s³. What goes further than this and the noise from one sample to the next
    /// is a jump; two of them in a row are an alarm.
    pub jerk: f64,
    /// The base may fall freely and accelerate for long (aircraft, boat): no lower norm, no watch on the slow mean.
    pub moving_base: bool,
    /// How far up may be from `up` at any time, rad: less than the 90° of exchanged axes by the base's largest tilt.
    pub pose_limit: f64,
    /// How far a level found anew may be from the slow tilt estimate, rad.
    pub tilt_limit: f64,
    /// Time constant of the slow tilt estimate, s.
    pub tilt_time: f64,

    /// Oldest sample that may be used, and longest silence without an alarm, ns.
    pub max_age_ns: i64,
    /// Under [`Policy::Strict`]: age up to which a value is held, ns.
    pub hold_ns: i64,
    /// Under [`Policy::Strict`]: age at which the fault latches, ns.
    pub fault_after_ns: i64,
    /// Without anything usable for this long after the start: an alarm, ns.
    pub no_sensor_ns: i64,

    /// Equal triples in a row that say the sensor is stuck; 0 for sensors without noise.
    pub stuck_count: u32,
    /// The same for a single axis.
    pub axis_stuck_count: u32,
    /// Rejected ones among the last 32 samples that raise an alarm.
    pub density: u32,
    /// Good samples in a row after which a sensor is trusted.
    pub start_count: u32,

    /// How fast the output gravity may move, m/s³: no transition steps further than this times the cycle.
    pub gravity_rate: f64,
    /// Largest angular acceleration, rad/s²; what the gyroscope shows beyond it is a jump. Also how fast the output angular
    /// velocity may move.
    pub angular_acceleration: f64,
    /// How fast the output angular acceleration may move, rad/s³.
    pub angular_jerk: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            sample_rate_hz: 100.0,
            range: 2.0 * STANDARD_GRAVITY,
            gyro_range: 35.0,
            bandwidth_hz: None,
            calibration: Calibration::IDENTITY,
            mounting: Mounting::default(),
            up: Vector3::new(0.0, 0.0, 1.0),
            cutoff_hz: Some(20.0),
            policy: Policy::Paper,
            norm: (3.0, 18.0),
            norm_tolerance: 0.15,
            noise: 0.03,
            linear_acceleration: 1.5,
            jerk: 150.0,
            moving_base: false,
            pose_limit: 45_f64.to_radians(),
            tilt_limit: 15_f64.to_radians(),
            tilt_time: 5.0,
            max_age_ns: 40_000_000,
            hold_ns: 50_000_000,
            fault_after_ns: 500_000_000,
            no_sensor_ns: 45_000_000,
            stuck_count: 8,
            axis_stuck_count: 40,
            density: 4,
            start_count: 20,
            gravity_rate: 50.0,
            angular_acceleration: 100.0,
            angular_jerk: 1000.0,
        }
    }
}

impl Settings {
    /// The same if they make sense together.
    ///
    /// # Errors
    /// [`SettingsError`] says which field, its value, and what would be right.
    pub fn checked(self) -> Result<Self, SettingsError> {
        self.check_numbers()?;
        self.check_order()?;
        self.calibration.check()?;
        Ok(self)
    }

    /// Time between two samples, s.
    pub(super) fn period(&self) -> f64 {
        1.0 / self.sample_rate_hz
    }

    /// How far a sample may be from the one `dt` seconds before it, m/s²: at least as for one period, at most as for two.
    pub(super) fn jump(&self, dt: f64) -> f64 {
        10.0 * self.noise + self.jerk * dt.clamp(self.period(), 2.0 * self.period())
    }

    /// How long a sensor can take until it is trusted, ns: its first samples, and how late they may come.
    #[allow(clippy::cast_possible_truncation)] // at most 10 001 s
    pub(super) fn start_ns(&self) -> i64 {
        let samples = f64::from(self.start_count.saturating_add(1)) * self.period();
        self.max_age_ns.saturating_add((1e9 * samples) as i64)
    }

    /// How far an angular velocity may be from the one `dt` seconds before it, rad/s.
    pub(super) fn spin_up(&self, dt: f64) -> f64 {
        GYRO_NOISE + self.angular_acceleration * dt.clamp(self.period(), 2.0 * self.period())
    }

    /// How far the specific force may be from where the gyroscope has carried its mean, m/s².
    pub(super) fn apart(&self) -> f64 {
        10.0 * self.noise + 2.0 * self.linear_acceleration
    }

    fn check_numbers(&self) -> Result<(), SettingsError> {
        let half_rate = self.sample_rate_hz / 2.0;
        within("sample_rate_hz", self.sample_rate_hz, 1.0, 1e5, "a rate of 1 to 1e5 samples per second")?;
        within("range", self.range, 10.0, 1e4, "a full scale of 10 to 1e4 m/s^2 (2 g is 19.6133)")?;
        within("gyro_range", self.gyro_range, 0.1, 1e3, "a full scale of 0.1 to 1e3 rad/s (2000 deg/s is 34.9)")?;
        for (field, hz) in [("cutoff_hz", self.cutoff_hz), ("bandwidth_hz", self.bandwidth_hz)] {
            within(field, hz.unwrap_or(half_rate), 1e-3, half_rate, "at least 1e-3 Hz and at most half the rate")?;
        }
        within("up", self.up.norm(), 1e-3, 1e3, "a direction in base axes, 0.001 to 1000 long")?;
        let lever = self.mounting.pose().translation().norm();
        within("mounting (position)", lever, 0.0, 1e3, "at most 1 km from the base origin (shown in m)")?;
        within("norm_tolerance", self.norm_tolerance, 0.01, 0.5, "a share of gravity, 0.01 to 0.5")?;
        within("noise", self.noise, 0.0, 1.0, "zero to 1 m/s^2")?;
        within("linear_acceleration", self.linear_acceleration, 0.01, 1e4, "0.01 to 1e4 m/s^2")?;
        within("jerk", self.jerk, 1.0, 1e6, "1 to 1e6 m/s^3")?;
        within("pose_limit", self.pose_limit, 0.01, core::f64::consts::PI, "0.01 to pi rad")?;
        within("tilt_limit", self.tilt_limit, 0.01, core::f64::consts::PI, "0.01 to pi rad")?;
        within("tilt_time", self.tilt_time, 0.1, 1e4, "0.1 to 1e4 s")?;
        within("gravity_rate", self.gravity_rate, 0.1, 1e6, "0.1 to 1e6 m/s^3")?;
        within("angular_acceleration", self.angular_acceleration, 0.1, 1e6, "0.1 to 1e6 rad/s^2")?;
        within("angular_jerk", self.angular_jerk, 0.1, 1e7, "0.1 to 1e7 rad/s^3")?;
        within("start_count", self.start_count.into(), 1.0, 1e4, "1 to 10000 samples")?;
        within("density", self.density.into(), 1.0, 32.0, "1 to 32 samples")?;
        let repeats = "0 for never, or 2 to 10000 samples";
        for (field, count) in [("stuck_count", self.stuck_count), ("axis_stuck_count", self.axis_stuck_count)] {
            within(field, if count == 0 { 2.0 } else { count.into() }, 2.0, 1e4, repeats)?;
        }
        Ok(())
    }

    fn check_order(&self) -> Result<(), SettingsError> {
        let (low, high) = self.norm;
        within("norm (lower end)", low, 0.0, STANDARD_GRAVITY * 0.99, "zero or more, and below 9.7 m/s^2")?;
        within("norm (upper end)", high, STANDARD_GRAVITY * 1.01, 2e4, "above 9.9 and at most 2e4 m/s^2")?;
        let day = 86_400.0;
        let age = seconds(self.max_age_ns);
        within("max_age_ns", age, 2.0 * self.period(), day, "at least two sample periods (shown in s)")?;
        within("hold_ns", seconds(self.hold_ns), age, day, "at least max_age_ns (shown in s)")?;
        let patience = seconds(self.fault_after_ns);
        within("fault_after_ns", patience, seconds(self.hold_ns), day, "at least hold_ns (shown in s)")?;
        within(
            "no_sensor_ns",
            seconds(self.no_sensor_ns),
            2.0 * self.period(),
            day,
            "at least two sample periods (in s)",
        )
    }
}
