//! A reader of Wavefront OBJ: `v` and `f`, all else is passed over.
//!
//! Guarantees: no panic, whatever the bytes are; all coordinates are finite and all corners exist. Polygons are cut into triangles; negative numbers count back
//! from the last point; a backslash at a line's end joins it with the next. Limits: free-form curves and surfaces of OBJ are not read.
//!
//! Reference: Wavefront, Advanced Visualizer Manual, appendix B1: object files.

use glam::DVec3;

use super::soup::{ReadError, ReadErrorKind, Soup, triangulate};

/// Reads a whole file.
pub fn parse_obj(bytes: &[u8]) -> Result<Soup, ReadError> {
    let mut soup = Soup::default();
    let mut polygons: Vec<(usize, Vec<u32>)> = Vec::new();
    let mut lines = bytes.split(|&b| b == b'\n').enumerate();
    let mut last = 0;
    while let Some((i, line)) = lines.next() {
        let number = i + 1;
        last = number;
        let mut whole = line.trim_ascii().to_vec();
        while whole.last() == Some(&b'\\') {
            whole.pop();
            match lines.next() {
                Some((_, more)) => {
                    whole.push(b' ');
                    whole.extend(more.trim_ascii());
                }
                None => {
                    return Err(ReadError::line(number, ReadErrorKind::Truncated("a line")));
                }
            }
        }
        let code = whole.split(|&b| b == b'#').next().unwrap_or_default();
        let mut words = code
            .split(u8::is_ascii_whitespace)
            .filter(|w| !w.is_empty());
        match words.next() {
            Some(b"v") => soup.points.push(point(number, words)?),
            Some(b"f") => {
                let corners = words
                    .map(|word| corner(number, word, soup.points.len()))
                    .collect::<Result<Vec<u32>, _>>()?;
                if corners.len() < 3 {
                    let kind = ReadErrorKind::Expected("a face of three corners or more");
                    return Err(ReadError::line(number, kind));
                }
                polygons.push((number, corners));
            }
            _ => {}
        }
    }
    for (number, corners) in polygons {
        if let Some(&high) = corners.iter().find(|&&c| c as usize >= soup.points.len()) {
            let kind = ReadErrorKind::MissingPoint(i64::from(high) + 1);
            return Err(ReadError::line(number, kind));
        }
        triangulate(&soup.points, &corners, &mut soup.triangles);
    }
    if soup.triangles.is_empty() {
        return Err(ReadError::line(last, ReadErrorKind::NoFacet));
    }
    Ok(soup)
}

fn point<'a>(number: usize, words: impl Iterator<Item = &'a [u8]>) -> Result<DVec3, ReadError> {
    let expected = || ReadError::line(number, ReadErrorKind::Expected("three coordinates"));
    let mut at = [0.0; 3];
    let mut words = words;
    for x in &mut at {
        *x = words
            .next()
            .and_then(|w| std::str::from_utf8(w).ok())
            .and_then(|w| w.parse().ok())
            .ok_or_else(expected)?;
    }
    let point = DVec3::from_array(at);
    if point.is_finite() {
        Ok(point)
    } else {
        Err(ReadError::line(number, ReadErrorKind::NotFinite))
    }
}

/// The position that a corner such as `7`, `7/1/3`, `7//3` or `-1` names. A point may be defined after it is used.
fn corner(number: usize, word: &[u8], defined: usize) -> Result<u32, ReadError> {
    let named: i64 = word
        .split(|&b| b == b'/')
        .next()
        .and_then(|w| std::str::from_utf8(w).ok())
        .and_then(|w| w.parse().ok())
        .ok_or_else(|| ReadError::line(number, ReadErrorKind::Expected("the number of a point")))?;
    let at = if named < 0 {
        named.checked_add(defined as i64)
    } else {
        named.checked_sub(1)
    };
    at.and_then(|at| u32::try_from(at).ok())
        .ok_or_else(|| ReadError::line(number, ReadErrorKind::MissingPoint(named)))
}
