//! The pictures of one log, each with the statement that it supports.

use std::io;

use plotters::style::RGBColor;

use crate::gap::outcome::{Evidence, Outcome, Report};
use crate::gap::table::is_extended;
use crate::page::plot::{self, AFTER, BEFORE, COLUMNS, GUIDE, Layer, MEASURED, Mark, Panel};
use crate::page::series::{
    Point, autocorrelation, binned_mean, bulk, difference, envelope, extent, histogram, mean,
    points, rms, thin, worst_stretch,
};
use crate::page::{Figure, escape};
use crate::quantity::{Scale, change};

/// Logs and torque residuals with fewer samples are not drawn.
const SHORTEST: usize = 8;
/// Marks of one cloud of points.
const CLOUD: usize = 700;
/// Replay windows of an excerpt.
const EXCERPT: usize = 6;
/// Stretches of the horizontal axis that a mean residual is taken over.
const BINS: usize = 40;
/// Longest lag of the autocorrelation, in samples of the torque residual.
const LAGS: usize = 100;
/// Bars of a histogram.
const BARS: usize = 48;
/// Share of the torque residuals that a cloud shows: a few spikes would flatten the rest.
const SHOWN: f64 = 0.998;

/// One model on one log.
struct Model<'a> {
    name: &'static str,
    class: &'static str,
    colour: RGBColor,
    position: &'a [f32],
    torque: &'a [f32],
    error: Vec<f32>,
}

/// How the two models that are compared are called.
struct Compared {
    /// The first one in a legend.
    first: &'static str,
    /// What tells it in a sentence.
    lacking: &'static str,
    /// The second one in a legend.
    second: &'static str,
    /// What makes it of the first, at the beginning of a sentence.
    takes: &'static str,
}

impl Compared {
    fn of(outcome: &Outcome) -> Self {
        if !outcome.effects.is_empty() {
            Self {
                first: "before effects",
                lacking: "without the effects",
                second: "with effects",
                takes: "The effects take",
            }
        } else if outcome.unknown.is_some() {
            Self {
                first: "before",
                lacking: "without the learned map",
                second: "with the learned map",
                takes: "The learned map takes",
            }
        } else {
            Self {
                first: "before",
                lacking: "with the declared numbers",
                second: "with other numbers",
                takes: "The other numbers take",
            }
        }
    }
}

/// A number of a model that a picture shows: what it is, its unit, how to get it.
type Number<'a> = (&'a str, &'a str, &'a dyn Fn(&Model) -> f64);

/// A log, the models to compare on it, and the units to do it in.
struct Subject<'a> {
    report: &'a Report,
    log: &'a Evidence,
    models: Vec<Model<'a>>,
}

/// The pictures that a log has data for; none if it is too short.
pub(super) fn of_log(report: &Report, log: &Evidence) -> io::Result<Vec<Figure>> {
    let before = |name| model(name, "before", BEFORE, log, &log.before, &log.torque_before);
    let after = |name| model(name, "after", AFTER, log, &log.after, &log.torque_after);
    let subject = Subject {
        report,
        log,
        models: if is_extended(&report.outcome) {
            let Compared { first, second, .. } = Compared::of(&report.outcome);
            vec![before(first), after(second)]
        } else {
            vec![after("fitted model")]
        },
    };
    let mut figures = Vec::new();
    if points(&log.time, &log.position).len() >= SHORTEST {
        figures.push(subject.whole()?);
        figures.push(subject.excerpt()?);
    }
    if points(&log.torque_time, &log.torque_after).len() >= SHORTEST {
        figures.push(subject.clouds()?);
        figures.extend(subject.correlation()?);
    }
    if !figures.is_empty() {
        figures.push(subject.histograms()?);
    }
    Ok(figures)
}

fn model<'a>(
    name: &'static str,
    class: &'static str,
    colour: RGBColor,
    log: &'a Evidence,
    position: &'a [f32],
    torque: &'a [f32],
) -> Model<'a> {
    Model {
        name,
        class,
        colour,
        position,
        torque,
        error: difference(position, &log.position),
    }
}

