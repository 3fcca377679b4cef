//! The arm at a pose, and the task there in numbers.

use super::factor::{Matrix, ROWS, Sides};
use super::settings::Settings;
use super::task::{Motion, Rows, Shape, Vector, by_rows, from_three, product};
use crate::manipulability::manipulability;
use crate::motion::{JointsNow, single, to_mechanism};
use crate::robot::{Joints, Robot};
use nalgebra::Vector3;

/// The arm at a pose, and what the task makes of its motions.
pub(super) struct Pose<const N: usize, const FUSED: bool> {
    pub motion: Motion<N, FUSED>,
    pub rows: Rows<FUSED>,
}

impl<const N: usize, const FUSED: bool> Pose<N, FUSED> {
    #[inline(always)]
    pub(super) fn of(settings: &Settings, shape: &Shape, robot: &Robot, q: &Joints, trocar: Vector3<f64>) -> Self {
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
    pub(super) fn columns(&self, robot: &Robot) -> Columns<N, FUSED> {
        match robot.coupling() {
            None => self.rows.columns(&self.motion),
            Some(coupling) => self.rows.columns(&self.motion.coupled(coupling)),
        }
    }

    /// m of the task and ∂m/∂q.
    #[inline(always)]
    pub(super) fn manipulability(&self, robot: &Robot, count: usize) -> (f64, [f64; N]) {
        let J = by_rows(&self.motion.columns);
        let found = manipulability::<N, FUSED>(&J, robot.coupling(), &self.rows.projection(count));
        (found.value, found.gradient)
    }
}

/// A Jacobian, by columns of two halves.
pub(super) type Columns<const N: usize, const FUSED: bool> = [[Vector<FUSED>; 2]; N];

/// The task in numbers, the rates that move it, and those that do not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts<const N: usize, const FUSED: bool> {
    pub velocity: [Vector<FUSED>; 2],
    pub task: [f64; N],
    pub free: [f64; N],
    /// Of J Jᵀ: the sum of the squared singular values, and of the rows that are not there.
    pub trace: f64,
}

impl<const N: usize, const FUSED: bool> Parts<N, FUSED> {
    /// ν
    #[inline(always)]
    pub(super) fn target(&self) -> [f64; ROWS] {
        let ([x, y, z, _], [u, v, w, _]) = (self.velocity[0].0, self.velocity[1].0);
        [x, y, z, u, v, w]
    }

    /// Share of the task that the rates do: ν·J q̇ / ν·ν, 0 to 1; 1 where there is none to do.
    #[inline(always)]
    pub(super) fn progress(&self, columns: &Columns<N, FUSED>, rates: &[f64; N]) -> f64 {
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
pub(super) fn side<const FUSED: bool>(sides: &Sides<FUSED>, k: usize) -> [Vector<FUSED>; 2] {
    let half = |from: usize| from_three([sides[from].0[k], sides[from + 1].0[k], sides[from + 2].0[k]]);
    [half(0), half(3)]
}

/// The sum of the diagonal.
#[inline(always)]
pub(super) fn trace(matrix: &Matrix) -> f64 {
    (0..ROWS).map(|k| matrix[k][k]).sum()
}
