//! The rows of a task: how the joints move what is to be moved, and how fast that should move.
//!
//! A task is three linear rows and three more, each a functional of the frame's motion; rows it has not are zeros.

use super::factor::{Matrix, ROWS};
use super::settings::{Settings, Task};
use crate::constants::MAX_JOINTS;
use crate::coupling::Coupling;
use crate::kinematics::{Axes, along};
use crate::lanes::Lanes;
use crate::manipulability::Projection;
use crate::motion::JointsNow;
use crate::robot::{Frame, Robot};
use nalgebra::Vector3;

/// Three numbers and a zero.
pub(super) type Vector<const FUSED: bool> = Lanes<4, FUSED>;

/// The frame, and its geometric Jacobian by columns, linear and angular part of each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion<const N: usize, const FUSED: bool> {
    pub tip: Axes<FUSED>,
    pub columns: [[Vector<FUSED>; 2]; N],
}

impl<const N: usize, const FUSED: bool> Motion<N, FUSED> {
    /// Of `frame` with the joints where they are now: one sweep gives both.
    #[inline(always)]
    pub(super) fn of(robot: &Robot, now: &JointsNow<'_, 1, FUSED>, frame: &Frame) -> Self {
        let mut columns = [[Lanes::ZERO; 2]; N];
        let Some(body) = frame.body() else {
            return Self { tip: crate::kinematics::pose(robot, now, frame), columns };
        };
        let (mut axis, mut origin) = ([Lanes::ZERO; MAX_JOINTS], [Lanes::ZERO; MAX_JOINTS]);
        let last = along(
            robot,
            now,
            body,
            #[inline(always)]
            |i, at| (axis[i], origin[i]) = (at.z, at.origin),
        );
        let tip = last.then(frame.pose.rotation(), frame.pose.translation());
        for i in 0..robot.bodies().min(N) {
            if robot.carries(i, body) {
                columns[i] = if robot.loads[i].slides {
                    [axis[i], Lanes::ZERO]
                } else {
                    [cross(axis[i], tip.origin - origin[i]), axis[i]]
                };
            }
        }
        Self { tip, columns }
    }

    /// The same for the coordinates that move the mechanism's joints: J = J_mechanism C.
    #[inline(always)]
    pub(super) fn coupled(&self, coupling: &Coupling) -> Self {
        let mut columns = [[Lanes::ZERO; 2]; N];
        for (column, along) in columns.iter_mut().zip(coupling.columns()) {
            for (of_joint, share) in self.columns.iter().zip(along) {
                for part in 0..2 {
                    column[part] = of_joint[part].mul_add((*share).into(), column[part]);
                }
            }
        }
        Self { tip: self.tip, columns }
    }
}

/// What of a task is the same at every pose.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    task: Task,
    /// 1/L where the row is there, else 0.
    linear: [f64; 4],
    /// 1 where the row is there, else 0.
    angular: [f64; 4],
    /// 1 where a row is not there, else 0.
    pub absent: [f64; ROWS],
    /// The pointing axis and two across it, in the frame's axes.
    pub axis: [f64; 3],
    across: [[f64; 3]; 2],
    /// 1/L
    scale: f64,
    /// Rows that are there.
    pub rows: usize,
}

impl Shape {
    /// Of a task that was checked.
    pub(super) fn of(settings: &Settings) -> Self {
        let there = match settings.task {
            Task::Twist => settings.rows,
            Task::Position => [true, true, true, false, false, false],
            Task::Pointing | Task::RemoteCentre => [true, true, true, true, true, false],
        };
        let ones = there.map(|there| if there { 1.0 } else { 0.0 });
        let scale = 1.0 / settings.characteristic_length;
        let [x, y, z, u, v, w] = ones;
        let axis = settings.pointing_axis.normalize();
        let first = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
        Self {
            task: settings.task,
            linear: [x * scale, y * scale, z * scale, 0.0],
            angular: [u, v, w, 0.0],
            absent: ones.map(|one| 1.0 - one),
            axis: axis.into(),
            across: [first.into(), axis.cross(&first).into()],
            scale,
            rows: there.iter().filter(|&&there| there).count(),
        }
    }
}

