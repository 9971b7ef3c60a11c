//! The options of `cargo hil machine`, read.

use std::f64::consts::TAU;

use super::command::Args;
use super::measure::{Measure, Quantity, number};
use crate::log::quoted;

/// What a data sheet says, SI, each number in its own range.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    pub voltage: Option<Measure>,
    pub no_load_speed: Option<Measure>,
    pub no_load_current: Option<Measure>,
    pub stall_torque: Option<Measure>,
    pub stall_current: Option<Measure>,
    pub resistance: Option<Measure>,
    pub inductance: Option<Measure>,
    pub torque_constant: Option<Measure>,
    pub speed_constant: Option<Measure>,
    pub back_emf_constant: Option<Measure>,
    pub rotor_inertia: Option<Measure>,
    pub mechanical_time_constant: Option<Measure>,
    pub friction_torque: Option<Measure>,
    pub load_friction: Option<Measure>,
    pub breakaway_torque: Option<Measure>,
    pub viscous: Option<Measure>,
    pub load_inertia: Option<Measure>,
    pub pendulum_mass: Option<Measure>,
    pub pendulum_length: Option<Measure>,
    pub gravity_rest: Option<Measure>,
    pub spring: Option<Measure>,
    pub spring_rest: Option<Measure>,
    pub spring_preload: Option<Measure>,
    pub lower_stop: Option<Measure>,
    pub upper_stop: Option<Measure>,
    pub resolution: Option<Measure>,
    pub efficiency: Option<f64>,
    pub encoder: Option<Encoder>,
    pub input: Input,
    pub gear: Gear,
}

/// Between the motor and the coordinate.
#[derive(Debug, Clone)]
pub(super) struct Gear {
    /// Turns of the motor for one of the gear's output; none where the sheet of a gearmotor does not say.
    pub ratio: Option<f64>,
    /// Way for a turn of the gear's output, where there is a screw.
    pub lead: Option<Measure>,
    /// Whether there is gear or screw.
    pub is_there: bool,
    /// Whether the sheet's values are those behind it.
    pub values_behind: bool,
    /// Whether the coordinate is a stroke.
    pub linear: bool,
}

/// An encoder by its counts.
#[derive(Debug, Clone)]
pub(super) struct Encoder {
    /// For a turn of its shaft.
    pub counts: f64,
    /// Whether that is the motor's.
    pub at_motor: bool,
}

/// What the log's input is.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Input {
    /// V for one unit of it.
    pub gain: f64,
    /// Where that comes from.
    pub why: String,
}

impl Gear {
    /// Radians of the gear's output for one unit of the coordinate.
    ///
    /// # Errors
    /// A stroke without the lead that leads to it.
    pub fn output(&self, asking: &dyn std::fmt::Display) -> Result<f64, String> {
        match &self.lead {
            Some(lead) => Ok(TAU / lead.value),
            None if self.linear => Err(format!(
                "{asking} is a rotary value of a linear machine; --screw-lead refers it to the stroke"
            )),
            None => Ok(1.0),
        }
    }

    /// Radians of the motor for one unit of the coordinate.
    ///
    /// # Errors
    /// As [`Gear::output`]; a gear whose ratio nobody has said.
    pub fn motor(&self, asking: &dyn std::fmt::Display) -> Result<f64, String> {
        let ratio = self.ratio.ok_or_else(|| {
            format!(
                "{asking} is a value of the motor's shaft, and the gear's ratio is not known; --gear-ratio refers it to \
                 the output"
            )
        })?;
        Ok(ratio * self.output(asking)?)
    }

    /// Radians of the shaft whose values the sheet gives for one unit of the coordinate; 1 for a value that
    /// is one of the stroke.
    ///
    /// # Errors
    /// As [`Gear::output`].
    pub fn sheet(&self, measure: &Measure) -> Result<f64, String> {
        match (measure.linear, self.values_behind) {
            (true, _) => Ok(1.0),
            (false, true) => self.output(measure),
            (false, false) => self.motor(measure),
        }
    }
}

type Found = Result<Option<Measure>, String>;

fn any(option: &'static str, text: &Option<String>, quantity: Quantity) -> Found {
    let text = text.as_deref();
    text.map(|text| Measure::parse(option, text, quantity))
        .transpose()
}

fn positive(option: &'static str, text: &Option<String>, quantity: Quantity) -> Found {
    any(option, text, quantity)?
        .map(Measure::positive)
        .transpose()
}

fn not_negative(option: &'static str, text: &Option<String>, quantity: Quantity) -> Found {
    any(option, text, quantity)?
        .map(Measure::not_negative)
        .transpose()
}

