//! What rubs: from the no-load current, the friction that is told, or a guess.

use super::agreement;
use super::derive::{Number, Point, Sure, significant, times, within};
use super::rules;

/// The friction of the machine, at the coordinate.
#[derive(Debug)]
pub(super) struct Friction {
    /// N·m·s/rad, or N·s/m.
    pub viscous: Number,
    /// N·m, or N.
    pub coulomb: Number,
    /// N·m, or N.
    pub breakaway: Number,
}

/// The no-load current, A: as told, that of the friction that is told, or a part of the one at standstill.
pub(super) fn no_load_current(
    point: &Point,
    resistance: f64,
    constant: f64,
) -> Result<Number, String> {
    let sheet = point.sheet;
    if let Some(measure) = &sheet.no_load_current {
        let number = Number::told(measure, 1.0, within([measure.rounding]));
        return agreement::of_idle(point, resistance, number);
    }
    if let (Some(measure), Some(torque)) = (&sheet.friction_torque, point.friction_torque) {
        let current = torque / (point.passed.unwrap_or(1.0) * constant);
        let why = format!("that {measure} takes");
        let number = Number::new(current, why, within([measure.rounding]));
        return agreement::of_idle(point, resistance, number);
    }
    let stall = agreement::stall_current(point, resistance).ok_or_else(|| {
        "nothing says how much rubs; expected --no-load-current or --friction-torque, or --voltage for a \
         guess from the current at standstill"
            .to_owned()
    })?;
    let share = point.presumed_share();
    Ok(Number::new(
        share * stall,
        format!(
            "guessed: {:.0} % of the {} A at standstill; --no-load-current gives it",
            100.0 * share,
            significant(stall)
        ),
        Sure::Guess(rules::FRICTION_FACTOR),
    ))
}

/// What the gear passes on over what it is given, at standstill, as a fraction: the stall torque, with the
/// friction that [`of`] will leave, over that of the winding.
///
/// `τ_s = η k I_s − c`, with `c` as it is told, or `η k I₀ − b ω₀` with `b` as it is told, or presumed to be
/// a part of `η k I₀`.
pub(super) fn at_standstill(
    point: &Point,
    stall: f64,
    constant: f64,
    current: f64,
    idle: &Number,
) -> (f64, f64) {
    if let Some(torque) = point.friction_torque {
        return (stall + torque, constant * current);
    }
    let drag = point.sheet.viscous.as_ref().zip(point.no_load_speed);
    if let (Some((viscous, speed)), Some(_)) = (drag, &point.sheet.no_load_current) {
        return (
            stall - viscous.value * speed,
            constant * (current - idle.value),
        );
    }
    let rubbing = (1.0 - rules::VISCOUS_PART) * idle.value;
    (stall, constant * (current - rubbing))
}

