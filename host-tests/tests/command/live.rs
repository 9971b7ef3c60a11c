//! `cargo hil live`: who is answered, that nothing moves unasked, and what the page shows and does.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use firmware::app::machine::EMA;
use host_tests::board_link::emulated::{EmulatedBoard, Pace};
use host_tests::toolchain::BROWSERS;
use serde_json::Value;
use tempfile::TempDir;

use crate::record::serve;

/// A page that is served.
struct Served {
    child: Child,
    port: u16,
    token: String,
    directory: TempDir,
}

/// What was answered: status, head, content.
struct Answer {
    status: u16,
    head: String,
    content: String,
}

impl Served {
    /// Of a board at this port; of an emulated one where there is none.
    fn start(port: Option<&Path>) -> Self {
        match port {
            Some(port) => Self::of(&["--port", port.to_str().unwrap()]),
            None => Self::of(&[]),
        }
    }

    /// Of a board that is reached so.
    fn of(way: &[&str]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_hil"));
        command.arg("live").args(way);
        command.arg("--out").arg(directory.path());
        let mut child = command
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut address = String::new();
        let out = child.stdout.as_mut().unwrap();
        BufReader::new(out).read_line(&mut address).unwrap();
        let rest = address.trim().strip_prefix("http://127.0.0.1:").unwrap();
        let (port, token) = rest.split_once("/?token=").unwrap();
        Self {
            child,
            port: port.parse().unwrap(),
            token: token.to_owned(),
            directory,
        }
    }

