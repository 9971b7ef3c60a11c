//! Modes that several actuators share, each worked out once.

use super::modes::{Basis, Modes};
use super::parameters::ParameterError;
use core::cell::OnceCell;

/// Room for the modes of `CAPACITY` different bases.
///
/// ```
/// use model_core::plant::mode_store::ModeStore;
/// use model_core::plant::{Directional, State, actuator::Actuator, modes::Basis};
/// use model_core::plant::parameters::{Drive, Parameters};
/// # let declared = Parameters {
/// #     viscous: Directional::both(2e-4),
/// #     coulomb: Directional::both(0.12),
/// #     breakaway: Directional::both(0.15),
/// #     ..Parameters::free(1.2e-4)
/// # };
/// let rough = Parameters { coulomb: Directional::both(0.14), ..declared };
/// let store = ModeStore::<1>::new();
/// let modes = |plant: &Parameters| store.modes(&Basis::new(plant, 1e-3));
/// for plant in [declared, rough] {
///     let sharing = Actuator::with_modes(&plant, modes(&plant)?)?;
///     let own = Actuator::build(&plant, 1e-3)?;
///     let (mut a, mut b) = (State::new(0.0, 0.1), State::new(0.0, 0.1));
///     sharing.step(&mut a, 0.2)?;
///     own.step(&mut b, 0.2)?;
///     assert_eq!(a, b);
/// }
/// let heavy = Parameters { inertia: 1.3e-4, ..declared };
/// assert!(modes(&heavy).is_err(), "the store is full");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct ModeStore<const CAPACITY: usize> {
    /// Filled from the front: each basis with its modes, which are worked out in their place.
    entries: [(OnceCell<Basis>, OnceCell<Modes>); CAPACITY],
}

impl<const CAPACITY: usize> ModeStore<CAPACITY> {
    /// An empty store.
    // Made where it is to stay: a call would make it on the stack and copy it.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            entries: core::array::from_fn(|_| (OnceCell::new(), OnceCell::new())),
        }
    }

    /// The modes of a basis; works them out the first time that they are asked for.
    ///
    /// # Errors
    /// As [`Modes::build`]; a new basis when the store is full.
    pub fn modes(&self, basis: &Basis) -> Result<&Modes, ParameterError> {
        basis.check()?;
        for (known, modes) in &self.entries {
            match (known.get(), modes.get()) {
                (Some(known), Some(modes)) if known == basis => return Ok(modes),
                (_, Some(_)) => {}
                (_, None) => {
                    let modes = modes.get_or_init(|| Modes::new(basis));
                    // Without its basis nobody asks for it again.
                    modes.check()?;
                    known.get_or_init(|| *basis);
                    return Ok(modes);
                }
            }
        }
        Err(ParameterError {
            parameter: "modes",
            requirement: "no more than there is room for",
        })
    }
}

impl<const CAPACITY: usize> Default for ModeStore<CAPACITY> {
    fn default() -> Self {
        Self::new()
    }
}
