//! The two ways through a tree of bodies: outward from the base to the tips, inward from the tips to the base.
//!
//! On a serial arm what is passed on stays in registers; on a tree it is looked up at the parent.

use crate::constants::MAX_JOINTS;
use crate::robot::Robot;
use core::ops::AddAssign;

/// Visits the bodies parents first: `visit(i, above)` gets what the parent passed on (`root` on the base) and passes on its own.
#[inline(always)]
pub(crate) fn outward<T: Copy>(robot: &Robot, root: T, mut visit: impl FnMut(usize, &T) -> T) {
    if robot.serial() {
        let mut above = root;
        for i in 0..robot.bodies() {
            above = visit(i, &above);
        }
    } else {
        let mut passed = [root; MAX_JOINTS];
        for i in 0..robot.bodies() {
            let parent = robot.parents[i];
            let above = if parent == i { root } else { passed[parent] };
            passed[i] = visit(i, &above);
        }
    }
}

/// Visits the bodies children first: `visit(i, beyond)` gets the sum of what its children passed on, and passes on its own.
/// Returns the sum at the base.
#[inline(always)]
pub(crate) fn inward<T: Copy + AddAssign>(robot: &Robot, zero: T, mut visit: impl FnMut(usize, T) -> T) -> T {
    let mut root = zero;
    if robot.serial() {
        for i in (0..robot.bodies()).rev() {
            root = visit(i, root);
        }
    } else {
        let mut beyond = [zero; MAX_JOINTS];
        for i in (0..robot.bodies()).rev() {
            let passed = visit(i, beyond[i]);
            let parent = robot.parents[i];
            if parent == i { root += passed } else { beyond[parent] += passed }
        }
    }
    root
}
