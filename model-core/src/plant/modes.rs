//! The affine modes, discretised for an input held over the step.
//!
//! Sliding, x = (i, ω, q) with q the deflection from the spring's rest obeys
//!
//! ```text
//! L di/dt = g u − R i − k ω
//! J dω/dt = k i − B ω − K q + d
//!   dq/dt = ω
//! ```
//!
//! with d = offset ∓ Coulomb friction ∓ preload constant in the mode. The exact step is
//! x⁺ = Φ x + Γ (u, d) with Φ = exp(A h); it is kept as x⁺ − x, so that the slow changes that a
//! short step makes are not rounded against the state. A *ladder* holds it for h, h/2, … h/16: an
//! event inside the step is found by going down it.

use super::parameters::{Drive, ParameterError, Parameters};
use super::{Directional, LONGEST_PERIOD, Motion};
use crate::numeric::matrix_exponential::{Matrix, exponential, multiply};

/// Rungs of a ladder: the step halved up to four times.
pub const RUNGS: usize = 5;

/// Finest rungs in a whole step.
const SIXTEENTHS: f32 = 16.0;

/// Change of the state over one rung, by row: (current, velocity, position), of
/// (current, velocity, deflection, input, torque).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Increment {
    /// Change of current.
    pub current: [f32; 5],
    /// Change of velocity.
    pub velocity: [f32; 5],
    /// Change of position.
    pub position: [f32; 5],
}

impl Increment {
    /// Whether each coefficient is a number within the range of `f32`.
    fn is_finite(&self) -> bool {
        let rows = [self.current, self.velocity, self.position];
        rows.as_flattened().iter().all(|entry| entry.is_finite())
    }
}

impl Increment {
    /// By how much velocity and deflection span more area after a rung than before: 0 where energy
    /// is conserved, negative where it falls.
    fn growth(&self) -> f64 {
        let [[_, velocity, ahead, ..], [_, onwards, position, ..]] =
            [self.velocity, self.position].map(|row| row.map(f64::from));
        velocity + position + velocity * position - ahead * onwards
    }

    /// Where the damping over a rung (its time over the mechanical time constant) is below what
    /// rounding to `f32` does to it, takes those of the neighbouring coefficients that come closest to
    /// it without a gain: a spring and an inertia that are let alone would otherwise gain up to 1e-7 of
    /// their energy with each radian of their swing, or lose as much.
    fn conserve(&mut self, damping: f64) {
        let rounding = (self.growth() + damping).abs();
        if self.velocity[2] == 0.0 || rounding <= damping {
            return;
        }
        let rounded = *self;
        let mut best = f64::NEG_INFINITY;
        for choice in 0..81 {
            let mut candidate = rounded;
            let mut digits = choice;
            let [_, damping, back, ..] = &mut candidate.velocity;
            let [_, onwards, position, ..] = &mut candidate.position;
            for coefficient in [damping, back, onwards, position] {
                *coefficient = match digits % 3 {
                    0 => *coefficient,
                    1 => coefficient.next_up(),
                    _ => coefficient.next_down(),
                };
                digits /= 3;
            }
            let growth = candidate.growth();
            if growth <= 0.0 && growth > best {
                best = growth;
                *self = candidate;
            }
        }
    }
}

/// By how much a state is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Of the current, A.
    pub current: f32,
    /// Of the velocity, rad/s or m/s.
    pub velocity: f32,
    /// Of the position, rad or m.
    pub position: f32,
}

impl Deviation {
    /// That of a velocity alone.
    pub fn of_velocity(velocity: f32) -> Self {
        Self {
            current: 0.0,
            velocity,
            position: 0.0,
        }
    }
}

/// Change of the current over one rung at rest: of (current, input).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RestIncrement {
    /// Of the current.
    pub current: f32,
    /// Of the input.
    pub input: f32,
}

/// A sliding mode over a step, its half, quarter, eighth and sixteenth.
pub type Ladder = [Increment; RUNGS];

/// Rest over a step, its half, quarter, eighth and sixteenth.
pub type RestLadder = [RestIncrement; RUNGS];

/// What the modes are worked out from: actuators that agree in it have the same modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Basis {
    drive: Drive,
    gain: f32,
    inertia: f32,
    viscous: Directional,
    spring: f32,
    period: f32,
}

impl Basis {
    /// Of parameters within their ranges, for steps of `period` seconds.
    pub fn new(parameters: &Parameters, period: f32) -> Self {
        Self {
            drive: parameters.drive,
            gain: parameters.gain,
            inertia: parameters.inertia,
            viscous: parameters.viscous,
            spring: parameters.spring,
            period,
        }
    }

    /// Whether the period is one that a step may have.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        if self.period > 0.0 && self.period <= LONGEST_PERIOD {
            Ok(())
        } else {
            Err(ParameterError {
                parameter: "period",
                requirement: "above 0 and at most 10 s",
            })
        }
    }
}

/// All modes of an actuator for one step period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modes {
    /// Sliding towards larger positions.
    pub(super) forward: Ladder,
    /// Sliding towards smaller positions.
    pub(super) backward: Ladder,
    /// At rest.
    pub(super) rest: RestLadder,
}

impl Modes {
    /// Works them out.
    ///
    /// # Errors
    /// A period that is not above 0 and at most 10 s, or parameters so far apart that `f32` does
    /// not hold the step.
    pub fn build(basis: &Basis) -> Result<Self, ParameterError> {
        basis.check()?;
        let modes = Self::new(basis);
        modes.check()?;
        Ok(modes)
    }

