//! How far apart two results may be that are equal but for rounding.
//!
//! A torque is a sum of terms that may cancel; its rounding error is a small multiple of the machine epsilon times the sum
//! of the terms' sizes. [`Scale`] bounds those sums from above with a few sizes of the robot and of its motion.

use crate::arms::{Arm, State};
use gravcomp::{Inertia, Joint, Joints};
use proptest::prelude::*;

/// Two computations of one number differ by at most this share of its [`Scale`].
pub const ROUNDING: f64 = 1e-13;

/// A five-point difference is at most this share of the scale times the rate away from the derivative.
pub const DIFFERENCE: f64 = 1e-11;

/// Step of a difference in units of the fastest coordinate: truncation h⁴/30 and rounding ε/h are both below 1e-12.
const STEP: f64 = 1e-3;

#[derive(Clone, Copy, Debug)]
pub struct Scale {
    mass: f64,
    /// Longest path from the base origin along the joints to a mass or the tool; at least 1.
    pub lever: f64,
    inertia: f64,
    /// Largest column sum of |C|, at least 1.
    pub gain: f64,
    acceleration: f64,
    angular: f64,
}

impl Scale {
    pub fn of(arm: &Arm, state: &State) -> Self {
        let (qd, qdd) = (arm.mechanism(&state.qd, false), arm.mechanism(&state.qdd, false));
        let (bodies, base) = (arm.moving().len(), &state.base);
        let turn = base.angular_velocity.norm() + sum(&qd, bodies);
        let angular = base.angular_acceleration.norm() + sum(&qdd, bodies) + turn * turn;
        let lever = reach(arm, &arm.mechanism(&state.q, true));
        Self {
            mass: arm.links.iter().map(|link| link.inertia.mass()).sum(),
            lever,
            inertia: arm.links.iter().map(|link| link.inertia.second_moment().trace()).sum(),
            gain: gain(arm),
            acceleration: base.specific_force.0.norm() + 2.0 * angular * lever,
            angular,
        }
    }

    /// The same robot with more attached to it.
    pub fn with(self, payload: &Inertia) -> Self {
        Self {
            mass: self.mass + payload.mass(),
            lever: self.lever + distance(payload),
            inertia: self.inertia + payload.second_moment().trace(),
            ..self
        }
    }

    /// Of moments (and forces) on the mechanism, of potential energy, of the base wrench.
    pub fn moment(&self) -> f64 {
        self.mass * self.acceleration * self.lever + self.inertia * self.angular
    }

    /// Of efforts at the coordinates.
    pub fn torque(&self) -> f64 {
        self.gain * self.moment()
    }

    /// Of ∂τ/∂q.
    pub fn stiffness(&self) -> f64 {
        self.gain * self.torque()
    }

    /// Of entries of M.
    pub fn mass_matrix(&self) -> f64 {
        self.gain * self.gain * (self.mass * self.lever * self.lever + self.inertia)
    }

    /// Of entries of the Jacobian.
    pub fn jacobian(&self) -> f64 {
        self.gain * self.lever
    }
}

/// Sum of the absolute values of the first `n` numbers.
pub fn sum(x: &Joints, n: usize) -> f64 {
    x.iter().take(n).map(|x| x.abs()).sum()
}

fn gain(arm: &Arm) -> f64 {
    let Some(coupling) = &arm.coupling else { return 1.0 };
    let column = |j: usize| coupling.matrix.iter().map(|row| row[j].abs()).sum::<f64>();
    (0..arm.coordinates()).map(column).fold(1.0, f64::max)
}

fn distance(inertia: &Inertia) -> f64 {
    if inertia.mass() > 0.0 { inertia.first_moment().norm() / inertia.mass() } else { 0.0 }
}

fn reach(arm: &Arm, q: &Joints) -> f64 {
    let ends = |k: usize| {
        arm.links[k].placement.before.translation().norm() + arm.links[k].placement.after.translation().norm()
    };
    let paths: f64 = (0..arm.links.len()).map(ends).sum();
    let slid: f64 = arm
        .moving()
        .iter()
        .zip(q.iter())
        .filter(|(k, _)| arm.links[**k].joint == Joint::Prismatic)
        .map(|(_, q)| q.abs())
        .sum();
    let farthest = arm.links.iter().map(|link| distance(&link.inertia)).fold(0.0, f64::max);
    1.0 + arm.base.translation().norm() + paths + slid + farthest + arm.tool.translation().norm()
}

/// No entry is farther off than `bound`; a NaN is infinitely far.
pub fn close(what: &str, found: &[f64], wanted: &[f64], bound: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(found.len(), wanted.len(), "{}: lengths", what);
    for (i, (a, b)) in found.iter().zip(wanted).enumerate() {
        let off = (a - b).abs();
        prop_assert!(off <= bound, "{what}[{i}]: {a:e} and {b:e} differ by {off:e}, allowed {bound:e}");
    }
    Ok(())
}

/// df/dt at 0 by five points, for an f that changes by its own size when t changes by 1/`rate`.
pub fn derivative<const N: usize>(rate: f64, f: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let h = STEP / rate;
    let [a, b, c, d] = [-2.0 * h, -h, h, 2.0 * h].map(f);
    core::array::from_fn(|i| (a[i] - 8.0 * b[i] + 8.0 * c[i] - d[i]) / (12.0 * h))
}

/// q + t d.
pub fn moved(q: &Joints, t: f64, d: &Joints) -> Joints {
    Joints(core::array::from_fn(|i| q[i] + t * d[i]))
}

/// The direction of coordinate `j` alone.
pub fn unit(j: usize) -> Joints {
    let mut e = Joints::default();
    e[j] = 1.0;
    e
}

/// A run of a property on `cases` random inputs; nothing is written beside the sources.
pub fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}
