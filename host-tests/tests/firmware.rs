//! The firmware's control loop against its simulated actuator, in order and under faults. The
//! interrupts' code is the board's own.

use firmware::app::machine::{ACTUATOR, POSITION_LOOP};
use firmware::app::profile::{self, STEPS};
use firmware::app::timing::{PLANT_PERIOD, QUEUED_SAMPLES, TICKS_PER_CONTROL};
use firmware::app::wiring::{Fault, Measurement, Wiring};
use host_tests::app_on_host::AppOnHost;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::Drive;

/// Ticks up to where the first step of the position has the actuator moving.
const MOVING: u32 = 410 * TICKS_PER_CONTROL;

fn moving() -> AppOnHost {
    let mut app = AppOnHost::new();
    for _ in 0..MOVING {
        app.tick();
    }
    assert!(app.wiring.measurement().velocity > 1.0, "not moving yet");
    assert_ne!(app.wiring.bridge_voltage(), 0.0);
    app
}

/// The bridge is off, and nothing that the loop or the plant does turns it on again.
fn assert_safe(mut app: AppOnHost, fault: Fault) {
    for _ in 0..MOVING {
        assert_eq!(app.wiring.fault(), Some(fault));
        assert_eq!(app.wiring.bridge_voltage(), 0.0);
        app.tick();
    }
    app.wiring.drive(5.0);
    app.wiring.trip(Fault::NonFinite);
    assert_eq!(app.wiring.fault(), Some(fault), "the first fault stays");
    assert_eq!(app.wiring.bridge_voltage(), 0.0);
}

#[test]
fn every_position_is_reached_as_near_as_friction_lets() {
    let samples = AppOnHost::new().run();
    assert_eq!(samples.len(), STEPS as usize);
    let Drive::Voltage {
        resistance,
        torque_constant,
        ..
    } = ACTUATOR.drive
    else {
        panic!("the emulated actuator has a winding");
    };
    let breakaway_voltage = ACTUATOR.breakaway.forward * resistance / torque_constant;
    let tolerance = breakaway_voltage / POSITION_LOOP.proportional;
    let mut ends = 0;
    for pair in samples.windows(2) {
        if pair[0].command != pair[1].command {
            let error = pair[0].command - pair[0].position;
            assert!(error.abs() <= tolerance, "{:?}: off by {error}", pair[0]);
            ends += 1;
        }
    }
    assert_eq!(ends, 9);
}

#[test]
fn the_log_replays_to_the_same_bits() {
    // `input` holds from its row to the next: that is all that a replay needs to know.
    let samples = AppOnHost::new().run();
    let actuator = Actuator::build(&ACTUATOR, PLANT_PERIOD).unwrap();
    let mut state = State::default();
    for sample in samples {
        assert_eq!(
            (
                state.position.value(),
                state.velocity.value(),
                state.current
            ),
            (sample.position, sample.velocity, sample.current),
            "at {} us",
            sample.time_us
        );
        for _ in 0..TICKS_PER_CONTROL {
            actuator.step(&mut state, sample.input).unwrap();
        }
    }
}

#[test]
fn the_bridge_is_off_after_the_profile() {
    let mut app = AppOnHost::new();
    while !app.progress.finished() {
        app.tick();
        while app.samples.dequeue().is_some() {}
    }
    assert_eq!(app.wiring.bridge_voltage(), 0.0);
    assert_eq!(app.wiring.fault(), None);
    assert_eq!(profile::command(STEPS), None);
}

#[test]
fn a_control_step_that_is_not_done_by_the_next_tick_is_a_fault() {
    let mut app = moving();
    // The control interrupt does not get to run.
    while !app.emulation.tick() {}
    assert_eq!(app.wiring.fault(), None);
    let _ = app.emulation.tick();
    assert_safe(app, Fault::MissedDeadline);
}

#[test]
fn a_voltage_that_is_not_finite_is_a_fault() {
    for voltage in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let app = moving();
        app.wiring.drive(voltage);
        assert_safe(app, Fault::NonFinite);
    }
}

#[test]
fn a_measurement_that_is_not_finite_is_a_fault() {
    let sound = Measurement {
        position: 0.1,
        velocity: 1.0,
        current: 2.0,
    };
    let wiring = Wiring::new();
    wiring.publish(sound);
    assert_eq!((wiring.measurement(), wiring.fault()), (sound, None));
    for measurement in [
        Measurement {
            position: f32::NAN,
            ..sound
        },
        Measurement {
            velocity: f32::INFINITY,
            ..sound
        },
        Measurement {
            current: f32::NEG_INFINITY,
            ..sound
        },
    ] {
        let app = moving();
        app.wiring.publish(measurement);
        assert_safe(app, Fault::NonFinite);
    }
}

#[test]
fn a_full_queue_drops_and_counts_and_the_numbers_show_it() {
    let mut app = AppOnHost::new();
    let steps = 50;
    for _ in 0..steps * TICKS_PER_CONTROL {
        app.tick();
    }
    // One place of the ring stays empty.
    let held = QUEUED_SAMPLES as u32 - 1;
    assert_eq!(app.progress.dropped(), steps - held);
    for number in 0..held {
        assert_eq!(app.samples.dequeue().unwrap().sequence, number);
    }
    assert_eq!(app.samples.dequeue(), None);
    app.tick();
    assert_eq!(app.samples.dequeue().unwrap().sequence, steps);
}
