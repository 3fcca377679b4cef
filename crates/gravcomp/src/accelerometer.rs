//! The base's accelerometer as a monitored safety signal: from raw samples to a gravity that an arm may rely on.
//!
//! [`Accelerometer::step`] is called once per control cycle, with a sample when one has come. It never fails: whatever comes
//! in, the [`Reading`] is finite, bounded, and no further from the one before than the declared rate allows.
//!
//! # The chain
//! | step | what it does |
//! |---|---|
//! | stamp, order | stamps in the future, from another clock or too old; duplicates and stragglers |
//! | numbers | finite, inside the range of each axis, a norm the base can feel, not the same bits again and again |
//! | change | no jump that the base's jerk does not allow; none of the gyroscope or of what it means for the lever arm |
//! | calibration | f = S (s − b) |
//! | filter | second-order Butterworth with a declared cut-off, exact for irregular sample times |
//! | mounting, lever arm | f₀ = R f − dω × r − ω × (ω × r), dω from the filter's own slope |
//! | turning | gravity turns as the gyroscope says, but for what the base accelerates |
//! | slow watch | size and direction of the long mean, direction of the sample against it |
//! | output | moves no faster than a declared rate, on any transition |
//!
//! A sample that fails is rejected: it is counted, it is visible in that step's [`Status`], and it makes nothing younger. One
//! rejected sample is no alarm. Two jumps in a row, three rejected samples in a row, four among the last 32, a stuck sensor,
//! three samples in a row that contradict the gyroscope, or silence beyond the age limit are: trust is lost.
//!
//! # Trust
//! A sensor is trusted after [`Settings::start_count`] samples in a row that pass, fit each other, have the size of gravity on
//! average and point up within [`Settings::pose_limit`]. Lost trust is regained the same way, and then the mean must also be
//! within [`Settings::tilt_limit`] of the slow tilt estimate: a sensor whose axes or sign changed agrees with itself for ever
//! and is never followed, unless somebody acknowledges that the base stands otherwise. Gravity as a gyroscope carries it on
//! meanwhile must not be contradicted either. After mere silence three samples that agree with the last value are enough; after
//! a long one the tilt estimate is not asked, as the base may have moved.
//!
//! A base that jerks harder than declared loses its sensor's trust, and what then lasts decides how long for. Across gravity an
//! acceleration of 0.2 g changes its size by 2 % and its direction by 11°: it is followed after a run of good samples. Along
//! gravity it changes the size by 20 %, more than [`Settings::norm_tolerance`], as a changed scale would: the value is held
//! while it lasts and a run longer, under the strict policy up to the latched fault. A base that may do so declares its
//! [`Settings::jerk`], and nothing is held.
//!
//! # States
//! | state | output | leads to |
//! |---|---|---|
//! | `NoData` (strict), `Nominal` (paper) | gravity of a level base | `Live` when the sensor is trusted |
//! | `Live` | the sensor | `Held` on any alarm |
//! | `Held` | the last value | `Live` when trusted again; under the strict policy `Degraded` at an age of 50 ms |
//! | `Degraded` | standard gravity along the slow tilt estimate | `Live` when trusted again, `Fault` at an age of 500 ms |
//! | `Fault` | the same | `Degraded` by [`Accelerometer::acknowledge`], by nothing else |
//!
//! A sensor that is trusted takes the output over with a ramp; the arm may be armed when that has arrived.
//!
//! # What one accelerometer cannot show
//! A bias that steps by less than the jump limit or creeps, within the watch's 15 % of size and cone of directions; vibration
//! above half the sample rate, which folds down; a delay before the stamp. Horizontal axes or signs that change show only where
//! they make a jump, or with a gyroscope where gravity comes to turn otherwise by more than twice the base's acceleration; a
//! gyroscope that turns about the vertical shows nowhere. `benches/faults.py` prints how far each of them carries the output.

mod calibration;
mod carried;
mod chain;
mod clock;
mod doubt;
mod fault;
mod filter;
mod gate;
mod motion;
mod now;
mod output;
mod run;
mod sample;
mod settings;
mod state;
mod tilt;
mod trust;
mod turning;
mod unit;

pub use crate::error::SettingsError;
pub use calibration::Calibration;
pub use chain::Accelerometer;
pub use fault::{Counters, Fault, Faults, Status};
pub use sample::{Reading, Sample};
pub use settings::Settings;
pub use state::{Event, Policy, State};
pub use unit::LikelyUnit;
