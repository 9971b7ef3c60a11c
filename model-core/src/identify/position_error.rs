//! The prognostics paper's objective: how far an actuator with a candidate friction is from a log.
//!
//! Eq. 5 of Dalla Vedova, Maggiore and Pace: the squared difference of simulated and measured
//! position, integrated over the log by the trapezoidal rule,
//!
//! ```text
//! E = Σ (e²ᵢ₊₁ + e²ᵢ)/2 · (tᵢ₊₁ − tᵢ)
//! ```
//!
//! The actuator is driven by the *measured* input: so a log from a closed loop needs no model of the
//! loop, and a log from an open one is the same. It runs freely over the whole log, as in the paper,
//! or in *windows*, each restarted from the smoothed measured state; then E is the sum over the
//! windows.
//!
//! Windows are the better choice where the log is sampled fast enough. A free run adds up every small fault
//! of the model, and once it has stuck where the machine slid it is lost for the rest of the log: E has
//! many minima, and the lowest need not be at the friction. In windows of 0.2 s E has one minimum. On
//! sweeps with 0.12 to 1.2 N·m at 1 kHz the largest error of the estimate falls from 9 % to 0.3 %
//! (`cargo hil reproduce prognostics`). A window is restarted from a state smoothed over 17 samples: at
//! 16 ms these are longer than the window, and the free run is the better choice.

use crate::gap::log::Log;
use crate::gap::replay::samples;
use crate::numeric::invalid_parameter::{InvalidParameter, require, require_positive};
use crate::plant::State;
use crate::plant::actuator::Actuator;
use crate::plant::parameters::Parameters;

/// Samples on either side of a restart that its state is smoothed over.
pub const HALF_WIDTH: usize = 8;

/// Levels of dry friction, N·m or N, the same in both directions.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Levels {
    /// While sliding.
    pub coulomb: f32,
    /// At breakaway. Below the Coulomb level it counts as that: no machine is stopped by the friction
    /// that it has just overcome.
    pub breakaway: f32,
}

/// E as a function of the friction.
///
/// ```
/// use model_core::gap::log::{Channel, Log};
/// use model_core::identify::position_error::{Levels, PositionError};
/// use model_core::plant::Directional;
/// use model_core::plant::parameters::{Drive, Parameters};
///
/// // 1 kg, pushed by 3 N against 1 N of friction: x = t².
/// let declared = Parameters {
///     coulomb: Directional::both(1.0),
///     breakaway: Directional::both(1.0),
///     ..Parameters::free(1.0)
/// };
/// let input = [3.0; 1017];
/// let position: [f32; 1017] = core::array::from_fn(|i| (i as f32 * 1e-3) * (i as f32 * 1e-3));
/// let (input, position) = (Channel::Values(&input), Channel::Values(&position));
/// let log = Log::new(1e-3, input, position);
///
/// let mut error = PositionError::new(&declared, &log, 0.0, None)?;
/// // 0.4 N more: after τ seconds 0.2 τ² behind, so E = 0.2²/5 after 1 s.
/// let levels = Levels { coulomb: 1.4, breakaway: 1.4 };
/// assert!((error.at(levels) / 0.008 - 1.0).abs() < 1e-3);
/// assert!(error.at(Levels { coulomb: 1.0, breakaway: 1.0 }) < 1e-9);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
#[derive(Debug, Clone)]
pub struct PositionError<'a> {
    log: Log<'a>,
    declared: Parameters,
    resolution: f32,
    /// Steps in a window.
    window: usize,
    windows: usize,
    actuator: Actuator,
}

impl<'a> PositionError<'a> {
    /// E on a log. `resolution` is the position sensor's, rad or m, 0 if unknown; `window` the length of
    /// the windows in s, `None` for a free run. What is left of the log after the last whole window
    /// does not take part.
    ///
    /// # Errors
    /// A parameter of the actuator outside its range, a window that is not positive, a log shorter
    /// than a window (`log`).
    pub fn new(
        declared: &Parameters,
        log: &Log<'a>,
        resolution: f32,
        window: Option<f32>,
    ) -> Result<Self, InvalidParameter> {
        let actuator = Actuator::build(declared, log.period).map_err(|error| InvalidParameter {
            name: error.parameter,
            requirement: error.requirement,
        })?;
        let steps = log.samples().saturating_sub(2 * HALF_WIDTH + 1);
        let window = match window {
            Some(seconds) => {
                require_positive(seconds, "window")?;
                samples(seconds, log.period, 1)
            }
            None => steps,
        };
        require(
            window > 0 && steps >= window,
            "log",
            "must be longer than a window",
        )?;
        Ok(Self {
            log: *log,
            declared: *declared,
            resolution,
            window,
            windows: steps / window,
            actuator,
        })
    }

    /// E of these levels, rad²·s or m²·s. Not finite where the log is not.
    pub fn at(&mut self, levels: Levels) -> f32 {
        let (mut total, mut within) = (0.0, 0.0f32);
        self.errors(levels, |error, weight| {
            within += weight * error * error;
            // The last of a window: in f64, so that the number of windows costs no digits.
            if weight < 1.0 {
                total += f64::from(within);
                within = 0.0;
            }
        });
        (total * f64::from(self.log.period)) as f32
    }

