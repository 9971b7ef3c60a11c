//! What a rig can have that its machine file does not say.

use crate::machine::Machine;
use std::f64::consts::TAU;

/// One physical effect with its strength. Loads are N·m or N, speeds rad/s or m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Effect {
    /// Coulomb and static friction are (1 + ratio) times as large forward and (1 − ratio) times
    /// as large backward.
    AsymmetricCoulomb {
        /// −1 to 1.
        ratio: f64,
    },
    /// Viscous friction beyond the machine's own, different either way.
    AsymmetricViscous {
        /// Added while moving forward, N·m·s/rad or N·s/m.
        forward: f64,
        /// Added while moving backward, N·m·s/rad or N·s/m.
        backward: f64,
    },
    /// A constant load, positive forward.
    OffsetTorque {
        /// N·m or N.
        torque: f64,
    },
    /// Sliding friction raised by drop · exp(−|v| / speed) (Tustin's law); breakaway needs at
    /// least the sliding friction at zero speed.
    Stribeck {
        /// N·m or N.
        drop: f64,
        /// rad/s or m/s, positive.
        speed: f64,
    },
    /// A load −coefficient · v · |v|.
    QuadraticDrag {
        /// N·m·s²/rad² or N·s²/m².
        coefficient: f64,
    },
    /// A load −stiffness · (x − rest), beside the machine's own spring.
    Spring {
        /// N·m/rad or N/m.
        stiffness: f64,
        /// rad or m.
        rest: f64,
    },
    /// A load amplitude · sin(2π x / period + phase).
    Cogging {
        /// N·m or N.
        amplitude: f64,
        /// rad or m, positive.
        period: f64,
        /// rad.
        phase: f64,
    },
    /// Sliding and static friction raised by ratio · |motor load|.
    LoadDependentFriction {
        /// 0 to less than 1: from 1 on the machine would lock itself.
        ratio: f64,
    },
    /// The drive applies every input this much later than it was told.
    InputDelay {
        /// s, any value: not bound to the sample period.
        seconds: f64,
    },
    /// The position reported is this old; the current is not.
    SensorDelay {
        /// s, any value: not bound to the sample period.
        seconds: f64,
    },
    /// Lost motion before the sensor: what it reports stays until the machine has taken up the play.
    Backlash {
        /// The full width, rad or m.
        width: f64,
    },
    /// A second inertia behind a spring, which the sensor sits on. It is a part of the machine's own.
    Compliance {
        /// Part of the machine's inertia, 0 to 1.
        share: f64,
        /// J₂/k, s²; 0 is rigid.
        trailing: f64,
        /// d / (2 √(k J₂)).
        damping: f64,
    },
    /// The torque constant falls with current: k / (1 + fall · |load|), with the load that the motor
    /// would have without it. The back-EMF falls with it.
    TorqueSaturation {
        /// One over what the load tends to, 1/(N·m) or 1/N.
        fall: f64,
    },
    /// Coulomb and static friction are (1 + rate · t) times as large, t from the beginning of the log.
    FrictionDrift {
        /// 1/s.
        rate: f64,
    },
    /// Coulomb and static friction are (1 + ratio · sin(2π x / period + phase)) times as large.
    PositionDependentFriction {
        /// −1 to 1.
        ratio: f64,
        /// rad or m, positive.
        period: f64,
        /// rad.
        phase: f64,
    },
    /// A load that rises and falls in ramps; the times are those of the ramps' middles.
    ExternalLoad {
        /// N·m or N.
        torque: f64,
        /// s from the beginning of the log.
        begin: f64,
        /// s.
        duration: f64,
        /// Length of a ramp, s, positive.
        ramp: f64,
    },
    /// Friction raised by torque · exp(−((|v| − centre) / width)²): a resonance of the housing,
    /// a seal that hums. No entry of the catalogue has this shape.
    SpeedBand {
        /// N·m or N.
        torque: f64,
        /// rad/s or m/s.
        centre: f64,
        /// rad/s or m/s, positive.
        width: f64,
    },
    /// Friction raised by torque · exp(−((x − centre) / width)²): a damaged place on the screw. No
    /// entry of the catalogue is that local.
    RoughSpot {
        /// N·m or N.
        torque: f64,
        /// rad or m.
        centre: f64,
        /// rad or m, positive.
        width: f64,
    },
    /// Friction that yields before it slides: bristles of Canudas de Wit, Olsson, Åström and
    /// Lischinsky (*A New Model for Control of Systems with Friction*, IEEE Trans. Autom. Control
    /// 40, 1995: LuGre). Static friction falls to Coulomb's as exp(−(v / speed)²).
    Presliding {
        /// 1/σ₀, rad/(N·m) or m/N; 0 is rigid.
        compliance: f64,
        /// σ₁, N·m·s/rad or N·s/m.
        damping: f64,
        /// v_s, rad/s or m/s, positive.
        speed: f64,
    },
}

