//! Gravity torque, kinematics and dynamics of robot arms on bases that tilt, rock or accelerate.
//!
//! After A. Lewis and B. Hannaford, "Dynamically Evaluated Gravity Compensation for the RAVEN Surgical Robot", eqs (1)-(3).
//! Read on: [`gravity`] is the paper on one page, [`dynamics`] the general case, [`robot`] what both compute with.
//!
//! # Promises
//! Construction checks everything and says what is wrong. After it nothing fails, allocates, locks, panics or remembers:
//! the crate is `no_std` without `alloc` and forbids `unsafe`, a [`Robot`] has a fixed capacity of [`MAX_JOINTS`] bodies, and
//! the same inputs give the same bits. NaN in, NaN out.
//!
//! # Signs
//! [`Gravity`] g points down: level (0, 0, −9.80665) m/s². An accelerometer reads the [`SpecificForce`] f = a − g: level and
//! at rest (0, 0, +9.80665). They are different types. A torque τ is what the actuators must exert: τ = +∂U/∂q.
//!
//! # Notation
//! | letter | meaning |
//! |---|---|
//! | B | base frame, z up when the arm is mounted level; q, g, f and ω are given in it |
//! | q, qd, qdd | coordinates and their rates, rad or m |
//! | tau | efforts at the coordinates, N·m or N |
//! | R, p | rotation and translation of a frame in its parent |
//! | m, h, I | mass, first moment m c, inertia about a frame's origin |
//! | u, M | first moment and mass of all that a joint carries |
//! | w, dw, f | angular velocity, angular acceleration, specific force |
//! | c, s, d | cosine and sine of a joint's turn, its shift |
//! | C, c₀ | coupling: q_mechanism = C q + c₀, τ = Cᵀ τ_mechanism |
//!
//! # Layers
//! A module uses only modules of lower floors, or those named before it on its own: 0 `constants`, `error`; 1 `lanes`, `trig`,
//! `spatial`, `slot`, `flags`; 2 `box_qp`, `joint`, `dh`, `coupling`, `base`; 3 `robot`; 4 `sweep`, `motion`, `kinematics`,
//! `manipulability`, `jacobian`, `gravity`, `dynamics`, `regressor`, `energy`, `transmission`, `elastic`, `disturbance`, `resolved_rate`,
//! `entry`;
//! 5 `predictor`, `accelerometer`; 6 `control`.
#![no_std]
#![forbid(unsafe_code)]
// Frames and matrices carry the capitals of the literature.
#![allow(non_snake_case)]
// The kernels are one text inlined into the functions compiled for each processor.
#![allow(clippy::inline_always)]

pub mod accelerometer;
pub mod base;
pub mod box_qp;
pub mod constants;
pub mod control;
pub mod coupling;
pub mod dh;
pub mod disturbance;
pub mod dynamics;
pub mod elastic;
mod energy;
mod entry;
pub mod error;
mod flags;
pub mod gravity;
mod jacobian;
pub mod joint;
mod kinematics;
pub mod lanes;
pub mod manipulability;
mod motion;
pub mod predictor;
mod regressor;
pub mod resolved_rate;
pub mod robot;
pub mod slot;
pub mod spatial;
mod sweep;
pub mod transmission;
pub mod trig;

pub use accelerometer::{Accelerometer, Reading};
pub use base::{BaseMotion, Gravity, ImuSample, Mounting, SpecificForce};
pub use constants::{MAX_JOINTS, STANDARD_GRAVITY};
pub use control::Controller;
pub use coupling::Coupling;
pub use dh::{DhRow, Placement};
pub use disturbance::Disturbances;
pub use elastic::ElasticGravity;
pub use entry::portable;
#[cfg(target_arch = "x86_64")]
pub use entry::{avx2, avx512};
pub use error::ModelError;
pub use jacobian::JacobianAxes;
pub use joint::Joint;
pub use predictor::Predictor;
pub use regressor::{GRAVITY_PARAMETERS, PARAMETERS};
pub use resolved_rate::ResolvedRate;
pub use robot::{Carrier, Frame, Joints, Robot, RobotBuilder};
pub use slot::Slot;
pub use spatial::{Inertia, Pose};
pub use transmission::Transmission;
