//! The command line of `cargo hil import`.

use std::io;
use std::path::{Path, PathBuf};

use super::call;
use super::convert::convert;
use super::groups::bring_together;
use super::layout::{Delimiter, Reading};
use super::page;
use super::raw::Raw;
use super::recipe::{Recipe, Turn};
use super::source::Source;
use super::summary;
use super::suspect::{counted_position, many_turns, suspicions};
use crate::error::{InputError, LARGEST_DATA, escaped, read_at_most, read_bytes, unreadable, warn};
use crate::failure::Failure;
use crate::log::fault::{Fault, Mend};
use crate::log::{COLUMNS, Log, TIME, quoted};
use crate::machine::Machine;
use crate::outputs::{Kind, Outputs, print};

/// What `cargo hil import` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// File of a logger: text with a row a sample, MATLAB of version 5 to 7.2, MCAP, MDF 4 or Parquet, as it is
    /// or behind gzip; `-` is standard input
    #[arg(value_name = "RAW")]
    pub raw: PathBuf,
    /// Column with the time, as in t:ms; without it the rows are taken to be evenly spaced, at --rate
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub time: Option<String>,
    /// Column with what the drive was told, as in duty:%*12
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub input: String,
    /// Column with the position, as in pos:deg, enc:counts/4096, -x:mm, or, of a belt or a screw, enc:counts*0.005:mm
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub position: String,
    /// Column with the position asked for
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub command: Option<String>,
    /// Column with the motor current, as in i:mA
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub current: Option<String>,
    /// Column with the velocity, as in w:rpm
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub velocity: Option<String>,
    /// Column with the friction that a brake adds, N·m or N
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub brake: Option<String>,
    /// Column with a measured external torque or force, against positive motion
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub load_torque: Option<String>,
    /// Column that is 0 while the drive is off and no current flows through the motor
    #[arg(long, value_name = "COLUMN", allow_hyphen_values = true)]
    pub enabled: Option<String>,
    /// The position (and command) jumps back after each turn, or after TURN counts of the file: make it continuous
    #[arg(long, value_name = "TURN", num_args = 0..=1)]
    pub unwrap: Option<Option<f64>>,
    /// Rate of the log, Hz; without it that of the rows
    #[arg(long, value_name = "HZ")]
    pub rate: Option<f64>,
    /// Use only these lines of the file (of arrays: elements), as in 2-5001
    #[arg(long, value_name = "FIRST-LAST", value_parser = lines)]
    pub lines: Option<(usize, usize)>,
    /// Put the rows into the order of their time
    #[arg(long)]
    pub sort: bool,
    /// Leave out rows in which a number is missing or impossible; short gaps are filled in
    #[arg(long)]
    pub skip_bad: bool,
    /// What separates the fields: one character, or comma, semicolon, tab, space; else it is found
    #[arg(long, value_name = "CHARACTER")]
    pub delimiter: Option<String>,
    /// Numbers are written with decimal commas; else that is found
    #[arg(long)]
    pub decimal_comma: bool,
    /// The line with the names, 0 if there are none; else it is found
    #[arg(long, value_name = "LINE")]
    pub header: Option<usize>,
    /// What lines of comment begin with; else #, %, //, ! and * are found
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    pub comment: Option<String>,
    /// Write the log to this file, which must not be there yet
    #[arg(long, value_name = "LOG.csv")]
    pub out: PathBuf,
    /// Check the log against this machine file: say which units, signs, counts a turn or supply voltage contradict it
    #[arg(long, value_name = "M.toml")]
    pub machine: Option<PathBuf>,
    /// Write plots of the columns to index.html in this directory, which must not be there yet
    #[arg(long, value_name = "DIR")]
    pub report: Option<PathBuf>,
}

/// What a column may be, for the help.
pub const COLUMN_HELP: &str = "\
A COLUMN is a name or a number from 1, then what is done to it, from left to right: :UNIT, *NUMBER,
/NUMBER, +NUMBER, -NUMBER; a - in front reverses the sign in the end. @COLUMN behind that gives a size
its sign, as of a drive with a direction pin: pwm:%*12@dir is negative where dir is 0 or negative. Units:
  time      s ms us ns min h day; time stamps with a clock, as 06:29:54.123 or those of ISO 8601, need none
  position  rad mrad deg rev counts/4096 (so many a turn), m cm mm um in; counts*0.005:mm (so much a count)
  velocity  rad/s deg/s rpm rev/s counts/4096, m/s cm/s mm/s m/min
  input     V mV A mA N·m mN·m N mN; % and duty (with the supply: duty:%*12); counts (with a factor)
  torque    N·m mN·m N·cm oz·in N kN
