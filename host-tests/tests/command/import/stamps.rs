//! Time stamps with a clock are read as seconds since the first row.

use super::*;

/// 300 rows, 4 ms apart, from half a second before midnight; `stamp` writes the day, and the time of it in ms.
fn over_midnight(header: &str, separator: &str, stamp: impl Fn(u32, u32) -> String) -> String {
    const DAY: u32 = 86_400_000;
    rows(header, 300, |k| {
        let time = DAY - 500 + 4 * k as u32;
        let angle = 40.0 * (0.02 * k as f64).sin();
        [
            stamp(time / DAY, time % DAY),
            (k % 60).to_string(),
            format!("{angle:.3}"),
        ]
        .join(separator)
    })
}

/// `06:29:54.123`, with another mark in place of the point.
fn clock(time: u32, mark: char) -> String {
    let (seconds, rest) = (time / 1000, time % 1000);
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    format!("{hours:02}:{minutes:02}:{:02}{mark}{rest:03}", seconds % 60)
}

/// The log of it, imported by a call that names the columns.
#[track_caller]
fn is_read(content: &str, first: &str) {
    let place = Place::with("raw.csv", content);
    let (log, said) = place.import("raw.csv --time t --input u:mV --position x:deg");
    assert_eq!((log.samples(), log.start_s), (300, 0.0), "{content}");
    assert!((log.period_s - 4e-3).abs() < 1e-12, "{}", log.period_s);
    near(&log.input, |k| 1e-3 * (k % 60) as f64);
    let told = format!("The time is counted from the file's first row, {first}.");
    assert!(said.contains(&told), "{said}");
    assert!(said.contains("none was resampled"), "{said}");
}

#[test]
fn dates_and_clocks_of_loggers() {
    let iso = over_midnight("t,u,x", ",", |day, time| {
        format!("2026-11-{:02}T{}Z", 27 + day, clock(time, '.'))
    });
    is_read(&iso, "2026-11-27T23:59:59.500Z");
    let points = over_midnight("t;u;x", ";", |day, time| {
        format!("{:02}.11.2026 {}", 27 + day, clock(time, ','))
    });
    is_read(&points, "27.11.2026 23:59:59,500");
    let american = over_midnight("t\tu\tx", "\t", |day, time| {
        let (half, time) = if time < 43_200_000 {
            ("AM", time)
        } else {
            ("PM", time - 43_200_000)
        };
        format!("11/{}/2026 {} {half}", 27 + day, clock(time, '.'))
    });
    is_read(&american, "11/27/2026 11:59:59.500 PM");
    // A clock alone, which passes midnight.
    is_read(
        &over_midnight("t,u,x", ",", |_, time| clock(time, '.')),
        "23:59:59.500",
    );
}

/// What separates the fields separates the decimals of the clock, or the clock from its date; the names count one column.
#[test]
fn a_stamp_in_two_fields_is_one() {
    let date = |day: u32| format!("2026-11-{:02}", 27 + day);
    let commas = over_midnight("t,u,x", ",", |day, time| {
        format!("{} {}", date(day), clock(time, ','))
    });
    is_read(&commas, "2026-11-27 23:59:59.500");
    let spaces = over_midnight("t u x", " ", |day, time| {
        format!("{} {}", date(day), clock(time, '.'))
    });
    is_read(&spaces, "2026-11-27 23:59:59.500");
    // Where the date has a name of its own, the clock is a column.
    let apart = over_midnight("date,t,u,x", ",", |day, time| {
        format!("{},{}", date(day), clock(time, '.'))
    });
    is_read(&apart, "23:59:59.500");
    // Three digits that the names count are another column.
    let counts = rows("t,n,u,x", 300, |k| {
        format!(
            "00:{:02}:{:02},{},{},{}",
            k / 60,
            k % 60,
            200 + k,
            k % 60,
            k % 7
        )
    });
    let place = Place::with("raw.csv", counts);
    let (log, _) = place.import("raw.csv --time t --input u --position n");
    assert!((log.period_s - 1.0).abs() < 1e-12);
    near(&log.position, |k| 200.0 + k as f64);
}

