//! The encoder against the winding: a motor that turns says so in its back-EMF.
//!
//! Over a control period *h* Kirchhoff's law of the winding, u = R i + L di/dt + k ω, integrates to
//!
//! u h = R ∫i dt + L Δi + k Δθ,
//!
//! in which no measurement is differentiated. What is left of it,
//!
//! e = u − R (i₀ + i₁)/2 − (L Δi + k Δθ)/h,
//!
//! is 0 V for exact numbers. For those within their tolerances it stays below
//!
//! b = δu + δR R |i| + R |Δi|/2 + (δL L |Δi| + δk k |Δθ|)/h,
//!
//! whose third term is the trapezoidal rule's worst for a current that is monotone over the period.
//! Both go through one first-order filter with the time constant *τ*. Its response is positive, so
//! |e| ≤ b in every period keeps the filtered |E| below the filtered B. Reading in steps of *r* rad is
//! wrong by half a step at most however long it moves, which the filter makes k r/τ of; twice that
//! covers what it hides of b too. Hence |E| > B + 2 k r/τ means that the encoder, the current sensor or
//! one of the declared tolerances is wrong: no debounce, no number that was tried out.
//!
//! A motor at ω whose encoder claims ω' is found within three time constants from where
//! k |ω − ω'| exceeds δu + δR R |i| + δk k |ω'|. A motor that is held, at a stop for instance, tells the
//! winding nothing about its encoder: what ends that is [`Fault::Overload`].

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::{Drive, Parameters};

use super::Fault;

/// How far the truth may be from the declared winding, as shares of the declared numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Of the resistance. Copper has 0.39 % more a kelvin.
    pub resistance: f32,
    /// Of the inductance. Iron that saturates loses a part of it.
    pub inductance: f32,
    /// Of the torque constant. Ferrite magnets lose 0.2 % a kelvin.
    pub torque_constant: f32,
    /// Between the voltage that was told and that at the winding, V: dead time, brushes, and the drop
    /// of the switches.
    pub voltage: f32,
}

impl Tolerances {
    /// A winding between −20 and 105 °C that was declared at 20 °C, with ferrite magnets and an
    /// inductance from a data sheet; 0.3 V at each of two brushes, and 1 µs of dead time in a period
    /// of 50 µs at 24 V, half a volt.
    pub const INDUSTRIAL: Self = Self {
        resistance: 0.35,
        inductance: 0.3,
        torque_constant: 0.2,
        voltage: 1.1,
    };
}

/// Time constant of the filter, s: four periods of the loop, over which a sample of the PWM's ripple
/// that is off averages out.
pub const TIME_CONSTANT: f32 = 4e-3;

/// What a control step measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// By the encoder, rad or m.
    pub position: f32,
    /// In the motor, A.
    pub current: f32,
    /// That stood at the winding since the reading before, V; none with the bridge off, which leaves
    /// the winding to itself.
    pub voltage: Option<f32>,
}

/// The observer's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    resistance: f32,
    /// L/h.
    inductance: f32,
    /// k/h.
    back_emf: f32,
    tolerances: Tolerances,
    /// 2 k r/τ, V.
    quantisation: f32,
    /// h/τ.
    gain: f32,
}

/// What the observer remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    before: Option<(f32, f32)>,
    /// E, V.
    residual: f32,
    /// B, V.
    bound: f32,
    /// Filtered magnitude of what the encoder claims, k |Δθ|/h, V.
    claimed: f32,
}

impl Coefficients {
    /// For an actuator, an encoder with steps of `resolution`, rad or m, and a control period, s.
    /// Lost motion between motor and encoder adds to the resolution.
    ///
    /// # Errors
    /// The drive is no voltage, or a number is out of its range.
    pub fn new(
        plant: &Parameters,
        tolerances: Tolerances,
        resolution: f32,
        period: f32,
    ) -> Result<Self, InvalidParameter> {
        let refused = |name, requirement| Err(InvalidParameter { name, requirement });
        let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = plant.drive
        else {
            return refused("drive", "must be a voltage");
        };
        if !(period > 0.0 && period <= TIME_CONSTANT) {
            return refused("period", "must be above 0 and at most 4 ms");
        }
        if !(resolution >= 0.0 && resolution.is_finite()) {
            return refused("resolution", "must be at least 0");
        }
        let shares = [
            tolerances.resistance,
            tolerances.inductance,
            tolerances.torque_constant,
            tolerances.voltage,
        ];
        if !shares.iter().all(|share| (0.0..=1e3).contains(share)) {
            return refused("tolerances", "must be 0 to 1000");
        }
        Ok(Self {
            resistance,
            inductance: inductance / period,
            back_emf: torque_constant / period,
            tolerances,
            quantisation: 2.0 * torque_constant * resolution / TIME_CONSTANT,
            gain: period / TIME_CONSTANT,
        })
    }

    /// Takes a reading: [`Fault::EncoderLost`] or [`Fault::EncoderImplausible`] as long as the encoder
    /// is not to be believed. A reading that is not finite is none, and the observer begins anew; so it
    /// does with the bridge off.
    pub fn step(&self, state: &mut State, reading: &Reading) -> Option<Fault> {
        let now = (reading.position, reading.current);
        let finite = now.0.is_finite() && now.1.is_finite();
        let voltage = reading.voltage.filter(|volts| volts.is_finite() && finite);
        let Some(voltage) = voltage else {
            *state = State {
                before: finite.then_some(now),
                ..State::default()
            };
            return None;
        };
        let (position, current) = state.before.replace(now).unwrap_or(now);
        let mean = 0.5 * (current + now.1);
        let change = now.1 - current;
        let claimed = self.back_emf * (now.0 - position);
        let residual = voltage - self.resistance * mean - self.inductance * change - claimed;
        let bound = self.tolerances.voltage
            + self.tolerances.resistance * self.resistance * mean.abs()
            + (0.5 * self.resistance + self.tolerances.inductance * self.inductance) * change.abs()
            + self.tolerances.torque_constant * claimed.abs();
        state.residual += self.gain * (residual - state.residual);
        state.bound += self.gain * (bound - state.bound);
        state.claimed += self.gain * (claimed.abs() - state.claimed);
        if state.residual.abs() <= state.bound + self.quantisation {
            None
        } else if state.claimed <= self.quantisation {
            Some(Fault::EncoderLost)
        } else {
            Some(Fault::EncoderImplausible)
        }
    }
}
