//! What is refused: numbers that contradict each other, are too few, or are none.

use super::*;

/// A sheet, what of it is replaced and by what, or added where that is nothing, and what the refusal names.
type Wrong = (&'static str, &'static str, &'static str, [&'static str; 2]);

/// A toy's gearmotor, whose gear loses next to nothing.
const TOY: &str = "--voltage 6V --no-load-speed 160rpm --no-load-current 60mA --stall-current 1.6A --stall-torque \
                   5.5kg.cm --gear-ratio 100 --values-of gearmotor";

const CONTRADICTIONS: [Wrong; 21] = [
    // V/R is 0.876 A.
    (
        MICROMOTOR,
        "",
        "--stall-current 1.1A",
        ["--stall-current 1.1A", "--resistance 13.7ohm"],
    ),
    // The speed constant is 835 rpm/V.
    (
        MICROMOTOR,
        "",
        "--speed-constant 700rpm/V",
        ["--torque-constant 11.4mNm/A", "--speed-constant 700rpm/V"],
    ),
    (
        MICROMOTOR,
        "",
        "--back-emf-constant 1.5mV/rpm",
        [
            "--torque-constant 11.4mNm/A",
            "--back-emf-constant 1.5mV/rpm",
        ],
    ),
    (
        MICROMOTOR,
        "9900rpm",
        "7900rpm",
        ["--torque-constant 11.4mNm/A", "--no-load-speed 7900rpm"],
    ),
    (
        MICROMOTOR,
        "9.90mNm",
        "12.5mNm",
        ["--stall-torque 12.5mNm", "--torque-constant 11.4mNm/A"],
    ),
    (
        MICROMOTOR,
        "0.0105A",
        "0.9A",
        ["--no-load-current 0.9A", "0.8759 A"],
    ),
    (
        MICROMOTOR,
        "7ms",
        "3ms",
        ["--mechanical-time-constant 3ms", "--rotor-inertia 0.67gcm2"],
    ),
    (
        MICROMOTOR,
        "",
        "--friction-torque 0.2mNm",
        ["--friction-torque 0.2mNm", "--no-load-current 0.0105A"],
    ),
    (
        MICROMOTOR,
        "",
        "--breakaway-torque 0.05mNm",
        ["--breakaway-torque 0.05mNm", "sliding friction"],
    ),
    (
        MICROMOTOR,
        "",
        "--viscous 1mNms/rad",
        ["--viscous 1mNms/rad", "no-load current"],
    ),
    // Through 50:1 that would be ten times what the winding gives.
    (
        CART,
        "210kg.mm",
        "210kg.cm",
        ["--stall-torque 210kg.cm", "--values-of"],
    ),
    // A slip of the decimal point.
    (
        TOY,
        "5.5kg.cm",
        "0.55kg.cm",
        ["--stall-torque 0.55kg.cm", "the gear would pass on"],
    ),
    // The motor's torque is not the gearmotor's.
    (
        CART,
        "210kg.mm",
        "6kg.mm",
        ["--stall-torque 6kg.mm", "--values-of"],
    ),
    (
        CART,
        "0.2A",
        "6A",
        ["--no-load-current 6A", "--stall-current 5.5A"],
    ),
    (
        CART,
        "",
        "--gear-efficiency 0.4",
        ["--stall-torque 210kg.mm", "--gear-efficiency 0.4"],
    ),
    (
        CART,
        "",
        "--gear-efficiency 1.2",
        ["--gear-efficiency", "0.05 to 1"],
    ),
    (
        CART,
        "",
        "--lower-stop 10deg --upper-stop 10deg",
        ["--lower-stop 10deg", "--upper-stop 10deg"],
    ),
    (
        CART,
        "",
        "--lower-stop 10mm",
        ["--lower-stop 10mm", "--screw-lead"],
    ),
    (
        CART,
        "",
        "--screw-lead 2mm --pendulum-mass 1kg --pendulum-length 1m",
        ["--pendulum-mass 1kg", "stroke"],
    ),
    (
        CART,
        "",
        "--rotor-inertia 1kg",
        ["--rotor-inertia 1kg", "g.cm2"],
    ),
    (
        CART,
        "200rpm",
        "20mm/s",
        ["--stall-torque 210kg.mm", "--screw-lead"],
    ),
];

