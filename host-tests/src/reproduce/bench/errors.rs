//! RMSE and NRMSE as the paper defines them (ch. 6.3.1).

/// How far values are off a measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Root of the mean square of the differences, over all n values.
    pub rmse: f64,
    /// The RMSE over the measurement's range, its largest value less its smallest. The paper prints it
    /// in per cent.
    pub nrmse: f64,
}

/// The errors of a model's values beside a measurement (the paper's ŷ). Without values, or of a
/// measurement without range, they are not finite.
///
/// ```
/// use host_tests::reproduce::bench::errors::errors;
///
/// let found = errors(&[1.0, 2.0, 5.0, 6.0], &[1.0, 2.0, 3.0, 6.0]);
/// assert_eq!(found.rmse, 1.0);
/// assert_eq!(found.nrmse, 0.2);
/// ```
pub fn errors(model: &[f64], measured: &[f64]) -> Errors {
    let pairs = model.iter().zip(measured);
    let squares: f64 = pairs.map(|(model, y)| (model - y).powi(2)).sum();
    let rmse = (squares / measured.len() as f64).sqrt();
    Errors {
        rmse,
        nrmse: rmse / range(measured),
    }
}

/// The RMSE with n less the number of fitted parameters below the sum, as curve fitting tools give it.
pub fn rmse_of_fit(model: &[f64], measured: &[f64], fitted: usize) -> f64 {
    let count = measured.len() as f64;
    errors(model, measured).rmse * (count / (count - fitted as f64)).sqrt()
}

/// The largest value less the smallest.
pub fn range(values: &[f64]) -> f64 {
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    largest - smallest
}
