//! The board's line, held by one thread: what comes over it is kept for the page, what the page asks is asked.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use firmware::app::console::editor::LINE;
use firmware::app::console::injection::INJECTIONS;
use firmware::app::console::parse::{Line as Parsed, parse};
use firmware::app::console::request::Request;
use firmware::app::operation::live::Live;
use firmware::app::store::field::DESCRIPTIONS;
use firmware::app::timing::STEPS_PER_SECOND;

use super::frozen::{Frozen, Gap};
use super::trigger::Trigger;
use crate::board_link::Line;
use crate::board_link::console::Console;
use crate::board_link::emulated::{EmulatedBoard, WireFault};
use crate::board_link::log_transfer::LogTransfer;
use crate::failure::Failure;
use crate::record::machine;

/// Lines a second that the board is asked for: half of what 115,200 baud carry beside its answers.
const RATE: u32 = 50;

/// How many are kept: a minute.
const KEPT: usize = 60 * RATE as usize;

/// Lines of text that are kept.
const KEPT_TEXT: usize = 500;

/// How long the page may be silent while the drive is armed. It asks ten times a second, or once where the
/// browser shows another page.
const LONGEST_ABSENCE: Duration = Duration::from_secs(3);

/// How often the board is told that somebody is there: it lets go after 60 s without a word.
const PING: Duration = Duration::from_secs(5);

/// How long after Arm lines may still say how the drive was before: a second is far more than any waits in a buffer.
const STALE: Duration = Duration::from_secs(1);

/// Control steps that are recorded behind a trigger.
const BEHIND: u32 = STEPS_PER_SECOND / 2;

/// What is asked of the thread.
#[derive(Debug)]
pub enum Ask {
    /// A line for the console.
    Line(String),
    /// The deliberate permission to move.
    Arm,
    /// Its end.
    Disarm,
    /// The end of latched faults.
    Clear,
    /// A fault, by its name.
    Inject(String),
    /// What freezes the picture from now on.
    Trigger(Trigger),
    /// Freeze it now.
    Freeze,
    /// Go on.
    Thaw,
}

type Answer = Result<String, String>;

/// What the page is shown.
#[derive(Debug)]
pub struct Shown {
    /// How the drive was, each with its number.
    pub lives: VecDeque<(u64, Live)>,
    /// What the board said by itself, each with its number.
    pub said: VecDeque<(u64, String)>,
    next: u64,
    /// When the page last asked.
    pub asked: Instant,
    /// Whether Arm was pressed, and nothing has ended that since.
    pub permitted: bool,
    trigger: Trigger,
    /// Rows that have come of a log, and all of them, while it is read.
    pub freezing: Option<(usize, usize)>,
    /// What was frozen.
    pub frozen: Option<Arc<Frozen>>,
    /// Why the thread ended.
    pub problem: Option<String>,
}

/// A board, with the thread that holds its line.
pub struct Board {
    shown: Arc<Mutex<Shown>>,
    asks: Mutex<Sender<(Ask, Sender<Answer>)>>,
    ending: Arc<AtomicBool>,
    thread: Mutex<Option<JoinHandle<Result<(), Failure>>>>,
    /// How far `gap` is.
    pub gap: Arc<Mutex<Gap>>,
    /// Names of the faults that can be injected.
    pub faults: Vec<&'static str>,
    /// Whether it is emulated.
    pub is_emulated: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Board {
    /// Takes hold of a board: disarmed, and told to say how it is.
    ///
    /// # Errors
    /// A board that does not answer, or that somebody else has armed.
    pub fn start(
        mut line: Box<dyn Line>,
        emulated: Option<EmulatedBoard>,
        directory: PathBuf,
        machine: Option<PathBuf>,
    ) -> Result<Self, Failure> {
        let own_machine = {
            let mut console = Console::new(&mut *line)?;
            if console.ask("status")?.starts_with("armed") {
                return Err(Failure::other(
                    "the drive is armed already: somebody else drives it; `disarm` it on its console first",
                ));
            }
            machine::text(&console.parameters()?)?
        };
        let shown = Arc::new(Mutex::new(Shown {
            lives: VecDeque::new(),
            said: VecDeque::new(),
            next: 1,
            asked: Instant::now(),
            permitted: false,
            trigger: Trigger::Off,
            freezing: None,
            frozen: None,
            problem: None,
        }));
        let ending = Arc::new(AtomicBool::new(false));
        let (asks, asked) = channel();
        let is_emulated = emulated.is_some();
        let keeper = Keeper {
            shown: shown.clone(),
            asked,
            emulated,
            directory,
            machine,
            own_machine,
            before: None,
            due: None,
            transfer: None,
            pinged: Instant::now(),
            armed: Instant::now(),
        };
        let thread = {
            let ending = ending.clone();
            thread::spawn(move || keeper.run(&mut *line, &ending))
        };
        Ok(Self {
            shown,
            asks: Mutex::new(asks),
            ending,
            thread: Mutex::new(Some(thread)),
            gap: Arc::new(Mutex::new(Gap::None)),
            faults: if is_emulated {
                WireFault::ALL.map(WireFault::name).to_vec()
            } else {
                let names = INJECTIONS.iter().map(|injection| injection.name);
                names.chain(["heal"]).collect()
            },
            is_emulated,
        })
    }

    /// What the page is shown.
    pub fn shown(&self) -> MutexGuard<'_, Shown> {
        lock(&self.shown)
    }

