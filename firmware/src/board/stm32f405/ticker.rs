//! TIM7, which ticks for an emulated plant.

use embassy_stm32::interrupt::{self, InterruptExt, Priority};
use embassy_stm32::peripherals::TIM7;
use embassy_stm32::timer::low_level::{RoundTo, Timer};
use embassy_stm32::{Peri, pac};

use crate::app::timing::PLANT_PERIOD_US;

/// Lets it tick, from now on, in the most urgent interrupt, whose work must be there.
pub fn start(timer: Peri<'static, TIM7>) {
    let timer = Timer::new(timer);
    timer.set_period_us(PLANT_PERIOD_US, RoundTo::Slower);
    timer.generate_update_event();
    timer.clear_update_interrupt();
    timer.enable_update_interrupt(true);
    timer.start();
    // Dropped, it would stand still.
    core::mem::forget(timer);
    interrupt::TIM7.set_priority(Priority::P0);
    // SAFETY: the interrupt has its work, which needs no critical section.
    unsafe { interrupt::TIM7.enable() }
}

/// Takes a tick.
pub fn acknowledge() {
    pac::TIM7.sr().write(|register| register.set_uif(false));
}
