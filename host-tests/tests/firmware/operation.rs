//! The images that are operated from a console, line by line from the start to a stored refit: what is
//! allowed when, and that each fault comes from where it should and makes the outputs safe.

use firmware::app::console::command::COMMANDS;
use firmware::app::fault::Fault;
use firmware::app::fault::output::Outputs;
use firmware::app::liveness::{Liveness, Task};
use firmware::app::machine::{EMA, FULL_DUTY, THROTTLE};
use firmware::app::memory::MEMORY_SAMPLES;
use firmware::app::operation::live::Live;
use firmware::app::operation::operator::POLL_PERIOD_MS;
use firmware::app::store::field::Field;
use firmware::app::timing::PLANT_PERIOD_US;
use firmware::app::tracks::DIAGNOSTIC;
use host_tests::board_link::demultiplexer::Demultiplexer;
use host_tests::board_link::log_transfer::LogTransfer;
use host_tests::board_log::BoardLog;
use host_tests::operation_on_host::{Motor, OperationOnHost, Plant, SECTOR, SharedFlash};
use host_tests::simulated_flash::{Cut, Tear};
use host_tests::workspace;
use model_core::plant::Directional;
use model_core::plant::bridge::Bridge;
use model_core::plant::parameters::{Drive, Parameters};

fn controller() -> OperationOnHost<Motor> {
    OperationOnHost::controller(&SharedFlash::new(), &EMA.plant)
}

/// A motor whose friction has grown.
fn worn() -> Parameters {
    Parameters {
        coulomb: Directional::both(0.15),
        breakaway: Directional::both(0.18),
        ..EMA.plant
    }
}

/// Lines that must be done.
fn perform<P: Plant>(image: &mut OperationOnHost<P>, lines: &[&str]) {
    for line in lines {
        assert_eq!(image.line(line), "ok", "{line}");
    }
}

/// The value that `show` gives.
fn shown<P: Plant>(image: &mut OperationOnHost<P>, field: Field) -> f32 {
    let name = field.description().name;
    let answer = image.line(&format!("show {name}"));
    let value = answer.strip_prefix(&format!("{name} = ")).unwrap();
    value.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn a_fresh_image_has_its_own_parameters_and_waits_disarmed() {
    let mut image = controller();
    assert!(
        image
            .said
            .starts_with("\r\ncontroller: nothing stored, its own parameters\r\n"),
        "{}",
        image.said
    );
    assert_eq!(shown(&mut image, Field::Coulomb), 0.12);
    let status = image.line("status");
    assert!(status.starts_with("disarmed, position mode"), "{status}");
    assert!(status.contains("latched: none"), "{status}");
    assert!(status.contains("supply 24.0"), "{status}");
    assert!(
        status.contains("worst plant 3000, control 5000 cycles"),
        "{status}"
    );
    assert_eq!(
        image.line("step 0 0.5"),
        "refused: the drive is disarmed; `arm` it first"
    );
    assert!(!image.plant.is_driven());
}

#[test]
fn armed_the_actuator_stays_where_it_is_until_it_is_commanded() {
    let mut image = controller();
    perform(&mut image, &["arm"]);
    image.run_ms(300);
    assert!(image.plant.is_driven());
    assert_eq!(image.plant.state.position.value(), 0.0);
    perform(&mut image, &["step 0 0.5"]);
    image.run_ms(1000);
    let reached = image.plant.state.position.value();
    // As near as breakaway lets it: 0.15 N·m · 1 Ω / (0.06 N·m/A · 30 V/rad).
    assert!((reached - 0.5).abs() < 0.084, "{reached}");
    perform(&mut image, &["disarm"]);
    assert!(!image.plant.is_driven());
    assert!(image.line("status").starts_with("disarmed"));
    // Armed anew, it is not drawn to where it was told before.
    let rest = image.plant.state.position.value();
    perform(&mut image, &["arm"]);
    image.run_ms(500);
    assert!((image.plant.state.position.value() - rest).abs() < 1e-3);
}

#[test]
fn a_command_beyond_the_stroke_ends_at_its_end() {
    let mut image = controller();
    perform(
        &mut image,
        &[
            "record 0 200 command command position",
            "arm",
            "ramp 0 5 0.1",
        ],
    );
    image.run_ms(300);
    perform(&mut image, &["dump"]);
    image.run_ms(300);
    let asked = image.asked.borrow();
    assert_eq!(asked.rows.len(), 200);
    let commands = asked.rows.iter().map(|row| row[0]);
    assert_eq!(commands.fold(0.0, f32::max), EMA.plant.upper_stop);
}

#[test]
fn voltage_mode_has_the_told_voltage_at_the_winding_whatever_the_supply() {
    for supply in [20.0, 24.0, 29.0] {
        let mut image = controller();
        image.plant.supply = supply;
        image.run_ms(20);
        perform(&mut image, &["mode voltage", "arm", "step 0 3"]);
        image.run_ms(10);
        // R i + k ω, less L di/dt of 0.03 V while it accelerates.
        let state = image.plant.state;
        let balance = state.current + 0.06 * state.velocity.value();
        assert!((balance - 3.0).abs() < 0.05, "{supply} V: {balance}");
    }
}

#[test]
fn a_refit_is_proposed_then_saved_disarmed_and_there_at_the_next_start() {
    let flash = SharedFlash::new();
    let mut image = OperationOnHost::controller(&flash, &worn());
    assert_eq!(image.line("refit"), "ok");
    let said = image.evaluate().unwrap();
    assert!(said.contains("no refit: "), "{said}");

    perform(&mut image, &["arm", "sweep 0 0.6 0.2 2 10"]);
    image.run_ms(10_000);
    assert_eq!(image.line("refit"), "ok");
    assert_eq!(
        image.line("check"),
        "refused: a refit, a check or `dump log` is under way; wait for it"
    );
    let said = image.evaluate().unwrap();
    assert!(said.contains("`save` takes it over, disarmed"), "{said}");
    assert_eq!(image.evaluate(), None);
    // Nothing is taken over yet, and nothing is written while the drive is armed.
    assert_eq!(shown(&mut image, Field::Coulomb), 0.12);
    assert_eq!(
        image.line("save"),
        "refused: the drive is armed; `disarm` it first"
    );
    assert_eq!(flash.flash.borrow().operations, 0);
    perform(&mut image, &["disarm", "save"]);
    assert_eq!(image.asked.borrow().stalls, [true, false]);
    let coulomb = shown(&mut image, Field::Coulomb);
    assert!((coulomb - 0.15).abs() < 0.005 * 0.15, "{coulomb}");

    let mut restarted = OperationOnHost::controller(&flash, &worn());
    assert!(restarted.said.contains("parameters of commit 1"));
    assert_eq!(shown(&mut restarted, Field::Coulomb), coulomb);
    assert_eq!(shown(&mut restarted, Field::Inertia), EMA.plant.inertia);
}

/// The time in a `status`.
fn seconds<P: Plant>(image: &mut OperationOnHost<P>) -> f64 {
    let status = image.line("status");
    let line = status.lines().next().unwrap_or_default();
    let time = line
        .rsplit_once(", ")
        .and_then(|(_, time)| time.strip_suffix(" s"));
    time.and_then(|time| time.parse().ok()).unwrap()
}

#[test]
fn the_clock_goes_on_while_a_save_keeps_the_processor() {
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
    let mut save = |clock_step| {
        image.asked.borrow_mut().clock_step = clock_step;
        let before = seconds(&mut image);
        perform(&mut image, &["save"]);
        seconds(&mut image) - before
    };
    let lines_alone = save(0);
    // Half a second, of which no tick is counted. A `status` tells milliseconds.
    let passed = save(10_000) - lines_alone;
    assert!((passed - 0.5).abs() < 1.5e-3, "{passed}");
}

#[test]
fn another_value_for_what_was_estimated_withdraws_the_estimate() {
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &worn());
    perform(&mut image, &["arm", "sweep 0 0.6 0.2 2 10"]);
    image.run_ms(10_000);
    perform(&mut image, &["refit"]);
    assert!(image.evaluate().unwrap().contains("takes it over"));
    perform(&mut image, &["set coulomb 0.13", "disarm", "save"]);
    assert_eq!(shown(&mut image, Field::Coulomb), 0.13);
}

