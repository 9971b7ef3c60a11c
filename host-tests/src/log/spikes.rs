//! Positions that are damaged for a few samples.

use std::iter::once;
use std::ops::Range;

/// How many times as far from the mean of its neighbours as all others a position has to be, to be a damaged sample: one
/// that oscillates is as far in every sample, and noise of a Gaussian sensor goes beyond five deviations once in a
/// million.
pub(super) const SPIKE: f64 = 10.0;

/// Most spikes that a log is looked through for; where more jump, that is how it moves.
pub(super) const MOST_SPIKES: usize = 10;

/// How many times as large as all others a few samples have to be, to be damaged: a converter of ten bits has no smaller step than a
/// thousandth of its range, so that all the others would be none.
pub(super) const RANGE: f64 = 1000.0;

/// Most samples of one spike. Through a jump that stays a straight line over `n` samples bends by 1/(n + 1) of it at either
/// end: over three by a quarter, more than [`SPIKE_LEFT`].
const LONGEST: usize = 3;

/// How far positions may be from the mean of their neighbours once damaged ones lie on a straight line, as a share of how far
/// these were: less than a jump that stays leaves, and no less than what motion, a tenth of it at most ([`SPIKE`]), makes in
/// two samples.
const SPIKE_LEFT: f64 = 0.2;

/// How far each position but the first and the last one is from the mean of its neighbours, from the second on.
fn bends(position: &[f64]) -> impl Iterator<Item = f64> {
    let threes = position.windows(3);
    threes.map(|three| three[1] - 0.5 * (three[0] + three[2]))
}

/// The rows of positions that jump there and back, few of them; or the first or the last row, if it jumps alone.
///
/// They are told by their distance from the mean of their neighbours, which a machine's acceleration alone makes, however
/// fast it moves: many times as large as every other one, and gone once a straight line is drawn in their place.
pub(super) fn spikes(position: &[f64]) -> Vec<Range<usize>> {
    let bends: Vec<f64> = bends(position).collect();
    let mut sizes: Vec<f64> = bends.iter().map(|bend| bend.abs()).collect();
    // So many bends does one spike make at most.
    let most = (LONGEST + 2) * MOST_SPIKES;
    if sizes.len() <= most {
        return Vec::new();
    }
    let (_, usual, _) = sizes.select_nth_unstable_by(most, |a, b| b.total_cmp(a));
    // At rest nothing but the last digit changes, seldom: no jump of that is one.
    let digit = (position.windows(2).map(|pair| (pair[1] - pair[0]).abs()))
        .filter(|size| *size > 0.0)
        .fold(f64::INFINITY, f64::min);
    let limit = SPIKE * usual.max(digit);
    let large: Vec<usize> = (0..bends.len())
        .filter(|&at| bends[at].abs() > limit)
        .collect();
    let last = position.len() - 1;
    // A machine that starts with a kick goes on with it.
    let is_alone = |at: usize, beside: usize| bends[beside].abs() <= SPIKE_LEFT * bends[at].abs();
    match large[..] {
        [0] if is_alone(0, 1) => return once(0..1).collect(),
        [at] if at + 1 == bends.len() && is_alone(at, at - 1) => {
            return once(last..last + 1).collect();
        }
        _ => (),
    }
    let mut found = Vec::new();
    for cluster in large.chunk_by(|one, next| next - one <= LONGEST) {
        let (Some(&first), Some(&end)) = (cluster.first(), cluster.last()) else {
            continue;
        };
        // A bend is that of the position one behind its own place.
        let starts = first + 1..=end + 1;
        let lengths = 1..=LONGEST;
        let mut runs = lengths.flat_map(|length| starts.clone().map(move |row| row..row + length));
        match runs.find(|run| run.end <= last && is_mended(position, &bends, run)) {
            Some(run) => found.push(run),
            // A jump that stays is an angle that wraps, or a gap: others know better what to say of it.
            None if stays(&bends[first..=end]) => return Vec::new(),
            None => {}
        }
    }
    found
}

/// Whether what is around these rows bends hardly any more once they are straight.
fn is_mended(position: &[f64], bends: &[f64], rows: &Range<usize>) -> bool {
    let around =
        rows.start.saturating_sub(LONGEST + 2)..(rows.end + LONGEST + 2).min(position.len());
    let largest = bends[around.start..around.end - 2]
        .iter()
        .fold(0.0_f64, |most, bend| most.max(bend.abs()));
    let mut straight = position[around.clone()].to_vec();
    let rows = rows.start - around.start..rows.end - around.start;
    straighten(&mut straight, &rows, None);
    self::bends(&straight).all(|bend| bend.abs() <= SPIKE_LEFT * largest)
}

/// Whether the position jumps once there, to where it stays.
fn stays(bends: &[f64]) -> bool {
    let pairs = bends.windows(2);
    let mut jumps = pairs.map(|pair| (pair[0] + pair[1]).abs() <= SPIKE_LEFT * pair[0].abs());
    jumps.any(|jump| jump)
}

/// Draws a straight line through these rows, in whole steps of the sensor where it has such. The first row and the last one of
/// a log have no second neighbour, and stay.
pub(super) fn straighten(position: &mut [f64], rows: &Range<usize>, step: Option<f64>) {
    if rows.start == 0 || rows.end == position.len() {
        return;
    }
    let (before, after) = (position[rows.start - 1], position[rows.end]);
    let count = (rows.len() + 1) as f64;
    for (place, row) in rows.clone().enumerate() {
        let part = (after - before) * (place + 1) as f64 / count;
        position[row] = before + step.map_or(part, |step| step * (part / step).round());
    }
}

/// What is said of these rows, and what becomes of them.
pub(super) fn said_of(rows: &Range<usize>, position: &[f64]) -> String {
    let nowhere = "and nowhere else does it bend nearly as much";
    let damaged = position[rows.start];
    if rows.start == 0 || rows.end == position.len() {
        let beside = if rows.start == 0 { 1 } else { rows.start - 1 };
        let beside = position[beside];
        return format!(
            "`position` is {damaged:?} in this sample alone, {beside:?} beside it, {nowhere}: remove the row"
        );
    }
    let (before, after) = (position[rows.start - 1], position[rows.end]);
    match rows.len() {
        1 => format!(
            "`position` is {damaged:?} in this sample alone, {before:?} before and {after:?} after it, {nowhere}: the mean of \
             its neighbours is taken in its place"
        ),
        count => format!(
            "`position` jumps to {damaged:?} for {count} samples, {before:?} before and {after:?} after them, {nowhere}: a \
             straight line is taken in their place"
        ),
    }
}
