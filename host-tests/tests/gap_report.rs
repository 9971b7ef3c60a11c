//! What `cargo hil gap` shows: every number of the outcome, readable in a pipe and as one page
//! that stands alone.

use host_tests::gap::outcome::{
    Candidate, Correlations, Cost, ErrorSet, Errors, Estimate, Evidence, FittedParameter,
    FoundEffect, Outcome, Report, Residual, Stages, Unknown, UnknownMap, Whiteness,
};
use host_tests::gap::{report, table};
use model_core::gap::verdict::Verdict;

/// A slide driven by a force, 1 kHz: its viscous friction differs with the direction, which the
/// model before effects does not know. Windows of 0.2 s; the torque residual is decimated by 10.
fn slide(label: &str, samples: usize) -> Evidence {
    const STEP: f64 = 1e-3;
    const MASS: f64 = 95.0;
    let friction = |forward: f64, backward: f64, velocity: f64| {
        let viscous = if velocity > 0.0 { forward } else { backward };
        viscous * velocity + 20.2 * (velocity / 1e-3).tanh()
    };
    let truth = |velocity| friction(166.0, 243.0, velocity);
    let before = |velocity| friction(203.5, 203.5, velocity);
    let after = |velocity| friction(167.2, 241.5, velocity);
    let mut seed = 1_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) as f64 / 2f64.powi(31) - 0.5
    };

    let mut log = Evidence {
        label: label.into(),
        ..Evidence::default()
    };
    // (position, velocity) of the slide, of the model before effects and of that after.
    let mut states = [(0.0_f64, 0.0_f64); 3];
    for sample in 0..samples {
        let time = sample as f64 * STEP;
        let force = 55.0 * (1.9 * time).sin() + 12.0 * (7.3 * time).sin();
        if sample % 200 == 0 {
            log.window_starts.push(sample);
            states = [states[0]; 3];
        }
        let (position, velocity) = states[0];
        log.time.push(time as f32);
        log.position.push((position + 4e-6 * noise()) as f32);
        log.velocity.push(velocity as f32);
        log.input.push((force / 35.15) as f32);
        log.current.push((force / 35.15) as f32);
        log.before.push(states[1].0 as f32);
        log.after.push(states[2].0 as f32);
        if sample % 10 == 0 {
            let torque_noise = 1.6 * noise();
            log.torque_time.push(time as f32);
            log.torque_velocity.push(velocity as f32);
            log.torque_position.push(position as f32);
            log.torque_before
                .push((before(velocity) - truth(velocity) + torque_noise) as f32);
            log.torque_after
                .push((after(velocity) - truth(velocity) + torque_noise) as f32);
        }
        let laws: [&dyn Fn(f64) -> f64; 3] = [&truth, &before, &after];
        for (state, law) in states.iter_mut().zip(laws) {
            state.1 += STEP * (force - law(state.1)) / MASS;
            state.0 += STEP * state.1;
        }
    }
    log
}

fn errors(position_rms: f64, torque_rel: f64) -> ErrorSet {
    ErrorSet {
        window_s: 0.2,
        position_rms,
        position_max: 4.0 * position_rms,
        position_nrmse: 5.0 * position_rms,
        current_rms: Some(0.01 * torque_rel),
        torque_rel,
        free_run_rms: 25.0 * position_rms,
    }
}

fn estimate(name: &str, value: f64, std: f64, unit: &str) -> Estimate {
    Estimate {
        name: name.into(),
        value,
        std,
        unit: unit.into(),
    }
}

fn fitted(name: &str, declared: f64, value: f64, std: Option<f64>, unit: &str) -> FittedParameter {
    FittedParameter {
        name: name.into(),
        declared,
        fitted: value,
        std,
        unit: unit.into(),
        freed: false,
    }
}

fn refused(round: usize, id: &str, score: f64, reason: &str) -> Candidate {
    Candidate {
        round,
        id: id.into(),
        score,
        identifiability: 0.347,
        held_out_ratio: None,
        p_value: None,
        accepted: false,
        reason: reason.into(),
    }
}