    /// What becomes of a deviation over a step in which the motion does not change.
    #[inline]
    pub fn carry(&self, deviation: &mut Deviation, motion: Motion) {
        let ladder = match motion {
            Motion::Forward => &self.forward,
            Motion::Backward => &self.backward,
            Motion::Rest => {
                deviation.current += self.rest[0].current * deviation.current;
                deviation.velocity = 0.0;
                return;
            }
        };
        let before = *deviation;
        let change = |row: &[f32; 5]| {
            row[0] * before.current + row[1] * before.velocity + row[2] * before.position
        };
        deviation.current += change(&ladder[0].current);
        deviation.velocity += change(&ladder[0].velocity);
        deviation.position += change(&ladder[0].position);
    }

    /// Works them out for a usable period.
    pub(super) fn new(basis: &Basis) -> Self {
        let forward = sliding(basis, basis.viscous.forward);
        let backward = if basis.viscous.backward == basis.viscous.forward {
            forward
        } else {
            sliding(basis, basis.viscous.backward)
        };
        Self {
            forward,
            backward,
            rest: rest(basis),
        }
    }

    /// Whether `f32` holds the step.
    pub(super) fn check(&self) -> Result<(), ParameterError> {
        let in_range = |ladder: &Ladder| ladder.iter().all(Increment::is_finite);
        // The current follows the input at rest as it does while sliding.
        if !self.rest[0].input.is_finite() {
            return Err(ParameterError {
                parameter: "resistance",
                requirement: "larger beside the gain: the current overflows",
            });
        }
        if in_range(&self.forward) && in_range(&self.backward) {
            Ok(())
        } else {
            Err(ParameterError {
                parameter: "inertia",
                requirement: "larger beside the other parameters: a coefficient of the step overflows",
            })
        }
    }
}

/// What the electrical side comes to: with a torque input the "current" is the torque.
struct Electrics {
    gain: f64,
    torque_constant: f64,
    back_emf: f64,
    resistance: f64,
    inductance: f64,
}

impl Electrics {
    fn of(basis: &Basis) -> Self {
        let gain = f64::from(basis.gain);
        match basis.drive {
            Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            } => Self {
                gain,
                torque_constant: f64::from(torque_constant),
                back_emf: f64::from(torque_constant),
                resistance: f64::from(resistance),
                inductance: f64::from(inductance),
            },
            Drive::Torque => Self {
                gain,
                torque_constant: 1.0,
                back_emf: 0.0,
                resistance: 1.0,
                inductance: 0.0,
            },
        }
    }
}

/// Discretises sliding with the given viscous friction.
fn sliding(basis: &Basis, viscous: f32) -> Ladder {
    let electrics = Electrics::of(basis);
    let inertia = f64::from(basis.inertia);
    let damping = f64::from(viscous) / inertia;
    let stiffness = f64::from(basis.spring) / inertia;
    let torque = electrics.torque_constant / inertia;
    let algebraic = electrics.inductance == 0.0;

    let mut generator: Matrix<5> = [[0.0; 5]; 5];
    if algebraic {
        let conductance = 1.0 / electrics.resistance;
        generator[1][1] = -damping - torque * electrics.back_emf * conductance;
        generator[1][3] = torque * electrics.gain * conductance;
    } else {
        generator[0][0] = -electrics.resistance / electrics.inductance;
        generator[0][1] = -electrics.back_emf / electrics.inductance;
        generator[0][3] = electrics.gain / electrics.inductance;
        generator[1][0] = torque;
        generator[1][1] = -damping;
    }
    generator[1][2] = -stiffness;
    generator[1][4] = 1.0 / inertia;
    generator[2][1] = 1.0;

    let finest = f64::from(basis.period) / f64::from(SIXTEENTHS);
    let mut transition = exponential(&generator.map(|row| row.map(|entry| entry * finest)));
    let mut ladder = [Increment {
        current: [0.0; 5],
        velocity: [0.0; 5],
        position: [0.0; 5],
    }; RUNGS];
    for rung in (0..RUNGS).rev() {
        let change = |row: usize| {
            let mut entries = transition[row];
            entries[row] -= 1.0;
            entries.map(|entry| entry as f32)
        };
        ladder[rung] = Increment {
            current: if algebraic {
                // i⁺ = (g u − k ω⁺) / R, whatever the current was.
                let mut entries =
                    transition[1].map(|entry| -electrics.back_emf / electrics.resistance * entry);
                entries[0] = -1.0;
                entries[3] += electrics.gain / electrics.resistance;
                entries.map(|entry| entry as f32)
            } else {
                change(0)
            },
            velocity: change(1),
            position: change(2),
        };
        if algebraic {
            let steps = f64::from(SIXTEENTHS) / f64::from(1_u32 << rung);
            ladder[rung].conserve(-generator[1][1] * finest * steps);
        }
        transition = multiply(&transition, &transition);
    }
    ladder
}

/// Discretises the winding of an actuator at rest.
fn rest(basis: &Basis) -> RestLadder {
    let electrics = Electrics::of(basis);
    let conductance = electrics.gain / electrics.resistance;
    let mut ladder = [RestIncrement {
        current: -1.0,
        input: conductance as f32,
    }; RUNGS];
    if electrics.inductance > 0.0 {
        let finest = f64::from(basis.period) / f64::from(SIXTEENTHS);
        let exponent = -electrics.resistance / electrics.inductance * finest;
        let mut decay = exponential(&[[exponent]])[0][0];
        for rung in ladder.iter_mut().rev() {
            *rung = RestIncrement {
                current: (decay - 1.0) as f32,
                input: (conductance * (1.0 - decay)) as f32,
            };
            decay *= decay;
        }
    }
    ladder
}
