//! Numeric arrays of a MATLAB file of level 5 (versions 5 to 7.2).
//!
//! Source: The MathWorks, *MAT-File Format*, chapter 1: a header of 128 bytes, then data elements, each a
//! tag (type, bytes) with its data; a compressed element is one element behind zlib. Cells, structures,
//! objects, texts and sparse arrays are left out, and complex arrays keep their real part. The crate
//! `matfile` was looked at: it refuses numbers that MATLAB stores in bytes or words of fewer bits, which
//! is what it does to whole numbers.

use flate2::read::ZlibDecoder;

use super::raw::{Column, Raw, not_unpacked};
use crate::error::{LARGEST_DATA, read_at_most};
use crate::log::counted;

const HEADER: usize = 128;
const VERSION: u16 = 0x0100;
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const DAMAGED: &str = "is a damaged MATLAB file: an element ends beyond the file";

/// Whether the bytes are such a file: its version, in the byte order that its mark says.
pub(super) fn is_it(bytes: &[u8]) -> bool {
    Order::of(bytes).is_some()
}

#[derive(Clone, Copy)]
enum Order {
    Little,
    Big,
}

impl Order {
    fn of(bytes: &[u8]) -> Option<Self> {
        let version = [*bytes.get(124)?, *bytes.get(125)?];
        match (bytes.get(126..HEADER)?, version) {
            (b"IM", version) if u16::from_le_bytes(version) == VERSION => Some(Self::Little),
            (b"MI", version) if u16::from_be_bytes(version) == VERSION => Some(Self::Big),
            _ => None,
        }
    }

    /// The bytes of a number, the least significant first.
    fn array<const N: usize>(self, bytes: &[u8]) -> [u8; N] {
        let mut array = [0; N];
        array.copy_from_slice(&bytes[..N]);
        if matches!(self, Self::Big) {
            array.reverse();
        }
        array
    }

    fn word(self, bytes: &[u8]) -> Option<u32> {
        (bytes.len() >= 4).then(|| u32::from_le_bytes(self.array(bytes)))
    }
}

/// One data element: its type and its data.
struct Element<'b> {
    kind: u32,
    data: &'b [u8],
}

impl<'b> Element<'b> {
    /// The first element, and what follows it.
    fn first(bytes: &'b [u8], order: Order) -> Option<(Self, &'b [u8])> {
        let tag = order.word(bytes)?;
        // A small element has its length in the upper half of the tag, its data behind it.
        let small = tag >> 16;
        if small != 0 {
            let kind = tag & 0xffff;
            let data = bytes.get(4..4 + small as usize)?;
            return Some((Self { kind, data }, bytes.get(8..).unwrap_or_default()));
        }
        let length = order.word(&bytes[4..])? as usize;
        let data = bytes.get(8..8usize.checked_add(length)?)?;
        // All but compressed elements end at a multiple of eight bytes; the last one may not.
        let padded = match tag {
            COMPRESSED => 8 + length,
            _ => 8 + length.next_multiple_of(8),
        };
        let rest = bytes.get(padded..).unwrap_or_default();
        Some((Self { kind: tag, data }, rest))
    }

    /// Its numbers; `None` where it holds none.
    fn numbers(&self, order: Order) -> Option<Vec<f64>> {
        macro_rules! each {
            ($type:ty) => {
                self.data
                    .chunks_exact(size_of::<$type>())
                    .map(|bytes| <$type>::from_le_bytes(order.array(bytes)) as f64)
                    .collect()
            };
        }
        Some(match self.kind {
            1 => each!(i8),
            2 => each!(u8),
            3 => each!(i16),
            4 => each!(u16),
            5 => each!(i32),
            6 => each!(u32),
            7 => each!(f32),
            9 => each!(f64),
            12 => each!(i64),
            13 => each!(u64),
            _ => return None,
        })
    }
}

/// A numeric array.
struct Array {
    name: String,
    rows: usize,
    columns: usize,
    values: Vec<f64>,
}

/// Reads the arrays of a file as columns: a vector under its name, the columns of a matrix (its rows, if
/// it has fewer of them) as `name.1`, `name.2`. Single numbers are no columns.
///
/// # Errors
/// A damaged file, or one without a numeric array.
pub(super) fn read(bytes: &[u8]) -> Result<Raw, String> {
    let order = Order::of(bytes).ok_or(DAMAGED)?;
    let mut arrays = Vec::new();
    let mut others = 0;
    let mut rest = &bytes[HEADER..];
    // What all elements together may still unpack to, bytes.
    let mut left = LARGEST_DATA;
    while rest.len() >= 8 {
        let (element, next) = Element::first(rest, order).ok_or(DAMAGED)?;
        rest = next;
        let unpacked;
        let matrix = if element.kind == COMPRESSED {
            unpacked = read_at_most(ZlibDecoder::new(element.data), left)
                .map_err(|error| not_unpacked("MATLAB file", &error))?;
            left -= unpacked.len() as u64;
            Element::first(&unpacked, order).ok_or(DAMAGED)?.0
        } else {
            element
        };
        match array(&matrix, order) {
            Some(array) if array.values.len() > 1 => arrays.push(array),
            Some(_) => {}
            None => others += 1,
        }
    }
    let mut raw = Raw::default();
    for array in &arrays {
        push(&mut raw, array);
    }
    if raw.columns.is_empty() {
        return Err(format!(
            "has no numeric array ({} of other kinds); expected vectors: take them out of structures, \
             cells and tables, as by t = data.t; u = data.u; x = data.x; save('F.mat', 't', 'u', 'x', '-v7')",
            counted(others, "variable")
        ));
    }
    let longest = raw.columns.iter().map(|column| column.values.len()).max();
    raw.lines = (1..=longest.unwrap_or(0)).collect();
    raw.units = vec![None; raw.names.len()];
    raw.layout = format!("MATLAB, {}", counted(arrays.len(), "array"));
    if others > 0 {
        raw.layout += &format!(", {} left out", counted(others, "other variable"));
    }
    Ok(raw)
}

/// The array that an element holds, if it is a numeric one.
fn array(element: &Element, order: Order) -> Option<Array> {
    if element.kind != MATRIX {
        return None;
    }
    let (flags, rest) = Element::first(element.data, order)?;
    // Double, single and the integers; below them cells, structures, objects, texts, sparse arrays.
    if !(6..=15).contains(&(order.word(flags.data)? & 0xff)) {
        return None;
    }
    let (dimensions, rest) = Element::first(rest, order)?;
    let (name, rest) = Element::first(rest, order)?;
    let (real, _) = Element::first(rest, order)?;
    let dimensions = dimensions.numbers(order)?;
    let values = real.numbers(order)?;
    let rows = *dimensions.first()? as usize;
    let columns = dimensions[1..].iter().product::<f64>() as usize;
    (rows.checked_mul(columns)? == values.len()).then(|| Array {
        name: String::from_utf8_lossy(name.data).into_owned(),
        rows,
        columns,
        values,
    })
}

fn push(raw: &mut Raw, array: &Array) {
    let (length, count) = (array.rows.max(array.columns), array.rows.min(array.columns));
    for series in 0..count {
        // Arrays are stored column by column.
        let at = |sample: usize| match array.rows >= array.columns {
            true => series * array.rows + sample,
            false => sample * array.rows + series,
        };
        raw.names.push(match count {
            1 => array.name.clone(),
            _ => format!("{}.{}", array.name, series + 1),
        });
        let values = (0..length).map(|sample| array.values[at(sample)]);
        raw.columns.push(Column::of(values.collect()));
    }
}
