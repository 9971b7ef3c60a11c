//! What fails while the controller drives, at any time, in either mode, under any load: how much current, for
//! how long and how far, against bounds that follow from the declared numbers; and no fault of a sound drive.
//!
//! The bound of the encoder is that of [`following`]: a rotor that stands still, by its encoder, under more than 1.1 I is
//! found within three time constants. Two control periods more pass until a speed is known and the bridge off.

use crate::any_drive::{
    TOLERANCES, Warming, any_command, any_drop, either_way, image, perform, winding,
};
use firmware::app::fault::monitor::Limits;
use firmware::app::fault::observer::TIME_CONSTANT;
use firmware::app::fault::output::Outputs;
use firmware::app::fault::{Fault, Faults, following};
use firmware::app::liveness::Task;
use firmware::app::machine::{EMA, FULL_DUTY};
use firmware::app::operation::bridge::MOST_DUTY;
use firmware::app::operation::homing::SWITCH_STEPS;
use firmware::app::operation::motion_limit;
use firmware::app::operation::operator::POLL_PERIOD_MS;
use firmware::app::operation::temperature::{BROKEN_STEPS, FILTER};
use firmware::app::timing::{CONTROL_PERIOD, PLANT_PERIOD, QUEUED_SAMPLES};
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};
use model_core::numeric::random::Random;
use model_core::plant::parameters::{Drive, Parameters};
use rayon::prelude::*;

/// The current beyond which nothing that is declared holds the rotor, A.
fn most_holding_current() -> f32 {
    let [_, _, torque_constant] = winding();
    ((1.0 + TOLERANCES.mechanics) * EMA.plant.breakaway.forward + EMA.limits.load)
        / ((1.0 - TOLERANCES.torque_constant) * torque_constant)
}

/// How long a current of 1.1 times that may last, s.
const LONGEST: f32 = 3.0 * TIME_CONSTANT + 2.0 * CONTROL_PERIOD;

/// What the drive itself finds of a command that asks for more than winding or bridge bear.
fn is_too_much(causes: Faults) -> bool {
    causes.contains(Fault::Overload) || causes.contains(Fault::OverCurrent)
}

#[test]
fn a_sound_drive_within_its_tolerances_has_no_fault_whatever_it_is_told() {
    const RUNS: u64 = 1000;
    let (mut at_a_stop, mut whole) = (0, 0);
    for seed in 0..RUNS {
        let mut random = Random::new(seed, 0);
        let mut image = image(&SharedFlash::new(), &mut random);
        // A thousand other drops and temperatures, on which the commands do not depend.
        let mut others = Random::new(seed, 11);
        image.plant.drop = any_drop(&mut others);
        let mut warming = Warming::any(&mut image.plant, &mut others);
        let mut told = Vec::new();
        let mut borne = true;
        for _ in 0..3 {
            let (mode, line) = any_command(&mut random);
            for told in [mode, "arm", &line] {
                image.line(told);
            }
            told.push(format!("{mode}, {line}"));
            warming.turn(&mut others);
            for _ in 0..(100.0 + 700.0 * random.uniform()) as u32 {
                warming.step(&mut image.plant, 1e-3);
                image.run_ms(1);
                let position = image.plant.state.position.value().abs();
                at_a_stop += u32::from(position > 0.97 && image.plant.state.current.abs() > 5.0);
            }
            let causes = image.wiring.latch().causes();
            assert!(!causes.are_of_the_encoder(), "{seed}: {causes}, {told:?}");
            assert!(
                causes.is_empty() || is_too_much(causes),
                "{seed}: {causes}, {told:?}"
            );
            borne &= causes.is_empty();
        }
        whole += u64::from(borne);
    }
    println!("{whole} of {RUNS} to their end, {at_a_stop} ms against a stop");
    // With the current limited, next to nothing that is told is too much.
    assert!(whole >= RUNS - RUNS / 100, "{whole} runs to their end");
    assert!(at_a_stop > 10_000, "{at_a_stop} ms against a stop");
}

