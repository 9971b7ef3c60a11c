//! The position loop, one step in an interrupt below the plant's and above every task.

use heapless::spsc::Consumer;
use model_core::control::pid;

use super::conversion::Converters;
use super::fault::Fault;
use super::fault::output::Bridge;
use super::profile::Profile;
use super::record::{Marks, Recorder, Sample};
use super::wiring::Wiring;
use super::work::ControlWork;

/// A loop to run from now on.
#[derive(Debug, Clone)]
pub struct Setup {
    /// The controller, built for the control period.
    pub pid: pid::Coefficients,
    /// The positions that it is asked for.
    pub profile: Profile,
    /// Sensors and bridge.
    pub converters: Converters,
    /// Steps that are recorded.
    pub steps: u32,
}

/// Controller, its command and its end of the log.
pub struct Control {
    setup: Option<Setup>,
    setups: Consumer<'static, Setup>,
    state: pid::State,
    wiring: &'static Wiring,
    recorder: Recorder,
    /// Steps so far, and the sequence number of the next sample.
    steps: u32,
}

impl Control {
    /// No controller yet: it comes through `setups`, and is taken when the plant begins anew.
    pub fn new(
        setups: Consumer<'static, Setup>,
        wiring: &'static Wiring,
        recorder: Recorder,
    ) -> Self {
        Self {
            setup: None,
            setups,
            state: pid::State::default(),
            wiring,
            recorder,
            steps: 0,
        }
    }
}

impl ControlWork for Control {
    /// Measurement in, duty out, sample to the queue while it is recorded. Behind that the loop goes
    /// on, so that the actuator moves while its log is evaluated.
    fn step(&mut self) {
        if self.wiring.take_restart() {
            self.setup = self.setups.dequeue();
            self.state = pid::State::default();
            self.steps = 0;
            self.recorder.begin();
        }
        let Some(setup) = &mut self.setup else {
            self.wiring.set_control_due(false);
            return;
        };
        let measured = self.wiring.measurement();
        let position = setup.converters.position.value(measured.position);
        let begins = setup.profile.begins();
        let command = setup.profile.advance();
        let voltage = setup.pid.step(&mut self.state, command, position);
        match voltage.map(|voltage| setup.converters.bridge.counts(voltage)) {
            Ok(Some(duty)) => self.wiring.drive(duty),
            _ => self.wiring.trip(Fault::NonFinite),
        }
        if self.steps < setup.steps {
            self.recorder.push(Sample {
                sequence: self.steps,
                command,
                duty: self.wiring.duty(),
                position: measured.position,
                current: measured.current,
                truth: self.wiring.truth(),
                marks: Marks {
                    command: begins,
                    fault: self.wiring.fault().is_some(),
                    driven: self.wiring.latch().outputs().bridge == Bridge::Driven,
                },
            });
            self.steps += 1;
        } else {
            self.recorder.finish();
        }
        self.wiring.set_control_due(false);
    }
}
