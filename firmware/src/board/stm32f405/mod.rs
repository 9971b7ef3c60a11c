//! An STM32F405RG at 168 MHz from a crystal, logging over RTT.
//!
//! | priority | vector | runs |
//! |---|---|---|
//! | 0 | TIM7; in the `controller` ADC | the plant, or what reads a real one, every [`PLANT_PERIOD_US`] |
//! | 4 | PendSV | the control step that a plant tick asks for |
//! | 8 | TIM5 | embassy's clock |
//! | 12 | USART1, DMA2 streams 2 and 7 | bytes of the console |
//! | 14 | CAN2_SCE, a spare line | the executor for tasks that must not wait for long work |
//! | none | | the executor for long work |
//!
//! Two images are the products: the emulated [`throttle`] body and the [`controller`] of a real actuator, both
//! [operated](crate::app::operation) from a [`terminal`]. The others run something to its end and log it,
//! [`unattended`]. What each pin is for stands in [`pins`]. Whatever ends a run ends in the safe state, see
//! [`end`], and starts the processor anew; where nothing ends, the [`watchdog`] does.

use cortex_m::peripheral::{DWT, Peripherals};
use embassy_executor::{InterruptExecutor, SendSpawner};
use embassy_stm32::interrupt::{self, InterruptExt, Priority};

use super::Work;
use super::interrupts;
use crate::app::timing::PLANT_PERIOD_US;
use crate::app::work::ControlWork;
use clock::CORE_CLOCK;
use pins::Pins;

mod cache;
mod clock;
pub mod controller;
mod core_coupled;
mod critical;
pub mod end;
mod parameters;
pub mod pins;
mod probe;
mod safety;
mod stack;
mod supply;
pub mod terminal;
pub mod throttle;
mod ticker;
mod tracks;
pub mod unattended;
mod vector;
mod watchdog;

/// Core cycles in a plant period.
const PERIOD_CYCLES: u32 = CORE_CLOCK / 1_000_000 * PLANT_PERIOD_US;

defmt::timestamp!("{=u64:us}", embassy_time::Instant::now().as_micros());

/// The processor with its clocks running.
struct Chip {
    core: Peripherals,
}

impl Chip {
    /// The processor and its pins, the first time they are asked for.
    fn take() -> Option<(Self, Pins)> {
        let mut core = Peripherals::take()?;
        let pins = Pins::new(clock::start());
        cache::enable();
        interrupt::TIM5.set_priority(Priority::P8);
        core.DCB.enable_trace();
        core.DWT.set_cycle_count(0);
        core.DWT.enable_cycle_counter();
        Some((Self { core }, pins))
    }

    /// Gives the control interrupt its work.
    fn start_control(&mut self, control: Option<&'static mut dyn ControlWork>) {
        interrupts::start_control(control, DWT::cycle_count, &mut self.core.SCB);
    }

    /// Starts the executor for tasks that must not wait for long work.
    fn start_tasks(&mut self) -> SendSpawner {
        interrupt::CAN2_SCE.set_priority(Priority::P14);
        TASK_EXECUTOR.start(interrupt::CAN2_SCE)
    }
}

/// What the processor has done so far, in cycles.
fn work() -> Work {
    let loads = interrupts::loads();
    Work {
        all: embassy_time::Instant::now().as_micros() * u64::from(CORE_CLOCK / 1_000_000),
        interrupts: loads.plant.sum() + loads.control.sum(),
    }
}

/// Tells how long the interrupts have taken.
fn log_loads() {
    let loads = interrupts::loads();
    defmt::info!(
        "load plant_worst_cycles={=u32} plant_mean_cycles={=u32} control_worst_cycles={=u32} control_mean_cycles={=u32} period_cycles={=u32}",
        loads.plant.worst(),
        loads.plant.mean(),
        loads.control.worst(),
        loads.control.mean(),
        PERIOD_CYCLES
    );
}

static TASK_EXECUTOR: InterruptExecutor = InterruptExecutor::new();

#[embassy_stm32::interrupt]
fn CAN2_SCE() {
    // SAFETY: this is the executor's own interrupt, which only `start` enables.
    unsafe { TASK_EXECUTOR.on_interrupt() }
}
