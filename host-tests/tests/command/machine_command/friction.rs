//! What rubs: what a data sheet says of it, and how unsure the rest is.

use super::numbers::guess;
use super::*;

/// What rubs behind a bare motor is more than its own friction and less than what stops it. Gearmotors draw 4 to 16 % of their stall
/// current without a load, their geometric mean is 8 %: from there, both ends are within the factor that is stated.
#[test]
fn the_friction_behind_a_bare_motor_is_that_of_gearmotors_within_all_that_it_can_be() {
    // 0.0105 A of 12 V / 13.7 Ω, with 11.4 mN·m for an ampere and 53 turns for one.
    let words = format!("{MICROMOTOR} --gear-ratio 53 --values-of motor");
    let text = printed(&words);
    let friction = machine(&words);
    let stall = 12.0 / 13.7 * 11.4e-3 * 53.0;
    let own = 0.0105 * 11.4e-3 * 53.0;
    let speed = 9900.0 * RPM / 53.0;
    let viscous = friction.mechanics.viscous;
    near(friction.friction.coulomb, 0.75 * 0.08 * stall, PRINTED);
    near(
        friction.friction.r#static,
        1.2 * 0.75 * 0.08 * stall,
        PRINTED,
    );
    near(viscous, 0.25 * 0.08 * stall / speed, PRINTED);
    // Printed with a tenth; a fit reaches no farther than 45 times.
    let expected = |value: f64, own: f64, most: f64| (value / own).max(most / value).min(45.0);
    let coulomb = expected(friction.friction.coulomb, 0.75 * own, stall);
    near(
        guess(&text, "coulomb").unwrap(),
        coulomb,
        0.05 / coulomb + PRINTED,
    );
    let factor = expected(viscous, 0.25 * own / speed, stall / speed);
    near(
        guess(&text, "viscous").unwrap(),
        factor,
        0.05 / factor + PRINTED,
    );
    let said = text.replace("\n# ", " ");
    assert!(
        said.contains(
            "without the gear's own friction, which no motor's data sheet has: --load-friction adds it, as in \
             --load-friction 20mNm"
        ),
        "{said}"
    );
    // What is told is as sure as that, a motor without a gear has none, and a gearmotor's current has it.
    let told = words.replace("--no-load-current 0.0105A", "--friction-torque 0.5mNm");
    let told = printed(&told);
    for (text, coulomb) in [
        (&told, None),
        (&printed(MICROMOTOR), Some(1.3)),
        (&printed(CART), Some(1.3)),
    ] {
        assert_eq!(guess(text, "coulomb"), coulomb);
        assert!(!text.contains("gear's own friction"), "{text}");
    }
    let viscous = printed(&format!("{words} --viscous 1e-9Nms"));
    assert_eq!(guess(&viscous, "viscous"), None);
    assert!(guess(&viscous, "coulomb").unwrap() > 10.0);
    // No guess contradicts a breakaway torque that is told.
    let told = format!("{words} --breakaway-torque 0.2mNm");
    assert!(machine(&told).friction.coulomb <= 0.2e-3 * 53.0 * (1.0 + PRINTED));
}

/// A load on the motor's own shaft has bearings that no data sheet knows; how much these rub nothing tells.
#[test]
fn a_load_makes_a_motors_friction_unsure() {
    let alone = machine(MICROMOTOR);
    let words = format!("{MICROMOTOR} --load-inertia 2gcm2");
    let text = printed(&words);
    let loaded = machine(&words);
    assert_eq!(loaded.friction.coulomb, alone.friction.coulomb);
    assert_eq!(loaded.mechanics.viscous, alone.mechanics.viscous);
    // 75 % of 0.0105 A, of 12 V / 13.7 Ω.
    assert_eq!(guess(&text, "coulomb"), Some(45.0));
    assert_eq!(guess(&text, "viscous"), Some(45.0));
    let said = text.replace("\n# ", " ");
    assert!(said.contains("without what rubs at the load"), "{said}");
    // What is told of the load says nothing of its viscous friction.
    let text = printed(&format!("{words} --load-friction 1mNm"));
    assert_eq!(guess(&text, "viscous"), Some(45.0));
    assert_eq!(guess(&text, "coulomb"), None);
}

/// A data sheet of a motor knows nothing of a rail; what that rubs is given at the carriage, and adds to what the motor's current says.
#[test]
fn a_carriage_has_its_own_friction() {
    let words = format!("{MICROMOTOR} --gear-ratio 4 --screw-lead 40mm --values-of motor");
    let text = printed(&words);
    let said = text.replace("\n# ", " ");
    let hint = "gear, belt or screw and rail, which no motor's data sheet has: --load-friction adds it, as in --load-friction 5N";
    assert!(said.contains(hint), "{said}");
    // 75 % of 0.0105 A, with 11.4 mN·m for an ampere and 4 turns for 40 mm.
    let alone = 0.75 * 0.0105 * 11.4e-3 * 4.0 * TAU / 0.04;
    let text = printed(&format!("{words} --load-friction 5N"));
    let both = machine(&format!("{words} --load-friction 5N")).friction;
    near(both.coulomb, alone + 5.0, PRINTED);
    near(both.r#static, 1.2 * (alone + 5.0), PRINTED);
    // Most of it is told, and is no guess.
    assert_eq!(guess(&text, "coulomb"), None);
    assert!(!text.contains("--load-friction adds it"), "{text}");
    let said = text.replace("\n# ", " ");
    assert!(said.contains("; + 5 of --load-friction 5N"), "{said}");
    // A gearmotor's current knows its gear, and no rail; a friction at the carriage is all of it.
    let gearmotor = printed(&format!("{CART} --screw-lead 40mm"));
    let said = gearmotor.replace("\n# ", " ");
    assert!(
        said.contains("without what rubs in belt or screw and rail"),
        "{said}"
    );
    let whole = words.replace("--no-load-current 0.0105A", "--friction-torque 5N");
    let text = printed(&format!("{whole} --gear-efficiency 80%"));
    assert!(!text.contains("--load-friction"), "{text}");
    near(
        machine(&format!("{whole} --gear-efficiency 80%"))
            .friction
            .coulomb,
        5.0,
        PRINTED,
    );
    // Beside the current of a motor that does not move it, it is no contradiction of the sheet.
    let error = refused(&split(&format!("{words} --friction-torque 5N")));
    assert!(
        error.contains("give what rubs behind the motor as --load-friction"),
        "{error}"
    );
    let error = refused(&split(&format!("{words} --load-friction 5mNm")));
    assert!(error.contains("give it along the stroke"), "{error}");
}
