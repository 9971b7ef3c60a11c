//! The encoder against the winding: a motor that turns says so in its back-EMF.
//!
//! Kirchhoff's law of the winding is u = R i + L di/dt + k ω. The current is measured as its mean over a control
//! period *h*, as the voltage is told and the encoder's way taken over one. The law's mean over a period that
//! slides from the last one to this, 0 to 1, is
//!
//! (u₀ + u₁)/2 = R (i₀ + i₁)/2 + L (i₁ − i₀)/h + k (Δθ₀ + Δθ₁)/2h,
//!
//! in which no measurement is differentiated. What is left of it, e, is 0 V for exact numbers and a motion
//! whose rates are even. For numbers within their tolerances and a current and a speed that are monotone it
//! stays below
//!
//! b = δu + δR R |i₀ + i₁|/2 + R |i₁ − i₀|/2 + δL L |i₁ − i₀|/h
//!   + (δk k |Δθ₀ + Δθ₁| + k |Δθ₁ − Δθ₀|)/2h + l |u₁ − u₀|/h + (s₀ + s₁)/8,
//!
//! whose third and sixth terms are the trapezoidal rule's worst, and whose seventh one is that of a voltage that acts
//! by *l* later than it was told. Where the current is limited the voltage changes within a period, by *s*: the period
//! that slides weighs a triangle's half, which is off from the mean by a quarter in all, of at most s/2. Both go through one first-order filter with the time constant *τ*. Its
//! response is positive, so |e| ≤ b in every period keeps the filtered |E| below the filtered B. Reading in steps
//! of *r* rad is wrong by half a step at most however long it moves, which the filter makes k r/τ of; twice that
//! covers what it hides of b too. Hence |E| > B + 2 k r/τ means that the encoder, the current sensor or
//! one of the declared tolerances is wrong: no debounce, no number that was tried out.
//!
//! What is off for good need not be borne twice. Declared numbers that are wrong are wrong by the same amount from one moment to
//! the next, so of e less its own mean over the time constant *T*, which D is after the filter, the tolerances of R and k leave
//! no more than they leave of the current and the speed less theirs:
//!
//! |D| ≤ δR R |I − Ī| + δk k |Ω − Ω̄| + N + N̄ + what the voltage between told and winding changes by,
//!
//! with the other terms of b as N. That voltage has the current's sign, and lies between 0 and δu: while the
//! current keeps its sign it changes by δu at most. The winding's own resistance changes too, by its copper's temperature: by
//! 0.39 %/K · 20 K/s · T in the mean, 0.8 % of R |i|, which N has. So a current sensor that is stuck, whose reading has
//! no change, is found once the voltage that the true current takes changes by little more than δu, whatever the reading is.
//!
//! A motor at ω whose encoder claims ω' is found within three time constants from where
//! k |ω − ω'| exceeds δu + δR R |i| + δk k |ω'|. A motor that is held tells the winding nothing about its
//! encoder: what ends that is the monitor of its [torque](super::following), and where it is held by an
//! end stop that it may be at, [`Fault::Overload`].

use model_core::numeric::invalid_parameter::InvalidParameter;
use model_core::plant::parameters::{Drive, Parameters};

use super::Fault;
use super::observer::{Reading, TIME_CONSTANT, Tolerances, check_encoder};
use crate::app::operation::current_offset;
use crate::app::timing::PLANT_PERIOD;

/// How much later than told a voltage acts at most, s: the bridge's timer takes it over with the second tick.
const LATENCY: f32 = 2.0 * PLANT_PERIOD;

/// T, s: 25 τ, so that what fails is compared with what was before, and short enough for a winding to stay as warm as it is.
const MEMORY: f32 = 0.1;

/// By which share of it a resistance differs from its mean over [`MEMORY`].
const DRIFT: f32 = 0.0039 * 20.0 * MEMORY;

/// Of a current whose sign is known, A: more than what the sensor's zero may be off by.
const SIGNED: f32 = current_offset::MOST;

/// The observer's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    resistance: f32,
    /// L/h.
    inductance: f32,
    /// k/h.
    back_emf: f32,
    tolerances: Tolerances,
    /// 2 k r/τ, V.
    quantisation: f32,
    /// l/h.
    latency: f32,
    /// h/τ.
    gain: f32,
    /// h/T.
    memory: f32,
}

/// What the difference from before is judged by, filtered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Signals {
    /// e, V.
    residual: f32,
    /// R i, V.
    ohmic: f32,
    /// k ω by the encoder, V.
    claimed: f32,
    /// N, V.
    rest: f32,
    /// How often the current may have been above 0, and below, 0 to 1.
    signs: [f32; 2],
}

impl Signals {
    fn follow(&mut self, other: &Self, gain: f32) {
        let follow = |value: &mut f32, other: f32| *value += gain * (other - *value);
        follow(&mut self.residual, other.residual);
        follow(&mut self.ohmic, other.ohmic);
        follow(&mut self.claimed, other.claimed);
        follow(&mut self.rest, other.rest);
        for (sign, other) in self.signs.iter_mut().zip(other.signs) {
            follow(sign, other);
        }
    }
}

