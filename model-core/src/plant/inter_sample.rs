//! A piecewise affine model between its samples.
//!
//! The model knows the position once a period, from the mean of the input over it. A simulation that
//! runs along with other things asks more often, and cannot look ahead. So in a period the position
//! lies on the line from the last sample to the one at which the model would arrive if the rest of the
//! period had the mean input of the part that is over. Where the input is held this is the straight
//! line between two samples; at the end of a period it is the model's sample whatever the input was.

use super::InputRefused;
use super::actuator::INPUT_LIMIT;
use super::piecewise_affine::{PiecewiseAffine, State};
use crate::numeric::invalid_parameter::{InvalidParameter, require};

/// Most ticks in a period of a model: so many are counted exactly in `f32`.
const MOST_TICKS: u32 = 1 << 20;

/// A model that is asked for its position at every tick of a shorter period.
///
/// ```
/// use model_core::plant::inter_sample::InterSample;
/// use model_core::plant::piecewise_affine::{Affine, Cell, Parameters, PiecewiseAffine};
///
/// // 0.01 rad a volt and period.
/// let growth = Affine { input: 0.01, ..Affine::default() };
/// let model = PiecewiseAffine::build(Parameters {
///     period: 0.01,
///     lower_limit: 0.0,
///     upper_limit: 1.5,
///     cells: [Cell { growth, ..Cell::default() }].into_iter().collect(),
/// })?;
/// let mut ticking = InterSample::new(model, 0.5, 0.0025)?;
/// for expected in [0.51, 0.52, 0.53, 0.54, 0.55] {
///     assert!((ticking.tick(4.0)? - expected).abs() < 1e-6);
/// }
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct InterSample {
    model: PiecewiseAffine,
    /// At the last sample.
    sample: State,
    /// Ticks in a period.
    ticks: u32,
    /// Ticks since the last sample, and the sum of their inputs.
    ticked: u32,
    sum: f32,
    position: f32,
}

impl InterSample {
    /// At rest at a position, at the nearer limit if it is beyond one; with a tick every `period` s.
    ///
    /// # Errors
    /// A position that is not finite; a period of which the model's is no multiple.
    pub fn new(model: PiecewiseAffine, start: f32, period: f32) -> Result<Self, InvalidParameter> {
        let requirement = "must go a whole number of times into the model's period";
        let ratio = model.parameters().period / period;
        // A NaN fails the comparison.
        let countable = (0.5..=MOST_TICKS as f32).contains(&ratio);
        require(countable, "period", requirement)?;
        let ticks = (ratio + 0.5) as u32;
        let difference = ratio - ticks as f32;
        require(difference.abs() <= 1e-3 * ratio, "period", requirement)?;
        let sample = model.rest(start).map_err(|InputRefused| InvalidParameter {
            name: "start",
            requirement: "must be finite",
        })?;
        Ok(Self {
            position: sample.position(),
            model,
            sample,
            ticks,
            ticked: 0,
            sum: 0.0,
        })
    }

    /// Position, rad or m.
    #[inline]
    pub fn position(&self) -> f32 {
        self.position
    }

    /// Advances by a tick in which the input is held, and returns the position.
    ///
    /// # Errors
    /// An input that is not finite or beyond [`INPUT_LIMIT`]; nothing is changed.
    #[inline]
    pub fn tick(&mut self, input: f32) -> Result<f32, InputRefused> {
        let taken = input.abs() <= INPUT_LIMIT;
        if !taken {
            return Err(InputRefused);
        }
        let (sum, ticked) = (self.sum + input, self.ticked + 1);
        let mut next = self.sample;
        let arrival = self.model.step(&mut next, sum / ticked as f32)?;
        if ticked == self.ticks {
            self.sample = next;
            (self.sum, self.ticked) = (0.0, 0);
            self.position = arrival;
        } else {
            (self.sum, self.ticked) = (sum, ticked);
            let part = ticked as f32 / self.ticks as f32;
            let start = self.sample.position();
            self.position = start + part * (arrival - start);
        }
        Ok(self.position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Random;
    use crate::plant::piecewise_affine::{Affine, Cell, Parameters};

    const TICKS: u32 = 8;

    fn model() -> PiecewiseAffine {
        let rising = Affine {
            change: 0.5,
            input: 0.25,
            ..Affine::default()
        };
        let falling = Affine {
            change: 0.25,
            input: 0.125,
            ..Affine::default()
        };
        let by_input = |input| Affine {
            input,
            ..Affine::default()
        };
        let cells = [(1.0, rising), (-1.0, falling)].map(|(sign, growth)| Cell {
            region: by_input(sign),
            growth,
        });
        PiecewiseAffine::build(Parameters {
            period: 0.01,
            lower_limit: -4.0,
            upper_limit: 4.0,
            cells: cells.into_iter().collect(),
        })
        .unwrap()
    }

    fn ticking() -> InterSample {
        InterSample::new(model(), 0.5, 0.01 / TICKS as f32).unwrap()
    }

    #[test]
    fn every_period_ends_at_the_models_sample() {
        let (model, mut ticking) = (model(), ticking());
        let mut state = model.rest(0.5).unwrap();
        let mut random = Random::new(5, 0);
        for _ in 0..200 {
            let mut sum = 0.0;
            for _ in 0..TICKS {
                let input = 2.0 * random.uniform() - 1.0;
                sum += input;
                let position = ticking.tick(input).unwrap();
                assert!((-4.0..=4.0).contains(&position));
            }
            let sample = model.step(&mut state, sum / TICKS as f32).unwrap();
            assert_eq!(ticking.position(), sample);
        }
    }

    #[test]
    fn a_step_of_the_input_within_a_period_acts_at_once() {
        let mut ticking = ticking();
        // Half of a period without input: at rest, as a cell without a constant is.
        for _ in 0..TICKS / 2 {
            assert_eq!(ticking.tick(0.0), Ok(0.5));
        }
        // Then 2 V: the mean is 0.4 V after one tick of five, and the growth 0.1 rad a period.
        let position = ticking.tick(2.0).unwrap();
        assert!((position - (0.5 + 5.0 / 8.0 * 0.1)).abs() < 1e-6);
        for _ in TICKS / 2 + 1..TICKS {
            ticking.tick(2.0).unwrap();
        }
        assert!((ticking.position() - 0.75).abs() < 1e-6);
    }

    #[test]
    fn what_is_no_input_is_refused_and_changes_nothing() {
        let mut ticking = ticking();
        ticking.tick(1.0).unwrap();
        let before = ticking.clone();
        for input in [f32::NAN, f32::INFINITY, -2e6] {
            assert_eq!(ticking.tick(input), Err(InputRefused));
            assert_eq!(ticking, before);
        }
    }

    #[test]
    fn periods_that_do_not_fit_are_refused_by_name() {
        for period in [0.0, -0.001, f32::NAN, 0.003, 0.02, 1e-9] {
            let error = InterSample::new(model(), 0.0, period).unwrap_err();
            assert_eq!(error.name, "period", "{period}");
        }
        let error = InterSample::new(model(), f32::NAN, 0.001).unwrap_err();
        assert_eq!(error.name, "start");
    }
}
