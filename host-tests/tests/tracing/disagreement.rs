//! Whether a log and a machine file belong together is said before anything is traced.

use host_tests::gap::disagreement::{Disagreement, cost, look};
use host_tests::gap_benchmark::cases::{self, Case, Extent};
use host_tests::log::Log;
use host_tests::machine::{MOTOR, Machine};
use rayon::prelude::*;
use rig::Random;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

fn declared(rig: &rig::Machine) -> Machine {
    Machine::of_bytes(Path::new("machine.toml"), rig.to_toml().into_bytes()).unwrap()
}

/// Numbers in `[fit]` off by up to three either way.
fn misdeclared(mut machine: Machine, seed: u64) -> Machine {
    let mut random = Random::new(seed);
    let mut off = || 3.0_f64.powf(2.0 * random.uniform() - 1.0);
    machine.mechanics.inertia *= off();
    machine.mechanics.viscous *= off();
    let friction = off();
    machine.friction.coulomb *= friction;
    machine.friction.r#static *= friction;
    machine
}

type Spoil = fn(&mut Log, &mut Machine);

/// The velocity of a log, from its positions before and after each row.
fn velocity(log: &Log) -> Vec<f64> {
    let position = &log.position;
    let last = position.len() - 1;
    let rows = (0..=last).map(|row| (row.saturating_sub(1), (row + 1).min(last)));
    rows.map(|(one, other)| {
        (position[other] - position[one]) / ((other - one) as f64 * log.period_s)
    })
    .collect()
}

fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}

fn wrap(values: &mut [f64], turn: f64) {
    values
        .iter_mut()
        .for_each(|value| *value = value.rem_euclid(turn));
}