Nm is N·m, us is µs. Without a unit the values are taken as they are. A file with decimal commas,
semicolons, a header behind some lines of comment, units in a line of their own, or another encoding
is read without being told. A log that jitters, misses rows or comes at two rates is resampled as
`cargo hil gap` would do it, and what that changed is printed.";

/// Imports a file: prints what it found, writes the log and the report.
///
/// # Errors
/// A wrong call or file, before anything is written; or a result that cannot be written.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.time.is_none() && args.rate.is_none() {
        return Err(Failure::Usage(
            "expected --time with the column of the time, or, for rows that are even, --rate with how many there are in a \
             second"
                .to_owned(),
        ));
    }
    let input = if is_standard_input(&args.raw) {
        PathBuf::from("/dev/stdin")
    } else {
        args.raw.clone()
    };
    let mut outputs =
        Outputs::reading([&input].into_iter().chain(&args.machine)).replacing_nothing();
    let out = outputs.file(Some(&args.out), Kind::Log)?;
    let report = outputs.directory(args.report.as_deref(), [("index.html", Kind::Marked)])?;
    let machine = args.machine.as_deref().map(Machine::read).transpose()?;
    let (name, bytes) = read(&args.raw)?;
    let path = Path::new(&name);
    let mut raw = Raw::read(path, &bytes, &reading(args)?)?;
    drop(bytes);
    let recipe = recipe(args)?;
    let brought = bring_together(&mut raw, &recipe).map_err(Failure::Usage)?;
    let sources = recipe.parsed(&raw).map_err(Failure::Usage)?;
    let converted = convert(&args.raw, &raw, &recipe, &sources)
        .map_err(|fault| refusal(args, path, &raw, &recipe, fault))?;
    let doubt = |fault: &Fault| InputError::new(path, Some(fault.line), &fault.message);
    warn(&converted.doubts.iter().map(doubt).collect::<Vec<_>>());
    let mut suspicions = suspicions(&raw, &sources, &converted.columns, machine.as_ref());
    suspicions.extend(many_turns(&sources, &converted));
    let again = recipe
        .with_remedies(&suspicions)
        .and_then(|mended| call::tried_beside(&args.out, &args.raw, &raw, mended));
    let is_linear = summary::is_linear(&sources, machine.as_ref());
    let mut text = summary::render(&name, &raw, &sources, &converted, is_linear, &args.out);
    for sentence in brought {
        text += &format!("{sentence}\n");
    }
    text += &summary::doubts(&suspicions, again.as_ref(), &args.out);
    if let Some(machine) = &machine {
        // The log as it will lie there: what is printed is a call that imports it.
        let log = Log {
            path: args.out.clone(),
            ..converted.log.clone()
        };
        // A column that is to be looked at again would make the machine file look wrong.
        text += &if suspicions.is_empty() {
            let counted = counted_position(&raw, &sources, machine);
            summary::compared(machine, &log, counted)
        } else {
            format!(
                "Not compared with {}: first see to what is said above.\n",
                machine.path.display()
            )
        };
    }
    if let Some([index]) = report {
        let html = page::html(&name, &converted.log, &sources, is_linear, &text);
        outputs.stage(
            index,
            html.map_err(|error| Failure::system("the report", &error))?,
        )?;
    }
    if let Some(out) = out {
        outputs.stage(out, converted.log.to_csv())?;
    }
    outputs.commit()?;
    // The names of its columns are whoever's wrote the file.
    print(&escaped(&text))
}

/// What the file holds, and its name for messages.
fn read(raw: &Path) -> Result<(String, Vec<u8>), Failure> {
    const EXPECTED: &str = "what a logger wrote: text, MATLAB arrays, MCAP, MDF 4 or Parquet";
    if !is_standard_input(raw) {
        let bytes = read_bytes(raw, EXPECTED, LARGEST_DATA)?;
        return Ok((raw.display().to_string(), bytes));
    }
    let name = "standard input";
    let bytes = read_at_most(io::stdin().lock(), LARGEST_DATA)
        .map_err(|error| unreadable(name.as_ref(), &error, EXPECTED, LARGEST_DATA))?;
    Ok((name.to_owned(), bytes))
}

