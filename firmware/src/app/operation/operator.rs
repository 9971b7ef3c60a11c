//! What the console is told, done.
//!
//! The operator owns everything that is not an interrupt's: the parameters and their store, the drive's
//! switch, the capture and the log. [`Operator::poll`] is called every few milliseconds,
//! [`Operator::take`] for each byte from the terminal; a [`Job`] that it gives away comes back done.
//!
//! # Parameters
//! Those of an emulated body are changed only disarmed, as another body takes its place, and so are the
//! position's unit and its limits; all others at any time. What a refit proposes waits for `save`, which takes it over if the cost went down and
//! the values are within their bounds, and stores all in one step; a `set` of the same parameter
//! withdraws the proposal.

use core::fmt::{self, Write};

use embedded_storage_async::nor_flash::NorFlash;
use heapless::spsc::{Consumer, Producer, Queue};
use model_core::plant::throttle::Throttle;

use super::drive::{self, Drive};
use super::evaluation::{Answer, Done, Job, Question};
use super::homing::Sought;
use super::kit::Kit;
use super::live::Live;
use super::motion_limit::NO_POSITION;
use super::order::{self, Receiver, Sender};
use super::setup::Refused;
use super::temperature::Told;
use super::transfer::Transfer;
use crate::app::arming::{Armed, Disarmed};
use crate::app::capture::{Capture, QUANTITIES, Stage};
use crate::app::console::frame::{self, FRAME};
use crate::app::console::request::{Destination, Dump, Home, Mode, Request};
use crate::app::console::response::{Latched, Refusal, Response, Status};
use crate::app::console::{self, Console};
use crate::app::ecu::loopback;
use crate::app::fault::latch::Latch;
use crate::app::fault::observer::Tolerances;
use crate::app::fault::{Fault, Faults};
use crate::app::liveness::Task;
use crate::app::machine::Machine;
use crate::app::memory::Memory;
use crate::app::profile::Signal;
use crate::app::record::{Progress, Recorder, Sample};
use crate::app::store::candidate::{Candidate, Rejected};
use crate::app::store::field::{DESCRIPTIONS, Field, Values};
use crate::app::store::{Loaded, Store};
use crate::app::timing::{CONTROL_PERIOD, CONTROL_PERIOD_US, QUEUED_SAMPLES};
use crate::app::wiring::Wiring;

/// How often the operator is polled, ms: the queue holds six times as many samples.
pub const POLL_PERIOD_MS: u32 = 5;

/// Rows of a capture that are sent in a poll: as many as are recorded in the same time.
pub(super) const ROWS: usize = (POLL_PERIOD_MS * 1000 / CONTROL_PERIOD_US) as usize;

/// Orders to the plant that other values take: another body, and its outputs.
const PLANT_ORDERS: usize = 2;

/// What the operator asks of a board.
pub trait Station {
    /// What durations are counted in, in the plural: "cycles".
    const UNIT: &'static str;

    /// Worst durations of the plant's and the control interrupt.
    fn worst(&self) -> [u32; 2];

    /// Begins or ends a time in which the processor stands still while flash is written: the watchdog
    /// has to bear it.
    fn stall(&mut self, stalled: bool);

    /// A clock, in plant ticks from any beginning, that goes on while the processor stands still.
    fn clock(&self) -> u32;

    /// Sends what comes before a capture's rows.
    fn send_head(&mut self, capture: &Capture);

    /// Sends what comes before the rows of a log that has so many.
    fn send_log_head(&mut self, rows: usize);

    /// Bytes that the console takes now beside the longest answer.
    fn room(&self) -> usize;

    /// Sends a row of a capture or a log, in the order of [`Quantity`](crate::app::capture::Quantity).
    fn send_row(&mut self, number: u32, values: &[f32; QUANTITIES]);
}

/// What an image keeps in statics beside its [`Memory`].
pub struct Cells {
    samples: Queue<Sample, QUEUED_SAMPLES>,
    progress: Progress,
    drive_orders: Queue<drive::Order, { drive::ORDERS }>,
    plant_orders: Queue<order::Order, { order::ORDERS }>,
    replaced: Queue<&'static mut Throttle, 2>,
    capture: Capture,
}

