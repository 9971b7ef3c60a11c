//! What was learned over a variable where no effect of the catalogue explains what is left, or where the machine has another
//! law of one.

use serde::Serialize;

/// A torque or a friction level that was learned over a variable: linear between its points, constant beyond them.
#[derive(Debug, Clone, Serialize)]
pub struct LearnedLaw {
    /// `position`, `velocity`, `current`, `load` or `time`.
    pub over: String,
    /// `torque`, positive forwards, or `friction`, which opposes motion and holds at rest.
    pub acts_as: String,
    /// Values of the variable, SI: of a friction over velocity, current or load its magnitude, of a
    /// current the torque that it makes.
    pub at: Vec<f64>,
    /// Unit of `at`.
    pub at_unit: String,
    /// What acts there beyond the fitted machine.
    pub values: Vec<f64>,
    /// Unit of `values`.
    pub unit: String,
}

impl LearnedLaw {
    /// What its points are values of, in words.
    pub(super) fn laid_over(&self) -> &str {
        match self.over.as_str() {
            "current" => "motor torque",
            variable => variable,
        }
    }

    /// Its points between two ends of its variable, and what it is at these.
    pub(super) fn within(&self, (low, high): (f64, f64)) -> (Vec<f64>, Vec<f64>) {
        // A law that is the same either way is laid over the magnitude.
        let is_of_magnitude = low < 0.0 && self.at.first().is_some_and(|&first| first >= 0.0);
        let (low, high) = if is_of_magnitude {
            ((-high).max(0.0), high.max(-low))
        } else {
            (low, high)
        };
        let [low, high] = match (self.at.first(), self.at.last()) {
            (Some(&first), Some(&last)) => [low, high].map(|end| end.clamp(first, last)),
            _ => [low, high],
        };
        let inside = |at: f64| (low..=high).contains(&at);
        let points = || self.at.iter().copied().zip(self.values.iter().copied());
        let between = points().zip(points().skip(1)).flat_map(|((a, x), (b, y))| {
            let ends = [low, high]
                .into_iter()
                .filter(move |&end| a < end && end < b);
            ends.map(move |end| (end, x + (y - x) * (end - a) / (b - a)))
        });
        let mut all: Vec<(f64, f64)> = points()
            .filter(|point| inside(point.0))
            .chain(between)
            .collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all.into_iter().unzip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A law whose last point, 5 at 3, is beyond the data; straight lines between the points are by hand.
    #[test]
    fn a_law_is_cut_where_the_data_end() {
        let law = |at: [f64; 4]| LearnedLaw {
            over: "velocity".into(),
            acts_as: "friction".into(),
            at: at.into(),
            at_unit: "rad/s".into(),
            values: vec![-1.0, 0.0, 1.0, 5.0],
            unit: "N·m".into(),
        };
        let signed = law([0.0, 1.0, 2.0, 3.0].map(|at| at - 1.0));
        let both = |at: &[f64], values: &[f64]| (at.to_vec(), values.to_vec());
        assert_eq!(
            signed.within((-0.5, 1.25)),
            both(&[-0.5, 0.0, 1.0, 1.25], &[-0.5, 0.0, 1.0, 2.0])
        );
        // What is laid over the magnitude has the data of either sign.
        let even = law([0.0, 1.0, 2.0, 3.0]);
        assert_eq!(
            even.within((-2.25, 1.5)),
            both(&[0.0, 1.0, 2.0, 2.25], &[-1.0, 0.0, 1.0, 2.0])
        );
        assert_eq!(even.within((-2.0, -1.0)), both(&[1.0, 2.0], &[0.0, 1.0]));
        // Beyond its points it is as at the last one.
        assert_eq!(even.within((2.0, 9.0)), both(&[2.0, 3.0], &[1.0, 5.0]));
        assert_eq!(even.within((5.0, 9.0)), both(&[3.0], &[5.0]));
    }
}
