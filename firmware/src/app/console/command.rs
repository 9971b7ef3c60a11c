//! The commands: one table for the parser and for the help.

use core::fmt;

use model_core::signal::{ramp, sine, step, sweep, triangle};

use super::error::ParseError;
use super::parse::{Arguments, Line};
use super::reading::{
    dump, help, home, inject, mode, record, request, set, show, signal, stream, supply,
};
use super::request::Request;
use crate::app::ecu::loopback;
use crate::app::profile::Signal;

/// Reads what follows a command's name.
pub(super) type Read = for<'a> fn(&mut Arguments<'a, '_>) -> Result<Line, ParseError<'a>>;

/// A command.
#[derive(Debug)]
pub struct Command {
    /// Its first word.
    pub name: &'static str,
    /// What may follow.
    pub arguments: &'static [Argument],
    /// What it does.
    pub help: &'static str,
    /// Makes a request of what follows.
    pub(super) read: Read,
}

/// By its name, as each is there once.
impl PartialEq for Command {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// An argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Argument {
    /// Its name; a signal's, as that has it.
    pub name: &'static str,
    /// Its unit, or the words that it may be.
    pub values: &'static str,
    /// Whether it must be there.
    pub presence: Presence,
}

/// How often an argument is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// Once.
    Required,
    /// Once, or not.
    Optional,
    /// As often as one likes, or not.
    Repeated,
}

const fn required(name: &'static str, values: &'static str) -> Argument {
    Argument {
        name,
        values,
        presence: Presence::Required,
    }
}

const fn optional(name: &'static str, values: &'static str) -> Argument {
    Argument {
        name,
        values,
        presence: Presence::Optional,
    }
}

const fn plain(name: &'static str, help: &'static str, read: Read) -> Command {
    Command {
        name,
        arguments: &[],
        help,
        read,
    }
}

impl Command {
    /// The command of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        COMMANDS.iter().find(|command| command.name == name)
    }
}

impl fmt::Display for Argument {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.name, self.values)
    }
}

/// How a command is used, on one line.
#[derive(Debug, Clone, Copy)]
pub struct Usage(pub &'static Command);

impl fmt::Display for Usage {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.0.name)?;
        for argument in self.0.arguments {
            match argument.presence {
                Presence::Required => write!(formatter, " {}", argument.name)?,
                Presence::Optional => write!(formatter, " [{}]", argument.name)?,
                Presence::Repeated => write!(formatter, " [{}...]", argument.name)?,
            }
        }
        Ok(())
    }
}

const UNIT: &str = "rad or V, as the mode is";
const QUANTITY: &str =
    "command, input, position, current_a, true_position, true_velocity or true_current_a";

