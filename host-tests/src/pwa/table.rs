//! What came of each number of clusters, as text.

use std::fmt::Write;

use super::search::Identified;

impl Identified {
    /// A line for each number of clusters: rms of the free-run error on the held-out parts of the
    /// training data, times `factor` (57.3 for degrees). The chosen number is marked.
    pub fn table(&self, factor: f64) -> String {
        let mut text = String::from("clusters  series-parallel  parallel  borders moved\n");
        for candidate in &self.candidates {
            let moved = candidate
                .moved
                .map_or_else(|| "-".to_owned(), |moved| format!("{:.2}", factor * moved));
            let mark = if candidate.clusters == self.model.parameters().cells.len() {
                "  chosen"
            } else {
                ""
            };
            writeln!(
                text,
                "{:>8}  {:>15.2}  {:>8.2}  {moved:>13}{mark}",
                candidate.clusters,
                factor * candidate.series_parallel,
                factor * candidate.parallel,
            )
            .expect("a String takes any text");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use crate::pwa::model::tests::example;
    use crate::pwa::{Candidate, Identified, Reading};

    #[test]
    fn the_chosen_number_is_marked() {
        let candidate = |clusters, moved| Candidate {
            clusters,
            series_parallel: 0.5,
            parallel: 0.25,
            moved,
        };
        let identified = Identified {
            model: example().core().unwrap(),
            reading: Reading::default(),
            candidates: vec![candidate(2, None), candidate(3, Some(0.125))],
        };
        let table = identified.table(2.0);
        let lines: Vec<Vec<&str>> = table
            .lines()
            .map(|line| line.split_whitespace().collect())
            .collect();
        assert_eq!(lines[1], ["2", "1.00", "0.50", "-"]);
        assert_eq!(lines[2], ["3", "1.00", "0.50", "0.25", "chosen"]);
    }
}
