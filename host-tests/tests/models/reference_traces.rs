//! The core's plant against the traces that SciPy integrated (`host-tests/traces`, its README says
//! how). The traces are exact beside `f32`; two errors are left, and each bound is their sum.
//!
//! *Rounding*: each parameter and each coefficient of a step is off by up to 2⁻²⁴ of itself, for
//! good. About ten of them make a quantity, so it may be off by 10 · 2⁻²⁴ of its largest value
//! where they conspire, by √10 · 2⁻²⁴ in the root mean square where they do not. Of rounding the
//! state in each step nothing adds up: position and velocity are summed with compensation, the
//! current forgets.
//!
//! *Events*: inside the finest cell, c = h/16, the state is a parabola, wrong by up to 0.064 f‴ c³.
//! With a voltage jump U across the event, i‴ = U R²/L³ and ω‴ = k U R/(J L²); an error of the
//! velocity decays with J/(b + k²/R) and leaves its integral in the position.

use model_core::control::pid;
use model_core::plant::actuator::Actuator;
use model_core::plant::karnopp::{self, Karnopp};
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, State};
use std::f64::consts::TAU;
use std::path::Path;

/// One row of a trace.
struct Row {
    input: f64,
    position: f64,
    velocity: f64,
    current: f64,
    command: f64,
}

fn read(name: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("traces")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.lines()
        .skip(1)
        .map(|line| {
            let mut numbers = line.split(',').map(|number| number.parse().unwrap());
            let mut next = || numbers.next();
            let _time = next();
            Row {
                input: next().unwrap(),
                position: next().unwrap(),
                velocity: next().unwrap(),
                current: next().unwrap(),
                command: next().unwrap_or(f64::NAN),
            }
        })
        .collect()
}

/// Root mean square and largest magnitude of an error.
#[derive(Default)]
struct Deviation {
    squares: f64,
    count: f64,
    largest: f64,
}

