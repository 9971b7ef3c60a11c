//! Plain `cargo hil`: the control loop on the emulated board, its log, and the loop closed on it.

use std::fmt::Write as _;
use std::fs;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

use firmware::app::record::Sample;

use crate::board_run::{self, BoardRun};
use crate::failure::Failure;
use crate::gap::{self, engine, report};
use crate::log::Log;
use crate::machine::Machine;
use crate::workspace;

/// The machine file that declares the emulated actuator, from the workspace's root.
pub const MACHINE: &str = "host-tests/machines/ema-24v.toml";

/// Runs the emulated board, writes `target/hil/emulated.csv` (and what the board sent,
/// `emulated.defmt`), traces the log's residual to what the machine file lacks, leaves the report
/// in `target/hil/index.html`, and prints a table.
///
/// # Errors
/// What is missing on this machine, or what is not in order with the run.
pub fn run() -> Result<(), Failure> {
    let on_terminal = io::stderr().is_terminal();
    let run = board_run::run(|step| {
        if on_terminal {
            eprintln!("{step} ...");
        }
    })?;
    let directory = workspace::results();
    let csv = directory.join("emulated.csv");
    fs::create_dir_all(&directory)
        .and_then(|()| fs::write(directory.join("emulated.defmt"), &run.sent))
        .and_then(|()| run.log.write_csv(&csv))
        .map_err(|error| Failure::system(directory.display(), &error))?;
    if on_terminal {
        eprintln!("tracing the residual of the board's log ...");
    }
    let machine = Machine::read(&workspace::root().join(MACHINE))?;
    let shown = |path: &Path| {
        let inside = path.strip_prefix(workspace::root()).unwrap_or(path);
        inside.display().to_string()
    };
    let log = Log {
        // As the report is to name it, on whatever machine.
        path: shown(&csv).into(),
        ..Log::read(&csv)?
    };
    let found = engine::run(&machine, &[log], || Ok(Vec::new()), |_| ())?;
    report::write(&found, &directory)
        .map_err(|error| Failure::system(directory.display(), &error))?;
    let mut text = gap::table::render(&found, io::stdout().is_terminal());
    text.push_str("\nThe emulated board\n");
    text += &table(&[
        ("built with", run.toolchain.route().describe().to_owned()),
        ("image", run.size.to_string()),
        ("samples", samples(&run)),
        ("tracking error", tracking(run.log.samples())),
        ("log", shown(&csv)),
        ("report", shown(&directory.join("index.html"))),
    ]);
    io::stdout()
        .write_all(text.as_bytes())
        .map_err(|error| Failure::system("standard output", &error))
}

fn samples(run: &BoardRun) -> String {
    format!(
        "{}, none dropped, bit for bit as on this host",
        run.log.samples().count()
    )
}

/// How far the position was from what was asked for.
fn tracking<'a>(samples: impl Iterator<Item = &'a Sample>) -> String {
    let (mut squares, mut count) = (0.0, 0.0);
    let mut last = 0.0;
    for sample in samples {
        last = f64::from(sample.command) - f64::from(sample.position);
        squares += last * last;
        count += 1.0;
    }
    let rms = (squares / f64::max(count, 1.0)).sqrt();
    format!("{rms:.3} rad rms, {last:.4} rad at the end")
}

fn table(rows: &[(&str, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    rows.iter().fold(String::new(), |mut text, (name, value)| {
        // A string takes everything.
        let _ = writeln!(text, "{name:width$}  {value}");
        text
    })
}
