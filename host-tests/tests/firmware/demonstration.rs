//! The firmware's application against its emulated actuators, in order and under failures. The
//! interrupts' and the tasks' code is the board's own.

use firmware::app::check;
use firmware::app::demonstration::{BRAKE, DEMONSTRATION, EMULATION, UNDECLARED, WEAR};
use firmware::app::experiment::{Experiment, Failure};
use firmware::app::failures::FAILURES;
use firmware::app::fault::Fault;
use firmware::app::memory::{MEMORY_SAMPLES, Memory};
use firmware::app::profile::Signal;
use firmware::app::record::{Marks, Outcome, Sample};
use firmware::app::refit;
use firmware::app::timing::{PLANT_PERIOD, QUEUED_SAMPLES, TICKS_PER_CONTROL};
use firmware::app::wiring::Truth;
use firmware::app::work::PlantWork;
use host_tests::app_on_host::AppOnHost;
use model_core::gap::log::Channel;
use model_core::identify::friction::Refusal;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::Drive;

/// Ticks up to where the first step of the position has the actuator moving.
const MOVING: u32 = 10 * TICKS_PER_CONTROL;

fn failure(name: &str) -> Experiment {
    let found = FAILURES.iter().find(|experiment| experiment.name == name);
    *found.unwrap()
}

fn moving() -> AppOnHost {
    let mut app = AppOnHost::new();
    app.load(&UNDECLARED);
    for _ in 0..MOVING {
        app.tick();
    }
    assert!(app.wiring.truth().velocity > 1.0, "not moving yet");
    assert_ne!(app.wiring.duty(), 0);
    app
}

/// The bridge is off, and nothing that the loop or the plant does turns it on again.
fn assert_safe(app: &mut AppOnHost, fault: Fault) {
    for _ in 0..MOVING {
        assert_eq!(app.wiring.fault(), Some(fault));
        assert_eq!(app.wiring.duty(), 0);
        app.tick();
    }
    app.wiring.drive(500);
    app.wiring.trip(Fault::NonFinite);
    assert_eq!(app.wiring.fault(), Some(fault), "the first fault stays");
    assert_eq!(app.wiring.duty(), 0);
}

#[test]
fn every_position_is_reached_as_near_as_friction_lets() {
    let (samples, _) = AppOnHost::new().run(&UNDECLARED);
    let machine = &UNDECLARED.machine;
    let Drive::Voltage {
        resistance,
        torque_constant,
        ..
    } = machine.plant.drive
    else {
        panic!("the actuator has a winding");
    };
    let breakaway_voltage = machine.plant.breakaway.forward * resistance / torque_constant;
    let tolerance = breakaway_voltage / machine.position_loop.proportional;
    let mut end = 0;
    for command in UNDECLARED.commands {
        end += command.milliseconds as usize;
        if let Signal::Step(_) = command.signal {
            let sample = samples[end - 1];
            let error = sample.command - sample.truth.position;
            assert!(error.abs() <= tolerance, "{sample:?}: off by {error}");
        }
    }
    assert_eq!(end, samples.len());
}

#[test]
fn the_throttle_follows_within_the_stick_of_its_friction() {
    let (samples, outcome) = AppOnHost::new().run(&EMULATION);
    assert!(outcome.is_success());
    // Every hold of half a second ends near its position; the first 3 s are steps.
    for hold in 0..6 {
        let sample = samples[hold * 500 + 499];
        let error = sample.command - sample.truth.position;
        assert!(error.abs() < 0.05, "{sample:?}: off by {error}");
    }
    let stops = (EMULATION.actuator.lower_stop, EMULATION.actuator.upper_stop);
    for sample in &samples {
        assert!((stops.0..=stops.1).contains(&sample.truth.position));
    }
}

#[test]
fn the_log_replays_to_the_same_bits() {
    // `duty` holds from its row to the next: that is all that a replay needs to know.
    for experiment in &DEMONSTRATION {
        let (samples, _) = AppOnHost::new().run(experiment);
        let mut actuator = Actuator::build(&experiment.actuator, PLANT_PERIOD).unwrap();
        let mut state = State::new(experiment.machine.rest, 0.0);
        let converters = &experiment.machine.converters;
        let mut tick = 0;
        for sample in samples {
            assert_eq!(Truth::from(&state), sample.truth, "{}", sample.sequence);
            let measured = converters.position.counts(sample.truth.position);
            assert_eq!(measured.map(i32::from), Some(sample.position));
            let current = converters.current.counts(sample.truth.current);
            assert_eq!(current, Some(sample.current));
            for _ in 0..TICKS_PER_CONTROL {
                tick += 1;
                if let Some(wear) = experiment.wear
                    && wear.step * TICKS_PER_CONTROL == tick
                {
                    actuator.set_friction(wear.coulomb, wear.breakaway);
                }
                let voltage = converters.bridge.value(sample.duty);
                actuator.step(&mut state, voltage).unwrap();
            }
        }
    }
}

