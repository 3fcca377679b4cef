//! Gravity compensation for arms with elastic joints (cables, harmonic drives, long shafts), from motor positions.
//!
//! The motor at θ moves the link at q through a spring (M. Spong 1987), both counted in joint units:
//!
//! > M(q) q̈ + C q̇ + g(q) = K (θ − q),  B θ̈ + K (θ − q) = u.
//!
//! At rest the spring carries the link, K (θ − q) = g(q): the link stands K⁻¹ g(q) away from its motor, and a controller that
//! reads the motor's encoder sees nothing of it. All the laws below aim the motor beyond the goal by as much,
//!
//! > u = K_P (θ_d − θ) − K_D θ̇ + g(at),  θ_d = q_d + K⁻¹ g(q_d),
//!
//! and differ in where they take gravity:
//!
//! | [`Variant`] | at | left at rest | proven stable where |
//! |---|---|---|---|
//! | `Desired` | q_d | nothing | λ(K_E) > α; P. Tomei 1991 |
//! | `Motor` | θ | an error: the sag counts twice | λ(K_E) > α, about a pose that is not q_d |
//! | `Biased` | θ̃ = θ − K⁻¹ g(q_d) | nothing | λ(K_E) > α; A. De Luca, B. Siciliano, L. Zollo 2005 |
//! | `QuasiStatic` | q̄ with q̄ = θ − K⁻¹ g(q̄) | nothing | λ(K) > α, any K_P > 0; Ch. Ott and others 2004 |
//! | `Link` | q, measured | nothing | not proven; q_d is the one pose at rest where λ(K) > α |
//!
//! with λ the least eigenvalue, α the largest |∂g/∂q| (spectral norm, over all poses and gravities that occur) and
//! K_E = [[K, −K], [−K, K + K_P]].
//!
//! # Why
//! With E(q, θ) = ½ (q − θ)ᵀ K (q − θ) + U(q) + ½ (θ − θ_d)ᵀ K_P (θ − θ_d) less the work of g(at), the arm's energy and E only
//! fall: by K_D. `Desired` subtracts θᵀ g(q_d), `Motor` U(θ), `Biased` U(θ̃); the Hessian of E is then K_E plus blocks no
//! larger than α, hence E is convex where λ(K_E) > α, and has one minimum. `QuasiStatic` subtracts the least that spring and
//! weight can hold at θ, min over q of ½ (q − θ)ᵀ K (q − θ) + U(q), whose slope is g(q̄): what is left is never negative, and zero
//! at q = q̄(θ), θ = θ_d alone. No term competes with K_P, which is why this law needs the least of it.
//!
//! # The fixed point
//! q ↦ θ − K⁻¹ g(q) shrinks distances by ρ = |K⁻¹| α < 1: after k steps from q₀ the distance to q̄ is at most
//! |q_{k+1} − q_k| / (1 − ρ) ≤ ρᵏ/(1 − ρ) |q₁ − q₀|. Each step costs one gravity torque; q₀ = θ − (the sag found last), so that a
//! slow arm needs one or two. Angles and shifts are measured alike, in SI units.
//!
//! # References
//! P. Tomei, "A simple PD controller for robots with elastic joints", IEEE Trans. Automatic Control 36(10), 1991.
//! A. De Luca, B. Siciliano, L. Zollo, "PD control with on-line gravity compensation for robots with elastic joints: theory and
//! experiments", Automatica 41(10), 2005. Ch. Ott, A. Albu-Schäffer, A. Kugi, S. Stramigioli, G. Hirzinger, "A passivity based
//! Cartesian impedance controller for flexible joint robots, part I: torque feedback and gravity compensation", ICRA 2004.

mod bound;
mod stiffness;

pub use bound::{Field, stiffness_bound};
pub use stiffness::{Stiffness, StiffnessError};

use crate::constants::MAX_JOINTS;
use crate::robot::Joints;
use nalgebra::ComplexField;

/// Most steps of the fixed point in one cycle.
pub const MOST_ITERATIONS: u32 = 64;

/// Where gravity is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variant {
    /// At the goal: constant while the goal is.
    Desired,
    /// At the motor's position, as if the joints were rigid.
    Motor,
    /// At the motor's position less the sag at the goal.
    Biased,
    /// Where the link would hang at rest with the motor where it is.
    QuasiStatic,
    /// At the link's own position, where a sensor measures it.
    Link,
}

/// Declarations of [`ElasticGravity`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Where gravity is taken.
    pub variant: Variant,
    /// ρ per m/s² of gravity: |K⁻¹| times the largest |∂g/∂q| in a field of 1 m/s². Infinite where nothing is known: error
    /// bounds are infinite then, and nothing else changes.
    pub contraction: f64,
    /// Most steps of the fixed point in a cycle; taken as 1 to [`MOST_ITERATIONS`].
    pub iterations: u32,
    /// The fixed point is good enough when it is known to be this close, rad (m).
    pub tolerance: f64,
}

/// Gravity compensation of one arm: its springs, where it takes gravity, and the sag it found last.
///
/// Total and without heap. NaN in, NaN out, for that cycle alone: a sag that is no number is not kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElasticGravity {
    stiffness: Stiffness,
    settings: Settings,
    sag: Joints,
}

/// What a cycle found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensation {
    /// g(at): the efforts to add to the motors' PD.
    pub torque: Joints,
    /// θ_d: where the motors belong for the links to hang at the goal.
    pub theta_d: Joints,
    /// The position whose gravity is compensated.
    pub at: Joints,
    /// Steps of the fixed point; 0 where the variant has none.
    pub iterations: u32,
    /// `at` is at most this far from the fixed point (rad, m; Euclidean); 0 where the variant has none.
    pub error: f64,
}

