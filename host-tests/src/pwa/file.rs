//! A model as a text file, TOML.

use std::path::Path;

use model_core::plant::piecewise_affine::{Parameters, PiecewiseAffine};
use serde::{Deserialize, Serialize};

use super::reading::Reading;
use crate::error::{InputError, read_text};
use crate::failure::Failure;

/// What the file holds.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    reading: Reading,
    model: Parameters,
}

/// Writes a model.
///
/// # Errors
/// What the file system reports.
pub fn save(path: &Path, reading: Reading, model: &PiecewiseAffine) -> Result<(), Failure> {
    let file = File {
        reading,
        model: model.parameters().clone(),
    };
    let text = toml::to_string(&file).map_err(|error| Failure::other(error.to_string()))?;
    std::fs::write(path, text).map_err(|error| Failure::system(path.display(), &error))
}

/// Reads a model.
///
/// # Errors
/// A file that is not such a model, with the line where that is known.
pub fn load(path: &Path) -> Result<(Reading, PiecewiseAffine), InputError> {
    let text = read_text(path, "a piecewise affine model (TOML)")?;
    let file: File = toml::from_str(&text).map_err(|error| {
        let line = error
            .span()
            .map(|span| 1 + text[..span.start].matches('\n').count());
        InputError::new(path, line, error.message().to_owned())
    })?;
    let model = PiecewiseAffine::build(file.model)
        .map_err(|error| InputError::new(path, None, error.to_string()))?;
    Ok((file.reading, model))
}
