//! Inverter and windings, switch by switch: the paper's own fidelity (sections 3.3 and 3.4).
//!
//! For steps of about 1 µs: a relay looks once a step, so that a current passes its band by what it
//! grows in one, 12 mA in 1 µs at most.

use super::electrics::{Drive, Electrics, Parameters, Rotor};
use super::hysteresis::Relays;
use super::park::{Rotation, clarke, inverse_clarke};
use super::torque::sum_of_phases;
use super::windings::Windings;
use crate::numeric::invalid_parameter::InvalidParameter;
use core::f32::consts::{FRAC_1_SQRT_2, SQRT_2};

/// At work.
#[derive(Debug, Clone, PartialEq)]
pub struct Switching {
    parameters: Parameters,
    windings: Windings,
    coefficient: f32,
    relays: Relays,
    currents: [f32; 3],
}

impl Switching {
    /// Phase currents, A.
    pub fn currents(&self) -> [f32; 3] {
        self.currents
    }
}

impl Electrics for Switching {
    fn build(parameters: &Parameters, period: f32) -> Result<Self, InvalidParameter> {
        parameters.check()?;
        Ok(Self {
            windings: parameters.windings.build(period)?,
            coefficient: parameters.torque.coefficient(),
            parameters: *parameters,
            relays: Relays::default(),
            currents: [0.0; 3],
        })
    }

    #[inline]
    fn step(&mut self, reference: f32, rotor: &Rotor) -> Drive {
        let Parameters {
            back_emf,
            torque,
            inverter,
            ..
        } = &self.parameters;
        let rotation = Rotation::new(rotor.electrical);
        let wanted = inverse_clarke(rotation.inverse_park([0.0, SQRT_2 * reference]));
        let errors = [0, 1, 2].map(|phase| wanted[phase] - self.currents[phase]);
        let terminals = inverter.terminals(self.relays.switch(errors, inverter.band));
        let coefficients = back_emf
            .coefficients(rotor.electrical, rotor.mechanical, &rotation)
            .map(|share| share * self.coefficient);
        let before = self.currents;
        let back_emf = coefficients.map(|coefficient| coefficient * rotor.velocity);
        self.windings.step(&mut self.currents, terminals, back_emf);
        let mean = [0, 1, 2].map(|phase| 0.5 * (before[phase] + self.currents[phase]));
        let [direct, quadrature] = rotation.park(clarke(self.currents));
        Drive {
            torque: torque.saturated(sum_of_phases(mean, coefficients)),
            direct: FRAC_1_SQRT_2 * direct,
            quadrature: FRAC_1_SQRT_2 * quadrature,
        }
    }
}
