//! An image that runs on a chip of its own, in a thread of its own, and stops at each instant that it is
//! asked to reach: there its pins are read and driven.

use std::collections::BTreeMap;
use std::io::{Read, Write, stdout};
use std::net::{TcpListener, TcpStream};
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle};

use rigless::chip::uart::Rate;
use rigless::device::Level;
use rigless::emulator::{
    self, AccessKind, Driver, Host, InterruptLine, Memory, Settled, Start, Stop,
};
use rigless::image::Image;
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;

use crate::board::Board;
use crate::chip::description::{CORE_COUPLED_BASE, FLASH_BASE, SRAM_BASE};
use crate::chip::pins::{self, Pin};
use crate::probe::Probe;
use crate::random::Random;

/// Where parameters are stored: the second to the fourth sector. See `memory.x`.
const PARAMETERS: u64 = FLASH_BASE + 0x4000;
const PARAMETERS_SIZE: usize = 3 * 16 * 1024;

/// What is to happen on the way to the next stop.
#[derive(Debug, Default)]
pub struct Inputs {
    /// Levels that pins are driven to, each at its instant, ns, in their order.
    pub levels: Vec<(u64, Pin, Level)>,
    /// Voltages at ADC1's channels from the beginning on, mV.
    pub analogue: Vec<(u8, u32)>,
    /// What the terminal types from the beginning on.
    pub typed: Vec<u8>,
    /// What is typed at a debug probe at the beginning; it hears then what the console has said, if there is one.
    pub probed: Option<Vec<u8>>,
    /// What befalls the chip at the beginning.
    pub events: Vec<Event>,
}

/// What may befall a chip.
#[derive(Debug)]
pub enum Event {
    /// TIM7 stands still, or goes on.
    StopTick(bool),
    /// No trigger starts the converter, or each does again.
    StopConverter(bool),
    /// The crystal stands still, or swings again when it is started.
    StopCrystal(bool),
    /// An interrupt's line is high whatever its source says, or is its source's again.
    StickInterrupt(u16, bool),
    /// An interrupt's vector is another one: a fault that has the program run what it should not.
    Vector(u16, Vector),
    /// From now on what the flash holds where parameters are is kept behind each of its operations.
    KeepFlash,
    /// The processor's own supply has this voltage, mV.
    Supply(u32),
    /// So many words in a million reach USART1 with a framing error, as many with noise, and some of their bits flipped.
    LineErrors(u32),
    /// The supply is lost. Nothing runs before it is back.
    PowerOff,
    /// It is back, the flash holds this where parameters are, and the RAM anything.
    PowerOn(Vec<u8>),
}

/// Where a vector leads.
#[derive(Debug, Clone, Copy)]
pub enum Vector {
    /// Where the image has it.
    Own,
    /// To the handler of an exception, by its number: 2 is the NMI, 16 the first interrupt.
    Of(u16),
    /// To these instructions, in a sector that the image does not use.
    To(u32),
}

/// Number of the first interrupt's vector.
pub const FIRST_INTERRUPT: u16 = 16;

/// The exception that cannot be masked.
const NMI: u16 = 2;

/// Where foreign instructions are put: the last sector.
const FOREIGN: u64 = FLASH_BASE + 0xe_0000;

/// The controller's most urgent interrupt: RM0090, table 61.
pub const ADC: u16 = 18;

/// What is on a chip's wires at a stop, and what was counted since the start.
#[derive(Debug, Clone, Default)]
pub struct Outputs {
    /// What the terminal was told since the stop before.
    pub said: Vec<u8>,
    /// What a debug probe was told at the stop before.
    pub probed: Vec<u8>,
    /// Share of the supply at the winding, −1 to 1, if the bridge's timer drives.
    pub bridge: Option<f64>,
    /// Level of the bridge's enable.
    pub bridge_enable: bool,
    /// Level of the brake's release.
    pub brake_release: bool,
    /// Codes of the two position tracks, 0 to 4095.
    pub tracks: [u16; 2],
    /// Share of the current output, 0 to 1.
    pub current: f64,
    /// `DBGMCU_APB1_FZ` and `DBGMCU_APB2_FZ`.
    pub debug_freeze: [u64; 2],
    /// What the flash held where parameters are behind each operation since the stop before, if that is kept.
    pub flash: Vec<Vec<u8>>,
    /// What was counted.
    pub counts: Counts,
}

