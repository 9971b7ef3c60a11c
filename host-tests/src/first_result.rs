//! The first thing that plain `cargo hil` shows, while the rest builds: the README's way from a data sheet and
//! two logs to a verdict, on logs that lie in the tree.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;
use crate::outputs::write_own;
use crate::workspace;

/// The sheet of a gearmotor with an encoder. What it says is printed as a machine file.
pub const MACHINE: &str = "machine --voltage 12V --no-load-speed 200rpm --no-load-current 0.2A --stall-torque \
                           21kg.cm --stall-current 5.5A --gear-ratio 50 --values-of gearmotor --measured-current";

/// What its logger wrote, and the logs that this becomes. A simulated arm hangs on its shaft.
pub const IMPORTS: [(&str, &str); 2] = [
    ("host-tests/examples/run-a.csv", "a.csv"),
    ("host-tests/examples/run-b.csv", "b.csv"),
];

/// The columns of the logger's files.
pub const COLUMNS: &str = "--time t:ms --position pos:deg --input duty:%*12 --current i:mA";

/// What is asked of the logs.
pub const GAP: &str = "gap --machine machine.toml --train a.csv --validate b.csv --report report";

/// The page of that report, from where it is called.
const PAGE: &str = "report/index.html";

/// The answer, as a user who types these calls gets it. What they leave is in `target/hil/example`.
///
/// # Errors
/// A call that fails, with what it said.
pub fn trace() -> Result<String, Failure> {
    let place = directory();
    let system = |error: io::Error| Failure::system(place.display(), error);
    fs::create_dir_all(&place).map_err(system)?;
    // An earlier run's: `import` replaces no log. Whatever else lies there stays.
    for (_, log) in IMPORTS {
        match fs::remove_file(place.join(log)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(system(error)),
            _ => {}
        }
    }
    let machine = call(&place, &words(MACHINE))?;
    write_own(&place.join("machine.toml"), machine)?;
    for (raw, log) in IMPORTS {
        let raw = workspace::root().join(raw).display().to_string();
        let mut import = vec!["import", &raw];
        import.extend(words(COLUMNS));
        import.extend(["--out", log]);
        call(&place, &import)?;
    }
    Ok(seen_from_here(&call(&place, &words(GAP))?))
}

/// The answer with the report's place as it is from where the user stands: the call ran in another directory.
fn seen_from_here(answer: &str) -> String {
    let page = workspace::shown(&directory().join(PAGE));
    answer.replace(&format!("Plots: {PAGE}."), &format!("Plots: {page}."))
}

/// Where the calls run.
pub fn directory() -> PathBuf {
    workspace::results().join("example")
}

fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

/// What this program prints, called with these words.
fn call(place: &Path, words: &[&str]) -> Result<String, Failure> {
    let system = |error: &io::Error| Failure::system("this program cannot call itself", error);
    let program = std::env::current_exe().map_err(|error| system(&error))?;
    let output = Command::new(program)
        .args(words)
        .current_dir(place)
        .output()
        .map_err(|error| system(&error))?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    Err(Failure::Other(format!(
        "cargo hil {}: {}",
        words.join(" "),
        said.trim_end()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_of_the_report_is_named_from_where_the_user_stands() {
        let said =
            seen_from_here("All numbers: --verbose. Plots: report/index.html. More: --json FILE.");
        let shown = said
            .split(' ')
            .find(|word| word.contains("index.html"))
            .unwrap();
        let page = shown.trim_end_matches('.');
        assert!(page.ends_with("hil/example/report/index.html"), "{said}");
        assert!(said.ends_with(". More: --json FILE."), "{said}");
    }

    #[test]
    fn the_calls_are_those_that_the_readme_shows() {
        let readme = fs::read_to_string(workspace::root().join("README.md")).unwrap();
        let readme = readme.replace(['\\', '"'], " ");
        let shown: Vec<&str> = readme.split_whitespace().collect();
        let mut calls = vec![words(MACHINE), words(GAP)];
        for (raw, log) in IMPORTS {
            calls.push([vec!["import", raw], words(COLUMNS), vec!["--out", log]].concat());
        }
        for call in calls {
            let is_shown = shown.windows(call.len()).any(|words| words == call);
            assert!(is_shown, "{call:?}");
        }
    }
}
