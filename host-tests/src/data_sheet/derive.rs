//! From the data sheet's numbers to those of the model, referred to the coordinate.

use super::agreement;
use super::friction::{self, Friction};
use super::measure::{GRAVITY, Measure};
use super::rules;
use super::sheet::Sheet;
use crate::quantity::given;

/// A number of the machine file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Number {
    /// SI, referred to the coordinate.
    pub value: f64,
    /// Where it comes from.
    pub why: String,
    /// How sure it is.
    pub sure: Sure,
}

/// How sure a number is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sure {
    /// As the user says.
    Told,
    /// Within a part of its value: what makers allow, and what rounding took away.
    Within(f64),
    /// A guess that may be off by a factor.
    Guess(f64),
}

impl Number {
    pub fn new(value: f64, why: impl Into<String>, sure: Sure) -> Self {
        Self {
            value,
            why: why.into(),
            sure,
        }
    }

    /// A number of the sheet, times what refers it to the coordinate.
    pub fn told(measure: &Measure, factor: f64, sure: Sure) -> Self {
        let why = if factor == 1.0 {
            format!("given, {measure}")
        } else {
            format!("given, {measure}, × {}", given(factor))
        };
        Self::new(measure.value * factor, why, sure)
    }
}

/// Within what the maker allows and these roundings.
pub(super) fn within(roundings: impl IntoIterator<Item = f64>) -> Sure {
    Sure::Within(roundings.into_iter().sum::<f64>() + rules::MAKERS_TOLERANCE)
}

/// The machine.
#[derive(Debug)]
pub(super) struct Derived {
    pub resistance: Number,
    pub inductance: Number,
    pub torque_constant: Number,
    pub inertia: Number,
    pub friction: Friction,
    /// What the gear loses of the motor's torque, where the sheet says that.
    pub share: Option<Number>,
    pub gravity_torque: Option<Number>,
    pub resolution: Option<Number>,
}

/// The sheet's numbers at the coordinate.
#[derive(Debug)]
pub(super) struct Point<'a> {
    pub sheet: &'a Sheet,
    pub no_load_speed: Option<f64>,
    pub stall_torque: Option<f64>,
    /// Of the shaft that the sheet is of, referred.
    pub friction_torque: Option<f64>,
    /// The torque constant as each option gives it.
    pub constants: Vec<(&'a Measure, f64)>,
    /// What the gear passes on of a torque, as far as the sheet's values have gone through it: 1 for those of
    /// the motor, none where it has to be found.
    pub passed: Option<f64>,
}

impl<'a> Point<'a> {
    fn of(sheet: &'a Sheet) -> Result<Self, String> {
        let gear = &sheet.gear;
        let times = |measure: &Option<Measure>| -> Result<Option<f64>, String> {
            let measure = measure.as_ref();
            measure
                .map(|measure| Ok(measure.value * gear.sheet(measure)?))
                .transpose()
        };
        let mut constants = Vec::new();
        if let Some(measure) = &sheet.torque_constant {
            constants.push((
                measure,
                measure.value * gear.sheet(measure)? / lossless(sheet)?,
            ));
        }
        if let Some(measure) = &sheet.back_emf_constant {
            constants.push((measure, measure.value * gear.sheet(measure)?));
        }
        if let Some(measure) = &sheet.speed_constant {
            constants.push((measure, gear.sheet(measure)? / measure.value));
        }
        let speed = sheet.no_load_speed.as_ref();
        Ok(Self {
            sheet,
            no_load_speed: speed
                .map(|speed| Ok::<_, String>(speed.value / gear.sheet(speed)?))
                .transpose()?,
            stall_torque: times(&sheet.stall_torque)?,
            friction_torque: times(&sheet.friction_torque)?,
            constants,
            passed: if gear.is_there && gear.values_behind {
                sheet.efficiency
            } else {
                Some(1.0)
            },
        })
    }

    pub fn voltage(&self) -> Option<f64> {
        self.sheet.voltage.as_ref().map(|it| it.value)
    }

    /// What is presumed of the no-load current, as a part of the current at standstill.
    pub fn presumed_share(&self) -> f64 {
        if self.sheet.gear.is_there {
            rules::GEARED_NO_LOAD_SHARE
        } else {
            rules::NO_LOAD_SHARE
        }
    }
}

