//! The geometric Jacobian: how a frame moves when the coordinates do.

use crate::constants::MAX_JOINTS;
use crate::kinematics::{Axes, Column, chain, column_of, vector};
use crate::lanes::{Lanes, dot};
use crate::motion::JointsNow;
use crate::robot::{Frame, Robot};

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
/// A joint that carries the frame contributes (z × (p − o), z) if it turns and (z, 0) if it slides: see [`column_of`]. The
/// others contribute nothing. With a coupling, J = J_mechanism C.
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
    let tip = chain(robot, now, (frame, body), &mut axis, &mut origin);
    let n = robot.coordinates();
    match robot.coupling() {
        None => {
            for i in 0..robot.bodies() {
                for (k, x) in
                    column(column_of(robot, body, i, (&axis, &origin), &tip), &tip, axes).into_iter().enumerate()
                {
                    if let Some(entry) = out.get_mut(k * n + i) {
                        *entry = x;
                    }
                }
            }
        }
        Some(coupling) => {
            out.fill(0.0);
            for i in 0..robot.bodies() {
                for (row, x) in
                    out.chunks_exact_mut(n).zip(column(column_of(robot, body, i, (&axis, &origin), &tip), &tip, axes))
                {
                    for (entry, along) in row.iter_mut().zip(coupling.columns()) {
                        *entry = Lanes::<1, FUSED>::splat(along[i]).mul_add(Lanes([x]), Lanes([*entry])).0[0];
                    }
                }
            }
        }
    }
}

/// A column in the axes wanted: linear, then angular components.
#[inline(always)]
fn column<const FUSED: bool>([v, w]: [Column<FUSED>; 2], tip: &Axes<FUSED>, axes: JacobianAxes) -> [f64; 6] {
    let [[x, y, z], [a, b, c]] = match axes {
        JacobianAxes::Base => [three(&v), three(&w)],
        JacobianAxes::Frame => [seen_from(tip, &v), seen_from(tip, &w)],
    };
    [x, y, z, a, b, c]
}

/// The first three rows.
#[inline(always)]
fn three<const FUSED: bool>(v: &Column<FUSED>) -> [f64; 3] {
    let [x, y, z, _] = v.0;
    [x, y, z]
}

/// `Rᵀ v`.
#[inline(always)]
fn seen_from<const FUSED: bool>(axes: &Axes<FUSED>, v: &Column<FUSED>) -> [f64; 3] {
    let v = vector(v);
    [dot(&vector(&axes.x), &v).0[0], dot(&vector(&axes.y), &v).0[0], dot(&vector(&axes.z), &v).0[0]]
}
