//! The tests on this host: every program of tests in turn, each test with the time that it takes.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::Deserialize;

use super::{Limit, cargo_command};
use crate::failure::Failure;
use crate::measured::SKIPPED;

/// Of the slowest tests, as many are named at the end.
const SLOWEST: usize = 10;

/// What the tests came to.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Tests {
    /// Tests that passed: name, and seconds where they are known.
    passed: Vec<(String, Option<f64>)>,
    /// Names of those that failed.
    failed: Vec<String>,
    /// Tests that could not run: name and reason.
    skipped: Vec<String>,
    /// What no time was left for, of what is done at length.
    pub(super) left: Vec<String>,
}

impl Tests {
    /// Tests that ran and passed: the harness counts one that could not run as passed.
    pub(super) fn passed(&self) -> usize {
        self.passed.len().saturating_sub(self.skipped.len())
    }

    /// What is said of them at the end.
    pub(super) fn summary(&self) -> String {
        let mut lines = vec![format!(
            "{} host tests passed, {} could not run",
            self.passed(),
            self.skipped.len()
        )];
        lines.extend(self.skipped.iter().map(|test| format!("  not run: {test}")));
        let left = self.left.iter();
        lines.extend(left.map(|what| format!("  no time was left for: {what}")));
        let mut timed: Vec<(f64, &str)> = self
            .passed
            .iter()
            .filter_map(|(name, seconds)| Some(((*seconds)?, &name[..])))
            .collect();
        timed.sort_by(|a, b| b.0.total_cmp(&a.0));
        timed.truncate(SLOWEST);
        lines.extend(
            timed
                .iter()
                .map(|(seconds, name)| format!("  {seconds:6.1} s {name}")),
        );
        lines.join("\n")
    }

    /// Takes in what a program printed.
    fn read(&mut self, program: &str, output: &[String], complaints: &[String]) {
        for line in output {
            let Some((name, outcome)) = result(line) else {
                continue;
            };
            let name = format!("{program}: {name}");
            if outcome.starts_with("ok") {
                self.passed.push((name, seconds(outcome)));
            } else if outcome.starts_with("FAILED") {
                self.failed.push(name);
            }
        }
        let skipped = complaints
            .iter()
            .filter_map(|line| line.strip_prefix(SKIPPED));
        self.skipped.extend(skipped.map(str::to_owned));
    }
}

/// The name of a test and what came of it, from a line of the harness.
fn result(line: &str) -> Option<(&str, &str)> {
    line.strip_prefix("test ")?.rsplit_once(" ... ")
}

/// The seconds behind an outcome: `ok <1.234s>`.
fn seconds(outcome: &str) -> Option<f64> {
    let (_, time) = outcome.split_once('<')?;
    time.strip_suffix("s>")?.parse().ok()
}

/// Runs the tests, all of them also where one fails, but for those at length.
///
/// # Errors
/// A program of tests that does not run.
pub(super) fn run(programs: &[Program]) -> Result<Tests, Failure> {
    let mut tests = Tests::default();
    for program in programs {
        let run = program.run(&[])?;
        tests.take(&program.name, run)?;
    }
    let mut examples = cargo_command();
    examples.args(["test", "--release", "--doc", "--no-fail-fast"]);
    tests.take("documentation", listen(examples)?)?;
    Ok(tests)
}

impl Tests {
    /// All of them, if none failed.
    ///
    /// # Errors
    /// Those that failed.
    pub(super) fn sound(self) -> Result<Self, Failure> {
        if self.failed.is_empty() {
            return Ok(self);
        }
        Err(Failure::Other(format!(
            "{} host tests failed\n  {}",
            self.failed.len(),
            self.failed.join("\n  ")
        )))
    }

    fn take(&mut self, program: &str, run: Run) -> Result<(), Failure> {
        let failed = self.failed.len();
        self.read(program, &run.output, &run.complaints);
        if run.status.success() || self.failed.len() > failed {
            Ok(())
        } else {
            Err(Failure::Other(format!(
                "tests of {program}: {}",
                run.status
            )))
        }
    }

    /// Runs the other cases and, if they are asked for, the tests at length behind them, as many at a time as there are
    /// cores.
    ///
    /// # Errors
    /// A program of tests that does not run.
    pub(super) fn longer(
        &mut self,
        programs: &[Program],
        at_length: bool,
        limit: Limit,
    ) -> Result<(), Failure> {
        let mut each = Vec::new();
        for reason in [OTHER_CASES, AT_LENGTH] {
            if reason == OTHER_CASES || at_length {
                each.extend(left_out(programs, reason)?);
            }
        }
        let (queue, done) = (Mutex::new(each.iter()), Mutex::new(Vec::new()));
        let next = || lock(&queue).next();
        let cores = thread::available_parallelism().map_or(1, usize::from);
        thread::scope(|scope| {
            for _ in 0..cores {
                scope.spawn(|| {
                    while !limit.is_reached()
                        && let Some((program, test)) = next()
                    {
                        let run = program.run(&["--ignored", "--exact", test]);
                        lock(&done).push((program, run));
                    }
                });
            }
        });
        let left = lock(&queue).clone();
        self.left
            .extend(left.map(|(program, test)| format!("{}: {test}", program.name)));
        for (program, run) in lock(&done).drain(..) {
            self.take(&program.name, run?)?;
        }
        Ok(())
    }
}

