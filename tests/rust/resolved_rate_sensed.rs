//! A base whose turning a sensor measures, as resolved rate moves against it: no jump, whatever becomes of the sensor.

use gravcomp::resolved_rate::SensedBase;
use nalgebra::Vector3;
use proptest::prelude::*;

const DT: f64 = 1e-3;

/// How a base rocks, rad/s.
fn rocking(t: f64) -> Vector3<f64> {
    Vector3::new(2.0 * (6.0 * t).sin(), 1.0 * (9.0 * t).cos(), 0.3)
}

/// Its angular acceleration, rad/s².
fn tugging(t: f64) -> Vector3<f64> {
    Vector3::new(12.0 * (6.0 * t).cos(), -9.0 * (9.0 * t).sin(), 0.0)
}

/// So many cycles with the sensor trusted, or not, and stepped, or not.
fn phases() -> impl Strategy<Value = Vec<(usize, bool, bool)>> {
    proptest::collection::vec((1..80_usize, any::<bool>(), any::<bool>()), 1..20)
}

proptest! {
    /// What is blended differs by at most the sizes of both ends, and all of it goes in 50 ms.
    #[test]
    fn losing_and_finding_trust_never_makes_a_jump(phases in phases()) {
        let (mut base, mut before, mut steps, mut cycle) = (SensedBase::new(0), Vector3::zeros(), 0, 0.0);
        for (cycles, is_trusted, is_stepped) in phases {
            for _ in 0..cycles {
                steps += u64::from(is_stepped);
                cycle += 1.0;
                let _ = base.ahead(steps, DT);
                let (w, in_doubt) = base.follow(&rocking(cycle * DT), is_trusted, DT);
                prop_assert!((w - before).norm() <= 4.6 * DT / 0.05 + 15.0 * DT, "{before} {w}");
                prop_assert!(in_doubt || w == rocking(cycle * DT));
                before = w;
            }
        }
    }
}

/// Carried on by its angular acceleration, what is stepped less often than the cycle says as much as what is stepped in each.
#[test]
fn a_sensor_that_is_stepped_every_few_cycles_is_carried_on() {
    for every in [1, 2, 5, 10] {
        let (mut base, mut steps, mut seen) = (SensedBase::new(0), 0, 0.0);
        for cycle in 0..2000_u32 {
            let now = f64::from(cycle) * DT;
            if cycle % every == 0 {
                (steps, seen) = (steps + 1, now);
            }
            let ahead = base.ahead(steps, DT);
            assert!((seen + ahead - (now + 0.5 * DT)).abs() < 1e-12, "{every} {cycle}: {ahead}");
            let said = rocking(seen) + tugging(seen) * ahead;
            let (w, in_doubt) = base.follow(&said, true, DT);
            assert_eq!(in_doubt, cycle < 49, "{every} {cycle}");
            assert!(in_doubt || (w - rocking(now + 0.5 * DT)).norm() < 60.0 * ahead * ahead);
        }
    }
}

/// It is followed after 50 ms, carried on for 10 ms without a step, and left in 50 ms, each to a cycle.
#[test]
fn a_sensor_that_nobody_steps_counts_as_still_after_a_while() {
    let mut base = SensedBase::new(0);
    for cycle in 0..200 {
        let _ = base.ahead(if cycle < 100 { cycle + 1 } else { 100 }, DT);
        let (w, in_doubt) = base.follow(&rocking(0.2), true, DT);
        match cycle {
            51..=107 => assert!(!in_doubt && w == rocking(0.2), "{cycle}: {w}"),
            0..=47 | 111..=156 => assert!(in_doubt && w != Vector3::zeros(), "{cycle}: {w}"),
            161.. => assert!(in_doubt && w == Vector3::zeros(), "{cycle}: {w}"),
            _ => {}
        }
    }
}