#[test]
fn what_was_estimated_is_refused_where_it_is_no_better() {
    // The motor is as declared: there is nothing to propose.
    let mut image = controller();
    perform(&mut image, &["arm", "sweep 0 0.6 0.2 2 10"]);
    image.run_ms(10_000);
    perform(&mut image, &["refit"]);
    let said = image.evaluate().unwrap();
    if said.contains("no refit: ") {
        return;
    }
    let estimate = shown(&mut image, Field::Coulomb);
    assert!((estimate - 0.12).abs() < 0.005 * 0.12, "{said}");
}

#[test]
fn a_check_of_a_sound_motor_finds_nothing() {
    let mut image = controller();
    perform(&mut image, &["arm", "sweep 0 0.6 0.2 2 6"]);
    image.run_ms(6000);
    perform(&mut image, &["check"]);
    let said = image.evaluate().unwrap();
    assert!(said.contains("check: no_missing_effect"), "{said}");
}

#[test]
fn values_that_do_not_go_together_are_refused_and_those_before_stay() {
    let mut image = controller();
    for (line, refusal) in [
        ("set lower_stop 2", "lower_stop must be below upper_stop"),
        ("set static 0.11", "static must be at least coulomb"),
        ("set coulomb 0.16", "static must be at least coulomb"),
        (
            "set continuous_current 24.8",
            "peak_current must be above the continuous current, at most 1e6 A",
        ),
        (
            "set supply_minimum 31",
            "supply must be two voltages from 0 up, the least first",
        ),
    ] {
        assert_eq!(image.line(line), format!("refused: {refusal}"));
    }
    assert_eq!(shown(&mut image, Field::LowerStop), -1.0);
}

#[test]
fn another_motor_at_another_supply_is_told_and_not_compiled() {
    let mut image = controller();
    image.plant.supply = 12.0;
    image.run_ms(20);
    assert_latched(&mut image, Fault::UnderVoltage);
    perform(
        &mut image,
        &["set supply_minimum 9", "set supply_maximum 16", "clear"],
    );
    perform(
        &mut image,
        &["set peak_current 8", "set continuous_current 3", "arm"],
    );
    assert_eq!(image.line("faults"), "none");
    assert_eq!(
        image.line("set position_unit 1e-3"),
        "refused: the drive is armed; `disarm` it first"
    );
    image.plant.current = Some(8.1);
    image.run_ms(5);
    assert_latched(&mut image, Fault::OverCurrent);
}

#[test]
fn whatever_is_set_within_its_bounds_the_outputs_are_numbers_or_safe() {
    for field in Field::ALL {
        let description = field.description();
        for value in [description.lower, description.upper] {
            let mut image = OperationOnHost::throttle(&SharedFlash::new());
            let line = format!("set {} {value:e}", description.name);
            let answer = image.line(&line);
            if answer != "ok" {
                assert!(answer.starts_with("refused: "), "{line}: {answer}");
                continue;
            }
            perform(&mut image, &["mode position", "arm", "step 0.2 1"]);
            image.run_ms(100);
            if image.wiring.latch().causes().is_empty() {
                let truth = image.wiring.truth();
                assert!(truth.position.is_finite(), "{line}");
                assert!(truth.current.is_finite(), "{line}");
            } else {
                assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE, "{line}");
            }
        }
    }
}

