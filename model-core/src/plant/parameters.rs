//! What an actuator is made of.

use super::Directional;

/// What the input is.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Drive {
    /// The input drives the winding of a brushed DC motor.
    Voltage {
        /// Winding resistance, Ω, > 0.
        resistance: f32,
        /// Winding inductance, H, ≥ 0; 0 neglects it.
        inductance: f32,
        /// Torque constant, N·m/A or N/A, and back-EMF constant, V·s/rad or V·s/m, > 0.
        torque_constant: f32,
    },
    /// The input is the motor torque or force itself.
    Torque,
}

/// A winding whose current has settled; all 0 with a torque input, where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Winding {
    /// Ω.
    pub resistance: f32,
    /// N·m/A or N/A, and V·s/rad or V·s/m.
    pub torque_constant: f32,
}

impl Winding {
    /// Whether there is one.
    #[inline]
    pub fn is_there(&self) -> bool {
        self.resistance > 0.0
    }

    /// Torque or force of the motor at a current, which without a winding is that already.
    #[inline]
    pub fn torque(&self, current: f32) -> f32 {
        if self.is_there() {
            self.torque_constant * current
        } else {
            current
        }
    }

    /// Current that it settles on at this voltage and this velocity, m/s or rad/s; without one, the
    /// torque or force that stands for the voltage.
    #[inline]
    pub fn steady_current(&self, voltage: f32, velocity: f32) -> f32 {
        if self.is_there() {
            (voltage - self.torque_constant * velocity) / self.resistance
        } else {
            voltage
        }
    }
}

impl Drive {
    /// The winding, its inductance left aside.
    pub fn winding(&self) -> Winding {
        match *self {
            Self::Voltage {
                resistance,
                torque_constant,
                ..
            } => Winding {
                resistance,
                torque_constant,
            },
            Self::Torque => Winding {
                resistance: 0.0,
                torque_constant: 0.0,
            },
        }
    }
}

/// A brushed-DC actuator in SI units, referred to the coordinate of the position.
///
/// `rad` and `m` are both served: torque and inertia stand for force and mass.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Parameters {
    /// What the input is.
    pub drive: Drive,
    /// V, N·m or N for one unit of the input, not 0.
    pub gain: f32,
    /// Inertia of rotor and load, kg·m² or kg, > 0.
    pub inertia: f32,
    /// Viscous friction, N·m·s/rad or N·s/m, ≥ 0.
    pub viscous: Directional,
    /// Coulomb friction while sliding, N·m or N, ≥ 0.
    pub coulomb: Directional,
    /// Torque or force that friction holds at rest, N·m or N. Raised to the Coulomb level where it
    /// is below it.
    pub breakaway: Directional,
    /// Stiffness of the return spring, N·m/rad or N/m, ≥ 0.
    pub spring: f32,
    /// Position at which the return spring is at rest, rad or m.
    pub spring_rest: f32,
    /// Torque or force with which the spring starts on either side of its rest (limp-home), ≥ 0.
    pub spring_preload: f32,
    /// Constant torque or force on the mechanism, positive towards larger positions, N·m or N.
    pub offset: f32,
    /// Lower end stop, rad or m; `f32::NEG_INFINITY` for none.
    pub lower_stop: f32,
    /// Upper end stop, rad or m; `f32::INFINITY` for none.
    pub upper_stop: f32,
}

/// A parameter outside its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ParameterError {
    /// The field of [`Parameters`].
    pub parameter: &'static str,
    /// What it must be.
    pub requirement: &'static str,
}

impl core::fmt::Display for ParameterError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(formatter, "{} must be {}", self.parameter, self.requirement)
    }
}

impl core::error::Error for ParameterError {}

/// Largest magnitude that a parameter may have, so that no product of two overflows.
const LARGEST: f32 = 1e12;

impl Parameters {
    /// An inertia, kg·m² or kg, that nothing but the input's torque or force moves: what others build
    /// on, field by field.
    pub const fn free(inertia: f32) -> Self {
        Self {
            drive: Drive::Torque,
            gain: 1.0,
            inertia,
            viscous: Directional::both(0.0),
            coulomb: Directional::both(0.0),
            breakaway: Directional::both(0.0),
            spring: 0.0,
            spring_rest: 0.0,
            spring_preload: 0.0,
            offset: 0.0,
            lower_stop: f32::NEG_INFINITY,
            upper_stop: f32::INFINITY,
        }
    }

    /// The same actuator with its winding's inductance neglected: the reduced motor.
    pub fn reduced(self) -> Self {
        let drive = match self.drive {
            Drive::Voltage {
                resistance,
                torque_constant,
                ..
            } => Drive::Voltage {
                resistance,
                inductance: 0.0,
                torque_constant,
            },
            Drive::Torque => Drive::Torque,
        };
        Self { drive, ..self }
    }

    /// Checks every field against its range.
    ///
    /// # Errors
    /// The first field outside its range.
    pub fn check(&self) -> Result<(), ParameterError> {
        let positive = |parameter, value: f32| {
            if value > 0.0 && value <= LARGEST {
                Ok(())
            } else {
                Err(ParameterError {
                    parameter,
                    requirement: "greater than 0 and at most 1e12",
                })
            }
        };
        let non_negative = |parameter, value: f32| {
            if (0.0..=LARGEST).contains(&value) {
                Ok(())
            } else {
                Err(ParameterError {
                    parameter,
                    requirement: "at least 0 and at most 1e12",
                })
            }
        };
        let finite = |parameter, value: f32| {
            if value.abs() <= LARGEST {
                Ok(())
            } else {
                Err(ParameterError {
                    parameter,
                    requirement: "finite and at most 1e12 in magnitude",
                })
            }
        };
        if let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = self.drive
        {
            positive("resistance", resistance)?;
            non_negative("inductance", inductance)?;
            positive("torque_constant", torque_constant)?;
        }
        positive("gain", self.gain.abs())?;
        positive("inertia", self.inertia)?;
        non_negative("viscous", self.viscous.forward)?;
        non_negative("viscous", self.viscous.backward)?;
        non_negative("coulomb", self.coulomb.forward)?;
        non_negative("coulomb", self.coulomb.backward)?;
        non_negative("breakaway", self.breakaway.forward)?;
        non_negative("breakaway", self.breakaway.backward)?;
        non_negative("spring", self.spring)?;
        finite("spring_rest", self.spring_rest)?;
        non_negative("spring_preload", self.spring_preload)?;
        finite("offset", self.offset)?;
        if self.lower_stop < self.upper_stop {
            Ok(())
        } else {
            Err(ParameterError {
                parameter: "lower_stop",
                requirement: "below upper_stop",
            })
        }
    }

    /// Torque or force that one unit of motor current gives; 1 with a torque input, where the
    /// state's current is the torque itself.
    pub fn torque_per_current(&self) -> f32 {
        self.drive.winding().torque(1.0)
    }

    /// Current that the winding settles on at this velocity and input; with a torque input, the
    /// torque.
    pub fn steady_current(&self, velocity: f32, input: f32) -> f32 {
        let winding = self.drive.winding();
        winding.steady_current(self.gain * input, velocity)
    }
}
