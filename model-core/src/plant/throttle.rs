//! A throttle body as an engine controller sees it: a motor behind an H-bridge, a plate on its
//! spring, two position tracks, and the faults that all of them may have.
//!
//! Everything that a fault needs is worked out when the throttle is built, so a fault begins and
//! ends between two steps of an interrupt: another set of modes where the winding is open or the
//! spring broken, another load where friction is raised or the plate jams. The state is carried
//! over, so the plate never jumps.

use super::actuator::{Actuator, INPUT_LIMIT, Load};
use super::bridge::{Bridge, Terminals};
use super::parameters::{Drive, ParameterError, Parameters};
use super::potentiometer::{Potentiometer, Track, TrackFault};
use super::{Directional, InputRefused, State};
use crate::numeric::invalid_parameter::{InvalidParameter, require};

/// What a throttle is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Motor, plate, spring and stops; the drive is a voltage, the gain 1.
    pub actuator: Parameters,
    /// The two tracks.
    pub tracks: [Track; 2],
    /// Drop of one diode of the bridge, V, 0 to 5.
    pub diode_drop: f32,
    /// Seed of the tracks' noise.
    pub seed: u64,
}

/// Friction of a plate that is jammed, N·m or N: more than any motor's.
const JAMMED: f32 = 1e6;

/// One of the two tracks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Side {
    /// The first.
    First,
    /// The second.
    Second,
}

/// What may befall a throttle. Faults of different parts may be there at once.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Fault {
    /// A track's.
    Track(Side, TrackFault),
    /// The plate stays where it is, whatever drives it.
    PlateJammed,
    /// No spring, no preload.
    SpringBroken,
    /// Static and Coulomb friction times this factor, 0 to 1000.
    FrictionRaised(f32),
    /// The winding carries no current.
    MotorOpen,
    /// A resistance, Ω, 1e-3 to 1, lies across the motor's terminals. The bridge feeds it alone:
    /// what it leaves of the supply is too little to count at the motor, whose winding is shorted.
    MotorShorted(f32),
}

impl Fault {
    fn check(self) -> Result<(), InvalidParameter> {
        match self {
            Self::Track(_, fault) => fault.check(),
            Self::FrictionRaised(factor) => require(
                (0.0..=1e3).contains(&factor),
                "friction factor",
                "must be 0 to 1000",
            ),
            Self::MotorShorted(resistance) => require(
                (1e-3..=1.0).contains(&resistance),
                "short's resistance",
                "must be 1e-3 to 1 ohm",
            ),
            Self::PlateJammed | Self::SpringBroken | Self::MotorOpen => Ok(()),
        }
    }
}

/// What is wrong with the motor's circuit.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Circuit {
    Sound,
    Open,
    Shorted(f32),
}

/// An actuator with its winding closed, and with its winding open.
#[derive(Debug, Clone, PartialEq)]
struct Mechanism {
    closed: Actuator,
    open: Actuator,
}

impl Mechanism {
    fn build(parameters: &Parameters, period: f32) -> Result<Self, ParameterError> {
        let open = Parameters {
            drive: Drive::Torque,
            gain: 1.0,
            ..*parameters
        };
        Ok(Self {
            closed: Actuator::build(parameters, period)?,
            open: Actuator::build(&open, period)?,
        })
    }
}

