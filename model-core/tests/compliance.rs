//! An elastic shaft in steps of a millisecond: against closed forms, against the equations themselves in
//! `f64` and steps of a microsecond, and against the rigid machine that it tends to.

use model_core::effect::compliance::Twist;
use model_core::effect::{Active, Id};
use model_core::gap::log::{Channel, Log};
use model_core::gap::model::Model;
use model_core::gap::replay::{Data, Settings, total_error};
use model_core::gap::simulator::{Course, Given, Simulator};
use model_core::plant::actuator::External;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, Motion, State};

const PERIOD: f32 = 1e-3;
const INERTIA: f32 = 0.5;

/// 30 Hz with the drive held.
const TRAILING: f32 = 2.8e-5;
const SHARE: f32 = 0.3;

/// An inertia that a torque drives, without friction.
fn free() -> Parameters {
    Parameters::free(INERTIA)
}

/// The same with friction that holds it and slows it.
fn rubbing() -> Parameters {
    Parameters {
        viscous: Directional::both(0.5),
        coulomb: Directional::both(1.0),
        breakaway: Directional::both(1.2),
        ..free()
    }
}

fn model(plant: Parameters, effects: &[(Id, [f32; 3])]) -> Model {
    let active = |&(id, values)| Active::new(id, values);
    Model {
        effects: effects.iter().map(active).collect(),
        ..Model::new(plant)
    }
}

fn elastic(plant: Parameters, damping: f32) -> Model {
    model(plant, &[(Id::Compliance, [TRAILING, SHARE, damping])])
}

fn step(simulator: &Simulator, course: &mut Course, index: usize, input: f32) {
    let given = Given {
        input,
        previous: input,
        external: External::NONE,
        index,
    };
    simulator.step(course, &given).unwrap();
}

/// Reported positions after each step from rest.
fn simulate(model: &Model, inputs: &[f32]) -> Vec<f32> {
    let simulator = model.build(PERIOD).unwrap();
    let mut course = Course::new(State::new(0.0, 0.0));
    let inputs = inputs.iter().enumerate();
    inputs
        .map(|(index, input)| {
            step(&simulator, &mut course, index, *input);
            simulator.reported(&course)
        })
        .collect()
}

/// Let go with a twisted shaft, both sides swing against each other at √(k (J₁ + J₂)/(J₁ J₂)), without
/// a loss of momentum or energy.
#[test]
fn let_go_it_swings_for_ever_at_the_frequency_of_two_masses() {
    let simulator = elastic(free(), 0.0).build(PERIOD).unwrap();
    let mut course = Course::new(State::new(0.0, 3.0));
    course.memory.twist = Twist {
        angle: 0.01,
        rate: 0.0,
    };
    let far = f64::from(SHARE * INERTIA);
    let near = f64::from(INERTIA) - far;
    let stiffness = far / f64::from(TRAILING);
    let velocities = |course: &Course| {
        let drive = f64::from(course.state.velocity.value());
        (drive, drive + f64::from(course.memory.twist.rate))
    };
    let momentum = |course: &Course| {
        let (drive, load) = velocities(course);
        near * drive + far * load
    };
    let energy = |course: &Course| {
        let (drive, load) = velocities(course);
        let angle = f64::from(course.memory.twist.angle);
        0.5 * (near * drive * drive + far * load * load + stiffness * angle * angle)
    };
    let before = (momentum(&course), energy(&course));
    let mut crossings = Vec::new();
    for index in 0..10_000_u16 {
        let last = course.memory.twist.angle;
        step(&simulator, &mut course, index.into(), 0.0);
        let angle = course.memory.twist.angle;
        if last < 0.0 && angle >= 0.0 {
            crossings.push(f64::from(index) + f64::from(last / (last - angle)));
        }
    }
    let after = (momentum(&course), energy(&course));
    assert!(
        (after.0 / before.0 - 1.0).abs() < 1e-5,
        "{before:?} {after:?}"
    );
    assert!(
        (after.1 / before.1 - 1.0).abs() < 1e-4,
        "{before:?} {after:?}"
    );
    let swings = (crossings.len() - 1) as f64;
    let seconds = (crossings[crossings.len() - 1] - crossings[0]) * f64::from(PERIOD);
    let frequency = swings / seconds;
    let exact = (stiffness * (near + far) / (near * far)).sqrt() / std::f64::consts::TAU;
    // The midpoint rule is late by a twelfth of the squared angle of a step, here 1 in 800.
    assert!(
        (frequency / exact - 1.0).abs() < 2e-3,
        "{frequency} {exact}"
    );
}

