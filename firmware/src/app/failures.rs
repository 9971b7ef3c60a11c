//! Everything that may go wrong with an experiment, one after the other: each has a name in the log,
//! nothing is taken over from it, and the plant goes on.

use model_core::plant::parameters::Parameters;

use super::experiment::{Evaluation, Experiment, Failure, Wear};
use super::machine::EMA;
use super::profile::Command;
use super::timing::STEPS_PER_SECOND;

/// Back and forth: 1 s.
const MOTION: [Command; 2] = [Command::step(-0.5, 0.5, 500), Command::step(0.5, -0.5, 500)];

/// An actuator whose friction is estimated anew.
const SOUND: Experiment = Experiment {
    evaluation: Evaluation::Refit,
    ..Experiment::new("sound", EMA, &MOTION, 3 * STEPS_PER_SECOND)
};

/// In the order in which they run.
pub const FAILURES: [Experiment; 8] = [
    // The position sensor stops reading: the bridge goes off.
    Experiment {
        name: "sensor",
        failure: Some(Failure::PositionSensor(200)),
        steps: STEPS_PER_SECOND,
        evaluation: Evaluation::None,
        ..SOUND
    },
    // No mass: the actuator before it goes on.
    Experiment {
        name: "impossible",
        actuator: Parameters {
            inertia: 0.0,
            ..EMA.plant
        },
        ..SOUND
    },
    // Nobody empties the queue for a while: samples are dropped, the log begins anew behind them.
    Experiment {
        name: "queue",
        failure: Some(Failure::Recording(100)),
        steps: STEPS_PER_SECOND,
        evaluation: Evaluation::None,
        ..SOUND
    },
    // Too short to estimate from.
    Experiment {
        name: "short",
        steps: STEPS_PER_SECOND / 2,
        ..SOUND
    },
    // Too short to look for anything in.
    Experiment {
        name: "short_check",
        steps: STEPS_PER_SECOND / 20,
        evaluation: Evaluation::Check,
        ..SOUND
    },
    // Never moves.
    Experiment {
        name: "still",
        commands: &[Command::step(0.0, 0.0, 1000)],
        ..SOUND
    },
    // So little friction that the estimate ends at its bound.
    Experiment {
        name: "bound",
        wear: Some(Wear {
            step: 0,
            coulomb: 0.001,
            breakaway: 0.001,
        }),
        ..SOUND
    },
    // And after all of that a friction that has grown is found, as if nothing had been.
    Experiment {
        wear: Some(Wear {
            step: 0,
            coulomb: 0.18,
            breakaway: 0.225,
        }),
        ..SOUND
    },
];
