//! A geared motor whose gear is loose: its encoder sits on the motor, and half of its inertia behind a gap of three
//! degrees. Whatever is said of that, nothing being missing is not it: the model predicts several times worse than the
//! encoder measures.

use std::f64::consts::PI;

use host_tests::gap::engine;
use host_tests::log::Log;
use model_core::gap::verdict::Verdict;

use crate::stepped::{GEARMOTOR, Stepped, gearmotor};

const RESISTANCE: f64 = 4.0;
const TORQUE_CONSTANT: f64 = 1.4;

/// What is before the gap.
const MOTOR: Stepped<4> = Stepped {
    inertia: 0.04,
    coulomb: 0.3,
    breakaway: 0.3,
    count: 2.0 * PI / 4800.0,
    period: 0.004,
    steps: 40,
    rows: 4000,
    ..GEARMOTOR
};

/// What is behind it, kg·m², and how stiff and how damped its contact is, N·m/rad and N·m·s/rad.
const BEHIND: f64 = 0.04;
const STIFFNESS: f64 = 2000.0;
const DAMPING: f64 = 4.0;

fn log(width: f64, phases: [f64; 4]) -> Log {
    let (mut far, mut rate) = (0.0_f64, 0.0_f64);
    MOTOR.log("gear.csv", phases, 0, |volts, position, velocity| {
        let apart = position - far;
        let pressed = apart - apart.clamp(-0.5 * width, 0.5 * width);
        let contact = if pressed == 0.0 {
            0.0
        } else {
            // A contact pushes and does not pull.
            let push = STIFFNESS * pressed + DAMPING * (velocity - rate);
            if push * pressed > 0.0 { push } else { 0.0 }
        };
        rate += MOTOR.step() * contact / BEHIND;
        far += MOTOR.step() * rate;
        let flow = (volts - TORQUE_CONSTANT * velocity) / RESISTANCE;
        (TORQUE_CONSTANT * flow - contact, flow)
    })
}

fn verdict(width: f64) -> Verdict {
    let machine = gearmotor(
        [4.0, 0.0, 1.4],
        "resolution = 1.309e-3\nside = \"motor\"",
        "",
    );
    let train = log(width, [0.3, 1.9, 4.0, 5.5]);
    let other = log(width, [2.2, 0.4, 5.1, 1.0]);
    let report = engine::run(&machine, &[train], || Ok(vec![other]), |_| ()).unwrap();
    report.outcome.verdict
}

/// `widths`: of the gap, degrees.
fn a_gap_is_not_called_complete(widths: &[f64]) {
    for width in widths {
        let verdict = verdict(width.to_radians());
        assert_ne!(verdict, Verdict::NoMissingEffect, "{width} degrees");
    }
}

#[test]
fn a_loose_gear_is_not_called_complete() {
    a_gap_is_not_called_complete(&[0.5]);
}

#[test]
#[ignore = "other cases"]
fn looser_gears_are_not_called_complete() {
    a_gap_is_not_called_complete(&[1.5, 3.0]);
}

#[test]
fn a_tight_one_is() {
    assert_eq!(verdict(0.0), Verdict::NoMissingEffect);
}
