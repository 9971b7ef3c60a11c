//! The runs for people, and for programs.

use std::fmt::Write as _;

use serde::Serialize;

use super::recording::Recording;
use super::run::{Counted, FRICTION, Outcome, Ticks, directory};
use super::tracing::{MACHINE, Traced};
use super::unattended::CHIP;
use crate::workspace;

/// The chip's blocks that the images use.
const PERIPHERALS: [&str; 19] = [
    "ADC1", "DAC", "DBGMCU", "DMA2", "DWT", "FLASH", "GPIOA", "GPIOB", "GPIOC", "IWDG", "PWR",
    "RCC", "TIM1", "TIM2", "TIM3", "TIM4", "TIM5", "TIM7", "USART1",
];

/// Core cycles between two plant ticks.
const PERIOD: u64 = 8400;

/// The answer as JSON.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// The images.
    pub target: [&'static str; 2],
    /// What ran them.
    pub chip: Chip,
    /// What came of the loop of both.
    pub r#loop: Loop,
}

/// What ran the images.
#[derive(Debug, Serialize)]
pub struct Chip {
    /// The emulator.
    pub emulator: &'static str,
    /// Cycles that an instruction is taken to last.
    pub cycles_per_instruction: f64,
    /// Of each image: in the loop, with its faults, and the throttle at an engine control unit, as far as that was run.
    pub worst_ticks: [WorstTick; 2],
    /// The same at other cycles an instruction, the throttle with each of its faults, and of the images that nobody
    /// operates, as far as those were run.
    pub at_other_cycles: Vec<AtCycles>,
    /// The chip's blocks that the images use.
    pub peripherals: [&'static str; 19],
}

/// The longest interrupts that an image saw, core cycles.
#[derive(Debug, Serialize)]
pub struct WorstTick {
    /// Which.
    pub image: &'static str,
    /// The plant interrupt.
    pub plant_cycles: Option<u64>,
    /// The control interrupt, with the plant interrupts within it.
    pub control_cycles: Option<u64>,
    /// From a plant tick to the next.
    pub period_cycles: u64,
    /// From a plant tick to its acknowledgement, µs.
    pub longest_latency_us: f64,
    /// Plant ticks that the program missed.
    pub missed: u64,
}

/// The longest interrupts of an image at other cycles an instruction.
#[derive(Debug, Serialize)]
pub struct AtCycles {
    /// The image, with what it was told.
    pub image: String,
    /// Cycles that an instruction is taken to last.
    pub cycles_per_instruction: f64,
    /// The plant interrupt.
    pub plant_cycles: Option<u64>,
    /// The control interrupt, with the plant interrupts within it.
    pub control_cycles: Option<u64>,
    /// From a plant tick to its acknowledgement, µs, where it was measured.
    pub longest_latency_us: Option<f64>,
    /// Plant ticks that the program missed.
    pub missed: u64,
    /// Bytes of the stack that were used, and those that there are, where that was measured.
    pub stack_bytes: Option<[u64; 2]>,
}

impl AtCycles {
    fn new(ticks: &Ticks) -> Self {
        let [plant_cycles, control_cycles] = worst(&ticks.status);
        Self {
            image: ticks.image.clone(),
            cycles_per_instruction: ticks.cycles_per_instruction,
            plant_cycles,
            control_cycles,
            longest_latency_us: Some(ticks.longest_latency_us),
            missed: ticks.missed,
            stack_bytes: Some(ticks.stack_bytes),
        }
    }

