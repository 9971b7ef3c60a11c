//! Where effects are evaluated, many places at once.

use super::Middle;
use crate::plant::lanes::Lanes;

/// Middles of a step side by side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Middles<const N: usize> {
    /// What all lanes have in common.
    pub common: Middle,
    pub motor_torque: Lanes<N>,
    pub warmth: Lanes<N>,
    pub voltage: Lanes<N>,
    pub excess: Lanes<N>,
    pub velocity: Lanes<N>,
    pub position: Lanes<N>,
    pub deflection: Lanes<N>,
    pub time: Lanes<N>,
}

impl<const N: usize> Middles<N> {
    /// The middle in a lane.
    #[inline(always)]
    pub fn at(&self, lane: usize) -> Middle {
        Middle {
            motor_torque: self.motor_torque[lane],
            warmth: self.warmth[lane],
            voltage: self.voltage[lane],
            excess: self.excess[lane],
            velocity: self.velocity[lane],
            position: self.position[lane],
            deflection: self.deflection[lane],
            time: self.time[lane],
            ..self.common
        }
    }
}
