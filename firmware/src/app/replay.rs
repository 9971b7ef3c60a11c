//! A recorded drive replayed: the model on a [`Tape`] stepped in the plant interrupt, with the inputs
//! on it and nothing else.
//!
//! What it gives is what a loop's plant would do with the same voltages, to the last bit: the same
//! functions at the same period. A row of the tape is a sample of the log that it was made from: the
//! position at the row, then its input until the next one.

use heapless::spsc::Producer;
use model_core::gap::lateness::Lateness;
use model_core::gap::simulator::{Course, Given, Simulator};
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::actuator::External;
use model_core::plant::inter_sample::InterSample;
use model_core::plant::parameters::ParameterError;
use model_core::plant::piecewise_affine::PiecewiseAffine;
use model_core::plant::{InputRefused, State};

use super::fault::Fault;
use super::tape::{Driven, Tape};
use super::timing::PLANT_PERIOD;
use super::wiring::Wiring;
use super::work::PlantWork;

/// The model of a tape and where it stands.
#[derive(Debug, Clone)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and no heap for the larger variant"
)]
enum Plant {
    Physical {
        simulator: Simulator,
        course: Course,
    },
    PiecewiseAffine(InterSample),
}

/// What is wrong with the model of a tape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelError {
    /// A parameter of the physics.
    Physical(ParameterError),
    /// A parameter of the piecewise affine model, or its period.
    PiecewiseAffine(InvalidParameter),
}

impl core::fmt::Display for ModelError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Physical(error) => error.fmt(formatter),
            Self::PiecewiseAffine(error) => error.fmt(formatter),
        }
    }
}

impl core::error::Error for ModelError {}

/// A replay under way.
#[derive(Debug, Clone)]
pub struct Replay<'a> {
    tape: Tape<'a>,
    plant: Plant,
    /// Ticks so far. The first samples the initial state, without a step.
    ticks: u32,
}

/// A row that was reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Its number, from 0.
    pub row: u32,
    /// Position of the model, rad or m.
    pub position: f32,
    /// Its motor current, A; 0 for a piecewise affine model, which knows none.
    pub current: f32,
}

impl<'a> Replay<'a> {
    /// Binds the tape's model for the plant's period.
    ///
    /// # Errors
    /// A parameter of the model outside its range.
    pub fn new(tape: Tape<'a>) -> Result<Self, ModelError> {
        let start = tape.head.start;
        let plant = match &tape.head.model {
            Driven::Physical(model) => {
                let simulator = model.build(PLANT_PERIOD).map_err(ModelError::Physical)?;
                let mut state = State::new(start, 0.0);
                state.current = simulator.steady_current(0.0, 0.0);
                let course = Course::new(state);
                Plant::Physical { simulator, course }
            }
            Driven::PiecewiseAffine(parameters) => {
                let built = PiecewiseAffine::build(parameters.clone())
                    .and_then(|model| InterSample::new(model, start, PLANT_PERIOD));
                Plant::PiecewiseAffine(built.map_err(ModelError::PiecewiseAffine)?)
            }
        };
        Ok(Self {
            tape,
            plant,
            ticks: 0,
        })
    }

    /// Rows of the tape.
    pub fn rows(&self) -> u32 {
        self.tape.head.inputs
    }

    /// One plant period; the row that it ends on, if it does. Beyond the last row the last input goes
    /// on acting, and there is no further row.
    ///
    /// # Errors
    /// An input that the plant refuses.
    pub fn tick(&mut self) -> Result<Option<Row>, InputRefused> {
        let per_input = self.tape.head.ticks_per_input;
        if self.ticks > 0 {
            let tick = self.ticks - 1;
            match &mut self.plant {
                Plant::Physical { simulator, course } => {
                    let late = simulator.input_lateness();
                    let acting = |late: Lateness| input(&self.tape, late.behind(tick as usize));
                    let given = Given {
                        input: acting(late),
                        previous: acting(late.one_more()),
                        external: External::NONE,
                        index: tick as usize,
                    };
                    simulator.step(course, &given)?;
                }
                Plant::PiecewiseAffine(model) => {
                    model.tick(input(&self.tape, Some(tick as usize)))?;
                }
            }
        }
        let (position, current) = match &self.plant {
            Plant::Physical { simulator, course } => {
                (simulator.reported(course), course.state.current)
            }
            Plant::PiecewiseAffine(model) => (model.position(), 0.0),
        };
        let (row, between) = (self.ticks / per_input, self.ticks % per_input);
        self.ticks = self.ticks.saturating_add(1);
        Ok((between == 0 && row < self.rows()).then_some(Row {
            row,
            position,
            current,
        }))
    }
}

/// The input that acts at a tick; none before the first one, as where the drive is late.
fn input(tape: &Tape, tick: Option<usize>) -> f32 {
    tick.map_or(0.0, |tick| {
        let row = tick / tape.head.ticks_per_input as usize;
        tape.input(row.min(tape.head.inputs as usize - 1))
    })
}

/// A replay as the work of the plant interrupt: rows go into a queue, and nobody drives it.
pub struct Playback {
    replay: Replay<'static>,
    rows: Producer<'static, Row>,
    wiring: &'static Wiring,
}

impl Playback {
    /// Begins with the next tick.
    pub fn new(
        replay: Replay<'static>,
        rows: Producer<'static, Row>,
        wiring: &'static Wiring,
    ) -> Self {
        Self {
            replay,
            rows,
            wiring,
        }
    }
}

impl PlantWork for Playback {
    /// No control step is ever due. An input that the plant refuses trips the latch; a row that finds
    /// the queue full is lost, and its number is missing among the others.
    fn tick(&mut self) -> bool {
        self.wiring.count_tick();
        match self.replay.tick() {
            Ok(Some(row)) => {
                let _ = self.rows.enqueue(row);
            }
            Ok(None) => {}
            Err(InputRefused) => self.wiring.trip(Fault::NonFinite),
        }
        false
    }
}