    /// Its row of the table for people: name and value.
    pub fn row(&self) -> [String; 2] {
        let latency = self.longest_latency_us.map_or(String::new(), |latency| {
            format!(", longest latency {latency:.1} µs")
        });
        let stack = self.stack_bytes.map_or(String::new(), |[used, room]| {
            format!("; {used} of {room} bytes of stack")
        });
        [
            format!("{} at {}", self.image, self.cycles_per_instruction),
            format!(
                "worst plant tick {} and control step {} of {PERIOD} cycles{latency}; {} ticks missed{stack}",
                shown(self.plant_cycles),
                shown(self.control_cycles),
                self.missed,
            ),
        ]
    }
}

/// What the controller's own log lacks.
#[derive(Debug, Serialize)]
pub struct Loop {
    /// As in the answer of `cargo hil gap`.
    pub verdict: &'static str,
    /// Ids of the effects.
    pub effects: Vec<String>,
    /// On the drive that nothing was fitted to, rad.
    pub position_rms_before: Option<f64>,
    /// With what was found.
    pub position_rms_after: Option<f64>,
    /// Rows of all captures.
    pub samples: usize,
}

/// A line of the table for people.
pub fn line(name: &str, value: &str) -> String {
    format!("{name:<18} {value}")
}

fn shown(cycles: Option<u64>) -> String {
    cycles.map_or("?".to_owned(), |cycles| cycles.to_string())
}

/// What `status` says of the longest plant and control interrupt, cycles.
fn worst(status: &str) -> [Option<u64>; 2] {
    let Some((_, rest)) = status.split_once("worst plant ") else {
        return [None; 2];
    };
    let mut numbers = rest
        .split(|character: char| !character.is_ascii_digit())
        .filter(|word| !word.is_empty())
        .map(|word| word.parse().ok());
    [numbers.next().flatten(), numbers.next().flatten()]
}

impl Summary {
    /// Of runs and their tracing.
    pub fn new(outcome: &Outcome, traced: &Traced, cycles_per_instruction: f64) -> Self {
        let worst_tick = |image, statuses: &[&str], counted: &Counted| {
            let worst = |interrupt: usize| {
                let seen = statuses.iter().map(|status| worst(status)[interrupt]);
                seen.max().flatten()
            };
            let (plant_cycles, control_cycles) = (worst(0), worst(1));
            WorstTick {
                image,
                plant_cycles,
                control_cycles,
                period_cycles: PERIOD,
                longest_latency_us: counted.longest_latency_us,
                missed: counted.plant_ticks_missed,
            }
        };
        let driven = &outcome.driven;
        let engine = outcome.engine.iter().flatten();
        let mut throttle: Vec<&str> = engine.map(|engine| &*engine.status).collect();
        throttle.extend([
            &*driven.throttle_status,
            &outcome.throttle.status_with_motor_open,
        ]);
        let faults = outcome.faults.iter().flat_map(|faults| &faults.faults);
        let mut controller: Vec<&str> = faults.map(|fault| &*fault.status).collect();
        controller.push(&driven.controller_status);
        let errors = traced.report.outcome.errors.validate.as_ref();
        Self {
            target: ["throttle", "controller"],
            chip: Chip {
                emulator: CHIP,
                cycles_per_instruction,
                worst_ticks: [
                    worst_tick("throttle", &throttle, &driven.throttle),
                    worst_tick("controller", &controller, &driven.controller),
                ],
                at_other_cycles: outcome.ticks.iter().flatten().map(AtCycles::new).collect(),
                peripherals: PERIPHERALS,
            },
            r#loop: Loop {
                verdict: traced.report.outcome.verdict.name(),
                effects: traced
                    .report
                    .outcome
                    .effects
                    .iter()
                    .map(|e| e.id.clone())
                    .collect(),
                position_rms_before: errors.map(|errors| errors.before.position_rms),
                position_rms_after: errors.map(|errors| errors.after.position_rms),
                samples: traced.samples,
            },
        }
    }

