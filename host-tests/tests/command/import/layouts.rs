//! How a text may be laid out and encoded.

use super::*;

fn value(k: usize) -> (f64, f64, f64) {
    let t = k as f64 * 2e-3;
    (t, (3.0 * t).sin(), (5.0 * t).cos())
}

fn reference() -> Log {
    let place = Place::with(
        "raw.csv",
        rows("t,u,x", 250, |k| {
            let (t, u, x) = value(k);
            format!("{t:.3},{u:.6},{x:.6}")
        }),
    );
    place.import("raw.csv --time t --input u --position x").0
}

#[track_caller]
fn reads(name: &str, content: impl AsRef<[u8]>, options: &str, said: &str) {
    let place = Place::with(name, content);
    let (log, printed) = place.import(&format!("{name} --time t --input u --position x{options}"));
    let reference = reference();
    assert_eq!(log.period_s, reference.period_s);
    assert_eq!(log.input, reference.input);
    assert_eq!(log.position, reference.position);
    assert!(printed.contains(said), "{printed}");
}

fn written(header: &str, delimiter: &str, comma: bool) -> String {
    rows(header, 250, |k| {
        let (t, u, x) = value(k);
        let row = [format!("{t:.3}"), format!("{u:.6}"), format!("{x:.6}")].join(delimiter);
        if comma { row.replace('.', ",") } else { row }
    })
}

#[test]
fn delimiters_decimal_commas_and_preambles_are_found() {
    reads(
        "a.csv",
        written("t;u;x", ";", true),
        "",
        "semicolons, decimal commas",
    );
    reads(
        "a.csv",
        written("t\tu\tx", "\t", true),
        "",
        "tabs, decimal commas",
    );
    reads(
        "a.txt",
        written("# t  u  x", "  ", false),
        "",
        "spaces, names in line 1",
    );
    reads(
        "a.csv",
        written("t,u,x", ",", true),
        "",
        "commas, decimal commas",
    );
    reads(
        "a.csv",
        format!("\u{feff}{}", written("t,u,x", ",", false)),
        "",
        "commas",
    );
    let preamble = "Logger 7\nStart: 1.2.2026\n\nt;u;x\n[s];[V];[rad]";
    reads(
        "a.csv",
        written(preamble, ";", true),
        "",
        "names in line 4, units in line 5",
    );
    let commented = "% by a logger\n% 3 channels\nt,u,x";
    reads(
        "a.csv",
        written(commented, ",", false),
        "",
        "names in line 3",
    );
}

#[test]
fn a_layout_can_be_set() {
    reads(
        "a.csv",
        written("t/u/x", "/", false),
        " --delimiter /",
        "apart by `/`",
    );
    let two = "t,u,x\na,b,c";
    reads(
        "a.csv",
        written(two, ",", false).replace("a,b,c\n", ""),
        " --header 1",
        "line 1",
    );
    let odd = written("t,u,x\n@ pause", ",", false);
    reads("a.csv", odd, " --comment @", "1 comment line left out");
    let place = Place::with("a.csv", written("t,u,x", ",", false));
    place.refuses(
        "import a.csv --time t --input u --position x --delimiter ab --out log.csv",
        &["--delimiter", "one character"],
    );
}

#[test]
fn encodings_and_gzip_are_found() {
    let text = written("# Winkel in °\nt;u;x", ";", true).replace('\n', "\r\n");
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    reads("a.csv", latin, "", "Latin-1");
    let mut wide = vec![0xff, 0xfe];
    wide.extend(text.encode_utf16().flat_map(u16::to_le_bytes));
    reads("a.csv", wide, "", "UTF-16");
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(text.as_bytes()).expect("memory");
    let packed = packed.finish().expect("memory");
    reads("a.csv.gz", &packed, "", "gzip, ");
    let place = Place::with("a.csv.gz", &packed[..packed.len() / 2]);
    place.refuses(
        "import a.csv.gz --time t --input u --position x --out log.csv",
        &["cut short or damaged gzip"],
    );
}

