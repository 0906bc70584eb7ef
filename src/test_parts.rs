//! Solids and meshes with closed forms, for unit tests.

pub(crate) mod homology;
pub(crate) mod stages;
pub(crate) mod voxels;

use crate::model::brep::{Brep, Curve, Face, Facet};
use crate::model::ids::{FaceId, IndexVec, NodeId, SheetId, VertexId, WallId};
use crate::model::shell::{Corners, Element, Sheet, ShellMesh};
use glam::DVec3;

/// A solid from flat polygons (each convex, counter-clockwise from outside), with the number of its face. `middle` is the point
/// between two corners on the surface.
pub(crate) fn brep(
    points: Vec<DVec3>,
    polygons: &[(Vec<usize>, u32)],
    middle: impl Fn(DVec3, DVec3) -> DVec3,
) -> Brep {
    let mut facets = Vec::new();
    for (polygon, face) in polygons {
        for k in 1..polygon.len() - 1 {
            let t = [polygon[0], polygon[k], polygon[k + 1]];
            facets.push(Facet {
                corners: t.map(|i| VertexId(i as u32)),
                mids: std::array::from_fn(|k| middle(points[t[k]], points[t[(k + 1) % 3]])),
                face: FaceId(*face),
            });
        }
    }
    let count = polygons.iter().map(|p| p.1 as usize + 1).max().unwrap_or(0);
    let solid = Brep {
        solid_tag: 1,
        vertices: IndexVec::from(points),
        facets: IndexVec::from(facets),
        faces: (0..count)
            .map(|i| Face {
                tag: i as i32 + 1,
                ..Face::default()
            })
            .collect(),
        curves: IndexVec::new(),
    };
    assert_eq!(solid.check(), vec![]);
    solid
}

/// A wedge 8 long, from the z axis along y: its flat side z = 0 (face 0) and its slope (face 1) meet at x = 0 under nine degrees; at x = 20 it is 3 high. Curve 0 is
/// their edge, 1 and 2 are those of the back (face 2).
pub(crate) fn slim_wedge() -> Brep {
    let points = [0.0, 8.0]
        .into_iter()
        .flat_map(|y| [(0.0, 0.0), (20.0, 0.0), (20.0, 3.0)].map(|(x, z)| DVec3::new(x, y, z)))
        .collect();
    let polygons = [
        (vec![0, 3, 4, 1], 0),
        (vec![0, 2, 5, 3], 1),
        (vec![1, 4, 5, 2], 2),
        (vec![0, 1, 2], 3),
        (vec![3, 5, 4], 4),
    ];
    let mut solid = brep(points, &polygons, |a, b| (a + b) / 2.0);
    for ends in [[0, 3], [1, 4], [2, 5]] {
        solid.curves.push(Curve {
            segments: vec![ends.map(VertexId)],
            ..Curve::default()
        });
    }
    solid
}

/// An outline in (y, z), counter-clockwise, drawn out along x. Face i stands on the side from corner i to the next; the ends come last. `middle` as for [`brep`].
pub(crate) fn prism(
    outline: &[(f64, f64)],
    length: f64,
    middle: impl Fn(DVec3, DVec3) -> DVec3,
) -> Brep {
    let n = outline.len();
    let points = [0.0, length]
        .into_iter()
        .flat_map(|x| outline.iter().map(move |&(y, z)| DVec3::new(x, y, z)))
        .collect();
    let mut polygons: Vec<(Vec<usize>, u32)> = (0..n)
        .map(|i| {
            let j = (i + 1) % n;
            (vec![i, j, n + j, n + i], i as u32)
        })
        .collect();
    polygons.push(((0..n).rev().collect(), n as u32));
    polygons.push(((n..2 * n).collect(), n as u32 + 1));
    brep(points, &polygons, middle)
}

/// A box with one corner at the origin.
pub(crate) fn box_brep(size: DVec3) -> Brep {
    let points = (0..8)
        .map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * size)
        .collect();
    let polygons = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let polygons: Vec<(Vec<usize>, u32)> = polygons.iter().map(|p| p.to_vec()).zip(0..).collect();
    brep(points, &polygons, |a, b| (a + b) / 2.0)
}

/// A tube round z of `n` curved facets a turn.
pub(crate) fn tube_brep(outer: f64, inner: f64, height: f64, n: usize) -> Brep {
    let mut points = Vec::new();
    for (r, z) in [(outer, 0.0), (outer, height), (inner, 0.0), (inner, height)] {
        for i in 0..n {
            let turn = std::f64::consts::TAU * i as f64 / n as f64;
            points.push(DVec3::new(r * turn.cos(), r * turn.sin(), z));
        }
    }
    let mut polygons = Vec::new();
    for i in 0..n {
        let at = |ring: usize, i: usize| ring * n + i % n;
        let j = i + 1;
        polygons.push((vec![at(0, i), at(0, j), at(1, j), at(1, i)], 0));
        polygons.push((vec![at(2, i), at(3, i), at(3, j), at(2, j)], 1));
        polygons.push((vec![at(1, i), at(1, j), at(3, j), at(3, i)], 2));
        polygons.push((vec![at(0, i), at(2, i), at(2, j), at(0, j)], 3));
    }
    brep(points, &polygons, |a, b| {
        let radius = |p: DVec3| p.truncate().length();
        let mid = (a + b) / 2.0;
        if (radius(a) - radius(b)).abs() > 1e-9 * outer {
            return mid;
        }
        (mid.truncate().normalize() * radius(a)).extend(mid.z)
    })
}

