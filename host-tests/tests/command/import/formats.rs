//! Files of other people's writers: `host-tests/formats/samples`, with the script that had them written.

use host_tests::workspace;

use super::*;

/// A file of the samples, under its own name.
fn sample(name: &str) -> Place {
    let path = workspace::root()
        .join("host-tests/formats/samples")
        .join(name);
    Place::with(name, fs::read(path).expect("a sample"))
}

/// Position in rad, duty of 24 V in V and current in A of a sample, as its script has them.
fn motion(row: usize) -> [f64; 3] {
    let position = 30.0 * (TAU * row as f64 / 1000.0).sin();
    let duty = ((row % 100) as f64 - 50.0).abs() * 2.0 - 50.0;
    let current = ((row * 7) % 1000) as f64 - 500.0;
    [position.to_radians(), duty / 100.0 * 24.0, current / 1000.0]
}

#[track_caller]
fn is_at_one_kilohertz(log: &Log) {
    assert!((log.period_s - 1e-3).abs() < 1e-12, "{}", log.period_s);
    assert_eq!(log.start_s, 0.0);
}

/// That a log is the samples' motion, at 1 kHz from its beginning.
#[track_caller]
fn is_the_motion(log: &Log) {
    assert_eq!(log.samples(), 200);
    is_at_one_kilohertz(log);
    near(&log.position, |row| motion(row)[0]);
    near(&log.input, |row| motion(row)[1]);
    let current = log.current.as_ref().expect("a current");
    near(current, |row| motion(row)[2]);
}

#[test]
#[ignore = "at length: the readers are built"]
fn parquet() {
    for codec in ["snappy", "zstd"] {
        let name = format!("run-{codec}.parquet");
        let place = sample(&name);
        let words = |current: &str| {
            format!("{name} --time stamp --position pos:deg --input duty:%*24 --current {current}")
        };
        let (log, said) = place.import(&words("pos:A"));
        assert_eq!(log.samples(), 200, "{said}");
        assert!(
            said.contains("Parquet, columns of numbers: 5, others left out: 1"),
            "{said}"
        );
        is_at_one_kilohertz(&log);
        near(&log.position, |row| motion(row)[0]);
        near(&log.input, |row| motion(row)[1]);
        // One cell of the current is empty.
        place.refuses(
            &format!("import {} --out log.csv", words("i:mA")),
            &["the number for `current_a` is ", "--skip-bad"],
        );
        // A count without sign that passes 2³².
        let (log, _) = place.import(&words("count:A/1000"));
        let count = log.current.expect("a current");
        near(&count, |row| {
            ((row as u64 + 4_294_967_000) % (1 << 32)) as f64 / 1000.0
        });
    }
}

#[test]
#[ignore = "at length: the readers are built"]
fn mdf() {
    let place = sample("run.mf4");
    let call = "run.mf4 --time time --position pos:deg --input duty:%*24 --current i:mA";
    let (log, said) = place.import(call);
    assert!(said.contains("MDF 4.10, channel groups: 2"), "{said}");
    is_the_motion(&log);
    // Of another group, that comes less often.
    place.refuses(
        &format!("import {} --out log.csv", call.replace("i:mA", "oil")),
        &["expected columns of one length"],
    );
}

#[test]
#[ignore = "at length: the readers are built"]
fn mcap_of_json() {
    let place = sample("run-json.mcap");
    let call = "--position pos:deg --input drive.duty:%*24 --current drive.i.0:mA";
    let (log, said) = place.import(&format!("run-json.mcap --time log_time {call}"));
    assert!(said.contains("MCAP, topics: 1"), "{said}");
    is_the_motion(&log);
    let (log, _) = place.import(&format!("run-json.mcap --time publish_time+5:us {call}"));
    assert_eq!(log.samples(), 200);
}

#[test]
#[ignore = "at length: the readers are built"]
fn mcap_of_ros_2() {
    let place = sample("run-ros2.mcap");
    let call = "--position position.0:deg --input duty:%*24 --current current.0:mA";
    for time in ["log_time", "header.stamp"] {
        let (log, _) = place.import(&format!("run-ros2.mcap --time {time} {call}"));
        is_the_motion(&log);
    }
    let (log, _) = place.import(
        "run-ros2.mcap --time log_time --position tips.0.y:deg --input tips.0.x --current mode",
    );
    near(&log.position, |row| motion(row)[0]);
    near(&log.input, |row| -(row as f64));
    near(&log.current.expect("a current"), |_| 1.0);
}

#[test]
#[ignore = "at length: the readers are built"]
fn a_file_that_is_cut_short_or_changed_is_an_error() {
    for (name, column) in [
        ("run-zstd.parquet", "pos"),
        ("run.mf4", "pos"),
        ("run-json.mcap", "pos"),
        ("run-ros2.mcap", "duty"),
    ] {
        let whole = sample(name);
        let bytes = fs::read(whole.path(name)).expect("the sample");
        let call =
            format!("import {name} --rate 1000 --position {column} --input {column} --out log.csv");
        for cut in [7, bytes.len() / 3, bytes.len() - 9] {
            whole.write(name, &bytes[..cut]);
            let output = whole.run(&call);
            // What a reader can be sure of is as good as a shorter log; nothing else may come of it.
            assert!(matches!(output.status.code(), Some(0 | 2)), "{name} {cut}");
            let _ = fs::remove_file(whole.path("log.csv"));
        }
        for at in (8..bytes.len()).step_by(bytes.len() / 12) {
            let mut changed = bytes.clone();
            changed[at] ^= 0x55;
            whole.write(name, changed);
            let output = whole.run(&call);
            assert!(matches!(output.status.code(), Some(0 | 2)), "{name} {at}");
            let _ = fs::remove_file(whole.path("log.csv"));
        }
    }
}
