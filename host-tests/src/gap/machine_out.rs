//! `--machine-out`: the user's machine file with what was found. The file's comments, order and formatting
//! stay, but for the head of a file that this program wrote; fitted numbers stand where it declares them,
//! found effects among its `declared_effects`.

use std::path::PathBuf;

use model_core::gap::verdict::Verdict;
use toml_edit::{Array, DocumentMut, Item, TableLike, Value};

use super::answer::mechanism;
use super::declared::{self, numbers};
use super::effect_words::DEVIATIONS;
use super::engine::Found;
use super::outcome::{FittedParameter, FoundEffect, Outcome};
use super::table::AT_LIMIT;
use super::terminal::wrapped;
use crate::data_sheet::UNSURE;
use crate::error::one_line;
use crate::failure::Failure;
use crate::machine::{Machine, Parameter};
use crate::outputs::MARK;
use crate::quantity::significant;

/// What ends a comment of [`note`], behind the declared value.
const UNDETERMINED: &str = "not determined by the logs";
const RAISED: &str = "not fitted, at least coulomb";
const INTERVAL: &str = "95 %: ";

/// Spaces before a comment where there was none.
const BEFORE_COMMENT: &str = "   ";

/// Why there is nothing to write; `None` where there is.
pub(super) fn refusal(verdict: Verdict) -> Option<&'static str> {
    match verdict {
        Verdict::LogAndMachineDisagree => {
            Some("the log and the machine file do not belong together, and nothing was fitted")
        }
        Verdict::NothingProven => {
            Some("nothing is proven, and the fitted numbers stand in for what is missing")
        }
        Verdict::EffectsFound | Verdict::UnknownEffect | Verdict::NoMissingEffect => None,
    }
}

/// The machine file `source`, which `machine` was read from, with what was found on these training logs.
///
/// # Errors
/// A text that would not be read back. None is known.
pub(super) fn text(
    source: &str,
    machine: &Machine,
    train: &[PathBuf],
    found: &Found,
) -> Result<String, Failure> {
    let outcome = &found.report.outcome;
    let failed = |error: String| {
        let file = machine.path.display();
        Failure::other(format!(
            "{file} with what was found is no machine file: {error}"
        ))
    };
    // The editor ends lines with a line feed alone.
    let mut document: DocumentMut = without_head(&source.replace("\r\n", "\n"))
        .parse()
        .map_err(|error: toml_edit::TomlError| failed(error.to_string()))?;
    // With a formula in place of the law that was learned, the numbers are those that were fitted beside the formula; the
    // intervals are those of the others.
    let named = mechanism(&found.trace);
    let model = named.map_or(&found.model, |mechanism| &mechanism.nearest);
    for (parameter, value) in numbers(machine, model, &found.trace.base) {
        let mut fit = outcome.fit.iter();
        let fit = fit.find(|fit| fit.name == parameter.name && named.is_none());
        set_number(&mut document, &parameter, value, fit);
        if fit.is_some_and(|fit| fit.std.is_some() && !fit.at_limit) {
            take_for_sure(&mut document, parameter.name);
        }
    }
    for effect in &outcome.effects {
        declare(&mut document, effect).map_err(failed)?;
    }
    let mut text = head(machine, train, outcome) + &document.to_string();
    if source.contains("\r\n") {
        text = text.replace('\n', "\r\n");
    }
    Machine::of_bytes(&machine.path, text.clone().into_bytes())
        .and_then(|written| declared::model(&written))
        .map_err(|error| failed(error.to_string()))?;
    Ok(text)
}

/// A machine file without the head of a run that wrote it: that would stand below the new one, and say of
/// the new numbers what holds for the old ones.
fn without_head(source: &str) -> &str {
    if !source.starts_with(&format!("# {MARK}")) {
        return source;
    }
    let mut lines = source.split_inclusive('\n');
    let comments = lines.clone().take_while(|line| line.starts_with('#'));
    let block: usize = comments.map(str::len).sum();
    // Where no blank line ends the block, only its first line is ours for sure.
    let first = lines.next().unwrap_or_default().len();
    source[block..]
        .strip_prefix('\n')
        .unwrap_or(&source[first..])
}

