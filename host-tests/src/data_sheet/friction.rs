//! What rubs: from the no-load current, the friction that is told, or a guess.

use model_core::gap::criterion;

use super::agreement;
use super::derive::{Number, Point, Sure, significant, times, within};
use super::measure::Measure;
use super::rules;
use crate::quantity::given;

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
                (split(point, (whole, passed), speed, idle).0, viscous)
            } else {
                let drag = viscous.value * speed.unwrap_or(0.0);
                agreement::of_viscous(point, measure, drag, whole, idle)?;
                let why = format!("{}; less {measure} at no load", of_current(idle, passed));
                let rest = (whole - drag).max(0.0);
                (Number::new(rest, why, idle.sure), viscous)
            }
        }
        (None, None) => split(point, (whole, passed), speed, idle),
    };
    let stall = agreement::stall_current(point, resistance.value);
    let behind = Behind::of(point, passed * constant.value, stall);
    let viscous = match &behind {
        Some(behind) if sheet.viscous.is_none() => behind.viscous(point, viscous, speed),
        _ => viscous,
    };
    let coulomb = with_load(point, coulomb, behind.as_ref(), lossy)?;
    Ok(Friction {
        breakaway: breakaway(point, &coulomb, lossy)?,
        viscous,
        coulomb,
    })
}

/// What rubs behind the shaft that the sheet is of: gear, belt, screw, rail or the load's bearings. It adds to the motor's own
/// friction, and by how much no data sheet says: by more than nothing, and by less than what stops the motor.
struct Behind {
    /// What the motor makes at standstill, at the coordinate, N·m or N; none where nothing says the current at standstill.
    stall: Option<f64>,
    /// Whether there is a gear, whose friction is guessed to be that of gearmotors; else nothing is like it.
    is_of_gear: bool,
}

impl Behind {
    /// `scale`: torque for an ampere at the coordinate. None where the sheet has all that rubs, or the user says it.
    fn of(point: &Point, scale: f64, current: Option<f64>) -> Option<Self> {
        let sheet = point.sheet;
        let gear = &sheet.gear;
        let told = sheet.friction_torque.as_ref();
        // Who says that nothing rubs there is believed.
        let is_none = |measure: &Measure| measure.value == 0.0;
        if sheet.load_friction.as_ref().is_some_and(is_none) {
            return None;
        }
        // A guessed current is one of a gearmotor, and as unsure as that.
        let is_measured = told.is_none() && sheet.no_load_current.is_some();
        let is_of_gear = is_measured && gear.is_there && !gear.values_behind;
        let has_rail = gear.lead.is_some() && !told.is_some_and(|measure| measure.linear);
        let load = [
            &sheet.load_inertia,
            &sheet.load_friction,
            &sheet.pendulum_mass,
        ];
        let has_load = load.into_iter().flatten().any(|load| load.value > 0.0);
        let bears_load = is_measured && !gear.is_there && has_load;
        (is_of_gear || has_rail || bears_load).then_some(Self {
            stall: current.map(|current| scale * current),
            is_of_gear,
        })
    }

    /// A part of the friction at no load, of which the motor's own is `own`: with what gearmotors have, if that is more.
    fn part(&self, own: f64, part: f64) -> f64 {
        let stall = self.stall.filter(|_| self.is_of_gear);
        stall.map_or(own, |stall| {
            own.max(part * rules::GEARMOTORS_NO_LOAD_SHARE * stall)
        })
    }

    /// By what factor such a number may be off: down to the motor's own, up to what stops the motor.
    fn sure(&self, value: f64, own: f64, most: Option<f64>) -> Sure {
        let up = most.map_or(0.0, |most| most / value);
        let down = if own > 0.0 { value / own } else { 0.0 };
        let factor = up.max(down).min(f64::from(criterion::FARTHEST));
        Sure::Guess(factor.max(rules::FRICTION_FACTOR))
    }

