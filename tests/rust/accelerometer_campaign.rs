//! A small fault campaign: what `benches/faults.py` flies with thousands of seeds for each kind, with forty.

#[path = "../../benches/campaign/mod.rs"]
mod campaign;

use campaign::random::Random;
use campaign::{Bits, Class, Flight, KINDS, Kind, Outcome};
use gravcomp::accelerometer::{Policy, State};

const SEEDS: u64 = 40;

/// Both policies' outcomes of every seed.
fn outcomes(kind: Kind) -> Vec<Outcome> {
    (0..SEEDS).map(|seed| Flight::new(kind, seed)).flat_map(|flight| [flight.paper, flight.strict]).collect()
}

#[test]
fn every_fault_leaves_the_output_finite_and_within_its_rate() {
    for (kind, name, class) in KINDS {
        for outcome in outcomes(kind) {
            assert_eq!((outcome.not_finite, outcome.too_far, outcome.early), (0, 0, false), "{name}");
            // A held value is off by what the base does meanwhile, and by the fault until it was seen.
            assert!(outcome.error < if class == Class::Hidden { 12.0 } else { 7.0 }, "{name}: {outcome:?}");
            assert!(outcome.armed <= outcome.error, "{name}");
            match class {
                Class::Hard => assert!(outcome.alarm.is_some_and(|time| time <= 0.1), "{name}: {outcome:?}"),
                Class::Harmless => assert_eq!(outcome.alarm, None, "{name}"),
                Class::Partial | Class::Hidden => {}
            }
        }
    }
}

/// Neighbouring seeds are other scenarios, not the same one a number later.
#[test]
fn no_two_seeds_share_their_numbers() {
    let numbers = |seed| {
        let mut random = Random::new(seed);
        (0..1000).map(move |_| random.bits()).collect::<Vec<_>>()
    };
    let mut all: Vec<u64> = (0..50).chain(u64::MAX - 50..u64::MAX).flat_map(numbers).collect();
    all.sort_unstable();
    assert!(all.windows(2).all(|pair| pair[0] != pair[1]));
}

/// 10-20° at 1 Hz with noise, for as long as a test may take.
#[test]
fn healthy_rocking_raises_no_alarm() {
    for seed in 0..10 {
        let flight = Flight::healthy(30.0, seed);
        for outcome in [flight.paper, flight.strict] {
            assert_eq!((outcome.alarm, outcome.early, outcome.not_finite, outcome.too_far), (None, false, 0, 0));
            assert!(outcome.error < 0.6, "{outcome:?}");
        }
        assert_eq!(flight.cycles, 30_000);
        assert_eq!(flight.naive.not_finite, 0);
    }
}

#[test]
fn random_bits_reach_every_state_and_do_no_harm() {
    let mut sum = Bits::default();
    for seed in 0..20 {
        sum.add(&Bits::feed(10_000, if seed % 2 == 0 { Policy::Paper } else { Policy::Strict }, seed));
    }
    assert_eq!((sum.samples, sum.not_finite, sum.too_far, sum.too_long), (200_000, 0, 0, 0));
    for (state, count) in State::ALL.iter().zip(sum.in_state) {
        assert!(count > 0, "{state:?} was never reached");
    }
    assert!(sum.accepted > 10_000, "{sum:?}");
}