/// Two effects found on one training and one validation log.
fn example() -> Report {
    let outcome = Outcome {
        machine: "slide".into(),
        verdict: Verdict::EffectsFound,
        disagreement: Vec::new(),
        residual: Some(Residual {
            position_rms: 4e-6,
            floor: 1e-6,
            implausible: None,
        }),
        effects: vec![
            FoundEffect {
                id: "asymmetric_viscous".into(),
                parameters: vec![
                    estimate("forward", 167.21, 1.13, "N·s/m"),
                    estimate("backward", 241.52, 1.28, "N·s/m"),
                ],
                declare: "{ id = \"asymmetric_viscous\", difference = -37.155 }".into(),
                score: 0.8712,
                identifiability: 0.6134,
                p_value: 1.04e-6,
                equivalent: vec!["offset_torque".into(), "spring".into()],
                presumes: vec![],
            },
            FoundEffect {
                id: "sensor_delay".into(),
                parameters: vec![estimate("delay", 5.04e-4, 2.1e-5, "s")],
                declare: "{ id = \"sensor_delay\", delay = 0.000504 }".into(),
                score: 0.2218,
                identifiability: 0.4821,
                p_value: 0.0042,
                equivalent: vec![],
                presumes: vec!["resistance".into(), "torque_constant".into()],
            },
        ],
        unknown: None,
        fit: vec![
            fitted("inertia", 90.0, 95.204, Some(0.118), "kg"),
            fitted("viscous", 203.5, 204.36, None, "N·s/m"),
            fitted("coulomb", 20.4, 20.21, Some(0.134), "N"),
            fitted("inductance", 1.2e-4, 1.3156e-4, Some(2.4e-6), "H"),
        ],
        errors: Errors {
            train: Stages {
                declared: errors(3.412e-4, 0.0812),
                before: errors(2.908e-4, 0.0707),
                after: errors(5.21e-5, 0.0295),
            },
            validate: Some(Stages {
                declared: errors(3.601e-4, 0.0834),
                before: errors(3.079e-4, 0.0719),
                after: errors(1.062e-4, 0.0368),
            }),
        },
        next_experiment: None,
        candidates: vec![
            Candidate {
                held_out_ratio: Some(0.153),
                p_value: Some(1.04e-6),
                accepted: true,
                ..refused(
                    1,
                    "asymmetric_viscous",
                    0.8712,
                    "mean square error 85 % lower on held-out blocks",
                )
            },
            Candidate {
                held_out_ratio: Some(0.942),
                p_value: Some(0.0213),
                ..refused(
                    1,
                    "quadratic_drag",
                    0.1934,
                    "held-out error only 5.8 % lower where 10 % is asked for, and p 0.021 where 0.0013 \
                     is, so what it gains on the blocks that it was fitted to does not carry over",
                )
            },
            refused(1, "stribeck", 0.1203, "not among the best three by score"),
            refused(1, "cogging", 0.0416, "not among the best three by score"),
            refused(1, "compliance", 0.0305, "not among the best three by score"),
            refused(1, "presliding", 0.0304, "not among the best three by score"),
            refused(1, "spring", 0.0203, "identifiability under 0.05"),
            refused(1, "gravity", 0.0102, "needs a rotary machine"),
            Candidate {
                held_out_ratio: Some(0.871),
                p_value: Some(0.0042),
                accepted: true,
                ..refused(2, "sensor_delay", 0.2218, "mean square error 13 % lower")
            },
        ],
        resampled: vec![],
        whiteness: Whiteness {
            ljung_box: 152.34,
            lags: 20,
            p_value: 0.0,
            correlations: Correlations {
                input: 0.12,
                velocity: -0.34,
                direction: 0.56,
                input_squared: -0.78,
            },
        },
        cost: Cost {
            seconds: 12.34,
            simulations: 1240,
            samples: 12_000,
        },
    };
    Report {
        outcome,
        coordinate: "m".into(),
        load_unit: "N".into(),
        train: vec![slide("train.csv", 12_000)],
        validate: vec![slide("validate.csv", 9_000)],
    }
}

