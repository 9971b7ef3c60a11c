//! What a world's sensors make of the truth.

use std::collections::VecDeque;

use super::laws::Law;
use super::machine::{Machine, Side};
use super::plant::State;
use crate::random::Random;

/// Quality of the sensors of one world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Standard deviation of the position before it is rounded, in counts.
    pub position_noise: f64,
    /// Standard deviation of a measured current, A; `None` for a log without that column.
    pub current_noise: Option<f64>,
    /// The same of a velocity, rad/s or m/s.
    pub velocity_noise: Option<f64>,
    /// Time constant of a filter before the log, s; 0 for none. One of the sins of a logger.
    pub filter: f64,
}

/// The position sensor at work.
#[derive(Debug, Clone)]
pub(super) struct PositionSensor {
    side: Side,
    delay: f64,
    errors: Vec<Law>,
    resolution: f64,
    noise: f64,
    filter: f64,
    filtered: Option<(f64, f64)>,
    past: VecDeque<(f64, f64)>,
}

impl PositionSensor {
    pub fn new(machine: &Machine, laws: &[Law], quality: &Quality) -> Self {
        let delays = laws.iter().map(|law| match law {
            Law::SensorDelay { seconds } => *seconds,
            _ => 0.0,
        });
        let joint = laws.iter().find_map(Law::joint);
        Self {
            side: joint.map_or(Side::Load, |(joint, _)| joint.sensor),
            delay: delays.sum(),
            errors: laws
                .iter()
                .filter(|law| matches!(law, Law::EncoderEccentricity { .. }))
                .copied()
                .collect(),
            resolution: machine.resolution,
            noise: quality.position_noise,
            filter: quality.filter,
            filtered: None,
            past: VecDeque::new(),
        }
    }

    /// Longest time between two looks, s; infinite where none is needed.
    pub fn stride(&self, step: f64) -> f64 {
        if self.delay > 0.0 || self.filter > 0.0 {
            (4.0 * step).max(0.02 * self.delay.max(self.filter))
        } else {
            f64::INFINITY
        }
    }

    /// Sees where the machine is.
    pub fn see(&mut self, state: &State) {
        let place = match self.side {
            Side::Motor => state.motor_position(),
            Side::Load => state.load_position(),
        };
        let place = if self.filter > 0.0 {
            let (time, before) = self.filtered.unwrap_or((state.time, place));
            let left = (-(state.time - time) / self.filter).exp();
            let after = place + (before - place) * left;
            self.filtered = Some((state.time, after));
            after
        } else {
            place
        };
        self.past.push_back((state.time, place));
        while self.past.len() > 2 && self.past[1].0 <= state.time - self.delay {
            self.past.pop_front();
        }
    }

    /// What it reports now, having seen the machine at this time.
    pub fn report(&self, random: &mut Random) -> f64 {
        let Some(&(now, last)) = self.past.back() else {
            return 0.0;
        };
        let then = now - self.delay;
        let after = self.past.partition_point(|(time, _)| *time < then);
        let place = match (after.checked_sub(1), self.past.get(after)) {
            (Some(before), Some(&(later, behind))) => {
                let (earlier, ahead) = self.past[before];
                ahead + (behind - ahead) * (then - earlier) / (later - earlier)
            }
            (None, Some(&(_, first))) => first,
            _ => last,
        };
        let mut reading = place;
        for error in &self.errors {
            if let Law::EncoderEccentricity { amplitude, ripple } = error {
                reading += amplitude * ripple.at(place);
            }
        }
        if self.noise > 0.0 {
            reading += self.noise * self.resolution * random.normal();
        }
        (reading / self.resolution).round() * self.resolution
    }
}
