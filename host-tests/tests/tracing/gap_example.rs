//! Answers of `cargo hil gap` made by hand: of every verdict, and of every state that a log may be in.

use host_tests::gap::demand::Demand;
use host_tests::gap::outcome::{
    Candidate, Correlations, Cost, ErrorSet, Errors, Estimate, Evidence, FittedParameter,
    FoundEffect, LearnedLaw, Outcome, Report, Residual, Stages, Unknown, Whiteness,
};
use model_core::gap::verdict::Verdict;

/// A slide driven by a force, 1 kHz: its viscous friction differs with the direction, which the
/// model before effects does not know. Windows of 0.2 s; the torque residual is decimated by 10.
pub fn slide(label: &str, samples: usize) -> Evidence {
    const STEP: f64 = 1e-3;
    const MASS: f64 = 95.0;
    let friction = |forward: f64, backward: f64, velocity: f64| {
        let viscous = if velocity > 0.0 { forward } else { backward };
        viscous * velocity + 20.2 * (velocity / 1e-3).tanh()
    };
    let truth = |velocity| friction(166.0, 243.0, velocity);
    let before = |velocity| friction(203.5, 203.5, velocity);
    let after = |velocity| friction(167.2, 241.5, velocity);
    let mut seed = 1_u64;
    let mut noise = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (seed >> 33) as f64 / 2f64.powi(31) - 0.5
    };

    let mut log = Evidence {
        label: label.into(),
        ..Evidence::default()
    };
    // (position, velocity) of the slide, of the model before effects and of that after.
    let mut states = [(0.0_f64, 0.0_f64); 3];
    for sample in 0..samples {
        let time = sample as f64 * STEP;
        let force = 55.0 * (1.9 * time).sin() + 12.0 * (7.3 * time).sin();
        if sample % 200 == 0 {
            log.window_starts.push(sample);
            states = [states[0]; 3];
        }
        let (position, velocity) = states[0];
        log.time.push(time as f32);
        log.position.push((position + 4e-6 * noise()) as f32);
        log.velocity.push(velocity as f32);
        log.input.push((force / 35.15) as f32);
        log.current.push((force / 35.15) as f32);
        log.before.push(states[1].0 as f32);
        log.after.push(states[2].0 as f32);
        if sample % 10 == 0 {
            let torque_noise = 1.6 * noise();
            log.torque_time.push(time as f32);
            log.torque_velocity.push(velocity as f32);
            log.torque_position.push(position as f32);
            log.torque_before
                .push((before(velocity) - truth(velocity) + torque_noise) as f32);
            log.torque_after
                .push((after(velocity) - truth(velocity) + torque_noise) as f32);
        }
        let laws: [&dyn Fn(f64) -> f64; 3] = [&truth, &before, &after];
        for (state, law) in states.iter_mut().zip(laws) {
            state.1 += STEP * (force - law(state.1)) / MASS;
            state.0 += STEP * state.1;
        }
    }
    log
}

pub fn errors(position_rms: f64, torque_rel: f64) -> ErrorSet {
    ErrorSet {
        window_s: 0.2,
        position_rms,
        position_max: 4.0 * position_rms,
        position_nrmse: 5.0 * position_rms,
        current_rms: Some(0.01 * torque_rel),
        torque_rel,
        free_run_rms: 25.0 * position_rms,
    }
}

pub fn estimate(name: &str, value: f64, std: f64, unit: &str) -> Estimate {
    Estimate {
        name: name.into(),
        value,
        std,
        unit: unit.into(),
    }
}

pub fn fitted(
    name: &str,
    declared: f64,
    value: f64,
    std: Option<f64>,
    unit: &str,
) -> FittedParameter {
    FittedParameter {
        name: name.into(),
        declared,
        fitted: value,
        std,
        unit: unit.into(),
        freed: false,
        tolerance: None,
        at_limit: false,
    }
}

pub fn refused(round: usize, id: &str, score: f64, reason: &str) -> Candidate {
    Candidate {
        round,
        id: id.into(),
        words: id.into(),
        score,
        identifiability: 0.347,
        held_out_ratio: None,
        p_value: None,
        accepted: false,
        reason: reason.into(),
    }
}

