//! Least squares on the replay: Levenberg–Marquardt with difference quotients.

use nalgebra::{SMatrix, SVector};

/// Step of a difference quotient, as a share of the parameter.
const STEP: f64 = 1e-3;

/// Most iterations.
const MOST: u32 = 30;

/// Relative change of all parameters at which it is done.
const TOLERANCE: f64 = 1e-4;

/// Minimises the sum of squares of what `residuals` gives, between bounds; the parameters and the
/// number of evaluations.
///
/// ```
/// use host_tests::reproduce::prognostics::methods::least_squares::minimise;
///
/// // Rosenbrock's valley.
/// let residuals = |[x, y]: [f64; 2]| vec![1.0 - x, 10.0 * (y - x * x)];
/// let (at, _) = minimise([-0.5, 1.5], [-9.0; 2], [9.0; 2], residuals);
/// assert!((at[0] - 1.0).abs() < 1e-3 && (at[1] - 1.0).abs() < 1e-3);
/// ```
pub fn minimise<const N: usize>(
    start: [f64; N],
    lower: [f64; N],
    upper: [f64; N],
    mut residuals: impl FnMut([f64; N]) -> Vec<f64>,
) -> ([f64; N], u32) {
    let squares = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
    let mut at = start;
    let mut current = residuals(at);
    let (mut evaluations, mut damping) = (1, 1e-3);
    for _ in 0..MOST {
        let columns: [Vec<f64>; N] = std::array::from_fn(|i| {
            let mut moved = at;
            // Inwards at the upper bound.
            let step = if at[i] * (1.0 + STEP) > upper[i] {
                -STEP * at[i]
            } else {
                STEP * at[i]
            };
            moved[i] += step;
            evaluations += 1;
            let there = residuals(moved);
            let pairs = there.iter().zip(&current);
            pairs.map(|(there, here)| (there - here) / step).collect()
        });
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let normal = SMatrix::<f64, N, N>::from_fn(|i, j| dot(&columns[i], &columns[j]));
        let slope = SVector::<f64, N>::from_fn(|i, _| dot(&columns[i], &current));
        let mut change = f64::INFINITY;
        // Damped until the step gains; so often in vain that there is none that does.
        for _ in 0..8 {
            let mut damped = normal;
            for i in 0..N {
                damped[(i, i)] += damping * normal[(i, i)] + f64::MIN_POSITIVE;
            }
            let Some(step) = damped.cholesky().map(|factor| factor.solve(&slope)) else {
                return (at, evaluations);
            };
            let next: [f64; N] =
                std::array::from_fn(|i| (at[i] - step[i]).clamp(lower[i], upper[i]));
            evaluations += 1;
            let there = residuals(next);
            if squares(&there) < squares(&current) {
                change = (0..N)
                    .map(|i| ((next[i] - at[i]) / at[i]).abs())
                    .fold(0.0, f64::max);
                at = next;
                current = there;
                damping *= 0.1;
                break;
            }
            damping *= 10.0;
        }
        if change < TOLERANCE || change.is_infinite() {
            break;
        }
    }
    (at, evaluations)
}