    /// Asks, and waits for what is said.
    ///
    /// # Errors
    /// What is refused, and why.
    pub fn ask(&self, ask: Ask) -> Answer {
        let (reply, answer) = channel();
        let gone = || "the board's line has ended".to_owned();
        lock(&self.asks).send((ask, reply)).map_err(|_| gone())?;
        answer.recv().unwrap_or_else(|_| Err(gone()))
    }

    /// Whether its line has ended.
    pub fn has_ended(&self) -> bool {
        let thread = lock(&self.thread);
        thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Disarms it and lets go of its line.
    ///
    /// # Errors
    /// Why its line ended before, or a drive that does not say that it is disarmed.
    pub fn end(&self) -> Result<(), Failure> {
        self.ending.store(true, Relaxed);
        match lock(&self.thread).take().map(JoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(_)) => Err(Failure::other(
                "what held the board's line ended too early: take the power of the bridge",
            )),
            None => Ok(()),
        }
    }
}

/// What the thread has.
struct Keeper {
    shown: Arc<Mutex<Shown>>,
    asked: Receiver<(Ask, Sender<Answer>)>,
    emulated: Option<EmulatedBoard>,
    directory: PathBuf,
    machine: Option<PathBuf>,
    own_machine: String,
    before: Option<Live>,
    /// The control step at which a trigger that came freezes.
    due: Option<u32>,
    transfer: Option<LogTransfer>,
    pinged: Instant,
    /// When Arm was pressed last.
    armed: Instant,
}

impl Keeper {
    fn run(mut self, line: &mut dyn Line, ending: &AtomicBool) -> Result<(), Failure> {
        let mut console = Console::new(line)?;
        let kept = console
            .order(&format!("stream {RATE}"))
            .and_then(|()| self.keep(&mut console, ending));
        let disarmed = console.disarm();
        let quiet = console.quiet();
        let ended = kept.and(disarmed).and(quiet);
        if let Err(failure) = &ended {
            lock(&self.shown).problem = Some(failure.to_string());
        }
        ended
    }

    fn keep(&mut self, console: &mut Console, ending: &AtomicBool) -> Result<(), Failure> {
        while !ending.load(Relaxed) {
            while let Ok((ask, reply)) = self.asked.try_recv() {
                let answer = self.answer(console, ask);
                // A page that has gone does not wait for it.
                let _ = reply.send(answer.map_err(|failure| failure.to_string()));
            }
            for frame in console.poll()? {
                self.take(console, &frame)?;
            }
            for text in console.announced() {
                self.say(text);
            }
            self.watch_page(console)?;
        }
        Ok(())
    }

    fn say(&self, text: String) {
        let mut shown = lock(&self.shown);
        let number = shown.next;
        shown.next += 1;
        shown.said.push_back((number, text));
        if shown.said.len() > KEPT_TEXT {
            shown.said.pop_front();
        }
    }

    fn take(&mut self, console: &mut Console, frame: &str) -> Result<(), Failure> {
        if let Some(live) = Live::read(frame) {
            return self.take_live(console, live);
        }
        let Some(transfer) = &mut self.transfer else {
            return Ok(());
        };
        if let Err(reason) = transfer.take(frame) {
            self.transfer = None;
            lock(&self.shown).freezing = None;
            self.say(format!("not frozen: {reason}"));
            return Ok(());
        }
        lock(&self.shown).freezing = Some(transfer.progress());
        if let Some(log) = transfer.log() {
            self.transfer = None;
            let machine = self.machine.as_deref();
            let frozen = Frozen::write(&log, &self.directory, machine, &self.own_machine);
            let mut shown = lock(&self.shown);
            shown.freezing = None;
            match frozen {
                Ok(frozen) => shown.frozen = Some(Arc::new(frozen)),
                Err(failure) => {
                    drop(shown);
                    self.say(format!("not frozen: {failure}"));
                }
            }
        }
        Ok(())
    }

    fn take_live(&mut self, console: &mut Console, live: Live) -> Result<(), Failure> {
        let trigger = {
            let mut shown = lock(&self.shown);
            let number = shown.next;
            shown.next += 1;
            shown.lives.push_back((number, live));
            if shown.lives.len() > KEPT {
                shown.lives.pop_front();
            }
            // A drive that lets go, by a word of the console or by itself, is armed anew by the button alone.
            let has_let_go = !live.armed && self.armed.elapsed() > STALE;
            shown.permitted &= live.latched.is_empty() && !has_let_go;
            shown.trigger
        };
        let before = self.before.replace(live);
        if self.due.is_none() && before.is_some_and(|before| trigger.comes(&before, &live)) {
            self.due = Some(live.sequence.wrapping_add(BEHIND));
            lock(&self.shown).trigger = Trigger::Off;
        }
        let is_due = |due: u32| live.sequence.wrapping_sub(due) < u32::MAX / 2;
        if self.due.is_some_and(is_due) {
            self.due = None;
            if let Err(reason) = self.freeze(console)? {
                self.say(format!("not frozen: {reason}"));
            }
        }
        Ok(())
    }

