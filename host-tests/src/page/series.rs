//! What is computed from the evidence before it is drawn: thinning, bins, autocorrelation.
//!
//! Points are `(x, y)` in SI units. Points that are not finite are left out, so that a replay that
//! diverged does not take the picture with it.

/// A point of a picture.
pub(crate) type Point = (f64, f64);

/// The points of two series of samples.
pub(crate) fn points(x: &[f32], y: &[f32]) -> Vec<Point> {
    x.iter()
        .zip(y)
        .map(|(&x, &y)| (f64::from(x), f64::from(y)))
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .collect()
}

/// `model − measured`, sample by sample.
pub(crate) fn difference(model: &[f32], measured: &[f32]) -> Vec<f32> {
    model.iter().zip(measured).map(|(m, y)| m - y).collect()
}

/// At most two points for each of `columns` equal stretches: the lowest and the highest, in order
/// of time. A spike of one sample survives.
pub(crate) fn envelope(points: &[Point], columns: usize) -> Vec<Point> {
    if points.len() <= 2 * columns {
        return points.to_vec();
    }
    let mut kept = Vec::with_capacity(2 * columns);
    for column in 0..columns {
        let from = column * points.len() / columns;
        let to = (column + 1) * points.len() / columns;
        let (mut lowest, mut highest) = (from, from);
        for i in from..to {
            if points[i].1 < points[lowest].1 {
                lowest = i;
            }
            if points[i].1 > points[highest].1 {
                highest = i;
            }
        }
        kept.push(points[lowest.min(highest)]);
        if lowest != highest {
            kept.push(points[lowest.max(highest)]);
        }
    }
    kept
}

/// At most `limit` points of a cloud: one for each occupied cell of a grid, made coarser until
/// they are few enough. Outliers have a cell to themselves and stay.
pub(crate) fn thin(points: &[Point], limit: usize) -> Vec<Point> {
    let (x, y) = (
        extent(points.iter().map(|p| p.0)),
        extent(points.iter().map(|p| p.1)),
    );
    let (Some(x), Some(y)) = (x, y) else {
        return Vec::new();
    };
    let cell = |value: f64, (low, high): (f64, f64), cells: f64| {
        if high > low {
            ((value - low) / (high - low) * cells) as u32
        } else {
            0
        }
    };
    let mut cells = 400.0;
    loop {
        let mut taken = std::collections::HashSet::new();
        let kept: Vec<Point> = points
            .iter()
            .copied()
            .filter(|p| taken.insert((cell(p.0, x, cells), cell(p.1, y, cells / 2.0))))
            .collect();
        if kept.len() <= limit || cells < 2.0 {
            return kept;
        }
        cells *= 0.8;
    }
}

/// Mean of y in `bins` equal stretches of x. A stretch with fewer than `least` points is left out.
pub(crate) fn binned_mean(points: &[Point], bins: usize, least: usize) -> Vec<Point> {
    let Some((low, high)) = extent(points.iter().map(|p| p.0)).filter(|(low, high)| high > low)
    else {
        return Vec::new();
    };
    let width = (high - low) / bins as f64;
    let mut sums = vec![(0.0, 0usize); bins];
    for (x, y) in points {
        let bin = (((x - low) / width) as usize).min(bins - 1);
        sums[bin].0 += y;
        sums[bin].1 += 1;
    }
    sums.iter()
        .enumerate()
        .filter(|(_, (_, count))| *count >= least.max(1))
        .map(|(bin, (sum, count))| (low + (bin as f64 + 0.5) * width, sum / *count as f64))
        .collect()
}

/// Autocorrelation at lags `1..=lags` by direct summation: r(k) = Σ eₜ eₜ₊ₖ / Σ eₜ² with the mean
/// taken off e (the biased estimate, never above 1). Empty for a constant series.
pub(crate) fn autocorrelation(series: &[f64], lags: usize) -> Vec<f64> {
    let mean = mean(series);
    let e: Vec<f64> = series.iter().map(|value| value - mean).collect();
    let energy: f64 = e.iter().map(|e| e * e).sum();
    if energy.is_nan() || energy <= f64::EPSILON * mean * mean * series.len() as f64 {
        return Vec::new();
    }
    (1..=lags.min(e.len().saturating_sub(1)))
        .map(|lag| e.iter().zip(&e[lag..]).map(|(a, b)| a * b).sum::<f64>() / energy)
        .collect()
}

/// Share of the values in each of `bins` equal stretches of `range`; a value beyond an end counts
/// in the bin there.
pub(crate) fn histogram(values: &[f64], (low, high): (f64, f64), bins: usize) -> Vec<f64> {
    let mut shares = vec![0.0; bins];
    for value in values {
        let bin = ((value - low) / (high - low) * bins as f64).max(0.0) as usize;
        shares[bin.min(bins - 1)] += 1.0 / values.len() as f64;
    }
    shares
}

/// Smallest and largest finite value.
pub(crate) fn extent(values: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    values
        .into_iter()
        .filter(|value| value.is_finite())
        .fold(None, |range, value| match range {
            None => Some((value, value)),
            Some((low, high)) => Some((value.min(low), value.max(high))),
        })
}

/// The stretch that holds the middle `share` of the values.
pub(crate) fn bulk(values: &[f64], share: f64) -> Option<(f64, f64)> {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    let cut = ((1.0 - share) / 2.0 * last as f64).round() as usize;
    Some((sorted[cut], sorted[last - cut]))
}