/// What a torque for an ampere has lost on its way to the shaft that it is given at.
fn lossless(sheet: &Sheet) -> Result<f64, String> {
    if !(sheet.gear.is_there && sheet.gear.values_behind) {
        return Ok(1.0);
    }
    sheet.efficiency.ok_or_else(|| {
        "--torque-constant behind a gear has the gear's loss in it; expected --gear-efficiency with it, or \
         --no-load-speed, --stall-torque and --stall-current instead"
            .into()
    })
}

impl Derived {
    /// The machine of a data sheet.
    ///
    /// # Errors
    /// Numbers that contradict each other or are too few, in one line.
    pub fn of(sheet: &Sheet) -> Result<Self, String> {
        let point = Point::of(sheet)?;
        agreement::of_currents(&point)?;
        let resistance = resistance(&point)?;
        let torque_constant = torque_constant(&point, resistance.value)?;
        agreement::of_constants(&point, resistance.value)?;
        let idle = friction::no_load_current(&point, resistance.value, torque_constant.value)?;
        let share = share(&point, &resistance, &torque_constant, &idle)?;
        let friction = friction::of(&point, &resistance, &torque_constant, &idle, &share)?;
        let inertia = inertia(&point, resistance.value, torque_constant.value)?;
        Ok(Self {
            inductance: match &sheet.inductance {
                Some(measure) => Number::told(measure, 1.0, within([measure.rounding])),
                None => Number::new(0.0, "neglected, not given", Sure::Told),
            },
            gravity_torque: gravity_torque(sheet),
            resolution: resolution(sheet)?,
            resistance,
            torque_constant,
            inertia,
            friction,
            share,
        })
    }
}

fn resistance(point: &Point) -> Result<Number, String> {
    let sheet = point.sheet;
    if let Some(measure) = &sheet.resistance {
        let mut number = Number::told(measure, 1.0, within([measure.rounding]));
        number.why += &agreement::other_resistance(sheet, measure).unwrap_or_default();
        return Ok(number);
    }
    if let (Some(voltage), Some(current)) = (&sheet.voltage, &sheet.stall_current) {
        return Ok(Number::new(
            voltage.value / current.value,
            format!("{voltage} over {current}"),
            within([current.rounding]),
        ));
    }
    let missing = "the winding's resistance is missing; expected --resistance, or --stall-current and \
                   --voltage, or --voltage, --no-load-speed and --stall-torque";
    let (Some(voltage), Some(torque), Some(stall)) =
        (&sheet.voltage, &sheet.stall_torque, point.stall_torque)
    else {
        return Err(missing.into());
    };
    let passed = point
        .passed
        .ok_or_else(|| format!("{missing} (behind a gear with --gear-efficiency)"))?;
    let idle = sheet.no_load_current.as_ref();
    let current = idle.map_or(0.0, |measure| measure.value);
    let volts = voltage.value;
    // τ_s = η k (V/R − I₀), with k as it is given or as the no-load point has it, V = R I₀ + k ω₀.
    let (ohms, other) = match (point.constants.first(), &sheet.no_load_speed) {
        (Some((measure, constant)), _) => {
            (volts / (stall / (passed * constant) + current), *measure)
        }
        (None, Some(measure)) => {
            let speed = point.no_load_speed.unwrap_or_default();
            let sum = stall * speed / passed + 2.0 * volts * current;
            let root = (sum * sum - (2.0 * volts * current).powi(2)).sqrt();
            (2.0 * volts * volts / (sum + root), measure)
        }
        (None, None) => return Err(missing.into()),
    };
    Ok(Number::new(
        ohms,
        format!("from {voltage}, {torque} and {other}"),
        within([torque.rounding, other.rounding]),
    ))
}

