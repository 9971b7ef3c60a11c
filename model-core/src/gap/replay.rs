//! Replay in windows, in lockstep with perturbed copies, into least-squares sums.
//!
//! Every window restarts from the measured state, so that an error does not grow beyond it and
//! windows are independent: they may be worked on in any order and by several cores. Sums inside a
//! window are `f32`, sums over windows `f64` in the order of the log: the same bits on one core,
//! on many and on the chip.

use super::ensemble::{COLUMNS, Ensemble, MOST_SIMULATORS, Source};
use super::held::{Acting, Held, Varied};
use super::held_out::LEAST_BLOCKS;
use super::log::{Channel, Log};
use super::simulator::{Course, Given, Simulator};
use crate::effect::compliance::{Shaft, Twist};
use crate::effect::learned_map::deflected;
use crate::effect::thermal_drift::ThermalDrift;
use crate::numeric::triangle::{Triangle, entries};
use crate::plant::modes::Modes;
use crate::plant::{Motion, State};
use core::borrow::Borrow;
use core::slice;
use heapless::Vec;
use places::{Places, Replay};

mod places;

/// Most samples on either side of a restart that its state is smoothed over; windows keep this
/// distance from the ends of a log, however wide the smoothing is.
pub const MARGIN: usize = 16;

/// Half widths of the restarts' smoothing that are tried.
pub(super) const HALF_WIDTHS: [usize; 7] = [2, 3, 4, 6, 8, 12, MARGIN];

/// How a log is cut and weighed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Samples in a window.
    pub window: usize,
    /// Samples on either side of a restart that its state is smoothed over, 1 to [`MARGIN`].
    pub half_width: usize,
    /// Whether a replay restarts from the measured velocity, where there is one, instead of the
    /// slope of the position.
    pub measured_velocity: bool,
    /// Whether the second channel is the velocity: where no log has a current and each has a velocity.
    pub velocity_channel: bool,
    /// Sensor resolution, rad or m; 0 if unknown.
    pub resolution: f32,
    /// Travel by which a motion is told from noise, rad or m: what the memory of an effect is known
    /// behind.
    pub clear_travel: f32,
    /// One over the scale of a position residual.
    pub position_weight: f32,
    /// One over the scale of a residual of the second channel, current or velocity; 0 leaves it out.
    pub current_weight: f32,
}

/// Length of a replay window by which models are judged, and friction is estimated anew, s.
pub const WINDOW: f32 = 0.2;

/// Fewest samples in a window that is shorter than [`WINDOW`]: fewer are not much more than what a restart is
/// smoothed over.
const LEAST_SAMPLES: usize = 10;

/// Counts of the sensor that a clear motion passes.
pub(super) const CLEAR_COUNTS: f32 = 4.0;

/// Length of the run-in that twists a shaft, s, and fewest samples in it: a wrong twist falls to a
/// tenth in two or three swings.
const SHAFT_RUN_IN: f32 = 0.1;
const LEAST_RUN_IN: usize = 100;

/// Fewest samples on either side that a run-in's state is smoothed over, at the beginning of a log.
const LEAST_HALF_WIDTH: usize = 2;

/// Most windows that a run-in goes back.
const MOST_RUN_IN: usize = 10;

/// Time from one look at the current to the next while a winding's warmth is carried to a restart, s:
/// far below any thermal time constant.
const HEAT_STRIDE: f32 = 0.01;

/// Time from one look at the position to the next while a hysteresis is carried to a restart, s: a
/// machine that turns has hardly moved in it.
const TURN_STRIDE: f32 = 0.005;

/// Travel, in shares of the reach, behind which the deflection that it began with is forgotten; and time
/// constants behind which a current is.
const FORGOTTEN: f32 = 5.0;

/// Periods under which a winding's current counts as steady: at a third of a period it is within 5 % of that
/// after one.
const FASTEST_WINDING: f32 = 0.3;

/// Samples on either side of a restart that its state is smoothed over, until the tracing has
/// chosen.
const HALF_WIDTH: usize = 8;

/// Samples nearest to a time, at least `least`.
pub fn samples(seconds: f32, period: f32, least: usize) -> usize {
    ((seconds / period + 0.5) as usize).max(least)
}

impl Settings {
    /// What the tracing starts from. `resolution`: that of the sensor, rad or m; 0 if unknown.
    pub fn new(period: f32, resolution: f32) -> Self {
        Self {
            window: samples(WINDOW, period, 5),
            half_width: HALF_WIDTH,
            measured_velocity: false,
            velocity_channel: false,
            resolution,
            clear_travel: CLEAR_COUNTS * resolution,
            position_weight: 1.0,
            current_weight: 0.0,
        }
    }

    /// The measured velocity, where replays restart from it.
    fn own_velocity<'a>(&self, log: &Log<'a>) -> Option<Channel<'a>> {
        log.velocity.filter(|_| self.measured_velocity)
    }
}

/// The logs of one machine and how they are replayed.
#[derive(Debug, Clone, Copy)]
pub struct Data<'a> {
    /// Logs; all of one sampling period.
    pub logs: &'a [Log<'a>],
    /// How they are cut and weighed.
    pub settings: Settings,
}

/// Where a window lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Index of the log.
    pub log: usize,
    /// Its first sample, where the replay starts.
    pub start: usize,
}