#[test]
fn whatever_a_controller_is_set_to_it_drives_with_numbers_or_lets_go() {
    for field in Field::ALL {
        let description = field.description();
        for value in [description.lower, description.upper] {
            for mode in ["mode position", "mode voltage"] {
                let mut image = controller();
                let line = format!("set {} {value:e}", description.name);
                let answer = image.line(&line);
                if answer != "ok" {
                    assert!(answer.starts_with("refused: "), "{line}: {answer}");
                    continue;
                }
                for told in [mode, "arm", "step 0.2 5"] {
                    image.line(told);
                }
                for _ in 0..100 {
                    image.run_ms(1);
                    assert!(image.wiring.duty().unsigned_abs() <= FULL_DUTY.unsigned_abs());
                    if !image.wiring.latch().causes().is_empty() {
                        assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE, "{line}");
                    }
                }
            }
        }
    }
}

/// The sessions of the README and of `docs/board.md`, typed as they stand there.
#[test]
fn the_sessions_of_the_documentation_go_as_they_are_printed() {
    let texts = ["README.md", "docs/board.md"].map(|text| workspace::root().join(text));
    let texts = texts.map(|text| std::fs::read_to_string(text).unwrap());
    let sessions = texts
        .iter()
        .flat_map(|text| text.split("```text\n").skip(1));
    let sessions = sessions.map(|rest| rest.split_once("```").unwrap().0);
    let mut typed = 0;
    for session in sessions.filter(|session| session.starts_with("> ")) {
        let mut image = controller();
        image.run_ms(1500);
        for exchange in session.split("> ").skip(1) {
            let (line, answer) = exchange.split_once('\n').unwrap();
            let said = image.line(line);
            typed += 1;
            for (said, printed) in said.lines().zip(answer.lines()) {
                // What steps cost, and how long they have been going on, is another thing here.
                let differs = |line: &str| line.starts_with("worst") || line.contains(" mode, ");
                assert!(
                    said == printed || differs(said) && differs(printed),
                    "{line}: {said}"
                );
            }
            assert_eq!(
                said.lines().count(),
                answer.trim_end().lines().count(),
                "{line}: {said}"
            );
        }
    }
    assert!(typed > 16, "{typed}");
}

/// The outputs are safe, and the console says why and what to do.
fn assert_latched<P: Plant>(image: &mut OperationOnHost<P>, fault: Fault) {
    let latch = image.wiring.latch();
    let causes = latch.causes();
    assert!(causes.contains(fault), "{fault}, not {causes}");
    assert_eq!(latch.outputs(), Outputs::SAFE, "{fault}");
    assert_eq!(image.wiring.duty(), 0, "{fault}");
    assert_eq!(image.wiring.tracks(), DIAGNOSTIC, "{fault}");
    assert_eq!(image.wiring.current_output(), 0, "{fault}");
    let faults = image.line("faults");
    assert!(faults.contains(fault.remedy()), "{faults}");
    assert!(
        image.said.contains(&format!("fault: {}", latch.causes())),
        "{}",
        image.said
    );
    let answer = image.line("arm");
    assert!(answer.starts_with("refused: latched: "), "{answer}");
}

/// An actuator that follows a sweep.
fn moving() -> OperationOnHost<Motor> {
    let mut image = controller();
    perform(&mut image, &["arm", "sine 0 0.5 1"]);
    image.run_ms(100);
    assert!(image.plant.state.velocity.value().abs() > 1.0);
    image
}

/// What is done to a moving actuator.
type Cause = fn(&mut OperationOnHost<Motor>);

#[test]
fn every_fault_of_a_real_actuator_comes_from_its_source_and_is_cleared_when_that_is_over() {
    let causes: [(Fault, Cause, Cause); 7] = [
        (
            Fault::OverCurrent,
            |image| image.plant.current = Some(24.9),
            |image| image.plant.current = None,
        ),
        (
            Fault::OverVoltage,
            |image| image.plant.supply = 31.0,
            |image| image.plant.supply = 24.0,
        ),
        (
            Fault::UnderVoltage,
            |image| image.plant.supply = 17.0,
            |image| image.plant.supply = 24.0,
        ),
        (
            Fault::StopReached,
            |image| image.plant.switches = [true, true],
            |image| image.plant.switches = [false, false],
        ),
        (
            Fault::BridgeBreak,
            |image| image.plant.broken = true,
            |image| image.plant.broken = false,
        ),
        (
            Fault::QueueOverflow,
            |image| image.tasks_held = u32::MAX,
            |_| (),
        ),
        (
            Fault::MissedDeadline,
            |image| image.control_held = true,
            |image| image.control_held = false,
        ),
    ];
    for (fault, cause, end) in causes {
        let mut image = moving();
        cause(&mut image);
        image.run_ms(400);
        image.tasks_held = 0;
        image.run_ms(10);
        assert_latched(&mut image, fault);
        let first = image.wiring.latch().first().unwrap().fault;
        assert_eq!(first, fault);
        end(&mut image);
        image.run_ms(50);
        assert_eq!(
            image.line("clear"),
            "refused: the drive is armed; `disarm` it first"
        );
        perform(&mut image, &["disarm", "clear", "arm"]);
        image.run_ms(100);
        assert!(image.plant.is_driven(), "{fault}");
        assert_eq!(image.line("faults"), "none", "{fault}");
    }
}

#[test]
fn an_encoder_that_does_not_go_with_a_motor_that_turns_is_a_fault() {
    // Far from any stop: a motor that is held says nothing of its encoder.
    let free = Parameters {
        lower_stop: -1000.0,
        upper_stop: 1000.0,
        ..EMA.plant
    };
    for (fault, encoder) in [(Fault::EncoderLost, 0.0), (Fault::FollowingError, -1.0)] {
        let mut image = OperationOnHost::controller(&SharedFlash::new(), &free);
        image.plant.encoder = encoder;
        perform(&mut image, &["mode voltage", "arm", "step 0 6"]);
        image.run_ms(200);
        assert_latched(&mut image, fault);
        image.plant.encoder = 1.0;
        perform(&mut image, &["disarm", "clear", "arm", "step 0 6"]);
        image.run_ms(200);
        assert_eq!(image.line("faults"), "none");
    }
}

