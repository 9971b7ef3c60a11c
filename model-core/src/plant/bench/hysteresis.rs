//! Hysteresis PWM: a relay for each phase (bench paper, section 3.3).
//!
//! A relay switches on where its current is low by the band, off where it is high by the band, and
//! else stays as it is. There is no carrier: the frequency is what currents and inductance make it.

/// The relays' outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Relays {
    on: [bool; 3],
}

impl Relays {
    /// Which phases are to be at the positive rail, for errors (reference − current) and a band, A.
    #[inline]
    pub fn switch(&mut self, errors: [f32; 3], band: f32) -> [bool; 3] {
        for (on, error) in self.on.iter_mut().zip(errors) {
            *on = if *on { error > -band } else { error >= band };
        }
        self.on
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relay_stays_as_it_is_within_its_band() {
        let mut relays = Relays::default();
        let mut first = |error| relays.switch([error, 0.0, 0.0], 0.1)[0];
        assert!(!first(0.09));
        assert!(first(0.1));
        assert!(first(-0.09));
        assert!(!first(-0.1));
        assert!(!first(0.09));
    }
}