const FAULTS: [(&str, &str, Spoil); 40] = [
    (
        "encoder's direction",
        "the encoder counts the other way",
        |log, _| {
            log.velocity = Some(velocity(log));
            scale(&mut log.position, -1.0);
            scale(log.velocity.as_mut().unwrap(), -1.0);
        },
    ),
    (
        "motor's side of the gear",
        "position is 75 times too large",
        |log, machine| {
            machine.gear_ratio = Some(75.0);
            scale(&mut log.position, 75.0)
        },
    ),
    (
        "motor's side of the gear, both",
        "position and velocity are 75 times too large",
        |log, machine| {
            machine.gear_ratio = Some(75.0);
            log.velocity = Some(velocity(log));
            scale(&mut log.position, 75.0);
            scale(log.velocity.as_mut().unwrap(), 75.0);
        },
    ),
    (
        "radians as degrees",
        "position is 57.3 times too small: the column is in rad",
        |log, _| scale(&mut log.position, TAU / 360.0),
    ),
    (
        "rpm as degrees per second",
        "velocity is 6 times too small: the column is in rpm, and was imported as degrees per second",
        |log, _| {
            log.velocity = Some(velocity(log));
            scale(log.velocity.as_mut().unwrap(), 1.0 / 6.0);
        },
    ),
    (
        "millimetres per second",
        "velocity is in millimetres per second",
        |log, _| {
            log.velocity = Some(velocity(log));
            scale(log.velocity.as_mut().unwrap(), 1e3);
        },
    ),
    (
        "amperes as milliamperes",
        "current_a is 1000 times too small",
        |log, _| scale(log.current.as_mut().unwrap(), 1e-3),
    ),
    (
        "volts as millivolts",
        "input is 1000 times too small",
        |log, _| scale(&mut log.input, 1e-3),
    ),
    (
        "too few counts",
        "position is 4 times too large",
        |log, _| scale(&mut log.position, 4.0),
    ),
    (
        "too many counts",
        "position is 4 times too small",
        |log, _| scale(&mut log.position, 0.25),
    ),
    (
        "too high a supply",
        "input is 2 times too large",
        |log, _| scale(&mut log.input, 2.0),
    ),
    (
        "too low a supply",
        "input is 2 times too small",
        |log, _| scale(&mut log.input, 0.5),
    ),
    (
        "PWM of 8 bits as per cent",
        "input is 2.55 times too large: it counts a PWM from 0 to 255",
        |log, _| scale(&mut log.input, 2.55),
    ),
    (
        "any full scale",
        "input is 3.|input is in per cent of a supply of about",
        |log, _| scale(&mut log.input, 3.2),
    ),
    (
        "degrees",
        "position is in degrees|position is in millimetres|position is in centimetres",
        |log, _| scale(&mut log.position, 360.0 / TAU),
    ),
    ("revolutions", "position is in revolutions", |log, _| {
        scale(&mut log.position, 1.0 / TAU)
    }),
    (
        "millimetres",
        "position is in millim|position is in millir",
        |log, _| scale(&mut log.position, 1e3),
    ),
    ("counts", "position is in counts", |log, machine| {
        let size = machine.resolution.unwrap();
        log.position
            .iter_mut()
            .for_each(|value| *value = (*value / size).round());
    }),
    ("position sign", "position has the wrong sign", |log, _| {
        scale(&mut log.position, -1.0)
    }),
    ("input sign", "input has the wrong sign", |log, _| {
        scale(&mut log.input, -1.0)
    }),
    ("size of the input", "input has no sign", |log, _| {
        log.input.iter_mut().for_each(|value| *value = value.abs())
    }),
    ("per cent of 24", "input is in per cent", |log, _| {
        scale(&mut log.input, 100.0 / 24.0)
    }),
    ("per cent of 12", "input is in per cent", |log, _| {
        scale(&mut log.input, 100.0 / 12.0)
    }),
    (
        "PWM of 10 bits at 24 V",
        "input is in counts of a PWM, of which",
        |log, _| {
            let counts = |input: &mut f64| *input = (*input * 1023.0 / 24.0).round();
            log.input.iter_mut().for_each(counts);
        },
    ),
    ("duty of 24", "input is the duty", |log, _| {
        scale(&mut log.input, 1.0 / 24.0)
    }),
    (
        "millivolts",
        "input is in millivolts|input is in thousandths",
        |log, _| scale(&mut log.input, 1e3),
    ),
    ("milliamperes", "current_a is in milliamperes", |log, _| {
        scale(log.current.as_mut().unwrap(), 1e3)
    }),
    ("current sign", "current_a has the wrong sign", |log, _| {
        scale(log.current.as_mut().unwrap(), -1.0)
    }),
    ("size of the current", "current_a has no sign", |log, _| {
        let current = log.current.as_mut().unwrap();
        current.iter_mut().for_each(|value| *value = value.abs())
    }),
    (
        "current of the supply",
        "current_a has no sign",
        |log, _| {
            // What a bridge takes from 24 V: the motor's current for the share of the time that it switches on.
            let current = log.current.as_mut().unwrap();
            let input = log.input.iter();
            current
                .iter_mut()
                .zip(input)
                .for_each(|(value, input)| *value *= input / 24.0)
        },
    ),
    ("wrap 2 pi", "position is wrapped", |log, _| {
        wrap(&mut log.position, TAU)
    }),
    ("wrap 360", "position is in degrees", |log, _| {
        scale(&mut log.position, 360.0 / TAU);
        wrap(&mut log.position, 360.0)
    }),
    ("swap", "input and current_a are swapped", |log, _| {
        let old = std::mem::replace(log.current.as_mut().unwrap(), log.input.clone());
        log.input = old;
    }),
    ("milliseconds", "time_s is in milliseconds", |log, _| {
        log.period_s *= 1e3
    }),
    ("g cm2", "inertia is declared in g", |_, machine| {
        machine.mechanics.inertia *= 1e7
    }),
    ("kg cm2", "inertia is declared in kg·cm²", |_, machine| {
        machine.mechanics.inertia *= 1e4
    }),
    ("mN m", "coulomb is declared in mN", |_, machine| {
        machine.friction.coulomb *= 1e3
    }),
    (
        "mN m/A",
        "torque_constant is declared in mN",
        |_, machine| machine.motor.as_mut().unwrap().torque_constant *= 1e3,
    ),
    ("mH", "inductance is declared in mH", |_, machine| {
        machine.motor.as_mut().unwrap().inductance *= 1e3
    }),
    ("too slow", "sampling is too slow", |log, _| {
        let keep = 60;
        for values in [
            Some(&mut log.input),
            Some(&mut log.position),
            log.current.as_mut(),
            log.command.as_mut(),
        ]
        .into_iter()
        .flatten()
        {
            *values = values.iter().step_by(keep).copied().collect();
        }
        log.period_s *= keep as f64;
    }),
];

