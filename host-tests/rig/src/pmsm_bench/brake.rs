//! The disc brake behind the chain.

use super::{CHAIN_RATIO, LOAD_CELL_LEVER};

/// One multiple of the brake shaft's rotation in the brake torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// As a share of the mean torque; the shares of a brake add up to less than 1.
    pub share: f64,
    /// rad.
    pub phase: f64,
}

/// Dry friction of the brake, referred to the motor shaft; the same while it holds and while it
/// slides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brake {
    /// Mean torque at the motor shaft, N·m.
    pub torque: f64,
    /// The first three multiples of the brake shaft's rotation (section 5.1: the disc's run-out).
    pub harmonics: [Harmonic; 3],
}

impl Brake {
    /// A disc whose torque does not vary.
    pub const fn even(torque: f64) -> Self {
        const NONE: Harmonic = Harmonic {
            share: 0.0,
            phase: 0.0,
        };
        Self {
            torque,
            harmonics: [NONE; 3],
        }
    }

    /// A disc with run-out.
    pub const fn with_run_out(torque: f64) -> Self {
        const fn harmonic(share: f64, phase: f64) -> Harmonic {
            Harmonic { share, phase }
        }
        Self {
            torque,
            harmonics: [
                harmonic(0.10, 0.4),
                harmonic(0.05, 1.9),
                harmonic(0.03, -0.8),
            ],
        }
    }

    /// Torque at the motor shaft when that stands at `angle`, rad, N·m.
    pub fn level(&self, angle: f64) -> f64 {
        self.torque * (1.0 + self.sum(angle, |h, _, phase| h.share * phase.sin()))
    }

    /// Its derivative, N·m/rad.
    pub(super) fn slope(&self, angle: f64) -> f64 {
        self.torque * self.sum(angle, |h, rate, phase| h.share * rate * phase.cos())
    }

    /// Sum of `term` over the harmonics, given their phase and its derivative over the motor's angle.
    fn sum(&self, angle: f64, term: fn(&Harmonic, f64, f64) -> f64) -> f64 {
        (1_u8..)
            .zip(&self.harmonics)
            .map(|(order, harmonic)| {
                let rate = f64::from(order) / CHAIN_RATIO;
                term(harmonic, rate, rate * angle + harmonic.phase)
            })
            .sum()
    }

    /// What the load cell feels of a brake torque at the motor shaft, N (the formula of section 5.1).
    pub fn load_cell_force(torque: f64) -> f64 {
        torque * CHAIN_RATIO / LOAD_CELL_LEVER
    }
}

#[cfg(test)]
mod tests {
    use super::Brake;

    /// First and last loaded rows of Table 5.1, in grams of force, against their torques.
    #[test]
    fn load_cell_agrees_with_the_printed_table() {
        for (grams, torque) in [(3.0577, 0.0047279), (453.3086, 0.70092)] {
            let force = 9.81e-3 * grams;
            assert!((Brake::load_cell_force(torque) / force - 1.0).abs() < 1e-4);
        }
    }
}
