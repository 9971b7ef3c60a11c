//! The units that loggers write, as factors to SI units.

use std::f64::consts::{PI, TAU};

use crate::log::median;

/// Slowest step that a drive is logged with, s: a larger one is in another unit.
const SLOWEST_S: f64 = 0.1;

/// What a unit measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Time,
    Angle,
    Length,
    AngularVelocity,
    LinearVelocity,
    Voltage,
    Current,
    Torque,
    Force,
    /// A part of a whole: a duty.
    Share,
    /// Numbers of a converter or a counter.
    Counts,
}

impl Kind {
    /// Whether it is one of motion along a stroke, or else of motion about an axis; neither where nothing moves in it.
    pub fn is_linear(self) -> Option<bool> {
        match self {
            Self::Length | Self::LinearVelocity => Some(true),
            Self::Angle | Self::AngularVelocity => Some(false),
            _ => None,
        }
    }
}

/// A unit with its factor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Unit {
    /// What it measures.
    pub kind: Kind,
    /// SI units in one of it.
    pub factor: f64,
}

const DEGREE: f64 = PI / 180.0;
const RPM: f64 = TAU / 60.0;

/// Every known unit with its spellings. The first spelling is the one that is printed.
const UNITS: [(&[&str], Kind, f64); 48] = [
    (&["s", "sec"], Kind::Time, 1.0),
    (&["ms", "msec"], Kind::Time, 1e-3),
    (&["us", "µs", "μs", "usec"], Kind::Time, 1e-6),
    (&["ns"], Kind::Time, 1e-9),
    (&["min"], Kind::Time, 60.0),
    (&["h"], Kind::Time, 3_600.0),
    (&["day", "days"], Kind::Time, 86_400.0),
    (&["rad"], Kind::Angle, 1.0),
    (&["mrad"], Kind::Angle, 1e-3),
    (&["deg", "°", "degrees"], Kind::Angle, DEGREE),
    (&["rev", "turn", "turns", "revolutions"], Kind::Angle, TAU),
    (&["m"], Kind::Length, 1.0),
    (&["mm"], Kind::Length, 1e-3),
    (&["cm"], Kind::Length, 1e-2),
    (&["um", "µm", "μm"], Kind::Length, 1e-6),
    (&["in", "inch"], Kind::Length, 0.0254),
    (&["rad/s"], Kind::AngularVelocity, 1.0),
    (
        &["rpm", "1/min", "rev/min", "U/min"],
        Kind::AngularVelocity,
        RPM,
    ),
    (&["deg/s", "°/s"], Kind::AngularVelocity, DEGREE),
    (&["rev/s", "rps", "turns/s"], Kind::AngularVelocity, TAU),
    (&["mrad/s"], Kind::AngularVelocity, 1e-3),
    (&["m/s"], Kind::LinearVelocity, 1.0),
    (&["mm/s"], Kind::LinearVelocity, 1e-3),
    (&["cm/s"], Kind::LinearVelocity, 1e-2),
    (&["m/min"], Kind::LinearVelocity, 1.0 / 60.0),
    (&["mm/min"], Kind::LinearVelocity, 1e-3 / 60.0),
    (&["V"], Kind::Voltage, 1.0),
    (&["mV"], Kind::Voltage, 1e-3),
    (&["kV"], Kind::Voltage, 1e3),
    (&["A"], Kind::Current, 1.0),
    (&["mA"], Kind::Current, 1e-3),
    (&["uA", "µA", "μA"], Kind::Current, 1e-6),
    (&["N·m", "Nm", "N.m", "N*m", "N-m"], Kind::Torque, 1.0),
    (&["mN·m", "mNm", "mN.m"], Kind::Torque, 1e-3),
    (&["N·cm", "Ncm", "N.cm"], Kind::Torque, 1e-2),
    (&["kN·m", "kNm", "kN.m"], Kind::Torque, 1e3),
    (&["kgf·cm", "kgfcm", "kgf.cm"], Kind::Torque, 0.098_066_5),
    // An ounce of force, 0.278013851 N, on an inch.
    (&["oz·in", "ozin", "oz.in"], Kind::Torque, 0.007_061_551_8),
    (&["N"], Kind::Force, 1.0),
    (&["mN"], Kind::Force, 1e-3),
    (&["kN"], Kind::Force, 1e3),
    (&["kgf"], Kind::Force, 9.806_65),
    (&["%", "percent", "pct"], Kind::Share, 1e-2),
    (&["permille", "‰"], Kind::Share, 1e-3),
    (&["duty", "pu"], Kind::Share, 1.0),
    (
        &["counts", "count", "cnt", "ticks", "lsb"],
        Kind::Counts,
        1.0,
    ),
    (&["g·cm", "gf·cm"], Kind::Torque, 9.806_65e-5),
    (&["lbf"], Kind::Force, 4.448_221_615_260_5),
];

/// Counts of an encoder, as `counts/4096`: so many to a turn.
const PER_TURN: &str = "counts/";

