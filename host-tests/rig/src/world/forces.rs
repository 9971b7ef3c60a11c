//! What acts on the masses and in the winding of a world.

use super::laws::{Joint, Law};
use super::machine::{InputKind, Machine};
use super::plant::State;
use super::shapes::Along;

/// Values of a state, or their rates of change.
pub(super) type Rates = [f64; 9];

/// Position of the motor, rad or m; behind it its velocity.
pub(super) const MOTOR: usize = 0;
/// The same of what is behind a joint.
pub(super) const LOAD: usize = 2;
/// Current of the winding, A.
pub(super) const CURRENT: usize = 4;
/// Bend of the bristles, rad or m.
pub(super) const BRISTLE: usize = 5;
/// State of a hysteresis, −1 to 1.
pub(super) const HYSTERESIS: usize = 6;
/// Share by which the winding's resistance has risen.
pub(super) const WARMTH: usize = 7;
/// Share of the supply's voltage that is there.
pub(super) const BUS: usize = 8;

/// Loads and voltages of a machine with its laws.
#[derive(Debug, Clone)]
pub(super) struct Forces {
    machine: Machine,
    laws: Vec<Law>,
    joint: Option<(Joint, f64)>,
    bristles: Option<(f64, f64, f64)>,
}

impl Forces {
    pub fn new(machine: &Machine, laws: &[Law]) -> Self {
        let bristles = laws.iter().find_map(|law| match *law {
            Law::Presliding {
                stiffness,
                damping,
                speed,
            } => Some((stiffness, damping, speed)),
            _ => None,
        });
        Self {
            machine: machine.clone(),
            joint: laws.iter().find_map(Law::joint),
            laws: laws.to_vec(),
            bristles,
        }
    }

    /// One, or two with a joint between them.
    pub fn masses(&self) -> usize {
        1 + usize::from(self.joint.is_some())
    }

    /// Whether the friction of a mass yields before it slides.
    pub fn bends(&self, side: usize) -> bool {
        side == 0 && self.bristles.is_some()
    }

    /// The mass on which springs, gravity, loads and stops act.
    fn output(&self) -> usize {
        self.masses() - 1
    }

    /// Inertia of a mass, and how it grows with the position.
    fn inertia(&self, side: usize, position: f64) -> (f64, f64) {
        let share = match (self.joint, side) {
            (Some((joint, _)), 0) => 1.0 - joint.inertia,
            (Some((joint, _)), _) => joint.inertia,
            (None, _) => 1.0,
        };
        let inertia = share * self.machine.inertia;
        let mut sum = (inertia, 0.0);
        for law in &self.laws {
            if let Law::CrankInertia {
                share,
                period,
                phase,
            } = *law
            {
                let rate = std::f64::consts::TAU / period;
                let angle = rate * position + phase;
                sum.0 += inertia * share * angle.sin();
                sum.1 += inertia * share * rate * angle.cos();
            }
        }
        sum
    }

    /// Share of the machine's dry friction that acts on a mass.
    fn friction_share(&self, side: usize) -> f64 {
        match (self.joint, side) {
            (Some((joint, _)), 0) => 1.0 - joint.friction,
            (Some((joint, _)), _) => joint.friction,
            (None, _) => 1.0,
        }
    }

    /// The motor's load at a current, A, or under an input, and the constant of its back-EMF.
    fn motor(&self, current: f64, input: f64) -> (f64, f64) {
        let machine = &self.machine;
        let mut load = match machine.input {
            InputKind::Voltage => machine.torque_constant * current,
            InputKind::Torque | InputKind::Current => machine.gain * input,
        };
        let mut constant = machine.torque_constant;
        for law in &self.laws {
            match *law {
                Law::TorqueSaturation { law, level, emf } => {
                    let left = law.left(load / level);
                    load *= left;
                    if emf {
                        constant *= left;
                    }
                }
                Law::CurrentLimit { torque } if machine.input != InputKind::Voltage => {
                    load = load.clamp(-torque, torque);
                }
                _ => {}
            }
        }
        (load, constant)
    }

