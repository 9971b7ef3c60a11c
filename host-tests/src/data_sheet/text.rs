//! Writes the machine file.

use model_core::gap::criterion;

use super::command::Args;
use super::derive::{Derived, Number, Sure, significant};
use super::measure::Measure;
use super::sheet::Sheet;
use crate::error::one_line;
use crate::import::call::quoted;
use crate::machine::{Coordinate, MOTOR};
use crate::outputs::MARK;
use crate::quantity::given;

/// Longest line of the head, characters, unless a word is longer.
const WIDTH: usize = 100;

/// Where the units begin, characters.
const COMMENT: usize = 32;

/// The machine file, each number with its unit, where it comes from and how sure it is.
pub(super) fn render(args: &Args, sheet: &Sheet, derived: &Derived) -> String {
    let coordinate = if sheet.gear.linear {
        Coordinate::Metre
    } else {
        Coordinate::Radian
    };
    let mut file = File {
        lines: head(args),
        coordinate,
    };
    file.plain(
        "name",
        &toml::Value::String(args.name.clone()).to_string(),
        "",
    );
    let referred = match (sheet.gear.is_there, sheet.gear.linear) {
        (true, false) => "the angle behind the gear, to which every number is referred",
        (true, true) => "the stroke behind gear and screw, to which every number is referred",
        (false, false) => "the angle of the motor's shaft",
        (false, true) => "the stroke",
    };
    file.plain(
        "coordinate",
        &format!("\"{}\"", coordinate.unit()),
        referred,
    );
    file.section("input");
    file.plain("kind", "\"voltage\"", "");
    file.plain("gain", &float(sheet.input.gain), &sheet.input.why);
    file.section("motor");
    file.number("resistance", &derived.resistance);
    file.number("inductance", &derived.inductance);
    file.number("torque_constant", &derived.torque_constant);
    file.section("mechanics");
    file.number("inertia", &derived.inertia);
    file.number("viscous", &derived.friction.viscous);
    file.told("spring", &sheet.spring);
    file.told("spring_rest", &sheet.spring_rest);
    file.told("spring_preload", &sheet.spring_preload);
    if let Some(gravity) = &derived.gravity_torque {
        file.number("gravity_torque", gravity);
        file.told("gravity_rest", &sheet.gravity_rest);
    }
    file.told("lower_stop", &sheet.lower_stop);
    file.told("upper_stop", &sheet.upper_stop);
    file.section("friction");
    file.number("coulomb", &derived.friction.coulomb);
    file.number("static", &derived.friction.breakaway);
    let ratio = sheet.gear.ratio;
    let ratio = ratio.filter(|ratio| *ratio != 1.0 && !sheet.gear.linear);
    if derived.resolution.is_some() || ratio.is_some() {
        file.section("sensor");
    }
    if let Some(resolution) = &derived.resolution {
        file.comment(&resolution.why);
        let comment = format!("{} a count", coordinate.unit());
        file.plain("resolution", &exact(resolution.value), &comment);
        if let Some(encoder) = &sheet.encoder {
            let side = if encoder.at_motor { "motor" } else { "load" };
            file.plain("side", &format!("\"{side}\""), "given, --encoder-side");
        }
    }
    if let Some(ratio) = ratio {
        let comment = "turns of the motor for one behind the gear: logs are checked for it";
        file.plain("gear_ratio", &exact(ratio), comment);
    }
    fit(&mut file, args, sheet, derived);
    file.lines.push(String::new());
    file.lines.join("\n")
}

