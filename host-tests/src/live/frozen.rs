//! What is kept of a moment: the board's log around it, as files, and what `cargo hil gap` makes of it.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use serde::Serialize;

use crate::board_log::BoardLog;
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs};

/// Every how many-th row the page draws: 100 a second.
const DRAWN: usize = 10;

/// A frozen part.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Frozen {
    /// The log.
    pub csv: PathBuf,
    /// The machine that it is held against.
    pub machine: PathBuf,
    /// Where a report would go.
    pub report: PathBuf,
    /// Time, bridge voltage, position and current, some of the rows: s, V, rad, A.
    pub rows: Vec<[f64; 4]>,
}

/// How far `gap` is with it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case", tag = "stage", content = "text")]
pub enum Gap {
    /// Nobody has asked.
    None,
    /// It computes.
    Running,
    /// What it said; its report is there.
    Done(String),
    /// What it said instead.
    Failed(String),
}

impl Frozen {
    /// Writes a log beside those that are there, with the machine file that it is held against: the user's, or one
    /// of the board's parameters.
    ///
    /// # Errors
    /// A directory that cannot be written to; a log without a sample.
    pub fn write(
        log: &BoardLog,
        directory: &Path,
        machine: Option<&Path>,
        own_machine: &str,
    ) -> Result<Self, Failure> {
        let recordings = log.recordings();
        let recording = recordings
            .first()
            .ok_or_else(|| Failure::other("the board sent no sample"))?;
        let number = (1..)
            .find(|number| {
                let names = ["frozen", "machine", "report"];
                names.iter().all(|name| {
                    let taken = |end| directory.join(format!("{name}-{number}{end}")).exists();
                    !["", ".csv", ".toml"].into_iter().any(taken)
                })
            })
            .unwrap_or(u32::MAX);
        let (csv, toml) = (
            format!("frozen-{number}.csv"),
            format!("machine-{number}.toml"),
        );
        let mut outputs = Outputs::reading([]).replacing_nothing();
        let files = [(csv.as_str(), Kind::Log), (toml.as_str(), Kind::Marked)];
        if let Some([log, own]) = outputs.directory(Some(directory), files)? {
            outputs.stage(log, recording.to_csv())?;
            if machine.is_none() {
                outputs.stage(own, own_machine)?;
            }
        }
        outputs.commit()?;
        let drawn = recording.samples().step_by(DRAWN).map(|sample| {
            let time_s = sample.time_us as f64 * 1e-6;
            let [input, position, current] =
                [sample.input, sample.position, sample.current].map(f64::from);
            [time_s, input, position, current]
        });
        Ok(Self {
            rows: drawn.collect(),
            machine: machine.map_or_else(|| directory.join(toml), Path::to_owned),
            csv: directory.join(csv),
            report: directory.join(format!("report-{number}")),
        })
    }

    /// Has `gap` look at it, in a thread and a program of its own.
    pub fn trace(&self, state: &Arc<Mutex<Gap>>) {
        *state.lock().unwrap_or_else(PoisonError::into_inner) = Gap::Running;
        let (frozen, state) = (self.clone(), state.clone());
        thread::spawn(move || {
            let gap = frozen.traced().unwrap_or_else(Gap::Failed);
            *state.lock().unwrap_or_else(PoisonError::into_inner) = gap;
        });
    }

    fn traced(&self) -> Result<Gap, String> {
        let program = std::env::current_exe().map_err(|error| error.to_string())?;
        let output = Command::new(program)
            .arg("gap")
            .arg("--machine")
            .arg(&self.machine)
            .arg("--train")
            .arg(&self.csv)
            .arg("--report")
            .arg(&self.report)
            .stdin(Stdio::null())
            .output()
            .map_err(|error| error.to_string())?;
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
        if output.status.success() {
            Ok(Gap::Done(text(&output.stdout)))
        } else {
            Err(text(&output.stderr))
        }
    }
}
