//! A scanner that knows just enough Rust: comments and literals blanked, test modules cut, paths with their groups spread out.

/// A path as it stands in the code, groups spread out, and its line (from 1).
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPath {
    pub segments: Vec<String>,
    pub line: usize,
}

/// The text with comments, literals and `#[cfg(test)] mod` blocks blanked; line breaks stay.
pub fn product_code(text: &str) -> String {
    cut_test_modules(&blank_comments_and_literals(text))
}

fn blank_comments_and_literals(text: &str) -> String {
    let chars: Vec<char> = text.chars().collect();
    let mut out = String::with_capacity(text.len());
    let mut i = 0;
    while i < chars.len() {
        let end = skip(&chars, i);
        if end > i {
            out.extend(
                chars[i..end]
                    .iter()
                    .map(|&c| if c == '\n' { '\n' } else { ' ' }),
            );
            i = end;
        } else {
            out.push(chars[i]);
            i += 1;
        }
    }
    out
}

/// The end of the comment or literal that begins at `i`; `i` where none does.
fn skip(chars: &[char], i: usize) -> usize {
    let at = |k: usize| chars.get(k).copied().unwrap_or('\0');
    let in_word = i > 0 && (at(i - 1).is_alphanumeric() || at(i - 1) == '_');
    match (at(i), at(i + 1)) {
        ('/', '/') => (i..chars.len())
            .find(|&k| chars[k] == '\n')
            .unwrap_or(chars.len()),
        ('/', '*') => (i + 2..chars.len())
            .find(|&k| at(k) == '*' && at(k + 1) == '/')
            .map_or(chars.len(), |k| k + 2),
        ('r', '"' | '#') if !in_word => {
            let hashes = (i + 1..).take_while(|&k| at(k) == '#').count();
            if at(i + 1 + hashes) != '"' {
                return i;
            }
            let closes = |k: usize| at(k) == '"' && (1..=hashes).all(|h| at(k + h) == '#');
            (i + 2 + hashes..chars.len())
                .find(|&k| closes(k))
                .map_or(chars.len(), |k| k + 1 + hashes)
        }
        ('"', _) => {
            let mut k = i + 1;
            while k < chars.len() && chars[k] != '"' {
                k += if chars[k] == '\\' { 2 } else { 1 };
            }
            (k + 1).min(chars.len())
        }
        // A character, not a lifetime.
        ('\'', '\\') => (i + 3..chars.len())
            .find(|&k| chars[k] == '\'')
            .map_or(chars.len(), |k| k + 1),
        ('\'', _) if at(i + 2) == '\'' => i + 3,
        _ => i,
    }
}

fn cut_test_modules(code: &str) -> String {
    const MARK: &str = "#[cfg(test)]";
    let mut out = String::with_capacity(code.len());
    let mut rest = code;
    while let Some(at) = rest.find(MARK) {
        let after = &rest[at + MARK.len()..];
        out.push_str(&rest[..at]);
        let item = behind_attributes(after);
        let is_module = ["mod ", "pub mod ", "pub(crate) mod ", "pub(super) mod "]
            .iter()
            .any(|m| item.starts_with(m));
        // The module is a file of its own, or stands here between its braces.
        let end = match after.find([';', '{']) {
            Some(at) if is_module && after[at..].starts_with(';') => at + 1,
            Some(at) if is_module => matching_brace(after, at),
            _ => {
                rest = after;
                continue;
            }
        };
        out.extend(after[..end].chars().filter(|c| *c == '\n'));
        rest = &after[end..];
    }
    out.push_str(rest);
    out
}

/// What stands behind more attributes, such as the path of a file.
fn behind_attributes(code: &str) -> &str {
    let mut item = code.trim_start();
    while let Some(end) = item.find(']').filter(|_| item.starts_with("#[")) {
        item = item[end + 1..].trim_start();
    }
    item
}

fn matching_brace(code: &str, open: usize) -> usize {
    let mut depth = 0;
    for (i, c) in code[open..].char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return open + i + 1;
        }
    }
    code.len()
}

/// Every path of two segments or more, and every crate that a `use` names.
pub fn named_paths(code: &str) -> Vec<NamedPath> {
    let tokens = tokens(code);
    let mut found = Vec::new();
    let mut i = 0;
    while i < tokens.len() {
        let starts = is_word(&tokens[i].0) && (i == 0 || tokens[i - 1].0 != "::");
        let goes_on = tokens.get(i + 1).is_some_and(|t| t.0 == "::");
        if starts && goes_on {
            let end = spread(&tokens, i, &[], &mut found);
            i = end.max(i + 1);
        } else {
            i += 1;
        }
    }
    found
}

/// Adds the paths of the tree that begins at token `i`, after `prefix`; returns the token behind it.
fn spread(
    tokens: &[(String, usize)],
    mut i: usize,
    prefix: &[String],
    found: &mut Vec<NamedPath>,
) -> usize {
    let line = tokens[i].1;
    let mut segments = prefix.to_vec();
    loop {
        match tokens.get(i).map(|t| t.0.as_str()) {
            Some("{") => {
                i += 1;
                while let Some((token, _)) = tokens.get(i) {
                    match token.as_str() {
                        "}" => return i + 1,
                        "," => i += 1,
                        _ => i = spread(tokens, i, &segments, found).max(i + 1),
                    }
                }
                return i;
            }
            Some(word) if is_word(word) => segments.push(word.to_owned()),
            Some("*") => {}
            _ => {
                // `a::<T>`: what stands between the brackets is scanned on its own.
                found.push(NamedPath { segments, line });
                return i;
            }
        }
        i += 1;
        if tokens.get(i).is_some_and(|t| t.0 == "::") {
            i += 1;
            continue;
        }
        // `as name` ends a path of a group.
        if tokens.get(i).is_some_and(|t| t.0 == "as") {
            i += 2;
        }
        found.push(NamedPath { segments, line });
        return i;
    }
}

/// Uses of the macros with these names, and their lines.
pub fn macros(code: &str, names: &[&str]) -> Vec<(String, usize)> {
    tokens(code)
        .windows(2)
        .filter(|w| w[1].0 == "!" && names.contains(&w[0].0.as_str()))
        .map(|w| w[0].clone())
        .collect()
}

/// Modules that are declared, and their lines.
pub fn modules(code: &str) -> Vec<(String, usize)> {
    tokens(code)
        .windows(2)
        .filter(|w| w[0].0 == "mod" && is_word(&w[1].0))
        .map(|w| w[1].clone())
        .collect()
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphabetic() || c == '_')
}

/// Words, `::` and single signs with their lines.
fn tokens(code: &str) -> Vec<(String, usize)> {
    let chars: Vec<char> = code.chars().collect();
    let mut found = Vec::new();
    let (mut i, mut line) = (0, 1);
    while i < chars.len() {
        let c = chars[i];
        let start = i;
        if c == '\n' {
            line += 1;
        }
        if c.is_alphanumeric() || c == '_' {
            while i < chars.len() && (chars[i].is_alphanumeric() || chars[i] == '_') {
                i += 1;
            }
        } else if c == ':' && chars.get(i + 1) == Some(&':') {
            i += 2;
        } else {
            i += 1;
        }
        if !c.is_whitespace() {
            found.push((chars[start..i].iter().collect(), line));
        }
    }
    found
}
