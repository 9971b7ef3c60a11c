//! The exponential of what decays.

use core::f32::consts::LOG2_E;

/// exp(−x) for `x` ≥ 0, to the bit what `libm::expf` gives.
///
/// The same method, FreeBSD's `e_expf.c`: x = k ln 2 + r, and a rational function of r. Without its
/// branches, so that many can be worked out at once. A NaN stays one.
///
/// ```
/// use model_core::numeric::exponential::decay;
/// assert_eq!(decay(0.0), 1.0);
/// assert_eq!(decay(1.0), libm::expf(-1.0));
/// assert_eq!(decay(f32::INFINITY), 0.0);
/// ```
#[inline(always)]
pub fn decay(x: f32) -> f32 {
    const LN2_HIGH: f32 = 6.931_457_5e-1;
    const LN2_LOW: f32 = 1.428_606_8e-6;
    const P1: f32 = 1.666_662_5e-1;
    const P2: f32 = -2.766_733_3e-3;
    /// Under half and under one and a half times ln 2, k is 0 and −1.
    const HALF_LN2: f32 = f32::from_bits(0x3eb1_7218);
    const MORE_THAN_LN2: f32 = f32::from_bits(0x3f85_1592);
    /// Below, 1 − x is all there is of it.
    const LEAST: f32 = f32::from_bits(0x3900_0000);
    /// From here on nothing is left.
    const MOST: f32 = f32::from_bits(0x42cf_f1b5);

    let negative = -x;
    let far = (LOG2_E * negative - 0.5) as i32;
    let k = if x > MORE_THAN_LN2 {
        far
    } else if x > HALF_LN2 {
        -1
    } else {
        0
    };
    let whole = k as f32;
    let high = negative - whole * LN2_HIGH;
    let low = whole * LN2_LOW;
    let rest = high - low;
    let square = rest * rest;
    let c = rest - square * (P1 + square * P2);
    let mantissa = 1.0 + (rest * c / (2.0 - c) - low + high);
    // In two factors, where one would be below the smallest number.
    let tiny = k < -126;
    let first = if tiny {
        f32::from_bits((127 - 102) << 23)
    } else {
        1.0
    };
    let left = (if tiny { k + 102 } else { k }).clamp(-126, 0);
    let second = f32::from_bits(((left + 127) as u32) << 23);
    let scaled = mantissa * first * second;
    if x >= MOST {
        0.0
    } else if x > LEAST {
        scaled
    } else {
        // A NaN, too.
        1.0 + negative
    }
}

#[cfg(test)]
mod tests {
    use super::decay;

    #[test]
    fn every_thousandth_number_has_the_bits_of_the_library() {
        // Up to infinity and some NaNs beyond, and all near the borders.
        let spread = (0..=0x7fc0_0000_u32).step_by(997);
        let borders = [
            0x3eb1_7218,
            0x3f85_1592,
            0x3900_0000,
            0x42cf_f1b5,
            0x42ae_ac50_u32,
        ];
        let near = borders
            .into_iter()
            .flat_map(|bits| bits - 2000..bits + 2000);
        for bits in spread.chain(near) {
            let x = f32::from_bits(bits);
            let (ours, theirs) = (decay(x), libm::expf(-x));
            assert!(
                ours.to_bits() == theirs.to_bits() || (ours.is_nan() && theirs.is_nan()),
                "{x:e}: {ours:e}, {theirs:e}"
            );
        }
    }
}
