//! The firmware's console on this host, with a drive behind it that does nothing but keep what it is
//! told: for tests and for fuzzing.

use firmware::app::capture::{CAPTURE_VALUES, Capture, Stage};
use firmware::app::console::editor::{LINE, PROMPT};
use firmware::app::console::request::{Dump, Mode, Request};
use firmware::app::console::response::{Latched, Refusal, Response, Status};
use firmware::app::console::{self, Console};
use firmware::app::ecu::loopback;
use firmware::app::fault::latch::Latch;
use firmware::app::operation::live::MOST_RATE;
use firmware::app::profile::Signal;
use firmware::app::store::field::Description;
use model_core::plant::parameters::Parameters;
use model_core::plant::throttle::Throttle;

/// What can be shown and set here: bounds of several kinds.
pub const PARAMETERS: [Description; 4] = [
    described("resistance", "Ω", 1e-3, 1e3),
    described("coulomb", "N·m", 0.0, 1e2),
    described("spring_rest", "rad", -1e2, 1e2),
    described("track_1_gain", "1", 0.5, 2.0),
];

const fn described(name: &'static str, unit: &'static str, lower: f32, upper: f32) -> Description {
    Description {
        name,
        unit,
        lower,
        upper,
    }
}

/// A drive that remembers.
pub struct ConsoleOnHost {
    console: Console<'static>,
    /// The fault latch.
    pub latch: Latch,
    /// The parameters' values.
    pub values: [f32; PARAMETERS.len()],
    /// What a command signal is.
    pub mode: Mode,
    /// The command signal.
    pub signal: Option<Signal>,
    /// The capture.
    pub capture: Box<Capture>,
    /// The throttle body.
    pub body: Option<Throttle>,
    /// The requests so far.
    pub requests: Vec<Request>,
}

impl ConsoleOnHost {
    /// Disarmed and sound.
    pub fn new() -> Self {
        Self {
            console: Console::new(&PARAMETERS),
            latch: Latch::new(),
            values: [1.0; PARAMETERS.len()],
            mode: Mode::default(),
            signal: None,
            capture: Box::default(),
            body: None,
            requests: Vec::new(),
        }
    }

    /// A throttle body to inject faults into.
    ///
    /// # Panics
    /// If its numbers are out of their ranges.
    pub fn with_body(plant: Parameters) -> Self {
        let settings = loopback::complementary(plant, 1);
        let body = Throttle::build(&settings, 50e-6).expect("a throttle in its ranges");
        Self {
            body: Some(body),
            ..Self::new()
        }
    }

    /// The line so far.
    pub fn line(&self) -> &str {
        self.console.line()
    }

    /// What the terminal is sent for a byte.
    pub fn take(&mut self, byte: u8) -> String {
        let mut sent = String::new();
        if let Some(request) = self.console.take(byte, &mut sent) {
            self.requests.push(request);
            let response = self.perform(request);
            console::reply(&response, &mut sent);
        }
        sent
    }

    /// What the terminal is sent for a line, without the echo and the prompt.
    pub fn line_response(&mut self, line: &str) -> String {
        for byte in line.bytes() {
            self.take(byte);
        }
        let sent = self.take(b'\r');
        let response = sent.strip_prefix("\r\n").unwrap_or(&sent);
        let response = response.strip_suffix(PROMPT).unwrap_or(response);
        response.trim_end().replace("\r\n", "\n")
    }

