//! What is written and what is not.

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
        (b"", "no two columns"),
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
