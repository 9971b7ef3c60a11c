//! What `cargo hil gap` found: the JSON of the contract, and the evidence behind it for the report.

use model_core::gap::criterion::LARGEST_RATIO;
use model_core::gap::criterion::UNEXPLAINED;
use model_core::gap::verdict::Verdict;
use serde::{Serialize, Serializer};

use super::component::Component;
use super::demand::Demand;
use super::disagreement::Disagreement;
use super::experiment::NextExperiment;
pub use super::learned_law::LearnedLaw;
pub use super::short_logs::ShortLogs;
use crate::log::Log;
use crate::log::resample::Resampling;
use crate::machine::DeclaredEffect;

/// The answer, serialised as it stands. Keys beyond the contract are additions.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// The name in the machine file.
    pub machine: String,
    /// What the tracing concludes.
    #[serde(serialize_with = "name")]
    pub verdict: Verdict,
    /// In what logs and machine file disagree; nothing was traced then.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub disagreement: Vec<Disagreement>,
    /// What is left of the windowed position error, and how little is possible, rad or m; nothing where nothing
    /// was traced.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub residual: Option<Residual>,
    /// The effects that were accepted, in the order in which they were.
    pub effects: Vec<FoundEffect>,
    /// Which variable carries a structure that the catalogue does not explain.
    pub unknown: Option<Unknown>,
    /// The parameters named in `[fit]`, as declared and in the final model.
    pub fit: Vec<FittedParameter>,
    /// Gain, offset and lag of the current's sensor, where the logs are followed clearly better with other ones than
    /// 1, 0 and 0; left out of the JSON elsewhere.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub current_sensor: Vec<Estimate>,
    /// How much earlier each input acted than the log has it, s, where the logs are followed clearly better so; left out of the
    /// JSON elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input_lead: Option<Estimate>,
    /// Errors of the three models on both logs.
    pub errors: Errors,
    /// What logs have otherwise than the training logs together, surely and by more than a data sheet would say; left out of the
    /// JSON where there is nothing.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub between_logs: Vec<LogDifference>,
    /// What little changes move a free run of the final model by, on the validation logs if there are any; left out of the
    /// JSON where nothing was traced.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub free_run_costs: Vec<FreeRunCost>,
    /// Every effect that was looked at, round by round, and why it was taken or refused.
    pub candidates: Vec<Candidate>,
    /// What would tell apart what the training logs do not; null where nothing is in doubt, or
    /// nobody asked.
    pub next_experiment: Option<NextExperiment>,
    /// The machine file with what was found, as the user named it; left out of the JSON where none was
    /// written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine_out: Option<String>,
    /// Whiteness of the residual of the base fit, as evidence.
    pub whiteness: Whiteness,
    /// Logs whose rows were not at even times, and what putting them on a grid changed; left out of the
    /// JSON where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub resampled: Vec<Resampled>,
    /// What the run cost.
    pub cost: Cost,
}

/// What one log has otherwise than the training logs.
#[derive(Debug, Clone, Serialize)]
pub struct LogDifference {
    /// The file, as the user named it.
    pub log: String,
    /// Whether it is one of the training logs, and so differs from all of them together, itself among them.
    pub trained_on: bool,
    /// Root mean square of the windowed position error on it of the final model, rad or m.
    pub position_rms: f64,
    /// The same with the numbers that this log has.
    pub position_rms_with: f64,
    /// These numbers.
    pub numbers: Vec<NumberDifference>,
}

/// A number that one log has otherwise than the training logs.
#[derive(Debug, Clone, Serialize)]
pub struct NumberDifference {
    /// Name of the number: that of a machine file, or `offset_torque`.
    pub name: String,
    /// What the training logs have, SI.
    pub trained: f64,
    /// By how much this log has more, SI.
    pub difference: f64,
    /// Standard deviation of the difference, SI.
    pub std: f64,
    /// Its unit.
    pub unit: String,
}