/// Splits what rubs without a load, the torque that the no-load current makes less what the gear loses of
/// it, into viscous and Coulomb friction.
pub(super) fn of(
    point: &Point,
    resistance: &Number,
    constant: &Number,
    idle: &Number,
    share: &Option<Number>,
) -> Result<Friction, String> {
    let sheet = point.sheet;
    let passed = 1.0 - share.as_ref().map_or(0.0, |share| share.value);
    let whole = passed * constant.value * idle.value;
    let speed = point.no_load_speed.or_else(|| {
        let rest = point.voltage()? - idle.value * resistance.value;
        Some(rest / constant.value)
    });
    // What the sheet says of the motor alone goes through the gear, too.
    let lossy = if sheet.gear.values_behind {
        1.0
    } else {
        passed
    };
    let told = sheet.friction_torque.as_ref().zip(point.friction_torque);
    let (coulomb, viscous) = match (told, &sheet.viscous) {
        (Some((measure, torque)), viscous) => {
            let lossy = if measure.linear { 1.0 } else { lossy };
            let torque = torque * lossy;
            let referred = times(sheet.gear.sheet(measure)?);
            let coulomb = Number::new(
                torque,
                format!("given, {measure}{referred}{}", passing(lossy)),
                within([measure.rounding]),
            );
            let viscous = match viscous {
                Some(measure) => Number::told(measure, 1.0, within([measure.rounding])),
                None => rest(point, whole, torque, speed)?,
            };
            (coulomb, viscous)
        }
        (None, Some(measure)) => {
            let viscous = Number::told(measure, 1.0, within([measure.rounding]));
            if sheet.no_load_current.is_none() {
                // A guessed current tells nothing of it.
                let coulomb = with_load(point, split(point, (whole, passed), speed, idle).0, None);
                return Ok(Friction {
                    breakaway: breakaway(point, &coulomb, lossy)?,
                    coulomb,
                    viscous,
                });
            }
            let speed = speed.unwrap_or(0.0);
            let rest = whole - viscous.value * speed;
            agreement::of_viscous(point, measure, viscous.value * speed, whole, idle)?;
            let why = format!("{}; less {measure} at no load", of_current(idle, passed));
            (Number::new(rest.max(0.0), why, idle.sure), viscous)
        }
        (None, None) => split(point, (whole, passed), speed, idle),
    };
    let unsure = unsure_of_gear(point, resistance.value);
    let viscous = match unsure {
        Some(factor) if sheet.viscous.is_none() => {
            let why = format!("{}; {}", viscous.why, without(point));
            Number::new(viscous.value, why, Sure::Guess(factor))
        }
        _ => viscous,
    };
    let coulomb = with_load(point, coulomb, unsure);
    Ok(Friction {
        breakaway: breakaway(point, &coulomb, lossy)?,
        viscous,
        coulomb,
    })
}

/// The sliding friction of the sheet with that of what the motor drives, or with what says that it is not known.
fn with_load(point: &Point, friction: Number, unsure: Option<f64>) -> Number {
    let sheet = point.sheet;
    let Some(measure) = &sheet.load_friction else {
        let told = sheet.friction_torque.as_ref();
        let is_of_load = told.is_some_and(|measure| measure.linear);
        let is_of_motor = unsure.is_some() || sheet.gear.lead.is_some() && !is_of_load;
        if !is_of_motor {
            return friction;
        }
        let (example, or) = if sheet.gear.linear {
            ("5N", "")
        } else {
            (
                "20mNm",
                ", or --values-of gearmotor with the gearmotor's numbers has it",
            )
        };
        let why = format!(
            "{}; {}: --load-friction adds it, as in --load-friction {example}{or}",
            friction.why,
            without(point)
        );
        let sure = unsure.map_or(friction.sure, Sure::Guess);
        return Number::new(friction.value, why, sure);
    };
    let load = measure.value;
    let why = format!("{}; + {} of {measure}", friction.why, significant(load));
    let value = friction.value + load;
    // A guess that hardly counts makes no guess of the sum.
    let sure = match friction.sure {
        Sure::Guess(factor) if (factor - 1.0) * friction.value > rules::MAKERS_TOLERANCE * load => {
            Sure::Guess(1.0 + (factor - 1.0) * friction.value / value)
        }
        _ => within([measure.rounding]),
    };
    Number::new(value, why, sure)
}

/// What rubs behind a motor and is not in its numbers.
fn without(point: &Point) -> &'static str {
    let gear = &point.sheet.gear;
    match (gear.linear, gear.values_behind) {
        (true, true) => {
            "without what rubs in belt or screw and rail, which no gearmotor's data sheet has"
        }
        (true, false) => {
            "without what rubs in gear, belt or screw and rail, which no motor's data sheet has"
        }
        (false, _) => "without the gear's own friction, which no motor's data sheet has",
    }
}

/// By what factor the friction behind a gear may be more than that of the no-load current, where this is a bare motor's.
fn unsure_of_gear(point: &Point, resistance: f64) -> Option<f64> {
    let sheet = point.sheet;
    let is_without = sheet.gear.is_there && !sheet.gear.values_behind;
    if !is_without || sheet.friction_torque.is_some() {
        return None;
    }
    let idle = sheet.no_load_current.as_ref()?;
    let stall = agreement::stall_current(point, resistance);
    let factor = stall.map(|stall| rules::GEARMOTORS_NO_LOAD_SHARE * stall / idle.value);
    Some(factor.unwrap_or(0.0).max(rules::FRICTION_FACTOR))
}

