//! Lines in which every value has its name in front, as a microcontroller prints them for a plotter, `ms:12 pwm:200`, or as
//! objects of JSON, `{"ms":12,"pwm":200}`.

use super::layout::number;

/// What may stand between a name and its value.
const MARKS: [char; 2] = [':', '='];

/// What may stand between two values.
const BETWEEN: [char; 4] = [',', ';', '\t', ' '];

/// The names, and the text as a table of the values alone, if most of its lines are such. Other lines stay as they are, so that
/// every row keeps the number of its line.
pub(super) fn as_table(lines: &[&str]) -> Option<(Vec<String>, String)> {
    // Nobody reads a whole file to see that its first lines have no names in them.
    const LOOKED_AT: usize = 50;
    let filled = lines.iter().filter(|line| !line.trim().is_empty());
    let first: Vec<_> = filled.take(LOOKED_AT).map(|line| values(line)).collect();
    let names = names(first.iter().flatten().next()?);
    let is_row = |row: &Vec<(&str, &str)>| self::names(row) == names;
    if 2 * first.iter().flatten().filter(|row| is_row(row)).count() <= first.len() {
        return None;
    }
    let table = lines.iter().map(|line| match values(line).filter(is_row) {
        Some(row) => {
            let numbers: Vec<&str> = row.iter().map(|(_, value)| *value).collect();
            numbers.join("\t") + "\n"
        }
        None => format!("{line}\n"),
    });
    let table = table.collect();
    Some((names.into_iter().map(str::to_owned).collect(), table))
}

fn names<'t>(row: &[(&'t str, &'t str)]) -> Vec<&'t str> {
    row.iter().map(|(name, _)| *name).collect()
}

/// The names and values of a line; `None` of one that has anything else, or fewer than two.
fn values(line: &str) -> Option<Vec<(&str, &str)>> {
    let line = line.trim().trim_start_matches('{').trim_end_matches('}');
    let mut row = Vec::new();
    let mut rest = line.trim_matches(BETWEEN);
    while !rest.is_empty() {
        let (name, behind) = rest.split_once(MARKS)?;
        let name = name.trim().trim_matches('"');
        // A clock begins with a digit, and a sentence has words.
        let is_name = name.starts_with(|c: char| c.is_alphabetic() || c == '_');
        if !is_name || name.contains(char::is_whitespace) {
            return None;
        }
        let behind = behind.trim_start();
        let end = behind.find(BETWEEN).unwrap_or(behind.len());
        let value = &behind[..end];
        number(value, false)?;
        row.push((name, value));
        rest = behind[end..].trim_start_matches(BETWEEN);
    }
    (row.len() >= 2).then_some(row)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_in_front_of_values_are_taken_off() {
        for lines in [
            ["ms:0\tpwm:-12\tx:1.5", "ms:1\tpwm:13\tx:2e-3"],
            ["ms:0,pwm:-12,x:1.5", "ms: 1, pwm: 13, x: 2e-3"],
            ["ms=0 pwm=-12 x=1.5", "ms = 1; pwm = 13; x = 2e-3;"],
            [
                "{\"ms\":0,\"pwm\":-12,\"x\":1.5}",
                "{ \"ms\": 1, \"pwm\": 13, \"x\": 2e-3 }",
            ],
        ] {
            let table = as_table(&lines).unwrap_or_else(|| panic!("{lines:?}"));
            let names = ["ms", "pwm", "x"].map(str::to_owned).to_vec();
            assert_eq!(table, (names, "0\t-12\t1.5\n1\t13\t2e-3\n".to_owned()));
        }
        let started = [
            "Ready: go",
            "ms:0 pwm:1",
            "reversing",
            "ms:1 pwm:2",
            "ms:2 pwm:2",
        ];
        let (_, table) = as_table(&started).unwrap();
        assert_eq!(table, "Ready: go\n0\t1\nreversing\n1\t2\n2\t2\n");
    }

    #[test]
    fn other_lines_have_none() {
        for line in ["0,1,2", "12:00:01,2,3", "t: 1", "t:1 of:x", "a b:1 c:2", ""] {
            assert_eq!(as_table(&[line; 9]), None, "{line}");
        }
    }
}
