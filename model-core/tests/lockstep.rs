//! Windows that are replayed in lockstep have the bits of windows that are replayed one by one, whatever
//! the model, the log and the number of lanes.

use model_core::effect::learned_map::{Kind, LearnedMap, Ranges};
use model_core::effect::{Active, Id, MOST_PARAMETERS, Scope};
use model_core::gap::covariance::Information;
use model_core::gap::current_sensor::{CurrentSensor, Reading};
use model_core::gap::fit::variables;
use model_core::gap::log::{Channel, Log};
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{self, Data, Fold, InOrder, Job, Schedule, Settings, WindowStart};
use model_core::gap::screen::screen;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::parameters::{Drive, Parameters};
use tracing::{PERIOD, model, plant, winding};

mod tracing;

const SCOPE: Scope = tracing::scope(1.5);

/// So many windows at once.
struct Together<const N: usize>;

impl<const N: usize> Schedule for Together<N> {
    fn at_once(&self) -> usize {
        2 * N
    }

    fn run<R: Default + Send>(
        &self,
        count: usize,
        work: impl Fn(usize, &mut R) + Send + Sync,
        fold: impl FnMut(usize, &R),
    ) {
        InOrder.run(count, work, fold);
    }

    fn run_job<J: Job>(&self, count: usize, job: &J, mut fold: impl FnMut(usize, &J::Result)) {
        // Side by side lie windows from all over the logs.
        let groups = count.div_ceil(N);
        let mut results: Vec<Option<J::Result>> = Vec::new();
        results.resize_with(count, || None);
        for group in 0..groups {
            let numbers: Vec<usize> = (group..count).step_by(groups).collect();
            let mut worked: Vec<J::Result> = Vec::new();
            worked.resize_with(numbers.len(), Default::default);
            job.work::<N>(&numbers, &mut worked);
            for (number, result) in numbers.into_iter().zip(worked) {
                results[number] = Some(result);
            }
        }
        for (number, result) in results.iter().flatten().enumerate() {
            fold(number, result);
        }
    }
}

/// A voltage drive with and without inductance, and a torque drive without a spring.
fn plants() -> [Parameters; 3] {
    [
        plant(winding(1e-3), true),
        plant(winding(0.0), false),
        plant(Drive::Torque, false),
    ]
}

/// A recording of a plant that slides, turns, rests and meets its stops.
struct Recording {
    input: Vec<f32>,
    position: Vec<f32>,
    current: Vec<f32>,
    velocity: Vec<f32>,
    brake: Vec<f32>,
    enabled: Vec<f32>,
}

impl Recording {
    fn of(plant: &Parameters, samples: usize) -> Self {
        let actuator = Actuator::build(plant, PERIOD).unwrap();
        let mut state = State::new(0.2, 0.0);
        let mut recording = Self {
            input: Vec::new(),
            position: Vec::new(),
            current: Vec::new(),
            velocity: Vec::new(),
            brake: Vec::new(),
            enabled: Vec::new(),
        };
        for sample in 0..samples {
            let time = sample as f32 * PERIOD;
            let pause = sample / 150 % 4 == 3;
            let swing = 5.0 * (37.0 * time).sin() + 2.5 * (90.0 * time).sin();
            let input = if pause { 0.0 } else { swing };
            recording.input.push(input);
            // A sensor of 1 mrad.
            let counts = (state.position.value() * 1e3).round();
            recording.position.push(counts * 1e-3);
            recording.current.push(state.current);
            recording.velocity.push(state.velocity.value());
            let braked = (400..500).contains(&sample);
            recording.brake.push(if braked { 0.03 } else { 0.0 });
            let released = (640..700).contains(&sample);
            recording.enabled.push(if released { 0.0 } else { 1.0 });
            actuator.step(&mut state, input).unwrap();
        }
        recording
    }

