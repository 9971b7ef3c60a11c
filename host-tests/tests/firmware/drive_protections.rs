//! What protects people and hardware beside the drive's own limits: the emergency stop, the temperatures of the switches and
//! of the motor, and the supply's current.

use firmware::app::fault::Fault;
use firmware::app::fault::output::Outputs;
use firmware::app::machine::EMA;
use firmware::app::operation::supply_limit::{Coefficients, NO_LIMIT};
use firmware::app::operation::temperature::{BETA, BROKEN_STEPS, celsius};
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};
use model_core::numeric::random::Random;
use model_core::plant::parameters::{Drive, Parameters};

/// The declared actuator at its controller.
fn declared() -> OperationOnHost<Motor> {
    OperationOnHost::controller(&SharedFlash::new(), &EMA.plant)
}

/// Lines that must be done.
fn perform(image: &mut OperationOnHost<Motor>, lines: &[&str]) {
    for line in lines {
        assert_eq!(image.line(line), "ok", "{line}");
    }
}

#[test]
fn an_emergency_stop_switches_the_bridge_off_in_the_tick_that_reads_it_and_is_named_first() {
    let mut image = declared();
    perform(&mut image, &["mode voltage", "arm", "step 0 12"]);
    assert!(image.plant.is_driven());
    // A contact that opens for one tick, together with what may come of it.
    image.plant.stopped = true;
    image.plant.broken = true;
    image.tick();
    assert!(!image.plant.is_driven());
    assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
    image.plant.stopped = false;
    image.plant.broken = false;
    image.run_ms(50);
    assert_eq!(image.wiring.fault(), Some(Fault::EmergencyStop));
    assert!(!image.plant.is_driven());
}

#[test]
fn nothing_clears_an_emergency_stop_that_is_pressed_and_nothing_moves_when_it_is_released() {
    let mut image = declared();
    perform(&mut image, &["arm", "step 0 0.5"]);
    image.plant.stopped = true;
    image.run_ms(10);
    let armed = image.line("clear");
    assert_eq!(armed, "refused: the drive is armed; `disarm` it first");
    perform(&mut image, &["disarm"]);
    for _ in 0..3 {
        let refused = image.line("clear");
        assert_eq!(
            refused,
            "refused: still there: emergency_stop; end that first"
        );
        assert!(image.line("arm").contains("emergency_stop"));
    }
    image.plant.stopped = false;
    image.run_ms(10);
    // Released it is over, but not forgotten.
    assert!(image.line("arm").contains("emergency_stop"));
    perform(&mut image, &["clear"]);
    let before = image.plant.state.position.value();
    perform(&mut image, &["arm"]);
    image.run_ms(200);
    assert!(image.plant.is_driven());
    let moved = (image.plant.state.position.value() - before).abs();
    // It is held where it is: within the encoder's count.
    assert!(moved <= EMA.converters.position.unit(), "{moved} rad");
}

/// Without the crystal nothing is driven, not even by orders that come all at once.
#[test]
fn a_drive_whose_crystal_stands_still_is_not_armed_until_the_next_start() {
    let mut image = declared();
    perform(&mut image, &["mode voltage", "arm", "step 0 12"]);
    image.clock_failed = true;
    image.tick();
    assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
    assert_eq!(image.wiring.fault(), Some(Fault::ClockFailed));
    image.run_ms(5);
    for _ in 0..20 {
        image.type_in(b"disarm\rclear\rarm\r");
        image.tick();
        assert!(!image.plant.is_driven());
    }
    image.line("disarm");
    assert_eq!(
        image.line("clear"),
        "refused: still there: clock_failed; end that first"
    );
}

/// The program's own supply: while it is low nothing is driven, cleared or written to flash.
#[test]
fn a_processor_whose_supply_sags_lets_go_at_once_and_saves_nothing_before_it_is_back() {
    let mut image = declared();
    perform(&mut image, &["mode voltage", "arm", "step 0 12"]);
    assert!(image.plant.is_driven());
    image.processor_supply_low = true;
    image.tick();
    assert!(!image.plant.is_driven());
    assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
    assert_eq!(image.wiring.fault(), Some(Fault::BrownOut));
    perform(&mut image, &["disarm", "set coulomb 0.13"]);
    let refused = image.line("clear");
    assert_eq!(refused, "refused: still there: brown_out; end that first");
    let refused = image.line("save");
    assert_eq!(
        refused,
        "refused: latched: brown_out; see `faults`, `clear`"
    );
    assert!(image.asked.borrow().stalls.is_empty());
    image.processor_supply_low = false;
    image.run_ms(5);
    assert_eq!(image.wiring.fault(), Some(Fault::BrownOut));
    perform(&mut image, &["save", "clear", "arm"]);
}

