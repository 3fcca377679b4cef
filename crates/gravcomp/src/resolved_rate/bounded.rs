//! Rates within what the joints can do: slowed down as a whole, bent by least squares, or led uphill.

use super::factor::ROWS;
use super::limits::{Bounds, Standing};
use super::pose::{Parts, Pose};
use super::task::{Columns, by_rows};
use super::{AtLimits, Event, Limit, Priority, ResolvedRate, finite};
use crate::box_qp::{Active, Outcome, Problem, solve};
use crate::manipulability::{Ascent, ascend};
use crate::robot::{Joints, Robot};

/// What rates weigh beside the task where it is not damped, as a share of the squared singular values.
const LEAST_WEIGHT: f64 = 1e-8;

impl ResolvedRate {
    /// The rates within the bounds.
    #[inline(always)]
    pub(super) fn within<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        pose: &Pose<'_, N, FUSED>,
        columns: &Columns<N, FUSED>,
        parts: &Parts<N, FUSED>,
        bounds: &Bounds<N>,
        q: &Joints,
    ) -> [f64; N] {
        (self.output.limiting, self.output.at_limits) = (None, AtLimits::default());
        let rates = match self.settings.priority {
            Priority::Direction => self.slowed(parts, bounds),
            Priority::Task => self.bent(columns, parts, bounds, q),
            Priority::Manipulability => self.climbing(robot, pose, columns, parts, bounds, q),
        };
        let good = finite(&rates) && finite(&[parts.trace]);
        self.watch.note(!good, Event::Overflow);
        if good {
            return rates;
        }
        self.output.scale = 0.0;
        [0.0; N]
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
            self.slow(bounds, &parts.task, alone);
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
        let pushed = led.pushed().map(|joint| (joint, Limit::Position));
        let first = pushed.or_else(|| bounds.standing(&rates, bounds.share(&rates), &self.settings).next());
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
        self.held(&problem, &found.x, found.active, first);
        self.watch.note(found.outcome != Outcome::Solved, Event::Unproven);
        self.output.scale = parts.progress(columns, &found.x);
        found.x
    }

    /// As `bent`, uphill.
    #[inline(always)]
    fn climbing<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        pose: &Pose<'_, N, FUSED>,
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
        let [up, task] = found.active;
        let active = Active { lower: up.lower | task.lower, upper: up.upper | task.upper };
        self.held(&boxed, &found.x, active, None);
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

    /// Says which joints stand at which limits with this share of the rates.
    #[cold]
    fn slow<const N: usize>(&mut self, bounds: &Bounds<N>, rates: &[f64; N], share: f64) {
        let Self { settings, output, watch, .. } = self;
        for (joint, limit) in bounds.standing(rates, share, settings) {
            output.at_limits.insert(joint, limit);
            output.limiting = output.limiting.or(Some((joint, limit)));
            watch.note(true, limit.event());
        }
    }

    /// Says which joints an optimum holds at which limits; `first` is the one to be named if it is among them.
    fn held<const N: usize>(&mut self, boxed: &Problem<N>, x: &[f64; N], active: Active, first: Standing) {
        for j in 0..self.settings.coordinates.min(N) {
            let (lower, upper) = (boxed.lower[j], boxed.upper[j]);
            let bound = if active.lower >> j & 1 == 1 { lower } else { upper };
            if active.any() >> j & 1 == 1 && x[j] == bound {
                let may_rest = lower <= 0.0 && upper >= 0.0;
                let is_fast = may_rest && bound.abs() >= self.settings.qd_max[j];
                let limit = if is_fast { Limit::Velocity } else { Limit::Position };
                self.stands(j, limit);
                self.output.limiting = self.output.limiting.or(Some((j, limit)));
            }
        }
        let is_none = self.output.at_limits.any() == 0;
        if let Some((joint, limit)) = first.filter(|(joint, _)| is_none || self.output.at_limits.has(*joint)) {
            self.stands(joint, limit);
            self.output.limiting = first;
        }
    }
}