#[test]
fn a_position_of_many_turns_is_measured_and_its_log_ends_with_sixteen_bits() {
    let free = Parameters {
        lower_stop: -1000.0,
        upper_stop: 1000.0,
        ..EMA.plant
    };
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &free);
    perform(&mut image, &["mode voltage", "arm", "step 0 6"]);
    image.run_ms(2000);
    let truth = image.plant.state.position.value();
    assert!(truth > 100.0, "{truth}");
    let status = image.line("status");
    let measured = status
        .lines()
        .find_map(|line| line.strip_prefix("position "));
    let measured: f32 = measured
        .unwrap()
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap();
    // A control period of 66 rad/s and a count.
    assert!(
        (measured - image.plant.state.position.value()).abs() < 1.0,
        "{status}"
    );
    assert!(measured > truth);
    perform(&mut image, &["refit"]);
    let said = image.evaluate().unwrap();
    assert!(said.contains("no refit: the log is too short"), "{said}");
}

#[test]
fn a_condition_that_holds_is_not_cleared() {
    let mut image = moving();
    image.plant.supply = 31.0;
    image.run_ms(100);
    perform(&mut image, &["disarm"]);
    assert_eq!(
        image.line("clear"),
        "refused: still there: over_voltage; end that first"
    );
    image.plant.broken = true;
    image.plant.supply = 24.0;
    image.run_ms(100);
    assert_eq!(
        image.line("clear"),
        "refused: still there: bridge_break; end that first"
    );
}

#[test]
fn an_over_current_switches_the_bridge_off_in_the_tick_that_reads_it() {
    let mut image = moving();
    image.plant.current = Some(-24.9);
    assert!(image.plant.is_driven());
    image.tick();
    assert!(!image.plant.is_driven());
}

#[test]
fn a_motor_that_is_held_at_its_stop_is_an_overload() {
    let mut stuck = controller();
    perform(&mut stuck, &["zero", "mode voltage", "arm", "step 0 15"]);
    // 15 A of 6 for (24.5² − 6²)/(15² − 6²) s; another gain does not cool it.
    for gain in ["31", "32", "33", "34", "35"] {
        stuck.run_ms(500);
        assert_eq!(stuck.line("faults"), "none");
        perform(&mut stuck, &[&format!("set proportional {gain}")]);
    }
    stuck.run_ms(700);
    assert_latched(&mut stuck, Fault::Overload);
}

#[test]
fn armed_outside_its_stroke_it_is_held_where_it_is() {
    let mut image = controller();
    perform(&mut image, &["set lower_stop 0.2", "arm"]);
    let mut most = 0.0_f32;
    for line in ["ping", "hold"] {
        perform(&mut image, &[line]);
        for _ in 0..100 {
            image.run_ms(1);
            most = most.max(image.plant.state.current.abs());
        }
    }
    // Less than holds it back: the friction of its breakaway.
    let Drive::Voltage {
        torque_constant, ..
    } = EMA.plant.drive
    else {
        panic!("the 24 V actuator has a winding");
    };
    let breakaway = EMA.plant.breakaway.forward / torque_constant;
    assert!(most < breakaway, "{most} A");
    assert!(image.plant.state.position.value().abs() < 1e-3);
    assert_eq!(image.line("faults"), "none");
    perform(&mut image, &["step 0.3 0.3"]);
    image.run_ms(1000);
    let position = image.plant.state.position.value();
    let faults = image.line("faults");
    assert!((position - 0.3).abs() < 0.05, "{position} rad; {faults}");
}

#[test]
fn driven_off_a_limit_switch_it_goes_and_onto_it_it_does_not() {
    let mut image = controller();
    image.plant.switches = [true, false];
    image.run_ms(10);
    perform(&mut image, &["mode voltage", "arm", "step 0 -3"]);
    image.run_ms(200);
    assert!(image.plant.state.position.value().abs() < 1e-3);
    assert_eq!(image.line("faults"), "none");
    let status = image.line("status");
    assert!(status.contains("limit switch open: lower"), "{status}");
    perform(&mut image, &["step 0 3"]);
    image.run_ms(200);
    assert!(image.plant.state.position.value() > 0.05);
    assert_eq!(image.line("faults"), "none");
    // Once it was closed, it is an end of the way.
    image.plant.switches = [false, false];
    image.run_ms(10);
    image.plant.switches = [true, false];
    perform(&mut image, &["step 0 -3"]);
    image.run_ms(20);
    assert_latched(&mut image, Fault::StopReached);
    // A contact that bounces is none that is open.
    let mut image = controller();
    perform(&mut image, &["mode voltage", "arm", "step 0 -3"]);
    for _ in 0..20 {
        image.plant.switches = [true, false];
        image.run_ms(3);
        image.plant.switches = [false, false];
        image.run_ms(2);
    }
    assert_eq!(image.line("faults"), "none");
}

#[test]
fn a_cause_of_the_last_reset_keeps_the_start_safe() {
    for fault in [
        Fault::Panic,
        Fault::StackOverflow,
        Fault::ProcessorFault,
        Fault::Watchdog,
        Fault::BrownOut,
        Fault::UnexpectedReset,
    ] {
        let mut image = controller();
        image.wiring.trip(fault);
        image.run_ms(10);
        assert_latched(&mut image, fault);
        perform(&mut image, &["clear", "arm"]);
    }
}

#[test]
fn a_damaged_store_is_a_fault_with_the_values_before_or_its_own() {
    let flash = SharedFlash::new();
    let mut image = OperationOnHost::controller(&flash, &EMA.plant);
    perform(&mut image, &["set coulomb 0.13", "save"]);
    let first = SECTOR / 4;
    for word in &mut flash.flash.borrow_mut().words_mut()[first..first + 40] {
        *word &= 0x5a5a_5a5a;
    }
    let mut image = OperationOnHost::controller(&flash, &EMA.plant);
    image.run_ms(10);
    assert!(image.said.contains("store: "), "{}", image.said);
    assert_latched(&mut image, Fault::StoreCorrupt);
    assert_eq!(shown(&mut image, Field::Coulomb), 0.12);
    // Saved anew, it is in order again.
    perform(&mut image, &["clear", "set coulomb 0.14", "save"]);
    let mut image = OperationOnHost::controller(&flash, &EMA.plant);
    assert_eq!(shown(&mut image, Field::Coulomb), 0.14);
    perform(&mut image, &["arm"]);
}

