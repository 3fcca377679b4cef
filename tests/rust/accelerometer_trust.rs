//! When the accelerometer is trusted, how trust is lost, and how it comes back.

use crate::accelerometer::{CYCLE_NS, Feed, PERIOD_NS, tilted};
use gravcomp::accelerometer::{Fault, Faults, Policy, Settings, State};
use gravcomp::{Accelerometer, Gravity, STANDARD_GRAVITY};
use nalgebra::Vector3;

const POLICIES: [Policy; 2] = [Policy::Paper, Policy::Strict];

/// Cycles until the state is this one; nothing comes in meanwhile.
fn cycles_until(feed: &mut Feed, state: State) -> i64 {
    for cycle in 0..2000 {
        if feed.step(None).state == state {
            return cycle;
        }
        feed.now_ns += CYCLE_NS;
    }
    panic!("never {state:?}");
}

#[test]
fn without_a_sensor_the_level_vector_stands_and_an_alarm_comes() {
    for (policy, state) in [(Policy::Paper, State::Nominal), (Policy::Strict, State::NoData)] {
        let mut feed = Feed::of(policy);
        let early = feed.silence(4);
        assert_eq!((early.state, early.gravity, early.status.is_alarm()), (state, Gravity::LEVEL, false));
        let late = feed.silence(1); // 50 ms in all
        assert_eq!((late.state, late.gravity, late.age_ns), (state, Gravity::LEVEL, None));
        assert!(late.status.alarms.has(Fault::NoSensor));
        assert_eq!(feed.chain.armable(), policy == Policy::Paper, "the paper's rule arms on the nominal vector");
        assert_eq!(feed.chain.counters().of(Fault::NoSensor), 1);
    }
}

#[test]
fn twenty_good_samples_make_a_sensor_live() {
    for policy in POLICIES {
        let mut feed = Feed::of(policy);
        assert_ne!(feed.feel(tilted(15.0), 19).state, State::Live);
        assert!(policy == Policy::Paper || !feed.chain.armable());
        let reading = feed.feel(tilted(15.0), 1);
        assert_eq!((reading.state, reading.status.word()), (State::Live, 0));
        assert!(!feed.chain.armable(), "the output is still on its way");
        let settled = feed.feel(tilted(15.0), 20);
        assert!((settled.gravity.0 + tilted(15.0)).norm() < 0.1);
        assert!(feed.chain.armable());
    }
}

#[test]
fn a_silent_sensor_under_the_strict_policy() {
    let mut feed = Feed::live(Policy::Strict, tilted(15.0));
    let held = feed.feel(tilted(15.0) + Vector3::new(0.5, 0.5, 0.0), 1).gravity;
    // The last sample was 10 ms old at the end of its period, and 1 ms when it came.
    let until = 11;
    assert_eq!(cycles_until(&mut feed, State::Held), 41 - until);
    assert!(feed.step(None).status.alarms.has(Fault::Age));
    assert!(!feed.chain.armable());
    assert_eq!(cycles_until(&mut feed, State::Degraded), 51 - 41);
    assert!((feed.step(None).gravity.0 - held.0).norm() < 0.5, "held until now");
    assert_eq!(cycles_until(&mut feed, State::Fault), 501 - 51);
    let safe = feed.step(None).gravity.0;
    assert!((safe.norm() - STANDARD_GRAVITY).abs() < 1e-9, "the tilt estimate has standard size");
    assert!((safe + tilted(15.0)).norm() < 0.1, "and the direction of the last seconds");
}

#[test]
fn a_fault_is_left_by_acknowledgement_alone() {
    let mut feed = Feed::live(Policy::Strict, tilted(15.0));
    feed.silence(60);
    assert_eq!(feed.feel(tilted(12.0), 200).state, State::Fault, "a sensor that is back changes nothing");
    feed.chain.acknowledge();
    assert_eq!(feed.feel(tilted(12.0), 19).state, State::Degraded);
    assert!(!feed.chain.armable());
    assert_eq!(feed.feel(tilted(12.0), 1).state, State::Live);
    assert!((feed.feel(tilted(12.0), 20).gravity.0 + tilted(12.0)).norm() < 0.1);

    feed.silence(60);
    feed.chain.acknowledge();
    assert_eq!(feed.silence(44).state, State::Degraded);
    assert_eq!(feed.silence(2).state, State::Fault, "nothing came: it latches anew");
}

#[test]
fn by_the_papers_rule_the_last_value_stays_until_the_sensor_is_back() {
    let mut feed = Feed::live(Policy::Paper, tilted(15.0));
    let last = feed.feel(tilted(15.0), 1).gravity;
    let reading = feed.silence(1000);
    assert_eq!((reading.state, reading.gravity), (State::Held, last));
    assert!(reading.status.alarms.has(Fault::Age) && !feed.chain.armable());
    assert_eq!(feed.feel(tilted(20.0), 19).gravity, last);
    let back = feed.feel(tilted(20.0), 20);
    assert_eq!((back.state, back.status.word()), (State::Live, 0));
}

