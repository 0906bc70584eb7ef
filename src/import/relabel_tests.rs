//! A box whose filling does not conform to its faces, with closed-form truth.

use super::*;
use crate::model::brep::Face;

const SIZE: DVec3 = DVec3::new(8.0, 6.0, 2.0);

/// A box: a face of two flat facets for either end of each axis, numbered 1 to 6, and its twelve edges.
fn box_skin() -> Skin {
    let mut skin = Skin {
        solid_tag: 1,
        ..Skin::default()
    };
    let corner = |axis: usize, end: usize, u: usize, v: usize| {
        let mut p = [0.0; 3];
        p[axis] = end as f64;
        p[(axis + 1) % 3] = u as f64;
        p[(axis + 2) % 3] = v as f64;
        DVec3::from_array(p) * SIZE
    };
    for axis in 0..3 {
        for end in 0..2 {
            skin.faces.push(Face {
                tag: skin.faces.len() as i32 + 1,
                ..Face::default()
            });
            let c = |u, v| corner(axis, end, u, v);
            let facets = [[c(0, 0), c(1, 0), c(1, 1)], [c(0, 0), c(1, 1), c(0, 1)]];
            let flat = |[a, b, c]: [DVec3; 3]| QuadraticTriangle {
                corners: [a, b, c],
                mids: [a.midpoint(b), b.midpoint(c), c.midpoint(a)],
            };
            skin.facets.push(facets.map(flat).to_vec());
        }
    }
    for axis in 0..3 {
        for (u, v) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            // The edge along `axis` where the next two axes are at these ends.
            let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut from = DVec3::ZERO;
            from[b] = u as f64 * SIZE[b];
            from[c] = v as f64 * SIZE[c];
            let mut to = from;
            to[axis] = SIZE[axis];
            skin.curves.push(SkinCurve {
                tag: skin.curves.len() as i32 + 1,
                faces: vec![2 * b as u32 + u as u32, 2 * c as u32 + v as u32],
                segments: vec![[from, to]],
            });
        }
    }
    skin
}

/// A grid of tets over the box, every point of it off by up to `error` in a fixed pattern.
fn rough_filling(error: f64) -> Filling {
    let n = [8usize, 6, 2];
    let at = |i: [usize; 3]| ((i[2] * (n[1] + 1) + i[1]) * (n[0] + 1) + i[0]) as u32;
    let mut points = Vec::new();
    for k in 0..=n[2] {
        for j in 0..=n[1] {
            for i in 0..=n[0] {
                let s = points.len() as f64;
                let off = DVec3::new((s * 1.7).sin(), (s * 2.3).cos(), (s * 3.1).sin());
                points.push(DVec3::new(i as f64, j as f64, k as f64) + off * error);
            }
        }
    }
    let mut tets = Vec::new();
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                // Kuhn's six tets: one a way from a corner of the cell to the one opposite.
                for (way, even) in [
                    ([0, 1, 2], true),
                    ([1, 2, 0], true),
                    ([2, 0, 1], true),
                    ([0, 2, 1], false),
                    ([2, 1, 0], false),
                    ([1, 0, 2], false),
                ] {
                    let mut place = [i, j, k];
                    let mut tet = [at(place); 4];
                    for (step, axis) in way.into_iter().enumerate() {
                        place[axis] += 1;
                        tet[step + 1] = at(place);
                    }
                    if !even {
                        tet.swap(0, 1);
                    }
                    tets.push(tet);
                }
            }
        }
    }
    Filling { points, tets }
}

#[test]
fn a_rough_filling_comes_back_onto_its_box() {
    let piece = relabel(&box_skin(), &rough_filling(0.05), 0.05).unwrap();
    let brep = &piece.brep;
    assert_eq!((brep.faces.len(), brep.curves.len()), (6, 12));
    assert!((brep.volume() - 96.0).abs() < 1e-9, "{}", brep.volume());
    assert!((brep.area() - 152.0).abs() < 1e-9, "{}", brep.area());
    assert_eq!(brep.euler(), 2);
    let tags: Vec<i32> = brep.faces.iter().map(|f| f.tag).collect();
    assert_eq!(tags, [1, 2, 3, 4, 5, 6]);
    assert!(brep.faces.iter().all(|f| f.curves.len() == 4));
    for curve in &brep.curves {
        let skin = box_skin();
        let own = skin.curves.iter().find(|c| c.tag == curve.tag).unwrap();
        let [a, b] = own.segments[0];
        let length = |&[p, q]: &[VertexId; 2]| brep.vertices[p].distance(brep.vertices[q]);
        let sum: f64 = curve.segments.iter().map(length).sum();
        assert!((sum - a.distance(b)).abs() < 1e-9, "curve {}", curve.tag);
    }
    for facet in &brep.facets {
        let axis = facet.face.index() / 2;
        let end = SIZE[axis] * (facet.face.index() % 2) as f64;
        assert!(facet.mids.iter().all(|m| (m[axis] - end).abs() < 1e-9));
    }
    for cell in &piece.tets.cells {
        let [a, b, c, d] = cell.map(|v| brep.vertices[v]);
        assert!((b - a).dot((c - a).cross(d - a)) > 0.0);
    }
}

#[test]
fn points_beyond_the_envelope_stay_where_they_are() {
    let piece = relabel(&box_skin(), &rough_filling(0.05), 0.005).unwrap();
    assert!((piece.brep.volume() - 96.0).abs() > 1e-3);
}

#[test]
fn boxes_that_touch_along_an_edge_are_opened() {
    let mut filling = rough_filling(0.0);
    // Without the cells of two opposite corners of the floor, the rest still hangs together; with only those two, an edge is all they share.
    let keep = |t: &[u32; 4]| {
        let c = t.iter().map(|&v| filling.points[v as usize]).sum::<DVec3>() / 4.0;
        (c.x < 4.0) == (c.y < 3.0)
    };
    let tets: Vec<[u32; 4]> = filling.tets.iter().copied().filter(keep).collect();
    filling.tets = tets;
    let piece = relabel(&box_skin(), &filling, 0.01).unwrap();
    assert_eq!(piece.brep.euler(), 4, "two spheres");
}
