//! The paper's data sheets and rules against each other.

use std::f64::consts::{PI, TAU};

use super::section::{Part, Section};
use crate::cells::{Cells, row};
use crate::failure::Failure;
use crate::reproduce::entry;

/// A printed number beside what other printed numbers make of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Check {
    /// What it is, and where it is printed.
    pub what: &'static str,
    /// As printed.
    pub printed: f64,
    /// By what formula from which numbers.
    pub from: &'static str,
    /// What that gives.
    pub found: f64,
    /// Its unit.
    pub unit: &'static str,
}

// Table 2.1.
const INERTIA: f64 = 7.7e-4;
const RESISTANCE: f64 = 2.75;
const INDUCTANCE: f64 = 30.5e-3;
const TORQUE_CONSTANT: f64 = 1.91;
const VOLTS_PER_1000_RPM: f64 = 121.0;
const RATED: (f64, f64) = (5.3, 3.0);
const MAXIMUM: (f64, f64) = (18.0, 10.7);
const OPTIMUM_RPM: f64 = 2000.0;
// Table 2.8: diameter, mm, and teeth.
const DRIVING: (f64, f64) = (90.0, 23.0);
const DRIVEN: (f64, f64) = (142.0, 34.0);
// Table 6.2: layer height and nozzle diameter, mm.
const REDUCER_GEAR: (f64, f64) = (0.2, 0.4);
const ENCODER_GEAR: (f64, f64) = (0.12, 0.25);

/// Pitch of a chain of half an inch, mm.
const CHAIN_PITCH_MM: f64 = 12.7;

/// Pitch diameter of a sprocket, mm.
fn pitch_diameter(pitch: f64, teeth: f64) -> f64 {
    pitch / (PI / teeth).sin()
}

/// Every check.
pub fn checks() -> Vec<Check> {
    let check = |what, printed, from, found, unit| Check {
        what,
        printed,
        from,
        found,
        unit,
    };
    let voltage_constant = VOLTS_PER_1000_RPM / (1000.0 * TAU / 60.0);
    let rule = |(height, nozzle): (f64, f64)| 0.2 * height + 0.5 * nozzle;
    let exchanged = |(height, nozzle): (f64, f64)| 0.5 * height + 0.2 * nozzle;
    vec![
        check(
            "electrical time constant (Table 2.1)",
            11.10,
            "L/R",
            1e3 * INDUCTANCE / RESISTANCE,
            "ms",
        ),
        check(
            "mechanical time constant (Table 2.1)",
            1.75,
            "3 R J/kt²",
            1e3 * 3.0 * RESISTANCE * INERTIA / (TORQUE_CONSTANT * TORQUE_CONSTANT),
            "ms",
        ),
        check(
            "mechanical time constant (Table 2.1)",
            1.75,
            "R J/kt², as of a DC motor",
            1e3 * RESISTANCE * INERTIA / (TORQUE_CONSTANT * TORQUE_CONSTANT),
            "ms",
        ),
        check(
            "torque constant (Table 2.1)",
            TORQUE_CONSTANT,
            "√3 times the voltage constant",
            3.0_f64.sqrt() * voltage_constant,
            "N·m/A",
        ),
        check(
            "torque constant (Table 2.1)",
            TORQUE_CONSTANT,
            "rated torque / rated current",
            RATED.0 / RATED.1,
            "N·m/A",
        ),
        check(
            "torque constant (Table 2.1)",
            TORQUE_CONSTANT,
            "maximum torque / maximum current",
            MAXIMUM.0 / MAXIMUM.1,
            "N·m/A",
        ),
        check(
            "optimum power (Table 2.1)",
            1.1,
            "rated torque at 2000 rpm",
            1e-3 * RATED.0 * OPTIMUM_RPM * TAU / 60.0,
            "kW",
        ),
        check(
            "chain ratio (ch. 2.2.2)",
            1.48,
            "teeth, 34/23",
            DRIVEN.1 / DRIVING.1,
            "",
        ),
        check(
            "chain ratio (ch. 2.2.2)",
            1.48,
            "diameters, 142/90",
            DRIVEN.0 / DRIVING.0,
            "",
        ),
        check(
            "diameter of the driving sprocket (Table 2.8)",
            DRIVING.0,
            "23 teeth, half-inch chain",
            pitch_diameter(CHAIN_PITCH_MM, DRIVING.1),
            "mm",
        ),
        check(
            "diameter of the driven sprocket (Table 2.8)",
            DRIVEN.0,
            "34 teeth, half-inch chain",
            pitch_diameter(CHAIN_PITCH_MM, DRIVEN.1),
            "mm",
        ),
        check(
            "tolerance of the reducer's gear (Table 6.2)",
            0.18,
            "0.2 l_h + d_n/2, as printed",
            rule(REDUCER_GEAR),
            "mm",
        ),
        check(
            "tolerance of the reducer's gear (Table 6.2)",
            0.18,
            "0.2 d_n + l_h/2",
            exchanged(REDUCER_GEAR),
            "mm",
        ),
        check(
            "tolerance of the encoder's gear (Table 6.2)",
            0.11,
            "0.2 l_h + d_n/2, as printed",
            rule(ENCODER_GEAR),
            "mm",
        ),
        check(
            "tolerance of the encoder's gear (Table 6.2)",
            0.11,
            "0.2 d_n + l_h/2",
            exchanged(ENCODER_GEAR),
            "mm",
        ),
    ]
}

/// What is shown of them.
pub(super) fn section() -> Result<Section, Failure> {
    let checks = checks();
    let entries = checks
        .iter()
        .map(|it| {
            let what = format!("{}, by {}", it.what, it.from);
            entry(&what, Some(it.printed), it.found, None, it.unit)
        })
        .collect();
    let notes = [
        "Time constants and power agree with the rest of Table 2.1, the mechanical one by the rule for \
         phase quantities, with three phases' resistance."
            .to_owned(),
        "Torque constant and voltage constant are of a rms ampere of a phase and of a rms volt between \
         two; for sinusoidal windings the one is √3 times the other. Here it is 4.6 % less. Torque over \
         current falls from 1.91 to 1.77 at the rated and 1.68 N·m/A at the largest torque, by 12 %, as of \
         a motor that saturates; losses at speed are in the former too."
            .to_owned(),
        "The ratio of the sprockets is that of their teeth. The printed diameters have another ratio and \
         fit no chain: by them its pitch would be 12.3 mm on the one and 13.1 mm on the other."
            .to_owned(),
        "The printed rule for the tolerance gives neither number of Table 6.2; with layer height and \
         nozzle diameter exchanged it gives both."
            .to_owned(),
    ];
    let mut parts = vec![Part::Table(
        "Printed numbers and what others make of them".to_owned(),
        cells(&checks),
    )];
    parts.extend(notes.map(Part::Note));
    Ok(Section {
        title: "The paper's own numbers",
        finding:
            "The motor's data sheet agrees with itself within 5 %; sprocket diameters and the \
                  tolerance rule do not agree with what they belong to."
                .to_owned(),
        parts,
        entries,
    })
}

fn cells(checks: &[Check]) -> Cells {
    let mut cells = vec![row(["", "from", "printed", "found", "difference"])];
    cells.extend(checks.iter().map(|it| {
        vec![
            it.what.to_owned(),
            it.from.to_owned(),
            format!("{} {}", it.printed, it.unit).trim_end().to_owned(),
            format!("{:.4} {}", it.found, it.unit).trim_end().to_owned(),
            format!("{:+.1} %", 100.0 * (it.found / it.printed - 1.0)),
        ]
    }));
    cells
}
