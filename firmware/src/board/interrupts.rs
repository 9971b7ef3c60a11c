//! What the interrupts do on every board. A board supplies the vector that ticks, and the clock.

use core::cell::Cell;

use cortex_m::interrupt::Mutex;
use cortex_m::peripheral::SCB;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m_rt::exception;

use super::deadline::Deadline;
use crate::app::control::Control;
use crate::app::emulate::Emulation;
use crate::app::wiring::{Fault, Wiring};

/// Work of an interrupt, which takes it out, runs it with nothing masked, and puts it back.
pub struct Slot<T>(Mutex<Cell<Option<T>>>);

impl<T> Slot<T> {
    /// No work yet.
    pub const fn new() -> Self {
        Self(Mutex::new(Cell::new(None)))
    }

    /// Gives the interrupt its work.
    pub fn put(&'static self, work: T) {
        cortex_m::interrupt::free(|section| self.0.borrow(section).set(Some(work)));
    }

    /// Runs the work, if it is there.
    pub fn with<R>(&'static self, run: impl FnOnce(&mut T) -> R) -> Option<R> {
        let mut work = cortex_m::interrupt::free(|section| self.0.borrow(section).take())?;
        let result = run(&mut work);
        self.put(work);
        Some(result)
    }
}

/// Work of the plant interrupt.
pub struct Plant {
    emulation: &'static mut Emulation,
    wiring: &'static Wiring,
    deadline: Deadline,
}

impl Plant {
    /// With the period in counts of the clock that [`tick`](Self::tick) is told.
    pub fn new(
        emulation: &'static mut Emulation,
        wiring: &'static Wiring,
        period_counts: u32,
    ) -> Self {
        Self {
            emulation,
            wiring,
            deadline: Deadline::new(period_counts),
        }
    }

    /// One plant period; asks for a control step where one is due.
    pub fn tick(&mut self, now: u32) {
        if self.deadline.missed(now) {
            self.wiring.trip(Fault::MissedDeadline);
        }
        if self.emulation.tick() {
            SCB::set_pendsv();
        }
    }
}

static CONTROL: Slot<&'static mut Control> = Slot::new();

/// Gives the control interrupt, PendSV, its work and its priority, the second of the two.
pub fn start_control(control: &'static mut Control, core: &mut SCB) {
    CONTROL.put(control);
    // SAFETY: no critical section depends on priorities.
    unsafe { core.set_priority(SystemHandler::PendSV, 0x40) }
}

#[exception]
fn PendSV() {
    CONTROL.with(|control| control.step());
}
