//! The equations of motion and their integrator.
//!
//! Between events the plant is smooth and advances by the explicit midpoint rule (second order)
//! at 2 µs or less. Four events end a smooth stretch, each placed inside its step by linear
//! interpolation, which keeps the second order: the velocity reaches zero, the load exceeds
//! static friction, the position passes the spring's rest, the position reaches a stop. At zero
//! velocity the machine sticks, truly, unless the load exceeds static friction: a sticking
//! machine has velocity 0 and a constant position, and only its current moves on.
//!
//! With [`Effect::Presliding`] friction is a smooth load of bristles instead, and the machine is
//! held by a stop or by the spring's preload alone.

use crate::effect::Effect;
use crate::machine::{Machine, Motor, Stops};
use std::f64::consts::TAU;

/// Default and largest integration step, s.
pub(crate) const STEP: f64 = 2.0e-6;

/// What the integrator carries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// A; stays 0 for a machine without a winding or without inductance.
    pub current: f64,
    /// rad/s or m/s.
    pub velocity: f64,
    /// rad or m.
    pub position: f64,
}

/// Whether it moves, and which way: the sign of friction while it does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Motion {
    Stuck,
    Sliding(f64),
}

/// LuGre's bristles.
#[derive(Debug, Clone, Copy)]
struct Bristles {
    /// σ₀, N·m/rad or N/m.
    stiffness: f64,
    /// σ₁, N·m·s/rad or N·s/m.
    damping: f64,
    /// v_s, rad/s or m/s.
    speed: f64,
}

/// A second inertia behind a spring.
#[derive(Debug, Clone, Copy)]
struct Shaft {
    /// kg·m² or kg.
    inertia: f64,
    /// N·m/rad or N/m.
    stiffness: f64,
    /// N·m·s/rad or N·s/m.
    damping: f64,
    /// rad or m.
    position: f64,
    /// rad/s or m/s.
    velocity: f64,
}

impl Shaft {
    /// Load on the drive.
    fn load(&self, drive: State) -> f64 {
        self.stiffness * (self.position - drive.position)
            + self.damping * (self.velocity - drive.velocity)
    }

    /// Lets `seconds` pass with the drive at its end (semi-implicit Euler: at 2 µs a swing of 100 Hz
    /// is right to a thousandth).
    fn follow(&mut self, drive: State, seconds: f64) {
        self.velocity -= seconds * self.load(drive) / self.inertia;
        self.position += seconds * self.velocity;
    }
}

/// A load that remembers where the motion last turned.
#[derive(Debug, Clone, Copy)]
struct Hysteresis {
    /// N·m or N.
    torque: f64,
    /// rad or m.
    reach: f64,
    /// Load on the machine, N·m or N.
    load: f64,
}

impl Hysteresis {
    /// Lets the machine pass a way (exact: its direction does not change within that).
    fn follow(&mut self, way: f64) {
        let end = -self.torque * way.signum();
        self.load = end + (self.load - end) * (-way.abs() / self.reach).exp();
    }
}

/// A supply behind a resistance, with a capacitor at the bridge.
#[derive(Debug, Clone, Copy)]
struct Supply {
    /// Without load, V.
    open: f64,
    /// Ω.
    resistance: f64,
    /// F.
    capacity: f64,
    /// At the bridge, V.
    voltage: f64,
}

impl Supply {
    /// Lets `seconds` pass in which the bridge draws a current (Euler: its time constant is far above
    /// 2 µs).
    fn follow(&mut self, drawn: f64, seconds: f64) {
        let charge = (self.open - self.voltage) / self.resistance - drawn;
        self.voltage += seconds * charge / self.capacity;
    }
}

/// Temperatures of winding and housing, as the share by which each would raise the resistance.
#[derive(Debug, Clone, Copy)]
struct Warmth {
    /// 1/(A²·s).
    rate: f64,
    /// Time constants, s.
    winding: f64,
    housing: f64,
    of_winding: f64,
    of_housing: f64,
}

impl Warmth {
    /// Heat capacity of the housing over the winding's.
    const HOUSING: f64 = 10.0;

    /// Lets `seconds` pass under a current.
    fn follow(&mut self, current: f64, seconds: f64) {
        let heating = self.rate * current * current * (1.0 + self.of_winding);
        let passed = (self.of_winding - self.of_housing) / self.winding;
        self.of_winding += seconds * (heating - passed);
        self.of_housing += seconds * (passed / Self::HOUSING - self.of_housing / self.housing);
    }
}

