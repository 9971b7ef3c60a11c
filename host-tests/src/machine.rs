//! What the user declares about the actuator: the machine file, TOML.
//!
//! [`PARAMETERS`] is the one list of the numbers that describe it: which section they stand in,
//! whether they may be left out, their range and their units. Reading, checking, `[fit]` and the
//! units of the answer all follow it.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use model_core::effect::Id;
use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, Visitor};
use toml::Spanned;

use crate::data_sheet::WITHIN;
use crate::error::{InputError, LARGEST_DECLARATION, line_of, read_text, text_of};

/// The numbers of a motor that a data sheet has with a tolerance, and a log with a current tells.
pub const MOTOR: [&str; 2] = ["resistance", "torque_constant"];

/// A declared actuator. Numbers are SI, finite, within their ranges in [`PARAMETERS`], and neither
/// over- nor underflow in single precision. Motor-side values are referred to the coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// The file, as the user named it.
    pub path: PathBuf,
    /// What the user calls it.
    pub name: String,
    /// What its position is measured in.
    pub coordinate: Coordinate,
    /// V, or N·m or N, for one unit of the log's `input`; not zero, perhaps negative.
    pub gain: f64,
    /// The winding that a voltage drives. Without one, `input` × `gain` is the torque or force.
    pub motor: Option<Motor>,
    /// The moving parts.
    pub mechanics: Mechanics,
    /// Dry friction.
    pub friction: Friction,
    /// Resolution of the position sensor, rad or m per count, where it is known.
    pub resolution: Option<f64>,
    /// Where the position sensor sits, where it is known.
    pub sensor_side: Option<SensorSide>,
    /// Turns of the motor for one of the coordinate, where they are known.
    pub gear_ratio: Option<f64>,
    /// How far numbers may be off, as a share, where a comment behind them says so: `# Ω, ±10 %`.
    pub tolerances: BTreeMap<&'static str, f64>,
    /// Names from [`PARAMETERS`], each once, that may be re-estimated before an effect is sought.
    pub fit: Vec<String>,
    /// By what factor numbers of `fit` may be off, a standard deviation of their logarithm, where the file says so: in `unsure`,
    /// or of the motor's numbers as a tolerance in a comment.
    pub unsure: BTreeMap<String, f64>,
    /// Effects that the declared model already has.
    pub declared_effects: Vec<DeclaredEffect>,
}

/// The coordinate of the load: an angle or a stroke.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum Coordinate {
    /// An angle; loads are torques.
    #[serde(rename = "rad")]
    Radian,
    /// A stroke; loads are forces.
    #[serde(rename = "m")]
    Metre,
}

/// Where the position sensor sits on the way from the motor to the load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SensorSide {
    /// Before backlash and elastic parts: at the motor.
    Motor,
    /// Behind them: at the load.
    Load,
}

/// A brushed DC winding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Ω
    pub resistance: f64,
    /// H; zero neglects it.
    pub inductance: f64,
    /// N·m/A and V·s/rad, or N/A and V·s/m.
    pub torque_constant: f64,
}

/// The moving parts, what pulls at them and where they stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mechanics {
    /// kg·m² or kg
    pub inertia: f64,
    /// N·m·s/rad or N·s/m
    pub viscous: f64,
    /// N·m/rad or N/m; zero: no spring.
    pub spring: f64,
    /// Where the spring rests, rad or m.
    pub spring_rest: f64,
    /// Step of the spring's load on either side of its rest (limp-home spring), N·m or N.
    pub spring_preload: f64,
    /// Torque of an unbalanced load at a right angle to hanging, N·m; zero where the coordinate is m.
    pub gravity_torque: f64,
    /// Angle at which the load hangs, rad.
    pub gravity_rest: f64,
    /// Lower end stop, rad or m; less than `upper_stop`.
    pub lower_stop: Option<f64>,
    /// Upper end stop, rad or m.
    pub upper_stop: Option<f64>,
}

/// Dry friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// While sliding, N·m or N.
    pub coulomb: f64,
    /// At breakaway, N·m or N; not less than `coulomb`.
    pub r#static: f64,
}

