//! What `cargo hil` runs: an actuator that is not what it is declared to be, one that wears, one under
//! its brake, and a throttle.

use model_core::plant::Directional;
use model_core::plant::parameters::Parameters;

use super::experiment::{Evaluation, Experiment, Wear};
use super::machine::{EMA, THROTTLE};
use super::profile::Command;
use super::timing::STEPS_PER_SECOND;

/// Steps of different height both ways, a sweep and a triangle: 5 s.
const EMA_SHORT: [Command; 7] = [
    Command::step(0.0, 0.3, 400),
    Command::step(0.3, 0.8, 400),
    Command::step(0.8, -0.2, 400),
    Command::step(-0.2, -0.7, 400),
    Command::step(-0.7, 0.0, 400),
    Command::sweep((0.0, 0.5), (0.5, 4.0), 2),
    Command::triangle((0.0, 0.6), 1.0, 1),
];

/// The same kinds, longer: 10 s.
const EMA_LONG: [Command; 8] = [
    Command::step(0.0, 0.3, 500),
    Command::step(0.3, 0.8, 500),
    Command::step(0.8, 0.5, 500),
    Command::step(0.5, -0.2, 500),
    Command::step(-0.2, -0.7, 500),
    Command::step(-0.7, 0.0, 500),
    Command::sweep((0.0, 0.6), (0.2, 3.0), 4),
    Command::triangle((0.0, 0.7), 0.5, 3),
];

/// A sine whose frequency rises linearly over 10 s, slow enough and large enough for the motor to
/// overcome half of its peak torque.
const EMA_SWEEP: [Command; 1] = [Command::sweep((0.0, 0.9), (0.2, 2.0), 10)];

/// Over the limp-home position and near both stops: 10 s.
const THROTTLE_LONG: [Command; 8] = [
    Command::step(0.2, 0.5, 500),
    Command::step(0.5, 1.4, 500),
    Command::step(1.4, 1.3, 500),
    Command::step(1.3, 0.1, 500),
    Command::step(0.1, 0.7, 500),
    Command::step(0.7, 0.3, 500),
    Command::sweep((0.7, 0.5), (0.2, 3.0), 4),
    Command::triangle((0.8, 0.7), 0.5, 3),
];

/// In the order in which they run.
pub const DEMONSTRATION: [Experiment; 4] = [UNDECLARED, WEAR, BRAKE, EMULATION];

/// Viscous friction that depends on the direction of motion, which nobody declares: the board has to
/// find it in its own log.
pub const UNDECLARED: Experiment = Experiment {
    actuator: Parameters {
        viscous: Directional {
            forward: 1.4e-3,
            backward: EMA.plant.viscous.backward,
        },
        ..EMA.plant
    },
    evaluation: Evaluation::Check,
    ..Experiment::new("undeclared", EMA, &EMA_SHORT, 5 * STEPS_PER_SECOND)
};

/// Friction that grows by a quarter on the way: the board has to say by how much.
pub const WEAR: Experiment = Experiment {
    wear: Some(Wear {
        step: 5 * STEPS_PER_SECOND,
        coulomb: 0.15,
        breakaway: 0.1875,
    }),
    evaluation: Evaluation::Refit,
    ..Experiment::new("wear", EMA, &EMA_LONG, 15 * STEPS_PER_SECOND)
};

/// The case of the prognostics paper: the holding brake at 11 V of 24 V stands for a bearing that seizes,
/// 0.779 N·m of friction where the drive believes in 0.12.
///
/// Source: *A New Prognostic Method based on Simulated Annealing Algorithm to deal with the Effects of Dry
/// Friction on Electromechanical Actuators*, section VI, where the estimate is 0.7352 N·m, 5.6 % off.
pub const BRAKE: Experiment = Experiment {
    actuator: Parameters {
        coulomb: Directional::both(0.779),
        breakaway: Directional::both(1.25 * 0.779),
        ..EMA.plant
    },
    evaluation: Evaluation::Refit,
    ..Experiment::new("brake", EMA, &EMA_SWEEP, 10 * STEPS_PER_SECOND)
};

/// A throttle in its loop.
pub const EMULATION: Experiment =
    Experiment::new("throttle", THROTTLE, &THROTTLE_LONG, 22 * STEPS_PER_SECOND);
