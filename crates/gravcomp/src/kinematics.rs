//! Where frames are.

use crate::lanes::{Lanes, Vec3, rotate, rotate_add, splat3, turn_z};
use crate::motion::JointsNow;
use crate::robot::{Carrier, Frame, Robot};
use nalgebra::{Matrix3, Vector3};

/// A frame in another as its axes and origin: columns x, y, z, o of the homogeneous matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes<const W: usize, const FUSED: bool> {
    pub x: Vec3<W, FUSED>,
    pub y: Vec3<W, FUSED>,
    pub z: Vec3<W, FUSED>,
    pub origin: Vec3<W, FUSED>,
}

impl<const W: usize, const FUSED: bool> Axes<W, FUSED> {
    /// A constant frame.
    #[inline(always)]
    pub fn constant(R: &Matrix3<f64>, p: &Vector3<f64>) -> Self {
        let column = |j: usize| Vector3::new(R[(0, j)].into(), R[(1, j)].into(), R[(2, j)].into());
        Self { x: column(0), y: column(1), z: column(2), origin: splat3(p) }
    }

    /// `R v`.
    #[inline(always)]
    pub fn rotate(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        let row = |i: usize| self.x[i].mul_add(v.x, self.y[i].mul_add(v.y, self.z[i] * v.z));
        Vector3::new(row(0), row(1), row(2))
    }

    /// `R v + o`.
    #[inline(always)]
    pub fn place(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        let row = |i: usize| self.x[i].mul_add(v.x, self.y[i].mul_add(v.y, self.z[i].mul_add(v.z, self.origin[i])));
        Vector3::new(row(0), row(1), row(2))
    }

    /// The constant frame (R, p) of this one: R rotates, p moves.
    #[inline(always)]
    pub fn then(&self, R: &Matrix3<f64>, p: &Vector3<f64>) -> Self {
        let column = |j: usize| self.rotate(&Vector3::new(R[(0, j)].into(), R[(1, j)].into(), R[(2, j)].into()));
        Self { x: column(0), y: column(1), z: column(2), origin: self.place(&splat3(p)) }
    }

    /// After a joint's own motion: a turn about z, then a shift along z.
    #[inline(always)]
    pub fn moved(&self, c: Lanes<W, FUSED>, s: Lanes<W, FUSED>, d: Lanes<W, FUSED>) -> Self {
        let mix = |i: usize| (c.mul_add(self.x[i], s * self.y[i]), c.mul_add(self.y[i], -(s * self.x[i])));
        let ((x0, y0), (x1, y1), (x2, y2)) = (mix(0), mix(1), mix(2));
        let shift = |i: usize| d.mul_add(self.z[i], self.origin[i]);
        Self {
            x: Vector3::new(x0, x1, x2),
            y: Vector3::new(y0, y1, y2),
            z: self.z,
            origin: Vector3::new(shift(0), shift(1), shift(2)),
        }
    }
}

/// The pose of `frame` in the base frame B, walked from the frame inward to the base.
#[inline(always)]
pub(crate) fn pose<const W: usize, const FUSED: bool>(robot: &Robot, now: &JointsNow<W, FUSED>, frame: &Frame) -> Axes<W, FUSED> {
    let mut axes = Axes::constant(frame.pose.rotation(), frame.pose.translation());
    let mut carrier = frame.carrier;
    while let Carrier::Body(i) = carrier {
        let (load, link) = (&robot.loads[i], &robot.links[i]);
        let inward = |v: &Vec3<W, FUSED>| rotate(&load.rotation, &turn_z(now.c[i], now.s[i], v));
        let mut turned = turn_z(now.c[i], now.s[i], &axes.origin);
        turned.z += now.d[i];
        axes = Axes {
            x: inward(&axes.x),
            y: inward(&axes.y),
            z: inward(&axes.z),
            origin: rotate_add(&load.rotation, &turned, &splat3(&link.position)),
        };
        let parent = robot.parents[i];
        carrier = if parent == i { Carrier::Base } else { Carrier::Body(parent) };
    }
    if carrier == Carrier::Root {
        let base = robot.base();
        axes = Axes::constant(base.rotation(), base.translation()).then(frame.pose.rotation(), frame.pose.translation());
    }
    axes
}

/// The axes of body `i` in B, from those of its parent.
#[inline(always)]
pub(crate) fn outward<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    i: usize,
    parent: Option<&Axes<W, FUSED>>,
) -> Axes<W, FUSED> {
    let (R, p) = (&robot.loads[i].rotation, &robot.links[i].position);
    let unmoved = parent.map_or_else(|| Axes::constant(R, p), |parent| parent.then(R, p));
    unmoved.moved(now.c[i], now.s[i], now.d[i])
}