/// What was counted since a run's start.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    /// Instructions.
    pub instructions: u64,
    /// Ticks of TIM7 and those that the program missed.
    pub timer_ticks: [u64; 2],
    /// Conversions that TIM1 triggered and those that the program missed.
    pub conversions: [u64; 2],
    /// Longest time from a plant tick to its acknowledgement, ns.
    pub longest_latency: u64,
    /// Writes of the position tracks.
    pub track_writes: u64,
    /// Sectors erased, words programmed, and stores that tried to set a bit.
    pub flash: [u64; 3],
    /// Resets.
    pub resets: usize,
    /// What `FLASH_ACR` reads.
    pub flash_access_control: u64,
    /// What `FLASH_OPTCR` reads.
    pub flash_options: u64,
    /// Erases since the data cache was last emptied.
    pub unforgotten_erases: u64,
}

impl Outputs {
    /// Share of the supply at the winding, −1 to 1, if the bridge drives: its timer does, and it is enabled.
    pub fn driven(&self) -> Option<f64> {
        self.bridge.filter(|_| self.bridge_enable)
    }

    /// Whether nothing moves the motor and everything holds it: the timer and the enable have let go of the bridge, and
    /// the brake is on.
    pub fn lets_go(&self) -> bool {
        self.bridge.is_none() && !self.bridge_enable && !self.brake_release
    }
}

enum Request {
    Reach(u64, Inputs),
    Stack,
    /// The end of power: what the flash holds where parameters are.
    End,
}

enum Reply {
    Reached(Outputs),
    Stack([u64; 2]),
    Ended(Vec<u8>),
}

/// A running image. Dropped, it ends.
pub struct Running {
    requests: Sender<Request>,
    replies: Receiver<Reply>,
    thread: Option<JoinHandle<Result<(), String>>>,
    log: Option<JoinHandle<Vec<u8>>>,
    /// What is to happen in the next step.
    pub next: Inputs,
    /// What was there at the last stop.
    pub outputs: Outputs,
    /// Everything that the terminal was told, byte for byte.
    pub heard: Vec<u8>,
    /// Everything that a debug probe was told.
    pub probed: Vec<u8>,
    /// What the flash held where parameters are behind each of its operations, if that is kept.
    pub kept: Vec<Vec<u8>>,
    now: u64,
}

/// What an image is started with.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The image, as it is flashed.
    pub elf: PathBuf,
    /// Instructions that a core retires in a second.
    pub instructions_per_second: NonZeroU64,
    /// What is stored in the parameters' sectors; none: erased.
    pub parameters: Option<Vec<u8>>,
}

impl Running {
    /// Starts it from power on; nothing runs before the first step.
    ///
    /// # Errors
    /// An image that is none, or a machine that cannot be made.
    pub fn start(setting: &Setting) -> Result<Self, String> {
        let stored = setting
            .parameters
            .as_deref()
            .map(|bytes| (PARAMETERS, bytes));
        Self::start_with(setting, stored, false)
    }

