//! A carriage on a belt, moved by a motor that a duty drives: its stroke comes in millimetres or in counts, and what is printed
//! of it leads to a log that `gap` accepts.

use super::*;
use rig::{Coordinate, Experiment, Motor, PidGains, Trajectory};

/// Volts of the supply.
const SUPPLY: f64 = 24.0;

fn carriage() -> Machine {
    Machine {
        name: "carriage",
        coordinate: Coordinate::Metre,
        motor: Motor::Winding {
            resistance: 2.4,
            inductance: 2e-4,
            torque_constant: 14.5,
        },
        input_limit: SUPPLY,
        inertia: 1.7,
        viscous: 3.0,
        coulomb: 5.0,
        static_friction: 6.0,
        resolution: 5e-6,
        gains: PidGains {
            proportional: 1_000.0,
            integral: 1_500.0,
            derivative: 10.0,
            derivative_time: 3e-3,
        },
        stroke: (0.03, 0.27),
        speed: 0.5,
        ..Machine::rotary_ema()
    }
}

/// Time, s, volts and metres of each row.
fn samples() -> &'static [[f64; 3]] {
    static SAMPLES: OnceLock<Vec<[f64; 3]>> = OnceLock::new();
    SAMPLES.get_or_init(|| {
        let moves = Trajectory::moves(&carriage());
        let experiment = Experiment::tracking(carriage(), moves).lasting(4.0);
        let log = Log::of_bytes("rig.csv".as_ref(), experiment.run().to_csv().into_bytes());
        let log = log.expect("a log");
        let rows = log.input.iter().zip(&log.position).enumerate();
        rows.map(|(row, (input, position))| [log.time_s(row), *input, *position])
            .collect()
    })
}

/// The machine file that takes a duty, with the resolution of the encoder or without.
fn machine(with_resolution: bool) -> String {
    let toml = carriage().to_toml();
    let toml = toml.replace("gain = 1.0", &format!("gain = {SUPPLY:?}"));
    assert!(
        toml.contains("gain = 24.0") && toml.contains("resolution"),
        "{toml}"
    );
    let kept = |line: &&str| with_resolution || !line.starts_with("resolution");
    toml.lines()
        .filter(kept)
        .map(|line| format!("{line}\n"))
        .collect()
}

/// What a logger wrote whose header names no unit: milliseconds, this much a volt and a metre.
fn raw(a_volt: f64, a_metre: f64) -> String {
    rows("t,u,x", samples().len(), |row| {
        let [time, volts, metres] = samples()[row];
        format!("{},{},{}", 1e3 * time, a_volt * volts, a_metre * metres)
    })
}

/// Follows the first call that `gap` prints of each log, until it accepts one; that log, and all that it said.
#[track_caller]
fn followed(place: &Place) -> (Log, String) {
    let mut log = "raw.csv".to_owned();
    let mut all = String::new();
    for _ in 0..3 {
        let output = place.run(&format!("gap --machine m.toml --train {log}"));
        let said = [text(&output.stdout), text(&output.stderr)].concat();
        all += &said;
        let Some(start) = said.find("cargo hil import") else {
            assert!(
                output.status.success() && !said.contains("do not belong"),
                "{all}"
            );
            return (Log::read(&place.path(&log)).expect("a log"), all);
        };
        let call = said[start..].lines().next().unwrap();
        place.follow(call);
        log = call.split(" --out ").last().unwrap().to_owned();
    }
    panic!("no log that is accepted: {all}");
}

#[test]
fn the_printed_calls_lead_to_a_log_that_is_accepted() {
    for (a_metre, unit) in [(1e3, "mm"), (1e2, "cm"), (1.0 / 0.0254, "in")] {
        for (a_volt, input) in [(1.0 / SUPPLY, "input"), (100.0 / SUPPLY, "\"input:%*1\"")] {
            for with_resolution in [true, false] {
                let place = Place::with("raw.csv", raw(a_volt, a_metre));
                place.write("m.toml", machine(with_resolution));
                let (log, said) = followed(&place);
                let call = format!("--position position:{unit} --input {input} ");
                assert!(said.contains(&call), "{call}: {said}");
                for (row, [_, volts, metres]) in samples().iter().enumerate() {
                    assert!((log.position[row] - metres).abs() < 1e-9, "{call}");
                    assert!((log.input[row] - volts / SUPPLY).abs() < 1e-9, "{call}");
                }
            }
        }
    }
}

