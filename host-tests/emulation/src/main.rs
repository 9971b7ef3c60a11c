//! Runs the images as they are flashed on emulated chips. `cargo hil emulate` builds and calls it.

mod board;
mod chip;
mod ecu;
mod harness;
mod probe;
mod random;
mod running;
mod scenario;

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match scenario::run(&arguments) {
        Ok(report) => {
            println!("{report}");
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}