#[test]
fn the_loop_goes_on_behind_the_recording_and_nothing_of_it_is_recorded() {
    let mut app = AppOnHost::new();
    let (samples, outcome) = app.run(&UNDECLARED);
    assert_eq!(samples.len(), UNDECLARED.steps as usize);
    assert!(outcome.is_success());
    let mut moved = false;
    for _ in 0..2000 * TICKS_PER_CONTROL {
        app.tick();
        moved |= app.wiring.truth().velocity.abs() > 1.0;
    }
    assert!(moved);
    assert_eq!(app.wiring.fault(), None);
    let mut recorded = 0;
    assert!(
        app.recording
            .drain(&mut app.memory, |_| recorded += 1)
            .is_some()
    );
    assert_eq!(recorded, 0);
}

#[test]
fn a_control_step_that_is_not_done_by_the_next_tick_is_a_fault() {
    let mut app = moving();
    // The control interrupt does not get to run.
    while !app.emulation.tick() {}
    assert_eq!((app.wiring.fault(), app.wiring.missed()), (None, 0));
    let _ = app.emulation.tick();
    assert!(app.wiring.missed() > 0);
    assert_safe(&mut app, Fault::MissedDeadline);
}

#[test]
fn a_sensor_without_a_reading_is_a_fault_until_the_next_experiment() {
    let mut app = AppOnHost::new();
    let (samples, outcome) = app.run(&failure("sensor"));
    assert_eq!(outcome.fault, Some(Fault::NonFinite));
    assert!(!outcome.is_success());
    let Some(Failure::PositionSensor(step)) = failure("sensor").failure else {
        panic!("no sensor fails");
    };
    assert_eq!(samples.last().map(|sample| sample.sequence), Some(step));
    assert_eq!(samples.last().map(|sample| sample.duty), Some(0));
    assert_safe(&mut app, Fault::NonFinite);

    let (samples, outcome) = app.run(&UNDECLARED);
    assert!(outcome.is_success());
    let (first, _) = AppOnHost::new().run(&UNDECLARED);
    assert_eq!(samples, first, "something is left of the run before");
}

#[test]
fn an_impossible_actuator_is_refused_and_the_one_before_it_goes_on() {
    let refused = failure("impossible").build().unwrap_err();
    assert!(format!("{refused:?}").contains("inertia"), "{refused:?}");
    let no_commands = Experiment {
        commands: &[],
        ..UNDECLARED
    };
    assert!(no_commands.build().is_err());
    let mut no_filter = UNDECLARED;
    no_filter.machine.position_loop.derivative_filter_time = -1.0;
    assert!(no_filter.build().is_err());
}

#[test]
fn a_full_queue_drops_and_counts_and_the_memory_begins_anew_behind_the_gap() {
    let mut app = AppOnHost::new();
    app.load(&UNDECLARED);
    let steps = 50;
    for _ in 0..steps * TICKS_PER_CONTROL {
        app.tick();
    }
    // One place of the ring stays empty.
    let held = QUEUED_SAMPLES as u32 - 1;
    assert_eq!(app.progress.dropped(), steps - held);
    let mut numbers = Vec::new();
    let mut log = |sample: &Sample| numbers.push(sample.sequence);
    assert_eq!(app.recording.drain(&mut app.memory, &mut log), None);
    app.tick();
    assert_eq!(app.recording.drain(&mut app.memory, &mut log), None);
    assert_eq!(numbers, (0..held).chain([steps]).collect::<Vec<_>>());
    assert_eq!(app.memory.samples(), 1);
}

#[test]
fn what_a_fault_left_in_the_queue_is_not_in_the_next_recording() {
    let mut app = AppOnHost::new();
    let _ = app.run(&failure("sensor"));
    for _ in 0..10 * TICKS_PER_CONTROL {
        app.tick();
    }
    let (samples, outcome) = app.run(&failure("short"));
    assert!(outcome.is_success());
    assert_eq!(samples[0].sequence, 0);
    assert_eq!(samples.len(), failure("short").steps as usize);
}