/// Volts beside such a machine file are mended in the machine file alone, and the position in the log.
#[test]
fn volts_and_millimetres_are_both_mended() {
    let place = Place::with("raw.csv", raw(1.0, 1e3));
    place.write("m.toml", machine(true));
    let output = place
        .run("import raw.csv --time t:ms --input u --position x*1 --machine m.toml --out a.csv");
    let said = text(&output.stdout);
    assert!(said.contains("in m.toml, [input]: gain = 1e0"), "{said}");
    let call = said
        .lines()
        .find_map(|line| line.trim().strip_prefix("Remedy: cargo"));
    place.follow(&format!("cargo{}", call.expect("a call")));
    place.write("m.toml", carriage().to_toml());
    let (_, said) = place
        .import("a-corrected.csv --time time_s --position position --input input --machine m.toml");
    assert!(
        said.contains("Nothing in the log contradicts m.toml"),
        "{said}"
    );
}

/// The unit of a stroke follows from what is said of it, and else from the machine file.
#[test]
fn a_stroke_is_no_angle() {
    let counts = rows("t,u,cnt", samples().len(), |row| {
        let [time, volts, metres] = samples()[row];
        format!(
            "{},{},{}",
            1e3 * time,
            volts / SUPPLY,
            (metres / 5e-6).round()
        )
    });
    let place = Place::with("raw.csv", counts);
    place.write("m.toml", machine(true));
    place.write("rotary.toml", Machine::rotary_ema().to_toml());
    for (position, machine, unit) in [
        ("cnt:counts*0.005:mm", "", "m"),
        ("cnt:counts*5e-6", " --machine m.toml", "m"),
        ("cnt:counts*5e-6", "", "rad or m"),
        ("cnt:counts/8000", "", "rad"),
    ] {
        let (log, said) = place.import(&format!(
            "raw.csv --time t:ms --input u:duty*1 --position {position}{machine}"
        ));
        let line = said
            .lines()
            .find(|line| line.starts_with("position"))
            .unwrap();
        assert!(line.ends_with(&format!(" {unit}")), "{position}: {line}");
        if position.contains('*') {
            for (row, [_, _, metres]) in samples().iter().enumerate() {
                assert!((log.position[row] - metres).abs() < 3e-6, "{position}");
            }
        }
    }
    for (position, machine, hint) in [
        (
            "cnt:counts/8000",
            "m.toml",
            "an angle's unit, and the coordinate of the machine file is a stroke: then --position \"cnt:counts*0.005:mm\"",
        ),
        (
            "cnt:mm",
            "rotary.toml",
            "a stroke's unit, and the coordinate of the machine file is an angle",
        ),
        (
            "cnt",
            "m.toml",
            "its values are whole: then --position \"cnt:counts*0.005:mm\"",
        ),
    ] {
        let (_, said) = place.import(&format!(
            "raw.csv --time t:ms --input u:duty*1 --position {position} --machine {machine}"
        ));
        assert!(said.contains(hint), "no {hint}: {said}");
    }
    let refused = "import raw.csv --time t:ms --input u --position cnt:counts:mm --out log.csv";
    place.refuses(refused, &["how much a count is", "cnt:counts*0.005:mm"]);
}

/// Without a unit a position may be degrees; of a stroke it is not.
#[test]
fn a_long_stroke_is_in_millimetres() {
    let place = Place::with("raw.csv", raw(1.0 / SUPPLY, 1e3));
    place.write("m.toml", machine(true));
    let words = "raw.csv --time t:ms --input u:duty*1 --position x";
    let (_, said) = place.import(words);
    let hint = "then --position \"x:deg\"; of a stroke --position \"x:mm\"";
    assert!(said.contains(hint), "{said}");
    // The machine file says how far its motor moves it: that is better than any guess from the range.
    let (_, said) = place.import(&format!("{words} --machine m.toml"));
    assert!(
        said.contains("position is in millimetres") && !said.contains("Look again"),
        "{said}"
    );
}

