//! RTT (SEGGER's Real-Time Transfer) as a debug probe uses it: two rings in a chip's RAM are read and written while the
//! program of the chip runs. The chip is neither reset nor halted for it.
//!
//! The layout is that of `SEGGER_RTT_CB` in SEGGER's `SEGGER_RTT.h`, with pointers of 32 bits. Nothing is known of the image:
//! the block that describes the rings is found by its name, and looked at anew in each exchange, for the chip may start
//! again, or may be flashed with another image.
//!
//! The program at a real probe (`host-tests/probe`) and the emulated chip (`host-tests/emulation`) both run this code.

mod serve;

use std::ops::Range;

pub use serve::{FAILURES, PERIOD, serve};

/// What the block begins with.
const NAME: &[u8; 16] = b"SEGGER RTT\0\0\0\0\0\0";

/// Bytes of the block before its first ring: its name, and how many rings there are up and down.
const HEAD: usize = 24;

/// Bytes that describe a ring: name, buffer, size, places of the writer and the reader, mode.
const RING: usize = 24;

/// Where in a ring's description the place of the writer is, and that of the reader.
const WRITTEN: u32 = 12;
const READ: u32 = 16;

/// Most rings of a direction that a block is believed to have.
const MOST_RINGS: u32 = 16;

/// A chip's memory as a probe reaches it, in the byte order of the chip (little-endian).
pub trait Memory {
    /// Why it cannot be reached.
    type Error;

    /// Reads bytes.
    ///
    /// # Errors
    /// A chip that does not answer.
    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<(), Self::Error>;

    /// Writes bytes. Four bytes at a multiple of four are written at once: the chip sees all of them or none.
    ///
    /// # Errors
    /// A chip that does not answer.
    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<(), Self::Error>;
}

/// A channel: the ring of this number up, to the host, and the ring of this number down, to the chip.
#[derive(Debug)]
pub struct Channel {
    ram: Range<u32>,
    number: u32,
    block: Option<Block>,
}

/// A block that was found: where it is, and how many rings up it has.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Block {
    at: u32,
    up: u32,
}

/// A ring as its block describes it.
#[derive(Debug)]
struct Ring {
    /// Where the description is.
    at: u32,
    buffer: u32,
    size: u32,
    written: u32,
    read: u32,
}

impl Channel {
    /// The channel of this number of a block that lies in this RAM.
    pub fn new(ram: Range<u32>, number: u32) -> Self {
        Self {
            ram,
            number,
            block: None,
        }
    }

    /// Looks for the block in the whole RAM. False if there is none that has this channel in both directions.
    ///
    /// # Errors
    /// A chip that does not answer.
    pub fn find<M: Memory>(&mut self, memory: &mut M) -> Result<bool, M::Error> {
        let mut bytes = vec![0; self.ram.len()];
        memory.read(self.ram.start, &mut bytes)?;
        let places = (0..bytes.len()).step_by(4);
        self.block = places
            .zip(self.ram.clone().step_by(4))
            .find_map(|(place, at)| block(bytes.get(place..place + HEAD)?, at, self.number));
        Ok(self.block.is_some())
    }

    /// Takes from `typed` what the ring down has room for and gives what is in the ring up. What is typed while there is no
    /// block is lost: nobody listens then.
    ///
    /// # Errors
    /// A chip that does not answer. What was to be typed and read is still there then.
    pub fn exchange<M: Memory>(
        &mut self,
        memory: &mut M,
        typed: &mut Vec<u8>,
    ) -> Result<Vec<u8>, M::Error> {
        if self.block.is_none() {
            self.find(memory)?;
        }
        let Some(found) = self.block else {
            typed.clear();
            return Ok(Vec::new());
        };
        let down = found.up + self.number;
        let mut bytes = vec![0; HEAD + RING * (down as usize + 1)];
        memory.read(found.at, &mut bytes)?;
        if block(&bytes[..HEAD], found.at, self.number) != Some(found) {
            // Another image, or a chip that has just lost its power: it is looked for in the next exchange.
            self.block = None;
            typed.clear();
            return Ok(Vec::new());
        }
        if let Some(ring) = self.ring(found, &bytes, down) {
            let count = ring.put(memory, typed)?;
            typed.drain(..count);
        }
        match self.ring(found, &bytes, self.number) {
            Some(ring) => ring.take(memory),
            None => Ok(Vec::new()),
        }
    }

    /// A ring of a block by its number there, if what describes it can be true.
    fn ring(&self, block: Block, bytes: &[u8], number: u32) -> Option<Ring> {
        let at = HEAD as u32 + RING as u32 * number;
        let word = |offset: u32| word(bytes, (at + offset) as usize);
        let ring = Ring {
            at: block.at + at,
            buffer: word(4),
            size: word(8),
            written: word(WRITTEN),
            read: word(READ),
        };
        let end = ring.buffer.checked_add(ring.size)?;
        let in_ram = ring.buffer >= self.ram.start && end <= self.ram.end;
        (in_ram && ring.written < ring.size && ring.read < ring.size).then_some(ring)
    }
}

impl Ring {
    /// Puts in what there is room for; gives how many bytes that is. A ring holds one byte less than its size.
    fn put<M: Memory>(&self, memory: &mut M, typed: &[u8]) -> Result<usize, M::Error> {
        let room = (self.size + self.read - self.written - 1) % self.size;
        let count = typed.len().min(room as usize);
        if count == 0 {
            return Ok(0);
        }
        let before_end = (count as u32).min(self.size - self.written);
        let (first, second) = typed[..count].split_at(before_end as usize);
        memory.write(self.buffer + self.written, first)?;
        if !second.is_empty() {
            memory.write(self.buffer, second)?;
        }
        // Last: only then may the chip read them.
        let written = (self.written + count as u32) % self.size;
        memory.write(self.at + WRITTEN, &written.to_le_bytes())?;
        Ok(count)
    }

    /// Takes everything out.
    fn take<M: Memory>(&self, memory: &mut M) -> Result<Vec<u8>, M::Error> {
        let count = (self.size + self.written - self.read) % self.size;
        let mut heard = vec![0; count as usize];
        if count == 0 {
            return Ok(heard);
        }
        let before_end = count.min(self.size - self.read);
        let (first, second) = heard.split_at_mut(before_end as usize);
        memory.read(self.buffer + self.read, first)?;
        if !second.is_empty() {
            memory.read(self.buffer, second)?;
        }
        // Last: only then may the chip write over them.
        memory.write(self.at + READ, &self.written.to_le_bytes())?;
        Ok(heard)
    }
}

/// The block that begins with these bytes, if one does that has the channel in both directions.
fn block(head: &[u8], at: u32, number: u32) -> Option<Block> {
    let [up, down] = [word(head, 16), word(head, 20)];
    let has = |rings: u32| rings > number && rings <= MOST_RINGS;
    (head.starts_with(NAME) && has(up) && has(down)).then_some(Block { at, up })
}

fn word(bytes: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(word)
}