/// What no log without a current shows.
const NEED_CURRENT: [&str; 13] = [
    "size of the current",
    "current of the supply",
    "amperes as milliamperes",
    "milliamperes",
    "current sign",
    "swap",
    "mH",
    "too few counts",
    "too many counts",
    "too high a supply",
    "too low a supply",
    "PWM of 8 bits as per cent",
    "any full scale",
];

fn applies(name: &str, case: &Case) -> bool {
    let rotary = case.rig.coordinate == rig::Coordinate::Radian;
    let winding = matches!(case.rig.motor, rig::Motor::Winding { .. });
    match name {
        // A motor that works against a spring is hardly driven backward.
        "size of the current" | "size of the input" | "current of the supply" => {
            winding && case.rig.spring.is_none()
        }
        "degrees"
        | "radians as degrees"
        | "rpm as degrees per second"
        | "revolutions"
        | "g cm2"
        | "kg cm2" => rotary,
        "millimetres per second" => !rotary,
        "motor's side of the gear" | "motor's side of the gear, both" => rotary && winding,
        "wrap 2 pi" | "wrap 360" => rotary && case.rig.stroke.1 - case.rig.stroke.0 > 7.0,
        "per cent of 24"
        | "per cent of 12"
        | "duty of 24"
        | "PWM of 10 bits at 24 V"
        | "milliamperes"
        | "amperes as milliamperes"
        | "current sign"
        | "swap"
        | "mN m/A"
        | "mH"
        | "too few counts"
        | "too many counts"
        | "too high a supply"
        | "too low a supply"
        | "PWM of 8 bits as per cent"
        | "any full scale" => winding,
        _ => true,
    }
}

/// How often a fault was named.
#[derive(Default)]
struct Tally {
    count: usize,
    good: usize,
    other: usize,
    examples: Vec<String>,
}

#[test]
#[ignore = "at length"]
fn rates() {
    let seed = std::env::var("SEED").map_or(8_100_000, |seed| seed.parse().unwrap());
    let mut all = cases::all(Extent::Quick, seed);
    if let Ok(step) = std::env::var("STEP") {
        all = all.into_iter().step_by(step.parse().unwrap()).collect();
    }
    let results: Vec<_> = all
        .par_iter()
        .map(|case| {
            let full = case.log_lasting(8.0);
            let mut rows = Vec::new();
            let label = format!(
                "{} {:?} {:?} {}",
                case.rig.name,
                case.motion,
                case.effects
                    .iter()
                    .map(|e| cases::label(e.kind()))
                    .collect::<Vec<_>>(),
                case.seed
            );
            for bare in [false, true] {
                let mut log = full.clone();
                if bare {
                    log.current = None;
                }
                for draw in 0..4 {
                    let machine = misdeclared(declared(&case.rig), case.seed * 10 + draw);
                    let said = look(&machine, &[log.clone()]);
                    let cost = cost(&machine, &[log.clone()]);
                    if cost > 4.0 {
                        println!("cost {cost:.1} {bare} {label}");
                    }
                    rows.push((
                        "none".to_owned(),
                        bare,
                        said.is_empty(),
                        said,
                        label.clone(),
                    ));
                }
                for (name, words, spoil) in FAULTS {
                    if !applies(name, case) || (bare && NEED_CURRENT.contains(&name)) {
                        continue;
                    }
                    let mut machine = misdeclared(declared(&case.rig), case.seed * 10 + 7);
                    let mut spoiled = log.clone();
                    spoil(&mut spoiled, &mut machine);
                    let said = look(&machine, &[spoiled]);
                    let found = said
                        .iter()
                        .any(|said| words.split('|').any(|words| said.what.contains(words)));
                    rows.push((name.to_owned(), bare, found, said, label.clone()));
                }
            }
            rows
        })
        .flatten()
        .collect();
    let mut table: BTreeMap<_, Tally> = BTreeMap::new();
    for (name, bare, good, said, label) in results {
        let entry = table
            .entry((name, bare, label.split(' ').next().unwrap().to_owned()))
            .or_default();
        entry.count += 1;
        if good {
            entry.good += 1
        } else {
            if !said.is_empty() {
                entry.other += 1;
            }
            if entry.examples.len() < 3 {
                entry.examples.push(format!(
                    "{label}: {}",
                    said.iter()
                        .map(|s| format!("{} [{}]", s.what, s.evidence))
                        .collect::<Vec<_>>()
                        .join(" / ")
                ));
            }
        }
    }
    for (
        (name, bare, machine),
        Tally {
            count,
            good,
            other,
            examples,
        },
    ) in table
    {
        println!(
            "{name:16} {machine:10} {} {good}/{count}, else named {other}",
            if bare { "bare   " } else { "current" }
        );
        for example in examples {
            println!("      {example}");
        }
    }
}

