//! Motor, brake and encoder gear in motion, and their integrator.
//!
//! Between events the plant is smooth and advances by the explicit midpoint rule (second order) at
//! 31.25 µs or less, under voltages that are held. Three kinds of event end a smooth stretch, each
//! placed inside its step by linear interpolation, which keeps the second order: a speed reaches
//! zero, a load exceeds static friction, the teeth meet. Motor and encoder gear stick truly: speed 0
//! and a constant angle until the load exceeds static friction. The brake's torque over the angle is
//! its tangent, drawn anew every few milliradians.

use super::GEAR_RATIO;
use super::brake::Brake;
use super::encoder_gear::{Contact, EncoderGear};
use super::loss::Loss;
use super::motor::Motor;

/// Default and largest integration step, s: of the order of the fastest time, that of the encoder gear on
/// the damping of its teeth.
pub(super) const STEP: f64 = 31.25e-6;

/// How far a tangent to the brake's torque is followed, rad of the motor: its error is under a
/// millionth of the torque.
const TANGENT_REACH: f64 = 5.0e-3;

/// Least share of a step that an event leaves over: rounding may put it at the step's very start.
const LEAST_SHARE: f64 = 1.0e-3;

/// What the integrator carries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// A rms.
    pub current_d: f64,
    /// A rms.
    pub current_q: f64,
    /// Of the motor shaft, rad/s.
    pub speed: f64,
    /// Of the motor shaft, rad.
    pub angle: f64,
    /// Of the encoder gear, referred to the slow shaft, rad/s; 0 with rigid teeth.
    pub encoder_speed: f64,
    /// Of the encoder gear, referred to the slow shaft, rad.
    pub encoder_angle: f64,
}

impl State {
    /// self + seconds · rate.
    fn plus(&self, rate: &Self, seconds: f64) -> Self {
        Self {
            current_d: self.current_d + seconds * rate.current_d,
            current_q: self.current_q + seconds * rate.current_q,
            speed: self.speed + seconds * rate.speed,
            angle: self.angle + seconds * rate.angle,
            encoder_speed: self.encoder_speed + seconds * rate.encoder_speed,
            encoder_angle: self.encoder_angle + seconds * rate.encoder_angle,
        }
    }
}

/// Whether a body moves, and which way: the sign of its friction while it does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Motion {
    Stuck,
    Sliding(f64),
}

impl Motion {
    /// Acceleration under `load` and friction of `level`.
    fn acceleration(self, load: f64, level: f64, inertia: f64) -> f64 {
        match self {
            Self::Stuck => 0.0,
            Self::Sliding(sign) => (load - sign * level) / inertia,
        }
    }

    /// Sliding in the direction of `load` if that exceeds what static friction holds.
    fn begin(self, load: f64, holding: f64) -> Self {
        match self {
            Self::Stuck if load.abs() > holding => Self::Sliding(load.signum()),
            other => other,
        }
    }
}

/// Where a value that goes from `before` to `after` passes zero, 0 to 1.
fn crossing(before: f64, after: f64) -> f64 {
    before / (before - after)
}

/// What ends a smooth stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    Motor,
    Gear,
    Teeth,
}

/// The bench without control and sensors.
#[derive(Debug, Clone)]
pub struct Plant {
    motor: Motor,
    brake: Brake,
    loss: Loss,
    gear: EncoderGear,
    step: f64,
    state: State,
    motor_motion: Motion,
    gear_motion: Motion,
    /// Of the brake over the motor's angle.
    tangent: Tangent,
}

/// A line: value at an angle, and slope.
#[derive(Debug, Clone, Copy)]
struct Tangent {
    angle: f64,
    value: f64,
    slope: f64,
}

impl Tangent {
    fn at(&self, angle: f64) -> f64 {
        self.value + self.slope * (angle - self.angle)
    }
}

impl Plant {
    /// At rest at 0 with the encoder gear in the middle of its play.
    pub fn new(motor: Motor, brake: Brake, loss: Loss, gear: EncoderGear) -> Self {
        Self {
            motor,
            brake,
            loss,
            gear,
            step: STEP,
            state: State::default(),
            motor_motion: Motion::Stuck,
            gear_motion: Motion::Stuck,
            tangent: tangent(&brake, 0.0),
        }
    }

