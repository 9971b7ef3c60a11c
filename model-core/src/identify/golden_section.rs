//! Golden-section search: the minimum of a unimodal cost of one parameter, between bounds.

use crate::numeric::invalid_parameter::{InvalidParameter, require, require_finite};

/// 1/φ = (√5 − 1)/2.
const GOLDEN_RATIO: f32 = 0.618_034;

/// Where to search and when to stop. The bounds have the parameter's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// Lower bound.
    pub lower: f32,
    /// Upper bound.
    pub upper: f32,
    /// Stop when the minimum is known to this width: positive, in the parameter's unit. A cost that
    /// is quadratic around its minimum is flat to `f32` within some 3e-4 of the scale on which it
    /// doubles; a smaller tolerance costs evaluations and gains nothing.
    pub tolerance: f32,
    /// Stop after this many evaluations at the latest: at least one.
    pub evaluations: u32,
}

impl Parameters {
    /// A search that has not begun.
    pub fn build(self) -> Result<GoldenSection, InvalidParameter> {
        require_finite(self.lower, "lower")?;
        require_finite(self.upper, "upper")?;
        let width = self.upper - self.lower;
        require(
            width > 0.0 && width.is_finite(),
            "upper",
            "must lie above lower, within f32",
        )?;
        require(self.tolerance > 0.0, "tolerance", "must be positive")?;
        require(self.evaluations > 0, "evaluations", "must be at least one")?;
        Ok(GoldenSection {
            lower: self.lower,
            upper: self.upper,
            tolerance: self.tolerance,
            left: Probe::between(self.upper, self.lower),
            right: Probe::between(self.lower, self.upper),
            limit: self.evaluations,
            evaluations: 0,
            best: None,
        })
    }
}

/// An inner point of the bracket.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Probe {
    at: f32,
    cost: Option<f32>,
}

impl Probe {
    /// The golden section of the way `from` one end `to` the other, not evaluated yet.
    fn between(from: f32, to: f32) -> Self {
        Self {
            at: from + GOLDEN_RATIO * (to - from),
            cost: None,
        }
    }
}

/// A search under way: Kiefer, *Sequential minimax search for a maximum*, Proc. Amer. Math. Soc. 4,
/// 1953.
///
/// The bracket starts as the bounds and shrinks to 0.618 of itself with every evaluation after the
/// first, so n evaluations leave 0.618ⁿ⁻¹ of it: twelve leave 0.5 %. Of a cost with several minima
/// it finds one. A cost that is not finite counts as larger than any other.
///
/// ```
/// use model_core::identify::golden_section::Parameters;
///
/// let mut search =
///     Parameters { lower: 0.0, upper: 1.0, tolerance: 0.01, evaluations: 50 }.build()?;
/// while let Some(candidate) = search.propose() {
///     search.report((candidate - 0.3) * (candidate - 0.3));
/// }
/// let (parameter, _cost) = search.best().unwrap();
/// assert!((parameter - 0.3).abs() < 0.01);
/// assert_eq!(search.evaluations(), 11);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GoldenSection {
    lower: f32,
    upper: f32,
    tolerance: f32,
    left: Probe,
    right: Probe,
    limit: u32,
    evaluations: u32,
    best: Option<(f32, f32)>,
}

impl GoldenSection {
    /// The parameter whose cost is wanted next, the same until it is reported; `None` when done.
    pub fn propose(&self) -> Option<f32> {
        // Rounding ends the search too: points that f32 cannot tell apart have nothing between them.
        let resolved =
            self.lower < self.left.at && self.left.at < self.right.at && self.right.at < self.upper;
        let done = self.evaluations >= self.limit
            || self.upper - self.lower <= self.tolerance
            || !resolved;
        (!done).then_some(if self.left.cost.is_none() {
            self.left.at
        } else {
            self.right.at
        })
    }

