//! What is expected of a run, rewritten: each change is shown before the file is.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::Path;

use crate::failure::Failure;
use crate::outputs::write_own;

/// Shows which lines of the file change, and writes it. A file that says the same already is left alone.
///
/// # Errors
/// The file cannot be read or written.
pub fn replace(file: &Path, text: &str) -> Result<(), Failure> {
    let before = match fs::read_to_string(file) {
        Ok(before) => before,
        Err(error) if error.kind() == ErrorKind::NotFound => String::new(),
        Err(error) => return Err(Failure::system(file.display(), &error)),
    };
    let changes = changes(&before, text);
    if changes.is_empty() {
        return Ok(());
    }
    // Whoever closed the stream does not want to know; the exit status tells the rest.
    let _ = write!(io::stdout(), "{}:\n{changes}", file.display());
    write_own(file, text)
}

/// The lines between those that are the same at both ends, as they were and as they become.
fn changes(before: &str, after: &str) -> String {
    let (before, after): (Vec<&str>, Vec<&str>) =
        (before.lines().collect(), after.lines().collect());
    let shorter = before.len().min(after.len());
    let same = |count: usize, pair: &mut dyn Iterator<Item = (&&str, &&str)>| {
        pair.take(count).take_while(|(a, b)| a == b).count()
    };
    let head = same(shorter, &mut before.iter().zip(&after));
    let tail = same(
        shorter - head,
        &mut before.iter().rev().zip(after.iter().rev()),
    );
    let marked = |sign: char, lines: &[&str]| {
        lines[head..lines.len() - tail]
            .iter()
            .map(|line| format!("{sign} {line}\n"))
            .collect::<String>()
    };
    marked('-', &before) + &marked('+', &after)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_is_shown_without_what_stays() {
        assert_eq!(changes("a\nb\nc\n", "a\nb\nc\n"), "");
        assert_eq!(changes("a\nb\nc\n", "a\nd\ne\nc\n"), "- b\n+ d\n+ e\n");
        assert_eq!(changes("a\na\n", "a\n"), "- a\n");
        assert_eq!(changes("", "a\n"), "+ a\n");
    }

    #[test]
    fn the_file_says_what_it_is_to_say() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("expected.log");
        for text in ["INFO a\n", "INFO a\nINFO b\n"] {
            replace(&file, text).unwrap();
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
        }
    }
}
