//! Promise: `cargo hil decode` makes the same CSV of what `probe-rs run` prints as of the bytes that the board
//! sent, in each of probe-rs' formats; and says of a line that is not whole where it is and what to do.
//!
//! The text is made by the library that probe-rs prints with, `defmt_decoder`'s formatter.

use std::fs;
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

use crate::board_image::{frame, image};
use defmt_decoder::Table;
use defmt_decoder::log::format::{Formatter, FormatterConfig, FormatterFormat};
use host_tests::printed_log;
use tempfile::TempDir;

/// A control step of the board with these bits for its seven numbers, in which no two digits are alike.
fn sample(sequence: u32, bits: [u32; 7]) -> Vec<u8> {
    let time_us = u64::from(sequence) * 1000;
    let mut message = 2_u16.to_le_bytes().to_vec();
    message.extend((time_us + 40).to_le_bytes());
    message.extend(sequence.to_le_bytes());
    message.extend(time_us.to_le_bytes());
    for bits in bits {
        message.extend(bits.to_le_bytes());
    }
    frame(&message)
}

fn message(number: u16, payload: &[u8]) -> Vec<u8> {
    let mut message = number.to_le_bytes().to_vec();
    message.extend(1_500_000_u64.to_le_bytes());
    message.extend(payload);
    frame(&message)
}

/// Two experiments with a warning between their samples, whose numbers have any finite bits.
fn sent() -> Vec<u8> {
    let mut state = 7_u32;
    let mut bits = || loop {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        if f32::from_bits(state).is_finite() {
            return state;
        }
    };
    let mut log = message(4, &[1]);
    for sequence in 0..300 {
        log.extend(sample(sequence, std::array::from_fn(|_| bits())));
        if sequence % 70 == 3 {
            log.extend(message(3, &23.5_f32.to_le_bytes()));
        }
    }
    log.extend(message(4, &[2]));
    for sequence in 0..40 {
        log.extend(sample(sequence, std::array::from_fn(|_| bits())));
    }
    log
}

/// What probe-rs prints of it, without colours.
fn printed(log: &[u8], format: FormatterFormat<'static>, with_time: bool) -> String {
    coloured(log, format, with_time, false)
}

/// What probe-rs prints of it.
fn coloured(
    log: &[u8],
    format: FormatterFormat<'static>,
    with_time: bool,
    colours: bool,
) -> String {
    // Whether there are colours is said to the whole process.
    static COLOURS: Mutex<()> = Mutex::new(());
    let _only_here = COLOURS.lock().unwrap_or_else(PoisonError::into_inner);
    colored::control::set_override(colours);
    let table = Table::parse(&image("rzcobs")).unwrap().unwrap();
    let formatter = Formatter::new(FormatterConfig {
        format,
        is_timestamp_available: with_time,
    });
    let mut decoder = table.new_stream_decoder();
    decoder.received(log);
    let mut text = String::new();
    while let Ok(frame) = decoder.decode() {
        let file = Some("/home/someone/my project/firmware/src/app/record.rs");
        text += &formatter.format_frame(frame, file, Some(120), Some("firmware::app::record"));
        text.push('\n');
    }
    text
}

fn oneline(with_location: bool) -> FormatterFormat<'static> {
    FormatterFormat::OneLine { with_location }
}

fn full(with_location: bool) -> FormatterFormat<'static> {
    FormatterFormat::Default { with_location }
}

struct Case {
    directory: TempDir,
}

