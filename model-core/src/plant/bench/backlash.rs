//! Backlash as a play: Simulink's block, a dead band of a width (bench paper, section 6.3).
//!
//! The driven side stands while the driving one is within half the width of it, and is pushed
//! beyond. It has no inertia and the teeth do not give.
//!
//! Algorithm 1 of the paper measures the mean of the largest distances to either side: half the
//! width.

/// A play at work, in rad.
///
/// ```
/// use model_core::plant::bench::backlash::Play;
/// let mut play = Play::new(0.2);
/// play.follow(0.5);
/// assert_eq!(play.output(), 0.4);
/// play.follow(0.3);
/// assert_eq!(play.output(), 0.4);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Play {
    half_width: f32,
    output: f32,
}

impl Play {
    /// Of a width, in its middle at zero. A width that is negative or not finite counts as zero.
    pub fn new(width: f32) -> Self {
        let width = if width.is_finite() { width } else { 0.0 };
        Self {
            half_width: 0.5 * width.max(0.0),
            output: 0.0,
        }
    }

    /// Half the width, rad.
    pub fn half_width(&self) -> f32 {
        self.half_width
    }

    /// Moves the driving side.
    #[inline]
    pub fn follow(&mut self, input: f32) {
        if self.output < input - self.half_width {
            self.output = input - self.half_width;
        } else if self.output > input + self.half_width {
            self.output = input + self.half_width;
        }
    }

    /// The driven side.
    #[inline]
    pub fn output(&self) -> f32 {
        self.output
    }
}
