//! From a duty to the compare values of the two half bridges.
//!
//! The timer counts up to [`FULL_DUTY`] and down again. Each half bridge is switched by one channel
//! and its complement, and the two get duties about one half, of opposite sense: the winding sees
//! their difference, at twice the timer's frequency, and no dead band about zero.

use crate::app::machine::FULL_DUTY;

/// Most counts of duty, either way: at full duty the upper switch of a half bridge would stay on,
/// and the capacitor that feeds its driver could not charge. What is left, 1.25 µs of a period at each
/// half bridge, is longer than the dead time.
pub const MOST_DUTY: i16 = FULL_DUTY - FULL_DUTY / 20;

/// Least supply at which a voltage is made of it, V.
const LEAST_SUPPLY: f32 = 1.0;

/// The largest voltage that the bridge makes of this supply, either way, V.
pub fn reach(supply: f32) -> f32 {
    supply * (f32::from(MOST_DUTY) / f32::from(FULL_DUTY))
}

/// The duty that puts a voltage at the winding, in counts, with this supply, V; 0 without a supply or
/// for what is not a number.
///
/// ```
/// use firmware::app::operation::bridge::{MOST_DUTY, duty};
///
/// assert_eq!(duty(6.0, 24.0), 1050);
/// assert_eq!(duty(-6.0, 12.0), -2100);
/// assert_eq!(duty(60.0, 12.0), MOST_DUTY);
/// assert_eq!(duty(6.0, 0.0), 0);
/// assert_eq!(duty(f32::NAN, 12.0), 0);
/// ```
pub fn duty(voltage: f32, supply: f32) -> i16 {
    if supply.is_nan() || supply < LEAST_SUPPLY {
        return 0;
    }
    let counts = voltage / supply * f32::from(FULL_DUTY);
    // The cast cuts the fraction off, saturates, and takes NaN for 0.
    let nearest = (counts + 0.5f32.copysign(counts)) as i16;
    nearest.clamp(-MOST_DUTY, MOST_DUTY)
}

/// Compare values of the half bridges at the winding's positive and negative end.
///
/// ```
/// use firmware::app::operation::bridge::compares;
///
/// assert_eq!(compares(0), [2100, 2100]);
/// assert_eq!(compares(1001), [2600, 1599]);
/// assert_eq!(compares(-1001), [1599, 2600]);
/// ```
pub fn compares(duty: i16) -> [u16; 2] {
    let duty = i32::from(duty.clamp(-MOST_DUTY, MOST_DUTY));
    let half = i32::from(FULL_DUTY) / 2;
    let positive = half + duty.div_euclid(2);
    // Both are 105 to 4095.
    [positive as u16, (positive - duty) as u16]
}
