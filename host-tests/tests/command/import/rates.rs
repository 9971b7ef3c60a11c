//! How rows may lie in time.

use super::*;

#[test]
fn stamps_that_jitter_are_resampled_and_that_is_said() {
    let stamp = |k: usize| k as f64 + 0.3 * (2.4 * k as f64).sin();
    let raw = rows("t,u,x", 2_000, |k| {
        format!("{:.4},{},{:.9}", stamp(k), k % 5, (0.004 * stamp(k)).sin())
    });
    let place = Place::with("raw.csv", raw);
    let (log, said) = place.import("raw.csv --time t:ms --input u --position x");
    assert_eq!(log.period_s, 1e-3);
    for (k, value) in log.position.iter().enumerate() {
        assert!((value - (4.0 * log.time_s(k)).sin()).abs() < 1e-5, "{k}");
    }
    assert!(said.contains("was resampled: its 2000 rows"), "{said}");
}

/// A ripple of one period of the new rate is gone from the current, and nothing is delayed.
#[test]
fn a_lower_rate_averages_the_current_and_keeps_the_impulse() {
    let ripple = |k: usize| if k % 10 < 5 { 0.5 } else { -0.5 };
    let raw = rows("t,u,x,i", 4_001, |k| {
        let t = k as f64 * 1e-4;
        format!("{t:.4},{},{t:.4},{}", k % 10, 2.0 * t + ripple(k))
    });
    let place = Place::with("raw.csv", raw);
    let (log, said) =
        place.import("raw.csv --time t --input u --position x --current i --rate 1000");
    assert_eq!((log.period_s, log.samples()), (1e-3, 401));
    assert!(said.contains("401 samples at 1000 Hz"), "{said}");
    for k in 1..400 {
        assert!(
            (log.current.as_ref().unwrap()[k] - 2e-3 * k as f64).abs() < 1e-9,
            "{k}"
        );
        assert!((log.input[k] - 4.5).abs() < 1e-9);
        assert!((log.position[k] - 1e-3 * k as f64).abs() < 1e-12);
    }
    place.refuses(
        "import raw.csv --time t --input u --position x --rate 50000 --out log.csv",
        &["more samples would have to be filled in"],
    );
    place.refuses(
        "import raw.csv --time t --input u --position x --rate 0 --out log.csv",
        &["--rate", "above 0"],
    );
}

#[test]
fn rows_without_a_time_are_even() {
    let place = Place::with("raw.csv", rows("u,x", 200, |k| format!("{k},{}", k * k)));
    let (log, _) = place.import("raw.csv --rate 400 --input u --position x");
    assert_eq!((log.period_s, log.samples()), (2.5e-3, 200));
    place.refuses(
        "import raw.csv --input u --position x --out log.csv",
        &["--time", "rows that are even, --rate"],
    );
}

#[test]
fn rows_can_be_cut_sorted_and_left_out() {
    let place = Place::with(
        "raw.csv",
        rows("t,u,x", 400, |k| match k {
            20 => "20,lost,400".to_owned(),
            // Two neighbours in the wrong order.
            30 => "31,31,961".to_owned(),
            31 => "30,30,900".to_owned(),
            _ => format!("{k},{k},{}", k * k),
        }),
    );
    let words = "raw.csv --time t:ms --input u --position x";
    let (log, said) = place.import(&format!("{words} --skip-bad --sort"));
    assert_eq!(log.samples(), 400);
    assert_eq!((log.position[30], log.position[31]), (900.0, 961.0));
    assert_eq!(log.position[20], (19.0 * 19.0 + 21.0 * 21.0) / 2.0);
    assert!(
        said.contains("1 row without a usable number left out"),
        "{said}"
    );
    assert!(said.contains("1 row earlier than one before"), "{said}");
    // Line 1 has the names, so line 102 has row 100.
    let (log, _) = place.import(&format!("{words} --lines 102-301"));
    assert_eq!(
        (log.samples(), log.position[0], log.start_s),
        (200, 1e4, 0.1)
    );
    let refused = format!("import {words} --out log.csv");
    place.refuses(&refused, &["raw.csv:22: ", "\"lost\"", "--skip-bad"]);
    place.refuses(&format!("{refused} --lines 9-3"), &["--lines", "2-5001"]);
}

