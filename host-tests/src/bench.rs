//! `cargo hil bench`: speed on this host.
//!
//! Each number is the best of several runs: the others only add what else the host was doing.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::hint::black_box;
use std::io::{self, IsTerminal};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use firmware::app::machine;
use indicatif::ProgressBar;
use model_core::control::pid;
use model_core::effect::{Active, Id};
use model_core::gap::log::{Channel, Log as CoreLog};
use model_core::gap::replay::WINDOW;
use model_core::gap::simulator::{Course, Given};
use model_core::identify::friction;
use model_core::plant::State;
use model_core::plant::actuator::{Actuator, External};
use model_core::plant::bench::averaged::Averaged;
use model_core::plant::bench::electrics::Electrics;
use model_core::plant::bench::switching::Switching;
use model_core::plant::bench::{self as test_bench, Bench};
use model_core::plant::karnopp::{self, Karnopp};
use model_core::plant::parameters::Parameters;
use rayon::ThreadPoolBuilder;
use serde::Serialize;

use batch::Throughput;
use tracing::Tracing;

use crate::failure::Failure;
use crate::gap::{declared, engine};
use crate::log::Log;
use crate::machine::{Coordinate, Friction, Machine, Mechanics, Motor};
use crate::outputs::{Kind, Outputs, print};
use crate::quantity::decimal;
use crate::{gap_benchmark, real_benchmark};

pub mod batch;
pub mod tracing;

/// What `cargo hil bench` takes.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    /// What else may be measured
    #[command(subcommand)]
    pub what: Option<What>,
    /// Write the result to this file as JSON
    #[arg(long, value_name = "F")]
    pub json: Option<PathBuf>,
    /// Measure shorter signals, once: a first impression within seconds
    #[arg(long)]
    pub quick: bool,
}

/// What may be measured beside the speed.
#[derive(Debug, clap::Subcommand)]
pub enum What {
    /// How often the tracing is right, on machines whose effects are known
    #[command(
        after_help = "Examples: cargo hil bench gap --json bench-gap.json\n          cargo hil bench gap --worlds 200 --json worlds.json"
    )]
    Gap(gap_benchmark::Args),
    /// The tracing on logs that other people measured on their machines
    #[command(after_help = "Example: cargo hil bench real --json bench-real.json")]
    Real(real_benchmark::Args),
}

/// The answer, serialised as it stands. Keys beyond the contract are additions.
#[derive(Debug, Clone, Serialize)]
pub struct Outcome {
    /// One core, one actuator.
    pub plants: Vec<PlantSpeed>,
    /// Coulomb friction from a log.
    pub refit: Refit,
    /// `cargo hil gap` without its files.
    pub gap: Gap,
    /// The same of logs of other machines, and of what costs more to find.
    pub tracings: Vec<Tracing>,
    /// Many actuators at once.
    pub batch: Throughput,
}

/// Speed of one plant.
#[derive(Debug, Clone, Serialize)]
pub struct PlantSpeed {
    /// `ema`, `throttle` and `bench` are the core's; `ema_…` and `bench_…` are other ways to simulate
    /// the first and the last.
    pub name: &'static str,
    /// Step, s.
    pub step_s: f64,
    /// Wall-clock nanoseconds for one step.
    pub ns_per_step: f64,
    /// Wall-clock seconds for one simulated second.
    pub seconds_per_simulated_second: f64,
}

/// Cost of finding the Coulomb friction: simulated annealing, polished by golden section.
#[derive(Debug, Clone, Serialize)]
pub struct Refit {
    /// Wall-clock seconds, one core.
    pub seconds: f64,
    /// Replays of the log.
    pub evaluations: u32,
    /// Simulated seconds in all of them.
    pub simulated_seconds: f64,
    /// What was found, N·m.
    pub coulomb: f64,
    /// What the log was made with, N·m.
    pub truth: f64,
}

