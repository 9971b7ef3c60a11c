//! The input/output characteristic of an actuator with friction and a return spring, and what its four
//! lines say: the first step of the semi-automatic identification.
//!
//! Source: *On Semi-Automated Modeling of Systems with Friction for HiL-Simulation and Application to
//! Electromechanical Actuators of Passenger Car*, equations 8–18. A slow triangle drives the actuator
//! to and fro; plotted over the position, the input lies on four kinds of lines, each once opening
//! (position grows) and once closing:
//!
//! * L1 and L2, [`Kind::Uniform`]: motion of constant speed;
//! * L3, [`Kind::Breakaway`]: the place and the input at which motion begins;
//! * L4, [`Kind::Standstill`]: the place and the input at which motion ends.
//!
//! The paper's Fig. 3 is read so: L1 and L2 are the two long branches, every sample of them a point; L3
//! and L4 consist of one point for each reversal, so the triangle has to reverse at several places
//! ([`growing_triangle`](crate::signal::growing_triangle)). With the equation of motion
//!
//! φ̈ = a₀ φ' − a₁ φ̇ + b₀ u + c₀ s − c₁ sgn φ̇,  φ' = φₒ − φ,  s = sgn φ'
//!
//! all four lines have the slope du/dφ = a₀/b₀, and at φₒ, with d = ±1 for opening and closing,
//!
//! | line | u at φₒ |
//! |---|---|
//! | L4 | −s c₀/b₀ + d c₁/b₀ |
//! | L3 | −s c₀/b₀ + d c_H/b₀ |
//! | L1, L2 | −s c₀/b₀ + d (c₁/b₀ + (a₁/b₀) \|φ̇\|) |
//!
//! Here the six numbers are positive where a positive input moves towards larger positions; the
//! paper's closing input is negated. The paper's throttle has its rest φₒ at the upper stop, so that
//! s = 1 always; a limp-home throttle has lines on both sides of its rest, of one slope, twice c₀/b₀
//! apart.
//!
//! One rate of the triangle suffices: L4 is the line of zero speed to which eq. 15 compares L1 and L2.
//! With several rates, uniform motion is reduced to its median speed by the a₁/b₀ found so far.

use super::line::{self, Line, Point, Settings as LineSettings};
use crate::numeric::statistics::median;
use crate::numeric::student;
use heapless::Vec;

/// Most points that a line of uniform motion is fitted to; a longer log is thinned out.
pub const MOST_POINTS: usize = 512;

/// Most reversals of one kind, direction and side that are used: the first ones.
pub const MOST_EVENTS: usize = 64;

/// Speed, in standard errors of the local slope, above which the actuator moves.
const MOVING: f32 = 6.0;

/// Displacement, in standard deviations of the sensor, up to which the begin or end of a motion is
/// fitted.
const ONSET: f32 = 8.0;

/// Distance from a stop or from the spring's rest, in standard deviations of the sensor, within which
/// a standstill says nothing of friction.
const AT_REST: f32 = 6.0;

/// Largest change of speed, relative, across [`UNIFORM_TIMES`] smoothing times of a uniform motion.
const UNIFORM_CHANGE: f32 = 0.25;

/// See [`UNIFORM_CHANGE`].
const UNIFORM_TIMES: usize = 4;

/// Rounds in which uniform motion is reduced to its median speed.
const ROUNDS: usize = 4;

