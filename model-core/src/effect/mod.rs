//! The catalogue of physical effects that a declared actuator may lack.
//!
//! One file an effect: its physics, its parameters with units and bounds, its source. To add one,
//! write its file and name it in the `catalogue!` line below; the tracing, the report and the
//! machine file's `declared_effects` then know it.
//!
//! An effect acts in one or both of two ways. *Bound* into the plant's parameters before the modes
//! are worked out, it keeps every mode affine and the step exact. *Held* over a step as a torque, a
//! friction level or a voltage, evaluated in the middle of the step, it is of second order in the step.

mod bounds;
pub mod harmonic;
pub(crate) mod lanes;
pub mod learned_map;
pub mod twins;

pub use self::bounds::Bounds;
use self::compliance::{Shaft, Twist};
use self::encoder_eccentricity::EncoderEccentricity;
use self::lanes::Middles;
use self::learned_map::Kind;
use self::presliding::Bristles;
use crate::plant::actuator::Load;
use crate::plant::actuator::lanes::Loads;
use crate::plant::lanes::Lanes;
use crate::plant::parameters::Parameters;
use crate::unit::Dimension;

/// Most parameters that one effect has.
pub const MOST_PARAMETERS: usize = 7;

/// Most of them that are strengths.
pub const MOST_STRENGTHS: usize = 3;

/// Most of them that are shapes.
pub const MOST_SHAPES: usize = 2;

/// The values of an effect of which the first are given; the rest are 0.
///
/// ```
/// assert_eq!(model_core::effect::padded([0.5])[..3], [0.5, 0.0, 0.0]);
/// ```
pub const fn padded<const N: usize>(first: [f32; N]) -> [f32; MOST_PARAMETERS] {
    let mut values = [0.0; MOST_PARAMETERS];
    let (head, _) = values.split_at_mut(N);
    head.copy_from_slice(&first);
    values
}

/// What an effect is, for people and for the tracing.
#[derive(Debug, Clone, Copy)]
pub struct Description {
    /// The contract's id.
    pub id: &'static str,
    /// What it adds.
    pub summary: Summary,
    /// Where the law comes from.
    pub source: &'static str,
    /// Its parameters in the order of its values; strengths come first.
    pub parameters: &'static [Parameter],
    /// What is reported of it, where that is more readable than its parameters. How much acts comes first; where, when and at
    /// what speed it does is behind that.
    pub reported: &'static [(&'static str, Dimension)],
    /// Whether it needs an angle as coordinate.
    pub rotary_only: bool,
}

/// What an effect adds, in one sentence.
#[derive(Debug, Clone, Copy)]
pub enum Summary {
    /// Whatever the coordinate.
    Same(&'static str),
    /// For an angle, whose loads are torques, and for a length, whose loads are forces.
    ByCoordinate {
        /// With an angle.
        angle: &'static str,
        /// With a length.
        length: &'static str,
    },
}

impl Summary {
    /// The sentence for an angle (`rotary`) or a length as coordinate.
    ///
    /// ```
    /// use model_core::effect::Id;
    /// let summary = Id::Spring.description().summary;
    /// assert_eq!(summary.of(true), "a torque proportional to the position");
    /// assert_eq!(summary.of(false), "a force proportional to the position");
    /// ```
    pub fn of(self, rotary: bool) -> &'static str {
        match self {
            Self::Same(sentence) => sentence,
            Self::ByCoordinate { angle, length } => {
                if rotary {
                    angle
                } else {
                    length
                }
            }
        }
    }
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Name, as in a machine file.
    pub name: &'static str,
    /// Its dimension.
    pub dimension: Dimension,
    /// Whether the effect is proportional to it.
    pub role: Role,
    /// What physics lets it be, for whoever declares it and for a fit alike.
    pub bounds: Bounds,
}

/// What a parameter does to its effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The effect vanishes with it.
    Strength,
    /// It forms the effect: a speed, a period. Scanned over [`Effect::shapes`].
    Shape,
    /// A harmonic of a periodic effect above the first, behind its shapes. It is 0, and no part of a fit, unless the
    /// log asks for it or the machine file declares it.
    Overtone,
}

