//! Filled solids from boxes: the boundary with its faces and curves, and tets, for unit tests of all that comes after import.
//!
//! A set of boxes of a rectilinear grid; each is split into six tets along its main diagonal (H. W. Kuhn, IBM J. Res. Dev. 4 (1960)), which conform from box
//! to box. Faces are the largest connected regions of one plane; curves are where two faces meet.

use crate::geom::random::Pcg;
use crate::model::brep::{Brep, Curve, Face, Facet};
use crate::model::ids::{CurveId, FaceId, Id, IndexVec, VertexId};
use crate::model::tets::Tets;
use glam::{DMat3, DVec3};
use std::collections::{BTreeMap, BTreeSet};

/// A solid with its filling.
#[derive(Clone, Debug)]
pub(crate) struct Filled {
    pub brep: Brep,
    pub tets: Tets,
}

type Cell = [i64; 3];
/// A side of a box: the box, the axis across it, and whether it lies at the upper end.
type Side = (Cell, usize, bool);

/// Grid lines from 0 through the given stops, each stretch in so many cells.
pub(crate) fn lines(stretches: &[(f64, usize)]) -> Vec<f64> {
    let mut at = vec![0.0];
    for &(end, n) in stretches {
        let start = at[at.len() - 1];
        at.extend((1..=n).map(|i| {
            if i == n {
                end
            } else {
                start + (end - start) * i as f64 / n as f64
            }
        }));
    }
    at
}

/// The solid of all boxes of the grid whose middle `full` accepts. It must be a manifold.
pub(crate) fn filled(grid: [Vec<f64>; 3], full: impl Fn(DVec3) -> bool) -> Filled {
    let size = grid.each_ref().map(|g| g.len() as i64 - 1);
    let point = |c: Cell| DVec3::from_array(std::array::from_fn(|a| grid[a][c[a] as usize]));
    let mut cells: BTreeSet<Cell> = BTreeSet::new();
    for i in 0..size[0] {
        for j in 0..size[1] {
            for k in 0..size[2] {
                if full((point([i, j, k]) + point([i + 1, j + 1, k + 1])) / 2.0) {
                    cells.insert([i, j, k]);
                }
            }
        }
    }
    let mut ids: BTreeMap<Cell, VertexId> = BTreeMap::new();
    let mut vertices: IndexVec<VertexId, DVec3> = IndexVec::new();
    let mut vertex = |c: Cell| *ids.entry(c).or_insert_with(|| vertices.push(point(c)));
    let mut tets = Tets::default();
    for &cell in &cells {
        for (order, even) in ORDERS {
            let mut corner = cell;
            let mut tet = [vertex(corner); 4];
            for (n, axis) in order.into_iter().enumerate() {
                corner[axis] += 1;
                tet[n + 1] = vertex(corner);
            }
            if !even {
                tet.swap(2, 3);
            }
            tets.cells.push(tet);
        }
    }
    let sides: BTreeSet<Side> = (cells.iter())
        .flat_map(|&c| (0..3).flat_map(move |a| [(c, a, false), (c, a, true)]))
        .filter(|&(c, a, upper)| !cells.contains(&step(c, a, if upper { 1 } else { -1 })))
        .collect();
    let face_of = regions(&sides);
    let mut brep = Brep {
        solid_tag: 1,
        faces: (0..face_of.values().map(|f| f + 1).max().unwrap_or(0))
            .map(|i| Face {
                tag: i as i32 + 1,
                ..Face::default()
            })
            .collect(),
        ..Brep::default()
    };
    for (side, &face) in &face_of {
        let [a, b, c, d] = corners(*side).map(&mut vertex);
        // The diagonal is the tets': from the lowest corner to the highest.
        for t in [[a, b, c], [a, c, d]] {
            brep.facets.push(Facet {
                corners: t,
                mids: [DVec3::ZERO; 3],
                face: FaceId(face),
            });
        }
    }
    brep.vertices = vertices;
    curves(&mut brep);
    let mut solid = Filled { brep, tets };
    solid.straighten();
    assert_eq!(solid.brep.check(), vec![], "the boxes are no manifold");
    solid
}