/// A machine with its effects, in motion. Delays are not the plant's: the
/// [`Experiment`](crate::Experiment) has them.
#[derive(Debug, Clone)]
pub struct Plant {
    motor: Motor,
    /// What the motor's load saturates at.
    peak_load: f64,
    /// Fall of the torque constant: k / (1 + fall · |load|).
    fall: f64,
    /// Friction that the brake adds.
    brake: f64,
    supply: Option<Supply>,
    /// Voltage lost at the brushes, and the current at which most of it is.
    brush: (f64, f64),
    /// Voltage lost in the dead time, and half the current's ripple.
    dead_time: (f64, f64),
    warmth: Option<Warmth>,
    /// What is behind an elastic shaft.
    shaft: Option<Shaft>,
    hysteresis: Option<Hysteresis>,
    inertia: f64,
    viscous_forward: f64,
    viscous_backward: f64,
    coulomb: f64,
    static_friction: f64,
    asymmetry: f64,
    offset: f64,
    drag: f64,
    /// All springs together: load −stiffness x + spring_load.
    stiffness: f64,
    spring_load: f64,
    rest: f64,
    preload: f64,
    stops: Stops,
    load_ratio: f64,
    bristles: Option<Bristles>,
    /// Mean deflection z of the bristles, rad or m.
    deflection: f64,
    /// Effects that cost a transcendental function each.
    shaped: Vec<Effect>,
    /// Ripple of the torque constant, and its waves in a radian or metre.
    torque_ripple: (f64, f64),
    step: f64,
    /// Since the start, s.
    time: f64,
    state: State,
    motion: Motion,
    /// Side of the spring's rest, −1 or 1; 0 while the preload holds the machine at rest.
    side: f64,
}

impl Plant {
    /// A machine with its effects, at standstill at 0. Several effects of one kind
    /// add up, but of what remembers and of what acts on the winding the last one counts.
    pub fn new(machine: &Machine, effects: &[Effect]) -> Self {
        let spring = machine.spring;
        let mut plant = Self {
            motor: machine.motor,
            peak_load: f64::INFINITY,
            fall: 0.0,
            brake: 0.0,
            supply: None,
            brush: (0.0, 1.0),
            dead_time: (0.0, 1.0),
            warmth: None,
            shaft: None,
            hysteresis: None,
            inertia: machine.inertia,
            viscous_forward: machine.viscous,
            viscous_backward: machine.viscous,
            coulomb: machine.coulomb,
            static_friction: machine.static_friction.max(machine.coulomb),
            asymmetry: 0.0,
            offset: 0.0,
            drag: 0.0,
            stiffness: spring.map_or(0.0, |s| s.stiffness),
            spring_load: spring.map_or(0.0, |s| s.stiffness * s.rest),
            rest: spring.map_or(0.0, |s| s.rest),
            preload: spring.map_or(0.0, |s| s.preload),
            stops: machine.stops.unwrap_or(Stops {
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
            }),
            load_ratio: 0.0,
            bristles: None,
            deflection: 0.0,
            shaped: Vec::new(),
            torque_ripple: (0.0, 1.0),
            step: STEP,
            time: 0.0,
            state: State::default(),
            motion: Motion::Stuck,
            side: 0.0,
        };
        for &effect in effects {
            match effect {
                Effect::AsymmetricCoulomb { ratio } => plant.asymmetry += ratio,
                Effect::AsymmetricViscous { forward, backward } => {
                    plant.viscous_forward += forward;
                    plant.viscous_backward += backward;
                }
                Effect::OffsetTorque { torque } => plant.offset += torque,
                Effect::QuadraticDrag { coefficient } => plant.drag += coefficient,
                Effect::Spring { stiffness, rest } => {
                    plant.stiffness += stiffness;
                    plant.spring_load += stiffness * rest;
                }
                Effect::LoadDependentFriction { ratio } => plant.load_ratio += ratio,
                Effect::Stribeck { .. }
                | Effect::Gravity { .. }
                | Effect::Cogging { .. }
                | Effect::FrictionDrift { .. }
                | Effect::PositionDependentFriction { .. }
                | Effect::ExternalLoad { .. }
                | Effect::SpeedBand { .. }
                | Effect::RoughSpot { .. } => plant.shaped.push(effect),
                Effect::Presliding {
                    compliance: 0.0, ..
                } => {}
                Effect::Presliding {
                    compliance,
                    damping,
                    speed,
                } => {
                    plant.bristles = Some(Bristles {
                        stiffness: 1.0 / compliance,
                        damping,
                        speed,
                    });
                }
                Effect::Hysteresis { torque, reach } => {
                    plant.hysteresis = Some(Hysteresis {
                        torque,
                        reach,
                        load: 0.0,
                    });
                }
                Effect::TorqueSaturation { fall } => plant.fall += fall,
                Effect::Compliance { trailing: 0.0, .. } => {}
                Effect::Compliance {
                    share,
                    trailing,
                    damping,
                } => {
                    let inertia = share * machine.inertia;
                    plant.inertia -= inertia;
                    plant.shaft = Some(Shaft {
                        inertia,
                        stiffness: inertia / trailing,
                        damping: 2.0 * damping * inertia / trailing.sqrt(),
                        position: 0.0,
                        velocity: 0.0,
                    });
                }
                Effect::SupplySag {
                    resistance: 0.0, ..
                } => {}
                Effect::SupplySag {
                    voltage,
                    resistance,
                    capacity,
                } => {
                    plant.supply = Some(Supply {
                        open: voltage,
                        resistance,
                        capacity,
                        voltage,
                    });
                }
                Effect::BrushDrop { drop, knee } => plant.brush = (drop, knee),
                Effect::DeadTime { loss, ripple } => plant.dead_time = (loss, ripple),
                Effect::ThermalDrift {
                    rate,
                    winding,
                    housing,
                } => {
                    plant.warmth = Some(Warmth {
                        rate,
                        winding,
                        housing,
                        of_winding: 0.0,
                        of_housing: 0.0,
                    });
                }
                Effect::InputDelay { .. }
                | Effect::SensorDelay { .. }
                | Effect::EncoderEccentricity { .. }
                | Effect::Backlash { .. } => {}
            }
        }
        plant.place(0.0, 0.0);
        plant
    }

