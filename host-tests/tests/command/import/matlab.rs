//! MATLAB files, built from *MAT-File Format* of The MathWorks.

use super::*;

#[derive(Clone, Copy)]
struct Writer {
    big: bool,
    packed: bool,
}

impl Writer {
    fn word(self, value: u32) -> [u8; 4] {
        if self.big {
            value.to_be_bytes()
        } else {
            value.to_le_bytes()
        }
    }

    fn element(self, kind: u32, data: &[u8]) -> Vec<u8> {
        // Up to four bytes stand in the tag itself.
        let mut bytes = if !data.is_empty() && data.len() <= 4 {
            self.word((data.len() as u32) << 16 | kind).to_vec()
        } else {
            [self.word(kind), self.word(data.len() as u32)].concat()
        };
        bytes.extend(data);
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        bytes
    }

    fn doubles(self, values: &[f64]) -> Vec<u8> {
        let bytes = |value: &f64| {
            if self.big {
                value.to_be_bytes()
            } else {
                value.to_le_bytes()
            }
        };
        self.element(9, &values.iter().flat_map(bytes).collect::<Vec<u8>>())
    }

    /// A variable; `real` is the element of its numbers.
    fn array(self, class: u32, name: &str, size: (u32, u32), real: &[u8]) -> Vec<u8> {
        let flags = self.element(6, &[self.word(class), self.word(0)].concat());
        let size = self.element(5, &[self.word(size.0), self.word(size.1)].concat());
        let name = self.element(1, name.as_bytes());
        let matrix = self.element(14, &[&flags[..], &size, &name, real].concat());
        if !self.packed {
            return matrix;
        }
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(&matrix).expect("memory");
        let packed = packed.finish().expect("memory");
        // No padding behind a compressed element.
        [&self.word(15)[..], &self.word(packed.len() as u32), &packed].concat()
    }

    fn file(self, variables: &[Vec<u8>]) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file, Platform: test".to_vec();
        bytes.resize(124, b' ');
        bytes.extend(if self.big {
            *b"\x01\x00MI"
        } else {
            *b"\x00\x01IM"
        });
        bytes.extend(variables.concat());
        bytes
    }
}

const ROWS: usize = 300;

fn time(k: usize) -> f64 {
    k as f64 * 1e-3
}

fn position(k: usize) -> f64 {
    (7.0 * time(k)).sin()
}

fn input(k: usize) -> i16 {
    (k % 11) as i16 - 5
}

fn file(writer: Writer) -> Vec<u8> {
    let column = |rule: fn(usize) -> f64| (0..ROWS).map(rule).collect::<Vec<f64>>();
    let rows = ROWS as u32;
    // MATLAB stores whole numbers of a double array in fewer bytes.
    let small: Vec<u8> = (0..ROWS)
        .flat_map(|k| {
            if writer.big {
                input(k).to_be_bytes()
            } else {
                input(k).to_le_bytes()
            }
        })
        .collect();
    let two = [column(position), column(time)].concat();
    let mut text = writer.array(4, "note", (1, 2), &writer.element(17, &[65, 0, 66, 0]));
    text.extend(writer.array(2, "settings", (1, 1), &writer.element(5, &[0; 4])));
    writer.file(&[
        text,
        writer.array(6, "t", (rows, 1), &writer.doubles(&column(time))),
        writer.array(6, "vir", (1, rows), &writer.element(3, &small)),
        writer.array(6, "both", (rows, 2), &writer.doubles(&two)),
        writer.array(6, "gain", (1, 1), &writer.doubles(&[3.0])),
    ])
}

/// A file with a vector of each name, the first of which is time.
pub fn of_vectors(names: &[&str]) -> Vec<u8> {
    let writer = Writer {
        big: false,
        packed: true,
    };
    let vectors = names.iter().enumerate().map(|(place, name)| {
        let rule = if place == 0 { time } else { position };
        let values: Vec<f64> = (0..ROWS).map(rule).collect();
        writer.array(6, name, (ROWS as u32, 1), &writer.doubles(&values))
    });
    writer.file(&vectors.collect::<Vec<_>>())
}

/// Such a file of a processor with the least significant byte first.
pub(super) fn whole(packed: bool) -> Vec<u8> {
    file(Writer { big: false, packed })
}

#[test]
fn numeric_arrays_are_read_in_either_byte_order_packed_or_not() {
    for big in [false, true] {
        for packed in [false, true] {
            let place = Place::with("raw.mat", file(Writer { big, packed }));
            let (log, said) = place.import("raw.mat --time t --input vir --position both.1");
            assert_eq!((log.samples(), log.period_s), (ROWS, 1e-3));
            near(&log.input, |k| f64::from(input(k)));
            near(&log.position, position);
            assert!(
                said.contains("MATLAB, 3 arrays, 2 other variables left out"),
                "{said}"
            );
            assert!(said.contains("not asked for: both.2"), "{said}");
        }
    }
}

#[test]
fn a_file_without_vectors_or_of_another_version_is_refused() {
    let little = Writer {
        big: false,
        packed: false,
    };
    let words = "import raw.mat --time t --input vir --position both.1 --out log.csv";
    let whole = file(little);
    Place::with("raw.mat", &whole[..whole.len() - 900]).refuses(words, &["damaged MATLAB"]);
    let settings = little.array(2, "settings", (1, 1), &little.element(5, &[0; 4]));
    Place::with("raw.mat", little.file(&[settings]))
        .refuses(words, &["no numeric array", "1 variable", "-v7"]);
    Place::with("raw.mat", b"MATLAB 7.3 MAT-file, Platform: GLNXA64")
        .refuses(words, &["7.3", "save('F.mat', '-v7')"]);
    let other = Place::with("raw.mat", file(little));
    other.refuses(
        "import raw.mat --time t --input u --position both.1 --out log.csv",
        &["--input", "\"u\"", "t, vir, both.1, both.2"],
    );
}

#[test]
fn as_a_log_it_is_refused_with_the_call_that_imports_it() {
    for packed in [false, true] {
        let said = Log::of_bytes("F.mat".as_ref(), whole(packed)).expect_err("no CSV");
        assert!(said.message.contains("is a MATLAB file"), "{said}");
        assert!(said.message.contains("cargo hil import F.mat"), "{said}");
    }
    let little = Writer {
        big: false,
        packed: false,
    };
    let structure = little.array(2, "data", (1, 1), &little.element(5, &[0; 4]));
    let said = Log::of_bytes("F.mat".as_ref(), little.file(&[structure])).expect_err("no CSV");
    assert!(
        said.message.contains("take them out of structures"),
        "{said}"
    );
}
