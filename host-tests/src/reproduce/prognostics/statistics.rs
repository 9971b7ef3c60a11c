//! Quantiles and tolerance limits.

use model_core::numeric::normal::quantile_f32;

/// The value below which a share of the values lies, linearly between neighbours; NaN of nothing.
///
/// ```
/// use host_tests::reproduce::prognostics::statistics::quantile;
///
/// assert_eq!(quantile(&[3.0, 1.0, 2.0, 5.0], 0.5), 2.5);
/// assert_eq!(quantile(&[3.0, 1.0, 2.0, 5.0], 1.0), 5.0);
/// ```
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let (below, above) = (place.floor() as usize, place.ceil() as usize);
    sorted[below] + (place - place.floor()) * (sorted[above] - sorted[below])
}

/// Mean and standard deviation (n − 1).
pub fn moments(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0)).sqrt())
}

/// The upper limit below which, with `confidence`, at least a share `content` of a normal
/// population lies from which the values were drawn: mean + k · deviation, with k by M. G. Natrella,
/// *Experimental Statistics*, NBS Handbook 91, 1963, section 2-5.3.
///
/// ```
/// use host_tests::reproduce::prognostics::statistics::tolerance_factor;
///
/// // Exact, from the noncentral t distribution: 2.684 for 100 values, 99 %, 95 %.
/// assert!((tolerance_factor(100, 0.99, 0.95) - 2.684).abs() < 0.01);
/// ```
pub fn tolerance_factor(count: usize, content: f64, confidence: f64) -> f64 {
    let count = count as f64;
    let content = f64::from(quantile_f32(content as f32));
    let confidence = f64::from(quantile_f32(confidence as f32)).powi(2);
    let a = 1.0 - confidence / (2.0 * (count - 1.0));
    let b = content * content - confidence / count;
    (content + (content * content - a * b).sqrt()) / a
}

/// A straight line by the medians of its pairs' slopes and of what these leave (Theil and Sen): up to
/// 29 % of the points may lie anywhere. `None` with fewer than two different abscissas.
///
/// ```
/// use host_tests::reproduce::prognostics::statistics::robust_line;
///
/// let line = robust_line(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (3.0, 99.0), (4.0, 9.0)]);
/// assert_eq!(line, Some((1.0, 2.0)));
/// ```
pub fn robust_line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let mut slopes = Vec::new();
    for (index, a) in points.iter().enumerate() {
        for b in &points[index + 1..] {
            if b.0 != a.0 {
                slopes.push((b.1 - a.1) / (b.0 - a.0));
            }
        }
    }
    if slopes.is_empty() {
        return None;
    }
    let slope = quantile(&slopes, 0.5);
    let rest: Vec<f64> = points.iter().map(|(x, y)| y - slope * x).collect();
    Some((quantile(&rest, 0.5), slope))
}
