//! An STM32F405 as QEMU's machine `netduinoplus2` emulates it: the processor, its memories and
//! its core peripherals, but no clock tree. So no HAL: SysTick is clock and plant interrupt in
//! one, PendSV the control interrupt, two idle interrupt lines the tasks' executors, semihosting
//! the log and the way out.
//!
//! What it cannot show: converters and timers, as there are none, and cycles, as an instruction takes
//! 8 ns here whatever it is. Counts of instructions are exact.

use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m_rt::{ExceptionFrame, exception};
use defmt_semihosting as _;
use embassy_executor::{InterruptExecutor, SendSpawner};
use static_cell::ConstStaticCell;
use systick_timer::SystickDriver;

use super::interrupts::{self, Plant, Slot};
use super::{Board, Work, tape_flash};
use crate::app::ecu;
use crate::app::ecu::session::Trials;
use crate::app::experiment::Experiment;
use crate::app::memory::Memory;
use crate::app::playback::{self, Player};
use crate::app::session::{self, Records, Session};
use crate::app::timing::PLANT_PERIOD_US;
use crate::app::wiring::Wiring;
use crate::app::work::{ControlWork, PlantWork};

/// Core clock of the emulated machine, Hz.
const CORE_CLOCK: u32 = 168_000_000;

/// SysTick counts in a plant period.
const TICK_COUNTS: u32 = CORE_CLOCK / 1_000_000 * PLANT_PERIOD_US;

embassy_time_driver::time_driver_impl!(
    // Four tasks may wait; one more would panic.
    static CLOCK: SystickDriver<4> = SystickDriver::new(CORE_CLOCK as u64, TICK_COUNTS - 1)
);

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

static PLANT: Slot<Plant> = Slot::new();

/// The board.
pub struct Emulated {
    core: Peripherals,
}

impl Emulated {
    /// The board, the first time it is asked for.
    fn take() -> Option<Self> {
        Peripherals::take().map(|core| Self { core })
    }

    /// Starts the two executors for tasks, both below the control step: one above the other.
    fn start_executors(&mut self) -> (SendSpawner, SendSpawner) {
        // SAFETY: no critical section depends on priorities.
        unsafe {
            self.core.NVIC.set_priority(RECORD_LINE, 0x80);
            self.core.NVIC.set_priority(SESSION_LINE, 0xC0);
        }
        let above = RECORD_EXECUTOR.start(RECORD_LINE);
        let below = SESSION_EXECUTOR.start(SESSION_LINE);
        (above, below)
    }
}

/// Ends the emulation with status 0, or 1 if something was not in order.
pub fn exit(sound: bool) -> ! {
    semihosting::process::exit(i32::from(!sound))
}

impl Board for Emulated {
    const WORK: &'static str = "instructions";

    fn start(
        &mut self,
        plant: &'static mut dyn PlantWork,
        control: Option<&'static mut dyn ControlWork>,
        wiring: &'static Wiring,
    ) {
        let period = PLANT_PERIOD_US * 1000;
        PLANT.put(Plant::new(plant, wiring, period));
        interrupts::start_control(control, stopwatch::nanoseconds, &mut self.core.SCB);
        // SAFETY: no critical section depends on priorities.
        unsafe { self.core.SCB.set_priority(SystemHandler::SysTick, 0x00) }
        stopwatch::start();
        CLOCK.start(&mut self.core.SYST);
    }

    fn work() -> Work {
        let instruction = u64::from(stopwatch::INSTRUCTION);
        let loads = interrupts::loads();
        Work {
            all: embassy_time::Instant::now().as_micros() * 1000 / instruction,
            interrupts: (loads.plant.sum() + loads.control.sum()) / instruction,
        }
    }
}

#[exception]
fn SysTick() {
    let start = stopwatch::nanoseconds();
    CLOCK.systick_interrupt();
    PLANT.with(|plant| plant.tick(start));
    interrupts::account_plant(stopwatch::nanoseconds().wrapping_sub(start));
}

/// TIM2, which in the emulated machine counts nanoseconds. Unlike a count of SysTick interrupts it
/// loses nothing while they are masked.
pub mod stopwatch {
    /// Nanoseconds that an instruction takes, whichever it is: `-icount shift=3`.
    pub const INSTRUCTION: u32 = 8;

    const TIM2: usize = 0x4000_0000;
    /// Control register 1; bit 0 enables the counter.
    const CR1: *mut u32 = TIM2 as *mut u32;
    /// The counter, 32 bit.
    const CNT: *const u32 = (TIM2 + 0x24) as *const u32;

    /// Starts it.
    pub fn start() {
        // SAFETY: a register of TIM2, which nothing else uses.
        unsafe { CR1.write_volatile(1) }
    }

    /// Its count: wraps every 4.3 s.
    #[inline(always)]
    pub fn nanoseconds() -> u32 {
        // SAFETY: a register of TIM2 whose reading has no effect.
        unsafe { CNT.read_volatile() }
    }
}

/// How deep the stack has ever been: it is painted, and what is no longer of that colour was used.
mod stack {
    use cortex_m::register::msp;

    /// The beginning of the RAM: `flip-link` puts the stack there, below the variables.
    const END: *mut u32 = 0x2000_0000 as *mut u32;

    /// Hardly what a program leaves there.
    const PAINT: u32 = 0xA5C3_965A;

