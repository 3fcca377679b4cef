//! The control laws: PD, PD with static or dynamic gravity, PD with the base's full motion, and gravity alone.
//!
//! > τ = Kp (q_r − q) + Kd (q̇_r − q̇) + τ_g(q; base) + τ_e(q, q̇)
//!
//! [`Controller::step`] is called once per cycle. It never fails: whatever comes in, every torque is finite, within its limit,
//! and no further from the one before than its rate allows; every departure from the law is an [`Event`].
//!
//! # A cycle
//! | step | what it does |
//! |---|---|
//! | base | the last good motion of the base where this cycle has none |
//! | encoders | unwrap, refuse what is missing or jumps, q = C m + c₀, rates given or by first difference |
//! | target | the last good one, moved to within the joint limits |
//! | state | see below |
//! | reference | q_r = q₀ + s (q_d − q₀), from the pose q₀ of the moment of arming |
//! | law | the terms above; a term that overflows stays at its last value |
//! | limits | torque; then the ramp τ = (1 − s) τ₀ + s τ_law from the torque τ₀ of the moment; then rate |
//!
//! # Sides
//! Positions are measured and gains act at [`Settings::feedback`], torques go to [`Settings::output`]: the joints or the motors,
//! q = C m + c₀ and τ_m = Cᵀ τ_q exactly. Targets and joint limits are those of the coordinates, always.
//!
//! # Elastic joints
//! With [`Controller::with_elastic`] the encoders are those of the motors, θ: where gains act at the joints, in their units.
//! PD aims at θ_d = q_d + K⁻¹ τ_g(q_d), so that the links come to the goal, and gravity is taken where [`crate::elastic`] says. A
//! fault and the law without a goal hold the links where they hang; a missing link position is a missing joint state.
//!
//! # Disturbance elements
//! Laws with a gravity term add the torque τ_e of the elements that they are given ([`crate::disturbance`]), at the pose and
//! rates of the encoders; a fault holds them where it holds gravity, at rest.
//!
//! # States
//! | state | torque | leads to |
//! |---|---|---|
//! | `Disarmed` | none | `Ramping` when arming is asked for, the joint state is good and the base sensor agrees |
//! | `Ramping` | from that of the moment to the law's | `Armed` after [`Settings::ramp_s`] |
//! | `Armed` | the law's | `Disarmed` when asked for |
//! | `Fault` | that of [`OnFault`] | `Ramping` by [`Controller::acknowledge`] and a good joint state, by nothing else |
//!
//! Without a good joint state the last good pose stands in: gravity goes on there, the PD terms are frozen, as stale data tell
//! them nothing. After [`Settings::hold_s`] of it the fault is latched. Static gravity is that of the moment of arming.

mod arming;
mod beside;
mod builds;
mod encoder;
mod feel;
mod law;
mod limits;
mod places;
mod settings;
mod springs;
mod status;
mod target;

pub use crate::error::SettingsError;
pub use arming::State;
#[cfg(target_arch = "x86_64")]
pub use builds::avx2;
pub use builds::{Kernels, portable};
pub use law::Law;
pub use settings::{OnFault, Settings, Side};
pub use status::{Counters, Event, Events, Status};

use crate::base::BaseMotion;
use crate::disturbance::Disturbances;
use crate::robot::{Joints, Robot};
use arming::{Arming, Moment};
use encoder::Encoders;
use feel::{Feel, Weight};
use limits::Limits;
use places::{Mask, Places, all, copy, places};
use springs::Springs;
use status::Watch;
use target::Targets;

/// What comes in with a cycle; anything may be NaN.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// What the encoders read, at the side of [`Settings::feedback`]: rad or m.
    pub q: &'a Joints,
    /// Their rates, rad/s or m/s; without them, first differences of the positions.
    pub qd: Option<&'a Joints>,
    /// Where the links are, rad or m: for elastic joints whose gravity is taken there, otherwise not read.
    pub q_link: Option<&'a Joints>,
    /// Where the coordinates should be, rad or m.
    pub q_desired: &'a Joints,
    /// How fast they should move, rad/s or m/s.
    pub qd_desired: &'a Joints,
    /// How the base moves; laws without the base's turning take its gravity alone.
    pub base: &'a BaseMotion,
    /// What acts beside the masses, for laws with a gravity term.
    pub disturbances: Option<&'a Disturbances>,
    /// The base sensor lets the arm be armed.
    pub armable: bool,
}

/// What a cycle gives, at the side of [`Settings::output`] but for the pose: N·m or N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct Output {
    /// What the actuators are to exert.
    pub tau: Joints,
    /// Kp (q_r − q) + Kd (q̇_r − q̇), before any limit.
    pub tau_pd: Joints,
    /// τ_g(q; base), before any limit.
    pub tau_gravity: Joints,
    /// τ_e(q, q̇) of the disturbance elements, before any limit.
    pub tau_disturbance: Joints,
    /// The last good pose, at the coordinates (with elastic joints, of the motors): rad or m.
    pub q: Joints,
}

