//! Numbers as text: the shortest that reads back to the same `f64`, or the most digits that a field holds.

/// How a dialect writes a real number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// `0.0015`, `1.5e-9`.
    Plain,
    /// `.0015`, `1.5-9`: no leading zero and no exponent letter.
    Nastran,
}

/// The shortest text that reads back to `value` exactly; `-0` is written as `0.0`.
pub(super) fn shortest(value: f64) -> String {
    format!("{:?}", value + 0.0)
}

/// `value` in at most `width` characters, and whether that text reads back to it exactly. Digits are cut, rounded, only where they must be. `width` is 8 or more.
pub(super) fn fitted(value: f64, width: usize, style: Style) -> (String, bool) {
    let mut best = String::new();
    // Seventeen digits tell every f64 from its neighbours.
    for kept in (1..=17).rev() {
        let exact = format!("{value:e}");
        let scientific = if kept == 17 {
            exact
        } else {
            format!("{:.*e}", kept - 1, value)
        };
        let decimal = Decimal::parse(&scientific);
        for text in decimal.texts(style) {
            best = text;
            if best.len() <= width {
                return (best, kept == 17);
            }
        }
    }
    (best, false)
}

/// A number as sign, significant digits without trailing zeros, and the power of ten of the first one.
struct Decimal {
    negative: bool,
    digits: String,
    exponent: i32,
}

impl Decimal {
    /// From Rust's `{:e}` notation.
    fn parse(scientific: &str) -> Self {
        let (mantissa, exponent) = scientific.split_once('e').unwrap_or((scientific, "0"));
        let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
        let digits = digits.trim_end_matches('0');
        let zero = digits.is_empty();
        Self {
            negative: mantissa.starts_with('-') && !zero,
            digits: if zero { "0".into() } else { digits.into() },
            exponent: if zero {
                0
            } else {
                exponent.parse().unwrap_or(0)
            },
        }
    }

    /// Both notations, first the one that people read more easily.
    fn texts(&self, style: Style) -> Vec<String> {
        let scientific = self.scientific(style);
        match self.exponent {
            -5..=15 => vec![self.fixed(style), scientific],
            // Beyond these powers of ten fixed point is longer than any field.
            -20..=20 => vec![scientific, self.fixed(style)],
            _ => vec![scientific],
        }
    }

    fn fixed(&self, style: Style) -> String {
        let mut text = String::from(if self.negative { "-" } else { "" });
        if self.exponent < 0 {
            if style == Style::Plain {
                text.push('0');
            }
            text.push('.');
            text.extend((1..-self.exponent).map(|_| '0'));
            text.push_str(&self.digits);
            return text;
        }
        let whole = self.exponent as usize + 1;
        if self.digits.len() > whole {
            text.push_str(&self.digits[..whole]);
            text.push('.');
            text.push_str(&self.digits[whole..]);
        } else {
            text.push_str(&self.digits);
            text.extend((self.digits.len()..whole).map(|_| '0'));
            text.push('.');
            if style == Style::Plain {
                text.push('0');
            }
        }
        text
    }

    fn scientific(&self, style: Style) -> String {
        let sign = if self.negative { "-" } else { "" };
        let (first, rest) = self.digits.split_at(1);
        match style {
            Style::Plain if rest.is_empty() => format!("{sign}{first}e{}", self.exponent),
            Style::Plain => format!("{sign}{first}.{rest}e{}", self.exponent),
            Style::Nastran => format!("{sign}{first}.{rest}{:+}", self.exponent),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Reads a Nastran real: an exponent may follow without its letter.
    fn read_nastran(text: &str) -> f64 {
        let split = text[1..].find(['+', '-']).map(|at| at + 1);
        match split {
            Some(at) => format!("{}e{}", &text[..at], &text[at..]).parse().unwrap(),
            None => text.parse().unwrap(),
        }
    }

    #[test]
    fn the_forms_are_those_of_the_dialect() {
        let nastran = |value: f64, width: usize| fitted(value, width, Style::Nastran);
        assert_eq!(nastran(1.0, 8), ("1.".into(), true));
        assert_eq!(nastran(-0.5, 8), ("-.5".into(), true));
        assert_eq!(nastran(0.0, 8), ("0.".into(), true));
        assert_eq!(nastran(7.85e-9, 8), ("7.85-9".into(), true));
        assert_eq!(nastran(210_000.0, 8), ("210000.".into(), true));
        assert_eq!(nastran(1.0 / 3.0, 8), (".3333333".into(), false));
        assert_eq!(nastran(-1.0 / 3.0, 16), ("-.33333333333333".into(), false));
        assert_eq!(nastran(1e100, 8), ("1.+100".into(), true));
        assert_eq!(nastran(0.999_999_999, 8), ("1.".into(), false));
        let plain = |value: f64| fitted(value, 20, Style::Plain);
        assert_eq!(plain(5.0), ("5.0".into(), true));
        assert_eq!(plain(7.85e-9), ("7.85e-9".into(), true));
        assert_eq!(plain(-1.234_567_890_123_456_7e-3).0, "-0.00123456789012346");
        assert_eq!(
            (shortest(-0.0), shortest(0.1)),
            ("0.0".into(), "0.1".into())
        );
    }

    proptest! {
        #[test]
        fn twenty_characters_keep_fourteen_digits(value in prop::num::f64::NORMAL) {
            let (text, exact) = fitted(value, 20, Style::Plain);
            prop_assert!(text.len() <= 20);
            let read: f64 = text.parse().unwrap();
            // Rounding the greatest numbers up may leave the range.
            prop_assert!(read.is_infinite() || ((read - value) / value).abs() < 1e-13);
            prop_assert!(!exact || read == value);
        }

        #[test]
        fn a_coordinate_in_sixteen_characters_keeps_twelve_digits(value in -1e4f64..1e4) {
            let (text, exact) = fitted(value, 16, Style::Nastran);
            prop_assert!(text.len() <= 16 && text.contains('.'));
            let read = read_nastran(&text);
            prop_assert!((read - value).abs() <= 1e-11 * value.abs());
            prop_assert!(!exact || read == value);
        }

        #[test]
        fn shortest_is_exact(value in prop::num::f64::NORMAL) {
            prop_assert_eq!(shortest(value).parse::<f64>().unwrap(), value);
        }
    }
}
