//! Windows side by side, replayed in lockstep.
//!
//! Simulators whose effects remember run in to the restart. The way there is longer in one window than in
//! another, so that lanes begin one after the other and restart together; those that sleep are left where
//! they are.

use super::{Data, Restart, Runner, Settings, Window};
use crate::gap::held::Acting;
use crate::gap::log::Log;
use crate::gap::simulator::lockstep::{Givens, Lockstep};
use crate::gap::simulator::{Course, Lateness, Simulator};
use crate::plant::actuator::lanes::Lanes;
use crate::plant::modes::Modes;
use core::array;
use core::borrow::Borrow;

/// Windows side by side, and how far a replay is in them.
pub(super) struct Places<'a, const N: usize> {
    logs: [&'a Log<'a>; N],
    settings: &'a Settings,
    /// What is compared besides the position.
    seconds: [Second; N],
    restarts: [Restart; N],
    /// Steps that a lane runs in, and most of them: lanes begin one after the other and restart
    /// together.
    leads: [usize; N],
    lead: usize,
    /// Steps made.
    step: usize,
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
    /// At the start of so many windows; lanes that are left go through the last of them, too.
    /// `remembers`: whether a simulator does.
    pub(super) fn new(
        data: &'a Data<'a>,
        count: usize,
        at: impl Fn(usize) -> Option<Window>,
        remembers: bool,
    ) -> Option<Self> {
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
            Restart::new(logs[lane], windows[lane].start, settings, remembers)
        });
        let leads: [usize; N] = array::from_fn(|lane| {
            let simulated = settings.own_velocity(logs[lane]).is_none();
            let approach = restarts[lane].approach.filter(|_| simulated);
            approach.map_or(0, |approach| restarts[lane].start - approach.since)
        });
        Some(Self {
            logs,
            settings,
            seconds,
            restarts,
            leads,
            lead: leads.into_iter().max().unwrap_or(0),
            step: 0,
        })
    }

    /// A simulator where it begins: at the restarts, or before them where it runs in.
    pub(super) fn start<'s, M: Borrow<Modes>, H: Acting>(
        &mut self,
        simulator: &'s Simulator<M, H>,
    ) -> Lockstep<'s, M, H, N> {
        let mut courses = [Course::default(); N];
        for (lane, course) in courses.iter_mut().enumerate() {
            let (log, restart) = (self.logs[lane], &mut self.restarts[lane]);
            let runner = if self.leads[lane] > 0 {
                Runner::at_restart(simulator, log, restart, self.settings)
            } else {
                Runner::from_restart(simulator, log, restart, self.settings)
            };
            let approach = restart.approach.filter(|_| self.leads[lane] > 0);
            *course = match approach {
                Some(approach) if simulator.remembers() => {
                    runner.run_in(&approach, self.settings).course
                }
                _ => runner.course,
            };
        }
        Lockstep::new(simulator, &courses)
    }

    /// Puts a simulator that has run in to the restarts.
    #[inline(never)]
    fn resume<M: Borrow<Modes>, H: Acting>(&mut self, runner: &mut Lockstep<M, H, N>) {
        let simulator = runner.simulator();
        for lane in 0..N {
            let (log, restart) = (self.logs[lane], &mut self.restarts[lane]);
            let approach = restart.approach.filter(|_| self.leads[lane] > 0);
            if let Some(approach) = approach.filter(|_| simulator.remembers()) {
                let there = Runner::at_restart(simulator, log, restart, self.settings);
                let run_in = (&runner.at(lane), 0.0);
                let resumed = there.resumed(run_in, &approach, self.settings);
                runner.put(lane, &resumed.course);
            }
        }
    }

    /// Steps of a run-in and a window.
    pub(super) fn steps(&self) -> usize {
        self.lead + self.settings.window
    }

    /// Whether the next step is one of a run-in.
    #[inline(always)]
    fn runs_in(&self) -> bool {
        self.step < self.lead
    }

    /// What the logs say of the next step.
    #[inline(always)]
    fn rows(&self) -> Rows<N> {
        let mut rows = Rows {
            given: Givens {
                input: [0.0; N],
                previous: [0.0; N],
                brake: [0.0; N],
                braked: false,
                index: [0; N],
                sample: [0.0; N],
                asleep: [false; N],
                awake: 0,
            },
            next_position: [0.0; N],
            current: [0.0; N],
            next_velocity: [0.0; N],
        };
        for lane in 0..N {
            let log = self.logs[lane];
            let given = &mut rows.given;
            // Asleep until its own run-in begins.
            let ahead = self.lead.saturating_sub(self.step);
            let asleep = ahead > self.leads[lane];
            let behind = self.step.saturating_sub(self.lead);
            let index = self.restarts[lane].start - ahead.min(self.leads[lane]) + behind;
            given.asleep[lane] = asleep;
            given.awake += usize::from(!asleep);
            given.index[lane] = index;
            given.sample[lane] = index as f32;
            given.input[lane] = log.input.at(index);
            if let Some(brake) = log.brake {
                given.brake[lane] = brake.at(index);
                given.braked |= given.brake[lane] != 0.0;
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

    /// Steps simulators. Whether this was a step of the windows, whose residuals count.
    #[inline(always)]
    pub(super) fn step<M: Borrow<Modes>, H: Acting>(
        &mut self,
        runners: &mut [Lockstep<M, H, N>],
        residuals: &mut [(Lanes<N>, Lanes<N>)],
    ) -> bool {
        let runs_in = self.runs_in();
        let rows = self.rows();
        for (runner, residual) in runners.iter_mut().zip(residuals) {
            if !runs_in || runner.simulator().remembers() {
                *residual = self.advance(runner, &rows);
            }
        }
        self.step += 1;
        if runs_in && !self.runs_in() {
            for runner in runners {
                self.resume(runner);
            }
        }
        !runs_in
    }

    /// As [`Runner::advance`].
    #[inline(always)]
    fn advance<M: Borrow<Modes>, H: Acting>(
        &self,
        runner: &mut Lockstep<M, H, N>,
        rows: &Rows<N>,
    ) -> (Lanes<N>, Lanes<N>) {
        let simulator = runner.simulator();
        let late = simulator.input_lateness();
        let predicted = if late.whole == 0 && late.share == 0.0 {
            runner.step(&rows.given)
        } else {
            runner.step(&self.late(late, &rows.given))
        };
        let late = simulator.sensor_lateness().whole;
        let mut measured = rows.current;
        if late > 0 {
            for lane in 0..N {
                let index = rows.given.index[lane].saturating_sub(late);
                if let Some(current) = self.logs[lane].current {
                    measured[lane] = current.at(index);
                }
            }
        }
        // Logs of one machine may differ in what they measure.
        let velocities = runner.velocities();
        let mut seconds = [0.0; N];
        for lane in 0..N {
            seconds[lane] = match self.seconds[lane] {
                Second::Current => predicted[lane] - measured[lane],
                Second::Velocity => velocities[lane] - rows.next_velocity[lane],
                Second::Nothing => 0.0,
            };
        }
        (runner.reported_from(&rows.next_position), seconds)
    }

    /// A step under inputs that act late.
    #[inline(never)]
    fn late(&self, late: Lateness, given: &Givens<N>) -> Givens<N> {
        let mut given = *given;
        for lane in 0..N {
            let index = given.index[lane];
            let back = |samples: usize| self.logs[lane].input.at(index.saturating_sub(samples));
            given.input[lane] = back(late.whole);
            given.previous[lane] = if late.share == 0.0 {
                given.input[lane]
            } else {
                back(late.whole + 1)
            };
        }
        given
    }
}
