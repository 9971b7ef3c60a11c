//! The critical sections of the tasks and of the logger: they mask every interrupt but the plant's and the control
//! step's.
//!
//! A frame of the log is written within one, which takes as long as it is: 1,900 instructions for a row of a
//! capture. Masked by `PRIMASK`, tick and step would wait for it. `BASEPRI` leaves out what is more urgent than
//! itself (PM0214, section 2.1.3), so whatever runs at priority 0 or 4 must not enter such a section, nor touch what
//! is kept in one: plant and control step do not log, wake no task, and share atomics, lock-free queues and
//! [`Slot`](crate::board::interrupts)s with the rest, whose few instructions mask everything.

use core::sync::atomic::{Ordering::SeqCst, compiler_fence};

use cortex_m::register::basepri;
use critical_section::{Impl, RawRestoreState, set_impl};

/// Of the eight priority bits the upper four are there: this is priority 5, and masks it and all below. The control
/// step has 4.
const TASKS: u8 = 0x50;

struct Masked;

set_impl!(Masked);

// SAFETY: there is one core, and nothing that runs while `BASEPRI` masks enters a critical section.
unsafe impl Impl for Masked {
    unsafe fn acquire() -> RawRestoreState {
        let was_open = basepri::read() == 0;
        // SAFETY: raising it breaks no section that is open.
        unsafe { basepri::write(TASKS) };
        compiler_fence(SeqCst);
        was_open
    }

    unsafe fn release(was_open: RawRestoreState) {
        compiler_fence(SeqCst);
        if was_open {
            // SAFETY: the outermost section ends.
            unsafe { basepri::write(0) };
        }
    }
}
