//! Promise: `cargo hil import` makes a log of any logger's file, in SI units to the last digit, says what
//! it found and did, and replaces nothing; and where `cargo hil gap` refuses a log for its form, the call
//! that it prints makes a log which it accepts.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use host_tests::log::Log;
use rig::{Effect, EffectKind, Experiment, Machine, Trajectory};
use serde_json::Value;
use tempfile::TempDir;

/// A directory that `hil` is run in.
struct Place {
    directory: TempDir,
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

impl Place {
    fn new() -> Self {
        Self {
            directory: tempfile::tempdir().expect("a temporary directory"),
        }
    }

    fn with(name: &str, content: impl AsRef<[u8]>) -> Self {
        let place = Self::new();
        place.write(name, content);
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("a writable temporary directory");
    }

    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.directory.path()).expect("a directory");
        let mut names: Vec<String> = entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .into_string()
                    .expect("UTF-8")
            })
            .collect();
        names.sort();
        names
    }

    fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
        command
            .current_dir(self.directory.path())
            .args(words.split(' ').map(|word| word.replace('~', " ")));
        command
    }

    /// Runs it; a `~` stands for a space inside a word.
    fn run(&self, words: &str) -> Output {
        let output = self.command(words).output().expect("hil starts");
        assert!(!text(&output.stderr).contains("panicked"), "{words}");
        output
    }

    /// Imports to `log.csv`: the log, and what was printed.
    #[track_caller]
    fn import(&self, words: &str) -> (Log, String) {
        let output = self.run(&format!("import {words} --out log.csv"));
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        assert!(output.stderr.is_empty());
        let log = Log::read(&self.path("log.csv")).expect("a log");
        fs::remove_file(self.path("log.csv")).expect("the log");
        (log, text(&output.stdout).to_owned())
    }

    /// Refused in one line with these words, status 2, nothing printed, nothing written.
    #[track_caller]
    fn refuses(&self, words: &str, expected: &[&str]) {
        let before = self.names();
        let output = self.run(words);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(error.starts_with("error: "), "{error}");
        for word in expected {
            assert!(error.contains(word), "no {word:?} in: {error}");
        }
        assert!(output.stdout.is_empty());
        assert_eq!(self.names(), before);
    }

    /// Runs a printed call as a shell does.
    #[track_caller]
    fn follow(&self, call: &str) {
        let program = format!("\"{}\" import ", env!("CARGO_BIN_EXE_hil"));
        let output = Command::new("sh")
            .current_dir(self.directory.path())
            .args(["-c", &call.replacen("cargo hil import ", &program, 1)])
            .output()
            .expect("a shell");
        assert!(output.status.success(), "{call}\n{}", text(&output.stderr));
    }
}

/// Rows from a header and a rule.
fn rows(header: &str, count: usize, row: impl Fn(usize) -> String) -> String {
    let rows: Vec<String> = (0..count).map(row).collect();
    format!("{header}\n{}\n", rows.join("\n"))
}

#[track_caller]
fn near(values: &[f64], expected: impl Fn(usize) -> f64) {
    for (at, value) in values.iter().enumerate() {
        let expected = expected(at);
        let scale = expected.abs().max(1e-3);
        assert!(
            (value - expected).abs() < 1e-12 * scale,
            "{at}: {value} {expected}"
        );
    }
}

mod units {
    use super::*;

