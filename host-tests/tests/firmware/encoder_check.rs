//! What is made sure of the encoder before a loop is closed over it: that it follows the rotor, by a push either way, and that it
//! counts the stroke that is declared, by both limit switches.

use crate::any_drive::{TOLERANCES, any_actuator, any_drop, either_way, perform, turns, winding};
use firmware::app::fault::output::Outputs;
use firmware::app::fault::{Fault, Faults};
use firmware::app::machine::EMA;
use firmware::app::timing::PLANT_PERIOD;
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};
use model_core::numeric::random::Random;
use model_core::plant::parameters::{Drive, Parameters};
use model_core::plant::{Directional, State};

const STROKE: f32 = EMA.plant.upper_stop - EMA.plant.lower_stop;

/// The image behind a start, disarmed, that checks its encoder, with this actuator at this place.
fn resting(actuator: &Parameters, position: f32, random: &mut Random) -> OperationOnHost<Motor> {
    let mut image = OperationOnHost::controller(&SharedFlash::new(), actuator);
    image.plant.noise = Some(Random::new(random.bits().into(), 2));
    image.plant.supply = 20.0 + 9.0 * random.uniform();
    image.plant.drop = any_drop(random);
    image.plant.state = State::new(position, 0.0);
    image.run_ms(30);
    perform(&mut image, &["set encoder_check 1"]);
    image
}

/// An actuator within its tolerances under any load that is declared, anywhere, also at either stop.
fn anywhere(seed: u64) -> (OperationOnHost<Motor>, Parameters) {
    let mut random = Random::new(seed, 20);
    let actuator = any_actuator(&mut random);
    let position = (1.2 * either_way(&mut random))
        .max(actuator.lower_stop)
        .min(actuator.upper_stop);
    (resting(&actuator, position, &mut random), actuator)
}

/// What came of an arming.
#[derive(Debug, Default)]
struct Outcome {
    /// Largest current, A.
    peak: f32,
    /// Largest way from where it was armed, rad.
    travel: f32,
    /// Until the encoder was known to follow, or the latch, s.
    seconds: f32,
    causes: Faults,
}

impl Outcome {
    fn worst(&mut self, other: &Self) {
        self.peak = self.peak.max(other.peak);
        self.travel = self.travel.max(other.travel);
        self.seconds = self.seconds.max(other.seconds);
    }
}

/// Until the brake counts as open, s.
const BRAKE: f32 = 0.1;

/// Arms it and lets it be for a third of a second.
fn arm(image: &mut OperationOnHost<Motor>) -> Outcome {
    let mut outcome = Outcome::default();
    image.type_in(b"arm\r");
    let start = image.plant.state.position.value();
    for _ in 0..6000 {
        image.tick();
        let state = &image.plant.state;
        if !image.wiring.encoder_follows() {
            outcome.peak = outcome.peak.max(state.current.abs());
            outcome.travel = outcome.travel.max((state.position.value() - start).abs());
            if !image.wiring.latch().is_tripped() {
                outcome.seconds += PLANT_PERIOD;
            }
        }
    }
    outcome.causes = image.wiring.latch().causes();
    outcome
}

/// How far a sound or a reversed encoder lets this rotor go, rad. It goes faster by *a* under all of the current, and by *n* under its load, where
/// that is more than friction. It falls by a line at first, and by what it goes in a control period. While the first push raises its current, for
/// 4 ms, it comes a line, or it comes one later and is slower. The current goes on for another control period. The second push turns it. That an
/// encoder goes faster the wrong way shows earlier.
fn most_way(actuator: &Parameters) -> f32 {
    let Drive::Voltage {
        torque_constant, ..
    } = actuator.drive
    else {
        panic!("the actuator has a winding");
    };
    let inertia = actuator.inertia;
    let a = torque_constant * most_current() / inertia;
    let n = (actuator.offset.abs() - actuator.coulomb.forward).max(0.0) / inertia;
    let (raised, period) = (4e-3_f32, 1e-3_f32);
    let pushed = raised + period;
    let line = 4.0 * EMA.converters.position.unit();
    let fallen = (line.sqrt() + (n / 2.0).sqrt() * period).powi(2);
    let falls = (2.0 * n * fallen).sqrt();
    let under_all = raised / 2.0 * period + period * period / 2.0;
    let up = falls * pushed + a * (raised * raised / 6.0 + under_all) + n * pushed * pushed / 2.0;
    let speed = falls + a * (raised / 2.0 + period) + n * pushed;
    let left = speed - a * raised / 2.0 + n * raised;
    let turned =
        speed * raised + (n / 2.0 - a / 6.0) * raised * raised + left * left / (2.0 * (a - n));
    fallen + up + turned
}