/// A control law with all that it remembers: see [`control`](self).
#[derive(Clone, Debug)]
pub struct Controller {
    settings: Settings,
    kernels: Kernels,
    feel: Feel,
    encoders: Encoders,
    targets: Targets,
    arming: Arming,
    limits: Limits,
    watch: Watch,
    springs: Option<Springs>,
    own: Mask,
    output: Output,
    /// q₀ and τ₀: pose and torque at the last change of state.
    start: Joints,
    from: Joints,
}

impl Controller {
    /// A disarmed controller that computes with these kernels.
    ///
    /// # Errors
    /// Those of [`Settings::checked`].
    pub fn new(settings: Settings, kernels: Kernels) -> Result<Self, SettingsError> {
        let settings = settings.checked()?.padded();
        Ok(Self {
            kernels,
            feel: Feel::new(),
            encoders: Encoders::new(&settings),
            targets: Targets::new(&settings),
            arming: Arming::new(&settings),
            limits: Limits::new(&settings),
            watch: Watch::default(),
            springs: None,
            own: Mask::of(settings.coordinates),
            output: Output::default(),
            start: Joints::default(),
            from: Joints::default(),
            settings,
        })
    }

    /// One control cycle of `robot`.
    ///
    /// Never fails, whatever comes in.
    #[inline]
    pub fn step(&mut self, robot: &Robot, inputs: &Inputs<'_>) -> &Output {
        (self.kernels.cycle)(self, robot, inputs);
        &self.output
    }

    /// A cycle of `N` places, those of the arm and some that hold zeros; `SPRINGS`, of elastic joints.
    #[inline(always)]
    fn cycle<const N: usize, const SPRINGS: bool>(&mut self, inputs: &Inputs<'_>, weight: &impl Weight) {
        self.watch.begin();
        self.feel.follow(inputs.base, &mut self.watch);
        let fresh = self.measure::<N, SPRINGS>(inputs);
        if self.settings.law.has_pd() {
            let (q, qd) = (self.own.own::<N>(inputs.q_desired), self.own.own::<N>(inputs.qd_desired));
            self.targets.follow(&q, &qd, &mut self.watch);
        }
        self.change_state(fresh, inputs.armable, weight);
        let (s, ds) = self.arming.share();
        // θ_d comes with gravity; without it nothing of PD waits for gravity.
        if SPRINGS {
            self.gravity::<N, SPRINGS>(weight);
            self.pd::<N, SPRINGS>(fresh, s, ds);
        } else {
            self.pd::<N, SPRINGS>(fresh, s, ds);
            self.gravity::<N, SPRINGS>(weight);
        }
        if inputs.disturbances.is_some() {
            self.beside::<N>(fresh, weight);
        } else {
            copy(&[0.0; N], &mut self.output.tau_disturbance);
        }
        let law = self.law::<N>();
        self.limits.drive(&mut self.output.tau, &self.from, s, &law, &mut self.watch);
        self.watch.end();
    }

    /// Asks for the arm to be driven: on a ramp, from the next cycle on that has a good joint state.
    pub const fn arm(&mut self) {
        self.arming.want(true);
    }

    /// Asks for no torque, on a ramp. A latched fault stays latched, without torque.
    pub fn disarm(&mut self) {
        self.arming.want(false);
    }

    /// Somebody has looked at it: [`Status::since`] begins anew, and the next cycle leaves a latched fault, on a ramp, if it
    /// has a good joint state.
    pub fn acknowledge(&mut self) {
        self.arming.acknowledge();
        self.watch.acknowledge();
    }

    /// So many cycles passed without a step: the last good pose is that much older.
    pub const fn skip(&mut self, cycles: u32) {
        self.encoders.pass(cycles);
    }

    /// What the last step gave; before the first one, zeros.
    #[must_use]
    pub const fn output(&self) -> &Output {
        &self.output
    }

    /// Whether the arm is driven.
    #[must_use]
    pub const fn state(&self) -> State {
        self.arming.state()
    }

    /// What happened in the last step, and since the last acknowledgement.
    #[must_use]
    pub const fn status(&self) -> Status {
        self.watch.status
    }

