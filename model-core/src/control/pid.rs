//! PID controller with set-point weights, filtered derivative, saturation and anti-windup.
//!
//! Terms: r the set point, y the measurement, u the output, v the output before saturation,
//! h the period. In continuous time, with parallel gains,
//!
//! ```text
//! v = K_p (b r − y) + K_i ∫ (r − y) dt + K_d s/(1 + T_f s) (c r − y),   u = sat(v)
//! ```
//!
//! (Åström and Murray, *Feedback Systems*, section 11.5). From the standard form, K_i = K_p/T_i and
//! K_d = K_p T_d. What is computed at tick k is exactly
//!
//! ```text
//! p_k     = K_p (b r_k − y_k)
//! d_k     = a d_(k−1) + g [(c r_k − y_k) − (c r_(k−1) − y_(k−1))],  a = T_f/(T_f + h), g = K_d/(T_f + h)
//! v_k     = p_k + i_k + d_k
//! u_k     = min(max(v_k, u_min), u_max)
//! i_(k+1) = i_k + h K_i (r_k − y_k) + w_k
//! ```
//!
//! The derivative is the backward Euler form of its filter, stable for every T_f ≥ 0. Before the
//! first tick r and y count as constant, so d_0 = 0 and the start does not kick. The integral is the
//! forward Euler form, advanced after the output, and summed with compensation: no error is too
//! small to be integrated. w_k is the anti-windup:
//!
//! | [`AntiWindup`] | w_k |
//! |---|---|
//! | `None` | 0 |
//! | `ConditionalIntegration` | −h K_i (r_k − y_k) while v_k lies beyond a limit and the error drives it further, else 0 |
//! | `BackCalculation` | (h/T_t) (u_k − v_k) |

use crate::numeric::invalid_parameter::{
    InvalidParameter, require, require_finite, require_positive,
};
use crate::numeric::sum::Sum;
use core::fmt;

/// What keeps the integral from growing while the output is saturated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AntiWindup {
    /// Nothing: the integral winds up.
    None,
    /// The integral stands while the output is saturated and the error would drive it further.
    #[default]
    ConditionalIntegration,
    /// The excess of the unsaturated output is fed back into the integral, which makes it forget
    /// the excess with a time constant. Also called tracking.
    BackCalculation {
        /// T_t in s, at least one period. Usual: between T_d and T_i of the standard form.
        tracking_time: f32,
    },
}

/// Gains, weights and limits. `Y` stands for the unit of the measurement, `U` for the output's.
///
/// ```
/// use model_core::control::pid::{AntiWindup, Parameters, State};
///
/// let pid = Parameters {
///     proportional: 2.0,
///     integral: 10.0,
///     output_minimum: -24.0,
///     output_maximum: 24.0,
///     anti_windup: AntiWindup::BackCalculation { tracking_time: 0.1 },
///     ..Parameters::default()
/// }
/// .build(0.001)?;
/// let mut state = State::default();
/// for _ in 0..100 {
///     pid.step(&mut state, 1.0, 0.0)?;
/// }
/// // Proportional action 2, and 0.1 s of an error of 1 through an integral gain of 10/s.
/// let output = pid.step(&mut state, 1.0, 0.0)?;
/// assert!((output - 3.0).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters {
    /// K_p in U/Y: finite, of either sign.
    pub proportional: f32,
    /// K_i in U/(Y s): finite.
    pub integral: f32,
    /// K_d in U s/Y: finite.
    pub derivative: f32,
    /// T_f in s: zero (no filter) or more. Usual: T_d/10 to T_d/3.
    pub derivative_filter_time: f32,
    /// b, without unit: 1 the error's proportional action, 0 none on the set point ("I-PD").
    pub set_point_weight: f32,
    /// c, without unit: 0 the derivative of the measurement alone, 1 that of the error.
    pub derivative_set_point_weight: f32,
    /// u_min in U: below the maximum.
    pub output_minimum: f32,
    /// u_max in U.
    pub output_maximum: f32,
    /// What holds the integral while the output is saturated.
    pub anti_windup: AntiWindup,
}

impl Default for Parameters {
    /// No action at all, b = 1, c = 0, limits that only overflow reaches, conditional integration.
    fn default() -> Self {
        Self {
            proportional: 0.0,
            integral: 0.0,
            derivative: 0.0,
            derivative_filter_time: 0.0,
            set_point_weight: 1.0,
            derivative_set_point_weight: 0.0,
            output_minimum: f32::MIN,
            output_maximum: f32::MAX,
            anti_windup: AntiWindup::default(),
        }
    }
}