/// One whose encoder stands still: two pushes that move the lightest rotor, which nothing holds, by seven hundredths of the stroke each, and as
/// much until the second one has turned it.
const MOST_WAY_UNSEEN: f32 = 0.21 * STROKE;

/// 1.1 times what holds a rotor that is held as firmly as is declared, and brakes its load, A.
fn most_current() -> f32 {
    let [_, _, torque_constant] = winding();
    1.1 * ((1.0 + TOLERANCES.mechanics) * EMA.plant.breakaway.forward + 1.125 * EMA.limits.load)
        / ((1.0 - TOLERANCES.torque_constant) * torque_constant)
}

/// Two pushes in which the current is raised and held for 5 ms each, one that waits until the rotor has come back, 12 times as long, and as
/// much to come to rest, s.
const LONGEST: f32 = BRAKE + 17.0 * 5e-3;

#[test]
fn a_sound_encoder_is_known_to_follow_anywhere_under_any_load() {
    const RUNS: u64 = 1000;
    let mut worst = Outcome::default();
    for seed in 0..RUNS {
        let (mut image, actuator) = anywhere(seed);
        let status = image.line("status");
        assert!(status.contains("encoder: not checked"), "{status}");
        let outcome = arm(&mut image);
        assert!(
            outcome.causes.is_empty() && image.wiring.encoder_follows(),
            "{seed}: {outcome:?}"
        );
        assert!(
            outcome.travel <= most_way(&actuator)
                && outcome.peak <= most_current()
                && outcome.seconds <= LONGEST,
            "{seed}: {outcome:?}"
        );
        let status = image.line("status");
        assert!(status.contains("encoder: follows the rotor"), "{status}");
        worst.worst(&outcome);
    }
    println!("sound: {worst:?}");
}

/// The same actuators with encoders that failed before. Half is the right way: its scale is compared by both limit switches. A rotor that
/// its load drives is not held by a loop whose encoder stands still, from the brake's opening on.
#[test]
fn an_encoder_that_failed_is_found_before_its_loop_is_closed() {
    const RUNS: u64 = 700;
    for (name, share) in [("frozen", 0.0), ("backwards", -1.0), ("half", 0.5)] {
        let (mut found, mut without) = (0, 0);
        let (mut worst, mut overhauled) = (Outcome::default(), Outcome::default());
        for seed in 0..RUNS {
            let (mut image, actuator) = anywhere(seed);
            let by_its_load = actuator.offset.abs() > actuator.coulomb.forward;
            image.plant.encoder = share;
            let outcome = arm(&mut image);
            if outcome.causes.is_empty() {
                assert!(image.wiring.encoder_follows(), "{name}, {seed}");
            } else {
                let of_the_encoder = outcome.causes.are_of_the_encoder();
                assert!(of_the_encoder, "{name}, {seed}: {outcome:?}");
                assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
                assert!(!image.wiring.encoder_follows());
                found += 1;
            }
            assert!(
                outcome.peak <= most_current() && outcome.seconds <= LONGEST,
                "{name}, {seed}: {outcome:?}"
            );
            let most = if share == 0.0 {
                MOST_WAY_UNSEEN
            } else {
                most_way(&actuator)
            };
            assert!(
                by_its_load || outcome.travel <= most,
                "{name}, {seed}: {outcome:?}"
            );
            let (mut image, _) = anywhere(seed);
            image.plant.encoder = share;
            perform(&mut image, &["set encoder_check 0"]);
            without += u32::from(!arm(&mut image).causes.is_empty());
            if by_its_load {
                overhauled.worst(&outcome);
            } else {
                worst.worst(&outcome);
            }
        }
        println!("{name}: {found} of {RUNS}, {without} without the check");
        println!("{worst:?}, driven by its load {overhauled:?}");
        assert!(found == RUNS || share > 0.0, "{name}: {found}");
    }
}

