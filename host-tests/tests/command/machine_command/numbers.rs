//! The numbers that are printed, and what a plant made of them does.

use std::f64::consts::PI;

use super::*;

#[test]
fn a_gearmotor_turns_draws_and_stalls_as_its_sheet_says() {
    let machine = machine_with_loss(CART);
    // Resistance, torque constant, friction and loss are printed with four digits each.
    let tolerance = 4.0 * PRINTED;
    let (speed, current) = settled(&machine, 12.0, 0.0);
    near(speed, 200.0 * RPM, tolerance);
    // The small difference of two large voltages: by how much they are larger, the current is less sure.
    near(current, 0.2, tolerance * 12.0 / (0.2 * 12.0 / 5.5));
    near(blocked(&machine, 12.0), 5.5, tolerance);
    // The line of speed over torque falls to nothing at the stall torque.
    let stall = 210.0 * KGF_MM;
    for part in [0.25, 0.5, 0.9] {
        let (speed, _) = settled(&machine, 12.0, part * stall);
        let expected = 200.0 * RPM * (1.0 - part);
        assert!(
            (speed - expected).abs() < tolerance * 200.0 * RPM,
            "{speed} for {expected} at {part}"
        );
    }
    assert!(settled(&machine, 12.0, 1.02 * stall).0 <= 0.0);
}

/// Resistance and torque constant as they are printed come to the same speed, current and torque as the sheet,
/// which rounds all of them to two or three digits.
#[test]
fn a_motor_with_its_constants_given_keeps_its_sheets_lines() {
    let machine = machine(&format!("{MICROMOTOR} --friction-torque 0.12mNm"));
    let motor = machine.motor.unwrap();
    assert_eq!(
        (motor.resistance, motor.inductance, motor.torque_constant),
        (13.7, 3.1e-4, 0.0114)
    );
    near(machine.mechanics.inertia, 6.7e-8, 1e-12);
    let (speed, current) = settled(&machine, 12.0, 0.0);
    // 11.4 mN·m/A has three digits, 9900 rpm two.
    near(speed, 9900.0 * RPM, 0.05 / 11.4 + 0.5 / 99.0);
    // 0.12 mN·m has two digits.
    near(current, 0.0105, 0.5 / 12.0 + 0.5 / 105.0);
    near(blocked(&machine, 12.0), 12.0 / 13.7, 1e-4);
    let (speed, _) = settled(&machine, 12.0, 9.90e-3);
    assert!(speed.abs() < 0.01 * 9900.0 * RPM, "{speed}");
}

/// Behind a gear of N, torque constant and friction grow by N, inertia by N², and the time constants stay.
#[test]
fn a_gear_refers_the_motor_to_its_output() {
    let bare = machine(MICROMOTOR);
    // A gear in which nothing rubs: else its own friction would be added.
    let words = format!("{MICROMOTOR} --gear-ratio 22:1 --values-of motor --load-friction 0mNm");
    let geared = machine(&words);
    let (one, other) = (bare.motor.unwrap(), geared.motor.unwrap());
    assert_eq!(one.resistance, other.resistance);
    assert_eq!(one.inductance, other.inductance);
    near(other.torque_constant, 22.0 * one.torque_constant, PRINTED);
    let (one, other) = (bare.mechanics, geared.mechanics);
    near(other.inertia, 484.0 * one.inertia, PRINTED);
    near(other.viscous, 484.0 * one.viscous, 2.0 * PRINTED);
    near(
        geared.friction.coulomb,
        22.0 * bare.friction.coulomb,
        2.0 * PRINTED,
    );
    assert!(geared.declared_effects.is_empty());
    near(settled(&geared, 12.0, 0.0).0, 9900.0 * RPM / 22.0, 0.01);

    // A loss leaves the speed, and takes its part of the torque.
    let lossy = machine_with_loss(&format!("{words} --gear-efficiency 70%"));
    assert_eq!(lossy.declared_effects[0].id, "load_dependent_friction");
    near(lossy.declared_effects[0].parameters["share"], 0.3, 1e-12);
    near(
        settled(&lossy, 12.0, 0.0).0,
        settled(&geared, 12.0, 0.0).0,
        2.0 * PRINTED,
    );
    // What rubs at the motor is overcome through the gear.
    let rubbing = machine(&format!(
        "{words} --gear-efficiency 70% --friction-torque 0.1mNm"
    ));
    near(rubbing.friction.coulomb, 0.7 * 22.0 * 1e-4, PRINTED);
    let half = 0.5 * 0.7 * 22.0 * 9.90e-3;
    near(
        settled(&lossy, 12.0, half).0,
        0.5 * 9900.0 * RPM / 22.0,
        0.02,
    );
}

