//! Power spectral density by Welch's method.
//!
//! The signal is cut into segments that overlap by half; each loses its mean, is weighted by a Hann
//! window and transformed, and the squared magnitudes are averaged (P. D. Welch, *The use of fast
//! Fourier transform for the estimation of power spectra*, 1967).

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

/// A one-sided power spectral density.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    /// From one value to the next, Hz.
    pub resolution: f64,
    /// From 0 Hz to half the sample rate, in the square of the signal's unit per Hz.
    pub values: Vec<f64>,
}

/// A peak of a density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Hz.
    pub frequency: f64,
    /// Height, as the density.
    pub density: f64,
}

/// The density of a signal from segments of so many samples. `None` for segments of fewer than two
/// samples or more than there are, for a sample rate that is not above 0, and for samples that are not
/// finite.
///
/// What is left beyond the last whole segment is not used. The sum of the values times the resolution
/// is the mean over the segments of Σ (w (x − mean))² / Σ w². A sine of amplitude a that lies on a
/// value stands in three, which sum up to its power a²/2 over the resolution.
///
/// ```
/// use host_tests::welch::density;
///
/// let sine: Vec<f64> = (0..1000).map(|i| 3.0 * (0.1 * std::f64::consts::TAU * f64::from(i)).sin()).collect();
/// let found = density(&sine, 50.0, 200).unwrap();
/// let power: f64 = found.values.iter().sum::<f64>() * found.resolution;
/// assert!((power - 4.5).abs() < 1e-9);
/// assert!((found.peaks(1)[0].frequency - 5.0).abs() < 1e-9);
/// ```
pub fn density(signal: &[f64], sample_rate: f64, segment: usize) -> Option<Density> {
    let positive = sample_rate > 0.0 && sample_rate.is_finite();
    if !positive || segment < 2 || segment > signal.len() || signal.iter().any(|x| !x.is_finite()) {
        return None;
    }
    // Periodic, as spectral estimates take it: the window's end is the next one's start.
    let window: Vec<f64> = (0..segment)
        .map(|at| 0.5 - 0.5 * (TAU * at as f64 / segment as f64).cos())
        .collect();
    let weight: f64 = window.iter().map(|w| w * w).sum();
    let transform = FftPlanner::new().plan_fft_forward(segment);
    let mut values = vec![0.0; segment / 2 + 1];
    let starts = (0..=signal.len() - segment).step_by(segment - segment / 2);
    let segments = starts.clone().count() as f64;
    for start in starts {
        let cut = &signal[start..start + segment];
        let mean = cut.iter().sum::<f64>() / segment as f64;
        let weighted = cut.iter().zip(&window).map(|(x, w)| w * (x - mean));
        let mut spectrum: Vec<Complex<f64>> = weighted.map(Complex::from).collect();
        transform.process(&mut spectrum);
        for (value, bin) in values.iter_mut().zip(&spectrum) {
            *value += bin.norm_sqr() / (segments * sample_rate * weight);
        }
    }
    // The other side's power, but for 0 Hz and half the sample rate, which have none there.
    let both_sides = 1..(segment - segment / 2);
    for value in &mut values[both_sides] {
        *value *= 2.0;
    }
    Some(Density {
        resolution: sample_rate / segment as f64,
        values,
    })
}

impl Density {
    /// The highest `count` values that are above both neighbours, by frequency, each refined by the
    /// parabola through the logarithms of the three. 0 Hz and half the sample rate are none.
    pub fn peaks(&self, count: usize) -> Vec<Peak> {
        let mut places: Vec<usize> = (1..self.values.len().saturating_sub(1))
            .filter(|&at| {
                self.values[at] > self.values[at - 1] && self.values[at] >= self.values[at + 1]
            })
            .collect();
        places.sort_by(|&a, &b| self.values[b].total_cmp(&self.values[a]));
        places.truncate(count);
        places.sort_unstable();
        places.into_iter().map(|at| self.refined(at)).collect()
    }

    fn refined(&self, at: usize) -> Peak {
        // A neighbour of zero has no logarithm.
        let log = |at: usize| self.values[at].max(f64::MIN_POSITIVE).ln();
        let (before, here, after) = (log(at - 1), log(at), log(at + 1));
        let shift = 0.5 * (before - after) / (before - 2.0 * here + after);
        Peak {
            frequency: (at as f64 + shift) * self.resolution,
            density: (here - 0.25 * (before - after) * shift).exp(),
        }
    }
}
