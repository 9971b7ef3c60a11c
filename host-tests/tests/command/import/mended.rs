//! Where `gap` refuses a log for its form, the call that it prints makes one which it accepts.

use super::*;
use crate::pushed_slide::HEADER;

fn log() -> &'static str {
    static LOG: OnceLock<String> = OnceLock::new();
    LOG.get_or_init(|| crate::pushed_slide::log(3.0))
}

/// The log with its rows changed; `edit` gets the row and its fields: time, input, position, command.
fn changed(header: &str, edit: impl Fn(usize, &[&str]) -> String) -> String {
    let rows = log().lines().skip(1).enumerate();
    let rows: Vec<String> = rows
        .map(|(row, line)| edit(row, &line.split(',').collect::<Vec<&str>>()))
        .filter(|line| !line.is_empty())
        .collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

fn verdict(place: &Place, log: &str) -> String {
    let output = place.run(&format!(
        "gap --machine machine.toml --train {log} --json gap.json"
    ));
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json = fs::read_to_string(place.path("gap.json")).expect("JSON");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    json["verdict"].as_str().expect("a verdict").to_owned()
}

/// The call that the refusal of this log prints. Following it, the log is accepted.
#[track_caller]
fn mends(content: impl AsRef<[u8]>, words: &[&str]) {
    let place = Place::with("my log.csv", content);
    place.write("machine.toml", Machine::force_slide().to_toml());
    let gap = "gap --machine machine.toml --train my~log.csv";
    place.refuses(gap, words);
    let error = place.run(gap).stderr;
    let error = text(&error).trim_end();
    let Some(start) = error.find("cargo hil import") else {
        panic!("no call: {error}");
    };
    let call = &error[start..];
    // Of a log that is to be cut a call for each part.
    for (part, call) in call.split(" && ").enumerate() {
        place.follow(call);
        if part > 0 {
            verdict(&place, &format!("my~log-corrected-{}.csv", part + 1));
        }
    }
    let made = place.path("my log-corrected.csv");
    assert!(made.is_file(), "{call}");
    let made = Log::read(&made).expect("a log");
    assert!(made.samples() >= 1_000, "{call}: {}", made.samples());
    verdict(&place, "my~log-corrected.csv");
}

/// Units that the file states stand in the call, SI units too.
#[test]
fn a_call_carries_the_units_of_the_file() {
    let body = log().lines().skip(1);
    let body: Vec<String> = body.map(|line| line.replace(',', "\t")).collect();
    let content = format!(
        "Time\tF_cmd\tx\tRef\n[s]\t[N]\t[m]\t[m]\n{}\n",
        body.join("\n")
    );
    mends(
        content,
        &[
            "no column",
            "--time Time ",
            "--input F_cmd:N",
            "--position x:m",
            "--command Ref:m",
        ],
    );
}

#[test]
fn headers() {
    let body = |header: &str| log().replacen(HEADER, header, 1);
    let milliseconds = changed("t,u,x,soll", |row, fields| {
        format!("{row},{}", fields[1..].join(","))
    });
    mends(milliseconds, &["no column", "--time t:ms"]);
    mends(
        body("t,u,x,soll"),
        &["no column `time_s`, `input`, `position`", "--command soll"],
    );
    mends(
        body("Time,input,position,command"),
        &["\"Time\"", "--time Time"],
    );
    mends(
        body("time_s,input,winkel [rad],command"),
        &["\"winkel [rad]:rad\""],
    );
    mends(body("a,b,c,d"), &["--time a --input b --position c"]);
    mends(
        body("time_s,input,position,position"),
        &["twice", "--position position"],
    );
    let without = log().split_once('\n').unwrap().1;
    mends(
        without,
        &[
            "numbers, not column names",
            "--time 1 --input 2 --position 3",
        ],
    );
}

#[test]
fn layouts() {
    let semicolons = log().replace(',', ";");
    mends(&semicolons, &["separate the fields by commas"]);
    mends(
        semicolons.replace('.', ","),
        &["separate the fields by commas"],
    );
    let rows = |row: usize, fields: &[&str]| {
        let _ = row;
        // As a program with a German locale prints them into a CSV.
        let numbers = fields
            .iter()
            .map(|field| format!("{:.6}", field.parse::<f64>().unwrap()));
        numbers
            .map(|number| number.replace('.', ","))
            .collect::<Vec<_>>()
            .join(",")
    };
    mends(changed(HEADER, rows), &["8 fields", "decimal commas"]);
    mends(format!("made by a logger\n\n{}", log()), &["no column"]);
    let text = format!("{}\n", log().replacen("command", "command °", 1));
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    mends(latin, &["not UTF-8"]);
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(log().as_bytes()).expect("memory");
    mends(packed.finish().expect("memory"), &["packed by gzip"]);
}

#[test]
fn cells() {
    let with = |at: usize, replacement: &'static str| {
        changed(HEADER, move |row, fields| match row {
            row if row == at => replacement.replace('T', fields[0]),
            _ => fields.join(","),
        })
    };
    mends(with(700, "T,nan,0,0"), &["`input`", "nan", "--skip-bad"]);
    mends(with(700, "T,,0,0"), &["is empty", "--skip-bad"]);
    mends(with(700, "T,1"), &["cut short", "--skip-bad"]);
    mends(with(700, "T,1e39,0,0"), &["single precision", "--skip-bad"]);
    mends(with(700, "T,0,1e12,0"), &["no machine", "--skip-bad"]);
    let braked = changed("time_s,input,position,brake", |_, fields| {
        format!("{},{},{},-2.5", fields[0], fields[1], fields[2])
    });
    mends(braked, &["`brake`", "\"brake*-1\""]);
    let state = changed("time_s,input,position,enabled", |_, fields| {
        format!("{},{},{},8", fields[0], fields[1], fields[2])
    });
    mends(state, &["`enabled` is 8"]);
}

