//! Re-estimation of the Coulomb friction from a log, in small steps.
//!
//! Friction is what wear changes first in an actuator. The method is the prognostics paper's
//! (*A New Prognostic Method based on Simulated Annealing Algorithm to deal with the Effects of Dry
//! Friction on Electromechanical Actuators*, sections III and IV): simulate the declared actuator
//! with the measured input under a candidate friction, compare with what was measured, and let
//! simulated [`annealing`] choose the candidates. A [`golden_section`] search polishes the result
//! between the nearest candidates on either side of the annealing's best.
//!
//! The cost is that of a replay in *windows* of [`WINDOW`] seconds, each restarted from the
//! smoothed measured state: an unknown load in one of them does not spoil the others.
//!
//! ```text
//! E = Σ (q − q̂)² / Σ (q − q₀)²  +  Σ (i − î)² / Σ i²
//! ```
//!
//! with the measured position q and current i, the simulated q̂ and î, and q₀ the measured position
//! at the window's start. A model that stands still has a position part of 1. The second part is
//! left out where no current is measured, or where it is the input and the velocity in other words:
//! without inductance, and with a torque input. The level at breakaway keeps its declared ratio to
//! that of sliding.
//!
//! The bounds are the paper's 0.01 and 1.5 N·m, there around 0.12 N·m, beside the declared level:
//! a twelfth of it and twelve and a half times it.
//!
//! On logs of 10 s that another integrator made, with the loop closed over an encoder of 2¹⁴ counts,
//! a current sensor of 12 mA and 0.6 to 3 times the declared friction, the estimate is within 0.5 %
//! after 90 to 95 replays (`friction_refit.rs` among the host's tests): 82 by annealing, the rest by
//! golden section.

use super::annealing::{self, Annealing};
use super::golden_section::{self, GoldenSection};
use crate::gap::log::{Channel, Log};
use crate::gap::replay::{WINDOW, samples};
use crate::numeric::invalid_parameter::{InvalidParameter, require};
use crate::plant::State;
use crate::plant::actuator::Actuator;
use crate::plant::parameters::{Drive, Parameters};
use heapless::Vec;

/// Most windows that take part: 12.8 s, the first ones of a longer log. Each takes 12 bytes.
pub const MOST_WINDOWS: usize = 64;

/// Fewest windows that say something: 1 s of motion.
const LEAST_WINDOWS: usize = 5;

/// Samples on either side of a restart that its state is smoothed over.
const HALF_WIDTH: usize = 8;

/// Lower bound of the search, as a share of the declared level.
const LOWER: f32 = 1.0 / 12.0;

/// Upper bound.
const UPPER: f32 = 12.5;

/// Evaluations by annealing: it comes to 2 % of the bounds in so many.
const ANNEALED: u32 = 82;

/// Width to which the golden-section search narrows its bracket, as a share of the declared level.
const TOLERANCE: f32 = 1e-3;

/// Most evaluations by golden section: enough for a bracket as wide as the bounds.
const POLISHED: u32 = 30;

/// What is re-estimated, from what.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// The actuator as declared. Its friction must be the same in both directions.
    pub declared: Parameters,
    /// What it was seen to do.
    pub log: Log<'a>,
    /// Sensor resolution, rad or m; 0 if unknown.
    pub resolution: f32,
    /// The Coulomb friction in use, N·m or N: where the search starts, and what the estimate has to
    /// be better than.
    pub present: f32,
    /// Seed of the annealing: one seed is one search, on every machine.
    pub seed: u64,
}

/// A friction that explains the log better than the present one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Estimate {
    /// Coulomb friction, N·m or N.
    pub coulomb: f32,
    /// Friction at breakaway, N·m or N.
    pub breakaway: f32,
    /// E of the estimate.
    pub cost: f32,
    /// E of the present value.
    pub present_cost: f32,
    /// Replays of the log by annealing.
    pub annealing_evaluations: u32,
    /// Replays by golden section.
    pub golden_section_evaluations: u32,
    /// Windows of the log in each.
    pub windows: usize,
}