/// The links at rest on their springs, approximately.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hanging {
    /// Position of the links.
    pub q: Joints,
    /// g(q).
    pub torque: Joints,
    /// K⁻¹ g(q).
    pub sag: Joints,
    /// Steps taken.
    pub iterations: u32,
    /// Bound on the distance of `q` from the fixed point (rad, m; Euclidean).
    pub error: f64,
}

impl ElasticGravity {
    /// Springs and declarations, and no sag yet.
    #[must_use]
    pub const fn new(stiffness: Stiffness, settings: Settings) -> Self {
        Self { stiffness, settings, sag: Joints([0.0; MAX_JOINTS]) }
    }

    /// The springs.
    #[must_use]
    pub const fn stiffness(&self) -> &Stiffness {
        &self.stiffness
    }

    /// What was declared.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Forgets the sag found last.
    pub fn reset(&mut self) {
        self.sag = Joints::default();
    }

    /// θ_d = q_d + K⁻¹ g(q_d), with `hold` for g.
    #[inline]
    #[must_use]
    pub fn theta_desired(&self, hold: impl Fn(&Joints) -> Joints, q_d: &Joints) -> Joints {
        plus(q_d, &self.stiffness.sag(&hold(q_d)))
    }

    /// One cycle with the motors at `theta` and the goal at `q_d`; `q`, the links, is read by [`Variant::Link`] alone.
    ///
    /// `hold` gives the efforts that hold the arm still at a position (N·m, N): gravity as it is now, and whatever else the
    /// base's motion adds. `field` is the size of that gravity, m/s², by which error bounds scale.
    #[inline]
    pub fn step(
        &mut self,
        hold: impl Fn(&Joints) -> Joints,
        field: f64,
        theta: &Joints,
        q_d: &Joints,
        q: &Joints,
    ) -> Compensation {
        let desired = hold(q_d);
        let sag = self.stiffness.sag(&desired);
        let theta_d = plus(q_d, &sag);
        let at = match self.settings.variant {
            Variant::Desired => return Compensation { torque: desired, theta_d, at: *q_d, iterations: 0, error: 0.0 },
            Variant::QuasiStatic => return self.quasi_static(hold, field, theta, theta_d),
            Variant::Motor => *theta,
            Variant::Biased => minus(theta, &sag),
            Variant::Link => *q,
        };
        Compensation { torque: hold(&at), theta_d, at, iterations: 0, error: 0.0 }
    }

    #[inline]
    fn quasi_static(
        &mut self,
        hold: impl Fn(&Joints) -> Joints,
        field: f64,
        theta: &Joints,
        theta_d: Joints,
    ) -> Compensation {
        let Hanging { q: at, torque, iterations, error, .. } = self.hang(hold, field, theta);
        Compensation { torque, theta_d, at, iterations, error }
    }

    /// As [`Self::hanging`], and the next fixed point starts from what it found.
    #[inline]
    pub fn hang(&mut self, hold: impl Fn(&Joints) -> Joints, field: f64, theta: &Joints) -> Hanging {
        let found = self.hanging(hold, field, theta);
        if found.sag.iter().copied().all(f64::is_finite) {
            self.sag = found.sag;
        }
        found
    }

    /// Where the links hang at rest with the motors at `theta`: the fixed point, from the sag found last.
    ///
    /// Stops when it is within the tolerance, when steps no longer shrink (rounding, or springs too soft), or at the most
    /// steps declared. `hold` and `field` as in [`Self::step`].
    #[inline]
    #[must_use]
    pub fn hanging(&self, hold: impl Fn(&Joints) -> Joints, field: f64, theta: &Joints) -> Hanging {
        let rho = self.settings.contraction * field;
        let most = self.settings.iterations.min(MOST_ITERATIONS);
        let (mut q, mut before, mut iterations) = (minus(theta, &self.sag), f64::INFINITY, 1);
        loop {
            let torque = hold(&q);
            let sag = self.stiffness.sag(&torque);
            let next = minus(theta, &sag);
            let moved = distance(&next, &q, self.stiffness.joints());
            let error = within(moved, rho);
            let shrinks = moved < before;
            if error <= self.settings.tolerance || !shrinks || iterations >= most {
                return Hanging { q, torque, sag, iterations, error };
            }
            (q, before, iterations) = (next, moved, iterations + 1);
        }
    }
}

/// |q_k − q̄| ≤ |q_{k+1} − q_k| / (1 − ρ); nothing is known where the map need not shrink.
fn within(moved: f64, rho: f64) -> f64 {
    if rho < 1.0 || moved.is_nan() { moved / (1.0 - rho) } else { f64::INFINITY }
}

#[inline(always)]
fn plus(a: &Joints, b: &Joints) -> Joints {
    Joints(core::array::from_fn(|i| a[i] + b[i]))
}

#[inline(always)]
fn minus(a: &Joints, b: &Joints) -> Joints {
    Joints(core::array::from_fn(|i| a[i] - b[i]))
}

/// Euclidean, over the first `n`.
#[inline(always)]
fn distance(a: &Joints, b: &Joints, n: usize) -> f64 {
    let squares = a.iter().zip(b.iter()).take(n).map(|(a, b)| (a - b) * (a - b));
    ComplexField::sqrt(squares.sum::<f64>())
}
