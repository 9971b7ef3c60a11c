//! The emulated engine controller at its emulated throttle body: every fault is found by its code in
//! time, and nothing is found in a sound one.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use firmware::app::ecu::code::Code;
use firmware::app::ecu::loopback::{self, Command};
use firmware::app::ecu::schedule::{HEALTHY, PEDAL, Pedal, Report, TRIALS, Trial};
use firmware::app::machine::{Machine, THROTTLE};
use firmware::app::wiring::Fault as Latched;
use host_tests::ecu_on_host::EcuOnHost;
use model_core::plant::bridge::Bridge;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::rise_time::with_rise_time;
use model_core::plant::throttle::{Fault, Settings};

/// Supply, V, and what the pedal does.
const POINTS: [(f32, Pedal); 4] = [
    (12.0, PEDAL),
    (
        14.0,
        Pedal {
            middle: 0.35,
            amplitude: 0.2,
            period: 700,
        },
    ),
    (
        10.0,
        Pedal {
            middle: 0.65,
            amplitude: 0.25,
            period: 1000,
        },
    ),
    (
        13.0,
        Pedal {
            middle: 0.5,
            amplitude: 0.4,
            period: 1200,
        },
    ),
];

/// The throttle, the same without inductance, and one with a rise time of 100 ms.
fn machines() -> [Machine; 3] {
    let Drive::Voltage {
        resistance,
        torque_constant,
        ..
    } = THROTTLE.plant.drive
    else {
        panic!("a throttle has a winding");
    };
    let reduced = Parameters {
        drive: Drive::Voltage {
            resistance,
            inductance: 0.0,
            torque_constant,
        },
        ..THROTTLE.plant
    };
    let slow = with_rise_time(&THROTTLE.plant, 0.1, 12.0, 50e-6).unwrap();
    [THROTTLE.plant, reduced, slow].map(|plant| {
        let mut machine = Machine { plant, ..THROTTLE };
        // The loop's derivative cancels the mechanical time constant, which grows with the inertia.
        machine.position_loop.derivative *= plant.inertia / THROTTLE.plant.inertia;
        machine
    })
}

/// Bodies of a machine with either second track.
fn bodies(machine: &Machine, seed: u64) -> [Settings; 2] {
    [loopback::complementary(seed), loopback::half_slope(seed)].map(|settings| Settings {
        actuator: machine.plant,
        ..settings
    })
}

#[test]
fn each_fault_is_found_by_its_code_in_time_at_every_operating_point() {
    let mut slowest: BTreeMap<&str, u32> = BTreeMap::new();
    let mut unsound = String::new();
    for (number, machine) in machines().iter().enumerate() {
        for (supply, pedal) in POINTS {
            for seed in 101..105 {
                for (kind, body) in bodies(machine, seed).iter().enumerate() {
                    let mut ecu = EcuOnHost::new(machine, body, supply, &TRIALS, pedal);
                    for trial in &TRIALS {
                        let report = ecu.next_report();
                        let most = slowest.entry(trial.name).or_default();
                        *most = report.steps.max(*most);
                        if !report.sound {
                            writeln!(
                                unsound,
                                "{} on {number}, track {kind}, {supply} V, seed {seed}: {:?} after {}",
                                trial.name, report.code, report.steps
                            )
                            .unwrap();
                        }
                    }
                }
            }
        }
    }
    println!("slowest, ms: {slowest:#?}");
    assert_eq!(unsound, "");
}

/// A drive of a quarter of a minute, nothing wrong.
const SOUND: [Trial; 1] = [Trial {
    name: "none",
    fault: None,
    within: 15_000,
}];

#[test]
fn nothing_is_found_in_a_sound_throttle() {
    let mut runs = 0;
    let mut alarms = Vec::new();
    for machine in &machines() {
        for (supply, pedal) in POINTS {
            for seed in 201..206 {
                for body in &bodies(machine, seed) {
                    let mut ecu = EcuOnHost::new(machine, body, supply, &SOUND, pedal);
                    let report = ecu.next_report();
                    runs += 1;
                    if !report.sound {
                        alarms.push((supply, seed, report));
                    }
                    assert_eq!(ecu.wiring.fault(), None);
                }
            }
        }
    }
    println!("{} alarms in {runs} runs of 15 s", alarms.len());
    assert!(alarms.is_empty(), "{alarms:#?}");
}
