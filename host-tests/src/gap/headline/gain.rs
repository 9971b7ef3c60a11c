//! How much better the model is with what was found, and what has become worse.

use model_core::gap::verdict::Verdict;

use crate::gap::answer::listed;
use crate::gap::outcome::{ErrorSet, Report, Stages, rises_clearly};
use crate::gap::table::is_extended;
use crate::quantity::{Scale, change};

/// Ratio of two errors up to which the second one is no worse.
const NO_WORSE: f64 = 1.01;

/// So many times an error is at least one of the unit that it is said in.
const LEAST_SAID: f64 = 10.0;

/// One kind of error before and after.
struct Movement<'a> {
    label: &'static str,
    /// Without its prefix; none of a share.
    unit: Option<&'a str>,
    scale: Scale,
    before: f64,
    after: f64,
    /// What the sensor leaves to any model: a rise by less, as squares add, says nothing.
    floor: f64,
    /// ` rms`, where that is what it is.
    suffix: &'static str,
}

impl Movement<'_> {
    /// Whether it is worse after than before, where it was one before; that of a replay that diverges is.
    fn rises(&self) -> bool {
        let added = (self.after * self.after - self.before * self.before).sqrt();
        self.before.is_finite()
            && (!self.after.is_finite() || self.is_larger() && added > self.floor)
    }

    fn is_larger(&self) -> bool {
        self.after > NO_WORSE * self.before
    }

    /// The unit of the error after: that of the one before, unless it has become so small that only zeros would be said.
    fn scale_after(&self) -> Scale {
        let least = LEAST_SAID * self.after;
        match self.unit {
            Some(unit) if self.after > 0.0 && least < self.before => Scale::of(unit, [least]),
            _ => self.scale.clone(),
        }
    }

    /// Whether it rises, and clearly.
    fn rises_clearly(&self) -> bool {
        self.rises() && (!self.after.is_finite() || rises_clearly(self.before, self.after))
    }

    /// `the position error went from 291 µm to 52.1 µm rms (-82 %)`; the verb only where it is given.
    fn in_words(&self, verb: &str) -> String {
        let (label, suffix) = (self.label, self.suffix);
        let before = self.scale.quantity(self.before);
        if !self.after.is_finite() {
            return format!("the {label}{verb} from {before}{suffix} beyond all bounds");
        }
        let after = self.scale_after().quantity(self.after);
        let change = change(self.before, self.after);
        let told = if self.is_larger() && !self.rises() {
            ", less than the sensor can tell"
        } else {
            ""
        };
        let change = change.map_or(String::new(), |change| format!(" ({change}{told})"));
        format!("the {label}{verb} from {before} to {after}{suffix}{change}")
    }
}

/// The errors that a model is judged by.
fn movements<'a>(stages: &Stages, report: &'a Report) -> [Movement<'a>; 3] {
    let floor = report
        .outcome
        .residual
        .map_or(0.0, |residual| residual.floor);
    let movement = |label, unit: Option<&'a str>, suffix, pick: fn(&ErrorSet) -> f64| {
        let (before, after) = (pick(&stages.before), pick(&stages.after));
        Movement {
            label,
            unit,
            scale: unit.map_or_else(Scale::percent, |unit| Scale::of(unit, [before])),
            before,
            after,
            floor: unit.map_or(0.0, |_| floor),
            suffix,
        }
    };
    let unit = Some(report.coordinate.as_str());
    let unexplained = if report.coordinate == "rad" {
        "unexplained torque"
    } else {
        "unexplained force"
    };
    [
        movement("position error", unit, " rms", |e| e.position_rms),
        movement(unexplained, None, "", |e| e.torque_rel),
        movement("free run error", unit, " rms", |e| e.free_run_rms),
    ]
}

/// The set of logs that a model is judged on, and what a sentence calls them.
fn judged(report: &Report) -> (&Stages, String) {
    let errors = &report.outcome.errors;
    match &errors.validate {
        Some(validate) => (validate, logs("validation", report.validate.len())),
        None => (&errors.train, logs("training", report.train.len())),
    }
}

fn logs(kind: &str, count: usize) -> String {
    if count > 1 {
        format!("the {count} {kind} logs")
    } else {
        format!("the {kind} log")
    }
}

/// Whether the position error on the validation logs has risen with what was found.
fn fails(report: &Report) -> bool {
    let validate = report.outcome.errors.validate.as_ref();
    validate.is_some_and(|stages| movements(stages, report)[0].rises())
}

/// What a model with what was found cannot be relied on for, by the errors that rose where it is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reliance {
    /// No error clearly rose.
    Full,
    /// Only that of a replay without restarts did.
    ShortPredictions,
    /// The position error over a window, or the unexplained torque, clearly rose.
    None,
}

