//! The parameter store: after a power cut at any operation of the flash, or with any word of it
//! damaged, it gives the old set or the new one whole, and says what is wrong.

use std::collections::BTreeMap;
use std::convert::Infallible;

use firmware::app::arming::{Disarmed, Switch};
use firmware::app::machine::{EMA, THROTTLE};
use firmware::app::store::candidate::{Candidate, Rejected};
use firmware::app::store::field::{FIELDS, Field, OutOfBounds, Values};
use firmware::app::store::{Loaded, SCHEMA, SECTORS, Store, StoreError};
use host_tests::simulated_flash::{Cut, SimulatedFlash, Tear, now};
use model_core::identify::friction::Estimate;
use model_core::numeric::random::Random;
use proptest::prelude::*;
use rayon::prelude::*;

/// Sectors of the chip.
const REAL: usize = 16 * 1024;

/// Sectors so small that they take three sets, and a few commits go all the way round.
const SMALL: usize = 3 * 1024;

/// Bytes of a field in flash: its number, its generation, its value, and the head of what is stored.
const RECORD: u32 = 24;

/// Sets that a sector of this many bytes takes: seven of its eight pages, each with two marks of a word; a set is
/// its fields, what is before them and what is behind.
const fn sets(sector: usize) -> u32 {
    7 * ((sector as u32 / 8 - 8) / RECORD) / (FIELDS as u32 + 2)
}

type SmallFlash = SimulatedFlash<SMALL>;

struct NoDrive;

impl Switch for NoDrive {
    type Refusal = Infallible;

