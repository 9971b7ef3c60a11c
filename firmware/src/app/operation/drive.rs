//! The control step of an image that is operated from a console.
//!
//! It judges the measurements first, then follows its command, then queues what it saw and did. It
//! vouches for the program, see [`Wiring::take_vouched`], when no deadline was missed since its last step,
//! all its numbers were finite and every [task](crate::app::liveness) goes on.
//!
//! Armed, it begins where the actuator is: the position is held, or the voltage is 0.

use heapless::spsc::Consumer;
use model_core::control::pid;

use super::bridge;
use super::calibration::Correction;
use super::encoder_check::{self, Check};
use super::homing::{End, Search, Seeking, Sought, Step};
use super::motion_limit;
use super::temperature;
use crate::app::console::request::Mode;
use crate::app::conversion::Converters;
use crate::app::fault::monitor::{Measured, Monitors};
use crate::app::fault::observer::Reading;
use crate::app::fault::output::Bridge;
use crate::app::fault::overload::Heat;
use crate::app::fault::{Fault, Faults};
use crate::app::profile::Generator;
use crate::app::record::{Marks, Recorder, Sample};
use crate::app::wiring::{Applied, Measurement, Wiring};
use crate::app::work::ControlWork;

/// What the drive is told.
#[expect(clippy::large_enum_variant, reason = "there is no allocation")]
#[derive(Debug, Clone)]
pub enum Order {
    /// Numbers, from now on.
    Setup(Setup),
    /// What the command is, from now on. It holds where the actuator is, whatever was ordered before.
    Mode(Mode),
    /// The command, from now on.
    Signal(Generator),
    /// The command stays where it is.
    Hold,
    /// A limit switch is sought, in position mode.
    Seek(Sought),
}

/// Orders under way at a time.
pub const ORDERS: usize = 8;

/// The drive's numbers.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The position loop, for the control period.
    pub pid: pid::Coefficients,
    /// Sensors and bridge.
    pub converters: Converters,
    /// Where a position may be commanded, rad.
    pub stroke: [f32; 2],
    /// What the current sensor is off by.
    pub current: Correction,
    /// Control steps that a command is driven without another one; none for ever.
    pub command_steps: Option<u32>,
    /// What keeps a real actuator's motion within its limits.
    pub motion: Option<motion_limit::Coefficients>,
    /// What its temperatures leave of a real actuator's current.
    pub temperature: Option<temperature::Coefficients>,
    /// What the encoder is checked by before a loop is closed over it.
    pub encoder_check: Option<encoder_check::Coefficients>,
    /// What watches a real actuator.
    pub monitors: Option<Monitors>,
}

impl Setup {
    /// Takes other numbers; what the monitors have seen stays. Nothing is copied twice: this is the longest of all orders, and the
    /// control step waits for it.
    fn take(&mut self, other: &Self) {
        let Self {
            pid,
            converters,
            stroke,
            current,
            command_steps,
            motion,
            temperature,
            encoder_check,
            monitors,
        } = other;
        self.pid.clone_from(pid);
        self.converters = *converters;
        self.stroke = *stroke;
        self.current = *current;
        self.command_steps = *command_steps;
        self.motion.clone_from(motion);
        self.temperature.clone_from(temperature);
        self.encoder_check = *encoder_check;
        match (&mut self.monitors, monitors) {
            (Some(ours), Some(monitors)) => ours.take(monitors),
            (ours, monitors) => ours.clone_from(monitors),
        }
    }
}

/// The command.
#[derive(Debug, Clone, Copy)]
enum Command {
    /// Where the actuator was when it was armed, though that be outside its stroke, or where a signal had it.
    Held(f32),
    /// And the control steps since its start. A position is bounded by the stroke.
    Signal(Generator, u32),
}

/// The drive.
pub struct Drive {
    setup: Setup,
    orders: Consumer<'static, Order>,
    mode: Mode,
    command: Command,
    seeking: Option<Seeking>,
    /// The last value of the command.
    commanded: f32,
    /// Whether a signal begins with this step.
    begins: bool,
    /// The check of the encoder that is under way: nothing is commanded meanwhile.
    check: Option<Check>,
    /// Its last step.
    checked: Option<encoder_check::Step>,
    /// Whether the encoder was seen to follow the rotor since the start, and no fault of it came since.
    encoder_follows: bool,
    state: pid::State,
    motion: motion_limit::State,
    /// What the limits leave of a real actuator's current, A, the least first.
    range: Option<[f32; 2]>,
    temperature: temperature::State,
    /// The limit switches, lower and upper.
    switches: [End; 2],
    /// The step before, as far as it is known: its voltage stands until this one.
    sample: Option<Sample>,
    /// The encoder's counts at the step before.
    counts: i32,
    /// Driven control steps since the terminal last sent a command.
    silent: u32,
    missed: u32,
    sequence: u32,
    wiring: &'static Wiring,
    recorder: Recorder,
}

