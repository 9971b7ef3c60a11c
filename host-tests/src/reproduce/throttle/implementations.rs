//! One model, three implementations (Table 2 of the paper): integrated in double precision, stepped
//! by the core on this host, stepped by the core in the interrupt of the emulated chip.

use std::path::Path;

use firmware::app::replay::Row;
use firmware::app::tape::Driven;
use firmware::app::timing::{PLANT_PERIOD_US, TICKS_PER_CONTROL};
use model_core::plant::parameters::{Drive, Parameters};
use rig::{Motor, Plant, ReturnSpring, Stops};

use super::stand;
use crate::failure::Failure;
use crate::log::Log;
use crate::replay_run::{self, OnBoard};
use crate::toolchain::Toolchain;

/// Plant periods in a sample of the stand.
const TICKS_PER_SAMPLE: u32 = (1e6 / stand::SAMPLE_RATE) as u32 / PLANT_PERIOD_US;

const _: () = assert!(TICKS_PER_SAMPLE == TICKS_PER_CONTROL);

/// Where a free run starts: the first measured position, brought within the stops.
fn start(plant: &Parameters, log: &Log) -> f32 {
    (log.position[0] as f32).clamp(plant.lower_stop, plant.upper_stop)
}

/// The tape of a model driven by the input of a log.
///
/// # Errors
/// A log that does not fit into the board's flash.
pub fn tape(model: &Driven, log: &Log) -> Result<Vec<u8>, Failure> {
    let inputs: Vec<f32> = log.input.iter().map(|&input| input as f32).collect();
    let drive = replay_run::Drive {
        model,
        start: match model {
            Driven::Physical(model) => start(&model.plant, log),
            // It keeps to its limits by itself.
            Driven::PiecewiseAffine(_) => log.position[0] as f32,
        },
        ticks_per_input: TICKS_PER_SAMPLE,
        inputs: &inputs,
    };
    drive.tape()
}

/// The time-continuous model: the rig's integrator in double precision, 2 µs, with the model's
/// parameters and no effect. It shares no code with the core.
pub fn continuous(plant: &Parameters, log: &Log) -> Vec<f64> {
    let motor = match plant.drive {
        Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } => Motor::Winding {
            resistance: resistance.into(),
            inductance: inductance.into(),
            torque_constant: torque_constant.into(),
        },
        Drive::Torque => Motor::Direct { gain: 1.0 },
    };
    let machine = rig::Machine {
        motor,
        inertia: plant.inertia.into(),
        viscous: plant.viscous.forward.into(),
        coulomb: plant.coulomb.forward.into(),
        static_friction: plant.breakaway.forward.into(),
        spring: Some(ReturnSpring {
            stiffness: plant.spring.into(),
            rest: plant.spring_rest.into(),
            preload: plant.spring_preload.into(),
        }),
        stops: Some(Stops {
            lower: plant.lower_stop.into(),
            upper: plant.upper_stop.into(),
        }),
        ..stand::throttle()
    };
    let mut simulated = Plant::new(&machine, &[]);
    simulated.place(start(plant, log).into(), 0.0);
    let gain = f64::from(plant.gain);
    log.input
        .iter()
        .map(|input| {
            let position = simulated.state().position;
            simulated.advance(gain * input, log.period_s);
            position
        })
        .collect()
}

/// Positions of a replay.
pub fn positions(rows: &[Row]) -> Vec<f64> {
    rows.iter().map(|row| f64::from(row.position)).collect()
}

/// Replays the tapes on emulated chips side by side, each left in its file.
///
/// # Errors
/// What [`replay_run::on_board`] returns, of the first board that fails.
pub fn on_boards(toolchain: &Toolchain, tapes: &[(&[u8], &Path)]) -> Result<Vec<OnBoard>, Failure> {
    std::thread::scope(|scope| {
        let boards: Vec<_> = tapes
            .iter()
            .map(|&(tape, file)| scope.spawn(move || replay_run::on_board(toolchain, tape, file)))
            .collect();
        boards
            .into_iter()
            .map(|board| {
                board
                    .join()
                    .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            })
            .collect()
    })
}