/// What a small change of one number moves a free run by.
#[derive(Debug, Clone, Serialize)]
pub struct FreeRunCost {
    /// Name of the number: that of a machine file, or `offset_torque`.
    pub name: String,
    /// What it is raised by, SI.
    pub change: f64,
    /// Its unit.
    pub unit: String,
    /// Root mean square of how far the free run is moved, rad or m.
    pub position_rms: f64,
}

/// A log that was resampled on reading.
#[derive(Debug, Clone, Serialize)]
pub struct Resampled {
    /// The file, as the user named it.
    pub log: String,
    /// Period of the samples, s.
    pub period_s: f64,
    /// What it changed.
    #[serde(flatten)]
    pub change: Resampling,
}

impl Resampled {
    /// The logs among these that were.
    pub fn among(logs: &[Log]) -> Vec<Self> {
        let of = |log: &Log| {
            Some(Self {
                log: log.path.display().to_string(),
                period_s: log.period_s,
                change: log.resampling?,
            })
        };
        logs.iter().filter_map(of).collect()
    }
}

/// What is left of the windowed position error of the final model on the training logs, rms, rad or m.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Residual {
    /// That error.
    pub position_rms: f64,
    /// What the sensor and the restarts leave to any model.
    pub floor: f64,
    /// A fitted number that has surely gone farther than the machine file lets it be off.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub implausible: Option<&'static str>,
    /// Whether something was found over predictions of one length and not over those of another, so that
    /// nothing is said to be missing or complete.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub unconfirmed: bool,
    /// That the training logs are short, where they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub short: Option<ShortLogs>,
}

impl Residual {
    /// How many times what the sensor and the restarts leave is left.
    pub fn times_floor(&self) -> f64 {
        self.position_rms / self.floor
    }
}

/// A verdict is its name.
fn name<S: Serializer>(verdict: &Verdict, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(verdict.name())
}

/// One accepted effect.
#[derive(Debug, Clone, Serialize)]
pub struct FoundEffect {
    /// The catalogue's id.
    pub id: String,
    /// Its parameters from the joint fit.
    pub parameters: Vec<Estimate>,
    /// How it would stand among a machine file's `declared_effects`, next to the fitted numbers.
    pub declare: String,
    /// Share of the residual's energy that it explains once the base is projected out, 0 to 1.
    pub score: f64,
    /// Share of its own sensitivity that no other fitted parameter can imitate, 0 to 1.
    pub identifiability: f64,
    /// One-sided Wilcoxon signed-rank p over held-out blocks of the training log: of such a gain, if no more
    /// than one percent of the error were to be gained. Of few blocks twice the lesser of that and of the
    /// paired t-test's.
    pub p_value: f64,
    /// The machine's law of it, where it is another one than the catalogue's formula and was learned: the final model has it in
    /// place of the formula, of which the parameters are those that come nearest. Left out of the JSON elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<LearnedLaw>,
    /// Effects that this log cannot tell from it.
    pub equivalent: Vec<String>,
    /// Inductance of the winding that makes the motion as late as this delay does, H, where the machine file neglects it: what it
    /// may be instead. Left out of the JSON elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub neglected_inductance: Option<NeglectedInductance>,
    /// Numbers of the motor that its values presume, for they were not fitted: freed instead of it, they
    /// explain less.
    pub presumes: Vec<String>,
}

/// A winding's inductance that a delay may stand for: over the resistance it is as long as that.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct NeglectedInductance {
    /// That inductance, H.
    pub inductance: f64,
    /// The resistance that it goes with, that of the final model, Ω.
    pub resistance: f64,
}

/// A fitted number with its standard deviation.
#[derive(Debug, Clone, Serialize)]
pub struct Estimate {
    /// Name of the parameter.
    pub name: String,
    /// Its value, SI.
    pub value: f64,
    /// Its standard deviation, SI; null in JSON where the log does not determine the value.
    pub std: f64,
    /// Its unit.
    pub unit: String,
}

