//! What a program that ends leaves for the next start: which fault, and a text.
//!
//! It stands in RAM that no start clears. After power-on that holds anything, so the record has a mark
//! and a checksum, and what does not check was never written.

use core::fmt::{self, Write};

use crc::{CRC_32_ISO_HDLC, Crc};

use super::Fault;

const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// First word of a record.
const MARK: u32 = u32::from_le_bytes(*b"LAST");

/// Most bytes of the text; what is longer is cut off.
pub const TEXT: usize = 120;

/// The record. Any bits are a value of it.
///
/// ```
/// use firmware::app::fault::Fault;
/// use firmware::app::fault::last_words::LastWords;
///
/// let mut left = LastWords::NONE;
/// left.write(Fault::Panic, format_args!("index {} at {}", 7, "check.rs:40"));
/// assert_eq!(left.read(), Some((Fault::Panic, "index 7 at check.rs:40")));
/// left.clear();
/// assert_eq!(left.read(), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub struct LastWords {
    mark: u32,
    fault: u32,
    length: u32,
    text: [u8; TEXT],
    checksum: u32,
}

impl LastWords {
    /// None.
    pub const NONE: Self = Self {
        mark: 0,
        fault: 0,
        length: 0,
        text: [0; TEXT],
        checksum: 0,
    };

    /// Leaves a fault and a text, of which the beginning is kept.
    pub fn write(&mut self, fault: Fault, text: fmt::Arguments<'_>) {
        *self = Self {
            mark: MARK,
            fault: fault.number(),
            ..Self::NONE
        };
        // What does not fit is cut off, and that is its only error.
        let _ = self.write_fmt(text);
        self.checksum = self.expected_checksum();
    }

    /// What was left; none if nothing was, or if it is damaged.
    pub fn read(&self) -> Option<(Fault, &str)> {
        if self.mark != MARK || self.checksum != self.expected_checksum() {
            return None;
        }
        let fault = Fault::ALL.get(usize::try_from(self.fault).ok()?)?;
        let text = self.text.get(..usize::try_from(self.length).ok()?)?;
        Some((*fault, core::str::from_utf8(text).ok()?))
    }

    /// Takes it away, so that it is not read again after the next start.
    pub fn clear(&mut self) {
        *self = Self::NONE;
    }

    fn expected_checksum(&self) -> u32 {
        let mut digest = CHECKSUM.digest();
        for word in [self.mark, self.fault, self.length] {
            digest.update(&word.to_le_bytes());
        }
        digest.update(&self.text);
        digest.finalize()
    }
}

impl Write for LastWords {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for character in text.chars() {
            let start = self.length as usize;
            let end = start + character.len_utf8();
            let place = self.text.get_mut(start..end).ok_or(fmt::Error)?;
            character.encode_utf8(place);
            self.length = end as u32;
        }
        Ok(())
    }
}
