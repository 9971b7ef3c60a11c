//! The actuator as its maker would declare it, and six of them ready to use.

use crate::controller::PidGains;
use std::fmt::Write;

/// What the position counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coordinate {
    /// An angle, rad; loads are torques, N·m.
    Radian,
    /// A displacement, m; loads are forces, N.
    Metre,
}

/// How the input becomes a load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motor {
    /// A brushed DC winding: L di/dt = u − R i − k v, load k i. The input is a voltage.
    Winding {
        /// R, Ω, positive.
        resistance: f64,
        /// L, H; 0 makes the current follow the voltage at once.
        inductance: f64,
        /// k, N·m/A and V·s/rad (N/A and V·s/m), referred to the coordinate.
        torque_constant: f64,
    },
    /// A current-controlled drive: load = gain × input.
    Direct {
        /// N·m or N for one unit of input.
        gain: f64,
    },
}

/// A spring that returns the coordinate to `rest`, with a step on either side of it (limp-home):
/// load −(stiffness (x − rest) + preload sgn(x − rest)). At rest it holds any load up to `preload`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReturnSpring {
    /// N·m/rad or N/m.
    pub stiffness: f64,
    /// rad or m.
    pub rest: f64,
    /// N·m or N, not negative.
    pub preload: f64,
}

/// Inelastic end stops: a machine that reaches one stays there until its load points back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stops {
    /// rad or m.
    pub lower: f64,
    /// rad or m, above `lower`.
    pub upper: f64,
}

/// One actuator with its sensor, its position loop and the range in which it is worked.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name in the machine file.
    pub name: &'static str,
    /// Rotary or linear.
    pub coordinate: Coordinate,
    /// Electrical side.
    pub motor: Motor,
    /// Largest magnitude of the input that the drive puts out.
    pub input_limit: f64,
    /// J or M, kg·m² or kg.
    pub inertia: f64,
    /// b, N·m·s/rad or N·s/m.
    pub viscous: f64,
    /// Friction while sliding, N·m or N.
    pub coulomb: f64,
    /// Friction to be overcome from standstill, N·m or N, not below `coulomb`.
    pub static_friction: f64,
    /// Return spring, if there is one.
    pub spring: Option<ReturnSpring>,
    /// End stops, if they are in reach.
    pub stops: Option<Stops>,
    /// One count of the encoder, rad or m; 0 reports the exact position.
    pub resolution: f64,
    /// Gains of the position loop that the bench runs it with.
    pub gains: PidGains,
    /// The range that the ready-made trajectories use, lower and upper end.
    pub stroke: (f64, f64),
    /// The top speed of the ready-made trajectories, rad/s or m/s.
    pub speed: f64,
}

impl Machine {
    /// A 24 V rotary actuator with strong Coulomb friction and a coarse encoder; no stop in reach.
    pub fn rotary_ema() -> Self {
        Self {
            name: "ema-24v",
            coordinate: Coordinate::Radian,
            motor: Motor::Winding {
                resistance: 1.0,
                inductance: 1.0e-3,
                torque_constant: 0.06,
            },
            input_limit: 24.0,
            inertia: 1.2e-4,
            viscous: 2.0e-4,
            coulomb: 0.12,
            static_friction: 0.15,
            spring: None,
            stops: None,
            resolution: 3.1e-3,
            gains: PidGains {
                proportional: 17.0,
                integral: 60.0,
                derivative: 0.25,
                derivative_time: 3.0e-3,
            },
            stroke: (-5.0, 5.0),
            speed: 60.0,
        }
    }

    /// A 95 kg ball-screw slide behind a current-controlled drive, 35 N for each volt of input.
    pub fn force_slide() -> Self {
        Self {
            name: "slide-95kg",
            coordinate: Coordinate::Metre,
            motor: Motor::Direct { gain: 35.0 },
            input_limit: 10.0,
            inertia: 95.0,
            viscous: 200.0,
            coulomb: 20.0,
            static_friction: 24.0,
            spring: None,
            stops: None,
            resolution: 1.0e-6,
            gains: PidGains {
                proportional: 980.0,
                integral: 2000.0,
                derivative: 77.0,
                derivative_time: 3.0e-3,
            },
            stroke: (-0.1, 0.1),
            speed: 0.15,
        }
    }

