//! `cargo hil record`: a board armed, commanded, recorded and read, to a log and a machine file.

pub mod drive;
pub mod machine;

use std::io::{self, BufRead, IsTerminal, Write};
use std::path::{Path, PathBuf};

use firmware::app::console::parse::{Line as Parsed, parse};
use firmware::app::console::request::Request;
use firmware::app::store::field::DESCRIPTIONS;

use self::drive::{Drive, ENDS, Ending};
use crate::board_link::Line;
use crate::board_link::connection::Connection;
use crate::board_link::console::Console;
use crate::board_link::emulated::{self, Pace};
use crate::board_link::log_transfer::LogTransfer;
use crate::board_log::BoardLog;
use crate::error::tell;
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs, print};

/// What is said of it in the help.
pub const HELP: &str = "\
The actuator moves. First set the board's parameters to it, and limits to what it bears (`show`, `set`, `save` on
the console, see docs/board.md), and have its supply within reach of your hand. The drive is disarmed again at
the end, after an error and after Ctrl-C too; if it does not say so, you are told.";

/// Longest recording, s: what the board's ring holds.
const LONGEST: f64 = 10.0;

/// Shortest recording, s: less than a turn of most signals says nothing.
const SHORTEST: f64 = 0.5;

/// What `cargo hil record` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    connection: Connection,
    /// What the signal is: a position of the loop, or a voltage without a loop
    #[arg(long, value_name = "MODE", default_value = "position", value_parser = ["position", "voltage"])]
    mode: String,
    /// A signal as the console takes it [default: a sweep of 0.2 rad about where the actuator stands]
    #[arg(long, value_name = "SIGNAL")]
    signal: Option<String>,
    /// How long to drive, 0.5 to 10
    #[arg(long, value_name = "S", default_value_t = LONGEST, value_parser = seconds)]
    seconds: f64,
    /// Let the actuator move without asking first
    #[arg(long)]
    arm: bool,
    /// Write the log here; or into this directory as log.csv, with machine.toml
    #[arg(long, value_name = "LOG.csv|DIR")]
    out: PathBuf,
    /// Write the machine file of the board's parameters here
    #[arg(long, value_name = "M.toml")]
    machine_out: Option<PathBuf>,
}

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (SHORTEST..=LONGEST).contains(&seconds) => Ok(seconds),
        _ => Err(format!(
            "expected a number from {SHORTEST} to {LONGEST}, which is what the board keeps"
        )),
    }
}

/// Records a board.
///
/// # Errors
/// Outputs that are there already, a port that cannot be opened, a board that does not answer or refuses, a fault
/// on the way, a recording that nobody allowed.
pub fn run(args: &Args) -> Result<(), Failure> {
    let (log_path, machine_path) = places(args);
    let mut outputs = Outputs::reading(args.connection.port()).replacing_nothing();
    let parent = log_path.parent().filter(|_| is_directory(&args.out));
    let [log, machine] = match parent {
        Some(directory) => {
            let files = [("log.csv", Kind::Log), ("machine.toml", Kind::Marked)];
            let named = args.machine_out.as_deref();
            match (outputs.directory(Some(directory), files)?, named) {
                (Some([log, _]), Some(named)) => {
                    [Some(log), outputs.file(Some(named), Kind::Marked)?]
                }
                (Some(both), None) => both.map(Some),
                (None, _) => [None; 2],
            }
        }
        None => [
            outputs.file(Some(&args.out), Kind::Log)?,
            outputs.file(args.machine_out.as_deref(), Kind::Marked)?,
        ],
    };
    let drive = Drive {
        mode: mode(args),
        signal: args.signal.as_deref().map(signal).transpose()?,
        seconds: args.seconds,
    };
    if drive.signal.is_none() && drive.mode == "voltage" {
        return Err(Failure::Usage(
            "--mode voltage needs a --signal: no voltage is harmless to every actuator".to_owned(),
        ));
    }
    let (_emulated, mut line) = match args.connection.open()? {
        Some(line) => (None, line),
        None if args.connection.is_emulated() => {
            let (board, line) = emulated::demonstration(Pace::Free)?;
            (Some(board), line)
        }
        None => {
            let expected =
                "expected a way to the board: --port, --probe or --rtt; or --emulated without one";
            return Err(Failure::Usage(expected.to_owned()));
        }
    };
    let ending = Ending::watch(&ENDS)?;
    let recorded = record(&mut line, &drive, &ending, || permitted(args, &drive))?;
    if let Some(log) = log {
        outputs.stage(log, recorded.csv()?)?;
    }
    if let Some(machine) = machine {
        outputs.stage(machine, recorded.machine.as_str())?;
    }
    outputs.commit()?;
    print_recorded(&recorded, &log_path, machine_path.as_deref())
}

