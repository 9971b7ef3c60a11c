//! Promise: `cargo hil gap --machine-out` writes the user's own machine file with what was found: nothing else
//! in it changes, it reads back, what was found is not missing from it, and where nothing can be said nothing
//! is written.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use host_tests::machine::Machine;
use host_tests::outputs::MARK;
use rig::{Effect, EffectKind, Experiment, Machine as RigMachine, Motor, Trajectory};
use serde_json::Value;
use tempfile::TempDir;

const MACHINE: &str = "machine.toml";
const TRAIN: &str = "train.csv";
const JSON: &str = "gap.json";
const NEW: &str = "refitted.toml";

/// The slide of the log as somebody wrote it down: sections in an order of their own, aligned comments, a list
/// over several lines.
const SLIDE: &str = "\
# The slide behind the window, as weighed in spring.
name = 'slide-95kg'   # its plate says otherwise
coordinate = \"m\"

[friction]            # by hand, with a spring balance
coulomb = 18.0        # N, both ways
static  = 24.0

[input]
kind = \"torque\"
gain = 35.0           # N for one unit

[fit]
# the spring stays as it is
parameters = [
    \"inertia\", \"viscous\",  # of the carriage
    \"coulomb\", \"static\",
]

[mechanics]
inertia = 9.0e1       # kg
viscous = 200         # N·s/m

# [sensor] comes last.
[sensor]
resolution = 1.0e-6
";

/// A directory with a machine file and a log.
struct Bench {
    directory: TempDir,
}

impl Bench {
    fn new(machine: &str, log: &str) -> Self {
        let directory = tempfile::tempdir().expect("a temporary directory");
        let bench = Self { directory };
        bench.write(MACHINE, machine);
        bench.write(TRAIN, log);
        bench
    }

    /// The slide that is pushed by a force that its file does not mention.
    fn pushed() -> Self {
        let rig = RigMachine::force_slide().to_toml();
        let rig = Machine::of_bytes(MACHINE.as_ref(), rig.into_bytes()).unwrap();
        let slide = Machine::of_bytes(MACHINE.as_ref(), SLIDE.as_bytes().to_vec()).unwrap();
        assert_eq!((slide.gain, slide.coordinate), (rig.gain, rig.coordinate));
        assert_eq!(slide.resolution, rig.resolution);
        Self::new(SLIDE, &crate::pushed_slide::log(6.0))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn write(&self, name: &str, content: &str) {
        fs::write(self.path(name), content).expect("a writable temporary directory");
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).expect(name)
    }

    fn run(&self, machine: &str, options: &[&str]) -> Output {
        let output = Command::new(env!("CARGO_BIN_EXE_hil"))
            .current_dir(self.directory.path())
            .args(["gap", "--machine", machine, "--train", TRAIN])
            .args(options)
            .output()
            .expect("hil starts");
        assert!(!text(&output.stderr).contains("panicked"));
        output
    }

    /// Traces with a machine file, and gives the answer in JSON and what was printed.
    #[track_caller]
    fn traced(&self, machine: &str, machine_out: &str) -> (Value, String) {
        let output = self.run(machine, &["--json", JSON, "--machine-out", machine_out]);
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let answer = serde_json::from_str(&self.read(JSON)).expect("JSON");
        (answer, text(&output.stdout).to_owned())
    }