    /// A geared 12 V throttle body: return spring with a limp-home step, a stop at either end.
    /// All values are referred to the plate.
    pub fn throttle() -> Self {
        Self {
            name: "throttle",
            coordinate: Coordinate::Radian,
            motor: Motor::Winding {
                resistance: 2.0,
                inductance: 1.2e-3,
                torque_constant: 0.38,
            },
            input_limit: 12.0,
            inertia: 1.6e-3,
            viscous: 8.0e-3,
            coulomb: 0.24,
            static_friction: 0.28,
            spring: Some(ReturnSpring {
                stiffness: 0.25,
                rest: 0.2,
                preload: 0.3,
            }),
            stops: Some(Stops {
                lower: 0.02,
                upper: 1.57,
            }),
            resolution: 1.0e-3,
            gains: PidGains {
                proportional: 32.0,
                integral: 120.0,
                derivative: 0.5,
                derivative_time: 3.0e-3,
            },
            stroke: (0.08, 1.48),
            speed: 6.0,
        }
    }

    /// A diesel's 12 V intake throttle: the spring holds it open at the upper stop, a negative
    /// voltage closes it.
    ///
    /// The same class of part as [`Machine::throttle`], and its orders of magnitude: a motor of
    /// 2 Ω and 19 mN·m/A behind a gear of about 20, which closes the plate within 0.2 s of the
    /// full 12 V; a spring that opens against friction with a reserve of half the friction. The
    /// potentiometer gives 0.5 to 4.5 V over the stroke, read with 12 bits of 5 V.
    pub fn intake_throttle() -> Self {
        Self {
            name: "intake-throttle-12v",
            spring: Some(ReturnSpring {
                stiffness: 0.25,
                rest: 1.57,
                preload: 0.4,
            }),
            stops: Some(Stops {
                lower: 0.0,
                upper: 1.57,
            }),
            resolution: 4.8e-4,
            ..Self::throttle()
        }
    }

    /// A 12 V swirl flap: a small motor behind a gear, its spring holds the flap at the lower
    /// stop. All values are referred to the flap's shaft.
    ///
    /// Orders of magnitude, no measured part: a motor of 10 mN·m/A and 1e-7 kg·m² behind a gear of
    /// 50 gives 0.5 N·m/A and a quarter of the inertia of a throttle; friction and preload are
    /// half of a throttle's, the stroke of 83° takes about 0.2 s. Potentiometer as in
    /// [`Machine::intake_throttle`].
    pub fn swirl_flap() -> Self {
        Self {
            name: "swirl-flap-12v",
            coordinate: Coordinate::Radian,
            motor: Motor::Winding {
                resistance: 5.0,
                inductance: 2.0e-3,
                torque_constant: 0.5,
            },
            input_limit: 12.0,
            inertia: 4.0e-4,
            viscous: 1.0e-2,
            coulomb: 0.12,
            static_friction: 0.15,
            spring: Some(ReturnSpring {
                stiffness: 0.1,
                rest: 0.0,
                preload: 0.22,
            }),
            stops: Some(Stops {
                lower: 0.0,
                upper: 1.45,
            }),
            resolution: 4.4e-4,
            gains: PidGains {
                proportional: 32.0,
                integral: 120.0,
                derivative: 0.8,
                derivative_time: 3.0e-3,
            },
            stroke: (0.08, 1.36),
            speed: 5.0,
        }
    }

