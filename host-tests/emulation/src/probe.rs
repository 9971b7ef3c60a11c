//! The console as a debug probe reaches it while the core runs: by the rings that the image has in its RAM (RTT). They are
//! found and used as OpenOCD 0.12 does it, by the name of their block in RAM and by nothing that is known of the image.

use rigless::emulator::Memory;
use rigless::soc::Width;

use crate::chip::description::SRAM_BASE;

/// What the block begins with.
const NAME: &[u8] = b"SEGGER RTT\0\0\0\0\0\0";

/// Where it is looked for.
const SRAM_SIZE: u64 = 128 << 10;

/// Channel of the console, up and down.
const CONSOLE: u64 = 1;

/// Bytes of the block before its first ring: its name, and how many rings there are of either kind.
const HEAD: u64 = 24;

/// Bytes that describe a ring: name, buffer, size, places of writer and reader, mode.
const RING: u64 = 24;

/// A probe at a chip.
#[derive(Debug, Default)]
pub struct Probe {
    block: Option<u64>,
}

/// A ring as the block describes it.
struct Ring {
    at: u64,
    buffer: u64,
    size: u64,
    written: u64,
    read: u64,
}

impl Probe {
    /// Writes what was typed, as far as there is room for it, and reads what the console has said.
    pub fn exchange(&mut self, memory: &mut (impl Memory + ?Sized), typed: &[u8]) -> Vec<u8> {
        if !self.block.is_some_and(|block| is_block(memory, block)) {
            let places = (SRAM_BASE..SRAM_BASE + SRAM_SIZE).step_by(4);
            self.block = places.into_iter().find(|&place| is_block(memory, place));
        }
        let Some(block) = self.block else {
            return Vec::new();
        };
        let up = word(memory, block + 16);
        if up <= CONSOLE || word(memory, block + 20) <= CONSOLE {
            return Vec::new();
        }
        let rings = block + HEAD;
        type_in(memory, rings + (up + CONSOLE) * RING, typed);
        hear(memory, rings + CONSOLE * RING)
    }
}

fn is_block(memory: &mut (impl Memory + ?Sized), place: u64) -> bool {
    (place..)
        .zip(NAME)
        .all(|(place, &byte)| memory.read(place, Width::W8).ok() == Some(byte.into()))
}

fn word(memory: &mut (impl Memory + ?Sized), address: u64) -> u64 {
    memory.read(address, Width::W32).unwrap_or(0)
}

fn ring(memory: &mut (impl Memory + ?Sized), at: u64) -> Option<Ring> {
    let ring = Ring {
        at,
        buffer: word(memory, at + 4),
        size: word(memory, at + 8),
        written: word(memory, at + 12),
        read: word(memory, at + 16),
    };
    (ring.written < ring.size && ring.read < ring.size).then_some(ring)
}

fn type_in(memory: &mut (impl Memory + ?Sized), at: u64, typed: &[u8]) {
    let Some(mut ring) = ring(memory, at) else {
        return;
    };
    for &byte in typed {
        let next = (ring.written + 1) % ring.size;
        if next == ring.read {
            break;
        }
        // The ring is there: the image has described it.
        let _ = memory.write(ring.buffer + ring.written, Width::W8, byte.into());
        ring.written = next;
    }
    let _ = memory.write(ring.at + 12, Width::W32, ring.written);
}

fn hear(memory: &mut (impl Memory + ?Sized), at: u64) -> Vec<u8> {
    let Some(mut ring) = ring(memory, at) else {
        return Vec::new();
    };
    let mut heard = Vec::new();
    while ring.read != ring.written {
        let byte = memory.read(ring.buffer + ring.read, Width::W8);
        heard.push(byte.unwrap_or(0) as u8);
        ring.read = (ring.read + 1) % ring.size;
    }
    // The ring is there: it was read.
    let _ = memory.write(ring.at + 16, Width::W32, ring.read);
    heard
}
