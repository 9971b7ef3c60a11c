//! A straight line through points of which some belong to something else: RANSAC.
//!
//! Fischler and Bolles, *Random Sample Consensus*, Comm. ACM 24, 1981; the scale of the residuals as in
//! Rousseeuw and Leroy, *Robust Regression and Outlier Detection*, Wiley 1987.

use crate::numeric::random::Random;
use crate::numeric::statistics::median;

/// The inlier rule: a residual of at most this many robust standard deviations. Of normal residuals
/// it takes 98.8 %.
pub const INLIER_LIMIT: f32 = 2.5;

/// Standard deviation of a normal variable that is cut off at [`INLIER_LIMIT`], over that of the whole.
const TRUNCATED: f64 = 0.954_6;

/// Rounds after RANSAC in which the inliers' own standard deviation takes and drops points.
const ROUNDS: usize = 8;

/// Standard deviation of a normal variable over the median of its magnitude.
const NORMAL_CONSISTENCY: f32 = 1.482_6;

/// A point; which group of dependent points it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Abscissa.
    pub x: f32,
    /// Ordinate.
    pub y: f32,
    /// Points of one group (a stretch of motion) share what disturbs them; points of different
    /// groups do not.
    pub group: u16,
}

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Probability with which at least one of the drawn pairs consists of inliers.
    pub confidence: f64,
    /// Least share of inliers that is counted on. The robust standard deviation needs a half.
    pub inlier_share: f64,
    /// Standard deviation of the ordinate that is there at least: the sensor's. Residuals below it
    /// exclude nothing.
    pub least_deviation: f32,
    /// Seed of the draws.
    pub seed: u64,
}

impl Settings {
    /// Pairs to draw: ln(1 − confidence)/ln(1 − share²), at least one and at most 10 000.
    fn draws(&self) -> u32 {
        let all_miss = libm::log(1.0 - self.inlier_share * self.inlier_share);
        let draws = libm::ceil(libm::log(1.0 - self.confidence) / all_miss);
        draws.clamp(1.0, 10_000.0) as u32
    }
}

/// A least-squares line on the inliers: y = level + slope (x − centre), in which level and slope are
/// uncorrelated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Mean abscissa of the inliers.
    pub centre: f64,
    /// Ordinate there.
    pub level: f64,
    /// dy/dx.
    pub slope: f64,
    /// Variance of the level.
    pub level_variance: f64,
    /// Variance of the slope.
    pub slope_variance: f64,
    /// Degrees of freedom of the variances: two less than there are groups.
    pub degrees_of_freedom: f64,
    /// Standard deviation of the inliers' residuals.
    pub deviation: f64,
    /// Points taken.
    pub inliers: usize,
    /// Points offered.
    pub points: usize,
}

impl Line {
    /// Ordinate of the line.
    pub fn at(&self, x: f64) -> f64 {
        self.level + self.slope * (x - self.centre)
    }

    fn residual(&self, point: &Point) -> f32 {
        (f64::from(point.y) - self.at(f64::from(point.x))) as f32
    }
}

/// Fits a line. `scratch` is as long as `points`; afterwards an inlier has `true` in `inlier`, which is
/// as long too.
///
/// Pairs of points are drawn; the pair whose line leaves the smallest median of the residuals'
/// magnitudes gives their robust standard deviation, 1.4826 (1 + 5/(n − 2)) times that median. The pair
/// with the most residuals within [`INLIER_LIMIT`] of these standard deviations wins. Of few points the
/// smallest median is too small, and points that belong to the line are left out; so least squares on the inliers
/// and the inlier rule with their standard deviation alternate until the inliers stay the same.
///
/// Variances are those of least squares or, where they are larger, the cluster-robust ones G/(G − 2)
/// Σ (Σ x r)²/(Σ x²)² over G groups (Liang and Zeger, Biometrika 73, 1986): many samples of one
/// disturbed motion are not many observations.
///
/// `None` with fewer than four points, with inliers from fewer than four groups, or where they do not
/// spread along x.
///
/// ```
/// use model_core::identify::line::{Point, Settings, fit};
///
/// let points: [Point; 9] = core::array::from_fn(|n| {
///     let x = n as f32;
///     // Every third point belongs to something else.
///     let y = if n % 3 == 1 { 40.0 } else { 2.0 * x + 1.0 };
///     Point { x, y, group: n as u16 }
/// });
/// let settings = Settings { confidence: 0.999, inlier_share: 0.5, least_deviation: 1e-3, seed: 1 };
/// let (mut scratch, mut inlier) = ([0.0; 9], [false; 9]);
/// let line = fit(&points, &settings, &mut scratch, &mut inlier).unwrap();
/// assert_eq!((line.inliers, line.slope, line.at(0.0)), (6, 2.0, 1.0));
/// ```
pub fn fit(
    points: &[Point],
    settings: &Settings,
    scratch: &mut [f32],
    inlier: &mut [bool],
) -> Option<Line> {
    if points.len() < 4 || scratch.len() < points.len() || inlier.len() < points.len() {
        return None;
    }
    let scratch = &mut scratch[..points.len()];
    let deviation = robust_deviation(points, settings, scratch)?;
    let mut limit = INLIER_LIMIT * deviation.max(settings.least_deviation);
    let best = consensus(points, settings, limit)?;
    let mut inliers = mark(points, inlier, limit, |point| best.residual(point));
    let mut line = least_squares(points, inlier, inliers)?;
    for _ in 0..ROUNDS {
        let deviation = (line.deviation / TRUNCATED) as f32;
        limit = INLIER_LIMIT * deviation.max(settings.least_deviation);
        let before = inliers;
        inliers = mark(points, inlier, limit, |point| line.residual(point));
        line = least_squares(points, inlier, inliers)?;
        if inliers == before {
            break;
        }
    }
    Some(line)
}