/// Two effects found on one training and one validation log.
pub fn example() -> Report {
    let outcome = Outcome {
        machine: "slide".into(),
        verdict: Verdict::EffectsFound,
        disagreement: Vec::new(),
        residual: Some(Residual {
            position_rms: 2e-6,
            floor: 1e-6,
            implausible: None,
            unconfirmed: false,
            short: None,
        }),
        effects: vec![
            FoundEffect {
                id: "asymmetric_viscous".into(),
                parameters: vec![
                    estimate("forward", 167.21, 1.13, "N·s/m"),
                    estimate("backward", 241.52, 1.28, "N·s/m"),
                ],
                declare: "{ id = \"asymmetric_viscous\", difference = -37.155 }".into(),
                score: 0.8712,
                identifiability: 0.6134,
                p_value: 1.04e-6,
                law: None,
                equivalent: vec!["offset_torque".into(), "spring".into()],
                neglected_inductance: None,
                presumes: vec![],
            },
            FoundEffect {
                id: "sensor_delay".into(),
                parameters: vec![estimate("delay", 5.04e-4, 2.1e-5, "s")],
                declare: "{ id = \"sensor_delay\", delay = 0.000504 }".into(),
                score: 0.2218,
                identifiability: 0.4821,
                p_value: 0.0042,
                law: None,
                equivalent: vec![],
                neglected_inductance: None,
                presumes: vec!["resistance".into(), "torque_constant".into()],
            },
        ],
        unknown: None,
        current_sensor: vec![],
        input_lead: None,
        fit: vec![
            fitted("inertia", 90.0, 95.204, Some(0.118), "kg"),
            fitted("viscous", 203.5, 204.36, None, "N·s/m"),
            fitted("coulomb", 20.4, 20.21, Some(0.134), "N"),
            fitted("inductance", 1.2e-4, 1.3156e-4, Some(2.4e-6), "H"),
        ],
        errors: Errors {
            train: Stages {
                declared: errors(3.412e-4, 0.0812),
                before: errors(2.908e-4, 0.0707),
                after: errors(5.21e-5, 0.0295),
            },
            validate: Some(Stages {
                declared: errors(3.601e-4, 0.0834),
                before: errors(3.079e-4, 0.0719),
                after: errors(1.062e-4, 0.0368),
            }),
        },
        between_logs: Vec::new(),
        free_run_costs: Vec::new(),
        next_experiment: None,
        machine_out: None,
        candidates: vec![
            Candidate {
                held_out_ratio: Some(0.153),
                p_value: Some(1.04e-6),
                accepted: true,
                ..refused(
                    1,
                    "asymmetric_viscous",
                    0.8712,
                    "mean square error 85 % lower on held-out blocks",
                )
            },
            Candidate {
                held_out_ratio: Some(0.942),
                p_value: Some(0.0213),
                ..refused(
                    1,
                    "quadratic_drag",
                    0.1934,
                    "held-out error only 5.8 % lower where 10 % is asked for, and p 0.021 where 0.0013 \
                     is, so what it gains on the blocks that it was fitted to does not carry over",
                )
            },
            refused(1, "stribeck", 0.1203, "not among the best three by score"),
            refused(1, "cogging", 0.0416, "not among the best three by score"),
            refused(1, "compliance", 0.0305, "not among the best three by score"),
            refused(1, "presliding", 0.0304, "not among the best three by score"),
            refused(1, "spring", 0.0203, "identifiability under 0.05"),
            refused(1, "gravity", 0.0102, "needs a rotary machine"),
            Candidate {
                held_out_ratio: Some(0.871),
                p_value: Some(0.0042),
                accepted: true,
                ..refused(2, "sensor_delay", 0.2218, "mean square error 13 % lower")
            },
        ],
        resampled: vec![],
        whiteness: Whiteness {
            ljung_box: 152.34,
            lags: 20,
            p_value: 0.0,
            correlations: Correlations {
                input: 0.12,
                velocity: -0.34,
                direction: 0.56,
                input_squared: -0.78,
            },
        },
        cost: Cost {
            seconds: 12.34,
            simulations: 1240,
            samples: 12_000,
        },
    };
    Report {
        outcome,
        coordinate: "m".into(),
        load_unit: "N".into(),
        demand: Demand {
            speed: 0.1,
            ..Demand::default()
        },
        declared: Vec::new(),
        free_motor: None,
        has_return_spring: false,
        has_page: false,
        without_inductance: None,
        held_within: Vec::new(),
        train: vec![slide("train.csv", 12_000)],
        validate: vec![slide("validate.csv", 9_000)],
    }
}