#[test]
fn times() {
    let timed = |stamp: &dyn Fn(usize, f64) -> String| {
        changed(HEADER, |row, fields| {
            let stamp = stamp(row, fields[0].parse().unwrap());
            if stamp.is_empty() {
                stamp
            } else {
                format!("{stamp},{}", fields[1..].join(","))
            }
        })
    };
    // The clock starts again after a second.
    let again = timed(&|row, t| format!("{:.4}", if row < 1_000 { t } else { t - 1.0 }));
    mends(
        again,
        &["earlier than that of line 1001", "--lines 1002-3001"],
    );
    // The clock is set back by a fifth of a second: no row that comes then belongs among those before.
    let back = timed(&|row, t| format!("{:.4}", if row < 1_200 { t } else { t - 0.2 }));
    mends(
        back,
        &["earlier than that of line 1201", "--lines 1202-3001"],
    );
    let swapped = timed(&|row, t| match row % 500 {
        3 => format!("{:.4}", t + 1e-3),
        4 => format!("{:.4}", t - 1e-3),
        _ => format!("{t:.4}"),
    });
    mends(swapped, &["earlier", "--sort"]);
    let gap = timed(&|row, t| match row {
        1_200..1_600 => String::new(),
        _ => format!("{t:.4}"),
    });
    mends(
        gap,
        &[
            "middle of motion",
            "cut the log here and give both parts: cargo hil import",
            "--lines 2-1201 --out \"my log-corrected.csv\" && cargo hil import",
            "--lines 1202-2601 --out \"my log-corrected-2.csv\"",
        ],
    );
    let coarse = timed(&|_, t| format!("{t:.2}"));
    mends(coarse, &["more digits", "--rate 1000"]);
    // Stamps that scatter, a few or a third of them into the row before: the rows are even all the same.
    for most in [0.6, 0.8, 1.5] {
        let scattered = timed(&|row, t| {
            let drawn = ((row * row * 31 + row * 17) % 1009) as f64 / 1009.0;
            format!("{:.6}", t + 2e-3 * most * (drawn - 0.5))
        });
        mends(
            scattered,
            &["earlier", "\"my log.csv\" --input input ", "--rate 1000 "],
        );
    }
    for (unit, written) in [("us", 0_u64), ("ns", 0), ("ns", 1_764_460_800_000_000_000)] {
        let a_second = if unit == "us" { 1e6 } else { 1e9 };
        let stamps = timed(&|_, t| (written + (t * a_second).round() as u64).to_string());
        let blamed = "my log.csv:3: `time_s` steps by ";
        mends(stamps, &[blamed, &format!("--time time_s:{unit} ")]);
    }
    let days = timed(&|_, t| format!("{:.16}", t * 1e-7 / 86.4));
    mends(days, &["expected seconds", "time_s:day"]);
    // Twenty samples a millisecond apart, then none for a fifth of a second, at rest or not.
    let bursts = timed(&|row, t| {
        if row < 300 || row % 20 == 0 {
            format!("{t:.4}")
        } else {
            String::new()
        }
    });
    let output = Place::with("a.csv", &bursts);
    output.write("machine.toml", Machine::force_slide().to_toml());
    output.refuses(
        "gap --machine machine.toml --train a.csv",
        &["more samples would have to be filled in", "--rate 50 "],
    );
}

