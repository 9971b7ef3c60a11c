//! Where an output goes, and which file a path leads to.

use std::fs::{self, OpenOptions};
use std::io::{self, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, MetadataExt};
use std::path::{Component, Path, PathBuf};

use super::part::probe;

/// Most symbolic links that are followed, as on Linux.
const MOST_LINKS: usize = 40;

/// Where an output goes once every symbolic link is followed.
#[derive(Debug)]
pub(super) enum Target {
    /// A file, new or not, by its absolute path.
    File(PathBuf),
    /// A device, a pipe or an open descriptor.
    Stream(PathBuf),
}

/// Which file a path leads to.
#[derive(Debug)]
pub(super) struct Identity {
    /// Absolute, without links; none for what cannot be replaced.
    pub(super) path: Option<PathBuf>,
    /// Device and inode, of what is there.
    pub(super) inode: Option<(u64, u64)>,
}

impl Identity {
    pub(super) fn of(path: &Path) -> Self {
        let there = fs::metadata(path).ok();
        // Nothing in a terminal or in /dev/null can be replaced: these may have several uses.
        if (there.as_ref()).is_some_and(|there| there.file_type().is_char_device()) {
            return Self {
                path: None,
                inode: None,
            };
        }
        Self {
            path: located(path).ok(),
            inode: there.map(|there| (there.dev(), there.ino())),
        }
    }

    /// Whether one is the other, or inside it.
    pub(super) fn meets(&self, other: &Self) -> bool {
        let inside = |a: &Option<PathBuf>, b: &Option<PathBuf>| match (a, b) {
            (Some(a), Some(b)) => a.starts_with(b),
            _ => false,
        };
        (self.inode.is_some() && self.inode == other.inode)
            || inside(&self.path, &other.path)
            || inside(&other.path, &self.path)
    }
}

impl Target {
    /// Follows a path that the user named to where it leads, or says why no file can be there.
    pub(super) fn of(path: &Path) -> Result<Self, String> {
        if path.as_os_str().as_bytes().ends_with(b"/") {
            return Err("is the name of a directory; expected the name of a file".to_owned());
        }
        let mut path = path.to_owned();
        for _ in 0..MOST_LINKS {
            let Some(name) = path.file_name() else {
                return Err("is a directory; expected the name of a file".to_owned());
            };
            let parent = parent(&path);
            let directory = fs::canonicalize(parent)
                .ok()
                .filter(|directory| directory.is_dir())
                .ok_or_else(|| {
                    let parent = parent.display();
                    format!("there is no directory {parent}; create it, or name another file")
                })?;
            let place = directory.join(name);
            if is_descriptors(&directory) {
                return match fs::metadata(&place) {
                    Ok(_) => Ok(Self::Stream(place)),
                    Err(_) => Err("is not open; name a file, or /dev/stdout".to_owned()),
                };
            }
            let there = match fs::symlink_metadata(&place) {
                Ok(there) => there,
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    return Ok(Self::File(place));
                }
                Err(error) => return Err(cannot_write(&error)),
            };
            let what = there.file_type();
            if what.is_symlink() {
                let to = fs::read_link(&place).map_err(|error| cannot_write(&error))?;
                path = directory.join(to);
            } else if what.is_char_device() || what.is_fifo() {
                return Ok(Self::Stream(place));
            } else if what.is_dir() {
                return Err("is a directory; expected the name of a file".to_owned());
            } else if !what.is_file() {
                return Err("is a disk or a socket; expected the name of a file".to_owned());
            } else if there.permissions().readonly() {
                return Err("is read-only; make it writable, or name another file".to_owned());
            } else {
                return Ok(Self::File(place));
            }
        }
        Err("is a symbolic link that leads to itself; name a file".to_owned())
    }

    pub(super) fn identity(&self) -> Identity {
        match self {
            Self::File(path) => Identity::of(path),
            Self::Stream(path) => Identity {
                // Its name is a place in a list of descriptors, not in a directory.
                path: None,
                ..Identity::of(path)
            },
        }
    }
}

/// The directory of a path.
pub(super) fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// An absolute path without links, for what may not be there yet.
pub(super) fn located(path: &Path) -> io::Result<PathBuf> {
    match fs::canonicalize(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let mut place = match path.components().next_back() {
                Some(Component::Normal(_) | Component::ParentDir) => located(parent(path))?,
                _ => return Err(error),
            };
            match path.file_name() {
                Some(name) => place.push(name),
                None => {
                    place.pop();
                }
            }
            Ok(place)
        }
        found => found,
    }
}

/// The absolute path of a directory that is there or can be made, or why it cannot.
pub(super) fn directory_at(directory: &Path) -> Result<PathBuf, String> {
    let place = located(directory).map_err(|error| cannot_write(&error))?;
    let there = |path: &&Path| fs::symlink_metadata(path).is_ok();
    let nearest = place.ancestors().find(there).unwrap_or(&place);
    if nearest.is_dir() {
        return match probe(&nearest.join("probe")) {
            Ok(()) => Ok(place),
            Err(error) => Err(cannot_write(&error)),
        };
    }
    if nearest == place {
        Err("is a file; expected the name of a directory, new or not".to_owned())
    } else {
        let nearest = nearest.display();
        Err(format!(
            "{nearest} is no directory; expected the name of a directory, new or not"
        ))
    }
}

/// Whether these are the open descriptors of this program.
fn is_descriptors(directory: &Path) -> bool {
    fs::canonicalize("/proc/self/fd").is_ok_and(|descriptors| descriptors == directory)
}

/// Sends bytes to a device, a pipe or a descriptor.
pub(super) fn send(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let descriptor = path
        .parent()
        .is_some_and(is_descriptors)
        .then(|| path.file_name()?.to_str())
        .flatten();
    match descriptor {
        // Opened anew, a file would be written from its start, and what is printed would follow there.
        Some("1") => {
            let mut out = io::stdout().lock();
            out.write_all(bytes)?;
            out.flush()
        }
        Some("2") => io::stderr().write_all(bytes),
        _ => {
            let mut options = OpenOptions::new();
            options.append(true).open(path)?.write_all(bytes)
        }
    }
}

/// Why nothing can be written at a place, and the remedy.
pub(super) fn cannot_write(error: &io::Error) -> String {
    format!("cannot be written ({error}); name another place")
}