    /// The cost of what was proposed. Ignored when the search is done.
    pub fn report(&mut self, cost: f32) {
        let Some(candidate) = self.propose() else {
            return;
        };
        self.evaluations += 1;
        let cost = if cost.is_finite() {
            cost
        } else {
            f32::INFINITY
        };
        if cost < self.best.map_or(f32::INFINITY, |(_, best)| best) {
            self.best = Some((candidate, cost));
        }
        let (left, right) = match (self.left.cost, self.right.cost) {
            (None, None) => {
                self.left.cost = Some(cost);
                return;
            }
            (None, Some(right)) => {
                self.left.cost = Some(cost);
                (cost, right)
            }
            (Some(left), _) => {
                self.right.cost = Some(cost);
                (left, cost)
            }
        };
        if left <= right {
            self.upper = self.right.at;
            self.right = self.left;
            self.left = Probe::between(self.upper, self.lower);
        } else {
            self.lower = self.left.at;
            self.left = self.right;
            self.right = Probe::between(self.lower, self.upper);
        }
    }

    /// The best parameter so far and its cost; `None` before a finite cost.
    pub fn best(&self) -> Option<(f32, f32)> {
        self.best
    }

    /// The bounds between which the minimum of a unimodal cost lies.
    pub fn bracket(&self) -> (f32, f32) {
        (self.lower, self.upper)
    }

    /// Number of costs reported.
    pub fn evaluations(&self) -> u32 {
        self.evaluations
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn search(parameters: Parameters, cost: impl Fn(f32) -> f32) -> GoldenSection {
        let mut search = parameters.build().unwrap();
        while let Some(candidate) = search.propose() {
            assert!((parameters.lower..=parameters.upper).contains(&candidate));
            assert_eq!(search.propose(), Some(candidate));
            search.report(cost(candidate));
        }
        search
    }

    const UNIT: Parameters = Parameters {
        lower: 0.0,
        upper: 1.0,
        tolerance: 1e-3,
        evaluations: 100,
    };

    #[test]
    fn finds_every_place_of_the_minimum_in_the_evaluations_of_the_formula() {
        // 0.618^(n − 1) ≤ 1e-3 needs n = 16.
        for k in 0..=100 {
            let minimum = k as f32 / 100.0;
            let search = search(UNIT, |x| (x - minimum).abs());
            assert_eq!(search.evaluations(), 16);
            assert!(
                (search.best().unwrap().0 - minimum).abs() <= 1e-3,
                "{minimum}"
            );
            let (lower, upper) = search.bracket();
            assert!(lower <= minimum && minimum <= upper);
        }
    }

    #[test]
    fn stops_at_the_limit_and_at_the_resolution_of_f32() {
        assert_eq!(
            search(
                Parameters {
                    evaluations: 5,
                    ..UNIT
                },
                |x| x
            )
            .evaluations(),
            5
        );
        let exact = search(
            Parameters {
                tolerance: 1e-30,
                ..UNIT
            },
            |x| (x - 0.7).abs(),
        );
        assert!((exact.best().unwrap().0 - 0.7).abs() < 5e-7);
        assert!(exact.evaluations() < 50);
    }

    #[test]
    fn avoids_costs_that_are_not_finite() {
        let search = search(UNIT, |x| if x > 0.5 { f32::NAN } else { -x });
        assert!((search.best().unwrap().0 - 0.5).abs() < 1e-3);
        let mut nothing = Parameters {
            evaluations: 1,
            ..UNIT
        }
        .build()
        .unwrap();
        nothing.report(f32::NAN);
        assert_eq!((nothing.best(), nothing.propose()), (None, None));
        nothing.report(1.0);
        assert_eq!((nothing.best(), nothing.evaluations()), (None, 1));
    }

    #[test]
    fn bad_parameters_are_named() {
        let name = |parameters: Parameters| parameters.build().unwrap_err().name;
        assert_eq!(
            name(Parameters {
                lower: f32::NAN,
                ..UNIT
            }),
            "lower"
        );
        assert_eq!(name(Parameters { upper: 0.0, ..UNIT }), "upper");
        assert_eq!(
            name(Parameters {
                lower: f32::MIN,
                upper: f32::MAX,
                ..UNIT
            }),
            "upper"
        );
        assert_eq!(
            name(Parameters {
                tolerance: f32::NAN,
                ..UNIT
            }),
            "tolerance"
        );
        assert_eq!(
            name(Parameters {
                evaluations: 0,
                ..UNIT
            }),
            "evaluations"
        );
    }
}
