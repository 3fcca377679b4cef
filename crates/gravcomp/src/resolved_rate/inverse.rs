//! From the task's velocity to rates: the damped inverse, and what the joints wish beside it.

use super::factor::ROWS;
use super::pose::{Parts, Pose};
use super::selective::selected;
use super::solver::Solved;
use super::task::{Columns, Six, of_coordinates, of_rows, product, products};
use super::{Damping, Event, NullSpace, ResolvedRate};
use crate::lanes::Lanes;
use crate::robot::{Joints, Robot};

/// Largest rate of selectively damped least squares where no limit is smaller, rad/s or m/s.
const SELECTIVE_RATE: f64 = core::f64::consts::TAU;

impl ResolvedRate {
    /// The rates that the task needs, and those that do not move it.
    #[inline(always)]
    pub(super) fn resolve<const N: usize, const FUSED: bool>(
        &mut self,
        robot: &Robot,
        pose: &Pose<'_, N, FUSED>,
        columns: &Columns<N, FUSED>,
        velocity: Six<FUSED>,
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
        if self.settings.coordinates < self.shape.rows {
            self.watch.note(parts.leave(columns), Event::Undone);
        }
        parts
    }

    /// q̇ = Jᵀ A⁻¹ ν, and z − Jᵀ A⁻¹ J z of the wish z.
    #[inline(always)]
    fn determined<const N: usize, const FUSED: bool>(
        &mut self,
        columns: &Columns<N, FUSED>,
        wish: &[f64; N],
        parts: &mut Parts<N, FUSED>,
    ) {
        let matrix = of_rows(&columns[..self.settings.coordinates.min(N)], &self.shape);
        let wishes = self.settings.null_space != NullSpace::Still;
        let mut of_wish = [Lanes::ZERO; 2];
        if wishes {
            for j in 0..N {
                for part in 0..2 {
                    of_wish[part] = columns[j][part].mul_add(wish[j].into(), of_wish[part]);
                }
            }
        }
        let solved = self.solver.solve(&matrix, parts.velocity, wishes.then_some(of_wish));
        self.condition(&solved);
        parts.task = products(columns, &solved.task);
        if wishes {
            let moved = products(columns, &solved.wish);
            for j in 0..N {
                parts.free[j] = wish[j] - moved[j];
            }
        }
        parts.trace = matrix.trace();
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
        let mut pull = [0.0; ROWS];
        for j in 0..n {
            pull[j] = product(&columns[j], &parts.velocity);
        }
        let [x, y, z, u, v, w] = pull;
        let side = [Lanes::of_three([x, y, z]), Lanes::of_three([u, v, w])];
        let solved = self.solver.solve(&matrix, side, None);
        self.condition(&solved);
        for j in 0..n {
            parts.task[j] = solved.task[j / 3].0[j % 3];
        }
        parts.trace = matrix.trace();
    }

    /// The rates of selectively damped least squares; with it the null space is still.
    #[inline(always)]
    fn selective<const N: usize, const FUSED: bool>(
        &mut self,
        columns: &Columns<N, FUSED>,
        parts: &mut Parts<N, FUSED>,
    ) {
        let n = self.settings.coordinates.min(N);
        let matrix = of_rows(&columns[..n], &self.shape);
        let fastest = self.settings.qd_max[..n].iter().fold(SELECTIVE_RATE, |most: f64, rate| most.min(*rate));
        let found = selected(columns, &matrix, &self.shape.absent, &parts.velocity, fastest);
        parts.task = found.rates;
        parts.trace = matrix.trace();
        self.output.sigma_min = nalgebra::ComplexField::sqrt(found.sigma_squared);
        self.output.damping = 0.0;
        self.watch.note(found.is_cut, Event::Singular);
    }

    /// Says how well conditioned the task is.
    #[inline(always)]
    fn condition<const FUSED: bool>(&mut self, condition: &Solved<FUSED>) {
        self.output.sigma_min = nalgebra::ComplexField::sqrt(condition.sigma_squared);
        self.output.damping = nalgebra::ComplexField::sqrt(condition.damping_squared);
        let damped = condition.damping_squared > 0.0 && self.settings.damping != Damping::Constant;
        self.watch.note(damped, Event::Singular);
    }

    /// z: what the joints would do if there were no task.
    #[inline(always)]
    fn wish<const N: usize, const FUSED: bool>(
        &self,
        robot: &Robot,
        pose: &Pose<'_, N, FUSED>,
        q: &Joints,
    ) -> [f64; N] {
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
    fn ascent<const N: usize, const FUSED: bool>(&self, robot: &Robot, pose: &Pose<'_, N, FUSED>) -> [f64; N] {
        let found = pose.manipulability(robot, self.shape.rows);
        let most = found.1.iter().fold(found.0, |most: f64, x| most.max(x.abs()));
        let mut ascent = found.1;
        for x in &mut ascent {
            *x = if most > 0.0 { *x / most } else { 0.0 };
        }
        ascent
    }
}
