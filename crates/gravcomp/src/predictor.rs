//! Where a moving target will be: breathing organs, beating hearts, whatever a camera sees late and in noise.
//!
//! [`Predictor::update`] takes a sample when one comes, [`Predictor::predict`] is asked in every control cycle. Both are total:
//! whatever comes in, a prediction is finite and no further from the newest sample than the declared speed allows, and
//! [`Notes`] say what was found.
//!
//! # Methods
//! | method | model |
//! |---|---|
//! | `Hold` | the newest sample |
//! | `Velocity`, `Acceleration` | kept until pushed, by pushes as large as they have lately been |
//! | `Periodic` | cycles of one learnt shape; each has its own rate and size, which it chooses where it rests |
//! | `Autoregressive` | a weighted sum of the past, the weights learnt for the very horizon |
//! | `Fourier` | sines of fixed frequencies over the band |
//! | `Switch` | those that have lately predicted best at the horizon |
//!
//! # The stream
//! Stamps order the samples, not the time at which they come: late and dropped ones need no care. Repeated and older ones are
//! refused; a stamp far ahead or a position far off waits until the next sample confirms it; three older stamps in a row mean
//! that the clock was set, and everything begins anew. `benches/predictions.py` prints how well each method does.
#![allow(clippy::cast_precision_loss)] // counts of bins, axes and harmonics, all below a thousand

mod autoregressive;
mod chain;
mod fourier;
mod kinematic;
mod past;
mod periodic;
mod settings;
mod spectrum;
mod status;
mod stream;
mod switch;

pub use crate::error::SettingsError;
pub use chain::Predictor;
pub use settings::{Method, Settings};
pub use status::{Counters, Note, Notes};

/// A position, m, or a velocity, m/s; axes that a target does not have are zero.
pub type Point = nalgebra::Vector3<f64>;

/// Methods that are no switch.
const METHODS: usize = 6;

/// Densities of the pushes that a target is believed to get, in units of m and s.
const SMALLEST_DENSITY: f64 = 1e-9;
const LARGEST_DENSITY: f64 = 1e3;

/// A position and its velocity.
#[derive(Clone, Copy, Debug, Default)]
struct Moving {
    position: Point,
    velocity: Point,
}

impl Moving {
    fn standing(position: Point) -> Self {
        Self { position, velocity: Point::zeros() }
    }

    /// Where it is `dt` seconds later.
    fn after(&self, dt: f64) -> Point {
        self.position + self.velocity * dt
    }

    fn is_finite(&self) -> bool {
        self.position.iter().chain(&self.velocity).all(|x| x.is_finite())
    }

    /// Brings it to where a target can be that was at `newest`, `ahead` seconds before (or after); true where it was not.
    fn limit(&mut self, newest: &Point, ahead: f64, settings: &Settings) -> bool {
        if !self.is_finite() {
            *self = Self::standing(*newest);
            return true;
        }
        let away = self.position - newest;
        let reach = settings.speed_limit * ahead.abs() + 10.0 * settings.noise;
        let is_far = away.norm() > reach;
        if is_far {
            self.position = newest + away * (reach / away.norm());
        }
        let speed = self.velocity.norm();
        let is_fast = speed > settings.speed_limit;
        if is_fast {
            self.velocity *= settings.speed_limit / speed;
        }
        is_far || is_fast
    }
}
