//! The motor's data.

/// A permanent-magnet synchronous motor with what turns at its speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motor {
    /// Of a phase, Ω.
    pub resistance: f64,
    /// Of a phase, rotating-field, H.
    pub inductance: f64,
    /// N·m for 1 A rms of i_q.
    pub torque_constant: f64,
    /// Periods of a phase in a turn.
    pub pole_pairs: f64,
    /// Largest current, A rms.
    pub peak_current: f64,
    /// Largest phase voltage of the inverter, V rms.
    pub peak_voltage: f64,
    /// Of motor and gearbox at the motor shaft, kg·m².
    pub inertia: f64,
    /// Viscous friction at the motor shaft, N·m·s/rad.
    pub viscous: f64,
    /// Sliding friction at the motor shaft without the brake, N·m.
    pub coulomb: f64,
    /// Static friction at the motor shaft without the brake, N·m; at least `coulomb`.
    pub static_friction: f64,
}

impl Motor {
    /// Simotics 1FK7060 (Table 2.1) on a supply of 380 V with the gearbox's inertia (Table 2.5). The
    /// friction is this bench's own: the paper prints none.
    pub const SIMOTICS_1FK7060: Self = Self {
        resistance: 2.75,
        inductance: 30.5e-3,
        torque_constant: 1.91,
        pole_pairs: 4.0,
        peak_current: 10.7,
        peak_voltage: 219.0,
        inertia: 7.7e-4 + 0.59e-4,
        viscous: 2.0e-3,
        coulomb: 0.05,
        static_friction: 0.06,
    };

    /// Flux linkage of the magnets in a phase, V·s rms: three phases share the torque.
    pub(super) fn flux_linkage(&self) -> f64 {
        self.torque_constant / (3.0 * self.pole_pairs)
    }
}
