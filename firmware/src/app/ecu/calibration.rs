//! What an engine controller is told of its throttle body: nominal numbers, in its own units.
//!
//! Positions are shares of the stroke, 0 at the closed stop and 1 at the open one; torques are the
//! motor currents that balance them.

use model_core::control::pid;
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::Drive;
use model_core::plant::potentiometer::{REFERENCE, Track};

use crate::app::conversion::Converter;
use crate::app::machine::{FULL_DUTY, Machine};
use crate::app::timing::CONTROL_PERIOD;

/// Sensor of the supply: 12 bits behind a divider by four.
pub const SUPPLY: Converter = Converter::new(4.0 * REFERENCE / 4095.0, 4095);

/// The bridge's duty, in shares of the supply.
pub const DUTY: Converter = Converter::new(1.0 / FULL_DUTY as f32, FULL_DUTY);

/// Nominal numbers of a throttle body and of its controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Where both tracks' lines have the two stops.
    pub ends: [Ends; 2],
    /// Share of the stroke at which the spring is at rest.
    pub limp_home: f32,
    /// Current sensor, A.
    pub current: Converter,
    /// Resistance of the winding, Ω.
    pub resistance: f32,
    /// Back-EMF, V for one stroke a second.
    pub back_emf: f32,
    /// Current that takes the plate through Coulomb friction, A.
    pub friction: f32,
    /// Current that balances the spring's preload, A.
    pub preload: f32,
    /// Current that balances the spring, A for the stroke.
    pub spring: f32,
    /// Current that balances viscous friction, A for one stroke a second.
    pub viscous: f32,
    /// Current that accelerates the plate, A for one stroke a second in a second.
    pub inertia: f32,
    /// Voltage that surely closes the plate, V, below 0.
    pub closing: f32,
    /// Voltage that surely opens it, V.
    pub opening: f32,
    /// The position loop: share of the stroke to V.
    pub position_loop: pid::Coefficients,
}

/// What a track reads at the two stops, as shares of the reference.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ends {
    /// At the closed stop.
    pub closed: f32,
    /// At the open stop.
    pub open: f32,
}

impl Ends {
    /// Share of the stroke at which the track reads this share of the reference.
    pub fn position(&self, share: f32) -> f32 {
        (share - self.closed) / (self.open - self.closed)
    }
}

/// What surely moves the plate, over what balances the most that holds it.
const SURELY: f32 = 1.4;

impl Calibration {
    /// Of a throttle with two stops, from what its drive believes it to be.
    ///
    /// # Errors
    /// A drive that is no voltage, a stroke that is not finite, a track that reads the same at both
    /// stops, or a loop out of its range.
    pub fn new(machine: &Machine, tracks: &[Track; 2]) -> Result<Self, InvalidParameter> {
        let plant = &machine.plant;
        let refused = |name, requirement| Err(InvalidParameter { name, requirement });
        let Drive::Voltage {
            resistance,
            torque_constant,
            ..
        } = plant.drive
        else {
            return refused("drive", "must be a voltage");
        };
        let stroke = plant.upper_stop - plant.lower_stop;
        if !stroke.is_finite() {
            return refused("stops", "must both be finite");
        }
        let gains = pid::Parameters {
            proportional: machine.position_loop.proportional * stroke,
            integral: machine.position_loop.integral * stroke,
            derivative: machine.position_loop.derivative * stroke,
            ..machine.position_loop
        };
        let ends = |track: &Track| Ends {
            closed: track.share(plant.lower_stop),
            open: track.share(plant.upper_stop),
        };
        let ends = [ends(&tracks[0]), ends(&tracks[1])];
        if ends.iter().any(|ends| ends.closed == ends.open) {
            return refused("tracks", "must each read another voltage at either stop");
        }
        let held = plant.breakaway.forward + plant.spring_preload;
        let volts = |torque: f32| SURELY * torque * resistance / torque_constant;
        Ok(Self {
            ends,
            limp_home: (plant.spring_rest - plant.lower_stop) / stroke,
            current: machine.converters.current,
            resistance,
            back_emf: torque_constant * stroke,
            friction: plant.coulomb.forward / torque_constant,
            preload: plant.spring_preload / torque_constant,
            spring: plant.spring * stroke / torque_constant,
            viscous: plant.viscous.forward * stroke / torque_constant,
            inertia: plant.inertia * stroke / torque_constant,
            closing: -volts(held + plant.spring * (plant.spring_rest - plant.lower_stop)),
            opening: volts(held + plant.spring * (plant.upper_stop - plant.spring_rest)),
            position_loop: gains.build(CONTROL_PERIOD)?,
        })
    }
}
