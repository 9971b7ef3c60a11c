//! A model as a TOML file.
//!
//! ```toml
//! period = 0.01                 # sample time, s
//! lower_limit = 0.0             # least position, rad or m
//! upper_limit = 1.57
//!
//! [[cells]]                     # 1 to 10
//! region = { position = -0.003, change = 0.8, input = 0.004, constant = 0.001 }
//! growth = { position = -0.007, change = 0.77, input = 0.005, constant = 0.013 }
//! ```

use std::path::Path;

use model_core::plant::piecewise_affine::{Parameters, PiecewiseAffine};

use crate::error::{InputError, LARGEST_DECLARATION, line_of, read_text};
use crate::failure::Failure;
use crate::outputs::write_own;

/// What the numbers are, for whoever opens the file.
const HEAD: &str = "\
# A piecewise affine model, in SI. The cell whose region is the largest holds, and in a period of its
# the position grows by its growth, as far as the limits let it. Both are affine in the last position, its
# change in the period before, and the mean of the input over the period.
";

/// Writes a model, every number with the digits that give it back unchanged.
///
/// # Errors
/// What the file system reports.
pub fn write(model: &PiecewiseAffine, path: &Path) -> Result<(), Failure> {
    let text =
        toml::to_string(model.parameters()).map_err(|error| Failure::other(error.to_string()))?;
    write_own(path, HEAD.to_owned() + &text)
}

/// Reads a model.
///
/// # Errors
/// What is wrong with the file, and where.
pub fn read(path: &Path) -> Result<PiecewiseAffine, InputError> {
    let text = read_text(path, "a piecewise affine model (TOML)", LARGEST_DECLARATION)?;
    let parameters: Parameters = toml::from_str(&text).map_err(|error: toml::de::Error| {
        let start = error.span().map_or(0, |span| span.start);
        let line = line_of(text.as_bytes(), start);
        InputError::new(path, Some(line), error.message())
    })?;
    PiecewiseAffine::build(parameters)
        .map_err(|error| InputError::new(path, None, error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pwa::model::tests::example;

    #[test]
    fn a_model_is_read_as_it_was_written() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("model.toml");
        let mut model = example();
        // Numbers without a short decimal form.
        model.cells[1].growth = [1.0 / 3.0, -2.0e-7 / 7.0, 3.0e5 / 11.0, 0.1];
        let model = model.core().unwrap();
        write(&model, &path).unwrap();
        assert_eq!(read(&path).unwrap(), model);
    }

    #[test]
    fn what_is_no_model_is_refused_with_its_place() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("model.toml");
        let limits = "lower_limit = 0.0\nupper_limit = 1.5\n";
        let zeros = "{ position = 0.0, change = 0.0, input = 0.0, constant = 0.0 }";
        let cell = format!("[[cells]]\nregion = {zeros}\ngrowth = {zeros}\n");
        let sound = format!("period = 0.01\n{limits}{cell}");
        let cases = [
            (format!("period = 0.01\n{limits}cells = []\n"), "cells"),
            (format!("period = 0.0\n{limits}{cell}"), "period"),
            (format!("period = 0.01\n{cell}"), "lower_limit"),
            (sound.replace("1.5", "-1.5"), "lower_limit"),
            (sound.replace("change = 0.0", "change = nan"), "region"),
            (sound.replace("input", "volts"), "volts"),
            (sound.replace("= 0.01", "= \"x\""), ":1:"),
            (sound.replace("[[cells]]", "[[cells"), ":4:"),
            (cell.repeat(11) + "x", ":34:"),
            (format!("period = 0.01\n{limits}{}", cell.repeat(11)), "11"),
        ];
        for (text, expected) in cases {
            std::fs::write(&path, &text).unwrap();
            let error = read(&path).unwrap_err().to_string();
            assert!(
                error.contains("model.toml") && error.contains(expected),
                "{error}"
            );
        }
        std::fs::write(&path, sound).unwrap();
        assert!(read(&path).is_ok());
        assert!(read(&directory.path().join("none.toml")).is_err());
    }
}
