//! The queue from the control interrupt to the log, filled and emptied at once.

use std::thread;

use firmware::app::memory::Memory;
use firmware::app::record::{Marks, Progress, Recorder, Recording, Sample};
use firmware::app::timing::QUEUED_SAMPLES;
use firmware::app::wiring::{Truth, Wiring};
use heapless::spsc::Queue;

/// What the board keeps in a static.
fn leak<T: Default>() -> &'static mut T {
    Box::leak(Box::default())
}

fn sample(sequence: u32) -> Sample {
    Sample {
        sequence,
        command: 0.0,
        duty: 0,
        position: 0,
        current: 0,
        truth: Truth::default(),
        marks: Marks::default(),
    }
}

#[test]
fn each_sample_is_logged_in_its_order_or_counted_as_dropped() {
    // Many times what the queue holds.
    const COUNT: u32 = 10 * QUEUED_SAMPLES as u32;
    let progress: &'static Progress = leak();
    let wiring: &'static Wiring = leak();
    let (producer, consumer) = leak::<Queue<Sample, QUEUED_SAMPLES>>().split();
    let mut recorder = Recorder::new(producer, progress);
    let mut recording = Recording::new(consumer, progress, wiring);
    let mut memory = Box::<Memory>::default();
    let mut logged = Vec::new();
    progress.ask();
    let interrupt = thread::spawn(move || {
        recorder.begin();
        for sequence in 0..COUNT {
            recorder.push(sample(sequence));
            thread::yield_now();
        }
        recorder.finish();
    });
    let outcome = loop {
        let log = |sample: &Sample| logged.push(sample.sequence);
        if let Some(outcome) = recording.drain(&mut memory, log) {
            break outcome;
        }
        thread::yield_now();
    };
    interrupt.join().expect("an interrupt that ends");
    assert!(logged.is_sorted_by(|before, after| before < after));
    assert_eq!(outcome.samples as usize, logged.len());
    assert_eq!(outcome.samples + outcome.dropped, COUNT);
    // The queue was empty when it began.
    assert!(logged.starts_with(&[0, 1, 2]));
}
