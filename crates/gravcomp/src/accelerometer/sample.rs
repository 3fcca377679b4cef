//! What goes in, and what comes out.

use super::fault::Status;
use super::state::State;
use crate::base::{BaseMotion, Gravity};
use nalgebra::Vector3;

/// What a sensor sent, in its own axes, before any calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Strictly increasing per sensor.
    pub seq: u64,
    /// When it was taken (or came, for sensors without a clock), on the clock of the caller's `now_ns`, ns.
    pub stamp_ns: i64,
    /// f = a − g, m/s²: +9.81 along up at rest.
    pub specific_force: Vector3<f64>,
    /// Gyroscope, rad/s, where there is one.
    pub angular_velocity: Option<Vector3<f64>>,
}

/// What the arm gets in a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Gravity at the base origin, base axes, m/s²: for [`gravity_torque`](crate::portable::gravity_torque). It contains the
    /// base's acceleration; always finite, never longer than the upper end of [`norm`](super::Settings::norm), and no further
    /// from the one before than [`gravity_rate`](super::Settings::gravity_rate) times the cycle.
    pub gravity: Gravity,
    /// The same as specific force, with the base's turning where there is a gyroscope (else zero).
    pub base: BaseMotion,
    /// Where it comes from.
    pub state: State,
    /// Age of the last accepted sample, ns; none before the first one. Rejected samples do not make it younger.
    pub age_ns: Option<i64>,
    /// What is wrong.
    pub status: Status,
}
