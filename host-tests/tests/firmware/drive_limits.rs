//! What the drive keeps within its limits whatever it is told, on actuators that are not as declared.

use crate::any_drive::{any_actuator, any_command, either_way, image, perform, started, winding};
use firmware::app::capture::QUANTITIES;
use firmware::app::fault::Fault;
use firmware::app::fault::monitor::CURRENT_SHARE;
use firmware::app::machine::EMA;
use firmware::app::operation::homing::SWITCH_STEPS;
use firmware::app::timing::CONTROL_PERIOD;
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};
use model_core::numeric::random::Random;
use model_core::plant::State;
use model_core::plant::parameters::{Drive, Parameters};

/// What resistance and inductance of a winding are off by.
const OFF: f32 = 0.3;

/// Volts that act at once, and are observed later, make this many amperes: 1/(R + L/τ) with τ of four ticks.
fn amperes_per_volt() -> f32 {
    let [resistance, inductance, _] = winding();
    1.0 / (resistance + inductance / 200e-6)
}

/// Declared but for the winding.
fn wound(resistance: f32, inductance: f32) -> Parameters {
    let [declared_resistance, declared_inductance, torque_constant] = winding();
    Parameters {
        drive: Drive::Voltage {
            resistance: resistance * declared_resistance,
            inductance: inductance * declared_inductance,
            torque_constant,
        },
        ..EMA.plant
    }
}

/// With other stops, as far either way.
fn stopped_at(plant: Parameters, stop: f32) -> Parameters {
    Parameters {
        lower_stop: -stop,
        upper_stop: stop,
        ..plant
    }
}

/// Largest current of so many milliseconds, A.
fn peak(image: &mut OperationOnHost<Motor>, milliseconds: u32) -> f32 {
    let mut peak = 0.0_f32;
    for _ in 0..20 * milliseconds {
        image.tick();
        peak = peak.max(image.plant.state.current.abs());
    }
    peak
}

/// Says a line, while the time goes on.
fn say(image: &mut OperationOnHost<Motor>, line: &str) {
    line.bytes()
        .chain([b'\r'])
        .for_each(|byte| image.byte(byte));
}

/// The hardest that a drive can be told: mode, line, milliseconds.
const HARD: [(&str, &str, u32); 4] = [
    ("mode voltage", "step 0 24", 150),
    ("mode voltage", "step 24 -24 0.1", 250),
    ("mode position", "step 0.9 -0.9 0.15", 400),
    ("mode position", "triangle 0 0.8 10", 400),
];

/// Largest current over all that is hard, on all windings, A.
fn hardest(limit: f32) -> f32 {
    let mut worst = 0.0_f32;
    let corners = [1.0 - OFF, 1.0, 1.0 + OFF];
    let windings = corners.map(|r| corners.map(|l| wound(r, l)));
    for plant in windings.into_iter().flatten() {
        // Blocked, between its stops, and free.
        for plant in [1e-4, 1.0, 1e3].map(|stop| stopped_at(plant, stop)) {
            for ((mode, line, milliseconds), late) in HARD
                .into_iter()
                .flat_map(|hard| [(hard, false), (hard, true)])
            {
                for supply in [20.0, 24.0, 29.5] {
                    let mut image = OperationOnHost::controller(&SharedFlash::new(), &plant);
                    image.plant.supply = supply;
                    image.plant.late = late;
                    image.plant.noise = Some(Random::new(7, 0));
                    image.run_ms(20);
                    let set = format!("set current_limit {limit}");
                    perform(&mut image, &[&set, mode, "arm"]);
                    say(&mut image, line);
                    worst = worst.max(peak(&mut image, milliseconds));
                }
            }
        }
    }
    worst
}