    fn on(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn off(&mut self) {}
}

fn disarmed() -> Disarmed<NoDrive> {
    Disarmed::new(NoDrive)
}

fn defaults() -> Values {
    Values::of(&EMA).unwrap()
}

/// Values of which every field is another in every set.
fn numbered(number: u32) -> Values {
    let mut values = defaults();
    for (field, default) in defaults().iter() {
        let description = field.description();
        let nearer = if default > 0.5 * (description.lower + description.upper) {
            description.lower
        } else {
            description.upper
        };
        let share = 0.25 * (1.0 + number as f32) / 1000.0;
        values
            .set(field, default + share * (nearer - default))
            .unwrap();
    }
    values
}

fn load<const SECTOR: usize>(flash: &mut SimulatedFlash<SECTOR>) -> Loaded {
    now(Store::new(flash, 0).unwrap().load(&defaults()))
}

fn commit<const SECTOR: usize>(
    flash: &mut SimulatedFlash<SECTOR>,
    values: &Values,
) -> Result<u32, StoreError> {
    now(Store::new(flash, 0).unwrap().commit(values, &disarmed()))
}

/// A flash after so many commits.
fn filled<const SECTOR: usize>(commits: u32) -> SimulatedFlash<SECTOR> {
    let mut flash = SimulatedFlash::new(SECTORS);
    for number in 0..commits {
        commit(&mut flash, &numbered(number)).unwrap();
    }
    flash
}

#[test]
fn what_is_committed_is_loaded() {
    let mut flash = SmallFlash::new(SECTORS);
    let empty = Loaded {
        values: defaults(),
        generation: None,
        refused: heapless::Vec::new(),
        problem: None,
    };
    assert_eq!(load(&mut flash), empty);
    for number in 0..20 {
        assert_ne!(numbered(number), numbered(number + 1));
        let generation = commit(&mut flash, &numbered(number)).unwrap();
        let expected = Loaded {
            values: numbered(number),
            generation: Some(generation),
            ..empty.clone()
        };
        assert_eq!(load(&mut flash), expected);
    }
}

#[test]
fn only_the_stores_own_sectors_are_touched() {
    let mut flash = SmallFlash::new(SECTORS + 2);
    for number in 0..20 {
        let mut store = Store::new(&mut flash, SMALL as u32).unwrap();
        now(store.commit(&numbered(number), &disarmed())).unwrap();
    }
    let used: Vec<bool> = flash
        .words()
        .chunks(SMALL / 4)
        .map(|sector| sector.iter().any(|word| *word != u32::MAX))
        .collect();
    assert_eq!(used, [false, true, true, true, false]);
    assert_eq!(flash.erases[0] + flash.erases[4], 0);
    for start in [1, 4, SMALL as u32 / 2, 3 * SMALL as u32, u32::MAX - 2047] {
        let refused = Store::new(&mut flash, start).unwrap_err();
        assert_eq!(refused.name, "start");
    }
}

#[test]
fn the_machine_gets_what_is_stored_and_keeps_the_rest() {
    for machine in [EMA, THROTTLE] {
        assert_eq!(Values::of(&machine).unwrap().applied_to(&machine), machine);
    }
    let values = numbered(7);
    let machine = values.applied_to(&EMA);
    assert_eq!(
        Values::of(&machine).unwrap().get(Field::Static),
        values.get(Field::Static)
    );
    assert_eq!(machine.plant.coulomb.backward, values.get(Field::Coulomb));
    assert_eq!(
        machine.position_loop.derivative,
        values.get(Field::Derivative)
    );
    let position = machine.converters.position;
    assert_eq!(position.unit(), values.get(Field::PositionUnit));
    assert_eq!(machine.plant.upper_stop, values.get(Field::UpperStop));
    assert_eq!(machine.limits.peak_current, values.get(Field::PeakCurrent));
    assert_eq!(machine.limits.peak_time, EMA.limits.peak_time);
    assert_eq!(machine.converters.current, EMA.converters.current);
    assert_eq!(machine.converters.bridge, EMA.converters.bridge);
}

/// What an operation may leave behind, as many variants as it takes.
fn tears(erase: bool) -> Vec<Tear> {
    let seeds = if erase { 0..12 } else { 0..3 };
    let mut tears = vec![Tear::None, Tear::Whole];
    for seed in seeds {
        tears.push(Tear::Bits(seed));
        if erase {
            tears.extend([Tear::Front(seed), Tear::Back(seed)]);
        }
    }
    tears
}

/// What came of a cut.
#[derive(PartialEq, Eq, PartialOrd, Ord, Debug)]
enum Found {
    Old,
    New,
}

/// Cuts the power at one operation of a commit, starts again, and commits once more.
fn cut_and_recover(before: &SmallFlash, number: u32, cut: Cut) -> Found {
    let old = load(&mut before.clone()).values;
    let new = numbered(number);
    let mut flash = before.clone();
    flash.cut(cut);
    let result = commit(&mut flash, &new);
    assert!(
        result.is_err(),
        "{number} {cut:?}: nobody can have read it back"
    );
    flash.restart();

    let loaded = load(&mut flash);
    assert!(loaded.refused.is_empty());
    let found = if loaded.values == new {
        assert_eq!(loaded.problem, None, "{number} {cut:?}");
        Found::New
    } else {
        assert_eq!(loaded.values, old, "{number} {cut:?}: a mixture");
        Found::Old
    };

    let next = numbered(500);
    commit(&mut flash, &next).unwrap();
    let recovered = load(&mut flash);
    assert_eq!(
        (recovered.values, recovered.problem),
        (next, None),
        "{number} {cut:?}"
    );
    found
}

#[test]
fn a_power_cut_at_any_operation_leaves_the_old_set_or_the_new_one() {
    // Three times round all sectors.
    const COMMITS: u32 = 3 * SECTORS as u32 * sets(SMALL);
    let mut flash = SmallFlash::new(SECTORS);
    let mut cases = Vec::new();
    for number in 0..COMMITS {
        let before = flash.clone();
        commit(&mut flash, &numbered(number)).unwrap();
        let erases = flash.erases != before.erases;
        for operation in before.operations..flash.operations {
            // A commit that erases does so first.
            let erase = erases && operation == before.operations;
            for tear in tears(erase) {
                cases.push((before.clone(), number, Cut { operation, tear }));
            }
        }
    }
    assert!(flash.erases.iter().all(|erases| *erases == 3));
    let found: Vec<Found> = cases
        .par_iter()
        .map(|(before, number, cut)| cut_and_recover(before, *number, *cut))
        .collect();
    let new = found.iter().filter(|found| **found == Found::New).count();
    println!(
        "{} operations of {COMMITS} commits, {} cuts: {} old, {new} new",
        flash.operations,
        found.len(),
        found.len() - new
    );
    // At least where the last word of the commit was written whole.
    assert!(new >= COMMITS as usize);
}

/// Bits that a cut left between zero and one read differently each time, so a start may find the new set and the next one
/// the old one. It is whole in any case, and so is what is stored behind it.
#[test]
fn a_power_cut_that_leaves_marginal_bits_never_mixes_sets() {
    const COMMITS: u32 = 2 * SECTORS as u32 * sets(SMALL);
    const STARTS: usize = 4;
    let mut flash = SmallFlash::new(SECTORS);
    let mut cases = Vec::new();
    for number in 0..COMMITS {
        let before = flash.clone();
        commit(&mut flash, &numbered(number)).unwrap();
        cases.extend((before.operations..flash.operations).flat_map(|operation| {
            let before = before.clone();
            (0..3).map(move |seed| (before.clone(), number, operation, seed))
        }));
    }
    let found: Vec<[bool; 2]> = cases
        .into_par_iter()
        .map(|(mut flash, number, operation, seed)| {
            let what = format!("{number}, {operation}, {seed}");
            let old = load(&mut flash).values;
            let new = numbered(number);
            let tear = Tear::Marginal(seed);
            flash.cut(Cut { operation, tear });
            commit(&mut flash, &new).unwrap_err();
            flash.restart();
            let starts = [(); STARTS].map(|()| load(&mut flash));
            for loaded in &starts {
                let whole = loaded.values == old || loaded.values == new;
                assert!(whole && loaded.refused.is_empty(), "{what}: a mixture");
            }
            // What is said to be stored is there, or what was there before is, whole.
            let next = numbered(500);
            let committed = commit(&mut flash, &next).is_ok();
            let mut lost = !committed;
            for _ in 0..STARTS {
                let values = load(&mut flash).values;
                assert!([old, new, next].contains(&values), "{what}: a mixture");
                lost |= values != next;
            }
            let differ = starts.iter().any(|start| start.values != starts[0].values);
            [differ, lost]
        })
        .collect();
    let count = |which: usize| found.iter().filter(|found| found[which]).count();
    println!(
        "{} cuts with marginal bits: {} read differently from start to start, {} lost the next set",
        found.len(),
        count(0),
        count(1)
    );
    assert_eq!(count(1), 0, "a set that was said to be stored was lost");
}

#[test]
fn ten_thousand_saves_are_each_there_and_wear_the_sectors_evenly() {
    const SAVES: u32 = 10_000;
    let mut flash = SimulatedFlash::<REAL>::new(SECTORS);
    for number in 0..SAVES {
        let values = numbered(number % 1000);
        commit(&mut flash, &values).unwrap();
        let loaded = load(&mut flash);
        assert_eq!((loaded.values, loaded.problem), (values, None), "{number}");
    }
    let rounds = SAVES / (SECTORS as u32 * sets(REAL));
    println!("{SAVES} saves, erases {:?}", flash.erases);
    for erases in &flash.erases {
        assert!((rounds..=rounds + 1).contains(erases), "{erases}");
    }
}

#[test]
fn cut_after_cut_never_mixes_sets() {
    (0..2000_u64).into_par_iter().for_each(|seed| {
        let mut random = Random::new(seed, 7);
        let mut flash = filled::<SMALL>(random.bits() % 12);
        let mut present = load(&mut flash).values;
        for number in 100..108 {
            let new = numbered(number);
            let tear = match random.bits() % 5 {
                0 => Tear::None,
                1 => Tear::Whole,
                2 => Tear::Front(random.bits().into()),
                3 => Tear::Back(random.bits().into()),
                _ => Tear::Bits(random.bits().into()),
            };
            // A commit has 252 operations: some come through.
            let operation = flash.operations + u64::from(random.bits() % 350);
            flash.cut(Cut { operation, tear });
            let result = commit(&mut flash, &new);
            flash.restart();
            let loaded = load(&mut flash);
            if result.is_ok() {
                assert_eq!((loaded.values, loaded.problem), (new, None));
            }
            assert!(
                loaded.values == new || loaded.values == present,
                "seed {seed}"
            );
            present = loaded.values;
        }
    });
}

/// A damaged flash gives one of the sets that were ever committed, or the defaults; if it is not the
/// newest, the problem has a name. Then the next commit is as good as any.
fn assert_contained(flash: &mut SmallFlash, commits: u32, what: &str) {
    let operations = flash.operations;
    let loaded = load(flash);
    assert_eq!(flash.operations, operations, "{what}: reading wrote");
    assert!(loaded.refused.is_empty(), "{what}");
    if loaded.values != numbered(commits - 1) {
        assert!(loaded.problem.is_some(), "{what}: nothing said");
        let known = (0..commits).map(numbered).any(|set| set == loaded.values);
        assert!(known || loaded.values == defaults(), "{what}: a mixture");
        assert_eq!(known, loaded.generation.is_some(), "{what}");
    }
    let next = numbered(500);
    commit(flash, &next).unwrap();
    assert_eq!(load(flash).values, next, "{what}");
}

#[test]
fn a_damaged_word_leaves_a_whole_set_and_is_told_of() {
    // The newest set in the middle of a sector, and at its end.
    for (commits, bits) in [(11, 32), (12, 0)] {
        let flash = filled::<SMALL>(commits);
        (0..flash.words().len()).into_par_iter().for_each(|index| {
            let word = flash.words()[index];
            let mut random = Random::new(index as u64, 1);
            let mut values = vec![0, u32::MAX, !word, random.bits(), random.bits()];
            values.extend((0..bits).map(|bit| word ^ 1 << bit));
            for value in values {
                let mut flash = flash.clone();
                flash.words_mut()[index] = value;
                let what = format!("{commits} commits, word {index:#x} as {value:#x}");
                assert_contained(&mut flash, commits, &what);
            }
        });
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

    #[test]
    fn many_damaged_words_leave_a_whole_set_or_the_defaults(
        commits in 1_u32..14,
        damage in prop::collection::vec((0_usize..SECTORS * SMALL / 4, any::<u32>()), 1..200),
    ) {
        let mut flash = filled::<SMALL>(commits);
        for (index, value) in damage {
            flash.words_mut()[index] = value;
        }
        assert_contained(&mut flash, commits, "many words");
    }

    #[test]
    fn garbage_leaves_the_defaults(seed: u64, mask in prop_oneof![Just(0), Just(u32::MAX), any::<u32>()]) {
        let mut flash = SmallFlash::new(SECTORS);
        for (index, word) in flash.words_mut().iter_mut().enumerate() {
            *word = Random::new(seed, index as u64).bits() | mask;
        }
        let blank = flash.words().iter().all(|word| *word == u32::MAX);
        let loaded = load(&mut flash);
        prop_assert_eq!(loaded.values, defaults());
        prop_assert_eq!(loaded.problem, (!blank).then_some(StoreError::Damaged));
        commit(&mut flash, &numbered(1)).unwrap();
        prop_assert_eq!(load(&mut flash).values, numbered(1));
    }
}

#[test]
fn reading_writes_nothing_and_what_is_stored_is_not_written_again() {
    let mut flash = filled::<SMALL>(5);
    // Also where something is to be repaired.
    flash.cut(Cut {
        operation: flash.operations + 40,
        tear: Tear::Bits(1),
    });
    commit(&mut flash, &numbered(5)).unwrap_err();
    flash.restart();
    let operations = flash.operations;
    assert_eq!(load(&mut flash).problem, Some(StoreError::Unfinished));
    assert_eq!(flash.operations, operations);

    // A commit of the same values settles it, and only then is there nothing to write.
    let generation = commit(&mut flash, &numbered(4)).unwrap();
    assert_eq!(load(&mut flash).problem, None);
    let operations = flash.operations;
    assert_eq!(commit(&mut flash, &numbered(4)), Ok(generation));
    assert_eq!(flash.operations, operations);
}

#[test]
fn a_sector_is_erased_when_seven_of_its_eight_pages_are_full() {
    // Twelve times round all sectors.
    const COMMITS: u32 = 12 * SECTORS as u32 * sets(REAL);
    let mut flash = SimulatedFlash::<REAL>::new(SECTORS);
    let mut before = 0;
    for number in 0..COMMITS {
        before = flash.operations;
        commit(&mut flash, &numbered(number)).unwrap();
    }
    println!(
        "{COMMITS} commits, erases {:?}, words of the last {}",
        flash.erases,
        flash.operations - before
    );
    assert_eq!(flash.erases, [12, 12, 12]);
    // A set, and where it crosses from page to page the marks of both.
    let set = u64::from(RECORD) * (FIELDS as u64 + 2);
    let written = (flash.operations - before) * 4;
    assert!([set, set + 8].contains(&written), "{written}");
}

#[test]
fn a_sector_that_is_worn_out_is_passed_over() {
    for worn in 0..SECTORS {
        let mut flash = filled::<SMALL>(4);
        flash.wear_out(worn);
        for number in 10..30 {
            commit(&mut flash, &numbered(number)).unwrap();
            assert_eq!(load(&mut flash).values, numbered(number));
        }
    }
}

#[test]
fn what_the_flash_does_not_keep_is_written_elsewhere() {
    for index in 0..SECTORS * SMALL / 4 {
        let mut flash = filled::<SMALL>(4);
        flash.weaken(index);
        for number in 10..16 {
            commit(&mut flash, &numbered(number)).unwrap();
            assert_eq!(load(&mut flash).values, numbered(number), "word {index:#x}");
        }
    }
}

#[test]
fn a_flash_that_fails_is_an_error_and_the_defaults() {
    let mut flash = SimulatedFlash::<SMALL>::new(SECTORS);
    flash.cut(Cut {
        operation: 0,
        tear: Tear::None,
    });
    let error = commit(&mut flash, &numbered(0)).unwrap_err();
    assert!(error.to_string().starts_with("the flash failed"), "{error}");
    let error = load(&mut flash).problem.unwrap();
    assert!(error.to_string().starts_with("the flash failed"), "{error}");
    assert_eq!(load(&mut flash).values, defaults());
}

#[test]
fn a_refit_is_taken_over_whole_if_it_is_better_and_within_bounds() {
    let mut flash = filled::<SMALL>(1);
    let present = numbered(0);
    let better = Candidate::from(&Estimate {
        coulomb: 0.13,
        breakaway: 0.17,
        cost: 1.0,
        present_cost: 2.0,
        annealing_evaluations: 0,
        golden_section_evaluations: 0,
        windows: 0,
    });
    let with = |change: &dyn Fn(&mut Candidate)| {
        let mut candidate = better.clone();
        change(&mut candidate);
        candidate
    };
    let no_better = [2.0, 3.0, f64::NAN, f64::INFINITY].map(|cost| with(&|it| it.cost = cost));
    let unknown = [f64::NAN, f64::INFINITY].map(|cost| with(&|it| it.present_cost = cost));
    let out = [-0.1, f32::NAN, f32::INFINITY].map(|value| with(&|it| it.changes[1].1 = value));
    let mut adopt = |candidate: &Candidate| {
        let mut store = Store::new(&mut flash, 0).unwrap();
        let adopted = now(store.adopt(&present, candidate, &disarmed()));
        (adopted, load(&mut flash).values)
    };
    for candidate in no_better.iter().chain(&unknown) {
        let (adopted, stored) = adopt(candidate);
        assert!(matches!(adopted, Err(Rejected::Cost { .. })), "{adopted:?}");
        assert_eq!(stored, present);
    }
    for candidate in &out {
        let (adopted, stored) = adopt(candidate);
        let error = adopted.unwrap_err();
        assert!(
            error
                .to_string()
                .starts_with("static must be 0e0 to 1e2 N·m"),
            "{error}"
        );
        assert_eq!(stored, present, "not even the field that is in order");
    }
    let (adopted, stored) = adopt(&better);
    let mut expected = present;
    expected.set(Field::Coulomb, 0.13).unwrap();
    expected.set(Field::Static, 0.17).unwrap();
    assert_eq!(adopted, Ok(expected));
    assert_eq!(stored, expected);
}

#[test]
fn what_is_forgotten_is_the_default() {
    let mut flash = filled::<SMALL>(5);
    let before = flash.clone();
    now(Store::new(&mut flash, 0).unwrap().forget(&disarmed())).unwrap();
    let loaded = load(&mut flash);
    assert_eq!((loaded.values, loaded.problem), (defaults(), None));
    // As one step too.
    for operation in before.operations..flash.operations {
        let mut flash = before.clone();
        flash.cut(Cut {
            operation,
            tear: Tear::Bits(operation),
        });
        now(Store::new(&mut flash, 0).unwrap().forget(&disarmed())).unwrap_err();
        flash.restart();
        let values = load(&mut flash).values;
        assert!(values == numbered(4) || values == defaults());
    }
}

/// The format of the flash, written here once more from its description.
mod format {
    use super::*;

    pub const COMMIT: u16 = 0x7fff;

    /// CRC of a polynomial in reflected form.
    fn crc(polynomial: u32, initial: u32, bytes: &[u8]) -> u32 {
        !bytes.iter().fold(initial, |crc, byte| {
            (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
                crc >> 1 ^ if crc & 1 == 1 { polynomial } else { 0 }
            })
        })
    }

    fn crc_32(bytes: &[u8]) -> u32 {
        crc(0xedb8_8320, u32::MAX, bytes)
    }

    /// The map's checksum of an item: Castagnoli's with another start, and no first byte of 0 or 0xff.
    fn item_checksum(bytes: &[u8]) -> u32 {
        let crc = crc(0x82f6_3b78, 0xeeee_eeee, bytes);
        if matches!(crc.to_le_bytes()[0], 0 | 0xff) {
            crc ^ 1
        } else {
            crc
        }
    }

    /// The map's checksum of an item's length.
    fn length_checksum(length: u16) -> u16 {
        let crc = length.to_le_bytes().iter().fold(0xffff_u16, |crc, byte| {
            (0..8).fold(crc ^ u16::from(*byte), |crc, _| {
                crc >> 1 ^ if crc & 1 == 1 { 0x1a2e } else { 0 }
            })
        });
        if crc == 0 { 0xfffe } else { !crc }
    }

    pub fn record(key: u16, generation: u32, value: u32) -> Vec<u8> {
        let slot = if generation % 2 == 1 { 0x8000 } else { 0 };
        let mut record = (slot | key).to_le_bytes().to_vec();
        record.extend(generation.to_le_bytes());
        record.extend(value.to_le_bytes());
        record.extend(crc_32(&record).to_le_bytes());
        record
    }

    /// The records of a set.
    pub fn set(generation: u32, schema: u32, fields: &[(u16, u32)]) -> Vec<Vec<u8>> {
        let mut set = vec![record(0, generation, schema)];
        set.extend(
            fields
                .iter()
                .map(|(key, value)| record(*key, generation, *value)),
        );
        let bodies: Vec<&[u8]> = set.iter().map(|record| &record[..10]).collect();
        let checksum = crc_32(&bodies.concat());
        set.push(record(COMMIT, generation, checksum));
        set
    }

    /// A flash with these items in its first sector, and the rest erased.
    pub fn flash<const SECTOR: usize>(items: &[Vec<u8>]) -> SimulatedFlash<SECTOR> {
        let page = SECTOR / 8;
        let mut bytes = vec![0xff; SECTOR];
        let mut at = 0;
        for item in items {
            let length = 8 + item.len().next_multiple_of(4);
            if at % page == 0 {
                bytes[at..at + 4].fill(0);
                at += 4;
            } else if at % page + length > page - 4 {
                let end = at.next_multiple_of(page);
                bytes[end - 4..end].fill(0);
                bytes[end..end + 4].fill(0);
                at = end + 4;
            }
            let place = &mut bytes[at..at + length];
            place.fill(0);
            place[..4].copy_from_slice(&item_checksum(item).to_le_bytes());
            let length_bytes = item.len() as u16;
            place[4..6].copy_from_slice(&length_bytes.to_le_bytes());
            place[6..8].copy_from_slice(&length_checksum(length_bytes).to_le_bytes());
            place[8..8 + item.len()].copy_from_slice(item);
            at += length;
        }
        let mut flash = SimulatedFlash::new(SECTORS);
        for (word, bytes) in flash.words_mut().iter_mut().zip(bytes.as_chunks().0) {
            *word = u32::from_le_bytes(*bytes);
        }
        flash
    }

    /// Keys and values of all fields.
    pub fn fields(values: &Values) -> Vec<(u16, u32)> {
        let numbers = values.iter();
        numbers
            .map(|(field, value)| (field as u16, value.to_bits()))
            .collect()
    }
}

#[test]
fn the_flash_holds_what_is_described() {
    let count = sets(REAL);
    let flash = filled::<REAL>(count);
    let sets = (0..count)
        .map(|number| format::set(number + 1, SCHEMA, &format::fields(&numbered(number))));
    let items: Vec<Vec<u8>> = sets.flatten().collect();
    assert_eq!(flash.words(), format::flash::<REAL>(&items).words());
}

#[test]
fn a_value_out_of_bounds_is_refused_by_name_and_the_default_stays() {
    let stored = numbered(3);
    for field in Field::ALL {
        let description = field.description();
        let bad = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            description.upper.next_up(),
            description.lower.next_down(),
        ];
        for value in bad {
            let mut fields = format::fields(&stored);
            fields[field as usize - 1].1 = value.to_bits();
            let mut flash = format::flash::<SMALL>(&format::set(1, SCHEMA, &fields));
            let loaded = load(&mut flash);
            let [OutOfBounds { field: named, .. }] = loaded.refused[..] else {
                panic!("{field:?} {value}: {:?}", loaded.refused)
            };
            assert_eq!(named, field);
            let message = loaded.refused[0].to_string();
            assert!(message.starts_with(description.name), "{message}");
            let mut expected = stored;
            expected.set(field, defaults().get(field)).unwrap();
            assert_eq!(loaded.values, expected);

            let mut values = stored;
            assert!(values.set(field, value).is_err(), "as on writing");
            assert_eq!(values, stored);
        }
        for value in [description.lower, description.upper] {
            let mut values = stored;
            values.set(field, value).unwrap();
            let mut flash = filled::<SMALL>(1);
            commit(&mut flash, &values).unwrap();
            assert_eq!(load(&mut flash).values, values);
        }
    }
}