const ORDERS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], true),
    ([1, 2, 0], true),
    ([2, 0, 1], true),
    ([0, 2, 1], false),
    ([2, 1, 0], false),
    ([1, 0, 2], false),
];

fn step(mut c: Cell, axis: usize, by: i64) -> Cell {
    c[axis] += by;
    c
}

/// The corners of a side, counter-clockwise seen from outside, the lowest first.
fn corners((cell, axis, upper): Side) -> [Cell; 4] {
    let base = step(cell, axis, i64::from(upper));
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let (u, v) = if upper { (u, v) } else { (v, u) };
    [
        base,
        step(base, u, 1),
        step(step(base, u, 1), v, 1),
        step(base, v, 1),
    ]
}

/// Number of the plane region that each side belongs to.
fn regions(sides: &BTreeSet<Side>) -> BTreeMap<Side, u32> {
    let mut of = BTreeMap::new();
    let mut count = 0;
    for &seed in sides {
        if of.contains_key(&seed) {
            continue;
        }
        of.insert(seed, count);
        let mut queue = vec![seed];
        while let Some((cell, axis, upper)) = queue.pop() {
            for a in [(axis + 1) % 3, (axis + 2) % 3] {
                for by in [-1, 1] {
                    let next = (step(cell, a, by), axis, upper);
                    if sides.contains(&next) && of.insert(next, count).is_none() {
                        queue.push(next);
                    }
                }
            }
        }
        count += 1;
    }
    of
}

/// One curve for each pair of faces that meet.
fn curves(brep: &mut Brep) {
    let mut at: BTreeMap<[VertexId; 2], Vec<FaceId>> = BTreeMap::new();
    for f in &brep.facets {
        for k in 0..3 {
            let (a, b) = (f.corners[k], f.corners[(k + 1) % 3]);
            at.entry([a.min(b), a.max(b)]).or_default().push(f.face);
        }
    }
    let mut by_faces: BTreeMap<[FaceId; 2], Vec<[VertexId; 2]>> = BTreeMap::new();
    for (ends, faces) in at {
        if let [f, g] = faces[..]
            && f != g
        {
            by_faces.entry([f.min(g), f.max(g)]).or_default().push(ends);
        }
    }
    for (faces, segments) in by_faces {
        let id = brep.curves.push(Curve {
            tag: 0,
            faces: faces.to_vec(),
            segments,
        });
        brep.curves[id].tag = id.0 as i32 + 1;
        for f in faces {
            brep.faces[f].curves.push(id);
        }
    }
}

impl Filled {
    fn straighten(&mut self) {
        let v = &self.brep.vertices;
        for f in self.brep.facets.iter_mut() {
            f.mids = std::array::from_fn(|k| (v[f.corners[k]] + v[f.corners[(k + 1) % 3]]) / 2.0);
        }
    }

    /// The same solid with every vertex moved by `f`; sides stay straight.
    pub fn mapped(&self, f: impl Fn(DVec3) -> DVec3) -> Self {
        let mut new = self.clone();
        for p in new.brep.vertices.iter_mut() {
            *p = f(*p);
        }
        new.straighten();
        new
    }

    /// The same solid with the numbers of its faces and curves shuffled; their tags travel with them.
    pub fn shuffled(&self, seed: u64) -> Self {
        let mut rng = Pcg::new(seed);
        let mut order = |n: usize| {
            let mut new: Vec<u32> = (0..n as u32).collect();
            for i in (1..n).rev() {
                new.swap(i, (rng.unit() * (i + 1) as f64) as usize);
            }
            new
        };
        let (faces, curves) = (order(self.brep.faces.len()), order(self.brep.curves.len()));
        let mut new = self.clone();
        for (id, face) in self.brep.faces.enumerated() {
            let mut face = face.clone();
            face.curves = face
                .curves
                .iter()
                .map(|c| CurveId(curves[c.index()]))
                .collect();
            face.curves.sort_unstable();
            new.brep.faces[FaceId(faces[id.index()])] = face;
        }
        for (id, curve) in self.brep.curves.enumerated() {
            let mut curve = curve.clone();
            curve.faces = curve
                .faces
                .iter()
                .map(|f| FaceId(faces[f.index()]))
                .collect();
            curve.faces.sort_unstable();
            new.brep.curves[CurveId(curves[id.index()])] = curve;
        }
        for f in new.brep.facets.iter_mut() {
            f.face = FaceId(faces[f.face.index()]);
        }
        new
    }

