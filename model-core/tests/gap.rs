//! The tracing's bounded stores against the largest model that may be asked of them, and the bounds of
//! what it fits.

use model_core::effect::{Active, Id, MOST_PARAMETERS, Role, Scope};
use model_core::gap::covariance::Information;
use model_core::gap::current_sensor::Reading;
use model_core::gap::fit::{Effort, Variable, fit, variables};
use model_core::gap::log::{Channel, Log};
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{Data, Fold, InOrder, Settings};
use model_core::gap::screen::{Candidate, screen};
use model_core::gap::simulator::{Course, Given};
use model_core::gap::workbench::Options;
use model_core::plant::actuator::{Actuator, External};
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, State};
use proptest::prelude::*;
use tracing::{PERIOD, model, plant, winding};

mod tracing;

const SCOPE: Scope = tracing::scope(0.3);

/// A machine in which every parameter means something.
fn declared() -> Model {
    model(&plant(winding(1e-3), true))
}

fn with(effects: &[(Id, [f32; 3])]) -> Model {
    let mut model = declared();
    for &(id, values) in effects {
        model.effects.push(Active::new(id, values)).unwrap();
    }
    model
}

/// Calls a test with a log of 0.3 s that moves.
fn on_a_log<R>(test: impl FnOnce(&Data) -> R) -> R {
    let input: Vec<f32> = (0..300)
        .map(|k| if k / 50 % 2 == 0 { 6.0 } else { -6.0 })
        .collect();
    let position: Vec<f32> = (0..300_u16)
        .map(|k| 0.5 - 0.5 * (f32::from(k) / 48.0).cos())
        .collect();
    let logs = [Log::new(
        PERIOD,
        Channel::Values(&input),
        Channel::Values(&position),
    )];
    let data = Data {
        logs: &logs,
        settings: Settings::new(PERIOD, 1e-3),
    };
    test(&data)
}

/// Every parameter, and every effect that changes the modes, with a delay that ends inside a step:
/// no other model needs as many modes at once.
#[test]
fn all_that_changes_the_modes_may_be_fitted_at_once() {
    let model = with(&[
        (Id::AsymmetricViscous, [1e-4, 0.0, 0.0]),
        (Id::Spring, [0.01, 0.0, 0.0]),
        (Id::InputDelay, [0.3e-3, 0.0, 0.0]),
        (Id::SensorDelay, [0.25e-3, 0.0, 0.0]),
    ]);
    let variables = variables(&declared(), &model, (&Base::ALL, &Reading::ALL), &SCOPE);
    assert_eq!(variables.len(), 15 + 1 + 2 + 1 + 1 + 3);
    on_a_log(|data| {
        let mut information = Information::default();
        let windows = information.gather(data, &InOrder, &model, &variables);
        // The model and its 20 copies, for the current's sensor needs none, each window twice.
        assert_eq!(windows, Some(data.windows() as u64 * 2 * 21));
    });
}

/// The same for what the model lacks, beside all that may be fitted.
#[test]
fn every_effect_may_be_screened_beside_all_parameters() {
    for delay in [&[][..], &[(Id::InputDelay, [0.3e-3, 0.0, 0.0])]] {
        let model = with(delay);
        let variables = variables(&declared(), &model, (&Base::ALL, &Reading::ALL), &SCOPE);
        let mut seen: Vec<Id> = Vec::new();
        let passed_over = |candidate: &Candidate| seen.push(candidate.effect.id);
        let screened =
            on_a_log(|data| screen(data, &InOrder, &model, &variables, &SCOPE, passed_over))
                .expect("room for all copies");
        let best = screened.candidates.iter();
        seen.extend(best.map(|candidate| candidate.effect.id));
        seen.sort_by_key(|id| *id as usize);
        let lacking = Id::ALL.iter().copied().filter(|id| !model.has(*id));
        assert_eq!(seen, lacking.collect::<Vec<Id>>());
        assert_eq!(screened.screened, seen.len());
    }
}

/// What logs of any machine span, from a watch's hand to a crane.
fn any_scope() -> impl Strategy<Value = Scope> {
    let size = || (-6.0_f32..6.0).prop_map(|exponent| 10_f32.powf(exponent));
    let sizes = (size(), size(), size(), size(), size(), size());
    let times = (-5.0_f32..-1.0, 0.0_f32..4.0, any::<bool>());
    (sizes, times).prop_map(|(sizes, (period, seconds, rotary))| {
        let (friction, torque, speed, stroke, voltage, current) = sizes;
        Scope {
            friction,
            torque,
            speed,
            stroke,
            voltage,
            current,
            period: 10_f32.powf(period),
            seconds: 10_f32.powf(seconds),
            rotary,
            encoder_turn: if rotary {
                core::f32::consts::TAU
            } else {
                f32::INFINITY
            },
        }
    })
}