fn torque_constant(point: &Point, resistance: f64) -> Result<Number, String> {
    let sheet = point.sheet;
    if let Some((measure, value)) = point.constants.first() {
        let factor = sheet.gear.sheet(measure)?;
        let mut number = Number::told(measure, factor, within([measure.rounding]));
        // The speed constant is the inverse of the others.
        if sheet.speed_constant.as_ref() == Some(measure) {
            number.why = number.why.replacen("given,", "1 over", 1);
        }
        if sheet.torque_constant.as_ref() == Some(measure) && *value != number.value {
            number.why += &format!(
                ", over the {} % that the gear passes on",
                significant(100.0 * number.value / *value)
            );
        }
        return Ok(Number {
            value: *value,
            ..number
        });
    }
    let idle = sheet.no_load_current.as_ref();
    if let (Some(voltage), Some(measure), Some(speed)) =
        (&sheet.voltage, &sheet.no_load_speed, point.no_load_speed)
    {
        let volts = voltage.value;
        let roundings = [measure.rounding];
        return match (idle, &sheet.friction_torque, point.friction_torque) {
            (Some(idle), _, _) => {
                let drop = idle.value * resistance;
                let referred = times(sheet.gear.sheet(measure)?);
                let why = format!("({voltage} − {idle} × resistance) over {measure}{referred}");
                let lost = drop / volts * idle.rounding;
                let sure = within(roundings.into_iter().chain([lost]));
                Ok(Number::new((volts - drop) / speed, why, sure))
            }
            (None, Some(friction), Some(torque)) => {
                // k ω₀ = V − R τ_f / k.
                let under = volts * volts - 4.0 * speed * resistance * torque;
                if under < 0.0 {
                    return Err(format!(
                        "{friction} contradicts {measure}: at {voltage} the motor would not reach it"
                    ));
                }
                let value = (volts + under.sqrt()) / (2.0 * speed);
                let why = format!("from {voltage}, {measure} and {friction}");
                Ok(Number::new(value, why, within(roundings)))
            }
            _ => {
                let share = point.presumed_share();
                let referred = times(sheet.gear.sheet(measure)?);
                let why = format!(
                    "{:.0} % of {voltage} over {measure}{referred}, the rest guessed for the no-load current",
                    100.0 * (1.0 - share)
                );
                let sure = within(roundings.into_iter().chain([share]));
                Ok(Number::new(volts * (1.0 - share) / speed, why, sure))
            }
        };
    }
    let missing = "the torque constant is missing; expected --torque-constant, --speed-constant or \
                   --back-emf-constant, or --voltage and --no-load-speed";
    let (Some(torque), Some(stall), Some(current)) = (
        &sheet.stall_torque,
        point.stall_torque,
        agreement::stall_current(point, resistance),
    ) else {
        return Err(missing.into());
    };
    let passed = point.passed.ok_or_else(|| {
        format!("{missing}; behind a gear --gear-efficiency makes --stall-torque do")
    })?;
    let lost = match idle {
        Some(idle) => idle.value,
        None if point.friction_torque.is_some() => 0.0,
        None => point.presumed_share() * current,
    };
    let extra = point.friction_torque.filter(|_| idle.is_none());
    let value = (stall + extra.unwrap_or(0.0)) / (passed * (current - lost));
    let referred = times(sheet.gear.sheet(torque)?);
    let and = match (&sheet.friction_torque, extra) {
        (Some(friction), Some(_)) => format!(" and {friction}"),
        _ => String::new(),
    };
    let less = if lost > 0.0 {
        format!(", less {} A that turn it without a load", significant(lost))
    } else {
        String::new()
    };
    let loss = if passed < 1.0 {
        format!(
            ", over the {} % that the gear passes on",
            significant(100.0 * passed)
        )
    } else {
        String::new()
    };
    let why = format!(
        "{torque}{and}{referred}, over the current at standstill, {} A{less}{loss}",
        significant(current)
    );
    let sure = within([torque.rounding, lost / current]);
    Ok(Number::new(value, why, sure))
}

/// What refers a number of the sheet to the coordinate, behind the number in a comment.
pub(super) fn times(factor: f64) -> String {
    if factor == 1.0 {
        String::new()
    } else {
        format!(", × {}", significant(factor))
    }
}

