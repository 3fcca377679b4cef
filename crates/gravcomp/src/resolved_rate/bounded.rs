//! Rates within what the joints can do: slowed down as a whole, bent by least squares, or led uphill.

use super::factor::ROWS;
use super::limits::Bounds;
use super::pose::{Parts, Pose};
use super::task::{Columns, by_rows};
use super::{Event, Limit, Priority, ResolvedRate, finite};
use crate::box_qp::{Outcome, Problem, solve};
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
        self.output.limiting = None;
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