impl Drive {
    /// With its first numbers, disarmed; every step is recorded. The winding is as hot as the wiring has it.
    pub fn new(
        mut setup: Setup,
        mode: Mode,
        orders: Consumer<'static, Order>,
        wiring: &'static Wiring,
        mut recorder: Recorder,
    ) -> Self {
        recorder.begin();
        if let Some(monitors) = &mut setup.monitors {
            monitors.set_heat(Heat::of_word(wiring.heat()));
        }
        wiring.set_commanded(mode != Mode::Wires);
        Self {
            setup,
            orders,
            mode,
            command: Command::Held(0.0),
            seeking: None,
            commanded: 0.0,
            begins: false,
            check: None,
            checked: None,
            encoder_follows: false,
            state: pid::State::default(),
            motion: motion_limit::State::default(),
            range: None,
            temperature: temperature::State::default(),
            switches: [End::default(); 2],
            sample: None,
            counts: 0,
            silent: 0,
            missed: 0,
            sequence: 0,
            wiring,
            recorder,
        }
    }

    /// Does what was ordered, with the encoder at these counts.
    fn obey(&mut self, counts: i32) {
        while let Some(order) = self.orders.peek() {
            // An order before this one may have set another unit.
            let position = self.setup.converters.position.value(counts);
            match *order {
                Order::Setup(ref setup) => self.setup.take(setup),
                Order::Mode(mode) => {
                    self.mode = mode;
                    self.wiring.set_commanded(mode != Mode::Wires);
                    self.seeking = None;
                    self.rest(position);
                }
                Order::Signal(generator) => self.command = Command::Signal(generator, 0),
                Order::Hold => self.command = Command::Held(self.commanded),
                Order::Seek(sought) => {
                    self.rest(position);
                    let search = Search::new(sought, position, self.wiring.switches());
                    self.seeking = Some(Seeking::Under(search));
                }
            }
            self.orders.dequeue();
        }
    }

    /// Begins anew, where the actuator is.
    fn rest(&mut self, position: f32) {
        self.state = pid::State::default();
        self.commanded = match self.mode {
            Mode::Position => position,
            Mode::Voltage | Mode::Wires => 0.0,
        };
        self.command = Command::Held(self.commanded);
    }

    /// The command of a step that seeks a switch. Where it is, the stroke's ends are not known yet.
    fn seek(&mut self, mut search: Search, (position, counts): (f32, i32)) -> f32 {
        let step = search.step(self.wiring.switches(), (position, counts));
        self.seeking = Some(match step {
            Step::To(_) => Seeking::Under(search),
            Step::Found(_) | Step::Lost => Seeking::Ended(search.switch()),
        });
        self.commanded = match step {
            Step::To(target) => target,
            Step::Found(edge) => {
                self.wiring.end_search(Some(edge));
                position
            }
            Step::Lost => {
                self.wiring.end_search(None);
                position
            }
        };
        self.commanded
    }

    /// Checks that the encoder follows the rotor, if a loop is closed over it that was not checked.
    fn check_encoder(&mut self, (position, counts): (f32, i32)) {
        let before = self.checked.take();
        let due = self.is_driven() && self.mode == Mode::Position && !self.encoder_follows;
        let Some(numbers) = self.setup.encoder_check.filter(|_| due) else {
            self.check = None;
            return;
        };
        let barred = self.switches.map(|end| end.leaves);
        let check = self.check.get_or_insert_default();
        let step = check.step(&numbers, counts, barred);
        let away = check.away();
        match step {
            encoder_check::Step::Follows => {
                self.check = None;
                self.encoder_follows = true;
                // The pushes may have passed the switch's edge.
                if let Some(Seeking::Under(search)) = self.seeking {
                    let search = search.anew(position, self.wiring.switches());
                    self.seeking = Some(Seeking::Under(search));
                    self.rest(position);
                }
            }
            encoder_check::Step::Failed(fault) => self.wiring.trip(fault),
            // What the loop integrates meanwhile is not its command's.
            encoder_check::Step::Push(_) | encoder_check::Step::Wait => {
                self.state = pid::State::default();
            }
            encoder_check::Step::Settle => {
                // The way back may be onto the switch, which is an end of the way once it was closed: it is held where it came
                // farthest away.
                if let Some(upwards) = away {
                    let from = if matches!(before, Some(encoder_check::Step::Push(_))) {
                        position
                    } else {
                        self.commanded
                    };
                    self.commanded = if upwards {
                        from.max(position)
                    } else {
                        from.min(position)
                    };
                    if let Command::Held(value) = &mut self.command {
                        *value = self.commanded;
                    }
                }
            }
        }
        self.checked = Some(step);
    }

