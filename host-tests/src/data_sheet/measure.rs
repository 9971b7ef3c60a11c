//! Numbers as a data sheet has them: `5400rpm`, `12 mNm`, `2.3ohm`.

use std::f64::consts::TAU;

use crate::import::unit::{Kind, Unit};
use crate::log::quoted;

/// What an option of a data sheet measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Voltage,
    Current,
    Resistance,
    Inductance,
    /// rad/s, or m/s of what moves along a stroke.
    Speed,
    /// N·m, or N.
    Torque,
    /// N·m/A, or N/A.
    TorqueConstant,
    /// rad/s for a volt.
    SpeedConstant,
    /// V·s/rad.
    BackEmfConstant,
    /// kg·m², or kg.
    Inertia,
    Mass,
    Time,
    /// rad, or m.
    Position,
    Length,
    /// N·m·s/rad, or N·s/m.
    Viscous,
    /// N·m/rad, or N/m.
    Spring,
}

/// A number that the user gave.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Measure {
    /// The option that gave it, with its dashes.
    pub option: &'static str,
    /// As it was written.
    pub text: String,
    /// SI.
    pub value: f64,
    /// What rounding to the digits that were written may have changed, as a part of the value.
    pub rounding: f64,
    /// Whether its unit is one of motion along a stroke.
    pub linear: bool,
}

