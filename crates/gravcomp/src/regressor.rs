//! Torque as a linear function of the inertial parameters: τ = Y π.
//!
//! Parameters belong to the moving links, in their link frames: for gravity (m, hx, hy, hz) with h = m c, for the full
//! dynamics those and (Ixx, Ixy, Ixz, Iyy, Iyz, Izz) about the link frame's origin (Atkeson, An & Hollerbach 1986).

use crate::dynamics::{Motion, Relative, Wrench, each_motion, effort, inward};
use crate::kinematics::Seat;
use crate::lanes::{Lanes, Vec3, cross, rotate, splat3, unrotate};
use crate::motion::{JointsNow, PerJoint};
use crate::robot::Robot;
use nalgebra::{Matrix3, Vector3};

/// Parameters per link of the gravity regressor.
pub const GRAVITY_PARAMETERS: usize = 4;

/// Parameters per link of the full regressor.
pub const PARAMETERS: usize = 10;

/// Parameters whose wrenches are carried inward side by side.
const GROUP: usize = 4;

/// Writes Y, row-major with one row per coordinate and `P` columns per body, into `out`, which has exactly this size.
///
/// Column by column: the wrench that one unit of the parameter needs, carried inward to each joint below. With a coupling,
/// Y = Cᵀ Y_mechanism.
#[inline(always)]
pub(crate) fn regressor<const P: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    qd: &PerJoint<1>,
    qdd: &PerJoint<1>,
    base: &Motion<1, FUSED>,
    out: &mut [f64],
) {
    out.fill(0.0);
    let width = P * robot.bodies();
    each_motion(
        robot,
        now,
        qd,
        qdd,
        base,
        #[inline(always)]
        |body, motion, relative| {
            let mut units = unit_wrenches(robot, body, motion, relative);
            let units = &mut units[..P.div_ceil(GROUP)];
            let mut i = body;
            loop {
                for (group, unit) in units.iter().enumerate() {
                    let first = GROUP * group;
                    let felt = effort(robot, i, unit);
                    put(robot, i, (body * P + first, width), &felt.0[..GROUP.min(P - first)], out);
                }
                if robot.parents[i] == i {
                    break;
                }
                let seat = Seat::of(robot, now, i).wide();
                for unit in units.iter_mut() {
                    *unit = inward(&seat, unit);
                }
                i = robot.parents[i];
            }
        },
    );
}

/// Efforts at joint i of the mechanism, for parameters from column `first` on, where they belong in Y with rows of `width`.
#[inline(always)]
fn put(robot: &Robot, i: usize, (first, width): (usize, usize), efforts: &[f64], out: &mut [f64]) {
    match robot.coupling() {
        None => {
            if let Some(entries) = out.get_mut(i * width + first..).and_then(|rest| rest.get_mut(..efforts.len())) {
                entries.copy_from_slice(efforts);
            }
        }
        Some(coupling) => {
            for (row, along) in out.chunks_exact_mut(width).zip(coupling.columns()) {
                for (entry, effort) in row.iter_mut().skip(first).zip(efforts) {
                    *entry += along[i] * effort;
                }
            }
        }
    }
}

/// Wrenches at the body's origin, in its axes, for one unit of each link parameter, side by side.
///
/// In link axes: m: (f, 0); h_k: (dw × e + w × (w × e), e × f); I: (0, E dw + w × E w) with E the unit symmetric matrix.
#[inline(always)]
fn unit_wrenches<const FUSED: bool>(
    robot: &Robot,
    body: usize,
    motion: &Motion<1, FUSED>,
    relative: &Relative<1, FUSED>,
) -> [Wrench<GROUP, FUSED>; PARAMETERS.div_ceil(GROUP)] {
    let link = robot.link_frame(body);
    let (R, p) = (link.pose.rotation(), link.pose.translation());
    let (w, dw) = (unrotate(R, &motion.w), unrotate(R, &motion.dw));
    let f = unrotate(R, &relative.at(&splat3(p), &motion.f));
    let zero = Vector3::from_element(Lanes::ZERO);
    let first = |k: usize| {
        let mut e = zero;
        e[k] = Lanes::splat(1.0);
        (cross(&dw, &e) + cross(&w, &cross(&w, &e)), cross(&e, &f))
    };
    let second = |a: usize, b: usize| {
        let unit = |v: &Vec3<1, FUSED>| {
            let mut Ev = zero;
            Ev[a] = v[b];
            Ev[b] = v[a];
            Ev
        };
        unit(&dw) + cross(&w, &unit(&w))
    };
    let ((h0, h1, h2), (xx, xy, xz)) = ((first(0), first(1), first(2)), (second(0, 0), second(0, 1), second(0, 2)));
    let (yy, yz, zz) = (second(1, 1), second(1, 2), second(2, 2));
    [
        side_by_side(R, p, [&f, &h0.0, &h1.0, &h2.0], [&zero, &h0.1, &h1.1, &h2.1]),
        side_by_side(R, p, [&zero; GROUP], [&xx, &xy, &xz, &yy]),
        side_by_side(R, p, [&zero; GROUP], [&yz, &zz, &zero, &zero]),
    ]
}

/// Wrenches at the point p, in axes turned by R, as one at the origin.
#[inline(always)]
fn side_by_side<const FUSED: bool>(
    R: &Matrix3<f64>,
    p: &Vector3<f64>,
    forces: [&Vec3<1, FUSED>; GROUP],
    moments: [&Vec3<1, FUSED>; GROUP],
) -> Wrench<GROUP, FUSED> {
    let force = rotate(R, &lanes(forces));
    Wrench { force, moment: rotate(R, &lanes(moments)) + cross(&splat3(p), &force) }
}

#[inline(always)]
fn lanes<const FUSED: bool>([a, b, c, d]: [&Vec3<1, FUSED>; GROUP]) -> Vec3<GROUP, FUSED> {
    Vector3::new(
        Lanes([a.x.0[0], b.x.0[0], c.x.0[0], d.x.0[0]]),
        Lanes([a.y.0[0], b.y.0[0], c.y.0[0], d.y.0[0]]),
        Lanes([a.z.0[0], b.z.0[0], c.z.0[0], d.z.0[0]]),
    )
}
