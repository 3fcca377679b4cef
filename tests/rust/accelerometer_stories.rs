//! What happens in the course of time: every scene may follow every other, under both policies.

use crate::accelerometer::{Feed, PERIOD_NS, tilted};
use crate::scale::cases;
use gravcomp::accelerometer::{Fault, Policy, Sample, Settings, State};
use gravcomp::{Mounting, STANDARD_GRAVITY};
use nalgebra::{Matrix3, Vector3};
use proptest::collection::vec;
use proptest::prelude::*;

const POLICIES: [Policy; 2] = [Policy::Paper, Policy::Strict];

fn policies() -> impl Strategy<Value = Policy> {
    prop_oneof![Just(Policy::Paper), Just(Policy::Strict)]
}

/// What goes on for a while.
#[derive(Clone, Copy, Debug)]
enum Scene {
    Good,
    Silence,
    /// All samples are this far off, m/s².
    Off(Vector3<f64>),
    /// Every second sample is.
    Spikes(Vector3<f64>),
    Factor(f64),
    /// Samples come that much too late, or from the future, ns.
    Delay(i64),
    /// The gyroscope says this.
    Turn(Option<Vector3<f64>>),
    Restart,
    /// The clock jumps, ns.
    Clock(i64),
    /// No cycle for so long, ns.
    Stall(i64),
    Acknowledge,
}

fn scenes() -> impl Strategy<Value = Scene> {
    let vector = || prop::array::uniform3(-20.0..20.0_f64).prop_map(Vector3::from);
    prop_oneof![
        8 => Just(Scene::Good),
        2 => Just(Scene::Silence),
        2 => vector().prop_map(Scene::Off),
        2 => vector().prop_map(|v| Scene::Off(0.1 * v)),
        1 => vector().prop_map(Scene::Spikes),
        1 => prop_oneof![Just(f64::NAN), Just(-1.0), Just(0.1), Just(0.0), Just(100.0)].prop_map(Scene::Factor),
        1 => (-100_000_000..200_000_000_i64).prop_map(Scene::Delay),
        2 => proptest::option::of(vector().prop_map(|v| 0.1 * v)).prop_map(Scene::Turn),
        1 => Just(Scene::Restart),
        1 => prop_oneof![-1_000_000_000..1_000_000_000_i64, Just(-3_600_000_000_000)].prop_map(Scene::Clock),
        1 => (0..2_000_000_000_i64).prop_map(Scene::Stall),
        3 => Just(Scene::Acknowledge),
    ]
}

/// Plays the scene for so many periods; the states that were seen.
fn play(feed: &mut Feed, scene: Scene, periods: u32) {
    let up = tilted(15.0);
    match scene {
        Scene::Restart => feed.seq = 0,
        Scene::Clock(jump) => feed.now_ns += jump,
        Scene::Stall(pause) => feed.now_ns += pause,
        Scene::Acknowledge => feed.chain.acknowledge(),
        _ => {}
    }
    let rate = feed.rate;
    for k in 0..periods {
        match scene {
            Scene::Silence => _ = feed.silence(1),
            Scene::Off(error) => _ = feed.feel(up + error, 1),
            Scene::Spikes(error) => _ = feed.feel(up + error * f64::from(k % 2), 1),
            Scene::Factor(factor) => _ = feed.feel(up * factor, 1),
            Scene::Delay(delay_ns) => late(feed, up, delay_ns),
            Scene::Turn(turn) => {
                feed.rate = turn;
                feed.feel(up, 1);
            }
            _ => _ = feed.feel(up, 1),
        }
    }
    feed.rate = rate;
}

fn late(feed: &mut Feed, force: Vector3<f64>, delay_ns: i64) {
    let sample = feed.sample(force);
    feed.step(Some(&Sample { stamp_ns: sample.stamp_ns - delay_ns, ..sample }));
    feed.now_ns += PERIOD_NS;
}