/// A unit: its spelling without `·`, `*`, `.`, `-` and `^`, what it measures, SI units in one of it, and
/// whether it is one of motion along a stroke.
type Entry = (&'static str, Quantity, f64, bool);

const RPM: f64 = TAU / 60.0;
/// Standard gravity, m/s², which a gram-force is made with.
pub(super) const GRAVITY: f64 = 9.806_65;
const INCH: f64 = 0.0254;
const OUNCE: f64 = 0.028_349_523_125;
const POUND: f64 = 16.0 * OUNCE;
const OUNCE_INCH: f64 = OUNCE * GRAVITY * INCH;

/// What no logger writes; the others are those of [`Unit`].
const UNITS: [Entry; 60] = {
    use Quantity::{
        BackEmfConstant, Inductance, Inertia, Mass, Resistance, SpeedConstant, Spring, Torque,
        TorqueConstant, Viscous,
    };
    [
        ("ohm", Resistance, 1.0, false),
        ("mohm", Resistance, 1e-3, false),
        ("kohm", Resistance, 1e3, false),
        ("H", Inductance, 1.0, false),
        ("mH", Inductance, 1e-3, false),
        ("uH", Inductance, 1e-6, false),
        // Torques with the force of a mass, as hobby motors have them.
        ("kgcm", Torque, 1e-2 * GRAVITY, false),
        ("kgm", Torque, GRAVITY, false),
        ("kgmm", Torque, 1e-3 * GRAVITY, false),
        ("gcm", Torque, 1e-5 * GRAVITY, false),
        ("ozfin", Torque, OUNCE_INCH, false),
        ("lbin", Torque, 16.0 * OUNCE_INCH, false),
        ("lbfin", Torque, 16.0 * OUNCE_INCH, false),
        ("lbft", Torque, 192.0 * OUNCE_INCH, false),
        ("lb", Torque, POUND * GRAVITY, true),
        ("Nm/A", TorqueConstant, 1.0, false),
        ("mNm/A", TorqueConstant, 1e-3, false),
        ("Ncm/A", TorqueConstant, 1e-2, false),
        ("ozin/A", TorqueConstant, OUNCE_INCH, false),
        ("kgcm/A", TorqueConstant, 1e-2 * GRAVITY, false),
        ("gcm/A", TorqueConstant, 1e-5 * GRAVITY, false),
        ("N/A", TorqueConstant, 1.0, true),
        ("rpm/V", SpeedConstant, RPM, false),
        ("min-1/V", SpeedConstant, RPM, false),
        ("rad/s/V", SpeedConstant, 1.0, false),
        ("rad/(sV)", SpeedConstant, 1.0, false),
        ("1/min/V", SpeedConstant, RPM, false),
        ("Vs/rad", BackEmfConstant, 1.0, false),
        ("V/(rad/s)", BackEmfConstant, 1.0, false),
        ("mVs/rad", BackEmfConstant, 1e-3, false),
        ("V/rpm", BackEmfConstant, 1.0 / RPM, false),
        ("mV/rpm", BackEmfConstant, 1e-3 / RPM, false),
        ("V/krpm", BackEmfConstant, 1e-3 / RPM, false),
        ("kgm2", Inertia, 1.0, false),
        ("kgcm2", Inertia, 1e-4, false),
        ("kgmm2", Inertia, 1e-6, false),
        ("gm2", Inertia, 1e-3, false),
        ("gcm2", Inertia, 1e-7, false),
        ("gmm2", Inertia, 1e-9, false),
        ("ozin2", Inertia, OUNCE * INCH * INCH, false),
        ("ozins2", Inertia, OUNCE_INCH, false),
        ("lbin2", Inertia, POUND * INCH * INCH, false),
        ("kg", Mass, 1.0, true),
        ("g", Mass, 1e-3, true),
        ("oz", Mass, OUNCE, true),
        ("Nms/rad", Viscous, 1.0, false),
        ("Nm/(rad/s)", Viscous, 1.0, false),
        ("Nms", Viscous, 1.0, false),
        ("mNms/rad", Viscous, 1e-3, false),
        ("mNm/rpm", Viscous, 1e-3 / RPM, false),
        ("Nm/rpm", Viscous, 1.0 / RPM, false),
        ("ozin/krpm", Viscous, 1e-3 * OUNCE_INCH / RPM, false),
        ("Ns/m", Viscous, 1.0, true),
        ("N/(m/s)", Viscous, 1.0, true),
        ("Nm/rad", Spring, 1.0, false),
        ("mNm/rad", Spring, 1e-3, false),
        ("Nm/deg", Spring, 360.0 / TAU, false),
        ("mNm/deg", Spring, 0.36 / TAU, false),
        ("N/m", Spring, 1.0, true),
        ("N/mm", Spring, 1e3, true),
    ]
};

impl Quantity {
    /// What of a logger's units measures it.
    fn kinds(self) -> &'static [Kind] {
        match self {
            Self::Voltage => &[Kind::Voltage],
            Self::Current => &[Kind::Current],
            Self::Speed => &[Kind::AngularVelocity, Kind::LinearVelocity],
            Self::Torque => &[Kind::Torque, Kind::Force],
            Self::Time => &[Kind::Time],
            Self::Position => &[Kind::Angle, Kind::Length],
            Self::Length => &[Kind::Length],
            _ => &[],
        }
    }

    /// Units of it, for messages: the usual ones.
    fn examples(self) -> &'static str {
        match self {
            Self::Voltage => "V, mV",
            Self::Current => "A, mA",
            Self::Resistance => "ohm, mohm, kohm",
            Self::Inductance => "H, mH, uH",
            Self::Speed => "rpm, rad/s, deg/s, rev/s, s/60deg; mm/s, m/s",
            Self::Torque => "Nm, mNm, Ncm, kg.cm, kg.mm, g.cm, oz.in, lb.in; N, kgf, lbf",
            Self::TorqueConstant => "Nm/A, mNm/A, Ncm/A, oz.in/A, kg.cm/A; N/A",
            Self::SpeedConstant => "rpm/V, rad/s/V",
            Self::BackEmfConstant => "V.s/rad, V/krpm, mV/rpm",
            Self::Inertia => "kg.m2, kg.cm2, g.cm2, g.mm2, oz.in2, oz.in.s2; kg, g along a stroke",
            Self::Mass => "kg, g, oz",
            Self::Time => "s, ms",
            Self::Position => "deg, rad, rev, counts/4096; mm, m, um",
            Self::Length => "m, cm, mm, in",
            Self::Viscous => "Nms/rad, mNms/rad, mNm/rpm; N.s/m",
            Self::Spring => "Nm/rad, mNm/rad, Nm/deg; N/m, N/mm",
        }
    }

    /// Whether a mass stands for it too: along a stroke the inertia is one.
    fn includes(self, other: Self) -> bool {
        self == other || (self == Self::Inertia && other == Self::Mass)
    }

    /// The factor of a unit, and whether it is one of motion along a stroke.
    fn unit(self, text: &str) -> Option<(f64, bool)> {
        let plain = plain(text);
        let own = |spelled: &dyn Fn(&str) -> bool| {
            let mut units = UNITS.iter();
            let found =
                units.find(|(name, quantity, ..)| self.includes(*quantity) && spelled(name));
            found.map(|&(_, _, factor, linear)| (factor, linear))
        };
        let of_loggers = |text: &str| {
            let unit = Unit::find(text).filter(|unit| self.kinds().contains(&unit.kind))?;
            let linear = matches!(unit.kind, Kind::LinearVelocity | Kind::Force | Kind::Length);
            Some((unit.factor, linear))
        };
        own(&|name| name == plain)
            .or_else(|| of_loggers(text))
            .or_else(|| of_loggers(&plain))
            .or_else(|| own(&|name| name.len() > 2 && name.eq_ignore_ascii_case(&plain)))
    }
}

