//! Where the machine is asked to go; also the shape of a prescribed input.

use crate::machine::Machine;
use std::f64::consts::{PI, TAU};

/// One component of [`Trajectory::Sines`]: amplitude · sin(2π frequency t + phase).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sine {
    /// In the trajectory's unit.
    pub amplitude: f64,
    /// Hz.
    pub frequency: f64,
    /// rad.
    pub phase: f64,
}

/// One move of [`Trajectory::Moves`]: trapezoidal velocity, then a rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Where it ends.
    pub target: f64,
    /// Top speed, positive.
    pub speed: f64,
    /// Acceleration and deceleration, positive.
    pub acceleration: f64,
    /// Rest after it, s.
    pub dwell: f64,
}

/// A function of time.
#[derive(Debug, Clone, PartialEq)]
pub enum Trajectory {
    /// One value for ever.
    Constant(f64),
    /// A centre and a sum of sines.
    Sines {
        /// Mean.
        centre: f64,
        /// The components.
        components: Vec<Sine>,
    },
    /// Moves with rests between them, repeated from the first when the last is over.
    Moves {
        /// Where the first move starts.
        start: f64,
        /// The moves.
        moves: Vec<Move>,
    },
    /// Constant speed to and fro, upward first.
    Triangle {
        /// Mean, and the value at time 0.
        centre: f64,
        /// Half the range.
        amplitude: f64,
        /// s.
        period: f64,
    },
    /// A sine whose frequency rises linearly; its amplitude falls as soon as its speed would
    /// exceed `speed`.
    Sweep {
        /// Mean.
        centre: f64,
        /// Largest amplitude.
        amplitude: f64,
        /// Frequency at time 0, Hz.
        from: f64,
        /// Frequency after `seconds`, Hz.
        to: f64,
        /// s.
        seconds: f64,
        /// Largest speed; infinite for a sweep of constant amplitude.
        speed: f64,
    },
    /// Values from elsewhere, each held until the next; the last one for ever, 0 if there is none.
    Sampled {
        /// Values a second, Hz.
        rate: f64,
        /// The values.
        values: Vec<f64>,
    },
}

impl Trajectory {
    /// Three incommensurate sines that together fill the machine's stroke and reach its speed.
    pub fn sines(machine: &Machine) -> Self {
        const SHARES: [(f64, f64, f64); 3] = [(0.7, 1.0, 0.0), (0.2, 2.7, 1.1), (0.1, 6.1, 2.3)];
        let amplitude = machine.amplitude();
        let rate: f64 = SHARES.iter().map(|(share, ratio, _)| share * ratio).sum();
        let base = machine.speed / (TAU * amplitude * rate);
        Self::Sines {
            centre: machine.centre(),
            components: SHARES
                .map(|(share, ratio, phase)| Sine {
                    amplitude: share * amplitude,
                    frequency: ratio * base,
                    phase,
                })
                .to_vec(),
        }
    }

    /// Smoothed steps of many lengths and speeds with rests, both ways over the whole stroke.
    pub fn moves(machine: &Machine) -> Self {
        // Target in half strokes from the centre, speed in shares of the machine's.
        const PLAN: [(f64, f64); 10] = [
            (0.5, 0.7),
            (-0.3, 1.0),
            (0.1, 0.25),
            (1.0, 0.5),
            (0.8, 0.15),
            (-1.0, 1.0),
            (-0.6, 0.4),
            (-0.8, 0.2),
            (0.9, 0.8),
            (0.0, 0.6),
        ];
        Self::Moves {
            start: machine.centre(),
            moves: PLAN
                .map(|(target, share)| Move {
                    target: machine.centre() + target * machine.amplitude(),
                    speed: share * machine.speed,
                    acceleration: machine.speed / 0.1,
                    dwell: 0.15,
                })
                .to_vec(),
        }
    }

    /// To and fro over the whole stroke at half the machine's speed.
    pub fn triangle(machine: &Machine) -> Self {
        Self::Triangle {
            centre: machine.centre(),
            amplitude: machine.amplitude(),
            period: 4.0 * machine.amplitude() / (0.5 * machine.speed),
        }
    }

    /// A sweep over `seconds`, from slow over the whole stroke to fast and short.
    pub fn sweep(machine: &Machine, seconds: f64) -> Self {
        // Where the whole stroke takes the whole speed.
        let corner = machine.speed / (TAU * machine.amplitude());
        Self::Sweep {
            centre: machine.centre(),
            amplitude: machine.amplitude(),
            from: 0.2 * corner,
            to: 4.0 * corner,
            seconds,
            speed: machine.speed,
        }
    }

    /// The four ready-made trajectories over `seconds`.
    pub fn all(machine: &Machine, seconds: f64) -> [Self; 4] {
        [
            Self::sines(machine),
            Self::moves(machine),
            Self::triangle(machine),
            Self::sweep(machine, seconds),
        ]
    }