    /// Sends a request with exactly these lines in its head.
    fn send(&self, request: &str, head: &[String], body: &str) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let mut text = format!("{request} HTTP/1.0\r\n");
        for line in head {
            text += &format!("{line}\r\n");
        }
        text += &format!("Content-Length: {}\r\n\r\n{body}", body.len());
        stream.write_all(text.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, content) = answer.split_once("\r\n\r\n").unwrap();
        Answer {
            status: head.split(' ').nth(1).unwrap().parse().unwrap(),
            head: head.to_owned(),
            content: content.to_owned(),
        }
    }

    /// What the page itself would send.
    fn own_head(&self) -> Vec<String> {
        vec![
            format!("Host: 127.0.0.1:{}", self.port),
            format!("Origin: http://127.0.0.1:{}", self.port),
            format!("X-Token: {}", self.token),
        ]
    }

    fn post(&self, path: &str, body: &str) -> Answer {
        self.send(&format!("POST {path}"), &self.own_head(), body)
    }

    fn get(&self, path: &str) -> Answer {
        self.send(&format!("GET {path}"), &self.own_head(), "")
    }

    fn state(&self) -> Value {
        serde_json::from_str(&self.get("/state?after=0").content).unwrap()
    }

    /// The state once it is as it should be.
    fn until(&self, is_so: impl Fn(&Value) -> bool) -> Value {
        loop {
            let state = self.state();
            if is_so(&state) {
                return state;
            }
            assert_eq!(state["problem"], Value::Null);
            thread::sleep(Duration::from_millis(50));
        }
    }

    fn files(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(self.directory.path()).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Position of the newest sample; no number while there is none.
fn position(state: &Value) -> f64 {
    let samples = state["samples"].as_array().unwrap();
    let newest = samples.last().map(|sample| sample[3].as_f64().unwrap());
    newest.unwrap_or(f64::NAN)
}

#[test]
fn only_the_printed_address_is_answered_and_no_refusal_tells_the_token() {
    let served = Served::start(None);
    let (port, token) = (served.port, &served.token);
    let host = format!("Host: 127.0.0.1:{port}");
    let key = format!("X-Token: {token}");
    let refused = |request: &str, head: &[&str]| {
        let head: Vec<String> = head.iter().map(|line| (*line).to_owned()).collect();
        let answer = served.send(request, &head, "");
        assert_eq!(answer.status, 403, "{request} {head:?}");
        assert!(!answer.head.contains(token) && !answer.content.contains(token));
    };
    for request in [
        "GET /",
        "GET /state",
        "GET /frozen",
        "POST /arm",
        "POST /line",
    ] {
        refused(request, &[&host]);
        refused(request, &[&host, "X-Token: 0"]);
        refused(request, &["Host: rebound.example", &key]);
        refused(request, &[&format!("Host: rebound.example:{port}"), &key]);
        refused(request, &[&host, &key, "Origin: http://other.example"]);
        refused(request, &[&host, &key, "Origin: null"]);
        refused(request, &[&host, &key, "Sec-Fetch-Site: cross-site"]);
    }
    let page = served.get(&format!("/?token={token}"));
    assert_eq!(page.status, 200);
    assert!(page.content.starts_with("<!DOCTYPE html>"));
    for line in [
        "frame-ancestors 'none'",
        "X-Frame-Options: DENY",
        "no-referrer",
    ] {
        assert!(page.head.contains(line), "{}", page.head);
    }
    // Bound to one address, not to all of this computer's.
    assert!(TcpStream::connect(("127.0.0.2", port)).is_err());
}

#[test]
fn nothing_moves_before_arm_and_nothing_goes_on_without_the_page() {
    let board = EmulatedBoard::start(EMA.plant, Pace::RealTime).unwrap();
    let served = Served::start(Some(&board.port));
    let is_armed = || board.wiring.latch().is_armed();
    for (path, body) in [
        ("/line", "step 0 0.5"),
        ("/line", "arm"),
        ("/line", "ping\rarm"),
        ("/line", "ping\narm"),
        ("/arm", ""),
        ("/arm", "yes"),
    ] {
        let answer = served.post(path, body);
        assert!(answer.status >= 400, "{path} {body}: {}", answer.content);
    }
    assert_eq!(served.get("/arm").status, 404);
    assert!(!board.was_armed.load(std::sync::atomic::Ordering::Relaxed));

    assert_eq!(served.post("/arm", "the actuator may move").status, 200);
    assert!(is_armed());
    assert_eq!(served.post("/line", "step 0 0.5").status, 200);
    served.until(|state| (position(state) - 0.5).abs() < 0.09);
    assert_eq!(served.post("/disarm", "").status, 200);
    assert!(!is_armed());
    assert_eq!(served.post("/line", "step 0 0").status, 409);

    assert_eq!(served.post("/arm", "the actuator may move").status, 200);
    // Nobody asks for the state any more.
    while is_armed() {
        thread::sleep(Duration::from_millis(50));
    }
    let state = served.until(|state| state["said"].to_string().contains("the page was closed"));
    assert_eq!(state["permitted"], false);
}

/// A word of the console that takes the drive's power ends the permission, and Arm gives it anew.
#[test]
fn a_drive_that_the_console_disarms_can_be_armed_again() {
    let board = Served::start(None);
    for line in ["disarm", "stop"] {
        assert_eq!(board.post("/arm", "the actuator may move").status, 200);
        board.until(|state| state["armed"] == true && state["permitted"] == true);
        assert_eq!(board.post("/line", line).status, 200);
        board.until(|state| state["armed"] == false && state["permitted"] == false);
        assert_eq!(board.post("/line", "step 0 0.3").status, 409);
    }
    assert_eq!(board.post("/arm", "the actuator may move").status, 200);
    assert_eq!(board.post("/line", "step 0 0.3").status, 200);
    board.until(|state| (position(state) - 0.3).abs() < 0.09);
}

/// A place that cannot be written to is refused at once, and not when something is to be kept.
#[test]
fn a_place_that_is_a_file_is_refused_before_the_board_is_driven() {
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("taken");
    std::fs::write(&file, "mine").unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .args(["live", "--out", file.to_str().unwrap()])
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && output.stdout.is_empty());
    assert!(
        said.contains("is a file; expected the name of a directory"),
        "{said}"
    );
    assert_eq!(std::fs::read(&file).unwrap(), b"mine");
}

/// Clear ends a fault as the page shows it, the drive armed or not, and a rotor that is free again moves.
#[test]
fn a_rotor_that_was_blocked_moves_again_once_healed_and_cleared() {
    let board = Served::start(None);
    let armed = |line: &str| {
        assert_eq!(board.post("/arm", "the actuator may move").status, 200);
        assert_eq!(board.post("/line", line).status, 200);
    };
    armed("step 0 0.3");
    board.until(|state| (position(state) - 0.3).abs() < 0.09);
    assert_eq!(board.post("/inject", "blocked").status, 200);
    assert_eq!(board.post("/line", "step 0 -0.3").status, 200);
    board.until(|state| state["faults"] != serde_json::json!([]));
    assert_eq!(board.post("/inject", "heal").status, 200);
    let cleared = board.post("/clear", "");
    assert_eq!((cleared.status, cleared.content.as_str()), (200, "ok"));
    board.until(|state| state["faults"] == serde_json::json!([]) && state["armed"] == false);
    armed("step 0 -0.3");
    board.until(|state| (position(state) + 0.3).abs() < 0.09);
}

#[test]
fn the_end_of_the_program_disarms_the_drive() {
    ends_disarmed(|port| Served::start(Some(port)));
}

#[test]
fn the_end_of_the_program_disarms_the_drive_at_a_probe() {
    ends_disarmed(|port| Served::of(&["--rtt", &serve(port)]));
}

