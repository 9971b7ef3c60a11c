//! The piecewise affine model: cells by velocity and input, limits, refusals; between its samples.

use model_core::numeric::random::Random;
use model_core::plant::inter_sample::InterSample;
use model_core::plant::piecewise_affine::{Affine, Cell, Parameters, PiecewiseAffine};

use super::Findings;

/// A throttle in round numbers: at rest, opening, closing.
const CELLS: [Cell; 3] = [
    Cell {
        region: affine([0.0; 4]),
        growth: affine([0.0, 0.3, 0.0, 0.0]),
    },
    Cell {
        region: affine([-1.3, 90.0, 1.0, 1.7]),
        growth: affine([-0.0071, 0.77, 0.0047, 0.013]),
    },
    Cell {
        region: affine([1.3, -90.0, -1.0, -4.3]),
        growth: affine([-0.0067, 0.79, 0.0045, 0.023]),
    },
];

/// Period of the model, s.
const PERIOD: f32 = 0.01;

/// Ticks in a period.
const TICKS: u32 = 8;

const fn affine([position, change, input, constant]: [f32; 4]) -> Affine {
    Affine {
        position,
        change,
        input,
        constant,
    }
}

pub(super) fn steps(findings: &mut Findings) {
    let built = PiecewiseAffine::build(Parameters {
        period: PERIOD,
        lower_limit: 0.0,
        upper_limit: 1.57,
        cells: CELLS.into_iter().collect(),
    });
    let Some(model) = findings.sound(built, "the cells are taken") else {
        return;
    };
    let Some(mut state) = findings.sound(model.rest(1.57), "a position is taken") else {
        return;
    };
    let between = InterSample::new(model.clone(), 1.57, PERIOD / TICKS as f32);
    let Some(mut between) = findings.sound(between, "a period that fits is taken") else {
        return;
    };
    let mut random = Random::new(3, 7);
    let mut visits = [0; CELLS.len()];
    let mut input = 0.0;
    for tick in 0..5_000 {
        if tick % 30 == 0 {
            input = -6.0 * random.uniform();
        }
        visits[model.cell(&state, input)] += 1;
        let stepped = model.step(&mut state, input);
        findings.claim(stepped.is_ok(), "an input is taken");
        findings.single(state.position());
        let within = (0.0..=1.57).contains(&state.position());
        findings.claim(within, "the limits hold");
        for _ in 0..TICKS {
            let ticked = between.tick(input);
            findings.claim(ticked.is_ok(), "an input is taken between samples");
            findings.single(between.position());
        }
        let near = (between.position() - state.position()).abs() < 1e-4;
        findings.claim(near, "a period of ticks is a step");
    }
    let visited = visits.iter().all(|&visits| visits > 100);
    findings.claim(visited, "every cell is visited");
    let before = state;
    for refused in [f32::NAN, f32::NEG_INFINITY, 2e6] {
        let outcome = model.step(&mut state, refused);
        findings.claim(
            outcome.is_err() && state == before,
            "what is no input is refused",
        );
    }
}
