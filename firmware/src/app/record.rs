//! From the control interrupt to the log.
//!
//! The interrupt never logs: it puts a numbered sample into a queue and counts those that find it
//! full. A task, above the one that evaluates, takes them out, logs them and keeps the last seconds
//! of them in the [`Memory`].

use core::sync::atomic::{
    AtomicU8, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

use heapless::spsc::{Consumer, Producer};

use super::fault::Fault;
use super::memory::Memory;
use super::wiring::{Truth, Wiring};

/// What the controller saw and did in one step, in counts of its converters, and the state of the
/// emulated actuator behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Number of the control step, from 0. A gap is a sample that was dropped.
    pub sequence: u32,
    /// Position asked for, rad.
    pub command: f32,
    /// Duty of the bridge from this sample to the next.
    pub duty: i16,
    /// Measured position.
    pub position: i32,
    /// Measured motor current.
    pub current: i16,
    /// What was measured.
    pub truth: Truth,
    /// What happened in this step.
    pub marks: Marks,
}

/// What a sample tells beside its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Marks {
    /// A command signal began.
    pub command: bool,
    /// A fault is latched.
    pub fault: bool,
    /// The bridge drives, from this sample to the next.
    pub driven: bool,
}

/// What the ends of the queue tell each other beside the samples.
///
/// A recording is asked for, begins with the first control step of a plant that begins anew, and
/// ends with the last step that is to be recorded. Asked for again, whatever the loop still does
/// with the plant before belongs to no recording.
#[derive(Debug, Default)]
pub struct Progress {
    dropped: AtomicU32,
    stage: AtomicU8,
}

const ASKED: u8 = 1;
const RUNNING: u8 = 2;
const FINISHED: u8 = 3;

impl Progress {
    /// Nothing recorded.
    pub const fn new() -> Self {
        Self {
            dropped: AtomicU32::new(0),
            stage: AtomicU8::new(0),
        }
    }

    /// Samples that found the queue full.
    pub fn dropped(&self) -> u32 {
        self.dropped.load(Relaxed)
    }

    /// Asks for a recording. The plant and the controller to be recorded must come next.
    pub fn ask(&self) {
        self.stage.store(ASKED, Release);
    }

    /// Whether the first sample of what was asked for has been taken.
    pub fn begun(&self) -> bool {
        self.stage.load(Acquire) >= RUNNING
    }

    /// Whether the last sample is in the queue.
    pub fn finished(&self) -> bool {
        self.stage.load(Acquire) == FINISHED
    }
}

/// The interrupt's end of the queue.
pub struct Recorder {
    samples: Producer<'static, Sample>,
    progress: &'static Progress,
}

impl Recorder {
    /// Takes the producing end.
    pub fn new(samples: Producer<'static, Sample>, progress: &'static Progress) -> Self {
        Self { samples, progress }
    }

    /// Says that the next sample is the first.
    pub fn begin(&mut self) {
        self.progress.dropped.store(0, Relaxed);
        self.progress.stage.store(RUNNING, Release);
    }

    /// Queues a sample of a recording that has begun, or counts it as dropped.
    pub fn push(&mut self, sample: Sample) {
        if self.progress.stage.load(Relaxed) != RUNNING {
            return;
        }
        if self.samples.enqueue(sample).is_err() {
            // The only writer: a load and a store do.
            self.progress
                .dropped
                .store(self.progress.dropped().saturating_add(1), Relaxed);
        }
    }

    /// Says that no sample follows.
    pub fn finish(&mut self) {
        if self.progress.stage.load(Relaxed) == RUNNING {
            self.progress.stage.store(FINISHED, Release);
        }
    }
}

/// How a recording ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub struct Outcome {
    /// Samples logged.
    pub samples: u32,
    /// Samples that found the queue full.
    pub dropped: u32,
    /// The latched fault.
    pub fault: Option<Fault>,
}

impl Outcome {
    /// Whether the log is whole and the drive in order.
    pub fn is_success(&self) -> bool {
        self.dropped == 0 && self.fault.is_none()
    }
}

/// The task's end of the queue.
pub struct Recording {
    samples: Consumer<'static, Sample>,
    progress: &'static Progress,
    wiring: &'static Wiring,
    logged: u32,
}

impl Recording {
    /// Takes the consuming end.
    pub fn new(
        samples: Consumer<'static, Sample>,
        progress: &'static Progress,
        wiring: &'static Wiring,
    ) -> Self {
        Self {
            samples,
            progress,
            wiring,
            logged: 0,
        }
    }

    /// Forgets what is left of the recording before, which a fault may have ended early. To be called
    /// once a recording is asked for and before it begins.
    pub fn discard(&mut self) {
        while self.samples.dequeue().is_some() {}
    }

    /// Empties the queue into the memory, each sample by way of `log`. Once the profile or a fault
    /// has ended the recording, says how.
    pub fn drain(&mut self, memory: &mut Memory, mut log: impl FnMut(&Sample)) -> Option<Outcome> {
        // Before the queue is emptied: what was queued before the end is then still logged.
        let fault = self.wiring.fault().filter(|_| self.progress.begun());
        let ended = self.progress.finished() || fault.is_some();
        while let Some(sample) = self.samples.dequeue() {
            log(&sample);
            memory.push(&sample);
            self.logged += 1;
        }
        ended.then(|| Outcome {
            samples: core::mem::take(&mut self.logged),
            dropped: self.progress.dropped(),
            fault,
        })
    }
}

/// Logs a sample in SI units.
#[cfg(feature = "tasks")]
pub fn log_sample(sample: &Sample, converters: &super::conversion::Converters) {
    log_values(sample.sequence, &super::capture::values(sample, converters));
}

/// Logs the values of a sample, in the order of [`Quantity`](super::capture::Quantity); NaN for what
/// is not known.
#[cfg(feature = "tasks")]
pub fn log_values(sequence: u32, values: &[f32; super::capture::QUANTITIES]) {
    use super::timing::CONTROL_PERIOD_US;

    let [
        command,
        input,
        position,
        current,
        true_position,
        true_velocity,
        true_current,
    ] = *values;
    defmt::info!(
        "sample sequence={=u32} time_us={=u64} input={=f32} position={=f32} command={=f32} current_a={=f32} true_position={=f32} true_velocity={=f32} true_current_a={=f32}",
        sequence,
        u64::from(sequence) * u64::from(CONTROL_PERIOD_US),
        input,
        position,
        command,
        current,
        true_position,
        true_velocity,
        true_current
    );
}
