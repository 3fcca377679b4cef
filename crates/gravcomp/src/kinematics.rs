//! Where frames are.

use crate::lanes::{Lanes, Vec3, dot, splat3};
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
    /// The base frame B in itself.
    pub const BASE: Self = {
        let (zero, one) = (Lanes::ZERO, Lanes::splat(1.0));
        Self {
            x: Vector3::new(one, zero, zero),
            y: Vector3::new(zero, one, zero),
            z: Vector3::new(zero, zero, one),
            origin: Vector3::new(zero, zero, zero),
        }
    };

    /// A constant frame.
    #[inline(always)]
    pub fn constant(R: &Matrix3<f64>, p: &Vector3<f64>) -> Self {
        Self { x: column(R, 0), y: column(R, 1), z: column(R, 2), origin: splat3(p) }
    }

    /// `R v`.
    #[inline(always)]
    pub fn rotate(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        let row = |k: usize| self.x[k].mul_add(v.x, self.y[k].mul_add(v.y, self.z[k] * v.z));
        Vector3::new(row(0), row(1), row(2))
    }

    /// `Rᵀ v`.
    #[inline(always)]
    pub fn unrotate(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        Vector3::new(dot(&self.x, v), dot(&self.y, v), dot(&self.z, v))
    }

    /// `R v + o`.
    #[inline(always)]
    pub fn place(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        let row = |k: usize| self.x[k].mul_add(v.x, self.y[k].mul_add(v.y, self.z[k].mul_add(v.z, self.origin[k])));
        Vector3::new(row(0), row(1), row(2))
    }

    /// The frame that the constant (R, p) is in this one.
    #[inline(always)]
    pub fn then(&self, R: &Matrix3<f64>, p: &Vector3<f64>) -> Self {
        Self {
            x: self.rotate(&column(R, 0)),
            y: self.rotate(&column(R, 1)),
            z: self.rotate(&column(R, 2)),
            origin: self.place(&splat3(p)),
        }
    }

    /// The axes of body i from those of its parent, these: constants first, then the joint's own turn. A body on the base
    /// starts from its constants.
    #[inline(always)]
    pub fn carry(&self, robot: &Robot, now: &JointsNow<W, FUSED>, i: usize) -> Self {
        let (F, p) = (&robot.loads[i].rotation, &robot.links[i].position);
        let (c, s, d) = (now.c[i], now.s[i], now.slide(robot, i));
        let unmoved = if robot.parents[i] == i { Self::constant(F, p) } else { self.then(F, p) };
        let slid = |k: usize| d.mul_add(unmoved.z[k], unmoved.origin[k]);
        Self {
            x: mixed(c, &unmoved.x, s, &unmoved.y),
            y: mixed(c, &unmoved.y, -s, &unmoved.x),
            z: unmoved.z,
            origin: Vector3::new(slid(0), slid(1), slid(2)),
        }
    }
}

/// Where a body sits in its parent: turned by R = F Rz(q), at p + F ẑ q.
///
/// R is multiplied out first: a rotation is then three operations deep instead of five, and depth is what sweeps wait for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seat<'r, const W: usize, const FUSED: bool> {
    x: Vec3<W, FUSED>,
    y: Vec3<W, FUSED>,
    F: &'r Matrix3<f64>,
    pub origin: Vec3<W, FUSED>,
}

impl<'r, const W: usize, const FUSED: bool> Seat<'r, W, FUSED> {
    /// Of body i, with the joints where they are now.
    #[inline(always)]
    pub fn of(robot: &'r Robot, now: &JointsNow<W, FUSED>, i: usize) -> Self {
        let (F, p) = (&robot.loads[i].rotation, &robot.links[i].position);
        let (c, s, d) = (now.c[i], now.s[i], now.slide(robot, i));
        let (fx, fy) = (column(F, 0), column(F, 1));
        let slid = |k: usize| d.mul_add(F[(k, 2)].into(), p[k].into());
        Self { x: mixed(c, &fx, s, &fy), y: mixed(c, &fy, -s, &fx), F, origin: Vector3::new(slid(0), slid(1), slid(2)) }
    }

    /// From the body's axes to the parent's.
    #[inline(always)]
    pub fn rotate(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        let row = |k: usize| self.x[k].mul_add(v.x, self.y[k].mul_add(v.y, Lanes::splat(self.F[(k, 2)]) * v.z));
        Vector3::new(row(0), row(1), row(2))
    }

    /// From the parent's axes to the body's.
    #[inline(always)]
    pub fn unrotate(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        Vector3::new(dot(&self.x, v), dot(&self.y, v), dot(&column(self.F, 2), v))
    }

    /// From a point in the body's frame to the parent's.
    #[inline(always)]
    pub fn place(&self, v: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
        self.rotate(v) + self.origin
    }
}

/// `c a + s b`.
#[inline(always)]
fn mixed<const W: usize, const FUSED: bool>(
    c: Lanes<W, FUSED>,
    a: &Vec3<W, FUSED>,
    s: Lanes<W, FUSED>,
    b: &Vec3<W, FUSED>,
) -> Vec3<W, FUSED> {
    let mixed = |k: usize| c.mul_add(a[k], s * b[k]);
    Vector3::new(mixed(0), mixed(1), mixed(2))
}

#[inline(always)]
fn column<const W: usize, const FUSED: bool>(R: &Matrix3<f64>, j: usize) -> Vec3<W, FUSED> {
    Vector3::new(R[(0, j)].into(), R[(1, j)].into(), R[(2, j)].into())
}

/// The pose of `frame` in the base frame B, walked from the frame inward to the base.
#[inline(always)]
pub(crate) fn pose<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    frame: &Frame,
) -> Axes<W, FUSED> {
    let mut axes = Axes::constant(frame.pose.rotation(), frame.pose.translation());
    match frame.carrier {
        Carrier::Base => axes,
        Carrier::Root => {
            let root = Axes::constant(robot.base().rotation(), robot.base().translation());
            root.then(frame.pose.rotation(), frame.pose.translation())
        }
        Carrier::Body(mut i) => loop {
            let seat = Seat::of(robot, now, i);
            axes = Axes {
                x: seat.rotate(&axes.x),
                y: seat.rotate(&axes.y),
                z: seat.rotate(&axes.z),
                origin: seat.place(&axes.origin),
            };
            if robot.parents[i] == i {
                return axes;
            }
            i = robot.parents[i];
        },
    }
}