/// A log of the slow test and what is known about the actuator.
#[derive(Debug, Clone, Copy)]
pub struct Task<'l> {
    /// Sample period, s.
    pub period: f32,
    /// Input, V, N·m or N, held from a sample to the next.
    pub input: &'l [f32],
    /// Measured position, rad or m; as long as `input`.
    pub position: &'l [f32],
    /// One count of the sensor, rad or m; 0 where it is fine.
    pub resolution: f32,
    /// φₒ, rad or m: where the spring rests.
    pub rest: f32,
    /// Lower end stop as the sensor reports it, rad or m; −∞ for none.
    pub lower_stop: f32,
    /// Upper end stop as the sensor reports it, rad or m; ∞ for none.
    pub upper_stop: f32,
    /// Time over which speeds are averaged, s: short against the triangle's flank, long enough
    /// for the sensor's noise.
    pub smoothing: f32,
    /// b₀ as it is known so far, rad/s² or m/s² for one unit of the input: what the paper sets to zero,
    /// φ̈/b₀ at the end of a motion, is 30 mV on a throttle under 1.6 V/s and is taken off.
    pub acceleration_gain: f32,
    /// 1/a₁ as it is known so far, s: the time in which speed settles after a breakaway.
    pub time_constant: f32,
    /// a₁/a₀ as it is known so far, s: the time in which the spring settles; ∞ if it is not.
    pub settling_time: f32,
    /// L/R, s: how late the motor's torque follows the input.
    pub lag: f32,
    /// Seed of RANSAC.
    pub seed: u64,
}

/// What the points of a line have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// L1 (opening), L2 (closing): motion at constant speed.
    Uniform,
    /// L3: from stiction to sliding.
    Breakaway,
    /// L4: from sliding to stiction.
    Standstill,
}

impl Kind {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Uniform, Self::Breakaway, Self::Standstill];
}

/// Direction of a motion that goes on, begins or ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Towards larger positions.
    Opening,
    /// Towards smaller positions.
    Closing,
}

impl Direction {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Opening, Self::Closing];

    /// d: 1 or −1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Opening => 1.0,
            Self::Closing => -1.0,
        }
    }
}

/// On which side of the spring's rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// φ < φₒ: the spring pulls towards larger positions.
    Below,
    /// φ > φₒ.
    Above,
}

impl Side {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Below, Self::Above];

    /// s = sgn(φₒ − φ): 1 or −1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Below => 1.0,
            Self::Above => -1.0,
        }
    }
}

/// A line of the characteristic: input over position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// What its points are.
    pub kind: Kind,
    /// Which way the motion goes.
    pub direction: Direction,
    /// On which side of the spring's rest.
    pub side: Side,
    /// The line, in V (N·m, N) over rad or m.
    pub line: Line,
}

/// A number with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its variance.
    pub variance: f64,
    /// Degrees of freedom of the variance.
    pub degrees_of_freedom: f64,
}

impl Estimate {
    /// Half of the width of the 95 % confidence interval.
    pub fn half_width(&self) -> f64 {
        student::quantile_975(self.degrees_of_freedom) * libm::sqrt(self.variance)
    }
}

/// The five ratios, all positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ratios {
    /// a₀/b₀, V/rad: the spring.
    pub a0: Estimate,
    /// a₁/b₀, V·s/rad: viscous friction and back-EMF.
    pub a1: Estimate,
    /// c₀/b₀, V: the spring's preload.
    pub c0: Estimate,
    /// c₁/b₀, V: Coulomb friction.
    pub c1: Estimate,
    /// c_H/b₀, V: static friction.
    pub ch: Estimate,
}

/// A point of the characteristic.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Position, rad or m.
    pub position: f32,
    /// Input there.
    pub input: f32,
    /// Velocity, rad/s or m/s; 0 where motion begins or ends.
    pub velocity: f32,
    /// The stretch of motion that it belongs to.
    pub stretch: u16,
    /// Whether its line took it.
    pub inlier: bool,
}

/// Why a log does not give the ratios.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refusal {
    /// Fewer samples than some smoothing times, or a smoothing time of fewer than five samples.
    TooShort,
    /// No uniform motion, opening or closing, that gives a line.
    NoUniformMotion,
    /// Fewer than four places where motion begins, for one side of the rest both ways.
    TooFewBreakaways,
    /// Fewer than four places where motion ends, for one side of the rest both ways.
    TooFewStandstills,
}

