//! VTK XML unstructured grids (`.vtu`): text, base64 and appended arrays, zlib or no compression, either byte order.
//!
//! Shells are triangles, quads and pixels, polygons of three or four corners, and their forms of higher order, taken by their corners. Thickness comes from the cell field
//! `thickness`, else from the point field of that name; sheets from the cell field `sheet`. Names are compared without regard to case. Several pieces are one mesh.
//!
//! Limits: LZ4 and LZMA are told as such, not read.
//!
//! Reference: VTK file formats, <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use super::error::{ReadError, ReadErrorKind, expected};
use super::raw::Raw;
use super::vtu_array::{Array, Coding, Source};
use super::xml::{Event, Reader, Tag};
use glam::DVec3;

const AGAIN: &str = "save it as an unstructured grid (.vtu) with zlib compression or none";

/// The arrays of one piece, by the element that they stand in.
#[derive(Default)]
struct Piece<'a> {
    arrays: Vec<(Section, Array<'a>)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Section {
    Points,
    Cells,
    PointData,
    CellData,
}

/// An array whose bytes are in the appended data: piece, place in the piece, offset.
type Appended = (usize, usize, usize);

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, ReadError> {
    let mut reader = Reader::new(bytes);
    let mut coding = None;
    let mut pieces: Vec<Piece<'_>> = Vec::new();
    let mut appended: Vec<Appended> = Vec::new();
    let mut section = None;
    let mut open: Option<Array<'_>> = None;
    let mut is_text = false;
    // Elements inside an array: VTK keeps the range of its numbers there.
    let mut depth = 0usize;
    while let Some(event) = reader.next()? {
        match event {
            Event::Open(tag) if open.is_some() => depth += usize::from(!tag.is_empty),
            Event::Close(name) if open.is_some() && name != b"DataArray" => {
                depth = depth.saturating_sub(1);
            }
            Event::Open(tag) => match tag.name {
                b"VTKFile" => coding = Some(header(&tag)?),
                _ if coding.is_none() => break,
                b"Piece" => pieces.push(Piece::default()),
                b"Points" => section = Some(Section::Points),
                b"Cells" => section = Some(Section::Cells),
                b"PointData" => section = Some(Section::PointData),
                b"CellData" => section = Some(Section::CellData),
                b"DataArray" => {
                    let (Some(section), Some(place)) = (section, pieces.len().checked_sub(1))
                    else {
                        continue;
                    };
                    let array = Array::new(&tag)?;
                    match tag.get("format").unwrap_or("ascii") {
                        "appended" => {
                            let offset = tag.get("offset").and_then(|o| o.trim().parse().ok());
                            let offset = offset.ok_or_else(|| {
                                expected(
                                    "an offset",
                                    tag.get("offset").unwrap_or_default().as_bytes(),
                                )
                                .byte(tag.at)
                            })?;
                            appended.push((place, pieces[place].arrays.len(), offset));
                            pieces[place].arrays.push((section, array));
                        }
                        form if tag.is_empty => {
                            is_text = form == "ascii";
                            pieces[place].arrays.push((section, array));
                        }
                        form => {
                            is_text = form == "ascii";
                            open = Some(array);
                        }
                    }
                }
                b"AppendedData" => {
                    let is_raw = tag.get("encoding") == Some("raw");
                    append(&bytes[reader.at..], is_raw, &appended, &mut pieces)
                        .map_err(|kind| kind.byte(reader.at))?;
                    appended.clear();
                    break;
                }
                _ => {}
            },
            Event::Text(_, text) => {
                if let Some(array) = &mut open
                    && depth == 0
                    && !text.trim_ascii().is_empty()
                {
                    array.source = match is_text {
                        true => Source::Text(text),
                        false => Source::Base64(text),
                    };
                }
            }
            Event::Close(b"DataArray") => {
                if let (Some(array), Some(section), Some(piece)) =
                    (open.take(), section, pieces.last_mut())
                {
                    piece.arrays.push((section, array));
                }
            }
            Event::Close(b"Points" | b"Cells" | b"PointData" | b"CellData") => section = None,
            Event::Close(_) => {}
        }
    }
    let Some(coding) = coding else {
        let kind = ReadErrorKind::Format {
            what: "it does not begin as a VTK XML file does".into(),
            remedy: AGAIN,
        };
        return Err(kind.byte(0));
    };
    if pieces.is_empty() || open.is_some() || !appended.is_empty() {
        return Err(ReadErrorKind::Truncated("the grid").byte(bytes.len()));
    }
    let mut raw = Raw::default();
    for piece in &pieces {
        read_piece(piece, coding, &mut raw)?;
    }
    Ok(raw)
}

fn header(tag: &Tag<'_>) -> Result<Coding, ReadError> {
    let other = |what: String| {
        let remedy = AGAIN;
        Err(ReadErrorKind::Format {
            what: what.into(),
            remedy,
        }
        .byte(tag.at))
    };
    let kind = tag.get("type").unwrap_or_default();
    if kind != "UnstructuredGrid" {
        return other(format!("it holds '{kind}', not an unstructured grid"));
    }
    let is_packed = match tag.get("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(name) => return other(format!("its arrays are compressed by '{name}'")),
    };
    Ok(Coding {
        is_big: tag.get("byte_order") == Some("BigEndian"),
        header: match tag.get("header_type") {
            Some("UInt64") => 8,
            _ => 4,
        },
        is_packed,
    })
}

