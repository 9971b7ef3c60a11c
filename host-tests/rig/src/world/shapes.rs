//! Curves that the laws of a world are made of.

use std::f64::consts::TAU;

/// How friction falls from its level at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fall {
    /// exp(−x), Tustin 1947.
    Exponential,
    /// exp(−x²), Armstrong 1990.
    Gaussian,
    /// 1/(1 + x²), Hess and Soom 1990.
    Rational,
}

impl Fall {
    /// Share that is left at a speed of `x` Stribeck speeds.
    pub fn left(self, x: f64) -> f64 {
        let x = x.abs();
        match self {
            Self::Exponential => (-x).exp(),
            Self::Gaussian => (-x * x).exp(),
            Self::Rational => 1.0 / (1.0 + x * x),
        }
    }
}

/// How the torque falls behind its constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Saturation {
    /// T/(1 + x), Frölich 1886.
    Froelich,
    /// T tanh(x)/x.
    Tangent,
    /// T/√(1 + x²).
    Root,
}

impl Saturation {
    /// Share of the torque that is left where the unsaturated one is `x` times the law's level.
    pub fn left(self, x: f64) -> f64 {
        let x = x.abs();
        match self {
            Self::Froelich => 1.0 / (1.0 + x),
            Self::Tangent if x > 1e-6 => x.tanh() / x,
            Self::Tangent => 1.0,
            Self::Root => 1.0 / (1.0 + x * x).sqrt(),
        }
    }
}

/// Course of an external load over the log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Course {
    /// Once, from `begin` for `duration`, with edges of `edge`, s.
    Pulse {
        /// s.
        begin: f64,
        /// s.
        duration: f64,
        /// s.
        edge: f64,
    },
    /// On for half of each period, off for the other.
    Periodic {
        /// s.
        period: f64,
        /// Share of a period.
        phase: f64,
    },
    /// Rises evenly from `begin` to `end`, s, and stays.
    Ramp {
        /// s.
        begin: f64,
        /// s.
        end: f64,
    },
}

impl Course {
    /// Share of the load at `time`, 0 to 1.
    pub fn at(self, time: f64) -> f64 {
        match self {
            Self::Pulse {
                begin,
                duration,
                edge,
            } => {
                let rise = (time - begin) / edge + 0.5;
                let fall = (begin + duration - time) / edge + 0.5;
                rise.min(fall).clamp(0.0, 1.0)
            }
            Self::Periodic { period, phase } => {
                f64::from((time / period + phase).rem_euclid(1.0) < 0.5)
            }
            Self::Ramp { begin, end } => ((time - begin) / (end - begin)).clamp(0.0, 1.0),
        }
    }
}

/// A ripple over the position: a fundamental and two harmonics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ripple {
    /// Of the fundamental, rad or m.
    pub period: f64,
    /// rad.
    pub phase: f64,
    /// Amplitude of the second and the third harmonic, of the fundamental's.
    pub harmonics: [f64; 2],
}

impl Ripple {
    /// The ripple of a fundamental of amplitude 1.
    pub fn at(&self, position: f64) -> f64 {
        let angle = TAU * position / self.period + self.phase;
        let [second, third] = self.harmonics;
        let mut sum = angle.sin();
        if second != 0.0 {
            sum += second * (2.0 * angle + 1.0).sin();
        }
        if third != 0.0 {
            sum += third * (3.0 * angle + 2.0).sin();
        }
        sum
    }
}

/// How friction varies along the stroke.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Along {
    /// Adds `level` times the ripple, N·m or N.
    Added(Ripple),
    /// Multiplies all dry friction by 1 + `level` times the ripple.
    Multiplied(Ripple),
    /// Adds `level` at one `reach` beyond `centre`, in proportion: tight at one end.
    Slope {
        /// rad or m.
        centre: f64,
        /// rad or m.
        reach: f64,
    },
}
