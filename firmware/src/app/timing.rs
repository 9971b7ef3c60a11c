//! Rates, and why they are what they are.

/// Period of the emulated plant, µs: a twentieth of the fastest time constant of the actuators at
/// hand, L/R = 1 ms, and of the control period.
pub const PLANT_PERIOD_US: u32 = 50;

/// Period of the position loop, µs: 24 samples in a period of its crossover, 260 1/s at most.
pub const CONTROL_PERIOD_US: u32 = 1000;

/// Plant ticks in a control period.
pub const TICKS_PER_CONTROL: u32 = CONTROL_PERIOD_US / PLANT_PERIOD_US;

/// Control steps in a second.
pub const STEPS_PER_SECOND: u32 = 1_000_000 / CONTROL_PERIOD_US;

/// How often the recording task empties the sample queue, ms.
pub const RECORD_PERIOD_MS: u64 = 5;

/// Samples that the queue holds: six recording periods, so that a task that runs late by a few
/// of them loses nothing.
pub const QUEUED_SAMPLES: usize = 32;

const _: () = assert!(CONTROL_PERIOD_US.is_multiple_of(PLANT_PERIOD_US));

/// Period of the emulated plant, s.
pub const PLANT_PERIOD: f32 = PLANT_PERIOD_US as f32 * 1e-6;

/// Period of the position loop, s.
pub const CONTROL_PERIOD: f32 = CONTROL_PERIOD_US as f32 * 1e-6;
