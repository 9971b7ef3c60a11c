//! Time stamps with a clock: `2026-11-27T06:29:54.123Z`, `27.11.2026 06:29:54,123`, `06:29:54.123 PM`.
//!
//! A column of them becomes seconds since its first row. A date whose order is known (year first, or day first with
//! points) counts days; of any other, and of none, the clock is taken alone, and passes midnight where it
//! jumps by more than half a day: no logger waits as long between two rows.

/// A day, ns.
pub(super) const DAY: i64 = 86_400_000_000_000;
/// A second, ns.
pub(super) const SECOND: i64 = 1_000_000_000;

/// A stamp, ns.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stamp {
    /// Since 1970, by the calendar.
    Calendar(i64),
    /// Since midnight.
    Clock(i64),
}

/// A column of stamps, read row by row.
#[derive(Debug, Clone)]
pub(super) struct Stamps {
    first: i64,
    /// The latest stamp, with the days that its clock has passed.
    last: i64,
}

impl Stamps {
    /// What reads a column from this cell on, if that is a stamp.
    pub fn beginning_with(cell: &str) -> Option<Self> {
        let first = nanoseconds(cell)?;
        Some(Self { first, last: first })
    }

    /// Seconds since the first stamp.
    pub fn read(&mut self, cell: &str) -> Option<f64> {
        self.last = match parse(cell)? {
            Stamp::Calendar(stamp) => stamp,
            Stamp::Clock(clock) => {
                let days = (self.last.saturating_add(DAY / 2) - clock).div_euclid(DAY);
                clock.saturating_add(days * DAY)
            }
        };
        Some(self.last.checked_sub(self.first)? as f64 / SECOND as f64)
    }
}

/// The instant of a time stamp, ns: of two stamps of one form the difference is the time between them, but for midnight.
pub(super) fn nanoseconds(cell: &str) -> Option<i64> {
    let (Stamp::Calendar(instant) | Stamp::Clock(instant)) = parse(cell)?;
    Some(instant)
}

/// Whether a cell is a time stamp.
pub(crate) fn is_stamp(cell: &str) -> bool {
    parse(cell).is_some()
}

/// Whether a cell is a clock of two numbers, `29:54.1`: a spreadsheet shows a time so, and saves what it shows.
pub(super) fn is_cut_clock(cell: &str) -> bool {
    let is_number = |text: &str| !text.is_empty() && text.parse::<f64>().is_ok();
    let numbers = cell.trim().split_once(':');
    numbers.is_some_and(|(one, other)| is_number(one) && is_number(&other.replace(',', ".")))
}

fn parse(cell: &str) -> Option<Stamp> {
    let cell = cell.trim();
    // The clock begins where its hour does.
    let colon = cell.find(':')?;
    let is_digit = |c: char| c.is_ascii_digit();
    let hour = cell[..colon].trim_end_matches(is_digit).len();
    let date = cell[..hour].trim_end_matches(['T', 't', ' ', '_', ',']);
    let (clock, rest) = clock(&cell[hour..])?;
    let clock = match rest.trim().to_ascii_lowercase().trim_matches('.') {
        "" | "z" | "utc" | "gmt" => clock,
        // Twelve o'clock is the first hour of either half.
        "am" | "a.m" => clock % (DAY / 2),
        "pm" | "p.m" => clock % (DAY / 2) + DAY / 2,
        zone => clock - offset(zone)?,
    };
    if date.is_empty() {
        return Some(Stamp::Clock(clock.rem_euclid(DAY)));
    }
    let order = date.find(['-', '/', '.'])?;
    let separator = date[order..].chars().next()?;
    let mut parts = date.split(separator).map(|part| part.parse::<u16>().ok());
    let [a, b, c] = [parts.next()??, parts.next()??, parts.next()??].map(i64::from);
    if parts.next().is_some() {
        return None;
    }
    let day = match separator {
        _ if order == 4 => (a, b, c),
        '.' if c < 100 => (2000 + c, b, a),
        '.' => (c, b, a),
        _ => return Some(Stamp::Clock(clock.rem_euclid(DAY))),
    };
    // Nanoseconds in 64 bits reach three centuries either way.
    let midnight = days(day)?.checked_mul(DAY)?;
    Some(Stamp::Calendar(midnight.checked_add(clock)?))
}

/// Time since midnight, ns, of `06:29:54` or `06:29:54.123`, and what follows it.
fn clock(text: &str) -> Option<(i64, &str)> {
    let (hour, rest) = number(text)?;
    let (minute, rest) = number(rest.strip_prefix(':')?)?;
    let (second, rest) = number(rest.strip_prefix(':')?)?;
    let whole = hour <= 23 && minute <= 59 && second <= 60;
    let whole = whole.then(|| ((hour * 60 + minute) * 60 + second) * SECOND)?;
    // Some loggers write 06:29:54:123.
    let Some(fraction) = rest.strip_prefix(['.', ',', ':']) else {
        return Some((whole, rest));
    };
    let (_, behind) = number(fraction)?;
    let digits = fraction.len() - behind.len();
    let nanoseconds: i64 = format!("{:0<9.9}", &fraction[..digits]).parse().ok()?;
    Some((whole + nanoseconds, behind))
}