/// Points of one line.
type Points<const N: usize> = Vec<Sample, N>;

/// Number of branches of a kind: directions × sides.
const WAYS: usize = 4;

/// The characteristic of a log: points, lines, ratios. Some 80 KB: for a host, or a board's static
/// memory.
#[derive(Debug, Clone)]
pub struct Characteristic {
    /// Standard deviation of the position sensor, found from the log, rad or m.
    pub deviation: f32,
    /// Speed to which uniform motion is reduced, rad/s or m/s.
    pub speed: f32,
    /// All lines found, L1 and L2 first.
    pub branches: Vec<Branch, { 3 * WAYS }>,
    uniform: [Points<MOST_POINTS>; WAYS],
    breakaways: [Points<MOST_EVENTS>; WAYS],
    standstills: [Points<MOST_EVENTS>; WAYS],
}

fn way(direction: Direction, side: Side) -> usize {
    2 * usize::from(direction == Direction::Closing) + usize::from(side == Side::Above)
}

fn direction_of(velocity: f32) -> Direction {
    if velocity > 0.0 {
        Direction::Opening
    } else {
        Direction::Closing
    }
}

impl Characteristic {
    /// Finds points and lines in a log.
    ///
    /// # Errors
    /// See [`Refusal`].
    pub fn find(task: &Task) -> Result<Self, Refusal> {
        let smoother = Smoother::new(task)?;
        let mut found = Self {
            deviation: smoother.deviation,
            speed: 0.0,
            branches: Vec::new(),
            uniform: Default::default(),
            breakaways: Default::default(),
            standstills: Default::default(),
        };
        found.collect(task, &smoother);
        found.reduce(task)?;
        Ok(found)
    }

    /// Points of a kind, opening and closing, below and above the rest.
    pub fn points(&self, kind: Kind) -> impl Iterator<Item = (Direction, Side, &[Sample])> {
        Direction::ALL.into_iter().flat_map(move |direction| {
            Side::ALL.into_iter().map(move |side| {
                let way = way(direction, side);
                let points: &[Sample] = match kind {
                    Kind::Uniform => &self.uniform[way],
                    Kind::Breakaway => &self.breakaways[way],
                    Kind::Standstill => &self.standstills[way],
                };
                (direction, side, points)
            })
        })
    }

    /// A line that was found.
    pub fn line(&self, kind: Kind, direction: Direction, side: Side) -> Option<&Line> {
        let wanted = |branch: &&Branch| {
            branch.kind == kind && branch.direction == direction && branch.side == side
        };
        self.branches.iter().find(wanted).map(|branch| &branch.line)
    }

    /// Goes through the log once: stretches of motion, their uniform parts, their ends.
    fn collect(&mut self, task: &Task, smoother: &Smoother) {
        let samples = task.position.len();
        let stride = (smoother.width / 4).max(1);
        let uniform_every = smoother.width.max(samples / MOST_POINTS);
        let mut stretch = 0;
        let mut last_uniform = 0;
        let mut was = None;
        let mut at = smoother.width;
        while at + smoother.width < samples {
            let velocity = smoother.velocity(task, at);
            let moving = (velocity.abs() > smoother.least_speed).then(|| direction_of(velocity));
            match (was.flatten(), moving) {
                (None, Some(direction)) => {
                    stretch += 1;
                    if was.is_some() {
                        self.begin(task, smoother, at, direction, stretch);
                    }
                }
                (Some(direction), None) => self.end(task, smoother, at, direction, stretch),
                (Some(before), Some(now)) if before != now => stretch += 1,
                _ => {}
            }
            if moving.is_some()
                && at >= last_uniform + uniform_every
                && let Some((position, input)) = smoother.uniform(task, at, velocity)
            {
                let way = way(direction_of(velocity), task.side(position));
                // A full line has its share of points already.
                let _ = self.uniform[way].push(Sample {
                    position,
                    input,
                    velocity,
                    stretch,
                    inlier: false,
                });
                last_uniform = at;
            }
            was = Some(moving);
            at += stride;
        }
    }

