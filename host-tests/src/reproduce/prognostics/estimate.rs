//! Friction from a log: eq. 5 minimised by annealing, polished by golden section.

use model_core::gap::log::Log;
use model_core::identify::annealing;
use model_core::identify::polished::{self, HALF_BRACKET};
use model_core::identify::position_error::{HALF_WIDTH, Levels, PositionError};
use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::Parameters;

/// The paper's bounds and start, N·m.
pub const LOWER: f32 = 0.01;
/// Upper bound.
pub const UPPER: f32 = 1.5;
/// Friction of the healthy actuator.
pub const START: f32 = 0.12;

/// Length of the windows of the replay, s.
pub const WINDOW: f32 = 0.2;

/// What the estimate of one level takes the other for, breakaway per Coulomb level: low in what the bench
/// draws, and below the 1.25 of the project's own actuators. It costs little on a sweep, most on a step.
pub const BREAKAWAY_PER_COULOMB: f32 = 1.075;

/// Largest breakaway level per Coulomb level that is looked for. That it is never below 1 is what the
/// paper's simplex could not be told.
pub const MOST_BREAKAWAY: f32 = 1.5;

/// Width to which golden section goes, as a share of the bounds: 1.5e-4 N·m.
const TOLERANCE: f32 = 1e-4;

/// Root mean square of what a sensor's noise and drift make of a standstill within a window, in counts, at
/// most.
const NOISE_COUNTS: f32 = 4.0;

/// A log from which no friction follows.
const UNUSABLE: InvalidParameter = InvalidParameter {
    name: "log",
    requirement: "must be finite and have motion",
};

/// One evaluation of a search, in order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluation {
    /// Of the annealing, as a share of the bounds; the last one while golden section polishes.
    pub temperature: f32,
    /// What was tried, N·m.
    pub coulomb: f32,
    /// Its E, rad²·s.
    pub cost: f32,
    /// The least E so far.
    pub least: f32,
}

/// What came of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The levels with the least E.
    pub levels: Levels,
    /// Their E, rad²·s.
    pub cost: f32,
    /// The best that annealing alone found.
    pub annealed: Levels,
    /// Replays of the log by annealing.
    pub annealing_evaluations: u32,
    /// Steps that annealing accepted.
    pub accepted: u32,
    /// Times that it raised its temperature again (eq. 3).
    pub reannealings: u32,
    /// Replays by golden section.
    pub polish_evaluations: u32,
    /// Every evaluation.
    pub history: Vec<Evaluation>,
}

/// How a search is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Windows of the replay, s; `None` for the paper's free run.
    pub window: Option<f32>,
    /// One count of the position sensor, rad.
    pub resolution: f32,
    /// T₀, step, cooling, acceptance, re-annealing, evaluations; bounds, start and k_b are set.
    pub annealing: annealing::Parameters<1>,
    /// Most evaluations by golden section.
    pub polish: u32,
}

impl Default for Options {
    /// In windows, the bench's encoder, 82 evaluations by annealing with its defaults.
    fn default() -> Self {
        Self {
            window: Some(WINDOW),
            resolution: super::stand::RESOLUTION as f32,
            annealing: annealing::Parameters {
                evaluations: 82,
                ..annealing::Parameters::new([LOWER], [UPPER], [START])
            },
            polish: 60,
        }
    }
}

/// What is minimised: how far a model with these levels is from a log.
pub trait Objective {
    /// E of these levels, rad²·s.
    fn at(&mut self, levels: Levels) -> f32;

    /// E of a model that does not move, rad²·s.
    fn at_rest(&self) -> f32;
}

impl Objective for PositionError<'_> {
    fn at(&mut self, levels: Levels) -> f32 {
        PositionError::at(self, levels)
    }

    fn at_rest(&self) -> f32 {
        PositionError::at_rest(self)
    }
}

/// Windows or one free run, by the sampling period alone: a window is worth its restart only if the
/// samples over which the restart is smoothed are short beside it, a quarter of it at most. So from
/// 3 ms on it is a free run.
pub fn window_for(period: f32) -> Option<f32> {
    let smoothed = (2 * HALF_WIDTH + 1) as f32 * period;
    (smoothed <= 0.25 * WINDOW).then_some(WINDOW)
}

/// E on a log.
///
/// # Errors
/// What the core refuses.
pub fn error<'a>(
    model: &Parameters,
    log: &Log<'a>,
    options: &Options,
) -> Result<PositionError<'a>, InvalidParameter> {
    PositionError::new(model, log, options.resolution, options.window)
}

