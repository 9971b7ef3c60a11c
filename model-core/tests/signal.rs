//! Accuracy of the test signals over long times, against exact rational arithmetic.

use model_core::signal::{aprts, growing_triangle, ramp, sine, step, sweep, triangle};
use std::f64::consts::TAU;

/// One hour at 10 kHz.
const HOUR: u32 = 36_000_000;

/// `value` = mantissa/2^exponent exactly.
fn dyadic(value: f64) -> (u128, u32) {
    assert!(value > 0.0);
    let mut mantissa = value;
    let mut exponent = 0;
    while mantissa.fract() != 0.0 {
        mantissa *= 2.0;
        exponent += 1;
    }
    (mantissa as u128, exponent)
}

/// The fractional part of a ratio.
fn fraction(numerator: u128, denominator: u128) -> f64 {
    (numerator % denominator) as f64 / denominator as f64
}

/// Ticks up to an hour, dense at both ends.
fn ticks() -> impl Iterator<Item = u32> {
    (0..20_000)
        .chain((0..HOUR).step_by(7919))
        .chain(HOUR - 20_000..=HOUR)
}

#[test]
fn sine_does_not_drift_within_an_hour() {
    let (period, frequency) = (1e-4_f32, 4.7_f32);
    let signal = sine::Parameters {
        offset: 0.0,
        amplitude: 1.0,
        frequency,
        phase: 0.0,
    }
    .build(period)
    .unwrap();
    let (mantissa, exponent) = dyadic(f64::from(period) * f64::from(frequency));
    let mut worst = 0.0_f64;
    for tick in ticks() {
        let cycles = fraction(u128::from(tick) * mantissa, 1 << exponent);
        worst = worst.max((f64::from(signal.at(tick)) - (TAU * cycles).sin()).abs());
    }
    println!("worst error of the sine within an hour: {worst:.3e}");
    assert!(worst < 2.5e-7, "{worst:e}");
}

#[test]
fn sweep_does_not_drift_within_an_hour() {
    let period = 1e-4_f32;
    let duration = HOUR as f32 * period;
    for (initial, last) in [(0.2_f32, 5.0_f32), (0.1, 4_900.0), (4_900.0, 0.1)] {
        let signal = sweep::Parameters {
            offset: 0.0,
            amplitude: 1.0,
            initial_frequency: initial,
            final_frequency: last,
            duration,
        }
        .build(period)
        .unwrap();
        let ticks_total = (f64::from(duration) / f64::from(period)).round() as u128;
        let (advance, advance_exponent) = dyadic(f64::from(period) * f64::from(initial));
        let change = f64::from(period) * (f64::from(last) - f64::from(initial));
        let (rate, rate_exponent) = dyadic(change.abs());
        let mut worst = 0.0_f64;
        for tick in ticks() {
            let n = u128::from(tick);
            let linear = fraction(n * advance, 1 << advance_exponent);
            let quadratic =
                fraction(n * n * rate, (2 * ticks_total) << rate_exponent) * change.signum();
            let exact = (TAU * (linear + quadratic)).sin();
            worst = worst.max((f64::from(signal.at(tick)) - exact).abs());
        }
        println!("worst error of the sweep {initial} to {last} Hz within an hour: {worst:.3e}");
        assert!(worst < 2.5e-7, "{worst:e}");
    }
}

#[test]
fn sweep_goes_on_at_its_final_frequency() {
    let signal = sweep::Parameters {
        offset: 1.0,
        amplitude: 2.0,
        initial_frequency: 1.0,
        final_frequency: 3.0,
        duration: 0.25,
    }
    .build(1.0 / 1024.0)
    .unwrap();
    // Half a cycle at the end of the sweep: 0.25 s at 2 Hz on average.
    for held in 0..10_000 {
        let exact = 1.0 + 2.0 * (TAU * (0.5 + 3.0 * f64::from(held) / 1024.0)).sin();
        assert!(
            (f64::from(signal.at(256 + held)) - exact).abs() < 1e-6,
            "{held}"
        );
    }
}

