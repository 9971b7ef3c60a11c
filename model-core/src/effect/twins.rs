//! Effects that are one model in many motions.
//!
//! What a log tells of one, it hardly tells of the other: an offset torque and a Coulomb friction that
//! differs by direction in any motion, brushes and a dead time unless the motor generates while the bridge hardly drives, a
//! spring and a load that hangs over a small angle, a spring that hardly pulls and an offset torque, a load that hangs far from
//! where the machine moves, and a load that hangs and a cogging of one cycle a turn.

use super::{Active, Id};
use heapless::Vec;

/// Whether two effects are one model in every motion, so that no log tells them apart: an offset torque and a Coulomb friction that
/// differs by direction.
///
/// ```
/// use model_core::effect::{Id, twins::are_one_model};
/// assert!(are_one_model(Id::AsymmetricCoulomb, Id::OffsetTorque));
/// assert!(!are_one_model(Id::Spring, Id::OffsetTorque));
/// ```
pub fn are_one_model(one: Id, other: Id) -> bool {
    matches!(
        (one, other),
        (Id::OffsetTorque, Id::AsymmetricCoulomb) | (Id::AsymmetricCoulomb, Id::OffsetTorque)
    )
}

/// Whether two effects with these values are one law, so that no motion tells them apart: [`are_one_model`], or a load that hangs and
/// a cogging without overtones of one cycle a turn. `off`: by what share a fitted period may be off.
///
/// ```
/// use core::f32::consts::TAU;
/// use model_core::effect::{Active, Id, twins::are_one_law};
/// let load = Active::new(Id::Gravity, [0.25, 0.5]);
/// let cogging = |period| Active::new(Id::Cogging, [0.25, -0.5, period]);
/// assert!(are_one_law(&load, &cogging(TAU), 0.05) && are_one_law(&cogging(1.04 * TAU), &load, 0.05));
/// assert!(!are_one_law(&load, &cogging(TAU / 2.0), 0.05));
/// ```
pub fn are_one_law(one: &Active, other: &Active, off: f32) -> bool {
    let is_once_a_turn = |cogging: &Active| {
        let [_, _, period, ..] = cogging.values;
        let has_no_overtones = cogging.overtones().iter().all(|&it| it == 0.0);
        has_no_overtones && (period / core::f32::consts::TAU - 1.0).abs() <= off
    };
    match (one.id, other.id) {
        (Id::Gravity, Id::Cogging) => is_once_a_turn(other),
        (Id::Cogging, Id::Gravity) => is_once_a_turn(one),
        (one, other) => are_one_model(one, other),
    }
}

/// Most twins of one effect.
pub const MOST_TWINS: usize = 2;

/// The twins of an effect with the strengths that they have then.
///
/// ```
/// use model_core::effect::{Active, Id, twins::twins};
/// let spring = Active::new(Id::Spring, [0.5, 0.125]);
/// let offset = Active::new(Id::OffsetTorque, [0.125]);
/// assert_eq!(twins(&spring)[0], offset);
/// // What pushes forward is friction that is less forward.
/// let friction = Active::new(Id::AsymmetricCoulomb, [-0.125]);
/// assert_eq!(twins(&offset), [friction]);
/// // What ripples once a turn is a load that hangs.
/// let ripple = Active::new(Id::Cogging, [0.25, -0.5, core::f32::consts::TAU]);
/// let load = Active::new(Id::Gravity, [-0.25, 0.5]);
/// assert_eq!(twins(&ripple), [load]);
/// // What the bridge loses, the brushes may.
/// let (bridge, brushes) = (Active::new(Id::DeadTime, [0.5]), Active::new(Id::BrushDrop, [0.5]));
/// assert_eq!((&twins(&bridge)[..], &twins(&brushes)[..]), (&[brushes][..], &[bridge][..]));
/// ```
pub fn twins(effect: &Active) -> Vec<Active, MOST_TWINS> {
    let [first, second, ..] = effect.values;
    let active = |id, first: f32, second: f32| Active::new(id, [first, second]);
    match effect.id {
        Id::OffsetTorque => Vec::from_iter([active(Id::AsymmetricCoulomb, -first, 0.0)]),
        Id::AsymmetricCoulomb => Vec::from_iter([active(Id::OffsetTorque, -first, 0.0)]),
        Id::Spring => Vec::from_iter([
            active(Id::OffsetTorque, second, 0.0),
            active(Id::Gravity, first, -second),
        ]),
        Id::Gravity => Vec::from_iter([
            active(Id::OffsetTorque, -second, 0.0),
            active(Id::Spring, first.max(0.0), -second),
        ]),
        Id::Cogging => Vec::from_iter([active(Id::Gravity, -first, -second)]),
        Id::DeadTime => Vec::from_iter([active(Id::BrushDrop, first, 0.0)]),
        Id::BrushDrop => Vec::from_iter([active(Id::DeadTime, first, 0.0)]),
        _ => Vec::new(),
    }
}
