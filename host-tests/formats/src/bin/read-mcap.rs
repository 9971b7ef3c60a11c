//! The columns of a file, from standard input to standard output.

use std::process::ExitCode;

fn main() -> ExitCode {
    formats::run(formats::mcap::read)
}
