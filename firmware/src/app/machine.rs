//! The actuators, as their drives believe them to be: numbers, sensors, bridge and position loop.

use model_core::control::pid;
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};

use super::conversion::{Converter, Converters};
use super::fault::monitor::Limits;
use super::operation::motion_limit::{self, NO_POSITION};

/// An actuator with all that its drive knows of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// Motor, mechanics and friction.
    pub plant: Parameters,
    /// Sensors and bridge.
    pub converters: Converters,
    /// The position loop: rad to V.
    pub position_loop: pid::Parameters,
    /// Where it rests before the first command, rad.
    pub rest: f32,
    /// What it bears.
    pub limits: Limits,
    /// What its motion is kept within.
    pub motion: motion_limit::Limits,
}

/// No limits: where the position is 0 is not known before somebody says so.
const UNLIMITED: motion_limit::Limits = motion_limit::Limits {
    speed: 0.0,
    position: [-NO_POSITION, NO_POSITION],
};

/// Counts of the timer behind a bridge at full duty: 168 MHz, centre-aligned at 20 kHz.
pub const FULL_DUTY: i16 = 4200;

/// Counts of a 12-bit converter on either side of its middle.
const HALF_SCALE: i16 = 2047;

/// How long commands are driven without another one, s, before something else is set: for a person who looks
/// on. A program that commands sends more often and sets less.
const COMMAND_TIMEOUT: f32 = 60.0;

/// Supply of the actuator's bridge, V.
const EMA_SUPPLY: f32 = 24.0;

/// A small 24 V brushed-DC actuator, referred to its output shaft: what `ema-24v.toml` among the
/// host's machine files declares. The encoder has 4096 lines, counted at every edge; the shunt's
/// amplifier spans 25 A either way.
///
/// Beyond 1/33 ms, the corner of the mechanical time constant J R / k², the voltage accelerates the rotor, so the
/// loop's derivative has to give the phase at the crossover, 130 1/s with these numbers and 80 to 260 1/s within the
/// tolerances. It is not filtered: a filter of four periods, with its corner at 250 1/s, takes most of that phase away, and
/// the loop swings at 55 to 75 Hz on a lighter rotor with a winding of less resistance. One count of the encoder is
/// K_d / h · 0.38 mrad = 0.08 V, of the 2.5 V that break the rotor away. With that derivative the proportional gain is the
/// largest, in steps of 2 V/rad, that keeps the greatest sensitivity |1/(1 + L)| at 2 or less with every resistance,
/// inductance, torque constant, inertia and damping within
/// [`Tolerances::INDUSTRIAL`](super::fault::observer::Tolerances::INDUSTRIAL): it is 1.95, the phase margin 35°, and 24
/// V/rad has 2.01 (`cargo test --test firmware position_loop:: -- --nocapture` prints both). At 2 the gain may double, or
/// the phase lag by 29° more (Åström and Murray, *Feedback Systems*, section 10.3). The integral is slow beside that,
/// K_i / K_p = 5 1/s. The actuator may rest wherever friction holds it, at most breakaway · R / (k K_p) = 114 mrad off; what
/// the integral does about that within one hold is left at that.
///
/// The peak current lies above the 24 A that the supply drives through the winding and below the 25 A of
/// the amplifier; the drive lets 20 A flow, as the bridge is one of 20 A. The winding bears 6 A for ever and the peak for a second. What these make beyond friction,
/// 0.06 N·m/A · 6 A − 0.12 N·m, is the load: what it can hold for ever it may have to. The supply is that of an
/// industrial 24 V, −25 and +25 %; the capacitors bear 35 V, the gate drivers switch from 8 V up.
pub const EMA: Machine = Machine {
    plant: Parameters {
        drive: Drive::Voltage {
            resistance: 1.0,
            inductance: 1.0e-3,
            torque_constant: 0.06,
        },
        gain: 1.0,
        inertia: 1.2e-4,
        viscous: Directional::both(2.0e-4),
        coulomb: Directional::both(0.12),
        breakaway: Directional::both(0.15),
        spring: 0.0,
        spring_rest: 0.0,
        spring_preload: 0.0,
        offset: 0.0,
        lower_stop: -1.0,
        upper_stop: 1.0,
    },
    converters: Converters {
        position: Converter::new(core::f32::consts::TAU / 16384.0, i16::MAX),
        current: Converter::new(25.0 / 2048.0, HALF_SCALE),
        bridge: Converter::new(EMA_SUPPLY / FULL_DUTY as f32, FULL_DUTY),
    },
    position_loop: pid::Parameters {
        proportional: 22.0,
        integral: 110.0,
        derivative: 0.2,
        derivative_filter_time: 0.0,
        set_point_weight: 1.0,
        derivative_set_point_weight: 0.0,
        output_minimum: -EMA_SUPPLY,
        output_maximum: EMA_SUPPLY,
        anti_windup: pid::AntiWindup::ConditionalIntegration,
    },
    rest: 0.0,
    limits: Limits {
        peak_current: 24.5,
        continuous_current: 6.0,
        current_limit: 20.0,
        peak_time: 1.0,
        load: 0.24,
        supply: [18.0, 30.0],
        supply_time: 5e-3,
        command_timeout: COMMAND_TIMEOUT,
    },
    motion: UNLIMITED,
};

/// Supply of the throttle's bridge, V.
const THROTTLE_SUPPLY: f32 = 12.0;

/// A 12 V throttle body, referred to its plate: what `throttle-12v.toml` declares. A return spring
/// holds the plate at its limp-home position by a preload to either side; a stop at either end. The
/// position is read from a potentiometer by a 12-bit converter over 1.64 rad.
///
/// The loop's derivative cancels the mechanical time constant J R / k² = 22 ms, which leaves an integrator with a
/// crossover of 66 1/s, far below the corners of filter and winding: within the tolerances the greatest sensitivity is
/// 1.46. Its load, by the actuator's rule, is what 3 A make beyond friction and preload.
pub const THROTTLE: Machine = Machine {
    plant: Parameters {
        drive: Drive::Voltage {
            resistance: 2.0,
            inductance: 1.2e-3,
            torque_constant: 0.38,
        },
        gain: 1.0,
        inertia: 1.6e-3,
        viscous: Directional::both(8.0e-3),
        coulomb: Directional::both(0.24),
        breakaway: Directional::both(0.28),
        spring: 0.25,
        spring_rest: 0.2,
        spring_preload: 0.3,
        offset: 0.0,
        lower_stop: 0.02,
        upper_stop: 1.57,
    },
    converters: Converters {
        position: Converter::new(4.0e-4, 4095),
        current: Converter::new(10.0 / 2048.0, HALF_SCALE),
        bridge: Converter::new(THROTTLE_SUPPLY / FULL_DUTY as f32, FULL_DUTY),
    },
    position_loop: pid::Parameters {
        proportional: 25.0,
        integral: 100.0,
        derivative: 0.5,
        derivative_filter_time: 4.0e-3,
        set_point_weight: 1.0,
        derivative_set_point_weight: 0.0,
        output_minimum: -THROTTLE_SUPPLY,
        output_maximum: THROTTLE_SUPPLY,
        anti_windup: pid::AntiWindup::ConditionalIntegration,
    },
    rest: 0.2,
    limits: Limits {
        peak_current: 8.0,
        continuous_current: 3.0,
        current_limit: 6.0,
        peak_time: 1.0,
        load: 0.6,
        supply: [8.0, 16.0],
        supply_time: 5e-3,
        command_timeout: COMMAND_TIMEOUT,
    },
    motion: UNLIMITED,
};
