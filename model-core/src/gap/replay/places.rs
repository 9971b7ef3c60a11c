//! Windows side by side, replayed in lockstep.
//!
//! Simulators whose effects remember run in to the restart, and before that those with a shaft past it,
//! to twist it. The way there is longer in one window than in another, so that lanes begin one after the
//! other and come there together; those that sleep are left where they are.

use super::data::{Data, Settings, Window};
use super::restart::{Restart, Twists};
use super::runner::Runner;
use crate::gap::held::Acting;
use crate::gap::lateness::Lateness;
use crate::gap::log::Log;
use crate::gap::simulator::lockstep::{Givens, Lockstep};
use crate::gap::simulator::{Course, Simulator};
use crate::plant::actuator::External;
use crate::plant::lanes::Lanes;
use crate::plant::modes::Modes;
use core::array;
use core::borrow::Borrow;

/// Windows side by side, and how far a replay is in them.
pub(super) struct Places<'a, const N: usize> {
    logs: [&'a Log<'a>; N],
    settings: &'a Settings,
    /// Lanes that have a window of their own.
    count: usize,
    /// What is compared besides the position.
    seconds: [Second; N],
    restarts: [Restart; N],
    /// What twists a shaft, where there is one.
    winding: Leads<N>,
    /// Steps past the restart that it takes, 0 without a shaft.
    wound: usize,
    run_in: Leads<N>,
    /// Steps made.
    step: usize,
}

/// Steps that a lane makes before the restart, and most of them.
#[derive(Clone, Copy)]
struct Leads<const N: usize> {
    each: [usize; N],
    most: usize,
}

impl<const N: usize> Leads<N> {
    pub(super) fn new(each: [usize; N]) -> Self {
        let most = each.into_iter().max().unwrap_or(0);
        Self { each, most }
    }
}

/// What a step is made for.
#[derive(Clone, Copy, PartialEq)]
enum Phase {
    /// To twist a shaft.
    Winding,
    /// For what effects remember.
    RunIn,
    /// For the residuals.
    Window,
}

/// A simulator in the windows.
pub(super) struct Replay<'s, M, H, const N: usize> {
    lanes: Lockstep<'s, M, H, N>,
    /// Where it restarts, without what the effects remember.
    restarts: [Course; N],
    pub twists: [Twists; N],
    /// Whether it starts from where the first simulator beside it has run in to.
    follows: bool,
}

impl<M: Borrow<Modes>, H: Acting, const N: usize> Replay<'_, M, H, N> {
    /// Has it start from where the first simulator beside it, which is this one, has run in to, if it
    /// runs in like that.
    pub(super) fn follow(&mut self, first: &Simulator<M, H>) {
        self.follows = self.lanes.simulator().runs_in_like(first);
    }

    /// Where it is.
    fn courses(&self) -> [Course; N] {
        array::from_fn(|lane| self.lanes.at(lane))
    }

    /// Whether it takes steps that are made for this.
    #[inline(always)]
    fn takes(&self, phase: Phase) -> bool {
        let simulator = self.lanes.simulator();
        match phase {
            Phase::Winding => simulator.shaft().is_some() && !self.follows,
            Phase::RunIn => simulator.is_stateful() && !self.follows,
            Phase::Window => true,
        }
    }
}

/// The second channel of a log.
#[derive(Clone, Copy)]
enum Second {
    Current,
    Velocity,
    Nothing,
}

/// What the logs say of one step, for all simulations that take it: a
/// [`Row`](super::Row) of each lane.
struct Rows<const N: usize> {
    given: Givens<N>,
    next_position: Lanes<N>,
    current: Lanes<N>,
    next_velocity: Lanes<N>,
}

impl<'a, const N: usize> Places<'a, N> {
    /// Before so many windows, for these simulators; lanes that are left stay at the last of them.
    pub(super) fn new<M: Borrow<Modes>, H: Acting>(
        data: &'a Data<'a>,
        count: usize,
        at: impl Fn(usize) -> Option<Window>,
        simulators: &[Simulator<M, H>],
    ) -> Option<Self> {
        let is_stateful = simulators.iter().any(Simulator::is_stateful);
        let winds = simulators.iter().any(|it| it.shaft().is_some());
        let settings = &data.settings;
        let mut windows = [at(0)?; N];
        for (lane, window) in windows.iter_mut().enumerate() {
            *window = at(lane.min(count - 1))?;
        }
        let logs = windows.map(|window| &data.logs[window.log]);
        let seconds = logs.map(|log| match (log.current, log.velocity) {
            (Some(_), _) => Second::Current,
            (None, Some(_)) if settings.velocity_channel => Second::Velocity,
            _ => Second::Nothing,
        });
        let restarts: [Restart; N] = array::from_fn(|lane| {
            Restart::new(logs[lane], windows[lane].start, settings, is_stateful)
        });
        let run_in = Leads::new(array::from_fn(|lane| {
            restarts[lane].lead(logs[lane], settings)
        }));
        let winding = Leads::new(array::from_fn(|lane| {
            restarts[lane].start - restarts[lane].winds_since(logs[lane])
        }));
        let wound = if winds {
            winding.most + settings.half_width
        } else {
            0
        };
        Some(Self {
            logs,
            settings,
            count,
            seconds,
            restarts,
            winding,
            wound,
            run_in,
            step: 0,
        })
    }

