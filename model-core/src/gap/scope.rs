//! What a log and the declared model say about sensible sizes.

use super::log::Log;
use super::model::Model;
use super::replay::{Data, MARGIN};
use super::simulator::Simulator;
use crate::effect::Scope;
use crate::effect::learned_map::{KNOTS, Ranges};
use crate::plant::State;
use core::f32::consts::TAU;

/// Samples from one look at the log to the next; the motor torque is averaged over as many.
const STRIDE: usize = 10;

/// Samples on either side that the state is smoothed over: with seventeen positions a cubic passes
/// what is slower than about a tenth of the sampling rate.
const HALF_WIDTH: usize = 8;

/// Share of the largest speed below which the machine counts as at rest, which says nothing about
/// how fast it moves.
const REST: f32 = 0.02;

/// Share of the motor torque's rms that stands for the friction of a machine that declares none.
const FRICTION: f32 = 0.1;

/// Smallest size, so that nothing is divided by zero.
const LEAST: f32 = 1e-9;

/// Smoothed states of a log, each with the motor torque around it.
fn looks<'a>(
    log: &'a Log,
    simulator: &'a Simulator,
    torque_per_current: f32,
    resolution: f32,
) -> impl Iterator<Item = (State, f32)> + 'a {
    let last = log.samples().saturating_sub(MARGIN);
    (MARGIN..last).step_by(STRIDE).map(move |index| {
        let state = log.smoothed_state(index, HALF_WIDTH, resolution);
        let around = index - STRIDE / 2..index - STRIDE / 2 + STRIDE;
        let mean = match log.current {
            Some(current) => {
                let sum: f32 = around.map(|at| simulator.read(current, at)).sum();
                sum / STRIDE as f32
            }
            None if log.is_released(index) => 0.0,
            None => {
                let late = simulator.input_lateness();
                let sum: f32 = around.map(|at| late.read(log.input, at)).sum();
                simulator.steady_current(state.velocity.value(), sum / STRIDE as f32)
            }
        };
        (state, torque_per_current * mean)
    })
}

/// Parts that the range of the speed is divided into to find where the machine moves.
const PARTS: usize = 256;

/// Share of the moving time on either side of the range of velocities that a learned law's points are laid over: a
/// tenth of what each point has where the time is even. The peak of a collision or of a spring that is let go would
/// take the points from where the machine moves.
const TAIL: f32 = 0.1 / KNOTS as f32;

/// The part of a range in which the values lie but for a tail on either side.
fn without_tails((lowest, highest): (f32, f32), values: impl Iterator<Item = f32>) -> (f32, f32) {
    let part = (highest - lowest).max(LEAST) / PARTS as f32;
    let mut counts = [0u32; PARTS];
    for value in values {
        counts[(((value - lowest) / part) as usize).min(PARTS - 1)] += 1;
    }
    let tail = TAIL * counts.iter().sum::<u32>() as f32;
    let within = |counts: &mut dyn Iterator<Item = &u32>| {
        let mut sum = 0;
        let tails = counts.take_while(|&count| {
            sum += count;
            sum as f32 <= tail
        });
        tails.count() as f32
    };
    let (below, above) = (within(&mut counts.iter()), within(&mut counts.iter().rev()));
    (lowest + below * part, highest - above * part)
}

/// Smallest and largest value so far.
fn widen((lowest, highest): &mut (f32, f32), value: f32) {
    *lowest = lowest.min(value);
    *highest = highest.max(value);
}

/// Typical sizes and ranges over the logs, for the declared model. `rotary`: the coordinate is an
/// angle.
///
/// Motor torque is that of the measured current, or of the winding's steady state where none was
/// measured.
///
/// `None` if there is no log or the model cannot be built.
pub fn scope(data: &Data, model: &Model, rotary: bool) -> Option<(Scope, Ranges)> {
    let period = data.logs.first()?.period;
    let simulator = model.build(period).ok()?;
    let per_current = model.plant.torque_per_current();
    let resolution = data.settings.resolution;
    let all = || {
        data.logs
            .iter()
            .flat_map(|log| looks(log, &simulator, per_current, resolution))
    };
    let nothing = (f32::MAX, f32::MIN);
    let (mut position, mut velocity, mut motor_torque) = (nothing, nothing, nothing);
    let mut torque = MeanSquare::default();
    for (state, motor) in all() {
        widen(&mut position, state.position.value());
        widen(&mut velocity, state.velocity.value());
        widen(&mut motor_torque, motor);
        torque.add(motor);
    }
    let slowest = REST * velocity.1.max(-velocity.0);
    let moving = || {
        let velocities = all().map(|(state, _)| state.velocity.value());
        velocities.filter(|velocity| velocity.abs() > slowest)
    };
    let mut speed = MeanSquare::default();
    moving().for_each(|velocity| speed.add(velocity));
    let mut input = MeanSquare::default();
    for log in data.logs {
        for index in (0..log.samples()).step_by(STRIDE) {
            input.add(log.input.at(index));
        }
    }
    let longest = data.logs.iter().map(Log::samples).max()?;
    let ranges = Ranges {
        position,
        velocity: without_tails(velocity, moving()),
        motor_torque,
        time: (0.0, longest as f32 * period),
    };
    let coulomb = model.plant.coulomb.forward;
    let scope = Scope {
        friction: if coulomb > 0.0 {
            coulomb
        } else {
            FRICTION * torque.root()
        },
        torque: torque.root(),
        voltage: model.plant.gain.abs() * input.root(),
        current: torque.root() / per_current,
        speed: speed.root(),
        stroke: (position.1 - position.0).max(LEAST),
        period,
        seconds: (longest as f32 * period).max(LEAST),
        rotary,
        // A gear makes the motor's side turn faster: no sensor turns less than the coordinate does.
        encoder_turn: if rotary { TAU } else { f32::INFINITY },
    };
    Some((scope, ranges))
}

/// A mean of squares.
#[derive(Default)]
struct MeanSquare {
    sum: f64,
    count: u32,
}

impl MeanSquare {
    fn add(&mut self, value: f32) {
        self.sum += f64::from(value) * f64::from(value);
        self.count += 1;
    }

    fn root(&self) -> f32 {
        (libm::sqrt(self.sum / f64::from(self.count.max(1))) as f32).max(LEAST)
    }
}
