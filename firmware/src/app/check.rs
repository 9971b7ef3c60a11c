//! The onboard check: what the actuator has and its machine lacks, traced on the chip in its own
//! log. It is the host's tracing, the same functions on the same numbers.

use heapless::Vec;
use model_core::effect::{Active, MOST_PARAMETERS};
use model_core::gap::lengths;
use model_core::gap::log::Log;
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{self, Data, InOrder};
use model_core::gap::select::LEAST_WINDOWS;
use model_core::gap::verdict::{Accepted, ROUNDS, Trace, Verdict};
use model_core::gap::workbench::Options;

use super::machine::Machine;

/// Parameters that are estimated anew before an effect is looked for: those that `[fit]` names in
/// the machine's file. All of them are [`Base::WITHOUT_EFFECT`].
pub const BASE: [Base; 4] = [Base::Inertia, Base::Viscous, Base::Coulomb, Base::Static];

/// An effect that was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Which, with its fitted values.
    pub effect: Active,
    /// The values that are reported of it.
    pub reported: [f32; MOST_PARAMETERS],
    /// Share of the residual that it explains, 0 to 1.
    pub score: f32,
    /// From the held-out blocks.
    pub p_value: f64,
}

/// What a check came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The answer.
    pub verdict: Verdict,
    /// The effects, if it is these.
    pub effects: Vec<Found, ROUNDS>,
    /// The variable that carries what is unknown, if it is that.
    pub unknown: Option<&'static str>,
    /// What was fitted together with what was found: the parameters of [`BASE`], and behind them those
    /// of the machine that turned out wrong.
    pub fitted: Vec<(Base, f32), { Base::WITHOUT_EFFECT.len() }>,
    /// Error of the position, rms in windows, rad: of the machine with its parameters fitted.
    pub before: f64,
    /// With what was found.
    pub after: f64,
    /// Replays of the log.
    pub simulations: u64,
}

/// Why there is no finding: the machine keeps what it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Failed {
    /// Fewer than four windows, of ten samples at least, between the log's margins.
    LogTooShort,
    /// The machine cannot be simulated, or the fit left the range in which it can.
    Machine,
}

impl core::fmt::Display for Failed {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::LogTooShort => "the log is too short; drive the actuator for a second or more",
            Self::Machine => {
                "the machine cannot be simulated with its parameters; check them with `show`"
            }
        })
    }
}

/// Looks in a log for what the machine lacks.
///
/// # Errors
/// A log or a machine that gives no answer.
pub fn check(machine: &Machine, log: Log) -> Result<Finding, Failed> {
    let declared = Model::new(machine.plant);
    let logs = [log];
    let data = Data::new(&logs, machine.converters.position.unit()).ok_or(Failed::LogTooShort)?;
    if data.windows() < LEAST_WINDOWS {
        return Err(Failed::LogTooShort);
    }
    let options = Options::new(&data, &declared, &BASE, true).ok_or(Failed::Machine)?;
    // Read where it is: a copy would lie on the stack as long as the tracing does.
    match &lengths::trace(&data, &InOrder, &declared, &options, |_| ()) {
        Some(trace) => finding(&data, trace),
        None => Err(Failed::Machine),
    }
}

/// What a tracing comes to. In a frame of its own, which the stack does not hold beside the tracing's.
#[inline(never)]
fn finding(data: &Data, trace: &Trace) -> Result<Finding, Failed> {
    let judged = Data {
        settings: trace.settings,
        ..*data
    };
    let error = |model: &Model| {
        let period = data.logs[0].period;
        let simulator = model.build(period).map_err(|_| Failed::Machine)?;
        Ok(replay::total_error(&judged, &InOrder, &simulator).position_rms())
    };
    let found = |accepted: &Accepted, effect: &Active, model: &Model| Found {
        effect: *effect,
        reported: effect.report(&model.plant),
        score: accepted.candidate.score,
        p_value: accepted.p_value,
    };
    let model = &trace.after.model;
    let accepted = trace.accepted.iter().zip(&model.effects);
    let unknown = trace.unknown.as_ref();
    let mechanism = unknown.and_then(|unknown| unknown.mechanism.as_ref());
    let named = mechanism.and_then(|mechanism| {
        let nearest = &mechanism.nearest;
        Some(found(&mechanism.accepted, nearest.effects.last()?, nearest))
    });
    let effects = accepted.map(|(accepted, effect)| found(accepted, effect, model));
    let effects = effects.chain(named);
    Ok(Finding {
        verdict: trace.verdict(),
        effects: effects.collect(),
        unknown: unknown
            .filter(|unknown| unknown.mechanism.is_none())
            .map(|unknown| unknown.kind.variable()),
        fitted: trace
            .base
            .iter()
            .map(|&parameter| (parameter, trace.after.model.get(parameter)))
            .collect(),
        before: error(&trace.before.model)?,
        after: error(&trace.after.model)?,
        simulations: trace.simulated / judged.windows() as u64,
    })
}
