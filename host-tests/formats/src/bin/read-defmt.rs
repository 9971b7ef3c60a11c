//! The lines of a board's log as it comes, from standard input to standard output.

use std::process::ExitCode;
use std::{env, fs, io};

use formats::defmt::Dictionary;

fn main() -> ExitCode {
    formats::end(pass_on())
}

fn pass_on() -> Result<(), String> {
    let image = env::args_os()
        .nth(1)
        .ok_or("expected the board's image (ELF)")?;
    let image = fs::read(image).map_err(|error| format!("cannot be read ({error})"))?;
    Dictionary::of_bytes(&image)?
        .pass_on(io::stdin().lock(), io::stdout().lock())
        .map_err(|error| format!("has a log that cannot be passed on ({error})"))
}
