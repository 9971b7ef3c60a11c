//! `cargo hil`: the command line. Each command is a module of the library.

use std::env;
use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};
use host_tests::failure::Failure;
use host_tests::{
    bench, check, data_sheet, decode, ecu, emulate, error, export, gap, hil, identify, import,
    live, onboard, outputs, record, reproduce, track,
};

/// Firmware and model of an electromechanical actuator, closed on each other
///
/// Without a command: builds the images that are flashed and runs them on emulated STM32F405s, a throttle
/// body and the controller that drives it pin to pin; then traces what the controller's own log has and
/// its machine file lacks, judges on a second drive, and leaves logs and report in target/hil.
#[derive(Debug, Parser)]
#[command(
    name = "cargo hil",
    bin_name = "cargo hil",
    version,
    after_help = "Example: cargo hil",
    after_long_help = with_files("Example: cargo hil")
)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

const IDENTIFY_EXAMPLE: &str = "Example: cargo hil identify --machine \
     host-tests/machines/intake-throttle-12v.toml --slow triangle.csv --fast steps.csv --machine-out \
     identified.toml";
const DECODE_EXAMPLE: &str = "Example: cargo hil decode \
     target/firmware/thumbv7em-none-eabihf/release/throttle target/hil/emulate/throttle.defmt";
const GAP_EXAMPLE: &str =
    "Example: cargo hil gap --machine ema.toml --train a.csv --validate b.csv";

const IMPORT_EXAMPLE: &str = "Example: cargo hil import run.csv --time t:ms --position pos:deg --input \"duty:%*12\" --current i:mA --out log.csv";

const MACHINE_EXAMPLE: &str = "Example: cargo hil machine --name cart --voltage 12V --no-load-speed 200rpm --no-load-current 0.2A --stall-torque 21kg.cm --stall-current 5.5A --gear-ratio 50 --values-of gearmotor --encoder-counts 64 --encoder-side motor > cart.toml";

const LIVE_EXAMPLE: &str = "Example: cargo hil live";
const TRACK_EXAMPLE: &str =
    "Example: cargo hil track --machine ema.toml march.csv april.csv may.csv --limit coulomb=0.2";
const EXPORT_EXAMPLE: &str = "Example: cargo hil export --machine ema.toml --to c --out ema.c";
const RECORD_EXAMPLE: &str = "Example: cargo hil record --port /dev/ttyUSB0 --signal \"sweep 0 0.3 0.3 3 10\" --out recorded";

#[derive(Debug, Subcommand)]
enum Command {
    /// Check everything: formatting, lints, firmware, runs on emulated chips, host tests
    #[command(after_help = "Example: cargo hil test")]
    Test(check::Args),
    /// Find the effects that a measured log has and a declared machine lacks
    #[command(
        after_help = GAP_EXAMPLE,
        after_long_help = format!("{}\n\n{}", gap::catalogue::text(), with_files(GAP_EXAMPLE))
    )]
    Gap(gap::command::Args),
    /// Make a log of any logger's file: columns by name, units, signs, a rate
    #[command(
        after_help = IMPORT_EXAMPLE,
        after_long_help = format!("{}\n\n{}", import::command::COLUMN_HELP, with_files(IMPORT_EXAMPLE))
    )]
    Import(Box<import::command::Args>),
    /// Make a machine file of what a data sheet says, each number with its origin
    #[command(
        after_help = MACHINE_EXAMPLE,
        after_long_help = format!("{}\n\n{}", data_sheet::command::SHEET_HELP, with_files(MACHINE_EXAMPLE))
    )]
    Machine(Box<data_sheet::command::Args>),
    /// Identify an actuator with friction and a return spring from a slow and a fast log
    #[command(
        after_help = IDENTIFY_EXAMPLE,
        after_long_help = with_files(IDENTIFY_EXAMPLE)
    )]
    Identify(identify::command::Args),
    /// Follow friction and motor numbers over many logs in time: trend, alarm, remaining logs to a limit
    #[command(after_help = TRACK_EXAMPLE, after_long_help = with_files(TRACK_EXAMPLE))]
    Track(track::command::Args),
    /// Give the machine with its declared effects to another simulator; what that cannot express is named
    #[command(after_help = EXPORT_EXAMPLE, after_long_help = with_files(EXPORT_EXAMPLE))]
    Export(export::command::Args),
    /// Reproduce the results of a paper, ours beside them
    #[command(after_help = "Example: cargo hil reproduce throttle --json throttle.json")]
    Reproduce(reproduce::Args),
    /// Run an actuator of each kind on the emulated chip, beside this host and the truth; and the loop
    #[command(after_help = "Example: cargo hil onboard --json onboard.json")]
    Onboard(onboard::command::Args),
    /// Let an emulated engine controller find every fault of an emulated throttle body
    #[command(after_help = "Example: cargo hil ecu --json ecu.json")]
    Ecu(ecu::Args),
    /// Run the images as they are flashed on emulated chips: each alone, then wired to a loop
    #[command(after_help = "Example: cargo hil emulate --json emulate.json")]
    Emulate(emulate::command::Args),
    /// Turn a board's defmt log into lines, and its samples into CSV
    #[command(
        after_help = DECODE_EXAMPLE,
        after_long_help = with_files(DECODE_EXAMPLE)
    )]
    Decode(decode::Args),
    /// Drive a board by its console, record it, and leave a log and a machine file
    #[command(
        after_help = RECORD_EXAMPLE,
        after_long_help = format!("{}\n\n{}", record::HELP, with_files(RECORD_EXAMPLE))
    )]
    Record(record::Args),
    /// Watch and drive a board in a browser: plots, console, faults, a frozen part traced by a button
    #[command(after_help = LIVE_EXAMPLE, after_long_help = format!("{}\n\n{LIVE_EXAMPLE}", live::HELP))]
    Live(live::Args),
    /// Measure the speed on this host
    #[command(after_help = "Example: cargo hil bench --json bench.json")]
    Bench(bench::Args),
}