/// Who wrote it, from what, and what was concluded.
fn head(machine: &Machine, train: &[PathBuf], outcome: &Outcome) -> String {
    let logs: Vec<String> = train.iter().map(|log| log.display().to_string()).collect();
    let ids: Vec<&str> = outcome.effects.iter().map(|effect| &*effect.id).collect();
    let verdict = match (&outcome.unknown, ids.as_slice()) {
        (None, []) => outcome.verdict.name().to_owned(),
        (None, ids) => format!("{}: {}", outcome.verdict.name(), ids.join(", ")),
        (Some(unknown), _) => format!(
            "{}, it depends on {}. The law of it that was learned from the logs is not in this file: no \
             machine file can declare it",
            outcome.verdict.name(),
            unknown.depends_on
        ),
    };
    let mut paragraphs = vec![
        format!(
            "{MARK} gap from the machine file {}.",
            machine.path.display()
        ),
        format!("Training logs: {}.", logs.join(", ")),
        format!("Verdict: {verdict}."),
    ];
    let freed: Vec<&str> = outcome.freed().collect();
    let named = outcome.with_law();
    let interval = named.map_or(", and its 95 % interval", |_| "");
    paragraphs.push(format!(
        "Behind each fitted number stands what it was{interval}."
    ));
    if let Some(effect) = named {
        paragraphs.push(format!(
            "The law of {} that was learned from the logs is not in this file, for no machine file can declare it. All \
             numbers are those with the formula in its place.",
            effect.id
        ));
    }
    if !freed.is_empty() {
        paragraphs.push(format!(
            "Fitted, though not in [fit]: {}.",
            freed.join(", ")
        ));
    }
    let lines = paragraphs
        .iter()
        .flat_map(|text| wrapped(&one_line(text), 2));
    let lines = lines.map(|line| format!("# {line}\n"));
    lines.collect::<String>() + "\n"
}

/// Sets a number where the file declares it, or adds it to its section, and says what it was.
fn set_number(
    document: &mut DocumentMut,
    parameter: &Parameter,
    value: f64,
    fit: Option<&FittedParameter>,
) {
    // The reader of machine files has required the section.
    let Some(section) = document.get_mut(parameter.section) else {
        return;
    };
    let is_inline = section.is_inline_table();
    let Some(table) = section.as_table_like_mut() else {
        return;
    };
    let declared = table.get_mut(parameter.name).and_then(Item::as_value_mut);
    let was = declared.as_deref().map(bare);
    let note = note(was.as_deref(), fit);
    let number = format!("{value:?}");
    let mut new: Value = number.parse().unwrap_or_else(|_| Value::from(value));
    match declared {
        Some(declared) => {
            *new.decor_mut() = declared.decor().clone();
            *declared = new;
        }
        None => {
            table.insert(parameter.name, Item::Value(new));
        }
    }
    if is_inline {
        // No comment may stand between the numbers of one line.
        if let Some(line) = section.as_value_mut() {
            append_comment(line, Some(parameter.name), &note, 0);
        }
    } else if let Some(line) = table.get_mut(parameter.name).and_then(Item::as_value_mut) {
        let wider = number.len() as isize - was.map_or(0, |was| was.len()) as isize;
        append_comment(line, None, &note, wider);
    }
}

/// Takes a number that was estimated out of `unsure`: by that factor it was off before, and its interval says how sure it is
/// now. What the logs do not determine, or have beyond its limit, stays.
fn take_for_sure(document: &mut DocumentMut, name: &str) {
    const KEY: &str = "unsure";
    let fit = document.get_mut("fit").and_then(Item::as_table_like_mut);
    let Some(fit) = fit else {
        return;
    };
    let unsure = fit.get_mut(KEY).and_then(Item::as_table_like_mut);
    let is_empty = unsure.is_some_and(|unsure| unsure.remove(name).is_some() && unsure.is_empty());
    if is_empty {
        fit.remove(KEY);
    }
}

/// A value as the file has it, without what stands around it.
fn bare(value: &Value) -> String {
    let value = value.clone().decorated("", "");
    value.to_string()
}

/// What a fitted number was, and how sure it is.
fn note(was: Option<&str>, fit: Option<&FittedParameter>) -> String {
    let was = was.unwrap_or("left out");
    let sure = match fit {
        None => RAISED.to_owned(),
        Some(fit) if fit.at_limit => AT_LIMIT.to_owned(),
        Some(fit) => match fit.std {
            Some(std) => format!("{INTERVAL}{}", interval(fit.fitted, std)),
            None => UNDETERMINED.to_owned(),
        },
    };
    format!("was {was}; {sure}")
}

