//! The winding's heat outlives a start of the drive: I² t is reckoned here anew, in `f64`, from the current that flowed.

use crate::any_drive::{any_command, image, perform};
use firmware::app::fault::Fault;
use firmware::app::fault::overload::Heat;
use firmware::app::machine::EMA;
use firmware::app::timing::PLANT_PERIOD;
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};
use model_core::numeric::random::Random;
use model_core::plant::parameters::Parameters;

/// What the declared winding bears beyond its continuous current, A² s.
fn most() -> f64 {
    let [peak, continuous] =
        [EMA.limits.peak_current, EMA.limits.continuous_current].map(f64::from);
    (peak.powi(2) - continuous.powi(2)) * f64::from(EMA.limits.peak_time)
}

/// The winding's heat, as a share of what it bears.
struct Truth(f64);

impl Truth {
    fn take(&mut self, current: f32, seconds: f64) {
        let squares = f64::from(current).powi(2) - f64::from(EMA.limits.continuous_current).powi(2);
        self.0 = (self.0 + squares * seconds / most()).max(0.0);
    }

    /// Runs, until a fault is latched at the latest.
    fn run(&mut self, image: &mut OperationOnHost<Motor>, milliseconds: u32) {
        for _ in 0..20 * milliseconds {
            if image.wiring.latch().is_tripped() {
                return;
            }
            image.tick();
            self.take(image.plant.state.current, PLANT_PERIOD.into());
        }
    }
}

/// An actuator that its stops hold, at which any current is borne for as long as the winding bears it.
fn held() -> Parameters {
    Parameters {
        lower_stop: -1e-4,
        upper_stop: 1e-4,
        ..EMA.plant
    }
}

/// Presses with all that the supply drives, from the next tick on.
fn press(image: &mut OperationOnHost<Motor>) {
    perform(image, &["set load 3", "mode voltage", "arm"]);
    "step 0 24\r".bytes().for_each(|byte| image.byte(byte));
}

fn pressed(flash: &SharedFlash) -> OperationOnHost<Motor> {
    let mut image = OperationOnHost::controller(flash, &held());
    image.run_ms(20);
    press(&mut image);
    image
}

/// Resets at random times, ten to a run: whatever part of the peak's time each start uses, the sum is what is borne.
#[test]
fn a_reset_does_not_cool_the_winding() {
    for seed in 0..20 {
        let mut random = Random::new(seed, 1);
        let flash = SharedFlash::new();
        let mut truth = Truth(0.0);
        let mut starts = 0;
        let cause = loop {
            let mut image = pressed(&flash);
            starts += 1;
            truth.run(&mut image, (300.0 * random.uniform()) as u32);
            if let Some(cause) = image.wiring.fault() {
                break cause;
            }
            assert!(truth.0 < 1.2, "{seed}: {} and no fault", truth.0);
        };
        assert_eq!(cause, Fault::Overload, "{seed}");
        // Each start rounds what is kept up by 2/65,535 at most. Not in the sum are the 50 ms in which the winding cools before
        // it presses; and a reset takes the current of up to two control periods, which nobody has reckoned yet.
        let [limit, continuous] = [EMA.limits.current_limit, EMA.limits.continuous_current]
            .map(|current| f64::from(current).powi(2));
        let lost = 0.05 * continuous + 0.002 * (limit - continuous);
        let bound = f64::from(starts) * lost / most();
        let beyond = truth.0 - 1.0;
        assert!(
            (-0.005..bound + 0.005).contains(&beyond),
            "{seed}: {beyond}"
        );
        assert!(starts > 4, "{seed}: {starts}");
    }
}

#[test]
fn a_winding_that_was_too_hot_is_so_after_a_reset_until_it_has_cooled() {
    let flash = SharedFlash::new();
    let mut image = pressed(&flash);
    Truth(0.0).run(&mut image, 5000);
    assert_eq!(image.wiring.fault(), Some(Fault::Overload));
    // The tick behind the control step keeps what that found.
    image.run_ms(1);
    let continuous = f64::from(EMA.limits.continuous_current);
    let cooling = most() / continuous.powi(2);
    // Resets meanwhile change nothing: it is latched again, and cannot be cleared.
    let mut image = OperationOnHost::controller(&flash, &held());
    for start in 0..(0.95 * cooling / 0.5) as u32 {
        image = OperationOnHost::controller(&flash, &held());
        image.run_ms(500);
        image.line("clear");
        image.run_ms(5);
        assert_eq!(image.wiring.fault(), Some(Fault::Overload), "{start}");
    }
    image.run_ms((0.06 * cooling * 1e3) as u32);
    perform(&mut image, &["clear", "arm"]);
}

