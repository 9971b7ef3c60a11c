//! The tracing's bounded stores against the largest model that may be asked of them.

use model_core::effect::{Active, Id, Scope};
use model_core::gap::covariance::Information;
use model_core::gap::fit::variables;
use model_core::gap::log::{Channel, Log};
use model_core::gap::model::{Base, Model};
use model_core::gap::replay::{Data, InOrder, Settings};
use model_core::gap::screen::{Candidate, screen};
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
        model.effects.push(Active { id, values }).unwrap();
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
    let logs = [Log {
        period: PERIOD,
        input: Channel::Values(&input),
        position: Channel::Values(&position),
        current: None,
        velocity: None,
        brake: None,
    }];
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
    let variables = variables(&declared(), &model, &Base::ALL, &SCOPE);
    assert_eq!(variables.len(), 14 + 1 + 2 + 1 + 1);
    on_a_log(|data| {
        let mut information = Information::default();
        let windows = information.gather(data, &InOrder, &model, &variables);
        // The model and its 19 copies, each window twice.
        assert_eq!(windows, Some(data.windows() as u64 * 2 * 20));
    });
}

/// The same for what the model lacks, beside all that may be fitted.
#[test]
fn every_effect_may_be_screened_beside_all_parameters() {
    for delay in [&[][..], &[(Id::InputDelay, [0.3e-3, 0.0, 0.0])]] {
        let model = with(delay);
        let variables = variables(&declared(), &model, &Base::ALL, &SCOPE);
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