/// What a unit of a voltage or a current in lower case can only be, for `ma` and `mv` are nothing else. Capitals stay what they
/// are: `MV` would be a million volts.
fn as_written(text: &str) -> &str {
    match text {
        "v" => "V",
        "mv" => "mV",
        "kv" => "kV",
        "a" => "A",
        "ma" => "mA",
        "ua" => "uA",
        other => other,
    }
}

impl Unit {
    /// The unit of this spelling. Case counts where it must (mV, MV), and is forgiven where nothing else
    /// can be meant.
    pub fn find(text: &str) -> Option<Self> {
        let known = |spelled: fn(&str, &str) -> bool| {
            let mut units = UNITS.iter();
            let found = units.find(|(names, _, _)| names.iter().any(|name| spelled(name, text)));
            found.map(|&(_, kind, factor)| Self { kind, factor })
        };
        known(|name, text| name == text)
            .or_else(|| known(|name, text| name.len() > 2 && name.eq_ignore_ascii_case(text)))
            .or_else(|| known(|name, text| name == as_written(text)))
            .or_else(|| Self::per_turn(text))
    }

    /// Whether it says nothing without a factor: a share of something, counts of some size.
    pub fn needs_size(&self) -> bool {
        matches!(self.kind, Kind::Share | Kind::Counts)
    }

    fn per_turn(text: &str) -> Option<Self> {
        let counts: f64 = text.strip_prefix(PER_TURN)?.parse().ok()?;
        (counts.is_finite() && counts > 0.0).then_some(Self {
            kind: Kind::Angle,
            factor: TAU / counts,
        })
    }

    /// The spellings of the units of these kinds, for messages.
    pub fn known(kinds: &[Kind]) -> String {
        let mut names: Vec<&str> = UNITS
            .iter()
            .filter(|(_, kind, _)| kinds.contains(kind))
            .map(|(names, _, _)| names[0])
            .collect();
        if kinds.contains(&Kind::Angle) {
            names.push("counts/4096 (so many a turn)");
        }
        names.join(", ")
    }
}

/// What the units of a column of the log may measure, in the order of the log's columns.
pub(super) fn kinds(column: &str) -> &'static [Kind] {
    match column {
        "time_s" => &[Kind::Time],
        "position" | "command" => &[Kind::Angle, Kind::Length, Kind::Counts],
        "current_a" => &[Kind::Current, Kind::Counts],
        "velocity" => &[Kind::AngularVelocity, Kind::LinearVelocity, Kind::Counts],
        "brake" | "load_torque" => &[Kind::Torque, Kind::Force, Kind::Counts],
        "enabled" => &[],
        _ => &[
            Kind::Voltage,
            Kind::Current,
            Kind::Torque,
            Kind::Force,
            Kind::Share,
            Kind::Counts,
        ],
    }
}

/// The unit of stamps that step too widely for seconds, with their usual step.
pub(crate) fn unit_of_time(stamps: &[f64]) -> Option<(f64, &'static str)> {
    let steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.is_empty() {
        return None;
    }
    let step = median(&steps);
    Some((step, unit_of_step(step)?))
}

/// The unit of a step that is too wide for seconds.
pub(crate) fn unit_of_step(step: f64) -> Option<&'static str> {
    match step {
        _ if step.is_nan() || step <= SLOWEST_S => None,
        _ if step <= 1e3 * SLOWEST_S => Some("ms"),
        _ if step <= 1e6 * SLOWEST_S => Some("us"),
        _ => Some("ns"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::disagreement::units;

    #[test]
    fn factors_are_those_of_the_definitions() {
        for (name, factor) in [
            ("ms", 1e-3),
            ("µs", 1e-6),
            ("deg", PI / 180.0),
            ("rev", TAU),
            ("counts/4096", TAU / 4096.0),
            ("rpm", TAU / 60.0),
            ("mN·m", 1e-3),
            ("%", 1e-2),
            ("V", 1.0),
            ("DEG", PI / 180.0),
            ("ma", 1e-3),
            ("mv", 1e-3),
            ("a", 1.0),
            ("v", 1.0),
        ] {
            assert_eq!(
                Unit::find(name).map(|unit| unit.factor),
                Some(factor),
                "{name}"
            );
        }
        for name in ["", "furlong", "MV", "counts/0", "counts/-3", "counts/x"] {
            assert_eq!(Unit::find(name), None, "{name}");
        }
    }

    /// What is printed as a remedy is understood, with the same factor.
    #[test]
    fn the_units_of_the_remedies_are_known() {
        let all = units::ANGLES.iter().chain(&units::STROKES);
        let all = all.chain(&units::ANGULAR_VELOCITIES);
        let all = all.chain(&units::LINEAR_VELOCITIES).chain(&units::TIMES);
        for unit in all {
            let found = Unit::find(unit.import).map(|unit| unit.factor);
            assert!(
                found.is_some_and(|factor| (factor / unit.factor - 1.0).abs() < 1e-12),
                "{}: {found:?}",
                unit.import
            );
        }
    }
}