/// What is remembered of a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Before {
    position: f32,
    current: f32,
    /// The period that it ended, as far as the bridge drove.
    period: Option<Period>,
}

/// A period in which the bridge drove.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Period {
    /// Mean voltage, V.
    voltage: f32,
    /// Most less least voltage, V.
    spread: f32,
    /// The encoder's way.
    moved: f32,
}

/// What the observer remembers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    before: Option<Before>,
    /// E, and what it is made of.
    now: Signals,
    /// Their mean before.
    mean: Signals,
    /// B, V.
    bound: f32,
    /// Filtered magnitude of what the encoder claims, k |Δθ₀ + Δθ₁|/2h, V.
    claimed: f32,
}

impl Coefficients {
    /// For an actuator, an encoder with steps of `resolution`, rad or m, and a control period, s.
    /// Lost motion between motor and encoder adds to the resolution.
    ///
    /// # Errors
    /// The drive is no voltage, or a number is out of its range.
    pub fn new(
        plant: &Parameters,
        tolerances: Tolerances,
        resolution: f32,
        period: f32,
    ) -> Result<Self, InvalidParameter> {
        let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = plant.drive
        else {
            return Err(InvalidParameter {
                name: "drive",
                requirement: "must be a voltage",
            });
        };
        check_encoder(resolution, period)?;
        tolerances.check()?;
        Ok(Self {
            resistance,
            inductance: inductance / period,
            back_emf: torque_constant / period,
            tolerances,
            quantisation: 2.0 * torque_constant * resolution / TIME_CONSTANT,
            latency: LATENCY / period,
            gain: period / TIME_CONSTANT,
            memory: period / MEMORY,
        })
    }

    /// Takes a reading: [`Fault::EncoderLost`] or [`Fault::EncoderImplausible`] as long as the encoder
    /// is not to be believed. A reading that is not finite is none, and the observer begins anew; so it
    /// does with the bridge off.
    pub fn step(&self, state: &mut State, reading: &Reading) -> Option<Fault> {
        let &Reading {
            position,
            current,
            spread,
            ..
        } = reading;
        let finite = position.is_finite() && current.is_finite() && spread.is_finite();
        let mut now = Before {
            position,
            current,
            period: None,
        };
        let voltage = reading.voltage.filter(|volts| volts.is_finite() && finite);
        let (Some(voltage), Some(before)) = (voltage, state.before) else {
            *state = State {
                before: finite.then_some(now),
                ..State::default()
            };
            return None;
        };
        let moved = position - before.position;
        now.period = Some(Period {
            voltage,
            spread,
            moved,
        });
        state.before = Some(now);
        let Period {
            voltage: voltage_before,
            spread: spread_before,
            moved: moved_before,
        } = before.period?;
        let mean = |before: f32, now: f32| 0.5 * (before + now);
        let mean_current = mean(before.current, current);
        let change = current - before.current;
        let claimed = self.back_emf * mean(moved_before, moved);
        let residual = mean(voltage_before, voltage)
            - self.resistance * mean_current
            - self.inductance * change
            - claimed;
        let ohmic = self.resistance * mean_current;
        let rest = (0.5 * self.resistance + self.tolerances.inductance * self.inductance)
            * change.abs()
            + 0.5 * self.back_emf * (moved - moved_before).abs()
            + self.latency * (voltage - voltage_before).abs()
            + 0.125 * (spread_before + spread);
        let bound = self.tolerances.voltage
            + self.tolerances.resistance * ohmic.abs()
            + self.tolerances.torque_constant * claimed.abs()
            + rest;
        let signals = Signals {
            residual,
            ohmic,
            claimed,
            rest: rest + DRIFT * ohmic.abs(),
            signs: [mean_current > -SIGNED, mean_current < SIGNED]
                .map(|may| f32::from(u8::from(may))),
        };
        state.now.follow(&signals, self.gain);
        state.mean.follow(&state.now, self.memory);
        state.bound += self.gain * (bound - state.bound);
        state.claimed += self.gain * (claimed.abs() - state.claimed);
        let within = state.now.residual.abs() <= state.bound + self.quantisation;
        if within && self.is_as_before(state) {
            None
        } else if state.claimed <= self.quantisation {
            Some(Fault::EncoderLost)
        } else {
            Some(Fault::EncoderImplausible)
        }
    }

    /// Whether what is left of the balance differs from its mean by no more than the tolerances let it.
    fn is_as_before(&self, state: &State) -> bool {
        let State { now, mean, .. } = state;
        let Tolerances {
            resistance,
            torque_constant,
            voltage,
            ..
        } = self.tolerances;
        let most = resistance * (now.ohmic - mean.ohmic).abs()
            + torque_constant * (now.claimed - mean.claimed).abs()
            + now.rest
            + mean.rest
            + 2.0 * self.quantisation;
        // What is lost with a current above 0 is a drop, below 0 it is negative.
        let difference = now.residual - mean.residual;
        let [above, below] = now.signs;
        let [above_before, below_before] = mean.signs;
        difference <= most + voltage * (above + below_before)
            && -difference <= most + voltage * (below + above_before)
    }
}
