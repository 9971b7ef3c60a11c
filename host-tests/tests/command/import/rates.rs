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
