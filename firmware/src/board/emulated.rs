//! An STM32F405 as QEMU's machine `netduinoplus2` emulates it: the processor, its memories and
//! its core peripherals, but no clock tree. So no HAL: SysTick is clock and plant interrupt in
//! one, PendSV the control interrupt, semihosting the log and the way out.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::Peripherals;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m_rt::{ExceptionFrame, exception};
use defmt_semihosting as _;
use embassy_executor::{Spawner, raw};
use static_cell::StaticCell;
use systick_timer::SystickDriver;

use super::Board;
use super::interrupts::{self, Plant, Slot};
use crate::app::control::Control;
use crate::app::emulate::Emulation;
use crate::app::record::Outcome;
use crate::app::timing::PLANT_PERIOD_US;
use crate::app::wiring::Wiring;

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
    pub fn take() -> Option<Self> {
        Peripherals::take().map(|core| Self { core })
    }

    /// Ends the emulation with status 0, or 1 if the run was no success.
    pub fn exit(&mut self, outcome: Outcome) -> ! {
        exit(outcome.is_success())
    }
}

/// Ends the emulation with status 0, or 1 without success.
pub fn exit(success: bool) -> ! {
    semihosting::process::exit(i32::from(!success))
}

impl Board for Emulated {
    fn start(
        &mut self,
        emulation: &'static mut Emulation,
        control: &'static mut Control,
        wiring: &'static Wiring,
    ) {
        PLANT.put(Plant::new(emulation, wiring, PLANT_PERIOD_US * 1000));
        interrupts::start_control(control, &mut self.core.SCB);
        // SAFETY: no critical section depends on priorities.
        unsafe { self.core.SCB.set_priority(SystemHandler::SysTick, 0x00) }
        stopwatch::start();
        CLOCK.start(&mut self.core.SYST);
    }
}

#[exception]
fn SysTick() {
    let now = stopwatch::nanoseconds();
    CLOCK.systick_interrupt();
    PLANT.with(|plant| plant.tick(now));
}

/// TIM2, which in the emulated machine counts nanoseconds. Unlike a count of SysTick interrupts it
/// loses nothing while they are masked.
pub mod stopwatch {
    /// Nanoseconds that an instruction takes, whichever it is.
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

/// Runs the tasks that `init` spawns.
///
/// Idle, it spins on a flag. embassy's own executor for Cortex-M sleeps by WFE, which makes QEMU
/// leave translated code each time round and takes it several times as long. WFI would cost
/// nothing, but QEMU then lets host time pass for the sleep, and no two runs are the same.
pub fn run(init: impl FnOnce(Spawner)) -> ! {
    static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
    let executor = EXECUTOR.init(raw::Executor::new(core::ptr::null_mut()));
    init(executor.spawner());
    loop {
        READY.store(false, Ordering::Relaxed);
        // SAFETY: this is the only place that polls, and `init` has returned.
        unsafe { executor.poll() };
        #[expect(
            clippy::missing_spin_loop,
            reason = "its YIELD costs QEMU what WFE does"
        )]
        while !READY.load(Ordering::Relaxed) {}
    }
}

/// Whether a task became ready since the executor last slept.
static READY: AtomicBool = AtomicBool::new(false);

#[unsafe(export_name = "__pender")]
fn pend(_executor: *mut ()) {
    READY.store(true, Ordering::Relaxed);
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