impl Parameters {
    /// The difference equations for a `period` in s.
    pub fn build(self, period: f32) -> Result<Coefficients, InvalidParameter> {
        require_positive(period, "period")?;
        require_finite(self.proportional, "proportional")?;
        let integral = self.integral * period;
        require_finite(integral, "integral")?;
        require_finite(self.derivative, "derivative")?;
        let filter_time = self.derivative_filter_time;
        require(
            filter_time >= 0.0 && filter_time.is_finite(),
            "derivative_filter_time",
            "must be zero or positive, and finite",
        )?;
        require_finite(self.set_point_weight, "set_point_weight")?;
        require_finite(
            self.derivative_set_point_weight,
            "derivative_set_point_weight",
        )?;
        require_finite(self.output_minimum, "output_minimum")?;
        require_finite(self.output_maximum, "output_maximum")?;
        require(
            self.output_minimum < self.output_maximum,
            "output_minimum",
            "must lie below output_maximum",
        )?;
        let (conditional, tracking_gain) = match self.anti_windup {
            AntiWindup::None => (false, 0.0),
            AntiWindup::ConditionalIntegration => (true, 0.0),
            AntiWindup::BackCalculation { tracking_time } => {
                require(
                    tracking_time >= period && tracking_time.is_finite(),
                    "tracking_time",
                    "must be at least one period, and finite",
                )?;
                (false, period / tracking_time)
            }
        };
        let derivative_gain = self.derivative / (filter_time + period);
        require_finite(derivative_gain, "derivative")?;
        Ok(Coefficients {
            proportional: self.proportional,
            set_point_weight: self.set_point_weight,
            integral,
            derivative_set_point_weight: self.derivative_set_point_weight,
            derivative_decay: filter_time / (filter_time + period),
            derivative_gain,
            output_minimum: self.output_minimum,
            output_maximum: self.output_maximum,
            conditional,
            tracking_gain,
        })
    }
}

/// A controller for one period, ready to run: no division and no period in its step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Coefficients {
    proportional: f32,
    set_point_weight: f32,
    /// h K_i.
    integral: f32,
    derivative_set_point_weight: f32,
    /// a.
    derivative_decay: f32,
    /// g.
    derivative_gain: f32,
    output_minimum: f32,
    output_maximum: f32,
    conditional: bool,
    /// h/T_t, zero without back-calculation.
    tracking_gain: f32,
}

/// What the controller remembers from tick to tick. The default is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct State {
    /// i_(k+1).
    integral: Sum,
    /// c r − y of the last tick, none before the first.
    derivative_input: Option<f32>,
    terms: Terms,
}

impl State {
    /// The terms of the last output, so that they can be logged.
    pub fn terms(&self) -> Terms {
        self.terms
    }
}

/// What the last output is made of, each in the output's unit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Terms {
    /// p_k.
    pub proportional: f32,
    /// i_k.
    pub integral: f32,
    /// d_k.
    pub derivative: f32,
    /// v_k, their sum.
    pub unsaturated: f32,
    /// u_k.
    pub output: f32,
}

/// A step was refused; the state is what it was before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum NonFinite {
    /// The set point is NaN or infinite.
    SetPoint,
    /// The measurement is NaN or infinite.
    Measurement,
    /// The inputs are finite, but a term would leave the range of `f32`.
    Overflow,
}

impl fmt::Display for NonFinite {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::SetPoint => "the set point is not finite: hold the last one",
            Self::Measurement => "the measurement is not finite: check the sensor",
            Self::Overflow => "a term of the controller overflows: check gains and units",
        })
    }
}

impl core::error::Error for NonFinite {}

impl Coefficients {
    /// One tick: the output for this set point and measurement.
    ///
    /// An input that is NaN or infinite is refused and leaves every bit of the state as it was. The
    /// caller chooses what drives the actuator then; `state.terms().output` is the last output.
    #[inline]
    pub fn step(
        &self,
        state: &mut State,
        set_point: f32,
        measurement: f32,
    ) -> Result<f32, NonFinite> {
        let limits = [self.output_minimum, self.output_maximum];
        self.advance(state, set_point, measurement, true, limits)
    }

    /// As [`Coefficients::step`], with an output within `limits` too, the lower one first: those of this moment, of a supply
    /// or of a current. The anti-windup knows of them as of its own. Limits that are NaN do not count.
    ///
    /// # Errors
    /// As [`Coefficients::step`].
    #[inline]
    pub fn step_between(
        &self,
        state: &mut State,
        set_point: f32,
        measurement: f32,
        [lower, upper]: [f32; 2],
    ) -> Result<f32, NonFinite> {
        let limits = [
            self.output_minimum.max(lower),
            self.output_maximum.min(upper),
        ];
        self.advance(state, set_point, measurement, true, limits)
    }

