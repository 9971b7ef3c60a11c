//! What the paper makes of a log before it simulates it (ch. 4.2.2 and 5.3): the command from its
//! Fourier transform and the encoder, the backlash by Algorithm 1, the friction from the load cell.

use std::f64::consts::{FRAC_PI_2, TAU};

use model_core::plant::bench::brake;
use rig::pmsm_bench::Recording;
use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::play::algorithm_1;
use crate::failure::Failure;

/// N for one gram-force, the unit of the paper's load cell.
const GRAM_FORCE: f64 = 1e-3 * super::friction_map::GRAVITY;

/// Speed of the motor above which it counts as moving, rad/s: the load cell reads friction then, and
/// at rest what the motor holds against it.
pub const MOVING: f64 = 1.0;

/// Rows around one whose mean its friction is, s either way: of the load cell's noise a small part is
/// left, of its swings with the brake's shaft, the third harmonic of 1.4 Hz among them, most.
const SMOOTHING: f64 = 0.05;

/// A sine about zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// In the unit of the signal.
    pub amplitude: f64,
    /// Hz.
    pub frequency: f64,
    /// At the first row, rad.
    pub phase: f64,
}

impl Sine {
    /// Its value so many seconds after the first row.
    pub fn at(&self, time: f64) -> f64 {
        self.amplitude * (TAU * self.frequency * time + self.phase).sin()
    }
}

/// Frequency, Hz, and phase, rad, of the strongest sine in a signal. `None` for a signal without one.
///
/// The signal is weighted by a Hann window, whose main lobe the two largest values of the transform
/// place: with the ratio r of the larger of the neighbours to the peak the frequency lies
/// (2 r − 1)/(r + 1) of a value beside it (exactly, for a sine of many periods).
///
/// ```
/// use host_tests::reproduce::bench::reconstruction::frequency_and_phase;
/// let signal: Vec<f64> = (0..1000).map(|row| (0.37 * f64::from(row) / 20.0 + 0.4).sin()).collect();
/// let (frequency, phase) = frequency_and_phase(&signal, 20.0).unwrap();
/// assert!((frequency - 0.37 / std::f64::consts::TAU).abs() < 1e-4);
/// assert!((phase - 0.4).abs() < 0.01);
/// ```
pub fn frequency_and_phase(signal: &[f64], sample_rate: f64) -> Option<(f64, f64)> {
    let count = signal.len();
    let weight = |row: usize| 0.5 - 0.5 * (TAU * row as f64 / count as f64).cos();
    let weighted = || signal.iter().enumerate().map(|(row, x)| weight(row) * x);
    let mut values: Vec<Complex<f64>> = weighted().map(|x| Complex::new(x, 0.0)).collect();
    FftPlanner::new()
        .plan_fft_forward(count)
        .process(&mut values);
    let sizes: Vec<f64> = values[..count / 2].iter().map(|x| x.norm()).collect();
    // Not the mean, nor what the window makes of it.
    let (peak, &size) = sizes
        .iter()
        .enumerate()
        .skip(2)
        .max_by(|a, b| a.1.total_cmp(b.1))?;
    if size <= 0.0 {
        return None;
    }
    let before = sizes[peak - 1];
    let after = sizes.get(peak + 1).copied().unwrap_or(0.0);
    let (neighbour, side) = if after > before {
        (after, 1.0)
    } else {
        (before, -1.0)
    };
    let ratio = neighbour / size;
    let place = peak as f64 + side * (2.0 * ratio - 1.0) / (ratio + 1.0);
    let frequency = place * sample_rate / count as f64;
    let at_frequency: Complex<f64> = weighted()
        .enumerate()
        .map(|(row, x)| Complex::from_polar(x, -TAU * place * row as f64 / count as f64))
        .sum();
    Some((frequency, at_frequency.arg() + FRAC_PI_2))
}

/// What a simulation is given.
#[derive(Debug, Clone, PartialEq)]
pub struct Reconstruction {
    /// Command, rad of the slow shaft.
    pub command: Sine,
    /// Algorithm 1's backlash, rad of the slow shaft: half the play.
    pub backlash: f64,
    /// Brake's friction at the motor's shaft at each row, N·m.
    pub friction: Vec<f64>,
    /// Its mean in motion, N·m.
    pub mean_friction: f64,
}

impl Reconstruction {
    /// From a log.
    ///
    /// # Errors
    /// A log without a command, a position or a motion.
    pub fn of(log: &Recording, sample_rate: f64) -> Result<Self, Failure> {
        let missing = |what: &str| Failure::other(format!("the bench's log has no {what}"));
        let (frequency, phase) =
            frequency_and_phase(&log.command, sample_rate).ok_or_else(|| missing("command"))?;
        let backlash = algorithm_1(&log.residual()).ok_or_else(|| missing("position"))?;
        let around = (SMOOTHING * sample_rate).round() as usize;
        let (friction, mean_friction) = friction(&log.motor_velocity, &log.load_cell_force, around)
            .ok_or_else(|| missing("motion"))?;
        Ok(Self {
            command: Sine {
                amplitude: 0.5 * super::errors::range(&log.encoder_position),
                frequency,
                phase,
            },
            backlash,
            friction,
            mean_friction,
        })
    }
}

/// Friction from the load cell, N·m at each row, and its mean in motion: in motion the mean of what
/// opposes it in the rows around, at rest what it was last.
fn friction(velocity: &[f64], force: &[f64], around: usize) -> Option<(Vec<f64>, f64)> {
    let opposing = |(velocity, force): (&f64, &f64)| {
        let torque = f64::from(brake::friction((force / GRAM_FORCE) as f32));
        (velocity.abs() > MOVING).then(|| torque * velocity.signum())
    };
    let moving: Vec<Option<f64>> = velocity.iter().zip(force).map(opposing).collect();
    let mean = |rows: &[Option<f64>]| {
        let (sum, count) = rows
            .iter()
            .flatten()
            .fold((0.0, 0.0), |(sum, count), level| (sum + level, count + 1.0));
        (count > 0.0).then(|| sum / count)
    };
    let overall = mean(&moving)?;
    let mut last = None;
    let levels: Vec<Option<f64>> = (0..moving.len())
        .map(|row| {
            if moving[row].is_some() {
                let rows = row.saturating_sub(around)..moving.len().min(row + around + 1);
                last = mean(&moving[rows]);
            }
            last
        })
        .collect();
    // A brake cannot push: what noise takes below zero is none.
    let levels = levels
        .into_iter()
        .map(|level| level.unwrap_or(overall).max(0.0));
    Some((levels.collect(), overall))
}
