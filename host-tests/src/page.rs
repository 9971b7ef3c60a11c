//! One HTML file that needs nothing beside it: its frame, its figures and how they are drawn.

use crate::outputs::MARK;

pub(crate) mod heat_map;
pub(crate) mod plot;
pub(crate) mod series;

const STYLE: &str = include_str!("page/style.css");

/// A page with a title, the body of its `<main>` and the paragraphs of its foot. The body is HTML,
/// the others are text.
pub(crate) fn page(title: &str, body: &str, foot: &[String]) -> String {
    let foot: String = foot
        .iter()
        .map(|text| format!("<p>{}</p>", escape(text)))
        .collect();
    format!(
        "<!DOCTYPE html>\n<!-- {MARK} -->\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta \
         name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n\
         <style>\n{}{STYLE}</style>\n</head>\n<body>\n<main>\n{body}\
         <footer>{foot}</footer>\n</main>\n</body>\n</html>\n",
        escape(title),
        plot::theme(),
    )
}

/// A picture and what it says.
pub(crate) struct Figure {
    /// One sentence: what there is to see.
    pub statement: String,
    /// How it was made.
    pub method: String,
    /// The keys of the colours, as classes of the style sheet, and what they stand for.
    pub keys: Vec<(&'static str, &'static str)>,
    /// The `<svg>` element.
    pub svg: String,
}

impl Figure {
    /// As a `<figure>` of the page.
    pub(crate) fn html(&self) -> String {
        let keys: String = self
            .keys
            .iter()
            .map(|(class, name)| format!("<span class=\"{class}\">{name}</span>"))
            .collect();
        format!(
            "<figure>\n<figcaption><b>{}</b> {}\n<div class=\"keys\">{keys}</div></figcaption>\n{}\
         </figure>\n",
            escape(&self.statement),
            escape(&self.method),
            self.svg
        )
    }
}

/// A table of cells; the first row is its head, the first column its names.
pub(crate) fn table(rows: &[Vec<String>]) -> String {
    let Some((head, body)) = rows.split_first() else {
        return String::new();
    };
    let cells = |row: &[String], tag: &str| -> String {
        let cell = |(index, cell): (usize, &String)| {
            let class = if index == 0 { "" } else { " class=\"n\"" };
            format!("<{tag}{class}>{}</{tag}>", escape(cell))
        };
        row.iter().enumerate().map(cell).collect()
    };
    let body: String = body
        .iter()
        .map(|row| format!("<tr>{}</tr>\n", cells(row, "td")))
        .collect();
    format!(
        "<div class=\"wide\"><table>\n<thead>\n<tr>{}</tr>\n</thead>\n<tbody>\n{body}</tbody>\n\
         </table></div>\n",
        cells(head, "th")
    )
}

/// Text as HTML and its attributes hold it.
pub(crate) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            // No control character but white space may stand in a page.
            c if c.is_control() && !c.is_whitespace() => {}
            c => escaped.push(c),
        }
    }
    escaped
}
