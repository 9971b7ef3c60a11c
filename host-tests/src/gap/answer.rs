//! What the tracing found, in the names, numbers and words of the answer.

use model_core::effect::learned_map::{Kind, LearnedMap};
use model_core::effect::{Active, Id};
use model_core::gap::criterion::LEAST_CERTAINTY;
use model_core::gap::current_sensor::Reading;
use model_core::gap::held_out::Refusal;
use model_core::gap::mechanism::Mechanism;
use model_core::gap::model::{Base, Model};
use model_core::gap::verdict::{Accepted, Consideration, Decision, Subject, Trace};
use model_core::gap::workbench::Options;
use model_core::plant::parameters::Drive;
use model_core::unit::Dimension;

use super::outcome::{
    Candidate, Estimate, FittedParameter, FoundEffect, LearnedLaw, NUMBERS, NeglectedInductance,
    Unknown,
};
use super::spread::{Spread, WINDING, propagate};
use crate::machine::{Coordinate, Machine};
use crate::quantity::decimal;
use crate::quantity::{probability, significant};

/// Why a candidate was taken or refused, in words.
pub(super) fn candidate(look: &Consideration) -> Candidate {
    let id = |id: Id| id.description().id;
    let share = |ratio: f64| format!("{:.0} %", 100.0 * (1.0 - ratio));
    let reason = match (look.decision, look.held_out) {
        (Decision::Accepted, Some(held_out)) => format!(
            "the error on data left out of the fit falls by {}, p = {:.1e}",
            share(held_out.ratio),
            held_out.p_value
        ),
        (Decision::Outdone { by }, Some(_)) => match by {
            // They are taken where they do as well.
            Subject::Numbers => {
                "other values of the machine file's own numbers lower the error as much".to_owned()
            }
            Subject::Sensor => "an error of the current's sensor explains it as well".to_owned(),
            Subject::Input => "an input that the log has late explains it as well".to_owned(),
            _ => format!("{} lowers the error more", in_words(by)),
        },
        (Decision::Outdone { by }, None) => match by {
            Subject::Effect(_) => format!(
                "it was taken at first, but beside the others {} follows the log better, or as well with \
                 fewer parameters",
                in_words(by)
            ),
            _ => format!(
                "it was taken at first, but {} explains clearly more",
                in_words(by)
            ),
        },
        (Decision::Refused(Refusal::NotSignificant { required }), Some(held_out)) => format!(
            "on data left out of the fit this may be chance (p = {}; with so many things tried, {} is asked for)",
            probability(held_out.p_value),
            probability(required)
        ),
        (Decision::Refused(Refusal::GainTooSmall), Some(held_out)) if held_out.ratio > 1.0 => {
            let times = significant(held_out.ratio, 2);
            format!(
                "the error falls in most stretches of the data left out of the fit, but over all of them it is {times} times as large"
            )
        }
        (Decision::Refused(Refusal::GainTooSmall), Some(held_out)) => format!(
            "the error on data left out of the fit falls by {} only, 10 % is required",
            share(held_out.ratio)
        ),
        (Decision::Refused(Refusal::NotNeeded), _) => {
            "the model without it follows the log as well, once it is fitted from the numbers that the effect led to"
                .to_owned()
        }
        (Decision::Refused(Refusal::Uncertain), _) => {
            format!("its fitted strength is within {LEAST_CERTAINTY} standard deviations of zero")
        }
        (Decision::NotClearlyBetter, held_out) => format!(
            "it lowers the error on data left out of the fit by {}, and effects of the catalogue by nearly as much",
            held_out.map_or(String::new(), |held_out| share(held_out.ratio))
        ),
        (Decision::InPlaceOf { other }, _) => {
            format!(
                "follows the log better than {}, or as well with fewer parameters",
                id(other)
            )
        }
        (Decision::LawOf { other }, _) => format!(
            "{} by another law follows the log about as well without it",
            id(other)
        ),
        (Decision::Refused(Refusal::Implausible(number)), _) => format!(
            "with it the fit takes {} farther from its declared value than the machine file allows (`unsure` in [fit])",
            number.name()
        ),
        (Decision::Refused(Refusal::WorseElsewhere), _) => {
            "over shorter or longer predictions the error is clearly larger with it".to_owned()
        }
        (Decision::Refused(Refusal::OverOneLength), _) => {
            OVER_ONE_LENGTH.to_owned()
        }
        (Decision::Refused(Refusal::ExplainsTooLittle), _) => {
            "with all that was found the model still does not follow the log, and most of its error is left: another \
             cause may look like this one"
                .to_owned()
        }
        (Decision::Refused(Refusal::GainNotCommon), _) => {
            "the error falls only in few stretches of the data left out of the fit".to_owned()
        }
        (Decision::SameAs { other }, _) => format!("it is the same model as {} here", id(other)),
        (Decision::Absorbed, _) => format!(
            "the fitted numbers can do what it does (identifiability {:.3})",
            look.identifiability
        ),
        (Decision::WrongSign, _) => "the logs ask for a negative size of it, which is impossible".to_owned(),
        (Decision::BelowResolution, _) => {
            "smaller than half a count: the sensor's own rounding".to_owned()
        }
        (Decision::ScoreTooLow, _) => "it explains less than 1 % of the error".to_owned(),
        (Decision::NearDeclared, _) => {
            "their fitted values are within 2 % of the declared ones".to_owned()
        }
        (Decision::Hopeless, _) => {
            "no fit with it came near to the model without it"
                .to_owned()
        }
        (Decision::NotShortlisted, _) => "it was not fitted: others have a higher score".to_owned(),
        (Decision::FarBehind { of }, _) => {
            format!("it was not fitted: its score is under a tenth of that of {}, which was proven", in_words(of))
        }
        (Decision::Dropped, _) => {
            "it was taken at first, and with the effects found later the model does as well without it".to_owned()
        }
        (Decision::Accepted | Decision::Refused(_), None) => String::new(),
    };
    Candidate {
        round: look.round,
        id: subject(look.subject),
        words: in_words(look.subject),
        score: decimal(look.score),
        identifiability: decimal(look.identifiability),
        held_out_ratio: look.held_out.map(|held_out| held_out.ratio),
        p_value: look.held_out.map(|held_out| held_out.p_value),
        accepted: matches!(
            look.decision,
            Decision::Accepted | Decision::InPlaceOf { .. }
        ),
        reason,
    }
}

