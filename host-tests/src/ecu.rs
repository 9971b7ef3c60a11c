//! `cargo hil ecu`: a throttle body tried out by its engine controller, fault after fault, on the
//! emulated chip beside this host.

use std::fmt::Write as _;
use std::path::PathBuf;

use firmware::app::ecu::calibration::Calibration;
use firmware::app::ecu::code::Code;
use firmware::app::ecu::loopback;
use firmware::app::ecu::schedule::{PEDAL, Report, TRIALS};
use firmware::app::machine::THROTTLE;
use serde::Serialize;

use crate::board_log::BoardLog;
use crate::board_run;
use crate::ecu_on_host::EcuOnHost;
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs, print};
use crate::progress::announce;
use crate::toolchain::Toolchain;

/// Supply of the board's throttle body, V.
const SUPPLY: f32 = 12.0;

/// What `cargo hil ecu` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Write the findings to this file as JSON
    #[arg(long, value_name = "F")]
    json: Option<PathBuf>,
}

/// What the controller found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
struct Finding {
    /// The fault that was injected; `none` for a sound throttle body.
    fault: &'static str,
    /// The code that it was found by, if any.
    code: Option<&'static str>,
    /// The trouble code of SAE J2012 next to it.
    trouble_code: Option<&'static str>,
    /// From the fault to the code, or as long as nothing was found, ms.
    after_ms: u32,
}

impl Finding {
    fn of(report: &Report) -> Self {
        Self {
            fault: TRIALS[report.trial].name,
            code: report.code.map(Code::name),
            trouble_code: report.code.map(Code::trouble_code),
            after_ms: report.steps,
        }
    }
}

/// Runs the board, compares it with this host, prints a table, writes what was asked for.
///
/// # Errors
/// What is missing on this machine; a fault that is not found, or a board that differs from this
/// host; a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    let mut outputs = Outputs::reading([]);
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    let announce = announce();
    announce("toolchain, image and the emulated chip (built once, which takes minutes)");
    let toolchain = Toolchain::set_up()?;
    announce("a throttle body and its engine controller on the emulated chip");
    let (_, log) = board_run::run_program(&toolchain, board_run::ECU)?;
    announce("the same on this host");
    let reports = on_host();
    require_parity(&log, &reports)?;
    let findings: Vec<Finding> = reports.iter().map(Finding::of).collect();
    outputs.stage_json(json, &findings)?;
    outputs.commit()?;
    let ticks = log
        .messages()
        .find_map(|line| line.value("deadlines", "ticks"));
    let mut text = table(&findings);
    // A string takes everything.
    let _ = writeln!(
        text,
        "\n{} plant ticks, none missed; every reading, answer and state of a control step bit for bit as on this host",
        ticks.unwrap_or("?")
    );
    print(&text)
}

/// The board's trials on this host.
///
/// # Panics
/// If a number of the board's is out of its range.
pub fn on_host() -> Vec<Report> {
    let body = loopback::complementary(THROTTLE.plant, loopback::SEED);
    let calibration =
        Calibration::new(&THROTTLE, &body.tracks).expect("the board's numbers in their ranges");
    let mut ecu = EcuOnHost::new(calibration, &body, SUPPLY, &TRIALS, PEDAL);
    TRIALS.iter().map(|_| ecu.next_report()).collect()
}

/// What the board is to say, after these reports.
pub fn said(reports: &[Report]) -> Vec<String> {
    let mut lines: Vec<String> = reports.iter().flat_map(said_of).collect();
    lines.push(format!("end trials={}", reports.len()));
    lines
}

fn said_of(report: &Report) -> [String; 2] {
    let name = TRIALS[report.trial].name;
    let learned = match &report.learned {
        Some(learned) => {
            let [closed, open] = learned.first_track_millivolts();
            let [from_closed, from_open] = learned.returns;
            format!(
                "learned trial={name} closed_mv={closed} open_mv={open} limp_home_permille={} \
                 from_closed_ms={from_closed} from_open_ms={from_open}",
                learned.limp_home_permille()
            )
        }
        None => format!("not learned trial={name}"),
    };
    let verdict = if report.sound {
        "found"
    } else {
        "not as expected:"
    };
    let code = report.code.map_or("none", Code::name);
    let found = format!(
        "{verdict} trial={name} code={code} after_ms={} wires={:016x}",
        report.steps, report.wires
    );
    [learned, found]
}

/// Refuses a log that is not what this host says.
fn require_parity(log: &BoardLog, reports: &[Report]) -> Result<(), Failure> {
    let board: Vec<&str> = board_run::messages(log)
        .map(|line| line.message.as_str())
        .collect();
    let host = said(reports);
    if board == host {
        return Ok(());
    }
    let differing = (0..board.len().max(host.len()))
        .map(|number| {
            (
                board.get(number).copied(),
                host.get(number).map(|line| &**line),
            )
        })
        .find(|(board, host)| board != host);
    let (board, host) = differing.unwrap_or_default();
    Err(Failure::other(format!(
        "board and host differ\n  board {}\n  host  {}",
        board.unwrap_or("nothing"),
        host.unwrap_or("nothing")
    )))
}

fn table(findings: &[Finding]) -> String {
    let mut text = String::from("A throttle body and its engine controller\n");
    let mut row = |fault: &str, code: &str, trouble_code: &str, after: &str| {
        let line = format!("{fault:<27}{code:<20}{trouble_code:<14}{after:>9}");
        text += line.trim_end();
        text.push('\n');
    };
    row("fault", "found as", "SAE J2012", "after");
    for finding in findings {
        row(
            &words(finding.fault),
            &words(finding.code.unwrap_or("nothing")),
            finding.trouble_code.unwrap_or_default(),
            &format!("{} ms", finding.after_ms),
        );
    }
    text
}

fn words(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board_log::Line;

    fn log(messages: &[String]) -> BoardLog {
        let mut log = BoardLog::default();
        log.lines.extend(messages.iter().map(|message| Line {
            time: String::new(),
            level: "INFO".to_owned(),
            message: message.clone(),
            sample: None,
        }));
        log
    }

    #[test]
    fn a_board_that_differs_in_one_digit_or_ends_early_is_refused() {
        let reports = on_host();
        let mut said = said(&reports);
        assert!(require_parity(&log(&said), &reports).is_ok());
        let end = said.pop().unwrap();
        let refusal = require_parity(&log(&said), &reports).unwrap_err();
        assert!(refusal.to_string().contains("board nothing\n  host  end"));
        said.push(end);
        let digit = said[1].pop().unwrap();
        said[1].push(if digit == '0' { '1' } else { '0' });
        let refusal = require_parity(&log(&said), &reports).unwrap_err();
        assert!(refusal.to_string().contains(&said[1]));
    }

    #[test]
    fn the_table_has_a_row_for_every_trial() {
        let findings: Vec<Finding> = on_host().iter().map(Finding::of).collect();
        let table = table(&findings);
        assert_eq!(table.lines().count(), 2 + TRIALS.len());
        let broken = table.lines().find(|line| line.starts_with("spring broken"));
        assert!(
            broken.is_some_and(|line| line.contains("spring return") && line.contains("P2119"))
        );
    }
}