/// A counter that was multiplied by a wrong size of a count comes near to some unit by chance.
#[test]
fn a_wrong_size_of_a_count_is_said_beside_a_unit() {
    let counts = rows("t,u,cnt", samples().len(), |row| {
        let [time, volts, metres] = samples()[row];
        let count = (metres / 5e-6).round();
        format!("{},{},{count}", 1e3 * time, volts / SUPPLY)
    });
    let place = Place::with("raw.csv", counts);
    place.write("m.toml", machine(false));
    let words = "raw.csv --time t:ms --input u:duty*1 --machine m.toml --position";
    // 200,000 counts to a metre, and 2,000 of them to a centimetre.
    let (_, said) = place.import(&format!("{words} cnt/2000"));
    let hint = "the size of a count may be wrong instead: then --position \"cnt:counts*0.005:mm\"";
    assert!(said.contains(hint), "{said}");
    for right in ["cnt*5e-6", "cnt:counts*0.005:mm"] {
        let (_, said) = place.import(&format!("{words} {right}"));
        assert!(said.contains("Nothing in the log contradicts"), "{said}");
    }
}

/// A velocity that was given another unit than its own is seen beside the position.
#[test]
fn a_velocity_in_another_unit_than_the_given_one_is_pointed_out() {
    let raw = rows("t,x,w", 400, |row| {
        let time = 1e-3 * row as f64;
        format!(
            "{time:.3},{},{}",
            (9.0 * time).sin(),
            9.0 * (9.0 * time).cos()
        )
    });
    let place = Place::with("raw.csv", raw);
    let words = "raw.csv --time t --input x:V --position";
    for (position, given, own) in [
        ("x:rev", "deg/s", Some("rev/s")),
        // A sixth of a turn for each of the position's.
        ("x:rev/60", "rev/s", Some("rpm")),
        ("x:rev*6", "rpm", None),
        ("x:mm", "m/s", Some("mm/s")),
        ("x:rev", "rev/s", None),
        ("x", "deg/s", None),
    ] {
        let (_, said) = place.import(&format!("{words} {position} --velocity w:{given}"));
        let hint = own.map(|own| format!("given in {given}, and may be in {own}, for it is"));
        match hint {
            Some(hint) => assert!(said.contains(&hint), "{hint}: {said}"),
            None => assert!(!said.contains("may be in"), "{said}"),
        }
    }
}

/// What an import has filled in is known to whoever reads its log, and to the next import.
#[test]
fn filled_samples_are_not_forgotten() {
    let all = raw(1.0 / SUPPLY, 1e3);
    let kept = |(row, _): &(usize, &str)| row % 100 < 95;
    let lines: Vec<&str> = all
        .lines()
        .enumerate()
        .filter(kept)
        .map(|(_, line)| line)
        .collect();
    let place = Place::with("raw.csv", lines.join("\n") + "\n");
    place.write("m.toml", machine(true));
    let words = "--time t:ms --input u:duty*1 --position x:mm";
    let (direct, said) = place.import(&format!("raw.csv {words}"));
    assert!(said.contains("was resampled"), "{said}");
    let missing = direct.samples() - (lines.len() - 1);
    let change = direct.resampling.expect("filled");
    assert_eq!((change.filled, change.rows), (missing, lines.len() - 1));
    assert!(missing > 100);
    place.run(&format!("import raw.csv {words} --out log.csv"));
    let again = "log.csv --time time_s --input input --position position";
    let output = place.run(&format!("import {again} --out again.csv"));
    assert!(!text(&output.stdout).contains("not asked for"));
    let again = Log::read(&place.path("again.csv")).expect("a log");
    assert_eq!(again.resampling.expect("filled").filled, missing);
    let output = place.run("gap --machine m.toml --train log.csv");
    let said = text(&output.stdout).replace('\n', " ");
    let filled = format!(
        "log.csv was resampled: {missing} of {} samples filled in",
        direct.samples()
    );
    assert!(said.contains(&filled), "{said}");
    assert!(
        output.stdout.iter().filter(|byte| **byte == b'\n').count() <= 13,
        "{said}"
    );
}