    /// Every column of a log at once, each with a unit of its own.
    #[test]
    fn every_column_becomes_si() {
        let raw = rows("t,pos,duty,i,w,soll,b,l,en", 200, |k| {
            let k = k as f64;
            let on = if k < 100.0 { "on" } else { "off" };
            format!(
                "{k},{},{},{},{},{},{k},{k},{on}",
                0.9 * k,
                k / 2.0,
                10.0 * k,
                3.0 * k,
                k
            )
        });
        let place = Place::with("raw.csv", raw);
        let (log, said) = place.import(
            "raw.csv --time t:ms --position pos:deg --input duty:%*12 --current i:mA --velocity w:rpm \
             --command -soll:rev --brake b:mN·m --load-torque l:Ncm*-1+2 --enabled en",
        );
        assert_eq!((log.samples(), log.period_s, log.start_s), (200, 1e-3, 0.0));
        near(&log.position, |k| 0.9 * k as f64 * PI / 180.0);
        near(&log.input, |k| k as f64 / 200.0 * 12.0);
        near(&log.current.unwrap(), |k| k as f64 / 100.0);
        near(&log.velocity.unwrap(), |k| 3.0 * k as f64 * TAU / 60.0);
        near(&log.command.unwrap(), |k| -TAU * k as f64);
        near(&log.brake.unwrap(), |k| k as f64 * 1e-3);
        near(&log.load_torque.unwrap(), |k| 2.0 - k as f64 * 1e-2);
        near(&log.enabled.unwrap(), |k| f64::from(u8::from(k < 100)));
        assert!(said.contains("200 samples at 1000 Hz"), "{said}");
        assert!(said.contains("none was resampled"), "{said}");
    }

    #[test]
    fn units_of_time_counts_and_strokes_have_their_factors() {
        let raw = rows("t,x,u", 200, |k| format!("{k},{},{}", 8 * k, k % 7));
        let place = Place::with("raw.csv", raw);
        for (unit, period) in [
            ("s", 1.0),
            ("ms", 1e-3),
            ("us", 1e-6),
            ("µs", 1e-6),
            ("ns", 1e-9),
        ] {
            let (log, _) = place.import(&format!("raw.csv --time t:{unit} --position x --input u"));
            assert!(
                (log.period_s / period - 1.0).abs() < 1e-9,
                "{unit}: {}",
                log.period_s
            );
        }
        for (unit, factor) in [
            ("counts/4096", TAU / 4096.0),
            ("counts*0.5", 0.5),
            ("mm", 1e-3),
            ("um", 1e-6),
            ("rev", TAU),
            ("rad", 1.0),
            ("°", PI / 180.0),
        ] {
            let (log, _) = place.import(&format!(
                "raw.csv --time 1:ms --position 2:{unit} --input 3:mV"
            ));
            near(&log.position, |k| 8.0 * k as f64 * factor);
            near(&log.input, |k| (k % 7) as f64 * 1e-3);
        }
        for (unit, factor) in [("rev/s", TAU), ("deg/s", PI / 180.0), ("mm/s", 1e-3)] {
            let words = "raw.csv --time t:ms --position x --input u --velocity x";
            let (log, _) = place.import(&format!("{words}:{unit}"));
            near(&log.velocity.unwrap(), |k| 8.0 * k as f64 * factor);
        }
    }

    /// Nanoseconds since 1970 are more than a log's time can be.
    #[test]
    fn a_calendar_becomes_a_time_from_zero() {
        let raw = rows("stamp,u,x", 300, |k| {
            format!(
                "{},{},{}",
                1_790_000_000_000_000_000_u64 + 1_000_000 * k as u64,
                k,
                k * k
            )
        });
        let place = Place::with("raw.csv", raw);
        let (log, said) = place.import("raw.csv --time stamp:ns --input u --position x");
        assert_eq!((log.start_s, log.samples()), (0.0, 300));
        assert!((log.period_s / 1e-3 - 1.0).abs() < 1e-6);
        assert!(said.contains("starts at zero"), "{said}");
    }