/// Pressed against a stop, or held on its way, by all that is declared, on the heaviest rotor with the weakest magnets.
#[test]
fn a_rotor_that_is_held_as_firmly_as_is_declared_is_moved_from_a_stop_and_on_its_way() {
    let [resistance, inductance, torque_constant] = winding();
    let more = 1.0 + 0.99 * TOLERANCES.mechanics;
    let scaled = |level: Directional| Directional::both(more * level.forward);
    for load in [-1.0_f32, 0.0, 1.0] {
        for (stroke, position) in [(1.0, -1.0), (1.0, 0.0), (1.0, 1.0), (1.02, 1.02)] {
            for spring in [0.0, 0.1] {
                let actuator = Parameters {
                    drive: Drive::Voltage {
                        resistance,
                        inductance,
                        torque_constant: (1.0 - 0.99 * TOLERANCES.torque_constant)
                            * torque_constant,
                    },
                    inertia: (1.0 + TOLERANCES.inertia) * EMA.plant.inertia,
                    coulomb: scaled(EMA.plant.coulomb),
                    breakaway: scaled(EMA.plant.breakaway),
                    offset: 0.99 * load * EMA.limits.load,
                    spring: more * spring,
                    spring_preload: more * spring,
                    lower_stop: -stroke,
                    upper_stop: stroke,
                    ..EMA.plant
                };
                let mut image = resting(&actuator, position, &mut Random::new(1, 21));
                // The position counts from here.
                let rest = format!("set spring_rest {}", -position);
                let set = format!("set spring {spring}");
                let preload = format!("set spring_preload {spring}");
                perform(&mut image, &[&rest, &set, &preload]);
                let outcome = arm(&mut image);
                let case = format!("{load}, {position}, {spring}: {outcome:?}");
                assert!(outcome.causes.is_empty(), "{case}");
                assert!(image.wiring.encoder_follows(), "{case}");
            }
        }
    }
}

/// Nothing tells it from an encoder that stands still.
#[test]
fn a_rotor_that_cannot_move_either_way_is_a_following_error() {
    for seed in 0..50 {
        let (mut image, _) = anywhere(seed);
        image.plant.block();
        // Against a stop it is blocked one way, on its way both.
        let outcome = arm(&mut image);
        assert_eq!(outcome.causes, Fault::FollowingError.into(), "{seed}");
        assert!(outcome.travel < 1e-3, "{seed}: {outcome:?}");
    }
}

#[test]
fn without_its_parameter_an_arming_moves_nothing() {
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
    image.run_ms(30);
    let status = image.line("status");
    assert!(!status.contains("encoder"), "{status}");
    let outcome = arm(&mut image);
    assert!(outcome.causes.is_empty());
    assert_eq!((outcome.peak, outcome.travel), (0.0, 0.0));
}

#[test]
fn it_is_checked_once_before_a_loop_is_closed_and_again_behind_a_fault_of_it() {
    let mut image = resting(&EMA.plant, 0.0, &mut Random::new(2, 21));
    // A voltage asks no encoder.
    perform(&mut image, &["zero", "mode voltage"]);
    assert!(arm(&mut image).travel < 1e-4);
    assert!(!image.wiring.encoder_follows());
    // What is commanded meanwhile begins when it is done.
    perform(&mut image, &["mode position", "step 0 0.3"]);
    image.run_ms(60);
    let position = image.plant.state.position.value();
    assert!(
        !image.wiring.encoder_follows() && position.abs() < 1e-3,
        "{position}"
    );
    image.run_ms(600);
    let position = image.plant.state.position.value();
    assert!(
        image.wiring.encoder_follows() && (position - 0.3).abs() < 0.1,
        "{position}"
    );
    perform(&mut image, &["disarm"]);
    let outcome = arm(&mut image);
    assert!(
        outcome.travel < 1e-4 && outcome.causes.is_empty(),
        "{outcome:?}"
    );

    image.plant.encoder = 0.0;
    perform(&mut image, &["step 0.3 -0.9"]);
    image.run_ms(300);
    assert!(image.wiring.latch().causes().are_of_the_encoder());
    perform(&mut image, &["disarm", "clear"]);
    let outcome = arm(&mut image);
    assert!(outcome.causes.are_of_the_encoder(), "{outcome:?}");
    image.plant.encoder = 1.0;
    perform(&mut image, &["disarm", "clear"]);
    let outcome = arm(&mut image);
    assert!(
        outcome.causes.is_empty() && image.wiring.encoder_follows(),
        "{outcome:?}"
    );
}