/// The reports that a user may meet beside the usual one.
fn variants() -> Vec<(&'static str, Report)> {
    let mut variants = vec![("usual", example())];

    let mut report = example();
    report.outcome.verdict = Verdict::NoMissingEffect;
    report.outcome.effects.clear();
    report.outcome.candidates.clear();
    report.outcome.errors.train.after = errors(2.908e-4, 0.0707);
    report.outcome.errors.validate.as_mut().unwrap().after = errors(3.079e-4, 0.0719);
    variants.push(("no effect", report));

    let mut report = example();
    report.outcome.verdict = Verdict::NoMissingEffect;
    report.outcome.effects.clear();
    report.outcome.fit[3].freed = true;
    variants.push(("wrong number", report));

    let mut report = example();
    report.outcome.verdict = Verdict::UnknownEffect;
    report.outcome.effects.clear();
    report.outcome.unknown = Some(Unknown {
        depends_on: "velocity".into(),
        score: 0.4063,
        map: UnknownMap {
            acts_as: "friction".into(),
            over: "velocity".into(),
            at: vec![0.0, 0.05, 0.1, 0.15],
            at_unit: "m/s".into(),
            values: vec![1.25, -0.5, 0.0, 3.75],
            unit: "N".into(),
        },
    });
    variants.push(("unknown", report.clone()));

    let mut nothing_proven = report.clone();
    nothing_proven.outcome.verdict = Verdict::NothingProven;
    nothing_proven.outcome.unknown = None;
    variants.push(("nothing proven", nothing_proven.clone()));

    let residual = nothing_proven.outcome.residual.as_mut().unwrap();
    residual.implausible = Some("viscous");
    variants.push(("implausible", nothing_proven));

    report.outcome.effects = example().outcome.effects;
    variants.push(("effects and unknown", report));

    let mut report = example();
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.position_rms = 1.5 * validate.before.position_rms;
    variants.push(("does not hold", report));

    let mut report = example();
    report.outcome.errors.validate = None;
    report.validate.clear();
    variants.push(("no validation", report));

    let mut report = example();
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    for stages in [&mut report.outcome.errors.train, validate] {
        for set in [&mut stages.declared, &mut stages.before, &mut stages.after] {
            set.current_rms = None;
        }
    }
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.current.clear();
    }
    variants.push(("no current", report));

    for samples in [0, 1, 3, 9, 120] {
        let mut report = example();
        report.train = vec![slide("tiny.csv", samples)];
        report.validate = vec![slide("tiny.csv", samples)];
        variants.push(("tiny", report));
    }

    let mut report = example();
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.window_starts.clear();
    }
    variants.push(("no windows", report));

    let mut report = example();
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.position.fill(0.25);
        log.before.fill(0.25);
        log.after.fill(0.25);
        log.torque_before.fill(0.0);
        log.torque_after.fill(0.0);
        log.torque_velocity.fill(0.0);
    }
    variants.push(("standstill", report));

    let mut report = example();
    report.outcome.errors.train.declared.free_run_rms = f64::INFINITY;
    report.outcome.effects[0].parameters[0].std = f64::NAN;
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.before[500..600].fill(f32::NAN);
        log.torque_before[50] = f32::INFINITY;
    }
    variants.push(("diverged", report));

    let mut report = example();
    report.train.push(slide("train-2.csv", 4_000));
    report.train.push(slide("train-3.csv", 2_000));
    variants.push(("more logs", report));
    variants
}

fn page(report: &Report) -> String {
    report::page(report).unwrap()
}

fn parsed(page: &str) -> roxmltree::Document<'_> {
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(page, options).unwrap()
}

