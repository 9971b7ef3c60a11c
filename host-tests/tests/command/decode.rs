//! `cargo hil decode`, on images and logs made here: a symbol table with defmt's words, and frames
//! put together by hand.

use std::cell::RefCell;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::board_image::{frame, image};
use crate::defmt::Dictionary;
use host_tests::board_log::BoardLog;
use host_tests::{dictionary, exercise};
use object::write::Object;
use object::{Architecture, BinaryFormat, Endianness};
use proptest::prelude::*;
use tempfile::TempDir;

fn sample(sequence: u32) -> Vec<u8> {
    let time_us = u64::from(sequence) * 1000;
    let mut message = 2_u16.to_le_bytes().to_vec();
    message.extend((time_us + 40).to_le_bytes());
    message.extend(sequence.to_le_bytes());
    message.extend(time_us.to_le_bytes());
    for value in [-12.5_f32, 0.1, 0.3, 1e-7, 0.11, sequence as f32, 2e-7] {
        message.extend(value.to_le_bytes());
    }
    frame(&message)
}

fn warning(volts: f32) -> Vec<u8> {
    let mut message = 3_u16.to_le_bytes().to_vec();
    message.extend(1_500_000_u64.to_le_bytes());
    message.extend(volts.to_le_bytes());
    frame(&message)
}

fn experiment(number: u8) -> Vec<u8> {
    let mut message = 4_u16.to_le_bytes().to_vec();
    message.extend(0_u64.to_le_bytes());
    message.push(number);
    frame(&message)
}

/// The head of a capture whose trigger is in its first row.
fn capture() -> Vec<u8> {
    let mut head = 5_u16.to_le_bytes().to_vec();
    head.extend(0_u64.to_le_bytes());
    let mut quantities = 6_u16.to_le_bytes().to_vec();
    quantities.extend(0_u64.to_le_bytes());
    quantities.push(0);
    [frame(&head), frame(&quantities)].concat()
}

/// What the reader makes of a log.
fn decoded(dictionary: &Dictionary, log: &[u8]) -> BoardLog {
    let mut said = Vec::new();
    dictionary.pass_on(log, &mut said).unwrap();
    BoardLog::of_frames(&said[..])
}

fn holds(log: &BoardLog, sequence: u32) -> bool {
    let mut samples = log.lines.iter().filter_map(|line| line.sample.as_ref());
    samples.any(|sample| sample.sequence == sequence)
}

struct Case {
    directory: TempDir,
}