#[test]
fn phase_of_a_sine_and_a_triangle_is_in_radians() {
    let quarter = std::f32::consts::FRAC_PI_2;
    for (phase, expected) in [(quarter, 1.0), (-quarter, -1.0), (5.0 * quarter, 1.0)] {
        let sine = sine::Parameters {
            offset: 0.0,
            amplitude: 1.0,
            frequency: 1.0,
            phase,
        };
        assert_eq!(sine.build(0.01).unwrap().at(0), expected);
        let triangle = triangle::Parameters {
            offset: 0.0,
            amplitude: 1.0,
            frequency: 1.0,
            phase,
        };
        assert!((triangle.build(0.01).unwrap().at(0) - expected).abs() < 5e-7);
    }
}

#[test]
fn ramp_is_within_its_error_and_ends_exactly() {
    let (from, to, period) = (-0.3_f32, 0.7_f32, 1e-4_f32);
    let ramp = ramp::Parameters {
        initial_value: from,
        final_value: to,
        start: 0.5,
        duration: 3599.0,
    }
    .build(period)
    .unwrap();
    let duration = (3599.0 / f64::from(period)).round();
    let mut worst = 0.0_f64;
    for tick in ticks() {
        let share = (f64::from(tick) - 5_000.0).max(0.0) / duration;
        let exact = f64::from(from) + share.min(1.0) * (f64::from(to) - f64::from(from));
        worst = worst.max((f64::from(ramp.at(tick)) - exact).abs());
    }
    println!("worst error of the ramp: {worst:.3e}");
    assert!(worst < 4.2e-7 * f64::from(to), "{worst:e}");
    assert_eq!(
        [0, 5_000, HOUR, u32::MAX].map(|tick| ramp.at(tick)),
        [from, from, to, to]
    );
}

#[test]
fn bad_parameters_are_named() {
    let step = step::Parameters {
        initial_value: 0.0,
        final_value: 1.0,
        time: 1.0,
    };
    assert_eq!(step.build(0.0).unwrap_err().name, "period");
    assert_eq!(
        step::Parameters { time: -1.0, ..step }
            .build(0.1)
            .unwrap_err()
            .name,
        "time"
    );
    assert_eq!(
        step::Parameters { time: 1e30, ..step }
            .build(0.1)
            .unwrap_err()
            .name,
        "time"
    );
    assert_eq!(
        step::Parameters {
            time: f32::NAN,
            ..step
        }
        .build(0.1)
        .unwrap_err()
        .name,
        "time"
    );

    let ramp = ramp::Parameters {
        initial_value: 0.0,
        final_value: 1.0,
        start: 0.0,
        duration: 1.0,
    };
    let short = ramp::Parameters {
        duration: 0.04,
        ..ramp
    };
    assert_eq!(short.build(0.1).unwrap_err().name, "duration");

    let sine = sine::Parameters {
        offset: 0.0,
        amplitude: 1.0,
        frequency: 1.0,
        phase: 0.0,
    };
    for frequency in [-1.0, 5.1, f32::NAN] {
        let refused = sine::Parameters { frequency, ..sine }
            .build(0.1)
            .unwrap_err();
        assert_eq!(refused.name, "frequency");
    }
    let refused = sine::Parameters {
        phase: f32::INFINITY,
        ..sine
    }
    .build(0.1)
    .unwrap_err();
    assert_eq!(refused.name, "phase");

    let sweep = sweep::Parameters {
        offset: 0.0,
        amplitude: 1.0,
        initial_frequency: 1.0,
        final_frequency: 6.0,
        duration: 1.0,
    };
    assert_eq!(sweep.build(0.1).unwrap_err().name, "final_frequency");
}

