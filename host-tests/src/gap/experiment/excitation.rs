//! The usual excitations, as shapes between −1 and 1 over time.

use std::f64::consts::TAU;

/// A shape of the input.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// What it is called.
    pub name: &'static str,
    /// Its value after so many periods and at this share of the experiment.
    pub at: fn(periods: f64, share: f64) -> f64,
}

/// Every shape that is tried, those that swing to both sides first: without a spring or a stop the
/// others run away.
pub(super) const SHAPES: [Shape; 15] = [
    Shape {
        name: "steps both ways",
        at: |periods, _| [1.0, -1.0][slot(periods, 2)],
    },
    Shape {
        name: "steps both ways with rests between them",
        at: |periods, _| [1.0, 0.0, -1.0, 0.0][slot(periods, 4)],
    },
    Shape {
        name: "short pulses both ways",
        at: |periods, _| [1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0][slot(periods, 8)],
    },
    Shape {
        name: "steps both ways of three levels with rests between them",
        at: |periods, _| {
            let level = [1.0, 0.7, 0.45][slot(periods / 3.0, 3)];
            level * [1.0, 0.0, -1.0, 0.0][slot(periods, 4)]
        },
    },
    Shape {
        name: "a staircase both ways",
        at: |periods, _| {
            let step = slot(periods, 16) as f64;
            let stairs = |step: f64| 0.25 * step.min(8.0 - step);
            if step < 8.0 {
                stairs(step)
            } else {
                -stairs(step - 8.0)
            }
        },
    },
    Shape {
        name: "a triangle",
        at: |periods, _| triangle(periods),
    },
    Shape {
        name: "a triangle that grows",
        at: |periods, share| (0.3 + 0.7 * share) * triangle(periods),
    },
    Shape {
        name: "a sine",
        at: |periods, _| (TAU * periods).sin(),
    },
    Shape {
        name: "a sine that grows",
        at: |periods, share| (0.3 + 0.7 * share) * (TAU * periods).sin(),
    },
    Shape {
        name: "a sweep to six times the frequency",
        at: |periods, share| (TAU * periods * (1.0 + 2.5 * share)).sin(),
    },
    Shape {
        name: "three sines",
        at: |periods, _| {
            let sine = |ratio: f64, phase: f64| (TAU * ratio * periods + phase).sin();
            0.5 * sine(1.0, 0.0) + 0.3 * sine(2.7, 1.1) + 0.2 * sine(6.1, 2.3)
        },
    },
    Shape {
        name: "a triangle with a fast sine on it",
        at: |periods, _| 0.65 * triangle(periods) + 0.35 * (TAU * 7.0 * periods).sin(),
    },
    Shape {
        name: "pushes forward with rests between them",
        at: |periods, _| [1.0, 0.0][slot(periods, 2)],
    },
    Shape {
        name: "pushes backward with rests between them",
        at: |periods, _| [-1.0, 0.0][slot(periods, 2)],
    },
    Shape {
        name: "a sine to one side",
        at: |periods, _| 0.5 - 0.5 * (TAU * periods).cos(),
    },
];

/// Which of so many equal parts of a period.
fn slot(periods: f64, parts: usize) -> usize {
    ((periods.rem_euclid(1.0) * parts as f64) as usize).min(parts - 1)
}

/// From 0 up, down and back.
fn triangle(periods: f64) -> f64 {
    1.0 - 4.0 * ((periods + 0.25).rem_euclid(1.0) - 0.5).abs()
}
