//! Sine of a phase in cycles: accurate, cheap, the same bits everywhere.
//!
//! A phase in cycles is reduced exactly, where a phase in radians would first have to be divided by
//! an irrational number. Libm's `sinf` computes in f64, some 1200 instructions on a Cortex-M4F;
//! micromath's is off by 1e-3. Here the argument is folded into a quarter cycle and an odd
//! polynomial of degree 9 does the rest.

/// One cycle of a fixed-point phase is 2³² steps: the phase wraps where the integer does.
const CYCLES_PER_STEP: f32 = 1.0 / 4_294_967_296.0;

/// Quarter of a cycle in fixed point.
const QUARTER: i32 = 1 << 30;

/// sin(2πx) of a phase `x` in cycles.
///
/// Any finite `x`; the error is that of the result alone, the argument is reduced without any.
/// Worst absolute error 1.8e-7 (minimax polynomial 3.4e-9, the rest is rounding), and never
/// outside ±1. An infinity or NaN gives NaN.
///
/// ```
/// use model_core::numeric::sine::sine_cycles;
///
/// assert_eq!(sine_cycles(0.25), 1.0);
/// assert!((sine_cycles(1000.125) - 0.5_f32.sqrt()).abs() < 2e-7);
/// ```
#[inline(always)]
pub fn sine_cycles(x: f32) -> f32 {
    // Both differences are exact, so no precision is lost however large x is.
    let x = x - nearest(x);
    let folded = if x > 0.25 {
        0.5 - x
    } else if x < -0.25 {
        -0.5 - x
    } else {
        x
    };
    sine_quarter(folded)
}

/// A sine of this amplitude at a phase in cycles. One without amplitude costs nothing.
#[inline(always)]
pub fn ripple(amplitude: f32, cycles: f32) -> f32 {
    if amplitude == 0.0 {
        0.0
    } else {
        amplitude * sine_cycles(cycles)
    }
}

/// The nearest whole number, the even one of two.
#[inline(always)]
fn nearest(x: f32) -> f32 {
    /// 1.5 · 2²³: what is added to it is rounded to a whole number, in the processor's own rounding.
    const WHOLE: f32 = 12_582_912.0;
    /// 2²³: from here on every number is whole.
    const ALL_WHOLE: f32 = 8_388_608.0;
    let magnitude = x.abs();
    let small = (x + WHOLE) - WHOLE;
    let large = if magnitude < ALL_WHOLE {
        ((magnitude + ALL_WHOLE) - ALL_WHOLE).copysign(x)
    } else {
        x
    };
    if magnitude < 4_194_304.0 {
        small
    } else {
        large
    }
}

/// sin(2π·phase/2³²) of a fixed-point phase, for generators that accumulate it without drift.
///
/// Worst absolute error 1.8e-7, as [`sine_cycles`].
///
/// ```
/// use model_core::numeric::sine::sine_phase;
///
/// assert_eq!(sine_phase(0xC000_0000), -1.0);
/// ```
#[inline]
pub fn sine_phase(phase: u32) -> f32 {
    sine_quarter(fold_phase(phase))
}

/// Triangle of amplitude 1 with the phase of a sine: 0 at 0, 1 at a quarter, −1 at three quarters
/// of 2³². Worst absolute error 3e-8: the rounding of the phase to `f32`.
///
/// ```
/// use model_core::numeric::sine::triangle_phase;
///
/// assert_eq!(triangle_phase(0x2000_0000), 0.5);
/// ```
#[inline]
pub fn triangle_phase(phase: u32) -> f32 {
    4.0 * fold_phase(phase)
}

/// The phase within ±1/4 cycle that has the same sine, in cycles.
#[inline]
fn fold_phase(phase: u32) -> f32 {
    // The cast reads the upper half of the cycle as negative; the wrap at i32::MIN is meant.
    let signed = phase as i32;
    let folded = if signed > QUARTER {
        i32::MIN.wrapping_sub(signed)
    } else if signed < -QUARTER {
        i32::MIN - signed
    } else {
        signed
    };
    folded as f32 * CYCLES_PER_STEP
}

/// sin(2πx) for |x| ≤ 1/4: minimax coefficients of x, x³ … x⁹, worst error 3.4e-9 before rounding.
#[inline(always)]
fn sine_quarter(x: f32) -> f32 {
    // 2π in two parts, the first of few bits: one rounding less, and the top is exactly 1.
    const HIGH: f32 = 6.281_25;
    const LOW: f32 = 1.935_16e-3;
    let square = x * x;
    let tail = square
        * (-41.341_655 + square * (81.601_004 + square * (-76.549_78 + square * 39.536_704)));
    let sine = x * HIGH + x * (LOW + tail);
    // Rounding may pass the top of the curve by an ulp. (A NaN stays one.)
    sine.clamp(-1.0, 1.0)
}