#[test]
fn wherever_the_power_goes_while_saving_the_next_start_has_the_old_or_the_new_values() {
    let flash = SharedFlash::new();
    let mut image = OperationOnHost::controller(&flash, &EMA.plant);
    perform(&mut image, &["set coulomb 0.13", "save"]);
    let before = flash.flash.borrow().clone();
    perform(
        &mut image,
        &["set coulomb 0.14", "set inertia 1.3e-4", "save"],
    );
    let operations = flash.flash.borrow().operations;
    assert!(operations > before.operations + 20);
    let mut news = 0;
    for operation in before.operations..operations {
        *flash.flash.borrow_mut() = before.clone();
        let mut image = OperationOnHost::controller(&flash, &EMA.plant);
        perform(&mut image, &["set coulomb 0.14", "set inertia 1.3e-4"]);
        flash.flash.borrow_mut().cut(Cut {
            operation,
            tear: Tear::Bits(operation),
        });
        image.line("save");
        flash.flash.borrow_mut().restart();
        let mut image = OperationOnHost::controller(&flash, &EMA.plant);
        let values = [Field::Coulomb, Field::Inertia].map(|field| shown(&mut image, field));
        let new = values == [0.14, 1.3e-4];
        assert!(new || values == [0.13, 1.2e-4], "{operation}: {values:?}");
        news += u32::from(new);
    }
    assert!(news <= 2, "the last operations alone make the new set");
}

#[test]
fn a_program_is_vouched_for_while_its_deadlines_hold() {
    let mut image = moving();
    image.wiring.take_vouched();
    let mut vouched = 0;
    for _ in 0..2000 {
        image.tick();
        vouched += u32::from(image.wiring.take_vouched());
    }
    assert_eq!(vouched, 100, "once a control step");
    image.control_held = true;
    image.run_ms(2);
    image.wiring.take_vouched();
    for _ in 0..2000 {
        image.tick();
        assert!(!image.wiring.take_vouched());
    }
    // A single one that was missed costs one meal.
    image.control_held = false;
    let mut vouched = 0;
    for _ in 0..2000 {
        image.tick();
        vouched += u32::from(image.wiring.take_vouched());
    }
    assert_eq!(vouched, 99);
}

/// The long work has half an hour, which is too long for an image on a host: the signs of life are asked themselves.
/// Each task is missed while all others go on.
#[test]
fn every_task_is_missed_after_its_time() {
    const TICKS_A_SECOND: u32 = 20_000;
    for (task, longest) in [
        (Task::Reception, TICKS_A_SECOND / 4),
        (Task::Answers, TICKS_A_SECOND / 4),
        (Task::Operator, TICKS_A_SECOND / 4),
        (Task::Evaluation, 30 * 60 * TICKS_A_SECOND),
    ] {
        // Also where the count of the ticks wraps meanwhile.
        for start in [0, u32::MAX - longest / 2] {
            let tasks = Liveness::new();
            tasks.goes_on(task, start);
            let at = |ticks: u32| {
                let now = start.wrapping_add(ticks);
                for other in Task::ALL {
                    if other != task {
                        tasks.goes_on(other, now);
                    }
                }
                tasks.all_go_on(now)
            };
            assert!(at(longest), "{task:?}");
            assert!(!at(longest + 1), "{task:?} hangs");
            assert!(!at(2 * longest), "{task:?} hangs");
            tasks.goes_on(task, start.wrapping_add(2 * longest));
            assert!(at(2 * longest), "{task:?} goes on");
        }
    }
}

#[test]
fn a_program_is_vouched_for_while_every_task_goes_on() {
    for task in [Task::Reception, Task::Answers, Task::Operator] {
        let longest = task.longest_silence() / (1000 / PLANT_PERIOD_US);
        let mut image = moving();
        image.hung = Some(task);
        // It last went on within a poll before.
        image.run_ms(longest - POLL_PERIOD_MS);
        image.wiring.take_vouched();
        image.run_ms(2);
        assert!(image.wiring.take_vouched(), "{task:?}");
        image.run_ms(POLL_PERIOD_MS);
        image.wiring.take_vouched();
        for _ in 0..4000 {
            image.tick();
            assert!(!image.wiring.take_vouched(), "{task:?} hangs");
        }
        image.hung = None;
        image.run_ms(POLL_PERIOD_MS + 2);
        assert!(image.wiring.take_vouched(), "{task:?} goes on");
    }
}

#[test]
fn a_capture_has_the_rows_around_its_trigger() {
    let mut image = controller();
    perform(
        &mut image,
        &["record 20 30 rising position 0.2 command position current_a"],
    );
    assert_eq!(
        image.line("dump"),
        "refused: the capture is waiting; `record` first"
    );
    perform(&mut image, &["arm", "step 0 0.5"]);
    image.run_ms(500);
    perform(&mut image, &["dump"]);
    image.run_ms(100);
    let asked = image.asked.borrow();
    assert_eq!(asked.triggers, [Some(20)]);
    assert_eq!(asked.rows.len(), 50);
    let position = |row: usize| asked.rows[row][2];
    assert!(position(19) < 0.2 && position(20) >= 0.2);
    assert!(asked.rows[0][1].is_nan(), "the input was not asked for");
}

#[test]
fn a_log_holds_what_was_driven_and_nothing_else() {
    let mut image = controller();
    image.run_ms(2000);
    perform(&mut image, &["refit"]);
    let said = image.evaluate().unwrap();
    assert!(said.contains("no refit: the log is too short"), "{said}");
}

