//! Numerics, and the functions of `libm` that the core uses. Constants go through `black_box`, or
//! the compiler may work the result out on the host.

use core::hint::black_box;

use model_core::numeric::cholesky::Cholesky;
use model_core::numeric::matrix_exponential::exponential;
use model_core::numeric::random::Random;
use model_core::numeric::statistics::{Moments, median};
use model_core::numeric::sum::Sum;
use model_core::numeric::triangle::{Triangle, entries};
use model_core::numeric::{chi_square, ljung_box, normal, sine, wilcoxon};

use super::Findings;
use crate::app::square_root::square_root as instruction;

/// Draws from every binade: any sign, any exponent, but no NaN and no infinity.
fn any_single(random: &mut Random) -> f32 {
    loop {
        let value = f32::from_bits(random.bits());
        if value.is_finite() {
            return value;
        }
    }
}

/// Between ±`limit`.
fn between(random: &mut Random, limit: f32) -> f32 {
    limit * (2.0 * random.uniform() - 1.0)
}

pub(super) fn square_root(findings: &mut Findings) {
    let mut random = Random::new(1, 1);
    for _ in 0..5000 {
        let value = any_single(&mut random).abs();
        let root = libm::sqrtf(value);
        findings.single(root);
        findings.double(libm::sqrt(f64::from(value)));
        // Correctly rounded: the exact root lies between the middles to its neighbours, whose squares
        // f64 holds.
        let below = 0.5 * (f64::from(root) + f64::from(root.next_down()));
        let above = 0.5 * (f64::from(root) + f64::from(root.next_up()));
        let nearest = below * below <= f64::from(value) && above * above >= f64::from(value);
        findings.claim(nearest, "a root is the nearest");
        findings.claim(
            instruction(value).to_bits() == root.to_bits(),
            "the instruction has the bits of libm",
        );
    }
    for whole in 0..4096_u16 {
        let root = f32::from(whole);
        findings.claim(libm::sqrtf(root * root) == root, "a square has its root");
    }
}

pub(super) fn transcendental(findings: &mut Findings) {
    let mut random = Random::new(2, 1);
    for _ in 0..2000 {
        let (x, y) = (between(&mut random, 80.0), between(&mut random, 80.0));
        for value in [
            libm::expf(x),
            libm::logf(x.abs()),
            libm::atan2f(y, x),
            libm::hypotf(x, y),
            micromath::F32Ext::exp(x),
        ] {
            findings.single(value);
        }
    }
    for _ in 0..300 {
        let x = f64::from(between(&mut random, 30.0));
        for value in [
            libm::exp(x),
            libm::log(x.abs()),
            libm::erfc(0.1 * x),
            libm::lgamma(x.abs()),
        ] {
            findings.double(value);
        }
    }
    findings.claim(libm::expf(black_box(0.0)) == 1.0, "e⁰ = 1");
    findings.claim(libm::logf(black_box(1.0)) == 0.0, "ln 1 = 0");
    findings.claim(
        libm::hypotf(black_box(3.0), black_box(4.0)) == 5.0,
        "3² + 4² = 5²",
    );
    findings.claim(libm::erfc(black_box(0.0)) == 1.0, "erfc 0 = 1");
}

pub(super) fn rounding(findings: &mut Findings) {
    let mut random = Random::new(3, 1);
    for _ in 0..2000 {
        let value = between(&mut random, 1e5);
        findings.single(libm::floorf(value));
        findings.single(libm::rintf(value));
        findings.double(libm::floor(f64::from(value) * 1e-3));
        findings.double(libm::rint(f64::from(value) * 1e-3));
        findings.word(value as i32 as u32);
        findings.single(random.bits() as f32);
        findings.single((f64::from(value) * 1.1) as f32);
    }
    let ties = black_box([0.5, 1.5, 2.5, -0.5]).map(libm::rintf) == [0.0, 2.0, 2.0, -0.0];
    findings.claim(ties, "a tie rounds to even");
    findings.claim(
        libm::floorf(black_box(-0.5)) == -1.0,
        "floor goes downwards",
    );
    let casts = black_box([3e9_f32, f32::NAN]).map(|value| value as i32);
    findings.claim(casts == [i32::MAX, 0], "casts saturate");
}

pub(super) fn sine(findings: &mut Findings) {
    let mut random = Random::new(4, 1);
    for _ in 0..5000 {
        findings.single(sine::sine_cycles(between(&mut random, 1e3)));
        let phase = random.bits();
        findings.single(sine::sine_phase(phase));
        findings.single(sine::triangle_phase(phase));
    }
    let quarters =
        black_box([0.0, 0.25, 0.5, 0.75]).map(sine::sine_cycles) == [0.0, 1.0, 0.0, -1.0];
    findings.claim(quarters, "the sine of each quarter cycle");
    let twelfth = sine::sine_cycles(black_box(1.0 / 12.0));
    findings.claim((twelfth - 0.5).abs() < 1.8e-7, "sin 30° = 1/2");
}

