//! What is said back: one response a line, each a few lines of text.

use core::fmt;

use model_core::numeric::invalid_parameter::InvalidParameter;

use super::command::{COMMANDS, Command, Usage};
use super::request::Mode;
use crate::app::capture::Stage;
use crate::app::fault::Faults;
use crate::app::fault::latch::{Cause, Latch, NotCleared};
use crate::app::operation::homing::Switch;
use crate::app::operation::setup;
use crate::app::operation::temperature::Told;
use crate::app::store::candidate::Rejected;
use crate::app::store::field::Description;
use crate::app::timing::PLANT_PERIOD_US;

/// A response. A line of text behind another begins with a line feed; there is none at the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Response<'a> {
    /// It is done, or under way and its result comes in the log.
    Done,
    /// It is not done.
    Refused(Refusal),
    /// How things are.
    Status(Status),
    /// What is latched.
    Faults(Latched),
    /// A parameter and its value.
    Parameter(&'a Description, f32),
    /// All parameters and their values.
    Parameters(&'a [Description], &'a [f32]),
    /// What there is, or what a command takes.
    Help(Option<&'static Command>),
}

/// Why something is not done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// These faults are latched.
    Latched(Faults),
    /// The latch stays.
    NotCleared(NotCleared),
    /// It is only done disarmed.
    Armed,
    /// It is only done armed.
    Disarmed,
    /// There is no command signal in this mode.
    Followed,
    /// It seeks a limit switch.
    Seeking,
    /// Its position is limited, and nobody has said where it is since the start.
    Unreferenced,
    /// A value does not go with the others.
    Invalid(InvalidParameter),
    /// The actuator's or the loop's values do not go together.
    Setup(setup::Refused),
    /// Another task of long duration is under way.
    Busy,
    /// There is nothing recorded, or not all of it.
    NotRecorded(Stage),
    /// Nothing was driven, so there is no log.
    NothingDriven,
    /// This image has nothing that could do it.
    Unavailable,
    /// What it is for has a full queue.
    QueueFull,
    /// Values are not stored.
    NotStored(Rejected),
}

/// How things are.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Status {
    /// Whether the drive may act.
    pub armed: bool,
    /// What a command signal is.
    pub mode: Mode,
    /// What is latched.
    pub latched: Faults,
    /// Measured position, rad.
    pub position: f32,
    /// Measured motor current, A.
    pub current: f32,
    /// Supply of the bridge, V.
    pub supply: f32,
    /// Whether the limit switches are open, the lower and the upper one.
    pub switches: [bool; 2],
    /// Whether the position of a real actuator counts from wherever it was at the start, and no end stop is trusted.
    pub from_start: bool,
    /// Whether the encoder was seen to follow the rotor, where that is checked.
    pub encoder_follows: Option<bool>,
    /// Temperatures of the switches and the motor, of a real actuator.
    pub temperatures: Option<[Told; 2]>,
    /// Plant ticks since the start.
    pub ticks: u32,
    /// Deadlines missed since the start.
    pub missed: u32,
    /// Worst durations of the plant's and the control interrupt.
    pub worst: [u32; 2],
    /// What they are counted in, in the plural.
    pub unit: &'static str,
    /// How far the capture is.
    pub capture: Stage,
}

/// What is latched, at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Latched {
    /// The first.
    pub first: Option<Cause>,
    /// All.
    pub causes: Faults,
    /// Conditions that hold now.
    pub present: Faults,
}

impl From<&Latch> for Latched {
    fn from(latch: &Latch) -> Self {
        Self {
            first: latch.first(),
            causes: latch.causes(),
            present: latch.present(),
        }
    }
}

/// A number of plant ticks in s.
fn seconds(ticks: u32) -> f64 {
    f64::from(ticks) * f64::from(PLANT_PERIOD_US) * 1e-6
}

impl fmt::Display for Response<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Done => formatter.write_str("ok"),
            Self::Refused(refusal) => write!(formatter, "refused: {refusal}"),
            Self::Status(status) => status.fmt(formatter),
            Self::Faults(latched) => latched.fmt(formatter),
            Self::Parameter(description, value) => show(formatter, description, *value),
            Self::Parameters(descriptions, values) => {
                for (place, (description, value)) in descriptions.iter().zip(*values).enumerate() {
                    if place > 0 {
                        formatter.write_str("\n")?;
                    }
                    show(formatter, description, *value)?;
                }
                Ok(())
            }
            Self::Help(None) => {
                for (place, command) in COMMANDS.iter().enumerate() {
                    if place > 0 {
                        formatter.write_str("\n")?;
                    }
                    write!(formatter, "{}: {}", Usage(command), command.help)?;
                }
                Ok(())
            }
            Self::Help(Some(command)) => {
                write!(formatter, "{}: {}", Usage(command), command.help)?;
                for argument in command.arguments {
                    write!(formatter, "\n  {argument}")?;
                }
                Ok(())
            }
        }
    }
}

