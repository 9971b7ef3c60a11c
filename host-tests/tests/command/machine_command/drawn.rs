//! Data sheets that are drawn at random, and words that are.

use clap::Parser;
use host_tests::data_sheet::command::{Args, text_of};
use proptest::prelude::*;

use super::*;

/// The command line without the program around it.
#[derive(Debug, Parser)]
struct Line {
    #[command(flatten)]
    args: Args,
}

fn parsed<S: AsRef<str>>(words: &[S]) -> Option<Args> {
    let words = words.iter().map(AsRef::as_ref);
    let line = Line::try_parse_from(std::iter::once("machine").chain(words));
    line.ok().map(|line| line.args)
}

proptest! {
    /// A gearmotor made up, its data sheet by the closed forms, and the gearmotor again from that.
    #[test]
    fn a_gearmotor_is_found_again_from_its_sheet(
        volts in 3.0..48.0_f64,
        stall in 0.05..100.0_f64,
        idle_share in 0.002..0.2_f64,
        constant in 1e-3..0.2_f64,
        ratio in 1.0..400.0_f64,
        // What is lost beyond may be nothing, and has no line to put in.
        efficiency in 0.2..0.9_f64,
    ) {
        let idle = idle_share * stall;
        let resistance = volts / stall;
        let referred = constant * ratio;
        let speed = (volts - idle * resistance) / referred;
        // Of what rubs without a load, three quarters rub at standstill too.
        let torque = efficiency * referred * (stall - 0.75 * idle);
        let words = format!(
            "--voltage {volts}V --no-load-speed {speed}rad/s --no-load-current {idle}A --stall-torque \
             {torque}Nm --stall-current {stall}A --gear-ratio {ratio} --values-of gearmotor"
        );
        let text = text_of(&parsed(&split(&words)).unwrap()).unwrap();
        let text = declaring_the_loss(&text);
        let machine = Machine::of_bytes(Path::new("a.toml"), text.into_bytes()).unwrap();
        let motor = machine.motor.unwrap();
        near(motor.resistance, resistance, PRINTED);
        near(motor.torque_constant, referred, PRINTED);
        let lost = efficiency * referred * idle;
        near(machine.friction.coulomb, 0.75 * lost, PRINTED);
        near(machine.mechanics.viscous, 0.25 * lost / speed, PRINTED);
        let share = machine.declared_effects.first().map_or(0.0, |effect| effect.parameters["share"]);
        prop_assert!((share - (1.0 - efficiency)).abs() < PRINTED);
    }

    /// A bare motor of which the sheet has four numbers only: no-load and stall point, without the current there.
    #[test]
    fn a_motor_is_found_again_from_four_numbers(
        volts in 3.0..48.0_f64,
        stall in 0.05..100.0_f64,
        idle_share in 0.0..0.5_f64,
        constant in 1e-3..0.2_f64,
    ) {
        let idle = idle_share * stall + 1e-6;
        let resistance = volts / stall;
        let speed = (volts - idle * resistance) / constant;
        let torque = constant * (stall - idle);
        let words = format!(
            "--voltage {volts}V --no-load-speed {speed}rad/s --no-load-current {idle}A --stall-torque {torque}Nm"
        );
        let text = text_of(&parsed(&split(&words)).unwrap()).unwrap();
        let machine = Machine::of_bytes(Path::new("a.toml"), text.into_bytes()).unwrap();
        let motor = machine.motor.unwrap();
        near(motor.resistance, resistance, PRINTED);
        near(motor.torque_constant, constant, PRINTED);
    }

    /// Whatever is typed, there is a machine that can be read, or a reason.
    #[test]
    fn nothing_that_is_typed_makes_a_panic(
        typed in prop::collection::btree_map(
            prop::sample::select(OPTIONS.to_vec()),
            prop_oneof![
                "[-+]?[0-9]{0,3}[.]?[0-9]{0,3}(e[-+]?[0-9]{1,3})?( )?(rpm|V|A|mA|ohm|Nm|kg[.]cm|N|deg|mm|g|gcm2|ms|%|:1|/255|duty|)",
                "[1-9][0-9]{0,2}(rpm|V|A|ohm|mNm|deg|mm|kg|gcm2|ms|Nms/rad|mNm/A|rpm/V|mH|Nm/rad|)",
                "\\PC{0,12}",
            ],
            0..20,
        ),
        side in prop::sample::select(vec!["motor", "gearmotor", "load"]),
    ) {
        let mut words: Vec<String> = vec!["--values-of".into(), side.into()];
        for (option, value) in typed {
            words.push(format!("{option}={value}"));
        }
        let Some(args) = parsed(&words) else { return Ok(()); };
        if let Err(reason) = text_of(&args) {
            prop_assert!(!reason.is_empty());
        }
    }
}

const OPTIONS: [&str; 35] = [
    "--name",
    "--source",
    "--voltage",
    "--no-load-speed",
    "--no-load-current",
    "--stall-torque",
    "--stall-current",
    "--resistance",
    "--inductance",
    "--torque-constant",
    "--speed-constant",
    "--back-emf-constant",
    "--rotor-inertia",
    "--mechanical-time-constant",
    "--friction-torque",
    "--load-friction",
    "--breakaway-torque",
    "--viscous",
    "--gear-ratio",
    "--gear-efficiency",
    "--screw-lead",
    "--load-inertia",
    "--pendulum-mass",
    "--pendulum-length",
    "--gravity-rest",
    "--spring",
    "--spring-rest",
    "--spring-preload",
    "--lower-stop",
    "--upper-stop",
    "--encoder-counts",
    "--encoder-side",
    "--resolution",
    "--input",
    "--supply",
];
