//! A recorded drive replayed: the model on a [`Tape`] stepped in the plant interrupt, with the inputs
//! on it and nothing else.
//!
//! What it gives is what a loop's plant would do with the same voltages, to the last bit: the same
//! functions at the same period. A row of the tape is a sample of the log that it was made from: the
//! position at the row, then its input until the next one.

use heapless::spsc::Producer;
use model_core::gap::simulator::Simulator;
use model_core::plant::parameters::ParameterError;
use model_core::plant::{InputRefused, State};

use super::tape::Tape;
use super::timing::PLANT_PERIOD;
use super::wiring::{Fault, Wiring};
use super::work::PlantWork;

/// A replay under way.
#[derive(Debug, Clone)]
pub struct Replay<'a> {
    tape: Tape<'a>,
    simulator: Simulator,
    state: State,
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
    /// Its motor current, A.
    pub current: f32,
}

impl<'a> Replay<'a> {
    /// Binds the tape's model for the plant's period.
    ///
    /// # Errors
    /// A parameter of the model outside its range.
    pub fn new(tape: Tape<'a>) -> Result<Self, ParameterError> {
        let simulator = tape.head.model.build(PLANT_PERIOD)?;
        let mut state = State::new(tape.head.start, 0.0);
        state.current = simulator.steady_current(0.0, 0.0);
        Ok(Self {
            tape,
            simulator,
            state,
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
            let inputs = self.inputs(tick);
            self.simulator
                .step(&mut self.state, inputs, tick as usize)?;
        }
        let (row, between) = (self.ticks / per_input, self.ticks % per_input);
        self.ticks = self.ticks.saturating_add(1);
        Ok((between == 0 && row < self.rows()).then(|| Row {
            row,
            position: self.state.position.value(),
            current: self.state.current,
        }))
    }

    /// The inputs that act in the beginning and in the end of the step behind a tick: those of a while
    /// ago where the drive or the sensor is late.
    fn inputs(&self, tick: u32) -> (f32, f32) {
        let late = self.simulator.input_lateness().whole as u32;
        let last = self.rows() - 1;
        let at = |tick: Option<u32>| {
            tick.map_or(0.0, |tick| {
                let row = (tick / self.tape.head.ticks_per_input).min(last);
                self.tape.input(row as usize)
            })
        };
        let now = tick.checked_sub(late);
        (at(now.and_then(|now| now.checked_sub(1))), at(now))
    }
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