/// One number: the Coulomb level, the breakaway level in a fixed ratio to it.
///
/// # Errors
/// What the core refuses, and a log that it cannot replay (`log`).
pub fn one(
    model: &Parameters,
    log: &Log,
    options: &Options,
    seed: u64,
) -> Result<Estimate, InvalidParameter> {
    let mut error = error(model, log, options)?;
    require_motion(&error, log, options)?;
    one_of(&mut error, options, seed)
}

/// Refuses a log in which only the sensor's noise moves: on it every level that holds the model is as good
/// as the other.
fn require_motion(
    error: &PositionError,
    log: &Log,
    options: &Options,
) -> Result<(), InvalidParameter> {
    let seconds = error.steps() as f32 * log.period;
    let noise = NOISE_COUNTS * options.resolution;
    // What is not a number is refused with its own reason, later.
    if error.at_rest() <= noise * noise * seconds {
        return Err(UNUSABLE);
    }
    Ok(())
}

/// As [`one`], with an objective of any kind.
///
/// # Errors
/// As [`one`].
pub fn one_of(
    objective: &mut impl Objective,
    options: &Options,
    seed: u64,
) -> Result<Estimate, InvalidParameter> {
    let search_for = (options.annealing, [HALF_BRACKET]);
    search(objective, options, search_for, seed, |[coulomb]| {
        in_ratio(coulomb)
    })
}

/// Coulomb and breakaway level, each a number. The second is searched as a ratio to the first.
///
/// # Errors
/// As [`one`].
pub fn two(
    model: &Parameters,
    log: &Log,
    options: &Options,
    seed: u64,
) -> Result<Estimate, InvalidParameter> {
    let one = options.annealing;
    let annealing = annealing::Parameters {
        initial_temperature: one.initial_temperature,
        step: one.step,
        cooling: one.cooling,
        acceptance: one.acceptance,
        reannealing_interval: one.reannealing_interval,
        evaluations: 2 * one.evaluations,
        ..annealing::Parameters::new(
            [LOWER, 1.0],
            [UPPER, MOST_BREAKAWAY],
            [START, BREAKAWAY_PER_COULOMB],
        )
    };
    let options = Options {
        polish: 4 * options.polish,
        ..*options
    };
    let levels = |[coulomb, ratio]: [f32; 2]| Levels {
        coulomb,
        breakaway: ratio * coulomb,
    };
    // E hardly depends on the breakaway: annealing leaves it anywhere.
    let search_for = (annealing, [HALF_BRACKET, 1.0]);
    let mut error = error(model, log, &options)?;
    require_motion(&error, log, &options)?;
    search(&mut error, &options, search_for, seed, levels)
}

/// The levels that a Coulomb level alone stands for.
pub fn in_ratio(coulomb: f32) -> Levels {
    Levels {
        coulomb,
        breakaway: BREAKAWAY_PER_COULOMB * coulomb,
    }
}

fn search<const N: usize>(
    objective: &mut impl Objective,
    options: &Options,
    (annealing, half_bracket): (annealing::Parameters<N>, [f32; N]),
    seed: u64,
    levels: impl Fn([f32; N]) -> Levels,
) -> Result<Estimate, InvalidParameter> {
    let at_rest = objective.at_rest();
    if !(at_rest.is_finite() && at_rest > 0.0) {
        return Err(UNUSABLE);
    }
    let mut search = polished::Parameters {
        annealing: annealing::Parameters {
            // A model that stands still is as bad as one can be that errs on the safe side.
            boltzmann_constant: at_rest,
            ..annealing
        },
        tolerance: TOLERANCE,
        half_bracket,
        polish: options.polish,
    }
    .build(seed)?;
    let mut history = Vec::new();
    let (mut annealed, mut least) = (None, f32::INFINITY);
    while let Some(candidate) = search.propose() {
        let tried = levels(candidate);
        let cost = objective.at(tried);
        search.report(cost);
        if let Some((_, best)) = search.best() {
            least = best;
        }
        if search.polish_evaluations() == 0 {
            annealed = search.best().map(|(best, _)| levels(best));
        }
        history.push(Evaluation {
            temperature: search.annealing().temperature()[0],
            coulomb: tried.coulomb,
            cost,
            least,
        });
    }
    let (Some((best, cost)), Some(annealed)) = (search.best(), annealed) else {
        return Err(UNUSABLE);
    };
    Ok(Estimate {
        levels: levels(best),
        cost,
        annealed,
        annealing_evaluations: search.annealing().evaluations(),
        accepted: search.annealing().accepted(),
        reannealings: search.annealing().reannealings(),
        polish_evaluations: search.polish_evaluations(),
        history,
    })
}