    /// A motion that was seen at `at` began before: where, and under which input.
    fn begin(&mut self, task: &Task, smoother: &Smoother, at: usize, to: Direction, stretch: u16) {
        let forward = |step: isize| at.checked_add_signed(step);
        let rate = smoother.slope(task.input, at);
        let ramp = rate * to.sign() as f32;
        if let Some(onset) = smoother.onset(task, forward, to, Onset::Breakaway { ramp }) {
            let input = task.input[onset.sample] - rate * task.age();
            self.breakaways[way(to, task.side(onset.position))]
                .push(event(onset.position, input, stretch))
                .ok();
        }
    }

    /// A motion that was not seen any more at `at` ended before: where, and under which input. The end
    /// of a motion is the onset of its reverse in reversed time.
    fn end(&mut self, task: &Task, smoother: &Smoother, at: usize, of: Direction, stretch: u16) {
        let backward = |step: isize| at.checked_add_signed(-step);
        let reverse = match of {
            Direction::Opening => Direction::Closing,
            Direction::Closing => Direction::Opening,
        };
        if let Some(onset) = smoother.onset(task, backward, reverse, Onset::Standstill) {
            // Backward in time speeds change sign, accelerations do not.
            let acceleration = onset.acceleration * reverse.sign() as f32;
            // The sample at rest comes half a period after the end of the motion.
            let age = task.age() + 0.5 * task.period;
            let felt = task.input[onset.sample] - smoother.slope(task.input, at) * age;
            let input = felt - acceleration / task.acceleration_gain;
            self.standstills[way(of, task.side(onset.position))]
                .push(event(onset.position, input, stretch))
                .ok();
        }
    }

    /// Fits the lines, in rounds: uniform motion is reduced to one speed by the a₁/b₀ of the last.
    fn reduce(&mut self, task: &Task) -> Result<(), Refusal> {
        let mut speeds: Vec<f32, MOST_POINTS> = Vec::new();
        let every = 1 + self
            .uniform
            .iter()
            .map(|points| points.len())
            .sum::<usize>()
            / MOST_POINTS;
        for sample in self.uniform.iter().flatten().step_by(every) {
            let _ = speeds.push(sample.velocity.abs());
        }
        self.speed = median(&mut speeds).ok_or(Refusal::NoUniformMotion)?;
        let mut damping = 0.0;
        for round in 1..=ROUNDS {
            self.branches.clear();
            let speed = self.speed;
            for kind in Kind::ALL {
                for direction in Direction::ALL {
                    for side in Side::ALL {
                        let way = way(direction, side);
                        let points: &mut [Sample] = match kind {
                            Kind::Uniform => &mut self.uniform[way],
                            Kind::Breakaway => &mut self.breakaways[way],
                            Kind::Standstill => &mut self.standstills[way],
                        };
                        let input = |sample: &Sample| match kind {
                            Kind::Uniform => {
                                let extra =
                                    sample.velocity - libm::copysignf(speed, sample.velocity);
                                sample.input - damping * extra
                            }
                            Kind::Breakaway | Kind::Standstill => sample.input,
                        };
                        if let Some(line) = fit(task, points, input) {
                            let _ = self.branches.push(Branch {
                                kind,
                                direction,
                                side,
                                line,
                            });
                        }
                    }
                }
            }
            let ratios = self.ratios(task.rest)?;
            if round < ROUNDS {
                damping = ratios.a1.value as f32;
            }
        }
        Ok(())
    }

