//! Parquet: the flat columns of numbers.

use bytes::Bytes;
use parquet::basic::{LogicalType, TimeUnit};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::DataType;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;

use crate::columns::{Column, Columns, check_size, seconds_since};

/// Rows that are decoded at once.
const BATCH: usize = 65_536;

/// Reads the columns that hold one number a row. Time stamps become seconds since the first.
pub fn read(bytes: Vec<u8>, most: usize) -> Result<Columns, String> {
    let damaged = |error: ParquetError| match error {
        // Brotli and LZO, which are rare.
        ParquetError::General(said) if said.contains("Disabled feature") => format!(
            "is compressed in a way that is not read ({said}); expected snappy, gzip, zstd, lz4 or none"
        ),
        error => format!("is a damaged Parquet file ({error})"),
    };
    let file = SerializedFileReader::new(Bytes::from(bytes)).map_err(damaged)?;
    let metadata = file.metadata().file_metadata();
    let rows = usize::try_from(metadata.num_rows()).unwrap_or(usize::MAX);
    let schema = metadata.schema_descr_ptr();
    let numeric = |column: &usize| is_numeric(&schema.column(*column));
    let kept: Vec<usize> = (0..schema.num_columns()).filter(numeric).collect();
    check_size(rows.saturating_mul(kept.len()), most)?;
    let mut columns = Vec::with_capacity(kept.len());
    for &column in &kept {
        let descriptor = schema.column(column);
        let mut cells = Vec::new();
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group).map_err(damaged)?;
            let reader = group.get_column_reader(column).map_err(damaged)?;
            take(reader, descriptor.max_def_level(), &mut cells).map_err(damaged)?;
            check_size(cells.len().saturating_mul(kept.len()), most)?;
        }
        columns.push(Column {
            name: descriptor.path().string(),
            unit: String::new(),
            group: 0,
            values: values(&cells, &descriptor),
        });
    }
    if columns.is_empty() {
        return Err("has no column of numbers; expected one number a row and column".to_owned());
    }
    let others = schema.num_columns() - kept.len();
    let mut layout = format!("Parquet, columns of numbers: {}", kept.len());
    if others > 0 {
        layout += &format!(", others left out: {others}");
    }
    Ok(Columns { layout, columns })
}

fn is_numeric(descriptor: &ColumnDescriptor) -> bool {
    use parquet::basic::Type;
    let one_a_row = descriptor.max_rep_level() == 0;
    let physical = matches!(
        descriptor.physical_type(),
        Type::BOOLEAN | Type::INT32 | Type::INT64 | Type::FLOAT | Type::DOUBLE
    );
    one_a_row && physical
}

/// A number as it stands in the file.
#[derive(Clone, Copy)]
enum Cell {
    None,
    Whole(i64),
    Real(f64),
}

fn take(reader: ColumnReader, level: i16, into: &mut Vec<Cell>) -> Result<(), ParquetError> {
    let whole = |number: i64| Cell::Whole(number);
    match reader {
        ColumnReader::BoolColumnReader(reader) => {
            each(reader, level, |&value| whole(value.into()), into)
        }
        ColumnReader::Int32ColumnReader(reader) => {
            each(reader, level, |&value| whole(value.into()), into)
        }
        ColumnReader::Int64ColumnReader(reader) => each(reader, level, |&value| whole(value), into),
        ColumnReader::FloatColumnReader(reader) => {
            each(reader, level, |&value| Cell::Real(value.into()), into)
        }
        ColumnReader::DoubleColumnReader(reader) => {
            each(reader, level, |&value| Cell::Real(value), into)
        }
        _ => Ok(()),
    }
}

fn each<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    level: i16,
    cell: impl Fn(&T::T) -> Cell,
    into: &mut Vec<Cell>,
) -> Result<(), ParquetError> {
    loop {
        let (mut levels, mut values) = (Vec::new(), Vec::new());
        let (rows, ..) = reader.read_records(BATCH, Some(&mut levels), None, &mut values)?;
        if rows == 0 {
            return Ok(());
        }
        let mut values = values.iter();
        if level == 0 {
            into.extend(values.map(&cell));
            continue;
        }
        into.extend(levels.iter().map(|&defined| {
            let value = (defined == level).then(|| values.next()).flatten();
            value.map_or(Cell::None, &cell)
        }));
    }
}

/// What the cells mean: a count without sign, a decimal fraction, a time stamp, or just a number.
fn values(cells: &[Cell], descriptor: &ColumnDescriptor) -> Vec<f64> {
    let first = cells.iter().find_map(|cell| match cell {
        Cell::Whole(number) => Some(i128::from(*number)),
        _ => None,
    });
    let logical = descriptor.logical_type_ref();
    let bits = match descriptor.physical_type() {
        parquet::basic::Type::INT32 => 32,
        _ => 64,
    };
    let meaning = |number: i64| match logical {
        Some(LogicalType::Timestamp(stamp)) => {
            let units = match stamp.unit {
                TimeUnit::MILLIS => 1e3,
                TimeUnit::MICROS => 1e6,
                TimeUnit::NANOS => 1e9,
            };
            seconds_since(first.unwrap_or(0), number.into(), units)
        }
        Some(LogicalType::Integer(integer)) if !integer.is_signed && bits == 32 => {
            f64::from(number as u32)
        }
        Some(LogicalType::Integer(integer)) if !integer.is_signed => number as u64 as f64,
        Some(LogicalType::Decimal(decimal)) => number as f64 / 10_f64.powi(decimal.scale),
        _ => number as f64,
    };
    cells
        .iter()
        .map(|cell| match *cell {
            Cell::None => f64::NAN,
            Cell::Whole(number) => meaning(number),
            Cell::Real(value) => value,
        })
        .collect()
}
