//! A capture holds what it was asked for: the trigger's row is the right one, so many rows before and
//! behind it, and no gap between them.

use firmware::app::capture::{
    Capture, Edge, QUANTITIES, Quantities, Quantity, Settings, Stage, Trigger, values,
};
use firmware::app::conversion::Converters;
use firmware::app::demonstration::UNDECLARED;
use firmware::app::fault::Fault;
use firmware::app::machine::EMA;
use firmware::app::record::{Marks, Sample};
use firmware::app::timing::TICKS_PER_CONTROL;
use firmware::app::wiring::Truth;
use host_tests::app_on_host::AppOnHost;
use proptest::prelude::*;

const CONVERTERS: &Converters = &EMA.converters;

/// A sample whose values all follow from its number.
fn numbered(sequence: u32) -> Sample {
    let count = (sequence % 10_000) as i16;
    Sample {
        sequence,
        command: sequence as f32,
        duty: count / 4,
        position: (-count).into(),
        current: count / 10,
        truth: Truth {
            position: 0.5 * sequence as f32,
            velocity: 2.0 * sequence as f32,
            current: 3.0 * sequence as f32,
        },
        marks: Marks::default(),
    }
}

/// A row as bits, for NaN is not itself.
fn bits(row: [f32; QUANTITIES]) -> [u32; QUANTITIES] {
    row.map(f32::to_bits)
}

/// What a row with these quantities of a sample is.
fn row_of(sample: &Sample, quantities: Quantities) -> [u32; QUANTITIES] {
    let mut row = values(sample, CONVERTERS);
    for quantity in Quantity::ALL {
        if !quantities.contains(quantity) {
            row[quantity as usize] = f32::NAN;
        }
    }
    bits(row)
}

fn quantities() -> impl Strategy<Value = Quantities> {
    prop::sample::subsequence(&Quantity::ALL, 1..=QUANTITIES).prop_map(|chosen| {
        chosen
            .into_iter()
            .fold(Quantities::default(), Quantities::with)
    })
}

proptest! {
    /// A ramp crosses each level once, at a sample that is known beforehand.
    #[test]
    fn the_rows_are_those_around_the_first_sample_at_or_beyond_the_level(
        quantities in quantities(),
        (before, after) in (0_u32..40, 1_u32..40),
        (start, crossing) in (0_u32..1000, 0_u32..200),
        fraction in 0.0_f32..1.0,
    ) {
        let first = start + 1 + crossing;
        // Between the sample before the first one, which is not included, and the first one.
        let level = first as f32 - fraction;
        let mut capture = Capture::<600>::new();
        let trigger = Trigger::Level { quantity: Quantity::Command, edge: Edge::Rising, level };
        capture.begin(Settings { quantities, trigger, before, after }).unwrap();
        let mut number = start;
        while capture.stage() != Stage::Complete {
            prop_assert!(number < first + after, "it does not end");
            prop_assert_eq!(capture.trigger_row().is_some(), number > first);
            capture.push(&numbered(number), CONVERTERS);
            number += 1;
        }
        prop_assert_eq!(number, first + after);
        let there = before.min(first - start);
        prop_assert_eq!(capture.trigger_row(), Some(there as usize));
        let rows: Vec<_> = capture.rows().map(bits).collect();
        let expected: Vec<_> = (first - there..first + after)
            .map(|number| row_of(&numbered(number), quantities))
            .collect();
        prop_assert_eq!(rows, expected);
        // What comes later is none of it.
        capture.push(&numbered(number), CONVERTERS);
        prop_assert_eq!(capture.rows().count() as u32, there + after);
    }

    #[test]
    fn a_missing_sample_is_never_between_two_rows(
        gaps in prop::collection::vec(1_u32..4, 200),
        (before, after) in (0_u32..20, 1_u32..20),
        at in 1_usize..150,
    ) {
        let mut capture = Capture::<80>::new();
        let settings = Settings {
            quantities: Quantities::LOG,
            trigger: Trigger::Command,
            before: before.min(10),
            after: after.min(10),
        };
        capture.begin(settings).unwrap();
        let mut number = 0;
        for (place, gap) in gaps.into_iter().enumerate() {
            // Mostly the next one.
            number += if gap < 3 { 1 } else { gap };
            let mut sample = numbered(number);
            sample.marks.command = place >= at;
            capture.push(&sample, CONVERTERS);
        }
        prop_assert_eq!(capture.stage(), Stage::Complete);
        let commands: Vec<f32> = capture.rows().map(|row| row[0]).collect();
        prop_assert!(!commands.is_empty());
        prop_assert!(commands.windows(2).all(|pair| pair[1] == pair[0] + 1.0), "{commands:?}");
    }
}