    /// The same plant with an integration step of at most `step` seconds.
    pub fn with_step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// The same plant with a torque constant k (1 + share · sin(waves · x)).
    pub fn with_torque_ripple(mut self, share: f64, waves: f64) -> Self {
        self.torque_ripple = (share, waves);
        self
    }

    /// The same plant with a motor that gives no more than `load` N·m or N either way.
    pub fn with_peak_load(mut self, load: f64) -> Self {
        self.peak_load = load;
        self
    }

    /// Sets the friction that a brake adds while sliding and at rest, N·m or N.
    pub fn brake(&mut self, friction: f64) {
        self.brake = friction;
    }

    /// Puts the machine somewhere, without current.
    pub fn place(&mut self, position: f64, velocity: f64) {
        self.state = State {
            current: 0.0,
            velocity,
            position,
        };
        self.deflection = 0.0;
        if let Some(shaft) = &mut self.shaft {
            (shaft.position, shaft.velocity) = (position, velocity);
        }
        if let Some(spring) = &mut self.hysteresis {
            spring.load = 0.0;
        }
        self.motion = if velocity == 0.0 {
            Motion::Stuck
        } else {
            Motion::Sliding(velocity.signum())
        };
        self.side = match position - self.rest {
            _ if self.preload == 0.0 => 0.0,
            0.0 if velocity == 0.0 => 0.0,
            0.0 => velocity.signum(),
            distance => distance.signum(),
        };
    }

    /// Where the machine is.
    pub fn state(&self) -> State {
        self.state
    }

    /// Where the side is that the sensor sits on, rad or m.
    pub fn sensed(&self) -> f64 {
        self.shaft
            .map_or(self.state.position, |shaft| shaft.position)
    }

    /// Whether friction, the preload or a stop holds it; bristles never do.
    pub fn is_stuck(&self) -> bool {
        self.motion == Motion::Stuck
    }

    /// Current under `input`, A; 0 for a machine without a winding.
    pub fn current(&self, input: f64) -> f64 {
        match self.motor {
            Motor::Winding {
                resistance,
                inductance: 0.0,
                torque_constant,
            } => {
                let emf = torque_constant * self.rippled(self.state) * self.state.velocity;
                (input - emf) / resistance
            }
            Motor::Winding { .. } => self.state.current,
            Motor::Direct { .. } => 0.0,
        }
    }

