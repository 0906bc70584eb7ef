//! Sheets that meet in a crease are wound as one surface: a load or an offset on one side of a bend stays on that side beyond it.

use crate::model::complex::{EdgeKind, MidComplex, MidEdge};
use crate::model::ids::{Id, IndexVec, SheetId, TriangleId};
use std::collections::BTreeMap;

/// Which sheets are to be turned over so that those on both sides of a crease run on. Of sheets that hang together so the largest stays as it is. The longest
/// creases come first: where sheets close to a one-sided ring, a seam is left at the shortest.
pub fn turned(
    complex: &MidComplex,
    edges: &[MidEdge],
    sheet_of: &IndexVec<TriangleId, SheetId>,
) -> IndexVec<SheetId, bool> {
    let count = sheet_of.iter().map(|s| s.index() + 1).max().unwrap_or(0);
    let mut area: IndexVec<SheetId, f64> = IndexVec::filled(0.0, count);
    for (t, triangle) in complex.triangles.enumerated() {
        area[sheet_of[t]] += complex.area_vector(triangle).length();
    }
    // Of each pair of sheets, the length of their creases over which they are wound against one another, less the rest.
    let mut against: BTreeMap<(SheetId, SheetId), f64> = BTreeMap::new();
    for edge in edges {
        let (EdgeKind::Crease, [s, t]) = (complex.kind(edge), edge.triangles.as_slice()) else {
            continue;
        };
        let (a, b) = (sheet_of[*s], sheet_of[*t]);
        if a == b {
            continue;
        }
        let [p, q] = edge.ends.map(|n| complex.nodes[n].point);
        let [s, t] = [s, t].map(|&t| complex.triangles[t].runs(edge.ends));
        let sign = if s == t { 1.0 } else { -1.0 };
        *against.entry((a.min(b), a.max(b))).or_insert(0.0) += sign * (q - p).length();
    }
    let mut pairs: Vec<_> = against.into_iter().collect();
    pairs.sort_by(|x, y| y.1.abs().total_cmp(&x.1.abs()).then(x.0.cmp(&y.0)));
    // Each group of sheets by the sheet that stays, with its members.
    let mut turn: IndexVec<SheetId, bool> = IndexVec::filled(false, count);
    let mut group: IndexVec<SheetId, SheetId> = area.ids().collect();
    let mut members: IndexVec<SheetId, Vec<SheetId>> = area.ids().map(|s| vec![s]).collect();
    for ((a, b), against) in pairs {
        let (g, h) = (group[a], group[b]);
        if g == h {
            continue;
        }
        let over = turn[a] ^ turn[b] ^ (against > 0.0);
        let (stays, joins) = if area[g] >= area[h] { (g, h) } else { (h, g) };
        for m in std::mem::take(&mut members[joins]) {
            turn[m] ^= over;
            group[m] = stays;
            members[stays].push(m);
        }
    }
    turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidNode, MidTriangle, Supports};
    use crate::model::ids::{NodeId, WallId};
    use glam::DVec3;

    /// A strip of triangles along x, each of a wall of its own, the listed ones wound the other way. The last is the largest.
    fn strip(over: &[u32], count: u32) -> MidComplex {
        let mut complex = MidComplex::default();
        for k in 0..count + 2 {
            let x = if k > count { 3 * k } else { k };
            complex.nodes.push(MidNode {
                point: DVec3::new(f64::from(x), f64::from(k % 2), 0.0),
                supports: Supports::new(),
            });
        }
        for k in 0..count {
            let mut nodes = [k, k + 1, k + 2].map(NodeId);
            if (k % 2 == 1) != over.contains(&k) {
                nodes.swap(1, 2);
            }
            complex.triangles.push(MidTriangle {
                nodes,
                wall: WallId(k),
            });
        }
        complex
    }

    fn turned_of(complex: &MidComplex) -> Vec<u32> {
        let sheet_of: IndexVec<TriangleId, SheetId> =
            (0..complex.triangles.len() as u32).map(SheetId).collect();
        let turned = turned(complex, &complex.edges(), &sheet_of);
        turned
            .enumerated()
            .filter(|(_, t)| **t)
            .map(|(s, _)| s.0)
            .collect()
    }

    #[test]
    fn sheets_run_on_as_the_largest_is_wound() {
        assert!(turned_of(&strip(&[], 6)).is_empty());
        assert_eq!(turned_of(&strip(&[1, 2, 4], 6)), [1, 2, 4]);
        assert_eq!(turned_of(&strip(&[5], 6)), [0, 1, 2, 3, 4]);
    }

    #[test]
    fn sheets_that_meet_in_a_junction_stay_as_they_are() {
        let mut complex = strip(&[1], 2);
        complex.nodes.push(MidNode {
            point: DVec3::Z,
            supports: Supports::new(),
        });
        complex.triangles.push(MidTriangle {
            nodes: [1, 2, 4].map(NodeId),
            wall: WallId(2),
        });
        assert!(turned_of(&complex).is_empty());
    }
}
