//! The duty of a PWM signal from a timer that measures it.
//!
//! The timer is reset by each rising edge, and catches its count there (the period) and at the falling
//! edge (the width). A duty of zero or one has no edges: when there was none for twice the period, or for
//! longer than the slowest signal's, the level of the pin decides, until a period is measured again. The count of
//! such a long time may wrap.

/// What the timer and the pin tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Edges {
    /// Whether a rising edge was caught since the last look.
    pub rising: bool,
    /// Counts between the last two rising edges.
    pub period: u32,
    /// Counts from a rising edge to the falling one behind it.
    pub width: u32,
    /// Counts since the last rising edge.
    pub since: u32,
    /// The pin's level.
    pub high: bool,
}

/// What judges them.
///
/// ```
/// use firmware::app::operation::duty_input::{DutyInput, Edges};
///
/// // A timer of 84 MHz, and signals from 400 Hz up.
/// let mut input = DutyInput::new(84_000_000, 400);
/// let edges = Edges { rising: true, period: 42_000, width: 10_500, since: 7, high: true };
/// assert_eq!(input.duty(&edges), 0.25);
/// // The signal stops, high.
/// let stopped = Edges { rising: false, since: 300_000, ..edges };
/// assert_eq!(input.duty(&stopped), 1.0);
/// // It falls, and is not known before there is a period: it was not low for long.
/// let falls = Edges { width: 300_000, since: 300_009, high: false, ..stopped };
/// assert_eq!(input.duty(&falls), 1.0);
/// // It stays low, and after 51 s the count wraps.
/// let low = Edges { since: 600_000, ..falls };
/// assert_eq!(input.duty(&low), 0.0);
/// assert_eq!(input.duty(&Edges { since: 5, period: 42_000, width: 10_500, ..low }), 0.0);
/// // A fast signal stops, low: two of its periods tell that.
/// let fast = Edges { rising: true, period: 4_200, width: 2_100, since: 7, high: true };
/// assert_eq!(input.duty(&fast), 0.5);
/// let stopped = Edges { rising: false, since: 10_501, high: false, ..fast };
/// assert_eq!(input.duty(&stopped), 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DutyInput {
    longest: u32,
    /// Whether there are edges.
    runs: bool,
    last: f32,
}

impl DutyInput {
    /// For a timer's clock and the slowest signal, Hz. 0 up to the first signal.
    pub const fn new(clock: u32, slowest: u32) -> Self {
        Self {
            longest: clock / slowest,
            runs: false,
            last: 0.0,
        }
    }

    /// The duty, 0 to 1.
    pub fn duty(&mut self, edges: &Edges) -> f32 {
        let &Edges {
            rising,
            period,
            width,
            since,
            high,
        } = edges;
        self.runs |= rising;
        // Edges that jitter do so by less than a period.
        let longest = match period {
            0 => self.longest,
            _ => self.longest.min(period.saturating_mul(2)),
        };
        if since > longest {
            // Behind a long pulse the pin is low as within a period: only a long pause is none.
            if high || since.saturating_sub(width) > longest {
                self.runs = false;
                self.last = if high { 1.0 } else { 0.0 };
            }
        } else if self.runs && (1..=self.longest).contains(&period) && width <= period {
            self.last = width as f32 / period as f32;
        }
        // Else a signal has just begun, or the width is of a period that is not over: as before.
        self.last
    }
}