/// What comes on top of a limit: an actuator that hits its stop at full speed loses its back-EMF at once, two radians
/// of way under the limit's current, and a winding whose inductance is off takes a part of each step of the voltage
/// for one.
#[test]
fn the_current_stays_at_its_limit_in_every_mode_on_windings_off_by_a_third() {
    let [_, _, torque_constant] = winding();
    for limit in [4.0_f32, 10.0, 20.0] {
        let worst = hardest(limit);
        // From stop to stop, against friction alone.
        let torque = torque_constant * limit - EMA.plant.coulomb.forward;
        let speed = (2.0 * torque / EMA.plant.inertia * 2.0).sqrt();
        let most = limit + amperes_per_volt() * torque_constant * speed;
        println!("{worst:.2} A with a limit of {limit} A, {most:.2} A at most");
        assert!(worst <= most, "{worst} A with a limit of {limit} A");
        // It is a limit, not a smaller one.
        assert!(worst >= 0.99 * limit.min(20.0), "{worst} A");
    }
}

/// A limit that is set above what the bridge may carry ends below it.
#[test]
fn no_limit_is_nearer_to_the_peak_than_its_share() {
    let plant = stopped_at(wound(1.0 - OFF, 1.0), 1e-4);
    for (set, limit) in [
        ("set peak_current 8", 8.0 * CURRENT_SHARE),
        ("set current_limit 24.9", 24.5 * CURRENT_SHARE),
        ("set current_limit 3", 3.0),
    ] {
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &plant);
        perform(
            &mut image,
            &[set, "set load 3", "mode voltage", "arm", "step 0 24"],
        );
        image.run_ms(100);
        let current = image.plant.state.current;
        assert!((current - limit).abs() < 0.02 * limit, "{set}: {current} A");
        assert!(image.wiring.latch().causes().is_empty());
    }
}

#[test]
fn the_current_stays_at_its_limit_whatever_fails_at_any_time() {
    const RUNS: u64 = 1000;
    let limit = EMA.limits.current_limit;
    let (mut worst, mut near) = (0.0_f32, 0);
    for seed in 0..RUNS {
        let mut random = Random::new(seed, 5);
        let mut image = image(&SharedFlash::new(), &mut random);
        image.plant.late = random.uniform() < 0.5;
        let (mode, line) = any_command(&mut random);
        perform(&mut image, &[mode, "arm"]);
        say(&mut image, &line);
        let mut most = peak(&mut image, (300.0 * random.uniform()) as u32);
        match (4.0 * random.uniform()) as u32 {
            0 => image.plant.block(),
            1 => image.plant.encoder = [0.0, -1.0, 0.5][(3.0 * random.uniform()) as usize],
            2 => {
                image.plant.supply = (image.plant.supply + 6.0 * either_way(&mut random)).min(29.9)
            }
            _ => say(&mut image, "step 0 0"),
        }
        most = most.max(peak(&mut image, 400));
        assert!(most <= 1.1 * limit, "{seed}: {most} A, {mode}, {line}");
        worst = worst.max(most);
        near += u32::from(most > 0.95 * limit);
    }
    println!("{worst:.2} A in {RUNS} runs, {near} of them at the limit");
    assert!(near > 30, "{near}");
}

/// A loop that is not told of the limit winds up while the current is held at it: here to 20 V, which its integral of 11 V/s
/// takes more than a second to give back.
#[test]
fn the_position_loop_does_not_wind_up_while_the_current_is_limited() {
    let plant = stopped_at(EMA.plant, 1e-4);
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &plant);
    let lines = [
        "set current_limit 2",
        "set load 3",
        "arm",
        "step 0.1 -0.1 2",
    ];
    perform(&mut image, &lines);
    image.run_ms(1900);
    assert!((image.plant.state.current - 2.0).abs() < 0.1);
    // Turned at 2 s: 2.2 V of proportional action against 2 V less 2.2 V of integral.
    image.run_ms(150);
    let current = image.plant.state.current;
    assert!((current + 2.0).abs() < 0.1, "{current} A");
}

/// Whoever estimates from a log needs the voltage that was applied: here 10 A through 0.7 Ω, where 24 V were told.
#[test]
fn the_log_has_the_voltage_that_the_limit_left() {
    let plant = stopped_at(wound(1.0 - OFF, 1.0), 1e-4);
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &plant);
    let lines = [
        "set current_limit 10",
        "set load 3",
        "record 0 100 command input",
        "mode voltage",
        "arm",
        "step 0 24",
    ];
    perform(&mut image, &lines);
    image.run_ms(150);
    perform(&mut image, &["dump"]);
    image.run_ms(100);
    let asked = image.asked.borrow();
    assert_eq!(asked.rows.len(), 100);
    let last = asked.rows[99][1];
    let resistance = (1.0 - OFF) * winding()[0];
    assert!((last - 10.0 * resistance).abs() < 0.1, "{last} V");
    // The first row after the command: most of the period at 24 V, then what the limit leaves.
    let first = asked.rows.iter().map(|row| row[1]).fold(0.0, f32::max);
    assert!(first > 10.0 && first < 22.0, "{first} V");
}

