//! Other readings of logs and machine file: each a transformation of a column, or of a declared number.

use std::f64::consts::TAU;

use super::balance::{Balances, Follows};
use super::channels::{self, Channels, Column};
use super::factor::is_guess;
use super::limits::{
    FITTED_FACTOR, HINT, LONGEST_PERIOD, SAME_FACTOR, SAME_STEP, SHEET, SHORTEST_AS_MILLISECONDS,
};
use super::measure::{Clue, Subject, clues, total};
use super::units::{self, Unit};
use crate::log::rounded;
use crate::machine::{Coordinate, Machine};

/// One transformation that would mend a log or a machine file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Correction {
    /// A column is in another unit.
    Unit(Column, &'static str, &'static str, f64),
    /// A column is the sensor's counts, of so much each.
    Counts(f64),
    /// The input is a share of the supply's voltage: what the whole is, 1, 100 or a counter's full scale, and the volts
    /// of the supply.
    Duty(f64, f64),
    /// A column is to be multiplied by a small whole number, or divided by it.
    Factor(Column, f64),
    /// A column is in one unit, that which it has to be in where none is named, and was taken for one in another.
    Taken(Column, Option<&'static str>, &'static str, f64),
    /// Position or velocity is that of the other side of a gear, so many times as large.
    Geared(Column, f64),
    /// Position and velocity both are, as from one sensor.
    GearedSensor(f64),
    /// A column has the wrong sign.
    Negative(Column),
    /// Position and velocity have the wrong sign: the encoder counts the other way.
    Reversed,
    /// Two columns are swapped.
    Swapped(Column, Column),
    /// The position starts again after so much.
    Wrapped(f64),
    /// Input or current is the size of what it was, without its sign.
    Unsigned(Column),
    /// A number of the machine file is in another unit: its name, that unit, the right value.
    Number(&'static str, &'static str, f64),
}

/// A number that a data sheet has.
#[derive(Debug, Clone, Copy)]
pub struct Stated {
    /// Its name.
    pub name: &'static str,
    /// What the log asks for over what is declared, at least and at most.
    pub ratio: (f64, f64),
    /// How far that may be off, as a factor either way.
    pub tolerance: f64,
}

impl Stated {
    /// What the log asks for over what is declared, where that is more or less than the tolerance allows; else 1.
    pub fn off(&self) -> f64 {
        let (low, high) = self.ratio;
        if low > self.tolerance {
            low
        } else if high < self.tolerance.recip() {
            high
        } else {
            1.0
        }
    }

    /// How far what the log asks for is from what is declared, in standard deviations: a tolerance is two.
    fn deviations(&self) -> f64 {
        let (low, high) = self.ratio;
        let off = if low > 1.0 { low } else { high.min(1.0) };
        // A wrong sign is as far as anything.
        2.0 * off.max(f64::MIN_POSITIVE).ln() / self.tolerance.ln()
    }
}

impl Correction {
    /// Whether it changes more of a column than its scale, so that what the balances leave open tells whether it is right.
    fn changes_the_course(&self) -> bool {
        match self {
            Self::Swapped(one, other) => [one, other].contains(&&Column::Position),
            Self::Unsigned(column) => *column == Column::Input,
            _ => false,
        }
    }

    /// The column that it multiplies, and nothing else.
    pub fn scales(&self) -> Option<Column> {
        match self {
            Self::Unit(column, ..)
            | Self::Taken(column, ..)
            | Self::Factor(column, _)
            | Self::Geared(column, _) => Some(*column),
            Self::Counts(_) => Some(Column::Position),
            Self::Duty(..) => Some(Column::Input),
            _ => None,
        }
    }

    /// Whether it has to be made before a column is multiplied.
    pub fn comes_first(&self) -> bool {
        matches!(self, Self::Swapped(..) | Self::Wrapped(_))
    }

