//! Numbers of a data sheet that say the same twice have to agree.
//!
//! Two values of one thing may differ by what makers allow, [`rules::MAKERS_TOLERANCE`], and by the rounding of
//! every number that went into them: half a unit of the last digit, as it was written.

use super::derive::{Number, Point, Sure};
use super::measure::Measure;
use super::rules;
use super::sheet::Sheet;
use crate::quantity::significant;

/// What mends two numbers of which neither is known to be the wrong one.
const LEAVE_OUT: &str = "leave out the less sure one";

/// A value with what it was made of.
struct Value<'a> {
    what: String,
    value: f64,
    unit: &'a str,
}

/// Refuses two values that are further apart than `rounding` and the maker explain.
fn agree(one: &Value, other: &Value, rounding: f64, remedy: &str) -> Result<(), String> {
    let allowed = rules::MAKERS_TOLERANCE + rounding;
    let ratio = (one.value / other.value).max(other.value / one.value);
    // Not a number where both are zero.
    if ratio.is_nan() || ratio <= 1.0 + allowed {
        return Ok(());
    }
    Err(format!(
        "{} and {} contradict each other: {} against {} {}, {} apart, and tolerance and rounding explain \
         {}; {remedy}",
        one.what,
        other.what,
        significant(one.value, 4),
        significant(other.value, 4),
        one.unit,
        apart(ratio),
        percent(allowed)
    ))
}

/// By how much voltage and stall current may have another resistance than the one that is told without a remark.
const REMARKED: f64 = 0.1;

/// What voltage and stall current make of a resistance that is told, where that is within rounding but clearly another number: a
/// remark behind it.
pub(super) fn other_resistance(sheet: &Sheet, resistance: &Measure) -> Option<String> {
    let (voltage, current) = (sheet.voltage.as_ref()?, sheet.stall_current.as_ref()?);
    let other = voltage.value / current.value;
    let ratio = (other / resistance.value).max(resistance.value / other);
    (ratio > 1.0 + REMARKED).then(|| {
        format!(
            "; {voltage} over {current} says {} Ω, {} apart, which rounding explains; measure it if you can",
            significant(other, 2),
            apart(ratio)
        )
    })
}

fn percent(part: f64) -> String {
    format!("{} %", significant(100.0 * part, 3))
}

fn apart(ratio: f64) -> String {
    if ratio < 3.0 {
        percent(ratio - 1.0)
    } else {
        format!("a factor of {}", significant(ratio, 3))
    }
}

fn load_unit(point: &Point) -> &'static str {
    if point.sheet.gear.linear { "N" } else { "N·m" }
}

/// The current at standstill, A: given, or that of voltage and resistance.
pub(super) fn stall_current(point: &Point, resistance: f64) -> Option<f64> {
    let given = point.sheet.stall_current.as_ref().map(|it| it.value);
    given.or_else(|| point.voltage().map(|volts| volts / resistance))
}

/// The current at standstill against voltage and resistance, and the one without a load below it.
pub(super) fn of_currents(point: &Point) -> Result<(), String> {
    let sheet = point.sheet;
    if let (Some(voltage), Some(current), Some(resistance)) =
        (&sheet.voltage, &sheet.stall_current, &sheet.resistance)
    {
        let one = Value {
            what: format!("{current}"),
            value: current.value,
            unit: "A",
        };
        let other = Value {
            what: format!("{voltage} over {resistance}"),
            value: voltage.value / resistance.value,
            unit: "A",
        };
        let rounding = current.rounding + resistance.rounding;
        agree(&one, &other, rounding, LEAVE_OUT)?;
    }
    if let (Some(idle), Some(stall)) = (&sheet.no_load_current, &sheet.stall_current)
        && idle.value >= stall.value
    {
        return Err(format!(
            "{idle} is not below {stall}: the motor would not turn"
        ));
    }
    Ok(())
}

/// The no-load current below the one at standstill.
pub(super) fn of_idle(point: &Point, resistance: f64, idle: Number) -> Result<Number, String> {
    match stall_current(point, resistance) {
        Some(stall) if idle.value >= stall => Err(format!(
            "the no-load current of {} A ({}) is not below the {} A at standstill: the motor would not turn",
            significant(idle.value, 4),
            idle.why,
            significant(stall, 4)
        )),
        _ => Ok(idle),
    }
}

/// The torque constant as each option gives it, and as the no-load point does.
pub(super) fn of_constants(point: &Point, resistance: f64) -> Result<(), String> {
    let sheet = point.sheet;
    let unit = if sheet.gear.linear { "N/A" } else { "N·m/A" };
    let value = |(measure, value): &(&Measure, f64)| Value {
        what: format!("{measure}"),
        value: *value,
        unit,
    };
    let remedy = if sheet.gear.is_there {
        "torque and back-EMF constant are one number, in SI; leave out the less sure one, or look at --values-of and \
         the units"
    } else {
        "torque and back-EMF constant are one number, in SI; leave out the less sure one, or look at the units; behind a \
         gear or a screw, add --values-of gearmotor, and --gear-ratio if the sheet has it"
    };
    for (place, one) in point.constants.iter().enumerate() {
        for other in &point.constants[place + 1..] {
            let rounding = one.0.rounding + other.0.rounding;
            agree(&value(one), &value(other), rounding, remedy)?;
        }
    }
    let (Some(constant), Some(voltage), Some(measure), Some(speed)) = (
        point.constants.first(),
        &sheet.voltage,
        &sheet.no_load_speed,
        point.no_load_speed,
    ) else {
        return Ok(());
    };
    let rounding = constant.0.rounding + measure.rounding;
    let (drop, lost, what) = match &sheet.no_load_current {
        Some(idle) => (
            idle.value * resistance,
            idle.rounding * idle.value * resistance / voltage.value,
            format!("({voltage} − {idle} × resistance) over {measure}"),
        ),
        // Somewhere between none and twice what is presumed.
        None => {
            let share = point.presumed_share();
            let what = format!("{voltage} over {measure}");
            (share * voltage.value, share, what)
        }
    };
    let other = Value {
        what,
        value: (voltage.value - drop) / speed,
        unit,
    };
    agree(&value(constant), &other, rounding + lost, remedy)
}