/// How often both of two errors are named, each pair drawn at random, over other rigs than those of [`rates`].
#[test]
#[ignore = "at length"]
fn rates_of_pairs() {
    let seed = std::env::var("SEED").map_or(8_900_000, |seed| seed.parse().unwrap());
    let all: Vec<Case> = cases::all(Extent::Quick, seed)
        .into_iter()
        .step_by(7)
        .collect();
    let drawn: Vec<_> = all
        .par_iter()
        .flat_map_iter(|case| pairs_of(case, 6))
        .collect();
    let named = |pair: &&Pair| pair.said == 2;
    let count = |kept: &dyn Fn(&&Pair) -> bool| drawn.iter().filter(|pair| kept(pair)).count();
    for pair in drawn.iter().filter(|pair| pair.said < 2) {
        println!("{}: {}", pair.of, pair.answer);
    }
    println!(
        "{} pairs: both named {}, one {}, none of two {}, silent {}",
        drawn.len(),
        count(&named),
        count(&|pair| pair.said == 1),
        count(&|pair| pair.said == 0 && !pair.answer.is_empty()),
        count(&|pair| pair.answer.is_empty())
    );
}

/// Two errors at once in one log, and what was said of them.
struct Pair {
    of: String,
    said: usize,
    answer: String,
}

/// Pairs of errors, drawn at random, that apply to a rig and leave one another alone: an order of the two does not matter.
fn pairs_of(case: &Case, count: usize) -> Vec<Pair> {
    let full = case.log_lasting(8.0);
    let mut random = Random::new(case.seed);
    let mut pairs = Vec::new();
    while pairs.len() < count {
        let mut draw = || FAULTS[(random.uniform() * FAULTS.len() as f64) as usize];
        let drawn = [draw(), draw()];
        let [one, other] = drawn.map(|(name, ..)| name);
        let column = |name: &str| changed_by(name);
        if one == other
            || !drawn
                .iter()
                .all(|(name, ..)| applies(name, case) && column(name).is_some())
        {
            continue;
        }
        let sign = |name: &str| name.contains("sign") || name.contains("direction");
        // Two signs are one, or none, of another column.
        if sign(one) && sign(other) || column(one) == column(other) && sign(one) == sign(other) {
            continue;
        }
        let mut machine = misdeclared(declared(&case.rig), case.seed * 10 + 7);
        let mut spoiled = full.clone();
        for (.., spoil) in drawn {
            spoil(&mut spoiled, &mut machine);
        }
        let said = look(&machine, &[spoiled]);
        let is_named = |words: &str| {
            let named =
                |said: &Disagreement| words.split('|').any(|words| said.what.contains(words));
            said.iter().any(named)
        };
        let answers: Vec<String> = said
            .iter()
            .map(|said| format!("{} [{}]", said.what, said.evidence))
            .collect();
        pairs.push(Pair {
            of: format!("{} {:?}, {one} and {other}", case.rig.name, case.motion),
            said: drawn.iter().filter(|(_, words, _)| is_named(words)).count(),
            answer: answers.join(" / "),
        });
    }
    pairs
}

/// The column that an error is in; none of those that hide whatever else there is, and of those of the machine file.
fn changed_by(name: &str) -> Option<&'static str> {
    Some(match name {
        "encoder's direction"
        | "motor's side of the gear"
        | "radians as degrees"
        | "degrees"
        | "millimetres"
        | "counts"
        | "position sign" => "position",
        "volts as millivolts"
        | "input sign"
        | "per cent of 24"
        | "per cent of 12"
        | "PWM of 10 bits at 24 V"
        | "duty of 24"
        | "millivolts" => "input",
        "amperes as milliamperes" | "milliamperes" | "current sign" => "current",
        "milliseconds" => "time",
        _ => return None,
    })
}

/// One log each of a rotary drive, a throttle and a slide, with and without an effect.
fn some(first_seed: u64) -> Vec<(Case, Log)> {
    let all = cases::all(Extent::Quick, first_seed);
    let kept: Vec<Case> = all.into_iter().step_by(53).collect();
    kept.into_par_iter()
        .map(|case| {
            let log = case.log_lasting(4.0);
            (case, log)
        })
        .collect()
}