/// A sensor that is slower than the drive leaves its cells blank in the rows between: these keep their inputs.
#[test]
fn a_slow_sensor_is_interpolated_between_its_rows() {
    let position = |k: usize| 0.3 * (0.004 * k as f64).sin();
    // A reading late by a row, and one that is missing.
    let reads = |k: usize| match k {
        500 | 1_000 => false,
        501 => true,
        _ => k.is_multiple_of(5),
    };
    let raw = |turn: f64| {
        rows("t,u,x,i", 2_000, |k| {
            let x = position(k).rem_euclid(turn);
            let x = if reads(k) {
                format!("{x:.9}")
            } else {
                String::new()
            };
            format!("{:.3},{},{x},{}", 1e-3 * k as f64, k % 7, k % 3)
        })
    };
    let place = Place::with("raw.csv", raw(0.5));
    let (log, said) =
        place.import("raw.csv --time t --input u --position x --current i --unwrap 0.5");
    // Behind the last number, of row 1995, nothing was measured.
    assert_eq!((log.samples(), log.period_s), (1_996, 1e-3));
    near(&log.input, |k| (k % 7) as f64);
    let sentence = "x has a number in every 5th row or so, 399 of 2000: it was interpolated in the rows between, which puts an \
                    error of some ";
    assert!(said.contains(sentence), "{said}");
    for (k, value) in log.position.iter().enumerate() {
        assert!((value - position(k)).abs() < 1e-4, "{k}: {value}");
    }
    // Where a log is read as it is, the call that is printed does it.
    let log = raw(10.0).replacen("t,u,x,i", "time_s,input,position,current_a", 1);
    let place = Place::with("log.csv", log);
    place.write("machine.toml", Machine::force_slide().to_toml());
    let error = place
        .run("gap --machine machine.toml --train log.csv")
        .stderr;
    let error = text(&error);
    assert!(
        error.contains("cargo hil import") && !error.contains("--skip-bad"),
        "{error}"
    );
    // Cells that are blank without a rule are none of a slow sensor.
    let place = Place::with(
        "raw.csv",
        rows("t,u,x", 2_000, |k| match k % 97 {
            3 | 11 | 40 => format!("{k},1,"),
            _ => format!("{k},1,{k}"),
        }),
    );
    place.refuses(
        "import raw.csv --time t:ms --input u --position x --out log.csv",
        &[
            "the number for `position` is empty",
            "leave such rows out",
            "--skip-bad",
        ],
    );
}

/// A file that is read with the wrong delimiter has no numbers at all: rows to be left out would be all of it.
#[test]
fn rows_without_any_number_are_not_to_be_left_out() {
    let raw = rows("t,u,x", 400, |k| {
        format!("12:00:{:02}.000 => {k},1,{k}", k % 60)
    });
    let place = Place::with("raw.csv", raw);
    let error = place
        .run("import raw.csv --time t --input u --position x --out log.csv")
        .stderr;
    let error = text(&error);
    assert!(
        error.contains("what separates the fields (--delimiter)"),
        "{error}"
    );
    assert!(!error.contains("leave such rows out"), "{error}");
}

/// Rows that are put into the order of their time lie in no order in the file: a part between two of its lines may be all of it,
/// and is not cut again.
#[test]
fn a_part_of_rows_that_were_sorted_is_not_cut_for_ever() {
    let raw = rows("t,u,x", 800, |k| {
        let time = match k {
            0 => 0,
            1..=400 => 1_000 + k,
            _ => k - 400,
        };
        format!("{time},{},{time}", k % 7)
    });
    let place = Place::with("raw.csv", raw);
    place.refuses(
        "import raw.csv --time t:ms --input u --position x --sort --out log.csv",
        &[
            "give both parts: cargo hil import raw.csv --time t:ms --input u --position x --lines 3-402 --sort --out \
             raw-corrected.csv\n",
        ],
    );
}

/// What is said of a slow sensor's error is what its interpolation costs, of motions that are known: a sine, a sweep of sines and
/// a triangle, with even stamps and with stamps that jitter.
#[test]
fn the_error_of_a_slow_sensor_is_what_it_costs() {
    let sine = |t: f64| 0.4 * (TAU * 0.7 * t).sin();
    let sweep = |t: f64| 0.4 * (TAU * (0.2 + 0.3 * t) * t).sin();
    let triangle = |t: f64| ((0.7093 * t).rem_euclid(1.0) - 0.5).abs();
    let motions: [(&str, &dyn Fn(f64) -> f64); 3] =
        [("sine", &sine), ("sweep", &sweep), ("triangle", &triangle)];
    for (name, motion) in motions {
        for (every, jitter) in [(4, 0.0), (10, 0.0), (25, 0.0), (10, 0.2)] {
            let stamp = |k: usize| 1e-3 * (k as f64 + jitter * (2.4 * k as f64).sin());
            let raw = rows("t,u,x", 6_001, |k| {
                let read = k.is_multiple_of(every);
                let x = if read {
                    format!("{:.9}", motion(stamp(k)))
                } else {
                    String::new()
                };
                format!("{:.7},1,{x}", stamp(k))
            });
            let place = Place::with("raw.csv", raw);
            let (log, said) = place.import("raw.csv --time t --input u --position x:rad");
            let (_, behind) = said
                .split_once("which puts an error of some ")
                .expect(&said);
            let mut words = behind.split(' ');
            let (number, unit) = (words.next().unwrap(), words.next().unwrap());
            let factor = match unit {
                "mrad" => 1e-3,
                "µrad" => 1e-6,
                "nrad" => 1e-9,
                other => panic!("{other}: {said}"),
            };
            let printed = factor * number.parse::<f64>().unwrap();
            let squares = log.position.iter().enumerate();
            let squares = squares.map(|(k, value)| (value - motion(log.time_s(k))).powi(2));
            let cost = (squares.sum::<f64>() / log.samples() as f64).sqrt();
            // Corners are at random places of their steps: of some 9 of them the mean is known to a fifth.
            assert!(
                (printed / cost - 1.0).abs() < 0.35,
                "{name}, every {every}th, {jitter}: {printed} for {cost}"
            );
        }
    }
}
