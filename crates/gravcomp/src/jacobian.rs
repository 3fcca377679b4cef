//! The geometric Jacobian: how a frame moves when the coordinates do.

use crate::constants::MAX_JOINTS;
use crate::kinematics::Axes;
use crate::lanes::{Lanes, Vec3, cross, scale};
use crate::motion::JointsNow;
use crate::robot::{Frame, Robot};
use nalgebra::Vector3;

/// The axes in which a Jacobian's six rows are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JacobianAxes {
    /// Axes of the base frame B.
    Base,
    /// Axes of the frame itself.
    Frame,
}

/// One column: linear velocity of the frame's origin, then angular velocity, for a unit rate of one coordinate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Column<const W: usize, const FUSED: bool> {
    pub linear: Vec3<W, FUSED>,
    pub angular: Vec3<W, FUSED>,
}

impl<const W: usize, const FUSED: bool> Column<W, FUSED> {
    pub const ZERO: Self = Self {
        linear: Vector3::new(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO),
        angular: Vector3::new(Lanes::ZERO, Lanes::ZERO, Lanes::ZERO),
    };
}

/// Columns of the Jacobian of `frame`, one per coordinate.
///
/// A joint that carries the frame contributes (z × (p − o), z) if it turns and (z, 0) if it slides, with its axis z and
/// origin o in B and the frame's origin p; the others contribute nothing. With a coupling, J = J_mechanism C.
#[inline(always)]
pub(crate) fn jacobian<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    frame: &Frame,
    axes: JacobianAxes,
) -> [Column<W, FUSED>; MAX_JOINTS] {
    let mut columns = [Column::ZERO; MAX_JOINTS];
    let Some(body) = frame.body() else { return columns };
    let path = robot.ancestors[body];
    let mut at = Axes::BASE;
    for i in 0..=body {
        if path >> i & 1 == 1 {
            at = at.carry(robot, now, i);
            columns[i] = Column { linear: at.origin, angular: at.z };
        }
    }
    let tip = at.then(frame.pose.rotation(), frame.pose.translation());
    for i in 0..=body {
        if path >> i & 1 == 1 {
            columns[i] = column(robot, i, &columns[i], &tip, axes);
        }
    }
    couple(robot, &columns)
}

/// From a joint's origin (held in `linear`) and axis (in `angular`) to its column.
#[inline(always)]
fn column<const W: usize, const FUSED: bool>(
    robot: &Robot,
    i: usize,
    joint: &Column<W, FUSED>,
    tip: &Axes<W, FUSED>,
    axes: JacobianAxes,
) -> Column<W, FUSED> {
    let turning = Lanes::splat(robot.turning[i]);
    let sliding = Lanes::splat(1.0 - robot.turning[i]);
    let z = joint.angular;
    let lever = tip.origin - joint.linear;
    let linear = scale(turning, &cross(&z, &lever)) + scale(sliding, &z);
    let angular = scale(turning, &z);
    match axes {
        JacobianAxes::Base => Column { linear, angular },
        JacobianAxes::Frame => Column { linear: tip.unrotate(&linear), angular: tip.unrotate(&angular) },
    }
}

/// J_mechanism C.
#[inline(always)]
fn couple<const W: usize, const FUSED: bool>(
    robot: &Robot,
    mechanism: &[Column<W, FUSED>; MAX_JOINTS],
) -> [Column<W, FUSED>; MAX_JOINTS] {
    let Some(coupling) = robot.coupling() else { return *mechanism };
    let mut columns = [Column::ZERO; MAX_JOINTS];
    for (column, along) in columns.iter_mut().zip(coupling.columns()) {
        for (joint, &c) in mechanism.iter().zip(along).take(robot.bodies()) {
            column.linear += scale(c.into(), &joint.linear);
            column.angular += scale(c.into(), &joint.angular);
        }
    }
    columns
}
