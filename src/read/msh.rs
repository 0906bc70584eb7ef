//! Gmsh MSH 2.2 and 4.1, text and binary, either byte order.
//!
//! Thickness comes from a data section whose name begins with `thickness`: `$ElementNodeData` (each corner) before `$ElementData` before `$NodeData`.
//! Limits: physical groups are not taken as sheets; nodes that partitions have twice stay so.
//!
//! Reference: <https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format>.

use super::error::{ReadError, ReadErrorKind};
use super::msh_source::Source;
use super::raw::{Numbers, Raw};
use glam::DVec3;
use std::collections::HashMap;

const AGAIN: &str = "let gmsh write it anew: gmsh -0 FILE -o NEW.msh -format msh41 (or msh22), or Mesh.MshFileVersion = 4.1";

/// A data section on thickness: its values by node or element number.
#[derive(Default)]
struct Thickness {
    of_nodes: HashMap<u64, f64>,
    of_elements: HashMap<u64, f64>,
    of_corners: HashMap<u64, Vec<f64>>,
}

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, ReadError> {
    let mut source = Source::new(bytes);
    let is_old = format(&mut source)?;
    let mut raw = Raw::default();
    let mut numbers = Numbers::default();
    let mut thickness = Thickness::default();
    let mut seen_elements = false;
    while !source.is_over() {
        let start = source.at;
        match source.line("a section's name")? {
            b"$Nodes" => {
                nodes(&mut source, is_old, &mut raw, &mut numbers)?;
                source.end(b"$EndNodes")?;
            }
            b"$Elements" => {
                elements(&mut source, is_old, &mut raw, &numbers)?;
                seen_elements = true;
                source.end(b"$EndElements")?;
            }
            b"$NodeData" => {
                data(&mut source, false, |number, values| {
                    thickness
                        .of_nodes
                        .extend(values.first().map(|v| (number, *v)));
                })?;
                source.end(b"$EndNodeData")?;
            }
            b"$ElementData" => {
                data(&mut source, false, |number, values| {
                    thickness
                        .of_elements
                        .extend(values.first().map(|v| (number, *v)));
                })?;
                source.end(b"$EndElementData")?;
            }
            b"$ElementNodeData" => {
                data(&mut source, true, |number, values| {
                    thickness.of_corners.insert(number, values.to_vec());
                })?;
                source.end(b"$EndElementNodeData")?;
            }
            [] => {}
            [b'$', name @ ..] => source.skip(name)?,
            other => return Err(super::error::expected("a section", other).byte(start)),
        }
    }
    if !seen_elements {
        return Err(source.wrong(ReadErrorKind::Truncated("the mesh: there is no $Elements")));
    }
    thicken(&mut raw, &thickness);
    Ok(raw)
}

/// Whether it is version 2.
fn format(source: &mut Source<'_>) -> Result<bool, ReadError> {
    let refuse = |what: String| {
        let what = what.into();
        ReadErrorKind::Format {
            what,
            remedy: AGAIN,
        }
        .byte(0)
    };
    match source.line("the format")? {
        b"$MeshFormat" => {}
        b"$NOD" => return Err(refuse("it is MSH version 1".into())),
        [b'(', ..] => return Err(refuse("it is a mesh of ANSYS Fluent, not of gmsh".into())),
        _ => return Err(refuse("it does not begin with $MeshFormat".into())),
    }
    let line = String::from_utf8_lossy(source.line("the version")?).into_owned();
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let is_old = match words.first() {
        Some(&("2.2" | "2.1" | "2" | "2.0")) => true,
        Some(&"4.1") => false,
        version => {
            return Err(refuse(format!(
                "it is MSH version {}",
                version.unwrap_or(&"?")
            )));
        }
    };
    if words.get(2) != Some(&"8") {
        return Err(refuse("its numbers are not of 8 bytes".into()));
    }
    if words.get(1) == Some(&"1") {
        source.is_binary = true;
        source.is_swapped = match source.int("the byte order")? {
            1 => false,
            0x0100_0000 => true,
            other => return Err(refuse(format!("its byte order is {other}"))),
        };
    }
    source.end(b"$EndMeshFormat")?;
    Ok(is_old)
}