#[test]
fn unknown_keys_are_ignored_and_missing_ones_are_defaults() {
    let mut fields = format::fields(&numbered(3));
    fields.remove(Field::Inertia as usize - 1);
    fields.insert(5, (FIELDS as u16 + 1, 77));
    fields.push((0x7000, 78));
    let mut flash = format::flash::<SMALL>(&format::set(9, SCHEMA, &fields));
    let loaded = load(&mut flash);
    let mut expected = numbered(3);
    expected
        .set(Field::Inertia, defaults().get(Field::Inertia))
        .unwrap();
    assert_eq!((loaded.values, loaded.problem), (expected, None));
    assert_eq!(loaded.generation, Some(9));
}

#[test]
fn a_newer_schema_is_refused_until_it_is_forgotten() {
    let mut items = format::set(1, SCHEMA, &format::fields(&numbered(1)));
    items.extend(format::set(2, SCHEMA + 1, &format::fields(&numbered(2))));
    let mut flash = format::flash::<SMALL>(&items);
    let newer = StoreError::NewerSchema(SCHEMA + 1);
    let loaded = load(&mut flash);
    assert_eq!((loaded.values, loaded.problem), (defaults(), Some(newer)));
    assert!(newer.to_string().contains("forget"), "{newer}");
    let before = flash.words().to_vec();
    assert_eq!(commit(&mut flash, &numbered(3)), Err(newer));
    assert_eq!(flash.words(), before);
    now(Store::new(&mut flash, 0).unwrap().forget(&disarmed())).unwrap();
    assert_eq!(load(&mut flash).problem, None);
    commit(&mut flash, &numbered(3)).unwrap();
    assert_eq!(load(&mut flash).values, numbered(3));
}

