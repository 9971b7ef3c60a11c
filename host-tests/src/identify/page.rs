//! The answer as a page: the table and the characteristic.

use crate::machine::Machine;
use crate::page::{self, Figure, escape};

/// A page with the terminal's text and the drawing, which takes the width of the window.
pub(super) fn html(machine: &Machine, text: &str, svg: String) -> String {
    let figure = Figure {
        statement: "Input over position on the slow log.".into(),
        method: "Filled dots lie on their line, hollow ones do not; all samples grey.".into(),
        keys: Vec::new(),
        svg,
    };
    let body = format!(
        "<header><p class=\"kind\">identified machine</p><h1>{}</h1></header>\n<section><pre>{}</pre></section>\n\
         <section>{}</section>\n",
        escape(&machine.name),
        escape(text),
        figure.html()
    );
    page::page(&format!("{}: six numbers", machine.name), &body, &[])
}