/// As far apart as a maker and rounding allow.
const ALLOWED: [(&str, &str, &str); 4] = [
    (MICROMOTOR, "", "--stall-current 0.90A"),
    (MICROMOTOR, "", "--speed-constant 800rpm/V"),
    (MICROMOTOR, "9.90mNm", "10.5mNm"),
    // Of one digit a half more: 0.5 A may be 0.55 A.
    (
        "--voltage 12V --resistance 20ohm --torque-constant 0.1Nm/A",
        "",
        "--stall-current 0.5A",
    ),
];

fn changed(sheet: &str, from: &str, to: &str) -> String {
    if from.is_empty() {
        format!("{sheet} {to}")
    } else {
        assert!(sheet.contains(from), "{from}");
        sheet.replace(from, to)
    }
}

#[test]
fn numbers_that_contradict_each_other_are_refused() {
    for (sheet, from, to, parts) in CONTRADICTIONS {
        let error = refused(&split(&changed(sheet, from, to)));
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
    for (sheet, from, to) in ALLOWED {
        printed(&changed(sheet, from, to));
    }
}

#[test]
fn what_is_missing_is_named_with_what_would_give_it() {
    for (words, parts) in [
        ("", &["--resistance", "--stall-current"][..]),
        (
            "--resistance 2ohm",
            &["--torque-constant", "--no-load-speed"],
        ),
        (
            "--resistance 2ohm --torque-constant 20mNm/A",
            &["--no-load-current", "--friction-torque", "--voltage"],
        ),
        (
            "--voltage 12V --no-load-speed 100rpm --stall-torque 1Nm --gear-ratio 9 --values-of gearmotor",
            &["--resistance", "--gear-efficiency"],
        ),
        (
            "--gear-ratio 9",
            &["--values-of motor", "--values-of gearmotor"],
        ),
        ("--encoder-counts 64", &["--encoder-side"]),
        ("--pendulum-mass 1kg", &["--pendulum-length"]),
        ("--input duty", &["--supply", "--voltage"]),
        (
            "--voltage 12V --stall-current 1.4A --torque-constant 1.786Nm/A --gear-ratio 193 --values-of gearmotor",
            &["--torque-constant", "--gear-efficiency"],
        ),
        ("--gear-efficiency 0.8", &["--gear-ratio"]),
    ] {
        let error = refused(&split(words));
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
    }
}

/// An option of a good sheet, and what is no value of it.
const BAD: [(&str, &str); 35] = [
    ("--voltage", "nanV"),
    ("--voltage", "infV"),
    ("--voltage", "12"),
    ("--voltage", "12A"),
    ("--voltage", "0V"),
    ("--voltage", ""),
    ("--voltage", "1e999V"),
    ("--voltage", "1e308kV"),
    ("--no-load-speed", "2,5rpm"),
    ("--no-load-speed", "200furlongs"),
    ("--no-load-current", "-0.2A"),
    ("--stall-torque", "1e-300Nm"),
    ("--stall-current", "1e38A"),
    ("--gear-ratio", "0"),
    ("--gear-ratio", "-50"),
    ("--gear-ratio", "1:50"),
    ("--gear-ratio", "nan"),
    ("--gear-ratio", "1e300"),
    ("--gear-efficiency", "nan"),
    ("--gear-efficiency", "0"),
    ("--gear-efficiency", "170%"),
    ("--values-of", "gear"),
    ("--rotor-inertia", "0gcm2"),
    ("--inductance", "1ohm"),
    ("--resolution", "0deg"),
    ("--lower-stop", "-nandeg"),
    ("--input", "volts"),
    ("--input", "duty/0"),
    ("--input", "\u{1b}[31m\n"),
    ("--name", ""),
    ("--name", " "),
    ("--load-inertia", "9e37kg.m2"),
    ("--load-inertia", "-1kg.m2"),
    ("--screw-lead", "0mm"),
    ("--nonsense", "1"),
];

#[test]
fn bad_values_are_one_line_and_status_2() {
    for (option, value) in BAD {
        let mut words: Vec<String> = split(CART).into_iter().map(str::to_owned).collect();
        if let Some(place) = words.iter().position(|word| word == option) {
            words.drain(place..place + 2);
        }
        // What begins with a dash would be taken for an option.
        words.push(format!("{option}={value}"));
        refused(&words);
    }
}
