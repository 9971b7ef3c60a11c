//! The state that a window restarts from, and what is run in to it.

use super::data::{Data, MARGIN, Settings, WINDOW, Window, WindowStart, samples};
use crate::effect::compliance::Twist;
use crate::effect::thermal_drift::ThermalDrift;
use crate::gap::held::Acting;
use crate::gap::log::Log;
use crate::gap::simulator::{Course, Simulator};
use crate::numeric::exponential::decay;
use crate::plant::modes::Modes;
use crate::plant::{Motion, State};
use core::borrow::Borrow;

/// Length of the run-in that twists a shaft, s, and fewest samples in it: a wrong twist falls to a
/// tenth in two or three swings.
const SHAFT_RUN_IN: f32 = 0.1;

const LEAST_RUN_IN: usize = 100;

/// Shortest time, s, that the simulation before a restart takes for each sample of the half width; one sample where that is longer.
/// How much a coarse sensor's rounding disturbs a velocity depends on the time, not on the number of samples in it.
const FINEST_RUN_IN: f32 = 1e-3;

/// Fewest samples on either side that a run-in's state is smoothed over, at the beginning of a log.
const LEAST_HALF_WIDTH: usize = 2;

/// Most windows that a run-in goes back.
const MOST_RUN_IN: usize = 10;

/// Time from one look at the current to the next while a winding's warmth is carried to a restart, s:
/// far below any thermal time constant.
const HEAT_STRIDE: f32 = 0.01;

/// Time over which its warmth is worked out at once, in time constants of the winding: a step of second order is off
/// by some of its square, a thousandth of what the current has changed.
const HEAT_STEP: f32 = 1.0 / 20.0;

/// Time from one look at the position to the next while a hysteresis is carried to a restart, s: a
/// machine that turns has hardly moved in it.
const TURN_STRIDE: f32 = 0.005;

/// Travel, in shares of the reach, behind which the deflection that it began with is forgotten; and time
/// constants behind which a current is.
const FORGOTTEN: f32 = 5.0;

/// Periods under which a winding's current counts as steady: at a third of a period it is within 5 % of that
/// after one.
const FASTEST_WINDING: f32 = 0.3;

/// What a run-in shows of a shaft's twist, in which what it started with has died out. What the far side
/// swings about is smoothed over it, for a swing is too fast for that.
#[derive(Debug, Clone, Copy)]
pub(super) struct Twists {
    /// The twist at the restart.
    pub twist: Twist,
    /// Its angles on either side of it, as far as that is smoothed over.
    pub angles: [f32; 2 * MARGIN + 1],
}

impl Twists {
    pub(super) fn new() -> Self {
        Self {
            twist: Twist::default(),
            angles: [0.0; 2 * MARGIN + 1],
        }
    }

    /// Takes down the twist at a sample.
    #[inline]
    pub(super) fn observe(
        &mut self,
        twist: Twist,
        sample: usize,
        restart: &Restart,
        settings: &Settings,
    ) {
        let place = (sample + settings.half_width).checked_sub(restart.start);
        if let Some(angle) = place.and_then(|place| self.angles.get_mut(place)) {
            *angle = twist.angle;
        }
        if sample == restart.start {
            self.twist = twist;
        }
    }
}

/// The last clear motion before a restart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Approach {
    /// Its last sample.
    pub since: usize,
    /// Which way it went.
    pub motion: Motion,
    /// Whether the machine rested or turned behind it: the slope at the restart then says nothing of
    /// the drive.
    pub rested: bool,
    /// The measured state there, but for the current.
    pub state: State,
}

/// Where a replay starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Restart {
    pub start: usize,
    /// The measured state, but for the current.
    pub state: State,
    /// How it came there, where somebody asks.
    pub approach: Option<Approach>,
    /// The warmth there, for the heating that was asked for first: few copies have another one.
    warmth: Option<(ThermalDrift, f32)>,
    /// The deflection of a hysteresis there, for the reach that was asked for first.
    deflection: Option<(f32, f32)>,
}

/// What run-ins to a restart lead to.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct RunIn {
    pub twists: Option<Twists>,
    /// Where a simulated approach ends.
    pub behind: Option<Course>,
}

impl Restart {
    pub(super) fn new(log: &Log, start: usize, settings: &Settings, is_stateful: bool) -> Self {
        let state = measured_state(log, start, settings);
        let approach = is_stateful.then(|| approach(log, start, settings));
        Self {
            start,
            state,
            approach,
            warmth: None,
            deflection: None,
        }
    }