/// `1.180 to 1.240`, to a tenth of the standard deviation.
fn interval(value: f64, std: f64) -> String {
    let (low, high) = (value - DEVIATIONS * std, value + DEVIATIONS * std);
    let power = |number: f64| number.abs().log10().floor();
    let digits = power(low.abs().max(high.abs())) - power(std) + 2.0;
    // Where the deviation is none, as many as single precision has.
    let digits = digits.clamp(2.0, 7.0) as usize;
    format!(
        "{} to {}",
        significant(low, digits),
        significant(high, digits)
    )
}

/// Adds to the comment behind a value, or begins one. A note of an earlier run is replaced. `name`: of the
/// number, where several share the line. `wider`: by how many columns the value has grown; the comment stays
/// in its column where it can.
fn append_comment(value: &mut Value, name: Option<&str>, note: &str, wider: isize) {
    let of = name.map_or(String::new(), |name| format!("{name} "));
    let suffix = value.decor().suffix().and_then(|suffix| suffix.as_str());
    let suffix = suffix.unwrap_or_default();
    let comment = match suffix.split_once('#') {
        Some((space, comment)) => {
            let space = space.len().saturating_add_signed(-wider).max(1);
            let kept = match name {
                Some(name) => without_note_of(name, comment),
                None => without_note(comment).to_owned(),
            };
            let kept = if note.contains(INTERVAL) {
                without_guess(kept.trim_end())
            } else {
                kept.trim_end().to_owned()
            };
            let between = if kept.is_empty() { " " } else { "; " };
            format!("{}#{kept}{between}{of}{note}", " ".repeat(space))
        }
        None => format!("{BEFORE_COMMENT}# {of}{note}"),
    };
    value.decor_mut().set_suffix(comment);
}

/// A comment without how unsure `cargo hil machine` was of its guess: of the fitted number the interval says so. What a
/// number may be off by, `±10 %`, stays: the reader of machine files goes by it, in the next log of a warmer motor too.
fn without_guess(comment: &str) -> String {
    let is_guess = |part: &str| {
        let factor = part.trim_end().strip_prefix(UNSURE);
        factor.is_some_and(|number| number.parse::<f64>().is_ok())
    };
    let kept = comment.split(", ").filter(|part| !is_guess(part));
    kept.collect::<Vec<_>>().join(", ")
}

/// A comment without the [`note`] that it ends with, if it does.
fn without_note(comment: &str) -> &str {
    let Some(at) = comment.rfind("was ") else {
        return comment;
    };
    let (kept, note) = comment.split_at(at);
    let is_note = note
        .split_once("; ")
        .is_some_and(|(_, sure)| ends_note(sure.trim()));
    let kept = kept.trim_end();
    if is_note && (kept.is_empty() || kept.ends_with(';')) {
        kept.trim_end_matches(';')
    } else {
        comment
    }
}

/// A comment without the [`note`] of a number among those of its line, wherever that stands.
fn without_note_of(name: &str, comment: &str) -> String {
    let beginning = format!("{name} was ");
    let mut parts: Vec<&str> = comment.split(';').collect();
    let note = parts.windows(2).position(|pair| {
        let [was, sure] = [pair[0], pair[1]].map(str::trim);
        was.starts_with(&beginning) && ends_note(sure)
    });
    if let Some(at) = note {
        parts.drain(at..at + 2);
    }
    parts.join(";")
}

/// Whether this is what a [`note`] ends with.
fn ends_note(sure: &str) -> bool {
    let is_interval = sure.starts_with(INTERVAL) && !sure.contains(';');
    is_interval || [UNDETERMINED, AT_LIMIT, RAISED].contains(&sure)
}

