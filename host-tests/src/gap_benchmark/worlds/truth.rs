//! A world's truth in the words of the catalogue.

use std::f64::consts::TAU;

use model_core::effect::gravity::Gravity;
use model_core::effect::{Active, Id};
use rig::world::{Along, Course, Fall, InputKind, Kind, Law, Ripple, Saturation, Side, World};

use crate::gap_benchmark::cases::Group;
use crate::gap_benchmark::judgement::Truth;

/// What carries each law that the catalogue has not, and which names say it fairly.
///
/// - A hysteresis over the position is the catalogue's, by name, and Dahl's presliding with a longer reach: the same
///   differential equation.
/// - A current limit is a motor whose torque stops growing with what is asked of it.
/// - A rough spot is friction over position, if not a periodic one.
/// - A warm-up is a friction that drifts, if not evenly.
/// - A crank and a band of speeds have no neighbour: `gravity`, `stribeck` say what is not so. So does the `spring` of
///   the catalogue of a cubic one, unless its law was learned (`other_law`).
fn outside(law: &Law) -> (&'static [&'static str], &'static [&'static str]) {
    match law {
        Law::Hysteresis { .. } => (&["position"], &["hysteresis", "presliding"]),
        Law::CubicSpring { .. } => (&["position"], &[]),
        Law::CurrentLimit { .. } => (&["current", "load"], &["torque_saturation"]),
        Law::CrankInertia { .. } => (&["position"], &[]),
        Law::RoughSpot { .. } => (&["position"], &["position_dependent_friction"]),
        Law::SpeedBand { .. } => (&["velocity"], &[]),
        Law::WarmUp { .. } => (&["time"], &["friction_drift"]),
        _ => (&[], &[]),
    }
}

/// The effect of the catalogue that a law is another law of: the same mechanism over the same variable.
fn other_law(law: &Law) -> Option<&'static str> {
    matches!(law, Law::CubicSpring { .. }).then_some("spring")
}

/// What an answer may say of a world.
pub fn of(world: &World) -> Truth {
    let outside = world.laws.iter().map(outside);
    let names = world.declaration.factors.iter().map(|(name, _)| *name);
    Truth {
        group: match world.kind {
            Kind::OneEffect => Group::Named,
            Kind::TwoEffects => Group::Two,
            Kind::Outside => Group::Outside,
            Kind::None | Kind::NoneWithSins => Group::Clean,
            Kind::Misdeclared => Group::WrongNumbers,
        },
        ids: world
            .laws
            .iter()
            .map(|law| law.label().to_owned())
            .collect(),
        carriers: outside
            .clone()
            .flat_map(|(carriers, _)| carriers.to_vec())
            .collect(),
        fair: outside
            .flat_map(|(_, fair)| fair.to_vec())
            .chain(stands_for(world))
            .collect(),
        other_law: world.laws.iter().filter_map(other_law).collect(),
        // A filter before the log is a sensor that reports late.
        tolerated: if world.sins.filter > 0.0 {
            vec!["sensor_delay"]
        } else {
            Vec::new()
        },
        wrong_numbers: names
            .filter(|name| world.misdeclares(name))
            .map(str::to_owned)
            .collect(),
        outside_fit: world.kind == Kind::Misdeclared,
    }
}

/// The effect that says the same as a wrong number: more or less of what is declared.
fn stands_for(world: &World) -> Option<&'static str> {
    let declaration = &world.declaration;
    let outside_fit = |name| !declaration.fit.contains(&name) && world.misdeclares(name);
    let wrong = |name| world.kind == Kind::Misdeclared && outside_fit(name);
    if wrong("spring") {
        Some("spring")
    } else {
        wrong("gravity_torque").then_some("gravity")
    }
}