/// Position of the far side after each step, by the equations of both sides and Coulomb friction that
/// holds a drive at rest.
fn integrate(plant: &Parameters, damping: f64, inputs: &[f32]) -> Vec<f64> {
    const PARTS: u32 = 1000;
    let dt = f64::from(PERIOD) / f64::from(PARTS);
    let far = f64::from(SHARE * plant.inertia);
    let near = f64::from(plant.inertia) - far;
    let stiffness = far / f64::from(TRAILING);
    let resistance = 2.0 * damping * (stiffness * far).sqrt();
    let coulomb = f64::from(plant.coulomb.forward);
    let breakaway = f64::from(plant.breakaway.forward);
    let viscous = f64::from(plant.viscous.forward);
    let (mut drive, mut load) = ((0.0_f64, 0.0_f64), (0.0_f64, 0.0_f64));
    let mut rests = true;
    inputs
        .iter()
        .map(|input| {
            for _ in 0..PARTS {
                let shaft = stiffness * (load.0 - drive.0) + resistance * (load.1 - drive.1);
                let push = f64::from(*input) + shaft;
                if rests && push.abs() > breakaway {
                    rests = false;
                    drive.1 = 0.0_f64.copysign(push);
                }
                if !rests {
                    let friction = coulomb.copysign(drive.1) + viscous * drive.1;
                    let after = drive.1 + dt * (push - friction) / near;
                    rests = after * drive.1 < 0.0 && push.abs() <= breakaway;
                    drive.1 = if rests { 0.0 } else { after };
                    drive.0 += dt * drive.1;
                }
                load.1 -= dt * shaft / far;
                load.0 += dt * load.1;
            }
            load.0
        })
        .collect()
}

/// Pushed to and fro until it slides, rests and breaks away again, with steps that make the shaft ring.
fn pushes() -> Vec<f32> {
    (0..3000_u16)
        .map(|k| {
            let sine = (f32::from(k) * PERIOD * 2.0 * std::f32::consts::PI).sin();
            1.6 * sine + if k % 400 < 200 { 0.9 } else { -0.9 }
        })
        .collect()
}

#[test]
fn it_moves_as_the_equations_of_two_masses_say() {
    let inputs = pushes();
    for plant in [free(), rubbing()] {
        let exact = integrate(&plant, 0.05, &inputs);
        let error = |model: &Model| {
            let ours = simulate(model, &inputs);
            let errors = ours
                .iter()
                .zip(&exact)
                .map(|(ours, exact)| f64::from(*ours) - exact);
            errors.fold(0.0_f64, |most, error| most.max(error.abs()))
        };
        let (ours, rigid) = (error(&elastic(plant, 0.05)), error(&model(plant, &[])));
        assert!(
            ours < 0.03 * rigid,
            "{ours} where a rigid one is off by {rigid}"
        );
    }
}

/// With effects that are held over a step the same comes out as where the plant has them itself: a
/// spring of the catalogue is bound, and one that gravity makes of a small angle is held.
#[test]
fn held_effects_act_on_the_drive() {
    let sprung = Parameters {
        spring: 20.0,
        ..free()
    };
    let inputs: Vec<f32> = pushes().iter().map(|push| 0.02 * push).collect();
    let bound = simulate(&elastic(sprung, 0.1), &inputs);
    let shaft = (Id::Compliance, [TRAILING, SHARE, 0.1]);
    let hanging = model(free(), &[(Id::Gravity, [20.0, 0.0, 0.0]), shaft]);
    let held = simulate(&hanging, &inputs);
    let largest = bound.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    assert!(largest > 1e-3, "{largest}");
    for (index, (bound, held)) in bound.iter().zip(&held).enumerate() {
        let error = (bound - held).abs();
        assert!(
            error < 3e-3 * largest,
            "{held} instead of {bound} after {index} ms"
        );
    }
}

/// Bristles that are far stiffer than a step resolves are the friction that holds and slides.
#[test]
fn bristles_hold_the_drive_alone() {
    let plant = Parameters {
        breakaway: Directional::both(1.0),
        ..rubbing()
    };
    let inputs = pushes();
    let rubbed = simulate(&elastic(plant, 0.1), &inputs);
    let shaft = (Id::Compliance, [TRAILING, SHARE, 0.1]);
    let bristles = (Id::Presliding, [1e-9, 0.01, 0.0]);
    let bent = simulate(&model(plant, &[bristles, shaft]), &inputs);
    let largest = rubbed.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    for (index, (rubbed, bent)) in rubbed.iter().zip(&bent).enumerate() {
        let error = (rubbed - bent).abs();
        assert!(
            error < 5e-3 * largest,
            "{bent} instead of {rubbed} after {index} ms"
        );
    }
}

/// A held drive feels the swinging far side: it breaks away where the shaft and the input together exceed
/// static friction, and not before.
#[test]
fn a_twisted_shaft_lets_a_resting_drive_go() {
    let simulator = elastic(rubbing(), 0.1).build(PERIOD).unwrap();
    let stiffness = SHARE * INERTIA / TRAILING;
    for (torque, lets_go) in [(1.1, false), (1.3, true), (-1.1, false), (-1.3, true)] {
        let mut course = Course::new(State::new(0.0, 0.0));
        course.memory.twist.angle = torque / stiffness;
        step(&simulator, &mut course, 0, 0.0);
        let moved = course.state.position.value() != 0.0;
        assert_eq!(moved, lets_go, "{torque} N·m");
        // From rest the far side swings towards the drive.
        assert!(course.memory.twist.rate * torque < 0.0);
    }
}

