//! An effect as the data show it, and as it was fitted.

use std::io;

use crate::gap::component::{Component, Quantity, SHOWN, Variable};
use crate::gap::outcome::{Evidence, Report};
use crate::page::plot::{self, AFTER, Layer, MEASURED, Mark, Panel};
use crate::page::series::{Point, binned_mean, bulk, extent, points, rms, thin};
use crate::page::{Figure, escape};
use crate::quantity::Scale;

/// Fewer samples are not drawn.
const SHORTEST: usize = 40;
/// Marks of the cloud.
const CLOUD: usize = 900;
/// Most stretches of the horizontal axis that a mean is taken over.
const BINS: usize = 60;
/// Fewest samples that make a mean.
const LEAST: usize = 3;

/// The picture of an effect in a log; none where the log is too short or shows nothing of it.
pub(super) fn of_effect(
    report: &Report,
    log: &Evidence,
    component: &Component,
) -> io::Result<Option<Figure>> {
    let whole = points(&component.x, &component.component);
    let Some((lowest, highest)) = extent(whole.iter().map(|p| p.1)) else {
        return Ok(None);
    };
    let Some(ends) = component.ends() else {
        return Ok(None);
    };
    let inside = |points: Vec<Point>| -> Vec<Point> {
        let within = |p: &Point| (ends.0..=ends.1).contains(&p.0);
        points.into_iter().filter(within).collect()
    };
    let fitted = inside(whole);
    let data = inside(points(&component.x, &component.partial_residual));
    if fitted.len() < SHORTEST || data.len() != fitted.len() || highest <= lowest {
        return Ok(None);
    }
    let bins = stretches(data.len());
    let means = [&data, &fitted].map(|points| stretch_means(points, bins));
    let apart = rms((means[0].iter().zip(&means[1])).map(|(data, fitted)| data.1 - fitted.1));
    let range = extent(means[1].iter().map(|p| p.1)).unwrap_or((0.0, 0.0));
    let span = range.1 - range.0;

    let (what, unit) = quantity(report, component.quantity);
    let (over, over_unit) = variable(report, component.variable);
    let y = Scale::of(unit, means.iter().flatten().map(|p| p.1));
    let x = Scale::of(&over_unit, [ends.0, ends.1]);
    let placed = |points: &[Point]| -> Vec<Point> {
        let place = |p: &Point| (p.0 * x.factor, p.1 * y.factor);
        points.iter().map(place).collect()
    };
    let tall = bulk(&data.iter().map(|p| p.1).collect::<Vec<_>>(), SHOWN).unwrap_or(range);
    let tall = (tall.0.min(range.0), tall.1.max(range.1));
    let shown: Vec<Point> = data
        .iter()
        .filter(|p| (tall.0..=tall.1).contains(&p.1))
        .copied()
        .collect();
    let layer = |mark: Mark, colour, opacity: f64, points: &[Point]| Layer {
        mark,
        colour,
        opacity,
        points: placed(points),
    };
    let panel = Panel {
        title: format!("{}: {what}, {}", component.id, y.unit),
        x_title: format!("{over}, {}", x.unit),
        x: Panel::padded((ends.0 * x.factor, ends.1 * x.factor)),
        y: Panel::padded((tall.0 * y.factor, tall.1 * y.factor)),
        layers: vec![
            layer(Mark::Dot(4), MEASURED, 0.25, &thin(&shown, CLOUD)),
            layer(Mark::Dot(7), MEASURED, 1.0, &means[0]),
            layer(Mark::Line(5), AFTER, 1.0, &means[1]),
        ],
    };
    // An effect that hardly varies over it has no range to compare with.
    let share = if span > apart {
        format!(
            ", {} of its range of {}",
            Scale::percent().quantity(apart / span),
            y.quantity(span)
        )
    } else {
        String::new()
    };
    Ok(Some(Figure {
        statement: format!(
            "Over {over} the fitted effect and the data are {} rms apart{share}.",
            y.quantity(apart)
        ),
        method: format!(
            "{}. Dots: the data less all other parts of the model; large dots and curve: means in {bins} equal stretches.",
            log.label
        ),
        keys: vec![("measured", "data"), ("after", "fitted effect")],
        svg: plot::draw(
            &[(520, vec![panel])],
            &escape(&format!("{} over {over}", component.id)),
        )?,
    }))
}

/// Stretches that so many samples are enough for: twice as many as a mean takes in each, so that some have enough however
/// the samples lie.
fn stretches(samples: usize) -> usize {
    (samples / (2 * LEAST)).clamp(1, BINS)
}

/// The means of samples in so many stretches; those with few samples are left out.
fn stretch_means(points: &[Point], bins: usize) -> Vec<Point> {
    binned_mean(points, bins, (points.len() / (20 * bins)).max(LEAST))
}

/// What the vertical axis shows, and its unit.
fn quantity(report: &Report, quantity: Quantity) -> (&'static str, &str) {
    match quantity {
        Quantity::Torque => ("what it takes of the motor", &report.load_unit),
        Quantity::Friction => ("friction", &report.load_unit),
        Quantity::Reading => ("reading error", &report.coordinate),
        Quantity::LostMotion => ("lost motion", &report.coordinate),
        Quantity::Twist => ("twist", &report.coordinate),
    }
}

/// What the horizontal axis shows, and its unit.
fn variable(report: &Report, variable: Variable) -> (&'static str, String) {
    let (coordinate, load) = (&report.coordinate, &report.load_unit);
    match variable {
        Variable::Velocity => ("velocity", format!("{coordinate}/s")),
        Variable::Position => ("position", coordinate.clone()),
        Variable::PositionInPeriod => ("position in a period", coordinate.clone()),
        Variable::MotorTorque => ("the motor's load", load.clone()),
        Variable::TorqueRate => ("the rate of the motor's load", format!("{load}/s")),
        Variable::Time => ("time", "s".to_owned()),
        Variable::TravelSinceTurn => ("travel since the last turn", coordinate.clone()),
        Variable::Deflection => (
            "the deflection that remembers the last turns",
            coordinate.clone(),
        ),
        Variable::Acceleration => ("the acceleration of the drive", format!("{coordinate}/s²")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a short log a sixtieth of the axis holds a sample or two: no mean, and nothing to be apart by.
    #[test]
    fn the_fewest_samples_that_are_drawn_have_means_however_they_lie() {
        for samples in [SHORTEST, 50, 100, 1000] {
            for power in [1, 2, 5] {
                let places = (0..samples).map(|k| (k as f64 / samples as f64).powi(power));
                let points: Vec<Point> = places.map(|x| (x, 7.0)).collect();
                let means = stretch_means(&points, stretches(samples));
                assert!(!means.is_empty(), "{samples} {power}");
                assert!(means.iter().all(|mean| mean.1 == 7.0), "{means:?}");
            }
        }
    }
}