#[test]
fn a_board_whose_emergency_stop_is_neither_wired_nor_strapped_does_not_arm() {
    let mut image = declared();
    image.plant.stopped = true;
    image.run_ms(10);
    let refused = image.line("arm");
    assert!(refused.contains("emergency_stop"), "{refused}");
    let faults = image.line("faults");
    assert!(faults.contains("PB15"), "{faults}");
    for line in ["mode voltage", "save"] {
        perform(&mut image, &[line]);
    }
    assert!(image.line("arm").contains("emergency_stop"));
    assert!(!image.plant.is_driven());
}

/// Resistance of Murata's NCP18XH103F03RB, Ω, over its temperature, °C: the maker's table (productdata NTHCG83).
const TABLE: [(f64, f64); 13] = [
    (-20.0, 68237.0),
    (0.0, 27219.0),
    (10.0, 17926.0),
    (25.0, 10000.0),
    (40.0, 5834.0),
    (50.0, 4161.0),
    (60.0, 3014.0),
    (70.0, 2228.0),
    (80.0, 1669.0),
    (90.0, 1268.0),
    (100.0, 974.0),
    (110.0, 758.0),
    (125.0, 531.0),
];

/// Code of 12 bits of a resistance, Ω, under 10 kΩ, not rounded.
fn code(resistance: f64) -> f64 {
    4096.0 * resistance / (resistance + 10e3)
}

/// Resistance at a temperature, °C, by the equation of B.
fn resistance(beta: f64, celsius: f64) -> f64 {
    10e3 * (beta * (1.0 / (celsius + 273.15) - 1.0 / 298.15)).exp()
}

/// What a pin reads of an NTC at this temperature, °C.
fn reading(celsius: f64) -> u16 {
    code(resistance(f64::from(BETA), celsius)).round() as u16
}

#[test]
fn an_ntc_is_read_as_its_equation_has_it_and_within_two_kelvin_of_its_data_sheet() {
    for beta in [2500.0, 3380.0, 3434.0, 3977.0, 5000.0] {
        for tenth in -400..1500 {
            let truth = 0.1 * f64::from(tenth);
            let read = celsius(beta as f32, code(resistance(beta, truth)) as f32);
            // A code of f32 is 2⁻²⁴ of itself off, of an open sensor's 2⁻²⁴ · 4096/(4096 − code) of the ratio.
            assert!(
                (f64::from(read) - truth).abs() < 0.01,
                "{beta} K, {truth}: {read}"
            );
        }
    }
    for (truth, ohms) in TABLE.into_iter().filter(|&(celsius, _)| celsius >= 0.0) {
        let read = f64::from(celsius(BETA, code(ohms).round() as f32));
        assert!((read - truth).abs() < 2.0, "{truth}: {read}");
    }
}

#[test]
fn a_sensor_that_is_declared_and_open_or_shorted_is_a_fault_and_one_that_is_not_there_is_said_to_be()
 {
    for (place, field) in ["switch", "motor"].into_iter().enumerate() {
        for broken in [0, 20, 4095] {
            let mut image = declared();
            image.plant.temperatures[place] = broken;
            image.run_ms(200);
            // Nobody said that there is one.
            assert_eq!(image.wiring.fault(), None);
            let status = image.line("status");
            assert!(
                status.contains("switches not watched, motor not watched"),
                "{status}"
            );
            image.plant.temperatures[place] = 2048;
            let set = format!("set {field}_temperature_maximum 100");
            perform(&mut image, &[&set, "arm", "step 0 0.3"]);
            let status = image.line("status");
            assert!(status.contains("25.0 °C"), "{status}");
            image.plant.temperatures[place] = broken;
            let mut milliseconds = 0;
            while image.plant.is_driven() && milliseconds < 1000 {
                image.run_ms(1);
                milliseconds += 1;
            }
            // The steps in a row, one until the codes are published, and one until the bridge is off.
            assert!(milliseconds <= BROKEN_STEPS + 2, "{milliseconds} ms");
            assert_eq!(image.wiring.fault(), Some(Fault::TemperatureSensor));
            assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
            assert!(image.line("status").contains("not readable"));
            perform(&mut image, &["disarm"]);
            assert!(image.line("clear").contains("temperature_sensor"));
            let none = format!("set {field}_temperature_maximum 0");
            perform(&mut image, &[&none, "clear", "arm"]);
        }
    }
}

