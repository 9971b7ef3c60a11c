//! A batch beside its actuators one by one: no bit may differ.

use model_core::plant::actuator::Actuator;
use model_core::plant::batch::Batch;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Compensated, Directional, State};
use proptest::prelude::*;

const LANES: usize = 8;

/// A number between two powers of ten, each decade as likely as another.
fn decades(lowest: f32, highest: f32) -> impl Strategy<Value = f32> {
    (lowest..highest).prop_map(|exponent| 10_f32.powf(exponent))
}

fn or_zero(strategy: impl Strategy<Value = f32>) -> impl Strategy<Value = f32> {
    (any::<bool>(), strategy).prop_map(|(there, value)| if there { value } else { 0.0 })
}

fn directional(lowest: f32, highest: f32) -> impl Strategy<Value = Directional> {
    let level = || or_zero(decades(lowest, highest));
    (level(), level()).prop_map(|(forward, backward)| Directional { forward, backward })
}

fn drives() -> impl Strategy<Value = Drive> {
    prop_oneof![
        Just(Drive::Torque),
        (
            decades(-1.0, 1.0),
            or_zero(decades(-5.0, -1.0)),
            decades(-2.0, 1.0)
        )
            .prop_map(|(resistance, inductance, torque_constant)| Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            }),
    ]
}

/// Actuators over many decades, with a spring or without one.
fn machines(sprung: bool) -> impl Strategy<Value = Parameters> {
    let friction = (
        directional(-4.0, 1.0),
        directional(-3.0, 1.0),
        directional(-3.0, 1.0),
    );
    let spring = (
        or_zero(decades(-2.0, 2.0)),
        -0.5_f32..0.5,
        or_zero(decades(-2.0, 1.0)),
    );
    let rest = (
        decades(-5.0, 1.0),
        prop_oneof![Just(0.0_f32), -1.0_f32..1.0],
        prop_oneof![Just(f32::INFINITY), 0.1_f32..2.0],
    );
    (drives(), friction, spring, rest).prop_map(
        move |(drive, friction, spring, (inertia, offset, stop))| Parameters {
            drive,
            gain: 1.0,
            inertia,
            viscous: friction.0,
            coulomb: friction.1,
            breakaway: friction.2,
            spring: if sprung { spring.0 } else { 0.0 },
            spring_rest: if sprung { spring.1 } else { 0.0 },
            spring_preload: if sprung { spring.2 } else { 0.0 },
            offset,
            lower_stop: -stop,
            upper_stop: stop,
        },
    )
}

/// Every bit of a state.
fn bits(state: &State) -> (u32, [u32; 4], String) {
    let parts = |sum: Compensated| {
        let value = sum.value();
        [value.to_bits(), sum.from(value).to_bits()]
    };
    let [velocity, position] = [state.velocity, state.position].map(parts);
    (
        state.current.to_bits(),
        [velocity[0], velocity[1], position[0], position[1]],
        format!("{:?}", state.motion),
    )
}

/// An input in thousands that no step takes.
fn inputs() -> impl Strategy<Value = f32> {
    prop_oneof![
        990 => -1.0_f32..1.0,
        5 => prop::sample::select(vec![0.0_f32, -0.0]),
        5 => prop::sample::select(vec![f32::NAN, f32::INFINITY, 1e7, -1e7]),
    ]
}

/// Steps a batch and its lanes one by one.
fn compare(
    machines: &[Parameters],
    period: f32,
    starts: &[(f32, f32)],
    amplitude: f32,
    inputs: &[f32],
) -> Result<(), TestCaseError> {
    let actuators: [Actuator; LANES] =
        core::array::from_fn(|lane| Actuator::build(&machines[lane], period).unwrap());
    let mut alone: [State; LANES] = core::array::from_fn(|lane| {
        let (position, velocity) = starts[lane];
        State::new(position, velocity)
    });
    let mut batch = Batch::new(actuators, alone);
    for step in 0..1500 {
        // Each input is held for some steps, and each lane has its own.
        let inputs: [f32; LANES] =
            core::array::from_fn(|lane| amplitude * inputs[(step / 15 + 7 * lane) % inputs.len()]);
        let taken = batch.step(&inputs);
        let mut expected = Ok(());
        for lane in 0..LANES {
            expected = expected.and(actuators[lane].step(&mut alone[lane], inputs[lane]));
        }
        prop_assert_eq!(taken, expected);
        for lane in 0..LANES {
            let (ours, theirs) = (bits(&batch.state(lane)), bits(&alone[lane]));
            prop_assert_eq!(ours, theirs, "step {}, lane {}", step, lane);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn no_bit_differs_without_springs(
        machines in prop::collection::vec(machines(false), LANES),
        period in decades(-5.0, -2.0),
        starts in prop::collection::vec((-0.1_f32..0.1, prop_oneof![Just(0.0_f32), -10.0_f32..10.0]), LANES),
        amplitude in decades(-2.0, 3.0),
        inputs in prop::collection::vec(inputs(), 100),
    ) {
        compare(&machines, period, &starts, amplitude, &inputs)?;
    }

    #[test]
    fn no_bit_differs_with_springs(
        sprung in prop::collection::vec(machines(true), LANES - 2),
        free in prop::collection::vec(machines(false), 2),
        period in decades(-5.0, -2.0),
        starts in prop::collection::vec((-0.1_f32..0.1, prop_oneof![Just(0.0_f32), -10.0_f32..10.0]), LANES),
        amplitude in decades(-2.0, 3.0),
        inputs in prop::collection::vec(inputs(), 100),
    ) {
        let machines: Vec<Parameters> = sprung.into_iter().chain(free).collect();
        compare(&machines, period, &starts, amplitude, &inputs)?;
    }
}
