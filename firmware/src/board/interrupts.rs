//! What the interrupts do on every board. A board supplies the vector that ticks, and the clock.

use core::cell::Cell;

use cortex_m::interrupt::Mutex;
use cortex_m::peripheral::SCB;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m_rt::exception;

use super::deadline::Deadline;
use super::load::Load;
use crate::app::fault::Fault;
use crate::app::wiring::Wiring;
use crate::app::work::{ControlWork, PlantWork};

/// Work of an interrupt, which takes it out, runs it with nothing masked, and puts it back.
pub(super) struct Slot<T>(Mutex<Cell<Option<T>>>);

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

/// How long the two interrupts take, in counts of the board's clock.
#[derive(Debug, Clone, Copy, Default)]
pub struct Loads {
    /// The plant interrupt.
    pub plant: Load,
    /// The control interrupt.
    pub control: Load,
}

static LOADS: Mutex<Cell<Loads>> = Mutex::new(Cell::new(Loads {
    plant: Load::new(),
    control: Load::new(),
}));

/// How long the two interrupts have taken so far.
pub fn loads() -> Loads {
    cortex_m::interrupt::free(|section| LOADS.borrow(section).get())
}

fn account(add: impl FnOnce(&mut Loads)) {
    cortex_m::interrupt::free(|section| {
        let loads = LOADS.borrow(section);
        let mut sums = loads.get();
        add(&mut sums);
        loads.set(sums);
    });
}

/// A free-running counter.
pub(super) type Clock = fn() -> u32;

/// Work of the plant interrupt.
pub(super) struct Plant {
    plant: &'static mut dyn PlantWork,
    wiring: &'static Wiring,
    deadline: Deadline,
}

impl Plant {
    /// With the period in counts of the clock.
    pub fn new(
        plant: &'static mut dyn PlantWork,
        wiring: &'static Wiring,
        period_counts: u32,
    ) -> Self {
        Self {
            plant,
            wiring,
            deadline: Deadline::new(period_counts),
        }
    }

    /// One plant period, whose interrupt began at `start`; asks for a control step where one is due.
    pub fn tick(&mut self, start: u32) {
        // Each tick is looked at, also while lateness is no fault.
        if self.deadline.missed(start) && !self.wiring.is_stalled() {
            self.wiring.trip(Fault::MissedDeadline);
        }
        if self.plant.tick() {
            SCB::set_pendsv();
        }
    }
}

/// Accounts for a plant interrupt of this duration, in counts of the board's clock. The last that its
/// vector does, so that nothing of what it did goes uncounted.
pub(super) fn account_plant(duration: u32) {
    account(|loads| loads.plant.add(duration));
}

static CONTROL: Slot<(&'static mut dyn ControlWork, Clock)> = Slot::new();

/// Gives the control interrupt, PendSV, its work and its priority, the second of the two.
pub(super) fn start_control(
    control: Option<&'static mut dyn ControlWork>,
    clock: Clock,
    core: &mut SCB,
) {
    if let Some(control) = control {
        CONTROL.put((control, clock));
    }
    // SAFETY: no critical section is open.
    unsafe { core.set_priority(SystemHandler::PendSV, 0x40) }
}

#[exception]
fn PendSV() {
    CONTROL.with(|(control, clock)| {
        let start = clock();
        control.step();
        // The plant ticks within it count too. Before the first of them the duty has to be there.
        let duration = clock().wrapping_sub(start);
        account(|loads| loads.control.add(duration));
    });
}