/// A throttle body in motion.
///
/// ```
/// use model_core::plant::bridge::Bridge;
/// use model_core::plant::parameters::{Drive, Parameters};
/// use model_core::plant::potentiometer::Track;
/// use model_core::plant::throttle::{Fault, Settings, Throttle};
/// use model_core::plant::Directional;
///
/// let settings = Settings {
///     actuator: Parameters {
///         drive: Drive::Voltage { resistance: 2.0, inductance: 1.2e-3, torque_constant: 0.38 },
///         gain: 1.0,
///         inertia: 1.6e-3,
///         viscous: Directional::both(8e-3),
///         coulomb: Directional::both(0.24),
///         breakaway: Directional::both(0.28),
///         spring: 0.25,
///         spring_rest: 0.2,
///         spring_preload: 0.3,
///         offset: 0.0,
///         lower_stop: 0.02,
///         upper_stop: 1.57,
///     },
///     tracks: [Track::rising(0.02, 1.57), Track::complementary(0.02, 1.57)],
///     diode_drop: 0.7,
///     seed: 1,
/// };
/// let mut throttle = Throttle::build(&settings, 50e-6)?;
/// for _ in 0..20_000 {
///     throttle.step(Bridge::Drive { duty: 1.0 }, 12.0)?;
/// }
/// assert_eq!(throttle.state().position.value(), 1.57);
/// assert!((throttle.tracks(5.0)[0] - 4.5).abs() < 1e-5);
/// // On its stop the winding's resistance alone is left: 12 V / 2 Ω.
/// assert!((throttle.current() - 6.0).abs() < 1e-4);
/// // Without power the spring takes it to its limp-home position.
/// for _ in 0..20_000 {
///     throttle.step(Bridge::Freewheel, 12.0)?;
/// }
/// assert_eq!(throttle.state().position.value(), 0.2);
/// throttle.inject(Fault::PlateJammed)?;
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Throttle {
    sound: Mechanism,
    springless: Mechanism,
    tracks: [Potentiometer; 2],
    diode_drop: f32,
    back_emf: f32,
    state: State,
    /// Friction as it is now.
    load: Load,
    /// What the bridge feeds, A.
    current: f32,
    spring_broken: bool,
    circuit: Circuit,
}

