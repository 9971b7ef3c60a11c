//! A recorded drive on a tape, and its replay by the plant interrupt's code.

use firmware::app::machine::THROTTLE;
use firmware::app::replay::{Replay, Row};
use firmware::app::tape::{self, Driven, Tape, TapeError};
use firmware::app::timing::{PLANT_PERIOD, TICKS_PER_CONTROL};
use model_core::effect::{Active, Id, padded};
use model_core::gap::model::Model;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::piecewise_affine::{Affine, Cell, Parameters, PiecewiseAffine};

/// Inputs of the tapes, V.
fn inputs() -> Vec<f32> {
    (0..400)
        .map(|row| [3.0, -2.5, 6.0, 0.0][row / 100])
        .collect()
}

fn throttle() -> Model {
    Model::new(THROTTLE.plant)
}

fn with_effect(id: Id, values: [f32; 3]) -> Model {
    let mut model = throttle();
    model.effects.push(Active::new(id, values)).unwrap();
    model
}

fn written(model: &Model, inputs: &[f32]) -> Vec<u8> {
    written_of(&Driven::Physical(model.clone()), inputs)
}

fn written_of(model: &Driven, inputs: &[f32]) -> Vec<u8> {
    let mut bytes = vec![0xFF; tape::HEAD_BYTES + 8 + 4 * inputs.len()];
    tape::write(model, THROTTLE.rest, TICKS_PER_CONTROL, inputs, &mut bytes)
        .unwrap()
        .to_vec()
}

fn rows(bytes: &[u8]) -> Vec<Row> {
    let mut replay = Replay::new(Tape::read(bytes).unwrap()).unwrap();
    let ticks = replay.rows() * TICKS_PER_CONTROL + 100;
    (0..ticks).filter_map(|_| replay.tick().unwrap()).collect()
}

#[test]
fn a_tape_gives_back_what_was_written_whatever_lies_behind_it() {
    let inputs = inputs();
    let mut bytes = written(&with_effect(Id::Cogging, [0.01, 0.02, 0.3]), &inputs);
    bytes.extend([0xFF; 100]);
    let tape = Tape::read(&bytes).unwrap();
    let Driven::Physical(model) = &tape.head.model else {
        panic!("another kind of model");
    };
    assert_eq!(model.plant, THROTTLE.plant);
    assert_eq!(model.effects[0].values, padded([0.01, 0.02, 0.3]));
    assert_eq!(tape.head.start, THROTTLE.rest);
    assert_eq!(tape.len(), inputs.len());
    let read: Vec<f32> = (0..tape.len()).map(|index| tape.input(index)).collect();
    assert_eq!(read, inputs);
    assert_eq!(tape.input(inputs.len()), 0.0);
    assert_eq!(tape.input(usize::MAX), 0.0);
}

#[test]
fn no_damaged_tape_is_believed() {
    let bytes = written(&throttle(), &inputs());
    for index in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[index] ^= 0x10;
        let padding = Tape::read(&damaged).is_ok_and(|tape| {
            // Between head and inputs there may be up to three bytes that mean nothing.
            tape.len() == inputs().len() && bytes[index] == 0
        });
        assert!(padding || Tape::read(&damaged).is_err(), "byte {index}");
    }
    for length in 0..bytes.len() {
        assert!(Tape::read(&bytes[..length]).is_err(), "{length} bytes");
    }
    assert_eq!(Tape::read(&[0xFF; 64]).unwrap_err(), TapeError::Missing);
    let mut cut = bytes.clone();
    cut.truncate(bytes.len() - 1);
    assert_eq!(Tape::read(&cut).unwrap_err(), TapeError::Length);
}

#[test]
fn inputs_that_are_no_numbers_are_refused() {
    for inputs in [&[1.0, f32::NAN][..], &[f32::INFINITY], &[]] {
        let bytes = written(&throttle(), inputs);
        assert_eq!(Tape::read(&bytes).unwrap_err(), TapeError::Values);
    }
}

#[test]
fn a_tape_that_does_not_fit_is_not_written() {
    let mut bytes = [0; 600];
    let fits = |inputs: &[f32], bytes: &mut [u8]| {
        let model = Driven::Physical(throttle());
        tape::write(&model, 0.0, 20, inputs, bytes).is_some()
    };
    assert!(fits(&[0.0; 20], &mut bytes));
    assert!(!fits(&[0.0; 200], &mut bytes));
    assert!(!fits(&[0.0], &mut bytes[..30]));
}

