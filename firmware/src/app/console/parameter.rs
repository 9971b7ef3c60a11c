//! A parameter, as the console shows it and lets it be set.

/// Name, unit and bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Description {
    /// Its name, as in a machine file where that has it.
    pub name: &'static str,
    /// Its SI unit, for an angle as coordinate.
    pub unit: &'static str,
    /// Smallest value that is taken.
    pub lower: f32,
    /// Largest value that is taken.
    pub upper: f32,
}
