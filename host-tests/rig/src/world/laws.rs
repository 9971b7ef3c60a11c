//! What a world has beyond its declared machine: each effect in several laws, so that no formula of a
//! catalogue is the only truth.

use super::machine::Side;
use super::shapes::{Along, Course, Fall, Ripple, Saturation};

/// One law. Loads in N·m or N, positions in rad or m, times in s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Dry friction of `drop` more at rest than at speed.
    Stribeck {
        /// How it falls.
        fall: Fall,
        /// What is lost.
        drop: f64,
        /// Stribeck speed.
        speed: f64,
    },
    /// `difference` more dry friction forwards, and less backwards.
    AsymmetricCoulomb {
        /// Half of what the directions differ by.
        difference: f64,
    },
    /// Viscous friction of `forward` and `backward` more.
    AsymmetricViscous {
        /// N·m·s/rad or N·s/m.
        forward: f64,
        /// The same.
        backward: f64,
    },
    /// Friction grows by `share` of the motor's torque; beyond `preload` alone.
    LoadDependentFriction {
        /// 0 to 1.
        share: f64,
        /// Torque under which it hardly grows: √(T² + T₀²) − T₀.
        preload: f64,
    },
    /// Friction varies along the stroke.
    PositionDependentFriction {
        /// In the unit that `along` says.
        level: f64,
        /// How.
        along: Along,
    },
    /// Friction changes in proportion to the time.
    FrictionDrift {
        /// Share of the friction a second, 1/s.
        rate: f64,
        /// Whether viscous friction changes alike.
        viscous: bool,
    },
    /// Bristles that bend before they slide, Canudas de Wit 1995.
    Presliding {
        /// N·m/rad or N/m.
        stiffness: f64,
        /// N·m·s/rad or N·s/m; 0 is Dahl's law.
        damping: f64,
        /// Speed of the fall from breakaway to Coulomb friction.
        speed: f64,
    },
    /// A torque against the motion that grows with a power of the speed.
    QuadraticDrag {
        /// Torque at `speed`.
        torque: f64,
        /// rad/s or m/s.
        speed: f64,
        /// 2, or 1.75 of turbulent oil (Blasius).
        exponent: f64,
    },
    /// A constant load.
    OffsetTorque {
        /// Positive forwards.
        torque: f64,
    },
    /// Hooke.
    Spring {
        /// N·m/rad or N/m.
        stiffness: f64,
        /// rad or m.
        rest: f64,
    },
    /// An unbalanced load.
    Gravity {
        /// At a right angle to hanging.
        torque: f64,
        /// rad.
        rest: f64,
    },
    /// A torque periodic in position.
    Cogging {
        /// Amplitude of the fundamental.
        amplitude: f64,
        /// Where.
        ripple: Ripple,
    },
    /// A load that comes and goes.
    ExternalLoad {
        /// Positive forwards.
        torque: f64,
        /// When.
        course: Course,
    },
    /// The supply's voltage falls with the current drawn from it.
    SupplySag {
        /// Resistance of the supply, Ω.
        resistance: f64,
        /// Its voltage without a load, V.
        voltage: f64,
        /// Time constant of its capacitor, s; 0 for none.
        lag: f64,
    },
    /// Voltage lost at the brushes.
    BrushDrop {
        /// V.
        volts: f64,
        /// Current at which three quarters of it are lost, about, A.
        knee: f64,
    },
    /// Voltage lost in the bridge, never more than it gives.
    DeadTime {
        /// V.
        volts: f64,
        /// As of [`Law::BrushDrop`].
        knee: f64,
    },
    /// The motor's torque falls behind its constant.
    TorqueSaturation {
        /// How.
        law: Saturation,
        /// Torque of `x` = 1.
        level: f64,
        /// Whether the back-EMF falls alike.
        emf: bool,
    },
    /// The winding heats.
    ThermalDrift {
        /// Share of the resistance per A² and second.
        rate: f64,
        /// Thermal time constant, s.
        winding: f64,
        /// Whether the loss grows with the resistance.
        growing: bool,
    },
    /// The drive acts late.
    InputDelay {
        /// s.
        seconds: f64,
    },
    /// The sensor reports late.
    SensorDelay {
        /// s.
        seconds: f64,
    },
    /// A reading error periodic in position.
    EncoderEccentricity {
        /// Amplitude of the fundamental, rad or m.
        amplitude: f64,
        /// Where.
        ripple: Ripple,
    },
    /// A gap with an inertia and friction behind it, closed by a stiff and damped contact.
    Backlash {
        /// Full width, rad or m.
        width: f64,
        /// What is behind it.
        joint: Joint,
    },
    /// An elastic shaft with an inertia and friction behind it.
    Compliance(Joint),
    /// Outside the catalogue: a torque that follows the position with a memory (Bouc, Wen).
    Hysteresis {
        /// Largest torque.
        torque: f64,
        /// Travel in which it turns round, rad or m.
        reach: f64,
    },
    /// Outside the catalogue: a torque with the cube of the position.
    CubicSpring {
        /// Torque at one `reach` from `rest`.
        torque: f64,
        /// rad or m.
        reach: f64,
        /// rad or m.
        rest: f64,
    },
    /// Outside the catalogue: the drive lets no more than this torque's current flow.
    CurrentLimit {
        /// The motor's load at the limit.
        torque: f64,
    },
    /// Outside the catalogue: an inertia that varies with the position, as of a crank.
    CrankInertia {
        /// Amplitude, as a share of the inertia.
        share: f64,
        /// rad or m.
        period: f64,
        /// rad.
        phase: f64,
    },
    /// Outside the catalogue: more dry friction at one place.
    RoughSpot {
        /// At its middle.
        torque: f64,
        /// rad or m.
        centre: f64,
        /// Standard deviation of the bell, rad or m.
        width: f64,
    },
    /// Outside the catalogue: more dry friction in one band of speeds.
    SpeedBand {
        /// At its middle.
        torque: f64,
        /// rad/s or m/s.
        centre: f64,
        /// Standard deviation of the bell, rad/s or m/s.
        width: f64,
    },
    /// Outside the catalogue: friction that falls as the machine warms up, exponentially in time.
    WarmUp {
        /// Share of the friction that is lost in the end.
        share: f64,
        /// Time constant, s.
        seconds: f64,
    },
}