/// What was recorded.
pub struct Recorded {
    /// The log.
    pub log: BoardLog,
    /// The machine file's text.
    pub machine: String,
}

impl Recorded {
    /// The log as CSV.
    ///
    /// # Errors
    /// None of a log that was read.
    pub fn csv(&self) -> Result<String, Failure> {
        let recordings = self.log.recordings();
        let recording = recordings.first();
        recording
            .map(|recording| recording.to_csv())
            .ok_or_else(|| Failure::other("the board sent no sample"))
    }

    fn samples(&self) -> usize {
        let samples = self.log.lines.iter();
        samples.filter(|line| line.sample.is_some()).count()
    }
}

/// Records what the board at the other end does. `permitted` is asked before anything moves.
///
/// # Errors
/// As [`run`].
pub fn record(
    line: &mut dyn Line,
    drive: &Drive,
    ending: &Ending,
    permitted: impl FnOnce() -> Result<(), Failure>,
) -> Result<Recorded, Failure> {
    let mut console = Console::new(line)?;
    let machine = machine::text(&console.parameters()?)?;
    drive::require_ready(&mut console)?;
    permitted()?;
    say("recording");
    drive::drive(&mut console, drive, ending)?;
    say("reading the log, some 12 s");
    let log = dump(&mut console)?;
    Ok(Recorded { log, machine })
}

/// The log of what was driven.
///
/// # Errors
/// A line that loses some of it.
pub fn dump(console: &mut Console) -> Result<BoardLog, Failure> {
    console.order("dump log console")?;
    let mut transfer = LogTransfer::default();
    loop {
        for frame in console.frames()? {
            transfer.take(&frame).map_err(Failure::Other)?;
        }
        if let Some(log) = transfer.log() {
            return Ok(log);
        }
    }
}

fn mode(args: &Args) -> &'static str {
    if args.mode == "voltage" {
        "voltage"
    } else {
        "position"
    }
}

/// A path that is a directory, or looks like one.
fn is_directory(path: &Path) -> bool {
    path.is_dir() || path.extension().is_none() && !path.exists()
}

/// Where log and machine file go.
fn places(args: &Args) -> (PathBuf, Option<PathBuf>) {
    if is_directory(&args.out) {
        let machine = args.out.join("machine.toml");
        let machine = args.machine_out.clone().unwrap_or(machine);
        (args.out.join("log.csv"), Some(machine))
    } else {
        (args.out.clone(), args.machine_out.clone())
    }
}

/// A signal, if the console would take it as one.
fn signal(text: &str) -> Result<String, Failure> {
    match parse(text, &DESCRIPTIONS) {
        Ok(Parsed::Request(Request::Signal(_))) => Ok(text.trim().to_owned()),
        Err(error) => Err(Failure::Usage(format!("--signal: {error}"))),
        Ok(_) => Err(Failure::Usage(
            "--signal: expected step, ramp, sine, sweep or triangle with its numbers, as on the console: \
             \"sine 0 0.2 0.5\""
                .to_owned(),
        )),
    }
}

/// Whether somebody allows the actuator to move.
fn permitted(args: &Args, drive: &Drive) -> Result<(), Failure> {
    // Of an emulated one nothing moves.
    if args.arm || args.connection.is_emulated() {
        return Ok(());
    }
    let refused = "nothing moves before somebody allows it: add --arm, or type `arm` when asked on a terminal";
    if !io::stdin().is_terminal() || !io::stderr().is_terminal() {
        return Err(Failure::Usage(refused.to_owned()));
    }
    let signal = drive
        .signal
        .as_deref()
        .unwrap_or("a sweep of 0.2 rad about where it stands");
    // Who cannot read it does not answer.
    let _ = write!(
        io::stderr(),
        "The actuator will move: {signal}, {} s, {} mode. Type `arm` to let it: ",
        drive.seconds,
        drive.mode
    );
    let mut answer = String::new();
    let read = io::stdin().lock().read_line(&mut answer);
    match read {
        Ok(_) if answer.trim() == "arm" => Ok(()),
        _ => Err(Failure::Usage(refused.to_owned())),
    }
}

/// What goes on, for who looks on.
fn say(step: &str) {
    if io::stderr().is_terminal() {
        tell(format_args!("{step} ..."));
    }
}

fn print_recorded(recorded: &Recorded, log: &Path, machine: Option<&Path>) -> Result<(), Failure> {
    let samples = recorded.samples();
    let mut text = format!("{}: {samples} rows at 1 kHz\n", log.display());
    let mut machine_file = "MACHINE.toml".to_owned();
    if let Some(machine) = machine {
        text += &format!("{}: the board's parameters\n", machine.display());
        machine_file = machine.display().to_string();
    }
    text += &format!(
        "\nnext: cargo hil gap --machine {machine_file} --train {}\n",
        log.display()
    );
    print(&text)
}