    /// Value at `time` seconds from the start, `time` ≥ 0.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Sines { centre, components } => components
                .iter()
                .map(|c| c.amplitude * (TAU * c.frequency * time + c.phase).sin())
                .fold(*centre, |sum, value| sum + value),
            Self::Moves { start, moves } => along(*start, moves, time),
            Self::Triangle {
                centre,
                amplitude,
                period,
            } => {
                let phase = (time / period + 0.25).rem_euclid(1.0);
                centre + amplitude * (1.0 - 4.0 * (phase - 0.5).abs())
            }
            Self::Sweep {
                centre,
                amplitude,
                from,
                to,
                seconds,
                speed,
            } => {
                let slope = (to - from) / seconds;
                let frequency = from + slope * time;
                let phase = TAU * from * time + PI * slope * time * time;
                centre + amplitude.min(speed / (TAU * frequency)) * phase.sin()
            }
            Self::Sampled { rate, values } => {
                // A hair early, so that a rounded time does not fall behind its value.
                let index = (time * rate + 1e-6).floor() as usize;
                let last = values.len().saturating_sub(1);
                values.get(index.min(last)).copied().unwrap_or(0.0)
            }
        }
    }
}

/// Position after `time` seconds of `moves`, repeated.
fn along(start: f64, moves: &[Move], mut time: f64) -> f64 {
    if moves.is_empty() {
        return start;
    }
    let mut from = start;
    for step in moves.iter().cycle() {
        let distance = (step.target - from).abs();
        // A short move never reaches its top speed: its velocity is a triangle.
        let speed = step.speed.min((distance * step.acceleration).sqrt());
        let ramp = speed / step.acceleration;
        let cruise = if speed > 0.0 {
            distance / speed - ramp
        } else {
            0.0
        };
        let moving = 2.0 * ramp + cruise;
        if time < moving {
            let done = if time < ramp {
                0.5 * step.acceleration * time * time
            } else if time < ramp + cruise {
                speed * (time - 0.5 * ramp)
            } else {
                distance - 0.5 * step.acceleration * (moving - time).powi(2)
            };
            return from + done * (step.target - from).signum();
        }
        time -= moving;
        from = step.target;
        if time < step.dwell {
            return from;
        }
        time -= step.dwell;
    }
    unreachable!("a cycle over moves that are not empty has no end")
}

#[cfg(test)]
mod tests {
    use super::{Move, Trajectory};
    use crate::machine::Machine;

    #[test]
    fn moves_are_trapezoids_of_velocity() {
        let trajectory = Trajectory::Moves {
            start: 1.0,
            moves: vec![Move {
                target: 4.0,
                speed: 2.0,
                acceleration: 4.0,
                dwell: 1.0,
            }],
        };
        // Ramps of 0.5 s over 0.5 each, 1 s of cruise over 2.
        for (time, position) in [
            (0.0, 1.0),
            (0.5, 1.5),
            (1.0, 2.5),
            (1.5, 3.5),
            (2.0, 4.0),
            (2.9, 4.0),
        ] {
            assert!((trajectory.at(time) - position).abs() < 1e-12, "{time}");
        }
    }

    #[test]
    fn a_short_move_stays_below_its_top_speed() {
        let trajectory = Trajectory::Moves {
            start: 0.0,
            moves: vec![Move {
                target: -1.0,
                speed: 100.0,
                acceleration: 4.0,
                dwell: 9.0,
            }],
        };
        // Half the way after √(d/a) = 0.5 s, all of it after 1 s.
        assert!((trajectory.at(0.5) + 0.5).abs() < 1e-12);
        assert!((trajectory.at(1.0) + 1.0).abs() < 1e-12);
    }

    #[test]
    fn ready_made_trajectories_use_the_stroke_and_the_speed_but_no_more() {
        for machine in [
            Machine::rotary_ema(),
            Machine::force_slide(),
            Machine::throttle(),
        ] {
            for trajectory in Trajectory::all(&machine, 10.0) {
                let dt = 1e-3;
                let values: Vec<f64> = (0..10_000)
                    .map(|k| trajectory.at(f64::from(k) * dt))
                    .collect();
                let low = values.iter().copied().fold(f64::INFINITY, f64::min);
                let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                let span = machine.stroke.1 - machine.stroke.0;
                assert!(low >= machine.stroke.0 - 1e-9 && high <= machine.stroke.1 + 1e-9);
                assert!(high - low > 0.7 * span, "{}: {trajectory:?}", machine.name);
                let speeds: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]) / dt).collect();
                let top = speeds.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                // The falling amplitude of a sweep adds a little to its speed.
                assert!(top < 1.1 * machine.speed, "{trajectory:?} {top}");
                assert!(top > 0.45 * machine.speed, "{trajectory:?} {top}");
            }
        }
    }
}