impl Throttle {
    /// A sound throttle at its limp-home position, for steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(settings: &Settings, period: f32) -> Result<Self, BuildError> {
        let parameters = &settings.actuator;
        let Drive::Voltage {
            torque_constant, ..
        } = parameters.drive
        else {
            return Err(refused("drive", "must be a voltage"));
        };
        let unity = parameters.gain == 1.0;
        require(unity, "gain", "must be 1: the bridge's output is in volts")?;
        let drop = settings.diode_drop;
        require(
            (0.0..=5.0).contains(&drop),
            "diode drop",
            "must be 0 to 5 V",
        )?;
        let springless = Parameters {
            spring: 0.0,
            spring_preload: 0.0,
            ..*parameters
        };
        let sound = Mechanism::build(parameters, period)?;
        let [first, second] = settings.tracks;
        Ok(Self {
            load: sound.closed.load(),
            sound,
            springless: Mechanism::build(&springless, period)?,
            tracks: [
                Potentiometer::build(first, settings.seed)?,
                Potentiometer::build(second, !settings.seed)?,
            ],
            diode_drop: drop,
            back_emf: torque_constant,
            state: State::new(parameters.spring_rest, 0.0),
            current: 0.0,
            spring_broken: false,
            circuit: Circuit::Sound,
        })
    }

    /// One step with bridge and supply, V, held over it.
    ///
    /// A current that ends in the step, with the switches off, is at zero at the step's end; the
    /// winding is open from the next step on.
    ///
    /// # Errors
    /// [`InputRefused`] for a duty that is not a number, or a supply that is not 0 to
    /// [`INPUT_LIMIT`]; the state is unchanged.
    #[inline]
    pub fn step(&mut self, bridge: Bridge, supply: f32) -> Result<(), InputRefused> {
        let fed = bridge.voltage(supply).unwrap_or(0.0);
        let accepted = (0.0..=INPUT_LIMIT).contains(&supply) && fed.is_finite();
        if !accepted {
            return Err(InputRefused);
        }
        let clamp = supply + 2.0 * self.diode_drop;
        let terminals = match self.circuit {
            Circuit::Sound => bridge.terminals(supply, clamp, &self.state, self.back_emf),
            Circuit::Open => Terminals::Open,
            Circuit::Shorted(_) => Terminals::At(0.0),
        };
        let mechanism = if self.spring_broken {
            &self.springless
        } else {
            &self.sound
        };
        // Whether no current is left at the end of the step.
        let mut ends = false;
        let (actuator, input) = match terminals {
            Terminals::At(voltage) => (&mechanism.closed, voltage),
            Terminals::Decaying(clamp) => {
                let ending = mechanism
                    .closed
                    .input_that_ends_current(&self.state, &self.load);
                ends = ending.abs() <= clamp;
                let voltage = if ends { ending } else { clamp.copysign(ending) };
                (&mechanism.closed, voltage)
            }
            Terminals::Open => {
                self.state.current = 0.0;
                (&mechanism.open, 0.0)
            }
        };
        actuator.step_under(&mut self.state, input, &self.load)?;
        if ends {
            // To the last bit: the winding is open from the next step on.
            self.state.current = 0.0;
        }
        self.current = match self.circuit {
            Circuit::Shorted(resistance) => fed / resistance,
            Circuit::Sound | Circuit::Open => self.state.current,
        };
        Ok(())
    }

    /// A reading of both tracks, V, with this reference, V. Each has its own noise, new in every
    /// reading.
    pub fn tracks(&mut self, reference: f32) -> [f32; 2] {
        self.shares().map(|share| share * reference)
    }

    /// The same as shares of the reference, which is what a ratiometric converter reads.
    #[inline]
    pub fn shares(&mut self) -> [f32; 2] {
        let position = self.state.position.value();
        let [first, second] = &mut self.tracks;
        [first.share(position), second.share(position)]
    }

    /// What the bridge feeds, A: the motor's current, or that of a short in its place.
    pub fn current(&self) -> f32 {
        self.current
    }

    /// Plate and winding.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// A fault from now on. It replaces one of the same part: of a track, of the spring, of the
    /// plate's friction, or of the motor's circuit.
    ///
    /// # Errors
    /// A number of the fault out of its range; nothing changes.
    pub fn inject(&mut self, fault: Fault) -> Result<(), InvalidParameter> {
        fault.check()?;
        match fault {
            Fault::Track(Side::First, fault) => self.tracks[0].set_fault(Some(fault)),
            Fault::Track(Side::Second, fault) => self.tracks[1].set_fault(Some(fault)),
            Fault::PlateJammed => {
                self.load.coulomb = Directional::both(JAMMED);
                self.load.breakaway = Directional::both(JAMMED);
            }
            Fault::SpringBroken => self.spring_broken = true,
            Fault::FrictionRaised(factor) => {
                let declared = self.sound.closed.load();
                self.load.coulomb = declared.coulomb.scaled(factor);
                self.load.breakaway = declared.breakaway.scaled(factor);
            }
            Fault::MotorOpen => self.circuit = Circuit::Open,
            Fault::MotorShorted(resistance) => self.circuit = Circuit::Shorted(resistance),
        }
        Ok(())
    }

    /// Ends every fault.
    pub fn heal(&mut self) {
        for track in &mut self.tracks {
            track.set_fault(None);
        }
        self.load = self.sound.closed.load();
        self.spring_broken = false;
        self.circuit = Circuit::Sound;
    }
}

/// Why a throttle cannot be built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum BuildError {
    /// A parameter of its motor, plate or spring.
    Actuator(ParameterError),
    /// Any other.
    Settings(InvalidParameter),
}

fn refused(name: &'static str, requirement: &'static str) -> BuildError {
    BuildError::Settings(InvalidParameter { name, requirement })
}

impl From<ParameterError> for BuildError {
    fn from(error: ParameterError) -> Self {
        Self::Actuator(error)
    }
}

impl From<InvalidParameter> for BuildError {
    fn from(error: InvalidParameter) -> Self {
        Self::Settings(error)
    }
}

impl core::fmt::Display for BuildError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Actuator(error) => error.fmt(formatter),
            Self::Settings(error) => error.fmt(formatter),
        }
    }
}

impl core::error::Error for BuildError {}
