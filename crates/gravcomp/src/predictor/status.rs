//! What was found about the stream and the prediction, as bits of a status word, and how often.

use crate::flags::{flags, up};

/// What can be noted; its number is its bit in [`Notes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Note {
    /// A stamp or position of a sample is NaN or infinite, or further away than any target.
    NotFinite = 0,
    /// The sample has the stamp of one before it.
    Repeated = 1,
    /// The sample is older than one before it.
    Backward = 2,
    /// Samples are missing before this one.
    Dropped = 3,
    /// The stamp is so far ahead that the next one has to confirm it.
    Gap = 4,
    /// The position is too far from where the target can be; the next one has to confirm it.
    Spike = 5,
    /// The target is elsewhere, or its samples were missing, as two samples say: what was about its last places is void.
    Moved = 6,
    /// The clock of the samples was set, or they were missing for long: everything begins anew.
    Restarted = 7,
    /// The sample moved the prediction by more than the declared jump.
    Jump = 8,
    /// There has been no sample yet.
    NoData = 9,
    /// The method is still learning; another one stands in.
    Learning = 10,
    /// The cycles are at an end of the declared band, or there are none in it.
    OutOfBand = 11,
    /// Asked for a time too far from the newest sample: held where it would be at the end of what can be asked.
    TooFar = 12,
    /// The prediction was further from the newest sample, or faster, than the target can go.
    Limited = 13,
    /// Asked for a time that is no number: the last prediction stands.
    NoTime = 14,
}

impl Note {
    /// All of them, by number.
    pub const ALL: [Self; 15] = [
        Self::NotFinite,
        Self::Repeated,
        Self::Backward,
        Self::Dropped,
        Self::Gap,
        Self::Spike,
        Self::Moved,
        Self::Restarted,
        Self::Jump,
        Self::NoData,
        Self::Learning,
        Self::OutOfBand,
        Self::TooFar,
        Self::Limited,
        Self::NoTime,
    ];

    /// Its name in logs: lower case, words joined by underscores.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotFinite => "not_finite",
            Self::Repeated => "repeated",
            Self::Backward => "backward",
            Self::Dropped => "dropped",
            Self::Gap => "gap",
            Self::Spike => "spike",
            Self::Moved => "moved",
            Self::Restarted => "restarted",
            Self::Jump => "jump",
            Self::NoData => "no_data",
            Self::Learning => "learning",
            Self::OutOfBand => "out_of_band",
            Self::TooFar => "too_far",
            Self::Limited => "limited",
            Self::NoTime => "no_time",
        }
    }

    /// What it says, in one line.
    #[must_use]
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::NotFinite => "a stamp or position is no number that a target can have",
            Self::Repeated => "a stamp came again",
            Self::Backward => "a stamp is older than one before it",
            Self::Dropped => "samples are missing before the newest one",
            Self::Gap => "a stamp far ahead waits for the next one to confirm it",
            Self::Spike => "a position far off waits for the next one to confirm it",
            Self::Moved => "the target is elsewhere, or its samples were missing, as two of them say",
            Self::Restarted => "the samples' clock was set or they were missing for long: everything begins anew",
            Self::Jump => "the sample moved the prediction by more than the declared jump",
            Self::NoData => "there has been no sample yet",
            Self::Learning => "the method is still learning; another one stands in",
            Self::OutOfBand => "the cycles are at an end of the declared band, or there are none in it",
            Self::TooFar => "asked for a time too far from the newest sample",
            Self::Limited => "the prediction was further off, or faster, than the target can go",
            Self::NoTime => "asked for a time that is no number",
        }
    }
}

flags!(
    /// A set of [`Note`]s.
    Notes of Note
);

impl Notes {
    /// Those of a sample that was not used.
    pub const REFUSED: Self = Self::of(&[Note::NotFinite, Note::Repeated, Note::Backward, Note::Gap, Note::Spike]);
}

/// How often, since the start. No counter wraps: it stays at the largest number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples handed in.
    pub received: u64,
    /// Samples that were used.
    pub accepted: u64,
    /// By the number of the [`Note`]: samples with which it was noted.
    pub notes: [u64; Note::ALL.len()],
}

impl Counters {
    /// How often `note` was noted.
    #[must_use]
    pub const fn of(&self, note: Note) -> u64 {
        self.notes[note as usize]
    }

    pub(super) fn add(&mut self, notes: Notes) {
        up(&mut self.received);
        if notes.common(Notes::REFUSED).is_empty() {
            up(&mut self.accepted);
        }
        for note in notes.iter() {
            up(&mut self.notes[note as usize]);
        }
    }
}