pub(super) fn sum(findings: &mut Findings) {
    let mut random = Random::new(5, 1);
    let mut sum = Sum::default();
    for _ in 0..20_000 {
        sum.add(between(&mut random, 1e3));
        findings.single(sum.value());
    }
    let mut tenths = Sum::default();
    tenths.extend(core::iter::repeat_n(black_box(0.1), 100_000));
    // A tenth as f32 is 0.1 + 1.49e-9.
    findings.claim(tenths.value() == 10_000.0, "a hundred thousand tenths");
}

pub(super) fn random(findings: &mut Findings) {
    let mut published = Random::new(42, 54);
    // O'Neill's `pcg32-demo`, round 1.
    for expected in [0xa15c_02b7, 0x7b47_f409, 0xba1d_3330, 0x83d2_f293] {
        findings.claim(published.bits() == expected, "the published sequence");
    }
    let mut random = Random::new(6, 1);
    for _ in 0..5000 {
        findings.single(random.uniform());
        findings.single(random.normal());
    }
}

pub(super) fn matrix_exponential(findings: &mut Findings) {
    let mut random = Random::new(7, 1);
    for _ in 0..20 {
        let matrix: [[f64; 4]; 4] = core::array::from_fn(|_| {
            core::array::from_fn(|_| f64::from(between(&mut random, 5.0)))
        });
        for entry in exponential(&matrix).as_flattened() {
            findings.double(*entry);
        }
    }
    let shear = exponential(&black_box([[0.0, 1.0], [0.0, 0.0]])) == [[1.0, 1.0], [0.0, 1.0]];
    findings.claim(shear, "a nilpotent matrix");
    let rotation = exponential(&black_box([[0.0, -1.0], [1.0, 0.0]]));
    let error = rotation[0][0] - 0.540_302_305_868_139_8;
    findings.claim(error.abs() < 1e-14, "a rotation by 1 rad");
}

pub(super) fn cholesky(findings: &mut Findings) {
    const ORDER: usize = 6;
    let mut random = Random::new(8, 1);
    for _ in 0..20 {
        // A Gram matrix is positive definite.
        let rows: [[f64; ORDER]; 2 * ORDER] = core::array::from_fn(|_| {
            core::array::from_fn(|_| f64::from(between(&mut random, 1.0)))
        });
        let mut matrix = Triangle::<f64, { entries(ORDER) }>::default();
        let mut right = [0.0; ORDER];
        for row in 0..ORDER {
            for column in 0..=row {
                let mut product = 0.0;
                for values in &rows {
                    product += values[row] * values[column];
                }
                matrix.row_mut(row)[column] = product;
            }
        }
        // The right-hand side of a solution of ones.
        for (row, right) in right.iter_mut().enumerate() {
            *right = (0..ORDER).fold(0.0, |sum, column| sum + matrix.at(row, column));
        }
        Cholesky::new(matrix, ORDER).solve(&mut right);
        for solution in right {
            findings.double(solution);
            findings.claim((solution - 1.0).abs() < 1e-9, "the solution is known");
        }
    }
}

pub(super) fn statistics(findings: &mut Findings) {
    let mut random = Random::new(9, 1);
    let mut samples: [f32; 501] = core::array::from_fn(|_| 10.0 + random.normal());
    let mut moments = Moments::default();
    for &sample in &samples {
        moments.push(sample);
    }
    for value in [moments.mean(), moments.variance(), median(&mut samples)] {
        findings.single(value.unwrap_or(-1.0));
    }
    let mut line = Moments::default();
    for sample in [1004.0, 1007.0, 1013.0, 1016.0] {
        line.push(sample);
    }
    findings.claim(
        line.variance() == Some(30.0),
        "the variance of four numbers",
    );
}

pub(super) fn tails(findings: &mut Findings) {
    for tenth in -80..=80 {
        findings.double(normal::upper_tail(0.1 * f64::from(tenth)));
    }
    for degrees in 1..=40 {
        findings.double(chi_square::upper_tail(1.3 * f64::from(degrees), degrees));
    }
    let box_test = ljung_box::ljung_box(&[0.2, -0.1, 0.05, 0.15, -0.02], 100, 0);
    if let Some(test) = findings.sound(box_test, "autocorrelations are taken") {
        findings.double(test.statistic);
        findings.double(test.p_value);
        // SciPy's chi2.sf.
        findings.claim((test.p_value - 0.164_209_0).abs() < 1e-6, "Ljung and Box");
    }
    let ratio = normal::upper_tail(black_box(4.0)) / 3.167_124_183_311_986e-5;
    findings.claim((ratio - 1.0).abs() < 1e-13, "four standard deviations");
}

pub(super) fn wilcoxon(findings: &mut Findings) {
    let mut random = Random::new(10, 1);
    for count in [3, 10, 25, 26, 60] {
        let mut differences: [f32; 60] = core::array::from_fn(|_| 0.3 + random.normal());
        let test = wilcoxon::signed_rank(&mut differences[..count]);
        if let Some(test) = findings.sound(test, "differences are taken") {
            findings.double(test.statistic);
            findings.double(test.p_value);
        }
    }
    let five = wilcoxon::signed_rank(&mut [0.3, 0.1, 0.7, 0.2, 0.4]);
    let one_of_32 = five.is_ok_and(|test| test.p_value == 1.0 / 32.0);
    findings.claim(one_of_32, "five of five are positive");
}
