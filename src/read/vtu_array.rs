//! The numbers of a VTK data array: text, base64 or raw bytes, with zlib blocks or without, of any of VTK's types.
//!
//! Reference: VTK file formats, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use super::error::{ReadError, ReadErrorKind, expected};
use super::xml::Tag;
use flate2::read::ZlibDecoder;
use std::io::Read;

/// How the arrays of a file are written.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coding {
    /// Whether the byte order is the other one.
    pub is_big: bool,
    /// Bytes of a number in the headers of arrays: 4 or 8.
    pub header: usize,
    /// Whether blocks are compressed by zlib.
    pub is_packed: bool,
}

/// Where the bytes of an array stand.
#[derive(Clone, Copy, Debug)]
pub(super) enum Source<'a> {
    /// Numbers as text.
    Text(&'a [u8]),
    /// Base64.
    Base64(&'a [u8]),
    /// Bytes.
    Raw(&'a [u8]),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Float(usize),
    Signed(usize),
    Unsigned(usize),
}

/// A data array that is not yet decoded.
#[derive(Clone, Debug)]
pub(super) struct Array<'a> {
    /// Its name.
    pub name: String,
    /// Numbers a node or a cell.
    pub width: usize,
    kind: Kind,
    /// The byte of the file that it begins at.
    at: usize,
    /// Its bytes.
    pub source: Source<'a>,
}

impl<'a> Array<'a> {
    /// From its tag; the source is still to come.
    pub fn new(tag: &Tag<'_>) -> Result<Self, ReadError> {
        let kind = tag.get("type").unwrap_or_default();
        let kind = match kind {
            "Float32" => Kind::Float(4),
            "Float64" => Kind::Float(8),
            "Int8" => Kind::Signed(1),
            "Int16" => Kind::Signed(2),
            "Int32" => Kind::Signed(4),
            "Int64" => Kind::Signed(8),
            "UInt8" => Kind::Unsigned(1),
            "UInt16" => Kind::Unsigned(2),
            "UInt32" => Kind::Unsigned(4),
            "UInt64" => Kind::Unsigned(8),
            // Strings and bits are never what is looked for; as bytes they do no harm.
            "String" | "Bit" => Kind::Unsigned(1),
            other => return Err(expected("a VTK type of numbers", other.as_bytes()).byte(tag.at)),
        };
        let width = tag.get("NumberOfComponents").map_or(Ok(1), str::parse);
        Ok(Self {
            name: tag.get("Name").unwrap_or_default().to_owned(),
            width: width.ok().filter(|w| *w > 0).unwrap_or(1),
            kind,
            at: tag.at,
            source: Source::Raw(&[]),
        })
    }

    /// All numbers as real ones.
    pub fn reals(&self, coding: Coding) -> Result<Vec<f64>, ReadError> {
        if let Source::Text(text) = self.source {
            return self.words(text, "a number");
        }
        self.decoded(coding, |kind, bytes| match kind {
            Kind::Float(4) => f64::from(f32::from_bits(number(bytes) as u32)),
            Kind::Float(_) => f64::from_bits(number(bytes)),
            Kind::Signed(_) => signed(bytes) as f64,
            Kind::Unsigned(_) => number(bytes) as f64,
        })
    }

    /// All numbers as whole ones.
    pub fn integers(&self, coding: Coding) -> Result<Vec<i64>, ReadError> {
        if let Kind::Float(_) = self.kind {
            let whole = |x: f64| (x == x.trunc() && x.abs() < 1e15).then_some(x as i64);
            let all: Option<Vec<i64>> = self.reals(coding)?.into_iter().map(whole).collect();
            return all
                .ok_or_else(|| expected("whole numbers", self.name.as_bytes()).byte(self.at));
        }
        if let Source::Text(text) = self.source {
            return self.words(text, "a whole number");
        }
        self.decoded(coding, |kind, bytes| match kind {
            Kind::Signed(_) => signed(bytes),
            _ => number(bytes) as i64,
        })
    }

    fn words<T: std::str::FromStr>(
        &self,
        text: &[u8],
        what: &'static str,
    ) -> Result<Vec<T>, ReadError> {
        text.split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
            .map(|word| {
                let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
                number.ok_or_else(|| expected(what, word).byte(self.at))
            })
            .collect()
    }

    /// Each number from its bytes in little-endian order.
    fn decoded<T>(
        &self,
        coding: Coding,
        number: impl Fn(Kind, &[u8]) -> T,
    ) -> Result<Vec<T>, ReadError> {
        let owned;
        let bytes = match self.source {
            Source::Raw(bytes) => bytes,
            Source::Base64(text) => {
                owned = base64(text).map_err(|word| expected("base64", &word).byte(self.at))?;
                &owned
            }
            Source::Text(text) => text,
        };
        let mut data = self.unpacked(bytes, coding)?;
        let (Kind::Float(size) | Kind::Signed(size) | Kind::Unsigned(size)) = self.kind;
        if coding.is_big {
            data.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
        Ok(data
            .chunks_exact(size)
            .map(|c| number(self.kind, c))
            .collect())
    }

    /// The bytes behind the header, inflated where they are packed.
    fn unpacked(&self, bytes: &[u8], coding: Coding) -> Result<Vec<u8>, ReadError> {
        let cut = || ReadErrorKind::Truncated("a data array").byte(self.at);
        let head = |k: usize| -> Result<usize, ReadError> {
            let field = (bytes.get(k * coding.header..(k + 1) * coding.header)).ok_or_else(cut)?;
            let mut field = field.to_vec();
            if coding.is_big {
                field.reverse();
            }
            usize::try_from(number(&field)).map_err(|_| cut())
        };
        // An array without numbers may have no bytes at all.
        if bytes.is_empty() {
            return Ok(Vec::new());
        }
        if !coding.is_packed {
            let end = head(0)?.checked_add(coding.header).ok_or_else(cut)?;
            return Ok(bytes.get(coding.header..end).ok_or_else(cut)?.to_vec());
        }
        let blocks = head(0)?;
        if blocks == 0 {
            return Ok(Vec::new());
        }
        let sizes = bytes.len() / coding.header;
        if blocks > sizes {
            return Err(cut());
        }
        let most = head(1)?.max(head(2)?) as u64;
        let mut at = (3 + blocks) * coding.header;
        let mut out = Vec::new();
        for k in 0..blocks {
            let end = at.checked_add(head(3 + k)?).ok_or_else(cut)?;
            let block = bytes.get(at..end).ok_or_else(cut)?;
            at = end;
            let mut inflated = ZlibDecoder::new(block).take(most);
            inflated.read_to_end(&mut out).map_err(|e| {
                ReadErrorKind::Counts(format!("a zlib block is damaged: {e}")).byte(self.at)
            })?;
        }
        Ok(out)
    }
}

/// Up to eight bytes in little-endian order.
fn number(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .rev()
        .fold(0, |sum, &b| sum << 8 | u64::from(b))
}

fn signed(bytes: &[u8]) -> i64 {
    let unused = 64 - 8 * bytes.len() as u32;
    (number(bytes) << unused) as i64 >> unused
}

/// RFC 4648. Padding may come inside: VTK encodes the header of an array and its data one after the other.
pub(super) fn base64(text: &[u8]) -> Result<Vec<u8>, Vec<u8>> {
    let mut out = Vec::with_capacity(text.len() / 4 * 3);
    let mut bits = 0u32;
    let (mut held, mut padding) = (0, 0);
    for &c in text.iter().filter(|c| !c.is_ascii_whitespace()) {
        let value = match c {
            b'A'..=b'Z' => c - b'A',
            b'a'..=b'z' => c - b'a' + 26,
            b'0'..=b'9' => c - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' => {
                padding += 1;
                0
            }
            other => return Err(vec![other]),
        };
        bits = bits << 6 | u32::from(value);
        held += 1;
        if held == 4 {
            if padding > 2 {
                return Err(b"====".to_vec());
            }
            out.extend_from_slice(&bits.to_be_bytes()[1..4 - padding]);
            (bits, held, padding) = (0, 0, 0);
        }
    }
    // Some writers leave the padding at the end out.
    match held {
        0 => {}
        2 => out.push((bits >> 4) as u8),
        3 => out.extend_from_slice(&((bits >> 2) as u16).to_be_bytes()),
        _ => return Err(b"a single character at the end".to_vec()),
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_rfc_also_without_padding_and_in_two_runs() {
        for (text, plain) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg", "foob"),
            ("Zm9v\nYmE", "fooba"),
            ("Zg==Zm8=", "ffo"),
        ] {
            assert_eq!(base64(text.as_bytes()).unwrap(), plain.as_bytes(), "{text}");
        }
        for bad in ["Z", "Zm9v!", "Z===", "===="] {
            assert!(base64(bad.as_bytes()).is_err(), "{bad}");
        }
    }

    #[test]
    fn small_numbers_keep_their_sign() {
        assert_eq!(signed(&[0xff]), -1);
        assert_eq!(signed(&[0xfe, 0xff, 0xff, 0xff]), -2);
        assert_eq!(signed(&[1, 1]), 257);
    }
}