/// A drop-out of a tenth of a second is over after three samples that agree; one in which the base was turned is not.
#[test]
fn a_short_silence_is_forgiven() {
    for policy in POLICIES {
        let mut feed = Feed::live(policy, tilted(15.0));
        assert!(feed.silence(9).status.alarms.has(Fault::Age));
        assert_ne!(feed.feel(tilted(16.0), 2).state, State::Live);
        assert_eq!(feed.feel(tilted(16.0), 1).state, State::Live);
        feed.silence(9);
        assert_ne!(feed.feel(tilted(-16.0), 10).state, State::Live);
    }
}

/// While nothing is heard the base may be turned, but up stays up.
#[test]
fn after_a_long_silence_the_base_may_stand_otherwise() {
    let up = tilted(15.0);
    for (felt, follows) in [(tilted(40.0), true), (-up, false), (Vector3::new(up.z, up.x, up.y), false)] {
        let mut feed = Feed::live(Policy::Paper, up);
        feed.silence(100);
        assert_eq!(feed.feel(felt, 40).state == State::Live, follows, "{felt}");
        assert!(!follows || (feed.feel(felt, 40).gravity.0 + felt).norm() < 0.1);
    }
}

/// Two, and two thousand, wrong samples that agree with each other are not followed.
#[test]
fn a_level_that_jumped_is_not_followed_because_it_stays() {
    let [up, side] = [tilted(15.0), Vector3::new(STANDARD_GRAVITY, 0.5, 1.0)];
    for wrong in [-up, side, Vector3::new(up.z, up.x, up.y), tilted(35.0), tilted(-15.0), 0.7 * up] {
        let mut feed = Feed::live(Policy::Paper, up);
        let last = feed.feel(up, 1).gravity;
        let alarmed = feed.feel(wrong, 2);
        assert!(alarmed.status.alarms.has(Fault::Jerk), "{wrong}");
        let reading = feed.feel(wrong, 2000);
        assert_eq!(reading.state, State::Held, "{wrong}");
        assert!((reading.gravity.0 - last.0).norm() < 0.05, "{wrong}");
        assert_eq!(feed.feel(up, 20).state, State::Live, "what was before is back");

        let mut feed = Feed::live(Policy::Strict, up);
        assert_eq!(feed.feel(wrong, 60).state, State::Fault, "{wrong}");
    }
}

/// 0.2 g between two samples. Across gravity its size stays, so that it is followed; along gravity it is as if the scale had
/// changed, which one sensor cannot tell from a lift: it is held while that lasts. A declared jerk makes it no jump.
#[test]
fn a_jump_along_gravity_is_held_as_long_as_it_lasts_and_one_across_it_is_followed() {
    let (up, fifth) = (tilted(0.0), 0.2 * STANDARD_GRAVITY);
    let along = Vector3::new(0.0, 0.0, fifth);
    for (jump, follows) in
        [(along, false), (-along, false), (Vector3::new(0.0, fifth, 0.0), true), (Vector3::new(-fifth, 0.0, 0.0), true)]
    {
        let mut feed = Feed::live(Policy::Paper, up);
        assert_eq!(feed.feel(up + jump, 2).state, State::Held, "{jump}");
        assert_eq!(feed.feel(up + jump, 20).state == State::Live, follows, "{jump}");
        let late = feed.feel(up + jump, 2000);
        assert_eq!((late.state == State::Live, late.status.is_alarm()), (follows, !follows), "{jump}");
        assert_eq!(feed.feel(up, 22).state, State::Live, "what was before is back");

        let settings = Settings { jerk: 400.0, ..Settings::default() };
        let mut feed = Feed::new(&settings);
        feed.feel(up, 100);
        for _ in 0..200 {
            assert_eq!(feed.feel(up + jump, 1).state, State::Live, "{jump}");
        }
    }
}

/// An acknowledgement says that the base stands otherwise; it says nothing against up being up.
#[test]
fn an_acknowledged_jump_is_followed_where_the_base_can_be() {
    for (policy, state) in [(Policy::Paper, State::Held), (Policy::Strict, State::Fault)] {
        for (wrong, follows) in [(tilted(35.0), true), (-tilted(15.0), false), (tilted(70.0), false)] {
            let mut feed = Feed::live(policy, tilted(15.0));
            assert_eq!(feed.feel(wrong, 60).state, state);
            feed.chain.acknowledge();
            assert_eq!(feed.feel(wrong, 20).state == State::Live, follows, "{policy:?} {wrong}");
        }
    }
}

