//! Tables 1 and 2 of the paper, ours beside them.

use super::stand::Logs;
use crate::free_run::Errors;
use crate::reproduce::Entry;

/// Errors of the paper's models: Table 1.
const PAPER: [(Column, Errors, Errors); 2] = [
    (Column::Physical, degrees(0.05, 4.21), degrees(0.06, 4.93)),
    (
        Column::PiecewiseAffine,
        degrees(0.04, 3.83),
        degrees(0.06, 3.92),
    ),
];

/// Errors of the paper's implementations on validation data: Table 2.
const PAPER_IMPLEMENTATIONS: [(Implementation, Errors); 3] = [
    (Implementation::Continuous, degrees(0.06, 4.93)),
    (Implementation::Discrete, degrees(0.07, 5.09)),
    (Implementation::RealTime, degrees(0.12, 12.08)),
];

/// What the paper asks of every model: the largest error, degrees.
pub const LIMIT: f64 = 5.0;

const fn degrees(nrmse: f64, max_abs: f64) -> Errors {
    Errors { nrmse, max_abs }
}

/// A model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Column {
    /// The physical one by the paper's procedure: four lines, then b₀.
    Physical,
    /// The same, all numbers fitted together to both logs.
    Fitted,
    /// The same with what the gap loop found, refitted.
    Extended,
    /// The piecewise affine one.
    PiecewiseAffine,
}

impl Column {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Physical => "physical model",
            Self::Fitted => "physical model, fitted",
            Self::Extended => "physical model with what the gap loop found",
            Self::PiecewiseAffine => "PWA model",
        }
    }

    /// Over a column of a table.
    pub fn head(self) -> &'static str {
        match self {
            Self::Physical => "physical",
            Self::Fitted => "physical, fitted",
            Self::Extended => "physical, gap closed",
            Self::PiecewiseAffine => "PWA",
        }
    }

    /// Its errors in the paper, on identification and on validation data.
    pub fn paper(self) -> Option<(Errors, Errors)> {
        let found = PAPER.iter().find(|(column, ..)| *column == self);
        found.map(|&(_, identification, validation)| (identification, validation))
    }
}

/// How a model is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Implementation {
    /// Integrated in double precision, 2 µs.
    Continuous,
    /// The core's step on this host.
    Discrete,
    /// The core's step in the interrupt of the emulated chip.
    RealTime,
}

impl Implementation {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Continuous => "time-continuous",
            Self::Discrete => "time-discrete",
            Self::RealTime => "real-time",
        }
    }

    /// Its errors in the paper.
    pub fn paper(self) -> Option<Errors> {
        let found = PAPER_IMPLEMENTATIONS
            .iter()
            .find(|(which, _)| *which == self);
        found.map(|&(_, errors)| errors)
    }
}

/// A model on the logs of steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Judged {
    /// Which.
    pub column: Column,
    /// Its free run on the identification log, rad.
    pub fast: Vec<f64>,
    /// Its free run on the validation log, rad.
    pub validate: Vec<f64>,
    /// Errors of the first, degrees.
    pub identification: Errors,
    /// Errors of the second, degrees.
    pub validation: Errors,
}

impl Judged {
    /// From the free runs.
    pub fn new(column: Column, fast: Vec<f64>, validate: Vec<f64>, logs: &Logs) -> Self {
        Self {
            column,
            identification: super::degrees(&fast, &logs.fast),
            validation: super::degrees(&validate, &logs.validate),
            fast,
            validate,
        }
    }
}

/// An implementation of a model on the validation log.
#[derive(Debug, Clone, PartialEq)]
pub struct Implemented {
    /// Of which model.
    pub column: Column,
    /// How.
    pub implementation: Implementation,
    /// Its free run, rad.
    pub positions: Vec<f64>,
    /// Its errors, degrees.
    pub errors: Errors,
}

/// Table 1 as entries.
pub fn table_1(models: &[Judged]) -> Vec<Entry> {
    let mut entries = Vec::new();
    for model in models {
        let paper = model.column.paper();
        let kinds = [
            ("identification", model.identification, paper.map(|p| p.0)),
            ("validation", model.validation, paper.map(|p| p.1)),
        ];
        for (kind, ours, paper) in kinds {
            entries.extend(pair(
                &format!("{}, {kind}", model.column.name()),
                ours,
                paper,
            ));
        }
    }
    entries
}