    /// Lets `seconds` pass under a constant `input`.
    pub fn advance(&mut self, input: f64, seconds: f64) {
        // The tolerance keeps a rounded multiple of the step from costing one step more.
        let steps = (seconds / self.step - 1e-6).ceil().max(0.0);
        let length = seconds / steps.max(1.0);
        for _ in 0..steps as usize {
            let before = self.state.position;
            self.step_by(input, length);
            self.time += length;
            if let Some(spring) = &mut self.hysteresis {
                spring.follow(self.state.position - before);
            }
            if let Some(shaft) = &mut self.shaft {
                shaft.follow(self.state, length);
            }
            if let Some(supply) = &mut self.supply {
                supply.follow(input / supply.open * self.state.current, length);
            }
            if let Some(warmth) = &mut self.warmth {
                warmth.follow(self.state.current, length);
            }
        }
    }

    /// One step, cut at its events.
    fn step_by(&mut self, input: f64, length: f64) {
        let mut left = length;
        // Set when a direction was tried and the machine came back at once: it stays put until
        // the next step, or events would follow each other without time passing.
        let mut held = false;
        while left > 0.0 {
            if let Some(bristles) = self.bristles {
                left -= self.yield_to(input, left, bristles);
                continue;
            }
            left -= match self.motion {
                Motion::Stuck => self.stick(input, left, &mut held),
                Motion::Sliding(direction) => self.slide(input, left, direction, &mut held),
            };
        }
    }

    /// Advances a machine at standstill until it breaks away, at most by `length`; returns the
    /// time it took.
    fn stick(&mut self, input: f64, length: f64, held: &mut bool) -> f64 {
        let start = self.state;
        let before = self.excess(input);
        if before > 0.0 && !*held {
            self.break_away(input);
            return 0.0;
        }
        self.state.current = self.locked_current(input, start.current, length);
        let after = self.excess(input);
        if after <= 0.0 || before >= 0.0 {
            return length;
        }
        let taken = length * before / (before - after);
        self.state.current = self.locked_current(input, start.current, taken);
        self.break_away(input);
        taken
    }

    /// Advances a machine in motion until an event, at most by `length`; returns the time it took.
    fn slide(&mut self, input: f64, length: f64, direction: f64, held: &mut bool) -> f64 {
        let start = self.state;
        let end = self.midpoint(input, length, direction);
        let mut share = 1.0;
        let mut event = None;
        let mut meet = |candidate: f64, what: Event| {
            if event.is_none() || candidate < share {
                share = candidate;
                event = Some(what);
            }
        };
        let passed = |level| share_of(start.position, end.position, level);
        if end.velocity * direction <= 0.0 {
            meet(share_of(start.velocity, end.velocity, 0.0), Event::Halt);
        }
        // A machine that leaves the rest and is back within the step has halted before.
        if direction * self.side < 0.0 && (end.position - self.rest) * self.side < 0.0 {
            meet(passed(self.rest), Event::Rest);
        }
        if end.position >= self.stops.upper && direction > 0.0 {
            meet(passed(self.stops.upper), Event::Stop);
        } else if end.position <= self.stops.lower && direction < 0.0 {
            meet(passed(self.stops.lower), Event::Stop);
        }
        let Some(event) = event else {
            self.state = end;
            return length;
        };
        let taken = share * length;
        self.state = self.midpoint(input, taken, direction);
        match event {
            Event::Rest => {
                self.state.position = self.rest;
                self.side = direction;
            }
            Event::Stop => {
                self.state.position = if direction > 0.0 {
                    self.stops.upper
                } else {
                    self.stops.lower
                };
                self.halt(input);
            }
            Event::Halt => {
                *held |= start.velocity == 0.0;
                self.halt(input);
            }
        }
        taken
    }

