//! Sample by sample, what the report draws.

use model_core::gap::model::Model;
use model_core::gap::replay::{Data, Row, Runner};
use model_core::gap::verdict::Trace;
use model_core::plant::parameters::ParameterError;

use super::component::components;
use super::metrics::torque_balance;
use super::outcome::Evidence;
use super::series::Series;
use crate::failure::Failure;
use crate::quantity::decimal;

fn refused(error: ParameterError) -> Failure {
    Failure::other(error.to_string())
}

/// Positions of a model replayed in windows; the measurement where no window reaches.
fn windowed(data: &Data, log: usize, model: &Model) -> Result<(Vec<f32>, Vec<usize>), Failure> {
    let series = &data.logs[log];
    let simulator = model.build(series.period).map_err(refused)?;
    let mut positions: Vec<f32> = series.position.iter().collect();
    let mut starts = Vec::new();
    for number in 0..data.windows() {
        let Some(window) = data.window(number).filter(|window| window.log == log) else {
            continue;
        };
        starts.push(window.start);
        let mut runner = Runner::new(&simulator, series, window.start, &data.settings);
        for index in window.start..window.start + data.settings.window {
            runner.advance(&Row::new(series, index));
            positions[index + 1] = runner.reported();
        }
    }
    Ok((positions, starts))
}

/// The evidence of every log, in their order.
pub(super) fn evidence(
    series: &[Series],
    data: &Data,
    declared: &Model,
    trace: &Trace,
) -> Result<Vec<Evidence>, Failure> {
    series
        .iter()
        .enumerate()
        .map(|(index, series)| {
            let log = series.log();
            let (before, window_starts) = windowed(data, index, &trace.before.model)?;
            let (after, _) = windowed(data, index, &trace.after.model)?;
            let balance = |model: &Model| {
                torque_balance(&log, model, f64::from(data.settings.resolution)).map_err(refused)
            };
            let (torque_before, torque_after) =
                (balance(&trace.before.model)?, balance(&trace.after.model)?);
            let narrow =
                |series: &[f64]| -> Vec<f32> { series.iter().map(|&value| value as f32).collect() };
            let time = |sample: usize| (sample as f64 * decimal(series.period)) as f32;
            let samples = log.samples();
            let half = data.settings.half_width;
            Ok(Evidence {
                label: series.label.clone(),
                time: (0..samples).map(time).collect(),
                position: series.position.clone(),
                velocity: (0..samples)
                    .map(|sample| {
                        let inside = sample.max(half).min(samples - 1 - half);
                        let state = log.smoothed_state(inside, half, data.settings.resolution);
                        state.velocity.value()
                    })
                    .collect(),
                input: series.input.clone(),
                current: series.current.clone().unwrap_or_default(),
                before,
                after,
                torque_before: narrow(&torque_before.residual),
                torque_after: narrow(&torque_after.residual),
                torque_time: torque_before.sample.iter().map(|&s| time(s)).collect(),
                torque_velocity: narrow(&torque_before.velocity),
                torque_position: narrow(&torque_before.position),
                window_starts,
                components: components(data, index, declared, &trace.after.model)
                    .map_err(refused)?,
            })
        })
        .collect()
}