/// The values with which the search for an effect begins.
fn tried(id: Id, scope: &Scope) -> Vec<[f32; MOST_PARAMETERS]> {
    let trials = (0..).map_while(|index| id.trial(scope, index));
    let shapes = (0..).map_while(|index| id.shapes(scope, index));
    let shaped = shapes.map(|shapes| {
        let mut values = [0.0; MOST_PARAMETERS];
        let room = values.iter_mut().skip(id.strengths());
        room.zip(shapes).for_each(|(value, shape)| *value = shape);
        values
    });
    trials.chain(shaped).collect()
}

proptest! {
    /// Wherever a search begins and wherever a fit has come to, no value is tried that the effect may
    /// not have.
    #[test]
    fn nothing_is_tried_out_of_an_effect_s_bounds(scope in any_scope(), along in 0.0_f32..1.0) {
        for &id in Id::ALL {
            let parameters = id.description().parameters;
            for values in tried(id, &scope) {
                for (parameter, value) in parameters.iter().zip(values) {
                    prop_assert!(
                        parameter.bounds.contains(value),
                        "{id:?} begins with {} = {value}", parameter.name
                    );
                }
                for (index, parameter) in parameters.iter().enumerate() {
                    let first = Variable::effect(id, 0, index, values[index], &scope);
                    // Fitted again from where a fit has come to.
                    let there = first.lower + along * (first.upper - first.lower);
                    let again = Variable::effect(id, 0, index, there, &scope);
                    for variable in [first, again] {
                        let (lower, upper) = (variable.lower, variable.upper);
                        prop_assert!(lower < upper, "{id:?} {}: {lower}, {upper}", parameter.name);
                        prop_assert!(
                            parameter.bounds.contains(lower) && parameter.bounds.contains(upper),
                            "{id:?} {}: {lower} to {upper}, not {}", parameter.name, parameter.bounds
                        );
                    }
                }
            }
        }
    }
}

/// A sweep of a plant over 2 s; its position is reported so many samples late.
fn swept(plant: &Parameters, late: usize) -> (Vec<f32>, Vec<f32>) {
    let actuator = Actuator::build(plant, PERIOD).unwrap();
    let mut state = State::new(0.0, 0.0);
    let (mut input, mut position) = (Vec::new(), vec![0.0; late]);
    for sample in 0..2000 {
        let time = sample as f32 * PERIOD;
        let volts = 5.0 * (9.0 * time).sin() + 4.0 * (31.0 * time).sin();
        input.push(volts);
        // A sensor of 0.1 mrad.
        position.push((state.position.value() * 1e4).round() * 1e-4);
        actuator.step(&mut state, volts).unwrap();
    }
    position.truncate(input.len());
    (input, position)
}

/// An effect fitted to a log of what it may not be ends at its bound.
#[track_caller]
fn assert_ends_at(bound: f32, (input, position): &(Vec<f32>, Vec<f32>), effect: Active) {
    let logs = [Log::new(
        PERIOD,
        Channel::Values(input),
        Channel::Values(position),
    )];
    let data = Data {
        logs: &logs,
        settings: Settings::new(PERIOD, 1e-4),
    };
    let declared = model(&plant(winding(1e-3), false));
    let mut start = declared.clone();
    start.effects.push(effect).unwrap();
    let scope = tracing::scope(2.0);
    let strengths = variables(&declared, &start, (&[], &[]), &scope);
    assert_eq!(effect.id.description().parameters[0].role, Role::Strength);
    let effort = Effort {
        steps: 30,
        converged: 1e-6,
    };
    let fitted = fit(&data, &InOrder, (Fold::All, 1), &start, &strengths, effort).unwrap();
    assert_eq!(fitted.model.effects[0].values[0], bound, "{:?}", effect.id);
}

/// A gear would have to drive to have less friction under load than without.
#[test]
fn a_friction_that_falls_with_the_load_is_fitted_as_none() {
    let declared = plant(winding(1e-3), false);
    let easier = Parameters {
        coulomb: Directional::both(0.8 * declared.coulomb.forward),
        breakaway: Directional::both(0.8 * declared.breakaway.forward),
        ..declared
    };
    let effect = Active::new(Id::LoadDependentFriction, [0.1]);
    assert_ends_at(0.0, &swept(&easier, 0), effect);
}

#[test]
fn a_delay_beyond_the_longest_is_fitted_as_the_longest() {
    let effect = Active::new(Id::SensorDelay, [0.2]);
    assert_ends_at(0.25, &swept(&plant(winding(1e-3), false), 270), effect);
}

