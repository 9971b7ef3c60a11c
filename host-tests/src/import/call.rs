//! The `cargo hil import` call that makes a log of a file. All such calls that are printed are made here.

use std::fmt;
use std::path::Path;

use super::convert::convert;
use super::groups::bring_together;
use super::guess;
use super::layout::Reading;
use super::raw::Raw;
use super::recipe::{FLAGS, Recipe};
use crate::error::InputError;
use crate::failure::Failure;
use crate::log::fault::Mend;

/// A call, to be copied into a shell.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Call {
    words: Vec<String>,
}

impl Call {
    /// The import of this file.
    pub fn new(raw: &Path) -> Self {
        let shown = raw.display().to_string();
        // What begins like an option is none in a directory.
        let is_option = shown.starts_with('-') && shown != "-";
        let shown = if is_option {
            format!("./{shown}")
        } else {
            shown
        };
        Self {
            words: ["cargo".into(), "hil".into(), "import".into(), shown].into(),
        }
    }

    /// Adds where a column of the log, by its place among them, comes from.
    pub fn source(&mut self, column: usize, source: &str) {
        self.option(FLAGS[column], source);
    }

    /// Adds an option and its value.
    pub fn option(&mut self, name: &str, value: &str) {
        self.words.extend([name.to_owned(), value.to_owned()]);
    }

    /// Adds a word.
    pub fn flag(&mut self, name: &str) {
        self.words.push(name.to_owned());
    }
}

/// Calls of which each makes a log of a part of a file, to be copied in one line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Calls(Vec<Call>);

impl fmt::Display for Calls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let calls: Vec<String> = self.0.iter().map(Call::to_string).collect();
        f.write_str(&calls.join(" && "))
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.words.iter().map(|word| quoted(word)).collect();
        f.write_str(&words.join(" "))
    }
}

/// A word as a shell takes it unchanged.
pub(crate) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./:=+,%@°".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else if word.contains(char::is_control) {
        // As bash and zsh read what a terminal must not be sent.
        let escaped: String = word.chars().map(escaped).collect();
        format!("$'{escaped}'")
    } else if word.contains(['"', '$', '`', '\\', '!']) {
        format!("'{}'", word.replace('\'', "'\\''"))
    } else {
        format!("\"{word}\"")
    }
}

/// A character within `$'…'`.
fn escaped(character: char) -> String {
    match character {
        '\'' | '\\' => format!("\\{character}"),
        character if character.is_control() => format!("\\u{:04x}", u32::from(character)),
        character => character.to_string(),
    }
}

/// A name for the corrected log beside the file, that no file has yet.
pub(crate) fn out_beside(path: &Path) -> String {
    names_beside(path, 1).concat()
}

/// So many names for logs beside the file, that no file has yet.
fn names_beside(path: &Path, count: usize) -> Vec<String> {
    let shown = path.display().to_string();
    let stem = if shown == "-" { "log" } else { stem_of(&shown) };
    let names = (1..100).map(|number| match (number, shown.as_str()) {
        (1, "-") => "log.csv".to_owned(),
        (1, _) => format!("{stem}-corrected.csv"),
        (number, "-") => format!("log-{number}.csv"),
        (number, _) => format!("{stem}-corrected-{number}.csv"),
    });
    let free = names.filter(|name| Path::new(name).symlink_metadata().is_err());
    let mut free: Vec<String> = free.take(count).collect();
    if free.is_empty() {
        free.push(format!("{stem}-corrected.csv"));
    }
    free
}

/// The name of a file without what it ends with.
fn stem_of(shown: &str) -> &str {
    let plain = shown.strip_suffix(".gz").unwrap_or(shown);
    let name_starts = plain.rfind(['/', '\\']).map_or(0, |at| at + 1);
    match plain[name_starts..].rfind('.') {
        Some(dot) if dot > 0 => &plain[..name_starts + dot],
        _ => plain,
    }
}

/// The error of a log, with the call that would mend it where there is one: an import of the file at
/// `path`, which holds `bytes`. A call is printed only if it has been followed and made a log.
pub(crate) fn mended(
    error: InputError,
    path: &Path,
    bytes: &[u8],
    mend: Option<Mend>,
) -> InputError {
    let found = mend.and_then(|mend| {
        let mut raw = Raw::read(path, bytes, &Reading::default()).ok()?;
        mending(path, &mut raw, &mend)
    });
    match found {
        Some(mending) => InputError::new(&error.file, error.line, mending.behind(&error.message)),
        None => error,
    }
}

/// What is said of a log that is no text but a file of a format that is known: the import that reads it, or what else to do
/// with it. `None` of any other file. `expected`: what the log should have been.
pub(crate) fn of_format(path: &Path, bytes: &[u8], expected: &str) -> Option<InputError> {
    let format = Raw::format_of(bytes)?;
    let message = format!("is {format}, not {expected}; import it");
    let message = match Raw::read(path, bytes, &Reading::default()) {
        Ok(mut raw) => match mending(path, &mut raw, &Mend::Read) {
            Some(mending) => mending.behind(&message),
            // Which of its columns is which nobody knows but the user.
            None => format!(
                "{message}, saying which of its columns are which: {}",
                raw.listed()
            ),
        },
        Err(Failure::Input(error)) => return Some(error),
        Err(failure) => format!("{message}: {failure}"),
    };
    Some(InputError::new(path, None, message))
}

