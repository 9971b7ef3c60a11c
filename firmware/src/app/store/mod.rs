//! The parameters that outlive a power cut: a refit's, the console's, the sensors' calibration.
//!
//! They lie in three sectors of 16 KB, apart from the program. What is stored at once is a *set*:
//! a value for every [`Field`](field::Field), each under a key of its own, between a record of the
//! schema's version and one of the whole set's checksum. A set counts from the moment on when that
//! last record, the commit, is whole; until then the set before it does. So whatever is cut short,
//! after the restart all values are the old ones or all are the new ones.
//!
//! A sector holds a map of the crate `sequential-storage`, which puts a checksum on each item, finds
//! the place for the next one and skips what is damaged. That crate would also make room by erasing
//! and repair by erasing. It is not let do either: an erase that is cut short leaves a sector in any
//! state, and one that looks half full can make the repair erase its neighbour, to which the values
//! had just been moved. Here a set that finds no room begins the next sector round, which alone is
//! erased, and the sector with the set in use stays as it is until the new set has been read back.
//! Nothing is written behind a set that was not finished, as a word that a cut left between zero and
//! one may read differently from one time to the next; the next set begins a sector then too. Two
//! such words cannot be told from sound ones: the commit's last, with which the set is there at one
//! start and perhaps not at the next, and one cut so early that it reads as erased, on which the next
//! set may be lost. In either case what is read is a whole set.
//!
//! Reading never writes. Whatever the flash holds, [`Store::load`] gives values within their bounds,
//! the defaults if need be, and names what was wrong.
//!
//! # Only while disarmed
//! The STM32F405 has one bank of flash. Erasing 16 KB of it byte by byte, as embassy does, takes
//! 400 ms, at worst 800 ms, and a word is written in 16 µs, at worst 100 µs (data sheet DS8626); for so long nothing
//! can be fetched from it, and the processor stands still, interrupts included. So writing asks for a
//! [`Disarmed`].
//!
//! # Wear
//! A set takes 984 bytes with all its fields, so that a sector takes 14 sets: an erase for every 14
//! commits that change a value. With three sectors of 10,000 erases each that makes 420,000 commits.

use core::fmt;

use embedded_storage_async::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};
use heapless::Vec;
use model_core::numeric::invalid_parameter::InvalidParameter;
use sequential_storage::Error;

use super::arming::{Disarmed, Switch};
use candidate::{Candidate, Rejected};
use field::{FIELDS, OutOfBounds, Values};
use scan::{Scan, Set, is_newer, scan};
use sector::{Access, BUFFER, Sector, SectorError};

pub mod candidate;
pub mod field;
mod record;
mod scan;
mod sector;

/// Sectors that the store takes.
pub const SECTORS: usize = 3;

/// Version of what the keys mean. Raised when an old key gets a new meaning; a new key alone does not
/// raise it, as keys that a firmware does not know are ignored.
pub const SCHEMA: u32 = 1;

/// The parameters' place in flash.
///
/// ```
/// # async fn example<F: embedded_storage_async::nor_flash::NorFlash, S: firmware::app::arming::Switch>(
/// #     flash: F,
/// #     disarmed: &firmware::app::arming::Disarmed<S>,
/// # ) -> Result<(), Box<dyn core::error::Error>> {
/// use firmware::app::machine::EMA;
/// use firmware::app::store::Store;
/// use firmware::app::store::field::{Field, Values};
///
/// let mut store = Store::new(flash, 0x4000)?;
/// let mut values = store.load(&Values::of(&EMA)?).await.values;
/// values.set(Field::Coulomb, 0.13)?;
/// store.commit(&values, disarmed).await?;
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct Store<F> {
    flash: F,
    start: u32,
}

/// What was found, and what to run with in any case.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The set in use; defaults for fields that it lacks or that are refused, and for all if there is
    /// no set.
    pub values: Values,
    /// The set's number. None if there is no set.
    pub generation: Option<u32>,
    /// Stored values outside their bounds, whose fields have their defaults.
    pub refused: Vec<OutOfBounds, FIELDS>,
    /// What else is not as it should be.
    pub problem: Option<StoreError>,
}

