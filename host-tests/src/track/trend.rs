//! A straight line through estimates of one number, log by log, and what follows from it.
//!
//! The estimate of log i is y_i = α + β x_i + u_i + e_i: the error e_i has the log's own standard error, the scatter u_i
//! from log to log a variance τ² that nobody knows beforehand. That is a random-effects meta-regression: weighted least
//! squares with the weights 1/(s_i² + τ²). τ² is R. C. Paule's and J. Mandel's (*Consensus values and weighting
//! factors*, Journal of Research of the NBS 87, 1982): the one at which the weighted squares of what is left are as
//! many as there are degrees of freedom, or 0. The variances are G. Knapp's and J. Hartung's (*Improved tests for a random effects
//! meta-regression with a single covariate*, Statistics in Medicine 22, 2003): scaled by the mean of these squares, taken for
//! 1 where it is less, with quantiles of Student's t, which hold for a few logs where normal ones do not.

use model_core::numeric::student::upper_tail;

/// Fewest estimates that a trend can be proven from: two make a line, and only a third one says how far they scatter.
pub const LEAST_LOGS: usize = 3;

/// What an interval leaves out.
pub const OUTSIDE: f64 = 0.05;

/// Chance of an alarm, of all numbers together, while nothing changes.
pub const FALSE_ALARMS: f64 = 0.05;

/// Least standard error that is believed, as a share of the largest estimate: those are single precision.
const LEAST_SHARE: f64 = 1e-6;

/// Halvings of an interval of a monotone function: all bits of an `f64`.
const HALVINGS: usize = 200;

/// The estimate of one log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Place of the log in time.
    pub place: f64,
    /// The estimate.
    pub value: f64,
    /// Its own standard error.
    pub std: f64,
}

/// The line through the estimates of at least [`LEAST_LOGS`] logs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Place at which the level is told: of the last log.
    pub last: f64,
    /// Value of the line there.
    pub level: f64,
    /// Change a log.
    pub slope: f64,
    /// Standard deviation of the scatter from log to log.
    pub scatter: f64,
    /// Degrees of freedom.
    pub freedom: f64,
    level_variance: f64,
    slope_variance: f64,
    covariance: f64,
}

/// When a line reaches a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reach {
    /// It is there already.
    Reached,
    /// Surely not, as it goes: it leads away from the limit.
    Never,
    /// In so many logs from the last one: the line, unless it leads away, and the interval, which may have no end.
    In {
        /// Where the line itself reaches it.
        logs: Option<f64>,
        /// From and to.
        interval: (f64, Option<f64>),
    },
}

impl Line {
    /// The line. `last`: the place of the last log, whether its estimate is among these or not. `None` where there are
    /// fewer than [`LEAST_LOGS`] places.
    pub fn through(estimates: &[Estimate], last: f64) -> Option<Self> {
        let largest = estimates.iter().map(|it| it.value.abs());
        let least = LEAST_SHARE * largest.fold(0.0, f64::max);
        let own: Vec<Estimate> = estimates
            .iter()
            .map(|it| Estimate {
                place: it.place - last,
                std: it.std.max(least).max(f64::MIN_POSITIVE.sqrt()),
                ..*it
            })
            .collect();
        let places = own.iter().map(|it| it.place);
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
            (low.min(it), high.max(it))
        });
        if own.len() < LEAST_LOGS || low >= high {
            return None;
        }
        let freedom = (own.len() - 2) as f64;
        let between = between(&own, freedom);
        let fit = Weighted::of(&own, between);
        let scale = (fit.squares / freedom).max(1.0);
        // The level at the last log lies `−centre` logs from the weighted mean of the places.
        let slope_variance = scale / fit.spread;
        let to_last = -fit.centre;
        Some(Self {
            last,
            level: fit.mean + fit.slope * to_last,
            slope: fit.slope,
            scatter: between.sqrt(),
            freedom,
            level_variance: scale / fit.weight + to_last * to_last * slope_variance,
            slope_variance,
            covariance: to_last * slope_variance,
        })
    }

    /// Value at a place.
    pub fn at(&self, place: f64) -> f64 {
        self.level + self.slope * (place - self.last)
    }

    /// The 95 % interval of the line at a place.
    pub fn interval_at(&self, place: f64) -> (f64, f64) {
        let from_last = place - self.last;
        let variance = self.level_variance
            + from_last * (2.0 * self.covariance + from_last * self.slope_variance);
        let half = self.quantile() * variance.max(0.0).sqrt();
        (self.at(place) - half, self.at(place) + half)
    }

    /// The 95 % interval of the slope.
    pub fn slope_interval(&self) -> (f64, f64) {
        let half = self.quantile() * self.slope_variance.sqrt();
        (self.slope - half, self.slope + half)
    }

    /// Chance of a slope as far from zero, either way, while nothing changes.
    pub fn p_value(&self) -> f64 {
        2.0 * upper_tail(self.slope.abs() / self.slope_variance.sqrt(), self.freedom)
    }

    /// When the line reaches a limit that lies above it, or below it, at the place `first`; with E. C. Fieller's interval
    /// (*Some problems in interval estimation*, Journal of the Royal Statistical Society B 16, 1954): all r at which level +
    /// slope r does not differ from the limit. It is of the line; one log scatters around that.
    pub fn reach(&self, limit: f64, first: f64) -> Reach {
        let is_upper = limit >= self.at(first);
        let away = self.level - limit;
        if if is_upper { away >= 0.0 } else { away <= 0.0 } {
            return Reach::Reached;
        }
        let squared = self.quantile().powi(2);
        let a = self.slope * self.slope - squared * self.slope_variance;
        let b = self.slope * away - squared * self.covariance;
        let c = away * away - squared * self.level_variance;
        let line = -away / self.slope;
        let logs = (line.is_finite() && line >= 0.0).then_some(line);
        let discriminant = b * b - a * c;
        // a r² + 2 b r + c ≤ 0.
        let interval = if a > 0.0 {
            // The slope is not zero for certain: an interval. The discriminant is not negative but by rounding.
            let root = discriminant.max(0.0).sqrt();
            let (from, to) = ((-b - root) / a, (-b + root) / a);
            if to < 0.0 {
                return Reach::Never;
            }
            (from.max(0.0), Some(to))
        } else if discriminant <= 0.0 || c <= 0.0 {
            (0.0, None)
        } else {
            // All but an interval around now: from its end on.
            let root = discriminant.sqrt();
            (((-b - root) / a).max((-b + root) / a).max(0.0), None)
        };
        Reach::In { logs, interval }
    }

    fn quantile(&self) -> f64 {
        quantile(self.freedom)
    }
}

