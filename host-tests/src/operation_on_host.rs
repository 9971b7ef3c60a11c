//! The two images that are operated from a console, on this host: the same code, called in the order in
//! which the board's vectors and tasks call it, with flash that survives a restart.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use firmware::app::capture::{Capture, QUANTITIES};
use firmware::app::console::editor::PROMPT;
use firmware::app::conversion::Converters;
use firmware::app::ecu::loopback::Wires;
use firmware::app::fault::output::Bridge;
use firmware::app::fault::overload::{self, Heat};
use firmware::app::liveness::Task;
use firmware::app::machine::FULL_DUTY;
use firmware::app::memory::Memory;
use firmware::app::operation::actuator::{self, CURRENT_MIDDLE, Inputs, Readings};
use firmware::app::operation::body::Body;
use firmware::app::operation::bridge;
use firmware::app::operation::drive::Drive;
use firmware::app::operation::evaluation::{Done, Job};
use firmware::app::operation::kit::{ACTUATOR, Kit, THROTTLE_BODY};
use firmware::app::operation::operator::{
    self, Joints, Keyboard, Operator, POLL_PERIOD_MS, Station,
};
use firmware::app::operation::order::Receiver;
use firmware::app::store::field::Values;
use firmware::app::store::{Loaded, Store};
use firmware::app::timing::{PLANT_PERIOD, PLANT_PERIOD_US};
use firmware::app::wiring::Wiring;
use firmware::app::work::{ControlWork, PlantWork};
use model_core::numeric::random::Random;
use model_core::plant::State;
use model_core::plant::actuator::Actuator;
use model_core::plant::bridge as model_bridge;
use model_core::plant::parameters::{self, Parameters};

use crate::simulated_flash::{SimulatedFlash, now};

/// Bytes of the chip's small sectors.
pub const SECTOR: usize = 16 * 1024;

/// Ticks between two polls of the operator.
const TICKS_PER_POLL: u32 = POLL_PERIOD_MS * 1000 / PLANT_PERIOD_US;

/// Flash that several programs in turn, and a test, have a hand on. It is changed only disarmed, and with
/// the processor's standstill announced.
#[derive(Debug, Clone)]
pub struct SharedFlash {
    /// The flash.
    pub flash: Rc<RefCell<SimulatedFlash<SECTOR>>>,
    /// RAM that no start clears: the winding's heat. At first it is cold, and that is known.
    pub heat: Rc<overload::Kept>,
    /// The wires of the program that runs.
    wiring: Rc<Cell<Option<&'static Wiring>>>,
}

impl SharedFlash {
    /// The four small sectors, erased.
    pub fn new() -> Self {
        let heat = Rc::new(overload::Kept::new());
        heat.set(Heat::NONE.word());
        Self {
            flash: Rc::new(RefCell::new(SimulatedFlash::new(4))),
            heat,
            wiring: Rc::default(),
        }
    }

    /// Takes the supply away for an unknown time: what the RAM held is lost.
    pub fn lose_ram(&self) {
        self.heat.set(Heat::UNKNOWN.word());
    }

    fn assert_allowed(&self) {
        if let Some(wiring) = self.wiring.get() {
            assert!(wiring.is_stalled(), "a standstill that nobody announced");
            assert!(!wiring.latch().is_armed(), "armed");
        }
    }
}

impl Default for SharedFlash {
    fn default() -> Self {
        Self::new()
    }
}

impl ErrorType for SharedFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for SharedFlash {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        now(self.flash.borrow_mut().read(offset, bytes))
    }

    fn capacity(&self) -> usize {
        self.flash.borrow().capacity()
    }
}

impl NorFlash for SharedFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        self.assert_allowed();
        now(self.flash.borrow_mut().erase(from, to))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        self.assert_allowed();
        now(self.flash.borrow_mut().write(offset, bytes))
    }
}

/// What the operator asked of its board.
#[derive(Debug, Default)]
pub struct Asked {
    /// Whether the watchdog was told of a stall, in order.
    pub stalls: Vec<bool>,
    /// Plant ticks by which the board's clock goes on from one look to the next.
    pub clock_step: u32,
    /// What the clock reads.
    pub clock: u32,
    /// Rows of captures that were sent.
    pub rows: Vec<[f32; QUANTITIES]>,
    /// Bytes that the console takes less than it would.
    pub congestion: usize,
    /// The trigger's row of each capture that was sent.
    pub triggers: Vec<Option<usize>>,
}

