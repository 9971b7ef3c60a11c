//! What an engine controller says is wrong.

/// A diagnostic code. Behind each name the trouble code of SAE J2012 that comes next to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// First track below its range: open to ground, or shorted to it (P0122).
    FirstTrackLow,
    /// First track above its range (P0123).
    FirstTrackHigh,
    /// First track noisy or intermittent (P0124).
    FirstTrackNoisy,
    /// Second track below its range (P0222).
    SecondTrackLow,
    /// Second track above its range (P0223).
    SecondTrackHigh,
    /// Second track noisy or intermittent (P0224).
    SecondTrackNoisy,
    /// The tracks disagree: one of them is stuck or off (P2135).
    TracksDisagree,
    /// The plate does not follow a voltage that surely moves it (P2111 stuck open, P2112 closed).
    PlateStuck,
    /// The plate does not return by its spring, or the spring does not weigh on the motor (P2119).
    SpringReturn,
    /// The motor needs more current to move the plate than its friction explains (P2101).
    FrictionHigh,
    /// Voltage, and no current (P2100).
    OpenLoad,
    /// More current than voltage, resistance and speed explain (P2118).
    ShortCircuit,
    /// The stops are not where they may be (P2176).
    NotLearned,
}

impl Code {
    /// What it is called in the log.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FirstTrackLow => "first_track_low",
            Self::FirstTrackHigh => "first_track_high",
            Self::FirstTrackNoisy => "first_track_noisy",
            Self::SecondTrackLow => "second_track_low",
            Self::SecondTrackHigh => "second_track_high",
            Self::SecondTrackNoisy => "second_track_noisy",
            Self::TracksDisagree => "tracks_disagree",
            Self::PlateStuck => "plate_stuck",
            Self::SpringReturn => "spring_return",
            Self::FrictionHigh => "friction_high",
            Self::OpenLoad => "open_load",
            Self::ShortCircuit => "short_circuit",
            Self::NotLearned => "not_learned",
        }
    }
}
