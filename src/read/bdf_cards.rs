//! The cards of a Nastran bulk data deck, put together from their lines: small, wide and free fields, and what goes on.
//!
//! Reference: MSC Nastran quick reference guide, format of bulk data entries.

use super::error::{ReadError, ReadErrorKind};

/// A card: its name in capitals, and its fields behind the name, without those for continuation.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Card {
    /// The line that it begins in, from 1.
    pub line: usize,
    /// Its name without `*`.
    pub name: String,
    /// Its fields, trimmed.
    pub fields: Vec<String>,
}

impl Card {
    /// A field from 0 (behind the name); empty where there is none.
    pub fn field(&self, place: usize) -> &str {
        self.fields.get(place).map_or("", String::as_str)
    }

    /// A whole number; `None` for an empty field.
    pub fn whole(&self, place: usize) -> Result<Option<u64>, ReadError> {
        let field = self.field(place);
        if field.is_empty() {
            return Ok(None);
        }
        let number = field.parse().map(Some);
        number.map_err(|_| self.wrong("a whole number", field))
    }

    /// A real number; `None` for an empty field.
    pub fn real(&self, place: usize) -> Result<Option<f64>, ReadError> {
        let field = self.field(place);
        if field.is_empty() {
            return Ok(None);
        }
        let number = real(field).map(Some);
        number.ok_or_else(|| self.wrong("a real number", field))
    }

    fn wrong(&self, what: &'static str, field: &str) -> ReadError {
        let text = format!("{field} in {} {}", self.name, self.field(0));
        ReadErrorKind::Expected(what, text).line(self.line)
    }
}

/// `1.5`, `1.5E+3`, `1.5D3`, and as Nastran alone writes it, `1.5+3`.
fn real(field: &str) -> Option<f64> {
    if let Ok(number) = field.parse() {
        return Some(number);
    }
    let field = field.to_ascii_uppercase().replace('D', "E");
    if let Ok(number) = field.parse() {
        return Some(number);
    }
    let sign = field.rfind(['+', '-']).filter(|&at| at > 0)?;
    format!("{}E{}", &field[..sign], &field[sign..])
        .parse()
        .ok()
}

/// The cards of a deck one by one, so that a large one is never in memory field by field; executive and case control are left out.
pub(super) fn cards(bytes: &[u8]) -> impl Iterator<Item = Card> {
    let begins = |line: &[u8]| {
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        let mut begins_with = |text: &[u8]| {
            words.next().is_some_and(|w| {
                w.len() >= text.len() && w[..text.len()].eq_ignore_ascii_case(text)
            })
        };
        begins_with(b"BEGIN") && begins_with(b"BULK")
    };
    let lines = || (1..).zip(bytes.split(|&b| b == b'\n'));
    let first = lines()
        .find(|(_, line)| begins(line))
        .map_or(0, |(number, _)| number);
    let mut pieces = (lines().skip(first)).filter_map(|(number, line)| piece(number, line));
    let mut open: Option<Card> = None;
    let mut is_over = false;
    std::iter::from_fn(move || {
        while !is_over {
            match pieces.next() {
                Some((card, true)) if open.is_some() => {
                    if let Some(open) = &mut open {
                        open.fields.extend(card.fields);
                    }
                }
                Some((card, _)) => {
                    is_over = card.name == "ENDDATA";
                    let next = Some(card).filter(|_| !is_over);
                    if let Some(whole) = std::mem::replace(&mut open, next) {
                        return Some(whole);
                    }
                }
                None => is_over = true,
            }
        }
        open.take()
    })
}

/// A line as a card, and whether it goes on with the one before; none for an empty one.
fn piece(number: usize, line: &[u8]) -> Option<(Card, bool)> {
    let line = line.split(|&b| b == b'$').next().unwrap_or_default();
    let text = untabbed(&String::from_utf8_lossy(line));
    let text = text.trim_end();
    if text.is_empty() {
        return None;
    }
    let (name, fields) = split(text);
    let goes_on = name.is_empty() || name.starts_with(['+', '*']);
    let card = Card {
        line: number,
        name: name.trim_end_matches('*').trim().to_ascii_uppercase(),
        fields,
    };
    Some((card, goes_on))
}

