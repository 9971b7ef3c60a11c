//! The columns of a log as one reading of it has them, and what can be seen in them without a machine.

use super::limits::{BOTH_WAYS, GLITCHES, STEP_OF_A_WRAP};
use super::units;
use crate::gap::metrics::differentiate;
use crate::log::resample::smallest_step;
use crate::log::{COLUMNS, COMMAND, CURRENT, INPUT, Log, POSITION, TIME, VELOCITY, median};
use crate::machine::Motor;

/// The columns of one log that a reading may change.
#[derive(Debug, Clone)]
pub struct Channels {
    /// Sampling period, s.
    pub period: f64,
    /// What the drive was told.
    pub input: Vec<f64>,
    /// Position, rad or m.
    pub position: Vec<f64>,
    /// Position asked for.
    pub command: Option<Vec<f64>>,
    /// Current, A.
    pub current: Option<Vec<f64>>,
    /// Velocity.
    pub velocity: Option<Vec<f64>>,
    /// Friction of a brake.
    pub brake: Option<Vec<f64>>,
    /// Torque or force from outside, against positive motion.
    pub load: Option<Vec<f64>>,
    /// 0 while the drive lets go of the motor, else 1.
    pub enabled: Option<Vec<f64>>,
    /// Smallest step of the position, where it is made of such steps.
    pub step: Option<f64>,
}

/// A column that a reading may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// `time_s`
    Time,
    /// `input`
    Input,
    /// `position`
    Position,
    /// `current_a`
    Current,
    /// `velocity`
    Velocity,
    /// `command`
    Command,
}

impl Column {
    /// Its place among the columns of a log.
    pub fn index(self) -> usize {
        match self {
            Self::Time => TIME,
            Self::Input => INPUT,
            Self::Position => POSITION,
            Self::Current => CURRENT,
            Self::Velocity => VELOCITY,
            Self::Command => COMMAND,
        }
    }

    /// Its name in the log.
    pub fn name(self) -> &'static str {
        COLUMNS[self.index()].0
    }
}

impl Channels {
    /// The log as it stands.
    pub fn of(log: &Log) -> Self {
        Self {
            period: log.period_s,
            input: log.input.clone(),
            position: log.position.clone(),
            command: log.command.clone(),
            current: log.current.clone(),
            velocity: log.velocity.clone(),
            brake: log.brake.clone(),
            load: log.load_torque.clone(),
            enabled: log.enabled.clone(),
            step: log.position_step(),
        }
    }

    /// A column's values; of the time there are none.
    pub fn column(&self, column: Column) -> Option<&[f64]> {
        match column {
            Column::Time => None,
            Column::Input => Some(&self.input),
            Column::Position => Some(&self.position),
            Column::Current => self.current.as_deref(),
            Column::Velocity => self.velocity.as_deref(),
            Column::Command => self.command.as_deref(),
        }
    }

    fn column_mut(&mut self, column: Column) -> Option<&mut Vec<f64>> {
        match column {
            Column::Time => None,
            Column::Input => Some(&mut self.input),
            Column::Position => Some(&mut self.position),
            Column::Current => self.current.as_mut(),
            Column::Velocity => self.velocity.as_mut(),
            Column::Command => self.command.as_mut(),
        }
    }

    /// Multiplies a column.
    pub fn scale(&mut self, column: Column, factor: f64) {
        if column == Column::Time {
            self.period *= factor;
        }
        if column == Column::Position {
            self.step = self.step.map(|step| step * factor.abs());
        }
        if let Some(values) = self.column_mut(column) {
            for value in values {
                *value *= factor;
            }
        }
    }

    /// Gives the input the sign of what drives the motion: of the voltage that current and speed ask for of a motor, or of the
    /// speed where no current was measured.
    pub fn sign_input(&mut self, motor: Option<&Motor>) {
        let mut drive = differentiate(&self.position, self.period);
        if let (Some(current), Some(motor)) = (&self.current, motor) {
            for (drive, current) in drive.iter_mut().zip(current) {
                *drive = motor.resistance * current + motor.torque_constant * *drive;
            }
        }
        for (value, drive) in self.input.iter_mut().zip(drive) {
            *value = value.abs() * drive.signum();
        }
    }

    /// Exchanges two columns; nothing happens where one of them is not there.
    pub fn swap(&mut self, one: Column, other: Column) {
        let (Some(first), Some(second)) = (self.column(one), self.column(other)) else {
            return;
        };
        let (first, second) = (first.to_vec(), second.to_vec());
        if let Some(values) = self.column_mut(one) {
            *values = second;
        }
        if let Some(values) = self.column_mut(other) {
            *values = first;
        }
        if [one, other].contains(&Column::Position) {
            self.step = smallest_step(&self.position);
        }
    }

    /// Takes the jumps of a turn out of the position.
    pub fn unwrap_position(&mut self, turn: f64) {
        let mut turns = 0.0;
        let mut last = self.position[0];
        for value in &mut self.position {
            let measured = *value;
            turns -= ((measured - last) / turn).round();
            last = measured;
            *value = measured + turns * turn;
        }
    }
}

