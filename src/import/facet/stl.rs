//! A reader of STL, ASCII and binary.
//!
//! Which of the two a file is, its length decides: a binary file has 84 bytes and 50 for each facet, as many as it says. Only where that does not hold, a
//! file that begins with `solid` is text: many binary files begin with that word too. A binary file may have bytes after its last facet.
//!
//! Guarantees: no panic and no large allocation, whatever the bytes are; all coordinates are finite. Normals and attributes are not read.
//! Several solids in one ASCII file are one soup.
//!
//! Reference: 3D Systems, StereoLithography Interface Specification, 1989.

use glam::DVec3;

use super::soup::{ReadError, ReadErrorKind, Soup};

const HEADER: usize = 80;
const FACET: usize = 50;

/// Reads a whole file.
pub fn parse_stl(bytes: &[u8]) -> Result<Soup, ReadError> {
    let count = bytes
        .get(HEADER..)
        .and_then(|b| b.first_chunk::<4>())
        .map(|b| u64::from(u32::from_le_bytes(*b)));
    let room = bytes.len().saturating_sub(HEADER + 4) as u64;
    if count.is_some_and(|n| n * FACET as u64 == room) {
        return binary(bytes);
    }
    let head = bytes.trim_ascii_start();
    let is_text = head.len() >= 5 && head[..5].eq_ignore_ascii_case(b"solid");
    if is_text && !bytes.iter().take(1024).any(|&b| b == 0) {
        return ascii(bytes);
    }
    match count {
        None => Err(ReadError::byte(
            0,
            ReadErrorKind::Expected("'solid' or a header of 84 bytes"),
        )),
        Some(count) if count * FACET as u64 > room => Err(ReadError::byte(
            HEADER,
            if bytes.iter().take(1024).all(|b| b.is_ascii()) && bytes[..HEADER].contains(&b'\n') {
                ReadErrorKind::Expected("'solid' at the beginning of a text file")
            } else {
                ReadErrorKind::Count {
                    what: "facets",
                    count,
                }
            },
        )),
        Some(_) => binary(bytes),
    }
}

fn binary(bytes: &[u8]) -> Result<Soup, ReadError> {
    let body = &bytes[HEADER + 4..];
    let count = bytes[HEADER..]
        .first_chunk::<4>()
        .map_or(0, |b| u32::from_le_bytes(*b) as usize);
    if count == 0 {
        return Err(ReadError::byte(HEADER, ReadErrorKind::NoFacet));
    }
    let mut soup = Soup {
        points: Vec::with_capacity(3 * count),
        triangles: Vec::with_capacity(count),
    };
    for (i, facet) in body.chunks_exact(FACET).take(count).enumerate() {
        let first = soup.points.len() as u32;
        for (k, corner) in facet[12..48].chunks_exact(12).enumerate() {
            let mut at = [0.0; 3];
            for (x, raw) in at.iter_mut().zip(corner.chunks_exact(4)) {
                *x = raw
                    .first_chunk::<4>()
                    .map_or(0.0, |b| f64::from(f32::from_le_bytes(*b)));
            }
            let point = DVec3::from_array(at);
            if !point.is_finite() {
                let byte = HEADER + 4 + i * FACET + 12 + k * 12;
                return Err(ReadError::byte(byte, ReadErrorKind::NotFinite));
            }
            soup.points.push(point);
        }
        soup.triangles.push([first, first + 1, first + 2]);
    }
    Ok(soup)
}

/// What an ASCII file may say next.
enum State {
    Outside,
    Facet,
    Loop,
    LoopDone,
}

fn ascii(bytes: &[u8]) -> Result<Soup, ReadError> {
    let mut soup = Soup::default();
    let mut state = State::Outside;
    let mut corners = 0;
    let mut ended = false;
    let mut last = 0;
    for (i, line) in bytes.split(|&b| b == b'\n').enumerate() {
        let number = i + 1;
        let expected = |what| ReadError::line(number, ReadErrorKind::Expected(what));
        let line = line.trim_ascii();
        if line.is_empty() {
            continue;
        }
        last = number;
        let mut words = line
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        let first = words.next().unwrap_or_default().to_ascii_lowercase();
        match (&state, first.as_slice()) {
            (State::Outside, b"solid") => ended = false,
            (State::Outside, b"endsolid") => ended = true,
            (State::Outside, b"facet") => state = State::Facet,
            (State::Facet, b"outer") => (state, corners) = (State::Loop, 0),
            (State::Loop, b"vertex") => {
                let mut at = [0.0; 3];
                for x in &mut at {
                    let word = words
                        .next()
                        .and_then(|w| std::str::from_utf8(w).ok())
                        .ok_or_else(|| expected("a coordinate"))?;
                    *x = word.parse::<f64>().map_err(|_| expected("a coordinate"))?;
                }
                let point = DVec3::from_array(at);
                if !point.is_finite() {
                    return Err(ReadError::line(number, ReadErrorKind::NotFinite));
                }
                soup.points.push(point);
                corners += 1;
            }
            (State::Loop, b"endloop") => {
                if corners != 3 {
                    return Err(expected("a facet of three vertices"));
                }
                let first = soup.points.len() as u32 - 3;
                soup.triangles.push([first, first + 1, first + 2]);
                state = State::LoopDone;
            }
            (State::LoopDone, b"endfacet") => state = State::Outside,
            (State::Outside, _) => return Err(expected("'facet' or 'endsolid'")),
            (State::Facet, _) => return Err(expected("'outer loop'")),
            (State::Loop, _) => return Err(expected("'vertex' or 'endloop'")),
            (State::LoopDone, _) => return Err(expected("'endfacet'")),
        }
    }
    if !ended || !matches!(state, State::Outside) {
        return Err(ReadError::line(last, ReadErrorKind::Truncated("a solid")));
    }
    if soup.triangles.is_empty() {
        return Err(ReadError::line(last, ReadErrorKind::NoFacet));
    }
    Ok(soup)
}
