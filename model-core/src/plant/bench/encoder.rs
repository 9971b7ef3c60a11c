//! The encoder on the slow shaft: gears, backlash, counts (bench paper, sections 2.1.6 and 5.2).
//!
//! A gear on the gearbox's output drives the encoder's, 62/15 turns for one. What the encoder
//! counts is referred to the slow shaft by the same ratio.

use super::backlash::Play;
use super::tooth_contact::{self, ToothContact};
use crate::numeric::invalid_parameter::{InvalidParameter, require};
use crate::plant::ema::{encoder, gearbox};

/// What the teeth are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meshing {
    /// The paper's: a play, [`super::backlash`].
    Rigid,
    /// Beyond the paper: a body behind elastic teeth, [`super::tooth_contact`].
    Elastic(tooth_contact::Parameters),
}

/// What the encoder is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Its counts.
    pub counter: encoder::Parameters,
    /// Its gears.
    pub gears: gearbox::Parameters,
    /// Whole width of their backlash, rad of the slow shaft, ≥ 0: twice what Algorithm 1 measures.
    pub backlash: f32,
    /// How they mesh.
    pub meshing: Meshing,
}

#[derive(Debug, Clone, PartialEq)]
enum Teeth {
    Rigid(Play),
    Elastic(ToothContact),
}

/// The encoder in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoder {
    counter: encoder::Parameters,
    ratio: f32,
    /// rad of the slow shaft for one count.
    count: f32,
    teeth: Teeth,
}

impl Encoder {
    /// In the middle of its backlash at zero, for steps of `period` seconds.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn build(parameters: &Parameters, period: f32) -> Result<Self, InvalidParameter> {
        parameters.gears.check()?;
        parameters.counter.check(1.0)?;
        require(
            parameters.backlash >= 0.0 && parameters.backlash.is_finite(),
            "backlash",
            "must be at least 0 and finite",
        )?;
        let play = Play::new(parameters.backlash);
        let teeth = match &parameters.meshing {
            Meshing::Rigid => Teeth::Rigid(play),
            Meshing::Elastic(contact) => {
                Teeth::Elastic(ToothContact::build(contact, play.half_width(), period)?)
            }
        };
        Ok(Self {
            counter: parameters.counter,
            ratio: parameters.gears.ratio,
            count: parameters.counter.angle() / parameters.gears.ratio,
            teeth,
        })
    }

    /// One step with the slow shaft at an angle, rad, and a velocity, rad/s. The torque, N·m, that
    /// the encoder takes from the slow shaft.
    #[inline]
    pub fn step(&mut self, angle: f32, velocity: f32) -> f32 {
        match &mut self.teeth {
            Teeth::Rigid(play) => {
                play.follow(angle);
                0.0
            }
            Teeth::Elastic(contact) => contact.step(angle, velocity),
        }
    }

    /// Its angle, rad of the slow shaft: between counts too.
    #[inline]
    pub fn angle(&self) -> f32 {
        match &self.teeth {
            Teeth::Rigid(play) => play.output(),
            Teeth::Elastic(contact) => contact.angle(),
        }
    }

    /// What its counter says, rad of the slow shaft: the last edge passed, as seen from below.
    #[inline]
    pub fn position(&self) -> f32 {
        self.count * self.counter.count(self.angle() * self.ratio)
    }
}
