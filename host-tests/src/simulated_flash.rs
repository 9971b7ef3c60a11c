//! NOR flash in memory, which loses its power at an operation of one's choice.
//!
//! Words of 32 bits, of which writing only clears bits, and sectors, of which erasing sets all. A word
//! written and a sector erased are one operation each. The one at which the power goes comes to pass in
//! part, and none after it does until the next start. A bit that was torn may read differently each time.

use std::collections::BTreeMap;
use std::pin::pin;
use std::task::{Context, Poll, Waker};

use embedded_storage_async::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use model_core::numeric::random::Random;

/// Bytes of a word.
const WORD: usize = 4;

/// Flash with sectors of so many bytes.
#[derive(Debug, Clone)]
pub struct SimulatedFlash<const SECTOR: usize> {
    words: Vec<u32>,
    /// Erases of each sector.
    pub erases: Vec<u32>,
    /// Words written and sectors erased.
    pub operations: u64,
    cut: Option<Cut>,
    dead: bool,
    /// Bits between zero and one, by word, and what draws how they read.
    marginal: BTreeMap<usize, u32>,
    readings: Random,
    worn: Option<usize>,
    weak: Option<usize>,
}

/// A loss of power.
#[derive(Debug, Clone, Copy)]
pub struct Cut {
    /// In which operation, counted from the first ever.
    pub operation: u64,
    /// What becomes of that operation.
    pub tear: Tear,
}

/// How far an operation comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tear {
    /// Nothing happens.
    None,
    /// It is done, and nothing after it.
    Whole,
    /// Each bit that was to change did so or not, as chance has it.
    Bits(u64),
    /// Each bit that was to change did so or not, or reads differently each time until it is written or erased again.
    Marginal(u64),
    /// Of an erase, the words in front of a random one. Of a word, what [`Tear::Bits`] makes of it.
    Front(u64),
    /// Of an erase, the words behind a random one. Of a word, what [`Tear::Bits`] makes of it.
    Back(u64),
}

impl<const SECTOR: usize> SimulatedFlash<SECTOR> {
    /// So many sectors, erased.
    pub fn new(sectors: usize) -> Self {
        Self {
            words: vec![u32::MAX; sectors * SECTOR / WORD],
            erases: vec![0; sectors],
            operations: 0,
            cut: None,
            dead: false,
            marginal: BTreeMap::new(),
            readings: Random::new(0, 0),
            worn: None,
            weak: None,
        }
    }

    /// What it holds.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// What it holds, to be damaged.
    pub fn words_mut(&mut self) -> &mut [u32] {
        &mut self.words
    }

    /// Lets the power go.
    pub fn cut(&mut self, cut: Cut) {
        self.cut = Some(cut);
    }

    /// Turns the power on again.
    pub fn restart(&mut self) {
        self.cut = None;
        self.dead = false;
    }

    /// From now on erasing this sector leaves one of its words at zero.
    pub fn wear_out(&mut self, sector: usize) {
        self.worn = Some(sector * SECTOR / WORD + 40);
        self.erase_worn();
    }

    fn erase_worn(&mut self) {
        if let Some(index) = self.worn {
            self.words[index] = 0;
        }
    }

    /// From now on one bit more than it should is cleared when this word is written.
    pub fn weaken(&mut self, index: usize) {
        self.weak = Some(index);
    }

    /// Counts an operation. What becomes of it, or that there is no power for it.
    fn operate(&mut self) -> Result<Tear, NorFlashErrorKind> {
        if self.dead {
            return Err(NorFlashErrorKind::Other);
        }
        let operation = self.operations;
        self.operations += 1;
        match self.cut {
            Some(cut) if cut.operation == operation => {
                self.dead = true;
                Ok(cut.tear)
            }
            _ => Ok(Tear::Whole),
        }
    }

    fn power(&self) -> Result<(), NorFlashErrorKind> {
        if self.dead {
            Err(NorFlashErrorKind::Other)
        } else {
            Ok(())
        }
    }

