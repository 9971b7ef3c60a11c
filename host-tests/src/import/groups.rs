//! Columns of several groups of rows, each with a time of its own, as channels of a data logger that are sampled at
//! different rates or topics of a robot: all are brought to the times of one group.

use super::guess::end_of_path;
use super::raw::{Column, Raw};
use super::recipe::Recipe;
use crate::log::{COLUMNS, Course, TIME, counted, quoted};

/// A column read at its own times, in their order.
pub(super) struct Read {
    samples: Vec<(f64, f64)>,
    /// The mean step.
    step: f64,
}

impl Read {
    /// `None` without two rows that have a time.
    pub(super) fn of(time: &[f64], values: &[f64]) -> Option<Self> {
        let pairs = time.iter().copied().zip(values.iter().copied());
        let mut samples: Vec<(f64, f64)> = pairs.filter(|(time, _)| !time.is_nan()).collect();
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let step = (samples.last()?.0 - samples.first()?.0) / (samples.len() - 1) as f64;
        (step > 0.0).then_some(Self { samples, step })
    }

    /// The first of its times.
    pub(super) fn first(&self) -> f64 {
        self.samples[0].0
    }

    /// The last of its times.
    pub(super) fn last(&self) -> f64 {
        self.samples[self.samples.len() - 1].0
    }

    /// The value at a time: of what holds the last one, else on the line to the next one. Up to a step before the first
    /// row and behind the last one what stands there; farther off there is none.
    pub(super) fn at(&self, time: f64, course: Course) -> f64 {
        let after = self.samples.partition_point(|(own, _)| *own <= time);
        let before = after.checked_sub(1).map(|place| self.samples[place]);
        match (before, self.samples.get(after).copied()) {
            (Some((_, held)), Some(_)) if course != Course::Seen => held,
            (Some((begin, from)), Some((end, to))) => {
                from + (to - from) * (time - begin) / (end - begin)
            }
            (Some((own, value)), None) | (None, Some((own, value)))
                if (time - own).abs() <= self.step =>
            {
                value
            }
            _ => f64::NAN,
        }
    }
}

/// Brings every column that a recipe asks for to the times of the group that `--time` is of, by the column of its own group that
/// is called the same. What was done, a sentence each.
///
/// # Errors
/// A source that cannot be read; a group without such a time, or with one in another unit.
pub(super) fn bring_together(raw: &mut Raw, recipe: &Recipe) -> Result<Vec<String>, String> {
    let mut said = Vec::new();
    let sources = recipe.each(raw)?;
    let Some((_, time)) = sources.iter().find(|(index, _)| *index == TIME) else {
        return Ok(said);
    };
    let main = time.column;
    for (index, source) in &sources {
        for column in source.columns() {
            let Some(&group) = raw.groups.get(column) else {
                continue;
            };
            if group == raw.groups[main] {
                continue;
            }
            let own = time_of(raw, group, main)?;
            let is_direction = column != source.column;
            let course = if is_direction {
                Course::Held
            } else {
                COLUMNS[*index].1
            };
            let values = |column: usize| &raw.columns[column].values;
            let read = Read::of(values(own), values(column)).ok_or_else(|| {
                format!(
                    "{} does not rise: its rows are at no times",
                    quoted(&raw.name(own))
                )
            })?;
            let times = values(main);
            said.push(format!(
                "{} has its own times in {}: its {} were {} at the {} of {}.",
                raw.name(column),
                raw.name(own),
                counted(read.samples.len(), "row"),
                if course == Course::Seen {
                    "interpolated"
                } else {
                    "held"
                },
                counted(times.len(), "time"),
                raw.name(main),
            ));
            let brought = times.iter().map(|&time| read.at(time, course)).collect();
            raw.columns[column] = Column::of(brought);
            raw.groups[column] = raw.groups[main];
        }
    }
    Ok(said)
}

/// The time of a group: what is called there as `main` is in its own.
fn time_of(raw: &Raw, group: usize, main: usize) -> Result<usize, String> {
    let last = |column: usize| end_of_path(&raw.names[column]);
    let mut columns = 0..raw.names.len();
    let is_it = |column: &usize| raw.groups[*column] == group && last(*column) == last(main);
    let refuse = |why: String| {
        let name = quoted(&raw.name(main));
        Err(format!(
            "{name} is of one of several groups of rows, and another one {why}"
        ))
    };
    match columns.find(is_it) {
        None => refuse(format!("that is asked for has no `{}`", last(main))),
        Some(own) if raw.units[own] != raw.units[main] => {
            refuse(format!("has its `{}` in another unit", last(main)))
        }
        Some(own) => Ok(own),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A slow current beside a fast position, of which the current's group begins later and ends before.
    #[test]
    fn a_group_is_brought_to_the_times_of_another() {
        let mut raw = Raw::named(["time", "enc", "time.2", "i", "duty"]);
        raw.groups = vec![0, 0, 1, 1, 1];
        let of = |values: &[f64]| Column::of(values.to_vec());
        let fast: Vec<f64> = (0..10).map(f64::from).collect();
        raw.columns = vec![
            of(&fast),
            of(&fast),
            of(&[2.0, 4.0, 6.0]),
            of(&[20.0, 40.0, 80.0]),
            of(&[1.0, -1.0, 1.0]),
        ];
        let mut recipe = Recipe::default();
        for (index, name) in [(TIME, "time"), (1, "duty"), (2, "enc"), (4, "i")] {
            recipe.sources[index] = Some(name.to_owned());
        }
        let said = bring_together(&mut raw, &recipe).unwrap();
        assert_eq!(said.len(), 2, "{said:?}");
        let [current, duty] = [3, 4].map(|column| &raw.columns[column].values);
        assert!(current[9].is_nan() && duty[9].is_nan());
        let seen = [20.0, 20.0, 20.0, 30.0, 40.0, 60.0, 80.0, 80.0, 80.0];
        assert_eq!(current[..9], seen);
        let held = [1.0, 1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0, 1.0];
        assert_eq!(duty[..9], held);
        assert!(recipe.parsed(&raw).is_ok());
    }
}
