//! An STM32F405RG at 168 MHz from a crystal, logging over RTT.
//!
//! | priority | vector | runs |
//! |---|---|---|
//! | 0 | TIM7 | the plant, every [`PLANT_PERIOD_US`] |
//! | 4 | PendSV | the control step that a plant tick asks for |
//! | 8 | TIM5 | embassy's clock |
//! | 12 | CAN2_SCE, a spare line | the executor for tasks that must not wait for long work |
//! | none | | the executor for long work |
//!
//! | pin | use | safe |
//! |---|---|---|
//! | PA4, PA5 | DAC: the position, 0.33 to 2.97 V over the stroke, and the same falling | both 0 V, which no position gives |
//! | PC8 | bridge enable, active high; needs a pull-down for the time before it is driven | low |
//! | PA13, PA14 | debug probe | |
//! | PH0, PH1 | crystal: 8 MHz, with the feature `crystal-12mhz` 12 MHz | |
//!
//! The DAC's output buffers, which leave 0.2 V at either end, are off: its outputs have 15 kΩ and
//! drive inputs of high impedance. Whatever ends the run ends in the safe state. The actuator here
//! is emulated, so the bridge is never enabled.

use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

use cortex_m::peripheral::{DCB, DWT, Peripherals};
use cortex_m_rt::exception;
use defmt_rtt as _;
use embassy_executor::{Executor, InterruptExecutor};
use embassy_stm32::dac::{Dac, DualValue};
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::mode::Blocking;
use embassy_stm32::peripherals::TIM7;
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::{RoundTo, Timer};
use embassy_stm32::{Config, pac, rcc};
use static_cell::StaticCell;

use super::interrupts::{self, Plant, Slot};
use super::{Board, Work};
use crate::app::experiment::Experiment;
use crate::app::record::Recording;
use crate::app::session::{self, Session};
use crate::app::timing::PLANT_PERIOD_US;
use crate::app::wiring::Wiring;
use crate::app::work::{ControlWork, PlantWork};

/// The crystal, and what divides its frequency to 2 MHz.
const CRYSTAL: (Hertz, rcc::PllPreDiv) = if cfg!(feature = "crystal-12mhz") {
    (Hertz(12_000_000), rcc::PllPreDiv::DIV6)
} else {
    (Hertz(8_000_000), rcc::PllPreDiv::DIV4)
};

/// Core clock, Hz.
const CORE_CLOCK: u32 = 168_000_000;

/// Core cycles in a plant period.
const PERIOD_CYCLES: u32 = CORE_CLOCK / 1_000_000 * PLANT_PERIOD_US;

/// 2 MHz · 168 / 2 for the core, / 7 = 48 MHz for what needs that; timers at 84 and 168 MHz.
fn configuration() -> Config {
    let (freq, prediv) = CRYSTAL;
    let mut config = Config::default();
    config.rcc.hsi = false;
    config.rcc.hse = Some(rcc::Hse {
        freq,
        mode: rcc::HseMode::Oscillator,
    });
    config.rcc.pll_src = rcc::PllSource::HSE;
    config.rcc.pll = Some(rcc::Pll {
        prediv,
        mul: rcc::PllMul::MUL168,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: Some(rcc::PllQDiv::DIV7),
        divr: None,
    });
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    // The cycle counter, and a probe that reads the log, go on while the core sleeps.
    config.enable_debug_during_sleep = true;
    config
}

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

/// Work of the plant interrupt.
struct PlantInterrupt {
    timer: Timer<'static, TIM7>,
    plant: Plant,
    wiring: &'static Wiring,
    sensor: Dac<'static, Blocking>,
}

static PLANT: Slot<PlantInterrupt> = Slot::new();

/// The board.
pub struct Stm32f405 {
    core: Peripherals,
    /// What moves to the plant interrupt when it starts.
    idle: Option<(Timer<'static, TIM7>, Dac<'static, Blocking>)>,
    _bridge_enable: Output<'static>,
}

impl Stm32f405 {
    /// The board with its clocks running and its outputs safe, the first time it is asked for.
    /// Without its crystal it waits here for ever.
    fn take() -> Option<Self> {
        let mut core = Peripherals::take()?;
        let chip = embassy_stm32::init(configuration());
        let bridge_enable = Output::new(chip.PC8, Level::Low, Speed::Low);
        let sensor = Dac::new_blocking(chip.DAC1, chip.PA4, chip.PA5);
        pac::DAC1.cr().modify(|register| {
            register.set_boff(0, true);
            register.set_boff(1, true);
        });
        interrupt::TIM5.set_priority(Priority::P8);
        core.DCB.enable_trace();
        core.DWT.set_cycle_count(0);
        core.DWT.enable_cycle_counter();
        Some(Self {
            core,
            idle: Some((Timer::new(chip.TIM7), sensor)),
            _bridge_enable: bridge_enable,
        })
    }

    /// Ends in the safe state, and tells a debug probe whether everything was in order.
    fn exit(sound: bool) -> ! {
        cortex_m::interrupt::disable();
        make_safe();
        if DCB::is_debugger_attached() {
            semihosting::process::exit(i32::from(!sound));
        }
        halt()
    }
}

