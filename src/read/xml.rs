//! As much XML as VTK's files are made of: elements with attributes, text, comments and declarations.
//!
//! Limits: no document type definitions, no CDATA, no entities but the five of XML in attributes.
//!
//! Reference: W3C, Extensible Markup Language (XML) 1.0, fifth edition, 2008.

use super::error::{ReadError, ReadErrorKind};

/// What comes next in a document.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Event<'a> {
    /// An element begins.
    Open(Tag<'a>),
    /// An element ends.
    Close(&'a [u8]),
    /// Text between two tags, with the byte that it begins at.
    Text(usize, &'a [u8]),
}

/// The beginning of an element.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tag<'a> {
    /// Its name.
    pub name: &'a [u8],
    /// Its attributes.
    attributes: Vec<(&'a [u8], String)>,
    /// Whether it ends at once.
    pub is_empty: bool,
    /// The byte that it begins at.
    pub at: usize,
}

impl Tag<'_> {
    /// The value of an attribute.
    pub fn get(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(n, _)| *n == name.as_bytes());
        found.map(|(_, value)| value.as_str())
    }
}

/// Goes through a document from tag to tag.
pub(super) struct Reader<'a> {
    bytes: &'a [u8],
    /// The byte that comes next.
    pub at: usize,
}

impl<'a> Reader<'a> {
    /// At the beginning of a document.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The next event; none at the end.
    pub fn next(&mut self) -> Result<Option<Event<'a>>, ReadError> {
        loop {
            let start = self.at;
            let rest = &self.bytes[start..];
            let Some(&first) = rest.first() else {
                return Ok(None);
            };
            if first != b'<' {
                let end = rest.iter().position(|&b| b == b'<').unwrap_or(rest.len());
                self.at += end;
                return Ok(Some(Event::Text(start, &rest[..end])));
            }
            if rest.starts_with(b"<!--") {
                self.skip(b"-->")?;
            } else if rest.starts_with(b"<?") {
                self.skip(b"?>")?;
            } else if rest.starts_with(b"<!") {
                self.skip(b">")?;
            } else {
                return self.tag().map(Some);
            }
        }
    }

    fn skip(&mut self, end: &[u8]) -> Result<(), ReadError> {
        let rest = &self.bytes[self.at..];
        match rest.windows(end.len()).position(|w| w == end) {
            Some(found) => {
                self.at += found + end.len();
                Ok(())
            }
            None => Err(self.cut()),
        }
    }

    fn cut(&self) -> ReadError {
        ReadErrorKind::Truncated("an XML tag").byte(self.bytes.len())
    }

    fn tag(&mut self) -> Result<Event<'a>, ReadError> {
        let start = self.at;
        let end = self.tag_end()?;
        let inside = &self.bytes[start + 1..end];
        self.at = end + 1;
        if let Some(name) = inside.strip_prefix(b"/") {
            return Ok(Event::Close(name.trim_ascii()));
        }
        let (inside, is_empty) = match inside.strip_suffix(b"/") {
            Some(inside) => (inside, true),
            None => (inside, false),
        };
        let split = |text: &[u8]| text.iter().position(u8::is_ascii_whitespace);
        let name_end = split(inside).unwrap_or(inside.len());
        let mut tag = Tag {
            name: &inside[..name_end],
            attributes: Vec::new(),
            is_empty,
            at: start,
        };
        let mut rest = inside[name_end..].trim_ascii();
        while !rest.is_empty() {
            let bad = || super::error::expected("an attribute name=\"value\"", rest).byte(start);
            let equals = rest.iter().position(|&b| b == b'=').ok_or_else(bad)?;
            let name = rest[..equals].trim_ascii();
            let value = rest[equals + 1..].trim_ascii_start();
            let quote = *value
                .first()
                .filter(|q| matches!(q, b'"' | b'\''))
                .ok_or_else(bad)?;
            let length = value[1..]
                .iter()
                .position(|&b| b == quote)
                .ok_or_else(bad)?;
            tag.attributes
                .push((name, unescaped(&value[1..1 + length])));
            rest = value[length + 2..].trim_ascii_start();
        }
        Ok(Event::Open(tag))
    }

    /// The `>` of the tag that begins here, not one inside quotes.
    fn tag_end(&self) -> Result<usize, ReadError> {
        let mut quote = None;
        for (k, &b) in self.bytes.iter().enumerate().skip(self.at) {
            match (quote, b) {
                (None, b'>') => return Ok(k),
                (None, b'"' | b'\'') => quote = Some(b),
                (Some(open), b) if open == b => quote = None,
                _ => {}
            }
        }
        Err(self.cut())
    }
}

fn unescaped(value: &[u8]) -> String {
    let text = String::from_utf8_lossy(value);
    if !text.contains('&') {
        return text.into_owned();
    }
    text.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&quot;", "\"")
        .replace("&apos;", "'")
        .replace("&amp;", "&")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_text_and_attributes_are_told_apart() {
        let text = b"<?xml version=\"1.0\"?>\n<!-- <a> --><A n='1' m = \"x &gt; &quot;y&quot; >\">text<B/></A>";
        let mut reader = Reader::new(text);
        let mut seen = Vec::new();
        while let Some(event) = reader.next().unwrap() {
            seen.push(event);
        }
        let [
            Event::Text(_, b"\n"),
            Event::Open(a),
            Event::Text(_, b"text"),
            Event::Open(b),
            Event::Close(b"A"),
        ] = seen.as_slice()
        else {
            panic!("{seen:?}")
        };
        assert_eq!((a.get("n"), a.get("m")), (Some("1"), Some("x > \"y\" >")));
        assert!(b.is_empty && b.name == b"B" && a.get("o").is_none());
    }

    #[test]
    fn what_is_cut_short_is_an_error() {
        for text in [&b"<A"[..], b"<!-- ", b"<A b>", b"<A b=c>", b"<A b=\"c>"] {
            let mut reader = Reader::new(text);
            assert!(reader.next().is_err(), "{}", String::from_utf8_lossy(text));
        }
    }
}
