//! The catalogue of effects as a machine file declares them: parameters, units, bounds.

use model_core::effect::{Id, Parameter};

use super::effect_words::declared_by;

/// What a parameter may be, with its unit: `0 to 0.25, in s`.
pub fn values(parameter: &Parameter, rotary: bool) -> String {
    let bounds = parameter.bounds;
    match parameter.dimension.unit(rotary) {
        "1" => bounds.to_string(),
        unit => format!("{bounds}, in {unit}"),
    }
}

/// An effect's parameters and what each may be.
pub fn parameters(id: Id, rotary: bool) -> String {
    let parameters = id.description().parameters.iter();
    let named =
        parameters.map(|parameter| format!("{} ({})", parameter.name, values(parameter, rotary)));
    named.collect::<Vec<_>>().join(", ")
}

/// Every effect with what it adds and its parameters, in the units of an angle.
pub fn text() -> String {
    let title = "What can be found, and what `declared_effects` of a machine file takes (along a \
                 stroke N for N·m and m for rad):";
    Id::ALL.iter().fold(title.to_owned(), |text, &id| {
        let description = id.description();
        let angle = if description.rotary_only {
            ", rotary only"
        } else {
            ""
        };
        let winding = if id.needs_winding() {
            ", voltage input only"
        } else {
            ""
        };
        let meaning = declared_by(id).map_or(String::new(), |words| format!("\n      {words}"));
        format!(
            "{text}\n  {}: {}{angle}{winding}\n      {}{meaning}",
            description.id,
            description.summary.of(true),
            parameters(id, true)
        )
    })
}