/// An effect that the declared model already has. That its id and parameters are the catalogue's
/// is for the catalogue to check; [`Machine::error_at`] makes the error.
#[derive(Debug, Clone, PartialEq)]
pub struct DeclaredEffect {
    /// The catalogue's id.
    pub id: String,
    /// Its parameters, SI; at least one.
    pub parameters: BTreeMap<String, f64>,
    /// Where it stands in the machine file.
    pub line: usize,
}

impl DeclaredEffect {
    /// Its entry of `declared_effects`.
    pub(crate) fn to_toml(&self) -> String {
        let parameters = self.parameters.iter();
        let parameters: String = parameters
            .map(|(name, value)| format!(", {name} = {value:?}"))
            .collect();
        format!("{{ id = \"{}\"{parameters} }}", self.id)
    }
}

/// One number of `[motor]`, `[mechanics]` or `[friction]`.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Its key in the machine file.
    pub name: &'static str,
    /// The section that it stands in.
    pub section: &'static str,
    range: Range,
    optional: bool,
    rotary_unit: &'static str,
    linear_unit: Option<&'static str>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Range {
    Any,
    NonNegative,
    Positive,
}

impl Parameter {
    const fn new(
        section: &'static str,
        name: &'static str,
        range: Range,
        rotary_unit: &'static str,
        linear_unit: &'static str,
    ) -> Self {
        Self {
            name,
            section,
            range,
            optional: false,
            rotary_unit,
            linear_unit: Some(linear_unit),
        }
    }

    const fn optional(mut self) -> Self {
        self.optional = true;
        self
    }

    const fn rotary_only(mut self) -> Self {
        self.linear_unit = None;
        self
    }

    /// Its unit; `None` where it has no meaning in that coordinate.
    pub const fn unit(&self, coordinate: Coordinate) -> Option<&'static str> {
        match coordinate {
            Coordinate::Radian => Some(self.rotary_unit),
            Coordinate::Metre => self.linear_unit,
        }
    }
}

/// Every number of `[motor]`, `[mechanics]` and `[friction]`.
pub const PARAMETERS: [Parameter; 14] = {
    use Range::{Any, NonNegative, Positive};
    const fn motor(
        name: &'static str,
        range: Range,
        rad: &'static str,
        m: &'static str,
    ) -> Parameter {
        Parameter::new("motor", name, range, rad, m)
    }
    const fn mechanics(
        name: &'static str,
        range: Range,
        rad: &'static str,
        m: &'static str,
    ) -> Parameter {
        Parameter::new("mechanics", name, range, rad, m)
    }
    [
        motor("resistance", Positive, "Ω", "Ω"),
        motor("inductance", NonNegative, "H", "H"),
        motor("torque_constant", Positive, "N·m/A", "N/A"),
        mechanics("inertia", Positive, "kg·m²", "kg"),
        mechanics("viscous", NonNegative, "N·m·s/rad", "N·s/m"),
        mechanics("spring", NonNegative, "N·m/rad", "N/m").optional(),
        mechanics("spring_rest", Any, "rad", "m").optional(),
        mechanics("spring_preload", NonNegative, "N·m", "N").optional(),
        mechanics("gravity_torque", Any, "N·m", "")
            .optional()
            .rotary_only(),
        mechanics("gravity_rest", Any, "rad", "")
            .optional()
            .rotary_only(),
        mechanics("lower_stop", Any, "rad", "m").optional(),
        mechanics("upper_stop", Any, "rad", "m").optional(),
        Parameter::new("friction", "coulomb", NonNegative, "N·m", "N"),
        Parameter::new("friction", "static", NonNegative, "N·m", "N"),
    ]
};

impl Coordinate {
    /// Unit of the position: `rad` or `m`.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Radian => "rad",
            Self::Metre => "m",
        }
    }

    /// Unit of a torque or force: `N·m` or `N`.
    pub const fn load_unit(self) -> &'static str {
        match self {
            Self::Radian => "N·m",
            Self::Metre => "N",
        }
    }

    /// Unit of a number of [`PARAMETERS`]; `None` for another name, and for gravity's along a stroke.
    ///
    /// ```
    /// use host_tests::machine::Coordinate;
    ///
    /// assert_eq!(Coordinate::Metre.parameter_unit("viscous"), Some("N·s/m"));
    /// assert_eq!(Coordinate::Metre.parameter_unit("gravity_torque"), None);
    /// ```
    pub fn parameter_unit(self, name: &str) -> Option<&'static str> {
        PARAMETERS
            .iter()
            .find(|parameter| parameter.name == name)?
            .unit(self)
    }
}

