//! `cargo hil test`: everything that can be checked on this machine.

use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs;
use std::io::{self, IsTerminal, Write};
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::thread;
use std::time::{Duration, Instant};

use host_tests::Tests;

use crate::blessing::replace;
use crate::board_log::Line;
use crate::board_run::{self, Prepared};
use crate::emulate;
use crate::failure::Failure;
use crate::figures::{self, Comparison, Figures};
use crate::fuzz;
use crate::image::Size;
use crate::on_target_run;
use crate::readers::{BOARD_LOG, READERS};
use crate::replay_run;
use crate::toolchain::{Build, Toolchain, set_up_browser};
use crate::workspace;

mod host_tests;

/// The images that are operated.
const PRODUCTS: [&str; 2] = ["throttle", "controller"];

/// An image, and what it occupies.
type ImageSize = (&'static str, Size);

/// When the first step began.
static START: LazyLock<Instant> = LazyLock::new(Instant::now);

/// What `cargo hil test` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Take the emulated runs' messages and the instruction counts as what is expected from now on, and show
    /// what changes
    #[arg(long)]
    bless: bool,
    /// Run the long tests too: many cases drawn at random, hundreds of logs, a day of a drive; and fuzz
    #[arg(long)]
    all: bool,
    /// Begin no long test later than this many minutes after the start
    #[arg(long, value_name = "MINUTES", requires = "all", value_parser = clap::value_parser!(u64).range(..=100_000))]
    within: Option<u64>,
}

/// Runs every step, up to the first that fails.
///
/// # Errors
/// The step that failed, and why.
pub fn run(args: &Args) -> Result<(), Failure> {
    LazyLock::force(&START);
    announce("formatting");
    cargo(&["fmt", "--all", "--check"])?;
    READERS.check_format()?;
    announce("lints");
    // In the profile of the tests: what the build itself runs is built once.
    cargo(&[
        "clippy",
        "--release",
        "--all-targets",
        "--",
        "-D",
        "warnings",
    ])?;
    cargo(&[
        "clippy",
        "--release",
        "--package",
        "firmware",
        "--lib",
        "--",
        "-D",
        "warnings",
    ])?;
    READERS.lint(BOARD_LOG)?;
    announce("documentation");
    for package in ["model-core", "rig", "firmware", "host-tests"] {
        cargo(&[
            "rustdoc",
            "--release",
            "--package",
            package,
            "--lib",
            "--",
            "-D",
            "warnings",
        ])?;
    }
    let prepared = board_run::prepare(announce)?;
    announce(
        "beside all that follows: a log of each kind of verdict on an emulated chip, which takes longest",
    );
    let (done, verdicts) = thread::scope(|scope| {
        let verdicts = scope.spawn(|| prepared.verdicts());
        let done = run_others(args, &prepared);
        if done.is_ok() && !verdicts.is_finished() {
            announce("waiting for the logs of each kind of verdict");
        }
        (done, verdicts.join())
    });
    let (images, tests) = done?;
    let verdicts = verdicts.unwrap_or_else(|cause| resume_unwind(cause))?;
    check_warnings(&verdicts.build)?;
    board_run::require_parity(&verdicts.comparisons)?;
    say(&format!(
        "{} logs, one of each kind of verdict, traced bit for bit as on this host",
        verdicts.comparisons.len()
    ));
    announce("done");
    say(&summary(&images, &tests));
    Ok(())
}

/// Runs the images, fuzzes where that is asked for, and runs the host tests.
fn run_others(args: &Args, prepared: &Prepared) -> Result<(Vec<ImageSize>, Tests), Failure> {
    let images = run_images(args, prepared)?;
    if args.all {
        announce("fuzzing");
        for target in fuzz::run()? {
            say(&target);
        }
    }
    announce("host tests");
    READERS.test(BOARD_LOG)?;
    if let Err(reason) = set_up_browser() {
        say(&format!(
            "no browser: the live page is not opened in one; {reason}"
        ));
    }
    let until = args
        .within
        .map(|minutes| *START + Duration::from_secs(60 * minutes));
    Ok((images, host_tests::run(args.all, until)?))
}

/// Builds and lints the images and runs them on emulated chips; gives what each occupies.
fn run_images(args: &Args, prepared: &Prepared) -> Result<Vec<ImageSize>, Failure> {
    let toolchain = &prepared.toolchain;
    announce("an actuator of each kind on the emulated chip");
    let board = prepared.actuators()?;
    check_warnings(&board.build)?;
    board.require_parity()?;
    check_messages(
        board_run::ACTUATORS,
        board_run::messages(&board.log),
        args.bless,
    )?;
    say(&format!(
        "{} samples, none dropped, bit for bit as on this host; messages as expected",
        board.samples()
    ));
    announce("failures on the emulated chip");
    run_program(toolchain, board_run::FAILURES, args.bless)?;
    say("each named, nothing taken over from it, the plant stepping on");
    announce("a throttle body and its engine controller on the emulated chip");
    run_program(toolchain, board_run::ECU, args.bless)?;
    say("each fault found by its code, none where there is none, no deadline missed");
    announce("the core's tests on the emulated chip");
    let on_target = on_target_run::run(toolchain)?;
    check_warnings(&on_target.build)?;
    check_messages(on_target_run::PROGRAM, on_target.messages(), args.bless)?;
    let counted = compare(
        toolchain,
        on_target_run::PROGRAM,
        &on_target.counts,
        args.bless,
    )?;
    say(&format!(
        "every test passed, bit for bit as on this host; instructions {counted}"
    ));
    announce("a recorded drive on the emulated chip");
    let replay = replay_run::check(toolchain)?;
    say(&format!(
        "{} rows, bit for bit as on this host",
        replay.rows.len()
    ));
    announce("the images that are operated");
    let mut images = vec![
        (board_run::ACTUATORS, board.size),
        (replay_run::PROGRAM, replay.size),
    ];
    for image in PRODUCTS {
        let built = toolchain.build(image)?;
        check_warnings(&built)?;
        images.push((
            image,
            Size::read(&built.elf)?.fitting_above(board.stack()?)?,
        ));
    }
    emulated_chips(toolchain)?;
    announce("lints of the images");
    if !toolchain.lint()? {
        say("this compiler has no clippy: the images' builds were looked at for warnings instead");
    }
    Ok(images)
}