#[test]
fn beyond_its_maximum_the_drive_lets_go_and_is_not_cleared_before_it_is_cooler() {
    for place in 0..2 {
        let field = ["switch", "motor"][place];
        let mut image = declared();
        let set = format!("set {field}_temperature_maximum 80");
        perform(&mut image, &[&set, "arm"]);
        image.plant.temperatures[place] = reading(81.0);
        // The filter takes codes. Of the 1500 codes between 25 and 81 °C the last 16, 1 K, are left after 4.5 time
        // constants of 64 ms.
        image.run_ms(400);
        assert_eq!(image.wiring.fault(), Some(Fault::OverTemperature));
        assert!(!image.plant.is_driven());
        perform(&mut image, &["disarm"]);
        assert!(image.line("clear").contains("over_temperature"));
        image.plant.temperatures[place] = reading(78.0);
        image.run_ms(300);
        perform(&mut image, &["clear", "arm"]);
    }
}

/// A winding of 1 Ω that the drive presses against its stop with 20 A, with an NTC that follows it: heat flows to
/// 25 °C. Its highest temperature, °C, over 20 s.
fn hottest(maximum: f64, capacity: f64, to_ambient: f64, lag: f64) -> (f64, Option<Fault>) {
    let mut image = declared();
    let set = format!("set motor_temperature_maximum {maximum}");
    perform(
        &mut image,
        &[
            &set,
            "set continuous_current 20",
            "zero",
            "mode voltage",
            "arm",
            "step 0 24",
        ],
    );
    let (mut winding, mut sensor, mut hottest) = (25.0, 25.0, 0.0_f64);
    let step = 50e-6;
    for _ in 0..400_000 {
        let current = f64::from(image.plant.state.current);
        let heat = current * current - (winding - 25.0) / to_ambient;
        winding += step * heat / capacity;
        sensor += step * (winding - sensor) / lag;
        hottest = hottest.max(winding);
        image.plant.temperatures[1] = reading(sensor.min(149.0));
        image.tick();
        if image.wiring.latch().is_tripped() {
            break;
        }
    }
    (hottest, image.wiring.fault())
}

#[test]
fn a_current_that_is_derated_keeps_a_winding_below_its_maximum_without_a_fault() {
    // 4 to 20 K/s at 20 A; a sensor that is up to 5 K behind.
    for (capacity, to_ambient, lag) in [(20.0, 2.0, 0.25), (40.0, 1.0, 0.5), (100.0, 3.0, 1.0)] {
        let (with, fault) = hottest(90.0, capacity, to_ambient, lag);
        let (without, _) = hottest(0.0, capacity, to_ambient, lag);
        println!("{capacity} J/K, {to_ambient} K/W, {lag} s: {with} with, {without} °C without");
        assert_eq!(fault, None);
        assert!(with < 90.0, "{with} °C");
        if capacity < 100.0 {
            assert!(without > 100.0, "{without} °C: nothing to protect");
        }
    }
}

#[test]
fn the_range_that_a_supply_leaves_is_where_its_power_is_within_its_limits() {
    let mut random = Random::new(3, 0);
    let mut between = |least: f64, most: f64| least + (most - least) * f64::from(random.uniform());
    for _ in 0..2000 {
        let (resistance, supply) = (between(0.1, 10.0), between(5.0, 60.0));
        let (drawn, returned) = (between(0.1, 50.0), between(0.0, 20.0));
        let observed = between(-60.0, 60.0);
        let limit = Coefficients::new(resistance as f32, drawn as f32, returned as f32);
        let [least, most] = limit.range(observed as f32, supply as f32).map(f64::from);
        let power = |current: f64| (resistance * current + observed) * current / supply;
        assert!(least <= 0.0 && most >= 0.0);
        for part in 0..=100 {
            let current = least + (most - least) * f64::from(part) / 100.0;
            let bound = 1e-4 * (1.0 + current.abs());
            let power = power(current);
            assert!(
                power < drawn + bound && power > -returned - bound,
                "{power} A at {current} A"
            );
        }
        // Beyond either end one of the limits is broken.
        for end in [least, most] {
            let beyond = power(1.01 * end + 0.01 * end.signum());
            assert!(beyond > drawn || beyond < -returned, "{beyond} A");
        }
    }
    let none = Coefficients::new(1.0, NO_LIMIT, NO_LIMIT);
    assert_eq!(none.range(-20.0, 24.0), [-f32::MAX, f32::MAX]);
}

/// Free to turn, with a winding that is off by these factors.
fn free(resistance_factor: f32, inductance_factor: f32) -> Parameters {
    let mut plant = Parameters {
        lower_stop: -1e4,
        upper_stop: 1e4,
        ..EMA.plant
    };
    if let Drive::Voltage {
        resistance,
        inductance,
        ..
    } = &mut plant.drive
    {
        *resistance *= resistance_factor;
        *inductance *= inductance_factor;
    }
    plant
}