    /// Whether both change the same thing in the same way, so that one of them is enough.
    fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::Unit(one, ..) | Self::Taken(one, ..),
                Self::Unit(other, ..) | Self::Taken(other, ..),
            ) => one == other,
            (Self::Number(one, ..), Self::Number(other, ..)) => one == other,
            (Self::Duty(..), Self::Duty(..)) | (Self::Counts(_), Self::Counts(_)) => true,
            (Self::Geared(one, _), Self::Geared(other, _)) => one == other,
            (Self::GearedSensor(_), Self::GearedSensor(_) | Self::Geared(..))
            | (Self::Geared(..), Self::GearedSensor(_)) => true,
            (Self::Wrapped(_), Self::Wrapped(_)) => true,
            (one, other) => one == other,
        }
    }
}

/// Corrections, with what the reading that they lead to costs.
#[derive(Debug, Clone)]
pub struct Tried {
    /// The corrections, in the order in which they are made.
    pub corrections: Vec<Correction>,
    /// As [`Reading::cost`].
    pub cost: f64,
    /// As [`Reading::strained`].
    pub strained: f64,
    rarities: Vec<f64>,
}

impl Tried {
    /// Those of a reading.
    pub fn of(reading: &Reading) -> Self {
        Self {
            corrections: reading.corrections.clone(),
            cost: reading.cost,
            strained: reading.strained(),
            rarities: reading.rarities.clone(),
        }
    }

    /// The reading that they lead to from the declared one.
    pub fn reading(&self, declared: &Reading) -> Reading {
        let corrections = self.corrections.iter().zip(&self.rarities);
        corrections.fold(declared.clone(), |reading, (correction, rarity)| {
            reading.with(*correction, *rarity)
        })
    }

    /// The correction that is made last.
    pub fn last(&self) -> Option<Correction> {
        self.corrections.last().copied()
    }

    /// Without the correction in this place.
    pub fn but(mut self, place: usize) -> Self {
        self.corrections.remove(place);
        self.rarities.remove(place);
        self
    }

    /// With the last correction in this place.
    pub fn with_last_at(&self, place: usize) -> Self {
        let mut moved = self.clone();
        moved.corrections[place..].rotate_right(1);
        moved.rarities[place..].rotate_right(1);
        moved
    }