/// The law as the catalogue's formula comes nearest to it; `None` for one that it has not. A fit told the
/// truth starts from there.
pub fn active(law: &Law, world: &World) -> Option<Active> {
    let id = Id::from_id(law.id()?)?;
    let coulomb = world.machine.coulomb;
    let seconds = world.rows as f64 / world.rate;
    let wave = |amplitude: f64, ripple: &Ripple| {
        let (sine, cosine) = ripple.phase.sin_cos();
        [amplitude * cosine, amplitude * sine, ripple.period]
    };
    let values = match *law {
        Law::Stribeck { fall, drop, speed } => {
            // The speed at which the exponential has lost as much as the other curves at theirs, about.
            let factor = match fall {
                Fall::Exponential => 1.0,
                Fall::Gaussian => 0.8,
                Fall::Rational => 1.2,
            };
            [drop, factor * speed, 0.0]
        }
        Law::AsymmetricCoulomb { difference } => [difference, 0.0, 0.0],
        Law::AsymmetricViscous { forward, backward } => [0.5 * (forward - backward), 0.0, 0.0],
        Law::LoadDependentFriction { share, .. } => [share, 0.0, 0.0],
        Law::PositionDependentFriction { level, along } => match along {
            Along::Added(ripple) => wave(level, &ripple),
            Along::Multiplied(ripple) => wave(level * coulomb, &ripple),
            Along::Slope { centre, reach } => {
                // A sine of four strokes, about straight within one.
                let period = 8.0 * reach;
                let ripple = Ripple {
                    period,
                    phase: -TAU * centre / period,
                    harmonics: [0.0; 2],
                };
                wave(level * period / (TAU * reach), &ripple)
            }
        },
        Law::FrictionDrift { rate, .. } => [rate, 0.0, 0.0],
        Law::Presliding {
            stiffness, speed, ..
        } => [1.0 / stiffness, speed, 0.0],
        Law::QuadraticDrag { torque, speed, .. } => [torque / speed.powi(2), 0.0, 0.0],
        Law::OffsetTorque { torque } => [torque, 0.0, 0.0],
        Law::Spring { stiffness, rest } => [stiffness, stiffness * rest, 0.0],
        Law::Gravity { torque, rest } => {
            let [sine, cosine, ..] = Gravity::values(torque as f32, rest as f32);
            [f64::from(sine), f64::from(cosine), 0.0]
        }
        Law::Cogging { amplitude, ripple } => wave(amplitude, &ripple),
        Law::ExternalLoad { torque, course } => {
            let (begin, end) = acts(course, seconds);
            [torque, end, end - begin]
        }
        Law::SupplySag {
            resistance,
            voltage,
            ..
        } => [resistance / voltage.powi(2), 0.0, 0.0],
        Law::BrushDrop { volts, .. } | Law::DeadTime { volts, .. } => [volts, 0.0, 0.0],
        Law::TorqueSaturation { law, level, .. } => {
            // The fall that leaves as much at the law's level.
            let left = law.left(1.0);
            [(1.0 / left - 1.0) / level, 0.0, 0.0]
        }
        Law::ThermalDrift { rate, winding, .. } => [rate, winding, 0.0],
        Law::InputDelay { seconds } | Law::SensorDelay { seconds } => [seconds, 0.0, 0.0],
        Law::EncoderEccentricity { amplitude, ripple } => wave(amplitude, &ripple),
        Law::Backlash { width, .. } => [width, 0.0, 0.0],
        Law::Compliance(joint) => {
            let inertia = world.machine.inertia * joint.inertia;
            let critical = 2.0 * (joint.stiffness * inertia).sqrt();
            [
                inertia / joint.stiffness,
                joint.inertia,
                joint.damping / critical,
            ]
        }
        _ => return None,
    };
    let mut active = Active::new(id, values.map(|value| value as f32));
    if let Law::Cogging { amplitude, ripple } = law {
        active.values[3..].copy_from_slice(&overtones(*amplitude, ripple));
    }
    Some(active)
}

/// Sine and cosine of the second and the third harmonic of a ripple of this amplitude, as [`Ripple::at`] has them.
fn overtones(amplitude: f64, ripple: &Ripple) -> [f32; 4] {
    let [second, third] = ripple.harmonics.map(|share| share * amplitude);
    let (sine_2, cosine_2) = (2.0 * ripple.phase + 1.0).sin_cos();
    let (sine_3, cosine_3) = (3.0 * ripple.phase + 2.0).sin_cos();
    [
        second * cosine_2,
        second * sine_2,
        third * cosine_3,
        third * sine_3,
    ]
    .map(|value| value as f32)
}

/// The one span of time that comes nearest to a course.
fn acts(course: Course, seconds: f64) -> (f64, f64) {
    match course {
        Course::Pulse {
            begin, duration, ..
        } => (begin, begin + duration),
        Course::Periodic { period, phase } => {
            let begin = period * (1.0 - phase.rem_euclid(1.0));
            (begin, begin + 0.5 * period)
        }
        Course::Ramp { begin, end } => (0.5 * (begin + end), seconds),
    }
}

/// Numbers that an answer may estimate, by the names that it gives them; only those that mean the same in
/// the world and in the model.
pub fn numbers(world: &World) -> Vec<(&'static str, f64)> {
    let machine = &world.machine;
    let mut numbers = Vec::new();
    let mut base = |names: &[&'static str]| {
        for &name in names {
            numbers.extend(machine.number(name).map(|value| (name, value)));
        }
    };
    let crank = |law: &Law| matches!(law, Law::CrankInertia { .. });
    if !world.laws.iter().any(crank) {
        base(&["inertia"]);
    }
    if world.laws.is_empty() {
        base(&["viscous", "coulomb"]);
        if machine.input == InputKind::Voltage {
            base(&["resistance", "torque_constant"]);
        }
    }
    for law in &world.laws {
        of_law(law, world, &mut numbers);
    }
    numbers
}

