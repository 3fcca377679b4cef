//! Torque as a linear function of the inertial parameters: τ = Y π.
//!
//! Parameters belong to the moving links, in their link frames: for gravity (m, hx, hy, hz) with h = m c, for the full
//! dynamics those and (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about the link frame's origin (Atkeson, An & Hollerbach 1986).

use crate::constants::MAX_JOINTS;
use crate::dynamics::{Motion, Relative, Wrench, each_motion, effort, inward};
use crate::kinematics::Seat;
use crate::lanes::{Lanes, Vec3, cross, rotate, splat3, unrotate};
use crate::motion::{JointsNow, PerJoint, to_coordinates};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Parameters per link of the gravity regressor.
pub const GRAVITY_PARAMETERS: usize = 4;

/// Parameters per link of the full regressor.
pub const PARAMETERS: usize = 10;

/// Writes Y, row-major with one row per coordinate and `P` columns per body, into `out`.
///
/// Column by column: the wrench that one unit of the parameter needs, carried inward to each joint below. `out` holds
/// coordinates × bodies × `P` numbers; what does not fit is left out.
#[inline(always)]
pub(crate) fn regressor<const P: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<1, FUSED>,
    qd: &PerJoint<1, FUSED>,
    qdd: &PerJoint<1, FUSED>,
    base: &Motion<1, FUSED>,
    out: &mut [f64],
) {
    let width = robot.bodies() * P;
    each_motion(
        robot,
        now,
        qd,
        qdd,
        base,
        #[inline(always)]
        |body, motion, relative| {
            for (p, unit) in unit_wrenches(robot, body, motion, relative).into_iter().take(P).enumerate() {
                let tau = to_coordinates(robot, felt(robot, now, body, unit));
                for (row, tau) in out.chunks_exact_mut(width).zip(tau).take(robot.coordinates()) {
                    row[body * P + p] = tau.0[0];
                }
            }
        },
    );
}

/// Efforts at the mechanism's joints for a wrench on `body`.
#[inline(always)]
fn felt<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<1, FUSED>,
    body: usize,
    mut wrench: Wrench<1, FUSED>,
) -> PerJoint<1, FUSED> {
    let mut tau = [Lanes::ZERO; MAX_JOINTS];
    let mut i = body;
    loop {
        tau[i] = effort(robot, i, &wrench);
        if robot.parents[i] == i {
            return tau;
        }
        wrench = inward(&Seat::of(robot, now, i), &wrench);
        i = robot.parents[i];
    }
}

/// Wrenches at the body's origin, in its axes, for one unit of each link parameter.
///
/// In link axes: m: (f, 0); h_k: (dw × e + w × (w × e), e × f); I: (0, E dw + w × E w) with E the unit symmetric matrix.
#[inline(always)]
fn unit_wrenches<const FUSED: bool>(
    robot: &Robot,
    body: usize,
    motion: &Motion<1, FUSED>,
    relative: &Relative<1, FUSED>,
) -> [Wrench<1, FUSED>; PARAMETERS] {
    let link = robot.link_frame(body);
    let (R, p) = (link.pose.rotation(), splat3(link.pose.translation()));
    let (w, dw) = (unrotate(R, &motion.w), unrotate(R, &motion.dw));
    let f = unrotate(R, &relative.at(&p, &motion.f));
    let to_body = |force: Vec3<1, FUSED>, moment: Vec3<1, FUSED>| {
        let force = rotate(R, &force);
        Wrench { force, moment: rotate(R, &moment) + cross(&p, &force) }
    };
    let zero = Vector3::from_element(Lanes::ZERO);
    let first = |k: usize| {
        let mut e = zero;
        e[k] = Lanes::splat(1.0);
        to_body(cross(&dw, &e) + cross(&w, &cross(&w, &e)), cross(&e, &f))
    };
    let second = |a: usize, b: usize| {
        let unit = |v: &Vec3<1, FUSED>| {
            let mut Ev = zero;
            Ev[a] = v[b];
            Ev[b] = v[a];
            Ev
        };
        to_body(zero, unit(&dw) + cross(&w, &unit(&w)))
    };
    [
        to_body(f, zero),
        first(0),
        first(1),
        first(2),
        second(0, 0),
        second(0, 1),
        second(0, 2),
        second(1, 1),
        second(1, 2),
        second(2, 2),
    ]
}
