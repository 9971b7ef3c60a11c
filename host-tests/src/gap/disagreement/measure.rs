//! What one reading of logs and machine file costs: how far the balances of the log are from what the
//! machine file, and a data sheet's tolerance, allow.

use super::balance::{Balance, Balances, Follows};
use super::channels::{self, Channels, Wrap};
use super::limits::{
    BAD_GUESS, BEYOND_STOPS, COMMAND_FACTOR, EXACT_DEVIATION, EXACT_FACTOR, FAR_OFF,
    FITTED_DEVIATION, FITTED_FACTOR, FLOOR, GLITCHES, HINT, IMPOSSIBLE, INDUCTANCE_FACTOR,
    LEAST_SAVING, LONGEST_PERIOD, LONGEST_WINDING, SHORTEST_PERIOD, STATED_DEVIATION,
    STATED_FACTOR, SUPPLY_DEVIATION, UNSIGNED,
};
use super::units::LARGEST_SUPPLY;
use crate::machine::Machine;

/// What a part of the cost is about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// A number of the machine file, by name.
    Number(&'static str),
    /// What friction and back-EMF take.
    Losses,
    /// The velocity column.
    Velocity,
    /// The command column.
    Command,
    /// The smallest step of the position, and the one that is declared.
    Resolution(f64, f64),
    /// Positions beyond the stops: the farthest.
    Stops(f64),
    /// Jumps of a turn.
    Wrap(Wrap),
    /// The sampling period, s.
    Period(f64),
    /// The winding's time constant, s.
    Winding(f64),
    /// The voltage that the input is read to be, V, beyond every usual supply.
    Supply(f64),
    /// The input has one sign, and with that of what drives the motion the balances leave less open: shares that are left without it
    /// and with it.
    InputSign([f64; 2]),
    /// The current has one sign while the motor is driven forward and backward: its means there, A.
    Sign([f64; 2]),
}

/// A part of the cost.
#[derive(Debug, Clone, Copy)]
pub struct Clue {
    /// What it is about.
    pub subject: Subject,
    /// What it costs, nats.
    pub cost: f64,
    /// What the log asks for over what is declared: the end of the interval that is nearer.
    pub ratio: f64,
    /// How far that is beyond what is allowed, as a logarithm.
    pub excess: f64,
}

/// A range that a data sheet's tolerance allows.
#[derive(Debug, Clone, Copy)]
struct Allowed {
    low: f64,
    declared: f64,
    high: f64,
    deviation: f64,
}

impl Allowed {
    fn within(declared: f64, factor: f64, deviation: f64) -> Self {
        Self {
            low: declared / factor,
            declared,
            high: declared * factor,
            deviation,
        }
    }

    fn number(machine: &Machine, name: &str) -> Self {
        let declared = machine.parameter(name).unwrap_or(0.0);
        let stated = machine.unsure.get(name);
        if machine.fits(name) && stated.is_none() {
            return Self::within(declared, FITTED_FACTOR, FITTED_DEVIATION);
        }
        let stated = stated.copied().unwrap_or(1.0);
        let deviation = STATED_DEVIATION.max(stated.ln());
        Self::within(declared, STATED_FACTOR.max(stated), deviation)
    }

    /// Tolerances of independent numbers add up as their logarithms' squares do.
    fn times(self, other: Self) -> Self {
        let spread = |one: &Self| (one.high / one.declared).ln();
        let factor = spread(&self).hypot(spread(&other)).exp();
        let deviation = self.deviation.max(other.deviation);
        Self::within(self.declared * other.declared, factor, deviation)
    }

    fn over(self, other: Self) -> Self {
        let factor = other.high / other.declared;
        self.times(Self::within(1.0 / other.declared, factor, other.deviation))
    }

    fn plus(self, other: Self) -> Self {
        // The larger of the two is what the sum is sure of.
        let larger = if self.declared > other.declared {
            self
        } else {
            other
        };
        Self {
            low: self.low + other.low,
            declared: self.declared + other.declared,
            high: self.high + other.high,
            deviation: larger.deviation,
        }
    }
}

/// Everything that a reading costs, part by part.
pub fn clues(machine: &Machine, logs: &[Channels], balances: &Balances) -> Vec<Clue> {
    let mut clues = motion(machine, &balances.motion, balances.winding.is_some());
    if let Some(winding) = &balances.winding {
        clues.extend(of_winding(machine, winding));
    }
    if let Some(velocity) = &balances.velocity {
        let one = Allowed::within(1.0, EXACT_FACTOR, EXACT_DEVIATION);
        clues.extend(clue(velocity, Follows::Velocity, one, Subject::Velocity));
    }
    if let Some(command) = &balances.command {
        let one = Allowed::within(1.0, COMMAND_FACTOR, FITTED_DEVIATION);
        let hint = clue(command, Follows::Command, one, Subject::Command);
        clues.extend(hint.map(|hint| Clue {
            cost: hint.cost.min(HINT),
            ..hint
        }));
    }
    clues.extend(impossible(machine, logs, balances));
    clues.extend(resolution(machine, logs));
    clues.extend(supply(machine, logs));
    clues.retain(|clue| clue.cost > 0.0);
    clues.sort_by(|a, b| b.cost.total_cmp(&a.cost));
    clues
}

