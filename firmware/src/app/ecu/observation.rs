//! What the controller makes of its readings, before it judges them.

use super::calibration::{Calibration, Ends, SUPPLY};
use crate::app::timing::CONTROL_PERIOD;
use crate::app::tracks::FULL_SCALE;

/// What the controller's converters read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Readings {
    /// Both tracks, 0 to [`FULL_SCALE`] at the reference.
    pub tracks: [u16; 2],
    /// Motor current.
    pub current: i16,
    /// Supply of the bridge.
    pub supply: i16,
}

/// Control steps in the filters' time constant: 8 ms.
const FILTER: f32 = 8.0;

/// Most that a plate moves in a control step, of its stroke. A track that jumps is not a speed.
const FASTEST: f32 = 0.03;

/// How far a plate that is still may read from where it was, of its stroke.
const STILL: f32 = 0.01;

/// Most that a second difference counts, of the stroke, so that one jump is no noise.
const JUMP: f32 = 0.05;

/// Control steps over which noise is averaged.
const NOISE: f32 = 32.0;

/// The controller's view of the throttle; the default before the first readings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observation {
    /// Shares of the reference.
    pub shares: [f32; 2],
    /// Shares of the stroke, by each track.
    pub positions: [f32; 2],
    /// Strokes a second, by the first track, filtered.
    pub velocity: f32,
    /// Strokes a second in a second: change of `velocity`.
    pub acceleration: f32,
    /// Motor current, filtered, A.
    pub current: f32,
    /// Voltage at the winding, filtered as the current is, V. None while the switches are off.
    pub voltage: Option<f32>,
    /// Supply of the bridge, V.
    pub supply: f32,
    /// Mean magnitude of each track's second difference, of the stroke.
    pub noise: [f32; 2],
    /// Control steps for which the plate has been still.
    pub still: u32,
    anchor: f32,
    /// The positions before `positions`; none before the first readings.
    before: Option<[f32; 2]>,
}

impl Observation {
    /// Takes readings. `voltage` is what stood at the bridge since the last ones, in shares of the
    /// supply; none with its switches off.
    pub fn take(
        &mut self,
        readings: &Readings,
        ends: &[Ends; 2],
        voltage: Option<f32>,
        calibration: &Calibration,
    ) {
        self.supply = SUPPLY.value(readings.supply);
        self.shares = readings
            .tracks
            .map(|counts| f32::from(counts) / f32::from(FULL_SCALE));
        let now = [0, 1].map(|side| ends[side].position(self.shares[side]));
        let (last, older) = match self.before {
            Some(older) => (self.positions, older),
            None => {
                self.anchor = now[0];
                (now, now)
            }
        };
        for (side, noise) in self.noise.iter_mut().enumerate() {
            let bend = now[side] - 2.0 * last[side] + older[side];
            *noise += (bend.abs().min(JUMP) - *noise) / NOISE;
        }
        let moved = (now[0] - last[0]).clamp(-FASTEST, FASTEST);
        let change = (moved / CONTROL_PERIOD - self.velocity) / FILTER;
        self.velocity += change;
        self.acceleration = change / CONTROL_PERIOD;
        (self.positions, self.before) = (now, Some(last));
        let current = calibration.current.value(readings.current);
        self.current += (current - self.current) / FILTER;
        self.voltage = voltage.map(|share| {
            let now = share * self.supply;
            let filtered = self.voltage.unwrap_or(now);
            filtered + (now - filtered) / FILTER
        });
        if (now[0] - self.anchor).abs() > STILL {
            self.anchor = now[0];
            self.still = 0;
        } else {
            self.still = self.still.saturating_add(1);
        }
    }

    /// The same plate on other ends of the tracks.
    pub fn rescale(&mut self) {
        self.before = None;
        self.still = 0;
    }
}
