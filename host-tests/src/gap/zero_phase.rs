//! Zero-phase low-pass filters for the torque balance.
//!
//! The designs are SciPy's, as printed by `scipy.signal.butter(4, 0.2, output='sos')` and
//! `scipy.signal.cheby1(8, 0.05, 0.08, output='sos')`; they are relative to the sampling rate, so
//! that no other is needed.

/// A second-order section: b0, b1, b2, 1, a1, a2.
type Section = [f64; 6];

/// Butterworth of 4th order with its corner at a tenth of the sampling rate.
pub const BUTTERWORTH: [Section; 2] = [
    [
        0.004824343357716228,
        0.009648686715432456,
        0.004824343357716228,
        1.0,
        -1.0485995763626117,
        0.2961403575616696,
    ],
    [1.0, 2.0, 1.0, 1.0, -1.3209134308194264, 0.6327387928852766],
];

/// Chebyshev I of 8th order, 0.05 dB, at 0.8 of the Nyquist rate that decimation by 10 leaves.
pub const DECIMATION: [Section; 4] = [
    [
        3.5863243209995223e-09,
        7.172648641999045e-09,
        3.5863243209995223e-09,
        1.0,
        -1.8204968644767618,
        0.8308597403796137,
    ],
    [1.0, 2.0, 1.0, 1.0, -1.8289505620176847, 0.8553173710387741],
    [1.0, 2.0, 1.0, 1.0, -1.8517334482627625, 0.9015161055713813],
    [1.0, 2.0, 1.0, 1.0, -1.8965395961864169, 0.9644245584642932],
];

/// Filters forward and backward, with the ends extended by odd reflection and the sections started
/// in their steady state (as `scipy.signal.sosfiltfilt`).
///
/// A series shorter than the extension comes back as it is.
pub fn filter(sections: &[Section], series: &[f64]) -> Vec<f64> {
    let padding = 3 * (2 * sections.len() + 1);
    if series.len() <= padding {
        return series.to_vec();
    }
    let (first, last) = (series[0], series[series.len() - 1]);
    let mut extended: Vec<f64> = (1..=padding)
        .rev()
        .map(|offset| 2.0 * first - series[offset])
        .chain(series.iter().copied())
        .chain((1..=padding).map(|offset| 2.0 * last - series[series.len() - 1 - offset]))
        .collect();
    for _ in 0..2 {
        run(sections, &mut extended);
        extended.reverse();
    }
    extended[padding..padding + series.len()].to_vec()
}

/// One pass through all sections, transposed direct form II.
fn run(sections: &[Section], series: &mut [f64]) {
    for [b0, b1, b2, _, a1, a2] in sections {
        // The steady state for a constant at the first sample's level.
        let level = series[0];
        let output = (b0 + b1 + b2) / (1.0 + a1 + a2) * level;
        let mut z2 = b2 * level - a2 * output;
        let mut z1 = b1 * level - a1 * output + z2;
        for sample in series.iter_mut() {
            let input = *sample;
            let output = b0 * input + z1;
            z1 = b1 * input - a1 * output + z2;
            z2 = b2 * input - a2 * output;
            *sample = output;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values: `scipy.signal.sosfiltfilt` 1.x on the same series, at samples 0, 1, 100,
    /// 200 and 399. SciPy pads 15 and 27 samples, as here.
    #[test]
    fn agrees_with_scipy() {
        let series: Vec<f64> = (0..400)
            .map(|n| {
                let n = f64::from(n);
                (0.05 * n).sin() + 0.5 * (0.9 * n).cos() + 0.01 * n
            })
            .collect();
        let cases: [(&[Section], [f64; 5]); 2] = [
            (
                &BUTTERWORTH,
                [
                    0.5034873408533405,
                    0.29981736951173554,
                    0.03206566675305759,
                    1.4439447936594378,
                    5.166618271231647,
                ],
            ),
            (
                &DECIMATION,
                [
                    0.49063563080287265,
                    0.46591914467275775,
                    0.030238565347069955,
                    1.4328402424732216,
                    5.065083458388087,
                ],
            ),
        ];
        for (sections, expected) in cases {
            let filtered = filter(sections, &series);
            for (index, expected) in [0, 1, 100, 200, 399].into_iter().zip(expected) {
                assert!(
                    (filtered[index] - expected).abs() < 1e-9,
                    "{index}: {} for {expected}",
                    filtered[index]
                );
            }
        }
    }
}