/// Which effect, without its strength.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffectKind {
    /// [`Effect::AsymmetricCoulomb`]
    AsymmetricCoulomb,
    /// [`Effect::AsymmetricViscous`]
    AsymmetricViscous,
    /// [`Effect::OffsetTorque`]
    OffsetTorque,
    /// [`Effect::Stribeck`]
    Stribeck,
    /// [`Effect::QuadraticDrag`]
    QuadraticDrag,
    /// [`Effect::Spring`]
    Spring,
    /// [`Effect::Cogging`]
    Cogging,
    /// [`Effect::LoadDependentFriction`]
    LoadDependentFriction,
    /// [`Effect::InputDelay`]
    InputDelay,
    /// [`Effect::SensorDelay`]
    SensorDelay,
    /// [`Effect::Backlash`]
    Backlash,
    /// [`Effect::Compliance`]
    Compliance,
    /// [`Effect::TorqueSaturation`]
    TorqueSaturation,
    /// [`Effect::FrictionDrift`]
    FrictionDrift,
    /// [`Effect::PositionDependentFriction`]
    PositionDependentFriction,
    /// [`Effect::ExternalLoad`]
    ExternalLoad,
    /// [`Effect::SpeedBand`]
    SpeedBand,
    /// [`Effect::RoughSpot`]
    RoughSpot,
    /// [`Effect::Presliding`]
    Presliding,
}

impl EffectKind {
    /// Every kind that a rig can carry.
    pub const ALL: [Self; 19] = [
        Self::AsymmetricCoulomb,
        Self::AsymmetricViscous,
        Self::OffsetTorque,
        Self::Stribeck,
        Self::QuadraticDrag,
        Self::Spring,
        Self::Cogging,
        Self::LoadDependentFriction,
        Self::InputDelay,
        Self::SensorDelay,
        Self::Backlash,
        Self::Compliance,
        Self::TorqueSaturation,
        Self::FrictionDrift,
        Self::PositionDependentFriction,
        Self::ExternalLoad,
        Self::SpeedBand,
        Self::RoughSpot,
        Self::Presliding,
    ];

    /// The id in the catalogue of effects. `None` for [`EffectKind::SpeedBand`] and
    /// [`EffectKind::RoughSpot`], which are there to be unknown.
    pub fn id(self) -> Option<&'static str> {
        match self {
            Self::AsymmetricCoulomb => Some("asymmetric_coulomb"),
            Self::AsymmetricViscous => Some("asymmetric_viscous"),
            Self::OffsetTorque => Some("offset_torque"),
            Self::Stribeck => Some("stribeck"),
            Self::QuadraticDrag => Some("quadratic_drag"),
            Self::Spring => Some("spring"),
            Self::Cogging => Some("cogging"),
            Self::LoadDependentFriction => Some("load_dependent_friction"),
            Self::InputDelay => Some("input_delay"),
            Self::SensorDelay => Some("sensor_delay"),
            Self::Backlash => Some("backlash"),
            Self::Compliance => Some("compliance"),
            Self::TorqueSaturation => Some("torque_saturation"),
            Self::FrictionDrift => Some("friction_drift"),
            Self::PositionDependentFriction => Some("position_dependent_friction"),
            Self::ExternalLoad => Some("external_load"),
            Self::Presliding => Some("presliding"),
            Self::SpeedBand | Self::RoughSpot => None,
        }
    }
}