    /// The current that the encoder's check pushes with, A.
    fn push(&self) -> Option<f32> {
        match self.checked {
            Some(encoder_check::Step::Push(current)) => Some(current),
            _ => None,
        }
    }

    /// The command of this step, which holds while the encoder is checked.
    fn advance(&mut self, position: f32, counts: i32) -> f32 {
        self.begins = false;
        if self.check.is_some() {
            return self.commanded;
        }
        match self.seeking {
            Some(Seeking::Under(search)) => return self.seek(search, (position, counts)),
            Some(Seeking::Ended(_)) => return position,
            None => {}
        }
        self.commanded = match &mut self.command {
            Command::Held(value) => *value,
            Command::Signal(generator, step) => {
                let value = generator.at(*step);
                self.begins = *step == 0;
                *step = step.saturating_add(1);
                let [lower, upper] = self.setup.stroke;
                match self.mode {
                    Mode::Position => value.max(lower).min(upper),
                    Mode::Voltage | Mode::Wires => value,
                }
            }
        };
        self.commanded
    }

    /// The step before with what the bridge held since: the log has what was driven.
    fn record(&mut self, applied: Option<Applied>) {
        let sample = self.sample.take().filter(|_| !self.wiring.is_stalled());
        if let Some(mut sample) = sample {
            sample.duty = applied.map_or(0, |applied| applied.mean);
            sample.marks.driven = applied.is_some();
            self.recorder.push(sample);
        }
    }

    fn is_driven(&self) -> bool {
        self.wiring.latch().outputs().bridge == Bridge::Driven
    }

    /// Latches what is wrong. False if a number is not finite.
    fn judge(
        &mut self,
        (position, counts): (f32, i32),
        current: f32,
        applied: Option<Applied>,
    ) -> bool {
        let moved = counts.wrapping_sub(core::mem::replace(&mut self.counts, counts));
        let supply = self.wiring.supply();
        let is_driven = self.is_driven();
        let [lower, upper] = self.wiring.switches();
        let open = [
            self.switches[0].step(lower, is_driven),
            self.switches[1].step(upper, is_driven),
        ];
        let [lower, upper] = self.switches.map(|end| end.leaves);
        let switches = [open[0] && !lower, open[1] && !upper];
        // The one that is sought is no end of the way.
        let switches = self
            .seeking
            .map_or(switches, |seeking| seeking.switch().closed(switches));
        // Nothing is at both ends at once: their cable is cut, and neither says where the actuator is.
        let are_cut = is_driven && open == [true; 2];
        let mut present = Faults::when(Fault::BridgeBreak, self.wiring.is_bridge_broken())
            | Faults::when(Fault::StopReached, are_cut)
            | Faults::when(Fault::CurrentOffset, self.wiring.is_current_sensor_off())
            | Faults::when(Fault::EmergencyStop, self.wiring.is_emergency_stop())
            | Faults::when(Fault::BrownOut, self.wiring.is_processor_supply_low())
            | Faults::when(Fault::ClockFailed, self.wiring.is_clock_failed());
        // A period in which the bridge went off and the brake on says nothing of the encoder.
        let applied = applied.filter(|_| is_driven);
        let bridge = self.setup.converters.bridge;
        let reading = Reading {
            position,
            moved: self.setup.converters.position.value(moved),
            current,
            voltage: applied.map(|applied| bridge.value(applied.mean)),
            spread: applied.map_or(0.0, |applied| bridge.value(applied.spread)),
        };
        if let Some(monitors) = &mut self.setup.monitors {
            // A rotor that is pushed against a stop, or comes to rest at one, is what the check is about.
            if let Some(encoder_check::Step::Push(_) | encoder_check::Step::Settle) = self.checked {
                monitors.forget_torque();
            }
            present = present
                | monitors.step(&Measured {
                    reading,
                    supply,
                    switches,
                });
        }
        // Also one that the operator latched, between two steps.
        let causes = present | self.wiring.latch().causes();
        self.encoder_follows &= !causes.are_of_the_encoder();
        if let Some(monitors) = &self.setup.monitors {
            self.wiring.set_heat(monitors.heat().word());
        }
        if let Some(motion) = &self.setup.motion {
            let verdict = motion.step(&mut self.motion, &reading);
            present = present | Faults::when(Fault::OverSpeed, verdict.too_fast);
            let bearable = self.setup.monitors.as_ref().map(Monitors::current);
            let mut most = bearable.unwrap_or(f32::MAX);
            if let Some(temperature) = &self.setup.temperature {
                let codes = self.wiring.temperature_codes();
                let verdict = temperature.step(&mut self.temperature, codes);
                most = most.min(verdict.current);
                self.wiring.set_temperatures(verdict.celsius);
                present = present | verdict.faults;
            }
            self.range = Some(verdict.range.map(|current| current.min(most).max(-most)));
        }
        self.wiring.latch().watch(present, self.wiring.time());
        position.is_finite() && current.is_finite() && supply.is_finite()
    }

