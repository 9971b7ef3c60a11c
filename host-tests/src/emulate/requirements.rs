//! What a user relies on, held against a run of the images.

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
        let effects: Vec<&str> = traced.answer.effects.iter().map(id).collect();
        found.require(effects == ["spring"], || {
            format!("the tracing names {effects:?}; the throttle has an undeclared spring")
        });
        let stiffness = traced
            .answer
            .effects
            .iter()
            .flat_map(|effect| &effect.parameters)
            .find(|parameter| parameter.name == "stiffness")
            .map_or(f64::NAN, |parameter| parameter.value);
        found.require((stiffness / SPRING - 1.0).abs() < 0.1, || {
            format!("the tracing finds a stiffness of {stiffness} N·m/rad; it is {SPRING}")
        });
        let errors = traced.answer.errors.validate.as_ref();
        let ratio = errors.map_or(f64::NAN, |errors| {
            errors.after.position_rms / errors.before.position_rms
        });
        found.require(ratio < 0.1, || {
            format!("the spring leaves {ratio} of the position error on the other drive")
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
        for part in ["armed, position mode", "latched: none", NONE_MISSED] {
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
            "controller: parameters of commit 1",
        );
        self.says("stored parameter", shown, STORED[0]);
        let is_whole = STORED
            .iter()
            .any(|value| shown_after_torn_save.contains(value));
        self.require(is_whole, || {
            format!(
                "power lost after {torn_after_words} words of a `save`: expected {STORED:?}, got \
                 {shown_after_torn_save:?}"
            )
        });
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
            for part in ["armed", "latched: none", NONE_MISSED] {
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

/// A parameter before and after the second `save`.
const STORED: [&str; 2] = ["torque_constant = 0.38 ", "torque_constant = 0.4 "];

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

    #[test]
    fn a_store_that_forgets_is_named() {
        let store = Store {
            first_greeting: "controller: nothing stored, its own parameters".to_owned(),
            saved: "save\nok".to_owned(),
            flash: [1, 187, 0],
            second_greeting: "controller: nothing stored, its own parameters".to_owned(),
            shown: "torque_constant = 0.06 N·m/A".to_owned(),
            shown_after_torn_save: "torque_constant = 0.39 N·m/A".to_owned(),
            torn_after_words: 20,
        };
        let mut found = Shortcomings::default();
        found.store(&store);
        assert_eq!(found.0.len(), 3, "{found:?}");
    }
}
