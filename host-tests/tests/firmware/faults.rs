//! What goes wrong is latched with its first cause, makes the outputs safe whatever it is, and is
//! cleared only when it is over; and the monitors find what they are for in an actuator that moves,
//! and nothing in a sound one.

use std::collections::HashSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use firmware::app::demonstration::{BRAKE, UNDECLARED, WEAR};
use firmware::app::fault::back_emf;
use firmware::app::fault::last_words::{LastWords, TEXT};
use firmware::app::fault::latch::{Cause, Latch, NotCleared};
use firmware::app::fault::monitor::{Limits, Measured, Monitors, Observers};
use firmware::app::fault::observer::{Reading, TIME_CONSTANT, Tolerances};
use firmware::app::fault::output::{Brake, Bridge, Outputs, Tracks};
use firmware::app::fault::reset::ResetFlags;
use firmware::app::fault::{Fault, Faults, following};
use firmware::app::machine::{EMA, Machine};
use firmware::app::timing::{CONTROL_PERIOD, PLANT_PERIOD, TICKS_PER_CONTROL};
use firmware::app::tracks::DIAGNOSTIC;
use host_tests::app_on_host::AppOnHost;
use model_core::control::pid;
use model_core::numeric::random::Random;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::{Drive, Parameters};
use proptest::prelude::*;

fn fault() -> impl Strategy<Value = Fault> {
    prop::sample::select(&Fault::ALL)
}

#[test]
fn every_fault_has_a_number_a_name_and_a_remedy_of_its_own() {
    let mut names = HashSet::new();
    for (place, fault) in Fault::ALL.into_iter().enumerate() {
        assert_eq!(fault.number() as usize, place);
        assert!(names.insert(fault.name()), "{fault} is there twice");
        assert!(!fault.remedy().is_empty());
    }
}

#[test]
fn whatever_is_latched_the_outputs_are_safe() {
    let safe = Outputs {
        bridge: Bridge::Off,
        brake: Brake::On,
        tracks: Tracks::Diagnostic,
    };
    for fault in Fault::ALL {
        for armed in [false, true] {
            assert_eq!(Outputs::of(fault.into(), armed), safe, "{fault}");
        }
        let mut app = AppOnHost::new();
        app.load(&UNDECLARED);
        for _ in 0..10 * TICKS_PER_CONTROL {
            app.tick();
        }
        assert_ne!(app.wiring.duty(), 0);
        assert_ne!(app.wiring.tracks(), DIAGNOSTIC);
        app.wiring.trip(fault);
        for _ in 0..10 * TICKS_PER_CONTROL {
            app.tick();
            app.wiring.drive(1000);
            assert_eq!(app.wiring.duty(), 0, "{fault}");
            assert_eq!(app.wiring.tracks(), DIAGNOSTIC, "{fault}");
        }
        let cause = app.wiring.latch().first();
        let tick = 10 * TICKS_PER_CONTROL;
        assert_eq!(cause, Some(Cause { fault, tick }));
    }
}

#[test]
fn disarmed_the_load_is_held_and_the_tracks_tell_where() {
    let outputs = Outputs::of(Faults::NONE, false);
    assert_eq!(outputs.bridge, Bridge::Off);
    assert_eq!(outputs.brake, Brake::On);
    assert_eq!(outputs.tracks, Tracks::Position);
    let mut app = AppOnHost::new();
    app.load(&UNDECLARED);
    for _ in 0..10 * TICKS_PER_CONTROL {
        app.tick();
    }
    app.wiring.latch().disarm();
    assert_eq!(app.wiring.duty(), 0);
    assert_ne!(app.wiring.tracks(), DIAGNOSTIC);
}

