//! Simulated annealing, polished by golden section.
//!
//! [`annealing`] comes near the lowest minimum from wherever it starts, but takes
//! hundreds of evaluations for the last per cent. [`golden_section`] takes a
//! dozen, but sees one minimum of one parameter. So the first brings the second near, and the second
//! goes on along each parameter in turn: in a bracket around the best point, which is drawn in from
//! round to round, and moved and widened where the minimum lies at its end.

use super::annealing::{self, Annealing};
use super::golden_section::{self, GoldenSection};
use crate::numeric::invalid_parameter::{InvalidParameter, require};

/// Half of the first bracket that suits most costs, as a share of the distance of the bounds: annealing
/// comes to 2 %.
pub const HALF_BRACKET: f32 = 0.025;

/// From one round's bracket to the next one's.
const NARROWING: f32 = 0.5;

/// Most evaluations of one golden-section search: enough for the bounds and a tolerance of 1e-6.
const LONGEST: u32 = 32;

/// What is searched and how.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters<const N: usize> {
    /// Bounds, start and the options of the annealing.
    pub annealing: annealing::Parameters<N>,
    /// Width to which golden section narrows each parameter, as a share of the distance of its
    /// bounds: above 0, at most 0.01.
    pub tolerance: f32,
    /// Half of each parameter's first bracket, as a share of the distance of its bounds: above 0, up
    /// to 1. [`HALF_BRACKET`], and more for a parameter on which the cost hardly depends.
    pub half_bracket: [f32; N],
    /// Most evaluations by golden section; 0 for none.
    pub polish: u32,
}

impl<const N: usize> Parameters<N> {
    /// A search that has not begun. The same `seed` gives the same search, on every machine.
    ///
    /// # Errors
    /// What the annealing refuses; a tolerance that is out of range.
    pub fn build(self, seed: u64) -> Result<Polished<N>, InvalidParameter> {
        require(
            self.tolerance > 0.0 && self.tolerance <= 0.01,
            "tolerance",
            "must lie between 0 and 0.01",
        )?;
        for half in self.half_bracket {
            require(
                half > 0.0 && half <= 1.0,
                "half_bracket",
                "must lie between 0 and 1",
            )?;
        }
        Ok(Polished {
            annealing: self.annealing.build(seed)?,
            parameters: self,
            best: None,
            line: None,
            half_bracket: self.half_bracket,
            moved: false,
            polished: 0,
        })
    }
}

/// Golden section along one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Line<const N: usize> {
    along: usize,
    /// The point through which it leads.
    through: [f32; N],
    bracket: (f32, f32),
}

/// A search under way.
///
/// ```
/// use model_core::identify::{annealing, polished::{HALF_BRACKET, Parameters}};
///
/// let mut search = Parameters {
///     annealing: annealing::Parameters {
///         evaluations: 82,
///         ..annealing::Parameters::new([0.01], [1.5], [0.12])
///     },
///     tolerance: 1e-4,
///     half_bracket: [HALF_BRACKET],
///     polish: 40,
/// }
/// .build(1)?;
/// while let Some([coulomb]) = search.propose() {
///     search.report((coulomb - 0.779) * (coulomb - 0.779));
/// }
/// let ([coulomb], _cost) = search.best().unwrap();
/// assert!((coulomb - 0.779).abs() < 2e-4);
/// assert_eq!(search.annealing().evaluations(), 82);
/// assert!(search.polish_evaluations() <= 40);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Polished<const N: usize> {
    parameters: Parameters<N>,
    annealing: Annealing<N>,
    best: Option<([f32; N], f32)>,
    /// The line searched now, once annealing is over.
    line: Option<(Line<N>, GoldenSection)>,
    half_bracket: [f32; N],
    /// Whether this round moved a parameter by more than the tolerance.
    moved: bool,
    polished: u32,
}

impl<const N: usize> Polished<N> {
    /// The point whose cost is wanted next, the same until it is reported; `None` when done.
    pub fn propose(&mut self) -> Option<[f32; N]> {
        if let Some(candidate) = self.annealing.propose() {
            return Some(candidate);
        }
        // Without a finite cost there is nothing to polish.
        self.best?;
        while self.polished < self.parameters.polish {
            if self.line.is_none() {
                self.line = self.search(0);
            }
            let (line, search) = self.line.as_ref()?;
            if let Some(at) = search.propose() {
                let mut candidate = line.through;
                candidate[line.along] = at;
                return Some(candidate);
            }
            let line = *line;
            self.line = Some(self.after(&line)?);
        }
        None
    }

    /// The cost of what was proposed. Ignored when nothing was.
    pub fn report(&mut self, cost: f32) {
        let candidate = match self.propose() {
            Some(candidate) if cost.is_finite() => Some(candidate),
            Some(_) => None,
            None => return,
        };
        match &mut self.line {
            Some((_, search)) => {
                search.report(cost);
                self.polished += 1;
            }
            None => self.annealing.report(cost),
        }
        let least = self.best.map_or(f32::INFINITY, |(_, least)| least);
        if let Some(candidate) = candidate
            && cost < least
        {
            self.best = Some((candidate, cost));
        }
    }

    /// The best point so far and its cost; `None` before a finite cost.
    pub fn best(&self) -> Option<([f32; N], f32)> {
        self.best
    }

    /// The annealing: its temperature, its counts.
    pub fn annealing(&self) -> &Annealing<N> {
        &self.annealing
    }

    /// Number of costs reported to golden section.
    pub fn polish_evaluations(&self) -> u32 {
        self.polished
    }