/// What a sound drive is told within its limits is driven as if there were none: the log has the same duties.
#[test]
fn a_motion_below_the_limit_is_not_touched_by_it() {
    for line in [
        "sine 0 0.5 1",
        "triangle 0 0.3 2",
        "sweep 0 0.3 0.5 3 2",
        "ramp 0 0.5 1",
    ] {
        let runs = ["set current_limit 15", "set current_limit 20"].map(|set| {
            let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
            perform(
                &mut image,
                &[
                    set,
                    "record 0 500 command command input current_a",
                    "arm",
                    line,
                ],
            );
            let most = peak(&mut image, 1500);
            assert!(most < 15.0, "{line}: {most} A");
            perform(&mut image, &["dump"]);
            image.run_ms(1500);
            assert!(image.wiring.latch().causes().is_empty());
            let rows = image.asked.take().rows;
            // What was not asked for is no number.
            rows.concat()
                .into_iter()
                .map(f32::to_bits)
                .collect::<Vec<_>>()
        });
        assert_eq!(runs[0].len(), 500 * QUANTITIES);
        assert_eq!(runs[0], runs[1], "{line}");
    }
}

#[test]
fn the_speed_stays_at_its_limit_in_every_mode_under_any_load() {
    const RUNS: u64 = 400;
    let (mut worst, mut near) = (0.0_f32, 0);
    for seed in 0..RUNS {
        let mut random = Random::new(seed, 6);
        let actuator = any_actuator(&mut random);
        let free = random.uniform() < 0.5;
        let actuator = if free {
            stopped_at(actuator, 1e3)
        } else {
            actuator
        };
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
        image.plant.noise = Some(Random::new(random.bits().into(), 2));
        let limit = [5.0_f32, 20.0, 60.0][(3.0 * random.uniform()) as usize];
        let (mode, line) = if free {
            let volts = (12.0 + 12.0 * random.uniform()).copysign(either_way(&mut random));
            ("mode voltage", format!("step 0 {volts} 0.02"))
        } else {
            any_command(&mut random)
        };
        perform(
            &mut image,
            &[&format!("set speed_limit {limit}"), "zero", mode, "arm"],
        );
        say(&mut image, &line);
        let (mut most, mut last) = (0.0_f32, 0.0_f32);
        for millisecond in 0..400 {
            image.run_ms(1);
            let speed = image.plant.state.velocity.value().abs();
            most = most.max(speed);
            last = if millisecond < 200 {
                0.0
            } else {
                last.max(speed)
            };
        }
        let causes = image.wiring.latch().causes();
        assert!(
            causes.is_empty(),
            "{seed}: {causes}, {limit} rad/s, {mode}, {line}"
        );
        // As docs/faults.md has it: 2.5 rad/s, and the encoder's step.
        assert!(
            most <= limit + 4.0,
            "{seed}: {most} rad/s of {limit}, {mode}, {line}"
        );
        worst = worst.max(most - limit);
        if free {
            // For good it is the limit itself, within two of the encoder's steps in a period.
            let step = 2.0 * EMA.converters.position.unit() / CONTROL_PERIOD;
            assert!(
                (last - limit).abs() <= step + 0.02 * limit,
                "{seed}: {last} of {limit}, {line}"
            );
            near += 1;
        }
    }
    println!("at most {worst:.2} rad/s beyond the limit");
    assert!(near > 100, "{near}");
}

#[test]
fn an_actuator_that_its_load_drives_beyond_the_limit_is_let_go() {
    // More than the current's limit holds.
    let actuator = Parameters {
        offset: 1.8,
        ..stopped_at(EMA.plant, 1e3)
    };
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
    let lines = ["set load 1.8", "set speed_limit 20", "mode voltage", "arm"];
    perform(&mut image, &lines);
    image.run_ms(200);
    assert!(image.wiring.latch().causes().contains(Fault::OverSpeed));
    assert!(!image.plant.is_driven());
}