    /// The face that holds all facets whose corners `on` accepts; there must be exactly one.
    pub fn face(&self, on: impl Fn(DVec3) -> bool) -> FaceId {
        let mut outside = IndexVec::<FaceId, bool>::filled(false, self.brep.faces.len());
        for f in &self.brep.facets {
            outside[f.face] |= !f.corners.iter().all(|&v| on(self.brep.vertices[v]));
        }
        let found: Vec<FaceId> = outside.ids().filter(|&f| !outside[f]).collect();
        assert_eq!(found.len(), 1, "{found:?}");
        found[0]
    }

    /// V - E + F of the boundary.
    pub fn boundary_euler(&self) -> i64 {
        let used: BTreeSet<VertexId> = self.brep.facets.iter().flat_map(|f| f.corners).collect();
        used.len() as i64 - self.brep.facets.len() as i64 / 2
    }
}

/// A motion that no axis or plane survives.
pub(crate) fn motion(p: DVec3) -> DVec3 {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -3.0).normalize(), 1.234);
    turn * p + DVec3::new(100.0, -50.0, 7.0)
}

/// A plate 40 x 24 x 2 with its lower side on z = 0.
pub(crate) fn plate(layers: usize) -> Filled {
    let grid = [
        lines(&[(40.0, 10)]),
        lines(&[(24.0, 6)]),
        lines(&[(2.0, layers)]),
    ];
    filled(grid, |_| true)
}

/// A plate 2 thick (40 x 24) with two ribs 1 thick and 8 high on it, from y = 10 to 11 and from 13 to 14: two turns of a thread, unrolled.
pub(crate) fn two_ribs() -> Filled {
    let across = [(10.0, 3), (11.0, 1), (13.0, 1), (14.0, 1), (24.0, 3)];
    let grid = [
        lines(&[(40.0, 10)]),
        lines(&across),
        lines(&[(2.0, 1), (10.0, 4)]),
    ];
    let rib = |y: f64| (10.0..11.0).contains(&y) || (13.0..14.0).contains(&y);
    filled(grid, |p| p.z < 2.0 || rib(p.y))
}

/// The plate with a rib 2 thick and 12 high along its middle y = 12.
pub(crate) fn tee(layers: usize) -> Filled {
    let y = lines(&[(11.0, 4), (13.0, layers), (24.0, 4)]);
    let grid = [lines(&[(40.0, 10)]), y, lines(&[(2.0, layers), (14.0, 4)])];
    filled(grid, |p| p.z < 2.0 || (11.0..13.0).contains(&p.y))
}

/// Two plates 2 thick that cross along x; all arms 11 long.
pub(crate) fn cross() -> Filled {
    let y = lines(&[(11.0, 4), (13.0, 1), (24.0, 4)]);
    let mid = |t: f64| (11.0..13.0).contains(&t);
    filled([lines(&[(30.0, 8)]), y.clone(), y], |p| {
        mid(p.y) || mid(p.z)
    })
}

/// A sharp angle of a floor 30 x 24 x 2 and a wall 20 high.
pub(crate) fn ell(layers: usize) -> Filled {
    let x = lines(&[(2.0, layers), (30.0, 8)]);
    let grid = [x, lines(&[(24.0, 6)]), lines(&[(2.0, layers), (20.0, 5)])];
    filled(grid, |p| p.x < 2.0 || p.z < 2.0)
}

