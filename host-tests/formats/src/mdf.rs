//! MDF 4: the channels of numbers, with the units and the conversions that the file says.

use falcon_mdf::Mf4File;
use falcon_mdf::error::Mf4Error;

use crate::columns::{Column, Columns, check_size};

/// Reads the channels that hold one number a sample, with the times that a group of them has. Channels of one
/// group have one length. A name that stands in several groups gets its group's number from 1: `t`, `t.2`.
pub fn read(bytes: Vec<u8>, most: usize) -> Result<Columns, String> {
    let damaged = |error: Mf4Error| format!("is an MDF file that cannot be read ({error})");
    let file = Mf4File::from_bytes(bytes).map_err(damaged)?;
    let groups = file
        .data_groups()
        .iter()
        .flat_map(|data| &data.channel_groups);
    let mut columns: Vec<Column> = Vec::new();
    let (mut filled, mut others, mut size) = (0, 0, 0_usize);
    for group in groups.filter(|group| group.sample_count > 0) {
        filled += 1;
        for channel in &group.channels {
            if !channel.is_numeric() || channel.array_shape.is_some() {
                others += 1;
                continue;
            }
            let samples = usize::try_from(group.sample_count).unwrap_or(usize::MAX);
            size = size.saturating_add(samples);
            check_size(size, most)?;
            let signal = file.signal(channel).map_err(damaged)?;
            let read = signal.values().map_err(damaged)?;
            if !read.kind().is_numeric() {
                others += 1;
                continue;
            }
            let mut values = read.to_f64();
            for (value, valid) in values
                .iter_mut()
                .zip(signal.validity().into_iter().flatten())
            {
                if !valid {
                    *value = f64::NAN;
                }
            }
            let is_taken = columns.iter().any(|column| column.name == channel.name);
            columns.push(Column {
                name: if is_taken {
                    format!("{}.{filled}", channel.name)
                } else {
                    channel.name.clone()
                },
                unit: channel.unit.clone(),
                group: filled - 1,
                values,
            });
        }
    }
    if columns.is_empty() {
        return Err("has no channel of numbers; bus frames have to be decoded first".to_owned());
    }
    let mut layout = format!(
        "MDF {}, channel groups: {filled}, channels of numbers: {}",
        file.version(),
        columns.len()
    );
    if others > 0 {
        layout += &format!(", others left out: {others}");
    }
    Ok(Columns { layout, columns })
}