/// A motor that turns one way for ever: its turns are counted in 32 bits, which wrap, and single precision holds 24 of them.
#[test]
fn a_sound_drive_has_no_fault_however_far_it_has_turned() {
    let free = Parameters {
        lower_stop: -1e4,
        upper_stop: 1e4,
        ..EMA.plant
    };
    // In a tick: the counter has 16 bits.
    const MOST_TURNED: i32 = 30_000;
    for turned in [1 << 24, 1 << 27, -(1 << 29), i32::MAX - 20_000] {
        for (volts, limit) in [(3.0, 0.0), (20.0, 0.0), (20.0, 150.0)] {
            let mut image = OperationOnHost::controller(&SharedFlash::new(), &free);
            while image.plant.turned != turned {
                let left = turned - image.plant.turned;
                image.plant.turned += left.clamp(-MOST_TURNED, MOST_TURNED);
                image.tick();
            }
            let [limit_told, told] = [
                format!("set speed_limit {limit}"),
                format!("step 0 {volts}"),
            ];
            perform(&mut image, &[&limit_told, "mode voltage", "arm", &told]);
            image.run_ms(1000);
            let causes = image.wiring.latch().causes();
            let case = format!("{turned} counts, {volts} V, at most {limit} rad/s");
            assert!(causes.is_empty(), "{case}: {causes}");
            assert!(image.plant.state.velocity.value() > 5.0, "{case}");
        }
    }
}

/// What came of a fault.
#[derive(Debug, Default)]
struct Outcome {
    causes: Faults,
    /// Largest current, A.
    peak: f32,
    /// Longest time with a rotor that stands still, by its encoder and not at a stop, under more than can
    /// hold it, s.
    longest: f32,
    /// True way from the fault to the end, rad.
    travel: f32,
    /// What the bridge gave the motor since the fault, J.
    energy: f32,
    /// From the fault to the latch, ms.
    after: Option<u32>,
}

impl Outcome {
    /// A tick of the plant from where it was when the fault came.
    fn tick(&mut self, image: &mut OperationOnHost<Motor>, start: f32) {
        image.tick();
        let Motor { state, supply, .. } = &image.plant;
        self.peak = self.peak.max(state.current.abs());
        self.travel = self.travel.max((state.position.value() - start).abs());
        let power = image.plant.supply_current() * supply;
        self.energy += power.max(0.0) * PLANT_PERIOD;
    }

    /// Whether current, way and energy are no more than so much current, the stroke, and what the supply gives at that
    /// current in these seconds.
    fn is_borne(&self, current: f32, image: &OperationOnHost<Motor>, seconds: f32) -> bool {
        self.peak <= current
            && self.travel <= MOST_WAY
            && self.energy <= image.plant.supply * current * seconds
    }

    /// The worst of both, fault by fault.
    fn worst(&mut self, other: &Self) {
        self.peak = self.peak.max(other.peak);
        self.longest = self.longest.max(other.longest);
        self.travel = self.travel.max(other.travel);
        self.energy = self.energy.max(other.energy);
        self.after = self.after.max(other.after);
    }
}

/// Whether the encoder reads a position in the reach of a stop, where the actuator may be held by it: what ends
/// that is the overload.
fn reads_a_stop(image: &OperationOnHost<Motor>) -> bool {
    let stroke = EMA.plant.upper_stop - EMA.plant.lower_stop;
    read(image).abs() >= EMA.plant.upper_stop - TOLERANCES.stop * stroke
}

/// The position as the encoder has it, rad.
fn read(image: &OperationOnHost<Motor>) -> f32 {
    let reading = image.wiring.measurement().position;
    EMA.converters.position.value(reading)
}

/// Milliseconds with an encoder that counts this share from now on.
fn fail(image: &mut OperationOnHost<Motor>, share: f32, milliseconds: u32) -> Outcome {
    let mut outcome = Outcome::default();
    let start = image.plant.state.position.value();
    let limit = 1.1 * most_holding_current();
    image.plant.encoder = share;
    let mut standing = 0.0;
    for millisecond in 0..milliseconds {
        for _ in 0..20 {
            let before = image.plant.state.position.value();
            outcome.tick(image, start);
            let moved = share * (image.plant.state.position.value() - before);
            let current = image.plant.state.current.abs();
            let standing_still = moved == 0.0 && !reads_a_stop(image);
            standing = if standing_still && current > limit {
                standing + PLANT_PERIOD
            } else {
                0.0
            };
            outcome.longest = outcome.longest.max(standing);
        }
        if image.wiring.latch().is_tripped() {
            outcome.after.get_or_insert(millisecond);
        }
    }
    outcome.causes = image.wiring.latch().causes();
    outcome
}

/// The stroke and what the stops' tolerance adds on either side, rad: as far as a way goes.
const MOST_WAY: f32 = (1.0 + 2.0 * TOLERANCES.stop) * (EMA.plant.upper_stop - EMA.plant.lower_stop);

/// Most current that is ever driven, A: what comes on top of the limit is derived in `drive_limits`.
const MOST_CURRENT: f32 = 1.1 * EMA.limits.current_limit;

