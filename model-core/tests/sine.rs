//! Accuracy of the core's sine against the standard library's in `f64`.

use model_core::numeric::sine::{sine_cycles, sine_phase, triangle_phase};
use std::f64::consts::TAU;

/// The error that the documentation promises.
const WORST: f64 = 1.8e-7;

#[test]
fn sine_of_cycles_is_within_its_error() {
    let mut worst = 0.0_f64;
    // A dense grid over two cycles, then ever sparser ones up to where f32 holds whole cycles only.
    for (scale, points) in [
        (1.0, 4_000_000),
        (1e3, 400_000),
        (1e5, 400_000),
        (2e7, 400_000),
    ] {
        for k in -points..=points {
            let x = (scale * f64::from(k) / f64::from(points)) as f32;
            let exact = (TAU * f64::from(x).fract()).sin();
            worst = worst.max((f64::from(sine_cycles(x)) - exact).abs());
            assert!(sine_cycles(x).abs() <= 1.0);
        }
    }
    println!("worst absolute error of sine_cycles: {worst:.3e}");
    assert!(worst < WORST, "{worst:e}");
}

#[test]
fn sine_of_a_phase_is_within_its_error() {
    let mut worst = 0.0_f64;
    let mut worst_triangle = 0.0_f64;
    // A step that is odd, so that it visits every low bit.
    for phase in (0..=u32::MAX).step_by(1009) {
        let cycles = f64::from(phase) / 4_294_967_296.0;
        worst = worst.max((f64::from(sine_phase(phase)) - (TAU * cycles).sin()).abs());
        let triangle = 1.0 - 4.0 * ((cycles + 0.25).fract() - 0.5).abs();
        worst_triangle = worst_triangle.max((f64::from(triangle_phase(phase)) - triangle).abs());
    }
    println!("worst absolute error of sine_phase: {worst:.3e}, triangle {worst_triangle:.3e}");
    assert!(worst < WORST, "{worst:e}");
    assert!(worst_triangle < 3.1e-8, "{worst_triangle:e}");
}

#[test]
fn quarters_are_exact() {
    for (cycles, expected) in [
        (0.0, 0.0),
        (0.25, 1.0),
        (0.5, 0.0),
        (0.75, -1.0),
        (-0.25, -1.0),
    ] {
        assert_eq!(sine_cycles(cycles), expected);
        assert_eq!(sine_cycles(cycles + 1024.0), expected);
    }
    for (phase, expected) in [(0, 0.0), (1 << 30, 1.0), (1 << 31, 0.0), (3 << 30, -1.0)] {
        assert_eq!(sine_phase(phase), expected);
        assert_eq!(triangle_phase(phase), expected);
    }
}

#[test]
fn large_arguments_are_whole_cycles_and_non_finite_ones_have_no_sine() {
    for x in [8_388_609.0, 16_777_217.0, 1e30, f32::MAX, -8_388_609.0] {
        assert_eq!(sine_cycles(x), 0.0);
    }
    for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert!(sine_cycles(x).is_nan());
    }
}
