//! The whole bench under its cascade, and the log that it leaves.

use super::GEAR_RATIO;
use super::brake::Brake;
use super::control::{Control, SpeedLoop};
use super::current_loop::CurrentLoop;
use super::encoder_gear::EncoderGear;
use super::loss::Loss;
use super::motor::Motor;
use super::plant::{Plant, STEP};
use super::program::Program;
use super::recording::Recording;
use super::sensors::Sensors;
use crate::random::Random;

/// What the bench is made of. Change any field, [`Bench::run`] it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench {
    /// And what turns with it.
    pub motor: Motor,
    /// Behind the chain.
    pub brake: Brake,
    /// What makes the current high.
    pub loss: Loss,
    /// Between slow shaft and encoder.
    pub gear: EncoderGear,
    /// Of drive and load cell.
    pub sensors: Sensors,
    /// Of PLC and drive.
    pub control: Control,
    /// Largest integration step, s.
    pub step: f64,
}

impl Default for Bench {
    /// No brake, no loss and no play, but printed teeth and real sensors.
    fn default() -> Self {
        Self {
            motor: Motor::SIMOTICS_1FK7060,
            brake: Brake::even(0.0),
            loss: Loss::None,
            gear: EncoderGear::printed(0.0),
            sensors: Sensors::BENCH,
            control: Control::BENCH,
            step: STEP,
        }
    }
}

impl Bench {
    /// The log of this program. The bench starts at rest at 0, in the middle of its play; equal
    /// seeds give equal logs.
    ///
    /// # Panics
    /// If the program's sample rate is not an integer part of the drive's 8000 Hz.
    pub fn run(&self, program: &Program) -> Recording {
        let drive_rate = 1.0 / Control::PERIOD;
        let divider = (drive_rate / program.sample_rate).round();
        assert!(
            divider >= 1.0 && (divider * program.sample_rate - drive_rate).abs() < 1e-6,
            "the sample rate must be {drive_rate} Hz over an integer, not {} Hz",
            program.sample_rate
        );
        let divider = divider as usize;
        let first = (program.settling * drive_rate).round() as usize;
        let rows = (program.seconds * program.sample_rate).round() as usize;

        let mut running = Running::new(self, program.seed);
        for tick in 0..first + rows * divider {
            let time = tick as f64 * Control::PERIOD;
            if tick.is_multiple_of(self.control.position_divider) {
                running.position_loop(program.trajectory.at(time));
            }
            let voltage = running.drive();
            if tick >= first && (tick - first).is_multiple_of(divider) {
                running.log((tick - first) as f64 * Control::PERIOD);
            }
            running.plant.advance(voltage, Control::PERIOD);
        }
        running.recording
    }
}

/// A bench in motion.
struct Running<'a> {
    bench: &'a Bench,
    plant: Plant,
    random: Random,
    command: f64,
    reference_speed: f64,
    speed_loop: SpeedLoop,
    current_loop: CurrentLoop,
    measured_speed: f64,
    filtered_current: f64,
    recording: Recording,
}

impl<'a> Running<'a> {
    fn new(bench: &'a Bench, seed: u64) -> Self {
        let plant = Plant::new(bench.motor, bench.brake, bench.loss, bench.gear);
        Self {
            bench,
            plant: plant.with_step(bench.step),
            random: Random::new(seed),
            command: 0.0,
            reference_speed: 0.0,
            speed_loop: SpeedLoop::default(),
            current_loop: CurrentLoop::default(),
            measured_speed: 0.0,
            filtered_current: 0.0,
            recording: Recording::default(),
        }
    }

    /// One period of the PLC.
    fn position_loop(&mut self, command: f64) {
        self.command = command;
        let error = GEAR_RATIO * (command - self.encoder_position());
        self.reference_speed = self.bench.control.reference_speed(error);
    }

    /// One period of the drive: what it measures, and the voltages that it sets.
    fn drive(&mut self) -> (f64, f64) {
        let (motor, sensors) = (&self.bench.motor, &self.bench.sensors);
        let state = *self.plant.state();
        let (offset_d, offset_q) = sensors.offset(motor.pole_pairs * state.angle);
        let mut noisy = |value: f64, deviation: f64| {
            if deviation == 0.0 {
                value
            } else {
                value + deviation * self.random.normal()
            }
        };
        self.measured_speed = noisy(state.speed, sensors.speed_noise);
        let current_d = noisy(state.current_d + offset_d, sensors.current_noise);
        let current_q = noisy(state.current_q + offset_q, sensors.current_noise);
        let ripple = sensors.current_ripple * (2.0 * self.random.uniform() - 1.0);
        self.filtered_current +=
            sensors.filter_share() * (current_q + ripple - self.filtered_current);

        let torque = self.speed_loop.step(
            &self.bench.control,
            self.reference_speed - self.measured_speed,
            motor.torque_constant * motor.peak_current,
        );
        self.current_loop.step(
            motor,
            (current_d, current_q),
            torque / motor.torque_constant,
            self.measured_speed,
        )
    }

    fn log(&mut self, time: f64) {
        let state = *self.plant.state();
        let force = Brake::load_cell_force(self.plant.brake_torque())
            + self.bench.sensors.force_noise * self.random.normal();
        let encoder_position = self.encoder_position();
        let recording = &mut self.recording;
        recording.time.push(time);
        recording.command.push(self.command);
        recording.encoder_position.push(encoder_position);
        recording.motor_position.push(state.angle / GEAR_RATIO);
        recording.motor_velocity.push(self.measured_speed);
        recording.current_q.push(self.filtered_current);
        recording.load_cell_force.push(force);
        recording.true_torque.push(self.plant.motor_torque());
        recording.true_velocity.push(state.speed);
    }

    fn encoder_position(&self) -> f64 {
        self.bench.gear.reading(self.plant.state().encoder_angle)
    }
}