fn nodes(
    source: &mut Source<'_>,
    is_old: bool,
    raw: &mut Raw,
    numbers: &mut Numbers,
) -> Result<(), ReadError> {
    const WHAT: &str = "nodes";
    let mut add = |source: &Source<'_>, number: u64, at: DVec3| {
        if numbers.add(number)?.is_some() {
            let kind = ReadErrorKind::DefinedTwice {
                what: "node",
                number,
            };
            return Err(source.wrong(kind));
        }
        raw.nodes.push((number, at));
        Ok(())
    };
    let place = |source: &mut Source<'_>| -> Result<DVec3, ReadError> {
        Ok(DVec3::new(
            source.real(WHAT)?,
            source.real(WHAT)?,
            source.real(WHAT)?,
        ))
    };
    if is_old {
        for _ in 0..source.count_line(WHAT)? {
            let number = source.int(WHAT)?;
            let at = place(source)?;
            add(source, number as u64, at)?;
        }
        return Ok(());
    }
    let blocks = source.count(WHAT)?;
    for _ in 0..3 {
        source.size(WHAT)?;
    }
    for _ in 0..blocks {
        let dimension = source.int(WHAT)?;
        source.int(WHAT)?;
        let is_parametric = source.int(WHAT)? != 0;
        let count = source.count(WHAT)?;
        let tags: Vec<u64> = (0..count)
            .map(|_| source.size(WHAT))
            .collect::<Result<_, _>>()?;
        for number in tags {
            let at = place(source)?;
            if is_parametric {
                for _ in 0..dimension.clamp(0, 3) {
                    source.real(WHAT)?;
                }
            }
            add(source, number, at)?;
        }
    }
    Ok(())
}

fn elements(
    source: &mut Source<'_>,
    is_old: bool,
    raw: &mut Raw,
    numbers: &Numbers,
) -> Result<(), ReadError> {
    const WHAT: &str = "elements";
    if is_old {
        let total = source.count_line(WHAT)?;
        let mut done = 0;
        while done < total {
            // Text has one element a header, binary as many as it says.
            let (mut number, kind, follow, tags);
            if source.is_binary {
                number = 0;
                kind = source.int(WHAT)?;
                follow = usize::try_from(source.int(WHAT)?).unwrap_or(0).max(1);
                tags = source.int(WHAT)?;
            } else {
                number = source.int(WHAT)?;
                kind = source.int(WHAT)?;
                follow = 1;
                tags = source.int(WHAT)?;
            }
            for _ in 0..follow {
                if source.is_binary {
                    number = source.int(WHAT)?;
                }
                for _ in 0..tags {
                    source.int(WHAT)?;
                }
                element(source, raw, numbers, (number as u64, kind), |s| {
                    s.int(WHAT).map(|n| n as u64)
                })?;
            }
            done += follow;
        }
        return Ok(());
    }
    let blocks = source.count(WHAT)?;
    for _ in 0..3 {
        source.size(WHAT)?;
    }
    for _ in 0..blocks {
        source.int(WHAT)?;
        source.int(WHAT)?;
        let kind = source.int(WHAT)?;
        for _ in 0..source.count(WHAT)? {
            let number = source.size(WHAT)?;
            element(source, raw, numbers, (number, kind), |s| s.size(WHAT))?;
        }
    }
    Ok(())
}

