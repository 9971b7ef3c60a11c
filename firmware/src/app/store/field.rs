//! What is stored: names, units and bounds of the fields, and their values.

use core::fmt;

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::Directional;
use model_core::plant::parameters::Drive;

use crate::app::machine::Machine;
use crate::app::operation::motion_limit::NO_POSITION;
use crate::app::operation::supply_limit::NO_LIMIT;
use crate::app::operation::temperature::BETA;

/// A field. Its number is its key in flash: a field that is no longer needed leaves its number
/// unused, and a new one takes the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Field {
    /// Winding resistance.
    Resistance = 1,
    /// Winding inductance.
    Inductance = 2,
    /// Torque and back-EMF constant.
    TorqueConstant = 3,
    /// Inertia of rotor and load.
    Inertia = 4,
    /// Viscous friction, both directions.
    Viscous = 5,
    /// Coulomb friction, both directions.
    Coulomb = 6,
    /// Friction that holds at rest, both directions.
    Static = 7,
    /// Stiffness of the return spring.
    Spring = 8,
    /// Where the return spring is at rest.
    SpringRest = 9,
    /// Torque step at the spring's rest.
    SpringPreload = 10,
    /// The position loop's proportional gain.
    Proportional = 11,
    /// The position loop's integral gain.
    Integral = 12,
    /// The position loop's derivative gain.
    Derivative = 13,
    /// The position loop's derivative filter.
    DerivativeFilterTime = 14,
    /// Factor on the first track's voltage.
    Track1Gain = 15,
    /// Voltage added to the first track.
    Track1Offset = 16,
    /// Factor on the second track's voltage.
    Track2Gain = 17,
    /// Voltage added to the second track.
    Track2Offset = 18,
    /// Factor on the measured current.
    CurrentGain = 19,
    /// Current added to the measured one.
    CurrentOffset = 20,
    /// One count of the position sensor.
    PositionUnit = 21,
    /// Where the stroke begins.
    LowerStop = 22,
    /// Where it ends.
    UpperStop = 23,
    /// Most current that the bridge may carry.
    PeakCurrent = 24,
    /// Most current for ever.
    ContinuousCurrent = 25,
    /// Least supply of the bridge.
    SupplyMinimum = 26,
    /// Most supply of the bridge.
    SupplyMaximum = 27,
    /// Most load beside friction and spring, either way.
    Load = 28,
    /// How long commands are driven without another one; 0 for ever.
    CommandTimeout = 29,
    /// Most current that the drive lets flow.
    CurrentLimit = 30,
    /// Most speed; 0 for no limit.
    SpeedLimit = 31,
    /// Least position that is driven to.
    PositionMinimum = 32,
    /// Most position that is driven to.
    PositionMaximum = 33,
    /// Most temperature of the switches; 0 without a sensor.
    SwitchTemperatureMaximum = 34,
    /// Most temperature of the motor; 0 without a sensor.
    MotorTemperatureMaximum = 35,
    /// B of the switches' temperature sensor.
    SwitchSensorBeta = 36,
    /// B of the motor's temperature sensor.
    MotorSensorBeta = 37,
    /// Most current that the bridge draws from its supply.
    SupplyCurrentLimit = 38,
    /// Most current that braking gives back to the supply.
    RegenerationLimit = 39,
    /// Whether the encoder is checked before a loop is closed over it; 0 or 1.
    EncoderCheck = 40,
}

/// How many there are.
pub const FIELDS: usize = Field::ALL.len();

/// A field's name and range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description {
    /// Its name, as in a machine file where that has it.
    pub name: &'static str,
    /// Its SI unit, for an angle as coordinate.
    pub unit: &'static str,
    /// Smallest value that is kept.
    pub lower: f32,
    /// Largest value that is kept.
    pub upper: f32,
}