/// Cost of tracing one missing effect.
#[derive(Debug, Clone, Serialize)]
pub struct Gap {
    /// Wall-clock seconds, all cores.
    pub seconds: f64,
    /// Wall-clock seconds on one core.
    pub seconds_one_core: f64,
    /// Replays of the whole log.
    pub simulations: u64,
    /// Samples of the log.
    pub samples: usize,
    /// Effects found; the log has `asymmetric_viscous`.
    pub found: Vec<String>,
}

/// How much is measured.
#[derive(Debug, Clone, Copy)]
struct Extent {
    /// Simulated time of the sweeps, s.
    sweep_s: f64,
    /// Length of the log that the friction is found from, s.
    refit_s: f64,
    /// Length of the log that is traced, s.
    gap_s: f64,
    /// Runs of what takes milliseconds.
    short_runs: u32,
    /// Runs of what takes a good part of a second.
    long_runs: u32,
    /// Runs of the tracing.
    gap_runs: u32,
    /// Logs that are traced besides, on each machine.
    traced: usize,
    /// Actuators of the batch.
    actuators: usize,
}

const FULL: Extent = Extent {
    sweep_s: 10.0,
    refit_s: 10.0,
    gap_s: 24.0,
    short_runs: 30,
    long_runs: 3,
    gap_runs: 2,
    traced: tracing::EFFECTS.len(),
    actuators: 4096,
};

const QUICK: Extent = Extent {
    sweep_s: 1.0,
    refit_s: 2.0,
    gap_s: 4.0,
    short_runs: 3,
    long_runs: 1,
    gap_runs: 1,
    traced: 2,
    actuators: 256,
};

/// Step of the plants, and hold of their input, s.
const STEP_S: f64 = 1e-4;

/// Step of the Karnopp scheme, s.
const KARNOPP_STEP_S: f64 = 1e-6;

/// Step of the reference integrator, s.
const REFERENCE_STEP_S: f64 = 1e-5;

/// Half the width of Karnopp's velocity band: a thousandth of the top speed, rad/s.
const BAND: f32 = 0.15;

/// Sampling period of the logs, s.
const SAMPLING_S: f64 = 1e-3;

/// The board's actuator in free travel, its friction no higher at breakaway.
const EMA: Parameters = Parameters {
    breakaway: machine::EMA.plant.coulomb,
    lower_stop: f32::NEG_INFINITY,
    upper_stop: f32::INFINITY,
    ..machine::EMA.plant
};

/// The board's throttle.
const THROTTLE: Parameters = machine::THROTTLE.plant;

/// Measures, prints the table, writes what was asked for.
///
/// # Errors
/// A result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    match &args.what {
        Some(What::Gap(args)) => return gap_benchmark::run(args),
        Some(What::Real(args)) => return real_benchmark::run(args),
        None => (),
    }
    let mut outputs = Outputs::reading([]);
    outputs.fills(&tracing::directory());
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    let extent = if args.quick { QUICK } else { FULL };
    let progress = if io::stderr().is_terminal() {
        ProgressBar::new_spinner()
    } else {
        ProgressBar::hidden()
    };
    // The spinner's own thread wakes ten times a second: nothing beside what is measured.
    progress.enable_steady_tick(Duration::from_millis(100));
    let outcome = measure(extent, |message| progress.set_message(message));
    progress.finish_and_clear();
    let outcome = outcome?;
    outputs.stage_json(json, &outcome)?;
    outputs.commit()?;
    print(&table(&outcome))
}