/// A call that makes a log of a file, tried out.
struct Mending {
    call: Calls,
    /// What to put into it that the file does not say: a rate, the size of a share or of a count.
    sizes: Vec<String>,
}

impl Mending {
    /// What is wrong, and then the call.
    fn behind(&self, message: &str) -> String {
        let sizes = self.sizes.iter().map(|put| format!("; in the call, {put}"));
        let sizes: String = sizes.collect();
        format!("{message}{sizes}: {}", self.call)
    }
}

/// The call that mends what the file holds, whose groups of rows are brought together for it.
fn mending(path: &Path, raw: &mut Raw, mend: &Mend) -> Option<Mending> {
    let mut recipe = guess::recipe(raw)?;
    bring_together(raw, &recipe).ok()?;
    let sizes = recipe.sizes_to_fill_in(raw);
    // What a reading of the numbers finds too is mended by following the recipe; a column of a slow sensor is no fault there.
    let is_found = matches!(mend, Mend::SkipBad | Mend::Parts(_));
    (is_found || recipe.mend(mend, raw)).then_some(())?;
    Some(Mending {
        call: tried(path, raw, recipe)?,
        sizes,
    })
}

/// The call of a recipe, mended until it makes a log; of a log that is to be cut, those of its parts.
pub(super) fn tried(path: &Path, raw: &Raw, recipe: Recipe) -> Option<Calls> {
    tried_beside(path, path, raw, recipe)
}

/// The same, with logs beside another file than the one that is imported.
pub(super) fn tried_beside(beside: &Path, path: &Path, raw: &Raw, recipe: Recipe) -> Option<Calls> {
    let recipes = followed(path, raw, recipe)?;
    let names = names_beside(beside, recipes.len());
    let calls = recipes.iter().zip(&names);
    Some(Calls(
        calls.map(|(recipe, out)| recipe.call(path, out)).collect(),
    ))
}

/// A recipe mended until it makes a log, or those of the parts that do; a part is not cut again.
fn followed(path: &Path, raw: &Raw, recipe: Recipe) -> Option<Vec<Recipe>> {
    match mended_until_cut(path, raw, recipe)? {
        (recipe, None) => Some(vec![recipe]),
        (recipe, Some(parts)) => {
            let parts = parts.into_iter().map(|part| Recipe {
                lines: Some(part),
                ..recipe.clone()
            });
            let made = parts.filter_map(|part| match mended_until_cut(path, raw, part)? {
                (part, None) => Some(part),
                (_, Some(_)) => None,
            });
            let made: Vec<Recipe> = made.collect();
            (!made.is_empty()).then_some(made)
        }
    }
}

/// The lines of the parts that a log is to be cut into.
type Parts = Vec<(usize, usize)>;

/// A recipe mended until it makes a log, or until this is to be cut.
fn mended_until_cut(path: &Path, raw: &Raw, mut recipe: Recipe) -> Option<(Recipe, Option<Parts>)> {
    const MOST: usize = 6;
    for _ in 0..MOST {
        let sources = recipe.parsed(raw).ok()?;
        match convert(path, raw, &recipe, &sources) {
            // What leaves out most of a file has not understood it.
            Ok(made) if 2 * made.left_out > made.rows => return None,
            Ok(_) => return Some((recipe, None)),
            Err(fault) => {
                let mend = fault.mend?;
                if let Mend::Parts(parts) = mend {
                    return Some((recipe, Some(parts)));
                }
                if mend == Mend::Read || !recipe.mend(&mend, raw) {
                    return None;
                }
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_survive_a_shell() {
        let mut call = Call::new("my log.csv".as_ref());
        call.option("--input", "duty:%*12");
        call.option("--time", "t:ms");
        call.option("--position", "a$b");
        assert_eq!(
            call.to_string(),
            "cargo hil import \"my log.csv\" --input \"duty:%*12\" --time t:ms --position 'a$b'"
        );
        assert_eq!(quoted("a\u{1b}[31m'x"), "$'a\\u001b[31m\\'x'");
        assert_eq!(
            Call::new("-x".as_ref()).to_string(),
            "cargo hil import ./-x"
        );
    }

    #[test]
    fn the_output_stands_beside_the_input() {
        for (raw, out) in [
            ("a.csv", "a-corrected.csv"),
            ("no/where.d/a.b.csv.gz", "no/where.d/a.b-corrected.csv"),
            ("no/where.d/a", "no/where.d/a-corrected.csv"),
            ("no/.hidden", "no/.hidden-corrected.csv"),
            ("-", "log.csv"),
        ] {
            assert_eq!(out_beside(raw.as_ref()), out);
        }
    }
}