#[test]
fn an_encoder_that_fails_at_any_time_leaves_no_rotor_standing_under_more_than_it_can_hold() {
    const RUNS: u64 = 700;
    const MILLISECONDS: u32 = 600;
    // With how many of them are found at least, and driven on and moved at most: as docs/faults.md has it.
    let encoders = [
        ("frozen", 0.0, 396, 74),
        ("backwards", -1.0, 464, 6),
        ("half", 0.5, 109, 358),
    ];
    for (name, share, least_found, most_moved) in encoders {
        let (mut found, mut worst) = (0, Outcome::default());
        let (mut driven, mut moved, mut misread) = (0, 0, 0.0_f32);
        for seed in 0..RUNS {
            let mut random = Random::new(seed, 1);
            let mut image = image(&SharedFlash::new(), &mut random);
            let (mode, line) = any_command(&mut random);
            perform(&mut image, &[mode, "arm", &line]);
            image.run_ms((300.0 * random.uniform()) as u32);
            let outcome = fail(&mut image, share, MILLISECONDS);
            let seconds = MILLISECONDS as f32 * 1e-3;
            assert!(
                outcome.longest <= LONGEST && outcome.is_borne(MOST_CURRENT, &image, seconds),
                "{name}, {seed}: {outcome:?}, {mode}, {line}"
            );
            worst.worst(&outcome);
            if outcome.causes.are_of_the_encoder() {
                assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
                assert!(!image.plant.is_driven());
                found += 1;
            } else if image.plant.is_driven() {
                let position = image.plant.state.position.value();
                misread = misread.max((position - read(&image)).abs());
                driven += 1;
                moved += u32::from(outcome.travel > 0.01 * MOST_WAY);
            }
        }
        println!(
            "{name}: {found} of {RUNS} found, {driven} driven, {moved} of them moved, {misread} rad off, {worst:?}"
        );
        assert!(found >= least_found && moved <= most_moved, "{name}");
    }
}

/// A current sensor that no longer moves, but reads what it may. It hides the current from its limit; what it cannot
/// hide it from is the [balance of the voltage](firmware::app::fault::back_emf): a current that takes more of the voltage than the
/// reading, the speed and all tolerances leave is found within three time constants.
#[test]
fn a_current_sensor_that_is_stuck_within_its_range_hides_no_more_than_its_balance_bears() {
    const RUNS: u64 = 700;
    let [resistance, _, torque_constant] = winding();
    let unheard = |image: &OperationOnHost<Motor>, read: f32| {
        let speed = image.plant.state.velocity.value().abs();
        let volts = (1.0 + TOLERANCES.resistance) * resistance * read.abs()
            + TOLERANCES.brushes
            + TOLERANCES.dead_time * image.plant.supply
            + 2.0 * TOLERANCES.torque_constant * torque_constant * speed;
        1.1 * volts / ((1.0 - TOLERANCES.resistance) * resistance)
    };
    // What the supply drives through the least resistance.
    let most_current = |supply: f32| supply / ((1.0 - TOLERANCES.resistance) * resistance);
    for (stuck, least_found) in [(true, 455), (false, 631)] {
        let name = if stuck { "stuck" } else { "at zero" };
        let (mut found, mut driven, mut moved) = (0, 0, 0);
        let mut worst = Outcome::default();
        for seed in 0..RUNS {
            let mut random = Random::new(seed, 6);
            let mut image = image(&SharedFlash::new(), &mut random);
            let (mode, line) = any_command(&mut random);
            perform(&mut image, &[mode, "arm", &line]);
            image.run_ms((300.0 * random.uniform()) as u32);
            let start = image.plant.state.position.value();
            let read = if stuck {
                image.plant.state.current
            } else {
                0.0
            };
            image.plant.current = Some(read);
            let (mut outcome, mut beyond) = (Outcome::default(), 0.0);
            for tick in 0..600 * 20 {
                outcome.tick(&mut image, start);
                let unheard = unheard(&image, read);
                beyond = if image.plant.state.current.abs() > unheard {
                    beyond + PLANT_PERIOD
                } else {
                    0.0
                };
                outcome.longest = outcome.longest.max(beyond);
                if image.wiring.latch().is_tripped() {
                    outcome.after.get_or_insert(tick / 20);
                }
            }
            outcome.causes = image.wiring.latch().causes();
            let current = most_current(image.plant.supply);
            assert!(
                outcome.longest <= LONGEST && outcome.is_borne(current, &image, 0.6),
                "{name}, {seed}: {read} A, {outcome:?}, {mode}, {line}"
            );
            worst.worst(&outcome);
            found += u32::from(!outcome.causes.is_empty());
            let is_driven = image.plant.is_driven();
            driven += u32::from(is_driven);
            moved += u32::from(is_driven && outcome.travel > 0.01 * MOST_WAY);
        }
        println!(
            "{name}: {found} of {RUNS} found, {driven} driven, {moved} of them moved, {worst:?}"
        );
        assert!(found >= least_found, "{name}");
    }
}