/// What a task makes of a motion: linear rows in units of the characteristic length, and what the other rows are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rows<const FUSED: bool> {
    task: Task,
    linear: Vector<FUSED>,
    angular: Vector<FUSED>,
    /// M, by columns: the other rows are M w, or M times the motion of a point of the shaft.
    further: [Vector<FUSED>; 3],
    /// h z: from the tip to the shaft's point nearest the trocar.
    shaft: Vector<FUSED>,
}

impl<const FUSED: bool> Rows<FUSED> {
    /// With the tip where it is, and the trocar.
    #[inline(always)]
    pub(super) fn at(shape: &Shape, tip: &Axes<FUSED>, trocar: Vector<FUSED>) -> Self {
        let mut rows = Self {
            task: shape.task,
            linear: Lanes(shape.linear),
            angular: Lanes(shape.angular),
            further: [Lanes::ZERO; 3],
            shaft: Lanes::ZERO,
        };
        match shape.task {
            Task::Twist | Task::Position => {}
            Task::Pointing => rows.further = across(shape, tip, 1.0),
            Task::RemoteCentre => {
                let axis = tip.rotate(shape.axis);
                rows.shaft = axis * Lanes::splat(dot(axis, trocar - tip.origin));
                rows.further = across(shape, tip, shape.scale);
            }
        }
        rows
    }

    /// From the tip to the shaft's point nearest the trocar, m.
    #[inline(always)]
    pub(super) fn shaft(&self) -> Vector<FUSED> {
        self.shaft
    }

    /// The task's velocity: of the frame's linear motion, and of its angular motion or that of the trocar.
    #[inline(always)]
    pub(super) fn velocity(&self, [linear, second]: [Vector<FUSED>; 2]) -> [Vector<FUSED>; 2] {
        let further = match self.task {
            Task::Twist | Task::Position => self.angular * second,
            Task::Pointing | Task::RemoteCentre => self.map(second),
        };
        [self.linear * linear, further]
    }

    /// The columns of the task's Jacobian.
    #[inline(always)]
    pub(super) fn columns<const N: usize>(&self, motion: &Motion<N, FUSED>, n: usize) -> [[Vector<FUSED>; 2]; N] {
        let mut columns = [[Lanes::ZERO; 2]; N];
        for j in 0..n.min(N) {
            let [linear, angular] = motion.columns[j];
            let further = match self.task {
                Task::Twist | Task::Position => self.angular * angular,
                Task::Pointing => self.map(angular),
                Task::RemoteCentre => self.map(linear + cross(angular, self.shaft)),
            };
            columns[j] = [self.linear * linear, further];
        }
        columns
    }

    /// What the task takes of the frame's twist, in base axes.
    #[inline(always)]
    pub(super) fn projection(&self, count: usize) -> Projection {
        let mut rows = [[0.0; 6]; ROWS];
        for r in 0..3 {
            rows[r][r] = self.linear.0[r];
            for c in 0..3 {
                rows[r + 3][c + 3] = match self.task {
                    Task::Twist | Task::Position if r == c => self.angular.0[r],
                    Task::Twist | Task::Position => 0.0,
                    Task::Pointing | Task::RemoteCentre => self.further[c].0[r],
                };
            }
        }
        Projection { rows, count }
    }

    /// M v, three products.
    #[inline(always)]
    fn map(&self, v: Vector<FUSED>) -> Vector<FUSED> {
        let [x, y, z, _] = v.0;
        self.further[0].mul_add(x.into(), self.further[1].mul_add(y.into(), self.further[2] * z.into()))
    }
}

