//! The balance of torques, or of voltages, as the log alone has it: how much of it follows the
//! acceleration, the velocity, the direction …, whatever the machine file says.

use super::channels::{Channels, quantum};
use super::limits::{AVERAGES, BOTH_WAYS, HEARD, LEAST_ROWS, MOST_NOISE, MOST_ROWS, SLOW};
use super::regression::{mean_square, regress};
use crate::gap::metrics::differentiate;
use crate::gap::zero_phase::{BUTTERWORTH, filter};
use crate::machine::{Coordinate, Machine};

/// What a share of the balance follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Follows {
    /// Acceleration.
    Acceleration,
    /// Velocity.
    Velocity,
    /// Direction of motion.
    Direction,
    /// Direction of motion, with nothing else that takes work.
    Losses,
    /// Nothing: it is constant.
    Constant,
    /// Position from the spring's rest.
    Position,
    /// Side of the spring's rest.
    Side,
    /// Sine of the angle from where the load hangs.
    Sine,
    /// Its cosine.
    Cosine,
    /// Motor current.
    Current,
    /// Its rate.
    CurrentRate,
    /// Position that was asked for.
    Command,
}

/// One coefficient of a balance.
#[derive(Debug, Clone, Copy)]
pub struct Share {
    /// What it multiplies.
    pub follows: Follows,
    /// The least and the most that it may be: noise of what it multiplies makes the first too small in
    /// size, noise of the sum the second too large.
    pub interval: (f64, f64),
    /// Effective value of what it multiplies.
    pub rms: f64,
}

/// One balance: what is balanced, and the coefficients.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Effective value of what is balanced.
    pub rms: f64,
    /// Its coefficients, each from the bands that show it well.
    pub shares: Vec<Share>,
    /// Share of its square that nothing of it explains, in the band that is explained best.
    pub unexplained: f64,
}

/// The balances of a log.
#[derive(Debug, Clone)]
pub struct Balances {
    /// Input, or current where a motor's was measured, over the motion.
    pub motion: Balance,
    /// Input voltage over current and velocity.
    pub winding: Option<Balance>,
    /// Measured velocity over that of the position.
    pub velocity: Option<Balance>,
    /// Position over the command.
    pub command: Option<Balance>,
    /// Mean measured current of the samples in which input and speed drive the motor forward, and of those in which they drive it
    /// backward, A: where there are enough of both.
    pub drawn: Option<[f64; 2]>,
}

/// One band of one log, filtered.
struct Band {
    input: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    current: Vec<f64>,
    current_rate: Vec<f64>,
    measured: Vec<f64>,
    command: Vec<f64>,
    brake: Vec<f64>,
    load: Vec<f64>,
    /// Samples that are left out at either end and between.
    skip: Vec<bool>,
}

/// A matrix with what it is to add up to.
pub(super) struct Rows {
    pub follows: Vec<Follows>,
    pub columns: Vec<Vec<f64>>,
    pub sum: Vec<f64>,
}

impl Balances {
    /// Share of the balances of torque and voltage that nothing explains, their mean.
    pub fn unexplained(&self) -> f64 {
        let motion = self.motion.unexplained;
        let winding = self.winding.as_ref();
        winding.map_or(motion, |winding| 0.5 * (motion + winding.unexplained))
    }

