//! Least squares of a balance, with how sure each coefficient is.

use nalgebra::{DMatrix, DVector};

use super::balance::{Rows, Share};
use super::limits::{LEAST_ROWS, STANDARD_ERRORS};

/// Mean of the squares; 0 of nothing.
pub(super) fn mean_square(series: &[f64]) -> f64 {
    series.iter().map(|value| value * value).sum::<f64>() / series.len().max(1) as f64
}

/// Least squares. Each coefficient has with it the share of what the others leave that it explains (the
/// squared partial correlation), which is also how far the regression the other way round is from it. With them the share of
/// the sum's square that is left.
pub(super) fn regress(rows: &Rows) -> Option<(Vec<(Share, f64)>, f64)> {
    let (count, unknowns) = (rows.sum.len(), rows.columns.len());
    let level = mean_square(&rows.sum).sqrt();
    if count < LEAST_ROWS || level == 0.0 {
        return None;
    }
    let rms: Vec<f64> = rows
        .columns
        .iter()
        .map(|column| mean_square(column).sqrt())
        .collect();
    let scaled = DMatrix::from_fn(count, unknowns, |row, column| {
        if rms[column] > 0.0 {
            rows.columns[column][row] / rms[column]
        } else {
            0.0
        }
    });
    let sum = DVector::from_iterator(count, rows.sum.iter().map(|value| value / level));
    // A hair on the diagonal keeps columns that are one another's copies apart, each undetermined.
    let ridge = 1e-9 * count as f64;
    let normal = scaled.tr_mul(&scaled) + DMatrix::identity(unknowns, unknowns) * ridge;
    let inverse = normal.cholesky()?.inverse();
    let solution = &inverse * scaled.tr_mul(&sum);
    let left = &sum - &scaled * &solution;
    let energy = left.norm_squared();
    let lagged: f64 = left
        .as_slice()
        .windows(2)
        .map(|pair| pair[0] * pair[1])
        .sum();
    let correlation = (lagged / energy.max(f64::MIN_POSITIVE)).clamp(0.0, 0.999);
    let inflation = (1.0 + correlation) / (1.0 - correlation);
    let freedom = (count - unknowns) as f64;
    let variance = energy / freedom;
    let shares = (0..unknowns).map(|place| {
        let value = solution[place];
        let plain = variance * inverse[(place, place)];
        let ratio = value * value / plain.max(f64::MIN_POSITIVE);
        let clarity = ratio / (ratio + freedom);
        let error = STANDARD_ERRORS * (plain * inflation).sqrt();
        let other = value / clarity.max(1e-12);
        let scale = if rms[place] > 0.0 {
            level / rms[place]
        } else {
            0.0
        };
        let interval = (
            scale * (value.min(other) - error),
            scale * (value.max(other) + error),
        );
        let share = Share {
            follows: rows.follows[place],
            interval,
            rms: rms[place],
        };
        (share, clarity)
    });
    Some((shares.collect(), energy / count as f64))
}
