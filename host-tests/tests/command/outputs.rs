//! Promise: the program writes a file whole or not at all, and no file of the user's is ever eaten.

use std::collections::BTreeMap;
use std::fs;
use std::io::{ErrorKind, Read};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use host_tests::outputs::MARK;
use rig::{Experiment, Machine, Trajectory};
use tempfile::TempDir;

/// After this a run counts as hung, and is killed.
const HUNG: Duration = Duration::from_secs(300);

const MACHINE: &str = "machine.toml";
const TRAIN: &str = "train.csv";
const GAP: &str = "gap --machine machine.toml --train train.csv";

/// A directory that the program is run in, with a machine file and a log that disagree: the shortest work
/// with a JSON and a report in the end.
struct Bench {
    directory: TempDir,
}

impl Bench {
    fn new() -> Self {
        let bench = Self {
            directory: tempfile::tempdir().expect("a temporary directory"),
        };
        let machine = Machine::force_slide();
        let stops = "[mechanics]\nlower_stop = -0.12\nupper_stop = 0.12";
        bench.write(MACHINE, machine.to_toml().replace("[mechanics]", stops));
        let moves = Trajectory::moves(&machine);
        let log = Experiment::tracking(machine, moves).lasting(2.0).run();
        let rows = log.to_csv();
        let rows = rows.lines().map(|row| {
            let mut fields: Vec<String> = row.split(',').map(str::to_owned).collect();
            if let Ok(metres) = fields[2].parse::<f64>() {
                fields[2] = format!("{:?}", 1e3 * metres);
            }
            fields.join(",") + "\n"
        });
        bench.write(TRAIN, rows.collect::<String>());
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Every file below the directory and what it holds; of a link where it leads. A file that a running command
    /// takes away meanwhile is not there.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        let mut directories = vec![self.directory.path().to_owned()];
        while let Some(directory) = directories.pop() {
            for entry in fs::read_dir(directory).unwrap() {
                let path = entry.unwrap().path();
                let content = fs::symlink_metadata(&path).and_then(|what| {
                    if what.is_symlink() {
                        let to = fs::read_link(&path)?;
                        return Ok(to.into_os_string().into_encoded_bytes());
                    }
                    if what.is_file() {
                        return fs::read(&path);
                    }
                    if what.is_dir() {
                        directories.push(path.clone());
                    }
                    Ok(Vec::new())
                });
                match content {
                    Ok(content) => {
                        files.insert(path, content);
                    }
                    Err(error) => assert_eq!(error.kind(), ErrorKind::NotFound, "{path:?}"),
                }
            }
        }
        files
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
        command
            .current_dir(self.directory.path())
            .args(arguments.split_whitespace());
        command
    }

    fn run(&self, arguments: &str) -> Output {
        finish(self.command(arguments))
    }

    /// Runs a line of a shell in which `$HIL` is the program.
    fn shell(&self, line: &str) -> Output {
        let mut shell = Command::new("sh");
        shell
            .current_dir(self.directory.path())
            .env("HIL", env!("CARGO_BIN_EXE_hil"))
            .args(["-c", line]);
        finish(shell)
    }

    /// Refused in one line that starts so, and nothing is other than before.
    #[track_caller]
    fn refuses(&self, arguments: &str, status: i32, start: &str) {
        let before = self.files();
        let output = self.run(arguments);
        assert_refused(&output, status, start);
        assert!(self.files() == before, "{arguments} changed a file");
    }

    #[track_caller]
    fn succeeds(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout).to_owned()
    }
}

/// What a run that ends by itself leaves; one that hangs is killed and fails.
#[track_caller]
fn finish(mut command: Command) -> Output {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    let reader = |mut from: Box<dyn Read + Send>| {
        thread::spawn(move || {
            let mut bytes = Vec::new();
            from.read_to_end(&mut bytes).unwrap();
            bytes
        })
    };
    let stdout = reader(Box::new(child.stdout.take().unwrap()));
    let stderr = reader(Box::new(child.stderr.take().unwrap()));
    let started = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if started.elapsed() > HUNG {
            child.kill().unwrap();
            panic!("hangs: {command:?}");
        }
        thread::sleep(Duration::from_millis(10));
    };
    Output {
        status,
        stdout: stdout.join().unwrap(),
        stderr: stderr.join().unwrap(),
    }
}

