//! The exported MJCF: well-formed, with the machine file's numbers, which are worked out here anew, and with what is not in it.

use rig::Machine;
use roxmltree::{Document, Node};

use super::drive::{export, text};

/// The exported model, and what was said of it.
fn exported(toml: &str) -> (String, String) {
    let directory = tempfile::tempdir().unwrap();
    let output = export(directory.path(), toml, &["mujoco"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    (
        text(&output.stdout).to_owned(),
        text(&output.stderr).to_owned(),
    )
}

fn element<'a>(document: &'a Document, name: &str) -> Node<'a, 'a> {
    let mut found = document
        .descendants()
        .filter(|node| node.has_tag_name(name));
    let one = found.next().unwrap_or_else(|| panic!("no {name}"));
    assert!(found.next().is_none(), "two {name}");
    one
}

fn numbers(node: Node, attribute: &str) -> Vec<f64> {
    let value = node
        .attribute(attribute)
        .unwrap_or_else(|| panic!("no {attribute}"));
    value
        .split(' ')
        .map(|number| number.parse().unwrap())
        .collect()
}

#[track_caller]
fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        // The model core holds single precision.
        let off = (found - expected).abs();
        assert!(off <= 2e-7 * expected.abs() + 1e-15, "{found} {expected}");
    }
}

/// A throttle body: R = 2 Ω, k = 0.38 N·m/A, a spring that rests within the stroke.
#[test]
fn a_throttle_has_its_numbers() {
    let (printed, said) = exported(&Machine::throttle().to_toml());
    let document = Document::parse(&printed).unwrap();
    let joint = element(&document, "joint");
    assert_eq!(joint.attribute("type"), Some("hinge"));
    near(&numbers(joint, "damping"), &[8e-3]);
    near(&numbers(joint, "frictionloss"), &[0.24]);
    near(&numbers(joint, "stiffness"), &[0.25]);
    near(&numbers(joint, "springref"), &[0.2]);
    near(&numbers(joint, "range"), &[0.02, 1.57]);
    near(
        &numbers(element(&document, "inertial"), "diaginertia"),
        &[1.6e-3; 3],
    );
    let motor = element(&document, "general");
    near(&numbers(motor, "gainprm"), &[0.19]);
    near(&numbers(motor, "biasprm"), &[0.0, 0.0, -0.0722]);
    assert_eq!(
        element(&document, "compiler").attribute("angle"),
        Some("radian")
    );
    for what in [
        "inductance of 0.0012 H",
        "static friction of 0.28",
        "preload of 0.3",
        "end stops",
        "`resolution`",
    ] {
        assert!(said.contains(what), "no {what} in {said}");
        assert!(printed.contains(what), "no {what} in {printed}");
    }
    assert!(
        said.lines()
            .all(|line| line.starts_with("warning: machine.toml: in `mujoco`, ")),
        "{said}"
    );
}

/// A flap that its spring holds at the lower stop: the preload pulls one way all along, −0.22 N·m.
#[test]
fn a_preload_at_a_stop_is_a_constant_torque() {
    let (printed, said) = exported(&Machine::swirl_flap().to_toml());
    let document = Document::parse(&printed).unwrap();
    near(
        &numbers(element(&document, "general"), "biasprm"),
        &[-0.22, 0.0, -0.05],
    );
    assert!(!said.contains("preload"), "{said}");
}

/// A slide of 95 kg, 35 N for each unit of input, and no winding.
#[test]
fn a_slide_has_its_numbers() {
    let (printed, said) = exported(&Machine::force_slide().to_toml());
    let document = Document::parse(&printed).unwrap();
    let joint = element(&document, "joint");
    assert_eq!(joint.attribute("type"), Some("slide"));
    near(&numbers(element(&document, "inertial"), "mass"), &[95.0]);
    near(
        &numbers(element(&document, "option"), "gravity"),
        &[0.0, 0.0, 0.0],
    );
    let motor = element(&document, "general");
    near(&numbers(motor, "gainprm"), &[35.0]);
    near(&numbers(motor, "biasprm"), &[0.0, 0.0, 0.0]);
    assert!(joint.attribute("range").is_none() && !said.contains("inductance"));
}

/// The body's mass hangs so that gravity turns it as the catalogue's law does, −a sin θ − b cos θ, and its inertia about the
/// axis is the machine's; offset and spring are in the joint and the actuator; other effects are named with their lines.
#[test]
fn effects_are_in_the_numbers_or_named() {
    let (sine, cosine) = (0.03, -0.04);
    let toml = format!(
        "{}declared_effects = [\n{{ id = \"gravity\", sine = {sine}, cosine = {cosine} }},\n{{ id = \"spring\", stiffness = 0.5, \
         torque = 0.1 }},\n{{ id = \"offset_torque\", torque = 0.01 }},\n{{ id = \"asymmetric_viscous\", difference = 1e-4 \
         }},\n{{ id = \"brush_drop\", drop = 0.2 }},\n]\n",
        Machine::rotary_ema().to_toml()
    );
    let (printed, said) = exported(&toml);
    let document = Document::parse(&printed).unwrap();
    let body = element(&document, "inertial");
    let (place, mass) = (numbers(body, "pos"), numbers(body, "mass")[0]);
    let down = numbers(element(&document, "option"), "gravity")[2];
    for angle in [-2.0, -0.3, 0.0, 1.0, 2.5_f64] {
        // Turned about y by the angle, the mass is at x; gravity's torque about y there is −x · (its force along z).
        let x = place[0] * angle.cos() + place[2] * angle.sin();
        near(
            &[-x * mass * down],
            &[-sine * angle.sin() - cosine * angle.cos()],
        );
    }
    let about_axis = numbers(body, "diaginertia")[1] + mass * (place[0].powi(2) + place[2].powi(2));
    near(&[about_axis], &[1.2e-4]);
    let (joint, motor) = (element(&document, "joint"), element(&document, "general"));
    near(&numbers(joint, "stiffness"), &[0.5]);
    near(&numbers(joint, "springref"), &[0.0]);
    // 0.06 N·m/A on 1 Ω.
    near(&numbers(motor, "biasprm"), &[0.11, 0.0, -0.0036]);
    near(&numbers(joint, "damping"), &[2e-4]);
    for id in ["asymmetric_viscous", "brush_drop"] {
        let line = toml.lines().position(|line| line.contains(id)).unwrap() + 1;
        let named = format!("effect `{id}` is not expressed");
        assert!(
            said.contains(&format!("machine.toml:{line}: in `mujoco`, {named}")),
            "{said}"
        );
        assert!(
            printed.contains(&format!("<!-- NOT EXPRESSED: {named}")),
            "{printed}"
        );
    }
    for id in ["gravity", "`spring`", "offset_torque"] {
        assert!(
            !said.contains(&format!("effect `{}`", id.trim_matches('`'))),
            "{said}"
        );
    }
}
