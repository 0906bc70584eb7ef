//! Nastran bulk data (`.bdf`, `.nas`, `.fem`): `GRID`, `CTRIA3`, `CTRIAR`, `CTRIA6`, `CQUAD4`, `CQUADR`, `CQUAD8`, `CQUAD`, and their thickness.
//!
//! Thickness comes from the corners (`T1` to `T4`, shares of the plate's where `TFLAG` is 1), else from `PSHELL`, else from the layers of `PCOMP`.
//! Limits: included files are refused, not opened; nodes must be given in the basic coordinate system.
//!
//! Reference: MSC Nastran quick reference guide.

use super::bdf_cards::{Card, cards};
use super::error::{ReadError, ReadErrorKind};
use super::raw::{Numbers, Raw};
use glam::DVec3;
use std::collections::{HashMap, HashSet};

/// Where a shell card has what: corners, nodes, first corner thickness, its flag.
struct Layout {
    corners: usize,
    nodes: usize,
    thickness: usize,
    flag: usize,
}

fn layout(name: &str) -> Option<Layout> {
    let of = |corners, nodes, thickness, flag| Layout {
        corners,
        nodes,
        thickness,
        flag,
    };
    Some(match name {
        "CTRIA3" | "CTRIAR" => of(3, 3, 10, 9),
        "CQUAD4" | "CQUADR" => of(4, 4, 10, 9),
        "CTRIA6" => of(3, 6, 10, 13),
        "CQUAD8" => of(4, 8, 10, 16),
        // Without a thickness of its own.
        "CQUAD" => of(4, 9, usize::MAX, usize::MAX),
        _ => return None,
    })
}

const SOLIDS: [&str; 7] = [
    "CTETRA", "CHEXA", "CPENTA", "CPYRAM", "CPYRA", "CHEXA1", "CHEXA2",
];

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, ReadError> {
    let mut raw = Raw::default();
    let mut numbers = Numbers::default();
    let mut plates: HashMap<u64, f64> = HashMap::new();
    // Elements may stand before their nodes.
    for card in cards(bytes) {
        let card = &card;
        match card.name.as_str() {
            "GRID" => grid(card, &mut raw, &mut numbers)?,
            "PSHELL" => {
                let (id, thickness) = (card.whole(0)?, card.real(2)?);
                plates.extend(id.zip(thickness));
            }
            "PCOMP" => plates.extend(card.whole(0)?.zip(laminate(card)?)),
            name if name == "INCLUDE" || name.starts_with("INCLUDE ") => {
                let kind = ReadErrorKind::Format {
                    what: "it includes another file".into(),
                    remedy: "put the contents of the included file in the place of the INCLUDE line",
                };
                return Err(kind.line(card.line));
            }
            _ => {}
        }
    }
    let mut seen = HashSet::new();
    for card in cards(bytes) {
        let card = &card;
        if let Some(layout) = layout(&card.name) {
            let number = required(card, 0, "the number of an element")?;
            if !seen.insert(number) {
                let what = "element";
                return Err(ReadErrorKind::DefinedTwice { what, number }.line(card.line));
            }
            shell(card, number, &layout, &numbers, &plates, &mut raw)?;
        } else if SOLIDS.contains(&card.name.as_str()) {
            raw.solids += 1;
            take_nodes(card, &numbers, &mut raw);
        } else if is_other(&card.name) {
            raw.others += 1;
        }
    }
    Ok(raw)
}

/// Elements and rigid bodies that are no shells. `CORD2R` and the like begin with a C too.
fn is_other(name: &str) -> bool {
    const BEGIN: [&str; 11] = [
        "CBAR", "CBEAM", "CROD", "CONROD", "CTUBE", "CELAS", "CBUSH", "CONM", "CSHEAR", "RBE",
        "CGAP",
    ];
    BEGIN.iter().any(|b| name.starts_with(b))
}

fn grid(card: &Card, raw: &mut Raw, numbers: &mut Numbers) -> Result<(), ReadError> {
    let number = required(card, 0, "the number of a node")?;
    if let Some(system) = card.whole(1)?.filter(|s| *s != 0) {
        let kind = ReadErrorKind::Format {
            what: format!("node {number} is given in coordinate system {system}").into(),
            remedy: "write the deck with all nodes in the basic coordinate system",
        };
        return Err(kind.line(card.line));
    }
    let mut at = [0.0; 3];
    for (k, x) in at.iter_mut().enumerate() {
        *x = card.real(2 + k)?.unwrap_or(0.0);
    }
    let at = DVec3::from_array(at);
    match numbers.add(number)? {
        None => raw.nodes.push((number, at)),
        Some(place) if raw.nodes[place as usize].1 == at => {}
        Some(_) => {
            let what = "node";
            return Err(ReadErrorKind::DefinedTwice { what, number }.line(card.line));
        }
    }
    Ok(())
}

fn required(card: &Card, place: usize, what: &'static str) -> Result<u64, ReadError> {
    let missing = || ReadErrorKind::Expected(what, String::new()).line(card.line);
    card.whole(place)?.ok_or_else(missing)
}

/// Layers added up, twice where the laminate is given by half.
fn laminate(card: &Card) -> Result<Option<f64>, ReadError> {
    let mut sum = 0.0;
    let mut last = None;
    for place in (9..card.fields.len()).step_by(4) {
        let has_material = !card.field(place - 1).is_empty();
        // A layer without a thickness has that of the one before.
        last = card.real(place)?.or(last.filter(|_| has_material));
        if has_material || !card.field(place).is_empty() {
            sum += last.unwrap_or(f64::NAN);
        }
    }
    let times = if card.field(7).starts_with("SYM") {
        2.0
    } else {
        1.0
    };
    Ok((sum > 0.0).then_some(times * sum))
}

fn shell(
    card: &Card,
    number: u64,
    layout: &Layout,
    numbers: &Numbers,
    plates: &HashMap<u64, f64>,
    raw: &mut Raw,
) -> Result<(), ReadError> {
    let mut nodes = Vec::with_capacity(layout.nodes);
    for k in 0..layout.nodes {
        // Mid-side nodes may be left out.
        let Some(node) = card.whole(2 + k)? else {
            if k < layout.corners {
                let what = format!("element {number} has too few corners");
                return Err(ReadErrorKind::Counts(what).line(card.line));
            }
            continue;
        };
        let place = numbers.get(node);
        let missing = || {
            ReadErrorKind::MissingNode {
                element: number,
                node,
            }
            .line(card.line)
        };
        nodes.push(place.ok_or_else(missing)?);
    }
    raw.shell(number, layout.corners, &nodes, None);
    let plate = card.whole(1)?.unwrap_or(number);
    let plate = plates.get(&plate).copied().unwrap_or(f64::NAN);
    let mut thickness = [plate; 4];
    if layout.thickness != usize::MAX {
        let is_share = card.field(layout.flag) == "1";
        for (k, t) in thickness.iter_mut().enumerate().take(layout.corners) {
            if let Some(own) = card.real(layout.thickness + k)? {
                *t = if is_share { own * plate } else { own };
            }
        }
    }
    if layout.corners == 3 {
        thickness[3] = thickness[2];
    }
    if let Some(element) = raw.elements.last_mut() {
        element.thickness = thickness;
    }
    Ok(())
}

fn take_nodes(card: &Card, numbers: &Numbers, raw: &mut Raw) {
    let nodes = card.fields.iter().skip(2).filter_map(|f| f.parse().ok());
    nodes
        .filter_map(|n| numbers.get(n))
        .for_each(|n| raw.take(n));
}
