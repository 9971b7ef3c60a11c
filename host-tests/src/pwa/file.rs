//! A model as a text file, TOML.

use std::path::Path;

use model_core::plant::piecewise_affine::{Parameters, PiecewiseAffine};
use serde::{Deserialize, Serialize};

use super::reading::Reading;
use crate::error::{InputError, line_of, read_text};
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
            .map(|span| line_of(text.as_bytes(), span.start));
        InputError::new(path, line, error.message())
    })?;
    let model = PiecewiseAffine::build(file.model)
        .map_err(|error| InputError::new(path, None, error.to_string()))?;
    Ok((file.reading, model))
}

#[cfg(test)]
mod tests {
    use model_core::plant::piecewise_affine::{Affine, Cell};

    use super::*;

    fn model() -> PiecewiseAffine {
        let moving = Cell {
            region: Affine {
                input: 1.0,
                constant: -0.1,
                ..Affine::default()
            },
            growth: Affine {
                position: -0.017_3,
                change: 0.71,
                input: 1.0 / 3.0,
                constant: 1e-9,
            },
        };
        PiecewiseAffine::build(Parameters {
            period: 0.01,
            lower_limit: -0.3,
            upper_limit: 1.57,
            cells: [Cell::default(), moving].into_iter().collect(),
        })
        .unwrap()
    }

    #[test]
    fn a_file_gives_back_every_bit() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("model.toml");
        save(&path, Reading::Balance, &model()).unwrap();
        assert_eq!(load(&path).unwrap(), (Reading::Balance, model()));
    }

    #[test]
    fn a_file_that_is_no_model_is_refused_by_line_or_name() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("model.toml");
        save(&path, Reading::Balance, &model()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let cases = [
            (text.replace("balance", "gut feeling"), "unknown variant"),
            (text.replace("upper_limit", "upper"), "unknown field"),
            (text.replace("period = 0.01", "period = -0.01"), "period"),
            (text.replace("0.71", "nan"), "growth"),
        ];
        for (spoilt, expected) in cases {
            assert_ne!(spoilt, text);
            std::fs::write(&path, spoilt).unwrap();
            let error = load(&path).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
