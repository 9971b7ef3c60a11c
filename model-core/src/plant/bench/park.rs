//! Clarke's and Park's transformations, direct and inverse (bench paper, sections 3.3 and 3.6).
//!
//! Clarke's has the factor 2/3, so that amplitudes stay: three symmetric currents of a peak I have
//! α and β, d and q of that magnitude.

use crate::numeric::sine::sine_cycles;

const HALF_ROOT_3: f32 = 0.866_025_4;
const INVERSE_ROOT_3: f32 = 0.577_350_26;

/// Sine and cosine of an electrical angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rotation {
    /// sin θ.
    pub sine: f32,
    /// cos θ.
    pub cosine: f32,
}

impl Rotation {
    /// By an angle in cycles.
    #[inline]
    pub fn new(cycles: f32) -> Self {
        Self {
            sine: sine_cycles(cycles),
            cosine: sine_cycles(cycles + 0.25),
        }
    }

    /// Park's transformation: (α, β) as seen from the rotor, (d, q).
    #[inline]
    pub fn park(&self, [alpha, beta]: [f32; 2]) -> [f32; 2] {
        [
            self.cosine * alpha + self.sine * beta,
            self.cosine * beta - self.sine * alpha,
        ]
    }

    /// Its inverse: (d, q) as seen from the stator, (α, β).
    #[inline]
    pub fn inverse_park(&self, [direct, quadrature]: [f32; 2]) -> [f32; 2] {
        [
            self.cosine * direct - self.sine * quadrature,
            self.sine * direct + self.cosine * quadrature,
        ]
    }
}

/// Clarke's transformation: (A, B, C) to (α, β).
///
/// What the three have in common is not in it.
///
/// ```
/// use model_core::plant::bench::park::clarke;
/// let [alpha, beta] = clarke([3.0, 1.0, 1.0]);
/// assert!((alpha - 4.0 / 3.0).abs() < 1e-6 && beta == 0.0);
/// ```
#[inline]
pub fn clarke([a, b, c]: [f32; 3]) -> [f32; 2] {
    [(2.0 / 3.0) * (a - 0.5 * (b + c)), INVERSE_ROOT_3 * (b - c)]
}

/// Its inverse: (α, β) to (A, B, C), which add up to zero.
#[inline]
pub fn inverse_clarke([alpha, beta]: [f32; 2]) -> [f32; 3] {
    let half = -0.5 * alpha;
    let side = HALF_ROOT_3 * beta;
    [alpha, half + side, half - side]
}
