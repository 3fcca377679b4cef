//! The arm at a pose, and the task there in numbers.

use super::factor::ROWS;
use super::task::{Columns, Rows, Six, Vector, by_rows, product};
use crate::coupling::Coupling;
use crate::kinematics::{Axes, Lines, chain, column_of, pose};
use crate::lanes::Lanes;
use crate::manipulability::manipulability;
use crate::motion::{JointsNow, single, to_mechanism};
use crate::robot::{Frame, Joints, Robot};

/// Share of a task that rounding may leave.
const ROUNDED: f64 = 1e-6;

/// No task is slower, in its own units.
const SLOWEST: f64 = 1e-9;

/// Out to the frame of the task, with the coordinates at q: it, and the joints' axes and origins.
#[inline(always)]
pub(super) fn reach<const N: usize, const FUSED: bool>(
    frame: &Frame,
    robot: &Robot,
    q: &Joints,
    (axis, origin): (&mut [Vector<FUSED>; N], &mut [Vector<FUSED>; N]),
) -> Axes<FUSED> {
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
    match frame.body() {
        Some(body) => chain(robot, &now, (frame, body), axis, origin),
        None => pose(robot, &now, frame),
    }
}

/// The arm at a pose, and what the task makes of its motions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose<'a, const N: usize, const FUSED: bool> {
    pub tip: &'a Axes<FUSED>,
    /// The body that carries it, if a joint moves it.
    pub body: Option<usize>,
    pub lines: Lines<'a, N, FUSED>,
    pub rows: &'a Rows<FUSED>,
}

impl<const N: usize, const FUSED: bool> Pose<'_, N, FUSED> {
    /// The mechanism's Jacobian of the frame, column i.
    #[inline(always)]
    fn frame_column(&self, robot: &Robot, i: usize) -> Six<FUSED> {
        match self.body {
            Some(body) => column_of(robot, body, i, self.lines, self.tip),
            None => [Lanes::ZERO; 2],
        }
    }

    /// The task's Jacobian.
    #[inline(always)]
    pub(super) fn columns(&self, robot: &Robot) -> Columns<N, FUSED> {
        let mut columns = [[Lanes::ZERO; 2]; N];
        match robot.coupling() {
            None => {
                for j in 0..robot.bodies().min(N) {
                    columns[j] = self.rows.column(self.frame_column(robot, j));
                }
            }
            Some(coupling) => {
                let moved = coupled(&self.frame_columns(robot), coupling);
                for j in 0..N {
                    columns[j] = self.rows.column(moved[j]);
                }
            }
        }
        columns
    }

    /// m of the task and ∂m/∂q.
    #[inline(always)]
    pub(super) fn manipulability(&self, robot: &Robot, count: usize) -> (f64, [f64; N]) {
        let J = by_rows(&self.frame_columns(robot));
        let found = manipulability::<N, FUSED>(&J, robot.coupling(), &self.rows.projection(count));
        (found.value, found.gradient)
    }

    /// The mechanism's Jacobian of the frame.
    #[inline(always)]
    fn frame_columns(&self, robot: &Robot) -> Columns<N, FUSED> {
        let mut columns = [[Lanes::ZERO; 2]; N];
        for i in 0..robot.bodies().min(N) {
            columns[i] = self.frame_column(robot, i);
        }
        columns
    }
}

/// J_mechanism C: how the coordinates move what the mechanism's joints move.
#[inline(always)]
fn coupled<const N: usize, const FUSED: bool>(joints: &Columns<N, FUSED>, coupling: &Coupling) -> Columns<N, FUSED> {
    let mut columns = [[Lanes::ZERO; 2]; N];
    for (column, along) in columns.iter_mut().zip(coupling.columns()) {
        for (of_joint, share) in joints.iter().zip(along) {
            for part in 0..2 {
                column[part] = of_joint[part].mul_add((*share).into(), column[part]);
            }
        }
    }
    columns
}

/// The task in numbers, the rates that move it, and those that do not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts<const N: usize, const FUSED: bool> {
    pub velocity: Six<FUSED>,
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

    /// The task's own rates leave some of it undone, more than rounding does.
    #[inline(always)]
    pub(super) fn leave(&self, columns: &Columns<N, FUSED>) -> bool {
        let mut left = self.velocity;
        for j in 0..N {
            for part in 0..2 {
                left[part] = columns[j][part].neg_mul_add(self.task[j].into(), left[part]);
            }
        }
        let whole = product(&self.velocity, &self.velocity);
        product(&left, &left) > ROUNDED * ROUNDED * whole + SLOWEST * SLOWEST
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
