//! What an error costs.

/// A sum of squares in which errors beyond a scale s weigh more: e²(1 + e²/2s²).
///
/// Where a model is asked for a largest error, an error of three scales must not hide behind thirty of
/// one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Penalty {
    /// 1/s².
    curvature: f64,
}

impl Penalty {
    /// With the scale s, rad or m.
    pub fn with_scale(scale: f64) -> Self {
        Self {
            curvature: 1.0 / (scale * scale),
        }
    }

    /// The cost of an error.
    #[inline]
    pub fn of(self, error: f64) -> f64 {
        let square = error * error;
        square * (1.0 + 0.5 * self.curvature * square)
    }

    /// Half of its derivative over the error: the weight in a least-squares step.
    #[inline]
    pub fn weight(self, error: f64) -> f64 {
        1.0 + self.curvature * error * error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_errors_cost_their_square_and_large_ones_more() {
        let penalty = Penalty::with_scale(0.5);
        assert!((penalty.of(0.01) / 1e-4 - 1.0).abs() < 1e-3);
        assert_eq!(penalty.of(1.0), 3.0);
    }

    #[test]
    fn the_weight_is_half_of_the_slope_over_the_error() {
        let penalty = Penalty::with_scale(0.5);
        for error in [-2.0, -0.3, 0.1, 1.5] {
            let slope = (penalty.of(error + 1e-5) - penalty.of(error - 1e-5)) / 2e-5;
            assert!((penalty.weight(error) - slope / (2.0 * error)).abs() < 1e-6);
        }
    }
}
