//! φ(s, ṡ): how the effort of an element depends on where its joint is and how fast it moves.

use super::blend::{Blend, Direction};
use crate::error::{SettingsError, within};
use crate::lanes::Lanes;
use crate::trig;
use nalgebra::ComplexField;

/// Most coefficients of a polynomial.
pub const MAX_COEFFICIENTS: usize = 10;

/// Most knots of a cable.
pub const MAX_KNOTS: usize = 8;

/// Where s is clamped into; infinite for no end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The lower end, rad or m.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

impl Range {
    /// Everywhere.
    pub const ALL: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY };

    fn check(self) -> Result<(), SettingsError> {
        if self.low < self.high {
            return Ok(());
        }
        Err(SettingsError {
            field: "range",
            joint: None,
            value: self.high,
            wanted: "with an upper end above the lower",
        })
    }

    /// s, or the end that it is beyond; NaN stays.
    #[inline(always)]
    fn clamp(self, s: f64) -> f64 {
        let raised = if s < self.low { self.low } else { s };
        if raised > self.high { self.high } else { raised }
    }
}

/// Polynomials between knots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pieces {
    knots: [f64; MAX_KNOTS],
    count: usize,
    /// Where the coefficients of each piece start, and the last one's end.
    starts: [usize; MAX_KNOTS + 2],
}

impl Pieces {
    /// `lengths` are the numbers of coefficients of the pieces, one more than there are knots, from the left.
    ///
    /// # Errors
    /// [`SettingsError`] for knots that do not rise, and for numbers of them that do not fit.
    pub fn new(knots: &[f64], lengths: &[usize]) -> Result<Self, SettingsError> {
        let refused = |field, value, wanted| Err(SettingsError { field, joint: None, value, wanted });
        #[allow(clippy::cast_precision_loss)] // counts
        let (found, polynomials) = (knots.len() as f64, lengths.len() as f64);
        within("knots", found, 1.0, 8.0, "1 to 8 of them")?;
        if lengths.len() != knots.len() + 1 {
            return refused("pieces", polynomials, "one more than there are knots");
        }
        if let Some(pair) = knots.windows(2).find(|pair| pair[0] >= pair[1]) {
            return refused("knots", pair[1], "above the one before it");
        }
        let mut pieces = Self { knots: [0.0; MAX_KNOTS], count: knots.len(), starts: [0; MAX_KNOTS + 2] };
        for (place, &knot) in pieces.knots.iter_mut().zip(knots) {
            within("knots", knot, -super::LARGEST, super::LARGEST, "a finite number of at most 1e9")?;
            *place = knot;
        }
        for (i, &length) in lengths.iter().enumerate() {
            check_length(length)?;
            pieces.starts[i + 1] = pieces.starts[i] + length;
        }
        Ok(pieces)
    }

    /// Calls `give` with the powers in the piece that holds s.
    #[inline(always)]
    fn values(&self, s: f64, give: impl FnMut(usize, f64)) {
        let mut holds = 0;
        for &knot in self.knots.iter().take(self.count) {
            holds += usize::from(s >= knot);
        }
        let origin = self.knots.get(holds.saturating_sub(1)).copied().unwrap_or(0.0);
        if let Some(&[start, end]) = self.starts.get(holds..holds + 2).and_then(|ends| ends.first_chunk()) {
            powers(s - origin, 1.0, start, end, give);
        }
    }
}

/// How an effort depends on s and ṡ: see [`super`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Σ c_k s^k in a direction of motion.
    Polynomial {
        /// In which.
        direction: Direction,
        /// How it is told.
        blend: Blend,
        /// Where the coefficients were found.
        range: Range,
    },
    /// A polynomial between each two knots, in powers of s minus the knot on its left (of the first piece, the first knot).
    Cable {
        /// The knots.
        pieces: Pieces,
        /// Where the coefficients were found.
        range: Range,
    },
    /// k (s − rest).
    LinearSpring {
        /// Where it gives nothing, rad or m.
        rest: f64,
    },
    /// Coulomb, viscous and Stribeck friction.
    Friction {
        /// The direction of motion.
        blend: Blend,
        /// The velocity at which what breaking loose takes has fallen to 1/e, rad/s or m/s.
        stribeck: Option<f64>,
    },
    /// The same everywhere.
    Constant,
    /// a cos(ν s) + b sin(ν s).
    Harmonic {
        /// ν: waves per turn.
        order: f64,
    },
}

impl Shape {
    /// The same if its numbers make sense with so many parameters.
    pub(super) fn checked(self, parameters: usize) -> Result<Self, SettingsError> {
        let expect = |count: usize| {
            #[allow(clippy::cast_precision_loss)] // counts
            let (found, count) = (parameters as f64, count as f64);
            within("parameters", found, count, count, "as many as the element's kind has")
        };
        match self {
            Self::Polynomial { blend, range, .. } => {
                blend.checked()?;
                range.check()?;
                check_length(parameters)?;
            }
            Self::Cable { pieces, range } => {
                range.check()?;
                expect(pieces.starts[pieces.count + 1])?;
            }
            Self::LinearSpring { rest } => {
                within("rest", rest, -super::LARGEST, super::LARGEST, "a finite number of at most 1e9")?;
                expect(1)?;
            }
            Self::Friction { blend, stribeck } => {
                blend.checked()?;
                let velocity = stribeck.unwrap_or(1.0);
                within("stribeck_velocity", velocity, f64::MIN_POSITIVE, super::LARGEST, "positive, rad/s or m/s")?;
                expect(if stribeck.is_some() { 3 } else { 2 })?;
            }
            Self::Constant => expect(1)?,
            Self::Harmonic { order } => {
                within("order", order, f64::MIN_POSITIVE, super::LARGEST, "positive")?;
                expect(2)?;
            }
        }
        Ok(self)
    }

    /// Calls `give(k, φ)` with what a unit of parameter k gives; those left out give nothing.
    #[inline(always)]
    pub(super) fn values(&self, count: usize, s: f64, v: f64, mut give: impl FnMut(usize, f64)) {
        match self {
            Self::Polynomial { direction, blend, range } => {
                powers(range.clamp(s), blend.weight(*direction, v), 0, count, give);
            }
            Self::Cable { pieces, range } => pieces.values(range.clamp(s), give),
            Self::LinearSpring { rest } => give(0, s - rest),
            Self::Friction { blend, stribeck } => {
                let way = blend.of(v);
                give(0, way);
                give(1, v);
                if let Some(velocity) = stribeck {
                    let share = v / velocity;
                    give(2, way * ComplexField::exp(-(share * share)));
                }
            }
            Self::Constant => give(0, 1.0),
            Self::Harmonic { order } => {
                let (sin, cos) = trig::library_sin_cos(Lanes::<1, false>([order * s]));
                give(0, cos.0[0]);
                give(1, sin.0[0]);
            }
        }
    }
}

/// Calls `give(start + k, weight · x^k)` up to `end`; a constant of an x that is no number is none either.
#[inline(always)]
fn powers(x: f64, weight: f64, start: usize, end: usize, mut give: impl FnMut(usize, f64)) {
    let mut power = weight * (1.0 + 0.0 * x);
    for k in start..end {
        give(k, power);
        power *= x;
    }
}

fn check_length(coefficients: usize) -> Result<(), SettingsError> {
    #[allow(clippy::cast_precision_loss)] // a count
    within("coefficients", coefficients as f64, 1.0, MAX_COEFFICIENTS as f64, "1 to 10 of them")
}
