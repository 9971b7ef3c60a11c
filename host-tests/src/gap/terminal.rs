//! Text for a terminal: paragraphs broken between words, colours where they are asked for.

/// Columns that a line takes at most, unless a single word is longer.
pub const WIDTH: usize = 100;

/// Text without what would move a terminal's cursor.
pub(super) fn printable(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect()
}

/// A paragraph broken between words. Its own leading spaces stay, further lines have `hang`.
pub(crate) fn wrapped(text: &str, hang: usize) -> Vec<String> {
    let indent = text.len() - text.trim_start().len();
    let mut lines = Vec::new();
    let mut line = " ".repeat(indent);
    let mut columns = indent;
    let mut is_empty = true;
    for word in text.split_whitespace() {
        let length = word.chars().count();
        if !is_empty && columns + 1 + length > WIDTH {
            lines.push(line);
            line = " ".repeat(hang);
            columns = hang;
            is_empty = true;
        }
        if !is_empty {
            line.push(' ');
            columns += 1;
        }
        line += word;
        columns += length;
        is_empty = false;
    }
    lines.push(line);
    lines
}

/// How a line looks where there are colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Style {
    Plain,
    Strong,
    Faint,
    Good,
    Warning,
}

/// What is to be printed.
pub(super) struct Page {
    /// So far, each line with its line feed.
    pub text: String,
    /// Whether styles are ANSI escapes; else they are nothing.
    pub colour: bool,
}

impl Page {
    /// Adds a line, however long it is.
    pub fn line(&mut self, text: &str, style: Style) {
        let code = match style {
            Style::Plain => "",
            Style::Strong => "1",
            Style::Faint => "2",
            Style::Good => "32",
            Style::Warning => "33",
        };
        let text = text.trim_end();
        if self.colour && !code.is_empty() && !text.is_empty() {
            self.text += &format!("\x1b[{code}m{text}\x1b[0m\n");
        } else {
            self.text += text;
            self.text.push('\n');
        }
    }

    /// Adds a heading behind an empty line.
    pub fn section(&mut self, title: &str) {
        self.line("", Style::Plain);
        self.line(title, Style::Strong);
    }

    /// Adds a paragraph, as [`wrapped`] breaks it.
    pub fn wrapped(&mut self, text: &str, hang: usize, style: Style) {
        for line in wrapped(text, hang) {
            self.line(&line, style);
        }
    }
}
