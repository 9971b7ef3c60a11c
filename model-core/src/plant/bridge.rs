//! What an H-bridge does to the winding between its halves, averaged over a period of its PWM.
//!
//! | bridge | winding |
//! |---|---|
//! | [`Bridge::Drive`] | at duty × supply |
//! | [`Bridge::Brake`] | shorted through two switches: at 0 V, and the back-EMF brakes |
//! | [`Bridge::Freewheel`] | every switch off: while a current flows, the diodes hold supply and two drops against it; then it is open, without current, torque or damping |
//!
//! With the switches off the diodes also conduct where the back-EMF exceeds supply and drops. Of the
//! PWM only the mean is here: no ripple, no dead time, no resistance of the switches.

use super::State;

/// What the bridge is told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Bridge {
    /// PWM of this duty, −1 to 1; positive towards larger positions.
    Drive {
        /// Share of the period, with the direction as its sign. Beyond ±1 it counts as ±1.
        duty: f32,
    },
    /// Both ends of the winding at one rail.
    Brake,
    /// Every switch off, as without power.
    #[default]
    Freewheel,
}

/// What stands at the ends of the winding over a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Terminals {
    /// A voltage, V.
    At(f32),
    /// The voltage that ends the current at the end of the step, up to this magnitude, V.
    Decaying(f32),
    /// Nothing: no current flows.
    Open,
}

impl Bridge {
    /// The voltage that the bridge holds at its ends, V; none with its switches off.
    #[inline]
    pub fn voltage(self, supply: f32) -> Option<f32> {
        match self {
            Self::Drive { duty } if duty > 1.0 => Some(supply),
            Self::Drive { duty } if duty < -1.0 => Some(-supply),
            Self::Drive { duty } => Some(duty * supply),
            Self::Brake => Some(0.0),
            Self::Freewheel => None,
        }
    }

    /// What stands at the winding of an actuator in this state, with its back-EMF constant, V·s/rad.
    /// `clamp` is supply and two diode drops, V.
    #[inline]
    pub(super) fn terminals(
        self,
        supply: f32,
        clamp: f32,
        state: &State,
        back_emf: f32,
    ) -> Terminals {
        if let Some(voltage) = self.voltage(supply) {
            return Terminals::At(voltage);
        }
        if state.current != 0.0 {
            return Terminals::Decaying(clamp);
        }
        let generated = back_emf * state.velocity.value();
        if generated > clamp {
            Terminals::At(clamp)
        } else if generated < -clamp {
            Terminals::At(-clamp)
        } else {
            Terminals::Open
        }
    }
}