#[test]
fn a_falling_level_is_not_a_rising_one_and_an_equal_value_is_no_crossing() {
    let triggered = |edge, path: &[f32]| {
        let mut capture = Capture::<8>::new();
        let settings = Settings {
            quantities: Quantities::default().with(Quantity::Command),
            trigger: Trigger::Level {
                quantity: Quantity::TrueVelocity,
                edge,
                level: 1.0,
            },
            before: 0,
            after: 8,
        };
        capture.begin(settings).unwrap();
        path.iter().enumerate().position(|(place, &velocity)| {
            let mut sample = numbered(place as u32);
            sample.truth.velocity = velocity;
            capture.push(&sample, CONVERTERS);
            capture.stage() != Stage::Waiting
        })
    };
    assert_eq!(triggered(Edge::Rising, &[0.0, 0.9, 1.0, 2.0]), Some(2));
    assert_eq!(
        triggered(Edge::Falling, &[0.0, 0.9, 1.0, 2.0, 1.0]),
        Some(4)
    );
    assert_eq!(triggered(Edge::Rising, &[1.0, 1.0, 2.0, 1.0]), None);
    assert_eq!(triggered(Edge::Falling, &[2.0, f32::NAN, 0.0, 0.5]), None);
    assert_eq!(triggered(Edge::Rising, &[2.0]), None, "nothing was crossed");
}

/// The application's own samples, from its experiment on, with a fault at a control step.
fn captured(trigger: Trigger, fault_at: Option<u32>) -> Capture {
    let mut app = AppOnHost::new();
    app.load(&UNDECLARED);
    let mut capture = Capture::new();
    let settings = Settings {
        quantities: Quantities::LOG,
        trigger,
        before: 100,
        after: 200,
    };
    capture.begin(settings).unwrap();
    for step in 0..2000 {
        if fault_at == Some(step) {
            app.wiring.trip(Fault::OverCurrent);
        }
        for _ in 0..TICKS_PER_CONTROL {
            app.tick();
        }
        let log = |sample: &Sample| capture.push(sample, &UNDECLARED.machine.converters);
        // A fault ends a recording; a capture goes on.
        let _ = app.recording.drain(&mut app.memory, log);
    }
    capture
}

#[test]
fn a_command_is_captured_from_its_first_sample_on() {
    // The first one begins with the recording, and the second after 400 steps.
    let first = captured(Trigger::Command, None);
    assert_eq!(first.trigger_row(), Some(0));
    let level = Trigger::Level {
        quantity: Quantity::Command,
        edge: Edge::Rising,
        level: 0.8,
    };
    let second = captured(level, None);
    assert_eq!(second.trigger_row(), Some(100));
    let commands: Vec<f32> = second.rows().map(|row| row[0]).collect();
    assert_eq!(commands, [[0.3; 100].as_slice(), &[0.8; 200]].concat());
    let positions: Vec<f32> = second.rows().map(|row| row[2]).collect();
    assert_eq!(positions[100], positions[99], "it has not moved yet");
    assert!(positions[150] > positions[100] + 0.1, "and now it has");
}

#[test]
fn a_fault_is_captured_with_what_led_to_it_and_what_followed() {
    let capture = captured(Trigger::Fault, Some(420));
    assert_eq!(capture.stage(), Stage::Complete);
    assert_eq!(capture.trigger_row(), Some(100));
    let inputs: Vec<f32> = capture.rows().map(|row| row[1]).collect();
    assert!(inputs[..100].iter().any(|&volts| volts != 0.0));
    assert!(
        inputs[100..].iter().all(|&volts| volts == 0.0),
        "the bridge is off"
    );
    assert_eq!(inputs.len(), 300);
}

#[test]
fn what_cannot_be_recorded_is_refused_and_what_was_stays() {
    let mut capture = Capture::<8>::new();
    let sound = Settings {
        quantities: Quantities::LOG,
        trigger: Trigger::Now,
        before: 1,
        after: 1,
    };
    capture.begin(sound).unwrap();
    capture.push(&numbered(0), CONVERTERS);
    let one = Quantities::default().with(Quantity::Input);
    let refused = [
        (
            Settings {
                quantities: Quantities::default(),
                ..sound
            },
            "quantities",
        ),
        (Settings { after: 0, ..sound }, "after"),
        (Settings { before: 2, ..sound }, "before"),
        (
            Settings {
                before: u32::MAX,
                after: u32::MAX,
                ..sound
            },
            "before",
        ),
        (
            Settings {
                quantities: one,
                after: 8,
                ..sound
            },
            "before",
        ),
    ];
    for (settings, name) in refused {
        assert_eq!(
            capture.begin(settings).unwrap_err().name,
            name,
            "{settings:?}"
        );
        assert_eq!(capture.stage(), Stage::Complete);
        assert_eq!(capture.rows().count(), 1);
    }
    assert!(
        capture
            .begin(Settings {
                quantities: one,
                after: 7,
                ..sound
            })
            .is_ok()
    );
    assert_eq!(capture.stage(), Stage::Waiting);
    assert_eq!((capture.trigger_row(), capture.rows().count()), (None, 0));
}