/// Two rows across the pointing axis, by columns.
#[inline(always)]
fn across<const FUSED: bool>(shape: &Shape, tip: &Axes<FUSED>, scale: f64) -> [Vector<FUSED>; 3] {
    let [first, second] = shape.across;
    let (first, second) = (tip.rotate(first) * scale.into(), tip.rotate(second) * scale.into());
    let mut columns = [Lanes::ZERO; 3];
    for l in 0..3 {
        columns[l] = Lanes([first.0[l], second.0[l], 0.0, 0.0]);
    }
    columns
}

/// J Jᵀ, with ones in place of the rows that are not there.
#[inline(always)]
pub(super) fn of_rows<const N: usize, const FUSED: bool>(
    columns: &[[Vector<FUSED>; 2]; N],
    n: usize,
    absent: &[f64; ROWS],
) -> Matrix {
    let (mut linear, mut mixed, mut further) = ([Lanes::ZERO; 3], [Lanes::ZERO; 3], [Lanes::ZERO; 3]);
    for column in &columns[..n.min(N)] {
        for r in 0..3 {
            let (l, f) = (column[0].0[r].into(), column[1].0[r].into());
            linear[r] = column[0].mul_add(l, linear[r]);
            mixed[r] = column[0].mul_add(f, mixed[r]);
            further[r] = column[1].mul_add(f, further[r]);
        }
    }
    let mut matrix = [[0.0; ROWS]; ROWS];
    for r in 0..3 {
        for c in 0..3 {
            matrix[r][c] = linear[r].0[c];
            matrix[r + 3][c] = mixed[r].0[c];
            matrix[r + 3][c + 3] = further[r].0[c];
        }
    }
    for r in 0..ROWS {
        matrix[r][r] += absent[r];
    }
    matrix
}

/// Jᵀ J of fewer coordinates than rows, with ones beyond them.
#[inline(always)]
pub(super) fn of_coordinates<const N: usize, const FUSED: bool>(columns: &[[Vector<FUSED>; 2]; N], n: usize) -> Matrix {
    let mut matrix = [[0.0; ROWS]; ROWS];
    for i in 0..ROWS {
        matrix[i][i] = 1.0;
    }
    for i in 0..n.min(N).min(ROWS) {
        for j in 0..=i {
            matrix[i][j] = product(&columns[i], &columns[j]);
        }
    }
    matrix
}

/// The product of two columns, or of a column and what belongs to the rows.
#[inline(always)]
pub(super) fn product<const FUSED: bool>(a: &[Vector<FUSED>; 2], b: &[Vector<FUSED>; 2]) -> f64 {
    let [x, y, z, _] = a[0].mul_add(b[0], a[1] * b[1]).0;
    x + y + z
}

/// Three numbers as a vector.
#[inline(always)]
pub(super) fn from_three<const FUSED: bool>([x, y, z]: [f64; 3]) -> Vector<FUSED> {
    Lanes([x, y, z, 0.0])
}

/// `a · b`.
#[inline(always)]
pub(super) fn dot<const FUSED: bool>(a: Vector<FUSED>, b: Vector<FUSED>) -> f64 {
    let [x, y, z, _] = (a * b).0;
    x + y + z
}

/// `a × b`.
#[inline(always)]
pub(super) fn cross<const FUSED: bool>(a: Vector<FUSED>, b: Vector<FUSED>) -> Vector<FUSED> {
    turned(a * turned(b) - turned(a) * b)
}

/// (y, z, x).
#[inline(always)]
fn turned<const FUSED: bool>(v: Vector<FUSED>) -> Vector<FUSED> {
    let [x, y, z, w] = v.0;
    Lanes([y, z, x, w])
}

/// The columns as rows.
#[inline(always)]
pub(super) fn by_rows<const N: usize, const FUSED: bool>(columns: &[[Vector<FUSED>; 2]; N]) -> [[f64; N]; ROWS] {
    let mut rows = [[0.0; N]; ROWS];
    for j in 0..N {
        for r in 0..3 {
            (rows[r][j], rows[r + 3][j]) = (columns[j][0].0[r], columns[j][1].0[r]);
        }
    }
    rows
}
