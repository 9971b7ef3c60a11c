//! One simulation on its way through a window.

use super::data::{Settings, WindowStart};
use super::restart::{
    Approach, Restart, RunIn, Twists, current_at, deflection_at, measured_state,
    measured_state_less,
};
use crate::effect::compliance::Shaft;
use crate::gap::held::{Acting, Held};
use crate::gap::log::Log;
use crate::gap::simulator::{Course, Given, Simulator};
use crate::numeric::straight_line::StraightLine;
use crate::plant::actuator::External;
use crate::plant::modes::{Deviation, Modes};
use crate::plant::{Compensated, Motion, State};
use core::borrow::Borrow;

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
    /// What acts from outside, held over it.
    external: External,
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
            external: log.external(index),
        }
    }
}

/// One simulation on its way through a window.
pub struct Runner<'a, M = Modes, H = Held> {
    pub(super) simulator: &'a Simulator<M, H>,
    pub(super) log: &'a Log<'a>,
    pub(super) course: Course,
    pub(super) velocity_channel: bool,
}

impl<'a, M: Borrow<Modes>, H: Acting> Runner<'a, M, H> {
    /// Starts at sample `start` of the log.
    pub fn new(
        simulator: &'a Simulator<M, H>,
        log: &'a Log<'a>,
        start: usize,
        settings: &Settings,
    ) -> Self {
        let mut restart = Restart::new(log, start, settings, simulator.is_stateful());
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
    pub(super) fn from_restart(
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
            Some(approach) if simulator.is_stateful() => {
                runner.behind(approach, restart, settings, &mut run_in.behind)
            }
            _ => runner,
        }
    }

    /// The same without a shaft's twist.
    pub(super) fn unwound(
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
        runner.course.memory.deflection = restart.deflection(simulator, log);
        // What is wound starts from the slope.
        let is_simulated =
            settings.window_start == WindowStart::Simulated && simulator.shaft().is_none();
        if is_simulated && restart.state.velocity.value() != 0.0 {
            let state = runner.come_to(restart, settings);
            runner.course = Course::with_history(state, &runner.course.memory);
        }
        runner
    }

