//! The image that tests the model core on the chip, and counts its cycles: emulated at one an instruction, its
//! instructions.
//!
//! Logs `check NAME DIGEST` for each test and `count NAME CYCLES` for each figure. Nothing interrupts it.
#![no_std]
#![no_main]

use core::hint::black_box;

use firmware::app::ecu::loopback;
use firmware::app::timing::{CONTROL_PERIOD, PLANT_PERIOD};
use firmware::board::stm32f405::unattended::{self, cycles};
use firmware::on_target::control::GAINS;
use firmware::on_target::log::{self, Recording};
use firmware::on_target::{CHECKS, plant};
use model_core::control::pid;
use model_core::identify::friction::{Refit, Task};
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::bench::averaged::Averaged;
use model_core::plant::bench::electrics::Electrics;
use model_core::plant::bench::switching::Switching;
use model_core::plant::bench::{self, Bench};
use model_core::plant::bridge::Bridge;
use model_core::plant::parameters::Parameters;
use model_core::plant::throttle::{Settings, Throttle};
use static_cell::StaticCell;

#[cortex_m_rt::entry]
fn main() -> ! {
    unattended::compute(measure)
}

fn measure() -> bool {
    let mut failed = 0_u32;
    for check in CHECKS {
        let findings = check.run();
        defmt::info!("check {=str} {=u64:016x}", check.name, findings.digest());
        if let Some(claim) = findings.broken() {
            defmt::error!("check {=str} fails: {=str}", check.name, claim);
            failed += 1;
        }
    }
    plants();
    throttle_body();
    bench_sliding::<Averaged>(
        ["bench_averaged", "bench_averaged_period"],
        &bench::Parameters::AVERAGED,
    );
    bench_sliding::<Switching>(
        ["bench_switching", "bench_switching_period"],
        &bench::Parameters::SWITCHING,
    );
    controller();
    refit();
    defmt::info!("end checks={=usize} failed={=u32}", CHECKS.len(), failed);
    failed == 0
}

/// Cycles of some work, without those of looking at the clock.
fn duration(work: impl FnOnce()) -> u32 {
    let start = cycles();
    let read = cycles();
    work();
    let end = cycles();
    end.wrapping_sub(read) - read.wrapping_sub(start)
}

/// Runs of what is counted.
const RUNS: usize = 1000;

/// Inputs of each run, out of the compiler's sight.
type Inputs = [f32; RUNS];

/// Logs the cycles of one run of `work`, without those of the loop around it.
fn count(name: &str, inputs: &Inputs, mut work: impl FnMut(f32)) {
    let inputs = black_box(inputs);
    let all = duration(|| inputs.iter().for_each(|&input| work(black_box(input))));
    let around = duration(|| {
        inputs.iter().for_each(|&input| {
            black_box(input);
        });
    });
    log_count(name, nearest(all - around, RUNS as u32));
}

/// Cycles of one of so many runs, to the nearest: a look at the emulated clock, which counts nanoseconds, is up to a
/// cycle off, so no single run is counted.
fn nearest(all: u32, runs: u32) -> u32 {
    (all + runs / 2) / runs
}

fn log_count(name: &str, cycles: u32) {
    defmt::info!("count {=str} {=u32}", name, cycles);
}

// As an interrupt calls it: in a loop the compiler would keep the modes in registers.
#[inline(never)]
fn step(actuator: &Actuator, state: &mut State, input: f32) {
    defmt::assert!(actuator.step(state, input).is_ok());
}

