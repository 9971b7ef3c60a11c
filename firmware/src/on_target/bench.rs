//! The bench paper's test bench, by both of its electrics.

use model_core::plant::bench::averaged::Averaged;
use model_core::plant::bench::back_emf::{self, Shape};
use model_core::plant::bench::control::{self, Hold};
use model_core::plant::bench::electrics::Electrics;
use model_core::plant::bench::encoder;
use model_core::plant::bench::switching::Switching;
use model_core::plant::bench::{Bench, Parameters, brake, electrics, mechanics, torque};

use super::Findings;

/// The paper's model, with backlash.
fn plain(parameters: Parameters) -> Parameters {
    Parameters {
        encoder: encoder::Parameters {
            backlash: 0.01,
            ..parameters.encoder
        },
        ..parameters
    }
}

/// A worn motor behind elastic teeth, with all that is off by default, and an anti-windup.
fn worn(parameters: Parameters, hold: Hold) -> Parameters {
    let parameters = plain(parameters).with_elastic_teeth(200.0, 0.01);
    Parameters {
        control: control::Parameters {
            hold,
            ..parameters.control
        },
        electrics: electrics::Parameters {
            back_emf: back_emf::Parameters {
                shape: Shape::Trapezoidal,
                static_eccentricity: 0.1,
                turns: [1.0, 0.9, 1.0],
            },
            torque: torque::Parameters {
                saturation: 0.02,
                ..parameters.electrics.torque
            },
            ..parameters.electrics
        },
        mechanics: mechanics::Parameters {
            transmission_loss: 0.2,
            load_share: 0.1,
            ..parameters.mechanics
        },
        ..parameters
    }
}

fn drive<E: Electrics>(findings: &mut Findings, parameters: &Parameters, periods: u32) {
    let built = Bench::<E>::build(parameters);
    let Some(mut bench) = findings.sound(built, "the bench is taken") else {
        return;
    };
    for period in 0..periods {
        if period == periods / 4 {
            bench.set_brake(brake::friction(200.0));
        }
        // Far off, so that speed, current and voltage are limited; then back.
        let command = if period < periods / 2 { 0.6 } else { -0.02 };
        let Some(sample) = findings.sound(bench.step(command), "the commands are taken") else {
            break;
        };
        for value in [
            sample.position,
            sample.motor_position,
            sample.velocity,
            sample.quadrature_current,
            sample.reference_current,
            bench.drive().torque,
            bench.drive().direct,
        ] {
            findings.single(value);
        }
    }
    findings.claim(
        bench.step(f32::NAN).is_err(),
        "what is no position is refused",
    );
}

/// The averaged electrics.
pub(super) fn averaged(findings: &mut Findings) {
    drive::<Averaged>(findings, &plain(Parameters::AVERAGED), 400);
    let worn = worn(Parameters::AVERAGED, Hold::AtStandstill);
    drive::<Averaged>(findings, &worn, 400);
}

/// The switching electrics.
pub(super) fn switching(findings: &mut Findings) {
    drive::<Switching>(findings, &plain(Parameters::SWITCHING), 20);
    let worn = worn(Parameters::SWITCHING, Hold::BeyondPositionError(0.3));
    drive::<Switching>(findings, &worn, 20);
}