/// The stall torque against torque constant and current at standstill, where the gear's loss is known. Makers
/// print it with and without friction: both are allowed.
pub(super) fn of_stall(
    point: &Point,
    resistance: f64,
    constant: &Number,
    idle: &Number,
) -> Result<(), String> {
    let (Some(torque), Some(stall), Some(current), Some(passed)) = (
        &point.sheet.stall_torque,
        point.stall_torque,
        stall_current(point, resistance),
        point.passed,
    ) else {
        return Ok(());
    };
    let without = passed * constant.value * current;
    let with = without * (1.0 - idle.value / current);
    let expected = stall.clamp(with, without);
    let unit = load_unit(point);
    let loss = if passed < 1.0 {
        format!(" × --gear-efficiency {}", significant(passed, 3))
    } else {
        String::new()
    };
    let one = Value {
        what: format!("{torque}"),
        value: stall,
        unit,
    };
    let other = Value {
        what: format!(
            "torque constant ({}) × {} A at standstill{loss}",
            constant.why,
            significant(current, 4)
        ),
        value: expected,
        unit,
    };
    let remedy = if point.sheet.gear.is_there {
        "leave out the less sure one, or look at the units and --values-of"
    } else {
        "leave out the less sure one, or look at the units; behind a gear or a screw, add --values-of gearmotor, and \
         --gear-ratio if the sheet has it"
    };
    let rounding = torque.rounding + rounding_of(constant);
    agree(&one, &other, rounding, remedy)
}

/// What rounding left unsure of a number of the motor.
fn rounding_of(number: &Number) -> f64 {
    match number.sure {
        Sure::Within(part) => (part - rules::MAKERS_TOLERANCE).max(0.0),
        Sure::Told | Sure::Guess(_) => 0.0,
    }
}

/// The efficiency that a gearmotor's numbers come to: at most one.
pub(super) fn of_efficiency(
    point: &Point,
    torque: &Measure,
    efficiency: f64,
    whole: f64,
    constant: &Number,
    current: f64,
) -> Result<(), String> {
    let most = 1.0 + rules::MAKERS_TOLERANCE + torque.rounding + rounding_of(constant);
    if (rules::LEAST_EFFICIENCY..=most).contains(&efficiency) {
        return Ok(());
    }
    Err(format!(
        "{torque} and torque constant ({}) × current at standstill, {} A, contradict each other: the gear \
         would pass on {} of {} {}; expected {} to 100 %, and {} with tolerance and rounding; look at \
         --values-of, --gear-ratio and the units",
        constant.why,
        significant(current, 4),
        percent(efficiency),
        significant(whole, 4),
        load_unit(point),
        percent(rules::LEAST_EFFICIENCY),
        percent(most)
    ))
}

/// A part of the friction against the whole of it, both N·m or N at the coordinate. Less is fine: the rest is of
/// the other kind.
fn of_part(
    point: &Point,
    (what, part): (String, f64),
    (of, whole): (String, f64),
    rounding: f64,
    remedy: &str,
) -> Result<(), String> {
    if part <= whole {
        return Ok(());
    }
    let unit = load_unit(point);
    let value = |what, value| Value { what, value, unit };
    agree(&value(what, part), &value(of, whole), rounding, remedy)
}

/// A friction that is told against the no-load current that overcomes it.
pub(super) fn of_friction(
    point: &Point,
    friction: &Measure,
    torque: f64,
    idle: &Measure,
    whole: f64,
) -> Result<(), String> {
    let part = (format!("{friction}"), torque);
    let whole = (format!("torque constant × {idle}"), whole);
    let gear = &point.sheet.gear;
    let remedy = if gear.is_there && !gear.values_behind {
        "leave out the less sure one, or give what rubs behind the motor as --load-friction"
    } else {
        LEAVE_OUT
    };
    let rounding = friction.rounding + idle.rounding;
    of_part(point, part, whole, rounding, remedy)
}

/// A viscous friction that is told against what rubs without a load.
pub(super) fn of_viscous(
    point: &Point,
    viscous: &Measure,
    torque: f64,
    whole: f64,
    idle: &Number,
) -> Result<(), String> {
    let part = (format!("{viscous} at the no-load speed"), torque);
    let whole = (
        format!("torque constant × no-load current ({})", idle.why),
        whole,
    );
    let rounding = viscous.rounding + rounding_of(idle);
    of_part(point, part, whole, rounding, LEAVE_OUT)
}

/// A rotor's inertia against a mechanical time constant. `found` is that of the inertia.
pub(super) fn of_time_constant(
    inertia: &Measure,
    time: &Measure,
    found: f64,
) -> Result<(), String> {
    let one = Value {
        what: format!("{time}"),
        value: time.value,
        unit: "s",
    };
    let other = Value {
        what: format!("{inertia} × resistance over torque constant²"),
        value: found,
        unit: "s",
    };
    let rounding = time.rounding + inertia.rounding + 2.0 * rules::MAKERS_TOLERANCE;
    agree(&one, &other, rounding, LEAVE_OUT)
}
