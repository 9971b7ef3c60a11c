//! What is traced: machines, what they have beyond their machine file, how they move.

use std::f64::consts::TAU;
use std::path::Path;

use rig::{Effect, EffectKind, Experiment, Motor, Move, Noise, PidGains, Random, Sine, Trajectory};
use serde::{Serialize, Serializer};

use crate::failure::Failure;
use crate::log::Log;
use crate::machine::Machine;
use crate::outputs::write_own;

/// Length of a log, s.
const SECONDS: f64 = 12.0;

/// Rows a second.
const SAMPLE_RATE: f64 = 1000.0;

/// Strengths of a single effect, of the rig's nominal, about which each log's own is drawn.
pub const STRENGTHS: [f64; 2] = [1.0, 0.4];

/// Seeds of a case. Its motion, its noise and how far a wrong number is off follow from them; none of
/// them was used to choose a limit of the tracing.
const SEEDS: u64 = 3;

/// Rounds of logs without an effect, each on three machines and with and without wrong numbers.
const HEALTHY: u64 = 14;

/// The first seed, unless another one is asked for.
pub const FIRST_SEED: u64 = 770_000;

/// How many cases there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// For figures.
    Full,
    /// One seed each.
    Quick,
}

/// What is behind a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// One effect of the catalogue.
    Named,
    /// Two of them.
    Two,
    /// One that is not in the catalogue.
    Outside,
    /// None.
    Clean,
    /// None, but wrong numbers in the machine file.
    WrongNumbers,
}

/// How a machine is moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// Five sines at once.
    Sines,
    /// From place to place, at rest between.
    Moves,
    /// To and fro at constant speed.
    Triangle,
    /// A sine whose frequency rises.
    Sweep,
    /// The five sines, behind a position loop so soft that the machine sticks and slips.
    SoftLoop,
}

impl Motion {
    /// Those that the rates by effect leave out.
    pub const OTHERS: [Self; 4] = [Self::Moves, Self::Triangle, Self::Sweep, Self::SoftLoop];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sines => "five sines",
            Self::Moves => "moves and rests",
            Self::Triangle => "triangle",
            Self::Sweep => "sweep",
            Self::SoftLoop => "soft loop",
        }
    }
}

/// One log to be made and traced.
#[derive(Debug, Clone, Serialize)]
pub struct Case {
    /// What is behind it.
    pub group: Group,
    /// The machine that is recorded.
    #[serde(serialize_with = "name")]
    pub rig: rig::Machine,
    /// The machine that is declared; `None` where its numbers are right.
    #[serde(skip)]
    pub declared: Option<rig::Machine>,
    /// What it has beyond that.
    #[serde(serialize_with = "ids")]
    pub effects: Vec<Effect>,
    /// Their strength, of nominal.
    pub strength: f64,
    /// How the machine is moved.
    pub motion: Motion,
    /// Seed of motion and noise.
    pub seed: u64,
}

fn name<S: Serializer>(machine: &rig::Machine, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(machine.name)
}

fn ids<S: Serializer>(effects: &[Effect], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(effects.iter().map(|effect| label(effect.kind())))
}

/// An effect's name: the catalogue's where it has one.
pub fn label(kind: EffectKind) -> String {
    kind.id()
        .map_or_else(|| format!("({kind:?})"), str::to_owned)
}

/// Rotary with a voltage, a slide driven by force, a throttle with spring and stops.
pub fn machines() -> [rig::Machine; 3] {
    [
        rig::Machine::rotary_ema(),
        rig::Machine::throttle(),
        rig::Machine::force_slide(),
    ]
}