impl<'a> Data<'a> {
    /// The logs, cut into windows of [`WINDOW`] seconds, or shorter ones where these would be fewer than the blocks
    /// by which models are told apart: a fast machine is recorded for a second.
    /// `resolution`: that of the sensor, rad or m; 0 if unknown.
    ///
    /// `None` without a log.
    pub fn new(logs: &'a [Log<'a>], resolution: f32) -> Option<Self> {
        let mut settings = Settings::new(logs.first()?.period, resolution);
        let whole = |log: &Log| log.samples().saturating_sub(2 * MARGIN + 1);
        let samples: usize = logs.iter().map(whole).sum();
        let shorter = (samples / LEAST_BLOCKS).max(LEAST_SAMPLES);
        settings.window = settings.window.min(shorter);
        Some(Self { logs, settings })
    }

    /// Whole windows in one log.
    fn windows_in(&self, log: &Log) -> usize {
        log.samples().saturating_sub(2 * MARGIN + 1) / self.settings.window
    }

    /// Whole windows in the longest log.
    pub fn longest(&self) -> usize {
        let windows = self.logs.iter().map(|log| self.windows_in(log));
        windows.max().unwrap_or(0)
    }

    /// The window at a place in a log, 0 the first.
    pub fn window_at(&self, log: usize, place: usize) -> Option<Window> {
        let start = MARGIN + place * self.settings.window;
        (place < self.windows_in(self.logs.get(log)?)).then_some(Window { log, start })
    }

    /// Whole windows in all logs.
    pub fn windows(&self) -> usize {
        self.logs.iter().map(|log| self.windows_in(log)).sum()
    }

    /// Where the window with this number lies.
    pub fn window(&self, mut number: usize) -> Option<Window> {
        for (index, log) in self.logs.iter().enumerate() {
            let windows = self.windows_in(log);
            if number < windows {
                return Some(Window {
                    log: index,
                    start: MARGIN + number * self.settings.window,
                });
            }
            number -= windows;
        }
        None
    }

    /// Whether a window and a span of time, s since the log began, have something in common.
    fn overlaps(&self, window: Window, (begin, end): (f32, f32)) -> bool {
        let period = self.logs[window.log].period;
        let last = window.start + self.settings.window;
        window.start as f32 * period < end && last as f32 * period > begin
    }

    /// Numbers of the windows that have something in common with one of these spans of time.
    pub fn overlapping<'s>(&'s self, spans: &'s [(f32, f32)]) -> impl Iterator<Item = usize> + 's {
        (0..self.windows()).filter(|&number| {
            let window = self.window(number);
            window.is_some_and(|it| spans.iter().any(|&span| self.overlaps(it, span)))
        })
    }

    /// Whole windows in all logs that take part in a fold of blocks of so many windows.
    pub fn windows_in_fold(&self, (fold, block): (Fold, usize)) -> usize {
        let windows = self.windows();
        let (pairs, rest) = (windows / (2 * block), windows % (2 * block));
        match fold {
            Fold::All => windows,
            Fold::Even => pairs * block + rest.min(block),
            Fold::Odd => pairs * block + rest.saturating_sub(block),
        }
    }

    /// The number among all windows of one that takes part in a fold, counted there.
    pub fn number_in_fold((fold, block): (Fold, usize), place: usize) -> usize {
        match fold {
            Fold::All => place,
            Fold::Even => place + place / block * block,
            Fold::Odd => place + (place / block + 1) * block,
        }
    }

    /// The same logs cut into windows of another length.
    pub fn with_window(&self, window: usize) -> Data<'a> {
        Data {
            settings: Settings {
                window,
                ..self.settings
            },
            ..*self
        }
    }
}

/// What the log says of one step, for all simulations that take it.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// Sample from which the step starts.
    pub index: usize,
    /// The input held over it.
    input: f32,
    /// The position at the end of the step.
    next_position: f32,
    /// The current at its start.
    current: Option<f32>,
    /// The velocity at its end.
    next_velocity: Option<f32>,
    /// The brake's friction, held over it.
    brake: f32,
}

impl Row {
    /// The step from sample `index` of a log, which must not be the last.
    #[inline]
    pub fn new(log: &Log, index: usize) -> Self {
        Self {
            index,
            input: log.input.at(index),
            next_position: log.position.at(index + 1),
            current: log.current.map(|current| current.at(index)),
            next_velocity: log.velocity.map(|velocity| velocity.at(index + 1)),
            brake: log.brake.map_or(0.0, |brake| brake.at(index)),
        }
    }
}

/// One simulation on its way through a window.
pub struct Runner<'a, M = Modes, H = Held> {
    simulator: &'a Simulator<M, H>,
    log: &'a Log<'a>,
    course: Course,
    velocity_channel: bool,
}

impl<'a, M: Borrow<Modes>, H: Acting> Runner<'a, M, H> {
    /// Starts at sample `start` of the log.
    pub fn new(
        simulator: &'a Simulator<M, H>,
        log: &'a Log<'a>,
        start: usize,
        settings: &Settings,
    ) -> Self {
        let mut restart = Restart::new(log, start, settings, simulator.remembers());
        Self::from_restart(
            simulator,
            log,
            &mut restart,
            settings,
            &mut RunIn::default(),
        )
    }

    /// Starts at a restart, with what another simulator has run in to, or what it runs in to itself:
    /// that it leaves there.
    fn from_restart(
        simulator: &'a Simulator<M, H>,
        log: &'a Log<'a>,
        restart: &mut Restart,
        settings: &Settings,
        run_in: &mut RunIn,
    ) -> Self {
        let mut runner = Self::unwound(simulator, log, restart, settings);
        if let Some(shaft) = simulator.shaft() {
            let twists = run_in
                .twists
                .get_or_insert_with(|| runner.twists(restart, settings));
            runner.wound(shaft, twists, restart, settings);
        }
        match &restart.approach {
            Some(approach) if simulator.remembers() => {
                runner.behind(approach, restart, settings, &mut run_in.behind)
            }
            _ => runner,
        }
    }

    /// The same without a shaft's twist.
    fn unwound(
        simulator: &'a Simulator<M, H>,
        log: &'a Log<'a>,
        restart: &mut Restart,
        settings: &Settings,
    ) -> Self {
        let mut runner = Self {
            velocity_channel: settings.velocity_channel,
            ..Self::from_state(simulator, log, (restart.start, restart.state), settings)
        };
        runner.course.memory.warmth = restart.warmth(simulator, log);
        runner
    }

    /// What a run-in shows of the shaft's twist.
    // Its frame is not to lie under the simulations behind it.
    #[inline(never)]
    fn twists(&self, restart: &Restart, settings: &Settings) -> Twists {
        let mut run_in = self.before(restart, settings);
        let mut twists = Twists::new();
        for index in restart.winds_since(self.log)..restart.start + settings.half_width {
            run_in.advance(&Row::new(self.log, index));
            twists.observe(run_in.course.memory.twist, index + 1, restart, settings);
        }
        twists
    }

