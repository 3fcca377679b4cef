//! Sets of things that can be noted, as the bits of a word; and how often what was noted.

/// `flags!(/// … Faults of Fault)`: a set of the variants of a fieldless enum with at most 32 of them and an `ALL` by number.
macro_rules! flags {
    ($(#[$about:meta])* $set:ident of $flag:ident) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct $set(u32);

        impl $set {
            /// None of them.
            pub const NONE: Self = Self(0);

            /// Only this one.
            #[must_use]
            pub const fn only(flag: $flag) -> Self {
                Self::when(true, flag)
            }

            /// All of these.
            #[must_use]
            pub const fn of(flags: &[$flag]) -> Self {
                let (mut set, mut i) = (Self::NONE, 0);
                while i < flags.len() {
                    set = set.and(Self::only(flags[i]));
                    i += 1;
                }
                set
            }

            /// This one if `here`, else none.
            #[must_use]
            pub const fn when(here: bool, flag: $flag) -> Self {
                Self((here as u32) << flag as u32)
            }

            /// These and those.
            #[must_use]
            pub const fn and(self, others: Self) -> Self {
                Self(self.0 | others.0)
            }

            /// Those among both.
            #[must_use]
            pub const fn common(self, others: Self) -> Self {
                Self(self.0 & others.0)
            }

            /// These without those.
            #[must_use]
            pub const fn without(self, others: Self) -> Self {
                Self(self.0 & !others.0)
            }

            /// This one is among them.
            #[must_use]
            pub const fn has(self, flag: $flag) -> bool {
                self.0 & Self::only(flag).0 != 0
            }

            /// There is none.
            #[must_use]
            pub const fn is_empty(self) -> bool {
                self.0 == 0
            }

            /// The bit of its number is set for each.
            #[must_use]
            pub const fn bits(self) -> u32 {
                self.0
            }

            /// Each of them, by number.
            pub fn iter(self) -> impl Iterator<Item = $flag> {
                let mut left = self.0;
                core::iter::from_fn(move || {
                    let flag = $flag::ALL.get(left.trailing_zeros() as usize)?;
                    left &= left - 1;
                    Some(*flag)
                })
            }
        }
    };
}
pub(crate) use flags;

/// `watch!(Events of Event)`: the set, with what happened in a cycle and since somebody looked, and how often.
macro_rules! watch {
    ($set:ident of $event:ident) => {
        $crate::flags::flags!(
            /// A set of events.
            $set of $event
        );

        /// What happened. As a word of 64 bits: since the last acknowledgement in the low half, in this cycle in the high one.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub struct Status {
            /// Since the start or the last acknowledgement.
            pub since: $set,
            /// In this very cycle.
            pub seen: $set,
        }

        impl Status {
            /// `since | seen << 32`.
            #[must_use]
            pub const fn word(self) -> u64 {
                self.since.bits() as u64 | (self.seen.bits() as u64) << 32
            }
        }

        /// How often, since the start. No counter wraps: it stays at the largest number.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct Counters {
            /// Cycles.
            pub cycles: u64,
            /// By the number of the event: cycles in which it happened.
            pub events: [u64; $event::ALL.len()],
        }

        impl Counters {
            /// In how many cycles `event` happened.
            #[must_use]
            pub const fn of(&self, event: $event) -> u64 {
                self.events[event as usize]
            }
        }

        /// Collects the events of a cycle.
        #[derive(Clone, Copy, Debug, Default)]
        pub(super) struct Watch {
            pub(super) status: Status,
            pub(super) counters: Counters,
        }

        impl Watch {
            /// A cycle begins: nothing has happened in it.
            #[inline(always)]
            pub(super) const fn begin(&mut self) {
                self.status.seen = $set::NONE;
            }

            /// `event` happens in this cycle if `here`.
            #[inline(always)]
            pub(super) const fn note(&mut self, here: bool, event: $event) {
                self.status.seen = self.status.seen.and($set::when(here, event));
            }

            /// The cycle ends: what happened is counted.
            #[inline(always)]
            pub(super) fn end(&mut self) {
                $crate::flags::up(&mut self.counters.cycles);
                if !self.status.seen.is_empty() {
                    self.count();
                }
            }

            #[inline(never)]
            fn count(&mut self) {
                self.status.since = self.status.since.and(self.status.seen);
                for event in self.status.seen.iter() {
                    $crate::flags::up(&mut self.counters.events[event as usize]);
                }
            }

            /// Somebody has looked at what happened since.
            pub(super) const fn acknowledge(&mut self) {
                self.status.since = $set::NONE;
            }
        }
    };
}
pub(crate) use watch;

/// A counter one further; at the largest number it stays.
pub(crate) const fn up(count: &mut u64) {
    *count = count.saturating_add(1);
}