impl Reliance {
    /// On the validation logs, or on the training logs where there are no others.
    pub fn on(report: &Report) -> Self {
        if !is_extended(&report.outcome) {
            return Self::Full;
        }
        let (stages, _) = judged(report);
        let [position, torque, free_run] = movements(stages, report).map(|it| it.rises_clearly());
        match (position || torque, free_run) {
            (true, _) => Self::None,
            (false, true) => Self::ShortPredictions,
            (false, false) => Self::Full,
        }
    }
}

/// The errors that have risen, in one sentence for all sets of logs; and whether what was found holds on others.
pub(super) fn rises(report: &Report) -> Vec<String> {
    let outcome = &report.outcome;
    if !is_extended(outcome) {
        return Vec::new();
    }
    let mut risen_on = Vec::new();
    let (stages, logs_there) = judged(report);
    let movements_there = movements(stages, report);
    let risen = |movements: &[Movement<'_>; 3]| -> Vec<String> {
        let risen = movements.iter().filter(|movement| movement.rises());
        risen.map(|movement| movement.in_words(" rose")).collect()
    };
    let there = risen(&movements_there);
    if !there.is_empty() {
        risen_on.push(format!("on {logs_there} {}", listed(&there)));
    }
    if outcome.errors.validate.is_some() {
        let train = risen(&movements(&outcome.errors.train, report));
        if !train.is_empty() {
            let logs = logs("training", report.train.len());
            risen_on.push(format!("on {logs} {}", listed(&train)));
        }
    }
    let mut sentences = Vec::new();
    if !risen_on.is_empty() {
        sentences.push(format!("But {}.", risen_on.join("; ")));
    }
    if fails(report) {
        sentences.push(match risen_on.len() {
            0 | 1 => "What was found does not hold there.".to_owned(),
            _ => format!("What was found does not hold on {logs_there}."),
        });
    }
    sentences
}

/// How much better the model is; of errors that have risen the finding says so.
pub(super) fn gain(report: &Report) -> String {
    let outcome = &report.outcome;
    if outcome.verdict == Verdict::LogAndMachineDisagree {
        return "Nothing was traced: with such files anything found now would be a false alarm."
            .to_owned();
    }
    let (stages, logs) = judged(report);
    let movements = movements(stages, report);
    let unseen = match &outcome.errors.validate {
        Some(_) => ", which nothing was fitted to,",
        None => ", to which the model was fitted,",
    };
    if !is_extended(outcome) {
        let [position, torque, _] = &movements;
        return format!(
            "On {logs}{unseen} the position error of the fitted model is {} rms, its {} {}.",
            position.scale.quantity(position.after),
            torque.label,
            torque.scale.quantity(torque.after)
        );
    }
    let mut better = movements.iter().filter(|movement| !movement.rises());
    let Some(first) = better.next() else {
        return format!("On {logs}{unseen} no error has become smaller.");
    };
    let first = first.in_words(" went");
    // A sentence for the last one, which may find no room.
    let others: Vec<String> = better.map(|movement| movement.in_words("")).collect();
    match &others[..] {
        [] => format!("On {logs}{unseen} {first}."),
        [second] => format!("On {logs}{unseen} {first} and {second}."),
        [second, third, ..] => {
            let third = third.replacen(" from ", " went from ", 1);
            let third = third.replacen("the ", "The ", 1);
            let costs = free_run_costs(report);
            format!("On {logs}{unseen} {first}, {second}. {third}.{costs}")
        }
    }
}

/// What beside a free run's error says how much of it a trifle makes.
fn free_run_costs(report: &Report) -> String {
    let costs = report.outcome.free_run_costs.iter().map(|cost| {
        let moved = Scale::of(&report.coordinate, [cost.position_rms]);
        moved.quantity(cost.position_rms)
    });
    match &costs.collect::<Vec<_>>()[..] {
        [friction, offset] => {
            format!(
                " A free run goes from start to end without a restart, so small errors add up: 1 % more friction alone moves it by \
                 {friction} rms, a constant load as large as that by {offset}."
            )
        }
        _ => String::new(),
    }
}

/// The same of one error, in a sentence; nothing where none has become smaller, for the finding says which have risen.
pub(super) fn shortest_gain(report: &Report) -> String {
    if report.outcome.verdict == Verdict::LogAndMachineDisagree {
        return gain(report);
    }
    let (stages, logs) = judged(report);
    let movements = movements(stages, report);
    if !is_extended(&report.outcome) {
        let [position, ..] = &movements;
        let error = position.scale.quantity(position.after);
        return format!("On {logs} the position error of the fitted model is {error} rms.");
    }
    let better = movements.iter().find(|movement| !movement.rises());
    better.map_or(String::new(), |first| {
        format!("On {logs} {}.", first.in_words(" went"))
    })
}