/// What a log that is sent over the console holds, once it has ended.
fn received(image: &mut OperationOnHost<Motor>) -> Option<BoardLog> {
    let mut demultiplexer = Demultiplexer::default();
    demultiplexer.take(image.type_in(b"").as_bytes());
    let mut transfer = LogTransfer::default();
    for frame in demultiplexer.frames() {
        transfer.take(&frame).unwrap();
    }
    assert_eq!(demultiplexer.damaged(), 0);
    transfer.log()
}

#[test]
fn the_log_of_ten_seconds_is_the_same_over_the_console_and_over_rtt() {
    let mut image = controller();
    assert_eq!(
        image.line("dump log"),
        "refused: nothing was driven; `arm` and command it first"
    );
    perform(&mut image, &["arm", "sine 0 0.5 1"]);
    image.run_ms(11_000);
    perform(&mut image, &["disarm", "dump log"]);
    // Five rows each 5 ms.
    image.run_ms(10_000);
    let sent = image.asked.borrow().rows.clone();
    assert_eq!(sent.len(), MEMORY_SAMPLES);

    perform(&mut image, &["dump log console"]);
    // Sixteen rows each 5 ms, and the end.
    image.run_ms(5 * 626);
    let log = received(&mut image).expect("an end");
    let recordings = log.recordings();
    let samples: Vec<_> = recordings[0].samples().collect();
    assert_eq!(samples.len(), MEMORY_SAMPLES);
    for (number, (sample, row)) in samples.iter().zip(&sent).enumerate() {
        let [command, input, position, current, ..] = *row;
        assert!(command.is_nan());
        assert_eq!(
            (sample.input, sample.position, sample.current),
            (input, position, current)
        );
        assert_eq!(sample.time_us, number as u64 * 1000);
    }
    let csv = recordings[0].to_csv();
    assert!(
        csv.starts_with("time_s,input,position,current_a\n"),
        "{csv:.60}"
    );
    // A sine of 0.5 rad was followed, so these are positions in rad.
    let most = sent.iter().map(|row| row[2]).fold(0.0, f32::max);
    assert!((0.45..0.6).contains(&most), "{most} rad");
}

#[test]
fn the_log_stays_as_it_is_while_it_is_sent_and_begins_anew_behind_it() {
    let mut image = controller();
    perform(&mut image, &["arm", "sine 0 0.5 1"]);
    image.run_ms(1000);
    perform(&mut image, &["dump log console"]);
    for refused in ["refit", "check"] {
        assert!(
            image
                .line(refused)
                .starts_with("refused: a refit, a check or")
        );
    }
    image.run_ms(1000);
    let log = received(&mut image).expect("an end");
    let recording = &log.recordings()[0];
    // From `arm` to the order, 1020 ms, less what was still in the queue: a poll's and the last step.
    let rows = recording.samples().count();
    assert!((1010..=1020).contains(&rows), "{rows} rows");
    assert_eq!(recording.first_gap(), None);
    perform(&mut image, &["dump log console"]);
    image.run_ms(1000);
    let log = received(&mut image).expect("an end");
    assert!(log.recordings()[0].samples().count() < 1000);
}

#[test]
fn a_console_that_takes_nothing_delays_what_is_sent_and_neither_the_loop_nor_the_answers() {
    let mut image = controller();
    perform(&mut image, &["arm", "sine 0 0.5 1", "stream 100"]);
    image.run_ms(500);
    image.type_in(b"");
    image.asked.borrow_mut().congestion = usize::MAX;
    perform(&mut image, &["dump log console"]);
    image.run_ms(2000);
    assert_eq!(image.type_in(b""), "");
    assert!(image.line("status").starts_with("armed"));
    assert!(image.wiring.latch().causes().is_empty());
    image.asked.borrow_mut().congestion = 0;
    image.run_ms(500);
    assert!(received(&mut image).is_some());
}

#[test]
fn a_stream_tells_how_the_drive_is_as_often_as_it_was_asked_for() {
    let mut image = controller();
    for (rate, lines) in [(100, 100), (20, 20), (30, 28), (0, 0)] {
        perform(&mut image, &[&format!("stream {rate}")]);
        image.type_in(b"");
        image.run_ms(1000);
        let mut demultiplexer = Demultiplexer::default();
        demultiplexer.take(image.type_in(b"").as_bytes());
        let frames = demultiplexer.frames();
        assert_eq!(frames.len(), lines, "{rate} Hz");
        assert!(frames.iter().all(|frame| Live::read(frame).is_some()));
    }
    perform(&mut image, &["arm", "step 0 0.5", "stream 100"]);
    image.run_ms(1000);
    image.plant.broken = true;
    image.run_ms(50);
    let mut demultiplexer = Demultiplexer::default();
    demultiplexer.take(image.type_in(b"").as_bytes());
    let lives = demultiplexer.frames();
    let lives: Vec<Live> = lives.iter().filter_map(|frame| Live::read(frame)).collect();
    let before = lives[lives.len() - 10];
    assert!(before.armed && before.latched.is_empty());
    assert_eq!((before.command, before.supply), (0.5, 24.0));
    assert!((before.position - 0.5).abs() < 0.09, "{before:?}");
    let last = lives[lives.len() - 1];
    assert!(last.latched.contains(Fault::BridgeBreak));
}

#[test]
fn the_position_is_zero_where_it_is_told_to_be() {
    let mut image = controller();
    perform(&mut image, &["arm", "step 0 0.5"]);
    image.run_ms(800);
    assert_eq!(
        image.line("zero"),
        "refused: the drive is armed; `disarm` it first"
    );
    perform(&mut image, &["disarm", "zero"]);
    let status = image.line("status");
    assert!(status.contains("position 0.000000 rad"), "{status}");
    assert!(image.plant.state.position.value() > 0.4);
}