/// The report of this name among the variants.
pub fn variant(name: &str) -> Report {
    let found = variants().into_iter().find(|(known, _)| *known == name);
    found.expect(name).1
}

/// The reports that a user may meet beside the usual one.
pub fn variants() -> Vec<(&'static str, Report)> {
    let mut variants = vec![("usual", example())];

    let mut report = example();
    report.outcome.verdict = Verdict::NoMissingEffect;
    report.outcome.effects.clear();
    report.outcome.candidates.clear();
    report.outcome.errors.train.after = errors(2.908e-4, 0.0707);
    report.outcome.errors.validate.as_mut().unwrap().after = errors(3.079e-4, 0.0719);
    variants.push(("no effect", report));

    let mut report = example();
    report.outcome.verdict = Verdict::NoMissingEffect;
    report.outcome.effects.clear();
    report.outcome.fit[3].freed = true;
    variants.push(("wrong number", report));

    let mut report = example();
    report.outcome.verdict = Verdict::UnknownEffect;
    report.outcome.effects.clear();
    report.outcome.unknown = Some(Unknown {
        depends_on: "velocity".into(),
        score: 0.4063,
        map: LearnedLaw {
            over: "velocity".into(),
            acts_as: "friction".into(),
            at: vec![0.0, 0.05, 0.1, 0.15],
            at_unit: "m/s".into(),
            values: vec![1.25, -0.5, 0.0, 3.75],
            unit: "N".into(),
        },
    });
    variants.push(("unknown", report.clone()));

    let mut nothing_proven = report.clone();
    nothing_proven.outcome.verdict = Verdict::NothingProven;
    nothing_proven.outcome.unknown = None;
    nothing_proven
        .outcome
        .residual
        .as_mut()
        .unwrap()
        .position_rms = 4e-6;
    variants.push(("nothing proven", nothing_proven.clone()));

    let mut at_limit = nothing_proven.clone();
    let mut numbers = at_limit.outcome.fit.iter_mut();
    let viscous = numbers.find(|number| number.name == "viscous").unwrap();
    viscous.fitted = 27.0 * viscous.declared;
    (viscous.at_limit, viscous.std) = (true, Some(1.1));
    variants.push(("at limit", at_limit));

    let residual = nothing_proven.outcome.residual.as_mut().unwrap();
    residual.implausible = Some("viscous");
    variants.push(("implausible", nothing_proven));

    report.outcome.effects = example().outcome.effects;
    variants.push(("effects and unknown", report));

    let mut report = example();
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    validate.after.position_rms = 1.5 * validate.before.position_rms;
    variants.push(("does not hold", report));

    let mut report = example();
    report.outcome.errors.validate = None;
    report.validate.clear();
    variants.push(("no validation", report));

    let mut report = example();
    let validate = report.outcome.errors.validate.as_mut().unwrap();
    for stages in [&mut report.outcome.errors.train, validate] {
        for set in [&mut stages.declared, &mut stages.before, &mut stages.after] {
            set.current_rms = None;
        }
    }
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.current.clear();
    }
    variants.push(("no current", report));

    for samples in [0, 1, 3, 9, 120] {
        let mut report = example();
        report.train = vec![slide("tiny.csv", samples)];
        report.validate = vec![slide("tiny.csv", samples)];
        variants.push(("tiny", report));
    }

    let mut report = example();
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.window_starts.clear();
    }
    variants.push(("no windows", report));

    let mut report = example();
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.position.fill(0.25);
        log.before.fill(0.25);
        log.after.fill(0.25);
        log.torque_before.fill(0.0);
        log.torque_after.fill(0.0);
        log.torque_velocity.fill(0.0);
    }
    variants.push(("standstill", report));

    let mut report = example();
    report.outcome.errors.train.declared.free_run_rms = f64::INFINITY;
    report.outcome.effects[0].parameters[0].std = f64::NAN;
    for log in report.train.iter_mut().chain(&mut report.validate) {
        log.before[500..600].fill(f32::NAN);
        log.torque_before[50] = f32::INFINITY;
    }
    variants.push(("diverged", report));

    let mut report = example();
    report.train.push(slide("train-2.csv", 4_000));
    report.train.push(slide("train-3.csv", 2_000));
    variants.push(("more logs", report));
    variants
}