#[test]
fn one_spike_is_dropped_and_no_alarm() {
    for spike in [Vector3::new(0.0, 10.0, 0.0), Vector3::new(f64::NAN, 0.0, 0.0), Vector3::new(0.0, 0.0, 1e6)] {
        let mut feed = Feed::live(Policy::Strict, tilted(15.0));
        let before = feed.feel(tilted(15.0), 1).gravity.0;
        let sample = feed.sample(tilted(15.0) + spike);
        let reading = feed.step(Some(&sample));
        assert!(!reading.status.is_alarm() && !reading.status.seen.is_empty());
        assert!((reading.gravity.0 - before).norm() < 0.05);
        feed.now_ns += PERIOD_NS;
        assert_eq!(feed.feel(tilted(15.0), 5).status.word(), 0);
        assert_eq!(feed.chain.counters().faults.iter().sum::<u64>(), 1);
    }
}

/// Every eighth sample bad: no two in a row, and still an alarm.
#[test]
fn many_single_spikes_are_an_alarm() {
    let mut feed = Feed::live(Policy::Paper, tilted(15.0));
    let mut alarmed = false;
    for k in 0..32 {
        let spike = if k % 8 == 0 { 10.0 } else { 0.0 };
        alarmed |= feed.feel(tilted(15.0) + Vector3::new(0.0, spike, 0.0), 1).status.alarms.has(Fault::Density);
    }
    assert!(alarmed);
    assert_eq!(feed.feel(tilted(15.0), 20).state, State::Live);
}

#[test]
fn a_stream_of_nan_is_never_healthy() {
    for policy in POLICIES {
        let mut feed = Feed::of(policy);
        for k in 0..2000 {
            let reading = feed.feel(Vector3::new(0.0, f64::NAN, STANDARD_GRAVITY), 1);
            assert!(reading.state != State::Live && reading.age_ns.is_none());
            assert_eq!(reading.status.alarms.has(Fault::NotFinite), k >= 2);
        }
    }
}

#[test]
fn a_stuck_sensor_and_a_stuck_axis_are_seen() {
    let mut feed = Feed::live(Policy::Paper, tilted(15.0));
    let frozen = feed.sample(tilted(15.0)).specific_force;
    let stuck = |feed: &mut Feed, axes: usize, samples: u32| {
        for _ in 0..samples {
            let mut sample = feed.sample(tilted(15.0));
            for axis in 0..axes {
                sample.specific_force[axis] = frozen[axis];
            }
            feed.step(Some(&sample));
            feed.now_ns += PERIOD_NS;
        }
        feed.step(None).status.alarms.has(Fault::Stuck)
    };
    assert!(!stuck(&mut feed, 3, 7));
    assert!(stuck(&mut feed, 3, 1));
    assert_eq!(feed.feel(tilted(15.0), 21).state, State::Live);
    assert!(!stuck(&mut feed, 1, 39));
    assert!(stuck(&mut feed, 1, 1));

    let settings = Settings { stuck_count: 0, axis_stuck_count: 0, ..Settings::default() };
    let mut ideal = Feed::new(&settings);
    assert!(!stuck(&mut ideal, 3, 200), "a sensor without noise may be declared");
}

#[test]
fn duplicates_and_stragglers_change_nothing() {
    let mut feed = Feed::live(Policy::Strict, tilted(15.0));
    for _ in 0..100 {
        let samples = [feed.sample(tilted(15.0)), feed.sample(tilted(15.0))];
        for sample in [&samples[0], &samples[0], &samples[0], &samples[0], &samples[0], &samples[1]] {
            assert_eq!(feed.step(Some(sample)).state, State::Live);
            feed.now_ns += CYCLE_NS;
        }
        let mut later = feed.sample(tilted(15.0));
        later.stamp_ns += 1;
        assert!(!feed.step(Some(&later)).status.is_alarm());
        assert!(feed.step(Some(&samples[1])).status.seen.has(Fault::Sequence));
        feed.now_ns += CYCLE_NS;
    }
}

#[test]
fn a_sensor_that_restarts_its_numbers_is_taken_up_again() {
    for policy in POLICIES {
        let mut feed = Feed::live(policy, tilted(15.0));
        feed.seq = 0;
        assert!(feed.feel(tilted(15.0), 3).status.alarms.has(Fault::Sequence));
        assert_eq!(feed.feel(tilted(15.0), 3).state, State::Live);
    }
}

