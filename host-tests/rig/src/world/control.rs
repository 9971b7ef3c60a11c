//! Who drives a world's machine: a position loop with gains that follow from the machine's numbers, an open
//! loop, or somebody's hand.

use super::dice::{between, chance, pick};
use super::machine::{InputKind, Machine};
use super::motion::Motion;
use crate::random::Random;

/// What kind of drive it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveKind {
    /// The position's error alone; on a torque or a current with the speed taken back, else it would swing.
    Proportional,
    /// With an integral.
    ProportionalIntegral,
    /// With both.
    Pid,
    /// A position loop around a velocity loop.
    Cascade,
    /// An input that nobody corrects, in steps of an eighth of its range.
    Open,
    /// A hand that corrects now and then.
    Hand,
}

/// One drive with its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// What it is.
    pub kind: DriveKind,
    /// What it is to do.
    pub motion: Motion,
    /// Time from one correction to the next, s.
    pub period: f64,
    /// Bandwidth of the loop, rad/s.
    pub bandwidth: f64,
    /// How far its idea of the machine is off, over the truth.
    sloppiness: f64,
}

/// Fastest sensible loop, rad/s, with corrections every `period`, s, and delays of `late`, s.
pub(super) fn fastest(period: f64, late: f64) -> f64 {
    0.3 / (1.5 * period + late)
}

impl Drive {
    /// A drive for a machine whose input acts and whose sensor reports `late` in all, s. `calm` is how many
    /// times the loop is slower than it could be.
    pub(super) fn draw(
        random: &mut Random,
        machine: &Machine,
        timing: (f64, f64, f64),
        calm: f64,
    ) -> Self {
        let (period, late, seconds) = timing;
        use DriveKind::{Cascade, Hand, Open, Pid, Proportional, ProportionalIntegral};
        let mut kind = pick(
            random,
            &[
                Proportional,
                ProportionalIntegral,
                Pid,
                Pid,
                Cascade,
                Cascade,
                Open,
                Hand,
            ],
        );
        let settled = machine.input == InputKind::Voltage || machine.spring > 0.0;
        if kind == Open && !settled {
            // Nothing holds it in its place.
            kind = Hand;
        }
        let wanted = machine.speed() / machine.amplitude * between(random, 4.0, 14.0);
        let electric = if machine.input == InputKind::Voltage {
            machine.inductance / machine.resistance
        } else {
            0.0
        };
        // Noise of the sensor through the gains: a seventh of what the motor has.
        let quiet = 0.011 * machine.torque / (machine.inertia * machine.resolution.max(1e-12));
        let bandwidth = wanted
            .min(fastest(period, late + electric))
            .min(quiet.sqrt())
            / calm;
        Self {
            kind,
            motion: Motion::draw(random, machine, seconds),
            period,
            bandwidth,
            sloppiness: between(random, 0.75, 1.3),
        }
    }

    /// The same machine driven in another way.
    pub(super) fn controller<'a>(&'a self, machine: &'a Machine) -> Controller<'a> {
        Controller {
            drive: self,
            machine,
            gains: Gains::new(self, machine),
            integral: 0.0,
            rate: 0.0,
            last: None,
            held: 0.0,
            ticks: 0,
        }
    }
}

/// Gains in units of load.
#[derive(Debug, Clone, Copy)]
struct Gains {
    stiffness: f64,
    damping: f64,
    integral: f64,
    filter: f64,
}

impl Gains {
    fn new(drive: &Drive, machine: &Machine) -> Self {
        let rate = drive.bandwidth;
        // What damps the loop well, and what the machine does not bring by itself.
        let wanted = 1.6 * machine.inertia * rate;
        let own = machine.damping();
        let whole = wanted.max(own);
        let stiffness = whole * rate / 1.6;
        let (damping, integral) = match drive.kind {
            DriveKind::Proportional => ((wanted - own).max(0.0), 0.0),
            DriveKind::ProportionalIntegral => ((wanted - own).max(0.0), 0.12 * rate),
            _ => ((wanted - own).max(0.0) + 0.1 * wanted, 0.2 * rate),
        };
        Self {
            stiffness,
            damping,
            integral: integral * stiffness,
            filter: (0.12 / rate).max(drive.period),
        }
    }
}

/// A drive at work.
#[derive(Debug, Clone)]
pub(super) struct Controller<'a> {
    drive: &'a Drive,
    machine: &'a Machine,
    gains: Gains,
    integral: f64,
    rate: f64,
    last: Option<f64>,
    held: f64,
    ticks: usize,
}