    /// As [`Coefficients::step`], with the integral as it stands: for an anti-windup that looks at
    /// more than the output.
    ///
    /// # Errors
    /// As [`Coefficients::step`].
    #[inline]
    pub fn step_holding_integral(
        &self,
        state: &mut State,
        set_point: f32,
        measurement: f32,
    ) -> Result<f32, NonFinite> {
        let limits = [self.output_minimum, self.output_maximum];
        self.advance(state, set_point, measurement, false, limits)
    }

    #[inline(always)]
    fn advance(
        &self,
        state: &mut State,
        set_point: f32,
        measurement: f32,
        integrates: bool,
        [minimum, maximum]: [f32; 2],
    ) -> Result<f32, NonFinite> {
        let proportional = self.proportional * (self.set_point_weight * set_point - measurement);
        let derivative_input = self.derivative_set_point_weight * set_point - measurement;
        let derivative = self.derivative_decay * state.terms.derivative
            + self.derivative_gain
                * (derivative_input - state.derivative_input.unwrap_or(derivative_input));
        let unsaturated = proportional + state.integral.value() + derivative;

        let output = if unsaturated > maximum {
            maximum
        } else if unsaturated < minimum {
            minimum
        } else {
            unsaturated
        };
        let increment = self.integral * (set_point - measurement);
        let excess = unsaturated - output;
        let held = !integrates || (self.conditional && excess * increment > 0.0);
        let mut integral = state.integral;
        if !held {
            integral.add(increment - self.tracking_gain * excess);
        }

        // One look at the results finds a bad input too: x·0 is NaN for every non-finite x, so a
        // zero gain or weight does not hide it.
        let terms = Terms {
            proportional,
            integral: state.integral.value(),
            derivative,
            unsaturated,
            output,
        };
        if !(unsaturated.is_finite() && integral.value().is_finite()) {
            return Err(refusal(set_point, measurement));
        }
        *state = State {
            integral,
            derivative_input: Some(derivative_input),
            terms,
        };
        Ok(output)
    }
}