/// Table 2 as entries.
pub fn table_2(implemented: &[Implemented]) -> Vec<Entry> {
    let entries = implemented.iter().flat_map(|it| {
        let what = format!("{}, {}", it.column.name(), it.implementation.name());
        let paper = (it.column == Column::Physical).then(|| it.implementation.paper());
        pair(&what, it.errors, paper.flatten())
    });
    entries.collect()
}

/// Both errors of something.
fn pair(what: &str, ours: Errors, paper: Option<Errors>) -> [Entry; 2] {
    let entry = |name: &str, unit: &str, pick: fn(&Errors) -> f64| Entry {
        what: format!("{what}, {name}"),
        paper: paper.as_ref().map(pick),
        ours: pick(&ours),
        truth: None,
        unit: unit.to_owned(),
    };
    [
        entry("NRMSE", "", |errors| errors.nrmse),
        entry("largest error", "°", |errors| errors.max_abs),
    ]
}

/// Table 1 as cells: a row of heads, then a row an error.
pub fn cells_1(models: &[Judged]) -> Vec<Vec<String>> {
    type Side = fn(&Judged) -> (Errors, Option<Errors>);
    let sides: [(&str, Side); 2] = [
        ("identification", |model| {
            (model.identification, model.column.paper().map(|p| p.0))
        }),
        ("validation", |model| {
            (model.validation, model.column.paper().map(|p| p.1))
        }),
    ];
    let mut rows = vec![row(
        "",
        models.iter().map(|model| model.column.head().to_owned()),
    )];
    for (name, side) in sides {
        for (error, pick) in ERRORS {
            let cells = models.iter().map(|model| {
                let (ours, paper) = side(model);
                beside(&ours, paper.as_ref(), pick)
            });
            rows.push(row(&format!("{name} {error}"), cells));
        }
    }
    rows
}

/// Table 2 as cells.
pub fn cells_2(implemented: &[Implemented]) -> Vec<Vec<String>> {
    let heads = implemented
        .iter()
        .map(|it| format!("{}, {}", it.column.head(), it.implementation.name()));
    let mut rows = vec![row("", heads)];
    for (error, pick) in ERRORS {
        let cells = implemented.iter().map(|it| {
            let paper = (it.column == Column::Physical).then(|| it.implementation.paper());
            beside(&it.errors, paper.flatten().as_ref(), pick)
        });
        rows.push(row(&format!("validation {error}"), cells));
    }
    rows
}

/// The validation errors of one model on all stands, in the order of their size: NRMSE and largest.
fn sorted(repeated: &[Vec<Judged>], model: usize) -> [Vec<f64>; 2] {
    let picks: [fn(&Errors) -> f64; 2] = [|errors| errors.nrmse, |errors| errors.max_abs];
    picks.map(|pick| {
        let mut values: Vec<f64> = repeated
            .iter()
            .map(|stand| pick(&stand[model].validation))
            .collect();
        values.sort_by(f64::total_cmp);
        values
    })
}

/// The errors on several stands as entries: median and worst.
pub fn table_repeated(repeated: &[Vec<Judged>]) -> Vec<Entry> {
    let Some(first) = repeated.first() else {
        return Vec::new();
    };
    let mut entries = Vec::new();
    for (number, model) in first.iter().enumerate() {
        let [nrmse, largest] = sorted(repeated, number);
        let paper = model.column.paper().map(|paper| paper.1);
        for (name, place) in [("median", nrmse.len() / 2), ("worst", nrmse.len() - 1)] {
            let ours = Errors {
                nrmse: nrmse[place],
                max_abs: largest[place],
            };
            let what = format!(
                "{}, validation, {name} of {} stands",
                model.column.name(),
                nrmse.len()
            );
            entries.extend(pair(&what, ours, paper));
        }
    }
    entries
}

