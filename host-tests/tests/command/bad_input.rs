//! Promise: bad input is named by file and line with what was expected, good input is read, and
//! nothing panics.

use std::fs;
use std::path::{Path, PathBuf};

use host_tests::error::InputError;
use host_tests::exercise;
use host_tests::log::Log;
use host_tests::machine::{Coordinate, Machine, SensorSide};
use proptest::prelude::*;
use tempfile::TempDir;

/// A directory with one file in it, both gone when dropped.
struct Given {
    _directory: TempDir,
    path: PathBuf,
}

fn given(name: &str, content: impl AsRef<[u8]>) -> Given {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let path = directory.path().join(name);
    fs::write(&path, content).expect("a writable temporary directory");
    Given {
        _directory: directory,
        path,
    }
}

/// Asserts where the error is, that it is one line, and that it says these words.
#[track_caller]
fn assert_error(error: &InputError, file: &Path, line: Option<usize>, words: &[&str]) {
    let shown = error.to_string();
    assert_eq!(error.file, file, "{shown}");
    assert_eq!(error.line, line, "{shown}");
    let place = match line {
        Some(line) => format!("{}:{line}: ", file.display()),
        None => format!("{}: ", file.display()),
    };
    assert_eq!(shown.strip_prefix(&place), Some(&*error.message));
    assert!(!shown.contains(char::is_control), "{shown:?}");
    for word in words {
        assert!(error.message.contains(word), "no {word:?} in: {shown}");
    }
}

mod log {
    use super::*;

    const HEADER: &str = "time_s,input,position";

    /// A 1 kHz log of 200 rows below `HEADER`: row `i`, counted from 0, is line `i + 2`.
    fn rows() -> Vec<String> {
        (0..200)
            .map(|i| {
                format!(
                    "{:.4},{},{}",
                    f64::from(i) * 1e-3,
                    i % 7,
                    f64::from(i) * 0.5
                )
            })
            .collect()
    }

    fn text(header: &str, rows: &[String]) -> String {
        format!("{header}\n{}\n", rows.join("\n"))
    }

    /// The log with the time stamps of `time`, printed in full.
    fn timed(time: impl Fn(usize) -> f64) -> String {
        let rows: Vec<String> = (0..200).map(|i| format!("{:?},0,0", time(i))).collect();
        text(HEADER, &rows)
    }

    #[track_caller]
    fn read(content: impl AsRef<[u8]>) -> Log {
        let file = given("log.csv", content);
        Log::read(&file.path).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn refused(content: impl AsRef<[u8]>, line: usize, words: &[&str]) {
        let file = given("log.csv", content);
        let error = Log::read(&file.path).expect_err("a bad log");
        assert_error(&error, &file.path, Some(line), words);
    }

    /// Refused when row `row` is replaced, at that row's line.
    #[track_caller]
    fn row_refused(row: usize, replacement: &str, words: &[&str]) {
        let mut rows = rows();
        rows[row] = replacement.into();
        refused(text(HEADER, &rows), row + 2, words);
    }

    #[test]
    fn a_good_log_is_read() {
        let log = read(text(HEADER, &rows()));
        assert_eq!(log.samples(), 200);
        assert_eq!(log.start_s, 0.0);
        assert_eq!(log.period_s, 1e-3);
        assert_eq!(log.input[9], 2.0);
        assert_eq!(log.position[199], 99.5);
        assert_eq!((log.command, log.current, log.velocity), (None, None, None));
        assert_eq!(log.brake, None);
    }

    #[test]
    fn columns_stand_in_any_order_among_others() {
        let rows: Vec<String> = (0..100)
            .map(|i| format!("{i},4,x,3,{},2,1", f64::from(i) * 0.01))
            .collect();
        let log = read(text(
            "position,current_a,remark,velocity,time_s,command,input",
            &rows,
        ));
        assert_eq!(log.period_s, 0.01);
        assert_eq!(log.position[99], 99.0);
        assert_eq!(log.input, [1.0; 100]);
        assert_eq!(log.command, Some(vec![2.0; 100]));
        assert_eq!(log.velocity, Some(vec![3.0; 100]));
        assert_eq!(log.current, Some(vec![4.0; 100]));
    }

    #[test]
    fn layout_does_no_harm() {
        let plain = read(text(HEADER, &rows()));
        let clean = text(HEADER, &rows());
        let spaced = clean.replace(',', " , \t");
        let blank_lines = clean.replace('\n', "\n\n  \n");
        for variant in [
            format!("\u{feff}{clean}"),
            clean.replace('\n', "\r\n"),
            clean.replace('\n', "\r"),
            spaced,
            blank_lines,
            clean.trim_end().to_owned(),
        ] {
            let mut log = read(variant);
            log.path.clone_from(&plain.path);
            assert_eq!(log, plain);
        }
    }

    #[test]
    fn the_wrong_file_is_refused() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let error = Log::read(directory.path()).expect_err("a directory");
        assert_error(&error, directory.path(), None, &["directory", "CSV"]);
        let absent = directory.path().join("absent.csv");
        let error = Log::read(&absent).expect_err("no file");
        assert_error(&error, &absent, None, &["no such file", "CSV"]);

        refused("", 1, &["empty", "time_s"]);
        refused("\n \n\n", 1, &["empty"]);
        refused(b"\x7fELF\x02\x01\x01\xff\xfe", 1, &["UTF-8"]);
        let mut binary = text(HEADER, &rows()).into_bytes();
        let line_5 = text(HEADER, &rows()[..3]).len();
        binary[line_5 + 2] = 0x80;
        refused(binary, 5, &["UTF-8"]);
        refused(b"\0\0\0\n\0\0", 1, &["no column", "`time_s`"]);
    }

    #[test]
    fn a_bad_header_is_refused() {
        refused(
            text("time_s,input,x", &rows()),
            1,
            &["`position`", "expected", "cargo hil import"],
        );
        refused(
            text("t,u,y", &rows()),
            1,
            &["`time_s`, `input`, `position`"],
        );
        refused(format!("\n\n{}", text("t,u,y", &rows())), 3, &["no column"]);
        refused(rows().join("\n"), 1, &["numbers, not column names"]);
        refused(
            text(HEADER, &rows()).replace(',', ";"),
            1,
            &["separate the fields by commas"],
        );
        refused(
            text("time_s,input,position,input", &rows()),
            1,
            &["\"input\"", "twice"],
        );
        refused(
            text("Time,input,position", &rows()),
            1,
            &["\"Time\"", "`time_s`"],
        );
        refused(
            text("time_s,input,position,current", &rows()),
            1,
            &["\"current\"", "`current_a`"],
        );
    }