/// Without names only the digits say what they are: decimals of the clock go on from row to row.
#[test]
fn digits_behind_a_clock_without_a_header_are_its_decimals_only_if_they_go_on() {
    let content = |digits: &dyn Fn(u32, u32) -> u32| {
        let lines = (0..900).map(|k| {
            // 4 ms a row, from half a second before midnight.
            let time = (86_399_500 + 4 * k) % 86_400_000;
            let seconds = &clock(time, '.')[..8];
            format!("{},{seconds},{:03},{}\n", 4 * k, digits(k, time), k % 7)
        });
        lines.collect::<String>()
    };
    let place = Place::with("raw.csv", content(&|_, time| time % 1000));
    let (log, _) = place.import("raw.csv --time 2 --input 3 --position 3");
    assert_eq!(log.samples(), 900);
    assert!((log.period_s - 4e-3).abs() < 1e-12, "{}", log.period_s);
    near(&log.input, |k| (k % 7) as f64);
    // A converter's counts: of a wave, of a sensor at rest, and of what rises or falls over the whole log.
    let wave = |k: u32, _: u32| (500.0 + 300.0 * (0.05 * f64::from(k)).sin()) as u32;
    for counts in [
        &wave as &dyn Fn(u32, u32) -> u32,
        &|_, _| 512,
        &|k, _| 100 + k,
        &|k, _| 999 - k,
    ] {
        place.write("raw.csv", content(counts));
        let (log, _) = place.import("raw.csv --time 1:ms --input 3 --position 4");
        near(&log.input, |k| f64::from(counts(k as u32, 0)));
    }
}

/// The first row is damaged: the rows behind it say what the column holds.
#[test]
fn a_damaged_first_row_does_not_decide_what_a_column_holds() {
    let content = over_midnight("t,u,x", ",", |_, time| clock(time, '.'));
    for damaged in ["", "boot", "0"] {
        let place = Place::with("raw.csv", content.replacen("23:59:59.500", damaged, 1));
        let call = "import raw.csv --time t --input u:mV --position x:deg --out log.csv";
        place.refuses(call, &["raw.csv:2", "--skip-bad"]);
        let (log, said) = place.import("raw.csv --time t --input u:mV --position x:deg --skip-bad");
        assert_eq!(log.samples(), 299, "{damaged}");
        assert!((log.period_s - 4e-3).abs() < 1e-12, "{}", log.period_s);
        assert!(said.contains("first row, 23:59:59.504"), "{said}");
    }
}

#[test]
fn a_stamp_has_no_unit_and_is_no_measurement() {
    let content = over_midnight("t,u,x", ",", |_, time| clock(time, '.'));
    let place = Place::with("raw.csv", content.replacen("23:59:59.512", "pause", 1));
    let call = |time: &str, input: &str| {
        format!("import raw.csv --time {time} --input {input} --position x:deg --out log.csv")
    };
    place.refuses(
        &call("t:ms", "u:mV"),
        &[
            "--time",
            "holds time stamps (23:59:59.500)",
            "leave the unit out",
        ],
    );
    place.refuses(
        &call("t", "t"),
        &["--input", "holds time stamps", "a column of numbers"],
    );
    place.refuses(
        &call("t", "u:mV"),
        &["raw.csv:5", "\"pause\"", "--skip-bad"],
    );
    // As a spreadsheet saves what it shows.
    let shown = over_midnight("t,u,x", ",", |_, time| clock(time, '.')[3..10].to_owned());
    place.write("raw.csv", shown);
    place.refuses(
        &call("t", "u:mV"),
        &["raw.csv:2", "\"59:59.5\"", "write 06:29:54.123"],
    );
}