/// Bytes that a board's console takes beside the longest answer.
const CONSOLE_ROOM: usize = 1024;

/// A board that remembers.
struct StationOnHost(Rc<RefCell<Asked>>);

impl Station for StationOnHost {
    const UNIT: &'static str = "cycles";

    fn worst(&self) -> [u32; 2] {
        [3000, 5000]
    }

    fn stall(&mut self, stalled: bool) {
        self.0.borrow_mut().stalls.push(stalled);
    }

    fn clock(&self) -> u32 {
        let mut asked = self.0.borrow_mut();
        asked.clock += asked.clock_step;
        asked.clock
    }

    fn send_head(&mut self, capture: &Capture) {
        let mut asked = self.0.borrow_mut();
        asked.rows.clear();
        asked.triggers.push(capture.trigger_row());
    }

    fn send_log_head(&mut self, _: usize) {
        self.0.borrow_mut().rows.clear();
    }

    fn room(&self) -> usize {
        CONSOLE_ROOM.saturating_sub(self.0.borrow().congestion)
    }

    fn send_row(&mut self, number: u32, values: &[f32; QUANTITIES]) {
        let mut asked = self.0.borrow_mut();
        assert_eq!(number as usize, asked.rows.len());
        asked.rows.push(*values);
    }
}

/// What is at an image's wires.
pub trait Plant {
    /// What the board's vector reads.
    fn read(&mut self);

    /// The plant interrupt's work.
    fn work(&mut self) -> &mut dyn PlantWork;

    /// What the board's vector writes.
    fn write(&mut self, wiring: &Wiring);
}

/// The emulated throttle body, with what an engine controller tells it.
pub struct ThrottleWires {
    body: Body,
    wires: &'static Wires,
    /// What the engine controller tells.
    pub told: model_bridge::Bridge,
}

impl Plant for ThrottleWires {
    fn read(&mut self) {
        self.wires.drive(self.told);
    }

    fn work(&mut self) -> &mut dyn PlantWork {
        &mut self.body
    }

    fn write(&mut self, _: &Wiring) {}
}

/// A motor with its bridge and sensors, in the place of a real one. Its brake holds it at once.
pub struct Motor {
    actuator: Actuator,
    plant: Parameters,
    /// Position, velocity and current.
    pub state: State,
    converters: Converters,
    inputs: &'static Inputs,
    work: actuator::Actuator,
    /// Supply of the bridge, V.
    pub supply: f32,
    /// What the encoder counts of each count from here on: 0 if it is lost, −1 the wrong way round.
    pub encoder: f32,
    /// What it has counted, rad.
    counted: f32,
    /// Counts that it has gone besides, which nothing drove.
    pub turned: i32,
    /// The limit switches.
    pub switches: [bool; 2],
    /// Where they open besides, rad.
    pub edges: [f32; 2],
    /// Whether the bridge's driver holds the break input.
    pub broken: bool,
    /// Whether the emergency stop's contact is open.
    pub stopped: bool,
    /// Codes of the temperature sensors, of the switches and the motor.
    pub temperatures: [u16; 2],
    /// What the current sensor reads in the place of the current, A.
    pub current: Option<f32>,
    /// What the current sensor adds, A.
    pub offset: f32,
    /// What is lost between the bridge and the winding.
    pub drop: Drop,
    /// What draws the noise of the current sensor, none for one without.
    pub noise: Option<Random>,
    /// Whether a voltage acts a whole tick late; a bridge's timer takes it over within half of one.
    pub late: bool,
    next: Option<f32>,
    voltage: Option<f32>,
}

/// What is lost between a bridge and its winding, against the current.
#[derive(Debug, Default)]
pub struct Drop {
    /// By the bridge's dead time, beyond the current's ripple of 0.3 A, as a share of the supply.
    pub dead_time: f32,
    /// At the brushes, V, beyond a tenth of the motor's rated current, 0.6 A: it comes and goes, from 0 to this much.
    pub brushes: f32,
    /// Of that what there is now, 0 to 1.
    pub share: f32,
}

