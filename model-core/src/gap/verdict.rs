//! What a tracing concludes, and what it looked at and decided on the way.

use super::criterion::UNEXPLAINED;
use super::current_sensor::Readings;
use super::fit::Fit;
use super::held_out::{Comparison, Refusal};
use super::model::{Base, Numbers};
use super::replay::Settings;
use super::screen::{Candidate, MOST_CANDIDATES};
use super::unknown::Unknown;
use crate::effect::Id;
use crate::effect::learned_map::Kind;
use heapless::Vec;

/// Rounds of the selection: most effects that one run adds.
pub const ROUNDS: usize = 4;

/// What a round decided about one effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decision {
    /// Best of those that passed.
    Accepted,
    /// Follows the log better than what was accepted, or as well with fewer parameters, and is taken for it.
    InPlaceOf {
        /// What was accepted.
        other: Id,
    },
    /// Passed, but another law of what was found before it does about as well.
    LawOf {
        /// What was found before it.
        other: Id,
    },
    /// Passed, but something else explains the residual better.
    Outdone {
        /// What was taken.
        by: Subject,
    },
    /// The same model as another candidate for this log.
    SameAs {
        /// That other candidate.
        other: Id,
    },
    /// Its sensitivity is a combination of the base's.
    Absorbed,
    /// Physics forbids the sign that the residual asks for.
    WrongSign,
    /// A reading error, or a play, that the rounding of the sensor makes too.
    BelowResolution,
    /// Explains too little of the residual to be refitted.
    ScoreTooLow,
    /// No start of a fit with it follows the log nearly as well as the model does without.
    Hopeless,
    /// As many others as are refitted score higher.
    NotShortlisted,
    /// Scores far below another one, which passed.
    FarBehind {
        /// That other one.
        of: Subject,
    },
    /// Numbers whose fitted values are those that are declared, to a data sheet's tolerance.
    NearDeclared,
    /// Refitted, and not enough better on held-out blocks.
    Refused(Refusal),
    /// A map that predicts held-out blocks, and the effects of the catalogue predict them about as well.
    NotClearlyBetter,
    /// Was taken in an earlier round and is not needed beside the later ones.
    Dropped,
}

/// What a look is at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// An effect of the catalogue.
    Effect(Id),
    /// A learned map.
    Map(Kind),
    /// The declared numbers that are not to be fitted, fitted nevertheless.
    Numbers,
    /// Gain, offset and lag of the current's sensor.
    Sensor,
    /// The lead of the log's input. Where it is accepted the tracing begins anew with the round of that look: what was told before of
    /// that round and later ones was found with other inputs, and is void.
    Input,
}

/// One look at one effect, or at one learned map, in one round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Consideration {
    /// Round, from 1.
    pub round: usize,
    /// The effect or the map.
    pub subject: Subject,
    /// As in [`Candidate`]. For a map: the share that all its knots explain together; for numbers: the
    /// share by which the held-out error falls.
    pub score: f32,
    /// As in [`Candidate`]; 1 for a map, whose knots overlap with the base by their nature, and for
    /// numbers.
    pub identifiability: f32,
    /// Held-out mean square error with the effect over that without, if it was refitted.
    pub held_out: Option<Comparison>,
    /// What was decided.
    pub decision: Decision,
}

/// An accepted effect.
#[derive(Debug, Clone)]
pub struct Accepted {
    /// Which, with score and identifiability from the screening of the round that took it.
    pub candidate: Candidate,
    /// From the held-out blocks.
    pub p_value: f64,
    /// Held-out mean square error with it over that without, in the round that took it.
    pub ratio: f64,
    /// Effects that this log cannot tell from it.
    pub equivalent: Vec<Id, MOST_CANDIDATES>,
}

/// What a tracing concludes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Verdict {
    /// What is left is what the sensors and the restarts leave, and no fitted number had to go where a data
    /// sheet would not let it.
    NoMissingEffect,
    /// At least one effect of the catalogue was accepted, or a law of one was learned.
    EffectsFound,
    /// Something is proven that no effect of the catalogue explains.
    UnknownEffect,
    /// Signs, units, wrapping or a column of the log are not those of the machine: nothing is traced.
    LogAndMachineDisagree,
    /// More is left than the sensors and the restarts leave, or a number moved too far, and nothing could be
    /// proven.
    NothingProven,
}

