//! Opens a filling where its boundary touches itself: along an edge, or in a point.
//!
//! A robust tetrahedraliser leaves such places where two sides of a part come nearer than its envelope. The tets that hang together over a face stay
//! together; those that only share an edge or a point come apart, each with a vertex of its own in the same place. What is left is a manifold.
//!
//! Guarantees: no tet is lost and none changes its shape but those round a pinched edge, which are cut in two at its middle; volume stays.

use glam::DVec3;

use super::piece::OUTWARD;
use super::tetwild::Filling;
use crate::model::disjoint::Disjoint;

/// A face of a tet: its corners sorted, its corners seen from outside, the tet.
type Side = ([u32; 3], [u32; 3], u32);

fn sides(tets: &[[u32; 4]]) -> Vec<Side> {
    let mut sides = Vec::with_capacity(4 * tets.len());
    for (i, tet) in (0u32..).zip(tets) {
        for f in OUTWARD {
            let seen = f.map(|k| tet[k]);
            let mut key = seen;
            key.sort_unstable();
            sides.push((key, seen, i));
        }
    }
    sides.sort_unstable();
    sides
}

/// The faces that belong to one tet, seen from outside, in the order of their corners' numbers.
pub(super) fn boundary(tets: &[[u32; 4]]) -> Vec<[u32; 3]> {
    sides(tets)
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|run| run.len() == 1)
        .map(|run| run[0].1)
        .collect()
}

/// Edges of the boundary with more than two facets, their ends in order.
fn pinched_edges(tets: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = boundary(tets)
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges
        .chunk_by(|a, b| a == b)
        .filter(|run| run.len() > 2)
        .map(|run| run[0])
        .collect()
}

/// The same filling without pinches, and without the points that no tet uses.
pub(super) fn opened(filling: &Filling) -> Filling {
    let mut points = filling.points.clone();
    let mut tets = filling.tets.clone();
    // Cut at its middle, a pinched edge has a point whose tets come apart even where those at its ends hang together.
    for [a, b] in pinched_edges(&tets) {
        let middle = points.len() as u32;
        points.push(points[a as usize].midpoint(points[b as usize]));
        let mut halves = Vec::new();
        for tet in &mut tets {
            if tet.contains(&a) && tet.contains(&b) {
                halves.push(tet.map(|v| if v == a { middle } else { v }));
                *tet = tet.map(|v| if v == b { middle } else { v });
            }
        }
        tets.extend(halves);
    }
    let mut corners = Disjoint::new(4 * tets.len());
    let place = |tet: u32, v: u32| {
        let k = tets[tet as usize].iter().position(|&w| w == v);
        4 * tet + k.unwrap_or(0) as u32
    };
    for run in sides(&tets).chunk_by(|a, b| a.0 == b.0) {
        if let [one, other] = run {
            for v in one.0 {
                corners.join(place(one.2, v), place(other.2, v));
            }
        }
    }
    let mut name = vec![u32::MAX; 4 * tets.len()];
    let mut own: Vec<DVec3> = Vec::new();
    let mut cells = Vec::with_capacity(tets.len());
    for (i, tet) in (0u32..).zip(&tets) {
        let mut cell = [0; 4];
        for k in 0..4 {
            let root = corners.find(4 * i + k as u32) as usize;
            if name[root] == u32::MAX {
                name[root] = own.len() as u32;
                own.push(points[tet[k] as usize]);
            }
            cell[k] = name[root];
        }
        cells.push(cell);
    }
    Filling {
        points: own,
        tets: cells,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two tets on the opposite sides of the first one's corner 0, sharing so many corners with it.
    fn two_tets(shared: usize) -> Filling {
        let first = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let mut points = first.to_vec();
        let second = match shared {
            1 => [0, 4, 5, 6],
            2 => [0, 1, 4, 5],
            _ => [0, 1, 2, 4],
        };
        points.extend([-DVec3::Y, -DVec3::Z, -DVec3::X]);
        if shared == 1 {
            points = vec![
                DVec3::ZERO,
                DVec3::X,
                DVec3::Y,
                DVec3::Z,
                -DVec3::Y,
                -DVec3::X,
                -DVec3::Z,
            ];
        }
        if shared == 3 {
            points[4] = -DVec3::Z;
        }
        let det = |t: [u32; 4]| {
            let [a, b, c, d] = t.map(|i| points[i as usize]);
            (b - a).dot((c - a).cross(d - a))
        };
        let mut tets = vec![[0, 1, 2, 3], second];
        for t in &mut tets {
            if det(*t) < 0.0 {
                t.swap(0, 1);
            }
        }
        Filling { points, tets }
    }

    fn volume(f: &Filling) -> f64 {
        let det = |t: &[u32; 4]| {
            let [a, b, c, d] = t.map(|i| f.points[i as usize]);
            (b - a).dot((c - a).cross(d - a)) / 6.0
        };
        assert!(f.tets.iter().all(|t| det(t) > 0.0));
        f.tets.iter().map(det).sum()
    }

    #[test]
    fn tets_that_touch_in_a_point_or_along_an_edge_come_apart() {
        // Apart, two tets have eight corners; four tets in two pairs have ten.
        for (shared, corners) in [(1, 8), (2, 10), (3, 5)] {
            let before = two_tets(shared);
            let after = opened(&before);
            assert_eq!(after.points.len(), corners, "{shared} corners shared");
            assert!(pinched_edges(&after.tets).is_empty());
            assert!((volume(&after) - volume(&before)).abs() < 1e-15);
        }
        assert_eq!(pinched_edges(&two_tets(2).tets).len(), 1);
    }

    #[test]
    fn a_point_without_tet_is_dropped() {
        let mut filling = two_tets(3);
        filling.points.push(DVec3::ONE);
        assert_eq!(opened(&filling).points.len(), 5);
    }
}