impl Deviation {
    fn see(&mut self, error: f64) {
        self.squares += error * error;
        self.count += 1.0;
        // Not `max`, which would pass over a NaN.
        if error.is_nan() || error.abs() > self.largest {
            self.largest = error.abs();
        }
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

/// Deviations from the rows of a trace.
#[derive(Default)]
struct Deviations {
    position: Deviation,
    velocity: Deviation,
    current: Deviation,
}

impl Deviations {
    fn see(&mut self, row: &Row, state: &State) {
        self.position
            .see(f64::from(state.position.value()) - row.position);
        self.velocity
            .see(f64::from(state.velocity.value()) - row.velocity);
        self.current.see(f64::from(state.current) - row.current);
    }

    /// The largest deviations against bounds of both errors, the root mean squares against those of
    /// rounding a third as large.
    fn assert_within(&self, name: &str, rows: &[Row], events: &Events) {
        let quantities = [
            (
                "position",
                &self.position,
                largest(rows.iter().map(|row| row.position)),
                events.position,
            ),
            (
                "velocity",
                &self.velocity,
                largest(rows.iter().map(|row| row.velocity)),
                events.velocity,
            ),
            (
                "current",
                &self.current,
                largest(rows.iter().map(|row| row.current)),
                events.current,
            ),
        ];
        for (quantity, deviation, scale, event) in quantities {
            let unit = scale * 2f64.powi(-24);
            let (rms, most) = (deviation.rms(), deviation.largest);
            println!("{name}, {quantity}: {rms:.1e} rms, {most:.1e} at most, of {scale:.4}");
            assert!(
                rms < 10f64.sqrt() * unit + event,
                "{name}, {quantity}: {rms:e} rms"
            );
            assert!(
                most < 10.0 * unit + event,
                "{name}, {quantity}: {most:e} at most"
            );
        }
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest, value| largest.max(value.abs()))
}

/// What events add to the deviations.
struct Events {
    position: f64,
    velocity: f64,
    current: f64,
}

impl Events {
    /// Of a voltage `jump` in each of a few events of a `machine` stepped by `hold`.
    fn of(machine: &Parameters, jump: f64, hold: f64) -> Self {
        /// Events within the time in which the velocity forgets.
        const FEW: f64 = 3.0;
        let Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } = machine.drive
        else {
            panic!("the traces are of windings");
        };
        let (r, l, k) = (
            f64::from(resistance),
            f64::from(inductance),
            f64::from(torque_constant),
        );
        let (j, b) = (
            f64::from(machine.inertia),
            f64::from(machine.viscous.forward),
        );
        let remainder = 0.064 * (hold / 16.0).powi(3);
        let velocity = FEW * remainder * k * jump * r / (j * l * l);
        Self {
            position: velocity * j / (b + k * k / r),
            velocity,
            current: FEW * remainder * jump * r * r / (l * l * l),
        }
    }
}

fn ema(breakaway: f32) -> Parameters {
    Parameters {
        drive: Drive::Voltage {
            resistance: 1.0,
            inductance: 1e-3,
            torque_constant: 0.06,
        },
        viscous: Directional::both(2e-4),
        coulomb: Directional::both(0.12),
        breakaway: Directional::both(breakaway),
        ..Parameters::free(1.2e-4)
    }
}

fn throttle() -> Parameters {
    Parameters {
        drive: Drive::Voltage {
            resistance: 2.0,
            inductance: 1.2e-3,
            torque_constant: 0.38,
        },
        inertia: 1.6e-3,
        viscous: Directional::both(8e-3),
        coulomb: Directional::both(0.24),
        breakaway: Directional::both(0.28),
        spring: 0.25,
        spring_rest: 0.2,
        spring_preload: 0.3,
        lower_stop: 0.02,
        upper_stop: 1.57,
        ..ema(0.15)
    }
}

/// The voltage of the sweeps at a time in s.
fn sweep(time: f64) -> f64 {
    12.0 * (TAU * (0.2 * time + 0.24 * time * time)).sin()
}

const SWEEPS: [(&str, f32, &str, f64); 6] = [
    ("coulomb", 0.12, "50us", 5e-5),
    ("coulomb", 0.12, "100us", 1e-4),
    ("coulomb", 0.12, "1ms", 1e-3),
    ("static", 0.15, "50us", 5e-5),
    ("static", 0.15, "100us", 1e-4),
    ("static", 0.15, "1ms", 1e-3),
];

#[test]
fn voltage_sweep() {
    for (friction, breakaway, label, hold) in SWEEPS {
        let name = format!("sweep-{friction}-{label}.csv");
        let machine = ema(breakaway);
        let actuator = Actuator::build(&machine, hold as f32).unwrap();
        let mut state = State::new(0.0, 0.0);
        let mut deviations = Deviations::default();
        let every = (5e-3 / hold).round() as usize;
        let rows = read(&name);
        for (number, row) in rows.iter().enumerate() {
            deviations.see(row, &state);
            for step in number * every..(number + 1) * every {
                let input = sweep(step as f64 * hold) as f32;
                actuator.step(&mut state, input).unwrap();
            }
        }
        // From hold to hold the voltage changes by 12 V times 2π times 5 Hz times the hold at most.
        let events = Events::of(&machine, 12.0 * TAU * 5.0 * hold, hold);
        deviations.assert_within(&name, &rows, &events);
    }
}

#[test]
fn throttle_over_its_rest_and_into_its_stops() {
    let machine = throttle();
    let actuator = Actuator::build(&machine, 1e-3).unwrap();
    let mut state = State::new(0.2, 0.0);
    let mut deviations = Deviations::default();
    let rows = read("throttle.csv");
    let mut resting = 0;
    for row in &rows {
        deviations.see(row, &state);
        // On the spring's rest and on the stops there is nothing to round.
        if [0.02, 0.2, 1.57].contains(&row.position) {
            assert_eq!(state.position.value(), row.position as f32);
            resting += 1;
        }
        actuator.step(&mut state, row.input as f32).unwrap();
    }
    assert!(resting > 1000, "{resting}");
    // Its largest step is from 0 to 8 V or back.
    let events = Events::of(&machine, 8.0, 1e-3);
    deviations.assert_within("throttle.csv", &rows, &events);
}

#[test]
fn voltage_of_the_position_loop() {
    let machine = ema(0.15);
    let actuator = Actuator::build(&machine, 1e-3).unwrap();
    let mut state = State::new(0.0, 0.0);
    let mut deviations = Deviations::default();
    let rows = read("pid.csv");
    for row in &rows {
        deviations.see(row, &state);
        actuator.step(&mut state, row.input as f32).unwrap();
    }
    let jump = largest(rows.windows(2).map(|pair| pair[1].input - pair[0].input));
    let events = Events::of(&machine, jump, 1e-3);
    deviations.assert_within("pid.csv", &rows, &events);
}

#[test]
fn position_loop() {
    let machine = ema(0.15);
    let actuator = Actuator::build(&machine, 1e-3).unwrap();
    let controller = pid::Parameters {
        proportional: 17.0,
        integral: 60.0,
        derivative: 0.25,
        derivative_filter_time: 3e-3,
        output_minimum: -24.0,
        output_maximum: 24.0,
        ..pid::Parameters::default()
    }
    .build(1e-3)
    .unwrap();
    let mut state = State::new(0.0, 0.0);
    let (mut fed, mut closed) = (pid::State::default(), pid::State::default());
    let mut deviations = Deviations::default();
    let mut output = Deviation::default();
    let rows = read("pid.csv");
    for row in &rows {
        deviations.see(row, &state);
        let command = row.command as f32;
        let exact = controller.step(&mut fed, command, row.position as f32);
        output.see(f64::from(exact.unwrap()) - row.input);
        let input = controller.step(&mut closed, command, state.position.value());
        // The reference's converter has a resolution of 1 µV.
        let input = (f64::from(input.unwrap()) * 1e6).round() / 1e6;
        actuator.step(&mut state, input as f32).unwrap();
    }
    // Command and position are rounded to 2⁻²⁴ of 4 rad, two positions to the derivative: kp of an
    // error and kd/(τ + T) of a difference. Half of the reference's microvolt comes on top.
    let rounding = 4.0 * 2f64.powi(-24);
    let bound = 2.0 * (17.0 + 0.25 / 4e-3) * rounding + 0.5e-6;
    println!("controller: {:.1e} V at most", output.largest);
    assert!(output.largest < bound, "{} V", output.largest);

    // The loop corrects what the plant alone would keep.
    let jump = largest(rows.windows(2).map(|pair| pair[1].input - pair[0].input));
    let events = Events::of(&machine, jump, 1e-3);
    deviations.assert_within("closed loop", &rows, &events);
    assert!(deviations.position.rms() < rounding);
    assert_eq!(
        largest(rows.iter().map(|row| row.input)),
        24.0,
        "the output limit is reached"
    );
}

/// Half the width of the velocity band: a thousandth of the top speed.
const BAND: f64 = 0.15;

/// The core's Karnopp scheme in steps of a fraction of the hold, over the 100 µs sweep.
fn karnopp_in_f32(step: f64, rows: &[Row]) -> Deviation {
    let scheme = Karnopp::build(&ema(0.12), step as f32, BAND as f32).unwrap();
    let mut state = karnopp::State::default();
    sweep_in_parts(step, rows, |input| {
        let before = f64::from(state.position);
        scheme.step(&mut state, input as f32).unwrap();
        before
    })
}

/// The same scheme in `f64`.
fn karnopp_in_f64(step: f64, rows: &[Row]) -> Deviation {
    let (mut current, mut velocity, mut position) = (0.0_f64, 0.0_f64, 0.0_f64);
    sweep_in_parts(step, rows, |input| {
        let before = position;
        let at_rest = velocity.abs() < BAND;
        let speed = if at_rest { 0.0 } else { velocity };
        current += (input - current - 0.06 * speed) / 1e-3 * step;
        let torque = 0.06 * current;
        if at_rest && torque.abs() <= 0.12 {
            velocity = 0.0;
        } else {
            let direction = if at_rest { torque } else { speed };
            let friction = 0.12_f64.copysign(direction) + 2e-4 * speed;
            velocity += (torque - friction) / 1.2e-4 * step;
        }
        if velocity.abs() >= BAND {
            position += velocity * step;
        }
        before
    })
}

/// Steps a scheme, which gives the position before each step, over the 100 µs sweep.
fn sweep_in_parts(step: f64, rows: &[Row], mut advance: impl FnMut(f64) -> f64) -> Deviation {
    let parts = (1e-4 / step).round() as usize;
    let mut deviation = Deviation::default();
    for (number, row) in rows.iter().enumerate() {
        for part in 0..50 * parts {
            let hold = number * 50 + part / parts;
            let position = advance(sweep(hold as f64 * 1e-4));
            if part == 0 {
                deviation.see(position - row.position);
            }
        }
    }
    deviation
}

/// Euler steps of 1 µs in `f32`, the published scheme's choice, are worse than ten times longer
/// ones: the position's rounding, half an ulp of 64 to 128 rad or 4 µrad of steps of 100 µrad, adds
/// up over ten million steps, and at a random walk's pace alone to √1e7 · 2.2 µrad = 7 mrad. The
/// same scheme in `f64` is as good at either: it is the arithmetic, not the scheme.
#[test]
fn short_euler_steps_are_a_trap_in_f32() {
    let rows = read("sweep-coulomb-100us.csv");
    let error = |scheme: fn(f64, &[Row]) -> Deviation, step: f64| {
        let rms = scheme(step, &rows).rms();
        println!("{:3.0} µs: {rms:.1e} rad rms", step * 1e6);
        rms
    };
    let [short, long, coarse] = [1e-6, 1e-5, 1e-4].map(|step| error(karnopp_in_f32, step));
    let [short_f64, long_f64, coarse_f64] =
        [1e-6, 1e-5, 1e-4].map(|step| error(karnopp_in_f64, step));
    assert!(short > 7e-3, "{short}");
    assert!(short > 4.0 * long, "{short} {long}");
    assert!(short > 4.0 * short_f64, "{short} {short_f64}");
    assert!(long < 2.0 * long_f64, "{long} {long_f64}");
    assert!((short_f64 / long_f64 - 1.0).abs() < 0.5);
    // At 100 µs, a tenth of the winding's time constant, the scheme's own error governs both.
    assert!((coarse / coarse_f64 - 1.0).abs() < 0.1);
    assert!(coarse_f64 > 4.0 * long_f64);

    // The core's exact steps, a hundredth in number, are below a thousandth of the one and a
    // hundredth of the other.
    let actuator = Actuator::build(&ema(0.12), 1e-4).unwrap();
    let mut state = State::new(0.0, 0.0);
    let exact = sweep_in_parts(1e-4, &rows, |input| {
        let before = f64::from(state.position.value());
        actuator.step(&mut state, input as f32).unwrap();
        before
    })
    .rms();
    assert!(
        exact < 1e-3 * short && exact < 1e-2 * short_f64,
        "{exact} {short} {short_f64}"
    );
}
