//! The plants: in a mode, and through every kind of event.

use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::Parameters;
use model_core::plant::{Motion, State};
use model_core::signal::sweep;

use super::Findings;
use crate::app::machine;

/// Step of the plants, s.
pub const PERIOD: f32 = 1e-4;

/// The board's actuator in free travel.
pub const EMA: Parameters = Parameters {
    lower_stop: f32::NEG_INFINITY,
    upper_stop: f32::INFINITY,
    ..machine::EMA.plant
};

/// The board's throttle: return spring with a limp-home step, two stops.
pub const THROTTLE: Parameters = machine::THROTTLE.plant;

fn take(findings: &mut Findings, state: &State) {
    findings.single(state.current);
    findings.single(state.velocity.value());
    findings.single(state.position.value());
}

pub(super) fn sliding(findings: &mut Findings) {
    let Some(actuator) = findings.sound(Actuator::build(&EMA, PERIOD), "the EMA is taken") else {
        return;
    };
    let mut state = State::new(0.0, 0.0);
    for _ in 0..10_000 {
        findings.claim(actuator.step(&mut state, 12.0).is_ok(), "12 V are taken");
        take(findings, &state);
    }
    // (k u / R − coulomb) / (B + k² / R)
    let last = (0.06 * 12.0 - 0.12) / (2e-4 + 0.06 * 0.06);
    findings.claim(
        (state.velocity.value() - last).abs() < 1e-4,
        "the final speed",
    );
    let before = state;
    for refused in [f32::NAN, f32::INFINITY, -2e6] {
        let outcome = actuator.step(&mut state, refused);
        findings.claim(
            outcome.is_err() && state == before,
            "what is no input is refused",
        );
    }
}

pub(super) fn events(findings: &mut Findings) {
    for (parameters, amplitude, fastest) in [(EMA, 3.5, 20.0), (THROTTLE, 6.0, 4.0)] {
        let sweep = sweep::Parameters {
            offset: 0.0,
            amplitude,
            initial_frequency: 1.0,
            final_frequency: fastest,
            duration: 2.0,
        };
        let (Some(actuator), Some(sweep)) = (
            findings.sound(Actuator::build(&parameters, PERIOD), "a plant is taken"),
            findings.sound(sweep.build(PERIOD), "the sweep is taken"),
        ) else {
            return;
        };
        let mut state = State::new(parameters.spring_rest, 0.0);
        let mut seen = Seen::default();
        for tick in 0..20_000 {
            let before = state;
            let taken = actuator.step(&mut state, sweep.at(tick)).is_ok();
            findings.claim(taken, "the sweep's voltages are taken");
            take(findings, &state);
            seen.compare(&parameters, &before, &state);
        }
        findings.claim(seen.breakaways > 5, "breakaways happen");
        findings.claim(seen.standstills > 5, "standstills happen");
        if parameters == THROTTLE {
            findings.claim(seen.rests > 5, "the spring's rest is passed");
            findings.claim(seen.stops > 2, "stops are reached");
        }
    }
}

/// Events that show in the states before and after a step.
#[derive(Default)]
struct Seen {
    breakaways: u32,
    standstills: u32,
    rests: u32,
    stops: u32,
}

impl Seen {
    fn compare(&mut self, parameters: &Parameters, before: &State, after: &State) {
        let resting = |state: &State| state.motion == Motion::Rest;
        let beyond = |state: &State| state.position.value() > parameters.spring_rest;
        let stopped = |state: &State| {
            let position = state.position.value();
            position == parameters.lower_stop || position == parameters.upper_stop
        };
        self.breakaways += u32::from(resting(before) && !resting(after));
        self.standstills += u32::from(!resting(before) && before.motion != after.motion);
        self.rests += u32::from(beyond(before) != beyond(after));
        self.stops += u32::from(!stopped(before) && stopped(after));
    }
}