/// Pressed against a stop the winding's voltage is R i and nothing else. From any current and through any winding, a change of
/// twice what the brushes' drop may change by is told from a sound sensor's: what is remembered and what is read may be
/// off by half of that each.
#[test]
fn a_current_sensor_that_is_stuck_is_found_by_the_first_change_that_it_does_not_show() {
    let [resistance, inductance, torque_constant] = winding();
    for share in [-1.0_f32, 0.0, 1.0] {
        let actuator = Parameters {
            lower_stop: -1e-4,
            upper_stop: 1e-4,
            drive: Drive::Voltage {
                resistance: resistance * (1.0 + 0.99 * share * TOLERANCES.resistance),
                inductance,
                torque_constant,
            },
            ..EMA.plant
        };
        // Below the current's limit on each winding.
        for volts in [4.0_f32, 7.0, 10.0] {
            for stuck in [false, true] {
                for change in [-2.0 * TOLERANCES.brushes, 2.0 * TOLERANCES.brushes] {
                    let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
                    image.plant.noise = Some(Random::new(3, 2));
                    image.run_ms(20);
                    let press = format!("step 0 {volts}");
                    perform(&mut image, &["set load 3", "mode voltage", "arm", &press]);
                    // Long enough to be what was before.
                    image.run_ms(300);
                    assert!(image.wiring.latch().causes().is_empty());
                    if stuck {
                        image.plant.current = Some(image.plant.state.current);
                    }
                    let changed = volts + change;
                    image.type_in(format!("step 0 {changed}\r").as_bytes());
                    // The command is taken by the next control step.
                    image.run_ms(1 + (1e3 * LONGEST).ceil() as u32);
                    let case = format!("{share}, {volts} V, {change}");
                    let causes = image.wiring.latch().causes();
                    assert_eq!(causes.are_of_the_encoder(), stuck, "{case}: {causes}");
                    assert_eq!(image.plant.is_driven(), !stuck, "{case}: {causes}");
                }
            }
        }
    }
}

/// What is done to a drive.
type Cause = fn(&mut OperationOnHost<Motor>);

/// The longest that the independent watchdog waits, s: 20 of its counts, 1.9 ms at most.
const WATCHDOG: f32 = 38e-3;

/// The filter of the temperatures, s, and what it takes from 25 °C to beyond 80 °C with a sensor at 140 °C, by its codes
/// of 2048, 584 and 159.
const TEMPERATURE_FILTER: f32 = 1.5 * CONTROL_PERIOD / FILTER;

/// What fails.
struct Failure {
    /// What a drive that moves has to find.
    fault: Fault,
    /// What is set before.
    set: &'static [&'static str],
    cause: Cause,
    /// The time from there to a bridge that is off, s: a sum of the periods in which it is read, judged and acted upon.
    longest: f32,
    /// Most torque that moves the actuator beside its motor, N·m.
    load: f32,
}

/// A failure of a drive whose load is the declared one.
const fn failure(
    fault: Fault,
    set: &'static [&'static str],
    cause: Cause,
    longest: f32,
) -> Failure {
    Failure {
        fault,
        set,
        cause,
        longest,
        load: EMA.limits.load,
    }
}

/// How long the tasks are held, s: the queue of the samples is full before, and no task counts as hung.
const HELD: f32 = 40e-3;

const _: () = assert!(HELD > (QUEUED_SAMPLES as f32 + 1.0) * CONTROL_PERIOD);

/// A load beyond what the current's limit holds, N·m, that was declared nevertheless.
const OVERHAULING: f32 = 3.0;

const RESISTANCE: f32 = winding()[0];
const TORQUE_CONSTANT: f32 = winding()[2];

/// Until the heat of a winding that is held under all that the least supply drives through the warmest winding, 20 V through
/// 1.35 Ω, is what it bears.
const LONGEST_HEAT: f32 = {
    let Limits {
        peak_current,
        continuous_current,
        peak_time,
        ..
    } = EMA.limits;
    let supply = 20.0 * MOST_DUTY as f32 / FULL_DUTY as f32;
    let current = supply / ((1.0 + TOLERANCES.resistance) * RESISTANCE);
    let continuous = continuous_current * continuous_current;
    (peak_current * peak_current - continuous) * peak_time / (current * current - continuous)
};

