//! What happened around one moment, at the rate of the loop.
//!
//! A ring takes the chosen quantities of each sample until a trigger comes, and then so many more.
//! Fewer quantities leave room for more rows. The trigger's row is known to the sample: a level
//! triggers with the first sample that is at it or beyond, a command with the first sample that
//! is asked for it, a fault with the first one that has it latched. A trigger that comes before all of
//! the rows before it are there is taken all the same.
//!
//! It lives where the sample queue is emptied. A sample that is missing there begins the rows before
//! the trigger anew, and ends those behind it: the rows of a capture follow each other without a gap.

use model_core::numeric::invalid_parameter::InvalidParameter;

use super::conversion::Converters;
use super::record::Sample;

/// What a sample holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Quantity {
    /// Position asked for, rad.
    Command,
    /// Bridge voltage from this sample to the next, V.
    Input,
    /// Measured position, rad.
    Position,
    /// Measured motor current, A.
    Current,
    /// Position of the emulated actuator, rad.
    TruePosition,
    /// Velocity of the emulated actuator, rad/s.
    TrueVelocity,
    /// Motor current of the emulated actuator, A.
    TrueCurrent,
}

/// How many there are.
pub const QUANTITIES: usize = Quantity::ALL.len();

impl Quantity {
    /// All of them, in their order.
    pub const ALL: [Self; 7] = [
        Self::Command,
        Self::Input,
        Self::Position,
        Self::Current,
        Self::TruePosition,
        Self::TrueVelocity,
        Self::TrueCurrent,
    ];

    /// What its column is called, in the log and in a CSV.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Command => "command",
            Self::Input => "input",
            Self::Position => "position",
            Self::Current => "current_a",
            Self::TruePosition => "true_position",
            Self::TrueVelocity => "true_velocity",
            Self::TrueCurrent => "true_current_a",
        }
    }

    /// The one of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|quantity| quantity.name() == name)
    }
}

/// The values of a sample in SI, in the order of [`Quantity`].
pub fn values(sample: &Sample, converters: &Converters) -> [f32; QUANTITIES] {
    [
        sample.command,
        converters.bridge.value(sample.duty),
        converters.position.value(sample.position),
        converters.current.value(sample.current),
        sample.truth.position,
        sample.truth.velocity,
        sample.truth.current,
    ]
}

/// A set of quantities.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Quantities(u8);

impl Quantities {
    /// What a log for the host needs, and the position asked for.
    pub const LOG: Self = Self(0b1111);

    /// This set and one more.
    #[must_use]
    pub const fn with(self, quantity: Quantity) -> Self {
        Self(self.0 | 1 << quantity as u8)
    }

    /// Whether it is in there.
    pub const fn contains(self, quantity: Quantity) -> bool {
        self.0 & (1 << quantity as u8) != 0
    }

    /// Whether there is none.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// How many.
    pub const fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// In their order.
    pub fn iter(self) -> impl Iterator<Item = Quantity> {
        Quantity::ALL
            .into_iter()
            .filter(move |&quantity| self.contains(quantity))
    }
}

impl core::fmt::Display for Quantities {
    /// Their names with commas between, as in the head of a CSV.
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (place, quantity) in self.iter().enumerate() {
            if place > 0 {
                formatter.write_str(",")?;
            }
            formatter.write_str(quantity.name())?;
        }
        Ok(())
    }
}

/// Which way a level is crossed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// From below it to it or above.
    Rising,
    /// From above it to it or below.
    Falling,
}

/// What a capture waits for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Trigger {
    /// Nothing: the next sample is the one.
    Now,
    /// A command signal begins.
    Command,
    /// A fault is latched.
    Fault,
    /// A quantity crosses a level, whether it is recorded or not.
    Level {
        /// Which.
        quantity: Quantity,
        /// Which way.
        edge: Edge,
        /// In the quantity's unit.
        level: f32,
    },
}