/// A second inertia behind a spring and a damper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// N·m/rad or N/m.
    pub stiffness: f64,
    /// N·m·s/rad or N·s/m.
    pub damping: f64,
    /// Share of the machine's inertia that is behind it, 0 to 1.
    pub inertia: f64,
    /// Share of its dry friction that is behind it, 0 to 1.
    pub friction: f64,
    /// Where the sensor sits.
    pub sensor: Side,
}

impl Law {
    /// The id in the catalogue of effects; `None` for what is outside it.
    pub fn id(&self) -> Option<&'static str> {
        Some(match self {
            Self::Stribeck { .. } => "stribeck",
            Self::AsymmetricCoulomb { .. } => "asymmetric_coulomb",
            Self::AsymmetricViscous { .. } => "asymmetric_viscous",
            Self::LoadDependentFriction { .. } => "load_dependent_friction",
            Self::PositionDependentFriction { .. } => "position_dependent_friction",
            Self::FrictionDrift { .. } => "friction_drift",
            Self::Presliding { .. } => "presliding",
            Self::QuadraticDrag { .. } => "quadratic_drag",
            Self::OffsetTorque { .. } => "offset_torque",
            Self::Spring { .. } => "spring",
            Self::Gravity { .. } => "gravity",
            Self::Cogging { .. } => "cogging",
            Self::ExternalLoad { .. } => "external_load",
            Self::SupplySag { .. } => "supply_sag",
            Self::BrushDrop { .. } => "brush_drop",
            Self::DeadTime { .. } => "dead_time",
            Self::TorqueSaturation { .. } => "torque_saturation",
            Self::ThermalDrift { .. } => "thermal_drift",
            Self::InputDelay { .. } => "input_delay",
            Self::SensorDelay { .. } => "sensor_delay",
            Self::EncoderEccentricity { .. } => "encoder_eccentricity",
            Self::Backlash { .. } => "backlash",
            Self::Compliance(_) => "compliance",
            _ => return None,
        })
    }

    /// Its name in tables: the catalogue's id, or what it is in parentheses.
    pub fn label(&self) -> &'static str {
        match self {
            Self::Hysteresis { .. } => "(hysteresis)",
            Self::CubicSpring { .. } => "(cubic_spring)",
            Self::CurrentLimit { .. } => "(current_limit)",
            Self::CrankInertia { .. } => "(crank_inertia)",
            Self::RoughSpot { .. } => "(rough_spot)",
            Self::SpeedBand { .. } => "(speed_band)",
            Self::WarmUp { .. } => "(warm_up)",
            _ => self.id().unwrap_or("(outside)"),
        }
    }

    /// What it has behind a joint, if it is one, and the width of its gap.
    pub fn joint(&self) -> Option<(Joint, f64)> {
        match *self {
            Self::Compliance(joint) => Some((joint, 0.0)),
            Self::Backlash { width, joint } => Some((joint, width)),
            _ => None,
        }
    }
}
