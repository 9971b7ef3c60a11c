//! Armed or disarmed, as types: what may only be done disarmed asks for a [`Disarmed`].
//!
//! Whoever holds one holds the drive's switch too, off, and can arm the drive only by giving the
//! [`Disarmed`] up. So the drive stays disarmed for as long as somebody borrows it, for instance
//! while flash is erased, when the processor stands still.
//!
//! ```
//! use firmware::app::arming::{Disarmed, Switch};
//!
//! #[derive(Default)]
//! struct Enable(bool);
//!
//! impl Switch for Enable {
//!     type Refusal = core::convert::Infallible;
//!     fn on(&mut self) -> Result<(), Self::Refusal> {
//!         self.0 = true;
//!         Ok(())
//!     }
//!     fn off(&mut self) {
//!         self.0 = false;
//!     }
//! }
//!
//! let disarmed = Disarmed::new(Enable::default());
//! let Ok(armed) = disarmed.arm();
//! assert!(armed.switch().0);
//! let disarmed = armed.disarm();
//! assert!(!disarmed.switch().0);
//! ```

/// What arms a drive.
pub trait Switch {
    /// Why it does not.
    type Refusal;

    /// From now on the drive may move its load.
    ///
    /// # Errors
    /// It stays off, for instance because a fault is latched.
    fn on(&mut self) -> Result<(), Self::Refusal>;

    /// From now on it may not. Always comes to pass.
    fn off(&mut self);
}

/// A drive that cannot move its load.
#[derive(Debug)]
pub struct Disarmed<S>(S);

/// A drive that may.
#[derive(Debug)]
pub struct Armed<S>(S);

impl<S: Switch> Disarmed<S> {
    /// Takes the switch and turns it off.
    pub fn new(mut switch: S) -> Self {
        switch.off();
        Self(switch)
    }

    /// Arms the drive. This is only possible while nobody borrows the token:
    ///
    /// ```compile_fail,E0505
    /// use firmware::app::arming::{Disarmed, Switch};
    ///
    /// fn meanwhile<S: Switch>(disarmed: Disarmed<S>, erase: impl FnOnce(&Disarmed<S>)) {
    ///     let permit = &disarmed;
    ///     let armed = disarmed.arm();
    ///     erase(permit);
    /// }
    /// ```
    ///
    /// # Errors
    /// The switch refuses, and the drive stays disarmed.
    pub fn arm(mut self) -> Result<Armed<S>, Refused<S>> {
        match self.0.on() {
            Ok(()) => Ok(Armed(self.0)),
            Err(reason) => Err(Refused {
                disarmed: Self::new(self.0),
                reason,
            }),
        }
    }

    /// What would arm it.
    pub fn switch(&self) -> &S {
        &self.0
    }
}

impl<S: Switch> Armed<S> {
    /// Disarms the drive.
    pub fn disarm(self) -> Disarmed<S> {
        Disarmed::new(self.0)
    }

    /// What disarms it.
    pub fn switch(&self) -> &S {
        &self.0
    }
}

/// A drive that was not armed.
#[derive(Debug)]
pub struct Refused<S: Switch> {
    /// The drive as it was before.
    pub disarmed: Disarmed<S>,
    /// Why.
    pub reason: S::Refusal,
}
