//! A file that is damaged anywhere, in any format: a sound log, or a refusal in one line that names the file.
//! The files are whole before, so that the damage reaches what stands behind their heads.

use host_tests::exercise;
use proptest::prelude::*;
use proptest::sample::{Index, select};

use super::formats::{mcap, motion_of_ros_2, sample};
use super::matlab;
use super::*;

/// What befalls a file.
#[derive(Debug, Clone)]
enum Damage {
    /// Other bytes stand where some were.
    Over(Index, Vec<u8>),
    /// Some are gone.
    Without(Index, usize),
    /// Some are there once more, elsewhere.
    Again(Index, usize, Index),
    /// The rest is gone.
    CutAt(Index),
}

impl Damage {
    fn befall(&self, bytes: &mut Vec<u8>) {
        if bytes.is_empty() {
            return;
        }
        let place = |index: &Index| index.index(bytes.len());
        let end = |begin: usize, length: usize| (begin + length).min(bytes.len());
        match self {
            Self::Over(at, other) => {
                let at = place(at);
                let end = end(at, other.len());
                bytes[at..end].copy_from_slice(&other[..end - at]);
            }
            Self::Without(at, length) => {
                let at = place(at);
                bytes.drain(at..end(at, *length));
            }
            Self::Again(at, length, to) => {
                let (at, to) = (place(at), place(to));
                let some = bytes[at..end(at, *length)].to_vec();
                bytes.splice(to..to, some);
            }
            Self::CutAt(at) => bytes.truncate(place(at)),
        }
    }
}

fn damage() -> impl Strategy<Value = Damage> {
    let at = any::<Index>;
    let other = prop_oneof![
        prop::collection::vec(any::<u8>(), 1..9),
        // What a length or a count is at its ends.
        select(vec![
            vec![0; 8],
            vec![0xff; 4],
            vec![0xff; 8],
            vec![0xff, 0xff, 0xff, 0x7f]
        ]),
        // What a text is made of.
        "[-+0-9eE.,;\"#\r\n \t]{1,9}".prop_map(String::into_bytes),
    ];
    prop_oneof![
        4 => (at(), other).prop_map(|(at, other)| Damage::Over(at, other)),
        2 => (at(), 1_usize..64).prop_map(|(at, length)| Damage::Without(at, length)),
        2 => (at(), 1_usize..64, at()).prop_map(|(at, length, to)| Damage::Again(at, length, to)),
        1 => at().prop_map(Damage::CutAt),
    ]
}

fn damages() -> impl Strategy<Value = Vec<Damage>> {
    prop::collection::vec(damage(), 1..5)
}

fn damaged(whole: &[u8], damages: &[Damage]) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    damages.iter().for_each(|damage| damage.befall(&mut bytes));
    bytes
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::fast());
    packed.write_all(bytes).expect("memory");
    packed.finish().expect("memory")
}

/// Imports these bytes by these words.
#[track_caller]
fn import(bytes: &[u8], words: &str) {
    let place = Place::with("raw", bytes);
    let output = place.run(&format!("import raw {words} --out log.csv"));
    let said = text(&output.stderr);
    match output.status.code() {
        Some(0) => drop(Log::read(&place.path("log.csv")).expect("a log")),
        Some(2) => {
            assert_eq!(said.lines().count(), 1, "{said}");
            // A column may be called otherwise now: then the option that asks for it is named.
            let named = ["error: raw:", "error: --"];
            assert!(named.iter().any(|named| said.starts_with(named)), "{said}");
            assert_eq!(place.names(), ["raw"]);
        }
        _ => panic!("{}: {said}", output.status),
    }
}

/// Files that this program reads itself, each with the columns of a log.
fn files() -> Vec<(Vec<u8>, &'static str)> {
    const NUMBERS: &str = "--time 1:ms --input 2 --position 3";
    const NAMES: &str = "--time t --input vir --position both.1";
    let row = |k: usize| format!("{k},{}.5,{}e-1", k % 7, k * k);
    let commas = rows("t,u,x", 150, row);
    let german = |k: usize| format!("{k};\"{},5\";-{},25", k % 7, k * k);
    let semicolons = rows("# a logger's\nt [ms];u [%];x [°]", 150, german);
    let tabs = commas.replace(',', "\t");
    let wide = [0xfeff]
        .into_iter()
        .chain(tabs.encode_utf16())
        .flat_map(u16::to_le_bytes);
    vec![
        (commas.into_bytes(), NUMBERS),
        (semicolons.into_bytes(), NUMBERS),
        (wide.collect(), NUMBERS),
        (matlab::whole(false), NAMES),
        (matlab::whole(true), NAMES),
    ]
}

const OPTIONS: [&str; 3] = ["", " --sort --skip-bad", " --unwrap 2 --rate 500"];

/// Files of other people's writers, each with the columns of a log.
fn samples() -> Vec<(Vec<u8>, &'static str)> {
    let sample = |name: &str| fs::read(sample(name).path(name)).expect("a sample");
    let plain = "--rate 1000 --position pos --input duty";
    vec![
        (sample("run-snappy.parquet"), plain),
        (sample("run-zstd.parquet"), plain),
        (sample("run.mf4"), plain),
        (
            sample("run-json.mcap"),
            "--rate 1000 --position pos --input drive.duty",
        ),
        (
            mcap(&motion_of_ros_2(5)),
            "--time log_time --position position --input input",
        ),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn is_read_or_refused(
        (whole, words) in select(files()),
        options in select(OPTIONS.to_vec()),
        damages in damages(),
    ) {
        let bytes = damaged(&whole, &damages);
        import(&bytes, &format!("{words}{options}"));
        // As a log it is looked at for the call that would import it.
        exercise::log(&bytes);
    }

    #[test]
    fn is_read_or_refused_behind_gzip(
        (whole, words) in select(files()),
        damages in damages(),
        is_inside in any::<bool>(),
    ) {
        let bytes = if is_inside {
            packed(&damaged(&whole, &damages))
        } else {
            damaged(&packed(&whole), &damages)
        };
        import(&bytes, words);
    }

    #[test]
    #[ignore = "at length: the readers are built"]
    fn is_read_or_refused_by_its_reader(
        (whole, words) in select(samples()),
        damages in damages(),
    ) {
        import(&damaged(&whole, &damages), words);
    }
}