    /// Where the run-in that twists a shaft begins.
    fn before(&self, restart: &Restart, settings: &Settings) -> Self {
        let since = restart.winds_since(self.log);
        let narrow = Settings {
            half_width: settings.half_width.min(since),
            ..*settings
        };
        let state = measured_state(self.log, since, &narrow);
        let mut run_in = Self::from_state(self.simulator, self.log, (since, state), settings);
        run_in.course.memory.warmth = self.course.memory.warmth;
        run_in
    }

    /// With the twist that a run-in leads to.
    fn wound(&mut self, shaft: &Shaft, twists: &Twists, restart: &Restart, settings: &Settings) {
        let (log, start) = (self.log, restart.start);
        let first = start - settings.half_width;
        let ahead = |index: usize| shaft.ahead() * twists.angles[index - first];
        let state = measured_state_less(log, start, settings, ahead);
        let warmth = self.course.memory.warmth;
        *self = Self {
            velocity_channel: self.velocity_channel,
            ..Self::from_state(self.simulator, log, (start, state), settings)
        };
        self.course.memory.warmth = warmth;
        let own_velocity = settings.own_velocity(log).is_some();
        self.simulator
            .twist(&mut self.course, shaft, twists.twist, own_velocity);
    }

    /// With what the effects remember of the approach to the restart, or of another simulator's if that
    /// is known; a simulated one is, then.
    fn behind(
        &self,
        approach: &Approach,
        restart: &Restart,
        settings: &Settings,
        known: &mut Option<Course>,
    ) -> Self {
        if let Some(course) = known {
            return self.resumed((course, 0.0), approach, settings);
        }
        let simulated = settings.own_velocity(self.log).is_none() && approach.since < restart.start;
        let mut run_in = self.run_in(approach, settings);
        let mut moved = 0.0;
        for index in approach.since..restart.start {
            match settings.own_velocity(self.log) {
                // A measured velocity is the drive's own, and says where it has gone.
                Some(velocity) => {
                    let by = self.log.period * velocity.at(index);
                    moved += by;
                    self.simulator.drag(&mut run_in.course, by);
                }
                None => {
                    run_in.advance(&Row::new(self.log, index));
                }
            }
        }
        *known = Some(run_in.course).filter(|_| simulated);
        self.resumed((&run_in.course, moved), approach, settings)
    }

    /// At the beginning of the approach.
    fn run_in(&self, approach: &Approach, settings: &Settings) -> Self {
        let since = (approach.since, approach.state);
        let mut run_in = Self::from_state(self.simulator, self.log, since, settings);
        run_in.course.memory.warmth = self.course.memory.warmth;
        self.simulator.lean(&mut run_in.course, approach.motion);
        run_in
    }

    /// With what the effects remember behind the approach, and how much further the drive is than a
    /// simulation of it says.
    fn resumed(
        &self,
        (run_in, moved): (&Course, f32),
        approach: &Approach,
        settings: &Settings,
    ) -> Self {
        let mut course = self.course;
        if approach.rested && settings.own_velocity(self.log).is_none() {
            course.state = run_in.state;
            course.state.position = self.course.state.position;
            if self.log.current.is_some() {
                course.state.current = self.course.state.current;
            }
        }
        self.simulator.resume(&mut course, run_in, moved);
        Self { course, ..*self }
    }

    /// Starts at sample `start` of the log from a state that lacks its current.
    fn from_state(
        simulator: &'a Simulator<M, H>,
        log: &'a Log<'a>,
        (start, measured): (usize, State),
        settings: &Settings,
    ) -> Self {
        let own_velocity = settings.own_velocity(log).is_some();
        let mut state = simulator.state_behind(measured, own_velocity);
        state.current = current_at(simulator, log, start, (&state, settings.half_width));
        let mut course = Course::new(state);
        if let Some(reach) = simulator.reach() {
            course.memory.deflection = deflection_at(log, start, reach);
        }
        Self {
            simulator,
            log,
            course,
            velocity_channel: false,
        }
    }

    /// Steps from a sample to the next and gives the residuals, model less measurement: of the
    /// position at the next sample, and of the current at this one or of the velocity at the next.
    #[inline]
    pub fn advance(&mut self, row: &Row) -> (f32, f32) {
        self.advance_and_see(row).0
    }

    /// The same; and the current that its sensor sees, with how fast that rises, A and A/s.
    #[inline]
    fn advance_and_see(&mut self, row: &Row) -> ((f32, f32), (f32, f32)) {
        let before = self.course.state.current;
        let late = self.simulator.input_lateness();
        // Before the log its first input acts.
        let back = |samples: usize| self.log.input.at(row.index.saturating_sub(samples));
        let input = if late.whole == 0 {
            row.input
        } else {
            back(late.whole)
        };
        let previous = if late.share == 0.0 {
            input
        } else {
            back(late.whole + 1)
        };
        let given = Given {
            input,
            previous,
            brake: row.brake,
            index: row.index,
        };
        // A refused input leaves the state: logs are checked on reading, so none is.
        let predicted = self
            .simulator
            .step(&mut self.course, &given)
            .unwrap_or(self.course.state.current);
        let reading = self.simulator.current_match();
        let read = self.simulator.current_sensor().reading(predicted);
        let current = match (row.current, self.log.current) {
            (Some(measured), _) if reading.is_at_hand() => read - measured,
            (_, Some(measured)) => read - measured.at(reading.sample(row.index, measured.len())),
            (_, None) => match row.next_velocity {
                Some(measured) if self.velocity_channel => {
                    self.course.state.velocity.value() - measured
                }
                _ => 0.0,
            },
        };
        let position = self
            .simulator
            .reported_from(&self.course, row.next_position);
        let rise = (self.course.state.current - before) / self.log.period;
        ((position, current), (predicted, rise))
    }

    /// The position that the simulation reports.
    pub fn reported(&self) -> f32 {
        self.simulator.reported(&self.course)
    }

    /// The velocity of its drive.
    pub fn drive_velocity(&self) -> f32 {
        self.course.state.velocity.value()
    }

    /// The position of its drive, before shaft, play and sensor.
    pub fn drive(&self) -> f32 {
        self.course.state.position.value()
    }
}

/// What a run-in shows of a shaft's twist, in which what it started with has died out. What the far side
/// swings about is smoothed over it, for a swing is too fast for that.
#[derive(Debug, Clone, Copy)]
struct Twists {
    /// The twist at the restart.
    twist: Twist,
    /// Its angles on either side of it, as far as that is smoothed over.
    angles: [f32; 2 * MARGIN + 1],
}

