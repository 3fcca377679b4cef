//! Resolved-rate motion: the joint rates with which a tool moves as it should, bounded wherever the arm is.
//!
//! > q̇ = J⁺ ν  (D. Whitney, "Resolved motion rate control of manipulators and human prostheses", 1969)
//!
//! [`ResolvedRate::step`] takes a twist, [`Goal::Reach`] a target that moves (closed loop, ν = ν_target + K e with the
//! orientation error e by logarithm). Either never fails: whatever comes in, the rates are finite and within their limits, and
//! every departure from J q̇ = ν is an [`Event`].
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

mod closed_loop;
mod factor;
mod limits;
mod selective;
mod settings;
mod solver;
mod status;
mod task;

pub use closed_loop::TARGET;
pub use settings::{Damping, NullSpace, Priority, Settings, SettingsError, Task};
pub use status::{Counters, Event, Events, Limit, Status};

use crate::box_qp::{Active, Outcome, Problem, solve};
use crate::constants::MAX_JOINTS;
use crate::kinematics::Axes;
use crate::lanes::Lanes;
use crate::manipulability::{Ascent, ascend, manipulability};
use crate::motion::{JointsNow, single, to_mechanism};
use crate::robot::{Joints, Robot};
use closed_loop::Away;
use factor::{Matrix, ROWS, Sides};
use limits::{Bounds, Limited, Ramp};
use nalgebra::Vector3;
use selective::selected;
use solver::{Condition, Solver, TASK, WISH};
use status::Watch;
use task::{Motion, Rows, Shape, Vector, by_rows, from_three, of_coordinates, of_rows, product};

/// No twist of a tool or a base is larger, m/s or rad/s.
const FASTEST: f64 = 1e6;

/// No point is further away, m, and no joint has turned further, rad.
const FARTHEST: f64 = 1e6;

/// Largest rate of selectively damped least squares where no limit is smaller, rad/s or m/s.
const SELECTIVE_RATE: f64 = core::f64::consts::TAU;

/// What rates weigh beside the task where it is not damped, as a share of the squared singular values.
const LEAST_WEIGHT: f64 = 1e-8;

