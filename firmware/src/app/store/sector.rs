//! One sector of the flash, as the map sees it: a small flash of its own, of which nothing is ever
//! erased.
//!
//! The map would erase a page to make room in it, and to repair it. Erasing is left to the store,
//! which erases whole sectors and never the one with the set in use; so here it is refused, and so
//! is writing unless the sector is open for it.

use embedded_storage_async::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use sequential_storage::cache::{Cache, Uncached};
use sequential_storage::map::{MapConfig, MapStorage};

use super::record::{self, Key};

/// Pages of a sector. The map keeps the last one free.
const PAGES: usize = 8;

/// What the map needs as a buffer: a record, in whole words.
pub(super) const BUFFER: usize = 32;

/// The map in a sector.
pub(super) type Map<'a, F> =
    MapStorage<Key, Sector<'a, F>, Cache<Uncached, Uncached, Uncached, Key>>;

/// Whether the map may write.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Access {
    /// It may not.
    Read,
    /// It may.
    Append,
}

/// A sector.
pub(super) struct Sector<'a, F> {
    flash: &'a mut F,
    start: u32,
    access: Access,
}

/// Why the map did not get what it asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum SectorError {
    /// The flash did not do it.
    Flash(NorFlashErrorKind),
    /// It would have erased, or written where it may only read.
    Refused,
}

impl NorFlashError for SectorError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Flash(kind) => *kind,
            Self::Refused => NorFlashErrorKind::Other,
        }
    }
}

impl<'a, F: NorFlash> Sector<'a, F> {
    /// Bytes of a word, of which flash is read and written in whole.
    const WORD: usize = if F::WRITE_SIZE > F::READ_SIZE {
        F::WRITE_SIZE
    } else {
        F::READ_SIZE
    };

    const PAGE: usize = F::ERASE_SIZE / PAGES;

    /// Bytes of an item: the map's head and a record.
    const ITEM: usize =
        Map::<F>::item_overhead_size() as usize + record::BYTES.next_multiple_of(Self::WORD);

    /// Items of a page, between the words that mark its beginning and its end.
    const ITEMS: usize = (Self::PAGE - 2 * Self::WORD) / Self::ITEM;

    /// Records that a sector takes before the map would erase.
    pub const CAPACITY: usize = Self::ITEMS * (PAGES - 1);

    /// The sector that begins at `start` in the flash.
    pub fn new(flash: &'a mut F, start: u32, access: Access) -> Self {
        const {
            assert!(
                F::ERASE_SIZE.is_multiple_of(PAGES * BUFFER) && BUFFER.is_multiple_of(Self::WORD),
                "a sector is made of pages, and a page of words"
            );
        }
        Self {
            flash,
            start,
            access,
        }
    }

    /// The map in it.
    pub fn map(self) -> Map<'a, F> {
        let config = const { MapConfig::new(0..F::ERASE_SIZE as u32) };
        MapStorage::new(self, config, Cache::new_uncached())
    }

    /// Whether nothing was ever written behind the first `items` items, not even in part, and each
    /// page's marks are wholly there or not at all.
    pub async fn is_blank_behind(&mut self, items: usize) -> Result<bool, SectorError> {
        let (full, rest) = (items / Self::ITEMS, items % Self::ITEMS);
        for page in 0..PAGES {
            let begin = page * Self::PAGE;
            let end = begin + Self::PAGE - Self::WORD;
            let used = match page {
                page if page < full => Self::PAGE - 2 * Self::WORD,
                page if page == full => rest * Self::ITEM,
                _ => 0,
            };
            let first = begin + Self::WORD;
            let blank = self.is_whole_mark(begin).await?
                && self.is_all(0xff, first + used, end).await?
                && self.is_whole_mark(end).await?;
            if !blank {
                return Ok(false);
            }
        }
        Ok(true)
    }

    async fn is_whole_mark(&mut self, at: usize) -> Result<bool, SectorError> {
        let end = at + Self::WORD;
        Ok(self.is_all(0xff, at, end).await? || self.is_all(0, at, end).await?)
    }

    /// Whether it is erased throughout.
    pub async fn is_blank(&mut self) -> Result<bool, SectorError> {
        self.is_all(0xff, 0, F::ERASE_SIZE).await
    }

    async fn is_all(&mut self, byte: u8, begin: usize, end: usize) -> Result<bool, SectorError> {
        let mut buffer = [0; BUFFER];
        for at in (begin..end).step_by(BUFFER) {
            let chunk = &mut buffer[..BUFFER.min(end - at)];
            self.read(at as u32, chunk).await?;
            if chunk.iter().any(|read| *read != byte) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Where it lies in the flash, if it lies in the sector.
    fn address(&self, offset: u32, length: usize) -> Result<u32, SectorError> {
        let end = (offset as usize).checked_add(length);
        if end.is_some_and(|end| end <= F::ERASE_SIZE) {
            Ok(self.start + offset)
        } else {
            Err(SectorError::Flash(NorFlashErrorKind::OutOfBounds))
        }
    }
}

fn failed(error: impl NorFlashError) -> SectorError {
    SectorError::Flash(error.kind())
}

impl<F> ErrorType for Sector<'_, F> {
    type Error = SectorError;
}

impl<F: NorFlash> ReadNorFlash for Sector<'_, F> {
    const READ_SIZE: usize = F::READ_SIZE;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), SectorError> {
        let address = self.address(offset, bytes.len())?;
        self.flash.read(address, bytes).await.map_err(failed)
    }

    fn capacity(&self) -> usize {
        F::ERASE_SIZE
    }
}

impl<F: NorFlash> NorFlash for Sector<'_, F> {
    const WRITE_SIZE: usize = F::WRITE_SIZE;
    const ERASE_SIZE: usize = Self::PAGE;

    async fn erase(&mut self, _: u32, _: u32) -> Result<(), SectorError> {
        Err(SectorError::Refused)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), SectorError> {
        if self.access == Access::Read {
            return Err(SectorError::Refused);
        }
        let address = self.address(offset, bytes.len())?;
        self.flash.write(address, bytes).await.map_err(failed)
    }
}
