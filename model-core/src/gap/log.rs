//! A measured log and the state that a replay starts from.

use crate::plant::State;

/// A uniformly sampled log in SI units.
#[derive(Debug, Clone, Copy)]
pub struct Log<'a> {
    /// Sampling period, s.
    pub period: f32,
    /// What the drive was told, held from its sample to the next.
    pub input: &'a [f32],
    /// Measured position, rad or m; as long as `input`.
    pub position: &'a [f32],
    /// Measured motor current, A; as long as `input`.
    pub current: Option<&'a [f32]>,
    /// Measured velocity, rad/s or m/s; as long as `input`.
    pub velocity: Option<&'a [f32]>,
}

impl Log<'_> {
    /// Samples that input and position both have.
    pub fn samples(&self) -> usize {
        self.input.len().min(self.position.len())
    }

    /// The state at sample `index` from the positions within `half_width` samples of it: a cubic
    /// by least squares (Savitzky and Golay 1964). Rest, with a velocity of exactly zero, where
    /// the position stays within `resolution`.
    ///
    /// `index` must be at least `half_width` from both ends of the log.
    pub fn smoothed_state(&self, index: usize, half_width: usize, resolution: f32) -> State {
        let origin = self.position[index];
        let neighbours = &self.position[index - half_width..=index + half_width];
        let (mut lowest, mut highest) = (origin, origin);
        for &position in neighbours {
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
        for (offset, &position) in neighbours.iter().enumerate() {
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
        let s0 = neighbours.len() as f32;
        let value = (s4 * y0 - s2 * y2) / (s0 * s4 - s2 * s2);
        let slope = if half_width > 1 {
            (s6 * y1 - s4 * y3) / (s2 * s6 - s4 * s4)
        } else {
            y1 / s2
        };
        State::new(origin + value, slope * unit / self.period)
    }
}