#[track_caller]
fn assert_refused(output: &Output, status: i32, start: &str) {
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{error}");
    assert!(error.starts_with(start), "not {start:?}: {error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(output.stdout.is_empty());
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

#[test]
fn no_output_is_an_input_by_whatever_name() {
    let bench = Bench::new();
    let log = bench.read(TRAIN);
    let machine = bench.read(MACHINE);
    bench.write("report/next-experiment.csv", &log);
    bench.write("first/full.toml", &machine);
    bench.write("second/reduced.toml", &log);
    symlink("report", bench.path("other")).unwrap();
    symlink(TRAIN, bench.path("link.csv")).unwrap();
    symlink("link.csv", bench.path("link-to-link.csv")).unwrap();
    fs::hard_link(bench.path(TRAIN), bench.path("hard.csv")).unwrap();
    let read = "is read by this command, and would be replaced; name another place";
    let next = "gap --machine machine.toml --train report/next-experiment.csv";
    let identify = "identify --slow train.csv --fast train.csv --machine machine.toml";
    for (arguments, at) in [
        (format!("{next} --report report"), "report/next-experiment.csv"),
        (format!("{next} --report other"), "other/next-experiment.csv"),
        (format!("{GAP} --validate report/next-experiment.csv --report ./report"), "./report/next-experiment.csv"),
        (format!("{GAP} --json link-to-link.csv"), "link-to-link.csv"),
        (format!("{GAP} --json hard.csv"), "hard.csv"),
        (format!("{GAP} --experiment report/../train.csv"), "report/../train.csv"),
        (format!("{identify} --machine-out machine.toml"), "machine.toml"),
        (
            "identify --slow train.csv --fast train.csv --machine first/full.toml --report first".to_owned(),
            "first/full.toml",
        ),
        (
            "identify --slow second/reduced.toml --fast train.csv --machine machine.toml --report second".to_owned(),
            "second/reduced.toml",
        ),
        ("decode machine.toml train.csv --csv train.csv".to_owned(), TRAIN),
    ] {
        bench.refuses(&arguments, 2, &format!("error: {at}: {read}"));
    }
}

#[test]
fn no_two_outputs_are_one_file() {
    let bench = Bench::new();
    fs::create_dir(bench.path("report")).unwrap();
    symlink("new.json", bench.path("link.json")).unwrap();
    for (options, at) in [
        (
            "--json report/index.html --report report",
            "report/index.html",
        ),
        ("--json new --experiment ./new", "./new"),
        ("--json link.json --experiment new.json", "new.json"),
        ("--json new --report new", "new/index.html"),
    ] {
        let start =
            format!("error: {at}: is another output of this command, and would be replaced");
        bench.refuses(&format!("{GAP} {options}"), 2, &start);
    }
    let output = bench.shell("$HIL gap --machine machine.toml --train train.csv --json out > out");
    assert_refused(&output, 2, "error: out: takes standard output");
}

#[test]
fn a_file_that_the_program_did_not_write_is_not_replaced() {
    let bench = Bench::new();
    bench.write("notes.txt", "- to do\n");
    bench.write(
        "package.json",
        "{\"name\": \"mine\", \"summary\": [], \"verdict\": 1}\n",
    );
    bench.write("mine.toml", bench.read(MACHINE));
    bench.write("played.csv", "time_s,input,position\n0,1,2\n");
    bench.write("site/index.html", "<!DOCTYPE html>\n<p>Mine</p>\n");
    bench.write("logs/next-experiment.csv", bench.read(TRAIN));
    bench.write("machines/polished.toml", bench.read(MACHINE));
    let identify = "identify --slow train.csv --fast train.csv --machine machine.toml";
    for (arguments, at) in [
        (format!("{GAP} --json notes.txt"), "notes.txt"),
        (format!("{GAP} --json package.json"), "package.json"),
        (format!("{GAP} --experiment played.csv"), "played.csv"),
        (format!("{GAP} --report site"), "site/index.html"),
        (format!("{GAP} --report logs"), "logs/next-experiment.csv"),
        (format!("{identify} --machine-out mine.toml"), "mine.toml"),
        (
            format!("{identify} --report machines"),
            "machines/polished.toml",
        ),
        (
            "decode machine.toml train.csv --csv notes.txt".to_owned(),
            "notes.txt",
        ),
        (
            "decode machine.toml train.csv --csv played.csv".to_owned(),
            "played.csv",
        ),
    ] {
        let start = format!("error: {at}: is there already and is no result of this program");
        bench.refuses(&arguments, 2, &start);
    }
}

#[test]
fn what_cannot_be_written_is_refused_before_the_work() {
    let bench = Bench::new();
    bench.write("closed.json", "");
    let closed = fs::Permissions::from_mode(0o444);
    fs::set_permissions(bench.path("closed.json"), closed).unwrap();
    symlink("round.json", bench.path("round.json")).unwrap();
    symlink("absent/out.json", bench.path("nowhere.json")).unwrap();
    for (options, start) in [
        ("--json closed.json", "closed.json: is read-only"),
        (
            "--json round.json",
            "round.json: is a symbolic link that leads to itself",
        ),
        (
            "--json nowhere.json",
            "nowhere.json: there is no directory ",
        ),
        (
            "--json absent/out.json",
            "absent/out.json: there is no directory absent; create it",
        ),
        ("--json new/", "new/: is the name of a directory"),
        (
            "--json train.csv/out.json",
            "train.csv/out.json: there is no directory train.csv",
        ),
        (
            "--report train.csv",
            "train.csv: is a file; expected the name of a directory",
        ),
        ("--report train.csv/report", "train.csv/report: "),
        ("--json /dev/fd/99", "/dev/fd/99: is not open"),
        // Nobody may make a file there, not even root.
        (
            "--json /proc/out.json",
            "/proc/out.json: cannot be written (",
        ),
        ("--report /proc/report", "/proc/report: cannot be written ("),
    ] {
        // The log is none: it would be refused first, were it read before.
        bench.write("empty.csv", "");
        let arguments = format!("gap --machine machine.toml --train empty.csv {options}");
        bench.refuses(&arguments, 1, &format!("error: {start}"));
    }
}

#[test]
fn an_earlier_result_is_replaced_and_all_else_survives() {
    let bench = Bench::new();
    bench.write("report/notes.txt", "mine");
    bench.write("report/style.css", "mine");
    // From an earlier run, which had something to propose.
    bench.write("report/next-experiment.csv", "time_s,input\n0.0,1.0\n");
    bench.write("results/empty.json", "");
    symlink("results/empty.json", bench.path("link.json")).unwrap();
    let arguments = format!("{GAP} --json link.json --report report");
    for _ in 0..2 {
        bench.succeeds(&arguments);
        assert!(
            bench
                .read("results/empty.json")
                .contains("log_and_machine_disagree")
        );
        assert_eq!(
            fs::read_link(bench.path("link.json")).unwrap(),
            Path::new("results/empty.json")
        );
        let page = bench.read("report/index.html");
        assert!(page.contains(MARK) && page.ends_with("</html>\n"), "{page}");
        let mut names: Vec<String> = bench
            .files()
            .keys()
            .map(|path| {
                path.strip_prefix(bench.directory.path())
                    .unwrap()
                    .display()
                    .to_string()
            })
            .collect();
        names.sort();
        let expected = [
            "link.json",
            "machine.toml",
            "report",
            "report/index.html",
            "report/notes.txt",
            "report/style.css",
            "results",
            "results/empty.json",
            "train.csv",
        ];
        assert_eq!(names, expected);
    }
}

#[test]
fn what_is_written_may_be_read_by_those_who_may_read_files_here() {
    let bench = Bench::new();
    bench.write("plain", "");
    bench.write("shared.json", "");
    fs::set_permissions(bench.path("shared.json"), fs::Permissions::from_mode(0o664)).unwrap();
    bench.succeeds(&format!("{GAP} --json shared.json --report new/report"));
    let mode = |name: &str| fs::metadata(bench.path(name)).unwrap().permissions().mode();
    assert_eq!(mode("new/report/index.html"), mode("plain"));
    assert_eq!(mode("shared.json") & 0o777, 0o664);
}

#[test]
fn devices_and_pipes_are_written_to() {
    let bench = Bench::new();
    let call = "$HIL gap --machine machine.toml --train train.csv --json";
    let printed = bench.shell(&format!("{call} /dev/stdout | cat"));
    assert!(text(&printed.stdout).starts_with("{\n"), "{printed:?}");
    let table = bench.succeeds(&format!("{GAP} --json /dev/null"));
    let json = text(&printed.stdout)
        .strip_suffix(&table)
        .expect("then the table");
    assert!(serde_json::from_str::<serde_json::Value>(json).is_ok());

    // But for the seconds that it took.
    let lasting = |json: &str| {
        let lines = json.lines().filter(|line| !line.contains("\"seconds\""));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };

    // A file that the shell opened gets both, one after the other.
    bench.shell(&format!("{call} /dev/stdout > both"));
    assert_eq!(lasting(&bench.read("both")), lasting(text(&printed.stdout)));
    bench.shell(&format!("{call} /dev/fd/3 3> third"));
    assert_eq!(lasting(&bench.read("third")), lasting(json));

    let piped = bench.shell(&format!(
        "mkfifo pipe && {{ cat pipe > copy & {call} pipe; wait; }}"
    ));
    assert!(piped.status.success(), "{piped:?}");
    assert_eq!(lasting(&bench.read("copy")), lasting(json));
    let there = bench.shell("test -p pipe && test -c /dev/null");
    assert!(there.status.success());
}

/// A device without room, and a file system whose files may not grow: neither leaves half a report, nor
/// takes an earlier one.
#[test]
fn without_room_nothing_is_written() {
    let bench = Bench::new();
    bench.refuses(
        &format!("{GAP} --json /dev/full --report report"),
        1,
        "error: /dev/full: cannot be written (",
    );
    for earlier in [None, Some(format!("<!-- {MARK} -->"))] {
        if let Some(page) = &earlier {
            bench.write("report/index.html", page);
        }
        let before = bench.files();
        let output = bench.shell(
            "ulimit -f 8; $HIL gap --machine machine.toml --train train.csv --json out.json --report report",
        );
        assert_refused(
            &output,
            1,
            "error: report/index.html: cannot be written (File too large",
        );
        assert!(bench.files() == before);
    }
}

/// The run waits for the reader of a pipe, with its report prepared, when it is ended.
#[test]
fn a_signal_leaves_nothing_behind() {
    let bench = Bench::new();
    assert!(bench.shell("mkfifo pipe").status.success());
    let before = bench.files();
    for (name, number) in [("TERM", 15), ("INT", 2)] {
        let mut child = bench
            .command(&format!("{GAP} --json pipe --report report"))
            .spawn()
            .unwrap();
        let started = Instant::now();
        let prepared = || {
            let files = bench.files();
            let mut pages = files
                .iter()
                .filter(|(path, _)| path.extension().is_some_and(|it| it == "part"));
            pages.any(|(_, content)| content.ends_with(b"</html>\n"))
        };
        while !prepared() {
            let ended = child.try_wait().unwrap();
            if ended.is_some() || started.elapsed() > HUNG {
                child.kill().unwrap();
                panic!("{ended:?}, and no report prepared");
            }
            thread::sleep(Duration::from_millis(10));
        }
        let killed = bench.shell(&format!("kill -{name} {}", child.id()));
        assert!(killed.status.success());
        assert_eq!(child.wait().unwrap().signal(), Some(number));
        assert!(bench.files() == before, "{:?}", bench.files().keys());
    }
}

#[test]
fn a_header_of_many_columns_is_read() {
    let bench = Bench::new();
    let names: Vec<String> = (0..300_000).map(|place| format!("c{place}")).collect();
    let header = format!("time_s,input,position,{}", names.join(","));
    bench.write("wide.csv", format!("{header}\n0,1,2\n"));
    let arguments = "gap --machine machine.toml --train wide.csv";
    bench.refuses(
        arguments,
        2,
        "error: wide.csv:2: 3 fields, the header has 300003",
    );
    bench.write("wide.csv", format!("{header},c0\n"));
    bench.refuses(
        arguments,
        2,
        "error: wide.csv:1: the column \"c0\" is there twice",
    );
}

#[test]
fn a_name_that_is_none_of_many_columns_is_refused() {
    let bench = Bench::new();
    let names: Vec<String> = (0..300_000)
        .map(|place| format!("c{}", place % 7))
        .collect();
    bench.write("wide.csv", format!("{}\n0,1,2\n", names.join(",")));
    let output = bench.run("import wide.csv --time absent --position c1 --out log.csv");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).starts_with("error: "));
}

