//! The section on the stick-slip.

use super::simulated::{self, Run, Scheme};
use super::{Cycle, Example, closed_form};
use crate::cells::{Cells, row};
use crate::failure::Failure;
use crate::page::Figure;
use crate::page::plot::{
    self, AFTER, BEFORE, COLUMNS, GUIDE, Layer, MEASURED, Mark, OTHER, line, panel,
};
use crate::page::series::{Point, envelope};
use crate::reproduce::bench::section::{Part, Section};
use crate::reproduce::entry;

/// Belt speeds, m/s.
const SPEEDS: [f64; 8] = [0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.5, 2.0];

/// That of the entries and of the motion that is shown.
const SHOWN: f64 = 0.2;

/// Half the width of Karnopp's band, m/s: a thousandth of the order of the speeds.
const BAND: f64 = 1e-3;

/// Step of every scheme, s.
const STEP: f64 = 1e-4;

/// The schemes and their names.
const SCHEMES: [(&str, Scheme); 3] = [
    ("modes and events", Scheme::Exact),
    ("Karnopp", Scheme::Karnopp(BAND)),
    ("Borello", Scheme::Borello),
];

/// Keys of the schemes.
const KEYS: [(&str, &str); 4] = [
    ("measured", "closed form"),
    ("after", "modes and events"),
    ("before", "Karnopp"),
    ("other", "Borello"),
];

/// A belt speed: the closed form and every scheme.
struct Row {
    speed: f64,
    truth: Cycle,
    found: Vec<Cycle>,
}

fn cycle(run: &Run) -> Result<Cycle, Failure> {
    run.cycle()
        .ok_or_else(|| Failure::other("the mass on the belt did not slip twice"))
}

fn rows(example: &Example) -> Result<Vec<Row>, Failure> {
    let at = |&speed: &f64| -> Result<Row, Failure> {
        let run =
            |(_, scheme): &(&str, Scheme)| cycle(&simulated::run(example, *scheme, speed, STEP)?);
        Ok(Row {
            speed,
            truth: closed_form::cycle(example, speed),
            found: SCHEMES.iter().map(run).collect::<Result<_, Failure>>()?,
        })
    };
    SPEEDS.iter().map(at).collect()
}

/// What is shown of it.
pub(in crate::reproduce::bench) fn section() -> Result<Section, Failure> {
    let example = Example::PAPER;
    let rows = rows(&example)?;
    let shown = rows
        .iter()
        .find(|row| row.speed == SHOWN)
        .ok_or_else(|| Failure::other("the belt speed that is shown was not run"))?;
    let fast = closed_form::cycle(&example, 1.0).amplitude;
    let deflection = example.excess_deflection();
    let notes = [
        "What the paper prints exactly: T_stick = 2(μs − μd)N/(kv) and its equation for T_slip, sign \
         included, hold at every belt speed. The latter need not be iterated: besides T = 0 it \
         has the root T_slip = (2/ω)(π − arctan((μs − μd)Nω/(kv))), from π/ω to 2π/ω. Without \
         damping the stick becomes short as 1/v, but never ends."
            .to_owned(),
        format!(
            "What differs: the printed x(t) lacks (v/ω) sin ωt, without which it does not meet the initial \
             condition ẋ = v that is printed above it; its time counts from the breakaway, and it swings \
             about μd N/k, not about x(t₁). Its amplitude is {deflection} m at every speed; it is {:.4} m at \
             {SHOWN} m/s and {fast:.4} m at 1 m/s.",
            shown.truth.amplitude
        ),
        format!(
            "Every scheme with steps of 0.1 ms. Times are read to a step, and the ramp is held over a step. \
             Karnopp's band of ±{BAND} m/s adds the time to leave it, √(2M·band/(kv)), and as much of the \
             belt's way to the amplitude; the other two schemes have no such term."
        ),
    ];
    let mut entries = Vec::new();
    for (number, (name, _)) in SCHEMES.iter().enumerate() {
        let (found, truth) = (shown.found[number], shown.truth);
        let values = [
            (
                "amplitude",
                Some(deflection),
                found.amplitude,
                truth.amplitude,
                "m",
            ),
            (
                "stick time",
                Some(truth.stick),
                found.stick,
                truth.stick,
                "s",
            ),
            ("slip time", Some(truth.slip), found.slip, truth.slip, "s"),
        ];
        for (what, paper, found, truth, unit) in values {
            let what = format!("stick-slip at {SHOWN} m/s, {name}, {what}");
            entries.push(entry(&what, paper, found, Some(truth), unit));
        }
    }
    let largest = |number: usize, of: fn(&Cycle) -> f64| {
        let errors = rows
            .iter()
            .map(|row| of(&row.found[number]) - of(&row.truth));
        errors.fold(0.0_f64, |largest, error| largest.max(error.abs()))
    };
    let mut parts = vec![Part::Table(
        "Stick-slip: closed form, and what each scheme adds to it".to_owned(),
        cells(&rows),
    )];
    parts.extend(notes.map(Part::Note));
    parts.push(Part::Figure(times(&rows, &example)?));
    parts.push(Part::Figure(motion(&example)?));
    Ok(Section {
        title: "Stick-slip",
        finding: format!(
            "A mass of 1 kg, 25 N/m, μs = 1, μd = 0.5: against the closed form the amplitude is off by up to \
             {:.2} mm and the times by {:.1} ms with modes and events, by {:.2} mm and {:.0} ms with \
             Karnopp's band, by {:.2} mm and {:.1} ms with Borello's crossing.",
            1e3 * largest(0, |it| it.amplitude),
            1e3 * largest(0, |it| it.stick).max(largest(0, |it| it.slip)),
            1e3 * largest(1, |it| it.amplitude),
            1e3 * largest(1, |it| it.stick).max(largest(1, |it| it.slip)),
            1e3 * largest(2, |it| it.amplitude),
            1e3 * largest(2, |it| it.stick).max(largest(2, |it| it.slip)),
        ),
        parts,
        entries,
    })
}