/// Stamps with a clock, under the log's own name and others; and what is a share or a count of something says of what.
#[test]
fn clocks_and_shares() {
    let stamped = |header: &str, separator: &str| {
        changed(header, |row, fields| {
            let clock = format!("06:29:{:02}.{:03}", 50 + row / 1000, row % 1000);
            let numbers = fields[1..].join(separator);
            format!("2026-11-27T{clock}Z{separator}{numbers}")
        })
    };
    mends(
        stamped(HEADER, ","),
        &[
            "`time_s` is \"2026-11-27T06:29:50.000Z\"",
            "--time time_s --input",
        ],
    );
    mends(
        stamped("Zeitstempel;Motor;Weg;Soll", ";"),
        &["--time Zeitstempel --input Motor --position Weg"],
    );
    mends(
        log().replacen(HEADER, "time_s,Duty (%),pos [counts],command", 1),
        &[
            "put the volts of the supply in place of the 1 of \"Duty (%):%*1\"",
            "put the size of a count, in rad or m, in place of the 1 of \"pos [counts]:counts*1\"",
        ],
    );
    // Whole numbers may be either, as far as they stay small: a PWM's are counts first.
    let whole = changed(&HEADER.replacen("input", "pwm", 1), |_, fields| {
        let input: f64 = fields[1].parse().unwrap();
        format!(
            "{},{:.0},{},{}",
            fields[0],
            4.0 * input,
            fields[2],
            fields[3]
        )
    });
    mends(
        whole,
        &[
            "put the volts of the supply in place of the 1 of \"pwm/255:duty*1\"",
            "if that is 100, it is \"pwm:%*1\"",
        ],
    );
}

/// A current in milliamperes is none that may be left out in silence, nor read as one in amperes.
#[test]
fn a_current_of_another_name_is_not_left_out() {
    for name in ["current_ma", "i_ma", "cur_ma", "motor_current_ma"] {
        mends(
            log().replacen("command", name, 1),
            &[
                &format!("the column \"{name}\" looks like the motor's current"),
                &format!("--current {name}:ma"),
            ],
        );
    }
}

/// Words are no numbers: a call that left out all rows that have them would leave out most rows.
#[test]
fn what_would_leave_out_most_rows_is_no_call() {
    let words = changed(HEADER, |row, fields| {
        let time = if row < 500 { fields[0] } else { "\"a second\"" };
        format!("{time},{}", fields[1..].join(","))
    });
    let place = Place::with("bad.csv", words);
    place.write("machine.toml", Machine::force_slide().to_toml());
    let error = place
        .run("gap --machine machine.toml --train bad.csv")
        .stderr;
    assert!(text(&error).contains("`time_s`"), "{}", text(&error));
    assert!(
        !text(&error).contains("cargo hil import"),
        "{}",
        text(&error)
    );
}

/// Nothing is printed that would not help.
#[test]
fn what_no_import_mends_has_no_call() {
    for content in ["", "time_s,input,position\n", "hello\n", "a,b\n1,2\n3,4\n"] {
        let place = Place::with("bad.csv", content);
        place.write("machine.toml", Machine::force_slide().to_toml());
        let error = place
            .run("gap --machine machine.toml --train bad.csv")
            .stderr;
        assert!(
            text(&error).starts_with("error: bad.csv"),
            "{}",
            text(&error)
        );
        assert!(
            !text(&error).contains("cargo hil import"),
            "{}",
            text(&error)
        );
    }
}

/// A validation log that is slower than the training log: that one is brought to its rate.
#[test]
fn rates_that_differ() {
    let place = Place::with("fast.csv", log());
    place.write("machine.toml", Machine::force_slide().to_toml());
    let slow = changed(HEADER, |row, fields| match row % 4 {
        0 => fields.join(","),
        _ => String::new(),
    });
    place.write("slow.csv", slow);
    let gap = "gap --machine machine.toml --validate slow.csv --train";
    place.refuses(
        &format!("{gap} fast.csv"),
        &["slow.csv: ", "import fast.csv", "--rate 250 "],
    );
    let error = place.run(&format!("{gap} fast.csv")).stderr;
    let error = text(&error).trim_end();
    place.follow(&error[error.find("cargo hil import").unwrap()..]);
    assert!(
        place
            .run(&format!("{gap} fast-corrected.csv"))
            .status
            .success()
    );
}

/// A log in millimetres, and one that reads 0 to 360 degrees: the remedy makes both agree.
#[test]
fn what_log_and_machine_disagree_in() {
    let millimetres = changed(HEADER, |_, fields| {
        let scaled = |field: &str| 1e3 * field.parse::<f64>().unwrap();
        format!(
            "{},{},{},{}",
            fields[0],
            fields[1],
            scaled(fields[2]),
            scaled(fields[3])
        )
    });
    let place = Place::with("mm.csv", millimetres);
    place.write("machine.toml", Machine::force_slide().to_toml());
    assert_eq!(verdict(&place, "mm.csv"), "log_and_machine_disagree");
    let json = fs::read_to_string(place.path("gap.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let remedies = json["disagreement"].as_array().unwrap();
    place.follow(remedies[0]["remedy"].as_str().unwrap());
    let mended = verdict(&place, "mm-corrected.csv");
    assert_ne!(mended, "log_and_machine_disagree");
}