    /// Of all logs together.
    pub fn of(logs: &[Channels], machine: &Machine) -> Self {
        let has_motor = machine.motor.is_some();
        let with_current = has_motor && logs.iter().all(|log| log.current.is_some());
        let quantum = quantum(logs);
        let bands: Vec<(Vec<Band>, bool)> = AVERAGES
            .iter()
            .map(|&average| {
                let bands: Vec<Band> = logs.iter().map(|log| band(log, average)).collect();
                let trusted = bands.iter().zip(logs).all(|(band, log)| {
                    acceleration_noise(log, average, quantum)
                        <= MOST_NOISE * mean_square(&band.acceleration)
                });
                (bands, trusted)
            })
            .collect();
        let best = |rows: &dyn Fn(&[Band]) -> Option<Rows>, needs: &[Follows]| {
            let mut balance = Balance::default();
            let mut clearest: Vec<f64> = Vec::new();
            for (bands, trusted) in &bands {
                if let Some(rows) = rows(bands) {
                    balance.merge(&rows, *trusted, needs, &mut clearest);
                }
            }
            balance
        };
        let mut motion = best(
            &|bands| Some(motion_rows(bands, machine, with_current)),
            &[Follows::Acceleration],
        );
        let losses = best(
            &|bands| motion_rows(bands, machine, with_current).of_losses(),
            &[],
        );
        motion.shares.extend(losses.share(Follows::Losses).copied());
        let winding = with_current.then(|| best(&|bands| Some(winding_rows(bands, machine)), &[]));
        let has = |there: fn(&Channels) -> bool| logs.iter().all(there);
        let velocity = has(|log| log.velocity.is_some()).then(|| {
            let rows = |bands: &[Band]| {
                Some(pair(bands, Follows::Velocity, |b| {
                    (&b.velocity, &b.measured)
                }))
            };
            best(&rows, &[])
        });
        let command = has(|log| log.command.is_some()).then(|| {
            let rows =
                |bands: &[Band]| Some(pair(bands, Follows::Command, |b| (&b.command, &b.position)));
            best(&rows, &[])
        });
        let drawn = bands.iter().find_map(|(bands, _)| {
            let motor = machine.motor.as_ref().filter(|_| with_current)?;
            drawn(
                bands,
                machine.gain,
                [motor.resistance, motor.torque_constant],
            )
        });
        Self {
            motion,
            winding,
            velocity,
            command,
            drawn,
        }
    }
}

impl Default for Balance {
    /// One of which nothing is known.
    fn default() -> Self {
        Self {
            rms: 0.0,
            shares: Vec::new(),
            unexplained: 1.0,
        }
    }
}

impl Balance {
    /// The share that follows something.
    pub fn share(&self, follows: Follows) -> Option<&Share> {
        self.shares.iter().find(|share| share.follows == follows)
    }

    /// Takes from a band the coefficients that it shows more clearly. Where the band is not to be trusted
    /// with them, those in `needs` are left out.
    fn merge(&mut self, rows: &Rows, trusted: bool, needs: &[Follows], clearest: &mut Vec<f64>) {
        let Some((fits, unexplained)) = regress(rows) else {
            return;
        };
        self.unexplained = self.unexplained.min(unexplained);
        let rms = mean_square(&rows.sum).sqrt();
        if self.rms == 0.0 {
            self.rms = rms;
        }
        for (share, clarity) in fits {
            if !trusted && needs.contains(&share.follows) {
                continue;
            }
            let known = self
                .shares
                .iter()
                .position(|known| known.follows == share.follows);
            match known {
                Some(place) => {
                    let (old, best) = (self.shares[place], clearest[place]);
                    let both = Share {
                        interval: (
                            old.interval.0.min(share.interval.0),
                            old.interval.1.max(share.interval.1),
                        ),
                        ..if clarity > best { share } else { old }
                    };
                    let heard = clarity.min(best) >= HEARD * clarity.max(best);
                    self.shares[place] = if heard {
                        both
                    } else if clarity > best {
                        share
                    } else {
                        old
                    };
                    clearest[place] = clarity.max(best);
                }
                None => {
                    self.shares.push(share);
                    clearest.push(clarity);
                }
            }
        }
    }
}

/// Variance that the sensor's noise has in the filtered acceleration: of white noise, between 0 and a tenth
/// of the rate, ∫ω⁴.
fn acceleration_noise(log: &Channels, average: usize, quantum: Option<f64>) -> f64 {
    let third = log.position.windows(4);
    let third: Vec<f64> = third
        .map(|x| x[3] - 3.0 * x[2] + 3.0 * x[1] - x[0])
        .collect();
    // The third difference of white noise has 1 + 9 + 9 + 1 times its variance.
    let scatter = mean_square(&third) / 20.0;
    let rounding = quantum.map_or(0.0, |step| step * step / 12.0);
    let period = log.period * average as f64;
    let share = 2.0 * std::f64::consts::TAU.powi(4) * 0.1_f64.powi(5) / 5.0;
    scatter.max(rounding) * share / period.powi(4)
}