/// What the `#[ignore]` of a test begins with that has other cases of what a shorter test has some of.
const OTHER_CASES: &str = "other cases";

/// And that of one that takes longer still.
const AT_LENGTH: &str = "at length";

/// The tests that are left out for a reason, from any of them on: one that no time is left for has its turn another
/// time.
fn left_out<'a>(
    programs: &'a [Program],
    reason: &str,
) -> Result<Vec<(&'a Program, String)>, Failure> {
    let mut each = Vec::new();
    for program in programs {
        let tests = program.left_out(reason)?;
        each.extend(tests.into_iter().map(|test| (program, test)));
    }
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let seconds = now.unwrap_or(Duration::ZERO).as_secs() as usize;
    let first = seconds % each.len().max(1);
    each.rotate_left(first);
    Ok(each)
}

/// What a mutex holds; a thread that panicked with it left it whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A program of tests.
#[derive(Debug)]
pub(super) struct Program {
    /// Its package and target.
    pub(super) name: String,
    executable: PathBuf,
    /// Where its package is, in which it runs.
    directory: PathBuf,
}

/// What cargo says of something that it built.
#[derive(Deserialize)]
struct Artifact {
    manifest_path: PathBuf,
    target: Target,
    executable: Option<PathBuf>,
    profile: Profile,
}

#[derive(Deserialize)]
struct Target {
    name: String,
}

#[derive(Deserialize)]
struct Profile {
    test: bool,
}

/// Builds the programs of tests.
///
/// # Errors
/// Tests that do not build, which cargo has told.
pub(super) fn build() -> Result<Vec<Program>, Failure> {
    let arguments = [
        "test",
        "--release",
        "--no-run",
        "--message-format",
        "json-render-diagnostics",
    ];
    let output = cargo_command()
        .args(arguments)
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| Failure::system("cargo cannot be run", &error))?;
    if !output.status.success() {
        return Err(super::failed(&arguments));
    }
    let lines = String::from_utf8_lossy(&output.stdout);
    Ok(lines.lines().filter_map(program).collect())
}

/// The program that a message of cargo's is about.
fn program(message: &str) -> Option<Program> {
    let artifact: Artifact = serde_json::from_str(message).ok()?;
    let directory = artifact.manifest_path.parent()?.to_owned();
    let package = directory.file_name()?.to_string_lossy().into_owned();
    artifact.profile.test.then_some(())?;
    Some(Program {
        name: format!("{package}/{}", artifact.target.name),
        executable: artifact.executable?,
        directory,
    })
}

impl Program {
    fn command(&self) -> Command {
        let mut command = Command::new(&self.executable);
        command.current_dir(&self.directory).stdin(Stdio::null());
        command
    }

    /// Runs its tests, or those that the arguments name.
    fn run(&self, arguments: &[&str]) -> Result<Run, Failure> {
        super::say(&self.name);
        let mut command = self.command();
        // The harness tells the times only where what is not stable is allowed.
        command
            .env("RUSTC_BOOTSTRAP", "1")
            .args(["-Z", "unstable-options", "--report-time"])
            .args(arguments);
        listen(command)
    }

    /// The names of its tests that a filter takes, told with options of the harness.
    ///
    /// # Errors
    /// A program that does not run.
    pub(super) fn list(&self, filter: &str, options: &[String]) -> Result<Vec<String>, Failure> {
        let output = self
            .command()
            .arg("--list")
            .args(options)
            .arg(filter)
            .output()
            .map_err(|error| Failure::system(self.executable.display(), &error))?;
        let lines = String::from_utf8_lossy(&output.stdout);
        let names = lines.lines().filter_map(|line| line.strip_suffix(": test"));
        Ok(names.map(str::to_owned).collect())
    }

    /// The names of its tests that are left out for a reason.
    fn left_out(&self, reason: &str) -> Result<Vec<String>, Failure> {
        let output = self
            .command()
            // The harness tells the reasons only where what is not stable is allowed.
            .env("RUSTC_BOOTSTRAP", "1")
            .args(["-Z", "unstable-options", "--ignored", "--list"])
            .args(["--format", "json"])
            .output()
            .map_err(|error| Failure::system(self.executable.display(), &error))?;
        let lines = String::from_utf8_lossy(&output.stdout);
        Ok(lines
            .lines()
            .filter_map(|line| ignored(line, reason))
            .collect())
    }
}