#[test]
fn a_screw_makes_a_stroke_of_turns() {
    let lead = 2e-3;
    let words = format!(
        "{MICROMOTOR} --gear-ratio 3 --screw-lead 2mm --gear-efficiency 0.5 --values-of motor \
         --load-friction 0N --load-inertia 2kg --lower-stop 0mm --upper-stop 5cm --encoder-counts 1000 --encoder-side motor"
    );
    let machine = machine_with_loss(&words);
    let turns = 3.0 * TAU / lead;
    near(
        machine.motor.unwrap().torque_constant,
        turns * 0.0114,
        PRINTED,
    );
    near(
        machine.mechanics.inertia,
        2.0 + turns * turns * 6.7e-8,
        PRINTED,
    );
    assert_eq!(machine.mechanics.lower_stop, Some(0.0));
    assert_eq!(machine.mechanics.upper_stop, Some(0.05));
    near(machine.resolution.unwrap(), lead / 3000.0, PRINTED);
    let (speed, current) = settled(&machine, 12.0, 0.0);
    near(speed, 9900.0 / 60.0 / 3.0 * lead, 0.01);
    assert!(current > 0.0);
    // Half the torque of standstill, through screw and gear at half the power.
    let (speed, _) = settled(&machine, 12.0, 0.25 * turns * 9.90e-3);
    near(speed, 0.5 * 9900.0 / 60.0 / 3.0 * lead, 0.02);
}

/// A linear actuator whose sheet says nothing of its screw: forces and speeds along the stroke are enough.
#[test]
fn a_linear_actuator_needs_no_lead() {
    let machine = machine_with_loss(
        "--voltage 12V --no-load-speed 32mm/s --no-load-current 40mA --stall-torque 100N --stall-current \
         0.65A --gear-ratio 35 --values-of gearmotor",
    );
    near(settled(&machine, 12.0, 0.0).0, 0.032, 4.0 * PRINTED);
    near(settled(&machine, 12.0, 50.0).0, 0.016, 8.0 * PRINTED);
    near(blocked(&machine, 12.0), 0.65, 4.0 * PRINTED);
}

#[test]
fn loads_springs_sensors_and_inputs_are_taken_over() {
    let machine = machine(&format!(
        "{CART} --pendulum-mass 490g --pendulum-length 10cm --gravity-rest -90deg --load-inertia 5kg.cm2 \
         --spring 0.5Nm/rad --spring-rest 10deg --spring-preload 0.1Nm --lower-stop -45deg --upper-stop \
         90deg --input duty/255 --encoder-counts 64 --encoder-side motor"
    ));
    let mechanics = machine.mechanics;
    near(mechanics.gravity_torque, 0.49 * 9.80665 * 0.1, PRINTED);
    near(mechanics.gravity_rest, -PI / 2.0, PRINTED);
    let alone = super::machine(CART).mechanics.inertia;
    near(mechanics.inertia, alone + 0.49 * 0.01 + 5e-4, PRINTED);
    assert_eq!((mechanics.spring, mechanics.spring_preload), (0.5, 0.1));
    near(mechanics.spring_rest, PI / 18.0, PRINTED);
    near(mechanics.lower_stop.unwrap(), -PI / 4.0, PRINTED);
    near(mechanics.upper_stop.unwrap(), PI / 2.0, PRINTED);
    near(machine.gain, 12.0 / 255.0, 1e-12);
    near(machine.resolution.unwrap(), TAU / 3200.0, PRINTED);
    assert_eq!(
        machine.fit,
        [
            "inertia",
            "viscous",
            "coulomb",
            "static",
            "spring",
            "spring_preload"
        ]
    );
    // A spring of nothing is none, and has nothing to fit.
    let without = super::machine(&format!("{CART} --spring 0Nm/rad"));
    assert_eq!(without.fit, ["inertia", "viscous", "coulomb", "static"]);
    for (input, gain) in [("V", 1.0), ("mV", 1e-3), ("duty", 12.0), ("%", 0.12)] {
        let machine = super::machine(&format!("{CART} --input {input}"));
        near(machine.gain, gain, 1e-12);
    }
    let machine = super::machine(&format!("{CART} --input duty --supply 9V"));
    assert_eq!(machine.gain, 9.0);
}