    /// As [`Running::start`], with bytes somewhere in the flash; what it logs goes to the standard output too,
    /// if that is asked for, as it comes.
    ///
    /// # Errors
    /// As [`Running::start`].
    pub fn start_with(
        setting: &Setting,
        stored: Option<(u64, &[u8])>,
        echo: bool,
    ) -> Result<Self, String> {
        let mut images = vec![Image::read(&setting.elf, None).map_err(|error| error.to_string())?];
        if let Some((address, bytes)) = stored {
            let stored = Image::new(Path::new("stored.bin"), bytes.to_vec(), Some(address));
            images.push(stored.map_err(|error| error.to_string())?);
        }
        let board = Board::new(setting.instructions_per_second).map_err(|e| e.to_string())?;
        let listener = TcpListener::bind("127.0.0.1:0").map_err(|error| error.to_string())?;
        let address = listener.local_addr().map_err(|error| error.to_string())?;
        // Before anything runs, so that the log is whole.
        let mut stream = TcpStream::connect(address).map_err(|error| error.to_string())?;
        let log = thread::spawn(move || {
            let mut log = Vec::new();
            let mut bytes = [0; 4096];
            // What came before an error is as good a log as there is.
            while let Ok(read @ 1..) = stream.read(&mut bytes) {
                log.extend(&bytes[..read]);
                if echo {
                    let mut out = stdout();
                    // Whoever closed it does not want to know.
                    let _ = out.write_all(&bytes[..read]).and_then(|()| out.flush());
                }
            }
            log
        });
        let (requests, asked) = channel();
        let (answers, replies) = channel();
        let thread = thread::spawn(move || {
            let session = Session::new(Box::new(board), 0, VirtualNanos(1))
                .map_err(|error| error.to_string())?;
            let mut start = Start::new(&images);
            start.rtt = Some(&listener);
            let stepping = Stepping {
                asked,
                answers,
                until: 1,
                pending: Vec::new(),
                is_held: false,
                kept: None,
                operations: 0,
                vectors: BTreeMap::new(),
                resets: 0,
                stuck: None,
                probe: Probe::default(),
                probed: Vec::new(),
            };
            emulator::run(session, &start, stepping).map_err(|error| error.to_string())?;
            Ok(())
        });
        Ok(Self {
            requests,
            replies,
            thread: Some(thread),
            log: Some(log),
            next: Inputs::default(),
            outputs: Outputs::default(),
            heard: Vec::new(),
            probed: Vec::new(),
            kept: Vec::new(),
            now: 0,
        })
    }

    /// Virtual time since the start, ns.
    pub fn now(&self) -> u64 {
        self.now
    }

    /// Lets it run to an instant, ns; [`Running::finish_step`] waits for it.
    ///
    /// # Errors
    /// The emulation has ended.
    pub fn begin_step(&mut self, until: u64) -> Result<(), String> {
        self.now = until;
        let inputs = std::mem::take(&mut self.next);
        self.requests
            .send(Request::Reach(until, inputs))
            .map_err(|_| self.failure())
    }

    /// Waits for the end of a step.
    ///
    /// # Errors
    /// The emulation has ended.
    pub fn finish_step(&mut self) -> Result<(), String> {
        match self.replies.recv() {
            Ok(Reply::Reached(mut outputs)) => {
                self.heard.extend(&outputs.said);
                self.probed.extend(&outputs.probed);
                self.kept.append(&mut outputs.flash);
                self.outputs = outputs;
                Ok(())
            }
            _ => Err(self.failure()),
        }
    }

    /// Bytes of the stack that were used since the start, and those that there are. Power that was lost in between
    /// fills the RAM with anything: then it is all of them.
    ///
    /// # Errors
    /// The emulation has ended.
    pub fn stack(&mut self) -> Result<[u64; 2], String> {
        if self.requests.send(Request::Stack).is_err() {
            return Err(self.failure());
        }
        match self.replies.recv() {
            Ok(Reply::Stack(stack)) => Ok(stack),
            _ => Err(self.failure()),
        }
    }

    /// Lets it run for a time, ns.
    ///
    /// # Errors
    /// The emulation has ended.
    pub fn run_for(&mut self, time: u64) -> Result<(), String> {
        self.begin_step(self.now + time)?;
        self.finish_step()
    }