    /// Load of the joint on its far side.
    fn through_joint(&self, values: &Rates) -> f64 {
        let Some((joint, width)) = self.joint else {
            return 0.0;
        };
        let twist = values[MOTOR] - values[LOAD];
        let rate = values[MOTOR + 1] - values[LOAD + 1];
        if width == 0.0 {
            return joint.stiffness * twist + joint.damping * rate;
        }
        let depth = twist.abs() - 0.5 * width;
        if depth <= 0.0 {
            return 0.0;
        }
        // A contact pushes and never pulls; its damping grows in as it closes, so that the load does not jump.
        let grown = (depth / (0.02 * width)).min(1.0);
        let push = joint.stiffness * depth + joint.damping * grown * rate * twist.signum();
        push.max(0.0) * twist.signum()
    }

    /// What acts on a mass besides friction, without what the curvature of its inertia asks for.
    fn applied(&self, side: usize, values: &Rates, input: f64, time: f64) -> f64 {
        let machine = &self.machine;
        let joint = self.through_joint(values);
        let mut sum = if side == 0 {
            let (position, velocity) = (values[MOTOR], values[MOTOR + 1]);
            let mut sum = self.motor(values[CURRENT], input).0 - joint - machine.viscous * velocity;
            for law in &self.laws {
                sum += match *law {
                    Law::Cogging { amplitude, ripple } => amplitude * ripple.at(position),
                    Law::AsymmetricViscous { forward, backward } => {
                        -velocity * if velocity > 0.0 { forward } else { backward }
                    }
                    Law::FrictionDrift {
                        rate,
                        viscous: true,
                    } => -machine.viscous * velocity * rate * time,
                    Law::QuadraticDrag {
                        torque,
                        speed,
                        exponent,
                    } => -torque * (velocity.abs() / speed).powf(exponent) * velocity.signum(),
                    _ => 0.0,
                };
            }
            sum
        } else {
            joint
        };
        if side == self.output() {
            sum += self.outside(values, time);
        }
        sum
    }

    /// What acts on the output: springs, gravity, loads.
    fn outside(&self, values: &Rates, time: f64) -> f64 {
        let machine = &self.machine;
        let position = values[2 * self.output()];
        let mut sum = -machine.spring * (position - machine.spring_rest);
        if machine.gravity != 0.0 {
            sum -= machine.gravity * (position - machine.gravity_rest).sin();
        }
        for law in &self.laws {
            sum += match *law {
                Law::OffsetTorque { torque } => torque,
                Law::Spring { stiffness, rest } => -stiffness * (position - rest),
                Law::Gravity { torque, rest } => -torque * (position - rest).sin(),
                Law::ExternalLoad { torque, course } => torque * course.at(time),
                Law::Hysteresis { torque, .. } => -torque * values[HYSTERESIS],
                Law::CubicSpring {
                    torque,
                    reach,
                    rest,
                } => -torque * ((position - rest) / reach).powi(3),
                _ => 0.0,
            };
        }
        sum
    }

    /// Dry friction of the whole machine that opposes motion in a direction, at a speed. `resting` is what it
    /// begins with: the Coulomb level while sliding, the breakaway level at rest.
    fn dry(&self, resting: f64, direction: f64, side: usize, at: &At) -> f64 {
        let speed = at.values[2 * side + 1];
        let position = at.values[2 * side];
        let mut sum = resting;
        let mut factor = 1.0;
        for law in &self.laws {
            match *law {
                Law::Stribeck {
                    fall,
                    drop,
                    speed: scale,
                } => {
                    let level = self.machine.coulomb + drop * fall.left(speed / scale);
                    sum = sum.max(level);
                }
                Law::AsymmetricCoulomb { difference } => sum += difference * direction,
                Law::LoadDependentFriction { share, preload } => {
                    let load = self.motor(at.values[CURRENT], at.input).0;
                    sum += share * (load.hypot(preload) - preload);
                }
                Law::PositionDependentFriction { level, along } => match along {
                    Along::Added(ripple) => sum += level * ripple.at(position),
                    Along::Multiplied(ripple) => factor *= 1.0 + level * ripple.at(position),
                    Along::Slope { centre, reach } => sum += level * (position - centre) / reach,
                },
                Law::FrictionDrift { rate, .. } => factor *= (1.0 + rate * at.time).max(0.0),
                Law::RoughSpot {
                    torque,
                    centre,
                    width,
                } => sum += torque * bell((position - centre) / width),
                Law::SpeedBand {
                    torque,
                    centre,
                    width,
                } => sum += torque * bell((speed.abs() - centre) / width),
                Law::WarmUp { share, seconds } => {
                    factor *= 1.0 - share * (1.0 - (-at.time / seconds).exp());
                }
                _ => {}
            }
        }
        (factor * sum).max(0.0) * self.friction_share(side)
    }

