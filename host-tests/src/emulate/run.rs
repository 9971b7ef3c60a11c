//! The emulation built and run, and what came of it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::dictionary;
use crate::failure::Failure;
use crate::package::Package;
use crate::toolchain::{Build, Toolchain, clean_command};
use crate::workspace;

/// Clock of the core, Hz.
const CORE_CLOCK: f64 = 168e6;

/// The emulation's package.
pub(crate) const EMULATION: Package = Package { name: "emulation" };

/// Cycles that an instruction takes on average, unless another number is asked for: with the caches on,
/// the flash keeps up with the core as if it had no wait states (RM0090, section 3.5.2), and a Cortex-M4's
/// loads, stores and taken branches take two to three cycles, the rest one.
pub const CYCLES_PER_INSTRUCTION: f64 = 1.5;

/// What was counted in a run of an image.
#[derive(Debug, Clone, Deserialize, Serialize)]
pub struct Counted {
    /// Virtual time, s.
    pub time_s: f64,
    /// Instructions.
    pub instructions: u64,
    /// Plant ticks that the hardware gave.
    pub plant_ticks: u64,
    /// Those that found the one before not taken yet.
    pub plant_ticks_missed: u64,
    /// Longest time from a plant tick to its acknowledgement by the program, µs.
    pub longest_latency_us: f64,
    /// Writes of the position tracks: one a plant tick.
    pub track_writes: u64,
    /// Resets.
    pub resets: usize,
    /// What `FLASH_ACR` reads: wait states, prefetch and caches.
    pub flash_access_control: u64,
}

/// The throttle by itself.
#[derive(Debug, Clone, Deserialize)]
pub struct Throttle {
    /// What it says before anything is asked.
    pub greeting: String,
    /// `status` after a step to 0.8 rad under its own drive.
    pub status: String,
    /// `status` after its motor was open for a while, the longest tick there is.
    pub status_with_motor_open: String,
    /// Up to then.
    pub counted: Counted,
    /// `faults` after TIM7 had been stopped.
    pub faults_after_stopped_tick: String,
    /// From there to the watchdog's reset, ms.
    pub reset_after_ms: f64,
    /// What came of each fault of the chip.
    pub faults: Vec<ThrottleFault>,
}

/// What came of a fault of the chip, the throttle armed.
#[derive(Debug, Clone, Deserialize)]
pub struct ThrottleFault {
    /// What was wrong.
    pub fault: String,
    /// What `faults` says then.
    pub faults: String,
    /// Codes of the tracks at the end.
    pub tracks: [u16; 2],
    /// Share of the current's output at the end.
    pub current: f64,
}

/// The controller by itself: its encoder's inputs, and its clock.
#[derive(Debug, Clone, Deserialize)]
pub struct Controller {
    /// `status` before anything.
    pub status: String,
    /// Behind spikes on both of the encoder's lines.
    pub status_behind_spikes: String,
    /// Behind edges, half a microsecond from one to the next.
    pub status_behind_edges: String,
    /// How many spikes there were.
    pub spikes: u64,
    /// How many edges.
    pub edges: u64,
    /// Time that a `save` takes which erases a sector, ms.
    pub save_ms: f64,
    /// By how much the clock in `status` is behind then, ms.
    pub clock_lost_ms: f64,
    /// Erases behind which the data cache was not emptied.
    pub unforgotten_erases: u64,
    /// What `FLASH_OPTCR` reads.
    pub flash_options: u64,
}

