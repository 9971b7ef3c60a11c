//! The standard normal distribution.

use core::f64::consts::FRAC_1_SQRT_2;

/// P(X ≤ x) of a standard normal X.
///
/// Any `x`; NaN gives NaN. Computed in `f64` as erfc(−x/√2)/2, hence relative error below 1e-13 in
/// the lower tail down to 1e-16 as well as in the bulk.
///
/// ```
/// use model_core::numeric::normal::cumulative;
///
/// assert!((cumulative(1.96) - 0.975_002_104_851_78).abs() < 1e-14);
/// ```
pub fn cumulative(x: f64) -> f64 {
    upper_tail(-x)
}

/// P(X > x) of a standard normal X, as accurate in the upper tail as [`cumulative`] is in the lower.
///
/// ```
/// use model_core::numeric::normal::upper_tail;
///
/// assert!((upper_tail(4.0) / 3.167_124_183_311_986e-5 - 1.0).abs() < 1e-14);
/// ```
pub fn upper_tail(x: f64) -> f64 {
    0.5 * libm::erfc(x * FRAC_1_SQRT_2)
}

/// The x with P(X ≤ x) = `probability`, for random numbers.
///
/// Any `probability` in (0, 1); outside of it the result is NaN. Wichura, *Algorithm
/// AS 241: The Percentage Points of the Normal Distribution*, Applied Statistics 37, 1988, routine
/// PPND7: a rational function of the central part, and of √(−ln p) in the tails. Relative error
/// below 1e-6, most of it rounding in `f32`.
///
/// ```
/// use model_core::numeric::normal::quantile_f32;
///
/// assert!((quantile_f32(0.01) + 2.326_347_9).abs() < 1e-6);
/// ```
pub fn quantile_f32(probability: f32) -> f32 {
    let central = probability - 0.5;
    if central.abs() <= 0.425 {
        let r = 0.180_625 - central * central;
        return central * (((59.109_375 * r + 159.291_13) * r + 50.434_27) * r + 3.387_132_7)
            / (((67.187_56 * r + 78.757_76) * r + 17.895_17) * r + 1.0);
    }
    let tail = if central < 0.0 {
        probability
    } else {
        1.0 - probability
    };
    // Of zero and of a negative number the logarithm leads to NaN, as it should.
    let r = libm::sqrtf(-libm::logf(tail));
    let value = if r <= 5.0 {
        let r = r - 1.6;
        (((0.170_238_21 * r + 1.306_728_5) * r + 2.756_815_4) * r + 1.423_437_3)
            / ((0.120_211_33 * r + 0.737_001_64) * r + 1.0)
    } else {
        let r = r - 5.0;
        (((0.017_337_204 * r + 0.428_682_94) * r + 3.081_226_4) * r + 6.657_905)
            / ((0.012_258_203 * r + 0.241_978_94) * r + 1.0)
    };
    if central < 0.0 { -value } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `scipy.stats.norm.sf(x)`, SciPy 1.17.
    #[test]
    fn tail_equals_scipy() {
        for (x, expected) in [
            (-3.0, 0.998_650_101_968_369_9),
            (0.0, 0.5),
            (0.5, 0.308_537_538_725_986_9),
            (2.5, 0.006_209_665_325_776_132),
            (5.612_001_244, 1.000_000_001_010_335e-8),
            (8.0, 6.220_960_574_271_74e-16),
        ] {
            assert!(
                (upper_tail(x) / expected - 1.0).abs() < 1e-13,
                "{x}: {}",
                upper_tail(x)
            );
            assert!((cumulative(-x) / expected - 1.0).abs() < 1e-13);
        }
        assert!(upper_tail(f64::NAN).is_nan());
    }

    /// `scipy.special.ndtri(p)`, SciPy 1.17.
    #[test]
    fn quantile_equals_scipy() {
        assert_eq!(quantile_f32(0.5), 0.0);
        for (probability, expected) in [
            (0.25, -0.674_489_75),
            (0.75, 0.674_489_75),
            (0.01, -2.326_347_9),
            (1e-6, -4.753_424),
            (1.0 / 8_589_934_592.0, -6.337_958),
            (1e-20, -9.262_34),
            (1e-37, -12.784_557),
        ] {
            let quantile = quantile_f32(probability);
            assert!(
                (quantile / expected - 1.0).abs() < 1e-6,
                "{probability}: {quantile}"
            );
        }
        for refused in [0.0, 1.0, -0.1, 1.1, f32::NAN] {
            assert!(quantile_f32(refused).is_nan());
        }
    }

    #[test]
    fn quantile_inverts_the_distribution() {
        // Every branch and both borders between them.
        for step in 1..2000 {
            let probability = step as f32 / 2000.0;
            let back = cumulative(f64::from(quantile_f32(probability)));
            assert!(
                (back - f64::from(probability)).abs() < 3e-7,
                "{probability}: {back}"
            );
        }
    }
}
