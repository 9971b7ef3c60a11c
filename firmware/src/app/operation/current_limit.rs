//! The motor's current kept within a range, in every mode: the voltage is bounded, tick by tick, so that the current
//! does not leave it.
//!
//! The winding obeys u = R i + L di/dt + e. What it takes beyond its declared resistance and inductance, e, is
//! its back-EMF and whatever is wrong with the declared numbers. A first-order observer with the time constant *T* follows
//! it from the voltage that stood at the winding and the current that came of it,
//!
//! ê ← ê + (h/T)(u − R (i₀ + i₁)/2 − L (i₁ − i₀)/h − ê),
//!
//! and the voltage that brings the current to the limit *I* with the time constant *τ* is
//!
//! u = ê + R I + (L/τ)(I − i).
//!
//! That is a loop of proportional and integral action whose integral, ê, follows the voltage as it was
//! applied: it cannot wind up while something else drives, and it takes over without a bump. At rest
//! u = R i + ê, hence (R + L/τ)(I − i) = 0: the current is the limit itself, whatever resistance,
//! inductance and back-EMF are in truth. Neither the encoder nor the torque constant is asked, so that a failed encoder
//! does not take the limit away.
//!
//! It steps with the bridge's timer: a control period is one time constant of the winding, in which a
//! resistance that is a third less lets the current rise by a third before it is measured again.
//!
//! # The two time constants
//! A voltage acts up to a tick later than the current it follows from was measured, and is held for another:
//! a dead time of 1.5 h in the mean. The magnitude optimum, τ twice the dead time, is 3 h; an inductance that is 30 % less
//! raises the loop's gain to 1/0.7 of that, hence τ = 4 h.
//!
//! With the true winding R′, L′ the loop has the characteristic polynomial
//!
//! L′ T s² + (L + T (R′ + L/τ)) s + R + L/τ,
//!
//! stable for every R′ and L′ above 0. It has no overshoot if (L + T G)² ≥ 4 L′ T G with G = R + L/τ,
//! which for an inductance L′ of up to 1.3 L wants T G ≥ 2.85 L: T = 3 τ.

use crate::app::timing::PLANT_PERIOD;

/// τ in periods.
const PERIODS: f32 = 4.0;

/// T in τ.
const OBSERVER: f32 = 3.0;

/// The limiter's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    resistance: f32,
    /// L/h.
    inductance: f32,
    /// L/τ.
    proportional: f32,
    /// h/T.
    gain: f32,
}

/// What it remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// ê, V.
    observed: f32,
    /// The last current, A, with the bridge driven.
    current: Option<f32>,
}

impl State {
    /// What the winding takes beyond its declared resistance and inductance, V.
    pub fn observed(&self) -> f32 {
        self.observed
    }
}

impl Coefficients {
    /// For a winding of this resistance, Ω, and inductance, H.
    pub fn new(resistance: f32, inductance: f32) -> Self {
        Self::of_loop(resistance, inductance, PLANT_PERIOD, PERIODS)
    }

    /// For anything that obeys the same equation, with steps of `period`, s, and τ of so many periods.
    pub(super) fn of_loop(resistance: f32, inductance: f32, period: f32, periods: f32) -> Self {
        Self {
            resistance,
            inductance: inductance / period,
            proportional: inductance / (periods * period),
            gain: 1.0 / (OBSERVER * periods),
        }
    }

    /// Takes a current, A, and the voltage, V, that stood at the winding for the tick before it, none with the
    /// bridge off: the least and the most voltage, V, with which the current stays in, or comes back
    /// to, this range, A, the least first.
    pub fn step(
        &self,
        state: &mut State,
        current: f32,
        voltage: Option<f32>,
        range: [f32; 2],
    ) -> [f32; 2] {
        match (voltage, state.current) {
            (Some(voltage), Some(before)) => {
                let residual = voltage
                    - self.resistance * 0.5 * (before + current)
                    - self.inductance * (current - before);
                state.observed += self.gain * (residual - state.observed);
            }
            // A winding that is let go tells nothing.
            (None, _) => state.observed = 0.0,
            (Some(_), None) => {}
        }
        state.current = voltage.map(|_| current);
        range.map(|limit| {
            state.observed + self.resistance * limit + self.proportional * (limit - current)
        })
    }
}