/// Lines as the fields between runs of spaces, so that a test names numbers and not columns.
fn fields(line: &str) -> String {
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn assert_lines(text: &str, expected: &[&str]) {
    let lines: Vec<String> = text.lines().map(fields).collect();
    for line in expected {
        assert!(
            lines.iter().any(|l| l == line),
            "no line {line:?} in\n{text}"
        );
    }
}

#[test]
fn the_table_gives_every_error_in_one_unit_a_row() {
    let text = table::render(&example(), false);
    assert_lines(
        &text,
        &[
            "position rms µm 341 291 52.1 0.179 360 308 106 0.345",
            "position max mm 1.36 1.16 0.208 0.179 1.44 1.23 0.425 0.345",
            "position NRMSE % 0.171 0.145 0.0261 0.179 0.180 0.154 0.0531 0.345",
            "current rms µA 812 707 295 0.417 834 719 368 0.512",
            "torque residual % 8.12 7.07 2.95 0.417 8.34 7.19 3.68 0.512",
            "free run rms mm 8.53 7.27 1.30 0.179 9.00 7.70 2.66 0.345",
        ],
    );
}

#[test]
fn the_table_leads_with_the_verdict_on_unseen_data() {
    let text = table::render(&example(), false);
    let opening = text.lines().take(3).collect::<Vec<_>>().join(" ");
    assert_eq!(
        opening,
        "slide: 2 effects were missing, asymmetric_viscous and sensor_delay. On the validation log \
         the windowed position error fell from 308 µm to 106 µm rms (-66 %), the torque residual \
         fell from 7.19 % to 3.68 % (-49 %)."
    );
}

#[test]
fn a_wrong_number_is_said_first_and_marked() {
    let (_, report) = variants()
        .into_iter()
        .find(|(name, _)| *name == "wrong number")
        .unwrap();
    let text = table::render(&report, false);
    let opening = text.lines().take(2).collect::<Vec<_>>().join(" ");
    assert!(
        opening.starts_with(
            "slide: no effect is missing, but the declared inductance is wrong. On the validation \
             log the windowed position error fell from 308 µm to 106 µm rms"
        ),
        "{opening}"
    );
    let marked = "not in [fit], and wrong: no effect follows the log better than this value";
    assert_lines(&text, &[marked]);
    assert!(page(&report).contains(marked));
}

#[test]
fn the_table_gives_effects_and_parameters_with_deviation_and_unit() {
    let text = table::render(&example(), false);
    assert_lines(
        &text,
        &[
            "asymmetric_viscous score 0.871 identifiability 0.613 p 1.0e-6",
            "forward 167.2 ± 1.1 N·s/m",
            "backward 241.5 ± 1.3 N·s/m",
            "this log cannot tell it from: offset_torque, spring",
            "A wrong resistance or torque_constant explains less; the values presume the declared ones",
            "to declare it { id = \"asymmetric_viscous\", difference = -37.155 }",
            "sensor_delay score 0.222 identifiability 0.482 p 0.0042",
            "delay 504 ± 21 µs",
            "inertia 90 → 95.20 ± 0.12 kg +5.8 %",
            "viscous 203.5 → 204.36 N·s/m (taken over by an effect) +0.4 %",
            "coulomb 20.4 → 20.21 ± 0.13 N -0.9 %",
            "inductance 0.00012 → (1.316 ± 0.024)e-4 H +9.6 %",
        ],
    );
}

#[test]
fn the_table_says_who_was_refused_and_why() {
    let text = table::render(&example(), false);
    assert_lines(
        &text,
        &[
            "asymmetric_viscous 0.871 0.347 0.153 1.0e-6",
            "taken: mean square error 85 % lower on held-out blocks",
            "quadratic_drag 0.193 0.347 0.942 0.021",
            "stribeck 0.120 0.347 – –",
            "refused: not among the best three by score",
            "and 3 more, none with a score above 0.0304",
            "Cost: 12.3 s, 1240 simulations of the training data (12000 samples).",
        ],
    );
    assert!(fields(&text).contains(
        "refused: held-out error only 5.8 % lower where 10 % is asked for, and p 0.021 where \
         0.0013 is, so what it gains on the blocks that it was fitted to does not carry over"
    ));
    assert!(fields(&text).contains("Ljung–Box 152 per degree of freedom over 20 lags"));
}

#[test]
fn the_table_fits_a_terminal_and_a_pipe() {
    for (name, report) in variants() {
        let plain = table::render(&report, false);
        for line in plain.lines() {
            assert!(line.chars().count() <= table::WIDTH, "{name}: {line:?}");
        }
        assert!(!plain.contains('\x1b'));
        let coloured = table::render(&report, true);
        let stripped = coloured
            .split('\x1b')
            .enumerate()
            .map(|(i, part)| {
                if i == 0 {
                    part
                } else {
                    part.split_once('m').unwrap().1
                }
            })
            .collect::<String>();
        assert!(coloured.contains('\x1b'));
        assert_eq!(stripped, plain, "{name}");
    }
}

#[test]
fn the_verdicts_are_told_apart() {
    for (name, expected) in [
        (
            "no effect",
            vec!["slide: no effect is missing.", "nothing that was tried"],
        ),
        (
            "unknown",
            vec![
                "slide: an effect is missing that the catalogue does not name; it depends on velocity.",
                "depends on velocity: a friction learned over it explains 40.6 % of the residual",
                "velocity, m/s 0 0.0500 0.100 0.150",
                "friction, N 1.25 -0.500 0 3.75",
            ],
        ),
        (
            "nothing proven",
            vec![
                "slide: nothing is proven: the position error is 4.0 times what the sensor and the \
                 restarts leave, and nothing that was tried predicts the rest of it.",
            ],
        ),
        (
            "implausible",
            vec![
                "slide: nothing is proven: to follow the logs, `viscous` had to go where no data sheet \
                 would let it",
            ],
        ),
        (
            "does not hold",
            vec!["error rose from", "What was found does not hold there."],
        ),
        (
            "effects and unknown",
            vec![
                "asymmetric_viscous and sensor_delay. A further effect is missing that the catalogue",
            ],
        ),
        (
            "no validation",
            vec!["On the training log", "unseen data is not known"],
        ),
        ("diverged", vec!["diverged", "167.2 ± not determined N·s/m"]),
    ] {
        let (_, report) = variants().into_iter().find(|(n, _)| *n == name).unwrap();
        let text = fields(&table::render(&report, false));
        for part in expected {
            assert!(text.contains(part), "{name}: no {part:?} in {text}");
        }
    }
    let (_, report) = variants()
        .into_iter()
        .find(|(n, _)| *n == "no current")
        .unwrap();
    assert!(!table::render(&report, false).contains("current rms"));
}

#[test]
fn the_page_is_well_formed_and_stands_alone() {
    for (name, report) in variants() {
        let page = page(&report);
        let document = parsed(&page);
        for node in document.descendants() {
            let tag = node.tag_name().name();
            assert!(
                !["script", "link", "img", "iframe", "object"].contains(&tag),
                "{name}: {tag}"
            );
            for attribute in node.attributes() {
                assert!(
                    !["src", "href", "srcset", "data"].contains(&attribute.name()),
                    "{name}: {attribute:?}"
                );
                assert!(!attribute.value().contains("NaN"), "{name}: {attribute:?}");
            }
        }
        for outside in ["http:", "https:", "url(", "@import", "@font-face"] {
            assert!(!page.contains(outside), "{name}: {outside}");
        }
        assert!(page.len() < 2_000_000, "{name}: {} bytes", page.len());
        for effect in &report.outcome.effects {
            assert!(page.contains(&effect.id), "{name}: {}", effect.id);
        }
    }
}

#[test]
fn the_page_draws_both_logs_and_says_so_where_it_cannot() {
    let drawings = |report: &Report| {
        let page = page(report);
        let count = parsed(&page)
            .descendants()
            .filter(|n| n.has_tag_name("svg"))
            .count();
        (count, page.contains("too short to draw"))
    };
    // Whole log, excerpt, clouds, autocorrelation, histograms; for each of two logs.
    assert_eq!(drawings(&example()), (10, false));
    for (name, expected) in [
        ("no validation", (5, false)),
        ("no windows", (10, false)),
        // A constant residual has no autocorrelation.
        ("standstill", (8, false)),
    ] {
        let (_, report) = variants().into_iter().find(|(n, _)| *n == name).unwrap();
        assert_eq!(drawings(&report), expected, "{name}");
    }
    let mut report = example();
    report.validate = vec![slide("tiny.csv", 3)];
    assert_eq!(drawings(&report), (5, true));
}

#[test]
fn the_page_holds_the_numbers_of_the_table() {
    let page = page(&example());
    for number in [
        "167.2 ± 1.1 N·s/m",
        "504 ± 21 µs",
        "95.20 ± 0.12 kg",
        "2 effects were missing, asymmetric_viscous and sensor_delay.",
        "offset_torque, spring",
        "held-out error only 5.8 % lower",
        "12.3 s, 1240 simulations",
        "µm",
    ] {
        assert!(page.contains(number), "{number}");
    }
    let document = parsed(&page);
    let rows: Vec<String> = document
        .descendants()
        .filter(|node| node.has_tag_name("tr"))
        .map(|row| {
            let cells = row.children().filter_map(|cell| cell.text());
            cells
                .map(str::trim)
                .collect::<Vec<_>>()
                .join(" ")
                .trim()
                .to_owned()
        })
        .collect();
    let expected = "position rms µm 341 291 52.1 0.179 360 308 106 0.345";
    assert!(rows.iter().any(|row| row == expected), "{rows:#?}");
}

#[test]
fn further_logs_are_listed_with_their_numbers() {
    let (_, report) = variants()
        .into_iter()
        .find(|(n, _)| *n == "more logs")
        .unwrap();
    let page = page(&report);
    for part in [
        "All training logs",
        "train-2.csv",
        "train-3.csv",
        "4000",
        "2000",
    ] {
        assert!(page.contains(part), "{part}");
    }
}

#[test]
fn names_cannot_break_out_of_the_page() {
    let mut report = example();
    let name = "<script>alert(1)</script> & \"co\" \u{1b}[31m";
    report.outcome.machine = name.into();
    report.outcome.candidates[1].reason = name.into();
    report.outcome.effects[0].parameters[0].unit = "<b>".into();
    report.train[0].label = name.into();
    let page = page(&report);
    assert!(!page.contains("<script") && !page.contains('\u{1b}'));
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;co&quot;"));
    let document = parsed(&page);
    let heading = document
        .descendants()
        .find(|n| n.has_tag_name("h1"))
        .unwrap();
    assert_eq!(
        heading.text(),
        Some("<script>alert(1)</script> & \"co\" [31m")
    );
    assert!(!table::render(&report, false).contains('\u{1b}'));
}

#[test]
fn the_page_stays_small_for_a_long_log() {
    let mut report = example();
    report.train = vec![slide("long.csv", 400_000)];
    report.validate = vec![slide("long.csv", 400_000)];
    let page = page(&report);
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
}
