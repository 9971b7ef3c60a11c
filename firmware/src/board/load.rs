//! How long an interrupt takes, at worst and on average.

/// Durations in the counts of whatever clock measured them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Load {
    worst: u32,
    sum: u64,
    runs: u64,
}

impl Load {
    /// Nothing measured yet.
    pub const fn new() -> Self {
        Self {
            worst: 0,
            sum: 0,
            runs: 0,
        }
    }

    /// Adds one run.
    pub fn add(&mut self, duration: u32) {
        self.worst = self.worst.max(duration);
        self.sum += u64::from(duration);
        self.runs += 1;
    }

    /// All runs together.
    pub const fn sum(&self) -> u64 {
        self.sum
    }

    /// The longest run.
    pub const fn worst(&self) -> u32 {
        self.worst
    }

    /// The mean, rounded down; 0 before the first run.
    pub fn mean(&self) -> u32 {
        self.sum
            .checked_div(self.runs)
            .and_then(|mean| u32::try_from(mean).ok())
            .unwrap_or(0)
    }
}
