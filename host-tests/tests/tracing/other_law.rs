//! A mechanism whose law is not quite the catalogue's: gear teeth whose torque over one tooth is no sine. What the sine
//! leaves repeats twice and three times a tooth and reads like a second effect, an encoder that is not centred; it is none.

use std::f64::consts::PI;

use host_tests::gap::engine;
use host_tests::log::Log;

use crate::stepped::{Stepped, torque_driven};

/// The machine that it is, in steps of 0.5 ms.
const TOOTHED: Stepped<4> = Stepped {
    inertia: 3.4e-3,
    viscous: 1.42e-2,
    coulomb: 1.4e-3,
    breakaway: 1.6e-3,
    count: 6.0e-6,
    period: 0.02,
    steps: 40,
    rows: 5000,
    frequencies: [0.15, 0.37, 0.81, 1.43],
    amplitudes: [0.3, 0.2, 0.1, 0.05],
    gains: [0.5, 0.6, 0.02],
    limit: 0.126,
};

/// Teeth a turn, and amplitude of the torque's first harmonic, N·m.
const TEETH: f64 = 9.0;
const AMPLITUDE: f64 = 8.4e-3;

/// `harmonics`: amplitudes of the second and the third one, as shares of the first; `spring`: N·m/rad.
fn log(harmonics: [f64; 2], spring: f64, phases: [f64; 4]) -> Log {
    let [second, third] = harmonics;
    TOOTHED.log_of_position("teeth.csv", phases, |acting, position, _| {
        let tooth = TEETH * position;
        let law = tooth.sin() + second * (2.0 * tooth + 0.9).sin() + third * (3.0 * tooth).sin();
        acting - AMPLITUDE * law - spring * position
    })
}

/// Names of what is found, in alphabetical order, and the periods among their numbers.
fn found(harmonics: [f64; 2], spring: f64) -> (Vec<String>, Vec<f64>) {
    let fit = ["inertia", "viscous", "coulomb", "static"];
    let machine = torque_driven([4.5e-3, 1.1e-2], [1.0e-3, 2.0e-3], TOOTHED.count, &fit);
    let train = log(harmonics, spring, [0.3, 1.9, 4.0, 5.5]);
    let other = log(harmonics, spring, [2.2, 0.4, 5.1, 1.0]);
    let outcome = engine::run(&machine, &[train], || Ok(vec![other]), |_| ())
        .unwrap()
        .outcome;
    let mut names: Vec<String> = outcome.effects.iter().map(|it| it.id.clone()).collect();
    names.sort();
    let numbers = outcome.effects.iter().flat_map(|it| &it.parameters);
    let periods = numbers.filter(|it| it.name == "period");
    (names, periods.map(|it| it.value).collect())
}

#[test]
fn overtones_of_a_cogging_are_no_second_effect() {
    for harmonics in [[0.24, 0.09], [0.35, 0.0], [0.5, 0.2]] {
        let (names, periods) = found(harmonics, 0.0);
        assert_eq!(names, ["cogging"], "{harmonics:?}");
        let tooth = 2.0 * PI / TEETH;
        assert!((periods[0] / tooth - 1.0).abs() < 0.01, "{periods:?}");
    }
}

#[test]
fn a_spring_beside_them_is() {
    let (names, _) = found([0.24, 0.09], 0.02);
    // Over 0.6 rad either way a load that hangs pulls all but as a spring does.
    let [cogging, returning] = &names[..] else {
        panic!("{names:?}");
    };
    assert_eq!(cogging, "cogging");
    assert!(["gravity", "spring"].contains(&&**returning), "{names:?}");
}
