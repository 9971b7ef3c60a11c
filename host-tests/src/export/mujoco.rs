//! A MuJoCo model, MJCF: one body on a hinge or a slide, and an actuator with the gain and the back-EMF of its winding.

use std::fmt::Write as _;

use model_core::effect::Id;
use model_core::plant::Directional;
use model_core::plant::parameters::{Drive, Parameters};

use super::{Missing, Source};
use crate::machine::Coordinate;
use crate::outputs::MARK;

/// Standard gravity, m/s²: what an unbalanced load is made of has no other place for it.
const GRAVITY: f64 = 9.806_65;

/// Mass of a body that nothing pulls at, kg: it turns about its centre, and only its inertia counts.
const MASS: f64 = 1.0;

/// Integration step, s.
const STEP: &str = "0.0001";

/// Effects that are in the numbers of joint, body and actuator.
const EXPRESSED: [Id; 3] = [Id::OffsetTorque, Id::Spring, Id::Gravity];

/// Effects of which the mean of both directions is.
const BY_MEAN: [Id; 2] = [Id::AsymmetricCoulomb, Id::AsymmetricViscous];

/// What MJCF's own numbers are.
struct Numbers {
    damping: f64,
    friction: f64,
    stiffness: f64,
    reference: f64,
    /// Torque or force for one unit of input.
    gain: f64,
    /// Constant torque or force.
    offset: f64,
    /// Torque or force for one unit of velocity.
    braking: f64,
}

/// The text, and what is not in it.
pub(super) fn text(source: &Source) -> (String, Vec<Missing>) {
    let plant = source.model.bound_plant();
    let (numbers, mut missing) = numbers(source, &plant);
    missing.extend(missing_of_effects(source));
    let mut text = format!("<!-- {MARK} export: {} -->\n", source.name());
    for missing in &missing {
        let _ = writeln!(text, "<!-- NOT EXPRESSED: {} -->", missing.what);
    }
    text += &model(source, &plant, &numbers);
    (text, missing)
}

fn f(value: f32) -> f64 {
    crate::quantity::decimal(value)
}

fn mean(level: Directional) -> f64 {
    0.5 * (f(level.forward) + f(level.backward))
}

fn numbers(source: &Source, plant: &Parameters) -> (Numbers, Vec<Missing>) {
    let mut missing = Vec::new();
    let mut miss = |what: String| missing.push(Missing { line: None, what });
    let (gain, braking) = match plant.drive {
        Drive::Voltage {
            resistance,
            inductance,
            torque_constant,
        } => {
            if inductance > 0.0 {
                miss(format!(
                    "the winding's inductance of {:?} H is neglected: the current follows the voltage at once",
                    f(inductance)
                ));
            }
            let (resistance, constant) = (f(resistance), f(torque_constant));
            (
                f(plant.gain) * constant / resistance,
                -constant * constant / resistance,
            )
        }
        Drive::Torque => (f(plant.gain), 0.0),
    };
    let (coulomb, breakaway) = (mean(plant.coulomb), mean(plant.breakaway));
    if breakaway > coulomb {
        miss(format!(
            "static friction of {breakaway:?} above the Coulomb friction of {coulomb:?}: frictionloss has one level"
        ));
    }
    if coulomb > 0.0 {
        miss("rest under friction: frictionloss is a soft constraint, which creeps".into());
    }
    if plant.lower_stop.is_finite() || plant.upper_stop.is_finite() {
        miss("inelastic end stops: a limit of a joint is a soft constraint, which gives way and rebounds".into());
    }
    if plant.lower_stop.is_finite() != plant.upper_stop.is_finite() {
        miss("a single end stop: the other end of the range is far away".into());
    }
    if source.machine.resolution.is_some() {
        miss("the sensor's `resolution`: the reported position is not rounded".into());
    }
    let (stiffness, rest) = (f(plant.spring), f(plant.spring_rest));
    let mut offset = f(plant.offset);
    // Where the spring rests at a stop or beyond, its preload has one sign all along the stroke: a constant.
    let side = if f(plant.lower_stop) >= rest {
        1.0
    } else if f(plant.upper_stop) <= rest {
        -1.0
    } else {
        0.0
    };
    let preload = f(plant.spring_preload);
    if side == 0.0 && preload > 0.0 {
        miss(format!(
            "the spring's preload of {preload:?} on either side of its rest: a joint's spring has no step"
        ));
    }
    offset -= side * preload;
    let numbers = Numbers {
        damping: mean(plant.viscous),
        friction: coulomb,
        stiffness,
        reference: rest,
        gain,
        offset,
        braking,
    };
    (numbers, missing)
}