proptest! {
    #[test]
    fn the_first_cause_stays_with_its_time_and_every_one_is_in_the_set(
        trips in prop::collection::vec((fault(), any::<u32>()), 1..40),
    ) {
        let latch = Latch::new();
        let mut causes = Faults::NONE;
        for &(fault, tick) in &trips {
            latch.trip(fault, tick);
            causes = causes | fault.into();
            let (fault, tick) = trips[0];
            prop_assert_eq!(latch.first(), Some(Cause { fault, tick }));
            prop_assert_eq!(latch.causes(), causes);
            prop_assert_eq!(latch.outputs(), Outputs::SAFE);
        }
        let distinct: HashSet<Fault> = trips.iter().map(|&(fault, _)| fault).collect();
        prop_assert_eq!(causes.iter().count(), distinct.len());
        prop_assert_eq!(latch.arm(), Err(causes));
        prop_assert_eq!(latch.clear(), Ok(()));
        prop_assert_eq!((latch.first(), latch.causes()), (None, Faults::NONE));
        prop_assert_eq!(latch.arm(), Ok(()));
    }

    #[test]
    fn a_latch_is_cleared_only_disarmed_and_with_every_condition_gone(
        present in prop::collection::vec(fault(), 1..4),
        gone in fault(),
    ) {
        let latch = Latch::new();
        prop_assert_eq!(latch.arm(), Ok(()));
        let holding = present.iter().fold(Faults::NONE, |set, &fault| set | fault.into());
        latch.watch(gone.into(), 1);
        latch.watch(holding, 2);
        prop_assert_eq!(latch.clear(), Err(NotCleared::Armed));
        latch.disarm();
        prop_assert_eq!(latch.clear(), Err(NotCleared::Present(holding)));
        let first = Some(Cause { fault: gone, tick: 1 });
        prop_assert_eq!(latch.first(), first);
        prop_assert_eq!(latch.causes(), holding | gone.into());
        latch.watch(Faults::NONE, 3);
        prop_assert_eq!(latch.first(), first, "a condition that ends clears nothing");
        prop_assert_eq!(latch.clear(), Ok(()));
        prop_assert!(!latch.is_tripped());
    }
}

#[test]
fn a_fault_that_comes_while_the_latch_is_cleared_stays() {
    for before in Fault::ALL {
        for between in Fault::ALL {
            let latch = Latch::new();
            latch.trip(before, 1);
            let clearing = latch.begin_to_clear();
            assert!(latch.is_tripped());
            latch.trip(between, 2);
            assert_eq!(clearing.end(), Err(NotCleared::Renewed));
            let first = Cause {
                fault: before,
                tick: 1,
            };
            assert_eq!(latch.first(), Some(first));
            assert_eq!(latch.clear(), Ok(()));
        }
    }
    // With nothing latched too, and nobody sees that somebody looked.
    let latch = Latch::new();
    let clearing = latch.begin_to_clear();
    assert!(!latch.is_tripped() && latch.first().is_none());
    assert_eq!(latch.outputs(), Outputs::of(Faults::NONE, false));
    latch.trip(Fault::Panic, 7);
    assert_eq!(clearing.end(), Err(NotCleared::Renewed));
    let first = Cause {
        fault: Fault::Panic,
        tick: 7,
    };
    assert_eq!(latch.first(), Some(first));
    // And whoever is refused leaves nothing behind.
    assert_eq!(latch.arm(), Err(Fault::Panic.into()));
    assert_eq!(latch.clear(), Ok(()));
    assert_eq!(latch.arm(), Ok(()));
    assert_eq!(latch.clear(), Err(NotCleared::Armed));
    assert_eq!(latch.outputs().bridge, Bridge::Driven);
}

