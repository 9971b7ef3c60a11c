//! The flash behind the program, where a recorded drive lies: sectors 9 to 11 of the STM32F405.

use core::ptr::addr_of;

// Symbols of memory.x.
unsafe extern "C" {
    static _tape: u8;
    static _tape_end: u8;
}

/// All of it, whatever is written there.
pub fn bytes() -> &'static [u8] {
    let (begin, end) = (addr_of!(_tape), addr_of!(_tape_end));
    // SAFETY: the region is flash that the program never writes; any byte is a valid u8.
    unsafe { core::slice::from_raw_parts(begin, end as usize - begin as usize) }
}