/// Why there is no estimate. The present value stays in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Refusal {
    /// The log has fewer than five whole windows: record longer.
    LogTooShort,
    /// The position stays within two counts of the sensor from the start to the end of a window:
    /// friction was never at work.
    NoMotion,
    /// The log, or what the declared actuator makes of it, is not finite: the sensor or the
    /// declaration is at fault.
    NonFinite,
    /// The cost falls down to the lower bound: something drives that is not declared, or the
    /// declared friction is far too large.
    AtLowerBound,
    /// The cost falls up to the upper bound: it is stuck, or the declared friction is far too small.
    AtUpperBound,
    /// No candidate is better than the present value, but for what the search resolves (0.2 % of the
    /// declared level): it is right, or friction is not what changed.
    NoImprovement,
}

impl core::fmt::Display for Refusal {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::LogTooShort => "the log is too short",
            Self::NoMotion => "the log has no motion",
            Self::NonFinite => "the log or its replay is not finite",
            Self::AtLowerBound => "the estimate lies at its lower bound",
            Self::AtUpperBound => "the estimate lies at its upper bound",
            Self::NoImprovement => "no friction explains the log better than the present one",
        })
    }
}

impl core::error::Error for Refusal {}

/// A re-estimation under way.
///
/// It never waits and never runs long: a call of [`Refit::advance`] replays one window, so that a
/// task beside a live plant can let others run, or drop the work, between any two. Where nothing waits
/// for it, [`Refit::run`] goes to the end.
///
/// ```
/// use model_core::gap::log::{Channel, Log};
/// use model_core::identify::friction::{Refit, Task};
/// use model_core::plant::parameters::{Drive, Parameters};
/// use model_core::plant::{Directional, State, actuator::Actuator};
///
/// let declared = Parameters {
///     drive: Drive::Voltage { resistance: 1.0, inductance: 1e-3, torque_constant: 0.06 },
///     viscous: Directional::both(2e-4),
///     coulomb: Directional::both(0.12),
///     breakaway: Directional::both(0.15),
///     ..Parameters::free(1.2e-4)
/// };
/// // Worn: half as much again.
/// let mut worn = Actuator::build(&declared, 1e-3)?;
/// worn.set_friction(0.18, 0.225);
/// let mut state = State::default();
/// let (mut input, mut position) = ([0.0; 2100], [0.0; 2100]);
/// for sample in 0..2100 {
///     input[sample] = if sample / 300 % 2 == 0 { 8.0 } else { -8.0 };
///     position[sample] = state.position.value();
///     worn.step(&mut state, input[sample])?;
/// }
/// let (input, position) = (Channel::Values(&input), Channel::Values(&position));
/// let log = Log::new(1e-3, input, position);
///
/// let task = Task { declared, log, resolution: 0.0, present: 0.12, seed: 1 };
/// let estimate = Refit::new(&task)?.run()?;
/// assert!((estimate.coulomb - 0.18).abs() < 0.0018);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Refit<'a> {
    replay: Replay<'a>,
    lower: f32,
    upper: f32,
    /// Breakaway level per Coulomb level.
    breakaway: f32,
    tolerance: f32,
    present: f32,
    annealing: Annealing<1>,
    stage: Stage,
    /// What is being evaluated, and its squared errors so far.
    candidate: f32,
    errors: Squares,
    /// Next window to be worked on.
    next: usize,
    present_cost: Option<f32>,
    bracket: Bracket,
}

/// What a call of [`Refit::advance`] works on.
#[derive(Debug, Clone)]
enum Stage {
    /// Restart states and scales.
    Preparing,
    Annealing,
    Polishing(GoldenSection),
    Over(Result<Estimate, Refusal>),
}