fn fit(file: &mut File, args: &Args, sheet: &Sheet, derived: &Derived) {
    file.section("fit");
    file.comment(if args.measured_current {
        "What no data sheet knows of one machine; and, with a measured current, what it knows within a tolerance."
    } else {
        "What no data sheet knows of one machine. A log without a current cannot tell the scale of torques: \
         it is that of the winding, which stays as declared. With a measured current add \"resistance\" and \
         \"torque_constant\"."
    });
    let mut free = vec!["inertia", "viscous", "coulomb", "static"];
    if args.measured_current {
        free.extend(MOTOR);
    }
    // A spring's words are a guess as friction's are; one of nothing is none.
    let has = |measure: &Option<Measure>| measure.as_ref().is_some_and(|it| it.value > 0.0);
    if has(&sheet.spring) {
        free.push("spring");
    }
    if sheet.spring_preload.is_some() {
        free.push("spring_preload");
    }
    file.lines.push(format!("parameters = {free:?}"));
    let friction = &derived.friction;
    let guessed: Vec<String> = [
        ("inertia", &derived.inertia),
        ("viscous", &friction.viscous),
        ("coulomb", &friction.coulomb),
        ("static", &friction.breakaway),
    ]
    .into_iter()
    .filter_map(|(name, number)| match number.sure {
        // What is surer is fitted within the limits of any number.
        Sure::Guess(factor) if factor > f64::from(criterion::UNSURE) => {
            Some(format!("{name} = {factor:.1}"))
        }
        _ => None,
    })
    .collect();
    if !guessed.is_empty() {
        file.comment("By what factor the guesses may be off; a fit goes no further than its cube, nor than 45 times.");
        file.lines
            .push(format!("unsure = {{ {} }}", guessed.join(", ")));
    }
    if sheet.gear.is_there {
        of_loss(file, derived.share.as_ref());
    }
    file.lines.push("declared_effects = []".to_owned());
}

/// What the gear loses, which is not declared: no fit changes what is, a sheet's number is too unsure for that, and other numbers
/// would make up for one that is wrong.
fn of_loss(file: &mut File, share: Option<&Number>) {
    let Some(share) = share else {
        file.comment("What the gear loses is not known, and left for the logs to show.");
        return;
    };
    let from = format!("{}{}", share.why, sureness(share.sure));
    if share.value > 0.0 {
        file.comment(&format!(
            "What the gear loses is left for the logs to show: no fit changes what is declared. As the sheet has it \
             ({from}), it is this line in place of the one below it:"
        ));
        file.lines.push(format!(
            "# declared_effects = [{{ id = \"load_dependent_friction\", share = {} }}]",
            value(share.value)
        ));
    } else {
        file.comment(&format!(
            "What the gear loses may be nothing ({from}), and is left for the logs to show."
        ));
    }
}

/// A file that is being written.
struct File {
    lines: Vec<String>,
    coordinate: Coordinate,
}

impl File {
    fn section(&mut self, name: &str) {
        self.lines.extend([String::new(), format!("[{name}]")]);
    }

    fn plain(&mut self, key: &str, value: &str, comment: &str) {
        let entry = format!("{key} = {value}");
        self.lines.push(if comment.is_empty() {
            entry
        } else {
            format!("{entry:<COMMENT$}# {}", one_line(comment))
        });
    }

    fn number(&mut self, key: &str, number: &Number) {
        let unit = self.coordinate.parameter_unit(key).unwrap_or_default();
        self.comment(&number.why);
        let comment = format!("{unit}{}", sureness(number.sure));
        let told = number.sure == Sure::Told;
        let value = if told { exact } else { value };
        self.plain(key, &value(number.value), &comment);
    }

    fn told(&mut self, key: &str, measure: &Option<Measure>) {
        if let Some(measure) = measure {
            self.number(key, &Number::told(measure, 1.0, Sure::Told));
        }
    }

    /// Comment lines of their own.
    fn comment(&mut self, text: &str) {
        let text = one_line(text);
        let words = text.split(' ').map(str::to_owned);
        self.lines.extend(wrapped(words, "# ", "# ", ""));
    }
}

/// What says how sure a number is, before the number of per cent.
pub(crate) const WITHIN: &str = "±";

/// The same before a factor.
pub(crate) const UNSURE: &str = "unsure by a factor of ";

fn sureness(sure: Sure) -> String {
    match sure {
        Sure::Told => String::new(),
        Sure::Within(part) => format!(", {WITHIN}{:.0} %", 100.0 * part),
        Sure::Guess(factor) => format!(", {UNSURE}{factor:.1}"),
    }
}

