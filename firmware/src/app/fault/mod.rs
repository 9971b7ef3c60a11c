//! Everything that can go wrong, in one list; what is latched of it, and what the outputs then do.
//!
//! A [`Fault`] has a name. [`Faults`] is a set of them. The [`latch`] keeps the first one with its
//! time and all of them as a set, until somebody clears it. While anything is latched the [`output`]s
//! are safe: bridge off, brake on, tracks at their diagnostic level. What measurements tell is
//! judged by the [`monitor`], with the winding's heat in [`overload`], the encoder against the winding in [`back_emf`] and against the
//! torque in [`following`], on what both share in [`observer`]; what the start tells, by [`reset`], with the
//! [`last_words`] of the program before it.

pub mod back_emf;
pub mod following;
pub mod last_words;
pub mod latch;
pub mod monitor;
pub mod observer;
pub mod output;
pub mod overload;
pub mod reset;

use core::fmt;
use core::ops::BitOr;

/// What can go wrong. Of several that come in one step the first of this list is named as the
/// cause: what is further down may follow from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
#[repr(u8)]
pub enum Fault {
    /// The program before this start ended in a panic.
    Panic,
    /// The stack ran into its guard.
    StackOverflow,
    /// The processor took a fault that is not the stack's.
    ProcessorFault,
    /// A watchdog started the processor anew.
    Watchdog,
    /// The processor's supply is too low, or its last reset was the brown-out's.
    BrownOut,
    /// The processor's crystal does not swing.
    ClockFailed,
    /// The processor was started anew by software, and nobody left a reason.
    UnexpectedReset,
    /// Stored parameters are damaged: those of the program are used.
    StoreCorrupt,
    /// A control step or a plant tick was not finished when the next tick came.
    MissedDeadline,
    /// A queue between an interrupt and a task was full, and what was meant for it is lost.
    QueueOverflow,
    /// Nothing valid came from the terminal for too long while its commands were driven.
    CommandTimeout,
    /// A measurement, a command or a voltage was NaN or infinite.
    NonFinite,
    /// The bridge's driver pulled the timer's break input.
    BridgeBreak,
    /// The motor's current was beyond what the bridge may carry.
    OverCurrent,
    /// The motor's current was beyond what its winding bears, for longer than it bears it.
    Overload,
    /// The supply of the bridge was too high.
    OverVoltage,
    /// The supply of the bridge was too low.
    UnderVoltage,
    /// The motor turns, by its current and voltage, and the encoder stands still.
    EncoderLost,
    /// The encoder does not move as the motor's current and voltage say.
    EncoderImplausible,
    /// The position does not follow the motor's torque: the encoder is wrong, or the actuator blocked.
    FollowingError,
    /// The actuator was driven into a limit switch, or both are open at once.
    StopReached,
    /// The actuator was faster than its limit lets it be.
    OverSpeed,
    /// The current sensor reads too much with the bridge off.
    CurrentOffset,
    /// The emergency stop's contact is open: it is pressed, or its cable is cut.
    EmergencyStop,
    /// The switches or the motor are hotter than they bear.
    OverTemperature,
    /// A temperature sensor that is declared reads what it cannot: open, or shorted.
    TemperatureSensor,
}

