//! Golden figures: what a program counts, kept in a file next to it.
//!
//! Instruction counts are exact, but they are the compiler's: a figure is compared only with one that the
//! same compiler left. The file is TOML with one table a compiler.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use crate::blessing::replace;
use crate::error::{InputError, LARGEST_DECLARATION, line_of, read_text};
use crate::failure::Failure;

/// Figures by name.
pub type Figures = BTreeMap<String, u64>;

/// The figures of every compiler that left some.
type Golden = BTreeMap<String, Figures>;

/// The first line of every file.
const HEADER: &str = "# By compiler. Rewritten by `cargo hil test --bless`.\n\n";

/// What came of a comparison that found no fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comparison {
    /// This compiler left the same figures.
    Same,
    /// This compiler has left none.
    UnknownCompiler,
    /// The figures are from now on what is expected.
    Blessed,
}

/// Compares `measured` with what `compiler` left in `file`; with `bless` leaves it there.
///
/// Blessing changed figures drops those of the other compilers, which are of an earlier program.
///
/// # Errors
/// Other figures, as lines of a difference and with the remedy. No such file, or no file of
/// figures.
pub fn compare(
    file: &Path,
    compiler: &str,
    measured: &Figures,
    bless: bool,
) -> Result<Comparison, Failure> {
    if bless {
        let golden = if file.exists() {
            read(file)?
        } else {
            Golden::new()
        };
        write(file, &blessed(golden, compiler, measured))
            .map_err(|error| Failure::system(file.display(), &error))?;
        return Ok(Comparison::Blessed);
    }
    match read(file)?.get(compiler) {
        None => Ok(Comparison::UnknownCompiler),
        Some(expected) if expected == measured => Ok(Comparison::Same),
        Some(expected) => Err(Failure::Other(format!(
            "{}: other figures with {compiler}; if they are right: cargo hil test --bless\n{}",
            file.display(),
            difference(expected, measured)
        ))),
    }
}

fn blessed(mut golden: Golden, compiler: &str, measured: &Figures) -> Golden {
    if golden
        .get(compiler)
        .is_some_and(|expected| expected != measured)
    {
        golden.clear();
    }
    golden.insert(compiler.to_owned(), measured.clone());
    golden
}

fn read(file: &Path) -> Result<Golden, InputError> {
    let text = read_text(
        file,
        "figures (cargo hil test --bless writes them)",
        LARGEST_DECLARATION,
    )?;
    toml::from_str(&text).map_err(|error| {
        let line = error
            .span()
            .map(|span| line_of(text.as_bytes(), span.start));
        let message = format!(
            "{}; expected a table of numbers a compiler",
            error.message()
        );
        InputError::new(file, line, message)
    })
}

fn write(file: &Path, golden: &Golden) -> Result<(), Failure> {
    let tables = toml::to_string(golden).map_err(|error| Failure::other(error.to_string()))?;
    replace(file, &(HEADER.to_owned() + &tables))
}

/// One line a figure, those that differ before and after.
fn difference(expected: &Figures, measured: &Figures) -> String {
    let names: BTreeSet<&String> = expected.keys().chain(measured.keys()).collect();
    let mut lines = String::new();
    for name in names {
        let mut line = |sign: char, value: Option<&u64>| {
            if let Some(value) = value {
                // A string takes everything.
                let _ = writeln!(lines, "{sign} {name} = {value}");
            }
        };
        let (before, after) = (expected.get(name), measured.get(name));
        if before == after {
            line(' ', before);
        } else {
            line('-', before);
            line('+', after);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn figures(pairs: &[(&str, u64)]) -> Figures {
        pairs
            .iter()
            .map(|&(name, value)| (name.to_owned(), value))
            .collect()
    }

    #[test]
    fn what_was_blessed_is_what_is_expected_of_that_compiler_alone() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("image.toml");
        let measured = figures(&[("flash", 41_000), ("ram", 2100)]);
        let compare = |compiler, measured, bless| compare(&file, compiler, measured, bless);
        assert_eq!(
            compare("rustc 1.95.0", &measured, true).unwrap(),
            Comparison::Blessed
        );
        assert_eq!(
            compare("rustc 1.95.0", &measured, false).unwrap(),
            Comparison::Same
        );
        let other = figures(&[("flash", 41_004), ("ram", 2100)]);
        assert_eq!(
            compare("rustc 1.96.0", &other, false).unwrap(),
            Comparison::UnknownCompiler
        );
        let failure = compare("rustc 1.95.0", &other, false).unwrap_err();
        assert_eq!(
            failure.to_string(),
            format!(
                "{}: other figures with rustc 1.95.0; if they are right: cargo hil test --bless\n\
                 - flash = 41000\n+ flash = 41004\n  ram = 2100\n",
                file.display()
            )
        );
    }

    #[test]
    fn figures_that_come_and_go_differ_too() {
        assert_eq!(
            difference(
                &figures(&[("a", 1), ("b", 2)]),
                &figures(&[("b", 2), ("c", 3)])
            ),
            "- a = 1\n  b = 2\n+ c = 3\n"
        );
    }

    #[test]
    fn changed_figures_take_those_of_other_compilers_with_them() {
        let (old, new) = (figures(&[("flash", 1)]), figures(&[("flash", 2)]));
        let one = blessed(Golden::new(), "a", &old);
        let two = blessed(one, "b", &old);
        assert_eq!(two.len(), 2, "a second compiler stands beside the first");
        assert_eq!(blessed(two.clone(), "a", &old), two);
        assert_eq!(
            blessed(two, "a", &new),
            Golden::from([("a".to_owned(), new)])
        );
    }

    #[test]
    fn a_file_that_is_none_is_named_with_its_line() {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("image.toml");
        let failure = compare(&file, "a", &Figures::new(), false).unwrap_err();
        assert!(failure.to_string().contains("no such file"), "{failure}");
        fs::write(&file, "[a]\nflash = \"many\"\n").unwrap();
        let failure = compare(&file, "a", &Figures::new(), false).unwrap_err();
        assert!(
            failure
                .to_string()
                .starts_with(&format!("{}:2: ", file.display())),
            "{failure}"
        );
    }
}
