//! The onboard log: the last seconds before now, in counts, as long as the RAM allows.

use model_core::gap::log::{Channel, Log};

use super::conversion::Converters;
use super::record::Sample;
use super::timing::{CONTROL_PERIOD, STEPS_PER_SECOND};

/// Samples that are kept: 10 s. At three counts of two bytes each that is 60,000 of the 65,536 bytes of
/// the chip's core-coupled memory.
pub const MEMORY_SAMPLES: usize = 10 * STEPS_PER_SECOND as usize;

/// A ring of the last `N` samples without a gap: the newest overwrites the oldest, and a sample that
/// does not follow the one before begins a new log.
#[derive(Debug)]
pub struct Memory<const N: usize = MEMORY_SAMPLES> {
    duty: [i16; N],
    position: [i16; N],
    current: [i16; N],
    /// Where the next sample goes.
    next: usize,
    samples: usize,
    /// The sequence number that the next sample has if none is missing.
    expected: u32,
}

impl<const N: usize> Memory<N> {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            duty: [0; N],
            position: [0; N],
            current: [0; N],
            next: 0,
            samples: 0,
            expected: 0,
        }
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.next = 0;
        self.samples = 0;
    }

    /// Keeps a sample. One farther out than 16 bits count has no place in a log, and ends it.
    pub fn push(&mut self, sample: &Sample) {
        let Ok(position) = i16::try_from(sample.position) else {
            self.clear();
            return;
        };
        if sample.sequence != self.expected {
            self.clear();
        }
        self.expected = sample.sequence.wrapping_add(1);
        self.duty[self.next] = sample.duty;
        self.position[self.next] = position;
        self.current[self.next] = sample.current;
        self.next = (self.next + 1) % N;
        self.samples = (self.samples + 1).min(N);
    }

    /// Samples kept.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// A sample's duty, position and current in counts, the oldest in row 0; none beyond the newest.
    pub fn row(&self, row: usize) -> Option<[i16; 3]> {
        let place = (self.next + N - self.samples + row) % N;
        let counts = [&self.duty, &self.position, &self.current];
        (row < self.samples).then(|| counts.map(|channel| channel[place]))
    }

    /// The log, oldest sample first.
    pub fn log(&self, converters: &Converters) -> Log<'_> {
        Log {
            current: Some(self.channel(&self.current, converters.current.unit())),
            ..Log::new(
                CONTROL_PERIOD,
                self.channel(&self.duty, converters.bridge.unit()),
                self.channel(&self.position, converters.position.unit()),
            )
        }
    }

    fn channel<'a>(&self, counts: &'a [i16; N], unit: f32) -> Channel<'a> {
        let (newer, older) = counts[..self.samples].split_at(self.next);
        Channel::Counts { older, newer, unit }
    }
}

impl<const N: usize> Default for Memory<N> {
    fn default() -> Self {
        Self::new()
    }
}