    #[test]
    fn a_short_log_is_refused() {
        refused(HEADER, 1, &["0 samples", "at least 171"]);
        refused(
            text(HEADER, &rows()[..1]),
            2,
            &["1 sample,", "at least 171"],
        );
        refused(text(HEADER, &rows()[..99]), 100, &["99 samples"]);
        assert_eq!(read(text(HEADER, &rows()[..100])).samples(), 100);
    }

    #[test]
    fn a_bad_row_is_refused() {
        row_refused(40, "0.0400,1", &["2 fields", "3", "cut short"]);
        row_refused(199, "0.19", &["1 field,", "cut short"]);
        row_refused(40, "0,0400,1,0", &["4 fields", "decimal commas"]);
        row_refused(40, "0.0400,volt,0", &["`input`", "\"volt\"", "a number"]);
        row_refused(40, "0.0400,1 V,0", &["`input`", "\"1 V\""]);
        row_refused(40, "0.0400,1,", &["`position`", "empty"]);
        row_refused(40, "0.0400,1,nan", &["`position`", "\"nan\"", "finite"]);
        row_refused(40, "0.0400,-inf,1", &["`input`", "\"-inf\"", "finite"]);
        row_refused(40, "0.0400,1,1e39", &["`position`", "\"1e39\"", "finite"]);
        row_refused(40, "NaN,1,1", &["`time_s`", "\"NaN\""]);
        let long = format!("0.0400,{},1", "z\u{7}".repeat(1000));
        row_refused(40, &long, &["`input`", "z\\u{7}z", "…"]);
        // An opened quotation mark swallows the rest of the file.
        row_refused(40, "0.0400,\"1,1", &["2 fields"]);
    }

    #[test]
    fn an_optional_column_is_checked_and_an_unknown_one_is_not() {
        let mut rows: Vec<String> = rows().into_iter().map(|row| row + ",1").collect();
        rows[10] = rows[10].replace(",1", ",NaN");
        refused(
            text("time_s,input,position,current_a", &rows),
            12,
            &["`current_a`", "NaN"],
        );
        read(text("time_s,input,position,temperature", &rows));
    }

    #[test]
    fn a_brake_that_would_push_is_refused() {
        let mut rows: Vec<String> = rows().into_iter().map(|row| row + ",0.5").collect();
        assert_eq!(
            read(text("time_s,input,position,brake", &rows)).brake,
            Some(vec![0.5; 200])
        );
        for (level, words) in [
            ("-0.1", ["`brake`", "-0.1", "0 or more"]),
            ("inf", ["`brake`", "\"inf\"", "finite"]),
            ("NaN", ["`brake`", "\"NaN\"", "finite"]),
        ] {
            rows[10] = format!("0.0100,1,1,{level}");
            refused(text("time_s,input,position,brake", &rows), 12, &words);
        }
    }

    #[test]
    fn the_line_is_that_of_the_file() {
        let mut rows = rows();
        rows[40] = "0.0400,x,0".into();
        let plain = text(HEADER, &rows);
        refused(plain.replace('\n', "\r\n"), 42, &["\"x\""]);
        refused(plain.replace('\n', "\r"), 42, &["\"x\""]);
        refused(plain.replace('\n', "\n\n"), 83, &["\"x\""]);
        refused(plain.replace('\n', "\r\n \r\n\r\n"), 124, &["\"x\""]);
    }

    #[test]
    fn time_that_runs_backwards_is_refused() {
        let words = ["0.038", "earlier", "line 41", "cargo hil import"];
        row_refused(40, "0.0380,1,1", &words);
        row_refused(40, "-5,1,1", &["-5", "earlier", "line 41"]);
    }

    #[test]
    fn repeated_rows_are_merged() {
        // Each third row written twice: nothing is lost, and nothing moved.
        let twice: Vec<String> = rows()
            .into_iter()
            .enumerate()
            .flat_map(|(row, text)| vec![text; if row % 3 == 0 { 2 } else { 1 }])
            .collect();
        let mut log = read(text(HEADER, &twice));
        let resampling = log.resampling.take().expect("merged rows");
        assert_eq!((resampling.merged, resampling.rows), (67, 267));
        assert_eq!((resampling.filled, resampling.position_error), (0, 0.0));
        let plain = read(text(HEADER, &rows()));
        log.path.clone_from(&plain.path);
        assert_eq!(log, plain);

        // A row written again with another position: each of the two is one from their mean, and the sensor's step is
        // still that of its readings.
        let mut again = rows();
        let (time, rest) = again[40].split_once(',').expect("fields");
        let (input, position) = rest.split_once(',').expect("fields");
        let position: f64 = position.parse().expect("a number");
        again.insert(41, format!("{time},{input},{}", position + 2.0));
        let log = read(text(HEADER, &again));
        let resampling = log.resampling.expect("a merged row");
        assert_eq!((resampling.merged, resampling.filled), (1, 0));
        let expected = (2.0_f64 / 200.0).sqrt();
        assert!((resampling.position_error / expected - 1.0).abs() < 1e-9);
        assert_eq!(log.position_step(), plain.position_step());

        // A stamp that repeats the last one, with other values: their mean, then a gap.
        let mut one = rows();
        one[40] = "0.0390,9,21.5".into();
        let log = read(text(HEADER, &one));
        let resampling = log.resampling.expect("a merged row");
        assert_eq!((resampling.merged, resampling.filled), (1, 1));
        assert_eq!(log.samples(), 200);
        assert_eq!(log.position[38..42], [19.0, 20.5, 20.5, 20.5]);
        // The first of the two held for no time, the second until the next row.
        assert_eq!(log.input[38..42], [3.0, 9.0, 9.0, 6.0]);

        // Many of them are stamps without their digits.
        let coarse: Vec<String> = (0..200)
            .map(|i| format!("{:.2},0,{i}", f64::from(i) * 5e-3))
            .collect();
        refused(
            text(HEADER, &coarse),
            4,
            &["repeats that of line 3", "more digits"],
        );
    }