/// Two trip, one reads and clears, all at once, until that one has cleared often enough:
/// which of the threads runs when is the scheduler's affair.
#[test]
fn no_cause_is_latched_without_a_first_one_and_none_is_lost() {
    const CLEARED: u32 = 1_000;
    let tripped = [Fault::Panic, Fault::StopReached];
    let latch = Latch::new();
    let done = AtomicBool::new(false);
    let trip = |fault: Fault| {
        let mut tick = 0;
        while !done.load(Ordering::Relaxed) {
            latch.trip(fault, tick);
            tick += 1;
            thread::yield_now();
        }
    };
    let never_tripped = thread::scope(|scope| {
        for fault in tripped {
            scope.spawn(move || trip(fault));
        }
        let mut cleared = 0;
        let mut never_tripped = None;
        while cleared < CLEARED && never_tripped.is_none() {
            let Some(cause) = latch.first() else {
                thread::yield_now();
                continue;
            };
            never_tripped = (!tripped.contains(&cause.fault)).then_some(cause);
            cleared += u32::from(latch.clear().is_ok());
        }
        done.store(true, Ordering::Relaxed);
        never_tripped
    });
    assert_eq!(
        never_tripped, None,
        "a cause that none of the threads tripped"
    );
    latch.trip(Fault::StopReached, 0);
    latch.trip(Fault::Panic, 0);
    let both = Faults::from(Fault::StopReached) | Fault::Panic.into();
    assert_eq!(latch.causes(), both);
    assert!(latch.first().is_some());
}

#[test]
fn a_reset_stands_for_what_came_before_it() {
    let none = ResetFlags::default();
    let power = ResetFlags {
        power_on: true,
        brown_out: true,
        ..none
    };
    let software = ResetFlags {
        software: true,
        ..none
    };
    let watchdog = ResetFlags {
        watchdog: true,
        ..none
    };
    let brown_out = ResetFlags {
        brown_out: true,
        ..none
    };
    // A RAM without power may hold anything.
    assert_eq!(power.fault(Some(Fault::Panic)), None);
    assert_eq!(none.fault(None), None, "the reset button");
    assert_eq!(software.fault(None), Some(Fault::UnexpectedReset));
    assert_eq!(software.fault(Some(Fault::Panic)), Some(Fault::Panic));
    assert_eq!(watchdog.fault(None), Some(Fault::Watchdog));
    let stack = Some(Fault::StackOverflow);
    assert_eq!(watchdog.fault(stack), stack);
    assert_eq!(brown_out.fault(None), Some(Fault::BrownOut));
}

proptest! {
    #[test]
    fn last_words_are_read_as_they_were_left_up_to_their_length(
        fault in fault(),
        text in "\\PC{0,200}",
    ) {
        let mut left = LastWords::NONE;
        left.write(fault, format_args!("{text}"));
        let (read, kept) = left.read().unwrap();
        prop_assert_eq!(read, fault);
        prop_assert!(text.starts_with(kept), "{kept}");
        // Whole characters, as many as there is room for.
        let room = text.len() <= TEXT || kept.len() + 4 > TEXT;
        prop_assert!(room && (kept.len() == text.len() || text.len() > TEXT), "{}", kept.len());
    }

    #[test]
    fn last_words_that_are_damaged_were_never_left(word in 0_usize..34, bit in 0_u32..32) {
        let mut left = LastWords::NONE;
        left.write(Fault::Panic, format_args!("attempt to divide by zero at plant.rs:12"));
        // SAFETY: 34 words, of which any value is one.
        let words: &mut [u32; 34] = unsafe { &mut *(&raw mut left).cast() };
        words[word] ^= 1 << bit;
        prop_assert_eq!(left.read(), None);
    }
}

#[test]
fn a_ram_that_was_without_power_has_no_last_words() {
    let mut random = Random::new(3, 0);
    for _ in 0..1000 {
        let words: [u32; 34] = std::array::from_fn(|_| random.bits());
        // SAFETY: as many bytes, and any value of them is one.
        let left: LastWords = unsafe { std::mem::transmute(words) };
        assert_eq!(left.read(), None);
    }
    assert_eq!(LastWords::NONE.read(), None);
}

const LIMITS: Limits = Limits {
    peak_current: 20.0,
    continuous_current: 5.0,
    current_limit: 15.0,
    peak_time: 0.5,
    load: 0.24,
    supply: [18.0, 30.0],
    supply_time: 2e-3,
    command_timeout: 0.0,
};