    /// Friction of a mass in a direction while it slides.
    fn sliding(&self, side: usize, direction: f64, at: &At) -> f64 {
        self.dry(self.machine.coulomb, direction, side, at)
    }

    /// Load that a stuck mass holds in a direction.
    pub fn breakaway(&self, side: usize, state: &State, input: f64, direction: f64) -> f64 {
        let at = At {
            values: &state.values,
            input,
            time: state.time,
        };
        self.dry(self.machine.breakaway, direction, side, &at)
    }

    /// Load on a mass at rest, without friction.
    pub fn load_on(&self, side: usize, state: &State, input: f64) -> f64 {
        self.applied(side, &state.values, input, state.time)
    }

    /// Whether a mass lies on a stop and the load holds it there.
    pub fn presses_on_stop(&self, side: usize, values: &Rates, load: f64) -> bool {
        let position = values[2 * side];
        side == self.output()
            && self.machine.stops.is_some_and(|(lower, upper)| {
                (position >= upper && load > 0.0) || (position <= lower && load < 0.0)
            })
    }

    /// The stop that a mass is beyond.
    pub fn stop_passed(&self, side: usize, values: &Rates) -> Option<f64> {
        let (lower, upper) = self.machine.stops.filter(|_| side == self.output())?;
        let position = values[2 * side];
        let slack = 1e-12 * (upper - lower);
        if position > upper + slack {
            Some(upper)
        } else {
            (position < lower - slack).then_some(lower)
        }
    }

    /// Rates of change of all values.
    pub fn rates(&self, values: &Rates, directions: &[f64; 2], input: f64, time: f64) -> Rates {
        let mut rates = Rates::default();
        let at = At {
            values,
            input,
            time,
        };
        for side in 0..self.masses() {
            let place = 2 * side;
            if directions[side] == 0.0 {
                continue;
            }
            let velocity = values[place + 1];
            let mut load = self.applied(side, values, input, time);
            if self.bends(side) {
                let (friction, bending) = self.bristles(&at);
                load -= friction;
                rates[BRISTLE] = bending;
            } else {
                let direction = directions[side];
                load -= direction * self.sliding(side, direction, &at);
            }
            let (inertia, growth) = self.inertia(side, values[place]);
            rates[place] = velocity;
            rates[place + 1] = (load - 0.5 * growth * velocity * velocity) / inertia;
        }
        self.electric(&at, &mut rates);
        for law in &self.laws {
            if let Law::Hysteresis { reach, .. } = *law {
                let velocity = values[2 * self.output() + 1];
                rates[HYSTERESIS] = (velocity - velocity.abs() * values[HYSTERESIS]) / reach;
            }
        }
        rates
    }

    /// Force of the bristles, and how fast they bend.
    fn bristles(&self, at: &At) -> (f64, f64) {
        let Some((stiffness, damping, scale)) = self.bristles else {
            return (0.0, 0.0);
        };
        let velocity = at.values[MOTOR + 1];
        let bend = at.values[BRISTLE];
        let machine = &self.machine;
        let fall = (-(velocity / scale).powi(2)).exp();
        let level = machine.coulomb + (machine.breakaway - machine.coulomb) * fall;
        let level = self.dry(level, velocity.signum(), 0, at).max(1e-12);
        let bending = velocity - velocity.abs() * stiffness * bend / level;
        (stiffness * bend + damping * bending, bending)
    }