    /// Steps that simulations which remember run in to it.
    pub(super) fn lead(&self, log: &Log, settings: &Settings) -> usize {
        let simulated = settings.own_velocity(log).is_none();
        let approach = self.approach.filter(|_| simulated);
        approach.map_or(0, |approach| self.start - approach.since)
    }

    /// Sample from which a model comes to a simulated velocity.
    pub(super) fn simulated_since(&self, log: &Log, settings: &Settings) -> usize {
        let half_width = settings.half_width;
        let run_in = half_width * samples(FINEST_RUN_IN, log.period, 1);
        let since = self.start.saturating_sub(run_in).max(half_width);
        since.min(self.start)
    }

    /// Sample from which a run-in twists a shaft.
    pub(super) fn winds_since(&self, log: &Log) -> usize {
        let run_in = samples(SHAFT_RUN_IN, log.period, LEAST_RUN_IN);
        self.start.saturating_sub(run_in).max(LEAST_HALF_WIDTH)
    }

    /// Share by which warmth has raised the resistance of a model's winding.
    pub(super) fn warmth<M: Borrow<Modes>, H: Acting>(
        &mut self,
        simulator: &Simulator<M, H>,
        log: &Log,
    ) -> f32 {
        let start = self.start;
        known(&mut self.warmth, simulator.heating(), |heating| {
            warmth_at(simulator, heating, log, start)
        })
    }

    /// The deflection of a model's hysteresis.
    pub(super) fn deflection<M: Borrow<Modes>, H: Acting>(
        &mut self,
        simulator: &Simulator<M, H>,
        log: &Log,
    ) -> f32 {
        let start = self.start;
        known(&mut self.deflection, simulator.reach(), |reach| {
            deflection_at(log, start, reach)
        })
    }
}

/// What comes of a cause, worked out again only for another one than the first; 0 without any.
fn known<C: Copy + PartialEq>(
    first: &mut Option<(C, f32)>,
    cause: Option<C>,
    work: impl Fn(C) -> f32,
) -> f32 {
    let Some(cause) = cause else { return 0.0 };
    match *first {
        Some((known, value)) if known == cause => value,
        _ => {
            let value = work(cause);
            first.get_or_insert((cause, value));
            value
        }
    }
}

/// Share by which a log up to a sample has raised the resistance of a winding that was cold at its
/// beginning: by the measured current, or by the steady one of input and speed.
pub(super) fn warmth_at<M: Borrow<Modes>, H: Acting>(
    simulator: &Simulator<M, H>,
    heating: ThermalDrift,
    log: &Log,
    start: usize,
) -> f32 {
    let stride = samples(HEAT_STRIDE, log.period, 1);
    let look = stride as f32 * log.period;
    let squared = |end: usize| {
        let middle = end - stride / 2;
        let current = match log.current {
            Some(current) => simulator.current_sensor().current(current.at(middle)),
            None if log.is_released(middle) => 0.0,
            None => {
                let travel = log.position.at(end) - log.position.at(end - stride);
                simulator.steady_current(travel / look, log.input.at(middle))
            }
        };
        current * current
    };
    let looks = start / stride;
    let longest = looks.max(1) as f32;
    let together = (HEAT_STEP * heating.time_constant() / look).clamp(1.0, longest) as usize;
    let mut warmth = 0.0;
    for from in (0..looks).step_by(together) {
        let to = looks.min(from + together);
        let sum: f32 = (from + 1..=to).map(|number| squared(number * stride)).sum();
        let count = (to - from) as f32;
        warmth = heating.long_after(warmth, libm::sqrtf(sum / count), count * look);
    }
    warmth
}