/// Refuses what a round took and the end of a tracing does not have: an effect or a law that is not certain, or holds over
/// predictions of one length alone.
pub(super) fn settle(candidates: &mut [Candidate], trace: &Trace) {
    let accepted = trace.accepted.iter();
    let effects = accepted.map(|it| Subject::Effect(it.candidate.effect.id));
    let of_law = mechanism(trace).map(|it| Subject::Effect(it.accepted.candidate.effect.id));
    let law = trace.unknown.as_ref().map(|law| Subject::Map(law.kind));
    let numbers = (!trace.freed().is_empty()).then_some(Subject::Numbers);
    let sensor = (!trace.readings.is_empty()).then_some(Subject::Sensor);
    let input = trace.base.contains(&Base::InputLead);
    let others = [
        of_law,
        law,
        numbers,
        sensor,
        input.then_some(Subject::Input),
    ];
    let there: Vec<String> = effects
        .chain(others.into_iter().flatten())
        .map(subject)
        .collect();
    for taken in candidates.iter_mut().filter(|it| it.accepted) {
        if !there.contains(&taken.id) {
            taken.accepted = false;
            taken.reason = if trace.unconfirmed {
                OVER_ONE_LENGTH
            } else {
                NOT_CERTAIN
            }
            .to_owned();
        }
    }
}

/// Why something that was found is not said.
const OVER_ONE_LENGTH: &str =
    "it helps the model to predict over one length of time, and not over another";

/// The same of what was found and does not stand in the end.
const NOT_CERTAIN: &str =
    "when all was found it was no longer certain, and so the answer leaves it out";

/// What was looked at, as the answer names it.
pub(super) fn subject(subject: Subject) -> String {
    match subject {
        Subject::Effect(effect) => effect.description().id.to_owned(),
        Subject::Map(kind) => map_name(kind),
        Subject::Numbers => NUMBERS.to_owned(),
        Subject::Sensor => "current_sensor".to_owned(),
        Subject::Input => "input_lead".to_owned(),
    }
}