impl Drop {
    /// With this supply, V, and current, A. What comes and goes changes after 10 ms in the mean.
    fn step(&mut self, supply: f32, current: f32, random: Option<&mut Random>) -> f32 {
        if let Some(random) = random
            && random.uniform() < PLANT_PERIOD / 10e-3
        {
            self.share = random.uniform();
        }
        self.dead_time * supply * (current / 0.3).clamp(-1.0, 1.0)
            + self.share * self.brushes * (current / 0.6).clamp(-1.0, 1.0)
    }
}

/// Noise of a current sensor that has some, counts either way.
const NOISE: f32 = 3.0;

impl Motor {
    /// At rest.
    fn new(plant: &Parameters, inputs: &'static Inputs, work: actuator::Actuator) -> Self {
        Self {
            actuator: Actuator::build(plant, PLANT_PERIOD).expect("a motor in its ranges"),
            plant: *plant,
            state: State::new(0.0, 0.0),
            converters: ACTUATOR.machine.converters,
            inputs,
            work,
            supply: 24.0,
            encoder: 1.0,
            counted: 0.0,
            turned: 0,
            switches: [false; 2],
            edges: [f32::NEG_INFINITY, f32::INFINITY],
            broken: false,
            stopped: false,
            // Of a sensor at 25 °C, as large as its resistor.
            temperatures: [2048; 2],
            current: None,
            offset: 0.0,
            drop: Drop::default(),
            noise: None,
            late: false,
            next: None,
            voltage: None,
        }
    }

    /// From here on it is blocked where it is.
    pub fn block(&mut self) {
        let here = self.state.position.value();
        self.replace(Parameters {
            lower_stop: here - 1e-4,
            upper_stop: here + 1e-4,
            ..self.plant
        });
    }

    /// From here on it is as it was made: neither blocked, nor overhauled, nor warm.
    pub fn release(&mut self) {
        self.replace(self.plant);
    }

    /// From here on a load of this torque drives it, and no stop is in its way.
    pub fn overhaul(&mut self, torque: f32) {
        self.replace(Parameters {
            offset: torque,
            lower_stop: -1e4,
            upper_stop: 1e4,
            ..self.plant
        });
    }

    /// From here on its winding has this resistance, Ω, and this torque constant, N·m/A.
    pub fn warm(&mut self, [resistance, torque_constant]: [f32; 2]) {
        let parameters::Drive::Voltage { inductance, .. } = self.plant.drive else {
            return;
        };
        self.replace(Parameters {
            drive: parameters::Drive::Voltage {
                resistance,
                inductance,
                torque_constant,
            },
            ..self.plant
        });
    }

    fn replace(&mut self, plant: Parameters) {
        self.actuator = Actuator::build(&plant, PLANT_PERIOD).expect("a motor in its ranges");
    }

    /// What the bridge draws from its supply, A: without losses, as much power as the winding takes.
    pub fn supply_current(&self) -> f32 {
        self.voltage
            .map_or(0.0, |voltage| voltage * self.state.current / self.supply)
    }

    /// Whether the bridge drove in the last tick.
    pub fn is_driven(&self) -> bool {
        self.voltage.is_some()
    }
}

impl Plant for Motor {
    fn read(&mut self) {
        let before = self.state.position.value();
        match self.voltage {
            Some(voltage) => {
                let noise = self.noise.as_mut();
                let lost = self.drop.step(self.supply, self.state.current, noise);
                let stepped = self.actuator.step(&mut self.state, voltage - lost);
                stepped.expect("a voltage");
            }
            None => self.state = State::new(self.state.position.value(), 0.0),
        }
        let current = self.current.unwrap_or(self.state.current);
        let noise = self.noise.as_mut().map_or(0.0, |random| {
            NOISE * (2.0 * random.uniform() - 1.0) * self.converters.current.unit()
        });
        let counts = self
            .converters
            .current
            .counts(current + self.offset + noise);
        let counts = counts.expect("a current");
        self.counted += self.encoder * (self.state.position.value() - before);
        let position = self.state.position.value();
        let encoder = (self.counted / self.converters.position.unit()).round() as i32;
        let supply = actuator::SUPPLY.counts(self.supply).expect("a supply");
        self.inputs.set(&Readings {
            current: CURRENT_MIDDLE.wrapping_add_signed(counts),
            supply: supply.unsigned_abs(),
            // The counter has 16 bits.
            encoder: encoder.wrapping_add(self.turned) as u16,
            switches: [
                self.switches[0] || position <= self.edges[0],
                self.switches[1] || position >= self.edges[1],
            ],
            broken: self.broken,
            stopped: self.stopped,
            temperatures: self.temperatures,
        });
    }

