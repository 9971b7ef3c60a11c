//! What the answer comes to, in words, and what to do next.

use std::path::Path;

use super::command::Args;
use super::table::{self, Validation};
use super::{Identified, UNCERTAIN};
use crate::free_run::Errors;
use crate::gap::terminal::wrapped;
use crate::import::call::quoted;
use crate::machine::{Coordinate, Machine};
use crate::quantity::{Scale, significant};

/// NRMSE of a free run up to which a model follows a log well: the throttle paper's models have 0.05 to 0.08 on theirs.
const WELL: f64 = 0.1;

/// NRMSE from which on it does not follow the log: a tenth of the motion's energy is left.
const NOT: f64 = 0.32;

/// The verdict and the next step, broken into lines; a command to copy stays in one.
pub(super) fn text(
    args: &Args,
    machine: &Machine,
    identified: &Identified,
    validation: Option<&Validation>,
) -> String {
    // The best one stands last.
    let models = table::models(identified);
    let best = models.len() - 1;
    let (name, model) = models[best];
    let worst = |a: Errors, b: Errors| if a.nrmse >= b.nrmse { a } else { b };
    let (log, errors) = match validation {
        Some(errors) => (
            "the validation log, which nothing was fitted to",
            errors[best],
        ),
        None => (
            "the log that it follows less well of the two that it was fitted to",
            worst(model.errors.slow, model.errors.fast),
        ),
    };
    let follows = Follows::of(errors);
    let verdict = format!(
        "Verdict: the model \"{name}\" {} {log}: started once and driven by the input alone it is off by {} % of how far \
         the position varies (rms), and by {} at most.",
        follows.words(),
        significant(100.0 * errors.nrmse, 2),
        length(errors.max_abs, machine.coordinate)
    );
    let (next, command) = next(args, identified, follows);
    let end = if command.is_some() { ":" } else { "." };
    let paragraphs = [verdict, format!("Next: {next}{end}")];
    let mut lines: Vec<String> = paragraphs
        .iter()
        .flat_map(|text| wrapped(text, 0))
        .collect();
    lines.extend(command.map(|command| format!("  {command}")));
    format!("\n{}\n", lines.join("\n"))
}

/// How well a model follows a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Follows {
    Well,
    Roughly,
    Not,
}

impl Follows {
    fn of(errors: Errors) -> Self {
        match errors.nrmse {
            nrmse if nrmse <= WELL => Self::Well,
            nrmse if nrmse <= NOT => Self::Roughly,
            // An error that is no number is of a run that diverged.
            _ => Self::Not,
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Well => "follows",
            Self::Roughly => "follows roughly",
            Self::Not => "does not follow",
        }
    }
}

fn length(value: f64, coordinate: Coordinate) -> String {
    match coordinate {
        Coordinate::Radian => format!("{}°", significant(value.to_degrees(), 3)),
        Coordinate::Metre => Scale::of("m", [value]).quantity(value),
    }
}

/// What to do, and the command to copy for the last of it.
fn next(args: &Args, identified: &Identified, follows: Follows) -> (String, Option<String>) {
    let shown = |path: &Path| quoted(&path.display().to_string());
    if follows == Follows::Not {
        let start = shown(&args.machine);
        let words = format!(
            "see that winding, stops and the spring's rest in {start} are those of this machine, and that the lines lie \
             along the points in the plot (--report DIR), then run it again"
        );
        return (words, None);
    }
    let mut steps = Vec::new();
    let numbers = identified.full.numbers.all();
    let uncertain = |number: &super::Number| {
        number.half_width.is_finite() && number.half_width > UNCERTAIN * number.value.abs()
    };
    if numbers.iter().any(uncertain) {
        steps.push(
            "record a longer triangle with more reversals on either side of the spring's rest, for a number is not well \
             known (see the notes)"
                .to_owned(),
        );
    }
    if args.validate.is_none() {
        steps.push("record another log, and give it with --validate".to_owned());
    }
    let machine = match &args.machine_out {
        Some(file) => shown(file),
        None => {
            steps.push("run it again with --machine-out M.toml".to_owned());
            "M.toml".to_owned()
        }
    };
    let validate = args.validate.as_ref();
    let validate = validate.map_or(String::new(), |log| format!(" --validate {}", shown(log)));
    steps.push("see whether an effect is missing beside the six numbers".to_owned());
    let fast = shown(&args.fast);
    let command = format!("cargo hil gap --machine {machine} --train {fast}{validate}");
    (steps.join("; "), Some(command))
}