    /// The ratios, eqs 14–18, the lines of both sides of `rest` (φₒ) taken together.
    ///
    /// # Errors
    /// A line that is missing. Two are needed of each kind, opening and closing on one side.
    pub fn ratios(&self, rest: f32) -> Result<Ratios, Refusal> {
        let rest = f64::from(rest);
        // Eq. 14: A1 and B1 on a line of uniform motion.
        let mut slope = Mean::default();
        for branch in &self.branches {
            if branch.kind == Kind::Uniform {
                slope.add(Estimate {
                    value: branch.line.slope,
                    variance: branch.line.slope_variance,
                    degrees_of_freedom: branch.line.degrees_of_freedom,
                });
            }
        }
        let a0 = slope.estimate().ok_or(Refusal::NoUniformMotion)?;
        let (mut a1, mut c0, mut c1, mut ch) = <(Mean, Mean, Mean, Mean)>::default();
        for side in Side::ALL {
            let line = |kind, direction| self.line(kind, direction, side);
            let pair = |kind| {
                Some((
                    line(kind, Direction::Opening)?,
                    line(kind, Direction::Closing)?,
                ))
            };
            // Eq. 17: A4 and B4 at one position. Eq. 18: A5 and B5.
            if let Some((opening, closing)) = pair(Kind::Standstill) {
                c1.add(difference(opening, closing, &a0).scaled(0.5));
            }
            if let Some((opening, closing)) = pair(Kind::Breakaway) {
                ch.add(difference(opening, closing, &a0).scaled(0.5));
                // Eq. 16: A3 and B3 at φₒ, the lines continued with their common slope.
                c0.add(mean_at(opening, closing, rest, &a0).scaled(-side.sign()));
            }
            // Eq. 15: A2 on uniform motion, B2 where such a motion ends, at one position.
            for direction in Direction::ALL {
                let lines = line(Kind::Uniform, direction).zip(line(Kind::Standstill, direction));
                if let Some((uniform, standstill)) = lines {
                    let per_speed = direction.sign() / f64::from(self.speed);
                    a1.add(difference(uniform, standstill, &a0).scaled(per_speed));
                }
            }
        }
        Ok(Ratios {
            a0,
            a1: a1.estimate().ok_or(Refusal::TooFewStandstills)?,
            c0: c0.estimate().ok_or(Refusal::TooFewBreakaways)?,
            c1: c1.estimate().ok_or(Refusal::TooFewStandstills)?,
            ch: ch.estimate().ok_or(Refusal::TooFewBreakaways)?,
        })
    }
}

impl Estimate {
    fn scaled(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            variance: self.variance * factor * factor,
            ..self
        }
    }
}

/// Input on `upper` minus input on `lower` at one position, halfway between their centres.
fn difference(upper: &Line, lower: &Line, slope: &Estimate) -> Estimate {
    let apart = lower.centre - upper.centre;
    combined(
        upper.level - lower.level + slope.value * apart,
        [
            (upper.level_variance, upper.degrees_of_freedom),
            (lower.level_variance, lower.degrees_of_freedom),
            (apart * apart * slope.variance, slope.degrees_of_freedom),
        ],
    )
}

/// Mean of the inputs on two lines at position `x`.
fn mean_at(one: &Line, other: &Line, x: f64, slope: &Estimate) -> Estimate {
    let away = x - 0.5 * (one.centre + other.centre);
    combined(
        0.5 * (one.level + other.level) + slope.value * away,
        [
            (0.25 * one.level_variance, one.degrees_of_freedom),
            (0.25 * other.level_variance, other.degrees_of_freedom),
            (away * away * slope.variance, slope.degrees_of_freedom),
        ],
    )
}

/// A sum of independent parts with these variances; degrees of freedom by Welch and Satterthwaite.
fn combined(value: f64, parts: [(f64, f64); 3]) -> Estimate {
    let variance: f64 = parts.iter().map(|(variance, _)| variance).sum();
    let fourth = parts
        .iter()
        .map(|(variance, freedom)| variance * variance / freedom);
    let fourth: f64 = fourth.sum();
    Estimate {
        value,
        variance,
        degrees_of_freedom: if fourth > 0.0 {
            variance * variance / fourth
        } else {
            f64::INFINITY
        },
    }
}