/// Reads the nodes of one element and puts it where it belongs.
fn element(
    source: &mut Source<'_>,
    raw: &mut Raw,
    numbers: &Numbers,
    (number, kind): (u64, i64),
    mut tag: impl FnMut(&mut Source<'_>) -> Result<u64, ReadError>,
) -> Result<(), ReadError> {
    let Some((dimension, corners, count)) = shape(kind) else {
        let what = format!("element {number} is of gmsh's type {kind}, which is not known here");
        let kind = ReadErrorKind::Format {
            what: what.into(),
            remedy: "save the mesh with elements of first or second order",
        };
        return Err(source.wrong(kind));
    };
    let mut nodes = Vec::with_capacity(count);
    for _ in 0..count {
        let node = tag(source)?;
        let place = numbers.get(node);
        nodes.push(place.ok_or_else(|| {
            source.wrong(ReadErrorKind::MissingNode {
                element: number,
                node,
            })
        })?);
    }
    match dimension {
        2 => raw.shell(number, corners, &nodes, None),
        _ => {
            nodes.iter().for_each(|&n| raw.take(n));
            match dimension {
                3 => raw.solids += 1,
                _ => raw.others += 1,
            }
        }
    }
    Ok(())
}

/// Dimension, corners and nodes of gmsh's element types.
fn shape(kind: i64) -> Option<(u8, usize, usize)> {
    Some(match kind {
        15 => (0, 1, 1),
        1 => (1, 2, 2),
        8 => (1, 2, 3),
        26 => (1, 2, 4),
        27 => (1, 2, 5),
        28 => (1, 2, 6),
        2 => (2, 3, 3),
        9 => (2, 3, 6),
        20 => (2, 3, 9),
        21 => (2, 3, 10),
        22 => (2, 3, 12),
        23 | 24 => (2, 3, 15),
        25 => (2, 3, 21),
        3 => (2, 4, 4),
        16 => (2, 4, 8),
        10 => (2, 4, 9),
        36 => (2, 4, 16),
        37 => (2, 4, 25),
        4 => (3, 4, 4),
        5 => (3, 8, 8),
        6 => (3, 6, 6),
        7 => (3, 5, 5),
        11 => (3, 4, 10),
        12 => (3, 8, 27),
        13 => (3, 6, 18),
        14 => (3, 5, 14),
        17 => (3, 8, 20),
        18 => (3, 6, 15),
        19 => (3, 5, 13),
        29 => (3, 4, 20),
        30 => (3, 4, 35),
        31 => (3, 4, 56),
        92 => (3, 8, 64),
        93 => (3, 8, 125),
        _ => return None,
    })
}

/// A data section: each number with its values is told, if the section is on thickness.
fn data(
    source: &mut Source<'_>,
    has_corners: bool,
    mut tell: impl FnMut(u64, &[f64]),
) -> Result<(), ReadError> {
    const WHAT: &str = "a data section";
    let mut name = String::new();
    for k in 0..source.count_line(WHAT)? {
        let line = String::from_utf8_lossy(source.line(WHAT)?).into_owned();
        if k == 0 {
            name = line.trim_matches('"').to_ascii_lowercase();
        }
    }
    for _ in 0..source.count_line(WHAT)? {
        source.line(WHAT)?;
    }
    let mut tags = Vec::new();
    for _ in 0..source.count_line(WHAT)? {
        tags.push(source.count_line(WHAT)?);
    }
    let (width, count) = (
        tags.get(1).copied().unwrap_or(1),
        tags.get(2).copied().unwrap_or(0),
    );
    let is_thickness = name.starts_with("thickness") && width == 1;
    let mut values = Vec::new();
    for _ in 0..count {
        let number = source.int(WHAT)?;
        let corners = match has_corners {
            true => usize::try_from(source.int(WHAT)?).unwrap_or(0),
            false => 1,
        };
        values.clear();
        for _ in 0..corners.saturating_mul(width) {
            values.push(source.real(WHAT)?);
        }
        if is_thickness {
            tell(number as u64, &values);
        }
    }
    Ok(())
}

fn thicken(raw: &mut Raw, thickness: &Thickness) {
    for element in &mut raw.elements {
        if let Some(values) = thickness.of_corners.get(&element.number) {
            for (to, value) in element.thickness.iter_mut().zip(values) {
                *to = *value;
            }
        } else if let Some(value) = thickness.of_elements.get(&element.number) {
            element.thickness = [*value; 4];
        } else {
            for (to, node) in element.thickness.iter_mut().zip(&element.corners) {
                let number = raw.nodes[*node as usize].0;
                *to = thickness.of_nodes.get(&number).copied().unwrap_or(f64::NAN);
            }
        }
        if element.corners.len() == 3 {
            element.thickness[3] = element.thickness[2];
        }
    }
}
