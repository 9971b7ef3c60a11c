//! What `cargo hil gap` shows: every number of the outcome, readable in a pipe and as one page
//! that stands alone.

use crate::gap_example::{example, slide, variant, variants};
use host_tests::gap::outcome::Report;
use host_tests::gap::table::Detail;
use host_tests::gap::{report, table};

/// Every number, as a pipe gets it.
fn verbose(report: &Report) -> String {
    table::render(report, false, Detail::Verbose)
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
    let text = verbose(&example());
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
fn a_wrong_number_is_marked() {
    let (_, report) = variants()
        .into_iter()
        .find(|(name, _)| *name == "wrong number")
        .unwrap();
    let marked = "[fit] does not name it; it was fitted because no effect follows the logs better than this value";
    assert_lines(&verbose(&report), &[marked]);
    assert!(page(&report).contains(marked));
}

#[test]
fn the_table_gives_effects_and_parameters_with_deviation_and_unit() {
    let text = verbose(&example());
    assert_lines(
        &text,
        &[
            "asymmetric_viscous score 0.871 identifiability 0.613 p 1.0e-6",
            "forward 167.2 ± 1.1 N·s/m",
            "backward 241.5 ± 1.3 N·s/m",
            "this log cannot tell it from: offset_torque, spring",
            "The values hold for the declared resistance or torque_constant; others explain less",
            "to declare it { id = \"asymmetric_viscous\", difference = -37.155 }",
            "sensor_delay score 0.222 identifiability 0.482 p 0.0042",
            "delay 504 ± 21 µs",
            "inertia 90 → 95.20 ± 0.12 kg +5.8 %",
            "viscous 203.5 → 204.36 N·s/m (the logs do not determine it) +0.4 %",
            "coulomb 20.4 → 20.21 ± 0.13 N -0.9 %",
            "inductance 0.00012 → (1.316 ± 0.024)e-4 H +9.6 %",
        ],
    );
}

#[test]
fn the_table_says_who_was_refused_and_why() {
    let text = verbose(&example());
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
        let plain = verbose(&report);
        for line in plain.lines() {
            assert!(line.chars().count() <= table::WIDTH, "{name}: {line:?}");
        }
        assert!(!plain.contains('\x1b'));
        let coloured = table::render(&report, true, Detail::Verbose);
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
            vec!["slide: no effect is missing.", "Nothing that was tried"],
        ),
        (
            "unknown",
            vec![
                "slide: an effect is missing that the catalogue does not name; it depends on velocity.",
                "depends on velocity: a friction was learned over it",
                "velocity, m/s 0 0.0500 0.100 0.150",
                "friction, N 1.25 -0.500 0 3.75",
            ],
        ),
        (
            "nothing proven",
            vec![
                "slide: nothing is proven: the model is off by 4.0 times the sensor's noise, and nothing that was tried \
                 predicts the rest of it.",
            ],
        ),
        (
            "implausible",
            vec![
                "slide: nothing is proven: to follow the logs, `viscous` had to go farther than the machine file \
                 lets it be off",
            ],
        ),
        (
            "at limit",
            vec!["viscous 203.5 → 5494 N·s/m (stopped at its limit)"],
        ),
        (
            "does not hold",
            vec!["error rose from", "What was found does not hold there."],
        ),
        (
            "effects and unknown",
            vec!["and sensor_delay. A further effect is missing that the catalogue"],
        ),
        (
            "no validation",
            vec!["On the training log", "to which the model was fitted"],
        ),
        ("diverged", vec!["diverged", "167.2 ± not determined N·s/m"]),
    ] {
        let report = variant(name);
        let text = fields(&verbose(&report));
        for part in expected {
            assert!(text.contains(part), "{name}: no {part:?} in {text}");
        }
    }
    let report = variant("no current");
    assert!(!verbose(&report).contains("current rms"));
}

#[test]
fn the_page_says_which_number_stopped_at_its_limit() {
    let report = variant("at limit");
    let page = page(&report);
    assert!(page.contains("5494 N·s/m (stopped at its limit)"));
    assert!(page.contains("The logs do not show how large viscous friction is"));
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

/// A model is called what it is: only where effects were found there is one without them.
#[test]
fn the_page_names_the_model_that_errs_most() {
    for (name, model) in [
        ("no effect", "as it is fitted"),
        ("wrong number", "with the declared numbers"),
        ("unknown", "without the learned map"),
        ("no validation", "without the effects"),
    ] {
        let report = variant(name);
        let page = page(&report);
        assert!(
            page.contains(&format!("the model {model} errs most.")),
            "{name}"
        );
        let said = page.matches("errs most.").count();
        assert_eq!(
            page.matches(&format!("the model {model} errs most."))
                .count(),
            said
        );
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
        let report = variant(name);
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
        "2 effects were missing, asymmetric_viscous (or offset_torque or spring: the logs cannot tell) and \
         sensor_delay.",
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
    let report = variant("more logs");
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
    assert!(!verbose(&report).contains('\u{1b}'));
}

#[test]
fn the_page_stays_small_for_a_long_log() {
    let mut report = example();
    report.train = vec![slide("long.csv", 400_000)];
    report.validate = vec![slide("long.csv", 400_000)];
    let page = page(&report);
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
}
