//! A command from a file: positions over time, a straight line from each to the next.

use std::path::Path;

use crate::error::{InputError, LARGEST_DATA, read_text};

/// What the file should have been, for messages.
const EXPECTED: &str = "a command (CSV with the columns time_s, command)";

/// Reads a command and samples it at `rate` for `seconds`; after its last row it stays there.
///
/// # Errors
/// Columns that are missing, a field that is no finite number, times that do not rise, with the line.
pub fn read(path: &Path, rate: f64, seconds: f64) -> Result<Vec<f64>, InputError> {
    let text = read_text(path, EXPECTED, LARGEST_DATA)?;
    let fault = |line, message: String| InputError::new(path, Some(line), message);
    let mut lines = text.lines().enumerate();
    let header: Vec<&str> = lines
        .next()
        .map(|(_, line)| line.split(',').map(str::trim).collect())
        .unwrap_or_default();
    let column = |name: &str| {
        let missing = || fault(1, format!("no column `{name}`; expected {EXPECTED}"));
        header
            .iter()
            .position(|column| *column == name)
            .ok_or_else(missing)
    };
    let columns = [column("time_s")?, column("command")?];
    let mut points: Vec<[f64; 2]> = Vec::new();
    for (index, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let mut point = [0.0; 2];
        for (value, &column) in point.iter_mut().zip(&columns) {
            let field = fields.get(column).copied().unwrap_or_default();
            *value = match field.parse::<f64>() {
                Ok(value) if value.is_finite() => value,
                _ => {
                    let message = format!("`{field}` in `{}`: expected a number", header[column]);
                    return Err(fault(index + 1, message));
                }
            };
        }
        if points.last().is_some_and(|last| point[0] <= last[0]) {
            let message = format!("time {} s: expected times that rise", point[0]);
            return Err(fault(index + 1, message));
        }
        points.push(point);
    }
    if points.is_empty() {
        let message = format!("no rows; expected {EXPECTED}");
        return Err(InputError::new(path, None, message));
    }
    let samples = (rate * seconds).round() as usize;
    Ok((0..samples)
        .map(|sample| at(&points, sample as f64 / rate))
        .collect())
}

/// The command at a time, between points of which there is at least one.
fn at(points: &[[f64; 2]], time: f64) -> f64 {
    let next = points.partition_point(|point| point[0] <= time);
    match (
        next.checked_sub(1).map(|last| points[last]),
        points.get(next),
    ) {
        (Some(last), Some(next)) => {
            last[1] + (time - last[0]) / (next[0] - last[0]) * (next[1] - last[1])
        }
        (Some(only), None) => only[1],
        (None, _) => points[0][1],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text_as_file(text: &str) -> Result<Vec<f64>, InputError> {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("command.csv");
        std::fs::write(&path, text).unwrap();
        read(&path, 4.0, 1.5)
    }

    #[test]
    fn straight_lines_lead_from_row_to_row() {
        let text = "command, time_s\n2,0.25\n4,0.75\n";
        let values = read_text_as_file(text).unwrap();
        assert_eq!(values, [2.0, 2.0, 3.0, 4.0, 4.0, 4.0]);
    }

    #[test]
    fn what_is_no_command_is_refused_with_its_line() {
        for (text, line, part) in [
            ("time_s,position\n0,0\n", Some(1), "no column `command`"),
            ("time_s,command\n0,0\n1,much\n", Some(3), "`much`"),
            ("time_s,command\n0,0\n0,1\n", Some(3), "times that rise"),
            ("time_s,command\n0,NaN\n", Some(2), "`NaN`"),
            ("time_s,command\n", None, "no rows"),
        ] {
            let error = read_text_as_file(text).unwrap_err();
            assert_eq!(error.line, line, "{text}");
            assert!(error.message.contains(part), "{error}");
        }
    }
}
