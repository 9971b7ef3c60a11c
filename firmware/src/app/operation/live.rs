//! How a drive is, as a line for a program, some times a second.

use core::fmt;

use crate::app::console::request::Mode;
use crate::app::fault::Faults;

/// Most lines in a second. One has some 80 bytes, and 115,200 baud carry 11,520 a second: the rest is left
/// for answers.
pub const MOST_RATE: f32 = 100.0;

/// How a drive is at a control step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Live {
    /// Number of the control step.
    pub sequence: u32,
    /// Whether the drive may act.
    pub armed: bool,
    /// What a command signal is.
    pub mode: Mode,
    /// What is latched.
    pub latched: Faults,
    /// What is asked for: rad or V, as the mode is.
    pub command: f32,
    /// Bridge voltage, V.
    pub input: f32,
    /// Measured position, rad.
    pub position: f32,
    /// Measured motor current, A.
    pub current: f32,
    /// Supply of the bridge, V.
    pub supply: f32,
    /// Worst durations of the plant's and the control interrupt, in what the board counts.
    pub worst: [u32; 2],
}

/// Begins each of these lines.
const KIND: &str = "live";

impl fmt::Display for Live {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [plant, control] = self.worst;
        write!(
            formatter,
            "{KIND} {} {} {} {:x} {:.5} {:.3} {:.6} {:.3} {:.2} {plant} {control}",
            self.sequence,
            u8::from(self.armed),
            self.mode.name(),
            self.latched.bits(),
            self.command,
            self.input,
            self.position,
            self.current,
            self.supply,
        )
    }
}

impl Live {
    /// Reads what [`Display`](fmt::Display) writes; none of another line.
    pub fn read(text: &str) -> Option<Self> {
        let mut words = text.split(' ');
        if words.next()? != KIND {
            return None;
        }
        let mut word = || words.next();
        let live = Self {
            sequence: word()?.parse().ok()?,
            armed: word()? == "1",
            mode: {
                let name = word()?;
                Mode::ALL.into_iter().find(|mode| mode.name() == name)?
            },
            latched: Faults::from_bits(u32::from_str_radix(word()?, 16).ok()?),
            command: word()?.parse().ok()?,
            input: word()?.parse().ok()?,
            position: word()?.parse().ok()?,
            current: word()?.parse().ok()?,
            supply: word()?.parse().ok()?,
            worst: [word()?.parse().ok()?, word()?.parse().ok()?],
        };
        words.next().is_none().then_some(live)
    }
}
