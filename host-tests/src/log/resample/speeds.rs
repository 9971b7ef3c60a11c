//! How fast rows at uneven times move, and whether the motion or the clock was uneven.

use super::BEYOND;

/// Speeds in rows at uneven times. They are taken over a period at least: between rows that all but repeat a stamp, a
/// count of the sensor would be any speed.
pub(super) struct Speeds<'a> {
    pub time: &'a [f64],
    pub position: &'a [f64],
    pub period: f64,
}

impl Speeds<'_> {
    fn between(&self, a: usize, b: usize) -> Option<f64> {
        let elapsed = self.time[b] - self.time[a];
        let enough = elapsed > (1.0 - BEYOND) * self.period;
        enough.then(|| (self.position[b] - self.position[a]) / elapsed)
    }

    /// The last row that is so many periods before this one, or the first one.
    fn before(&self, row: usize, periods: f64) -> usize {
        let until = self.time[row] - periods * (1.0 - BEYOND) * self.period;
        let rows = self.time.partition_point(|t| *t <= until);
        rows.saturating_sub(1)
    }

    /// The first row that is so many periods after this one, or the last one.
    fn after(&self, row: usize, periods: f64) -> usize {
        let from = self.time[row] + periods * (1.0 - BEYOND) * self.period;
        let row = self.time.partition_point(|t| *t < from);
        row.min(self.time.len() - 1)
    }

    /// In the middle of the rows around this one.
    pub fn around(&self, row: usize) -> Option<f64> {
        self.between(self.before(row, 0.5), self.after(row, 0.5))
    }

    /// How fast the speed changes from before this row to behind the next one.
    pub fn curvature(&self, row: usize) -> Option<f64> {
        let (first, last) = (self.before(row, 1.0), self.after(row + 1, 1.0));
        let change = self.between(row + 1, last)? - self.between(first, row)?;
        let middles =
            [[first, row], [row + 1, last]].map(|[a, b]| 0.5 * (self.time[a] + self.time[b]));
        Some(change / (middles[1] - middles[0]))
    }
}

/// Which share of the uneven steps is the clock's, 0 to 1, where the machine was looked at evenly and the stamps were
/// taken unevenly; the rest is true. Between neighbours at distances h before and g behind, a row that moves by v is
/// v (h − g)/2 away from their middle if its stamp is true, and in the middle if only the clock was uneven.
pub(super) fn share_of_clock(time: &[f64], position: &[f64], period: f64) -> f64 {
    let (mut product, mut square) = (0.0, 0.0);
    let is_step = |step: f64| (0.5..1.5).contains(&(step / period));
    for row in 1..time.len() - 1 {
        let (before, behind) = (time[row] - time[row - 1], time[row + 1] - time[row]);
        // Nobody doubts a gap.
        if is_step(before) && is_step(behind) {
            let speed = (position[row + 1] - position[row - 1]) / (before + behind);
            let if_true = 0.5 * speed * (before - behind);
            let off_middle = position[row] - 0.5 * (position[row - 1] + position[row + 1]);
            product += off_middle * if_true;
            square += if_true * if_true;
        }
    }
    if square > 0.0 {
        (1.0 - product / square).clamp(0.0, 1.0)
    } else {
        0.0
    }
}