    #[test]
    fn a_small_gap_is_filled_wherever_it_is() {
        let plain = read(text(HEADER, &rows()));
        for first_missing in [2, 40, 100, 190, 198] {
            let mut rows = rows();
            rows.remove(first_missing);
            let mut log = read(text(HEADER, &rows));
            let resampling = log.resampling.take().expect("a filled sample");
            assert_eq!((resampling.filled, resampling.merged), (1, 0));
            assert!(resampling.displacement_max < 1e-9, "{resampling:?}");
            for (sample, filled) in std::mem::take(&mut log.filled).iter().enumerate() {
                assert_eq!(*filled, sample == first_missing, "{sample}");
            }
            // What the drive had been told still held.
            assert_eq!(log.input[first_missing], plain.input[first_missing - 1]);
            log.path.clone_from(&plain.path);
            log.input.clone_from(&plain.input);
            assert_eq!(log, plain);
        }
        // Printed no finer than the period.
        let mut rows: Vec<String> = (0..200).map(|i| format!("{i},0,0")).collect();
        rows.remove(100);
        let log = read(text(HEADER, &rows));
        assert_eq!((log.period_s, log.samples()), (1.0, 200));
    }

    #[test]
    fn a_long_gap_is_refused_in_motion_and_filled_at_rest() {
        let with_gap = |gap_s: f64, position: &dyn Fn(f64) -> f64| {
            let rows: Vec<String> = (0..2_000)
                .map(|i| f64::from(i) * 1e-3 + if i >= 1_000 { gap_s } else { 0.0 })
                .map(|t| format!("{t:.4},0,{}", position(t)))
                .collect();
            text(HEADER, &rows)
        };
        let moving = |t: f64| (3.0 * t).sin();
        let resting = |t: f64| (t.min(0.5) + (t - 1.9).max(0.0)) * 0.7;
        assert_eq!(read(with_gap(0.19, &moving)).samples(), 2_190);
        assert_eq!(read(with_gap(0.6, &resting)).samples(), 2_600);
        let words = [
            "a gap of 250 samples",
            "motion",
            "0.2 s",
            "cargo hil import",
        ];
        refused(with_gap(0.25, &moving), 1_002, &words);
        // More than the log itself has, even at rest.
        let words = ["a gap of 3000 samples", "more samples", "--lines 2-1001"];
        refused(with_gap(3.0, &|t| t.min(0.5)), 1_002, &words);
        refused(
            timed(|i| i as f64 * 1e-3 + if i >= 60 { 5.0 } else { 0.0 }),
            62,
            &["a gap of 5000 samples"],
        );
    }

    #[test]
    fn jitter_up_to_one_percent_is_left_and_beyond_resampled() {
        // Stamps that scatter to either side of the grid, the hardest way last.
        let scatter =
            |share: f64| timed(move |i| (i as f64 + share * (i as f64 * 2.4).sin()) * 1e-3);
        let alternate = |share: f64| {
            timed(move |i| (i as f64 + if i % 2 == 0 { share } else { -share }) * 1e-3)
        };
        let one_off =
            |share: f64| timed(move |i| (i as f64 + if i == 70 { share } else { 0.0 }) * 1e-3);
        for accepted in [0.0, 0.001, 0.0099] {
            for log in [scatter(accepted), alternate(accepted), one_off(accepted)] {
                let log = read(log);
                assert!((log.period_s / 1e-3 - 1.0).abs() < 1e-4, "{}", log.period_s);
                assert_eq!(log.resampling, None);
            }
        }
        for share in [-0.015, 0.015, 0.1, -0.4] {
            let log = read(one_off(share));
            assert_eq!((log.period_s, log.samples()), (1e-3, 200));
            let resampling = log.resampling.expect("a moved stamp");
            assert!((resampling.displacement_max / share.abs() - 1.0).abs() < 0.05);
        }
        for log in [scatter(0.03), alternate(0.015), scatter(0.3)] {
            let log = read(log);
            assert_eq!(log.period_s, 1e-3);
            let resampling = log.resampling.expect("moved stamps");
            assert_eq!(
                (resampling.filled, resampling.merged),
                (0, 0),
                "{resampling:?}"
            );
        }
        // One off by the last digit printed, which is a tenth of the period.
        let mut rows = rows();
        rows[40] = "0.0401,1,20".into();
        let log = read(text(HEADER, &rows));
        // Between the rows at 40.1 and 39 ms, which have 20 and 19.5.
        assert!((log.position[40] - (19.5 + 0.5 / 1.1)).abs() < 1e-9);
    }

    #[test]
    fn two_rates_are_brought_to_the_usual_one() {
        // 1 kHz, in the middle 500 Hz.
        let stamps = (0..200)
            .map(f64::from)
            .filter(|i| !(80.0..120.0).contains(i) || i % 2.0 == 0.0);
        let rows: Vec<String> = stamps
            .map(|i| format!("{:.4},{},{}", i * 1e-3, i % 7.0, i * 0.5))
            .collect();
        let log = read(text(HEADER, &rows));
        assert_eq!((log.period_s, log.samples()), (1e-3, 200));
        assert!(
            log.position
                .iter()
                .enumerate()
                .all(|(i, p)| (p - 0.5 * i as f64).abs() < 1e-9)
        );
        let resampling = log.resampling.expect("filled samples");
        assert_eq!((resampling.rows, resampling.filled), (180, 20));
        // A straight line loses nothing.
        assert!(resampling.position_error < 1e-9);
    }

    #[test]
    fn a_period_can_be_asked_for() {
        let log = read(text(HEADER, &rows()));
        assert_eq!(log.clone().at_period(1.005e-3), Ok(log.clone()));
        let slower = log.clone().at_period(2e-3).expect("half the samples");
        assert_eq!((slower.period_s, slower.samples()), (2e-3, 100));
        assert_eq!(slower.position[7], log.position[14]);
        let mean = (log.input[14] + log.input[15]) / 2.0;
        assert!((slower.input[7] - mean).abs() < 1e-9);
        let error = log.clone().at_period(0.5e-3).expect_err("half made up");
        assert!(
            error.message.contains("at most 1.5 times theirs"),
            "{error}"
        );
        log.at_period(1.0).expect_err("one sample left");
    }

