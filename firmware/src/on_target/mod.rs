//! Tests of the model core that run on the target and on the host alike.
//!
//! A [`Check`] calls functions of the core on many inputs and mixes the bits of all results into a
//! [digest](Findings::digest). Image and host run the same checks: equal digests are equal bits.
//! Where a closed form or a published number exists, the check *claims* it, on the target too.
//!
//! What would break the equality of bits, and so is nowhere in the core:
//!
//! * fused operations: a multiply-add rounds once where two instructions round twice;
//! * `std`'s float methods, which call the system's library: `libm` by its full name is one code;
//! * another version of `libm` for the target than for the host (`Cargo.lock` holds it), or its
//!   assembly for one of them where that is not correctly rounded: of what is used here, only
//!   square roots and roundings to whole numbers have any, and those are exact;
//! * `micromath` by method: in scope of `std` the same line is `std`'s; by its full name it is one
//!   code too;
//! * sums in another order: iterators and threads may not change it;
//! * the sign of a zero out of `f32::min` and `f32::max`, and the payload of a NaN: neither is
//!   specified, so neither may reach a result.
//!
//! `f64` is software on the target and hardware on the host. Both round `+ − × ÷` as IEEE 754 says,
//! so constructors and sums over windows may use it; it only costs time.

mod bench;
pub mod control;
mod ema;
mod findings;
pub mod log;
mod numeric;
mod piecewise_affine;
pub mod plant;
mod search;
mod throttle;

pub use findings::Findings;

/// One test.
pub struct Check {
    /// What is tested.
    pub name: &'static str,
    run: fn(&mut Findings),
}

impl Check {
    /// Runs it.
    pub fn run(&self) -> Findings {
        let mut findings = Findings::new();
        (self.run)(&mut findings);
        findings
    }
}

/// All tests.
pub const CHECKS: [Check; 24] = [
    check("square_root", numeric::square_root),
    check("transcendental", numeric::transcendental),
    check("rounding", numeric::rounding),
    check("sine", numeric::sine),
    check("sum", numeric::sum),
    check("random", numeric::random),
    check("matrix_exponential", numeric::matrix_exponential),
    check("cholesky", numeric::cholesky),
    check("statistics", numeric::statistics),
    check("tails", numeric::tails),
    check("wilcoxon", numeric::wilcoxon),
    check("signals", control::signals),
    check("pid", control::pid),
    check("plant_sliding", plant::sliding),
    check("plant_events", plant::events),
    check("piecewise_affine", piecewise_affine::steps),
    check("throttle_body", throttle::body),
    check("throttle_rise", throttle::rise),
    check("ema_servo", ema::servo),
    check("bench_averaged", bench::averaged),
    check("bench_switching", bench::switching),
    check("annealing", search::annealing),
    check("golden_section", search::golden_section),
    check("friction", search::friction),
];

const fn check(name: &'static str, run: fn(&mut Findings)) -> Check {
    Check { name, run }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_claim_holds_on_the_host() {
        for check in CHECKS {
            assert_eq!(check.run().broken(), None, "{}", check.name);
        }
    }

    #[test]
    fn names_are_told_apart() {
        for (index, check) in CHECKS.iter().enumerate() {
            assert!(CHECKS[..index].iter().all(|other| other.name != check.name));
        }
    }
}