    /// Distance of a parameter's bounds.
    fn range(&self, along: usize) -> f32 {
        self.parameters.annealing.upper[along] - self.parameters.annealing.lower[along]
    }

    /// A search along a parameter through the best point.
    fn search(&self, along: usize) -> Option<(Line<N>, GoldenSection)> {
        let (through, _) = self.best?;
        let (lower, upper) = (
            self.parameters.annealing.lower[along],
            self.parameters.annealing.upper[along],
        );
        let half = self.half_bracket[along] * self.range(along);
        let bracket = (
            (through[along] - half).max(lower),
            (through[along] + half).min(upper),
        );
        let search = golden_section::Parameters {
            lower: bracket.0,
            upper: bracket.1,
            tolerance: self.parameters.tolerance * self.range(along),
            evaluations: LONGEST,
        }
        .build()
        .ok()?;
        let line = Line {
            along,
            through,
            bracket,
        };
        Some((line, search))
    }

    /// What follows a line that is searched to its end; `None` when nothing does.
    fn after(&mut self, line: &Line<N>) -> Option<(Line<N>, GoldenSection)> {
        let along = line.along;
        let (best, _) = self.best?;
        let resolved = 2.0 * self.parameters.tolerance * self.range(along);
        let parameters = &self.parameters.annealing;
        let at_end = |end: f32, bound: f32| (best[along] - end).abs() <= resolved && end != bound;
        let moved = (best[along] - line.through[along]).abs() > resolved;
        self.moved |= moved;
        let beyond = at_end(line.bracket.0, parameters.lower[along])
            || at_end(line.bracket.1, parameters.upper[along]);
        if beyond && moved {
            // Twice as far each time: from anywhere in few searches.
            self.half_bracket[along] *= 2.0;
            return self.search(along);
        }
        if along + 1 < N {
            return self.search(along + 1);
        }
        // One parameter is done after one round.
        if N == 1 || !self.moved {
            return None;
        }
        self.moved = false;
        for half in &mut self.half_bracket {
            *half *= NARROWING;
        }
        let narrow = |half: &f32| *half <= 2.0 * self.parameters.tolerance;
        if self.half_bracket.iter().all(narrow) {
            return None;
        }
        self.search(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run<const N: usize>(
        parameters: Parameters<N>,
        seed: u64,
        cost: impl Fn([f32; N]) -> f32,
    ) -> Polished<N> {
        let mut search = parameters.build(seed).unwrap();
        while let Some(candidate) = search.propose() {
            let bounds = parameters.annealing.lower.iter();
            let bounds = bounds.zip(&parameters.annealing.upper);
            for ((lower, upper), value) in bounds.zip(&candidate) {
                assert!((lower..=upper).contains(&value));
            }
            assert_eq!(search.propose(), Some(candidate));
            search.report(cost(candidate));
        }
        search
    }

    fn line(evaluations: u32) -> Parameters<1> {
        Parameters {
            annealing: annealing::Parameters {
                evaluations,
                ..annealing::Parameters::new([0.01], [1.5], [0.12])
            },
            tolerance: 1e-4,
            half_bracket: [HALF_BRACKET],
            polish: 60,
        }
    }

    #[test]
    fn one_parameter_is_found_to_the_tolerance_with_every_seed() {
        for seed in 0..50 {
            for truth in [0.05, 0.12, 0.779, 1.4] {
                let search = run(line(82), seed, |[x]| (x - truth) * (x - truth));
                let ([found], _) = search.best().unwrap();
                assert!((found - truth).abs() < 3e-4, "{seed} {truth} {found}");
            }
        }
    }

    #[test]
    fn a_minimum_outside_the_first_bracket_is_followed() {
        // Three evaluations leave annealing anywhere.
        let search = run(line(3), 1, |[x]| (x - 0.9) * (x - 0.9));
        let ([found], _) = search.best().unwrap();
        assert!((found - 0.9).abs() < 3e-4, "{found}");
    }

    #[test]
    fn two_parameters_that_depend_on_each_other_are_found() {
        for seed in 0..20 {
            let parameters = Parameters {
                annealing: annealing::Parameters {
                    evaluations: 200,
                    ..annealing::Parameters::new([0.0, 0.0], [1.0, 1.0], [0.1, 0.1])
                },
                tolerance: 1e-4,
                half_bracket: [HALF_BRACKET; 2],
                polish: 400,
            };
            let search = run(parameters, seed, |[x, y]| {
                let (a, b) = (x - 0.6, y - 0.7);
                a * a + b * b + 0.8 * a * b
            });
            let ([x, y], _) = search.best().unwrap();
            assert!((x - 0.6).abs() < 2e-3 && (y - 0.7).abs() < 2e-3, "{x} {y}");
            assert!(search.polish_evaluations() <= 400);
        }
    }

    #[test]
    fn a_cost_that_is_never_finite_leaves_no_best() {
        let search = run(line(20), 1, |_| f32::NAN);
        assert_eq!(search.best(), None);
        assert_eq!(search.polish_evaluations(), 0);
    }

    #[test]
    fn what_is_out_of_range_is_refused() {
        for tolerance in [0.0, 0.1, f32::NAN] {
            let parameters = Parameters {
                tolerance,
                ..line(20)
            };
            assert_eq!(parameters.build(1).unwrap_err().name, "tolerance");
        }
        let parameters = Parameters {
            half_bracket: [2.0],
            ..line(20)
        };
        assert_eq!(parameters.build(1).unwrap_err().name, "half_bracket");
    }
}