proptest! {
    #![proptest_config(cases(150))]

    /// Every cycle is checked by [`Feed`]: finite, within its rate, state and ages in step. A fault is left by an
    /// acknowledgement alone, counters only grow, and in the end all is forgotten.
    #[test]
    fn any_story_ends_well(
        policy in policies(),
        gyro in any::<bool>(),
        story in vec((scenes(), 1..80_u32), 1..30),
    ) {
        let position = if gyro { Vector3::new(0.3, -0.2, 0.4) } else { Vector3::zeros() };
        let mounting = Mounting::new(Matrix3::identity(), position).expect("a rotation");
        let mut feed = Feed::new(&Settings { policy, mounting, ..Settings::default() });
        feed.rate = gyro.then(Vector3::zeros);
        for (scene, periods) in story {
            let (state, before) = (feed.chain.reading().state, *feed.chain.counters());
            play(&mut feed, scene, periods);
            let now = feed.chain.reading().state;
            prop_assert!(state != State::Fault || now == State::Fault || matches!(scene, Scene::Acknowledge));
            let after = feed.chain.counters();
            prop_assert!(before.faults.iter().zip(after.faults).all(|(before, after)| *before <= after));
            prop_assert!(before.received <= after.received && before.accepted <= after.accepted);
            prop_assert!(after.accepted <= after.received);
        }
        // Twice: what a bad gyroscope had carried away may come to light only when all is well again.
        for _ in 0..2 {
            feed.feel(tilted(15.0), 5);
            feed.chain.acknowledge();
            feed.feel(tilted(15.0), 30);
        }
        prop_assert_eq!(feed.feel(tilted(15.0), 60).state, State::Live);
        prop_assert!(feed.chain.armable() && (feed.step(None).gravity.0 + tilted(15.0)).norm() < 0.1);
    }

    /// The state of a silent sensor is its age, whatever the cycle and the limits.
    #[test]
    fn a_silent_sensor_ages_through_its_states(
        policy in policies(),
        limits in prop::array::uniform3(0..300_000_000_i64),
        cycles in vec(0..30_000_000_i64, 1..200),
    ) {
        let max_age_ns = 20_000_000 + limits[0];
        let hold_ns = max_age_ns + limits[1];
        let fault_after_ns = hold_ns + limits[2];
        let settings = Settings { policy, max_age_ns, hold_ns, fault_after_ns, ..Settings::default() };
        let mut feed = Feed::new(&settings);
        feed.feel(tilted(15.0), 30);
        let sample = feed.sample(tilted(15.0));
        let mut age = feed.step(Some(&sample)).age_ns.expect("it is live");
        prop_assert_eq!(age, feed.now_ns - sample.stamp_ns);
        for cycle in cycles {
            feed.now_ns += cycle;
            age += cycle;
            let reading = feed.step(None);
            let wanted = match policy {
                _ if age <= max_age_ns => State::Live,
                Policy::Paper => State::Held,
                Policy::Strict if age <= hold_ns => State::Held,
                Policy::Strict if age <= fault_after_ns => State::Degraded,
                Policy::Strict => State::Fault,
            };
            prop_assert_eq!((reading.age_ns, reading.state), (Some(age), wanted));
            prop_assert_eq!(reading.status.alarms.has(Fault::Age), wanted != State::Live);
        }
    }

    /// Whatever the first sample is, trust comes at most ten samples later than without it.
    #[test]
    fn a_bad_first_sample_delays_trust_but_little(
        policy in policies(),
        seq in prop_oneof![any::<u64>(), 0..10_u64, Just(u64::MAX)],
        stamp in prop_oneof![any::<i64>(), -50_000_000..5_000_000_i64],
        force in prop::array::uniform3(prop_oneof![any::<u64>().prop_map(f64::from_bits), -20.0..20.0_f64]),
        rate in proptest::option::of(prop::array::uniform3(any::<u64>().prop_map(f64::from_bits))),
    ) {
        let mut feed = Feed::of(policy);
        let [specific_force, angular_velocity] = [Some(force), rate].map(|v| v.map(Vector3::from));
        let specific_force = specific_force.expect("it was given");
        feed.step(Some(&Sample { seq, stamp_ns: stamp, specific_force, angular_velocity }));
        feed.now_ns += PERIOD_NS;
        prop_assert_eq!(feed.feel(tilted(15.0), 30).state, State::Live);
    }

    /// More samples than cycles: only the newest is handed in, and it may come from anywhere in between.
    #[test]
    fn any_number_of_samples_in_a_cycle_is_one_sensor(policy in policies(), counts in vec(0..5_usize, 200)) {
        let settings = Settings { policy, sample_rate_hz: 250.0, ..Settings::default() };
        let mut feed = Feed::new(&settings);
        for count in counts {
            for _ in 0..count {
                let sample = feed.sample(tilted(15.0));
                feed.now_ns += 1_000_000;
                feed.step(Some(&Sample { stamp_ns: feed.now_ns, ..sample }));
            }
            feed.now_ns += 5_000_000;
        }
        let counters = feed.chain.counters();
        prop_assert_eq!(counters.of(Fault::Sequence) + counters.of(Fault::Jerk) + counters.of(Fault::Clock), 0);
    }
}