/// Averages, filters and differentiates one log.
fn band(log: &Channels, average: usize) -> Band {
    let mean = |series: &[f64]| -> Vec<f64> {
        let whole = series.chunks_exact(average);
        whole
            .map(|chunk| chunk.iter().sum::<f64>() / average as f64)
            .collect()
    };
    let smooth = |series: &[f64]| filter(&BUTTERWORTH, &mean(series));
    let optional = |series: &Option<Vec<f64>>| series.as_deref().map_or(Vec::new(), smooth);
    let optional_mean = |series: &Option<Vec<f64>>| series.as_deref().map_or(Vec::new(), mean);
    // An input that is held acts half a sample late.
    let held: Vec<f64> = (0..log.input.len())
        .map(|index| 0.5 * (log.input[index] + log.input[index.saturating_sub(1)]))
        .collect();
    let position = smooth(&log.position);
    let period = log.period * average as f64;
    let rate = |series: &[f64]| {
        if series.len() < 2 {
            vec![0.0; series.len()]
        } else {
            differentiate(series, period)
        }
    };
    let velocity = rate(&position);
    let acceleration = rate(&velocity);
    let current = optional(&log.current);
    let slow = SLOW * mean_square(&velocity).sqrt();
    let last = position.len();
    // Where the filter settles, and where the drive lets go of the motor or the filter has not forgotten it.
    let edge = 10;
    let enabled = optional_mean(&log.enabled);
    let skip = (0..last)
        .map(|index| {
            let around = index.saturating_sub(edge)..(index + edge + 1).min(enabled.len());
            let lets_go = enabled
                .get(around)
                .is_some_and(|around| around.iter().any(|it| *it < 1.0));
            index < edge || index + edge >= last || velocity[index].abs() <= slow || lets_go
        })
        .collect();
    Band {
        input: smooth(&held),
        current_rate: rate(&current),
        current,
        measured: optional(&log.velocity),
        command: optional(&log.command),
        brake: optional_mean(&log.brake),
        load: optional_mean(&log.load),
        position,
        velocity,
        acceleration,
        skip,
    }
}

impl Rows {
    /// Without the velocity, so that the direction has all that takes work. None of a motion that is one
    /// way: there friction is a constant like another.
    fn of_losses(mut self) -> Option<Self> {
        let place =
            |rows: &Self, wanted| rows.follows.iter().position(|follows| *follows == wanted);
        let direction = place(&self, Follows::Direction)?;
        let backward = self.columns[direction].iter().filter(|sign| **sign < 0.0);
        let share = backward.count() as f64 / self.sum.len().max(1) as f64;
        if share.min(1.0 - share) < BOTH_WAYS {
            return None;
        }
        self.follows[direction] = Follows::Losses;
        let velocity = place(&self, Follows::Velocity)?;
        self.follows.remove(velocity);
        self.columns.remove(velocity);
        Some(self)
    }

    /// Rows of all bands that are not skipped, thinned to [`MOST_ROWS`].
    fn new(
        bands: &[Band],
        follows: &[Follows],
        row: impl Fn(&Band, usize, Follows) -> f64,
        sum: impl Fn(&Band, usize) -> f64,
    ) -> Self {
        let kept: Vec<(&Band, usize)> = bands
            .iter()
            .flat_map(|band| (0..band.skip.len()).map(move |index| (band, index)))
            .filter(|(band, index)| !band.skip[*index])
            .collect();
        let stride = kept.len().div_ceil(MOST_ROWS).max(1);
        let kept: Vec<_> = kept.into_iter().step_by(stride).collect();
        let column = |follows: &Follows| {
            kept.iter()
                .map(|(band, index)| row(band, *index, *follows))
                .collect()
        };
        Self {
            follows: follows.to_vec(),
            columns: follows.iter().map(column).collect(),
            sum: kept.iter().map(|(band, index)| sum(band, *index)).collect(),
        }
    }
}

