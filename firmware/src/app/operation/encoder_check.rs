//! That the encoder follows the rotor, before a loop is closed over it: the rotor is pushed a little either way, and the encoder
//! has to move with each push.
//!
//! Until the brake is open the voltage is 0. Where a load moves the rotor before that, the first push begins at once.
//! A push raises the motor's current from 0 to *I* in a time *T*, holds it there for as long, and ends as soon as the encoder has
//! come a line of the encoder, four counts, the push's way from where it was farthest the other way. What may be
//! the rotor's coasting from the push before is not counted. Both are seen before the loop is closed.
//!
//! What that proves: under a constant load an encoder that counts backwards comes no line against both pushes. It would have to see
//! the rotor go down under the current that pushes it up, by its load alone, and up under the one that pushes it down. An
//! encoder of which one line is dead comes one count at most. The scale is not proven: `home` compares it.
//!
//! With a limit switch open nothing is pushed towards it. The only push that is left then counts once the encoder has gone faster and faster
//! the push's way under *I*: what a load does while the current is raised proves nothing.
//!
//! A rotor that is pushed against a stop does not move, and a rotor that its friction holds, or its load, moves under *I* at the latest:
//!
//! I = ((1 + δm)(breakaway + s) + (1 + ε) T_load)/((1 − δk) k) + 2 n q (1 + δJ) J/(T² (1 − δk) k),
//!
//! with
//!
//! - δm, δk and δJ: how far friction and spring, the torque constant *k* and the inertia *J* may be off, as shares of what is declared;
//! - *s*: the most torque of the return spring within the stroke;
//! - T_load: the load that is declared;
//! - ε = 1/8: a load that nothing else brakes has a rotor at T_load T/(2 J) at most when *I* is reached, and (1 − ε)/(2 ε) T = 3.5 T
//!   later *I* has turned it;
//! - *n* = 4: counts of a line, and *q*: the rad of a count. The second part has the heaviest rotor, with the weakest
//!   magnets and held by all that is declared, come *n* counts in *T* under *I*.
//!
//! So a push that has moved nothing was towards a stop, or the encoder is lost. The next one is away from the stop, and the one behind
//! it comes back. A second push that moves nothing is [`Fault::FollowingError`]: what keeps both ways from moving is not told from an
//! encoder that stands still. An encoder that has gone a line against a push, and goes faster under *I*, or has not come back
//! `PATIENCE` T after the push began, is [`Fault::EncoderImplausible`].
//!
//! # What goes faster
//! Under *I* a rotor accelerates the push's way, all the time. So the ways of equal times one after another never become less, but for what
//! the encoder rounds. Each way is the difference of two positions, each rounded by half a count at most: two ways differ by up to 2 counts less
//! than the rotor's. What differs by more than that is the rotor's. It is looked for in single control periods, where a light rotor shows it
//! at once, and in times of T/2, in which the slowest one goes 2 counts more each time.
//!
//! # What coasts
//! Under a push the rotor's speed changes the push's way, all the time. So an encoder that goes against a push, and then with it, has turned with the
//! rotor. One that goes with a push from its beginning may show what the push before has left: where a load has answered that one, over an encoder that
//! counts backwards, it ends while the rotor still falls, or less than a control period *h* after it has turned the rotor. That leaves a speed
//! of k I h/J at most. The next push takes k I t²/(2 T J) of it until *t*, all of it until √(2 T h). What goes with a push alone is counted from then on.
//!
//! # Constants
//! *T* lets the lightest rotor with the strongest magnets, which nothing holds, move by `SHARE` of the stroke while the current is
//! raised: x = (1 + δk) k I T²/(6 (1 − δJ) J). While it is held such a rotor moves six times as far.

use crate::app::fault::Fault;
use crate::app::fault::observer::Tolerances;
use crate::app::machine::Machine;
use crate::app::square_root::square_root;
use crate::app::timing::CONTROL_PERIOD;

/// A line of the encoder: all four edges of its two tracks.
const LINE: i32 = 4;

/// Of the stroke, for *T*: a rotor that nothing holds, and whose encoder stands still, goes seven times as far in a push.
const SHARE: f32 = 0.01;

/// By how many counts two ways of an encoder differ at most that are the same for the rotor: each is the difference of two rounded positions.
const ROUNDING: i32 = 2;

/// Of the load, what *I* brakes it with beyond holding it.
const BRAKING: f32 = 0.125;

/// How long a push against a load that drives the rotor may take until it comes back, in *T*. What a load has driven while the current was raised is
/// turned 4.5 T behind the push's beginning, and what the push before had driven besides, over a line, takes 1 T more. It has come a line back within
/// another one. That is 6.5 T, and this nearly twice that.
const PATIENCE: u32 = 12;