/// A hollow wing along y: a round nose of `n` curved facets round the axis, and sides that meet behind it at twice `half_angle`, in rad. Faces 0 to 2 are the upper side, the
/// nose and the lower side outside, 3 to 5 the same inside; 6 and 7 are the ends.
pub(crate) fn wing_brep(outer: f64, inner: f64, half_angle: f64, length: f64, n: usize) -> Brep {
    let turn = std::f64::consts::PI + 2.0 * half_angle;
    let ring = n + 2;
    let mut points = Vec::new();
    for (r, y) in [(outer, 0.0), (outer, length), (inner, 0.0), (inner, length)] {
        points.push(DVec3::new(r / half_angle.sin(), y, 0.0));
        for i in 0..=n {
            let at = std::f64::consts::FRAC_PI_2 - half_angle + turn * i as f64 / n as f64;
            points.push(DVec3::new(r * at.cos(), y, r * at.sin()));
        }
    }
    let mut polygons = Vec::new();
    for i in 0..ring {
        let at = |row: usize, i: usize| row * ring + i % ring;
        let (j, face) = (
            i + 1,
            if i == 0 {
                0
            } else if i <= n {
                1
            } else {
                2
            },
        );
        polygons.push((vec![at(0, i), at(1, i), at(1, j), at(0, j)], face));
        polygons.push((vec![at(2, i), at(2, j), at(3, j), at(3, i)], 3 + face));
        polygons.push((vec![at(0, i), at(0, j), at(2, j), at(2, i)], 6));
        polygons.push((vec![at(1, i), at(3, i), at(3, j), at(1, j)], 7));
    }
    brep(points, &polygons, |a, b| {
        let radius = |p: DVec3| p.x.hypot(p.z);
        let mid = (a + b) / 2.0;
        let curved = [inner, outer]
            .into_iter()
            .find(|r| [a, b].iter().all(|&p| (radius(p) - r).abs() < 1e-9 * outer));
        curved.map_or(mid, |r| {
            DVec3::new(mid.x * r / radius(mid), mid.y, mid.z * r / radius(mid))
        })
    })
}

/// A mesh of quads over a grid of `nu` by `nv` cells, closed in the first direction if `round`.
pub(crate) fn grid_mesh(
    f: impl Fn(f64, f64) -> DVec3,
    nu: usize,
    nv: usize,
    round: bool,
    thickness: f64,
) -> ShellMesh {
    let width = if round { nu } else { nu + 1 };
    let mut mesh = ShellMesh::default();
    for j in 0..=nv {
        for i in 0..width {
            mesh.nodes
                .push(f(i as f64 / nu as f64, j as f64 / nv as f64));
        }
    }
    for j in 0..nv {
        for i in 0..nu {
            let at = |i: usize, j: usize| NodeId((j * width + i % width) as u32);
            let corners = Corners::Quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            mesh.elements.push(element(corners, 0, thickness));
        }
    }
    mesh.node_thickness = IndexVec::filled(thickness, mesh.nodes.len());
    mesh.node_normals = IndexVec::filled(DVec3::Z, mesh.nodes.len());
    mesh.sheets.push(sheet());
    mesh
}

/// A sheet of the first solid.
pub(crate) fn sheet() -> Sheet {
    Sheet {
        solid_tag: 1,
        wall: WallId(0),
        sides: [vec![2], vec![1]],
    }
}

/// An element of constant thickness.
pub(crate) fn element(corners: Corners, sheet: u32, thickness: f64) -> Element {
    Element {
        corners,
        sheet: SheetId(sheet),
        thickness: [thickness; 4],
        source_faces: [2, 1],
        unsure: false,
    }
}

/// The mid-surface of the plate 100 x 60 x 3.
pub(crate) fn plate_mesh(nu: usize, nv: usize) -> ShellMesh {
    grid_mesh(
        |u, v| DVec3::new(100.0 * u, 60.0 * v, 1.5),
        nu,
        nv,
        false,
        3.0,
    )
}

/// A tube of radius 1 and height 1 round z, of 8 by 3 quads; `closed` by a fan of triangles at either end.
pub(crate) fn drum_mesh(closed: bool) -> ShellMesh {
    let tau = std::f64::consts::TAU;
    let wall = |u: f64, v: f64| DVec3::new((tau * u).cos(), (tau * u).sin(), v);
    let mut mesh = grid_mesh(wall, 8, 3, true, 1.0);
    for (first, z) in [(0, 0.0), (24, 1.0)] {
        if closed {
            let pole = mesh.nodes.push(DVec3::Z * z);
            for i in 0..8u32 {
                let at = |i: u32| NodeId(first + i % 8);
                let fan = Corners::Triangle([at(i), at(i + 1), pole]);
                mesh.elements.push(element(fan, 0, 1.0));
            }
        }
    }
    mesh
}

/// A cube of 20 with a cube of 16 cut out of its middle.
pub(crate) fn hollow_brep() -> Brep {
    let mut solid = box_brep(DVec3::splat(20.0));
    let inner = box_brep(DVec3::splat(16.0));
    let (vertices, faces) = (solid.vertices.len() as u32, solid.faces.len() as u32);
    for p in &inner.vertices {
        solid.vertices.push(*p + DVec3::splat(2.0));
    }
    for facet in &inner.facets {
        let mut facet = *facet;
        let [a, b, c] = facet.corners;
        facet.corners = [a, c, b].map(|v| VertexId(v.0 + vertices));
        let [ab, bc, ca] = facet.mids.map(|p| p + DVec3::splat(2.0));
        facet.mids = [ca, bc, ab];
        facet.face = FaceId(facet.face.0 + faces);
        solid.facets.push(facet);
    }
    for face in &inner.faces {
        let mut face = face.clone();
        face.tag += faces as i32;
        solid.faces.push(face);
    }
    assert_eq!(solid.check(), vec![]);
    solid
}
