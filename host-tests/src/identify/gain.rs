//! b₀ from a fast log: eq. 20, the least error of a free run.

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
pub(super) const BLOCK_S: f32 = 1.0;

/// 97.5 % point of the normal distribution.
pub(super) const NORMAL_975: f64 = 1.96;

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
/// Blocks in which the small step of the sensitivity moves a breakaway do not take part.
pub(super) fn find(
    assembly: &Assembly,
    numbers: &Numbers,
    log: &Series,
    inductance: bool,
) -> Option<Found> {
    let block = ((BLOCK_S / log.period) as usize).max(1);
    let mut simulations = 0;
    let mut simulate = |b0: f64| {
        simulations += 1;
        let mut values = numbers.values();
        values[5] = b0;
        let parameters = assembly.parameters(&values, inductance);
        free_run::simulate(&parameters, log.period, &log.input, log.position[0]).ok()
    };
    let start = numbers.b0.value;
    let mut cost = |logarithm: f32| {
        simulate(start * f64::from(logarithm).exp()).map_or(f32::INFINITY, |predicted| {
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
    let centre = simulate(value)?;
    let (above, below) = (
        simulate(value * STEP.exp())?,
        simulate(value * (-STEP).exp())?,
    );
    let roots = block_roots(&centre, &log.position, block);
    let (mut normal, mut gradients, mut blocks) = (0.0, 0.0, 0.0);
    for (number, root) in roots.iter().enumerate() {
        let (mut own, mut gradient, mut bend) = (0.0, 0.0, 0.0);
        for k in number * block..((number + 1) * block).min(centre.len()) {
            let [above, below, centre] = [&above, &below, &centre].map(|run| f64::from(run[k]));
            let sensitivity = (above - below) / (2.0 * STEP);
            own += sensitivity * sensitivity;
            gradient += sensitivity * (f64::from(log.position[k]) - centre);
            bend += ((above + below - 2.0 * centre) / STEP).powi(2);
        }
        if bend <= own {
            let weight = 1.0 / root.max(1e-12);
            normal += weight * own;
            gradients += (weight * gradient).powi(2);
            blocks += 1.0;
        }
    }
    let small_sample = blocks / (blocks - 1.0_f64).max(1.0);
    let deviation = (small_sample * gradients).sqrt() / normal;
    deviation.is_finite().then_some(Found {
        number: Number {
            value,
            half_width: NORMAL_975 * deviation * value,
        },
        simulations,
    })
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
