//! The motion by the core's friction schemes.
//!
//! In the belt's frame: the core's velocity is that of the mass on the belt, so that it is the
//! friction about zero velocity that is tried out. The spring's other end then moves at −v; its force
//! −k (q + v t) is the core's spring −k q and a ramp −k v t at the input, taken in the middle of each
//! step and held over it.

use model_core::plant::actuator::Actuator;
use model_core::plant::borello::Borello;
use model_core::plant::euler::{Euler, FrictionRule};
use model_core::plant::karnopp::Karnopp;
use model_core::plant::parameters::Parameters;
use model_core::plant::{Compensated, Directional, Motion, State, euler};

use super::{Cycle, Example, closed_form};
use crate::failure::Failure;

/// Periods that a cycle is the mean of.
pub const CYCLES: usize = 3;

/// A friction scheme of the core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Scheme {
    /// Exact in a mode, split at events.
    Exact,
    /// A velocity band of so many m/s on either side, by Euler steps.
    Karnopp(f64),
    /// The zero crossing, by Euler steps.
    Borello,
}

/// The motion at the ends of the steps.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Seconds of a step.
    pub period: f64,
    /// Position of the mass, m from the unloaded spring.
    pub position: Vec<f64>,
    /// Whether it sticks.
    pub sticks: Vec<bool>,
}

/// What a step ends in: position on the belt, m, and whether the scheme sees rest.
type Stepped = Result<(f32, bool), Failure>;

/// From an unloaded spring on, until the closed form has slipped [`CYCLES`] times and stuck after each.
///
/// # Errors
/// A period or a band that the core does not take.
pub fn run(
    example: &Example,
    scheme: Scheme,
    belt_speed: f64,
    period: f64,
) -> Result<Run, Failure> {
    let expected = closed_form::cycle(example, belt_speed);
    // Half a slip more: the schemes may be late.
    let seconds = example.first_breakaway(belt_speed)
        + CYCLES as f64 * (expected.stick + expected.slip)
        + 0.5 * expected.slip;
    let mut step = stepper(example, scheme, period as f32)?;
    let mut run = Run {
        period,
        position: Vec::new(),
        sticks: Vec::new(),
    };
    let pull = example.stiffness * belt_speed;
    for tick in 0..(seconds / period).ceil() as u64 {
        let (position, sticks) = step((-pull * (tick as f64 + 0.5) * period) as f32)?;
        let end = (tick + 1) as f64 * period;
        run.position.push(f64::from(position) + belt_speed * end);
        run.sticks.push(sticks);
    }
    Ok(run)
}

fn stepper(
    example: &Example,
    scheme: Scheme,
    period: f32,
) -> Result<Box<dyn FnMut(f32) -> Stepped>, Failure> {
    let parameters = parameters(example);
    let refused = |error: &dyn std::fmt::Display| Failure::other(error.to_string());
    Ok(match scheme {
        Scheme::Exact => {
            let actuator = Actuator::build(&parameters, period).map_err(|it| refused(&it))?;
            let mut state = State::new(0.0, 0.0);
            Box::new(move |input| {
                actuator
                    .step(&mut state, input)
                    .map_err(|it| refused(&it))?;
                Ok((state.position.value(), state.motion == Motion::Rest))
            })
        }
        Scheme::Karnopp(band) => {
            let band = band as f32;
            let it = Karnopp::build(&parameters, period, band).map_err(|it| refused(&it))?;
            euler_stepper(it, move |velocity| velocity.abs() < band)
        }
        Scheme::Borello => {
            let it = Borello::build(&parameters, period).map_err(|it| refused(&it))?;
            euler_stepper(it, |velocity| velocity == 0.0)
        }
    })
}

/// Steps of a published scheme; velocity and position lose no increment, as neither would in the
/// `f64` of the publications.
fn euler_stepper<F: FrictionRule + 'static>(
    scheme: Euler<F>,
    sticks: impl Fn(f32) -> bool + 'static,
) -> Box<dyn FnMut(f32) -> Stepped> {
    let mut state: euler::State<Compensated> = euler::State {
        current: 0.0,
        velocity: Compensated::new(0.0),
        position: Compensated::new(0.0),
    };
    Box::new(move |input| {
        let stepped = scheme.step(&mut state, input);
        stepped.map_err(|error| Failure::other(error.to_string()))?;
        Ok((state.position.value(), sticks(state.velocity.value())))
    })
}

fn parameters(example: &Example) -> Parameters {
    let friction =
        |coefficient: f64| Directional::both((coefficient * example.normal_force()) as f32);
    Parameters {
        coulomb: friction(example.dynamic_coefficient),
        breakaway: friction(example.static_coefficient),
        spring: example.stiffness as f32,
        ..Parameters::free(example.mass as f32)
    }
}

impl Run {
    /// Means over its whole periods, from the first slip to the last; times to a step. `None` where it
    /// did not slip twice.
    pub fn cycle(&self) -> Option<Cycle> {
        let starts = |of: bool| -> Vec<usize> {
            let changes = self.sticks.windows(2).enumerate();
            let begun = changes.filter(|(_, pair)| pair[0] != pair[1] && pair[1] == of);
            begun.map(|(row, _)| row + 1).collect()
        };
        let (slips, sticks) = (starts(false), starts(true));
        let periods = slips.len().checked_sub(1).filter(|&count| count > 0)?;
        let slipping: usize = slips
            .iter()
            .zip(&sticks)
            .take(periods)
            .map(|(a, b)| b - a)
            .sum();
        let whole = slips[periods] - slips[0];
        let swing = &self.position[slips[0] - 1..slips[periods]];
        let mean = |rows: usize| rows as f64 * self.period / periods as f64;
        Some(Cycle {
            amplitude: 0.5 * super::super::errors::range(swing),
            slip: mean(slipping),
            stick: mean(whole - slipping),
        })
    }
}