/// Every case from this seed on, in the order of the tables.
pub fn all(extent: Extent, first_seed: u64) -> Vec<Case> {
    let (seeds, healthy) = match extent {
        Extent::Full => (SEEDS, HEALTHY),
        Extent::Quick => (1, 2),
    };
    let mut cases = Vec::new();
    let mut push = |group, rig: &rig::Machine, effects: &[EffectKind], strength, motion| {
        let seed = first_seed + cases.len() as u64;
        let effects = effects
            .iter()
            .zip(0..)
            .map(|(&kind, place)| {
                let nominal = Effect::nominal(kind, rig).scaled(strength);
                drawn(nominal, rig, (seed, place))
            })
            .collect();
        cases.push(Case {
            group,
            rig: rig.clone(),
            declared: (group == Group::WrongNumbers).then(|| misdeclared(rig, seed)),
            effects,
            strength,
            motion,
            seed,
        });
    };
    let sines = Motion::Sines;
    for rig in &machines() {
        let possible = |kind: &EffectKind| kind.can_act_on(rig);
        for kind in EffectKind::ALL.into_iter().filter(possible) {
            let named = kind
                .id()
                .is_some_and(|id| model_core::effect::Id::from_id(id).is_some());
            for _ in 0..seeds {
                if named {
                    for strength in STRENGTHS {
                        push(Group::Named, rig, &[kind], strength, sines);
                    }
                } else {
                    push(Group::Outside, rig, &[kind], 1.0, sines);
                }
            }
        }
        for pair in PAIRS {
            for _ in 0..seeds {
                push(Group::Two, rig, &pair, 1.0, sines);
            }
        }
        for _ in 0..healthy {
            push(Group::Clean, rig, &[], 1.0, sines);
            push(Group::WrongNumbers, rig, &[], 1.0, sines);
        }
    }
    for motion in Motion::OTHERS {
        for rig in &machines() {
            let possible = |kind: &EffectKind| kind.can_act_on(rig) && kind.id().is_some();
            for kind in EffectKind::ALL.into_iter().filter(possible) {
                push(Group::Named, rig, &[kind], 1.0, motion);
            }
            for _ in 0..2 * seeds {
                push(Group::Clean, rig, &[], 1.0, motion);
            }
        }
    }
    cases
}

/// Effects that come together: friction and geometry, supply and friction, two of friction.
const PAIRS: [[EffectKind; 2]; 4] = [
    [EffectKind::AsymmetricCoulomb, EffectKind::Cogging],
    [EffectKind::InputDelay, EffectKind::QuadraticDrag],
    [EffectKind::Stribeck, EffectKind::Spring],
    [EffectKind::AsymmetricViscous, EffectKind::Cogging],
];

/// The effect up to 15 % stronger or weaker, somewhere else on the stroke and at another time: nobody has
/// looked at it. `place`: among the effects of its log, each of which is drawn for itself.
fn drawn(effect: Effect, rig: &rig::Machine, (seed, place): (u64, u64)) -> Effect {
    let mut random = Random::new(seed ^ 0xD4A3 ^ (place << 32));
    let mut between = |lower: f64, upper: f64| lower + (upper - lower) * random.uniform();
    let mut effect = effect.scaled(between(0.85, 1.15));
    match &mut effect {
        Effect::Cogging { period, phase, .. }
        | Effect::PositionDependentFriction { period, phase, .. } => {
            *period *= between(0.8, 1.25);
            *phase = between(0.0, TAU);
        }
        Effect::EncoderEccentricity { phase, .. } => *phase = between(0.0, TAU),
        Effect::ExternalLoad {
            begin, duration, ..
        } => {
            *begin = between(2.0, 6.0);
            *duration = between(1.5, 4.0);
        }
        Effect::SpeedBand { centre, .. } => *centre *= between(0.75, 1.25),
        Effect::RoughSpot { centre, .. } => {
            *centre = rig.centre() + rig.amplitude() * between(-0.4, 0.4);
        }
        _ => {}
    }
    effect
}

/// The machine with numbers that are off by up to a quarter.
fn misdeclared(rig: &rig::Machine, seed: u64) -> rig::Machine {
    let mut random = Random::new(seed ^ 0x5EED);
    let mut off = || {
        1.0 + (if random.uniform() < 0.5 { -1.0 } else { 1.0 }) * (0.08 + 0.17 * random.uniform())
    };
    let mut declared = rig.clone();
    declared.inertia *= off();
    declared.viscous *= off();
    let friction = off();
    declared.coulomb *= friction;
    declared.static_friction *= friction;
    if let Motor::Winding {
        resistance,
        torque_constant,
        ..
    } = &mut declared.motor
    {
        *resistance *= off();
        *torque_constant *= off();
    }
    declared
}

/// A number of a machine, by its name in the machine file.
fn number(machine: &rig::Machine, name: &str) -> Option<f64> {
    match (name, machine.motor) {
        ("inertia", _) => Some(machine.inertia),
        ("viscous", _) => Some(machine.viscous),
        ("coulomb", _) => Some(machine.coulomb),
        ("static", _) => Some(machine.static_friction),
        ("resistance", Motor::Winding { resistance, .. }) => Some(resistance),
        (
            "torque_constant",
            Motor::Winding {
                torque_constant, ..
            },
        ) => Some(torque_constant),
        _ => None,
    }
}

