//! Inverter and windings in the mean of the switching, in the rotor's frame.
//!
//! The hysteresis takes the current to its reference as fast as the bus allows and holds it there.
//! In the mean that is the voltage with which the current is at the reference at the step's end, cut
//! to V/√3, the largest that the bridge has in every direction. With z = d + j q, over a step in
//! which the rotor turns by φ = ω_e h electrically and the voltage stands still in the stator,
//!
//! ```text
//! z⁺ = e^(−jφ) e^(−Rh/L) z + (1 − e^(−Rh/L))/R · (v − e)
//! ```
//!
//! is exact, at 1 µs and at 100 µs alike. What is left out is the ripple of the band.

use super::back_emf;
use super::electrics::{Drive, Electrics, Parameters, Rotor};
use super::park::{Rotation, clarke};
use super::windings::Windings;
use crate::numeric::invalid_parameter::InvalidParameter;
use core::f32::consts::{FRAC_1_SQRT_2, SQRT_2, TAU};

const INVERSE_ROOT_3: f32 = 0.577_350_26;

/// At work.
#[derive(Debug, Clone, PartialEq)]
pub struct Averaged {
    parameters: Parameters,
    windings: Windings,
    coefficient: f32,
    /// Current that a voltage over a step adds, A/V, and its inverse.
    admittance: f32,
    impedance: f32,
    /// Largest voltage, V, squared too.
    limit: f32,
    limit_squared: f32,
    /// Cycles by which the rotor turns electrically in a step at 1 rad/s.
    cycles_per_velocity: f32,
    /// d and q, A.
    current: [f32; 2],
}

impl Averaged {
    /// Coefficients of the phases as the rotor sees them, d and q.
    #[inline]
    fn coefficients(&self, rotor: &Rotor) -> [f32; 2] {
        let shapes = &self.parameters.back_emf;
        if *shapes == back_emf::Parameters::SOUND {
            return [0.0, self.coefficient];
        }
        let rotation = Rotation::new(rotor.electrical);
        let phases = shapes.coefficients(rotor.electrical, rotor.mechanical, &rotation);
        rotation
            .park(clarke(phases))
            .map(|share| share * self.coefficient)
    }
}

impl Electrics for Averaged {
    fn build(parameters: &Parameters, period: f32) -> Result<Self, InvalidParameter> {
        parameters.check()?;
        let windings = parameters.windings.build(period)?;
        let limit = parameters.inverter.bus_voltage * INVERSE_ROOT_3;
        Ok(Self {
            admittance: windings.admittance(),
            impedance: windings.impedance(),
            windings,
            coefficient: parameters.torque.coefficient(),
            limit,
            limit_squared: limit * limit,
            cycles_per_velocity: f32::from(parameters.windings.pole_pairs) * period / TAU,
            parameters: *parameters,
            current: [0.0; 2],
        })
    }

    #[inline]
    fn step(&mut self, reference: f32, rotor: &Rotor) -> Drive {
        let coefficients = self.coefficients(rotor);
        let back_emf = coefficients.map(|coefficient| coefficient * rotor.velocity);
        let before = self.current;
        let turned = Rotation::new(self.cycles_per_velocity * rotor.velocity);
        let free = turned
            .park(before)
            .map(|current| current * self.windings.decay);
        let wanted = [0.0, SQRT_2 * reference];
        let voltage =
            [0, 1].map(|axis| back_emf[axis] + (wanted[axis] - free[axis]) * self.impedance);
        let squared = voltage[0] * voltage[0] + voltage[1] * voltage[1];
        self.current = if squared <= self.limit_squared {
            wanted
        } else {
            let scale = self.limit / libm::sqrtf(squared);
            [0, 1]
                .map(|axis| free[axis] + (scale * voltage[axis] - back_emf[axis]) * self.admittance)
        };
        let [direct, quadrature] = [0, 1].map(|axis| 0.5 * (before[axis] + self.current[axis]));
        let torque = 1.5 * (coefficients[0] * direct + coefficients[1] * quadrature);
        Drive {
            torque: self.parameters.torque.saturated(torque),
            direct: FRAC_1_SQRT_2 * self.current[0],
            quadrature: FRAC_1_SQRT_2 * self.current[1],
        }
    }
}
