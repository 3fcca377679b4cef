//! Where a moving target will be.

mod chain;
mod kinematic;
mod periodic;
mod settings;
mod spectrum;
mod status;
mod stream;

pub use chain::Predictor;
pub use settings::{Method, Settings, SettingsError};
pub use status::{Counters, Note, Notes};

/// A position, m, or a velocity, m/s; axes that a target does not have are zero.
pub type Point = nalgebra::Vector3<f64>;

/// Densities of the pushes that a target is believed to get, in units of m and s.
const SMALLEST_DENSITY: f64 = 1e-9;
const LARGEST_DENSITY: f64 = 1e3;

/// A position and its velocity.
#[derive(Clone, Copy, Debug, Default)]
struct Moving {
    position: Point,
    velocity: Point,
}