/// What is done with files, and then the example that every help ends with.
fn with_files(example: &str) -> String {
    format!("{}\n{}\n\n{example}", error::LIMITS, outputs::HELP)
}

fn main() -> ExitCode {
    let command_line = match CommandLine::try_parse() {
        Ok(command_line) => command_line,
        Err(error) => return usage(&error),
    };
    match run(command_line) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            error::tell(format_args!("error: {failure}"));
            failure.exit_code()
        }
    }
}

fn run(command_line: CommandLine) -> Result<(), Failure> {
    match command_line.command {
        None => hil::run(),
        Some(Command::Test(args)) => check::run(&args),
        Some(Command::Gap(args)) => gap::command::run(&args),
        Some(Command::Import(args)) => import::command::run(&args),
        Some(Command::Machine(args)) => data_sheet::command::run(&args),
        Some(Command::Identify(args)) => identify::command::run(&args),
        Some(Command::Track(args)) => track::command::run(&args),
        Some(Command::Export(args)) => export::command::run(&args),
        Some(Command::Onboard(args)) => onboard::command::run(&args),
        Some(Command::Ecu(args)) => ecu::run(&args),
        Some(Command::Emulate(args)) => emulate::command::run(&args),
        Some(Command::Reproduce(args)) => reproduce::run(&args),
        Some(Command::Decode(args)) => decode::run(&args),
        Some(Command::Record(args)) => record::run(&args),
        Some(Command::Live(args)) => live::run(&args),
        Some(Command::Bench(args)) => bench::run(&args),
    }
}

/// The command that stands first on the command line, if it is one.
fn asked_for() -> Option<String> {
    let word = env::args_os().nth(1)?;
    let line = CommandLine::command();
    let command = line.find_subcommand(word);
    command.map(|command| command.get_name().to_owned())
}

/// The first option with a number below zero behind it, which is taken for an option of its own.
fn negative() -> Option<(String, String)> {
    let words: Vec<String> = env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let is_number = |word: &str| {
        let digits = word
            .strip_prefix('-')
            .map(|word| word.trim_start_matches('.'));
        digits.is_some_and(|word| word.starts_with(|first: char| first.is_ascii_digit()))
    };
    let pair = words
        .windows(2)
        .find(|pair| pair[0].starts_with("--") && !pair[0].contains('=') && is_number(&pair[1]))?;
    Some((pair[0].clone(), pair[1].clone()))
}

/// Help goes to standard output; anything else is a usage error, in one line.
fn usage(error: &clap::Error) -> ExitCode {
    if matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion
    ) {
        // A closed standard output is no reason to fail.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let rendered = error.render().to_string();
    let mut line = String::new();
    for part in rendered.lines().map(str::trim) {
        if part.starts_with("Usage:") || part.starts_with("For more information") {
            break;
        }
        if !part.is_empty() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(part);
        }
    }
    if error.kind() == ErrorKind::UnknownArgument
        && let Some((option, value)) = negative()
    {
        line += &format!("; a value with a minus follows its option behind =: {option}={value}");
    }
    let help = match asked_for() {
        Some(command) => format!("cargo hil {command} --help"),
        None => "cargo hil help".to_owned(),
    };
    error::tell(format_args!("{}; see {help}", error::one_line(&line)));
    ExitCode::from(2)
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    use clap::Parser;
    use clap::error::ErrorKind;
    use host_tests::documents::{self, Documented};
    use host_tests::workspace;

    use super::CommandLine;

    fn is_test(name: &str) -> bool {
        [
            "host-tests",
            "host-tests/rig",
            "host-tests/rtt",
            "model-core",
        ]
        .iter()
        .any(|package| {
            let tests = workspace::root().join(package).join("tests");
            let directory: PathBuf = tests.join(name).join("main.rs");
            tests.join(format!("{name}.rs")).is_file() || directory.is_file()
        })
    }

    fn check(command: &Documented) -> bool {
        let Documented {
            words, is_whole, ..
        } = command;
        let place = format!("{}: {}", command.document, command.line);
        if words[0] != "cargo" {
            return false;
        }
        match words.get(1).map(String::as_str) {
            Some("hil") => {
                let Err(error) = CommandLine::try_parse_from(&words[1..]) else {
                    return true;
                };
                // A sentence names a command, or some of its options, or stands S for a number.
                let is_part = matches!(
                    error.kind(),
                    ErrorKind::MissingRequiredArgument
                        | ErrorKind::ValueValidation
                        | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
                );
                let is_help = error.kind() == ErrorKind::DisplayHelp;
                assert!(is_help || (is_part && !*is_whole), "{place}\n{error}");
            }
            Some("test") => {
                for pair in words.windows(2).filter(|pair| pair[0] == "--test") {
                    assert!(pair[1] == "NAME" || is_test(&pair[1]), "{place}");
                }
            }
            Some(alias) if alias.starts_with("flash-") => {
                let config = workspace::root().join(".cargo/config.toml");
                let config = fs::read_to_string(config).unwrap();
                assert!(config.contains(&format!("\n{alias} = ")), "{place}");
            }
            _ => return false,
        }
        true
    }

    /// What the texts say can be typed: this program takes it, the test is there, the alias is.
    #[test]
    fn every_command_in_the_texts_is_one_that_there_is() {
        let mut checked = 0;
        for command in documents::commands().unwrap() {
            checked += usize::from(check(&command));
        }
        assert!(checked > 50, "{checked}");
    }
}