impl Board for Stm32f405 {
    const WORK: &'static str = "cycles";

    fn start(
        &mut self,
        plant: &'static mut dyn PlantWork,
        control: Option<&'static mut dyn ControlWork>,
        wiring: &'static Wiring,
    ) {
        let (timer, sensor) = defmt::unwrap!(self.idle.take(), "started twice");
        interrupts::start_control(control, DWT::cycle_count, &mut self.core.SCB);
        timer.set_period_us(PLANT_PERIOD_US, RoundTo::Slower);
        timer.generate_update_event();
        timer.clear_update_interrupt();
        timer.enable_update_interrupt(true);
        timer.start();
        PLANT.put(PlantInterrupt {
            timer,
            plant: Plant::new(plant, wiring, PERIOD_CYCLES),
            wiring,
            sensor,
        });
        interrupt::TIM7.set_priority(Priority::P0);
        // SAFETY: the interrupt has its work, and no critical section depends on priorities.
        unsafe { interrupt::TIM7.enable() }
    }

    fn work() -> Work {
        let loads = interrupts::loads();
        Work {
            all: embassy_time::Instant::now().as_micros() * u64::from(CORE_CLOCK / 1_000_000),
            interrupts: loads.plant.sum() + loads.control.sum(),
        }
    }
}

#[embassy_stm32::interrupt]
fn TIM7() {
    let start = DWT::cycle_count();
    PLANT.with(|interrupt| {
        interrupt.timer.clear_update_interrupt();
        interrupt.plant.tick(start);
        let [rising, falling] = interrupt.wiring.tracks();
        interrupt.sensor.set(DualValue::Bit12Right(rising, falling));
    });
    interrupts::account_plant(DWT::cycle_count().wrapping_sub(start));
}

static RECORD_EXECUTOR: InterruptExecutor = InterruptExecutor::new();

/// Runs the experiments, with the recording's executor above the session's and both below the control
/// step, logs how long the interrupts took and ends in the safe state. A debug probe is told whether
/// everything was in order.
///
/// # Panics
/// If it is called twice.
pub fn run(experiments: &'static [Experiment]) -> ! {
    static EXECUTOR: StaticCell<Executor> = StaticCell::new();
    let mut board = defmt::unwrap!(Stm32f405::take());
    interrupt::CAN2_SCE.set_priority(Priority::P12);
    let above = RECORD_EXECUTOR.start(interrupt::CAN2_SCE);
    EXECUTOR.init(Executor::new()).run(|below| {
        let (session, recording) = session::start(&mut board);
        above.spawn(defmt::unwrap!(record(recording)));
        below.spawn(defmt::unwrap!(perform(session, experiments)));
    })
}

#[embassy_executor::task]
async fn record(recording: Recording) -> ! {
    session::record(recording).await
}

#[embassy_executor::task]
async fn perform(mut session: Session, experiments: &'static [Experiment]) {
    let sound = session.run::<Stm32f405>(experiments).await;
    let loads = interrupts::loads();
    defmt::info!(
        "load plant_worst_cycles={=u32} plant_mean_cycles={=u32} control_worst_cycles={=u32} control_mean_cycles={=u32} period_cycles={=u32}",
        loads.plant.worst(),
        loads.plant.mean(),
        loads.control.worst(),
        loads.control.mean(),
        PERIOD_CYCLES
    );
    Stm32f405::exit(sound)
}

#[embassy_stm32::interrupt]
fn CAN2_SCE() {
    // SAFETY: this is the executor's own interrupt, which only `start` enables.
    unsafe { RECORD_EXECUTOR.on_interrupt() }
}

/// Bridge off, both tracks at 0 V. Touches registers alone, so it does what it can in any state.
fn make_safe() {
    pac::GPIOC.bsrr().write(|register| register.set_br(8, true));
    pac::DAC1.dhr12rd().write(|_| ());
}

/// Nothing any more, with every interrupt masked.
fn halt() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// A fault of the processor. A stack that has overflowed leaves nowhere to push to, so this begins
/// on an empty one.
// SAFETY: the name is the vector's; the stack is not used again, since this never returns.
#[unsafe(export_name = "HardFault")]
#[unsafe(naked)]
unsafe extern "C" fn hard_fault() -> ! {
    core::arch::naked_asm!(
        "movw r0, #:lower16:_stack_start",
        "movt r0, #:upper16:_stack_start",
        "msr msp, r0",
        "b {end}",
        end = sym end_in_hard_fault,
    )
}

extern "C" fn end_in_hard_fault() -> ! {
    cortex_m::interrupt::disable();
    make_safe();
    halt()
}

/// An interrupt that nobody serves.
#[exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    panic!("interrupt {number} has no handler")
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    static PANICKED: AtomicBool = AtomicBool::new(false);
    cortex_m::interrupt::disable();
    make_safe();
    // The logger panics if it is the one that was interrupted.
    if !PANICKED.load(Relaxed) {
        PANICKED.store(true, Relaxed);
        defmt::error!("{}", defmt::Display2Format(info));
    }
    // A probe stops here with a backtrace; without one it is `HardFault` that halts.
    cortex_m::asm::udf()
}
