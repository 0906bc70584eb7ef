//! A grid of quads in a plane, for the tests of what changes cells.

use super::cells::{Cells, Ground, Place, Ring};
use crate::spatial::Hint;
use glam::DVec3;
use smallvec::smallvec;

/// The plane z = 0.
pub(super) struct Plane;

impl Ground for Plane {
    fn foot(&self, p: DVec3, _: Option<Hint>) -> Place {
        Place {
            point: DVec3::new(p.x, p.y, 0.0),
            normal: DVec3::Z,
            hint: None,
            stretch: DVec3::ZERO,
        }
    }
}

/// The number of a node of a grid that is `nu` squares wide.
pub(super) fn at(nu: u32, i: u32, j: u32) -> u32 {
    j * (nu + 1) + i
}

/// A grid of squares of side 1 with its rim held.
pub(super) fn grid(nu: u32, nv: u32) -> Cells {
    let rings = (0..nv)
        .flat_map(|j| (0..nu).map(move |i| (i, j)))
        .map(|(i, j)| -> Ring {
            smallvec![
                at(nu, i, j),
                at(nu, i + 1, j),
                at(nu, i + 1, j + 1),
                at(nu, i, j + 1)
            ]
        });
    with_rings(nu, nv, rings.collect())
}

/// Other cells over the nodes of such a grid.
pub(super) fn with_rings(nu: u32, nv: u32, rings: Vec<Ring>) -> Cells {
    let mut places = Vec::new();
    let mut held = Vec::new();
    for j in 0..=nv {
        for i in 0..=nu {
            places.push(Plane.foot(DVec3::new(f64::from(i), f64::from(j), 0.0), None));
            held.push(i == 0 || j == 0 || i == nu || j == nv);
        }
    }
    let mut kept: Vec<[u32; 2]> = Vec::new();
    for i in 0..nu {
        kept.extend([0, nv].map(|j| [at(nu, i, j), at(nu, i + 1, j)]));
    }
    for j in 0..nv {
        kept.extend([0, nu].map(|i| [at(nu, i, j), at(nu, i, j + 1)]));
    }
    kept.sort_unstable();
    Cells::new(places, held, rings, kept)
}

/// How many of the living cells are triangles.
pub(super) fn triangles(cells: &Cells) -> usize {
    cells.living().filter(|&c| !cells.is_quad(c)).count()
}

/// The least worth of all living cells.
pub(super) fn worst(cells: &Cells) -> f64 {
    cells.worst(&cells.living().collect::<Vec<_>>())
}
