//! The position loop of the declared actuators: stable, with a margin, on any actuator within its tolerances. The
//! reference is a linear model in `f64` of its own: the winding and the rotor solved exactly over a period, the loop as a
//! transfer function in z.

use crate::any_drive::{TOLERANCES, any_actuator, either_way, perform, turns, winding_of};
use firmware::app::machine::{EMA, Machine, THROTTLE};
use firmware::app::timing::{CONTROL_PERIOD, PLANT_PERIOD};
use host_tests::operation_on_host::{OperationOnHost, SharedFlash};
use model_core::control::pid;
use model_core::numeric::random::Random;
use nalgebra::{Complex, DMatrix, Matrix3, Matrix4, Vector3};

/// A motor without Coulomb friction and load, in SI units. That friction would damp it: without it the margin is the least.
#[derive(Debug, Clone, Copy)]
struct Motor {
    resistance: f64,
    inductance: f64,
    torque_constant: f64,
    inertia: f64,
    viscous: f64,
}

impl Motor {
    fn declared(machine: &Machine) -> Self {
        let [resistance, inductance, torque_constant] = winding_of(machine);
        Self {
            resistance: resistance.into(),
            inductance: inductance.into(),
            torque_constant: torque_constant.into(),
            inertia: machine.plant.inertia.into(),
            viscous: machine.plant.viscous.forward.into(),
        }
    }

    /// As declared, and every corner of its tolerances.
    fn all(machine: &Machine) -> Vec<Self> {
        let declared = Self::declared(machine);
        let corner = |bits: u32| {
            let off = |bit: u32, share: f32| {
                let share = f64::from(share);
                1.0 + if bits >> bit & 1 == 0 { -share } else { share }
            };
            Self {
                resistance: declared.resistance * off(0, TOLERANCES.resistance),
                inductance: declared.inductance * off(1, TOLERANCES.inductance),
                torque_constant: declared.torque_constant * off(2, TOLERANCES.torque_constant),
                inertia: declared.inertia * off(3, TOLERANCES.inertia),
                viscous: declared.viscous * off(4, TOLERANCES.mechanics),
            }
        };
        core::iter::once(declared)
            .chain((0..32).map(corner))
            .collect()
    }

    /// Position, velocity and current over so many seconds of a voltage that stands: the state's part, and the voltage's.
    fn over(&self, seconds: f64) -> (Matrix3<f64>, Vector3<f64>) {
        let Self {
            resistance,
            inductance,
            torque_constant,
            inertia,
            viscous,
        } = *self;
        #[rustfmt::skip]
        let rates = Matrix4::new(
            0.0, 1.0, 0.0, 0.0,
            0.0, -viscous / inertia, torque_constant / inertia, 0.0,
            0.0, -torque_constant / inductance, -resistance / inductance, 1.0 / inductance,
            0.0, 0.0, 0.0, 0.0,
        );
        let solved = (rates * seconds).exp();
        (
            solved.fixed_view::<3, 3>(0, 0).into(),
            solved.fixed_view::<3, 1>(0, 3).into(),
        )
    }
}

/// A motor with its loop.
struct Loop {
    gains: pid::Parameters,
    period: f64,
    /// Over a period, with the voltage before, which stands for a time at its beginning, and the one after it.
    state: Matrix3<f64>,
    before: Vector3<f64>,
    after: Vector3<f64>,
}

impl Loop {
    /// A voltage acts so many ticks after the measurement that it follows from.
    fn new(motor: &Motor, gains: &pid::Parameters, late: f64) -> Self {
        let (period, delay) = (f64::from(CONTROL_PERIOD), late * f64::from(PLANT_PERIOD));
        let (_, early) = motor.over(delay);
        let (rest, after) = motor.over(period - delay);
        Self {
            gains: *gains,
            period,
            state: motor.over(period).0,
            before: rest * early,
            after,
        }
    }

    /// The filter's decay and the derivative's gain, of the backward Euler form.
    fn derivative(&self) -> (f64, f64) {
        let filter = f64::from(self.gains.derivative_filter_time);
        let whole = filter + self.period;
        (filter / whole, f64::from(self.gains.derivative) / whole)
    }

    /// The open loop at an angular frequency, 1/s.
    fn open(&self, frequency: f64) -> Complex<f64> {
        let z = Complex::from_polar(1.0, frequency * self.period);
        let complex = |value: f64| Complex::new(value, 0.0);
        let left = Matrix3::from_diagonal_element(z) - self.state.map(complex);
        let right = self.before.map(complex) / z + self.after.map(complex);
        let position = left.lu().solve(&right).expect("no pole of the motor")[0];
        let (decay, gain) = self.derivative();
        let controller = complex(self.gains.proportional.into())
            + complex(self.period * f64::from(self.gains.integral)) / (z - 1.0)
            + (complex(1.0) - z.inv()) * gain / (complex(1.0) - z.inv() * decay);
        position * controller
    }

