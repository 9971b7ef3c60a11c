//! Temperatures of the switches and of the motor, each by an NTC, and what they leave of the motor's current.
//!
//! An NTC from the pin to ground under as much as its resistance at 25 °C to the converter's own reference reads
//! the share x = r/(1 + r) with r = R/R₂₅, whatever the reference is. It obeys R = R₂₅ exp(B (1/T − 1/298.15 K)), hence
//! 1/T = 1/298.15 K + ln(x/(1 − x))/B.
//!
//! Over the last 20 K before the maximum the current's limit shrinks in proportion, to nothing at the maximum: a
//! proportional controller of the heat, whose equilibrium lies below the maximum wherever nothing else heats.
//! Half of the 20 K is for what a sensor of 1 % under a resistor of 1 % and the two numbers of its law read too
//! little, 2 K, and for how much hotter than the sensor the thing itself is while it heats up.

use crate::app::debounce::Debounce;
use crate::app::fault::{Fault, Faults};

/// B between 25 and 85 °C of Murata's NCP15 to NCP21XH103, 10 kΩ, K: its data sheet. The same sensor has 3380 K up to 50 °C
/// and 3455 K up to 100 °C.
pub const BETA: f32 = 3434.0;

/// Codes of full scale.
const FULL_SCALE: f32 = 4096.0;

/// 0 °C, K.
const ZERO: f32 = 273.15;

/// Where an NTC has its nominal resistance, K.
const NOMINAL: f32 = 25.0 + ZERO;

/// What no sensor reads that is whole, °C: NTCs are sold for −40 to 125 or 150 °C.
pub const RANGE: [f32; 2] = [-40.0, 150.0];

/// From where to the maximum the current is lessened, K.
pub const DERATED_OVER: f32 = 20.0;

/// Control steps in a row that a sensor reads what it cannot before that counts: heat takes longer.
pub const BROKEN_STEPS: u32 = 50;

/// Share of a reading that is taken over in a control step: a time constant of 64 ms.
pub const FILTER: f32 = 1.0 / 64.0;

/// Temperature of an NTC of this B, K, that reads this code, °C.
///
/// ```
/// use firmware::app::operation::temperature::{BETA, celsius};
///
/// assert_eq!(celsius(BETA, 2048.0), 25.0);
/// ```
pub fn celsius(beta: f32, code: f32) -> f32 {
    let ratio = code / (FULL_SCALE - code);
    let inverse = 1.0 / NOMINAL + libm::logf(ratio) / beta;
    1.0 / inverse - ZERO
}

/// Code of an NTC of this B, K, at this temperature, °C.
fn code(beta: f32, celsius: f32) -> f32 {
    let ratio = libm::expf(beta * (1.0 / (celsius + ZERO) - 1.0 / NOMINAL));
    FULL_SCALE * ratio / (1.0 + ratio)
}

/// One sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Most temperature, °C; 0 for a sensor that is not there.
    pub maximum: f32,
    /// Its B, K.
    pub beta: f32,
}

/// What the temperatures leave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coefficients {
    sensors: [Sensor; 2],
    /// Codes between which a whole sensor reads.
    codes: [[f32; 2]; 2],
    /// Most current, A.
    current: f32,
}

/// What is remembered of a sensor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Seen {
    /// Its code.
    code: Option<f32>,
    outside: Debounce,
}

/// What is remembered.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State([Seen; 2]);

/// What a step says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdict {
    /// Most current, A, either way.
    pub current: f32,
    /// What is wrong.
    pub faults: Faults,
    /// Temperature of each sensor, °C; none of one that is not there, or broken.
    pub celsius: [Option<f32>; 2],
}

impl Coefficients {
    /// For the switches' and the motor's sensor, and the most current, A.
    pub fn new(sensors: [Sensor; 2], current: f32) -> Self {
        Self {
            sensors,
            // The hotter, the less.
            codes: sensors.map(|Sensor { beta, .. }| [code(beta, RANGE[1]), code(beta, RANGE[0])]),
            current,
        }
    }

    /// Takes a control step's codes.
    pub fn step(&self, state: &mut State, codes: [u16; 2]) -> Verdict {
        let mut verdict = Verdict {
            current: self.current,
            faults: Faults::NONE,
            celsius: [None; 2],
        };
        for place in 0..2 {
            let (sensor, seen) = (&self.sensors[place], &mut state.0[place]);
            if sensor.maximum <= 0.0 {
                *seen = Seen::default();
                continue;
            }
            let [least, most] = self.codes[place];
            let read = f32::from(codes[place]);
            // Not of NaN.
            let whole = (least..=most).contains(&read);
            if whole {
                let before = seen.code.unwrap_or(read);
                seen.code = Some(before + FILTER * (read - before));
            }
            if seen.outside.after(BROKEN_STEPS, !whole) {
                seen.code = None;
                verdict.faults = verdict.faults | Fault::TemperatureSensor.into();
            }
            // Nothing is driven before a temperature is known.
            let celsius = seen.code.map(|code| celsius(sensor.beta, code));
            let left = celsius.map_or(0.0, |celsius| sensor.maximum - celsius);
            let share = (left / DERATED_OVER).clamp(0.0, 1.0);
            verdict.current = verdict.current.min(share * self.current);
            let hot = celsius.is_some_and(|celsius| celsius > sensor.maximum);
            verdict.faults = verdict.faults | Faults::when(Fault::OverTemperature, hot);
            verdict.celsius[place] = celsius;
        }
        verdict
    }
}

/// What is told of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Told {
    /// Its maximum is 0.
    NotWatched,
    /// It reads what it cannot.
    Broken,
    /// Its temperature, °C.
    Celsius(f32),
}

impl core::fmt::Display for Told {
    fn fmt(&self, formatter: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotWatched => formatter.write_str("not watched"),
            Self::Broken => formatter.write_str("not readable"),
            Self::Celsius(celsius) => write!(formatter, "{celsius:.1} °C"),
        }
    }
}
