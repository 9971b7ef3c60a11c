//! What the winding bears, by I² t: its heat, and what is known of it after a start.
//!
//! dQ/dt = i² − I², Q ≥ 0, with the continuous current *I*. The winding bears Q up to (Î² − I²) t: the peak current Î
//! for the peak time *t* after rest. Beyond it is [`Fault::Overload`](super::Fault::Overload), until Q is 0 again.
//!
//! A reset does not cool a winding, so its heat outlives one: it is [kept](Kept) in RAM that no start clears, and counts on
//! from there. Without a supply the RAM loses it, and for an unknown time the winding cools. IEC 61800-5-1 wants a thermal
//! memory that survives that, or the hottest state for the beginning. This is the second: beside the heat that was
//! measured runs the one that there could be, by the same equation, from the most that the winding bears. What was
//! measured is a fault where it is too much. What there only could be narrows the range of the current, down to
//! the continuous one where it reaches the most: then Q grows no more, whatever it was.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use crate::app::square_root::square_root;

/// Share of the most heat that is left when the range of the current begins to narrow. With it Q approaches the most as
/// e^(−t/T) with T this share of the peak time: at 0.1 and 1 s a hundred control steps.
const MARGIN: f32 = 0.1;

/// The winding's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Coefficients {
    peak: f32,
    continuous: f32,
    /// Most current that the drive lets flow, A.
    limit: f32,
    period: f32,
    /// Heat that is too much, A² s.
    most: f32,
}

/// The heat, as shares of the most that the winding bears.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Heat {
    /// What was measured.
    measured: f32,
    /// What there could be; at least what was measured.
    possible: f32,
    /// Whether it was too much, and is not gone yet.
    too_much: bool,
}

/// Of 16 bits, for a share from 0 to 1.
const ONE: f32 = 65535.0;

impl Heat {
    /// None, for sure.
    pub const NONE: Self = Self {
        measured: 0.0,
        possible: 0.0,
        too_much: false,
    };

    /// As hot as the winding may be; none of it was measured.
    pub const UNKNOWN: Self = Self {
        measured: 0.0,
        possible: 1.0,
        too_much: false,
    };

    /// In one word: what there could be in the upper half, what was measured in the lower one, rounded up, with the
    /// lowest bit for too much.
    pub fn word(self) -> u32 {
        // The conversion holds the ends.
        let share = |share: f32| u32::from(libm::ceilf(share * ONE) as u16);
        share(self.possible) << 16 | share(self.measured) & !1 | u32::from(self.too_much)
    }

    /// Of such a word.
    pub fn of_word(word: u32) -> Self {
        let share = |bits: u32| (bits & 0xffff) as f32 / ONE;
        let measured = share(word | 1);
        Self {
            measured,
            possible: share(word >> 16).max(measured),
            too_much: word & 1 != 0,
        }
    }
}

impl Coefficients {
    pub(super) fn new([peak, continuous, limit]: [f32; 3], peak_time: f32, period: f32) -> Self {
        Self {
            peak,
            continuous,
            limit: limit.max(continuous),
            period,
            most: (peak * peak - continuous * continuous) * peak_time,
        }
    }

    /// The heat of a winding with these numbers, where it was reckoned with others. What was measured is as many A² s as
    /// before; what only could be is as much of what the winding bears as before.
    pub(super) fn taken_over(&self, before: Self, heat: Heat) -> Heat {
        let measured = heat.measured * (before.most / self.most);
        let is_known = heat.possible <= heat.measured;
        Heat {
            measured,
            possible: if is_known {
                measured
            } else {
                heat.possible.max(measured)
            },
            ..heat
        }
    }

    /// Takes a current, A, that flowed for a control period. True if the winding was too hot, and is not cool yet. A
    /// current that is not a number says nothing here: that is another fault.
    pub(super) fn step(&self, heat: &mut Heat, current: f32) -> bool {
        if current.is_finite() {
            // What is beyond the peak is another fault's, and must not overflow here.
            let current = current.abs().min(self.peak);
            let squares = current * current - self.continuous * self.continuous;
            let rise = squares * self.period / self.most;
            heat.measured = (heat.measured + rise).max(0.0);
            heat.possible = (heat.possible + rise).max(heat.measured);
        }
        let limit = if heat.too_much { 0.0 } else { 1.0 };
        heat.too_much = heat.measured > limit;
        heat.too_much
    }

    /// Most current that flows while the winding could be as hot as it bears, A. What was measured alone narrows nothing.
    pub(super) fn current(&self, heat: &Heat) -> f32 {
        if heat.possible <= heat.measured {
            return self.limit;
        }
        let left = ((1.0 - heat.possible) / MARGIN).clamp(0.0, 1.0);
        let [most, least] = [self.limit, self.continuous].map(|current| current * current);
        square_root(least + (most - least) * left)
    }
}

/// Where the heat is kept over a reset: a word and its complement. What they are after power-on, or torn by a reset between
/// the two, does not fit together.
///
/// ```
/// use firmware::app::fault::overload::{Heat, Kept};
///
/// let kept = Kept::new();
/// assert_eq!(kept.get(), Heat::UNKNOWN);
/// let word = Heat::NONE.word();
/// kept.set(word);
/// // What was measured is rounded up by a unit of the word.
/// assert_eq!(kept.get(), Heat::of_word(word));
/// assert_ne!(kept.get(), Heat::UNKNOWN);
/// ```
#[derive(Debug, Default)]
#[repr(C)]
pub struct Kept {
    word: AtomicU32,
    complement: AtomicU32,
}

impl Kept {
    /// Nothing.
    pub const fn new() -> Self {
        Self {
            word: AtomicU32::new(0),
            complement: AtomicU32::new(0),
        }
    }

    /// Keeps a [word](Heat::word).
    pub fn set(&self, word: u32) {
        self.word.store(word, Relaxed);
        self.complement.store(!word, Relaxed);
    }

    /// What was kept.
    pub fn get(&self) -> Heat {
        let [word, complement] = [&self.word, &self.complement].map(|word| word.load(Relaxed));
        if word == !complement {
            Heat::of_word(word)
        } else {
            Heat::UNKNOWN
        }
    }
}
