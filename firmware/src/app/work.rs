//! What a board's two interrupts run, whatever it is: an actuator with its loop, or a throttle body
//! with its engine controller.

/// Work of the plant interrupt.
pub trait PlantWork: Send {
    /// One plant period. True if a control step is due: it has until the next tick.
    #[must_use]
    fn tick(&mut self) -> bool;
}

/// Work of the control interrupt.
pub trait ControlWork: Send {
    /// One control step.
    fn step(&mut self);
}
