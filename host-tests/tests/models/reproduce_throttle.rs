//! The way of the throttle paper, from logs to models and their errors.

use host_tests::reproduce::throttle::tables::{Column, Judged, LIMIT};
use host_tests::reproduce::throttle::{judge_all, models, stand};
use rayon::prelude::*;

use crate::throttle_logs;

/// NRMSE of the paper's physical model on validation data (its Table 1).
const PAPER: f64 = 0.06;

/// The models of a stand, judged; what the gap loop found is in the rig.
fn stand(seed: u64) -> Vec<Judged> {
    let directory = tempfile::tempdir().unwrap();
    let logs = throttle_logs(seed);
    let models = models(logs, directory.path()).unwrap();
    let there: Vec<&str> = stand::effects()
        .iter()
        .filter_map(|effect| effect.kind().id())
        .collect();
    assert!(!models.effects.is_empty());
    for found in &models.effects {
        assert!(there.contains(&found.as_str()), "{seed}: {found}");
    }
    let judged = judge_all(&models, logs).unwrap();
    for model in &judged {
        println!("{seed} {:?} {:?}", model.column, model.identification);
        println!("{seed} {:?} {:?}", model.column, model.validation);
    }
    judged
}

/// How many errors of a stand's models exceed the paper's limit.
fn beyond(judged: &[Judged]) -> usize {
    let errors = judged
        .iter()
        .flat_map(|model| [model.identification, model.validation]);
    errors.filter(|errors| errors.max_abs > LIMIT).count()
}

/// NRMSE of the model with what the gap loop found, on validation data.
fn closed(judged: &[Judged]) -> f64 {
    let extended = judged.iter().find(|model| model.column == Column::Extended);
    extended.unwrap().validation.nrmse
}

/// On the stand of the reproduction every model keeps the limit, and the closed gap halves the paper's
/// error. Pieces of it are looked at on other logs in `pwa` and in `tests/tracing/identify.rs`.
#[test]
#[ignore = "other cases"]
fn the_reproduction_keeps_the_limit_in_every_column() {
    let judged = stand(1);
    let columns: Vec<Column> = judged.iter().map(|model| model.column).collect();
    let all = [
        Column::Physical,
        Column::Fitted,
        Column::Extended,
        Column::PiecewiseAffine,
    ];
    assert_eq!(columns, all);
    assert_eq!(beyond(&judged), 0);
    assert!(closed(&judged) <= 0.5 * PAPER);
}

/// On stands that were not looked at before: a breakaway that only one of throttle and model has moves the
/// plate by 4.6°, so that now and then the steps of a stand break the limit, about one column in fifty.
#[test]
#[ignore = "at length"]
fn other_noise_and_other_steps_give_the_same_picture() {
    let stands: Vec<Vec<Judged>> = [211, 221].into_par_iter().map(stand).collect();
    let exceeding: usize = stands.iter().map(|judged| beyond(judged)).sum();
    assert!(exceeding <= 1, "{exceeding} of 16");
    let mean = stands.iter().map(|judged| closed(judged)).sum::<f64>() / stands.len() as f64;
    assert!(mean <= 0.5 * PAPER, "{mean}");
}