impl Twists {
    fn new() -> Self {
        Self {
            twist: Twist::default(),
            angles: [0.0; 2 * MARGIN + 1],
        }
    }

    /// Takes down the twist at a sample.
    #[inline]
    fn observe(&mut self, twist: Twist, sample: usize, restart: &Restart, settings: &Settings) {
        let place = (sample + settings.half_width).checked_sub(restart.start);
        if let Some(angle) = place.and_then(|place| self.angles.get_mut(place)) {
            *angle = twist.angle;
        }
        if sample == restart.start {
            self.twist = twist;
        }
    }
}

/// The last clear motion before a restart.
#[derive(Debug, Clone, Copy)]
struct Approach {
    /// Its last sample.
    since: usize,
    /// Which way it went.
    motion: Motion,
    /// Whether the machine rested or turned behind it: the slope at the restart then says nothing of
    /// the drive.
    rested: bool,
    /// The measured state there, but for the current.
    state: State,
}

/// Where a replay starts.
#[derive(Debug, Clone, Copy)]
struct Restart {
    start: usize,
    /// The measured state, but for the current.
    state: State,
    /// How it came there, where somebody asks.
    approach: Option<Approach>,
    /// The warmth there, for the heating that was asked for first: few copies have another one.
    warmth: Option<(ThermalDrift, f32)>,
}

/// What run-ins to a restart lead to.
#[derive(Debug, Clone, Copy, Default)]
struct RunIn {
    twists: Option<Twists>,
    /// Where a simulated approach ends.
    behind: Option<Course>,
}

impl Restart {
    fn new(log: &Log, start: usize, settings: &Settings, remembers: bool) -> Self {
        let state = measured_state(log, start, settings);
        let approach = remembers.then(|| approach(log, start, settings));
        Self {
            start,
            state,
            approach,
            warmth: None,
        }
    }

    /// Steps that simulations which remember run in to it.
    fn lead(&self, log: &Log, settings: &Settings) -> usize {
        let simulated = settings.own_velocity(log).is_none();
        let approach = self.approach.filter(|_| simulated);
        approach.map_or(0, |approach| self.start - approach.since)
    }

    /// Sample from which a run-in twists a shaft.
    fn winds_since(&self, log: &Log) -> usize {
        let run_in = samples(SHAFT_RUN_IN, log.period, LEAST_RUN_IN);
        self.start.saturating_sub(run_in).max(LEAST_HALF_WIDTH)
    }

    /// Share by which warmth has raised the resistance of a model's winding.
    fn warmth<M: Borrow<Modes>, H: Acting>(
        &mut self,
        simulator: &Simulator<M, H>,
        log: &Log,
    ) -> f32 {
        let Some(heating) = simulator.heating() else {
            return 0.0;
        };
        match self.warmth {
            Some((known, warmth)) if known == heating => warmth,
            _ => {
                let warmth = warmth_at(simulator, heating, log, self.start);
                self.warmth.get_or_insert((heating, warmth));
                warmth
            }
        }
    }
}

/// Share by which a log up to a sample has raised the resistance of a winding that was cold at its
/// beginning: by the measured current, or by the steady one of input and speed.
fn warmth_at<M: Borrow<Modes>, H: Acting>(
    simulator: &Simulator<M, H>,
    heating: ThermalDrift,
    log: &Log,
    start: usize,
) -> f32 {
    let stride = samples(HEAT_STRIDE, log.period, 1);
    let step = stride as f32 * log.period;
    let mut warmth = 0.0;
    for sample in (stride..=start).step_by(stride) {
        let middle = sample - stride / 2;
        let current = match log.current {
            Some(current) => simulator.current_sensor().current(current.at(middle)),
            None => {
                let travel = log.position.at(sample) - log.position.at(sample - stride);
                simulator.steady_current(travel / step, log.input.at(middle))
            }
        };
        warmth = heating.after(warmth, current, step);
    }
    warmth
}

/// Current of a winding at a sample. It is integrated from the input and the measured motion, from so early that
/// what it began with is forgotten. A measured current corrects it on the way: a wrong start would act like a
/// torque for a time constant of the winding, so that the samples of the last time constant are averaged, each
/// carried on to this one. `state`: that at the sample, smoothed over so many samples on either side.
fn current_at<M: Borrow<Modes>, H: Acting>(
    simulator: &Simulator<M, H>,
    log: &Log,
    start: usize,
    (state, half_width): (&State, usize),
) -> f32 {
    let late = simulator.input_lateness().whole;
    let input = |sample: usize| log.input.at(sample.saturating_sub(late));
    let measured = |sample: usize| log.current.map(|current| simulator.read(current, sample));
    let periods = simulator.electric_periods();
    if periods < FASTEST_WINDING || start <= half_width {
        return measured(start)
            .unwrap_or_else(|| simulator.steady_current(state.velocity.value(), input(start)));
    }
    let longest = samples(WINDOW, log.period, 1).min(start - half_width);
    let back = (FORGOTTEN * periods + 1.0).min(longest as f32) as usize;
    let share = 1.0 - libm::expf(-1.0 / periods);
    let most = periods.max(1.0);
    let mut seen = 1.0;
    let mut current = measured(start - back);
    for sample in start - back..start {
        let travel = log.position.at(sample + half_width) - log.position.at(sample - half_width);
        let velocity = travel / (2.0 * half_width as f32 * log.period);
        let steady = simulator.steady_current(velocity, input(sample));
        let before = current.unwrap_or(steady);
        let mut after = before + share * (steady - before);
        if let Some(measured) = measured(sample + 1) {
            seen = most.min(seen + 1.0);
            after += (measured - after) / seen;
        }
        current = Some(after);
    }
    current.unwrap_or(0.0)
}

/// Deflection of a hysteresis with this reach behind the measured motion up to a sample.
fn deflection_at(log: &Log, start: usize, reach: f32) -> f32 {
    let stride = samples(TURN_STRIDE, log.period, 1);
    let displacement = |end: usize| log.position.at(end) - log.position.at(end - stride);
    let mut begin = start;
    let mut travel = 0.0;
    while begin >= stride && travel < FORGOTTEN * reach {
        travel += displacement(begin).abs();
        begin -= stride;
    }
    let ends = (begin + stride..=start).step_by(stride);
    ends.fold(0.0, |deflection, end| {
        deflected(deflection, displacement(end), reach)
    })
}

