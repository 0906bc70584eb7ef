//! A reader of PLY: ASCII and both binary byte orders.
//!
//! Of the elements `vertex` (its `x`, `y`, `z`) and `face` (its `vertex_indices` or `vertex_index`) are taken, all others are passed over by their
//! declared properties. Polygons are cut into triangles.
//!
//! Guarantees: no panic, whatever the bytes are; a count is held against the bytes that are left before anything is allocated for it; all coordinates are finite and all corners exist.
//! Limits: triangle strips (`tristrips`) are not read.
//!
//! Reference: G. Turk, The PLY polygon file format, Stanford 1994.

use glam::DVec3;

use super::soup::{Place, ReadError, ReadErrorKind, Soup, triangulate};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

#[derive(Clone, Debug)]
struct Property {
    name: String,
    /// Type of the count, where it is a list.
    count: Option<Scalar>,
    value: Scalar,
}

#[derive(Clone, Debug)]
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    /// Fewest bytes that one takes; in text at least a digit and a space a property.
    fn least(&self, encoding: Encoding) -> u64 {
        let of = |p: &Property| match encoding {
            Encoding::Ascii => 2,
            _ => p.count.unwrap_or(p.value).size() as u64,
        };
        self.properties.iter().map(of).sum::<u64>().max(1)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    encoding: Encoding,
}

/// Reads a whole file.
pub fn parse_ply(bytes: &[u8]) -> Result<Soup, ReadError> {
    let mut reader = Reader {
        bytes,
        at: 0,
        line: 0,
        encoding: Encoding::Ascii,
    };
    let elements = reader.header()?;
    let mut soup = Soup::default();
    let mut polygons = false;
    for element in &elements {
        let room = (bytes.len() - reader.at) as u64;
        // The last number of a text may end the file, without a space behind it.
        if element.count.saturating_mul(element.least(reader.encoding)) > room + 1 {
            return Err(reader.error(ReadErrorKind::Count {
                what: "entries of an element",
                count: element.count,
            }));
        }
        match element.name.as_str() {
            "vertex" => reader.vertices(element, &mut soup)?,
            "face" => {
                polygons = true;
                reader.faces(element, &mut soup)?;
            }
            _ => {
                for _ in 0..element.count {
                    for property in &element.properties {
                        reader.values(property, |_| {})?;
                    }
                }
            }
        }
    }
    if !polygons || soup.triangles.is_empty() {
        return Err(reader.error(ReadErrorKind::NoFacet));
    }
    Ok(soup)
}

impl<'a> Reader<'a> {
    fn error(&self, kind: ReadErrorKind) -> ReadError {
        let place = match self.encoding {
            Encoding::Ascii => Place::Line(self.line.max(1)),
            _ => Place::Byte(self.at),
        };
        ReadError { place, kind }
    }