    fn write_word(&mut self, index: usize, value: u32) -> Result<(), NorFlashErrorKind> {
        let old = self.words[index];
        let marginal = self.marginal.remove(&index).unwrap_or(0);
        let erased = old | marginal;
        assert_eq!(
            erased & value,
            value,
            "word {index:#x} was not erased before"
        );
        let value = if self.weak == Some(index) {
            value & value.wrapping_sub(1)
        } else {
            value
        };
        let tear = self.operate()?;
        let still_marginal = match tear {
            Tear::None => marginal,
            Tear::Marginal(seed) => {
                marginal & value | (erased & !value & Random::new(seed, !(index as u64)).bits())
            }
            // Writing makes no one.
            _ => marginal & value,
        };
        if still_marginal != 0 {
            self.marginal.insert(index, still_marginal);
        }
        self.words[index] = match tear {
            Tear::None => old,
            Tear::Whole => old & value,
            Tear::Bits(seed) | Tear::Marginal(seed) | Tear::Front(seed) | Tear::Back(seed) => {
                (old & value) | (old & Random::new(seed, index as u64).bits())
            }
        };
        self.power()
    }

    fn erase_sector(&mut self, sector: usize) -> Result<(), NorFlashErrorKind> {
        let tear = self.operate()?;
        self.erases[sector] += 1;
        let first = sector * SECTOR / WORD;
        let words = &mut self.words[first..][..SECTOR / WORD];
        if tear == Tear::Whole {
            self.marginal
                .retain(|index, _| !(first..first + words.len()).contains(index));
        }
        let place = |seed| Random::new(seed, 0).bits() as usize % words.len();
        match tear {
            Tear::None => {}
            Tear::Whole => words.fill(u32::MAX),
            Tear::Bits(seed) => {
                let mut random = Random::new(seed, 0);
                // From hardly any to nearly all of the bits.
                let share = random.bits() % 5;
                for word in words {
                    let (a, b) = (random.bits(), random.bits());
                    *word |= [
                        a & b & random.bits(),
                        a & b,
                        a,
                        a | b,
                        a | b | random.bits(),
                    ][share as usize];
                }
            }
            Tear::Marginal(seed) => {
                let mut random = Random::new(seed, 0);
                for (index, word) in (first..).zip(words) {
                    let marginal = self.marginal.entry(index).or_default();
                    *marginal |= !*word & random.bits();
                    *word |= random.bits() & random.bits();
                }
            }
            Tear::Front(seed) => {
                let end = place(seed);
                words[..end].fill(u32::MAX);
            }
            Tear::Back(seed) => {
                let begin = place(seed);
                words[begin..].fill(u32::MAX);
            }
        }
        self.erase_worn();
        self.power()
    }
}

impl<const SECTOR: usize> ErrorType for SimulatedFlash<SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<const SECTOR: usize> ReadNorFlash for SimulatedFlash<SECTOR> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), NorFlashErrorKind> {
        self.power()?;
        // Nothing is read across the end of a word.
        for (address, part) in (offset as usize..)
            .step_by(WORD)
            .zip(bytes.chunks_mut(WORD))
        {
            let index = address / WORD;
            let marginal = self.marginal.get(&index).copied().unwrap_or(0);
            let word = self.words[index] ^ (marginal & self.readings.bits());
            let word = word.to_le_bytes();
            part.copy_from_slice(&word[address % WORD..][..part.len()]);
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.words.len() * WORD
    }
}

impl<const SECTOR: usize> NorFlash for SimulatedFlash<SECTOR> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), NorFlashErrorKind> {
        let (from, to) = (from as usize, to as usize);
        assert!(from.is_multiple_of(SECTOR) && to.is_multiple_of(SECTOR));
        (from / SECTOR..to / SECTOR).try_for_each(|sector| self.erase_sector(sector))
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), NorFlashErrorKind> {
        let (words, rest) = bytes.as_chunks();
        assert!(rest.is_empty() && (offset as usize).is_multiple_of(WORD));
        (offset as usize / WORD..)
            .zip(words)
            .try_for_each(|(index, word)| self.write_word(index, u32::from_le_bytes(*word)))
    }
}

/// What a future that waits for nothing comes to.
///
/// # Panics
/// If it waits.
pub fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result,
        Poll::Pending => panic!("nobody is there to wake it"),
    }
}
