//! What was wrong since the latch was last cleared, and whether the drive is armed.
//!
//! Interrupts of different urgency trip it, a task reads and clears it, so it is a few atomic words:
//! nothing is locked. The set of all causes and the number of the first share one word, which is
//! exchanged as a whole: there is no moment at which a cause is latched and the first one unnamed. Whoever
//! clears marks that word first and exchanges it afterwards, which fails where a fault took the mark away.

use super::output::Outputs;
use super::{Fault, Faults};
use crate::app::arming::Switch;
use crate::app::atomic::{
    AtomicBool, AtomicU32,
    Ordering::{AcqRel, Acquire, Relaxed, Release},
};

/// Where the number of the first cause stands in the word; below it, one bit a cause.
const FIRST: u32 = 26;

/// Above it, whether somebody is about to clear: every fault takes that back, also one that is latched already.
const CLEARING: u32 = 1 << 31;

const NUMBER: u32 = (CLEARING >> FIRST) - 1;

const _: () = assert!(Fault::ALL.len() <= FIRST as usize);

const CAUSES: u32 = (1 << FIRST) - 1;

/// The latch.
///
/// ```
/// use firmware::app::fault::latch::{Cause, Latch, NotCleared};
/// use firmware::app::fault::{Fault, Faults};
///
/// let latch = Latch::new();
/// assert_eq!(latch.arm(), Ok(()));
/// latch.watch(Fault::OverVoltage.into(), 100);
/// latch.trip(Fault::NonFinite, 120);
/// let first = Cause { fault: Fault::OverVoltage, tick: 100 };
/// assert_eq!(latch.first(), Some(first));
/// // First the drive is disarmed and the condition gone.
/// assert_eq!(latch.clear(), Err(NotCleared::Armed));
/// latch.disarm();
/// assert_eq!(latch.clear(), Err(NotCleared::Present(Fault::OverVoltage.into())));
/// latch.watch(Faults::NONE, 200);
/// assert_eq!(latch.clear(), Ok(()));
/// assert_eq!(latch.first(), None);
/// ```
#[derive(Debug, Default)]
pub struct Latch {
    /// The causes, above them the number of the first, and [`CLEARING`].
    word: AtomicU32,
    /// When the first came.
    tick: AtomicU32,
    /// Conditions that hold now.
    present: AtomicU32,
    armed: AtomicBool,
}

/// The first fault, and when it came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub struct Cause {
    /// Which.
    pub fault: Fault,
    /// Plant ticks from the start of the clock to it; they wrap after 2³², 60 hours at 20 kHz.
    pub tick: u32,
}

/// A latch that somebody is about to clear.
#[derive(Debug)]
pub struct Clearing<'l> {
    latch: &'l Latch,
    /// What is to be forgotten.
    word: u32,
}

impl Clearing<'_> {
    /// Forgets the causes that were looked at.
    ///
    /// # Errors
    /// The drive is armed, a condition still holds, or a fault came since.
    pub fn end(self) -> Result<(), NotCleared> {
        let Self { latch, word } = self;
        if latch.is_armed() {
            return Err(NotCleared::Armed);
        }
        let present = latch.present();
        if !present.is_empty() {
            return Err(NotCleared::Present(present));
        }
        match latch.word.compare_exchange(word, 0, AcqRel, Acquire) {
            Ok(_) => Ok(()),
            Err(_) => Err(NotCleared::Renewed),
        }
    }
}

/// Why the latch was not cleared. Nothing of it changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum NotCleared {
    /// The drive is armed.
    Armed,
    /// These conditions still hold.
    Present(Faults),
    /// Another fault came at that moment.
    Renewed,
}

impl Switch for &Latch {
    type Refusal = Faults;

    fn on(&mut self) -> Result<(), Faults> {
        self.arm()
    }

    fn off(&mut self) {
        self.disarm();
    }
}

impl Latch {
    /// Nothing latched, disarmed.
    pub const fn new() -> Self {
        Self {
            word: AtomicU32::new(0),
            tick: AtomicU32::new(0),
            present: AtomicU32::new(0),
            armed: AtomicBool::new(false),
        }
    }