    /// Integrated in steps of at most `step` seconds.
    pub fn with_step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// Puts it elsewhere.
    pub fn place(&mut self, state: State) {
        let motion = |speed: f64| {
            if speed == 0.0 {
                Motion::Stuck
            } else {
                Motion::Sliding(speed.signum())
            }
        };
        self.motor_motion = motion(state.speed);
        self.gear_motion = motion(state.encoder_speed);
        self.tangent = tangent(&self.brake, state.angle);
        self.state = state;
    }

    /// Where it is.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Of the motor, N·m.
    pub fn motor_torque(&self) -> f64 {
        self.torque(self.state.current_q)
    }

    /// What the brake holds against at the motor shaft, N·m: its level while it slides, its share of
    /// the load while the shaft stands.
    pub fn brake_torque(&self) -> f64 {
        let state = &self.state;
        let level = self.tangent.at(state.angle);
        match self.motor_motion {
            Motion::Sliding(sign) => sign * level,
            Motion::Stuck if level == 0.0 => 0.0,
            Motion::Stuck => {
                let teeth = self.teeth(state);
                self.motor_load(state, teeth) * level / self.holding(state, teeth)
            }
        }
    }

    /// Lets `seconds` pass under the voltages (v_d, v_q), V rms.
    pub fn advance(&mut self, voltage: (f64, f64), seconds: f64) {
        let mut left = seconds;
        while left > 1.0e-9 * self.step {
            left -= self.stretch(voltage, left.min(self.step));
        }
    }

    /// One step of `seconds`, or the part of it up to the first event; returns its length.
    fn stretch(&mut self, voltage: (f64, f64), seconds: f64) -> f64 {
        let before = self.state;
        if (before.angle - self.tangent.angle).abs() > TANGENT_REACH {
            self.tangent = tangent(&self.brake, before.angle);
        }
        let teeth = self.teeth(&before);
        self.motor_motion = self.motor_motion.begin(
            self.motor_load(&before, teeth),
            self.holding(&before, teeth),
        );
        self.gear_motion = self.gear_motion.begin(teeth, self.gear.starting_torque);

        let after = self.midpoint(&before, voltage, seconds);
        let Some((event, share)) = self.first_event(&before, &after) else {
            self.state = self.carried(after);
            return seconds;
        };
        let share = share.clamp(LEAST_SHARE, 1.0);
        let mut state = self.midpoint(&before, voltage, share * seconds);
        match (event, self.motor_motion, self.gear_motion) {
            (Event::Motor, Motion::Sliding(_), _) => {
                state.speed = 0.0;
                self.motor_motion = Motion::Stuck;
            }
            (Event::Gear, _, Motion::Sliding(_)) => {
                state.encoder_speed = 0.0;
                self.gear_motion = Motion::Stuck;
            }
            // Breakaway is decided at the start of the next stretch, as is the teeth's torque.
            _ => {}
        }
        self.state = self.carried(state);
        share * seconds
    }