fn ends_disarmed(start: impl FnOnce(&Path) -> Served) {
    let board = EmulatedBoard::start(EMA.plant, Pace::RealTime).unwrap();
    let mut served = start(&board.port);
    assert_eq!(served.post("/arm", "the actuator may move").status, 200);
    assert!(board.wiring.latch().is_armed());
    let sent = Command::new("kill")
        .args(["-INT", &served.child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    served.child.wait().unwrap();
    assert!(!board.wiring.latch().is_armed());
}

#[test]
fn a_fault_freezes_what_was_driven_and_gap_finds_what_the_motor_has() {
    let served = Served::start(None);
    assert_eq!(served.post("/freeze", "").status, 409, "nothing was driven");
    assert_eq!(served.post("/gap", "").status, 409);
    assert_eq!(served.post("/trigger", "fault").status, 200);
    assert_eq!(served.post("/trigger", "sideways").status, 400);
    assert_eq!(served.post("/arm", "the actuator may move").status, 200);
    assert_eq!(served.post("/line", "sweep 0 0.5 0.5 3 8").status, 200);
    let start = served.state()["next"].as_u64().unwrap();
    served.until(|state| state["next"].as_u64().unwrap() > start + 6 * 50);
    assert_eq!(served.post("/inject", "bridge_break").status, 200);
    let state = served.until(|state| !state["frozen"].is_null());
    assert_eq!(state["faults"][0][0], "bridge_break");
    assert_eq!(state["permitted"], false);
    let frozen: Value = serde_json::from_str(&served.get("/frozen").content).unwrap();
    assert!(frozen["rows"].as_array().unwrap().len() > 500);
    assert_eq!(served.post("/gap", "").status, 200);
    let state = served.until(|state| state["gap"]["stage"] != "running");
    assert_eq!(state["gap"]["stage"], "done", "{}", state["gap"]);
    let said = state["gap"]["text"].as_str().unwrap();
    assert!(said.contains("asymmetric_viscous"), "{said}");
    assert!(served.get("/report").content.contains("<svg"));
    assert_eq!(served.files().len(), 3, "{:?}", served.files());

    // The next one stands beside it.
    assert_eq!(served.post("/thaw", "").status, 200);
    assert_eq!(served.post("/freeze", "").status, 200);
    served.until(|state| !state["frozen"].is_null());
    assert_eq!(served.files().len(), 5);
}

/// What a refit or a check finds is said, and the board's log is there for the next question.
#[test]
fn a_refit_and_a_check_say_what_they_find_and_freezing_works_again() {
    let served = Served::start(None);
    let drive = |seconds: u64| {
        assert_eq!(served.post("/arm", "the actuator may move").status, 200);
        assert_eq!(served.post("/line", "sweep 0 0.5 0.5 3 8").status, 200);
        let start = served.state()["next"].as_u64().unwrap();
        served.until(|state| state["next"].as_u64().unwrap() > start + seconds * 50);
        assert_eq!(served.post("/disarm", "").status, 200);
    };
    let ask = |question: &str, result: &str| {
        assert_eq!(served.post("/line", question).content, "ok");
        served.until(|state| state["said"].to_string().contains(result));
    };
    // Nothing was driven.
    ask("refit", "no refit: ");
    ask("check", "no check: ");
    for (question, result) in [("refit", "refit: coulomb "), ("check", "\"check: ")] {
        drive(6);
        ask(question, result);
        drive(1);
        let freezing = served.post("/freeze", "");
        assert_eq!(freezing.status, 200, "{}", freezing.content);
        served.until(|state| !state["frozen"].is_null());
        assert_eq!(served.post("/thaw", "").status, 200);
    }
}

#[test]
fn the_page_shows_the_drive_in_a_browser() {
    let is_there = |name: &&&str| {
        let found = Command::new(name).arg("--version").output();
        found.is_ok_and(|found| found.status.success())
    };
    let Some(browser) = BROWSERS.iter().find(is_there) else {
        eprintln!(
            "skipped: there is no Chromium on this machine; `cargo hil test` installs it where it can"
        );
        return;
    };
    let served = Served::start(None);
    let profile = tempfile::tempdir().unwrap();
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
            "--no-first-run",
            "--virtual-time-budget=2000",
            "--dump-dom",
        ])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg(format!(
            "http://127.0.0.1:{}/?token={}",
            served.port, served.token
        ))
        .output()
        .unwrap();
    let page = String::from_utf8_lossy(&output.stdout);
    assert!(page.contains(">disarmed, position</span>"), "{page}");
    // The newest position, drawn beside its plot.
    assert!(page.contains(" rad</output>"), "{page}");
    assert!(page.contains("<option value=\"encoder_lost\">"), "{page}");
}
