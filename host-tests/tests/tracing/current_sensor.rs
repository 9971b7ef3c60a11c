//! A log whose current column errs: its gain, offset and lag are said, and nothing else is made of them.

use host_tests::gap::engine;
use host_tests::gap::headline::Headline;
use host_tests::gap::outcome::Outcome;
use host_tests::log::Log;

use crate::stepped::{COUNTS, GEARMOTOR, Stepped, gearmotor};

const RESISTANCE: f64 = 4.0;
const TORQUE_CONSTANT: f64 = 1.4;
/// A current that takes two rows to follow: how late a row reads it shows.
const INDUCTANCE: f64 = 0.016;

const MOTOR: Stepped<4> = Stepped {
    viscous: 0.025,
    breakaway: 0.36,
    ..GEARMOTOR
};

/// What the column says of a current: this multiple of it, so many steps before, and so much more, A.
struct Sensor {
    gain: f64,
    offset: f64,
    late: usize,
}

/// A log of the motor with a weight at its shaft of so much torque at a right angle.
fn log(sensor: &Sensor, weight: f64, phases: [f64; 4]) -> Log {
    log_with(INDUCTANCE, sensor, weight, phases)
}

fn log_with(inductance: f64, sensor: &Sensor, weight: f64, phases: [f64; 4]) -> Log {
    let mut flow = 0.0;
    let mut log = MOTOR.log(
        "current.csv",
        phases,
        sensor.late,
        |volts, position, velocity| {
            // In closed form: an explicit Euler step would make the winding's time constant half a step shorter.
            let settled = (volts - TORQUE_CONSTANT * velocity) / RESISTANCE;
            flow = settled + (flow - settled) * (-MOTOR.step() * RESISTANCE / inductance).exp();
            (TORQUE_CONSTANT * flow - weight * position.sin(), flow)
        },
    );
    for reading in log.current.iter_mut().flatten() {
        *reading = sensor.gain * *reading + sensor.offset;
    }
    log
}

fn trace(sensor: &Sensor, weight: f64) -> Outcome {
    let machine = gearmotor([4.0, 0.016, 1.4], COUNTS, "");
    let train = log(sensor, weight, [0.3, 1.9, 4.0, 5.5]);
    let other = log(sensor, weight, [2.2, 0.4, 5.1, 1.0]);
    let report = engine::run(&machine, &[train], || Ok(vec![other]), |_| ()).unwrap();
    report.outcome
}

/// Sensors by their gain, their offset and the steps by which they are late.
fn what_it_errs_by_is_said(sensors: &[(f64, f64, usize)]) {
    for &(gain, offset, late) in sensors {
        let sensor = Sensor { gain, offset, late };
        for (weight, expected) in [(0.0, &[][..]), (0.4, &["gravity"])] {
            let outcome = trace(&sensor, weight);
            let named: Vec<&str> = outcome.effects.iter().map(|it| it.id.as_str()).collect();
            assert_eq!(named, expected, "{gain}, {offset}, {late}: {outcome:?}");
            for found in &outcome.effects {
                // Neither is fitted, and a torque is known by them alone.
                assert_eq!(found.presumes, ["resistance", "torque_constant"]);
            }
            assert_eq!(
                outcome.freed().count(),
                0,
                "{gain}, {offset}, {late}: {outcome:?}"
            );
            let lag = late as f64 * MOTOR.step();
            let [found, shifted, lateness] = &outcome.current_sensor[..] else {
                panic!("{gain}, {offset}, {late}: nothing is said of the sensor");
            };
            assert!((found.value - gain).abs() < 0.01, "{found:?} for {gain}");
            assert!(
                (shifted.value - offset).abs() < 0.01,
                "{shifted:?} for {offset}"
            );
            assert!(
                (lateness.value - lag).abs() < 2e-4,
                "{lateness:?} for {lag}"
            );
        }
    }
}

#[test]
fn what_it_errs_by_is_said_and_is_no_effect_and_no_wrong_number() {
    what_it_errs_by_is_said(&[(0.95, 0.04, 30)]);
}

#[test]
#[ignore = "other cases"]
fn what_others_err_by_is_said_and_is_no_effect_and_no_wrong_number() {
    what_it_errs_by_is_said(&[(1.05, -0.03, 8), (0.94, 0.0, 0), (1.0, 0.0, 24)]);
}

