//! What protects people and hardware beside the limits: the emergency stop, and the temperatures of the switches and
//! of the motor.

use firmware::app::fault::Fault;
use firmware::app::fault::output::Outputs;
use firmware::app::machine::EMA;
use firmware::app::operation::temperature::{BETA, BROKEN_STEPS, celsius};
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};

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