#[test]
fn logs_of_the_machine_are_traced_whatever_it_lacks_and_though_fitted_numbers_are_off_by_three() {
    for (case, log) in some(8_600_000) {
        for draw in 0..3 {
            let machine = misdeclared(declared(&case.rig), case.seed + 1000 * draw);
            let said = look(&machine, std::slice::from_ref(&log));
            assert_eq!(said, [], "{case:?}");
        }
    }
}

/// Where it makes a difference: of a machine that hardly moves a sign may be any.
#[test]
fn units_and_signs_are_named_with_what_to_do() {
    let some = some(8_700_000);
    for (name, words, spoil) in FAULTS {
        if ["too slow", "revolutions"].contains(&name) {
            continue;
        }
        let (mut named, mut count) = (0, 0);
        for (case, log) in some.iter().filter(|(case, _)| applies(name, case)) {
            let (mut log, mut machine) = (log.clone(), declared(&case.rig));
            spoil(&mut log, &mut machine);
            let said = look(&machine, &[log]);
            let is_it = |what: &str| words.split('|').any(|words| what.contains(words));
            count += 1;
            named += usize::from(said.iter().any(|said| is_it(&said.what)));
            for found in said {
                let remedy = found.remedy;
                assert!(
                    remedy.starts_with("cargo hil import ")
                        || remedy.starts_with("in machine.toml")
                        || remedy.starts_with("record the direction of the drive"),
                    "{remedy}"
                );
            }
        }
        assert!(10 * named >= 8 * count, "{name}: {named} of {count}");
    }
}

/// One error hides another: a wrong sign is least wrong where a wrong unit makes it small.
#[test]
fn two_errors_in_one_log_are_both_named() {
    let pairs: Vec<Pair> = some(8_710_000)
        .par_iter()
        .flat_map_iter(|(case, _)| pairs_of(case, 2))
        .collect();
    let both = pairs.iter().filter(|pair| pair.said == 2).count();
    assert!(10 * both >= 8 * pairs.len(), "{both} of {}", pairs.len());
}

/// What is said of these logs of windings with one column spoilt.
fn said_of_windings(spoil: Spoil) -> Vec<Vec<Disagreement>> {
    let some = some(8_700_000);
    let rotary = |case: &Case| case.rig.coordinate == rig::Coordinate::Radian;
    let winding = |case: &Case| matches!(case.rig.motor, rig::Motor::Winding { .. });
    let there = some
        .iter()
        .filter(|(case, _)| rotary(case) && winding(case));
    let said = there.map(|(case, log)| {
        let (mut log, mut machine) = (log.clone(), declared(&case.rig));
        spoil(&mut log, &mut machine);
        look(&machine, &[log])
    });
    said.collect()
}

/// In so many of ten logs.
#[track_caller]
fn mostly(said: &[Vec<Disagreement>], is_so: impl Fn(&[Disagreement]) -> bool) {
    let count = said.iter().filter(|said| is_so(said)).count();
    assert!(
        10 * count >= 8 * said.len(),
        "{count} of {}: {said:#?}",
        said.len()
    );
}

/// One column is off, and so one call is the whole remedy: no number of the machine file is touched.
#[test]
fn one_wrong_column_is_not_explained_by_several_numbers() {
    let said = said_of_windings(|log, _| scale(log.current.as_mut().unwrap(), 1e-3));
    mostly(&said, |said| {
        said.len() == 1 && said[0].remedy.contains("--current \"current_a:A*1000\"")
    });
}

/// The count of an encoder on the motor is a gear's ratio too large, which one step of the position shows where the
/// machine file has the sensor's.
#[test]
fn a_position_in_front_of_the_gear_is_no_other_unit() {
    let gears: [Spoil; 2] = [
        |log, machine| {
            machine.gear_ratio = Some(75.0);
            scale(&mut log.position, 75.0);
        },
        |log, machine| {
            let resolution = machine.resolution.expect("of the rig's sensor");
            let round =
                |position: &mut f64| *position = (*position / resolution).round() * resolution;
            log.position.iter_mut().for_each(round);
            scale(&mut log.position, 75.0);
        },
    ];
    for spoil in gears {
        let said = said_of_windings(spoil);
        mostly(&said, |said| {
            said.iter()
                .any(|said| said.remedy.contains("--position position:rad/75 "))
        });
        mostly(&said, |said| {
            said.iter().all(|said| !said.what.contains("degrees"))
        });
    }
    // Nothing is known of a gear: degrees are the nearest unit, but the motor's numbers speak against it.
    let said = said_of_windings(|log, machine| {
        machine.resolution = None;
        scale(&mut log.position, 75.0);
    });
    mostly(&said, |said| {
        said.iter()
            .all(|said| !said.evidence.contains("numbers agree"))
    });
}

