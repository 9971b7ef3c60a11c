//! The plant interrupt, by whichever vector it comes: read, step, write, feed the watchdog, account.

use cortex_m::peripheral::DWT;
use embassy_stm32::interrupt;

use super::{clock, supply, watchdog};
use crate::app::wiring::Wiring;
use crate::app::work::PlantWork;
use crate::board::interrupts::{self, Plant, Slot};

/// The hardware around a plant's tick.
pub trait Edge: Send {
    /// Before it: acknowledges the interrupt, and reads.
    fn read(&mut self);

    /// Behind it: writes.
    fn write(&mut self);
}

struct PlantInterrupt {
    plant: Plant,
    wiring: &'static Wiring,
    edge: &'static mut dyn Edge,
}

static PLANT: Slot<PlantInterrupt> = Slot::new();

/// Gives the interrupt its work; `period` is in core cycles.
pub fn set(
    plant: &'static mut dyn PlantWork,
    wiring: &'static Wiring,
    edge: &'static mut dyn Edge,
    period: u32,
) {
    PLANT.put(PlantInterrupt {
        plant: Plant::new(plant, wiring, period),
        wiring,
        edge,
    });
}

/// The vector's body.
pub fn run() {
    let start = DWT::cycle_count();
    PLANT.with(|interrupt| {
        interrupt.edge.read();
        interrupt.wiring.set_processor_supply_low(supply::is_low());
        interrupt.wiring.set_clock_failed(!clock::is_from_crystal());
        interrupt.plant.tick(start);
        interrupt.edge.write();
        if interrupt.wiring.take_vouched() {
            watchdog::feed();
        }
    });
    interrupts::account_plant(DWT::cycle_count().wrapping_sub(start));
}

/// The tick of an emulated plant.
#[interrupt]
fn TIM7() {
    run();
}

/// The tick of a real one: its current and supply have been converted.
#[interrupt]
fn ADC() {
    run();
}