/// Until a load beyond all that holds it has turned the heaviest actuator round and brought it to the speed that counts as too
/// much, at a limit of 20 rad/s.
const LONGEST_OVERHAULED: f32 = {
    let friction = EMA.plant.breakaway.forward;
    let change = 2.0 * OVERHAULING + 2.0 * (1.0 + TOLERANCES.mechanics) * friction;
    let beyond = change * motion_limit::TIME_CONSTANT
        / ((1.0 - TOLERANCES.inertia) * EMA.plant.inertia)
        + 2.0 * EMA.converters.position.unit() / CONTROL_PERIOD;
    let held = (1.0 + TOLERANCES.torque_constant) * TORQUE_CONSTANT * MOST_CURRENT
        + (1.0 + TOLERANCES.mechanics) * friction;
    // It may run at its limit the other way, and beyond that by what `drive_limits` holds.
    let change = 20.0 + beyond + 24.0;
    (1.0 + TOLERANCES.inertia) * EMA.plant.inertia * change / (OVERHAULING - held)
};

const FAILURES: [Failure; 16] = [
    // Read, judged and acted upon in one tick.
    failure(
        Fault::OverCurrent,
        &[],
        |image| image.plant.current = Some(24.9),
        PLANT_PERIOD,
    ),
    failure(
        Fault::BridgeBreak,
        &[],
        |image| image.plant.broken = true,
        PLANT_PERIOD,
    ),
    failure(
        Fault::EmergencyStop,
        &[],
        |image| image.plant.stopped = true,
        PLANT_PERIOD,
    ),
    failure(
        Fault::BrownOut,
        &[],
        |image| image.processor_supply_low = true,
        PLANT_PERIOD,
    ),
    // A mean over a control period, judged at its end, then its debounce and the tick that acts.
    failure(
        Fault::OverVoltage,
        &[],
        |image| image.plant.supply = 33.0,
        2.0 * CONTROL_PERIOD + EMA.limits.supply_time + 2.0 * PLANT_PERIOD,
    ),
    failure(
        Fault::UnderVoltage,
        &[],
        |image| image.plant.supply = 12.0,
        2.0 * CONTROL_PERIOD + EMA.limits.supply_time + 2.0 * PLANT_PERIOD,
    ),
    // Judged by the control step: both switches, as with a cable that is torn out.
    failure(
        Fault::StopReached,
        &[],
        |image| image.plant.switches = [true, true],
        (SWITCH_STEPS + 1) as f32 * CONTROL_PERIOD + 2.0 * PLANT_PERIOD,
    ),
    failure(
        Fault::OverTemperature,
        &["set motor_temperature_maximum 80"],
        |image| image.plant.temperatures = [159; 2],
        TEMPERATURE_FILTER + 2.0 * CONTROL_PERIOD + 2.0 * PLANT_PERIOD,
    ),
    failure(
        Fault::TemperatureSensor,
        &["set switch_temperature_maximum 80"],
        |image| image.plant.temperatures = [4095; 2],
        (BROKEN_STEPS + 1) as f32 * CONTROL_PERIOD + 2.0 * PLANT_PERIOD,
    ),
    // The step that is due within a period does not come, which the tick behind it sees.
    failure(
        Fault::MissedDeadline,
        &[],
        |image| image.control_held = true,
        CONTROL_PERIOD + 2.0 * PLANT_PERIOD,
    ),
    // Nothing is typed any more.
    failure(
        Fault::CommandTimeout,
        &["set command_timeout 0.35"],
        |_| (),
        0.35 + 3.0 * CONTROL_PERIOD,
    ),
    // What a task may be silent for, then the watchdog.
    failure(
        Fault::Watchdog,
        &[],
        |image| image.hung = Some(Task::Operator),
        Task::Operator.longest_silence() as f32 * PLANT_PERIOD + 2.0 * CONTROL_PERIOD + WATCHDOG,
    ),
    // A supply that is no number, until the control step that takes it.
    failure(
        Fault::NonFinite,
        &[],
        |image| image.damaged_supply = Some(f32::NAN),
        CONTROL_PERIOD + 2.0 * PLANT_PERIOD,
    ),
    // Told by the operator, once it goes on.
    failure(
        Fault::QueueOverflow,
        &[],
        |image| image.tasks_held = (HELD / PLANT_PERIOD) as u32,
        HELD + POLL_PERIOD_MS as f32 * 1e-3 + 2.0 * PLANT_PERIOD,
    ),
    // A load that may hold it, as far as is declared, and all that the supply drives.
    failure(
        Fault::Overload,
        &["set load 100"],
        |image| {
            image.plant.block();
            image.type_in(b"mode voltage\rstep 0 24\r");
        },
        LONGEST_HEAT + 3.0 * CONTROL_PERIOD,
    ),
    // The speed is the mean over a control period.
    Failure {
        fault: Fault::OverSpeed,
        set: &["set load 3", "set speed_limit 20"],
        cause: |image| image.plant.overhaul(OVERHAULING),
        longest: LONGEST_OVERHAULED + 2.0 * CONTROL_PERIOD + 2.0 * PLANT_PERIOD,
        load: OVERHAULING,
    },
];

