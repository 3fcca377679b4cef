//! Which unit a sensor seems to send, by the size of the gravity it shows.

use crate::constants::STANDARD_GRAVITY;

/// A unit or setting that would explain the size of what the sensor sends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LikelyUnit {
    /// g: 9.80665 m/s².
    StandardGravity,
    /// cm/s², or mg: 980.665 and 1000 for one gravity, too close to tell apart.
    CentimetresOrMilliG,
    /// mm/s².
    Millimetres,
    /// µg.
    MicroG,
    /// ft/s².
    Feet,
    /// Counts of the converter, never scaled: 256, 2048, 4096, 8192 or 16384 for one gravity.
    Counts,
    /// m/s² for a range setting that is a half, a quarter or an eighth, or 2 or 4 times, the real one.
    RangeSetting,
}

/// How close to its unit's size a sample has to be, relative.
const BAND: f64 = 0.06;

/// Sizes of one gravity in m/s², as numbers of the unit.
const SIZES: [(LikelyUnit, f64); 15] = [
    (LikelyUnit::StandardGravity, 1.0),
    (LikelyUnit::CentimetresOrMilliG, 990.0),
    (LikelyUnit::Millimetres, 9806.65),
    (LikelyUnit::MicroG, 1e6),
    (LikelyUnit::Feet, 32.174),
    (LikelyUnit::Counts, 256.0),
    (LikelyUnit::Counts, 2048.0),
    (LikelyUnit::Counts, 4096.0),
    (LikelyUnit::Counts, 8192.0),
    (LikelyUnit::Counts, 16384.0),
    (LikelyUnit::RangeSetting, 2.0 * STANDARD_GRAVITY),
    (LikelyUnit::RangeSetting, 4.0 * STANDARD_GRAVITY),
    (LikelyUnit::RangeSetting, 8.0 * STANDARD_GRAVITY),
    (LikelyUnit::RangeSetting, STANDARD_GRAVITY / 2.0),
    (LikelyUnit::RangeSetting, STANDARD_GRAVITY / 4.0),
];

impl LikelyUnit {
    /// The unit that a sensor at rest with this norm of its three numbers may send; none for m/s² and for no match.
    #[must_use]
    pub fn of(norm: f64) -> Option<Self> {
        let near = |size: f64| (norm - size).abs() <= BAND * size;
        SIZES.iter().find(|(_, size)| near(*size)).map(|(unit, _)| *unit)
    }

    /// In words, for messages.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::StandardGravity => "g",
            Self::CentimetresOrMilliG => "cm/s^2 or mg",
            Self::Millimetres => "mm/s^2",
            Self::MicroG => "ug",
            Self::Feet => "ft/s^2",
            Self::Counts => "raw counts",
            Self::RangeSetting => "m/s^2 for another range setting",
        }
    }
}

/// Samples of one unit in a row that name it.
const NAMED: u32 = 8;

/// Counts samples that look alike.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct UnitWatch {
    looks: Option<LikelyUnit>,
    count: u32,
}

impl UnitWatch {
    /// Takes the norm of a sample as it was sent; true when a unit is named.
    pub(super) fn sees(&mut self, norm: f64) -> bool {
        let looks = LikelyUnit::of(norm);
        self.count = if looks == self.looks { self.count.saturating_add(1) } else { 1 };
        self.looks = looks;
        self.named().is_some()
    }

    /// The unit that the last samples agreed on.
    pub(super) fn named(self) -> Option<LikelyUnit> {
        self.looks.filter(|_| self.count >= NAMED)
    }
}
