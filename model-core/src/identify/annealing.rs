//! Simulated annealing between bounds, with the options of the prognostics paper.
//!
//! Dalla Vedova, Maggiore and Pace, *A New Prognostic Method based on Simulated Annealing Algorithm
//! to deal with the Effects of Dry Friction on Electromechanical Actuators*, section III; equation
//! numbers are theirs.
//!
//! A *point* is a set of N parameters, its *cost* the energy E to be minimised. From the current
//! point a random *step* leads to a candidate, which is *accepted* as the current point if its cost
//! is lower, and with a probability P(ΔE) if it is higher (ΔE from eq. 1). Both the step and P
//! depend on the *temperature* T, which falls as the search goes on. Each parameter i has its own
//! temperature Tᵢ and *annealing parameter* kᵢ, which counts the candidates since the start; P uses
//! the highest.
//!
//! Inside, the parameters are scaled to their bounds, 0 to 1, and so is the temperature: at T = 1 a
//! step is as long as the distance of the bounds, whatever the unit. A step that leaves the bounds
//! is reflected at them.
//!
//! One parameter of a quadratic cost is found to 2 % of its bounds after 82 evaluations and to 0.1 %
//! after 500, with each of 200 seeds (defaults). It takes [`golden_section`](super::golden_section)
//! to go further cheaply, and other methods for four parameters and more.

use crate::numeric::invalid_parameter::{
    InvalidParameter, require, require_finite, require_positive,
};
use crate::numeric::random::Random;

/// Steps below 1e-7 of the bounds vanish in `f32`, so no temperature falls further.
const LOWEST_TEMPERATURE: f32 = 1e-7;

/// Share of the bounds over which re-annealing takes a slope: far above the resolution of `f32`, far
/// below the structure of a cost worth annealing.
const SLOPE_STEP: f32 = 1.0 / 1024.0;

/// How the random step depends on the temperature, n being a vector of standard normal numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StepFunction {
    /// "Fast annealing": length proportional to the temperature, Tᵢ nᵢ/‖n‖. Of a single parameter
    /// that is ±T, which explores by its change alone: not for slow cooling ([`Cooling::Boltzmann`]).
    #[default]
    Fast,
    /// "Boltzmann annealing": multivariate normal, √Tᵢ nᵢ.
    Boltzmann,
}

/// How the temperature falls with the annealing parameter k; T₀ at k = 0 in each.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Cooling {
    /// T₀ `factor`ᵏ, with `factor` between 0 and 1; 0.95 is usual.
    Exponential {
        /// Ratio of successive temperatures.
        factor: f32,
    },
    /// T₀/k, and T₀ while k < 1.
    Fast,
    /// T₀/ln k, and T₀ while k < e.
    Boltzmann,
}

/// With which probability a candidate of a higher cost is accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Acceptance {
    /// Eq. 2, e^(−ΔE/(k_b T)): from 1 downwards.
    Metropolis,
    /// Eq. 4, 1/(1 + e^(ΔE/(k_b T))): from 1/2 downwards.
    #[default]
    Logistic,
}

/// What is searched and how. [`Parameters::new`] gives the defaults.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters<const N: usize> {
    /// Lower bounds, each in its parameter's unit.
    pub lower: [f32; N],
    /// Upper bounds.
    pub upper: [f32; N],
    /// The first candidate, within the bounds.
    pub start: [f32; N],
    /// T₀, as a share of the distance of the bounds: positive.
    pub initial_temperature: f32,
    /// k_b in the unit of the cost: positive. The rise of the cost at T = 1 that is accepted with
    /// probability 1/e (eq. 2); about as much as the cost varies between the bounds.
    pub boltzmann_constant: f32,
    /// How the step depends on the temperature.
    pub step: StepFunction,
    /// How the temperature falls.
    pub cooling: Cooling,
    /// When a worse candidate is accepted.
    pub acceptance: Acceptance,
    /// Number of accepted candidates after which the temperatures are raised again (eq. 3); `None`
    /// for never.
    pub reannealing_interval: Option<u32>,
    /// Number of evaluations, those of re-annealing included: at least one.
    pub evaluations: u32,
}

