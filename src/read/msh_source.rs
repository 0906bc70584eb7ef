//! The numbers of an MSH file, which are the same in text and in binary but for how they stand there.

use super::error::{ReadError, ReadErrorKind, expected};

/// Goes through the file.
pub(super) struct Source<'a> {
    bytes: &'a [u8],
    /// The byte that comes next.
    pub at: usize,
    /// Whether numbers are binary.
    pub is_binary: bool,
    /// Whether their byte order is not that of little-endian machines.
    pub is_swapped: bool,
}

impl<'a> Source<'a> {
    /// At the beginning.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            at: 0,
            is_binary: false,
            is_swapped: false,
        }
    }

    /// Whether nothing is left but blanks.
    pub fn is_over(&self) -> bool {
        self.bytes[self.at..].trim_ascii().is_empty()
    }

    /// An error where the file stands.
    pub fn wrong(&self, kind: ReadErrorKind) -> ReadError {
        kind.byte(self.at)
    }

    /// The rest of the line, trimmed.
    pub fn line(&mut self, what: &'static str) -> Result<&'a [u8], ReadError> {
        let rest = &self.bytes[self.at..];
        if rest.is_empty() {
            return Err(self.wrong(ReadErrorKind::Truncated(what)));
        }
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at = (self.at + end + 1).min(self.bytes.len());
        Ok(rest[..end].trim_ascii())
    }

    /// A number on a line of its own, also in binary files.
    pub fn count_line(&mut self, what: &'static str) -> Result<usize, ReadError> {
        let start = self.at;
        let line = self.line(what)?;
        let text = std::str::from_utf8(line).ok();
        let count = text.and_then(|t| t.split_ascii_whitespace().next()?.parse().ok());
        count.ok_or_else(|| expected("a count", line).byte(start))
    }

    /// The mark that ends a section.
    pub fn end(&mut self, mark: &'static [u8]) -> Result<(), ReadError> {
        let start = self.at;
        let mut line = self.line("a section")?;
        if line.is_empty() {
            line = self.line("a section")?;
        }
        if line == mark {
            return Ok(());
        }
        Err(expected("the end of a section", line).byte(start))
    }

    /// Over everything up to the end of this section.
    pub fn skip(&mut self, name: &[u8]) -> Result<(), ReadError> {
        let mark = [b"$End", name].concat();
        let found = self.bytes[self.at..]
            .windows(mark.len())
            .position(|w| w == mark);
        let Some(found) = found else {
            return Err(self.wrong(ReadErrorKind::Truncated("a section")));
        };
        self.at += found;
        self.line("a section").map(|_| ())
    }

    /// A whole number of 4 bytes.
    pub fn int(&mut self, what: &'static str) -> Result<i64, ReadError> {
        match self.is_binary {
            true => Ok(i64::from(i32::from_le_bytes(self.array(what)?))),
            false => self.word(what),
        }
    }

    /// A whole number of 8 bytes.
    pub fn size(&mut self, what: &'static str) -> Result<u64, ReadError> {
        match self.is_binary {
            true => Ok(u64::from_le_bytes(self.array(what)?)),
            false => self.word(what),
        }
    }

    /// A real number.
    pub fn real(&mut self, what: &'static str) -> Result<f64, ReadError> {
        match self.is_binary {
            true => Ok(f64::from_le_bytes(self.array(what)?)),
            false => self.word(what),
        }
    }

    /// A count of things that take a byte each at least: never more than the file has left.
    pub fn count(&mut self, what: &'static str) -> Result<usize, ReadError> {
        let start = self.at;
        let count = self.size(what)?;
        let room = self.bytes.len() - self.at;
        match usize::try_from(count) {
            Ok(n) if n <= room => Ok(n),
            _ => {
                let told = format!("{count} {what} cannot be in what is left of the file");
                Err(ReadErrorKind::Counts(told).byte(start))
            }
        }
    }

    fn array<const N: usize>(&mut self, what: &'static str) -> Result<[u8; N], ReadError> {
        let Some(chunk) = self.bytes[self.at..].first_chunk::<N>() else {
            return Err(self.wrong(ReadErrorKind::Truncated(what)));
        };
        self.at += N;
        let mut chunk = *chunk;
        if self.is_swapped {
            chunk.reverse();
        }
        Ok(chunk)
    }

    fn word<T: std::str::FromStr>(&mut self, what: &'static str) -> Result<T, ReadError> {
        let rest = &self.bytes[self.at..];
        let blank = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        let length = rest[blank..]
            .iter()
            .take_while(|b| !b.is_ascii_whitespace())
            .count();
        let word = &rest[blank..blank + length];
        if word.is_empty() {
            return Err(self.wrong(ReadErrorKind::Truncated(what)));
        }
        let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        let number = number.ok_or_else(|| expected(what, word).byte(self.at + blank))?;
        self.at += blank + length;
        Ok(number)
    }
}