/// No cycle for seconds: the sensor may have been well, but nobody looked.
#[test]
fn a_stalled_loop_makes_no_step_and_trusts_nothing_that_it_slept_through() {
    for policy in POLICIES {
        let mut feed = Feed::live(policy, tilted(15.0));
        feed.now_ns += 5_000_000_000;
        let sample = feed.sample(tilted(30.0));
        let reading = feed.step(Some(&sample));
        let wanted = if policy == Policy::Paper { State::Held } else { State::Fault };
        assert_eq!((reading.state, reading.status.alarms.has(Fault::Age)), (wanted, true));
    }
}

/// An acknowledgement is worth as much time as a sensor needs to be trusted, however slow it is.
#[test]
fn a_slow_sensor_can_come_back_from_a_fault() {
    let settings = Settings {
        policy: Policy::Strict,
        sample_rate_hz: 10.0,
        cutoff_hz: None,
        max_age_ns: 400_000_000,
        hold_ns: 400_000_000,
        fault_after_ns: 800_000_000,
        no_sensor_ns: 800_000_000,
        ..Settings::default()
    };
    let mut feed = Feed::new(&settings);
    let feel = |feed: &mut Feed, samples: u32| {
        for _ in 0..samples {
            feed.feel(tilted(15.0), 1);
            feed.silence(9);
        }
        feed.step(None).state
    };
    assert_eq!(feel(&mut feed, 25), State::Live);
    assert_eq!(feed.silence(100).state, State::Fault);
    feed.chain.acknowledge();
    assert_eq!(feel(&mut feed, 19), State::Degraded);
    assert_eq!(feel(&mut feed, 1), State::Live);
    assert_eq!(feed.silence(100).state, State::Fault);
    feed.chain.acknowledge();
    assert_eq!(feed.silence(300).state, State::Fault, "but not for ever");
}

/// The paper's rule arms without a sensor; an alarm of a clock that jumped once must not forbid that for ever.
#[test]
fn alarms_without_a_sensor_go_when_they_are_acknowledged() {
    let mut feed = Feed::of(Policy::Paper);
    feed.silence(2);
    feed.now_ns -= 3_600_000_000_000;
    assert!(feed.silence(1).status.alarms.has(Fault::HostClock) && !feed.chain.armable());
    feed.chain.acknowledge();
    assert!(feed.chain.armable());
    assert!(!feed.silence(1).status.is_alarm());
    for wrong in [Vector3::new(0.0, f64::NAN, STANDARD_GRAVITY), tilted(15.0) * 100.0, -tilted(15.0)] {
        assert!(feed.feel(wrong, 10).status.is_alarm());
        feed.chain.acknowledge();
        assert!(feed.feel(wrong, 10).status.is_alarm(), "what is still there comes again: {wrong}");
    }
}

/// A number of 64 bits that begins anew, and one that stands still.
#[test]
fn numbers_that_wrap_or_stand_still_are_noticed() {
    let mut feed = Feed::of(Policy::Strict);
    feed.seq = u64::MAX - 50;
    assert_eq!(feed.feel(tilted(15.0), 50).state, State::Live);
    feed.seq = 0;
    assert!(feed.feel(tilted(15.0), 3).status.alarms.has(Fault::Sequence));
    assert_eq!(feed.feel(tilted(15.0), 3).state, State::Live);
    for _ in 0..30 {
        feed.seq = 7;
        assert!(feed.feel(tilted(15.0), 1).state != State::Live || feed.chain.counters().of(Fault::Sequence) < 6);
    }
    assert!(feed.step(None).status.alarms.has(Fault::Sequence));
}