impl<const N: usize> Parameters<N> {
    /// The paper's choices, MATLAB's defaults among them: fast annealing, exponential cooling by
    /// 0.95, eq. 4, re-annealing after 100 accepted candidates. T₀ is 1 where MATLAB's is 100
    /// without regard to the bounds. k_b = 1, 500 evaluations.
    pub const fn new(lower: [f32; N], upper: [f32; N], start: [f32; N]) -> Self {
        Self {
            lower,
            upper,
            start,
            initial_temperature: 1.0,
            boltzmann_constant: 1.0,
            step: StepFunction::Fast,
            cooling: Cooling::Exponential { factor: 0.95 },
            acceptance: Acceptance::Logistic,
            reannealing_interval: Some(100),
            evaluations: 500,
        }
    }

    /// A search that has not begun. The same `seed` gives the same search, on every machine.
    pub fn build(self, seed: u64) -> Result<Annealing<N>, InvalidParameter> {
        const { assert!(N > 0, "annealing needs a parameter to search") };
        let mut start = [0.0; N];
        for (i, start) in start.iter_mut().enumerate() {
            let (lower, upper) = (self.lower[i], self.upper[i]);
            require_finite(lower, "lower")?;
            require_finite(upper, "upper")?;
            let range = upper - lower;
            require(
                range > 0.0 && range.is_finite(),
                "upper",
                "must lie above lower, within f32",
            )?;
            let within = (lower..=upper).contains(&self.start[i]);
            require(within, "start", "must lie within the bounds")?;
            *start = (self.start[i] - lower) / range;
        }
        require_positive(self.initial_temperature, "initial_temperature")?;
        require_positive(self.boltzmann_constant, "boltzmann_constant")?;
        let log_factor = match self.cooling {
            Cooling::Exponential { factor } => {
                require(
                    factor > 0.0 && factor < 1.0,
                    "factor",
                    "must lie between 0 and 1",
                )?;
                libm::logf(factor)
            }
            Cooling::Fast | Cooling::Boltzmann => 0.0,
        };
        require(
            self.reannealing_interval != Some(0),
            "reannealing_interval",
            "must not be zero",
        )?;
        require(self.evaluations > 0, "evaluations", "must be at least one")?;
        Ok(Annealing {
            parameters: self,
            log_factor,
            random: Random::new(seed, 0),
            phase: Phase::Start,
            candidate: start,
            pending: true,
            current: start,
            current_cost: f32::INFINITY,
            best: None,
            annealing_parameter: [0.0; N],
            temperature: [self.initial_temperature; N],
            slopes: [0.0; N],
            accepted_since_reannealing: 0,
            evaluations: 0,
            accepted: 0,
            reannealings: 0,
        })
    }
}

/// What the pending candidate is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
enum Phase {
    /// The start point.
    Start,
    /// A random step.
    Walk,
    /// The slope of the cost along one parameter, for re-annealing.
    Slope(usize),
}

/// A search under way. A cost that is not finite is never accepted.
///
/// ```
/// use model_core::identify::annealing::Parameters;
///
/// // Two parameters in units of their own; the minimum is at (0.12, -300).
/// let mut annealing =
///     Parameters::new([0.0, -1000.0], [0.5, 1000.0], [0.4, 900.0]).build(1)?;
/// while let Some([coulomb, offset]) = annealing.propose() {
///     let (a, b) = ((coulomb - 0.12) / 0.5, (offset + 300.0) / 2000.0);
///     annealing.report(a * a + b * b);
/// }
/// let ([coulomb, offset], _cost) = annealing.best().unwrap();
/// assert!((coulomb - 0.12).abs() < 0.005 && (offset + 300.0).abs() < 20.0);
/// assert_eq!(annealing.evaluations(), 500);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Annealing<const N: usize> {
    parameters: Parameters<N>,
    /// Logarithm of the factor of exponential cooling, zero with another.
    log_factor: f32,
    random: Random,
    phase: Phase,
    /// Points are scaled to the bounds.
    candidate: [f32; N],
    /// Whether `candidate` still waits for its cost.
    pending: bool,
    current: [f32; N],
    current_cost: f32,
    /// In the parameters' units, as proposed.
    best: Option<([f32; N], f32)>,
    annealing_parameter: [f32; N],
    temperature: [f32; N],
    /// |∂E/∂xᵢ| times the distance of the bounds, zero if not known.
    slopes: [f32; N],
    accepted_since_reannealing: u32,
    evaluations: u32,
    accepted: u32,
    reannealings: u32,
}

