//! Promise: the first twelve lines of `cargo hil gap` say what was found, how much better the model is, how sure
//! that is and what to do next, for each verdict and however much was found; an error that has risen is said; and
//! the page begins with the same words.

use crate::gap_example::{estimate, example, fitted, variant, variants};
use host_tests::gap::demand::Demand;
use host_tests::gap::disagreement::Disagreement;
use host_tests::gap::experiment::{Absorbed, Bounds, NextExperiment, Quantity};
use host_tests::gap::headline::{Headline, LINES, Step};
use host_tests::gap::outcome::{FoundEffect, FreeMotor, Report, Resampled, ShortLogs};
use host_tests::gap::report;
use host_tests::gap::table::{Detail, WIDTH, render};
use host_tests::log::resample::Resampling;
use host_tests::machine::DeclaredEffect;
use model_core::effect::Id;
use model_core::gap::verdict::Verdict;

const HINT: &str = "More: --verbose.";

/// A line of `[fit]` that frees the motor's numbers.
const FREE_MOTOR: &str = "parameters = [\"inertia\", \"viscous\", \"coulomb\", \"static\", \"resistance\", \
                          \"torque_constant\"]";

/// What a pipe gets, as the program prints it and as the main loop does.
fn brief(report: &Report) -> [String; 2] {
    [Some(HINT), None].map(|hint| render(report, false, Detail::Brief { hint }))
}

