//! Promise: where a log cannot tell effects apart, `gap` names an input that would, within what the
//! machine has been shown to take; and the log of that input does, also where the machine's numbers are
//! a little off those that were fitted. Where nothing was found because fitted parameters absorb what an
//! effect does, the input shows it, and shows nothing where there is nothing.
//!
//! The excitations, the limits and the choice among them were worked out on other strengths.

use std::fs;
use std::path::Path;
use std::process::Command;

use host_tests::gap::engine;
use host_tests::gap::experiment::{self, NextExperiment};
use host_tests::gap::outcome::{FoundEffect, Outcome};
use host_tests::log::Log;
use host_tests::machine::Machine;
use model_core::gap::verdict::Verdict;
use rig::{
    Effect, EffectKind, Experiment, Machine as RigMachine, Move, Noise, Recording, Stops,
    Trajectory,
};
use serde_json::Value;
use tempfile::TempDir;

/// Strength of the effects, of nominal.
const STRENGTH: f64 = 0.9;

/// A machine with stops a tenth of its stroke beyond it, which a proposal must stay clear of.
fn with_stops(machine: RigMachine) -> RigMachine {
    let (centre, reach) = (machine.centre(), 1.2 * machine.amplitude());
    RigMachine {
        stops: Some(Stops {
            lower: centre - reach,
            upper: centre + reach,
        }),
        ..machine
    }
}

/// To and fro at one slow speed.
fn slow_triangle(machine: &RigMachine) -> Experiment {
    let triangle = Trajectory::Triangle {
        centre: machine.centre(),
        amplitude: 0.8 * machine.amplitude(),
        period: 4.0,
    };
    Experiment::tracking(machine.clone(), triangle)
}

/// Three sines at half the speed that the machine has: a quarter of the accelerations.
fn slow_sines(machine: &RigMachine) -> Trajectory {
    Trajectory::sines(&RigMachine {
        speed: 0.5 * machine.speed,
        ..machine.clone()
    })
}

/// Once over the stroke: position and time are one.
fn single_pass(machine: &RigMachine) -> Experiment {
    let pass = Trajectory::Moves {
        start: machine.stroke.0,
        moves: vec![Move {
            target: machine.stroke.1,
            speed: 2.0 * machine.amplitude() / 5.0,
            acceleration: machine.speed / 0.1,
            dwell: 10.0,
        }],
    };
    Experiment::tracking(machine.clone(), pass).lasting(5.0)
}

/// A machine with what nobody declared, and the files that its user has.
struct Bench {
    directory: TempDir,
    effects: Vec<Effect>,
    declared: Machine,
}

impl Bench {
    fn new(machine: &RigMachine, kind: EffectKind) -> Self {
        Self::with(machine, &[kind])
    }

    fn with(machine: &RigMachine, kinds: &[EffectKind]) -> Self {
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("machine.toml");
        fs::write(&file, machine.to_toml()).unwrap();
        Self {
            declared: Machine::read(&file).unwrap(),
            directory,
            effects: kinds
                .iter()
                .map(|&kind| Effect::nominal(kind, machine).scaled(STRENGTH))
                .collect(),
        }
    }

    /// What a tracing of these logs names: an effect and those that the logs cannot tell from it.
    fn named(&self, logs: &[Log]) -> Vec<Vec<String>> {
        let outcome = engine::run(&self.declared, logs, || Ok(Vec::new()), |_| ())
            .unwrap()
            .outcome;
        let class = |found: &FoundEffect| {
            let id = std::iter::once(found.id.clone());
            id.chain(found.equivalent.iter().cloned()).collect()
        };
        outcome.effects.iter().map(class).collect()
    }

    fn record(&self, experiment: Experiment, seed: u64) -> Recording {
        experiment.with_effects(&self.effects).seeded(seed).run()
    }

    fn log(&self, name: &str, recording: &Recording) -> Log {
        let path = self.directory.path().join(name);
        fs::write(&path, recording.to_csv()).unwrap();
        Log::read(&path).unwrap()
    }