    /// Advances a machine on bristles until an event, at most by `length`; returns the time it
    /// took.
    fn yield_to(&mut self, input: f64, length: f64, bristles: Bristles) -> f64 {
        let start = self.state;
        if start.velocity == 0.0 {
            let load = self.load(input, start) - bristles.stiffness * self.deflection;
            let preload = if self.side == 0.0 { self.preload } else { 0.0 };
            let against_stop = (load > 0.0 && start.position >= self.stops.upper)
                || (load < 0.0 && start.position <= self.stops.lower);
            if against_stop || (preload > 0.0 && load.abs() <= preload) {
                self.motion = Motion::Stuck;
                self.state.current = self.locked_current(input, start.current, length);
                return length;
            }
            if preload > 0.0 {
                self.side = load.signum();
            }
        }
        let (end, deflection) = self.bristle_midpoint(input, length, bristles);
        self.motion = Motion::Sliding(end.velocity.signum());
        let rest = ((end.position - self.rest) * self.side < 0.0)
            .then(|| share_of(start.position, end.position, self.rest));
        let stop = if end.position > self.stops.upper {
            Some(self.stops.upper)
        } else if end.position < self.stops.lower {
            Some(self.stops.lower)
        } else {
            None
        };
        let share = match (rest, stop) {
            (None, None) => {
                self.state = end;
                self.deflection = deflection;
                return length;
            }
            (rest, stop) => {
                let stop = stop.map_or(1.0, |stop| share_of(start.position, end.position, stop));
                rest.unwrap_or(1.0).min(stop)
            }
        };
        let taken = share * length;
        (self.state, self.deflection) = self.bristle_midpoint(input, taken, bristles);
        if let Some(stop) = stop {
            self.state.position = stop;
            self.state.velocity = 0.0;
        }
        if rest.is_some() {
            // As in `halt`: what the load covers within a step of the spring's rest is rest.
            let acceleration =
                (self.preload + self.motor_load(input, self.state).abs()) / self.inertia;
            self.state.position = self.rest;
            self.side = if self.state.velocity.abs() <= 2.0 * acceleration * self.step {
                self.state.velocity = 0.0;
                0.0
            } else {
                self.state.velocity.signum()
            };
        }
        taken
    }

    /// The state and the deflection `length` seconds on, without an event (explicit midpoint
    /// rule).
    #[inline]
    fn bristle_midpoint(&self, input: f64, length: f64, bristles: Bristles) -> (State, f64) {
        let start = self.state;
        let half = 0.5 * length;
        let rates = self.bristle_rates(input, start, self.deflection, bristles);
        let middle = State {
            current: start.current + half * rates.0,
            velocity: start.velocity + half * rates.1,
            position: start.position + half * start.velocity,
        };
        let rates = self.bristle_rates(input, middle, self.deflection + half * rates.2, bristles);
        let end = State {
            current: start.current + length * rates.0,
            velocity: start.velocity + length * rates.1,
            position: start.position + length * middle.velocity,
        };
        (end, self.deflection + length * rates.2)
    }

    /// di/dt, dv/dt and dz/dt on bristles: dz/dt = v − σ₀ |v| z / g(v), load −(σ₀ z + σ₁ dz/dt).
    #[inline]
    fn bristle_rates(
        &self,
        input: f64,
        state: State,
        deflection: f64,
        bristles: Bristles,
    ) -> (f64, f64, f64) {
        let direction = state.velocity.signum();
        let level = self.coulomb
            + (self.static_friction - self.coulomb) * bell(state.velocity / bristles.speed);
        let steady = self.kinetic_friction(level, input, state, direction);
        let deflection_rate =
            state.velocity - bristles.stiffness * state.velocity.abs() * deflection / steady;
        let friction = bristles.stiffness * deflection
            + bristles.damping * deflection_rate
            + self.viscous(direction) * state.velocity;
        (
            self.current_rate(input, state),
            (self.load(input, state) - friction) / self.inertia,
            deflection_rate,
        )
    }

    /// Velocity has reached zero: stick there, and on the spring's rest if the machine cannot get
    /// away from it within a step. The next stretch tries the breakaway.
    fn halt(&mut self, input: f64) {
        self.state.velocity = 0.0;
        self.motion = Motion::Stuck;
        if self.side != 0.0 {
            // Between preload and friction a plate bounces about its rest ever more often in ever
            // shorter time. Below the distance that the load covers in one step that is rest.
            let acceleration =
                (self.preload + self.motor_load(input, self.state).abs()) / self.inertia;
            if (self.state.position - self.rest).abs() <= acceleration * self.step * self.step {
                self.state.position = self.rest;
                self.side = 0.0;
            }
        }
    }

    /// How far the load exceeds what holds the machine at standstill; negative while it holds.
    fn excess(&self, input: f64) -> f64 {
        let load = self.load(input, self.state);
        let direction = load.signum();
        if (direction > 0.0 && self.state.position >= self.stops.upper)
            || (direction < 0.0 && self.state.position <= self.stops.lower)
        {
            return -load.abs();
        }
        let preload = if self.side == 0.0 { self.preload } else { 0.0 };
        load.abs() - self.breakaway(input, direction) - preload
    }