/// The last clear motion before what the state at `start` is smoothed over, within the run-in; the
/// one before, where it has hardly begun.
fn approach(log: &Log, start: usize, settings: &Settings) -> Approach {
    let half_width = settings.half_width;
    let earliest = start
        .saturating_sub(MOST_RUN_IN * settings.window)
        .max(half_width);
    let clear_motion = |before: usize| {
        let there = log.position.at(before);
        let mut samples = (earliest..before).rev();
        samples
            .find(|&index| (log.position.at(index) - there).abs() > settings.clear_travel)
            .map(|last| (last, Motion::of(there - log.position.at(last))))
    };
    let before = start - half_width;
    let Some((last, motion)) = clear_motion(before) else {
        // Too near to the beginning of the log to look back over the smoothing?
        let here = log.position.at(start);
        let mut first = (0..start).filter(|_| earliest == half_width);
        let moved = |index: &usize| (here - log.position.at(*index)).abs() > settings.clear_travel;
        if let Some(index) = first.find(moved) {
            return Approach {
                since: start,
                motion: Motion::of(here - log.position.at(index)),
                rested: false,
                state: measured_state(log, start, settings),
            };
        }
        // It has rested as long as anybody looks back: somewhere within the play.
        return Approach {
            since: earliest,
            motion: Motion::Rest,
            rested: true,
            state: measured_state(log, earliest, settings),
        };
    };
    // A slope over the end of a plateau mixes a rest with what comes behind it.
    let turned = last
        .checked_sub(2 * half_width)
        .filter(|&index| index > earliest)
        .and_then(clear_motion)
        .filter(|(_, earlier)| *earlier != motion);
    let resting = clear_motion(start).is_none_or(|(last, _)| 2 * (start - last) > half_width);
    let rested = resting || before - last > half_width || turned.is_some();
    let (since, motion) = turned.unwrap_or((last, motion));
    Approach {
        since,
        motion,
        rested,
        state: measured_state(log, since, settings),
    }
}

/// Steps that simulations run in to a window, where any of them remembers.
fn lead(data: &Data, window: Window, remembers: bool) -> usize {
    let log = &data.logs[window.log];
    Restart::new(log, window.start, &data.settings, remembers).lead(log, &data.settings)
}

/// Whether the machine turns or rests in a window, or shortly before it: where a memory shows.
pub fn turns(data: &Data, window: Window) -> bool {
    let log = &data.logs[window.log];
    let at = |sample: usize| approach(log, sample, &data.settings);
    let (start, end) = (at(window.start), at(window.start + data.settings.window));
    start.rested || end.rested || start.motion != end.motion
}

/// The measured state at a sample, but for the current.
fn measured_state(log: &Log, start: usize, settings: &Settings) -> State {
    measured_state_less(log, start, settings, |_| 0.0)
}

/// The same less a known part of each position.
fn measured_state_less(
    log: &Log,
    start: usize,
    settings: &Settings,
    part: impl Fn(usize) -> f32 + Copy,
) -> State {
    let state = log.smoothed_state_less(start, settings.half_width, settings.resolution, part);
    match log.velocity {
        Some(velocity) if settings.measured_velocity => {
            State::new(state.position.value(), velocity.at(start))
        }
        _ => state,
    }
}

/// Products of the columns, summed over one window.
pub type WindowSums = Triangle<f32, { entries(COLUMNS) }>;

/// Replays one window with the model and its perturbed copies and adds the products of
/// (residual, sensitivities) to the sums.
fn accumulate(sums: &mut WindowSums, data: &Data, window: Window, ensemble: &Ensemble) {
    let log = &data.logs[window.log];
    let settings = &data.settings;
    let simulators = ensemble.simulators();
    let remembers = simulators.iter().any(Simulator::remembers);
    let mut restart = Restart::new(log, window.start, settings, remembers);
    let mut shared = RunIn::default();
    let mut runners: Vec<Runner<&Modes, Varied>, MOST_SIMULATORS> = simulators
        .iter()
        .map(|simulator| {
            let model = ensemble.shared_run_in();
            let mut own = RunIn::default();
            let run_in = if model.is_some_and(|model| simulator.runs_in_like(model)) {
                &mut shared
            } else {
                &mut own
            };
            Runner::from_restart(simulator, log, &mut restart, settings, run_in)
        })
        .collect();
    let mut positions = [0.0f32; COLUMNS];
    let mut currents = [0.0f32; COLUMNS];
    let columns = ensemble.lanes().len() + 1;
    let sensor = ensemble.current_sensor();
    let late = ensemble.reads_within_steps();
    let mut last = 0.0;
    for index in window.start..window.start + settings.window {
        let row = Row::new(log, index);
        let mut residuals = runners
            .iter_mut()
            .map(|runner| runner.advance_and_see(&row));
        let mut next = || residuals.next().unwrap_or_default();
        let (centre, (seen, rise)) = next();
        let before = core::mem::replace(&mut last, rise);
        let seen = (seen, if late { rise } else { before });
        positions[0] = centre.0 * settings.position_weight;
        currents[0] = centre.1 * settings.current_weight;
        for (column, lane) in ensemble.lanes().iter().enumerate() {
            let (position, current) = (&mut positions[column + 1], &mut currents[column + 1]);
            match lane.source {
                Source::Copies {
                    two_sided,
                    inverse_step,
                } => {
                    let moved = next().0;
                    let from = if two_sided { next().0 } else { centre };
                    *position = (moved.0 - from.0) * settings.position_weight * inverse_step;
                    *current = (moved.1 - from.1) * settings.current_weight * inverse_step;
                }
                Source::Sensor { reading, scale } => {
                    *position = 0.0;
                    *current = if log.current.is_some() {
                        sensor.slope(reading, seen) * settings.current_weight * scale
                    } else {
                        0.0
                    };
                }
            }
        }
        let with_current = settings.current_weight > 0.0;
        for (column, sums) in sums.rows_mut().take(columns).enumerate() {
            let (position, current) = (positions[column], currents[column]);
            let add = |sums: &mut [f32], first: usize| {
                let others = (&positions[first..], &currents[first..]);
                if with_current {
                    add_products(sums, (position, current), others);
                } else {
                    add_position_products(sums, position, others.0);
                }
            };
            let (before, own) = ensemble.partners(column);
            add(&mut sums[own..], own);
            if before > 0 {
                add(&mut sums[..before], 0);
            }
        }
    }
}