/// A weighted straight line, its place counted from the weighted mean of the places.
struct Weighted {
    centre: f64,
    mean: f64,
    slope: f64,
    /// Sum of the weights.
    weight: f64,
    /// Weighted sum of the squared places.
    spread: f64,
    /// Weighted sum of the squares of what is left.
    squares: f64,
}

impl Weighted {
    fn of(estimates: &[Estimate], between: f64) -> Self {
        let weights: Vec<f64> = estimates
            .iter()
            .map(|it| 1.0 / (it.std * it.std + between))
            .collect();
        let sum = |value: &dyn Fn(&Estimate) -> f64| -> f64 {
            let each = estimates.iter().zip(&weights);
            each.map(|(it, weight)| weight * value(it)).sum()
        };
        let weight = sum(&|_| 1.0);
        let centre = sum(&|it| it.place) / weight;
        let mean = sum(&|it| it.value) / weight;
        let spread = sum(&|it| (it.place - centre).powi(2));
        let slope = sum(&|it| (it.place - centre) * (it.value - mean)) / spread;
        let squares = sum(&|it| (it.value - mean - slope * (it.place - centre)).powi(2));
        Self {
            centre,
            mean,
            slope,
            weight,
            spread,
            squares,
        }
    }
}

/// Paule's and Mandel's variance between the logs: the squares fall as it grows.
fn between(estimates: &[Estimate], freedom: f64) -> f64 {
    let is_enough = |between: f64| Weighted::of(estimates, between).squares <= freedom;
    if is_enough(0.0) {
        return 0.0;
    }
    let variances = estimates.iter().map(|it| it.std * it.std);
    let mut high = variances.fold(0.0, f64::max);
    while !is_enough(high) {
        high *= 4.0;
    }
    least(high, is_enough)
}

/// The least number up to `high` from which on something holds, to the last bit; it holds at `high`, and not at 0.
fn least(mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let mut low = 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// The 97.5 % point of Student's t: where its upper tail is half of [`OUTSIDE`].
fn quantile(freedom: f64) -> f64 {
    let is_beyond = |t: f64| upper_tail(t, freedom) <= 0.5 * OUTSIDE;
    let mut high = 2.0;
    while !is_beyond(high) {
        high *= 2.0;
    }
    least(high, is_beyond)
}

/// Which of several p-values are significant, so that with nothing in any of them the chance of one is `share` at most (S. Holm,
/// *A simple sequentially rejective multiple test procedure*, Scandinavian Journal of Statistics 6, 1979).
pub fn holm(p_values: &[f64], share: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|&a, &b| p_values[a].total_cmp(&p_values[b]));
    let mut significant = vec![false; p_values.len()];
    for (rank, &place) in order.iter().enumerate() {
        if p_values[place] > share / (p_values.len() - rank) as f64 {
            break;
        }
        significant[place] = true;
    }
    significant
}
