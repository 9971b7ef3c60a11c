//! The words of an image's log, as its reader knows them, and what the reader decodes with them.

use std::io::{self, BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;

use crate::board_log::{BoardLog, IMAGE, Line, frames};
use crate::error::{InputError, LARGEST_DATA, read_bytes};
use crate::failure::Failure;
use crate::progress::announce;
use crate::readers::{self, BOARD_LOG};

/// What is said before the reader is built.
pub const BUILDING: &str = "the reader of the board's log (built once, which takes a minute)";

/// The words of an image's log.
pub struct Dictionary {
    reader: PathBuf,
    image: PathBuf,
}

/// Builds the reader of boards' logs, or finds it built.
///
/// # Errors
/// A reader that cannot be built, with the command that does it.
pub fn build() -> Result<PathBuf, Failure> {
    readers::build(BOARD_LOG, "the board's log", "")
}

impl Dictionary {
    /// The words of the image in an ELF file.
    ///
    /// # Errors
    /// No such file, no ELF file, or one without a defmt log that can be read here; a reader that cannot be built.
    pub fn read(elf: &Path) -> Result<Self, Failure> {
        read_bytes(elf, IMAGE, LARGEST_DATA)?;
        if !readers::is_built(BOARD_LOG) {
            announce()(BUILDING);
        }
        let dictionary = Self {
            reader: build()?,
            image: elf.to_owned(),
        };
        // An image whose words cannot be read is refused, whatever the log.
        dictionary.decode(&[])?;
        Ok(dictionary)
    }

    /// Decodes a whole log. Frames end with a zero byte; what follows the last is cut off and
    /// counted as damaged.
    ///
    /// # Errors
    /// An image whose words cannot be read; a reader that does not run.
    pub fn decode(&self, log: &[u8]) -> Result<BoardLog, Failure> {
        let mut decoding = self.follow(Stdio::piped())?;
        let input = decoding.reader.stdin.take();
        let decoded = thread::scope(|scope| {
            scope.spawn(move || {
                // A reader that has refused the image does not take the log.
                let _ = input.map(|mut input| input.write_all(log));
            });
            BoardLog::of_frames(&mut decoding.said)
        });
        decoding.end()?;
        Ok(decoded)
    }

    /// Decodes a log as it comes.
    ///
    /// # Errors
    /// A reader that does not run.
    pub fn follow(&self, log: impl Into<Stdio>) -> Result<Decoding, Failure> {
        let system = |error: io::Error| Failure::system(self.reader.display(), error);
        let mut reader = Command::new(&self.reader)
            .arg(&self.image)
            .stdin(log)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(system)?;
        let said = reader.stdout.take();
        let said = said.ok_or_else(|| system(ErrorKind::BrokenPipe.into()))?;
        Ok(Decoding {
            reader,
            said: BufReader::new(said),
            image: self.image.clone(),
        })
    }
}

/// A log that is being decoded, up to where this is dropped.
pub struct Decoding {
    reader: Child,
    said: BufReader<ChildStdout>,
    image: PathBuf,
}

impl Decoding {
    /// The frames: a line, or none of a damaged one.
    pub fn frames(&mut self) -> impl Iterator<Item = Option<Line>> {
        frames(&mut self.said)
    }

    /// Waits until the reader has ended by itself, as it does behind the end of the log.
    ///
    /// # Errors
    /// An image whose words cannot be read.
    pub fn end(mut self) -> Result<(), Failure> {
        let mut said = Vec::new();
        let status = self
            .reader
            .stderr
            .take()
            .map_or(Ok(0), |mut complaints| complaints.read_to_end(&mut said));
        let status = status.and_then(|_| self.reader.wait());
        let status =
            status.map_err(|error| Failure::system("the reader of the board's log", error))?;
        match readers::complaint(status, &said) {
            None => Ok(()),
            Some(reason) => Err(InputError::new(&self.image, None, reason).into()),
        }
    }
}

impl Drop for Decoding {
    fn drop(&mut self) {
        let _ = self.reader.kill();
        let _ = self.reader.wait();
    }
}
