//! What drive, PLC and load cell logged.

/// One value a row in each column.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// Since the first row, s.
    pub time: Vec<f64>,
    /// Position asked for, rad at the slow shaft; held from one period of the position loop to the
    /// next.
    pub command: Vec<f64>,
    /// What the encoder reported, rad at the slow shaft.
    pub encoder_position: Vec<f64>,
    /// What the motor's own encoder reported, scaled to the slow shaft, rad.
    pub motor_position: Vec<f64>,
    /// As the drive reports it, rad/s at the *motor* shaft.
    pub motor_velocity: Vec<f64>,
    /// Measured i_q, A rms (torque = torque constant · i_q), filtered as the drive filters its log.
    pub current_q: Vec<f64>,
    /// Of the load cell, N, positive while the brake holds against a positive motion.
    pub load_cell_force: Vec<f64>,
    /// Motor torque as it was, N·m. Not in the log.
    pub true_torque: Vec<f64>,
    /// Speed of the motor shaft as it was, rad/s. Not in the log.
    pub true_velocity: Vec<f64>,
}

impl Recording {
    /// Motor position less encoder position, rad at the slow shaft.
    pub fn residual(&self) -> Vec<f64> {
        self.motor_position
            .iter()
            .zip(&self.encoder_position)
            .map(|(motor, encoder)| motor - encoder)
            .collect()
    }

    /// Algorithm 1 (section 5.2): mean of the residual's greatest and least value, by magnitude, rad.
    pub fn backlash_reading(&self) -> f64 {
        let (least, greatest) = self
            .residual()
            .into_iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), r| {
                (low.min(r), high.max(r))
            });
        0.5 * (least.abs() + greatest.abs())
    }
}