    /// What the terminal was told from a byte on, its lines ended by line feeds alone.
    pub fn transcript(&self, from: usize) -> String {
        let said = self.heard.get(from..).unwrap_or_default();
        String::from_utf8_lossy(said).replace('\r', "")
    }

    /// Types a line.
    pub fn type_line(&mut self, line: &str) {
        self.next.typed.extend(line.bytes());
        self.next.typed.push(b'\r');
    }

    /// Cuts the power. What the flash holds where parameters are, and the log.
    ///
    /// # Errors
    /// The emulation had ended before.
    pub fn cut_power(mut self) -> Result<(Vec<u8>, Vec<u8>), String> {
        if self.requests.send(Request::End).is_err() {
            return Err(self.failure());
        }
        let Ok(Reply::Ended(parameters)) = self.replies.recv() else {
            return Err(self.failure());
        };
        if let Some(thread) = self.thread.take() {
            thread.join().map_err(|_| "the emulation panicked")??;
        }
        let log = self.log.take().map(JoinHandle::join);
        Ok((parameters, log.and_then(Result::ok).unwrap_or_default()))
    }

    /// Why the emulation has ended by itself.
    fn failure(&mut self) -> String {
        let reason = match self.thread.take().map(JoinHandle::join) {
            Some(Ok(Err(reason))) => reason,
            Some(Err(_)) => "it panicked".to_owned(),
            _ => "it ended by itself".to_owned(),
        };
        format!("emulation: {reason}")
    }
}

/// The emulator's side of a running image.
struct Stepping {
    asked: Receiver<Request>,
    answers: Sender<Reply>,
    until: u64,
    /// Levels to come before that, the last one first.
    pending: Vec<(u64, Pin, Level)>,
    is_held: bool,
    /// Parameters behind each operation of the flash, if they are kept.
    kept: Option<Vec<Vec<u8>>>,
    operations: u64,
    /// Vectors that were changed, as the image has them.
    vectors: BTreeMap<u16, u32>,
    /// Resets when it was last looked.
    resets: usize,
    /// An interrupt's line that is high.
    stuck: Option<InterruptLine>,
    /// The probe, and what it was told since the stop before.
    probe: Probe,
    probed: Vec<u8>,
}

impl Stepping {
    fn drive_due(&mut self, board: &mut Board, at: VirtualNanos) {
        while let Some(&(instant, pin, level)) = self.pending.last()
            && instant <= at.0
        {
            self.pending.pop();
            board.chip.drive(at, pin, level);
        }
    }

    fn take(
        &mut self,
        (board, host): (&mut Board, &mut dyn Host),
        at: VirtualNanos,
        until: u64,
        inputs: Inputs,
    ) {
        self.until = until;
        self.pending = inputs.levels;
        self.pending.reverse();
        for (channel, millivolts) in inputs.analogue {
            board.chip.set_analogue(channel, millivolts);
        }
        board.terminal().typed.extend(inputs.typed);
        if let Some(typed) = inputs.probed {
            self.probed = self.probe.exchange(host, &typed);
        }
        for event in inputs.events {
            self.befall((board, host), at, event);
        }
        self.drive_due(board, at);
    }

    /// Has a vector lead elsewhere, or where it did at first.
    fn lead(&mut self, host: &mut dyn Host, number: u16, vector: Vector) {
        let word = |host: &mut dyn Host, number: u16| {
            // The vectors are there: the core started by them.
            let address = FLASH_BASE + 4 * u64::from(number);
            host.read(address, Width::W32).unwrap_or(0) as u32
        };
        let present = word(host, number);
        let own = *self.vectors.entry(number).or_insert(present);
        let leads_to = match vector {
            Vector::Own => own,
            Vector::Of(other) => word(host, other),
            Vector::To(instructions) => {
                program(host, FOREIGN, &instructions.to_le_bytes());
                // The lowest bit says that it is Thumb code.
                FOREIGN as u32 | 1
            }
        };
        let address = FLASH_BASE + 4 * u64::from(number);
        program(host, address, &leads_to.to_le_bytes());
    }