/// The same in a sentence.
fn in_words(looked_at: Subject) -> String {
    match looked_at {
        Subject::Map(kind) => format!("a {} learned over {}", kind.acts_as(), kind.variable()),
        Subject::Numbers => "the machine file's own numbers".to_owned(),
        Subject::Sensor => "gain, offset and lag of the current's sensor".to_owned(),
        Subject::Input => "an earlier input than the log has".to_owned(),
        Subject::Effect(_) => subject(looked_at),
    }
}

/// `a`, `a and b`, `a, b and c`
pub(crate) fn listed(names: &[impl AsRef<str>]) -> String {
    let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [rest @ .., last] => format!("{} and {last}", rest.join(", ")),
    }
}

/// A learned map among the candidates.
fn map_name(kind: Kind) -> String {
    format!("map:{} ({})", kind.variable(), kind.acts_as())
}

/// The effects that were found. `named`: how sure the formula is of that one of which a law was learned.
pub(super) fn found(
    trace: &Trace,
    spread: &Spread,
    named: Option<&Spread>,
    declared: &Model,
    rotary: bool,
) -> Vec<FoundEffect> {
    let first = declared.effects.len();
    let (after, fitted) = (&trace.after.model, &trace.base);
    let accepted = trace.accepted.iter().enumerate();
    let accepted = accepted.map(|(index, accepted)| {
        found_effect(accepted, (after, first + index), (spread, fitted), rotary)
    });
    let named = mechanism(trace).zip(named).map(|(mechanism, spread)| {
        let formula = (&mechanism.nearest, first);
        FoundEffect {
            law: after.map.map(|map| learned(&map, rotary)),
            ..found_effect(&mechanism.accepted, formula, (spread, fitted), rotary)
        }
    });
    accepted.chain(named).collect()
}

/// The effect of which a law was learned.
pub(super) fn mechanism(trace: &Trace) -> Option<&Mechanism> {
    trace.unknown.as_ref()?.mechanism.as_ref()
}

/// An effect that was found, in a slot of a model to which these numbers were fitted.
fn found_effect(
    accepted: &Accepted,
    (model, slot): (&Model, usize),
    (spread, fitted): (&Spread, &[Base]),
    rotary: bool,
) -> FoundEffect {
    let report = |model: &Model| model.effects[slot].report(&model.plant);
    let values = report(model);
    let description = accepted.candidate.effect.id.description();
    let mut declare = format!("{{ id = \"{}\"", description.id);
    let effect = &model.effects[slot];
    let parameters = description.parameters.iter().enumerate();
    for (index, parameter) in parameters.filter(|(index, _)| effect.has(*index)) {
        declare += &format!(", {} = {}", parameter.name, decimal(effect.values[index]));
    }
    declare += " }";
    let reported = effect.reported();
    let dimensions: Vec<Dimension> = reported.iter().map(|(_, dimension)| *dimension).collect();
    let stds = propagate(model, spread, &dimensions, report);
    // The winding makes a torque of a voltage: what the log tells of torques has its scale.
    let needs_winding = accepted.candidate.effect.id.needs_winding()
        || model.plant.drive.winding().is_there() && dimensions.iter().any(|it| it.has_torque());
    let mut presumed = WINDING.to_vec();
    presumed.retain(|number| needs_winding && !fitted.contains(number));
    FoundEffect {
        id: description.id.to_owned(),
        parameters: reported
            .iter()
            .zip(values.iter().zip(stds))
            .map(|((name, dimension), (value, std))| Estimate {
                name: (*name).to_owned(),
                value: decimal(*value),
                std,
                unit: dimension.unit(rotary).to_owned(),
            })
            .collect(),
        declare,
        score: decimal(accepted.candidate.score),
        identifiability: decimal(accepted.candidate.identifiability),
        p_value: accepted.p_value,
        law: None,
        equivalent: accepted
            .equivalent
            .iter()
            .map(|id| id.description().id.to_owned())
            .collect(),
        neglected_inductance: neglected_inductance(effect, model),
        presumes: presumed
            .iter()
            .map(|number| number.name().to_owned())
            .collect(),
    }
}