/// Each in the place of its number less one. The bounds are those of any actuator that the board's
/// bridge could drive: they keep out what would make a model or a loop meaningless, not what would
/// make it bad.
pub static DESCRIPTIONS: [Description; FIELDS] = [
    described("resistance", "Ω", 1e-3, 1e3),
    described("inductance", "H", 0.0, 1.0),
    described("torque_constant", "N·m/A", 1e-4, 1e2),
    described("inertia", "kg·m²", 1e-9, 1e2),
    described("viscous", "N·m·s/rad", 0.0, 1e2),
    described("coulomb", "N·m", 0.0, 1e2),
    described("static", "N·m", 0.0, 1e2),
    described("spring", "N·m/rad", 0.0, 1e3),
    described("spring_rest", "rad", -1e2, 1e2),
    described("spring_preload", "N·m", 0.0, 1e2),
    described("proportional", "V/rad", 0.0, 1e4),
    described("integral", "V/(rad·s)", 0.0, 1e5),
    described("derivative", "V·s/rad", 0.0, 1e3),
    described("derivative_filter_time", "s", 0.0, 1.0),
    described("track_1_gain", "1", 0.5, 2.0),
    described("track_1_offset", "V", -1.0, 1.0),
    described("track_2_gain", "1", 0.5, 2.0),
    described("track_2_offset", "V", -1.0, 1.0),
    described("current_gain", "1", 0.5, 2.0),
    described("current_offset", "A", -5.0, 5.0),
    described("position_unit", "rad", 1e-6, 0.1),
    described("lower_stop", "rad", -1e3, 1e3),
    described("upper_stop", "rad", -1e3, 1e3),
    // Beyond 25 A the sensor saturates, and beyond 36 V that of the supply.
    described("peak_current", "A", 0.1, 24.9),
    described("continuous_current", "A", 0.01, 24.9),
    described("supply_minimum", "V", 5.0, 36.0),
    described("supply_maximum", "V", 5.0, 36.0),
    described("load", "N·m", 0.0, 1e2),
    described("command_timeout", "s", 0.0, 3600.0),
    described("current_limit", "A", 0.1, 24.9),
    described("speed_limit", "rad/s", 0.0, 1e4),
    // At their bounds they are none.
    described("position_minimum", "rad", -NO_POSITION, NO_POSITION),
    described("position_maximum", "rad", -NO_POSITION, NO_POSITION),
    // 0 without a sensor; below what a sensor reads that is whole.
    described("switch_temperature_maximum", "°C", 0.0, 140.0),
    described("motor_temperature_maximum", "°C", 0.0, 140.0),
    described("switch_sensor_beta", "K", 2500.0, 5000.0),
    described("motor_sensor_beta", "K", 2500.0, 5000.0),
    // At their bounds they are none.
    described("supply_current_limit", "A", 0.1, NO_LIMIT),
    described("regeneration_limit", "A", 0.0, NO_LIMIT),
    described("encoder_check", "1", 0.0, 1.0),
];

const fn described(name: &'static str, unit: &'static str, lower: f32, upper: f32) -> Description {
    Description {
        name,
        unit,
        lower,
        upper,
    }
}

impl Field {
    /// All of them, by number.
    pub const ALL: [Self; 40] = [
        Self::Resistance,
        Self::Inductance,
        Self::TorqueConstant,
        Self::Inertia,
        Self::Viscous,
        Self::Coulomb,
        Self::Static,
        Self::Spring,
        Self::SpringRest,
        Self::SpringPreload,
        Self::Proportional,
        Self::Integral,
        Self::Derivative,
        Self::DerivativeFilterTime,
        Self::Track1Gain,
        Self::Track1Offset,
        Self::Track2Gain,
        Self::Track2Offset,
        Self::CurrentGain,
        Self::CurrentOffset,
        Self::PositionUnit,
        Self::LowerStop,
        Self::UpperStop,
        Self::PeakCurrent,
        Self::ContinuousCurrent,
        Self::SupplyMinimum,
        Self::SupplyMaximum,
        Self::Load,
        Self::CommandTimeout,
        Self::CurrentLimit,
        Self::SpeedLimit,
        Self::PositionMinimum,
        Self::PositionMaximum,
        Self::SwitchTemperatureMaximum,
        Self::MotorTemperatureMaximum,
        Self::SwitchSensorBeta,
        Self::MotorSensorBeta,
        Self::SupplyCurrentLimit,
        Self::RegenerationLimit,
        Self::EncoderCheck,
    ];

    /// Its name, unit and bounds.
    pub fn description(self) -> &'static Description {
        &DESCRIPTIONS[self.index()]
    }

    /// The field of this name.
    ///
    /// ```
    /// use firmware::app::store::field::Field;
    /// assert_eq!(Field::named("coulomb"), Some(Field::Coulomb));
    /// assert_eq!(Field::Coulomb.description().unit, "N·m");
    /// assert_eq!(Field::named("colour"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|field| field.description().name == name)
    }

    /// Whether it is the actuator's: its motor's, its mechanics' with the stops, or its friction's.
    pub const fn is_plant(self) -> bool {
        self as usize <= Self::SpringPreload as usize
            || matches!(self, Self::LowerStop | Self::UpperStop)
    }

    /// The field of this number.
    pub(super) fn numbered(number: u16) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(1)?).copied()
    }

    /// Where it stands among all.
    const fn index(self) -> usize {
        self as usize - 1
    }

    /// The value, if it is within the bounds.
    fn check(self, value: f32) -> Result<f32, OutOfBounds> {
        let Description { lower, upper, .. } = *self.description();
        // Not for NaN.
        if (lower..=upper).contains(&value) {
            Ok(value)
        } else {
            Err(OutOfBounds { field: self, value })
        }
    }
}

/// A value that is not kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfBounds {
    /// What it was for.
    pub field: Field,
    /// The value.
    pub value: f32,
}