/// Current of a winding at a sample. It is integrated from the input and the measured motion, from so early that
/// what it began with is forgotten. A measured current corrects it on the way: a wrong start would act like a
/// torque for a time constant of the winding, so that the samples of the last time constant are averaged, each
/// carried on to this one. `state`: that at the sample, smoothed over so many samples on either side.
pub(super) fn current_at<M: Borrow<Modes>, H: Acting>(
    simulator: &Simulator<M, H>,
    log: &Log,
    start: usize,
    (state, half_width): (&State, usize),
) -> f32 {
    let late = simulator.input_lateness();
    let steady = |sample: usize, velocity: f32| {
        if log.is_released(sample) {
            0.0
        } else {
            simulator.steady_current(velocity, late.read(log.input, sample))
        }
    };
    let measured = |sample: usize| log.current.map(|current| simulator.read(current, sample));
    let periods = simulator.electric_periods();
    if periods < FASTEST_WINDING || start <= half_width {
        return measured(start).unwrap_or_else(|| steady(start, state.velocity.value()));
    }
    let longest = samples(WINDOW, log.period, 1).min(start - half_width);
    let back = (FORGOTTEN * periods + 1.0).min(longest as f32) as usize;
    let share = 1.0 - libm::expf(-1.0 / periods);
    let most = periods.max(1.0);
    let mut seen = 1.0;
    let mut current = measured(start - back);
    for sample in start - back..start {
        let travel = log.position.at(sample + half_width) - log.position.at(sample - half_width);
        let velocity = travel / (2.0 * half_width as f32 * log.period);
        let last = steady(sample, velocity);
        let before = current.unwrap_or(last);
        // What flowed when the drive lets go has gone with the step.
        let share = if log.is_released(sample) { 1.0 } else { share };
        let mut after = before + share * (last - before);
        if let Some(measured) = measured(sample + 1) {
            seen = most.min(seen + 1.0);
            after += (measured - after) / seen;
        }
        current = Some(after);
    }
    current.unwrap_or(0.0)
}

/// Deflection of a hysteresis with this reach behind the measured motion up to a sample: each way without a turn
/// leaves what it has led to times what the travel since then leaves of that.
pub(super) fn deflection_at(log: &Log, start: usize, reach: f32) -> f32 {
    let stride = samples(TURN_STRIDE, log.period, 1);
    let mut end = start;
    // Backwards: travel, what it leaves at the last turn, which way the drive went before that.
    let (mut travel, mut left, mut towards) = (0.0, 1.0, 0.0);
    let mut deflection = 0.0;
    while end >= stride && travel < FORGOTTEN * reach {
        let displacement = log.position.at(end) - log.position.at(end - stride);
        if displacement * towards <= 0.0 && displacement != 0.0 {
            let remains = decay(travel / reach);
            deflection += towards * (left - remains);
            (left, towards) = (remains, displacement.signum() * reach);
        }
        travel += displacement.abs();
        end -= stride;
    }
    deflection + towards * (left - decay(travel / reach))
}

/// The last clear motion before what the state at `start` is smoothed over, within the run-in; the
/// one before, where it has hardly begun.
pub(super) fn approach(log: &Log, start: usize, settings: &Settings) -> Approach {
    let half_width = settings.half_width;
    let earliest = start
        .saturating_sub(MOST_RUN_IN * settings.window)
        .max(half_width);
    let clear_motion = |before: usize| {
        let there = log.position.at(before);
        let mut samples = (earliest..before).rev();
        samples
            .find(|&index| (log.position.at(index) - there).abs() > settings.clear_travel)
            .map(|last| (last, Motion::of(there - log.position.at(last))))
    };
    let before = start - half_width;
    let Some((last, motion)) = clear_motion(before) else {
        // Too near to the beginning of the log to look back over the smoothing?
        let here = log.position.at(start);
        let mut first = (0..start).filter(|_| earliest == half_width);
        let moved = |index: &usize| (here - log.position.at(*index)).abs() > settings.clear_travel;
        if let Some(index) = first.find(moved) {
            return Approach {
                since: start,
                motion: Motion::of(here - log.position.at(index)),
                rested: false,
                state: measured_state(log, start, settings),
            };
        }
        // It has rested as long as anybody looks back: somewhere within the play.
        return Approach {
            since: earliest,
            motion: Motion::Rest,
            rested: true,
            state: measured_state(log, earliest, settings),
        };
    };
    // A slope over the end of a plateau mixes a rest with what comes behind it.
    let turned = last
        .checked_sub(2 * half_width)
        .filter(|&index| index > earliest)
        .and_then(clear_motion)
        .filter(|(_, earlier)| *earlier != motion);
    let resting = clear_motion(start).is_none_or(|(last, _)| 2 * (start - last) > half_width);
    let rested = resting || before - last > half_width || turned.is_some();
    let (since, motion) = turned.unwrap_or((last, motion));
    Approach {
        since,
        motion,
        rested,
        state: measured_state(log, since, settings),
    }
}

