//! A measured log and the state that a replay starts from.

use crate::plant::State;
use crate::plant::actuator::External;

/// One channel of a log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Channel<'a> {
    /// Values in SI units.
    Values(&'a [f32]),
    /// Counts in the two parts of a ring buffer; a value is its count, as an `f32`, times the unit.
    Counts {
        /// The part with the older samples.
        older: &'a [i16],
        /// The part with the newer samples.
        newer: &'a [i16],
        /// SI value of one count.
        unit: f32,
    },
}

impl<'a> Channel<'a> {
    /// Samples.
    pub fn len(&self) -> usize {
        match self {
            Self::Values(values) => values.len(),
            Self::Counts { older, newer, .. } => older.len() + newer.len(),
        }
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value at a sample, SI.
    ///
    /// ```
    /// use model_core::gap::log::Channel;
    /// let channel = Channel::Counts { older: &[1, 2], newer: &[3], unit: 0.5 };
    /// assert_eq!((channel.len(), channel.at(0), channel.at(2)), (3, 0.5, 1.5));
    /// ```
    ///
    /// # Panics
    /// Behind the last sample.
    #[inline]
    pub fn at(&self, index: usize) -> f32 {
        match self {
            Self::Values(values) => values[index],
            Self::Counts { older, newer, unit } => {
                let count = match older.get(index) {
                    Some(count) => *count,
                    None => newer[index - older.len()],
                };
                f32::from(count) * unit
            }
        }
    }

    /// All values, SI.
    pub fn iter(self) -> impl Iterator<Item = f32> + 'a {
        (0..self.len()).map(move |index| self.at(index))
    }
}

/// A uniformly sampled log in SI units.
#[derive(Debug, Clone, Copy)]
pub struct Log<'a> {
    /// Sampling period, s.
    pub period: f32,
    /// What the drive was told, held from its sample to the next.
    pub input: Channel<'a>,
    /// Measured position, rad or m; as long as `input`.
    pub position: Channel<'a>,
    /// Measured motor current, A; as long as `input`.
    pub current: Option<Channel<'a>>,
    /// Measured velocity, rad/s or m/s; as long as `input`.
    pub velocity: Option<Channel<'a>>,
    /// Friction that a brake adds at the coordinate, N·m or N, ≥ 0, held from its sample to the next;
    /// as long as `input`.
    pub brake: Option<Channel<'a>>,
    /// Torque or force on the mechanism from outside, against positive motion, N·m or N, at its sample; as long as
    /// `input`.
    pub load: Option<Channel<'a>>,
    /// 0 while the drive lets go of the motor, so that no current flows whatever `input` says, else 1; held from its
    /// sample to the next; as long as `input`.
    pub enabled: Option<Channel<'a>>,
}

impl<'a> Log<'a> {
    /// Of input and position alone. `period`: s.
    pub fn new(period: f32, input: Channel<'a>, position: Channel<'a>) -> Self {
        Self {
            period,
            input,
            position,
            current: None,
            velocity: None,
            brake: None,
            load: None,
            enabled: None,
        }
    }

    /// Samples that input and position both have.
    pub fn samples(&self) -> usize {
        self.input.len().min(self.position.len())
    }

    /// Whether the drive lets go of the motor from sample `index` to the next.
    #[inline]
    pub fn is_released(&self, index: usize) -> bool {
        self.enabled.is_some_and(|enabled| enabled.at(index) == 0.0)
    }

    /// Whether it says of anything what acts from outside.
    #[inline]
    pub fn tells_what_acts(&self) -> bool {
        self.brake.is_some() || self.load.is_some() || self.enabled.is_some()
    }

    /// What acts from outside from sample `index`, not the last, to the next: of the load the mean.
    #[inline]
    pub fn external(&self, index: usize) -> External {
        let mean = |load: Channel| 0.5 * (load.at(index) + load.at(index + 1));
        External {
            brake: self.brake.map_or(0.0, |brake| brake.at(index)),
            load: self.load.map_or(0.0, mean),
            released: self.is_released(index),
        }
    }

    /// The state at sample `index` from the positions within `half_width` samples of it: a cubic
    /// by least squares (Savitzky and Golay 1964). Rest, with a velocity of exactly zero, where
    /// the position stays within `resolution`.
    ///
    /// `index` must be at least `half_width` from both ends of the log.
    pub fn smoothed_state(&self, index: usize, half_width: usize, resolution: f32) -> State {
        self.smoothed_state_less(index, half_width, resolution, |_| 0.0)
    }

    /// The same of what is left of the positions less a known part of each, by its sample.
    pub fn smoothed_state_less(
        &self,
        index: usize,
        half_width: usize,
        resolution: f32,
        part: impl Fn(usize) -> f32 + Copy,
    ) -> State {
        let left = |at: usize| self.position.at(at) - part(at);
        let origin = left(index);
        let neighbours = (index - half_width..=index + half_width).map(left);
        let (mut lowest, mut highest) = (origin, origin);
        for position in neighbours.clone() {
            lowest = lowest.min(position);
            highest = highest.max(position);
        }
        if highest - lowest <= resolution {
            return State::new(0.5 * (highest + lowest), 0.0);
        }
        // Moments of the abscissa scaled to −1 … 1, so that the sixth power stays within f32.
        let unit = 1.0 / half_width as f32;
        let (mut s2, mut s4, mut s6) = (0.0f32, 0.0f32, 0.0f32);
        let (mut y0, mut y1, mut y2, mut y3) = (0.0f32, 0.0f32, 0.0f32, 0.0f32);
        for (offset, position) in neighbours.enumerate() {
            let x = (offset as f32 - half_width as f32) * unit;
            let square = x * x;
            let y = position - origin;
            s2 += square;
            s4 += square * square;
            s6 += square * square * square;
            y0 += y;
            y1 += x * y;
            y2 += square * y;
            y3 += square * x * y;
        }
        let s0 = (2 * half_width + 1) as f32;
        let value = (s4 * y0 - s2 * y2) / (s0 * s4 - s2 * s2);
        let slope = if half_width > 1 {
            (s6 * y1 - s4 * y3) / (s2 * s6 - s4 * s4)
        } else {
            y1 / s2
        };
        State::new(origin + value, slope * unit / self.period)
    }
}
