//! What a fit that is told the truth makes of a world: whether there was anything to be seen.
//!
//! Such fits start from the machine's true numbers, so that they do not depend on the declared ones, and are
//! judged on a log under another drive.
//!
//! - Of the catalogue: the refitted model with the true effects over the refitted one without. Of two
//!   effects, each has to be missed: both over either one alone.
//! - Outside the catalogue nothing can be told to a fit. There the same world is played again without the law,
//!   drive, noise and logger alike, and the model is refitted to that: what a model that knew the law would
//!   leave.

use model_core::gap::model::Model;
use model_core::gap::replay::Settings;
use rig::world::{InputRow, Kind, World};

use super::traced::{log_of, machine_of};
use super::truth;
use crate::failure::Failure;
use crate::gap::{declared, engine};
use crate::log::Log;
use crate::machine::Machine;

/// Errors of fits that are told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// Error on the other log without what is told, over the one with it.
    pub ratio: f64,
    /// Windowed position error on the traced log of the fit that is told everything, rad or m.
    pub train: f64,
}

/// The fits of a world; `None` where there is nothing to be told.
///
/// # Errors
/// A file that is refused; a fit that leaves the range.
pub fn told(world: &World, logs: &[Log; 2], settings: Settings) -> Result<Option<Told>, Failure> {
    let machine = true_machine(world)?;
    let errors = |logs: &[Log; 2], model: &Model| {
        engine::refitted_errors(&machine, &logs[..1], &logs[1..], settings, model)
    };
    let mut bare = declared::model(&machine)?;
    if world.sins.input == InputRow::RowLate {
        bare.input_lead = (1.0 / world.rate) as f32;
    }
    match world.kind {
        Kind::None | Kind::NoneWithSins | Kind::Misdeclared => Ok(None),
        Kind::Outside => {
            let (_, without) = errors(logs, &bare)?;
            let clean = [clean_log(world, 0)?, clean_log(world, 1)?];
            let (train, with) = errors(&clean, &bare)?;
            Ok(Some(Told {
                ratio: without / with,
                train,
            }))
        }
        Kind::OneEffect | Kind::TwoEffects => {
            let all: Vec<_> = world
                .laws
                .iter()
                .filter_map(|law| truth::active(law, world))
                .collect();
            let model_with = |left_out: Option<usize>| {
                let mut model = bare.clone();
                for (place, active) in all.iter().enumerate() {
                    if Some(place) != left_out {
                        // Two fit in eight places.
                        let _ = model.effects.push(*active);
                    }
                }
                model
            };
            let (train, with) = errors(logs, &model_with(None))?;
            let mut ratio = f64::INFINITY;
            for place in 0..all.len() {
                // A model that cannot even be fitted without it misses it.
                let without = errors(logs, &model_with(Some(place)));
                ratio = ratio.min(without.map_or(f64::INFINITY, |(_, error)| error / with));
            }
            Ok(Some(Told { ratio, train }))
        }
    }
}

/// The machine file with its fitted numbers right.
fn true_machine(world: &World) -> Result<Machine, Failure> {
    let mut world = world.clone();
    let fit = world.declaration.fit.clone();
    world
        .declaration
        .factors
        .retain(|(name, _)| !fit.contains(name));
    machine_of(&world)
}

/// The log that the machine would have given without its law.
fn clean_log(world: &World, drive: usize) -> Result<Log, Failure> {
    Ok(log_of(world, &world.record_with(drive, &[]), drive)?)
}
