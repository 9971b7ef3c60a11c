//! Other readings of logs and machine file: each a transformation of a column, or of a declared number.

use std::f64::consts::TAU;

use super::balance::{Balances, Follows};
use super::channels::{self, Channels, Column, largest};
use super::limits::SHORTEST_AS_MILLISECONDS;
use super::measure::{Clue, Subject, clues, total};
use super::units::{self, Unit};
use crate::machine::{Coordinate, Machine};

/// One transformation that would mend a log or a machine file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Correction {
    /// A column is in another unit.
    Unit(Column, &'static str, &'static str, f64),
    /// A column is the sensor's counts, of so much each.
    Counts(f64),
    /// The input is a share of the supply's voltage: whether in per cent, and the volts of the supply.
    Duty(bool, f64),
    /// A column is to be multiplied by a small whole number, or divided by it.
    Factor(Column, f64),
    /// The velocity is that of the other side of a gear.
    Geared(f64),
    /// A column has the wrong sign.
    Negative(Column),
    /// Two columns are swapped.
    Swapped(Column, Column),
    /// The position starts again after so much.
    Wrapped(f64),
    /// A number of the machine file is in another unit: its name, that unit, the right value.
    Number(&'static str, &'static str, f64),
}

impl Correction {
    /// Whether both change the same thing in the same way, so that one of them is enough.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Unit(one, ..), Self::Unit(other, ..)) => one == other,
            (Self::Number(one, ..), Self::Number(other, ..)) => one == other,
            (Self::Duty(..), Self::Duty(..)) | (Self::Counts(_), Self::Counts(_)) => true,
            (Self::Geared(_), Self::Geared(_)) | (Self::Wrapped(_), Self::Wrapped(_)) => true,
            (one, other) => one == other,
        }
    }
}

/// Logs and machine file, read in one way.
#[derive(Debug, Clone)]
pub struct Reading {
    /// The machine file.
    pub machine: Machine,
    /// The logs.
    pub logs: Vec<Channels>,
    /// The corrections that lead to it.
    pub corrections: Vec<Correction>,
    /// What the log alone says.
    pub balances: Balances,
    /// What does not fit.
    pub clues: Vec<Clue>,
    /// What that costs, with how unusual the corrections are, nats.
    pub cost: f64,
    rarity: f64,
}

impl Reading {
    /// As declared.
    pub fn declared(machine: &Machine, logs: Vec<Channels>) -> Self {
        let balances = Balances::of(&logs, machine);
        let clues = clues(machine, &logs, &balances);
        Self {
            machine: machine.clone(),
            corrections: Vec::new(),
            cost: total(&clues),
            rarity: 0.0,
            logs,
            balances,
            clues,
        }
    }

    /// With one more correction, which is that unusual.
    pub fn with(&self, correction: Correction, rarity: f64) -> Self {
        let mut machine = self.machine.clone();
        let mut logs = self.logs.clone();
        for log in &mut logs {
            match correction {
                Correction::Unit(column, _, _, factor) => log.scale(column, factor),
                Correction::Factor(column, factor) => log.scale(column, factor),
                Correction::Counts(size) => log.scale(Column::Position, size),
                Correction::Duty(percent, volts) => {
                    let gain = volts * if percent { 0.01 } else { 1.0 };
                    log.scale(Column::Input, gain / self.machine.gain.abs());
                }
                Correction::Geared(ratio) => log.scale(Column::Velocity, 1.0 / ratio),
                Correction::Negative(column) => log.scale(column, -1.0),
                Correction::Swapped(one, other) => log.swap(one, other),
                Correction::Wrapped(turn) => log.unwrap_position(turn),
                Correction::Number(..) => {}
            }
        }
        let balances = if let Correction::Number(name, _, value) = correction {
            set(&mut machine, name, value);
            self.balances.clone()
        } else {
            Balances::of(&logs, &machine)
        };
        let clues = clues(&machine, &logs, &balances);
        let rarity = self.rarity + rarity;
        Self {
            cost: total(&clues) + rarity,
            rarity,
            corrections: [&self.corrections[..], &[correction]].concat(),
            machine,
            logs,
            balances,
            clues,
        }
    }

    /// Every reading that is one correction further, each with the cost.
    pub fn further(&self) -> Vec<Self> {
        let mut tried = Vec::new();
        let mut attempt = |correction: Correction, rarity: f64| {
            if !self
                .corrections
                .iter()
                .any(|known| known.is_like(&correction))
            {
                tried.push(self.with(correction, rarity));
            }
        };
        // A jump is a jump in every unit: until it is out, nothing else can be seen.
        if let Some(wrap) = channels::wrap(&self.logs) {
            attempt(Correction::Wrapped(wrap.turn), 0.0);
            return tried;
        }
        for (correction, rarity) in self.of_units().into_iter().chain(self.of_signs()) {
            attempt(correction, rarity);
        }
        for (correction, rarity) in self.of_numbers() {
            attempt(correction, rarity);
        }
        tried
    }

    fn has(&self, column: Column) -> bool {
        self.logs.iter().all(|log| log.column(column).is_some())
    }