    #[test]
    fn a_measured_load_and_a_switch_are_read() {
        let header = "time_s,input,position,load_torque,enabled";
        let mut rows: Vec<String> = rows()
            .into_iter()
            .enumerate()
            .map(|(row, text)| format!("{text},-0.5,{}", u8::from(row < 100)))
            .collect();
        let log = read(text(header, &rows));
        assert_eq!(log.load_torque, Some(vec![-0.5; 200]));
        let enabled = log.enabled.expect("the column");
        assert_eq!((enabled[99], enabled[100]), (1.0, 0.0));
        // It stays a switch when rows are filled in.
        rows.remove(150);
        assert_eq!(read(text(header, &rows)).enabled, Some(enabled));
        rows[10] = "0.0100,1,1,0,0.5".into();
        refused(text(header, &rows), 12, &["`enabled`", "0.5", "0", "1"]);
    }

    #[test]
    fn a_slowly_drifting_clock_is_accepted() {
        let period = read(timed(|i| {
            let i = i as f64;
            i * 1e-3 + 2e-8 * i * i
        }))
        .period_s;
        assert!((1e-3..1.01e-3).contains(&period), "{period}");
    }

    #[test]
    fn few_printed_digits_are_accepted() {
        let printed = |stamp: &dyn Fn(usize) -> String| {
            let rows: Vec<String> = (0..3000).map(|i| stamp(i) + ",0,0").collect();
            read(text(HEADER, &rows)).period_s
        };
        assert_eq!(printed(&|i| format!("{:.3}", i as f64 * 1e-3)), 1e-3);
        assert_eq!(printed(&|i| format!("{:.1}", 1e6 + i as f64 * 0.1)), 0.1);
        assert_eq!(printed(&|i| format!("{:.4e}", 1.0 + i as f64 * 1e-3)), 1e-3);
        assert_eq!(
            printed(&|i| format!("{:.6}", 1.7e9 + i as f64 * 1e-3)),
            1e-3
        );
        // Stamps that rounding moves by up to 15 % of the period.
        let period = printed(&|i| format!("{:.4}", i as f64 / 3000.0));
        assert!((period * 3000.0 - 1.0).abs() < 1e-4, "{period}");
        // `%g`: six significant digits, coarser as time goes on.
        let period = printed(&|i| {
            let stamp = 8.0 + i as f64 / 800.0;
            let decimals = if stamp < 10.0 { 5 } else { 4 };
            format!("{stamp:.decimals$}")
                .trim_end_matches('0')
                .to_owned()
        });
        assert!((period * 800.0 - 1.0).abs() < 1e-4, "{period}");
        // Coarser than half a period it cannot be told from jitter.
        let rows: Vec<String> = (0..200)
            .map(|i| format!("{:.3},0,0", i as f64 / 700.0))
            .collect();
        refused(text(HEADER, &rows), 4, &["print `time_s` with more digits"]);
    }

    #[test]
    fn time_in_another_unit_is_refused() {
        refused(
            timed(|i| i as f64 * 1e-10),
            3,
            &["1e-10 s", "expected seconds"],
        );
    }

    #[test]
    fn a_quotation_mark_that_nothing_closes_is_refused() {
        row_refused(5, "0.0050,\"5,2.5", &["\"5,2.5", "is not closed"]);
        let header = text("\"time_s,input,position", &rows());
        refused(header, 1, &["quotation mark", "is not closed"]);
        let mut remarked: Vec<String> = rows().iter().map(|row| row.to_owned() + ",").collect();
        remarked[7] += "\"two\nlines, a \"\"word\"\" and 2\"\" more\"";
        remarked[9] += "5\" wide";
        read(text("time_s,input,position,remark", &remarked));
    }

    #[test]
    fn a_file_that_is_too_large_is_refused() {
        let file = given("log.csv", "");
        let hole = fs::File::options().write(true).open(&file.path).unwrap();
        hole.set_len((512 << 20) + 1).unwrap();
        let error = Log::read(&file.path).expect_err("a log that is too large");
        assert_error(&error, &file.path, None, &["larger than 512 MB", "a log"]);
        let endless = Path::new("/dev/zero");
        let error = Machine::read(endless).expect_err("a machine file that never ends");
        assert_error(
            &error,
            endless,
            None,
            &["larger than 1 MB", "a machine file"],
        );
    }

    #[test]
    fn an_impossible_sample_is_refused() {
        row_refused(
            5,
            "0.0050,1e10,2.5",
            &["`input` is 10000000000.0", "at most 1e9"],
        );
        row_refused(5, "0.0050,5,-2e9", &["`position`", "leave the row out"]);
    }

    /// A swing of 0.4 rad, once in 100 s; `edit` gets its positions.
    fn swing(edit: impl Fn(&mut [f64])) -> String {
        let time = |row: usize| row as f64 * 1e-2;
        let mut positions: Vec<f64> = (0..1000).map(|row| 0.4 * (time(row) * 0.6).sin()).collect();
        edit(&mut positions);
        let rows: Vec<String> = positions
            .iter()
            .enumerate()
            .map(|(row, position)| format!("{:?},0,{position:?}", time(row)))
            .collect();
        text(HEADER, &rows)
    }

    /// What is said of a log, at these lines, that is read nevertheless.
    #[track_caller]
    fn doubted(content: String, lines: &[usize], words: &[&str]) {
        let file = given("log.csv", content);
        let mut doubts = Vec::new();
        Log::read_with_doubts(&file.path, &mut doubts).unwrap_or_else(|error| panic!("{error}"));
        let found: Vec<_> = doubts.iter().filter_map(|doubt| doubt.line).collect();
        assert_eq!(found, lines);
        for (doubt, line) in doubts.iter().zip(lines) {
            assert_error(doubt, &file.path, Some(*line), words);
        }
    }

    #[test]
    fn a_position_that_jumps_for_one_sample_is_named() {
        doubted(swing(|_| ()), &[], &[]);
        doubted(
            swing(|it| it[500] += 1.0),
            &[502],
            &["`position`", "in this sample alone"],
        );
        doubted(
            swing(|it| it[500] -= 1.0),
            &[502],
            &["mean of its neighbours"],
        );
        let twice = swing(|it| {
            it[300] -= 1.0;
            it[700] += 2.0;
        });
        doubted(twice, &[302, 702], &["in this sample alone"]);
    }

    #[test]
    fn a_first_or_last_position_beside_all_others_is_named() {
        for (row, line) in [(0, 2), (999, 1001)] {
            doubted(
                swing(|it| it[row] -= 1.0),
                &[line],
                &["`position`", "remove the row"],
            );
        }
    }

