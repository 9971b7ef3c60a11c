//! The answer for people as a terminal shows it.

use std::borrow::Cow;

use super::next::{Step, sentence};
use super::{CHANCE, Headline, NAMED, is_doubt_in_finding, rises};
use crate::gap::answer::listed;
use crate::gap::outcome::{Outcome, Report};
use crate::gap::terminal::{Style, WIDTH, printable, wrapped};
use crate::log::counted;
use crate::quantity::Scale;

/// Lines that the answer takes at most, as a terminal shows it.
pub const LINES: usize = 12;

/// Effects that stay with their sizes as long as anything else can be left out: as many as the first sentence names.
const LEAST_DETAILED: usize = NAMED;

/// Characters of a machine's name that the answer shows.
const NAME: usize = 40;

/// The answer as lines of at most [`WIDTH`] columns, [`LINES`] of them less `reserved`: what finds no room is left out
/// by whole sentences. What is to be copied stands in one line, however long it is.
pub(in crate::gap) fn lines(report: &Report, reserved: usize) -> Vec<(String, Style)> {
    let headline = Headline::of(report);
    let mut shown = Shown::all(report, &headline);
    while shown.lines().len() > LINES - reserved && shown.leave_out() {}
    shown.lines()
}

/// The sentences of the answer that are shown.
struct Shown<'h> {
    finding: Vec<&'h str>,
    /// So many sentences of it stay: the first, and the last ones, which say which errors have risen.
    least_finding: usize,
    details: &'h [(String, String)],
    /// So many of the details, the others are counted.
    detailed: usize,
    gain: Vec<&'h str>,
    /// The one sentence that stays of it.
    shortest_gain: &'h str,
    certainty: Vec<&'h str>,
    /// So many sentences of it stay as long as anything else can be left out, beside the one that says how sure it is: that of
    /// the doubt, which is the last.
    least_certainty: usize,
    /// What to do, each with its lines to copy.
    next: Vec<Cow<'h, [Step]>>,
    name: String,
    note: Option<String>,
    /// How many samples were filled in, which stays of it where there are many.
    short_note: Option<String>,
    /// Whether it stays as long as the effects are named with their sizes.
    keeps_note: bool,
}

impl<'h> Shown<'h> {
    fn all(report: &Report, headline: &'h Headline) -> Self {
        Self {
            finding: sentences(&headline.finding),
            least_finding: 1 + rises(report).len(),
            details: &headline.details,
            detailed: headline.details.len(),
            gain: sentences(&headline.gain),
            shortest_gain: &headline.shortest_gain,
            certainty: sentences(&headline.certainty),
            least_certainty: usize::from(!is_doubt_in_finding(&report.outcome)),
            next: headline
                .next
                .chunk_by(|_, step| matches!(step, Step::Copy(_)))
                .map(Cow::Borrowed)
                .collect(),
            name: shortened(&printable(&report.outcome.machine), NAME),
            note: resampled(&report.outcome, &report.coordinate),
            short_note: filled(&report.outcome),
            keeps_note: has_many_filled(&report.outcome),
        }
    }

    fn lines(&self) -> Vec<(String, Style)> {
        let steps: Vec<Step> = self.next.concat();
        let (next, copied) = sentence(&steps);
        let copied = copied.iter();
        let copied = copied.map(|line| format!("  {}", printable(line)));
        let parts = [
            (
                paragraph(&format!("{}: {}", self.name, self.finding.join(" "))),
                Style::Strong,
            ),
            (self.detail_lines(), Style::Good),
            (paragraph(&self.gain.join(" ")), Style::Plain),
            (paragraph(&self.certainty.join(" ")), Style::Plain),
            (paragraph(&next), Style::Plain),
            (copied.collect(), Style::Plain),
            (
                paragraph(self.note.as_deref().unwrap_or_default()),
                Style::Warning,
            ),
        ];
        let styled = parts.into_iter();
        styled
            .flat_map(|(lines, style)| lines.into_iter().map(move |line| (line, style)))
            .collect()
    }

    /// The details that are shown, and how many more there are.
    fn detail_lines(&self) -> Vec<String> {
        let (shown, others) = self.details.split_at(self.detailed);
        let mut lines: Vec<String> = shown.iter().flat_map(detail).collect();
        if !others.is_empty() {
            let ids: Vec<&str> = others.iter().map(|(id, _)| id.as_str()).collect();
            let and = if shown.is_empty() { "" } else { "and " };
            let more = if shown.is_empty() { "" } else { " more" };
            let counted = |what: &str| format!("  {and}{}{more}: {what}", others.len());
            let line = printable(&counted(&listed(&ids)));
            let fits = line.chars().count() <= WIDTH;
            lines.push(if fits {
                line
            } else {
                counted("--verbose lists them")
            });
        }
        lines
    }

    /// Leaves out the sentence, the step or the detail that is needed least; false if none can be left out. What the
    /// logs cannot tell apart is the end of the certainty, so that loses its beginning; how sure it is stays longest. The
    /// errors on unseen data stay.
    fn leave_out(&mut self) -> bool {
        if let Some(place) = self.least_certain() {
            self.certainty.remove(place);
        } else if self.gain.len() > 1 {
            self.gain.pop();
        } else if let Some((place, steps)) = self.with_line() {
            self.next[place] = Cow::Owned(steps);
        } else if self.detailed > LEAST_DETAILED {
            self.detailed -= 1;
        } else if self.gain != [self.shortest_gain] {
            // One error says how much better the model is; each step says another thing to do.
            self.gain = vec![self.shortest_gain];
        } else if let Some(place) = self.least_step() {
            self.next.remove(place);
        } else if self.note != self.short_note {
            self.note.clone_from(&self.short_note);
        } else if self.leave_out_certainty() || !self.keeps_note && self.leave_out_note() {
            // One of them is out.
        } else if self.detailed > 1 {
            self.detailed -= 1;
        } else if self.finding.len() > self.least_finding {
            self.finding.remove(1);
        } else if self.detailed > 0 {
            self.detailed = 0;
        } else if self.leave_out_note() {
            // What was found comes before what was done to the logs.
        } else if self.finding.len() > 1 {
            self.finding.pop();
        } else {
            return false;
        }
        true
    }
}

