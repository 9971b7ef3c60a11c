//! A log of the user's in the core's numbers.

use model_core::gap::log::{Channel, Log as CoreLog};

use crate::log::Log;
use crate::machine::Machine;

/// A log in the core's numbers.
pub(super) struct Series {
    pub label: String,
    pub period: f32,
    pub input: Vec<f32>,
    pub position: Vec<f32>,
    pub current: Option<Vec<f32>>,
    pub velocity: Option<Vec<f32>>,
    pub brake: Option<Vec<f32>>,
    pub load: Option<Vec<f32>>,
    pub enabled: Option<Vec<f32>>,
}

impl Series {
    /// The logs of a machine.
    pub fn of(logs: &[Log], machine: &Machine) -> Vec<Self> {
        let has_motor = machine.motor.is_some();
        logs.iter().map(|log| Self::new(log, has_motor)).collect()
    }

    /// With a torque input there is no motor in the model, and nothing to compare a current with.
    fn new(log: &Log, has_motor: bool) -> Self {
        let narrow = |series: &[f64]| series.iter().map(|&value| value as f32).collect();
        Self {
            label: log.path.display().to_string(),
            period: log.period_s as f32,
            input: narrow(&log.input),
            position: narrow(&log.position),
            current: log.current.as_deref().filter(|_| has_motor).map(narrow),
            velocity: log.velocity.as_deref().map(narrow),
            brake: log.brake.as_deref().map(narrow),
            load: log.load_torque.as_deref().map(narrow),
            enabled: log.enabled.as_deref().map(narrow),
        }
    }

    pub fn log(&self) -> CoreLog<'_> {
        CoreLog {
            period: self.period,
            input: Channel::Values(&self.input),
            position: Channel::Values(&self.position),
            current: self.current.as_deref().map(Channel::Values),
            velocity: self.velocity.as_deref().map(Channel::Values),
            brake: self.brake.as_deref().map(Channel::Values),
            load: self.load.as_deref().map(Channel::Values),
            enabled: self.enabled.as_deref().map(Channel::Values),
        }
    }
}
