//! Mean, variance, root mean square and median of samples.

use super::sum::Sum;

/// Running mean and variance, one sample at a time.
///
/// Welford, *Note on a method for calculating corrected sums of squares and products*,
/// Technometrics 4, 1962:
///
/// ```text
/// m_n = m_(n−1) + (x − m_(n−1))/n,   S_n = S_(n−1) + (x − m_(n−1)) (x − m_n)
/// ```
///
/// with both sums compensated, since the increments of the mean fall as 1/n. No cancellation of
/// squares: samples 1000 with a spread of 1e-3 still give the variance of what `f32` can hold of
/// them. Up to 2²⁴ samples, finite ones: a non-finite sample stays in the result.
///
/// ```
/// use model_core::numeric::statistics::Moments;
///
/// let mut moments = Moments::default();
/// for sample in [1004.0, 1007.0, 1013.0, 1016.0] {
///     moments.push(sample);
/// }
/// assert_eq!(moments.mean(), Some(1010.0));
/// assert_eq!(moments.variance(), Some(30.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Moments {
    count: u32,
    mean: Sum,
    squares: Sum,
}

impl Moments {
    /// Takes one sample.
    pub fn push(&mut self, sample: f32) {
        self.count += 1;
        let before = sample - self.mean.value();
        self.mean.add(before / self.count as f32);
        self.squares.add(before * (sample - self.mean.value()));
    }

    /// Number of samples.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Arithmetic mean, in the samples' unit. `None` without samples.
    pub fn mean(&self) -> Option<f32> {
        (self.count > 0).then(|| self.mean.value())
    }

    /// Unbiased variance S/(n − 1), in the samples' unit squared. `None` below two samples.
    pub fn variance(&self) -> Option<f32> {
        (self.count > 1).then(|| self.squares.value() / (self.count - 1) as f32)
    }

    /// Square root of [`variance`](Moments::variance), in the samples' unit.
    pub fn standard_deviation(&self) -> Option<f32> {
        self.variance().map(libm::sqrtf)
    }
}

impl Extend<f32> for Moments {
    fn extend<I: IntoIterator<Item = f32>>(&mut self, samples: I) {
        for sample in samples {
            self.push(sample);
        }
    }
}

/// Root of the mean of the squares, in the samples' unit. `None` without samples.
///
/// Compensated: relative error below 2e-7 for any number of samples up to 2²⁴. A NaN among them
/// gives NaN. The sum of the squares must stay below `f32::MAX`.
///
/// ```
/// use model_core::numeric::statistics::root_mean_square;
///
/// assert_eq!(root_mean_square(&[1.0, -7.0]), Some(5.0));
/// ```
pub fn root_mean_square(samples: &[f32]) -> Option<f32> {
    let mut squares = Sum::default();
    squares.extend(samples.iter().map(|sample| sample * sample));
    (!samples.is_empty()).then(|| libm::sqrtf(squares.value() / samples.len() as f32))
}

/// Median, in the samples' unit; of an even number of samples the mean of the middle two.
///
/// Reorders `samples` and needs no other memory; takes time in proportion to their number.
/// `None` without samples, or if one is NaN.
///
/// ```
/// use model_core::numeric::statistics::median;
///
/// assert_eq!(median(&mut [9.0, 1.0, 4.0, 2.0]), Some(3.0));
/// ```
pub fn median(samples: &mut [f32]) -> Option<f32> {
    if samples.is_empty() || samples.iter().any(|sample| sample.is_nan()) {
        return None;
    }
    let middle = samples.len() / 2;
    let even = samples.len().is_multiple_of(2);
    let (below, &mut upper, _) = samples.select_nth_unstable_by(middle, f32::total_cmp);
    if !even {
        return Some(upper);
    }
    let lower = below.iter().copied().max_by(f32::total_cmp)?;
    // Halved before the addition: the sum of two large samples may not exist.
    Some(0.5 * lower + 0.5 * upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_survives_a_large_offset() {
        // 1000 ± 2⁻⁸ alternately: variance n/(n − 1)·2⁻¹⁶. The sum of squares in f32 loses it:
        // 1000² has a spacing of 0.06.
        const SAMPLES: u32 = 100_000;
        let mut moments = Moments::default();
        moments.extend((0..SAMPLES).map(|k| {
            1000.0
                + if k % 2 == 0 {
                    1.0 / 256.0
                } else {
                    -1.0 / 256.0
                }
        }));
        let expected = SAMPLES as f32 / (SAMPLES - 1) as f32 / 65_536.0;
        assert_eq!(moments.mean(), Some(1000.0));
        assert!((moments.variance().unwrap() / expected - 1.0).abs() < 1e-4);
        assert_eq!(moments.count(), SAMPLES);
    }

    /// 0, 1, … n − 1: mean (n − 1)/2, variance n(n + 1)/12.
    #[test]
    fn moments_of_an_arithmetic_sequence() {
        const SAMPLES: u32 = 1 << 20;
        let mut moments = Moments::default();
        moments.extend((0..SAMPLES).map(|k| k as f32));
        let n = SAMPLES as f32;
        assert!((moments.mean().unwrap() / ((n - 1.0) / 2.0) - 1.0).abs() < 1e-6);
        assert!((moments.variance().unwrap() / (n * (n + 1.0) / 12.0) - 1.0).abs() < 1e-6);
        let deviation = moments.standard_deviation().unwrap();
        assert!((deviation * deviation / moments.variance().unwrap() - 1.0).abs() < 3e-7);
    }

    #[test]
    fn nothing_has_no_statistics() {
        assert_eq!(Moments::default().mean(), None);
        let mut one = Moments::default();
        one.push(3.0);
        assert_eq!(
            (one.mean(), one.variance(), one.standard_deviation()),
            (Some(3.0), None, None)
        );
        assert_eq!(root_mean_square(&[]), None);
        assert_eq!(median(&mut []), None);
    }

    #[test]
    fn median_of_odd_extreme_and_unordered() {
        assert_eq!(median(&mut [5.0]), Some(5.0));
        assert_eq!(median(&mut [3.0, -1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [f32::MAX, f32::MAX]), Some(f32::MAX));
        assert_eq!(
            median(&mut [1.0, f32::NEG_INFINITY, f32::INFINITY]),
            Some(1.0)
        );
        assert_eq!(median(&mut [1.0, f32::NAN, 2.0]), None);
    }

    #[test]
    fn root_mean_square_does_not_drift() {
        const SAMPLES: usize = 100_000;
        assert!((root_mean_square(&[0.1; SAMPLES]).unwrap() / 0.1 - 1.0).abs() < 2e-7);
    }
}
