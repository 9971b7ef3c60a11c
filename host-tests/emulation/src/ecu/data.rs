//! What an engine controller is told of its throttle body: the data sheet, and nothing that runs in it.

/// The body's machine file.
const FILE: &str = include_str!("../../../machines/throttle-12v.toml");

/// Numbers of a throttle body, referred to its plate, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    pub resistance: f64,
    pub inductance: f64,
    pub torque_constant: f64,
    pub inertia: f64,
    pub viscous: f64,
    pub spring: f64,
    pub spring_rest: f64,
    pub preload: f64,
    pub lower_stop: f64,
    pub upper_stop: f64,
    pub coulomb: f64,
    pub breakaway: f64,
}

impl Body {
    /// From the machine file.
    ///
    /// # Errors
    /// The name of a number that it does not have.
    pub fn read() -> Result<Self, String> {
        let number = |name: &str| {
            let mut lines = FILE.lines();
            let value = lines.find_map(|line| {
                let (key, rest) = line.split_once('=')?;
                let value = rest.split('#').next()?.trim();
                (key.trim() == name).then(|| value.parse().ok()).flatten()
            });
            value.ok_or_else(|| format!("throttle-12v.toml has no number {name}"))
        };
        Ok(Self {
            resistance: number("resistance")?,
            inductance: number("inductance")?,
            torque_constant: number("torque_constant")?,
            inertia: number("inertia")?,
            viscous: number("viscous")?,
            spring: number("spring")?,
            spring_rest: number("spring_rest")?,
            preload: number("spring_preload")?,
            lower_stop: number("lower_stop")?,
            upper_stop: number("upper_stop")?,
            coulomb: number("coulomb")?,
            breakaway: number("static")?,
        })
    }

    /// From stop to stop, rad.
    pub fn stroke(&self) -> f64 {
        self.upper_stop - self.lower_stop
    }

    /// Share of the stroke at which the spring rests.
    pub fn limp_home(&self) -> f64 {
        (self.spring_rest - self.lower_stop) / self.stroke()
    }

    /// Torque of the spring at a share of the stroke, N·m, against which the motor opens.
    pub fn spring_torque(&self, share: f64) -> f64 {
        let away = self.lower_stop + share * self.stroke() - self.spring_rest;
        self.preload.copysign(away) + self.spring * away
    }

    /// Voltage that holds a torque at standstill, V.
    pub fn volts(&self, torque: f64) -> f64 {
        torque * self.resistance / self.torque_constant
    }

    /// Time constant with which speed follows voltage, s.
    pub fn mechanical_time(&self) -> f64 {
        self.inertia / self.damping()
    }

    /// Torque that a speed costs with the winding at a voltage source, N·m·s/rad.
    pub fn damping(&self) -> f64 {
        self.viscous + self.torque_constant.powi(2) / self.resistance
    }
}

/// Voltages of the tracks at the closed and at the open stop, V: the first rises, the second falls.
pub const SPAN: [[f64; 2]; 2] = [[0.5, 4.5], [4.5, 0.5]];

/// Noise of a track at its pin, V rms.
pub const NOISE: f64 = 5e-3;

/// Linearity of a track and mounting tolerance of a stop, of the stroke: what a conductive-plastic
/// potentiometer is sold with.
pub const TOLERANCE: f64 = 0.02;

/// By how much resistance, friction and spring may be off without being faulty: copper between 20 and
/// 95 °C is 30 %, greases and springs are no better.
pub const SPREAD: f64 = 0.3;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_machine_file_is_read() {
        let body = Body::read().unwrap();
        assert_eq!([body.breakaway, body.upper_stop], [0.28, 1.57]);
        // The preload turns at limp-home, 0.18 of 1.55 rad.
        assert!((body.spring_torque(0.0) + 0.345).abs() < 1e-9);
        assert!((body.spring_torque(1.0) - 0.6425).abs() < 1e-9);
    }
}
