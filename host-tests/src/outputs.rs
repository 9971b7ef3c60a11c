//! What a command reads and what it writes, known before it runs.
//!
//! A command names its inputs and each place that it may write to [`Outputs`] before any work. What
//! cannot be written, what would replace an input, and two outputs at one place are refused then.
//! Links count: a symbolic link is followed, hard links are told by their inode.
//!
//! A result is *staged*: written to a temporary file beside its place, and flushed to the disk.
//! [`Outputs::commit`] renames all of them at the end. So every output of a command is there whole, or
//! none is: an error, SIGINT and SIGTERM remove what was staged. Devices, pipes and descriptors
//! (`/dev/stdout`) are written to, and never replaced.
//!
//! A file that is there already is replaced only if this program wrote it; see [`Kind`].

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::InputError;
use crate::failure::Failure;

use self::part::{Unfinished, probe, rename, unfinished, write_part};
use self::place::{Identity, Target, cannot_write, directory_at, located, send};

mod part;
mod place;

pub use part::defer_signals;

/// What the help of every command with outputs says about them.
pub const HELP: &str = "\
Files: what is read is never written, and no two outputs may be one file. Outputs are written whole or
not at all. A file that is there already is replaced only if it is empty or this program wrote it, and
by `import` and `record` never:
  JSON, TOML, pages  \"Written by cargo hil\" stands in the beginning; delete that line to keep what you edited
  input CSV          has the columns time_s,input and no other
  log CSV            is never replaced
Other files in a report's directory are left alone. Devices, pipes and /dev/stdout are written to.";

/// Stands in the beginning of a page, a drawing, a machine file or a result in JSON that this program wrote.
pub const MARK: &str = "Written by cargo hil";

/// The first line of an experiment's input. A measured log has more columns.
pub const INPUT_HEADER: &str = "time_s,input";

/// As much of a file is looked at for what it is, bytes.
const BEGINNING: usize = 1000;

/// Writes text to the standard output, at once.
///
/// # Errors
/// It takes no more.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut output = io::stdout();
    output
        .write_all(text.as_bytes())
        .and_then(|()| output.flush())
        .map_err(|error| Failure::system("standard output", &error))
}

/// What an output holds, which decides what file of the same name it may replace. An empty file is
/// always replaced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Text with [`MARK`] in its beginning: replaces such text.
    Marked,
    /// An experiment's input, CSV: replaces a file with the columns of [`INPUT_HEADER`] alone.
    Input,
    /// A log, CSV, which nothing tells from one that a user measured: replaces none.
    Log,
}

impl Kind {
    /// Whether this program wrote a file with these bytes, of which more than [`BEGINNING`] need not be given.
    fn wrote(self, bytes: &[u8]) -> bool {
        let beginning = &bytes[..bytes.len().min(BEGINNING)];
        if beginning.len() < BEGINNING && beginning.trim_ascii().is_empty() {
            return true;
        }
        match self {
            Self::Marked => String::from_utf8_lossy(beginning).contains(MARK),
            Self::Input => {
                let line = beginning.split(|byte| *byte == b'\n').next();
                line.is_some_and(|line| line.trim_ascii() == INPUT_HEADER.as_bytes())
            }
            Self::Log => false,
        }
    }
}

/// Indented JSON with the key `about`, which says [`MARK`], in its object or in the first one of its list.
fn marked(json: &str) -> String {
    let Some((before, entries)) = json.split_once('{') else {
        return format!("{json}\n");
    };
    if entries.starts_with('}') {
        return format!("{json}\n");
    }
    let indent: String = entries
        .chars()
        .take_while(|it| it.is_whitespace())
        .collect();
    format!("{before}{{{indent}\"about\": \"{MARK}\",{entries}\n")
}

/// One place of a command's [`Outputs`].
#[derive(Debug, Clone, Copy)]
pub struct Output(usize);

/// The inputs and outputs of one run of a command.
#[derive(Debug)]
pub struct Outputs {
    /// The file that standard output was redirected to: device and inode.
    printed: Option<(u64, u64)>,
    /// Whether that is one of the inputs.
    is_read_and_printed: bool,
    taken: Vec<Taken>,
    /// Whether a result of this program is replaced; else nothing is.
    replaces: bool,
    places: Vec<Place>,
    changes: Vec<Change>,
    /// Temporary files and new directories, in the order in which they were made.
    unfinished: Vec<Unfinished>,
}

/// A file or directory that no output may touch.
#[derive(Debug)]
struct Taken {
    identity: Identity,
    /// What it is, and what the remedy is.
    because: &'static str,
}

#[derive(Debug)]
struct Place {
    /// As the user named it.
    shown: PathBuf,
    target: Target,
    kind: Kind,
}