/// Mean of independent estimates, each with the reciprocal of its variance as its weight; its variance
/// allows for weights that are estimates themselves (Meier, Biometrics 9, 1953).
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    weights: f64,
    sum: f64,
    /// Σ weight²/ν (Welch and Satterthwaite)
    fourth: f64,
    /// Σ weight/ν
    third: f64,
}

impl Mean {
    fn add(&mut self, estimate: Estimate) {
        // Lines without any scatter are equally good.
        let weight = 1.0 / estimate.variance.max(1e-24);
        self.weights += weight;
        self.sum += weight * estimate.value;
        self.fourth += weight * weight / estimate.degrees_of_freedom;
        self.third += weight / estimate.degrees_of_freedom;
    }

    fn estimate(&self) -> Option<Estimate> {
        (self.weights > 0.0).then(|| Estimate {
            value: self.sum / self.weights,
            // 1/W (1 + 4 Σ w (1 − w)/ν) with w the weight's share of their sum W
            variance: (1.0 + 4.0 * (self.third - self.fourth / self.weights) / self.weights)
                / self.weights,
            degrees_of_freedom: self.weights * self.weights / self.fourth,
        })
    }
}

fn event(position: f32, input: f32, stretch: u16) -> Sample {
    Sample {
        position,
        input,
        velocity: 0.0,
        stretch,
        inlier: false,
    }
}

/// Fits a line to points and marks its inliers.
fn fit(task: &Task, samples: &mut [Sample], input: impl Fn(&Sample) -> f32) -> Option<Line> {
    let mut points: Vec<Point, MOST_POINTS> = Vec::new();
    for sample in samples.iter() {
        let _ = points.push(Point {
            x: sample.position,
            y: input(sample),
            group: sample.stretch,
        });
    }
    let settings = LineSettings {
        confidence: 0.999,
        inlier_share: 0.5,
        least_deviation: 0.0,
        seed: task.seed,
    };
    let (mut scratch, mut inlier) = ([0.0; MOST_POINTS], [false; MOST_POINTS]);
    let line = line::fit(&points, &settings, &mut scratch, &mut inlier)?;
    for (sample, inlier) in samples.iter_mut().zip(inlier) {
        sample.inlier = inlier;
    }
    Some(line)
}

impl Task<'_> {
    /// How old the input is that the mechanism feels, s: half a period, for which a sample is held on
    /// average when something happens, and the winding's lag.
    fn age(&self) -> f32 {
        0.5 * self.period + self.lag
    }

    fn side(&self, position: f32) -> Side {
        if position < self.rest {
            Side::Below
        } else {
            Side::Above
        }
    }
}

/// Local means and slopes of the position.
struct Smoother {
    /// Samples of the smoothing time.
    width: usize,
    /// Standard deviation of the sensor.
    deviation: f32,
    /// Speed from which on the actuator is said to move.
    least_speed: f32,
    period: f32,
}

impl Smoother {
    fn new(task: &Task) -> Result<Self, Refusal> {
        let width = (task.smoothing / task.period) as usize;
        let samples = task.position.len();
        if width < 5 || samples < 20 * width || samples != task.input.len() {
            return Err(Refusal::TooShort);
        }
        let mut smoother = Self {
            width,
            deviation: 0.0,
            least_speed: 0.0,
            period: task.period,
        };
        // Scatter about the local lines, the median of all windows: motion is smooth within one.
        let mut scatter: Vec<f32, MOST_POINTS> = Vec::new();
        let every = (samples / MOST_POINTS).max(width);
        let mut at = width;
        while at + width < samples {
            let _ = scatter.push(smoother.scatter(task, at));
            at += every;
        }
        // Rounding to counts is uniform: its standard deviation is a count over √12.
        let rounding = task.resolution * 0.288_675_13;
        smoother.deviation = median(&mut scatter).ok_or(Refusal::TooShort)?.max(rounding);
        let n = width as f32;
        let slope_error = libm::sqrtf(12.0 / (n * (n * n - 1.0))) / task.period;
        smoother.least_speed = MOVING * smoother.deviation * slope_error;
        Ok(smoother)
    }