impl Subject<'_> {
    fn whole(&self) -> io::Result<Figure> {
        let time = &self.log.time;
        let panels = self.over_time(0, time.len(), 2);
        let largest =
            |model: &Model| extent(wide(&model.error)).map_or(0.0, |(low, high)| high.max(-low));
        let coordinate = &self.report.coordinate;
        // As the table of errors counts them, so that one log has one number.
        let window_s = self.report.outcome.errors.train.after.window_s;
        let predicted = self.log.predicted(window_s);
        Ok(Figure {
            statement: self.statement(&[
                ("the rms position error", coordinate, &|model| {
                    let errors = predicted.iter().filter_map(|&at| model.error.get(at));
                    rms(errors.map(|&error| f64::from(error)))
                }),
                ("its peak", coordinate, &largest),
            ]),
            method: "The whole log. The model is started again and again; the error is model minus measurement. Curves \
                     are thinned to the lowest and the highest sample of each pixel."
                .into(),
            keys: self.keys(true),
            svg: self.draw(panels, "Position and position error over the whole log")?,
        })
    }

    fn excerpt(&self) -> io::Result<Figure> {
        let log = self.log;
        let samples = log.time.len();
        let window = log
            .window_starts
            .windows(2)
            .map(|pair| pair[1].saturating_sub(pair[0]))
            .max()
            .unwrap_or(0);
        let length = match window {
            0 => (samples / 25).clamp(50, 2000),
            window => EXCERPT * window,
        }
        .min(samples);
        let from = worst_stretch(&self.models[0].error, length);
        // From the restart nearest to it, so that whole windows are seen.
        let from = (log.window_starts.iter().copied())
            .min_by_key(|start| start.abs_diff(from))
            .filter(|start| start.abs_diff(from) <= window / 2 && start + length <= samples)
            .unwrap_or(from);
        let to = (from + length).min(samples);
        let mut panels = self.over_time(from, to, 3);
        let restarts = self.restarts(from, to);
        let restarts_text = if restarts.is_empty() {
            ""
        } else {
            " Vertical lines: here the model is started again from what was measured."
        };
        for (_, row) in &mut panels {
            for panel in row {
                panel.layers.insert(
                    0,
                    Layer {
                        mark: Mark::Upright,
                        colour: GUIDE,
                        opacity: 0.35,
                        points: restarts.clone(),
                    },
                );
            }
        }
        Ok(Figure {
            statement: format!(
                "From {:.2} s to {:.2} s the model {} errs most.",
                log.time[from],
                log.time[to - 1],
                self.first(),
            ),
            method: format!("The same curves, sample by sample.{restarts_text}"),
            keys: self.keys(true),
            svg: self.draw(
                panels,
                "Position and position error over an excerpt of the log",
            )?,
        })
    }

    /// What tells the first of the models, in a sentence.
    fn first(&self) -> &'static str {
        match self.models.as_slice() {
            [_] => "as it is fitted",
            _ => Compared::of(&self.report.outcome).lacking,
        }
    }

    /// Position above, position error below, for the samples `from..to`.
    fn over_time(&self, from: usize, to: usize, width: u32) -> Vec<(u32, Vec<Panel>)> {
        let log = self.log;
        let cut = |series: &[f32]| {
            points(
                log.time.get(from..to).unwrap_or_default(),
                series.get(from..to).unwrap_or_default(),
            )
        };
        let position = Scale::of(&self.report.coordinate, wide(&log.position));
        let error = self.error_scale();
        let measured = Layer {
            mark: Mark::Line(width + 2),
            colour: MEASURED,
            opacity: 0.55,
            points: scaled(&envelope(&cut(&log.position), COLUMNS), &position),
        };
        let mut positions = vec![measured];
        let mut errors = Vec::new();
        for model in &self.models {
            positions.extend(self.pieces(model, model.position, from, to, &position, width));
            errors.extend(self.pieces(model, &model.error, from, to, &error, width));
        }
        let time = extent(cut(&log.time).iter().map(|p| p.0)).unwrap_or((0.0, 1.0));
        let panel = |title: &str, x_title: &str, scale: &Scale, layers: Vec<Layer>| {
            let y = extent(layers.iter().flat_map(|layer| &layer.points).map(|p| p.1));
            Panel {
                title: format!("{title}, {}", scale.unit),
                x_title: x_title.into(),
                x: if time.1 > time.0 {
                    time
                } else {
                    Panel::padded(time)
                },
                y: Panel::padded(y.unwrap_or((-1.0, 1.0))),
                layers,
            }
        };
        vec![
            (400, vec![panel("position", "", &position, positions)]),
            (
                400,
                vec![panel("position error", "time, s", &error, errors)],
            ),
        ]
    }

    /// The curve of a model, taken apart where the replay restarts if the excerpt is short enough
    /// to show it.
    fn pieces(
        &self,
        model: &Model,
        series: &[f32],
        from: usize,
        to: usize,
        scale: &Scale,
        width: u32,
    ) -> Vec<Layer> {
        let line = |points: Vec<Point>| Layer {
            mark: Mark::Line(width),
            colour: model.colour,
            opacity: 0.9,
            points,
        };
        let to = to.min(series.len()).min(self.log.time.len());
        let inner = |start: &&usize| (from + 1..to).contains(*start);
        let mut cuts: Vec<usize> = self
            .log
            .window_starts
            .iter()
            .filter(inner)
            .copied()
            .collect();
        if from == 0 && to == self.log.time.len() && to > 2 * COLUMNS {
            cuts.clear();
        }
        cuts.insert(0, from.min(to));
        cuts.push(to);
        cuts.windows(2)
            .map(|ends| {
                let piece = points(&self.log.time[ends[0]..ends[1]], &series[ends[0]..ends[1]]);
                line(scaled(&envelope(&piece, COLUMNS), scale))
            })
            .filter(|layer| !layer.points.is_empty())
            .collect()
    }

    fn restarts(&self, from: usize, to: usize) -> Vec<Point> {
        let starts = self.log.window_starts.iter();
        starts
            .filter(|start| (from..to).contains(*start))
            .filter_map(|&start| self.log.time.get(start))
            .map(|&time| (f64::from(time), 0.0))
            .collect()
    }

    /// Torque residual over velocity and over position, a column for each model.
    fn clouds(&self) -> io::Result<Figure> {
        let log = self.log;
        let torque = self.torque_scale();
        let residuals = || self.models.iter().flat_map(|model| wide(model.torque));
        let range = bulk(&residuals().collect::<Vec<_>>(), SHOWN).unwrap_or((0.0, 0.0));
        let outside = residuals().filter(|r| *r < range.0 || *r > range.1).count();
        let (coordinate, load) = (&self.report.coordinate, &self.report.load_unit);
        let variables = [
            ("velocity", &log.torque_velocity, format!("{coordinate}/s")),
            ("position", &log.torque_position, coordinate.clone()),
        ];
        let mut rows = Vec::new();
        for (name, variable, unit) in &variables {
            let x_scale = Scale::of(unit, wide(variable));
            let Some(x) = extent(wide(variable)) else {
                continue;
            };
            let x = Panel::padded((x.0 * x_scale.factor, x.1 * x_scale.factor));
            let panels = self.models.iter().map(|model| {
                let both = |points: &[Point]| -> Vec<Point> {
                    let inside = |p: &&Point| (range.0..=range.1).contains(&p.1);
                    let place = |p: &Point| (p.0 * x_scale.factor, p.1 * torque.factor);
                    points.iter().filter(inside).map(place).collect()
                };
                let means = both(&mean_over(variable, model));
                Panel {
                    title: format!("torque residual, {}: {}", torque.unit, model.name),
                    x_title: format!("{name}, {}", x_scale.unit),
                    x,
                    y: Panel::padded((range.0 * torque.factor, range.1 * torque.factor)),
                    layers: vec![
                        Layer {
                            mark: Mark::Dot(4),
                            colour: model.colour,
                            opacity: 0.3,
                            points: thin(&both(&points(variable, model.torque)), CLOUD),
                        },
                        Layer {
                            mark: Mark::Line(4),
                            colour: MEASURED,
                            opacity: 1.0,
                            points: means.clone(),
                        },
                        Layer {
                            mark: Mark::Dot(5),
                            colour: MEASURED,
                            opacity: 1.0,
                            points: means,
                        },
                    ],
                }
            });
            rows.push((480, panels.collect()));
        }
        let outside = match outside {
            0 => String::new(),
            _ => format!(" {outside} samples lie beyond the vertical axis."),
        };
        let mut keys = self.keys(false);
        keys.push(("measured", "mean"));
        Ok(Figure {
            statement: self.statement(&[
                (
                    "the range of the mean torque residual over velocity",
                    load,
                    &|model| range_of_mean(&log.torque_velocity, model),
                ),
                ("that over position", load, &|model| {
                    range_of_mean(&log.torque_position, model)
                }),
            ]),
            method: format!(
                "Dots: samples, one for each spot that has any. Line: mean in {BINS} equal \
                 stretches.{outside}"
            ),
            keys,
            svg: self.draw(rows, "Torque residual over velocity and over position")?,
        })
    }

    /// Autocorrelation of the torque residual; none where it is constant.
    fn correlation(&self) -> io::Result<Option<Figure>> {
        let time = &self.log.torque_time;
        let samples = time.len();
        let lags = LAGS.min(samples / 4);
        let bound = 1.96 / (samples as f64).sqrt();
        let spacing = f64::from(time[samples - 1] - time[0]) / (samples - 1) as f64;
        let scale = Scale::of("s", [spacing * lags as f64]);
        let step = if spacing > 0.0 {
            spacing * scale.factor
        } else {
            1.0
        };
        let mut panels = Vec::new();
        let mut outside = Vec::new();
        for model in &self.models {
            let values: Vec<f64> = wide(model.torque).filter(|r| r.is_finite()).collect();
            let r = autocorrelation(&values, lags);
            if r.is_empty() {
                return Ok(None);
            }
            outside.push(r.iter().filter(|r| r.abs() > bound).count());
            let bars = r
                .iter()
                .enumerate()
                .map(|(i, &r)| ((i + 1) as f64 * step, r));
            panels.push(Panel {
                title: format!("autocorrelation of the torque residual: {}", model.name),
                x_title: format!("lag, {}", scale.unit),
                x: (0.0, (lags + 1) as f64 * step),
                y: (-1.0, 1.0),
                layers: vec![
                    Layer {
                        mark: Mark::Bar,
                        colour: model.colour,
                        opacity: 0.85,
                        points: bars.collect(),
                    },
                    Layer {
                        mark: Mark::Across,
                        colour: GUIDE,
                        opacity: 1.0,
                        points: vec![(0.0, bound), (0.0, -bound)],
                    },
                ],
            });
        }
        let counts = match outside.as_slice() {
            [before, after] => format!(
                "{before} of {lags} lags lie outside the 95 % bounds {}, {after} {}",
                self.models[0].name, self.models[1].name
            ),
            _ => format!("{} of {lags} lags lie outside the 95 % bounds", outside[0]),
        };
        Ok(Some(Figure {
            statement: format!(
                "Autocorrelation: {counts}; white noise would leave {:.0}.",
                0.05 * lags as f64
            ),
            method: format!(
                "Direct sum over the filtered and decimated torque residual, mean taken off, \
                 biased estimate. Lines: ±1.96/√N with N = {samples}."
            ),
            keys: self.keys(false),
            svg: self.draw(
                vec![(470, panels)],
                "Autocorrelation of the torque residual",
            )?,
        }))
    }

    /// Distribution of the torque residual and of the position error.
    fn histograms(&self) -> io::Result<Figure> {
        let kinds: [(&str, Scale, Vec<Vec<f64>>); 2] = [
            (
                "position error",
                self.error_scale(),
                self.models
                    .iter()
                    .map(|m| wide(&m.error).collect())
                    .collect(),
            ),
            (
                "torque residual",
                self.torque_scale(),
                self.models
                    .iter()
                    .map(|m| wide(m.torque).collect())
                    .collect(),
            ),
        ];
        let mut panels = Vec::new();
        for (name, scale, series) in kinds {
            let Some(range) = bulk(&series.concat(), SHOWN) else {
                continue;
            };
            let (low, high) = Panel::padded((range.0 * scale.factor, range.1 * scale.factor));
            let width = (high - low) / BARS as f64;
            let mut tallest: f64 = 0.0;
            let mut layers = Vec::new();
            for (model, values) in self.models.iter().zip(&series) {
                let values: Vec<f64> = values.iter().map(|value| value * scale.factor).collect();
                let shares = histogram(&values, (low, high), BARS);
                let edge = |bar: usize| low + bar as f64 * width;
                let mut outline = vec![(low, 0.0)];
                for (bar, share) in shares.iter().enumerate() {
                    tallest = tallest.max(100.0 * share);
                    outline.extend([(edge(bar), 100.0 * share), (edge(bar + 1), 100.0 * share)]);
                }
                outline.push((high, 0.0));
                layers.push(Layer {
                    mark: Mark::Area,
                    colour: model.colour,
                    opacity: 0.2,
                    points: outline.clone(),
                });
                layers.push(Layer {
                    mark: Mark::Line(3),
                    colour: model.colour,
                    opacity: 1.0,
                    points: outline,
                });
            }
            panels.push(Panel {
                title: "share of the samples, %".into(),
                x_title: format!("{name}, {}", scale.unit),
                x: (low, high),
                y: (0.0, 1.08 * tallest.max(1e-9)),
                layers,
            });
        }
        let (coordinate, load) = (&self.report.coordinate, &self.report.load_unit);
        let error: Number = (
            "the standard deviation of the position error",
            coordinate,
            &|model| deviation(&model.error),
        );
        let torque: Number = ("that of the torque residual", load, &|model| {
            deviation(model.torque)
        });
        let has_torque = self.models.iter().any(|model| !model.torque.is_empty());
        Ok(Figure {
            statement: if has_torque {
                self.statement(&[error, torque])
            } else {
                self.statement(&[error])
            },
            method: "Histograms; the outermost bars hold what lies beyond them.".into(),
            keys: self.keys(false),
            svg: self.draw(vec![(470, panels)], "Histograms of the residuals")?,
        })
    }

    fn error_scale(&self) -> Scale {
        let errors = self.models.iter().map(|model| rms(wide(&model.error)));
        Scale::of(&self.report.coordinate, errors)
    }

    fn torque_scale(&self) -> Scale {
        let residuals = self.models.iter().map(|model| rms(wide(model.torque)));
        Scale::of(&self.report.load_unit, residuals)
    }

    /// What the picture shows in numbers: `The effects take the rms position error from 0.291 mm
    /// to 0.052 mm (-82 %), its peak …`.
    fn statement(&self, numbers: &[Number]) -> String {
        let clauses: Vec<String> = numbers
            .iter()
            .map(|(name, unit, number)| {
                let values: Vec<f64> = self.models.iter().map(number).collect();
                let scale = Scale::of(unit, values.iter().copied());
                match values.as_slice() {
                    [before, after] => {
                        let change = change(*before, *after);
                        format!(
                            "{name} from {} to {}{}",
                            scale.quantity(*before),
                            scale.quantity(*after),
                            change.map_or(String::new(), |change| format!(" ({change})"))
                        )
                    }
                    _ => format!("{name} is {}", scale.quantity(values[0])),
                }
            })
            .collect();
        let clauses = clauses.join(", ");
        if self.models.len() == 1 {
            format!("With the fitted model {clauses}.")
        } else {
            let takes = Compared::of(&self.report.outcome).takes;
            format!("{takes} {clauses}.")
        }
    }

    fn keys(&self, with_measured: bool) -> Vec<(&'static str, &'static str)> {
        let measured = with_measured.then_some(("measured", "measured"));
        let models = self.models.iter().map(|model| (model.class, model.name));
        measured.into_iter().chain(models).collect()
    }

    fn draw(&self, rows: Vec<(u32, Vec<Panel>)>, description: &str) -> io::Result<String> {
        plot::draw(&rows, &escape(&format!("{description} {}", self.log.label)))
    }
}

fn wide(series: &[f32]) -> impl Iterator<Item = f64> + '_ {
    series.iter().map(|&value| f64::from(value))
}

fn scaled(points: &[Point], scale: &Scale) -> Vec<Point> {
    points.iter().map(|(x, y)| (*x, y * scale.factor)).collect()
}

/// Mean torque residual of a model in equal stretches of a variable.
fn mean_over(variable: &[f32], model: &Model) -> Vec<Point> {
    let least = (variable.len() / (20 * BINS)).max(3);
    binned_mean(&points(variable, model.torque), BINS, least)
}

/// From the smallest to the largest of these means.
fn range_of_mean(variable: &[f32], model: &Model) -> f64 {
    let means = mean_over(variable, model);
    extent(means.iter().map(|p| p.1)).map_or(0.0, |(low, high)| high - low)
}

fn deviation(series: &[f32]) -> f64 {
    let mean = mean(&wide(series).collect::<Vec<_>>());
    rms(wide(series).map(|value| value - mean))
}
