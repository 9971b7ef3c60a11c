//! Numbers as an engineer writes them: a prefix on the unit, significant digits, value ± deviation.

/// A unit and the factor that takes an SI value to it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    /// Multiplies the SI value.
    pub factor: f64,
    /// The unit with its prefix.
    pub unit: String,
}

/// Prefixes that are used, largest first. Above the plain unit there are none: a stroke of 1200 m
/// or a force of 1200 N reads best as it stands.
const PREFIXES: [(f64, &str); 4] = [(1.0, ""), (1e3, "m"), (1e6, "µ"), (1e9, "n")];

/// Power of ten below which a number is written with it.
const LEAST_EXPONENT: i32 = -4;

/// Units that take a prefix. A compound keeps the form that the machine file has.
const PREFIXED: [&str; 8] = ["m", "rad", "s", "A", "V", "N", "N·m", "H"];

impl Scale {
    /// The prefix that brings the largest of `values` (SI, in `unit`) to at least 1. Values that
    /// are not finite do not count; without any the plain unit stays, and where no prefix spares the power of ten.
    pub fn of(unit: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let largest = values
            .into_iter()
            .filter(|value| value.is_finite())
            .fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let (factor, prefix) = if largest > 0.0 && PREFIXED.contains(&unit) {
            // Half a unit in the third digit is rounded up, so 0.9996 belongs to the larger unit.
            PREFIXES
                .into_iter()
                .find(|(factor, _)| largest * factor >= 0.9995)
                .unwrap_or_else(|| {
                    let smallest = PREFIXES[PREFIXES.len() - 1];
                    let plain = exponent(largest * smallest.0, 3) < LEAST_EXPONENT;
                    if plain { PREFIXES[0] } else { smallest }
                })
        } else {
            PREFIXES[0]
        };
        Self {
            factor,
            unit: format!("{prefix}{unit}"),
        }
    }

    /// Percent of one.
    pub fn percent() -> Self {
        Self {
            factor: 100.0,
            unit: "%".into(),
        }
    }

    /// The value to three significant digits, without its unit.
    pub fn number(&self, value: f64) -> String {
        significant(value * self.factor, 3)
    }

    /// The value to three significant digits, with its unit.
    pub fn quantity(&self, value: f64) -> String {
        format!("{} {}", self.number(value), self.unit)
    }
}

/// `value` to `digits` significant digits: `0.0520`, `0.106`, `1234`, and with an exponent below
/// 1e-4 and from 1e6. An error that is not a number comes from a replay that left every bound.
pub(crate) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "diverged".into();
    }
    if value == 0.0 {
        return "0".into();
    }
    let exponent = exponent(value, digits);
    if (LEAST_EXPONENT..6).contains(&exponent) {
        let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
        format!("{value:.decimals$}")
    } else {
        format!("{value:.precision$e}", precision = digits - 1)
    }
}

/// A value from a file: as many digits as it was given with, at most six.
pub(crate) fn given(value: f64) -> String {
    let text = significant(value, 6);
    let (mantissa, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    let mantissa = if mantissa.contains('.') {
        mantissa.trim_end_matches('0').trim_end_matches('.')
    } else {
        mantissa
    };
    format!("{mantissa}{power}")
}

/// As [`estimate`], with a prefix on the unit where that reads better: `504 ± 21 µs`.
pub(crate) fn prefixed_estimate(value: f64, std: f64, unit: &str) -> String {
    let scale = Scale::of(unit, [value]);
    estimate(value * scale.factor, std * scale.factor, &scale.unit)
}

/// `value ± std unit`, the deviation to two digits and the value to the same place:
/// `166.0 ± 1.1 N·s/m`, `(1.203 ± 0.013)e-4 kg·m²`.
pub(crate) fn estimate(value: f64, std: f64, unit: &str) -> String {
    if !value.is_finite() || !std.is_finite() {
        let value = if value.is_finite() {
            significant(value, 4)
        } else {
            "not determined".into()
        };
        return format!("{value} ± not determined {unit}")
            .trim_end()
            .to_owned();
    }
    let largest = value.abs().max(std.abs());
    let power = if largest > 0.0 && !(1e-3..1e6).contains(&largest) {
        exponent(largest, 2)
    } else {
        0
    };
    let shift = 10f64.powi(-power);
    let (value, std) = (value * shift, std * shift);
    // A deviation far below the value would print digits that nobody reads.
    let finest = 5 - exponent(value, 6).min(5);
    let wanted = 1 - exponent(std, 2);
    let (decimals, deviation) = if std != 0.0 && wanted <= finest {
        let decimals = wanted.max(0) as usize;
        (decimals, format!("{std:.decimals$}"))
    } else {
        (finest.max(0) as usize, significant(std, 2))
    };
    let pair = format!("{} ± {deviation}", fixed(value, decimals));
    let text = if power == 0 {
        format!("{pair} {unit}")
    } else {
        format!("({pair})e{power} {unit}")
    };
    text.trim_end().to_owned()
}

/// A probability to two digits, below 0.001 with a power of ten.
pub(crate) fn probability(p: f64) -> String {
    match p {
        _ if !p.is_finite() => "–".into(),
        0.0 => format!("<{:.0e}", f64::MIN_POSITIVE),
        _ if p < 9.995e-4 => format!("{p:.1e}"),
        _ => significant(p, 2),
    }
}

/// The relative change from one value to another, in percent and signed: `-54 %`. `None` where
/// there is nothing to compare with.
pub(crate) fn change(from: f64, to: f64) -> Option<String> {
    let percent = 100.0 * (to - from) / from.abs();
    if !percent.is_finite() {
        return None;
    }
    let left = 100.0 + percent;
    let decimals = if percent.abs() < 9.95 {
        1
    } else if left > 1e-4 && left < 1.0 {
        // −99.95 %, not −100 %: something is left.
        -left.log10().floor() as usize
    } else {
        0
    };
    let text = format!("{percent:+.decimals$} %");
    let is_zero = !text.contains(|digit| ('1'..='9').contains(&digit));
    Some(if is_zero { "0 %".into() } else { text })
}

/// Power of ten of the leading digit after rounding to `digits` digits; 0 for zero.
fn exponent(value: f64, digits: usize) -> i32 {
    let text = format!("{value:.precision$e}", precision = digits - 1);
    text.split_once('e')
        .and_then(|(_, power)| power.parse().ok())
        .unwrap_or(0)
}

/// A number with so many decimals, and no sign before a zero.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.contains(|digit| ('1'..='9').contains(&digit)) {
        text
    } else {
        text.replace('-', "")
    }
}

