//! The tests and the runs on the emulated chip that the texts for people show.

use std::collections::BTreeSet;
use std::env::current_exe;
use std::fs;
use std::process::{Command, Stdio};

use super::host_tests::Program;
use super::{Limit, announce, succeed};
use crate::documents;
use crate::failure::Failure;
use crate::workspace;

/// What a text gives for a call that runs some tests.
#[derive(Debug, Default, PartialEq, Eq)]
struct Call {
    package: Option<String>,
    /// Name of the program of tests.
    test: String,
    filters: Vec<String>,
    /// What is said to the program itself.
    options: Vec<String>,
}

impl Call {
    /// Of the words of a command that runs some tests of one program.
    fn of(words: &[String]) -> Option<Self> {
        let place = words.iter().position(|word| word == "test")?;
        if !words[..place].iter().any(|word| word == "cargo") {
            return None;
        }
        let mut call = Self::default();
        let mut is_behind = false;
        let mut words = words[place + 1..].iter();
        while let Some(word) = words.next() {
            match word.as_str() {
                "--" => is_behind = true,
                "-p" => call.package = words.next().cloned(),
                "--test" => call.test.clone_from(words.next()?),
                option if option.starts_with('-') && is_behind => call.options.push(word.clone()),
                option if option.starts_with('-') => (),
                _ => call.filters.push(word.clone()),
            }
        }
        // A text has NAME for any name.
        let is_any = |word: &String| word.starts_with("NAME");
        let is_some = !call.test.is_empty() && !is_any(&call.test);
        (is_some && !call.filters.iter().any(is_any)).then_some(call)
    }
}

/// Whether a filter stands in a test's name where a name begins, and not within a word: `store::` takes `restore::` too.
fn begins_a_name(name: &str, filter: &str) -> bool {
    name.match_indices(filter).any(|(place, _)| {
        let before = &name[..place];
        before.is_empty() || before.ends_with(':') || !filter.contains(':') && before.ends_with('_')
    })
}

/// Demands of each call of tests in the texts that its program is there, that every filter takes a test, and that it takes none
/// but those that it names; gives how many calls there are.
///
/// # Errors
/// The calls that are not so.
pub(super) fn require_tests(programs: &[Program]) -> Result<usize, Failure> {
    let mut calls = 0;
    let mut wrong = Vec::new();
    for command in documents::commands()? {
        let Some(call) = Call::of(&command.words) else {
            continue;
        };
        calls += 1;
        let complaint = complaint(&call, programs)?;
        wrong.extend(complaint.map(|why| format!("{}: {}: {why}", command.document, command.line)));
    }
    if wrong.is_empty() {
        return Ok(calls);
    }
    let wrong = wrong.join("\n  ");
    Err(Failure::Other(format!(
        "texts name tests that are not so\n  {wrong}"
    )))
}

/// What is wrong with a call.
fn complaint(call: &Call, programs: &[Program]) -> Result<Option<String>, Failure> {
    let is_meant = |program: &&Program| {
        let (package, target) = program.name.split_once('/').unwrap_or_default();
        let named = call.package.as_ref();
        target == call.test && named.is_none_or(|named| named == package)
    };
    let Some(program) = programs.iter().find(is_meant) else {
        return Ok(Some("there is no such program of tests".to_owned()));
    };
    // Without a filter it is all of them, and there must be some.
    let all = [String::new()];
    let filters = if call.filters.is_empty() {
        &all[..]
    } else {
        &call.filters
    };
    for filter in filters {
        let names = program.list(filter, &call.options)?;
        if names.is_empty() {
            return Ok(Some(format!("no test has `{filter}` in its name")));
        }
        let other = names.iter().find(|name| !begins_a_name(name, filter));
        if let Some(other) = other {
            return Ok(Some(format!("`{filter}` takes `{other}` too")));
        }
    }
    Ok(None)
}

/// Runs every call of the texts that has to do with the emulated chip, as it stands there, one after another; gives those that
/// no time was left for.
///
/// # Errors
/// The first that fails.
pub(super) fn run_on_emulated_chips(limit: Limit) -> Result<Vec<String>, Failure> {
    let directory = workspace::results().join("documented");
    fs::create_dir_all(&directory).map_err(|error| Failure::system(directory.display(), &error))?;
    let program = current_exe().map_err(|error| Failure::system("this program", &error))?;
    let mut left = Vec::new();
    for words in on_emulated_chips()? {
        let call = words.join(" ");
        if limit.is_reached() {
            left.push(call);
            continue;
        }
        announce(&call);
        let mut command = Command::new(&program);
        command.args(&words[2..]).current_dir(&directory);
        command.stdin(Stdio::null());
        let words: Vec<&str> = words[1..].iter().map(String::as_str).collect();
        succeed(command, &words)?;
    }
    Ok(left)
}

/// The calls of the texts that run emulated chips, each once.
fn on_emulated_chips() -> Result<BTreeSet<Vec<String>>, Failure> {
    let mut commands = documents::commands()?;
    // A sentence that says no more than a command's name shows no call of its own.
    commands.retain(|command| command.is_whole || command.words.len() > 3);
    let words = commands.into_iter().map(|command| command.words);
    Ok(words
        .filter(|words| {
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            matches!(
                &words[..],
                ["cargo", "hil"]
                    | ["cargo", "hil", "ecu" | "emulate" | "onboard", ..]
                    | ["cargo", "hil", "reproduce", "throttle", ..]
            )
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn call(text: &str) -> Option<Call> {
        let words: Vec<String> = text.split(' ').map(str::to_owned).collect();
        Call::of(&words)
    }

    #[test]
    fn a_call_of_tests_is_read_as_cargo_reads_it() {
        let read = call("A=-b cargo +nightly miri test -p rig --test a b:: -- c --nocapture");
        let words = |words: &[&str]| words.iter().map(|&word| word.to_owned()).collect();
        let expected = Call {
            package: Some("rig".to_owned()),
            test: "a".to_owned(),
            filters: words(&["b::", "c"]),
            options: words(&["--nocapture"]),
        };
        assert_eq!(read, Some(expected));
        for other in [
            "cargo test",
            "cargo hil gap",
            "cargo test --test NAME",
            "cargo test --test a NAME::",
        ] {
            assert_eq!(call(other), None, "{other}");
        }
    }

    #[test]
    fn a_filter_within_a_word_takes_too_much() {
        assert!(begins_a_name("store::a", "store::"));
        assert!(begins_a_name("a::store::b", "store::"));
        assert!(!begins_a_name("restore::a", "store::"));
        assert!(!begins_a_name("re_store::a", "store::"));
        assert!(begins_a_name("a::with_hysteresis", "hysteresis"));
        assert!(begins_a_name("a", ""));
    }

    #[test]
    fn the_texts_show_runs_on_emulated_chips() {
        let calls = on_emulated_chips().unwrap();
        let calls: Vec<String> = calls.iter().map(|words| words.join(" ")).collect();
        for shown in [
            "cargo hil",
            "cargo hil ecu",
            "cargo hil emulate --at-length",
        ] {
            assert!(calls.iter().any(|call| call == shown), "{calls:?}");
        }
    }
}
