//! Temporary files, which an error or a signal removes.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, Once, PoisonError};
use std::thread;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;
use signal_hook::{flag, low_level};

use super::place::parent;

/// What is removed unless it was renamed before: temporary files, and new directories that are empty.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Held while something has to be brought to its end before a signal may end the program.
static DEFERRED: Mutex<()> = Mutex::new(());

/// Until it is dropped, SIGHUP, SIGINT and SIGTERM do not end the program. Who holds it is told of them by a flag of
/// his own, and must come to an end soon.
pub fn defer_signals() -> MutexGuard<'static, ()> {
    remove_on_signals();
    DEFERRED.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary file or a new directory. Dropped, it goes; a directory only if it is empty.
#[derive(Debug)]
pub(super) struct Unfinished(PathBuf);

impl Unfinished {
    /// Before the file is made: a signal may come right after.
    fn new(path: PathBuf) -> Self {
        remove_on_signals();
        unfinished().push(path.clone());
        Self(path)
    }

    /// Leaves it where it is.
    fn keep(self) {
        unfinished().retain(|path| *path != self.0);
        std::mem::forget(self);
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        remove(&self.0);
        unfinished().retain(|path| *path != self.0);
    }
}

fn remove(path: &Path) {
    // It may have been renamed, or never made; a directory that is used stays.
    let _ = fs::remove_file(path).or_else(|_| fs::remove_dir(path));
}

/// Removes what is unfinished when the user, or the system, ends the program.
fn remove_on_signals() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // A limit on the size of files becomes an error of writing, and is no reason to end at once.
        let _ = flag::register(SIGXFSZ, Arc::default());
        let Ok(mut signals) = Signals::new([SIGHUP, SIGINT, SIGTERM]) else {
            return;
        };
        thread::spawn(move || {
            for signal in signals.forever() {
                let _undeferred = DEFERRED.lock();
                let unfinished = unfinished();
                unfinished.iter().rev().for_each(|path| remove(path));
                let _ = low_level::emulate_default_handler(signal);
            }
        });
    });
}

/// A new file beside `path`: a rename does not cross file systems.
fn new_part(path: &Path, left: &mut Vec<Unfinished>) -> io::Result<(File, PathBuf)> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    loop {
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let name = format!(".cargo-hil-{}-{count}.part", std::process::id());
        let part = parent(path).join(name);
        let new = Unfinished::new(part.clone());
        match OpenOptions::new().write(true).create_new(true).open(&part) {
            // Another machine's, perhaps, that shares the disk.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => new.keep(),
            Err(error) => return Err(error),
            Ok(file) => {
                left.push(new);
                return Ok((file, part));
            }
        }
    }
}

/// Whether a file can be made beside `path`.
pub(super) fn probe(path: &Path) -> io::Result<()> {
    new_part(path, &mut Vec::new()).map(drop)
}

/// Writes bytes to a temporary file beside `path`, down to the disk, and returns its name.
pub(super) fn write_part(
    path: &Path,
    bytes: &[u8],
    left: &mut Vec<Unfinished>,
) -> io::Result<PathBuf> {
    make_directories(parent(path), left)?;
    let (mut file, part) = new_part(path, left)?;
    file.write_all(bytes)?;
    if let Ok(there) = fs::metadata(path) {
        // A user may have opened the old one to others, or closed it.
        file.set_permissions(there.permissions())?;
    }
    file.sync_all()?;
    Ok(part)
}

/// Makes a directory and those above it, and remembers which are new.
fn make_directories(directory: &Path, left: &mut Vec<Unfinished>) -> io::Result<()> {
    if directory.is_dir() {
        return Ok(());
    }
    make_directories(parent(directory), left)?;
    let new = Unfinished::new(directory.to_owned());
    match fs::create_dir(directory) {
        // Another thread was first.
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists && directory.is_dir() => {
            new.keep()
        }
        Err(error) => return Err(error),
        Ok(()) => left.push(new),
    }
    Ok(())
}

/// Renames, down to the disk.
pub(super) fn rename(part: &Path, to: &Path) -> io::Result<()> {
    fs::rename(part, to)?;
    // A file system that cannot flush a directory has renamed nevertheless.
    let _ = File::open(parent(to)).and_then(|directory| directory.sync_all());
    Ok(())
}
