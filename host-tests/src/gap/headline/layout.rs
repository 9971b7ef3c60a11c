//! The answer for people as a terminal shows it.

use super::Headline;
use super::next::sentence;
use crate::gap::answer::listed;
use crate::gap::outcome::{Outcome, Report};
use crate::gap::terminal::{Style, WIDTH, printable, wrapped};
use crate::quantity::Scale;

/// Lines that the answer takes at most, as a terminal shows it.
pub const LINES: usize = 12;

/// Lines that stay for what was found, whatever the rest needs.
const LEAST_FOR_DETAILS: usize = 4;

/// Characters of a machine's name that the answer shows.
const NAME: usize = 40;

/// The answer as lines of at most [`WIDTH`] columns, [`LINES`] of them less `reserved`: what does not fit ends
/// with an ellipsis, or is counted. What is to be copied stands in one line, however long it is.
pub(in crate::gap) fn lines(report: &Report, reserved: usize) -> Vec<(String, Style)> {
    let headline = Headline::of(report);
    let name = shortened(&printable(&report.outcome.machine), NAME);
    let (next, copied) = sentence(&headline.next);
    let copied: Vec<String> = copied
        .iter()
        .map(|line| format!("  {}", printable(line)))
        .collect();
    let mut texts = [
        format!("{name}: {}", headline.finding),
        headline.gain.clone(),
        headline.certainty.clone(),
        next,
    ];
    let note = resampled(&report.outcome, &report.coordinate).unwrap_or_default();
    let note = paragraph(&note);
    let most = LINES - reserved;
    let others = copied.len() + note.len();
    let sentences: Vec<Vec<String>> = headline.details.iter().map(detail).collect();
    let least = LEAST_FOR_DETAILS.min(sentences.iter().map(Vec::len).sum());
    let room = most.saturating_sub(others + least);
    leave_sentences_out(&mut texts, room);
    let mut blocks = texts.map(|text| paragraph(&text));
    shorten(&mut blocks, room);
    let used: usize = blocks.iter().map(Vec::len).sum();
    let room = most.saturating_sub(others + used);
    let details = details(&headline.details, &sentences, room);
    let [finding, gain, certainty, next] = blocks;
    let parts = [
        (finding, Style::Strong),
        (details, Style::Good),
        (gain, Style::Plain),
        (certainty, Style::Plain),
        (next, Style::Plain),
        (copied, Style::Plain),
        (note, Style::Warning),
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

/// Takes whole sentences from certainty and gain, of which one each stays, until all paragraphs have no more than `most`
/// lines. What the logs cannot tell apart is the end of the certainty, so that loses its beginning, the gain its end.
fn leave_sentences_out(texts: &mut [String; 4], most: usize) {
    let used =
        |texts: &[String; 4]| -> usize { texts.iter().map(|text| paragraph(text).len()).sum() };
    while used(texts) > most
        && let Some(&end) = sentence_ends(&texts[2]).first()
    {
        texts[2] = texts[2].split_off(end + 1);
    }
    while used(texts) > most
        && let Some(&end) = sentence_ends(&texts[1]).last()
    {
        texts[1].truncate(end);
    }
}

/// Where each sentence but the last one ends.
fn sentence_ends(text: &str) -> Vec<usize> {
    let begins = |rest: &str| rest.starts_with(|first: char| first.is_uppercase());
    let ends = text.match_indices(". ");
    ends.filter(|(at, end)| begins(&text[at + end.len()..]))
        .map(|(at, _)| at + 1)
        .collect()
}

/// Takes lines from the ends of paragraphs until no more than `most` are left in all, or one of each. The
/// paragraphs are finding, gain, certainty and next step. The certainty is shortened first, then the gain: the
/// report holds both in full.
fn shorten(blocks: &mut [Vec<String>; 4], most: usize) {
    for least in [2, 1] {
        for place in [2, 1, 3, 0] {
            while blocks[place].len() > least && blocks.iter().map(Vec::len).sum::<usize>() > most {
                blocks[place].pop();
                if let Some(last) = blocks[place].last_mut() {
                    *last = with_ellipsis(last);
                }
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

/// What was found, behind its name.
fn detail((id, sentence): &(String, String)) -> Vec<String> {
    wrapped(&printable(&format!("  {id}: {sentence}")), 4)
}

/// As many of the sentences, broken into `blocks`, as so many lines take, and how many more there are.
fn details(details: &[(String, String)], blocks: &[Vec<String>], room: usize) -> Vec<String> {
    if blocks.iter().map(Vec::len).sum::<usize>() <= room {
        return blocks.concat();
    }
    let mut shown: Vec<String> = Vec::new();
    let mut count = 0;
    // The last line is for those that are left out.
    for block in blocks {
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

/// That logs were resampled, and what that changed in the first of them.
fn resampled(outcome: &Outcome, unit: &str) -> Option<String> {
    let (first, others) = outcome.resampled.split_first()?;
    let also = match others.len() {
        0 => String::new(),
        1 => "; another log was resampled too".to_owned(),
        count => format!("; {count} more logs were resampled too"),
    };
    let name = printable(&first.log);
    // The end of a path says more than its beginning.
    let start = name.chars().count().saturating_sub(NAME);
    let name: String = name.chars().skip(start).collect();
    let change = &first.change;
    Some(format!(
        "{name} was resampled: rows moved by up to {} of a period, {} samples filled in, some {} rms added to \
         the position{also}.",
        Scale::percent().quantity(change.displacement_max),
        change.filled,
        Scale::of(unit, [change.position_error]).quantity(change.position_error)
    ))
}