/// Why the results of a step were not finite.
#[cold]
fn refusal(set_point: f32, measurement: f32) -> NonFinite {
    if !measurement.is_finite() {
        NonFinite::Measurement
    } else if !set_point.is_finite() {
        NonFinite::SetPoint
    } else {
        NonFinite::Overflow
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f32 = 0.001;

    fn bounded(anti_windup: AntiWindup) -> Coefficients {
        Parameters {
            proportional: 1.0,
            integral: 20.0,
            output_minimum: -1.0,
            output_maximum: 1.0,
            anti_windup,
            ..Parameters::default()
        }
        .build(PERIOD)
        .unwrap()
    }

    /// Ticks until the output leaves its limit after the error turns from +1 to −0.1.
    fn recovery(anti_windup: AntiWindup) -> u32 {
        let pid = bounded(anti_windup);
        let mut state = State::default();
        for _ in 0..1000 {
            assert!(pid.step(&mut state, 1.0, 0.0).unwrap() <= 1.0);
        }
        assert_eq!(state.terms().output, 1.0);
        (0..)
            .find(|_| pid.step(&mut state, -0.1, 0.0).unwrap() < 1.0)
            .unwrap()
    }

    #[test]
    fn integral_of_a_step_is_a_ramp() {
        let pid = Parameters {
            integral: 3.0,
            ..Parameters::default()
        }
        .build(PERIOD)
        .unwrap();
        let mut state = State::default();
        for k in 0..10_000 {
            let output = pid.step(&mut state, 2.0, 0.5).unwrap();
            // i_k = k h K_i (r − y); the error of h K_i in f32 grows with k, rounding does not add up.
            let expected = k as f32 * (PERIOD * 3.0 * 1.5);
            assert!(
                (output - expected).abs() <= 2e-7 * expected,
                "{k}: {output}, {expected}"
            );
        }
    }

    #[test]
    fn integral_takes_increments_far_below_its_own_spacing() {
        let pid = Parameters {
            integral: 1.0,
            ..Parameters::default()
        }
        .build(1.0)
        .unwrap();
        let mut state = State::default();
        pid.step(&mut state, 1.0, 0.0).unwrap();
        for _ in 0..1 << 20 {
            pid.step(&mut state, 1.0 / 33_554_432.0, 0.0).unwrap();
        }
        assert_eq!(pid.step(&mut state, 0.0, 0.0).unwrap(), 1.0 + 1.0 / 32.0);
    }

    #[test]
    fn derivative_of_a_ramp_settles_as_its_filter_does() {
        let (gain, filter_time, slope) = (0.5, 0.01, -4.0);
        let pid = Parameters {
            derivative: gain,
            derivative_filter_time: filter_time,
            ..Parameters::default()
        }
        .build(PERIOD)
        .unwrap();
        let mut state = State::default();
        let decay = filter_time / (filter_time + PERIOD);
        let mut remaining = 1.0;
        for k in 0..200 {
            let output = pid
                .step(&mut state, 7.0, slope * PERIOD * k as f32)
                .unwrap();
            // Derivative on the measurement: d_k = −K_d·slope·(1 − a^k).
            let expected = -gain * slope * (1.0 - remaining);
            assert!(
                (output - expected).abs() < 1e-4,
                "{k}: {output}, {expected}"
            );
            remaining *= decay;
        }
        assert!((state.terms().derivative - 2.0).abs() < 1e-4);
    }

    #[test]
    fn weights_act_on_the_set_point_alone() {
        let parameters = Parameters {
            proportional: 2.0,
            derivative: 0.003,
            set_point_weight: 0.25,
            derivative_set_point_weight: 0.5,
            ..Parameters::default()
        };
        let pid = parameters.build(PERIOD).unwrap();
        let mut state = State::default();
        pid.step(&mut state, 0.0, 0.0).unwrap();
        pid.step(&mut state, 1.0, 0.0).unwrap();
        // K_p·b·1 and K_d·c·1/h.
        assert_eq!(state.terms().proportional, 0.5);
        assert!((state.terms().derivative - 1.5).abs() < 1e-6);
        pid.step(&mut state, 1.0, 1.0).unwrap();
        assert_eq!(state.terms().proportional, -1.5);
        assert!((state.terms().derivative + 3.0).abs() < 1e-6);
    }

    #[test]
    fn terms_add_up_to_the_output() {
        let pid = Parameters {
            proportional: 1.5,
            integral: 40.0,
            derivative: 0.01,
            derivative_filter_time: 0.002,
            output_minimum: -2.0,
            output_maximum: 2.0,
            ..Parameters::default()
        }
        .build(PERIOD)
        .unwrap();
        let mut state = State::default();
        let mut saturated = 0;
        for k in 0..500 {
            let output = pid
                .step(&mut state, if k % 100 < 50 { 1.0 } else { -1.0 }, 0.0)
                .unwrap();
            let terms = state.terms();
            assert_eq!(
                terms.unsaturated,
                terms.proportional + terms.integral + terms.derivative
            );
            assert_eq!(terms.output, output);
            assert!((-2.0..=2.0).contains(&output));
            saturated += u32::from(output != terms.unsaturated);
        }
        assert!(saturated > 100 && saturated < 500);
    }

    /// With K_p = 1, h K_i = 0.02, limits ±1 and 1000 ticks of an error of 1, then −0.1.
    #[test]
    fn recovery_from_saturation_takes_the_ticks_that_it_should() {
        // Wound up: i = 20, v = 19.9 − 0.002 k falls below 1 after (19.9 − 1)/0.002 = 9450 ticks.
        let wound_up = recovery(AntiWindup::None);
        assert!(wound_up.abs_diff(9450) <= 1, "{wound_up}");
        // Held at once (v = 1 at the first tick is not beyond the limit, so i = 0.02): v = −0.08.
        assert_eq!(recovery(AntiWindup::ConditionalIntegration), 0);
        // i settles where h K_i = (h/T_t)(v − 1): v = 1 + K_i T_t = 3, i = 2. Then v = i − 0.1 and
        // i ← i − 0.002 − 0.01 (v − 1), so v − 1 + 0.2 decays from 1.1 by 0.99 a tick; it passes
        // 0.2 after ln(1.1/0.2)/−ln 0.99 = 169.6 ticks.
        let tracked = recovery(AntiWindup::BackCalculation { tracking_time: 0.1 });
        assert_eq!(tracked, 170);
    }

    /// Limits of a moment act as the controller's own, and are forgotten with the moment.
    #[test]
    fn limits_of_a_moment_hold_output_and_integral_as_its_own_do() {
        for anti_windup in [
            AntiWindup::None,
            AntiWindup::ConditionalIntegration,
            AntiWindup::BackCalculation { tracking_time: 0.1 },
        ] {
            let narrow = bounded(anti_windup);
            let wide = Parameters {
                proportional: 1.0,
                integral: 20.0,
                output_minimum: -5.0,
                output_maximum: 5.0,
                anti_windup,
                ..Parameters::default()
            }
            .build(PERIOD)
            .unwrap();
            let [mut own, mut told] = [State::default(); 2];
            for k in 0..300 {
                let set_point = if k < 200 { 2.0 } else { -2.0 };
                let output = wide
                    .step_between(&mut told, set_point, 0.0, [-1.0, 1.0])
                    .unwrap();
                assert_eq!(output, narrow.step(&mut own, set_point, 0.0).unwrap());
                assert_eq!(told, own);
            }
            let free = wide.step_between(&mut told, -2.0, 0.0, [f32::NAN; 2]);
            assert_eq!(free, wide.step(&mut own, -2.0, 0.0));
            assert_eq!(told, own);
        }
    }

    #[test]
    fn anti_windup_does_nothing_within_the_limits() {
        let run = |anti_windup| {
            let pid = bounded(anti_windup);
            let mut state = State::default();
            core::array::from_fn::<u32, 40, _>(|k| {
                pid.step(&mut state, 0.2, 0.005 * k as f32)
                    .unwrap()
                    .to_bits()
            })
        };
        let plain = run(AntiWindup::None);
        assert_eq!(plain, run(AntiWindup::ConditionalIntegration));
        assert_eq!(
            plain,
            run(AntiWindup::BackCalculation { tracking_time: 0.1 })
        );
    }

    #[test]
    fn non_finite_inputs_leave_every_bit_of_the_state() {
        // Gains and weights of zero must not hide a bad input.
        for parameters in [
            Parameters {
                set_point_weight: 0.0,
                ..Parameters::default()
            },
            Parameters {
                proportional: 1.0,
                integral: 2.0,
                derivative: 0.1,
                derivative_filter_time: 0.01,
                derivative_set_point_weight: 1.0,
                anti_windup: AntiWindup::BackCalculation { tracking_time: 1.0 },
                ..Parameters::default()
            },
        ] {
            let pid = parameters.build(PERIOD).unwrap();
            for ticks in [0, 3] {
                let mut state = State::default();
                for k in 0..ticks {
                    pid.step(&mut state, 1.0, 0.1 * k as f32).unwrap();
                }
                let before = state;
                for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                    assert_eq!(pid.step(&mut state, bad, 0.0), Err(NonFinite::SetPoint));
                    assert_eq!(pid.step(&mut state, 0.0, bad), Err(NonFinite::Measurement));
                    assert_eq!(pid.step(&mut state, bad, bad), Err(NonFinite::Measurement));
                }
                // Equality of floats that are not NaN, none of them a signed zero in one only.
                assert_eq!(state, before);
                let mut undisturbed = before;
                assert_eq!(
                    pid.step(&mut state, 0.5, 0.25).unwrap().to_bits(),
                    pid.step(&mut undisturbed, 0.5, 0.25).unwrap().to_bits()
                );
            }
        }
    }

    #[test]
    fn overflow_is_refused() {
        let pid = Parameters {
            proportional: 10.0,
            ..Parameters::default()
        }
        .build(PERIOD)
        .unwrap();
        let mut state = State::default();
        assert_eq!(
            pid.step(&mut state, f32::MAX, 0.0),
            Err(NonFinite::Overflow)
        );
        assert_eq!(state, State::default());
    }

    #[test]
    fn bad_parameters_are_named() {
        let good = Parameters::default();
        let name = |parameters: Parameters| parameters.build(PERIOD).unwrap_err().name;
        assert_eq!(
            name(Parameters {
                proportional: f32::NAN,
                ..good
            }),
            "proportional"
        );
        assert_eq!(
            name(Parameters {
                integral: f32::INFINITY,
                ..good
            }),
            "integral"
        );
        assert_eq!(
            name(Parameters {
                derivative: 1e38,
                ..good
            }),
            "derivative"
        );
        assert_eq!(
            name(Parameters {
                derivative_filter_time: -1.0,
                ..good
            }),
            "derivative_filter_time"
        );
        assert_eq!(
            name(Parameters {
                output_minimum: 1.0,
                output_maximum: 1.0,
                ..good
            }),
            "output_minimum"
        );
        let anti_windup = AntiWindup::BackCalculation {
            tracking_time: 0.5 * PERIOD,
        };
        assert_eq!(
            name(Parameters {
                anti_windup,
                ..good
            }),
            "tracking_time"
        );
        for period in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert_eq!(good.build(period).unwrap_err().name, "period");
        }
    }
}