/// Numbers of one law.
fn of_law(law: &Law, world: &World, numbers: &mut Vec<(&'static str, f64)>) {
    match *law {
        Law::OffsetTorque { torque } => {
            let coulomb = world.machine.coulomb;
            numbers.extend([
                ("torque", torque),
                ("forward", coulomb - torque),
                ("backward", coulomb + torque),
            ]);
        }
        Law::Spring { stiffness, rest } => {
            numbers.extend([("stiffness", stiffness), ("rest", rest)]);
        }
        Law::Gravity { torque, .. } => numbers.push(("torque", torque)),
        Law::Cogging { amplitude, ripple } | Law::EncoderEccentricity { amplitude, ripple } => {
            numbers.push(("period", ripple.period));
            if ripple.harmonics == [0.0; 2] {
                numbers.push(("amplitude", amplitude));
            }
        }
        Law::InputDelay { seconds } | Law::SensorDelay { seconds } => {
            numbers.push(("delay", seconds));
        }
        Law::ExternalLoad {
            torque,
            course: Course::Pulse { .. },
        } => numbers.push(("torque", torque)),
        Law::SupplySag {
            resistance,
            voltage,
            lag: 0.0,
        } => numbers.push(("share", resistance / voltage.powi(2))),
        Law::BrushDrop { volts, .. } | Law::DeadTime { volts, .. } => {
            numbers.extend([("drop", volts), ("loss", volts)]);
        }
        Law::TorqueSaturation {
            law: Saturation::Froelich,
            level,
            emf: true,
        } => numbers.push(("fall", 1.0 / level)),
        Law::ThermalDrift {
            rate,
            growing: true,
            ..
        } => numbers.push(("rate", rate)),
        Law::Backlash { width, .. } => numbers.push(("width", width)),
        Law::Compliance(joint) if joint.sensor == Side::Load && joint.friction == 0.0 => {
            let inertia = world.machine.inertia * joint.inertia;
            numbers.push(("trailing", inertia / joint.stiffness));
        }
        _ => of_friction(law, world, numbers),
    }
}

/// The same of laws of friction.
fn of_friction(law: &Law, world: &World, numbers: &mut Vec<(&'static str, f64)>) {
    let (coulomb, viscous) = (world.machine.coulomb, world.machine.viscous);
    match *law {
        Law::AsymmetricCoulomb { difference } => numbers.extend([
            ("forward", coulomb + difference),
            ("backward", coulomb - difference),
            ("torque", -difference),
        ]),
        Law::AsymmetricViscous { forward, backward } => numbers.extend([
            ("forward", viscous + forward),
            ("backward", viscous + backward),
        ]),
        Law::Stribeck {
            fall: Fall::Exponential,
            drop,
            speed,
        } => numbers.extend([("drop", drop), ("velocity", speed)]),
        Law::QuadraticDrag {
            torque,
            speed,
            exponent: 2.0,
        } => numbers.push(("coefficient", torque / speed.powi(2))),
        Law::PositionDependentFriction {
            level,
            along: Along::Added(ripple),
        } if ripple.harmonics == [0.0; 2] => {
            numbers.extend([("amplitude", level.abs()), ("period", ripple.period)]);
        }
        Law::LoadDependentFriction {
            share,
            preload: 0.0,
        } => {
            numbers.push(("share", share));
        }
        Law::FrictionDrift {
            rate,
            viscous: false,
        } => numbers.push(("rate", rate)),
        Law::Presliding { stiffness, .. } => numbers.push(("compliance", 1.0 / stiffness)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use rig::world::{Kind, World};

    use super::{active, of, outside};
    use crate::gap::declared;
    use crate::gap_benchmark::worlds::traced::{log_of, machine_of};
    use crate::machine::Machine;

    /// Files of worlds are a user's, and what fits are told is a model.
    #[test]
    fn worlds_are_read_and_their_truth_can_be_told() {
        for index in 0..25 {
            let (world, records) = World::draw(21, index);
            let machine: Machine = machine_of(&world).unwrap();
            let other = log_of(&world, &records[1], 1).unwrap();
            assert_eq!(other.samples(), world.rows, "{index}");
            let mut model = declared::model(&machine).unwrap();
            for law in &world.laws {
                if let Some(active) = active(law, &world) {
                    assert_eq!(Some(active.id.description().id), law.id());
                    model.effects.push(active).unwrap();
                } else {
                    assert_eq!(world.kind, Kind::Outside);
                    assert!(!outside(law).0.is_empty(), "{}", law.label());
                }
            }
            model.build(other.period_s as f32).unwrap();
            assert_eq!(of(&world).ids.len(), world.laws.len());
        }
    }
}
