//! What a debug probe reads and writes: a ring gives what was put in, loses what there is no room for, and nothing that a
//! probe writes leads out of it. And what is typed at a probe is taken as what is typed at the terminal.

use std::collections::VecDeque;
use std::sync::atomic::Ordering::Relaxed;

use firmware::app::fault::Fault;
use firmware::app::machine::EMA;
use firmware::app::operation::operator::Keyboard;
use firmware::app::rtt::{Bytes, Ring, bytes};
use host_tests::operation_on_host::{Motor, OperationOnHost, SharedFlash};
use proptest::prelude::*;

const SIZE: usize = 16;

/// A ring of its own.
fn ring() -> Ring<SIZE> {
    let bytes: &'static Bytes<SIZE> = Box::leak(Box::new(bytes()));
    Ring::new(b"test\0\0\0\0", bytes)
}

#[derive(Debug, Clone)]
enum Step {
    Write(Vec<u8>),
    Piece(Vec<u8>, Vec<u8>),
    Read(usize),
}

fn step() -> impl Strategy<Value = Step> {
    let text = || prop::collection::vec(any::<u8>(), 0..2 * SIZE);
    prop_oneof![
        text().prop_map(Step::Write),
        (text(), text()).prop_map(|(first, second)| Step::Piece(first, second)),
        (0..2 * SIZE).prop_map(Step::Read),
    ]
}

proptest! {
    /// Against a queue of bytes that has room for one less than the ring has.
    #[test]
    fn a_ring_gives_what_was_put_in_and_a_piece_whole_or_not_at_all(steps in prop::collection::vec(step(), 1..40)) {
        let ring = ring();
        let mut expected = VecDeque::new();
        for step in steps {
            let room = SIZE - 1 - expected.len();
            match step {
                Step::Write(text) => {
                    ring.write(&text);
                    expected.extend(text.into_iter().take(room));
                }
                Step::Piece(first, second) => {
                    let mut piece = ring.begin();
                    ring.put(&mut piece, &first);
                    ring.put(&mut piece, &second);
                    ring.end(piece);
                    if first.len() + second.len() <= room {
                        expected.extend(first.into_iter().chain(second));
                    }
                }
                Step::Read(count) => {
                    for _ in 0..count {
                        prop_assert_eq!(ring.read(), expected.pop_front());
                    }
                }
            }
        }
    }

    /// Whatever a probe makes of the places, at any time.
    #[test]
    fn nothing_that_a_probe_writes_leads_out_of_a_ring_or_to_no_end(
        places in prop::collection::vec(prop_oneof![any::<u32>(), 0..2 * SIZE as u32], 4),
        text in prop::collection::vec(any::<u8>(), 0..3 * SIZE),
    ) {
        let ring = ring();
        let set = |places: &[u32]| {
            for (place, to) in ring.places.iter().zip(places) {
                place.store(*to, Relaxed);
            }
        };
        set(&places[..2]);
        let mut piece = ring.begin();
        ring.put(&mut piece, &text);
        set(&places[2..]);
        ring.put(&mut piece, &text);
        ring.end(piece);
        let read = std::iter::from_fn(|| ring.read()).take(SIZE).count();
        prop_assert!(read < SIZE, "{} bytes of a ring of {}", read, SIZE);
        // It works again.
        ring.write(b"stop");
        prop_assert_eq!(std::iter::from_fn(|| ring.read()).collect::<Vec<_>>(), b"stop");
    }
}

fn controller() -> OperationOnHost<Motor> {
    let mut image = OperationOnHost::controller(&SharedFlash::new(), &EMA.plant);
    image.run_ms(100);
    image.line("zero");
    image
}

#[test]
fn what_one_types_is_no_part_of_the_line_of_the_other() {
    let mut image = controller();
    image.type_at(Keyboard::Terminal, b"set coulomb 0.0");
    let said = image.type_at(Keyboard::Probe, b"show static\r");
    assert!(said.contains("static = "), "{said}");
    image.type_at(Keyboard::Probe, b"garbage \xff\x00");
    image.type_at(Keyboard::Terminal, b"7\r");
    let said = image.type_at(Keyboard::Terminal, b"show coulomb\r");
    assert!(said.contains("coulomb = 0.07"), "{said}");
}

#[test]
fn a_probe_has_the_rules_of_arming_of_the_terminal_and_either_stops_the_other() {
    for (one, other) in [
        (Keyboard::Probe, Keyboard::Terminal),
        (Keyboard::Terminal, Keyboard::Probe),
    ] {
        let mut image = controller();
        let said = image.type_at(one, b"step 0 0.1\r");
        assert!(said.contains("refused: the drive is disarmed"), "{said}");
        image.type_at(one, b"arm\r");
        assert!(image.wiring.latch().is_armed());
        // In the middle of a line of the one.
        image.type_at(one, b"step 0 0");
        image.type_at(other, b"stop\r");
        assert!(!image.wiring.latch().is_armed());
    }
}

#[test]
fn a_drive_lets_go_when_both_are_silent_and_not_while_one_speaks() {
    let mut image = controller();
    assert_eq!(image.line("set command_timeout 2"), "ok");
    image.type_at(Keyboard::Probe, b"arm\rsine 0 0.5 1\r");
    // Twice as long as it waits.
    for _ in 0..8 {
        image.run_ms(500);
        image.type_at(Keyboard::Probe, b"ping\r");
        assert!(image.plant.is_driven());
    }
    // What is not understood is no sign of life.
    for _ in 0..5 {
        image.run_ms(500);
        image.type_at(Keyboard::Probe, b"pong\r");
    }
    assert!(!image.plant.is_driven());
    assert!(
        image
            .wiring
            .latch()
            .causes()
            .contains(Fault::CommandTimeout)
    );
}