impl<const N: usize> Annealing<N> {
    /// The point whose cost is wanted next, the same until it is reported; `None` when the
    /// evaluations are used up. Always within the bounds.
    pub fn propose(&mut self) -> Option<[f32; N]> {
        if self.evaluations >= self.parameters.evaluations {
            return None;
        }
        if !self.pending {
            self.candidate = match self.phase {
                Phase::Slope(i) => self.slope_probe(i),
                Phase::Start | Phase::Walk => self.random_step(),
            };
            self.pending = true;
        }
        Some(self.physical())
    }

    /// The cost of what was proposed. Ignored when nothing was.
    pub fn report(&mut self, cost: f32) {
        if !self.pending || self.evaluations >= self.parameters.evaluations {
            return;
        }
        self.pending = false;
        self.evaluations += 1;
        let cost = if cost.is_finite() {
            cost
        } else {
            f32::INFINITY
        };
        if cost < self.best.map_or(f32::INFINITY, |(_, best)| best) {
            self.best = Some((self.physical(), cost));
        }
        match self.phase {
            Phase::Start => {
                self.current_cost = cost;
                self.phase = Phase::Walk;
            }
            Phase::Walk => self.walk(cost),
            Phase::Slope(i) => {
                let slope = (cost - self.current_cost).abs() / SLOPE_STEP;
                self.slopes[i] = if slope.is_finite() { slope } else { 0.0 };
                if i + 1 < N {
                    self.phase = Phase::Slope(i + 1);
                } else {
                    self.reanneal();
                }
            }
        }
    }

    /// The best point so far and its cost; `None` before a finite cost.
    pub fn best(&self) -> Option<([f32; N], f32)> {
        self.best
    }

    /// The temperature of each parameter, as a share of the distance of its bounds.
    pub fn temperature(&self) -> [f32; N] {
        self.temperature
    }

    /// Number of costs reported.
    pub fn evaluations(&self) -> u32 {
        self.evaluations
    }

    /// Number of steps accepted.
    pub fn accepted(&self) -> u32 {
        self.accepted
    }

    /// Number of times that the temperatures were raised.
    pub fn reannealings(&self) -> u32 {
        self.reannealings
    }

    /// The pending candidate in the parameters' units.
    fn physical(&self) -> [f32; N] {
        if self.phase == Phase::Start {
            return self.parameters.start;
        }
        core::array::from_fn(|i| {
            let (lower, upper) = (self.parameters.lower[i], self.parameters.upper[i]);
            // Rounding may pass the bound by an ulp.
            (lower + self.candidate[i] * (upper - lower)).clamp(lower, upper)
        })
    }

    fn random_step(&mut self) -> [f32; N] {
        let (direction, norm) = loop {
            let direction: [f32; N] = core::array::from_fn(|_| self.random.normal());
            let norm = libm::sqrtf(
                direction
                    .iter()
                    .map(|component| component * component)
                    .sum(),
            );
            // A draw of zeros has no direction: once in 2³¹ draws of one parameter.
            if norm > 0.0 {
                break (direction, norm);
            }
        };
        core::array::from_fn(|i| {
            let length = match self.parameters.step {
                StepFunction::Fast => self.temperature[i] / norm,
                StepFunction::Boltzmann => libm::sqrtf(self.temperature[i]),
            };
            reflect(self.current[i] + length * direction[i])
        })
    }

    /// The current point, moved a little along parameter `i`, inwards.
    fn slope_probe(&self, i: usize) -> [f32; N] {
        let mut probe = self.current;
        probe[i] += if probe[i] > 0.5 {
            -SLOPE_STEP
        } else {
            SLOPE_STEP
        };
        probe
    }