/// Where the limit switches are, rad.
const EDGES: [f32; 2] = [-0.9, 0.85];

/// Towards a switch that is open nothing drives. Away from it is away.
#[test]
fn on_an_open_switch_it_is_pushed_away_from_it_alone() {
    for (position, side) in [(EDGES[0] - 0.03, -1.0), (EDGES[1] + 0.03, 1.0)] {
        for (share, follows) in [(1.0, true), (0.0, false), (-1.0, false)] {
            let mut image = resting(&EMA.plant, position, &mut Random::new(3, 21));
            image.plant.edges = EDGES;
            image.plant.encoder = share;
            image.run_ms(20);
            let outcome = arm(&mut image);
            assert_eq!(
                image.wiring.encoder_follows(),
                follows,
                "{share}: {outcome:?}"
            );
            assert_eq!(outcome.causes.are_of_the_encoder(), !follows, "{share}");
            assert!(side * (image.plant.state.position.value() - position) < 1e-3);
        }
    }
}

/// Seeks a switch: whether it was found there.
fn home(image: &mut OperationOnHost<Motor>, name: &str, position: f32, speed: f32) -> bool {
    perform(image, &[&format!("home {name} {position} {speed}"), "arm"]);
    image.said.clear();
    for _ in 0..(2500.0 * STROKE / speed) as u32 {
        image.run_ms(1);
        if !image.plant.is_driven() {
            break;
        }
    }
    image.run_ms(10);
    perform(image, &["disarm"]);
    image.said.contains("switch is at")
}

#[test]
fn both_switches_compare_the_encoder_with_the_stroke() {
    for seed in 0..60 {
        let mut random = Random::new(seed, 22);
        let share = [1.0, 0.5, 2.0, 0.9, 1.1][seed as usize % 5];
        let (mut image, _) = anywhere(seed);
        image.plant.edges = EDGES;
        image.plant.encoder = share;
        image.run_ms(20);
        perform(
            &mut image,
            &["set position_minimum -0.8", "set position_maximum 0.8"],
        );
        let speed = 0.2 + 0.8 * random.uniform();
        let mut ends = [("lower", EDGES[0]), ("upper", EDGES[1])];
        if random.uniform() < 0.5 {
            ends.reverse();
        }
        // A switch may open as far from where it is declared as a stop may be.
        let mut found = Vec::new();
        for (name, edge) in ends {
            let declared = edge + 0.9 * TOLERANCES.stop * STROKE * either_way(&mut random);
            if image.wiring.latch().causes().is_empty() {
                found.push(home(&mut image, name, declared, speed));
            }
        }
        let causes = image.wiring.latch().causes();
        let case = format!("{seed}: {share}, {found:?}, {causes}, {}", image.said);
        perform(&mut image, &["disarm"]);
        if share == 1.0 {
            assert_eq!((found, causes), (vec![true; 2], Faults::NONE), "{case}");
            perform(&mut image, &["arm"]);
        } else {
            // Where the encoder counts more, the stroke may end before a switch.
            assert!(found != [true; 2], "{case}");
            if !causes.is_empty() {
                // A scale that is off is a fault of the encoder also where the operator finds it.
                let of_the_encoder = causes.are_of_the_encoder();
                assert!(
                    !(of_the_encoder && image.wiring.encoder_follows()),
                    "{case}"
                );
                // What was pressed against a stop cools down first.
                image.run_ms(20_000);
                perform(&mut image, &["clear"]);
            }
            if !causes.is_empty() || found.last() == Some(&false) {
                let refused = image.line("arm");
                assert!(refused.contains("not known"), "{case}: {refused}");
            }
        }
    }
}