#[test]
fn whatever_fails_at_any_time_the_bridge_is_off_within_its_time() {
    const RUNS: u64 = 200;
    let mut broken = 0;
    for Failure {
        fault,
        set,
        cause,
        longest,
        load,
    } in FAILURES
    {
        let (mut latest, mut worst) = (0.0_f32, Outcome::default());
        for seed in 0..RUNS {
            let mut random = Random::new(seed, 3);
            let mut image = image(&SharedFlash::new(), &mut random);
            let (mode, line) = any_command(&mut random);
            perform(&mut image, set);
            perform(&mut image, &[mode, "arm", &line]);
            for _ in 0..(6000.0 * random.uniform()) as u32 {
                image.tick();
            }
            if !image.wiring.latch().causes().is_empty() {
                // A command that was too much before anything failed.
                continue;
            }
            broken += 1;
            let start = image.plant.state;
            // The speed that it had, and what the most current that is ever driven adds: 24.5 A beside the load,
            // on the strongest and lightest motor of the series.
            let [_, _, torque_constant] = winding();
            let torque =
                (1.0 + TOLERANCES.torque_constant) * torque_constant * EMA.limits.peak_current
                    + load;
            let acceleration = torque / ((1.0 - TOLERANCES.inertia) * EMA.plant.inertia);
            let stroke = if load > EMA.limits.load {
                f32::INFINITY
            } else {
                EMA.plant.upper_stop - EMA.plant.lower_stop
            };
            let most = (start.velocity.value().abs() * longest
                + 0.5 * acceleration * longest * longest)
                .min((1.0 + 2.0 * TOLERANCES.stop) * stroke);
            cause(&mut image);
            let most_energy = image.plant.supply * MOST_CURRENT * longest;
            let (mut after, mut unfed, mut outcome) = (0.0, 0.0, Outcome::default());
            // Unfed, the watchdog starts the processor anew, and its pins let go.
            while image.plant.is_driven() && unfed < WATCHDOG && after <= 2.0 * longest + 0.1 {
                after += PLANT_PERIOD;
                outcome.tick(&mut image, start.position.value());
                unfed = if image.wiring.take_vouched() {
                    0.0
                } else {
                    unfed + PLANT_PERIOD
                };
                // A switch is in nobody's way who is at 0 V.
                let idle = image.wiring.duty() == 0 && image.wiring.latch().causes().is_empty();
                if fault == Fault::StopReached && idle {
                    after = 0.0;
                    break;
                }
            }
            assert!(
                after <= longest + 0.5 * PLANT_PERIOD,
                "{fault}, {seed}: {after} s"
            );
            assert!(outcome.travel <= most, "{fault}, {seed}: {outcome:?}");
            assert!(outcome.peak <= MOST_CURRENT, "{fault}, {seed}: {outcome:?}");
            assert!(
                outcome.energy <= most_energy,
                "{fault}, {seed}: {outcome:?}"
            );
            latest = latest.max(after);
            worst.worst(&outcome);
            if after > 0.0 && fault != Fault::Watchdog {
                image.run_ms(20);
                assert!(
                    image.wiring.latch().causes().contains(fault),
                    "{fault}, {seed}"
                );
                assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
            }
        }
        println!("{fault}: {latest} s of {longest}, {worst:?}");
        assert!(latest > 0.0, "{fault} was never found");
    }
    println!("{broken} drives broken");
    assert!(broken >= 2000, "{broken}");
}