/// What a log and the declared machine say about sensible sizes, to scale strengths and scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scope {
    /// Coulomb friction, or a tenth of the motor torque's rms where there is none.
    pub friction: f32,
    /// Root mean square of the motor torque.
    pub torque: f32,
    /// Root mean square of the speed while moving.
    pub speed: f32,
    /// Stroke: largest less smallest position.
    pub stroke: f32,
    /// Root mean square of the input's voltage, V; of the torque that it asks for with a torque input.
    pub voltage: f32,
    /// Root mean square of the motor's current, A; of its torque with a torque input.
    pub current: f32,
    /// Sampling period, s.
    pub period: f32,
    /// Length of the longest log, s.
    pub seconds: f32,
    /// Whether the coordinate is an angle.
    pub rotary: bool,
    /// Way of the coordinate in which the position sensor's disc turns once, at most, rad or m; infinite where nothing is known of
    /// it.
    pub encoder_turn: f32,
}

/// Typical sizes that a fit looks within.
pub const REACH: f32 = 20.0;

impl Scope {
    /// Where what acts is as large as the motor's torque, if that is more than the declared friction: a load may be a hundred times that.
    pub fn strong(&self) -> Self {
        Self {
            friction: self.friction.max(self.torque),
            ..*self
        }
    }
}

/// Longest delay of a drive or a sensor, s: beyond it a position loop would hardly be stable.
pub const LONGEST_DELAY: f32 = 0.25;

/// The `index`-th delay that a fit starts from: a quarter of a sample, and factors of two from there, which lie near enough for a
/// fit to find the rest. A base that is fitted without a long delay bends to it, and asks for a negative one.
fn delay_start(scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
    let shortest = 0.25 * scope.period;
    let delays = core::iter::successors(Some(shortest), |delay| Some(2.0 * delay));
    let mut delays = delays.take_while(|&delay| delay < LONGEST_DELAY);
    delays.nth(index).map(|delay| padded([delay]))
}

/// What lies before the plant, and behind it up to the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Chain {
    /// Time by which the drive acts late, s.
    pub input_delay: f32,
    /// Time by which the position is reported late, s.
    pub sensor_delay: f32,
    /// Full width of the play before the sensor, rad or m; `None` without one. With a width of zero
    /// replays start as with a play, and the sensor reports what the drive does.
    pub play: Option<f32>,
    /// What friction yields by before it slides. With a compliance of 0 replays start as with it, and
    /// friction is rigid.
    pub bristles: Option<Bristles>,
    /// What lies behind an elastic shaft; without trailing there is none.
    pub shaft: Shaft,
    /// How the sensor errs.
    pub reading: EncoderEccentricity,
    /// Whether the winding's resistance is one that heats.
    pub heats: bool,
    /// Way over which the deflection of a hysteresis follows the motion, rad or m; `None` without one.
    pub reach: Option<f32>,
}

/// What a model's effects remember from one step to the next.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Memory {
    /// Where the far side of the play is, rad or m.
    pub far: f32,
    /// Force of the bristles, positive against forward motion, N·m or N.
    pub friction: f32,
    /// The far side of the shaft beside the drive.
    pub twist: Twist,
    /// Share by which warmth has raised the winding's resistance.
    pub warmth: f32,
    /// Deflection that a hysteresis depends on, rad or m.
    pub deflection: f32,
}

/// The actuator in the middle of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Middle {
    /// Motor torque or force, as the declared torque constant has it.
    pub motor_torque: f32,
    /// Declared torque constant, N·m/A or N/A, with which the winding's back-EMF goes; 0 with a torque
    /// input, which has no winding.
    pub torque_constant: f32,
    /// Winding resistance without what warmth adds to it, Ω; 0 with a torque input.
    pub resistance: f32,
    /// Share by which warmth has raised it.
    pub warmth: f32,
    /// Voltage that the input asks for, V.
    pub voltage: f32,
    /// The winding's voltage beyond the one that leaves no current in the end of the step, V.
    pub excess: f32,
    /// Velocity.
    pub velocity: f32,
    /// Position.
    pub position: f32,
    /// Deflection that a hysteresis depends on.
    pub deflection: f32,
    /// Time since the log began at the beginning of the sample that the step is a part of, s.
    pub time: f32,
    /// Length of that sample, s.
    pub step: f32,
}

impl Middle {
    /// Current of the winding, A. With a torque input nobody asks for it.
    #[inline]
    pub fn current(&self) -> f32 {
        self.motor_torque / self.torque_constant
    }
}

/// A physical effect with its parameters.
pub trait Effect: Copy {
    /// What it is.
    const DESCRIPTION: Description;

    /// Whether [`Effect::hold`] does anything.
    const HELD: bool = false;