impl Cells {
    /// Nothing in there.
    pub const fn new() -> Self {
        Self {
            samples: Queue::new(),
            progress: Progress::new(),
            drive_orders: Queue::new(),
            plant_orders: Queue::new(),
            replaced: Queue::new(),
            capture: Capture::new(),
        }
    }
}

impl Default for Cells {
    fn default() -> Self {
        Self::new()
    }
}

/// Where orders are typed. Both are taken alike, and everything is told to both; but each has a line of its own, so that what one
/// types never ends up within a line of the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Keyboard {
    /// The terminal at the serial line.
    Terminal,
    /// A debug probe.
    Probe,
}

/// A console for each keyboard.
struct Consoles {
    terminal: Console<'static>,
    probe: Console<'static>,
    /// The one that typed last.
    latest: Keyboard,
}

impl Consoles {
    const fn new() -> Self {
        Self {
            terminal: Console::new(&DESCRIPTIONS),
            probe: Console::new(&DESCRIPTIONS),
            latest: Keyboard::Terminal,
        }
    }

    /// Says something of itself, and shows the line anew that is being typed.
    fn announce(&self, text: fmt::Arguments<'_>, out: &mut dyn Write) {
        let console = match self.latest {
            Keyboard::Terminal => &self.terminal,
            Keyboard::Probe => &self.probe,
        };
        console.announce(text, out);
    }

    fn take(&mut self, keyboard: Keyboard, byte: u8, out: &mut dyn Write) -> Option<Request> {
        self.latest = keyboard;
        let console = match keyboard {
            Keyboard::Terminal => &mut self.terminal,
            Keyboard::Probe => &mut self.probe,
        };
        console.take(byte, out)
    }
}

