//! The downhill simplex of J. A. Nelder and R. Mead, *A Simplex Method for Function Minimization*,
//! Computer Journal 7, 1965, with start and end as in MATLAB's `fminsearch`, which knows no bounds.

/// Share of a coordinate by which a corner of the first simplex differs from the start.
const FIRST_STEP: f64 = 0.05;

/// Largest distance between corners at the end, in the coordinate's unit.
const TOLERANCE: f64 = 1e-4;

/// Most evaluations for each parameter.
const MOST: u32 = 200;

/// Minimises a cost from a start; the best corner and the number of evaluations.
///
/// ```
/// use host_tests::reproduce::prognostics::methods::nelder_mead::minimise;
///
/// // Rosenbrock's valley.
/// let (at, _) = minimise([-0.5, 1.5], |[x, y]| (1.0 - x).powi(2) + 100.0 * (y - x * x).powi(2));
/// assert!((at[0] - 1.0).abs() < 1e-3 && (at[1] - 1.0).abs() < 1e-3);
/// ```
pub fn minimise<const N: usize>(
    start: [f64; N],
    mut cost: impl FnMut([f64; N]) -> f64,
) -> ([f64; N], u32) {
    let mut evaluations = 0;
    let mut evaluate = |at: [f64; N]| {
        evaluations += 1;
        let cost = cost(at);
        (at, if cost.is_nan() { f64::INFINITY } else { cost })
    };
    let mut simplex = vec![evaluate(start)];
    for along in 0..N {
        let mut corner = start;
        corner[along] *= 1.0 + FIRST_STEP;
        simplex.push(evaluate(corner));
    }
    let mut used = N as u32 + 1;
    while used < MOST * N as u32 {
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, worst) = (simplex[0], simplex[N]);
        let span = simplex
            .iter()
            .flat_map(|corner| (0..N).map(|i| (corner.0[i] - best.0[i]).abs()))
            .fold(0.0, f64::max);
        if span <= TOLERANCE {
            break;
        }
        let centre: [f64; N] = std::array::from_fn(|i| {
            simplex[..N].iter().map(|corner| corner.0[i]).sum::<f64>() / N as f64
        });
        // From the worst corner through the centre of the others: 1 is the reflection.
        let beyond = |share: f64| -> [f64; N] {
            std::array::from_fn(|i| centre[i] + share * (centre[i] - worst.0[i]))
        };
        let reflected = evaluate(beyond(1.0));
        used += 1;
        let replacement = if reflected.1 < best.1 {
            used += 1;
            let expanded = evaluate(beyond(2.0));
            Some(if expanded.1 < reflected.1 {
                expanded
            } else {
                reflected
            })
        } else if reflected.1 < simplex[N - 1].1 {
            Some(reflected)
        } else {
            used += 1;
            let (share, limit) = if reflected.1 < worst.1 {
                (0.5, reflected.1)
            } else {
                (-0.5, worst.1)
            };
            let contracted = evaluate(beyond(share));
            (contracted.1 <= limit).then_some(contracted)
        };
        match replacement {
            Some(corner) => simplex[N] = corner,
            None => {
                for corner in &mut simplex[1..] {
                    *corner = evaluate(std::array::from_fn(|i| 0.5 * (corner.0[i] + best.0[i])));
                    used += 1;
                }
            }
        }
    }
    simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
    (simplex[0].0, evaluations)
}