    /// For people.
    pub fn text(
        &self,
        outcome: &Outcome,
        traced: &Traced,
        recording: Option<&Recording>,
    ) -> String {
        let mut text = format!(
            "Two unmodified images on emulated STM32F405s, {} cycles an instruction\n",
            self.chip.cycles_per_instruction
        );
        // A string takes everything.
        let mut row = |name: &str, value: String| {
            let _ = writeln!(text, "{}", line(name, &value));
        };
        for tick in &self.chip.worst_ticks {
            row(
                tick.image,
                format!(
                    "worst plant tick {} and control step {} of {} cycles, longest latency \
                     {:.1} µs; {} ticks missed",
                    shown(tick.plant_cycles),
                    shown(tick.control_cycles),
                    tick.period_cycles,
                    tick.longest_latency_us,
                    tick.missed
                ),
            );
        }
        for tick in &self.chip.at_other_cycles {
            let [name, value] = tick.row();
            row(&name, value);
        }
        let [erased, programmed, _] = outcome.store.flash;
        row(
            "save",
            format!(
                "{erased} sectors erased, {programmed} words programmed, read back after an end of power"
            ),
        );
        row(
            "power",
            format!(
                "lost after {} words of a second save: the values of the first are there",
                outcome.store.torn_after_words
            ),
        );
        for (cuts, save) in outcome
            .cuts
            .iter()
            .flatten()
            .zip(["first save", "second save"])
        {
            row(
                save,
                format!(
                    "power lost {} times in its {} operations of flash: {} starts with the values before it, {} \
                     behind it; {} latch `store_corrupt`",
                    cuts.starts, cuts.operations, cuts.before, cuts.behind, cuts.named
                ),
            );
        }
        if let Some(healthy) = &outcome.healthy {
            row(
                "healthy",
                format!(
                    "{:.0} s and {} commands of the sound loop: {} faults, {} ticks missed",
                    healthy.controller.time_s,
                    healthy.commands,
                    healthy.unsound.len(),
                    healthy.controller.plant_ticks_missed + healthy.throttle.plant_ticks_missed
                ),
            );
        }
        for fault in outcome.any_time.iter().flatten() {
            let named: Vec<String> = fault
                .named
                .iter()
                .map(|(name, times)| format!("{name} {times} times"))
                .collect();
            row(
                "any time",
                format!(
                    "{}, {} runs: bridge off after {:.2} ms at most; {}",
                    fault.fault,
                    fault.runs,
                    1e-3 * fault.latest_us,
                    named.join(", ")
                ),
            );
        }
        for fault in outcome.faults.iter().flat_map(|faults| &faults.faults) {
            let name = fault.faults.split_once("first: ").map_or("?", |(_, rest)| {
                rest.split_whitespace().next().unwrap_or("?")
            });
            row(
                name,
                format!(
                    "{}: bridge off after {:.2} ms",
                    fault.fault,
                    fault.let_go_after_us.map_or(f64::NAN, |after| after * 1e-3)
                ),
            );
        }
        if let Some(controller) = &outcome.controller {
            row(
                "encoder",
                format!(
                    "{} spikes of 0.3 µs count nothing, {} edges at two million a second all",
                    controller.spikes, controller.edges
                ),
            );
            row(
                "clock",
                format!(
                    "off by {:.0} ms after a save of {:.0} ms",
                    controller.clock_lost_ms.abs(),
                    controller.save_ms
                ),
            );
        }
        for engine in outcome.engine.iter().flatten() {
            let found = engine.found.iter().filter(|found| found.code.is_some());
            let slowest = found.clone().max_by_key(|found| found.after_ms);
            row(
                &format!("engine at {} Hz", engine.pwm_hz),
                format!(
                    "learned in {:.2} s; {:.1} % of the stroke off behind steps, {:.1} % on a ramp; {} of {} \
                     faults found, the last one, {}, after {} ms",
                    engine.learned_after_s,
                    100.0
                        * engine
                            .settled
                            .iter()
                            .fold(0.0, |worst: f64, error| worst.max(error.abs())),
                    100.0 * engine.following,
                    found.count(),
                    engine.found.len(),
                    slowest.map_or("none", |found| &found.fault),
                    slowest.map_or(0, |found| found.after_ms)
                ),
            );
        }
        row(
            "watchdog",
            format!(
                "reset {:.1} ms after the last tick, and named",
                outcome.throttle.reset_after_ms
            ),
        );
        for (command, target, position) in &outcome.driven.positions {
            row(
                command,
                format!("to {target:.3} rad; it is at {position:.3}"),
            );
        }
        let effects = self.r#loop.effects.join(", ");
        let milliradian = |value: Option<f64>| value.map_or(f64::NAN, |value| value * 1e3);
        row(
            "log",
            format!(
                "{} samples of the controller's own: {}, {effects}; position error on the other drive {:.1} \
                 before, {:.2} mrad rms after",
                self.r#loop.samples,
                self.r#loop.verdict,
                milliradian(self.r#loop.position_rms_before),
                milliradian(self.r#loop.position_rms_after)
            ),
        );
        if let Some(recording) = recording {
            row(
                "record",
                format!(
                    "{} rows over the controller's console at a pseudo-terminal: {}; it leaves {:.1} % of the position \
                     error on {} more at a debug probe",
                    recording.rows[0],
                    recording.effects.join(", "),
                    100.0 * recording.remaining,
                    recording.rows[1]
                ),
            );
        }
        row(
            "friction",
            format!(
                "{:.4} N·m, estimated by the controller from its own log; it grew from {} to {}",
                outcome.driven.friction().unwrap_or(f64::NAN),
                FRICTION[0],
                FRICTION[1]
            ),
        );
        row("took", format!("{:.0} s", outcome.wall_time_s));
        row("files", workspace::shown(&directory()));
        let with = |option: &str, paths: &[std::path::PathBuf]| -> String {
            paths
                .iter()
                .map(|path| format!(" {option} {}", workspace::shown(path)))
                .collect()
        };
        let _ = writeln!(
            text,
            "\ncargo hil gap --machine {MACHINE}{}{}",
            with("--train", &traced.train),
            with("--validate", &traced.validate)
        );
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_interrupts_are_read_from_a_status() {
        let status = "latched: none\nworst plant 1887, control 1168 cycles; deadlines missed: 0\n";
        assert_eq!(worst(status), [Some(1887), Some(1168)]);
        assert_eq!(worst("armed"), [None; 2]);
    }
}