    /// How often what happened, since the start.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.watch.counters
    }

    /// What was declared.
    #[must_use]
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// q = C m + c₀ of a good reading; false where the last good pose has to stand in.
    #[inline(always)]
    fn measure<const N: usize, const SPRINGS: bool>(&mut self, inputs: &Inputs<'_>) -> bool {
        let raw = self.own.own::<N>(inputs.q);
        let rates = inputs.qd.map(|qd| self.own.own::<N>(qd));
        if SPRINGS
            && let Some(springs) = &mut self.springs
            && !springs.see::<N>(inputs.q_link.map(|q| self.own.own(q)))
        {
            return self.encoders.miss(&mut self.watch);
        }
        let fresh = self.encoders.read(&raw, rates.as_ref(), &mut self.watch);
        if fresh {
            let position = places(self.encoders.position());
            let q = match &self.settings.transmission {
                Some(transmission) if self.settings.feedback == Side::Motor => {
                    transmission.joint_positions_of(position)
                }
                _ => *position,
            };
            copy::<N>(&q, &mut self.output.q);
            self.watch.note(!self.targets.contain(&q), Event::JointLimit);
        }
        fresh
    }

    /// The state of this cycle; a change starts from the pose and torque of now.
    #[inline(never)]
    fn change_state(&mut self, fresh: bool, armable: bool, weight: &impl Weight) {
        let was_driven = self.state().is_driven();
        let moment = Moment { fresh, missed: self.encoders.missed(), armable };
        if self.arming.advance(moment, &mut self.watch) {
            (self.start, self.from) = (self.output.q, self.output.tau);
            if self.state().is_driven() && !was_driven {
                self.feel.arm();
                self.stay(weight);
            }
        }
    }

    /// τ_pd = Kp (x_r − x) + Kd (ẋ_r − ẋ), x the joints or the motors; frozen off stale data, none where nothing drives.
    #[inline(always)]
    fn pd<const N: usize, const SPRINGS: bool>(&mut self, fresh: bool, s: f64, ds: f64) {
        let mut tau = [0.0; N];
        if self.settings.law.has_pd() && self.state().is_driven() {
            if !fresh {
                return;
            }
            let (q_r, qd_r) = self.reference::<N, SPRINGS>(s, ds);
            let (kp, kd) = (&self.settings.kp, &self.settings.kd);
            let (x, xd) = (self.encoders.position(), self.encoders.rate());
            for j in 0..N {
                tau[j] = kp[j] * (q_r[j] - x[j]) + kd[j] * (qd_r[j] - xd[j]);
            }
            tau = self.at_output(&tau, self.settings.feedback);
        }
        take(&tau, &mut self.output.tau_pd, &mut self.watch);
    }

    /// q_r = q₀ + s (q_d − q₀), q̇_r = s q̇_d + ds/dt (q_d − q₀), where the encoders are; with elastic joints θ_d for q_d.
    #[inline(always)]
    fn reference<const N: usize, const SPRINGS: bool>(&self, s: f64, ds: f64) -> (Places<N>, Places<N>) {
        let target = self.targets.last();
        let goal = if SPRINGS { self.aim() } else { &target.q };
        let (mut q_r, mut qd_r) = (*places(goal), *places(&target.qd));
        if s < 1.0 {
            let per_second = ds * self.settings.rate_hz;
            for j in 0..N {
                let way = q_r[j] - self.start[j];
                q_r[j] = self.start[j] + s * way;
                qd_r[j] = s * target.qd[j] + per_second * way;
            }
        }
        match &self.settings.transmission {
            Some(transmission) if self.settings.feedback == Side::Motor => {
                (transmission.motor_positions_of(&q_r), transmission.motor_rates_of(&qd_r))
            }
            _ => (q_r, qd_r),
        }
    }

    /// τ_g at the last good pose where the law has it or the fault wants it, none before there is a pose.
    #[inline(always)]
    fn gravity<const N: usize, const SPRINGS: bool>(&mut self, weight: &impl Weight) {
        let law = self.settings.law;
        let mut tau = [0.0; N];
        if self.holds() {
            let held =
                if SPRINGS { self.weight_on_springs(weight) } else { self.feel.hold(law, weight, &self.output.q) };
            tau = self.at_output(places(&held), Side::Joint);
        }
        take(&tau, &mut self.output.tau_gravity, &mut self.watch);
    }

    /// What the state wants to exert.
    #[inline(always)]
    fn law<const N: usize>(&self) -> Places<N> {
        if !(self.state().is_driven() || self.holds_after_fault()) {
            return [0.0; N];
        }
        core::array::from_fn(|j| self.output.tau_pd[j] + self.output.tau_gravity[j] + self.output.tau_disturbance[j])
    }

    /// Gravity, and what acts beside it, is to be held at a pose that is known.
    fn holds(&self) -> bool {
        self.encoders.is_known() && (self.settings.law.has_gravity() || self.holds_after_fault())
    }

    fn holds_after_fault(&self) -> bool {
        self.state() == State::Fault && self.arming.is_wanted() && self.settings.on_fault == OnFault::Gravity
    }

    /// τ_m = Cᵀ τ_q, or its inverse, where torques go to the other side than the one they were computed at.
    #[inline(always)]
    fn at_output<const N: usize>(&self, tau: &Places<N>, side: Side) -> Places<N> {
        match (&self.settings.transmission, side, self.settings.output) {
            (Some(transmission), Side::Joint, Side::Motor) => transmission.motor_efforts_of(tau),
            (Some(transmission), Side::Motor, Side::Joint) => transmission.joint_efforts_of(tau),
            _ => *tau,
        }
    }
}

/// A term of the law in place of its last value, if all its numbers are finite.
#[inline(always)]
fn take<const N: usize>(term: &Places<N>, last: &mut Joints, watch: &mut Watch) {
    if all::<N>(|j| term[j].is_finite()) {
        copy(term, last);
    } else {
        watch.note(true, Event::Overflow);
    }
}
