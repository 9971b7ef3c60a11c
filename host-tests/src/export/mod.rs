//! `cargo hil export`: a machine file's model with its declared effects, for another simulator.
//!
//! What a target cannot express is named, in the exported text and on standard error; nothing is dropped in silence.

mod c;
pub mod command;
mod fmu;
mod mujoco;

use model_core::effect::Id;
use model_core::gap::model::Model;

use crate::error::InputError;
use crate::gap::declared;
use crate::machine::Machine;
use crate::quantity::decimal;

/// A machine with the core's model of it.
pub(crate) struct Source {
    pub machine: Machine,
    pub model: Model,
}

/// What a target does not express: the line of the machine file to blame, where there is one, and what it is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Missing {
    pub line: Option<usize>,
    pub what: String,
}

impl Source {
    pub fn new(machine: Machine) -> Result<Self, InputError> {
        let model = declared::model(&machine)?;
        Ok(Self { machine, model })
    }

    /// The line of the machine file that declares an effect.
    fn line_of(&self, id: Id) -> Option<usize> {
        let name = id.description().id;
        let declared = self.machine.declared_effects.iter();
        declared
            .into_iter()
            .find(|effect| effect.id == name)
            .map(|effect| effect.line)
    }

    /// That an effect is not expressed, with why.
    fn effect_missing(&self, id: Id, why: &str) -> Missing {
        Missing {
            line: self.line_of(id),
            what: format!("effect `{}` is not expressed: {why}", id.description().id),
        }
    }

    /// Its name as it can stand in a comment of any language.
    fn name(&self) -> String {
        let plain = |c: char| {
            if c.is_alphanumeric() || " _.,:()".contains(c) {
                c
            } else {
                '_'
            }
        };
        // Two hyphens would end a comment of XML, so that none is left.
        self.machine.name.chars().map(plain).take(80).collect()
    }
}

/// A number of the core as C, XML and a person read it, to the last bit of the core's.
fn number(value: f32) -> String {
    format!("{:?}", decimal(value))
}