/// Least and most current of the supply in the mean of 10 ms, A, of a motor whose voltage changes from 24 V to another and back.
fn supplied(settings: &[&str], plant: &Parameters, supply: f32, other: f32) -> [f32; 2] {
    let mut image = OperationOnHost::controller(&SharedFlash::new(), plant);
    image.plant.supply = supply;
    image.run_ms(20);
    perform(&mut image, settings);
    let step = format!("step 24 {other} 0.3");
    perform(&mut image, &["mode voltage", "arm", &step]);
    let mut range = [0.0_f32; 2];
    for _ in 0..120 {
        let mut sum = 0.0;
        for _ in 0..200 {
            image.tick();
            sum += image.plant.supply_current();
        }
        let mean = sum / 200.0;
        range = [range[0].min(mean), range[1].max(mean)];
    }
    assert!(image.wiring.latch().causes().is_empty());
    range
}

/// Besides the limit a supply gives the energy of the winding's field in one of these windows, and takes it back in another:
/// ½ L i² with R i² below the power that is drawn. Of an inductance 30 % more and a resistance 30 % less than declared that is
/// ½ · 1.86 ms of 10 ms.
const FIELD: f32 = 0.093;

/// While the observer learns what they are off by, 0.6 ms of 10 ms, the power is off by as much as the resistance.
const LEARNING: f32 = 0.06 * 0.3;

#[test]
fn the_supply_gives_and_takes_no_more_than_its_limits_on_windings_off_by_a_third() {
    let corners = [0.7, 1.0, 1.3];
    for (drawn, returned) in [(2.0, 0.0), (4.0, 0.5), (6.0, 2.0)] {
        let settings = [
            format!("set supply_current_limit {drawn}"),
            format!("set regeneration_limit {returned}"),
        ];
        let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
        let mut range = [0.0_f32; 2];
        for plant in corners
            .into_iter()
            .flat_map(|r| corners.map(|l| free(r, l)))
        {
            for supply in [20.0, 24.0, 29.5] {
                for other in [-24.0, 0.0, 10.0] {
                    let [least, most] = supplied(&settings, &plant, supply, other);
                    range = [range[0].min(least), range[1].max(most)];
                }
            }
        }
        let [free_least, free_most] = supplied(&[], &free(1.0, 1.0), 24.0, 10.0);
        println!(
            "{drawn} A: {:.2} of {free_most:.2} A; {returned} A: {:.2} of {free_least:.2} A",
            range[1], range[0]
        );
        assert!(
            range[1] <= (1.0 + FIELD + LEARNING) * drawn,
            "{} A",
            range[1]
        );
        assert!(range[1] >= 0.95 * drawn, "{} A: a smaller limit", range[1]);
        // Half a count of the current's converter, at the whole supply.
        let count = 0.5 * EMA.converters.current.unit();
        let most = (1.0 + LEARNING) * returned + FIELD * drawn + count;
        assert!(range[0] >= -most, "{} A", range[0]);
        assert!(free_most > 1.2 * drawn && free_least < -1.2 * returned);
    }
}

#[test]
fn a_limited_position_is_kept_with_less_current_to_brake_and_refused_with_too_little() {
    for (drawn, returned, speed) in [(4.0, 100.0, 0.0), (4.0, 2.0, 20.0), (100.0, 4.0, 40.0)] {
        for supply in [20.0, 24.0, 29.5] {
            let plant = Parameters {
                lower_stop: -1e4,
                upper_stop: 1e4,
                ..EMA.plant
            };
            let mut image = OperationOnHost::controller(&SharedFlash::new(), &plant);
            image.plant.supply = supply;
            image.run_ms(20);
            perform(
                &mut image,
                &[
                    &format!("set supply_current_limit {drawn}"),
                    &format!("set regeneration_limit {returned}"),
                    &format!("set speed_limit {speed}"),
                    "set position_minimum -0.8",
                    "set position_maximum 0.8",
                    "zero",
                    "mode voltage",
                    "arm",
                    "step 24 -24 0.5",
                ],
            );
            let mut most = 0.0_f32;
            for _ in 0..2000 {
                image.run_ms(1);
                most = most.max(image.plant.state.position.value().abs());
            }
            println!("{drawn} A, {returned} A, {speed} rad/s, {supply} V: {most}");
            assert!(image.wiring.latch().causes().is_empty());
            // What docs/faults.md says of a position's limits, and it is driven to them.
            assert!(most < 0.8 + 3.5e-3 && most > 0.79, "{most} rad");
        }
    }
    let mut image = declared();
    perform(&mut image, &["set position_minimum -0.8", "zero"]);
    let answer = image.line("set regeneration_limit 0");
    assert!(answer.contains("regeneration_limit"), "{answer}");
}
