//! The rig's truth in the words of the catalogue.

use model_core::effect::gravity::Gravity;
use model_core::effect::{Active, Id};
use rig::{Effect, Machine, Motor};

use super::cases::Case;

/// The effect as the catalogue has it; `None` for one that it has not, or has in other numbers.
pub fn active(effect: &Effect, rig: &Machine) -> Option<Active> {
    let id = Id::from_id(effect.kind().id()?)?;
    let values = match *effect {
        Effect::AsymmetricCoulomb { ratio } => [ratio * rig.coulomb, 0.0, 0.0],
        Effect::AsymmetricViscous { forward, backward } => [0.5 * (forward - backward), 0.0, 0.0],
        Effect::OffsetTorque { torque } => [torque, 0.0, 0.0],
        Effect::Stribeck { drop, speed } => [drop, speed, 0.0],
        Effect::QuadraticDrag { coefficient } => [coefficient, 0.0, 0.0],
        Effect::Spring { stiffness, rest } => [stiffness, stiffness * rest, 0.0],
        Effect::Gravity { torque, rest } => {
            let [sine, cosine, ..] = Gravity::values(torque as f32, rest as f32);
            [f64::from(sine), f64::from(cosine), 0.0]
        }
        Effect::Cogging {
            amplitude,
            period,
            phase,
        } => [amplitude * phase.cos(), amplitude * phase.sin(), period],
        Effect::LoadDependentFriction { ratio } => [ratio, 0.0, 0.0],
        Effect::InputDelay { seconds } | Effect::SensorDelay { seconds } => [seconds, 0.0, 0.0],
        Effect::FrictionDrift { rate } => [rate, 0.0, 0.0],
        Effect::PositionDependentFriction {
            ratio,
            period,
            phase,
        } => {
            let amplitude = ratio * rig.coulomb;
            [amplitude * phase.cos(), amplitude * phase.sin(), period]
        }
        Effect::ExternalLoad {
            torque,
            begin,
            duration,
            ..
        } => [torque, begin + duration, duration],
        Effect::Presliding {
            compliance, speed, ..
        } => [compliance, speed, 0.0],
        Effect::SupplySag {
            voltage,
            resistance,
            ..
        } => [resistance / voltage.powi(2), 0.0, 0.0],
        Effect::BrushDrop { drop: volts, .. } | Effect::DeadTime { loss: volts, .. } => {
            [volts, 0.0, 0.0]
        }
        Effect::Backlash { width } => [width, 0.0, 0.0],
        Effect::TorqueSaturation { fall } => [fall, 0.0, 0.0],
        Effect::ThermalDrift { rate, winding, .. } => [rate, winding, 0.0],
        Effect::Compliance {
            share,
            trailing,
            damping,
        } => [trailing, share, damping],
        Effect::EncoderEccentricity {
            amplitude,
            period,
            phase,
        } => [amplitude * phase.cos(), amplitude * phase.sin(), period],
        Effect::Hysteresis { torque, reach } => [torque, reach, 0.0],
        _ => return None,
    };
    Some(Active::new(id, values.map(|value| value as f32)))
}

/// Numbers that an answer may estimate, by the names that it gives them, whichever of equivalent effects
/// it names. Only those that mean the same on the rig and in the model.
pub fn numbers(case: &Case) -> Vec<(&'static str, f64)> {
    let rig = &case.rig;
    let mut numbers = vec![("inertia", rig.inertia)];
    if case.effects.is_empty() {
        numbers.extend([("viscous", rig.viscous), ("coulomb", rig.coulomb)]);
        if let Motor::Winding {
            resistance,
            torque_constant,
            ..
        } = rig.motor
        {
            numbers.extend([
                ("resistance", resistance),
                ("torque_constant", torque_constant),
            ]);
        }
    }
    for effect in &case.effects {
        match *effect {
            Effect::AsymmetricCoulomb { ratio } => numbers.extend([
                ("forward", rig.coulomb * (1.0 + ratio)),
                ("backward", rig.coulomb * (1.0 - ratio)),
                ("torque", -ratio * rig.coulomb),
            ]),
            Effect::AsymmetricViscous { forward, backward } => numbers.extend([
                ("forward", rig.viscous + forward),
                ("backward", rig.viscous + backward),
            ]),
            Effect::OffsetTorque { torque } => numbers.extend([
                ("torque", torque),
                ("forward", rig.coulomb - torque),
                ("backward", rig.coulomb + torque),
            ]),
            Effect::Stribeck { drop, speed } => {
                numbers.extend([("drop", drop), ("velocity", speed)]);
            }
            Effect::QuadraticDrag { coefficient } => numbers.push(("coefficient", coefficient)),
            Effect::Spring { stiffness, rest } => {
                numbers.extend([("stiffness", stiffness), ("rest", rest)]);
            }
            Effect::Gravity { torque, .. } => numbers.push(("torque", torque)),
            Effect::Cogging {
                amplitude, period, ..
            } => numbers.extend([("amplitude", amplitude), ("period", period)]),
            Effect::LoadDependentFriction { ratio } => numbers.push(("share", ratio)),
            Effect::InputDelay { seconds } | Effect::SensorDelay { seconds } => {
                numbers.push(("delay", seconds));
            }
            Effect::FrictionDrift { rate } => numbers.push(("rate", rate)),
            Effect::PositionDependentFriction { ratio, period, .. } => {
                numbers.extend([("amplitude", ratio * rig.coulomb), ("period", period)]);
            }
            Effect::ExternalLoad { torque, .. } => numbers.push(("torque", torque)),
            Effect::Presliding { compliance, .. } => numbers.push(("compliance", compliance)),
            Effect::SupplySag {
                voltage,
                resistance,
                ..
            } => numbers.push(("share", resistance / voltage.powi(2))),
            Effect::Backlash { width } => numbers.push(("width", width)),
            Effect::TorqueSaturation { fall } => numbers.push(("fall", fall)),
            Effect::BrushDrop { drop: volts, .. } | Effect::DeadTime { loss: volts, .. } => {
                numbers.extend([("drop", volts), ("loss", volts)]);
            }
            Effect::ThermalDrift { rate, .. } => numbers.push(("rate", rate)),
            Effect::Compliance { trailing, .. } => numbers.push(("trailing", trailing)),
            Effect::EncoderEccentricity {
                amplitude, period, ..
            } => numbers.extend([("amplitude", amplitude), ("period", period)]),
            _ => {}
        }
    }
    numbers
}