impl<'a> Refit<'a> {
    /// Work that has not begun. The actuator's modes are worked out here and never again.
    ///
    /// # Errors
    /// A parameter of the machine outside its range, a declared friction that is zero or not the
    /// same in both directions, or a present value outside the bounds (`start`).
    pub fn new(task: &Task<'a>) -> Result<Self, InvalidParameter> {
        let replay = Replay::new(task)?;
        let friction = replay.actuator.load();
        let (coulomb, breakaway) = (friction.coulomb.forward, friction.breakaway.forward);
        require(
            coulomb == friction.coulomb.backward && breakaway == friction.breakaway.backward,
            "friction",
            "must be declared the same in both directions",
        )?;
        require(coulomb > 0.0, "coulomb", "must be declared above 0")?;
        let (lower, upper) = (LOWER * coulomb, UPPER * coulomb);
        let annealing = annealing::Parameters {
            evaluations: ANNEALED,
            ..annealing::Parameters::new([lower], [upper], [task.present])
        }
        .build(task.seed)?;
        Ok(Self {
            replay,
            lower,
            upper,
            breakaway: breakaway / coulomb,
            tolerance: TOLERANCE * coulomb,
            present: task.present,
            annealing,
            stage: Stage::Preparing,
            candidate: task.present,
            errors: Squares::default(),
            next: 0,
            present_cost: None,
            bracket: Bracket {
                lower,
                upper,
                best: None,
            },
        })
    }

    /// Works until there is an outcome.
    ///
    /// # Errors
    /// Why there is no estimate.
    pub fn run(mut self) -> Result<Estimate, Refusal> {
        loop {
            if let Some(outcome) = self.advance() {
                return outcome;
            }
        }
    }

    /// Works on one window. `None` while there is more to do, then the outcome.
    pub fn advance(&mut self) -> Option<Result<Estimate, Refusal>> {
        match self.stage {
            Stage::Preparing => self.prepare(),
            Stage::Annealing | Stage::Polishing(_) => self.evaluate(),
            Stage::Over(_) => {}
        }
        match self.stage {
            Stage::Over(outcome) => Some(outcome),
            _ => None,
        }
    }

    fn prepare(&mut self) {
        if self.replay.windows < LEAST_WINDOWS {
            return self.end(Err(Refusal::LogTooShort));
        }
        self.replay.prepare(self.next);
        self.next += 1;
        if self.next == self.replay.windows {
            match self.replay.check() {
                Ok(()) => {
                    self.stage = Stage::Annealing;
                    self.propose();
                }
                Err(refusal) => self.end(Err(refusal)),
            }
        }
    }

    fn evaluate(&mut self) {
        self.errors.add(self.replay.errors(self.next));
        self.next += 1;
        if self.next == self.replay.windows {
            let cost = self.replay.cost(&self.errors);
            self.report(cost);
        }
    }

    fn report(&mut self, cost: f32) {
        // The first candidate is the present value.
        if self.present_cost.is_none() && !cost.is_finite() {
            return self.end(Err(Refusal::NonFinite));
        }
        self.present_cost.get_or_insert(cost);
        self.bracket.see(self.candidate, cost);
        match &mut self.stage {
            Stage::Annealing => self.annealing.report(cost),
            Stage::Polishing(search) => search.report(cost),
            Stage::Preparing | Stage::Over(_) => {}
        }
        self.propose();
    }

    /// Begins with the next candidate, of this stage or of the next.
    fn propose(&mut self) {
        let candidate = match &mut self.stage {
            Stage::Annealing => match self.annealing.propose() {
                Some([candidate]) => Some(candidate),
                None => self.polish(),
            },
            Stage::Polishing(search) => search.propose(),
            Stage::Preparing | Stage::Over(_) => None,
        };
        match candidate {
            Some(candidate) => {
                self.candidate = candidate;
                self.errors = Squares::default();
                self.next = 0;
                self.replay
                    .actuator
                    .set_friction(candidate, candidate * self.breakaway);
            }
            None => self.end(self.judge()),
        }
    }

