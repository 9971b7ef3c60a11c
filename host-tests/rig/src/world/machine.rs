//! The machine of a world: what it is, and what its file declares.

use std::f64::consts::TAU;
use std::fmt::Write;

use super::dice::{between, chance, log_between, pick, sign};
use crate::random::Random;

/// Whether machine files say on which side of backlash and elastic parts the sensor sits
/// (`[sensor] side`). The machine file's reader does not know the key yet; switch this on once it does.
const DECLARES_SENSOR_SIDE: bool = false;

/// Mechanical power of the smallest and of the largest motor, torque at standstill times top speed, W.
const SMALLEST_POWER: f64 = 0.02;
const LARGEST_POWER: f64 = 3e3;

/// Most power that a motor takes at standstill, W.
const LARGEST_STALL_POWER: f64 = 2e4;

/// Most current that it takes then, A.
const LARGEST_CURRENT: f64 = 100.0;

/// Voltages of supplies, V.
const SUPPLIES: [f64; 6] = [5.0, 12.0, 24.0, 48.0, 110.0, 310.0];

/// What the drive is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputKind {
    /// A voltage on a brushed DC winding, V.
    Voltage,
    /// A torque or force, N·m or N.
    Torque,
    /// A current, A; the drive's own loop makes it flow at once.
    Current,
}

/// Where the position sensor sits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Before backlash and elastic parts.
    Motor,
    /// Behind them.
    Load,
}

/// One actuator. SI units; loads in N·m for a rotary machine, N for a linear one, all values referred to
/// the coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Whether the coordinate is a displacement, m, instead of an angle, rad.
    pub linear: bool,
    /// What the drive is told.
    pub input: InputKind,
    /// Load for one unit of input; 1 with a voltage.
    pub gain: f64,
    /// Largest magnitude of the input.
    pub limit: f64,
    /// R, Ω; 0 without a voltage input.
    pub resistance: f64,
    /// L, H; 0 without a voltage input.
    pub inductance: f64,
    /// k, N·m/A and V·s/rad; 0 without a voltage input.
    pub torque_constant: f64,
    /// J, kg·m² or kg.
    pub inertia: f64,
    /// b, N·m·s/rad or N·s/m.
    pub viscous: f64,
    /// Friction while sliding.
    pub coulomb: f64,
    /// Friction at breakaway, not below `coulomb`.
    pub breakaway: f64,
    /// Stiffness of a return spring, N·m/rad or N/m; 0 for none.
    pub spring: f64,
    /// Where it rests, rad or m.
    pub spring_rest: f64,
    /// Torque of an unbalanced load at a right angle to hanging, N·m; 0 for none.
    pub gravity: f64,
    /// Where it hangs, rad.
    pub gravity_rest: f64,
    /// End stops, lower and upper, rad or m.
    pub stops: Option<(f64, f64)>,
    /// Turns of the motor for one of the coordinate; 1 for a direct drive.
    pub gear: f64,
    /// One count of the sensor, rad or m.
    pub resolution: f64,
    /// Middle of the motion, rad or m.
    pub centre: f64,
    /// Half the stroke of the motion, rad or m.
    pub amplitude: f64,
    /// Time that a motion takes to come back to where it was, s.
    pub cycle: f64,
    /// Load that the motor has at standstill.
    pub torque: f64,
}

/// What a machine file says of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Declaration {
    /// Names of `[fit]`.
    pub fit: Vec<&'static str>,
    /// Declared over true value of those numbers that are not declared as they are.
    pub factors: Vec<(&'static str, f64)>,
    /// Whether the file has the sensor's resolution.
    pub resolution: bool,
    /// Where the sensor sits, in a world in which that matters.
    pub side: Option<Side>,
}

impl Machine {
    /// Top speed of the motions, rad/s or m/s.
    pub fn speed(&self) -> f64 {
        TAU * self.amplitude / self.cycle
    }

    /// Load for one unit of the input at standstill.
    pub fn load_per_input(&self) -> f64 {
        match self.input {
            InputKind::Voltage => self.torque_constant / self.resistance,
            InputKind::Torque | InputKind::Current => self.gain,
        }
    }

    /// What resists a motion in proportion to its speed: viscous friction and back-EMF, N·m·s/rad.
    pub fn damping(&self) -> f64 {
        match self.input {
            InputKind::Voltage => self.viscous + self.torque_constant.powi(2) / self.resistance,
            InputKind::Torque | InputKind::Current => self.viscous,
        }
    }

    /// One of its numbers by the name in the machine file; `None` for one that it has not.
    pub fn number(&self, name: &str) -> Option<f64> {
        let winding = self.input == InputKind::Voltage;
        match name {
            "resistance" if winding => Some(self.resistance),
            "inductance" if winding => Some(self.inductance),
            "torque_constant" if winding => Some(self.torque_constant),
            "inertia" => Some(self.inertia),
            "viscous" => Some(self.viscous),
            "coulomb" => Some(self.coulomb),
            "static" => Some(self.breakaway),
            "spring" => Some(self.spring),
            "spring_rest" => Some(self.spring_rest),
            "gravity_torque" if !self.linear => Some(self.gravity),
            "gravity_rest" if !self.linear => Some(self.gravity_rest),
            _ => None,
        }
    }