/// Name (or mark of continuation) and fields of a line: eight, or four of a wide one.
fn split(line: &str) -> (String, Vec<String>) {
    let owned = |field: &str| field.trim().to_owned();
    if line.contains(',') {
        let mut parts = line.split(',').map(owned);
        let name = parts.next().unwrap_or_default();
        let count = if name.contains('*') { 4 } else { 8 };
        let mut fields: Vec<String> = parts.take(count).collect();
        fields.resize(count, String::new());
        return (name, fields);
    }
    let chars: Vec<char> = line.chars().collect();
    let part = |from: usize, to: usize| -> String {
        let (from, to) = (from.min(chars.len()), to.min(chars.len()));
        owned(&chars[from..to].iter().collect::<String>())
    };
    let name = part(0, 8);
    let fields = match name.contains('*') {
        true => (0..4).map(|k| part(8 + 16 * k, 24 + 16 * k)).collect(),
        false => (1..9).map(|k| part(8 * k, 8 * k + 8)).collect(),
    };
    (name, fields)
}

/// A tab goes on to the next field of eight.
fn untabbed(line: &str) -> String {
    if !line.contains('\t') {
        return line.to_owned();
    }
    let mut out = String::new();
    let mut column = 0;
    for c in line.chars() {
        if c == '\t' {
            let to = (column / 8 + 1) * 8;
            out.extend(std::iter::repeat_n(' ', to - column));
            column = to;
        } else {
            out.push(c);
            column += 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn only(text: &str) -> Card {
        let mut cards: Vec<Card> = cards(text.as_bytes()).collect();
        assert_eq!(cards.len(), 1, "{cards:?}");
        cards.remove(0)
    }

    #[test]
    fn one_card_in_every_form_of_fields() {
        for text in [
            "GRID    7               1.5     -2.0    3.0",
            "GRID*   7                               1.5             -2.0\n*       3.0",
            "GRID*   7                               1.5             -2.0            *A\n*A      3.0",
            "GRID,7,,1.5,-2.0,3.0 $ a comment",
            "GRID*,7,,1.5,-2.0\n*,3.0",
            "GRID\t7\t\t1.5\t-2.0\t3.0",
            "SOL 101\nCEND\nBEGIN BULK\nGRID,7,,15.-1,-2.D0,3.\nENDDATA\nGRID,8",
        ] {
            let card = only(text);
            let (number, system) = (card.whole(0).unwrap(), card.whole(1).unwrap());
            assert_eq!(
                (card.name.as_str(), number, system),
                ("GRID", Some(7), None),
                "{text}"
            );
            let at = [2, 3, 4].map(|k| card.real(k).unwrap().unwrap());
            assert_eq!(at, [1.5, -2.0, 3.0], "{text}");
        }
    }

    #[test]
    fn fields_go_on_behind_the_eighth() {
        for text in [
            "CQUAD4  1       1       1       2       3       4\n                        1.5     1.6     1.7     1.8",
            "CQUAD4,1,1,1,2,3,4\n,,,1.5,1.6,1.7,1.8",
            "CQUAD4  1       1       1       2       3       4                       +A\n+A                      1.5     1.6     1.7     1.8",
        ] {
            let card = only(text);
            assert_eq!(
                [10, 11, 12, 13].map(|k| card.real(k).unwrap()),
                [1.5, 1.6, 1.7, 1.8].map(Some)
            );
        }
    }

    #[test]
    fn numbers_as_nastran_writes_them() {
        for (text, value) in [
            ("7.85-9", 7.85e-9),
            ("1.+3", 1e3),
            (".3", 0.3),
            ("-1.5E2", -150.0),
            ("0.E+0", 0.0),
        ] {
            assert_eq!(real(text), Some(value), "{text}");
        }
        assert_eq!(real("x"), None);
        let card = only("GRID,7,,x,0.,0.");
        assert!(
            card.real(2)
                .unwrap_err()
                .to_string()
                .starts_with("line 1: a real number is expected")
        );
    }
}
