//! Energy of a world's plant, and the shortest times in which anything happens in it.

use super::forces::{CURRENT, Forces, LOAD, MOTOR, Rates};
use super::laws::Law;
use super::machine::InputKind;
use super::shapes::Along;

impl Forces {
    /// Kinetic energy, and that of springs, joint and magnetic field, J.
    pub fn energy(&self, values: &Rates) -> f64 {
        let machine = &self.machine;
        let mut sum = 0.5 * machine.inductance * values[CURRENT].powi(2);
        for side in 0..self.masses() {
            let (inertia, _) = self.inertia(side, values[2 * side]);
            sum += 0.5 * inertia * values[2 * side + 1].powi(2);
        }
        let position = values[2 * self.output()];
        sum += 0.5 * machine.spring * (position - machine.spring_rest).powi(2);
        sum -= machine.gravity * (position - machine.gravity_rest).cos();
        if let Some((joint, width)) = self.joint {
            let twist = (values[MOTOR] - values[LOAD]).abs();
            sum += 0.5 * joint.stiffness * (twist - 0.5 * width).max(0.0).powi(2);
        }
        sum
    }

    /// Longest step that resolves everything that happens, s.
    pub fn longest_step(&self) -> f64 {
        let machine = &self.machine;
        let speed = 1.5 * machine.speed();
        let mut step = 0.05 * machine.inertia / machine.damping().max(1e-300);
        step = step.min(machine.cycle / 400.0);
        if machine.input == InputKind::Voltage {
            step = step.min(0.4 * machine.inductance / machine.resistance);
        }
        for law in &self.laws {
            step = step.min(match *law {
                Law::Cogging { ripple, .. }
                | Law::PositionDependentFriction {
                    along: Along::Added(ripple) | Along::Multiplied(ripple),
                    ..
                } => {
                    ripple.period
                        / (if ripple.harmonics == [0.0; 2] {
                            20.0
                        } else {
                            50.0
                        } * speed)
                }
                Law::RoughSpot { width, .. } => 0.1 * width / speed,
                Law::Hysteresis { reach, .. } => 0.1 * reach / speed,
                Law::Stribeck { speed, .. } => {
                    0.2 * speed * machine.inertia / (2.0 * machine.coulomb + 0.2 * machine.torque)
                }
                Law::BrushDrop { volts, knee } | Law::DeadTime { volts, knee } => {
                    0.5 * machine.inductance / (machine.resistance + volts / knee)
                }
                Law::SupplySag { lag, .. } if lag > 0.0 => 0.2 * lag,
                Law::Presliding {
                    stiffness, damping, ..
                } => {
                    let swing = 0.2 * (machine.inertia / stiffness).sqrt();
                    let slide = 0.5 * machine.coulomb / (stiffness * speed);
                    let damp = machine.inertia / damping.max(1e-300);
                    swing.min(slide).min(damp)
                }
                Law::Backlash { joint, .. } | Law::Compliance(joint) => {
                    let both = machine.inertia * joint.inertia * (1.0 - joint.inertia);
                    let swing = 0.15 * (both / joint.stiffness).sqrt();
                    swing.min(0.5 * both / joint.damping.max(1e-300))
                }
                _ => f64::INFINITY,
            });
        }
        step
    }
}
