//! The geometric Jacobian: how a frame moves when the coordinates do.

use crate::constants::MAX_JOINTS;
use crate::kinematics::{Axes, Chain, Column, vector};
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
/// A joint that carries the frame contributes (z × (p − o), z) if it turns and (z, 0) if it slides: see [`Chain::column`]. The
/// others contribute nothing. With a coupling, J = J_mechanism C.
#[inline(always)]
pub(crate) fn jacobian<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    frame: &Frame,
    axes: JacobianAxes,
    out: &mut [f64],
) {
    let chain = Chain::<MAX_JOINTS, FUSED>::to(robot, now, frame);
    let n = robot.coordinates();
    match robot.coupling() {
        None => {
            for i in 0..robot.bodies() {
                for (k, x) in column(&chain, robot, i, axes).into_iter().enumerate() {
                    if let Some(entry) = out.get_mut(k * n + i) {
                        *entry = x;
                    }
                }
            }
        }
        Some(coupling) => {
            out.fill(0.0);
            for i in 0..robot.bodies() {
                for (row, x) in out.chunks_exact_mut(n).zip(column(&chain, robot, i, axes)) {
                    for (entry, along) in row.iter_mut().zip(coupling.columns()) {
                        *entry = Lanes::<1, FUSED>::splat(along[i]).mul_add(Lanes([x]), Lanes([*entry])).0[0];
                    }
                }
            }
        }
    }
}

/// The column of joint i of the mechanism: linear, then angular components.
#[inline(always)]
fn column<const FUSED: bool>(
    chain: &Chain<MAX_JOINTS, FUSED>,
    robot: &Robot,
    i: usize,
    axes: JacobianAxes,
) -> [f64; 6] {
    let [linear, angular] = chain.column(robot, i);
    let [[x, y, z], [u, v, w]] = match axes {
        JacobianAxes::Base => [three(&linear), three(&angular)],
        JacobianAxes::Frame => [seen_from(&chain.tip, &linear), seen_from(&chain.tip, &angular)],
    };
    [x, y, z, u, v, w]
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