#[test]
fn a_file_that_comes_up_during_a_run_is_not_replaced() {
    let bench = Bench::new();
    // The log is read behind the outputs' places were looked at, and not before somebody writes it.
    let output = bench.shell(
        "mkfifo pipe; $HIL gap --machine machine.toml --train pipe --json out.json & \
         exec 3>pipe; echo mine > out.json; cat train.csv >&3; exec 3>&-; wait $!",
    );
    assert_refused_with(&output, "error: ");
    assert!(text(&output.stderr).contains("out.json: has come up meanwhile"));
    assert_eq!(bench.read("out.json"), "mine\n");
}

#[test]
fn nothing_is_appended_to_what_is_read() {
    let bench = Bench::new();
    let before = bench.files();
    for line in [
        "$HIL gap --machine machine.toml --train train.csv >> train.csv",
        "$HIL gap --machine machine.toml --train train.csv --json /dev/stdout >> train.csv",
        "$HIL export --machine machine.toml --to c >> machine.toml",
    ] {
        let output = bench.shell(line);
        assert_refused_with(
            &output,
            "error: standard output goes to a file that this command reads",
        );
        assert!(bench.files() == before, "{line}");
    }
}

/// Refused, with a line that starts so.
#[track_caller]
fn assert_refused_with(output: &Output, start: &str) {
    let error = text(&output.stderr);
    assert!(!output.status.success());
    assert!(error.starts_with(start), "not {start:?}: {error}");
}

