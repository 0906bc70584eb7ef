//! How much of the material that the elements stand for is there twice: sheets that meet at a junction both fill the block in which they meet.
//!
//! ```text
//!        |   |
//!        | B |             Of the rib B, area times thickness counts from the middle of the plate A on: the half block (x) is in both. At the corner of two
//!        |   |             walls it is otherwise: what is there twice inside the bend is missing outside, and nothing is to be taken out.
//!   _____|   |_____
//!        | x |
//!   - - -|- -|- - - A
//!   _______________
//! ```
//! Points are spread through the material of the elements, and counted once for each sheet whose material holds them.
//!
//! Limits: a sheet that meets itself is one sheet.

use super::sampling::spread;
use super::topology::{Topology, is_sound};
use super::walls::Flat;
use crate::geom::random::Pcg;
use crate::model::ids::{ElementId, Id, NodeId, SheetId};
use crate::model::shell::ShellMesh;
use crate::spatial::TriangleBvh;
use glam::DVec3;
use rayon::prelude::*;

/// A weight of a corner below this is none: the nearest point is on the side across.
const ON_SIDE: f64 = 1e-9;
/// Cosine above which a point lies straight over a place on a rim: what leans further lies beyond it.
const STRAIGHT: f64 = 1.0 - 1e-6;

/// One sheet's material.
struct Slab {
    sheet: SheetId,
    surface: TriangleBvh,
    /// Its triangles among those of the mesh.
    triangles: Vec<u32>,
    low: DVec3,
    high: DVec3,
    /// Half of its greatest thickness.
    reach: f64,
}

/// Share of the material (area times thickness) that counts, when what several sheets hold counts once.
pub(super) fn counted_once(
    mesh: &ShellMesh,
    flat: &Flat,
    topology: &Topology,
    count: usize,
    seed: u64,
) -> f64 {
    if topology.junctions == 0 {
        return 1.0;
    }
    let slabs = slabs(mesh, flat);
    let on_border = on_border(mesh);
    let bends = Bends::new(mesh);
    let samples = spread(&flat.areas, count, seed);
    let mut rng = Pcg::new(seed.wrapping_add(1));
    let heights: Vec<f64> = samples.iter().map(|_| rng.unit() - 0.5).collect();
    let weights: Vec<[f64; 2]> = (samples.par_iter().zip(heights))
        .map(|(sample, height)| {
            let i = sample.triangle;
            let thickness = flat.thickness[i];
            let p = sample.of(flat.triangles[i]) + flat.normals[i] * (height * thickness);
            let own = mesh.elements[flat.elements[i]].sheet;
            let others = slabs.iter().filter(|slab| {
                slab.sheet != own
                    && slab.holds(p, mesh, flat, &on_border)
                    && !bends.near(p, [own, slab.sheet], thickness + 2.0 * slab.reach)
            });
            [thickness, thickness / (1.0 + others.count() as f64)]
        })
        .collect();
    let (all, once) = (weights.iter()).fold((0.0, 0.0), |(a, b), w| (a + w[0], b + w[1]));
    if all > 0.0 { once / all } else { 1.0 }
}

fn slabs(mesh: &ShellMesh, flat: &Flat) -> Vec<Slab> {
    let sheet_of = |i: &u32| mesh.elements[flat.elements[*i as usize]].sheet;
    let mut order: Vec<u32> = (0..flat.triangles.len() as u32).collect();
    order.sort_by_key(sheet_of);
    let sheets: Vec<&[u32]> = order.chunk_by(|a, b| sheet_of(a) == sheet_of(b)).collect();
    (sheets.into_par_iter())
        .map(|triangles| {
            let corners: Vec<[DVec3; 3]> =
                (triangles.iter().map(|i| flat.triangles[*i as usize])).collect();
            let all = || corners.iter().flatten();
            let thickness = triangles.iter().map(|i| flat.thickness[*i as usize]);
            let reach = thickness.fold(0.0, f64::max) / 2.0;
            Slab {
                sheet: sheet_of(&triangles[0]),
                low: all().fold(DVec3::INFINITY, |l, p| l.min(*p)) - reach,
                high: all().fold(DVec3::NEG_INFINITY, |h, p| h.max(*p)) + reach,
                surface: TriangleBvh::new(&corners),
                triangles: triangles.to_vec(),
                reach,
            }
        })
        .collect()
}

impl Slab {
    /// Whether its material holds a point.
    fn holds(&self, p: DVec3, mesh: &ShellMesh, flat: &Flat, on_border: &[bool]) -> bool {
        if p.cmplt(self.low).any() || p.cmpgt(self.high).any() {
            return false;
        }
        let Some(near) = self.surface.nearest_within(p, self.reach) else {
            return false;
        };
        let i = self.triangles[near.index] as usize;
        if near.distance > flat.thickness[i] / 2.0 {
            return false;
        }
        let straight = (p - near.point).dot(flat.normals[i]).abs() >= STRAIGHT * near.distance;
        // Beyond a rim there is none.
        straight || !at_border(mesh, flat.elements[i], near.point, on_border)
    }
}

