//! The draw of a world: what kind it is, what is behind its log, and whether anybody would have kept it.

use super::control::{self, Drive};
use super::declaration::{declaration, guessed};
use super::dice::{between, chance, log_between, pick, seed_of};
use super::laws::Law;
use super::machine::{Declaration, InputKind, Machine};
use super::record::{Record, Scene, play};
use super::sensor::Quality;
use super::sins::Sins;
use super::{needs, strength};
use crate::random::Random;

/// What is behind a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One effect of the catalogue.
    OneEffect,
    /// Two of them.
    TwoEffects,
    /// A law that the catalogue has not.
    Outside,
    /// Nothing.
    None,
    /// Nothing but a poor logger.
    NoneWithSins,
    /// Nothing but a wrong number outside `[fit]`.
    Misdeclared,
}

impl Kind {
    /// All, in the order of the tables, each with its share of the worlds.
    pub const ALL: [(Self, f64); 6] = [
        (Self::OneEffect, 0.40),
        (Self::TwoEffects, 0.15),
        (Self::Outside, 0.15),
        (Self::None, 0.12),
        (Self::NoneWithSins, 0.10),
        (Self::Misdeclared, 0.08),
    ];

    /// Its name in answers.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneEffect => "one_effect",
            Self::TwoEffects => "two_effects",
            Self::Outside => "outside",
            Self::None => "none",
            Self::NoneWithSins => "none_with_sins",
            Self::Misdeclared => "misdeclared",
        }
    }

    fn draw(random: &mut Random) -> Self {
        let mut left = random.uniform();
        for (kind, share) in Self::ALL {
            left -= share;
            if left <= 0.0 {
                return kind;
            }
        }
        Self::OneEffect
    }
}

/// Rows a second that loggers are set to, Hz.
const RATES: [f64; 12] = [
    50.0, 100.0, 200.0, 250.0, 500.0, 1e3, 1e3, 2e3, 4e3, 5e3, 1e4, 2e4,
];

/// Shortest and longest log, s; beyond 10 kHz the rows end it earlier.
const SECONDS: [f64; 2] = [2.4, 120.0];

/// Fewest and most rows.
const ROWS: [f64; 2] = [2e3, 2.4e4];

/// Draws until a world is sane; the last one is kept whatever it is.
const MOST_ATTEMPTS: u64 = 24;

/// Least stroke of a sane log, of the machine's own.
const LEAST_STROKE: f64 = 0.35;

/// Largest stroke of a sane log, of the machine's own: it neither runs away nor swings.
const MOST_STROKE: f64 = 4.0;

/// Most of a sane log in which the drive gives all that it has, and in which nothing moves.
const MOST_SATURATED: f64 = 0.25;
const MOST_STUCK: f64 = 0.8;

/// One world: a machine with what it has beyond its file, two drives of it, its sensors and its logger.
#[derive(Debug, Clone, PartialEq)]
pub struct World {
    /// Seed of all worlds.
    pub seed: u64,
    /// Which of them.
    pub index: u64,
    /// What is behind its log.
    pub kind: Kind,
    /// The machine.
    pub machine: Machine,
    /// What it has beyond its file.
    pub laws: Vec<Law>,
    /// What its file says.
    pub declaration: Declaration,
    /// The drive of the log that is traced, and another one.
    pub drives: [Drive; 2],
    /// Its sensors.
    pub quality: Quality,
    /// Its logger.
    pub sins: Sins,
    /// Rows a second, Hz.
    pub rate: f64,
    /// Rows of the log.
    pub rows: usize,
    /// Draws that it took until it was sane, from 1.
    pub attempts: u64,
    /// Whether it is sane.
    pub sane: bool,
}

impl World {
    /// The world with this index, drawn until a person would have kept its logs.
    pub fn draw(seed: u64, index: u64) -> (Self, [Record; 2]) {
        // What there is does not depend on how often it is drawn: no effect is thinned out for being wild.
        let mut random = Random::new(seed_of(&[seed, index]));
        let kind = Kind::draw(&mut random);
        let effects = strength::kinds(&mut random, kind);
        let with_sins = match kind {
            Kind::NoneWithSins => true,
            Kind::OneEffect | Kind::TwoEffects => chance(&mut random, 0.5),
            _ => false,
        };
        let mut attempt = 1;
        loop {
            let mut random = Random::new(seed_of(&[seed, index, attempt]));
            let mut world = Self::attempt(&mut random, kind, &effects, with_sins, attempt);
            world.seed = seed;
            world.index = index;
            world.attempts = attempt;
            let records = [world.record(0), world.record(1)];
            world.sane = records.iter().all(|record| world.is_sane(record));
            if world.sane || attempt == MOST_ATTEMPTS {
                return (world, records);
            }
            attempt += 1;
        }
    }

