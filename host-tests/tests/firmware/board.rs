//! What the boards compute beside the application: the position sensor that they play, the late
//! tick, the load.

use firmware::app::tracks::{FULL_SCALE, Tracks};
use firmware::board::deadline::Deadline;
use firmware::board::load::Load;

#[test]
fn the_tracks_spread_the_stroke_over_four_fifths_of_the_converter_and_add_up_to_full_scale() {
    let tracks = Tracks::new(-0.5, 1.5);
    // 0.5 and 4.5 V of 5 V: 409.5 and 3685.5, to the nearest.
    for (position, share) in [(-0.5, 0.1), (0.0, 0.3), (0.5, 0.5), (1.5, 0.9)] {
        let [rising, falling] = tracks.codes(position).map(f64::from);
        assert!((rising - 4095.0 * share).abs() <= 0.5 + 1e-3, "{position}");
        assert!((falling - 4095.0 * (1.0 - share)).abs() <= 0.5 + 1e-3);
    }
    for step in 0..=2000 {
        let [rising, falling] = tracks.codes(-0.5 + step as f32 * 1e-3);
        assert!((rising + falling).abs_diff(FULL_SCALE) <= 1);
    }
}

#[test]
fn the_tracks_stay_at_their_rails_far_beyond_the_stroke_and_nothing_is_at_zero_on_both() {
    let tracks = Tracks::new(-1.0, 1.0);
    for beyond in [-1.3, -100.0, f32::NEG_INFINITY] {
        assert_eq!(tracks.codes(beyond), [0, FULL_SCALE], "{beyond}");
    }
    for beyond in [1.3, 100.0, f32::INFINITY] {
        assert_eq!(tracks.codes(beyond), [FULL_SCALE, 0], "{beyond}");
    }
    assert_eq!(tracks.codes(f32::NAN), [0, 0]);
}

#[test]
fn a_tick_is_late_from_half_a_period_on_and_over_the_counter_s_end_too() {
    let mut deadline = Deadline::new(8400);
    let first = u32::MAX - 20_000;
    assert!(!deadline.missed(first), "nothing to be late against");
    let in_time = first + 8400 + 4200;
    assert!(!deadline.missed(in_time));
    // The counter begins anew in this period.
    let late = in_time.wrapping_add(8400 + 4201);
    assert!(deadline.missed(late));
    assert!(!deadline.missed(late.wrapping_add(8400)));
}

#[test]
fn the_load_is_the_worst_and_the_mean() {
    let mut load = Load::new();
    assert_eq!((load.worst(), load.mean()), (0, 0));
    for duration in [300, 900, 301] {
        load.add(duration);
    }
    assert_eq!((load.worst(), load.mean()), (900, 500));
}

#[test]
fn the_mean_load_of_a_long_run_is_right() {
    let mut load = Load::new();
    for _ in 0..1_000_000 {
        load.add(8000);
    }
    assert_eq!(load.mean(), 8000, "the sum is more than 32 bits hold");
}

/// Four days of ticks are more than 32 bits count, and their durations too.
#[test]
#[ignore = "at length"]
fn the_mean_load_of_days_is_right() {
    const TICKS_A_DAY: u64 = 20_000 * 24 * 60 * 60;
    let mut load = Load::new();
    for duration in [8000, 4000] {
        for _ in 0..2 * TICKS_A_DAY {
            load.add(duration);
        }
    }
    assert_eq!((load.worst(), load.mean()), (8000, 6000));
}
