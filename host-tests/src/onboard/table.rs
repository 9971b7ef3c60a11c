//! The answer as a terminal shows it.

use std::fmt::Write as _;

use super::outcome::{Gap, Onboard, Refit};
use crate::image::{RAM, flash};

impl Onboard {
    /// For people.
    pub fn table(&self) -> String {
        let Self {
            parity,
            refit,
            brake,
            gap,
            verdicts,
            instructions_per_step: steps,
            image,
            ..
        } = self;
        let experiments: Vec<String> = parity
            .experiments
            .iter()
            .map(|experiment| format!("{} of {}", experiment.samples, experiment.name))
            .collect();
        let cost = |instructions: u64, seconds: f64, ticks: u32, missed: u32| {
            format!(
                "{:.3e} instructions, {seconds:.2} s at 168 MHz and one a cycle; {ticks} plant ticks \
                 meanwhile, {missed} missed",
                instructions as f64
            )
        };
        let found = |refit: &Refit| {
            format!(
                "{} {} -> {:.5} N·m, really {} ({:+.2} %), {} evaluations of {} samples",
                refit.parameter,
                refit.present,
                refit.estimate,
                refit.truth,
                100.0 * (refit.estimate / refit.truth - 1.0),
                refit.evaluations,
                refit.samples
            )
        };
        let cost_of = |refit: &Refit| {
            cost(
                refit.instructions,
                refit.seconds,
                refit.ticks,
                refit.missed_ticks,
            )
        };
        let checked = |gap: &Gap| {
            let finding = format!(
                "{}: {}: position {:.3} -> {:.3} mrad rms over {} samples",
                gap.experiment,
                gap.names(),
                1e3 * gap.position_rms_before,
                1e3 * gap.position_rms_after,
                gap.samples
            );
            let cost = cost(gap.instructions, gap.seconds, gap.ticks, gap.missed_ticks);
            [("check", finding), ("", cost)]
        };
        let mut rows = vec![
            (
                "parity",
                format!(
                    "{} samples ({}), {} bits differ from this host",
                    parity.samples,
                    experiments.join(", "),
                    parity.differing_bits
                ),
            ),
            ("refit", found(refit)),
            ("", cost_of(refit)),
            ("brake", found(brake)),
            ("", cost_of(brake)),
        ];
        rows.extend([gap].into_iter().chain(verdicts).flat_map(checked));
        rows.extend([
            (
                "evaluations",
                if parity.same_evaluations {
                    "the same numbers as on this host, bit for bit".to_owned()
                } else {
                    "other numbers than on this host".to_owned()
                },
            ),
            (
                "instructions",
                format!(
                    "a step of the actuator {}, of the throttle {}, of the PID {}, of the test bench \
                     {} (averaged) or {} (switching); a sample of the refit {}",
                    steps.ema,
                    steps.throttle,
                    steps.pid,
                    steps.bench,
                    steps.bench_switching,
                    steps.refit_sample
                ),
            ),
            (
                "image",
                format!(
                    "{:.1} of {} KB flash, {:.1} of {} KB RAM ({:.1} KB for the stack, of which {:.1} KB were used)",
                    kilobytes(image.flash_bytes),
                    flash() / 1024,
                    kilobytes(image.ram_bytes),
                    RAM / 1024,
                    kilobytes(image.ram_room_bytes),
                    kilobytes(image.stack_bytes)
                ),
            ),
        ]);
        let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
        rows.iter().fold(String::new(), |mut text, (name, value)| {
            // A string takes everything.
            let _ = writeln!(text, "{name:width$}  {value}");
            text
        })
    }
}

fn kilobytes(bytes: u64) -> f64 {
    bytes as f64 / 1024.0
}
