//! The resolver: electrical angle of the rotor (bench paper, section 3.2).
//!
//! ```text
//! θ_e = 2π [p θ_m/2π − floor(p θ_m/2π)]
//! ```
//!
//! The bracket is what the model computes with: an angle in cycles, wrapped to 0 … 1.

use core::f32::consts::TAU;

/// A resolver of so many pole pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolver {
    /// p/2π.
    cycles_per_radian: f32,
}

impl Resolver {
    /// Of so many pairs of poles.
    pub fn new(pole_pairs: u8) -> Self {
        Self {
            cycles_per_radian: f32::from(pole_pairs) / TAU,
        }
    }

    /// Electrical angle at a mechanical one in rad: cycles from 0 to 1.
    ///
    /// ```
    /// use model_core::plant::bench::resolver::Resolver;
    /// let quarter_turn = core::f32::consts::FRAC_PI_2;
    /// // Four pairs of poles: a sixteenth of a turn is a quarter of a cycle.
    /// assert_eq!(Resolver::new(4).electrical(quarter_turn / 4.0), 0.25);
    /// assert_eq!(Resolver::new(4).electrical(-quarter_turn / 4.0), 0.75);
    /// ```
    #[inline]
    pub fn electrical(&self, mechanical: f32) -> f32 {
        let cycles = mechanical * self.cycles_per_radian;
        cycles - libm::floorf(cycles)
    }
}
