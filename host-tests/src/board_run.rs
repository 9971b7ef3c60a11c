//! The images that nobody operates, built and run on an emulated chip, and what is expected of such a run.

use firmware::app::demonstration::DEMONSTRATION;
use firmware::app::experiment::Experiment;
use firmware::app::verdicts;

use crate::board_log::{BoardLog, Line};
use crate::comparison::{self, Comparison};
use crate::dictionary;
use crate::emulate::{self, unattended};
use crate::failure::Failure;
use crate::image::Size;
use crate::toolchain::{Build, Toolchain};

/// The program that runs an actuator of each kind.
pub const ACTUATORS: &str = "stm32f405";

/// The program in which everything goes wrong that may.
pub const FAILURES: &str = "failures";

/// The program in which the board traces a log of each kind of verdict.
pub const VERDICTS: &str = "verdicts";

/// The program in which an engine controller tries out a throttle body.
pub const ECU: &str = "trials";

/// What begins the lines whose numbers are the compiler's.
const COSTS: [&str; 5] = ["cost ", "deadlines ", "exit ", "load ", "stack "];

/// A board's messages but for those that tell cycles and bytes: the same whatever it was built with.
pub fn messages(log: &BoardLog) -> impl Iterator<Item = &Line> {
    let is_cost = |line: &&Line| COSTS.iter().any(|cost| line.message.starts_with(cost));
    log.messages().filter(move |line| !is_cost(line))
}

/// Builds and runs a program of the board's. What is expected of it is what it says.
///
/// # Errors
/// A program that does not build, does not fit, or does not end in order.
pub fn run_program(toolchain: &Toolchain, program: &str) -> Result<(Build, BoardLog), Failure> {
    let build = toolchain.build(program)?;
    Size::read(&build.elf)?.fitting()?;
    let mut run = unattended::run(&build.elf, None)?;
    // What is expected of the failures is that they are named.
    if program != FAILURES {
        run = run.in_order()?;
    }
    Ok((build, run.log))
}

/// Logs of each kind of verdict, traced by the board.
pub struct VerdictsRun {
    /// What the program was built to.
    pub build: Build,
    /// What it logged, decoded.
    pub log: BoardLog,
    /// Each experiment beside the same on this host.
    pub comparisons: Vec<Comparison>,
}

/// A run of the image that ended in order.
pub struct BoardRun {
    /// What it was built to.
    pub build: Build,
    /// What it occupies.
    pub size: Size,
    /// What it logged, decoded.
    pub log: BoardLog,
    /// Each experiment beside the same on this host.
    pub comparisons: Vec<Comparison>,
}

/// What the runs need: the toolchain, the image that runs an actuator of each kind, and the emulated chip.
pub struct Prepared {
    /// What the images are built with.
    pub toolchain: Toolchain,
    build: Build,
    size: Size,
}

/// Sets up what is missing, builds the image, the emulated chip and the reader of its log. `announce` is told each
/// of these before it begins.
///
/// # Errors
/// What is missing, with the command that brings it; an image that does not build or does not fit.
pub fn prepare(mut announce: impl FnMut(&str)) -> Result<Prepared, Failure> {
    announce("toolchain");
    let toolchain = Toolchain::set_up()?;
    announce(&format!(
        "firmware, built with {}",
        toolchain.route().describe()
    ));
    let build = toolchain.build(ACTUATORS)?;
    let size = Size::read(&build.elf)?.fitting()?;
    announce("the emulated chip (built once, which takes minutes)");
    emulate::run::build()?;
    announce(dictionary::BUILDING);
    dictionary::build()?;
    Ok(Prepared {
        toolchain,
        build,
        size,
    })
}

impl Prepared {
    /// Runs the actuator of each kind, and compares with this host.
    ///
    /// # Errors
    /// A run that does not end in order; a board that reports an error.
    pub fn actuators(&self) -> Result<BoardRun, Failure> {
        let log = unattended::run(&self.build.elf, None)?.in_order()?.log;
        let comparisons = compare(&log, &DEMONSTRATION).map_err(Failure::Other)?;
        Ok(BoardRun {
            build: self.build.clone(),
            size: self.size,
            log,
            comparisons,
        })
    }

    /// Builds the program that traces a log of each kind of verdict, runs it up to the second of these logs, and
    /// compares the first with this host: a sound actuator, in which there is nothing to find.
    ///
    /// # Errors
    /// As [`unattended::run_up_to`]; a board that reports an error.
    pub fn first_verdict(&self) -> Result<VerdictsRun, Failure> {
        let build = self.toolchain.build(VERDICTS)?;
        Size::read(&build.elf)?.fitting()?;
        let [first, second, ..] = verdicts::VERDICTS;
        let is_second = |line: &Line| line.value("experiment", "name") == Some(second.name);
        let log = unattended::run_up_to(&build.elf, is_second)?;
        let comparisons = compare(&log, &[first]).map_err(Failure::Other)?;
        Ok(VerdictsRun {
            build,
            log,
            comparisons,
        })
    }

    /// Builds and runs the program that traces a log of each kind of verdict, and compares with this host. It is
    /// the longest run of all: let it run beside another.
    ///
    /// # Errors
    /// As [`run_program`]; a board that reports an error.
    pub fn verdicts(&self) -> Result<VerdictsRun, Failure> {
        let (build, log) = run_program(&self.toolchain, VERDICTS)?;
        let comparisons = compare(&log, &verdicts::VERDICTS).map_err(Failure::Other)?;
        Ok(VerdictsRun {
            build,
            log,
            comparisons,
        })
    }
}

impl BoardRun {
    /// Bytes of the stack that were used, with the check and an interrupt in an interrupt in them.
    ///
    /// # Errors
    /// A log that does not tell.
    pub fn stack(&self) -> Result<u64, Failure> {
        let said = self
            .log
            .messages()
            .find_map(|line| line.value("stack", "used"));
        said.and_then(|text| text.parse().ok())
            .ok_or_else(|| Failure::other("the board does not tell how much of its stack it used"))
    }

    /// Samples compared with this host's.
    pub fn samples(&self) -> usize {
        self.comparisons
            .iter()
            .map(|experiment| experiment.samples)
            .sum()
    }

    /// Refuses a run in which board and host differ in a bit.
    ///
    /// # Errors
    /// What differs first.
    pub fn require_parity(&self) -> Result<(), Failure> {
        require_parity(&self.comparisons)
    }
}

/// Refuses experiments in which board and host differ in a bit.
///
/// # Errors
/// What differs first.
pub fn require_parity(comparisons: &[Comparison]) -> Result<(), Failure> {
    match comparisons.iter().find(|experiment| !experiment.is_equal()) {
        None => Ok(()),
        Some(experiment) => Err(Failure::Other(difference(experiment))),
    }
}

fn difference(experiment: &Comparison) -> String {
    let mut text = format!("{}: board and host differ", experiment.name);
    if let Some((board, host)) = &experiment.first {
        text += &format!(
            " in {} bits of the samples, first\n  board {board:?}\n  host  {host:?}",
            experiment.differing_bits
        );
    }
    for (board, host) in &experiment.lines {
        text += &format!("\n  board {board}\n  host  {host}");
    }
    text
}

/// Compares a log that reports no error with this host's.
fn compare(log: &BoardLog, experiments: &[Experiment]) -> Result<Vec<Comparison>, String> {
    if let Some(line) = log.messages().find(|line| line.level == "ERROR") {
        return Err(format!("the emulated chip reports: {line}"));
    }
    comparison::compare(log, experiments)
}