    /// A 12 V exhaust-gas recirculation valve: a poppet valve that its spring presses onto the
    /// seat at 0, moved by a motor through a gear. All values are referred to the stem: metres,
    /// newtons, and a mass that is nearly all the rotor's.
    ///
    /// Orders of magnitude, no measured part: a motor of 20 mN·m/A and 3e-6 kg·m² that turns 20 rad
    /// for 6 mm gives 66 N/A and 33 kg; 40 N on the seat against the exhaust's pressure, about as
    /// much friction in the stem's guide as in the gear, the stroke within 0.1 s. Potentiometer as
    /// in [`Machine::intake_throttle`].
    pub fn egr_valve() -> Self {
        Self {
            name: "egr-valve-12v",
            coordinate: Coordinate::Metre,
            motor: Motor::Winding {
                resistance: 3.0,
                inductance: 2.0e-3,
                torque_constant: 66.0,
            },
            input_limit: 12.0,
            inertia: 33.0,
            viscous: 100.0,
            coulomb: 22.0,
            static_friction: 27.0,
            spring: Some(ReturnSpring {
                stiffness: 5.0e3,
                rest: 0.0,
                preload: 40.0,
            }),
            stops: Some(Stops {
                lower: 0.0,
                upper: 6.0e-3,
            }),
            resolution: 1.8e-6,
            gains: PidGains {
                proportional: 8.0e3,
                integral: 3.0e4,
                derivative: 150.0,
                derivative_time: 3.0e-3,
            },
            stroke: (4.0e-4, 5.6e-3),
            speed: 0.03,
        }
    }

    /// Middle of the stroke, rad or m.
    pub fn centre(&self) -> f64 {
        0.5 * (self.stroke.0 + self.stroke.1)
    }

    /// Resistance of the winding, Ω; 1 without one.
    pub(crate) fn resistance(&self) -> f64 {
        match self.motor {
            Motor::Winding { resistance, .. } => resistance,
            Motor::Direct { .. } => 1.0,
        }
    }

    /// Torque constant of the winding, N·m/A or N/A; 1 without one.
    pub(crate) fn torque_constant(&self) -> f64 {
        match self.motor {
            Motor::Winding {
                torque_constant, ..
            } => torque_constant,
            Motor::Direct { .. } => 1.0,
        }
    }

    /// Half the stroke, rad or m.
    pub fn amplitude(&self) -> f64 {
        0.5 * (self.stroke.1 - self.stroke.0)
    }

    /// The machine file that declares this machine. An effect never appears in it: what the
    /// experiment adds is what the declared model lacks. For wrong base parameters, write the file
    /// of another `Machine`.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        let mut line = |key: &str, value: String| {
            writeln!(text, "{key} = {value}").expect("a String takes any text");
        };
        line("name", format!("{:?}", self.name));
        let coordinate = match self.coordinate {
            Coordinate::Radian => "rad",
            Coordinate::Metre => "m",
        };
        line("coordinate", format!("{coordinate:?}"));
        text.push_str(&match self.motor {
            Motor::Winding {
                resistance,
                inductance,
                torque_constant,
            } => format!(
                "\n[input]\nkind = \"voltage\"\ngain = 1.0\n\n[motor]\nresistance = {resistance:?}\n\
                 inductance = {inductance:?}\ntorque_constant = {torque_constant:?}\n"
            ),
            Motor::Direct { gain } => {
                format!("\n[input]\nkind = \"torque\"\ngain = {gain:?}\n")
            }
        });
        let mut line = |key: &str, value: f64| {
            writeln!(text, "{key} = {value:?}").expect("a String takes any text");
        };
        line("\n[mechanics]\ninertia", self.inertia);
        line("viscous", self.viscous);
        if let Some(spring) = self.spring {
            line("spring", spring.stiffness);
            line("spring_rest", spring.rest);
            line("spring_preload", spring.preload);
        }
        if let Some(stops) = self.stops {
            line("lower_stop", stops.lower);
            line("upper_stop", stops.upper);
        }
        line("\n[friction]\ncoulomb", self.coulomb);
        line("static", self.static_friction);
        if self.resolution > 0.0 {
            line("\n[sensor]\nresolution", self.resolution);
        }
        text.push_str(
            "\n[fit]\nparameters = [\"inertia\", \"viscous\", \"coulomb\", \"static\"]\n",
        );
        text
    }
}
