//! `cargo hil test`: everything that can be checked on this machine.

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::panic::resume_unwind;
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use host_tests::Tests;

use crate::board_link::probe::PROBE;
use crate::emulate::run::EMULATION;
use crate::failure::Failure;
use crate::fuzz;
use crate::readers::READERS;
use crate::toolchain::set_up_browser;
use crate::workspace;

mod documented;
mod host_tests;
mod images;

/// When the first step began.
static START: LazyLock<Instant> = LazyLock::new(Instant::now);

/// What `cargo hil test` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Take the emulated runs' messages and the instruction counts as what is expected from now on, and show
    /// what changes
    #[arg(long)]
    bless: bool,
    /// Look at all cases of each promise, not at a few: every machine, every log of a list, every verdict on the chip
    #[arg(long, group = "longer")]
    cases: bool,
    /// Besides, run the tests at length: many cases drawn at random, hundreds of logs, a day of a drive; what the
    /// texts show of the emulated chips, as it stands there; and fuzz
    #[arg(long, group = "longer")]
    all: bool,
    /// Begin nothing that one of these options adds later than this many minutes after the start
    #[arg(long, value_name = "MINUTES", requires = "longer", value_parser = clap::value_parser!(u64).range(..=100_000))]
    within: Option<u64>,
}

impl Args {
    /// Whether more is done than a few cases of each promise.
    fn is_longer(&self) -> bool {
        self.cases || self.all
    }
}

/// Runs every step: one after another, up to the first that fails, but for the images, which are built and run beside
/// the host tests. An emulated chip keeps one core busy at most, whatever else there is to do.
///
/// # Errors
/// The steps that failed, and why.
pub fn run(args: &Args) -> Result<(), Failure> {
    LazyLock::force(&START);
    announce("formatting");
    cargo(&["fmt", "--all", "--check"])?;
    READERS.check_format()?;
    EMULATION.check_format()?;
    PROBE.check_format()?;
    announce("lints");
    lint()?;
    // Before the images: both may have packages to install.
    if let Err(reason) = set_up_browser() {
        say(&format!(
            "no browser: the live page is not opened in one; {reason}"
        ));
    }
    let limit = Limit::of(args);
    let (images, tests) = thread::scope(|scope| {
        let images = scope.spawn(|| told(images::run(args, limit)));
        let tests = told(run_host_tests(args, limit));
        if !images.is_finished() {
            announce("waiting for the images on the emulated chips");
        }
        (images.join(), tests)
    });
    let images = images.unwrap_or_else(|cause| resume_unwind(cause));
    let (images, mut tests) = (images?, tests?);
    tests.left.extend(images.left);
    announce("done");
    say(&tests.summary());
    for (image, size) in images.sizes {
        say(&format!("image {image}: {size}"));
    }
    Ok(())
}

/// Whether a step has failed.
static FAILED: AtomicBool = AtomicBool::new(false);

/// Says at once what failed, for a step beside it may go on for long.
fn told<T>(outcome: Result<T, Failure>) -> Result<T, Failure> {
    if let Err(failure) = &outcome {
        FAILED.store(true, Ordering::Relaxed);
        say(&format!("failed, beside what may go on: {failure}"));
    }
    outcome
}

/// Until when what `--cases` and `--all` add is begun.
#[derive(Debug, Clone, Copy)]
struct Limit(Option<Instant>);

impl Limit {
    fn of(args: &Args) -> Self {
        let minutes = args.within;
        Self(minutes.map(|minutes| *START + Duration::from_secs(60 * minutes)))
    }

    /// Whether nothing more is to be begun: it is too late, or a step has failed.
    fn is_reached(self) -> bool {
        FAILED.load(Ordering::Relaxed) || self.0.is_some_and(|until| Instant::now() >= until)
    }
}

fn lint() -> Result<(), Failure> {
    // In the profile of the tests: what the build itself runs is built once.
    cargo(&[
        "clippy",
        "--release",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ])?;
    // Named beside host-tests the firmware has the features that the call before has built, and little is checked twice.
    cargo(&[
        "clippy",
        "--release",
        "--package",
        "firmware",
        "--package",
        "host-tests",
        "--lib",
        "--",
        "-D",
        "warnings",
    ])
}

/// Builds the documentation and runs the host tests; with `--cases` and `--all`, the longer ones too.
fn run_host_tests(args: &Args, limit: Limit) -> Result<Tests, Failure> {
    announce("documentation");
    let arguments = ["doc", "--release", "--workspace", "--lib", "--no-deps"];
    let mut documentation = cargo_command();
    documentation.args(arguments);
    documentation.env("RUSTDOCFLAGS", "-D warnings");
    succeed(documentation, &arguments)?;
    announce("host tests");
    let programs = host_tests::build()?;
    let calls = documented::require_tests(&programs)?;
    say(&format!(
        "{calls} calls of tests in the texts take the tests that they name"
    ));
    let mut tests = host_tests::run(&programs)?.sound()?;
    if args.is_longer() {
        announce("host tests of other cases");
        tests.longer(&programs, args.all, limit)?;
    }
    if args.all {
        announce("fuzzing");
        if limit.is_reached() {
            tests.left.push("fuzzing".to_owned());
        } else {
            for target in fuzz::run()? {
                say(&target);
            }
        }
    }
    tests.sound()
}

/// Says what is done next, and the minutes and seconds since the start.
fn announce(step: &str) {
    let seconds = START.elapsed().as_secs();
    say(&format!("== {}:{:02} {step}", seconds / 60, seconds % 60));
}

fn say(text: &str) {
    // Whoever closed the stream does not want to know; the exit status tells the rest.
    let _ = writeln!(io::stdout(), "{text}");
}

/// A cargo of the toolchain that runs this program.
fn cargo_command() -> Command {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(cargo);
    command.current_dir(workspace::root()).stdin(Stdio::null());
    if io::stdout().is_terminal() {
        command.env("CARGO_TERM_COLOR", "always");
    }
    command
}

fn cargo(arguments: &[&str]) -> Result<(), Failure> {
    let mut command = cargo_command();
    command.args(arguments);
    succeed(command, arguments)
}

fn succeed(mut command: Command, arguments: &[&str]) -> Result<(), Failure> {
    let status = command
        .status()
        .map_err(|error| Failure::system("cargo cannot be run", &error))?;
    if status.success() {
        Ok(())
    } else {
        Err(failed(arguments))
    }
}

fn failed(arguments: &[&str]) -> Failure {
    Failure::Other(format!("failed: cargo {}", arguments.join(" ")))
}
