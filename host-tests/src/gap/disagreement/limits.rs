//! Every constant that decides whether a log and a machine file belong together, each with its reason.
//!
//! The rates that follow from them are those of `cargo test --release --test tracing disagreement:: -- --ignored
//! --nocapture`, over rigs with every effect, numbers of `[fit]` off by up to three, and every error of
//! units and signs.

/// How far a number in `[fit]` may be off, as a factor either way, before it counts at all: the contract
/// promises an answer that does not depend on it within three. Where the file says how far it may be off, that, or
/// [`STATED_FACTOR`] if it is more.
pub const FITTED_FACTOR: f64 = 3.0;

/// The same for a number that `[fit]` leaves out: a data sheet's tolerance of 10 to 20 %, and as much again
/// for a winding that is hot and a magnet that is weak.
pub const STATED_FACTOR: f64 = 1.5;

/// How far a data sheet's number is off at most, as a factor either way, where another explanation of it is at hand
/// and the machine file does not say how far it may be off.
pub const SHEET: f64 = 1.2;

/// How far the smallest step of the position may be from the declared resolution, as a factor either way: both are
/// known exactly, but the resolution is often written with a digit or two.
pub const SAME_STEP: f64 = 1.1;

/// How near two factors are, as a share, to be one: that of a unit and that between two steps, say.
pub const SAME_FACTOR: f64 = 0.02;

/// Standard deviation of the logarithm of a number in `[fit]` beyond that factor: a number that was
/// guessed is as likely off by two as not. Where the file says how far it may be off, that, or [`STATED_DEVIATION`] if it is more.
pub const FITTED_DEVIATION: f64 = std::f64::consts::LN_2;

/// The same for a number that `[fit]` leaves out: the upper end of a data sheet's 10 to 20 %.
pub const STATED_DEVIATION: f64 = 0.2;

/// Share of the effective torque (or voltage) that an effect which is missing may take or add, so that
/// contributions below it say nothing about a number. The strongest of the rigs' nominal effects, a
/// supply's sag, takes a third at the top of its range, the others a tenth to a fifth.
pub const FLOOR: f64 = 0.2;

/// Standard errors either side of a coefficient: three, for errors that are taken from the residual's
/// first autocorrelation alone.
pub const STANDARD_ERRORS: f64 = 3.0;

/// What the declared reading costs, in nats, from which on it is not believed: e⁷, a thousand to one. Of
/// 1216 logs that do belong to their machine (seeds from 8,400,000 on, every seventh; from 8,500,001 on,
/// every fifth) none cost 4.
pub const IMPLAUSIBLE: f64 = 7.0;

/// What another reading has to save, in nats, to be named: e⁵, the usual "very strong" (Kass and Raftery,
/// "Bayes factors", 1995).
pub const CLEARLY_BETTER: f64 = 5.0;

/// Share of the declared reading's cost that another one has to save: one that leaves most of the
/// contradiction is no explanation of it.
pub const LEAST_SAVING: f64 = 0.5;

/// Readings whose costs are within this, in nats, are named together: e¹ to one is no evidence.
pub const ALIKE: f64 = 1.0;

/// Factor beyond its tolerance from which on a number is named although no unit explains it: with
/// [`FITTED_FACTOR`] thirty, the middle between right and off by a thousand, the smallest of the prefixes.
pub const FAR_OFF: f64 = 10.0;

/// Share of the acceleration's energy that the sensor's noise may have for the acceleration to be used:
/// it biases the coefficient by as much.
pub const MOST_NOISE: f64 = 0.1;

/// Averages of so many samples: corners at a tenth, a thirtieth … of the sampling rate, three to a decade,
/// down to where a log of a few seconds at 1 kHz has [`LEAST_ROWS`] left.
pub const AVERAGES: [usize; 4] = [1, 3, 10, 30];

/// Fewest rows of a balance: four for each of up to nine unknowns, and as many for their errors.
pub const LEAST_ROWS: usize = 60;

/// Rows that a balance has at most; more of them say nothing new after the filter's low pass.
pub const MOST_ROWS: usize = 6000;

/// Share of the effective speed below which the direction is in doubt: breakaway, reversal, rest.
pub const SLOW: f64 = 0.05;

/// Strokes beyond a declared stop from which on a position is in another unit, not at a worn stop.
pub const BEYOND_STOPS: f64 = 0.5;

