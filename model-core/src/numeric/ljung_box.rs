//! Ljung–Box test: is a residual white?

use super::chi_square;
use super::invalid_parameter::{InvalidParameter, require};

/// Outcome of [`ljung_box`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LjungBox {
    /// Q, without unit.
    pub statistic: f64,
    /// Probability of such a Q or a larger one from a white residual.
    pub p_value: f64,
}

/// Tests whether the first m autocorrelations of a residual are those of white noise.
///
/// Ljung and Box, *On a measure of lack of fit in time series models*, Biometrika 65, 1978:
///
/// ```text
/// Q = n (n + 2) Σ ρ_k² / (n − k),   k = 1 … m,   chi-square with m − fitted degrees of freedom
/// ```
///
/// `autocorrelations` holds ρ₁ … ρ_m (lag zero left out), `samples` is n, `fitted` the number of
/// parameters of the noise model fitted to the series (zero for a plain residual).
/// Refused: m ≤ `fitted`, n ≤ m, and autocorrelations outside ±1.
///
/// ```
/// use model_core::numeric::ljung_box::ljung_box;
///
/// let test = ljung_box(&[0.2, -0.1, 0.05, 0.15, -0.02], 100, 0)?;
/// assert!((test.statistic - 7.858_487_4).abs() < 1e-6);
/// assert!((test.p_value - 0.164_209_0).abs() < 1e-6);
/// # Ok::<(), model_core::numeric::invalid_parameter::InvalidParameter>(())
/// ```
pub fn ljung_box(
    autocorrelations: &[f32],
    samples: u32,
    fitted: u32,
) -> Result<LjungBox, InvalidParameter> {
    let within = autocorrelations
        .iter()
        .all(|rho| (-1.0..=1.0).contains(rho));
    require(within, "autocorrelations", "must lie between -1 and 1")?;
    let lags = u32::try_from(autocorrelations.len()).unwrap_or(u32::MAX);
    require(
        lags > fitted,
        "autocorrelations",
        "must be more than the fitted parameters",
    )?;
    require(samples > lags, "samples", "must be more than the lags")?;

    let n = f64::from(samples);
    let mut sum = 0.0;
    let mut overlap = n;
    for &rho in autocorrelations {
        overlap -= 1.0;
        sum += f64::from(rho) * f64::from(rho) / overlap;
    }
    let statistic = n * (n + 2.0) * sum;
    Ok(LjungBox {
        statistic,
        p_value: chi_square::upper_tail(statistic, lags - fitted),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `Q = n*(n+2)*sum(r**2/(n-arange(1,m+1)))` in NumPy and `scipy.stats.chi2.sf(Q, m - 2)`.
    #[test]
    fn fitted_parameters_cost_degrees_of_freedom() {
        let test = ljung_box(&[0.2, -0.1, 0.05, 0.15, -0.02], 100, 2).unwrap();
        assert!((test.statistic - 7.858_487_414_101_932).abs() < 1e-6);
        assert!((test.p_value - 0.049_028_696_047_359_24).abs() < 1e-7);
    }

    #[test]
    fn refuses_what_has_no_answer() {
        assert_eq!(
            ljung_box(&[0.1, f32::NAN], 10, 0).unwrap_err().name,
            "autocorrelations"
        );
        assert_eq!(
            ljung_box(&[0.1, 0.1], 10, 2).unwrap_err().name,
            "autocorrelations"
        );
        assert_eq!(ljung_box(&[], 10, 0).unwrap_err().name, "autocorrelations");
        assert_eq!(ljung_box(&[0.1, 0.1], 2, 0).unwrap_err().name, "samples");
    }
}
