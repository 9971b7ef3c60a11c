//! A section of the report: what a topic shows, on the page and on a terminal.

use crate::cells::{Cells, render};
use crate::page::{Figure, escape, table};
use crate::reproduce::Entry;

/// What a topic gives.
pub(crate) struct Section {
    /// Its title.
    pub title: &'static str,
    /// One sentence: what came out.
    pub finding: String,
    /// In the order of the page.
    pub parts: Vec<Part>,
    /// What it adds to the JSON.
    pub entries: Vec<Entry>,
}

/// A part of a section.
pub(crate) enum Part {
    /// A paragraph.
    Note(String),
    /// A table and what it shows.
    Table(String, Cells),
    /// A figure; a terminal shows none.
    Figure(Figure),
}

impl Section {
    /// As a `<section>` of the page.
    pub(super) fn html(&self) -> String {
        let parts: String = self.parts.iter().map(Part::html).collect();
        format!(
            "<section>\n<h2>{}</h2>\n<p>{}</p>\n{parts}</section>\n",
            escape(self.title),
            escape(&self.finding)
        )
    }

    /// For a terminal.
    pub(super) fn text(&self) -> String {
        let parts: String = self.parts.iter().map(Part::text).collect();
        format!("{}\n{}\n\n{parts}", self.title, self.finding)
    }
}

impl Part {
    fn html(&self) -> String {
        match self {
            Self::Note(note) => format!("<p class=\"note\">{}</p>\n", escape(note)),
            Self::Table(title, cells) => format!("<h3>{}</h3>\n{}", escape(title), table(cells)),
            Self::Figure(figure) => figure.html(),
        }
    }

    fn text(&self) -> String {
        match self {
            Self::Note(note) => format!("note: {note}\n\n"),
            Self::Table(title, cells) => format!("{title}\n{}\n", render(cells)),
            Self::Figure(_) => String::new(),
        }
    }
}