    /// The winding, what feeds it, and how warm it gets.
    fn electric(&self, at: &At, rates: &mut Rates) {
        let machine = &self.machine;
        if machine.input != InputKind::Voltage {
            return;
        }
        let current = at.values[CURRENT];
        let (_, constant) = self.motor(current, at.input);
        let emf = constant * at.values[MOTOR + 1];
        let mut resistance = machine.resistance;
        let mut voltage = at.input;
        let mut lost = 0.0;
        for law in &self.laws {
            match *law {
                Law::SupplySag {
                    resistance,
                    voltage: full,
                    lag,
                } => {
                    let duty = voltage / full;
                    let there = 1.0 - resistance * duty * current / full;
                    if lag > 0.0 {
                        rates[BUS] = (there - at.values[BUS]) / lag;
                        voltage *= at.values[BUS];
                    } else {
                        voltage *= there;
                    }
                }
                Law::BrushDrop { volts, knee } => lost += volts * (current / knee).tanh(),
                Law::DeadTime { volts, knee } => {
                    lost += volts.min(voltage.abs()) * (current / knee).tanh();
                }
                Law::ThermalDrift {
                    rate,
                    winding,
                    growing,
                } => {
                    let warmth = at.values[WARMTH];
                    resistance *= 1.0 + warmth;
                    let loss = if growing { 1.0 + warmth } else { 1.0 };
                    rates[WARMTH] = rate * current * current * loss - warmth / winding;
                }
                Law::CurrentLimit { torque } => {
                    let most = resistance * torque / machine.torque_constant;
                    voltage = voltage.clamp(emf - most, emf + most);
                }
                _ => {}
            }
        }
        rates[CURRENT] = (voltage - lost - resistance * current - emf) / machine.inductance;
    }

    /// Kinetic energy, and that of springs, joint and magnetic field, J.
    pub fn energy(&self, values: &Rates) -> f64 {
        let machine = &self.machine;
        let mut sum = 0.5 * machine.inductance * values[CURRENT].powi(2);
        for side in 0..self.masses() {
            let (inertia, _) = self.inertia(side, values[2 * side]);
            sum += 0.5 * inertia * values[2 * side + 1].powi(2);
        }
        let position = values[2 * self.output()];
        sum += 0.5 * machine.spring * (position - machine.spring_rest).powi(2);
        sum -= machine.gravity * (position - machine.gravity_rest).cos();
        if let Some((joint, width)) = self.joint {
            let twist = (values[MOTOR] - values[LOAD]).abs();
            sum += 0.5 * joint.stiffness * (twist - 0.5 * width).max(0.0).powi(2);
        }
        sum
    }

    /// Longest step that resolves everything that happens, s.
    pub fn longest_step(&self) -> f64 {
        let machine = &self.machine;
        let speed = 1.5 * machine.speed();
        let mut step = 0.05 * machine.inertia / machine.damping().max(1e-300);
        step = step.min(machine.cycle / 400.0);
        if machine.input == InputKind::Voltage {
            step = step.min(0.4 * machine.inductance / machine.resistance);
        }
        for law in &self.laws {
            step = step.min(match *law {
                Law::Cogging { ripple, .. }
                | Law::PositionDependentFriction {
                    along: Along::Added(ripple) | Along::Multiplied(ripple),
                    ..
                } => {
                    ripple.period
                        / (if ripple.harmonics == [0.0; 2] {
                            20.0
                        } else {
                            50.0
                        } * speed)
                }
                Law::RoughSpot { width, .. } => 0.1 * width / speed,
                Law::Hysteresis { reach, .. } => 0.1 * reach / speed,
                Law::Stribeck { speed, .. } => {
                    0.2 * speed * machine.inertia / (2.0 * machine.coulomb + 0.2 * machine.torque)
                }
                Law::BrushDrop { volts, knee } | Law::DeadTime { volts, knee } => {
                    0.5 * machine.inductance / (machine.resistance + volts / knee)
                }
                Law::SupplySag { lag, .. } if lag > 0.0 => 0.2 * lag,
                Law::Presliding {
                    stiffness, damping, ..
                } => {
                    let swing = 0.2 * (machine.inertia / stiffness).sqrt();
                    let slide = 0.5 * machine.coulomb / (stiffness * speed);
                    let damp = machine.inertia / damping.max(1e-300);
                    swing.min(slide).min(damp)
                }
                Law::Backlash { joint, .. } | Law::Compliance(joint) => {
                    let both = machine.inertia * joint.inertia * (1.0 - joint.inertia);
                    let swing = 0.25 * (both / joint.stiffness).sqrt();
                    swing.min(0.5 * both / joint.damping.max(1e-300))
                }
                _ => f64::INFINITY,
            });
        }
        step
    }
}

/// Where dry friction is asked for.
struct At<'a> {
    values: &'a Rates,
    input: f64,
    time: f64,
}

/// A bell of height 1.
fn bell(x: f64) -> f64 {
    (-0.5 * x * x).exp()
}
