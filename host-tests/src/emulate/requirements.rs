//! What a user relies on, held against a run of the images.

use firmware::app::machine::THROTTLE;
use firmware::app::timing::STEPS_PER_SECOND;
use model_core::plant::parameters::Drive;
use model_core::plant::potentiometer::SPAN;

use super::recording::{self, Recording};
use super::run::{
    AnyTime, CYCLES_PER_INSTRUCTION, Controller, Counted, Cuts, Driven, Engine, FRICTION, Faults,
    Healthy, Outcome, Store, Throttle, Ticks,
};
use super::summary::AtCycles;
use super::tracing::Traced;
use crate::gap::outcome::{FoundEffect, Stages};

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

/// Most that the spring may leave of the position error on the drive that it was not found on.
const MOST_REMAINING: f64 = 0.1;

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
        if let Some(ticks) = &outcome.ticks {
            found.ticks(ticks);
        }
        if let Some(controller) = &outcome.controller {
            found.controller(controller);
        }
        if let Some(engine) = &outcome.engine {
            found.engine(engine);
        }
        if let Some(faults) = &outcome.faults {
            found.faults(faults);
        }
        let saves = [("the first", 0), ("an erasing", 1)];
        for (cuts, (save, erases)) in outcome.cuts.iter().flatten().zip(saves) {
            found.cuts(save, erases, cuts);
        }
        if let Some(healthy) = &outcome.healthy {
            found.healthy(healthy);
        }
        if let Some(faults) = &outcome.any_time {
            found.any_time(faults);
        }
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
        let ratio = errors.map_or(f64::NAN, Stages::remaining);
        found.require(ratio < MOST_REMAINING, || {
            format!("the spring leaves {ratio} of the position error on the other drive")
        });
        found
    }

    /// Of the images that nobody operates. Another actuator in the middle of a run costs them more than `throttle` or
    /// `controller` ever do: up to [`CYCLES_PER_INSTRUCTION`].
    pub fn of_unattended(images: &[AtCycles]) -> Self {
        let mut found = Self::default();
        for AtCycles {
            image,
            cycles_per_instruction: cycles,
            missed,
            ..
        } in images
        {
            found.require(*missed == 0 || *cycles > CYCLES_PER_INSTRUCTION, || {
                format!("{image} at {cycles} cycles an instruction: {missed} plant ticks missed")
            });
        }
        found
    }

    /// Of what was recorded over the console.
    pub fn of_recording(recording: &Recording) -> Self {
        let mut found = Self::default();
        let least = (recording::SECONDS * f64::from(STEPS_PER_SECOND)) as usize;
        let Recording {
            rows,
            effects,
            remaining,
        } = recording;
        found.require(rows.iter().all(|rows| *rows >= least), || {
            format!("the logs over the console have {rows:?} rows of {least}")
        });
        found.require(*remaining < MOST_REMAINING, || {
            format!("over the console the spring leaves {remaining} of the position error on the other drive")
        });
        found.require(*effects == ["spring"], || {
            format!("the tracing of the log over the console names {effects:?}; the throttle has an undeclared spring")
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
            faults,
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
        let given: Vec<&str> = faults.iter().map(|fault| &*fault.fault).collect();
        self.require(given == THROTTLE_FAULTS.map(|(fault, _)| fault), || {
            format!("the throttle's faults are {given:?}")
        });
        for (fault, (_, name)) in faults.iter().zip(THROTTLE_FAULTS) {
            let who = format!("throttle, {}", fault.fault);
            self.says(&who, &fault.faults, &format!("first: {name} at "));
            self.require(fault.tracks == [0; 2] && fault.current == 0.0, || {
                format!(
                    "{who}: tracks at {:?}, current at {}",
                    fault.tracks, fault.current
                )
            });
        }
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
        let [declared, worn] = FRICTION;
        let near = |friction: f64| (friction - worn).abs() < 0.5 * (worn - declared);
        self.require(driven.friction().is_some_and(near), || {
            format!(
                "of a friction that grew from {declared} to {worn} N·m the controller says {:?}",
                driven.refit
            )
        });
    }

    /// Up to [`MOST_CYCLES`] no deadline is missed, with every protection up to [`CYCLES_PER_INSTRUCTION`].
    fn ticks(&mut self, ticks: &[Ticks]) {
        for ticks in ticks {
            let Ticks {
                image,
                cycles_per_instruction: cycles,
                status,
                missed,
                ..
            } = ticks;
            let most = if image == PROTECTED {
                CYCLES_PER_INSTRUCTION
            } else {
                MOST_CYCLES
            };
            if *cycles > most {
                continue;
            }
            let who = format!("{image} at {cycles} cycles an instruction");
            self.begins_a_line(&who, status, "armed, ");
            for part in ["latched: none", NONE_MISSED] {
                self.says(&who, status, part);
            }
            self.require(*missed == 0, || {
                format!("{who}: {missed} plant ticks missed")
            });
        }
        self.require(ticks.len() == 12, || {
            format!("{} measurements of the longest interrupts", ticks.len())
        });
    }

    fn controller(&mut self, controller: &Controller) {
        let Controller {
            status,
            status_behind_spikes,
            status_behind_edges,
            spikes,
            edges,
            save_ms,
            clock_lost_ms,
            unforgotten_erases,
            flash_options,
        } = controller;
        let count = std::f64::consts::TAU / 16384.0;
        for (who, status, counts) in [
            ("the controller's encoder", status, 0),
            ("its encoder behind spikes", status_behind_spikes, 0),
            ("its encoder behind edges", status_behind_edges, *edges),
        ] {
            let position = counts as f64 * count;
            let line = format!("position {position:.6} rad, ");
            self.begins_a_line(who, status, &line);
        }
        self.require(*spikes >= 100 && *edges >= 100, || {
            format!("{spikes} spikes and {edges} edges at the controller's encoder")
        });
        // An erase is at least 10 times as long as what may be lost.
        self.require(
            *save_ms > 10.0 * CLOCK && clock_lost_ms.abs() < CLOCK,
            || {
                format!(
                    "over a `save` of {save_ms} ms the controller's clock loses {clock_lost_ms}"
                )
            },
        );
        self.require(*unforgotten_erases == 0, || {
            format!("{unforgotten_erases} erases are in the data cache as they were before")
        });
        self.require(flash_options & BROWN_OUT_LEVEL == 0, || {
            format!(
                "FLASH_OPTCR reads {flash_options:#x}, which is not the highest brown-out reset"
            )
        });
    }

    fn engine(&mut self, engine: &[Engine]) {
        let frequencies: Vec<f64> = engine.iter().map(|engine| engine.pwm_hz).collect();
        self.require(frequencies == FREQUENCIES, || {
            format!("the engine control unit has PWMs of {frequencies:?} Hz")
        });
        let plant = &THROTTLE.plant;
        let stroke = f64::from(plant.upper_stop - plant.lower_stop);
        let limp_home = f64::from(plant.spring_rest - plant.lower_stop) / stroke;
        for engine in engine {
            let Engine {
                pwm_hz,
                learned,
                proportional,
                settled,
                following,
                found,
                status,
                ..
            } = engine;
            let who = format!("engine control unit at {pwm_hz} Hz");
            let [lower, upper] = SPAN.map(f64::from);
            let tracks = [[lower, upper], [upper, lower]];
            for (learned, [closed, open]) in learned.iter().zip(tracks) {
                let nominal = [closed + limp_home * (open - closed), closed, open];
                let is_near = |(learned, nominal): (&f64, f64)| (learned - nominal).abs() < LEARNED;
                self.require(learned.iter().zip(nominal).all(is_near), || {
                    format!("{who}: learned {learned:?} V; expected {nominal:?}")
                });
            }
            // What friction may hold off against the loop's gain.
            let held = breakaway_voltage() / proportional / stroke;
            let worst = settled
                .iter()
                .fold(*following, |worst, error| worst.max(error.abs()));
            self.require(settled.len() == 4 && worst < held, || {
                format!("{who}: {settled:?} off behind steps, {following} on a ramp; expected less than {held}")
            });
            let found: Vec<(&str, Option<&str>)> = found
                .iter()
                .map(|found| (&*found.fault, found.code.as_deref()))
                .collect();
            self.require(
                found == CODES.map(|(fault, code)| (fault, Some(code))),
                || format!("{who}: found {found:?}"),
            );
            self.begins_a_line(&who, status, "armed, wires mode");
            for part in ["latched: none", NONE_MISSED] {
                self.says(&who, status, part);
            }
        }
    }

    fn faults(&mut self, faults: &Faults) {
        let given: Vec<&str> = faults.faults.iter().map(|fault| &*fault.fault).collect();
        self.require(given == FAULTS.map(|(fault, ..)| fault), || {
            format!("the faults are {given:?}")
        });
        for (fault, (_, name, longest_us, resets)) in faults.faults.iter().zip(FAULTS) {
            self.says(&fault.fault, &fault.faults, &format!("first: {name} at "));
            let let_go = fault.let_go_after_us;
            self.require(let_go.is_some_and(|after| after <= longest_us), || {
                format!(
                    "{}: the bridge is off after {let_go:?} µs; expected at most {longest_us}",
                    fault.fault
                )
            });
            self.require(fault.held && fault.tracks == [0; 2], || {
                format!(
                    "{}: the bridge is off and the brake on for good: {}; the tracks are at {:?}",
                    fault.fault, fault.held, fault.tracks
                )
            });
            self.require(fault.resets == resets, || {
                format!(
                    "{}: {} starts, expected {resets}",
                    fault.fault, fault.resets
                )
            });
        }
        let Faults {
            faults_overloaded,
            faults_behind_reset,
            cleared_behind_reset,
            faults_behind_power,
            armed_without_crystal,
            greeting_without_crystal,
            faults_with_crystal,
            status_in_flood,
            status_behind_stop,
            debug_freeze: [watchdog, bridge],
            ..
        } = faults;
        for (who, said) in [
            ("`arm` without a crystal", armed_without_crystal),
            ("greeting without a crystal", greeting_without_crystal),
        ] {
            self.says(who, said, "clock_failed");
        }
        // The heat is kept in RAM that no start clears; without it none was measured.
        for (who, said, words) in [
            (
                "`faults` of a winding that is too hot",
                faults_overloaded,
                "first: overload at ",
            ),
            (
                "`faults` behind its reset",
                faults_behind_reset,
                "first: watchdog at ",
            ),
            (
                "`clear` behind its reset",
                cleared_behind_reset,
                "refused: still there: overload",
            ),
            (
                "`faults` behind its end of power",
                faults_behind_power,
                "none",
            ),
        ] {
            self.says(who, said, words);
        }
        self.says(
            "`faults` with the crystal back",
            faults_with_crystal,
            "none",
        );
        for (who, status, state) in [
            ("status in a flood", status_in_flood, "armed, "),
            (
                "status behind a `stop` in a flood",
                status_behind_stop,
                "disarmed, ",
            ),
        ] {
            self.begins_a_line(who, status, state);
            for part in ["latched: none", NONE_MISSED] {
                self.says(who, status, part);
            }
        }
        self.require(watchdog & IWDG_STOP != 0 && bridge & TIM1_STOP != 0, || {
            format!("a halted core leaves running: {watchdog:#x}, {bridge:#x}")
        });
    }

    fn cuts(&mut self, save: &str, expected: usize, cuts: &Cuts) {
        let Cuts {
            operations,
            erases,
            starts,
            before,
            behind,
            named,
            otherwise,
        } = cuts;
        // A set is some hundred words.
        self.require(*operations > 100 && *starts > 30, || {
            format!("{save} `save` has {operations} operations, and {starts} starts behind a cut")
        });
        self.require(otherwise.is_empty() && before + behind == *starts, || {
            format!(
                "{save} `save`, cut short: {before} starts with the values before it, {behind} behind it; {otherwise:?}"
            )
        });
        self.require(*erases == expected, || {
            format!("{save} `save` erases {erases} used sectors")
        });
        // Only behind its last words it counts; and the cut is seen but where all that
        // there is reads as erased.
        self.require(*behind > 0 && *behind <= 4, || {
            format!("{save} `save`: {behind} starts with the values behind it")
        });
        self.require(before - named.min(before) <= 4, || {
            format!("{save} `save`: of {before} starts with the values before it {named} latch `store_corrupt`")
        });
    }

    fn any_time(&mut self, faults: &[AnyTime]) {
        self.require(faults.len() == ANY_TIME.len(), || {
            format!("{} faults at any time", faults.len())
        });
        for (cause, name, longest) in ANY_TIME {
            let Some(fault) = faults.iter().find(|fault| fault.fault == cause) else {
                self.0.push(format!("no {cause} at any time"));
                continue;
            };
            let AnyTime {
                runs,
                latest_us,
                named,
                unsound,
                ..
            } = fault;
            self.require(named.get(name) == Some(runs) && unsound.is_empty(), || {
                format!(
                    "{cause} at any time, {runs} runs: {named:?}; {}",
                    unsound.join("; ")
                )
            });
            self.require(*latest_us <= longest, || {
                format!("{cause} at any time: the bridge is off after {latest_us} µs; {longest} are to be borne")
            });
        }
    }

    fn healthy(&mut self, healthy: &Healthy) {
        let Healthy {
            commands,
            unsound,
            controller,
            throttle,
        } = healthy;
        self.require(controller.time_s >= 600.0 && *commands > 100, || {
            format!("the sound loop followed {commands} commands in {:.0} s; it is driven for ten minutes", controller.time_s)
        });
        self.require(unsound.is_empty(), || {
            format!(
                "the sound loop has a fault behind a command: {}",
                unsound.join("; ")
            )
        });
        self.counted("the sound loop's controller", controller);
        self.counted("the sound loop's throttle", throttle);
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

/// Cycles an instruction up to which `throttle` and `controller` keep their deadlines under their own commands, without the
/// protections that are off unless they are set: where no line is ever in a cache. A line of 128
/// bits, some five instructions of Thumb-2, then costs five wait states (RM0090, sections 3.5.1 and 3.5.2), which makes
/// the 1.5 of cached lines 2.5; no program runs so from its beginning to its end. What they do beyond is printed.
const MOST_CYCLES: f64 = 2.5;

/// `BOR_LEV` of `FLASH_OPTCR`: RM0090, section 3.9.5. Nothing set is the highest level.
const BROWN_OUT_LEVEL: u64 = 0b1100;

/// The emulation's name for the controller with every protection set.
const PROTECTED: &str = "protected";

/// What befalls the armed controller; the name that it is to be found by, the longest until the bridge is off, µs,
/// and the starts that it takes. A plant tick is 50 µs, and one more until it is seen; liveness waits for 250 ms,
/// and the watchdog for [`LONGEST_WATCHDOG_MS`] more.
const FAULTS: [(&str, &str, f64, usize); 12] = [
    ("break input, a pulse of 1 µs", "bridge_break", 100.0, 0),
    ("emergency stop", "emergency_stop", 100.0, 0),
    (
        "the processor's supply sags to 2.9 V",
        "brown_out",
        100.0,
        0,
    ),
    ("current sensor at its end", "over_current", 100.0, 0),
    // Three time constants of its observer, 4 ms each, behind a typed line.
    (
        "current sensor stuck at no current, 6 V, shaft blocked",
        "encoder_lost",
        15e3,
        0,
    ),
    (
        "converter stands still",
        "watchdog",
        LONGEST_WATCHDOG_MS * 1e3,
        1,
    ),
    (
        "an interrupt of the console stuck",
        "watchdog",
        250e3 + LONGEST_WATCHDOG_MS * 1e3,
        1,
    ),
    (
        "the most urgent interrupt stuck",
        "missed_deadline",
        1.1e3,
        0,
    ),
    (
        "panic, by an interrupt that nobody serves",
        "panic",
        100.0,
        1,
    ),
    ("stack overflow", "stack_overflow", 200.0, 1),
    ("an instruction that is none", "processor_fault", 100.0, 1),
    ("crystal stops", "clock_failed", 100.0, 1),
];

/// The same at any time in the loop: what befalls, its name, and the longest until the bridge is off, µs. The bound of the supply is
/// that of `docs/faults.md`; what comes by the wires of the loop takes a step of theirs, 50 µs, more.
const ANY_TIME: [(&str, &str, f64); 13] = [
    ("bridge_break", "bridge_break", 150.0),
    ("emergency_stop", "emergency_stop", 150.0),
    ("over_current", "over_current", 150.0),
    ("under_voltage", "under_voltage", 7.15e3),
    ("stop_reached", "stop_reached", 6.15e3),
    ("brown_out", "brown_out", 100.0),
    (
        "converter stands still",
        "watchdog",
        LONGEST_WATCHDOG_MS * 1e3,
    ),
    (
        "console's interrupt stuck",
        "watchdog",
        250e3 + LONGEST_WATCHDOG_MS * 1e3,
    ),
    ("missed_deadline", "missed_deadline", 1.1e3),
    ("panic", "panic", 100.0),
    ("stack_overflow", "stack_overflow", 200.0),
    ("processor_fault", "processor_fault", 100.0),
    ("clock_failed", "clock_failed", 100.0),
];

/// From a question to its answer's time, ms: its line's bytes, and two looks of the operator for one.
const CLOCK: f64 = 12.0;

/// Of the engine control unit's PWM, Hz.
const FREQUENCIES: [f64; 4] = [400.0, 2e3, 20e3, 40e3];

/// By how much a place that was learned may be off, V: 4 standard errors of 64 readings of a track with 5 mV of noise,
/// and half a code of 5 V in each converter.
const LEARNED: f64 = 4.0 * 5e-3 / 8.0 + 5.0 / 4095.0;

/// What befalls the throttle's chip, and the name that it gets.
const THROTTLE_FAULTS: [(&str, &str); 4] = [
    ("panic, by an interrupt that nobody serves", "panic"),
    ("stack overflow", "stack_overflow"),
    ("an instruction that is none", "processor_fault"),
    ("the most urgent interrupt stuck", "watchdog"),
];

/// Each fault that the throttle may have, and the code that it has to be found by.
const CODES: [(&str, &str); 17] = [
    ("plate_jammed", "plate_stuck"),
    ("spring_broken", "spring_return"),
    ("friction_raised 1.8", "friction_high"),
    ("motor_open", "open_load"),
    ("motor_shorted 0.2", "short_circuit"),
    ("first_track_open", "first_track_low"),
    ("first_track_shorted_high", "first_track_high"),
    ("first_track_shorted_low", "first_track_low"),
    ("first_track_stuck", "tracks_disagree"),
    ("first_track_offset 0.3", "tracks_disagree"),
    ("first_track_noisy 0.05", "first_track_noisy"),
    ("second_track_open", "second_track_low"),
    ("second_track_shorted_high", "second_track_high"),
    ("second_track_shorted_low", "second_track_low"),
    ("second_track_stuck", "tracks_disagree"),
    ("second_track_offset 0.3", "tracks_disagree"),
    ("second_track_noisy 0.05", "second_track_noisy"),
];

/// Voltage at standstill that breakaway friction holds, V.
fn breakaway_voltage() -> f64 {
    let plant = &THROTTLE.plant;
    let Drive::Voltage {
        resistance,
        torque_constant,
        ..
    } = plant.drive
    else {
        return f64::NAN;
    };
    f64::from(plant.breakaway.forward * resistance / torque_constant)
}

/// `DBG_IWDG_STOP` in `DBGMCU_APB1_FZ`, and `DBG_TIM1_STOP` in `DBGMCU_APB2_FZ`: RM0090, section 38.16.
const IWDG_STOP: u64 = 1 << 12;
const TIM1_STOP: u64 = 1;

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
    use super::super::run::{Fault, Found, ThrottleFault};
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

    fn throttle_fault((fault, name): (&str, &str)) -> ThrottleFault {
        ThrottleFault {
            fault: fault.to_owned(),
            faults: format!("faults\nfirst: {name} at 0.00000 s"),
            tracks: [0; 2],
            current: 0.0,
        }
    }

    fn throttle(status: &str) -> Vec<String> {
        let throttle = Throttle {
            greeting: "throttle: nothing stored, its own parameters\n> ".to_owned(),
            status: status.to_owned(),
            status_with_motor_open: ARMED.to_owned(),
            counted: counted(),
            faults_after_stopped_tick: "faults\nfirst: watchdog at 0.00000 s".to_owned(),
            reset_after_ms: 20.0,
            faults: THROTTLE_FAULTS.map(throttle_fault).to_vec(),
        };
        let mut found = Shortcomings::default();
        found.throttle(&throttle);
        found.0
    }

    fn driven([controller_status, throttle_status]: [&str; 2], refit: &str) -> Vec<String> {
        let driven = Driven {
            positions: vec![("step".to_owned(), 0.6, 0.599)],
            controller_status: controller_status.to_owned(),
            throttle_status: throttle_status.to_owned(),
            controller: counted(),
            throttle: counted(),
            captures: Vec::new(),
            refit: refit.to_owned(),
        };
        let mut found = Shortcomings::default();
        found.driven(&driven);
        found.0
    }

    const REFIT: &str = "refit: coulomb 0.30015 N·m, static 0.35 N·m; cost 1.5e-3, before 2.8e-2";

    #[test]
    fn a_drive_that_is_disarmed_is_named() {
        let disarmed = ARMED.replace("armed", "disarmed");
        assert_eq!(throttle(ARMED), [""; 0]);
        assert_eq!(throttle(&disarmed).len(), 1);
        assert_eq!(driven([ARMED; 2], REFIT), [""; 0]);
        for statuses in [[&*disarmed, ARMED], [ARMED, &disarmed]] {
            assert_eq!(driven(statuses, REFIT).len(), 1);
        }
        for refit in [
            "no refit: the log is too short",
            &REFIT.replace("0.30015", "0.26"),
        ] {
            assert_eq!(driven([ARMED; 2], refit).len(), 1);
        }
    }

    #[test]
    fn a_deadline_that_is_missed_at_the_cycles_to_be_borne_is_named() {
        let shortcomings = |missing_at: f64, status: &str, missed| {
            let rows = [1.0, 1.5, 2.5, 3.0].into_iter().flat_map(|cycles| {
                ["throttle", "controller", PROTECTED].map(|image| Ticks {
                    image: image.to_owned(),
                    cycles_per_instruction: cycles,
                    status: if cycles == missing_at { status } else { ARMED }.to_owned(),
                    longest_latency_us: 2.0,
                    missed: if cycles == missing_at { missed } else { 0 },
                    stack_bytes: [4_000, 60_000],
                })
            });
            let mut found = Shortcomings::default();
            found.ticks(&rows.collect::<Vec<_>>());
            found.0.len()
        };
        let late = ARMED.replace("missed: 0", "missed: 3");
        assert_eq!(shortcomings(0.0, ARMED, 0), 0);
        assert_eq!(shortcomings(2.5, &late, 0), 2);
        assert_eq!(shortcomings(2.5, ARMED, 1), 2);
        assert_eq!(shortcomings(1.5, &late, 0), 3);
        assert_eq!(shortcomings(3.0, &late, 1), 0);
    }

    #[test]
    fn a_spike_that_counts_and_a_clock_that_stands_still_are_named() {
        let status =
            |position| format!("disarmed, position mode, 0.2 s\nposition {position} rad, x");
        let shortcomings = |behind_spikes, behind_edges, save_ms, clock_lost_ms| {
            let mut found = Shortcomings::default();
            found.controller(&Controller {
                status: status("0.000000"),
                status_behind_spikes: status(behind_spikes),
                status_behind_edges: status(behind_edges),
                spikes: 100,
                edges: 400,
                save_ms,
                clock_lost_ms,
                unforgotten_erases: 0,
                flash_options: 0x0fff_aae1,
            });
            found.0.len()
        };
        // 400 of 16,384 counts a turn.
        assert_eq!(shortcomings("0.000000", "0.153398", 420.0, -3.0), 0);
        assert_eq!(shortcomings("0.153398", "0.153398", 420.0, -3.0), 1);
        assert_eq!(shortcomings("0.000000", "0.153014", 420.0, -3.0), 1);
        assert_eq!(shortcomings("0.000000", "0.153398", 420.0, 399.0), 1);
        assert_eq!(shortcomings("0.000000", "0.153398", 20.0, -3.0), 1);
    }

    fn engines() -> Vec<Engine> {
        let engine = |pwm_hz| Engine {
            pwm_hz,
            learned: [[0.9645, 0.5, 4.5], [4.0355, 4.5, 0.5]],
            learned_after_s: 1.5,
            proportional: 22.0,
            settled: vec![0.01; 4],
            following: 0.03,
            found: CODES
                .map(|(fault, code)| Found {
                    fault: fault.to_owned(),
                    code: Some(code.to_owned()),
                    after_ms: 20,
                })
                .to_vec(),
            status: ARMED.replace("position mode", "wires mode"),
        };
        FREQUENCIES.map(engine).to_vec()
    }

    #[test]
    fn an_engine_control_unit_that_is_led_astray_is_named() {
        let shortcomings = |spoil: fn(&mut Engine)| {
            let mut engines = engines();
            spoil(&mut engines[2]);
            let mut found = Shortcomings::default();
            found.engine(&engines);
            found.0.len()
        };
        assert_eq!(shortcomings(|_| ()), 0);
        let spoils: [fn(&mut Engine); 8] = [
            |engine| engine.pwm_hz = 1e3,
            |engine| engine.learned[1][2] += 5e-3,
            // 2 Ω by 0.28 N·m / 0.38 N·m/A, over 22 V/rad and 1.55 rad: 0.043.
            |engine| engine.settled[3] = -0.05,
            |engine| engine.following = 0.05,
            |engine| engine.found[4].code = Some("open_load".to_owned()),
            |engine| engine.found[9].code = None,
            |engine| engine.found.truncate(16),
            |engine| engine.status = engine.status.replace("missed: 0", "missed: 2"),
        ];
        for (number, spoil) in spoils.into_iter().enumerate() {
            assert_eq!(shortcomings(spoil), 1, "{number}");
        }
    }

    fn faults() -> Faults {
        let row = |(fault, name, longest, resets): (&str, &str, f64, usize)| Fault {
            fault: fault.to_owned(),
            let_go_after_us: Some(longest),
            held: true,
            tracks: [0; 2],
            resets,
            faults: format!("faults\nfirst: {name} at 0.00000 s"),
            status: "status\ndisarmed, voltage mode, 0.000 s".to_owned(),
        };
        Faults {
            faults: FAULTS.into_iter().map(row).collect(),
            faults_overloaded: "faults\nfirst: overload at 0.00000 s".to_owned(),
            faults_behind_reset: "faults\nfirst: watchdog at 0.00000 s".to_owned(),
            cleared_behind_reset: "clear\nrefused: still there: overload; end that first"
                .to_owned(),
            faults_behind_power: "faults\nnone".to_owned(),
            armed_without_crystal: "arm\nrefused: latched: clock_failed".to_owned(),
            greeting_without_crystal: "fault: clock_failed; the bridge is off".to_owned(),
            faults_with_crystal: "faults\nnone".to_owned(),
            status_in_flood: ARMED.to_owned(),
            status_behind_stop: ARMED.replace("armed", "disarmed"),
            debug_freeze: [IWDG_STOP, TIM1_STOP],
        }
    }

    #[test]
    fn a_fault_without_its_name_or_its_safe_state_is_named() {
        let shortcomings = |spoil: fn(&mut Faults)| {
            let mut faults = faults();
            spoil(&mut faults);
            let mut found = Shortcomings::default();
            found.faults(&faults);
            found.0.len()
        };
        assert_eq!(shortcomings(|_| ()), 0);
        let spoils: [fn(&mut Faults); 10] = [
            |faults| faults.faults[0].let_go_after_us = None,
            |faults| faults.faults[1].held = false,
            |faults| faults.faults[2].tracks = [410, 3686],
            |faults| faults.faults[4].let_go_after_us = Some(1e6),
            |faults| faults.faults[8].faults = "faults\nfirst: watchdog at 0.0 s".to_owned(),
            |faults| faults.faults[10].resets = 0,
            |faults| faults.cleared_behind_reset = "clear\nok".to_owned(),
            |faults| faults.armed_without_crystal = "arm\nok".to_owned(),
            |faults| faults.status_behind_stop = ARMED.to_owned(),
            |faults| faults.debug_freeze = [IWDG_STOP, 0],
        ];
        for (number, spoil) in spoils.into_iter().enumerate() {
            assert_eq!(shortcomings(spoil), 1, "{number}");
        }
    }

    #[test]
    fn a_save_that_is_torn_is_named() {
        let cuts = || Cuts {
            operations: 188,
            erases: 1,
            starts: 47,
            before: 45,
            behind: 2,
            named: 43,
            otherwise: Vec::new(),
        };
        let shortcomings = |cuts: &Cuts| {
            let mut found = Shortcomings::default();
            found.cuts("a", 1, cuts);
            found.0.len()
        };
        assert_eq!(shortcomings(&cuts()), 0);
        let mixed = Cuts {
            before: 44,
            named: 42,
            otherwise: vec!["torque_constant = 0.38 N·m/A\nresistance = 1 Ω".to_owned()],
            ..cuts()
        };
        let silent = Cuts { named: 0, ..cuts() };
        let blank = Cuts {
            erases: 0,
            ..cuts()
        };
        for cuts in [mixed, silent, blank] {
            assert_eq!(shortcomings(&cuts), 1, "{cuts:?}");
        }
    }

    #[test]
    fn a_sound_loop_that_is_short_or_has_a_fault_is_named() {
        let board = || Counted {
            time_s: 601.0,
            plant_ticks: 12_019_900,
            track_writes: 12_019_900,
            ..counted()
        };
        let sound = || Healthy {
            commands: 400,
            unsound: Vec::new(),
            controller: board(),
            throttle: board(),
        };
        let shortcomings = |spoil: fn(&mut Healthy)| {
            let mut healthy = sound();
            spoil(&mut healthy);
            let mut found = Shortcomings::default();
            found.healthy(&healthy);
            found.0.len()
        };
        assert_eq!(shortcomings(|_| ()), 0);
        let spoils: [fn(&mut Healthy); 4] = [
            |healthy| healthy.commands = 3,
            |healthy| healthy.controller = counted(),
            |healthy| {
                healthy
                    .unsound
                    .push("step 0.1 0.1: latched: overload".to_owned())
            },
            |healthy| healthy.throttle.plant_ticks_missed = 1,
        ];
        for (number, spoil) in spoils.into_iter().enumerate() {
            assert_eq!(shortcomings(spoil), 1, "{number}");
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