/// A day of a sound drive, in hours of 24 actuators at once: `cargo test --release --test firmware drive_faults:: -- --ignored`.
/// The current is limited to what the winding bears for ever, so that no command is too much.
#[test]
#[ignore = "at length"]
fn a_sound_drive_has_no_fault_in_a_day() {
    const HOUR_MS: u32 = 3_600_000;
    (0..24).into_par_iter().for_each(|seed| {
        let mut random = Random::new(seed, 7);
        let mut image = image(&SharedFlash::new(), &mut random);
        let mut others = Random::new(seed, 12);
        image.plant.drop = any_drop(&mut others);
        let mut warming = Warming::any(&mut image.plant, &mut others);
        let continuous = EMA.limits.continuous_current;
        perform(&mut image, &[&format!("set current_limit {continuous}")]);
        let mut driven = 0;
        while driven < HOUR_MS {
            let (mode, line) = any_command(&mut random);
            perform(&mut image, &[mode, "arm", &line]);
            image.plant.supply = 20.0 + 9.0 * random.uniform();
            let milliseconds = (100.0 + 2000.0 * random.uniform()) as u32;
            warming.turn(&mut others);
            for _ in 0..milliseconds {
                warming.step(&mut image.plant, 1e-3);
                image.run_ms(1);
            }
            driven += milliseconds + 30;
            let causes = image.wiring.latch().causes();
            assert!(
                causes.is_empty(),
                "{seed}: {causes} after {driven} ms, {mode}, {line}"
            );
            assert!(image.plant.is_driven());
        }
    });
}

/// What the sensor reads too much is told from a current with the bridge off alone. A zero that moves while the drive runs is
/// a current that the limit does not see; the drive is not armed again with it.
#[test]
fn a_current_sensor_whose_zero_moves_at_any_time_keeps_the_drive_from_being_armed_again() {
    const RUNS: u64 = 200;
    // The first block waits for the current to die out.
    const LONGEST: f32 = 2.0 * 256.0 * PLANT_PERIOD + 2.0 * CONTROL_PERIOD;
    let (mut latest, mut driven, mut worst) = (0.0_f32, 0, Outcome::default());
    for seed in 0..RUNS {
        let mut random = Random::new(seed, 8);
        let mut image = image(&SharedFlash::new(), &mut random);
        image.run_ms(20);
        let (mode, line) = any_command(&mut random);
        perform(&mut image, &[mode, "arm", &line]);
        image.run_ms((300.0 * random.uniform()) as u32);
        let start = image.plant.state.position.value();
        let offset = 1.2 + 3.8 * random.uniform();
        image.plant.offset = offset.copysign(either_way(&mut random));
        let mut outcome = Outcome::default();
        for _ in 0..300 * 20 {
            outcome.tick(&mut image, start);
        }
        assert!(
            outcome.is_borne(MOST_CURRENT + offset, &image, 0.3),
            "{seed}: {offset} A, {outcome:?}"
        );
        worst.worst(&outcome);
        driven += u32::from(image.plant.is_driven());
        image.type_in(b"disarm\r");
        let mut after = 0.0;
        while !image.wiring.latch().causes().contains(Fault::CurrentOffset) {
            after += PLANT_PERIOD;
            assert!(after <= LONGEST, "{seed}: {offset} A");
            image.tick();
        }
        latest = latest.max(after);
        assert!(image.line("arm").contains("current_offset"), "{seed}");
    }
    println!(
        "current_offset: {latest} s of {LONGEST}, {driven} of {RUNS} driven until then, {worst:?}"
    );
    assert!(driven <= 5, "{driven} driven until they are disarmed");
}

#[test]
fn a_terminal_that_falls_silent_at_any_time_is_let_go_after_the_time_that_is_set() {
    for seed in 0..40 {
        let mut random = Random::new(seed, 4);
        let mut image = image(&SharedFlash::new(), &mut random);
        let seconds = 0.05 + 0.5 * random.uniform();
        let (mode, line) = any_command(&mut random);
        let set = format!("set command_timeout {seconds}");
        perform(&mut image, &[&set, mode, "arm", &line]);
        // Of the last line 10 ms are over.
        let mut since = 10e-3;
        while image.plant.is_driven() && since < 1.0 {
            since += PLANT_PERIOD;
            image.tick();
        }
        let causes = image.wiring.latch().causes();
        if !causes.contains(Fault::CommandTimeout) {
            assert!(is_too_much(causes), "{seed}: {causes}");
            continue;
        }
        let late = since - seconds;
        assert!(
            (0.0..=3.0 * CONTROL_PERIOD).contains(&late),
            "{seed}: {late} s late"
        );
    }
}