/// A voltage drives the actuator to the end of its range at any speed that it reaches, under any load that is borne.
#[test]
fn a_voltage_ends_at_the_limit_of_the_position() {
    const RUNS: u64 = 300;
    let mut worst = 0.0_f32;
    for seed in 0..RUNS {
        let mut random = Random::new(seed, 7);
        let actuator = stopped_at(any_actuator(&mut random), 1e3);
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
        image.plant.noise = Some(Random::new(random.bits().into(), 2));
        let range = [-0.2 - 0.8 * random.uniform(), 0.2 + 3.8 * random.uniform()];
        let volts = (12.0 + 12.0 * random.uniform()).copysign(either_way(&mut random));
        let [lower, upper] = range;
        let lines = [
            &format!("set position_minimum {lower}"),
            &format!("set position_maximum {upper}"),
            "zero",
            "mode voltage",
            "arm",
        ];
        perform(&mut image, &lines);
        // There and back.
        for volts in [volts, -volts] {
            say(&mut image, &format!("step 0 {volts}"));
            for _ in 0..600 {
                image.run_ms(1);
                let position = image.plant.state.position.value();
                let beyond = (position - upper).max(lower - position);
                worst = worst.max(beyond);
                assert!(
                    beyond <= 0.005,
                    "{seed}: {beyond} rad beyond {range:?} at {volts} V"
                );
            }
            let end = if volts > 0.0 { upper } else { lower };
            let off = (image.plant.state.position.value() - end).abs();
            assert!(off < 0.02, "{seed}: {off} rad from {end}");
            let causes = image.wiring.latch().causes();
            assert!(causes.is_empty(), "{seed}: {causes}");
        }
    }
    println!("at most {worst:.4} rad beyond the range");
}

/// As after its shaft was turned by hand: nothing moves before it is told to, and then no faster than the limit.
#[test]
fn a_drive_that_is_armed_beyond_its_range_stays_where_it_is_until_it_is_told_to_come_back() {
    for side in [-1.0_f32, 1.0] {
        let actuator = stopped_at(EMA.plant, 1e3);
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
        let range = [0.2_f32, 0.8].map(|end| end * side);
        let [lower, upper] = [range[0].min(range[1]), range[0].max(range[1])];
        let lines = [
            &format!("set position_minimum {lower}"),
            &format!("set position_maximum {upper}"),
            "set speed_limit 5",
            "zero",
            "mode voltage",
            "arm",
        ];
        perform(&mut image, &lines);
        let mut fastest = 0.0_f32;
        for _ in 0..300 {
            image.run_ms(1);
            fastest = fastest.max(image.plant.state.velocity.value().abs());
        }
        assert!(fastest < 0.1, "{fastest} rad/s at 0 V");
        // Outwards it does not go, whatever is told.
        say(&mut image, &format!("step 0 {}", -12.0 * side));
        image.run_ms(300);
        let position = image.plant.state.position.value();
        assert!(position.abs() < 0.02, "{position} rad");
        say(&mut image, &format!("step 0 {}", 12.0 * side));
        for _ in 0..600 {
            image.run_ms(1);
            fastest = fastest.max(image.plant.state.velocity.value().abs());
        }
        assert!(fastest < 9.0, "{fastest} rad/s of 5");
        let end = image.plant.state.position.value();
        assert!((end - 0.8 * side).abs() < 0.005, "{end} rad");
        assert!(image.wiring.latch().causes().is_empty());
    }
}