    fn attempt(
        random: &mut Random,
        kind: Kind,
        effects: &[strength::Effect],
        with_sins: bool,
        attempt: u64,
    ) -> Self {
        let mut sins = if with_sins {
            Sins::draw(random)
        } else {
            Sins::NONE
        };
        let (rate, rows) = sampling(random);
        let period = 1.0 / (rate * sins.corrections as f64);
        let delays = needs::delays(random, effects, 1.0 / rate);
        let late: f64 = delays.iter().sum::<f64>() + sins.filter / rate;
        let mut machine = Machine::draw(random, rate, rows, control::fastest(period, late));
        needs::fit_machine(random, &mut machine, effects);
        if machine.input != InputKind::Voltage {
            sins.without_current();
        }
        let seconds = rows as f64 / rate;
        let laws: Vec<Law> = effects
            .iter()
            .zip(delays)
            .map(|(&effect, delay)| {
                let scene = strength::Scene {
                    machine: &machine,
                    seconds,
                    rate,
                    delay,
                    alone: effects.len() == 1,
                };
                strength::draw(random, effect, &scene)
            })
            .collect();
        // Later attempts are calmer: what was not stable may be.
        let calm = needs::calm(&laws, &machine) * (1.0 + 0.25 * ((attempt - 1) / 3) as f64);
        let timing = (period, late, seconds);
        let drives = [
            Drive::draw(random, &machine, timing, calm),
            Drive::draw(random, &machine, timing, calm),
        ];
        let quality = quality(random, &machine, &sins, rate);
        let declaration = declaration(random, kind, &machine, &laws);
        Self {
            seed: 0,
            index: 0,
            kind,
            machine,
            laws,
            declaration,
            drives,
            quality,
            sins,
            rate,
            rows,
            attempts: attempt,
            sane: false,
        }
    }

    /// The log of one of the two drives. The first is the logger's; the second, which nothing is fitted to,
    /// has the loop and the delays of the first, but no row out of its place.
    pub fn record(&self, drive: usize) -> Record {
        self.record_with(drive, &self.laws)
    }

    /// The same with other laws, everything else alike.
    pub fn record_with(&self, drive: usize, laws: &[Law]) -> Record {
        let sins = if drive == 0 {
            self.sins
        } else {
            self.sins.mended()
        };
        self.record_by(drive, laws, sins)
    }

    /// The traced log as it would be with every row in its place.
    pub fn mended_record(&self) -> Record {
        self.record_by(0, &self.laws, self.sins.mended())
    }

    fn record_by(&self, drive: usize, laws: &[Law], sins: Sins) -> Record {
        play(&Scene {
            machine: &self.machine,
            laws,
            drive: &self.drives[drive],
            quality: self.quality,
            sins,
            rate: self.rate,
            rows: self.rows,
            seed: seed_of(&[self.seed, self.index, self.attempts, drive as u64 + 1]),
        })
    }

    /// Whether somebody would have kept this log.
    fn is_sane(&self, record: &Record) -> bool {
        let stroke = record.stroke() / (2.0 * self.machine.amplitude);
        stroke.is_finite()
            && (LEAST_STROKE..MOST_STROKE).contains(&stroke)
            && record.saturated < MOST_SATURATED
            && record.stuck < MOST_STUCK
            && record.position.iter().all(|place| place.is_finite())
            && !swings(record)
    }

    /// The machine file.
    pub fn to_toml(&self) -> String {
        let name = format!("world-{}-{}", self.seed, self.index);
        self.machine.to_toml(&name, &self.declaration)
    }

    /// The same world whose machine file guesses otherwise what `[fit]` names: each number a third of to three times
    /// the truth. `turn`: which guess.
    pub fn guessed(&self, turn: u64) -> Self {
        let mut random = Random::new(seed_of(&[self.seed, self.index, u64::MAX, turn]));
        Self {
            declaration: guessed(&mut random, &self.machine, &self.declaration),
            ..self.clone()
        }
    }

    /// Whether the machine file's number of this name is not the machine's.
    pub fn misdeclares(&self, name: &str) -> bool {
        let factors = &self.declaration.factors;
        factors
            .iter()
            .any(|(known, factor)| *known == name && *factor != 1.0)
    }
}

/// Whether the input turns from end to end all the time, as that of a loop that is not stable.
fn swings(record: &Record) -> bool {
    let mean = record.input.iter().sum::<f64>() / record.input.len() as f64;
    let size = record
        .input
        .iter()
        .map(|input| (input - mean).powi(2))
        .sum::<f64>();
    let change = record
        .input
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).powi(2))
        .sum::<f64>();
    // White noise has 2; a loop whose every correction undoes the last one has 4.
    change > 1.6 * size
}

/// Rate in Hz and rows.
fn sampling(random: &mut Random) -> (f64, usize) {
    let rate = if chance(random, 0.8) {
        pick(random, &RATES)
    } else {
        log_between(random, 50.0, 2e4).round()
    };
    let rows = if chance(random, 0.8) {
        log_between(random, 3e3, 1.2e4)
    } else {
        log_between(random, ROWS[0], ROWS[1])
    };
    let least = (SECONDS[0] * rate).clamp(ROWS[0], ROWS[1]);
    let most = (SECONDS[1] * rate).clamp(ROWS[0], ROWS[1]);
    (rate, rows.clamp(least, most) as usize)
}

/// Sensors from good to poor.
fn quality(random: &mut Random, machine: &Machine, sins: &Sins, rate: f64) -> Quality {
    let full = if machine.input == InputKind::Voltage {
        machine.limit / machine.resistance
    } else {
        0.0
    };
    Quality {
        position_noise: if chance(random, 0.5) {
            0.0
        } else {
            between(random, 0.1, 1.0)
        },
        current_noise: (chance(random, 0.6) || sins.on_current())
            .then(|| full * log_between(random, 1e-3, 1e-2)),
        velocity_noise: chance(random, 0.12)
            .then(|| machine.speed() * log_between(random, 1e-3, 1e-2)),
        filter: sins.filter / rate,
    }
}