/// The angle, rad, that the time before it is for, as in 0.16s/60deg: so hobby servos say their speed.
fn angle_for_a_time(unit: &str) -> Option<f64> {
    let (time, angle) = unit.split_once('/')?;
    if !matches!(time.trim(), "s" | "sec") {
        return None;
    }
    let (number, unit) = split(angle.trim());
    let unit = Unit::find(unit).filter(|unit| unit.kind == Kind::Angle)?;
    let angle = number.parse::<f64>().ok()? * unit.factor;
    (angle.is_finite() && angle > 0.0).then_some(angle)
}

/// A unit without what separates its parts, in letters of the keyboard.
fn plain(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '·' | '⋅' | '*' | '.' | '-' | '^' | ' ' => (),
            '²' => plain.push('2'),
            'Ω' | '\u{2126}' => plain.push_str("ohm"),
            'µ' | 'μ' => plain.push('u'),
            other => plain.push(other),
        }
    }
    plain
}

impl Measure {
    /// A number with its unit.
    ///
    /// # Errors
    /// What is wrong with it and what was expected, in one line.
    pub fn parse(option: &'static str, text: &str, quantity: Quantity) -> Result<Self, String> {
        let text = text.trim();
        let wrong = |reason: &str| {
            let examples = quantity.examples();
            format!(
                "{option} is {}: {reason}; expected a number with its unit ({examples})",
                quoted(text)
            )
        };
        let (number, unit) = split(text);
        if number.is_empty() {
            return Err(wrong("it does not begin with a number"));
        }
        if unit.starts_with(',') {
            return Err(wrong("a decimal comma; write a point"));
        }
        let value: f64 = number
            .parse()
            .map_err(|_| wrong(&format!("{} is not a number", quoted(number))))?;
        if unit.is_empty() {
            return Err(wrong("its unit is missing"));
        }
        let angle = angle_for_a_time(unit).filter(|_| quantity == Quantity::Speed);
        let (value, linear) = match (angle, quantity.unit(unit)) {
            (Some(angle), _) => (angle / value, false),
            (None, Some((factor, linear))) => (value * factor, linear),
            (None, None) => return Err(wrong(&format!("{} is no unit of it", quoted(unit)))),
        };
        if !value.is_finite() {
            return Err(wrong("it is too large"));
        }
        Ok(Self {
            option,
            text: text.to_owned(),
            value,
            rounding: rounding(number),
            linear,
        })
    }

    /// The number, if it is more than zero.
    ///
    /// # Errors
    /// One that is not.
    pub fn positive(self) -> Result<Self, String> {
        if self.value > 0.0 {
            Ok(self)
        } else {
            Err(format!("{self} is not more than 0"))
        }
    }

    /// The number, if it is not negative.
    ///
    /// # Errors
    /// One that is.
    pub fn not_negative(self) -> Result<Self, String> {
        if self.value >= 0.0 {
            Ok(self)
        } else {
            Err(format!("{self} is negative; expected 0 or more"))
        }
    }
}

impl std::fmt::Display for Measure {
    /// The option with what it says, as it may be typed.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.option, self.text)
    }
}

/// A plain number, as in `50`.
///
/// # Errors
/// What is none.
pub(super) fn number(option: &str, text: &str) -> Result<f64, String> {
    let (number, rest) = split(text.trim());
    match number.parse::<f64>() {
        Ok(value) if rest.is_empty() && value.is_finite() => Ok(value),
        _ => Err(format!(
            "{option} is {}; expected a number",
            quoted(text.trim())
        )),
    }
}

/// A number and what follows it. An exponent needs its digits: `2e` is 2 of the unit e.
pub(super) fn split(text: &str) -> (&str, &str) {
    let bytes = text.as_bytes();
    let digits = |from: usize| {
        let rest = bytes[from..].iter();
        rest.take_while(|byte| byte.is_ascii_digit()).count()
    };
    let sign = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
    let whole = digits(sign);
    let mut end = sign + whole;
    let mut all = whole;
    if bytes.get(end) == Some(&b'.') {
        let decimals = digits(end + 1);
        all += decimals;
        // A point behind the digits separates the unit unless digits follow.
        end += if decimals > 0 { 1 + decimals } else { 0 };
    }
    if all == 0 {
        return ("", text);
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        let power = digits(end + 1 + sign);
        if power > 0 {
            end += 1 + sign + power;
        }
    }
    (&text[..end], text[end..].trim_start())
}