    fn work(&mut self) -> &mut dyn PlantWork {
        &mut self.work
    }

    fn write(&mut self, wiring: &Wiring) {
        let driven = wiring.latch().outputs().bridge == Bridge::Driven;
        let voltage = driven.then(|| {
            let volts = self.converters.bridge.value(wiring.duty());
            let duty = bridge::duty(volts, wiring.supply());
            f32::from(duty) / f32::from(FULL_DUTY) * self.supply
        });
        let before = core::mem::replace(&mut self.next, voltage);
        // Switches open at once.
        self.voltage = if self.late && driven && before.is_some() {
            before
        } else {
            voltage
        };
    }
}

/// An image.
pub struct OperationOnHost<P> {
    operator: Operator<SharedFlash, StationOnHost>,
    drive: Drive,
    /// What is at its wires.
    pub plant: P,
    /// The wires.
    pub wiring: &'static Wiring,
    /// What was asked of the board.
    pub asked: Rc<RefCell<Asked>>,
    /// What the terminal was sent, without the answers to lines.
    pub said: String,
    /// Ticks for which the tasks are kept from running.
    pub tasks_held: u32,
    /// A task that hangs, while the others go on.
    pub hung: Option<Task>,
    /// Whether the processor's own supply is too low.
    pub processor_supply_low: bool,
    /// Whether its crystal stands still.
    pub clock_failed: bool,
    /// Whether the control interrupt is kept from running.
    pub control_held: bool,
    /// What bits that flip in memory make of the measured supply, V.
    pub damaged_supply: Option<f32>,
    heat: Rc<overload::Kept>,
    ticks: u32,
}

/// What the board keeps in statics is leaked.
fn leak<T: Default>() -> &'static mut T {
    Box::leak(Box::default())
}

/// What the plant at the wires is made of.
struct Parts {
    values: Values,
    receiver: Receiver,
    wiring: &'static Wiring,
}

impl OperationOnHost<ThrottleWires> {
    /// The emulated throttle body, started.
    pub fn throttle(flash: &SharedFlash) -> Self {
        let kit = &THROTTLE_BODY;
        Self::start(kit, flash, |parts| {
            let wires: &'static Wires = leak();
            let throttle = kit.throttle(&parts.values).expect("a body in its ranges");
            let body = Body::new(
                Box::leak(Box::new(throttle)),
                parts.receiver,
                (
                    kit.machine_with(&parts.values).converters,
                    kit.calibration(&parts.values),
                ),
                (wires, parts.wiring),
            );
            ThrottleWires {
                body,
                wires,
                told: model_bridge::Bridge::Freewheel,
            }
        })
    }
}

impl OperationOnHost<Motor> {
    /// The controller, started, with this motor at its wires.
    pub fn controller(flash: &SharedFlash, motor: &Parameters) -> Self {
        let kit = &ACTUATOR;
        Self::start(kit, flash, |parts| {
            let inputs: &'static Inputs = leak();
            let work = actuator::Actuator::new(
                parts.receiver,
                (inputs, parts.wiring),
                &kit.actuator(&parts.values),
            );
            Motor::new(motor, inputs, work)
        })
    }
}