    /// Whether it remembers the last clear motion, which no measured state restores: its replays run in
    /// from there.
    const STATEFUL: bool = false;

    /// Whether a base that is fitted without it bends to it, so that a screening may not see it: it is
    /// refitted whatever its score.
    const BIASES_BASE: bool = false;

    /// Whether it is the first terms of any law of its variable, so that a learned map may be the
    /// better answer.
    const EXPANSION: bool = false;

    /// The learned map that has its variable and acts as it does, where there is one.
    const MAP: Option<Kind> = None;

    /// Whether [`Effect::voltage`] is anything but zero.
    const ELECTRIC: bool = false;

    /// Whether it needs a winding, which a torque input does not have.
    const NEEDS_WINDING: bool = false;

    /// Whether its strengths are an error of the position's reading: one below half a count of the sensor
    /// is the sensor's rounding.
    const MISREADS: bool = false;

    /// From values in the order of the description's parameters.
    fn new(values: [f32; MOST_PARAMETERS]) -> Self;

    /// Typical size of the `index`-th strength: what a fit steps by.
    fn scale(scope: &Scope, index: usize) -> f32;

    /// How far from 0 a fit looks for the `index`-th strength, as far as its bounds allow that.
    fn reach(scope: &Scope, index: usize) -> f32 {
        REACH * Self::scale(&scope.strong(), index)
    }

    /// The largest value that a fit lets a shape parameter have: beyond it a log does not show what the effect is.
    fn largest_shape(_scope: &Scope) -> f32 {
        f32::INFINITY
    }

    /// The `index`-th value to try for the shape parameter; `None` behind the last.
    fn shape(_scope: &Scope, _index: usize) -> Option<f32> {
        None
    }

    /// The same for all of its shape parameters, where there are several.
    fn shapes(scope: &Scope, index: usize) -> Option<[f32; MOST_SHAPES]> {
        Self::shape(scope, index).map(|shape| [shape, 0.0])
    }

    /// The `index`-th values to try, where a small strength does not tell what a large one does; `None`
    /// behind the last, and always where it does. Such an effect has one strength.
    fn trial(_scope: &Scope, _index: usize) -> Option<[f32; MOST_PARAMETERS]> {
        None
    }

    /// The `index`-th values that fits start from, where the base bends to it; `None` behind the last.
    fn start(scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
        Self::trial(scope, index)
    }

    /// Writes its affine part into the plant, and what it puts before or behind it into the chain.
    fn bind(&self, _plant: &mut Parameters, _chain: &mut Chain) {}

    /// From when to when it acts, s since the log began, if it does not act throughout. Its shapes
    /// are then its end and its duration.
    fn span(&self) -> Option<(f32, f32)> {
        None
    }

    /// Adds its torque or friction to what is held over a step.
    fn hold(&self, _middle: &Middle, _load: &mut Load) {}

    /// Voltage that it adds to the input's over a step, V. With a torque input nobody asks for it.
    fn voltage(&self, _middle: &Middle) -> f32 {
        0.0
    }

    /// The values of the description's `reported` list, for an actuator with these parameters
    /// before the effect is bound.
    fn report(&self, plant: &Parameters) -> [f32; MOST_PARAMETERS];
}