/// A channel: floor 30 x 24 x 2, walls 20 high at x = 0 and x = 30.
pub(crate) fn channel() -> Filled {
    let x = lines(&[(2.0, 1), (28.0, 7), (30.0, 1)]);
    let grid = [x, lines(&[(24.0, 6)]), lines(&[(2.0, 1), (20.0, 5)])];
    filled(grid, |p| p.z < 2.0 || !(2.0..28.0).contains(&p.x))
}

/// A plate 40 x 24 x 2 with a hole 8 x 8 in its middle.
pub(crate) fn plate_with_hole() -> Filled {
    let grid = [
        lines(&[(40.0, 10)]),
        lines(&[(24.0, 6)]),
        lines(&[(2.0, 1)]),
    ];
    filled(grid, |p| {
        !(16.0..24.0).contains(&p.x) || !(8.0..16.0).contains(&p.y)
    })
}

/// A closed box 24 x 20 x 16 of walls 2 thick.
pub(crate) fn hollow_box() -> Filled {
    let axis = |l: f64, n| lines(&[(2.0, 1), (l - 2.0, n), (l, 1)]);
    let grid = [axis(24.0, 5), axis(20.0, 4), axis(16.0, 3)];
    filled(grid, |p| {
        let inside = |x: f64, l: f64| (2.0..l - 2.0).contains(&x);
        !(inside(p.x, 24.0) && inside(p.y, 20.0) && inside(p.z, 16.0))
    })
}

/// A square tube along z: 20 x 20 outside, 30 long, walls 2 thick, open at both ends.
pub(crate) fn square_tube() -> Filled {
    let axis = || lines(&[(2.0, 1), (18.0, 4), (20.0, 1)]);
    filled([axis(), axis(), lines(&[(30.0, 8)])], |p| {
        !((2.0..18.0).contains(&p.x) && (2.0..18.0).contains(&p.y))
    })
}

/// A cube of side 10: no wall anywhere.
pub(crate) fn cube() -> Filled {
    filled(std::array::from_fn(|_| lines(&[(10.0, 4)])), |_| true)
}

/// A square ring of section 5 x 5: a solid torus.
pub(crate) fn solid_ring() -> Filled {
    let axis = || lines(&[(5.0, 3), (25.0, 3), (30.0, 3)]);
    filled([axis(), axis(), lines(&[(5.0, 3)])], |p| {
        !((5.0..25.0).contains(&p.x) && (5.0..25.0).contains(&p.y))
    })
}

/// A plate 60 x 40 x 2 that carries a block 12 x 12 x 10 on its middle.
pub(crate) fn plate_with_block() -> Filled {
    let x = lines(&[(24.0, 6), (36.0, 3), (60.0, 6)]);
    let y = lines(&[(14.0, 4), (26.0, 3), (40.0, 4)]);
    filled([x, y, lines(&[(2.0, 1), (12.0, 3)])], |p| {
        p.z < 2.0 || ((24.0..36.0).contains(&p.x) && (14.0..26.0).contains(&p.y))
    })
}

/// Two plates 30 x 12 x 2 in one plane that hang together only through a block 12 x 12 x 12 between them.
pub(crate) fn plates_through_block() -> Filled {
    let x = lines(&[(30.0, 8), (42.0, 4), (72.0, 8)]);
    let z = lines(&[(5.0, 2), (7.0, 1), (12.0, 2)]);
    filled([x, lines(&[(12.0, 4)]), z], |p| {
        (30.0..42.0).contains(&p.x) || (5.0..7.0).contains(&p.z)
    })
}

/// A plate 40 x 24, 2 thick for x < 20 and 4 thick beyond, with one flat lower side.
pub(crate) fn step_plate() -> Filled {
    let grid = [
        lines(&[(40.0, 10)]),
        lines(&[(24.0, 6)]),
        lines(&[(2.0, 1), (4.0, 1)]),
    ];
    filled(grid, |p| p.z < 2.0 || p.x > 20.0)
}