/// What a file should have been, for messages.
const EXPECTED: &str = "a machine file (TOML)";

impl Machine {
    /// Reads and checks a machine file.
    ///
    /// # Errors
    /// The first fault found, with its line. A missing section is reported at the file's last line.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Ok(Self::read_with_text(path)?.0)
    }

    /// Whether `[fit]` names this parameter.
    pub fn fits(&self, parameter: &str) -> bool {
        self.fit.iter().any(|fitted| fitted == parameter)
    }

    /// As [`Machine::read`], with the file's text, which a pipe gives only once.
    pub(crate) fn read_with_text(path: &Path) -> Result<(Self, String), InputError> {
        let text = read_text(path, EXPECTED, LARGEST_DECLARATION)?;
        Ok((Self::of_text(path, &text)?, text))
    }

    /// As [`Machine::read`], of what a file holds.
    ///
    /// # Errors
    /// As [`Machine::read`].
    pub fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Self, InputError> {
        Self::of_text(path, &text_of(path, bytes, EXPECTED)?)
    }

    fn of_text(path: &Path, text: &str) -> Result<Self, InputError> {
        let source = Source { path, text };
        if text.trim().is_empty() {
            return Err(source.error(
                1,
                "is empty; the command that was to write it said why it did not",
            ));
        }
        let document = toml::from_str(text).map_err(|error| source.syntax_error(error))?;
        source.machine(document)
    }

    /// The declared value of a number of [`PARAMETERS`]; `None` for another name, for the winding's
    /// without `[motor]`, and for an end stop that is not there.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        let motor = self.motor.as_ref();
        let mechanics = &self.mechanics;
        match name {
            "resistance" => motor.map(|motor| motor.resistance),
            "inductance" => motor.map(|motor| motor.inductance),
            "torque_constant" => motor.map(|motor| motor.torque_constant),
            "inertia" => Some(mechanics.inertia),
            "viscous" => Some(mechanics.viscous),
            "spring" => Some(mechanics.spring),
            "spring_rest" => Some(mechanics.spring_rest),
            "spring_preload" => Some(mechanics.spring_preload),
            "gravity_torque" => Some(mechanics.gravity_torque),
            "gravity_rest" => Some(mechanics.gravity_rest),
            "lower_stop" => mechanics.lower_stop,
            "upper_stop" => mechanics.upper_stop,
            "coulomb" => Some(self.friction.coulomb),
            "static" => Some(self.friction.r#static),
            _ => None,
        }
    }

    /// An error at a line of the machine file, for what is checked where more is known.
    pub fn error_at(&self, line: usize, message: impl AsRef<str>) -> InputError {
        InputError::new(&self.path, Some(line), message)
    }
}

/// The file as it stands: syntax, keys and types are right, values and what is missing are not
/// checked. Required entries are optional here, so that their absence can be reported with a remedy.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    name: Option<Spanned<String>>,
    coordinate: Option<Coordinate>,
    input: Option<Spanned<InputSection>>,
    motor: Option<Numbers>,
    mechanics: Option<Numbers>,
    friction: Option<Numbers>,
    sensor: Option<SensorSection>,
    fit: Option<Spanned<FitSection>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a section")]
struct InputSection {
    kind: Option<InputKind>,
    gain: Option<Spanned<Number>>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum InputKind {
    Voltage,
    Torque,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, expecting = "a section")]
struct SensorSection {
    resolution: Option<Spanned<Number>>,
    side: Option<SensorSide>,
    gear_ratio: Option<Spanned<Number>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a section")]
struct FitSection {
    parameters: Option<Vec<Spanned<String>>>,
    #[serde(default)]
    unsure: BTreeMap<String, Spanned<Number>>,
    #[serde(default)]
    declared_effects: Vec<Spanned<EffectEntry>>,
}

/// `[motor]`, `[mechanics]` or `[friction]`; its keys are checked against [`PARAMETERS`].
type Numbers = Spanned<BTreeMap<String, Spanned<Number>>>;

/// A number that single precision holds.
#[derive(Clone, Copy)]
struct Number(f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberVisitor;

        impl Visitor<'_> for NumberVisitor {
            type Value = Number;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number in SI units")
            }

