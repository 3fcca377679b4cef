//! The geometric Jacobian: how a frame moves when the coordinates do.

use crate::constants::MAX_JOINTS;
use crate::kinematics::{Axes, Column, along, vector};
use crate::lanes::{Lanes, Vec3, cross, dot};
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

/// Writes the Jacobian of `frame`, 6 × coordinates, row-major, into `out`, which has exactly this size.
///
/// A joint that carries the frame contributes (z × (p − o), z) if it turns and (z, 0) if it slides, with its axis z and
/// origin o in B and the frame's origin p; the others contribute nothing. With a coupling, J = J_mechanism C.
#[inline(always)]
pub(crate) fn jacobian<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    frame: &Frame,
    axes: JacobianAxes,
    out: &mut [f64],
) {
    let Some(body) = frame.body() else { return out.fill(0.0) };
    let (mut axis, mut origin) = ([Lanes::ZERO; MAX_JOINTS], [Lanes::ZERO; MAX_JOINTS]);
    let last = along(
        robot,
        now,
        body,
        #[inline(always)]
        |i, at| (axis[i], origin[i]) = (at.z, at.origin),
    );
    let tip = last.then(frame.pose.rotation(), frame.pose.translation());
    let n = robot.coordinates();
    match robot.coupling() {
        None => {
            for i in 0..robot.bodies() {
                let column = column(robot, body, i, (&axis[i], &origin[i]), &tip, axes);
                for (k, x) in column.into_iter().enumerate() {
                    if let Some(entry) = out.get_mut(k * n + i) {
                        *entry = x;
                    }
                }
            }
        }
        Some(coupling) => {
            out.fill(0.0);
            for i in 0..robot.bodies() {
                let column = column(robot, body, i, (&axis[i], &origin[i]), &tip, axes);
                for (row, x) in out.chunks_exact_mut(n).zip(column) {
                    for (entry, along) in row.iter_mut().zip(coupling.columns()) {
                        *entry = Lanes::<1, FUSED>::splat(along[i]).mul_add(Lanes([x]), Lanes([*entry])).0[0];
                    }
                }
            }
        }
    }
}

/// The column of joint i of the mechanism, from its axis and origin, for the frame `tip` that `body` carries.
#[inline(always)]
fn column<const FUSED: bool>(
    robot: &Robot,
    body: usize,
    i: usize,
    (axis, origin): (&Column<FUSED>, &Column<FUSED>),
    tip: &Axes<FUSED>,
    axes: JacobianAxes,
) -> [f64; 6] {
    if !robot.carries(i, body) {
        return [0.0; 6];
    }
    let z = vector(axis);
    let (linear, angular) = if robot.loads[i].slides {
        (z, Vector3::from_element(Lanes::ZERO))
    } else {
        (cross(&z, &vector(&(tip.origin - *origin))), z)
    };
    match axes {
        JacobianAxes::Base => numbers(&linear, &angular),
        JacobianAxes::Frame => numbers(&seen_from(tip, &linear), &seen_from(tip, &angular)),
    }
}

/// Linear, then angular components.
#[inline(always)]
fn numbers<const FUSED: bool>(linear: &Vec3<1, FUSED>, angular: &Vec3<1, FUSED>) -> [f64; 6] {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z].map(|x| x.0[0])
}

/// `Rᵀ v`.
#[inline(always)]
fn seen_from<const FUSED: bool>(axes: &Axes<FUSED>, v: &Vec3<1, FUSED>) -> Vec3<1, FUSED> {
    Vector3::new(dot(&vector(&axes.x), v), dot(&vector(&axes.y), v), dot(&vector(&axes.z), v))
}