/// An `f32` as the decimal that a person would write for it: 0.2, not 0.20000000298.
pub fn decimal(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// The text with its first letter in upper case, as the start of a sentence.
pub fn capitalised(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(characters).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_prefix_follows_the_largest_value() {
        let scale = Scale::of("m", [2.91e-4, 5.2e-5, f64::NAN]);
        assert_eq!(scale.unit, "µm");
        assert_eq!(scale.number(5.2e-5), "52.0");
        let scale = Scale::of("rad", [3.1e-3, 5.2e-5]);
        assert_eq!(scale.quantity(5.2e-5), "0.0520 mrad");
        assert_eq!(Scale::of("m", [0.99961e-3]).quantity(0.99961e-3), "1.00 mm");
        assert_eq!(Scale::of("m", [0.0]).quantity(0.0), "0 m");
        assert_eq!(Scale::of("rad", [5.2e-11]).quantity(5.2e-11), "0.0520 nrad");
        assert_eq!(
            Scale::of("rad", [7.27e-17]).quantity(7.27e-17),
            "7.27e-17 rad"
        );
        assert_eq!(Scale::of("kg", [0.02]).unit, "kg");
        assert_eq!(Scale::of("N", [3000.0]).quantity(3000.0), "3000 N");
        assert_eq!(Scale::percent().quantity(0.0398), "3.98 %");
    }

    #[test]
    fn digits_are_significant_ones() {
        assert_eq!(significant(0.05204, 3), "0.0520");
        assert_eq!(significant(0.9996, 3), "1.00");
        assert_eq!(significant(1234.4, 3), "1234");
        assert_eq!(significant(-3.1648, 3), "-3.16");
        assert_eq!(significant(1.25e-7, 2), "1.2e-7");
        assert_eq!(significant(f64::INFINITY, 3), "diverged");
    }

    #[test]
    fn a_declared_value_reads_as_in_its_file() {
        assert_eq!(given(95.0), "95");
        assert_eq!(given(1.2e-4), "0.00012");
        assert_eq!(given(f64::from(2.0e-4_f32)), "0.0002");
        assert_eq!(given(100_000.0), "100000");
        assert_eq!(given(-3.1648), "-3.1648");
        assert_eq!(given(1.5e-7), "1.5e-7");
    }

    #[test]
    fn a_deviation_sets_the_last_digit() {
        assert_eq!(estimate(166.04, 1.1, "N·s/m"), "166.0 ± 1.1 N·s/m");
        assert_eq!(
            estimate(1.2034e-4, 1.3e-6, "kg·m²"),
            "(1.203 ± 0.013)e-4 kg·m²"
        );
        assert_eq!(prefixed_estimate(5.0e-4, 2.0e-5, "s"), "500 ± 20 µs");
        assert_eq!(estimate(5.0e-4, 2.0e-5, "s"), "(5.00 ± 0.20)e-4 s");
        assert_eq!(estimate(-0.5, 12.0, "kg"), "0 ± 12 kg");
        assert_eq!(estimate(95.2, 0.0996, "kg"), "95.20 ± 0.10 kg");
        assert_eq!(estimate(20.0, 0.0, "N"), "20.0000 ± 0 N");
        assert_eq!(estimate(20.0, 1e-9, "N"), "20.0000 ± 1.0e-9 N");
        assert_eq!(estimate(20.0, f64::NAN, "N"), "20.00 ± not determined N");
        assert_eq!(estimate(0.25, 0.01, ""), "0.250 ± 0.010");
    }

    #[test]
    fn small_probabilities_keep_their_power() {
        assert_eq!(probability(0.0123), "0.012");
        assert_eq!(probability(0.0042), "0.0042");
        assert_eq!(probability(1.26e-6), "1.3e-6");
        assert_eq!(probability(0.0), "<2e-308");
    }

    #[test]
    fn a_change_is_signed() {
        assert_eq!(change(0.291, 0.052).unwrap(), "-82 %");
        assert_eq!(change(100.0, 101.25).unwrap(), "+1.2 %");
        assert_eq!(change(-2.0, -3.0).unwrap(), "-50 %");
        assert_eq!(change(1.0, 1.0 - 1e-9).unwrap(), "0 %");
        assert_eq!(change(25.8, 0.014).unwrap(), "-99.95 %");
        assert_eq!(change(1.0, 0.0).unwrap(), "-100 %");
        assert_eq!(change(0.0, 1.0), None);
    }
}
