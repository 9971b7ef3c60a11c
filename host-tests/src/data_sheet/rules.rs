//! What is presumed where a data sheet says nothing, and how far its numbers may differ.
//!
//! The ranges are those of the data sheets in `host-tests/machines/motors`.

/// What makers allow the constants of a motor: resistance and torque constant ±10 % (Faulhaber: ±10 to 12 %;
/// Quanser prints ±12 % for both of the SRV02).
pub(super) const MAKERS_TOLERANCE: f64 = 0.1;

/// No-load current over stall current where neither it nor a friction is given. Bare motors of these data
/// sheets have 0.2 to 3 %, gearmotors and servos 4 to 16 %.
pub(super) const NO_LOAD_SHARE: f64 = 0.03;

/// As [`NO_LOAD_SHARE`], with a gear.
pub(super) const GEARED_NO_LOAD_SHARE: f64 = 0.05;

/// The middle of the shares of the stall current that gearmotors and servos draw without a load: 8 %, the geometric mean of 4
/// and 16 %. Where a bare motor draws less, a gear that nobody has measured is guessed to rub so much more.
pub(super) const GEARMOTORS_NO_LOAD_SHARE: f64 = 0.08;

/// By how much a guessed friction may be off, as a factor.
pub(super) const FRICTION_FACTOR: f64 = 4.0;

/// Mechanical time constant where nothing gives the rotor's inertia, s. Data sheets of small brushed motors
/// have 3 to 20 ms, those with iron in the rotor the longer ones.
pub(super) const TIME_CONSTANT: f64 = 0.01;

/// By how much a guessed inertia may be off, as a factor.
pub(super) const INERTIA_FACTOR: f64 = 3.0;

/// Part of the friction without a load that is taken for viscous where nothing tells the two: brushes and
/// bearings mostly rub.
pub(super) const VISCOUS_PART: f64 = 0.25;

/// Breakaway over sliding friction where nothing gives it: dry friction has 1 to 1.5.
pub(super) const BREAKAWAY_RATIO: f64 = 1.2;

/// Least efficiency that the numbers of a gear may come to: below it a number has the wrong side or unit. One that is off by
/// ten makes a tenth of a gear without loss, and what makers allow the numbers beside it; self-locking worms and screws
/// pass on a fifth, the gears of the data sheets 45 % and more.
pub(super) const LEAST_EFFICIENCY: f64 = 0.15;