/// Puts a found effect among the `declared_effects`, in place of one with its id.
///
/// # Errors
/// What the effect's own text is not.
fn declare(document: &mut DocumentMut, effect: &FoundEffect) -> Result<(), String> {
    const KEY: &str = "declared_effects";
    let entry: Value = effect
        .declare
        .parse()
        .map_err(|error: toml_edit::TomlError| error.to_string())?;
    let fit = document.get_mut("fit").and_then(Item::as_table_like_mut);
    let Some(fit) = fit else {
        return Err("it has no [fit]".to_owned());
    };
    let is_it = |entry: &dyn TableLike| {
        let id = entry.get("id").and_then(Item::as_str);
        id == Some(effect.id.as_str())
    };
    match fit.get_mut(KEY) {
        Some(Item::ArrayOfTables(tables)) => {
            let Value::InlineTable(entry) = entry else {
                return Err("an effect is no table".to_owned());
            };
            let place = tables.iter().position(|table| is_it(table));
            match place.and_then(|place| tables.get_mut(place)) {
                // The header and the comments above it stay.
                Some(table) => {
                    for (key, value) in entry {
                        table.insert(&key, Item::Value(value));
                    }
                }
                None => tables.push(entry.into_table()),
            }
        }
        Some(Item::Value(Value::Array(list))) => {
            let place = list.iter().position(|known| {
                let known = known.as_inline_table();
                known.is_some_and(|known| is_it(known))
            });
            match place.and_then(|place| list.get_mut(place)) {
                Some(known) => {
                    let decor = known.decor().clone();
                    *known = entry;
                    *known.decor_mut() = decor;
                }
                None => append(list, entry),
            }
        }
        _ => {
            fit.insert(KEY, Item::Value(Value::Array(Array::from_iter([entry]))));
        }
    }
    Ok(())
}