fn encoder() -> back_emf::Coefficients {
    let resolution = EMA.converters.position.unit();
    let tolerances = Tolerances::INDUSTRIAL;
    back_emf::Coefficients::new(
        &EMA.plant,
        &EMA.limits,
        tolerances,
        resolution,
        CONTROL_PERIOD,
    )
    .unwrap()
}

fn observers() -> Observers {
    let resolution = EMA.converters.position.unit();
    let tolerances = Tolerances::INDUSTRIAL;
    let load = LIMITS.load;
    let torque =
        following::Coefficients::new(&EMA.plant, tolerances, load, resolution, CONTROL_PERIOD);
    Observers {
        winding: encoder(),
        torque: torque.unwrap(),
    }
}

fn monitors() -> Monitors {
    Monitors::new(LIMITS, observers(), CONTROL_PERIOD).unwrap()
}

/// Nothing moves, nothing flows, and the bridge is off.
const QUIET: Measured = Measured {
    reading: Reading {
        position: 0.0,
        moved: 0.0,
        current: 0.0,
        voltage: None,
        spread: 0.0,
    },
    supply: 24.0,
    switches: [false; 2],
};

fn with_current(current: f32) -> Measured {
    Measured {
        reading: Reading {
            current,
            ..QUIET.reading
        },
        ..QUIET
    }
}

fn with_supply(supply: f32) -> Measured {
    Measured { supply, ..QUIET }
}

/// Steps until a fault is there.
fn steps_until(fault: Fault, measured: &Measured) -> Option<u32> {
    let mut monitors = monitors();
    (1..10_000).find(|_| monitors.step(measured).contains(fault))
}

#[test]
fn limits_are_kept_to_either_side_and_what_is_not_a_number_is_beyond_all_of_them() {
    for sign in [-1.0, 1.0] {
        assert_eq!(
            steps_until(Fault::OverCurrent, &with_current(sign * 19.9)),
            None
        );
        let over = with_current(sign * 20.1);
        assert_eq!(steps_until(Fault::OverCurrent, &over), Some(1));
    }
    // Two milliseconds are borne, the step behind them is not.
    assert_eq!(steps_until(Fault::OverVoltage, &with_supply(30.1)), Some(3));
    assert_eq!(
        steps_until(Fault::UnderVoltage, &with_supply(17.9)),
        Some(3)
    );
    for inside in [18.0, 30.0] {
        let mut monitors = monitors();
        for _ in 0..100 {
            assert_eq!(monitors.step(&with_supply(inside)), Faults::NONE);
        }
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let current = monitors().step(&with_current(bad));
        assert_eq!(
            current,
            Faults::from(Fault::NonFinite) | Fault::OverCurrent.into()
        );
        assert_eq!(monitors().step(&with_supply(bad)), Fault::NonFinite.into());
        let mut position = QUIET;
        position.reading.position = bad;
        assert_eq!(monitors().step(&position), Fault::NonFinite.into());
        let mut voltage = QUIET;
        voltage.reading.voltage = Some(bad);
        assert_eq!(monitors().step(&voltage), Fault::NonFinite.into());
        // And nothing of it stays behind.
        let mut monitors = monitors();
        monitors.step(&with_current(bad));
        assert_eq!(monitors.step(&QUIET), Faults::NONE);
    }
    assert_eq!(
        steps_until(Fault::UnderVoltage, &with_supply(f32::NAN)),
        Some(3)
    );
}

/// By the definition of I² t: (i² − 5²) t = (20² − 5²) · 0.5 s.
#[test]
fn a_winding_bears_its_peak_current_for_its_time_and_the_continuous_one_for_ever() {
    let time = |current: f32| {
        let seconds = 375.0 * 0.5 / (current * current - 25.0);
        (seconds / CONTROL_PERIOD) as i64
    };
    for current in [20.0, -15.0, 10.0, 7.0] {
        let steps = steps_until(Fault::Overload, &with_current(current)).unwrap();
        let late = i64::from(steps) - time(current);
        assert!((0..=2).contains(&late), "{current} A: {late} steps late");
    }
    assert_eq!(steps_until(Fault::Overload, &with_current(5.0)), None);
    // What was too hot cools down to the end before it counts as cool.
    let mut monitors = monitors();
    while !monitors.step(&with_current(20.0)).contains(Fault::Overload) {}
    let cooling = (1..).find(|_| monitors.step(&QUIET).is_empty()).unwrap();
    let expected = 375.0 * 0.5 / 25.0 / CONTROL_PERIOD;
    assert!(
        (cooling as f32 / expected - 1.0).abs() < 0.01,
        "{cooling} steps"
    );
}

