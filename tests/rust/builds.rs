//! The builds of the kernels that this processor can run, as tables of functions.

use gravcomp::control::Kernels;
use gravcomp::resolved_rate::{Inputs, ResolvedRate};
use gravcomp::{BaseMotion, Disturbances, Frame, Gravity, JacobianAxes, Joints, MAX_JOINTS, Robot};
use nalgebra::{Matrix4, Vector3, Vector6};

/// Lanes of the batch kernel that the theorems use.
pub const WIDTH: usize = 8;

pub type Lanes = [[f64; WIDTH]; MAX_JOINTS];

/// One gravity vector per lane.
pub type Fields = [[f64; WIDTH]; 3];

/// One column per coordinate: linear velocity of the frame's origin, then angular velocity.
pub type JacobianColumns = [Vector6<f64>; MAX_JOINTS];

/// A square matrix whose first rows and columns belong to the robot's coordinates.
pub type JointMatrix = [[f64; MAX_JOINTS]; MAX_JOINTS];

pub type BatchKernel = fn(&Robot, &Lanes, &Fields) -> Lanes;

/// Every entry point of one build.
#[derive(Clone, Copy, Debug)]
pub struct Build {
    pub name: &'static str,
    pub gravity_torque: fn(&Robot, &Joints, &Gravity) -> Joints,
    pub gravity_torques: BatchKernel,
    pub disturbance_torque: fn(&Robot, &Disturbances, &Joints, &Joints) -> Joints,
    pub disturbance_regressor: fn(&Robot, &Disturbances, &Joints, &Joints, &mut [f64]),
    pub resolved_rate: fn(&Robot, &mut ResolvedRate, &Inputs<'_>),
    pub forward_kinematics: fn(&Robot, &Joints, &Frame) -> Matrix4<f64>,
    pub write_jacobian: fn(&Robot, &Joints, &Frame, JacobianAxes, &mut [f64]),
    pub inverse_dynamics: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion) -> Joints,
    pub base_wrench: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion) -> Vector6<f64>,
    pub write_mass_matrix: fn(&Robot, &Joints, &mut [f64]),
    pub forward_dynamics: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion) -> Joints,
    pub gravity_regressor: fn(&Robot, &Joints, &Gravity, &mut [f64]),
    pub inverse_dynamics_regressor: fn(&Robot, &Joints, &Joints, &Joints, &BaseMotion, &mut [f64]),
    pub write_gravity_stiffness: fn(&Robot, &Joints, &Gravity, &mut [f64]),
    pub potential_energy: fn(&Robot, &Joints, &Gravity) -> f64,
    pub center_of_mass: fn(&Robot, &Joints) -> Vector3<f64>,
    pub control: Kernels,
}

impl Build {
    pub fn jacobian(&self, robot: &Robot, q: &Joints, frame: &Frame, axes: JacobianAxes) -> JacobianColumns {
        let (n, mut rows) = (robot.coordinates(), [0.0; 6 * MAX_JOINTS]);
        (self.write_jacobian)(robot, q, frame, axes, &mut rows);
        std::array::from_fn(|j| if j < n { Vector6::from_fn(|k, _| rows[k * n + j]) } else { Vector6::zeros() })
    }

    pub fn mass_matrix(&self, robot: &Robot, q: &Joints) -> JointMatrix {
        square(robot.coordinates(), |out| (self.write_mass_matrix)(robot, q, out))
    }

    pub fn gravity_stiffness(&self, robot: &Robot, q: &Joints, g: &Gravity) -> JointMatrix {
        square(robot.coordinates(), |out| (self.write_gravity_stiffness)(robot, q, g, out))
    }
}

/// The entry points of `gravcomp::$module`; `$call!` wraps each call.
macro_rules! build {
    ($module:ident, $call:ident) => {
        Build {
            name: stringify!($module),
            gravity_torque: |r, q, g| $call!(gravcomp::$module::gravity_torque(r, q, g)),
            gravity_torques: |r, q, g| {
                let mut tau = [[0.0; WIDTH]; MAX_JOINTS];
                $call!(gravcomp::$module::gravity_torques(r, q, g, &mut tau));
                tau
            },
            disturbance_torque: |r, all, q, qd| $call!(gravcomp::$module::disturbance_torque(r, all, q, qd)),
            disturbance_regressor: |r, all, q, qd, out| {
                $call!(gravcomp::$module::disturbance_regressor(r, all, q, qd, out));
            },
            resolved_rate: |r, rate, inputs| $call!(gravcomp::$module::resolved_rate(r, rate, inputs)),
            forward_kinematics: |r, q, frame| $call!(gravcomp::$module::forward_kinematics(r, q, frame)),
            write_jacobian: |r, q, frame, axes, out| $call!(gravcomp::$module::jacobian(r, q, frame, axes, out)),
            inverse_dynamics: |r, q, qd, qdd, b| $call!(gravcomp::$module::inverse_dynamics(r, q, qd, qdd, b)),
            base_wrench: |r, q, qd, qdd, b| $call!(gravcomp::$module::base_wrench(r, q, qd, qdd, b)),
            write_mass_matrix: |r, q, out| $call!(gravcomp::$module::mass_matrix(r, q, out)),
            forward_dynamics: |r, q, qd, tau, b| $call!(gravcomp::$module::forward_dynamics(r, q, qd, tau, b)),
            gravity_regressor: |r, q, g, out| $call!(gravcomp::$module::gravity_regressor(r, q, g, out)),
            inverse_dynamics_regressor: |r, q, qd, qdd, b, out| {
                $call!(gravcomp::$module::inverse_dynamics_regressor(r, q, qd, qdd, b, out));
            },
            write_gravity_stiffness: |r, q, g, out| $call!(gravcomp::$module::gravity_stiffness(r, q, g, out)),
            potential_energy: |r, q, g| $call!(gravcomp::$module::potential_energy(r, q, g)),
            center_of_mass: |r, q| $call!(gravcomp::$module::center_of_mass(r, q)),
            control: Kernels {
                cycle: |law, robot, inputs| $call!(gravcomp::control::$module::cycle(law, robot, inputs)),
            },
        }
    };
}

/// The matrix that `compute` writes row by row, in the first rows and columns.
fn square(n: usize, compute: impl FnOnce(&mut [f64])) -> JointMatrix {
    let mut rows = [0.0; MAX_JOINTS * MAX_JOINTS];
    compute(&mut rows);
    std::array::from_fn(|i| std::array::from_fn(|j| if i < n && j < n { rows[i * n + j] } else { 0.0 }))
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
        return Some(|r, q, g| {
            let mut tau = [[0.0; WIDTH]; MAX_JOINTS];
            // SAFETY: AVX-512 F, VL and DQ were detected.
            unsafe { gravcomp::avx512::gravity_torques(r, q, g, &mut tau) };
            tau
        });
    }
    None
}