fn missing_of_effects(source: &Source) -> Vec<Missing> {
    let effects = source.model.effects.iter().map(|effect| effect.id);
    effects
        .filter(|id| !EXPRESSED.contains(id))
        .map(|id| {
            if BY_MEAN.contains(&id) {
                source.effect_missing(
                    id,
                    "a joint has one friction for both directions, here their mean",
                )
            } else {
                source.effect_missing(id, "MJCF has no element for it")
            }
        })
        .collect()
}

/// Torque of all unbalanced loads together at a right angle to hanging, and where they hang.
fn hanging(source: &Source) -> (f64, f64) {
    let model = &source.model;
    let (torque, rest) = (f(model.gravity_torque), f(model.gravity_rest));
    // −a sin θ − b cos θ = −G sin(θ − rest).
    let (mut sine, mut cosine) = (torque * rest.cos(), -torque * rest.sin());
    for effect in model
        .effects
        .iter()
        .filter(|effect| effect.id == Id::Gravity)
    {
        sine += f(effect.values[0]);
        cosine += f(effect.values[1]);
    }
    (sine.hypot(cosine), (-cosine).atan2(sine))
}

/// The body's mass, its inertia about its centre, and where that is.
fn inertial(source: &Source, inertia: f64) -> String {
    let (torque, rest) = hanging(source);
    if source.machine.coordinate == Coordinate::Metre {
        return format!("<inertial pos=\"0 0 0\" mass=\"{inertia:?}\" diaginertia=\"1 1 1\"/>");
    }
    if torque == 0.0 {
        return format!(
            "<inertial pos=\"0 0 0\" mass=\"{MASS:?}\" diaginertia=\"{inertia:?} {inertia:?} {inertia:?}\"/>"
        );
    }
    // A mass m at the distance c with m g c = G, and m c² half of the inertia: the rest is about its centre.
    let distance = 0.5 * inertia * GRAVITY / torque;
    let mass = torque / (GRAVITY * distance);
    let (x, z) = (distance * rest.sin(), -distance * rest.cos());
    let own = 0.5 * inertia;
    format!(
        "<inertial pos=\"{x:?} 0 {z:?}\" mass=\"{mass:?}\" diaginertia=\"{own:?} {own:?} {own:?}\"/>"
    )
}

fn model(source: &Source, plant: &Parameters, numbers: &Numbers) -> String {
    let Numbers {
        damping,
        friction,
        stiffness,
        reference,
        gain,
        offset,
        braking,
    } = numbers;
    let kind = match source.machine.coordinate {
        Coordinate::Radian => "hinge",
        Coordinate::Metre => "slide",
    };
    let gravity = if source.machine.coordinate == Coordinate::Radian {
        GRAVITY
    } else {
        0.0
    };
    let range = if plant.lower_stop.is_finite() || plant.upper_stop.is_finite() {
        let end = |stop: f32| {
            if stop.is_finite() {
                f(stop)
            } else {
                1e6_f64.copysign(stop.into())
            }
        };
        format!(
            " limited=\"true\" range=\"{:?} {:?}\"",
            end(plant.lower_stop),
            end(plant.upper_stop)
        )
    } else {
        String::new()
    };
    format!(
        "<mujoco model=\"{name}\">\n  <compiler angle=\"radian\" autolimits=\"false\"/>\n  <option timestep=\"{STEP}\" \
         integrator=\"implicitfast\" gravity=\"0 0 -{gravity:?}\"/>\n  <worldbody>\n    <body name=\"load\">\n      \
         {inertial}\n      <joint name=\"axis\" type=\"{kind}\" axis=\"0 1 0\" damping=\"{damping:?}\" \
         frictionloss=\"{friction:?}\" stiffness=\"{stiffness:?}\" springref=\"{reference:?}\"{range}/>\n    </body>\n  \
         </worldbody>\n  <actuator>\n    <!-- ctrl is the input; force = gain * ctrl + offset + braking * velocity -->\n    \
         <general name=\"motor\" joint=\"axis\" gaintype=\"fixed\" gainprm=\"{gain:?}\" biastype=\"affine\" \
         biasprm=\"{offset:?} 0 {braking:?}\"/>\n  </actuator>\n  <sensor>\n    <jointpos name=\"position\" \
         joint=\"axis\"/>\n    <jointvel name=\"velocity\" joint=\"axis\"/>\n  </sensor>\n</mujoco>\n",
        name = source.name(),
        inertial = inertial(source, f(plant.inertia)),
    )
}
