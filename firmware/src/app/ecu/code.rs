//! What an engine controller says is wrong.

/// A diagnostic code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// First track below its range: open to ground, or shorted to it.
    FirstTrackLow,
    /// First track above its range.
    FirstTrackHigh,
    /// First track noisy or intermittent.
    FirstTrackNoisy,
    /// Second track below its range.
    SecondTrackLow,
    /// Second track above its range.
    SecondTrackHigh,
    /// Second track noisy or intermittent.
    SecondTrackNoisy,
    /// The tracks disagree: one of them is stuck or off.
    TracksDisagree,
    /// The plate does not follow a voltage that surely moves it.
    PlateStuck,
    /// The plate does not return by its spring, or the spring does not weigh on the motor.
    SpringReturn,
    /// The motor needs more current to move the plate than its friction explains.
    FrictionHigh,
    /// Voltage, and no current.
    OpenLoad,
    /// More current than voltage, resistance and speed explain.
    ShortCircuit,
    /// The stops are not where they may be.
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

    /// The trouble code of SAE J2012 that comes next to it; for a plate that is stuck, those of one
    /// that is stuck open and one that is stuck closed.
    pub const fn trouble_code(self) -> &'static str {
        match self {
            Self::FirstTrackLow => "P0122",
            Self::FirstTrackHigh => "P0123",
            Self::FirstTrackNoisy => "P0124",
            Self::SecondTrackLow => "P0222",
            Self::SecondTrackHigh => "P0223",
            Self::SecondTrackNoisy => "P0224",
            Self::TracksDisagree => "P2135",
            Self::PlateStuck => "P2111, P2112",
            Self::SpringReturn => "P2119",
            Self::FrictionHigh => "P2101",
            Self::OpenLoad => "P2100",
            Self::ShortCircuit => "P2118",
            Self::NotLearned => "P2176",
        }
    }
}