/// One number of the machine file that was fitted.
#[derive(Debug, Clone, Serialize)]
pub struct FittedParameter {
    /// Name, as in the machine file.
    pub name: String,
    /// The machine file's value.
    pub declared: f64,
    /// The value in the final model.
    pub fitted: f64,
    /// Its standard deviation; null for a parameter that the log does not determine.
    pub std: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// Whether `[fit]` leaves it out, and it was fitted because the logs ask for another value. Only "after" has it
    /// so.
    pub freed: bool,
    /// How far the machine file says that it may be off, as a share.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Whether the fit stopped at the limit of how far the machine file lets it be off: then it is no estimate.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub at_limit: bool,
}

impl FittedParameter {
    /// Whether the logs ask for no more than the machine file says that it may be off.
    pub(super) fn is_within_tolerance(&self) -> bool {
        let off = (self.fitted / self.declared - 1.0).abs();
        self.tolerance.is_some_and(|tolerance| off <= tolerance)
    }

    /// Whether the logs ask for more than that, by more than two standard deviations.
    pub(super) fn is_surely_beyond_tolerance(&self) -> bool {
        let off = (self.fitted - self.declared).abs();
        let stated = self.tolerance.zip(self.std);
        stated.is_some_and(|(tolerance, std)| off > tolerance * self.declared.abs() + 2.0 * std)
    }
}

impl Outcome {
    /// Whether the final model leaves so much more of the validation logs than of the training logs, and than the sensor, that it
    /// has a cause, and no number in which the logs differ is it. A free run that follows them shows that it follows: windows have
    /// restarts, of which one may be wrong where the machine sticks.
    pub(super) fn is_lost(&self) -> bool {
        let Some((validate, residual)) = self.errors.validate.as_ref().zip(self.residual) else {
            return false;
        };
        let here = self.errors.train.after.position_rms.max(residual.floor);
        let there = validate.after.position_rms.min(validate.after.free_run_rms);
        there > UNEXPLAINED * here && self.between_logs.is_empty()
    }

    /// Says nothing proven in place of nothing missing, where the validation logs show more than sensors and restarts leave.
    pub(super) fn heed_validation(&mut self) {
        if self.verdict == Verdict::NoMissingEffect && self.is_lost() {
            self.verdict = Verdict::NothingProven;
        }
    }

    /// What logs and machine file disagree in, each once though several logs need it mended.
    pub fn disagreements(&self) -> Vec<&str> {
        distinct(self.disagreement.iter().map(|found| &*found.what))
    }

    /// What mends them, each once though it mends several things. Where one of several calls does, all stand here.
    pub fn remedies(&self) -> Vec<&str> {
        distinct(
            self.disagreement
                .iter()
                .flat_map(|found| found.remedy.lines()),
        )
    }

    /// Names of the numbers of the machine file that were fitted although `[fit]` leaves them out.
    pub fn freed(&self) -> impl Iterator<Item = &str> {
        let freed = self.fit.iter().filter(|parameter| parameter.freed);
        freed.map(|parameter| parameter.name.as_str())
    }

    /// The effect of which the final model has a learned law in place of the formula; no machine file can hold that law.
    pub(super) fn with_law(&self) -> Option<&FoundEffect> {
        self.effects.iter().find(|effect| effect.law.is_some())
    }
}

/// Structure that the catalogue does not explain.
#[derive(Debug, Clone, Serialize)]
pub struct Unknown {
    /// `position`, `velocity`, `current`, `load` or `time`.
    pub depends_on: String,
    /// Share of the residual that the learned map of this variable explains.
    pub score: f64,
    /// That map.
    pub map: LearnedLaw,
}

/// Errors on the training log, and on the validation log where there is one.
#[derive(Debug, Clone, Serialize)]
pub struct Errors {
    /// On the training logs.
    pub train: Stages,
    /// On the validation logs, opened once at the end; null where none was given.
    pub validate: Option<Stages>,
}