/// Appends to a list, on a line of its own where the last entry has one.
fn append(list: &mut Array, mut entry: Value) {
    let text = |raw: Option<&toml_edit::RawString>| {
        let raw = raw.and_then(|raw| raw.as_str());
        raw.unwrap_or_default().to_owned()
    };
    let last = list
        .len()
        .checked_sub(1)
        .and_then(|last| list.get_mut(last));
    let Some(last) = last else {
        list.push(entry);
        return;
    };
    let before = text(last.decor().prefix());
    let Some(line_end) = before.rfind('\n') else {
        list.push(entry);
        return;
    };
    let indent = &before[line_end..];
    // What stands behind the last entry, a comment perhaps, belongs to it.
    let behind = text(last.decor().suffix());
    last.decor_mut().set_suffix("");
    let behind = behind + &text(Some(list.trailing()));
    let end = behind.rfind('\n').unwrap_or(behind.len());
    let (comment, end) = behind.split_at(end);
    let comment = comment.trim_end();
    // A comment goes to the end of its line.
    let end = if end.is_empty() { "\n" } else { end };
    entry.decor_mut().set_prefix(format!("{comment}{indent}"));
    entry.decor_mut().set_suffix("");
    list.push_formatted(entry);
    list.set_trailing(end);
    list.set_trailing_comma(true);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::PARAMETERS;

    fn document(text: &str) -> DocumentMut {
        text.parse().unwrap()
    }

    /// A file in which a number was fitted.
    fn with_number(text: &str, name: &str, value: f64, std: Option<f64>) -> String {
        let mut document = document(text);
        let mut known = PARAMETERS.iter();
        let parameter = known.find(|known| known.name == name).unwrap();
        let fit = FittedParameter {
            name: name.to_owned(),
            declared: 0.0,
            fitted: value,
            std,
            unit: String::new(),
            freed: false,
            tolerance: None,
            at_limit: false,
        };
        set_number(&mut document, parameter, value, Some(&fit));
        document.to_string()
    }

    /// A file in which an effect was found.
    fn with_effect(text: &str, id: &str, torque: f64) -> String {
        let mut document = document(text);
        let effect = FoundEffect {
            id: id.to_owned(),
            parameters: Vec::new(),
            declare: format!("{{ id = \"{id}\", torque = {torque:?} }}"),
            score: 1.0,
            identifiability: 1.0,
            p_value: 1e-6,
            law: None,
            equivalent: Vec::new(),
            neglected_inductance: None,
            presumes: Vec::new(),
        };
        declare(&mut document, &effect).unwrap();
        document.to_string()
    }

    #[test]
    fn a_number_is_set_where_it_stands_in_whatever_form() {
        let set = |text: &str| with_number(text, "resistance", 1.21, Some(0.0153));
        // A comment stays in its column.
        assert_eq!(
            set("[motor]\nresistance = 1.050 # Ω\ninductance = 0\n"),
            "[motor]\nresistance = 1.21  # Ω; was 1.050; 95 %: 1.180 to 1.240\ninductance = 0\n"
        );
        assert_eq!(
            set("[motor]\nresistance = 1\n"),
            "[motor]\nresistance = 1.21   # was 1; 95 %: 1.180 to 1.240\n"
        );
        assert_eq!(
            set("motor.resistance = 1.0 # Ω\n"),
            "motor.resistance = 1.21 # Ω; was 1.0; 95 %: 1.180 to 1.240\n"
        );
        assert_eq!(
            set("motor = { resistance = 1.0, inductance = 0.0 } # of the sheet\n"),
            "motor = { resistance = 1.21, inductance = 0.0 } # of the sheet; resistance was 1.0; 95 %: \
             1.180 to 1.240\n"
        );
    }

    #[test]
    fn a_guess_gives_way_to_the_interval_and_a_tolerance_stays() {
        for (comment, kept) in [
            ("Ω, ±10 %", "Ω, ±10 %"),
            ("N·m, unsure by a factor of 1.3", "N·m"),
        ] {
            let text = format!("[motor]\nresistance = 1.2 # {comment}\n");
            let fitted = with_number(&text, "resistance", 1.21, Some(0.0153));
            assert!(
                fitted.contains(&format!("# {kept}; was 1.2; 95 %: 1.180 to 1.240")),
                "{fitted}"
            );
            // What the logs do not determine is as sure as before.
            let left = with_number(&text, "resistance", 1.2, None);
            assert!(left.contains(&format!("# {comment}; was 1.2")), "{left}");
        }
    }

    #[test]
    fn an_estimated_number_is_no_longer_unsure() {
        for [text, one, none] in [
            [
                "[fit]\nparameters = []\nunsure = { inertia = 3.0, viscous = 4.0 } # both\n",
                "[fit]\nparameters = []\nunsure = { viscous = 4.0 } # both\n",
                "[fit]\nparameters = []\n",
            ],
            [
                "[fit]\nparameters = []\n\n[fit.unsure] # both\ninertia = 3.0 # light\nviscous = 4.0\n",
                "[fit]\nparameters = []\n\n[fit.unsure] # both\nviscous = 4.0\n",
                "[fit]\nparameters = []\n",
            ],
            [
                "[fit]\nunsure.inertia = 3.0\nunsure.viscous = 4.0\nparameters = []\n",
                "[fit]\nunsure.viscous = 4.0\nparameters = []\n",
                "[fit]\nparameters = []\n",
            ],
        ] {
            let mut document = document(text);
            take_for_sure(&mut document, "coulomb");
            assert_eq!(document.to_string(), text);
            take_for_sure(&mut document, "inertia");
            assert_eq!(document.to_string(), one);
            take_for_sure(&mut document, "viscous");
            assert_eq!(document.to_string(), none);
        }
    }

    #[test]
    fn a_number_that_was_left_out_is_added_to_its_section() {
        assert_eq!(
            with_number(
                "[mechanics]\ninertia = 1.0 # kg\n\n# dry\n[friction]\n",
                "spring",
                2.5e-9,
                None
            ),
            "[mechanics]\ninertia = 1.0 # kg\nspring = 2.5e-9   # was left out; not determined by the \
             logs\n\n# dry\n[friction]\n"
        );
    }

    #[test]
    fn the_note_of_an_earlier_run_is_replaced_and_nothing_else() {
        for comment in [
            "Ω; was 1.0; 95 %: 1.1 to 1.3",
            "Ω; was 1.0; not determined by the logs",
        ] {
            let text = format!("[motor]\nresistance = 1.2 # {comment}\n");
            assert_eq!(
                with_number(&text, "resistance", 1.3, None),
                "[motor]\nresistance = 1.3 # Ω; was 1.2; not determined by the logs\n"
            );
        }
        for comment in [
            "was 1.0 on the sheet",
            "as it was measured; 95 %: of them",
            "was 1.0; 95 %: 1.1 to 1.3; cold",
        ] {
            let text = format!("[motor]\nresistance = 1.2 # {comment}\n");
            let set = with_number(&text, "resistance", 1.3, None);
            assert!(set.contains(comment), "{set}");
        }
    }

    #[test]
    fn the_notes_of_numbers_in_one_line_are_replaced_each() {
        let set = |text: &str, value: f64| {
            let text = with_number(text, "resistance", value, None);
            with_number(&text, "inductance", value, Some(0.0153))
        };
        for [before, after] in [[" # of the sheet", " # of the sheet; "], ["", "   # "]] {
            let first = set(
                &format!("motor = {{ resistance = 1.0, inductance = 1.1 }}{before}\n"),
                1.2,
            );
            assert_eq!(
                set(&first, 1.3),
                format!(
                    "motor = {{ resistance = 1.3, inductance = 1.3 }}{after}resistance was 1.2; not determined \
                     by the logs; inductance was 1.2; 95 %: 1.270 to 1.330\n"
                )
            );
        }
        let text = "motor = { resistance = 1.0 } # resistance was 0.9 in spring; cold\n";
        let set = with_number(text, "resistance", 1.3, None);
        assert!(
            set.contains("# resistance was 0.9 in spring; cold; resistance was 1.0; "),
            "{set}"
        );
    }

    #[test]
    fn the_head_of_an_earlier_run_goes_and_nothing_else() {
        let body = "# the slide\nname = 's'\n\n[input]\n";
        let gap = format!("# {MARK} gap from the machine file m.toml.\n# Verdict: v.\n\n{body}");
        let identify = format!("# {MARK} identify: steps.\n{body}");
        for text in [body, &gap, &identify] {
            assert_eq!(without_head(text), body);
        }
        for text in [
            "",
            "# mine\n\nname = 's'\n",
            &format!("# mine\n{identify}"),
            &format!("name = '{MARK}'\n"),
        ] {
            assert_eq!(without_head(text), text);
        }
    }

    #[test]
    fn an_effect_is_added_in_whatever_form_the_others_have() {
        let add = |text: &str| with_effect(text, "offset_torque", 0.5);
        let new = "{ id = \"offset_torque\", torque = 0.5 }";
        assert_eq!(
            add("[fit]\nparameters = []\n"),
            format!("[fit]\nparameters = []\ndeclared_effects = [{new}]\n")
        );
        assert_eq!(
            add("[fit]\ndeclared_effects = [] # none\n"),
            format!("[fit]\ndeclared_effects = [{new}] # none\n")
        );
        assert_eq!(
            add("[fit]\ndeclared_effects = [{ id = \"spring\", torque = 1 }]\n"),
            format!("[fit]\ndeclared_effects = [{{ id = \"spring\", torque = 1 }}, {new}]\n")
        );
        // With and without a comma behind the last one.
        for comma in [",", ""] {
            let text = format!(
                "[fit]\ndeclared_effects = [\n  # known\n  {{ id = \"spring\", torque = 1 }}{comma} # soft\n]\n"
            );
            assert_eq!(
                add(&text),
                format!(
                    "[fit]\ndeclared_effects = [\n  # known\n  {{ id = \"spring\", torque = 1 }}, # soft\n  \
                     {new},\n]\n"
                )
            );
        }
        let tables = add("[[fit.declared_effects]] # soft\nid = \"spring\"\ntorque = 1\n");
        assert!(
            tables.starts_with("[[fit.declared_effects]] # soft\nid = \"spring\"\ntorque = 1\n"),
            "{tables}"
        );
        let added = document(&tables);
        let added = added["fit"]["declared_effects"]
            .as_array_of_tables()
            .unwrap();
        assert_eq!(added.get(1).unwrap()["torque"].as_float(), Some(0.5));
    }

    #[test]
    fn an_effect_that_was_declared_is_replaced() {
        let old = "[fit]\ndeclared_effects = [\n  { id = \"spring\", torque = 1 }, # soft\n  { id = \"gravity\" }\n]\n";
        assert_eq!(
            with_effect(old, "spring", 2.0),
            old.replace("torque = 1 ", "torque = 2.0 ")
        );
        let old = "# soft\n[[fit.declared_effects]]\nid = \"spring\"\ntorque = 1\n";
        let new = document(&with_effect(old, "spring", 2.0));
        let tables = new["fit"]["declared_effects"].as_array_of_tables().unwrap();
        assert_eq!(tables.len(), 1);
        assert_eq!(tables.get(0).unwrap()["torque"].as_float(), Some(2.0));
    }
}
