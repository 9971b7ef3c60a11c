//! What the processor's last reset says of the time before it.

use super::Fault;

/// The flags that a reset leaves. Several are set at once: every reset pulls the reset pin, and power
/// that comes up passes the brown-out threshold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ResetFlags {
    /// Power came up.
    pub power_on: bool,
    /// The supply was below the brown-out threshold.
    pub brown_out: bool,
    /// The independent or the window watchdog.
    pub watchdog: bool,
    /// By software.
    pub software: bool,
}

impl ResetFlags {
    /// The fault that the reset stands for; none after power-on, or a reset by the pin alone. `left`
    /// is the reason that the program left before it reset itself.
    pub fn fault(self, left: Option<Fault>) -> Option<Fault> {
        if self.power_on {
            // What a RAM held that had no power is nobody's reason.
            None
        } else if self.brown_out {
            Some(Fault::BrownOut)
        } else if left.is_some() {
            left
        } else if self.watchdog {
            Some(Fault::Watchdog)
        } else if self.software {
            Some(Fault::UnexpectedReset)
        } else {
            None
        }
    }
}