    /// Largest size of the closed loop's poles.
    fn largest_pole(&self) -> f64 {
        // Position, velocity, current, and of the step before: voltage, derivative, position; and the integral.
        let (decay, gain) = self.derivative();
        let mut matrix = DMatrix::zeros(7, 7);
        let mut derivative = nalgebra::RowDVector::zeros(7);
        (derivative[0], derivative[4], derivative[5]) = (-gain, decay, gain);
        let mut voltage = derivative.clone();
        voltage[0] -= f64::from(self.gains.proportional);
        voltage[6] += 1.0;
        matrix.view_mut((0, 0), (3, 3)).copy_from(&self.state);
        matrix.view_mut((0, 3), (3, 1)).copy_from(&self.before);
        let driven = self.after * &voltage;
        let mut motion = matrix.view_mut((0, 0), (3, 7));
        motion += driven;
        matrix.set_row(3, &voltage);
        matrix.set_row(4, &derivative);
        matrix[(5, 0)] = 1.0;
        matrix[(6, 0)] = -self.period * f64::from(self.gains.integral);
        matrix[(6, 6)] = 1.0;
        let poles = matrix.complex_eigenvalues();
        poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max)
    }

    /// Greatest sensitivity |1/(1 + L)|, and least phase margin, degrees.
    fn margins(&self) -> (f64, f64) {
        const POINTS: i32 = 2000;
        let (mut sensitivity, mut phase) = (0.0_f64, f64::INFINITY);
        let mut before = f64::INFINITY;
        for point in 0..POINTS {
            // From 5 1/s, where the integral's part ends, to the half of the sampling's.
            let share = f64::from(point) / f64::from(POINTS);
            let highest = core::f64::consts::PI / self.period;
            let open = self.open(5.0 * (highest / 5.0).powf(share));
            sensitivity = sensitivity.max((open + 1.0).norm().recip());
            if before > 1.0 && open.norm() <= 1.0 {
                phase = phase.min((-open).arg().to_degrees());
            }
            before = open.norm();
        }
        (sensitivity, phase)
    }
}

/// Greatest sensitivity, least phase margin and largest pole of a machine and all corners of its tolerances, with a
/// voltage that acts within a tick, as on the host's model, or within two.
fn worst(machine: &Machine, gains: &pid::Parameters) -> (f64, f64, f64) {
    let mut worst = (0.0_f64, f64::INFINITY, 0.0_f64);
    for motor in Motor::all(machine) {
        for late in [1.0, 2.0] {
            let closed = Loop::new(&motor, gains, late);
            let (sensitivity, phase) = closed.margins();
            worst = (
                worst.0.max(sensitivity),
                worst.1.min(phase),
                worst.2.max(closed.largest_pole()),
            );
        }
    }
    worst
}

/// A sensitivity of 2 is a gain margin of 2 and a phase margin of 29°.
#[test]
fn its_sensitivity_is_at_most_two_within_all_tolerances() {
    for (name, machine) in [("actuator", EMA), ("throttle", THROTTLE)] {
        let (sensitivity, phase, pole) = worst(&machine, &machine.position_loop);
        println!("{name}: sensitivity {sensitivity:.3}, phase margin {phase:.1}°, pole {pole:.4}");
        assert!(pole < 1.0, "{name}: {pole}");
        assert!(sensitivity <= 2.0, "{name}: {sensitivity}");
        assert!(phase >= 28.9, "{name}: {phase}");
    }
    // The next gain is too much.
    let more = pid::Parameters {
        proportional: EMA.position_loop.proportional + 2.0,
        ..EMA.position_loop
    };
    let (sensitivity, phase, _) = worst(&EMA, &more);
    println!("more: sensitivity {sensitivity:.3}, phase margin {phase:.1}°");
    assert!(sensitivity > 2.0, "{sensitivity}");
}

/// The model's own check: without inductance and delay, with proportional action alone and a period that is short
/// against all else, the loop is K/(k s (1 + T s)), whose crossover and margin are closed forms.
#[test]
fn the_reference_has_the_margin_of_the_closed_form() {
    let motor = Motor {
        inductance: 1e-6,
        viscous: 0.0,
        ..Motor::declared(&EMA)
    };
    let gains = pid::Parameters {
        proportional: 2.0,
        ..pid::Parameters::default()
    };
    let closed = Loop::new(&motor, &gains, 0.0);
    let time = motor.inertia * motor.resistance / motor.torque_constant.powi(2);
    let gain = 2.0 / motor.torque_constant;
    // ω²(1 + ω²T²) = (K/k)².
    let square = ((1.0 + 4.0 * (gain * time).powi(2)).sqrt() - 1.0) / (2.0 * time * time);
    let crossover = square.sqrt();
    // A voltage that is held is half a period late.
    let expected = 90.0
        - (crossover * time).atan().to_degrees()
        - (0.5 * crossover * closed.period).to_degrees();
    let (_, phase) = closed.margins();
    assert!((phase - expected).abs() < 0.5, "{phase}°, {expected}°");
    assert!((closed.open(crossover).norm() - 1.0).abs() < 5e-3);
}

/// On the image: whatever the actuator within its tolerances and its load, a step ends without a swing.
#[test]
fn a_step_ends_without_a_swing_on_any_actuator_within_its_tolerances() {
    for seed in 0..400 {
        let mut random = Random::new(seed, 26);
        let actuator = any_actuator(&mut random);
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
        image.plant.noise = Some(Random::new(random.bits().into(), 2));
        image.plant.supply = 20.0 + 9.0 * random.uniform();
        image.run_ms(20);
        let target = 0.8 * either_way(&mut random);
        perform(&mut image, &["zero", "arm", &format!("step 0 {target}")]);
        image.run_ms(400);
        let turns = turns(&mut image, 200);
        let causes = image.wiring.latch().causes();
        assert!(causes.is_empty(), "{seed}: {causes}");
        assert!(
            turns < 2,
            "{seed}: {turns} turns, to {target}, {actuator:?}"
        );
    }
}