/// A sample whose counts all follow from its number.
fn numbered(sequence: u32) -> Sample {
    let count = (sequence % 30_000) as i16;
    Sample {
        sequence,
        command: 0.0,
        duty: count,
        position: (-count).into(),
        current: count / 2,
        truth: Truth::default(),
        marks: Marks::default(),
    }
}

#[test]
fn the_memory_keeps_the_last_samples_in_order() {
    let converters = &UNDECLARED.machine.converters;
    for pushed in [
        0,
        1,
        MEMORY_SAMPLES - 1,
        MEMORY_SAMPLES,
        MEMORY_SAMPLES + 1,
        25_000,
    ] {
        let mut memory = Box::<Memory>::default();
        for sequence in 0..pushed as u32 {
            memory.push(&numbered(sequence));
        }
        let kept = pushed.min(MEMORY_SAMPLES);
        assert_eq!(memory.samples(), kept);
        let log = memory.log(converters);
        let expected = |value: fn(&Sample) -> f32| -> Vec<f32> {
            let numbers = pushed - kept..pushed;
            numbers
                .map(|number| value(&numbered(number as u32)))
                .collect()
        };
        let counts = |channel: Channel, unit: f32| -> Vec<f32> {
            channel.iter().map(|value| (value / unit).round()).collect()
        };
        assert_eq!(
            counts(log.input, converters.bridge.unit()),
            expected(|sample| sample.duty.into())
        );
        assert_eq!(
            counts(log.position, converters.position.unit()),
            expected(|sample| sample.position as f32)
        );
        assert_eq!(
            counts(log.current.unwrap(), converters.current.unit()),
            expected(|sample| sample.current.into())
        );
    }
}

fn refit_of(experiment: &Experiment) -> Result<f32, refit::Failed> {
    let mut app = AppOnHost::new();
    let _: (Vec<Sample>, Outcome) = app.run(experiment);
    let machine = &experiment.machine;
    refit::refit(machine, app.memory.log(&machine.converters)).map(|estimate| estimate.coulomb)
}

#[test]
fn worn_friction_is_estimated_within_a_percent_from_the_nominal_one() {
    for factor in [0.6, 0.8, 1.25, 1.6, 2.5] {
        let mut experiment = WEAR;
        let wear = experiment.wear.as_mut().unwrap();
        wear.coulomb = factor * experiment.machine.plant.coulomb.forward;
        wear.breakaway = factor * experiment.machine.plant.breakaway.forward;
        let truth = wear.coulomb;
        let estimate = refit_of(&experiment).unwrap();
        assert!(
            (estimate / truth - 1.0).abs() < 0.01,
            "{estimate} for {truth}"
        );
    }
}

/// The paper's estimate of the same case is 5.6 % off.
#[test]
fn the_friction_of_the_papers_brake_is_estimated_within_a_percent() {
    let truth = BRAKE.actuator.coulomb.forward;
    let estimate = refit_of(&BRAKE).unwrap();
    println!("{estimate} for {truth}");
    assert!(
        (estimate / truth - 1.0).abs() < 0.01,
        "{estimate} for {truth}"
    );
}

#[test]
fn a_log_that_gives_no_estimate_is_refused_by_name() {
    let refused = |name: &str| refit_of(&failure(name)).unwrap_err();
    assert_eq!(refused("short"), refit::Failed::Log(Refusal::LogTooShort));
    assert_eq!(refused("still"), refit::Failed::Log(Refusal::NoMotion));
    assert_eq!(refused("bound"), refit::Failed::Log(Refusal::AtLowerBound));
    let mut unchanged = WEAR;
    unchanged.wear = None;
    assert_eq!(
        refit_of(&unchanged).unwrap_err(),
        refit::Failed::Log(Refusal::NoImprovement)
    );
    let mut impossible = WEAR;
    impossible.machine.plant.inertia = 0.0;
    let failed = refit_of(&impossible).unwrap_err();
    assert!(matches!(failed, refit::Failed::Machine(_)), "{failed:?}");
}

#[test]
fn a_log_too_short_for_a_check_is_refused_by_name() {
    let experiment = failure("short_check");
    let mut app = AppOnHost::new();
    let _ = app.run(&experiment);
    let log = app.memory.log(&experiment.machine.converters);
    assert_eq!(
        check::check(&experiment.machine, log),
        Err(check::Failed::LogTooShort)
    );
}
