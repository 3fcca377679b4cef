//! The geometric Jacobian: how a frame moves when the coordinates do.

use crate::constants::MAX_JOINTS;
use crate::kinematics::{Axes, outward};
use crate::lanes::{Lanes, Vec3, cross, dot, scale};
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
    let mut at: Option<Axes<W, FUSED>> = None;
    for i in 0..=body {
        if path >> i & 1 == 1 {
            let here = outward(robot, now, i, at.as_ref());
            columns[i] = Column { linear: here.origin, angular: here.z };
            at = Some(here);
        }
    }
    let Some(carrier) = at else { return columns };
    let tip = carrier.then(frame.pose.rotation(), frame.pose.translation());
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
    let turning = Lanes::splat(robot.loads[i].turning);
    let sliding = Lanes::splat(1.0 - robot.loads[i].turning);
    let z = joint.angular;
    let lever = tip.origin - joint.linear;
    let linear = scale(turning, &cross(&z, &lever)) + scale(sliding, &z);
    let angular = scale(turning, &z);
    match axes {
        JacobianAxes::Base => Column { linear, angular },
        JacobianAxes::Frame => {
            let seen = |v: &Vec3<W, FUSED>| Vector3::new(dot(&tip.x, v), dot(&tip.y, v), dot(&tip.z, v));
            Column { linear: seen(&linear), angular: seen(&angular) }
        }
    }
}

/// J_mechanism C.
#[inline(always)]
fn couple<const W: usize, const FUSED: bool>(robot: &Robot, mechanism: &[Column<W, FUSED>; MAX_JOINTS]) -> [Column<W, FUSED>; MAX_JOINTS] {
    let Some(coupling) = robot.coupling() else { return *mechanism };
    let mut columns = [Column::ZERO; MAX_JOINTS];
    for j in 0..coupling.coordinates() {
        for (joint, &c) in mechanism.iter().zip(coupling.column(j)).take(robot.bodies()) {
            columns[j].linear += scale(c.into(), &joint.linear);
            columns[j].angular += scale(c.into(), &joint.angular);
        }
    }
    columns
}
