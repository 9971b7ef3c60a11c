//! Seeded random numbers: the same sequence on the board and on the host.

use super::normal;

/// Knuth's multiplier, as in the reference implementation of PCG.
const MULTIPLIER: u64 = 6_364_136_223_846_793_005;

/// PCG32 (XSH-RR 64/32): period 2⁶⁴, 16 bytes, one 64-bit multiplication a number.
///
/// O'Neill, *PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms for Random
/// Number Generation*, Harvey Mudd College HMC-CS-2014-0905. Not for cryptography.
///
/// ```
/// use model_core::numeric::random::Random;
///
/// let mut random = Random::new(42, 54);
/// assert_eq!(random.bits(), 0xa15c_02b7);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Random {
    state: u64,
    increment: u64,
}

impl Random {
    /// A generator at the place `seed` of the sequence `stream`: two streams never share a state.
    /// The highest bit of `stream` is not used.
    pub const fn new(seed: u64, stream: u64) -> Self {
        let increment = (stream << 1) | 1;
        // The reference seeding: one step from zero, add the seed, one more step.
        let state = increment
            .wrapping_add(seed)
            .wrapping_mul(MULTIPLIER)
            .wrapping_add(increment);
        Self { state, increment }
    }

    /// 32 uniformly distributed bits.
    pub fn bits(&mut self) -> u32 {
        let state = self.state;
        self.state = state.wrapping_mul(MULTIPLIER).wrapping_add(self.increment);
        let xorshifted = (((state >> 18) ^ state) >> 27) as u32;
        xorshifted.rotate_right((state >> 59) as u32)
    }

    /// Uniform in [0, 1): a multiple of 2⁻²⁴, each equally likely.
    pub fn uniform(&mut self) -> f32 {
        (self.bits() >> 8) as f32 * (1.0 / 16_777_216.0)
    }

    /// Standard normal, by inverting the distribution ([`normal::quantile_f32`]): one draw a number,
    /// no rejection, so that a run always takes the same steps. Within ±6.34.
    pub fn normal(&mut self) -> f32 {
        let bits = self.bits();
        // One bit for the sign and 31 for the probability of the tail keep the tail's precision.
        let tail = ((bits >> 1) as f32 + 0.5) * (1.0 / 4_294_967_296.0);
        let value = normal::quantile_f32(tail);
        if bits & 1 == 0 { value } else { -value }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::sum::Sum;

    /// Round 1 of the output of `pcg32-demo` in O'Neill's `pcg-c-basic`, seed 42, stream 54.
    #[test]
    fn equals_the_published_sequence() {
        let mut random = Random::new(42, 54);
        for expected in [
            0xa15c_02b7,
            0x7b47_f409,
            0xba1d_3330,
            0x83d2_f293,
            0xbfa4_784b,
            0xcbed_606e,
        ] {
            assert_eq!(random.bits(), expected);
        }
    }

    #[test]
    fn uniform_fills_its_interval_evenly() {
        let mut random = Random::new(1, 1);
        let mut bins = [0_u32; 100];
        for _ in 0..100_000 {
            bins[(random.uniform() * 100.0) as usize] += 1;
        }
        let chi_square: f32 = bins
            .iter()
            .map(|&count| (count as f32 - 1000.0) * (count as f32 - 1000.0) / 1000.0)
            .sum();
        // 99 degrees of freedom: the 0.1 % and 99.9 % points (scipy.stats.chi2.ppf).
        assert!(chi_square > 60.9 && chi_square < 149.5, "{chi_square}");
    }

    #[test]
    fn normal_has_the_moments_of_a_normal_variable() {
        const DRAWS: u32 = 200_000;
        let mut random = Random::new(1, 1);
        let mut powers = [Sum::default(); 4];
        let mut beyond_two = 0;
        for _ in 0..DRAWS {
            let x = random.normal();
            for (sum, power) in powers.iter_mut().zip([x, x * x, x * x * x, x * x * x * x]) {
                sum.add(power);
            }
            beyond_two += u32::from(x.abs() > 2.0);
        }
        // Five standard errors: sqrt(1, 2, 15, 96)/sqrt(200 000).
        for ((sum, expected), tolerance) in powers
            .iter()
            .zip([0.0, 1.0, 0.0, 3.0])
            .zip([0.0112, 0.0158, 0.0433, 0.1095])
        {
            let moment = sum.value() / DRAWS as f32;
            assert!(
                (moment - expected).abs() < tolerance,
                "{moment} for {expected}"
            );
        }
        // P(|x| > 2) = 0.0455003, its standard error 4.7e-4.
        assert!((beyond_two as f32 / DRAWS as f32 - 0.045_500_3).abs() < 0.002_4);
    }
}
