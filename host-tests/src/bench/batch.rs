//! Throughput of many actuators with different parameters, in the widest vectors that this processor
//! has.

use std::hint::black_box;

use model_core::plant::actuator::Actuator;
use model_core::plant::batch::Batch;
use model_core::plant::modes::{Basis, Modes};
use model_core::plant::parameters::Parameters;
use model_core::plant::{Directional, InputRefused, State};
use rayon::prelude::*;
use serde::Serialize;

use super::{EMA, Extent, STEP_S, best, fault, pool, sweep};
use crate::failure::Failure;
use crate::vectors::Vectors;

/// Actuators in a batch.
const LANES: usize = 64;

/// What was measured.
#[derive(Debug, Clone, Serialize)]
pub struct Throughput {
    /// Threads that share the work.
    pub cores: usize,
    /// Steps of all actuators in a wall-clock second, all cores.
    pub steps_per_second: f64,
    /// The same on one core.
    pub steps_per_second_one_core: f64,
    /// The same on one core, one actuator after the other.
    pub steps_per_second_one_by_one: f64,
    /// Vectors of the processor that were used.
    pub vectors: &'static str,
}

/// Steps a batch through the inputs, the same for every lane.
fn run(
    vectors: Vectors,
    batch: &mut Batch<&Modes, LANES>,
    inputs: &[f32],
) -> Result<(), InputRefused> {
    match vectors {
        Vectors::Baseline => follow(batch, inputs),
        // SAFETY: only `Vectors` makes it, where the processor has it.
        #[cfg(target_arch = "x86_64")]
        Vectors::Avx2(_) => unsafe { follow_avx2(batch, inputs) },
        // SAFETY: as above, each feature of the function.
        #[cfg(target_arch = "x86_64")]
        Vectors::Avx512(_) => unsafe { follow_avx512(batch, inputs) },
    }
}

#[inline(always)]
fn follow(batch: &mut Batch<&Modes, LANES>, inputs: &[f32]) -> Result<(), InputRefused> {
    // A closure would be a function of its own, without the vectors.
    for &input in inputs {
        batch.step(&[input; LANES])?;
    }
    Ok(())
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn follow_avx2(batch: &mut Batch<&Modes, LANES>, inputs: &[f32]) -> Result<(), InputRefused> {
    follow(batch, inputs)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw")]
fn follow_avx512(batch: &mut Batch<&Modes, LANES>, inputs: &[f32]) -> Result<(), InputRefused> {
    follow(batch, inputs)
}

/// So many actuators with different inertias and frictions, and the modes of each.
fn actuators(count: usize) -> Result<Vec<(Parameters, Modes)>, Failure> {
    (0..count)
        .map(|index| {
            let share = index as f32 / count as f32;
            let parameters = Parameters {
                inertia: EMA.inertia * (0.5 + share),
                coulomb: Directional::both(0.15 * share),
                ..EMA
            };
            let modes = Modes::build(&Basis::new(&parameters, STEP_S as f32)).map_err(fault)?;
            Ok((parameters, modes))
        })
        .collect()
}

/// Batches of them at rest.
fn batches(actuators: &[(Parameters, Modes)]) -> Result<Vec<Batch<&Modes, LANES>>, Failure> {
    let lanes = actuators
        .iter()
        .map(|(parameters, modes)| Actuator::with_modes(parameters, modes).map_err(fault))
        .collect::<Result<Vec<_>, _>>()?;
    let (batches, rest) = lanes.as_chunks::<LANES>();
    debug_assert!(rest.is_empty(), "a number of actuators that fills batches");
    let at_rest = [State::default(); LANES];
    Ok(batches
        .iter()
        .map(|&lanes| Batch::new(lanes, at_rest))
        .collect())
}

/// Steps many actuators with different inertias and frictions through a sweep.
pub(super) fn measure(extent: Extent) -> Result<Throughput, Failure> {
    let inputs = sweep(f64::min(extent.sweep_s, 1.0), STEP_S);
    let actuators = actuators(extent.actuators)?;
    let batches = batches(&actuators)?;
    let vectors = Vectors::widest();
    let work = || {
        batches.par_iter().try_for_each(|batch| {
            let mut batch = batch.clone();
            run(vectors, &mut batch, black_box(&inputs)).map_err(fault)?;
            black_box(batch.state(0));
            Ok(())
        })
    };
    let one_by_one = || {
        actuators.iter().try_for_each(|(parameters, modes)| {
            let actuator = Actuator::with_modes(parameters, modes).map_err(fault)?;
            let mut state = State::default();
            for &input in black_box(&inputs) {
                actuator.step(&mut state, input).map_err(fault)?;
            }
            black_box(state);
            Ok(())
        })
    };
    let steps = (actuators.len() * inputs.len()) as f64;
    let (all, ()) = best(extent.long_runs, work)?;
    let one_core = pool(1)?;
    let (one, ()) = best(extent.long_runs, || one_core.install(work))?;
    let (alone, ()) = best(extent.long_runs, one_by_one)?;
    Ok(Throughput {
        cores: rayon::current_num_threads(),
        steps_per_second: steps / all,
        steps_per_second_one_core: steps / one,
        steps_per_second_one_by_one: steps / alone,
        vectors: vectors.name(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_bit_depends_on_the_vectors() {
        let inputs = sweep(1.0, STEP_S);
        let actuators = actuators(LANES).unwrap();
        let alone: Vec<String> = actuators
            .iter()
            .map(|(parameters, modes)| {
                let actuator = Actuator::with_modes(parameters, modes).unwrap();
                let mut state = State::default();
                for &input in &inputs {
                    actuator.step(&mut state, input).unwrap();
                }
                // The shortest digits that give every bit back.
                format!("{state:?}")
            })
            .collect();
        for vectors in Vectors::present() {
            let mut batch = batches(&actuators).unwrap().remove(0);
            run(vectors, &mut batch, &inputs).unwrap();
            for (lane, alone) in alone.iter().enumerate() {
                assert_eq!(
                    &format!("{:?}", batch.state(lane)),
                    alone,
                    "{vectors:?} {lane}"
                );
            }
        }
    }
}
