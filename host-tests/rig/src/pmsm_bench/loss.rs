//! Why the bench needs more current than tare and brake account for.

/// The loss that the paper's model lacks, and that makes its current up to 43 % low (section 6.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Loss {
    /// None: current is torque over torque constant.
    None,
    /// Friction that grows with the torque transmitted by chain and gearbox.
    LoadDependentLoss {
        /// N·m of friction for 1 N·m transmitted, both at the motor shaft.
        coefficient: f64,
    },
    /// A torque constant that falls with current as 1 / (1 + |i_q| / current).
    TorqueSaturation {
        /// Where the torque constant has fallen to half, A rms, positive.
        current: f64,
    },
}

impl Loss {
    /// The load-dependent loss with which the plain model's current is 40 % low at high friction.
    pub const fn load_dependent() -> Self {
        Self::LoadDependentLoss { coefficient: 0.72 }
    }

    /// The saturation with which the plain model's current is 40 % low at high friction.
    pub const fn torque_saturation() -> Self {
        Self::TorqueSaturation { current: 1.0 }
    }

    /// N·m of friction for 1 N·m transmitted.
    pub(super) fn friction_ratio(self) -> f64 {
        match self {
            Self::LoadDependentLoss { coefficient } => coefficient,
            Self::None | Self::TorqueSaturation { .. } => 0.0,
        }
    }

    /// What is left of the torque constant at this current.
    pub(super) fn torque_share(self, current: f64) -> f64 {
        match self {
            Self::TorqueSaturation { current: half } => 1.0 / (1.0 + current.abs() / half),
            Self::None | Self::LoadDependentLoss { .. } => 1.0,
        }
    }
}