#[test]
fn a_model_out_of_range_is_refused() {
    let mut model = throttle();
    model.plant.inertia = 0.0;
    let bytes = written(&model, &inputs());
    let error = Replay::new(Tape::read(&bytes).unwrap()).unwrap_err();
    assert!(error.to_string().contains("inertia"), "{error}");
    // Plant periods do not go into this one a whole number of times.
    let mut parameters = piecewise_affine();
    parameters.period = 1.01 * PLANT_PERIOD;
    let bytes = written_of(&Driven::PiecewiseAffine(parameters), &inputs());
    let error = Replay::new(Tape::read(&bytes).unwrap()).unwrap_err();
    assert!(error.to_string().contains("period"), "{error}");
}

/// Held below 1 V, moving above it. Ten cells, as many as there can be.
fn piecewise_affine() -> Parameters {
    let affine = |input, constant| Affine {
        input,
        constant,
        ..Affine::default()
    };
    let cell = |cell: u8| {
        let steepness = f32::from(cell);
        Cell {
            region: affine(steepness, -0.5 * steepness * (steepness + 1.0)),
            growth: affine(0.01 * steepness, -0.01 * steepness),
        }
    };
    Parameters {
        period: 0.01,
        lower_limit: 0.0,
        upper_limit: 1.5,
        cells: (0..10).map(cell).collect(),
    }
}

#[test]
fn a_piecewise_affine_model_is_replayed_from_sample_to_sample() {
    let inputs = inputs();
    let parameters = piecewise_affine();
    let rows = rows(&written_of(
        &Driven::PiecewiseAffine(parameters.clone()),
        &inputs,
    ));
    assert_eq!(rows.len(), inputs.len());
    let model = PiecewiseAffine::build(parameters).unwrap();
    let mut state = model.rest(THROTTLE.rest).unwrap();
    // Ten rows are a period, and the inputs change at its ends only.
    for (sample, input) in rows.chunks(10).zip(inputs.iter().step_by(10)) {
        assert!((sample[0].position - state.position()).abs() < 1e-5);
        let from = state.position();
        let to = model.step(&mut state, *input).unwrap();
        assert!((sample[5].position - 0.5 * (from + to)).abs() < 1e-5);
    }
    let moved = rows.iter().any(|row| row.position > 0.5);
    assert!(moved, "the plate opens");
    assert!(rows.iter().all(|row| row.current == 0.0));
}

/// A replay is the plant stepped with the inputs of the tape: a row, then its input up to the next.
#[test]
fn a_replay_is_the_actuator_driven_by_the_inputs() {
    let inputs = inputs();
    let rows = rows(&written(&throttle(), &inputs));
    assert_eq!(rows.len(), inputs.len());
    let actuator = Actuator::build(&THROTTLE.plant, PLANT_PERIOD).unwrap();
    let mut state = State::new(THROTTLE.rest, 0.0);
    for (index, (row, &input)) in rows.iter().zip(&inputs).enumerate() {
        assert_eq!(row.row as usize, index);
        assert_eq!(row.position, state.position.value());
        assert_eq!(row.current, state.current);
        for _ in 0..TICKS_PER_CONTROL {
            actuator.step(&mut state, input).unwrap();
        }
    }
    let moved = rows.iter().any(|row| row.position > 0.5);
    assert!(moved, "the plate opens");
}

/// An effect on the tape acts, and a late drive is late by what it says.
#[test]
fn effects_of_the_tape_act() {
    let inputs = inputs();
    let plain = rows(&written(&throttle(), &inputs));
    let rippled = rows(&written(
        &with_effect(Id::Cogging, [0.05, 0.05, 0.2]),
        &inputs,
    ));
    assert!(
        plain
            .iter()
            .zip(&rippled)
            .any(|(plain, rippled)| (plain.position - rippled.position).abs() > 1e-3)
    );
    let late = rows(&written(
        &with_effect(Id::InputDelay, [0.002, 0.0, 0.0]),
        &inputs,
    ));
    for (plain, late) in plain.iter().zip(&late[2..]) {
        assert_eq!(plain.position, late.position);
    }
}