    /// From annealing to golden section; its first candidate.
    fn polish(&mut self) -> Option<f32> {
        let search = golden_section::Parameters {
            lower: self.bracket.lower,
            upper: self.bracket.upper,
            tolerance: self.tolerance,
            evaluations: POLISHED,
        }
        .build()
        .ok()?;
        let candidate = search.propose();
        self.stage = Stage::Polishing(search);
        candidate
    }

    fn judge(&self) -> Result<Estimate, Refusal> {
        let present_cost = self.present_cost.unwrap_or(f32::INFINITY);
        let (coulomb, cost) = self.bracket.best.unwrap_or((self.lower, f32::INFINITY));
        let resolved = 2.0 * self.tolerance;
        if cost >= present_cost || (coulomb - self.present).abs() <= resolved {
            Err(Refusal::NoImprovement)
        } else if coulomb - self.lower <= resolved {
            Err(Refusal::AtLowerBound)
        } else if self.upper - coulomb <= resolved {
            Err(Refusal::AtUpperBound)
        } else {
            Ok(Estimate {
                coulomb,
                breakaway: coulomb * self.breakaway,
                cost,
                present_cost,
                annealing_evaluations: self.annealing.evaluations(),
                golden_section_evaluations: match &self.stage {
                    Stage::Polishing(search) => search.evaluations(),
                    _ => 0,
                },
                windows: self.replay.windows,
            })
        }
    }

    fn end(&mut self, outcome: Result<Estimate, Refusal>) {
        self.stage = Stage::Over(outcome);
    }
}

/// The best candidate so far, and the nearest ones on either side of it: between these lies the
/// minimum of a unimodal cost.
#[derive(Debug, Clone, Copy)]
struct Bracket {
    lower: f32,
    upper: f32,
    best: Option<(f32, f32)>,
}

impl Bracket {
    fn see(&mut self, candidate: f32, cost: f32) {
        // The end that is drawn in: by the candidate, or by what was the best before it.
        let end = match self.best {
            Some((best, least)) if cost < least => {
                self.best = Some((candidate, cost));
                if candidate < best {
                    self.upper = best;
                } else {
                    self.lower = best;
                }
                return;
            }
            Some((best, _)) => best,
            None => {
                self.best = Some((candidate, cost));
                return;
            }
        };
        if candidate < end {
            self.lower = self.lower.max(candidate);
        } else if candidate > end {
            self.upper = self.upper.min(candidate);
        }
    }
}

/// The state that a window's replay restarts from.
#[derive(Debug, Clone, Copy)]
struct Restart {
    position: f32,
    velocity: f32,
    current: f32,
}

/// Sums of squared errors, or of squared signals.
#[derive(Debug, Clone, Copy, Default)]
struct Squares {
    position: f64,
    current: f64,
}

impl Squares {
    fn add(&mut self, (position, current): (f32, f32)) {
        self.position += f64::from(position);
        self.current += f64::from(current);
    }
}

/// The log in windows, and the actuator that is driven through them.
#[derive(Debug, Clone)]
struct Replay<'a> {
    log: Log<'a>,
    declared: Parameters,
    resolution: f32,
    /// Samples in a window.
    window: usize,
    windows: usize,
    restarts: Vec<Restart, MOST_WINDOWS>,
    /// Squared signals: what squared errors are divided by.
    scale: Squares,
    actuator: Actuator,
}

impl<'a> Replay<'a> {
    fn new(task: &Task<'a>) -> Result<Self, InvalidParameter> {
        let (mut log, declared) = (task.log, &task.declared);
        let actuator = Actuator::build(declared, log.period).map_err(|error| InvalidParameter {
            name: error.parameter,
            requirement: error.requirement,
        })?;
        if !matches!(declared.drive, Drive::Voltage { inductance, .. } if inductance > 0.0) {
            log.current = None;
        }
        let window = samples(WINDOW, log.period, 1);
        let windows = log.samples().saturating_sub(2 * HALF_WIDTH + 1) / window;
        Ok(Self {
            log,
            declared: *declared,
            resolution: task.resolution,
            window,
            windows: windows.min(MOST_WINDOWS),
            restarts: Vec::new(),
            scale: Squares::default(),
            actuator,
        })
    }

