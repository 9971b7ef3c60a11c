//! What is done with the images, and what came of it.

use std::fs;
use std::num::NonZeroU64;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::thread;
use std::time::Instant;

use serde::Serialize;
use serde_json::{Map, Value};

use crate::board::CORE_CLOCK;
use crate::harness::Harness;
use crate::running::{Counts, Running, Setting};

mod alone;
mod any_time;
mod engine;
mod faults;
mod healthy;
mod pair;
mod power;
mod served;
mod ticks;
mod unattended;

/// How the program is called.
const USAGE: &str = "usage: emulation [serve|SCENARIO,...] THROTTLE_ELF CONTROLLER_ELF DIRECTORY [INSTRUCTIONS_PER_SECOND] | \
     emulation unattended INSTRUCTIONS_PER_SECOND ELF [TAPE ADDRESS]";

/// The controller's stored parameters, in the directory: what a run leaves and `serve` starts with.
const PARAMETERS: &str = "controller.parameters";

/// A millisecond, ns.
const MILLISECOND: u64 = 1_000_000;

/// A part of the report, by its name.
type Part = (&'static str, Value);

/// What is done, and its name.
type Scenario = (&'static str, fn(&Call) -> Result<Vec<Part>, String>);

/// What is done unless some of it is named.
const SCENARIOS: [Scenario; 7] = [
    ("engine", |call| part("engine", engine::engine(call)?)),
    ("cuts", |call| part("cuts", power::cuts(call)?)),
    ("pair", pair::pair),
    ("ticks", |call| part("ticks", ticks::ticks(call)?)),
    ("faults", |call| part("faults", faults::faults(call)?)),
    ("throttle", |call| part("throttle", alone::throttle(call)?)),
    ("controller", |call| {
        part("controller", alone::controller(call)?)
    }),
];

/// What takes too long to be done unless it is named.
const ON_DEMAND: [Scenario; 3] = [
    ("any_time", |call| {
        part("any_time", any_time::any_time(call)?)
    }),
    ("every_cut", |call| part("cuts", power::every_cut(call)?)),
    ("healthy", |call| part("healthy", healthy::healthy(call)?)),
];

/// A part of the report that is all of a scenario's.
fn part(name: &'static str, found: impl Serialize) -> Result<Vec<Part>, String> {
    let found = serde_json::to_value(found).map_err(|error| error.to_string())?;
    Ok(vec![(name, found)])
}

/// What was counted in a run.
#[derive(Debug, Serialize)]
struct Counted {
    /// Virtual time, s.
    time_s: f64,
    instructions: u64,
    plant_ticks: u64,
    plant_ticks_missed: u64,
    /// Longest time from a plant tick to its acknowledgement by the program, µs.
    longest_latency_us: f64,
    track_writes: u64,
    resets: usize,
    /// What `FLASH_ACR` reads.
    flash_access_control: u64,
}

impl Counted {
    /// Of a throttle, which ticks by TIM7, or of a controller, which ticks by its converter.
    fn new(counts: &Counts, now: u64) -> Self {
        let [ticks, missed] = if counts.timer_ticks[0] > 0 {
            counts.timer_ticks
        } else {
            counts.conversions
        };
        Self {
            time_s: now as f64 * 1e-9,
            instructions: counts.instructions,
            plant_ticks: ticks,
            plant_ticks_missed: missed,
            longest_latency_us: counts.longest_latency as f64 * 1e-3,
            track_writes: counts.track_writes,
            resets: counts.resets,
            flash_access_control: counts.flash_access_control,
        }
    }
}

/// What the calls of all scenarios share.
struct Call {
    throttle: Setting,
    controller: Setting,
    directory: PathBuf,
}

impl Call {
    fn read(arguments: &[String]) -> Result<Self, String> {
        let (throttle, controller, directory, rate) = match arguments {
            [throttle, controller, directory] => (throttle, controller, directory, None),
            [throttle, controller, directory, rate] => {
                (throttle, controller, directory, Some(rate))
            }
            _ => return Err(USAGE.to_owned()),
        };
        let rate = rate.map_or(Ok(CORE_CLOCK), |rate| rate.parse());
        let rate = rate.ok().and_then(NonZeroU64::new).ok_or(USAGE)?;
        let setting = |elf: &str| Setting {
            elf: elf.into(),
            instructions_per_second: rate,
            parameters: None,
        };
        Ok(Self {
            throttle: setting(throttle),
            controller: setting(controller),
            directory: directory.into(),
        })
    }
}

/// Runs every scenario, or those that are named, and gives the report as JSON; or serves the controller's
/// console, without one.
///
/// # Errors
/// A call that is none, an image that ends, or one that does not answer.
pub fn run(arguments: &[String]) -> Result<String, String> {
    let (word, rest) = arguments.split_first().ok_or(USAGE)?;
    if word == "serve" {
        return served::serve(&Call::read(rest)?).map(|()| String::new());
    }
    if word == "unattended" {
        return unattended::run(rest).map(|()| String::new());
    }
    let named = |scenario: &&Scenario| word.split(',').any(|word| word == scenario.0);
    let all = ON_DEMAND.iter().chain(&SCENARIOS);
    let some: Vec<_> = all.filter(named).copied().collect();
    let (scenarios, rest) = if some.is_empty() {
        (&SCENARIOS[..], arguments)
    } else {
        (&some[..], rest)
    };
    let call = Call::read(rest)?;
    let began = Instant::now();
    let parts = work_off(scenarios, |(name, run)| {
        run(&call).map_err(|reason| format!("{name}: {reason}"))
    });
    let mut report: Map<String, Value> = parts?
        .into_iter()
        .flatten()
        .map(|(name, found)| (name.to_owned(), found))
        .collect();
    let rate = call.throttle.instructions_per_second.get();
    report.insert("instructions_per_second".to_owned(), rate.into());
    report.insert(
        "wall_time_s".to_owned(),
        began.elapsed().as_secs_f64().into(),
    );
    serde_json::to_string_pretty(&report).map_err(|error| error.to_string())
}

/// Does this with each of a list, as many at a time as there are cores, and gives what each comes to, in any order.
/// The longest ones are best the first of the list.
fn work_off<I: Sync, T: Send>(
    list: &[I],
    work: impl Fn(&I) -> Result<T, String> + Sync,
) -> Result<Vec<T>, String> {
    let next = AtomicUsize::new(0);
    let some = || {
        let mut done = Vec::new();
        while let Some(item) = list.get(next.fetch_add(1, Relaxed)) {
            done.push(work(item)?);
        }
        Ok(done)
    };
    side_by_side(cores(), some).map(|all| all.into_iter().flatten().collect())
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Does this in so many threads, and gives what each comes to.
fn side_by_side<T: Send>(
    threads: usize,
    work: impl Fn() -> Result<T, String> + Sync,
) -> Result<Vec<T>, String> {
    thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(&work)).collect();
        let parts = workers.into_iter().map(|worker| {
            let ended = worker.join();
            ended.unwrap_or_else(|_| Err("a scenario panicked".to_owned()))
        });
        parts.collect()
    })
}