/// The controller's parameters over an end of power.
#[derive(Debug, Clone, Deserialize)]
pub struct Store {
    /// What it says at its first start.
    pub first_greeting: String,
    /// `save`'s answer.
    pub saved: String,
    /// Sectors erased, words programmed, and stores that tried to set a bit that was not erased.
    pub flash: [u64; 3],
    /// What it says at the start behind the end of power.
    pub second_greeting: String,
    /// `show torque_constant` behind it.
    pub shown: String,
    /// With 0.4 set, a second `save` begun, and the power lost in the middle of it: what it says at the next
    /// start.
    pub greeting_after_torn_save: String,
    /// `faults` behind it.
    pub faults_after_torn_save: String,
    /// `show torque_constant` behind it.
    pub shown_after_torn_save: String,
    /// Words that this `save` had programmed by then.
    pub torn_after_words: u64,
}

/// The loop of both.
#[derive(Debug, Clone, Deserialize)]
pub struct Driven {
    /// Command, what was asked for, and what the throttle's tracks say, rad from its rest.
    pub positions: Vec<(String, f64, f64)>,
    /// The controller's `status` at the end.
    pub controller_status: String,
    /// The throttle's.
    pub throttle_status: String,
    /// Of the controller.
    pub controller: Counted,
    /// Of the throttle.
    pub throttle: Counted,
    /// What was driven during each capture in the log.
    pub captures: Vec<String>,
    /// What the controller estimates from its own log of a worn throttle.
    pub refit: String,
}

/// The throttle's friction as the controller knows it, and once it is worn, N·m.
pub const FRICTION: [f64; 2] = [0.24, 0.3];

impl Driven {
    /// The friction that the controller estimates, N·m.
    pub fn friction(&self) -> Option<f64> {
        let (_, rest) = self.refit.split_once("refit: coulomb ")?;
        rest.split_whitespace().next()?.parse().ok()
    }
}

/// What came of a fault of the chip or of what is at its pins, the drive armed.
#[derive(Debug, Clone, Deserialize)]
pub struct Fault {
    /// What was wrong.
    pub fault: String,
    /// From there until the bridge was off and the brake was on, µs.
    pub let_go_after_us: Option<f64>,
    /// Whether that stayed so.
    pub held: bool,
    /// Codes of the tracks at the end.
    pub tracks: [u16; 2],
    /// Starts that it took.
    pub resets: usize,
    /// What `faults` says then.
    pub faults: String,
    /// And `status`: it has the longest interrupts since the last start.
    pub status: String,
}

/// The controller with one fault after the other.
#[derive(Debug, Clone, Deserialize)]
pub struct Faults {
    /// What came of each.
    pub faults: Vec<Fault>,
    /// `faults` of a winding that was pressed with until it was too hot.
    pub faults_overloaded: String,
    /// `faults` behind a reset right after that.
    pub faults_behind_reset: String,
    /// `clear`'s answer behind that.
    pub cleared_behind_reset: String,
    /// `faults` behind an end of power, in which the RAM is lost.
    pub faults_behind_power: String,
    /// `arm`'s answer while the crystal is dead, behind a `clear`.
    pub armed_without_crystal: String,
    /// The greeting at a start without a crystal.
    pub greeting_without_crystal: String,
    /// `faults` with the crystal back.
    pub faults_with_crystal: String,
    /// `status` while the terminal was flooded and torn.
    pub status_in_flood: String,
    /// `status` behind a `stop` in the middle of it.
    pub status_behind_stop: String,
    /// What stands still while a probe has halted the core: `DBGMCU_APB1_FZ` and `DBGMCU_APB2_FZ`.
    pub debug_freeze: [u64; 2],
}

/// A `save` that was cut short in many places.
#[derive(Debug, Clone, Deserialize)]
pub struct Cuts {
    /// Operations that the whole of it takes.
    pub operations: usize,
    /// Those of them that erase a sector in which something stands.
    pub erases: usize,
    /// Starts behind a cut.
    pub starts: usize,
    /// Those with the values before the `save`, and those with the values behind it.
    pub before: usize,
    /// See `before`.
    pub behind: usize,
    /// Starts at which `store_corrupt` was latched.
    pub named: usize,
    /// What was said at starts with values of both, or of neither.
    pub otherwise: Vec<String>,
}