/// A machine over decades of inertia, friction and load, declared as it is, and its start.
fn any_machine(random: &mut Random) -> Option<OperationOnHost<Motor>> {
    let decades =
        |random: &mut Random, low: f32, high: f32| low * (high / low).powf(random.uniform());
    let [resistance, inductance, _] = winding();
    let torque_constant = decades(random, 0.03, 0.6);
    let inertia = decades(random, 3e-5, 2e-2);
    // Of the torque at 12 A.
    let load = 12.0 * torque_constant * decades(random, 0.02, 0.7);
    let friction = 0.7 * load * decades(random, 0.02, 1.0);
    let mut off = |share: f32| 1.0 + 0.95 * share * either_way(random);
    let grown = off(TOLERANCES.mechanics);
    let actuator = Parameters {
        drive: Drive::Voltage {
            resistance,
            inductance,
            torque_constant: torque_constant * off(TOLERANCES.torque_constant),
        },
        inertia: inertia * off(TOLERANCES.inertia),
        viscous: Directional::both(0.0),
        coulomb: Directional::both(0.8 * friction * grown),
        breakaway: Directional::both(friction * grown),
        offset: load * either_way(random),
        ..EMA.plant
    };
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
    image.plant.state = State::new(0.9 * either_way(random), 0.0);
    image.run_ms(30);
    let set = [
        ("coulomb", 0.0),
        ("viscous", 0.0),
        ("static", friction),
        ("coulomb", 0.8 * friction),
        ("torque_constant", torque_constant),
        ("inertia", inertia),
        ("load", load),
        ("encoder_check", 1.0),
    ];
    let are_taken = set
        .into_iter()
        .all(|(name, value)| image.line(&format!("set {name} {value}")) == "ok");
    are_taken.then_some(image)
}

/// An encoder rounds, whatever the machine: what it rounds is no motion. And one that counts backwards is found on all of them.
#[test]
fn a_sound_encoder_follows_on_machines_of_any_inertia_friction_and_load() {
    let (mut taken, mut lost) = (0, Vec::new());
    for seed in 0..1500 {
        for share in [1.0, -1.0] {
            let Some(mut image) = any_machine(&mut Random::new(seed, 23)) else {
                continue;
            };
            taken += 1;
            image.plant.encoder = share;
            image.type_in(b"arm\r");
            for _ in 0..4000 {
                image.run_ms(1);
                if image.wiring.encoder_follows() || image.wiring.latch().is_tripped() {
                    break;
                }
            }
            if image.wiring.encoder_follows() != (share > 0.0) {
                lost.push((seed, share, image.wiring.latch().causes()));
            }
        }
    }
    println!("{taken} of 3000 taken");
    assert!(lost.is_empty(), "{} of {taken}: {lost:?}", lost.len());
    assert!(taken > 1500, "{taken}");
}

/// The pushes may pass the edge that is sought. The position that is told is right all the same.
#[test]
fn a_search_begins_behind_the_pushes_however_near_its_switch_is() {
    for seed in 0..200 {
        let mut random = Random::new(seed, 24);
        let actuator = any_actuator(&mut random);
        let away = 0.05 * random.uniform();
        let (name, place, position) = if random.uniform() < 0.5 {
            ("lower", EDGES[0], EDGES[0] + away)
        } else {
            ("upper", EDGES[1], EDGES[1] - away)
        };
        let mut image = resting(&actuator, position, &mut random);
        image.plant.edges = EDGES;
        image.run_ms(20);
        let speed = 0.2 + 0.8 * random.uniform();
        perform(
            &mut image,
            &[&format!("home {name} {place} {speed}"), "arm"],
        );
        image.said.clear();
        let mut fastest = 0.0_f32;
        for _ in 0..(2e3 * STROKE / speed) as u32 {
            image.run_ms(1);
            if image.wiring.encoder_follows() {
                fastest = fastest.max(image.plant.state.velocity.value().abs());
            }
            if !image.plant.is_driven() {
                break;
            }
        }
        image.run_ms(10);
        let case = format!("{seed}: {away}, {name}, {}", image.said);
        assert!(image.wiring.latch().causes().is_empty(), "{case}");
        assert!(image.said.contains("switch is at"), "{case}");
        let reading = image.wiring.measurement().position;
        let unit = EMA.converters.position.unit();
        let read = EMA.converters.position.value(reading);
        let off = (read - image.plant.state.position.value()).abs();
        assert!(
            off <= fastest * 1e-3 + 2.0 * unit,
            "{off} of {fastest}, {case}"
        );
    }
}