/// Control steps in which the brake opens. Brakes of motors up to 2 kW take 100 ms
/// (Yaskawa Σ-V, user's manual, "Holding Brakes": SGMGV-05 to -20).
const BRAKE_STEPS: u32 = 100;

/// Most of *T*, in control periods, for an actuator whose stroke has no end.
const MOST_STEPS: f32 = 100.0;

/// The numbers of a push.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    /// *I*, A.
    current: f32,
    /// *T*, in control steps.
    steps: u32,
    /// Control steps of a push in which the rotor may still coast from the push before.
    coasting: u32,
}

/// The ways of equal times, one after another, under all of the current.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ways {
    /// A time, in control steps.
    length: u32,
    /// Steps of the one that is under way.
    steps: u32,
    from: i32,
    /// The least and the most way of those before, in counts.
    seen: Option<[i32; 2]>,
    /// Whether the encoder has gone faster against the push, and with it, by more than it rounds.
    faster: [bool; 2],
}

/// A push under way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Push {
    upwards: bool,
    steps: u32,
    began: i32,
    /// Farthest against the push, in counts.
    farthest: i32,
    /// From when all of the current flows: of single control steps, and of T/2.
    ways: Option<[Ways; 2]>,
}

/// A check under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Check {
    waits: u32,
    /// Where it waited first, in counts.
    waited_at: Option<i32>,
    /// Control steps since the last push, once both ways were seen.
    settles: u32,
    push: Option<Push>,
    /// Whether a limit switch that kept the drive from going down and up was open at any time.
    barred: [bool; 2],
    /// Whether the encoder has come a line downwards and upwards.
    came: [bool; 2],
    /// Whether a push has moved nothing.
    was_held: bool,
}

/// What a control step of it says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// The brake is not open yet: no voltage.
    Wait,
    /// A current, A.
    Push(f32),
    /// Both pushes are over, and the rotor comes to rest, maybe at the stop from which it came: the actuator is held.
    Settle,
    /// The encoder follows the rotor.
    Follows,
    /// It does not, or nothing moves.
    Failed(Fault),
}

impl Coefficients {
    /// For a machine with a winding of this torque constant, N·m/A.
    pub fn new(machine: &Machine, torque_constant: f32) -> Self {
        let Tolerances {
            torque_constant: weaker,
            inertia: heavier,
            mechanics,
            ..
        } = Tolerances::INDUSTRIAL;
        let plant = &machine.plant;
        let unit = machine.converters.position.unit();
        let travel = SHARE * (plant.upper_stop - plant.lower_stop);
        let spring = [plant.lower_stop, plant.upper_stop]
            .map(|stop| plant.spring * (stop - plant.spring_rest).abs() + plant.spring_preload);
        let friction = plant.breakaway.forward.max(plant.breakaway.backward);
        let load =
            (1.0 + mechanics) * spring[0].max(spring[1]) + (1.0 + BRAKING) * machine.limits.load;
        let held = (1.0 + mechanics) * friction + load;
        let least = (1.0 - weaker) * torque_constant;
        let most = (1.0 + weaker) * torque_constant;
        let lightest = (1.0 - heavier) * plant.inertia;
        let time = square_root(6.0 * lightest * travel / (most * held / least));
        // At least one. Of what is not a number the minimum is the other one; the cast takes the fraction off.
        let steps = ((time / CONTROL_PERIOD).min(MOST_STEPS) as u32).max(1);
        let time = steps as f32 * CONTROL_PERIOD;
        let moved = 2.0 * LINE as f32 * unit * (1.0 + heavier) * plant.inertia / (time * time);
        Self {
            current: ((held + moved) / least).min(machine.limits.current()),
            steps,
            // The cast takes the fraction off.
            coasting: square_root(2.0 * steps as f32) as u32 + 1,
        }
    }

    /// Control steps of a push from which all of the current flows, and all that the encoder goes is counted.
    fn raised(&self) -> u32 {
        self.steps.max(self.coasting)
    }
}

/// How many counts it is from one reading to another, up or down.
fn way(upwards: bool, from: i32, to: i32) -> i32 {
    let way = to.wrapping_sub(from);
    if upwards { way } else { way.wrapping_neg() }
}

impl Ways {
    fn new(length: u32, from: i32) -> Self {
        Self {
            length,
            steps: 0,
            from,
            seen: None,
            faster: [false; 2],
        }
    }