impl Shown<'_> {
    /// The sentence of the certainty that is needed least, if one can be left out while there is anything else.
    fn least_certain(&self) -> Option<usize> {
        let kept = self.certainty.len().saturating_sub(self.least_certainty);
        (0..kept).find(|&place| !self.certainty[place].starts_with(CHANCE))
    }

    /// Leaves out how sure it is, then what the logs cannot tell apart; false where neither is there.
    fn leave_out_certainty(&mut self) -> bool {
        let is_there = !self.certainty.is_empty();
        if is_there {
            self.certainty.remove(0);
        }
        is_there
    }

    /// Leaves out what was done to the logs; false if nothing is said of it.
    fn leave_out_note(&mut self) -> bool {
        self.short_note = None;
        self.note.take().is_some()
    }

    /// The step with a line to declare an effect by, and the same without that line.
    fn with_line(&self) -> Option<(usize, Vec<Step>)> {
        let mut steps = self.next.iter().enumerate();
        steps.find_map(|(place, steps)| Some((place, Step::without_line(steps)?)))
    }

    /// The step that is needed least, if one can be left out: not the first one, nor that a file was written; what is
    /// there to be copied goes last.
    fn least_step(&self) -> Option<usize> {
        let is_plain = |steps: &[Step]| matches!(steps, [Step::Do(_)]);
        let is_written = |steps: &[Step]| matches!(steps, [Step::Written(_), ..]);
        let places = || (1..self.next.len()).rev();
        let plain = places().find(|&place| is_plain(&self.next[place]));
        plain.or_else(|| places().find(|&place| !is_written(&self.next[place])))
    }
}

fn paragraph(text: &str) -> Vec<String> {
    if text.is_empty() {
        return Vec::new();
    }
    wrapped(&printable(text), 0)
}

/// The sentences of a text.
fn sentences(text: &str) -> Vec<&str> {
    let begins = |rest: &str| rest.starts_with(|first: char| first.is_uppercase());
    let ends = text.match_indices(". ");
    let ends = ends.filter(|(at, end)| begins(&text[at + end.len()..]));
    let mut sentences = Vec::new();
    let mut start = 0;
    for (at, end) in ends {
        sentences.push(&text[start..=at]);
        start = at + end.len();
    }
    sentences.push(&text[start..]);
    sentences.retain(|sentence| !sentence.is_empty());
    sentences
}

/// The name with its end left out where it is longer than `most` characters.
fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_owned();
    }
    let start: String = name.chars().take(most - 1).collect();
    format!("{start}…")
}

/// What was found, behind its name.
fn detail((id, sentence): &(String, String)) -> Vec<String> {
    wrapped(&printable(&format!("  {id}: {sentence}")), 4)
}

/// Share of a log's samples from which on those that are filled in matter: as many of its rows are a straight line.
const MANY: f64 = 0.01;

/// Whether so many samples of any log are filled in that the answer has to say so.
fn has_many_filled(outcome: &Outcome) -> bool {
    let mut changes = outcome.resampled.iter().map(|log| &log.change);
    changes.any(|change| change.filled as f64 > MANY * (change.rows + change.filled) as f64)
}

/// How many samples of the first log that was resampled are filled in, if any are.
fn filled(outcome: &Outcome) -> Option<String> {
    let first = outcome.resampled.first()?;
    let change = &first.change;
    let samples = change.rows + change.filled - change.merged;
    (change.filled > 0).then(|| {
        format!(
            "{}: {} of {samples} samples filled in, where rows are missing.",
            short_name(&first.log),
            change.filled
        )
    })
}

/// The end of a log's path, which says more than its beginning.
fn short_name(log: &str) -> String {
    let name = printable(log);
    let start = name.chars().count().saturating_sub(NAME);
    name.chars().skip(start).collect()
}

/// That logs were resampled, and what that changed in the first of them.
fn resampled(outcome: &Outcome, unit: &str) -> Option<String> {
    let (first, others) = outcome.resampled.split_first()?;
    let also = match others.len() {
        0 => String::new(),
        1 => "; another log was resampled too".to_owned(),
        count => format!("; {count} more logs were resampled too"),
    };
    let name = short_name(&first.log);
    let change = &first.change;
    let mut done = vec![format!("{name} was resampled")];
    if change.filled > 0 {
        let samples = change.rows + change.filled - change.merged;
        let filled = change.filled;
        done.push(format!(
            "{filled} of {samples} samples filled in, where rows are missing"
        ));
    }
    if change.displacement_max > 0.0 {
        let moved = Scale::percent().quantity(change.displacement_max);
        done.push(format!("rows moved by up to {moved} of a period"));
    }
    if change.merged > 0 {
        let rows = counted(change.merged, "row");
        done.push(format!("{rows} merged with one of the same time"));
    }
    Some(format!(
        "{}; that puts some {} rms into the position{also}.",
        done.join(", ").replacen(',', ":", 1),
        Scale::of(unit, [change.position_error]).quantity(change.position_error)
    ))
}