/// All of them.
pub static COMMANDS: [Command; 28] = [
    Command {
        name: "help",
        arguments: &[optional("name", "a command's")],
        help: "what there is, or what a command takes",
        read: help,
    },
    plain(
        "status",
        "armed or not, faults, measurements, times",
        |_| request(Request::Status),
    ),
    plain("faults", "what is latched, and what to do about it", |_| {
        request(Request::Faults)
    }),
    plain(
        "clear",
        "forget what is latched: disarmed, and with every condition gone",
        |_| request(Request::Clear),
    ),
    plain("arm", "let the drive act", |_| request(Request::Arm)),
    plain("disarm", "take its power: bridge off, brake on", |_| {
        request(Request::Disarm)
    }),
    plain(
        "stop",
        "take its power; it counts anywhere in a line that is no command",
        |_| request(Request::Disarm),
    ),
    plain(
        "ping",
        "a sign of life, as any command is, against command_timeout",
        |_| request(Request::Ping),
    ),
    Command {
        name: "mode",
        arguments: &[required("mode", "position, voltage or wires")],
        help: "what a command signal is from now on; `wires`: what an emulated actuator is driven by",
        read: mode,
    },
    Command {
        name: "step",
        arguments: &[
            required("initial_value", UNIT),
            required("final_value", UNIT),
            optional("time", "s"),
        ],
        help: "command a step, at once or at a time",
        read: |arguments| {
            signal(arguments, |[initial_value, final_value, time]| {
                let parameters = step::Parameters {
                    initial_value,
                    final_value,
                    time,
                };
                Signal::Step(parameters)
            })
        },
    },
    Command {
        name: "ramp",
        arguments: &[
            required("initial_value", UNIT),
            required("final_value", UNIT),
            required("duration", "s"),
            optional("start", "s"),
        ],
        help: "command a ramp, at once or from a start on",
        read: |arguments| {
            signal(
                arguments,
                |[initial_value, final_value, duration, start]| {
                    let parameters = ramp::Parameters {
                        initial_value,
                        final_value,
                        start,
                        duration,
                    };
                    Signal::Ramp(parameters)
                },
            )
        },
    },
    Command {
        name: "sine",
        arguments: &[
            required("offset", UNIT),
            required("amplitude", UNIT),
            required("frequency", "Hz"),
            optional("phase", "rad"),
        ],
        help: "command a sine",
        read: |arguments| {
            signal(arguments, |[offset, amplitude, frequency, phase]| {
                let parameters = sine::Parameters {
                    offset,
                    amplitude,
                    frequency,
                    phase,
                };
                Signal::Sine(parameters)
            })
        },
    },
    Command {
        name: "sweep",
        arguments: &[
            required("offset", UNIT),
            required("amplitude", UNIT),
            required("initial_frequency", "Hz"),
            required("final_frequency", "Hz"),
            required("duration", "s"),
        ],
        help: "command a sine whose frequency changes evenly, and then stays",
        read: |arguments| {
            signal(
                arguments,
                |[
                    offset,
                    amplitude,
                    initial_frequency,
                    final_frequency,
                    duration,
                ]| {
                    let parameters = sweep::Parameters {
                        offset,
                        amplitude,
                        initial_frequency,
                        final_frequency,
                        duration,
                    };
                    Signal::Sweep(parameters)
                },
            )
        },
    },
    Command {
        name: "triangle",
        arguments: &[
            required("offset", UNIT),
            required("amplitude", UNIT),
            required("frequency", "Hz"),
            optional("phase", "rad"),
        ],
        help: "command straight lines up and down",
        read: |arguments| {
            signal(arguments, |[offset, amplitude, frequency, phase]| {
                let parameters = triangle::Parameters {
                    offset,
                    amplitude,
                    frequency,
                    phase,
                };
                Signal::Triangle(parameters)
            })
        },
    },
    plain("hold", "the command stays where it is", |_| {
        request(Request::Hold)
    }),
    plain(
        "zero",
        "the position is 0 where the actuator is; disarmed",
        |_| request(Request::Zero),
    ),
    Command {
        name: "home",
        arguments: &[
            required("switch", "lower or upper"),
            required("position", "rad, where the switch opens"),
            required("speed", "rad/s"),
        ],
        help: "the next `arm` seeks a limit switch, then takes its power; with that the position is known",
        read: home,
    },
    Command {
        name: "show",
        arguments: &[optional(
            "parameter",
            "a parameter's name; `show` lists them",
        )],
        help: "values of parameters, with units and bounds",
        read: show,
    },
    Command {
        name: "set",
        arguments: &[
            required("parameter", "a parameter's name; `show` lists them"),
            required("value", "in the parameter's unit"),
        ],
        help: "another value for a parameter, until the next start unless it is saved",
        read: set,
    },
    Command {
        name: "inject",
        arguments: &[
            required(
                "fault",
                "plate_jammed, spring_broken, friction_raised, motor_open, motor_shorted, or \
                 first_track_ or second_track_ with open, shorted_high, shorted_low, stuck, offset or noisy",
            ),
            optional(
                "value",
                "a factor to friction_raised, ohm to motor_shorted, V to offset and noisy",
            ),
        ],
        help: "a fault of the emulated throttle body, from now on",
        read: inject,
    },
    plain("heal", "every injected fault ends", |_| {
        request(Request::Body(loopback::Command::Heal))
    }),
    Command {
        name: "supply",
        arguments: &[required("voltage", "V")],
        help: "supply of the emulated throttle body's bridge",
        read: supply,
    },
    Command {
        name: "record",
        arguments: &[
            required("before", "rows before the trigger's"),
            required("after", "rows from the trigger's on"),
            required("trigger", "now, command, fault, rising or falling"),
            optional("of", QUANTITY),
            optional("level", "in the quantity's unit"),
            Argument {
                name: "quantity",
                values: QUANTITY,
                presence: Presence::Repeated,
            },
        ],
        help: "record at the loop's rate around a trigger; `of` and `level` go with rising and falling",
        read: record,
    },
    Command {
        name: "dump",
        arguments: &[
            optional(
                "what",
                "capture, or log, which is what was driven in the last 10 s; capture unless it is said",
            ),
            optional("where", "of the log: rtt or console; rtt unless it is said"),
        ],
        help: "send what was recorded",
        read: dump,
    },
    Command {
        name: "stream",
        arguments: &[required("rate", "Hz")],
        help: "lines for a program on how the drive is, 0 to 100 a second",
        read: stream,
    },
    plain("refit", "estimate the friction from the log", |_| {
        request(Request::Refit)
    }),
    plain(
        "check",
        "look for what the machine lacks, in the log",
        |_| request(Request::Check),
    ),
    plain("save", "store the parameters; disarmed", |_| {
        request(Request::Save)
    }),
];