/// The errors on several stands as cells: median and worst of both, and on how many the largest is
/// within [`LIMIT`].
pub fn cells_repeated(repeated: &[Vec<Judged>]) -> Vec<Vec<String>> {
    let Some(first) = repeated.first() else {
        return Vec::new();
    };
    let mut rows = vec![row(
        "",
        first.iter().map(|model| model.column.head().to_owned()),
    )];
    let all: Vec<[Vec<f64>; 2]> = (0..first.len())
        .map(|model| sorted(repeated, model))
        .collect();
    rows.push(row(
        "NRMSE",
        all.iter().map(|[nrmse, _]| {
            format!(
                "{:.3}, {:.3}",
                nrmse[nrmse.len() / 2],
                nrmse[nrmse.len() - 1]
            )
        }),
    ));
    rows.push(row(
        "‖e‖∞",
        all.iter().map(|[_, largest]| {
            let worst = largest[largest.len() - 1];
            format!("{:.2}°, {worst:.2}°", largest[largest.len() / 2])
        }),
    ));
    rows.push(row(
        "within",
        all.iter().map(|[_, largest]| {
            let within = largest.iter().filter(|error| **error <= LIMIT).count();
            format!("{within} of {}", largest.len())
        }),
    ));
    rows
}

/// Cells for a terminal, a column an entry and a line a row of them: many columns become lines.
pub fn render(cells: &[Vec<String>]) -> String {
    let columns = cells.first().map_or(0, Vec::len);
    let width = |row: usize| {
        let lengths = (0..columns).map(|column| cells[row][column].chars().count());
        lengths.max().unwrap_or(0) + 3
    };
    let widths: Vec<usize> = (0..cells.len()).map(width).collect();
    let mut text = String::new();
    for column in 0..columns {
        let line = cells.iter().zip(&widths).enumerate();
        let line: String = line
            .map(|(row, (cells, width))| {
                let (cell, width) = (&cells[column], *width);
                if row == 0 {
                    format!("{cell:<width$}")
                } else {
                    format!("{cell:>width$}")
                }
            })
            .collect();
        text += line.trim_end();
        text.push('\n');
    }
    text
}

/// An error as a table shows it.
pub type Shown = fn(&Errors) -> String;

/// The two errors and how they are shown.
const ERRORS: [(&str, Shown); 2] = [("NRMSE", nrmse), ("‖e‖∞", largest)];

/// Ours, and the paper's in brackets.
pub fn beside(ours: &Errors, paper: Option<&Errors>, pick: Shown) -> String {
    match paper {
        Some(paper) => format!("{} ({})", pick(ours), pick(paper)),
        None => pick(ours),
    }
}

/// An NRMSE as a table shows it.
pub fn nrmse(errors: &Errors) -> String {
    format!("{:.3}", errors.nrmse)
}

/// A largest error as a table shows it.
pub fn largest(errors: &Errors) -> String {
    format!("{:.2}°", errors.max_abs)
}

fn row(name: &str, cells: impl Iterator<Item = String>) -> Vec<String> {
    std::iter::once(name.to_owned()).chain(cells).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_numbers_stand_beside_ours() {
        let ours = Errors {
            nrmse: 0.0123,
            max_abs: 1.5,
        };
        let models = [Judged {
            column: Column::PiecewiseAffine,
            fast: Vec::new(),
            validate: Vec::new(),
            identification: ours,
            validation: ours,
        }];
        let table = render(&cells_1(&models));
        assert!(
            table.contains("0.012 (0.060)") && table.contains("1.50° (3.83°)"),
            "{table}"
        );
        let entries = table_1(&models);
        assert_eq!(entries.len(), 4);
        assert_eq!(entries[3].what, "PWA model, validation, largest error");
        assert_eq!((entries[3].paper, entries[3].ours), (Some(3.92), 1.5));
        let real_time = |column| Implemented {
            column,
            implementation: Implementation::RealTime,
            positions: Vec::new(),
            errors: ours,
        };
        let implemented = [Column::Physical, Column::Extended].map(real_time);
        let entries = table_2(&implemented);
        assert_eq!((entries[1].paper, entries[3].paper), (Some(12.08), None));
        assert!(render(&cells_2(&implemented)).contains("1.50° (12.08°)"));
    }
}
