//! From where the frame is to where it should be: K e, bounded.

use super::settings::{Settings, Task};
use super::task::{Rows, Shape, Six, Vector};
use crate::kinematics::Axes;
use crate::lanes::Lanes;
use nalgebra::ComplexField;

/// Numbers of the longest target: a pose as a homogeneous matrix, row by row.
pub const TARGET: usize = 16;

/// No target is further away, m.
const FARTHEST: f64 = 1e6;

/// Largest sine, squared, for which the angle comes from a series.
const SMALL: f64 = 0.01;

/// asin(s)/s = 1 + s²/6 + …
const ARC_SINE: [f64; 7] =
    [1.0, 1.0 / 6.0, 3.0 / 40.0, 15.0 / 336.0, 105.0 / 3456.0, 945.0 / 42240.0, 10395.0 / 599_040.0];

/// Below this cosine the axis of a turn is taken from the symmetric part: towards π its sine vanishes.
const OPPOSED: f64 = -0.95;

/// How far away the target is: of the origin, and the turn or the trocar's distance from the shaft.
#[derive(Clone, Copy, Debug)]
pub(super) struct Away<const FUSED: bool> {
    pub first: Vector<FUSED>,
    pub second: Vector<FUSED>,
    /// The pointing axis is opposed to where it should point.
    pub opposed: bool,
}

impl<const FUSED: bool> Away<FUSED> {
    /// Of a target that is one: see [`Goal::Reach`](super::Goal::Reach).
    #[inline(always)]
    pub(super) fn of(
        shape: &Shape,
        task: Task,
        tip: &Axes<FUSED>,
        rows: &Rows<FUSED>,
        target: &[f64; TARGET],
    ) -> Option<Self> {
        let count = match task {
            Task::Position => 3,
            Task::Pointing | Task::RemoteCentre => 6,
            Task::Twist => TARGET,
        };
        let far = |x: &f64| x.abs() <= FARTHEST;
        if !target[..count].iter().fold(true, |all, x| all & far(x)) {
            return None;
        }
        let [x, y, z, u, v, w, ..] = *target;
        let here = tip.origin;
        let (second, opposed) = match task {
            Task::Twist => return Self::of_pose(tip, target),
            Task::Position => (Lanes::ZERO, false),
            Task::Pointing => turn_onto(tip.rotate(shape.axis), Lanes::of_three([-u, -v, -w]))?,
            Task::RemoteCentre => (Lanes::of_three([u, v, w]) - here - rows.shaft(), false),
        };
        Some(Self { first: Lanes::of_three([x, y, z]) - here, second, opposed })
    }

    #[inline(always)]
    fn of_pose(tip: &Axes<FUSED>, pose: &[f64; TARGET]) -> Option<Self> {
        let column = |j: usize| Lanes::of_three([pose[j], pose[4 + j], pose[8 + j]]);
        let (x, y, z) = (column(0), column(1), column(2));
        let long = |v: Vector<FUSED>| (v.dot(v) - 1.0).abs() < 1e-3;
        let right_handed = x.cross(y).dot(z) > 0.999;
        if !(long(x) & long(y) & long(z) & right_handed) {
            return None;
        }
        let sine = (tip.x.cross(x) + tip.y.cross(y) + tip.z.cross(z)) * 0.5.into();
        let cosine = 0.5 * (tip.x.dot(x) + tip.y.dot(y) + tip.z.dot(z) - 1.0);
        let turn =
            if cosine < OPPOSED { half_turn(tip, &[x, y, z], sine, cosine) } else { sine * arc(sine, cosine).into() };
        Some(Self { first: column(3) - tip.origin, second: turn, opposed: false })
    }

