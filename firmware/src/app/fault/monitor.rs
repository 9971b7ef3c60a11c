//! What the measurements of a control step say about the drive: which conditions hold now.
//!
//! Pure functions of what was measured and of a few remembered numbers. A number that is not finite
//! counts as out of every limit. What comes out goes to [`Latch::watch`](super::latch::Latch::watch).

use model_core::numeric::invalid_parameter::InvalidParameter;

use super::observer::Reading;
use super::{Fault, Faults};
use super::{back_emf, following, overload};
use crate::app::debounce::Debounce;

/// The current that is let flow at most, as a share of what the bridge may carry: what the
/// [limiter](crate::app::operation::current_limit) may be beyond its limit for a moment lies between the two.
pub const CURRENT_SHARE: f32 = 0.85;

/// What the drive bears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Most that the bridge may carry, A, either way: above what the loop can draw from its supply
    /// through the winding, below where the current sensor saturates, or nothing is ever beyond it.
    pub peak_current: f32,
    /// What the winding bears for ever, A: the motor's rated current.
    pub continuous_current: f32,
    /// Most that the drive lets flow, A, either way.
    pub current_limit: f32,
    /// How long it bears the peak current after rest, s: I² t, as the copper takes the heat of so
    /// short a time up by itself.
    pub peak_time: f32,
    /// Most load that its mechanism sees beside its own friction and spring, N·m or N, either way.
    pub load: f32,
    /// Least and most of the bridge's supply, V. The most lies below what the capacitors and switches
    /// bear, the least where the gate drivers still switch.
    pub supply: [f32; 2],
    /// How long a supply may be out of there, s: longer than the PWM's ripple, shorter than it takes
    /// the capacitors to charge by the rest of their margin.
    pub supply_time: f32,
    /// How long commands of a terminal are driven that sends nothing more, s; 0 for ever.
    pub command_timeout: f32,
}

impl Limits {
    /// Most current that the drive lets flow, A, either way: as it is set, and no nearer to the peak than
    /// [`CURRENT_SHARE`].
    pub fn current(&self) -> f32 {
        self.current_limit.min(CURRENT_SHARE * self.peak_current)
    }
}

/// What a control step measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Encoder, current and voltage.
    pub reading: Reading,
    /// Supply of the bridge, V.
    pub supply: f32,
    /// Lower and upper limit switch: true where the actuator is on it.
    pub switches: [bool; 2],
}

/// What watches the encoder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observers {
    /// Against the winding.
    pub winding: back_emf::Coefficients,
    /// Against the torque.
    pub torque: following::Coefficients,
}

/// What is remembered from step to step, whatever the numbers are by then.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct State {
    winding: back_emf::State,
    torque: following::State,
    heat: overload::Heat,
    low: Debounce,
    high: Debounce,
}

/// The monitors of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Monitors {
    limits: Limits,
    observers: Observers,
    state: State,
    supply_steps: u32,
    winding: overload::Coefficients,
}

impl Monitors {
    /// For control steps of `period`, s.
    ///
    /// # Errors
    /// A limit that is not above 0, or above the one that should be above it.
    pub fn new(
        limits: Limits,
        observers: Observers,
        period: f32,
    ) -> Result<Self, InvalidParameter> {
        let require = |valid: bool, name, requirement| {
            valid
                .then_some(())
                .ok_or(InvalidParameter { name, requirement })
        };
        let positive = |value: f32| value > 0.0 && value.is_finite();
        let Limits {
            peak_current,
            continuous_current,
            current_limit,
            peak_time,
            load: _,
            supply: [least, most],
            supply_time,
            command_timeout: _,
        } = limits;
        require(positive(period), "period", "must be above 0")?;
        require(
            positive(continuous_current),
            "continuous_current",
            "must be above 0",
        )?;
        require(
            peak_current > continuous_current && peak_current <= 1e6,
            "peak_current",
            "must be above the continuous current, at most 1e6 A",
        )?;
        require(positive(current_limit), "current_limit", "must be above 0")?;
        require(positive(peak_time), "peak_time", "must be above 0")?;
        require(
            least >= 0.0 && most > least && most.is_finite(),
            "supply",
            "must be two voltages from 0 up, the least first",
        )?;
        require(
            (0.0..=1.0).contains(&supply_time),
            "supply_time",
            "must be 0 to 1 s",
        )?;
        Ok(Self {
            limits,
            observers,
            state: State::default(),
            // At least one step; the conversion takes the fraction off.
            supply_steps: (supply_time / period) as u32 + 1,
            winding: overload::Coefficients::new(
                [peak_current, continuous_current, limits.current()],
                peak_time,
                period,
            ),
        })
    }

