//! Plain `cargo hil`: the images that are flashed, on emulated chips, wired to a loop, and the loop closed on the
//! log that the controller recorded of it.

use std::io::{self, IsTerminal};
use std::thread;

use crate::emulate::command::{demonstrate, require};
use crate::emulate::run::{Built, CYCLES_PER_INSTRUCTION, Extent};
use crate::emulate::summary::Summary;
use crate::failure::Failure;
use crate::first_result;
use crate::gap::report;
use crate::gap::table::{self, Detail};
use crate::outputs::{print, write_own};
use crate::progress::announce;
use crate::toolchain::Toolchain;
use crate::workspace;

/// Traces the logs of an example while the emulated chips and the images are built; runs the images, traces the
/// controller's log, judges on a drive that nothing was fitted to, leaves the report in
/// `target/hil/index.html`, and prints tables.
///
/// # Errors
/// What is missing on this machine, or what is not in order with the run.
pub fn run() -> Result<(), Failure> {
    let mut announce = announce();
    let built = thread::scope(|scope| {
        announce("a first answer, from a data sheet and two logs in the tree");
        let building = scope.spawn(|| Built::new(&Toolchain::set_up()?, &mut announce));
        let first = first_result::trace().and_then(|answer| {
            print(&format!(
                "A gearmotor of which there are a data sheet and two logs, in {}\n{answer}\n",
                workspace::shown(&first_result::directory())
            ))
        });
        let built = building
            .join()
            .unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        first.and(built)
    })?;
    let (outcome, traced) =
        demonstrate(&built, CYCLES_PER_INSTRUCTION, Extent::Loop, &mut announce)?;
    let page = workspace::results().join("index.html");
    let drawn =
        report::page(&traced.report).map_err(|error| Failure::system("the report", &error))?;
    write_own(&page, drawn)?;
    let summary = Summary::new(&outcome, &traced, CYCLES_PER_INSTRUCTION);
    let colour = io::stdout().is_terminal();
    print(&format!(
        "The log that the controller recorded in its loop\n{}\n{}report       {}\n",
        table::render(&traced.report, colour, Detail::Brief { hint: None }),
        summary.text(&outcome, &traced, None),
        workspace::shown(&page)
    ))?;
    require(&outcome, &traced, None)
}