/// Half a unit of the last digit that counts, as a part of the number. Zeros at the end of a whole number
/// hold its place (200 may have been 195 to 205), but two digits always count.
fn rounding(number: &str) -> f64 {
    let mantissa = number.split(['e', 'E']).next().unwrap_or(number);
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let digits = digits.trim_start_matches('0');
    let counted = if mantissa.contains('.') {
        digits
    } else {
        digits.trim_end_matches('0')
    };
    let count = if mantissa.contains('.') {
        counted.len()
    } else {
        counted.len().max(2.min(digits.len()))
    };
    let leading: f64 = digits
        .get(..count)
        .and_then(|digits| digits.parse().ok())
        .unwrap_or(0.0);
    if leading > 0.0 { 0.5 / leading } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_the_factors_of_their_definitions() {
        for (text, quantity, value) in [
            ("5400rpm", Quantity::Speed, 5400.0 * TAU / 60.0),
            ("5400 1/min", Quantity::Speed, 5400.0 * TAU / 60.0),
            ("32mm/s", Quantity::Speed, 0.032),
            ("0.16s/60deg", Quantity::Speed, TAU / 6.0 / 0.16),
            ("0.16 sec/60°", Quantity::Speed, TAU / 6.0 / 0.16),
            ("12 mNm", Quantity::Torque, 0.012),
            ("21kg.cm", Quantity::Torque, 21.0 * 0.098_066_5),
            ("21 kgf·cm", Quantity::Torque, 21.0 * 0.098_066_5),
            ("210kg·mm", Quantity::Torque, 2.1 * 0.980_665),
            ("200g.cm", Quantity::Torque, 200.0 * 9.806_65e-5),
            // NIST SP 811: 7.061552e-3 N·m.
            ("1oz.in", Quantity::Torque, 7.061_552e-3),
            ("1oz-in", Quantity::Torque, 7.061_552e-3),
            ("1lb.ft", Quantity::Torque, 1.355_818),
            ("10gcm2", Quantity::Inertia, 1e-6),
            ("10g·cm²", Quantity::Inertia, 1e-6),
            ("2kg", Quantity::Inertia, 2.0),
            // NIST SP 811: 1.829e-5 kg·m² for an ounce (avoirdupois) on a square inch.
            ("1oz.in2", Quantity::Inertia, 1.829e-5),
            ("2.3ohm", Quantity::Resistance, 2.3),
            ("2.3Ω", Quantity::Resistance, 2.3),
            ("310uH", Quantity::Inductance, 3.1e-4),
            ("0.31 mH", Quantity::Inductance, 3.1e-4),
            ("150mA", Quantity::Current, 0.15),
            ("29.2mNm/A", Quantity::TorqueConstant, 0.0292),
            ("1000rpm/V", Quantity::SpeedConstant, 1000.0 * TAU / 60.0),
            ("3V/krpm", Quantity::BackEmfConstant, 3e-3 * 60.0 / TAU),
            ("1.2mV/rpm", Quantity::BackEmfConstant, 1.2e-3 * 60.0 / TAU),
            ("1e-3Nms/rad", Quantity::Viscous, 1e-3),
            ("90deg", Quantity::Position, TAU / 4.0),
            ("1counts/4096", Quantity::Position, TAU / 4096.0),
            ("2mm", Quantity::Length, 2e-3),
        ] {
            let measure = Measure::parse("--x", text, quantity).unwrap();
            let off = (measure.value / value - 1.0).abs();
            // The definitions of NIST are printed with four to seven digits.
            assert!(off < 5e-5, "{text}: {} for {value}", measure.value);
        }
    }

    #[test]
    fn what_is_no_number_with_a_unit_is_refused() {
        for text in [
            "",
            "rpm",
            "nanV",
            "infV",
            "2,3V",
            "5",
            "5rpm",
            "5MV",
            "1e400V",
            "--V",
            "1..2V",
            ".V",
            "5 furlongs",
            "0x10V",
            "٣V",
        ] {
            let refused = Measure::parse("--voltage", text, Quantity::Voltage).unwrap_err();
            assert!(refused.starts_with("--voltage is \""), "{refused}");
            assert!(refused.contains("expected"), "{refused}");
        }
    }

    #[test]
    fn digits_say_how_far_a_number_was_rounded() {
        for (text, rounding) in [
            ("200rpm", 0.5 / 20.0),
            ("5400rpm", 0.5 / 54.0),
            ("10000rpm", 0.5 / 10.0),
            ("7670rpm", 0.5 / 767.0),
            ("0.2rpm", 0.5 / 2.0),
            ("0.20rpm", 0.5 / 20.0),
            ("5rpm", 0.5 / 5.0),
            ("5.50e3rpm", 0.5 / 550.0),
            ("0rpm", 0.0),
        ] {
            let measure = Measure::parse("--x", text, Quantity::Speed).unwrap();
            assert_eq!(measure.rounding, rounding, "{text}");
        }
    }
}