/// What is done at the end.
#[derive(Debug)]
enum Change {
    Rename { part: PathBuf, to: PathBuf },
    Send { to: usize, bytes: Vec<u8> },
    Remove(PathBuf),
}

impl Outputs {
    /// The outputs of a command that reads these files.
    pub fn reading<'a>(inputs: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        let printed = fs::metadata("/dev/stdout").ok();
        let printed = printed.filter(fs::Metadata::is_file);
        let taken = |input: &PathBuf| Taken {
            identity: Identity::of(input),
            because: "is read by this command, and would be replaced; name another place for the \
                      output",
        };
        let printed = printed.map(|file| (file.dev(), file.ino()));
        let taken: Vec<Taken> = inputs.into_iter().map(taken).collect();
        let is_printed = |taken: &Taken| printed.is_some() && taken.identity.inode == printed;
        Self {
            printed,
            is_read_and_printed: taken.iter().any(is_printed),
            taken,
            replaces: true,
            places: Vec::new(),
            changes: Vec::new(),
            unfinished: Vec::new(),
        }
    }

    /// Outputs that replace no file at all, whoever wrote it.
    #[must_use]
    pub fn replacing_nothing(mut self) -> Self {
        self.replaces = false;
        self
    }

    /// Keeps other outputs out of a directory of the program's own that the command fills itself.
    pub fn fills(&mut self, directory: &Path) {
        self.taken.push(Taken {
            identity: Identity {
                path: located(directory).ok(),
                inode: None,
            },
            because: "is in a directory that this command fills itself, and would be replaced; name \
                      another place",
        });
    }

    /// Refuses standard output that goes into an input, whatever else is asked for.
    fn check_printed(&self) -> Result<(), Failure> {
        if self.is_read_and_printed {
            return Err(Failure::other(
                "standard output goes to a file that this command reads; name another file",
            ));
        }
        Ok(())
    }

    /// An output that the user named; none where none was asked for.
    ///
    /// # Errors
    /// A place at which no file can be written; an input, another output, or a file that this program
    /// did not write; standard output that goes into an input.
    pub fn file(&mut self, path: Option<&Path>, kind: Kind) -> Result<Option<Output>, Failure> {
        self.check_printed()?;
        let Some(path) = path else { return Ok(None) };
        self.declare(path, kind).map(Some)
    }

    /// Outputs of these names in a directory that the user named, which is made at the end where it is
    /// missing; none where none was asked for.
    ///
    /// # Errors
    /// A directory that is none or cannot be made, and what [`Outputs::file`] refuses.
    pub fn directory<const N: usize>(
        &mut self,
        directory: Option<&Path>,
        files: [(&str, Kind); N],
    ) -> Result<Option<[Output; N]>, Failure> {
        self.check_printed()?;
        let Some(directory) = directory else {
            return Ok(None);
        };
        let place = directory_at(directory).map_err(|reason| unwritable(directory, &reason))?;
        let mut outputs = [Output(0); N];
        for (output, (name, kind)) in outputs.iter_mut().zip(files) {
            let shown = directory.join(name);
            *output = if place.is_dir() {
                self.declare(&shown, kind)?
            } else {
                self.keep(shown, Target::File(place.join(name)), kind)?
            };
        }
        Ok(Some(outputs))
    }

    fn declare(&mut self, path: &Path, kind: Kind) -> Result<Output, Failure> {
        let refuse = |reason: String| unwritable(path, &reason);
        let target = Target::of(path).map_err(refuse)?;
        if let Target::File(file) = &target {
            probe(file).map_err(|error| refuse(cannot_write(&error)))?;
        }
        self.keep(path.to_owned(), target, kind)
    }

    fn keep(&mut self, shown: PathBuf, target: Target, kind: Kind) -> Result<Output, Failure> {
        let refuse = |message: &str| Err(InputError::new(&shown, None, message).into());
        let identity = target.identity();
        let touched = |taken: &&Taken| taken.identity.meets(&identity);
        if let Some(taken) = self.taken.iter().find(touched) {
            return refuse(taken.because);
        }
        if !self.replaces && matches!(target, Target::File(_)) && is_there(&shown) {
            return refuse(
                "is there already and is not replaced; name a new file, or remove it first",
            );
        }
        if let Target::File(path) = &target
            && path.exists()
        {
            if identity.inode.is_some() && identity.inode == self.printed {
                return refuse(
                    "takes standard output, and would be replaced; name another file, or /dev/stdout",
                );
            }
            let beginning = read_beginning(path)
                .map_err(|error| unwritable(&shown, &format!("cannot be read ({error})")))?;
            if !kind.wrote(&beginning) {
                return refuse(
                    "is there already and is no result of this program, so it is not replaced; name \
                     another place, or move it away",
                );
            }
        }
        self.taken.push(Taken {
            identity,
            because: "is another output of this command, and would be replaced; name a place for each",
        });
        self.places.push(Place {
            shown,
            target,
            kind,
        });
        Ok(Output(self.places.len() - 1))
    }

    /// Prepares an output. Nothing is at its place before [`Outputs::commit`].
    ///
    /// # Errors
    /// What the file system reports.
    pub fn stage(&mut self, output: Output, bytes: impl Into<Vec<u8>>) -> Result<(), Failure> {
        let (bytes, place) = (bytes.into(), &self.places[output.0]);
        // A log is never replaced, so that none has to be known again.
        let is_known = matches!(place.kind, Kind::Log) || place.kind.wrote(&bytes);
        debug_assert!(is_known, "the next run would not know it");
        let Target::File(path) = &place.target else {
            let to = output.0;
            self.changes.push(Change::Send { to, bytes });
            return Ok(());
        };
        let path = path.clone();
        match write_part(&path, &bytes, &mut self.unfinished) {
            Ok(part) => {
                self.changes.push(Change::Rename { part, to: path });
                Ok(())
            }
            Err(error) => Err(unwritable(&place.shown, &cannot_write(&error))),
        }
    }

    /// Prepares an output as indented JSON with [`MARK`] in its beginning and a newline at its end, if it was asked for.
    ///
    /// # Errors
    /// As [`Outputs::stage`].
    pub fn stage_json(
        &mut self,
        output: Option<Output>,
        value: &impl Serialize,
    ) -> Result<(), Failure> {
        let Some(output) = output else { return Ok(()) };
        let failed = |error: serde_json::Error| Failure::other(error.to_string());
        let text = serde_json::to_string_pretty(value).map_err(failed)?;
        self.stage(output, marked(&text))
    }

    /// Removes an earlier run's file at the end: this run has none. [`Kind`] says whose file it is.
    pub fn stage_removal(&mut self, output: Output) {
        if let Target::File(path) = &self.places[output.0].target {
            self.changes.push(Change::Remove(path.clone()));
        }
    }

    /// Whether nothing is at an output's place, or a file of this program that may be replaced.
    fn may_replace(&self, to: &Path) -> bool {
        let kind = self.places.iter().find_map(|place| match &place.target {
            Target::File(path) if path == to => Some(place.kind),
            _ => None,
        });
        !is_there(to)
            || self.replaces
                && read_beginning(to)
                    .is_ok_and(|beginning| kind.is_some_and(|kind| kind.wrote(&beginning)))
    }

    /// Puts every staged output in its place.
    ///
    /// # Errors
    /// What the file system reports. A pipe may have got its part then; files are as before, unless the disk
    /// failed between two renames.
    pub fn commit(mut self) -> Result<(), Failure> {
        let changes = std::mem::take(&mut self.changes);
        // Streams first: these fail, or wait for a reader, while nothing is in place yet.
        for change in &changes {
            if let Change::Send { to, bytes } = change {
                let place = &self.places[*to];
                if let Target::Stream(path) = &place.target {
                    send(path, bytes)
                        .map_err(|error| unwritable(&place.shown, &cannot_write(&error)))?;
                }
            }
        }
        for change in &changes {
            if let Change::Rename { to, .. } | Change::Remove(to) = change
                && !self.may_replace(to)
            {
                return Err(unwritable(
                    to,
                    "has come up meanwhile and is not replaced; name a new file, or remove it first",
                ));
            }
        }
        // A signal waits until all are in place.
        let _all = unfinished();
        for change in &changes {
            match change {
                Change::Rename { part, to } => {
                    rename(part, to).map_err(|error| unwritable(to, &cannot_write(&error)))?;
                }
                Change::Remove(path) if path.exists() => fs::remove_file(path)
                    .map_err(|error| unwritable(path, &format!("cannot be removed ({error})")))?,
                Change::Remove(_) | Change::Send { .. } => (),
            }
        }
        Ok(())
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        // The last first: a directory has to be empty.
        while self.unfinished.pop().is_some() {}
    }
}

/// Writes a file of the program's own, in `target/hil` or beside its sources, whole or not at all. Its
/// directory is made where it is missing.
///
/// # Errors
/// What the file system reports.
pub fn write_own(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
    let mut left = Vec::new();
    let written = write_part(path, bytes.as_ref(), &mut left).and_then(|part| rename(&part, path));
    while left.pop().is_some() {}
    written.map_err(|error| Failure::system(path.display(), error))
}

/// Whether there is anything of this name, a link that leads nowhere too.
fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

fn unwritable(path: &Path, reason: &str) -> Failure {
    Failure::system(path.display(), reason)
}

/// As much of a file as [`Kind::wrote`] looks at.
fn read_beginning(path: &Path) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    File::open(path)?
        .take(BEGINNING as u64)
        .read_to_end(&mut bytes)?;
    Ok(bytes)
}
