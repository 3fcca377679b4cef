//! Potential energy of gravity and what follows from it: centre of mass and the stiffness of the gravity torque.

use crate::constants::MAX_JOINTS;
use crate::dynamics::{Square, congruent};
use crate::kinematics::Axes;
use crate::lanes::{Lanes, Vec3, cross, dot, scale, splat3};
use crate::motion::JointsNow;
use crate::robot::Robot;
use crate::sweep;

/// Mass (kg) and first moment about the base origin (kg·m, base axes) of everything that moves.
#[inline(always)]
pub(crate) fn moment<const FUSED: bool>(robot: &Robot, now: &JointsNow<1, FUSED>) -> (f64, Vec3<1, FUSED>) {
    let (mut mass, mut moment) = (0.0, Vec3::from_element(Lanes::ZERO));
    each_body(
        robot,
        now,
        #[inline(always)]
        |i, axes| {
            let link = &robot.links[i];
            mass += link.mass;
            moment += scale(link.mass.into(), &axes.origin) + axes.rotate(&splat3(&robot.loads[i].first_moment));
        },
    );
    (mass, moment)
}

/// Calls `visit` with each body's axes in B, parents first.
#[inline(always)]
fn each_body<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<1, FUSED>,
    mut visit: impl FnMut(usize, &Axes<1, FUSED>),
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

/// ∂τ_g/∂q, symmetric: the Hessian of the potential energy U = −Σ m g·p.
///
/// For joint i on the path to joint j (i = j included) with unit axes z, U's second derivative is −g · (z_i × D_j): D_j is
/// how unit motion of joint j moves the first moment that it carries, z_j × u_j if it turns and M_j z_j if it slides.
/// A sliding joint i turns nothing: 0. Joints on different branches do not meet: 0. With a coupling, Cᵀ K C.
#[inline(always)]
pub(crate) fn gravity_stiffness<const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<1, FUSED>,
    g: &Vec3<1, FUSED>,
) -> Square<1, FUSED> {
    let zero = Vec3::from_element(Lanes::ZERO);
    let (mut z, mut origin, mut u) = ([zero; MAX_JOINTS], [zero; MAX_JOINTS], [zero; MAX_JOINTS]);
    each_body(
        robot,
        now,
        #[inline(always)]
        |i, axes| {
            z[i] = axes.z;
            origin[i] = axes.origin;
            u[i] = axes.rotate(&splat3(&robot.loads[i].first_moment));
        },
    );
    let mut matrix = [[Lanes::ZERO; MAX_JOINTS]; MAX_JOINTS];
    sweep::inward(
        robot,
        zero,
        #[inline(always)]
        |j, beyond| {
            let load = &robot.loads[j];
            let u = u[j] + beyond;
            let carried = scale(load.turning.into(), &cross(&z[j], &u)) + scale(load.sliding.into(), &z[j]);
            for i in 0..=j {
                if robot.ancestors[j] >> i & 1 == 1 {
                    let turning = Lanes::splat(-robot.turning[i]);
                    matrix[i][j] = turning * dot(g, &cross(&z[i], &carried));
                    matrix[j][i] = matrix[i][j];
                }
            }
            u + scale(load.carried.into(), &(origin[j] - origin[robot.parents[j]]))
        },
    );
    congruent(robot, &matrix)
}