impl Case {
    /// Whether the machine file's number of this name is not the rig's.
    pub fn misdeclares(&self, name: &str) -> bool {
        let declared = self.declared.as_ref().unwrap_or(&self.rig);
        number(declared, name) != number(&self.rig, name)
    }

    /// Whether the machine file lets wrong numbers of a motor be fitted: of every second one, and such cases
    /// come two seeds apart.
    fn fits_motor(&self) -> bool {
        self.declared.is_some()
            && matches!(self.rig.motor, Motor::Winding { .. })
            && (self.seed / 2).is_multiple_of(2)
    }

    /// Writes the machine file, unless it is there, and reads it as a user's.
    ///
    /// # Errors
    /// What the file system reports; a file that is refused.
    pub fn machine_file(&self, directory: &Path) -> Result<Machine, Failure> {
        let declared = self.declared.as_ref().unwrap_or(&self.rig);
        let seed = self
            .declared
            .as_ref()
            .map_or(String::new(), |_| format!("-{}", self.seed));
        let path = directory.join(format!("{}{seed}.toml", declared.name));
        let mut text = declared.to_toml();
        if self.fits_motor() {
            let listed = "parameters = [\"resistance\", \"torque_constant\", ";
            text = text.replace("parameters = [", listed);
        }
        write_own(&path, text)?;
        Ok(Machine::read(&path)?)
    }

    /// Records the log.
    pub fn log(&self) -> Log {
        self.log_lasting(SECONDS)
    }

    /// Records a log of another length, s.
    pub fn log_lasting(&self, seconds: f64) -> Log {
        let recording = Experiment {
            sample_rate: SAMPLE_RATE,
            ..Experiment::tracking(self.bench(), self.trajectory(seconds))
        }
        .with_effects(&self.effects)
        .with_noise(self.noise())
        .lasting(seconds)
        .seeded(self.seed)
        .run();
        let there = |column: Vec<f64>| (!column.is_empty()).then_some(column);
        Log {
            path: format!("{} {}", self.rig.name, self.seed).into(),
            start_s: recording.time[0],
            period_s: 1.0 / SAMPLE_RATE,
            input: recording.input,
            position: recording.position,
            command: there(recording.command),
            current: there(recording.current),
            ..Log::default()
        }
    }

    /// The machine with the position loop that it is recorded in.
    fn bench(&self) -> rig::Machine {
        let mut bench = self.rig.clone();
        if self.motion == Motion::SoftLoop {
            bench.gains = soft_loop(&self.rig, self.seed);
        }
        bench
    }

    fn trajectory(&self, seconds: f64) -> Trajectory {
        match self.motion {
            Motion::Sines | Motion::SoftLoop => sines(&self.rig, self.seed),
            Motion::Moves => moves(&self.rig, self.seed),
            Motion::Triangle => triangle(&self.rig, self.seed),
            Motion::Sweep => sweep(&self.rig, self.seed, seconds),
        }
    }

    /// Sensors from good to poor: up to a count of noise before the encoder, 10 to 40 mA.
    fn noise(&self) -> Noise {
        let mut random = Random::new(self.seed ^ 0x0153);
        Noise {
            position: random.uniform() * self.rig.resolution,
            current: 0.01 + 0.03 * random.uniform(),
        }
    }
}

/// Five sines of random frequency and phase, from a fifth of the corner at which the whole stroke takes
/// the whole speed to three times it, within the machine's stroke and speed.
fn sines(rig: &rig::Machine, seed: u64) -> Trajectory {
    let mut random = Random::new(seed);
    let corner = rig.speed / (TAU * rig.amplitude());
    let mut components: Vec<Sine> = (0..5)
        .map(|index| {
            let ratio = 0.2 * 15.0_f64.powf((f64::from(index) + random.uniform()) / 5.0);
            Sine {
                amplitude: (0.4 + 0.6 * random.uniform()) / ratio.max(0.5),
                frequency: ratio * corner,
                phase: TAU * random.uniform(),
            }
        })
        .collect();
    let stroke: f64 = components.iter().map(|sine| sine.amplitude).sum();
    let speed: f64 = components
        .iter()
        .map(|sine| TAU * sine.frequency * sine.amplitude)
        .sum();
    let share = (rig.amplitude() / stroke).min(rig.speed / speed);
    for sine in &mut components {
        sine.amplitude *= share;
    }
    Trajectory::Sines {
        centre: rig.centre(),
        components,
    }
}