    /// A machine for logs of `rows` rows at `rate` Hz, whose loop can be as fast as `loop_rate` rad/s.
    pub(super) fn draw(random: &mut Random, rate: f64, rows: usize, loop_rate: f64) -> Self {
        let seconds = rows as f64 / rate;
        let linear = chance(random, 0.2);
        let input = pick(
            random,
            &[
                InputKind::Voltage,
                InputKind::Voltage,
                InputKind::Voltage,
                InputKind::Torque,
                InputKind::Current,
            ],
        );
        let amplitude = if linear {
            log_between(random, 1e-3, 0.5)
        } else {
            log_between(random, 0.5, 60.0)
        };
        let shortest = (40.0 / rate).max(14.0 / loop_rate).max(0.05);
        let longest = (0.35 * seconds).min(8.0);
        let cycle = log_between(random, shortest.min(0.8 * longest), longest);
        let inertia = if linear {
            log_between(random, 0.05, 500.0)
        } else {
            log_between(random, 1e-6, 1e-2)
        };
        let mut machine = Self {
            linear,
            input,
            gain: 1.0,
            limit: 1.0,
            resistance: 0.0,
            inductance: 0.0,
            torque_constant: 0.0,
            inertia,
            viscous: 0.0,
            coulomb: 0.0,
            breakaway: 0.0,
            spring: 0.0,
            spring_rest: 0.0,
            gravity: 0.0,
            gravity_rest: 0.0,
            stops: None,
            gear: if chance(random, 0.5) {
                1.0
            } else {
                between(random, 2.0, 120.0).round()
            },
            resolution: 0.0,
            centre: 0.0,
            amplitude,
            cycle,
            torque: 0.0,
        };
        machine.place(random);
        machine.load(random);
        machine.drive(random, seconds);
        machine.sense(random);
        machine
    }

    /// Where it moves, and between which stops.
    fn place(&mut self, random: &mut Random) {
        if chance(random, 0.5) {
            self.centre = self.amplitude * between(random, -1.5, 1.5);
        }
        if chance(random, 0.3) {
            let reach = self.amplitude * between(random, 1.15, 1.6);
            self.stops = Some((self.centre - reach, self.centre + reach));
        }
    }

    /// Its loads, and a motor that carries them with something to spare.
    fn load(&mut self, random: &mut Random) {
        let friction = log_between(random, 0.01, 0.8);
        // Share of the supply that the top speed takes as back-EMF.
        let emf = if self.input == InputKind::Voltage {
            between(random, 0.03, (0.85 - friction).max(0.05))
        } else {
            0.0
        };
        let spare = 0.95 * (1.0 - emf) - friction;
        let share = |random: &mut Random, probability: f64| {
            if chance(random, probability) {
                spare * between(random, 0.05, 0.35)
            } else {
                0.0
            }
        };
        let spring = share(random, 0.25);
        let gravity = if self.linear { 0.0 } else { share(random, 0.2) };
        let viscous = spare * log_between(random, 0.01, 0.25);
        let rest = (spare - spring - gravity - viscous).max(0.05 * spare);
        let dynamic = 1.5 * self.inertia * self.amplitude * (TAU / self.cycle).powi(2);
        self.torque = dynamic * log_between(random, 1.2, 12.0) / rest;
        self.keep_power_within(random, emf);
        self.viscous = viscous * self.torque / self.speed();
        self.coulomb = friction * self.torque;
        self.breakaway = self.coulomb * between(random, 1.0, 1.35);
        self.spring = spring * self.torque / (1.5 * self.amplitude);
        if self.spring > 0.0 {
            self.spring_rest = self.centre + self.amplitude * between(random, -0.5, 0.5);
        }
        self.gravity = gravity * self.torque;
        if self.gravity > 0.0 {
            self.gravity_rest = between(random, -3.0, 3.0);
        }
        if self.input == InputKind::Voltage {
            // Kept for `drive`, which knows the supply.
            self.torque_constant = emf / self.speed();
        }
    }

    /// Makes a machine lighter or heavier whose motor nobody would build.
    fn keep_power_within(&mut self, random: &mut Random, emf: f64) {
        let power = self.torque * self.speed();
        let most = if emf > 0.0 {
            LARGEST_POWER.min(emf * LARGEST_STALL_POWER)
        } else {
            LARGEST_POWER
        };
        let wanted = if power > most {
            most * log_between(random, 0.1, 1.0)
        } else if power < SMALLEST_POWER {
            SMALLEST_POWER * log_between(random, 1.0, 10.0)
        } else {
            power
        };
        self.inertia *= wanted / power;
        self.torque *= wanted / power;
    }

