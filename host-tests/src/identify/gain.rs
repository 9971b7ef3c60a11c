//! b₀ from a fast log: eq. 20, the least mean square error of a free run.

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

/// The b₀ of the reduced motor with the least error on the log. `None` if it is at the end of the
/// span, or without influence on the log.
///
/// The interval is that of least squares in ln b₀ at the minimum, its variance N⁻¹ Σ(block gradient)²
/// N⁻¹ over blocks of [`BLOCK_S`], within which residuals may be correlated as they like.
pub(super) fn find(assembly: &Assembly, numbers: &Numbers, log: &Series) -> Option<Found> {
    let mut simulations = 0;
    let mut simulate = |b0: f64| {
        simulations += 1;
        let mut values = numbers.values();
        values[5] = b0;
        let parameters = assembly.parameters(&values, false);
        free_run::simulate(&parameters, log.period, &log.input, log.position[0]).ok()
    };
    let start = numbers.b0.value;
    let mut cost = |logarithm: f32| {
        simulate(start * f64::from(logarithm).exp()).map_or(f32::INFINITY, |predicted| {
            let errors = free_run::errors(&predicted, &log.position);
            errors.nrmse as f32
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
    let block = ((BLOCK_S / log.period) as usize).max(1);
    let (mut normal, mut gradients, mut gradient) = (0.0, 0.0, 0.0);
    let blocks = centre.len().div_ceil(block);
    for (k, &predicted) in centre.iter().enumerate() {
        let sensitivity = (f64::from(above[k]) - f64::from(below[k])) / (2.0 * STEP);
        let residual = f64::from(log.position[k]) - f64::from(predicted);
        normal += sensitivity * sensitivity;
        gradient += sensitivity * residual;
        if (k + 1) % block == 0 || k + 1 == centre.len() {
            gradients += gradient * gradient;
            gradient = 0.0;
        }
    }
    let small_sample = blocks as f64 / (blocks as f64 - 1.0).max(1.0);
    let deviation = (small_sample * gradients).sqrt() / normal;
    deviation.is_finite().then_some(Found {
        number: Number {
            value,
            half_width: NORMAL_975 * deviation * value,
        },
        simulations,
    })
}
