//! Is the residual white, and what does it go along with?

use model_core::gap::model::Model;
use model_core::gap::replay::Data;
use model_core::numeric::ljung_box::ljung_box;

use super::metrics::torque_balance;
use super::outcome::{Correlations, Whiteness};
use crate::failure::Failure;

/// Lags of the whiteness test.
const LAGS: usize = 20;

/// Correlation of two series of equal length; 0 where one does not vary.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |series: &[f64]| series.iter().sum::<f64>() / series.len() as f64;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let (mut shared, mut own_a, mut own_b) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - mean_a, b - mean_b);
        shared += a * b;
        own_a += a * a;
        own_b += b * b;
    }
    let norm = (own_a * own_b).sqrt();
    if norm > 0.0 { shared / norm } else { 0.0 }
}

/// Whiteness of the base fit's torque residual, and what it goes along with.
pub(super) fn whiteness(data: &Data, model: &Model) -> Result<Whiteness, Failure> {
    let (mut residual, mut input, mut velocity) = (Vec::new(), Vec::new(), Vec::new());
    for log in data.logs {
        let balance = torque_balance(log, model, f64::from(data.settings.resolution))
            .map_err(|error| Failure::other(error.to_string()))?;
        residual.extend(balance.residual);
        velocity.extend(balance.velocity);
        input.extend(balance.sample.iter().map(|&at| f64::from(log.input.at(at))));
    }
    let along = |series: &[f64], of: fn(f64) -> f64| {
        let series: Vec<f64> = series.iter().map(|&value| of(value)).collect();
        correlation(&residual, &series)
    };
    let correlations = Correlations {
        input: along(&input, |u| u),
        velocity: along(&velocity, |v| v),
        direction: along(&velocity, f64::signum),
        input_squared: along(&input, |u| u * u),
    };
    let mean = residual.iter().sum::<f64>() / residual.len() as f64;
    let product = |lag: usize| -> f64 {
        residual
            .iter()
            .zip(&residual[lag..])
            .map(|(a, b)| (a - mean) * (b - mean))
            .sum()
    };
    let lags = LAGS.min(residual.len() / 4);
    let variance = product(0);
    let autocorrelations: Vec<f32> = (1..=lags)
        // At rest friction takes whatever acts: a residual may be zero throughout.
        .map(|lag| {
            if variance > 0.0 {
                product(lag) / variance
            } else {
                0.0
            }
        })
        .map(|autocorrelation| autocorrelation as f32)
        .collect();
    let test = ljung_box(&autocorrelations, residual.len() as u32, 0)
        .map_err(|error| Failure::other(error.to_string()))?;
    Ok(Whiteness {
        ljung_box: f64::from(test.statistic as f32) / lags as f64,
        lags,
        p_value: test.p_value,
        correlations,
    })
}
