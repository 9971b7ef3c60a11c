//! Plain `cargo hil`: the control loop on the emulated board, its log, and the loop closed on it.

use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;

use firmware::app::demonstration::UNDECLARED;

use crate::board_run;
use crate::failure::Failure;
use crate::gap::table::Detail;
use crate::gap::{self, engine, report};
use crate::log::Log;
use crate::machine::Machine;
use crate::on_target_run;
use crate::onboard::outcome::Onboard;
use crate::outputs::write_own;
use crate::workspace;

/// The machine file that declares the emulated actuator, from the workspace's root.
pub const MACHINE: &str = "host-tests/machines/ema-24v.toml";

/// Runs the emulated board, writes its logs to `target/hil` (one CSV an experiment, and what the
/// board sent, `emulated.defmt`), traces the residual of the log that the board checked itself to
/// what the machine file lacks, leaves the report in `target/hil/index.html`, and prints tables.
///
/// # Errors
/// What is missing on this machine, or what is not in order with the run.
pub fn run() -> Result<(), Failure> {
    let on_terminal = io::stderr().is_terminal();
    let mut announce = |step: &str| {
        if on_terminal {
            eprintln!("{step} ...");
        }
    };
    let run = board_run::run(&mut announce)?;
    run.require_parity()?;
    announce("instruction counts");
    let counts = on_target_run::run(&run.toolchain)?.counts;
    let directory = workspace::results();
    write_own(&directory.join("emulated.defmt"), &run.sent)?;
    for recording in run.log.recordings() {
        write_own(&csv(recording.name), recording.to_csv())?;
    }
    announce("tracing the residual of the board's log");
    let machine = Machine::read(&workspace::root().join(MACHINE))?;
    let log = Log {
        // As the report is to name it, on whatever machine.
        path: workspace::shown(&csv(UNDECLARED.name)).into(),
        ..Log::read(&csv(UNDECLARED.name))?
    };
    let found = engine::run(&machine, &[log], || Ok(Vec::new()), |_| ())?;
    let page = report::page(&found).map_err(|error| Failure::system("the report", &error))?;
    write_own(&directory.join("index.html"), page)?;
    let detail = Detail::Brief { hint: None };
    let mut text = gap::table::render(&found, io::stdout().is_terminal(), detail);
    text.push_str("\nThe emulated board, by itself\n");
    text += &Onboard::read(&run, None, &counts)?.table();
    text += &format!(
        "built with   {}\nlogs         {}\nreport       {}\n",
        run.toolchain.route().describe(),
        workspace::shown(&directory.join("*.csv")),
        workspace::shown(&directory.join("index.html"))
    );
    io::stdout()
        .write_all(text.as_bytes())
        .map_err(|error| Failure::system("standard output", &error))
}

/// Where an experiment's log is left.
fn csv(experiment: &str) -> PathBuf {
    workspace::results().join(experiment).with_extension("csv")
}