macro_rules! catalogue {
    ($($module:ident :: $name:ident),* $(,)?) => {
        $(pub mod $module;)*

        /// An effect of the catalogue.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub enum Id {
            $(#[doc = concat!("See [`", stringify!($module), "`].")] $name),*
        }

        impl Id {
            /// Every effect, in the order in which equal candidates are preferred.
            pub const ALL: &'static [Self] = &[$(Self::$name),*];

            /// How many of them a base bends to that is fitted without.
            pub const BIASING: usize = 0 $(+ $module::$name::BIASES_BASE as usize)*;

            /// What the effect is.
            // Inlined, each caller's part of the program has a catalogue of its own.
            #[inline(never)]
            pub fn description(self) -> &'static Description {
                match self { $(Self::$name => &$module::$name::DESCRIPTION),* }
            }

            /// Typical size of its `index`-th strength.
            pub fn scale(self, scope: &Scope, index: usize) -> f32 {
                match self { $(Self::$name => $module::$name::scale(scope, index)),* }
            }

            /// How far from 0 a fit looks for its `index`-th strength, as far as its bounds allow that.
            pub fn reach(self, scope: &Scope, index: usize) -> f32 {
                match self { $(Self::$name => $module::$name::reach(scope, index)),* }
            }

            /// The largest value that a fit lets a shape parameter have.
            pub fn largest_shape(self, scope: &Scope) -> f32 {
                match self { $(Self::$name => $module::$name::largest_shape(scope)),* }
            }

            /// Whether it remembers the last clear motion, which no measured state restores.
            pub fn is_stateful(self) -> bool {
                match self { $(Self::$name => $module::$name::STATEFUL),* }
            }

            /// Whether a base that is fitted without it bends to it.
            pub fn biases_base(self) -> bool {
                match self { $(Self::$name => $module::$name::BIASES_BASE),* }
            }

            /// Whether it is the first terms of any law of its variable.
            pub fn is_expansion(self) -> bool {
                match self { $(Self::$name => $module::$name::EXPANSION),* }
            }

            /// The learned map that has its variable and acts as it does, where there is one.
            pub fn map(self) -> Option<Kind> {
                match self { $(Self::$name => $module::$name::MAP),* }
            }

            /// The `index`-th values to try for its shape parameters; the rest are 0.
            pub fn shapes(self, scope: &Scope, index: usize) -> Option<[f32; MOST_SHAPES]> {
                match self { $(Self::$name => $module::$name::shapes(scope, index)),* }
            }

            /// Whether it needs a winding, which a torque input does not have.
            pub fn needs_winding(self) -> bool {
                match self { $(Self::$name => $module::$name::NEEDS_WINDING),* }
            }

            /// Whether its strengths are an error of the position's reading.
            pub fn misreads(self) -> bool {
                match self { $(Self::$name => $module::$name::MISREADS),* }
            }

            /// The `index`-th values to try, where a small strength does not tell what a large
            /// one does.
            pub fn trial(self, scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
                match self { $(Self::$name => $module::$name::trial(scope, index)),* }
            }

            /// The `index`-th values that fits start from, where the base bends to it; `None` behind the last.
            pub fn start(self, scope: &Scope, index: usize) -> Option<[f32; MOST_PARAMETERS]> {
                match self { $(Self::$name => $module::$name::start(scope, index)),* }
            }
        }

        /// An effect with its values bound to its law.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Law {
            $(#[doc = concat!("See [`", stringify!($module), "`].")] $name($module::$name)),*
        }

        impl Law {
            fn new(id: Id, values: [f32; MOST_PARAMETERS]) -> Self {
                match id { $(Id::$name => Self::$name($module::$name::new(values))),* }
            }

            /// Whether it acts through [`Law::hold`] or [`Law::voltage`].
            pub fn is_held(&self) -> bool {
                self.is_electric() || match self { $(Self::$name(_) => $module::$name::HELD),* }
            }

            /// Whether it acts on the winding's voltage.
            pub fn is_electric(&self) -> bool {
                match self { $(Self::$name(_) => $module::$name::ELECTRIC),* }
            }

            /// From when to when it acts, s since the log began, if it does not act throughout.
            pub fn span(&self) -> Option<(f32, f32)> {
                match self { $(Self::$name(effect) => effect.span()),* }
            }

            /// Writes its affine part into the plant and the chain.
            pub fn bind(&self, plant: &mut Parameters, chain: &mut Chain) {
                match self { $(Self::$name(effect) => effect.bind(plant, chain)),* }
            }

            fn report(&self, plant: &Parameters) -> [f32; MOST_PARAMETERS] {
                match self { $(Self::$name(effect) => effect.report(plant)),* }
            }

            /// Adds the effect to what is held over a step.
            #[inline]
            pub fn hold(&self, middle: &Middle, load: &mut Load) {
                match self { $(Self::$name(effect) => effect.hold(middle, load)),* }
            }

            /// Voltage that it adds to the input's over a step.
            #[inline]
            pub fn voltage(&self, middle: &Middle) -> f32 {
                match self { $(Self::$name(effect) => effect.voltage(middle)),* }
            }

            /// As [`Law::hold`], in all lanes.
            #[inline(always)]
            pub(crate) fn hold_all<const N: usize>(&self, middles: &Middles<N>, loads: &mut Loads<N>) {
                match self { $(Self::$name(effect) => for lane in 0..N {
                    let mut load = loads.at(lane);
                    effect.hold(&middles.at(lane), &mut load);
                    loads.put(lane, &load);
                }),* }
            }

            /// As [`Law::voltage`], in all lanes.
            #[inline(always)]
            pub(crate) fn voltages<const N: usize>(&self, middles: &Middles<N>) -> Lanes<N> {
                let mut voltages = [0.0; N];
                match self { $(Self::$name(effect) => for lane in 0..N {
                    voltages[lane] = effect.voltage(&middles.at(lane));
                }),* }
                voltages
            }
        }
    };
}