/// Marks the points whose residual is within the limit, and counts them.
fn mark(
    points: &[Point],
    inlier: &mut [bool],
    limit: f32,
    residual: impl Fn(&Point) -> f32,
) -> usize {
    let mut inliers = 0;
    for (point, inlier) in points.iter().zip(inlier.iter_mut()) {
        *inlier = residual(point).abs() <= limit;
        inliers += usize::from(*inlier);
    }
    inliers
}

/// A line through two points, relative to the first.
#[derive(Clone, Copy)]
struct Candidate {
    through: Point,
    slope: f32,
}

impl Candidate {
    /// `None` for points above each other.
    fn draw(points: &[Point], random: &mut Random) -> Option<Self> {
        let count = points.len() as u64;
        let mut index = || ((u64::from(random.bits()) * count) >> 32) as usize;
        let (a, b) = (points[index()], points[index()]);
        let slope = (b.y - a.y) / (b.x - a.x);
        slope.is_finite().then_some(Self { through: a, slope })
    }

    fn residual(&self, point: &Point) -> f32 {
        point.y - self.through.y - self.slope * (point.x - self.through.x)
    }
}

/// The smallest robust standard deviation that a drawn line leaves.
fn robust_deviation(points: &[Point], settings: &Settings, scratch: &mut [f32]) -> Option<f32> {
    let mut random = Random::new(settings.seed, 0);
    let mut smallest: Option<f32> = None;
    for _ in 0..settings.draws() {
        let Some(candidate) = Candidate::draw(points, &mut random) else {
            continue;
        };
        for (residual, point) in scratch.iter_mut().zip(points) {
            *residual = candidate.residual(point).abs();
        }
        let middle = median(scratch)?;
        if smallest.is_none_or(|smallest| middle < smallest) {
            smallest = Some(middle);
        }
    }
    let small_sample = 1.0 + 5.0 / (points.len() - 2) as f32;
    Some(NORMAL_CONSISTENCY * small_sample * smallest?)
}

/// The drawn line with the most points within `limit`; of equals the one with the smaller residuals.
fn consensus(points: &[Point], settings: &Settings, limit: f32) -> Option<Candidate> {
    let mut random = Random::new(settings.seed, 0);
    let mut best: Option<(usize, f32, Candidate)> = None;
    for _ in 0..settings.draws() {
        let Some(candidate) = Candidate::draw(points, &mut random) else {
            continue;
        };
        let (mut count, mut sum) = (0, 0.0);
        for point in points {
            let residual = candidate.residual(point).abs();
            if residual <= limit {
                count += 1;
                sum += residual;
            }
        }
        if best.is_none_or(|(most, least, _)| count > most || (count == most && sum < least)) {
            best = Some((count, sum, candidate));
        }
    }
    best.map(|(_, _, candidate)| candidate)
}

/// Least squares on the inliers.
fn least_squares(points: &[Point], inlier: &[bool], inliers: usize) -> Option<Line> {
    let taken = || {
        let both = points.iter().zip(inlier);
        both.filter(|(_, inlier)| **inlier).map(|(point, _)| point)
    };
    let count = inliers as f64;
    let centre = taken().map(|point| f64::from(point.x)).sum::<f64>() / count;
    let level = taken().map(|point| f64::from(point.y)).sum::<f64>() / count;
    let (mut square, mut product) = (0.0, 0.0);
    for point in taken() {
        let x = f64::from(point.x) - centre;
        square += x * x;
        product += x * (f64::from(point.y) - level);
    }
    let slope = product / square;
    // Groups are numbered in the order of the points: one ends where the next begins.
    let (mut residuals, mut groups) = (0.0, 0.0);
    let mut between = [0.0; 2];
    let mut sums = [0.0; 2];
    let mut group = None;
    let mut close = |sums: &mut [f64; 2]| {
        for (square, sum) in between.iter_mut().zip(sums) {
            *square += *sum * *sum;
            *sum = 0.0;
        }
    };
    for point in taken() {
        if group != Some(point.group) {
            close(&mut sums);
            groups += 1.0;
            group = Some(point.group);
        }
        let x = f64::from(point.x) - centre;
        let residual = f64::from(point.y) - level - slope * x;
        residuals += residual * residual;
        sums[0] += residual;
        sums[1] += x * residual;
    }
    close(&mut sums);
    let freedom = groups - 2.0;
    if freedom < 2.0 || !slope.is_finite() {
        return None;
    }
    let variance = residuals / (count - 2.0);
    let robust = groups / freedom;
    let [level_between, slope_between] = between;
    Some(Line {
        centre,
        level,
        slope,
        level_variance: (variance / count).max(robust * level_between / (count * count)),
        slope_variance: (variance / square).max(robust * slope_between / (square * square)),
        degrees_of_freedom: freedom,
        deviation: libm::sqrt(variance),
        inliers,
        points: points.len(),
    })
}