/// In position mode the loop's integral raises the voltage until the rotor is proven to stand: at the
/// latest when that alone drives 1.1 I through the warmest winding.
#[test]
fn a_position_loop_with_a_frozen_encoder_ends_where_its_integral_reaches_the_holding_current() {
    let [resistance, ..] = winding();
    let gains = EMA.position_loop;
    let current = 1.1 * most_holding_current();
    for target in [0.02_f32, 0.05, -0.1, 0.2, -0.3] {
        for onset in [0, 110] {
            let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
            perform(&mut image, &["arm"]);
            image.plant.encoder = if onset == 0 { 0.0 } else { 1.0 };
            perform(&mut image, &[&format!("step 0 {target}")]);
            image.run_ms(onset);
            let reading = image.wiring.measurement().position;
            let error = (target - EMA.converters.position.value(reading)).abs();
            let slope = gains.integral * error;
            let begun = gains.proportional * error;
            let seconds = (current * resistance - begun) / slope + LONGEST;
            let outcome = fail(&mut image, 0.0, (1000.0 * (seconds + 0.5)) as u32);
            println!("to {target} rad, {error} off: {outcome:?}");
            let after = outcome.after.expect("a fault") as f32 * 1e-3;
            assert!(after <= seconds, "{after} s of {seconds}: {outcome:?}");
            let most = current + slope * LONGEST / resistance;
            assert!(outcome.peak <= most, "{outcome:?}, {most} A at most");
            assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
        }
    }
}

/// Against its torque a rotor does not turn: what is claimed beyond friction, load and tolerance goes
/// through the filter. The rotor turns meanwhile under the current that it has, and not for longer.
#[test]
fn an_encoder_that_runs_backwards_is_found_before_the_loop_runs_away() {
    let [_, _, torque_constant] = winding();
    for target in [0.02_f32, -0.1, 0.3, -0.8] {
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
        perform(&mut image, &["arm"]);
        image.plant.encoder = -1.0;
        perform(&mut image, &[&format!("step 0 {target}")]);
        let outcome = fail(&mut image, -1.0, 1000);
        assert_eq!(outcome.causes.first(), Some(Fault::FollowingError));
        assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
        // Nothing accelerates the rotor by more than the current that its command alone may drive.
        let acceleration = torque_constant * 24.0 / EMA.plant.inertia;
        let most = 0.5 * acceleration * LONGEST * LONGEST;
        println!("to {target} rad: {outcome:?}");
        assert!(outcome.travel <= most, "{outcome:?}, {most} rad at most");
        // As every fault: the limit, and a tenth of it.
        assert!(outcome.peak <= 22.0, "{outcome:?}");
    }
}

#[test]
fn an_actuator_that_is_blocked_on_its_way_is_let_go_and_one_at_its_stop_is_not() {
    let blocked = Parameters {
        upper_stop: 0.5,
        ..EMA.plant
    };
    let voltage = 1.2 * most_holding_current() * winding()[0];
    let line = format!("step 0 {voltage}");
    // Where the stops are is not known before the position is.
    for (actuator, told, fault) in [
        (blocked, "zero", Some(Fault::FollowingError)),
        (EMA.plant, "zero", None),
        (EMA.plant, "ping", Some(Fault::FollowingError)),
    ] {
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &actuator);
        let status = image.line("status");
        assert!(status.contains("no end stop is trusted"), "{status}");
        perform(&mut image, &[told, "mode voltage", "arm", &line]);
        let status = image.line("status");
        assert_eq!(status.contains("no end stop is trusted"), told != "zero");
        image.run_ms(500);
        assert_eq!(image.wiring.fault(), fault);
    }
}

#[test]
fn numbers_that_make_no_monitor_are_refused_by_name() {
    let name = |plant: &Parameters, load: f32, resolution: f32, period: f32| {
        following::Coefficients::new(plant, TOLERANCES, load, resolution, period)
            .map_err(|refused| refused.name)
    };
    assert!(name(&EMA.plant, 0.0, 0.0, CONTROL_PERIOD).is_ok());
    let torque = Parameters {
        drive: Drive::Torque,
        ..EMA.plant
    };
    assert_eq!(name(&torque, 0.0, 0.0, CONTROL_PERIOD), Err("drive"));
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(name(&EMA.plant, bad, 0.0, CONTROL_PERIOD), Err("load"));
        assert_eq!(
            name(&EMA.plant, 0.0, bad, CONTROL_PERIOD),
            Err("resolution")
        );
        assert_eq!(name(&EMA.plant, 0.0, 0.0, bad), Err("period"));
    }
}