    /// First sample of the window around `at`.
    fn from(&self, at: usize) -> usize {
        at - self.width / 2
    }

    fn mean(&self, values: &[f32], at: usize) -> f32 {
        let from = self.from(at);
        let window = &values[from..from + self.width];
        // Relative to the first: a sum of small numbers rounds little.
        let sum: f32 = window.iter().map(|value| value - window[0]).sum();
        window[0] + sum / self.width as f32
    }

    /// Least-squares slope of a series around `at`, per second.
    fn slope(&self, values: &[f32], at: usize) -> f32 {
        let from = self.from(at);
        let window = &values[from..from + self.width];
        let n = self.width as f32;
        let middle = 0.5 * (n - 1.0);
        let product: f32 = window
            .iter()
            .enumerate()
            .map(|(k, value)| (k as f32 - middle) * (value - window[0]))
            .sum();
        product * 12.0 / (n * (n * n - 1.0)) / self.period
    }

    fn velocity(&self, task: &Task, at: usize) -> f32 {
        self.slope(task.position, at)
    }

    /// Standard deviation about the local line.
    fn scatter(&self, task: &Task, at: usize) -> f32 {
        let from = self.from(at);
        let mean = self.mean(task.position, at);
        let slope = self.velocity(task, at) * self.period;
        let middle = 0.5 * (self.width as f32 - 1.0);
        let window = &task.position[from..from + self.width];
        let squares: f32 = window
            .iter()
            .enumerate()
            .map(|(k, value)| {
                let residual = value - mean - slope * (k as f32 - middle);
                residual * residual
            })
            .sum();
        libm::sqrtf(squares / (self.width as f32 - 2.0))
    }

    /// Position and input of a uniform motion around `at`: constant speed, one flank of the triangle,
    /// away from stops and from the rest.
    fn uniform(&self, task: &Task, at: usize, velocity: f32) -> Option<(f32, f32)> {
        let apart = UNIFORM_TIMES * self.width / 2;
        let (before, after) = (at.checked_sub(apart)?, at + apart);
        if before < self.width || after + self.width >= task.position.len() {
            return None;
        }
        let change = self.velocity(task, after) - self.velocity(task, before);
        // What noise alone may change.
        let noise = 1.5 * self.least_speed / MOVING;
        if change.abs() > UNIFORM_CHANGE * velocity.abs() + noise {
            return None;
        }
        let rates = [before, at, after].map(|place| self.slope(task.input, place));
        if (rates[2] - rates[0]).abs() > 0.01 * rates[1].abs() {
            return None;
        }
        let ends = [before, after].map(|place| self.mean(task.position, place));
        let margin = AT_REST * self.deviation + velocity.abs() * self.width as f32 * self.period;
        let apart_from = |place: f32| {
            let sides = ends.map(|end| end - place);
            sides[0] * sides[1] > 0.0 && sides.iter().all(|side| side.abs() > margin)
        };
        if !(apart_from(task.lower_stop) && apart_from(task.upper_stop) && apart_from(task.rest)) {
            return None;
        }
        let acceleration = change / ((after - before) as f32 * self.period);
        Some((
            self.mean(task.position, at),
            self.mean(task.input, at)
                - rates[1] * task.age()
                - acceleration / task.acceleration_gain,
        ))
    }

