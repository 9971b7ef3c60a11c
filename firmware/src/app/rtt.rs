//! SEGGER's RTT: rings in RAM that a debug probe reads and writes while the processor runs.
//!
//! A probe finds the [`Block`] by its name, and behind it what each ring is called, where it is and how far both
//! sides are. The log (defmt) goes up by channel 0. By channel 1 the console's answers go up and its lines come
//! down. The layout is that of `SEGGER_RTT_CB` in SEGGER's `SEGGER_RTT.h`.
//!
//! Nothing here waits for a probe, whatever mode it sets, and no number that it writes leads out of a ring. That is why no crate is
//! used: `defmt-rtt` has no channel down, and `rtt-target` waits within a critical section if a probe asks it to.

use core::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use core::sync::atomic::{AtomicU8, AtomicU32};

/// The bytes of a ring. One less than there are can wait in it.
pub type Bytes<const N: usize> = [AtomicU8; N];

/// An empty ring's bytes.
pub const fn bytes<const N: usize>() -> Bytes<N> {
    [const { AtomicU8::new(0) }; N]
}

/// What a ring is called, with a zero behind it.
pub type Name = [u8; 8];

/// A ring: `SEGGER_RTT_BUFFER_UP` or `SEGGER_RTT_BUFFER_DOWN`.
#[repr(C)]
#[derive(Debug)]
pub struct Ring<const N: usize> {
    name: Option<&'static Name>,
    bytes: Option<&'static Bytes<N>>,
    size: u32,
    /// Where the writer and the reader are. A probe moves one of them, and may make anything of both.
    pub places: [AtomicU32; 2],
    /// What is to happen when the ring is full. A probe may set it; nobody asks.
    mode: AtomicU32,
}

/// `SEGGER_RTT_MODE_NO_BLOCK_TRIM`.
const TRIM: u32 = 1;

impl<const N: usize> Ring<N> {
    /// An empty one.
    pub const fn new(name: &'static Name, bytes: &'static Bytes<N>) -> Self {
        Self::with(Some(name), Some(bytes), N as u32)
    }

    const fn with(
        name: Option<&'static Name>,
        bytes: Option<&'static Bytes<N>>,
        size: u32,
    ) -> Self {
        Self {
            name,
            bytes,
            size,
            places: [const { AtomicU32::new(0) }; 2],
            mode: AtomicU32::new(TRIM),
        }
    }

    /// Where the writer and the reader are.
    fn places(&self) -> [usize; 2] {
        self.places.each_ref().map(|place| {
            let place = place.load(Acquire) as usize;
            if place < N { place } else { 0 }
        })
    }

    const fn behind(place: usize) -> usize {
        if place + 1 < N { place + 1 } else { 0 }
    }

    /// Begins a piece of text of which the probe sees all or nothing.
    pub fn begin(&self) -> Piece {
        let [place, _] = self.places();
        Piece { place, fits: true }
    }

    /// Puts bytes behind what the piece has.
    pub fn put(&self, piece: &mut Piece, text: &[u8]) {
        for &byte in text {
            let next = Self::behind(piece.place);
            let slot = self.bytes.and_then(|bytes| bytes.get(piece.place));
            let [_, read] = self.places();
            match slot {
                Some(slot) if piece.fits && next != read => {
                    slot.store(byte, Relaxed);
                    piece.place = next;
                }
                _ => piece.fits = false,
            }
        }
    }

    /// Shows the piece to the probe, if there was room for it.
    pub fn end(&self, piece: Piece) {
        if piece.fits {
            let [written, _] = &self.places;
            written.store(piece.place as u32, Release);
        }
    }

    /// Writes as much of a text as there is room for.
    pub fn write(&self, text: &[u8]) {
        for byte in text.chunks(1) {
            let mut piece = self.begin();
            self.put(&mut piece, byte);
            self.end(piece);
        }
    }

    /// The next byte that the other side has written.
    pub fn read(&self) -> Option<u8> {
        let [written, place] = self.places();
        if place == written {
            return None;
        }
        let byte = self.bytes?.get(place)?.load(Relaxed);
        let [_, read] = &self.places;
        read.store(Self::behind(place) as u32, Release);
        Some(byte)
    }
}

/// Text on its way into a ring.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    place: usize,
    fits: bool,
}

impl Piece {
    /// None yet.
    pub const NONE: Self = Self {
        place: 0,
        fits: false,
    };
}

/// The first bytes of the block, by which a probe finds it.
const NAME: [u8; 16] = *b"SEGGER RTT\0\0\0\0\0\0";

/// What a probe looks for.
#[repr(C)]
#[derive(Debug)]
pub struct Block<const LOG: usize, const TOLD: usize, const TYPED: usize> {
    name: [u8; 16],
    up: u32,
    down: u32,
    /// The log.
    pub log: Ring<LOG>,
    /// What the console says.
    pub told: Ring<TOLD>,
    /// By channel 0 nothing comes.
    unused: Ring<1>,
    /// What the console is told.
    pub typed: Ring<TYPED>,
}

impl<const LOG: usize, const TOLD: usize, const TYPED: usize> Block<LOG, TOLD, TYPED> {
    /// With these rings.
    pub const fn new(log: Ring<LOG>, told: Ring<TOLD>, typed: Ring<TYPED>) -> Self {
        Self {
            name: NAME,
            up: 2,
            down: 2,
            log,
            told,
            unused: Ring::with(None, None, 0),
            typed,
        }
    }
}
