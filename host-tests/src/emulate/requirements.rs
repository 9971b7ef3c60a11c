//! What a user relies on, held against a run of the images.

use firmware::app::timing::STEPS_PER_SECOND;

use super::recording::{self, Recording};
use super::run::{Counted, Driven, Outcome, Store, Throttle};
use super::tracing::Traced;
use crate::gap::outcome::FoundEffect;

/// `FLASH_ACR` with five wait states, which 168 MHz ask for at 3.3 V, prefetch and both caches: RM0090, table
/// 10 and section 3.9.1.
const FLASH_ACCESS_CONTROL: u64 = 0x705;

/// Plant ticks a second.
const TICK_RATE: f64 = 20_000.0;

/// Longest that the program takes from power on to its first tick, s.
const START: f64 = 0.05;

/// Longest that the watchdog waits, ms: 20 counts of 32 cycles of its oscillator, 17 to 47 kHz.
const LONGEST_WATCHDOG_MS: f64 = 38.0;

/// Where the drive has to be after a step, rad: as far as friction may hold it off, breakaway · R / (k K_p).
const REACHED: f64 = 0.06;

/// What the throttle's console is told: its spring, N·m/rad.
const SPRING: f64 = 0.4;

/// What a run lacks; empty if it is in order.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Shortcomings(pub Vec<String>);

impl Shortcomings {
    /// Of the runs alone.
    pub fn of(outcome: &Outcome) -> Self {
        let mut found = Self::default();
        found.throttle(&outcome.throttle);
        found.store(&outcome.store);
        found.driven(&outcome.driven);
        found
    }

    /// Of the tracing.
    pub fn of_tracing(traced: &Traced) -> Self {
        let mut found = Self::default();
        let effects: Vec<&str> = traced.report.outcome.effects.iter().map(id).collect();
        found.require(effects == ["spring"], || {
            format!("the tracing names {effects:?}; the throttle has an undeclared spring")
        });
        let stiffness = traced
            .report
            .outcome
            .effects
            .iter()
            .flat_map(|effect| &effect.parameters)
            .find(|parameter| parameter.name == "stiffness")
            .map_or(f64::NAN, |parameter| parameter.value);
        found.require((stiffness / SPRING - 1.0).abs() < 0.1, || {
            format!("the tracing finds a stiffness of {stiffness} N·m/rad; it is {SPRING}")
        });
        let errors = traced.report.outcome.errors.validate.as_ref();
        let ratio = errors.map_or(f64::NAN, |errors| {
            errors.after.position_rms / errors.before.position_rms
        });
        found.require(ratio < 0.1, || {
            format!("the spring leaves {ratio} of the position error on the other drive")
        });
        found
    }

    /// Of what was recorded over the console.
    pub fn of_recording(recording: &Recording) -> Self {
        let mut found = Self::default();
        let least = (recording::SECONDS * f64::from(STEPS_PER_SECOND)) as usize;
        found.require(recording.rows >= least, || {
            format!(
                "the log over the console has {} rows of {least}",
                recording.rows
            )
        });
        found.require(recording.effects == ["spring"], || {
            format!(
                "the tracing of the log over the console names {:?}; the throttle has an undeclared spring",
                recording.effects
            )
        });
        found
    }

    fn require(&mut self, holds: bool, otherwise: impl FnOnce() -> String) {
        if !holds {
            self.0.push(otherwise());
        }
    }

    fn says(&mut self, who: &str, said: &str, part: &str) {
        self.require(said.contains(part), || {
            format!("{who}: expected {part:?}, got {said:?}")
        });
    }

    /// A part that means something else within a line: `armed` is in `disarmed`.
    fn begins_a_line(&mut self, who: &str, said: &str, part: &str) {
        self.require(said.lines().any(|line| line.starts_with(part)), || {
            format!("{who}: expected a line that begins with {part:?}, got {said:?}")
        });
    }

    fn throttle(&mut self, throttle: &Throttle) {
        let Throttle {
            greeting,
            status,
            status_with_motor_open,
            counted,
            faults_after_stopped_tick,
            reset_after_ms,
        } = throttle;
        self.says("throttle's greeting", greeting, "throttle: nothing stored");
        self.begins_a_line("throttle's status", status, "armed, position mode");
        for part in ["latched: none", NONE_MISSED] {
            self.says("throttle's status", status, part);
        }
        self.says(
            "throttle's status with its motor open",
            status_with_motor_open,
            NONE_MISSED,
        );
        self.counted("throttle", counted);
        self.require(*reset_after_ms <= LONGEST_WATCHDOG_MS, || {
            format!("the watchdog took {reset_after_ms} ms after the throttle's last tick")
        });
        self.says(
            "throttle's faults behind the watchdog's reset",
            faults_after_stopped_tick,
            "first: watchdog",
        );
    }