    /// Takes the numbers of other monitors, and keeps all that was seen: numbers that come as often as
    /// one likes hide nothing. What is known of the winding holds for its old numbers alone.
    pub fn take(&mut self, other: &Self) {
        let Self {
            limits,
            observers,
            state: _,
            supply_steps,
            winding,
        } = *other;
        self.state.heat = winding.taken_over(self.winding, self.state.heat);
        if self.observers.winding != observers.winding {
            self.state.winding = self.state.winding.of_other_numbers();
        }
        self.limits = limits;
        self.observers = observers;
        self.supply_steps = supply_steps;
        self.winding = winding;
    }

    /// Begins the balance of the torque anew: what pushes a rotor to see whether it moves is no fault of the encoder.
    pub fn forget_torque(&mut self) {
        self.state.torque = following::State::default();
    }

    /// Takes a control step's measurements: the conditions that hold now.
    pub fn step(&mut self, measured: &Measured) -> Faults {
        let Reading {
            position,
            moved,
            current,
            voltage,
            ..
        } = measured.reading;
        let [least, most] = self.limits.supply;
        let supply = measured.supply;
        let finite = position.is_finite()
            && moved.is_finite()
            && current.is_finite()
            && supply.is_finite()
            && voltage.is_none_or(f32::is_finite);
        let winding =
            self.observers
                .winding
                .step(&mut self.state.winding, &measured.reading, supply);
        let torque = self
            .observers
            .torque
            .step(&mut self.state.torque, &measured.reading);
        // The comparisons are written so that NaN is out of the limit.
        let inside = current.abs() <= self.limits.peak_current;
        let high = self
            .state
            .high
            .after(self.supply_steps, supply.is_nan() || supply > most);
        let low = self
            .state
            .low
            .after(self.supply_steps, supply.is_nan() || supply < least);
        Faults::when(Fault::NonFinite, !finite)
            | Faults::when(Fault::OverCurrent, !inside)
            | Faults::when(
                Fault::Overload,
                self.winding.step(&mut self.state.heat, current),
            )
            | Faults::when(Fault::OverVoltage, high)
            | Faults::when(Fault::UnderVoltage, low)
            | winding.map_or(Faults::NONE, Faults::from)
            | torque.map_or(Faults::NONE, Faults::from)
            | Faults::when(
                Fault::StopReached,
                driven_into_stop(voltage, measured.switches),
            )
    }

    /// Learns from the last step what the next one judges by. It may be called when the control step is not waited for any more.
    pub fn learn(&mut self) {
        self.observers.winding.learn(&mut self.state.winding);
    }

    /// How hot the winding is.
    pub fn heat(&self) -> overload::Heat {
        self.state.heat
    }

    /// Begins with a winding that is so hot.
    pub fn set_heat(&mut self, heat: overload::Heat) {
        self.state.heat = heat;
    }

    /// Most current that the winding bears now, as far as its heat is not known, A.
    pub fn current(&self) -> f32 {
        self.winding.current(&self.state.heat)
    }
}

/// Whether the bridge drives towards a limit switch that the actuator is on. With the bridge off, or
/// driven away from it, all is well: that is the way out.
pub fn driven_into_stop(voltage: Option<f32>, [lower, upper]: [bool; 2]) -> bool {
    voltage.is_some_and(|volts| (lower && volts < 0.0) || (upper && volts > 0.0))
}