/// The drive's switch, as a type on either side.
enum Power {
    Disarmed(Disarmed<&'static Latch>),
    Armed(Armed<&'static Latch>),
}

/// The operator.
pub struct Operator<F, S> {
    kit: &'static Kit,
    wiring: &'static Wiring,
    station: S,
    consoles: Consoles,
    store: Store<F>,
    values: Values,
    /// The actuator with them.
    machine: Machine,
    proposal: Option<Candidate>,
    /// None only while it is being switched.
    power: Option<Power>,
    mode: Mode,
    orders: Producer<'static, drive::Order>,
    plant: Sender,
    spare: Option<&'static mut Throttle>,
    samples: Consumer<'static, Sample>,
    progress: &'static Progress,
    dropped: u32,
    capture: &'static mut Capture,
    /// None while a job has it.
    memory: Option<&'static mut Memory>,
    job: Option<Job>,
    /// What is being sent.
    sending: Option<Transfer>,
    /// Polls from one line on how the drive is to the next, and those until then; 0: none is sent.
    stream: [u32; 2],
    /// The sample that came last.
    latest: Option<Sample>,
    /// What was announced of the latch.
    announced: Faults,
    /// Whether the position is known since the start, and no fault of the encoder came since.
    referenced: bool,
    /// A limit switch that is sought, or will be once the drive is armed.
    home: Option<Home>,
    /// The one that was found last, as long as the position counts from it.
    found: Option<Home>,
    /// Whether the drive was last told of no limits of the position, for a search.
    unlimited: bool,
    /// Whether it was last told where the end stops are.
    trusted: bool,
}

/// What is joined to an operator, once and for all.
pub struct Joints<F, S> {
    /// The image.
    pub kit: &'static Kit,
    /// Its wires.
    pub wiring: &'static Wiring,
    /// Its board.
    pub station: S,
    /// Its parameters' place in flash.
    pub store: Store<F>,
    /// Where its log is kept.
    pub memory: &'static mut Memory,
    /// Its other statics.
    pub cells: &'static mut Cells,
    /// For an emulated body: another one, to take the place of the first.
    pub spare: Option<&'static mut Throttle>,
}

/// The values to run with: those that were stored, or the image's own, with [`Fault::StoreCorrupt`]
/// latched if the store is not as it should be.
pub async fn load<F: NorFlash>(
    kit: &Kit,
    store: &mut Store<F>,
    wiring: &Wiring,
) -> Result<(Values, Loaded), Refused> {
    let own = Values::of(&kit.machine)?;
    let loaded = store.load(&own).await;
    let usable = kit.drive(&loaded.values, false).is_ok();
    if loaded.problem.is_some() || !loaded.refused.is_empty() || !usable {
        wiring.trip(Fault::StoreCorrupt);
    }
    let values = if usable { loaded.values } else { own };
    Ok((values, loaded))
}

impl<F: NorFlash, S: Station> Operator<F, S> {
    /// Joins everything, disarmed: the operator, the work of the control interrupt, and the ends of
    /// the plant interrupt.
    ///
    /// # Errors
    /// Values that do not go together; those of [`load`] do.
    pub fn new(joints: Joints<F, S>, values: &Values) -> Result<(Self, Drive, Receiver), Refused> {
        let Joints {
            kit,
            wiring,
            station,
            store,
            memory,
            cells,
            spare,
        } = joints;
        let Cells {
            samples,
            progress,
            drive_orders,
            plant_orders,
            replaced,
            capture,
        } = cells;
        let progress: &'static Progress = progress;
        let (producer, samples) = samples.split();
        let (orders, drive_orders) = drive_orders.split();
        let (plant_sender, plant_receiver) = plant_orders.split();
        let (replaced_sender, replaced_receiver) = replaced.split();
        let mode = kit.modes.first().copied().unwrap_or_default();
        let setup = kit.drive(values, false)?;
        let recorder = Recorder::new(producer, progress);
        let drive = Drive::new(setup, mode, drive_orders, wiring, recorder);
        let receiver = Receiver {
            orders: plant_receiver,
            replaced: replaced_sender,
        };
        let operator = Self {
            kit,
            wiring,
            station,
            consoles: Consoles::new(),
            store,
            values: *values,
            machine: kit.machine_with(values),
            proposal: None,
            power: Some(Power::Disarmed(Disarmed::new(wiring.latch()))),
            mode,
            orders,
            plant: Sender {
                orders: plant_sender,
                replaced: replaced_receiver,
            },
            spare,
            samples,
            progress,
            dropped: 0,
            capture,
            memory: Some(memory),
            job: None,
            sending: None,
            stream: [0; 2],
            latest: None,
            announced: Faults::NONE,
            referenced: false,
            home: None,
            found: None,
            unlimited: false,
            trusted: false,
        };
        Ok((operator, drive, receiver))
    }

    /// Says what it is, and how it found the store.
    pub fn greet(&self, loaded: &Loaded, out: &mut dyn Write) {
        let parameters = Greeting {
            kit: self.kit,
            loaded,
        };
        self.consoles.announce(format_args!("{parameters}"), out);
        self.consoles.terminal.greet(out);
    }

    /// Empties the sample queue, tells what was latched, and sends what is to be sent.
    pub fn poll(&mut self, out: &mut dyn Write) {
        self.wiring.goes_on(Task::Operator);
        let converters = self.machine.converters;
        while let Some(sample) = self.samples.dequeue() {
            self.capture.push(&sample, &converters);
            if sample.marks.driven
                && !self.sends_log()
                && let Some(memory) = &mut self.memory
            {
                memory.push(&sample);
            }
            self.latest = Some(sample);
        }
        let dropped = self.progress.dropped();
        if dropped != self.dropped {
            self.dropped = dropped;
            self.wiring.trip(Fault::QueueOverflow);
        }
        if let Some(throttle) = self.plant.replaced.dequeue() {
            self.spare = Some(throttle);
        }
        self.heed_faults(out);
        self.end_search(out);
        self.tell(out);
        self.send(out);
    }

    /// Tells what was latched since it was last told, and takes the position for unknown behind a fault of the encoder.
    fn heed_faults(&mut self, out: &mut dyn Write) {
        let latched = self.wiring.latch().causes();
        if latched == self.announced {
            return;
        }
        self.announced = latched;
        // What the encoder did not count is missing for good.
        if latched.are_of_the_encoder() {
            self.referenced = false;
            self.found = None;
        }
        if !latched.is_empty() {
            let text = format_args!("fault: {latched}; the bridge is off; see `faults`");
            self.consoles.announce(text, out);
        }
    }

    /// Takes the power once a switch is found, or is not, and with what was found makes the position known.
    fn end_search(&mut self, out: &mut dyn Write) {
        let Some(edge) = self.wiring.take_search() else {
            return;
        };
        let Some(home) = self.home else {
            return;
        };
        self.disarm();
        let switch = home.switch.name();
        match edge {
            Some(edge) => {
                let read = self.machine.converters.position.value(edge);
                let other = self.found.filter(|other| other.switch != home.switch);
                if let Some(other) = other
                    && !self.is_scaled(&other, &home, read)
                {
                    self.found = None;
                    self.wiring.trip(Fault::EncoderImplausible);
                    let declared = home.position - other.position;
                    let counted = read - other.position;
                    let text = format_args!(
                        "home: from the other switch it is {declared} rad, by the encoder {counted:.3} rad"
                    );
                    self.consoles.announce(text, out);
                    return;
                }
                self.found = Some(home);
                // Within the parameters' bounds the quotient is below 2³⁰; the cast rounds towards 0 and saturates.
                let counts = libm::roundf(home.position / self.machine.converters.position.unit());
                self.wiring.ask_shift((counts as i32).wrapping_sub(edge));
                self.referenced = true;
                let text = format_args!("home: the {switch} switch is at {} rad", home.position);
                self.consoles.announce(text, out);
            }
            None => {
                let text = format_args!("home: no {switch} switch within the stroke");
                self.consoles.announce(text, out);
            }
        }
    }

    /// Whether the encoder, which counts from one switch, reads the other one where that is declared. Either may open as far from
    /// there as a stop may be, and what is passed within a control period is not told.
    fn is_scaled(&self, from: &Home, to: &Home, read: f32) -> bool {
        let plant = &self.machine.plant;
        let stroke = plant.upper_stop - plant.lower_stop;
        let passed = (from.speed + to.speed) * CONTROL_PERIOD;
        let tolerance = 2.0 * Tolerances::INDUSTRIAL.stop * stroke + passed;
        (read - to.position).abs() <= tolerance
    }

    fn sends_log(&self) -> bool {
        self.sending.is_some_and(|sending| sending.holds_log())
    }

    fn send(&mut self, out: &mut dyn Write) {
        self.sending = self.sending.and_then(|sending| {
            let log = self.memory.as_deref();
            let log = log.map(|log| (log, &self.machine.converters));
            sending.advance(self.capture, log, &mut self.station, out)
        });
    }

    /// A line on how the drive is, where one is due. What there is no room for is left out.
    fn tell(&mut self, out: &mut dyn Write) {
        let [period, left] = self.stream;
        let Some(sample) = self.latest.filter(|_| period > 0) else {
            return;
        };
        if left > 1 {
            self.stream = [period, left - 1];
            return;
        }
        self.stream = [period, period];
        if self.station.room() >= FRAME {
            let live = self.live(&sample);
            let _ = frame::write(out, format_args!("{live}"));
        }
    }

    fn live(&self, sample: &Sample) -> Live {
        let converters = &self.machine.converters;
        Live {
            sequence: sample.sequence,
            armed: self.is_armed(),
            mode: self.mode,
            latched: self.wiring.latch().causes(),
            command: sample.command,
            input: converters.bridge.value(sample.duty),
            position: converters.position.value(sample.position),
            current: converters.current.value(sample.current),
            supply: self.wiring.supply(),
            worst: self.station.worst(),
        }
    }

    /// Takes a byte from a keyboard.
    pub async fn take(&mut self, keyboard: Keyboard, byte: u8, out: &mut dyn Write) {
        if let Some(request) = self.consoles.take(keyboard, byte, out) {
            self.wiring.sign_of_life();
            match request {
                Request::Help(command) => console::reply(&Response::Help(command), out),
                Request::Status => console::reply(&Response::Status(self.status()), out),
                Request::Faults => {
                    let latched = Latched::from(self.wiring.latch());
                    console::reply(&Response::Faults(latched), out);
                }
                Request::ShowAll => {
                    let all = Response::Parameters(&DESCRIPTIONS, self.values.as_array());
                    console::reply(&all, out);
                }
                Request::Show(place) => match Field::ALL.get(place) {
                    Some(field) => {
                        let value = self.values.get(*field);
                        console::reply(&Response::Parameter(field.description(), value), out);
                    }
                    None => console::reply(&Response::Refused(Refusal::Unavailable), out),
                },
                _ => {
                    let response = match self.perform(request, out).await {
                        Ok(()) => Response::Done,
                        Err(refusal) => Response::Refused(refusal),
                    };
                    console::reply(&response, out);
                }
            }
        }
    }

    fn is_armed(&self) -> bool {
        self.wiring.latch().is_armed()
    }

    fn status(&self) -> Status {
        let measured = self.wiring.measurement();
        let converters = &self.machine.converters;
        Status {
            armed: self.is_armed(),
            mode: self.mode,
            latched: self.wiring.latch().causes(),
            position: converters.position.value(measured.position),
            current: self
                .kit
                .measured_current(&self.values)
                .of(converters.current.value(measured.current)),
            supply: self.wiring.supply(),
            switches: self.wiring.switches(),
            from_start: !self.kit.is_emulated && !self.referenced,
            encoder_follows: self
                .kit
                .checks_encoder(&self.values)
                .then(|| self.wiring.encoder_follows()),
            temperatures: (!self.kit.is_emulated).then(|| self.temperatures()),
            ticks: self.wiring.time(),
            missed: self.wiring.missed(),
            worst: self.station.worst(),
            unit: S::UNIT,
            capture: self.capture.stage(),
        }
    }

    fn temperatures(&self) -> [Told; 2] {
        let [switches, motor] = self.wiring.temperatures();
        let told = |maximum, celsius: f32| match celsius {
            _ if self.values.get(maximum) == 0.0 => Told::NotWatched,
            _ if celsius.is_nan() => Told::Broken,
            _ => Told::Celsius(celsius),
        };
        [
            told(Field::SwitchTemperatureMaximum, switches),
            told(Field::MotorTemperatureMaximum, motor),
        ]
    }

    async fn perform(&mut self, request: Request, out: &mut dyn Write) -> Result<(), Refusal> {
        match request {
            Request::Clear => self.clear(out),
            Request::Arm => self.arm(),
            Request::Disarm => {
                self.disarm();
                Ok(())
            }
            Request::Mode(mode) => self.set_mode(mode),
            Request::Signal(signal) => self.command(signal),
            Request::Hold => {
                self.require_commanded()?;
                self.order(drive::Order::Hold)
            }
            Request::Zero => self.zero(),
            Request::Home(home) => self.home(home),
            Request::Set { parameter, value } => self.set(parameter, value),
            Request::Body(command) => self.tell_body(command),
            Request::Record(settings) => {
                if !self.sends_log() {
                    self.sending = None;
                }
                self.capture.begin(settings).map_err(Refusal::Invalid)
            }
            Request::Dump(Dump::Capture) => self.dump(),
            Request::Dump(Dump::Log(to)) => self.dump_log(to),
            Request::Stream(rate) => {
                self.stream = [polls(rate); 2];
                Ok(())
            }
            Request::Refit => self.ask(Question::Refit),
            Request::Check => self.ask(Question::Check),
            Request::Save => self.save().await,
            // Answered where they are read, or nothing but a sign of life.
            Request::Help(_)
            | Request::Status
            | Request::Faults
            | Request::ShowAll
            | Request::Show(_)
            | Request::Ping => Ok(()),
        }
    }

    /// Forgets what is latched. What came since the last poll is heeded before.
    fn clear(&mut self, out: &mut dyn Write) -> Result<(), Refusal> {
        // From here on a fault that comes is not forgotten.
        let clearing = self.wiring.latch().begin_to_clear();
        self.heed_faults(out);
        clearing.end().map_err(Refusal::NotCleared)?;
        // The same fault is told anew, though it come before the next poll.
        self.announced = Faults::NONE;
        Ok(())
    }

    fn arm(&mut self) -> Result<(), Refusal> {
        let must_be_known = self.machine.motion.has_position() && !self.kit.is_emulated;
        if must_be_known && !self.referenced && self.home.is_none() {
            return Err(Refusal::Unreferenced);
        }
        let was_armed = self.is_armed();
        let is_outdated = self.unlimited || self.trusted != self.referenced;
        if is_outdated && self.home.is_none() {
            self.order_setup()?;
            self.unlimited = false;
        }
        if !was_armed {
            // Lines come faster than control steps: what was told before the drive was disarmed may still be on its way to it, and
            // so may its last position before another zero.
            self.order(drive::Order::Mode(self.mode))?;
        }
        self.switch_on()?;
        match self.home {
            Some(home) if !was_armed => self.seek(&home).inspect_err(|_| self.disarm()),
            _ => Ok(()),
        }
    }

    fn switch_on(&mut self) -> Result<(), Refusal> {
        match self.power.take() {
            Some(Power::Disarmed(disarmed)) => match disarmed.arm() {
                Ok(armed) => {
                    self.power = Some(Power::Armed(armed));
                    Ok(())
                }
                Err(refused) => {
                    self.power = Some(Power::Disarmed(refused.disarmed));
                    Err(Refusal::Latched(refused.reason))
                }
            },
            power => {
                self.power = power;
                // Armed already; but what is latched meanwhile keeps the bridge off.
                let latched = self.wiring.latch().causes();
                if latched.is_empty() {
                    Ok(())
                } else {
                    Err(Refusal::Latched(latched))
                }
            }
        }
    }

    /// Takes the power. A search that is under way has ended then.
    fn disarm(&mut self) {
        if self.is_armed() {
            self.home = None;
        }
        self.power = match self.power.take() {
            Some(Power::Armed(armed)) => Some(Power::Disarmed(armed.disarm())),
            power => power,
        };
    }

    fn require_disarmed(&self) -> Result<&Disarmed<&'static Latch>, Refusal> {
        match &self.power {
            Some(Power::Disarmed(disarmed)) => Ok(disarmed),
            _ => Err(Refusal::Armed),
        }
    }

    /// Armed, sound, and in a mode with a command.
    fn require_commanded(&self) -> Result<(), Refusal> {
        if self.mode == Mode::Wires {
            return Err(Refusal::Followed);
        }
        let latched = self.wiring.latch().causes();
        if !latched.is_empty() {
            Err(Refusal::Latched(latched))
        } else if self.is_armed() {
            self.require_no_search()
        } else {
            Err(Refusal::Disarmed)
        }
    }

    fn require_no_search(&self) -> Result<(), Refusal> {
        let seeks = self.home.is_some() && self.is_armed();
        if seeks { Err(Refusal::Seeking) } else { Ok(()) }
    }

    fn order(&mut self, order: drive::Order) -> Result<(), Refusal> {
        self.orders.enqueue(order).map_err(|_| Refusal::QueueFull)
    }

    fn order_plant(&mut self, order: order::Order) -> Result<(), Refusal> {
        let sent = self.plant.orders.enqueue(order);
        sent.map_err(|_| Refusal::QueueFull)
    }

    fn set_mode(&mut self, mode: Mode) -> Result<(), Refusal> {
        if !self.kit.modes.contains(&mode) {
            return Err(Refusal::Unavailable);
        }
        self.require_no_search()?;
        self.home = None;
        self.order(drive::Order::Mode(mode))?;
        self.mode = mode;
        Ok(())
    }

    fn command(&mut self, signal: Signal) -> Result<(), Refusal> {
        self.require_commanded()?;
        let generator = signal.build().map_err(Refusal::Invalid)?;
        if self.mode == Mode::Position {
            self.machine
                .motion
                .check(signal.extent())
                .map_err(Refusal::Invalid)?;
        }
        self.order(drive::Order::Signal(generator))
    }

    /// Has the next arming seek a switch.
    fn home(&mut self, home: Home) -> Result<(), Refusal> {
        if self.kit.is_emulated {
            return Err(Refusal::Unavailable);
        }
        self.require_disarmed()?;
        self.set_mode(Mode::Position)?;
        // What came of an earlier search says nothing of this one.
        let _ = self.wiring.take_search();
        self.referenced = false;
        self.home = Some(home);
        Ok(())
    }

    /// Begins to seek a switch: nothing limits a position that is not known, but the way is no longer than the stroke.
    fn seek(&mut self, home: &Home) -> Result<(), Refusal> {
        self.unlimited = true;
        self.order_setup()?;
        let plant = &self.machine.plant;
        self.order(drive::Order::Seek(Sought {
            switch: home.switch,
            speed: home.speed,
            farthest: plant.upper_stop - plant.lower_stop,
        }))
    }

    /// The drive's numbers. A position that is not known is not limited while a switch is sought.
    fn setup(&self, values: &Values) -> Result<drive::Setup, Refusal> {
        let mut values = *values;
        if self.home.is_some() && self.is_armed() {
            for (field, value) in [
                (Field::PositionMinimum, -NO_POSITION),
                (Field::PositionMaximum, NO_POSITION),
            ] {
                let set = values.set(field, value);
                set.map_err(|out| Refusal::NotStored(Rejected::Bounds(out)))?;
            }
        }
        self.kit
            .drive(&values, self.referenced)
            .map_err(Refusal::Setup)
    }

    fn order_setup(&mut self) -> Result<(), Refusal> {
        let setup = self.setup(&self.values)?;
        self.order_drive(setup)
    }

    fn order_drive(&mut self, setup: drive::Setup) -> Result<(), Refusal> {
        self.order(drive::Order::Setup(setup))?;
        self.trusted = self.referenced;
        Ok(())
    }

    fn zero(&mut self) -> Result<(), Refusal> {
        if self.kit.is_emulated {
            return Err(Refusal::Unavailable);
        }
        self.require_disarmed()?;
        self.wiring.ask_zero();
        self.referenced = true;
        self.home = None;
        self.found = None;
        Ok(())
    }

    fn tell_body(&mut self, command: loopback::Command) -> Result<(), Refusal> {
        if self.kit.is_emulated {
            self.order_plant(order::Order::Body(command))
        } else {
            Err(Refusal::Unavailable)
        }
    }

    fn set(&mut self, parameter: usize, value: f32) -> Result<(), Refusal> {
        let field = *Field::ALL.get(parameter).ok_or(Refusal::Unavailable)?;
        let mut values = self.values;
        let set = values.set(field, value);
        set.map_err(|out| Refusal::NotStored(Rejected::Bounds(out)))?;
        // The position or the measured current jumps, has to be known before the drive is armed, or a check would begin
        // while a loop is closed.
        let at_rest = match field {
            Field::PositionUnit | Field::PositionMinimum | Field::PositionMaximum => true,
            Field::CurrentGain | Field::CurrentOffset | Field::EncoderCheck => {
                !self.kit.is_emulated
            }
            _ => false,
        };
        if at_rest {
            self.require_disarmed()?;
        }
        self.use_values(&values, field.is_plant())?;
        let withdrawn = self.proposal.as_ref().is_some_and(|proposal| {
            let mut changes = proposal.changes.iter();
            changes.any(|(changed, _)| *changed == field)
        });
        if withdrawn {
            self.proposal = None;
        }
        Ok(())
    }

    /// Runs with these values from now on. A body with another plant takes the place of the one before.
    fn use_values(&mut self, values: &Values, another_plant: bool) -> Result<(), Refusal> {
        let setup = self.setup(values)?;
        let converters = self.kit.machine_with(values).converters;
        if self.sends_log() && converters.position.unit() != self.machine.converters.position.unit()
        {
            return Err(Refusal::Busy);
        }
        // All of them or none.
        let room = self.orders.ready()
            && self.plant.orders.len() + PLANT_ORDERS <= self.plant.orders.capacity();
        if !room {
            return Err(Refusal::QueueFull);
        }
        if another_plant && self.kit.is_emulated {
            self.require_disarmed()?;
            let throttle = self.kit.throttle(values).map_err(Refusal::Setup)?;
            let spare = self.spare.take().ok_or(Refusal::QueueFull)?;
            *spare = throttle;
            self.order_plant(order::Order::Replace(spare))?;
        }
        self.order_drive(setup)?;
        self.order_plant(if self.kit.is_emulated {
            order::Order::Calibrate(converters, self.kit.calibration(values))
        } else {
            order::Order::Actuator(self.kit.actuator(values))
        })?;
        self.values = *values;
        let unit = self.machine.converters.position.unit();
        self.machine = self.kit.machine_with(values);
        if self.machine.converters.position.unit() != unit {
            // What was counted, was counted in another unit.
            self.found = None;
            self.referenced = false;
            if let Some(memory) = &mut self.memory {
                memory.clear();
            }
        }
        Ok(())
    }

    fn dump(&mut self) -> Result<(), Refusal> {
        let stage = self.capture.stage();
        if stage != Stage::Complete {
            return Err(Refusal::NotRecorded(stage));
        }
        self.station.send_head(self.capture);
        self.sending = Some(Transfer::new(Dump::Capture));
        Ok(())
    }

    fn dump_log(&mut self, to: Destination) -> Result<(), Refusal> {
        let rows = self.memory.as_ref().ok_or(Refusal::Busy)?.samples();
        if rows == 0 {
            return Err(Refusal::NothingDriven);
        }
        if to == Destination::Rtt {
            self.station.send_log_head(rows);
        }
        self.sending = Some(Transfer::new(Dump::Log(to)));
        Ok(())
    }

    fn ask(&mut self, question: Question) -> Result<(), Refusal> {
        if self.sends_log() {
            return Err(Refusal::Busy);
        }
        let memory = self.memory.take().ok_or(Refusal::Busy)?;
        self.job = Some(Job {
            question,
            machine: self.machine,
            memory,
        });
        Ok(())
    }

    /// The work to be done, once.
    pub fn job(&mut self) -> Option<Job> {
        self.job.take()
    }

    /// Takes work back that is done.
    pub fn finish(&mut self, done: Done, out: &mut dyn Write) {
        let Done { memory, answer } = done;
        memory.clear();
        self.memory = Some(memory);
        let verdict = self.propose(&answer);
        self.consoles
            .announce(format_args!("{answer}{verdict}"), out);
    }

    /// Keeps what a refit found for `save`, if it may be taken over.
    fn propose(&mut self, answer: &Answer) -> Verdict {
        let Answer::Refit(Ok(estimate)) = answer else {
            return Verdict::None;
        };
        let candidate = Candidate::from(estimate);
        let applied = match candidate.applied_to(&self.values) {
            Ok(applied) => applied,
            Err(rejected) => return Verdict::Rejected(rejected),
        };
        match self.kit.drive(&applied, self.referenced) {
            Ok(_) => {
                self.proposal = Some(candidate);
                Verdict::Proposed
            }
            Err(refused) => Verdict::Refused(refused),
        }
    }

    async fn save(&mut self) -> Result<(), Refusal> {
        let Some(Power::Disarmed(disarmed)) = &self.power else {
            return Err(Refusal::Armed);
        };
        // A word that is programmed with too little voltage may be neither what it was nor what it should be.
        if self.wiring.is_processor_supply_low() {
            return Err(Refusal::Latched(Fault::BrownOut.into()));
        }
        self.wiring.set_stalled(true);
        self.station.stall(true);
        let began = self.station.clock().wrapping_sub(self.wiring.ticks());
        let saved = match &self.proposal {
            Some(candidate) => self.store.adopt(&self.values, candidate, disarmed).await,
            None => {
                let committed = self.store.commit(&self.values, disarmed).await;
                committed.map(|_| self.values).map_err(Rejected::Store)
            }
        };
        let ended = self.station.clock().wrapping_sub(self.wiring.ticks());
        // Clock and ticks are read one behind the other: it may be a tick less than none.
        let stood_still = ended.wrapping_sub(began).cast_signed().max(0);
        self.wiring.stood_still_for(stood_still.unsigned_abs());
        self.station.stall(false);
        self.wiring.set_stalled(false);
        let values = saved.map_err(Refusal::NotStored)?;
        if self.proposal.take().is_some() {
            self.use_values(&values, true)?;
        }
        Ok(())
    }
}

/// Polls from one line to the next, for so many lines a second; 0 for none.
fn polls(rate: f32) -> u32 {
    if rate > 0.0 {
        let polls_a_second = 1000.0 / POLL_PERIOD_MS as f32;
        // At most the rate that was asked for. A rate of next to nothing becomes the largest number.
        libm::ceilf(polls_a_second / rate) as u32
    } else {
        0
    }
}

/// What becomes of a refit's result.
enum Verdict {
    None,
    Proposed,
    Rejected(Rejected),
    /// It does not go with the other values.
    Refused(Refused),
}

impl fmt::Display for Verdict {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => Ok(()),
            Self::Proposed => formatter.write_str("\n`save` takes it over, disarmed"),
            Self::Rejected(rejected) => write!(formatter, "\nnot taken over: {rejected}"),
            Self::Refused(refused) => write!(formatter, "\nnot taken over: {refused}"),
        }
    }
}

/// What an image says of itself when it starts.
struct Greeting<'a> {
    kit: &'a Kit,
    loaded: &'a Loaded,
}

impl fmt::Display for Greeting<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: ", self.kit.name)?;
        match self.loaded.generation {
            Some(generation) => write!(formatter, "parameters of commit {generation}")?,
            None => formatter.write_str("nothing stored, its own parameters")?,
        }
        if let Some(problem) = self.loaded.problem {
            write!(formatter, "\nstore: {problem}")?;
        }
        for refused in &self.loaded.refused {
            write!(formatter, "\nstore: {refused}; its own is used")?;
        }
        Ok(())
    }
}
