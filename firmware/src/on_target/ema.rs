//! The prognostics paper's servo, by each of its friction schemes.

use model_core::plant::ema::friction::Scheme;
use model_core::plant::ema::{Command, Ema, Parameters};

use super::Findings;

/// Periods of the drive in open loop, and as many in closed loop.
const PERIODS: usize = 40;

/// The schemes, each with the steps that it takes in a period.
const SCHEMES: [(Scheme, u16); 3] = [
    (Scheme::Karnopp { band: 0.15 }, 320),
    (Scheme::Borello, 320),
    (Scheme::Exact, 32),
];

pub(super) fn servo(findings: &mut Findings) {
    for (scheme, steps) in SCHEMES {
        let parameters = Parameters {
            scheme,
            steps,
            ..Parameters::ALI_2
        };
        let Some(mut ema) = findings.sound(Ema::build(&parameters), "the servo is taken") else {
            continue;
        };
        for period in 0..2 * PERIODS {
            // Full duty to and fro saturates the motor; then a step and its way back.
            let command = match period {
                0..10 => Command::Duty(1.0),
                10..20 => Command::Duty(-1.0),
                20..PERIODS => Command::Duty(0.11),
                40..60 => Command::Position(5e-3),
                _ => Command::Position(0.0),
            };
            let Some(sample) = findings.sound(ema.step(command), "the commands are taken") else {
                break;
            };
            for value in [sample.position, sample.speed, sample.current, sample.duty] {
                findings.single(value);
            }
            findings.single(ema.position());
        }
        let before = ema.clone();
        for refused in [f32::NAN, f32::INFINITY] {
            let outcome = ema.step(Command::Position(refused));
            findings.claim(
                outcome.is_err() && ema == before,
                "what is no position is refused",
            );
        }
    }
}
