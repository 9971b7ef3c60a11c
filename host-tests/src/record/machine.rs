//! The machine file that a board's own parameters make.

use std::collections::BTreeMap;

use crate::failure::Failure;
use crate::outputs::MARK;

/// The file: each line is text, and where it ends with a name in braces, that parameter's value stands there.
const FILE: &str = r#"# The board's own parameters, as `show` gave them: what somebody set or stored there, or
# what the image came with. Nothing here was measured. Compare it with the motor's data sheet.
name = "board"
coordinate = "rad"

[input]
kind = "voltage"
gain = 1.0                    # the log's input is the voltage at the winding, V

[motor]
resistance = {resistance}     # Ω
inductance = {inductance}     # H
torque_constant = {torque_constant}   # N·m/A, and V·s/rad

[mechanics]
inertia = {inertia}           # kg·m²
viscous = {viscous}           # N·m·s/rad
spring = {spring}             # N·m/rad
spring_rest = {spring_rest}   # rad
spring_preload = {spring_preload}     # N·m
lower_stop = {lower_stop}     # rad; remove both stops where there are none
upper_stop = {upper_stop}     # rad

[friction]
coulomb = {coulomb}           # N·m
static = {static}             # N·m

[sensor]
resolution = {position_unit}  # rad a count

[fit]
parameters = ["inertia", "viscous", "coulomb", "static"]   # fitted before an effect is looked for
declared_effects = []
"#;

/// Its text.
///
/// # Errors
/// A parameter that the board does not have, or whose value is no number.
pub fn text(parameters: &BTreeMap<String, String>) -> Result<String, Failure> {
    let mut text = format!("# {MARK} record\n");
    let mut rest = FILE;
    while let Some((before, behind)) = rest.split_once('{') {
        text += before;
        let Some((name, behind)) = behind.split_once('}') else {
            break;
        };
        let value = parameters
            .get(name)
            .and_then(|value| value.parse::<f32>().ok());
        let value = value.ok_or_else(|| {
            Failure::other(format!(
                "the board does not show its {name}, which a machine file needs; flash an image of this version"
            ))
        })?;
        // The digits that give the board's value back.
        text += &format!("{value:?}");
        rest = behind;
    }
    text += rest;
    Ok(text)
}