    #[test]
    fn a_column_that_looks_like_another_unit_is_pointed_out() {
        let raw = rows("t,pos,u,i,w,T [ms]", 400, |k| {
            let t = k as f64;
            let angle = 170.0 * (0.01 * t).sin();
            // Milliseconds, degrees, per cent, milliamperes, and rpm of the degrees' radians.
            let rpm = 170.0 * 10.0 * (0.01 * t).cos();
            format!(
                "{t},{angle},{},{},{rpm},{t}",
                90.0 * (0.02 * t).cos(),
                900.0 * (0.03 * t).sin()
            )
        });
        let place = Place::with("raw.csv", raw);
        let words = "raw.csv --position pos --input u --current i --velocity w";
        let (_, said) = place.import(&format!("{words} --time t"));
        for hint in [
            "--time \"t:ms\"",
            "--position \"pos:deg\"",
            "--input \"u:%\"",
            "--current \"i:mA\"",
        ] {
            assert!(said.contains(hint), "{hint}: {said}");
        }
        let (_, said) = place.import(&format!("{words} --time T~[ms]"));
        assert!(
            said.contains("the file says so: then --time \"T [ms]:ms\""),
            "{said}"
        );
        // In milliseconds the velocity is nine and a half times what the position, in radians, does.
        let rpm = rows("t,pos,u,w", 400, |k| {
            let t = 1e-3 * k as f64;
            format!(
                "{t:.3},{},1,{}",
                (9.0 * t).sin(),
                9.0 * (9.0 * t).cos() * 60.0 / TAU
            )
        });
        place.write("rpm.csv", rpm);
        let given = "rpm.csv --time t --position pos --input u --velocity w";
        let (_, said) = place.import(given);
        assert!(said.contains("--velocity \"w:rpm\""), "{said}");
        assert!(!said.contains("--position \""), "{said}");
        // What was given a unit is not doubted.
        let (_, said) = place.import(&format!("{given}:rpm"));
        assert!(!said.contains("Look again"), "{said}");
    }
}

mod angles {
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
        for (column, jumps) in [("deg:deg", 12), ("count:counts/4096", 12), ("rad", 12)] {
            let words =
                format!("raw.csv --time t:ms --input u --position {column} --command ref:deg");
            let (log, said) = place.import(&format!("{words} --unwrap"));
            for (k, value) in log.position.iter().enumerate() {
                assert!(
                    (value - log.position[0] - TAU * 0.03 * k as f64).abs() < 1e-9,
                    "{column} {k}"
                );
            }
            assert!(said.contains("jumps taken out"), "{jumps}: {said}");
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
        let (log, _) =
            place.import("raw.csv --time t:ms --input u --position n:um*2 --unwrap 65536");
        near(&log.position, |k| (60_000 + 700 * k) as f64 * 2e-6);
    }
}

mod layouts {
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
        let (log, printed) =
            place.import(&format!("{name} --time t --input u --position x{options}"));
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
        let text = written("t;u;x;°", ";", true).replace('\n', "\r\n");
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
}

/// MATLAB files, built from *MAT-File Format* of The MathWorks.
mod matlab {
    use super::*;

    #[derive(Clone, Copy)]
    struct Writer {
        big: bool,
        packed: bool,
    }

    impl Writer {
        fn word(self, value: u32) -> [u8; 4] {
            if self.big {
                value.to_be_bytes()
            } else {
                value.to_le_bytes()
            }
        }

        fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
            // Up to four bytes stand in the tag itself.
            let mut bytes = if !data.is_empty() && data.len() <= 4 {
                self.word((data.len() as u32) << 16 | kind).to_vec()
            } else {
                [self.word(kind), self.word(data.len() as u32)].concat()
            };
            bytes.extend(data);
            bytes.resize(bytes.len().next_multiple_of(8), 0);
            bytes
        }

        fn doubles(self, values: &[f64]) -> Vec<u8> {
            let bytes = |value: &f64| {
                if self.big {
                    value.to_be_bytes()
                } else {
                    value.to_le_bytes()
                }
            };
            self.element(9, &values.iter().flat_map(bytes).collect::<Vec<u8>>())
        }

        /// A variable; `real` is the element of its numbers.
        fn array(self, class: u32, name: &str, size: (u32, u32), real: &[u8]) -> Vec<u8> {
            let flags = self.element(6, &[self.word(class), self.word(0)].concat());
            let size = self.element(5, &[self.word(size.0), self.word(size.1)].concat());
            let name = self.element(1, name.as_bytes());
            let matrix = self.element(14, &[&flags[..], &size, &name, real].concat());
            if !self.packed {
                return matrix;
            }
            let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
            packed.write_all(&matrix).expect("memory");
            let packed = packed.finish().expect("memory");
            // No padding behind a compressed element.
            [&self.word(15)[..], &self.word(packed.len() as u32), &packed].concat()
        }