    /// K e, neither part faster than it may be.
    #[inline(always)]
    pub(super) fn correction(&self, settings: &Settings, dt: f64) -> Six<FUSED> {
        let at_most = 1.0 / dt;
        let (turning, turning_max) = match settings.task {
            Task::RemoteCentre => (settings.gain, settings.speed_max),
            _ => (settings.turning_gain, settings.turning_max),
        };
        [
            shortened(self.first * settings.gain.min(at_most).into(), settings.speed_max),
            shortened(self.second * turning.min(at_most).into(), turning_max),
        ]
    }
}

/// The angle over its sine; `sine` is the vector of that length along the axis.
#[inline(always)]
fn arc<const FUSED: bool>(sine: Vector<FUSED>, cosine: f64) -> f64 {
    let squared = sine.dot(sine);
    if squared < SMALL && cosine > 0.0 {
        return ARC_SINE.iter().rev().fold(0.0, |sum, c| sum * squared + c);
    }
    let length = ComplexField::sqrt(squared);
    atan2(length, cosine) / length
}

fn atan2(y: f64, x: f64) -> f64 {
    nalgebra::RealField::atan2(y, x)
}

/// The turn of nearly π: its axis is that of the symmetric part, (R + Rᵀ)/2 = c 1 + (1 − c) u uᵀ, its sign that of the sine.
#[inline(always)]
fn half_turn<const FUSED: bool>(
    tip: &Axes<FUSED>,
    wanted: &[Vector<FUSED>; 3],
    sine: Vector<FUSED>,
    cosine: f64,
) -> Vector<FUSED> {
    // R = Σ r*_k r_kᵀ
    let entry = |i: usize, j: usize| {
        let here = [tip.x, tip.y, tip.z];
        (0..3).map(|k| wanted[k].0[i] * here[k].0[j]).sum::<f64>()
    };
    let diagonal = [entry(0, 0), entry(1, 1), entry(2, 2)];
    let largest = (0..3).fold(0, |best, k| if diagonal[k] > diagonal[best] { k } else { best });
    let mut axis = [0.0; 3];
    for (k, x) in axis.iter_mut().enumerate() {
        *x = 0.5 * (entry(k, largest) + entry(largest, k)) - if k == largest { cosine } else { 0.0 };
    }
    let axis = Lanes::of_three(axis);
    let length = ComplexField::sqrt(axis.dot(axis));
    let angle = atan2(ComplexField::sqrt(sine.dot(sine)), cosine);
    let sign = if axis.dot(sine) < 0.0 { -1.0 } else { 1.0 };
    axis * (sign * angle / length).into()
}

/// The shortest turn that lays a unit vector on a direction, about any axis across where they are opposed; none for a
/// direction without length.
#[inline(always)]
fn turn_onto<const FUSED: bool>(axis: Vector<FUSED>, direction: Vector<FUSED>) -> Option<(Vector<FUSED>, bool)> {
    let squared = direction.dot(direction);
    if squared <= 1e-18 {
        return None;
    }
    let wanted = direction * (1.0 / ComplexField::sqrt(squared)).into();
    let (sine, cosine) = (axis.cross(wanted), axis.dot(wanted));
    if cosine > 0.0 || sine.dot(sine) > 1e-16 {
        return Some((sine * arc(sine, cosine).into(), cosine < OPPOSED));
    }
    let [x, y, z, _] = axis.0;
    let least = if x.abs() < 0.6 {
        [1.0, 0.0, 0.0]
    } else if y.abs() < 0.6 {
        [0.0, 1.0, 0.0]
    } else {
        [z, 0.0, -x]
    };
    let across = axis.cross(Lanes::of_three(least));
    Some((across * (core::f64::consts::PI / ComplexField::sqrt(across.dot(across))).into(), true))
}

/// The same direction, no longer than this.
#[inline(always)]
fn shortened<const FUSED: bool>(v: Vector<FUSED>, most: f64) -> Vector<FUSED> {
    if most == f64::INFINITY {
        return v;
    }
    let squared = v.dot(v);
    if squared <= most * most { v } else { v * (most / ComplexField::sqrt(squared)).into() }
}