    fn of_units(&self) -> Vec<(Correction, f64)> {
        let rotary = self.machine.coordinate == Coordinate::Radian;
        let of = |column: Column, units: &[Unit]| -> Vec<(Correction, f64)> {
            let correction = |unit: &Unit| {
                let correction = Correction::Unit(column, unit.name, unit.import, unit.factor);
                (correction, unit.rarity)
            };
            units.iter().map(correction).collect()
        };
        let mut all = of(
            Column::Position,
            if rotary {
                &units::ANGLES
            } else {
                &units::STROKES
            },
        );
        if self.logs[0].period >= SHORTEST_AS_MILLISECONDS {
            all.extend(of(Column::Time, &units::TIMES));
        }
        let milli = |column, name, import| (Correction::Unit(column, name, import, 1e-3), 0.0);
        if self.machine.motor.is_some() {
            all.push(milli(Column::Input, "millivolts", "mV"));
            if self.has(Column::Current) {
                all.push(milli(Column::Current, "milliamperes", "mA"));
            }
            all.extend(self.of_duty());
        } else {
            all.push(milli(Column::Input, "thousandths of its unit", ""));
        }
        if self.has(Column::Velocity) {
            let velocities: &[Unit] = if rotary {
                &units::ANGULAR_VELOCITIES
            } else {
                &units::LINEAR_VELOCITIES
            };
            all.extend(of(Column::Velocity, velocities));
            all.extend(self.gear().map(|ratio| (Correction::Geared(ratio), 2.0)));
        }
        if channels::are_counts(&self.logs) {
            let sizes = match self.machine.resolution {
                Some(size) => vec![size],
                None if rotary => units::COUNTS_A_TURN
                    .iter()
                    .map(|count| TAU / count)
                    .collect(),
                None => Vec::new(),
            };
            all.extend(
                sizes
                    .into_iter()
                    .map(|size| (Correction::Counts(size), 0.5)),
            );
        }
        all
    }

    fn of_duty(&self) -> Vec<(Correction, f64)> {
        let most = self
            .logs
            .iter()
            .map(|log| largest(&log.input))
            .fold(0.0, f64::max);
        // A duty ends at one, a percentage at a hundred.
        let kinds = [(false, 1.0), (true, 100.0)]
            .into_iter()
            .filter(|(_, end)| most <= 1.001 * end);
        kinds
            .flat_map(|(percent, _)| {
                units::SUPPLIES.map(|volts| (Correction::Duty(percent, volts), 1.0))
            })
            .collect()
    }

    /// The ratio that would make the measured velocity the position's.
    fn gear(&self) -> Option<f64> {
        let share = self.balances.velocity.as_ref()?.share(Follows::Velocity)?;
        let (low, high) = share.interval;
        let ratio = 0.5 * (low + high);
        (low * high > 0.0).then_some(ratio)
    }

    fn of_signs(&self) -> Vec<(Correction, f64)> {
        let signs = [
            Column::Position,
            Column::Input,
            Column::Current,
            Column::Velocity,
        ];
        // A sign is wrong where something is negative that must not be.
        let is_negative = self.clues.iter().any(|clue| clue.ratio < 0.0);
        let there = signs
            .into_iter()
            .filter(|column| is_negative && self.has(*column));
        let mut all: Vec<_> = there
            .map(|column| (Correction::Negative(column), 0.0))
            .collect();
        let pairs = [
            (Column::Input, Column::Current, 1.0),
            (Column::Position, Column::Velocity, 2.0),
            // A command is so much like a position, in the right unit too, that it is not to be taken for
            // one lightly.
            (Column::Position, Column::Command, 6.0),
        ];
        let there = pairs
            .into_iter()
            .filter(|(one, other, _)| self.has(*one) && self.has(*other));
        all.extend(there.map(|(one, other, rarity)| (Correction::Swapped(one, other), rarity)));
        all
    }

    fn of_numbers(&self) -> Vec<(Correction, f64)> {
        // Only numbers that do not fit need another unit.
        let named: Vec<&'static str> = self
            .clues
            .iter()
            .filter_map(|clue| match clue.subject {
                Subject::Number(name) => Some(name),
                _ => None,
            })
            .collect();
        let rotary = self.machine.coordinate == Coordinate::Radian;
        let mut all = Vec::new();
        let motor = ["torque_constant", "resistance", "inductance"];
        let every = crate::machine::PARAMETERS
            .iter()
            .map(|parameter| parameter.name);
        for name in every.filter(|name| named.contains(name) || motor.contains(name)) {
            let Some(declared) = self.machine.parameter(name).filter(|value| *value > 0.0) else {
                continue;
            };
            for unit in units::of_number(name, rotary) {
                let correction = Correction::Number(name, unit.name, declared * unit.factor);
                all.push((correction, 0.5 + unit.rarity));
            }
            if name == "torque_constant" && rotary {
                let value = 60.0 / TAU / declared;
                all.push((Correction::Number(name, "rpm/V", value), 2.0));
            }
        }
        all
    }
}

/// Sets a number of the machine.
fn set(machine: &mut Machine, name: &str, value: f64) {
    let mechanics = &mut machine.mechanics;
    match (name, &mut machine.motor) {
        ("resistance", Some(motor)) => motor.resistance = value,
        ("inductance", Some(motor)) => motor.inductance = value,
        ("torque_constant", Some(motor)) => motor.torque_constant = value,
        ("inertia", _) => mechanics.inertia = value,
        ("viscous", _) => mechanics.viscous = value,
        ("spring", _) => mechanics.spring = value,
        ("spring_preload", _) => mechanics.spring_preload = value,
        ("gravity_torque", _) => mechanics.gravity_torque = value,
        ("coulomb", _) => machine.friction.coulomb = value,
        ("static", _) => machine.friction.r#static = value,
        _ => {}
    }
}
