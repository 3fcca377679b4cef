//! Resolved-rate motion: the joint rates with which a tool moves as it should, bounded wherever the arm is.
//!
//! > q̇ = J⁺ ν  (D. Whitney, "Resolved motion rate control of manipulators and human prostheses", 1969)
//!
//! [`Goal::Move`] takes a twist, [`Goal::Reach`] a target that moves (closed loop, ν = ν_target + K e with the
//! orientation error e by logarithm). Either never fails: whatever comes in, the rates are finite and within their limits, and
//! every departure from J q̇ = ν is an [`Event`], but for that of [`Damping::Constant`], which is everywhere.
//!
//! # A step
//! | part | what it does |
//! |---|---|
//! | kinematics | one sweep gives the frame and its Jacobian |
//! | task | the rows to be moved, in units of a characteristic length; off ν goes what the moving base does |
//! | inverse | damped near singularities, σ tracked: see [`Damping`] |
//! | null space | what the joints wish, without moving the task |
//! | limits | slowed down as a whole to within limits of rate and position |
//! | ramp | straight from the last rates to these, within acceleration and jerk |
//!
//! Limits of position come before those of rate, these before acceleration, and that before jerk.

mod bounded;
mod closed_loop;
mod factor;
mod inverse;
mod limits;
mod pose;
mod selective;
mod sensed;
mod settings;
mod solver;
mod status;
mod task;

pub use crate::error::SettingsError;
pub use closed_loop::TARGET;
pub use sensed::SensedBase;
pub use settings::{Damping, NullSpace, Priority, Settings, Task};
pub use status::{AtLimits, Counters, Event, Events, Limit, Status};

use crate::box_qp::Active;
use crate::constants::MAX_JOINTS;
use crate::kinematics::Axes;
use crate::lanes::{Lanes, keep_lanes};
use crate::robot::{Joints, Robot};
use closed_loop::Away;
use core::hint::black_box;
use factor::ROWS;
use limits::{Bounds, Limited, Ramp};
use nalgebra::Vector3;
use pose::{Pose, reach};
use solver::Solver;
use status::Watch;
use task::{Rows, Shape, Six, Vector};

/// No twist of a tool or a base is larger, m/s or rad/s.
const FASTEST: f64 = 1e6;

/// No point is further away, m, and no joint has turned further, rad.
const FARTHEST: f64 = 1e6;

/// Shortest and longest time step, s.
pub const STEPS: (f64, f64) = (1e-6, 1.0);

/// The trocar is at the tip if it is no further along the shaft, m.
const AT_TIP: f64 = 1e-3;

/// What a step gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Output {
    /// The rates, rad/s or m/s.
    pub qd: Joints,
    /// The smallest singular value of the task's Jacobian.
    pub sigma_min: f64,
    /// λ
    pub damping: f64,
    /// Share of the task that limits of rate and position leave, 0 to 1.
    pub scale: f64,
    /// The joint that leaves the task least, and at which limit it stands.
    pub limiting: Option<(usize, Limit)>,
    /// All joints that stand at limits.
    pub at_limits: AtLimits,
}

/// What the task should do. Twists are motions in the world, in base axes: the linear velocity (m/s) of the frame's origin,
/// then the frame's angular velocity (rad/s), or the linear velocity of the trocar.
#[derive(Clone, Copy, Debug)]
pub enum Goal<'a> {
    /// Move like this.
    Move(&'a [f64; ROWS]),
    /// Reach this, in base axes, that moves like that: by task, a pose as a homogeneous matrix, row by row; a point; a point
    /// and the outward normal of the surface there, against which the pointing axis is laid; the tip's point and the trocar.
    Reach(&'a [f64; TARGET], &'a [f64; ROWS]),
}

/// What comes in with a step; anything may be NaN.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a> {
    /// Where the coordinates are, rad or m.
    pub q: &'a Joints,
    /// What the task should do.
    pub goal: Goal<'a>,
    /// How the base moves in the world, in base axes: linear velocity of its origin, then angular.
    pub base_twist: Option<&'a [f64; ROWS]>,
    /// That comes from a sensor which is not trusted.
    pub base_in_doubt: bool,
    /// Until the next step, s.
    pub dt: f64,
}

/// Resolved-rate motion with all that it remembers: see [`resolved_rate`](self).
#[derive(Clone, Debug)]
pub struct ResolvedRate {
    settings: Settings,
    shape: Shape,
    solver: Solver,
    limited: Limited,
    /// All bits set for each coordinate that there is, none beyond.
    used: [u64; MAX_JOINTS],
    ramp: Ramp,
    trocar: Vector3<f64>,
    base_twist: [f64; ROWS],
    /// Which bounds held the last optimum.
    active: [Active; 2],
    watch: Watch,
    output: Output,
}

