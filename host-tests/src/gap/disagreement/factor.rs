//! A position or an input that is off as a whole: an encoder's lines taken for edges, a supply of 12 V taken for 24 V,
//! counts of a PWM taken for per cent. The numbers of a motor take that, and a fit calls it a wrong motor. But with a
//! measured current two numbers follow from the winding's voltage, and what mends both is no chance.

use super::balance::Follows;
use super::channels::Column;
use super::limits::{IMPLAUSIBLE, SHEET, STATED_FACTOR};
use super::reading::{Correction, Reading};
use super::units::LARGEST_SUPPLY;
use crate::log::rounded;
use crate::machine::{MOTOR, Machine};

/// What a column may have to be multiplied by.
const FACTORS: [f64; 4] = [4.0, 2.0, 0.5, 0.25];

/// What an input may have to be multiplied by that counts a PWM of 8 bits, 0 to 255, and was taken for per cent.
pub(super) const COUNTS_AS_PER_CENT: f64 = 100.0 / 255.0;

/// The readings of logs and machine file that mend that. None where the motor's numbers may be guesses.
pub(super) fn readings(declared: &Reading) -> Vec<Reading> {
    let Some([constant, resistance]) = ratios(declared) else {
        return Vec::new();
    };
    let reach = |ratio: f64| (ratio / SHEET, ratio * SHEET);
    // With each, what the log asks for until then: times the declared torque constant, and times the declared
    // resistance. Too small a position makes the speed too small, too small an input the whole voltage.
    let positions = FACTORS.map(|factor| (Column::Position, factor, [factor, 1.0]));
    let inputs = FACTORS.into_iter().chain([COUNTS_AS_PER_CENT]);
    let inputs = inputs.map(|factor| (Column::Input, factor, [1.0 / factor; 2]));
    let known: Vec<Reading> = positions
        .into_iter()
        .chain(inputs)
        .filter(|(_, _, [of_constant, of_resistance])| {
            let (low, high) = reach(*of_constant);
            let is_it = low <= constant.0 && constant.1 <= high;
            // The resistance shows where the current is large: it may not contradict.
            let (low, high) = reach(*of_resistance);
            is_it && resistance.0 <= high && low <= resistance.1
        })
        .map(|(column, factor, _)| declared.with(Correction::Factor(column, factor), 0.0))
        .filter(|mended| mended.cost < IMPLAUSIBLE)
        .collect();
    if known.is_empty() {
        return of_common(declared, [constant, resistance])
            .into_iter()
            .collect();
    }
    known
}

/// The input multiplied by what torque constant and resistance both ask for, whatever has made it: where the log asks of both
/// for more, or for less, than a stated number is off, and one factor is within both. Another winding has no such factor: its
/// resistance goes with the square of its torque constant, and heat raises the one and lowers the other.
fn of_common(declared: &Reading, [constant, resistance]: [(f64, f64); 2]) -> Option<Reading> {
    let (low, high) = (constant.0.max(resistance.0), constant.1.min(resistance.1));
    let is_beyond = |(low, high): (f64, f64)| low > STATED_FACTOR || high < 1.0 / STATED_FACTOR;
    if low > high || low <= 0.0 || !is_beyond(constant) || !is_beyond(resistance) {
        return None;
    }
    let factor = rounded(1.0 / (low * high).sqrt(), 3);
    // Any factor fits some log: it is as unusual as there are factors up to the largest supply that a sheet's tolerance tells apart.
    let rarity = (LARGEST_SUPPLY.ln() / (2.0 * SHEET.ln())).ln();
    let mended = declared.with(Correction::Factor(Column::Input, factor), rarity);
    (mended.cost < IMPLAUSIBLE).then_some(mended)
}

/// What the log asks for, at least and at most, over what is declared: torque constant and resistance.
pub(super) fn ratios(declared: &Reading) -> Option<[(f64, f64); 2]> {
    let winding = declared.balances.winding.as_ref()?;
    let motor = declared.machine.motor.as_ref()?;
    if MOTOR.iter().any(|name| is_guess(&declared.machine, name)) {
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

/// Whether a number may be one: where `[fit]` has it, and the file does not say that it is within a data sheet's tolerance.
pub(super) fn is_guess(machine: &Machine, name: &str) -> bool {
    let stated = machine.unsure.get(name).copied().unwrap_or(f64::INFINITY);
    machine.fits(name) && stated > STATED_FACTOR
}
