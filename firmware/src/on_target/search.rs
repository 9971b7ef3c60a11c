//! The searches, and the friction's re-estimation with them.

use model_core::identify::friction::{Refit, Task};
use model_core::identify::{annealing, golden_section};

use super::log::{self, Recording};
use super::{Findings, plant};

pub(super) fn annealing(findings: &mut Findings) {
    let steps = [
        annealing::StepFunction::Fast,
        annealing::StepFunction::Boltzmann,
    ];
    let coolings = [
        annealing::Cooling::Exponential { factor: 0.95 },
        annealing::Cooling::Fast,
        annealing::Cooling::Boltzmann,
    ];
    let acceptances = [
        annealing::Acceptance::Metropolis,
        annealing::Acceptance::Logistic,
    ];
    for index in 0..12 {
        let parameters = annealing::Parameters {
            step: steps[index % 2],
            cooling: coolings[index / 2 % 3],
            acceptance: acceptances[index / 6],
            reannealing_interval: Some(20),
            evaluations: 300,
            ..annealing::Parameters::new([-1.0, 0.0], [1.0, 50.0], [0.9, 45.0])
        };
        let Some(mut search) = findings.sound(parameters.build(7), "bounds are taken") else {
            return;
        };
        while let Some([x, y]) = search.propose() {
            findings.single(x);
            findings.single(y);
            let (x, y) = (x - 0.2, 0.04 * (y - 20.0));
            search.report(x * x + y * y);
        }
        let near = search.best().is_some_and(|(_, cost)| cost < 0.1);
        findings.claim(near, "the minimum is found");
    }
}

pub(super) fn golden_section(findings: &mut Findings) {
    let parameters = golden_section::Parameters {
        lower: 0.0,
        upper: 1.0,
        tolerance: 0.01,
        evaluations: 50,
    };
    let Some(mut search) = findings.sound(parameters.build(), "bounds are taken") else {
        return;
    };
    while let Some(x) = search.propose() {
        findings.single(x);
        search.report((x - 0.3) * (x - 0.3));
    }
    // 0.618¹⁰ < 0.01.
    findings.claim(search.evaluations() == 11, "the evaluations of the formula");
    let near = search.best().is_some_and(|(x, _)| (x - 0.3).abs() < 0.01);
    findings.claim(near, "the minimum is found");
}

pub(super) fn friction(findings: &mut Findings) {
    /// Five windows.
    const SAMPLES: usize = 1020;
    const TRUTH: f32 = 0.2;
    let mut recording = Recording::<SAMPLES>::new();
    let driven = recording.drive(&plant::EMA, TRUTH);
    findings.claim(driven, "the log is made");
    let task = Task {
        declared: plant::EMA,
        log: recording.log(),
        resolution: log::CONVERTERS.position.unit(),
        present: 0.12,
        seed: 1,
    };
    let Some(refit) = findings.sound(Refit::new(&task), "the task is taken") else {
        return;
    };
    if let Some(estimate) = findings.sound(refit.run(), "a friction is found") {
        findings.single(estimate.coulomb);
        findings.single(estimate.cost);
        findings.single(estimate.present_cost);
        findings.word(estimate.golden_section_evaluations);
        let near = (estimate.coulomb / TRUTH - 1.0).abs() < 0.01;
        findings.claim(near, "the friction is within 1 %");
    }
}