    /// The state that the model reaches at a restart from the measured one some time before, shifted to be nearest to the log
    /// on the way, in least squares. The offset of the position is taken as constant on the way, and a deviation of the
    /// velocity changes by inertia, viscous friction, spring and winding alone: effects are left out.
    // Its frame is not to lie under the simulations behind it.
    #[inline(never)]
    fn come_to(&self, restart: &Restart, settings: &Settings) -> State {
        let (simulator, log) = (self.simulator, self.log);
        let since = restart.simulated_since(log, settings);
        // At the beginning of a log there is no time to be simulated in, and the modes carry a deviation as in a closed circuit.
        let is_short = restart.start < since + settings.half_width;
        if is_short || (since..restart.start).any(|index| log.is_released(index)) {
            return self.course.state;
        }
        let measured = measured_state(log, since, settings);
        let mut before = Self::from_state(simulator, log, (since, measured), settings);
        before.course = Course::with_history(before.course.state, &self.course.memory);
        simulator.lean(&mut before.course, Motion::of(measured.velocity.value()));
        let mut last = 0.0;
        let mut deviation = Deviation::of_velocity(1.0);
        let mut line = StraightLine::default();
        for index in since..restart.start {
            last = before.advance(&Row::new(log, index)).0;
            simulator.carry(&mut deviation, before.course.state.motion);
            line.add(deviation.position, last);
        }
        let come = before.course.state;
        let slope = line.slope();
        let velocity = come.velocity.value() - slope * deviation.velocity;
        // A deviation that turns or stops the motion does not grow in proportion.
        let slope = if Motion::of(velocity) == come.motion {
            slope
        } else {
            0.0
        };
        let less = |value: f32, deviation: f32| value - slope * deviation;
        let (mean_deviation, mean) = line.means();
        let ahead = less(last - mean, deviation.position - mean_deviation);
        // Where the sensor would be then, and from there the drive.
        let measured = State {
            position: Compensated::new(log.position.at(restart.start) + ahead),
            ..restart.state
        };
        State {
            position: simulator.state_behind(measured, false).position,
            velocity: Compensated::new(less(come.velocity.value(), deviation.velocity)),
            current: less(come.current, deviation.current),
            ..come
        }
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
    pub(super) fn before(&self, restart: &Restart, settings: &Settings) -> Self {
        let since = restart.winds_since(self.log);
        let narrow = Settings {
            half_width: settings.half_width.min(since),
            ..*settings
        };
        let state = measured_state(self.log, since, &narrow);
        let mut run_in = Self::from_state(self.simulator, self.log, (since, state), settings);
        run_in.course.memory.warmth = self.course.memory.warmth;
        run_in.course.memory.deflection = run_in.deflection_at(since);
        run_in
    }

    /// With the twist that a run-in leads to.
    pub(super) fn wound(
        &mut self,
        shaft: &Shaft,
        twists: &Twists,
        restart: &Restart,
        settings: &Settings,
    ) {
        let (log, start) = (self.log, restart.start);
        let first = start - settings.half_width;
        let ahead = |index: usize| shaft.ahead() * twists.angles[index - first];
        let state = measured_state_less(log, start, settings, ahead);
        let wound = Self::from_state(self.simulator, log, (start, state), settings);
        self.course = Course::with_history(wound.course.state, &self.course.memory);
        let own_velocity = settings.own_velocity(log).is_some();
        self.simulator
            .twist(&mut self.course, shaft, twists.twist, own_velocity);
    }

    /// With what the effects remember of the approach to the restart, or of another simulator's if that
    /// is known; a simulated one is, then.
    pub(super) fn behind(
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
    pub(super) fn run_in(&self, approach: &Approach, settings: &Settings) -> Self {
        let since = (approach.since, approach.state);
        let mut run_in = Self::from_state(self.simulator, self.log, since, settings);
        run_in.course.memory.warmth = self.course.memory.warmth;
        run_in.course.memory.deflection = run_in.deflection_at(approach.since);
        self.simulator.lean(&mut run_in.course, approach.motion);
        run_in
    }

    /// With what the effects remember behind the approach, and how much further the drive is than a
    /// simulation of it says.
    pub(super) fn resumed(
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
        Self {
            simulator,
            log,
            course: Course::new(state),
            velocity_channel: false,
        }
    }

    /// What a hysteresis remembers at a sample of the log.
    fn deflection_at(&self, sample: usize) -> f32 {
        let reach = self.simulator.reach();
        reach.map_or(0.0, |reach| deflection_at(self.log, sample, reach))
    }

    /// Steps from a sample to the next and gives the residuals, model less measurement: of the
    /// position at the next sample, and of the current at this one or of the velocity at the next.
    #[inline]
    pub fn advance(&mut self, row: &Row) -> (f32, f32) {
        self.advance_and_see(row).0
    }

    /// The same; and the current that its sensor sees, with how fast that rises, A and A/s.
    #[inline]
    pub(super) fn advance_and_see(&mut self, row: &Row) -> ((f32, f32), (f32, f32)) {
        let before = self.course.state.current;
        let late = self.simulator.input_lateness();
        // Before the log its first input acts, and behind it its last one.
        let inputs = self.log.input;
        let input = if late.is_at_hand() {
            row.input
        } else {
            late.read(inputs, row.index)
        };
        let previous = if late.share == 0.0 {
            input
        } else {
            late.one_more().read(inputs, row.index)
        };
        let given = Given {
            input,
            previous,
            external: row.external,
            index: row.index,
        };
        // A refused input leaves the state: logs are checked on reading, so none is.
        let predicted = self
            .simulator
            .step(&mut self.course, &given)
            .unwrap_or(self.course.state.current);
        let reading = self.simulator.current_lateness();
        let read = self.simulator.current_sensor().reading(predicted);
        let current = match (row.current, self.log.current) {
            (Some(measured), _) if reading.is_at_hand() => read - measured,
            (_, Some(measured)) => read - reading.read(measured, row.index),
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
