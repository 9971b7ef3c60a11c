//! The test bench's paper: *Experimental Characterization and Modeling of Nonlinear Effects in
//! Electromechanical Actuators for Prognostic Capabilities*.
//!
//! A synchronous motor, a gearbox, an encoder behind adjustable play and a brake. Each module is a
//! topic of the paper and gives a section: its tables, its figures and its entries of the JSON. A
//! further topic is a module and a line of `TOPICS`.

use std::path::Path;

use rig::pmsm_bench::BacklashLevel;

use self::section::Section;
use crate::failure::Failure;
use crate::outputs::{Kind, Outputs, print, write_own};
use crate::page::{self, escape};
use crate::progress::announce;
use crate::reproduce::Entry;
use crate::workspace;

pub mod backlash_map;
pub mod consistency;
pub mod cost;
pub mod errors;
pub mod friction_map;
pub mod gears;
pub mod load_cell;
pub mod play;
pub mod points;
pub mod polynomial;
pub mod reconstruction;
pub mod residuals;
mod section;
pub mod stick_slip;

/// A topic: what is announced while it is worked out, and its work, of which tracing is done at these levels of backlash.
type Topic = (
    &'static str,
    fn(&[BacklashLevel]) -> Result<Section, Failure>,
);

/// The topics in the order of the report.
const TOPICS: [Topic; 8] = [
    ("map of the friction", |_| friction_map::section()),
    ("harmonics of the load cell", |_| load_cell::section()),
    ("map of the backlash", |_| backlash_map::section()),
    ("fifteen points", |_| points::report::section()),
    ("the two open residuals", residuals::report::section),
    ("cost", |_| cost::section()),
    ("stick-slip", |_| stick_slip::report::section()),
    ("the paper's own numbers", |_| consistency::section()),
];

/// What the report begins with.
const FINDING: &str = "Maps, harmonics, stick-slip and data sheets, worked out again from what is \
     printed; the model at the fifteen points of friction and backlash, and what it costs. Where the paper's numbers do not agree with each other, it is said.";

/// Runs every topic, prints the tables, leaves the report in `target/hil/bench`. `short`: of the levels of backlash
/// the widest alone is traced.
///
/// # Errors
/// A file that cannot be written; parameters that the core does not take.
pub fn run(json: Option<&Path>, short: bool) -> Result<(), Failure> {
    let directory = workspace::results().join("bench");
    let mut outputs = Outputs::reading([]);
    outputs.fills(&directory);
    let json = outputs.file(json, Kind::Marked)?;
    let announce = announce();
    let all = &BacklashLevel::ALL;
    let levels = if short { &all[all.len() - 1..] } else { all };
    let mut sections = Vec::new();
    for (step, topic) in TOPICS {
        announce(step);
        sections.push(topic(levels)?);
    }
    let index = directory.join("index.html");
    write_own(&index, report(&sections))?;
    let entries: Vec<&Entry> = sections.iter().flat_map(|it| &it.entries).collect();
    outputs.stage_json(json, &entries)?;
    outputs.commit()?;
    let mut text: String = sections.iter().map(Section::text).collect();
    text += &format!("report   {}\n", workspace::shown(&index));
    print(&text)
}

fn report(sections: &[Section]) -> String {
    let mut body = format!(
        "<header>\n<p class=\"kind\">A paper reproduced</p>\n<h1>A test bench for electromechanical \
         actuators</h1>\n<p class=\"finding\">{}</p>\n</header>\n",
        escape(FINDING)
    );
    body.extend(sections.iter().map(Section::html));
    let foot = ["Tables 5.1 and 5.2 stand in host-tests/traces, digit by digit.".to_owned()];
    page::page("Test bench paper, reproduced", &body, &foot)
}

/// The rows of a table of the paper that is kept as CSV.
fn rows<R: serde::de::DeserializeOwned>(table: &str) -> Vec<R> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_reader(table.as_bytes());
    let rows: Result<Vec<R>, _> = reader.deserialize().collect();
    rows.expect("the tables are part of the program")
}
