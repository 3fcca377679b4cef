//! From what encoders read to positions and rates, or to the verdict that they read nothing of use.

use super::places::{Places, all, copy};
use super::settings::Settings;
use super::status::{Event, Watch};
use crate::robot::Joints;
use nalgebra::ComplexField;

/// No arm is so far (rad, m) or so fast (rad/s, m/s); what is, is no joint state and could overflow.
pub(super) const LARGEST: f64 = 1e9;

/// The encoders of an arm, at the side where they are.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Encoders {
    modulus: Joints,
    jump: Joints,
    /// One of them wraps.
    wraps: bool,
    period: f64,
    /// The last good positions, unwrapped.
    position: Joints,
    rate: Joints,
    /// There has been a good reading.
    known: bool,
    /// Cycles since the last good reading, or since the start.
    missed: u32,
}

impl Encoders {
    pub(super) fn new(settings: &Settings) -> Self {
        Self {
            modulus: settings.modulus,
            jump: settings.jump,
            wraps: settings.modulus.iter().any(|modulus| *modulus < f64::INFINITY),
            period: settings.period(),
            position: Joints::default(),
            rate: Joints::default(),
            known: false,
            missed: 0,
        }
    }

    /// Reads the encoders in a new cycle; rates are those given, or first differences. False, and nothing but the age
    /// changed, where one of them reads nothing of use.
    #[inline(always)]
    pub(super) fn read<const N: usize>(
        &mut self,
        raw: &Places<N>,
        rates: Option<&Places<N>>,
        watch: &mut Watch,
    ) -> bool {
        self.pass(1);
        if !(are_numbers(raw) & rates.is_none_or(are_numbers)) {
            return refuse(Event::Absent, watch);
        }
        let unwrapped;
        let position = if self.wraps {
            if !all::<N>(|j| raw[j].abs() <= 1.001 * self.modulus[j]) {
                return refuse(Event::EncoderRange, watch);
            }
            unwrapped = self.unwrapped(raw);
            &unwrapped
        } else {
            raw
        };
        let reach = f64::from(self.missed);
        if self.known && !all::<N>(|j| (position[j] - self.position[j]).abs() <= self.jump[j] * reach) {
            return refuse(Event::Jump, watch);
        }
        match rates {
            Some(rates) => copy(rates, &mut self.rate),
            None => self.differentiate(position),
        }
        copy(position, &mut self.position);
        (self.known, self.missed) = (true, 0);
        true
    }

    /// A cycle without a joint state.
    pub(super) fn miss(&mut self, watch: &mut Watch) -> bool {
        self.pass(1);
        refuse(Event::Absent, watch)
    }

    /// Cycles pass without a reading.
    pub(super) const fn pass(&mut self, cycles: u32) {
        self.missed = self.missed.saturating_add(cycles);
    }

    /// The last good positions.
    pub(super) const fn position(&self) -> &Joints {
        &self.position
    }

    /// Their rates.
    pub(super) const fn rate(&self) -> &Joints {
        &self.rate
    }

    /// There has been a good reading.
    pub(super) const fn is_known(&self) -> bool {
        self.known
    }

    /// Cycles since the last good reading, or since the start.
    pub(super) const fn missed(&self) -> u32 {
        self.missed
    }

    /// x = r + k M with the whole k that is nearest to the last good position; the first reading is taken as it is.
    #[inline(always)]
    fn unwrapped<const N: usize>(&self, raw: &Places<N>) -> Places<N> {
        let mut position = *raw;
        for j in 0..N {
            let modulus = self.modulus[j];
            if self.known && modulus.is_finite() {
                position[j] += ComplexField::round((self.position[j] - raw[j]) / modulus) * modulus;
            }
        }
        position
    }

    /// ẋ = (x − x_last) / Δt; at rest before there is a last one.
    #[inline(always)]
    fn differentiate<const N: usize>(&mut self, position: &Places<N>) {
        let per_second = if self.known { 1.0 / (self.period * f64::from(self.missed)) } else { 0.0 };
        for j in 0..N {
            self.rate[j] = (position[j] - self.position[j]) * per_second;
        }
    }
}

/// Finite, and not beyond any arm.
#[inline(always)]
pub(super) fn are_numbers<const N: usize>(x: &Places<N>) -> bool {
    all::<N>(|j| x[j].abs() <= LARGEST)
}

#[cold]
fn refuse(event: Event, watch: &mut Watch) -> bool {
    watch.note(true, event);
    false
}