/// A test as the harness lists it.
#[derive(Deserialize)]
struct Listed {
    name: String,
    ignore_message: String,
}

/// The test of a line of the list, if that is left out for a reason.
fn ignored(line: &str, reason: &str) -> Option<String> {
    let listed: Listed = serde_json::from_str(line).ok()?;
    listed
        .ignore_message
        .starts_with(reason)
        .then_some(listed.name)
}

/// A program of tests that has ended.
struct Run {
    status: ExitStatus,
    /// The lines of its output that are about a test.
    output: Vec<String>,
    /// Those of its complaints that say what could not run.
    complaints: Vec<String>,
}

/// Runs a program and passes on what it prints.
fn listen(mut command: Command) -> Result<Run, Failure> {
    let name = PathBuf::from(command.get_program());
    let system = |error: &io::Error| Failure::system(name.display(), error);
    let mut child: Child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| system(&error))?;
    let complaints = child.stderr.take();
    let complaints = thread::spawn(move || pass_on(complaints, io::stderr()));
    let output = pass_on(child.stdout.take(), io::stdout());
    let complaints = complaints.join().unwrap_or_default();
    let status = child.wait().map_err(|error| system(&error))?;
    Ok(Run {
        status,
        output,
        complaints,
    })
}

/// Copies a stream line by line and keeps the lines that are about a test.
fn pass_on(stream: Option<impl Read>, mut to: impl Write) -> Vec<String> {
    let mut kept = Vec::new();
    let Some(stream) = stream else { return kept };
    let mut stream = BufReader::new(stream);
    let mut line = Vec::new();
    while stream
        .read_until(b'\n', &mut line)
        .is_ok_and(|read| read > 0)
    {
        // Whoever closed the stream does not want to know; the exit status tells the rest.
        let _ = to.write_all(&line);
        let text = String::from_utf8_lossy(&line);
        let text = text.trim_end();
        if text.starts_with(SKIPPED) || result(text).is_some() {
            kept.push(text.to_owned());
        }
        line.clear();
    }
    kept
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn tests_that_could_not_run_are_not_counted_as_passed() {
        let output = [
            "test gap::emps ... ok <12.345s>",
            "test gap::slow ... FAILED <1.000s>",
            "test gap::long ... ignored, at length",
            "test src/lib.rs - of (line 3) ... ok",
        ]
        .map(str::to_owned);
        let skipped = ["SKIPPED gap::emps: no ../shared/data/emps/train.csv".to_owned()];
        let mut tests = Tests::default();
        tests.read("tracing", &output, &skipped);
        tests.left.push("tracing: gap::long".to_owned());
        assert_eq!(tests.passed(), 1);
        assert_eq!(tests.failed, ["tracing: gap::slow"]);
        assert_eq!(
            tests.summary(),
            "1 host tests passed, 1 could not run\n  not run: gap::emps: no ../shared/data/emps/train.csv\n  \
             no time was left for: tracing: gap::long\n  \x20 12.3 s tracing: gap::emps"
        );
    }

    #[test]
    fn lines_are_passed_on_whole_and_only_those_of_tests_are_kept() {
        let text = b"running 1 test\ntest a ... ok <0.010s>\n\xff\nSKIPPED a: b";
        let mut copy = Vec::new();
        let kept = pass_on(Some(&text[..]), &mut copy);
        assert_eq!(copy, text);
        assert_eq!(kept, ["test a ... ok <0.010s>", "SKIPPED a: b"]);
    }

    #[test]
    fn tests_that_are_left_out_are_told_apart_by_their_reasons() {
        let line = |name: &str, reason: &str| {
            format!(
                r#"{{ "type": "test", "event": "discovered", "name": "{name}", "ignore": false, "ignore_message": "{reason}" }}"#
            )
        };
        let (one, other) = (
            line("a", "other cases"),
            line("b", "at length: it is built"),
        );
        assert_eq!(ignored(&one, OTHER_CASES).as_deref(), Some("a"));
        assert_eq!(ignored(&one, AT_LENGTH), None);
        assert_eq!(ignored(&other, AT_LENGTH).as_deref(), Some("b"));
        let suite = r#"{ "type": "suite", "event": "discovery" }"#;
        assert_eq!(ignored(suite, OTHER_CASES), None);
    }

    #[test]
    fn programs_of_tests_are_found_in_what_cargo_says() {
        let message = r#"{"reason":"compiler-artifact","manifest_path":"/w/model-core/Cargo.toml","target":{"name":"pid"},
            "executable":"/w/target/release/deps/pid-1","profile":{"test":true}}"#;
        let found = program(message).unwrap();
        assert_eq!(found.name, "model-core/pid");
        assert_eq!(found.directory, Path::new("/w/model-core"));
        assert!(program(&message.replace("true", "false")).is_none());
        assert!(program(r#"{"reason":"build-finished","success":true}"#).is_none());
    }
}
