//! From the control interrupt to the log.
//!
//! The interrupt never logs: it puts a numbered sample into a queue and counts those that find it
//! full. The task takes them out and logs them.

use core::sync::atomic::{
    AtomicBool, AtomicU32,
    Ordering::{Acquire, Relaxed, Release},
};

use heapless::spsc::Producer;

/// What the controller saw and did in one step. SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Number of the control step, from 0. A gap is a sample that was dropped.
    pub sequence: u32,
    /// Time of the measurement, µs from the first one.
    pub time_us: u64,
    /// Bridge voltage from this sample to the next, V.
    pub input: f32,
    /// Measured position, rad.
    pub position: f32,
    /// Position asked for, rad.
    pub command: f32,
    /// Measured motor current, A.
    pub current: f32,
    /// Measured velocity, rad/s.
    pub velocity: f32,
}

/// What the two ends of the queue tell each other beside the samples.
#[derive(Debug, Default)]
pub struct Progress {
    dropped: AtomicU32,
    finished: AtomicBool,
}

impl Progress {
    /// Nothing dropped, not finished.
    pub const fn new() -> Self {
        Self {
            dropped: AtomicU32::new(0),
            finished: AtomicBool::new(false),
        }
    }

    /// Samples that found the queue full.
    pub fn dropped(&self) -> u32 {
        self.dropped.load(Relaxed)
    }

    /// Whether the last sample is in the queue.
    pub fn finished(&self) -> bool {
        self.finished.load(Acquire)
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

    /// Queues a sample, or counts it as dropped.
    pub fn push(&mut self, sample: Sample) {
        if self.samples.enqueue(sample).is_err() {
            // The only writer: a load and a store do.
            self.progress
                .dropped
                .store(self.progress.dropped().saturating_add(1), Relaxed);
        }
    }

    /// Says that no sample follows.
    pub fn finish(&mut self) {
        self.progress.finished.store(true, Release);
    }
}

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub struct Outcome {
    /// Samples logged.
    pub samples: u32,
    /// Samples that found the queue full.
    pub dropped: u32,
    /// The latched fault.
    pub fault: Option<super::wiring::Fault>,
}

impl Outcome {
    /// Whether the log is whole and the drive in order.
    pub fn is_success(&self) -> bool {
        self.dropped == 0 && self.fault.is_none()
    }
}

/// Logs what comes out of the queue until the profile or a fault ends the run.
#[cfg(feature = "tasks")]
pub async fn record(
    mut samples: heapless::spsc::Consumer<'static, Sample>,
    progress: &'static Progress,
    wiring: &'static super::wiring::Wiring,
) -> Outcome {
    use super::timing::{CONTROL_PERIOD_US, PLANT_PERIOD_US, RECORD_PERIOD_MS};
    use embassy_time::Timer;

    defmt::info!(
        "start plant_period_us={=u32} control_period_us={=u32}",
        PLANT_PERIOD_US,
        CONTROL_PERIOD_US
    );
    let mut logged = 0;
    loop {
        // Before the queue is emptied: what was queued before the end is then still logged.
        let fault = wiring.fault();
        let ended = progress.finished() || fault.is_some();
        while let Some(sample) = samples.dequeue() {
            defmt::info!(
                "sample sequence={=u32} time_us={=u64} input={=f32} position={=f32} command={=f32} current_a={=f32} velocity={=f32}",
                sample.sequence,
                sample.time_us,
                sample.input,
                sample.position,
                sample.command,
                sample.current,
                sample.velocity
            );
            logged += 1;
        }
        if ended {
            let outcome = Outcome {
                samples: logged,
                dropped: progress.dropped(),
                fault,
            };
            if let Some(fault) = fault {
                defmt::error!("fault: {}", fault);
            }
            defmt::info!(
                "end samples={=u32} dropped={=u32}",
                outcome.samples,
                outcome.dropped
            );
            return outcome;
        }
        Timer::after_millis(RECORD_PERIOD_MS).await;
    }
}
