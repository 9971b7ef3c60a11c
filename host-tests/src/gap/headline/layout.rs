//! The answer for people as a terminal shows it.

use super::{Headline, Step};
use crate::gap::answer::listed;
use crate::gap::outcome::{Outcome, Report};
use crate::gap::terminal::{Style, WIDTH, printable, wrapped};

/// Lines that the answer takes at most, as a terminal shows it.
pub const LINES: usize = 12;

/// Lines that stay for what was found, whatever the rest needs.
const LEAST_FOR_DETAILS: usize = 2;

/// Characters of a machine's name that the answer shows.
const NAME: usize = 40;

/// The answer as lines of at most [`WIDTH`] columns, [`LINES`] of them less `reserved`: what does not fit ends
/// with an ellipsis, or is counted. What is to be copied stands in one line, however long it is.
pub(in crate::gap) fn lines(report: &Report, reserved: usize) -> Vec<(String, Style)> {
    let headline = Headline::of(report);
    let name = shortened(&printable(&report.outcome.machine), NAME);
    let (mut words, mut copied) = (vec!["Next:"], Vec::new());
    for step in &headline.next {
        match step {
            Step::Do(step) => words.push(step),
            Step::Copy(line) => copied.push(format!("  {}", printable(line))),
        }
    }
    let mut blocks = [
        paragraph(&format!("{name}: {}", headline.finding)),
        paragraph(&headline.gain),
        paragraph(&headline.certainty),
        paragraph(&words.join(" ")),
    ];
    let note = resampled(&report.outcome);
    let most = LINES - reserved;
    let others = copied.len() + note.iter().count();
    let least = LEAST_FOR_DETAILS.min(headline.details.len());
    shorten(&mut blocks, most.saturating_sub(others + least));
    let used: usize = blocks.iter().map(Vec::len).sum();
    let details = details(&headline.details, most.saturating_sub(others + used));
    let [finding, gain, certainty, next] = blocks;
    let parts = [
        (finding, Style::Strong),
        (details, Style::Good),
        (gain, Style::Plain),
        (certainty, Style::Plain),
        (next, Style::Plain),
        (copied, Style::Plain),
        (note.into_iter().collect(), Style::Warning),
    ];
    let styled = parts.into_iter();
    styled
        .flat_map(|(lines, style)| lines.into_iter().map(move |line| (line, style)))
        .collect()
}

fn paragraph(text: &str) -> Vec<String> {
    if text.is_empty() {
        return Vec::new();
    }
    wrapped(&printable(text), 0)
}

/// Takes lines from the ends of paragraphs until no more than `most` are left in all, or one of each. The
/// order is finding, gain, certainty, next: of the last two the most can be read elsewhere.
fn shorten(blocks: &mut [Vec<String>; 4], most: usize) {
    for (place, least) in [2, 1, 3, 0]
        .into_iter()
        .flat_map(|place| [(place, 2)])
        .chain([2, 1, 3, 0].map(|place| (place, 1)))
    {
        while blocks[place].len() > least && blocks.iter().map(Vec::len).sum::<usize>() > most {
            blocks[place].pop();
            if let Some(last) = blocks[place].last_mut() {
                *last = with_ellipsis(last);
            }
        }
    }
}

/// A line that says that it goes on elsewhere.
fn with_ellipsis(line: &str) -> String {
    let mut line = line.trim_end_matches([' ', '…']);
    while line.chars().count() + 2 > WIDTH {
        line = line.rfind(' ').map_or("", |end| &line[..end]);
    }
    format!("{line} …")
}

/// The name with its end left out where it is longer than `most` characters.
fn shortened(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_owned();
    }
    let start: String = name.chars().take(most - 1).collect();
    format!("{start}…")
}

/// As many of the sentences as so many lines take, and how many more there are.
fn details(details: &[(String, String)], room: usize) -> Vec<String> {
    let blocks: Vec<Vec<String>> = details
        .iter()
        .map(|(id, sentence)| wrapped(&printable(&format!("  {id}: {sentence}")), 4))
        .collect();
    if blocks.iter().map(Vec::len).sum::<usize>() <= room {
        return blocks.concat();
    }
    let mut shown: Vec<String> = Vec::new();
    let mut count = 0;
    // The last line is for those that are left out.
    for block in &blocks {
        if shown.len() + block.len() + 1 > room {
            break;
        }
        shown.extend_from_slice(block);
        count += 1;
    }
    if count == 0 {
        let kept = room.saturating_sub(usize::from(blocks.len() > 1)).max(1);
        shown.extend(blocks[0].iter().take(kept).cloned());
        if let Some(last) = shown.last_mut().filter(|_| kept < blocks[0].len()) {
            *last = with_ellipsis(last);
        }
        count = 1;
    }
    let rest: Vec<&str> = details[count..].iter().map(|(id, _)| id.as_str()).collect();
    if !rest.is_empty() && shown.len() < room {
        let line = format!("  and {} more: {}", rest.len(), listed(&rest));
        let mut lines = wrapped(&printable(&line), 4);
        if lines.len() > 1 {
            lines[0] = with_ellipsis(&lines[0]);
        }
        shown.push(lines.swap_remove(0));
    }
    shown
}

/// That logs were resampled, in one line.
fn resampled(outcome: &Outcome) -> Option<String> {
    let (first, others) = outcome.resampled.split_first()?;
    let also = match others.len() {
        0 => String::new(),
        count => format!(", and {count} more logs"),
    };
    let name = printable(&first.log);
    // The end of a path says more than its beginning.
    let start = name.chars().count().saturating_sub(NAME);
    let name: String = name.chars().skip(start).collect();
    Some(format!(
        "{name} was resampled ({} samples filled in){also}.",
        first.change.filled
    ))
}
