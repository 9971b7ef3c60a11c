//! What is shown of the two residuals.

use rig::pmsm_bench::{BacklashLevel, Loss, Point};

use super::{BeforeAfter, Found, Residuals, Traced, run};
use crate::cells::{Cells, row};
use crate::failure::Failure;
use crate::page::Figure;
use crate::page::plot::{self, AFTER, BEFORE, COLUMNS, MEASURED, line, panel};
use crate::page::series::{Point as Mark, envelope};
use crate::reproduce::bench::points::Compared;
use crate::reproduce::bench::section::{Part, Section};
use crate::reproduce::{Entry, entry};

/// First seed of the noise.
const SEED: u64 = 2_001;

/// Sample that is drawn, by the number of Table 5.5: high friction, high backlash.
const DRAWN: usize = 15;

/// Largest share by which the paper's model is short of current, %.
const PAPER_SHORTFALL: f64 = 43.0;

/// How late the paper's model leaves the dead band at most, s.
const PAPER_LATENESS: f64 = 0.25;

/// Losses that could be taken for each other.
const LOSSES: [&str; 2] = ["load_dependent_friction", "torque_saturation"];

/// Half of a window around the instant at which the encoder leaves the dead band, s.
const AROUND: f64 = 1.2;

/// Both losses, each the truth once, at these levels of backlash, the widest among them.
pub(in crate::reproduce::bench) fn section(levels: &[BacklashLevel]) -> Result<Section, Failure> {
    let mut parts = vec![Part::Note(
        "Five logs a level of backlash are traced together: the paper's sine at each level of friction, and at \
         the lower two one of 0.4 Hz, without which inertia and spring are one. Quadrature current in, \
         encoder out, the load cell's torque as `brake`. The machine file knows neither backlash nor \
         loss; the rig shares no code with the tracing. Before: the declared model, its friction refitted. \
         Validation: a sine of 6° at 0.23 Hz. In closed loop: the paper's model with Algorithm 1's backlash, then \
         with what was found, on logs with other noise. The bench's play is narrower than Algorithm 1 reads, for \
         its teeth bend."
            .to_owned(),
    )];
    let mut entries = Vec::new();
    let mut findings = Vec::new();
    for cause in [
        Cause {
            name: "load-dependent friction",
            loss: Loss::load_dependent(),
            id: "load_dependent_friction",
            size: |found| found.load_share,
        },
        Cause {
            name: "torque saturation",
            loss: Loss::torque_saturation(),
            id: "torque_saturation",
            size: |found| found.saturation,
        },
    ] {
        let name = cause.name;
        let residuals = run(cause.loss, levels, SEED)?;
        let points = &residuals.points;
        entries.extend(cause.entries(&residuals.traced));
        findings.push(format!(
            "With {name} as its loss, the model's current is at most {:.0} % off after the tracing ({:.0} % \
             before), and it leaves the dead band within {:.0} ms of the bench ({:.0} ms)",
            worst(points, |it| &it.after, Compared::shortfall_percent),
            worst(points, |it| &it.before, Compared::shortfall_percent),
            worst(points, |it| &it.after, lateness),
            worst(points, |it| &it.before, lateness),
        ));
        for (stage, paper, of) in [
            ("before", true, before as fn(&BeforeAfter) -> &Compared),
            ("after", false, after),
        ] {
            for (what, value, unit, scale, paper_value) in [
                (
                    "position NRMSE",
                    Compared::position_percent as fn(&Compared) -> f64,
                    "%",
                    1.0,
                    1.5,
                ),
                (
                    "error of the current in motion",
                    Compared::shortfall_percent,
                    "%",
                    1.0,
                    PAPER_SHORTFALL,
                ),
                (
                    "time of leaving the dead band off by",
                    lateness,
                    "s",
                    1e-3,
                    PAPER_LATENESS,
                ),
            ] {
                entries.push(entry(
                    &format!("{name}, {stage}: {what}, largest"),
                    paper.then_some(paper_value),
                    scale * worst(points, of, value),
                    None,
                    unit,
                ));
            }
        }
        parts.push(Part::Table(
            format!("Traced, a bench with {name}"),
            traced_cells(&residuals.traced),
        ));
        parts.push(Part::Table(
            format!("In closed loop, before → after, a bench with {name}"),
            point_cells(points),
        ));
        parts.push(Part::Figure(figure(name, &residuals)?));
    }
    Ok(Section {
        title: "The two residuals that the paper left open",
        finding: format!("{}.", findings.join(". ")),
        parts,
        entries,
    })
}

/// What a bench loses its torque to, and what has to be found of that.
struct Cause {
    name: &'static str,
    loss: Loss,
    id: &'static str,
    size: fn(&Found) -> f64,
}

impl Cause {
    /// What `size` of the bench is.
    fn truth(&self) -> f64 {
        match self.loss {
            Loss::None => 0.0,
            // With 1 N·m that the brake takes go so many N·m: a share of what the motor gives.
            Loss::LoadDependentLoss { coefficient } => coefficient / (1.0 + coefficient),
            Loss::TorqueSaturation { current } => 1.0 / current,
        }
    }

    /// At how many levels it is named, and its size where that is farthest off.
    fn entries(&self, traced: &[Traced]) -> [Entry; 2] {
        let is_right = |level: &&Traced| {
            let effects = &level.outcome.effects;
            let is_named = |id: &str| effects.iter().any(|found| found.id == id);
            is_named("backlash") && LOSSES.iter().all(|id| is_named(id) == (*id == self.id))
        };
        let right = traced.iter().filter(is_right).count();
        let truth = self.truth();
        let sizes = traced.iter().map(|level| (self.size)(&level.found));
        let off = |size: &f64| (size - truth).abs();
        let farthest = sizes.max_by(|one, other| off(one).total_cmp(&off(other)));
        let (name, levels) = (self.name, traced.len());
        [
            entry(
                &format!(
                    "{name}: levels of backlash at which it is named beside the backlash, and no other loss"
                ),
                None,
                right as f64,
                Some(levels as f64),
                "1",
            ),
            entry(
                &format!("{name}: its size as it was found, where that is farthest off"),
                None,
                farthest.unwrap_or(0.0),
                Some(truth),
                "1",
            ),
        ]
    }
}

