//! That the encoder follows the rotor, before a loop is closed over it: the rotor is pushed a little either way, and the encoder
//! has to move with each push.
//!
//! A push raises the motor's current from 0 to *I* in a time *T*, holds it there for as long, and ends as soon as the encoder has
//! come [`LINE`] counts the push's way from where it was farthest the other way. Both are seen before the loop is closed.
//!
//! What that proves: under a constant load an encoder that counts backwards comes no line against both pushes. It would have to see
//! the rotor go down under the current that pushes it up, by its load alone, and up under the one that pushes it down. An
//! encoder of which one line is dead comes one count at most. The scale is not proven: `home` compares it.
//!
//! A rotor that is pushed against a stop does not move, and a rotor that its friction holds, or its load, moves under *I* at the latest:
//!
//! I = ((1 + δm)(breakaway + s) + T_load)/((1 − δk) k) + 2 n q (1 + δJ) J/(T² (1 − δk) k),
//!
//! with the most torque *s* of the return spring within the stroke. The second part has the heaviest rotor, with the weakest
//! magnets and held by all that is declared, come *n* steps of *q* rad while it is held. So a push that has moved nothing
//! was towards a stop, or the encoder is lost. The next one is away from the stop, and the one behind it comes back. A
//! second push that moves nothing is [`Fault::FollowingError`]: what keeps both ways from moving is not told from an encoder that stands
//! still. An encoder that has gone a line against a push, and goes faster under *I*, or has not turned after
//! `PATIENCE` T, is [`Fault::EncoderImplausible`].
//!
//! # Constants
//! *T* lets the lightest rotor with the strongest magnets, which nothing holds, move by `SHARE` of the stroke while the current is
//! raised: x = (1 + δk) k I T²/(6 (1 − δJ) J). While it is held such a rotor moves six times as far.
//!
//! A load may drive the rotor against a push at first. Under *I* it is braked, by the push and by friction, and turns; an encoder that counts
//! backwards sees a rotor that goes faster and faster.

use crate::app::fault::Fault;
use crate::app::fault::observer::Tolerances;
use crate::app::machine::Machine;
use crate::app::square_root::square_root;
use crate::app::timing::CONTROL_PERIOD;

/// A line of the encoder: all four edges of its two tracks.
pub const LINE: i32 = 4;

/// Of the stroke, for *T*: a rotor that nothing holds, and whose encoder stands still, goes seven times as far in a push.
const SHARE: f32 = 0.01;

/// How long a rotor that its load drives may take to turn, in *T*. The lightest one of the 24 V actuator is brought to 22 rad/s at most, by its
/// load and the push before over a line and by its load while the current is raised; *I* and the least friction turn it within 7 ms. That is 3 T
/// in all, and this more than twice that.
const PATIENCE: u32 = 8;

/// Control steps in which the loop holds the actuator first: until the brake is open. Brakes of motors up to 2 kW take 100 ms
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
}

/// A push under way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Push {
    upwards: bool,
    steps: u32,
    began: i32,
    /// Farthest against the push, in counts.
    farthest: i32,
    /// Counts of the step before.
    before: i32,
    /// Way of the control period before, in counts.
    way: i32,
}

/// A check under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Check {
    waits: u32,
    /// Control steps since the last push, once both ways were seen.
    settles: u32,
    push: Option<Push>,
    /// Whether the encoder has come a line downwards and upwards.
    came: [bool; 2],
    /// Whether a push has moved nothing.
    was_held: bool,
}

/// What a control step of it says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// The brake is not open yet: the actuator is held.
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
        let load = (1.0 + mechanics) * spring[0].max(spring[1]) + machine.limits.load;
        let held = (1.0 + mechanics) * friction + load;
        let least = (1.0 - weaker) * torque_constant;
        let most = (1.0 + weaker) * torque_constant;
        let lightest = (1.0 - heavier) * plant.inertia;
        let time = square_root(6.0 * lightest * travel / (most * held / least));
        // At least one; the cast takes the fraction off, and makes 0 of what is not a number.
        let steps = ((time / CONTROL_PERIOD).min(MOST_STEPS) as u32).max(1);
        let time = steps as f32 * CONTROL_PERIOD;
        let moved = 2.0 * LINE as f32 * unit * (1.0 + heavier) * plant.inertia / (time * time);
        Self {
            current: ((held + moved) / least).min(machine.limits.current()),
            steps,
        }
    }
}

impl Push {
    fn new(upwards: bool, counts: i32) -> Self {
        Self {
            upwards,
            steps: 0,
            began: counts,
            farthest: counts,
            before: counts,
            way: 0,
        }
    }

    /// How many counts it goes the push's way from one reading to another.
    fn way(&self, from: i32, to: i32) -> i32 {
        let way = to.wrapping_sub(from);
        if self.upwards {
            way
        } else {
            way.wrapping_neg()
        }
    }
}

impl Default for Check {
    fn default() -> Self {
        Self {
            waits: BRAKE_STEPS,
            settles: 0,
            push: None,
            came: [false; 2],
            was_held: false,
        }
    }
}

impl Check {
    /// Takes the encoder's counts, and whether a limit switch keeps the drive from going down and up: there nothing is pushed.
    pub fn step(&mut self, numbers: &Coefficients, counts: i32, barred: [bool; 2]) -> Step {
        if self.waits > 0 {
            self.waits -= 1;
            return Step::Wait;
        }
        if self.came == [true; 2] {
            self.settles += 1;
            return if self.settles < numbers.steps {
                Step::Settle
            } else {
                Step::Follows
            };
        }
        let mut push = self.push.unwrap_or(Push::new(true, counts));
        if push.way(push.farthest, counts) < 0 {
            push.farthest = counts;
        }
        let way = push.way(push.before, counts);
        let goes_faster = way < push.way.min(0);
        push.way = way;
        push.before = counts;
        let is_astray = push.way(counts, push.began) >= LINE;
        let is_over = push.steps >= 2 * numbers.steps && !is_astray;
        let came = push.way(push.farthest, counts) >= LINE || barred[usize::from(push.upwards)];
        if came {
            self.came[usize::from(push.upwards)] = true;
            if self.came == [true; 2] {
                return Step::Settle;
            }
        } else if is_astray
            // Both periods were driven by all of the current.
            && (goes_faster && push.steps > numbers.steps + 1
                || push.steps >= PATIENCE * numbers.steps)
        {
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