    fn store(&mut self, store: &Store) {
        let Store {
            first_greeting,
            saved,
            flash: [erased, programmed, set],
            second_greeting,
            shown,
            greeting_after_torn_save,
            faults_after_torn_save,
            shown_after_torn_save,
            torn_after_words,
        } = store;
        self.says(
            "controller's greeting",
            first_greeting,
            "controller: nothing stored",
        );
        self.says("`save`", saved, "ok");
        self.require(*erased > 0 && *programmed > 0, || {
            format!("`save` erased {erased} sectors and programmed {programmed} words")
        });
        self.require(*set == 0, || {
            format!("`save` programmed {set} words that were not erased")
        });
        self.says(
            "controller's greeting after an end of power",
            second_greeting,
            FIRST_COMMIT,
        );
        self.says("stored parameter", shown, STORED);
        // The cut comes long before the second commit: only the first one counts. What was begun is not
        // passed over: the store calls for a look at the values.
        let after = format!("after a power cut behind {torn_after_words} words of a `save`");
        for part in [FIRST_COMMIT, "store: a commit was cut short"] {
            self.says(
                &format!("controller's greeting {after}"),
                greeting_after_torn_save,
                part,
            );
        }
        self.begins_a_line(
            &format!("controller's faults {after}"),
            faults_after_torn_save,
            "first: store_corrupt",
        );
        self.says(
            &format!("stored parameter {after}"),
            shown_after_torn_save,
            STORED,
        );
    }

    fn driven(&mut self, driven: &Driven) {
        for (command, target, position) in &driven.positions {
            self.require((position - target).abs() < REACHED, || {
                format!("after {command} the throttle is at {position} rad, not at {target}")
            });
        }
        let boards = [
            ("controller", &driven.controller_status, &driven.controller),
            ("throttle", &driven.throttle_status, &driven.throttle),
        ];
        for (name, status, counted) in boards {
            let who = format!("{name}'s status in the loop");
            self.begins_a_line(&who, status, "armed, ");
            for part in ["latched: none", NONE_MISSED] {
                self.says(&who, status, part);
            }
            self.counted(name, counted);
        }
    }

    fn counted(&mut self, who: &str, counted: &Counted) {
        let Counted {
            time_s,
            plant_ticks,
            plant_ticks_missed,
            track_writes,
            resets,
            flash_access_control,
            ..
        } = counted;
        let expected = [(time_s - START) * TICK_RATE, time_s * TICK_RATE];
        let ticks = *plant_ticks as f64;
        self.require(expected[0] <= ticks && ticks <= expected[1], || {
            format!("{who}: {ticks} plant ticks in {time_s} s; expected 20,000 a second")
        });
        self.require(*plant_ticks_missed == 0 && *resets == 0, || {
            format!("{who}: {plant_ticks_missed} plant ticks missed, {resets} resets")
        });
        // The last tick may be under way.
        self.require(plant_ticks - track_writes.min(plant_ticks) <= 1, || {
            format!("{who}: {track_writes} writes of the tracks in {plant_ticks} ticks")
        });
        self.require(*flash_access_control == FLASH_ACCESS_CONTROL, || {
            format!(
                "{who}: FLASH_ACR reads {flash_access_control:#x}; caches, prefetch and five wait states \
                 are {FLASH_ACCESS_CONTROL:#x}"
            )
        });
    }
}

/// What the controller greets with while what the first `save` stored is in use.
const FIRST_COMMIT: &str = "controller: parameters of commit 1\n";

/// A parameter as the first `save` stored it.
const STORED: &str = "torque_constant = 0.38 ";

/// In a `status`.
const NONE_MISSED: &str = "deadlines missed: 0";

