//! The current of the bridge's supply kept within limits: what it gives, and what braking gives back to it.
//!
//! Without losses of its own a bridge passes the winding's power on, V I = u i. With u = R i + e, where e is what the
//! [current's limiter](super::current_limit) observes, and so holds whatever is wrong with R, the limits are
//!
//! −V I₋ ≤ R i² + e i ≤ V I₊.
//!
//! The right one is a range of the current about 0. The left one keeps a current out that brakes: against e, it
//! gives back at most e²/4R, at half of what shorts the winding. Where that is more than V I₋, currents between two roots
//! are too much, and the current stays below the lesser of them: what is beyond the greater is a harder braking than
//! what was asked for.
//!
//! Motion is then braked with less current the faster it is, and the [position's limits](super::motion_limit) reckon with
//! the least.

use crate::app::square_root::square_root;

/// A limit at or above it is none, A: the bound of the parameters.
pub const NO_LIMIT: f32 = 100.0;

/// The limiter's numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    resistance: f32,
    drawn: Option<f32>,
    returned: Option<f32>,
}

impl Coefficients {
    /// For a winding of this resistance, Ω, above 0: most current that the supply gives, and that it takes, A;
    /// [`NO_LIMIT`] is none.
    pub fn new(resistance: f32, drawn: f32, returned: f32) -> Self {
        let limit = |current: f32| (current < NO_LIMIT).then_some(current);
        Self {
            resistance,
            drawn: limit(drawn),
            returned: limit(returned),
        }
    }

    /// Range of the current, A, the least first, at this observed voltage and this supply, V. It has 0 in it.
    pub fn range(&self, observed: f32, supply: f32) -> [f32; 2] {
        let voltage = observed.abs();
        // With the voltage positive: a current against it, and along it.
        let against = self
            .returned(voltage, supply)
            .min(self.drawn_against(voltage, supply));
        let along = self.drawn_along(voltage, supply);
        if observed < 0.0 {
            [-along, against]
        } else {
            [-against, along]
        }
    }

    /// Most current that is there to brake from this voltage, V, down to none, and to hold, A.
    pub fn braking(&self, voltage: f32, supply: f32) -> f32 {
        self.returned(voltage, supply).min(self.holding(supply))
    }

    /// Most current at rest, A.
    pub fn holding(&self, supply: f32) -> f32 {
        self.drawn_against(0.0, supply)
    }

    /// √(e² + 4 R P) + e.
    fn sum(&self, drawn: f32, voltage: f32, supply: f32) -> f32 {
        let power = drawn * supply;
        voltage + square_root(voltage * voltage + 4.0 * self.resistance * power)
    }

    fn drawn_along(&self, voltage: f32, supply: f32) -> f32 {
        self.drawn.map_or(f32::MAX, |drawn| {
            let sum = self.sum(drawn, voltage, supply);
            // Not the difference that the root's other form has. Without a supply nothing is drawn.
            if sum > 0.0 {
                2.0 * drawn * supply / sum
            } else {
                0.0
            }
        })
    }

    fn drawn_against(&self, voltage: f32, supply: f32) -> f32 {
        self.drawn.map_or(f32::MAX, |drawn| {
            self.sum(drawn, voltage, supply) / (2.0 * self.resistance)
        })
    }

    fn returned(&self, voltage: f32, supply: f32) -> f32 {
        self.returned.map_or(f32::MAX, |returned| {
            let power = returned * supply;
            let square = voltage * voltage - 4.0 * self.resistance * power;
            if square > 0.0 {
                2.0 * power / (voltage + square_root(square))
            } else {
                f32::MAX
            }
        })
    }
}