    /// Where such a number comes from, of which the motor's own is `own`. `part`: what of the friction at no load it is.
    fn why(&self, point: &Point, (value, own): (f64, &Number), part: &str) -> String {
        let without = without(point);
        let (what, unit) = if point.sheet.gear.linear {
            ("force", "N")
        } else {
            ("torque", "N·m")
        };
        match self.stall {
            Some(stall) if value > own.value => format!(
                "guessed: {part} of the {what} that gearmotors need without a load, which is {} % of that at standstill, {} {unit}; \
                 the motor's own, from its no-load current, is {}, {without}",
                given(100.0 * rules::GEARMOTORS_NO_LOAD_SHARE),
                significant(stall),
                significant(own.value)
            ),
            _ => format!("{}; {without}", own.why),
        }
    }

    fn viscous(&self, point: &Point, own: Number, speed: Option<f64>) -> Number {
        let Some(speed) = speed.filter(|speed| *speed > 0.0) else {
            let sure = self.sure(own.value, own.value, None);
            let why = self.why(point, (own.value, &own), "");
            return Number::new(own.value, why, sure);
        };
        let part = rules::VISCOUS_PART;
        let value = self.part(own.value, part / speed);
        let share = format!("{} % over the speed there", given(100.0 * part));
        let why = self.why(point, (value, &own), &share);
        let most = self.stall.map(|stall| stall / speed);
        Number::new(value, why, self.sure(value, own.value, most))
    }

    /// `most`: what it surely is not above, as a breakaway torque that is told.
    fn coulomb(&self, point: &Point, own: Number, most: Option<f64>) -> Number {
        let part = 1.0 - rules::VISCOUS_PART;
        let value = self.part(own.value, part);
        let value = most.map_or(value, |most| value.min(most).max(own.value));
        let why = self.why(point, (value, &own), &format!("{} %", given(100.0 * part)));
        Number::new(value, why, self.sure(value, own.value, self.stall))
    }
}

/// The sliding friction of the sheet with that of what the motor drives, or with what says that it is not known. `lossy`: what
/// the gear passes on of a breakaway torque.
fn with_load(
    point: &Point,
    friction: Number,
    behind: Option<&Behind>,
    lossy: f64,
) -> Result<Number, String> {
    let sheet = point.sheet;
    let Some(measure) = &sheet.load_friction else {
        let Some(behind) = behind else {
            return Ok(friction);
        };
        let (example, or) = match (sheet.gear.linear, behind.is_of_gear) {
            (true, _) => ("5N", ""),
            (false, true) => (
                "20mNm",
                ", or --values-of gearmotor with the gearmotor's numbers has it",
            ),
            (false, false) => ("20mNm", ""),
        };
        let most = told_breakaway(point, lossy)?.map(|number| number.value);
        let mut number = behind.coulomb(point, friction, most);
        number.why += &format!(": --load-friction adds it, as in --load-friction {example}{or}");
        return Ok(number);
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
    Ok(Number::new(value, why, sure))
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
        (false, _) if gear.is_there => {
            "without the gear's own friction, which no motor's data sheet has"
        }
        (false, _) => "without what rubs at the load, which no motor's data sheet has",
    }
}

/// What has to be overcome before it moves, where the sheet says so.
fn told_breakaway(point: &Point, lossy: f64) -> Result<Option<Number>, String> {
    let told = point.sheet.breakaway_torque.as_ref().map(|measure| {
        let lossy = if measure.linear { 1.0 } else { lossy };
        let factor = point.sheet.gear.sheet(measure)? * lossy;
        let sure = within([measure.rounding]);
        Ok(Number::told(measure, factor, sure))
    });
    told.transpose()
}

/// What has to be overcome before it moves.
fn breakaway(point: &Point, coulomb: &Number, lossy: f64) -> Result<Number, String> {
    match (told_breakaway(point, lossy)?, &point.sheet.breakaway_torque) {
        (Some(number), Some(measure)) if number.value < coulomb.value => Err(format!(
            "{measure} is less than the sliding friction, {} ({}); expected at least as much",
            significant(coulomb.value),
            coulomb.why
        )),
        (Some(number), _) => Ok(number),
        (None, _) => Ok(Number::new(
            rules::BREAKAWAY_RATIO * coulomb.value,
            format!("guessed: {} × coulomb", rules::BREAKAWAY_RATIO),
            coulomb.sure,
        )),
    }
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
