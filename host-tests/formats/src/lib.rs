//! Columns of numbers of an MCAP, MDF or Parquet file, for `cargo hil import`; lines of a board's defmt log.
//!
//! Each format is a feature and a program of its own. It reads the file from standard input; its argument is how
//! many bytes of numbers there may be. What goes to standard output is one line of JSON,
//! `{"layout": …, "columns": [{"name", "unit", "group", "length"}]}`, and behind it the columns one after the other, `f64` of
//! the least significant byte first, NaN where there is no number. What is wrong with a file is said on standard
//! error, as the end of a sentence, with exit status 2.
//!
//! Of the log's program, the argument is the image, of which the same is said. A line of JSON for each frame goes to
//! standard output as soon as the frame has come.

mod columns;
#[cfg(feature = "defmt")]
pub mod defmt;
mod guard;
#[cfg(feature = "mcap")]
pub mod mcap;
#[cfg(feature = "mdf")]
pub mod mdf;
#[cfg(feature = "parquet")]
pub mod parquet;
#[cfg(feature = "mcap")]
mod ros;

use std::io::{self, Read};
use std::process::ExitCode;

pub use columns::{Column, Columns};
use guard::guarded;

/// Reads a file of at most so many bytes of numbers.
pub type Reader = fn(Vec<u8>, usize) -> Result<Columns, String>;

/// Runs a program of this package.
pub fn run(reader: Reader) -> ExitCode {
    end(pass_on(reader))
}

/// The exit status of a program of this package; says what is wrong.
pub fn end(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::from(2)
        }
    }
}

fn pass_on(reader: Reader) -> Result<(), String> {
    let most = std::env::args()
        .nth(1)
        .and_then(|most| most.parse().ok())
        .ok_or("expected how many bytes of numbers there may be")?;
    let mut bytes = Vec::new();
    io::stdin()
        .lock()
        .read_to_end(&mut bytes)
        .map_err(|error| format!("cannot be read ({error})"))?;
    guarded(|| reader(bytes, most))
        .unwrap_or_else(|| Err("is damaged beyond what its reader bears".to_owned()))?
        .write(&mut io::stdout().lock())
        .map_err(|error| format!("cannot be passed on ({error})"))
}
