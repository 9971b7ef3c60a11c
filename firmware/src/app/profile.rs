//! What the run asks for: one command signal after the other, and then all of them again.

use heapless::Vec;
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::signal::{ramp, sine, step, sweep, triangle};

use super::timing::{CONTROL_PERIOD, CONTROL_PERIOD_US};

/// Most commands of one experiment.
pub const MOST_COMMANDS: usize = 12;

/// A position over time, rad, or whatever else is commanded. Each begins at its own time zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Signal {
    /// From one value to another at once.
    Step(step::Parameters),
    /// From one value to another in a straight line.
    Ramp(ramp::Parameters),
    /// A sine.
    Sine(sine::Parameters),
    /// A sine whose frequency changes.
    Sweep(sweep::Parameters),
    /// Straight lines up and down.
    Triangle(triangle::Parameters),
}

impl Signal {
    /// What it is called in the log.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Step(_) => "step",
            Self::Ramp(_) => "ramp",
            Self::Sine(_) => "sine",
            Self::Sweep(_) => "sweep",
            Self::Triangle(_) => "triangle",
        }
    }

    /// Its least and most value.
    pub fn extent(&self) -> [f32; 2] {
        let about = |offset: f32, amplitude: f32| [offset - amplitude, offset + amplitude];
        let [one, other] = match self {
            Self::Step(signal) => [signal.initial_value, signal.final_value],
            Self::Ramp(signal) => [signal.initial_value, signal.final_value],
            Self::Sine(signal) => about(signal.offset, signal.amplitude),
            Self::Sweep(signal) => about(signal.offset, signal.amplitude),
            Self::Triangle(signal) => about(signal.offset, signal.amplitude),
        };
        [one.min(other), one.max(other)]
    }

    /// The signal for the control period.
    ///
    /// # Errors
    /// One of its parameters is out of its range.
    pub fn build(self) -> Result<Generator, InvalidParameter> {
        Ok(match self {
            Self::Step(signal) => Generator::Step(signal.build(CONTROL_PERIOD)?),
            Self::Ramp(signal) => Generator::Ramp(signal.build(CONTROL_PERIOD)?),
            Self::Sine(signal) => Generator::Sine(signal.build(CONTROL_PERIOD)?),
            Self::Sweep(signal) => Generator::Sweep(signal.build(CONTROL_PERIOD)?),
            Self::Triangle(signal) => Generator::Triangle(signal.build(CONTROL_PERIOD)?),
        })
    }
}

/// A signal and how long it lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Command {
    /// The position asked for.
    pub signal: Signal,
    /// Its length, ms; at least one control period.
    pub milliseconds: u32,
}

impl Command {
    /// From one position to another at once, and there.
    pub const fn step(initial_value: f32, final_value: f32, milliseconds: u32) -> Self {
        let step = step::Parameters {
            initial_value,
            final_value,
            time: 0.0,
        };
        Self {
            signal: Signal::Step(step),
            milliseconds,
        }
    }

    /// A sine about `offset` whose frequency, Hz, changes evenly.
    pub const fn sweep(
        (offset, amplitude): (f32, f32),
        (initial_frequency, final_frequency): (f32, f32),
        seconds: u32,
    ) -> Self {
        let sweep = sweep::Parameters {
            offset,
            amplitude,
            initial_frequency,
            final_frequency,
            duration: seconds as f32,
        };
        Self {
            signal: Signal::Sweep(sweep),
            milliseconds: 1000 * seconds,
        }
    }

    /// Straight lines about `offset`; the frequency is in Hz.
    pub const fn triangle((offset, amplitude): (f32, f32), frequency: f32, seconds: u32) -> Self {
        let triangle = triangle::Parameters {
            offset,
            amplitude,
            frequency,
            phase: 0.0,
        };
        Self {
            signal: Signal::Triangle(triangle),
            milliseconds: 1000 * seconds,
        }
    }
}

/// Control steps of a command.
fn steps(command: &Command) -> u32 {
    (command.milliseconds * 1000 / CONTROL_PERIOD_US).max(1)
}

/// A signal bound to the control period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Generator {
    /// From one value to another at once.
    Step(step::Step),
    /// From one value to another in a straight line.
    Ramp(ramp::Ramp),
    /// A sine.
    Sine(sine::Sine),
    /// A sine whose frequency changes.
    Sweep(sweep::Sweep),
    /// Straight lines up and down.
    Triangle(triangle::Triangle),
}

impl Generator {
    /// The value so many control steps after its start.
    pub fn at(&self, tick: u32) -> f32 {
        match self {
            Self::Step(signal) => signal.at(tick),
            Self::Ramp(signal) => signal.at(tick),
            Self::Sine(signal) => signal.at(tick),
            Self::Sweep(signal) => signal.at(tick),
            Self::Triangle(signal) => signal.at(tick),
        }
    }
}

/// Commands bound to the control period, read in order.
#[derive(Debug, Clone, Default)]
pub struct Profile {
    commands: Vec<(Generator, u32), MOST_COMMANDS>,
    current: usize,
    /// Control steps into the current command.
    step: u32,
}

impl Profile {
    /// The commands one after the other.
    ///
    /// # Errors
    /// No command, more than [`MOST_COMMANDS`], or a signal that is out of its range.
    pub fn new(commands: &[Command]) -> Result<Self, InvalidParameter> {
        let mut profile = Self::default();
        let wrong_number = InvalidParameter {
            name: "commands",
            requirement: "must be one to twelve",
        };
        for command in commands {
            profile
                .commands
                .push((command.signal.build()?, steps(command)))
                .map_err(|_| wrong_number)?;
        }
        if profile.commands.is_empty() {
            return Err(wrong_number);
        }
        Ok(profile)
    }

    /// Whether a command begins with the next control step.
    pub fn begins(&self) -> bool {
        self.step == 0
    }

    /// The position asked for in the next control step, rad. Behind the last command the first one
    /// follows. 0 without commands.
    pub fn advance(&mut self) -> f32 {
        let Some((signal, steps)) = self.commands.get(self.current) else {
            return 0.0;
        };
        let position = signal.at(self.step);
        self.step += 1;
        if self.step == *steps {
            self.step = 0;
            self.current += 1;
            if self.current == self.commands.len() {
                self.current = 0;
            }
        }
        position
    }
}