    /// Begins to read the board's log.
    fn freeze(&mut self, console: &mut Console) -> Result<Answer, Failure> {
        if self.transfer.is_some() {
            return Ok(Err("the log is being read already".to_owned()));
        }
        let answer = console.ask("dump log console")?;
        if answer != "ok" {
            return Ok(Err(answer));
        }
        self.transfer = Some(LogTransfer::default());
        lock(&self.shown).freezing = Some((0, 0));
        Ok(Ok("reading the board's log".to_owned()))
    }

    fn answer(&mut self, console: &mut Console, ask: Ask) -> Result<String, Failure> {
        let refused = |reason: &str| Err(Failure::other(reason));
        match ask {
            Ask::Disarm => {
                lock(&self.shown).permitted = false;
                console.disarm()?;
                Ok("disarmed".to_owned())
            }
            Ask::Clear => {
                // A fault has taken the bridge, and the drive is still armed: that ends with it.
                if self.before.is_some_and(|live| !live.latched.is_empty()) {
                    lock(&self.shown).permitted = false;
                    console.disarm()?;
                }
                console.ask("clear")
            }
            Ask::Arm => {
                console.order("arm")?;
                self.armed = Instant::now();
                lock(&self.shown).permitted = true;
                Ok("armed".to_owned())
            }
            Ask::Line(line) => {
                if line.len() > LINE || line.chars().any(char::is_control) {
                    return refused("expected one line of a console, of 128 characters at most");
                }
                let permitted = lock(&self.shown).permitted;
                may_be_sent(&line, permitted).map_err(Failure::Other)?;
                console.ask(&line)
            }
            Ask::Inject(name) => match &self.emulated {
                Some(board) => match WireFault::named(&name) {
                    Some(fault) => {
                        board.inject(fault);
                        Ok(format!("at the wires from now on: {name}"))
                    }
                    None => refused("there is no such fault"),
                },
                None if name == "heal" => console.ask("heal"),
                None => {
                    let line = format!("inject {name}");
                    match parse(&line, &DESCRIPTIONS) {
                        Ok(Parsed::Request(Request::Body(_))) => console.ask(&line),
                        Ok(_) => refused("there is no such fault"),
                        Err(error) => refused(&error.to_string()),
                    }
                }
            },
            Ask::Trigger(trigger) => {
                lock(&self.shown).trigger = trigger;
                self.due = None;
                Ok("ok".to_owned())
            }
            Ask::Freeze => self.freeze(console)?.map_err(Failure::Other),
            Ask::Thaw => {
                lock(&self.shown).frozen = None;
                Ok("ok".to_owned())
            }
        }
    }

    /// Takes the drive's power where nobody looks at the page any more, and else tells the board that somebody does.
    fn watch_page(&mut self, console: &mut Console) -> Result<(), Failure> {
        let (absence, permitted) = {
            let shown = lock(&self.shown);
            (shown.asked.elapsed(), shown.permitted)
        };
        if permitted && absence > LONGEST_ABSENCE {
            lock(&self.shown).permitted = false;
            console.disarm()?;
            self.say("disarmed: the page was closed, or its browser stands still".to_owned());
        } else if permitted && self.pinged.elapsed() > PING {
            self.pinged = Instant::now();
            console.order("ping")?;
        }
        Ok(())
    }
}

/// Whether a line may go to the console.
fn may_be_sent(line: &str, permitted: bool) -> Result<(), String> {
    match parse(line, &DESCRIPTIONS) {
        Ok(Parsed::Request(Request::Arm)) => {
            Err("the drive is armed by the button Arm alone".to_owned())
        }
        Ok(Parsed::Request(Request::Signal(_) | Request::Hold)) if !permitted => {
            Err("nothing moves before Arm was pressed".to_owned())
        }
        Ok(Parsed::Request(Request::Dump(_) | Request::Stream(_))) => {
            Err("this page sends that by itself; press Freeze for the log".to_owned())
        }
        Ok(_) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_moves_needs_the_button() {
        for line in ["step 0 1", "sine 0 0.1 1", "hold"] {
            assert!(may_be_sent(line, false).is_err(), "{line}");
            assert_eq!(may_be_sent(line, true), Ok(()), "{line}");
        }
        for line in ["arm", "  arm ", "dump log console", "stream 10", "nonsense"] {
            assert!(may_be_sent(line, false).is_err(), "{line}");
            assert!(may_be_sent(line, true).is_err(), "{line}");
        }
        for line in [
            "disarm",
            "stop",
            "status",
            "set coulomb 0.1",
            "mode voltage",
        ] {
            assert_eq!(may_be_sent(line, false), Ok(()), "{line}");
        }
    }
}