    fn befall(
        &mut self,
        (board, host): (&mut Board, &mut dyn Host),
        at: VirtualNanos,
        event: Event,
    ) {
        match event {
            Event::StopTick(stopped) => board.chip.tim7.is_stopped = stopped,
            Event::StopConverter(stopped) => board.chip.adc1.is_stopped = stopped,
            Event::StopCrystal(stopped) => {
                board.chip.stop_crystal(at, stopped);
                // rigless cannot raise the exception, so the most urgent interrupt leads to its handler.
                if stopped && board.chip.asks_for_nmi() {
                    self.lead(host, FIRST_INTERRUPT + ADC, Vector::Of(NMI));
                    set_interrupt(host, ADC, Level::High);
                }
            }
            Event::StickInterrupt(line, stuck) => {
                self.stuck = InterruptLine::new(line).filter(|_| stuck);
                // Let go, it has the level of its source. USART1's is let go behind a reset, when that is low.
                let level = match line {
                    _ if stuck => Level::High,
                    ADC => board.chip.converter_interrupt(),
                    _ => Level::Low,
                };
                set_interrupt(host, line, level);
            }
            Event::Vector(line, vector) => self.lead(host, FIRST_INTERRUPT + line, vector),
            Event::KeepFlash => {
                self.kept = Some(Vec::new());
                self.operations = board.chip.flash.operations();
            }
            Event::Supply(millivolts) => board.chip.set_supply(millivolts),
            Event::LineErrors(per_million) => {
                let errors = board.chip.part.usart[0].errors_mut();
                errors.framing = Rate {
                    name: "framing",
                    per_million,
                };
                errors.noise = Rate {
                    name: "noise",
                    per_million,
                };
            }
            Event::PowerOff => board.chip.supply(at, false),
            Event::PowerOn(parameters) => {
                program(host, PARAMETERS, &parameters);
                scramble(host);
                board.chip.supply(at, true);
            }
        }
    }

    /// The next instant to stop at.
    fn next(&self, at: VirtualNanos) -> VirtualNanos {
        let event = self.pending.last().map(|&(instant, ..)| instant);
        VirtualNanos(event.unwrap_or(self.until).min(self.until).max(at.0))
    }
}

fn outputs(session: &mut Session<Board>, stop: &Stop) -> Outputs {
    let resets = session.resets().len();
    let board = session.board_mut();
    let said = std::mem::take(&mut board.terminal().said);
    let chip = &mut board.chip;
    let counts = Counts {
        instructions: stop.instruction_count,
        timer_ticks: [chip.tim7.updates, chip.tim7.missed],
        conversions: [chip.adc1.conversions, chip.adc1.missed],
        longest_latency: chip.tim7.longest_latency.max(chip.adc1.longest_latency),
        track_writes: chip.dac.writes,
        flash: [chip.flash.erases, chip.flash.words, chip.flash.set_bits],
        resets,
        flash_access_control: chip.flash_access_control(),
        flash_options: chip.flash_options().0,
        unforgotten_erases: chip.flash.unforgotten,
    };
    Outputs {
        said,
        probed: Vec::new(),
        bridge: chip.bridge(),
        bridge_enable: chip.level(pins::BRIDGE_ENABLE) == Level::High,
        brake_release: chip.level(pins::BRAKE_RELEASE) == Level::High,
        tracks: chip.tracks(),
        current: chip.current_output(),
        debug_freeze: chip.debug_freeze(),
        flash: Vec::new(),
        counts,
    }
}

fn set_interrupt(host: &mut dyn Host, line: u16, level: Level) {
    if let Some(line) = InterruptLine::new(line) {
        host.set_interrupt(line, level);
    }
}

