//! The texts for people, and the commands that stand in them: the tests run these.

use std::fs;
use std::path::PathBuf;

use crate::failure::Failure;
use crate::workspace;

/// A command in a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Documented {
    /// The text, from the project's root.
    pub document: String,
    /// As it is typed, in one line.
    pub line: String,
    /// Its words, without a comment and without where its output goes.
    pub words: Vec<String>,
    /// Whether it is to be typed as it stands: it is a line of a block. A sentence names a command, or some of its
    /// options, or stands a letter for a number.
    pub is_whole: bool,
}

/// The commands of all texts.
///
/// # Errors
/// A text that cannot be read.
pub fn commands() -> Result<Vec<Documented>, Failure> {
    let root = workspace::root();
    let mut files: Vec<PathBuf> = ["README.md", "CONTRIBUTING.md"]
        .map(|name| root.join(name))
        .to_vec();
    for directory in ["docs", "host-tests/emulation", "host-tests/traces"] {
        let directory = root.join(directory);
        let system = |error| Failure::system(directory.display(), &error);
        for entry in fs::read_dir(&directory).map_err(system)? {
            files.push(entry.map_err(system)?.path());
        }
    }
    files.retain(|file| file.extension().is_some_and(|extension| extension == "md"));
    files.sort();
    let mut all = Vec::new();
    for file in files {
        let text =
            fs::read_to_string(&file).map_err(|error| Failure::system(file.display(), &error))?;
        all.extend(of_text(&workspace::shown(&file), &text));
    }
    Ok(all)
}

/// The commands of a text: each line of a block of shell, each call of cargo in another block, and each in a sentence.
fn of_text(document: &str, text: &str) -> Vec<Documented> {
    let mut found = Vec::new();
    for (place, part) in text.split("```").enumerate() {
        let is_block = place % 2 == 1;
        let lines: Vec<String> = if is_block {
            let (language, block) = part.split_once('\n').unwrap_or((part, ""));
            let block = block.replace("\\\n", " ");
            let lines = block.lines().map(str::trim);
            let is_command =
                |line: &&str| !line.is_empty() && (language == "sh" || line.starts_with("cargo "));
            lines.filter(is_command).map(str::to_owned).collect()
        } else {
            let spans = part.split('`').skip(1).step_by(2);
            let spans = spans.map(|span| span.replace('\n', " "));
            spans.filter(|span| span.starts_with("cargo ")).collect()
        };
        found.extend(lines.into_iter().map(|line| Documented {
            document: document.to_owned(),
            words: words(&line),
            line,
            is_whole: is_block,
        }));
    }
    // A comment is a line without a word.
    found.retain(|command| !command.words.is_empty());
    found
}

/// The words of a command as a shell has them, up to a comment or where its output goes.
fn words(command: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word: Option<String> = None;
    let mut quote = None;
    for character in command.chars() {
        match character {
            '"' | '\'' if quote.is_none_or(|quote| quote == character) => {
                quote = quote.xor(Some(character));
                word.get_or_insert_default();
            }
            '#' | '>' | '|' if quote.is_none() && word.is_none() => break,
            ' ' if quote.is_none() => words.extend(word.take()),
            _ => word.get_or_insert_default().push(character),
        }
    }
    words.extend(word);
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_found_in_blocks_and_in_sentences() {
        let text = "It is `cargo hil gap`, or `a`.\n```sh\nA=\"b c\" cargo hil \\\n    track 'd \"e' > f    # g\n\n# h\n\
                    sudo i\n```\nSays\n```text\ncargo j\nk\n```\n";
        let found = of_text("a.md", text);
        let found: Vec<(&str, bool)> = found
            .iter()
            .map(|command| (command.words.last().unwrap().as_str(), command.is_whole))
            .collect();
        assert_eq!(
            found,
            [("gap", false), ("d \"e", true), ("i", true), ("j", true)]
        );
        assert_eq!(words("A=\"b c\" d"), ["A=b c", "d"]);
    }
}