    /// First sample of a window.
    fn start(&self, window: usize) -> usize {
        HALF_WIDTH + window * self.window
    }

    /// Keeps the state that the next window restarts from, and adds to the scales.
    fn prepare(&mut self, window: usize) {
        let start = self.start(window);
        let log = &self.log;
        let state = log.smoothed_state(start, HALF_WIDTH, self.resolution);
        let velocity = state.velocity.value();
        let restart = Restart {
            position: state.position.value(),
            velocity,
            current: match log.current {
                Some(current) => current.at(start),
                None => self.declared.steady_current(velocity, log.input.at(start)),
            },
        };
        // As many as there are windows.
        let _ = self.restarts.push(restart);
        let (mut position, mut current) = (0.0, 0.0);
        for index in start..start + self.window {
            let travel = log.position.at(index + 1) - log.position.at(start);
            position += travel * travel;
            if let Some(measured) = log.current {
                current += measured.at(index) * measured.at(index);
            }
        }
        self.scale.add((position, current));
    }

    /// Whether the log is one to estimate friction from.
    fn check(&self) -> Result<(), Refusal> {
        let travel = 2.0 * f64::from(self.resolution);
        let still = travel * travel * (self.windows * self.window) as f64;
        if !(self.scale.position + self.scale.current).is_finite() {
            Err(Refusal::NonFinite)
        } else if self.scale.position <= still {
            Err(Refusal::NoMotion)
        } else {
            Ok(())
        }
    }

    /// Squared errors of position and current in a window; NaN where an input is refused.
    fn errors(&self, window: usize) -> (f32, f32) {
        let start = self.start(window);
        let end = start + self.window;
        let log = &self.log;
        let mut run = Run::new(&self.actuator, &self.restarts[window]);
        let mut index = start;
        while index < end {
            if let Some([input, position, current]) = self.counts(index, end) {
                let samples = input.values().zip(position.values()).zip(current.values());
                for ((input, position), current) in samples {
                    run.sample(input, position, Some(current));
                }
                index += input.counts.len();
            } else {
                let current = log.current.map(|current| current.at(index));
                run.sample(log.input.at(index), log.position.at(index + 1), current);
                index += 1;
            }
        }
        (run.position, run.current)
    }

    /// Input, position at the next sample, and current from a sample on, where all are counts: as
    /// many as lie in one piece in each ring. They are most of the work on a board, and from slices
    /// of one length they cost a third of what they do one by one.
    fn counts(&self, index: usize, end: usize) -> Option<[Piece<'a>; 3]> {
        let input = Piece::new(&self.log.input, index)?;
        let position = Piece::new(&self.log.position, index + 1)?;
        let current = Piece::new(&self.log.current?, index)?;
        let pieces = [input, position, current];
        let most = pieces.iter().map(|piece| piece.counts.len()).min()?;
        let length = most.min(end - index);
        Some(pieces.map(|piece| Piece {
            counts: &piece.counts[..length],
            ..piece
        }))
    }

    /// E of the squared errors of all windows.
    fn cost(&self, errors: &Squares) -> f32 {
        let share = |error: f64, scale: f64| if scale > 0.0 { error / scale } else { 0.0 };
        let position = share(errors.position, self.scale.position);
        (position + share(errors.current, self.scale.current)) as f32
    }
}

/// Neighbouring samples of a channel of counts.
#[derive(Debug, Clone, Copy)]
struct Piece<'a> {
    counts: &'a [i16],
    unit: f32,
}

impl<'a> Piece<'a> {
    /// From a sample on, to the end of the part of the ring that it lies in.
    fn new(channel: &Channel<'a>, index: usize) -> Option<Self> {
        let Channel::Counts { older, newer, unit } = *channel else {
            return None;
        };
        let counts = match index.checked_sub(older.len()) {
            None => &older[index..],
            Some(index) => &newer[index..],
        };
        Some(Self { counts, unit })
    }

