//! The units that logs and data sheets come in, as factors to the SI units of the contract.

use std::f64::consts::{PI, TAU};

/// A unit that may have been taken for the expected one.
#[derive(Debug, Clone, Copy)]
pub struct Unit {
    /// Its name in a sentence.
    pub name: &'static str,
    /// Its name for `cargo hil import`; empty where a factor has to be written.
    pub import: &'static str,
    /// The expected unit's worth of one of it.
    pub factor: f64,
    /// How unusual it is, nats: breaks ties.
    pub rarity: f64,
}

const fn unit(name: &'static str, import: &'static str, factor: f64, rarity: f64) -> Unit {
    Unit {
        name,
        import,
        factor,
        rarity,
    }
}

const DEGREE: f64 = PI / 180.0;
const RPM: f64 = TAU / 60.0;

/// Angles.
pub const ANGLES: [Unit; 3] = [
    unit("degrees", "deg", DEGREE, 0.0),
    unit("revolutions", "rev", TAU, 1.0),
    unit("milliradians", "mrad", 1e-3, 2.0),
];

/// Strokes.
pub const STROKES: [Unit; 4] = [
    unit("millimetres", "mm", 1e-3, 0.0),
    unit("micrometres", "um", 1e-6, 1.0),
    unit("centimetres", "cm", 1e-2, 1.0),
    unit("inches", "in", 0.0254, 2.0),
];

/// Velocities at an angle.
pub const ANGULAR_VELOCITIES: [Unit; 3] = [
    unit("rpm", "rpm", RPM, 0.0),
    unit("degrees per second", "deg/s", DEGREE, 0.0),
    unit("revolutions per second", "rev/s", TAU, 1.0),
];

/// Velocities along a stroke.
pub const LINEAR_VELOCITIES: [Unit; 3] = [
    unit("millimetres per second", "mm/s", 1e-3, 0.0),
    unit("centimetres per second", "cm/s", 1e-2, 1.0),
    unit("metres per minute", "m/min", 1.0 / 60.0, 1.0),
];

/// Times.
pub const TIMES: [Unit; 2] = [
    unit("milliseconds", "ms", 1e-3, 0.0),
    unit("microseconds", "us", 1e-6, 0.5),
];

/// An input.
pub const MILLIVOLTS: Unit = unit("millivolts", "mV", 1e-3, 0.0);

/// An input that is no voltage.
pub const THOUSANDTHS: Unit = unit("thousandths of its unit", "", 1e-3, 0.0);

/// A current.
pub const MILLIAMPERES: Unit = unit("milliamperes", "mA", 1e-3, 0.0);

/// Volts that a supply is likely to have: what a duty of one, or of 100 %, stands for.
pub const SUPPLIES: [f64; 12] = [
    5.0, 6.0, 7.4, 9.0, 12.0, 15.0, 18.0, 24.0, 28.0, 36.0, 48.0, 72.0,
];

/// The largest of them.
pub const LARGEST_SUPPLY: f64 = SUPPLIES[SUPPLIES.len() - 1];

/// Full scale of a PWM's counter of 8, 10, 12 or 16 bits: the least that holds such counts.
pub fn full_scale(largest: f64) -> Option<f64> {
    let scales = [8, 10, 12, 16].map(|bits| f64::from((1_u32 << bits) - 1));
    scales.into_iter().find(|scale| largest <= *scale)
}

/// Counts a turn of common encoders: lines of incremental ones, four times as many edges, and powers of two.
pub const COUNTS_A_TURN: [f64; 20] = [
    256.0, 360.0, 400.0, 500.0, 512.0, 1000.0, 1024.0, 1440.0, 2000.0, 2048.0, 2500.0, 3600.0,
    4000.0, 4096.0, 8192.0, 10_000.0, 16_384.0, 20_000.0, 65_536.0, 131_072.0,
];

