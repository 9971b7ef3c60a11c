//! The emulated engine controller at its emulated throttle body: every fault is found by its code in
//! time, and nothing is found in a sound one.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use firmware::app::ecu::calibration::{Calibration, SUPPLY};
use firmware::app::ecu::code::Code;
use firmware::app::ecu::observation::Readings;
use firmware::app::ecu::schedule::{PEDAL, Pedal, TRIALS, Trial};
use firmware::app::ecu::{Demand, Ecu, loopback};
use firmware::app::fault::Fault as Latched;
use firmware::app::machine::{Machine, THROTTLE};
use firmware::app::timing::{PLANT_PERIOD, TICKS_PER_CONTROL};
use firmware::app::tracks;
use firmware::app::work::PlantWork;
use host_tests::ecu_on_host::EcuOnHost;
use host_tests::gap::declared;
use host_tests::{ecu, machine, workspace};
use model_core::numeric::random::Random;
use model_core::plant::bridge::Bridge;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::potentiometer::{Track, TrackFault};
use model_core::plant::rise_time::with_rise_time;
use model_core::plant::throttle::{Fault, Settings, Side, Throttle};

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

/// The intake throttle, whose spring holds it open at its upper stop: it has no limp-home position of
/// its own.
fn intake_throttle() -> Parameters {
    let file = workspace::root().join("host-tests/machines/intake-throttle-12v.toml");
    let machine = machine::Machine::read(&file).unwrap();
    declared::model(&machine).unwrap().plant
}

/// The throttle, the same without inductance, one with a rise time of 100 ms, and the intake throttle.
fn machines() -> [Machine; 4] {
    let slow = with_rise_time(&THROTTLE.plant, 0.1, 12.0, PLANT_PERIOD).unwrap();
    let plants = [
        THROTTLE.plant,
        THROTTLE.plant.reduced(),
        slow,
        intake_throttle(),
    ];
    plants.map(|plant| {
        let mut machine = Machine { plant, ..THROTTLE };
        // The loop's derivative cancels the mechanical time constant, which grows with the inertia.
        machine.position_loop.derivative *= plant.inertia / THROTTLE.plant.inertia;
        machine
    })
}

/// Throttle bodies with either second track.
fn bodies(plant: Parameters, seed: u64) -> [Settings; 2] {
    [
        loopback::complementary(plant, seed),
        loopback::half_slope(plant, seed),
    ]
}

/// A controller of such machines at a throttle body.
fn joined(
    machine: &Machine,
    nominal: &Settings,
    body: &Settings,
    (supply, pedal): (f32, Pedal),
    trials: &'static [Trial],
) -> EcuOnHost {
    let calibration = Calibration::new(machine, &nominal.tracks).unwrap();
    EcuOnHost::new(calibration, body, supply, trials, pedal)
}