    #[inline]
    fn values(self) -> impl Iterator<Item = f32> {
        self.counts
            .iter()
            .map(move |&count| f32::from(count) * self.unit)
    }
}

/// A replay on its way through a window.
struct Run<'a> {
    actuator: &'a Actuator,
    state: State,
    /// Sum of squared errors, as the current's.
    position: f32,
    current: f32,
}

impl<'a> Run<'a> {
    fn new(actuator: &'a Actuator, restart: &Restart) -> Self {
        let mut state = State::new(restart.position, restart.velocity);
        state.current = restart.current;
        Self {
            actuator,
            state,
            position: 0.0,
            current: 0.0,
        }
    }

    /// Takes the current at a sample, then steps to the next and takes the position there.
    #[inline(always)]
    fn sample(&mut self, input: f32, position: f32, current: Option<f32>) {
        if let Some(current) = current {
            let error = self.state.current - current;
            self.current += error * error;
        }
        if self.actuator.step(&mut self.state, input).is_err() {
            self.position = f32::NAN;
        }
        let error = self.state.position.from(position);
        self.position += error * error;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::Directional;

    const DECLARED: Parameters = Parameters {
        drive: Drive::Voltage {
            resistance: 1.0,
            inductance: 1e-3,
            torque_constant: 0.06,
        },
        viscous: Directional::both(2e-4),
        coulomb: Directional::both(0.12),
        breakaway: Directional::both(0.15),
        ..Parameters::free(1.2e-4)
    };

    const SAMPLES: usize = 2100;

    /// Channels of a log: input, position, current.
    type Channels = [[f32; SAMPLES]; 3];

    /// A motor of the declared kind with another friction, under a voltage that changes its sign
    /// every 0.3 s.
    fn record(coulomb: f32, volts: f32) -> Channels {
        let mut actuator = Actuator::build(&DECLARED, 1e-3).unwrap();
        actuator.set_friction(coulomb, 1.25 * coulomb);
        let mut state = State::default();
        let mut channels = [[0.0; SAMPLES]; 3];
        for sample in 0..SAMPLES {
            let input = if sample / 300 % 2 == 0 { volts } else { -volts };
            channels[0][sample] = input;
            channels[1][sample] = state.position.value();
            channels[2][sample] = state.current;
            actuator.step(&mut state, input).unwrap();
        }
        channels
    }

    fn task(channels: &Channels) -> Task<'_> {
        Task {
            declared: DECLARED,
            log: Log {
                current: Some(Channel::Values(&channels[2])),
                ..Log::new(
                    1e-3,
                    Channel::Values(&channels[0]),
                    Channel::Values(&channels[1]),
                )
            },
            resolution: 0.0,
            present: 0.12,
            seed: 1,
        }
    }

    /// The outcome, and the calls that it took.
    fn run(task: &Task) -> (Result<Estimate, Refusal>, usize) {
        let mut refit = Refit::new(task).unwrap();
        let mut calls = 1;
        loop {
            if let Some(outcome) = refit.advance() {
                assert_eq!(refit.advance(), Some(outcome), "an outcome is final");
                return (outcome, calls);
            }
            calls += 1;
        }
    }

    #[test]
    fn finds_the_friction_with_and_without_current() {
        let channels = record(0.2, 8.0);
        for seed in 0..5 {
            let task = Task {
                seed,
                ..task(&channels)
            };
            let estimate = run(&task).0.unwrap();
            assert!((estimate.coulomb / 0.2 - 1.0).abs() < 2e-3, "{estimate:?}");
            let ratio = estimate.breakaway / estimate.coulomb;
            assert!((ratio - 1.25).abs() < 1e-6, "{ratio}");
            assert!(estimate.cost < 0.01 * estimate.present_cost);
            let log = Log {
                current: None,
                ..task.log
            };
            let estimate = run(&Task { log, ..task }).0.unwrap();
            assert!((estimate.coulomb / 0.2 - 1.0).abs() < 2e-3, "{estimate:?}");
        }
    }