const WINDING: Drive = Drive::Voltage {
    resistance: 1.0,
    inductance: 1e-3,
    torque_constant: 0.5,
};

/// Without trailing it is the rigid machine, and it comes near to that with little.
#[test]
fn it_tends_to_the_rigid_machine() {
    let plant = Parameters {
        drive: WINDING,
        ..rubbing()
    };
    let inputs: Vec<f32> = pushes().iter().map(|push| 3.0 * push).collect();
    let rigid = simulate(&model(plant, &[]), &inputs);
    let nothing = simulate(
        &model(plant, &[(Id::Compliance, [0.0, SHARE, 0.1])]),
        &inputs,
    );
    assert_eq!(rigid, nothing);
    // Both in halves of a step: what is held over it does nothing.
    let nothing = (Id::QuadraticDrag, [0.0; 3]);
    let rigid = simulate(&model(plant, &[nothing]), &inputs);
    let apart = |trailing: f32| {
        let shaft = (Id::Compliance, [trailing, SHARE, 0.1]);
        let elastic = simulate(&model(plant, &[shaft, nothing]), &inputs);
        let apart = elastic.iter().zip(&rigid).map(|(a, b)| (a - b).abs());
        apart.fold(0.0_f32, f32::max)
    };
    let (large, small) = (apart(1e-5), apart(1e-9));
    assert!(small < 0.01 * large, "{large} to {small}");
}

/// Pushed evenly, the far side comes to trail behind by J₂/k for each unit of acceleration.
#[test]
fn it_trails_behind_by_the_acceleration() {
    let simulator = elastic(free(), 0.3).build(PERIOD).unwrap();
    let mut course = Course::new(State::new(0.0, 0.0));
    for index in 0..500 {
        step(&simulator, &mut course, index, 2.0);
    }
    let trailing = TRAILING * 2.0 / INERTIA;
    let Twist { angle, .. } = course.memory.twist;
    assert!((angle / trailing + 1.0).abs() < 1e-4, "{angle} {trailing}");
}

/// A log of the model's own, as replays see it.
fn on_its_log(made: &Model, replayed: &Model) -> f64 {
    let inputs = pushes();
    let position = simulate(made, &inputs);
    // The input acts from its row to the next, at the end of which the position is.
    let logs = [Log::new(
        PERIOD,
        Channel::Values(&inputs[1..]),
        Channel::Values(&position),
    )];
    let settings = Settings {
        half_width: 4,
        ..Settings::new(PERIOD, 0.0)
    };
    let data = Data {
        logs: &logs,
        settings,
    };
    let simulator = replayed.build(PERIOD).unwrap();
    total_error(&data, &model_core::gap::replay::InOrder, &simulator).position_rms()
}

/// A replay carries the twist to its restarts: on its own log hardly anything is left of what a rigid
/// machine is off by; one with a shaft of no trailing replays as that one.
#[test]
fn replays_restart_with_the_twist() {
    let made = elastic(rubbing(), 0.1);
    let rigid = model(rubbing(), &[]);
    let own = on_its_log(&made, &made);
    let without = on_its_log(&made, &rigid);
    assert!(own < 0.2 * without, "{own} {without}");
    let nothing = model(rubbing(), &[(Id::Compliance, [0.0, SHARE, 0.1])]);
    assert_eq!(on_its_log(&made, &nothing), without);
    // And does not see one where there is none.
    assert!(on_its_log(&rigid, &rigid) < 0.2 * on_its_log(&rigid, &made));
}

#[test]
fn a_shaft_that_is_none_is_refused() {
    for (values, parameter) in [
        ([f32::NAN, 0.2, 0.1], "trailing"),
        ([-1e-5, 0.2, 0.1], "trailing"),
        ([1e-5, 1.0, 0.1], "share"),
        ([1e-5, -0.1, 0.1], "share"),
        ([1e-5, 0.2, -0.1], "damping"),
        ([1e-5, 0.2, f32::INFINITY], "damping"),
    ] {
        let error = model(free(), &[(Id::Compliance, values)]).build(PERIOD);
        assert_eq!(error.unwrap_err().parameter, parameter, "{values:?}");
    }
}

/// The direction of motion is the drive's.
#[test]
fn a_resting_drive_stays_at_rest() {
    let simulator = elastic(rubbing(), 0.1).build(PERIOD).unwrap();
    let mut course = Course::new(State::new(0.3, 0.0));
    course.memory.twist.angle = 1e-4;
    for index in 0..1000 {
        step(&simulator, &mut course, index, 0.5);
    }
    assert_eq!(course.state.motion, Motion::Rest);
    assert_eq!(course.state.position.value(), 0.3);
    assert!(course.memory.twist.angle.abs() < 1e-9);
}