#[test]
fn an_error_that_nobody_can_read_is_no_panic() {
    let bench = Bench::new();
    let output = bench.shell("$HIL gap --machine absent.toml --train train.csv 2> /dev/full");
    assert_eq!(output.status.code(), Some(2));
    let output = bench.shell("$HIL gap 2> /dev/full");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_position_that_jumps_for_one_sample_is_said_with_its_line() {
    let bench = Bench::new();
    let log = bench.read(TRAIN);
    let mut rows: Vec<String> = log.lines().map(str::to_owned).collect();
    let mut fields: Vec<&str> = rows[1000].split(',').collect();
    fields[2] = "1e6";
    rows[1000] = fields.join(",");
    bench.write(TRAIN, rows.join("\n"));
    let output = bench.run(GAP);
    assert!(output.status.success());
    let warning = text(&output.stderr);
    assert!(
        warning
            .starts_with("warning: train.csv:1001: `position` is 1000000.0 in this sample alone")
    );
    assert_eq!(warning.lines().count(), 1, "{warning}");
    bench.write(TRAIN, log);
    assert!(bench.run(GAP).stderr.is_empty());
}

#[test]
fn an_error_is_one_short_line_without_control_characters() {
    let bench = Bench::new();
    let long = "x".repeat(100_000);
    let strange = "a\u{1b}[31m\nb";
    bench.write(strange, "");
    bench.write("long.toml", format!("[mechanics]\n{long} = 1\n"));
    bench.write("long.csv", format!("time_s,input,position\n{long},1,2\n"));
    let machine = ["gap", "--machine", "machine.toml"];
    let cases: [&[&str]; 7] = [
        &["--train", strange],
        &["--train", &long],
        &["--train", TRAIN, "--json", "absent\u{7}/out.json"],
        &["--train", "long.csv"],
        &["--train", TRAIN, "--machine-\u{1b}out", &long],
        &["--train", TRAIN, &long],
        &["--train", TRAIN, "--json", &long],
    ];
    let long_machine = ["gap", "--machine", "long.toml", "--train", TRAIN];
    let calls = cases.iter().map(|more| [&machine, *more].concat());
    for call in calls.chain([long_machine.to_vec()]) {
        let output = finish({
            let mut command = bench.command("");
            command.args(&call);
            command
        });
        let error = text(&output.stderr).strip_suffix('\n').unwrap();
        assert!(matches!(output.status.code(), Some(1 | 2)), "{error}");
        assert!(error.starts_with("error: "), "{error}");
        assert!(!error.contains(char::is_control), "{error:?}");
        assert!(error.chars().count() < 3000, "{} characters", error.len());
    }
}

#[test]
fn an_import_prints_no_control_characters_of_a_file() {
    let bench = Bench::new();
    let log = bench.read(TRAIN);
    bench.write(TRAIN, log.replacen("input", "in\u{1b}]0;title\u{7}put", 1));
    let arguments = "import train.csv --time time_s:s --input 2 --position position --out log.csv";
    let printed = bench.succeeds(arguments);
    assert!(printed.contains("in\\u{1b}]0;title\\u{7}put"), "{printed}");
    let is_control = |character: char| character.is_control() && character != '\n';
    assert!(!printed.contains(is_control), "{printed:?}");
}

/// A machine file of this program among the logs is an input as the others are.
#[test]
fn nothing_is_written_among_the_logs_of_a_benchmark() {
    let bench = Bench::new();
    bench.write("logs/emps/machine.toml", format!("# {MARK}\n"));
    bench.write("logs/emps/train.csv", "");
    symlink("logs", bench.path("other")).unwrap();
    for json in [
        "logs/emps/machine.toml",
        "logs/emps/train.csv",
        "other/emps/new.json",
    ] {
        bench.refuses(
            &format!("bench real logs --json {json}"),
            2,
            &format!("error: {json}: is read by this command, and would be replaced"),
        );
    }
}

#[test]
fn the_help_says_what_is_replaced_and_how_large_a_file_may_be() {
    let bench = Bench::new();
    for command in ["", "gap", "import", "identify", "decode"] {
        let help = bench.succeeds(&format!("{command} --help"));
        for words in [MARK, "what is read is never written", "512 MB"] {
            assert!(help.contains(words), "no {words:?} in: {help}");
        }
    }
}
