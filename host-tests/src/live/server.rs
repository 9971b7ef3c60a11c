//! What answers the page: a few addresses, each with the token, on this computer's own address alone.

use std::fs;
use std::io::Read;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::PoisonError;
use std::thread;
use std::time::{Duration, Instant};

use firmware::app::console::request::Mode;
use firmware::app::timing::STEPS_PER_SECOND;
use serde_json::{Value, json};
use tiny_http::{Header, Method, Request, Response};

use super::board::{Ask, Board};
use super::frozen::Gap;
use super::guard::{Asked, Guard};
use super::trigger::Trigger;
use crate::failure::Failure;
use crate::page::plot;

/// The page; `{{theme}}`, `{{nonce}}` and `{{settings}}` are put in.
const PAGE: &str = include_str!("page.html");

/// Most bytes of what the page sends.
const LONGEST_BODY: u64 = 1024;

/// Threads that answer: a line that the board is slow to answer must not hold up the order to stop.
const THREADS: usize = 4;

/// How often a thread looks whether it is to end.
const LOOK: Duration = Duration::from_millis(100);

/// The server.
pub struct Server {
    http: tiny_http::Server,
    port: u16,
    guard: Guard,
    /// What the page's own script is told from any other one by.
    nonce: String,
}

/// What is answered: status, kind, content.
type Answer = (u16, &'static str, Vec<u8>);

const TEXT: &str = "text/plain; charset=utf-8";
const JSON: &str = "application/json";
const HTML: &str = "text/html; charset=utf-8";

fn text(status: u16, text: impl Into<String>) -> Answer {
    (status, TEXT, text.into().into_bytes())
}

impl Server {
    /// On the loopback at this port; 0 for any that is free.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn bind(port: u16, guard: Guard, nonce: String) -> Result<Self, Failure> {
        let failed = |error: &dyn std::fmt::Display| {
            Failure::system(
                format!("127.0.0.1:{port} (--listen takes another one)"),
                error,
            )
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|e| failed(&e))?;
        let port = listener.local_addr().map_err(|e| failed(&e))?.port();
        let http = tiny_http::Server::from_listener(listener, None).map_err(|e| failed(&e))?;
        Ok(Self {
            http,
            port,
            guard,
            nonce,
        })
    }

    /// What a browser is given.
    pub fn address(&self) -> String {
        format!(
            "http://127.0.0.1:{}/?token={}",
            self.port,
            self.guard.token()
        )
    }

    /// Answers until the end.
    ///
    /// # Errors
    /// What the system reports of its socket.
    pub fn serve(&self, board: &Board, is_ended: impl Fn() -> bool + Sync) -> Result<(), Failure> {
        let work = || -> Result<(), Failure> {
            while !is_ended() {
                let request = self.http.recv_timeout(LOOK);
                let request = request.map_err(|error| Failure::system("the server", error))?;
                if let Some(request) = request {
                    self.answer(request, board);
                }
            }
            Ok(())
        };
        thread::scope(|scope| {
            let threads = [(); THREADS].map(|()| scope.spawn(work));
            let ended = threads.map(|thread| thread.join().unwrap_or(Ok(())));
            ended.into_iter().collect()
        })
    }

    fn answer(&self, mut request: Request, board: &Board) {
        let url = request.url().to_owned();
        let (path, query) = url.split_once('?').unwrap_or((&url, ""));
        let (status, kind, content) = match self.admit(&request, query) {
            Ok(()) => self.respond(&mut request, path, query, board),
            Err(reason) => text(403, format!("refused: {reason}")),
        };
        let mut response = Response::from_data(content).with_status_code(status);
        let nonce = &self.nonce;
        let policy = format!(
            "default-src 'none'; style-src 'unsafe-inline'; script-src 'nonce-{nonce}'; connect-src 'self'; \
             img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        );
        for (name, value) in [
            ("Content-Type", kind),
            ("Content-Security-Policy", policy.as_str()),
            ("X-Frame-Options", "DENY"),
            ("X-Content-Type-Options", "nosniff"),
            ("Referrer-Policy", "no-referrer"),
            ("Cache-Control", "no-store"),
        ] {
            if let Ok(header) = Header::from_bytes(name, value) {
                response.add_header(header);
            }
        }
        // Who has gone does not wait for it.
        let _ = request.respond(response);
    }

    fn admit(&self, request: &Request, query: &str) -> Result<(), &'static str> {
        let header = |name: &'static str| {
            let mut headers = request.headers().iter();
            let found = headers.find(|header| header.field.equiv(name));
            found.map(|header| header.value.as_str())
        };
        let asked = Asked {
            host: header("Host"),
            origin: header("Origin"),
            fetched_from: header("Sec-Fetch-Site"),
            token: header("X-Token").or_else(|| parameter(query, "token")),
        };
        self.guard.admit(&asked, self.port)
    }

    fn respond(&self, request: &mut Request, path: &str, query: &str, board: &Board) -> Answer {
        match (request.method(), path) {
            (Method::Get, "/") => (200, HTML, self.page(board).into_bytes()),
            (Method::Get, "/state") => {
                let after = parameter(query, "after").and_then(|after| after.parse().ok());
                let state = state(board, after.unwrap_or(0));
                (200, JSON, state.to_string().into_bytes())
            }
            (Method::Get, "/frozen") => {
                let frozen = board.shown().frozen.clone();
                match frozen.and_then(|frozen| serde_json::to_vec(&*frozen).ok()) {
                    Some(frozen) => (200, JSON, frozen),
                    None => text(404, "nothing is frozen"),
                }
            }
            (Method::Get, "/report") => report(board),
            (Method::Post, _) => {
                let mut body = String::new();
                let read = request
                    .as_reader()
                    .take(LONGEST_BODY)
                    .read_to_string(&mut body);
                match read {
                    Ok(_) => posted(path, body, board),
                    Err(_) => text(400, "expected text"),
                }
            }
            _ => text(404, "there is nothing of this name"),
        }
    }

    fn page(&self, board: &Board) -> String {
        let settings = json!({
            "token": self.guard.token(),
            "faults": board.faults,
            "emulated": board.is_emulated,
        });
        PAGE.replace("{{theme}}", &plot::theme())
            .replace("{{nonce}}", &self.nonce)
            .replace("{{settings}}", &settings.to_string())
    }
}

