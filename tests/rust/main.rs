//! Theorems about `gravcomp`: what must hold for every robot, pose and base motion, whoever computes it.
//!
//! Robots are drawn at random ([`arms`]); each theorem runs on every build of the kernels that this processor has
//! ([`builds`]); how far rounding may carry a result is derived from the robot's size ([`scale`]).
#![allow(non_snake_case)] // M, C, R, J: the matrices of the literature

mod accelerometer;
mod accelerometer_campaign;
mod accelerometer_gyro;
mod accelerometer_signal;
mod accelerometer_stories;
mod accelerometer_trust;
mod arms;
mod bad_numbers;
mod base_motion;
mod box_qp;
mod builds;
mod construction;
mod control;
mod control_arming;
mod control_elastic;
mod control_encoder;
mod control_limits;
mod coupling;
mod disturbance;
mod double_double;
mod dynamics;
mod elastic;
mod gravity;
mod kinematics;
mod manipulability;
mod no_heap;
mod predictor;
mod predictor_stream;
mod regressors;
mod resolved_rate;
mod resolved_rate_limits;
mod resolved_rate_sensed;
mod same_arm;
mod same_bits;
mod scale;
mod settings;
mod slot;
mod transmission;
mod trig;