    /// Its motor or its drive.
    fn drive(&mut self, random: &mut Random, seconds: f64) {
        match self.input {
            InputKind::Voltage => {
                // At standstill the supply drives a power of T ω / (its share of back-EMF).
                let supply = supply(random, self.torque / self.torque_constant);
                self.limit = supply;
                self.torque_constant *= supply;
                self.resistance = self.torque_constant * supply / self.torque;
                // Not below what the plant resolves over a long log.
                let shortest = (3.0 * super::plant::finest_step(seconds)).max(8e-5);
                let longest = (self.cycle / 25.0).clamp(1.5 * shortest, 8e-3);
                self.inductance = self.resistance * log_between(random, shortest, longest);
            }
            InputKind::Torque => {
                self.gain = if chance(random, 0.5) {
                    1.0
                } else {
                    self.torque / 10.0 * sign(random)
                };
                self.limit = self.torque / self.gain.abs();
            }
            InputKind::Current => {
                self.limit = log_between(random, 0.5, 40.0);
                self.gain = self.torque / self.limit;
            }
        }
    }

    /// Its position sensor: an 8-bit potentiometer at worst, 20 bits a turn at best.
    fn sense(&mut self, random: &mut Random) {
        let stroke = 3.0 * self.amplitude;
        self.resolution = match (random.uniform(), self.linear) {
            (share, _) if share < 0.1 => stroke / 256.0,
            (share, _) if share < 0.3 => {
                stroke / f64::from(1 << (10 + (6.0 * random.uniform()) as i32))
            }
            (_, true) => stroke / log_between(random, 2e3, 1e6).round(),
            (_, false) => {
                let counts = f64::from(1 << (10 + (11.0 * random.uniform()) as i32));
                let behind = if chance(random, 0.5) { self.gear } else { 1.0 };
                TAU / (counts * behind)
            }
        }
        // A motion passes two hundred counts at least.
        .min(2.0 * self.amplitude / 200.0);
    }

    /// The machine file. What the world has beyond the machine never appears in it.
    pub fn to_toml(&self, name: &str, declaration: &Declaration) -> String {
        let mut text = format!(
            "name = {name:?}\ncoordinate = {:?}\n\n[input]\n",
            if self.linear { "m" } else { "rad" }
        );
        let value = |key: &str| {
            let factor = declaration.factors.iter().find(|(known, _)| *known == key);
            self.number(key).unwrap_or(0.0) * factor.map_or(1.0, |(_, factor)| *factor)
        };
        let mut line = |key: &str, value: f64| {
            writeln!(text, "{key} = {value:?}").expect("a String takes any text");
        };
        if self.input == InputKind::Voltage {
            line("kind = \"voltage\"\ngain", self.gain);
            line("\n[motor]\nresistance", value("resistance"));
            line("inductance", value("inductance"));
            line("torque_constant", value("torque_constant"));
        } else {
            line("kind = \"torque\"\ngain", self.gain);
        }
        line("\n[mechanics]\ninertia", value("inertia"));
        line("viscous", value("viscous"));
        if self.spring > 0.0 {
            line("spring", value("spring"));
            line("spring_rest", value("spring_rest"));
        }
        if self.gravity > 0.0 {
            line("gravity_torque", value("gravity_torque"));
            line("gravity_rest", value("gravity_rest"));
        }
        if let Some((lower, upper)) = self.stops {
            line("lower_stop", lower);
            line("upper_stop", upper);
        }
        line("\n[friction]\ncoulomb", value("coulomb"));
        line("static", value("static"));
        let side = declaration.side.and_then(sensor_side);
        if declaration.resolution || side.is_some() {
            text.push_str("\n[sensor]\n");
        }
        if declaration.resolution {
            writeln!(text, "resolution = {:?}", self.resolution).expect("a String takes any text");
        }
        text.push_str(&side.unwrap_or_default());
        writeln!(text, "\n[fit]\nparameters = {:?}", declaration.fit)
            .expect("a String takes any text");
        text
    }
}

/// A supply, V, from which a motor takes this power at standstill, W, with no more than its largest current.
pub(super) fn supply(random: &mut Random, power: f64) -> f64 {
    let wanted = pick(random, &SUPPLIES);
    let enough = |supply: &&f64| **supply >= wanted && power / **supply <= LARGEST_CURRENT;
    let largest = SUPPLIES[SUPPLIES.len() - 1];
    SUPPLIES.iter().find(enough).copied().unwrap_or(largest)
}

/// The line of `[sensor]` that says where the sensor sits; `None` while nobody reads it.
fn sensor_side(side: Side) -> Option<String> {
    let name = match side {
        Side::Motor => "motor",
        Side::Load => "load",
    };
    DECLARES_SENSOR_SIDE.then(|| format!("side = {name:?}\n"))
}
