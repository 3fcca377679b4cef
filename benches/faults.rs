//! The fault campaign, as fast as this machine can: `benches/faults.py` builds, runs and reads it.
//!
//! `faults SEEDS HEALTHY_SECONDS RANDOM_SAMPLES` prints one JSON object: a row per kind of fault, the healthy rocking, the
//! random bits. On the error stream it says how many parts there are, and then a line for each that is done.

mod campaign;

use campaign::{Bits, Class, Flight, KINDS, Kind, Outcome};
use gravcomp::accelerometer::{Policy, State};
use std::env;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::Instant;

/// When an alarm is in time, ms.
const IN_TIME_MS: f64 = 100.0;

/// Seconds of healthy rocking in one piece.
const PIECE: u64 = 100;

/// Random samples in one piece.
const BATCH: u64 = 100_000;

fn main() {
    let numbers: Vec<u64> = env::args().skip(1).filter_map(|word| word.parse().ok()).collect();
    let &[seeds, healthy_seconds, random_samples] = numbers.as_slice() else {
        eprintln!("usage: faults SEEDS HEALTHY_SECONDS RANDOM_SAMPLES");
        std::process::exit(2);
    };
    eprintln!("{}", KINDS.len() + 2);
    let start = Instant::now();
    let rows: Vec<String> = (0_u64..).zip(KINDS).map(|(k, row)| kind(k, row, seeds)).collect();
    let healthy = healthy(healthy_seconds);
    let bits = bits(random_samples);
    println!(
        r#"{{"seeds": {seeds}, "seconds": {:.1}, "kinds": [{}], "healthy": {healthy}, "bits": {bits}}}"#,
        start.elapsed().as_secs_f64(),
        rows.join(", ")
    );
}

/// Work `0..count`, spread over all cores; the results in no order.
fn spread<T: Send>(count: u64, work: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let next = AtomicU64::new(0);
    let turn = || {
        let mut done = Vec::new();
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            if i >= count {
                return done;
            }
            done.push(work(i));
        }
    };
    thread::scope(|scope| {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        let threads: Vec<_> = (0..cores).map(|_| scope.spawn(turn)).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("no scenario panics")).collect()
    })
}

fn kind(number: u64, (kind, name, class): (Kind, &str, Class), seeds: u64) -> String {
    let flights = spread(seeds, |seed| Flight::new(kind, number << 32 | seed));
    eprintln!("{name}");
    let side = |outcome: fn(&Flight) -> &Outcome| side(flights.iter().map(outcome));
    format!(
        r#"{{"name": "{name}", "class": "{class:?}", "cycles": {}, "paper": {}, "strict": {}, "naive": {}}}"#,
        flights.iter().map(|flight| flight.cycles).sum::<u64>(),
        side(|flight| &flight.paper),
        side(|flight| &flight.strict),
        side(|flight| &flight.naive),
    )
}

/// The outcomes of one gate in one kind of fault.
fn side<'a>(outcomes: impl Iterator<Item = &'a Outcome> + Clone) -> String {
    let mut times: Vec<f64> = outcomes.clone().filter_map(|outcome| outcome.alarm).map(|time| 1e3 * time).collect();
    times.sort_by(f64::total_cmp);
    let sorted = |of: fn(&Outcome) -> f64| {
        let mut numbers: Vec<f64> = outcomes.clone().map(of).collect();
        numbers.sort_by(f64::total_cmp);
        numbers
    };
    let (errors, armed) = (sorted(|outcome| outcome.error), sorted(|outcome| outcome.armed));
    format!(
        r#"{{"alarmed": {}, "in_time": {}, "early": {}, "p50": {}, "p99": {}, "max": {}, "error_p50": {}, "error": {}, "armed_p50": {}, "armed": {}, "not_finite": {}, "too_far": {}}}"#,
        times.len(),
        times.iter().filter(|time| **time <= IN_TIME_MS).count(),
        outcomes.clone().filter(|outcome| outcome.early).count(),
        quantile(&times, 50),
        quantile(&times, 99),
        quantile(&times, 100),
        quantile(&errors, 50),
        quantile(&errors, 100),
        quantile(&armed, 50),
        quantile(&armed, 100),
        outcomes.clone().map(|outcome| outcome.not_finite).sum::<u64>(),
        outcomes.map(|outcome| outcome.too_far).sum::<u64>(),
    )
}

/// The smallest number that `percent` of the sorted ones do not exceed, for JSON.
fn quantile(sorted: &[f64], percent: usize) -> String {
    let rank = (sorted.len() * percent).div_ceil(100);
    sorted.get(rank.saturating_sub(1)).map_or("null".into(), |number| format!("{number:.6e}"))
}

fn healthy(seconds: u64) -> String {
    #[allow(clippy::cast_precision_loss)] // 100
    let flights = spread(seconds.div_ceil(PIECE), |i| Flight::healthy(PIECE as f64, u64::MAX - i));
    eprintln!("healthy rocking");
    let both = flights.iter().flat_map(|flight| [&flight.paper, &flight.strict]);
    format!(
        r#"{{"seconds": {}, "alarms": {}, "error": {:e}, "not_finite": {}, "too_far": {}}}"#,
        seconds.div_ceil(PIECE) * PIECE,
        both.clone().filter(|outcome| outcome.alarm.is_some() || outcome.early).count(),
        both.clone().map(|outcome| outcome.error).fold(0.0, f64::max),
        both.clone().map(|outcome| outcome.not_finite).sum::<u64>(),
        both.map(|outcome| outcome.too_far).sum::<u64>(),
    )
}

fn bits(samples: u64) -> String {
    let mut sum = Bits::default();
    for part in spread(samples.div_ceil(BATCH), |i| {
        Bits::feed(BATCH, if i % 2 == 0 { Policy::Paper } else { Policy::Strict }, i)
    }) {
        sum.add(&part);
    }
    eprintln!("random bits");
    let states: Vec<String> =
        State::ALL.iter().zip(sum.in_state).map(|(state, count)| format!(r#""{}": {count}"#, state.name())).collect();
    format!(
        r#"{{"samples": {}, "accepted": {}, "not_finite": {}, "too_far": {}, "too_long": {}, "states": {{{}}}}}"#,
        sum.samples,
        sum.accepted,
        sum.not_finite,
        sum.too_far,
        sum.too_long,
        states.join(", ")
    )
}
