//! STL: the facets of [`crate::import::facet::stl`], with corners in exactly one place made one node.
//!
//! Limits: STL holds triangles alone, in single precision where it is binary, and neither thickness nor sheets.

use super::error::{ReadError, ReadErrorKind};
use super::raw::Raw;
use crate::import::facet::stl::parse_stl;

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<Raw, ReadError> {
    let soup = parse_stl(bytes).map_err(|e| ReadError {
        place: Some(e.place),
        kind: ReadErrorKind::Stl(e.kind),
    })?;
    // By their coordinates; -0 is 0.
    let key = |k: u32| {
        soup.points[k as usize]
            .to_array()
            .map(|x| (x + 0.0).to_bits())
    };
    let mut order: Vec<u32> = (0..soup.points.len() as u32).collect();
    order.sort_by_key(|&k| (key(k), k));
    let mut first = vec![0u32; soup.points.len()];
    for run in order.chunk_by(|&a, &b| key(a) == key(b)) {
        run.iter().for_each(|&k| first[k as usize] = run[0]);
    }
    let mut raw = Raw::default();
    let mut place = vec![u32::MAX; soup.points.len()];
    for (k, point) in soup.points.iter().enumerate() {
        if first[k] as usize == k {
            place[k] = raw.nodes.len() as u32;
            raw.nodes.push((raw.nodes.len() as u64 + 1, *point));
        }
    }
    for (number, corners) in (1u64..).zip(&soup.triangles) {
        let nodes = corners.map(|k| place[first[k as usize] as usize]);
        raw.shell(number, 3, &nodes, None);
    }
    let welded = soup.points.len() - raw.nodes.len();
    raw.notes.push(format!(
        "STL has no nodes: of {} corners {welded} lie where another does and were joined to it",
        soup.points.len()
    ));
    Ok(raw)
}
