//! Which build of the kernels this processor can run, found once when the module is imported.

use gravcomp::control::Kernels;
use std::sync::OnceLock;

/// A set of instructions that the kernels are compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Whatever every processor of the target has.
    Portable,
    /// x86-64 with AVX2 and FMA.
    Avx2,
    /// x86-64 with AVX-512 (F, VL, DQ): batches only, a single cycle runs the AVX2 build.
    Avx512,
}

impl Level {
    /// The best level of this processor, or the one that `RAVENGC_LEVEL` (`portable`, `avx2`, `avx512`) lowers it to.
    #[inline(always)]
    pub fn get() -> Self {
        static LEVEL: OnceLock<Level> = OnceLock::new();
        *LEVEL.get_or_init(|| detected().min(requested()))
    }

    /// Its name, as `RAVENGC_LEVEL` spells it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }
}

fn requested() -> Level {
    match std::env::var("RAVENGC_LEVEL").as_deref() {
        Ok("portable") => Level::Portable,
        Ok("avx2") => Level::Avx2,
        _ => Level::Avx512,
    }
}

#[cfg(target_arch = "x86_64")]
fn detected() -> Level {
    let avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    let avx512 = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512vl")
        && is_x86_feature_detected!("avx512dq");
    match (avx2, avx512) {
        (true, true) => Level::Avx512,
        (true, false) => Level::Avx2,
        _ => Level::Portable,
    }
}

#[cfg(not(target_arch = "x86_64"))]
fn detected() -> Level {
    Level::Portable
}

/// Calls a kernel in the best build: `kernel!(gravity_torque(robot, q, g))`.
macro_rules! kernel {
    ($name:ident($($argument:expr),* $(,)?)) => {{
        #[cfg(target_arch = "x86_64")]
        {
            if $crate::dispatch::Level::get() >= $crate::dispatch::Level::Avx2 {
                // SAFETY: AVX2 and FMA were detected on this processor.
                unsafe { gravcomp::avx2::$name($($argument),*) }
            } else {
                gravcomp::portable::$name($($argument),*)
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        {
            gravcomp::portable::$name($($argument),*)
        }
    }};
}
pub(crate) use kernel;

/// The cycle of a control law in the best build, picked once.
pub fn kernels() -> Kernels {
    #[cfg(target_arch = "x86_64")]
    if Level::get() >= Level::Avx2 {
        return Kernels {
            // SAFETY: AVX2 and FMA were detected on this processor.
            cycle: |law, robot, inputs| unsafe { gravcomp::control::avx2::cycle(law, robot, inputs) },
        };
    }
    Kernels::PORTABLE
}
