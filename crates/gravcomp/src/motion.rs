//! Where the joints are: positions, sines and cosines of all joints, computed once for a whole cycle.

use crate::constants::MAX_JOINTS;
use crate::coupling::Coupling;
use crate::lanes::Lanes;
use crate::robot::Robot;
use crate::trig;

/// Joints whose sines and cosines are computed side by side in a single cycle.
const GROUP: usize = 4;

/// One number per joint of the mechanism (or per coordinate), in as many lanes as there are configurations.
pub(crate) type PerJoint<const W: usize> = [[f64; W]; MAX_JOINTS];

/// Plain numbers, one per joint, as single lanes.
#[inline(always)]
pub(crate) fn single(x: &[f64; MAX_JOINTS]) -> &PerJoint<1> {
    const NONE: &PerJoint<1> = &[[0.0]; MAX_JOINTS];
    x.as_chunks().0.first_chunk().unwrap_or(NONE)
}

/// Σ_j C_ij x_j (+ c₀ᵢ): coordinates, or their rates, as the mechanism's joints see them.
#[inline(always)]
pub(crate) fn to_mechanism<const W: usize, const FUSED: bool>(
    coupling: &Coupling,
    x: &PerJoint<W>,
    offset: Option<&[f64; MAX_JOINTS]>,
) -> PerJoint<W> {
    let mut y = offset.map_or([[0.0; W]; MAX_JOINTS], |offset| offset.map(|c0| [c0; W]));
    for (&x, column) in x.iter().zip(coupling.columns()) {
        for (y, &c) in y.iter_mut().zip(column) {
            *y = Lanes::<W, FUSED>::splat(c).mul_add(Lanes(x), Lanes(*y)).0;
        }
    }
    y
}

/// τ_j = Σ_i C_ij τ_i: the mechanism's efforts as the coordinates feel them, in their place.
#[inline(always)]
pub(crate) fn to_coordinates<const W: usize, const FUSED: bool>(robot: &Robot, effort: &mut PerJoint<W>) {
    let Some(coupling) = robot.coupling() else { return };
    let mut tau = [[0.0; W]; MAX_JOINTS];
    for (tau, column) in tau.iter_mut().zip(coupling.columns()) {
        for (&e, &c) in effort.iter().zip(column).take(robot.bodies()) {
            *tau = Lanes::<W, FUSED>::splat(c).mul_add(Lanes(e), Lanes(*tau)).0;
        }
    }
    *effort = tau;
}

/// Positions q of the mechanism's joints with cosine c and sine s of their turns (1 and 0 where a joint slides).
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointsNow<'q, const W: usize, const FUSED: bool> {
    q: &'q PerJoint<W>,
    pub c: [Lanes<W, FUSED>; MAX_JOINTS],
    pub s: [Lanes<W, FUSED>; MAX_JOINTS],
}

impl<const FUSED: bool> JointsNow<'_, 1, FUSED> {
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
                x.0[l] = turning[k][l] * f64::from_bits(used[k][l] & q[k][l][0].to_bits());
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

impl<'q, const W: usize, const FUSED: bool> JointsNow<'q, W, FUSED> {
    /// The mechanism's positions; the turns are still to come.
    #[inline(always)]
    pub fn at(q: &'q PerJoint<W>) -> Self {
        Self { q, c: [Lanes::ZERO; MAX_JOINTS], s: [Lanes::ZERO; MAX_JOINTS] }
    }

    /// Position of joint i.
    #[inline(always)]
    fn position(&self, i: usize) -> Lanes<W, FUSED> {
        Lanes(self.q[i])
    }

    /// How far the sliding joint i has slid: its position, or NaN where that is not finite (c is 1, or then NaN).
    #[inline(always)]
    pub fn slide(&self, i: usize) -> Lanes<W, FUSED> {
        self.c[i] * self.position(i)
    }

    /// `W` configurations: each joint's sine serves all of them.
    #[inline(always)]
    pub fn turn_many(&mut self, robot: &Robot) {
        let mut reducible = true;
        for i in 0..robot.bodies() {
            let x = Lanes::splat(robot.turning[i]) * self.position(i);
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
            (self.s[i], self.c[i]) = trig::library_sin_cos(Lanes::splat(robot.turning[i]) * self.position(i));
        }
    }
}
