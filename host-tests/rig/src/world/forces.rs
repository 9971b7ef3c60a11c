//! What acts on the masses and in the winding of a world.

use super::friction::At;
use super::laws::{Joint, Law};
use super::machine::{InputKind, Machine};
use super::plant::State;

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
    pub(super) machine: Machine,
    pub(super) laws: Vec<Law>,
    /// What is behind a joint, and the width of its gap.
    pub(super) joint: Option<(Joint, f64)>,
    /// Stiffness, damping and speed of a friction that bends.
    pub(super) bristles: Option<(f64, f64, f64)>,
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
    pub fn output(&self) -> usize {
        self.masses() - 1
    }

    /// Inertia of a mass, and how it grows with the position.
    pub fn inertia(&self, side: usize, position: f64) -> (f64, f64) {
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

    /// The motor's load at a current, A, or under an input, and the constant of its back-EMF.
    pub fn motor(&self, current: f64, input: f64) -> (f64, f64) {
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

    /// The stop that a mass is beyond, and the direction in which it lies.
    pub fn stop_passed(&self, side: usize, values: &Rates) -> Option<(f64, f64)> {
        let (lower, upper) = self.machine.stops.filter(|_| side == self.output())?;
        let position = values[2 * side];
        let slack = 1e-12 * (upper - lower);
        if position > upper + slack {
            Some((upper, 1.0))
        } else {
            (position < lower - slack).then_some((lower, -1.0))
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
}