/// Steps that simulations run in to a window, where any of them remembers.
pub(super) fn lead(data: &Data, window: Window, is_stateful: bool) -> usize {
    let log = &data.logs[window.log];
    Restart::new(log, window.start, &data.settings, is_stateful).lead(log, &data.settings)
}

/// Whether the machine turns or rests in a window, or shortly before it: where a memory shows.
pub fn turns(data: &Data, window: Window) -> bool {
    let log = &data.logs[window.log];
    let at = |sample: usize| approach(log, sample, &data.settings);
    let (start, end) = (at(window.start), at(window.start + data.settings.window));
    start.rested || end.rested || start.motion != end.motion
}

/// The measured state at a sample, but for the current.
pub(super) fn measured_state(log: &Log, start: usize, settings: &Settings) -> State {
    measured_state_less(log, start, settings, |_| 0.0)
}

/// The same less a known part of each position.
pub(super) fn measured_state_less(
    log: &Log,
    start: usize,
    settings: &Settings,
    part: impl Fn(usize) -> f32 + Copy,
) -> State {
    let state = log.smoothed_state_less(start, settings.half_width, settings.resolution, part);
    match log.velocity {
        Some(velocity) if settings.window_start == WindowStart::Measured => {
            State::new(state.position.value(), velocity.at(start))
        }
        _ => state,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{Effect, padded};
    use crate::gap::log::Channel;
    use crate::gap::model::Model;
    use crate::plant::parameters::{Drive, Parameters};

    const PERIOD: f32 = 1e-3;

    #[test]
    fn a_deflection_follows_the_ways_between_turns() {
        // To 0.3 rad, back to 0.1 and on to 0.15, in 12 s.
        let there = |time: f32| match time {
            _ if time < 6.0 => 0.05 * time,
            _ if time < 10.0 => 0.3 - 0.05 * (time - 6.0),
            _ => 0.1 + 0.025 * (time - 10.0),
        };
        let positions: [f32; 12_001] = core::array::from_fn(|sample| there(sample as f32 * PERIOD));
        let inputs = [0.0; 12_001];
        let log = Log::new(
            PERIOD,
            Channel::Values(&inputs),
            Channel::Values(&positions),
        );
        // Dahl's law in closed form, a way at a time; half of the second and none of the third at first.
        let reach = 0.1_f64;
        let way = |deflection: f64, way: f64| {
            let towards = reach.copysign(way);
            towards - (towards - deflection) * (-way.abs() / reach).exp()
        };
        let first = way(0.0, 0.3);
        for (start, expected) in [
            (3000, way(0.0, 0.15)),
            (8000, way(first, -0.1)),
            (12_000, way(way(first, -0.2), 0.05)),
        ] {
            let found = f64::from(deflection_at(&log, start, reach as f32));
            // What lies further back is left out.
            let forgotten = reach * f64::from(-FORGOTTEN).exp();
            assert!(
                (found - expected).abs() < forgotten,
                "{start}: {found} {expected}"
            );
        }
        assert_eq!(deflection_at(&log, 0, 0.1), 0.0);
    }

    #[test]
    fn a_winding_heats_as_its_closed_form() {
        let mut plant = Parameters::free(1e-3);
        plant.drive = Drive::Voltage {
            resistance: 1.0,
            inductance: 1e-3,
            torque_constant: 0.05,
        };
        let model = Model::new(plant);
        let simulator = model.build(PERIOD).unwrap();
        let current: [f32; 12_001] =
            core::array::from_fn(|sample| if sample % 2000 < 1000 { 3.0 } else { 1.0 });
        let zeros = [0.0; 12_001];
        let mut log = Log::new(PERIOD, Channel::Values(&zeros), Channel::Values(&zeros));
        log.current = Some(Channel::Values(&current));
        for time_constant in [2.0_f64, 5.0, 50.0] {
            let rate = 0.01_f64;
            let heating = ThermalDrift::new(padded([rate as f32, time_constant as f32]));
            let mut expected = 0.0;
            for second in 0..12 {
                let gain = rate * if second % 2 == 0 { 9.0 } else { 1.0 };
                let loss = 1.0 / time_constant - gain;
                let steady = gain / loss;
                expected = steady + (expected - steady) * (-loss).exp();
            }
            let found = f64::from(warmth_at(&simulator, heating, &log, 12_000));
            assert!(
                (found / expected - 1.0).abs() < 5e-3,
                "{time_constant}: {found} {expected}"
            );
        }
    }
}