/// The same motor in the units of other data sheets, and with other things given.
#[test]
fn a_number_can_be_given_in_many_ways() {
    let one = machine(CART);
    let other = machine(
        "--voltage 12000mV --no-load-speed 20.943951rad/s --no-load-current 200mA --stall-torque \
         291.63oz.in --stall-current 5.5A --gear-ratio 50:1 --values-of gearmotor",
    );
    let constants = |machine: &Machine| machine.motor.unwrap().torque_constant;
    near(constants(&other), constants(&one), PRINTED);
    near(other.friction.coulomb, one.friction.coulomb, 4.0 * PRINTED);
    // Torque, speed and back-EMF constant are one number: 60 / 2π / 835 = 0.01144.
    for constant in [
        "--torque-constant 11.44mNm/A",
        "--speed-constant 835rpm/V",
        "--back-emf-constant 1.198mV/rpm",
        "--back-emf-constant 1.198V/krpm",
    ] {
        let words =
            format!("--voltage 12V --resistance 13.7ohm --no-load-current 10.5mA {constant}");
        near(constants(&machine(&words)), 0.01144, 1e-3);
    }
    // Behind a gear a torque for an ampere has lost what the gear takes: 12 V · 95 % / 55 rpm · 0.9.
    let servo = machine(
        "--voltage 12V --no-load-speed 55rpm --no-load-current 70mA --stall-current 1.4A --gear-ratio 193 \
         --values-of gearmotor --gear-efficiency 90% --torque-constant 1.781Nm/A",
    );
    near(constants(&servo), 12.0 * 0.95 / (55.0 * RPM), 2.0 * PRINTED);
    // Without resistance and stall current: the quadratic of no-load speed and stall torque, whose solution
    // the full sheet has.
    let machine = machine(
        "--voltage 12V --no-load-speed 9900rpm --no-load-current 0.0105A --stall-torque 9.90mNm",
    );
    near(machine.motor.unwrap().resistance, 13.7, 0.02);
    near(constants(&machine), 0.0114, 0.02);
    // The rotor's inertia from the mechanical time constant: 7 ms · k² / R.
    let words = MICROMOTOR.replace("--rotor-inertia 0.67gcm2", "");
    let machine = super::machine(&words);
    near(
        machine.mechanics.inertia,
        7e-3 * 0.0114 * 0.0114 / 13.7,
        PRINTED,
    );
}

/// What the gear loses is never declared, for no fit would change it. Its line is there to be put in where the sheet's numbers show
/// a loss at all: 99 % of the torque, from numbers of two digits, may be all of it.
#[test]
fn a_loss_is_told_and_not_declared() {
    let words = "--voltage 24V --no-load-speed 70rpm --no-load-current 0.16A --stall-torque 100kg.cm \
                 --stall-current 3.3A --gear-ratio 75 --values-of gearmotor";
    assert!(machine_with_loss(words).declared_effects.is_empty());
    let text = printed(words);
    assert!(
        text.contains("What the gear loses may be nothing ("),
        "{text}"
    );
    let words_of_loss = words.replace("100kg.cm", "70kg.cm");
    assert!(machine(&words_of_loss).declared_effects.is_empty());
    let lossy = machine_with_loss(&words_of_loss);
    assert_eq!(lossy.declared_effects[0].id, "load_dependent_friction");
    // As the user says, however small.
    let told = machine_with_loss(&format!("{words} --gear-efficiency 98%"));
    near(told.declared_effects[0].parameters["share"], 0.02, 1e-12);
}