#[test]
fn a_limit_switch_stops_what_drives_into_it_and_lets_out_what_leaves_it() {
    let step = |voltage: Option<f32>, switches: [bool; 2]| {
        let mut measured = QUIET;
        measured.reading.voltage = voltage;
        measured.switches = switches;
        monitors().step(&measured).contains(Fault::StopReached)
    };
    assert!(step(Some(1.0), [false, true]));
    assert!(step(Some(-1.0), [true, false]));
    assert!(!step(Some(-1.0), [false, true]));
    assert!(!step(Some(1.0), [true, false]));
    assert!(!step(Some(1.0), [false, false]));
    assert!(!step(None, [true, true]));
    assert!(step(Some(1.0), [true, true]), "a broken wire to both");
}

#[test]
fn impossible_limits_are_refused_by_name() {
    let name = |limits: Limits| {
        Monitors::new(limits, observers(), CONTROL_PERIOD)
            .unwrap_err()
            .name
    };
    assert_eq!(
        name(Limits {
            peak_current: 5.0,
            ..LIMITS
        }),
        "peak_current"
    );
    assert_eq!(
        name(Limits {
            continuous_current: 0.0,
            ..LIMITS
        }),
        "continuous_current"
    );
    for current_limit in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let limits = Limits {
            current_limit,
            ..LIMITS
        };
        assert_eq!(name(limits), "current_limit");
    }
    assert_eq!(
        name(Limits {
            peak_time: f32::NAN,
            ..LIMITS
        }),
        "peak_time"
    );
    assert_eq!(
        name(Limits {
            supply: [30.0, 18.0],
            ..LIMITS
        }),
        "supply"
    );
    assert_eq!(
        name(Limits {
            supply_time: -1.0,
            ..LIMITS
        }),
        "supply_time"
    );
    let torque = Parameters {
        drive: Drive::Torque,
        ..EMA.plant
    };
    let tolerances = Tolerances::INDUSTRIAL;
    let refused =
        back_emf::Coefficients::new(&torque, &EMA.limits, tolerances, 0.0, CONTROL_PERIOD);
    assert_eq!(refused.unwrap_err().name, "drive");
    for period in [0.0, 0.1, f32::NAN] {
        let refused = back_emf::Coefficients::new(&EMA.plant, &EMA.limits, tolerances, 0.0, period);
        assert_eq!(refused.unwrap_err().name, "period");
    }
}

/// Of the bridge, V.
const SUPPLY: f32 = 24.0;

/// The encoder's monitor over a whole recording: the faults and the steps at which they began.
fn judge(machine: &Machine, samples: &[(f32, f32, f32)]) -> Vec<(usize, Fault)> {
    let resolution = machine.converters.position.unit();
    let tolerances = Tolerances::INDUSTRIAL;
    let observer = back_emf::Coefficients::new(
        &machine.plant,
        &machine.limits,
        tolerances,
        resolution,
        CONTROL_PERIOD,
    );
    let observer = observer.unwrap();
    let mut state = back_emf::State::default();
    let (mut stood, mut before) = (None, None);
    let mut found = Vec::new();
    for (step, &(input, position, current)) in samples.iter().enumerate() {
        let reading = Reading {
            position,
            moved: position - before.replace(position).unwrap_or(position),
            current,
            voltage: stood.replace(input),
            spread: 0.0,
        };
        if let Some(fault) = observer.step(&mut state, &reading, SUPPLY) {
            found.push((step, fault));
        }
        observer.learn(&mut state);
    }
    found
}