#[test]
fn each_fault_is_found_by_its_code_in_time_at_every_operating_point() {
    let mut slowest: BTreeMap<&str, u32> = BTreeMap::new();
    let mut unsound = String::new();
    for (number, machine) in machines().iter().enumerate() {
        for point in POINTS {
            let supply = point.0;
            for seed in 101..=106 {
                for (kind, nominal) in bodies(machine.plant, seed).iter().enumerate() {
                    // Every second body is off its nominal numbers.
                    let body = if seed % 2 == 0 {
                        as_made(nominal, seed)
                    } else {
                        *nominal
                    };
                    let mut ecu = joined(machine, nominal, &body, point, &TRIALS);
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

/// A drive with nothing wrong.
const SOUND: [Trial; 1] = [Trial {
    name: "none",
    fault: None,
    within: 8000,
}];

#[test]
fn nothing_is_found_in_a_sound_throttle() {
    let mut runs = 0;
    let mut alarms = Vec::new();
    for machine in &machines() {
        for point in POINTS {
            for seed in 201..=220 {
                for body in &bodies(machine.plant, seed) {
                    let mut ecu = joined(machine, body, body, point, &SOUND);
                    let report = ecu.next_report();
                    runs += 1;
                    if !report.sound {
                        alarms.push((point, seed, report));
                    }
                    assert_eq!(ecu.wiring.fault(), None);
                }
            }
        }
    }
    println!("{} alarms in {runs} runs of 8 s", alarms.len());
    assert!(alarms.is_empty(), "{alarms:#?}");
}

/// A throttle body as it is made, each number off its nominal one by a tolerance, up or down.
fn as_made(nominal: &Settings, seed: u64) -> Settings {
    let mut random = Random::new(seed, 2);
    let mut off = |tolerance: f32| {
        if random.bits() & 0x1000 == 0 {
            tolerance
        } else {
            -tolerance
        }
    };
    let plant = nominal.actuator;
    let Drive::Voltage {
        resistance,
        inductance,
        torque_constant,
    } = plant.drive
    else {
        panic!("a throttle has a winding");
    };
    let friction = 1.0 + off(0.05);
    let actuator = Parameters {
        drive: Drive::Voltage {
            resistance: resistance * (1.0 + off(0.1)),
            inductance,
            torque_constant: torque_constant * (1.0 + off(0.05)),
        },
        inertia: plant.inertia * (1.0 + off(0.1)),
        viscous: plant.viscous.scaled(1.0 + off(0.1)),
        coulomb: plant.coulomb.scaled(friction),
        breakaway: plant.breakaway.scaled(friction),
        spring: plant.spring * (1.0 + off(0.05)),
        spring_preload: plant.spring_preload * (1.0 + off(0.05)),
        ..plant
    };
    let tracks = nominal.tracks.map(|track| Track {
        offset: track.offset + off(0.04),
        gain: track.gain * (1.0 + off(0.01)),
        ..track
    });
    Settings {
        actuator,
        tracks,
        ..*nominal
    }
}

#[test]
fn nothing_is_found_in_a_throttle_that_is_off_its_nominal_numbers_by_their_tolerances() {
    let mut alarms = Vec::new();
    for machine in [&THROTTLE, &machines()[3]] {
        for point in POINTS {
            for seed in 301..=320 {
                for nominal in &bodies(machine.plant, seed) {
                    let made = as_made(nominal, seed);
                    let mut ecu = joined(machine, nominal, &made, point, &SOUND);
                    let report = ecu.next_report();
                    if !report.sound {
                        alarms.push((point, seed, report));
                        continue;
                    }
                    let plant = &made.actuator;
                    for (ends, track) in report.learned.unwrap().ends.iter().zip(made.tracks) {
                        for (share, stop) in [
                            (ends.closed, plant.lower_stop),
                            (ends.open, plant.upper_stop),
                        ] {
                            let volts = track.offset + track.gain * stop;
                            assert!((5.0 * share - volts).abs() < 5e-3, "{share} for {volts} V");
                        }
                    }
                }
            }
        }
    }
    assert!(alarms.is_empty(), "{} {alarms:#?}", alarms.len());
}

#[test]
fn the_board_says_what_this_host_does() {
    let golden = workspace::root().join("firmware/src/bin/trials.log");
    let golden = std::fs::read_to_string(golden).unwrap();
    let host = ecu::said(&ecu::on_host());
    let host: Vec<String> = host.iter().map(|line| format!("INFO {line}")).collect();
    assert_eq!(golden.lines().collect::<Vec<_>>(), host);
}

/// A controller at a throttle body, with nothing in between.
struct Bench {
    ecu: Ecu,
    throttle: Throttle,
    bridge: Bridge,
}

impl Bench {
    fn new(settings: &Settings) -> Self {
        let machine = Machine {
            plant: settings.actuator,
            ..THROTTLE
        };
        let calibration = Calibration::new(&machine, &settings.tracks).unwrap();
        Self {
            ecu: Ecu::new(calibration),
            throttle: Throttle::build(settings, PLANT_PERIOD).unwrap(),
            bridge: Bridge::Freewheel,
        }
    }

    /// So many milliseconds with the key and the pedal as they are.
    fn run(&mut self, milliseconds: u32, demand: Demand) {
        for _ in 0..milliseconds {
            for _ in 0..TICKS_PER_CONTROL {
                self.throttle.step(self.bridge, 12.0).unwrap();
            }
            let current = self.throttle.current();
            let readings = Readings {
                tracks: self.throttle.shares().map(tracks::code),
                current: THROTTLE.converters.current.counts(current).unwrap(),
                supply: SUPPLY.counts(12.0).unwrap(),
            };
            self.bridge = self.ecu.step(&readings, &demand);
        }
    }

    fn position(&self) -> f32 {
        self.throttle.state().position.value()
    }
}

const KEY_ON: Demand = Demand {
    key_on: true,
    pedal: 0.6,
};

#[test]
fn at_key_on_stops_and_limp_home_are_learned_and_then_the_pedal_is_followed() {
    for plant in [THROTTLE.plant, intake_throttle()] {
        let stroke = plant.upper_stop - plant.lower_stop;
        for settings in bodies(plant, 7) {
            let mut bench = Bench::new(&settings);
            bench.run(3000, KEY_ON);
            assert_eq!(bench.ecu.code(), None);
            let learned = bench.ecu.learned().unwrap();
            // 5 mV of noise over 32 readings: 0.9 mV, and half a count of the converter is 0.6 mV.
            for (ends, track) in learned.ends.iter().zip(settings.tracks) {
                for (share, stop) in [
                    (ends.closed, plant.lower_stop),
                    (ends.open, plant.upper_stop),
                ] {
                    let volts = track.offset + track.gain * stop;
                    assert!((5.0 * share - volts).abs() < 5e-3, "{share} for {volts} V");
                }
            }
            let limp_home = (plant.spring_rest - plant.lower_stop) / stroke;
            assert!((learned.limp_home - limp_home).abs() < 2e-3);
            let asked = plant.lower_stop + stroke * KEY_ON.pedal;
            // As near as the loop's friction lets it: breakaway · R / (k K_p) = 59 mrad.
            assert!((bench.position() - asked).abs() < 0.06);
        }
    }
}

#[test]
fn a_code_switches_the_bridge_off_and_key_off_forgets_it() {
    let mut bench = Bench::new(&loopback::complementary(THROTTLE.plant, 3));
    bench.run(3000, KEY_ON);
    let fault = Fault::Track(Side::First, TrackFault::ShortedHigh);
    bench.throttle.inject(fault).unwrap();
    bench.run(30, KEY_ON);
    assert_eq!(bench.ecu.code(), Some(Code::FirstTrackHigh));
    bench.run(1000, KEY_ON);
    assert_eq!(bench.bridge, Bridge::Freewheel);
    assert_eq!(bench.position(), 0.2, "limp-home");
    // The fault goes, the code stays as long as the key is on.
    bench.throttle.heal();
    bench.run(100, KEY_ON);
    assert_eq!(bench.ecu.code(), Some(Code::FirstTrackHigh));
    bench.run(1, Demand::default());
    assert_eq!(bench.bridge, Bridge::Brake, "a soft way down");
    bench.run(100, Demand::default());
    assert_eq!(bench.bridge, Bridge::Freewheel);
    bench.run(3000, KEY_ON);
    assert_eq!(bench.ecu.code(), None);
    assert!(bench.ecu.learned().is_some());
}

#[test]
fn a_fault_that_is_there_at_key_on_is_found_before_the_pedal_is_followed() {
    for (fault, code) in [
        (Fault::SpringBroken, Code::SpringReturn),
        (Fault::FrictionRaised(1.8), Code::SpringReturn),
        (Fault::PlateJammed, Code::PlateStuck),
        (Fault::MotorOpen, Code::OpenLoad),
        (Fault::MotorShorted(0.2), Code::ShortCircuit),
        (
            Fault::Track(Side::Second, TrackFault::Open),
            Code::SecondTrackLow,
        ),
    ] {
        for seed in 1..=5 {
            let mut bench = Bench::new(&loopback::complementary(THROTTLE.plant, seed));
            bench.throttle.inject(fault).unwrap();
            bench.run(5000, KEY_ON);
            assert_eq!(bench.ecu.code(), Some(code), "{fault:?}");
            assert_eq!(bench.ecu.learned(), None);
            assert_eq!(bench.bridge, Bridge::Freewheel);
        }
    }
}

#[test]
fn a_control_step_that_is_not_done_by_the_next_tick_switches_the_bridge_off() {
    let body = loopback::complementary(THROTTLE.plant, 1);
    let mut ecu = joined(&THROTTLE, &body, &body, (12.0, PEDAL), &TRIALS);
    for _ in 0..TICKS_PER_CONTROL * 2500 {
        ecu.tick();
    }
    assert!(matches!(ecu.wires.bridge(), Bridge::Drive { .. }));
    while !ecu.emulation.tick() {}
    for _ in 0..20_000 {
        let _ = ecu.emulation.tick();
    }
    assert_eq!(ecu.wiring.fault(), Some(Latched::MissedDeadline));
    assert!(matches!(ecu.wires.bridge(), Bridge::Drive { .. }));
    assert_eq!(ecu.wiring.truth().position, 0.2, "limp-home all the same");
}

#[test]
fn a_pedal_that_is_no_number_takes_the_plate_to_limp_home_and_an_endless_one_to_its_limit() {
    let mut bench = Bench::new(&loopback::complementary(THROTTLE.plant, 1));
    bench.run(3000, KEY_ON);
    let pressed = |pedal: f32| Demand {
        key_on: true,
        pedal,
    };
    bench.run(1000, pressed(f32::NAN));
    assert_eq!(bench.bridge, Bridge::Freewheel);
    assert_eq!(bench.position(), 0.2, "limp-home");
    for (pedal, limit) in [(f32::INFINITY, 0.97), (f32::NEG_INFINITY, 0.03)] {
        bench.run(1000, pressed(pedal));
        let limit = 0.02 + 1.55 * limit;
        assert!((bench.position() - limit).abs() < 0.06, "{pedal}");
    }
    assert_eq!(bench.ecu.code(), None);
}

#[test]
fn a_track_that_does_not_tell_the_stops_apart_is_refused() {
    let mut tracks = loopback::complementary(THROTTLE.plant, 1).tracks;
    tracks[1].gain = 0.0;
    let error = Calibration::new(&THROTTLE, &tracks).unwrap_err();
    assert_eq!(error.name, "tracks");
}

#[test]
fn a_command_that_makes_no_sense_is_counted_and_changes_nothing() {
    const NONSENSE: [Trial; 1] = [Trial {
        name: "nonsense",
        fault: Some((Fault::FrictionRaised(f32::NAN), Code::FrictionHigh)),
        within: 2000,
    }];
    let body = loopback::complementary(THROTTLE.plant, 1);
    let mut ecu = joined(&THROTTLE, &body, &body, (f32::NAN, PEDAL), &NONSENSE);
    let report = ecu.next_report();
    assert_eq!(report.code, None);
    assert!(!report.sound, "what was to be found was not");
    // The supply, and the fault.
    assert_eq!(ecu.wires.refused(), 2);
    assert_eq!(ecu.wiring.fault(), None);
}
