//! A second-order Butterworth low-pass in continuous time, stepped exactly over whatever lies between two samples.
//!
//! > ẍ = ω² (u − x) − √2 ω ẋ,  ω = 2π f_c,  |H(f)| = 1 / √(1 + (f / f_c)⁴)
//!
//! Between two samples the input is the straight line u₀ + u̇ t. On it x = u − (√2/ω) u̇, ẋ = u̇ solves the equation, so that
//! the difference e from that solution only swings out: with a = ω/√2 (the poles are −a ± ja)
//!
//! > e(t) = e^(−at) ((cos at + sin at) e₀ + (sin at / a) ė₀)
//! > ė(t) = e^(−at) ((cos at − sin at) ė₀ − 2a sin at e₀)
//!
//! Sample times may be irregular: no time step is assumed anywhere. ẋ is the filtered derivative of the input, for nothing.

use core::f64::consts::{PI, SQRT_2};
use nalgebra::{ComplexField, Vector3};

/// What swings out between two samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Swing {
    a: f64,
    dt: f64,
    /// e^(−at) cos at and e^(−at) sin at.
    cos: f64,
    sin: f64,
}

impl Swing {
    /// Over `dt` > 0 seconds, with the cut-off in Hz.
    pub(super) fn new(cutoff_hz: f64, dt: f64) -> Self {
        // ω/√2 = √2 π f_c
        let a = SQRT_2 * PI * cutoff_hz;
        let (sin, cos) = ComplexField::sin_cos(a * dt);
        let decay = ComplexField::exp(-a * dt);
        Self { a, dt, cos: decay * cos, sin: decay * sin }
    }
}

/// Three channels of the filter.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Butterworth {
    input: Vector3<f64>,
    value: Vector3<f64>,
    slope: Vector3<f64>,
}

impl Butterworth {
    /// At rest, as if `input` had always been there.
    pub(super) fn resting(input: Vector3<f64>) -> Self {
        Self { input, value: input, slope: Vector3::zeros() }
    }

    /// On to the next input.
    pub(super) fn after(&self, input: Vector3<f64>, swing: &Swing) -> Self {
        let Swing { a, dt, cos, sin } = *swing;
        let ramp = (input - self.input) / dt;
        // √2/ω = 1/a
        let lag = ramp / a;
        let (e, de) = (self.value - (self.input - lag), self.slope - ramp);
        let value = input - lag + (cos + sin) * e + (sin / a) * de;
        let slope = ramp + (cos - sin) * de - (2.0 * a * sin) * e;
        Self { input, value, slope }
    }

    /// u, as it came last.
    pub(super) const fn input(&self) -> Vector3<f64> {
        self.input
    }

    /// x, in the input's unit.
    pub(super) const fn value(&self) -> Vector3<f64> {
        self.value
    }

    /// ẋ, in the input's unit per second.
    pub(super) const fn slope(&self) -> Vector3<f64> {
        self.slope
    }
}