/// What to record, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// What is in a row.
    pub quantities: Quantities,
    /// What is waited for.
    pub trigger: Trigger,
    /// Most rows before the trigger's.
    pub before: u32,
    /// Rows from the trigger's on, at least one.
    pub after: u32,
}

/// Values that a board's capture holds: 8 KB, 512 rows of what a log needs.
pub const CAPTURE_VALUES: usize = 2048;

impl Settings {
    /// Rows in all, if a buffer of so many values has room for them.
    ///
    /// # Errors
    /// Nothing to record, or too much.
    pub fn rows(&self, values: usize) -> Result<usize, InvalidParameter> {
        let refused = |name, requirement| Err(InvalidParameter { name, requirement });
        if self.quantities.is_empty() {
            return refused("quantities", "must be at least one");
        }
        if self.after == 0 {
            return refused("after", "must be at least one row");
        }
        let rows = u64::from(self.before) + u64::from(self.after);
        match usize::try_from(rows) {
            Ok(rows) if rows <= values / self.quantities.count() => Ok(rows),
            _ => refused(
                "before",
                "and after are more rows than there is room for; ask for less of either, or for fewer quantities",
            ),
        }
    }
}

/// How far a capture is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Stage {
    /// Nothing was asked for.
    #[default]
    Idle,
    /// For the trigger.
    Waiting,
    /// The trigger came.
    Triggered,
    /// All rows are there.
    Complete,
}

impl Stage {
    /// What it is called on the console.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Idle => "idle",
            Self::Waiting => "waiting",
            Self::Triggered => "triggered",
            Self::Complete => "complete",
        }
    }
}

/// The buffer, for so many values.
#[derive(Debug)]
pub struct Capture<const VALUES: usize = CAPTURE_VALUES> {
    values: [f32; VALUES],
    settings: Settings,
    stage: Stage,
    /// Rows that the ring holds.
    capacity: usize,
    /// Where the next row goes.
    next: usize,
    /// Rows that are there.
    rows: usize,
    /// The trigger's row.
    trigger: usize,
    /// Rows that are still to come.
    remaining: u32,
    /// The sample before: its number, and the value that the trigger looks at.
    before: Option<(u32, f32)>,
}

impl<const VALUES: usize> Capture<VALUES> {
    /// Nothing asked for.
    pub const fn new() -> Self {
        Self {
            values: [0.0; VALUES],
            settings: Settings {
                quantities: Quantities::LOG,
                trigger: Trigger::Now,
                before: 0,
                after: 1,
            },
            stage: Stage::Idle,
            capacity: 1,
            next: 0,
            rows: 0,
            trigger: 0,
            remaining: 0,
            before: None,
        }
    }

    /// Forgets what was recorded, and begins with the next sample.
    ///
    /// # Errors
    /// Nothing to record, or more than there is room for: what was recorded stays.
    pub fn begin(&mut self, settings: Settings) -> Result<(), InvalidParameter> {
        self.capacity = settings.rows(VALUES)?;
        self.settings = settings;
        self.stage = Stage::Waiting;
        self.before = None;
        self.forget();
        Ok(())
    }

    fn forget(&mut self) {
        self.next = 0;
        self.rows = 0;
        self.trigger = 0;
    }

    /// How far it is.
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// What is recorded.
    pub const fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The trigger's row; none before the trigger.
    pub fn trigger_row(&self) -> Option<usize> {
        matches!(self.stage, Stage::Triggered | Stage::Complete).then_some(self.trigger)
    }