impl ResolvedRate {
    /// At rest.
    ///
    /// # Errors
    /// Those of [`Settings::checked`].
    pub fn new(settings: Settings) -> Result<Self, SettingsError> {
        let settings = settings.checked()?.padded();
        let shape = Shape::of(&settings);
        let n = settings.coordinates;
        let there = if n < shape.rows {
            core::array::from_fn(|j| if j < n { 1.0 } else { 0.0 })
        } else {
            shape.absent.map(|absent| 1.0 - absent)
        };
        Ok(Self {
            solver: Solver::new(&settings, there),
            limited: Limited::of(&settings),
            used: core::array::from_fn(|j| if j < n { u64::MAX } else { 0 }),
            ramp: Ramp::default(),
            trocar: settings.remote_centre,
            base_twist: [0.0; ROWS],
            active: [Active::default(); 2],
            watch: Watch::default(),
            output: Output { scale: 1.0, ..Output::default() },
            shape,
            settings,
        })
    }

    /// What the last step gave; before the first one, rest.
    #[must_use]
    pub const fn output(&self) -> &Output {
        &self.output
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

    /// How many rows the task has.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.shape.rows
    }

    /// Somebody has looked at it: [`Status::since`] begins anew.
    pub const fn acknowledge(&mut self) {
        self.watch.acknowledge();
    }

    /// The arm stands still: the next step starts from rest.
    pub fn reset(&mut self) {
        self.ramp.reset();
        self.output.qd = Joints::default();
    }

    /// One step, of a kernel build.
    #[inline(always)]
    pub(crate) fn step<const FUSED: bool>(&mut self, robot: &Robot, inputs: &Inputs<'_>) -> &Output {
        if robot.bodies() <= 8 {
            self.run::<8, FUSED>(robot, inputs);
        } else {
            self.run::<MAX_JOINTS, FUSED>(robot, inputs);
        }
        &self.output
    }

    #[inline(always)]
    fn run<const N: usize, const FUSED: bool>(&mut self, robot: &Robot, inputs: &Inputs<'_>) {
        self.watch.begin();
        let dt = self.time(inputs.dt);
        self.take_base(inputs);
        let q = self.places::<N>(inputs.q);
        let known = q[..N].iter().fold(true, |all, x| all & (x.abs() <= FARTHEST));
        self.watch.note(!known, Event::Absent);
        let mut goal = [0.0; N];
        let mut bounds = Bounds::NONE;
        if known {
            bounds = Bounds::at(&self.settings, self.limited, &q, dt);
            self.take_trocar(&inputs.goal);
            goal = self.rates::<N, FUSED>(robot, &q, &inputs.goal, &bounds, dt);
        } else {
            (self.output.scale, self.output.limiting, self.output.at_limits) = (0.0, None, AtLimits::default());
        }
        let (next, standing) = self.ramp.towards(&goal, &self.settings, self.limited, dt);
        if let Some((joint, limit)) = standing {
            self.stands(joint, limit);
            self.output.limiting = standing;
        }
        self.ramp.go(&next, &bounds.clamped(&next), self.limited, dt);
        self.output.qd = *self.ramp.rates();
        self.watch.end();
    }

    /// Says that a joint stands at a limit.
    #[inline(always)]
    fn stands(&mut self, joint: usize, limit: Limit) {
        self.output.at_limits.insert(joint, limit);
        self.watch.note(true, limit.event());
    }

    /// The coordinates; zeros where there is none.
    #[inline(always)]
    fn places<const N: usize>(&self, q: &Joints) -> Joints {
        let mut places = Joints::default();
        for j in 0..N {
            places[j] = f64::from_bits(q[j].to_bits() & self.used[j]);
        }
        places
    }

