//! Dry friction: what it holds at rest, what it takes while sliding, and bristles that bend first.

use super::forces::{BRISTLE, CURRENT, Forces, MOTOR, Rates};
use super::laws::Law;
use super::plant::State;
use super::shapes::Along;

/// Where dry friction is asked for.
pub(super) struct At<'a> {
    pub values: &'a Rates,
    pub input: f64,
    pub time: f64,
}

/// A bell of height 1.
fn bell(x: f64) -> f64 {
    (-0.5 * x * x).exp()
}

impl Forces {
    /// Share of the machine's dry friction that acts on a mass.
    fn friction_share(&self, side: usize) -> f64 {
        match (self.joint, side) {
            (Some((joint, _)), 0) => 1.0 - joint.friction,
            (Some((joint, _)), _) => joint.friction,
            (None, _) => 1.0,
        }
    }

    /// Dry friction of the whole machine that opposes motion in a direction, at a speed. `resting` is what it
    /// begins with: the Coulomb level while sliding, the breakaway level at rest.
    fn dry(&self, resting: f64, direction: f64, side: usize, at: &At) -> f64 {
        let speed = at.values[2 * side + 1];
        let position = at.values[2 * side];
        let mut sum = resting;
        let mut factor = 1.0;
        for law in &self.laws {
            match *law {
                Law::Stribeck {
                    fall,
                    drop,
                    speed: scale,
                } => {
                    let level = self.machine.coulomb + drop * fall.left(speed / scale);
                    sum = sum.max(level);
                }
                Law::AsymmetricCoulomb { difference } => sum += difference * direction,
                Law::LoadDependentFriction { share, preload } => {
                    let load = self.motor(at.values[CURRENT], at.input).0;
                    sum += share * (load.hypot(preload) - preload);
                }
                Law::PositionDependentFriction { level, along } => match along {
                    Along::Added(ripple) => sum += level * ripple.at(position),
                    Along::Multiplied(ripple) => factor *= 1.0 + level * ripple.at(position),
                    Along::Slope { centre, reach } => sum += level * (position - centre) / reach,
                },
                Law::FrictionDrift { rate, .. } => factor *= (1.0 + rate * at.time).max(0.0),
                Law::RoughSpot {
                    torque,
                    centre,
                    width,
                } => sum += torque * bell((position - centre) / width),
                Law::SpeedBand {
                    torque,
                    centre,
                    width,
                } => sum += torque * bell((speed.abs() - centre) / width),
                Law::WarmUp { share, seconds } => {
                    factor *= 1.0 - share * (1.0 - (-at.time / seconds).exp());
                }
                _ => {}
            }
        }
        (factor * sum).max(0.0) * self.friction_share(side)
    }

    /// Friction of a mass in a direction while it slides.
    pub fn sliding(&self, side: usize, direction: f64, at: &At) -> f64 {
        self.dry(self.machine.coulomb, direction, side, at)
    }

    /// Load that a stuck mass holds in a direction.
    pub fn breakaway(&self, side: usize, state: &State, input: f64, direction: f64) -> f64 {
        let at = At {
            values: &state.values,
            input,
            time: state.time,
        };
        self.dry(self.machine.breakaway, direction, side, &at)
    }

    /// Force of the bristles, and how fast they bend.
    pub fn bristles(&self, at: &At) -> (f64, f64) {
        let Some((stiffness, damping, scale)) = self.bristles else {
            return (0.0, 0.0);
        };
        let velocity = at.values[MOTOR + 1];
        let bend = at.values[BRISTLE];
        let machine = &self.machine;
        let fall = (-(velocity / scale).powi(2)).exp();
        let level = machine.coulomb + (machine.breakaway - machine.coulomb) * fall;
        let level = self.dry(level, velocity.signum(), 0, at).max(1e-12);
        let bending = velocity - velocity.abs() * stiffness * bend / level;
        (stiffness * bend + damping * bending, bending)
    }
}