#[test]
fn a_limited_position_has_to_be_known_and_its_set_points_are_within() {
    let flash = SharedFlash::new();
    let mut image = OperationOnHost::controller(&flash, &EMA.plant);
    perform(&mut image, &["set position_maximum 0.5"]);
    assert!(
        image
            .line("arm")
            .starts_with("refused: the position is limited")
    );
    perform(&mut image, &["zero", "arm", "step 0 0.5", "sine 0 0.5 1"]);
    for line in [
        "step 0 0.51",
        "ramp 0.6 0 1",
        "sine 0.1 0.45 1",
        "triangle 0 0.6 1",
        "sweep 0 0.6 1 2 3",
    ] {
        let refused = "refused: signal must stay from position_minimum to position_maximum";
        assert_eq!(image.line(line), refused, "{line}");
    }
    assert_eq!(
        image.line("set position_maximum 0.9"),
        "refused: the drive is armed; `disarm` it first"
    );
    perform(&mut image, &["disarm"]);
    assert_eq!(
        image.line("set position_minimum 0.5"),
        "refused: position_minimum must be below position_maximum"
    );
    assert_eq!(
        image.line("set current_limit 2"),
        "refused: current_limit must hold the load, for a position that is limited"
    );
    // After a restart it is anywhere.
    perform(&mut image, &["save"]);
    let mut restarted = OperationOnHost::controller(&flash, &EMA.plant);
    assert!(
        restarted
            .line("arm")
            .starts_with("refused: the position is limited")
    );
    perform(&mut restarted, &["zero", "arm"]);
}

/// The limit is one of the true current, whatever the sensor's zero is.
#[test]
fn the_current_sensors_zero_is_measured_with_the_bridge_off() {
    let plant = stopped_at(EMA.plant, 1e-4);
    for (declared, offset) in [(0.0_f32, 0.9_f32), (0.0, -0.9), (2.0, -2.0), (2.0, -1.2)] {
        for gain in [0.9_f32, 1.1] {
            let mut image = OperationOnHost::controller(&SharedFlash::new(), &plant);
            image.plant.noise = Some(Random::new(3, 0));
            // What the sensor makes of a current is put right by gain and offset.
            image.plant.offset = offset / gain;
            let lines = [
                &format!("set current_gain {gain}"),
                &format!("set current_offset {declared}"),
                "set current_limit 10",
                "set load 3",
            ];
            perform(&mut image, &lines);
            image.run_ms(40);
            perform(&mut image, &["clear", "mode voltage", "arm", "step 0 24"]);
            image.run_ms(100);
            let current = gain * image.plant.state.current;
            assert!(
                (current - 10.0).abs() < 0.1,
                "{declared} {offset}: {current} A"
            );
        }
    }
}

#[test]
fn a_current_sensor_that_is_too_far_off_keeps_the_drive_disarmed() {
    for offset in [1.2, -1.2, 24.0] {
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
        image.run_ms(100);
        image.plant.offset = offset;
        image.run_ms(100);
        assert!(image.wiring.latch().causes().contains(Fault::CurrentOffset));
        assert!(image.line("arm").contains("current_offset"));
        // Nor does it arm between two blocks.
        for _ in 0..20 {
            let cleared = image.line("clear");
            assert!(cleared.contains("current_offset"), "{cleared}");
            assert!(image.line("arm").contains("current_offset"));
            image.run_ms(1);
        }
        image.plant.offset = 0.0;
        image.run_ms(40);
        perform(&mut image, &["clear", "arm", "step 0 0.5"]);
        image.run_ms(300);
        assert!(image.wiring.latch().causes().is_empty());
    }
}

/// A short in the motor drives the sensor to its end, which is below the peak once a zero is taken off.
#[test]
fn a_sensor_at_its_end_is_an_over_current_whatever_its_zero_is() {
    for offset in [0.9_f32, -0.9] {
        for end in [-1e3_f32, 1e3] {
            let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
            image.plant.offset = offset;
            image.run_ms(100);
            perform(&mut image, &["mode voltage", "arm"]);
            image.run_ms(10);
            assert!(image.wiring.latch().causes().is_empty());
            image.plant.offset = end;
            image.run_ms(1);
            assert!(image.wiring.latch().causes().contains(Fault::OverCurrent));
        }
    }
}

/// Other numbers of the sensor would make the current of a drive that runs jump.
#[test]
fn the_current_sensors_numbers_are_set_disarmed() {
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
    perform(&mut image, &["arm"]);
    for line in ["set current_offset 1", "set current_gain 1.1"] {
        let refused = "refused: the drive is armed; `disarm` it first";
        assert_eq!(image.line(line), refused, "{line}");
    }
}