fn measure(extent: Extent, mut progress: impl FnMut(&'static str)) -> Result<Outcome, Failure> {
    progress("plants");
    let plants = plants(extent)?;
    progress("friction refit");
    let refit = refit(extent)?;
    progress("gap");
    let gap = gap(extent)?;
    progress("tracings");
    let tracings = tracing::measure(extent)?;
    progress("batch");
    let batch = batch::measure(extent)?;
    Ok(Outcome {
        plants,
        refit,
        gap,
        tracings,
        batch,
    })
}

/// Shortest time of several runs, s, and what the last one gave.
fn best<R>(runs: u32, mut work: impl FnMut() -> Result<R, Failure>) -> Result<(f64, R), Failure> {
    let mut timed = || {
        let started = Instant::now();
        let result = black_box(work()?);
        Ok::<_, Failure>((started.elapsed().as_secs_f64(), result))
    };
    let (mut shortest, mut last) = timed()?;
    for _ in 1..runs {
        let (seconds, result) = timed()?;
        shortest = f64::min(shortest, seconds);
        last = result;
    }
    Ok((shortest, last))
}

/// What the core refuses here is a fault of the benchmark itself.
fn fault(error: impl std::fmt::Display) -> Failure {
    Failure::other(format!("the benchmark's own machine is refused: {error}"))
}

/// The sweep, 0.2 to 5 Hz over 10 s with 12 V, at the beginning of each hold.
fn sweep(seconds: f64, hold_s: f64) -> Vec<f32> {
    let count = (seconds / hold_s).round() as usize;
    (0..count)
        .map(|index| {
            let time = index as f64 * hold_s;
            let cycles = 0.2 * time + 0.5 * (5.0 - 0.2) / 10.0 * time * time;
            (12.0 * (TAU * cycles).sin()) as f32
        })
        .collect()
}

fn plants(extent: Extent) -> Result<Vec<PlantSpeed>, Failure> {
    let inputs = sweep(extent.sweep_s, STEP_S);
    let speed = |name, step_s: f64, seconds: f64| PlantSpeed {
        name,
        step_s,
        ns_per_step: seconds / (extent.sweep_s / step_s) * 1e9,
        seconds_per_simulated_second: seconds / extent.sweep_s,
    };
    let (ema, _) = best(extent.short_runs, || {
        exact(&EMA, 0.0, black_box(&inputs)).map_err(fault)
    })?;
    let (throttle, _) = best(extent.short_runs, || {
        exact(&THROTTLE, THROTTLE.spring_rest, black_box(&inputs)).map_err(fault)
    })?;
    let (euler, _) = best(extent.long_runs, || {
        euler(&EMA, black_box(&inputs)).map_err(fault)
    })?;
    let (reference, _) = best(extent.long_runs, || Ok(reference(black_box(&inputs))))?;
    let averaged = &test_bench::Parameters::AVERAGED;
    let (bench, _) = best(extent.short_runs, || {
        follow::<Averaged>(averaged, extent.sweep_s).map_err(fault)
    })?;
    let switching = &test_bench::Parameters::SWITCHING;
    let (switched, _) = best(extent.long_runs, || {
        follow::<Switching>(switching, extent.sweep_s).map_err(fault)
    })?;
    let bench_step = |parameters: &test_bench::Parameters| {
        f64::from(parameters.control.period) / f64::from(parameters.steps)
    };
    Ok(vec![
        speed("ema", STEP_S, ema),
        speed("throttle", STEP_S, throttle),
        speed("ema_karnopp_1us", KARNOPP_STEP_S, euler),
        speed("ema_reference_f64", REFERENCE_STEP_S, reference),
        speed("bench", bench_step(averaged), bench),
        speed("bench_switching_1us", bench_step(switching), switched),
    ])
}

/// Last position of the test bench after so many seconds of its paper's command, 10° at 0.1 Hz.
fn follow<E: Electrics>(
    parameters: &test_bench::Parameters,
    seconds: f64,
) -> Result<f64, Box<dyn std::error::Error>> {
    let mut bench = Bench::<E>::build(parameters)?;
    let period = f64::from(parameters.control.period);
    for tick in 0..(seconds / period).round() as usize {
        let phase = 0.1 * TAU * tick as f64 * period;
        bench.step((10.0_f64.to_radians() * phase.sin()) as f32)?;
    }
    Ok(f64::from(bench.encoder().angle()))
}

/// Last position after the inputs, by the core's exact steps.
fn exact(
    parameters: &Parameters,
    position: f32,
    inputs: &[f32],
) -> Result<f64, Box<dyn std::error::Error>> {
    let actuator = Actuator::build(parameters, STEP_S as f32)?;
    let mut state = State::new(position, 0.0);
    for &input in inputs {
        actuator.step(&mut state, input)?;
    }
    Ok(f64::from(state.position.value()))
}

/// Last position after the inputs, by the core's Karnopp scheme.
fn euler(parameters: &Parameters, inputs: &[f32]) -> Result<f64, Box<dyn std::error::Error>> {
    let scheme = Karnopp::build(parameters, KARNOPP_STEP_S as f32, BAND)?;
    let parts = (STEP_S / KARNOPP_STEP_S).round() as usize;
    let mut state = karnopp::State::default();
    for &input in inputs {
        for _ in 0..parts {
            scheme.step(&mut state, input)?;
        }
    }
    Ok(f64::from(state.position))
}

/// Last position of [`EMA`] after the inputs, by the fourth-order Runge–Kutta rule in `f64`, the
/// direction of friction held over a step: shares neither code nor method with the core.
fn reference(inputs: &[f32]) -> f64 {
    const H: f64 = REFERENCE_STEP_S;
    let parts = (STEP_S / H).round() as usize;
    let rates = |[current, velocity, _]: [f64; 3], input: f64, direction: f64| {
        let torque = 0.06 * current - 2e-4 * velocity - 0.12 * direction;
        [
            (input - current - 0.06 * velocity) / 1e-3,
            if direction == 0.0 {
                0.0
            } else {
                torque / 1.2e-4
            },
            velocity,
        ]
    };
    let along = |state: [f64; 3], rate: [f64; 3], time: f64| -> [f64; 3] {
        std::array::from_fn(|index| state[index] + time * rate[index])
    };
    let mut state = [0.0_f64; 3];
    for &input in inputs {
        let input = f64::from(input);
        for _ in 0..parts {
            let torque = 0.06 * state[0];
            let direction = if state[1] != 0.0 {
                state[1].signum()
            } else if torque.abs() > 0.12 {
                torque.signum()
            } else {
                0.0
            };
            let first = rates(state, input, direction);
            let second = rates(along(state, first, 0.5 * H), input, direction);
            let third = rates(along(state, second, 0.5 * H), input, direction);
            let fourth = rates(along(state, third, H), input, direction);
            let mean = std::array::from_fn(|index| {
                (first[index] + 2.0 * (second[index] + third[index]) + fourth[index]) / 6.0
            });
            state = along(state, mean, H);
            if state[1] * direction <= 0.0 {
                state[1] = 0.0;
            }
        }
    }
    state[2]
}

/// Finds the friction of [`EMA`] worn to half as much again, from a sweep's position and current.
fn refit(extent: Extent) -> Result<Refit, Failure> {
    const TRUTH: f32 = 0.18;
    let input = sweep(extent.refit_s, SAMPLING_S);
    let mut actuator = Actuator::build(&EMA, SAMPLING_S as f32).map_err(fault)?;
    actuator.set_friction(TRUTH, TRUTH);
    let mut state = State::default();
    let (mut position, mut current) = (Vec::new(), Vec::new());
    for &input in &input {
        position.push(state.position.value());
        current.push(state.current);
        actuator.step(&mut state, input).map_err(fault)?;
    }
    let task = friction::Task {
        declared: EMA,
        log: CoreLog {
            current: Some(Channel::Values(&current)),
            ..CoreLog::new(
                SAMPLING_S as f32,
                Channel::Values(&input),
                Channel::Values(&position),
            )
        },
        resolution: 0.0,
        present: EMA.coulomb.forward,
        seed: 1,
    };
    let (seconds, estimate) = best(extent.long_runs, || {
        let refit = friction::Refit::new(black_box(&task)).map_err(fault)?;
        refit.run().map_err(fault)
    })?;
    let evaluations = estimate.annealing_evaluations + estimate.golden_section_evaluations;
    let replayed = decimal(WINDOW) * estimate.windows as f64;
    Ok(Refit {
        seconds,
        evaluations,
        simulated_seconds: f64::from(evaluations) * replayed,
        coulomb: decimal(estimate.coulomb),
        truth: decimal(TRUTH),
    })
}

/// Traces an effect that the log has and the machine lacks.
fn gap(extent: Extent) -> Result<Gap, Failure> {
    let machine = machine();
    let log = position_loop(&machine, extent.gap_s)?;
    let logs = [log];
    let trace = || engine::run(&machine, &logs, || Ok(Vec::new()), |_| {});
    let (seconds, report) = best(extent.gap_runs, trace)?;
    let one_core = pool(1)?;
    let (seconds_one_core, _) = best(extent.gap_runs, || one_core.install(trace))?;
    let outcome = report.outcome;
    Ok(Gap {
        seconds,
        seconds_one_core,
        simulations: outcome.cost.simulations,
        samples: outcome.cost.samples,
        found: outcome
            .effects
            .into_iter()
            .map(|effect| effect.id)
            .collect(),
    })
}

/// [`EMA`] as a user declares it.
fn machine() -> Machine {
    Machine {
        path: PathBuf::from("bench"),
        name: "ema-24v".to_owned(),
        coordinate: Coordinate::Radian,
        gain: 1.0,
        motor: Some(Motor {
            resistance: 1.0,
            inductance: 1e-3,
            torque_constant: 0.06,
        }),
        mechanics: Mechanics {
            inertia: 1.2e-4,
            viscous: 2e-4,
            spring: 0.0,
            spring_rest: 0.0,
            spring_preload: 0.0,
            gravity_torque: 0.0,
            gravity_rest: 0.0,
            lower_stop: None,
            upper_stop: None,
        },
        friction: Friction {
            coulomb: 0.12,
            r#static: 0.15,
        },
        resolution: Some(3.1e-3),
        sensor_side: None,
        gear_ratio: None,
        tolerances: BTreeMap::new(),
        fit: ["inertia", "viscous", "coulomb"]
            .map(str::to_owned)
            .to_vec(),
        unsure: BTreeMap::new(),
        declared_effects: Vec::new(),
    }
}

/// A log of the machine under a position loop, with a viscous friction that depends on the
/// direction, seen by its encoder and by a current sensor of 10 mA.
fn position_loop(machine: &Machine, seconds: f64) -> Result<Log, Failure> {
    let mut model = declared::model(machine)?;
    let difference = 0.6 * model.plant.viscous.forward;
    let effect = Active::new(Id::AsymmetricViscous, [difference]);
    if model.effects.push(effect).is_err() {
        return Err(fault("it has no room for an effect"));
    }
    let simulator = model.build(SAMPLING_S as f32).map_err(fault)?;
    let controller = pid::Parameters {
        proportional: 17.0,
        integral: 60.0,
        derivative: 0.25,
        derivative_filter_time: 3e-3,
        output_minimum: -24.0,
        output_maximum: 24.0,
        ..pid::Parameters::default()
    }
    .build(SAMPLING_S as f32)
    .map_err(fault)?;
    let counted = |value: f32, count: f64| (f64::from(value) / count).round() * count;
    let resolution = machine.resolution.unwrap_or(1e-6);
    let samples = (seconds / SAMPLING_S).round() as usize;
    let mut course = Course::default();
    let mut pid = pid::State::default();
    let mut inputs: Vec<f32> = Vec::with_capacity(samples);
    let (mut position, mut current) = (Vec::new(), Vec::new());
    for sample in 0..samples {
        let time = sample as f64 * SAMPLING_S;
        let command = 3.0 * (TAU * 0.7 * time).sin() + 1.5 * (TAU * 1.9 * time).sin();
        let measured = counted(course.state.position.value(), resolution);
        position.push(measured);
        current.push(counted(course.state.current, 0.01));
        let input = controller.step(&mut pid, command as f32, measured as f32);
        inputs.push(input.map_err(fault)?);
        let given = Given {
            input: inputs[sample],
            previous: inputs[sample],
            external: External::NONE,
            index: sample,
        };
        simulator.step(&mut course, &given).map_err(fault)?;
    }
    Ok(Log {
        path: PathBuf::from("bench.csv"),
        start_s: 0.0,
        period_s: SAMPLING_S,
        input: inputs.into_iter().map(f64::from).collect(),
        position,
        command: None,
        current: Some(current),
        ..Log::default()
    })
}

fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Failure::other(format!("a thread cannot be started: {error}")))
}

