//! What the answers on worlds come to.

use rig::world::Kind;
use serde::Serialize;

use super::traced::Judged;
use crate::cells::{self, Cells, row};
use crate::gap_benchmark::judgement::Judgement;
use crate::reproduce::prognostics::statistics::quantile;

/// Standard deviations that hold 95 % of a normal population.
const HOLDS_95: f64 = 1.96;

/// One row of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Which worlds: a kind, or an effect's id.
    pub kind: String,
    /// How many.
    pub logs: usize,
    /// In how many there was something to be seen; where nothing is there, all.
    pub visible: usize,
    /// Right, of the visible ones.
    pub right: usize,
    /// Too little, of the visible ones.
    pub too_little: usize,
    /// Wrong, visible or not.
    pub wrong: usize,
    /// Of those the ones in which there was nothing to be seen.
    pub wrong_not_visible: usize,
    /// Refused by a reader or by the tracing.
    pub refused: usize,
}

impl Row {
    fn of<'a>(kind: &str, judged: impl Iterator<Item = &'a Judged>) -> Self {
        let mut row = Self {
            kind: kind.to_owned(),
            logs: 0,
            visible: 0,
            right: 0,
            too_little: 0,
            wrong: 0,
            wrong_not_visible: 0,
            refused: 0,
        };
        for one in judged {
            row.logs += 1;
            row.visible += usize::from(one.visible);
            row.refused += usize::from(one.refused.is_some());
            match one.judgement {
                Judgement::Right => row.right += usize::from(one.visible),
                Judgement::Abstained => row.too_little += usize::from(one.visible),
                Judgement::Wrong => {
                    row.wrong += 1;
                    row.wrong_not_visible += usize::from(!one.visible);
                }
            }
        }
        row
    }

    fn cells(&self) -> Vec<String> {
        let of_visible = |count: usize| share(count, self.visible);
        vec![
            self.kind.clone(),
            self.logs.to_string(),
            self.visible.to_string(),
            of_visible(self.right),
            of_visible(self.too_little),
            share(self.wrong, self.logs),
            self.wrong_not_visible.to_string(),
            self.refused.to_string(),
        ]
    }
}

/// Numbers within their 95 % intervals.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Coverage {
    /// How many are.
    pub inside: usize,
    /// Of how many.
    pub of: usize,
}

/// Wall-clock seconds of a tracing, beside others.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Seconds {
    /// Half of them take less.
    pub median: f64,
    /// The longest.
    pub longest: f64,
}

/// The answer, serialised as it stands. Keys beyond the contract are additions.
#[derive(Debug, Clone, Serialize)]
pub struct Summary {
    /// How many.
    pub worlds: usize,
    /// Their seed.
    pub seed: u64,
    /// By kind.
    pub rows: Vec<Row>,
    /// Of worlds answered right.
    pub coverage: Coverage,
    /// Of the tracings.
    pub seconds: Seconds,
    /// Of worlds with one effect, by what it is.
    pub effects: Vec<Row>,
    /// Median windowed position error after over before, where something was named rightly.
    pub after_over_before: f64,
    /// Median windowed position error after, over that of a fit told the truth, of visible worlds.
    pub after_over_told: f64,
    /// Every world.
    pub list: Vec<Judged>,
}

impl Summary {
    pub(super) fn of(seed: u64, judged: &[Judged]) -> Self {
        let row_of = |kind: &str| Row::of(kind, judged.iter().filter(|one| one.kind == kind));
        let single = |one: &&Judged| one.truth.len() == 1;
        let mut labels: Vec<&str> = judged
            .iter()
            .filter(single)
            .map(|one| one.truth[0])
            .collect();
        labels.sort_unstable();
        labels.dedup();
        let deviations = judged.iter().flat_map(|one| &one.deviations);
        let inside = |deviation: &f64| deviation.abs() <= HOLDS_95;
        let deviations: Vec<f64> = deviations.map(|it| it.deviation).collect();
        let traced = judged.iter().filter(|one| one.refused.is_none());
        let seconds: Vec<f64> = traced.map(|one| one.seconds).collect();
        let right = |one: &&Judged| one.judgement == Judgement::Right;
        let before = judged
            .iter()
            .filter(right)
            .filter_map(|one| one.after_over_before);
        let visible = judged.iter().filter(|one| one.visible);
        let told = visible.filter_map(|one| one.after_over_told);
        Self {
            worlds: judged.len(),
            seed,
            rows: Kind::ALL
                .iter()
                .map(|(kind, _)| row_of(kind.name()))
                .collect(),
            coverage: Coverage {
                inside: deviations.iter().copied().filter(inside).count(),
                of: deviations.len(),
            },
            seconds: Seconds {
                median: median(&seconds),
                longest: seconds.iter().copied().fold(0.0, f64::max),
            },
            effects: labels
                .iter()
                .map(|label| {
                    let of = |one: &&Judged| one.truth.len() == 1 && one.truth[0] == *label;
                    Row::of(label, judged.iter().filter(of))
                })
                .collect(),
            after_over_before: median(&before.collect::<Vec<_>>()),
            after_over_told: median(&told.collect::<Vec<_>>()),
            list: judged.to_vec(),
        }
    }