    /// When a motion in a direction begins, and the position before it.
    ///
    /// `sample(k)` is the k-th sample counted in the direction of time (or against it) from where the
    /// motion was noticed first. Before the motion the position is a constant, y₀; after its begin at
    /// t₀ it is y₀ + A S(t − t₀) + R(t − t₀) with the shapes of [`Onset`], as long as the displacement is
    /// [`ONSET`] standard deviations at most. Of all t₀ the one with the least squares over A ≥ 0 is
    /// taken: a threshold would report every begin late.
    fn onset(
        &self,
        task: &Task,
        sample: impl Fn(isize) -> Option<usize>,
        to: Direction,
        kind: Onset,
    ) -> Option<Begin> {
        let width = self.width as isize;
        let read = |step: isize| task.position.get(sample(step)?).copied();
        // At least as long as the smoothing time, at most five times that, the position was held.
        let (first, last) = (-7 * width, -2 * width);
        let mut held = 0;
        let mut sum = 0.0;
        let reference = read(last)?;
        for step in (first..last).rev() {
            let Some(value) = read(step) else { break };
            if (value - reference).abs() > AT_REST * self.deviation {
                break;
            }
            sum += value - reference;
            held += 1;
        }
        if held < width {
            return None;
        }
        let place = reference + sum / held as f32;
        let margin = AT_REST * self.deviation;
        let at_rest = [task.rest, task.lower_stop, task.upper_stop]
            .iter()
            .any(|rest| (place - rest).abs() <= margin);
        if at_rest {
            return None;
        }
        let sign = to.sign() as f32;
        // The displacement is large enough where four samples in a row say so.
        let limit = ONSET * self.deviation;
        let mut beyond = 0;
        let mut end = last;
        while beyond < 4 {
            beyond = if (read(end)? - place) * sign > limit {
                beyond + 1
            } else {
                0
            };
            end += 1;
            if end > 4 * width {
                return None;
            }
        }
        let end = end - 4;
        let mut best: Option<(f32, isize, f32)> = None;
        for start in last..end - 3 {
            let (mut product, mut square, mut total) = (0.0_f32, 0.0_f32, 0.0_f32);
            for step in last..end {
                let mut value = (read(step)? - place) * sign;
                if step > start {
                    let (shape, known) = kind.shapes((step - start) as f32 * self.period, task);
                    value -= known;
                    product += value * shape;
                    square += shape * shape;
                }
                total += value * value;
            }
            let acceleration = product.max(0.0) / square;
            let left = total - acceleration * product;
            if best.is_none_or(|(least, ..)| left < least) {
                best = Some((left, start, acceleration));
            }
        }
        let (_, start, acceleration) = best?;
        Some(Begin {
            position: place,
            sample: sample(start)?,
            acceleration,
        })
    }
}

/// The begin of a motion.
struct Begin {
    /// Position before it.
    position: f32,
    /// Last sample before it.
    sample: usize,
    /// Magnitude of the acceleration at the begin.
    acceleration: f32,
}

/// How a displacement begins.
#[derive(Clone, Copy)]
enum Onset {
    /// From static to Coulomb friction, at an acceleration that the damping wears off, while the
    /// input goes on by `ramp` a second in the direction of the motion.
    Breakaway {
        /// V/s
        ramp: f32,
    },
    /// Backward in time, from standstill at an acceleration that grows with the settling time.
    Standstill,
}

impl Onset {
    /// Displacement after `time` s: for a unit of acceleration at the begin, and by the ramp.
    fn shapes(self, time: f32, task: &Task) -> (f32, f32) {
        match self {
            Self::Standstill => {
                // τ² (e^x − 1 − x) with x = t/τ, as a series: x is small, or τ infinite.
                let x = time / task.settling_time;
                (0.5 * time * time * (1.0 + x / 3.0 * (1.0 + x / 4.0)), 0.0)
            }
            Self::Breakaway { ramp } => {
                let tau = task.time_constant;
                // 1 − e^(−t/τ)
                let settled = -libm::expm1f(-time / tau);
                let step = tau * (time - tau * settled);
                let rate = task.acceleration_gain * ramp.max(0.0);
                (step, rate * tau * (0.5 * time * time - step))
            }
        }
    }
}