impl Sheet {
    /// Reads the options: each number by itself, and what has to be known of the gear.
    ///
    /// # Errors
    /// What is wrong and what was expected, in one line.
    pub fn read(args: &Args) -> Result<Self, String> {
        use Quantity as Q;
        if args.name.trim().is_empty() {
            return Err("--name is empty; expected a name".into());
        }
        let voltage = positive("--voltage", &args.voltage, Q::Voltage)?;
        // What a sheet's numbers are given at is exact.
        let voltage = voltage.map(|measure| Measure {
            rounding: 0.0,
            ..measure
        });
        let mut sheet = Self {
            no_load_speed: positive("--no-load-speed", &args.no_load_speed, Q::Speed)?,
            no_load_current: positive("--no-load-current", &args.no_load_current, Q::Current)?,
            stall_torque: positive("--stall-torque", &args.stall_torque, Q::Torque)?,
            stall_current: positive("--stall-current", &args.stall_current, Q::Current)?,
            resistance: positive("--resistance", &args.resistance, Q::Resistance)?,
            inductance: not_negative("--inductance", &args.inductance, Q::Inductance)?,
            torque_constant: positive(
                "--torque-constant",
                &args.torque_constant,
                Q::TorqueConstant,
            )?,
            speed_constant: positive("--speed-constant", &args.speed_constant, Q::SpeedConstant)?,
            back_emf_constant: positive(
                "--back-emf-constant",
                &args.back_emf_constant,
                Q::BackEmfConstant,
            )?,
            rotor_inertia: positive("--rotor-inertia", &args.rotor_inertia, Q::Inertia)?,
            mechanical_time_constant: positive(
                "--mechanical-time-constant",
                &args.mechanical_time_constant,
                Q::Time,
            )?,
            friction_torque: not_negative("--friction-torque", &args.friction_torque, Q::Torque)?,
            load_friction: not_negative("--load-friction", &args.load_friction, Q::Torque)?,
            breakaway_torque: not_negative(
                "--breakaway-torque",
                &args.breakaway_torque,
                Q::Torque,
            )?,
            viscous: not_negative("--viscous", &args.viscous, Q::Viscous)?,
            load_inertia: not_negative("--load-inertia", &args.load_inertia, Q::Inertia)?,
            pendulum_mass: positive("--pendulum-mass", &args.pendulum_mass, Q::Mass)?,
            pendulum_length: positive("--pendulum-length", &args.pendulum_length, Q::Length)?,
            gravity_rest: any("--gravity-rest", &args.gravity_rest, Q::Position)?,
            spring: not_negative("--spring", &args.spring, Q::Spring)?,
            spring_rest: any("--spring-rest", &args.spring_rest, Q::Position)?,
            spring_preload: not_negative("--spring-preload", &args.spring_preload, Q::Torque)?,
            lower_stop: any("--lower-stop", &args.lower_stop, Q::Position)?,
            upper_stop: any("--upper-stop", &args.upper_stop, Q::Position)?,
            resolution: positive("--resolution", &args.resolution, Q::Position)?,
            efficiency: efficiency(args)?,
            encoder: encoder(args)?,
            input: input(args, voltage.as_ref())?,
            gear: gear(args)?,
            voltage,
        };
        sheet.gear.linear = sheet.is_linear();
        sheet.check_sides()?;
        if sheet.efficiency.is_some() && !sheet.gear.is_there {
            return Err(
                "--gear-efficiency without a gear; --gear-ratio, --screw-lead or --values-of gearmotor says that there is one"
                    .into(),
            );
        }
        Ok(sheet)
    }

    fn is_linear(&self) -> bool {
        let at_coordinate = [&self.no_load_speed, &self.stall_torque];
        let of_stroke = |measure: &&Option<Measure>| measure.as_ref().is_some_and(|it| it.linear);
        self.gear.lead.is_some() || at_coordinate.iter().any(of_stroke)
    }

    /// What stands at the coordinate has to be of its kind: an angle's, or a stroke's.
    fn check_sides(&self) -> Result<(), String> {
        let linear = self.gear.linear;
        for measure in [
            &self.viscous,
            &self.load_inertia,
            &self.load_friction,
            &self.spring,
            &self.spring_rest,
            &self.spring_preload,
            &self.lower_stop,
            &self.upper_stop,
            &self.resolution,
        ]
        .into_iter()
        .flatten()
        {
            if measure.linear != linear {
                let (is, coordinate, remedy) = if linear {
                    ("an angle's", "a stroke", "give it along the stroke")
                } else {
                    ("a stroke's", "an angle", "--screw-lead makes it a stroke")
                };
                return Err(format!(
                    "{measure} is {is} value, and the coordinate is {coordinate}; {remedy}"
                ));
            }
        }
        for measure in [
            &self.friction_torque,
            &self.breakaway_torque,
            &self.torque_constant,
        ]
        .into_iter()
        .flatten()
        {
            if measure.linear && !linear {
                return Err(format!(
                    "{measure} is a stroke's value, and the coordinate is an angle; --screw-lead makes \
                     it a stroke"
                ));
            }
        }
        if let Some(inertia) = &self.rotor_inertia
            && inertia.linear
        {
            return Err(format!(
                "{inertia} is a mass; expected a rotor's inertia (g.cm2), or --load-inertia for a mass"
            ));
        }
        if let (true, Some(mass)) = (linear, &self.pendulum_mass) {
            return Err(format!(
                "{mass} is for rotary machines only, and the coordinate is a stroke; --load-inertia has \
                 what a linear machine moves"
            ));
        }
        if let Some(rest) = self.gravity_rest.as_ref().filter(|rest| rest.linear) {
            return Err(format!("{rest} is a length; expected an angle"));
        }
        if let (Some(lower), Some(upper)) = (&self.lower_stop, &self.upper_stop)
            && lower.value >= upper.value
        {
            return Err(format!(
                "{lower} is not below {upper}; expected room to move"
            ));
        }
        Ok(())
    }
}