/// The sum of the parts.
pub fn total(clues: &[Clue]) -> f64 {
    clues.iter().map(|clue| clue.cost).sum()
}

fn motion(machine: &Machine, balance: &Balance, with_current: bool) -> Vec<Clue> {
    let number = |name| Allowed::number(machine, name);
    let one = Allowed::within(1.0, 1.0, 0.0);
    // What is balanced, over the torque.
    let per_torque = match (&machine.motor, with_current) {
        (None, _) => one,
        (Some(_), true) => one.over(number("torque_constant")),
        (Some(_), false) => number("resistance").over(number("torque_constant")),
    };
    let numbers: [(Follows, &'static str); 6] = [
        (Follows::Acceleration, "inertia"),
        (Follows::Velocity, "viscous"),
        (Follows::Direction, "coulomb"),
        (Follows::Position, "spring"),
        (Follows::Side, "spring_preload"),
        (Follows::Sine, "gravity_torque"),
    ];
    let mut clues = Vec::new();
    // A machine that gives off work all the time is read with a wrong sign. One coefficient alone is
    // negative for a delay or an elastic shaft too.
    let gives_work = losses(balance);
    clues.extend(gives_work);
    for (follows, name) in numbers {
        let (mut expected, mut name) = (number(name).times(per_torque), name);
        if follows == Follows::Velocity && machine.motor.is_some() && !with_current {
            let constant = number("torque_constant");
            if constant.declared > expected.declared {
                name = "torque_constant";
            }
            expected = expected.plus(constant);
        }
        // What is declared as nothing is what may be missing.
        if expected.declared > 0.0 {
            let clue = clue(balance, follows, expected, Subject::Number(name));
            let clue = clue.filter(|clue| clue.ratio > 0.0 || gives_work.is_some());
            clues.extend(clue.and_then(|clue| weighed(clue, name, machine)));
        }
    }
    clues
}

/// What a clue on a number is worth beside the effects that may be missing.
fn weighed(clue: Clue, name: &str, machine: &Machine) -> Option<Clue> {
    let is_elastic = matches!(name, "spring" | "spring_preload" | "gravity_torque");
    // More spring or weight than is declared, and of any sign, is an effect that may be missing.
    if is_elastic && !(0.0..1.0).contains(&clue.ratio) {
        return None;
    }
    let is_guess = is_elastic || machine.fits(name);
    // So is more friction that grows with the speed.
    let is_drag = name == "viscous" && clue.ratio > 1.0;
    let is_near = clue.ratio > 0.0 && clue.excess < FAR_OFF.ln();
    let most = if is_drag || (is_guess && is_near) {
        BAD_GUESS
    } else {
        f64::INFINITY
    };
    Some(Clue {
        cost: clue.cost.min(most),
        ..clue
    })
}

/// What it costs that friction and back-EMF together drive the machine instead of braking it.
fn losses(balance: &Balance) -> Option<Clue> {
    let share = balance.share(Follows::Losses)?;
    let floor = FLOOR * balance.rms;
    let most = share.interval.1 * share.rms;
    if floor == 0.0 || most >= -floor {
        return None;
    }
    let excess = ((-most - floor) / floor).asinh();
    let deviations = excess / STATED_DEVIATION;
    Some(Clue {
        subject: Subject::Losses,
        cost: 0.5 * deviations * deviations,
        ratio: -1.0,
        excess,
    })
}

fn of_winding(machine: &Machine, balance: &Balance) -> Vec<Clue> {
    let numbers = [
        (Follows::Current, "resistance"),
        (Follows::Velocity, "torque_constant"),
        (Follows::CurrentRate, "inductance"),
    ];
    let mut clues = Vec::new();
    for (follows, name) in numbers {
        let mut expected = Allowed::number(machine, name);
        if name == "inductance" {
            expected = Allowed::within(expected.declared, INDUCTANCE_FACTOR, STATED_DEVIATION);
        }
        if expected.declared > 0.0 {
            clues.extend(clue(balance, follows, expected, Subject::Number(name)));
        }
    }
    clues
}

/// What a coefficient costs, if it is outside what is allowed.
///
/// Shares of the balance below [`FLOOR`] say nothing: sizes are compared as asinh(share / floor), which is
/// the logarithm for large ones. A share that is allowed to be small and is large is compared, if that says
/// more, by what is left of it when an effect that is missing takes the floor.
fn clue(balance: &Balance, follows: Follows, allowed: Allowed, subject: Subject) -> Option<Clue> {
    let share = balance.share(follows)?;
    let floor = FLOOR * balance.rms;
    if floor == 0.0 || share.rms == 0.0 {
        return None;
    }
    let (low, high) = (share.interval.0 * share.rms, share.interval.1 * share.rms);
    let (least, most) = (allowed.low * share.rms, allowed.high * share.rms);
    let size = |value: f64| (value / floor).asinh();
    let (excess, deviation, nearer) = if high < -floor {
        // Of the wrong sign: that is no matter of a guess.
        let excess = size(least) - size(high + floor);
        (
            excess,
            allowed.deviation.min(STATED_DEVIATION),
            share.interval.1,
        )
    } else if high < least {
        (
            size(least) - size(high),
            allowed.deviation,
            share.interval.1,
        )
    } else if low > most {
        let left = ((low - floor) / most).ln();
        let excess = (size(low) - size(most)).max(left);
        (excess, allowed.deviation, share.interval.0)
    } else {
        return None;
    };
    let deviations = excess / deviation;
    Some(Clue {
        subject,
        cost: 0.5 * deviations * deviations,
        ratio: nearer / allowed.declared,
        excess,
    })
}

/// What no machine does: jump by a turn, go far beyond its stops, show itself in a sample a second, draw a current of one sign
/// whichever way it is driven.
fn impossible(machine: &Machine, logs: &[Channels], balances: &Balances) -> Vec<Clue> {
    let cost = |subject| Clue {
        subject,
        cost: IMPOSSIBLE,
        ratio: f64::NAN,
        excess: 0.0,
    };
    let mut clues = Vec::new();
    let period = logs[0].period;
    if !(SHORTEST_PERIOD..=LONGEST_PERIOD).contains(&period) {
        clues.push(cost(Subject::Period(period)));
    }
    if let Some(motor) = &machine.motor
        && motor.inductance > LONGEST_WINDING * motor.resistance
    {
        clues.push(cost(Subject::Winding(motor.inductance / motor.resistance)));
    }
    clues.extend(channels::wrap(logs).map(|wrap| cost(Subject::Wrap(wrap))));
    // The size of a current, or that of the supply, which a bridge turns round for the motor.
    let has_one_sign =
        |[one, other]: &[f64; 2]| (UNSIGNED..=UNSIGNED.recip()).contains(&(one / other));
    let unsigned = balances.drawn.filter(has_one_sign);
    clues.extend(unsigned.map(|means| cost(Subject::Sign(means))));
    clues.extend(lost_sign(machine, logs, balances).map(|shares| cost(Subject::InputSign(shares))));
    let mechanics = &machine.mechanics;
    if let (Some(lower), Some(upper)) = (mechanics.lower_stop, mechanics.upper_stop) {
        let slack = BEYOND_STOPS * (upper - lower);
        let positions = || logs.iter().flat_map(|log| log.position.iter().copied());
        let beyond = |position: &f64| *position < lower - slack || *position > upper + slack;
        let count = positions().filter(beyond).count();
        if count as f64 > GLITCHES * positions().count() as f64 {
            let middle = 0.5 * (lower + upper);
            let farther = |a: &f64, b: &f64| (a - middle).abs().total_cmp(&(b - middle).abs());
            let farthest = positions().max_by(farther).unwrap_or(middle);
            clues.push(cost(Subject::Stops(farthest)));
        }
    }
    clues
}

/// What the balances leave open, without the sign of the input and with it, where it seems to have lost it.
fn lost_sign(machine: &Machine, logs: &[Channels], balances: &Balances) -> Option<[f64; 2]> {
    if !channels::may_lack_sign(logs) {
        return None;
    }
    let mut signed = logs.to_vec();
    for log in &mut signed {
        log.sign_input(machine.motor.as_ref());
    }
    let (without, with) = (
        balances.unexplained(),
        Balances::of(&signed, machine).unexplained(),
    );
    (with <= (1.0 - LEAST_SAVING) * without).then_some([without, with])
}

fn resolution(machine: &Machine, logs: &[Channels]) -> Option<Clue> {
    let declared = machine.resolution?;
    let step = channels::quantum(logs)?;
    let excess = (step / declared).ln().abs() - FITTED_FACTOR.ln();
    let deviations = excess.max(0.0) / FITTED_DEVIATION;
    Some(Clue {
        subject: Subject::Resolution(step, declared),
        cost: (0.5 * deviations * deviations).min(HINT),
        ratio: step / declared,
        excess,
    })
}

/// What it costs that no usual supply gives as much voltage as the input is read to be.
fn supply(machine: &Machine, logs: &[Channels]) -> Option<Clue> {
    machine.motor.as_ref()?;
    let volts = channels::largest_input(logs) * machine.gain.abs();
    let excess = (volts / LARGEST_SUPPLY).ln();
    let deviations = excess.max(0.0) / SUPPLY_DEVIATION;
    Some(Clue {
        subject: Subject::Supply(volts),
        cost: 0.5 * deviations * deviations,
        ratio: volts / LARGEST_SUPPLY,
        excess,
    })
}
