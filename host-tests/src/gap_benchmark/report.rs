//! The benchmark as a page.

use std::io;

use super::summary::{Confusion, NOTHING, Summary, UNKNOWN, rate_cells};
use crate::page::{escape, page, table};

pub(super) fn html(summary: &Summary) -> io::Result<String> {
    let head = summary.groups.first().map_or(String::new(), |nominal| {
        format!(
            "Of {} logs with one undeclared effect at nominal strength, {:.0} % are answered right and \
             {:.1} % wrong.",
            nominal.logs,
            100.0 * nominal.right,
            100.0 * nominal.wrong
        )
    });
    let mut body = format!(
        "<header><p class=\"kind\">A benchmark</p>\n<h1>How often the tracing is right</h1>\n<p \
         class=\"finding\">{}</p></header>\n",
        escape(&head)
    );
    let mut section = |title: &str, text: &str, html: String| {
        body += &format!(
            "<section>\n<h2>{}</h2>\n<p class=\"note\">{}</p>\n{html}</section>\n",
            escape(title),
            escape(text)
        );
    };
    section(
        "Rates",
        "Right: the effect, or a class that it is in, and nothing else. Too little: nothing, an unknown \
         effect, or one of two. Stepwise: a regression on accelerations with the same library of effects \
         and the same held-out blocks.",
        table(&rate_cells("", &summary.groups)) + &table(&summary.figure_cells()),
    );
    section(
        "What there is, and what was said",
        "Logs with one effect at both strengths, or none. A class counts as the truth where it holds it.",
        matrix(&summary.confusion),
    );
    section(
        "Effect by effect",
        "On three machines.",
        table(&rate_cells("effect × strength", &summary.effects))
            + &table(&rate_cells("machine", &summary.machines))
            + &table(&rate_cells("other motions", &summary.motions)),
    );
    Ok(page(
        "How often the tracing is right",
        &body,
        &[
            "The machines are rigs in double precision that share no code with the core. Motions, seeds and \
             noise are not those that the tracing was developed on."
                .to_owned(),
        ],
    ))
}

/// The counts as a table whose cells are as dark as their share of the row; right ones in one colour,
/// wrong ones in another.
fn matrix(confusion: &Confusion) -> String {
    let heads: String = confusion
        .answers
        .iter()
        .map(|answer| format!("<th class=\"up\"><span>{}</span></th>", escape(answer)))
        .collect();
    let mut rows = String::new();
    for (truth, counts) in confusion.truths.iter().zip(&confusion.counts) {
        let all: usize = counts.iter().sum();
        rows += &format!("<tr><td>{}</td>", escape(truth));
        for (answer, &count) in confusion.answers.iter().zip(counts) {
            if count == 0 {
                rows += "<td class=\"n\"></td>";
                continue;
            }
            let effect = confusion.answers.contains(truth);
            let outside = truth.starts_with('(');
            let right = answer == truth
                || (outside && answer == UNKNOWN)
                || (!effect && !outside && answer == NOTHING);
            let too_little = (effect && (answer == UNKNOWN || answer == NOTHING))
                || (outside && answer == NOTHING);
            let colour = match (right, too_little) {
                (true, _) => "after",
                (_, true) => "guide",
                _ => "before",
            };
            let share = (100.0 * (0.15 + 0.6 * count as f64 / all as f64)).round();
            rows += &format!(
                "<td class=\"n\" style=\"background:color-mix(in srgb,var(--{colour}) {share}%,transparent)\">{count}</td>"
            );
        }
        rows += "</tr>\n";
    }
    format!(
        "<div class=\"wide\"><table class=\"matrix\">\n<thead>\n<tr><th>there is \\ said</th>{heads}</tr>\n\
         </thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}
