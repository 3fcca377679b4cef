//! `ravengc._core`: the compiled part of the Python package. Arguments are checked here; the maths is in `gravcomp`.
#![allow(clippy::inline_always)]
// PyO3 hands over arguments by value and methods by reference, and `getter` methods cannot be associated constants.
#![allow(clippy::needless_pass_by_value, clippy::unused_self, clippy::missing_errors_doc, missing_docs)]

mod accelerometer;
mod arrays;
mod batch;
mod control_cycle;
mod controller;
mod cycle;
mod dispatch;
mod disturbance;
mod elastic;
mod errors;
mod predictor;
mod present;
mod rate_cycle;
mod rates;
mod resolved_rate;
mod robot;
mod rows;
mod shared;
mod spec;
mod types;

/// The compiled core of ravengc.
#[pyo3::pymodule(gil_used = false)]
mod _core {
    use super::dispatch::Level;
    use pyo3::prelude::*;

    #[pymodule_export]
    use super::accelerometer::Accelerometer;
    #[pymodule_export]
    use super::batch::{
        base_wrench_batch, center_of_mass_batch, forward_dynamics_batch, forward_kinematics_batch,
        gravity_regressor_batch, gravity_stiffness_batch, gravity_torque_batch, inverse_dynamics_batch,
        inverse_dynamics_regressor_batch, jacobian_batch, mass_matrix_batch, potential_energy_batch,
    };
    #[pymodule_export]
    use super::control_cycle::ControlCycle;
    #[pymodule_export]
    use super::controller::Controller;
    #[pymodule_export]
    use super::cycle::{Cycle, bind_forward_kinematics, bind_gravity_torque, bind_inverse_dynamics, bind_jacobian};
    #[pymodule_export]
    use super::disturbance::{disturbance_regressor_batch, disturbance_torque_batch};
    #[pymodule_export]
    use super::elastic::{ElasticCycle, ElasticGravity, bind_elastic_gravity, gravity_stiffness_bound};
    #[pymodule_export]
    use super::predictor::{Predictor, PredictorCycle};
    #[pymodule_export]
    use super::rate_cycle::RateCycle;
    #[pymodule_export]
    use super::rates::{ascend, box_minimum, manipulability};
    #[pymodule_export]
    use super::resolved_rate::ResolvedRate;
    #[pymodule_export]
    use super::robot::Robot;
    #[pymodule_export]
    use super::types::{BaseMotion, Gravity, Mounting, SpecificForce};

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("EVENTS", super::controller::event_meanings(module.py())?)?;
        module.add("FAULTS", super::accelerometer::fault_meanings(module.py())?)?;
        module.add("INSTRUCTIONS", Level::get().name())?;
        module.add("NOTES", super::predictor::note_meanings(module.py())?)?;
        module.add("RATE_EVENTS", super::resolved_rate::event_meanings(module.py())?)?;
        module.add("MAX_JOINTS", gravcomp::MAX_JOINTS)?;
        module.add("STANDARD_GRAVITY", gravcomp::STANDARD_GRAVITY)
    }
}
