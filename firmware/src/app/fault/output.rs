//! What the outputs do, as a function of what is latched and of nothing else.

use super::Faults;

/// The bridge's switches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Bridge {
    /// All off.
    Off,
    /// As the loop drives them.
    Driven,
}

/// The holding brake, which closes without current.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Brake {
    /// Holds.
    On,
    /// Under current.
    Released,
}

/// The two position tracks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Tracks {
    /// At [`DIAGNOSTIC`](crate::app::tracks::DIAGNOSTIC), which no position gives.
    Diagnostic,
    /// At the position.
    Position,
}

/// All of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub struct Outputs {
    /// The bridge.
    pub bridge: Bridge,
    /// The brake.
    pub brake: Brake,
    /// The tracks.
    pub tracks: Tracks,
}

impl Outputs {
    /// With whatever fault: no torque, the load held, and a reader of the tracks told so.
    pub const SAFE: Self = Self {
        bridge: Bridge::Off,
        brake: Brake::On,
        tracks: Tracks::Diagnostic,
    };

    /// With these faults latched. Disarmed and sound the load is held, and the tracks tell where.
    pub const fn of(latched: Faults, armed: bool) -> Self {
        if !latched.is_empty() {
            return Self::SAFE;
        }
        let (bridge, brake) = if armed {
            (Bridge::Driven, Brake::Released)
        } else {
            (Bridge::Off, Brake::On)
        };
        Self {
            bridge,
            brake,
            tracks: Tracks::Position,
        }
    }
}