    /// Whether both correct the same things, in one order or another.
    pub fn corrects_as(&self, other: &Self) -> bool {
        let are_in = |one: &[Correction], other: &[Correction]| {
            let is_in =
                |correction: &Correction| other.iter().any(|known| correction.is_like(known));
            one.iter().all(is_in)
        };
        let (one, other) = (&self.corrections, &other.corrections);
        one.len() == other.len() && are_in(one, other) && are_in(other, one)
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
    /// How unusual each of the corrections is, nats.
    rarities: Vec<f64>,
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
            rarities: Vec::new(),
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
                Correction::Unit(column, _, _, factor)
                | Correction::Taken(column, .., factor)
                | Correction::Factor(column, factor) => log.scale(column, factor),
                Correction::Counts(size) => log.scale(Column::Position, size),
                Correction::Duty(whole, volts) => {
                    log.scale(Column::Input, volts / whole / self.machine.gain.abs());
                }
                Correction::Geared(column, ratio) => log.scale(column, 1.0 / ratio),
                Correction::GearedSensor(ratio) => {
                    log.scale(Column::Position, 1.0 / ratio);
                    log.scale(Column::Velocity, 1.0 / ratio);
                }
                Correction::Negative(column) => log.scale(column, -1.0),
                Correction::Reversed => {
                    log.scale(Column::Position, -1.0);
                    log.scale(Column::Velocity, -1.0);
                }
                Correction::Swapped(one, other) => log.swap(one, other),
                Correction::Wrapped(turn) => log.unwrap_position(turn),
                Correction::Unsigned(Column::Input) => log.sign_input(machine.motor.as_ref()),
                Correction::Unsigned(_) => log.current = None,
                Correction::Number(..) => {}
            }
        }
        let balances = if let Correction::Number(name, _, value) = correction {
            set(&mut machine, name, value);
            self.balances.clone()
        } else {
            Balances::of(&logs, &machine)
        };
        let mut clues = clues(&machine, &logs, &balances);
        // A missing sign stands until it is seen or the column is out: an input of another size only hides it.
        if balances.drawn.is_none() && correction != Correction::Unsigned(Column::Current) {
            clues.extend(self.clues.iter().filter(|clue| is_of_sign(clue)));
        }
        let rarities = [&self.rarities[..], &[rarity]].concat();
        Self {
            cost: total(&clues) + rarities.iter().sum::<f64>(),
            rarities,
            corrections: [&self.corrections[..], &[correction]].concat(),
            machine,
            logs,
            balances,
            clues,
        }
    }

    /// Every reading that is one correction further.
    pub fn further(&self) -> Vec<Tried> {
        self.further_by(|_| true)
    }

    /// Those of them whose last correction is one of these.
    pub fn further_by(&self, is_kept: impl Fn(&Correction) -> bool) -> Vec<Tried> {
        let mut tried = Vec::new();
        let mut attempt = |correction: Correction, rarity: f64| {
            let is_late =
                correction.comes_first() && !self.corrections.iter().all(Correction::comes_first);
            let is_known = self
                .corrections
                .iter()
                .any(|known| known.is_like(&correction));
            if is_known || is_late || !is_kept(&correction) {
                return;
            }
            let reading = self.with(correction, rarity);
            // What is a machine's motion leaves less of its balance open than what is none.
            if !correction.changes_the_course()
                || reading.balances.unexplained() < self.balances.unexplained()
            {
                tried.push(Tried::of(&reading));
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

    /// Whether every log has this column.
    pub fn has(&self, column: Column) -> bool {
        self.logs.iter().all(|log| log.column(column).is_some())
    }

    fn of_units(&self) -> Vec<(Correction, f64)> {
        let rotary = self.machine.coordinate == Coordinate::Radian;
        let of = of_column;
        let angles_or_strokes: &[Unit] = if rotary {
            &units::ANGLES
        } else {
            &units::STROKES
        };
        let mut all = of(Column::Position, angles_or_strokes);
        all.extend(self.of_gear(angles_or_strokes));
        let period = self.logs[0].period;
        let is_credible = |(correction, _): &(Correction, f64)| match correction {
            Correction::Taken(.., factor) if *factor > 1.0 => period * factor <= LONGEST_PERIOD,
            _ => period >= SHORTEST_AS_MILLISECONDS,
        };
        all.extend(
            of(Column::Time, &units::TIMES)
                .into_iter()
                .filter(is_credible),
        );
        if self.machine.motor.is_some() {
            if !self.takes_a_share() {
                all.extend(of(Column::Input, &[units::MILLIVOLTS]));
            }
            if self.has(Column::Current) {
                all.extend(of(Column::Current, &[units::MILLIAMPERES]));
            }
            all.extend(self.of_duty());
            all.extend(self.of_gain());
        } else {
            all.extend(of(Column::Input, &[units::THOUSANDTHS]));
        }
        if self.has(Column::Velocity) {
            let velocities: &[Unit] = if rotary {
                &units::ANGULAR_VELOCITIES
            } else {
                &units::LINEAR_VELOCITIES
            };
            all.extend(of(Column::Velocity, velocities));
            let ratio = self.gear();
            all.extend(ratio.map(|ratio| (Correction::Geared(Column::Velocity, ratio), 2.0)));
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

    pub fn of_duty(&self) -> Vec<(Correction, f64)> {
        let inputs = || self.logs.iter().flat_map(|log| &log.input);
        let most = channels::largest_input(&self.logs);
        // A duty ends at one, a percentage at a hundred; what goes beyond in whole numbers is a counter's alone.
        let mut wholes: Vec<f64> = [1.0, 100.0]
            .into_iter()
            .filter(|whole| most <= 1.001 * whole)
            .collect();
        // Whole numbers up to a hundred may be counts of a PWM that stayed small as well as per cent. Up to one they are a
        // switch's.
        let may_be_counts = !wholes.contains(&1.0);
        if may_be_counts && inputs().all(|input| input.fract() == 0.0) {
            wholes.extend(units::full_scale(most));
        }
        let declared = self.takes_a_share().then(|| self.machine.gain.abs());
        // Who has declared the supply knows it.
        let others = if declared.is_some() { 3.0 } else { 1.0 };
        let supplies = units::SUPPLIES.map(|volts| (volts, others)).into_iter();
        let supplies = supplies.filter(|(volts, _)| Some(*volts) != declared);
        let supplies: Vec<(f64, f64)> = supplies.chain(declared.map(|it| (it, 0.0))).collect();
        let of_whole = |whole: f64| {
            let of_supply = move |&(volts, rarity)| (Correction::Duty(whole, volts), rarity);
            supplies.iter().map(of_supply)
        };
        wholes.into_iter().flat_map(of_whole).collect()
    }

    /// Whether the machine file takes the input for a share of a supply, whose voltage is its gain.
    fn takes_a_share(&self) -> bool {
        self.machine.gain.abs() > 1.0
    }

    /// Volts, where the machine file takes a unit of the input for the voltage of the supply.
    fn of_gain(&self) -> Option<(Correction, f64)> {
        let is_no_duty = self.takes_a_share() && channels::largest_input(&self.logs) > 1.001;
        let factor = self.machine.gain.abs().recip();
        is_no_duty.then_some((Correction::Factor(Column::Input, factor), 0.0))
    }

    /// Whether no likely supply gives as much voltage as this input is read to be.
    pub fn is_beyond_supplies(&self) -> bool {
        let volts = channels::largest_input(&self.logs) * self.machine.gain.abs();
        self.machine.motor.is_some() && volts > units::LARGEST_SUPPLY
    }

    /// A position of the other side of the gear, and a velocity with it where there is one: by its ratio, or by how many of the sensor's steps one of the
    /// position's is, where no unit is that.
    fn of_gear(&self, units: &[Unit]) -> Vec<(Correction, f64)> {
        if self.machine.coordinate != Coordinate::Radian {
            return Vec::new();
        }
        let gear = self.machine.gear_ratio.filter(|ratio| *ratio != 1.0);
        let gear = gear.into_iter().flat_map(|ratio| [ratio, ratio.recip()]);
        let mut ratios: Vec<f64> = gear.collect();
        let is_like = |one: f64, other: f64| (one / other).ln().abs() < SAME_FACTOR;
        if let (Some(step), Some(resolution)) =
            (channels::quantum(&self.logs), self.machine.resolution)
        {
            let ratio = rounded(step / resolution, 4);
            let is_other = ratio.ln().abs() > FITTED_FACTOR.ln();
            let known = units
                .iter()
                .map(|unit| unit.factor.recip())
                .chain(ratios.clone());
            let mut known = known.chain([resolution.recip()]);
            if is_other && !known.any(|known| is_like(known, ratio)) {
                ratios.push(ratio);
            }
        }
        let of_position = |ratio: &f64| Correction::Geared(Column::Position, *ratio);
        let mut all: Vec<Correction> = ratios.iter().map(of_position).collect();
        if self.has(Column::Velocity) {
            // A velocity is measured by the same sensor, most often.
            all.extend(ratios.iter().copied().map(Correction::GearedSensor));
        }
        all.into_iter()
            .map(|correction| (correction, 0.0))
            .collect()
    }

    /// What the log asks for of the numbers of the motor that are no guesses, over what is declared, each with how far that
    /// may be off, as factors.
    pub fn motor(&self) -> Vec<Stated> {
        let Some(motor) = &self.machine.motor else {
            return Vec::new();
        };
        let (balance, follows_constant) = match &self.balances.winding {
            Some(winding) => (winding, motor.torque_constant),
            None => {
                let drag = self.machine.mechanics.viscous * motor.resistance;
                let drag = drag / motor.torque_constant;
                // What else takes voltage with the speed is not known that well.
                if drag > motor.torque_constant {
                    return Vec::new();
                }
                (&self.balances.motion, motor.torque_constant + drag)
            }
        };
        let numbers = [
            ("torque_constant", Follows::Velocity, follows_constant),
            ("resistance", Follows::Current, motor.resistance),
        ];
        let numbers = numbers
            .into_iter()
            .filter(|(name, ..)| !is_guess(&self.machine, name));
        numbers
            .filter_map(|(name, follows, declared)| {
                let (low, high) = balance.share(follows)?.interval;
                let tolerance = self.machine.tolerances.get(name);
                Some(Stated {
                    name,
                    ratio: (low / declared, high / declared),
                    tolerance: tolerance.map_or(SHEET, |share| 1.0 + share),
                })
            })
            .collect()
    }

    /// The cost with how far the log is from numbers that are known well, those of the motor, the sensor's step and the
    /// voltages of supplies, nats: it chooses among readings that cost the same.
    pub fn strained(&self) -> f64 {
        let step = self.step().map(|ratio| ratio.ln() / SAME_STEP.ln());
        let stated = self.motor();
        let off = stated.iter().map(Stated::deviations).chain(step);
        let supply = if self.is_beyond_supplies() { HINT } else { 0.0 };
        self.cost
            + supply
            + off
                .map(|deviations| 0.5 * deviations * deviations)
                .sum::<f64>()
    }

    /// Whether the log agrees with them.
    pub fn agrees(&self) -> bool {
        let step = self
            .step()
            .is_none_or(|ratio| ratio.ln().abs() < SAME_STEP.ln());
        step && self.motor().iter().all(|stated| stated.off() == 1.0)
    }

    /// The sensor's step over the declared one.
    fn step(&self) -> Option<f64> {
        Some(channels::quantum(&self.logs)? / self.machine.resolution?)
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
        if is_negative && self.has(Column::Position) && self.has(Column::Velocity) {
            all.push((Correction::Reversed, 0.0));
        }
        if self.clues.iter().any(is_of_sign) {
            all.push((Correction::Unsigned(Column::Current), 0.0));
        }
        if channels::may_lack_sign(&self.logs) {
            all.push((Correction::Unsigned(Column::Input), 0.0));
        }
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
            // Who states a tolerance knows the number.
            let is_stated = self.machine.tolerances.contains_key(name);
            let rarity = if is_stated { HINT } else { 0.5 };
            for unit in units::of_number(name, rotary) {
                let correction = Correction::Number(name, unit.name, declared * unit.factor);
                all.push((correction, rarity + unit.rarity));
            }
            if name == "torque_constant" && rotary {
                let value = 60.0 / TAU / declared;
                all.push((Correction::Number(name, "rpm/V", value), 2.0));
            }
        }
        all
    }
}

/// A column in one of these units, or one that was taken for it, whether it is in another of them or as it has to be. Who writes
/// a unit that is neither the logger's nor that of the log errs less often.
fn of_column(column: Column, units: &[Unit]) -> Vec<(Correction, f64)> {
    let corrections = |unit: &Unit| {
        let others = units.iter().filter(|other| other.name != unit.name);
        let taken = |own: &Unit| {
            let factor = own.factor / unit.factor;
            let correction = Correction::Taken(column, Some(own.name), unit.name, factor);
            (correction, 1.0 + own.rarity + unit.rarity)
        };
        let of_log = [
            Correction::Unit(column, unit.name, unit.import, unit.factor),
            Correction::Taken(column, None, unit.name, 1.0 / unit.factor),
        ];
        let of_log = of_log.map(|correction| (correction, unit.rarity));
        of_log
            .into_iter()
            .chain(others.map(taken))
            .collect::<Vec<_>>()
    };
    units.iter().flat_map(corrections).collect()
}

fn is_of_sign(clue: &Clue) -> bool {
    matches!(clue.subject, Subject::Sign(_))
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