/// A motion over less than a cycle and a half does not show that a torque repeats. A period that was declared
/// stays.
#[test]
fn a_cogging_is_fitted_over_a_cycle_and_a_half_at_least() {
    let limit = |period: f32| Variable::effect(Id::Cogging, 0, 2, period, &SCOPE).upper;
    assert_eq!(limit(0.6 * SCOPE.stroke), SCOPE.stroke / 1.5);
    assert_eq!(limit(0.2 * SCOPE.stroke), 3.0 * (0.2 * SCOPE.stroke));
    assert_eq!(limit(1.5 * SCOPE.stroke), 1.5 * SCOPE.stroke);
}

/// Three standard deviations either way on a logarithmic scale, of the factor that is stated, or of two.
#[test]
fn a_fit_leaves_a_number_as_far_off_as_it_is_unsure() {
    on_a_log(|data| {
        let options = Options::new(data, &declared(), &Base::ALL, true).unwrap();
        let stated = [
            (Base::Coulomb, 3.0),
            (Base::Inertia, 1.0),
            (Base::Viscous, 1e9),
        ];
        let options = Options {
            unsure: &stated,
            ..options
        };
        let limits = |number| options.limits(number, 0.5);
        assert_eq!(limits(Base::Resistance), Some([0.5 / 8.0, 0.5 * 8.0]));
        assert_eq!(limits(Base::Coulomb), Some([0.5 / 27.0, 0.5 * 27.0]));
        assert_eq!(limits(Base::Inertia), Some([0.5, 0.5]));
        // What is declared as none has no scale to be off by, and a place has none either.
        assert_eq!(options.limits(Base::Coulomb, 0.0), None);
        assert_eq!(limits(Base::SpringRest), None);
        // A fit that stops at the bound of a number has not found it.
        let bounds = Variable::base(&declared(), Base::Viscous, &SCOPE);
        let value = declared().get(Base::Viscous);
        let [least, largest] = options.limits(Base::Viscous, value).unwrap();
        assert!(bounds.lower < least && largest < bounds.upper, "{bounds:?}");
    });
}

/// A log of a second has as many windows as it takes to prove something, a long one windows of 0.2 s.
#[test]
fn a_short_log_is_cut_into_short_windows() {
    for (seconds, period, longest) in [
        (1.2, 5e-5, 0.05),
        (0.3, 1e-3, 0.0125),
        (5.0, 1e-3, 0.2),
        (60.0, 1e-2, 0.2),
    ] {
        let values = vec![0.0; (seconds / period) as usize];
        let channel = Channel::Values(&values);
        let logs = [Log::new(period, channel, channel)];
        let data = Data::new(&logs, 0.0).unwrap();
        let length = data.settings.window as f32 * period;
        assert!(
            length <= longest + 0.5 * period,
            "{length} s in {seconds} s"
        );
        assert!(data.windows() >= 24, "{} in {seconds} s", data.windows());
    }
}

/// While the drive lets go of the motor the rotor coasts: J v' = −F − B v, with v(0) = v₀, of which
/// v(t) = (v₀ + F/B) exp(−B t/J) − F/B is the solution, whatever the input says and an effect adds to it.
#[test]
fn a_released_rotor_coasts() {
    let voltage_lost = Active::new(Id::BrushDrop, [0.5]);
    let released = External {
        released: true,
        ..External::NONE
    };
    for (drive, effect) in [
        (Drive::Torque, None),
        (winding(0.0), None),
        (winding(1e-3), None),
        (winding(1e-3), Some(voltage_lost)),
    ] {
        let mut model = model(&plant(drive, false));
        model.effects.extend(effect);
        let simulator = model.build(PERIOD).unwrap();
        let mut course = Course::new(State::new(-0.5, 8.0));
        for index in 0..6 {
            let given = Given {
                input: 3.0,
                previous: 3.0,
                external: released,
                index,
            };
            simulator.step(&mut course, &given).unwrap();
        }
        let (inertia, viscous, coulomb) = (1.2e-4_f64, 2e-4, 0.12);
        let level = coulomb / viscous;
        let truth = (8.0 + level) * (-viscous * 6e-3 / inertia).exp() - level;
        let velocity = f64::from(course.state.velocity.value());
        assert!(
            (velocity - truth).abs() < 1e-4,
            "{velocity}, {truth}: {model:?}"
        );
        assert!(course.state.current.abs() < 1e-4, "{course:?}");
    }
}

/// What flowed when the drive lets go has gone with the step.
#[test]
fn a_released_winding_carries_no_current() {
    let simulator = model(&plant(winding(4e-3), false)).build(PERIOD).unwrap();
    let mut course = Course::new(State::new(0.0, 5.0));
    course.state.current = 3.0;
    let given = Given {
        input: 6.0,
        previous: 6.0,
        external: External {
            released: true,
            ..External::NONE
        },
        index: 0,
    };
    simulator.step(&mut course, &given).unwrap();
    assert!(course.state.current.abs() < 1e-4, "{course:?}");
}
