//! The position loop, one step in an interrupt below the plant's and above every task.

use super::profile;
use super::record::{Recorder, Sample};
use super::timing::CONTROL_PERIOD_US;
use super::wiring::{Fault, Wiring};
use model_core::control::pid;

/// Controller, its command and its end of the log.
pub struct Control {
    pid: pid::Coefficients,
    state: pid::State,
    wiring: &'static Wiring,
    recorder: Recorder,
    /// Steps so far, and the sequence number of the next sample.
    steps: u32,
}

impl Control {
    /// A controller at rest, before the first step of the profile.
    pub fn new(pid: pid::Coefficients, wiring: &'static Wiring, recorder: Recorder) -> Self {
        Self {
            pid,
            state: pid::State::default(),
            wiring,
            recorder,
            steps: 0,
        }
    }

    /// Measurement in, voltage out, sample to the queue. Once the profile has ended, nothing but a
    /// bridge at zero.
    pub fn step(&mut self) {
        let measured = self.wiring.measurement();
        if let Some(command) = profile::command(self.steps) {
            match self.pid.step(&mut self.state, command, measured.position) {
                Ok(voltage) => self.wiring.drive(voltage),
                Err(_) => self.wiring.trip(Fault::NonFinite),
            }
            self.recorder.push(Sample {
                sequence: self.steps,
                time_us: u64::from(self.steps) * u64::from(CONTROL_PERIOD_US),
                input: self.wiring.bridge_voltage(),
                position: measured.position,
                command,
                current: measured.current,
                velocity: measured.velocity,
            });
            self.steps += 1;
        } else {
            self.wiring.drive(0.0);
            self.recorder.finish();
        }
        self.wiring.set_control_due(false);
    }
}
