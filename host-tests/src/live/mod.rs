//! `cargo hil live`: a board's position, current, command and faults as they come, in a browser on this computer.
//!
//! [`board`] holds the board's line in a thread of its own; [`server`] answers the page, and nobody else;
//! [`frozen`] is what is kept of a moment and handed to `cargo hil gap`. Nothing moves before the page's `Arm`
//! was pressed, and nothing goes on moving without the page.

pub mod board;
pub mod frozen;
pub mod guard;
pub mod server;
pub mod trigger;

use std::io::{self, Read, Write};
use std::path::PathBuf;

use self::board::Board;
use self::guard::Guard;
use self::server::Server;
use crate::board_link::connection::Connection;
use crate::board_link::emulated::{self, Pace};
use crate::error::tell;
use crate::failure::Failure;
use crate::outputs::Outputs;
use crate::record::drive::{ENDS, Ending};
use crate::workspace;

/// What is said of it in the help.
pub const HELP: &str = "\
Prints an address for a browser on this computer and serves that page alone, until Ctrl-C. Whoever knows the
address may drive the board. Nothing moves before Arm is pressed in the page, and the drive is disarmed when the
page is closed. Without --port, --probe or --rtt a controller is emulated, with a motor whose viscous friction\ndepends on the direction of motion, which its parameters do not say.";

/// What `cargo hil live` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    connection: Connection,
    /// The machine that a frozen part is held against [default: the board's own parameters]
    #[arg(long, value_name = "M.toml")]
    machine: Option<PathBuf>,
    /// Where frozen parts go, with their reports; nothing there is replaced
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Port on 127.0.0.1 for the browser [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    listen: u16,
}

/// Serves the page until the program is told to end.
///
/// # Errors
/// A port or a board that is not there, a machine file that is none, an address that is taken.
pub fn run(args: &Args) -> Result<(), Failure> {
    if let Some(machine) = &args.machine {
        // What is wrong with it is said now, not when something was frozen.
        crate::machine::Machine::read(machine)?;
    }
    let directory = args.out.clone();
    let directory = directory.unwrap_or_else(|| workspace::results().join("live"));
    // Whether anything can be written there is said now too.
    Outputs::reading(&args.machine).directory(Some(&directory), [])?;
    let (emulated, line) = match args.connection.open()? {
        Some(line) => (None, line),
        None => {
            let (board, line) = emulated::demonstration(Pace::RealTime)?;
            (Some(board), line)
        }
    };
    let ending = Ending::watch(&ENDS)?;
    let board = Board::start(line, emulated, directory, args.machine.clone())?;
    let server = Server::bind(args.listen, Guard::new(random()?), random()?)?;
    let mut out = io::stdout();
    writeln!(out, "{}", server.address())
        .and_then(|()| out.flush())
        .map_err(|error| Failure::system("standard output", error))?;
    tell("open this address in a browser on this computer; Ctrl-C ends it and disarms the drive");
    let _deferred = crate::outputs::defer_signals();
    let served = server.serve(&board, || ending.is_asked() || board.has_ended());
    let ended = board.end();
    served.and(ended)
}

/// 128 random bits in hexadecimal digits: who does not see the printed address cannot guess it.
fn random() -> Result<String, Failure> {
    let mut bytes = [0; 16];
    std::fs::File::open("/dev/urandom")
        .and_then(|mut random| random.read_exact(&mut bytes))
        .map_err(|error| Failure::system("/dev/urandom", error))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}