#[test]
fn a_sound_encoder_is_believed_whatever_the_friction() {
    for experiment in [UNDECLARED, WEAR, BRAKE] {
        let (samples, _) = AppOnHost::new().run(&experiment);
        let converters = &experiment.machine.converters;
        let seen: Vec<(f32, f32, f32)> = samples
            .iter()
            .map(|sample| {
                (
                    converters.bridge.value(sample.duty),
                    converters.position.value(sample.position),
                    converters.current.value(sample.current),
                )
            })
            .collect();
        assert_eq!(judge(&experiment.machine, &seen), [], "{}", experiment.name);
    }
}

/// The actuator in its loop, with an encoder that may do what it likes.
struct Stand {
    actuator: Actuator,
    state: State,
    pid: pid::Coefficients,
    loop_state: pid::State,
    /// Mean current over the control period before, A.
    mean: f32,
    seen: Vec<(f32, f32, f32)>,
}

impl Stand {
    fn new(plant: &Parameters) -> Self {
        Self {
            actuator: Actuator::build(plant, PLANT_PERIOD).unwrap(),
            state: State::new(0.0, 0.0),
            pid: EMA.position_loop.build(CONTROL_PERIOD).unwrap(),
            loop_state: pid::State::default(),
            mean: 0.0,
            seen: Vec::new(),
        }
    }

    /// Control steps towards a position, with what the encoder makes of the true one, and `lost` V
    /// less at the winding than was told.
    fn run(&mut self, steps: usize, command: f32, lost: f32, encoder: impl Fn(f32) -> f32) {
        let converters = &EMA.converters;
        for _ in 0..steps {
            let read = |converter: firmware::app::conversion::Converter, value| {
                converter.value(converter.counts(value).unwrap())
            };
            let position = read(converters.position, encoder(self.state.position.value()));
            let current = read(converters.current, self.mean);
            let voltage = self
                .pid
                .step(&mut self.loop_state, command, position)
                .unwrap();
            let voltage = read(converters.bridge, voltage);
            self.seen.push((voltage, position, current));
            let opposed = lost.min(voltage.abs()).copysign(self.state.current);
            let mut sum = 0.0;
            for _ in 0..TICKS_PER_CONTROL {
                self.actuator
                    .step(&mut self.state, voltage - opposed)
                    .unwrap();
                sum += self.state.current;
            }
            self.mean = sum / TICKS_PER_CONTROL as f32;
        }
    }
}

fn winding(resistance: f32, torque_constant: f32, inductance: f32) -> Parameters {
    let Drive::Voltage {
        resistance: r,
        inductance: l,
        torque_constant: k,
    } = EMA.plant.drive
    else {
        panic!("the actuator has a winding");
    };
    Parameters {
        drive: Drive::Voltage {
            resistance: r * resistance,
            inductance: l * inductance,
            torque_constant: k * torque_constant,
        },
        ..EMA.plant
    }
}

#[test]
fn a_sound_encoder_is_believed_on_a_winding_within_its_tolerances() {
    for resistance in [0.65, 1.0, 1.34] {
        for torque_constant in [0.81, 1.0, 1.19] {
            for inductance in [0.71, 1.29] {
                let plant = winding(resistance, torque_constant, inductance);
                for lost in [0.0, 1.0] {
                    let mut stand = Stand::new(&plant);
                    for command in [0.8, -0.8, 0.1, 0.9, -0.9, 0.0] {
                        stand.run(150, command, lost, |position| position);
                    }
                    assert_eq!(judge(&EMA, &stand.seen), [], "{:?}, {lost} V", plant.drive);
                }
            }
        }
    }
}

