//! The examples run to their end.

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
