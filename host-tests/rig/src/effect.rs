//! What a rig can have that its machine file does not say.

use crate::machine::{Coordinate, Machine, Motor};
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
    /// An unbalanced load on a horizontal axis: −torque · sin(x − rest).
    Gravity {
        /// At a right angle to hanging, N·m.
        torque: f64,
        /// Where it hangs, rad.
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
    /// The bridge gives its duty's share of a supply that is charged through a resistance. Needs a
    /// winding with inductance, as all that acts on its voltage.
    SupplySag {
        /// Voltage of the supply without load, V.
        voltage: f64,
        /// Ω.
        resistance: f64,
        /// Of the capacitor at the bridge, F, positive.
        capacity: f64,
    },
    /// Voltage lost at the brushes: drop · (1 − exp(−|i| / knee)) against the current.
    BrushDrop {
        /// V.
        drop: f64,
        /// Current at which most of it is there, A, positive.
        knee: f64,
    },
    /// Voltage lost in the bridge's dead time, against the current; at most what the drive was told.
    /// A current within its own ripple changes its sign in every period and loses in proportion.
    DeadTime {
        /// V.
        loss: f64,
        /// Half the current's ripple, A, positive.
        ripple: f64,
    },
    /// The winding's resistance grows by rate · i²R for each second and R, and passes its heat to the
    /// housing, which has ten times its heat capacity.
    ThermalDrift {
        /// Growth of a cold winding's resistance, as a share of it, 1/(A²·s).
        rate: f64,
        /// Time constant of the winding against the housing, s, positive.
        winding: f64,
        /// Time constant of the housing against the air, s, positive.
        housing: f64,
    },
    /// The encoder's disc turns about a point beside its centre: it reports the position and
    /// amplitude · sin(2π x / period + phase).
    EncoderEccentricity {
        /// rad or m.
        amplitude: f64,
        /// rad or m, positive.
        period: f64,
        /// rad.
        phase: f64,
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
    /// A rubber mount beside the friction: a load z with dz/dx = −(torque + sign(v) z) / reach, that
    /// remembers where the motion last turned (P. R. Dahl, *A Solid Friction Model*, 1968). No entry
    /// of the catalogue gives way over so long a way.
    Hysteresis {
        /// What it comes to far from the last turn, N·m or N.
        torque: f64,
        /// Way in which it comes near to that, rad or m, positive.
        reach: f64,
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
    /// [`Effect::Gravity`]
    Gravity,
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
    /// [`Effect::SupplySag`]
    SupplySag,
    /// [`Effect::BrushDrop`]
    BrushDrop,
    /// [`Effect::DeadTime`]
    DeadTime,
    /// [`Effect::ThermalDrift`]
    ThermalDrift,
    /// [`Effect::EncoderEccentricity`]
    EncoderEccentricity,
    /// [`Effect::SpeedBand`]
    SpeedBand,
    /// [`Effect::RoughSpot`]
    RoughSpot,
    /// [`Effect::Presliding`]
    Presliding,
    /// [`Effect::Hysteresis`]
    Hysteresis,
}

impl EffectKind {
    /// Every kind that a rig can carry.
    pub const ALL: [Self; 26] = [
        Self::AsymmetricCoulomb,
        Self::AsymmetricViscous,
        Self::OffsetTorque,
        Self::Stribeck,
        Self::QuadraticDrag,
        Self::Spring,
        Self::Gravity,
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
        Self::SupplySag,
        Self::BrushDrop,
        Self::DeadTime,
        Self::ThermalDrift,
        Self::EncoderEccentricity,
        Self::SpeedBand,
        Self::RoughSpot,
        Self::Presliding,
        Self::Hysteresis,
    ];

    /// The id in the catalogue of effects. `None` for [`EffectKind::SpeedBand`] and [`EffectKind::RoughSpot`], which are
    /// there to be unknown.
    pub fn id(self) -> Option<&'static str> {
        match self {
            Self::AsymmetricCoulomb => Some("asymmetric_coulomb"),
            Self::AsymmetricViscous => Some("asymmetric_viscous"),
            Self::OffsetTorque => Some("offset_torque"),
            Self::Stribeck => Some("stribeck"),
            Self::QuadraticDrag => Some("quadratic_drag"),
            Self::Spring => Some("spring"),
            Self::Gravity => Some("gravity"),
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
            Self::SupplySag => Some("supply_sag"),
            Self::BrushDrop => Some("brush_drop"),
            Self::DeadTime => Some("dead_time"),
            Self::ThermalDrift => Some("thermal_drift"),
            Self::EncoderEccentricity => Some("encoder_eccentricity"),
            Self::Presliding => Some("presliding"),
            Self::Hysteresis => Some("hysteresis"),
            Self::SpeedBand | Self::RoughSpot => None,
        }
    }

    /// Whether this machine can have it: what acts on a winding needs one, and a load hangs on an
    /// axis.
    pub fn can_act_on(self, machine: &Machine) -> bool {
        match self {
            Self::SupplySag | Self::BrushDrop | Self::DeadTime | Self::ThermalDrift => {
                matches!(machine.motor, Motor::Winding { .. })
            }
            Self::Gravity => machine.coordinate == Coordinate::Radian,
            _ => true,
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
            // Off the middle, as a lever is mounted for its work.
            EffectKind::Gravity => Self::Gravity {
                torque: 0.2 * coulomb,
                rest: machine.centre() - 0.6,
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
            EffectKind::SupplySag => Self::SupplySag {
                voltage: machine.input_limit,
                resistance: 0.6 * machine.resistance(),
                capacity: 1e-3,
            },
            EffectKind::BrushDrop => Self::BrushDrop {
                drop: 0.015 * machine.input_limit,
                knee: 4e-3 * machine.input_limit / machine.resistance(),
            },
            EffectKind::DeadTime => Self::DeadTime {
                loss: 0.015 * machine.input_limit,
                ripple: 4e-3 * machine.input_limit / machine.resistance(),
            },
            EffectKind::ThermalDrift => {
                // A tenth after a few seconds under the load of friction and spring.
                let load = coulomb + machine.spring.map_or(0.0, |spring| spring.preload);
                let current = load / machine.torque_constant();
                Self::ThermalDrift {
                    rate: 0.04 / current.powi(2),
                    winding: 5.0,
                    housing: 120.0,
                }
            }
            EffectKind::EncoderEccentricity => {
                // An encoder that turns once on the stroke at least, behind a gear if need be.
                let stroke = 2.0 * machine.amplitude();
                let period = if machine.coordinate == Coordinate::Radian && stroke > TAU {
                    TAU
                } else {
                    0.2 * stroke
                };
                Self::EncoderEccentricity {
                    amplitude: (5e-3 * period).max(2.0 * machine.resolution),
                    period,
                    phase: TAU / 7.0,
                }
            }
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
            EffectKind::Hysteresis => Self::Hysteresis {
                torque: 0.4 * coulomb,
                reach: 0.2 * machine.amplitude(),
            },
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
            | Self::Gravity {
                torque: strength, ..
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
            | Self::SupplySag {
                resistance: strength,
                ..
            }
            | Self::BrushDrop { drop: strength, .. }
            | Self::DeadTime { loss: strength, .. }
            | Self::ThermalDrift { rate: strength, .. }
            | Self::EncoderEccentricity {
                amplitude: strength,
                ..
            }
            | Self::SpeedBand {
                torque: strength, ..
            }
            | Self::RoughSpot {
                torque: strength, ..
            }
            | Self::Hysteresis {
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

    /// What an encoder at `position` reports beyond it, rad or m.
    pub(crate) fn reading_error(&self, position: f64) -> f64 {
        match self {
            Self::EncoderEccentricity {
                amplitude,
                period,
                phase,
            } => amplitude * (TAU * position / period + phase).sin(),
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
            Self::Gravity { .. } => EffectKind::Gravity,
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
            Self::SupplySag { .. } => EffectKind::SupplySag,
            Self::BrushDrop { .. } => EffectKind::BrushDrop,
            Self::DeadTime { .. } => EffectKind::DeadTime,
            Self::ThermalDrift { .. } => EffectKind::ThermalDrift,
            Self::EncoderEccentricity { .. } => EffectKind::EncoderEccentricity,
            Self::SpeedBand { .. } => EffectKind::SpeedBand,
            Self::RoughSpot { .. } => EffectKind::RoughSpot,
            Self::Presliding { .. } => EffectKind::Presliding,
            Self::Hysteresis { .. } => EffectKind::Hysteresis,
        }
    }
}