    /// What the frame of the painting itself has at most, bytes.
    const OWN: u32 = 256;

    unsafe extern "C" {
        /// Where the stack begins, from cortex-m-rt's linker script.
        static _stack_start: u32;
    }

    /// Paints what is free. Nothing may interrupt it.
    pub fn paint() {
        let free = msp::read() - OWN - END as u32;
        for word in 0..free as usize / 4 {
            // SAFETY: from the stack's end up to below this frame, which nothing else uses.
            unsafe { END.add(word).write_volatile(PAINT) }
        }
    }

    /// Bytes of it.
    pub fn room() -> u32 {
        // The address alone is taken.
        &raw const _stack_start as u32 - END as u32
    }

    /// Bytes that have been used.
    pub fn used() -> u32 {
        let words = room() as usize / 4;
        // SAFETY: within the stack; whatever is there is a word.
        let painted = |word: &usize| unsafe { END.add(*word).read_volatile() } == PAINT;
        room() - 4 * (0..words).take_while(painted).count() as u32
    }
}

/// An interrupt line that the emulated machine leaves idle, to carry an executor.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Line(u16);

// SAFETY: the two numbers below are constant and lines of the STM32F405.
unsafe impl InterruptNumber for Line {
    fn number(self) -> u16 {
        self.0
    }
}

const RECORD_LINE: Line = Line(80);
const SESSION_LINE: Line = Line(81);

static RECORD_EXECUTOR: InterruptExecutor = InterruptExecutor::new();
static SESSION_EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Runs the experiments, with the recording's executor above the session's, and at last `end` with
/// what [`Session::run`] says of them.
///
/// # Panics
/// If it is called twice.
pub fn run(experiments: &'static [Experiment], end: fn(bool) -> !) -> ! {
    static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::new());
    stack::paint();
    let mut board = defmt::unwrap!(Emulated::take());
    let (above, below) = board.start_executors();
    let (session, records) = session::start(&mut board, MEMORY.take());
    above.spawn(defmt::unwrap!(record(records)));
    below.spawn(defmt::unwrap!(perform(session, experiments, end)));
    idle()
}

/// Runs the trials of the emulated engine controller, and at last `end` with what [`Trials::run`]
/// says of them.
///
/// # Panics
/// If it is called twice.
pub fn run_trials(end: fn(bool) -> !) -> ! {
    let mut board = defmt::unwrap!(Emulated::take());
    let (above, _) = board.start_executors();
    let trials = ecu::session::start(&mut board);
    above.spawn(defmt::unwrap!(try_out(trials, end)));
    idle()
}

/// Plays the recorded drive behind the program, and at last `end` with what [`Player::run`] says of
/// it; false where there is nothing to play.
///
/// # Panics
/// If it is called twice.
pub fn play(end: fn(bool) -> !) -> ! {
    let mut board = defmt::unwrap!(Emulated::take());
    let (above, _) = board.start_executors();
    match playback::start(&mut board, tape_flash::bytes()) {
        Some(player) => above.spawn(defmt::unwrap!(log_replay(player, end))),
        None => end(false),
    }
    idle()
}

/// Idle, it spins. embassy's executor for a main thread sleeps by WFE, which makes QEMU leave
/// translated code each time round and takes it several times as long. WFI would cost nothing, but
/// QEMU then lets host time pass for the sleep, and no two runs are the same.
fn idle() -> ! {
    #[expect(
        clippy::empty_loop,
        reason = "a spin loop's YIELD costs QEMU what WFE does"
    )]
    loop {}
}

#[embassy_executor::task]
async fn try_out(mut trials: Trials, end: fn(bool) -> !) {
    let sound = trials.run().await;
    let loads = interrupts::loads();
    let instructions = |duration: u32| duration / stopwatch::INSTRUCTION;
    defmt::info!(
        "cost plant_worst={=u32} plant_mean={=u32} control_worst={=u32} control_mean={=u32} instructions",
        instructions(loads.plant.worst()),
        instructions(loads.plant.mean()),
        instructions(loads.control.worst()),
        instructions(loads.control.mean())
    );
    end(sound)
}

#[embassy_executor::task]
async fn log_replay(player: Player, end: fn(bool) -> !) {
    end(player.run().await)
}

#[embassy_executor::task]
async fn record(records: Records) -> ! {
    session::record(records).await
}

#[embassy_executor::task]
async fn perform(mut session: Session, experiments: &'static [Experiment], end: fn(bool) -> !) {
    let sound = session.run::<Emulated>(experiments).await;
    defmt::info!("stack used={=u32} of={=u32}", stack::used(), stack::room());
    end(sound)
}

/// Without a device's vector table every line comes here.
#[exception]
unsafe fn DefaultHandler(line: i16) {
    match u16::try_from(line).map(Line) {
        // SAFETY: each line polls its own executor, after `run` has started it.
        Ok(RECORD_LINE) => unsafe { RECORD_EXECUTOR.on_interrupt() },
        // SAFETY: as above.
        Ok(SESSION_LINE) => unsafe { SESSION_EXECUTOR.on_interrupt() },
        _ => defmt::panic!("interrupt {=i16} has no handler", line),
    }
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // Not by defmt, here and below: its logger may be the one that was interrupted.
    semihosting::eprintln!("hard fault at {:#010x}", frame.pc());
    semihosting::process::exit(1)
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    semihosting::eprintln!("{info}");
    semihosting::process::exit(1)
}
