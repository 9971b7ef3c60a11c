//! Computing for a simulated second (ch. 6.4), of both fidelities, here and on the chip.
//!
//! On this host a run is timed several times and the median is shown. On the chip the emulator
//! counts the instructions of a period of the control, exactly; `cargo hil test` keeps the counts
//! next to the program that they are of. They are taken at one instruction a cycle of 168 MHz.

use std::collections::BTreeMap;
use std::hint::black_box;
use std::time::Instant;

use model_core::plant::bench::averaged::Averaged;
use model_core::plant::bench::electrics::Electrics;
use model_core::plant::bench::switching::Switching;
use model_core::plant::bench::{Bench, Parameters};

use super::reconstruction::Sine;
use super::section::{Part, Section};
use crate::cells::{Cells, row};
use crate::failure::Failure;
use crate::figures::Figures;
use crate::reproduce::entry;

/// The paper's model: mean and standard deviation over its fifteen points, s for a simulated second.
const PAPER: (f64, f64) = (8.48, 2.09);

/// The chip's clock, Hz.
const CLOCK: f64 = 168e6;

/// Instructions by compiler and name, as counted on the emulated chip.
const COUNTS: &str = include_str!("../../../../firmware/src/bin/on_target.toml");

/// Runs of which the median is shown.
const RUNS: usize = 5;

/// Cost of a fidelity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Steps in a simulated second.
    pub steps: f64,
    /// Seconds of computing on this host for one simulated: the median of the runs.
    pub host: f64,
    /// On the chip: instructions of a period of the control, and seconds for one simulated.
    pub chip: (u64, f64),
}

/// Instructions by name. They are those of the file's first compiler: where several left some, they
/// are of the same program.
fn counts() -> Figures {
    let tables: BTreeMap<String, Figures> =
        toml::from_str(COUNTS).expect("the counts are part of the program");
    tables.into_values().next().unwrap_or_default()
}

/// The cost of a model under the paper's command, with friction, over so many seconds a run.
///
/// # Errors
/// Parameters that the core does not take; counts that are not there.
pub fn measure<E: Electrics>(
    parameters: &Parameters,
    seconds: f64,
    count: &str,
) -> Result<Cost, Failure> {
    let command = Sine {
        amplitude: 10.0_f64.to_radians(),
        frequency: 0.1,
        phase: 0.0,
    };
    let period = f64::from(parameters.control.period);
    let periods = (seconds / period).round() as usize;
    let mut runs = Vec::new();
    for _ in 0..RUNS {
        let mut bench = Bench::<E>::build(parameters)
            .map_err(|error| Failure::other(format!("the bench is refused: {error}")))?;
        bench.set_brake(0.32325);
        let started = Instant::now();
        for tick in 0..periods {
            let step = bench.step(command.at(tick as f64 * period) as f32);
            black_box(step).map_err(|error| Failure::other(error.to_string()))?;
        }
        runs.push(started.elapsed().as_secs_f64() / seconds);
    }
    runs.sort_by(f64::total_cmp);
    let missing = || Failure::other(format!("no instructions of {count} are counted"));
    let instructions = counts().get(count).copied().ok_or_else(missing)?;
    Ok(Cost {
        steps: f64::from(parameters.steps) / period,
        host: runs[RUNS / 2],
        chip: (instructions, instructions as f64 / period / CLOCK),
    })
}

/// What is shown of the cost.
pub(super) fn section() -> Result<Section, Failure> {
    let switching = measure::<Switching>(&Parameters::SWITCHING, 1.0, "bench_switching_period")?;
    let averaged = measure::<Averaged>(&Parameters::AVERAGED, 10.0, "bench_averaged_period")?;
    let finding = format!(
        "For a simulated second this host computes {} s by the switching model and {} s by the averaged \
         one, {:.0} and {:.0} times less than the paper's; the chip runs the averaged one in real time \
         with {:.0} % of its clock.",
        short(switching.host),
        short(averaged.host),
        PAPER.0 / switching.host,
        PAPER.0 / averaged.host,
        100.0 * averaged.chip.1
    );
    let mut entries = Vec::new();
    for (name, cost) in [("switching", &switching), ("averaged", &averaged)] {
        for (place, seconds) in [("host", cost.host), ("chip", cost.chip.1)] {
            let what = format!("computing for a simulated second, {name}, {place}");
            entries.push(entry(&what, Some(PAPER.0), seconds, None, "s"));
        }
    }
    Ok(Section {
        title: "Cost of a simulated second",
        finding,
        parts: vec![
            Part::Table(
                "Seconds of computing for a simulated second".to_owned(),
                cells(&switching, &averaged),
            ),
            Part::Note(format!(
                "Paper: mean and standard deviation of its fifteen points, a Simulink model in steps of \
                 1 µs. Host: one core, median of {RUNS} runs. Chip: instructions that the emulated \
                 board counts, at one a cycle of 168 MHz. Every step costs the same, so that the cost \
                 is linear in the simulated time."
            )),
        ],
        entries,
    })
}

fn cells(switching: &Cost, averaged: &Cost) -> Cells {
    let mut cells = vec![row([
        "model",
        "steps a second",
        "this host, s",
        "chip, instructions a period",
        "chip, s",
    ])];
    cells.push(row([
        "paper, switching",
        "1000000",
        &format!("{} ± {}", PAPER.0, PAPER.1),
        "",
        "",
    ]));
    for (name, cost) in [("switching", switching), ("averaged", averaged)] {
        cells.push(vec![
            name.to_owned(),
            format!("{:.0}", cost.steps),
            short(cost.host),
            cost.chip.0.to_string(),
            short(cost.chip.1),
        ]);
    }
    cells
}

/// Three significant digits.
fn short(seconds: f64) -> String {
    let digits = (2.0 - seconds.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{seconds:.digits$}")
}
