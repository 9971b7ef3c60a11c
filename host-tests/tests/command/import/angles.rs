//! Readings of an angle that start again.

use super::*;

/// A steady turn that reads 0 to 360 comes out steady, whatever the unit of the reading.
#[test]
fn a_reading_that_starts_again_is_unwrapped() {
    let turns = |k: usize| 0.03 * k as f64 - 2.0;
    let wrapped = |k: usize, turn: f64| turns(k).rem_euclid(1.0) * turn;
    let raw = rows("t,deg,count,rad,u,ref", 400, |k| {
        let (degrees, counts) = (wrapped(k, 360.0), wrapped(k, 4096.0));
        format!(
            "{k},{degrees},{counts},{},1,{}",
            wrapped(k, TAU),
            (degrees + 20.0) % 360.0
        )
    });
    let place = Place::with("raw.csv", raw);
    for column in ["deg:deg", "count:counts/4096", "rad"] {
        let words = format!("raw.csv --time t:ms --input u --position {column} --command ref:deg");
        let (log, said) = place.import(&format!("{words} --unwrap"));
        for (k, value) in log.position.iter().enumerate() {
            assert!(
                (value - log.position[0] - TAU * 0.03 * k as f64).abs() < 1e-9,
                "{column} {k}"
            );
        }
        assert!(said.contains("23 jumps taken out"), "{said}");
        let apart = log.command.unwrap()[399] - log.position[399];
        assert!(
            (apart - 20.0 * PI / 180.0).abs() < 1e-9,
            "{column}: {apart}"
        );
        let (log, said) = place.import(&words);
        assert!(
            log.position
                .iter()
                .all(|value| (0.0..TAU + 1e-9).contains(value))
        );
        assert!(said.contains("add --unwrap"), "{said}");
    }
}

/// Degrees that are taken for radians turn in nearly every row.
#[test]
fn a_turn_of_another_unit_is_pointed_out() {
    let raw = rows("t,x,u", 400, |k| {
        format!("{k},{},{}", (7.0 * k as f64) % 360.0, k % 7)
    });
    let place = Place::with("raw.csv", raw);
    let words = "raw.csv --time t:ms --input u --unwrap --position";
    let doubt = "Look again: --unwrap took";
    let (_, said) = place.import(&format!("{words} x"));
    assert!(said.contains(doubt), "{said}");
    let (_, said) = place.import(&format!("{words} x:deg"));
    assert!(!said.contains(doubt), "{said}");
}

/// A sample that is alone, the first one, the last one or one between them, is damaged: no reading starts again there.
#[test]
fn a_damaged_sample_is_no_turn() {
    for damaged in [0, 150, 399] {
        let raw = rows("t,x,u", 400, |k| {
            let angle = if k == damaged { 300.0 } else { 0.05 * k as f64 };
            format!("{k},{angle},{}", k % 7)
        });
        let place = Place::with("raw.csv", raw);
        let call = "import raw.csv --time t:ms --position x:deg --input u --out log.csv";
        let output = place.run(call);
        let (said, warned) = (text(&output.stdout), text(&output.stderr));
        assert!(!said.contains("--unwrap"), "{said}");
        assert!(warned.contains("in this sample alone"), "{warned}");
    }
}

/// A sensor that drops out for two samples or three is no slow sampling either, and what is there comes from its neighbours. Where
/// it stays, it is a turn.
#[test]
fn a_sensor_that_drops_out_for_a_few_samples_is_mended() {
    let angle = |k: usize| 30.0 + 20.0 * (0.05 * k as f64).sin();
    for (count, mended) in [(2, true), (3, true), (12, false)] {
        let raw = rows("t,x,u", 400, |k| {
            let damaged = (150..150 + count).contains(&k);
            format!("{k},{},{}", if damaged { 0.0 } else { angle(k) }, k % 7)
        });
        let place = Place::with("raw.csv", raw);
        let output =
            place.run("import raw.csv --time t:ms --position x:deg --input u --out log.csv");
        let warned = text(&output.stderr);
        let said = format!("jumps to 0.0 for {count} samples");
        assert_eq!(warned.contains(&said), mended, "{warned}");
        if mended {
            let log = Log::read(&place.path("log.csv")).expect("a log");
            // Over four steps of 0.05 rad a sine of 20 degrees is within 0.1 of a straight line.
            for (k, position) in log.position.iter().enumerate() {
                assert!(
                    (position.to_degrees() - angle(k)).abs() < 0.11,
                    "row {k}: {position}"
                );
            }
        }
    }
}

/// A counter of 16 bits behind a spindle of 2 µm a count.
#[test]
fn a_counter_says_at_what_it_starts_again() {
    let raw = rows("t,n,u", 400, |k| {
        format!("{k},{},1", (60_000 + 700 * k) % 65_536)
    });
    let place = Place::with("raw.csv", raw);
    let words = "import raw.csv --time t:ms --input u --position n:um*2 --out log.csv";
    place.refuses(
        &format!("{words} --unwrap"),
        &["no angle", "--unwrap 65536"],
    );
    let (log, _) = place.import("raw.csv --time t:ms --input u --position n:um*2 --unwrap 65536");
    near(&log.position, |k| (60_000 + 700 * k) as f64 * 2e-6);
}
