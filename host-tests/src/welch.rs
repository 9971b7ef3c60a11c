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

#[cfg(test)]
mod tests {
    use super::*;
    use rig::Random;

    /// No closed form of anything: two sines, of which one is swept over the other.
    fn signal() -> Vec<f64> {
        (0..1000)
            .map(|n| {
                let n = f64::from(n);
                (0.3 * n).sin() + 0.5 * (0.011 * n * n % 7.0).cos() + 0.25
            })
            .collect()
    }

    /// `scipy.signal.welch(x, fs=100.0, window="hann", nperseg=n, noverlap=n // 2)` of
    /// `x = sin(0.3 * n) + 0.5 * cos(0.011 * n * n % 7.0) + 0.25`, `n = arange(1000)`; SciPy 1.17.1.
    #[test]
    fn the_density_is_scipys() {
        let even = [
            (0, 0.000586364491695749),
            (1, 0.0011875817662643146),
            (5, 0.07656938192192021),
            (6, 0.4074962863269161),
            (7, 0.13823154076690855),
            (30, 0.0032276290064193218),
            (64, 0.0007143183959922176),
        ];
        let odd = [
            (0, 0.0004001666560444387),
            (1, 0.001175469924409649),
            (5, 0.11253336243415919),
            (6, 0.40328566785903536),
            (7, 0.08835553003222414),
            (30, 0.003306243399222571),
            (62, 0.001506729755577622),
        ];
        for (segment, expected) in [(128, even), (125, odd)] {
            let found = density(&signal(), 100.0, segment).unwrap();
            assert_eq!(found.values.len(), segment / 2 + 1);
            assert_eq!(found.resolution, 100.0 / segment as f64);
            for (at, value) in expected {
                let off = found.values[at] / value - 1.0;
                assert!(off.abs() < 1e-10, "{segment}, {at}: {off}");
            }
        }
    }

    /// Parseval: the density's integral is the windowed signal's power, segment by segment.
    #[test]
    fn no_power_is_lost() {
        let signal = signal();
        for segment in [250, 251] {
            let found = density(&signal, 8.0, segment).unwrap();
            let window: Vec<f64> = (0..segment)
                .map(|at| {
                    (std::f64::consts::PI * at as f64 / segment as f64)
                        .sin()
                        .powi(2)
                })
                .collect();
            let weight: f64 = window.iter().map(|w| w * w).sum();
            let hop = segment - segment / 2;
            let mut powers = Vec::new();
            let mut start = 0;
            while start + segment <= signal.len() {
                let cut = &signal[start..start + segment];
                let mean = cut.iter().sum::<f64>() / segment as f64;
                let squares = cut
                    .iter()
                    .zip(&window)
                    .map(|(x, w)| (w * (x - mean)).powi(2));
                powers.push(squares.sum::<f64>() / weight);
                start += hop;
            }
            let expected = powers.iter().sum::<f64>() / powers.len() as f64;
            let power = found.resolution * found.values.iter().sum::<f64>();
            assert!((power / expected - 1.0).abs() < 1e-12, "{power} {expected}");
        }
    }

    /// On a value a Hann window gives a sine's power to three values as 1 : 4 : 1; half-way between
    /// two, these are the highest and equal.
    #[test]
    fn a_sine_stands_where_and_as_high_as_it_is() {
        let sine = |cycles: f64| -> Density {
            let rows = (0..4096).map(|n| 3.0 * (TAU * cycles * f64::from(n) / 512.0).sin());
            density(&rows.collect::<Vec<_>>(), 512.0, 512).unwrap()
        };
        let on = sine(40.0);
        for (at, share) in [(39, 1.0 / 6.0), (40, 4.0 / 6.0), (41, 1.0 / 6.0)] {
            assert!((on.values[at] - 4.5 * share).abs() < 1e-9, "{at}");
        }
        assert!(on.values[50] < 1e-20);
        let [peak] = on.peaks(1)[..] else {
            panic!("one peak")
        };
        assert!((peak.frequency - 40.0).abs() < 1e-9 && (peak.density - 3.0).abs() < 1e-9);
        // A Hann window's lobe is no parabola: up to 0.016 of a value off, and right by symmetry here.
        let between = sine(40.5);
        let frequency = between.peaks(1)[0].frequency;
        assert!((frequency - 40.5).abs() < 1e-3, "{frequency}");
        assert!((between.values[40] / between.values[41] - 1.0).abs() < 1e-3);
        let off = sine(40.25).peaks(1)[0].frequency - 40.25;
        assert!(off.abs() < 0.02, "{off}");
    }

    /// White noise of variance σ² has the density 2 σ²/f on one side.
    #[test]
    fn white_noise_is_flat() {
        let mut random = Random::new(7);
        let noise: Vec<f64> = (0..100_000).map(|_| 0.2 * random.normal()).collect();
        let found = density(&noise, 1000.0, 128).unwrap();
        let expected = 2.0 * 0.04 / 1000.0;
        // 1561 segments that half overlap: a value scatters by √((1 + 2/36)/1561), 2.6 %. Next to 0 Hz
        // the mean took its share.
        let inner = &found.values[2..64];
        for value in inner {
            assert!((value / expected - 1.0).abs() < 5.0 * 0.026, "{value}");
        }
        let mean = inner.iter().sum::<f64>() / inner.len() as f64;
        assert!((mean / expected - 1.0).abs() < 5.0 * 0.0045, "{mean}");
    }

    #[test]
    fn peaks_come_by_frequency_and_never_from_the_ends() {
        let found = Density {
            resolution: 2.0,
            values: vec![9.0, 1.0, 4.0, 1.0, 8.0, 1.0, 2.0, 1.0, 99.0],
        };
        let frequencies = |count| -> Vec<f64> {
            let peaks = found.peaks(count);
            peaks.iter().map(|peak| peak.frequency).collect()
        };
        assert_eq!(frequencies(2), [4.0, 8.0]);
        assert_eq!(frequencies(9), [4.0, 8.0, 12.0]);
        let empty = Density {
            resolution: 1.0,
            values: Vec::new(),
        };
        assert!(empty.peaks(3).is_empty());
    }

    #[test]
    fn what_has_no_density_is_refused() {
        let signal = [1.0, 2.0, 3.0];
        assert!(density(&signal, 1.0, 3).is_some());
        assert!(density(&signal, 1.0, 4).is_none());
        assert!(density(&signal, 1.0, 1).is_none());
        assert!(density(&signal, 0.0, 2).is_none());
        assert!(density(&signal, f64::INFINITY, 2).is_none());
        assert!(density(&[1.0, f64::NAN], 1.0, 2).is_none());
        assert!(density(&[], 1.0, 2).is_none());
    }
}