catalogue! {
    offset_torque::OffsetTorque,
    asymmetric_coulomb::AsymmetricCoulomb,
    asymmetric_viscous::AsymmetricViscous,
    quadratic_drag::QuadraticDrag,
    stribeck::Stribeck,
    load_dependent_friction::LoadDependentFriction,
    spring::Spring,
    gravity::Gravity,
    cogging::Cogging,
    input_delay::InputDelay,
    sensor_delay::SensorDelay,
    backlash::Backlash,
    torque_saturation::TorqueSaturation,
    friction_drift::FrictionDrift,
    position_dependent_friction::PositionDependentFriction,
    external_load::ExternalLoad,
    presliding::Presliding,
    supply_sag::SupplySag,
    brush_drop::BrushDrop,
    dead_time::DeadTime,
    encoder_eccentricity::EncoderEccentricity,
    thermal_drift::ThermalDrift,
    compliance::Compliance,
    hysteresis::Hysteresis,
}

impl Id {
    /// The effect with this id.
    pub fn from_id(id: &str) -> Option<Self> {
        Self::ALL
            .iter()
            .copied()
            .find(|effect| effect.description().id == id)
    }

    /// Number of parameters, without overtones.
    pub fn parameters(self) -> usize {
        self.with_roles(&[Role::Strength, Role::Shape])
    }

    /// Number of strengths; they come first among the parameters.
    pub fn strengths(self) -> usize {
        self.with_roles(&[Role::Strength])
    }

    fn with_roles(self, roles: &[Role]) -> usize {
        let parameters = self.description().parameters.iter();
        parameters.filter(|it| roles.contains(&it.role)).count()
    }
}

/// An effect in a model: which, and the values of its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Active {
    /// Which effect.
    pub id: Id,
    /// Its values, in the order of its description; the rest are 0.
    pub values: [f32; MOST_PARAMETERS],
}

impl Active {
    /// An effect with the first of its values, in the order of its description; the rest are 0.
    pub const fn new<const N: usize>(id: Id, first: [f32; N]) -> Self {
        Self {
            id,
            values: padded(first),
        }
    }

    /// With strengths of the other sign where they may not be negative and are.
    pub fn with_allowed_signs(mut self) -> Self {
        let parameters = self.id.description().parameters;
        for (value, parameter) in self.values.iter_mut().zip(parameters) {
            if !parameter.bounds.are_signed() {
                *value = value.abs();
            }
        }
        self
    }

    /// Whether its `index`-th parameter is one of its law as it stands: an overtone of 0 is not.
    pub fn has(&self, index: usize) -> bool {
        let parameters = self.id.description().parameters;
        parameters
            .get(index)
            .is_some_and(|parameter| parameter.role != Role::Overtone || self.values[index] != 0.0)
    }

    /// The values of its overtones; nothing for an effect that may have none.
    pub fn overtones(&self) -> &[f32] {
        let parameters = self.id.description().parameters;
        let overtones = parameters.iter().filter(|it| it.role == Role::Overtone);
        &self.values[parameters.len() - overtones.count()..parameters.len()]
    }

    /// Names and dimensions of the reported values: those of overtones, which come last, only where it has some.
    ///
    /// ```
    /// use model_core::effect::{Active, Id};
    /// let mut cogging = Active::new(Id::Cogging, [0.2, 0.0, 0.6]);
    /// assert_eq!(cogging.reported().len(), 3);
    /// cogging.values[3] = 0.05;
    /// assert_eq!(cogging.reported()[3].0, "second_harmonic");
    /// ```
    pub fn reported(&self) -> &'static [(&'static str, Dimension)] {
        let reported = self.id.description().reported;
        let overtones = self.overtones();
        if overtones.iter().any(|&value| value != 0.0) {
            reported
        } else {
            // An amplitude is reported of a sine and a cosine.
            &reported[..reported.len() - overtones.len() / 2]
        }
    }

    /// Its law with these values.
    pub fn law(&self) -> Law {
        Law::new(self.id, self.values)
    }

    /// The reported values on an actuator with these parameters.
    pub fn report(&self, plant: &Parameters) -> [f32; MOST_PARAMETERS] {
        self.law().report(plant)
    }
}
