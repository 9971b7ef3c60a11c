//! Harmonics of the load cell's force (ch. 5.1), on the rig that plays the bench.
//!
//! The disc's run-out makes the brake's torque vary with the turn of its shaft. Welch's method shows it
//! as peaks at multiples of that shaft's frequency, which the log's motor position gives.

use std::f64::consts::TAU;

use rig::pmsm_bench::{
    BacklashLevel, CHAIN_RATIO, FrictionLevel, GEAR_RATIO, Loss, Point, Program,
};
use rig::{Move, Trajectory};

use super::section::{Part, Section};
use crate::cells::{Cells, row};
use crate::failure::Failure;
use crate::page::Figure;
use crate::page::plot::{self, AFTER, BEFORE, GUIDE, Layer, Mark, line};
use crate::page::series::Point as Drawn;
use crate::reproduce::entry;
use crate::welch::{Density, Peak, density};

/// Speed of the slow shaft in the mapping, degrees a second.
pub const SPEED_DEG: f64 = 0.085;

/// Length of the paper's test, s.
pub const PAPER_SECONDS: f64 = 120.0;

/// Length of ours, s.
pub const SECONDS: f64 = 600.0;

/// Rows a second of the log, Hz.
pub const SAMPLE_RATE: f64 = 20.0;

/// Length of a segment of ours, s.
pub const SEGMENT: f64 = 240.0;

/// The longest two segments that overlap by half in the paper's test, s.
pub const HALVES: f64 = 80.0;

/// Peaks that are looked for.
pub const PEAKS: usize = 3;

/// Half the width of a Hann window's main lobe, in values of a density.
const LOBE: usize = 2;

/// The friction levels that are shown; without the brake there is nothing but noise.
const LEVELS: [(&str, FrictionLevel); 2] = [
    ("medium", FrictionLevel::Medium),
    ("high", FrictionLevel::High),
];

/// A log of the load cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    /// N.
    pub force: Vec<f64>,
    /// Turns of the brake's shaft a second, by the motor's encoder, Hz.
    pub shaft_frequency: f64,
}

/// The mapping's slow ramp at a friction level, [`SECONDS`] long.
pub fn record(friction: FrictionLevel) -> Log {
    let speed = SPEED_DEG.to_radians();
    let ramp = Program::slow_ramp();
    let program = Program {
        trajectory: Trajectory::Moves {
            start: 0.0,
            moves: vec![Move {
                // Beyond the log's end, so that nothing of its braking is in it.
                target: 2.0 * SECONDS * speed,
                speed,
                acceleration: speed,
                dwell: 0.0,
            }],
        },
        ..ramp.lasting(SECONDS).sampled_at(SAMPLE_RATE)
    };
    let point = Point {
        friction,
        backlash: BacklashLevel::Low,
    };
    let recording = point.bench(Loss::load_dependent()).run(&program);
    let motor = &recording.motor_position;
    let turned = GEAR_RATIO * (motor[motor.len() - 1] - motor[0]) / TAU / CHAIN_RATIO;
    Log {
        shaft_frequency: turned / ((motor.len() - 1) as f64 / SAMPLE_RATE),
        force: recording.load_cell_force,
    }
}

impl Log {
    /// The density of its first seconds from segments of so many seconds.
    ///
    /// # Errors
    /// Segments longer than that.
    pub fn density(&self, seconds: f64, segment: f64) -> Result<Density, Failure> {
        let rows = ((seconds * SAMPLE_RATE) as usize).min(self.force.len());
        let segment = (segment * SAMPLE_RATE) as usize;
        density(&self.force[..rows], SAMPLE_RATE, segment)
            .ok_or_else(|| Failure::other("the load cell's log is shorter than a segment"))
    }

    /// Mean force, N.
    pub fn mean(&self) -> f64 {
        self.force.iter().sum::<f64>() / self.force.len() as f64
    }
}

/// Amplitude of the sine that makes a peak: its lobe's power is half the square of it.
pub fn amplitude(density: &Density, peak: &Peak) -> f64 {
    let middle = (peak.frequency / density.resolution).round() as usize;
    let last = (middle + LOBE).min(density.values.len() - 1);
    let lobe = &density.values[middle.saturating_sub(LOBE)..=last];
    (2.0 * density.resolution * lobe.iter().sum::<f64>()).sqrt()
}