    /// Nothing is written, and what is printed says so.
    #[track_caller]
    fn writes_nothing(&self, verdict: &str) {
        let (answer, printed) = self.traced(MACHINE, NEW);
        assert_eq!(answer["verdict"], verdict, "{printed}");
        assert!(answer.get("machine_out").is_none());
        let said = format!("{NEW} was not written: ");
        assert!(printed.contains(&said), "{printed}");
        assert!(!self.path(NEW).exists());
    }
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

/// Whether an answer names an effect.
fn names(answer: &Value, id: &str) -> bool {
    let effects = answer["effects"].as_array().unwrap();
    effects.iter().any(|effect| effect["id"] == id)
}

/// The windowed position error of a stage on the training log, m or rad.
fn rms(answer: &Value, stage: &str) -> f64 {
    let errors = &answer["errors"]["train"][stage];
    errors["position_rms"].as_f64().unwrap()
}

/// The name of the number that a line of a machine file sets.
fn set_by(line: &str) -> Option<&str> {
    Some(line.split_once('=')?.0.trim())
}

/// Asserts that a line has the fitted number, what it was, and an interval around it.
#[track_caller]
fn says_what_it_was(fit: &Value, line: &str, was: &str) {
    let (value, comment) = line.split_once('#').expect(line);
    let value: f64 = value.split_once('=').unwrap().1.trim().parse().unwrap();
    assert_eq!(value, fit["fitted"].as_f64().unwrap(), "{line}");
    let note = format!("was {was}; 95 %: ");
    let (_, interval) = comment.split_once(&note).expect(line);
    let (low, high) = interval.split_once(" to ").unwrap();
    let [low, high]: [f64; 2] = [low, high].map(|end| end.parse().unwrap());
    assert!(low < value && value < high, "{line}");
    let width = (high - low) / (2.0 * 1.96 * fit["std"].as_f64().unwrap());
    assert!((width - 1.0).abs() < 0.1, "{width} of the interval: {line}");
}

/// What was found, and nothing else, has changed; traced with it, the log has no missing effect.
#[test]
fn what_was_found_stands_in_the_users_own_file() {
    let bench = Bench::pushed();
    let (first, printed) = bench.traced(MACHINE, NEW);
    assert!(names(&first, "offset_torque"), "{printed}");
    assert_eq!(first["machine_out"], NEW);
    assert!(
        printed.contains(NEW) && !printed.contains("declared_effects"),
        "{printed}"
    );

    let written = bench.read(NEW);
    let (head, _) = written.split_once("\n\n").expect("a head of its own");
    for part in [MACHINE, TRAIN, "effects_found", "offset_torque"] {
        assert!(head.contains(part), "no {part}: {head}");
    }
    assert!(head.lines().all(|line| line.starts_with("# ")), "{head}");

    let fits = first["fit"].as_array().unwrap();
    let mut lines = written.lines();
    let mut fitted = 0;
    for line in SLIDE.lines() {
        let number = fits.iter().find(|fit| set_by(line) == fit["name"].as_str());
        let Some(fit) = number else {
            assert!(lines.any(|kept| kept == line), "no {line:?}: {written}");
            continue;
        };
        let new = lines.next().expect(line);
        let (declared, comment) = line.split_once('#').unwrap_or((line, ""));
        assert_eq!(set_by(new), set_by(line));
        assert!(new.contains(comment.trim_end()), "{new}");
        says_what_it_was(fit, new, declared.split_once('=').unwrap().1.trim());
        fitted += 1;
    }
    assert_eq!(fitted, 4);

    let machine = Machine::read(&bench.path(NEW)).expect("a machine file");
    let [declared] = &machine.declared_effects[..] else {
        panic!("{written}");
    };
    assert_eq!(declared.id, "offset_torque");

    // With the new file as the declared one, neither notes nor heads pile up.
    let (second, printed) = bench.traced(NEW, "again.toml");
    assert_eq!(second["verdict"], "no_missing_effect", "{printed}");
    let (found, declared) = (rms(&first, "after"), rms(&second, "declared"));
    assert!((declared / found - 1.0).abs() < 0.05, "{declared}, {found}");
    assert!(rms(&second, "before") < 1.05 * found, "{second}");
    let again = bench.read("again.toml");
    for line in again.lines().filter(|line| !line.starts_with('#')) {
        assert!(line.matches("was ").count() <= 1, "{line}");
    }
    assert_eq!(again.matches(MARK).count(), 1, "{again}");
    let (head, _) = again.split_once("\n\n").expect("a head of its own");
    assert!(
        head.contains(NEW) && head.contains("no_missing_effect"),
        "{head}"
    );
    assert!(again.contains("# The slide behind the window, as weighed in spring."));
    assert_eq!(bench.read(MACHINE), SLIDE);
}

/// Lines that end as on Windows do so in the new file.
#[test]
fn line_ends_stay_and_an_earlier_result_is_replaced() {
    let bench = Bench::pushed();
    bench.write(MACHINE, &SLIDE.replace('\n', "\r\n"));
    bench.traced(MACHINE, NEW);
    let first = bench.read(NEW);
    assert_eq!(first.matches("\r\n").count(), first.matches('\n').count());
    bench.traced(MACHINE, NEW);
    assert_eq!(bench.read(NEW), first);
}

/// A number that `[fit]` leaves out, and that is wrong.
#[test]
fn a_freed_number_is_set_too() {
    let declared = RigMachine::rotary_ema();
    let mut rig = declared.clone();
    let Motor::Winding { resistance, .. } = &mut rig.motor else {
        panic!("{} has no winding", rig.name);
    };
    let was = *resistance;
    *resistance *= 1.2;
    let motion = Trajectory::sines(&rig);
    let log = Experiment::tracking(rig, motion)
        .lasting(10.0)
        .seeded(72_821);
    let line = format!("resistance = {was:?}");
    let machine = declared.to_toml();
    assert_eq!(machine.matches(&line).count(), 1);
    let commented = format!("{line}  # cold, on the bench");
    let bench = Bench::new(&machine.replace(&line, &commented), &log.run().to_csv());
    let (answer, printed) = bench.traced(MACHINE, NEW);
    let mut fits = answer["fit"].as_array().unwrap().iter();
    let freed = fits
        .find(|fit| fit["freed"] == true)
        .expect("a freed number");
    assert_eq!(freed["name"], "resistance");
    assert!(!printed.contains("set `resistance"), "{printed}");

    let written = bench.read(NEW);
    let mut lines = written.lines();
    let line = lines
        .find(|line| set_by(line) == Some("resistance"))
        .unwrap();
    assert!(line.contains("# cold, on the bench; was "), "{line}");
    says_what_it_was(freed, line, &format!("{was:?}"));
    let found = Machine::read(&bench.path(NEW))
        .unwrap()
        .motor
        .unwrap()
        .resistance;
    assert!((found / was - 1.2).abs() < 0.02, "{found}");
    let (again, printed) = bench.traced(NEW, "again.toml");
    assert_eq!(again["verdict"], "no_missing_effect", "{printed}");
    let mut fits = again["fit"].as_array().unwrap().iter();
    assert!(fits.all(|fit| fit["freed"] == false), "{again}");
    let (found, before) = (rms(&answer, "after"), rms(&again, "before"));
    assert!((before / found - 1.0).abs() < 0.05, "{before}, {found}");
}

/// The fitted numbers are written, and the file says what it lacks.
#[test]
fn a_learned_law_is_not_declared_and_the_file_says_so() {
    let rig = RigMachine::rotary_ema();
    let rough = Effect::nominal(EffectKind::RoughSpot, &rig).scaled(0.7);
    let motion = Trajectory::sweep(&rig, 10.0);
    let machine = rig.to_toml();
    let log = Experiment::tracking(rig, motion)
        .with_effects(&[rough])
        .lasting(10.0)
        .seeded(3301);
    let bench = Bench::new(&machine, &log.run().to_csv());
    let (answer, printed) = bench.traced(MACHINE, NEW);
    assert_eq!(answer["verdict"], "unknown_effect", "{printed}");
    assert!(printed.contains(NEW), "{printed}");
    let written = bench.read(NEW);
    let head: String = written.split_once("\n\n").unwrap().0.replace("\n# ", " ");
    assert!(
        head.contains("unknown_effect, it depends on position"),
        "{head}"
    );
    assert!(head.contains("no machine file can declare it"), "{head}");
    assert_eq!(
        Machine::read(&bench.path(NEW)).unwrap().declared_effects,
        []
    );
}

#[test]
fn nothing_is_written_where_log_and_machine_disagree() {
    let bench = Bench::pushed();
    let rows = crate::pushed_slide::log(6.0);
    let milliseconds = rows.lines().enumerate().map(|(row, line)| match row {
        0 => line.to_owned(),
        _ => format!("{},{}", row - 1, line.split_once(',').unwrap().1),
    });
    bench.write(TRAIN, &(milliseconds.collect::<Vec<_>>().join("\n") + "\n"));
    bench.writes_nothing("log_and_machine_disagree");
}

/// A friction that no guess would be so far from: see `declared_guesses.rs`.
#[test]
fn nothing_is_written_where_nothing_is_proven() {
    let rig = RigMachine::rotary_ema();
    let declared = RigMachine {
        coulomb: 0.05 * rig.coulomb,
        static_friction: 0.05 * rig.static_friction,
        ..rig.clone()
    };
    let motion = Trajectory::sweep(&rig, 8.0);
    let log = Experiment::tracking(rig, motion).lasting(8.0).seeded(5109);
    Bench::new(&declared.to_toml(), &log.run().to_csv()).writes_nothing("nothing_proven");
}

#[test]
fn places_that_may_not_be_written_are_refused_before_the_work() {
    let bench = Bench::pushed();
    bench.write("mine.toml", SLIDE);
    for (place, expected) in [
        (MACHINE, "would be replaced"),
        (TRAIN, "would be replaced"),
        (JSON, "is another output"),
        ("mine.toml", "is no result of this program"),
    ] {
        let before = ["mine.toml", MACHINE, TRAIN].map(|name| bench.read(name));
        let output = bench.run(MACHINE, &["--json", JSON, "--machine-out", place]);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.starts_with(&format!("error: {place}: ")), "{error}");
        assert!(error.contains(expected), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty());
        assert_eq!(
            ["mine.toml", MACHINE, TRAIN].map(|name| bench.read(name)),
            before
        );
        assert!(!bench.path(JSON).exists());
    }
}

/// Without the option the answer names it, next to what it would write.
#[test]
fn the_answer_names_the_option() {
    let output = Bench::pushed().run(MACHINE, &[]);
    let printed = text(&output.stdout);
    assert!(printed.contains("--machine-out"), "{printed}");
    assert!(
        printed.contains("declared_effects = [{ id = \"offset_torque\""),
        "{printed}"
    );
}