/// Over 20 000 steps: the levels fill their range evenly and know nothing of the level before, the
/// holds keep their bounds and their mean.
#[test]
fn aprts_draws_levels_and_holds_as_promised() {
    let parameters = aprts::Parameters {
        lower: -2.0,
        upper: 6.0,
        shortest_hold: 0.02,
        longest_hold: 0.1,
        seed: 5,
    };
    let signal = parameters.build(1e-3).unwrap();
    let mut levels = vec![signal.at(0)];
    let mut switches = Vec::new();
    for tick in 1..1_200_000 {
        let level = signal.at(tick);
        if level != *levels.last().unwrap() {
            levels.push(level);
            switches.push(tick);
        }
    }
    let holds: Vec<u32> = switches.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(holds.iter().all(|hold| (20..=100).contains(hold)));
    assert!(holds.contains(&21) || holds.contains(&20));
    assert!(holds.contains(&99) || holds.contains(&100));
    let mean = f64::from(holds.iter().sum::<u32>()) / holds.len() as f64;
    assert!((mean - 60.0).abs() < 0.01, "{mean}");

    assert!(levels.iter().all(|level| (-2.0..=6.0).contains(level)));
    let n = levels.len() as f64;
    let share = |x: &f32| (f64::from(*x) + 2.0) / 8.0 - 0.5;
    let moment = |lag: usize| {
        let pairs = levels.iter().zip(&levels[lag..]);
        pairs.map(|(a, b)| share(a) * share(b)).sum::<f64>() / n
    };
    // Five standard errors: of the mean, the variance and the covariance of uniform numbers.
    assert!(levels.iter().map(share).sum::<f64>().abs() / n < 5.0 * (1.0 / 12.0 / n).sqrt());
    assert!((moment(0) - 1.0 / 12.0).abs() < 5.0 * (1.0 / 180.0 / n).sqrt());
    for lag in 1..5 {
        assert!(moment(lag).abs() < 5.0 / 12.0 / n.sqrt(), "lag {lag}");
    }

    let same = parameters.build(1e-3).unwrap();
    let other = aprts::Parameters {
        seed: 6,
        ..parameters
    };
    let other = other.build(1e-3).unwrap();
    assert!((0..1000).all(|tick| same.at(tick) == signal.at(tick)));
    assert!((0..1000).any(|tick| other.at(tick) != signal.at(tick)));
}

#[test]
fn growing_triangle_keeps_its_slope_and_starts_over() {
    let signal = growing_triangle::Parameters {
        offset: -3.0,
        amplitude: 3.0,
        first: 10,
        last: 18,
        duration: 60.0,
    }
    .build(1e-3)
    .unwrap();
    // 2 (18·19 − 10·9) quarters of 119 ticks; 1/18 of 3 V each.
    let (ticks, slope) = (504 * 119, 3.0 / 18.0 / 119.0);
    let mut turns = 0;
    let mut rising = true;
    for tick in 1..=ticks {
        let step = signal.at(tick) - signal.at(tick - 1);
        assert!((step.abs() - slope).abs() < 1e-6, "{tick}: {step}");
        if (step > 0.0) != rising {
            rising = !rising;
            turns += 1;
        }
    }
    assert_eq!(turns, 18);
    assert_eq!(signal.at(ticks), signal.at(0));
    assert_eq!(signal.at(ticks + 1000), signal.at(1000));
}

#[test]
fn bad_parameters_of_steps_and_growing_triangles_are_named() {
    let steps = aprts::Parameters {
        lower: 0.0,
        upper: 1.0,
        shortest_hold: 0.1,
        longest_hold: 0.2,
        seed: 0,
    };
    let name = |parameters: aprts::Parameters| parameters.build(1e-2).unwrap_err().name;
    let (upper, lower) = (f32::NAN, f32::INFINITY);
    assert_eq!(name(aprts::Parameters { upper, ..steps }), "upper");
    assert_eq!(name(aprts::Parameters { lower, ..steps }), "lower");
    let shortest_hold = 1e-3;
    assert_eq!(
        name(aprts::Parameters {
            shortest_hold,
            ..steps
        }),
        "shortest_hold"
    );
    let longest_hold = 0.05;
    assert_eq!(
        name(aprts::Parameters {
            longest_hold,
            ..steps
        }),
        "longest_hold"
    );
    let triangle = growing_triangle::Parameters {
        offset: 0.0,
        amplitude: 1.0,
        first: 1,
        last: 4,
        duration: 1.0,
    };
    let name = |parameters: growing_triangle::Parameters| parameters.build(1e-2).unwrap_err().name;
    let (first, last, duration) = (5, 0, 0.1);
    assert_eq!(
        name(growing_triangle::Parameters { last, ..triangle }),
        "last"
    );
    assert_eq!(
        name(growing_triangle::Parameters { first, ..triangle }),
        "first"
    );
    assert_eq!(
        name(growing_triangle::Parameters {
            duration,
            ..triangle
        }),
        "duration"
    );
}
