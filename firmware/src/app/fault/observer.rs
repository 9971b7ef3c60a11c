//! What the two monitors of the encoder share: the [`back_emf`](super::back_emf) one and the
//! [`following`](super::following) one read the same measurements, believe the declared numbers as far, and filter
//! alike.

use model_core::numeric::invalid_parameter::InvalidParameter;

/// Time constant of the filter, s: four periods of the loop, over which a sample of the PWM's ripple
/// that is off averages out.
pub const TIME_CONSTANT: f32 = 4e-3;

/// That a monitor can be made for an encoder with steps of `resolution`, rad or m, and a control period, s.
///
/// # Errors
/// A resolution or a period out of its range.
pub(super) fn check_encoder(resolution: f32, period: f32) -> Result<(), InvalidParameter> {
    let refused = |name, requirement| Err(InvalidParameter { name, requirement });
    if !(period > 0.0 && period <= TIME_CONSTANT) {
        return refused("period", "must be above 0 and at most 4 ms");
    }
    if !(resolution >= 0.0 && resolution.is_finite()) {
        return refused("resolution", "must be at least 0");
    }
    Ok(())
}

/// What a control step measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// By the encoder, rad or m.
    pub position: f32,
    /// The encoder's way since the reading before, rad or m. A difference of positions is none after thousands of turns: single
    /// precision no longer holds each count of them.
    pub moved: f32,
    /// In the motor, A: its mean since the reading before.
    pub current: f32,
    /// That stood at the winding since the reading before, V, in the mean; none with the bridge off, which leaves
    /// the winding to itself.
    pub voltage: Option<f32>,
    /// Between the most and the least voltage since then, V: 0 but where the current is limited.
    pub spread: f32,
}

/// How far the truth may be from the declared actuator, as shares of the declared numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Of the resistance. Copper has 0.39 % more a kelvin.
    pub resistance: f32,
    /// Of the inductance. Iron that saturates loses a part of it.
    pub inductance: f32,
    /// Of the torque constant. Ferrite magnets lose 0.2 % a kelvin.
    pub torque_constant: f32,
    /// What the brushes take of the voltage, V, from 0 to this. It comes and goes at any time.
    pub brushes: f32,
    /// Of the supply: what the dead time of the bridge takes of the voltage, from 0 to this.
    pub dead_time: f32,
    /// Of the inertia.
    pub inertia: f32,
    /// Of friction, and of the return spring.
    pub mechanics: f32,
    /// Of the stroke: how near to a declared stop the encoder reads where the actuator is at it.
    pub stop: f32,
}

impl Tolerances {
    /// A winding between −20 and 105 °C that was declared at 20 °C, with ferrite magnets and an
    /// inductance from a data sheet; 0.3 V at each of two brushes, and 1 µs of dead time in a period
    /// of 50 µs. Mechanics that were identified on one actuator of a series, and
    /// buffers at its stops that yield.
    pub const INDUSTRIAL: Self = Self {
        resistance: 0.35,
        inductance: 0.3,
        torque_constant: 0.2,
        brushes: 0.6,
        dead_time: 0.02,
        inertia: 0.2,
        mechanics: 0.25,
        stop: 0.02,
    };

    /// That nothing of it is senseless.
    ///
    /// # Errors
    /// Not a number, negative, or so large that the declared number says nothing.
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        let shares = [
            self.resistance,
            self.inductance,
            self.torque_constant,
            self.brushes,
            self.dead_time,
            self.inertia,
            self.mechanics,
            self.stop,
        ];
        let sensible = shares.iter().all(|share| (0.0..=1e3).contains(share));
        sensible.then_some(()).ok_or(InvalidParameter {
            name: "tolerances",
            requirement: "must be 0 to 1000",
        })
    }
}