/// Lines that come together are done between two control steps, at any time in a control period.
#[test]
fn armed_in_one_batch_with_what_came_before_it_the_actuator_stays_where_it_is() {
    let batches = [
        ("disarm", "zero\rarm\r"),
        ("disarm", "set position_unit 0.0006\rarm\r"),
        ("disarm", "arm\rstep 0 -0.4\rdisarm\rarm\r"),
        ("ping", "disarm\rzero\rarm\r"),
        ("ping", "sine 0 0.4 1\rdisarm\rarm\r"),
        ("ping", "mode voltage\rstep 6 6\rdisarm\rarm\r"),
        ("ping", "disarm\rhome upper 0.9 1\rarm\rdisarm\rarm\r"),
    ];
    for (ticks, (before, batch)) in [0, 7]
        .into_iter()
        .flat_map(|ticks| batches.map(|it| (ticks, it)))
    {
        let mut image = controller();
        perform(&mut image, &["arm", "step 0 0.5"]);
        image.run_ms(800);
        perform(&mut image, &[before]);
        (0..ticks).for_each(|_| image.tick());
        let start = image.plant.state.position.value();
        let said = image.type_in(batch.as_bytes());
        let lines = batch.matches('\r').count();
        assert_eq!(said.matches("ok").count(), lines, "{said}");
        image.run_ms(500);
        let case = format!("{batch:?} {ticks} ticks behind a control step");
        assert!(image.plant.is_driven(), "{case}: {}", image.said);
        let moved = image.plant.state.position.value() - start;
        assert!(moved.abs() < 1e-3, "{case}: {moved} rad");
        // And it takes what comes then.
        perform(&mut image, &["mode position", "hold"]);
    }
}

#[test]
fn a_fault_that_is_cleared_before_the_next_poll_is_told_of() {
    let mut image = controller();
    let told = "fault: queue_overflow; the bridge is off; see `faults`";
    for _ in 0..2 {
        // None of these is in a poll.
        image.tasks_held = 200;
        for _ in 0..2 {
            image.wiring.trip(Fault::QueueOverflow);
            let said = image.type_in(b"clear\r");
            assert!(said.contains(told), "{said}");
            assert!(!image.wiring.latch().is_tripped(), "{said}");
        }
        image.run_ms(20);
        assert!(!image.said.contains("fault"), "{}", image.said);
    }
    image.wiring.trip(Fault::QueueOverflow);
    image.run_ms(10);
    assert!(image.said.contains(told), "{}", image.said);
}

#[test]
fn a_throttle_body_follows_its_wires_when_armed() {
    let mut image = OperationOnHost::throttle(&SharedFlash::new());
    image.plant.told = Bridge::Drive { duty: 0.8 };
    image.run_ms(300);
    let rest = image.wiring.truth().position;
    assert!((rest - THROTTLE.plant.spring_rest).abs() < 0.01, "{rest}");
    perform(&mut image, &["arm"]);
    image.run_ms(600);
    let open = image.wiring.truth().position;
    assert!((open - THROTTLE.plant.upper_stop).abs() < 1e-3, "{open}");
    let [first, second] = image.wiring.tracks();
    assert!(first > 3500 && second < 600, "{first} {second}");
    assert!(image.wiring.current_output() > 1024, "a current that opens");
    image.plant.told = Bridge::Drive { duty: -0.8 };
    image.run_ms(800);
    assert!(image.wiring.truth().position < 0.03);
    // Its engine controller lets go: the spring takes it home.
    image.plant.told = Bridge::Freewheel;
    image.run_ms(800);
    let home = image.wiring.truth().position;
    assert!((home - THROTTLE.plant.spring_rest).abs() < 0.01, "{home}");
    assert_eq!(
        image.line("step 0 1"),
        "refused: the actuator follows its wires; take `mode position` or `mode voltage` first"
    );
    perform(&mut image, &["mode position", "step 0 1"]);
    image.run_ms(1500);
    let reached = image.wiring.truth().position;
    assert!((reached - 1.0).abs() < 0.06, "{reached}");
}

#[test]
fn a_body_takes_faults_and_another_supply() {
    let mut image = OperationOnHost::throttle(&SharedFlash::new());
    image.plant.told = Bridge::Drive { duty: 0.5 };
    perform(&mut image, &["arm", "inject first_track_shorted_low"]);
    image.run_ms(100);
    assert_eq!(image.wiring.tracks()[0], 0);
    perform(&mut image, &["heal", "inject plate_jammed"]);
    image.run_ms(100);
    let jammed = image.wiring.truth().position;
    assert!(image.wiring.tracks()[0] > 300);
    perform(&mut image, &["supply 16"]);
    image.run_ms(300);
    assert_eq!(image.wiring.truth().position, jammed);
    assert!(image.line("status").contains("supply 16.00 V"));
    perform(&mut image, &["heal"]);
    image.run_ms(500);
    assert!(image.wiring.truth().position > 1.0);
    // What is emulated may be injected; a real actuator has its own.
    assert_eq!(
        controller().line("inject plate_jammed"),
        "refused: this image has nothing that could do it"
    );
}

#[test]
fn another_body_is_taken_disarmed_and_moves_as_its_numbers_say() {
    let mut image = OperationOnHost::throttle(&SharedFlash::new());
    image.plant.told = Bridge::Drive { duty: 0.6 };
    perform(&mut image, &["arm"]);
    assert_eq!(
        image.line("set spring_rest 0.3"),
        "refused: the drive is armed; `disarm` it first"
    );
    perform(&mut image, &["disarm"]);
    // Three in a row: each takes the spare's place.
    for rest in ["0.3", "0.5", "0.4"] {
        perform(&mut image, &[&format!("set spring_rest {rest}")]);
    }
    image.run_ms(50);
    assert_eq!(image.wiring.truth().position, 0.4);
    perform(&mut image, &["save"]);
    perform(&mut image, &["arm"]);
    image.run_ms(500);
    assert!(image.wiring.truth().position > 1.0);
}