    /// The rates within the bounds that the task needs at q, or half a step further on.
    #[inline(always)]
    fn rates<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        q: &Joints,
        goal: &Goal<'_>,
        bounds: &Bounds<N>,
        dt: f64,
    ) -> [f64; N] {
        let (mut q, mut demand, mut rates) = (*q, [Lanes::ZERO; 2], [0.0; N]);
        let passes = if self.settings.midpoint { 2 } else { 1 };
        for pass in 0..passes {
            // Opaque: else what both passes share is fetched before them, the table of a coupling too, which few arms have.
            let (this, robot) = (black_box(&mut *self), black_box(robot));
            if pass > 0 {
                for j in 0..N {
                    q[j] += 0.5 * dt * rates[j];
                }
            }
            let frame = this.settings.frame.as_ref().unwrap_or(robot.tool());
            let (mut axis, mut origin) = ([Vector::<FUSED>::ZERO; N], [Lanes::ZERO; N]);
            let mut tip: Axes<FUSED> = reach(frame, robot, &q, (&mut axis, &mut origin));
            keep_lanes(&mut (&mut axis, &mut origin, &mut tip));
            let tip = &tip;
            let rows = Rows::at(&this.shape, tip, this.trocar());
            let pose = Pose { tip, body: frame.body(), lines: (&axis, &origin), rows: &rows };
            this.watch.note(this.settings.task == Task::RemoteCentre && rows.depth() <= AT_TIP, Event::Centre);
            if pass == 0 {
                demand = this.demand(goal, tip, &rows, dt);
            }
            let columns = pose.columns(robot);
            let velocity = rows.velocity(this.relative(tip, &demand));
            let parts = this.resolve(robot, &pose, &columns, velocity, &q);
            rates = this.within(robot, &pose, &columns, &parts, bounds, &q);
        }
        rates
    }

    /// A time step that is one.
    #[inline(always)]
    fn time(&mut self, dt: f64) -> f64 {
        let good = dt >= STEPS.0 && dt <= STEPS.1;
        self.watch.note(!good, Event::Time);
        if good { dt } else { 1.0 / self.settings.rate_hz }
    }

    /// The base's twist, the last good one if it is none.
    #[inline(always)]
    fn take_base(&mut self, inputs: &Inputs<'_>) {
        self.watch.note(inputs.base_in_doubt, Event::BaseSensor);
        let Some(base) = inputs.base_twist else { return };
        let good = moderate(base);
        self.watch.note(!good, Event::BaseTwist);
        if good {
            self.base_twist = *base;
        }
    }

    /// How the task should move in the world: none where that is not known.
    #[inline(always)]
    fn demand<const FUSED: bool>(
        &mut self,
        goal: &Goal<'_>,
        tip: &Axes<FUSED>,
        rows: &Rows<FUSED>,
        dt: f64,
    ) -> Six<FUSED> {
        let (Goal::Move(twist) | Goal::Reach(_, twist)) = goal;
        let good = moderate(twist);
        self.watch.note(!good, Event::Twist);
        let mut demand = [Lanes::ZERO; 2];
        if good {
            demand = [half(twist, 0), half(twist, 3)];
        }
        if let Goal::Reach(target, _) = goal {
            if let Some(away) = Away::of(&self.shape, self.settings.task, tip, rows, target) {
                self.watch.note(away.opposed, Event::Opposed);
                let correction = away.correction(&self.settings, dt);
                demand = [demand[0] + correction[0], demand[1] + correction[1]];
            } else {
                self.watch.note(true, Event::Target);
                demand = [Lanes::ZERO; 2];
            }
        }
        demand
    }

    /// Where the trocar is, if the target says so.
    #[inline(always)]
    fn take_trocar(&mut self, goal: &Goal<'_>) {
        if let (Task::RemoteCentre, Goal::Reach(target, _)) = (self.settings.task, goal) {
            let trocar = Vector3::new(target[3], target[4], target[5]);
            if trocar.iter().fold(true, |all, x| all & (x.abs() <= FARTHEST)) {
                self.trocar = trocar;
            }
        }
    }

    /// Where the trocar is.
    #[inline(always)]
    fn trocar<const FUSED: bool>(&self) -> Vector<FUSED> {
        Lanes::of_three(self.trocar.into())
    }

    /// How fast what is to be moved should move relative to the base.
    #[inline(always)]
    fn relative<const FUSED: bool>(&self, tip: &Axes<FUSED>, demand: &Six<FUSED>) -> Six<FUSED> {
        let (v, w) = (half(&self.base_twist, 0), half(&self.base_twist, 3));
        let by_base = match self.settings.task {
            Task::RemoteCentre => v + w.cross(self.trocar()),
            _ => w,
        };
        [demand[0] - (v + w.cross(tip.origin)), demand[1] - by_base]
    }
}

/// The twist of a base's origin that turns with `w` about a pivot which itself moves with `v`, all in base axes: v + p × ω,
/// then ω.
#[must_use]
pub fn turning_about(pivot: &Vector3<f64>, v: &Vector3<f64>, w: &Vector3<f64>) -> [f64; ROWS] {
    let linear = v + pivot.cross(w);
    [linear.x, linear.y, linear.z, w.x, w.y, w.z]
}

/// Three of six numbers.
#[inline(always)]
fn half<const FUSED: bool>(six: &[f64; ROWS], from: usize) -> Vector<FUSED> {
    Lanes::of_three([six[from], six[from + 1], six[from + 2]])
}

/// All numbers are.
#[inline(always)]
fn finite(numbers: &[f64]) -> bool {
    numbers.iter().fold(true, |all, x| all & (x.abs() < f64::INFINITY))
}

/// All numbers are such as occur.
#[inline(always)]
fn moderate(numbers: &[f64; ROWS]) -> bool {
    numbers.iter().fold(true, |all, x| all & (x.abs() <= FASTEST))
}