/// The images as they are flashed, on emulated chips.
fn emulated_chips(toolchain: &Toolchain) -> Result<(), Failure> {
    let cycles = emulate::run::CYCLES_PER_INSTRUCTION;
    let built = emulate::run::Built::new(toolchain, announce)?;
    let (outcome, traced) =
        emulate::command::demonstrate(&built, cycles, emulate::run::Extent::Everything, announce)?;
    announce("recording the controller over its console");
    let recording = emulate::recording::run(&built, cycles)?;
    emulate::command::require(&outcome, &traced, Some(&recording))?;
    emulate::run::check()?;
    say(&format!(
        "both images start, answer, keep their ticks and what is saved; the loop follows its commands, and {} \
         samples of its log name what nobody declared",
        traced.samples
    ));
    Ok(())
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
    let status = cargo_command()
        .args(arguments)
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

/// The firmware's own code, hardware and all, builds without a warning.
fn check_warnings(build: &Build) -> Result<(), Failure> {
    if build.warnings.is_empty() {
        return Ok(());
    }
    Err(Failure::Other(format!(
        "the firmware builds with warnings\n{}",
        build.warnings.concat()
    )))
}

/// Builds and runs a program of the emulated chip and compares what it says with what is expected.
fn run_program(toolchain: &Toolchain, program: &str, bless: bool) -> Result<(), Failure> {
    let (build, said) = board_run::run_program(toolchain, program)?;
    check_warnings(&build)?;
    check_messages(program, board_run::messages(&said), bless)
}

/// Compares figures with the file next to the program that they are of; what came of it.
fn compare(
    toolchain: &Toolchain,
    image: &str,
    measured: &Figures,
    bless: bool,
) -> Result<String, Failure> {
    let compiler = toolchain.compiler();
    let file = golden_file(image, "toml");
    let remark = match figures::compare(&file, &compiler, measured, bless)? {
        Comparison::Same => "as expected",
        Comparison::UnknownCompiler => "not compared",
        Comparison::Blessed => "expected from now on",
    };
    Ok(format!("{remark} ({compiler})"))
}

/// Compares what the board said, but for samples and times, with the file next to its program.
fn check_messages<'a>(
    image: &str,
    lines: impl Iterator<Item = &'a Line>,
    bless: bool,
) -> Result<(), Failure> {
    let path = golden_file(image, "log");
    let said = text(lines);
    if bless {
        return replace(&path, &said);
    }
    let expected =
        fs::read_to_string(&path).map_err(|error| Failure::system(path.display(), &error))?;
    match first_difference(&expected, &said) {
        None => Ok(()),
        Some(difference) => Err(Failure::Other(format!(
            "{}:{difference}; if this is right: cargo hil test --bless",
            path.display()
        ))),
    }
}

/// What is expected of an image, next to its program.
fn golden_file(image: &str, extension: &str) -> PathBuf {
    let programs = workspace::root().join("firmware/src/bin");
    programs.join(image).with_extension(extension)
}

fn text<'a>(lines: impl Iterator<Item = &'a Line>) -> String {
    lines.fold(String::new(), |mut text, line| {
        // A string takes everything.
        let _ = writeln!(text, "{} {}", line.level, line.message);
        text
    })
}

fn first_difference(expected: &str, said: &str) -> Option<String> {
    let (mut expected, mut said) = (expected.lines(), said.lines());
    for number in 1.. {
        let quoted =
            |line: Option<&str>| line.map_or("nothing".to_owned(), |line| format!("{line:?}"));
        match (expected.next(), said.next()) {
            (None, None) => break,
            (before, now) if before == now => {}
            (before, now) => {
                return Some(format!(
                    "{number}: expected {}, got {}",
                    quoted(before),
                    quoted(now)
                ));
            }
        }
    }
    None
}

/// What is said at the end.
fn summary(images: &[ImageSize], tests: &Tests) -> String {
    let mut text = tests.summary();
    // A string takes everything.
    for (image, size) in images {
        let _ = write!(text, "\nimage {image}: {size}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_names_its_line() {
        assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
        assert_eq!(
            first_difference("a\nb\n", "a\nc\n").as_deref(),
            Some("2: expected \"b\", got \"c\"")
        );
        assert_eq!(
            first_difference("a\n", "a\nb\n").as_deref(),
            Some("2: expected nothing, got \"b\"")
        );
        assert_eq!(
            first_difference("a\nb\n", "a\n").as_deref(),
            Some("2: expected \"b\", got nothing")
        );
    }
}