#[test]
fn the_tracks_calibration_moves_them_at_once() {
    let mut image = OperationOnHost::throttle(&SharedFlash::new());
    // The mean, as both have noise.
    let mean = |image: &mut OperationOnHost<_>| {
        let mut sum = 0.0;
        for _ in 0..1000 {
            image.tick();
            sum += f64::from(image.wiring.tracks()[0]);
        }
        sum / 1000.0
    };
    let before = mean(&mut image);
    perform(
        &mut image,
        &["set track_1_gain 1.02", "set track_1_offset 0.1"],
    );
    let after = mean(&mut image);
    let expected = 1.02 * before + 0.1 / 5.0 * 4095.0;
    assert!(
        (after - expected).abs() < 1.0,
        "{before} {after} {expected}"
    );
}

#[test]
fn every_command_is_done_or_says_why_not_on_either_image() {
    /// A line for each command, and whether a throttle body and a controller do it, disarmed.
    const LINES: [(&str, bool, bool); 28] = [
        ("help", true, true),
        ("status", true, true),
        ("faults", true, true),
        ("clear", true, true),
        ("arm", true, true),
        ("disarm", true, true),
        ("stop", true, true),
        ("ping", true, true),
        ("mode voltage", true, true),
        ("step 0 1", false, false),
        ("ramp 0 1 1", false, false),
        ("sine 0 1 1", false, false),
        ("sweep 0 1 1 2 1", false, false),
        ("triangle 0 1 1", false, false),
        ("hold", false, false),
        ("zero", false, true),
        ("home lower -0.9 0.2", false, true),
        ("show", true, true),
        ("set coulomb 0.1", true, true),
        ("inject motor_open", true, false),
        ("heal", true, false),
        ("supply 10", true, false),
        ("record 1 1 now", true, true),
        ("dump", true, true),
        ("stream 0", true, true),
        ("refit", true, true),
        ("check", false, false),
        ("save", true, true),
    ];
    let names = LINES.map(|(line, ..)| line.split(' ').next().unwrap());
    assert!(
        names
            .iter()
            .eq(COMMANDS.iter().map(|command| &command.name))
    );
    let mut throttle = OperationOnHost::throttle(&SharedFlash::new());
    let mut controller = controller();
    for (line, by_throttle, by_controller) in LINES {
        let answers = [throttle.line(line), controller.line(line)];
        for (answer, done) in answers.iter().zip([by_throttle, by_controller]) {
            assert_eq!(!answer.starts_with("refused: "), done, "{line}: {answer}");
            assert!(!answer.is_empty() && !answer.starts_with("error"), "{line}");
        }
    }
}

/// Bytes of a terminal, one after the other, with nothing in between.
fn send<P: Plant>(image: &mut OperationOnHost<P>, bytes: &[u8]) {
    for &byte in bytes {
        image.byte(byte);
    }
}

#[test]
fn a_terminal_that_is_silent_for_too_long_is_a_fault_in_every_mode() {
    for lines in [
        ["mode position", "arm", "sine 0 0.5 1"],
        ["mode voltage", "arm", "sine 0 3 5"],
    ] {
        let mut image = controller();
        perform(&mut image, &["set command_timeout 2"]);
        perform(&mut image, &lines);
        // Of the last line 10 ms are over. Noise and blank lines are no sign of life.
        for _ in 0..19 {
            image.run_ms(100);
            send(&mut image, b"\r\x00stat\r");
        }
        image.run_ms(85);
        assert!(image.plant.is_driven());
        image.run_ms(10);
        assert!(!image.plant.is_driven());
        assert_latched(&mut image, Fault::CommandTimeout);
        perform(&mut image, &["disarm", "clear", "arm"]);
        image.run_ms(100);
        assert!(image.plant.is_driven());
        // Whatever is valid is one, what is refused too.
        for line in ["ping", "status", "help", "zero", "show load", "hold"] {
            image.line(line);
            image.run_ms(1900);
            assert!(image.plant.is_driven(), "{line}");
        }
    }
}

#[test]
fn ten_minutes_without_a_byte_are_not_driven_unless_that_is_chosen() {
    let mut image = controller();
    perform(&mut image, &["arm", "sine 0 0.5 0.5"]);
    image.run_ms(59_000);
    assert!(image.plant.is_driven());
    image.run_ms(1_100);
    assert_latched(&mut image, Fault::CommandTimeout);
    let mut image = controller();
    perform(
        &mut image,
        &["set command_timeout 0", "arm", "sine 0 0.5 0.5"],
    );
    image.run_ms(70_000);
    assert!(image.plant.is_driven());
    // What an engine controller drives by its wires waits for no terminal.
    let mut image = OperationOnHost::throttle(&SharedFlash::new());
    perform(&mut image, &["set command_timeout 1", "arm"]);
    image.run_ms(2000);
    assert_eq!(image.line("faults"), "none");
    perform(&mut image, &["mode position"]);
    image.run_ms(1100);
    assert_latched(&mut image, Fault::CommandTimeout);
}

#[test]
fn a_stream_of_settings_hides_no_fault() {
    let faults: [(Fault, Cause); 3] = [
        (Fault::UnderVoltage, |image| image.plant.supply = 17.0),
        (Fault::OverVoltage, |image| image.plant.supply = 31.0),
        (Fault::FollowingError, |image| image.plant.encoder = 0.0),
    ];
    for (fault, cause) in faults {
        let mut image = controller();
        perform(&mut image, &["arm"]);
        cause(&mut image);
        send(&mut image, b"step 0 0.8\r");
        for number in 0..50 {
            send(
                &mut image,
                format!("set proportional {}\r", 30 + number % 2).as_bytes(),
            );
            image.run_ms(1);
        }
        assert_latched(&mut image, fault);
    }
}

#[test]
fn stop_takes_the_power_before_the_next_tick_whatever_came_before_it() {
    for garbage in [&b""[..], b"\x00\xfe", b"step 0 1 0 ", &[b'x'; 1000]] {
        let mut image = moving();
        send(&mut image, garbage);
        send(&mut image, b"stop\r");
        image.tick();
        assert!(!image.plant.is_driven(), "{}", garbage.escape_ascii());
        assert!(image.line("status").starts_with("disarmed"));
    }
}