/// Lengths of a turn at which a reading starts again: in rad, deg, rev, and counts of 8 to 20 bits.
pub fn wraps() -> impl Iterator<Item = f64> {
    let counts = (8..=20).map(|bits| f64::from(1 << bits));
    [TAU, 360.0, 1.0, 400.0, PI, 180.0]
        .into_iter()
        .chain(counts)
}

const MILLI: f64 = 1e-3;

/// Units in which data sheets give a number of the machine file.
pub fn of_number(name: &str, rotary: bool) -> &'static [Unit] {
    const INERTIA: [Unit; 6] = [
        unit("g·cm²", "", 1e-7, 0.0),
        unit("kg·cm²", "", 1e-4, 0.0),
        unit("kg·mm²", "", 1e-6, 1.0),
        unit("g·mm²", "", 1e-9, 1.0),
        unit("oz·in²", "", 1.829e-5, 1.0),
        unit("oz·in·s²", "", 7.062e-3, 1.0),
    ];
    const MASS: [Unit; 2] = [unit("g", "", MILLI, 0.0), unit("t", "", 1e3, 1.0)];
    const TORQUE: [Unit; 4] = [
        unit("mN·m", "", MILLI, 0.0),
        unit("N·cm", "", 1e-2, 0.5),
        unit("oz·in", "", 7.062e-3, 1.0),
        unit("kgf·cm", "", 0.0981, 1.0),
    ];
    const FORCE: [Unit; 3] = [
        unit("mN", "", MILLI, 0.0),
        unit("kN", "", 1e3, 0.0),
        unit("kgf", "", 9.81, 1.0),
    ];
    const ROTARY_VISCOUS: [Unit; 4] = [
        unit("mN·m·s/rad", "", MILLI, 0.0),
        unit("N·m/rpm", "", 1.0 / RPM, 1.0),
        unit("mN·m/rpm", "", MILLI / RPM, 0.0),
        unit("N·m·s/deg", "", 1.0 / DEGREE, 1.0),
    ];
    const LINEAR_VISCOUS: [Unit; 2] =
        [unit("N·s/mm", "", 1e3, 0.0), unit("mN·s/m", "", MILLI, 1.0)];
    const ROTARY_SPRING: [Unit; 2] = [
        unit("mN·m/rad", "", MILLI, 0.0),
        unit("N·m/deg", "", 1.0 / DEGREE, 0.0),
    ];
    const LINEAR_SPRING: [Unit; 2] = [unit("N/mm", "", 1e3, 0.0), unit("mN/m", "", MILLI, 1.0)];
    const ROTARY_CONSTANT: [Unit; 4] = [
        unit("mN·m/A", "", MILLI, 0.0),
        unit("V/krpm", "", MILLI / RPM, 0.0),
        unit("N·cm/A", "", 1e-2, 0.5),
        unit("V/rpm", "", 1.0 / RPM, 1.0),
    ];
    const LINEAR_CONSTANT: [Unit; 1] = [unit("mN/A", "", MILLI, 0.0)];
    const RESISTANCE: [Unit; 2] = [unit("mΩ", "", MILLI, 0.0), unit("kΩ", "", 1e3, 1.0)];
    const INDUCTANCE: [Unit; 2] = [unit("mH", "", MILLI, 0.0), unit("µH", "", 1e-6, 0.0)];
    match (name, rotary) {
        ("inertia", true) => &INERTIA,
        ("inertia", false) => &MASS,
        ("coulomb" | "static" | "spring_preload" | "gravity_torque", true) => &TORQUE,
        ("coulomb" | "static" | "spring_preload", false) => &FORCE,
        ("viscous", true) => &ROTARY_VISCOUS,
        ("viscous", false) => &LINEAR_VISCOUS,
        ("spring", true) => &ROTARY_SPRING,
        ("spring", false) => &LINEAR_SPRING,
        ("torque_constant", true) => &ROTARY_CONSTANT,
        ("torque_constant", false) => &LINEAR_CONSTANT,
        ("resistance", _) => &RESISTANCE,
        ("inductance", _) => &INDUCTANCE,
        _ => &[],
    }
}
