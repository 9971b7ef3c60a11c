//! The images: built, linted and run on emulated chips, and what is expected of that.

use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use super::{Args, Limit, announce, documented, say};
use crate::blessing::replace;
use crate::board_link::probe::PROBE;
use crate::board_log::Line;
use crate::board_run::{self, Prepared, VerdictsRun};
use crate::emulate;
use crate::failure::Failure;
use crate::figures::{self, Comparison, Figures};
use crate::image::Size;
use crate::on_target_run;
use crate::readers::{BOARD_LOG, READERS};
use crate::replay_run;
use crate::toolchain::{Build, Toolchain};
use crate::workspace;

/// The images that are operated.
const PRODUCTS: [&str; 2] = ["throttle", "controller"];

/// What the images came to.
#[derive(Debug)]
pub(super) struct Images {
    /// What each occupies.
    pub(super) sizes: Vec<(&'static str, Size)>,
    /// What no time was left for.
    pub(super) left: Vec<String>,
}

/// Builds the images and what runs them, and runs them; with `--cases` or `--all`, a log of each kind of verdict too, which takes
/// longest; with `--all`, besides, the calls that the texts show, as they stand there.
///
/// # Errors
/// What does not build, does not run, or does something else than is expected.
pub(super) fn run(args: &Args, limit: Limit) -> Result<Images, Failure> {
    let prepared = board_run::prepare(announce)?;
    announce("lints and tests of the reader of the board's log");
    READERS.lint(BOARD_LOG)?;
    READERS.test(BOARD_LOG)?;
    if args.is_longer() {
        // Other people's drivers of probes, minutes to build: what is our own in it is the package `rtt`, which is tested always.
        announce("lints and tests of the program at a debug probe");
        PROBE.lint("")?;
        PROBE.test("")?;
    }
    let sizes = run_images(args, &prepared)?;
    let mut left = Vec::new();
    if !args.is_longer() {
        announce("a sound actuator's log traced on the emulated chip");
        check_verdicts(&prepared.first_verdict()?)?;
    } else if limit.is_reached() {
        left.push("a log of each kind of verdict on the emulated chip".to_owned());
    } else {
        announce("a log of each kind of verdict on the emulated chip, which takes longest");
        check_verdicts(&prepared.verdicts()?)?;
    }
    if args.all {
        left.extend(documented::run_on_emulated_chips(limit)?);
    }
    Ok(Images { sizes, left })
}

/// What the board makes of logs, bit for bit as this host does.
fn check_verdicts(verdicts: &VerdictsRun) -> Result<(), Failure> {
    check_warnings(&verdicts.build)?;
    board_run::require_parity(&verdicts.comparisons)?;
    let names: Vec<&str> = verdicts.comparisons.iter().map(|it| it.name).collect();
    say(&format!(
        "logs traced bit for bit as on this host: {}",
        names.join(", ")
    ));
    Ok(())
}

/// Builds and lints the images and runs them on emulated chips; gives what each occupies.
fn run_images(args: &Args, prepared: &Prepared) -> Result<Vec<(&'static str, Size)>, Failure> {
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
    emulate::run::test()?;
    say(&format!(
        "both images start, answer, keep their ticks and what is saved; the loop follows its commands, and {} \
         samples of its log name what nobody declared",
        traced.samples
    ));
    Ok(())
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