    /// A simulator where it begins: at the restarts, or before them where it runs in.
    pub(super) fn start<'s, M: Borrow<Modes>, H: Acting>(
        &mut self,
        simulator: &'s Simulator<M, H>,
    ) -> Replay<'s, M, H, N> {
        let mut restarts = [Course::default(); N];
        for (lane, course) in restarts.iter_mut().enumerate() {
            let (log, restart) = (self.logs[lane], &mut self.restarts[lane]);
            *course = Runner::unwound(simulator, log, restart, self.settings).course;
        }
        let mut courses = restarts;
        for (lane, course) in courses.iter_mut().enumerate() {
            let there = self.runner(simulator, lane, *course);
            *course = if simulator.shaft().is_some() {
                let restart = &self.restarts[lane];
                there.before(restart, self.settings).course
            } else {
                self.entered(&there, lane)
            };
        }
        Replay {
            lanes: Lockstep::new(simulator, &courses),
            restarts,
            twists: [Twists::new(); N],
            follows: false,
        }
    }

    /// A simulator somewhere in a lane.
    fn runner<'s, M: Borrow<Modes>, H: Acting>(
        &'s self,
        simulator: &'s Simulator<M, H>,
        lane: usize,
        course: Course,
    ) -> Runner<'s, M, H> {
        Runner {
            simulator,
            log: self.logs[lane],
            course,
            velocity_channel: self.settings.velocity_channel,
        }
    }

    /// Where a simulator that is to restart there runs in, if it does.
    fn entered<M: Borrow<Modes>, H: Acting>(
        &self,
        there: &Runner<'_, M, H>,
        lane: usize,
    ) -> Course {
        let restart = &self.restarts[lane];
        match &restart.approach {
            Some(approach) if there.simulator.is_stateful() => {
                if self.run_in.each[lane] > 0 {
                    there.run_in(approach, self.settings).course
                } else {
                    there
                        .behind(approach, restart, self.settings, &mut None)
                        .course
                }
            }
            _ => there.course,
        }
    }

    /// Takes down the twists behind a step.
    #[inline(never)]
    pub(super) fn observe<M: Borrow<Modes>, H: Acting>(
        &self,
        replay: &mut Replay<M, H, N>,
        samples: &[usize; N],
    ) {
        for lane in 0..N {
            let twist = replay.lanes.at(lane).memory.twist;
            let (restart, sample) = (&self.restarts[lane], samples[lane] + 1);
            replay.twists[lane].observe(twist, sample, restart, self.settings);
        }
    }

    /// Puts a simulator whose shaft is twisted to the restarts, or where it runs in to them.
    #[inline(never)]
    fn wind<M: Borrow<Modes>, H: Acting>(
        &self,
        replay: &mut Replay<M, H, N>,
        twists: &[Twists; N],
    ) {
        let simulator = replay.lanes.simulator();
        let Some(shaft) = simulator.shaft() else {
            return;
        };
        for lane in 0..N {
            let (restart, twists) = (&self.restarts[lane], &twists[lane]);
            let mut there = self.runner(simulator, lane, replay.restarts[lane]);
            there.wound(shaft, twists, restart, self.settings);
            replay.restarts[lane] = there.course;
            replay.lanes.put(lane, &self.entered(&there, lane));
        }
    }

    /// Puts a simulator that has run in to the restarts.
    #[inline(never)]
    fn resume<M: Borrow<Modes>, H: Acting>(
        &self,
        replay: &mut Replay<M, H, N>,
        behind: &[Course; N],
    ) {
        let simulator = replay.lanes.simulator();
        for lane in 0..N {
            let approach = self.restarts[lane].approach.as_ref();
            let ran_in = |_: &&_| self.run_in.each[lane] > 0 && simulator.is_stateful();
            if let Some(approach) = approach.filter(ran_in) {
                let there = self.runner(simulator, lane, replay.restarts[lane]);
                let run_in = (&behind[lane], 0.0);
                let resumed = there.resumed(run_in, approach, self.settings);
                replay.lanes.put(lane, &resumed.course);
            }
        }
    }

    /// Steps of all phases.
    pub(super) fn steps(&self) -> usize {
        self.wound + self.run_in.most + self.settings.window
    }

    /// What the next step is made for.
    #[inline(always)]
    fn phase(&self) -> Phase {
        if self.step < self.wound {
            Phase::Winding
        } else if self.step < self.wound + self.run_in.most {
            Phase::RunIn
        } else {
            Phase::Window
        }
    }

    /// What the logs say of the next step.
    #[inline(always)]
    fn rows(&self) -> Rows<N> {
        let mut rows = Rows {
            given: Givens {
                input: [0.0; N],
                previous: [0.0; N],
                brake: [0.0; N],
                load: [0.0; N],
                released: [false; N],
                is_loaded: false,
                index: [0; N],
                sample: [0.0; N],
                asleep: [false; N],
                awake: 0,
            },
            next_position: [0.0; N],
            current: [0.0; N],
            next_velocity: [0.0; N],
        };
        let (leads, step) = match self.phase() {
            Phase::Winding => (&self.winding, self.step),
            Phase::RunIn | Phase::Window => (&self.run_in, self.step - self.wound),
        };
        let ahead = leads.most.saturating_sub(step);
        let behind = step.saturating_sub(leads.most);
        for lane in 0..N {
            let log = self.logs[lane];
            let given = &mut rows.given;
            // Asleep until its own way begins.
            let lead = leads.each[lane];
            let asleep = ahead > lead || lane >= self.count;
            let index = self.restarts[lane].start - ahead.min(lead) + behind;
            given.asleep[lane] = asleep;
            given.awake += usize::from(!asleep);
            given.index[lane] = index;
            given.sample[lane] = index as f32;
            given.input[lane] = log.input.at(index);
            if log.tells_what_acts() {
                let external = log.external(index);
                given.brake[lane] = external.brake;
                given.load[lane] = external.load;
                given.released[lane] = external.released;
                given.is_loaded |= external != External::NONE;
            }
            rows.next_position[lane] = log.position.at(index + 1);
            if let Some(current) = log.current {
                rows.current[lane] = current.at(index);
            }
            if let Some(velocity) = log.velocity {
                rows.next_velocity[lane] = velocity.at(index + 1);
            }
        }
        rows.given.previous = rows.given.input;
        rows
    }

    /// Lanes in which the current was measured.
    pub(super) fn measured_current(&self) -> [bool; N] {
        self.seconds.map(|second| matches!(second, Second::Current))
    }

    /// Steps simulators. The current that the first one's sensor sees, with how fast that rises, if this was
    /// a step of the windows, whose residuals count.
    #[inline(always)]
    pub(super) fn step<M: Borrow<Modes>, H: Acting>(
        &mut self,
        replays: &mut [Replay<M, H, N>],
        residuals: &mut [(Lanes<N>, Lanes<N>)],
    ) -> Option<(Lanes<N>, Lanes<N>)> {
        let phase = self.phase();
        let rows = self.rows();
        let mut first = None;
        for (replay, residual) in replays.iter_mut().zip(residuals) {
            if replay.takes(phase) {
                let (residuals, seen) = self.advance(&mut replay.lanes, &rows);
                *residual = residuals;
                first.get_or_insert(seen);
                if phase == Phase::Winding {
                    self.observe(replay, &rows.given.index);
                }
            }
        }
        self.step += 1;
        if phase != self.phase() {
            let model = replays.first()?;
            let (twists, behind) = (model.twists, model.courses());
            for replay in replays {
                let follows = replay.follows;
                if phase == Phase::Winding {
                    let own = replay.twists;
                    self.wind(replay, if follows { &twists } else { &own });
                } else {
                    let own = replay.courses();
                    self.resume(replay, if follows { &behind } else { &own });
                }
            }
        }
        first.filter(|_| phase == Phase::Window)
    }

    /// As [`Runner::advance_and_see`].
    #[inline(always)]
    fn advance<M: Borrow<Modes>, H: Acting>(
        &self,
        runner: &mut Lockstep<M, H, N>,
        rows: &Rows<N>,
    ) -> ((Lanes<N>, Lanes<N>), (Lanes<N>, Lanes<N>)) {
        let simulator = runner.simulator();
        let before = runner.currents();
        let late = simulator.input_lateness();
        let predicted = if late.is_at_hand() && late.share == 0.0 {
            runner.step(&rows.given)
        } else {
            runner.step(&self.late(late, &rows.given))
        };
        let reading = simulator.current_lateness();
        let sensor = simulator.current_sensor();
        let mut measured = rows.current;
        if !reading.is_at_hand() {
            for lane in 0..N {
                if let Some(current) = self.logs[lane].current {
                    measured[lane] = reading.read(current, rows.given.index[lane]);
                }
            }
        }
        // Logs of one machine may differ in what they measure.
        let velocities = runner.velocities();
        let mut seconds = [0.0; N];
        for lane in 0..N {
            seconds[lane] = match self.seconds[lane] {
                Second::Current => sensor.reading(predicted[lane]) - measured[lane],
                Second::Velocity => velocities[lane] - rows.next_velocity[lane],
                Second::Nothing => 0.0,
            };
        }
        let position = runner.reported_from(&rows.next_position);
        let after = runner.currents();
        let mut rises = [0.0; N];
        for lane in 0..N {
            rises[lane] = (after[lane] - before[lane]) / self.logs[lane].period;
        }
        ((position, seconds), (predicted, rises))
    }

    /// A step under inputs that act late, or early.
    #[inline(never)]
    fn late(&self, late: Lateness, given: &Givens<N>) -> Givens<N> {
        let mut given = *given;
        for lane in 0..N {
            let (index, inputs) = (given.index[lane], self.logs[lane].input);
            given.input[lane] = late.read(inputs, index);
            given.previous[lane] = if late.share == 0.0 {
                given.input[lane]
            } else {
                late.one_more().read(inputs, index)
            };
        }
        given
    }
}