/// What has to be overcome before it moves.
fn breakaway(point: &Point, coulomb: &Number, lossy: f64) -> Result<Number, String> {
    let sheet = point.sheet;
    let Some(measure) = &sheet.breakaway_torque else {
        return Ok(Number::new(
            rules::BREAKAWAY_RATIO * coulomb.value,
            format!("guessed: {} × coulomb", rules::BREAKAWAY_RATIO),
            coulomb.sure,
        ));
    };
    let lossy = if measure.linear { 1.0 } else { lossy };
    let factor = sheet.gear.sheet(measure)? * lossy;
    let number = Number::told(measure, factor, within([measure.rounding]));
    if number.value < coulomb.value {
        return Err(format!(
            "{measure} is less than the sliding friction, {} ({}); expected at least as much",
            significant(coulomb.value),
            coulomb.why
        ));
    }
    Ok(number)
}

/// The viscous friction that the no-load current leaves beside a Coulomb friction that is told.
fn rest(point: &Point, whole: f64, torque: f64, speed: Option<f64>) -> Result<Number, String> {
    let sheet = point.sheet;
    let (Some(idle), Some(speed), Some(friction)) =
        (&sheet.no_load_current, speed, &sheet.friction_torque)
    else {
        let speed = speed.unwrap_or(f64::INFINITY);
        let value = rules::VISCOUS_PART * torque / speed;
        let why = "guessed: a quarter of the friction at no load".to_owned();
        return Ok(Number::new(value, why, Sure::Guess(rules::FRICTION_FACTOR)));
    };
    agreement::of_friction(point, friction, torque, idle, whole)?;
    let value = (whole - torque).max(0.0) / speed;
    let why = format!("what {friction} leaves of {idle}, at the no-load speed");
    Ok(Number::new(value, why, Sure::Guess(rules::FRICTION_FACTOR)))
}

/// Coulomb and viscous friction where nothing tells the two.
/// `whole`: all of it, and what the gear passes on of the torque that makes it.
fn split(
    point: &Point,
    (whole, passed): (f64, f64),
    speed: Option<f64>,
    idle: &Number,
) -> (Number, Number) {
    let Some(speed) = speed else {
        let coulomb = Number::new(whole, of_current(idle, passed), idle.sure);
        let why = "not known, and taken for coulomb; --voltage or --no-load-speed splits the two";
        return (coulomb, Number::new(0.0, why, Sure::Told));
    };
    let part = rules::VISCOUS_PART;
    let why = format!(
        "{:.0} % of {}",
        100.0 * (1.0 - part),
        of_current(idle, passed)
    );
    let sure = match idle.sure {
        Sure::Guess(factor) => Sure::Guess(factor),
        _ => Sure::Guess(1.0 / (1.0 - part)),
    };
    let coulomb = Number::new((1.0 - part) * whole, why, sure);
    let [load, rate] = if point.sheet.gear.linear {
        ["N", "m/s"]
    } else {
        ["N·m", "rad/s"]
    };
    let why = format!(
        "guessed: {:.0} % of the friction at no load, {} {load}, over the speed there, {} {rate}",
        100.0 * part,
        significant(whole),
        significant(speed)
    );
    let viscous = Number::new(
        part * whole / speed,
        why,
        Sure::Guess(rules::FRICTION_FACTOR),
    );
    (coulomb, viscous)
}

fn of_current(idle: &Number, passed: f64) -> String {
    format!(
        "what the no-load current of {} A ({}) makes with the torque constant{}",
        significant(idle.value),
        idle.why,
        passing(passed)
    )
}

/// What the gear passes on of a torque, behind that in a comment.
fn passing(passed: f64) -> String {
    if passed == 1.0 {
        String::new()
    } else {
        format!(
            ", of which the gear passes on {} %",
            significant(100.0 * passed)
        )
    }
}