    #[test]
    fn a_call_works_on_one_window() {
        let channels = record(0.2, 8.0);
        let (outcome, calls) = run(&task(&channels));
        let estimate = outcome.unwrap();
        let replays = estimate.annealing_evaluations + estimate.golden_section_evaluations;
        assert_eq!(estimate.windows, 10);
        assert_eq!(calls, 10 * (1 + replays as usize));
    }

    #[test]
    fn the_start_is_the_present_value_and_has_to_be_beaten() {
        let channels = record(0.2, 8.0);
        let present = Task {
            present: 0.2,
            ..task(&channels)
        };
        assert_eq!(run(&present).0, Err(Refusal::NoImprovement));
        let far = Task {
            present: 1.2,
            ..task(&channels)
        };
        let estimate = run(&far).0.unwrap();
        assert!((estimate.coulomb / 0.2 - 1.0).abs() < 2e-3, "{estimate:?}");
    }

    #[test]
    fn a_log_too_short_or_without_motion_is_refused() {
        let channels = record(0.2, 8.0);
        let mut short = task(&channels);
        short.log.position = Channel::Values(&channels[1][..5 * 200 + 2 * HALF_WIDTH]);
        assert_eq!(run(&short).0, Err(Refusal::LogTooShort));
        short.log.position = Channel::Values(&channels[1][..5 * 200 + 2 * HALF_WIDTH + 1]);
        assert!(run(&short).0.is_ok());
        short.log.position = Channel::Values(&[]);
        assert_eq!(run(&short).0, Err(Refusal::LogTooShort));

        // 2 V are 0.12 N·m: not enough to break away from 0.25 N·m.
        let still = record(0.2, 2.0);
        assert_eq!(run(&task(&still)).0, Err(Refusal::NoMotion));
        let mut dithering = still;
        for (sample, position) in dithering[1].iter_mut().enumerate() {
            *position = 1e-3 * (sample % 3) as f32;
        }
        let counts = Task {
            resolution: 1e-3,
            ..task(&dithering)
        };
        assert_eq!(run(&counts).0, Err(Refusal::NoMotion));
    }

    #[test]
    fn an_estimate_at_a_bound_is_refused() {
        // Bounds of 0.01 and 1.5 N·m.
        let free = record(0.0, 8.0);
        assert_eq!(run(&task(&free)).0, Err(Refusal::AtLowerBound));
        let heavy = record(1.8, 40.0);
        assert_eq!(run(&task(&heavy)).0, Err(Refusal::AtUpperBound));
    }

    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        for channel in 0..3 {
            for value in [f32::NAN, f32::INFINITY] {
                let mut channels = record(0.2, 8.0);
                channels[channel][1000] = value;
                assert_eq!(run(&task(&channels)).0, Err(Refusal::NonFinite));
            }
        }
    }

    #[test]
    fn bad_tasks_are_named() {
        let channels = record(0.2, 8.0);
        let name = |task: Task| Refit::new(&task).unwrap_err().name;
        let good = task(&channels);
        for present in [0.009, 1.51, f32::NAN] {
            assert_eq!(name(Task { present, ..good }), "start");
        }
        let with = |coulomb, breakaway| Task {
            declared: Parameters {
                coulomb,
                breakaway,
                ..DECLARED
            },
            ..good
        };
        let both = Directional::both;
        let uneven = Directional {
            forward: 0.12,
            backward: 0.13,
        };
        assert_eq!(name(with(both(0.0), both(0.15))), "coulomb");
        assert_eq!(name(with(uneven, both(0.15))), "friction");
        assert_eq!(name(with(both(0.01), uneven)), "friction");
        assert_eq!(name(with(both(-1.0), both(0.15))), "coulomb");
        for period in [0.0, f32::NAN, 11.0] {
            let mut timeless = good;
            timeless.log.period = period;
            assert_eq!(name(timeless), "period");
        }
    }
}