/// The number that a text begins with, and what follows it.
fn number(text: &str) -> Option<(i64, &str)> {
    let end = text.bytes().take_while(u8::is_ascii_digit).count();
    Some((text[..end].parse().ok()?, &text[end..]))
}

/// How far a zone's clock is ahead, ns: `+01:00`, `-0530`, `+01`.
fn offset(zone: &str) -> Option<i64> {
    let sign = match zone.chars().next()? {
        '+' => 1,
        '-' => -1,
        _ => return None,
    };
    let digits: String = zone[1..].chars().filter(|c| *c != ':').collect();
    let number: i64 = digits.parse().ok().filter(|n| (0..=1400).contains(n))?;
    let minutes = match digits.len() {
        2 => number * 60,
        4 => number / 100 * 60 + number % 100,
        _ => return None,
    };
    Some(sign * minutes * 60 * SECOND)
}

/// Days since 1970 of a year, month and day of the Gregorian calendar.
fn days((year, month, day): (i64, i64, i64)) -> Option<i64> {
    if !(1..=12).contains(&month) || !(1..=31).contains(&day) {
        return None;
    }
    // A year from March on ends with the day that not every year has: its months' lengths repeat every five.
    let (year, month) = match month {
        1 | 2 => (year - 1, month + 9),
        _ => (year, month - 3),
    };
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    Some(year * 365 + leap_days + (153 * month + 2) / 5 + day - 719_469)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds since the first one of these stamps.
    fn seconds(cells: &[&str]) -> Vec<f64> {
        let mut stamps = Stamps::beginning_with(cells[0]).expect("a stamp");
        let read = cells.iter().map(|cell| stamps.read(cell).expect("a stamp"));
        read.collect()
    }

    #[test]
    fn stamps_become_seconds_since_the_first() {
        for cells in [
            ["2026-11-27T06:29:54.123Z", "2026-11-27T06:29:55.373Z"],
            ["2026-11-27 06:29:54,123", "2026-11-27 06:29:55,373"],
            [
                "2026/11/27 06:29:54.123000000",
                "2026/11/27 06:29:55.373000000",
            ],
            ["27.11.2026 06:29:54,123", "27.11.2026 06:29:55,373"],
            ["11/27/2026 6:29:54.123 AM", "11/27/2026 6:29:55.373 AM"],
            ["06:29:54.123", "06:29:55.373"],
            ["6:29:54:123", "6:29:55:373"],
            // Over midnight, noon, the end of a month and of a leap year's February.
            ["23:59:59.500", "00:00:00.750"],
            ["11:59:59.500 pm", "12:00:00.750 am"],
            ["11:59:59.500 AM", "12:00:00.750 PM"],
            ["31.12.26 23:59:59.500", "01.01.2027 00:00:00.750"],
            ["2024-02-28T23:59:59.5", "2024-02-29T00:00:00.75"],
            ["2024-02-29T23:59:59.5", "2024-03-01T00:00:00.75"],
            // One instant has other clocks in other zones.
            ["2026-11-27T06:29:54.123+01:00", "2026-11-27T05:29:55.373Z"],
            ["2026-11-27T06:29:54.123-0530", "2026-11-27T11:59:55.373Z"],
        ] {
            assert_eq!(seconds(&cells), [0.0, 1.25], "{cells:?}");
        }
        // Rows that came late, before midnight and behind it.
        assert_eq!(
            seconds(&["23:59:59", "00:00:01", "23:59:58", "00:00:02"]),
            [0.0, 2.0, -1.0, 3.0]
        );
        assert_eq!(
            seconds(&["2026-11-27 00:00:00", "2026-11-29 00:00:00"])[1],
            172_800.0
        );
    }

    #[test]
    fn what_is_no_stamp_is_none() {
        for cell in [
            "",
            "12",
            "12.5",
            "06:29",
            "25:00:00",
            "06:61:00",
            "06:29:54.",
            "06:29:54 o'clock",
            "2026-13-01 00:00:00",
            "2026-11 06:29:54",
            "x 06:29:54",
            "9999-01-01 00:00:00",
            "a:b:c",
            "::",
            "9999999999:00:00",
            "1:2:3:4:5",
            "-06:29:54",
            "2026-11-27T06:29:54+99:00",
            "°06:29:54",
        ] {
            assert!(Stamps::beginning_with(cell).is_none(), "{cell}");
        }
    }
}