/// Adds the products of both channels: position first.
#[inline]
fn add_products(
    sums: &mut [f32],
    (position, current): (f32, f32),
    (positions, currents): (&[f32], &[f32]),
) {
    for (sum, (other, flow)) in sums.iter_mut().zip(positions.iter().zip(currents)) {
        *sum = *sum + position * other + current * flow;
    }
}

#[inline]
fn add_position_products(sums: &mut [f32], position: f32, positions: &[f32]) {
    for (sum, other) in sums.iter_mut().zip(positions) {
        *sum += position * other;
    }
}

/// The sums of windows.
struct Accumulate<'a> {
    data: &'a Data<'a>,
    fold: (Fold, usize),
    ensemble: &'a Ensemble<'a>,
}

impl Accumulate<'_> {
    fn window(&self, number: usize) -> Option<Window> {
        self.data.window(Data::number_in_fold(self.fold, number))
    }
}

impl Job for Accumulate<'_> {
    type Result = WindowSums;

    fn lead(&self, number: usize) -> usize {
        let simulators = self.ensemble.simulators();
        let remembers = simulators.iter().any(Simulator::remembers);
        let window = self.window(number);
        window.map_or(0, |window| lead(self.data, window, remembers))
    }

    #[inline(always)]
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [WindowSums]) {
        let at = |place: usize| self.window(numbers[place]);
        if N > 1 {
            accumulate_all::<N>(results, self.data, at, self.ensemble);
        } else if let (Some(sums), Some(window)) = (results.first_mut(), at(0)) {
            accumulate(sums, self.data, window, self.ensemble);
        }
    }
}

/// As [`accumulate`], in several windows.
#[inline(always)]
fn accumulate_all<const N: usize>(
    results: &mut [WindowSums],
    data: &Data,
    at: impl Fn(usize) -> Option<Window>,
    ensemble: &Ensemble,
) {
    let simulators = ensemble.simulators();
    let Some(mut places) = Places::<N>::new(data, results.len(), at, simulators) else {
        return;
    };
    let settings = &data.settings;
    let mut replays: Vec<Replay<&Modes, Varied, N>, MOST_SIMULATORS> = simulators
        .iter()
        .map(|simulator| places.start(simulator))
        .collect();
    if let Some(model) = ensemble.shared_run_in() {
        for replay in replays.iter_mut().skip(1) {
            replay.follow(model);
        }
    }
    let mut positions = [[0.0f32; N]; COLUMNS];
    let mut currents = [[0.0f32; N]; COLUMNS];
    let mut sums = [[0.0f32; N]; entries(COLUMNS)];
    let mut residuals = [([0.0f32; N], [0.0f32; N]); MOST_SIMULATORS];
    let columns = ensemble.lanes().len() + 1;
    let (position_weight, current_weight) = (settings.position_weight, settings.current_weight);
    let with_current = current_weight > 0.0;
    let sensor = ensemble.current_sensor();
    let measured = places.measured_current();
    let late = ensemble.reads_within_steps();
    let mut last = [0.0; N];
    for _ in 0..places.steps() {
        let Some((seen, rises)) = places.step(&mut replays, &mut residuals) else {
            continue;
        };
        let before = core::mem::replace(&mut last, rises);
        let rises = if late { rises } else { before };
        let mut next = 1;
        let centre = &residuals[0];
        for lane in 0..N {
            positions[0][lane] = centre.0[lane] * position_weight;
            currents[0][lane] = centre.1[lane] * current_weight;
        }
        for (column, perturbed) in ensemble.lanes().iter().enumerate() {
            let (position, current) = (&mut positions[column + 1], &mut currents[column + 1]);
            match perturbed.source {
                Source::Copies {
                    two_sided,
                    inverse_step,
                } => {
                    let moved = &residuals[next];
                    let from = if two_sided {
                        &residuals[next + 1]
                    } else {
                        centre
                    };
                    next += 1 + usize::from(two_sided);
                    for lane in 0..N {
                        position[lane] =
                            (moved.0[lane] - from.0[lane]) * position_weight * inverse_step;
                        current[lane] =
                            (moved.1[lane] - from.1[lane]) * current_weight * inverse_step;
                    }
                }
                Source::Sensor { reading, scale } => {
                    for lane in 0..N {
                        position[lane] = 0.0;
                        current[lane] = if measured[lane] {
                            sensor.slope(reading, (seen[lane], rises[lane]))
                                * current_weight
                                * scale
                        } else {
                            0.0
                        };
                    }
                }
            }
        }
        for column in 0..columns {
            let (before, own) = ensemble.partners(column);
            let (position, current) = (positions[column], currents[column]);
            let sums = &mut sums[entries(column)..];
            for other in 0..=column {
                if other >= before && other < own {
                    continue;
                }
                let (positions, currents) = (&positions[other], &currents[other]);
                let sum = &mut sums[other];
                for lane in 0..N {
                    sum[lane] += position[lane] * positions[lane];
                }
                if with_current {
                    for lane in 0..N {
                        sum[lane] += current[lane] * currents[lane];
                    }
                }
            }
        }
    }
    for (lane, result) in results.iter_mut().enumerate() {
        for (column, row) in result.rows_mut().take(columns).enumerate() {
            for (sum, lanes) in row.iter_mut().zip(&sums[entries(column)..]) {
                *sum = lanes[lane];
            }
        }
    }
}

/// Errors of one window, in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WindowError {
    /// Sum of the squared position residuals.
    pub position: f32,
    /// Sum of the squared current residuals.
    pub current: f32,
    /// Largest position residual.
    pub largest: f32,
}

/// What a replay of one window comes to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Replayed {
    pub error: WindowError,
    /// Sum of the squared weighted residuals: the first of the window's sums.
    pub cost: f32,
}

