//! The fault campaign: seeded scenarios of everything that can go wrong with a sensor on a rocking base.

pub mod bits;
pub mod flight;
pub mod kinds;
pub mod random;
pub mod world;

pub use bits::Bits;
pub use flight::{Flight, Outcome};
pub use kinds::{Class, KINDS, Kind};