#[test]
fn standard_input_is_read() {
    let place = Place::new();
    let mut child = place
        .command("import - --time t --input u --position x --out log.csv")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("hil starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    stdin
        .write_all(written("t;u;x", ";", true).as_bytes())
        .expect("a reader");
    drop(stdin);
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.success());
    assert!(text(&output.stdout).starts_with("standard input: "));
    let log = Log::read(&place.path("log.csv")).expect("a log");
    assert_eq!(log.position, reference().position);
}

#[test]
fn a_row_with_a_quotation_mark_that_is_not_closed_is_refused_or_left_out() {
    let content = rows("t,u,x", 250, |k| {
        let (t, u, x) = value(k);
        let mark = if k == 100 { "\"" } else { "" };
        format!("{t:.3},{mark}{u:.6},{x:.6}")
    });
    let place = Place::with("raw.csv", content);
    let call = "raw.csv --time t --input u --position x";
    place.refuses(
        &format!("import {call} --out log.csv"),
        &["quotation mark", "not closed", "--skip-bad"],
    );
    let (_, printed) = place.import(&format!("{call} --skip-bad"));
    assert!(printed.contains("1 row"), "{printed}");
}

/// One that opens a field; the sign of an inch does not.
#[test]
fn a_header_with_a_quotation_mark_that_is_not_closed_is_refused() {
    let with = |header: &str| {
        rows(header, 250, |k| {
            let (t, u, x) = value(k);
            format!("{t:.3},{u:.6},{x:.6},0.5")
        })
    };
    let call = "raw.csv --time 1 --input 2 --position 3 --out log.csv";
    for header in ["t,u,x,\"i", "\"t,u,x,i"] {
        let place = Place::with("raw.csv", with(header));
        place.refuses(
            &format!("import {call}"),
            &["raw.csv:1", "quotation mark", "not closed"],
        );
    }
    let place = Place::with("raw.csv", with("t,u,weg [\"],i"));
    assert!(place.run(&format!("import {call}")).status.success());
}

#[test]
fn a_sample_that_stands_alone_is_said_with_its_line() {
    let content = rows("t,u,x", 250, |k| {
        let (t, u, x) = value(k);
        let x = if k == 100 { 50.0 } else { x };
        format!("{t:.3},{u:.6},{x:.6}")
    });
    let place = Place::with("raw.csv", content);
    let output = place.run("import raw.csv --time t --input u --position x --out log.csv");
    assert_eq!(output.status.code(), Some(0));
    let warning = text(&output.stderr);
    assert!(
        warning.starts_with("warning: raw.csv:102: `position` is 50.0"),
        "{warning}"
    );
}