    /// Takes a reading in a push that goes this way.
    fn step(&mut self, upwards: bool, counts: i32) {
        self.steps += 1;
        if self.steps < self.length {
            return;
        }
        let way = way(upwards, self.from, counts);
        if let Some([least, most]) = self.seen {
            self.faster[0] |= way < -ROUNDING && way < most.saturating_sub(ROUNDING);
            self.faster[1] |= way > ROUNDING && way > least.saturating_add(ROUNDING);
            self.seen = Some([least.min(way), most.max(way)]);
        } else {
            self.seen = Some([way; 2]);
        }
        self.steps = 0;
        self.from = counts;
    }
}

impl Push {
    fn new(upwards: bool, counts: i32) -> Self {
        Self {
            upwards,
            steps: 0,
            began: counts,
            farthest: counts,
            ways: None,
        }
    }

    /// How many counts it goes the push's way from one reading to another.
    fn way(&self, from: i32, to: i32) -> i32 {
        way(self.upwards, from, to)
    }

    /// Takes a reading: whether the encoder has gone faster against the push, and with it, under all of the current.
    fn goes_faster(&mut self, numbers: &Coefficients, counts: i32) -> [bool; 2] {
        let upwards = self.upwards;
        if let Some(ways) = &mut self.ways {
            for ways in ways {
                ways.step(upwards, counts);
            }
        } else if self.steps >= numbers.steps {
            let half = (numbers.steps / 2).max(1);
            self.ways = Some([1, half].map(|length| Ways::new(length, counts)));
        }
        let any = |side: usize| {
            self.ways
                .is_some_and(|ways| ways.iter().any(|ways| ways.faster[side]))
        };
        [any(0), any(1)]
    }
}

impl Default for Check {
    fn default() -> Self {
        Self {
            waits: BRAKE_STEPS,
            waited_at: None,
            settles: 0,
            push: None,
            barred: [false; 2],
            came: [false; 2],
            was_held: false,
        }
    }
}

impl Check {
    /// Which way is away from a limit switch that was open: whether upwards. None if no switch was.
    pub(super) fn away(&self) -> Option<bool> {
        let [lower, upper] = self.barred;
        (lower || upper).then_some(lower)
    }

    /// Takes the encoder's counts, and whether a limit switch keeps the drive from going down and up: there nothing is pushed,
    /// also when the push away from the switch has closed it.
    pub(super) fn step(&mut self, numbers: &Coefficients, counts: i32, barred: [bool; 2]) -> Step {
        if self.waits > 0 {
            let moved = counts.wrapping_sub(*self.waited_at.get_or_insert(counts));
            // What its load moves has no brake any more.
            self.waits = if moved.wrapping_abs() < LINE {
                self.waits - 1
            } else {
                0
            };
            if self.waits > 0 {
                return Step::Wait;
            }
        }
        if self.came == [true; 2] {
            self.settles += 1;
            return if self.settles < numbers.steps {
                Step::Settle
            } else {
                Step::Follows
            };
        }
        self.barred = [self.barred[0] || barred[0], self.barred[1] || barred[1]];
        let mut push = self.push.unwrap_or(Push::new(true, counts));
        let turned = push.way(push.began, push.farthest) < 0;
        let is_first = self.came == [false; 2];
        let coasts = !is_first && !turned && push.steps <= numbers.coasting;
        if coasts || push.way(push.farthest, counts) < 0 {
            push.farthest = counts;
        }
        let [against, with] = push.goes_faster(numbers, counts);
        let astray = push.way(push.farthest, push.began);
        let came_a_line = push.way(push.farthest, counts) >= LINE;
        let side = usize::from(push.upwards);
        let came = self.barred[side] || came_a_line && (with || !self.barred[1 - side]);
        // An encoder of which one line is dead goes one count.
        let moves = came_a_line || astray > 1;
        let is_over = push.steps >= numbers.steps + numbers.raised() && !moves;
        if came {
            self.came[side] = true;
            if self.came == [true; 2] {
                return Step::Settle;
            }
        } else if astray >= LINE && against || push.steps >= PATIENCE * numbers.steps {
            return Step::Failed(Fault::EncoderImplausible);
        } else if is_over {
            if self.was_held {
                return Step::Failed(Fault::FollowingError);
            }
            self.was_held = true;
        }
        if came || is_over {
            push = Push::new(!push.upwards, counts);
        }
        push.steps += 1;
        self.push = Some(push);
        let share = (push.steps as f32 / numbers.steps as f32).min(1.0);
        let current = share * numbers.current;
        Step::Push(if push.upwards { current } else { -current })
    }
}