/// The value of a name in an address: what this program puts there needs no decoding.
fn parameter<'a>(query: &'a str, name: &str) -> Option<&'a str> {
    query
        .split('&')
        .find_map(|pair| pair.strip_prefix(name)?.strip_prefix('='))
}

/// What is done on the page's behalf.
fn posted(path: &str, body: String, board: &Board) -> Answer {
    let ask = match path {
        "/arm" if body == "the actuator may move" => Ask::Arm,
        "/disarm" => Ask::Disarm,
        "/clear" => Ask::Clear,
        "/line" => Ask::Line(body),
        "/inject" => Ask::Inject(body),
        "/freeze" => Ask::Freeze,
        "/thaw" => Ask::Thaw,
        "/trigger" => match Trigger::read(&body) {
            Some(trigger) => Ask::Trigger(trigger),
            None => {
                return text(
                    400,
                    "expected off, fault, or above or below with a position in rad",
                );
            }
        },
        "/gap" => return trace(board),
        _ => return text(404, "there is nothing of this name"),
    };
    match board.ask(ask) {
        Ok(answer) => text(200, answer),
        Err(reason) => text(409, reason),
    }
}

fn trace(board: &Board) -> Answer {
    let Some(frozen) = board.shown().frozen.clone() else {
        return text(409, "nothing is frozen; press Freeze first");
    };
    let gap = board.gap.lock().unwrap_or_else(PoisonError::into_inner);
    if *gap == Gap::Running {
        return text(409, "the part before is still being looked at");
    }
    drop(gap);
    frozen.trace(&board.gap);
    text(200, "ok")
}

fn report(board: &Board) -> Answer {
    let frozen = board.shown().frozen.clone();
    let page = frozen.and_then(|frozen| fs::read(frozen.report.join("index.html")).ok());
    match page {
        Some(page) => (200, HTML, page),
        None => text(404, "there is no report yet"),
    }
}

/// All that has come since, and how things are.
fn state(board: &Board, after: u64) -> Value {
    let gap = board.gap.lock().unwrap_or_else(PoisonError::into_inner);
    let gap = gap.clone();
    let mut shown = board.shown();
    shown.asked = Instant::now();
    let is_new = |number: u64| number > after;
    let samples: Vec<Value> = shown
        .lives
        .iter()
        .filter(|(number, _)| is_new(*number))
        .map(|(_, live)| {
            json!([
                f64::from(live.sequence) / f64::from(STEPS_PER_SECOND),
                (live.mode == Mode::Position).then_some(live.command),
                live.input,
                live.position,
                live.current,
                live.supply,
                live.worst[0],
                live.worst[1],
                u8::from(!live.latched.is_empty()),
                (live.mode == Mode::Voltage).then_some(live.command),
            ])
        })
        .collect();
    let said: Vec<&str> = shown
        .said
        .iter()
        .filter(|(number, _)| is_new(*number))
        .map(|(_, text)| text.as_str())
        .collect();
    let last = |number: Option<u64>| number.unwrap_or(0);
    let next = last(shown.lives.back().map(|(number, _)| *number))
        .max(last(shown.said.back().map(|(number, _)| *number)));
    let live = shown.lives.back().map(|(_, live)| *live);
    let faults: Vec<Value> = live
        .iter()
        .flat_map(|live| live.latched.iter())
        .map(|fault| json!([fault.name(), fault.remedy()]))
        .collect();
    json!({
        "next": next.max(after),
        "samples": samples,
        "said": said,
        "armed": live.is_some_and(|live| live.armed),
        "permitted": shown.permitted,
        "mode": live.map(|live| live.mode.name()),
        "faults": faults,
        "freezing": shown.freezing,
        "frozen": shown.frozen.as_ref().map(|frozen| frozen.csv.clone()),
        "gap": gap,
        "problem": shown.problem,
    })
}
