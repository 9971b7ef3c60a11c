//! Stand-in for the model core's PID.
#![allow(missing_docs)]

pub struct Parameters {
    pub proportional: f32,
    pub integral: f32,
    pub derivative: f32,
    pub derivative_filter_time: f32,
    pub set_point_weight: f32,
    pub derivative_set_point_weight: f32,
    pub output_minimum: f32,
    pub output_maximum: f32,
}

#[derive(Debug)]
pub struct InvalidParameter;
#[cfg(feature = "tasks")]
impl defmt::Format for InvalidParameter {
    fn format(&self, _: defmt::Formatter) {}
}

pub struct Coefficients(Parameters, f32);

#[derive(Default)]
pub struct State {
    integral: f32,
    last: Option<f32>,
    derivative: f32,
}

#[derive(Debug)]
pub struct NonFinite;

impl Parameters {
    pub fn build(self, period: f32) -> Result<Coefficients, InvalidParameter> {
        Ok(Coefficients(self, period))
    }
}

impl Coefficients {
    pub fn step(&self, s: &mut State, command: f32, position: f32) -> Result<f32, NonFinite> {
        if !(command.is_finite() && position.is_finite()) {
            return Err(NonFinite);
        }
        let error = command - position;
        let h = self.1;
        let t = self.0.derivative_filter_time;
        let last = s.last.replace(position).unwrap_or(position);
        s.derivative = t / (t + h) * s.derivative - self.0.derivative / (t + h) * (position - last);
        let u = self.0.proportional * error + s.integral + s.derivative;
        let limited = u.max(self.0.output_minimum).min(self.0.output_maximum);
        if u == limited {
            s.integral += self.0.integral * error * h;
        }
        Ok(limited)
    }
}