/// What a log can be checked for is in the file: the gear's ratio, and how far the sheet's numbers may be off.
#[test]
fn gear_ratio_and_tolerances_are_read_back() {
    let machine = machine(CART);
    assert_eq!(machine.gear_ratio, Some(50.0));
    // Makers' 10 %, and 0.05 of 5.5 A.
    near(machine.tolerances["resistance"], 0.11, 0.05);
    assert!(!machine.tolerances.contains_key("coulomb"));
}

/// What is behind a number that is a guess, as the file says it.
pub(super) fn guess(text: &str, name: &str) -> Option<f64> {
    let line = text
        .lines()
        .find(|line| line.starts_with(&format!("{name} = ")));
    let (_, factor) = line.unwrap().split_once("unsure by a factor of ")?;
    Some(factor.parse().unwrap())
}

/// The comment behind a number and what a tracing goes by are one: the factors of all that is fitted, above the two that a
/// number of which nothing is said has.
#[test]
fn the_factors_of_the_guesses_are_in_fit() {
    for words in [
        CART,
        MICROMOTOR,
        &format!("{MICROMOTOR} --gear-ratio 53 --values-of motor"),
        &format!("{MICROMOTOR} --friction-torque 0.12mNm --viscous 1e-9Nms"),
        &format!("{CART} --spring-preload 0.1Nm"),
    ] {
        let text = printed(words);
        let machine = Machine::of_bytes(Path::new("a.toml"), text.clone().into_bytes()).unwrap();
        for name in &machine.fit {
            let stated = guess(&text, name).filter(|factor| *factor > 2.0);
            assert_eq!(machine.unsure.get(name).copied(), stated, "{name}: {text}");
        }
    }
    let unsure = machine(CART).unsure;
    assert_eq!(unsure.keys().collect::<Vec<_>>(), ["inertia", "viscous"]);
}

/// The comment above a number, in one line.
fn comment(text: &str, name: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    let at = lines
        .iter()
        .position(|line| line.starts_with(&format!("{name} = ")))
        .unwrap();
    let above = lines[..at]
        .iter()
        .rev()
        .take_while(|line| line.starts_with("# "));
    let mut above: Vec<&str> = above.map(|line| &line[2..]).collect();
    above.reverse();
    above.join(" ")
}

/// Behind a gear each comment has all that its number was made of: the ratio, and what the gear passes on.
#[test]
fn a_comment_makes_its_number() {
    let words = MICROMOTOR
        .replace("--torque-constant 11.4mNm/A", "")
        .replace("--stall-torque 9.90mNm", "");
    // A gear in which nothing rubs: else its own friction would be guessed.
    let words = format!(
        "{words} --gear-ratio 53 --values-of motor --gear-efficiency 43% --load-friction 0mNm"
    );
    let text = printed(&words);
    let machine = machine(&words);
    let constant = (12.0 - 0.0105 * 13.7) / (9900.0 * RPM) * 53.0;
    near(machine.motor.unwrap().torque_constant, constant, PRINTED);
    let said = comment(&text, "torque_constant");
    assert!(
        said.ends_with(" over --no-load-speed 9900rpm, × 53"),
        "{said}"
    );
    let whole = constant * 0.0105 * 0.43;
    near(machine.friction.coulomb, 0.75 * whole, PRINTED);
    let said = comment(&text, "coulomb");
    let parts = "75 % of what the no-load current of 0.0105 A (given, --no-load-current 0.0105A) makes with the torque \
                 constant, of which the gear passes on 43 %";
    assert!(said.starts_with(parts), "{said}");
    let speed = 9900.0 * RPM / 53.0;
    near(
        machine.mechanics.viscous,
        0.25 * whole / speed,
        2.0 * PRINTED,
    );
    let said = comment(&text, "viscous");
    let (friction, speed_said) = (
        said.split("at no load, ")
            .nth(1)
            .unwrap()
            .split(' ')
            .next()
            .unwrap(),
        said.split("over the speed there, ")
            .nth(1)
            .unwrap()
            .split(' ')
            .next()
            .unwrap(),
    );
    near(friction.parse().unwrap(), whole, 2.0 * PRINTED);
    near(speed_said.parse().unwrap(), speed, PRINTED);
    // A friction that is told goes through the gear as well.
    let told = words.replace("--no-load-current 0.0105A", "--friction-torque 0.1mNm");
    let said = comment(&printed(&told), "coulomb");
    assert!(
        said.starts_with("given, --friction-torque 0.1mNm, × 53, of which the gear passes on 43 %"),
        "{said}"
    );
}