fn is_standard_input(raw: &Path) -> bool {
    raw == Path::new("-")
}

fn reading(args: &Args) -> Result<Reading, Failure> {
    let delimiter = args.delimiter.as_deref().map(|text| {
        let wrong = |reason| Failure::Usage(format!("--delimiter is {}: {reason}", quoted(text)));
        Delimiter::parse(text).map_err(wrong)
    });
    Ok(Reading {
        delimiter: delimiter.transpose()?,
        decimal_comma: args.decimal_comma,
        header: args.header,
        comment: args.comment.clone().filter(|comment| !comment.is_empty()),
    })
}

fn recipe(args: &Args) -> Result<Recipe, Failure> {
    let positive = |name: &str, value: Option<f64>| match value {
        Some(value) if !(value.is_finite() && value > 0.0) => Err(Failure::Usage(format!(
            "{name} is {value}; expected a number above 0"
        ))),
        _ => Ok(()),
    };
    positive("--rate", args.rate)?;
    positive("--unwrap", args.unwrap.flatten())?;
    let mut layout = Vec::new();
    let mut option = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            layout.extend([name.to_owned(), value]);
        }
    };
    option("--delimiter", args.delimiter.clone());
    option("--header", args.header.map(|line| line.to_string()));
    option("--comment", args.comment.clone());
    if args.decimal_comma {
        layout.push("--decimal-comma".into());
    }
    if let Some(machine) = &args.machine {
        layout.extend(["--machine".to_owned(), machine.display().to_string()]);
    }
    Ok(Recipe {
        sources: [
            args.time.clone(),
            Some(args.input.clone()),
            Some(args.position.clone()),
            args.command.clone(),
            args.current.clone(),
            args.velocity.clone(),
            args.brake.clone(),
            args.load_torque.clone(),
            args.enabled.clone(),
        ],
        unwrap: args.unwrap.map(|turn| turn.map_or(Turn::OfUnit, Turn::Of)),
        rate: args.rate,
        lines: args.lines,
        sort: args.sort,
        skip_bad: args.skip_bad,
        layout,
    })
}

/// The error of a fault, with the call that would mend it.
fn refusal(args: &Args, path: &Path, raw: &Raw, recipe: &Recipe, fault: Fault) -> Failure {
    if let Some(error) = unit_left_out(args, path, raw, recipe) {
        return error.into();
    }
    let mut mended = recipe.clone();
    let call = fault
        .mend
        .as_ref()
        .filter(|mend| **mend != Mend::Read && mended.mend(mend, raw))
        .and_then(|_| call::tried(&args.raw, raw, mended.clone()));
    let message = match call {
        Some(call) => format!("{}: {call}", fault.message),
        None => fault.message,
    };
    InputError::new(path, Some(fault.line), message).into()
}

/// What is wrong where a time without a unit makes no log, with the unit that the file says it would.
fn unit_left_out(args: &Args, path: &Path, raw: &Raw, recipe: &Recipe) -> Option<InputError> {
    let time = recipe.sources[TIME].as_deref()?;
    let source = Source::parse(time, raw, COLUMNS[TIME].0).ok()?;
    let unit = raw.own_unit(source.column, COLUMNS[TIME].0);
    let unit = unit.filter(|_| source.is_plain())?;
    let mut mended = recipe.clone();
    mended.sources[TIME] = Some(format!("{}:{unit}", raw.name(source.column)));
    let call = call::tried(&args.raw, raw, mended)?;
    let message = format!("--time has no unit, and the file says that it is in {unit}: {call}");
    Some(InputError::new(path, None, message))
}

/// Two lines, as in `2-5001`.
fn lines(text: &str) -> Result<(usize, usize), String> {
    let parts = text.split_once('-');
    let parsed = parts.and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match parsed {
        Some((first, last)) if first >= 1 && first <= last => Ok((first, last)),
        _ => Err("expected two lines, the first one first, as in 2-5001".into()),
    }
}