/// The inductance that a delay stands for, of a model that neglects it. Without one the current of a model follows the voltage at
/// once; with one it comes later by inductance over resistance, and so does the motion.
fn neglected_inductance(effect: &Active, model: &Model) -> Option<NeglectedInductance> {
    let is_delay = matches!(effect.id, Id::InputDelay | Id::SensorDelay);
    match model.plant.drive {
        Drive::Voltage {
            resistance,
            inductance: 0.0,
            ..
        } if is_delay => {
            let resistance = decimal(resistance);
            let [delay, ..] = effect.values;
            Some(NeglectedInductance {
                inductance: decimal(delay) * resistance,
                resistance,
            })
        }
        _ => None,
    }
}

/// Structure that the catalogue does not explain, with the map that was learned of it.
pub(super) fn unknown(trace: &Trace, rotary: bool) -> Option<Unknown> {
    let unknown = trace.unknown.as_ref()?;
    if unknown.mechanism.is_some() {
        return None;
    }
    Some(Unknown {
        depends_on: unknown.kind.variable().to_owned(),
        score: decimal(unknown.score),
        map: learned(&trace.after.model.map?, rotary),
    })
}

/// A learned map in the words of the answer.
fn learned(map: &LearnedMap, rotary: bool) -> LearnedLaw {
    let kind = map.kind;
    let knots = 0..map.knots.len();
    LearnedLaw {
        over: kind.variable().to_owned(),
        acts_as: kind.acts_as().to_owned(),
        at: knots.map(|knot| decimal(map.place(knot))).collect(),
        at_unit: kind.dimension().unit(rotary).to_owned(),
        values: map.knots.iter().map(|&value| decimal(value)).collect(),
        unit: Dimension::Torque.unit(rotary).to_owned(),
    }
}

/// What a fit has made of numbers of the declared actuator: its model, and which.
pub(super) fn fitted(
    (model, base): (&Model, &[Base]),
    spread: &Spread,
    declared: &Model,
    options: &Options,
    machine: &Machine,
) -> Vec<FittedParameter> {
    let rotary = machine.coordinate == Coordinate::Radian;
    base.iter()
        .filter(|&&parameter| parameter != Base::InputLead)
        .map(|&parameter| {
            let value = |model: &Model| [model.get(parameter)];
            let dimensions = [parameter.dimension()];
            let [std] = propagate(model, spread, &dimensions, value);
            let fitted = model.get(parameter);
            let limits = options.limits(parameter, declared.get(parameter));
            FittedParameter {
                name: parameter.name().to_owned(),
                declared: decimal(declared.get(parameter)),
                fitted: decimal(fitted),
                // At a bound where it says nothing to the log, as a breakaway level on the Coulomb one, no window moves it.
                std: (std.is_finite() && std > 0.0).then_some(std),
                unit: parameter.dimension().unit(rotary).to_owned(),
                freed: !options.base.contains(&parameter),
                tolerance: machine.tolerances.get(parameter.name()).copied(),
                // What is held there has exactly that value.
                at_limit: limits.is_some_and(|limits| limits.contains(&fitted)),
            }
        })
        .collect()
}

/// How much earlier each input acted than the log has it, s, where that was fitted.
pub(super) fn input_lead(trace: &Trace, spread: &Spread) -> Option<Estimate> {
    let (lead, model) = (Base::InputLead, &trace.after.model);
    let value = |model: &Model| [model.get(lead)];
    trace.base.contains(&lead).then(|| {
        let [std] = propagate(model, spread, &[lead.dimension()], value);
        Estimate {
            name: lead.name().to_owned(),
            value: decimal(model.get(lead)),
            std,
            unit: lead.dimension().unit(true).to_owned(),
        }
    })
}

/// Gain, offset and lag of the current's sensor, where they were fitted.
pub(super) fn current_sensor(trace: &Trace, spread: &Spread) -> Vec<Estimate> {
    if trace.readings.is_empty() {
        return Vec::new();
    }
    let model = &trace.after.model;
    let values = |model: &Model| Reading::ALL.map(|reading| model.current_sensor.get(reading));
    let stds = propagate(model, spread, &[], values);
    let names = [("gain", "1"), ("offset", "A"), ("lag", "s")];
    let numbers = names.into_iter().zip(values(model).into_iter().zip(stds));
    numbers
        .map(|((name, unit), (value, std))| Estimate {
            name: name.to_owned(),
            value: decimal(value),
            std,
            unit: unit.to_owned(),
        })
        .collect()
}