/// From where the doc comment of the observer says that an encoder can be told to be wrong.
#[test]
fn an_encoder_that_fails_is_found_within_three_time_constants() {
    let endless = Parameters {
        lower_stop: f32::NEG_INFINITY,
        upper_stop: f32::INFINITY,
        ..EMA.plant
    };
    let Drive::Voltage {
        resistance,
        torque_constant,
        ..
    } = EMA.plant.drive
    else {
        panic!("the actuator has a winding");
    };
    let tolerances = Tolerances::INDUSTRIAL;
    let within = (3.0 * TIME_CONSTANT / CONTROL_PERIOD) as usize;
    // What the encoder makes of a movement, and movements fast enough to tell.
    let cases = [
        ("without a signal", Fault::EncoderLost, 0.0, [0.5, -0.8]),
        ("backwards", Fault::EncoderImplausible, -1.0, [0.5, -0.8]),
        ("slipping", Fault::EncoderImplausible, 0.3, [4.0, -4.0]),
    ];
    for (name, fault, share, commands) in cases {
        for command in commands {
            let mut stand = Stand::new(&endless);
            let mut onset = None;
            let (step, found) = (0..1000)
                .find_map(|step| {
                    stand.run(1, command, 0.0, |position| share * position);
                    let claimed = share * stand.state.velocity.value();
                    let apart = (stand.state.velocity.value() - claimed).abs();
                    let explained = tolerances.brushes
                        + tolerances.dead_time * SUPPLY
                        + tolerances.resistance * resistance * stand.state.current.abs()
                        + tolerances.torque_constant * torque_constant * claimed.abs();
                    if onset.is_none() && torque_constant * apart > explained {
                        onset = Some(step);
                    }
                    judge(&EMA, &stand.seen).first().copied()
                })
                .expect("no fault");
            println!(
                "{name}, to {command} rad: after {step} ms, {} rad",
                stand.state.position.value()
            );
            assert_eq!(found, fault, "{name}");
            // What the winding told before may have told it sooner.
            let late = onset.map_or(0, |onset| step - onset);
            assert!(late <= within, "{name}: {step}, {late}");
        }
    }
}

#[test]
fn with_the_bridge_off_the_encoder_is_believed_and_a_fault_of_it_is_over() {
    let observer = encoder();
    let mut state = back_emf::State::default();
    let lying = Reading {
        position: 0.0,
        moved: 0.0,
        current: 0.0,
        voltage: Some(24.0),
        spread: 0.0,
    };
    let mut found = None;
    for _ in 0..20 {
        found = observer.step(&mut state, &lying, SUPPLY);
    }
    assert_eq!(found, Some(Fault::EncoderLost));
    for moved in [0.0, 1.0, -1.0] {
        let off = Reading {
            position: moved,
            moved,
            current: 0.0,
            voltage: None,
            spread: 0.0,
        };
        assert_eq!(observer.step(&mut state, &off, SUPPLY), None);
    }
}

/// What no converter makes. Behind it, and the bridge off for a step, a sound reading is believed.
#[test]
fn readings_that_are_no_numbers_or_enormous_are_borne_by_the_encoders_monitor() {
    let observer = encoder();
    let values = [0.0, 1.0, 1e20, f32::MAX, f32::INFINITY, f32::NAN];
    let signed = values.map(|value| [value, -value]).concat();
    let mut random = Random::new(1, 0);
    let mut any = || signed[(random.uniform() * signed.len() as f32) as usize % signed.len()];
    let rest = Reading {
        position: 0.0,
        moved: 0.0,
        current: 0.0,
        voltage: Some(0.0),
        spread: 0.0,
    };
    let mut found = 0;
    for _ in 0..1000 {
        let mut state = back_emf::State::default();
        for _ in 0..10 {
            let reading = Reading {
                position: any(),
                moved: any(),
                current: any(),
                voltage: Some(any()),
                spread: any().abs(),
            };
            found += u32::from(observer.step(&mut state, &reading, any()).is_some());
            observer.learn(&mut state);
        }
        let off = Reading {
            voltage: None,
            ..rest
        };
        for reading in [off, rest, rest, rest] {
            assert_eq!(observer.step(&mut state, &reading, SUPPLY), None);
            observer.learn(&mut state);
        }
    }
    assert!(found > 0);
}