/// What is wrong with the store.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StoreError {
    /// The flash did not read, write or erase.
    Flash(NorFlashErrorKind),
    /// A newer firmware has written, with keys of another meaning: nothing is read or written.
    NewerSchema(u32),
    /// Beside the set in use, the newest that is whole, there is something that is not: a commit was
    /// cut short, or a set is damaged.
    Unfinished,
    /// There is something, but no whole set.
    Damaged,
    /// What was written does not read back.
    NotKept,
}

impl fmt::Display for StoreError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Flash(kind) => write!(formatter, "the flash failed: {kind}"),
            Self::NewerSchema(version) => write!(
                formatter,
                "the stored parameters have schema {version}, this firmware knows {SCHEMA}: \
                 install the newer firmware, or forget the parameters"
            ),
            Self::Unfinished => formatter.write_str(
                "a commit was cut short or a set is damaged, the newest whole set is in use; \
                 see that it is the right one and commit",
            ),
            Self::Damaged => formatter.write_str(
                "the stored parameters are damaged, defaults are in use; commit them anew",
            ),
            Self::NotKept => formatter
                .write_str("the flash does not keep what is written; those before are in use"),
        }
    }
}

impl core::error::Error for StoreError {}

impl From<NorFlashErrorKind> for StoreError {
    fn from(kind: NorFlashErrorKind) -> Self {
        Self::Flash(kind)
    }
}

/// All sectors.
struct Survey {
    sectors: [Scan; SECTORS],
    /// The newest whole set, and where it lies.
    set: Option<(usize, Set)>,
}

impl Survey {
    fn new(sectors: [Scan; SECTORS]) -> Self {
        let mut newest: Option<(usize, Set)> = None;
        for (index, sector) in sectors.iter().enumerate() {
            if let Some(set) = sector.set
                && newest.is_none_or(|(_, before)| is_newer(set.generation, before.generation))
            {
                newest = Some((index, set));
            }
        }
        Self {
            sectors,
            set: newest,
        }
    }

    /// The newest generation of which there is any record.
    fn newest(&self) -> Option<u32> {
        let generations = self.sectors.iter().filter_map(|sector| sector.newest);
        generations.reduce(|a, b| if is_newer(b, a) { b } else { a })
    }

    /// What is wrong, beside the values themselves.
    fn problem(&self) -> Option<StoreError> {
        let Some((index, set)) = self.set else {
            let blank = self.sectors.iter().all(|sector| sector.blank);
            return (!blank).then_some(StoreError::Damaged);
        };
        if set.schema > SCHEMA {
            return Some(StoreError::NewerSchema(set.schema));
        }
        // What is newer than the set in use lies behind it, or in a sector that has no set yet.
        let behind = self.sectors[index].room.is_none();
        let begun = |sector: &Scan| sector.set.is_none() && !sector.blank;
        (behind || self.sectors.iter().any(begun)).then_some(StoreError::Unfinished)
    }
}

impl<F: NorFlash> Store<F> {
    /// In the [`SECTORS`] sectors of `flash` from the offset `start` on. Reads and writes nothing.
    ///
    /// # Errors
    /// A start that is no sector's, or too few sectors behind it.
    pub fn new(flash: F, start: u32) -> Result<Self, InvalidParameter> {
        let sector = F::ERASE_SIZE as u32;
        let end = sector
            .checked_mul(SECTORS as u32)
            .and_then(|length| start.checked_add(length));
        let fits = end.is_some_and(|end| end as usize <= flash.capacity());
        if !fits || !start.is_multiple_of(sector) {
            return Err(InvalidParameter {
                name: "start",
                requirement: "must be where a sector begins, with the store's sectors in the flash",
            });
        }
        Ok(Self { flash, start })
    }

    /// What is stored, or the defaults.
    pub async fn load(&mut self, defaults: &Values) -> Loaded {
        let mut loaded = Loaded {
            values: *defaults,
            generation: None,
            refused: Vec::new(),
            problem: None,
        };
        let survey = match self.survey().await {
            Ok(survey) => survey,
            Err(error) => {
                loaded.problem = Some(error);
                return loaded;
            }
        };
        loaded.problem = survey.problem();
        if let Some((_, set)) = survey.set
            && set.schema <= SCHEMA
        {
            loaded.generation = Some(set.generation);
            for (field, bits) in set.fields() {
                if let Err(refused) = loaded.values.set(field, f32::from_bits(bits)) {
                    // There is room for every field.
                    let _ = loaded.refused.push(refused);
                }
            }
        }
        loaded
    }

