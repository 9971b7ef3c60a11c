//! The logs, and how they are cut into windows and weighed.

use crate::gap::criterion::FEW_WINDOWS;
use crate::gap::log::{Channel, Log};

/// Most samples on either side of a restart that its state is smoothed over; windows keep this
/// distance from the ends of a log, however wide the smoothing is.
pub const MARGIN: usize = 16;

/// Half widths of the restarts' smoothing that are tried.
pub(in crate::gap) const HALF_WIDTHS: [usize; 7] = [2, 3, 4, 6, 8, 12, MARGIN];

/// How a window that moves gets its starting state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowStart {
    /// The slope of the position over the samples around it.
    Slope,
    /// The state that the model reaches when it is simulated from some time before, shifted in position and velocity to fit
    /// the log on the way. Where the speed follows the input within a few samples, or where an encoder counts little in
    /// them, no slope over these samples is the velocity at one of them. A model with a shaft starts from the slope.
    Simulated,
    /// The measured velocity, where there is one.
    Measured,
}

/// How a log is cut and weighed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Samples in a window.
    pub window: usize,
    /// Samples on either side of a restart that its state is smoothed over, 1 to [`MARGIN`]; with [`WindowStart::Simulated`] also the
    /// length of that simulation, in samples or, if a sample is shorter, in milliseconds.
    pub half_width: usize,
    /// How a window that moves gets its starting state.
    pub window_start: WindowStart,
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
pub(in crate::gap) const CLEAR_COUNTS: f32 = 4.0;

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
            window_start: WindowStart::Slope,
            velocity_channel: false,
            resolution,
            clear_travel: CLEAR_COUNTS * resolution,
            position_weight: 1.0,
            current_weight: 0.0,
        }
    }

    /// The measured velocity, where replays restart from it.
    pub(super) fn own_velocity<'a>(&self, log: &Log<'a>) -> Option<Channel<'a>> {
        log.velocity
            .filter(|_| self.window_start == WindowStart::Measured)
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
    /// The logs, cut into windows of [`WINDOW`] seconds, or shorter ones where these would be fewer than
    /// [`FEW_WINDOWS`]: a fast machine is recorded for a second.
    /// `resolution`: that of the sensor, rad or m; 0 if unknown.
    ///
    /// `None` without a log.
    pub fn new(logs: &'a [Log<'a>], resolution: f32) -> Option<Self> {
        let mut settings = Settings::new(logs.first()?.period, resolution);
        let whole = |log: &Log| log.samples().saturating_sub(2 * MARGIN + 1);
        let samples: usize = logs.iter().map(whole).sum();
        let shorter = (samples / FEW_WINDOWS).max(LEAST_SAMPLES);
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

    /// The same logs with restarts that are smoothed over the next fewer and the next more samples, where there are such.
    pub fn with_neighbouring_restarts(&self) -> [Option<Data<'a>>; 2] {
        let own = self.settings.half_width;
        let narrower = HALF_WIDTHS.iter().rev().find(|&&width| width < own);
        let wider = HALF_WIDTHS.iter().find(|&&width| width > own);
        [narrower, wider].map(|width| {
            let mut data = *self;
            data.settings.half_width = *width?;
            Some(data)
        })
    }
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
