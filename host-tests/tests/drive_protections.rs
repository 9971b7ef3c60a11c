//! What protects people and hardware beside the limits: the emergency stop.

use firmware::app::fault::Fault;
use firmware::app::fault::output::Outputs;
use firmware::app::machine::EMA;
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};

/// The declared actuator at its controller.
fn declared() -> OperationOnHost<Motor> {
    OperationOnHost::controller(&SharedFlash::new(), &EMA.plant)
}

/// Lines that must be done.
fn perform(image: &mut OperationOnHost<Motor>, lines: &[&str]) {
    for line in lines {
        assert_eq!(image.line(line), "ok", "{line}");
    }
}

#[test]
fn an_emergency_stop_switches_the_bridge_off_in_the_tick_that_reads_it_and_is_named_first() {
    let mut image = declared();
    perform(&mut image, &["mode voltage", "arm", "step 0 12"]);
    assert!(image.plant.is_driven());
    // A contact that opens for one tick, together with what may come of it.
    image.plant.stopped = true;
    image.plant.broken = true;
    image.tick();
    assert!(!image.plant.is_driven());
    assert_eq!(image.wiring.latch().outputs(), Outputs::SAFE);
    image.plant.stopped = false;
    image.plant.broken = false;
    image.run_ms(50);
    assert_eq!(image.wiring.fault(), Some(Fault::EmergencyStop));
    assert!(!image.plant.is_driven());
}

#[test]
fn nothing_clears_an_emergency_stop_that_is_pressed_and_nothing_moves_when_it_is_released() {
    let mut image = declared();
    perform(&mut image, &["arm", "step 0 0.5"]);
    image.plant.stopped = true;
    image.run_ms(10);
    let armed = image.line("clear");
    assert_eq!(armed, "refused: the drive is armed; `disarm` it first");
    perform(&mut image, &["disarm"]);
    for _ in 0..3 {
        let refused = image.line("clear");
        assert_eq!(
            refused,
            "refused: still there: emergency_stop; end that first"
        );
        assert!(image.line("arm").contains("emergency_stop"));
    }
    image.plant.stopped = false;
    image.run_ms(10);
    // Released it is over, but not forgotten.
    assert!(image.line("arm").contains("emergency_stop"));
    perform(&mut image, &["clear"]);
    let before = image.plant.state.position.value();
    perform(&mut image, &["arm"]);
    image.run_ms(200);
    assert!(image.plant.is_driven());
    let moved = (image.plant.state.position.value() - before).abs();
    // It is held where it is: within the encoder's count.
    assert!(moved <= EMA.converters.position.unit(), "{moved} rad");
}

#[test]
fn a_board_whose_emergency_stop_is_neither_wired_nor_strapped_does_not_arm() {
    let mut image = declared();
    image.plant.stopped = true;
    image.run_ms(10);
    let refused = image.line("arm");
    assert!(refused.contains("emergency_stop"), "{refused}");
    let faults = image.line("faults");
    assert!(faults.contains("PB15"), "{faults}");
    for line in ["mode voltage", "save"] {
        perform(&mut image, &[line]);
    }
    assert!(image.line("arm").contains("emergency_stop"));
    assert!(!image.plant.is_driven());
}
