//! The command line of `cargo hil export`.

use std::io::{self, Write};
use std::path::PathBuf;

use super::{Source, c, fmu, mujoco};
use crate::error::{InputError, warn};
use crate::failure::Failure;
use crate::machine::Machine;
use crate::outputs::{Kind, Outputs};

/// The simulator that is exported to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Target {
    /// One file of C99 that needs math.h alone
    C,
    /// A Functional Mock-up Unit, FMI 2.0 for co-simulation; needs --out
    Fmu,
    /// A MuJoCo model, MJCF
    Mujoco,
}

impl Target {
    fn name(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Fmu => "fmu",
            Self::Mujoco => "mujoco",
        }
    }
}

/// What `cargo hil export` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Machine file; its declared_effects come along, as `gap --machine-out` writes them
    #[arg(long, value_name = "M.toml")]
    pub machine: PathBuf,
    /// What it is exported to
    #[arg(long, value_enum, value_name = "TARGET")]
    pub to: Target,
    /// Write to this file instead of standard output
    #[arg(long, value_name = "F")]
    pub out: Option<PathBuf>,
}

/// Exports the machine, and names on standard error what the target does not express.
///
/// # Errors
/// A wrong machine file, before anything is written; or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.to == Target::Fmu && args.out.is_none() {
        let message = "an FMU is an archive, which needs a file: give --out NAME.fmu";
        return Err(Failure::Usage(message.into()));
    }
    let mut outputs = Outputs::reading([&args.machine]);
    let out = outputs.file(args.out.as_deref(), Kind::Marked)?;
    let source = Source::new(Machine::read(&args.machine)?)?;
    let (bytes, missing) = match args.to {
        Target::C => {
            let (text, missing) = c::text(&source);
            (text.into_bytes(), missing)
        }
        Target::Fmu => fmu::archive(&source)?,
        Target::Mujoco => {
            let (text, missing) = mujoco::text(&source);
            (text.into_bytes(), missing)
        }
    };
    let named: Vec<InputError> = missing
        .iter()
        .map(|it| {
            let message = format!("in `{}`, {}", args.to.name(), it.what);
            InputError::new(&args.machine, it.line, message)
        })
        .collect();
    warn(&named);
    match out {
        Some(out) => {
            outputs.stage(out, bytes)?;
            outputs.commit()
        }
        None => io::stdout()
            .write_all(&bytes)
            .map_err(|error| Failure::system("standard output", &error)),
    }
}