impl<P: Plant> OperationOnHost<P> {
    fn start(kit: &'static Kit, flash: &SharedFlash, plant: impl FnOnce(Parts) -> P) -> Self {
        let wiring: &'static Wiring = leak();
        flash.wiring.set(Some(wiring));
        wiring.set_heat(flash.heat.get().word());
        let asked = Rc::new(RefCell::new(Asked::default()));
        let mut store = Store::new(flash.clone(), SECTOR as u32).expect("flash with room");
        let (values, loaded): (Values, Loaded) =
            now(operator::load(kit, &mut store, wiring)).expect("values within their bounds");
        let spare = kit.is_emulated.then(|| {
            let spare = kit.throttle(&values).expect("a body in its ranges");
            &mut *Box::leak(Box::new(spare))
        });
        let joints = Joints {
            kit,
            wiring,
            station: StationOnHost(asked.clone()),
            store,
            memory: leak::<Memory>(),
            cells: leak(),
            spare,
        };
        let (operator, drive, receiver) = Operator::new(joints, &values).expect("values in use");
        let parts = Parts {
            values,
            receiver,
            wiring,
        };
        let mut image = Self {
            operator,
            drive,
            plant: plant(parts),
            wiring,
            asked,
            said: String::new(),
            tasks_held: 0,
            hung: None,
            processor_supply_low: false,
            clock_failed: false,
            control_held: false,
            damaged_supply: None,
            heat: flash.heat.clone(),
            ticks: 0,
        };
        image.operator.greet(&loaded, &mut image.said);
        image
    }

    /// A period of the plant, with the control step and the poll that are due.
    pub fn tick(&mut self) {
        self.plant.read();
        self.wiring
            .set_processor_supply_low(self.processor_supply_low);
        self.wiring.set_clock_failed(self.clock_failed);
        let due = self.plant.work().tick();
        self.plant.write(self.wiring);
        self.heat.set(self.wiring.heat());
        if let Some(supply) = self.damaged_supply {
            self.wiring.set_supply(supply);
        }
        if due && !self.control_held {
            self.drive.step();
        }
        self.ticks += 1;
        let held = self.tasks_held > 0;
        self.tasks_held = self.tasks_held.saturating_sub(1);
        if self.ticks.is_multiple_of(TICKS_PER_POLL) && !held {
            for task in Task::ALL {
                match task {
                    _ if self.hung == Some(task) => {}
                    Task::Operator => self.operator.poll(&mut self.said),
                    // Of these a host has no more than their word.
                    Task::Reception | Task::Answers | Task::Evaluation => self.wiring.goes_on(task),
                }
            }
        }
    }

    /// So many milliseconds.
    pub fn run_ms(&mut self, milliseconds: u32) {
        for _ in 0..milliseconds * 1000 / PLANT_PERIOD_US {
            self.tick();
        }
    }

    /// What both are told for bytes that are typed at one of them.
    pub fn type_at(&mut self, keyboard: Keyboard, bytes: &[u8]) -> String {
        let mut sent = core::mem::take(&mut self.said);
        for &byte in bytes {
            now(self.operator.take(keyboard, byte, &mut sent));
        }
        sent
    }

    /// Takes a byte from the terminal; what it is answered is lost.
    pub fn byte(&mut self, byte: u8) {
        now(self
            .operator
            .take(Keyboard::Terminal, byte, &mut String::new()));
    }

    /// What the terminal is sent for bytes from it, and what was said since it was last asked.
    pub fn type_in(&mut self, bytes: &[u8]) -> String {
        self.type_at(Keyboard::Terminal, bytes)
    }

    /// What a line is answered, without the prompt; then 10 ms pass.
    pub fn line(&mut self, line: &str) -> String {
        let mut sent = String::new();
        for byte in line.bytes().chain([b'\r']) {
            now(self.operator.take(Keyboard::Terminal, byte, &mut sent));
        }
        let answer = sent
            .strip_prefix(&format!("{line}\r\n"))
            .and_then(|answer| answer.strip_suffix(PROMPT))
            .expect("an echo and a prompt");
        let answer = answer.trim_end().replace("\r\n", "\n");
        self.run_ms(10);
        answer
    }

    /// The long work that was asked for, once.
    pub fn job(&mut self) -> Option<Job> {
        self.operator.job()
    }

    /// Takes long work back that is done, and says what came of it.
    pub fn finish(&mut self, done: Done) {
        self.operator.finish(done, &mut self.said);
    }

    /// Does the long work that was asked for, and gives what is said of it. None if nothing was.
    pub fn evaluate(&mut self) -> Option<String> {
        let done = self.job()?.run();
        let mut said = String::new();
        self.operator.finish(done, &mut said);
        Some(said.replace("\r\n", "\n"))
    }
}