fn show(formatter: &mut fmt::Formatter<'_>, description: &Description, value: f32) -> fmt::Result {
    let Description {
        name,
        unit,
        lower,
        upper,
    } = description;
    // As many digits as give the value back.
    write!(
        formatter,
        "{name} = {value:?} {unit} ({lower:?} to {upper:?})"
    )
}

impl fmt::Display for Status {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = if self.armed { "armed" } else { "disarmed" };
        let [plant, control] = self.worst;
        write!(
            formatter,
            "{state}, {} mode, {:.3} s\n\
             latched: {}\n\
             position {:.6} rad, current {:.3} A, supply {:.2} V\n\
             worst plant {plant}, control {control} {}; deadlines missed: {}\n\
             capture: {}",
            self.mode.name(),
            seconds(self.ticks),
            self.latched,
            self.position,
            self.current,
            self.supply,
            self.unit,
            self.missed,
            self.capture.name()
        )?;
        for (is_open, switch) in self.switches.into_iter().zip(Switch::ALL) {
            if is_open {
                write!(formatter, "\nlimit switch open: {}", switch.name())?;
            }
        }
        if self.from_start {
            write!(
                formatter,
                "\nposition counts from the start, no end stop is trusted; `home` it, or `zero` it"
            )?;
        }
        match self.encoder_follows {
            Some(true) => formatter.write_str("\nencoder: follows the rotor")?,
            Some(false) => formatter.write_str(
                "\nencoder: not checked; in position mode the drive pushes either way first",
            )?,
            None => {}
        }
        match &self.temperatures {
            Some([switches, motor]) => {
                write!(
                    formatter,
                    "\ntemperature: switches {switches}, motor {motor}"
                )
            }
            None => Ok(()),
        }
    }
}

impl fmt::Display for Latched {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(Cause { fault, tick }) = self.first else {
            return formatter.write_str("none");
        };
        write!(formatter, "first: {fault} at {:.5} s", seconds(tick))?;
        for fault in self.causes.iter() {
            let holds = if self.present.contains(fault) {
                ", holds now"
            } else {
                ""
            };
            write!(formatter, "\n{fault}{holds}: {}", fault.remedy())?;
        }
        Ok(())
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Latched(faults) => write!(formatter, "latched: {faults}; see `faults`, `clear`"),
            Self::NotCleared(NotCleared::Armed) | Self::Armed => {
                formatter.write_str("the drive is armed; `disarm` it first")
            }
            Self::NotCleared(NotCleared::Present(faults)) => {
                write!(formatter, "still there: {faults}; end that first")
            }
            Self::NotCleared(NotCleared::Renewed) => {
                formatter.write_str("another fault came at that moment; see `faults`")
            }
            Self::Invalid(invalid) => invalid.fmt(formatter),
            Self::Setup(refused) => refused.fmt(formatter),
            Self::Disarmed => formatter.write_str("the drive is disarmed; `arm` it first"),
            Self::Unreferenced => formatter.write_str(
                "the position is limited and not known; `home` it, or move the actuator to its 0 and `zero` it",
            ),
            Self::Seeking => {
                formatter.write_str("a limit switch is sought; wait for it, or `disarm`")
            }
            Self::Followed => formatter.write_str(
                "the actuator follows its wires; take `mode position` or `mode voltage` first",
            ),
            Self::NotStored(rejected) => rejected.fmt(formatter),
            Self::Busy => {
                formatter.write_str("a refit, a check or `dump log` is under way; wait for it")
            }
            Self::NotRecorded(stage) => {
                write!(formatter, "the capture is {}; `record` first", stage.name())
            }
            Self::NothingDriven => {
                formatter.write_str("nothing was driven; `arm` and command it first")
            }
            Self::Unavailable => formatter.write_str("this image has nothing that could do it"),
            Self::QueueFull => formatter.write_str("too many at once; send it again"),
        }
    }
}