    /// Accepts or rejects the candidate, then cools.
    fn walk(&mut self, cost: f32) {
        let rise = cost - self.current_cost;
        // Drawn whatever the outcome, so that the sequence of steps does not depend on rounding of
        // the cost more than it must. An infinite cost gives an infinite rise or NaN: rejected.
        let draw = self.random.uniform();
        let hottest = self
            .temperature
            .iter()
            .copied()
            .fold(LOWEST_TEMPERATURE, f32::max);
        let exponent = rise / (self.parameters.boltzmann_constant * hottest);
        if rise < 0.0 || draw < acceptance_probability(self.parameters.acceptance, exponent) {
            self.current = self.candidate;
            self.current_cost = cost;
            self.accepted += 1;
            self.accepted_since_reannealing += 1;
        }
        for k in &mut self.annealing_parameter {
            *k += 1.0;
        }
        self.cool();
        if Some(self.accepted_since_reannealing) == self.parameters.reannealing_interval {
            if N > 1 {
                self.phase = Phase::Slope(0);
            } else {
                // The only slope is the largest, whatever it is.
                self.slopes = [1.0; N];
                self.reanneal();
            }
        }
    }

    /// Lowers the annealing parameters by eq. 3, kᵢ = ln(T₀/Tᵢ · max(sⱼ)/sᵢ), which raises the
    /// temperatures, most where the cost is steep.
    fn reanneal(&mut self) {
        let steepest = self.slopes.iter().copied().fold(0.0, f32::max);
        for i in 0..N {
            let ratio = self.parameters.initial_temperature / self.temperature[i];
            let k = libm::logf(ratio * (steepest / self.slopes[i]));
            // Never raised: a parameter without a slope, or with none that is known, keeps its own.
            if k < self.annealing_parameter[i] {
                self.annealing_parameter[i] = if k > 0.0 { k } else { 0.0 };
            }
        }
        self.cool();
        self.accepted_since_reannealing = 0;
        self.reannealings += 1;
        self.phase = Phase::Walk;
    }

    /// The temperatures that belong to the annealing parameters.
    fn cool(&mut self) {
        for (temperature, &k) in self.temperature.iter_mut().zip(&self.annealing_parameter) {
            let share = match self.parameters.cooling {
                Cooling::Exponential { .. } => libm::expf(self.log_factor * k),
                Cooling::Fast if k > 1.0 => 1.0 / k,
                Cooling::Boltzmann if k > core::f32::consts::E => 1.0 / libm::logf(k),
                Cooling::Fast | Cooling::Boltzmann => 1.0,
            };
            let cooled = self.parameters.initial_temperature * share;
            *temperature = if cooled > LOWEST_TEMPERATURE {
                cooled
            } else {
                LOWEST_TEMPERATURE
            };
        }
    }
}

/// P of eq. 2 or eq. 4 for ΔE/(k_b T) = `exponent` ≥ 0.
fn acceptance_probability(acceptance: Acceptance, exponent: f32) -> f32 {
    // Beyond, P is below the resolution of the draw; NaN is rejected too.
    if exponent.is_nan() || exponent > 20.0 {
        return 0.0;
    }
    // micromath's exponential errs by 0.24 %: a probability of 0.5 becomes 0.501, which changes
    // one decision in a thousand and no result.
    match acceptance {
        Acceptance::Metropolis => micromath::F32Ext::exp(-exponent),
        Acceptance::Logistic => 1.0 / (1.0 + micromath::F32Ext::exp(exponent)),
    }
}