/// Whether a place of an element is on a side, or a corner, between nodes on the border of its sheet.
fn at_border(mesh: &ShellMesh, id: ElementId, place: DVec3, on_border: &[bool]) -> bool {
    let nodes = mesh.elements[id].corners.as_slice();
    let ends = (0..nodes.len()).map(|k| [nodes[k], nodes[(k + 1) % nodes.len()]]);
    let on = |[a, b]: [NodeId; 2]| {
        let (a, b) = (mesh.nodes[a], mesh.nodes[b]);
        let along = b - a;
        let t = ((place - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        place.distance(a + along * t) <= ON_SIDE * along.length()
    };
    let border = |n: NodeId| on_border[n.index()];
    ends.into_iter().any(|e| on(e) && e.into_iter().all(border))
}

/// Of every node, whether a sheet ends there.
fn on_border(mesh: &ShellMesh) -> Vec<bool> {
    let mut on = vec![false; mesh.nodes.len()];
    for edge in (mesh.rims.iter())
        .chain(&mesh.junctions)
        .chain(&mesh.creases)
    {
        for node in edge {
            if let Some(on) = on.get_mut(node.index()) {
                *on = true;
            }
        }
    }
    on
}

/// Edges at which just two sheets meet.
struct Bends {
    lines: TriangleBvh,
    sheets: Vec<[SheetId; 2]>,
}

impl Bends {
    fn new(mesh: &ShellMesh) -> Self {
        let mut sides: Vec<(NodeId, NodeId, SheetId)> = Vec::new();
        for (id, element) in mesh.elements.enumerated() {
            let nodes = element.corners.as_slice();
            for (k, &a) in nodes.iter().enumerate().filter(|_| is_sound(mesh, id)) {
                let b = nodes[(k + 1) % nodes.len()];
                sides.push((a.min(b), a.max(b), element.sheet));
            }
        }
        sides.sort_unstable();
        let (mut lines, mut sheets) = (Vec::new(), Vec::new());
        for run in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            if let [a, b] = run
                && a.2 != b.2
            {
                let [p, q] = [a.0, a.1].map(|n| mesh.nodes[n]);
                lines.push([p, q, q]);
                sheets.push([a.2, b.2]);
            }
        }
        Self {
            lines: TriangleBvh::new(&lines),
            sheets,
        }
    }

    /// Whether these two meet in a bend this near.
    fn near(&self, p: DVec3, mut two: [SheetId; 2], reach: f64) -> bool {
        two.sort_unstable();
        (self.lines)
            .nearest_where(p, reach, |i| self.sheets[i] == two)
            .is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::super::topology::look_at;
    use super::*;
    use crate::model::ids::{IndexVec, WallId};
    use crate::model::shell::{Corners, Element, Sheet};

    /// Strips 10 wide along y, from one point of the (x, z) plane to another, each a sheet of this thickness.
    fn strips(of: &[([f64; 2], [f64; 2], f64)]) -> ShellMesh {
        let mut mesh = ShellMesh::default();
        let node = |p: DVec3, nodes: &mut IndexVec<NodeId, DVec3>| {
            let found = nodes.ids().find(|n| nodes[*n] == p);
            found.unwrap_or_else(|| nodes.push(p))
        };
        for (k, (from, to, thickness)) in of.iter().enumerate() {
            let n = [(from, 0.0), (to, 0.0), (to, 10.0), (from, 10.0)]
                .map(|(p, y)| node(DVec3::new(p[0], y, p[1]), &mut mesh.nodes));
            mesh.elements.push(Element {
                corners: Corners::Quad(n),
                sheet: SheetId(k as u32),
                thickness: [*thickness; 4],
                source_faces: [1, 2],
                unsure: false,
            });
            mesh.sheets.push(Sheet {
                solid_tag: 1,
                wall: WallId(k as u32),
                sides: [vec![1], vec![2]],
            });
            for side in 0..4 {
                let (a, b) = (n[side], n[(side + 1) % 4]);
                mesh.rims.push([a.min(b), a.max(b)]);
            }
        }
        mesh
    }

    fn once(mesh: &ShellMesh) -> f64 {
        let topology = look_at(mesh);
        let flat = Flat::new(mesh, |_| true);
        counted_once(mesh, &flat, &topology, 40_000, 3)
    }

    #[test]
    fn the_half_block_under_a_rib_counts_once() {
        // Plate 2 thick from -10 to 10, rib 1 thick and 8 high from its middle: 40 + 8, of which 1 x 1 is there twice.
        let mesh = strips(&[
            ([-10.0, 0.0], [0.0, 0.0], 2.0),
            ([0.0, 0.0], [10.0, 0.0], 2.0),
            ([0.0, 0.0], [0.0, 8.0], 1.0),
        ]);
        assert!((once(&mesh) - 47.0 / 48.0).abs() < 2e-3, "{}", once(&mesh));
    }

    #[test]
    fn the_block_of_a_cross_counts_once() {
        let mesh = strips(&[
            ([-5.0, 0.0], [0.0, 0.0], 2.0),
            ([0.0, 0.0], [5.0, 0.0], 2.0),
            ([0.0, 0.0], [0.0, 5.0], 2.0),
            ([0.0, -5.0], [0.0, 0.0], 2.0),
        ]);
        assert!((once(&mesh) - 0.9).abs() < 2e-3, "{}", once(&mesh));
    }

    #[test]
    fn the_corner_of_two_walls_is_left_as_it_is() {
        let bend = [
            ([-8.0, 0.0], [0.0, 0.0], 2.0),
            ([0.0, 0.0], [0.0, 8.0], 2.0),
        ];
        assert_eq!(once(&strips(&bend)), 1.0);
        // Nor where there is a junction elsewhere.
        let mut with_rib = bend.to_vec();
        with_rib[0].0 = [-4.0, 0.0];
        with_rib.push(([-10.0, 0.0], [-4.0, 0.0], 2.0));
        with_rib.push(([-4.0, 0.0], [-4.0, 6.0], 1.0));
        let whole = 2.0 * 10.0 + 2.0 * 8.0 + 6.0;
        let share = once(&strips(&with_rib));
        assert!((share - (whole - 1.0) / whole).abs() < 2e-3, "{share}");
    }
}
