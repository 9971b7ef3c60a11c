//! `cargo hil bench gap --worlds N`: how often the tracing is right on machines that nobody chose.
//!
//! Each log is a world drawn from a seed and an index ([`rig::world`]). It goes the way of a user's: its log
//! as CSV text through the log's reader, its machine as TOML text through the machine file's. What a reader
//! or the tracing refuses counts as too little.
//!
//! An effect is *visible* where a fit that is told the truth is better by [`VISIBLE`] than one that is not, on
//! a log of the same machine under another drive ([`told`]). Where it is not visible, only a wrong name counts.

use std::path::PathBuf;
use std::time::Instant;

use indicatif::ProgressBar;
use rayon::prelude::*;
use rig::world::World;

use crate::failure::Failure;
use crate::outputs::{Kind, Outputs, print};
use crate::workspace;

mod details;
mod guesses;
mod summary;
pub mod told;
pub mod traced;
pub mod truth;

use self::summary::Summary;
use self::traced::Judged;

/// The seed, unless another one is asked for.
pub const FIRST_SEED: u64 = 1;

/// Windowed position error without over with what is told, on the other log, from which on an effect is
/// visible.
pub const VISIBLE: f64 = 1.5;

/// What is to be traced.
#[derive(Debug, Clone)]
pub struct Args {
    /// Worlds from index 0 on.
    pub count: u64,
    /// Their seed.
    pub seed: u64,
    /// The only one to be traced.
    pub only: Option<u64>,
    /// Whether each is traced with other guesses for what `[fit]` names, too.
    pub guesses: bool,
    /// Where the result goes, as JSON.
    pub json: Option<PathBuf>,
}

/// Traces the worlds and prints what came of it.
///
/// # Errors
/// A result that cannot be written; an index beyond the worlds.
pub fn run(args: &Args) -> Result<(), Failure> {
    let text = match args.only {
        Some(index) if index >= args.count => {
            return Err(Failure::Usage(format!(
                "--only {index} is beyond the worlds; expected 0 to {}",
                args.count.saturating_sub(1)
            )));
        }
        Some(index) => details::text(args.seed, index)?,
        None => all(args)?,
    };
    print(&text)
}

/// Every world, several at once; the same whatever the number of threads, but for the seconds.
fn all(args: &Args) -> Result<String, Failure> {
    let mut outputs = Outputs::reading([]);
    let json = outputs.file(args.json.as_deref(), Kind::Marked)?;
    let started = Instant::now();
    // Hidden by itself where standard error is no terminal.
    let progress = ProgressBar::new(args.count);
    let judged: Vec<Judged> = (0..args.count)
        .into_par_iter()
        .map(|index| {
            let (world, records) = World::draw(args.seed, index);
            let (mut judged, _) = traced::judge_world(&world, &records);
            if args.guesses && judged.refused.is_none() {
                let first = (&judged.verdict[..], &judged.answer);
                judged.guesses = guesses::ask(&world, &records, first);
            }
            progress.inc(1);
            judged
        })
        .collect();
    progress.finish_and_clear();
    let summary = Summary::of(args.seed, &judged);
    outputs.stage_json(json, &summary)?;
    outputs.commit()?;
    Ok(summary.text()
        + &format!(
            "\n{} worlds in {:.0} s\n",
            judged.len(),
            started.elapsed().as_secs_f64()
        ))
}

/// Where the files of single worlds are left.
fn directory() -> PathBuf {
    workspace::results().join("worlds")
}