/// Longest time step, s.
const LONGEST: f64 = 1.0;

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
    /// The joint that stands at a limit, and at which.
    pub limiting: Option<(usize, Limit)>,
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
        self.take_base(inputs.base_twist);
        let n = self.settings.coordinates.min(N);
        let known = inputs.q[..n].iter().fold(true, |all, x| all & (x.abs() <= FARTHEST));
        self.watch.note(!known, Event::Absent);
        let mut goal = [0.0; N];
        let mut bounds = Bounds { lower: [f64::NEG_INFINITY; N], upper: [f64::INFINITY; N] };
        if known {
            bounds = Bounds::at(&self.settings, self.limited, inputs.q, dt);
            self.take_trocar(&inputs.goal);
            goal = self.rates::<N, FUSED>(robot, inputs, &bounds, dt);
        }
        let (next, standing) = self.ramp.towards(&goal, &self.settings, self.limited, dt);
        if let Some((_, limit)) = standing {
            self.watch.note(true, limit.event());
            self.output.limiting = standing;
        }
        let next = bounds.clamped(&next);
        self.ramp.go(&next, self.limited, dt);
        self.output.qd = *self.ramp.rates();
        self.watch.end();
    }

    /// The rates within the bounds that the task needs at q, or half a step further on.
    #[inline(always)]
    fn rates<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        inputs: &Inputs<'_>,
        bounds: &Bounds<N>,
        dt: f64,
    ) -> [f64; N] {
        let (mut q, mut demand, mut rates) = (*inputs.q, [Lanes::ZERO; 2], [0.0; N]);
        let passes = if self.settings.midpoint { 2 } else { 1 };
        for pass in 0..passes {
            for j in 0..N {
                q[j] += 0.5 * dt * rates[j];
            }
            let pose = Pose::<N, FUSED>::of(&self.settings, &self.shape, robot, &q, self.trocar);
            if pass == 0 {
                demand = self.demand(&inputs.goal, &pose.motion.tip, &pose.rows, dt);
            }
            let columns = pose.columns(robot);
            let velocity = pose.rows.velocity(self.relative(&pose.motion.tip, &demand));
            let parts = self.resolve(robot, &pose, &columns, velocity, &q);
            rates = self.within(robot, &pose, &columns, &parts, bounds, &q);
        }
        rates
    }

    /// A time step that is one.
    #[inline(always)]
    fn time(&mut self, dt: f64) -> f64 {
        let good = dt > 0.0 && dt <= LONGEST;
        self.watch.note(!good, Event::Time);
        if good { dt } else { 1.0 / self.settings.rate_hz }
    }

    /// The base's twist, the last good one if it is none.
    #[inline(always)]
    fn take_base(&mut self, twist: Option<&[f64; ROWS]>) {
        let Some(base) = twist else { return };
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
    ) -> [Vector<FUSED>; 2] {
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
            if trocar.amax() <= FARTHEST {
                self.trocar = trocar;
            }
        }
    }

    /// The rates that the task needs, and those that do not move it.
    #[inline(always)]
    fn resolve<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        pose: &Pose<N, FUSED>,
        columns: &Columns<N, FUSED>,
        velocity: [Vector<FUSED>; 2],
        q: &Joints,
    ) -> Parts<N, FUSED> {
        let mut parts = Parts { velocity, task: [0.0; N], free: [0.0; N], trace: 0.0 };
        if self.settings.damping == Damping::Selective {
            self.selective(columns, &mut parts);
        } else if self.settings.coordinates < self.shape.rows {
            self.overdetermined(columns, &mut parts);
        } else {
            let wish = self.wish(robot, pose, q);
            self.determined(columns, &wish, &mut parts);
        }
        parts
    }

    /// How fast what is to be moved should move relative to the base.
    #[inline(always)]
    fn relative<const FUSED: bool>(&self, tip: &Axes<FUSED>, demand: &[Vector<FUSED>; 2]) -> [Vector<FUSED>; 2] {
        let (v, w) = (half(&self.base_twist, 0), half(&self.base_twist, 3));
        let by_base = match self.settings.task {
            Task::RemoteCentre => v + task::cross(w, from_three(self.trocar.into())),
            _ => w,
        };
        [demand[0] - (v + task::cross(w, tip.origin)), demand[1] - by_base]
    }

    /// q̇ = Jᵀ A⁻¹ ν, and z − Jᵀ A⁻¹ J z of the wish z.
    #[inline(always)]
    fn determined<const N: usize, const FUSED: bool>(
        &mut self,
        columns: &Columns<N, FUSED>,
        wish: &[f64; N],
        parts: &mut Parts<N, FUSED>,
    ) {
        let matrix = of_rows(columns, &self.shape.absent);
        let mut of_wish = [Lanes::ZERO; 2];
        if self.settings.null_space != NullSpace::Still {
            for j in 0..N {
                for part in 0..2 {
                    of_wish[part] = columns[j][part].mul_add(wish[j].into(), of_wish[part]);
                }
            }
        }
        let mut sides: Sides<FUSED> = [Lanes::ZERO; ROWS];
        for r in 0..3 {
            for part in 0..2 {
                sides[r + 3 * part].0[TASK] = parts.velocity[part].0[r];
                sides[r + 3 * part].0[WISH] = of_wish[part].0[r];
            }
        }
        let condition = self.solver.solve(&matrix, &mut sides);
        self.condition(condition);
        let y = side(&sides, TASK);
        for j in 0..N {
            parts.task[j] = product(&columns[j], &y);
        }
        if self.settings.null_space != NullSpace::Still {
            let z = side(&sides, WISH);
            for j in 0..N {
                parts.free[j] = wish[j] - product(&columns[j], &z);
            }
        }
        parts.trace = trace(&matrix);
    }

    /// q̇ = (Jᵀ J)⁻¹ Jᵀ ν: as near to the task as so few coordinates come.
    #[inline(always)]
    fn overdetermined<const N: usize, const FUSED: bool>(
        &mut self,
        columns: &Columns<N, FUSED>,
        parts: &mut Parts<N, FUSED>,
    ) {
        let n = self.settings.coordinates.min(N).min(ROWS);
        let matrix = of_coordinates(columns, n);
        let mut sides: Sides<FUSED> = [Lanes::ZERO; ROWS];
        for j in 0..n {
            sides[j].0[TASK] = product(&columns[j], &parts.velocity);
        }
        let condition = self.solver.solve(&matrix, &mut sides);
        self.condition(condition);
        for j in 0..n {
            parts.task[j] = sides[j].0[TASK];
        }
        parts.trace = trace(&matrix);
    }

    /// The rates of selectively damped least squares; with it the null space is still.
    #[inline(always)]
    fn selective<const N: usize, const FUSED: bool>(
        &mut self,
        columns: &Columns<N, FUSED>,
        parts: &mut Parts<N, FUSED>,
    ) {
        let n = self.settings.coordinates.min(N);
        let matrix = of_rows(columns, &self.shape.absent);
        let fastest = self.settings.qd_max[..n].iter().fold(SELECTIVE_RATE, |most: f64, rate| most.min(*rate));
        let found = selected(columns, &matrix, &self.shape.absent, &parts.velocity, fastest);
        parts.task = found.rates;
        parts.trace = trace(&matrix);
        self.output.sigma_min = nalgebra::ComplexField::sqrt(found.sigma_squared);
        self.output.damping = 0.0;
        self.watch.note(found.is_cut, Event::Singular);
    }

    /// Says how well conditioned the task is.
    #[inline(always)]
    fn condition(&mut self, condition: Condition) {
        self.output.sigma_min = nalgebra::ComplexField::sqrt(condition.sigma_squared);
        self.output.damping = nalgebra::ComplexField::sqrt(condition.damping_squared);
        let damped = condition.damping_squared > 0.0 && self.settings.damping != Damping::Constant;
        self.watch.note(damped, Event::Singular);
    }

    /// z: what the joints would do if there were no task.
    #[inline(always)]
    fn wish<const N: usize, const FUSED: bool>(&self, robot: &Robot, pose: &Pose<N, FUSED>, q: &Joints) -> [f64; N] {
        let (lower, upper) = &self.settings.limits;
        let mut wish = [0.0; N];
        match self.settings.null_space {
            NullSpace::Still => return wish,
            NullSpace::Posture => {
                for j in 0..N {
                    wish[j] = self.settings.posture[j] - q[j];
                }
            }
            NullSpace::Limits => {
                for j in 0..N {
                    let middle = 0.5 * (lower[j] + upper[j]) - q[j];
                    wish[j] = if middle.is_finite() { middle } else { 0.0 };
                }
            }
            NullSpace::Manipulability => wish = self.ascent(robot, pose),
        }
        for j in 0..N {
            wish[j] = if j < self.settings.coordinates { wish[j] * self.settings.null_gain } else { 0.0 };
        }
        wish
    }

    /// ∂ ln m/∂q, no number of which is larger than 1.
    #[inline(always)]
    fn ascent<const N: usize, const FUSED: bool>(&self, robot: &Robot, pose: &Pose<N, FUSED>) -> [f64; N] {
        let found = pose.manipulability(robot, self.shape.rows);
        let most = found.1.iter().fold(found.0, |most: f64, x| most.max(x.abs()));
        let mut ascent = found.1;
        for x in &mut ascent {
            *x = if most > 0.0 { *x / most } else { 0.0 };
        }
        ascent
    }

    /// The rates within the bounds.
    #[inline(always)]
    fn within<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        pose: &Pose<N, FUSED>,
        columns: &Columns<N, FUSED>,
        parts: &Parts<N, FUSED>,
        bounds: &Bounds<N>,
        q: &Joints,
    ) -> [f64; N] {
        self.output.limiting = None;
        let rates = match self.settings.priority {
            Priority::Direction => self.slowed(parts, bounds),
            Priority::Task => self.bent(columns, parts, bounds, q),
            Priority::Manipulability => self.climbing(robot, pose, columns, parts, bounds, q),
        };
        let good = finite(&rates) && finite(&[parts.trace]);
        self.watch.note(!good, Event::Overflow);
        if good { rates } else { [0.0; N] }
    }

    /// The task first, slowed down as a whole; what does not move it as far as there is room.
    #[inline(always)]
    fn slowed<const N: usize, const FUSED: bool>(&mut self, parts: &Parts<N, FUSED>, bounds: &Bounds<N>) -> [f64; N] {
        let mut rates = parts.task;
        for j in 0..N {
            rates[j] += parts.free[j];
        }
        let mut share = bounds.share(&rates);
        if share < 1.0 {
            let alone = bounds.share(&parts.task);
            self.stands(bounds, &parts.task, alone);
            if alone >= share {
                share = alone;
                let mut slowed = parts.task;
                for rate in &mut slowed {
                    *rate *= share;
                }
                let room = bounds.room(&slowed, &parts.free);
                for j in 0..N {
                    rates[j] = slowed[j] + room * parts.free[j];
                }
            } else {
                for rate in &mut rates {
                    *rate *= share;
                }
            }
        }
        self.output.scale = share;
        rates
    }

    /// As much of the task as there is within the bounds, by least squares; exactly the task where it is within them.
    #[inline(always)]
    fn bent<const N: usize, const FUSED: bool>(
        &mut self,
        columns: &Columns<N, FUSED>,
        parts: &Parts<N, FUSED>,
        bounds: &Bounds<N>,
        q: &Joints,
    ) -> [f64; N] {
        let mut rates = parts.task;
        for j in 0..N {
            rates[j] += parts.free[j];
        }
        let led = bounds.leading_back(&self.settings, q);
        self.output.scale = 1.0;
        if led.hold(&rates) {
            return rates;
        }
        self.stands(bounds, &rates, bounds.share(&rates));
        if let Some(joint) = led.pushed() {
            self.output.limiting = Some((joint, Limit::Position));
            self.watch.note(true, Event::PositionLimit);
        }
        let damping = self.output.damping * self.output.damping;
        let problem = Problem {
            rows: by_rows(columns),
            target: parts.target(),
            row_weight: [1.0; ROWS],
            wish: parts.free,
            weight: [damping.max(LEAST_WEIGHT * parts.trace + f64::MIN_POSITIVE); N],
            ..self.boxed(&led)
        };
        let found = solve::<N, FUSED>(&problem, self.active[0]);
        self.active[0] = found.active;
        self.watch.note(found.outcome != Outcome::Solved, Event::Unproven);
        self.output.scale = parts.progress(columns, &found.x);
        found.x
    }

    /// As `bent`, uphill.
    #[inline(always)]
    fn climbing<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        pose: &Pose<N, FUSED>,
        columns: &Columns<N, FUSED>,
        parts: &Parts<N, FUSED>,
        bounds: &Bounds<N>,
        q: &Joints,
    ) -> [f64; N] {
        let gradient = pose.manipulability(robot, self.shape.rows).1;
        let boxed = self.boxed(&bounds.leading_back(&self.settings, q));
        let target = parts.target();
        let distance = target.iter().map(|x| x.abs()).sum::<f64>() / self.settings.gain.max(1e-9);
        let box_of_rates = (boxed.lower, boxed.upper);
        let found = ascend::<N, FUSED>(
            &by_rows(columns),
            &target,
            &gradient,
            Ascent::towards(distance),
            box_of_rates,
            self.active,
        );
        self.active = found.active;
        self.watch.note(found.outcome != Outcome::Solved, Event::Unproven);
        if found.active[0].any() != 0 {
            self.stands(bounds, &found.x, 1.0);
        }
        self.output.scale = parts.progress(columns, &found.x);
        found.x
    }

    /// A box of rates for the optimum: none of places beyond the arm's own.
    #[inline(always)]
    fn boxed<const N: usize>(&self, bounds: &Bounds<N>) -> Problem<N> {
        let mut problem = Problem::EMPTY;
        for j in 0..self.settings.coordinates.min(N) {
            (problem.lower[j], problem.upper[j]) = (bounds.lower[j], bounds.upper[j]);
        }
        problem
    }

    /// Says which joint stands at which limit with this share of the rates.
    #[inline(always)]
    fn stands<const N: usize>(&mut self, bounds: &Bounds<N>, rates: &[f64; N], share: f64) {
        self.output.limiting = bounds.standing(rates, share, &self.settings);
        if let Some((_, limit)) = self.output.limiting {
            self.watch.note(true, limit.event());
        }
    }
}