impl Controller<'_> {
    /// The position asked for at a time.
    pub fn command(&self, time: f64) -> f64 {
        self.machine.centre + self.drive.motion.at(time)
    }

    /// The input from `time` on, the sensor having reported `measured`.
    pub fn step(&mut self, time: f64, measured: f64) -> f64 {
        let last = self.last.replace(measured).unwrap_or(measured);
        let filter = self.gains.filter;
        self.rate = (filter * self.rate + measured - last) / (filter + self.drive.period);
        let error = self.command(time) - measured;
        let input = match self.drive.kind {
            DriveKind::Open => self.feed_forward(time),
            DriveKind::Hand => self.hand(time, error),
            DriveKind::Cascade => self.cascade(time, error),
            _ => {
                let load = self.gains.stiffness * error - self.gains.damping * self.rate;
                self.limited(load, error)
            }
        };
        self.ticks += 1;
        input
    }

    /// A load, with the integral, as an input within its limits.
    fn limited(&mut self, load: f64, error: f64) -> f64 {
        let per_input = self.machine.load_per_input();
        let wanted = (load + self.integral) / per_input;
        let limit = self.machine.limit;
        let input = wanted.clamp(-limit, limit);
        if input == wanted || error * (load + self.integral) < 0.0 {
            self.integral += self.gains.integral * error * self.drive.period;
        }
        input
    }

    fn cascade(&mut self, time: f64, error: f64) -> f64 {
        let step = self.drive.period;
        let asked = (self.command(time + step) - self.command(time - step)) / (2.0 * step);
        let ahead = if asked.abs() < 3.0 * self.machine.speed() {
            0.8 * asked
        } else {
            0.0
        };
        let wanted = 0.35 * self.drive.bandwidth * error + ahead;
        let wrong = wanted - self.rate;
        // The inner loop: as stiff against speed as the damping of the outer one would be.
        let gain = 1.6 * self.machine.inertia * self.drive.bandwidth;
        let gain = gain.max(0.5 * self.machine.damping());
        self.gains.integral = 0.3 * gain * self.drive.bandwidth;
        self.limited(gain * wrong, wrong)
    }

    /// What the motion takes, as far as whoever made the course knew, in steps of an eighth.
    fn feed_forward(&self, time: f64) -> f64 {
        let machine = self.machine;
        let step = (0.01 * machine.cycle).max(self.drive.period);
        let at = |time: f64| self.drive.motion.at(time);
        let speed = (at(time + step) - at(time - step)) / (2.0 * step);
        let speed = speed.clamp(-machine.speed(), machine.speed());
        let place = machine.centre + at(time);
        let friction = machine.coulomb * (8.0 * speed / machine.speed()).clamp(-1.0, 1.0);
        let load = friction
            + machine.damping() * speed
            + machine.spring * (place - machine.spring_rest)
            + machine.gravity * (place - machine.gravity_rest).sin();
        let input = self.drive.sloppiness * load / machine.load_per_input();
        let notch = machine.limit / 8.0;
        ((input / notch).round() * notch).clamp(-machine.limit, machine.limit)
    }

    /// Corrects ten times in the fastest motion, pushes a little harder than friction takes.
    fn hand(&mut self, time: f64, error: f64) -> f64 {
        let every = (0.03 * self.machine.cycle / self.drive.period)
            .ceil()
            .max(1.0) as usize;
        if self.ticks.is_multiple_of(every) {
            let machine = self.machine;
            let rate = (0.5 * self.drive.bandwidth).min(4.0 / machine.cycle * 3.0);
            let damping = (1.6 * machine.inertia * rate).max(machine.damping());
            let place = self.command(time);
            let load = damping * rate / 1.6 * error
                - (damping - machine.damping()).max(0.0) * self.rate
                + 0.9 * machine.coulomb * (20.0 * error / machine.amplitude).clamp(-1.0, 1.0)
                + machine.spring * (place - machine.spring_rest)
                + machine.gravity * (place - machine.gravity_rest).sin();
            let input = self.drive.sloppiness * load / machine.load_per_input();
            self.held = input.clamp(-machine.limit, machine.limit);
        }
        self.held
    }
}

/// How many times the loop corrects in one row of the log.
pub(super) fn corrections_a_row(random: &mut Random) -> usize {
    if chance(random, 0.4) {
        pick(random, &[2, 4, 5, 10])
    } else {
        1
    }
}