    fn next(&self, log: &Log) -> (Outcome, Option<NextExperiment>) {
        let train = std::slice::from_ref(log);
        let found = engine::trace(&self.declared, train, || Ok(Vec::new()), |_| ()).unwrap();
        let found = found.found().unwrap();
        let next = experiment::next(&self.declared, train, &found).unwrap();
        (found.report.outcome, next)
    }
}

/// The input of a CSV with the columns `time_s` and `input`, as somebody who plays it reads it, and its
/// sampling rate.
fn input_of(csv: &str) -> (Vec<f64>, f64) {
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("time_s,input"));
    let rows: Vec<(f64, f64)> = lines
        .map(|line| {
            let (time, input) = line.split_once(',').unwrap();
            (time.parse().unwrap(), input.parse().unwrap())
        })
        .collect();
    let period = rows[1].0 - rows[0].0;
    for (row, (time, _)) in rows.iter().enumerate() {
        assert!((time - row as f64 * period).abs() < 1e-6 * period, "{row}");
    }
    (
        rows.into_iter().map(|(_, input)| input).collect(),
        1.0 / period,
    )
}

fn largest(series: &[f64]) -> f64 {
    series.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// The greatest speed over four samples, over which the limit is one: what a sensor shows of it.
fn fastest(recording: &Recording, rate: f64) -> f64 {
    let position = &recording.true_position;
    let moved = position.iter().zip(&position[4..]).map(|(a, b)| b - a);
    largest(&moved.collect::<Vec<f64>>()) * rate / 4.0
}

/// The share of the time for which a machine slides forward and backward at more than a hundredth of
/// the speed of another log.
fn sliding(recording: &Recording, first: &Recording) -> [f64; 2] {
    let clear = 0.01 * largest(&first.true_velocity);
    [1.0, -1.0].map(|sign| {
        let sliding = recording.true_velocity.iter();
        let sliding = sliding.filter(|velocity| sign * **velocity > clear).count();
        sliding as f64 / recording.true_velocity.len() as f64
    })
}

/// The words and the JSON call the same effects equivalent to the one that is in doubt.
fn says_what_the_answer_says(outcome: &Outcome, next: &NextExperiment, case: &str) {
    let [named, others @ ..] = &next.candidates[..] else {
        panic!("{case}: {next:?}");
    };
    let found = outcome.effects.iter().find(|found| found.id == *named);
    let equivalent = found.map_or(&[][..], |found| &found.equivalent[..]);
    assert_eq!(next.equivalent, equivalent, "{case}");
    let sentences = next.sentences("rad");
    let cannot = format!("The logs cannot tell {named} from ");
    let said = sentences.strip_prefix(&cannot);
    let said = said.map(|rest| rest.split('.').next().unwrap());
    assert_eq!(
        said.is_some(),
        !equivalent.is_empty(),
        "{case}: {sentences}"
    );
    for other in equivalent {
        assert!(
            said.unwrap().contains(other.as_str()),
            "{case}: {sentences}"
        );
    }
    let near = |other: &&String| !equivalent.contains(other);
    assert!(
        others.iter().filter(near).eq(&next.near),
        "{case}: {next:?}"
    );
}

/// The proposal for a log, as its user plays it.
struct Proposal {
    bench: Bench,
    machine: RigMachine,
    case: String,
    known: Log,
    first: Recording,
    noise: Noise,
    next: NextExperiment,
    input: Vec<f64>,
    rate: f64,
}

impl Proposal {
    /// Where the first log leaves the true effect among several.
    fn of(machine: &RigMachine, kind: EffectKind, first: Experiment, seed: u64) -> Self {
        let id = kind.id().unwrap();
        let (proposal, outcome) = Self::after(machine, &[kind], first, seed);
        let Self { next, case, .. } = &proposal;
        says_what_the_answer_says(&outcome, next, case);
        assert!(
            next.candidates.iter().any(|it| it == id),
            "{case}: {next:?}"
        );
        assert!(next.separates.iter().any(|it| it == id), "{case}: {next:?}");
        proposal
    }

    /// Where the first log shows nothing, for the fitted parameters absorb what an effect of this kind
    /// does. Whether the machine has it, the log does not tell.
    fn of_absorbed(
        machine: &RigMachine,
        (kind, present): (EffectKind, bool),
        first: Experiment,
        seed: u64,
    ) -> Self {
        let id = kind.id().unwrap();
        let there: &[EffectKind] = if present { &[kind] } else { &[] };
        let (proposal, outcome) = Self::after(machine, there, first, seed);
        let Self { next, case, .. } = &proposal;
        assert_eq!(outcome.verdict, Verdict::NoMissingEffect, "{case}");
        assert!(
            next.absorbed.iter().any(|absorbed| absorbed.id == id),
            "{case}: {next:?}"
        );
        assert_eq!(next.candidates[0], "no effect", "{case}");
        let sentences = next.sentences("rad");
        let (missing, _) = sentences.split_once(':').unwrap();
        assert!(
            missing.starts_with("These logs would not show") && missing.contains(id),
            "{case}: {sentences}"
        );
        proposal
    }

    /// What is proposed after a first log of a machine with these effects.
    fn after(
        machine: &RigMachine,
        kinds: &[EffectKind],
        first: Experiment,
        seed: u64,
    ) -> (Self, Outcome) {
        let case = format!("{kinds:?} on {}, seed {seed}", machine.name);
        let bench = Bench::with(machine, kinds);
        let noise = first.noise;
        let first = bench.record(first, seed);
        let known = bench.log("first.csv", &first);
        let (outcome, next) = bench.next(&known);
        let next =
            next.unwrap_or_else(|| panic!("nothing in doubt: {case}: {:?}", outcome.effects));
        let plan = next.plan.as_ref();
        let plan = plan.unwrap_or_else(|| panic!("no experiment tells: {case}: {next:?}"));
        let (input, rate) = input_of(&plan.to_csv());
        assert!(
            largest(&input) <= largest(&first.input) * (1.0 + 1e-6),
            "{case}"
        );
        let proposal = Self {
            bench,
            machine: machine.clone(),
            case,
            known,
            first,
            noise,
            next,
            input,
            rate,
        };
        proposal.says_whether_it_is_confirmed();
        (proposal, outcome)
    }

    /// In words, as in the JSON. What was never rehearsed with success is not said to do alone either.
    fn says_whether_it_is_confirmed(&self) {
        let Self { next, case, .. } = self;
        let sentences = next.sentences("rad");
        let would = sentences.contains("An experiment in open loop would tell:");
        let may = sentences.contains("may tell, though no rehearsal of it does:");
        let expected = (next.confirmed, !next.confirmed);
        assert_eq!((would, may), expected, "{case}: {sentences}");
        assert!(next.confirmed || !next.alone, "{case}: {next:?}");
    }

    /// Its input on a machine.
    fn replay(&self, machine: RigMachine) -> Experiment {
        Experiment::replaying(machine, self.input.clone(), self.rate).with_noise(self.noise)
    }

    /// Its log on the machine, or on one with other numbers. It slides both ways, stays off its stops
    /// and becomes no faster than the proposal allows, which is half as fast again as it was.
    fn played(&self, machine: RigMachine, seed: u64) -> Recording {
        let case = &self.case;
        let stops = machine.stops.unwrap();
        let played = self.bench.record(self.replay(machine), seed);
        let inside = |position: &f64| *position > stops.lower && *position < stops.upper;
        assert!(played.true_position.iter().all(inside), "at a stop: {case}");
        let fastest = fastest(&played, self.rate);
        let limit = self.next.limits.speed;
        assert!(fastest <= limit, "{fastest}, {limit}: {case}");
        let sliding = sliding(&played, &self.first);
        assert!(
            sliding.iter().all(|share| *share > 0.05),
            "{sliding:?}: {case}"
        );
        played
    }

    /// The log beside the first one leaves the true effect alone, or among `left` others at most; where
    /// the log alone is said to be enough, it does so too.
    fn settles(&self, seed: u64, left: usize) {
        for off in [0.97, 1.03] {
            let mut other = self.machine.clone();
            other.coulomb *= off;
            other.static_friction *= off;
            other.inertia /= off;
            self.played(other, seed);
        }
        let played = self.played(self.machine.clone(), seed);
        let log = self.bench.log("second.csv", &played);
        let settled = |logs: &[Log]| {
            let named = self.bench.named(logs);
            let [class] = &named[..] else {
                panic!("{named:?}: {}", self.case);
            };
            let id = self.bench.effects[0].kind().id().unwrap();
            assert!(class.iter().any(|it| it == id), "{class:?}: {}", self.case);
            assert!(class.len() <= 1 + left, "{class:?}: {}", self.case);
            assert!(
                class.len() < self.next.candidates.len(),
                "{class:?}: {}",
                self.case
            );
        };
        if self.next.alone {
            settled(std::slice::from_ref(&log));
        }
        settled(&[self.known.clone(), log]);
    }
}

/// Whether a rehearsal had confirmed it.
fn is_settled(
    machine: &RigMachine,
    kind: EffectKind,
    first: Experiment,
    seed: u64,
    left: usize,
) -> bool {
    let proposal = Proposal::of(machine, kind, first, seed);
    proposal.settles(seed + 1, left);
    proposal.next.confirmed
}

/// At one speed friction that differs by direction is viscous, Coulomb's or a constant push.
fn viscous_friction_by_direction(seeds: &[u64]) {
    let machine = with_stops(RigMachine::rotary_ema());
    for &seed in seeds {
        let first = slow_triangle(&machine);
        let confirmed = is_settled(&machine, EffectKind::AsymmetricViscous, first, seed, 0);
        assert!(confirmed, "seed {seed}");
    }
}

/// The search for it takes minutes, and is done on such a log by `the_command_leaves_it_as_a_file` too.
#[test]
#[ignore = "other cases"]
fn viscous_friction_by_direction_is_told_from_a_push() {
    viscous_friction_by_direction(&[6101]);
}

#[test]
#[ignore = "at length"]
fn viscous_friction_by_direction_is_told_from_a_push_in_another_log() {
    viscous_friction_by_direction(&[6103]);
}

/// While the motor drives, brushes and dead time take the same voltage.
#[test]
#[ignore = "other cases"]
fn brushes_are_told_from_dead_time() {
    let machine = with_stops(RigMachine::rotary_ema());
    let triangle = Experiment::tracking(machine.clone(), Trajectory::triangle(&machine));
    is_settled(&machine, EffectKind::BrushDrop, triangle, 6201, 0);
}

#[test]
#[ignore = "at length"]
fn dead_time_is_told_from_brushes() {
    let machine = with_stops(RigMachine::rotary_ema());
    let triangle = Experiment::tracking(machine.clone(), Trajectory::triangle(&machine));
    is_settled(&machine, EffectKind::DeadTime, triangle, 6203, 0);
}

/// On a single pass what depends on the position depends on time, and a torque on friction.
fn what_a_single_pass_mixes(seeds: &[u64]) {
    let machine = with_stops(RigMachine::force_slide());
    for &seed in seeds {
        let first = single_pass(&machine);
        is_settled(&machine, EffectKind::FrictionDrift, first, seed, 0);
    }
}

#[test]
#[ignore = "other cases"]
fn what_a_single_pass_mixes_is_told_apart() {
    what_a_single_pass_mixes(&[6301]);
}

#[test]
#[ignore = "at length"]
fn what_another_single_pass_mixes_is_told_apart() {
    what_a_single_pass_mixes(&[6303]);
}

/// After a log that would not show an effect: where the machine has it, the log of what is proposed names it,
/// and of a machine without it that log shows nothing.
fn shows_an_absorbed_effect(machine: &RigMachine, kind: EffectKind, first: &Experiment, seed: u64) {
    let present = Proposal::of_absorbed(machine, (kind, true), first.clone(), seed);
    assert!(present.next.confirmed, "{}", present.case);
    present.settles(seed + 1, 0);
    let healthy = Bench::with(machine, &[]);
    let known = healthy.log("first.csv", &healthy.record(first.clone(), seed + 2));
    let played = healthy.record(present.replay(machine.clone()), seed + 3);
    let named = healthy.named(&[known, healthy.log("second.csv", &played)]);
    assert!(named.is_empty(), "{named:?}: {}", present.case);
}

/// What is proposed after such a log of a machine that has not the effect, whether a rehearsal confirms it or not:
/// its log shows nothing.
fn shows_no_absent_effect(machine: &RigMachine, kind: EffectKind, first: &Experiment, seed: u64) {
    let absent = Proposal::of_absorbed(machine, (kind, false), first.clone(), seed + 4);
    let played = absent.played(machine.clone(), seed + 5);
    let log = absent.bench.log("second.csv", &played);
    let named = absent.bench.named(&[absent.known.clone(), log]);
    assert!(named.is_empty(), "{named:?}: {}", absent.case);
}

/// Friction stops the machine in these sines, the motor never has to: what grows with its torque is then a
/// part of Coulomb's friction, of the viscous one and of the inertia.
fn sines_that_absorb_it(machine: &RigMachine) -> Experiment {
    let noise = Noise::potentiometer(machine);
    Experiment::tracking(machine.clone(), slow_sines(machine)).with_noise(noise)
}

fn friction_that_grows_with_load(machine: &RigMachine, seed: u64) {
    let first = sines_that_absorb_it(machine);
    shows_an_absorbed_effect(machine, EffectKind::LoadDependentFriction, &first, seed);
}

fn no_friction_that_grows_with_load(machine: &RigMachine, seed: u64) {
    let first = sines_that_absorb_it(machine);
    shows_no_absent_effect(machine, EffectKind::LoadDependentFriction, &first, seed);
}

#[test]
#[ignore = "other cases"]
fn no_friction_that_grows_with_load_is_shown_where_there_is_none() {
    no_friction_that_grows_with_load(&with_stops(RigMachine::force_slide()), 6911);
}

#[test]
#[ignore = "at length"]
fn no_friction_of_an_actuator_that_grows_with_load_is_shown_where_there_is_none() {
    no_friction_that_grows_with_load(&with_stops(RigMachine::rotary_ema()), 6941);
}

#[test]
fn friction_that_grows_with_load_is_shown_where_a_log_absorbs_it() {
    friction_that_grows_with_load(&with_stops(RigMachine::force_slide()), 6911);
}

#[test]
#[ignore = "at length"]
fn friction_of_an_actuator_that_grows_with_load_is_shown_where_a_log_absorbs_it() {
    friction_that_grows_with_load(&with_stops(RigMachine::rotary_ema()), 6941);
}

/// Logs that hardly pass breakaway: what is proposed for them moves the machine all the same.
#[test]
#[ignore = "at length"]
fn nothing_is_proposed_that_breakaway_decides() {
    let machine = with_stops(RigMachine::rotary_ema());
    let mut proposed = 0;
    for (case, kind) in [EffectKind::DeadTime, EffectKind::BrushDrop]
        .repeat(2)
        .into_iter()
        .enumerate()
    {
        let seed = 6471 + 2 * case as u64;
        let bench = Bench::new(&machine, kind);
        let first = bench.record(slow_triangle(&machine), seed);
        let (_, next) = bench.next(&bench.log("first.csv", &first));
        let Some(plan) = next.as_ref().and_then(|next| next.plan.as_ref()) else {
            continue;
        };
        proposed += 1;
        let (input, rate) = input_of(&plan.to_csv());
        let replay = Experiment::replaying(machine.clone(), input, rate);
        let sliding = sliding(&bench.record(replay, seed + 1), &first);
        assert!(
            sliding.iter().all(|share| *share > 0.05),
            "{sliding:?}, {next:?}"
        );
    }
    assert!(proposed > 0);
}

/// Without a current nobody can tell a late drive from a late sensor, whatever the input.
#[test]
fn a_pair_that_no_input_separates_is_said_to_be_one() {
    let machine = with_stops(RigMachine::force_slide());
    let bench = Bench::new(&machine, EffectKind::SensorDelay);
    let sweep = Trajectory::sweep(&machine, 10.0);
    let first = bench.record(Experiment::tracking(machine.clone(), sweep), 6501);
    let (outcome, next) = bench.next(&bench.log("first.csv", &first));
    let next = next.unwrap();
    says_what_the_answer_says(&outcome, &next, "sensor_delay");
    assert!(
        next.candidates.iter().any(|it| it == "sensor_delay"),
        "{next:?}"
    );
    assert!(next.plan.is_none() && next.separates.is_empty(), "{next:?}");
    let sentences = next.sentences("m");
    assert!(
        sentences.contains("No input that was tried would")
            && sentences.contains("with an input up to")
            && sentences.contains("widens these limits"),
        "{sentences}"
    );
}

/// Six turns tell lost motion from a late reading.
#[test]
fn turns_that_tell_are_followed_by_nothing() {
    let machine = with_stops(RigMachine::force_slide());
    for seed in [6401, 6403] {
        let bench = Bench::new(&machine, EffectKind::Backlash);
        let log = bench.log("first.csv", &bench.record(slow_triangle(&machine), seed));
        let (outcome, next) = bench.next(&log);
        let named: Vec<&str> = outcome.effects.iter().map(|it| &*it.id).collect();
        assert_eq!(named, ["backlash"], "seed {seed}");
        assert!(outcome.effects[0].equivalent.is_empty(), "seed {seed}");
        assert!(next.is_none(), "seed {seed}: {next:?}");
    }
}

/// A load that came and went is in the logs that are there, and no input brings it back.
#[test]
fn nothing_is_proposed_for_a_load_that_acted_once() {
    let machine = with_stops(RigMachine::force_slide());
    let bench = Bench::new(&machine, EffectKind::ExternalLoad);
    for first in [slow_triangle(&machine), single_pass(&machine)] {
        let log = bench.log("first.csv", &bench.record(first, 6651));
        let (outcome, next) = bench.next(&log);
        let named = outcome.effects.first().map(|effect| &*effect.id);
        let candidates = next.map_or(Vec::new(), |next| next.candidates);
        assert!(
            !candidates.iter().any(|it| it == "external_load"),
            "{named:?}: {candidates:?}"
        );
    }
}

/// A sweep tells a spring from everything else, and where nothing is missing there is no doubt.
#[test]
fn a_log_that_tells_is_followed_by_nothing() {
    let machine = with_stops(RigMachine::force_slide());
    let bench = Bench::new(&machine, EffectKind::Spring);
    let sweep = || Experiment::tracking(machine.clone(), Trajectory::sweep(&machine, 10.0));
    let log = bench.log("spring.csv", &bench.record(sweep(), 6601));
    let (outcome, next) = bench.next(&log);
    assert_eq!(outcome.effects[0].id, "spring");
    assert!(next.is_none(), "{next:?}");

    let log = bench.log("nothing.csv", &sweep().seeded(6602).run());
    let (outcome, next) = bench.next(&log);
    assert_eq!(outcome.verdict, Verdict::NoMissingEffect);
    assert!(next.is_none(), "{next:?}");
}

fn hil(directory: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_hil"))
        .current_dir(directory)
        .args(["gap", "--machine", "machine.toml", "--train", "first.csv"])
        .args(arguments)
        .output()
        .unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{error}");
    String::from_utf8(output.stdout).unwrap()
}

/// The terminal says it, the CSV is beside the report and where it was asked for, the JSON has it, the
/// page draws it.
#[test]
fn the_command_leaves_it_as_a_file() {
    let machine = with_stops(RigMachine::rotary_ema());
    let bench = Bench::new(&machine, EffectKind::AsymmetricViscous);
    bench.log("first.csv", &bench.record(slow_triangle(&machine), 6701));
    let directory = bench.directory.path();
    let text = hil(
        directory,
        &[
            "--json",
            "gap.json",
            "--report",
            "report",
            "--experiment",
            "next.csv",
        ],
    );
    let text: Vec<&str> = text.split_whitespace().collect();
    let text = text.join(" ");
    assert!(
        text.contains("one effect was missing, either asymmetric_viscous"),
        "{text}"
    );
    assert!(text.contains("next.csv"), "{text}");

    let asked = fs::read_to_string(directory.join("next.csv")).unwrap();
    let beside = fs::read_to_string(directory.join("report/next-experiment.csv")).unwrap();
    assert_eq!(asked, beside);
    let (input, rate) = input_of(&asked);
    assert!((rate - 1000.0).abs() < 1e-3);

    let json = fs::read_to_string(directory.join("gap.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let next = &json["next_experiment"];
    assert_eq!(next["file"], "next.csv");
    assert!(
        next["separates"]
            .as_array()
            .unwrap()
            .contains(&"asymmetric_viscous".into())
    );
    assert!(next["excitation"].is_string());
    assert!(next["separation"].as_f64().unwrap() > 1.0, "{next}");
    let duration = next["duration_s"].as_f64().unwrap();
    assert!((duration - input.len() as f64 / rate).abs() < 1e-6);

    let page = fs::read_to_string(directory.join("report/index.html")).unwrap();
    assert!(page.contains("<h2>Next experiment</h2>"));
    let options = roxmltree::ParsingOptions {
        allow_dtd: true,
        ..Default::default()
    };
    roxmltree::Document::parse_with_options(&page, options).unwrap();
}

/// The search takes many times as long as the tracing: who does not ask for it hears of the doubt alone.
#[test]
fn the_command_names_a_doubt_and_looks_no_further_unless_asked() {
    let machine = with_stops(RigMachine::rotary_ema());
    let bench = Bench::new(&machine, EffectKind::AsymmetricViscous);
    bench.log("first.csv", &bench.record(slow_triangle(&machine), 6701));
    let directory = bench.directory.path();
    let text = hil(directory, &["--json", "gap.json"]);
    let text: Vec<&str> = text.split_whitespace().collect();
    let text = text.join(" ");
    let doubt = "one effect was missing, either asymmetric_viscous, ";
    assert!(text.contains(doubt), "{text}");
    let remedy = "run it again with --experiment FILE, which writes an input that settles whether it is asymmetric_viscous or";
    assert!(text.contains(remedy), "{text}");
    assert!(text.contains(", if one is found"), "{text}");
    let json = fs::read_to_string(directory.join("gap.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let next = &json["next_experiment"];
    assert_eq!(next["looked"], false);
    assert!(next["excitation"].is_null());
    assert!(next["candidates"].as_array().unwrap().len() > 1);
}

/// Nothing in doubt: null, and no file.
#[test]
fn the_command_writes_nothing_where_nothing_is_in_doubt() {
    let machine = with_stops(RigMachine::force_slide());
    let bench = Bench::new(&machine, EffectKind::Spring);
    let sweep = Trajectory::sweep(&machine, 10.0);
    let recording = bench.record(Experiment::tracking(machine.clone(), sweep), 6801);
    bench.log("first.csv", &recording);
    let directory = bench.directory.path();
    let text = hil(
        directory,
        &["--json", "gap.json", "--experiment", "next.csv"],
    );
    assert!(!text.contains("settles"), "{text}");
    assert!(text.contains("next.csv was not written"), "{text}");
    assert!(!directory.join("next.csv").exists());
    let json = fs::read_to_string(directory.join("gap.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    assert!(json.get("next_experiment").unwrap().is_null());
}