fn plants() {
    let build = |parameters| defmt::unwrap!(Actuator::build(parameters, plant::PERIOD).ok());
    let ema = build(&plant::EMA);
    let sliding = |name, actuator: &Actuator, state: State, volts: f32| {
        let mut state = state;
        count(name, &[volts; RUNS], |input| {
            step(actuator, &mut state, input)
        });
    };
    sliding("ema_forward", &ema, State::new(0.0, 50.0), 12.0);
    sliding("ema_backward", &ema, State::new(0.0, -50.0), -12.0);
    sliding("ema_rest", &ema, State::new(0.0, 0.0), 1.0);
    // No stop in reach.
    let throttle = build(&Parameters {
        upper_stop: 100.0,
        ..plant::THROTTLE
    });
    sliding("throttle_sliding", &throttle, State::new(0.5, 5.0), 12.0);

    // Comes to a standstill in the middle of the step and goes back.
    let turning = State {
        current: -20.0,
        ..State::new(0.0, 0.5)
    };
    let mut state = turning;
    count("ema_reversal", &[-20.0; RUNS], |input| {
        state = turning;
        step(&ema, &mut state, input);
    });
    defmt::assert!(state.velocity.value() < 0.0);
}

/// A sound throttle body: driven, with its switches off, and a reading of its two tracks.
fn throttle_body() {
    static BODY: StaticCell<Throttle> = StaticCell::new();
    let endless = Parameters {
        upper_stop: 100.0,
        ..plant::THROTTLE
    };
    let settings = Settings {
        actuator: endless,
        ..loopback::complementary(plant::THROTTLE, loopback::SEED)
    };
    let throttle = BODY.init(defmt::unwrap!(
        Throttle::build(&settings, PLANT_PERIOD).ok()
    ));
    // Off its limp-home position, and in motion.
    for _ in 0..1000 {
        defmt::assert!(throttle.step(Bridge::Drive { duty: 1.0 }, 12.0).is_ok());
    }
    count("throttle_body_driven", &[1.0; RUNS], |duty| {
        defmt::assert!(throttle.step(Bridge::Drive { duty }, 12.0).is_ok());
    });
    count("throttle_body_tracks", &[0.0; RUNS], |_| {
        black_box(throttle.shares());
    });
    count("throttle_body_freewheeling", &[12.0; RUNS], |supply| {
        defmt::assert!(throttle.step(Bridge::Freewheel, supply).is_ok());
    });
}

/// The test bench in motion: a step without its control, and a whole period of that.
fn bench_sliding<E: Electrics>([step, period]: [&str; 2], parameters: &bench::Parameters) {
    let mut bench = defmt::unwrap!(Bench::<E>::build(parameters).ok());
    bench.set_brake(0.3);
    let mut command = 0.0;
    let mut follow = |bench: &mut Bench<E>| {
        command += 1e-5;
        defmt::assert!(bench.step(command).is_ok());
    };
    for _ in 0..100 {
        follow(&mut bench);
    }
    count(period, &[0.0; RUNS], |_| follow(&mut bench));
    let wanted = bench.terms().output / parameters.control.torque_constant;
    count(step, &[wanted; RUNS], |reference| {
        defmt::assert!(bench.advance(reference).is_ok());
    });
}

fn controller() {
    let controller = defmt::unwrap!(GAINS.build(CONTROL_PERIOD).ok());
    let mut state = pid::State::default();
    count("pid", &[0.5; RUNS], |measured| {
        let _ = black_box(controller.step(&mut state, 0.6, measured));
    });
}

/// A log of 10 s and the friction's re-estimation from it.
fn refit() {
    static RECORDING: StaticCell<Recording<10_000>> = StaticCell::new();
    let recording = RECORDING.init_with(Recording::new);
    defmt::assert!(recording.drive(&plant::EMA, 0.2));
    let task = Task {
        declared: plant::EMA,
        log: recording.log(),
        resolution: log::CONVERTERS.position.unit(),
        present: 0.12,
        seed: 1,
    };
    let mut refit = defmt::unwrap!(Refit::new(&task).ok());
    let mut outcome = None;
    let mut calls = 0;
    let all = duration(|| {
        outcome = loop {
            calls += 1;
            if let Some(outcome) = refit.advance() {
                break outcome.ok();
            }
        };
    });
    let estimate = defmt::unwrap!(outcome);
    let evaluations = estimate.annealing_evaluations + estimate.golden_section_evaluations;
    log_count("refit_evaluations", evaluations);
    log_count("refit_evaluation", nearest(all, evaluations));
    log_count("refit_sample", nearest(all, calls * 200));
}