/// Who wrote the file, from what, and the call that does it again.
fn head(args: &Args) -> Vec<String> {
    let mut lines = vec![format!(
        "# {MARK} machine: what a data sheet gives, what follows from it, and guesses."
    )];
    lines.push("#".to_owned());
    let call = call(args).into_iter();
    lines.extend(wrapped(call, "# ", "#     ", " \\"));
    lines.push(String::new());
    lines
}

/// The call that prints this file, its words as a shell takes them; an option with its value is one.
fn call(args: &Args) -> Vec<String> {
    let mut call = vec!["cargo hil machine".to_owned()];
    let mut option = |name: &str, value: Option<&String>| {
        if let Some(value) = value {
            call.push(format!("{name} {}", quoted(&one_line(value))));
        }
    };
    option("--name", Some(&args.name));
    option("--voltage", args.voltage.as_ref());
    option("--no-load-speed", args.no_load_speed.as_ref());
    option("--no-load-current", args.no_load_current.as_ref());
    option("--stall-torque", args.stall_torque.as_ref());
    option("--stall-current", args.stall_current.as_ref());
    option("--resistance", args.resistance.as_ref());
    option("--inductance", args.inductance.as_ref());
    option("--torque-constant", args.torque_constant.as_ref());
    option("--speed-constant", args.speed_constant.as_ref());
    option("--back-emf-constant", args.back_emf_constant.as_ref());
    option("--rotor-inertia", args.rotor_inertia.as_ref());
    option(
        "--mechanical-time-constant",
        args.mechanical_time_constant.as_ref(),
    );
    option("--friction-torque", args.friction_torque.as_ref());
    option("--load-friction", args.load_friction.as_ref());
    option("--breakaway-torque", args.breakaway_torque.as_ref());
    option("--viscous", args.viscous.as_ref());
    option("--gear-ratio", args.gear_ratio.as_ref());
    option("--gear-efficiency", args.gear_efficiency.as_ref());
    option("--screw-lead", args.screw_lead.as_ref());
    option("--values-of", args.values_of.as_ref());
    option("--load-inertia", args.load_inertia.as_ref());
    option("--pendulum-mass", args.pendulum_mass.as_ref());
    option("--pendulum-length", args.pendulum_length.as_ref());
    option("--gravity-rest", args.gravity_rest.as_ref());
    option("--spring", args.spring.as_ref());
    option("--spring-rest", args.spring_rest.as_ref());
    option("--spring-preload", args.spring_preload.as_ref());
    option("--lower-stop", args.lower_stop.as_ref());
    option("--upper-stop", args.upper_stop.as_ref());
    option("--encoder-counts", args.encoder_counts.as_ref());
    option("--encoder-side", args.encoder_side.as_ref());
    option("--resolution", args.resolution.as_ref());
    option("--input", Some(&args.input).filter(|input| *input != "V"));
    option("--supply", args.supply.as_ref());
    option("--source", args.source.as_ref());
    if args.measured_current {
        call.push("--measured-current".to_owned());
    }
    call
}

/// Words in lines of at most [`WIDTH`] characters, what goes on in the next line ends with `ending`.
fn wrapped(
    words: impl Iterator<Item = String>,
    first: &str,
    next: &str,
    ending: &str,
) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = first.to_owned();
    let mut is_empty = true;
    for word in words {
        let length = line.chars().count() + 1 + word.chars().count() + ending.chars().count();
        if !is_empty && length > WIDTH {
            lines.push(format!("{line}{ending}"));
            line = next.to_owned();
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
        }
        line.push_str(&word);
        is_empty = false;
    }
    lines.push(line);
    lines
}

/// A value with the digits that count, as TOML has a float.
fn value(value: f64) -> String {
    float(significant(value).parse().unwrap_or(value))
}

/// As [`value`], of what is not rounded by anyone before.
fn exact(value: f64) -> String {
    float(given(value).parse().unwrap_or(value))
}

/// As Rust writes it: `1e-5`, `0.5` and `12.0` are floats of TOML too.
fn float(value: f64) -> String {
    format!("{value:?}")
}