impl Effect {
    /// The effect at a strength that this machine might well have: a tenth to a third of its
    /// friction, or two to three milliseconds.
    pub fn nominal(kind: EffectKind, machine: &Machine) -> Self {
        let coulomb = machine.coulomb;
        let friction_at_speed = coulomb + machine.viscous * machine.speed;
        match kind {
            EffectKind::AsymmetricCoulomb => Self::AsymmetricCoulomb { ratio: 0.2 },
            EffectKind::AsymmetricViscous => Self::AsymmetricViscous {
                forward: 0.3 * coulomb / machine.speed,
                backward: 0.0,
            },
            EffectKind::OffsetTorque => Self::OffsetTorque {
                torque: 0.15 * coulomb,
            },
            EffectKind::Stribeck => Self::Stribeck {
                drop: 0.3 * coulomb,
                speed: 0.1 * machine.speed,
            },
            EffectKind::QuadraticDrag => Self::QuadraticDrag {
                coefficient: 0.2 * friction_at_speed / machine.speed.powi(2),
            },
            EffectKind::Spring => Self::Spring {
                stiffness: 0.15 * coulomb / machine.amplitude(),
                rest: machine.centre(),
            },
            EffectKind::Cogging => Self::Cogging {
                amplitude: 0.15 * coulomb,
                period: 2.0 * machine.amplitude() / 12.0,
                phase: TAU / 7.0,
            },
            EffectKind::LoadDependentFriction => Self::LoadDependentFriction { ratio: 0.12 },
            EffectKind::InputDelay => Self::InputDelay { seconds: 2.4e-3 },
            EffectKind::SensorDelay => Self::SensorDelay { seconds: 2.4e-3 },
            EffectKind::Backlash => Self::Backlash {
                width: 0.01 * (2.0 * machine.amplitude()),
            },
            // 40 Hz with the drive held: well below, the position loops swing.
            EffectKind::Compliance => Self::Compliance {
                share: 0.2,
                trailing: (TAU * 40.0).powi(-2),
                damping: 0.15,
            },
            EffectKind::TorqueSaturation => {
                // A fifth is lost at the load that friction, spring and a brisk start take.
                let spring = machine.spring.map_or(0.0, |spring| {
                    spring.preload + spring.stiffness * (machine.stroke.1 - spring.rest)
                });
                let start = machine.inertia * machine.speed / 0.1;
                let peak = friction_at_speed + spring + start;
                Self::TorqueSaturation { fall: 0.25 / peak }
            }
            // A third more at the end of a log of ten seconds.
            EffectKind::FrictionDrift => Self::FrictionDrift { rate: 0.03 },
            EffectKind::PositionDependentFriction => Self::PositionDependentFriction {
                ratio: 0.3,
                period: 1.4 * (2.0 * machine.amplitude()),
                phase: TAU / 5.0,
            },
            EffectKind::ExternalLoad => Self::ExternalLoad {
                torque: 0.25 * coulomb,
                begin: 3.7,
                duration: 2.6,
                ramp: 0.02,
            },
            EffectKind::SpeedBand => Self::SpeedBand {
                torque: 0.4 * coulomb,
                centre: 0.4 * machine.speed,
                width: 0.1 * machine.speed,
            },
            EffectKind::RoughSpot => Self::RoughSpot {
                torque: 0.4 * coulomb,
                centre: machine.centre() + 0.3 * machine.amplitude(),
                width: 0.15 * machine.amplitude(),
            },
            EffectKind::Presliding => {
                // Half the critical damping of the inertia on its bristles.
                let compliance = 2e-3 * machine.amplitude() / coulomb;
                Self::Presliding {
                    compliance,
                    damping: (machine.inertia / compliance).sqrt(),
                    speed: 5e-3 * machine.speed,
                }
            }
        }
    }