/// Where the limit switches are, rad.
const EDGES: [f32; 2] = [-0.9, 0.85];

/// The drive after a start with the actuator anywhere, with its position limited within its switches.
fn anywhere(random: &mut Random) -> OperationOnHost<Motor> {
    let mut image = started(&SharedFlash::new(), random);
    image.plant.state = State::new(0.97 * either_way(random), 0.0);
    image.plant.edges = EDGES;
    perform(
        &mut image,
        &["set position_minimum -0.8", "set position_maximum 0.8"],
    );
    image
}

/// How far the position that is measured is from the true one, rad.
fn misread(image: &OperationOnHost<Motor>) -> f32 {
    let reading = image.wiring.measurement().position;
    (EMA.converters.position.value(reading) - image.plant.state.position.value()).abs()
}

#[test]
fn a_switch_that_is_sought_tells_the_position_from_anywhere() {
    let mut worst = 0.0_f32;
    for seed in 0..100 {
        let mut random = Random::new(seed, 9);
        let mut image = anywhere(&mut random);
        let refused = image.line("arm");
        assert!(refused.contains("not known"), "{seed}: {refused}");
        let (name, place) = if random.uniform() < 0.5 {
            ("lower", EDGES[0])
        } else {
            ("upper", EDGES[1])
        };
        let speed = 0.2 + 0.8 * random.uniform();
        let home = format!("home {name} {place} {speed}");
        perform(&mut image, &[&home, "arm"]);
        // There, and perhaps out of the switch before, each over no more than a stroke.
        let most = (2e3 * (EMA.plant.upper_stop - EMA.plant.lower_stop) / speed) as u32;
        // What it moves in the control period in which the switch opens is not told.
        let (mut ran, mut fastest) = (0, 0.0_f32);
        while image.plant.is_driven() && ran < most {
            image.run_ms(1);
            fastest = fastest.max(image.plant.state.velocity.value().abs());
            ran += 1;
        }
        let causes = image.wiring.latch().causes();
        assert!(causes.is_empty(), "{seed}: {causes}, {home}");
        assert!(!image.wiring.latch().is_armed(), "{seed}: {home}");
        image.run_ms(2);
        let bound = fastest * CONTROL_PERIOD + 2.0 * EMA.converters.position.unit();
        let off = misread(&image);
        assert!(off <= bound, "{seed}: {off} rad of {bound}, {home}");
        worst = worst.max(off);
        assert!(image.said.contains("home: "), "{seed}: {}", image.said);

        // Held on the switch, whichever way a loop asks for a little, it is there and no fault.
        perform(&mut image, &["arm"]);
        image.run_ms(300);
        let causes = image.wiring.latch().causes();
        assert!(causes.is_empty(), "{seed}: {causes} on the switch, {home}");
        perform(&mut image, &["disarm"]);

        // The range is that of the true position, at its other end.
        let away = if name == "lower" { 1.0 } else { -1.0 };
        let line = format!("step 0 {}", 12.0 * away);
        perform(&mut image, &["mode voltage", "arm", &line]);
        image.run_ms(700);
        let causes = image.wiring.latch().causes();
        let position = away * image.plant.state.position.value();
        assert!(causes.is_empty(), "{seed}: {causes}, {home}");
        assert!(position <= 0.8 + 4e-3 + off, "{seed}: {position} rad");
    }
    println!("at most {worst} rad off");
}

#[test]
fn without_a_switch_a_search_ends_undriven_and_the_position_is_not_known() {
    for (name, speed) in [("lower", 0.3), ("upper", 2.0)] {
        let mut image = anywhere(&mut Random::new(1, 9));
        image.plant.edges = [f32::NEG_INFINITY, f32::INFINITY];
        perform(&mut image, &[&format!("home {name} 0.9 {speed}"), "arm"]);
        for _ in 0..80 {
            image.run_ms(100);
            image.line("ping");
        }
        assert!(!image.plant.is_driven());
        let ended = image.said.contains("home: no ") || image.wiring.latch().is_tripped();
        assert!(ended, "{}", image.said);
        perform(&mut image, &["disarm", "clear"]);
        let refused = image.line("arm");
        assert!(refused.contains("not known"), "{refused}");
    }
}

