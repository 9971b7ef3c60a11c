//! Whether each task goes on.
//!
//! An interrupt that is in time proves nothing about the tasks below it. So each of them says that it goes
//! on, at least once in its time, also while it has nothing to do; a control step vouches for the program only while
//! none is silent, and without that the watchdog starts the processor anew.

use core::sync::atomic::{AtomicU32, Ordering::Relaxed};

use super::timing::PLANT_PERIOD_US;

/// A task of an image that is operated from a console.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Takes bytes from the terminal.
    Reception,
    /// Sends answers to it.
    Answers,
    /// Does what it is told.
    Operator,
    /// Does the long work.
    Evaluation,
}

/// How often a task goes on that has nothing to do, ms.
pub const IDLE_PERIOD_MS: u32 = 50;

/// How long a task may be silent, ms: one that is late by a few of its periods is none that hangs.
const LONGEST_SILENCE_MS: u32 = 5 * IDLE_PERIOD_MS;

/// The same of the long work, which has no place to say anything in: a check of the longest log is some 4e10
/// instructions, of three cycles of 168 MHz each at worst, and the interrupts take up to a half of the time.
const LONGEST_WORK_MS: u32 = 30 * 60 * 1000;

impl Task {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::Reception,
        Self::Answers,
        Self::Operator,
        Self::Evaluation,
    ];

    /// Plant ticks for which it may be silent.
    pub const fn longest_silence(self) -> u32 {
        let milliseconds = match self {
            Self::Reception | Self::Answers | Self::Operator => LONGEST_SILENCE_MS,
            Self::Evaluation => LONGEST_WORK_MS,
        };
        milliseconds * (1000 / PLANT_PERIOD_US)
    }
}

/// When each task last went on, in plant ticks.
///
/// ```
/// use firmware::app::liveness::{Liveness, Task};
///
/// let tasks = Liveness::new();
/// assert!(tasks.all_go_on(1000));
/// for task in Task::ALL {
///     tasks.goes_on(task, u32::MAX);
/// }
/// // The ticks wrap.
/// let longest = Task::Operator.longest_silence();
/// assert!(tasks.all_go_on(longest - 1));
/// assert!(!tasks.all_go_on(longest));
/// ```
#[derive(Debug, Default)]
pub struct Liveness([AtomicU32; Task::ALL.len()]);

impl Liveness {
    /// All went on at tick 0.
    pub const fn new() -> Self {
        Self([const { AtomicU32::new(0) }; Task::ALL.len()])
    }

    /// A task goes on.
    pub fn goes_on(&self, task: Task, tick: u32) {
        self.0[task as usize].store(tick, Relaxed);
    }

    /// Whether no task has been silent for too long.
    pub fn all_go_on(&self, tick: u32) -> bool {
        Task::ALL
            .into_iter()
            .zip(&self.0)
            .all(|(task, last)| tick.wrapping_sub(last.load(Relaxed)) <= task.longest_silence())
    }
}