/// The longest interrupts of an image, at a number of cycles an instruction.
#[derive(Debug, Clone, Deserialize)]
pub struct Ticks {
    /// `throttle`, with each of its faults; `controller`, while it sends a capture.
    pub image: String,
    /// Cycles that an instruction takes.
    pub cycles_per_instruction: f64,
    /// Its `status` at the end.
    pub status: String,
    /// Longest time from a plant tick to its acknowledgement, µs.
    pub longest_latency_us: f64,
    /// Plant ticks that found the one before not taken yet.
    pub missed: u64,
    /// Bytes of the stack that were used, and those that there are.
    pub stack_bytes: [u64; 2],
}

/// The throttle at the pins of an engine control unit, with a PWM of one frequency.
#[derive(Debug, Clone, Deserialize)]
pub struct Engine {
    /// Of the PWM, Hz.
    pub pwm_hz: f64,
    /// Each track at limp-home, closed and open stop as it was learned, V.
    pub learned: [[f64; 3]; 2],
    /// Time that the learning took, s.
    pub learned_after_s: f64,
    /// Gain of the position loop, V/rad.
    pub proportional: f64,
    /// Distance of the plate from the pedal half a second behind steps, of the stroke.
    pub settled: Vec<f64>,
    /// Largest distance from the set point along a triangle, of the stroke.
    pub following: f64,
    /// What was found of each fault.
    pub found: Vec<Found>,
    /// The throttle's `status` at the end.
    pub status: String,
}

/// What the engine control unit found of a fault.
#[derive(Debug, Clone, Deserialize)]
pub struct Found {
    /// As it was injected.
    pub fault: String,
    /// The code, if any.
    pub code: Option<String>,
    /// From the first byte of its line on the console, ms.
    pub after_ms: u64,
}

/// The loop for ten minutes with nothing wrong.
#[derive(Debug, Clone, Deserialize)]
pub struct Healthy {
    /// Commands that it followed.
    pub commands: usize,
    /// Each `status` that did not say that nothing is latched, behind its command.
    pub unsound: Vec<String>,
    /// What was counted in the controller.
    pub controller: Counted,
    /// What was counted in the throttle.
    pub throttle: Counted,
}

/// A fault at any time in the loop: while a limit switch is sought, and in both modes.
#[derive(Debug, Clone, Deserialize)]
pub struct AnyTime {
    /// What was wrong.
    pub fault: String,
    /// How often.
    pub runs: usize,
    /// The longest until the bridge was off, µs.
    pub latest_us: f64,
    /// What was latched first, and how often.
    pub named: BTreeMap<String, usize>,
    /// What was said in runs in which the drive did not move before, or did not let go.
    pub unsound: Vec<String>,
}

/// Everything that came of it.
#[derive(Debug, Clone, Deserialize)]
pub struct Outcome {
    /// Instructions that a core retires in a second.
    pub instructions_per_second: u64,
    /// The throttle by itself.
    pub throttle: Throttle,
    /// The controller's parameters over an end of power.
    pub store: Store,
    /// The loop of both.
    pub driven: Driven,
    /// The controller with one fault after the other, where that was run.
    pub faults: Option<Faults>,
    /// Its power lost in the middle of a save in an empty flash, and of one behind it, where that was
    /// run.
    pub cuts: Option<[Cuts; 2]>,
    /// The sound loop at length, where that was run.
    pub healthy: Option<Healthy>,
    /// Faults at any time, where that was run.
    pub any_time: Option<Vec<AnyTime>>,
    /// The longest interrupts of both images, where that was run.
    pub ticks: Option<Vec<Ticks>>,
    /// The controller by itself, where that was run.
    pub controller: Option<Controller>,
    /// The throttle at an engine control unit, where that was run: one a frequency of the PWM.
    pub engine: Option<Vec<Engine>>,
    /// Seconds that the emulation took on this host.
    pub wall_time_s: f64,
}