/// The velocity of a sensor on the motor is the motor's as well: one column alone is not the remedy.
#[test]
fn a_sensor_in_front_of_the_gear_is_wrong_in_both_of_its_columns() {
    let gears: [Spoil; 2] = [
        |_, machine| machine.gear_ratio = Some(75.0),
        |log, machine| {
            let resolution = machine.resolution.expect("of the rig's sensor");
            let round =
                |position: &mut f64| *position = (*position / resolution).round() * resolution;
            log.position.iter_mut().for_each(round);
        },
    ];
    for know in gears {
        let some = some(8_700_000);
        let is_rotary = |case: &Case| applies("motor's side of the gear", case);
        let there = some.iter().filter(|(case, _)| is_rotary(case));
        let said: Vec<_> = there
            .map(|(case, log)| {
                let (mut log, mut machine) = (log.clone(), declared(&case.rig));
                log.velocity = Some(velocity(&log));
                know(&mut log, &mut machine);
                scale(&mut log.position, 75.0);
                scale(log.velocity.as_mut().unwrap(), 75.0);
                look(&machine, &[log])
            })
            .collect();
        mostly(&said, |said| {
            said.len() == 1
                && [
                    "--position position:rad/75 ",
                    "--velocity velocity:rad/s/75 ",
                ]
                .iter()
                .all(|source| said[0].remedy.contains(source))
        });
    }
}

/// Has the motor's numbers fitted, which a data sheet gives within a tenth.
fn fit_motor(machine: &mut Machine) {
    for name in MOTOR {
        machine.fit.push(name.to_owned());
        machine.unsure.insert(name.to_owned(), 1.1);
    }
}

/// The motor's numbers are fitted, but a data sheet has them within a tenth: they do not take up a wrong count of the encoder, nor
/// a wrong supply.
#[test]
fn a_stated_tolerance_counts_though_the_number_is_fitted() {
    let spoilt: [(&str, Spoil); 2] = [
        ("position is 4 times too large", |log, machine| {
            fit_motor(machine);
            scale(&mut log.position, 4.0);
        }),
        ("input is 2 times too large", |log, machine| {
            fit_motor(machine);
            scale(&mut log.input, 2.0);
        }),
    ];
    for (what, spoil) in spoilt {
        let said = said_of_windings(spoil);
        mostly(&said, |said| {
            said.iter().any(|said| said.what.contains(what))
        });
    }
}

/// The machine file makes volts of a duty, and the log has volts.
#[test]
fn volts_beside_a_machine_file_of_a_duty_are_said_to_be_that() {
    let said = said_of_windings(|_, machine| machine.gain = 24.0);
    mostly(&said, |said| {
        said.len() == 1
            && said[0].what == "input is in V, and the machine file takes it for a share of 24 V"
            && said[0].remedy.ends_with("[input]: gain = 1e0")
    });
}

/// Per cent of 24 V are a quarter of the volts, but for a twentieth; up to 100 they are no voltage of any supply.
#[test]
fn per_cent_are_no_volts_of_another_supply() {
    let said = said_of_windings(|log, _| scale(&mut log.input, 100.0 / 24.0));
    mostly(&said, |said| {
        said.iter()
            .any(|said| said.remedy.contains("--input \"input:%*24\""))
    });
}

#[test]
fn of_the_supplies_that_a_duty_may_be_of_those_are_offered_that_fit() {
    let said = said_of_windings(|log, _| scale(&mut log.input, 1.0 / 24.0));
    mostly(&said, |said| {
        let offered = said.iter().flat_map(|said| said.what.split(", or "));
        let offered: Vec<&str> = offered
            .filter(|what| what.contains("supply of about"))
            .collect();
        offered
            .first()
            .is_some_and(|first| first.contains("about 24 V"))
            && offered.len() <= 2
    });
}
