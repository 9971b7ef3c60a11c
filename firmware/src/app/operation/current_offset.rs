//! The current sensor's zero: what it reads with the bridge off is no current.
//!
//! While the bridge is off the readings are averaged, block after block, and what the mean is off by is taken off every
//! reading from then on. The first block waits for the current to die out. A mean that is too far off is
//! [`Fault::CurrentOffset`](crate::app::fault::Fault::CurrentOffset) until a block says otherwise: it is not cleared before,
//! and the drive not armed. The sensor is broken, or a current flows that no switch lets flow.

/// Ticks of a block: 13 ms, twelve time constants of the winding for a current to die out, and in the mean a sixteenth of a
/// reading's noise.
const TICKS: i32 = 256;

/// Most that is taken off, A. Two resistors of 1 % that divide 3.3 V make the sensor's middle wrong by 16.5 mV, 0.25 A of
/// 66 mV/A; as much again each for amplifier, reference and warmth.
pub const MOST: f32 = 1.0;

/// A block under way.
///
/// ```
/// use firmware::app::operation::current_offset::State;
///
/// let mut state = State::default();
/// let mut ends = |counts: i32, is_off| (0..256).find_map(|_| state.take(counts, is_off));
/// assert_eq!(ends(700, false), None);
/// // What dies out is waited for.
/// assert_eq!(ends(300, true), None);
/// assert_eq!(ends(-7, true), Some(-7));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct State {
    ticks: i32,
    sum: i32,
    /// Whether a block has passed since the bridge went off.
    quiet: bool,
}

impl State {
    /// Takes a reading, in counts, with the bridge off or not: the mean of a block that it ends.
    pub fn take(&mut self, counts: i32, is_off: bool) -> Option<i32> {
        if !is_off {
            *self = Self::default();
            return None;
        }
        self.ticks += 1;
        self.sum += counts;
        if self.ticks < TICKS {
            return None;
        }
        // To the nearest.
        let mean = (2 * self.sum + TICKS).div_euclid(2 * TICKS);
        let quiet = self.quiet;
        *self = Self {
            quiet: true,
            ..Self::default()
        };
        quiet.then_some(mean)
    }
}