#[test]
fn an_older_generation_never_passes_for_a_newer_one() {
    // Numbers begin anew behind the last.
    let mut items = format::set(u32::MAX, SCHEMA, &format::fields(&numbered(1)));
    items.extend(format::set(0, SCHEMA, &format::fields(&numbered(2))));
    let mut flash = format::flash::<SMALL>(&items);
    assert_eq!(load(&mut flash).values, numbered(2));
    assert_eq!(commit(&mut flash, &numbered(3)), Ok(1));
    assert_eq!(load(&mut flash).values, numbered(3));
}

#[test]
fn records_that_do_not_belong_together_are_no_set() {
    let fields = format::fields(&numbered(1));
    let whole = format::set(4, SCHEMA, &fields);
    let other = format::set(5, SCHEMA, &format::fields(&numbered(2)));
    let mut damaged = BTreeMap::new();
    for index in 0..whole.len() {
        let mut items = whole.clone();
        items.remove(index);
        damaged.insert(format!("without {index}"), items);
        let mut items = whole.clone();
        items.insert(index, whole[index].clone());
        damaged.insert(format!("with {index} twice"), items);
        if index > 0 {
            let mut items = whole.clone();
            items.swap(index - 1, index);
            damaged.insert(format!("{index} before its time"), items);
        }
        let mut items = whole.clone();
        items[index] = other[index].clone();
        damaged.insert(format!("{index} of another generation"), items);
    }
    for (what, items) in damaged {
        let mut flash = format::flash::<SMALL>(&items);
        let loaded = load(&mut flash);
        // The commit twice makes no set of the second, and takes none from the first.
        if what == format!("with {} twice", whole.len() - 1) {
            assert_eq!(loaded.values, numbered(1));
            continue;
        }
        assert_eq!(loaded.values, defaults(), "{what}");
        assert_eq!(loaded.problem, Some(StoreError::Damaged), "{what}");
    }
}

#[test]
fn items_of_others_do_no_harm() {
    // All of them with the map's checksums in order.
    for length in [0, 1, 2, 13, 15, 33, 100] {
        let mut items = vec![vec![0; length]];
        items.extend(format::set(1, SCHEMA, &format::fields(&numbered(1))));
        items.push(vec![0xa5; length]);
        let mut flash = format::flash::<SMALL>(&items);
        let loaded = load(&mut flash);
        assert_eq!(loaded.values, numbered(1), "{length}");
        assert_eq!(loaded.problem, Some(StoreError::Unfinished), "{length}");
        commit(&mut flash, &numbered(2)).unwrap();
        assert_eq!(load(&mut flash).values, numbered(2), "{length}");
    }
}