    fn first_event(&self, before: &State, after: &State) -> Option<(Event, f64)> {
        [
            (Event::Motor, self.motor_event(before, after)),
            (Event::Gear, self.gear_event(before, after)),
            (Event::Teeth, self.meeting(before, after)),
        ]
        .into_iter()
        .filter_map(|(event, share)| share.map(|share| (event, share)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Where in a step the motor comes to rest or breaks away.
    fn motor_event(&self, before: &State, after: &State) -> Option<f64> {
        if let Motion::Sliding(sign) = self.motor_motion {
            return (sign * after.speed < 0.0).then(|| crossing(before.speed, after.speed));
        }
        let excess = |state| {
            let teeth = self.teeth(state);
            self.motor_load(state, teeth).abs() - self.holding(state, teeth)
        };
        let after = excess(after);
        (after > 0.0).then(|| crossing(excess(before), after))
    }

    /// Where in a step the encoder gear comes to rest or breaks away.
    fn gear_event(&self, before: &State, after: &State) -> Option<f64> {
        if let Motion::Sliding(sign) = self.gear_motion {
            return (sign * after.encoder_speed < 0.0)
                .then(|| crossing(before.encoder_speed, after.encoder_speed));
        }
        let excess = |state| self.teeth(state).abs() - self.gear.starting_torque;
        let after = excess(after);
        (after > 0.0).then(|| crossing(excess(before), after))
    }

    /// Where in a step the teeth meet: damping makes their torque jump there.
    fn meeting(&self, before: &State, after: &State) -> Option<f64> {
        let half = 0.5 * self.gear.clearance;
        if self.gear.contact == Contact::Rigid {
            return None;
        }
        let (lead, next) = (lead(before), lead(after));
        [1.0, -1.0].into_iter().find_map(|side| {
            let (gap, next_gap) = (half - side * lead, half - side * next);
            (gap > 0.0 && next_gap < 0.0).then(|| crossing(gap, next_gap))
        })
    }

    /// Rigid teeth carry the encoder gear along.
    fn carried(&self, mut state: State) -> State {
        if self.gear.contact == Contact::Rigid {
            let half = 0.5 * self.gear.clearance;
            let slow = state.angle / GEAR_RATIO;
            state.encoder_angle = state.encoder_angle.clamp(slow - half, slow + half);
        }
        state
    }

    fn midpoint(&self, state: &State, voltage: (f64, f64), seconds: f64) -> State {
        let middle = state.plus(&self.rate(state, voltage), 0.5 * seconds);
        state.plus(&self.rate(&middle, voltage), seconds)
    }

    /// d(state)/dt in the present motion.
    fn rate(&self, state: &State, (v_d, v_q): (f64, f64)) -> State {
        let motor = &self.motor;
        let teeth = self.teeth(state);
        let electrical_speed = motor.pole_pairs * state.speed;
        // Three phases of EMF and current in phase make the mechanical power.
        let emf =
            motor.torque_constant * self.loss.torque_share(state.current_q) * state.speed / 3.0;
        State {
            current_d: (v_d - motor.resistance * state.current_d) / motor.inductance
                + electrical_speed * state.current_q,
            current_q: (v_q - motor.resistance * state.current_q - emf) / motor.inductance
                - electrical_speed * state.current_d,
            speed: self.motor_motion.acceleration(
                self.motor_load(state, teeth),
                self.friction(state, teeth, motor.coulomb),
                motor.inertia,
            ),
            angle: state.speed,
            encoder_speed: self.gear_motion.acceleration(
                teeth,
                self.gear.running_torque,
                self.gear.inertia,
            ),
            encoder_angle: state.encoder_speed,
        }
    }

    fn torque(&self, current_q: f64) -> f64 {
        self.motor.torque_constant * self.loss.torque_share(current_q) * current_q
    }

    /// Torque on the motor shaft but for dry friction, N·m.
    fn motor_load(&self, state: &State, teeth: f64) -> f64 {
        self.torque(state.current_q) - self.motor.viscous * state.speed - teeth / GEAR_RATIO
    }

    /// Dry friction at the motor shaft, N·m: a tare, the brake, and what transmitting the brake's and
    /// the teeth's torque costs.
    fn friction(&self, state: &State, teeth: f64, tare: f64) -> f64 {
        let brake = self.tangent.at(state.angle);
        let transmitted = brake + teeth.abs() / GEAR_RATIO;
        tare + brake + self.loss.friction_ratio() * transmitted
    }

    /// Static friction at the motor shaft, N·m.
    fn holding(&self, state: &State, teeth: f64) -> f64 {
        self.friction(state, teeth, self.motor.static_friction)
    }

    /// Torque of the teeth on the encoder gear, N·m at the slow shaft.
    fn teeth(&self, state: &State) -> f64 {
        let rate = state.speed / GEAR_RATIO - state.encoder_speed;
        self.gear.tooth_torque(lead(state), rate)
    }
}

/// How far the slow shaft is ahead of the encoder gear, rad.
fn lead(state: &State) -> f64 {
    state.angle / GEAR_RATIO - state.encoder_angle
}

/// To the brake's torque at this angle of the motor.
fn tangent(brake: &Brake, angle: f64) -> Tangent {
    Tangent {
        angle,
        value: brake.level(angle),
        slope: brake.slope(angle),
    }
}