impl Replayed {
    #[inline(always)]
    fn add(&mut self, (position, current): (f32, f32), settings: &Settings) {
        let error = &mut self.error;
        error.position += position * position;
        error.current += current * current;
        error.largest = error.largest.max(position.abs());
        let position = position * settings.position_weight;
        self.cost += position * position;
        if settings.current_weight > 0.0 {
            let current = current * settings.current_weight;
            self.cost += current * current;
        }
    }
}

/// Windows to be replayed.
pub(super) struct Replays<'a> {
    pub data: &'a Data<'a>,
    pub simulator: &'a Simulator,
    /// Where a window lies, by its number among them.
    pub window: &'a (dyn Fn(usize) -> Option<Window> + Sync),
}

impl Job for Replays<'_> {
    type Result = Replayed;

    fn lead(&self, number: usize) -> usize {
        let remembers = self.simulator.remembers();
        let window = (self.window)(number);
        window.map_or(0, |window| lead(self.data, window, remembers))
    }

    #[inline(always)]
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [Replayed]) {
        let at = |place: usize| (self.window)(numbers[place]);
        replay::<N>(results, self.data, at, self.simulator);
    }
}

/// Replays as many windows as there are results, at most `N` and in lockstep.
#[inline(always)]
pub(super) fn replay<const N: usize>(
    results: &mut [Replayed],
    data: &Data,
    at: impl Fn(usize) -> Option<Window>,
    simulator: &Simulator,
) {
    if N > 1 {
        replay_all::<N>(results, data, at, simulator);
    } else if let (Some(result), Some(window)) = (results.first_mut(), at(0)) {
        replay_one(result, data, window, simulator);
    }
}

fn replay_one(result: &mut Replayed, data: &Data, window: Window, simulator: &Simulator) {
    let log = &data.logs[window.log];
    let mut runner = Runner::new(simulator, log, window.start, &data.settings);
    for index in window.start..window.start + data.settings.window {
        result.add(runner.advance(&Row::new(log, index)), &data.settings);
    }
}

#[inline(always)]
fn replay_all<const N: usize>(
    results: &mut [Replayed],
    data: &Data,
    at: impl Fn(usize) -> Option<Window>,
    simulator: &Simulator,
) {
    let simulators = slice::from_ref(simulator);
    let Some(mut places) = Places::<N>::new(data, results.len(), at, simulators) else {
        return;
    };
    let settings = &data.settings;
    let mut replays = [places.start(simulator)];
    let mut residuals = [([0.0; N], [0.0; N])];
    let (mut position, mut current, mut largest) = ([0.0; N], [0.0; N], [0.0; N]);
    let mut cost = [0.0; N];
    for _ in 0..places.steps() {
        if places.step(&mut replays, &mut residuals).is_none() {
            continue;
        }
        let [(positions, currents)] = &residuals;
        for lane in 0..N {
            let mut replayed = Replayed {
                error: WindowError {
                    position: position[lane],
                    current: current[lane],
                    largest: largest[lane],
                },
                cost: cost[lane],
            };
            replayed.add((positions[lane], currents[lane]), settings);
            position[lane] = replayed.error.position;
            current[lane] = replayed.error.current;
            largest[lane] = replayed.error.largest;
            cost[lane] = replayed.cost;
        }
    }
    for (lane, result) in results.iter_mut().enumerate() {
        *result = Replayed {
            error: WindowError {
                position: position[lane],
                current: current[lane],
                largest: largest[lane],
            },
            cost: cost[lane],
        };
    }
}

/// What two simulations make of one window.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Contrast {
    /// Errors of the first and of the second.
    pub errors: [WindowError; 2],
    /// Sum of the squared distances between their positions.
    pub apart: f32,
}

/// Windows to be replayed by two simulators, each with its own way of restarting. Both cut the same
/// logs into the same windows.
pub(super) struct Contrasts<'a> {
    /// The logs as the first and as the second one restarts in them.
    pub data: [&'a Data<'a>; 2],
    /// The first and the second simulator.
    pub simulators: [&'a Simulator; 2],
}

impl Job for Contrasts<'_> {
    type Result = Contrast;

    fn lead(&self, number: usize) -> usize {
        let window = self.data[0].window(number);
        let leads = self.data.iter().zip(self.simulators);
        let leads = leads.map(|(data, simulator)| {
            window.map_or(0, |window| lead(data, window, simulator.remembers()))
        });
        leads.max().unwrap_or(0)
    }

    #[inline(always)]
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [Contrast]) {
        if N > 1 {
            self.work_all::<N>(numbers, results);
        } else if let (Some(result), Some(&number)) = (results.first_mut(), numbers.first()) {
            self.work_one(number, result);
        }
    }
}

impl Contrasts<'_> {
    fn work_one(&self, number: usize, result: &mut Contrast) {
        let [first, second] = self.data;
        let Some(window) = first.window(number) else {
            return;
        };
        let log = &first.logs[window.log];
        let runner =
            |simulator, data: &Data| Runner::new(simulator, log, window.start, &data.settings);
        let mut runners = [
            runner(self.simulators[0], first),
            runner(self.simulators[1], second),
        ];
        for index in window.start..window.start + first.settings.window {
            let row = Row::new(log, index);
            let [one, other] = &mut runners;
            result.add([one.advance(&row), other.advance(&row)]);
        }
    }

    #[inline(always)]
    fn work_all<const N: usize>(&self, numbers: &[usize], results: &mut [Contrast]) {
        let count = results.len();
        let start = |place: usize| {
            let (data, simulator) = (self.data[place], self.simulators[place]);
            let at = |lane: usize| data.window(numbers[lane]);
            let mut places = Places::<N>::new(data, count, at, slice::from_ref(simulator))?;
            let replay = places.start(simulator);
            Some((places, [replay]))
        };
        let (Some(mut first), Some(mut second)) = (start(0), start(1)) else {
            return;
        };
        for _ in 0..self.data[0].settings.window {
            let mut residuals = [[([0.0; N], [0.0; N])]; 2];
            // Run-ins lead to the windows; of these each has as many steps.
            for ((places, replay), residual) in
                [&mut first, &mut second].into_iter().zip(&mut residuals)
            {
                while places.step(replay, residual).is_none() {}
            }
            for (lane, result) in results.iter_mut().enumerate() {
                result.add(residuals.map(|[(position, second)]| (position[lane], second[lane])));
            }
        }
    }
}

