//! The builds of the kernels that this processor can run, as tables of functions.

use gravcomp::{BaseMotion, Frame, Gravity, JacobianAxes, JacobianColumns, JointMatrix, Joints, MAX_JOINTS, Robot};
use nalgebra::{Matrix4, Vector3, Vector6};

/// Lanes of the batch kernel that the theorems use.
pub const WIDTH: usize = 8;

pub type Lanes = [[f64; WIDTH]; MAX_JOINTS];

/// One gravity vector per lane.
pub type Fields = [[f64; WIDTH]; 3];

pub type BatchKernel = fn(&Robot, &Lanes, &Fields) -> Lanes;

/// Every entry point of one build.
#[derive(Clone, Copy, Debug)]
pub struct Build {
    pub name: &'static str,
    pub gravity_torque: fn(&Robot, &Joints, &Gravity) -> Joints,
    pub gravity_torques: BatchKernel,
    pub forward_kinematics: fn(&Robot, &Joints, &Frame) -> Matrix4<f64>,
    pub jacobian: fn(&Robot, &Joints, &Frame, JacobianAxes) -> JacobianColumns,
    pub inverse_dynamics: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion) -> Joints,
    pub base_wrench: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion) -> Vector6<f64>,
    pub mass_matrix: fn(&Robot, &Joints) -> JointMatrix,
    pub forward_dynamics: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion) -> Joints,
    pub gravity_regressor: fn(&Robot, &Joints, &Gravity, &mut [f64]),
    pub inverse_dynamics_regressor: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion, &mut [f64]),
    pub gravity_stiffness: fn(&Robot, &Joints, &Gravity) -> JointMatrix,
    pub potential_energy: fn(&Robot, &Joints, &Gravity) -> f64,
    pub center_of_mass: fn(&Robot, &Joints) -> Vector3<f64>,
}

/// The entry points of `gravcomp::$module`; `$call!` wraps each call.
macro_rules! build {
    ($module:ident, $call:ident) => {
        Build {
            name: stringify!($module),
            gravity_torque: |r, q, g| $call!(gravcomp::$module::gravity_torque(r, q, g)),
            gravity_torques: |r, q, g| $call!(gravcomp::$module::gravity_torques(r, q, g)),
            forward_kinematics: |r, q, frame| $call!(gravcomp::$module::forward_kinematics(r, q, frame)),
            jacobian: |r, q, frame, axes| $call!(gravcomp::$module::jacobian(r, q, frame, axes)),
            inverse_dynamics: |r, q, qd, qdd, b| $call!(gravcomp::$module::inverse_dynamics(r, q, qd, qdd, b)),
            base_wrench: |r, q, qd, qdd, b| $call!(gravcomp::$module::base_wrench(r, q, qd, qdd, b)),
            mass_matrix: |r, q| $call!(gravcomp::$module::mass_matrix(r, q)),
            forward_dynamics: |r, q, qd, tau, b| $call!(gravcomp::$module::forward_dynamics(r, q, qd, tau, b)),
            gravity_regressor: |r, q, g, out| $call!(gravcomp::$module::gravity_regressor(r, q, g, out)),
            inverse_dynamics_regressor: |r, q, qd, qdd, b, out| {
                $call!(gravcomp::$module::inverse_dynamics_regressor(r, q, qd, qdd, b, out));
            },
            gravity_stiffness: |r, q, g| $call!(gravcomp::$module::gravity_stiffness(r, q, g)),
            potential_energy: |r, q, g| $call!(gravcomp::$module::potential_energy(r, q, g)),
            center_of_mass: |r, q| $call!(gravcomp::$module::center_of_mass(r, q)),
        }
    };
}

macro_rules! plain {
    ($call:expr) => {
        $call
    };
}

pub const PORTABLE: Build = build!(portable, plain);

/// The build for AVX2 and FMA where this processor has them.
#[cfg(target_arch = "x86_64")]
pub fn avx2() -> Option<Build> {
    macro_rules! detected {
        ($call:expr) => {
            // SAFETY: the table is only handed out below, where AVX2 and FMA were detected.
            unsafe { $call }
        };
    }
    let found = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    found.then_some(build!(avx2, detected))
}

/// The build for AVX2 and FMA: not on this kind of processor.
#[cfg(not(target_arch = "x86_64"))]
pub fn avx2() -> Option<Build> {
    None
}

/// All builds that this processor runs.
pub fn builds() -> impl Iterator<Item = Build> {
    std::iter::once(PORTABLE).chain(avx2())
}

/// The batch kernel for AVX-512 where this processor has it.
pub fn avx512_gravity_torques() -> Option<BatchKernel> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq")
    {
        // SAFETY: AVX-512 F, VL and DQ were detected.
        return Some(|r, q, g| unsafe { gravcomp::avx512::gravity_torques(r, q, g) });
    }
    None
}