    /// Stores all values in one step, and gives the set's number. What is stored already, with nothing
    /// wrong beside it, is not written again.
    ///
    /// # Errors
    /// The values before stay in use, unless the flash fails at the very end.
    pub async fn commit<S: Switch>(
        &mut self,
        values: &Values,
        _: &Disarmed<S>,
    ) -> Result<u32, StoreError> {
        let survey = self.survey().await?;
        if let Some((_, set)) = survey.set {
            if set.schema > SCHEMA {
                return Err(StoreError::NewerSchema(set.schema));
            }
            let same = set == Set::new(set.generation, Some(values));
            if same && survey.problem().is_none() {
                return Ok(set.generation);
            }
        }
        self.replace(&survey, Some(values)).await
    }

    /// Takes over what a refit proposes, in one step, if it is better and within its bounds, and gives
    /// the values that are then in use.
    ///
    /// # Errors
    /// The values in use stay.
    pub async fn adopt<S: Switch>(
        &mut self,
        present: &Values,
        candidate: &Candidate,
        disarmed: &Disarmed<S>,
    ) -> Result<Values, Rejected> {
        let values = candidate.applied_to(present)?;
        self.commit(&values, disarmed)
            .await
            .map_err(Rejected::Store)?;
        Ok(values)
    }

    /// From now on every field has its default, whatever is stored and whoever has stored it: in one
    /// step, like a commit.
    ///
    /// # Errors
    /// The values before stay in use, unless the flash fails at the very end.
    pub async fn forget<S: Switch>(&mut self, _: &Disarmed<S>) -> Result<u32, StoreError> {
        let survey = self.survey().await?;
        self.replace(&survey, None).await
    }

    async fn survey(&mut self) -> Result<Survey, StoreError> {
        let mut sectors = [Scan::default(); SECTORS];
        for (index, sector) in sectors.iter_mut().enumerate() {
            let start = self.start_of(index);
            *sector = scan(&mut self.flash, start).await?;
        }
        Ok(Survey::new(sectors))
    }

    fn start_of(&self, sector: usize) -> u32 {
        self.start + (sector * F::ERASE_SIZE) as u32
    }

    /// Writes a set behind the one in use, or else in the next sector that takes it.
    async fn replace(
        &mut self,
        survey: &Survey,
        values: Option<&Values>,
    ) -> Result<u32, StoreError> {
        let generation = survey.newest().map_or(1, |newest| newest.wrapping_add(1));
        let set = Set::new(generation, values);
        let mut result = Err(StoreError::NotKept);
        let others = match survey.set {
            Some((index, _)) => {
                let room = survey.sectors[index].room.unwrap_or(0);
                if room >= set.records().count() {
                    result = self.write(index, &set).await;
                }
                index + 1..index + SECTORS
            }
            None => 0..SECTORS,
        };
        for index in others {
            if result.is_ok() {
                break;
            }
            let sector = index % SECTORS;
            result = match self.erase(sector).await {
                Ok(()) => self.write(sector, &set).await,
                Err(error) => Err(error),
            };
        }
        result.map(|()| generation)
    }

    async fn erase(&mut self, sector: usize) -> Result<(), StoreError> {
        let (start, end) = (self.start_of(sector), self.start_of(sector + 1));
        let erased = self.flash.erase(start, end).await;
        erased.map_err(|error| error.kind())?;
        let mut sector = Sector::new(&mut self.flash, start, Access::Read);
        match sector.is_blank().await {
            Ok(true) => Ok(()),
            Ok(false) => Err(StoreError::NotKept),
            Err(error) => Err(error.kind().into()),
        }
    }

    /// Writes a set and reads it back.
    async fn write(&mut self, sector: usize, set: &Set) -> Result<(), StoreError> {
        let start = self.start_of(sector);
        let mut map = Sector::new(&mut self.flash, start, Access::Append).map();
        let mut buffer = [0; BUFFER];
        for record in set.records() {
            let stored = map.store_item(&mut buffer, &record.key(), &record).await;
            stored.map_err(|error| match error {
                Error::Storage {
                    value: SectorError::Flash(kind),
                    ..
                } => StoreError::Flash(kind),
                // There was room, so the flash has not what was written before.
                _ => StoreError::NotKept,
            })?;
        }
        let found = scan(&mut self.flash, start).await?.set;
        if found.is_some_and(|found| found == *set) {
            Ok(())
        } else {
            Err(StoreError::NotKept)
        }
    }
}