fn nothing_is_said_of_a_good_sensor(weight: f64) {
    let sensor = Sensor {
        gain: 1.0,
        offset: 0.0,
        late: 0,
    };
    let outcome = trace(&sensor, weight);
    assert!(outcome.current_sensor.is_empty(), "{outcome:?}");
}

#[test]
fn nothing_is_said_of_a_good_one() {
    nothing_is_said_of_a_good_sensor(0.4);
}

#[test]
#[ignore = "other cases"]
fn nothing_is_said_of_a_good_one_without_a_weight() {
    nothing_is_said_of_a_good_sensor(0.0);
}

/// The current comes later than the voltage by inductance over resistance, here 1.5 to 5 ms; a machine file without
/// inductance has none of that. The answer says which one it is.
fn the_lag_of_a_winding_is_said(lags: &[f64]) {
    let machine = gearmotor([4.0, 0.0, 1.4], COUNTS, "");
    for &lag in lags {
        let good = Sensor {
            gain: 1.0,
            offset: 0.0,
            late: 0,
        };
        let inductance = lag * RESISTANCE;
        let drive = |phases| log_with(inductance, &good, 0.0, phases);
        let train = drive([0.3, 1.9, 4.0, 5.5]);
        let other = drive([2.2, 0.4, 5.1, 1.0]);
        let report = engine::run(&machine, &[train], || Ok(vec![other]), |_| ()).unwrap();
        let headline = Headline::of(&report);
        let said = format!("{headline:?}");
        let (_, behind) = said
            .split_once("the winding's inductance, which the machine file neglects: a delay of ")
            .and_then(|(_, delay)| delay.split_once(" would be "))
            .unwrap_or_else(|| panic!("{lag}: {said}"));
        let words: Vec<&str> = behind.split_whitespace().take(2).collect();
        assert_eq!(words[1], "mH", "{said}");
        let found = 1e-3 * words[0].parse::<f64>().unwrap();
        // A delay stands for a winding's lag for slow changes alone: it is a size to look up, not one to declare.
        assert!(
            (found / inductance - 1.0).abs() < 0.25,
            "{found} for {inductance}: {said}"
        );
    }
}

#[test]
fn the_lag_of_a_winding_that_the_machine_file_neglects_is_said_to_be_that() {
    the_lag_of_a_winding_is_said(&[3e-3]);
}

#[test]
#[ignore = "other cases"]
fn other_lags_of_a_winding_that_the_machine_file_neglects_are_said_to_be_that() {
    the_lag_of_a_winding_is_said(&[1.5e-3, 5e-3]);
}

/// Without a current the motion is late, as of a late drive; the answer has the inductance that it may be.
#[test]
fn a_late_motion_may_be_the_inductance_that_the_machine_file_neglects() {
    let lag = 3e-3;
    let good = Sensor {
        gain: 1.0,
        offset: 0.0,
        late: 0,
    };
    let drive = |phases| Log {
        current: None,
        ..log_with(lag * RESISTANCE, &good, 0.0, phases)
    };
    let machine = gearmotor([4.0, 0.0, 1.4], COUNTS, "");
    let train = [drive([0.3, 1.9, 4.0, 5.5])];
    let other = drive([2.2, 0.4, 5.1, 1.0]);
    let report = engine::run(&machine, &train, || Ok(vec![other]), |_| ()).unwrap();
    let mut effects = report.outcome.effects.iter();
    let found = effects.find_map(|effect| effect.neglected_inductance);
    let found = found.unwrap_or_else(|| panic!("{:?}", report.outcome.effects));
    let share = found.inductance / (lag * RESISTANCE);
    assert!((share - 1.0).abs() < 0.25, "{found:?}");
    let said = format!("{:?}", Headline::of(&report));
    assert!(said.contains("which the machine file neglects"), "{said}");
}

/// A channel of the logger that nothing is connected to: the torque of a log is that of its current.
#[test]
fn a_current_that_is_zero_throughout_is_named_and_not_the_input() {
    let mut log = GEARMOTOR.log_of_position(
        "unconnected.csv",
        [0.3, 1.9, 4.0, 5.5],
        |volts, _, velocity| 1.4 * (volts - 1.4 * velocity) / 4.0,
    );
    log.current = Some(vec![0.0; log.position.len()]);
    let machine = gearmotor([4.0, 0.0, 1.4], COUNTS, "");
    let refused = engine::run(&machine, &[log], || Ok(Vec::new()), |_| ());
    let said = refused.unwrap_err().to_string();
    assert!(said.contains("`current_a` is 0 throughout"), "{said}");
}
