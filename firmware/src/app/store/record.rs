//! One item of the map: a key, the generation that it belongs to, a value.
//!
//! Little endian:
//!
//! | bytes | what |
//! |---|---|
//! | 2 | the [`Key`] |
//! | 4 | generation |
//! | 4 | value: the bits of an `f32`, or a whole number |
//! | 4 | CRC-32 of the ten bytes before |
//!
//! The map has a checksum of its own for each item, and skips what fails it. The one in here covers
//! the item once more by another polynomial.

use crc::{CRC_32_ISO_HDLC, Crc};
use sequential_storage::map::{self, SerializationError};

use super::field::Field;

/// Bytes of a record.
pub(super) const BYTES: usize = 14;

/// Bytes of it before its checksum.
const BODY: usize = 10;

/// Of a record's body, and of the bodies of all records of a generation together.
pub(super) static CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// What a value is of, in its slot. There are two slots: generations take turns, so that the map
/// has the last whole one while the next is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Key(u16);

/// The bit of the key that names the slot.
const SLOT: u16 = 0x8000;

/// What a record says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Entry {
    /// Version of what the keys mean: the first of a generation.
    Schema,
    /// A field's value.
    Field(Field),
    /// Something that this firmware has no use for.
    Unknown,
    /// The checksum of the generation's records: the last, which makes it count.
    Commit,
}

impl Entry {
    const SCHEMA: u16 = 0;
    const COMMIT: u16 = 0x7fff;

    fn number(self) -> u16 {
        match self {
            Self::Schema => Self::SCHEMA,
            Self::Field(field) => field as u16,
            Self::Unknown => Self::COMMIT - 1,
            Self::Commit => Self::COMMIT,
        }
    }
}

/// One item of the map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Record {
    key: Key,
    /// The generation that it belongs to.
    pub generation: u32,
    /// Bits of an `f32`, or a whole number.
    pub value: u32,
}

impl Record {
    pub fn new(entry: Entry, generation: u32, value: u32) -> Self {
        let slot = if generation.is_multiple_of(2) {
            0
        } else {
            SLOT
        };
        Self {
            key: Key(slot | entry.number()),
            generation,
            value,
        }
    }

    pub fn key(&self) -> Key {
        self.key
    }

    pub fn entry(&self) -> Entry {
        match self.key.0 & !SLOT {
            Entry::SCHEMA => Entry::Schema,
            Entry::COMMIT => Entry::Commit,
            number => Field::numbered(number).map_or(Entry::Unknown, Entry::Field),
        }
    }

    /// What its checksum is of. A set's checksum is of this too, not of the whole records: with their
    /// checksums in it, a sequence of records has the same one whatever they say.
    pub fn body(&self) -> [u8; BODY] {
        let [k0, k1] = self.key.0.to_le_bytes();
        let [g0, g1, g2, g3] = self.generation.to_le_bytes();
        let [v0, v1, v2, v3] = self.value.to_le_bytes();
        [k0, k1, g0, g1, g2, g3, v0, v1, v2, v3]
    }

    /// As it is in flash.
    fn bytes(&self) -> [u8; BYTES] {
        let body = self.body();
        let mut bytes = [0; BYTES];
        bytes[..BODY].copy_from_slice(&body);
        bytes[BODY..].copy_from_slice(&CHECKSUM.checksum(&body).to_le_bytes());
        bytes
    }

    /// From flash; none if the checksum is not right.
    fn read(bytes: &[u8; BYTES]) -> Option<Self> {
        let [k0, k1, g0, g1, g2, g3, v0, v1, v2, v3, ..] = *bytes;
        let record = Self {
            key: Key(u16::from_le_bytes([k0, k1])),
            generation: u32::from_le_bytes([g0, g1, g2, g3]),
            value: u32::from_le_bytes([v0, v1, v2, v3]),
        };
        (record.bytes() == *bytes).then_some(record)
    }
}

/// The key is the first two bytes of the record, so that the record's checksum covers it. Beside the
/// record it takes none: the map must not cut it off, least of all from an item that is shorter.
impl map::Key for Key {
    fn serialize_into(&self, _: &mut [u8]) -> Result<usize, SerializationError> {
        Ok(0)
    }

    fn deserialize_from(buffer: &[u8]) -> Result<(Self, usize), SerializationError> {
        let key = buffer
            .first_chunk()
            .ok_or(SerializationError::BufferTooSmall)?;
        Ok((Self(u16::from_le_bytes(*key)), 0))
    }
}

impl map::Value<'_> for Record {
    fn serialize_into(&self, buffer: &mut [u8]) -> Result<usize, SerializationError> {
        *buffer
            .first_chunk_mut()
            .ok_or(SerializationError::BufferTooSmall)? = self.bytes();
        Ok(BYTES)
    }

    fn deserialize_from(buffer: &[u8]) -> Result<(Self, usize), SerializationError> {
        let bytes = buffer
            .try_into()
            .map_err(|_| SerializationError::InvalidFormat)?;
        let record = Self::read(bytes).ok_or(SerializationError::InvalidFormat)?;
        Ok((record, BYTES))
    }
}