fn write(directory: &Path, name: &str, bytes: &[u8]) -> Result<(), String> {
    let path = directory.join(name);
    fs::write(&path, bytes).map_err(|error| format!("{}: {error}", path.display()))
}

/// Steps until the prompt that follows an answer.
const PROMPT: &str = "\n> ";

/// How long an answer is waited for, ms of virtual time.
const PATIENCE: u64 = 3000;

/// Something that has consoles and goes on.
trait Consoles {
    /// Which one.
    type Which: Copy;

    fn console(&mut self, which: Self::Which) -> &mut Running;

    fn run_for(&mut self, time: u64) -> Result<(), String>;

    /// Types a line and waits for the prompt behind its answer, which it gives.
    fn ask(&mut self, which: Self::Which, line: &str) -> Result<String, String> {
        let before = self.console(which).heard.len();
        self.console(which).type_line(line);
        for _ in 0..PATIENCE {
            self.run_for(MILLISECOND)?;
            let said = self.console(which).transcript(before);
            if said.ends_with(PROMPT) {
                return Ok(said.trim_end_matches(PROMPT).to_owned());
            }
        }
        let said = self.console(which).transcript(before);
        Err(format!("no prompt behind {line:?}, but {said:?}"))
    }

    /// Asks for something that has to be done.
    fn order(&mut self, which: Self::Which, line: &str) -> Result<(), String> {
        let answer = self.ask(which, line)?;
        if answer.lines().any(|line| line.trim() == "ok") {
            Ok(())
        } else {
            Err(format!("{line:?} was not done: {answer:?}"))
        }
    }
}

/// A board by itself.
struct Alone(Running);

impl Consoles for Alone {
    type Which = ();

    fn console(&mut self, (): ()) -> &mut Running {
        &mut self.0
    }

    fn run_for(&mut self, time: u64) -> Result<(), String> {
        self.0.run_for(time)
    }
}

/// One of the two boards of a loop.
#[derive(Debug, Clone, Copy)]
enum Side {
    Controller,
    Throttle,
}

/// Two boards at their wires.
struct Pair {
    controller: Running,
    throttle: Running,
    harness: Harness,
}

impl Pair {
    /// The controller with this stored in its flash.
    fn storing(call: &Call, parameters: &[u8]) -> Result<Self, String> {
        let stored = Setting {
            parameters: Some(parameters.to_vec()),
            ..call.controller.clone()
        };
        Self::start(&stored, &call.throttle)
    }

    fn start(controller: &Setting, throttle: &Setting) -> Result<Self, String> {
        Ok(Self {
            controller: Running::start(controller)?,
            throttle: Running::start(throttle)?,
            harness: Harness::default(),
        })
    }
}

impl Consoles for Pair {
    type Which = Side;

    fn console(&mut self, side: Side) -> &mut Running {
        match side {
            Side::Controller => &mut self.controller,
            Side::Throttle => &mut self.throttle,
        }
    }

    fn run_for(&mut self, time: u64) -> Result<(), String> {
        let end = self.controller.now() + time;
        while self.controller.now() < end {
            self.harness
                .step(&mut self.controller, &mut self.throttle)?;
        }
        Ok(())
    }
}