fn efficiency(args: &Args) -> Result<Option<f64>, String> {
    let Some(text) = &args.gear_efficiency else {
        return Ok(None);
    };
    let text = text.trim();
    let value = match text.strip_suffix('%') {
        Some(percent) => number("--gear-efficiency", percent)? / 100.0,
        None => number("--gear-efficiency", text)?,
    };
    // The core's bound of the share that a gear may take.
    if (0.05..=1.0).contains(&value) {
        return Ok(Some(value));
    }
    Err(format!(
        "--gear-efficiency is {}: expected 0.05 to 1, or 5% to 100%",
        quoted(text)
    ))
}

fn gear(args: &Args) -> Result<Gear, String> {
    let ratio = match &args.gear_ratio {
        None => None,
        Some(text) => {
            let wrong = || {
                format!(
                    "--gear-ratio is {}: expected turns of the motor for one of the output, 1 to 1e6, as in \
                     50 or 50:1",
                    quoted(text)
                )
            };
            let plain = text.trim().strip_suffix(":1").unwrap_or(text.trim());
            let ratio = number("--gear-ratio", plain).map_err(|_| wrong())?;
            if !(1.0..=1e6).contains(&ratio) {
                return Err(wrong());
            }
            Some(ratio)
        }
    };
    let lead = positive("--screw-lead", &args.screw_lead, Quantity::Length)?;
    let has_ratio_or_lead = ratio.is_some() || lead.is_some();
    let values_behind = match args.values_of.as_deref() {
        Some(side) => side == "gearmotor",
        None if has_ratio_or_lead => {
            return Err(
                "there is a gear or screw, and nothing says whose values these are; expected --values-of \
                 motor (speeds and torques of the motor alone) or --values-of gearmotor (those behind the \
                 gear)"
                    .into(),
            );
        }
        None => false,
    };
    Ok(Gear {
        // Without a gear, or with a screw alone, the motor turns as the output does. A gearmotor has a gear.
        ratio: ratio.or((!values_behind || lead.is_some()).then_some(1.0)),
        is_there: has_ratio_or_lead || values_behind,
        lead,
        values_behind,
        linear: false,
    })
}

fn encoder(args: &Args) -> Result<Option<Encoder>, String> {
    let Some(text) = &args.encoder_counts else {
        return Ok(None);
    };
    let counts = number("--encoder-counts", text)?;
    if counts < 1.0 {
        return Err(format!(
            "--encoder-counts is {}: expected 1 or more",
            quoted(text)
        ));
    }
    Ok(Some(Encoder {
        counts,
        at_motor: args.encoder_side.as_deref() == Some("motor"),
    }))
}

fn input(args: &Args, voltage: Option<&Measure>) -> Result<Input, String> {
    let supply = positive("--supply", &args.supply, Quantity::Voltage)?;
    let text = args.input.trim();
    let whole = match text {
        "V" | "mV" => {
            let gain = if text == "V" { 1.0 } else { 1e-3 };
            let why = format!("V for one unit of `input`, which is in {text} (--input)");
            return match supply {
                Some(supply) => Err(format!(
                    "{supply} has no use where the input is in {text}; --input duty is a part of it"
                )),
                None => Ok(Input { gain, why }),
            };
        }
        "duty" => 1.0,
        "%" => 100.0,
        _ => text
            .strip_prefix("duty/")
            .and_then(|whole| number("--input", whole).ok())
            .filter(|whole| *whole > 0.0)
            .ok_or_else(|| {
                format!(
                    "--input is {}: expected V, mV, duty, % or duty/255 (so many for the whole supply)",
                    quoted(text)
                )
            })?,
    };
    let supply = supply.as_ref().or(voltage).ok_or_else(|| {
        format!(
            "--input {text} is a part of a supply that is not known; expected --supply or --voltage"
        )
    })?;
    Ok(Input {
        gain: supply.value / whole,
        why: format!("V for one unit of `input`: {text} of the supply ({supply})"),
    })
}