impl Contrast {
    /// Takes the residuals of a step.
    #[inline(always)]
    fn add(&mut self, residuals: [(f32, f32); 2]) {
        for (error, (position, second)) in self.errors.iter_mut().zip(residuals) {
            error.position += position * position;
            error.current += second * second;
            error.largest = error.largest.max(position.abs());
        }
        let apart = residuals[0].0 - residuals[1].0;
        self.apart += apart * apart;
    }
}

/// What is to be done with windows.
pub trait Job: Sync {
    /// What a window gives.
    type Result: Default + Send;

    /// Steps that lead to a window. Those of one length are best worked on side by side: a short way
    /// waits for a long one.
    fn lead(&self, _number: usize) -> usize {
        0
    }

    /// Works on the windows of these numbers, in rising order and at most `N`, in lockstep; each has its
    /// result. The bits depend neither on `N` nor on what lies beside a window.
    fn work<const N: usize>(&self, numbers: &[usize], results: &mut [Self::Result]);
}

/// Who works on the windows: one core in order, or several.
pub trait Schedule {
    /// Calls `work` for 0 … `count` − 1 in any order, each time with a default result to fill in, and
    /// `fold` with the results in that order.
    fn run<R: Default + Send>(
        &self,
        count: usize,
        work: impl Fn(usize, &mut R) + Send + Sync,
        fold: impl FnMut(usize, &R),
    );

    /// The same with a job, of which several may be done in lockstep.
    fn run_job<J: Job>(&self, count: usize, job: &J, fold: impl FnMut(usize, &J::Result)) {
        let one = |number, result: &mut J::Result| {
            job.work::<1>(&[number], slice::from_mut(result));
        };
        self.run(count, one, fold);
    }
}

/// One core, in order: the chip's way.
#[derive(Debug, Clone, Copy, Default)]
pub struct InOrder;

impl Schedule for InOrder {
    fn run<R: Default + Send>(
        &self,
        count: usize,
        work: impl Fn(usize, &mut R) + Send + Sync,
        mut fold: impl FnMut(usize, &R),
    ) {
        for index in 0..count {
            let mut result = R::default();
            work(index, &mut result);
            fold(index, &result);
        }
    }
}

/// Errors of all windows, in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TotalError {
    position: f64,
    current: f64,
    /// Largest position residual.
    pub largest: f32,
    /// Windows replayed.
    pub windows: usize,
    samples: usize,
}

impl TotalError {
    /// Root mean square of the position residuals; 0 without windows.
    pub fn position_rms(&self) -> f64 {
        libm::sqrt(self.position / self.samples.max(1) as f64)
    }

    /// Root mean square of the current residuals; 0 without windows or without current.
    pub fn current_rms(&self) -> f64 {
        libm::sqrt(self.current / self.samples.max(1) as f64)
    }
}

/// Replays all windows and sums their errors in the order of the log.
pub fn total_error(data: &Data, schedule: &impl Schedule, simulator: &Simulator) -> TotalError {
    let mut total = TotalError::default();
    schedule.run_job(
        data.windows(),
        &Replays {
            data,
            simulator,
            window: &|number| data.window(number),
        },
        |_, Replayed { error, .. }| {
            total.position += f64::from(error.position);
            total.current += f64::from(error.current);
            total.largest = total.largest.max(error.largest);
            total.windows += 1;
            total.samples += data.settings.window;
        },
    );
    total
}

/// Which windows take part, by blocks of neighbouring windows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fold {
    /// All of them.
    All,
    /// Blocks 0, 2, 4, …
    Even,
    /// Blocks 1, 3, 5, …
    Odd,
}

/// Sum of the squared weighted residuals over the windows of a fold, to the bit the first of
/// [`Sums`]' products, and how many windows these are.
pub fn cost(
    data: &Data,
    schedule: &impl Schedule,
    (fold, block): (Fold, usize),
    simulator: &Simulator,
) -> (f64, usize) {
    let mut total = 0.0;
    let fold = (fold, block);
    let windows = data.windows_in_fold(fold);
    let replays = Replays {
        data,
        simulator,
        window: &|place| data.window(Data::number_in_fold(fold, place)),
    };
    schedule.run_job(windows, &replays, |_, replayed| {
        total += f64::from(replayed.cost);
    });
    (total, windows)
}

/// Least-squares sums over the windows of a fold.
#[derive(Debug, Clone, Default)]
pub struct Sums {
    /// Products of the columns; 0 is the residual.
    pub products: Triangle<f64, { entries(COLUMNS) }>,
    /// Windows that took part.
    pub windows: usize,
}

/// Replays the windows of a fold with a model and its copies. `observe` is told the sums of each
/// window, in the order of the log.
pub fn replay_windows(
    data: &Data,
    schedule: &impl Schedule,
    fold: (Fold, usize),
    ensemble: &Ensemble,
    mut observe: impl FnMut(&WindowSums),
) {
    let job = Accumulate {
        data,
        fold,
        ensemble,
    };
    schedule.run_job(data.windows_in_fold(fold), &job, |_, sums| observe(sums));
}

impl Sums {
    /// Replays the windows of a fold and sums them up in the order of the log.
    pub fn replay(
        &mut self,
        data: &Data,
        schedule: &impl Schedule,
        fold: (Fold, usize),
        ensemble: &Ensemble,
    ) {
        *self = Self::default();
        replay_windows(data, schedule, fold, ensemble, |window| {
            self.add(window, ensemble);
        });
    }

    fn add(&mut self, window: &WindowSums, ensemble: &Ensemble) {
        self.windows += 1;
        for row in 0..=ensemble.lanes().len() {
            let (before, own) = ensemble.partners(row);
            let products = self.products.row_mut(row);
            for partners in [0..before, own..row + 1] {
                for column in partners {
                    products[column] += f64::from(window.row(row)[column]);
                }
            }
        }
    }

    /// Windows simulated, each copy counted.
    pub fn simulated(&self, ensemble: &Ensemble) -> u64 {
        self.windows as u64 * ensemble.simulators().len() as u64
    }
}