    fn perform(&mut self, request: Request) -> Response<'_> {
        match request {
            Request::Status => {
                return Response::Status(Status {
                    armed: self.latch.is_armed(),
                    mode: self.mode,
                    latched: self.latch.causes(),
                    unit: "cycles",
                    capture: self.capture.stage(),
                    ..Status::default()
                });
            }
            Request::Help(command) => return Response::Help(command),
            Request::Faults => return Response::Faults(Latched::from(&self.latch)),
            Request::ShowAll => return Response::Parameters(&PARAMETERS, &self.values),
            Request::Show(parameter) => {
                return Response::Parameter(&PARAMETERS[parameter], self.values[parameter]);
            }
            _ => {}
        }
        match self.change(request) {
            Ok(()) => Response::Done,
            Err(refusal) => Response::Refused(refusal),
        }
    }

    fn change(&mut self, request: Request) -> Result<(), Refusal> {
        match request {
            Request::Clear => self.latch.clear().map_err(Refusal::NotCleared),
            Request::Arm => self.latch.arm().map_err(Refusal::Latched),
            Request::Disarm => {
                self.latch.disarm();
                Ok(())
            }
            Request::Mode(mode) => {
                self.mode = mode;
                Ok(())
            }
            Request::Signal(signal) => {
                self.signal = Some(signal);
                Ok(())
            }
            Request::Set { parameter, value } => {
                self.values[parameter] = value;
                Ok(())
            }
            Request::Body(loopback::Command::Inject(fault)) => match &mut self.body {
                Some(body) => body.inject(fault).map_err(Refusal::Invalid),
                None => Err(Refusal::Unavailable),
            },
            Request::Body(loopback::Command::Heal) => match &mut self.body {
                Some(body) => {
                    body.heal();
                    Ok(())
                }
                None => Err(Refusal::Unavailable),
            },
            Request::Record(settings) => self.capture.begin(settings).map_err(Refusal::Invalid),
            Request::Dump(Dump::Capture) if self.capture.stage() != Stage::Complete => {
                Err(Refusal::NotRecorded(self.capture.stage()))
            }
            Request::Save if self.latch.is_armed() => Err(Refusal::Armed),
            _ => Ok(()),
        }
    }
}

impl Default for ConsoleOnHost {
    fn default() -> Self {
        Self::new()
    }
}

/// Sends bytes to a console, whatever they are, and looks at each answer.
///
/// # Panics
/// If a line is longer than it may be or no text, if its end has not exactly one response, if something
/// else has one, or if a request could not be meant.
pub fn exercise(bytes: &[u8]) {
    let mut host = ConsoleOnHost::new();
    let mut before = None;
    for &byte in bytes {
        let requests = host.requests.len();
        let sent = host.take(byte);
        let line = host.line();
        assert!(line.len() <= LINE, "{} characters", line.len());
        assert!(line.bytes().all(|byte| (b' '..=b'~').contains(&byte)));
        let follows_return = byte == b'\n' && before == Some(b'\r');
        let ends = (matches!(byte, b'\r' | b'\n') && !follows_return) || byte == 0x03;
        before = Some(byte);
        let prompts = sent.matches(&format!("\n{PROMPT}")).count();
        assert_eq!(prompts, usize::from(ends), "{sent:?}");
        assert_eq!(sent.ends_with(&format!("\n{PROMPT}")), ends, "{sent:?}");
        let bare = sent.replace("\r\n", "");
        assert!(!bare.contains('\n'), "no carriage return: {sent:?}");
        assert!(host.requests.len() <= requests + usize::from(ends));
        if let Some(request) = host.requests.get(requests) {
            assert_sensible(request);
        }
    }
}

fn assert_sensible(request: &Request) {
    match *request {
        Request::Set { parameter, value } => {
            let bounds = &PARAMETERS[parameter];
            assert!((bounds.lower..=bounds.upper).contains(&value));
        }
        Request::Signal(signal) => {
            let generator = signal.build().expect("a signal that was checked");
            for tick in [0, 1, 1000, u32::MAX] {
                assert!(generator.at(tick).is_finite(), "{signal:?}");
            }
        }
        Request::Record(settings) => {
            assert!(settings.rows(CAPTURE_VALUES).is_ok(), "{settings:?}");
        }
        Request::Stream(rate) => assert!((0.0..=MOST_RATE).contains(&rate)),
        _ => {}
    }
}