impl Case {
    fn new(image: &[u8], log: &[u8]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        fs::write(directory.path().join("image"), image).unwrap();
        fs::write(directory.path().join("log"), log).unwrap();
        Self { directory }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn decode(&self, more: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_hil"))
            .current_dir(self.directory.path())
            .args(["decode", "image", "log"])
            .args(more)
            .output()
            .unwrap()
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

#[test]
fn lines_and_samples_come_out_as_they_were_sent() {
    let log = [sample(0), warning(23.5), sample(1)].concat();
    let output = Case::new(&image("rzcobs"), &log).decode(&[]);
    assert!(output.status.success());
    assert_eq!(text(&output.stderr), "");
    let lines: Vec<&str> = text(&output.stdout).lines().collect();
    assert_eq!(
        lines,
        [
            "0.000040 INFO sample sequence=0 time_us=0 input=-12.5 position=0.1 command=0.3 \
             current_a=1e-7 true_position=0.11 true_velocity=0.0 true_current_a=2e-7",
            "1.500000 WARN supply at 23.5 V",
            "0.001040 INFO sample sequence=1 time_us=1000 input=-12.5 position=0.1 command=0.3 \
             current_a=1e-7 true_position=0.11 true_velocity=1.0 true_current_a=2e-7",
        ]
    );
}

#[test]
fn csv_takes_the_samples_and_the_terminal_the_rest() {
    let log = [sample(0), warning(23.5), sample(1)].concat();
    let case = Case::new(&image("rzcobs"), &log);
    let output = case.decode(&["--csv", "out.csv"]);
    assert!(output.status.success());
    assert_eq!(text(&output.stdout), "1.500000 WARN supply at 23.5 V\n");
    assert_eq!(
        fs::read_to_string(case.path("out.csv")).unwrap(),
        "time_s,input,position,command,current_a\n\
         0.000000,-12.5,0.1,0.3,1e-7\n\
         0.001000,-12.5,0.1,0.3,1e-7\n"
    );
}

#[test]
fn one_experiment_of_several_is_taken_the_first_unless_it_is_named() {
    let log = [
        experiment(1),
        sample(0),
        sample(1),
        experiment(2),
        sample(0),
    ]
    .concat();
    let case = Case::new(&image("rzcobs"), &log);
    let rows = || {
        fs::read_to_string(case.path("out.csv"))
            .unwrap()
            .lines()
            .count()
            - 1
    };
    let output = case.decode(&["--csv", "out.csv"]);
    assert!(output.status.success());
    assert_eq!(rows(), 2);
    assert_eq!(
        text(&output.stderr),
        "note: out.csv holds the experiment \"number_1\"; the log has number_1, number_2, \
         see --experiment\n"
    );
    // A log is never replaced.
    fs::remove_file(case.path("out.csv")).unwrap();
    let output = case.decode(&["--csv", "out.csv", "--experiment", "number_2"]);
    assert!(output.status.success());
    assert_eq!((rows(), text(&output.stderr)), (1, ""));
    let output = case.decode(&["--csv", "other.csv", "--experiment", "3"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(
        text(&output.stderr),
        "error: log: holds no sample of an experiment \"3\"; expected one of number_1, number_2\n"
    );
    assert!(!case.path("other.csv").exists());
    let output = case.decode(&["--csv", "out.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(rows(), 1, "what was there stays");
}

#[test]
fn captures_have_one_name_and_are_told_apart_by_their_number() {
    let log = [
        capture(),
        sample(0),
        sample(1),
        // Armed, and disarmed before it was triggered.
        capture(),
        capture(),
        sample(0),
    ]
    .concat();
    let case = Case::new(&image("rzcobs"), &log);
    let output = case.decode(&["--csv", "out.csv", "--experiment", "capture:2"]);
    assert!(output.status.success());
    assert_eq!(
        fs::read_to_string(case.path("out.csv")).unwrap(),
        "time_s,position,true_velocity\n0.000000,0.1,0.0\n"
    );
    let output = case.decode(&["--csv", "other.csv", "--experiment", "capture:3"]);
    assert_eq!(
        text(&output.stderr),
        "error: log: holds no sample of an experiment \"capture:3\"; expected one of capture, capture:2\n"
    );
}

#[test]
fn a_capture_has_the_columns_that_it_recorded() {
    let log = [experiment(1), sample(0), capture(), sample(0), sample(1)].concat();
    let case = Case::new(&image("rzcobs"), &log);
    let output = case.decode(&["--csv", "out.csv", "--experiment", "capture"]);
    assert!(output.status.success());
    assert_eq!(
        fs::read_to_string(case.path("out.csv")).unwrap(),
        "time_s,position,true_velocity\n\
         0.000000,0.1,0.0\n\
         0.001000,0.1,1.0\n"
    );
}

#[test]
fn what_is_missing_is_said() {
    let mut log = [sample(0), sample(1), sample(5)].concat();
    log.extend([7, 7, 7]);
    let output = Case::new(&image("rzcobs"), &log).decode(&[]);
    assert!(output.status.success());
    assert_eq!(
        text(&output.stderr),
        "warning: 1 damaged frames left out\n\
         warning: samples are missing, first between number 1 and 5\n"
    );
}

#[test]
fn a_file_that_is_not_what_it_should_be_is_status_2_and_nothing_is_written() {
    let whole = image("rzcobs");
    let log = sample(0);
    let object = Object::new(BinaryFormat::Elf, Architecture::Arm, Endianness::Little);
    let without_defmt = object.write().unwrap();
    for (image, log, start) in [
        (&b"no image"[..], &log[..], "error: image: "),
        (&whole[..40], &log, "error: image: "),
        (&without_defmt, &log, "error: image: has no defmt log"),
        (
            &image("raw"),
            &log,
            "error: image: logs in another encoding",
        ),
        (&image("morse"), &log, "error: image: "),
        (&whole, b"", "error: log: no frame can be decoded"),
        (
            &whole,
            b"not a log\n",
            "error: log: no frame can be decoded",
        ),
        (&whole, &warning(1.0), "error: log: holds no sample"),
    ] {
        let case = Case::new(image, log);
        let output = case.decode(&["--csv", "out.csv"]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.starts_with(start), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty());
        assert!(!case.path("out.csv").exists());
    }
}

#[test]
fn a_result_that_cannot_be_written_is_status_1() {
    let case = Case::new(&image("rzcobs"), &sample(0));
    let output = case.decode(&["--csv", "absent/out.csv"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).starts_with("error: absent/out.csv: "));
}

#[test]
fn a_damaged_byte_costs_at_most_the_two_frames_around_it() {
    let dictionary = Dictionary::of_bytes(&image("rzcobs")).unwrap();
    let numbers: Vec<u32> = (0..8).map(|number| number * 1_000_003).collect();
    let log: Vec<u8> = numbers.iter().flat_map(|&number| sample(number)).collect();
    for position in 0..log.len() {
        let sent = log[position];
        for received in [sent ^ 1, sent ^ 0x80, !sent, 0] {
            let mut damaged = log.clone();
            damaged[position] = received;
            let decoded = decoded(&dictionary, &damaged);
            exercise::board_log(&decoded, &damaged);
            let found = numbers
                .iter()
                .filter(|&&number| holds(&decoded, number))
                .count();
            assert!(
                found >= numbers.len() - 2,
                "byte {position} as {received:#x}"
            );
        }
    }
}

/// A log that comes byte by byte, and what has been passed on of it.
struct Live<'a> {
    log: &'a [u8],
    passed_on: &'a RefCell<Vec<u8>>,
    frames: usize,
}

impl Read for Live<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let lines = self.passed_on.borrow().split(|&byte| byte == b'\n').count() - 1;
        assert_eq!(lines, self.frames, "before the next byte has come");
        let read = self.log.read(&mut bytes[..1])?;
        self.frames += usize::from(bytes[..read] == [0]);
        Ok(read)
    }
}

struct PassedOn<'a>(&'a RefCell<Vec<u8>>);

impl Write for PassedOn<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_frame_is_passed_on_as_soon_as_it_has_come() {
    let log = [&sample(0)[..], &warning(23.5), &[7, 0], &sample(1)].concat();
    let passed_on = RefCell::default();
    let live = Live {
        log: &log,
        passed_on: &passed_on,
        frames: 0,
    };
    let dictionary = Dictionary::of_bytes(&image("rzcobs")).unwrap();
    dictionary.pass_on(live, PassedOn(&passed_on)).unwrap();
    let passed_on = BoardLog::of_frames(&passed_on.borrow()[..]);
    assert_eq!(passed_on, decoded(&dictionary, &log));
    assert_eq!((passed_on.lines.len(), passed_on.damaged), (3, 1));
}

#[test]
fn an_image_that_is_missing_is_named() {
    let error = dictionary::Dictionary::read(Path::new("absent"))
        .err()
        .unwrap();
    assert!(
        error.to_string().starts_with("absent: no such file"),
        "{error}"
    );
}

/// Pieces of a log: whole frames, the ends of frames, and any bytes.
fn pieces() -> impl Strategy<Value = Vec<u8>> {
    let whole = any::<u16>().prop_map(|number| sample(number.into()));
    let part = (any::<u16>(), 0_usize..60).prop_map(|(number, from)| {
        let whole = sample(number.into());
        whole[from.min(whole.len())..].to_vec()
    });
    let noise = prop::collection::vec(prop_oneof![Just(0), any::<u8>()], 0..80);
    let pieces = prop::collection::vec(prop_oneof![whole, part, noise], 0..20);
    pieces.prop_map(|pieces| pieces.concat())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    /// The fuzzer's own check: each frame is a line or damaged, none is lost or counted twice.
    #[test]
    fn whatever_a_board_sends_each_frame_is_a_line_or_damaged(bytes in pieces()) {
        let dictionary = Dictionary::of_bytes(&image("rzcobs")).expect("an image with a defmt log");
        exercise::board_log(&decoded(&dictionary, &bytes), &bytes);
    }

    #[test]
    fn a_damaged_image_is_refused_or_has_words(
        at in any::<prop::sample::Index>(),
        patch in prop::collection::vec(any::<u8>(), 1..40),
    ) {
        let mut damaged = image("rzcobs");
        let at = at.index(damaged.len());
        let end = (at + patch.len()).min(damaged.len());
        damaged.splice(at..end, patch);
        if let Err(error) = Dictionary::of_bytes(&damaged) {
            prop_assert!(!error.is_empty());
        }
    }
}
