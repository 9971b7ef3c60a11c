//! What the two fidelities of inverter and windings have in common.

use super::{back_emf, three_phase_bridge, torque, windings};
use crate::numeric::invalid_parameter::InvalidParameter;

/// Motor and inverter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Of the motor.
    pub windings: windings::Parameters,
    /// Shape of its field, and its faults.
    pub back_emf: back_emf::Parameters,
    /// Its torque.
    pub torque: torque::Parameters,
    /// What drives it.
    pub inverter: three_phase_bridge::Parameters,
}

impl Parameters {
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        self.back_emf.check()?;
        self.torque.check()?;
        self.inverter.check()
    }
}

/// The rotor at the start of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotor {
    /// Electrical angle by the resolver, cycles.
    pub electrical: f32,
    /// Mechanical angle, cycles.
    pub mechanical: f32,
    /// rad/s.
    pub velocity: f32,
}

/// What a step gives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// Torque on the rotor in the mean of the step, N·m.
    pub torque: f32,
    /// Direct current, A rms.
    pub direct: f32,
    /// Quadrature current, A rms.
    pub quadrature: f32,
}

/// Inverter and windings: a reference in, a torque out.
pub trait Electrics: Sized {
    /// For steps of `period` seconds, without current.
    ///
    /// # Errors
    /// A parameter outside its range.
    fn build(parameters: &Parameters, period: f32) -> Result<Self, InvalidParameter>;

    /// One step towards a quadrature current, A rms.
    fn step(&mut self, reference: f32, rotor: &Rotor) -> Drive;
}