/// What is shown of them.
pub(super) fn section() -> Result<Section, Failure> {
    let logs = LEVELS.map(|(name, level)| (name, record(level)));
    let mut entries = Vec::new();
    let mut found = vec![row([
        "friction, peak",
        "frequency, Hz",
        "turns of the brake",
        "amplitude, N",
        "of the mean, %",
        "in the rig, %",
    ])];
    let mut worst = 0.0_f64;
    for ((name, log), (_, level)) in logs.iter().zip(LEVELS) {
        let density = log.density(SECONDS, SEGMENT)?;
        let harmonics = rig::pmsm_bench::Brake::with_run_out(level.torque()).harmonics;
        let peaks = density.peaks(PEAKS);
        for (number, (peak, truth)) in peaks.iter().zip(&harmonics).enumerate() {
            let number = number + 1;
            let multiple = peak.frequency / log.shaft_frequency;
            let amplitude = amplitude(&density, peak);
            worst = worst.max((multiple / number as f64 - 1.0).abs());
            entries.push(entry(
                &format!(
                    "load cell, {name} friction, peak {number} over the brake shaft's frequency"
                ),
                Some(number as f64),
                multiple,
                Some(number as f64),
                "",
            ));
            found.push(vec![
                format!("{name}, {number}"),
                format!("{:.5}", peak.frequency),
                format!("{multiple:.3}"),
                format!("{amplitude:.4}"),
                format!("{:.2}", 100.0 * amplitude / log.mean()),
                format!("{:.2}", 100.0 * truth.share),
            ]);
        }
    }
    let turns = PAPER_SECONDS * logs[0].1.shaft_frequency;
    Ok(Section {
        title: "Harmonics of the load cell",
        finding: format!(
            "The first three peaks of the force are multiples of the brake shaft's frequency, as in the \
             paper, to {:.1} %.",
            100.0 * worst
        ),
        parts: vec![
            Part::Table(
                format!("Highest peaks in {SECONDS} s at {SPEED_DEG}°/s, segments of {SEGMENT} s"),
                found,
            ),
            Part::Table(
                "Highest peaks by length of log and segments, in turns of the brake's shaft"
                    .to_owned(),
                cuts(&logs)?,
            ),
            Part::Note(format!(
                "The paper's test of {PAPER_SECONDS} s at {SPEED_DEG}°/s of the slow shaft is {turns:.1} turns \
                 of the brake's. The longest two segments that overlap by half, {HALVES} s, have values \
                 1/{HALVES} Hz apart and peaks {:.1} values apart; the main lobe of a Hann window reaches \
                 two to each side, and so does a Hamming window's. With the printed speed and length three peaks \
                 come out of one segment over the whole test, a tenth of a turn off, but of no average.",
                turns * HALVES / PAPER_SECONDS
            )),
            Part::Figure(figure(&logs)?),
        ],
        entries,
    })
}

/// Peaks of the same logs, cut as in the paper's test.
fn cuts(logs: &[(&str, Log)]) -> Result<Cells, Failure> {
    let mut cells = vec![row(["log, segments", "medium friction", "high friction"])];
    for (seconds, segment) in [
        (SECONDS, SEGMENT),
        (PAPER_SECONDS, PAPER_SECONDS),
        (PAPER_SECONDS, HALVES),
    ] {
        let mut row = vec![format!("{seconds} s, of {segment} s")];
        for (_, log) in logs {
            let peaks = log.density(seconds, segment)?.peaks(PEAKS);
            let multiples = peaks
                .iter()
                .map(|peak| format!("{:.2}", peak.frequency / log.shaft_frequency));
            row.push(multiples.collect::<Vec<_>>().join(", "));
        }
        cells.push(row);
    }
    Ok(cells)
}

/// The paper's Fig. 5.2.
fn figure(logs: &[(&str, Log)]) -> Result<Figure, Failure> {
    let shown = |seconds: f64, segment: f64, title: &str| -> Result<plot::Panel, Failure> {
        let highest = 6.0 * logs[0].1.shaft_frequency;
        let mut layers = vec![Layer {
            mark: Mark::Upright,
            colour: GUIDE,
            opacity: 0.8,
            points: (1..=PEAKS)
                .map(|number| (number as f64 * logs[0].1.shaft_frequency, 0.0))
                .collect(),
        }];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for ((_, log), colour) in logs.iter().zip([AFTER, BEFORE]) {
            let density = log.density(seconds, segment)?;
            // Without 0 Hz: the mean is taken off.
            let values = density.values.iter().enumerate().skip(1);
            let points: Vec<Drawn> = values
                .map(|(at, value)| (at as f64 * density.resolution, value.log10()))
                .take_while(|(frequency, _)| *frequency <= highest)
                .collect();
            for (_, value) in &points {
                (low, high) = (low.min(*value), high.max(*value));
            }
            layers.push(line(colour, 3, 0.9, points));
        }
        Ok(plot::Panel {
            title: title.to_owned(),
            x_title: "frequency, Hz".to_owned(),
            x: (0.0, highest),
            y: plot::Panel::padded((low, high)),
            layers,
        })
    };
    let rows = [(
        440,
        vec![
            shown(SECONDS, SEGMENT, "600 s, segments of 240 s: log10 N²/Hz")?,
            shown(
                PAPER_SECONDS,
                HALVES,
                "120 s, segments of 80 s: log10 N²/Hz",
            )?,
        ],
    )];
    Ok(Figure {
        statement: "The force of the load cell peaks at multiples of the brake shaft's frequency.".to_owned(),
        method: "By Welch's method (the paper's Fig. 5.2); upright, the first three multiples. On the right, \
                 the paper's length of test."
            .to_owned(),
        keys: vec![("after", "medium friction"), ("before", "high friction")],
        svg: plot::draw(&rows, "Power spectral density of the load cell's force")
            .map_err(|error| Failure::system("the plots", &error))?,
    })
}