#[test]
fn a_search_is_not_commanded_and_ends_with_its_power() {
    let seeking = || {
        let mut image = anywhere(&mut Random::new(2, 9));
        image.plant.state = State::new(0.3, 0.0);
        perform(&mut image, &["home lower -0.9 0.3", "arm"]);
        image.run_ms(200);
        image
    };
    let mut image = seeking();
    for line in ["step 0 0.5", "hold", "mode voltage", "home upper 0.85 1"] {
        let refused = image.line(line);
        assert!(refused.starts_with("refused: "), "{line}: {refused}");
        assert!(image.plant.is_driven());
    }
    // Numbers that are set meanwhile bring no limits of a position that is not known.
    perform(&mut image, &["set load 0.23"]);
    image.run_ms(6000);
    assert!(image.wiring.latch().causes().is_empty());
    assert!(misread(&image) < 2e-3);

    let ends: [fn(&mut OperationOnHost<Motor>); 2] = [
        |image| perform(image, &["disarm"]),
        |image| {
            image.plant.stopped = true;
            image.run_ms(1);
            image.plant.stopped = false;
            image.run_ms(5);
            perform(image, &["disarm", "clear"]);
        },
    ];
    for end in ends {
        let mut image = seeking();
        end(&mut image);
        let refused = image.line("arm");
        assert!(refused.contains("not known"), "{refused}");
        perform(&mut image, &["home lower -0.9 0.3", "arm"]);
        image.run_ms(6000);
        perform(&mut image, &["arm", "step 0 0.2"]);
        image.run_ms(300);
        assert!(image.wiring.latch().causes().is_empty());
    }
}

/// Both switches open at once are a cut cable, whichever of them is sought or was open when the drive was armed.
#[test]
fn a_cable_of_the_switches_that_is_cut_ends_a_search_and_tells_no_position() {
    for seed in 0..100 {
        let mut random = Random::new(seed, 12);
        let mut image = anywhere(&mut random);
        let speed = 0.2 + 0.8 * random.uniform();
        let home = if random.uniform() < 0.5 {
            format!("home lower -0.9 {speed}")
        } else {
            format!("home upper 0.85 {speed}")
        };
        perform(&mut image, &[&home, "arm"]);
        image.run_ms((500.0 * random.uniform()) as u32);
        // It is there: its power goes with the operator's next look.
        if image.said.contains("home: ") {
            image.run_ms(10);
            perform(&mut image, &["arm"]);
        }
        image.plant.switches = [true; 2];
        // Five control steps, and the one that reads it last.
        image.run_ms(7);
        let first = image.wiring.latch().first();
        let first = first.map(|first| first.fault);
        assert_eq!(first, Some(Fault::StopReached), "{seed}: {home}");
        assert!(!image.plant.is_driven());
        image.plant.switches = [false; 2];
        image.run_ms(10);
        perform(&mut image, &["disarm", "clear"]);
        if !image.said.contains("home: ") {
            let refused = image.line("arm");
            assert!(refused.contains("not known"), "{seed}: {refused}, {home}");
        }
    }
}