/// The two images.
#[derive(Debug, Clone)]
pub struct Images {
    /// `throttle`.
    pub throttle: Build,
    /// `controller`.
    pub controller: Build,
}

impl Images {
    /// Builds both as they are flashed.
    ///
    /// # Errors
    /// What the compiler says.
    pub fn build(toolchain: &Toolchain) -> Result<Self, Failure> {
        Ok(Self {
            throttle: toolchain.build("throttle")?,
            controller: toolchain.build("controller")?,
        })
    }
}

/// Everything that is built before anything runs.
#[derive(Debug, Clone)]
pub struct Built {
    /// The emulation.
    pub emulation: PathBuf,
    /// What runs on it.
    pub images: Images,
}

impl Built {
    /// Builds the emulation, the images and the reader of their logs, or finds them built. `announce` is told each
    /// step before it begins.
    ///
    /// # Errors
    /// What the compiler says.
    pub fn new(toolchain: &Toolchain, mut announce: impl FnMut(&str)) -> Result<Self, Failure> {
        announce(&format!(
            "the images as they are flashed, built with {}",
            toolchain.route().describe()
        ));
        let images = Images::build(toolchain)?;
        announce("the emulated chips (built once, which takes minutes)");
        let emulation = build()?;
        announce(dictionary::BUILDING);
        dictionary::build()?;
        Ok(Self { emulation, images })
    }
}

/// How much of what can be done with the images is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extent {
    /// Each alone, and both wired to a loop: under a minute.
    Loop,
    /// With faults of the chip, power that is lost and instructions of several lengths too: minutes.
    Everything,
    /// With the power lost at every operation of the flash, faults at any time, and ten minutes of a sound loop: half an hour.
    AtLength,
}

/// The emulation's names for what [`Extent::Loop`] runs.
const LOOP: &str = "pair,throttle";

/// Those for what [`Extent::AtLength`] runs.
const AT_LENGTH: &str = "every_cut,any_time,healthy,engine,pair,ticks,faults,throttle,controller";

/// Where the runs leave their logs.
pub fn directory() -> PathBuf {
    workspace::results().join("emulate")
}

/// Builds the emulation, or finds it built.
///
/// # Errors
/// What the compiler says.
pub fn build() -> Result<PathBuf, Failure> {
    EMULATION.build(EMULATION.name, "")
}

/// Tests of the emulation's own code.
///
/// # Errors
/// What fails.
pub fn test() -> Result<(), Failure> {
    EMULATION.test("")
}

/// Instructions that a core retires in a second, as the emulation is told.
pub(super) fn rate(cycles_per_instruction: f64) -> String {
    format!("{:.0}", CORE_CLOCK / cycles_per_instruction)
}

/// Runs the images.
///
/// # Errors
/// An image that ends or does not answer, and what it said instead.
pub fn run(built: &Built, cycles_per_instruction: f64, extent: Extent) -> Result<Outcome, Failure> {
    let Built { emulation, images } = built;
    let directory = directory();
    std::fs::create_dir_all(&directory)
        .map_err(|error| Failure::system(directory.display(), &error))?;
    let mut command = clean_command(emulation);
    match extent {
        Extent::Loop => command.arg(LOOP),
        Extent::Everything => &mut command,
        Extent::AtLength => command.arg(AT_LENGTH),
    };
    let output = command
        .args([&images.throttle.elf, &images.controller.elf, &directory])
        .arg(rate(cycles_per_instruction))
        .output()
        .map_err(|error| Failure::system(emulation.display(), &error))?;
    if !output.status.success() {
        return Err(Failure::Other(format!(
            "the images do not run on the emulated chips\n{}",
            String::from_utf8_lossy(&output.stderr).trim_end()
        )));
    }
    serde_json::from_slice(&output.stdout)
        .map_err(|error| Failure::Other(format!("what the emulation reports: {error}")))
}