    /// With no more than the position, with a current and a brake, and with a velocity.
    fn logs(&self) -> [Log<'_>; 3] {
        let plain = Log::new(
            PERIOD,
            Channel::Values(&self.input),
            Channel::Values(&self.position),
        );
        [
            plain,
            Log {
                current: Some(Channel::Values(&self.current)),
                brake: Some(Channel::Values(&self.brake)),
                load: Some(Channel::Values(&self.brake)),
                enabled: Some(Channel::Values(&self.enabled)),
                ..plain
            },
            Log {
                velocity: Some(Channel::Values(&self.velocity)),
                ..plain
            },
        ]
    }
}

/// Every effect at a strength that acts, some together, and every map.
fn models(plant: &Parameters) -> Vec<(String, Model)> {
    let acting = |id: Id| {
        let trial = id.trial(&SCOPE, 4).or(id.trial(&SCOPE, 1));
        let values = trial.unwrap_or_else(|| {
            let shapes = id.shapes(&SCOPE, 1).or(id.shapes(&SCOPE, 0));
            let mut values = [0.0; MOST_PARAMETERS];
            for index in 0..id.strengths() {
                values[index] = 0.6 * id.scale(&SCOPE, index);
            }
            for (value, shape) in values[id.strengths()..]
                .iter_mut()
                .zip(shapes.unwrap_or_default())
            {
                *value = shape;
            }
            values
        });
        Active { id, values }
    };
    let has_winding = plant.drive != Drive::Torque;
    let possible = |id: &&Id| has_winding || !id.needs_winding();
    let mut sets: Vec<Vec<Id>> = Id::ALL
        .iter()
        .filter(possible)
        .map(|&id| vec![id])
        .collect();
    sets.push(vec![Id::InputDelay, Id::Presliding, Id::Cogging]);
    sets.push(vec![Id::SensorDelay, Id::Backlash, Id::Stribeck]);
    sets.push(vec![Id::Compliance, Id::Backlash]);
    sets.push(vec![Id::Compliance, Id::Presliding]);
    sets.push(vec![Id::Compliance, Id::Stribeck, Id::SensorDelay]);
    if has_winding {
        sets.push(vec![
            Id::InputDelay,
            Id::BrushDrop,
            Id::SupplySag,
            Id::ThermalDrift,
        ]);
    }
    let mut models = vec![("nothing".to_owned(), model(plant))];
    for set in sets {
        let mut with = model(plant);
        for &id in &set {
            with.effects.push(acting(id)).unwrap();
        }
        models.push((format!("{set:?}"), with));
    }
    for lag in [0.0, 0.3, 1.0, 2.4] {
        for id in [None, Some(Id::SensorDelay)] {
            let mut with = model(plant);
            with.effects.extend(id.map(acting));
            with.current_sensor = CurrentSensor {
                gain: 0.97,
                offset: 0.02,
                lag: lag * PERIOD,
            };
            models.push((format!("{id:?} and {:?}", with.current_sensor), with));
        }
    }
    let ranges = Ranges {
        position: (-1.0, 1.0),
        velocity: (-10.0, 10.0),
        motor_torque: (-0.4, 0.4),
        time: (0.0, 1.5),
    };
    for kind in Kind::ALL {
        let mut map = LearnedMap::flat(kind, &ranges);
        for (knot, value) in map.knots.iter_mut().enumerate() {
            *value = 0.01 * (knot as f32 - 3.0);
        }
        let mut with = model(plant);
        with.map = Some(map);
        models.push((format!("{kind:?}"), with));
    }
    models
}