/// Orders that come in one control step. Nothing is driven until the brake is open, and then pushed.
#[test]
fn orders_in_one_step_command_nothing_before_the_check() {
    for (before, batch) in [
        (
            vec!["zero", "mode voltage", "arm"],
            "mode position\rstep 0 0.4\r",
        ),
        (
            vec!["zero", "mode voltage"],
            "mode position\rarm\rstep 0 0.4\r",
        ),
        (
            vec!["zero", "mode voltage", "arm", "step 2 2"],
            "mode position\rhold\r",
        ),
    ] {
        let mut image = resting(&EMA.plant, 0.0, &mut Random::new(4, 21));
        image.plant.noise = None;
        perform(&mut image, &before);
        image.run_ms(20);
        perform(&mut image, &["record 0 100 command command position"]);
        image.type_in(batch.as_bytes());
        // 2 V decay first.
        image.run_ms(10);
        for _ in 0..80 {
            image.run_ms(1);
            let current = image.plant.state.current;
            assert!(current.abs() < 0.01, "{batch:?}: {current} A");
        }
        // The signal begins behind the check.
        let status = image.line("status");
        assert!(status.contains("capture: waiting"), "{batch:?}: {status}");
        image.run_ms(700);
        assert!(image.wiring.encoder_follows(), "{batch:?}");
        let target = if batch.contains("step") { 0.4 } else { 0.0 };
        let position = image.plant.state.position.value();
        assert!((position - target).abs() < 0.1, "{batch:?}: {position}");
        let status = image.line("status");
        assert_eq!(
            !status.contains("capture: waiting"),
            batch.contains("step"),
            "{status}"
        );
    }
}

/// With one push left, under any load: an encoder that counts backwards never passes. The loop that takes a sound one over
/// begins without an integral: a load towards the switch brings the actuator back before it is held. It swings on no actuator.
#[test]
fn on_an_open_switch_a_load_proves_nothing() {
    let (mut worst, mut stopped) = (Outcome::default(), 0);
    for seed in 0..400 {
        for share in [1.0, -1.0] {
            let mut random = Random::new(seed, 25);
            let actuator = any_actuator(&mut random);
            let (position, towards) = if random.uniform() < 0.5 {
                (EDGES[0] - 0.03, -1.0)
            } else {
                (EDGES[1] + 0.03, 1.0)
            };
            let mut image = resting(&actuator, position, &mut random);
            image.plant.edges = EDGES;
            image.plant.encoder = share;
            image.run_ms(20);
            let outcome = arm(&mut image);
            let case = format!("{seed}: {share}, {}, {outcome:?}", actuator.offset);
            // What closed the switch and is brought back onto it is at an end of the way.
            let back = outcome.causes == Fault::StopReached.into();
            if share > 0.0 {
                assert!(image.wiring.encoder_follows(), "{case}");
                assert!(
                    !back || towards * actuator.offset > actuator.coulomb.forward,
                    "{case}"
                );
                stopped += u32::from(back);
            } else {
                assert!(!image.wiring.encoder_follows(), "{case}");
                assert!(!outcome.causes.is_empty(), "{case}");
            }
            assert!(outcome.peak <= 1.1 * EMA.limits.current(), "{case}");
            worst.worst(&outcome);
            if share > 0.0 && !back {
                // Friction may let go once and again, but nothing swings.
                image.run_ms(300);
                let turns = turns(&mut image, 200);
                assert!(turns < 2, "{case}: {turns} turns");
            }
        }
    }
    println!("one switch open: {worst:?}, {stopped} brought back onto it");
}

#[test]
fn whether_it_is_checked_is_set_at_rest() {
    let mut image = resting(&EMA.plant, 0.0, &mut Random::new(5, 21));
    perform(&mut image, &["zero", "arm"]);
    for value in [0, 1] {
        let refused = image.line(&format!("set encoder_check {value}"));
        assert_eq!(refused, "refused: the drive is armed; `disarm` it first");
    }
}