/// What loggers of many kinds write, each of the same motion: settings above the table, names in front of values, thousands apart,
/// wide characters without a mark.
#[test]
fn tables_of_many_loggers_are_read() {
    let row = |form: &dyn Fn(f64, f64, f64) -> String| {
        let rows: Vec<String> = (0..250)
            .map(|k| {
                let (t, u, x) = value(k);
                form(t, u, x)
            })
            .collect();
        rows.join("\n") + "\n"
    };
    let plain = row(&|t, u, x| format!("{t:.3},{u:.6},{x:.6}"));
    reads(
        "scope.csv",
        "Model,DSO-4\nMemory,250\nSource,CH1,CH2\nProbe,10,1\nVertical Units,V,V\nVertical Scale,2,1\n\
         Vertical Offset,0,0\nSample Interval,0.002\nTrigger Level,1.2\nDate,2026-11-12\nNote,\"bench, left\"\n\n\
         t,u,x\n(s),(V),(V)\n"
            .to_owned()
            + &plain,
        "",
        "names in line 13, units in line 14",
    );
    reads(
        "lab.lvm",
        "LabVIEW Measurement\t\nDecimal_Separator\t.\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t250\t250\t\n\
         Date\t2026/11/12\t2026/11/12\t\nX0\t0.0E+0\t0.0E+0\t\nDelta_X\t2.0E-3\t2.0E-3\t\n***End_of_Header***\t\t\t\n\
         t\tu\tx\tComment\n"
            .to_owned()
            + &row(&|t, u, x| format!("{t:.3}\t{u:.6}\t{x:.6}\t")),
        "",
        "names in line 11",
    );
    for labelled in [
        row(&|t, u, x| format!("t:{t:.3}\tu:{u:.6}\tx:{x:.6}")),
        row(&|t, u, x| format!("t={t:.3} u={u:.6} x={x:.6}")),
        row(&|t, u, x| format!("{{\"t\":{t:.3},\"u\":{u:.6},\"x\":{x:.6}}}")),
    ] {
        reads("plotter.txt", labelled, "", "a name in front of each value");
    }
    let wide = row(&|t, u, x| format!("{t:.3}\t{u:.6}\t{x:.6}"));
    let wide = format!("t\tu\tx\n{wide}");
    let wide: Vec<u8> = wide.encode_utf16().flat_map(u16::to_le_bytes).collect();
    reads("wide.txt", wide, "", "UTF-16, fields apart by tabs");
    reads(
        "empty.csv",
        "t,u,x,,,\n".to_owned() + &plain.replace('\n', ",,,\n"),
        "",
        "commas",
    );
}

/// Microseconds with their thousands apart, as a spreadsheet shows them: in English, in German, in Swiss and with spaces.
#[test]
fn thousands_apart_are_read() {
    for (separator, decimal) in [(',', '.'), ('.', ','), ('\'', '.'), ('\u{202f}', ',')] {
        let grouped = |number: i64| {
            let digits = number.abs().to_string();
            let grouped = digits.bytes().enumerate().map(|(at, digit)| {
                let apart = at > 0 && (digits.len() - at).is_multiple_of(3);
                let apart = if apart {
                    separator.to_string()
                } else {
                    String::new()
                };
                format!("{apart}{}", char::from(digit))
            });
            let sign = if number < 0 { "-" } else { "" };
            format!("{sign}{}", grouped.collect::<String>())
        };
        let raw = rows("\"t\";\"u\";\"x\"", 400, |k| {
            let milli = (9_000.0 * (0.05 * k as f64).sin()).round() as i64;
            format!(
                "\"{}\";\"{}\";\"{}{decimal}5\"",
                grouped(5_000 * k as i64),
                grouped(milli),
                grouped(30 * k as i64)
            )
        });
        let place = Place::with("raw.csv", raw);
        let (log, _) = place.import("raw.csv --time t:us --input u:mV --position x:mrad");
        assert_eq!((log.samples(), log.period_s), (400, 5e-3), "{separator}");
        near(&log.input, |k| {
            1e-3 * (9_000.0 * (0.05 * k as f64).sin()).round()
        });
        near(&log.position, |k| 1e-3 * (30.0 * k as f64 + 0.5));
    }
}

/// The time of a ROS message: whole seconds, and nanoseconds beside them.
#[test]
fn seconds_and_nanoseconds_are_one_time() {
    let raw = rows("header.stamp.secs,header.stamp.nsecs,u,x", 400, |k| {
        let nanoseconds = 900_000_000 + 5_000_000 * k;
        let (secs, nsecs) = (nanoseconds / 1_000_000_000, nanoseconds % 1_000_000_000);
        format!("{},{nsecs},{},{}", 1_790_000_000 + secs, k % 7, k)
    });
    let place = Place::with("raw.csv", raw);
    let (log, said) = place.import("raw.csv --time header.stamp.secs --input u --position x");
    assert_eq!((log.samples(), log.start_s), (400, 0.0));
    assert!((log.period_s / 5e-3 - 1.0).abs() < 1e-6, "{}", log.period_s);
    let sentence = "header.stamp.secs with what header.stamp.nsecs has of its seconds";
    assert!(said.contains(sentence), "{said}");
}