impl Verdict {
    /// Its name in logs and answers.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoMissingEffect => "no_missing_effect",
            Self::EffectsFound => "effects_found",
            Self::UnknownEffect => "unknown_effect",
            Self::LogAndMachineDisagree => "log_and_machine_disagree",
            Self::NothingProven => "nothing_proven",
        }
    }
}

/// What is left of the position error, against how little is possible; rad or m, rms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// The windowed error of the final model.
    pub position_rms: f64,
    /// What the sensor and the restarts leave to any model.
    pub floor: f64,
}

impl Residual {
    /// Whether more is left than the sensors and the restarts leave.
    pub fn is_unexplained(&self) -> bool {
        self.position_rms > UNEXPLAINED * self.floor
    }
}

/// The result of the tracing.
#[derive(Debug, Clone)]
pub struct Trace {
    /// What is left.
    pub residual: Residual,
    /// A fitted number that the log has beyond its limits.
    pub farthest: Option<Base>,
    /// The base fit.
    pub before: Fit,
    /// The final fit: the base fit again where nothing was found.
    pub after: Fit,
    /// What was accepted, in the order of the final model's effects behind the declared ones.
    pub accepted: Vec<Accepted, ROUNDS>,
    /// Numbers of the declared actuator and of its log that the final fit has moved: those that every fit moves, and behind
    /// them those that turned out wrong.
    pub base: Numbers,
    /// Where those begin that turned out wrong: behind those of the options, and [`Base::InputLead`] where the log's input
    /// turned out late.
    pub first_freed: usize,
    /// Numbers of the current's sensor that were fitted.
    pub readings: Readings,
    /// A learned law that none of the catalogue follows, where nothing was accepted: structure that none explains, unless it is
    /// another law of an effect.
    pub unknown: Option<Unknown>,
    /// Whether something was found over predictions of one length, and nothing of it over those of another.
    pub unconfirmed: bool,
    /// How the log was cut and weighed in the end.
    pub settings: Settings,
    /// Windows of the judging length simulated.
    pub simulated: u64,
}

impl Trace {
    /// Takes back all that was found, as where other logs of the machine speak against it. The residual is still that of
    /// what was found.
    pub fn take_back(&mut self) {
        self.accepted.clear();
        self.unknown = None;
        self.base.truncate(self.first_freed);
        self.after = self.before.clone();
    }

    /// Numbers that every fit moves.
    pub fn fitted(&self) -> &[Base] {
        &self.base[..self.first_freed]
    }

    /// Numbers that turned out wrong.
    pub fn freed(&self) -> &[Base] {
        &self.base[self.first_freed..]
    }

    /// Whether it has found anything: an effect, structure that none explains, or wrong numbers.
    pub fn has_found(&self) -> bool {
        !self.accepted.is_empty() || self.unknown.is_some() || !self.freed().is_empty()
    }

    /// Whether it has found an effect too, or one that its log does not tell from it.
    pub(super) fn confirms(&self, effect: &Accepted) -> bool {
        let id = |accepted: &Accepted| accepted.candidate.effect.id;
        self.accepted.iter().any(|own| {
            id(own) == id(effect)
                || own.equivalent.contains(&id(effect))
                || effect.equivalent.contains(&id(own))
        })
    }

    /// Whether it has found a law over the variable of a map: a map, or an effect.
    pub(super) fn confirms_map(&self, map: Kind) -> bool {
        let own = self.unknown.as_ref().map(|unknown| unknown.kind);
        let effects = self.accepted.iter();
        let laws = effects.filter_map(|accepted| accepted.candidate.effect.id.map());
        let mut laws = own.into_iter().chain(laws);
        laws.any(|law| law.variable() == map.variable())
    }

    /// What it concludes.
    pub fn verdict(&self) -> Verdict {
        let unknown = self.unknown.as_ref();
        let is_named = unknown.is_some_and(|unknown| unknown.mechanism.is_some());
        if !self.accepted.is_empty() || is_named {
            Verdict::EffectsFound
        } else if self.unknown.is_some() {
            Verdict::UnknownEffect
        } else if self.residual.is_unexplained() || self.farthest.is_some() || self.unconfirmed {
            Verdict::NothingProven
        } else {
            Verdict::NoMissingEffect
        }
    }
}
