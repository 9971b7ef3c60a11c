//! b₀ from a fast log: eq. 20, the least error of a free run.

use std::ops::Range;

use model_core::identify::golden_section;

use super::{Assembly, Number, Numbers, Series};
use crate::free_run;

/// The search spans this factor either way of the value that it starts from.
const SPAN: f32 = 30.0;

/// Values tried over the span before the golden section: the cost may have more than one minimum.
const SCAN: u32 = 24;

/// Relative step of the sensitivity.
const STEP: f64 = 0.01;

/// Length of a block of residuals, s: far longer than their correlation.
const BLOCK_S: f32 = 1.0;

/// 97.5 % point of the normal distribution.
const NORMAL_975: f64 = 1.96;

/// What was found.
pub(super) struct Found {
    /// b₀.
    pub number: Number,
    /// Simulations of the log.
    pub simulations: usize,
}

/// The b₀, with the declared inductance or without, with the least error on the log. `None` if it is at the end of the
/// span, or without influence on the log.
///
/// The error is the sum over blocks of [`BLOCK_S`] of the *root* of the block's mean square, not of the
/// mean square itself as in eq. 20: a level of the input next to the breakaway leaves the model where
/// the machine moved on, or the other way round, and such a block would outweigh all others though it
/// says nothing of the inertia.
///
/// The interval is that of the weighted least squares in ln b₀ that this is at the minimum, its variance
/// N⁻¹ Σ(block gradient)² N⁻¹ over the blocks, within which residuals may be correlated as they like.
/// What the ratios' own intervals do to b₀ is added, as if the ratios were independent. Blocks in
/// which the small step of a sensitivity moves a breakaway do not take part.
pub(super) fn find(
    assembly: &Assembly,
    numbers: &Numbers,
    log: &Series,
    inductance: bool,
) -> Option<Found> {
    let block = ((BLOCK_S / log.period) as usize).max(1);
    let mut simulations = 0;
    let mut simulate = |values: &[f64; 6]| {
        simulations += 1;
        let parameters = assembly.parameters(values, inductance);
        free_run::simulate(&parameters, log.period, &log.input, log.position[0]).ok()
    };
    let start = numbers.b0.value;
    let mut cost = |logarithm: f32| {
        let mut values = numbers.values();
        values[5] = start * f64::from(logarithm).exp();
        simulate(&values).map_or(f32::INFINITY, |predicted| {
            block_roots(&predicted, &log.position, block)
                .iter()
                .sum::<f64>() as f32
        })
    };
    let span = SPAN.ln();
    let at = |index: u32| span * (2.0 * index as f32 / SCAN as f32 - 1.0);
    let costs: Vec<f32> = (0..=SCAN).map(|index| cost(at(index))).collect();
    let best = (0..=SCAN).min_by(|&a, &b| costs[a as usize].total_cmp(&costs[b as usize]))?;
    if best == 0 || best == SCAN {
        return None;
    }
    let mut search = golden_section::Parameters {
        lower: at(best - 1),
        upper: at(best + 1),
        tolerance: 3e-4,
        evaluations: 40,
    }
    .build()
    .ok()?;
    while let Some(candidate) = search.propose() {
        search.report(cost(candidate));
    }
    let value = start * f64::from(search.best()?.0).exp();
    let mut at_minimum = numbers.values();
    at_minimum[5] = value;
    let centre = simulate(&at_minimum)?;
    let mut sensitivity = |index: usize, step: f64| {
        let moved = |step: f64| {
            let mut values = at_minimum;
            values[index] += step;
            values
        };
        let (above, below) = (simulate(&moved(step))?, simulate(&moved(-step))?);
        Some(Sensitivity::new(&above, &centre, &below))
    };
    let own = sensitivity(5, STEP * value)?;
    // What a standard deviation of each ratio does to the position.
    let ratios: Vec<Sensitivity> = numbers.all()[..5]
        .iter()
        .enumerate()
        .filter_map(|(index, number)| sensitivity(index, number.half_width / NORMAL_975))
        .collect();
    let roots = block_roots(&centre, &log.position, block);
    let (mut normal, mut gradients, mut blocks) = (0.0, 0.0, 0.0);
    let mut shifts = vec![0.0; ratios.len()];
    for (number, root) in roots.iter().enumerate() {
        let rows = number * block..((number + 1) * block).min(centre.len());
        if !own.is_smooth(rows.clone()) {
            continue;
        }
        let weight = 1.0 / root.max(1e-12);
        let residuals = rows
            .clone()
            .map(|k| f64::from(log.position[k]) - f64::from(centre[k]));
        normal += weight * own.product(rows.clone(), own.slope[rows.clone()].iter().copied());
        gradients += (weight * own.product(rows.clone(), residuals)).powi(2);
        blocks += 1.0;
        for (shift, ratio) in shifts.iter_mut().zip(&ratios) {
            if ratio.is_smooth(rows.clone()) {
                let slopes = ratio.slope[rows.clone()].iter().copied();
                *shift += weight * own.product(rows.clone(), slopes);
            }
        }
    }
    let small_sample = blocks / (blocks - 1.0_f64).max(1.0);
    // `own` is for a step of STEP b₀, the others for a standard deviation.
    let by_log = small_sample * gradients;
    let by_ratios: f64 = shifts.iter().map(|shift| shift * shift).sum();
    let deviation = STEP * (by_log + by_ratios).sqrt() / normal;
    deviation.is_finite().then_some(Found {
        number: Number {
            value,
            half_width: NORMAL_975 * deviation * value,
        },
        simulations,
    })
}

/// What a step of a number does to the position.
struct Sensitivity {
    /// Half of the difference between a step up and a step down.
    slope: Vec<f64>,
    /// What of both is not linear.
    bend: Vec<f64>,
}

impl Sensitivity {
    fn new(above: &[f32], centre: &[f32], below: &[f32]) -> Self {
        let rows = || above.iter().zip(centre).zip(below);
        let rows = || rows().map(|((a, c), b)| [a, c, b].map(|position| f64::from(*position)));
        Self {
            slope: rows().map(|[a, _, b]| 0.5 * (a - b)).collect(),
            bend: rows().map(|[a, c, b]| a + b - 2.0 * c).collect(),
        }
    }

    /// Whether no breakaway moves on these rows.
    fn is_smooth(&self, rows: Range<usize>) -> bool {
        let square = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        square(&self.bend[rows.clone()]) <= square(&self.slope[rows])
    }

    /// Sum of products with the slope.
    fn product(&self, rows: Range<usize>, other: impl Iterator<Item = f64>) -> f64 {
        let pairs = self.slope[rows].iter().zip(other);
        pairs.map(|(slope, other)| slope * other).sum()
    }
}

/// Root mean square error of each block.
fn block_roots(predicted: &[f32], measured: &[f32], block: usize) -> Vec<f64> {
    predicted
        .chunks(block)
        .zip(measured.chunks(block))
        .map(|(predicted, measured)| {
            let pairs = predicted.iter().zip(measured);
            let squares = pairs.map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
            (squares.sum::<f64>() / predicted.len() as f64).sqrt()
        })
        .collect()
}