    /// Latches a fault that happened at a plant tick.
    pub fn trip(&self, fault: Fault, tick: u32) {
        self.latch(fault.into(), tick);
    }

    /// Takes the conditions that hold at a plant tick, in place of those before, and latches them.
    /// One caller: whoever runs the monitors.
    pub fn watch(&self, present: Faults, tick: u32) {
        self.present.store(present.bits(), Release);
        self.latch(present, tick);
    }

    fn latch(&self, faults: Faults, tick: u32) {
        let Some(first) = faults.first() else {
            return;
        };
        if !self.is_tripped() {
            // Before the fault, which a reader looks for first. Should an interrupt come in between
            // with a fault of its own, that one is named and the times are those of one moment.
            self.tick.store(tick, Relaxed);
        }
        let named = first.number() << FIRST;
        // The closure always gives a word, so there is no failure.
        let _ = self.word.fetch_update(AcqRel, Acquire, |word| {
            let word = if word & CAUSES == 0 {
                named
            } else {
                word & !CLEARING
            };
            Some(word | faults.bits())
        });
    }

    /// All causes since the latch was cleared.
    pub fn causes(&self) -> Faults {
        Faults::from_bits(self.word.load(Acquire) & CAUSES)
    }

    /// The first of them.
    pub fn first(&self) -> Option<Cause> {
        let word = self.word.load(Acquire);
        // No cause, no number: an empty word is not the fault of number 0.
        let fault = Fault::ALL.get((word >> FIRST & NUMBER) as usize)?;
        (word & CAUSES != 0).then(|| Cause {
            fault: *fault,
            tick: self.tick.load(Relaxed),
        })
    }

    /// Whether anything is latched.
    pub fn is_tripped(&self) -> bool {
        self.word.load(Acquire) & CAUSES != 0
    }

    /// Conditions that hold now.
    pub fn present(&self) -> Faults {
        Faults::from_bits(self.present.load(Acquire))
    }

    /// Forgets the causes.
    ///
    /// # Errors
    /// The drive is armed, or a condition still holds.
    pub fn clear(&self) -> Result<(), NotCleared> {
        self.begin_to_clear().end()
    }

    /// Looks at what is latched, to forget it.
    ///
    /// ```
    /// use firmware::app::fault::Fault;
    /// use firmware::app::fault::latch::{Latch, NotCleared};
    ///
    /// let latch = Latch::new();
    /// latch.trip(Fault::QueueOverflow, 1);
    /// let clearing = latch.begin_to_clear();
    /// // An interrupt comes in between, with the same fault once more.
    /// latch.trip(Fault::QueueOverflow, 2);
    /// assert_eq!(clearing.end(), Err(NotCleared::Renewed));
    /// assert!(latch.is_tripped());
    /// assert_eq!(latch.clear(), Ok(()));
    /// ```
    pub fn begin_to_clear(&self) -> Clearing<'_> {
        let word = self.word.fetch_or(CLEARING, AcqRel) | CLEARING;
        Clearing { latch: self, word }
    }

    /// Lets the drive act from now on.
    ///
    /// # Errors
    /// What is latched.
    pub fn arm(&self) -> Result<(), Faults> {
        let causes = self.causes();
        if causes.is_empty() {
            self.armed.store(true, Release);
            Ok(())
        } else {
            Err(causes)
        }
    }

    /// Takes the drive's power.
    pub fn disarm(&self) {
        self.armed.store(false, Release);
    }

    /// Whether the drive may act, should nothing be latched.
    pub fn is_armed(&self) -> bool {
        self.armed.load(Acquire)
    }

    /// What the outputs do now.
    pub fn outputs(&self) -> Outputs {
        Outputs::of(self.causes(), self.is_armed())
    }

    /// Another actuator, armed: what was wrong with the one before is nothing to it.
    pub(in crate::app) fn begin_anew(&self) {
        self.present.store(0, Release);
        self.word.store(0, Release);
        self.armed.store(true, Release);
    }
}
