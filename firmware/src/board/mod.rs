//! The boards, the only files that know hardware, and what they share.

use crate::app::wiring::Wiring;
use crate::app::work::{ControlWork, PlantWork};

pub mod deadline;
#[cfg(all(feature = "stm32f405", target_os = "none"))]
pub mod interrupts;
pub mod load;
#[cfg(all(feature = "stm32f405", target_os = "none"))]
pub mod stm32f405;
#[cfg(target_os = "none")]
pub mod tape_flash;

/// The result of a future that never waits: flash whose operations end before they return.
#[cfg(all(feature = "stm32f405", target_os = "none"))]
fn now<T>(future: impl Future<Output = T>) -> T {
    use core::pin::pin;
    use core::task::{Context, Poll, Waker};

    let mut future = pin!(future);
    loop {
        if let Poll::Ready(result) = future
            .as_mut()
            .poll(&mut Context::from_waker(Waker::noop()))
        {
            return result;
        }
    }
}

/// What the application asks of a board.
pub trait Board {
    /// Gives the interrupts their work and starts the clock. Called once.
    ///
    /// From then on the board calls [`PlantWork::tick`] every
    /// [`PLANT_PERIOD_US`](crate::app::timing::PLANT_PERIOD_US) in its most urgent interrupt, and
    /// [`ControlWork::step`], where there is a control, in the next one whenever the tick says so. A
    /// tick that comes late by half a period or more, or not at all, it reports to the fault latch of
    /// `wiring`.
    fn start(
        &mut self,
        plant: &'static mut dyn PlantWork,
        control: Option<&'static mut dyn ControlWork>,
        wiring: &'static Wiring,
    );

    /// What the processor has done since the start.
    fn work() -> Work;
}

/// What a processor has done, in cycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Work {
    /// All of it, idling included.
    pub all: u64,
    /// The share of the plant's and the control interrupt.
    pub interrupts: u64,
}

impl Work {
    /// What was done since an earlier time, interrupts left out.
    pub fn below_interrupts_since(&self, earlier: &Self) -> u64 {
        (self.all - earlier.all).saturating_sub(self.interrupts - earlier.interrupts)
    }
}
