//! A slide that is pushed by a constant force its machine file does not mention.

use rig::{Effect, EffectKind, Experiment, Machine, Trajectory};

/// What its logs begin with.
pub const HEADER: &str = "time_s,input,position,command";

/// Its log of so many seconds, at 1 kHz.
pub fn log(seconds: f64) -> String {
    let machine = Machine::force_slide();
    let push = Effect::nominal(EffectKind::OffsetTorque, &machine);
    let moves = Trajectory::moves(&machine);
    let log = Experiment::tracking(machine, moves)
        .with_effects(&[push])
        .lasting(seconds)
        .run()
        .to_csv();
    assert!(log.starts_with(HEADER));
    log
}
