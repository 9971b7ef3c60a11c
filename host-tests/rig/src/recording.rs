//! What the bench logged.

use crate::machine::Machine;
use std::fmt::Write;

/// One log, a row a sample, and beside it the truth that no sensor sees.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The machine that was recorded, as declared.
    pub machine: Machine,
    /// s.
    pub time: Vec<f64>,
    /// What the drive was told, held from its row to the next.
    pub input: Vec<f64>,
    /// What the sensor reported, rad or m.
    pub position: Vec<f64>,
    /// What was asked for, rad or m; empty for a prescribed input.
    pub command: Vec<f64>,
    /// Measured current, A; empty for a machine without a winding.
    pub current: Vec<f64>,
    /// Friction that a brake added, N·m or N; empty for a bench without a brake.
    pub brake: Vec<f64>,
    /// Where the machine was, rad or m: no delay, noise or quantisation. Not in the log.
    pub true_position: Vec<f64>,
    /// How fast it was, rad/s or m/s. Not in the log.
    pub true_velocity: Vec<f64>,
}

impl Recording {
    /// The log as `cargo hil gap` reads it: `time_s, input, position` and, where they exist,
    /// `command`, `current_a` and `brake`.
    pub fn to_csv(&self) -> String {
        let mut header = String::from("time_s,input,position");
        let mut columns = vec![&self.input, &self.position];
        let optional = [
            ("command", &self.command),
            ("current_a", &self.current),
            ("brake", &self.brake),
        ];
        for (name, column) in optional {
            if !column.is_empty() {
                header.push(',');
                header.push_str(name);
                columns.push(column);
            }
        }
        let mut text = header + "\n";
        for (row, time) in self.time.iter().enumerate() {
            write!(text, "{time:.9}").expect("a String takes any text");
            for column in &columns {
                write!(text, ",{:.9}", column[row]).expect("a String takes any text");
            }
            text.push('\n');
        }
        text
    }
}
