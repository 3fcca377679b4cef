//! Where the joints are: sines, cosines and displacements of all joints, computed once for a whole cycle.

use crate::constants::MAX_JOINTS;
use crate::lanes::Lanes;
use crate::robot::{Joints, Robot};
use crate::trig::sin_cos;

/// Joints whose sines and cosines are computed side by side in a single cycle.
const GROUP: usize = 4;

/// The joints' own motions: a turn about z by an angle with cosine `c` and sine `s`, and a shift along z by `d`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointsNow<const W: usize, const FUSED: bool> {
    pub c: [Lanes<W, FUSED>; MAX_JOINTS],
    pub s: [Lanes<W, FUSED>; MAX_JOINTS],
    pub d: [Lanes<W, FUSED>; MAX_JOINTS],
}

/// Σ_j C_ij x_j (+ c₀ᵢ): coordinates, or their rates, as the mechanism's joints see them.
#[inline(always)]
pub(crate) fn to_mechanism<const W: usize, const FUSED: bool>(
    robot: &Robot,
    x: &[Lanes<W, FUSED>; MAX_JOINTS],
    with_offset: bool,
) -> [Lanes<W, FUSED>; MAX_JOINTS] {
    let Some(coupling) = robot.coupling() else { return *x };
    let mut y = [Lanes::ZERO; MAX_JOINTS];
    if with_offset {
        y = coupling.offset().map(Lanes::splat);
    }
    for j in 0..coupling.coordinates() {
        for (y, &c) in y.iter_mut().zip(coupling.column(j)) {
            *y = Lanes::splat(c).mul_add(x[j], *y);
        }
    }
    y
}

/// τ_j = Σ_i C_ij τ_i: the mechanism's efforts as the coordinates feel them.
#[inline(always)]
pub(crate) fn to_coordinates<const W: usize, const FUSED: bool>(
    robot: &Robot,
    effort: &[Lanes<W, FUSED>; MAX_JOINTS],
) -> [Lanes<W, FUSED>; MAX_JOINTS] {
    let Some(coupling) = robot.coupling() else { return *effort };
    let mut tau = [Lanes::ZERO; MAX_JOINTS];
    for j in 0..coupling.coordinates() {
        for (&e, &c) in effort.iter().zip(coupling.column(j)).take(robot.bodies()) {
            tau[j] = Lanes::splat(c).mul_add(e, tau[j]);
        }
    }
    tau
}

impl<const FUSED: bool> JointsNow<1, FUSED> {
    /// One configuration: the joints themselves fill the lanes of the sine.
    #[inline(always)]
    pub fn single(robot: &Robot, q: &Joints) -> Self {
        let q = to_mechanism(robot, &lanes::<FUSED>(q), true);
        let mut now = Self { c: [Lanes::ZERO; MAX_JOINTS], s: [Lanes::ZERO; MAX_JOINTS], d: [Lanes::ZERO; MAX_JOINTS] };
        let mut angle = [0.0; MAX_JOINTS];
        for i in 0..robot.bodies() {
            let turning = robot.loads[i].turning;
            angle[i] = turning * q[i].0[0];
            now.d[i] = Lanes([(1.0 - turning) * q[i].0[0]]);
        }
        for first in (0..robot.bodies()).step_by(GROUP) {
            let x = core::array::from_fn(|l| angle[first + l]);
            let (s, c) = sin_cos::<GROUP, FUSED>(Lanes(x));
            for l in 0..GROUP {
                now.s[first + l] = Lanes([s.0[l]]);
                now.c[first + l] = Lanes([c.0[l]]);
            }
        }
        now
    }
}

impl<const W: usize, const FUSED: bool> JointsNow<W, FUSED> {
    /// `W` configurations: each joint's sine serves all of them.
    #[inline(always)]
    pub fn many(robot: &Robot, q: &[Lanes<W, FUSED>; MAX_JOINTS]) -> Self {
        let q = to_mechanism(robot, q, true);
        let mut now = Self { c: [Lanes::ZERO; MAX_JOINTS], s: [Lanes::ZERO; MAX_JOINTS], d: [Lanes::ZERO; MAX_JOINTS] };
        for i in 0..robot.bodies() {
            let turning = Lanes::splat(robot.loads[i].turning);
            (now.s[i], now.c[i]) = sin_cos(turning * q[i]);
            now.d[i] = (Lanes::splat(1.0) - turning) * q[i];
        }
        now
    }
}

/// Plain numbers as single lanes.
#[inline(always)]
pub(crate) fn lanes<const FUSED: bool>(x: &Joints) -> [Lanes<1, FUSED>; MAX_JOINTS] {
    x.0.map(|x| Lanes([x]))
}

/// Single lanes as plain numbers.
#[inline(always)]
pub(crate) fn numbers<const FUSED: bool>(x: &[Lanes<1, FUSED>; MAX_JOINTS]) -> Joints {
    Joints(x.map(|x| x.0[0]))
}