    #[test]
    fn an_input_of_one_sample_beside_all_others_is_named() {
        let log = |damaged: &[usize], volts: f64| {
            let input = |at: usize| match damaged.contains(&at) {
                true => volts,
                false => (at % 7) as f64,
            };
            let rows: Vec<String> = (0..1000)
                .map(|at| {
                    format!(
                        "{:?},{:?},{:?}",
                        at as f64 * 1e-2,
                        input(at),
                        at as f64 * 1e-3
                    )
                })
                .collect();
            text(HEADER, &rows)
        };
        for row in [0, 500, 999] {
            doubted(
                log(&[row], 1e5),
                &[row + 2],
                &["`input`", "in this sample alone", "remove the row"],
            );
        }
        // No more than ten times the largest of all others.
        doubted(log(&[500], -60.0), &[], &[]);
        // Several of which each hides the other, as no converter has them; a drive that kicks is none.
        let several = log(&[400, 401, 800], 1e8);
        doubted(
            several,
            &[402],
            &["`input`", "in this sample, about as much in 2 others"],
        );
        doubted(log(&[500, 501], 200.0), &[], &[]);
    }

    #[test]
    fn what_a_sensor_does_is_no_jump() {
        // An angle that wraps, also there and back.
        doubted(
            swing(|it| it.iter_mut().for_each(|it| *it = it.rem_euclid(0.5))),
            &[],
            &[],
        );
        // A last digit that toggles at rest.
        doubted(
            swing(|it| {
                it.fill(0.25);
                it[400] = 0.251;
            }),
            &[],
            &[],
        );
        // A step to another place.
        doubted(
            swing(|it| it[500..].iter_mut().for_each(|it| *it += 1.0)),
            &[],
            &[],
        );
        // Steps of an encoder, and noise.
        doubted(
            swing(|it| {
                it.iter_mut()
                    .for_each(|it| *it = (*it * 50.0).round() / 50.0)
            }),
            &[],
            &[],
        );
        let noise = |row: usize| 0.05 * ((row * row) as f64 * 0.7).sin();
        doubted(
            swing(|it| {
                it.iter_mut()
                    .enumerate()
                    .for_each(|(row, it)| *it += noise(row))
            }),
            &[],
            &[],
        );
    }

    #[test]
    fn the_public_benchmark_is_read() {
        let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/emps");
        if !directory.is_dir() {
            eprintln!("not run: the EMPS logs are not at ../shared/data/emps");
            return;
        }
        for name in ["train.csv", "validate.csv"] {
            let log = Log::read(&directory.join(name)).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(log.samples(), 24_841);
            assert_eq!((log.start_s, log.period_s), (0.0, 1e-3));
            assert!(log.command.is_some_and(|command| command.len() == 24_841));
            assert!(log.current.is_none());
        }
    }

    fn series(samples: usize) -> impl Strategy<Value = Vec<f64>> {
        let value = prop_oneof![
            -1e3..1e3,
            Just(0.0),
            Just(-0.0),
            // Up to what a sample may be.
            any::<f32>().prop_map(|value| f64::from(value) % 1e9)
        ]
        .prop_filter("finite", |value: &f64| value.is_finite());
        prop::collection::vec(value, samples)
    }

    /// Positions none of which stands out.
    fn positions(samples: usize) -> impl Strategy<Value = Vec<f64>> {
        prop::collection::vec(-1e3..1e3, samples)
    }

    prop_compose! {
        fn any_log()(samples in Log::MIN_SAMPLES..400)(
            start_us in -1_000_000_000_i64..1_000_000_000,
            period_us in 10_u32..100_000,
            input in series(samples),
            position in positions(samples),
            command in prop::option::of(series(samples)),
            current in prop::option::of(series(samples)),
            velocity in prop::option::of(series(samples)),
            brake in prop::option::of(series(samples)),
            load_torque in prop::option::of(series(samples)),
            enabled in prop::option::of(prop::collection::vec(0_u8..2, samples)),
        ) -> Log {
            Log {
                path: PathBuf::new(),
                start_s: start_us as f64 / 1e6,
                period_s: f64::from(period_us) / 1e6,
                input,
                position,
                command,
                current,
                velocity,
                // A column of negative levels would be refused.
                brake: brake.map(|levels| levels.into_iter().map(f64::abs).collect()),
                load_torque,
                enabled: enabled.map(|levels| levels.into_iter().map(f64::from).collect()),
                filled: Vec::new(),
                resampling: None,
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn a_written_log_reads_back_identical(mut log in any_log()) {
            let file = given("log.csv", log.to_csv());
            log.path = file.path.clone();
            prop_assert_eq!(Log::read(&file.path), Ok(log));
        }

        #[test]
        fn arbitrary_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
            let file = given("log.csv", bytes);
            prop_assert!(Log::read(&file.path).is_err());
        }

        /// A good log, patched with what logs are made of: reaches further than noise does.
        #[test]
        fn a_damaged_log_does_not_panic(
            at in 0_usize..4000,
            length in 0_usize..30,
            patch in "[-+0-9eE.,\"\r\n \t]{0,30}",
        ) {
            let mut bytes = text(HEADER, &rows()).into_bytes();
            let start = at.min(bytes.len());
            let end = (at + length).min(bytes.len());
            bytes.splice(start..end, patch.into_bytes());
            exercise::log(&bytes);
            let file = given("log.csv", bytes);
            if let Err(error) = Log::read(&file.path) {
                assert_error(&error, &file.path, error.line, &[]);
            }
        }

        #[test]
        fn arbitrary_time_stamps_do_not_panic(stamps in prop::collection::vec(
            prop_oneof![any::<f64>(), 0.0..1.0],
            100..300,
        )) {
            let mut stamps: Vec<f64> = stamps.into_iter().filter(|t| t.abs() < 1e38).collect();
            stamps.sort_by(f64::total_cmp);
            stamps.dedup();
            let rows: Vec<String> = stamps.iter().map(|t| format!("{t:?},0,0")).collect();
            let file = given("log.csv", text(HEADER, &rows));
            if let Err(error) = Log::read(&file.path) {
                assert_error(&error, &file.path, error.line, &[]);
            }
        }
    }
}

mod machine {
    use super::*;

    fn declared(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("machines")
            .join(name)
    }

    fn rotary() -> String {
        fs::read_to_string(declared("ema-24v.toml")).expect("a machine of the repository")
    }

    fn linear() -> String {
        fs::read_to_string(declared("emps.toml")).expect("a machine of the repository")
    }

