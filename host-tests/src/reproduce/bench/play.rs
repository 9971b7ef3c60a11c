//! Play of a transmission from a log of both its ends: the paper's Algorithm 1.

/// Motor position, scaled to the slow shaft, less encoder position, both referred to the slow shaft:
/// the residual of ch. 5.2. It ends with the shorter of the two.
pub fn residual(motor: &[f64], reduction: f64, encoder: &[f64]) -> Vec<f64> {
    let pairs = motor.iter().zip(encoder);
    pairs
        .map(|(motor, encoder)| motor / reduction - encoder)
        .collect()
}

/// The mean of |max| and |min| of a residual, in its unit. `None` without values or with one that is
/// not finite.
///
/// What it measures, for a residual that lies at one flank while moving forward and at the other
/// while moving backward:
///
/// * *Half of the play.* With zero in the middle of the play of full width b the residual runs from
///   −b/2 to b/2 and the answer is b/2. A dead band whose parameter is the full width wants twice
///   this number.
/// * *An offset* of the encoder's zero changes nothing while zero stays inside the play: also from one
///   flank, residuals from 0 to b, it is b/2. Beyond a flank the answer is the offset's magnitude
///   instead, whatever the play.
/// * *Elasticity* adds its wind-up: with a torque of ±T at the ends of a shaft of stiffness c it is
///   b/2 + T/c. It cannot tell the two apart, and extremes take the largest noise and every spike
///   with them. So does gearing that runs out: an eccentricity of amplitude e adds up to e.
///
/// ```
/// use host_tests::reproduce::bench::play::algorithm_1;
///
/// assert_eq!(algorithm_1(&[0.25, 0.25, -0.75, -0.75]), Some(0.5));
/// assert_eq!(algorithm_1(&[]), None);
/// ```
pub fn algorithm_1(residual: &[f64]) -> Option<f64> {
    let (first, rest) = residual.split_first()?;
    if residual.iter().any(|value| !value.is_finite()) {
        return None;
    }
    let (low, high) = rest.iter().fold((*first, *first), |(low, high), &value| {
        (value.min(low), value.max(high))
    });
    Some(0.5 * (high.abs() + low.abs()))
}
