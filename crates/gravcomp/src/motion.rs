//! Where the joints are: positions, sines and cosines of all joints, computed once for a whole cycle.

use crate::constants::MAX_JOINTS;
use crate::lanes::Lanes;
use crate::robot::{Joints, Robot};
use crate::trig;

/// Joints whose sines and cosines are computed side by side in a single cycle.
const GROUP: usize = 4;

/// One number per joint of the mechanism (or per coordinate).
pub(crate) type PerJoint<const W: usize, const FUSED: bool> = [Lanes<W, FUSED>; MAX_JOINTS];

/// Positions q of the mechanism's joints with cosine c and sine s of their turns (1 and 0 where a joint slides).
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointsNow<const W: usize, const FUSED: bool> {
    pub q: PerJoint<W, FUSED>,
    pub c: PerJoint<W, FUSED>,
    pub s: PerJoint<W, FUSED>,
}

/// Σ_j C_ij x_j (+ c₀ᵢ): coordinates, or their rates, as the mechanism's joints see them.
#[inline(always)]
pub(crate) fn to_mechanism<const W: usize, const FUSED: bool>(
    robot: &Robot,
    x: PerJoint<W, FUSED>,
    with_offset: bool,
) -> PerJoint<W, FUSED> {
    let Some(coupling) = robot.coupling() else { return x };
    let mut y = [Lanes::ZERO; MAX_JOINTS];
    if with_offset {
        y = coupling.offset().map(Lanes::splat);
    }
    for (x, column) in x.iter().zip(coupling.columns()) {
        for (y, &c) in y.iter_mut().zip(column) {
            *y = Lanes::splat(c).mul_add(*x, *y);
        }
    }
    y
}

/// τ_j = Σ_i C_ij τ_i: the mechanism's efforts as the coordinates feel them.
#[inline(always)]
pub(crate) fn to_coordinates<const W: usize, const FUSED: bool>(
    robot: &Robot,
    effort: PerJoint<W, FUSED>,
) -> PerJoint<W, FUSED> {
    let Some(coupling) = robot.coupling() else { return effort };
    let mut tau = [Lanes::ZERO; MAX_JOINTS];
    for (tau, column) in tau.iter_mut().zip(coupling.columns()) {
        for (&e, &c) in effort.iter().zip(column).take(robot.bodies()) {
            *tau = Lanes::splat(c).mul_add(e, *tau);
        }
    }
    tau
}

impl<const FUSED: bool> JointsNow<1, FUSED> {
    /// One configuration: the joints themselves fill the lanes of the sine.
    #[inline(always)]
    pub fn turn_single(&mut self, robot: &Robot) {
        let (c, s) = (self.c.as_chunks_mut::<GROUP>().0, self.s.as_chunks_mut::<GROUP>().0);
        let (q, turning) = (self.q.as_chunks::<GROUP>().0, robot.turning.as_chunks::<GROUP>().0);
        let used = robot.used.as_chunks::<GROUP>().0;
        let mut reducible = true;
        for k in 0..robot.bodies().div_ceil(GROUP) {
            let mut x = Lanes::<GROUP, FUSED>([0.0; GROUP]);
            for l in 0..GROUP {
                // Lanes beyond the last joint hold whatever the caller left there.
                x.0[l] = turning[k][l] * f64::from_bits(used[k][l] & q[k][l].0[0].to_bits());
            }
            let (sine, cosine) = trig::sin_cos(x);
            for l in 0..GROUP {
                s[k][l] = Lanes([sine.0[l]]);
                c[k][l] = Lanes([cosine.0[l]]);
            }
            reducible &= trig::reducible(x);
        }
        if !reducible {
            self.turn_by_library(robot);
        }
    }
}

impl<const W: usize, const FUSED: bool> JointsNow<W, FUSED> {
    /// The mechanism's positions for coordinates q; the turns are still to come.
    #[inline(always)]
    pub fn at(robot: &Robot, q: PerJoint<W, FUSED>) -> Self {
        Self { q: to_mechanism(robot, q, true), c: [Lanes::ZERO; MAX_JOINTS], s: [Lanes::ZERO; MAX_JOINTS] }
    }

    /// `W` configurations: each joint's sine serves all of them.
    #[inline(always)]
    pub fn turn_many(&mut self, robot: &Robot) {
        let mut reducible = true;
        for i in 0..robot.bodies() {
            let x = Lanes::splat(robot.turning[i]) * self.q[i];
            (self.s[i], self.c[i]) = trig::sin_cos(x);
            reducible &= trig::reducible(x);
        }
        if !reducible {
            self.turn_by_library(robot);
        }
    }

    /// The turns again, where an angle was too large for the polynomial or is no number.
    #[cold]
    #[inline(never)]
    fn turn_by_library(&mut self, robot: &Robot) {
        for i in 0..robot.bodies() {
            (self.s[i], self.c[i]) = trig::library_sin_cos(Lanes::splat(robot.turning[i]) * self.q[i]);
        }
    }

    /// How far joint i has slid along its axis; 0 where it turns.
    #[inline(always)]
    pub fn slide(&self, robot: &Robot, i: usize) -> Lanes<W, FUSED> {
        Lanes::splat(1.0 - robot.turning[i]) * self.q[i]
    }
}

/// Plain numbers as single lanes.
#[inline(always)]
pub(crate) fn lanes<const FUSED: bool>(x: &Joints) -> PerJoint<1, FUSED> {
    x.0.map(|x| Lanes([x]))
}

/// Single lanes as plain numbers.
#[inline(always)]
pub(crate) fn numbers<const FUSED: bool>(x: &PerJoint<1, FUSED>) -> Joints {
    Joints(x.map(|x| x.0[0]))
}
