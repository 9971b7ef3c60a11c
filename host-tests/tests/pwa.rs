//! Piecewise affine models from the logs of the throttle stand, on noise and steps that the method was not
//! made on.

use host_tests::free_run::{self, Errors};
use host_tests::log::Log;
use host_tests::pwa::identify::{Identified, Options, identify};
use host_tests::pwa::reading::Reading;
use host_tests::pwa::{figure, run};
use host_tests::reproduce::throttle::stand::{self, Logs};
use host_tests::reproduce::throttle::tables::LIMIT;

/// The paper's PWA model on validation data (its Table 1): NRMSE.
const PAPER: f64 = 0.06;

fn logs(seed: u64) -> Logs {
    let directory = tempfile::tempdir().unwrap();
    stand::record(directory.path(), seed).unwrap()
}

fn errors(found: &Identified, log: &Log) -> Errors {
    free_run::errors(&run::positions(&found.model, log).unwrap(), &log.position)
}

fn degrees(errors: Errors) -> f64 {
    errors.max_abs.to_degrees()
}

#[test]
fn the_model_keeps_the_papers_limit_on_fresh_data() {
    let logs = logs(61);
    let found = identify(&[&logs.slow, &logs.fast], &Options::default()).unwrap();
    for log in [&logs.fast, &logs.validate] {
        let errors = errors(&found, log);
        println!("{errors:?}");
        assert!(
            degrees(errors) <= LIMIT && errors.nrmse <= PAPER,
            "{errors:?}"
        );
    }
    // The number of clusters is the one that does best on data held out.
    let trials = found.trials.iter();
    let best = trials.min_by(|a, b| a.held_out.total_cmp(&b.held_out));
    assert_eq!(best.unwrap().clusters, found.model.parameters().cells.len());
    assert_eq!(found.trials.len(), 9);
}

/// A model without the place of the plate drifts away; one that knows it only in its sub-models does
/// worse than one that takes the spring off the input. With `--nocapture` the table of the module's
/// documentation, on the logs of the reproduction.
#[test]
fn readings_rank_as_documented() {
    let logs = logs(1);
    let mut errors_of = [[0.0; 2]; Reading::ALL.len()];
    for (reading, errors_of) in Reading::ALL.into_iter().zip(&mut errors_of) {
        for (refine, nrmse) in [false, true].into_iter().zip(errors_of) {
            let options = Options {
                reading,
                refine,
                ..Options::default()
            };
            let found = identify(&[&logs.slow, &logs.fast], &options).unwrap();
            let [identification, validation] =
                [&logs.fast, &logs.validate].map(|log| errors(&found, log));
            println!(
                "| `{reading}` | {} | {} | {:.3}, {:.1}° | {:.3}, {:.1}° |",
                if refine { "fitted" } else { "k-means" },
                found.model.parameters().cells.len(),
                identification.nrmse,
                degrees(identification),
                validation.nrmse,
                degrees(validation),
            );
            *nrmse = validation.nrmse;
        }
    }
    for way in 0..2 {
        let [output, growth, velocity, position, balance] = errors_of.map(|reading| reading[way]);
        assert!(growth < output && velocity < 0.5 * growth && position < 0.5 * growth);
        assert!(balance < 0.5 * velocity && balance < 0.5 * position);
    }
}

#[test]
fn one_seed_is_one_model() {
    let logs = logs(62);
    let options = Options {
        clusters: (3, 4),
        starts: 3,
        ..Options::default()
    };
    let once = identify(&[&logs.fast], &options).unwrap();
    assert_eq!(once, identify(&[&logs.fast], &options).unwrap());
}

#[test]
fn what_no_model_can_be_had_from_is_refused_with_a_remedy() {
    let logs = logs(62);
    let short = Log {
        input: logs.fast.input[..500].to_vec(),
        position: logs.fast.position[..500].to_vec(),
        ..logs.fast.clone()
    };
    let still = Log {
        position: vec![0.5; logs.fast.position.len()],
        ..logs.fast.clone()
    };
    let refused =
        |train: &[&Log], options: &Options| identify(train, options).unwrap_err().to_string();
    let default = Options::default();
    let cases = [
        (refused(&[], &default), "give one at least"),
        (refused(&[&short], &default), "record longer"),
        (refused(&[&still], &default), "drive the actuator"),
        (
            refused(
                &[&logs.fast],
                &Options {
                    clusters: (2, 11),
                    ..default
                },
            ),
            "expected 1 to 10",
        ),
        (
            refused(
                &[&logs.fast],
                &Options {
                    period: 1.5e-3,
                    ..default
                },
            ),
            "divides its own",
        ),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn the_drawing_has_a_colour_for_each_cell() {
    let logs = logs(62);
    let options = Options {
        clusters: (4, 4),
        starts: 2,
        refine: false,
        ..Options::default()
    };
    let found = identify(&[&logs.fast], &options).unwrap();
    let svg = figure::draw(&found, &[&logs.fast]).unwrap();
    let page = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<&str> = page
        .descendants()
        .filter_map(|node| node.text())
        .map(str::trim)
        .collect();
    for cell in 1..=4 {
        assert!(
            texts.contains(&format!("cell {cell}").as_str()),
            "{texts:?}"
        );
    }
}