    fn header_line(&mut self) -> Result<&'a str, ReadError> {
        let rest = &self.bytes[self.at..];
        self.line += 1;
        let end = rest
            .iter()
            .position(|&b| b == b'\n')
            .ok_or_else(|| ReadError::line(self.line, ReadErrorKind::Truncated("the header")))?;
        self.at += end + 1;
        std::str::from_utf8(rest[..end].trim_ascii())
            .map_err(|_| ReadError::line(self.line, ReadErrorKind::Header("is no text")))
    }

    fn header(&mut self) -> Result<Vec<Element>, ReadError> {
        if !self.bytes.starts_with(b"ply") || self.header_line()? != "ply" {
            return Err(ReadError::line(1, ReadErrorKind::Expected("'ply'")));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let line = self.header_line()?;
            let bad = |what| ReadError::line(self.line, ReadErrorKind::Header(what));
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words[..] {
                [] | ["comment", ..] | ["obj_info", ..] => {}
                ["format", kind, "1.0"] => {
                    encoding = Some(match kind {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Little,
                        "binary_big_endian" => Encoding::Big,
                        _ => return Err(bad("names an unknown format")),
                    });
                }
                ["element", name, count] => elements.push(Element {
                    name: name.to_owned(),
                    count: count
                        .parse()
                        .map_err(|_| bad("has an element without a count"))?,
                    properties: Vec::new(),
                }),
                ["property", ref kind @ .., name] => {
                    let (count, value) = match *kind {
                        ["list", count, value] => (Scalar::named(count), Scalar::named(value)),
                        [value] => (None, Scalar::named(value)),
                        _ => return Err(bad("has a property of an unknown form")),
                    };
                    let list = kind.len() == 3;
                    let (Some(value), true) = (value, count.is_some() == list) else {
                        return Err(bad("has a property of an unknown type"));
                    };
                    let element = elements
                        .last_mut()
                        .ok_or_else(|| bad("has a property before any element"))?;
                    element.properties.push(Property {
                        name: name.to_owned(),
                        count,
                        value,
                    });
                }
                ["end_header"] => break,
                _ => return Err(bad("has a line that is not known")),
            }
        }
        self.encoding = encoding
            .ok_or_else(|| ReadError::line(self.line, ReadErrorKind::Header("names no format")))?;
        // The data begin on the next line.
        self.line += 1;
        Ok(elements)
    }

    fn word(&mut self) -> Result<&'a str, ReadError> {
        let rest = &self.bytes[self.at..];
        let skipped = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
        self.line += rest[..skipped].iter().filter(|&&b| b == b'\n').count();
        let rest = &rest[skipped..];
        let length = rest.iter().take_while(|b| !b.is_ascii_whitespace()).count();
        if length == 0 {
            return Err(self.error(ReadErrorKind::Truncated("the data")));
        }
        self.at += skipped + length;
        std::str::from_utf8(&rest[..length])
            .map_err(|_| self.error(ReadErrorKind::Expected("a number")))
    }

    fn raw<const N: usize>(&mut self) -> Result<[u8; N], ReadError> {
        let Some(chunk) = self.bytes[self.at..].first_chunk::<N>() else {
            return Err(self.error(ReadErrorKind::Truncated("the data")));
        };
        self.at += N;
        let mut chunk = *chunk;
        if self.encoding == Encoding::Big {
            chunk.reverse();
        }
        Ok(chunk)
    }

    fn number(&mut self, kind: Scalar) -> Result<f64, ReadError> {
        if self.encoding == Encoding::Ascii {
            let word = self.word()?;
            return word
                .parse()
                .map_err(|_| self.error(ReadErrorKind::Expected("a number")));
        }
        Ok(match kind {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.raw()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.raw()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.raw()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.raw()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.raw()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.raw()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.raw()?)),
            Scalar::F64 => f64::from_le_bytes(self.raw()?),
        })
    }

    /// A whole number that is not negative.
    fn whole(&mut self, kind: Scalar, what: &'static str) -> Result<u64, ReadError> {
        let start = (self.at, self.line);
        let value = self.number(kind)?;
        if value >= 0.0 && value.fract() == 0.0 && value < 9e15 {
            Ok(value as u64)
        } else {
            (self.at, self.line) = start;
            Err(self.error(ReadErrorKind::Expected(what)))
        }
    }

    fn values(&mut self, property: &Property, mut take: impl FnMut(f64)) -> Result<(), ReadError> {
        let count = match property.count {
            None => 1,
            Some(kind) => self.list_count(kind, property.value)?,
        };
        for _ in 0..count {
            take(self.number(property.value)?);
        }
        Ok(())
    }

    fn list_count(&mut self, kind: Scalar, value: Scalar) -> Result<u64, ReadError> {
        let count = self.whole(kind, "a list's length")?;
        let size = if self.encoding == Encoding::Ascii {
            2
        } else {
            value.size() as u64
        };
        if count.saturating_mul(size) > (self.bytes.len() - self.at) as u64 + 1 {
            return Err(self.error(ReadErrorKind::Count {
                what: "entries of a list",
                count,
            }));
        }
        Ok(count)
    }

    fn vertices(&mut self, element: &Element, soup: &mut Soup) -> Result<(), ReadError> {
        let axis = |p: &Property| ["x", "y", "z"].iter().position(|n| *n == p.name);
        let found = element
            .properties
            .iter()
            .filter(|p| p.count.is_none() && axis(p).is_some())
            .count();
        if found != 3 {
            return Err(self.error(ReadErrorKind::Header("has no x, y and z of a vertex")));
        }
        for _ in 0..element.count {
            let mut point = DVec3::ZERO;
            for property in &element.properties {
                let axis = axis(property);
                self.values(property, |v| {
                    if let Some(k) = axis {
                        point[k] = v;
                    }
                })?;
            }
            if !point.is_finite() {
                return Err(self.error(ReadErrorKind::NotFinite));
            }
            soup.points.push(point);
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, soup: &mut Soup) -> Result<(), ReadError> {
        let is_corners = |p: &Property| {
            p.count.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index")
        };
        if !element.properties.iter().any(is_corners) {
            return Err(self.error(ReadErrorKind::Header("has no vertex_indices of a face")));
        }
        let mut corners = Vec::new();
        for _ in 0..element.count {
            corners.clear();
            for property in &element.properties {
                let Some(count) = property.count.filter(|_| is_corners(property)) else {
                    self.values(property, |_| {})?;
                    continue;
                };
                for _ in 0..self.list_count(count, property.value)? {
                    let corner = self.whole(property.value, "the number of a point")?;
                    if corner >= soup.points.len() as u64 {
                        return Err(self.error(ReadErrorKind::MissingPoint(corner as i64)));
                    }
                    corners.push(corner as u32);
                }
            }
            // Points and lines among the faces bound nothing.
            if corners.len() >= 3 {
                triangulate(&soup.points, &corners, &mut soup.triangles);
            }
        }
        Ok(())
    }
}
