//! The newest value passes whole, in order, and is taken once.

use gravcomp::Slot;
use proptest::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// Words that give each other away: a mixture of two values is neither.
fn value(k: u64) -> [u64; 8] {
    let mixed = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    [0, 7, 14, 21, 28, 35, 42, 49].map(|turn| mixed.rotate_left(turn))
}

#[test]
fn an_empty_slot_has_nothing() {
    assert_eq!(Slot::<4>::new().take(), None);
    assert_eq!(Slot::<4>::default().take(), None);
}

proptest! {
    /// Whatever is put, the last of it is taken, once.
    #[test]
    fn the_newest_is_taken_once(puts in prop::collection::vec(prop::collection::vec(any::<u64>(), 0..4), 0..20)) {
        let slot = Slot::<1>::new();
        for group in puts {
            for &word in &group {
                prop_assert!(slot.put(&[word]));
            }
            prop_assert_eq!(slot.take(), group.last().map(|&word| [word]));
            prop_assert_eq!(slot.take(), None);
        }
    }
}

/// A thread that writes as fast as it can: every value read is whole and newer than the one before.
#[test]
fn a_hammering_writer_never_tears_a_value() {
    const COUNT: u64 = 300_000;
    let slot = Slot::<8>::new();
    let (mut seen, mut last) = (0_u64, 0);
    thread::scope(|scope| {
        scope.spawn(|| (1..=COUNT).for_each(|k| assert!(slot.put(&value(k)), "the only writer was turned away")));
        let mut next = 1;
        while last < COUNT {
            let Some(words) = slot.take() else { continue };
            let found =
                (next..=COUNT).find(|&k| value(k)[0] == words[0]).expect("no value that was put, or an old one");
            assert_eq!(words, value(found), "torn");
            (seen, last, next) = (seen + 1, found, found + 1);
        }
    });
    assert!(seen > 0 && slot.take().is_none());
}

/// Two writers and two readers at once: some are turned away, no value is torn.
#[test]
fn a_crowd_is_turned_away_not_mixed_up() {
    const COUNT: u64 = 50_000;
    let (slot, done) = (Slot::<8>::new(), AtomicBool::new(false));
    thread::scope(|scope| {
        let readers: Vec<_> = (0..2)
            .map(|_| {
                scope.spawn(|| {
                    while !done.load(Ordering::Relaxed) {
                        if let Some(words) = slot.take() {
                            let k = words[0].wrapping_mul(0xF1DE_83E1_9937_733D);
                            assert_eq!(words, value(k), "torn");
                        }
                    }
                })
            })
            .collect();
        let slot = &slot;
        let writers = [0, 1].map(|w| scope.spawn(move || (1..=COUNT).filter(|k| slot.put(&value(2 * k + w))).count()));
        let put: usize = writers.into_iter().map(|writer| writer.join().expect("no panic")).sum();
        assert!(put > 0);
        done.store(true, Ordering::Relaxed);
        for reader in readers {
            reader.join().expect("no panic");
        }
    });
}
