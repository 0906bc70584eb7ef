//! Trims spurs: ends of a junction that lead nowhere.
//!
//! Where curves become one, sheets may stay glued to each other along an edge more than they should: a junction edge with a loose end, inside sheets that go on round
//! it. No wall ends there, so no curve can: the loose end is contracted into its base.
//!
//! Guarantee: the homotopy type stays (link condition). A spur whose contraction would change it stays.

use super::contract::keeps_homotopy;
use super::surface::Surface;
use crate::model::ids::NodeId;

/// Contracts loose ends until none is left that can go.
pub(super) fn trim_spurs(surface: &mut Surface) {
    let mut open: Vec<NodeId> = surface.live_nodes().collect();
    while let Some(end) = open.pop() {
        if surface.star(end).is_empty() {
            continue;
        }
        let &[base] = surface.feature_neighbours(end).as_slice() else {
            continue;
        };
        if keeps_homotopy(surface, end, base) {
            surface.contract(end, base);
            open.push(base);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::complex::{MidComplex, MidNode, MidTriangle};
    use crate::model::ids::WallId;
    use glam::DVec3;

    /// Two plates above each other (walls 0 and 1), a 4 x 4 grid each, that share the edge between two inner nodes and nothing else.
    fn glued() -> MidComplex {
        let mut complex = MidComplex::default();
        let mut grids = Vec::new();
        for z in [0.0, 1.0] {
            let mut grid = Vec::new();
            for i in 0..16 {
                let shared = z > 0.0 && (i == 5 || i == 6);
                grid.push(if shared {
                    NodeId(i)
                } else {
                    complex.nodes.push(MidNode {
                        point: DVec3::new(f64::from(i % 4), f64::from(i / 4), z),
                        supports: Default::default(),
                    })
                });
            }
            grids.push(grid);
        }
        for (wall, grid) in grids.iter().enumerate() {
            for i in 0..9 {
                let a = i / 3 * 4 + i % 3;
                for nodes in [[a, a + 1, a + 5], [a, a + 5, a + 4]] {
                    complex.triangles.push(MidTriangle {
                        nodes: nodes.map(|n| grid[n]),
                        wall: WallId(wall as u32),
                    });
                }
            }
        }
        complex
    }

    #[test]
    fn a_junction_edge_between_two_loose_ends_is_contracted() {
        let before = glued();
        let euler = before.euler();
        let junctions = |c: &MidComplex| c.edges().iter().filter(|e| e.triangles.len() > 2).count();
        assert_eq!(junctions(&before), 1);
        let mut surface = Surface::new(before);
        trim_spurs(&mut surface);
        let after = surface.finish();
        assert_eq!((junctions(&after), after.euler()), (0, euler));
        assert!(after.check().is_empty());
    }
}
