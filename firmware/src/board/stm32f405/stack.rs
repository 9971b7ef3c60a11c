//! How deep the stack has ever been: it is painted, and what is no longer of that colour was used.

use cortex_m::register::msp;

use super::end::STACK_END;

/// The end of the stack, from where it is painted.
const END: *mut u32 = STACK_END as *mut u32;

/// Hardly what a program leaves there.
const PAINT: u32 = 0xA5C3_965A;

/// What the frame of the painting itself has at most, bytes.
const OWN: u32 = 256;

unsafe extern "C" {
    /// Where the stack begins, from cortex-m-rt's linker script.
    static _stack_start: u32;
}

/// Paints what is free. Nothing may interrupt it.
pub fn paint() {
    let free = msp::read() - OWN - STACK_END;
    for word in 0..free as usize / 4 {
        // SAFETY: from the stack's end up to below this frame, which nothing else uses.
        unsafe { END.add(word).write_volatile(PAINT) }
    }
}

/// Bytes of it.
pub fn room() -> u32 {
    // The address alone is taken.
    &raw const _stack_start as u32 - STACK_END
}

/// Bytes that have been used.
pub fn used() -> u32 {
    let words = room() as usize / 4;
    // SAFETY: within the stack; whatever is there is a word.
    let painted = |word: &usize| unsafe { END.add(*word).read_volatile() } == PAINT;
    room() - 4 * (0..words).take_while(painted).count() as u32
}