/// Calls a test with windows of logs of each kind and of two kinds, as many as fill no lanes evenly.
fn on_logs(plant: &Parameters, mut test: impl FnMut(&Data)) {
    let recordings = [1490, 700].map(|samples| Recording::of(plant, samples));
    for (kinds, window_start) in [
        ([0, 0], WindowStart::Slope),
        ([0, 0], WindowStart::Simulated),
        ([1, 1], WindowStart::Slope),
        ([2, 2], WindowStart::Measured),
        ([1, 0], WindowStart::Simulated),
        ([0, 1], WindowStart::Slope),
    ] {
        let logs = [0, 1].map(|recording: usize| recordings[recording].logs()[kinds[recording]]);
        let kind = kinds[0].max(kinds[1]);
        let mut settings = Settings::new(PERIOD, 1e-3);
        settings.window = 50;
        settings.half_width = 4;
        settings.position_weight = 300.0;
        settings.current_weight = if kind == 0 { 0.0 } else { 2.0 };
        settings.window_start = window_start;
        settings.velocity_channel = kind == 2;
        test(&Data {
            logs: &logs,
            settings,
        });
    }
}

#[test]
fn a_replay_has_the_same_errors() {
    for plant in plants() {
        on_logs(&plant, |data| {
            for (name, model) in models(&plant) {
                let simulator = model.build(PERIOD).unwrap();
                let total = replay::total_error(data, &InOrder, &simulator);
                assert!(total.position_rms() > 0.0);
                assert_eq!(
                    total,
                    replay::total_error(data, &Together::<4>, &simulator),
                    "{name}"
                );
                assert_eq!(
                    total,
                    replay::total_error(data, &Together::<16>, &simulator),
                    "{name}"
                );
                for fold in [(Fold::All, 1), (Fold::Even, 3), (Fold::Odd, 3)] {
                    let cost = replay::cost(data, &InOrder, fold, &simulator);
                    assert!(cost.0 > 0.0);
                    let together = replay::cost(data, &Together::<16>, fold, &simulator);
                    assert_eq!(cost, together, "{name} {fold:?}");
                    for (limit, expected) in [
                        (1.000_01 * cost.0, Some(cost.0)),
                        (cost.0, None),
                        (0.3 * cost.0, None),
                        (1e-6 * cost.0, None),
                    ] {
                        let below = [
                            replay::cost_below(limit, data, &InOrder, fold, &simulator),
                            replay::cost_below(limit, data, &Together::<4>, fold, &simulator),
                        ];
                        assert_eq!(below, [expected; 2], "{name} {fold:?} {limit}");
                    }
                }
            }
        });
    }
}

#[test]
fn sums_over_perturbed_copies_are_the_same() {
    let base = [Base::Inertia, Base::Viscous, Base::Coulomb, Base::Static];
    let plant = &plants()[0];
    on_logs(plant, |data| {
        for (name, with) in models(plant) {
            let variables = variables(&model(plant), &with, (&base, &Reading::ALL), &SCOPE);
            let [one_by_one, together] = [true, false].map(|one_by_one| {
                let mut information = Information::default();
                if one_by_one {
                    information.gather(data, &InOrder, &with, &variables)
                } else {
                    information.gather(data, &Together::<16>, &with, &variables)
                }
                .unwrap();
                // A number printed in full is another one wherever a bit is.
                format!("{information:?}")
            });
            assert!(one_by_one == together, "{name}");
        }
    });
}

#[test]
fn a_screening_is_the_same() {
    for plant in plants() {
        on_logs(&plant, |data| {
            let model = model(&plant);
            let variables = variables(
                &model,
                &model,
                (&[Base::Inertia, Base::Coulomb], &Reading::ALL),
                &SCOPE,
            );
            let mut passed_over = [Vec::new(), Vec::new()];
            let [first, second] = &mut passed_over;
            let one = screen(data, &InOrder, &model, &variables, &SCOPE, |it| {
                first.push(*it)
            });
            let all = screen(data, &Together::<8>, &model, &variables, &SCOPE, |it| {
                second.push(*it)
            });
            let (one, all) = (one.unwrap(), all.unwrap());
            assert_eq!(one.candidates, all.candidates);
            assert_eq!(one.collinearity, all.collinearity);
            assert_eq!(first, second);
        });
    }
}