fn cells(rows: &[Row]) -> Cells {
    let mut heads = row(["belt, m/s", "amplitude, m", "T_stick, s", "T_slip, s"]);
    heads.extend(SCHEMES.map(|(name, _)| format!("{name}: mm, ms, ms")));
    let mut cells = vec![heads];
    cells.extend(rows.iter().map(|row| {
        let truth = row.truth;
        let mut cells = vec![
            row.speed.to_string(),
            format!("{:.4}", truth.amplitude),
            format!("{:.4}", truth.stick),
            format!("{:.4}", truth.slip),
        ];
        cells.extend(row.found.iter().map(|found| {
            format!(
                "{:+.2}, {:+.2}, {:+.2}",
                1e3 * (found.amplitude - truth.amplitude),
                1e3 * (found.stick - truth.stick),
                1e3 * (found.slip - truth.slip)
            )
        }));
        cells
    }));
    cells
}

/// The paper's Fig. 1.8.
fn times(rows: &[Row], example: &Example) -> Result<Figure, Failure> {
    let curve = |of: fn(&Cycle) -> f64| -> Vec<Point> {
        let steps = (0..=380).map(|step| SPEEDS[0] + f64::from(step) / 200.0);
        let points = steps.map(|speed| (speed, of(&closed_form::cycle(example, speed))));
        points.collect()
    };
    let shown = |title: &str, of: fn(&Cycle) -> f64| {
        let mut layers = vec![line(MEASURED, 4, 0.6, curve(of))];
        for (number, (colour, radius)) in [(AFTER, 11), (BEFORE, 8), (OTHER, 4)]
            .into_iter()
            .enumerate()
        {
            layers.push(Layer {
                mark: Mark::Dot(radius),
                colour,
                opacity: 0.9,
                points: rows
                    .iter()
                    .map(|row| (row.speed, of(&row.found[number])))
                    .collect(),
            });
        }
        panel(title, "belt speed, m/s", layers)
    };
    let off = |title: &str, of: fn(&Cycle) -> f64| {
        let ends = vec![(SPEEDS[0], 0.0), (SPEEDS[SPEEDS.len() - 1], 0.0)];
        let mut layers = vec![line(GUIDE, 2, 0.8, ends)];
        for (number, colour) in [AFTER, BEFORE, OTHER].into_iter().enumerate() {
            let error = |row: &Row| 1e3 * (of(&row.found[number]) - of(&row.truth));
            layers.push(Layer {
                mark: Mark::Dot(6),
                colour,
                opacity: 0.9,
                points: rows.iter().map(|row| (row.speed, error(row))).collect(),
            });
        }
        panel(title, "belt speed, m/s", layers)
    };
    let drawn = [
        (
            420,
            vec![
                shown("T_stick, s", |it| it.stick),
                shown("T_slip, s", |it| it.slip),
            ],
        ),
        (
            360,
            vec![
                off("T_stick less closed form, ms", |it| it.stick),
                off("T_slip less closed form, ms", |it| it.slip),
            ],
        ),
    ];
    Ok(Figure {
        statement: "How long the mass sticks and slips, over the speed of the belt.".to_owned(),
        method: format!(
            "The paper's Fig. 1.8; each dot the mean of {} periods.",
            simulated::CYCLES
        ),
        keys: KEYS.to_vec(),
        svg: plot::draw(&drawn, "Stick time and slip time over the belt speed")
            .map_err(|error| Failure::system("the plots", &error))?,
    })
}

/// The paper's Fig. 1.7.
fn motion(example: &Example) -> Result<Figure, Failure> {
    let first = example.first_breakaway(SHOWN);
    let cycle = closed_form::cycle(example, SHOWN);
    let period = cycle.stick + cycle.slip;
    let run = simulated::run(example, SCHEMES[0].1, SHOWN, STEP)?;
    let rows = run.position.iter().enumerate();
    let simulated: Vec<Point> = rows
        .map(|(row, &position)| ((row + 1) as f64 * STEP, position))
        .collect();
    let end = run.position.len() as f64 * STEP;
    let truth = |time: f64| {
        if time < first {
            SHOWN * time
        } else {
            closed_form::position(example, SHOWN, (time - first) % period)
        }
    };
    let times =
        |from: f64, to: f64| (0..=900).map(move |at| from + (to - from) * f64::from(at) / 900.0);
    let exact: Vec<Point> = times(0.0, end).map(|time| (time, truth(time))).collect();
    let printed: Vec<Point> = times(first, first + cycle.slip)
        .map(|time| (time, closed_form::printed_slip(example, time - first)))
        .collect();
    let drawn = [(
        380,
        vec![panel(
            "position, m",
            "time, s",
            vec![
                line(MEASURED, 6, 0.5, exact),
                line(AFTER, 2, 0.9, envelope(&simulated, COLUMNS)),
                line(BEFORE, 3, 0.9, printed),
            ],
        )],
    )];
    Ok(Figure {
        statement: "The mass goes with the belt, and slips back.".to_owned(),
        method: format!("At {SHOWN} m/s (the paper's Fig. 1.7)."),
        keys: vec![
            ("measured", "closed form"),
            ("after", "modes and events"),
            ("before", "the first slip as printed"),
        ],
        svg: plot::draw(&drawn, "Position of the mass over time")
            .map_err(|error| Failure::system("the plots", &error))?,
    })
}
