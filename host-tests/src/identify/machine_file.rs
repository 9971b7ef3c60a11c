//! Writes an identified machine as a machine file.

use model_core::plant::parameters::{Drive, Parameters};

use crate::machine::{Coordinate, Machine};
use crate::outputs::MARK;

/// What the six numbers say, to be fitted again before an effect is looked for.
const IDENTIFIED: [&str; 6] = [
    "inertia",
    "viscous",
    "spring",
    "spring_preload",
    "coulomb",
    "static",
];

/// The machine file of identified parameters; what was not identified is as declared.
pub(crate) fn text(declared: &Machine, parameters: &Parameters, note: &str) -> String {
    let (coordinate, kind) = (
        match declared.coordinate {
            Coordinate::Radian => "rad",
            Coordinate::Metre => "m",
        },
        if declared.motor.is_some() {
            "voltage"
        } else {
            "torque"
        },
    );
    let mut lines = vec![
        format!("# {MARK} identify: {note}."),
        format!("name = {:?}", declared.name),
        format!("coordinate = {coordinate:?}"),
        String::new(),
        "[input]".to_owned(),
        format!("kind = {kind:?}"),
        format!("gain = {:?}", declared.gain),
        String::new(),
    ];
    if let Drive::Voltage {
        resistance,
        inductance,
        torque_constant,
    } = parameters.drive
    {
        lines.extend([
            "[motor]".to_owned(),
            format!("resistance = {resistance:?}"),
            format!("inductance = {inductance:?}"),
            format!("torque_constant = {torque_constant:?}"),
            String::new(),
        ]);
    }
    lines.extend([
        "[mechanics]".to_owned(),
        format!("inertia = {:?}", parameters.inertia),
        format!("viscous = {:?}", parameters.viscous.forward),
        format!("spring = {:?}", parameters.spring),
        format!("spring_rest = {:?}", parameters.spring_rest),
        format!("spring_preload = {:?}", parameters.spring_preload),
    ]);
    for (name, stop) in [
        ("lower_stop", parameters.lower_stop),
        ("upper_stop", parameters.upper_stop),
    ] {
        if stop.is_finite() {
            lines.push(format!("{name} = {stop:?}"));
        }
    }
    lines.extend([
        String::new(),
        "[friction]".to_owned(),
        format!("coulomb = {:?}", parameters.coulomb.forward),
        format!("static = {:?}", parameters.breakaway.forward),
    ]);
    if let Some(resolution) = declared.resolution {
        lines.extend([
            String::new(),
            "[sensor]".to_owned(),
            format!("resolution = {resolution:?}"),
        ]);
    }
    lines.extend([
        String::new(),
        "[fit]".to_owned(),
        format!("parameters = {IDENTIFIED:?}"),
        "declared_effects = []".to_owned(),
        String::new(),
    ]);
    lines.join("\n")
}
