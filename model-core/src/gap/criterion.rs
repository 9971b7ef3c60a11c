//! The numbers that the tracing decides by, in one place.
//!
//! Each says what it is, and from what it is derived. Where no derivation is given it is a choice; what the choices come
//! to on machines drawn at random is in `docs/evaluation.md`. Lengths of windows, sizes of buffers and the effort of fits
//! stand with what they belong to.

// What is known before a log is looked at.

/// Weight of a declared value, in squared residuals a squared scale: nothing beside a log that determines the number, and
/// what holds one that it does not. So is that of zero for the points of a learned map, some of which the log hardly visits.
pub const DECLARED_WEIGHT: f64 = 3.0;

/// How far a current's sensor errs in its gain: what a shunt and its amplifier are off by in a cheap drive.
/// [`DECLARED_WEIGHT`] is one over the variance of what lies anywhere within such a scale.
pub const SENSOR_GAIN: f32 = 0.05;

/// The same of its offset, as a share of the current's rms.
pub const SENSOR_OFFSET: f32 = 0.03;

/// Most scales that a fit moves a number of the current's sensor by: beyond that its unit is wrong, not its sensor.
pub const SENSOR_REACH: f32 = 4.0;

/// Shares of the scales of a current's sensor within which it is a good one: 1 % of gain, 0.6 % of offset, a fifth of a
/// sample. A shunt with its amplifier comes no nearer.
pub const GOOD_SENSOR: f64 = 0.2;

/// Share of a declared number from which on a fitted one makes it wrong: finer than a data sheet.
pub const LEAST_OFF: f32 = 0.02;

/// A number of the base that is fitted to more than this multiple of what is declared, or to less than this part of it,
/// is taken to be biased by what the model lacks.
pub const BIASED: f32 = 2.0;

/// By what factor a number that is fitted may be off where nobody says so, a standard deviation of its logarithm.
pub const UNSURE: f32 = 2.0;

/// Multiple of a declared number, or part of it, that no fit is left beyond, however unsure the number is: just within the
/// fifty that a fit is bounded to, so that a number which stops there is not taken for found.
pub const FARTHEST: f32 = 45.0;

// What a sensor leaves of any model.

/// Counts of the sensor that are added to every held-out position error: below that an error is the
/// sensor's, and on a motion that repeats it repeats in every block.
pub const FLOOR_COUNTS: f32 = 2.0;

/// The same where no resolution is declared, as a share of the stroke: finer than any encoder in the field.
pub const FLOOR_STROKE: f32 = 1e-5;

/// The same of the current, as a share of its rms: finer than any shunt in the field.
pub const FLOOR_CURRENT: f32 = 1e-3;

/// A reading error or a play under so many counts of the sensor is its rounding, which repeats with the
/// motion.
pub const LEAST_COUNTS: f32 = 0.5;

/// A windowed error beyond so many counts of the sensor is not the sensor's.
pub const SENSOR_COUNTS: f64 = 3.0;

/// A windowed error beyond so many counts of the sensor, and beyond [`STRUCTURED_STROKE`], is too large for what is
/// linear in an effect to say much of it.
pub const STRUCTURED_COUNTS: f64 = 10.0;

/// Share of the stroke that goes with [`STRUCTURED_COUNTS`].
pub const STRUCTURED_STROKE: f64 = 0.003;

/// Multiple of the least error beyond which an error has a cause.
pub const UNEXPLAINED: f64 = 3.0;

// The test on held-out blocks.

/// Length of a held-out block, s.
pub const BLOCK: f32 = 0.5;

/// Blocks that a log is cut into at least, if it has that many windows: where the machine rests in three fifths of them
/// as many as [`FEW_BLOCKS`] still say something. With half as many ten would, of which all have to gain for a p of 2⁻¹⁰.
pub const LEAST_BLOCKS: usize = 48;

/// Windows under which a log is cut into shorter ones, one in each block: of 24 the four that differ least may lose, and
/// the signed-rank p of 43/2²⁴ is still below what [`FEW_BLOCKS`] speaks of.
pub const FEW_WINDOWS: usize = 24;

/// Blocks under which ranks alone may prove nothing: though all of n gain, the signed-rank p is 2⁻ⁿ, and of
/// an effect that is tried at 128 periods, as all others are looked at too, 3.4e-6 is asked.
pub const FEW_BLOCKS: usize = 19;

/// Error of the whole test, shared among the candidates of a round and, for each, among the shapes
/// that were tried for it.
pub const SIGNIFICANCE: f64 = 0.01;

/// Gain that is of no interest, as the logarithm of the mean square: one percent of the error. That much
/// is left to be explained where nothing is missing, by restarts and by rounding, and a test in enough
/// blocks finds it.
pub const NO_GAIN: f32 = 0.02;

