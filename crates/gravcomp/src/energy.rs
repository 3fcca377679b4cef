//! Potential energy of gravity and what follows from it: centre of mass and the stiffness of the gravity torque.

use crate::constants::MAX_JOINTS;
use crate::dynamics::congruent;
use crate::kinematics::{Axes, vector};
use crate::lanes::{Lanes, Vec3, cross, dot, scale};
use crate::motion::JointsNow;
use crate::robot::Robot;
use crate::sweep;

/// Mass (kg) and first moment about the base origin (kg·m, base axes) of everything that moves.
#[inline(always)]
pub(crate) fn moment<const FUSED: bool>(robot: &Robot, now: &JointsNow<'_, 1, FUSED>) -> (f64, Vec3<1, FUSED>) {
    let (mut mass, mut moment) = (0.0, Lanes::ZERO);
    each_body(
        robot,
        now,
        #[inline(always)]
        |i, axes| {
            let own = robot.links[i].mass;
            mass += own;
            moment += axes.rotate(robot.loads[i].first_moment.into()) + axes.origin * own.into();
        },
    );
    (mass, vector(&moment))
}

/// Calls `visit` with each body's axes in B, parents first.
#[inline(always)]
fn each_body<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    mut visit: impl FnMut(usize, &Axes<FUSED>),
) {
    sweep::outward(
        robot,
        Axes::BASE,
        #[inline(always)]
        |i, above| {
            let axes = above.carry(robot, now, i);
            visit(i, &axes);
            axes
        },
    );
}

/// Writes ∂τ_g/∂q, coordinates × coordinates, into `out`, which has exactly this size: the Hessian of U = −Σ m g·p.
///
/// For joint i on the path to joint j (i = j included) with unit axes z, U's second derivative is −g · (z_i × D_j): D_j is
/// how unit motion of joint j moves the first moment that it carries, z_j × u_j if it turns and M_j z_j if it slides.
/// A sliding joint i turns nothing: 0. Joints on different branches do not meet: 0. With a coupling, Cᵀ K C.
#[inline(always)]
pub(crate) fn gravity_stiffness<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, 1, FUSED>,
    g: &Vec3<1, FUSED>,
    out: &mut [f64],
) {
    let zero = Vec3::from_element(Lanes::ZERO);
    let (mut z, mut origin, mut u) = ([zero; MAX_JOINTS], [zero; MAX_JOINTS], [zero; MAX_JOINTS]);
    each_body(
        robot,
        now,
        #[inline(always)]
        |i, axes| {
            z[i] = vector(&axes.z);
            origin[i] = vector(&axes.origin);
            u[i] = vector(&axes.rotate(robot.loads[i].first_moment.into()));
        },
    );
    congruent::<FUSED>(
        robot,
        out,
        #[inline(always)]
        |matrix| {
            sweep::inward(
                robot,
                zero,
                #[inline(always)]
                |j, beyond| {
                    let load = &robot.loads[j];
                    let u = u[j] + beyond;
                    let carried = if load.slides { scale(load.carried.into(), &z[j]) } else { cross(&z[j], &u) };
                    for i in 0..=j {
                        if robot.carries(i, j) && !robot.loads[i].slides {
                            matrix.put(i, j, -dot(g, &cross(&z[i], &carried)));
                        }
                    }
                    u + scale(load.carried.into(), &(origin[j] - origin[robot.parents[j]]))
                },
            );
        },
    );
}