/// More moves than a log is long, anywhere in the stroke and at a tenth to the whole of the speed.
fn moves(rig: &rig::Machine, seed: u64) -> Trajectory {
    let mut random = Random::new(seed);
    let moves = (0..40).map(|_| Move {
        target: rig.centre() + rig.amplitude() * (2.0 * random.uniform() - 1.0),
        speed: rig.speed * 10.0_f64.powf(-random.uniform()),
        acceleration: rig.speed * (2.0 + 18.0 * random.uniform()),
        dwell: 0.3 * random.uniform(),
    });
    Trajectory::Moves {
        start: rig.centre(),
        moves: moves.collect(),
    }
}

/// Half to the whole of the stroke, at a tenth to the whole of the speed.
fn triangle(rig: &rig::Machine, seed: u64) -> Trajectory {
    let mut random = Random::new(seed);
    let amplitude = rig.amplitude() * (0.5 + 0.5 * random.uniform());
    let speed = rig.speed * 10.0_f64.powf(-random.uniform());
    Trajectory::Triangle {
        centre: rig.centre(),
        amplitude,
        period: 4.0 * amplitude / speed,
    }
}

/// From a tenth to a fifth of the corner up to two to six times it.
fn sweep(rig: &rig::Machine, seed: u64, seconds: f64) -> Trajectory {
    let mut random = Random::new(seed);
    let corner = rig.speed / (TAU * rig.amplitude());
    Trajectory::Sweep {
        centre: rig.centre(),
        amplitude: rig.amplitude(),
        from: corner * (0.1 + 0.1 * random.uniform()),
        to: corner * (2.0 + 4.0 * random.uniform()),
        seconds,
        speed: rig.speed,
    }
}

/// A loop without an integral that breaks the machine away at a tenth to two fifths of half the stroke.
fn soft_loop(rig: &rig::Machine, seed: u64) -> PidGains {
    let mut random = Random::new(seed ^ 0x50F7);
    let torque_per_input = match rig.motor {
        Motor::Winding {
            resistance,
            torque_constant,
            ..
        } => torque_constant / resistance,
        Motor::Direct { gain } => gain,
    };
    let breakaway = rig.static_friction / torque_per_input;
    let error = 0.1 * 4.0_f64.powf(random.uniform()) * rig.amplitude();
    PidGains {
        proportional: breakaway / error,
        integral: 0.0,
        ..rig.gains
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_motion_uses_the_machine_but_no_more() {
        for rig in machines() {
            for seed in 0..50 {
                let motion = sines(&rig, seed);
                let dt = 1e-3;
                let at = |motion: &Trajectory| -> Vec<f64> {
                    (0..12_000).map(|k| motion.at(f64::from(k) * dt)).collect()
                };
                let values = at(&motion);
                let others = [
                    moves(&rig, seed),
                    triangle(&rig, seed),
                    sweep(&rig, seed, 12.0),
                ];
                for values in others.iter().map(at).chain([values.clone()]) {
                    assert!(
                        values
                            .iter()
                            .all(|&x| x >= rig.stroke.0 && x <= rig.stroke.1)
                    );
                }
                let top = values
                    .windows(2)
                    .map(|w| ((w[1] - w[0]) / dt).abs())
                    .fold(0.0, f64::max);
                assert!(
                    top <= 1.001 * rig.speed && top > 0.3 * rig.speed,
                    "{top} {}",
                    rig.speed
                );
            }
        }
    }

    #[test]
    fn every_second_wrong_motor_may_be_fitted() {
        for first in [FIRST_SEED, FIRST_SEED + 1] {
            let motors = all(Extent::Full, first).into_iter().filter(|case| {
                case.group == Group::WrongNumbers && matches!(case.rig.motor, Motor::Winding { .. })
            });
            let fitted: Vec<bool> = motors.map(|case| case.fits_motor()).collect();
            let half = fitted.iter().filter(|fitted| **fitted).count();
            assert_eq!(2 * half, fitted.len());
        }
    }

    #[test]
    fn every_seed_is_used_once() {
        let cases = all(Extent::Full, FIRST_SEED);
        let mut seeds: Vec<u64> = cases.iter().map(|case| case.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), cases.len());
        let clean = cases
            .iter()
            .filter(|case| case.group == Group::Clean && case.motion == Motion::Sines)
            .count();
        assert!(clean >= 40, "{clean}");
    }
}
