//! From a world to the log of it.

use std::collections::VecDeque;
use std::fmt::Write;

use super::control::Drive;
use super::laws::Law;
use super::machine::{InputKind, Machine};
use super::plant::{Plant, State};
use super::sensor::{PositionSensor, Quality};
use super::sins::{InputRow, Sins};
use crate::random::Random;

/// Everything that one log follows from.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// What it has beyond its file.
    pub laws: &'a [Law],
    /// Who drives it.
    pub drive: &'a Drive,
    /// Its sensors.
    pub quality: Quality,
    /// Its logger.
    pub sins: Sins,
    /// Rows a second, Hz.
    pub rate: f64,
    /// Rows.
    pub rows: usize,
    /// Seed of the noise.
    pub seed: u64,
}

/// A log as the logger wrote it, and what it did not see.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Record {
    /// s.
    pub time: Vec<f64>,
    /// As the machine's input is.
    pub input: Vec<f64>,
    /// rad or m.
    pub position: Vec<f64>,
    /// A; empty for a log without it.
    pub current: Vec<f64>,
    /// rad/s or m/s; empty for a log without it.
    pub velocity: Vec<f64>,
    /// Where the sensor's side was, rad or m. Not in the log.
    pub true_position: Vec<f64>,
    /// How fast the motor was, rad/s or m/s. Not in the log.
    pub true_velocity: Vec<f64>,
    /// Share of the loop's corrections that asked for all that the drive has.
    pub saturated: f64,
    /// Share of the rows in which nothing moved.
    pub stuck: f64,
}

impl Record {
    /// The log as a user's file.
    pub fn to_csv(&self) -> String {
        let mut text = String::from("time_s,input,position");
        let mut columns = vec![&self.input, &self.position];
        for (name, column) in [("current_a", &self.current), ("velocity", &self.velocity)] {
            if !column.is_empty() {
                text.push(',');
                text.push_str(name);
                columns.push(column);
            }
        }
        text.push('\n');
        for (row, time) in self.time.iter().enumerate() {
            write!(text, "{time:.9}").expect("a String takes any text");
            for column in &columns {
                // Nine digits: more than any logger's converter has.
                write!(text, ",{:.9e}", column[row]).expect("a String takes any text");
            }
            text.push('\n');
        }
        text
    }

    /// Largest less smallest true position, rad or m.
    pub fn stroke(&self) -> f64 {
        let (low, high) = self
            .true_position
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &place| {
                (low.min(place), high.max(place))
            });
        high - low
    }

    fn drop_rows(&mut self, share: f64, random: &mut Random) {
        let kept: Vec<bool> = self.time.iter().map(|_| random.uniform() > share).collect();
        let all = [
            &mut self.time,
            &mut self.input,
            &mut self.position,
            &mut self.current,
            &mut self.velocity,
            &mut self.true_position,
            &mut self.true_velocity,
        ];
        for column in all {
            let mut keep = kept.iter();
            column.retain(|_| *keep.next().unwrap_or(&true));
        }
    }
}

/// Plays a scene.
pub fn play(scene: &Scene) -> Record {
    let mut stage = Stage::new(scene);
    let corrections = scene.sins.corrections;
    let period = 1.0 / (scene.rate * corrections as f64);
    let mut jitter = Random::new(scene.seed ^ 0x71_77E2);
    for tick in 0..scene.rows * corrections {
        let time = tick as f64 * period;
        let reading = stage.correct(time);
        if tick.is_multiple_of(corrections) {
            let late = scene.sins.jitter * jitter.uniform() / scene.rate;
            // Rows of a good logger have the very reading that the loop acts on.
            if late == 0.0 {
                stage.log(reading);
            } else {
                stage.pending = Some(time + late);
            }
        }
        stage.advance(time + period);
    }
    stage.finish()
}

/// A scene on the way.
struct Stage<'a> {
    scene: &'a Scene<'a>,
    plant: Plant,
    state: State,
    controller: super::control::Controller<'a>,
    sensor: PositionSensor,
    random: Random,
    delay: f64,
    /// What acts now, and what will: time and value.
    acting: f64,
    coming: VecDeque<(f64, f64)>,
    told: f64,
    all_told: Vec<f64>,
    pending: Option<f64>,
    saturated: usize,
    still: usize,
    record: Record,
}

