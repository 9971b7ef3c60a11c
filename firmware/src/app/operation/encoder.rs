//! A position of 32 bits from a counter of 16.

/// What the counter has come by.
///
/// Right as long as it is looked at before it has moved by half of its range: at 20 kHz with 16,384
/// counts a turn that is 40,000 turns a second.
///
/// ```
/// use firmware::app::operation::encoder::Extension;
///
/// let mut encoder = Extension::default();
/// assert_eq!(encoder.take(65_000), 65_000 - 65_536);
/// assert_eq!(encoder.take(10_000), 10_000);
/// assert_eq!(encoder.take(40_000), 40_000);
/// assert_eq!(encoder.take(5_000), 70_536);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Extension {
    last: u16,
    total: i32,
}

impl Extension {
    /// Takes the counter's reading: the counts since the start, or since [`Extension::zero`]. They
    /// wrap after 2³¹.
    pub fn take(&mut self, count: u16) -> i32 {
        // The cast takes what lies beyond half of the range as a way back.
        let moved = count.wrapping_sub(self.last) as i16;
        self.last = count;
        self.total = self.total.wrapping_add(moved.into());
        self.total
    }

    /// Counts from here on.
    pub fn zero(&mut self) {
        self.total = 0;
    }

    /// Counts as if it had moved by so much more.
    pub fn shift(&mut self, counts: i32) {
        self.total = self.total.wrapping_add(counts);
    }
}