/// A plate 60 x 40 whose thickness grows from 2 along x by the angle.
pub(crate) fn wedge(angle_rad: f64) -> Filled {
    let grid = [
        lines(&[(60.0, 12)]),
        lines(&[(40.0, 8)]),
        lines(&[(1.0, 1)]),
    ];
    filled(grid, |_| true).mapped(|p| DVec3::new(p.x, p.y, p.z * (2.0 + p.x * angle_rad.tan())))
}

#[test]
fn volumes_faces_and_topology_are_those_of_the_shapes() {
    let volume = |s: &Filled| -> f64 {
        (s.tets.cells.iter())
            .map(|t| {
                let [a, b, c, d] = t.map(|v| s.brep.vertices[v]);
                let det = (b - a).cross(c - a).dot(d - a);
                assert!(det > 0.0, "a tet lies the wrong way round");
                det / 6.0
            })
            .sum()
    };
    for (name, solid, size, faces, euler) in [
        ("plate", plate(3), 40.0 * 24.0 * 2.0, 6, 2),
        ("tee", tee(1), 40.0 * 24.0 * 2.0 + 40.0 * 2.0 * 12.0, 10, 2),
        ("cross", cross(), 30.0 * (24.0 * 2.0 * 2.0 - 4.0), 14, 2),
        ("ell", ell(1), 24.0 * (60.0 + 36.0), 8, 2),
        ("hole", plate_with_hole(), 2.0 * (960.0 - 64.0), 10, 0),
        ("hollow", hollow_box(), 7680.0 - 20.0 * 16.0 * 12.0, 12, 4),
        ("tube", square_tube(), 30.0 * (400.0 - 256.0), 10, 0),
        ("ring", solid_ring(), 5.0 * (900.0 - 400.0), 10, 0),
        ("block", plate_with_block(), 4800.0 + 1440.0, 11, 2),
        ("plates", plates_through_block(), 1440.0 + 1728.0, 14, 2),
        ("step", step_plate(), 960.0 + 1920.0, 8, 2),
        ("channel", channel(), 24.0 * (60.0 + 72.0), 10, 2),
        ("cube", cube(), 1000.0, 6, 2),
    ] {
        assert!((volume(&solid) - size).abs() < 1e-9 * size, "{name}");
        assert!((solid.brep.volume() - size).abs() < 1e-9 * size, "{name}");
        assert_eq!(solid.brep.faces.len(), faces, "{name}");
        assert_eq!(solid.boundary_euler(), euler, "{name}");
        assert_eq!(solid.tets.check(solid.brep.vertices.len()), vec![]);
        let shuffled = solid.shuffled(1).brep;
        assert_ne!(shuffled.faces, solid.brep.faces);
        assert_eq!(shuffled.check(), vec![]);
        for (id, curve) in shuffled.curves.enumerated() {
            for &f in &curve.faces {
                assert!(shuffled.faces[f].curves.contains(&id));
            }
        }
    }
    let angle = 10f64.to_radians();
    let size = 40.0 * 60.0 * (2.0 + 30.0 * angle.tan());
    assert!((volume(&wedge(angle)) - size).abs() < 1e-9 * size);
}

/// Thin-walled parts with their pieces, loops and voids.
pub(crate) fn thin_parts() -> Vec<(&'static str, Filled, [usize; 3])> {
    vec![
        ("plate", plate(1), [1, 0, 0]),
        ("plate of three layers", plate(3), [1, 0, 0]),
        ("tee", tee(1), [1, 0, 0]),
        ("tee of three layers", tee(3), [1, 0, 0]),
        ("cross", cross(), [1, 0, 0]),
        ("ell", ell(1), [1, 0, 0]),
        ("ell of three layers", ell(3), [1, 0, 0]),
        ("channel", channel(), [1, 0, 0]),
        ("plate with a hole", plate_with_hole(), [1, 1, 0]),
        ("hollow box", hollow_box(), [1, 0, 1]),
        ("square tube", square_tube(), [1, 1, 0]),
        ("plate with a block", plate_with_block(), [1, 0, 0]),
        ("plates through a block", plates_through_block(), [1, 0, 0]),
        ("step", step_plate(), [1, 0, 0]),
    ]
}