impl Case {
    fn new(log: impl AsRef<[u8]>) -> Self {
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("image"), image("rzcobs")).unwrap();
        fs::write(directory.path().join("log"), log).unwrap();
        Self { directory }
    }

    /// What an earlier call left is not there any more: nothing is replaced.
    fn decode(&self, more: &[&str]) -> Output {
        let _ = fs::remove_file(self.directory.path().join("out.csv"));
        Command::new(env!("CARGO_BIN_EXE_hil"))
            .current_dir(self.directory.path())
            .args(["decode", "image", "log", "--csv", "out.csv"])
            .args(more)
            .output()
            .unwrap()
    }

    /// The CSV of the named experiment, and what was said besides.
    #[track_caller]
    fn csv(&self, experiment: &str) -> (String, String) {
        let output = self.decode(&["--experiment", experiment]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let csv = fs::read_to_string(self.directory.path().join("out.csv")).unwrap();
        (csv, text(&output.stderr).to_owned())
    }

    /// The one line of an error with status 2, behind which nothing is written.
    #[track_caller]
    fn error(&self) -> String {
        let output = self.decode(&[]);
        let error = text(&output.stderr).to_owned();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty());
        assert!(!self.directory.path().join("out.csv").exists());
        error
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn every_format_gives_the_csv_of_the_bytes() {
    let sent = sent();
    let raw = Case::new(&sent);
    let expected = ["number_1", "number_2"].map(|name| raw.csv(name));
    assert_eq!(expected[0].0.lines().count(), 301);
    assert_eq!(expected[1].0.lines().count(), 41);
    for colours in [false, true] {
        for format in [oneline, full] {
            for with_location in [false, true] {
                for with_time in [false, true] {
                    let printed = coloured(&sent, format(with_location), with_time, colours);
                    assert_eq!(printed.contains('\x1b'), colours);
                    assert_eq!(printed.contains("record.rs:120"), with_location);
                    let case = Case::new(&printed);
                    let found = ["number_1", "number_2"].map(|name| case.csv(name));
                    assert_eq!(found, expected, "{}", &printed[..400]);
                    // The ends of lines that Windows makes.
                    let windows = Case::new(printed.replace('\n', "\r\n"));
                    assert_eq!(windows.csv("number_2"), expected[1]);
                }
            }
        }
    }
}

#[test]
fn messages_stand_as_the_board_said_them() {
    let line = "1.500000 [WARN ] supply (of 2) at 23.5 V (board src/main.rs:12)\n\
                1.500000 ERROR supply (of 2) at 23.5 V\n\
                └─ board::main @ src/main.rs:12\n\
                [INFO ] ready\n";
    let printed = printed_log::read("log".as_ref(), line.as_bytes())
        .unwrap()
        .unwrap();
    let lines: Vec<String> = printed.log.lines.iter().map(ToString::to_string).collect();
    assert_eq!(
        lines,
        [
            "1.500000 WARN supply (of 2) at 23.5 V",
            "1.500000 ERROR supply (of 2) at 23.5 V",
            "INFO ready"
        ]
    );
    assert_eq!(printed.others, 0);
}

#[test]
fn what_cargo_and_the_probe_say_is_left_out_and_counted() {
    let sent = sent();
    let expected = Case::new(&sent).csv("number_1").0;
    let head = "   Compiling firmware v0.1.0\n     Running `probe-rs run --chip STM32F405RGTx`\n\n      \
                Erasing ✔ 100% [####################] 128.00 KiB\n";
    let case = Case::new(format!("{head}{}", printed(&sent, oneline(true), true)));
    let (csv, said) = case.csv("number_1");
    assert_eq!(csv, expected);
    assert_eq!(
        said,
        "note: 3 lines that are none of the board's left out\n"
    );
}

#[test]
fn a_last_line_without_an_end_counts_as_damaged() {
    let sent = sent();
    let whole = printed(&sent, oneline(false), true);
    let case = Case::new(&whole[..whole.len() - 3]);
    let (csv, said) = case.csv("number_2");
    assert_eq!(csv.lines().count(), 40);
    assert_eq!(said, "warning: 1 damaged frames left out\n");
}

#[test]
fn a_line_that_is_not_whole_is_named_with_a_remedy() {
    let sent = sent();
    let whole = printed(&sent, oneline(true), true);
    let lines: Vec<&str> = whole.lines().collect();
    for (number, damage) in [
        // A terminal's width, a lost field, a number that is none, two lines in one, another format.
        (5, lines[4][..80].to_owned()),
        (9, lines[8].replace("command=", "cmd=")),
        (17, lines[16].replace("time_us=", "time_us=x")),
        (20, format!("{} {}", lines[0], lines[19])),
        (31, lines[30].replace("[INFO ]", "I")),
    ] {
        let mut damaged: Vec<&str> = lines.clone();
        damaged[number - 1] = &damage;
        let error = Case::new(damaged.join("\n") + "\n").error();
        assert!(
            error.starts_with(&format!("error: log:{number}: holds a sample")),
            "{error}"
        );
        assert!(
            error.contains("straight into a file") && error.contains("remove the line"),
            "{error}"
        );
    }
}

#[test]
fn other_text_is_no_log() {
    let error = Case::new("time_s,input,position\n0.0,1.0,2.0\n").error();
    assert!(
        error.starts_with("error: log: no frame can be decoded, and no line is one"),
        "{error}"
    );
    let utf16: Vec<u8> = "\u{feff}0.1 [INFO ] ready\n"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let error = Case::new(utf16).error();
    assert!(
        error.starts_with("error: log: is text in UTF-16; expected UTF-8"),
        "{error}"
    );
}
