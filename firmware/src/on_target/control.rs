//! The controller and the test signals.

use model_core::control::pid;
use model_core::numeric::random::Random;
use model_core::signal::{ramp, sine, step, sweep, triangle};

use super::Findings;
use crate::app::timing::CONTROL_PERIOD;

/// A position loop of the actuator.
pub const GAINS: pid::Parameters = pid::Parameters {
    proportional: 17.0,
    integral: 60.0,
    derivative: 0.25,
    derivative_filter_time: 3e-3,
    set_point_weight: 1.0,
    derivative_set_point_weight: 0.0,
    output_minimum: -24.0,
    output_maximum: 24.0,
    anti_windup: pid::AntiWindup::ConditionalIntegration,
};

pub(super) fn pid(findings: &mut Findings) {
    let ways = [
        pid::AntiWindup::None,
        pid::AntiWindup::ConditionalIntegration,
        pid::AntiWindup::BackCalculation { tracking_time: 0.1 },
    ];
    for anti_windup in ways {
        let parameters = pid::Parameters {
            anti_windup,
            ..GAINS
        };
        let Some(controller) = findings.sound(parameters.build(CONTROL_PERIOD), "gains are taken")
        else {
            return;
        };
        let mut random = Random::new(11, 1);
        let mut state = pid::State::default();
        for _ in 0..2000 {
            let output = controller.step(&mut state, 2.0 * random.normal(), random.normal());
            findings.single(output.unwrap_or(1e9));
        }
        findings.claim(
            controller.step(&mut state, f32::NAN, 0.0).is_err(),
            "a set point that is not a number is refused",
        );
    }
    // 2 + 10/s · 0.1 s of an error of 1.
    let plain = pid::Parameters {
        proportional: 2.0,
        integral: 10.0,
        ..pid::Parameters::default()
    };
    if let Some(controller) = findings.sound(plain.build(CONTROL_PERIOD), "gains are taken") {
        let mut state = pid::State::default();
        let last = (0..=100).fold(0.0, |_, _| {
            controller.step(&mut state, 1.0, 0.0).unwrap_or(1e9)
        });
        findings.claim((last - 3.0).abs() < 1e-6, "a constant error ramps");
    }
}

pub(super) fn signals(findings: &mut Findings) {
    let sine = sine::Parameters {
        offset: 0.5,
        amplitude: 2.0,
        frequency: 3.7,
        phase: 1.0,
    };
    let triangle = triangle::Parameters {
        offset: 0.5,
        amplitude: 2.0,
        frequency: 3.7,
        phase: 1.0,
    };
    let sweep = sweep::Parameters {
        offset: 0.0,
        amplitude: 12.0,
        initial_frequency: 0.2,
        final_frequency: 40.0,
        duration: 1.5,
    };
    let ramp = ramp::Parameters {
        initial_value: -1.0,
        final_value: 3.0,
        start: 0.1,
        duration: 1.0,
    };
    let step = step::Parameters {
        initial_value: 0.0,
        final_value: 12.0,
        time: 0.5,
    };
    let claim = "a signal's parameters are taken";
    let (Some(sine), Some(triangle), Some(sweep), Some(ramp), Some(step)) = (
        findings.sound(sine.build(CONTROL_PERIOD), claim),
        findings.sound(triangle.build(CONTROL_PERIOD), claim),
        findings.sound(sweep.build(CONTROL_PERIOD), claim),
        findings.sound(ramp.build(CONTROL_PERIOD), claim),
        findings.sound(step.build(CONTROL_PERIOD), claim),
    ) else {
        return;
    };
    for tick in 0..2000 {
        for value in [
            sine.at(tick),
            triangle.at(tick),
            sweep.at(tick),
            ramp.at(tick),
            step.at(tick),
        ] {
            findings.single(value);
        }
    }
    findings.claim(ramp.at(600) == 1.0, "half way up the ramp");
    findings.claim(
        [499, 500].map(|tick| step.at(tick)) == [0.0, 12.0],
        "the step",
    );
}