    /// Takes a sample.
    pub fn push(&mut self, sample: &Sample, converters: &Converters) {
        if matches!(self.stage, Stage::Idle | Stage::Complete) {
            return;
        }
        let before = self
            .before
            .filter(|(number, _)| number.wrapping_add(1) == sample.sequence);
        if before.is_none() && self.before.is_some() {
            if self.stage == Stage::Triggered {
                self.stage = Stage::Complete;
                return;
            }
            self.forget();
        }
        let values = values(sample, converters);
        let watched = match self.settings.trigger {
            Trigger::Level { quantity, .. } => values[quantity as usize],
            Trigger::Now | Trigger::Command | Trigger::Fault => 0.0,
        };
        self.before = Some((sample.sequence, watched));
        self.store(&values);
        if self.stage == Stage::Triggered {
            self.remaining -= 1;
        } else if self.triggers(sample, before.map(|(_, value)| value), watched) {
            self.trigger = (self.rows - 1).min(self.settings.before as usize);
            self.rows = self.trigger + 1;
            self.remaining = self.settings.after - 1;
            self.stage = Stage::Triggered;
        }
        if self.stage == Stage::Triggered && self.remaining == 0 {
            self.stage = Stage::Complete;
        }
    }

    fn triggers(&self, sample: &Sample, before: Option<f32>, now: f32) -> bool {
        match self.settings.trigger {
            Trigger::Now => true,
            Trigger::Command => sample.marks.command,
            Trigger::Fault => sample.marks.fault,
            Trigger::Level { edge, level, .. } => before.is_some_and(|before| match edge {
                Edge::Rising => before < level && now >= level,
                Edge::Falling => before > level && now <= level,
            }),
        }
    }

    fn store(&mut self, values: &[f32; QUANTITIES]) {
        let quantities = self.settings.quantities;
        let start = self.next * quantities.count();
        let places = self.values.iter_mut().skip(start);
        for (place, quantity) in places.zip(quantities.iter()) {
            *place = values[quantity as usize];
        }
        self.next = (self.next + 1) % self.capacity;
        self.rows = (self.rows + 1).min(self.capacity);
    }

    /// The rows that are there, oldest first: values in the order of [`Quantity`], NaN for what was not
    /// recorded.
    pub fn rows(&self) -> impl Iterator<Item = [f32; QUANTITIES]> {
        let oldest = self.next + self.capacity - self.rows;
        (0..self.rows).map(move |row| self.row((oldest + row) % self.capacity))
    }

    /// How many there are.
    pub const fn count(&self) -> usize {
        self.rows
    }

    fn row(&self, place: usize) -> [f32; QUANTITIES] {
        let quantities = self.settings.quantities;
        let start = place * quantities.count();
        let mut row = [f32::NAN; QUANTITIES];
        for (quantity, value) in quantities.iter().zip(self.values.iter().skip(start)) {
            row[quantity as usize] = *value;
        }
        row
    }
}

impl<const VALUES: usize> Default for Capture<VALUES> {
    fn default() -> Self {
        Self::new()
    }
}

/// Logs what comes before the rows of a capture: an experiment of the name `capture`, whose first
/// sample has the number 0.
#[cfg(feature = "tasks")]
pub fn log_head<const VALUES: usize>(capture: &Capture<VALUES>) {
    use core::fmt::Write;

    use heapless::String;

    use super::timing::{CONTROL_PERIOD_US, PLANT_PERIOD_US};

    let mut names = String::<80>::new();
    // There is room for all of them.
    let _ = write!(names, "{}", capture.settings.quantities);
    defmt::info!(
        "experiment name=capture plant_period_us={=u32} control_period_us={=u32} steps={=usize}",
        PLANT_PERIOD_US,
        CONTROL_PERIOD_US,
        capture.rows
    );
    defmt::info!(
        "capture quantities={=str} trigger_row={=usize}",
        names.as_str(),
        capture.trigger
    );
}

/// Logs what comes before the rows of a log of the last seconds: an experiment of the name `log`, whose
/// first sample has the number 0.
#[cfg(feature = "tasks")]
pub fn log_log_head(rows: usize) {
    use super::timing::{CONTROL_PERIOD_US, PLANT_PERIOD_US};

    defmt::info!(
        "experiment name=log plant_period_us={=u32} control_period_us={=u32} steps={=usize}",
        PLANT_PERIOD_US,
        CONTROL_PERIOD_US,
        rows
    );
    defmt::info!("capture quantities=input,position,current_a trigger_row=0");
}
