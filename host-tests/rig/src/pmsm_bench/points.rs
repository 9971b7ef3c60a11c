//! The fifteen points of the campaign (Tables 5.3 to 5.5).

use super::brake::Brake;
use super::encoder_gear::EncoderGear;
use super::loss::Loss;
use super::program::Program;
use super::recording::Recording;
use super::run::Bench;

/// Friction of the brake (Table 5.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionLevel {
    /// No brake.
    Low,
    /// Brake half way in.
    Medium,
    /// Brake all the way in.
    High,
}

impl FrictionLevel {
    /// From the least on.
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    /// Mean torque of the brake at the motor shaft, N·m.
    pub const fn torque(self) -> f64 {
        match self {
            Self::Low => 0.0,
            Self::Medium => 0.32325,
            Self::High => 0.70092,
        }
    }
}

/// Distance of the encoder gear (Table 5.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BacklashLevel {
    /// Micro-mover at 13 mm.
    Low,
    /// 12 mm.
    MediumLow,
    /// 10 mm.
    Medium,
    /// 9 mm.
    MediumHigh,
    /// 8 mm.
    High,
}

impl BacklashLevel {
    /// From the least on.
    pub const ALL: [Self; 5] = [
        Self::Low,
        Self::MediumLow,
        Self::Medium,
        Self::MediumHigh,
        Self::High,
    ];

    /// What Algorithm 1 reads, rad (the paper prints degrees).
    pub fn reading(self) -> f64 {
        let degrees: f64 = match self {
            Self::Low => 0.16575,
            Self::MediumLow => 0.16905,
            Self::Medium => 0.46382,
            Self::MediumHigh => 0.70121,
            Self::High => 0.98959,
        };
        degrees.to_radians()
    }

    /// Clear width of the play, rad, with which Algorithm 1 reads [`BacklashLevel::reading`] off this
    /// bench's sine without the brake: the rest of the reading is bent teeth.
    pub fn clearance(self) -> f64 {
        let degrees: f64 = match self {
            Self::Low => 0.0991,
            Self::MediumLow => 0.1025,
            Self::Medium => 0.3547,
            Self::MediumHigh => 0.5108,
            Self::High => 0.6672,
        };
        degrees.to_radians()
    }
}

/// One sampling point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Point {
    /// Of the brake.
    pub friction: FrictionLevel,
    /// Of the encoder gear.
    pub backlash: BacklashLevel,
}

impl Point {
    /// In the order of Table 5.5: sample n is `ALL[n - 1]`.
    pub const ALL: [Self; 15] = {
        let mut all = [Self {
            friction: FrictionLevel::Low,
            backlash: BacklashLevel::Low,
        }; 15];
        let mut index = 0;
        while index < all.len() {
            all[index] = Self {
                friction: FrictionLevel::ALL[index / 5],
                backlash: BacklashLevel::ALL[index % 5],
            };
            index += 1;
        }
        all
    };

    /// The bench as it stands at this point, with this loss.
    pub fn bench(self, loss: Loss) -> Bench {
        Bench {
            brake: Brake::with_run_out(self.friction.torque()),
            loss,
            gear: EncoderGear::printed(self.backlash.clearance()),
            ..Bench::default()
        }
    }
}

/// The logs of [`Point::ALL`] under this program, in their order: the whole campaign. The first point
/// has the program's seed, each later one the next.
pub fn campaign(loss: Loss, program: &Program) -> Vec<Recording> {
    Point::ALL
        .into_iter()
        .zip(program.seed..)
        .map(|(point, seed)| point.bench(loss).run(&program.clone().seeded(seed)))
        .collect()
}