/// The arm at a pose, and what the task makes of its motions.
struct Pose<const N: usize, const FUSED: bool> {
    motion: Motion<N, FUSED>,
    rows: Rows<FUSED>,
}

impl<const N: usize, const FUSED: bool> Pose<N, FUSED> {
    #[inline(always)]
    fn of(settings: &Settings, shape: &Shape, robot: &Robot, q: &Joints, trocar: Vector3<f64>) -> Self {
        let frame = settings.frame.as_ref().unwrap_or(robot.tool());
        let coupled;
        let joints = match robot.coupling() {
            None => single(q),
            Some(coupling) => {
                coupled = to_mechanism::<_, FUSED>(coupling, single(q), Some(coupling.offset()));
                &coupled
            }
        };
        let mut now = JointsNow::<1, FUSED>::at(joints);
        now.turn_single(robot);
        let motion = Motion::<N, FUSED>::of(robot, &now, frame);
        let rows = Rows::at(shape, &motion.tip, from_three(trocar.into()));
        Self { motion, rows }
    }

    /// The task's Jacobian.
    #[inline(always)]
    fn columns(&self, robot: &Robot) -> Columns<N, FUSED> {
        match robot.coupling() {
            None => self.rows.columns(&self.motion),
            Some(coupling) => self.rows.columns(&self.motion.coupled(coupling)),
        }
    }

