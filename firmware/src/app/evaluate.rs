//! What is made of a log, and what it cost, as lines of the board's log.

use super::check;
use super::experiment::{Evaluation, Experiment};
use super::machine::Machine;
use super::memory::Memory;
use super::refit;
use super::wiring::Wiring;
use crate::board::{Board, Work};

/// What the evaluation is measured by: the processor's work, and the plant's deadlines meanwhile.
struct Before {
    work: Work,
    ticks: u32,
    missed: u32,
}

impl Before {
    fn now<B: Board>(wiring: &Wiring) -> Self {
        Self {
            work: B::work(),
            ticks: wiring.ticks(),
            missed: wiring.missed(),
        }
    }

    fn log<B: Board>(&self, wiring: &Wiring) {
        let now = B::work();
        defmt::info!(
            "cost cycles={=u64} with_interrupts={=u64} ticks={=u32} missed={=u32}",
            now.below_interrupts_since(&self.work),
            now.all - self.work.all,
            wiring.ticks().wrapping_sub(self.ticks),
            wiring.missed() - self.missed
        );
    }
}

/// Evaluates an experiment's log. True if there is a result.
pub fn evaluate<B: Board>(experiment: &Experiment, memory: &Memory, wiring: &Wiring) -> bool {
    let before = Before::now::<B>(wiring);
    let sound = match experiment.evaluation {
        Evaluation::None => return true,
        Evaluation::Refit => refit(&experiment.machine, memory),
        Evaluation::Check => check(&experiment.machine, memory),
    };
    before.log::<B>(wiring);
    sound
}

fn refit(machine: &Machine, memory: &Memory) -> bool {
    let present = machine.plant.coulomb.forward;
    match refit::refit(machine, memory.log(&machine.converters)) {
        Ok(estimate) => {
            defmt::info!(
                "refit parameter=coulomb present={=f32} estimate={=f32} present_cost={=f32} cost={=f32} annealing_evaluations={=u32} golden_section_evaluations={=u32} samples={=usize}",
                present,
                estimate.coulomb,
                estimate.present_cost,
                estimate.cost,
                estimate.annealing_evaluations,
                estimate.golden_section_evaluations,
                memory.samples()
            );
            true
        }
        Err(failed) => {
            defmt::warn!("no refit: {}; coulomb stays {=f32}", failed, present);
            false
        }
    }
}

fn check(machine: &Machine, memory: &Memory) -> bool {
    let finding = match check::check(machine, memory.log(&machine.converters)) {
        Ok(finding) => finding,
        Err(failed) => {
            defmt::warn!("no check: {}; the machine stays as declared", failed);
            return false;
        }
    };
    defmt::info!(
        "check verdict={=str} position_rms_before={=f64} position_rms_after={=f64} simulations={=u64} samples={=usize}",
        finding.verdict.name(),
        finding.before,
        finding.after,
        finding.simulations,
        memory.samples()
    );
    for found in &finding.effects {
        let description = found.effect.id.description();
        defmt::info!(
            "effect id={=str} score={=f32} p_value={=f64}",
            description.id,
            found.score,
            found.p_value
        );
        let named = found.effect.reported().iter().zip(found.reported);
        for ((name, _), value) in named {
            defmt::info!("effect_parameter name={=str} value={=f32}", name, value);
        }
    }
    if let Some(variable) = finding.unknown {
        defmt::info!("unknown depends_on={=str}", variable);
    }
    for (parameter, fitted) in &finding.fitted {
        defmt::info!("fitted name={=str} value={=f32}", parameter.name(), fitted);
    }
    true
}