fn table(outcome: &Outcome) -> String {
    let mut text = String::new();
    // A string takes everything.
    let mut line = |cells: std::fmt::Arguments| {
        let _ = writeln!(text, "{cells}");
    };
    line(format_args!(
        "{:19} {:>8} {:>10} {:>12} {:>14} {:>10}",
        "plant", "step", "ns a step", "steps a s", "s a second", "ema's time"
    ));
    let reference = outcome.plants[0].seconds_per_simulated_second;
    for plant in &outcome.plants {
        line(format_args!(
            "{:19} {:>5.0} µs {:>10.1} {:>12.2e} {:>14.2e} {:>10}",
            plant.name,
            plant.step_s * 1e6,
            plant.ns_per_step,
            1e9 / plant.ns_per_step,
            plant.seconds_per_simulated_second,
            if plant.name.starts_with("ema_") {
                let ratio = plant.seconds_per_simulated_second / reference;
                format!("{ratio:.0} ×")
            } else {
                String::new()
            },
        ));
    }
    let list = |ids: &[String]| {
        if ids.is_empty() {
            "nothing".to_owned()
        } else {
            ids.join(", ")
        }
    };
    let (refit, gap, batch) = (&outcome.refit, &outcome.gap, &outcome.batch);
    line(format_args!(
        "\nfriction refit     {:.3} s: {} simulations, {:.0} simulated seconds; {:.4} N·m of {:.4} N·m",
        refit.seconds, refit.evaluations, refit.simulated_seconds, refit.coulomb, refit.truth
    ));
    line(format_args!(
        "gap                {:.2} s, {:.2} s on one core: {} simulations of {} samples; found {}",
        gap.seconds,
        gap.seconds_one_core,
        gap.simulations,
        gap.samples,
        list(&gap.found)
    ));
    line(format_args!(
        "\n{:20} {:16} {:>7} {:>8} {:>12} {:>22}  found",
        "tracing", "has", "s", "samples", "simulations", "samples a s and core"
    ));
    for tracing in &outcome.tracings {
        line(format_args!(
            "{:20} {:16} {:>7.2} {:>8} {:>12} {:>22.2e}  {}",
            tracing.machine,
            list(&tracing.effects),
            tracing.seconds,
            tracing.samples,
            tracing.simulations,
            tracing.samples_per_second_and_core,
            list(&tracing.found),
        ));
    }
    line(format_args!(
        "\nbatch              {:.0} million steps a second on {} cores, {:.0} on one, {:.0} one by one; vectors: {}",
        batch.steps_per_second * 1e-6,
        batch.cores,
        batch.steps_per_second_one_core * 1e-6,
        batch.steps_per_second_one_by_one * 1e-6,
        batch.vectors
    ));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_compared_simulates_the_same() {
        let inputs = sweep(2.0, STEP_S);
        let exact = exact(&EMA, 0.0, &inputs).unwrap();
        assert!(exact > 20.0, "{exact}");
        let (reference, euler) = (reference(&inputs), euler(&EMA, &inputs).unwrap());
        // Where it halts within one of its steps, the reference forgets up to 0.05 rad/s, for the
        // 33 ms of the mechanical time constant.
        assert!((reference - exact).abs() < 5e-3, "{exact} {reference}");
        // The velocity band and rounding at 1 µs cost Karnopp's scheme some centiradians.
        assert!((euler - exact).abs() < 0.1, "{exact} {euler}");
    }

    #[test]
    fn the_refit_finds_the_friction() {
        let refit = refit(QUICK).unwrap();
        assert!(
            (refit.coulomb / refit.truth - 1.0).abs() < 1e-3,
            "{refit:?}"
        );
    }
}
