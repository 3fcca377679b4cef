//! Sets of things that can be noted, as the bits of a word.

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

/// A counter one further; at the largest number it stays.
pub(crate) const fn up(count: &mut u64) {
    *count = count.saturating_add(1);
}
