//! Three RL branches in star, with their back-EMFs (bench paper, section 3.4).
//!
//! With a neutral point that is connected to nothing, and branches that are alike,
//!
//! ```text
//! L di_j/dt + R i_j = (v_j − e_j) − ⅓ Σ (v_k − e_k),   Σ i_j = 0
//! ```
//!
//! While the switches and the back-EMFs stand, each current nears its final value by the same share
//! of the distance in every step, 1 − e^(−Rh/L): the step is exact, however long.

use crate::numeric::invalid_parameter::{InvalidParameter, require, require_positive};
use crate::numeric::matrix_exponential::exponential;

/// What the windings are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Pairs of poles, at least 1.
    pub pole_pairs: u8,
    /// Of a phase, Ω, > 0.
    pub resistance: f32,
    /// Of a phase with the others' currents symmetric, H, > 0.
    pub inductance: f32,
}

/// The branches, for steps of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Windings {
    /// 1 − e^(−Rh/L).
    pub(super) share: f32,
    /// e^(−Rh/L).
    pub(super) decay: f32,
    conductance: f32,
}

impl Parameters {
    /// Branches for steps of `period` seconds.
    ///
    /// # Errors
    /// A value that is not above zero and finite.
    pub fn build(&self, period: f32) -> Result<Windings, InvalidParameter> {
        require_positive(f32::from(self.pole_pairs), "pole pairs")?;
        require_positive(self.resistance, "resistance")?;
        require_positive(self.inductance, "inductance")?;
        require_positive(period, "period")?;
        let exponent = -f64::from(self.resistance) / f64::from(self.inductance) * f64::from(period);
        let [[decay]] = exponential(&[[exponent]]);
        let windings = Windings {
            share: (1.0 - decay) as f32,
            decay: decay as f32,
            conductance: 1.0 / self.resistance,
        };
        require(
            windings.admittance().is_normal() && windings.impedance().is_normal(),
            "inductance",
            "must let the current change in a step, within f32",
        )?;
        Ok(windings)
    }
}

impl Windings {
    /// Current that a voltage over the step adds, A/V.
    pub(super) fn admittance(&self) -> f32 {
        self.share * self.conductance
    }

    /// Its inverse, V/A.
    pub(super) fn impedance(&self) -> f32 {
        1.0 / self.admittance()
    }

    /// One step of the phase currents, A, under the terminals' voltages and back-EMFs, V.
    #[inline]
    pub fn step(&self, currents: &mut [f32; 3], terminals: [f32; 3], back_emf: [f32; 3]) {
        let driving = [0, 1, 2].map(|phase| terminals[phase] - back_emf[phase]);
        let neutral = (driving[0] + driving[1] + driving[2]) * (1.0 / 3.0);
        for phase in [0, 1] {
            let final_current = (driving[phase] - neutral) * self.conductance;
            currents[phase] += self.share * (final_current - currents[phase]);
        }
        // Kirchhoff's law, whatever rounding does.
        currents[2] = -(currents[0] + currents[1]);
    }
}