        fn file(self, variables: &[Vec<u8>]) -> Vec<u8> {
            let mut bytes = b"MATLAB 5.0 MAT-file, Platform: test".to_vec();
            bytes.resize(124, b' ');
            bytes.extend(if self.big {
                *b"\x01\x00MI"
            } else {
                *b"\x00\x01IM"
            });
            bytes.extend(variables.concat());
            bytes
        }
    }

    const ROWS: usize = 300;

    fn time(k: usize) -> f64 {
        k as f64 * 1e-3
    }

    fn position(k: usize) -> f64 {
        (7.0 * time(k)).sin()
    }

    fn input(k: usize) -> i16 {
        (k % 11) as i16 - 5
    }

    fn file(writer: Writer) -> Vec<u8> {
        let column = |rule: fn(usize) -> f64| (0..ROWS).map(rule).collect::<Vec<f64>>();
        let rows = ROWS as u32;
        // MATLAB stores whole numbers of a double array in fewer bytes.
        let small: Vec<u8> = (0..ROWS)
            .flat_map(|k| {
                if writer.big {
                    input(k).to_be_bytes()
                } else {
                    input(k).to_le_bytes()
                }
            })
            .collect();
        let two = [column(position), column(time)].concat();
        let mut text = writer.array(4, "note", (1, 2), &writer.element(17, &[65, 0, 66, 0]));
        text.extend(writer.array(2, "settings", (1, 1), &writer.element(5, &[0; 4])));
        writer.file(&[
            text,
            writer.array(6, "t", (rows, 1), &writer.doubles(&column(time))),
            writer.array(6, "vir", (1, rows), &writer.element(3, &small)),
            writer.array(6, "both", (rows, 2), &writer.doubles(&two)),
            writer.array(6, "gain", (1, 1), &writer.doubles(&[3.0])),
        ])
    }

    #[test]
    fn numeric_arrays_are_read_in_either_byte_order_packed_or_not() {
        for big in [false, true] {
            for packed in [false, true] {
                let place = Place::with("raw.mat", file(Writer { big, packed }));
                let (log, said) = place.import("raw.mat --time t --input vir --position both.1");
                assert_eq!((log.samples(), log.period_s), (ROWS, 1e-3));
                near(&log.input, |k| f64::from(input(k)));
                near(&log.position, position);
                assert!(said.contains("MATLAB, 3 arrays, 2 variables"), "{said}");
                assert!(said.contains("not asked for: both.2"), "{said}");
            }
        }
    }

    #[test]
    fn a_file_without_vectors_or_of_another_version_is_refused() {
        let little = Writer {
            big: false,
            packed: false,
        };
        let words = "import raw.mat --time t --input vir --position both.1 --out log.csv";
        let whole = file(little);
        Place::with("raw.mat", &whole[..whole.len() - 900]).refuses(words, &["damaged MATLAB"]);
        let settings = little.array(2, "settings", (1, 1), &little.element(5, &[0; 4]));
        Place::with("raw.mat", little.file(&[settings]))
            .refuses(words, &["no numeric array", "1 variable", "-v7"]);
        Place::with("raw.mat", b"MATLAB 7.3 MAT-file, Platform: GLNXA64")
            .refuses(words, &["7.3", "save('F.mat', '-v7')"]);
        let other = Place::with("raw.mat", file(little));
        other.refuses(
            "import raw.mat --time t --input u --position both.1 --out log.csv",
            &["--input", "\"u\"", "t, vir, both.1, both.2"],
        );
    }
}

mod rates {
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
            &["--time"],
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
        assert!(said.contains("1 row without a number left out"), "{said}");
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
}

mod files {
    use super::*;

    const WORDS: &str = "import raw.csv --time t:ms --input u --position x";

    fn place() -> Place {
        Place::with(
            "raw.csv",
            rows("t,u,x", 200, |k| format!("{k},{k},{}", k * k)),
        )
    }

