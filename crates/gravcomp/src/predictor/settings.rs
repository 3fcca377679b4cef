//! What is declared about the target, its sensor and the use of the prediction; checked once.

use crate::error::{SettingsError, within};

/// How positions are predicted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Method {
    /// The last sample.
    Hold,
    /// Constant velocity.
    Velocity,
    /// Constant acceleration.
    Acceleration,
    /// Cycles of one learnt shape whose rate and size vary.
    Periodic,
    /// A weighted sum of what was measured lately, with weights learnt for the horizon.
    Autoregressive,
    /// Sines of fixed frequencies over the band.
    Fourier,
    /// Whichever of them has lately predicted best.
    #[default]
    Switch,
}

impl Method {
    /// All of them but the switch, by number.
    pub const SINGLE: [Self; 6] =
        [Self::Hold, Self::Velocity, Self::Acceleration, Self::Periodic, Self::Autoregressive, Self::Fourier];

    /// Its name in logs.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
            Self::Periodic => "periodic",
            Self::Autoregressive => "autoregressive",
            Self::Fourier => "fourier",
            Self::Switch => "switch",
        }
    }
}

/// Declarations, with the defaults of a camera that watches breathing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Samples per second.
    pub rate_hz: f64,
    /// Numbers of a position: 1 to 3.
    pub axes: usize,
    /// How positions are predicted.
    pub method: Method,
    /// What a sample shows is this much older than its stamp, s.
    pub latency: f64,
    /// How far ahead of the newest sample predictions are mostly asked for, s: what they are tuned for and judged by.
    pub horizon: f64,
    /// Lowest and highest frequency of the cycles, Hz.
    pub band: (f64, f64),
    /// Standard deviation of a sample, m per axis.
    pub noise: f64,
    /// Harmonics of the cycles' shape: 1 to 5.
    pub harmonics: usize,
    /// How fast the target can move, m/s: no prediction is further from the newest sample than this allows.
    pub speed_limit: f64,
    /// A sample that moves the prediction for the horizon further than this is noted as a jump, m.
    pub jump: f64,
    /// Further ahead than this the target is held where it would be then, s.
    pub longest: f64,
    /// Length of the record that the first guess of the cycles is made from, s.
    pub start: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            rate_hz: 30.0,
            axes: 3,
            method: Method::Switch,
            latency: 0.0,
            horizon: 0.1,
            band: (0.08, 1.0),
            noise: 3e-4,
            harmonics: 2,
            speed_limit: 0.5,
            jump: 3e-3,
            longest: 1.0,
            start: 12.0,
        }
    }
}

impl Settings {
    /// The same if they make sense together.
    ///
    /// # Errors
    /// [`SettingsError`] says which field, its value, and what would be right.
    #[allow(clippy::cast_precision_loss)] // a handful
    pub fn checked(self) -> Result<Self, SettingsError> {
        within("rate_hz", self.rate_hz, 1.0, 1e4, "a rate of 1 to 1e4 samples per second")?;
        within("axes", self.axes as f64, 1.0, 3.0, "1, 2 or 3 numbers per position")?;
        within("latency_s", self.latency, 0.0, 10.0, "0 to 10 s")?;
        within("horizon_s", self.horizon, 1e-4, 2.0, "0.0001 to 2 s")?;
        within("longest_s", self.longest, self.horizon, 10.0, "at least horizon_s and at most 10 s")?;
        let (low, high) = self.band;
        within("band (lower end)", low, 0.01, 50.0, "0.01 to 50 Hz")?;
        within("band (upper end)", high, low * 1.5, 100.0, "at least 1.5 times the lower end and at most 100 Hz")?;
        within("band (upper end)", high, 0.0, self.rate_hz / 2.0, "at most half the rate of the samples")?;
        within("noise", self.noise, 1e-7, 1.0, "1e-7 to 1 m per axis")?;
        within("harmonics", self.harmonics as f64, 1.0, 5.0, "1 to 5")?;
        within("speed_limit", self.speed_limit, 1e-3, 100.0, "0.001 to 100 m/s")?;
        within("jump_m", self.jump, 1e-7, 1e3, "1e-7 to 1000 m")?;
        within("start_s", self.start, 0.8 / low, 1e3, "at least 0.8 periods of the band's lower end, at most 1000 s")?;
        Ok(self)
    }
}