    /// Calls `each` with every error of the position, simulated minus measured, in rad or m, and
    /// with its weight in the trapezoidal rule: 1, and ½ at both ends of a window.
    pub fn errors(&mut self, levels: Levels, mut each: impl FnMut(f32, f32)) {
        let (log, last) = (&self.log, self.window);
        self.actuator.set_friction(levels.coulomb, levels.breakaway);
        for window in 0..self.windows {
            let start = HALF_WIDTH + window * last;
            let mut state = self.restart(start);
            each(state.position.from(log.position.at(start)), 0.5);
            for step in 1..=last {
                let input = log.input.at(start + step - 1);
                let error = match self.actuator.step(&mut state, input) {
                    Ok(_) => state.position.from(log.position.at(start + step)),
                    Err(_) => f32::NAN,
                };
                each(error, if step == last { 0.5 } else { 1.0 });
            }
        }
    }

    /// E of an actuator that does not move: what the others are measured by.
    pub fn at_rest(&self) -> f32 {
        let mut total = 0.0;
        for window in 0..self.windows {
            let start = HALF_WIDTH + window * self.window;
            let from = self.log.position.at(start);
            for step in 1..=self.window {
                let travel = f64::from(self.log.position.at(start + step) - from);
                let weight = if step == self.window { 0.5 } else { 1.0 };
                total += weight * travel * travel;
            }
        }
        (total * f64::from(self.log.period)) as f32
    }

    /// Steps that one evaluation simulates.
    pub fn steps(&self) -> usize {
        self.windows * self.window
    }

    /// Where the machine was. The current is the one that the winding settles on, within L/R: a
    /// measured one would bring the offset of its sensor in.
    fn restart(&self, start: usize) -> State {
        let mut state = self.log.smoothed_state(start, HALF_WIDTH, self.resolution);
        state.current = self
            .declared
            .steady_current(state.velocity.value(), self.log.input.at(start));
        state
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::log::Channel;
    use crate::plant::Directional;
    use crate::plant::parameters::Drive;

    const PERIOD: f32 = 1e-3;
    const SAMPLES: usize = 2017;

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

    const WORN: Levels = Levels {
        coulomb: 0.4,
        breakaway: 0.5,
    };

    /// The worn actuator, to and fro with rests between.
    fn record() -> ([f32; SAMPLES], [f32; SAMPLES]) {
        let mut actuator = Actuator::build(&DECLARED, PERIOD).unwrap();
        actuator.set_friction(WORN.coulomb, WORN.breakaway);
        let mut state = State::default();
        let (mut input, mut position) = ([0.0; SAMPLES], [0.0; SAMPLES]);
        for sample in 0..SAMPLES {
            let phase = sample % 500;
            // From standstill through the breakaway, back to standstill.
            let ramp = if phase < 400 {
                0.04 * phase as f32
            } else {
                0.0
            };
            input[sample] = if sample / 500 % 2 == 0 { ramp } else { -ramp };
            position[sample] = state.position.value();
            actuator.step(&mut state, input[sample]).unwrap();
        }
        (input, position)
    }

    fn with_error<R>(window: Option<f32>, run: impl FnOnce(PositionError) -> R) -> R {
        let (input, position) = record();
        let log = Log::new(PERIOD, Channel::Values(&input), Channel::Values(&position));
        run(PositionError::new(&DECLARED, &log, 0.0, window).unwrap())
    }

    #[test]
    fn both_levels_have_their_minimum_at_the_truth() {
        for window in [None, Some(0.2)] {
            with_error(window, |mut error| {
                let least = error.at(WORN);
                assert!(least < 1e-3 * error.at_rest(), "{least}");
                for factor in [0.8, 0.95, 1.05, 1.2] {
                    let coulomb = Levels {
                        coulomb: factor * WORN.coulomb,
                        ..WORN
                    };
                    let breakaway = Levels {
                        breakaway: factor * WORN.breakaway,
                        ..WORN
                    };
                    assert!(error.at(coulomb) > least, "{window:?} {factor}");
                    assert!(error.at(breakaway) > least, "{window:?} {factor}");
                }
            });
        }
    }

    #[test]
    fn a_breakaway_below_coulomb_friction_counts_as_that() {
        with_error(Some(0.2), |mut error| {
            let below = error.at(Levels {
                coulomb: 0.4,
                breakaway: 0.1,
            });
            let equal = error.at(Levels {
                coulomb: 0.4,
                breakaway: 0.4,
            });
            assert_eq!(below.to_bits(), equal.to_bits());
        });
    }

    #[test]
    fn a_model_that_sticks_has_the_error_of_one_at_rest() {
        with_error(None, |mut error| {
            let stuck = error.at(Levels {
                coulomb: 9.0,
                breakaway: 9.0,
            });
            assert!((stuck / error.at_rest() - 1.0).abs() < 1e-3);
            assert_eq!(error.steps(), 2000);
        });
    }

    #[test]
    fn what_cannot_be_replayed_is_refused() {
        let values = [0.0; 100];
        let log = Log::new(PERIOD, Channel::Values(&values), Channel::Values(&values));
        let name = |declared: &Parameters, window| {
            PositionError::new(declared, &log, 0.0, window)
                .unwrap_err()
                .name
        };
        assert_eq!(name(&DECLARED, Some(0.2)), "log");
        assert_eq!(name(&DECLARED, Some(-0.2)), "window");
        let heavy = Parameters {
            inertia: f32::NAN,
            ..DECLARED
        };
        assert_eq!(name(&heavy, None), "inertia");
    }
}