fn id(effect: &FoundEffect) -> &str {
    &effect.id
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counted() -> Counted {
        Counted {
            time_s: 1.0,
            instructions: 17_000_000,
            plant_ticks: 19_900,
            plant_ticks_missed: 0,
            longest_latency_us: 5.0,
            track_writes: 19_900,
            resets: 0,
            flash_access_control: FLASH_ACCESS_CONTROL,
        }
    }

    fn shortcomings(counted: &Counted) -> Vec<String> {
        let mut found = Shortcomings::default();
        found.counted("throttle", counted);
        found.0
    }

    #[test]
    fn each_count_that_is_off_is_named() {
        assert!(shortcomings(&counted()).is_empty());
        let off = [
            Counted {
                plant_ticks: 18_000,
                track_writes: 18_000,
                ..counted()
            },
            Counted {
                plant_ticks_missed: 1,
                ..counted()
            },
            Counted {
                track_writes: 19_000,
                ..counted()
            },
            Counted {
                resets: 1,
                ..counted()
            },
            Counted {
                flash_access_control: 5,
                ..counted()
            },
        ];
        for counted in &off {
            assert_eq!(shortcomings(counted).len(), 1, "{counted:?}");
        }
    }

    const ARMED: &str = "status\narmed, position mode, 1.000 s\nlatched: none\nworst plant 2830, control 1753 \
                         cycles; deadlines missed: 0\ncapture: idle";

    fn throttle(status: &str) -> Vec<String> {
        let throttle = Throttle {
            greeting: "throttle: nothing stored, its own parameters\n> ".to_owned(),
            status: status.to_owned(),
            status_with_motor_open: ARMED.to_owned(),
            counted: counted(),
            faults_after_stopped_tick: "faults\nfirst: watchdog at 0.00000 s".to_owned(),
            reset_after_ms: 20.0,
        };
        let mut found = Shortcomings::default();
        found.throttle(&throttle);
        found.0
    }

    fn driven(controller_status: &str, throttle_status: &str) -> Vec<String> {
        let driven = Driven {
            positions: vec![("step".to_owned(), 0.6, 0.599)],
            controller_status: controller_status.to_owned(),
            throttle_status: throttle_status.to_owned(),
            controller: counted(),
            throttle: counted(),
            captures: Vec::new(),
        };
        let mut found = Shortcomings::default();
        found.driven(&driven);
        found.0
    }

    #[test]
    fn a_drive_that_is_disarmed_is_named() {
        let disarmed = ARMED.replace("armed", "disarmed");
        assert_eq!(throttle(ARMED), [""; 0]);
        assert_eq!(throttle(&disarmed).len(), 1);
        assert_eq!(driven(ARMED, ARMED), [""; 0]);
        for [controller, throttle] in [[&disarmed, ARMED], [ARMED, &disarmed]] {
            assert_eq!(driven(controller, throttle).len(), 1);
        }
    }

    /// As the images say it.
    fn store() -> Store {
        let parameter = |value| format!("show torque_constant\ntorque_constant = {value} N·m/A");
        let greeting = |what| format!("\ncontroller: {what}\n> `help` lists the commands\n> ");
        Store {
            first_greeting: greeting("nothing stored, its own parameters"),
            saved: "save\nok".to_owned(),
            flash: [1, 187, 0],
            second_greeting: greeting("parameters of commit 1"),
            shown: parameter("0.38"),
            greeting_after_torn_save: greeting(
                "parameters of commit 1\nstore: a commit was cut short or a set is damaged",
            ),
            faults_after_torn_save: "faults\nfirst: store_corrupt at 0.00000 s".to_owned(),
            shown_after_torn_save: parameter("0.38"),
            torn_after_words: 20,
        }
    }

    #[test]
    fn a_store_that_forgets_is_named() {
        let shortcomings = |store: &Store| {
            let mut found = Shortcomings::default();
            found.store(store);
            found.0
        };
        assert_eq!(shortcomings(&store()), [""; 0]);
        let forgotten = "controller: nothing stored, its own parameters\n> ";
        let off = [
            Store {
                second_greeting: forgotten.to_owned(),
                ..store()
            },
            Store {
                shown: "torque_constant = 0.06 N·m/A".to_owned(),
                ..store()
            },
            Store {
                greeting_after_torn_save: store().greeting_after_torn_save.replace(
                    "parameters of commit 1",
                    "nothing stored, its own parameters",
                ),
                ..store()
            },
            // As if the save that was cut short were whole.
            Store {
                greeting_after_torn_save: store()
                    .greeting_after_torn_save
                    .replace("commit 1", "commit 2"),
                ..store()
            },
            Store {
                greeting_after_torn_save: store().second_greeting,
                ..store()
            },
            Store {
                faults_after_torn_save: "faults\nnone".to_owned(),
                ..store()
            },
            Store {
                shown_after_torn_save: "torque_constant = 0.4 N·m/A".to_owned(),
                ..store()
            },
        ];
        for store in &off {
            assert_eq!(shortcomings(store).len(), 1, "{store:?}");
        }
    }
}
