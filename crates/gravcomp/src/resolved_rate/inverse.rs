//! From the task's velocity to rates: the damped inverse, and what the joints wish beside it.

use super::factor::{ROWS, Sides};
use super::pose::{Columns, Parts, Pose, side, trace};
use super::selective::selected;
use super::solver::{Condition, TASK, WISH};
use super::task::{Vector, of_coordinates, of_rows, product};
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
}