/// Puts bytes into the flash, as a probe does, a word at a time.
fn program(host: &mut dyn Host, base: u64, bytes: &[u8]) {
    for (address, bytes) in (base..).step_by(4).zip(bytes.chunks_exact(4)) {
        let word = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        // The region is there: it is the chip's own flash.
        let _ = host.program(address, Width::W32, word.into());
    }
}

/// Both RAMs, as power finds them: anything.
fn scramble(host: &mut dyn Host) {
    let mut random = Random(0x9e37_79b9);
    for (base, size) in [(SRAM_BASE, 128 << 10), (CORE_COUPLED_BASE, 64 << 10)] {
        for address in (base..base + size).step_by(4) {
            // The regions are there: they are the chip's own RAM.
            let _ = host.write(address, Width::W32, random.bits().into());
        }
    }
}

/// Bytes of the stack that were used, and those that there are. It lies at the bottom of the RAM, ends there, and
/// begins where the first vector says; the RAM of a run begins as zeros.
fn stack(memory: &mut (impl Memory + ?Sized)) -> [u64; 2] {
    let mut word = |address| memory.read(address, Width::W32).unwrap_or(0);
    let top = word(FLASH_BASE);
    let deepest = (SRAM_BASE..top)
        .step_by(4)
        .find(|address| word(*address) != 0);
    [top - deepest.unwrap_or(top), top.saturating_sub(SRAM_BASE)]
}

fn parameters(memory: &mut (impl Memory + ?Sized)) -> Vec<u8> {
    let addresses = (PARAMETERS..).take(PARAMETERS_SIZE);
    addresses
        .map(|address| {
            // The region is there: it is the chip's own flash.
            memory.read(address, Width::W8).unwrap_or(0xff) as u8
        })
        .collect()
}

impl Driver<Board> for Stepping {
    /// The core waits while the one bank of flash is erased or programmed: RM0090, section 3.6.
    fn on_settled(&mut self, session: &mut Session<Board>, host: &mut dyn Host, settled: Settled) {
        if let Settled::Access { access, .. } = settled {
            let at = access.virtual_time;
            if access.kind == AccessKind::Write {
                session.board_mut().chip.hold_crystal(at);
            }
            if session.resets().len() != self.resets {
                self.resets = session.resets().len();
                session.board_mut().chip.drive_again(at);
            }
        }
        if let Some(line) = self.stuck {
            host.set_interrupt(line, Level::High);
        }
        let operations = session.board().chip.flash.operations();
        if let Some(kept) = &mut self.kept
            && operations != self.operations
            && !session.board().chip.is_stalled()
        {
            self.operations = operations;
            kept.push(parameters(host));
        }
        let may_begin =
            matches!(settled, Settled::Access { access, .. } if access.kind == AccessKind::Write);
        if (may_begin || self.is_held) && session.board().chip.is_stalled() != self.is_held {
            self.is_held = !self.is_held;
            host.hold(self.is_held);
        }
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Board>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        let at = stop.at;
        self.drive_due(session.board_mut(), at);
        while at.0 >= self.until {
            let mut reached = outputs(session, &stop);
            reached.probed = std::mem::take(&mut self.probed);
            if let Some(kept) = &mut self.kept {
                reached.flash = std::mem::take(kept);
            }
            // The first stop is nobody's.
            if self.until > 1 && self.answers.send(Reply::Reached(reached)).is_err() {
                return None;
            }
            let mut asked = self.asked.recv();
            while let Ok(Request::Stack) = asked {
                // Whoever asked waits.
                let _ = self.answers.send(Reply::Stack(stack(host)));
                asked = self.asked.recv();
            }
            match asked {
                Ok(Request::Reach(until, inputs)) => {
                    self.take((session.board_mut(), host), at, until, inputs);
                }
                Ok(Request::End) => {
                    // Whoever asked waits.
                    let _ = self.answers.send(Reply::Ended(parameters(host)));
                    return None;
                }
                Ok(Request::Stack) | Err(_) => return None,
            }
        }
        Some(self.next(at))
    }
}
