//! What was wrong since the latch was last cleared, and whether the drive is armed.
//!
//! Interrupts of different urgency trip it, a task reads and clears it, so it is a few atomic words:
//! nothing is locked. The set of all causes and the number of the first share one word, which is
//! exchanged as a whole: there is no moment at which a cause is latched and the first one unnamed.

use core::sync::atomic::{
    AtomicBool, AtomicU32,
    Ordering::{AcqRel, Acquire, Relaxed, Release},
};

use super::output::Outputs;
use super::{Fault, Faults};
use crate::app::arming::Switch;

/// Where the number of the first cause stands in the word; below it, one bit a cause.
const FIRST: u32 = 27;

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
    /// The causes, and above them the number of the first; 0 while nothing is latched.
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
        if self.word.load(Acquire) == 0 {
            // Before the fault, which a reader looks for first. Should an interrupt come in between
            // with a fault of its own, that one is named and the times are those of one moment.
            self.tick.store(tick, Relaxed);
        }
        let named = first.number() << FIRST;
        // The closure always gives a word, so there is no failure.
        let _ = self.word.fetch_update(AcqRel, Acquire, |word| {
            let first = if word == 0 { named } else { word & !CAUSES };
            Some(first | (word & CAUSES) | faults.bits())
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
        let fault = Fault::ALL.get((word >> FIRST) as usize)?;
        (word & CAUSES != 0).then(|| Cause {
            fault: *fault,
            tick: self.tick.load(Relaxed),
        })
    }

    /// Whether anything is latched.
    pub fn is_tripped(&self) -> bool {
        self.word.load(Acquire) != 0
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
        let word = self.word.load(Acquire);
        if self.is_armed() {
            return Err(NotCleared::Armed);
        }
        let present = self.present();
        if !present.is_empty() {
            return Err(NotCleared::Present(present));
        }
        match self.word.compare_exchange(word, 0, AcqRel, Acquire) {
            Ok(_) => Ok(()),
            Err(_) => Err(NotCleared::Renewed),
        }
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
