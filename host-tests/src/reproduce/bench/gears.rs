//! Two spur gears at a centre distance that is not their own: the play between their teeth.

/// A pair of spur gears with involute teeth, without play at its reference centre distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GearPair {
    /// Pitch diameter over number of teeth, m.
    pub module: f64,
    /// Teeth of the gear at whose axis angles are counted.
    pub teeth: f64,
    /// Teeth of the other gear.
    pub other_teeth: f64,
    /// Pressure angle, rad.
    pub pressure_angle: f64,
}

impl GearPair {
    /// Pitch radius, m.
    pub fn pitch_radius(&self) -> f64 {
        0.5 * self.module * self.teeth
    }

    /// Centre distance without play, m.
    pub fn reference_distance(&self) -> f64 {
        0.5 * self.module * (self.teeth + self.other_teeth)
    }

    /// Angle that the gear can turn in, the other held, by the paper's line (ch. 2.1.6, 6.2):
    /// j_θ = 2 Δa tan α / r, rad, from one flank to the other. The first term of
    /// [`Self::involute_play`] in Δa.
    pub fn linear_play(&self, distance: f64) -> f64 {
        let growth = distance - self.reference_distance();
        2.0 * growth * self.pressure_angle.tan() / self.pitch_radius()
    }

    /// The same by the involute itself: j_θ = 2 (1 + z₂/z₁)(inv α′ − inv α) with
    /// a′ cos α′ = a cos α and inv φ = tan φ − φ, rad (the geometry of ISO 21771). Exact while teeth
    /// are in mesh, for a distance from the reference up.
    pub fn involute_play(&self, distance: f64) -> f64 {
        let involute = |angle: f64| angle.tan() - angle;
        let cosine = self.reference_distance() / distance * self.pressure_angle.cos();
        let opened = involute(cosine.acos()) - involute(self.pressure_angle);
        2.0 * (1.0 + self.other_teeth / self.teeth) * opened
    }
}
