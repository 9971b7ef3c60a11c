//! The onboard log in the core-coupled memory, so that the RAM is the stack's.

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;

use static_cell::ConstStaticCell;

use crate::app::memory::Memory;

/// Core-coupled memory, which no start clears.
struct CoreCoupled(UnsafeCell<MaybeUninit<Memory>>);

// SAFETY: it is given away once.
unsafe impl Sync for CoreCoupled {}

/// 60 of the 64 KB.
#[unsafe(link_section = ".ccm.MEMORY")]
static MEMORY: CoreCoupled = CoreCoupled(UnsafeCell::new(MaybeUninit::uninit()));

/// The log, empty.
///
/// # Panics
/// If it is called twice.
pub fn memory() -> &'static mut Memory {
    static TAKEN: ConstStaticCell<()> = ConstStaticCell::new(());
    TAKEN.take();
    let memory = MEMORY.0.get();
    // SAFETY: nobody else has it. It is made of whole numbers, so zeros are a value of it, the empty log;
    // a value that is built and then moved would need as much of the stack.
    unsafe {
        memory.write_bytes(0, 1);
        (*memory).assume_init_mut()
    }
}