    /// What flows at most until the next step: in a push no more than the push.
    fn limit_current(&mut self) {
        if let Some(range) = self.range {
            let most = self.push().map_or(f32::MAX, f32::abs);
            let range = range.map(|current| current.min(most).max(-most));
            self.wiring.set_current_range(range);
        }
    }

    /// Latches that nobody commands any more, where it is the terminal that does.
    fn watch_terminal(&mut self, armed: bool) {
        let commanded_anew = self.wiring.take_sign_of_life();
        let waits = armed && self.wiring.is_commanded() && !commanded_anew;
        self.silent = if waits {
            self.silent.saturating_add(1)
        } else {
            0
        };
        let most = self.setup.command_steps;
        if most.is_some_and(|most| self.silent > most) {
            self.wiring.trip(Fault::CommandTimeout);
        }
    }

    /// What is left of a range of voltage, V, while the actuator is on a limit switch from the beginning.
    fn off_switches(&self, [low, high]: [f32; 2]) -> [f32; 2] {
        let [lower, upper] = self.switches.map(|end| end.leaves);
        [
            if lower { low.max(0.0).min(high) } else { low },
            if upper { high.min(0.0).max(low) } else { high },
        ]
    }

    /// The voltage that the command asks for, V, as far as the supply reaches and the motor's current
    /// bears it. None if it is not a number.
    fn voltage(&mut self, command: f32, position: f32) -> Option<f32> {
        let most = bridge::reach(self.wiring.supply());
        let converter = self.setup.converters.bridge;
        let [low, high] = self.wiring.bounds().map(|counts| converter.value(counts));
        let [low, high] = self.off_switches([low.max(-most), high.min(most)]);
        let wanted = match (self.push(), self.mode) {
            // As much as the push's current takes: the current's range ends there.
            (Some(push), _) => most.copysign(push),
            _ if matches!(self.checked, Some(encoder_check::Step::Wait)) => 0.0,
            _ if matches!(self.seeking, Some(Seeking::Ended(_))) => 0.0,
            (None, Mode::Position) => self
                .setup
                .pid
                .step_between(&mut self.state, command, position, [low, high])
                .ok()?,
            (None, Mode::Voltage) => command,
            (None, Mode::Wires) => 0.0,
        };
        let voltage = wanted.min(high).max(low);
        voltage.is_finite().then_some(voltage)
    }
}

impl ControlWork for Drive {
    fn step(&mut self) {
        let Measurement { position, current } = self.wiring.measurement();
        let converters = self.setup.converters;
        let angle = converters.position.value(position);
        let amperes = self.setup.current.of(converters.current.value(current));
        let applied = self.wiring.applied();
        let mut finite = self.judge((angle, position), amperes, applied);
        self.obey(position);
        let converters = self.setup.converters;
        let angle = converters.position.value(position);
        // Whether a check is due is known once the orders of this step are.
        self.check_encoder((angle, position));
        self.wiring.set_encoder_follows(self.encoder_follows);
        self.limit_current();
        self.watch_terminal(self.is_driven());

        let armed = self.is_driven();
        if !armed {
            self.rest(angle);
            self.seeking = None;
        }
        let command = self.advance(angle, position);
        let voltage = self.voltage(command, angle);
        finite &= voltage.is_some();
        let counts = voltage.and_then(|voltage| converters.bridge.counts(voltage));
        if !finite {
            self.wiring.trip(Fault::NonFinite);
            self.state = pid::State::default();
        }
        self.wiring.drive(counts.unwrap_or(0));
        // It was due before the next plant tick. What is left may come beside that.
        self.wiring.set_control_due(false);

        if let Some(monitors) = &mut self.setup.monitors {
            monitors.learn();
        }
        self.record(applied);
        // A log has a gap where the processor stood still.
        self.sample = (!self.wiring.is_stalled()).then(|| Sample {
            sequence: self.sequence,
            command,
            duty: 0,
            position,
            current: converters.current.counts(amperes).unwrap_or(0),
            truth: self.wiring.truth(),
            marks: Marks {
                command: self.begins && armed,
                fault: self.wiring.latch().is_tripped(),
                driven: false,
            },
        });
        self.sequence = self.sequence.wrapping_add(1);
        let missed = self.wiring.missed();
        if finite && missed == self.missed && self.wiring.all_tasks_go_on() {
            self.wiring.vouch();
        }
        self.missed = missed;
    }
}