/// Share of samples beyond the stops, or beyond every supply, that may be glitches.
pub const GLITCHES: f64 = 1e-3;

/// Cost of positions beyond the stops or of jumps by a turn, nats: what physics forbids is worth more than
/// any number, and is decided by itself.
pub const IMPOSSIBLE: f64 = 3.0 * IMPLAUSIBLE;

/// Most that the sensor's smallest step or the command may cost, nats: they choose among readings, and
/// decide nothing by themselves (below [`IMPLAUSIBLE`] together).
pub const HINT: f64 = 3.0;

/// Most that a number may cost that is off by less than [`FAR_OFF`] beyond its tolerance while `[fit]`
/// names it, or that declares a spring or a weight: such a guess was bad, and is no unit.
pub const BAD_GUESS: f64 = IMPLAUSIBLE / 4.0;

/// Largest factor by which a number is off for its unit: g·mm² for kg·m², and [`FAR_OFF`] for a bad guess.
pub const LARGEST_UNIT: f64 = 1e10;

/// Share of the rows that have to be of either direction of motion for friction to be told from a constant, or of either direction of
/// the drive for the sign of its current to be seen.
pub const BOTH_WAYS: f64 = 0.1;

/// Least ratio of the mean currents that a motor draws where it is driven one way and the other, both of one sign, for the current to
/// have no sign: a sensor's offset adds to the one what it takes from the other, so that it makes 1/2 only where it is three times
/// the current itself.
pub const UNSIGNED: f64 = 0.5;

/// Share of the best band's squared partial correlation from which on another band is heard too: an effect
/// that is missing shows in one band more than in another.
pub const HEARD: f64 = 0.3;

/// Longest sampling period, s: no drive shows what it does in fewer samples. Milliseconds taken for
/// seconds are longer.
pub const LONGEST_PERIOD: f64 = 0.1;

/// Shortest credible sampling period, s: a megahertz. Logs in kiloseconds are shorter.
pub const SHORTEST_PERIOD: f64 = 1e-6;

/// Largest step from one sample to the next that is motion, as a share of the largest jump that is a wrap.
pub const STEP_OF_A_WRAP: f64 = 0.3;

/// How far the measured velocity may be from the position's derivative, as a factor: a lag of the filter
/// behind it, or a sensor that is not calibrated.
pub const EXACT_FACTOR: f64 = 1.2;

/// Standard deviation of the logarithm of that beyond the factor: an identity has no more than a sensor's
/// tolerance.
pub const EXACT_DEVIATION: f64 = 0.1;

/// How far the stroke may be from the commanded one, as a factor: a soft loop.
pub const COMMAND_FACTOR: f64 = 2.0;

/// How far a winding's inductance may be off, as a factor: it is smaller at the frequency of the bridge, and
/// data sheets give it at 1 kHz, or between two phases.
pub const INDUCTANCE_FACTOR: f64 = 3.0;

/// Longest time constant L/R of a brushed DC winding, s: catalogues have 0.05 to 20 ms for motors of watts to
/// kilowatts; an inductance in mH taken for H is beyond.
pub const LONGEST_WINDING: f64 = 0.1;

/// Shortest sampling period, s, that may be a number of milliseconds: that of 50 kHz.
pub const SHORTEST_AS_MILLISECONDS: f64 = 0.02;

/// Corrections that are tried one on top of another: a log may have more than one column in another unit.
pub const MOST_CORRECTIONS: usize = 3;

/// Sets of corrections that are kept to be tried with one more. Of 396 pairs of errors both were named in 341 with 8 and in
/// 357 with 16, which takes 1.4 times as long (`SEED=9000001 cargo test --release --test tracing
/// disagreement::rates_of_pairs -- --ignored --nocapture`, when it was chosen).
pub const KEPT: usize = 16;

/// Samples that a period of the motion has to have: below that many the torque balance, with its corner at
/// a tenth of the sampling rate, has lost most of the motion, and a hold of the input is no small part of it.
pub const SAMPLES_A_PERIOD: f64 = 8.0;

/// Standard deviation of the logarithm of a voltage beyond the largest usual supply: the rectified mains, 4.5 times as much, costs
/// [`CLEARLY_BETTER`] and is still believed, per cent that were taken for a share of 24 V are not.
pub const SUPPLY_DEVIATION: f64 = 0.5;
