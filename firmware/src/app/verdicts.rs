//! A board for each kind of verdict: short logs in which the onboard check has to find lost motion, say what a
//! second does not prove, name a number that the machine declares wrongly, and find nothing where nothing is.

use model_core::plant::parameters::{Drive, Parameters};

use super::demonstration::UNDECLARED;
use super::experiment::{Evaluation, Experiment, Peculiarity};
use super::machine::EMA;
use super::profile::Command;
use super::timing::STEPS_PER_SECOND;

/// A sine that quickens: a second of it turns as often as it takes to tell lost motion from the rest.
const MOTION: [Command; 1] = [Command::sweep((0.0, 0.5), (2.0, 8.0), 2)];

/// In the order in which they run. [`TWO`] is traced on the host alone: it would take longer than all others together.
pub const VERDICTS: [Experiment; 4] = [SOUND, PLAY, ROUGH_SPOT, WARM];

/// An actuator that is what it is declared to be: there is nothing to find. As short as a log may be that
/// decides so.
pub const SOUND: Experiment = Experiment {
    evaluation: Evaluation::Check,
    ..Experiment::new("sound", EMA, &MOTION, 6 * STEPS_PER_SECOND / 5)
};

/// Lost motion before the sensor, an effect that remembers where the motion turned.
pub const PLAY: Experiment = Experiment {
    name: "play",
    peculiarity: Some(Peculiarity::Play(0.05)),
    // One sweep: twenty reversals.
    steps: 2 * STEPS_PER_SECOND,
    ..SOUND
};

/// The same on a drive that drags more forward: what was found first is chosen anew beside the other.
pub const TWO: Experiment = Experiment {
    name: "two",
    actuator: UNDECLARED.actuator,
    ..PLAY
};

/// A spot with half as much friction again: the catalogue has nothing that local.
pub const ROUGH_SPOT: Experiment = Experiment {
    name: "rough_spot",
    peculiarity: Some(Peculiarity::RoughSpot {
        from: 0.1,
        to: 0.2,
        more: 0.5 * EMA.plant.coulomb.forward,
    }),
    ..SOUND
};

/// A winding that is 38 K warmer than its declared resistance, which no fit is told to doubt.
pub const WARM: Experiment = Experiment {
    name: "warm",
    actuator: Parameters {
        drive: Drive::Voltage {
            resistance: 1.15,
            inductance: 1.0e-3,
            torque_constant: 0.06,
        },
        ..EMA.plant
    },
    steps: 2 * STEPS_PER_SECOND,
    ..SOUND
};