/// Gives the arrays with an offset their bytes: up to where the next one begins.
fn append<'a>(
    rest: &'a [u8],
    is_raw: bool,
    arrays: &[Appended],
    pieces: &mut [Piece<'a>],
) -> Result<(), ReadErrorKind> {
    let mark = rest.iter().position(|&b| b == b'_');
    let data = &rest[mark.ok_or(ReadErrorKind::Truncated("the appended data"))? + 1..];
    let data = match data.iter().position(|&b| b == b'<') {
        Some(end) if !is_raw => &data[..end],
        _ => data,
    };
    let mut offsets: Vec<usize> = arrays.iter().map(|a| a.2).collect();
    offsets.sort_unstable();
    offsets.dedup();
    for &(piece, place, offset) in arrays {
        let next = offsets.partition_point(|&o| o <= offset);
        let end = match offsets.get(next) {
            Some(&end) => end.min(data.len()),
            None => data.len(),
        };
        let bytes = data
            .get(offset..end)
            .ok_or(ReadErrorKind::Truncated("the appended data"))?;
        pieces[piece].arrays[place].1.source = match is_raw {
            true => Source::Raw(bytes),
            false => Source::Base64(bytes),
        };
    }
    Ok(())
}

fn read_piece(piece: &Piece<'_>, coding: Coding, raw: &mut Raw) -> Result<(), ReadError> {
    let find = |section: Section, name: &str| {
        let mut of = piece.arrays.iter().filter(|(s, _)| *s == section);
        of.find(|(_, a)| a.name.eq_ignore_ascii_case(name))
            .map(|(_, a)| a)
    };
    let missing = |what: &str| ReadErrorKind::Counts(format!("a piece has no {what}")).anywhere();
    let Some((_, points)) = piece.arrays.iter().find(|(s, _)| *s == Section::Points) else {
        // A piece without points is one that a process had nothing to write into.
        return Ok(());
    };
    let points = points.reals(coding)?;
    let first = raw.nodes.len();
    for (number, at) in (first as u64 + 1..).zip(points.chunks_exact(3)) {
        raw.nodes.push((number, DVec3::from_slice(at)));
    }
    let count = raw.nodes.len() - first;
    let cells = |name| -> Result<Vec<i64>, ReadError> {
        find(Section::Cells, name)
            .ok_or_else(|| missing(name))?
            .integers(coding)
    };
    let (corners, ends, types) = (cells("connectivity")?, cells("offsets")?, cells("types")?);
    if ends.len() != types.len() {
        let what = format!("{} offsets for {} cell types", ends.len(), types.len());
        return Err(ReadErrorKind::Counts(what).anywhere());
    }
    let reals = |section, name| match find(section, name) {
        Some(array) if array.width == 1 => array.reals(coding).map(Some),
        _ => Ok(None),
    };
    let of_cells = reals(Section::CellData, "thickness")?.filter(|v| v.len() == types.len());
    let of_points = reals(Section::PointData, "thickness")?.filter(|v| v.len() == count);
    let sheets = match find(Section::CellData, "sheet") {
        Some(array) => array
            .integers(coding)
            .ok()
            .filter(|v| v.len() == types.len()),
        None => None,
    };
    let mut from = 0;
    for (k, (&end, &kind)) in ends.iter().zip(&types).enumerate() {
        let number = raw.elements.len() + raw.solids + raw.others + 1;
        let number = number as u64;
        let nodes = usize::try_from(end)
            .ok()
            .and_then(|end| corners.get(from..end));
        let nodes = nodes.ok_or_else(|| {
            let what = format!("cell {number} ends at {end}, beyond or before its corners");
            ReadErrorKind::Counts(what).anywhere()
        })?;
        from = end as usize;
        let place = |n: &i64| match usize::try_from(*n) {
            Ok(n) if n < count => Ok((first + n) as u32),
            _ => Err(ReadErrorKind::MissingNode {
                element: number,
                node: n.wrapping_add(1) as u64,
            }
            .anywhere()),
        };
        let mut nodes: Vec<u32> = nodes.iter().map(place).collect::<Result<_, _>>()?;
        let shell = match (kind, nodes.len()) {
            (5, 3) | (22, 6) | (34, 7) | (69, 3..) | (76, 3..) | (7, 3) => Some(3),
            (9, 4) | (23, 8) | (28, 9) | (30, 6) | (70, 4..) | (77, 4..) | (7, 4) => Some(4),
            // A pixel runs row by row.
            (8, 4) => {
                nodes.swap(2, 3);
                Some(4)
            }
            _ => None,
        };
        match shell {
            Some(corners) => {
                raw.shell(number, corners, &nodes, sheets.as_ref().map(|s| s[k]));
                let thickness = |c: usize| match (&of_cells, &of_points) {
                    (Some(cells), _) => cells[k],
                    (None, Some(points)) => points[nodes[c.min(corners - 1)] as usize - first],
                    (None, None) => f64::NAN,
                };
                if let Some(element) = raw.elements.last_mut() {
                    element.thickness = [0, 1, 2, 3].map(thickness);
                }
            }
            None => {
                nodes.iter().for_each(|&n| raw.take(n));
                match is_solid(kind) {
                    true => raw.solids += 1,
                    false => raw.others += 1,
                }
            }
        }
    }
    Ok(())
}

/// VTK's numbers for cells with a volume.
fn is_solid(kind: i64) -> bool {
    matches!(kind, 10..=16 | 24..=27 | 29 | 31..=33 | 37 | 42 | 71..=74 | 78..=81)
}