            fn visit_i64<E: de::Error>(self, value: i64) -> Result<Number, E> {
                Ok(Number(value as f64))
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<Number, E> {
                let size = value.abs();
                let held = f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX);
                if size == 0.0 || held.contains(&size) {
                    Ok(Number(value))
                } else {
                    Err(E::custom(format!(
                        "{value:?} is not a number that single precision holds; \
                         expected 0 or {:.1e} to {:.1e} in size",
                        held.start(),
                        held.end()
                    )))
                }
            }
        }

        deserializer.deserialize_f64(NumberVisitor)
    }
}

/// An entry of `declared_effects`.
struct EffectEntry {
    id: String,
    parameters: BTreeMap<String, f64>,
}

impl<'de> Deserialize<'de> for EffectEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct EntryVisitor;

        impl<'de> Visitor<'de> for EntryVisitor {
            type Value = EffectEntry;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(
                    "an effect with its parameters: { id = \"offset_torque\", torque = 0.1 }",
                )
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<EffectEntry, A::Error> {
                let mut id: Option<String> = None;
                let mut parameters = BTreeMap::new();
                while let Some(key) = map.next_key::<String>()? {
                    if key == "id" {
                        id = Some(map.next_value()?);
                    } else {
                        parameters.insert(key, map.next_value::<Number>()?.0);
                    }
                }
                match id {
                    // Of an id that is not known, that is what is said.
                    Some(id) if !parameters.is_empty() || Id::from_id(&id).is_none() => {
                        Ok(EffectEntry { id, parameters })
                    }
                    Some(_) => Err(de::Error::invalid_type(
                        de::Unexpected::Other("an effect without parameters"),
                        &self,
                    )),
                    None => Err(de::Error::invalid_type(
                        de::Unexpected::Other("an entry without `id`"),
                        &self,
                    )),
                }
            }
        }

        deserializer.deserialize_map(EntryVisitor)
    }
}