    pub(super) fn text(&self) -> String {
        let heads = [
            "kind",
            "logs",
            "visible",
            "right of visible",
            "too little of visible",
            "wrong of logs",
            "not visible",
            "refused",
        ];
        let table = |rows: &[Row], head: &'static str| {
            let mut heads = heads;
            heads[0] = head;
            let mut table: Cells = vec![row(heads)];
            table.extend(rows.iter().map(Row::cells));
            cells::render(&table)
        };
        let mut text = format!(
            "{} worlds of seed {}; in brackets 95 % intervals (Wilson)\n\n{}\n{}\n",
            self.worlds,
            self.seed,
            table(&self.rows, "kind"),
            table(&self.effects, "one effect or law"),
        );
        text += &format!(
            "numbers within their 95 % intervals   {}\n\
             error after over before, median       {:.3}\n\
             error after over told fit, median     {:.3}\n\
             seconds, median and longest           {:.2}, {:.2}\n\n",
            out_of(self.coverage.inside, self.coverage.of),
            self.after_over_before,
            self.after_over_told,
            self.seconds.median,
            self.seconds.longest,
        );
        text += &self.guesses();
        text + &self.failures()
    }

    /// How many answers stay with other guesses for what `[fit]` names; nothing, where that was not asked.
    fn guesses(&self) -> String {
        let asked = || self.list.iter().filter(|one| !one.guesses.is_empty());
        let stay = |one: &&Judged| one.guesses.iter().all(|guessed| guessed.same);
        let right = |one: &&Judged| one.visible && one.judgement == Judgement::Right;
        if asked().next().is_none() {
            return String::new();
        }
        format!(
            "answers that stay with other guesses  {}\n\
             of those that are right and visible   {}\n\n",
            out_of(asked().filter(stay).count(), asked().count()),
            out_of(
                asked().filter(right).filter(stay).count(),
                asked().filter(right).count()
            ),
        )
    }

    /// One line for each world that counts against the tracing, the wrong ones first.
    fn failures(&self) -> String {
        let mut text = String::new();
        for (title, wanted) in [
            ("Wrong:", Judgement::Wrong),
            ("Too little, though visible:", Judgement::Abstained),
        ] {
            let failed = |one: &&Judged| one.judgement == wanted && one.fails();
            let failed: Vec<&Judged> = self.list.iter().filter(failed).collect();
            if failed.is_empty() {
                continue;
            }
            text += &format!("{title}\n");
            for one in failed {
                text += &self.failure(one);
            }
            text.push('\n');
        }
        text
    }

    fn failure(&self, one: &Judged) -> String {
        let mut truth = one.truth.join(" + ");
        if truth.is_empty() {
            truth = "nothing".to_owned();
        }
        if !one.wrong_numbers.is_empty() {
            truth += &format!(", wrong {}", one.wrong_numbers.join(" and "));
        }
        if !one.sins.is_empty() {
            truth += &format!(" [{}]", one.sins.join(", "));
        }
        let ratio = one
            .told_ratio
            .map_or(String::new(), |ratio| format!(" ({ratio:.2} times)"));
        format!(
            "  {truth}{ratio} -> {}   cargo hil bench gap --worlds {} --seed {} --only {}\n",
            one.said(),
            self.worlds,
            self.seed,
            one.index
        )
    }
}

fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// Count out of all, with the interval of the share.
fn out_of(count: usize, of: usize) -> String {
    format!("{count} of {of}{}", bracket(count, of))
}

/// Count and share with its interval.
fn share(count: usize, of: usize) -> String {
    if of == 0 {
        return "-".to_owned();
    }
    let percent = 100.0 * count as f64 / of as f64;
    format!("{count}: {percent:.0} %{}", bracket(count, of))
}

fn bracket(count: usize, of: usize) -> String {
    if of == 0 {
        return String::new();
    }
    let (low, high) = wilson(count, of);
    format!(" [{:.0}, {:.0}]", 100.0 * low, 100.0 * high)
}

/// 95 % interval of a share (E. B. Wilson, *Probable inference, the law of succession, and statistical
/// inference*, 1927).
pub fn wilson(count: usize, of: usize) -> (f64, f64) {
    let (n, z) = (of as f64, HOLDS_95);
    let share = count as f64 / n;
    let middle = share + z * z / (2.0 * n);
    let spread = z * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    let whole = 1.0 + z * z / n;
    (
        ((middle - spread) / whole).max(0.0),
        ((middle + spread) / whole).min(1.0),
    )
}

#[cfg(test)]
mod tests {
    use super::wilson;

    /// From the tables of R. G. Newcombe, Statistics in Medicine 17 (1998).
    #[test]
    fn wilson_intervals_are_the_published_ones() {
        for ((count, of), (low, high)) in [
            ((81, 263), (0.2553, 0.3662)),
            ((15, 148), (0.0624, 0.1605)),
            ((0, 20), (0.0, 0.1611)),
            ((1, 29), (0.0061, 0.1718)),
        ] {
            let interval = wilson(count, of);
            assert!((interval.0 - low).abs() < 1e-4, "{interval:?}");
            assert!((interval.1 - high).abs() < 1e-4, "{interval:?}");
        }
    }
}
