//! Piecewise affine models from the logs of the throttle stand, on noise and steps that the method was not
//! made on.

use std::ops::RangeInclusive;

use host_tests::free_run::{self, Errors};
use host_tests::log::Log;
use host_tests::pwa::{self, Identified, Options, Reading, figure, identify};
use host_tests::reproduce::throttle::tables::LIMIT;

use crate::throttle_logs;

/// The paper's PWA model on validation data (its Table 1): NRMSE.
const PAPER: f64 = 0.06;

fn errors(found: &Identified, log: &Log) -> Errors {
    free_run::errors(&pwa::positions(&found.model, log).unwrap(), &log.position)
}

/// Options of a quick identification.
fn quick(clusters: RangeInclusive<usize>) -> Options {
    Options {
        clusters,
        starts: 2,
        ..Options::default()
    }
}

fn the_model_keeps_the_papers_limit(seeds: &[u64]) {
    for &seed in seeds {
        let logs = throttle_logs(seed);
        let found = identify(&[&logs.slow, &logs.fast], &Options::default()).unwrap();
        for log in [&logs.fast, &logs.validate] {
            let errors = errors(&found, log);
            println!("{seed} {errors:?}");
            assert!(
                errors.max_abs.to_degrees() <= LIMIT && errors.nrmse <= PAPER,
                "{seed} {errors:?}"
            );
        }
    }
}

#[test]
fn the_model_keeps_the_papers_limit_on_fresh_data() {
    the_model_keeps_the_papers_limit(&[61]);
}

#[test]
#[ignore = "at length"]
fn the_model_keeps_the_papers_limit_on_more_data() {
    the_model_keeps_the_papers_limit(&[71, 81]);
}

/// The fewest clusters that do nearly as well as the best, on data that was held out.
#[test]
fn the_number_of_clusters_is_chosen_by_held_out_data() {
    let logs = throttle_logs(62);
    let found = identify(&[&logs.slow, &logs.fast], &quick(2..=6)).unwrap();
    let numbers: Vec<usize> = found.candidates.iter().map(|c| c.clusters).collect();
    assert_eq!(numbers, [2, 3, 4, 5, 6]);
    let chosen = found.model.parameters().cells.len();
    let error = |clusters: usize| {
        let candidate = found.candidates.iter().find(|c| c.clusters == clusters);
        candidate.unwrap().error()
    };
    for other in numbers {
        assert!(error(chosen) <= 1.02 * error(other), "{other}");
        assert!(other >= chosen || error(other) > error(chosen), "{other}");
    }
    // Least squares are biased: the free run of what they give errs more.
    let gained = |c: &pwa::Candidate| c.parallel < c.series_parallel;
    assert!(found.candidates.iter().filter(|c| gained(c)).count() >= 3);
}

/// A model without the place of the plate drifts away; one that knows it only in its sub-models does
/// worse than one that takes the spring off the input. With `--nocapture` the table of the module's
/// documentation, on the logs of the reproduction.
#[test]
fn readings_rank_as_documented() {
    let logs = throttle_logs(1);
    let mut errors_of = [[0.0; 2]; Reading::ALL.len()];
    for (reading, errors_of) in Reading::ALL.into_iter().zip(&mut errors_of) {
        for (move_borders, nrmse) in [false, true].into_iter().zip(errors_of) {
            let options = Options {
                reading,
                move_borders,
                ..Options::default()
            };
            let found = identify(&[&logs.slow, &logs.fast], &options).unwrap();
            let [identification, validation] =
                [&logs.fast, &logs.validate].map(|log| errors(&found, log));
            println!(
                "| `{}` | {} | {} | {:.3}, {:.1}° | {:.3}, {:.1}° |",
                reading.name(),
                if move_borders { "moved" } else { "k-means" },
                found.model.parameters().cells.len(),
                identification.nrmse,
                identification.max_abs.to_degrees(),
                validation.nrmse,
                validation.max_abs.to_degrees(),
            );
            *nrmse = validation.nrmse;
        }
    }
    for way in 0..2 {
        let [output, growth, velocity, position, balance] = errors_of.map(|reading| reading[way]);
        assert!(growth < output && velocity < 0.5 * growth && position < 0.5 * growth);
        assert!(balance < velocity && balance < position);
    }
}

/// One seed is one model, on any number of threads.
#[test]
fn one_seed_is_one_model() {
    let logs = throttle_logs(62);
    let on_threads = |threads: usize, seed: u64| {
        let options = Options {
            seed,
            ..quick(3..=4)
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| identify(&[&logs.fast], &options).unwrap())
    };
    let once = on_threads(1, 1);
    assert_eq!(once, on_threads(2, 1));
    assert_ne!(once.model, on_threads(2, 2).model);
}

#[test]
fn what_no_model_can_be_had_from_is_refused_with_a_remedy() {
    let logs = throttle_logs(62);
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
    let other_period = Options {
        period_s: 1.5e-3,
        ..default.clone()
    };
    let no_start = Options {
        starts: 0,
        ..default.clone()
    };
    let cases = [
        (refused(&[], &default), "needs at least 20 s"),
        (refused(&[&short], &default), "needs at least 20 s"),
        (refused(&[&still], &default), "does not move"),
        (refused(&[&logs.fast], &quick(2..=11)), "give 1 to 10"),
        (refused(&[&logs.fast], &no_start), "a start at least"),
        (refused(&[&logs.fast], &other_period), "is no multiple"),
    ];
    for (message, expected) in cases {
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn the_drawing_has_a_colour_for_each_cell() {
    let logs = throttle_logs(62);
    let found = identify(&[&logs.fast], &quick(4..=4)).unwrap();
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
