//! Promise: the two residuals that the bench paper leaves open are traced to their effects, and the model with
//! what was found is nearer to logs that nothing was fitted on.
//!
//! Seeds that nothing was chosen on, at every level of backlash. The rig shares no code with the core. At the widest
//! backlash the command's own logs are held to the same in `reproduce_bench`.

use host_tests::reproduce::bench::points::Compared;
use host_tests::reproduce::bench::residuals::{BeforeAfter, Residuals, run};
use rig::pmsm_bench::{BacklashLevel, Loss};

const SEED: u64 = 70_001;

/// Loss and backlash are named at every level of backlash, and no other loss.
fn names(residuals: &Residuals, id: &str) {
    for level in &residuals.traced {
        let named: Vec<&str> = level
            .outcome
            .effects
            .iter()
            .map(|it| it.id.as_str())
            .collect();
        let both = named.contains(&id) && named.contains(&"backlash");
        assert!(both, "{:?}: {named:?}", level.backlash);
        let losses = ["load_dependent_friction", "torque_saturation"];
        let count = named.iter().filter(|it| losses.contains(it)).count();
        assert_eq!(count, 1, "{:?}: {named:?}", level.backlash);
    }
}

fn worst(residuals: &Residuals, value: impl Fn(&Compared) -> f64) -> [f64; 2] {
    let over =
        |of: &dyn Fn(&BeforeAfter) -> f64| residuals.points.iter().map(of).fold(0.0, f64::max);
    [
        over(&|point| value(&point.before).abs()),
        over(&|point| value(&point.after).abs()),
    ]
}

/// The paper's limit on the position everywhere, a current that is wrong by a quarter of what it was, and
/// half the time by which the dead band is left too late or too early.
fn closes(residuals: &Residuals) {
    let [before, after] = worst(residuals, |it| it.current_shortfall);
    assert!(before > 0.35 && after < 0.25 * before, "{before} {after}");
    let [before, after] = worst(residuals, |it| it.lateness);
    assert!(after < 0.5 * before, "{before} {after}");
    let [_, after] = worst(residuals, |it| it.position.nrmse);
    assert!(after < 5e-3, "{after}");
}

#[test]
#[ignore = "at length"]
fn a_loss_in_the_transmission_is_found_and_closed() {
    let residuals = run(Loss::load_dependent(), &BacklashLevel::ALL, SEED).unwrap();
    names(&residuals, "load_dependent_friction");
    // 0.72 N·m of friction for 1 N·m that the brake takes is this share of the motor's torque.
    let share = 0.72 / 1.72;
    for level in &residuals.traced {
        let found = level.found.load_share;
        assert!((found - share).abs() < 0.05 * share, "{found}");
    }
    closes(&residuals);
}

#[test]
#[ignore = "at length"]
fn a_saturating_motor_is_found_and_closed() {
    let residuals = run(Loss::torque_saturation(), &BacklashLevel::ALL, SEED).unwrap();
    names(&residuals, "torque_saturation");
    for level in &residuals.traced {
        let found = level.found.saturation;
        assert!((found - 1.0).abs() < 0.05, "{found}");
    }
    closes(&residuals);
}