/// Largest size of a column's values.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// Largest size of the logs' inputs, but for a few samples that may be damaged.
pub fn largest_input(logs: &[Channels]) -> f64 {
    let inputs = logs.iter().flat_map(|log| &log.input);
    let mut sizes: Vec<f64> = inputs.map(|input| input.abs()).collect();
    let damaged = (GLITCHES * sizes.len() as f64) as usize;
    let place = sizes.len() - 1 - damaged;
    *sizes.select_nth_unstable_by(place, f64::total_cmp).1
}

/// What a position that starts again after a turn shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrap {
    /// The length of a turn.
    pub turn: f64,
    /// Jumps in all logs.
    pub jumps: usize,
    /// Largest step that is no jump.
    pub step: f64,
}

/// Jumps of a turn: there are steps of the size of the whole range, and none between them and the steps
/// of the motion. A sample that is alone behind its jump, at an end of its log or there and back, is a damaged one, and
/// makes no turn.
pub fn wrap(logs: &[Channels]) -> Option<Wrap> {
    let logs: Vec<&[f64]> = logs.iter().map(|log| &log.position[..]).collect();
    wrap_of(&logs)
}

/// As [`wrap`], of positions.
pub fn wrap_of(logs: &[&[f64]]) -> Option<Wrap> {
    let positions = || logs.iter().copied().flatten();
    let low = positions().copied().fold(f64::INFINITY, f64::min);
    let high = positions().copied().fold(f64::NEG_INFINITY, f64::max);
    let range = high - low;
    let steps: Vec<f64> = logs
        .iter()
        .flat_map(|log| log.windows(2).map(|pair| (pair[1] - pair[0]).abs()))
        .collect();
    let is_jump = |log: &[f64], at: usize| {
        let pair = log.get(at..at + 2);
        pair.is_none_or(|pair| (pair[1] - pair[0]).abs() > 0.5 * range)
    };
    // A turn is followed and led up to by motion.
    let is_turn = |log: &[f64], at: usize| {
        is_jump(log, at) && at > 0 && !is_jump(log, at - 1) && !is_jump(log, at + 1)
    };
    let turns = |log: &&[f64]| (0..log.len().saturating_sub(1)).any(|at| is_turn(log, at));
    if range > 0.0 && !logs.iter().any(turns) {
        return None;
    }
    let mut jumps: Vec<f64> = steps
        .iter()
        .copied()
        .filter(|step| *step > 0.5 * range)
        .collect();
    if jumps.is_empty() || range == 0.0 {
        return None;
    }
    jumps.sort_by(f64::total_cmp);
    let most = jumps[jumps.len() - 1];
    let motion = steps.iter().copied().filter(|step| *step <= 0.5 * range);
    let step = motion.fold(0.0, f64::max);
    // A jump is a turn less one step of the motion, so that it never comes to more than a turn; and the
    // range is less than a turn, but hardly.
    let moved = step > 0.0 && step < STEP_OF_A_WRAP * most;
    if !moved || jumps[0] < most - 2.0 * step || most < (1.0 - STEP_OF_A_WRAP) * range {
        return None;
    }
    let is_near = |turn: &f64| *turn >= range - 1e-9 * range && *turn <= most + 2.0 * step;
    // Between two steps of the motion a jump has one of them in it, about their mean.
    let around = |log: &[f64], at: usize| {
        let step = |at: usize| log[at + 1] - log[at];
        is_turn(log, at).then(|| (step(at) - 0.5 * (step(at - 1) + step(at + 1))).abs())
    };
    let around_all = |log: &&[f64]| -> Vec<f64> {
        let inner = 1..log.len().saturating_sub(2);
        inner.filter_map(|at| around(log, at)).collect()
    };
    let turns: Vec<f64> = logs.iter().flat_map(around_all).collect();
    let seen = median(&turns);
    let known = units::wraps().filter(is_near);
    let known = known.min_by(|a, b| (a - seen).abs().total_cmp(&(b - seen).abs()));
    // A sensor's turn is a whole number of its steps.
    let whole = || {
        let steps = logs.iter().filter_map(|log| smallest_step(log));
        let least = steps.min_by(f64::total_cmp)?;
        Some(least * (seen / least).round())
    };
    Some(Wrap {
        turn: known.or_else(whole).unwrap_or(seen),
        jumps: jumps.len(),
        step,
    })
}

/// The smallest step of the position sensor, where the logs are made of such steps.
pub fn quantum(logs: &[Channels]) -> Option<f64> {
    logs.iter()
        .filter_map(|log| log.step)
        .min_by(f64::total_cmp)
}

/// Whether every position is a whole number, and some are not zero.
pub fn are_counts(logs: &[Channels]) -> bool {
    let mut positions = logs.iter().flat_map(|log| &log.position);
    let moved = logs.iter().any(|log| largest(&log.position) >= 10.0);
    moved && positions.all(|position| position.fract() == 0.0)
}

/// Whether the input may be the size of what it was: it never changes its sign, though the machine moves both ways.
pub fn may_lack_sign(logs: &[Channels]) -> bool {
    let has_one_sign = |log: &Channels| {
        log.input.iter().all(|value| *value >= 0.0) || log.input.iter().all(|value| *value <= 0.0)
    };
    let (mut forward, mut backward) = (0.0, 0.0);
    for log in logs {
        for pair in log.position.windows(2) {
            let step = pair[1] - pair[0];
            forward += step.max(0.0);
            backward += (-step).max(0.0);
        }
    }
    logs.iter().all(has_one_sign) && forward.min(backward) > BOTH_WAYS * (forward + backward)
}