    /// m of the task and ∂m/∂q.
    #[inline(always)]
    fn manipulability(&self, robot: &Robot, count: usize) -> (f64, [f64; N]) {
        let J = by_rows(&self.motion.columns);
        let found = manipulability::<N, FUSED>(&J, robot.coupling(), &self.rows.projection(count));
        (found.value, found.gradient)
    }
}

/// A Jacobian, by columns of two halves.
type Columns<const N: usize, const FUSED: bool> = [[Vector<FUSED>; 2]; N];

/// The task in numbers, the rates that move it, and those that do not.
#[derive(Clone, Copy, Debug)]
struct Parts<const N: usize, const FUSED: bool> {
    velocity: [Vector<FUSED>; 2],
    task: [f64; N],
    free: [f64; N],
    /// Of J Jᵀ: the sum of the squared singular values, and of the rows that are not there.
    trace: f64,
}

impl<const N: usize, const FUSED: bool> Parts<N, FUSED> {
    /// ν
    #[inline(always)]
    fn target(&self) -> [f64; ROWS] {
        let ([x, y, z, _], [u, v, w, _]) = (self.velocity[0].0, self.velocity[1].0);
        [x, y, z, u, v, w]
    }

    /// Share of the task that the rates do: ν·J q̇ / ν·ν, 0 to 1; 1 where there is none to do.
    #[inline(always)]
    fn progress(&self, columns: &Columns<N, FUSED>, rates: &[f64; N]) -> f64 {
        let mut done = 0.0;
        for j in 0..N {
            done += rates[j] * product(&columns[j], &self.velocity);
        }
        let whole = product(&self.velocity, &self.velocity);
        if whole > 0.0 { (done / whole).clamp(0.0, 1.0) } else { 1.0 }
    }
}

/// A right-hand side as a vector of rows.
#[inline(always)]
fn side<const FUSED: bool>(sides: &Sides<FUSED>, k: usize) -> [Vector<FUSED>; 2] {
    let half = |from: usize| from_three([sides[from].0[k], sides[from + 1].0[k], sides[from + 2].0[k]]);
    [half(0), half(3)]
}

/// The sum of the diagonal.
#[inline(always)]
fn trace(matrix: &Matrix) -> f64 {
    (0..ROWS).map(|k| matrix[k][k]).sum()
}

/// Three of six numbers.
#[inline(always)]
fn half<const FUSED: bool>(six: &[f64; ROWS], from: usize) -> Vector<FUSED> {
    from_three([six[from], six[from + 1], six[from + 2]])
}

/// All numbers are.
#[inline(always)]
fn finite(numbers: &[f64]) -> bool {
    numbers.iter().map(|x| x * 0.0).sum::<f64>() == 0.0
}

/// All numbers are such as occur.
#[inline(always)]
fn moderate(numbers: &[f64; ROWS]) -> bool {
    numbers.iter().fold(true, |all, x| all & (x.abs() <= FASTEST))
}
