//! One track of a throttle's position sensor: a straight line of the position, ratiometric, with
//! noise, between its rails; and what a fault makes of it.

use crate::numeric::invalid_parameter::{InvalidParameter, require, require_finite};
use crate::numeric::random::Random;

/// Reference at which a track's voltages are declared, V.
pub const REFERENCE: f32 = 5.0;

/// Voltages of the ends of the stroke on a track that spans all of it, V of [`REFERENCE`].
pub const SPAN: [f32; 2] = [0.5, 4.5];

/// √6: a triangular distribution over ±√6 has a variance of 1.
const SQRT_6: f32 = 2.449_489_7;

/// A track.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Track {
    /// Voltage at position 0, V of [`REFERENCE`]: where the line begins, wherever the stroke does.
    pub offset: f32,
    /// V of [`REFERENCE`] for one rad or m; negative on a falling track.
    pub gain: f32,
    /// Standard deviation of the noise, V, ≥ 0: white, triangular, from one reading to the next.
    pub noise: f32,
    /// Where a resistor at the reader pulls a track that is open.
    pub pull: Pull,
}

/// What a track that is open is pulled to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Pull {
    /// To the reference.
    Up,
    /// To ground.
    Down,
}

/// What a track may suffer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TrackFault {
    /// No wire: the reader sees its pull resistor.
    Open,
    /// At the reference.
    ShortedHigh,
    /// At ground.
    ShortedLow,
    /// The reading of that moment, for ever.
    Stuck,
    /// So many V too much.
    Offset(f32),
    /// Noise of this standard deviation, V, on top of its own.
    Noisy(f32),
}

impl TrackFault {
    pub(super) fn check(self) -> Result<(), InvalidParameter> {
        match self {
            Self::Offset(volts) => require_finite(volts, "offset"),
            Self::Noisy(volts) => require_noise(volts),
            Self::Open | Self::ShortedHigh | Self::ShortedLow | Self::Stuck => Ok(()),
        }
    }
}

fn require_noise(volts: f32) -> Result<(), InvalidParameter> {
    require(
        (0.0..=REFERENCE).contains(&volts),
        "noise",
        "must be 0 to 5 V",
    )
}

impl Track {
    /// The line through `at_lower` V at `lower` and `at_upper` V at `upper`, without noise.
    ///
    /// ```
    /// use model_core::plant::potentiometer::{Potentiometer, Track};
    /// let track = Track::between((0.0, 0.5), (1.6, 4.5));
    /// assert_eq!(Potentiometer::build(track, 1)?.read(0.4, 5.0), 1.5);
    /// # Ok::<(), Box<dyn core::error::Error>>(())
    /// ```
    pub const fn between((lower, at_lower): (f32, f32), (upper, at_upper): (f32, f32)) -> Self {
        let gain = (at_upper - at_lower) / (upper - lower);
        Self {
            offset: at_lower - gain * lower,
            gain,
            noise: 0.0,
            pull: Pull::Down,
        }
    }

    /// Over the stroke from `lower` to `upper` it rises from 0.5 to 4.5 V.
    pub const fn rising(lower: f32, upper: f32) -> Self {
        Self::between((lower, SPAN[0]), (upper, SPAN[1]))
    }

    /// A second track that falls as the first one rises: the two add up to the reference.
    pub const fn complementary(lower: f32, upper: f32) -> Self {
        Self::between((lower, SPAN[1]), (upper, SPAN[0]))
    }

    /// A second track that begins as the first one does and rises half as far, to 2.5 V.
    pub const fn half_slope(lower: f32, upper: f32) -> Self {
        Self::between(
            (lower, SPAN[0]),
            (upper, SPAN[0] + 0.5 * (SPAN[1] - SPAN[0])),
        )
    }

    /// Share of the reference at a position, without noise, between the rails; NaN is at ground.
    #[inline]
    pub fn share(&self, position: f32) -> f32 {
        within_rails((self.offset + self.gain * position) * (1.0 / REFERENCE))
    }

    fn check(&self) -> Result<(), InvalidParameter> {
        require_finite(self.offset, "offset")?;
        require_finite(self.gain, "gain")?;
        require_noise(self.noise)
    }
}

/// Between ground and the reference, in shares of it.
#[inline]
fn within_rails(share: f32) -> f32 {
    if share >= 1.0 {
        1.0
    } else if share > 0.0 {
        share
    } else {
        0.0
    }
}

/// A track with its noise and its fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Potentiometer {
    track: Track,
    random: Random,
    fault: Option<TrackFault>,
    /// Share of the reference that was read last: what it is stuck at.
    last: f32,
}

impl Potentiometer {
    /// A sound track, whose noise is that of `seed`.
    ///
    /// # Errors
    /// A line or a noise that is out of its range.
    pub fn build(track: Track, seed: u64) -> Result<Self, InvalidParameter> {
        track.check()?;
        Ok(Self {
            track,
            random: Random::new(seed, 1),
            fault: None,
            last: track.share(0.0),
        })
    }

    /// A fault from now on, or none.
    pub(super) fn set_fault(&mut self, fault: Option<TrackFault>) {
        self.fault = fault;
    }

    /// A reading at a position, V, with this reference, V.
    #[inline]
    pub fn read(&mut self, position: f32, reference: f32) -> f32 {
        self.share(position) * reference
    }

    /// A reading at a position, as a share of the reference.
    #[inline]
    pub fn share(&mut self, position: f32) -> f32 {
        let (extra, noise) = match self.fault {
            None => (0.0, self.track.noise),
            Some(TrackFault::Offset(volts)) => (volts, self.track.noise),
            Some(TrackFault::Noisy(volts)) => (
                0.0,
                libm::sqrtf(volts * volts + self.track.noise * self.track.noise),
            ),
            Some(TrackFault::Stuck) => return self.last,
            Some(TrackFault::ShortedHigh) => return 1.0,
            Some(TrackFault::ShortedLow) => return 0.0,
            Some(TrackFault::Open) => {
                return match self.track.pull {
                    Pull::Up => 1.0,
                    Pull::Down => 0.0,
                };
            }
        };
        let mut volts = self.track.offset + self.track.gain * position + extra;
        if noise > 0.0 {
            volts += noise * self.deviate();
        }
        self.last = within_rails(volts * (1.0 / REFERENCE));
        self.last
    }

    /// Mean 0, variance 1, within ±√6: the sum of two uniform halves of one draw.
    fn deviate(&mut self) -> f32 {
        let bits = self.random.bits();
        let sum = (bits & 0xffff) + (bits >> 16);
        (sum as f32 - 65_535.0) * (SQRT_6 / 65_536.0)
    }
}