/// Where a stretch of `length` samples has the largest sum of squares.
pub(crate) fn worst_stretch(error: &[f32], length: usize) -> usize {
    let square = |e: &f32| {
        if e.is_finite() {
            f64::from(*e).powi(2)
        } else {
            0.0
        }
    };
    let length = length.min(error.len());
    let mut sum: f64 = error[..length].iter().map(square).sum();
    let (mut worst, mut largest) = (0, sum);
    for end in length..error.len() {
        sum += square(&error[end]) - square(&error[end - length]);
        if sum > largest {
            (worst, largest) = (end + 1 - length, sum);
        }
    }
    worst
}

/// Arithmetic mean; 0 of nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    values.iter().sum::<f64>() / values.len() as f64
}

/// Root mean square; 0 of nothing. What diverged stays visible: one infinite value makes it so.
pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0usize), |(sum, count), v| (sum + v * v, count + 1));
    if count == 0 {
        0.0
    } else {
        (sum / count as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_envelope_keeps_a_spike_of_one_sample() {
        let mut points: Vec<Point> = (0..10_000).map(|i| (i as f64, (i % 7) as f64)).collect();
        points[4321].1 = -50.0;
        points[8765].1 = 80.0;
        let kept = envelope(&points, 100);
        assert!(kept.len() <= 200);
        assert!(kept.contains(&(4321.0, -50.0)) && kept.contains(&(8765.0, 80.0)));
        assert!(kept.windows(2).all(|pair| pair[0].0 < pair[1].0));
        assert_eq!(envelope(&points[..150], 100), points[..150]);
    }

    #[test]
    fn thinning_keeps_outliers_and_its_limit() {
        let mut points: Vec<Point> = (0..20_000)
            .map(|i| ((i as f64 * 0.618).fract(), (i as f64 * 0.414).fract()))
            .collect();
        points.push((0.5, 9.0));
        let kept = thin(&points, 500);
        assert!(kept.len() <= 500 && kept.len() > 100, "{}", kept.len());
        assert!(kept.contains(&(0.5, 9.0)));
        assert_eq!(thin(&[(1.0, 1.0); 3], 10), [(1.0, 1.0)]);
        assert!(thin(&[], 10).is_empty());
    }

    #[test]
    fn the_binned_mean_of_a_line_lies_on_it() {
        let points: Vec<Point> = (0..=1000)
            .map(|i| (f64::from(i), 3.0 * f64::from(i)))
            .collect();
        let means = binned_mean(&points, 10, 5);
        assert_eq!(means.len(), 10);
        // A bin holds whole samples, so its mean may be off by half a sample.
        assert!(means.iter().all(|(x, y)| (y - 3.0 * x).abs() <= 1.5));
        assert!(binned_mean(&points, 10, 200).is_empty());
        assert!(binned_mean(&[(1.0, 2.0), (1.0, 3.0)], 10, 1).is_empty());
    }

    #[test]
    fn the_autocorrelation_of_a_sine_is_a_cosine() {
        let period = 40.0;
        let sine: Vec<f64> = (0..4000)
            .map(|i| 5.0 + (std::f64::consts::TAU * f64::from(i) / period).sin())
            .collect();
        let r = autocorrelation(&sine, 60);
        assert_eq!(r.len(), 60);
        assert!((r[39] - 0.99).abs() < 1e-3, "{}", r[39]);
        assert!((r[19] + 0.995).abs() < 1e-3, "{}", r[19]);
        // The lagged sum ends early: off by at most half the lag over half the samples.
        assert!(r[9].abs() < 10.0 / 4000.0, "{}", r[9]);
        assert!(autocorrelation(&[0.1; 50], 10).is_empty());
        assert_eq!(autocorrelation(&[1.0, -1.0], 10), [-0.5]);
        assert!(autocorrelation(&[], 10).is_empty());
    }

    #[test]
    fn a_histogram_sums_to_one_and_collects_what_lies_outside() {
        let shares = histogram(&[-9.0, 0.1, 0.6, 0.7, 9.0], (0.0, 1.0), 2);
        assert!((shares[0] - 0.4).abs() < 1e-12 && (shares[1] - 0.6).abs() < 1e-12);
    }

    #[test]
    fn ranges_ignore_what_is_not_finite() {
        assert_eq!(
            extent([f64::NAN, 2.0, -1.0, f64::INFINITY]),
            Some((-1.0, 2.0))
        );
        assert_eq!(extent([f64::NAN]), None);
        let values: Vec<f64> = (0..=1000).map(f64::from).collect();
        assert_eq!(bulk(&values, 0.99), Some((5.0, 995.0)));
        assert_eq!(bulk(&[], 0.99), None);
        assert_eq!(points(&[0.0, 1.0, 2.0], &[1.0, f32::NAN]), [(0.0, 1.0)]);
    }

    #[test]
    fn the_worst_stretch_holds_the_largest_error() {
        let mut error = vec![0.1_f32; 1000];
        error[700..720].fill(2.0);
        assert_eq!(worst_stretch(&error, 20), 700);
        assert_eq!(worst_stretch(&error, 5000), 0);
        assert_eq!(worst_stretch(&[], 20), 0);
    }

    #[test]
    fn root_mean_square() {
        assert_eq!(rms([3.0, -3.0]), 3.0);
        assert_eq!(rms([3.0, f64::INFINITY]), f64::INFINITY);
        assert_eq!(rms([]), 0.0);
    }
}