impl<'a> Stage<'a> {
    fn new(scene: &'a Scene<'a>) -> Self {
        let seconds = scene.rows as f64 / scene.rate;
        let plant = Plant::new(scene.machine, scene.laws, seconds, 1.0 / scene.rate);
        let controller = scene.drive.controller(scene.machine);
        let state = plant.at_rest(controller.command(0.0));
        let mut sensor = PositionSensor::new(scene.machine, scene.laws, &scene.quality);
        sensor.see(&state);
        let delays = scene.laws.iter().map(|law| match law {
            Law::InputDelay { seconds } => *seconds,
            _ => 0.0,
        });
        Self {
            scene,
            plant,
            state,
            controller,
            sensor,
            random: Random::new(scene.seed),
            delay: delays.sum(),
            acting: 0.0,
            coming: VecDeque::new(),
            told: 0.0,
            all_told: Vec::new(),
            pending: None,
            saturated: 0,
            still: 0,
            record: Record::default(),
        }
    }

    /// Lets the loop correct, and returns what it read.
    fn correct(&mut self, time: f64) -> f64 {
        let reading = self.sensor.report(&mut self.random);
        // What a log can hold: the drive's own converter is no finer.
        let notch = self.scene.machine.limit / 32768.0;
        let told = self.controller.step(time, reading);
        self.told = (told / notch).round() * notch;
        if told.abs() >= self.scene.machine.limit {
            self.saturated += 1;
        }
        self.all_told.push(self.told);
        if self.delay > 0.0 {
            self.coming.push_back((time + self.delay, self.told));
        } else {
            self.acting = self.told;
        }
        reading
    }

    /// Carries the plant to a time, through the edges of a late input and the rows on the way.
    fn advance(&mut self, until: f64) {
        loop {
            let edge = self.coming.front().map_or(f64::INFINITY, |(time, _)| *time);
            let row = self.pending.unwrap_or(f64::INFINITY);
            let next = edge.min(row).min(until);
            self.carry(next);
            if edge <= next {
                if let Some((_, value)) = self.coming.pop_front() {
                    self.acting = value;
                }
            } else if row <= next {
                self.pending = None;
                let reading = self.sensor.report(&mut self.random);
                self.log(reading);
            } else {
                return;
            }
        }
    }

    fn carry(&mut self, until: f64) {
        let stride = self.sensor.stride(self.plant.step());
        let mut time = self.state.time;
        while time < until {
            time = (time + stride).min(until);
            self.plant.advance(&mut self.state, self.acting, time);
            self.sensor.see(&self.state);
        }
    }

    fn log(&mut self, reading: f64) {
        let quality = &self.scene.quality;
        let record = &mut self.record;
        record.time.push(self.state.time);
        record.input.push(self.told);
        record.position.push(reading);
        if let Some(noise) = quality.current_noise
            && self.scene.machine.input == InputKind::Voltage
        {
            let current = self.state.current() + noise * self.random.normal();
            record.current.push(current);
        }
        if let Some(noise) = quality.velocity_noise {
            let velocity = self.state.load_velocity() + noise * self.random.normal();
            record.velocity.push(velocity);
        }
        record.true_position.push(self.state.load_position());
        record.true_velocity.push(self.state.motor_velocity());
        self.still += usize::from(self.state.is_stuck() || self.state.motor_velocity() == 0.0);
    }

    /// What the logger makes of it.
    fn finish(mut self) -> Record {
        let sins = &self.scene.sins;
        let rows = self.record.time.len();
        self.record.saturated = self.saturated as f64 / self.all_told.len().max(1) as f64;
        self.record.stuck = self.still as f64 / rows.max(1) as f64;
        match sins.input {
            InputRow::Exact => {}
            InputRow::RowLate => {
                self.record.input.rotate_right(1);
                if let Some(first) = self.record.input.first_mut() {
                    *first = 0.0;
                }
            }
            InputRow::Averaged => {
                let means = self.all_told.chunks(sins.corrections);
                self.record.input = means
                    .map(|row| row.iter().sum::<f64>() / row.len() as f64)
                    .collect();
            }
        }
        if !self.record.current.is_empty() {
            self.record.current = sins.current(&self.record.current);
        }
        if let Some((row, strokes)) = sins.glitch_at(&mut self.random, rows) {
            let size = strokes * self.scene.machine.amplitude;
            self.record.position[row] += size;
        }
        if sins.dropped > 0.0 {
            self.record.drop_rows(sins.dropped, &mut self.random);
        }
        self.record
    }
}
