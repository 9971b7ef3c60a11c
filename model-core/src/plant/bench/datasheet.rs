//! The bench's datasheets (bench paper, Tables 2.1 to 2.8) in SI units.
//!
//! Left out is what no equation of the model takes: weights, dimensions, supplies and processors,
//! with them the whole of Tables 2.2 (the controller's PC) and 2.3 (the control unit).

use core::f32::consts::PI;

/// rad/s of a turn a minute.
const TURN_A_MINUTE: f32 = PI / 30.0;

/// The motor: Simotics 1FK7060-2AC71 (Table 2.1).
pub mod motor {
    use super::TURN_A_MINUTE;

    /// Inertia of the rotor, kg·m²: 7.700 kg·cm².
    pub const INERTIA: f32 = 7.7e-4;
    /// Pairs of poles: 8 poles.
    pub const POLE_PAIRS: u8 = 4;
    /// Speed at the rated torque, rad/s: 2000 1/min.
    pub const RATED_SPEED: f32 = 2000.0 * TURN_A_MINUTE;
    /// Torque at the rated speed, N·m.
    pub const RATED_TORQUE: f32 = 5.3;
    /// Current at the rated torque, A rms.
    pub const RATED_CURRENT: f32 = 3.0;
    /// N·m per A rms.
    pub const TORQUE_CONSTANT: f32 = 1.91;
    /// Open-circuit voltage between two terminals at 20 °C, V rms per rad/s: 121.0 V at 1000 1/min.
    pub const VOLTAGE_CONSTANT: f32 = 121.0 / (1000.0 * TURN_A_MINUTE);
    /// Resistance of a phase at 20 °C, Ω.
    pub const RESISTANCE: f32 = 2.75;
    /// Rotating field inductance: what a phase of three symmetric currents has, H.
    pub const INDUCTANCE: f32 = 30.5e-3;
    /// Inductance over resistance, s.
    pub const ELECTRICAL_TIME_CONSTANT: f32 = 11.1e-3;
    /// Three resistances times the inertia over the torque constant squared, s.
    pub const MECHANICAL_TIME_CONSTANT: f32 = 1.75e-3;
    /// Highest speed by the inverter, rad/s: 4750 1/min.
    pub const INVERTER_SPEED: f32 = 4750.0 * TURN_A_MINUTE;
    /// Highest torque, N·m.
    pub const MAXIMUM_TORQUE: f32 = 18.0;
    /// Highest current, A rms.
    pub const MAXIMUM_CURRENT: f32 = 10.7;
}

/// The inverter: PM240-2 Blocksize (Table 2.4).
pub mod inverter {
    /// Between two lines of the supply, V rms.
    pub const LINE_VOLTAGE: f32 = 380.0;
    /// Of the real inverter's pulses, Hz; the model's hysteresis has none of its own.
    pub const PULSE_FREQUENCY: f32 = 4000.0;
}

/// The gearbox: Tramec REP100/3C (Table 2.5).
pub mod gearbox {
    /// Turns of the motor for one of the slow shaft.
    pub const RATIO: f32 = 120.0;
    /// Inertia at the input shaft, kg·m²: 0.59 kg·cm².
    pub const INERTIA: f32 = 0.59e-4;
    /// Its own backlash at the most, rad of the slow shaft: 8 arcmin.
    pub const BACKLASH: f32 = 8.0 / 60.0 * (core::f32::consts::PI / 180.0);
}

/// The encoder: Italsensor TSW581HS (Table 2.6), and the gears that drive it.
pub mod encoder {
    /// Counts a turn: 10 000 pulses, of which the edges of both channels count (section 2.1.6).
    pub const COUNTS_PER_TURN: u16 = 40_000;
    /// Turns for one of the slow shaft: the gears' 62/15 (section 5.2).
    pub const GEAR_RATIO: f32 = 62.0 / 15.0;
    /// Torque that starts it at 25 °C, N·m.
    pub const STARTING_TORQUE: f32 = 0.025;
    /// Inertia, kg·m²: 40 g·cm².
    pub const INERTIA: f32 = 4e-6;
}

/// The brake: its servo, a SAVOX SC-0254MG (Table 2.7), its chain (Table 2.8) and its load cell.
pub mod brake {
    /// Torque of the servo at 6 V, N·m: 7.2 kg·cm.
    pub const SERVO_TORQUE: f32 = 0.072 * GRAVITY;
    /// Speed of the servo at 6 V, rad/s: 60° in 0.14 s.
    pub const SERVO_SPEED: f32 = core::f32::consts::PI / 3.0 / 0.14;
    /// Teeth of the driving sprocket.
    pub const DRIVING_TEETH: u8 = 23;
    /// Teeth of the driven sprocket.
    pub const DRIVEN_TEETH: u8 = 34;
    /// From the plate's axis to the load cell, m (section 5.1).
    pub const LEVER_ARM: f32 = 0.233;
    /// m/s²: rounded as Table 5.1 has it.
    pub const GRAVITY: f32 = 9.81;
}