/// What drives the motion, over the motion. With a measured current the sum is the current, else the input.
fn motion_rows(bands: &[Band], machine: &Machine, with_current: bool) -> Rows {
    use Follows::{Acceleration, Constant, Cosine, Direction, Position, Side, Sine, Velocity};
    let mechanics = &machine.mechanics;
    let mut follows = vec![Acceleration, Velocity, Direction, Constant, Position];
    if mechanics.spring_preload > 0.0 {
        follows.push(Side);
    }
    let positions = || bands.iter().flat_map(|band| &band.position);
    let high = positions().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = positions().copied().fold(f64::INFINITY, f64::min);
    // Over less than a radian a sine is a constant and a slope.
    if machine.coordinate == Coordinate::Radian && high - low > 1.0 {
        follows.extend([Sine, Cosine]);
    }
    let row = |band: &Band, index: usize, follows: Follows| {
        let angle = band.position[index] - mechanics.gravity_rest;
        let deflection = band.position[index] - mechanics.spring_rest;
        match follows {
            Acceleration => band.acceleration[index],
            Velocity => band.velocity[index],
            Direction => band.velocity[index].signum(),
            Position => deflection,
            Side => deflection.signum(),
            Sine => angle.sin(),
            Cosine => angle.cos(),
            _ => 1.0,
        }
    };
    // What is known of the outside is not the machine's: in the sum's unit.
    let gain = match (&machine.motor, with_current) {
        (Some(motor), true) => 1.0 / motor.torque_constant,
        (Some(motor), false) => motor.resistance / motor.torque_constant,
        (None, _) => 1.0,
    };
    let sum = |band: &Band, index: usize| {
        let driven = if with_current {
            band.current[index]
        } else {
            machine.gain * band.input[index]
        };
        let at = |channel: &[f64]| channel.get(index).copied().unwrap_or(0.0);
        let brake = at(&band.brake) * band.velocity[index].signum();
        driven - gain * (brake + at(&band.load))
    };
    Rows::new(bands, &follows, row, sum)
}

/// Mean measured currents where the motor is driven forward and backward, as [`Balances::drawn`]: where the voltage and the current
/// that winding and back-EMF make of it both point there. Currents of less than half the effective one are left out: of these the
/// sign is in doubt.
fn drawn(bands: &[Band], gain: f64, [resistance, constant]: [f64; 2]) -> Option<[f64; 2]> {
    let rows = bands.iter().flat_map(|band| {
        let kept = (0..band.skip.len()).filter(|index| !band.skip[*index]);
        kept.map(|index| {
            let voltage = gain * band.input[index];
            let expected = (voltage - constant * band.velocity[index]) / resistance;
            (voltage, expected, band.current[index])
        })
    });
    let rows: Vec<(f64, f64, f64)> = rows.collect();
    let expected: Vec<f64> = rows.iter().map(|row| row.1).collect();
    let least = 0.5 * mean_square(&expected).sqrt();
    let mean = |sign: f64| {
        let driven = rows
            .iter()
            .filter(|row| sign * row.0 > 0.0 && sign * row.1 > least);
        let currents: Vec<f64> = driven.map(|row| row.2).collect();
        let enough =
            currents.len() as f64 >= BOTH_WAYS * rows.len() as f64 && currents.len() >= LEAST_ROWS;
        enough.then(|| currents.iter().sum::<f64>() / currents.len() as f64)
    };
    Some([mean(1.0)?, mean(-1.0)?])
}

/// The input voltage over the current and the velocity.
fn winding_rows(bands: &[Band], machine: &Machine) -> Rows {
    use Follows::{Constant, Current, CurrentRate, Velocity};
    let row = |band: &Band, index: usize, follows: Follows| match follows {
        Current => band.current[index],
        CurrentRate => band.current_rate[index],
        Velocity => band.velocity[index],
        _ => 1.0,
    };
    let follows = [Current, Velocity, CurrentRate, Constant];
    Rows::new(bands, &follows, row, |band, index| {
        machine.gain * band.input[index]
    })
}

/// One series over another one and a constant.
fn pair(bands: &[Band], follows: Follows, pick: impl Fn(&Band) -> (&Vec<f64>, &Vec<f64>)) -> Rows {
    let row = |band: &Band, index: usize, part: Follows| {
        if part == follows {
            pick(band).0[index]
        } else {
            1.0
        }
    };
    Rows::new(bands, &[follows, Follows::Constant], row, |band, index| {
        pick(band).1[index]
    })
}