/// Distance from [`NO_GAIN`], as a multiple of it, within which a block says nothing. The two models predict the same
/// there, as where the machine rests; that many blocks say so is not evidence against an effect which shows when it
/// moves. As much is left out on either side of what the test asks about, so that chance gains nothing by it. A block
/// in which nothing differs lies at 1, to rounding.
pub const UNLIKE: f32 = 1.25;

/// Least median over blocks of the logarithm of the two errors' ratio.
pub const LEAST_MEDIAN: f32 = 0.05;

/// Held-out mean square error that a larger model must fall below, as a share of the smaller one's.
pub const LARGEST_RATIO: f64 = 0.9;

/// Standard deviations that an effect's strength must be from zero: those of the 95 % interval that is reported, which is not to
/// contain nothing. That chance alone is not the cause, among all effects that were looked at, the held-out blocks have shown by then.
pub const LEAST_CERTAINTY: f64 = 1.96;

/// Standard deviations by which a number of one log must be apart from that of others. A two-sided test at [`SIGNIFICANCE`], shared
/// among the 20 to 28 numbers that a machine may have, asks for 3.48 to 3.57.
pub const LEAST_APART: f64 = 3.5;

// What is worth a refit.

/// A candidate, or a map, under this score is not refitted.
pub const LEAST_SCORE: f32 = 0.01;

/// A candidate under this identifiability is absorbed by the base.
pub const LEAST_IDENTIFIABILITY: f32 = 0.05;

/// Candidates refitted in a round for their scores.
pub const SHORTLIST: usize = 8;

/// A candidate, or a map, whose score is under this share of that of one that has passed is not refitted:
/// what the candidate explains is left for a later round.
pub const FAR_BEHIND: f32 = 0.1;

/// Effects that are presumed, one at a time, to look for another one beside it, where none is found alone: those that come nearest.
pub const PRESUMED: usize = 4;

/// Effects that are fitted beside each of those, by their scores there, to see which of them is worth a round.
pub const BESIDE: usize = 2;

/// A tried strength whose error, before anything is fitted to it, is beyond this multiple of what the
/// model has without is hopeless. Large, for a base that was fitted without it is biased by its absence.
pub const WORTH_A_FIT: f64 = 10.0;

/// A map whose error on the first half of the held-out blocks is beyond this multiple of what it must fall
/// below is not tested on the others.
pub const NEAR: f64 = 3.0;

/// Where the error is structured, only a map that leaves less than this share of it spares those far behind it
/// a refit.
pub const LEFT_BY_MAP: f64 = 0.1;

/// Maps that challenge effects that leave little: those that explain most of what is left without.
pub const MAPS_BESIDE_EFFECTS: usize = 3;

// What is told from what.

/// Candidates whose held-out errors are within this ratio of the best one's are equally good: the
/// one with the fewest parameters is taken.
pub const EQUALLY_GOOD: f64 = 1.1;

/// Cosine beyond which two effects are the same model and only one is refitted.
pub const IDENTICAL: f32 = 0.9995;

/// Cosine beyond which a log cannot tell two effects apart.
pub const EQUIVALENT: f32 = 0.9;

/// An effect whose held-out error is beyond this multiple of the accepted one's is told from it,
/// however alike the two sensitivities are. So is one from another law of what was found before it.
pub const TOLD_APART: f64 = 1.5;

/// An effect with a memory whose held-out error is within this ratio of the best one's may still be
/// the better one: the restarts were chosen for a model without it.
pub const CONTESTED: f64 = 3.0;

/// A map that brings the held-out error below this share of what the effects leave replaces them:
/// the catalogue's best guess is then not what the machine has.
pub const CLEARLY_BETTER: f64 = 0.5;

/// A fit of the whole log whose error falls to no less than this multiple of what the held-out one falls to has stopped
/// in a local minimum.
pub const LOCAL_MINIMUM: f64 = 2.0;

/// An effect with a memory that leaves no more than this share of the held-out error is judged on its own
/// restarts too before it is called not significant: a few windows that restart wrongly may outweigh all
/// others.
pub const LITTLE_LEFT: f64 = 0.3;

/// Effects that leave more than this share of the held-out error are challenged by learned maps, as
/// are those that leave an error beyond the sensor's and those that are the first terms of any law.
pub const POOR_EXPLANATION: f64 = 0.3;

/// Effects that leave less than this share of the held-out error, the product over the channels, do not stand
/// in for anything else. What they leave is no reason to look beyond the scores, however far beyond the
/// sensor's it is.
pub const NOTHING_LEFT: f64 = 1e-3;

/// Share of what a learned law takes off the held-out error that an effect has to take off, for the law to be another one of
/// that effect: more is explained by the effect's own law then than by what the learned one is otherwise.
pub const SAME_MECHANISM: f64 = 0.5;

/// Share of the windows from which on what acts in them acts always: what tells it from an effect
/// without edges is too little to be more than noise.
pub const MOST_FILLED: f32 = 0.9;
