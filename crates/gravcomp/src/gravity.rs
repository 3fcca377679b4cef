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
use crate::motion::{JointsNow, to_coordinates};
use crate::robot::Robot;

/// Eqs (1)-(3) for the efforts at the coordinates; `g` in base axes.
#[inline(always)]
pub(crate) fn gravity_torque<const W: usize, const FUSED: bool>(
    robot: &Robot,
    now: &JointsNow<W, FUSED>,
    g: Vec3<W, FUSED>,
) -> [Lanes<W, FUSED>; MAX_JOINTS] {
    let effort = if robot.serial() { along_chain(robot, now, g) } else { along_tree(robot, now, g) };
    to_coordinates(robot, &effort)
}

/// One body's share: g in its axes and the moment u that it carries give the effort at its joint.
#[inline(always)]
fn effort<const W: usize, const FUSED: bool>(robot: &Robot, i: usize, g: &Vec3<W, FUSED>, u: &Vec3<W, FUSED>) -> Lanes<W, FUSED> {
    let load = &robot.loads[i];
    let torque = u.y.mul_add(g.x, -(u.x * g.y));
    Lanes::splat(load.turning).mul_add(torque, -(Lanes::splat(load.sliding) * g.z))
}

/// `Rᵢᵀ g`.
#[inline(always)]
fn outward<const W: usize, const FUSED: bool>(robot: &Robot, now: &JointsNow<W, FUSED>, i: usize, g: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
    unturn_z(now.c[i], now.s[i], &unrotate(&robot.loads[i].rotation, g))
}

/// `Rᵢ u + Mᵢ pᵢ`.
#[inline(always)]
fn inward<const W: usize, const FUSED: bool>(robot: &Robot, now: &JointsNow<W, FUSED>, i: usize, u: &Vec3<W, FUSED>) -> Vec3<W, FUSED> {
    let load = &robot.loads[i];
    let mut turned = turn_z(now.c[i], now.s[i], u);
    turned.z = Lanes::splat(load.carried).mul_add(now.d[i], turned.z);
    rotate_add(&load.rotation, &turned, &splat3(&load.offset_moment))
}

/// Serial arms: both sweeps stay in registers.
#[inline(always)]
fn along_chain<const W: usize, const FUSED: bool>(robot: &Robot, now: &JointsNow<W, FUSED>, g: Vec3<W, FUSED>) -> [Lanes<W, FUSED>; MAX_JOINTS] {
    let n = robot.bodies();
    let mut g_in = [Vec3::from_element(Lanes::ZERO); MAX_JOINTS];
    let mut g = g;
    for i in 0..n {
        g = outward(robot, now, i, &g);
        g_in[i] = g;
    }
    let mut tau = [Lanes::ZERO; MAX_JOINTS];
    let mut beyond = Vec3::from_element(Lanes::ZERO);
    for i in (0..n).rev() {
        let u = beyond + splat3(&robot.loads[i].first_moment);
        tau[i] = effort(robot, i, &g_in[i], &u);
        beyond = inward(robot, now, i, &u);
    }
    tau
}

/// Trees: the same with the parent looked up.
#[inline(always)]
fn along_tree<const W: usize, const FUSED: bool>(robot: &Robot, now: &JointsNow<W, FUSED>, g: Vec3<W, FUSED>) -> [Lanes<W, FUSED>; MAX_JOINTS] {
    let n = robot.bodies();
    let mut g_in = [Vec3::from_element(Lanes::ZERO); MAX_JOINTS];
    for i in 0..n {
        let parent = robot.parents[i];
        let above = if parent == i { g } else { g_in[parent] };
        g_in[i] = outward(robot, now, i, &above);
    }
    let mut tau = [Lanes::ZERO; MAX_JOINTS];
    let mut u = [Vec3::from_element(Lanes::ZERO); MAX_JOINTS];
    for i in (0..n).rev() {
        let own = u[i] + splat3(&robot.loads[i].first_moment);
        tau[i] = effort(robot, i, &g_in[i], &own);
        let parent = robot.parents[i];
        if parent != i {
            u[parent] += inward(robot, now, i, &own);
        }
    }
    tau
}