    /// `text` with the line that begins with `key` replaced, and that line's number.
    #[track_caller]
    fn replace_line(text: &str, key: &str, replacement: &str) -> (String, usize) {
        let index = text
            .lines()
            .position(|line| line.starts_with(key))
            .expect("the key is in the file");
        let mut lines: Vec<&str> = text.lines().collect();
        lines[index] = replacement;
        (lines.join("\n"), index + 1)
    }

    /// `text` without its section `[name]`.
    #[track_caller]
    fn without(text: &str, name: &str) -> String {
        let start = text.find(&format!("[{name}]")).expect("the section");
        let end = text[start..]
            .find("\n[")
            .map_or(text.len(), |end| start + end + 1);
        format!("{}{}", &text[..start], &text[end..])
    }

    #[track_caller]
    fn read(content: &str) -> Machine {
        let file = given("machine.toml", content);
        Machine::read(&file.path).unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn refused(content: impl AsRef<[u8]>, line: usize, words: &[&str]) {
        let file = given("machine.toml", content);
        let error = Machine::read(&file.path).expect_err("a bad machine file");
        assert_error(&error, &file.path, Some(line), words);
    }

    /// Refused when the line that begins with `key` is replaced, at that line.
    #[track_caller]
    fn line_refused(text: &str, key: &str, replacement: &str, words: &[&str]) {
        let (text, line) = replace_line(text, key, replacement);
        refused(text, line, words);
    }

    #[test]
    fn the_rotary_example_is_read() {
        let machine = Machine::read(&declared("ema-24v.toml")).expect("a good machine");
        assert_eq!(machine.name, "ema-24v");
        assert_eq!(machine.coordinate, Coordinate::Radian);
        assert_eq!(machine.gain, 1.0);
        assert_eq!(machine.resolution, Some(3.834952e-4));
        assert_eq!(machine.sensor_side, None);
        assert_eq!(machine.fit, ["inertia", "viscous", "coulomb", "static"]);
        assert_eq!(machine.declared_effects, []);
        for (name, value, unit) in [
            ("resistance", 1.0, "Ω"),
            ("inductance", 1e-3, "H"),
            ("torque_constant", 0.06, "N·m/A"),
            ("inertia", 1.2e-4, "kg·m²"),
            ("viscous", 2e-4, "N·m·s/rad"),
            ("spring", 0.0, "N·m/rad"),
            ("spring_rest", 0.0, "rad"),
            ("spring_preload", 0.0, "N·m"),
            ("gravity_torque", 0.0, "N·m"),
            ("gravity_rest", 0.0, "rad"),
            ("lower_stop", -1.0, "rad"),
            ("upper_stop", 1.0, "rad"),
            ("coulomb", 0.12, "N·m"),
            ("static", 0.15, "N·m"),
        ] {
            assert_eq!(machine.parameter(name), Some(value), "{name}");
            assert_eq!(
                machine.coordinate.parameter_unit(name),
                Some(unit),
                "{name}"
            );
        }
        assert_eq!(machine.parameter("gain"), None);
        assert_eq!(machine.coordinate.parameter_unit("gain"), None);
    }

    #[test]
    fn the_linear_benchmark_is_read() {
        let machine = Machine::read(&declared("emps.toml")).expect("a good machine");
        assert_eq!(machine.name, "EMPS");
        assert_eq!(machine.coordinate.unit(), "m");
        assert_eq!(machine.coordinate.load_unit(), "N");
        assert_eq!(machine.gain, 35.15065188);
        assert_eq!(machine.motor, None);
        assert_eq!(machine.fit, ["inertia", "viscous", "coulomb"]);
        for (name, value, unit) in [
            ("resistance", None, Some("Ω")),
            ("torque_constant", None, Some("N/A")),
            ("inertia", Some(95.1089), Some("kg")),
            ("viscous", Some(203.5034), Some("N·s/m")),
            ("spring", Some(0.0), Some("N/m")),
            ("gravity_torque", Some(0.0), None),
            ("lower_stop", None, Some("m")),
            ("coulomb", Some(20.3935), Some("N")),
        ] {
            assert_eq!(machine.parameter(name), value, "{name}");
            assert_eq!(machine.coordinate.parameter_unit(name), unit, "{name}");
        }
    }

    #[test]
    fn what_is_optional_may_be_left_out() {
        let machine = read(
            "name = \"least\"\ncoordinate = \"rad\"\n[input]\nkind = \"torque\"\ngain = -2\n\
             [mechanics]\ninertia = 1\nviscous = 0\n[friction]\ncoulomb = 0\nstatic = 0\n\
             [fit]\nparameters = []\n",
        );
        assert_eq!((machine.gain, machine.mechanics.inertia), (-2.0, 1.0));
        assert_eq!((machine.motor, machine.resolution), (None, None));
        assert_eq!(machine.mechanics.upper_stop, None);
        let windows = format!("\u{feff}{}", rotary().replace('\n', "\r\n"));
        assert_eq!(read(&windows).fit.len(), 4);
    }

    #[test]
    fn declared_effects_keep_their_numbers_and_their_lines() {
        let (text, line) = replace_line(
            &linear(),
            "declared_effects",
            "declared_effects = [\n  { id = \"offset_torque\", torque = 1 },\n\n  \
             { id = \"cogging\", period = 0.1, amplitude = -2.5 },\n]",
        );
        let file = given("machine.toml", text);
        let machine = Machine::read(&file.path).expect("a good machine");
        let [offset, cogging] = &machine.declared_effects[..] else {
            panic!("{:?}", machine.declared_effects);
        };
        assert_eq!(
            (&*offset.id, offset.parameters["torque"]),
            ("offset_torque", 1.0)
        );
        assert_eq!(
            (&*cogging.id, cogging.parameters["amplitude"]),
            ("cogging", -2.5)
        );
        assert_eq!((offset.line, cogging.line), (line + 1, line + 3));
        let error = machine.error_at(cogging.line, "unknown parameter");
        assert_error(&error, &file.path, Some(line + 3), &["unknown parameter"]);
    }

    #[test]
    fn a_bad_declared_effect_is_refused() {
        let bad = |entry: &str, words: &[&str]| {
            let line = format!("declared_effects = [{entry}]");
            line_refused(&rotary(), "declared_effects", &line, words);
        };
        let form = "{ id = \"offset_torque\", torque = 0.1 }";
        bad("\"cogging\"", &["\"cogging\"", form]);
        bad("{ id = \"cogging\" }", &["without parameters", form]);
        bad("{ torque = 0.1 }", &["without `id`", form]);
        bad("{ id = 3, torque = 0.1 }", &["integer `3`", "string"]);
        bad(
            "{ id = \"cogging\", period = \"x\" }",
            &["\"x\"", "a number"],
        );
        bad(
            "{ id = \"cogging\", period = inf }",
            &["inf", "single precision"],
        );
    }

    #[test]
    fn the_wrong_file_is_refused() {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let error = Machine::read(directory.path()).expect_err("a directory");
        assert_error(&error, directory.path(), None, &["directory", "TOML"]);
        let absent = directory.path().join("absent.toml");
        let error = Machine::read(&absent).expect_err("no file");
        assert_error(&error, &absent, None, &["no such file", "TOML"]);
        // What a shell leaves of `cargo hil machine ... > machine.toml` that was refused.
        for text in ["", "\n"] {
            refused(text, 1, &["is empty", "the command that was to write it"]);
        }
        refused(b"name = \"a\"\n\xff\xfe", 2, &["UTF-8"]);
        refused("name = \"a\"\ntime_s,input\n", 2, &["expected", "="]);
        refused("name = \"a\"\nname = \"b\"\n", 2, &["duplicate key"]);
        refused("name = \"a\"\ncoordinate = \"rad\n", 2, &["expected"]);
    }

    #[test]
    fn what_is_missing_is_named() {
        let (text, _) = replace_line(&rotary(), "name", "");
        refused(text, 1, &["`name`", "missing"]);
        let (text, _) = replace_line(&rotary(), "coordinate", "");
        refused(text, 1, &["`coordinate`", "\"rad\"", "\"m\""]);
        for section in ["input", "mechanics", "friction", "fit"] {
            let text = without(&rotary(), section);
            let last = text.trim_end().lines().count();
            refused(
                text,
                last,
                &[&format!("[{section}]"), "missing", "expected"],
            );
        }
        read(&without(&rotary(), "sensor"));
        for (section, key, words) in [
            ("input", "kind", &["\"voltage\"", "\"torque\""][..]),
            ("input", "gain", &["V for one unit"]),
            ("motor", "resistance", &["Ω"]),
            ("motor", "inductance", &["H"]),
            ("motor", "torque_constant", &["N·m/A"]),
            ("mechanics", "inertia", &["kg·m²"]),
            ("mechanics", "viscous", &["N·m·s/rad"]),
            ("friction", "coulomb", &["N·m"]),
            ("friction", "static", &["N·m"]),
            ("fit", "parameters", &["list"]),
        ] {
            let (text, _) = replace_line(&rotary(), key, "");
            let header = format!("[{section}]");
            let line = text.lines().position(|line| line.starts_with(&header));
            let key = format!("`{key}`");
            let words = [&[&*header, &*key, "expected"], words].concat();
            refused(&text, line.expect("the section") + 1, &words);
        }
    }

    /// What is written as a German spreadsheet does, and what the next section's header is missing before.
    #[test]
    fn a_decimal_comma_and_a_missing_header_are_named() {
        line_refused(
            &rotary(),
            "viscous",
            "viscous = 2,5e-4   # N·m·s/rad",
            &["decimal point, as in 2.5"],
        );
        line_refused(
            &rotary(),
            "inertia",
            "coulomb = 1.0",
            &["`coulomb` stands in [mechanics]", "belongs into [friction]"],
        );
        let text = rotary().replace("[friction]\n", "");
        let line = text.lines().position(|line| line.starts_with("coulomb"));
        refused(
            &text,
            line.expect("a friction") + 1,
            &["belongs into [friction], and the line [friction] is missing"],
        );
    }

    #[test]
    fn an_unknown_key_is_named_with_the_known_ones() {
        line_refused(
            &rotary(),
            "name",
            "nome = \"x\"",
            &["unknown key", "`nome`", "`name`"],
        );
        line_refused(
            &rotary(),
            "gain",
            "gian = 1.0",
            &["unknown key", "`gian`", "`gain`"],
        );
        line_refused(
            &rotary(),
            "resolution",
            "step = 1.0",
            &["`step`", "`resolution`"],
        );
        line_refused(
            &rotary(),
            "parameters",
            "params = []",
            &["`params`", "`parameters`"],
        );
        line_refused(
            &rotary(),
            "viscous",
            "viscus = 2.0e-4",
            &[
                "unknown key",
                "`viscus`",
                "[mechanics]",
                "`inertia`, `viscous`",
            ],
        );
        line_refused(
            &rotary(),
            "resistance",
            "r = 1",
            &["`r`", "[motor]", "`resistance`"],
        );
        line_refused(
            &rotary(),
            "static",
            "stick = 1",
            &["`stick`", "[friction]", "`static`"],
        );
        line_refused(
            &rotary(),
            "[sensor]",
            "[sensors]",
            &["`sensors`", "`sensor`"],
        );
        line_refused(&rotary(), "name", "\"a\\nb\" = 1", &["`a\\nb`"]);
    }

    #[test]
    fn the_side_of_the_sensor_is_read() {
        for (word, side) in [("motor", SensorSide::Motor), ("load", SensorSide::Load)] {
            let (text, _) = replace_line(
                &rotary(),
                "[sensor]",
                &format!("[sensor]\nside = \"{word}\""),
            );
            assert_eq!(read(&text).sensor_side, Some(side));
        }
        line_refused(
            &rotary(),
            "resolution",
            "side = \"gear\"",
            &["`gear`", "`motor` or `load`"],
        );
        line_refused(&rotary(), "resolution", "side = 1", &["side"]);
    }

    #[test]
    fn a_wrong_type_or_word_is_refused() {
        line_refused(
            &rotary(),
            "name",
            "name = 3",
            &["integer `3`", "string", "`name`"],
        );
        line_refused(&rotary(), "name", "name = \"  \"", &["`name`", "empty"]);
        line_refused(
            &rotary(),
            "coordinate",
            "coordinate = \"deg\"",
            &["`deg`", "`rad` or `m`"],
        );
        line_refused(
            &rotary(),
            "kind",
            "kind = \"force\"",
            &["`force`", "`voltage` or `torque`"],
        );
        line_refused(
            &rotary(),
            "inertia",
            "inertia = \"1.2 g·cm²\"",
            &["\"1.2 g·cm²\"", "a number in SI units", "mechanics.inertia"],
        );
        line_refused(
            &rotary(),
            "coulomb",
            "coulomb = [1.0]",
            &["a number", "friction.coulomb"],
        );
        line_refused(
            &rotary(),
            "gain",
            "gain = true",
            &["boolean", "a number", "input.gain"],
        );
        line_refused(
            &rotary(),
            "parameters",
            "parameters = \"inertia\"",
            &["a list"],
        );
        line_refused(&rotary(), "parameters", "parameters = [1]", &["string"]);
        line_refused(
            &linear(),
            "name",
            "sensor = 3",
            &["`3`", "a section", "`sensor`"],
        );
        line_refused(&linear(), "name", "motor = []", &["a section", "`motor`"]);
    }

    #[test]
    fn an_impossible_value_is_refused() {
        for (key, bad, expected) in [
            ("resistance", "0.0", "more than 0"),
            ("inductance", "-1e-3", "0 or more"),
            ("torque_constant", "0", "more than 0"),
            ("torque_constant", "-0.06", "more than 0"),
            ("inertia", "0.0", "more than 0"),
            ("inertia", "-1", "more than 0"),
            ("viscous", "-2.0e-4", "0 or more"),
            ("spring", "-1.0", "0 or more"),
            ("spring_preload", "-1.0", "0 or more"),
            ("coulomb", "-0.1", "0 or more"),
            ("resolution", "0.0", "more than 0"),
            ("gain", "0.0", "`gain` is 0"),
            ("static", "0.1199", "less than `coulomb` 0.12"),
            ("lower_stop", "1.0", "not below `upper_stop` 1.0"),
            ("lower_stop", "2.0", "not below `upper_stop` 1.0"),
            // Equal in single precision.
            ("lower_stop", "0.999999999", "not below `upper_stop` 1.0"),
            ("inertia", "nan", "single precision"),
            ("gain", "-inf", "single precision"),
            ("spring_rest", "1e39", "single precision"),
            ("inertia", "1e-60", "single precision"),
        ] {
            // "spring =" rather than "spring_rest".
            let line = format!("{key} = {bad}");
            line_refused(&rotary(), &format!("{key} ="), &line, &[key, expected]);
        }
    }

    #[test]
    fn sections_that_contradict_each_other_are_refused() {
        let text = without(&rotary(), "motor");
        let last = text.trim_end().lines().count();
        refused(
            text,
            last,
            &["[motor]", "missing", "`resistance`", "kind = \"torque\""],
        );
        let (text, _) = replace_line(&rotary(), "kind", "kind = \"torque\"");
        let line = text.lines().position(|line| line.starts_with("[motor]"));
        let words = ["[motor]", "remove", "kind = \"voltage\""];
        refused(&text, line.expect("the section") + 1, &words);
        for key in ["gravity_torque", "gravity_rest"] {
            let replacement = format!("inertia = 1.0\n{key} = 0.0");
            let (text, line) = replace_line(&linear(), "inertia", &replacement);
            refused(text, line + 1, &[key, "rotary", "remove"]);
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let bad = |text: &str, name: &str, words: &[&str]| {
            let line = format!("parameters = [\"inertia\",\n  \"{name}\"]");
            let (text, line) = replace_line(text, "parameters", &line);
            refused(text, line + 1, words);
        };
        bad(&rotary(), "inertia", &["`inertia`", "twice"]);
        bad(
            &rotary(),
            "mass",
            &["`mass`", "`resistance`", "`gravity_torque`", "or `static`"],
        );
        bad(&rotary(), "gain", &["`gain`", "`inertia`"]);
        bad(
            &linear(),
            "resistance",
            &["`resistance`", "expected `inertia`"],
        );
        bad(
            &linear(),
            "gravity_torque",
            &["`gravity_torque`", "or `static`"],
        );
        bad(&linear(), "upper_stop", &["`upper_stop`", "no such number"]);
        let (text, _) = replace_line(
            &rotary(),
            "parameters",
            "parameters = [\"torque_constant\", \"spring\", \"upper_stop\"]",
        );
        assert_eq!(read(&text).fit, ["torque_constant", "spring", "upper_stop"]);
    }

    #[test]
    fn a_factor_by_which_no_fitted_number_can_be_off_is_refused() {
        let bad = |unsure: &str, words: &[&str]| line_refused(&rotary(), "unsure", unsure, words);
        for (factors, words) in [
            // Not in `parameters`, though the machine has such a number.
            (
                "resistance = 3.0",
                &[
                    "`resistance` of `unsure`",
                    "not in `parameters`",
                    "expected `inertia`, `viscous`, `coulomb` or `static`",
                ][..],
            ),
            ("mass = 3.0", &["`mass` of `unsure`", "not in `parameters`"]),
            (
                "inertia = 0.9",
                &["`inertia` of `unsure` is 0.9", "a factor of 1 or more"],
            ),
            ("inertia = -3", &["`inertia` of `unsure` is -3.0"]),
            ("inertia = inf", &["inf is not a number"]),
            ("inertia = nan", &["NaN is not a number"]),
            ("inertia = \"3\"", &["a number", "`fit.unsure.inertia`"]),
        ] {
            bad(&format!("unsure = {{ {factors} }}"), words);
        }
        bad("unsure = 3.0", &["`fit.unsure`", "a section"]);
        let (text, line) = replace_line(&rotary(), "unsure", "unsure = { inertia = 3.0 }");
        assert_eq!(read(&text).unsure, [("inertia".to_owned(), 3.0)].into());
        let (text, _) = replace_line(&text, "parameters", "parameters = []");
        refused(&text, line, &["`inertia` of `unsure`", "remove it"]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn arbitrary_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
            let file = given("machine.toml", bytes);
            prop_assert!(Machine::read(&file.path).is_err());
        }

        /// A good file, patched with what TOML is made of: reaches further than noise does.
        #[test]
        fn a_damaged_file_does_not_panic(
            at in 0_usize..2500,
            length in 0_usize..30,
            patch in "[-+0-9aeinf_.,=\"'{}\\[\\]#\r\n ]{0,30}",
        ) {
            let mut bytes = rotary().into_bytes();
            let start = at.min(bytes.len());
            let end = (at + length).min(bytes.len());
            bytes.splice(start..end, patch.into_bytes());
            exercise::machine(&bytes);
            let file = given("machine.toml", bytes);
            if let Err(error) = Machine::read(&file.path) {
                assert_error(&error, &file.path, error.line, &[]);
            }
        }
    }
}
