//! The gear pair between slow shaft and encoder. Everything is referred to the slow shaft.

use super::ENCODER_RATIO;
use std::f64::consts::TAU;

/// How teeth touch on either side of the play.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Contact {
    /// At once and without give: the encoder gear is carried along, and stays where it is left.
    Rigid,
    /// A Kelvin–Voigt body of the printed teeth and their mount; it pushes and never pulls.
    Elastic {
        /// N·m/rad.
        stiffness: f64,
        /// N·m·s/rad.
        damping: f64,
    },
}

/// Play, teeth, and what turns behind them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderGear {
    /// Clear width of the play from flank to flank, rad.
    pub clearance: f64,
    /// How the teeth touch.
    pub contact: Contact,
    /// Of encoder and encoder gear, kg·m².
    pub inertia: f64,
    /// Friction of the turning encoder bearing, N·m.
    pub running_torque: f64,
    /// What it takes to start it, N·m; at least `running_torque`.
    pub starting_torque: f64,
    /// Reading error from an eccentric encoder gear, rad; 0 for a centred one.
    pub eccentricity: f64,
    /// One count, rad; 0 for a continuous encoder.
    pub resolution: f64,
}

impl EncoderGear {
    /// Encoder of 40 g·cm² (Table 2.6) and a printed gear of 18.75 mm radius, 20 mm wide, kg·m².
    const INERTIA: f64 = (4.0e-6 + 4.8e-6) * ENCODER_RATIO * ENCODER_RATIO;
    /// 0.025 N·m at the encoder (Table 2.6).
    const STARTING_TORQUE: f64 = 0.025 * ENCODER_RATIO;
    const RUNNING_TORQUE: f64 = 0.020 * ENCODER_RATIO;
    /// Four counts for each of 10,000 pulses (Table 2.6).
    const RESOLUTION: f64 = TAU / (40_000.0 * ENCODER_RATIO);
    /// Stiffness of teeth in full mesh, N·m/rad: with the bearing's friction it leaves part of the
    /// 0.166° that the paper read where its gears were pressed together.
    const STIFFNESS: f64 = 64.0;
    /// Clear width over which a tooth's lever doubles, rad (0.625°).
    const SOFTENING: f64 = 0.0109;
    /// Time in which the printed teeth creep, s: damping over stiffness.
    const RELAXATION: f64 = 0.1;

    /// The bench's gear pair at this clear width, rad. Drawn apart, the teeth touch nearer to their
    /// tips and fewer of them at a time, so that the pair softens: as cantilevers do, with the cube of
    /// their lever. The constants are chosen, not measured: the encoder shall leave the play earlier
    /// than the paper's model does, the more so the wider it is (section 6.3).
    pub fn printed(clearance: f64) -> Self {
        let stiffness = Self::STIFFNESS / (1.0 + clearance / Self::SOFTENING).powi(3);
        Self {
            clearance,
            contact: Contact::Elastic {
                stiffness,
                damping: Self::RELAXATION * stiffness,
            },
            inertia: Self::INERTIA,
            running_torque: Self::RUNNING_TORQUE,
            starting_torque: Self::STARTING_TORQUE,
            eccentricity: 0.0,
            resolution: Self::RESOLUTION,
        }
    }

    /// The paper's model of it: a play operator of this clear width, rad, and the encoder's counts.
    pub fn play(clearance: f64) -> Self {
        Self {
            contact: Contact::Rigid,
            ..Self::printed(clearance)
        }
    }

    /// Torque of the teeth on the encoder gear, N·m, when the slow shaft is ahead of it by `lead`,
    /// rad, and gets ahead at `rate`, rad/s; 0 within the play and for rigid teeth.
    pub(super) fn tooth_torque(&self, lead: f64, rate: f64) -> f64 {
        let Contact::Elastic { stiffness, damping } = self.contact else {
            return 0.0;
        };
        let half = 0.5 * self.clearance;
        if lead > half {
            (stiffness * (lead - half) + damping * rate).max(0.0)
        } else if lead < -half {
            (stiffness * (lead + half) + damping * rate).min(0.0)
        } else {
            0.0
        }
    }

    /// What the encoder reports for a gear at `angle`, rad: the last count passed.
    pub(super) fn reading(&self, angle: f64) -> f64 {
        let angle = angle + self.eccentricity * (ENCODER_RATIO * angle).sin();
        if self.resolution > 0.0 {
            (angle / self.resolution).floor() * self.resolution
        } else {
            angle
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ENCODER_RATIO, EncoderGear};
    use std::f64::consts::TAU;

    #[test]
    fn encoder_reports_the_last_of_its_counts() {
        let gear = EncoderGear::printed(0.0);
        let counts = 40_000.0 * 62.0 / 15.0;
        let near_the_next_count = (1000.0 + 0.99) / counts * TAU;
        assert!((gear.reading(near_the_next_count) - 1000.0 / counts * TAU).abs() < 1e-12);
    }

    /// Once a turn of the encoder, greatest after a quarter of it.
    #[test]
    fn eccentricity_bends_the_reading() {
        let gear = EncoderGear {
            eccentricity: 1.0e-3,
            resolution: 0.0,
            ..EncoderGear::printed(0.0)
        };
        for (turns, error) in [(0.0, 0.0), (0.25, 1.0e-3), (0.5, 0.0), (0.75, -1.0e-3)] {
            let angle = TAU * turns / ENCODER_RATIO;
            assert!(
                (gear.reading(angle) - angle - error).abs() < 1e-12,
                "{turns}"
            );
        }
    }
}