    /// The same effect with its strength multiplied by `factor`; widths, periods, places, times
    /// and the speeds of a shape stay.
    pub fn scaled(mut self, factor: f64) -> Self {
        match &mut self {
            Self::AsymmetricViscous { forward, backward } => {
                *forward *= factor;
                *backward *= factor;
            }
            Self::AsymmetricCoulomb { ratio: strength }
            | Self::OffsetTorque { torque: strength }
            | Self::Stribeck { drop: strength, .. }
            | Self::QuadraticDrag {
                coefficient: strength,
            }
            | Self::Spring {
                stiffness: strength,
                ..
            }
            | Self::Cogging {
                amplitude: strength,
                ..
            }
            | Self::LoadDependentFriction { ratio: strength }
            | Self::InputDelay { seconds: strength }
            | Self::SensorDelay { seconds: strength }
            | Self::Backlash { width: strength }
            | Self::Compliance {
                trailing: strength, ..
            }
            | Self::TorqueSaturation { fall: strength }
            | Self::FrictionDrift { rate: strength }
            | Self::PositionDependentFriction {
                ratio: strength, ..
            }
            | Self::ExternalLoad {
                torque: strength, ..
            }
            | Self::SpeedBand {
                torque: strength, ..
            }
            | Self::RoughSpot {
                torque: strength, ..
            }
            | Self::Presliding {
                compliance: strength,
                ..
            } => *strength *= factor,
        }
        self
    }

    /// Seconds that it holds an input back.
    pub(crate) fn input_delay(&self) -> f64 {
        match self {
            Self::InputDelay { seconds } => *seconds,
            _ => 0.0,
        }
    }

    /// Seconds that it holds a position back.
    pub(crate) fn sensor_delay(&self) -> f64 {
        match self {
            Self::SensorDelay { seconds } => *seconds,
            _ => 0.0,
        }
    }

    /// Lost motion that it adds, rad or m.
    pub(crate) fn play(&self) -> f64 {
        match self {
            Self::Backlash { width } => *width,
            _ => 0.0,
        }
    }

    /// Which effect it is.
    pub fn kind(&self) -> EffectKind {
        match self {
            Self::AsymmetricCoulomb { .. } => EffectKind::AsymmetricCoulomb,
            Self::AsymmetricViscous { .. } => EffectKind::AsymmetricViscous,
            Self::OffsetTorque { .. } => EffectKind::OffsetTorque,
            Self::Stribeck { .. } => EffectKind::Stribeck,
            Self::QuadraticDrag { .. } => EffectKind::QuadraticDrag,
            Self::Spring { .. } => EffectKind::Spring,
            Self::Cogging { .. } => EffectKind::Cogging,
            Self::LoadDependentFriction { .. } => EffectKind::LoadDependentFriction,
            Self::InputDelay { .. } => EffectKind::InputDelay,
            Self::SensorDelay { .. } => EffectKind::SensorDelay,
            Self::Backlash { .. } => EffectKind::Backlash,
            Self::Compliance { .. } => EffectKind::Compliance,
            Self::TorqueSaturation { .. } => EffectKind::TorqueSaturation,
            Self::FrictionDrift { .. } => EffectKind::FrictionDrift,
            Self::PositionDependentFriction { .. } => EffectKind::PositionDependentFriction,
            Self::ExternalLoad { .. } => EffectKind::ExternalLoad,
            Self::SpeedBand { .. } => EffectKind::SpeedBand,
            Self::RoughSpot { .. } => EffectKind::RoughSpot,
            Self::Presliding { .. } => EffectKind::Presliding,
        }
    }
}
