//! The newest value from one thread for another, without a lock: neither side ever waits.
//!
//! Three places hold a value each. The writer fills the one that is its own and exchanges it for the one in the middle; the
//! reader exchanges its own for the one in the middle where that is newer. What stands in the middle is exchanged as a
//! whole, so a value is never seen half-written, and a slow reader sees the newest, not the next.

use core::array;
use core::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};

/// Set in the middle where the reader has not seen it yet.
const NEW: u8 = 4;

/// Index of a place, without [`NEW`].
const PLACE: u8 = 3;

/// One place: `N` words.
type Place<const N: usize> = [AtomicU64; N];

/// A slot for the newest `N` words.
///
/// One writer and one reader are served at a time; who comes while another of its kind is busy is turned away instead of
/// kept waiting.
#[derive(Debug)]
pub struct Slot<const N: usize> {
    places: [Place<N>; 3],
    middle: AtomicU8,
    back: AtomicU8,
    front: AtomicU8,
    writing: AtomicBool,
    reading: AtomicBool,
}

impl<const N: usize> Default for Slot<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Slot<N> {
    /// An empty slot.
    #[must_use]
    pub fn new() -> Self {
        Self {
            places: array::from_fn(|_| array::from_fn(|_| AtomicU64::new(0))),
            middle: AtomicU8::new(0),
            back: AtomicU8::new(1),
            front: AtomicU8::new(2),
            writing: AtomicBool::new(false),
            reading: AtomicBool::new(false),
        }
    }

    /// Makes `words` the newest value; false, and nothing done, while another thread is writing.
    pub fn put(&self, words: &[u64; N]) -> bool {
        if self.writing.swap(true, Ordering::Acquire) {
            return false;
        }
        let back = self.back.load(Ordering::Relaxed);
        for (word, &value) in self.place(back).iter().zip(words) {
            word.store(value, Ordering::Relaxed);
        }
        let middle = self.middle.swap(back | NEW, Ordering::AcqRel);
        self.back.store(middle & PLACE, Ordering::Relaxed);
        self.writing.store(false, Ordering::Release);
        true
    }

    /// The newest value if nobody has taken it yet; `None` too while another thread is taking it.
    pub fn take(&self) -> Option<[u64; N]> {
        if self.middle.load(Ordering::Relaxed) & NEW == 0 || self.reading.swap(true, Ordering::Acquire) {
            return None;
        }
        let front = self.front.load(Ordering::Relaxed);
        let middle = self.middle.swap(front, Ordering::AcqRel);
        let newest = middle & PLACE;
        self.front.store(newest, Ordering::Relaxed);
        let place = self.place(newest);
        let words = array::from_fn(|i| place[i].load(Ordering::Relaxed));
        self.reading.store(false, Ordering::Release);
        (middle & NEW != 0).then_some(words)
    }

    /// Indices are 0 to 2 by construction.
    fn place(&self, index: u8) -> &Place<N> {
        &self.places[usize::from(index) % 3]
    }
}
