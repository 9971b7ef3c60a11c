//! A time that two columns hold: whole seconds, and what is beyond them, as ROS and `struct timeval` have it.

use super::raw::{Column, Raw};

/// What the columns of whole seconds and of the rest are called at their ends, and how many of the rest are a second.
const PAIRS: [(&str, &str, f64); 6] = [
    ("secs", "nsecs", 1e9),
    ("sec", "nsec", 1e9),
    ("sec", "nanosec", 1e9),
    ("seconds", "nanoseconds", 1e9),
    ("sec", "usec", 1e6),
    ("seconds", "microseconds", 1e6),
];

/// Puts such a time together in the column of its seconds. What was done, to be said behind the layout; nothing where there is no
/// such pair.
pub(super) fn join_seconds(raw: &mut Raw) -> String {
    let names: Vec<String> = raw.names.iter().map(|name| name.to_lowercase()).collect();
    let mut said = String::new();
    for seconds in 0..names.len() {
        let rest_of = |(whole, rest, parts): &(&str, &str, f64)| {
            let stem = names[seconds].strip_suffix(whole)?;
            let is_word = stem.is_empty() || stem.ends_with(|c: char| !c.is_alphanumeric());
            let rest = names
                .iter()
                .position(|name| *name == format!("{stem}{rest}"));
            Some((rest.filter(|_| is_word)?, *parts))
        };
        let Some((rest, parts)) = PAIRS.iter().find_map(rest_of) else {
            continue;
        };
        let values = |column: usize| raw.columns[column].values.iter().copied();
        let is_part = |value: f64| value.is_nan() || (0.0..parts).contains(&value);
        if values(seconds).len() != values(rest).len() || !values(rest).all(is_part) {
            continue;
        }
        let whole = values(seconds).zip(values(rest));
        let whole = whole
            .map(|(seconds, rest)| seconds + rest / parts)
            .collect();
        let bad = raw.columns[seconds].bad.take();
        let bad = bad.or_else(|| raw.columns[rest].bad.clone());
        raw.columns[seconds] = Column {
            bad,
            ..Column::of(whole)
        };
        raw.units[seconds] = Some("s".to_owned());
        said += &format!(
            ", {} with what {} has of its seconds",
            raw.name(seconds),
            raw.name(rest)
        );
    }
    said
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_and_their_parts_are_one_time() {
        for names in [
            ["header.stamp.secs", "header.stamp.nsecs"],
            ["sec", "nanosec"],
            ["tv_sec", "tv_nsec"],
        ] {
            let mut raw = Raw::named(names);
            raw.columns[0] = Column::of(vec![1_790_000_000.0, 1_790_000_001.0]);
            raw.columns[1] = Column::of(vec![750_000_000.0, 250_000.0]);
            let said = join_seconds(&mut raw);
            assert!(said.contains(names[1]), "{said}");
            let time = &raw.columns[0].values;
            // A quarter of a microsecond is what `f64` holds of such a time.
            assert!((time[1] - time[0] - 0.25025).abs() < 5e-7, "{time:?}");
        }
        // What is no part of a second, or of another time, stays.
        for (names, rest) in [
            (["sec", "nsec"], 2e9),
            (["a.sec", "b.nsec"], 1.0),
            (["parsec", "parnsec"], 1.0),
        ] {
            let mut raw = Raw::named(names);
            raw.columns[0] = Column::of(vec![1.0, 2.0]);
            raw.columns[1] = Column::of(vec![rest, rest]);
            assert_eq!(join_seconds(&mut raw), "");
            assert_eq!(raw.columns[0].values, [1.0, 2.0]);
        }
    }
}