/// What the gear loses: as told, or what the stall torque lacks.
fn share(
    point: &Point,
    resistance: &Number,
    constant: &Number,
    idle: &Number,
) -> Result<Option<Number>, String> {
    let sheet = point.sheet;
    if !sheet.gear.is_there {
        agreement::of_stall(point, resistance.value, constant, idle)?;
        return Ok(None);
    }
    if let Some(efficiency) = sheet.efficiency {
        agreement::of_stall(point, resistance.value, constant, idle)?;
        let why = format!("1 − --gear-efficiency {}", given(efficiency));
        return Ok(Some(Number::new(1.0 - efficiency, why, within([]))));
    }
    if !sheet.gear.values_behind {
        agreement::of_stall(point, resistance.value, constant, idle)?;
        return Ok(None);
    }
    let (Some(torque), Some(stall), Some(current)) = (
        &sheet.stall_torque,
        point.stall_torque,
        agreement::stall_current(point, resistance.value),
    ) else {
        return Ok(None);
    };
    // Both denominators are positive: the no-load current is below that at standstill.
    let (left, whole) = friction::at_standstill(point, stall, constant.value, current, idle);
    let efficiency = left / whole;
    agreement::of_efficiency(point, torque, efficiency, whole, constant, current)?;
    let why = format!(
        "{torque} and friction are {} % of torque constant × current at standstill, {} A",
        given((1000.0 * efficiency).round() / 10.0),
        significant(current)
    );
    let sure = within([torque.rounding]);
    // What is within the tolerance of the whole may be none, and is taken for that.
    let lost = match sure {
        Sure::Within(part) if efficiency * (1.0 + part) >= 1.0 => 0.0,
        _ => 1.0 - efficiency,
    };
    Ok(Some(Number::new(lost, why, sure)))
}

fn inertia(point: &Point, resistance: f64, constant: f64) -> Result<Number, String> {
    let sheet = point.sheet;
    let settling = constant * constant / resistance;
    let (rotor, mut why, mut sure) = match (&sheet.rotor_inertia, &sheet.mechanical_time_constant) {
        (Some(measure), time) => {
            let factor = sheet.gear.motor(measure)?.powi(2);
            let number = Number::told(measure, factor, within([measure.rounding]));
            if let Some(time) = time {
                agreement::of_time_constant(measure, time, number.value / settling)?;
            }
            (number.value, number.why, number.sure)
        }
        (None, Some(time)) => (
            time.value * settling,
            format!("{time} × torque constant² over resistance"),
            within([time.rounding, 2.0 * rules::MAKERS_TOLERANCE]),
        ),
        (None, None) => (
            rules::TIME_CONSTANT * settling,
            format!(
                "guessed: {} ms × torque constant² over resistance, small motors have 3 to 20 ms; \
                 --rotor-inertia gives it",
                given(1e3 * rules::TIME_CONSTANT)
            ),
            Sure::Guess(rules::INERTIA_FACTOR),
        ),
    };
    let mut loads = Vec::new();
    if let Some(measure) = &sheet.load_inertia {
        loads.push((measure.value, format!("{measure}")));
    }
    if let (Some(mass), Some(length)) = (&sheet.pendulum_mass, &sheet.pendulum_length) {
        let value = mass.value * length.value * length.value;
        loads.push((value, format!("{mass} × {length}²")));
    }
    let load: f64 = loads.iter().map(|(value, _)| value).sum();
    for (value, text) in loads {
        why = format!("{why}; + {} of {text}", significant(value));
    }
    // A guess that hardly counts makes no guess of the sum.
    if let Sure::Guess(factor) = sure
        && rotor * (factor - 1.0) < rules::MAKERS_TOLERANCE * load
    {
        sure = within([]);
    }
    Ok(Number::new(rotor + load, why, sure))
}

fn gravity_torque(sheet: &Sheet) -> Option<Number> {
    let (mass, length) = (
        sheet.pendulum_mass.as_ref()?,
        sheet.pendulum_length.as_ref()?,
    );
    Some(Number::new(
        mass.value * GRAVITY * length.value,
        format!("{mass} × 9.80665 m/s² × {length}"),
        Sure::Told,
    ))
}

fn resolution(sheet: &Sheet) -> Result<Option<Number>, String> {
    if let Some(measure) = &sheet.resolution {
        return Ok(Some(Number::told(measure, 1.0, Sure::Told)));
    }
    let Some(encoder) = &sheet.encoder else {
        return Ok(None);
    };
    let gear = &sheet.gear;
    let (shaft, radians) = if encoder.at_motor {
        ("motor", gear.motor(&"--encoder-counts")?)
    } else {
        ("load", gear.output(&"--encoder-counts")?)
    };
    let counts = encoder.counts;
    Ok(Some(Number::new(
        std::f64::consts::TAU / (counts * radians),
        format!(
            "a turn over --encoder-counts {}, at the {shaft}'s shaft",
            given(counts)
        ),
        Sure::Told,
    )))
}

/// A number as it stands in the file: four digits that count, or fewer.
pub(super) fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    given(rounded)
}
