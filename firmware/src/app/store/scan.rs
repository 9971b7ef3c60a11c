//! What a sector holds, found in one pass over its records.

use core::iter;

use crc::Digest;
use embedded_storage_async::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};
use sequential_storage::Error;

use super::SCHEMA;
use super::field::{FIELDS, Field, Values};
use super::record::{CHECKSUM, Entry, Record};
use super::sector::{Access, BUFFER, Sector, SectorError};

/// A generation of which nothing is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Set {
    pub generation: u32,
    /// Version of what the keys mean.
    pub schema: u32,
    /// Bits of the fields that it has, by number.
    fields: [Option<u32>; FIELDS],
}

impl Set {
    /// With these values, or with none.
    pub fn new(generation: u32, values: Option<&Values>) -> Self {
        let mut fields = [None; FIELDS];
        if let Some(values) = values {
            fields = Field::ALL.map(|field| Some(values.get(field).to_bits()));
        }
        Self {
            generation,
            schema: SCHEMA,
            fields,
        }
    }

    /// As it is in flash: the schema, the fields, the commit.
    pub fn records(&self) -> impl Iterator<Item = Record> {
        let record = |entry, value| Record::new(entry, self.generation, value);
        let body = iter::once(record(Entry::Schema, self.schema)).chain(
            self.fields()
                .map(move |(field, bits)| record(Entry::Field(field), bits)),
        );
        let mut digest = CHECKSUM.digest();
        for record in body.clone() {
            digest.update(&record.body());
        }
        body.chain(iter::once(record(Entry::Commit, digest.finalize())))
    }

    /// The fields that it has.
    pub fn fields(&self) -> impl Iterator<Item = (Field, u32)> + Clone {
        Field::ALL
            .into_iter()
            .zip(self.fields)
            .filter_map(|(field, bits)| Some((field, bits?)))
    }
}

/// Whether a generation is newer than another. Numbers begin anew behind the last, so the nearer way
/// round counts.
pub(super) fn is_newer(generation: u32, than: u32) -> bool {
    (generation.wrapping_sub(than) as i32) > 0
}

/// What a sector holds.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Scan {
    /// Its newest whole set.
    pub set: Option<Set>,
    /// The newest generation of which it has any record.
    pub newest: Option<u32>,
    /// Records that fit behind the set; none if anything else is behind it.
    pub room: Option<usize>,
    /// Nothing was ever written.
    pub blank: bool,
}

/// A set of which the end has not come yet.
struct Unfinished {
    generation: u32,
    schema: Option<u32>,
    fields: [Option<u32>; FIELDS],
    digest: Digest<'static, u32>,
}

impl Unfinished {
    fn new(generation: u32) -> Self {
        Self {
            generation,
            schema: None,
            fields: [None; FIELDS],
            digest: CHECKSUM.digest(),
        }
    }
}

/// The records, one after the other.
#[derive(Default)]
struct Pass {
    unfinished: Option<Unfinished>,
    set: Option<Set>,
    newest: Option<u32>,
    /// Whether the last item was the end of `set`.
    ended: bool,
}

impl Pass {
    fn take(&mut self, record: &Record) {
        let generation = record.generation;
        if self
            .newest
            .is_none_or(|newest| is_newer(generation, newest))
        {
            self.newest = Some(generation);
        }
        let mut set = match self.unfinished.take() {
            Some(set) if set.generation == generation => set,
            _ => Unfinished::new(generation),
        };
        match record.entry() {
            Entry::Commit => {
                self.end(set, record.value);
                return;
            }
            Entry::Schema => set.schema = Some(record.value),
            Entry::Field(field) => set.fields[field as usize - 1] = Some(record.value),
            Entry::Unknown => {}
        }
        set.digest.update(&record.body());
        self.unfinished = Some(set);
        self.ended = false;
    }

    fn end(&mut self, set: Unfinished, checksum: u32) {
        let whole = set.digest.finalize() == checksum;
        let newest = self
            .set
            .is_none_or(|before| is_newer(set.generation, before.generation));
        self.ended = false;
        if let (true, true, Some(schema)) = (whole, newest, set.schema) {
            self.ended = true;
            self.set = Some(Set {
                generation: set.generation,
                schema,
                fields: set.fields,
            });
        }
    }
}

/// Reads the sector that begins at `start`. Never writes.
///
/// # Errors
/// The flash cannot be read.
pub(super) async fn scan<F: NorFlash>(
    flash: &mut F,
    start: u32,
) -> Result<Scan, NorFlashErrorKind> {
    let mut pass = Pass::default();
    let items = read_items(flash, start, &mut pass).await?;
    let mut sector = Sector::new(flash, start, Access::Read);
    let room = match items {
        Some(items) if pass.ended && sector.is_blank_behind(items).await.map_err(kind)? => {
            Some(Sector::<F>::CAPACITY.saturating_sub(items))
        }
        _ => None,
    };
    Ok(Scan {
        set: pass.set,
        newest: pass.newest,
        room,
        blank: sector.is_blank().await.map_err(kind)?,
    })
}

/// Takes every record, oldest first. Gives the number of items that the map finds sound; none if it
/// cannot make sense of the sector's pages.
async fn read_items<F: NorFlash>(
    flash: &mut F,
    start: u32,
    pass: &mut Pass,
) -> Result<Option<usize>, NorFlashErrorKind> {
    let mut buffer = [0; BUFFER];
    let mut map = Sector::new(flash, start, Access::Read).map();
    let mut items = match map.fetch_all_items(&mut buffer).await {
        Ok(items) => items,
        Err(Error::Storage {
            value: SectorError::Flash(kind),
            ..
        }) => return Err(kind),
        // It would have erased to repair.
        Err(_) => return Ok(None),
    };
    let mut count = 0;
    loop {
        match items.next::<Record>(&mut buffer).await {
            Ok(Some((_, record))) => pass.take(&record),
            Ok(None) => return Ok(Some(count)),
            // An item of somebody else.
            Err(Error::SerializationError(_) | Error::BufferTooSmall(_)) => pass.ended = false,
            Err(Error::Storage {
                value: SectorError::Flash(kind),
                ..
            }) => return Err(kind),
            Err(_) => return Ok(None),
        }
        count += 1;
    }
}

fn kind(error: SectorError) -> NorFlashErrorKind {
    error.kind()
}
