//! Compensated summation.

/// A running sum in two `f32`: its value, and what the value's rounding lost.
///
/// Knuth's exact error of an addition, carried on and renormalised every time (`DWPlusFP`,
/// algorithm 4 of Joldes, Muller and Popescu, *Tight and rigorous error bounds for basic building
/// blocks of double-word arithmetic*, ACM Trans. Math. Softw. 44, 2017):
///
/// ```text
/// s ← fl(value + x),   e ← value + x − s (exact),   v ← fl(lost + e)
/// value ← fl(s + v),   lost ← s + v − value (exact)
/// ```
///
/// An addition errs by at most 2⁻⁴⁷ of the sum, where a plain `f32` errs by 2⁻²⁴: a million
/// additions of one sign stay below half an ulp of the value. Ten additions, no branch.
/// (Neumaier's form, which adds up the lost parts without renormalising them, is off by 6 in the
/// example below: they become as large as 958 and are rounded themselves.)
/// Units and range are those of the summands: the sum must stay below `f32::MAX`, and a non-finite
/// summand makes the value NaN for good, so refuse it before.
///
/// One tenth has no exact `f32`: a million of them should be 100000.00149, and a plain `f32` sum
/// says 100958.34.
///
/// ```
/// use model_core::numeric::sum::Sum;
///
/// let mut sum = Sum::default();
/// let mut plain = 0.0;
/// for _ in 0..1_000_000 {
///     sum.add(0.1);
///     plain += 0.1f32;
/// }
/// assert_eq!(sum.value(), 100_000.0);
/// assert_eq!(plain, 100_958.34);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sum {
    value: f32,
    lost: f32,
}

impl Sum {
    /// A sum that starts from `value`.
    pub const fn new(value: f32) -> Self {
        Self { value, lost: 0.0 }
    }

    /// Adds one summand.
    #[inline]
    pub fn add(&mut self, summand: f32) {
        let sum = self.value + summand;
        let taken = sum - self.value;
        let error = (self.value - (sum - taken)) + (summand - taken);
        let lost = self.lost + error;
        self.value = sum + lost;
        self.lost = lost - (self.value - sum);
    }

    /// The sum so far, rounded once.
    #[inline]
    pub fn value(&self) -> f32 {
        self.value
    }
}

impl Extend<f32> for Sum {
    fn extend<I: IntoIterator<Item = f32>>(&mut self, summands: I) {
        for summand in summands {
            self.add(summand);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn survives_cancellation() {
        // The plain sum loses both ones: the spacing of f32 at 1e8 is 8.
        let summands = [1.0, 1e8, 1.0, -1e8];
        let mut sum = Sum::default();
        sum.extend(summands);
        assert_eq!(sum.value(), 2.0);
        assert_eq!(summands.iter().sum::<f32>(), 0.0);
    }

    #[test]
    fn keeps_increments_below_half_an_ulp() {
        // 2⁻²⁵ is a quarter of the spacing above 1: a plain sum stays at 1 for ever.
        let increment = 1.0 / 33_554_432.0;
        let mut sum = Sum::new(1.0);
        let mut plain = 1.0;
        for _ in 0..1 << 20 {
            sum.add(increment);
            plain += increment;
        }
        assert_eq!(sum.value(), 1.0 + 1.0 / 32.0);
        assert_eq!(plain, 1.0);
    }
}
