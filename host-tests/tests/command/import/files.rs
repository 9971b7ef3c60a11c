//! What is written and what is not.

use std::os::unix::fs::symlink;

use super::*;

const WORDS: &str = "import raw.csv --time t:ms --input u --position x";

fn place() -> Place {
    Place::with(
        "raw.csv",
        rows("t,u,x", 200, |k| format!("{k},{k},{}", k * k)),
    )
}

#[test]
fn nothing_of_the_users_is_replaced() {
    let place = place();
    place.write("log.csv", "mine");
    place.refuses(
        &format!("{WORDS} --out log.csv"),
        &["log.csv: ", "not replaced", "name a new"],
    );
    assert_eq!(fs::read_to_string(place.path("log.csv")).unwrap(), "mine");
    place.refuses(
        &format!("{WORDS} --out raw.csv"),
        &["raw.csv: ", "is read by this command"],
    );
    fs::create_dir(place.path("page")).unwrap();
    place.write("page/index.html", "mine");
    place.refuses(
        &format!("{WORDS} --report page --out new.csv"),
        &["index.html: ", "not replaced"],
    );
    assert_eq!(
        fs::read_to_string(place.path("page/index.html")).unwrap(),
        "mine"
    );
}

#[test]
fn not_even_an_earlier_log_an_empty_file_or_a_link_is_replaced() {
    let place = place();
    let out = |name: &str| format!("{WORDS} --out {name}");
    assert!(place.run(&out("log.csv")).status.success());
    place.write("empty.csv", "");
    symlink("nowhere.csv", place.path("dangling.csv")).unwrap();
    for name in ["log.csv", "empty.csv", "dangling.csv"] {
        place.refuses(&out(name), &[name, "is there already", "name a new"]);
    }
    symlink("raw.csv", place.path("link.csv")).unwrap();
    fs::hard_link(place.path("raw.csv"), place.path("hard.csv")).unwrap();
    for name in ["link.csv", "hard.csv"] {
        place.refuses(&out(name), &[name, "is read by this command"]);
    }
    fs::create_dir(place.path("page")).unwrap();
    place.refuses(
        &format!("{WORDS} --out page/index.html --report page"),
        &["index.html: ", "another output"],
    );
    let output = place.run(&format!("{WORDS} --out absent/log.csv --report new"));
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("there is no directory absent"));
    assert!(!place.path("new").exists());
}

#[test]
fn standard_input_is_kept_and_standard_output_written_to() {
    let place = place();
    let raw = fs::read(place.path("raw.csv")).unwrap();
    let words = WORDS.replace("raw.csv", "-");
    let from_raw = |out: &str| {
        let mut command = place.command(&format!("{words} --out {out}"));
        command.stdin(fs::File::open(place.path("raw.csv")).unwrap());
        command.output().expect("hil starts")
    };
    let output = from_raw("raw.csv");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("is read by this command"));
    let output = from_raw("/dev/stdout");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let (log, summary) =
        text(&output.stdout).split_at(text(&output.stdout).find("standard").unwrap());
    assert!(log.starts_with("time_s,input,position\n"));
    assert!(summary.contains("200 rows"), "{summary}");
    assert_eq!(fs::read(place.path("raw.csv")).unwrap(), raw);
    assert_eq!(place.names(), ["raw.csv"]);
}

#[test]
fn what_is_too_large_is_refused() {
    let place = place();
    let hole = fs::File::create(place.path("hole.csv")).unwrap();
    hole.set_len((512 << 20) + 1).unwrap();
    let words = WORDS.replace("raw.csv", "hole.csv");
    place.refuses(
        &format!("{words} --out log.csv"),
        &["hole.csv: ", "larger than 512 MB"],
    );
    place.refuses(
        &format!("{WORDS}:m*1e7 --out log.csv"),
        &["raw.csv:", "`position`", "at most 1e9"],
    );
}

#[test]
fn a_wrong_call_names_what_there_is() {
    let place = place();
    place.refuses(
        "import raw.csv --time Zeit --input u --position x --out log.csv",
        &["--time", "\"Zeit\"", "t, u, x"],
    );
    place.refuses(
        "import raw.csv --time t:V --input u --position x --out log.csv",
        &["--time", "\"V\"", "s, ms, us"],
    );
    place.refuses(
        &format!("{WORDS}:furlong --out log.csv"),
        &["--position", "furlong", "deg"],
    );
    place.refuses(
        "import absent.csv --time t --input u --position x --out a.csv",
        &["no such file"],
    );
    for (content, words) in [
        (&b"PK\x03\x04"[..], "spreadsheet"),
        (b"\x89HDF\r\n", "HDF5"),
        (b"\x7fELF\0\0", "neither text"),
        (b"hello\nworld\n", "no two columns"),
        (b"", "is empty"),
    ] {
        let place = Place::with("raw.csv", content);
        place.refuses(&format!("{WORDS} --out log.csv"), &["raw.csv: ", words]);
    }
}

#[test]
fn the_report_draws_every_column() {
    let place = place();
    let output = place.run(&format!(
        "{WORDS} --current u:mA --report page --out log.csv"
    ));
    assert!(output.status.success());
    assert_eq!(place.names(), ["log.csv", "page", "raw.csv"]);
    let page = fs::read_to_string(place.path("page/index.html")).unwrap();
    for title in ["position, rad", "current_a, A", "input\n", "time, s"] {
        assert!(page.contains(title), "{title}");
    }
    let svg = &page[page.find("<svg").unwrap()..page.find("</svg>").unwrap() + 6];
    assert!(
        roxmltree::Document::parse(svg)
            .unwrap()
            .descendants()
            .count()
            > 50
    );
    assert!(
        page.contains("none was resampled"),
        "the table stands on the page"
    );
}

/// What is wrong with a call is said beside the help of its own command, and an empty file is called that.
#[test]
fn a_short_call_and_an_empty_file_are_named() {
    let place = Place::with("empty.csv", "");
    place.refuses(
        "import empty.csv --time t",
        &[
            "--input",
            "--position",
            "--out",
            "see cargo hil import --help",
        ],
    );
    place.refuses("imports empty.csv", &["see cargo hil help"]);
    place.refuses(
        "import empty.csv --time t --input u --position x --out log.csv",
        &["empty.csv: is empty; expected a row a sample"],
    );
}
