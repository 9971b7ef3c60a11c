//! Gain, offset and lag of a current's sensor are found beside the numbers of the machine.

use model_core::gap::covariance::Information;
use model_core::gap::current_sensor::{CurrentSensor, Reading};
use model_core::gap::fit::{Effort, fit, variables};
use model_core::gap::log::{Channel, Log};
use model_core::gap::model::Base;
use model_core::gap::replay::{Data, Fold, InOrder};
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use tracing::{PERIOD, model, plant, winding};

mod tracing;

/// Steps of the plant in a sample: where between two samples a late sensor reads, the current is known.
const STEPS: usize = 10;

/// What a sensor that is `late` steps behind says of a current, as this file has it.
fn read(current: &[f32], gain: f32, offset: f32, late: usize) -> Vec<f32> {
    let samples = 0..current.len() / STEPS;
    let then = |sample: usize| current[(sample * STEPS).saturating_sub(late)];
    samples.map(|sample| gain * then(sample) + offset).collect()
}

/// Input, position and, at every step, current of a plant that is driven to and fro.
fn recorded() -> (Vec<f32>, Vec<f32>, Vec<f32>) {
    let actuator = Actuator::build(&plant(winding(4e-3), true), PERIOD / STEPS as f32).unwrap();
    let mut state = State::new(0.2, 0.0);
    let (mut input, mut position, mut current) = (Vec::new(), Vec::new(), Vec::new());
    for sample in 0..4000 {
        let time = sample as f32 * PERIOD;
        input.push(5.0 * (37.0 * time).sin() + 2.5 * (90.0 * time).sin());
        position.push(state.position.value());
        for _ in 0..STEPS {
            current.push(state.current);
            actuator.step(&mut state, input[sample]).unwrap();
        }
    }
    (input, position, current)
}

#[test]
fn they_are_found_beside_a_wrong_inertia() {
    let (input, position, current) = recorded();
    let rms = (current.iter().map(|it| it * it).sum::<f32>() / current.len() as f32).sqrt();
    let mut declared = model(&plant(winding(4e-3), true));
    let truth = declared.get(Base::Inertia);
    declared.set(Base::Inertia, 1.3 * truth);
    for (gain, share, late) in [(0.95, 0.02, 13), (1.04, -0.03, 4), (1.0, 0.0, 0)] {
        let offset = share * rms;
        let measured = read(&current, gain, offset, late);
        let logs = [Log {
            current: Some(Channel::Values(&measured)),
            ..Log::new(PERIOD, Channel::Values(&input), Channel::Values(&position))
        }];
        let mut data = Data::new(&logs, 0.0).unwrap();
        data.settings.half_width = 3;
        data.settings.position_weight = 1e3;
        data.settings.current_weight = 30.0 / rms;
        let scope = tracing::scope(4.0);
        let moved = variables(
            &declared,
            &declared,
            (&[Base::Inertia], &Reading::ALL),
            &scope,
        );
        let effort = Effort {
            steps: 60,
            converged: 1e-7,
        };
        let all = (Fold::All, 1);
        let fitted = fit(&data, &InOrder, all, &declared, &moved, effort).unwrap();
        let CurrentSensor {
            gain: found,
            offset: shifted,
            lag,
        } = fitted.model.current_sensor;
        let lateness = late as f32 / STEPS as f32;
        let apart = |a: f32, b: f32, by: f32, what: &str| {
            assert!(
                (a - b).abs() < by,
                "{what}: {a} for {b} at {gain}, {share}, {late}"
            );
        };
        apart(found, gain, 5e-3, "gain");
        apart(shifted / rms, share, 5e-3, "offset");
        apart(lag / PERIOD, lateness, 0.05, "lag");
        apart(
            fitted.model.get(Base::Inertia) / truth,
            1.0,
            0.01,
            "inertia",
        );
        let mut information = Information::default();
        information
            .gather(&data, &InOrder, &fitted.model, &moved)
            .unwrap();
        let covariance = information.covariance(&moved);
        for place in 0..moved.len() {
            let std = covariance.at(place, place).sqrt();
            let scale = f64::from(moved[place].scale);
            assert!(std > 0.0 && std < 0.1 * scale, "{place}: {std} of {scale}");
        }
    }
}
