//! The paper's gravity torque, one page.
//!
//! Lewis & Hannaford, eqs (1)-(3): with everything expressed in frame i, whose z-axis is joint i's axis, the effort that
//! holds joint i against the links k that it carries is
//!
//! > τᵢ = −ẑ · Σₖ rₖ × mₖ g for a revolute joint (1), fᵢ = −ẑ · Σₖ mₖ g for a prismatic one (3), ⁱg = ⁱR_B ᴮg (2).
//!
//! The sums telescope. Let uᵢ = Σₖ mₖ rₖ (about the origin of frame i) and Mᵢ = Σₖ mₖ. Then
//!
//! > gᵢ = Rᵢᵀ g_parent        outward, from the base to the tips: eq. (2) one joint at a time,
//! > u_parent += Rᵢ uᵢ + Mᵢ pᵢ    inward, from the tips to the base: the sum of eq. (1),
//! > τᵢ = −ẑ · uᵢ × gᵢ = u_y g_x − u_x g_y,  fᵢ = −Mᵢ g_z,
//!
//! where Rᵢ = F Rz(q) and pᵢ place frame i in its parent. Neither sweep waits for the other, mₖ cₖ and Mᵢ pᵢ are constants,
//! and a prismatic joint only adds F (0, 0, Mᵢ q): 315 floating-point operations for seven joints.

use crate::constants::MAX_JOINTS;
use crate::lanes::{Lanes, Vec3, rotate_add, splat3, turn_z, unrotate, unturn_z};
use crate::motion::{JointsNow, PerJoint, to_coordinates};
use crate::robot::Robot;
use crate::sweep;

/// Eqs (1)-(3): writes the efforts at the coordinates into `tau`; `g` in base axes.
#[inline(always)]
pub(crate) fn gravity_torque<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<'_, W, FUSED>,
    g: Vec3<W, FUSED>,
    tau: &mut PerJoint<W>,
) {
    let zero = Vec3::from_element(Lanes::ZERO);
    let mut g_in = [zero; MAX_JOINTS];
    sweep::outward(
        robot,
        g,
        #[inline(always)]
        |i, g| {
            g_in[i] = unturn_z(now.c[i], now.s[i], &unrotate(&robot.loads[i].rotation, g));
            g_in[i]
        },
    );
    sweep::inward(
        robot,
        zero,
        #[inline(always)]
        |i, beyond| {
            let load = &robot.loads[i];
            let (mut u, g) = (beyond + splat3(&load.first_moment), &g_in[i]);
            if load.slides {
                // 0 c u_x is 0, or NaN where a position here (c = 1) or beyond is no number.
                let nothing = Lanes::ZERO * now.c[i] * u.x;
                tau[i] = Lanes::splat(-load.carried).mul_add(g.z, nothing).0;
                u.z = Lanes::splat(load.carried).mul_add(now.slide(i), u.z);
            } else {
                tau[i] = u.y.mul_add(g.x, -(u.x * g.y)).0;
                u = turn_z(now.c[i], now.s[i], &u);
            }
            rotate_add(&load.rotation, &u, &splat3(&load.offset_moment))
        },
    );
    to_coordinates::<W, FUSED>(robot, tau);
}
