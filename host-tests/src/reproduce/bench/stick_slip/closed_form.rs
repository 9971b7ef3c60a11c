//! The motion in closed form.

use std::f64::consts::PI;

use super::{Cycle, Example};

/// The motion exactly, at a belt speed v > 0, m/s.
///
/// With A₀ = (μs − μd) N/k and ω = √(k/M), and time from the breakaway, the slip is
/// x = μd N/k + A₀ cos ωt + (v/ω) sin ωt. It has the amplitude √(A₀² + (v/ω)²) and lasts until
/// ẋ = v, which is the paper's transcendental equation
/// v (cos ωT − 1) − A₀ ω sin ωT = 0: with half angles, tan(ωT/2) = −A₀ ω/v, so
/// T = (2/ω)(π − arctan(A₀ ω/v)), between π/ω for a slow belt and 2π/ω for a fast one. There
/// x = μd N/k − A₀ at every speed, and the next stick lasts 2 A₀/v exactly.
///
/// ```
/// use host_tests::reproduce::bench::stick_slip::{Example, closed_form::cycle};
///
/// let found = cycle(&Example::PAPER, 0.981);
/// // A₀ ω = v: the slip starts and ends an eighth of a turn off the turning points.
/// assert!((found.slip - 0.3 * std::f64::consts::PI).abs() < 1e-12);
/// assert!((found.stick - 0.4).abs() < 1e-12);
/// ```
pub fn cycle(example: &Example, belt_speed: f64) -> Cycle {
    cycle_with_band(example, belt_speed, 0.0)
}

/// The same with a velocity band ±`band` m/s, below the belt speed, in which friction is static, as
/// Karnopp's scheme has it.
///
/// From breakaway on the mass has to leave the band by what the spring pulls beyond the static
/// friction, k v t: that takes √(2 M band/(k v)), in which the spring is drawn further by as much as the
/// belt moves. The slip begins and ends at the speed v − band.
pub fn cycle_with_band(example: &Example, belt_speed: f64, band: f64) -> Cycle {
    let frequency = example.natural_frequency();
    let leaving = (2.0 * example.mass * band / (example.stiffness * belt_speed)).sqrt();
    let deflection = example.excess_deflection() + belt_speed * leaving;
    let speed = belt_speed - band;
    Cycle {
        amplitude: deflection.hypot(speed / frequency),
        stick: 2.0 * deflection / belt_speed,
        slip: 2.0 / frequency * (PI - (deflection * frequency / speed).atan()),
    }
}

/// Position of the mass at seconds after a breakaway, m from the unloaded spring, for one period.
pub fn position(example: &Example, belt_speed: f64, time: f64) -> f64 {
    let cycle = cycle(example, belt_speed);
    let frequency = example.natural_frequency();
    let (middle, deflection) = (middle(example), example.excess_deflection());
    if time <= cycle.slip {
        let (sine, cosine) = (frequency * time).sin_cos();
        middle + deflection * cosine + belt_speed / frequency * sine
    } else {
        middle - deflection + belt_speed * (time - cycle.slip)
    }
}

/// The slip as the paper prints it, with the time from the breakaway: without the term
/// (v/ω) sin ωt, so that it begins at rest and not at the belt's speed.
pub fn printed_slip(example: &Example, time: f64) -> f64 {
    let angle = example.natural_frequency() * time;
    middle(example) + example.excess_deflection() * angle.cos()
}

/// What the swing is about, m: the deflection under dynamic friction.
fn middle(example: &Example) -> f64 {
    example.dynamic_coefficient * example.normal_force() / example.stiffness
}
