//! From stored values to what the interrupts need.

use core::fmt;

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::{ParameterError, Parameters};
use model_core::plant::throttle::{BuildError, Throttle};

use super::actuator;
use super::bridge::MOST_DUTY;
use super::calibration::{Calibration, Correction};
use super::current_limit;
use super::drive;
use super::encoder_check;
use super::kit::Kit;
use super::motion_limit;
use super::supply_limit;
use super::temperature;
use crate::app::ecu::loopback;
use crate::app::fault::back_emf;
use crate::app::fault::following;
use crate::app::fault::monitor::{Monitors, Observers};
use crate::app::fault::observer::Tolerances;
use crate::app::machine::Machine;
use crate::app::store::field::{Field, Values};
use crate::app::timing::{CONTROL_PERIOD, PLANT_PERIOD};

/// Values that do not go together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// One of the actuator's.
    Plant(ParameterError),
    /// Any other.
    Other(InvalidParameter),
}

impl fmt::Display for Refused {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Plant(error) => error.fmt(formatter),
            Self::Other(error) => error.fmt(formatter),
        }
    }
}

impl core::error::Error for Refused {}

impl From<ParameterError> for Refused {
    fn from(error: ParameterError) -> Self {
        Self::Plant(error)
    }
}

impl From<InvalidParameter> for Refused {
    fn from(error: InvalidParameter) -> Self {
        Self::Other(error)
    }
}

impl From<BuildError> for Refused {
    fn from(error: BuildError) -> Self {
        match error {
            BuildError::Actuator(error) => Self::Plant(error),
            BuildError::Settings(error) => Self::Other(error),
        }
    }
}

/// Of the switches and of the motor.
fn temperature_sensors(values: &Values) -> [temperature::Sensor; 2] {
    let sensor = |maximum, beta| temperature::Sensor {
        maximum: values.get(maximum),
        beta: values.get(beta),
    };
    [
        sensor(Field::SwitchTemperatureMaximum, Field::SwitchSensorBeta),
        sensor(Field::MotorTemperatureMaximum, Field::MotorSensorBeta),
    ]
}

/// Of the bridge.
fn supply_limit(values: &Values) -> supply_limit::Coefficients {
    supply_limit::Coefficients::new(
        values.get(Field::Resistance),
        values.get(Field::SupplyCurrentLimit),
        values.get(Field::RegenerationLimit),
    )
}

impl Kit {
    /// The actuator with these values: neither bridge nor loop asks for more than the half bridges may.
    pub fn machine_with(&self, values: &Values) -> Machine {
        let mut machine = values.applied_to(&self.machine);
        machine.converters.bridge = machine.converters.bridge.saturating_at(MOST_DUTY);
        let most = machine.converters.bridge.value(MOST_DUTY);
        machine.position_loop.output_minimum = -most;
        machine.position_loop.output_maximum = most;
        machine
    }

    /// The drive's numbers. Where the end stops are is trusted only while the position is known.
    ///
    /// # Errors
    /// Values that do not go together.
    pub fn drive(&self, values: &Values, is_referenced: bool) -> Result<drive::Setup, Refused> {
        let machine = self.machine_with(values);
        machine.plant.check()?;
        let Parameters {
            coulomb, breakaway, ..
        } = machine.plant;
        // A model raises it by itself; what a person or a refit says is a mistake.
        if breakaway.forward < coulomb.forward || breakaway.backward < coulomb.backward {
            return Err(Refused::Plant(ParameterError {
                parameter: "static",
                requirement: "at least coulomb",
            }));
        }
        // An emulated actuator bears anything; but what is stored for it has to go together too.
        let resolution = machine.converters.position.unit();
        let observers = Observers {
            winding: back_emf::Coefficients::new(
                &machine.plant,
                &machine.limits,
                Tolerances::INDUSTRIAL,
                resolution,
                CONTROL_PERIOD,
            )?,
            torque: following::Coefficients::new(
                &if is_referenced {
                    machine.plant
                } else {
                    Parameters {
                        lower_stop: f32::NEG_INFINITY,
                        upper_stop: f32::INFINITY,
                        ..machine.plant
                    }
                },
                Tolerances::INDUSTRIAL,
                machine.limits.load,
                resolution,
                CONTROL_PERIOD,
            )?,
        };
        let monitors = Monitors::new(machine.limits, observers, CONTROL_PERIOD)?;
        let motion = motion_limit::Coefficients::new(
            &machine,
            values.get(Field::TorqueConstant),
            &supply_limit(values),
        )?;
        Ok(drive::Setup {
            pid: machine.position_loop.build(CONTROL_PERIOD)?,
            converters: machine.converters,
            stroke: [
                machine.plant.lower_stop.max(machine.motion.position[0]),
                machine.plant.upper_stop.min(machine.motion.position[1]),
            ],
            current: self.measured_current(values),
            motion: (!self.is_emulated).then_some(motion),
            temperature: (!self.is_emulated).then(|| {
                temperature::Coefficients::new(
                    temperature_sensors(values),
                    machine.limits.current(),
                )
            }),
            command_steps: (machine.limits.command_timeout > 0.0)
                .then_some((machine.limits.command_timeout / CONTROL_PERIOD) as u32),
            encoder_check: self.checks_encoder(values).then(|| {
                encoder_check::Coefficients::new(&machine, values.get(Field::TorqueConstant))
            }),
            monitors: (!self.is_emulated).then_some(monitors),
        })
    }

    /// Whether the encoder is checked before a loop is closed over it.
    pub fn checks_encoder(&self, values: &Values) -> bool {
        !self.is_emulated && values.get(Field::EncoderCheck) >= 0.5
    }

    /// What the current sensor is off by: an emulated one by nothing.
    pub fn measured_current(&self, values: &Values) -> Correction {
        if self.is_emulated {
            Correction::NONE
        } else {
            Calibration::of(values).current
        }
    }

    /// What an emulated body's outputs are off by.
    pub fn calibration(&self, values: &Values) -> Calibration {
        Calibration::of(values)
    }

    /// What a real actuator's tick goes by. Its current's correction is the sensor's, not an output's.
    pub fn actuator(&self, values: &Values) -> actuator::Numbers {
        let machine = self.machine_with(values);
        actuator::Numbers {
            converters: machine.converters,
            calibration: Calibration {
                current: Correction::NONE,
                ..Calibration::of(values)
            },
            peak: machine.limits.peak_current,
            sensor: Calibration::of(values).current,
            limit: machine.limits.current(),
            limiter: current_limit::Coefficients::new(
                values.get(Field::Resistance),
                values.get(Field::Inductance),
            ),
            supply: supply_limit(values),
            stroke: [machine.plant.lower_stop, machine.plant.upper_stop],
        }
    }

    /// The throttle body, with a complementary second track.
    ///
    /// # Errors
    /// Values that do not go together.
    pub fn throttle(&self, values: &Values) -> Result<Throttle, Refused> {
        let machine = self.machine_with(values);
        let settings = loopback::complementary(machine.plant, loopback::SEED);
        Ok(Throttle::build(&settings, PLANT_PERIOD)?)
    }
}
