//! What a world's machine is asked to do.

use std::f64::consts::TAU;

use super::dice::{between, chance, log_between, pick, sign};
use super::machine::Machine;
use crate::random::Random;

/// A course of the position.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    /// A sum of sines: amplitude, angular frequency, phase.
    Sines(Vec<[f64; 3]>),
    /// To and fro at constant speed: amplitude and period.
    Triangle(f64, f64),
    /// A sine of this amplitude whose angular frequency rises from one to another over so many seconds,
    /// then begins again.
    Sweep(f64, [f64; 2], f64),
    /// From place to place: begin, duration and end of each move, at rest between. A move of no duration
    /// is a step.
    Moves(Vec<Move>),
}

/// One move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// s.
    pub begin: f64,
    /// s.
    pub duration: f64,
    /// Where it ends, beside the centre, rad or m.
    pub target: f64,
}

impl Motion {
    /// A motion for a log of `seconds`, within the machine's stroke.
    pub(super) fn draw(random: &mut Random, machine: &Machine, seconds: f64) -> Self {
        let (amplitude, cycle) = (machine.amplitude, machine.cycle);
        match pick(random, &[0, 0, 1, 2, 3, 4, 5, 5]) {
            0 => {
                let count = pick(random, &[2, 3, 4, 5]);
                let mut sines: Vec<[f64; 3]> = (0..count)
                    .map(|_| {
                        let ratio = log_between(random, 0.3, 2.0);
                        [
                            1.0 / ratio.max(0.5),
                            ratio * TAU / cycle,
                            between(random, 0.0, TAU),
                        ]
                    })
                    .collect();
                let speed: f64 = sines.iter().map(|[size, rate, _]| size * rate).sum();
                let stroke: f64 = sines.iter().map(|[size, ..]| size).sum();
                let share = (amplitude / stroke).min(1.1 * machine.speed() / speed);
                for sine in &mut sines {
                    sine[0] *= share;
                }
                Self::Sines(sines)
            }
            1 => Self::Triangle(amplitude, 1.6 * cycle * between(random, 0.9, 2.0)),
            2 => {
                let slow = TAU / cycle * log_between(random, 0.08, 0.4);
                let fast = TAU / cycle * between(random, 0.8, 1.2);
                let lasting = seconds * pick(random, &[1.0, 0.5, 0.34]);
                Self::Sweep(amplitude * between(random, 0.5, 1.0), [slow, fast], lasting)
            }
            3 => Self::Moves(steps(random, machine, seconds)),
            4 => Self::Moves(moves(random, machine, seconds, 1.2)),
            _ => Self::Moves(moves(random, machine, seconds, 0.25)),
        }
    }

    /// The commanded position at a time beside the centre, rad or m.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Sines(sines) => sines
                .iter()
                .map(|[size, rate, phase]| size * (rate * time + phase).sin())
                .sum(),
            Self::Triangle(amplitude, period) => {
                let phase = (time / period + 0.25).rem_euclid(1.0);
                amplitude * (1.0 - 4.0 * (phase - 0.5).abs())
            }
            Self::Sweep(amplitude, [slow, fast], lasting) => {
                let time = time.rem_euclid(*lasting);
                let angle = slow * time + 0.5 * (fast - slow) / lasting * time * time;
                amplitude * angle.sin()
            }
            Self::Moves(moves) => {
                let next = moves.partition_point(|it| it.begin <= time);
                let Some(current) = next.checked_sub(1).map(|place| moves[place]) else {
                    return 0.0;
                };
                let before = next.checked_sub(2).map_or(0.0, |place| moves[place].target);
                let share = if current.duration > 0.0 {
                    ((time - current.begin) / current.duration).min(1.0)
                } else {
                    1.0
                };
                // Third order: no jump of the speed.
                before + (current.target - before) * share * share * (3.0 - 2.0 * share)
            }
        }
    }
}

/// Steps of a part of the stroke.
fn steps(random: &mut Random, machine: &Machine, seconds: f64) -> Vec<Move> {
    let mut time = 0.0;
    let mut side = sign(random);
    let mut all = Vec::new();
    while time < seconds {
        side = if chance(random, 0.7) { -side } else { side };
        all.push(Move {
            begin: time,
            duration: 0.0,
            target: side * machine.amplitude * between(random, 0.1, 0.6),
        });
        time += machine.cycle * between(random, 0.4, 1.0);
    }
    all
}

/// Moves at a tenth to the whole of the speed, with rests of up to `rest` cycles.
fn moves(random: &mut Random, machine: &Machine, seconds: f64, rest: f64) -> Vec<Move> {
    let mut time = 0.0;
    let mut place = 0.0;
    let mut all = Vec::new();
    while time < seconds {
        let target = machine.amplitude * between(random, -1.0, 1.0);
        // A third-order move is one and a half times as fast in its middle as in the mean.
        let quickest = 1.5 * f64::abs(target - place) / machine.speed();
        let duration = quickest.max(0.2 * machine.cycle) * log_between(random, 1.0, 4.0);
        all.push(Move {
            begin: time,
            duration,
            target,
        });
        time += duration + rest * machine.cycle * random.uniform();
        place = target;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{Motion, Move};

    #[test]
    fn a_triangle_has_its_amplitude_and_one_speed() {
        let motion = Motion::Triangle(2.0, 4.0);
        for (time, place) in [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (3.0, -2.0), (3.5, -1.0)] {
            assert!((motion.at(time) - place).abs() < 1e-12, "{time}");
        }
    }

    #[test]
    fn a_move_arrives_and_rests() {
        let motion = Motion::Moves(vec![
            Move {
                begin: 0.0,
                duration: 1.0,
                target: 3.0,
            },
            Move {
                begin: 2.0,
                duration: 0.0,
                target: -1.0,
            },
        ]);
        for (time, place) in [(0.0, 0.0), (0.5, 1.5), (1.0, 3.0), (1.9, 3.0), (2.0, -1.0)] {
            assert!((motion.at(time) - place).abs() < 1e-12, "{time}");
        }
    }
}