/// Mirrors a coordinate at 0 and 1 until it lies between them.
fn reflect(coordinate: f32) -> f32 {
    let folded = coordinate - 2.0 * libm::floorf(0.5 * coordinate);
    if folded > 1.0 { 2.0 - folded } else { folded }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINE: Parameters<1> = Parameters::new([0.0], [2.0], [1.7]);

    fn run<const N: usize>(
        parameters: Parameters<N>,
        seed: u64,
        cost: impl Fn([f32; N]) -> f32,
    ) -> Annealing<N> {
        let mut annealing = parameters.build(seed).unwrap();
        while let Some(candidate) = annealing.propose() {
            for i in 0..N {
                let (lower, upper) = (parameters.lower[i], parameters.upper[i]);
                assert!((lower..=upper).contains(&candidate[i]), "{candidate:?}");
            }
            assert_eq!(annealing.propose(), Some(candidate));
            annealing.report(cost(candidate));
        }
        annealing
    }

    /// Every combination of step function, cooling and acceptance.
    fn options() -> impl Iterator<Item = (StepFunction, Cooling, Acceptance)> {
        [StepFunction::Fast, StepFunction::Boltzmann]
            .into_iter()
            .flat_map(|step| {
                [
                    Cooling::Exponential { factor: 0.95 },
                    Cooling::Fast,
                    Cooling::Boltzmann,
                ]
                .into_iter()
                .flat_map(move |cooling| {
                    [Acceptance::Metropolis, Acceptance::Logistic]
                        .map(|acceptance| (step, cooling, acceptance))
                })
            })
    }

    /// Largest miss over many seeds, as a share of the bounds.
    fn worst_miss(parameters: Parameters<1>) -> f32 {
        (0..200)
            .map(|seed| {
                let annealing = run(parameters, seed, |[x]| (x - 0.779) * (x - 0.779));
                assert_eq!(annealing.evaluations(), parameters.evaluations);
                let ([x], _) = annealing.best().unwrap();
                (x - 0.779).abs() / 2.0
            })
            .fold(0.0, f32::max)
    }

    #[test]
    fn one_parameter_is_found_with_every_option() {
        for (step, cooling, acceptance) in options() {
            let slow = step == StepFunction::Fast && cooling == Cooling::Boltzmann;
            let miss = worst_miss(Parameters {
                step,
                cooling,
                acceptance,
                ..LINE
            });
            assert!(
                miss < if slow { 0.1 } else { 0.01 },
                "{step:?} {cooling:?}: {miss}"
            );
        }
    }

    #[test]
    fn one_parameter_takes_the_evaluations_that_the_documentation_says() {
        assert!(
            worst_miss(Parameters {
                evaluations: 82,
                ..LINE
            }) < 0.02
        );
        assert!(worst_miss(LINE) < 0.001);
    }

    #[test]
    fn leaves_local_minima() {
        // A valley of cost 1 around 0.8 holds the start; the lowest point is 0 at 0.2.
        let cost = |[x]: [f32; 1]| {
            let (near, far) = ((x - 0.8) * (x - 0.8), (x - 0.2) * (x - 0.2));
            if 20.0 * near + 1.0 < 20.0 * far {
                20.0 * near + 1.0
            } else {
                20.0 * far
            }
        };
        let parameters = Parameters::new([0.0], [1.0], [0.8]);
        for seed in 0..50 {
            let ([x], _) = run(parameters, seed, cost).best().unwrap();
            assert!((x - 0.2).abs() < 0.01, "seed {seed}: {x}");
        }
        // Too cold to leave: the search is one of descent.
        let cold = Parameters {
            initial_temperature: 0.01,
            ..parameters
        };
        let ([x], _) = run(cold, 0, cost).best().unwrap();
        assert!((x - 0.8).abs() < 0.01, "{x}");
    }

    #[test]
    fn one_seed_is_one_search() {
        let trace = |seed| {
            let mut annealing = LINE.build(seed).unwrap();
            core::array::from_fn::<u32, 100, _>(|_| {
                let [x] = annealing.propose().unwrap();
                annealing.report(x * x);
                x.to_bits()
            })
        };
        assert_eq!(trace(5), trace(5));
        assert_ne!(trace(5), trace(6));
    }

    #[test]
    fn first_candidate_is_the_start_to_the_bit() {
        let mut annealing = Parameters::new([-0.1], [0.7], [0.3]).build(0).unwrap();
        assert_eq!(annealing.propose(), Some([0.3]));
        annealing.report(4.0);
        assert_eq!(annealing.best(), Some(([0.3], 4.0)));
    }

    #[test]
    fn steps_are_as_long_as_the_temperature_says() {
        // At a constant cost that nothing is accepted from, the walk stays in the middle.
        let parameters = Parameters {
            initial_temperature: 0.04,
            acceptance: Acceptance::Metropolis,
            ..Parameters::new([-1.0, -1.0], [1.0, 1.0], [0.0, 0.0])
        };
        for step in [StepFunction::Fast, StepFunction::Boltzmann] {
            let mut squares = [0.0, 0.0];
            for seed in 0..2000 {
                let mut annealing = Parameters { step, ..parameters }.build(seed).unwrap();
                annealing.propose();
                annealing.report(0.0);
                let [x, y] = annealing.propose().unwrap();
                squares[0] += x * x;
                squares[1] += y * y;
                if step == StepFunction::Fast {
                    // T·(distance of the bounds) whatever the direction.
                    assert!((libm::sqrtf(x * x + y * y) - 0.08).abs() < 1e-6);
                }
            }
            // Mean squares: T²/2·2² each, or T·2² each, the second less what is reflected (5σ
            // inside the bounds: nothing). Standard error of 2000: 1.6 % and 3.2 %.
            let expected = if step == StepFunction::Fast {
                0.0032
            } else {
                0.16
            };
            for square in squares {
                assert!((square / 2000.0 / expected - 1.0).abs() < 0.15, "{square}");
            }
        }
    }

    #[test]
    fn acceptance_follows_the_equations() {
        for tenths in 0..=200 {
            let exponent = tenths as f32 / 10.0;
            let metropolis = libm::expf(-exponent);
            let logistic = 1.0 / (1.0 + libm::expf(exponent));
            for (acceptance, exact) in [
                (Acceptance::Metropolis, metropolis),
                (Acceptance::Logistic, logistic),
            ] {
                let probability = acceptance_probability(acceptance, exponent);
                assert!(
                    (probability / exact - 1.0).abs() < 0.003,
                    "{exponent}: {probability}"
                );
            }
        }
        for rejected in [f32::NAN, f32::INFINITY, 20.1] {
            assert_eq!(
                acceptance_probability(Acceptance::Metropolis, rejected),
                0.0
            );
        }
    }

    #[test]
    fn worse_candidates_are_accepted_as_often_as_the_equations_say() {
        // The cost rises by k_b T at the first step, whatever the step.
        for (acceptance, expected) in [
            (Acceptance::Metropolis, 0.367_88_f32),
            (Acceptance::Logistic, 0.268_94),
        ] {
            let parameters = Parameters {
                acceptance,
                boltzmann_constant: 3.0,
                ..LINE
            };
            let accepted: u32 = (0..10_000)
                .map(|seed| {
                    let mut annealing = parameters.build(seed).unwrap();
                    for cost in [0.0, 3.0] {
                        annealing.propose();
                        annealing.report(cost);
                    }
                    annealing.accepted()
                })
                .sum();
            // Five standard errors of 10 000 decisions.
            assert!(
                (accepted as f32 / 10_000.0 - expected).abs() < 0.025,
                "{accepted}"
            );
        }
    }

    #[test]
    fn temperature_follows_its_schedule() {
        for (cooling, expected) in [
            // 0.9^10, 1/10, 1/ln 10.
            (Cooling::Exponential { factor: 0.9 }, 0.348_678_4),
            (Cooling::Fast, 0.1),
            (Cooling::Boltzmann, core::f32::consts::LOG10_E),
        ] {
            let parameters = Parameters {
                cooling,
                initial_temperature: 2.0,
                evaluations: 11,
                ..LINE
            };
            let [temperature] = run(parameters, 0, |[x]| x).temperature();
            assert!(
                (temperature / (2.0 * expected) - 1.0).abs() < 1e-5,
                "{temperature}"
            );
        }
        // In the end nothing is left to cool.
        let long = Parameters {
            evaluations: 5000,
            reannealing_interval: None,
            ..LINE
        };
        assert_eq!(run(long, 0, |[x]| x).temperature(), [LOWEST_TEMPERATURE]);
    }

    #[test]
    fn reannealing_follows_equation_3() {
        // A plane with slopes 1 and 4 over the bounds. Every candidate is accepted: T₀ = 1 and k_b
        // so large that P = 1 up to micromath's error, checked by the counter.
        let parameters = Parameters {
            acceptance: Acceptance::Metropolis,
            boltzmann_constant: 1e9,
            reannealing_interval: Some(40),
            evaluations: 1 + 40 + 2,
            ..Parameters::new([0.0, 0.0], [1.0, 4.0], [0.5, 2.0])
        };
        let annealing = run(parameters, 3, |[x, y]| x + y);
        assert_eq!((annealing.accepted(), annealing.reannealings()), (40, 1));
        // Before: T = 0.95^40 = 0.12851. k₁ = ln(4/0.12851) = 3.4381, k₂ = ln(1/0.12851) = 2.0517.
        // After: T₁ = 0.95^3.4381 = 0.83833, T₂ = 0.95^2.0517 = 0.90013.
        let [first, second] = annealing.temperature();
        assert!((first - 0.838_33).abs() < 1e-3, "{first}");
        assert!((second - 0.900_13).abs() < 1e-3, "{second}");
    }

    #[test]
    fn a_flat_parameter_keeps_its_temperature_when_others_are_reheated() {
        let parameters = Parameters {
            boltzmann_constant: 1e9,
            acceptance: Acceptance::Metropolis,
            reannealing_interval: Some(40),
            evaluations: 1 + 40 + 2,
            ..Parameters::new([0.0, 0.0], [1.0, 1.0], [0.5, 0.5])
        };
        let annealing = run(parameters, 3, |[x, _]| x);
        assert_eq!(annealing.reannealings(), 1);
        let [steep, flat] = annealing.temperature();
        assert!(
            (flat - 0.128_51).abs() < 1e-4 && steep > 0.9,
            "{steep}, {flat}"
        );
    }

    #[test]
    fn costs_that_are_not_finite_are_never_accepted() {
        let annealing = run(LINE, 0, |[x]| {
            if x > 1.0 {
                f32::NAN
            } else if x > 0.9 {
                f32::NEG_INFINITY
            } else {
                x
            }
        });
        let ([x], cost) = annealing.best().unwrap();
        assert!(x <= 0.9 && cost == x && x < 0.02, "{x}");

        let hopeless = run(LINE, 0, |_| f32::NAN);
        assert_eq!((hopeless.best(), hopeless.accepted()), (None, 0));
        assert_eq!(hopeless.evaluations(), 500);
    }

    #[test]
    fn a_report_without_a_proposal_is_ignored() {
        let mut annealing = LINE.build(0).unwrap();
        annealing.propose();
        annealing.report(1.0);
        let before = annealing.clone();
        annealing.report(0.0);
        assert_eq!(annealing, before);
    }

    #[test]
    fn reflection_is_a_mirror() {
        for (coordinate, expected) in [
            (0.25, 0.25),
            (-0.25, 0.25),
            (1.25, 0.75),
            (2.25, 0.25),
            (-1.25, 0.75),
            (1.0, 1.0),
        ] {
            assert_eq!(reflect(coordinate), expected);
        }
    }

    #[test]
    fn bad_parameters_are_named() {
        let name = |parameters: Parameters<1>| parameters.build(0).unwrap_err().name;
        assert_eq!(
            name(Parameters {
                lower: [f32::NAN],
                ..LINE
            }),
            "lower"
        );
        assert_eq!(
            name(Parameters {
                upper: [0.0],
                ..LINE
            }),
            "upper"
        );
        assert_eq!(
            name(Parameters {
                start: [2.1],
                ..LINE
            }),
            "start"
        );
        assert_eq!(
            name(Parameters {
                start: [f32::NAN],
                ..LINE
            }),
            "start"
        );
        assert_eq!(
            name(Parameters {
                initial_temperature: 0.0,
                ..LINE
            }),
            "initial_temperature"
        );
        assert_eq!(
            name(Parameters {
                boltzmann_constant: f32::NAN,
                ..LINE
            }),
            "boltzmann_constant"
        );
        let cooling = Cooling::Exponential { factor: 1.0 };
        assert_eq!(name(Parameters { cooling, ..LINE }), "factor");
        let reannealing_interval = Some(0);
        assert_eq!(
            name(Parameters {
                reannealing_interval,
                ..LINE
            }),
            "reannealing_interval"
        );
        assert_eq!(
            name(Parameters {
                evaluations: 0,
                ..LINE
            }),
            "evaluations"
        );
    }
}