    /// Starts to slide the way the load points.
    fn break_away(&mut self, input: f64) {
        let direction = self.load(input, self.state).signum();
        self.motion = Motion::Sliding(direction);
        if self.preload > 0.0 && self.side == 0.0 {
            self.side = direction;
        }
    }

    /// Current of the winding after `length` seconds at standstill, A.
    fn locked_current(&self, input: f64, current: f64, length: f64) -> f64 {
        match self.motor {
            Motor::Winding {
                resistance,
                inductance,
                ..
            } if inductance > 0.0 => {
                let rate = |current: f64| {
                    let drop = resistance * self.warmed() * current;
                    (self.terminal(input, current) - drop) / inductance
                };
                current + length * rate(current + 0.5 * length * rate(current))
            }
            _ => 0.0,
        }
    }

    /// The state `length` seconds on, sliding one way without an event (explicit midpoint rule).
    #[inline]
    fn midpoint(&self, input: f64, length: f64, direction: f64) -> State {
        let start = self.state;
        let half = 0.5 * length;
        let (current_rate, acceleration) = self.rates(input, start, direction);
        let middle = State {
            current: start.current + half * current_rate,
            velocity: start.velocity + half * acceleration,
            position: start.position + half * start.velocity,
        };
        let (current_rate, acceleration) = self.rates(input, middle, direction);
        State {
            current: start.current + length * current_rate,
            velocity: start.velocity + length * acceleration,
            position: start.position + length * middle.velocity,
        }
    }

    /// di/dt in A/s and dv/dt in rad/s² or m/s², sliding one way.
    #[inline]
    fn rates(&self, input: f64, state: State, direction: f64) -> (f64, f64) {
        let friction = direction * self.sliding_friction(input, state, direction);
        (
            self.current_rate(input, state),
            (self.load(input, state) - friction) / self.inertia,
        )
    }

    /// di/dt, A/s; 0 for a machine without a winding or without inductance.
    #[inline]
    fn current_rate(&self, input: f64, state: State) -> f64 {
        match self.motor {
            Motor::Winding {
                resistance,
                inductance,
                torque_constant,
            } if inductance > 0.0 => {
                let constant = torque_constant * self.rippled(state);
                let emf = constant * self.left_of(constant * state.current) * state.velocity;
                let drop = resistance * self.warmed() * state.current;
                (self.terminal(input, state.current) - drop - emf) / inductance
            }
            _ => 0.0,
        }
    }

    /// What supply, bridge and brushes leave of the voltage that the drive was told, V.
    #[inline]
    fn terminal(&self, input: f64, current: f64) -> f64 {
        let fed = self
            .supply
            .map_or(input, |supply| input * supply.voltage / supply.open);
        let (loss, ripple) = self.dead_time;
        let lost = loss.min(input.abs()) * (current / ripple).clamp(-1.0, 1.0);
        let (drop, knee) = self.brush;
        let at_brushes = if drop == 0.0 {
            0.0
        } else {
            (drop * (1.0 - (-current.abs() / knee).exp())).copysign(current)
        };
        fed - lost - at_brushes
    }

    /// What warmth makes of a resistance of 1.
    #[inline]
    fn warmed(&self) -> f64 {
        self.warmth.map_or(1.0, |warmth| 1.0 + warmth.of_winding)
    }

    /// What the ripple makes of a torque constant of 1.
    #[inline]
    fn rippled(&self, state: State) -> f64 {
        let (share, waves) = self.torque_ripple;
        if share == 0.0 {
            1.0
        } else {
            1.0 + share * (waves * state.position).sin()
        }
    }

    /// Load of the motor.
    #[inline]
    fn motor_load(&self, input: f64, state: State) -> f64 {
        let load = match self.motor {
            Motor::Winding {
                resistance,
                inductance,
                torque_constant,
            } => {
                let torque_constant = torque_constant * self.rippled(state);
                let current = if inductance > 0.0 {
                    state.current
                } else {
                    (input - torque_constant * state.velocity) / resistance
                };
                torque_constant * current
            }
            Motor::Direct { gain } => gain * input,
        };
        (load * self.left_of(load)).clamp(-self.peak_load, self.peak_load)
    }