/// The file's text, to which errors refer.
struct Source<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Source<'_> {
    fn line<T>(&self, spanned: &Spanned<T>) -> usize {
        line_of(self.text.as_bytes(), spanned.span().start)
    }

    fn last_line(&self) -> usize {
        line_of(self.text.as_bytes(), self.text.trim_end().len())
    }

    fn error(&self, line: usize, message: impl AsRef<str>) -> InputError {
        InputError::new(self.path, Some(line), message)
    }

    fn missing_section(&self, section: &str, remedy: &str) -> InputError {
        self.error(
            self.last_line(),
            format!("the section [{section}] is missing; {remedy}"),
        )
    }

    /// The TOML reader's own error, in the words of the file's author.
    fn syntax_error(&self, mut error: toml::de::Error) -> InputError {
        let start = error.span().map_or(0, |span| span.start);
        // Without its excerpt of the file the error displays its message, then the key.
        error.set_input(None);
        let shown = error.to_string();
        let (message, key) = shown.split_at(error.message().len());
        let mut message = message.to_owned();
        for (serde, toml) in [
            ("unknown field", "unknown key"),
            ("unknown variant", "unknown value"),
            ("expected a sequence", "expected a list"),
            ("expected a map", "expected a section"),
        ] {
            message = message.replacen(serde, toml, 1);
        }
        if let Some(key) = key.trim().strip_prefix("in ") {
            message = format!("{key}: {message}");
        }
        if let Some(remedy) = self.decimal_comma(start) {
            message += &remedy;
        }
        self.error(line_of(self.text.as_bytes(), start), message)
    }

    /// What to do about a number with a decimal comma, where the reader stumbled over one.
    fn decimal_comma(&self, at: usize) -> Option<String> {
        let line = self
            .text
            .lines()
            .nth(line_of(self.text.as_bytes(), at) - 1)?;
        let (_, value) = line.split('#').next()?.split_once('=')?;
        let (whole, rest) = value.trim().split_once(',')?;
        let part: String = rest.chars().take_while(char::is_ascii_digit).collect();
        let digits = whole.trim_start_matches(['-', '+']);
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        (is_number(digits) && is_number(&part))
            .then(|| format!("; numbers take a decimal point, as in {whole}.{part}"))
    }

    /// Checks what types cannot say.
    fn machine(&self, document: Document) -> Result<Machine, InputError> {
        let name = document.name.ok_or_else(|| {
            self.error(1, "`name` is missing; expected `name = \"ema-24v\"`, say")
        })?;
        if name.get_ref().trim().is_empty() {
            return Err(self.error(self.line(&name), "`name` is empty; expected a name"));
        }
        let coordinate = document.coordinate.ok_or_else(|| {
            self.error(
                1,
                "`coordinate` is missing; expected `coordinate = \"rad\"` or \"m\"",
            )
        })?;

        let input = document
            .input
            .ok_or_else(|| self.missing_section("input", "expected it with `kind` and `gain`"))?;
        let input_line = self.line(&input);
        let input = input.into_inner();
        let kind = input.kind.ok_or_else(|| {
            self.error(
                input_line,
                "[input] has no `kind`; expected `kind = \"voltage\"` or \"torque\"",
            )
        })?;
        let gain = input.gain.ok_or_else(|| {
            let load_unit = coordinate.load_unit();
            let unit = match kind {
                InputKind::Voltage => "V",
                InputKind::Torque => load_unit,
            };
            self.error(
                input_line,
                format!("[input] has no `gain`; expected {unit} for one unit of `input`"),
            )
        })?;
        if gain.get_ref().0 == 0.0 {
            let message = "`gain` is 0, the input would do nothing; expected another number";
            return Err(self.error(self.line(&gain), message));
        }

        let motor = match (kind, document.motor) {
            (InputKind::Voltage, Some(numbers)) => {
                Some(self.section("motor", coordinate, numbers)?)
            }
            (InputKind::Voltage, None) => {
                let remedy = "a voltage drives a winding: add it with `resistance`, `inductance` \
                              and `torque_constant`, or set `kind = \"torque\"` in [input]";
                return Err(self.missing_section("motor", remedy));
            }
            (InputKind::Torque, Some(numbers)) => {
                let message = "[motor] has no use where [input] has `kind = \"torque\"`; remove \
                               it, or set `kind = \"voltage\"`";
                return Err(self.error(self.line(&numbers), message));
            }
            (InputKind::Torque, None) => None,
        };
        let mechanics = document.mechanics.ok_or_else(|| {
            self.missing_section(
                "mechanics",
                "expected it with at least `inertia` and `viscous`",
            )
        })?;
        let mechanics = self.section("mechanics", coordinate, mechanics)?;
        let friction = document.friction.ok_or_else(|| {
            self.missing_section("friction", "expected it with `coulomb` and `static`")
        })?;
        let friction = self.section("friction", coordinate, friction)?;
        self.check_stops(&mechanics)?;
        if friction.get("static") < friction.get("coulomb") {
            let message = format!(
                "`static` {:?} is less than `coulomb` {:?}; expected at least as much",
                friction.get("static"),
                friction.get("coulomb")
            );
            return Err(self.error(friction.line("static"), message));
        }

        let SensorSection {
            resolution,
            side,
            gear_ratio,
        } = document.sensor.unwrap_or_default();
        for (name, number) in [("resolution", &resolution), ("gear_ratio", &gear_ratio)] {
            if let Some(number) = number {
                self.check_range(name, Range::Positive, number)?;
            }
        }

        let fit = document.fit.ok_or_else(|| {
            let remedy = "expected it with `parameters`, a list of what may be re-estimated";
            self.missing_section("fit", remedy)
        })?;
        let fit_line = self.line(&fit);
        let fit = fit.into_inner();
        let parameters = fit.parameters.ok_or_else(|| {
            let message = "[fit] has no `parameters`; expected a list of what may be re-estimated";
            self.error(fit_line, message)
        })?;

        let sections = motor.iter().chain([&mechanics, &friction]);
        let tolerances = sections.flat_map(|section| self.tolerances(section));
        let tolerances = tolerances.collect();
        let mut machine = Machine {
            path: self.path.to_owned(),
            name: name.into_inner(),
            coordinate,
            gain: gain.get_ref().0,
            motor: motor.map(|motor| Motor {
                resistance: motor.get("resistance"),
                inductance: motor.get("inductance"),
                torque_constant: motor.get("torque_constant"),
            }),
            mechanics: Mechanics {
                inertia: mechanics.get("inertia"),
                viscous: mechanics.get("viscous"),
                spring: mechanics.get("spring"),
                spring_rest: mechanics.get("spring_rest"),
                spring_preload: mechanics.get("spring_preload"),
                gravity_torque: mechanics.get("gravity_torque"),
                gravity_rest: mechanics.get("gravity_rest"),
                lower_stop: mechanics.given("lower_stop"),
                upper_stop: mechanics.given("upper_stop"),
            },
            friction: Friction {
                coulomb: friction.get("coulomb"),
                r#static: friction.get("static"),
            },
            resolution: resolution.map(|resolution| resolution.get_ref().0),
            sensor_side: side,
            gear_ratio: gear_ratio.map(|ratio| ratio.get_ref().0),
            tolerances,
            fit: parameters
                .iter()
                .map(|name| name.get_ref().clone())
                .collect(),
            unsure: fit
                .unsure
                .iter()
                .map(|(name, factor)| (name.clone(), factor.get_ref().0))
                .collect(),
            declared_effects: fit
                .declared_effects
                .into_iter()
                .map(|entry| {
                    let line = self.line(&entry);
                    let EffectEntry { id, parameters } = entry.into_inner();
                    DeclaredEffect {
                        id,
                        parameters,
                        line,
                    }
                })
                .collect(),
        };
        self.check_fit(&machine, &parameters)?;
        self.check_unsure(&machine, &fit.unsure)?;
        for name in MOTOR {
            let tolerance = machine.tolerances.get(name).copied();
            if let Some(tolerance) = tolerance.filter(|_| machine.fits(name)) {
                let stated = machine.unsure.entry(name.to_owned());
                stated.or_insert(1.0 + tolerance);
            }
        }
        Ok(machine)
    }

    /// The numbers of a section: none unknown, none missing, each in its range.
    fn section(
        &self,
        section: &'static str,
        coordinate: Coordinate,
        numbers: Numbers,
    ) -> Result<Section, InputError> {
        let line = self.line(&numbers);
        let known = || PARAMETERS.iter().filter(|known| known.section == section);
        let mut values = BTreeMap::new();
        for (name, number) in numbers.into_inner() {
            let line = self.line(&number);
            let Some(parameter) = known().find(|parameter| parameter.name == name) else {
                if let Some(other) = PARAMETERS.iter().find(|other| other.name == name) {
                    return Err(self.error(line, self.misplaced(&name, section, other.section)));
                }
                let names = list(
                    known()
                        .filter(|parameter| parameter.unit(coordinate).is_some())
                        .map(|parameter| parameter.name),
                );
                let message = format!("unknown key `{name}` in [{section}], expected {names}");
                return Err(self.error(line, message));
            };
            if parameter.unit(coordinate).is_none() {
                let message = format!(
                    "`{name}` is for rotary machines only; remove it, or set `coordinate = \"rad\"`"
                );
                return Err(self.error(line, message));
            }
            self.check_range(parameter.name, parameter.range, &number)?;
            values.insert(parameter.name, (number.get_ref().0, line));
        }
        for parameter in known() {
            if !parameter.optional && !values.contains_key(parameter.name) {
                let unit = parameter.unit(coordinate).unwrap_or_default();
                let message = format!(
                    "[{section}] has no `{}`; expected a number in {unit}",
                    parameter.name
                );
                return Err(self.error(line, message));
            }
        }
        Ok(Section(values))
    }

    /// What is wrong with a number that stands in another section than its own.
    fn misplaced(&self, name: &str, section: &str, own: &str) -> String {
        let header = format!("[{own}]");
        let is_there = self
            .text
            .lines()
            .any(|line| line.trim().starts_with(&header));
        let missing = if is_there {
            String::new()
        } else {
            format!(", and the line {header} is missing")
        };
        format!("`{name}` stands in [{section}]; it belongs into {header}{missing}")
    }

    /// What the comments behind the numbers of a section say of how far they may be off.
    fn tolerances(&self, section: &Section) -> Vec<(&'static str, f64)> {
        let stated = |line: usize| {
            let (_, comment) = self.text.lines().nth(line - 1)?.split_once('#')?;
            let (_, stated) = comment.split_once(WITHIN)?;
            let (percent, _) = stated.split_once('%')?;
            let percent: f64 = percent.trim().parse().ok()?;
            (percent > 0.0).then_some(0.01 * percent)
        };
        let numbers = section.0.iter();
        numbers
            .filter_map(|(name, (_, line))| Some((*name, stated(*line)?)))
            .collect()
    }

    fn check_range(
        &self,
        name: &str,
        range: Range,
        number: &Spanned<Number>,
    ) -> Result<(), InputError> {
        let value = number.get_ref().0;
        let expected = match range {
            Range::NonNegative if value < 0.0 => "0 or more",
            Range::Positive if value <= 0.0 => "more than 0",
            _ => return Ok(()),
        };
        let message = format!("`{name}` is {value:?}, expected {expected}");
        Err(self.error(self.line(number), message))
    }

    fn check_stops(&self, mechanics: &Section) -> Result<(), InputError> {
        if let (Some(lower), Some(upper)) =
            (mechanics.given("lower_stop"), mechanics.given("upper_stop"))
            // In the precision that the model computes in.
            && lower as f32 >= upper as f32
        {
            let message = format!(
                "`lower_stop` {lower:?} is not below `upper_stop` {upper:?}; expected room to move"
            );
            return Err(self.error(mechanics.line("lower_stop"), message));
        }
        Ok(())
    }

    fn check_fit(&self, machine: &Machine, names: &[Spanned<String>]) -> Result<(), InputError> {
        for (place, spanned) in names.iter().enumerate() {
            let name = spanned.get_ref();
            if names[..place]
                .iter()
                .any(|earlier| earlier.get_ref() == name)
            {
                let message = format!("`{name}` is in `parameters` twice; remove one");
                return Err(self.error(self.line(spanned), message));
            }
            let fits = |parameter: &&Parameter| {
                parameter.unit(machine.coordinate).is_some()
                    && machine.parameter(parameter.name).is_some()
            };
            let mut valid = PARAMETERS
                .iter()
                .filter(fits)
                .map(|parameter| parameter.name);
            if !valid.clone().any(|known| known == name) {
                let message = format!(
                    "`{name}` cannot be fitted, this machine has no such number; expected {}",
                    list(&mut valid)
                );
                return Err(self.error(self.line(spanned), message));
            }
        }
        Ok(())
    }

    /// The factors of `unsure`: each of a number that is fitted, and none that narrows what is left of it to nothing.
    fn check_unsure(
        &self,
        machine: &Machine,
        factors: &BTreeMap<String, Spanned<Number>>,
    ) -> Result<(), InputError> {
        for (name, factor) in factors {
            if !machine.fits(name) {
                let fitted = list(machine.fit.iter().map(String::as_str));
                let expected = match fitted.as_str() {
                    "" => "which is empty; remove it".to_owned(),
                    fitted => format!("expected {fitted}"),
                };
                let message = format!("`{name}` of `unsure` is not in `parameters`, {expected}");
                return Err(self.error(self.line(factor), message));
            }
            let value = factor.get_ref().0;
            if value < 1.0 {
                let message = format!(
                    "`{name}` of `unsure` is {value:?}, expected a factor of 1 or more: with 3.0 it may be a third \
                     or three times what is declared"
                );
                return Err(self.error(self.line(factor), message));
            }
        }
        Ok(())
    }
}

/// The checked numbers of a section, each with its line.
struct Section(BTreeMap<&'static str, (f64, usize)>);

impl Section {
    fn given(&self, name: &str) -> Option<f64> {
        self.0.get(name).map(|&(value, _)| value)
    }

    /// The number, or 0 if an optional one was left out.
    fn get(&self, name: &str) -> f64 {
        self.given(name).unwrap_or(0.0)
    }

    /// The line of a number that was given.
    fn line(&self, name: &str) -> usize {
        self.0[name].1
    }
}

/// "`a`, `b` or `c`".
fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<String> = names.map(|name| format!("`{name}`")).collect();
    match names.split_last() {
        Some((last, [])) => last.clone(),
        Some((last, others)) => format!("{} or {last}", others.join(", ")),
        None => String::new(),
    }
}