/// That `[fit]` leaves these numbers of the motor out.
fn free_motor(fixed: &[&'static str]) -> Option<FreeMotor> {
    Some(FreeMotor {
        fixed: fixed.to_vec(),
        line: FREE_MOTOR.into(),
    })
}

/// The words of the answer in one line.
fn words(report: &Report) -> String {
    let [text, _] = brief(report);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Logs and machine file that disagree in three things, each with a remedy of its own.
fn disagreeing() -> Report {
    let mut report = example();
    let outcome = &mut report.outcome;
    outcome.verdict = Verdict::LogAndMachineDisagree;
    outcome.effects.clear();
    outcome.fit.clear();
    outcome.candidates.clear();
    outcome.disagreement = ["position", "input", "current_a"]
        .map(|column| Disagreement {
            what: format!("{column} is in another unit"),
            evidence: "the torque that the motion takes is 57 times what the motor gives, and 1.0 times \
                       with the other unit, in each of the windows in which the machine clearly moves, \
                       forward as well as backward, fast as well as slow, and with and without the brake"
                .into(),
            remedy: format!("cargo hil import a.csv --{column} {column}:other --out b.csv"),
        })
        .to_vec();
    report
}

/// A report with every effect of the catalogue, names as long as a file system takes, numbers that are wrong,
/// errors that have all risen, logs that were resampled, and no validation.
fn crowded() -> Report {
    let mut report = example();
    let outcome = &mut report.outcome;
    outcome.machine = "gearmotor-with-a-very-long-name-".repeat(8);
    outcome.effects = Id::ALL
        .iter()
        .map(|id| {
            let description = id.description();
            let reported = description.reported.iter();
            FoundEffect {
                id: description.id.into(),
                parameters: reported
                    .map(|(name, _)| estimate(name, 0.5, 0.01, ""))
                    .collect(),
                declare: format!("{{ id = \"{}\" }}", description.id),
                equivalent: Id::ALL
                    .iter()
                    .map(|id| id.description().id.into())
                    .collect(),
                ..outcome.effects[0].clone()
            }
        })
        .collect();
    outcome.fit = (0..5)
        .map(|number| {
            fitted(
                &format!("a_number_that_is_wrong_{number}"),
                1.0,
                2.0,
                Some(0.1),
                "kg",
            )
        })
        .collect();
    for parameter in &mut outcome.fit {
        parameter.freed = true;
    }
    let stages = outcome.errors.validate.as_mut().unwrap();
    std::mem::swap(&mut stages.before, &mut stages.after);
    let stages = &mut outcome.errors.train;
    std::mem::swap(&mut stages.before, &mut stages.after);
    report.free_motor = free_motor(&["resistance", "torque_constant"]);
    let outcome = &mut report.outcome;
    outcome.machine_out = Some("refitted.toml".into());
    outcome.resampled = vec![
        Resampled {
            log: "a/directory/".repeat(20) + "log.csv",
            period_s: 1e-3,
            change: Resampling {
                rows: 1000,
                displacement_max: 0.4,
                displacement_rms: 0.2,
                filled: 5,
                merged: 0,
                position_error: 1e-6,
                position_step: None,
            },
        };
        3
    ];
    report
}

#[test]
fn every_verdict_says_all_of_it_in_twelve_lines() {
    let mut reports: Vec<(String, Report)> = variants()
        .into_iter()
        .map(|(name, report)| (name.to_owned(), report))
        .collect();
    reports.push(("disagreeing".to_owned(), disagreeing()));
    reports.push(("crowded".to_owned(), crowded()));
    for verdict in [
        Verdict::EffectsFound,
        Verdict::UnknownEffect,
        Verdict::NothingProven,
        Verdict::NoMissingEffect,
    ] {
        let mut report = crowded();
        report.outcome.verdict = verdict;
        report.outcome.unknown = variant("unknown").outcome.unknown;
        reports.push((format!("crowded, {}", verdict.name()), report));
        let mut report = crowded();
        report.outcome.verdict = verdict;
        report.outcome.errors.validate = None;
        reports.push((
            format!("crowded without validation, {}", verdict.name()),
            report,
        ));
    }
    let mut report = disagreeing();
    report.outcome.machine = crowded().outcome.machine;
    report.outcome.resampled = crowded().outcome.resampled;
    reports.push(("crowded, disagreeing".to_owned(), report));
    for (name, report) in reports {
        for text in brief(&report) {
            let lines: Vec<&str> = text.lines().collect();
            assert!(
                lines.len() <= LINES,
                "{name}: {} lines\n{text}",
                lines.len()
            );
            assert!(
                lines.iter().any(|line| line.starts_with("Next: ")),
                "{name}:\n{text}"
            );
            // What becomes of the error on unseen data is said however much else there is.
            let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
            let is_validated = report.outcome.errors.validate.is_some()
                && report.outcome.verdict != Verdict::LogAndMachineDisagree;
            let rose = "But on the validation log the position error rose from";
            let on_unseen =
                flat.contains("On the validation log") && flat.contains("the position error ");
            assert!(
                !is_validated || on_unseen || flat.contains(rose),
                "{name}:\n{text}"
            );
            // Sentences are shown whole, or not at all; but for the machine's name.
            let (_, said) = text.split_once(": ").unwrap();
            assert!(!said.contains('…'), "{name}:\n{text}");
            for line in lines {
                // What is to be copied is not broken.
                let copied = ["  declared_effects", "  parameters", "  cargo hil"]
                    .iter()
                    .any(|start| line.starts_with(start));
                assert!(copied || line.chars().count() <= WIDTH, "{name}: {line:?}");
            }
        }
    }
}

/// An effect that halves the error on data left out of the fit, and may be chance.
#[test]
fn what_may_be_chance_is_not_said_to_be_nothing() {
    let mut report = variant("no effect");
    assert!(words(&report).contains("no effect is missing. "));
    let mut nearest = example().outcome.candidates[0].clone();
    nearest.accepted = false;
    nearest.held_out_ratio = Some(0.4);
    report.outcome.candidates.push(nearest);
    let said = words(&report);
    assert!(
        said.contains("no effect is missing that the logs can prove. "),
        "{said}"
    );
    assert!(said.contains("record a longer log"), "{said}");
}

/// A validation log of another machine, which no one number explains.
#[test]
fn a_validation_log_that_the_model_does_not_follow_is_said() {
    let lost = "does not follow the validation data";
    let mut report = variant("no effect");
    assert!(!words(&report).contains(lost));
    let here = report.outcome.errors.train.after.position_rms;
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.position_rms = 100.0 * here;
    validate.after.free_run_rms = here;
    // A window that restarts wrongly is no error of the model.
    assert!(!words(&report).contains(lost));
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.free_run_rms = 200.0 * here;
    for verdict in [Verdict::NoMissingEffect, Verdict::NothingProven] {
        report.outcome.verdict = verdict;
        let said = words(&report);
        assert!(said.contains(lost), "{said}");
        assert!(said.contains("Next: see what was different"), "{said}");
    }
}

#[test]
fn what_finds_no_room_is_counted() {
    let report = crowded();
    let headline = Headline::of(&report);
    let text = words(&report);
    let shown = headline
        .details
        .iter()
        .filter(|(id, _)| text.contains(&format!("{id}: ")));
    let left_out = headline.details.len() - shown.count();
    assert!(left_out > 0);
    assert!(
        text.contains(&format!("and {left_out} more: ")),
        "{left_out}: {text}"
    );
    for (id, sentence) in &headline.details {
        let is_whole = text.contains(sentence.as_str());
        assert_eq!(text.contains(&format!("{id}: ")), is_whole, "{id}: {text}");
    }
    assert!(text.contains("24 effects were missing."), "{text}");
}

/// Along a stroke what else it could be is a force too.
#[test]
fn what_else_it_could_be_is_said_in_the_words_of_the_coordinate() {
    for (coordinate, words_of_it) in [
        ("m", "spring (a force prop"),
        ("rad", "spring (a torque prop"),
    ] {
        let mut report = example();
        report.coordinate = coordinate.into();
        report.outcome.effects.truncate(1);
        report.outcome.effects[0].equivalent = vec!["spring".into()];
        let certainty = Headline::of(&report).certainty;
        assert!(certainty.contains(words_of_it), "{certainty}");
    }
}

/// What is named is one of those that the logs cannot tell apart, and the first sentence says so.
#[test]
fn the_first_sentence_says_what_the_effect_may_be_instead() {
    let mut report = example();
    report.outcome.effects.truncate(1);
    let ids: Vec<String> = Id::ALL
        .iter()
        .map(|id| id.description().id.to_owned())
        .collect();
    for (equivalent, said) in [
        (&[][..], "one effect was missing, asymmetric_viscous."),
        (
            &ids[..1],
            "one effect was missing, either asymmetric_viscous or offset_torque: the logs cannot tell them apart.",
        ),
        (
            &ids[..],
            "one effect was missing, either asymmetric_viscous or one of 24 others: the logs cannot tell them apart.",
        ),
    ] {
        report.outcome.effects[0].equivalent = equivalent.to_vec();
        let finding = Headline::of(&report).finding;
        assert_eq!(finding, said.replace("offset_torque", &ids[0]));
    }
    // An offset torque is such a friction in every motion.
    let effect = &mut report.outcome.effects[0];
    effect.id = "offset_torque".into();
    effect.equivalent = vec!["asymmetric_coulomb".into()];
    let finding = Headline::of(&report).finding;
    assert!(
        finding.ends_with("asymmetric_coulomb: no log can tell them apart."),
        "{finding}"
    );
}

/// An answer whose one effect may be another one, with more to say than there is room for.
fn in_doubt() -> Report {
    let mut report = example();
    report.outcome.effects.truncate(1);
    let effect = &mut report.outcome.effects[0];
    effect.equivalent = vec!["offset_torque".into()];
    effect.presumes = ["resistance", "torque_constant"]
        .map(str::to_owned)
        .to_vec();
    report.declared = vec![DeclaredEffect {
        id: "load_dependent_friction".into(),
        parameters: [("share".to_owned(), 0.3)].into(),
        line: 1,
    }];
    report.outcome.next_experiment = Some(NextExperiment {
        equivalent: vec!["offset_torque".into()],
        near: vec!["cogging".into()],
        low_identifiability: Some(0.095),
        ..NextExperiment::open(
            vec!["asymmetric_viscous".into(), "offset_torque".into()],
            Bounds {
                input: 1.0,
                lowest_position: -1.0,
                highest_position: 1.0,
                speed: 1.0,
            },
        )
    });
    report
}

/// How sure it is comes before the line to copy, in whose place a file can be written.
#[test]
fn how_sure_it_is_stays_where_room_is_short() {
    let headline = Headline::of(&in_doubt());
    let all = format!("{} {}", headline.gain, headline.certainty);
    let [text, _] = brief(&in_doubt());
    let said = words(&in_doubt());
    assert!(!said.contains(&all), "there is room for all of it:\n{text}");
    assert!(said.contains("Chance alone would show this "), "{text}");
    assert!(!text.contains("  declared_effects"), "{text}");
    assert!(
        said.contains("Next: ")
            && said.contains("to keep it, run it again with --machine-out FILE"),
        "{text}"
    );
}

/// The words of a doubt are those of whoever stands beside the machine: no statistics, and sizes in degrees and per cent.
#[test]
fn a_doubt_is_said_in_plain_words() {
    let certainty = Headline::of(&in_doubt()).certainty;
    for part in [
        "The fitted numbers, set a little differently, do 90 % of what asymmetric_viscous does: take its size with care.",
        "It may also be cogging, not asymmetric_viscous: the logs cannot tell.",
    ] {
        assert!(certainty.contains(part), "no {part:?} in {certainty}");
    }
    let quantity = |name: &str, value: f64, unit: &str| Quantity {
        name: name.into(),
        value,
        unit: unit.into(),
    };
    let mut report = variant("no effect");
    let mut open = open_questions();
    open.absorbed = vec![
        Absorbed {
            id: "spring".into(),
            parameters: vec![
                quantity("stiffness", 8.4e-5, "N·m/rad"),
                quantity("rest", -344.0, "rad"),
            ],
        },
        Absorbed {
            id: "backlash".into(),
            parameters: vec![quantity("width", 0.01, "rad")],
        },
    ];
    report.outcome.next_experiment = Some(open);
    let certainty = Headline::of(&report).certainty;
    let part = "These logs would not show spring (1.5 µN·m a degree) or backlash (0.57°): other fitted numbers make up for it.";
    assert!(certainty.contains(part), "no {part:?} in {certainty}");
}

/// An error that has almost gone is said in a unit in which it has digits.
#[test]
fn an_error_that_has_almost_gone_keeps_its_digits() {
    let mut report = example();
    report.coordinate = "rad".into();
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    (validate.before.position_rms, validate.after.position_rms) = (1.17, 2.79e-4);
    let gain = Headline::of(&report).gain;
    let part = "the position error went from 1.17 rad to 0.279 mrad rms";
    assert!(gain.contains(part), "no {part:?} in {gain}");
}

/// A file with a list of effects takes the line as it is printed in place of its own.
#[test]
fn the_line_that_declares_an_effect_keeps_what_is_declared() {
    let mut report = example();
    report.outcome.effects.truncate(1);
    report.declared = vec![DeclaredEffect {
        id: "load_dependent_friction".into(),
        parameters: [("share".to_owned(), 0.3)].into(),
        line: 1,
    }];
    let headline = Headline::of(&report);
    let line = headline.next.iter().find_map(|step| match step {
        Step::Copy(line) => Some(line.as_str()),
        _ => None,
    });
    let line: toml::Table = line.unwrap().parse().unwrap();
    let effects = line["declared_effects"].as_array().unwrap();
    let ids: Vec<_> = effects
        .iter()
        .map(|effect| effect["id"].as_str().unwrap())
        .collect();
    assert_eq!(ids, ["load_dependent_friction", "asymmetric_viscous"]);
    assert_eq!(effects[0]["share"].as_float(), Some(0.3));
    // What no fit changes is said to be presumed.
    let presumed = "No fit changes what the machine file declares of load_dependent_friction;";
    assert!(
        headline.certainty.contains(presumed),
        "{}",
        headline.certainty
    );
    assert!(!Headline::of(&example()).certainty.contains("Presumed"));
}

/// No input brings back what acted once.
#[test]
fn a_load_that_acted_once_is_settled_by_the_same_motion_again() {
    let mut report = example();
    let advice = "record the same motion again and give it with another --train";
    let says = |report: &Report| {
        let mut steps = Headline::of(report).next.into_iter();
        steps.any(|step| matches!(step, Step::Do(words) if words.contains(advice)))
    };
    assert!(!says(&report));
    report.outcome.effects[0].equivalent = vec!["external_load".into()];
    assert!(says(&report));
    report.outcome.effects[0].equivalent.clear();
    report.outcome.effects[0].id = "external_load".into();
    assert!(says(&report));
}

/// Whatever else there is to say, up to three effects keep their sizes, and the answer the error on unseen data.
/// How many rows were missing is said while the effects have their sizes, if it is one in a hundred.
#[test]
fn many_filled_samples_are_told_however_much_else_there_is() {
    for (filled, told) in [(5, false), (400, true)] {
        let mut report = variant("usual");
        report.free_motor = free_motor(&["resistance", "torque_constant"]);
        report.outcome.next_experiment = Some(open_questions());
        let third = report.outcome.effects[0].clone();
        report.outcome.effects.push(third);
        report.outcome.resampled = vec![Resampled {
            log: "a.csv".into(),
            period_s: 1e-3,
            change: Resampling {
                rows: 1_600,
                filled,
                position_error: 2e-5,
                ..Resampling::default()
            },
        }];
        let sentence = format!(
            "{filled} of {} samples filled in, where rows are missing",
            1_600 + filled
        );
        let text = words(&report);
        assert_eq!(text.contains(&sentence), told, "{text}");
        assert!(
            text.contains("16.7 N forward and 24.2 N backward"),
            "{text}"
        );
    }
}

/// The sizes of effects follow the declared numbers of the motor where none is fitted.
#[test]
fn what_the_sizes_depend_on_is_told() {
    let mut report = example();
    let numbers = ["resistance", "torque_constant"];
    report.outcome.effects[0].presumes = numbers.map(str::to_owned).to_vec();
    let sizes =
        "If the declared resistance or torque constant is wrong, each size is wrong by as much";
    for (held_within, intervals) in [
        (vec![], "; the intervals do not include that."),
        (
            numbers.to_vec(),
            "; the intervals include their tolerances.",
        ),
    ] {
        report.held_within = held_within;
        let certainty = Headline::of(&report).certainty;
        let said = format!("{sizes}{intervals}");
        assert!(certainty.contains(&said), "{certainty}");
    }
}

#[test]
fn the_sizes_of_what_was_found_find_room() {
    for name in ["no validation", "usual"] {
        sizes_find_room(variant(name));
    }
}

fn sizes_find_room(mut report: Report) {
    report.free_motor = free_motor(&["resistance", "torque_constant"]);
    report.outcome.resampled = vec![Resampled {
        log: "a.csv".into(),
        period_s: 1e-3,
        change: Resampling::default(),
    }];
    let third = FoundEffect {
        id: "offset_torque".into(),
        parameters: vec![estimate("torque", 1.5, 0.1, "N")],
        ..report.outcome.effects[0].clone()
    };
    report.outcome.effects.push(third);
    let text = words(&report);
    let details = Headline::of(&report).details;
    assert_eq!(details.len(), 3);
    for (id, sentence) in details {
        assert!(text.contains(&sentence), "{id}: {text}");
    }
    let logs = match report.outcome.errors.validate {
        Some(_) => "On the validation log",
        None => "On the training log",
    };
    assert!(text.contains(logs), "{text}");
    assert!(text.contains("the position error went from "), "{text}");
}

#[test]
fn found_effects_are_said_with_size_gain_certainty_and_next_step() {
    let text = words(&example());
    for part in [
        "slide: 2 effects were missing, asymmetric_viscous (or offset_torque or spring: the logs cannot tell) and \
         sensor_delay.",
        // 0.1 m/s of 167.21 and 241.52 N·s/m.
        "asymmetric_viscous: Friction that grows with speed",
        "16.7 N forward and 24.2 N backward",
        "sensor_delay: The position is reported 0.504 ms",
        "On the validation log, which nothing was fitted to, the position error went from 308 µm to 106 µm \
         rms (-66 %), the unexplained force from 7.19 % to 3.68 % (-49 %)",
        // The larger of 1.04e-6 and 0.0042.
        "Chance alone would show sensor_delay, the least sure of them, once in 240 logs.",
        "Next: to keep all of that, run it again with --machine-out FILE.",
    ] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
    // One effect comes with the line that declares it, whole.
    let mut report = example();
    report.outcome.effects.truncate(1);
    let [text, _] = brief(&report);
    let line = "  declared_effects = [{ id = \"asymmetric_viscous\", difference = -37.155 }]";
    assert!(text.lines().any(|known| known == line), "{text}");
    // Where a file has it already, there is nothing to copy.
    report.outcome.machine_out = Some("refitted.toml".into());
    let [text, _] = brief(&report);
    assert!(
        words(&report).contains("use refitted.toml from now on"),
        "{text}"
    );
    assert!(!text.contains("declared_effects"), "{text}");
    // Nor where more is missing.
    let mut unexplained = report.clone();
    let residual = unexplained.outcome.residual.as_mut().unwrap();
    residual.position_rms = 10.0 * residual.floor;
    let text = words(&unexplained);
    assert!(text.contains("something more is missing"), "{text}");
    assert!(text.contains("for now use refitted.toml"), "{text}");
    assert!(!text.contains("from now on"), "{text}");
    // Before the last word on it that file is not the last one either.
    report.free_motor = free_motor(&["resistance", "torque_constant"]);
    let text = words(&report);
    assert!(text.contains("for now use refitted.toml"), "{text}");
    assert!(!text.contains("from now on"), "{text}");
}

/// A machine file holds formulas alone: where the model has a learned law, none is called what was found.
#[test]
fn a_machine_file_is_said_to_lack_a_learned_law() {
    let law = variant("unknown").outcome.unknown.unwrap().map;
    let mut report = example();
    report.outcome.effects.truncate(1);
    report.outcome.effects[0].law = Some(law);
    let text = words(&report);
    let it = "to keep the catalogue's formula for it, which is near to what the logs show, run it again with --machine-out FILE";
    assert!(text.contains(it), "{text}");
    assert!(!text.contains("declared_effects"), "{text}");
    for part in [
        "The formula does not follow it closely",
        "friction that depends on the velocity: it is -0.500 to 3.75 N where that is",
    ] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
    report.outcome.machine_out = Some("refitted.toml".into());
    let text = words(&report);
    let lacks = "refitted.toml was written with the formula of asymmetric_viscous that comes nearest, but not the learned law";
    assert!(text.contains(lacks), "{text}");
    assert!(!text.contains("with what was found"), "{text}");
}

/// A number that has gone as far as any factor lets it is not asked to be more unsure.
#[test]
fn no_factor_is_asked_for_that_would_change_nothing() {
    let mut report = variant("at limit");
    let mut numbers = report.outcome.fit.iter_mut();
    let viscous = numbers.find(|number| number.at_limit).unwrap();
    viscous.fitted = viscous.declared / 45.0;
    let text = words(&report);
    assert!(
        text.contains("do not show how large viscous friction is"),
        "{text}"
    );
    assert!(!text.contains("larger factor"), "{text}");
    assert!(!text.contains("is a guess"), "{text}");
    let mut numbers = report.outcome.fit.iter_mut();
    let viscous = numbers.find(|number| number.at_limit).unwrap();
    viscous.fitted = viscous.declared * 45.0;
    let text = words(&report);
    assert!(text.contains("is a guess, put "), "{text}");
    assert!(text.contains(" N·s/m there, and run it again"), "{text}");
}

/// What was found may not be all, or stand in for something else.
#[test]
fn an_effect_that_leaves_more_than_the_sensor_does_is_said_to() {
    let mut report = example();
    let leaves = "the model is still off by 10 times the sensor's noise";
    assert!(!words(&report).contains("still off by"));
    report.outcome.residual.as_mut().unwrap().position_rms = 1e-5;
    let text = words(&report);
    assert!(text.contains(leaves), "{text}");
}

/// What is declared is not fitted, and other effects or numbers make up for a share that a data sheet has too large.
#[test]
fn what_is_declared_may_be_what_is_wrong() {
    let advice = "if load_dependent_friction in `declared_effects` comes from a data sheet, leave it out there";
    for (name, advised) in [
        ("unknown", true),
        ("nothing proven", true),
        ("no effect", false),
        ("wrong number", true),
    ] {
        let mut report = variant(name);
        report.declared = vec![DeclaredEffect {
            id: "load_dependent_friction".into(),
            parameters: [("share".to_owned(), 0.25)].into(),
            line: 1,
        }];
        let text = words(&report);
        assert_eq!(text.contains(advice), advised, "{name}: {text}");
    }
}

#[test]
fn the_other_verdicts_say_what_they_are_and_what_to_do() {
    for (name, parts) in [
        (
            "no effect",
            &[
                "slide: no effect is missing.",
                "the position error of the fitted model is 308 µm rms, its unexplained force 7.19 %",
                "Next: nothing; the machine file and these logs belong together.",
            ][..],
        ),
        (
            "wrong number",
            &[
                "no effect is missing; the declared inductance is wrong.",
                "inductance: The machine file has 0.000120 H, the logs ask for 0.000132 H (+9.6 %).",
                "run it again with --machine-out FILE, or set `inductance = 0.00013156` in the machine file",
            ],
        ),
        (
            "unknown",
            &[
                "an effect is missing that the catalogue does not name; it depends on velocity.",
                "A friction that depends on the velocity: it is -0.500 to 3.75 N where that is 0 to 0.150 m/s",
                "Next: see the learned law with --report DIR; look for what changes with speed",
            ],
        ),
        (
            "nothing proven",
            &[
                "nothing is proven: the model is off by 4.0 times the sensor's noise",
                "Next: check that your logger writes the input (voltage, duty) at the moment it is set, not a row later",
                "record a longer log, slow and fast",
            ],
        ),
        (
            "implausible",
            &[
                "`viscous` had to go farther than the machine file lets it be off",
                "Next: if what the machine file says of viscous (",
                ") is a guess, put ",
                "which the logs ask for, and run it again",
            ],
        ),
        (
            "at limit",
            &[
                "The logs do not show how large viscous friction is: ",
                " N·s/m is only the limit that the fit was allowed to reach.",
                "Next: if what the machine file says of viscous (",
                ") is a guess, give viscous a larger factor than 3.0 in `unsure` of [fit]",
            ],
        ),
        (
            "no validation",
            &[
                "On the training log, to which the model was fitted, the position error went",
                "Next: record a second log, not for the fit, and give it with --validate",
            ],
        ),
    ] {
        let text = words(&variant(name));
        for part in parts {
            assert!(text.contains(part), "{name}: no {part:?} in {text}");
        }
    }
    // An inertia that is too large for a motor is what somebody has mounted; one that is too small is nobody's.
    let mut report = variant("implausible");
    let outcome = &mut report.outcome;
    outcome.residual.as_mut().unwrap().implausible = Some("inertia");
    let inertia = outcome
        .fit
        .iter_mut()
        .find(|number| number.name == "inertia");
    let inertia = inertia.unwrap();
    (inertia.declared, inertia.fitted) = (0.5, 12.0);
    let advice = "Next: if anything is mounted on the shaft, put its inertia into the machine file \
                  (`cargo hil machine` takes --load-inertia): it has 0.50 kg, the logs ask for 12 kg";
    assert!(words(&report).contains(advice), "{}", words(&report));
    let outcome = &mut report.outcome;
    let inertia = outcome
        .fit
        .iter_mut()
        .find(|number| number.name == "inertia");
    inertia.unwrap().fitted = 0.01;
    assert!(!words(&report).contains("mounted"), "{}", words(&report));
    let report = disagreeing();
    let [text, _] = brief(&report);
    for found in &report.outcome.disagreement {
        assert!(words(&report).contains(&found.what), "{text}");
        let line = format!("  {}", found.remedy);
        assert!(text.lines().any(|known| known == line), "{text}");
    }
    assert!(words(&report).contains("Evidence: the torque that the motion takes is 57 times"));
}

/// Two sets of logs on which an error rose are one sentence.
#[test]
fn errors_that_rose_on_both_sets_of_logs_are_one_sentence() {
    let mut report = example();
    let errors = &mut report.outcome.errors;
    for stages in [&mut errors.train, errors.validate.as_mut().unwrap()] {
        stages.after.free_run_rms = 2.0 * stages.before.free_run_rms;
    }
    let finding = Headline::of(&report).finding;
    assert_eq!(finding.matches("But").count(), 1, "{finding}");
    for part in [
        "But on the validation log the free run error rose",
        "; on the training log the free run error rose",
    ] {
        assert!(finding.contains(part), "no {part:?} in {finding}");
    }
    // Which of the sets it does not hold on is named.
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.position_rms = 2.0 * validate.before.position_rms;
    let finding = Headline::of(&report).finding;
    let fails = "What was found does not hold on the validation log.";
    assert!(finding.contains(fails), "{finding}");
}

/// What predicts a window better and a long run worse is for windows alone.
#[test]
fn what_errs_more_in_the_long_run_is_not_for_it() {
    let mut report = example();
    report.outcome.machine_out = Some("refitted.toml".into());
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.free_run_rms = 2.87 * validate.before.free_run_rms;
    let text = words(&report);
    let window = validate_window(&report);
    for part in [
        "Next: do not rely on it for long runs without restarts, whose error rose; for these record a longer log",
        &format!(
            "for now use refitted.toml, the machine file with what was found, for predictions of {window} or so."
        ),
    ] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
    assert!(!text.contains("from now on"), "{text}");
    // More unexplained torque is worse altogether.
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.torque_rel = 2.0 * validate.before.torque_rel;
    let text = words(&report);
    assert!(text.contains("Next: do not rely on it yet"), "{text}");
    assert!(!text.contains("from now on"), "{text}");
}

/// Length of the windows that the example is judged over, in words.
fn validate_window(report: &Report) -> String {
    let seconds = report.outcome.errors.train.after.window_s;
    format!("{} ms", 1e3 * seconds)
}

/// Whatever else there is to say, and however much was found, a file that was written is said to be.
#[test]
fn a_machine_file_that_was_written_is_named() {
    // A number at its limit, which another step is about.
    let mut at_limit = example();
    at_limit.outcome.fit = variant("at limit").outcome.fit;
    assert!(words(&at_limit).contains("larger factor"));
    // What may change with that is not the last word.
    at_limit.outcome.machine_out = Some("refitted.toml".into());
    let text = words(&at_limit);
    assert!(text.contains("for now use refitted.toml"), "{text}");
    let mut reports = vec![crowded(), variant("unknown"), at_limit];
    let mut unknown = crowded();
    unknown.outcome.verdict = Verdict::UnknownEffect;
    unknown.outcome.unknown = variant("unknown").outcome.unknown;
    reports.push(unknown);
    for mut report in reports {
        report.outcome.machine_out = Some("refitted.toml".into());
        for text in brief(&report) {
            assert!(text.contains("refitted.toml"), "{text}");
            assert!(text.lines().count() <= LINES, "{text}");
        }
    }
}

/// Each error by itself, on each set of logs.
#[test]
fn an_error_that_has_risen_is_said_in_the_headline() {
    type Raise = fn(&mut host_tests::gap::outcome::Stages);
    let raises: [(&str, Raise); 3] = [
        ("the position error rose from", |stages| {
            stages.after.position_rms = 1.02 * stages.before.position_rms;
        }),
        ("the unexplained force rose from", |stages| {
            stages.after.torque_rel = 1.5 * stages.before.torque_rel;
        }),
        ("the free run error rose from", |stages| {
            stages.after.free_run_rms = f64::INFINITY;
        }),
    ];
    for (said, raise) in raises {
        let mut report = example();
        assert!(!Headline::of(&report).finding.contains("rose"));
        raise(report.outcome.errors.validate.as_mut().unwrap());
        let finding = Headline::of(&report).finding;
        assert!(
            finding.contains(&format!("But on the validation log {said}")),
            "{finding}"
        );
        assert_eq!(
            finding.contains("does not hold there"),
            said.contains("position"),
            "{finding}"
        );
        assert!(words(&report).contains(said));

        let mut report = example();
        raise(&mut report.outcome.errors.train);
        let finding = Headline::of(&report).finding;
        assert!(
            finding.contains(&format!("But on the training log {said}")),
            "{finding}"
        );

        report.outcome.errors.validate = None;
        let finding = Headline::of(&report).finding;
        assert_eq!(finding.matches(said).count(), 1, "{finding}");
    }
    // As much worse as a rounding is no rise.
    let mut report = example();
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.free_run_rms = 1.005 * validate.before.free_run_rms;
    assert!(!Headline::of(&report).finding.contains("rose"));
    // A model that was not changed has none either.
    let mut report = variant("no effect");
    let train = &mut report.outcome.errors.train;
    train.after.free_run_rms = 2.0 * train.before.free_run_rms;
    assert!(!Headline::of(&report).finding.contains("rose"));
}

/// More effects that the logs would not show than the answer has room for.
fn open_questions() -> NextExperiment {
    let ids = ["spring", "gravity", "cogging", "stribeck", "backlash"].map(str::to_owned);
    let quantity = Quantity {
        name: "a number with a long name".into(),
        value: 1.0,
        unit: "N·m".into(),
    };
    let absorbed = |id: &String| Absorbed {
        id: id.clone(),
        parameters: vec![quantity.clone(); 3],
    };
    let limits = Bounds {
        input: 1.0,
        lowest_position: -1.0,
        highest_position: 1.0,
        speed: 1.0,
    };
    NextExperiment {
        absorbed: ids.iter().map(absorbed).collect(),
        ..NextExperiment::open(vec!["no effect".into()], limits)
    }
}

/// Resistance and torque constant that a data sheet is wrong about look like an effect, or like nothing that can be
/// proven.
#[test]
fn fixed_numbers_of_the_motor_are_to_be_freed_where_they_may_be_what_is_wrong() {
    let is_advised = |mut report: Report| {
        report.free_motor = free_motor(&["resistance", "torque_constant"]);
        let [text, _] = brief(&report);
        let advice = "if resistance and torque constant come from a data sheet, put `parameters` below into [fit]";
        let advised = words(&report).contains(advice);
        let copied = text.lines().any(|line| line == format!("  {FREE_MOTOR}"));
        assert_eq!(advised, copied, "{text}");
        assert_eq!(report::page(&report).unwrap().contains(advice), advised);
        advised
    };
    for (name, expected) in [
        ("usual", true),
        ("unknown", true),
        ("nothing proven", true),
        ("no effect", false),
        // Freed by the tracing itself, which says by how much it is wrong.
        ("wrong number", false),
    ] {
        assert_eq!(is_advised(variant(name)), expected, "{name}");
    }
    // Nothing proven to be missing, but the motor's numbers would follow the logs better.
    let mut report = variant("no effect");
    let mut numbers = example().outcome.candidates[1].clone();
    numbers.id = "numbers".into();
    numbers.held_out_ratio = Some(0.08);
    report.outcome.candidates.push(numbers);
    let nearest = "helps most: the error on data left out of the fit is 92 % smaller with it, but ";
    assert!(words(&report).contains(nearest), "{}", words(&report));
    assert!(is_advised(report.clone()));
    // It stays where there is no room for all that the logs leave open.
    report.outcome.next_experiment = Some(open_questions());
    assert!(words(&report).contains(nearest), "{}", words(&report));
    // Where the tracing freed one of them, what it found beside that may still stand for the other.
    for (freed, expected) in [(1, true), (2, false)] {
        let mut report = example();
        let fit = &mut report.outcome.fit;
        for (parameter, name) in fit
            .iter_mut()
            .zip(["resistance", "torque_constant"])
            .take(freed)
        {
            parameter.name = name.into();
            parameter.freed = true;
        }
        assert_eq!(is_advised(report), expected, "{freed}");
    }
    // What is fitted already is not asked for.
    let mut report = example();
    report.free_motor = free_motor(&["resistance"]);
    let advice = "if resistance comes from a data sheet, put `parameters` below into [fit]";
    assert!(words(&report).contains(advice), "{}", words(&report));
    // Nothing to free.
    assert!(!words(&example()).contains("data sheet"));
}

#[test]
fn what_does_not_hold_is_not_to_be_relied_on() {
    let mut report = variant("does not hold");
    report.outcome.machine_out = Some("refitted.toml".into());
    let next = Headline::of(&report).next;
    assert!(
        matches!(&next[0], Step::Do(words) if words.starts_with("do not rely on it yet")),
        "{next:?}"
    );
    let text = words(&report);
    assert!(!text.contains("from now on"), "{text}");
    assert!(
        text.contains(
            "until then use refitted.toml, the machine file with what was found, for trials only"
        ),
        "{text}"
    );
}

/// A motor whose numbers are as far off as its data sheet allows is a good motor, also where a second log is followed
/// less well by less than a count.
#[test]
fn what_is_within_the_tolerance_is_not_called_wrong() {
    let mut report = variant("wrong number");
    let outcome = &mut report.outcome;
    outcome.machine_out = Some("refitted.toml".into());
    let number = outcome.fit.iter_mut().find(|number| number.freed).unwrap();
    number.tolerance = Some(0.1);
    let validate = outcome.errors.validate.as_mut().unwrap();
    validate.after.position_rms = 1.044 * validate.before.position_rms;
    validate.after.free_run_rms = 0.9 * validate.before.free_run_rms;
    let rise = 0.3 * validate.before.position_rms;
    outcome.residual.as_mut().unwrap().floor = 1.1 * rise;
    let text = words(&report);
    for part in [
        "no effect is missing; inductance differs from the declared value, within its tolerance.",
        "The machine file has 0.000120 H ±10 %, the logs ask for 0.000132 H (+9.6 %).",
        "(+4.4 %, less than the sensor can tell)",
        "Next: use refitted.toml from now on",
    ] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
    for part in ["wrong", "rose", "does not hold", "do not rely"] {
        assert!(!text.contains(part), "{part:?} in {text}");
    }
    // More than the sensor's count is a rise.
    report.outcome.residual.as_mut().unwrap().floor = 0.9 * rise;
    let text = words(&report);
    assert!(
        text.contains("What was found does not hold there."),
        "{text}"
    );
}

#[test]
fn the_page_begins_with_the_same_words() {
    for report in [
        example(),
        variant("unknown"),
        variant("nothing proven"),
        disagreeing(),
    ] {
        let page = report::page(&report).unwrap();
        assert!(!page.contains("--report DIR"), "the page refers to itself");
        let headline = Headline::on_page(&report);
        let header = page.split("</header>").next().unwrap();
        let document = roxmltree::Document::parse_with_options(
            &page,
            roxmltree::ParsingOptions {
                allow_dtd: true,
                ..Default::default()
            },
        )
        .unwrap();
        assert!(header.contains("Next:"));
        let shown = document
            .descendants()
            .find(|node| node.has_tag_name("header"))
            .unwrap();
        let texts: String = shown
            .descendants()
            .filter_map(|node| node.text())
            .collect::<Vec<_>>()
            .join(" ");
        let said = [&headline.finding, &headline.gain, &headline.certainty];
        let sentences = headline.details.iter().map(|(_, sentence)| sentence);
        for words in said.into_iter().chain(sentences) {
            // The first letter is made a capital.
            let rest: String = words.chars().skip(1).collect();
            assert!(texts.contains(&rest), "no {rest:?} in {texts}");
        }
        for step in &headline.next {
            let words = step.text();
            assert!(texts.contains(&*words), "no {words:?} in {texts}");
        }
    }
}

#[test]
fn a_demand_without_numbers_prints_no_nonsense() {
    let mut report = example();
    report.demand = Demand::default();
    let text = words(&report);
    assert!(text.contains("at 1000 mm/s it is 167 N forward"), "{text}");
}

/// A load that hangs and a cogging of once a turn are one law: a changed machine tells, and no input.
#[test]
fn what_no_input_settles_asks_for_another_machine() {
    let mut report = example();
    let outcome = &mut report.outcome;
    outcome.effects.truncate(1);
    let effect = &mut outcome.effects[0];
    effect.id = "gravity".into();
    effect.equivalent = vec!["cogging".into()];
    let limits = open_questions().limits;
    let open = |candidates: &[&str]| NextExperiment {
        equivalent: vec!["cogging".into()],
        ..NextExperiment::open(candidates.iter().map(|&it| it.into()).collect(), limits)
    };
    // Of another period an input may tell.
    outcome.next_experiment = Some(open(&["gravity", "cogging"]));
    let text = words(&report);
    assert!(text.contains("the logs cannot tell them apart"), "{text}");
    assert!(
        text.contains("--experiment FILE") && !text.contains("turn the machine"),
        "{text}"
    );
    report.outcome.next_experiment = Some(NextExperiment {
        same_law: vec!["cogging".into()],
        ..open(&["gravity"])
    });
    let text = words(&report);
    assert!(text.contains("no log can tell them apart"), "{text}");
    assert!(
        text.contains("turn the machine") && !text.contains("--experiment FILE"),
        "{text}"
    );
}

/// Where nothing was found in short logs, how long one has to be is said, and to record it comes first.
#[test]
fn short_logs_are_said_to_be_short() {
    for name in ["no effect", "nothing proven"] {
        let mut report = variant(name);
        let residual = report.outcome.residual.as_mut().unwrap();
        residual.short = Some(ShortLogs {
            duration_s: 0.6,
            windows: 24,
            window_s: 0.022,
            usual_s: 0.2,
            least_s: 4.833,
        });
        let text = words(&report);
        for said in [
            "24 predictions of 22.0 ms",
            "A log of 4.90 s",
            "record a log of 4.90 s or more",
        ] {
            assert!(text.contains(said), "{name}: no {said:?} in {text}");
        }
    }
}