/// Errors of the three models on one set of logs.
#[derive(Debug, Clone, Serialize)]
pub struct Stages {
    /// The machine file as it stands.
    pub declared: ErrorSet,
    /// Its `[fit]` parameters re-estimated on the training log.
    pub before: ErrorSet,
    /// With the effects, everything refitted.
    pub after: ErrorSet,
}

/// Whether an error is clearly larger after than before: by as much as an effect has to take off to be said, turned round.
pub(super) fn rises_clearly(before: f64, after: f64) -> bool {
    before * before < LARGEST_RATIO * after * after
}

impl Stages {
    /// What the effects leave of the windowed position error.
    pub fn remaining(&self) -> f64 {
        self.after.position_rms / self.before.position_rms
    }
}

/// Errors of one model on one set of logs. An error that is no number, because the replay diverged,
/// is null in JSON.
#[derive(Debug, Clone, Serialize)]
pub struct ErrorSet {
    /// Length of a replay window, s.
    pub window_s: f64,
    /// Root mean square of the windowed position error, rad or m.
    pub position_rms: f64,
    /// Largest windowed position error, rad or m.
    pub position_max: f64,
    /// `position_rms` over the standard deviation of the measured position (throttle paper, eq. 23).
    pub position_nrmse: f64,
    /// Root mean square of the windowed current error, A, where current was measured.
    pub current_rms: Option<f64>,
    /// Norm of the torque residual over the norm of the torque.
    pub torque_rel: f64,
    /// Root mean square position error of one replay without restarts, rad or m.
    pub free_run_rms: f64,
}

/// Texts, each where it comes first.
fn distinct<'t>(texts: impl Iterator<Item = &'t str>) -> Vec<&'t str> {
    let mut distinct = Vec::new();
    for text in texts {
        if !distinct.contains(&text) {
            distinct.push(text);
        }
    }
    distinct
}

/// Numbers of the motor that a machine file does not have fitted.
#[derive(Debug, Clone)]
pub struct FreeMotor {
    /// Their names.
    pub fixed: Vec<&'static str>,
    /// The line of `[fit]` that has them fitted too.
    pub line: String,
}

/// The candidate that frees those numbers of the machine file that `[fit]` leaves out.
pub(super) const NUMBERS: &str = "numbers";

/// One look at one effect in one round of the selection.
#[derive(Debug, Clone, Serialize)]
pub struct Candidate {
    /// Round of the selection, from 1.
    pub round: usize,
    /// The catalogue's id, `map:VARIABLE` for a learned map, or `numbers`: those of the machine file
    /// that `[fit]` leaves out.
    pub id: String,
    /// What it is in a sentence.
    #[serde(skip)]
    pub words: String,
    /// As in [`FoundEffect`], from the screening.
    pub score: f64,
    /// As in [`FoundEffect`], from the screening.
    pub identifiability: f64,
    /// Held-out mean square error with the effect over that without; null if it was not refitted.
    pub held_out_ratio: Option<f64>,
    /// The same p over held-out blocks; null if it was not refitted.
    pub p_value: Option<f64>,
    /// Whether the round took it.
    pub accepted: bool,
    /// Why it was taken or refused, in words.
    pub reason: String,
}

/// Portmanteau test of the base fit's residual.
#[derive(Debug, Clone, Serialize)]
pub struct Whiteness {
    /// Ljung–Box statistic over its degrees of freedom.
    pub ljung_box: f64,
    /// Lags that it sums.
    pub lags: usize,
    /// Its p-value.
    pub p_value: f64,
    /// Correlations of the residual with what may drive it, −1 to 1.
    pub correlations: Correlations,
}

/// Correlations of the base fit's torque residual, −1 to 1.
#[derive(Debug, Clone, Serialize)]
pub struct Correlations {
    /// With the input.
    pub input: f64,
    /// With the velocity.
    pub velocity: f64,
    /// With the direction of motion.
    pub direction: f64,
    /// With the square of the input.
    pub input_squared: f64,
}

/// What the run cost.
#[derive(Debug, Clone, Serialize)]
pub struct Cost {
    /// Wall-clock seconds.
    pub seconds: f64,
    /// Replays of the whole training log.
    pub simulations: u64,
    /// Samples of the training log.
    pub samples: usize,
}