impl fmt::Display for OutOfBounds {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Description {
            name,
            unit,
            lower,
            upper,
        } = self.field.description();
        let value = self.value;
        write!(
            formatter,
            "{name} must be {lower:e} to {upper:e} {unit}, not {value:e}"
        )
    }
}

impl core::error::Error for OutOfBounds {}

/// A value for each field, within its bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Values([f32; FIELDS]);

impl Values {
    /// Those of a machine, the forward ones where the directions differ, and no correction of its
    /// sensors.
    ///
    /// # Errors
    /// A drive that is no voltage, or a number outside its field's bounds.
    pub fn of(machine: &Machine) -> Result<Self, InvalidParameter> {
        let plant = &machine.plant;
        let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = plant.drive
        else {
            return Err(InvalidParameter {
                name: "drive",
                requirement: "must be a voltage",
            });
        };
        let gains = &machine.position_loop;
        let limits = &machine.limits;
        let values = Self([
            resistance,
            inductance,
            torque_constant,
            plant.inertia,
            plant.viscous.forward,
            plant.coulomb.forward,
            plant.breakaway.forward,
            plant.spring,
            plant.spring_rest,
            plant.spring_preload,
            gains.proportional,
            gains.integral,
            gains.derivative,
            gains.derivative_filter_time,
            1.0,
            0.0,
            1.0,
            0.0,
            1.0,
            0.0,
            machine.converters.position.unit(),
            plant.lower_stop,
            plant.upper_stop,
            limits.peak_current,
            limits.continuous_current,
            limits.supply[0],
            limits.supply[1],
            limits.load,
            limits.command_timeout,
            limits.current_limit,
            machine.motion.speed,
            machine.motion.position[0],
            machine.motion.position[1],
            0.0,
            0.0,
            BETA,
            BETA,
            NO_LIMIT,
            NO_LIMIT,
            0.0,
        ]);
        for (field, value) in values.iter() {
            field.check(value).map_err(|_| InvalidParameter {
                name: field.description().name,
                requirement: "must be within the bounds that the store has for it",
            })?;
        }
        Ok(values)
    }

    /// A field's value, SI.
    pub const fn get(&self, field: Field) -> f32 {
        self.0[field.index()]
    }

    /// Sets a field, SI.
    ///
    /// # Errors
    /// A value outside the field's bounds: the field keeps what it has.
    pub fn set(&mut self, field: Field, value: f32) -> Result<(), OutOfBounds> {
        self.0[field.index()] = field.check(value)?;
        Ok(())
    }

    /// All values, by number.
    pub const fn as_array(&self) -> &[f32; FIELDS] {
        &self.0
    }

    /// Every field and its value, by number.
    pub fn iter(&self) -> impl Iterator<Item = (Field, f32)> {
        Field::ALL.into_iter().zip(self.0)
    }

    /// The machine with these numbers in the place of its own. Of its converters the position's alone is
    /// another: gains and offsets of the sensors are the board's to apply, where it has the voltages.
    pub fn applied_to(&self, machine: &Machine) -> Machine {
        let mut machine = *machine;
        let plant = &mut machine.plant;
        plant.drive = Drive::Voltage {
            resistance: self.get(Field::Resistance),
            inductance: self.get(Field::Inductance),
            torque_constant: self.get(Field::TorqueConstant),
        };
        plant.inertia = self.get(Field::Inertia);
        plant.viscous = Directional::both(self.get(Field::Viscous));
        plant.coulomb = Directional::both(self.get(Field::Coulomb));
        plant.breakaway = Directional::both(self.get(Field::Static));
        plant.spring = self.get(Field::Spring);
        plant.spring_rest = self.get(Field::SpringRest);
        plant.spring_preload = self.get(Field::SpringPreload);
        plant.lower_stop = self.get(Field::LowerStop);
        plant.upper_stop = self.get(Field::UpperStop);
        let gains = &mut machine.position_loop;
        gains.proportional = self.get(Field::Proportional);
        gains.integral = self.get(Field::Integral);
        gains.derivative = self.get(Field::Derivative);
        gains.derivative_filter_time = self.get(Field::DerivativeFilterTime);
        let position = &mut machine.converters.position;
        *position = position.with_unit(self.get(Field::PositionUnit));
        let limits = &mut machine.limits;
        limits.peak_current = self.get(Field::PeakCurrent);
        limits.continuous_current = self.get(Field::ContinuousCurrent);
        limits.supply = [Field::SupplyMinimum, Field::SupplyMaximum].map(|field| self.get(field));
        limits.load = self.get(Field::Load);
        limits.command_timeout = self.get(Field::CommandTimeout);
        limits.current_limit = self.get(Field::CurrentLimit);
        machine.motion.speed = self.get(Field::SpeedLimit);
        machine.motion.position =
            [Field::PositionMinimum, Field::PositionMaximum].map(|field| self.get(field));
        machine
    }
}
