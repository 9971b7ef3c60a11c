//! A position or an input that is off as a whole by two or four: an encoder's lines taken for edges, a supply of 12 V
//! taken for 24 V. The numbers of a motor take that, and a fit calls it a wrong motor. But with a measured current two
//! numbers follow from the winding's voltage, and what mends both is no chance.

use super::balance::Follows;
use super::channels::Column;
use super::limits::{IMPLAUSIBLE, SHEET};
use super::reading::{Correction, Reading};
use crate::gap::outcome::MOTOR;

/// A column, what it is to be multiplied by, and what the log asks for until then: times the declared torque constant,
/// and times the declared resistance.
const CASES: [(Column, f64, [f64; 2]); 8] = [
    (Column::Position, 4.0, [4.0, 1.0]),
    (Column::Position, 2.0, [2.0, 1.0]),
    (Column::Position, 0.5, [0.5, 1.0]),
    (Column::Position, 0.25, [0.25, 1.0]),
    (Column::Input, 4.0, [0.25, 0.25]),
    (Column::Input, 2.0, [0.5, 0.5]),
    (Column::Input, 0.5, [2.0, 2.0]),
    (Column::Input, 0.25, [4.0, 4.0]),
];

/// The readings of logs and machine file that mend that. None where `[fit]` has the motor's numbers, which may be
/// guesses then.
pub(super) fn readings(declared: &Reading) -> Vec<Reading> {
    let Some([constant, resistance]) = ratios(declared) else {
        return Vec::new();
    };
    let reach = |ratio: f64| (ratio / SHEET, ratio * SHEET);
    CASES
        .into_iter()
        .filter(|(_, _, [of_constant, of_resistance])| {
            let (low, high) = reach(*of_constant);
            let is_it = low <= constant.0 && constant.1 <= high;
            // The resistance shows where the current is large: it may not contradict.
            let (low, high) = reach(*of_resistance);
            is_it && resistance.0 <= high && low <= resistance.1
        })
        .map(|(column, factor, _)| declared.with(Correction::Factor(column, factor), 0.0))
        .filter(|mended| mended.cost < IMPLAUSIBLE)
        .collect()
}

/// What the log asks for, at least and at most, over what is declared: torque constant and resistance.
pub(super) fn ratios(declared: &Reading) -> Option<[(f64, f64); 2]> {
    let winding = declared.balances.winding.as_ref()?;
    let motor = declared.machine.motor.as_ref()?;
    let fit = &declared.machine.fit;
    if MOTOR
        .iter()
        .any(|name| fit.iter().any(|fitted| fitted == name))
    {
        return None;
    }
    let ratio = |follows, declared: f64| {
        let (low, high) = winding.share(follows)?.interval;
        Some((low / declared, high / declared))
    };
    Some([
        ratio(Follows::Velocity, motor.torque_constant)?,
        ratio(Follows::Current, motor.resistance)?,
    ])
}