impl Fault {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 26] = [
        Self::Panic,
        Self::StackOverflow,
        Self::ProcessorFault,
        Self::Watchdog,
        Self::BrownOut,
        Self::ClockFailed,
        Self::UnexpectedReset,
        Self::StoreCorrupt,
        Self::MissedDeadline,
        Self::QueueOverflow,
        Self::CommandTimeout,
        Self::NonFinite,
        Self::BridgeBreak,
        Self::OverCurrent,
        Self::Overload,
        Self::OverVoltage,
        Self::UnderVoltage,
        Self::EncoderLost,
        Self::EncoderImplausible,
        Self::FollowingError,
        Self::StopReached,
        Self::OverSpeed,
        Self::CurrentOffset,
        Self::EmergencyStop,
        Self::OverTemperature,
        Self::TemperatureSensor,
    ];

    /// Its number.
    pub const fn number(self) -> u32 {
        self as u32
    }

    /// What it is called on the console.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Panic => "panic",
            Self::StackOverflow => "stack_overflow",
            Self::ProcessorFault => "processor_fault",
            Self::Watchdog => "watchdog",
            Self::BrownOut => "brown_out",
            Self::ClockFailed => "clock_failed",
            Self::UnexpectedReset => "unexpected_reset",
            Self::StoreCorrupt => "store_corrupt",
            Self::MissedDeadline => "missed_deadline",
            Self::QueueOverflow => "queue_overflow",
            Self::CommandTimeout => "command_timeout",
            Self::NonFinite => "non_finite",
            Self::BridgeBreak => "bridge_break",
            Self::OverCurrent => "over_current",
            Self::Overload => "overload",
            Self::OverVoltage => "over_voltage",
            Self::UnderVoltage => "under_voltage",
            Self::EncoderLost => "encoder_lost",
            Self::EncoderImplausible => "encoder_implausible",
            Self::FollowingError => "following_error",
            Self::StopReached => "stop_reached",
            Self::OverSpeed => "over_speed",
            Self::CurrentOffset => "current_offset",
            Self::EmergencyStop => "emergency_stop",
            Self::OverTemperature => "over_temperature",
            Self::TemperatureSensor => "temperature_sensor",
        }
    }

    /// What to look at first.
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::Panic => "send its reason, which the log's beginning has, to the makers",
            Self::StackOverflow => "send the log to the makers",
            Self::ProcessorFault => "send the log to the makers",
            Self::Watchdog => "look for what kept interrupts or tasks from going on",
            Self::BrownOut => "check the supply of the processor",
            Self::ClockFailed => "check the crystal and its capacitors; it is not armed without",
            Self::UnexpectedReset => "check what else may reset the processor: a probe, a tool",
            Self::StoreCorrupt => "check the parameters, then save them",
            Self::MissedDeadline => "ask less of the loop, or at a lower rate",
            Self::QueueOverflow => "send commands at a lower rate",
            Self::CommandTimeout => {
                "send a command more often, `ping` for one, or set command_timeout; 0 is none"
            }
            Self::NonFinite => "check the sensors and the last parameter that was set",
            Self::BridgeBreak => "check the bridge, its cooling and the motor's cables",
            Self::OverCurrent => "check the motor and its cables for a short",
            Self::Overload => "let the motor cool, and look for what holds it",
            Self::OverVoltage => "check the supply, and where braking energy goes",
            Self::UnderVoltage => "check the supply and its cables",
            Self::EncoderLost => "check the encoder's cable and supply",
            Self::EncoderImplausible => {
                "check the encoder, its coupling and direction, the current sensor, and the motor's parameters"
            }
            Self::FollowingError => {
                "check the encoder, look for what blocks the actuator, and check zero, stops and load"
            }
            Self::StopReached => {
                "command the actuator away from the switch; if both are open, check their cable"
            }
            Self::CurrentOffset => {
                "check the current sensor, current_offset, and the bridge for a switch that stays on"
            }
            Self::EmergencyStop => {
                "release the emergency stop, or check its cable; a board without one has PB15 at ground"
            }
            Self::OverTemperature => "let it cool, and look for what heats it; `status` says which",
            Self::TemperatureSensor => {
                "check the sensor's cable; a maximum of 0 says that there is none"
            }
            Self::OverSpeed => "look for what drives the actuator, and check load and speed_limit",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.name())
    }
}

/// A set of faults.
///
/// ```
/// use firmware::app::fault::{Fault, Faults};
///
/// let faults = Faults::from(Fault::UnderVoltage) | Fault::BrownOut.into();
/// assert_eq!(faults.to_string(), "brown_out, under_voltage");
/// assert_eq!(faults.first(), Some(Fault::BrownOut));
/// assert!(!faults.contains(Fault::OverVoltage));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Faults(u32);

impl Faults {
    /// None.
    pub const NONE: Self = Self(0);

    /// Those whose bits are set, the bit 2ⁿ standing for the one of number n.
    pub const fn from_bits(bits: u32) -> Self {
        Self(bits)
    }

    /// The bits that are set.
    pub const fn bits(self) -> u32 {
        self.0
    }

    /// Whether it is in there.
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & (1 << fault.number()) != 0
    }

    /// Whether there is none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether one of them says that the encoder does not follow the rotor.
    pub fn are_of_the_encoder(self) -> bool {
        [
            Fault::EncoderLost,
            Fault::EncoderImplausible,
            Fault::FollowingError,
        ]
        .into_iter()
        .any(|fault| self.contains(fault))
    }

    /// The first by number.
    pub fn first(self) -> Option<Fault> {
        Fault::ALL.get(self.0.trailing_zeros() as usize).copied()
    }

    /// By number.
    pub fn iter(self) -> impl Iterator<Item = Fault> {
        Fault::ALL
            .into_iter()
            .filter(move |&fault| self.contains(fault))
    }

    /// The fault, if the condition holds.
    pub fn when(fault: Fault, condition: bool) -> Self {
        if condition { fault.into() } else { Self::NONE }
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Self {
        Self(1 << fault.number())
    }
}

impl BitOr for Faults {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl fmt::Display for Faults {
    /// Their names with commas between; "none" for none.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return formatter.write_str("none");
        }
        for (place, fault) in self.iter().enumerate() {
            if place > 0 {
                formatter.write_str(", ")?;
            }
            formatter.write_str(fault.name())?;
        }
        Ok(())
    }
}

/// The same.
#[cfg(feature = "tasks")]
impl defmt::Format for Faults {
    fn format(&self, formatter: defmt::Formatter<'_>) {
        if self.is_empty() {
            defmt::write!(formatter, "none");
        }
        for (place, fault) in self.iter().enumerate() {
            if place > 0 {
                defmt::write!(formatter, ", ");
            }
            defmt::write!(formatter, "{=str}", fault.name());
        }
    }
}
