//! Dimensions of parameters, and their SI units for an angle or a length as coordinate.

/// What a parameter measures, with torque standing for force and angle for length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// Ω.
    Resistance,
    /// H.
    Inductance,
    /// V.
    Voltage,
    /// 1/W.
    PerPower,
    /// 1/(A²·s).
    PerSquaredCurrentTime,
    /// N·m/A or N/A.
    TorquePerCurrent,
    /// kg·m² or kg.
    Inertia,
    /// N·m or N.
    Torque,
    /// 1/(N·m) or 1/N.
    PerTorque,
    /// N·m·s/rad or N·s/m.
    TorquePerVelocity,
    /// N·m·s²/rad² or N·s²/m².
    TorquePerSquaredVelocity,
    /// N·m/rad or N/m.
    TorquePerPosition,
    /// rad/(N·m) or m/N.
    PositionPerTorque,
    /// rad or m.
    Position,
    /// rad/s or m/s.
    Velocity,
    /// s.
    Time,
    /// s².
    SquaredTime,
    /// 1/s.
    PerTime,
    /// rad, whatever the coordinate.
    Phase,
    /// 1.
    Ratio,
}

impl Dimension {
    /// Whether a torque or force is part of it.
    ///
    /// ```
    /// use model_core::unit::Dimension;
    /// assert!(Dimension::PositionPerTorque.has_torque());
    /// assert!(!Dimension::Inertia.has_torque());
    /// ```
    pub fn has_torque(self) -> bool {
        matches!(
            self,
            Self::TorquePerCurrent
                | Self::Torque
                | Self::PerTorque
                | Self::TorquePerVelocity
                | Self::TorquePerSquaredVelocity
                | Self::TorquePerPosition
                | Self::PositionPerTorque
        )
    }

    /// The SI unit, for an angle (`rotary`) or a length as coordinate.
    ///
    /// ```
    /// use model_core::unit::Dimension;
    /// assert_eq!(Dimension::TorquePerVelocity.unit(false), "N·s/m");
    /// ```
    pub fn unit(self, rotary: bool) -> &'static str {
        let (angle, length) = match self {
            Self::Resistance => ("Ω", "Ω"),
            Self::Inductance => ("H", "H"),
            Self::Voltage => ("V", "V"),
            Self::PerPower => ("1/W", "1/W"),
            Self::PerSquaredCurrentTime => ("1/(A²·s)", "1/(A²·s)"),
            Self::TorquePerCurrent => ("N·m/A", "N/A"),
            Self::Inertia => ("kg·m²", "kg"),
            Self::Torque => ("N·m", "N"),
            Self::PerTorque => ("1/(N·m)", "1/N"),
            Self::TorquePerVelocity => ("N·m·s/rad", "N·s/m"),
            Self::TorquePerSquaredVelocity => ("N·m·s²/rad²", "N·s²/m²"),
            Self::TorquePerPosition => ("N·m/rad", "N/m"),
            Self::PositionPerTorque => ("rad/(N·m)", "m/N"),
            Self::Position => ("rad", "m"),
            Self::Velocity => ("rad/s", "m/s"),
            Self::Time => ("s", "s"),
            Self::SquaredTime => ("s²", "s²"),
            Self::PerTime => ("1/s", "1/s"),
            Self::Phase => ("rad", "rad"),
            Self::Ratio => ("1", "1"),
        };
        if rotary { angle } else { length }
    }
}
