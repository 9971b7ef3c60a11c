//! The way to a limit switch, whose place is known: with it the position is.
//!
//! The set point goes towards the switch at an even speed until the switch is open. Where it is open at the beginning, the
//! set point first goes away from it until it is closed, so that the edge is always passed in the same direction. The
//! position is that of the control step in which the switch opened; that it did is believed after
//! [`SWITCH_STEPS`].

use crate::app::debounce::Debounce;
use crate::app::timing::CONTROL_PERIOD;

/// Control steps that a limit switch has to be open for before that counts: contacts bounce for a
/// millisecond or two.
pub const SWITCH_STEPS: u32 = 5;

/// A limit switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "tasks", derive(defmt::Format))]
pub enum Switch {
    /// At the lower end.
    Lower,
    /// At the upper end.
    Upper,
}

impl Switch {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Lower, Self::Upper];

    /// What it is called on the console.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lower => "lower",
            Self::Upper => "upper",
        }
    }

    /// Whether it is open, of both.
    pub const fn of(self, [lower, upper]: [bool; 2]) -> bool {
        match self {
            Self::Lower => lower,
            Self::Upper => upper,
        }
    }

    /// Both, as if this one were closed.
    pub const fn closed(self, [lower, upper]: [bool; 2]) -> [bool; 2] {
        match self {
            Self::Lower => [false, upper],
            Self::Upper => [lower, false],
        }
    }
}

/// Which switch is sought, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sought {
    /// The switch.
    pub switch: Switch,
    /// Speed, rad/s.
    pub speed: f32,
    /// Most way in one direction, rad.
    pub farthest: f32,
}

/// What a control step of the search says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// The set point, rad.
    To(f32),
    /// Where the switch opened, in counts.
    Found(i32),
    /// It did not change over the farthest way.
    Lost,
}

/// A search under way.
///
/// ```
/// use firmware::app::operation::homing::{Search, Sought, Step, Switch};
///
/// let sought = Sought { switch: Switch::Upper, speed: 1.0, farthest: 2.0 };
/// let mut search = Search::new(sought, 0.5, [false; 2]);
/// assert_eq!(search.step([false; 2], (0.5, 50)), Step::To(0.501));
/// // It opens at 51 counts, and stays open.
/// for counts in 51..55 {
///     assert!(matches!(search.step([false, true], (0.51, counts)), Step::To(_)));
/// }
/// assert_eq!(search.step([false, true], (0.51, 55)), Step::Found(51));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    sought: Sought,
    /// Where this part of it began, rad.
    from: f32,
    /// Control steps since.
    steps: u32,
    /// Whether it goes away from the switch, which was open.
    leaves: bool,
    /// Where the switch opened, in counts.
    edge: Option<i32>,
    changed: Debounce,
}

impl Search {
    /// From this position, rad, with the switches open or not.
    pub fn new(sought: Sought, from: f32, switches: [bool; 2]) -> Self {
        Self {
            sought,
            from,
            steps: 0,
            leaves: sought.switch.of(switches),
            edge: None,
            changed: Debounce::default(),
        }
    }

    /// The same from here.
    #[must_use]
    pub fn anew(&self, from: f32, switches: [bool; 2]) -> Self {
        Self::new(self.sought, from, switches)
    }

    /// The switch that is sought.
    pub fn switch(&self) -> Switch {
        self.sought.switch
    }

    /// Takes the switches and the position, in rad and in counts.
    pub fn step(&mut self, switches: [bool; 2], (position, counts): (f32, i32)) -> Step {
        let is_open = self.switch().of(switches);
        if self.changed.after(SWITCH_STEPS, is_open != self.leaves) {
            if !self.leaves {
                return Step::Found(self.edge.unwrap_or(counts));
            }
            *self = Self::new(self.sought, position, self.switch().closed(switches));
        } else if !is_open {
            self.edge = None;
        } else if self.edge.is_none() {
            self.edge = Some(counts);
        }
        self.steps = self.steps.saturating_add(1);
        let way = self.sought.speed * CONTROL_PERIOD * self.steps as f32;
        // Also of what is not a number.
        if way.is_nan() || way > self.sought.farthest {
            return Step::Lost;
        }
        let is_upwards = (self.sought.switch == Switch::Upper) != self.leaves;
        Step::To(self.from + if is_upwards { way } else { -way })
    }
}

/// What seeks a limit switch, until the drive is disarmed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Seeking {
    Under(Search),
    /// Nothing is driven any more.
    Ended(Switch),
}

impl Seeking {
    /// The switch that is sought.
    pub(super) fn switch(&self) -> Switch {
        match self {
            Self::Under(search) => search.switch(),
            Self::Ended(switch) => *switch,
        }
    }
}

/// An end of the way, with its limit switch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct End {
    open: Debounce,
    closed: Debounce,
    /// Whether the switch has been open ever since the drive was armed. Then nothing drives towards it, and it is a way out
    /// and no fault: a loop that holds the actuator there may ask for a little either way, as behind a search.
    pub(super) leaves: bool,
}

impl End {
    /// Takes a control step. True while the switch is open.
    pub(super) fn step(&mut self, is_open: bool, is_driven: bool) -> bool {
        let open = self.open.after(SWITCH_STEPS, is_open);
        let closed = self.closed.after(SWITCH_STEPS, !is_open);
        self.leaves = if is_driven {
            self.leaves && !closed
        } else {
            open
        };
        open
    }
}
