//! What a file holds.

use std::io::{self, Write};

/// Columns of numbers, of one length or of several.
#[derive(Debug, Default)]
pub struct Columns {
    /// How the file is laid out, in words.
    pub layout: String,
    /// The columns, in the file's order.
    pub columns: Vec<Column>,
}

/// One of them.
#[derive(Debug)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its unit as the file spells it, empty where it says none.
    pub unit: String,
    /// Which of the file's groups of rows it is of, from 0: those of one group have one length and one time.
    pub group: usize,
    /// Row by row; NaN where there is no number.
    pub values: Vec<f64>,
}

impl Columns {
    /// Writes the line that says what there is, and the numbers.
    pub(crate) fn write(&self, to: &mut impl Write) -> io::Result<()> {
        let columns: Vec<serde_json::Value> = self
            .columns
            .iter()
            .map(|column| {
                serde_json::json!({
                    "name": column.name,
                    "unit": column.unit,
                    "group": column.group,
                    "length": column.values.len(),
                })
            })
            .collect();
        let head = serde_json::json!({ "layout": self.layout, "columns": columns });
        writeln!(to, "{head}")?;
        for column in &self.columns {
            let bytes: Vec<u8> = column
                .values
                .iter()
                .flat_map(|value| value.to_le_bytes())
                .collect();
            to.write_all(&bytes)?;
        }
        to.flush()
    }
}

/// Refuses more numbers than may be.
#[cfg(any(feature = "mcap", feature = "mdf", feature = "parquet"))]
pub(crate) fn check_size(numbers: usize, most: usize) -> Result<(), String> {
    if numbers.saturating_mul(size_of::<f64>()) <= most {
        return Ok(());
    }
    let megabytes = most >> 20;
    Err(format!(
        "unpacks to more than {megabytes} MB; cut it into shorter files"
    ))
}

/// Nanoseconds since the first stamp, in seconds: what a calendar's nanoseconds are too large for `f64` for.
#[cfg(any(feature = "mcap", feature = "parquet"))]
pub(crate) fn seconds_since(first: i128, stamp: i128, units_per_second: f64) -> f64 {
    (stamp - first) as f64 / units_per_second
}