/// A clock that jumps takes its samples' stamps with it: an alarm, and twenty samples later all is well.
#[test]
fn a_host_clock_that_jumps_back_is_survived() {
    for (policy, jump) in POLICIES.into_iter().flat_map(|policy| [(policy, 3_600_000_000_000), (policy, i64::MAX)]) {
        let mut feed = Feed::live(policy, tilted(15.0));
        feed.now_ns -= jump;
        let reading = feed.feel(tilted(15.0), 1);
        assert!(reading.status.alarms.has(Fault::HostClock) && reading.state != State::Live);
        assert_eq!(feed.feel(tilted(15.0), 25).state, State::Live);
    }
}

#[test]
fn a_host_clock_that_jumps_ahead_makes_everything_old() {
    for (policy, state) in [(Policy::Paper, State::Held), (Policy::Strict, State::Fault)] {
        let mut feed = Feed::live(policy, tilted(15.0));
        feed.now_ns += 3_600_000_000_000;
        let reading = feed.step(None);
        assert_eq!(reading.state, state);
        assert!(reading.age_ns > Some(3_600_000_000_000));
    }
}

#[test]
fn a_clock_that_stands_still_moves_nothing_and_is_noticed() {
    let mut feed = Feed::live(Policy::Strict, tilted(15.0));
    feed.feel(tilted(20.0), 1);
    let before = feed.step(None);
    for _ in 0..200 {
        let reading = feed.step(None);
        assert_eq!((reading.gravity, reading.age_ns), (before.gravity, before.age_ns));
    }
    assert!(feed.step(None).status.alarms.has(Fault::HostClock));
}

#[test]
fn stamps_of_another_clock_are_no_sequence_fault() {
    for offset in [3_600_000_000_000, -3_600_000_000_000, i64::MAX / 2, i64::MIN / 2] {
        let mut feed = Feed::live(Policy::Paper, tilted(15.0));
        for _ in 0..4 {
            let mut sample = feed.sample(tilted(15.0));
            sample.stamp_ns = sample.stamp_ns.saturating_add(offset);
            feed.step(Some(&sample));
            feed.now_ns += PERIOD_NS;
        }
        let counters = feed.chain.counters();
        assert_eq!((counters.of(Fault::Clock), counters.of(Fault::Sequence)), (4, 0));
        assert_eq!(feed.feel(tilted(15.0), 21).state, State::Live);
    }
}

#[test]
fn free_fall_is_a_fault_unless_the_base_may_fall() {
    let mut fixed = Feed::live(Policy::Paper, tilted(0.0));
    assert!(fixed.feel(Vector3::zeros(), 4).status.alarms.has(Fault::LowG));

    let settings = Settings { moving_base: true, jerk: 2000.0, ..Settings::default() };
    let mut falling = Feed::new(&settings);
    falling.feel(tilted(0.0), 100);
    let reading = falling.feel(Vector3::zeros(), 2000);
    assert_eq!(reading.state, State::Live);
    assert!(reading.gravity.0.norm() < 0.1);
}

/// A drift that no sample betrays ends where the mean leaves its size, or its cone.
#[test]
fn a_creeping_fault_has_an_end() {
    for direction in [Vector3::z(), -Vector3::z(), Vector3::y()] {
        let mut feed = Feed::live(Policy::Paper, tilted(15.0));
        feed.feel(tilted(15.0), 600);
        let mut drift = 0.0;
        while feed.feel(tilted(15.0) + drift * direction, 1).state == State::Live {
            drift += 0.002;
            assert!(drift < 15.0, "{direction}");
        }
        assert!(!feed.step(None).status.alarms.common(Faults::of(&[Fault::Drift, Fault::Tilt])).is_empty());
    }
}

/// A base that is laid far over is beyond what it was declared to do; back within, its sensor is trusted by itself.
#[test]
fn a_base_that_comes_back_into_its_cone_is_followed() {
    let mut feed = Feed::live(Policy::Paper, tilted(15.0));
    let tilts = (0..3000).map(|k| 15.0 + 0.02 * f64::from(k));
    let alarmed = tilts.map(|tilt| feed.feel(tilted(tilt), 1)).find(|reading| reading.status.is_alarm());
    assert!(alarmed.is_some_and(|reading| reading.status.alarms.has(Fault::Drift)));
    assert_eq!(feed.feel(tilted(60.0), 500).state, State::Held);
    assert_eq!(feed.feel(tilted(20.0), 21).state, State::Live);
}

#[test]
fn acknowledging_a_live_sensor_changes_nothing() {
    let mut feed = Feed::live(Policy::Strict, tilted(15.0));
    feed.chain.acknowledge();
    assert_eq!(feed.feel(tilted(15.0), 1).state, State::Live);
    let mut fresh = Accelerometer::new(Settings::default()).expect("the defaults");
    fresh.acknowledge();
    assert_eq!(fresh.step(0, None).state, State::Nominal);
}
