//! What a line asks for, checked as far as that can be without the drive.

use super::command::Command;
use crate::app::capture;
use crate::app::ecu::loopback;
use crate::app::operation::homing::Switch;
use crate::app::profile::Signal;

/// What a command signal is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Mode {
    /// The position that the loop is asked for, rad.
    #[default]
    Position,
    /// The voltage at the winding, V; no loop.
    Voltage,
    /// Nothing: an emulated actuator follows the duty and the direction at its wires.
    Wires,
}

impl Mode {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Position, Self::Voltage, Self::Wires];

    /// What it is called on the console.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Voltage => "voltage",
            Self::Wires => "wires",
        }
    }
}

/// What is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dump {
    /// The capture, over RTT.
    Capture,
    /// The log of the last seconds that were driven.
    Log(Destination),
}

/// Where a limit switch is, and how fast it is sought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Home {
    /// Which.
    pub switch: Switch,
    /// Where it opens, rad.
    pub position: f32,
    /// rad/s.
    pub speed: f32,
}

/// Where a log is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Destination {
    /// To the log that a debug probe reads.
    Rtt,
    /// To the terminal, in frames.
    Console,
}

/// What is asked for. A parameter is its place in the list that the console was given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Request {
    /// What there is, or what a command takes.
    Help(Option<&'static Command>),
    /// Nothing but a sign of life.
    Ping,
    /// How things are.
    Status,
    /// What is latched, and what to do about it.
    Faults,
    /// Forget what is latched.
    Clear,
    /// Let the drive act.
    Arm,
    /// Take its power.
    Disarm,
    /// What a command signal is from now on.
    Mode(Mode),
    /// A command signal from now on; [`Signal::build`] takes it.
    Signal(Signal),
    /// The command stays where it is.
    Hold,
    /// The position is 0 where the actuator is.
    Zero,
    /// Armed next, a limit switch is sought.
    Home(Home),
    /// The values of all parameters.
    ShowAll,
    /// The value of one.
    Show(usize),
    /// A value, within its bounds, for a parameter.
    Set {
        /// Which.
        parameter: usize,
        /// SI.
        value: f32,
    },
    /// Something for the emulated throttle body.
    Body(loopback::Command),
    /// Record, once the trigger comes.
    Record(capture::Settings),
    /// Send what was recorded.
    Dump(Dump),
    /// So many lines a second on how the drive is, Hz; 0 for none.
    Stream(f32),
    /// Estimate the friction anew.
    Refit,
    /// Look for what the machine lacks.
    Check,
    /// Store the parameters.
    Save,
}