/// Within rounding nothing contradicts, but who reads the file sees that two numbers differ.
#[test]
fn a_resistance_that_the_stall_current_has_otherwise_is_remarked() {
    let sheet = |current: &str| {
        let words = format!(
            "--voltage 12V --no-load-speed 5000rpm --no-load-current 0.1A --resistance 3ohm --stall-current {current}"
        );
        comment(&printed(&words), "resistance")
    };
    let said = sheet("5A");
    assert!(
        said.contains("--voltage 12V over --stall-current 5A says 2.4 Ω, 25.0 % apart"),
        "{said}"
    );
    assert_eq!(sheet("4.1A"), "given, --resistance 3ohm");
}

/// A shop's page of a linear actuator or a gearmotor may not say its ratio: the numbers behind the gear are enough.
#[test]
fn a_gearmotor_of_an_unknown_ratio_is_its_output() {
    let words = CART.replace("--gear-ratio 50 ", "");
    let (unknown, known) = (machine_with_loss(&words), machine_with_loss(CART));
    assert_eq!(unknown.motor, known.motor);
    assert_eq!(unknown.mechanics.inertia, known.mechanics.inertia);
    assert_eq!(unknown.friction.coulomb, known.friction.coulomb);
    assert_eq!(unknown.declared_effects.len(), 1);
    assert_eq!(unknown.gear_ratio, None);
    let actuator = "--voltage 12V --no-load-speed 32mm/s --no-load-current 40mA --stall-torque 100N --stall-current 0.65A";
    near(
        settled(
            &machine_with_loss(&format!("{actuator} --values-of gearmotor")),
            12.0,
            50.0,
        )
        .0,
        0.016,
        8.0 * PRINTED,
    );
    // Without the word for it, the message has it.
    let error = refused(&split(actuator));
    assert!(error.contains("add --values-of gearmotor"), "{error}");
    // What is at the motor's shaft needs the ratio.
    for of_motor in [
        "--rotor-inertia 5gcm2",
        "--encoder-counts 64 --encoder-side motor",
    ] {
        let error = refused(&split(&format!("{words} {of_motor}")));
        assert!(
            error.contains("--gear-ratio refers it to the output"),
            "{error}"
        );
    }
}

/// As hobby servos say it: 60° in 0.16 s are 62.5 rpm.
#[test]
fn a_speed_may_be_a_time_for_an_angle() {
    let words = |speed: &str| {
        format!(
            "--voltage 6V --no-load-speed {speed} --stall-torque 5kg.cm --stall-current 1.2A --values-of gearmotor"
        )
    };
    let servo = machine(&words("0.16s/60deg"));
    assert_eq!(servo.motor, machine(&words("62.5rpm")).motor);
    for wrong in ["0s/60deg", "0.16s/0deg", "0.16s/60mm", "0.16s/deg"] {
        let error = refused(&split(&words(wrong)));
        assert!(error.contains("--no-load-speed"), "{error}");
    }
}