    /// Share of the torque constant that is left where the unsaturated motor had this load.
    #[inline]
    fn left_of(&self, load: f64) -> f64 {
        1.0 / (1.0 + self.fall * load.abs())
    }

    /// All loads but friction.
    #[inline]
    fn load(&self, input: f64, state: State) -> f64 {
        let mut load = self.motor_load(input, state) + self.offset + self.spring_load
            - self.stiffness * state.position
            - self.preload * self.side
            + self.shaft.map_or(0.0, |shaft| shaft.load(state))
            + self.hysteresis.map_or(0.0, |spring| spring.load)
            - self.drag * state.velocity * state.velocity.abs();
        for effect in &self.shaped {
            load += match effect {
                Effect::Gravity { torque, rest } => -torque * (state.position - rest).sin(),
                Effect::Cogging {
                    amplitude,
                    period,
                    phase,
                } => amplitude * (TAU * state.position / period + phase).sin(),
                Effect::ExternalLoad {
                    torque,
                    begin,
                    duration,
                    ramp,
                } => {
                    // It is held over a step, so it is that of the step's middle.
                    let middle = self.time + 0.5 * STEP;
                    let risen = |since: f64| ((middle - since) / ramp + 0.5).clamp(0.0, 1.0);
                    torque * (risen(*begin) - risen(begin + duration))
                }
                _ => 0.0,
            };
        }
        load
    }

    /// Friction against a motion in `direction`, positive.
    #[inline]
    fn sliding_friction(&self, input: f64, state: State, direction: f64) -> f64 {
        let speed = direction * state.velocity;
        self.kinetic_friction(self.coulomb, input, state, direction)
            + self.viscous(direction) * speed
    }

    /// Viscous friction for a motion in `direction`.
    #[inline]
    fn viscous(&self, direction: f64) -> f64 {
        if direction > 0.0 {
            self.viscous_forward
        } else {
            self.viscous_backward
        }
    }

    /// Friction against a motion in `direction` from `level` up, but the viscous one.
    #[inline]
    fn kinetic_friction(&self, level: f64, input: f64, state: State, direction: f64) -> f64 {
        let speed = direction * state.velocity;
        let mut friction = self.dry_friction(level, input, state, direction);
        for effect in &self.shaped {
            friction += match effect {
                Effect::Stribeck { drop, speed: scale } => drop * (-speed / scale).exp(),
                Effect::SpeedBand {
                    torque,
                    centre,
                    width,
                } => torque * bell((speed - centre) / width),
                _ => 0.0,
            };
        }
        friction
    }

    /// Friction to be overcome from standstill. It is never below the sliding friction there: a
    /// machine that breaks away must not be stopped by that at once.
    fn breakaway(&self, input: f64, direction: f64) -> f64 {
        self.dry_friction(self.static_friction, input, self.state, direction)
            .max(self.sliding_friction(input, self.state, direction))
    }

    /// The part of friction that knows direction, load, place and time, but no speed.
    #[inline]
    fn dry_friction(&self, level: f64, input: f64, state: State, direction: f64) -> f64 {
        let (mut factor, mut spots) = (1.0 + direction * self.asymmetry, 0.0);
        for effect in &self.shaped {
            match effect {
                Effect::FrictionDrift { rate } => factor *= (1.0 + rate * self.time).max(0.0),
                Effect::PositionDependentFriction {
                    ratio,
                    period,
                    phase,
                } => factor *= 1.0 + ratio * (TAU * state.position / period + phase).sin(),
                Effect::RoughSpot {
                    torque,
                    centre,
                    width,
                } => spots += torque * bell((state.position - centre) / width),
                _ => {}
            }
        }
        level * factor + spots + self.brake + self.load_ratio * self.motor_load(input, state).abs()
    }
}

/// exp(−x²)
fn bell(x: f64) -> f64 {
    (-x * x).exp()
}

/// Where between `from` and `to` the value `level` lies, 0 to 1.
fn share_of(from: f64, to: f64, level: f64) -> f64 {
    if to == from {
        0.0
    } else {
        ((level - from) / (to - from)).clamp(0.0, 1.0)
    }
}

/// What ends a smooth stretch of sliding.
#[derive(Debug, Clone, Copy)]
enum Event {
    /// The velocity reached zero.
    Halt,
    /// The position passed the spring's rest.
    Rest,
    /// The position reached a stop.
    Stop,
}
