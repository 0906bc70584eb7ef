//! TOML as text into values, and where in the text a value stands: the home of the `toml` crate.

use serde::de::DeserializeOwned;
pub use toml::Spanned;

/// Reads a text; the message of an error tells the line, and the names that are known where one is not.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    toml::from_str(text).map_err(|e| e.to_string().trim().to_owned())
}

/// The line, from 1, on which a value begins in the text that it was read from.
pub fn line<T>(text: &str, value: &Spanned<T>) -> usize {
    let before = text.get(..value.span().start).unwrap_or(text);
    before.matches('\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn values_know_their_line() {
        let text = "# zwölf\na = 1\n\n[b]\nc = 2\n";
        #[derive(serde::Deserialize)]
        struct All {
            a: Spanned<i32>,
            b: BTreeMap<String, Spanned<i32>>,
        }
        let all: All = parse(text).unwrap();
        assert_eq!((line(text, &all.a), line(text, &all.b["c"])), (2, 5));
        assert!(parse::<All>("a = [").err().unwrap().contains("line 1"));
    }
}