/// However hot the winding was when the supply went, and whatever is driven after it came back, it does not get hotter than
/// it bears; and no fault is made of heat that nobody measured.
#[test]
fn after_power_on_the_winding_gets_no_hotter_than_it_bears() {
    let (mut worst, mut overloads) = (0.0_f64, 0);
    for seed in 0..100 {
        let mut random = Random::new(seed, 2);
        let flash = SharedFlash::new();
        flash.lose_ram();
        let before = if seed % 2 == 0 {
            1.0
        } else {
            f64::from(random.uniform())
        };
        let mut truth = Truth(before);
        let is_held = seed % 4 < 2;
        let mut image = if is_held {
            OperationOnHost::controller(&flash, &held())
        } else {
            image(&flash, &mut random)
        };
        if is_held {
            press(&mut image);
        } else {
            let (mode, line) = any_command(&mut random);
            perform(&mut image, &[mode, "arm", &line]);
        }
        truth.run(&mut image, 3000);
        worst = worst.max(truth.0);
        overloads += u32::from(image.wiring.latch().causes().contains(Fault::Overload));
        if is_held && before > 0.999 {
            // It drives on, with what the winding bears for ever.
            let current = image.plant.state.current / EMA.limits.continuous_current;
            assert!((0.95..1.1).contains(&current), "{seed}: {current}");
        }
    }
    println!("the winding at {worst:.4} of what it bears, {overloads} overloads");
    assert!(worst < 1.005, "{worst}");
    assert_eq!(overloads, 0);
}

/// From the hottest state, with nothing driven, the range of the current is whole again after a tenth of what cooling takes.
#[test]
fn what_is_only_possible_cools_as_the_winding_does() {
    let flash = SharedFlash::new();
    flash.lose_ram();
    let mut image = OperationOnHost::controller(&flash, &held());
    let continuous = EMA.limits.continuous_current;
    // And what 10 ms at the limit heat.
    let tenth = 0.11 * most() / f64::from(continuous).powi(2);
    image.run_ms((1e3 * tenth) as u32);
    press(&mut image);
    image.run_ms(10);
    let current = image.plant.state.current;
    let limit = EMA.limits.current();
    assert!((current - limit).abs() < 0.02 * limit, "{current} A");
}

/// A start that comes while there is no knowing yet knows no more.
#[test]
fn a_reset_soon_after_power_on_leaves_the_heat_unknown() {
    let flash = SharedFlash::new();
    flash.lose_ram();
    OperationOnHost::controller(&flash, &held()).run_ms(20);
    let mut image = pressed(&flash);
    image.run_ms(50);
    // Of 40 ms without a current, by the equation of the range: 36 A² + 364 A² · 36 · 0.04/(0.1 · 564), 6.7 A.
    let current = image.plant.state.current;
    assert!((5.9..7.0).contains(&current), "{current} A");
}

/// Numbers that are told after power-on are those of the same winding, whose heat is not known any better for it.
#[test]
fn other_numbers_do_not_make_heat_known() {
    let flash = SharedFlash::new();
    flash.lose_ram();
    let mut image = OperationOnHost::controller(&flash, &held());
    perform(&mut image, &["set continuous_current 4"]);
    image.run_ms(20);
    press(&mut image);
    image.run_ms(50);
    let current = image.plant.state.current;
    // As above, 4 A and what some 20 ms without a current add.
    assert!((3.9..4.9).contains(&current), "{current} A");
}

/// Of the order of a word's bits nothing is assumed: a heat comes back no smaller, and no greater than by two parts of 65,535.
#[test]
fn what_is_kept_is_never_less() {
    for word in (0..=u32::MAX).step_by(65_521) {
        let heat = Heat::of_word(word);
        let again = Heat::of_word(heat.word());
        let [before, after] = [heat, again].map(Heat::word);
        assert_eq!(before & 1, after & 1, "{word:#x}");
        for half in [0, 16] {
            let [before, after] = [before, after].map(|word| word >> half & 0xffff);
            assert!((before..=before + 2).contains(&after), "{word:#x}");
        }
    }
}
