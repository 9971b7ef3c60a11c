//! A recorded drive: a model, and the input that it is to be driven with.
//!
//! A tape lies in flash behind the program and is written there by whoever wants to know what the
//! model does on the chip. Little endian:
//!
//! | bytes | what |
//! |---|---|
//! | 4 | `TAPE` |
//! | 4 | length *h* of the head |
//! | *h* | the [`Head`] as postcard, with its CRC-32 behind it |
//! | 0 to 3 | zeros up to a multiple of four |
//! | 4 each | the inputs as `f32` |
//!
//! Nothing on it is believed before both checksums are right, and the model is checked like any
//! other.

use crc::{CRC_32_ISO_HDLC, Crc};
use model_core::gap::model::Model;
use model_core::plant::piecewise_affine::Parameters;
use serde::{Deserialize, Serialize};

/// First bytes of a tape.
const MARK: [u8; 4] = *b"TAPE";

/// Bytes of the mark and of the head's length.
const PREFIX: usize = 8;

/// Bytes that a head takes at most.
pub const HEAD_BYTES: usize = 1024;

/// Bytes of one input.
const INPUT_BYTES: usize = 4;

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A model that can be driven.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Driven {
    /// Of physics and effects.
    Physical(Model),
    /// Learned from input and output.
    PiecewiseAffine(Parameters),
}

/// What stands before the inputs.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Head {
    /// What is driven.
    pub model: Driven,
    /// Where it starts, at rest, rad or m.
    pub start: f32,
    /// Plant periods for which an input is held.
    pub ticks_per_input: u32,
    /// Inputs.
    pub inputs: u32,
    /// CRC-32 of the inputs' bytes.
    pub checksum: u32,
}

/// A tape that was found in order.
#[derive(Debug, Clone)]
pub struct Tape<'a> {
    /// Its head.
    pub head: Head,
    inputs: &'a [u8],
}

/// What is wrong with a tape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum TapeError {
    /// It does not begin like one: there is none.
    Missing,
    /// It ends before its head says, or is longer than the flash behind the program.
    Length,
    /// The head or its checksum is damaged.
    Head,
    /// The inputs are not those that the checksum is of.
    Inputs,
    /// An input is not finite, there is none, or none is ever held.
    Values,
}

impl core::fmt::Display for TapeError {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        formatter.write_str(match self {
            Self::Missing => "there is no tape; write one behind the program",
            Self::Length => "the tape's length is not what its head says; write it again",
            Self::Head => "the tape's head is damaged; write it again",
            Self::Inputs => "the tape's inputs are damaged; write it again",
            Self::Values => "the tape has no inputs, or one that is not finite",
        })
    }
}

impl core::error::Error for TapeError {}

/// A word of four bytes, little endian.
fn word(bytes: &[u8]) -> Option<[u8; 4]> {
    bytes.first_chunk().copied()
}

/// Bytes of mark, length and head, filled up to whole words.
const fn behind_head(head: usize) -> usize {
    (PREFIX + head).next_multiple_of(INPUT_BYTES)
}

impl<'a> Tape<'a> {
    /// Reads a tape. What lies behind it does not matter.
    ///
    /// # Errors
    /// [`TapeError`].
    pub fn read(bytes: &'a [u8]) -> Result<Self, TapeError> {
        let (mark, rest) = bytes.split_first_chunk().ok_or(TapeError::Missing)?;
        if *mark != MARK {
            return Err(TapeError::Missing);
        }
        let length = word(rest).ok_or(TapeError::Length)?;
        let length = u32::from_le_bytes(length) as usize;
        if length > HEAD_BYTES {
            return Err(TapeError::Head);
        }
        let head = bytes.get(PREFIX..PREFIX + length);
        let head = head.ok_or(TapeError::Length)?;
        let head: Head =
            postcard::from_bytes_crc32(head, CHECKSUM.digest()).map_err(|_| TapeError::Head)?;
        let inputs = (head.inputs as usize)
            .checked_mul(INPUT_BYTES)
            .and_then(|size| bytes.get(behind_head(length)..)?.get(..size))
            .ok_or(TapeError::Length)?;
        if CHECKSUM.checksum(inputs) != head.checksum {
            return Err(TapeError::Inputs);
        }
        let tape = Self { head, inputs };
        let finite = (0..tape.len()).all(|index| tape.input(index).is_finite());
        if tape.is_empty() || !finite || tape.head.ticks_per_input == 0 {
            return Err(TapeError::Values);
        }
        Ok(tape)
    }

    /// Inputs on it.
    pub fn len(&self) -> usize {
        self.inputs.len() / INPUT_BYTES
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.inputs.is_empty()
    }

    /// An input; zero beyond either end.
    #[inline]
    pub fn input(&self, index: usize) -> f32 {
        index
            .checked_mul(INPUT_BYTES)
            .and_then(|start| word(self.inputs.get(start..)?))
            .map_or(0.0, f32::from_le_bytes)
    }
}

/// Writes a tape: a model that starts at rest at `start`, and inputs that are each held for
/// `ticks_per_input` plant periods. Gives the bytes that it takes in `bytes`; none if they are too
/// few.
pub fn write<'a>(
    model: &Driven,
    start: f32,
    ticks_per_input: u32,
    inputs: &[f32],
    bytes: &'a mut [u8],
) -> Option<&'a [u8]> {
    let mut digest = CHECKSUM.digest();
    for input in inputs {
        digest.update(&input.to_le_bytes());
    }
    let head = Head {
        model: model.clone(),
        start,
        ticks_per_input,
        inputs: u32::try_from(inputs.len()).ok()?,
        checksum: digest.finalize(),
    };
    let room = bytes.get_mut(PREFIX..)?;
    let most = HEAD_BYTES.min(room.len());
    let room = &mut room[..most];
    let length = postcard::to_slice_crc32(&head, room, CHECKSUM.digest())
        .ok()?
        .len();
    let (begin, size) = (behind_head(length), inputs.len().checked_mul(INPUT_BYTES)?);
    let end = begin.checked_add(size)?;
    bytes.get_mut(PREFIX + length..begin)?.fill(0);
    let places = bytes.get_mut(begin..end)?.chunks_exact_mut(INPUT_BYTES);
    for (place, input) in places.zip(inputs) {
        place.copy_from_slice(&input.to_le_bytes());
    }
    bytes[..MARK.len()].copy_from_slice(&MARK);
    bytes[MARK.len()..PREFIX].copy_from_slice(&u32::try_from(length).ok()?.to_le_bytes());
    bytes.get(..end)
}