/// Sample-by-sample evidence for the report's plots, one entry a log. All series of one `Evidence` have
/// the same length, but for those of its components. Windowed replays: restarted every
/// `ErrorSet::window_s`.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// The file it came from, as the user named it.
    pub label: String,
    /// Sample times from the log's first sample, s: single precision does not tell the milliseconds
    /// of a late start.
    pub time: Vec<f32>,
    /// Measured position, rad or m.
    pub position: Vec<f32>,
    /// Measured position smoothed and differentiated, rad/s or m/s.
    pub velocity: Vec<f32>,
    /// What the drive was told, unit of the log's `input`.
    pub input: Vec<f32>,
    /// Measured current, A; empty where it was not measured.
    pub current: Vec<f32>,
    /// Position of the model before effects, windowed replay.
    pub before: Vec<f32>,
    /// Position of the model with its effects, windowed replay.
    pub after: Vec<f32>,
    /// Torque (or force) residual of the model before effects, filtered, at `torque_time`.
    pub torque_before: Vec<f32>,
    /// Torque (or force) residual of the model with its effects, filtered, at `torque_time`.
    pub torque_after: Vec<f32>,
    /// Times of the torque residuals (decimated), s.
    pub torque_time: Vec<f32>,
    /// Measured velocity at `torque_time`.
    pub torque_velocity: Vec<f32>,
    /// Measured position at `torque_time`.
    pub torque_position: Vec<f32>,
    /// Start rows of the replay windows.
    pub window_starts: Vec<usize>,
    /// What each found effect does in it, in the order of the answer.
    pub components: Vec<Component>,
}

impl Evidence {
    /// Samples that a replay predicts, by the length of its windows: not those that no window reaches, where the model's
    /// position is the measured one. All, where no window is known.
    pub(super) fn predicted(&self, window_s: f64) -> Vec<usize> {
        let samples = self.position.len();
        let period = match self.time[..] {
            [first, second, ..] => f64::from(second - first),
            _ => f64::NAN,
        };
        let window = window_s / period;
        if self.window_starts.is_empty() || !window.is_finite() {
            return (0..samples).collect();
        }
        let window = window.round() as usize;
        let starts = self.window_starts.iter();
        let ahead = starts.flat_map(|start| start + 1..=start + window);
        ahead.filter(|sample| *sample < samples).collect()
    }
}

/// Everything that the report shows.
#[derive(Debug, Clone)]
pub struct Report {
    /// The answer.
    pub outcome: Outcome,
    /// `rad` or `m`.
    pub coordinate: String,
    /// Unit of torque or force: `N·m` or `N`.
    pub load_unit: String,
    /// What the training logs ask of the machine.
    pub demand: Demand,
    /// The effects that the machine file declares.
    pub declared: Vec<DeclaredEffect>,
    /// Those of the motor's numbers that `[fit]` leaves out, where the training logs could tell them.
    pub free_motor: Option<FreeMotor>,
    /// Resistance of a motor for which the machine file has no inductance, Ω.
    pub without_inductance: Option<f64>,
    /// Numbers of the winding that no fit moves, and that the machine file says how far they may be off.
    pub held_within: Vec<&'static str>,
    /// Whether the machine has a return spring between two stops and nothing beside it: `cargo hil identify` makes its
    /// machine file from logs.
    pub has_return_spring: bool,
    /// Whether the page is written too, which draws what the terminal refers to.
    pub has_page: bool,
    /// Training logs.
    pub train: Vec<Evidence>,
    /// Validation logs.
    pub validate: Vec<Evidence>,
}

impl Report {
    /// An effect in the log in which it is shown: on unseen data where there are some.
    pub(super) fn shown(&self, id: &str) -> Option<(&Evidence, &Component)> {
        let log = self.validate.first().or(self.train.first())?;
        let component = log.components.iter().find(|shown| shown.id == id)?;
        Some((log, component))
    }
}