fn before(point: &BeforeAfter) -> &Compared {
    &point.before
}

fn after(point: &BeforeAfter) -> &Compared {
    &point.after
}

fn worst(
    points: &[BeforeAfter],
    of: fn(&BeforeAfter) -> &Compared,
    value: fn(&Compared) -> f64,
) -> f64 {
    let values = points.iter().map(|point| value(of(point)).abs());
    values.fold(0.0, f64::max)
}

fn lateness(compared: &Compared) -> f64 {
    1e3 * compared.lateness
}

fn traced_cells(traced: &[Traced]) -> Cells {
    let mut cells = vec![row([
        "backlash read, °",
        "found",
        "play, °",
        "position, validation, mrad",
        "torque residual, validation, %",
    ])];
    for it in traced {
        let named: Vec<String> = it
            .outcome
            .effects
            .iter()
            .map(|found| {
                let others = match found.equivalent.len() {
                    0 => String::new(),
                    _ => format!(" (or {})", found.equivalent.join(", ")),
                };
                found.id.clone() + &others
            })
            .collect();
        let errors = it.outcome.errors.validate.as_ref();
        let pair = |value: fn(&crate::gap::outcome::ErrorSet) -> f64| {
            errors.map_or(String::new(), |errors| {
                format!("{:.2} → {:.2}", value(&errors.before), value(&errors.after))
            })
        };
        let found = if named.is_empty() {
            it.outcome.verdict.name().to_owned()
        } else {
            named.join(" + ")
        };
        cells.push(vec![
            format!("{:.3}", it.backlash.reading().to_degrees()),
            found,
            it.found
                .play
                .map_or("–".to_owned(), |play| format!("{:.3}", play.to_degrees())),
            pair(|errors| 1e3 * errors.position_rms),
            pair(|errors| 100.0 * errors.torque_rel),
        ]);
    }
    cells
}

fn point_cells(points: &[BeforeAfter]) -> Cells {
    let mut cells = vec![row([
        "sample",
        "position, %",
        "velocity, %",
        "i_q, %",
        "i_q short, %",
        "late, ms",
    ])];
    for point in points {
        let pair = |value: fn(&Compared) -> f64, decimals: usize| {
            let (before, after) = (value(&point.before), value(&point.after));
            format!("{before:.decimals$} → {after:.decimals$}")
        };
        cells.push(vec![
            sample(point).to_string(),
            pair(Compared::position_percent, 3),
            pair(Compared::velocity_percent, 2),
            pair(Compared::current_percent, 1),
            pair(Compared::shortfall_percent, 1),
            pair(lateness, 0),
        ]);
    }
    cells
}

/// Its number in Table 5.5.
fn sample(point: &BeforeAfter) -> usize {
    let place = Point::ALL.iter().position(|it| *it == point.before.point);
    place.map_or(0, |place| place + 1)
}

fn figure(name: &str, residuals: &Residuals) -> Result<Figure, Failure> {
    let drawn = residuals.points.iter().find(|it| sample(it) == DRAWN);
    let point = drawn.ok_or_else(|| Failure::Other(format!("sample {DRAWN} was not run")))?;
    let log = &point.before.log;
    // A quarter of a period before its end the sine turns; the dead band lies behind that.
    let period = 1.0 / point.before.given.command.frequency;
    let turn = 0.25 * period + 0.3;
    let shown = |values: &[f64], scale: f64, (from, to): (f64, f64)| -> Vec<Mark> {
        let rows = log.time.iter().zip(values);
        let rows = rows.filter(|(time, _)| (from..=to).contains(*time));
        let points: Vec<Mark> = rows.map(|(time, value)| (*time, scale * value)).collect();
        envelope(&points, COLUMNS)
    };
    let three =
        |title: &str, measured: &[f64], models: [&[f64]; 2], scale: f64, span: (f64, f64)| {
            panel(
                title,
                "time, s",
                vec![
                    line(MEASURED, 5, 0.7, shown(measured, scale, span)),
                    line(BEFORE, 3, 1.0, shown(models[0], scale, span)),
                    line(AFTER, 3, 1.0, shown(models[1], scale, span)),
                ],
            )
        };
    let rows = [
        (
            430,
            vec![three(
                "encoder behind a reversal, °",
                &log.encoder_position,
                [&point.before.model.position, &point.after.model.position],
                1.0_f64.to_degrees(),
                (turn - 0.5 * AROUND, turn + AROUND),
            )],
        ),
        (
            430,
            vec![three(
                "quadrature current over a period, A rms",
                &log.current_q,
                [&point.before.model.current, &point.after.model.current],
                1.0,
                (0.0, period),
            )],
        ),
    ];
    Ok(Figure {
        statement: format!(
            "Sample {DRAWN}, a bench with {name}: what was found closes both residuals."
        ),
        method: "An unseen log, the paper's model, and the model with what the tracing found."
            .to_owned(),
        keys: vec![
            ("measured", "bench"),
            ("before", "paper's model"),
            ("after", "after the tracing"),
        ],
        svg: plot::draw(&rows, "encoder and current, before and after")
            .map_err(|error| Failure::system("the plots", &error))?,
    })
}