    #[test]
    fn nothing_of_the_users_is_replaced() {
        let place = place();
        place.write("log.csv", "mine");
        place.refuses(
            &format!("{WORDS} --out log.csv"),
            &["log.csv: ", "not replaced", "name a new"],
        );
        assert_eq!(fs::read_to_string(place.path("log.csv")).unwrap(), "mine");
        place.refuses(
            &format!("{WORDS} --out raw.csv"),
            &["raw.csv: ", "is read by this command"],
        );
        fs::create_dir(place.path("page")).unwrap();
        place.write("page/index.html", "mine");
        place.refuses(
            &format!("{WORDS} --report page --out new.csv"),
            &["index.html: ", "not replaced"],
        );
        assert_eq!(
            fs::read_to_string(place.path("page/index.html")).unwrap(),
            "mine"
        );
    }

    #[test]
    fn a_wrong_call_names_what_there_is() {
        let place = place();
        place.refuses(
            "import raw.csv --time Zeit --input u --position x --out log.csv",
            &["--time", "\"Zeit\"", "t, u, x"],
        );
        place.refuses(
            "import raw.csv --time t:V --input u --position x --out log.csv",
            &["--time", "\"V\"", "s, ms, us"],
        );
        place.refuses(
            &format!("{WORDS}:furlong --out log.csv"),
            &["--position", "furlong", "deg"],
        );
        place.refuses(
            "import absent.csv --time t --input u --position x --out a.csv",
            &["no such file"],
        );
        for (content, words) in [
            (&b"PK\x03\x04"[..], "spreadsheet"),
            (b"\x89HDF\r\n", "HDF5"),
            (b"\x7fELF\0\0", "neither text"),
            (b"hello\nworld\n", "no two columns"),
            (b"", "no two columns"),
        ] {
            let place = Place::with("raw.csv", content);
            place.refuses(&format!("{WORDS} --out log.csv"), &["raw.csv: ", words]);
        }
    }

    #[test]
    fn the_report_draws_every_column() {
        let place = place();
        let output = place.run(&format!(
            "{WORDS} --current u:mA --report page --out log.csv"
        ));
        assert!(output.status.success());
        assert_eq!(place.names(), ["log.csv", "page", "raw.csv"]);
        let page = fs::read_to_string(place.path("page/index.html")).unwrap();
        for title in ["position, rad", "current_a, A", ">input<", "time, s"] {
            assert!(page.contains(title), "{title}");
        }
        let svg = &page[page.find("<svg").unwrap()..page.find("</svg>").unwrap() + 6];
        assert!(
            roxmltree::Document::parse(svg)
                .unwrap()
                .descendants()
                .count()
                > 50
        );
        assert!(
            page.contains("none was resampled"),
            "the table stands on the page"
        );
    }
}

/// Where `gap` refuses a log for its form, the call that it prints makes one which it accepts.
mod mended {
    use super::*;

    fn log() -> &'static str {
        static LOG: OnceLock<String> = OnceLock::new();
        LOG.get_or_init(|| {
            let machine = Machine::force_slide();
            let push = Effect::nominal(EffectKind::OffsetTorque, &machine);
            let moves = Trajectory::moves(&machine);
            let experiment = Experiment::tracking(machine, moves).with_effects(&[push]);
            experiment.lasting(3.0).run().to_csv()
        })
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

    const HEADER: &str = "time_s,input,position,command";

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
        place.follow(call);
        let made = place.path("my log-corrected.csv");
        assert!(made.is_file(), "{call}");
        let made = Log::read(&made).expect("a log");
        assert!(made.samples() >= 1_000, "{call}: {}", made.samples());
        verdict(&place, "my~log-corrected.csv");
    }

    #[test]
    fn headers() {
        let body = |header: &str| log().replacen(HEADER, header, 1);
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
            &["\"winkel [rad]\""],
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
        mends(packed.finish().expect("memory"), &["not UTF-8"]);
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
        mends(gap, &["middle of motion", "--lines 1202-2601"]);
        let coarse = timed(&|_, t| format!("{t:.2}"));
        mends(coarse, &["more digits", "--rate 1000"]);
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
}