/// One of the switches sticks at any time, open or closed. The set point goes over the stroke at most, away from the switch and back
/// to it, so the search has an end; where the switch did not open there is none but a fault or "no switch".
#[test]
fn a_switch_that_sticks_during_a_search_leaves_nothing_driven() {
    let stroke = EMA.plant.upper_stop - EMA.plant.lower_stop;
    let (mut named, mut misled, mut missed) = (0, 0, 0);
    for seed in 0..200 {
        let mut random = Random::new(seed, 13);
        let mut image = anywhere(&mut random);
        let speed = 0.5 + 0.5 * random.uniform();
        let sought = usize::from(random.uniform() < 0.5);
        let home = ["home lower -0.9", "home upper 0.85"][sought];
        perform(&mut image, &[&format!("{home} {speed}"), "arm"]);
        image.run_ms((1000.0 * random.uniform()) as u32);
        let stuck = usize::from(random.uniform() < 0.5);
        let opens = random.uniform() < 0.5;
        let was_found = image.said.contains("switch is at");
        if opens {
            image.plant.switches[stuck] = true;
        } else {
            image.plant.edges[stuck] = [f32::NEG_INFINITY, f32::INFINITY][stuck];
        }
        // And a poll of the operator's.
        let longest = 2.0 * stroke / speed + 0.05;
        let current = peak(&mut image, (1e3 * longest).ceil() as u32);
        let case = format!("{seed}: {home} {speed}, {stuck} stuck, open {opens}");
        assert!(
            current <= 1.1 * EMA.limits.current_limit,
            "{case}: {current} A"
        );
        assert!(!image.plant.is_driven(), "{case}");
        let fault = image.wiring.fault();
        let found = image.said.contains("switch is at");
        if let Some(fault) = fault {
            let of_the_way = [
                Fault::StopReached,
                Fault::FollowingError,
                Fault::EncoderLost,
            ];
            assert!(of_the_way.contains(&fault), "{case}: {fault}");
            named += 1;
        }
        assert!(fault.is_some() || image.said.contains("home: "), "{case}");
        if !opens && stuck == sought && !was_found {
            assert!(!found, "{case}");
            missed += 1;
        }
        misled += u32::from(opens && stuck == sought && !was_found && found);
    }
    println!("{named} faults, {missed} not found, {misled} found where they stuck");
    assert!(named > 0 && missed > 0);
}

/// What an encoder did not count while it failed is missing afterwards.
#[test]
fn after_a_fault_of_the_encoder_the_position_has_to_be_told_anew() {
    let mut image = anywhere(&mut Random::new(3, 9));
    image.plant.state = State::new(0.0, 0.0);
    perform(&mut image, &["zero", "mode voltage", "arm", "step 0 12"]);
    image.plant.encoder = 0.0;
    image.run_ms(100);
    assert!(image.wiring.latch().is_tripped());
    image.plant.encoder = 1.0;
    perform(&mut image, &["disarm", "clear"]);
    let refused = image.line("arm");
    assert!(refused.contains("not known"), "{refused}");
    perform(&mut image, &["zero", "arm"]);

    // Also where it is cleared before the operator has looked.
    perform(&mut image, &["step 0 12"]);
    image.plant.encoder = 0.0;
    image.tasks_held = 400;
    while !image.wiring.latch().is_tripped() {
        image.tick();
    }
    image.type_in(b"disarm\r");
    image.run_ms(2);
    let said = image.type_in(b"clear\r");
    assert!(image.tasks_held > 0 && said.contains("ok"), "{said}");
    let refused = image.line("arm");
    assert!(refused.contains("not known"), "{refused}");
}

/// With another unit the same counts are another position.
#[test]
fn with_another_unit_the_position_has_to_be_told_anew() {
    let mut image = anywhere(&mut Random::new(3, 9));
    image.plant.state = State::new(0.5, 0.0);
    perform(&mut image, &["home upper 0.85 0.5", "arm"]);
    image.run_ms(2000);
    perform(&mut image, &["arm", "disarm", "set position_unit 0.0003"]);
    let refused = image.line("arm");
    assert!(refused.contains("not known"), "{refused}");
    perform(&mut image, &["zero", "arm"]);
}

/// A switch that was found is the one that was sought, not one that is to be sought next.
#[test]
fn what_a_search_has_found_says_nothing_of_the_next_one() {
    let mut image = anywhere(&mut Random::new(3, 9));
    image.plant.state = State::new(0.7, 0.0);
    perform(&mut image, &["home upper 0.85 1", "arm"]);
    while image.plant.is_driven() && image.plant.state.position.value() < 0.849 {
        image.tick();
    }
    // Found, and not looked at by the operator: the queue of the samples holds as long.
    image.tasks_held = 29 * 20;
    let mut open = 0;
    for _ in 0..25 {
        image.run_ms(1);
        open += u32::from(image.wiring.switches()[1]);
    }
    assert!(open >= SWITCH_STEPS && image.wiring.duty() == 0, "{open}");
    let said = image.type_in(b"disarm\rhome lower -0.9 1\r");
    assert_eq!(said.matches("ok").count(), 2, "{said}");
    image.run_ms(20);
    assert!(!image.said.contains("home: "), "{}", image.said);
    let status = image.line("status");
    assert!(status.contains("no end stop is trusted"), "{status}");
}
