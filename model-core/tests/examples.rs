//! The examples run to their end.

#[path = "../examples/effect_of_ones_own.rs"]
mod effect_of_ones_own;
#[path = "../examples/refit_friction.rs"]
mod refit_friction;
#[path = "../examples/step_a_plant.rs"]
mod step_a_plant;

#[test]
fn a_plant_is_stepped() {
    step_a_plant::main().unwrap();
}

#[test]
fn a_friction_is_estimated_anew() {
    refit_friction::main().unwrap();
}

/// The speed that it reaches is that of a closed form.
#[test]
fn an_effect_of_ones_own_acts() {
    effect_of_ones_own::main().unwrap();
}
