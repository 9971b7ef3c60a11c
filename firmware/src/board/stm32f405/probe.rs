//! What a debug probe reads and writes: the log, and the console beside its serial line.

use core::cell::UnsafeCell;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};

use critical_section::RestoreState;

use crate::app::rtt::{Block, Bytes, Piece, Ring, bytes};

/// Bytes of the log until the probe fetches it: a twentieth of a second of a board's log. The rest is the stack's.
const LOG: usize = 2048;

/// Bytes of the console's answers: 0.18 s at the serial line's pace, which they keep.
const TOLD: usize = 2048;

/// Bytes of lines: two of the longest.
const TYPED: usize = 256;

static LOG_BYTES: Bytes<LOG> = bytes();
static TOLD_BYTES: Bytes<TOLD> = bytes();
static TYPED_BYTES: Bytes<TYPED> = bytes();

/// The name that programs at a probe look for in an image.
#[unsafe(no_mangle)]
static _SEGGER_RTT: Block<LOG, TOLD, TYPED> = Block::new(
    Ring::new(b"defmt\0\0\0", &LOG_BYTES),
    Ring::new(b"console\0", &TOLD_BYTES),
    Ring::new(b"console\0", &TYPED_BYTES),
);

/// The next byte that somebody typed at the probe.
pub fn typed() -> Option<u8> {
    _SEGGER_RTT.typed.read()
}

/// Tells the probe what the console says, as far as there is room.
pub fn tell(text: &[u8]) {
    _SEGGER_RTT.told.write(text);
}

#[defmt::global_logger]
struct Logger;

/// A frame of the log on its way. A frame that does not fit is left out whole.
struct Frame {
    section: RestoreState,
    encoder: defmt::Encoder,
    piece: Piece,
}

struct Log {
    /// Whether a frame is on its way.
    taken: AtomicBool,
    frame: UnsafeCell<Frame>,
}

// SAFETY: the frame is touched between `acquire` and `release` alone, within one critical section.
unsafe impl Sync for Log {}

static LOG_FRAME: Log = Log {
    taken: AtomicBool::new(false),
    frame: UnsafeCell::new(Frame {
        section: RestoreState::invalid(),
        encoder: defmt::Encoder::new(),
        piece: Piece::NONE,
    }),
};

/// The frame on its way.
///
/// # Safety
/// Between `acquire` and `release`, which `defmt` calls in pairs, and for no longer than one of its calls.
unsafe fn frame() -> &'static mut Frame {
    // SAFETY: the critical section keeps everybody else out, as the caller says.
    unsafe { &mut *LOG_FRAME.frame.get() }
}

// SAFETY: `acquire` enters a critical section, which is left in `release`; who logs while a frame is on its way panics.
unsafe impl defmt::Logger for Logger {
    fn acquire() {
        // SAFETY: `release` leaves it.
        let section = unsafe { critical_section::acquire() };
        assert!(!LOG_FRAME.taken.swap(true, Relaxed), "a log within a log");
        // SAFETY: this is the beginning.
        let frame = unsafe { frame() };
        frame.section = section;
        frame.piece = _SEGGER_RTT.log.begin();
        let piece = &mut frame.piece;
        frame
            .encoder
            .start_frame(|bytes| _SEGGER_RTT.log.put(piece, bytes));
    }

    unsafe fn flush() {
        // A probe may never come: nothing waits for it.
    }

    unsafe fn write(bytes: &[u8]) {
        // SAFETY: `defmt` calls this behind `acquire`.
        let Frame { encoder, piece, .. } = unsafe { frame() };
        encoder.write(bytes, |bytes| _SEGGER_RTT.log.put(piece, bytes));
    }

    unsafe fn release() {
        // SAFETY: `defmt` calls this behind `acquire`.
        let frame = unsafe { frame() };
        let piece = &mut frame.piece;
        frame
            .encoder
            .end_frame(|bytes| _SEGGER_RTT.log.put(piece, bytes));
        _SEGGER_RTT.log.end(frame.piece);
        let section = frame.section;
        LOG_FRAME.taken.store(false, Relaxed);
        // SAFETY: it is that of `acquire`.
        unsafe { critical_section::release(section) };
    }
}
