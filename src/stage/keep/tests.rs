use super::*;
use crate::geom::placer::Placer;
use crate::model::brep::{Curve, Face};
use crate::model::complex::EdgeKind;
use crate::model::ids::{NodeId, VertexId};
use crate::model::walls::Wall;
use crate::stage::adjacency::adjacency;
use crate::stage::test_shapes::sheet;
use crate::test_parts::voxels::{filled, lines};

/// A plate 40 x 24 x 2 on facets of 4; a place on its upper side is on the face of the given number, from 0.
fn plate(face: impl Fn(DVec3) -> usize) -> Brep {
    let grid = [
        lines(&[(40.0, 10)]),
        lines(&[(24.0, 6)]),
        lines(&[(2.0, 1)]),
    ];
    let mut brep = filled(grid, |_| true).brep;
    let first = brep.faces.len();
    for id in brep.facets.ids().collect::<Vec<_>>() {
        let centre = brep.corners(id).iter().sum::<DVec3>() / 3.0;
        if centre.z == 2.0 {
            let number = first + face(centre);
            while brep.faces.len() <= number {
                brep.faces.push(Face::default());
            }
            brep.facets[id].face = FaceId(number as u32);
        }
    }
    // Faces are numbered from 1, and every two that share sides have one edge.
    let mut sides: BTreeMap<[VertexId; 2], Vec<FaceId>> = BTreeMap::new();
    for facet in &brep.facets {
        for k in 0..3 {
            let [a, b] = [facet.corners[k], facet.corners[(k + 1) % 3]];
            let faces = sides.entry([a.min(b), a.max(b)]).or_default();
            faces.push(facet.face);
            faces.sort_unstable();
        }
    }
    let mut curves: BTreeMap<Vec<FaceId>, Vec<[VertexId; 2]>> = BTreeMap::new();
    for (side, faces) in sides.into_iter().filter(|(_, f)| f[0] != f[1]) {
        curves.entry(faces).or_default().push(side);
    }
    brep.curves = (curves.into_iter())
        .map(|(faces, segments)| Curve {
            tag: 1,
            faces,
            segments,
        })
        .collect();
    for (i, f) in brep.faces.as_mut_slice().iter_mut().enumerate() {
        f.tag = i as i32 + 1;
        f.curves = (brep.curves.enumerated())
            .filter(|(_, c)| c.faces.contains(&FaceId(i as u32)))
            .map(|(id, _)| id)
            .collect();
    }
    brep
}

/// The faces of a plate whose places are told to count.
fn faces_at(brep: &Brep, counts: impl Fn(DVec3) -> bool) -> Vec<FaceId> {
    let mut faces: Vec<FaceId> = (brep.facets.ids())
        .filter(|&f| counts(brep.corners(f).iter().sum::<DVec3>() / 3.0))
        .map(|f| brep.facets[f].face)
        .collect();
    faces.sort_unstable();
    faces.dedup();
    faces
}

fn number(brep: &Brep, at: DVec3) -> i32 {
    let nearest = (brep.facets.ids())
        .min_by(|a, b| {
            let far = |f| (brep.corners(f).iter().sum::<DVec3>() / 3.0).distance(at);
            far(*a).total_cmp(&far(*b))
        })
        .unwrap();
    brep.faces[brep.facets[nearest].face].tag
}

fn wall(brep: &Brep) -> Pairing {
    let mut pairing = Pairing::default();
    pairing.walls.push(Wall {
        sides: [
            faces_at(brep, |p| p.z == 2.0),
            faces_at(brep, |p| p.z == 0.0),
        ],
        thickness: 2.0,
        group: 0,
    });
    pairing.side = (brep.faces.ids())
        .map(|f| {
            let on = |s: usize| pairing.walls[WallId(0)].sides[s].contains(&f);
            (0..2).find(|&s| on(s)).map(|s| (0, s as u8))
        })
        .collect();
    pairing
}

/// What is asked of a sheet half-way up, over all of the plate, that is cut beneath the edges between the faces at two places of the upper side.
fn kept(brep: &Brep, between: &[[DVec3; 2]], check: impl Fn(&MidComplex, &Kept<'_>)) {
    let (aag, pairing) = (adjacency(brep), wall(brep));
    let medial = Medial::new(brep, &aag, &pairing);
    // No node of it lies on a line.
    let complex = sheet(11, 7, |u, v| DVec3::new(40.0 * u, 24.0 * v, 1.0));
    let wishes: Vec<KeepEdge> = (between.iter())
        .map(|places| KeepEdge {
            faces: places.map(|p| number(brep, p)),
        })
        .collect();
    let kept = keep(&complex, brep, &aag, &pairing, &medial, &wishes);
    let kept = kept.unwrap().unwrap();
    assert_eq!(kept.complex.check(), vec![]);
    assert_eq!(kept.complex.euler(), complex.euler());
    let joined = kept.pieces.joined(kept.complex.clone());
    assert!(joined.triangles.iter().all(|t| t.wall == WallId(0)));
    check(&kept.complex, &kept);
}

/// The edges between pieces.
fn creases(complex: &MidComplex) -> Vec<[DVec3; 2]> {
    (complex.edges().iter())
        .filter(|e| complex.kind(e) == EdgeKind::Crease)
        .map(|e| e.ends.map(|n: NodeId| complex.nodes[n].point))
        .collect()
}

fn length(edges: &[[DVec3; 2]]) -> f64 {
    edges.iter().map(|[a, b]| a.distance(*b)).sum()
}

const TOP: [DVec3; 4] = [
    DVec3::new(2.0, 2.0, 2.0),
    DVec3::new(38.0, 2.0, 2.0),
    DVec3::new(2.0, 22.0, 2.0),
    DVec3::new(38.0, 22.0, 2.0),
];

#[test]
fn a_line_from_rim_to_rim_is_straight_beneath_its_edge() {
    let brep = plate(|p| usize::from(p.x > 16.0));
    kept(&brep, &[[TOP[0], TOP[1]]], |complex, kept| {
        let line = creases(complex);
        for p in line.iter().flatten() {
            assert!((p.x - 16.0).abs() < 1e-9 && (p.z - 1.0).abs() < 1e-9, "{p}");
        }
        assert!((length(&line) - 24.0).abs() < 1e-9);
        let [told] = kept.standing(complex).try_into().unwrap();
        assert_eq!(told.edges, line.len());
        assert!((told.length - 24.0).abs() < 1e-9);
        // What is placed on the line stays, what leaves it comes back.
        let on: Vec<_> = (complex.nodes.iter())
            .filter(|n| n.supports.len() > 1 && n.point.x == 16.0)
            .collect();
        let off = on[0].point + DVec3::new(0.4, 0.1, 0.2);
        let back = kept.walls.place(off, &on[0].supports);
        assert!((back.x - 16.0).abs() < 1e-9 && (back.z - 1.0).abs() < 1e-9);
    });
}

#[test]
fn a_line_has_a_node_at_its_corner() {
    let brep = plate(|p| usize::from(p.x > 16.0 && p.y > 8.0));
    kept(&brep, &[[TOP[0], TOP[3]]], |complex, _| {
        let line = creases(complex);
        let corner = DVec3::new(16.0, 8.0, 1.0);
        assert!(line.iter().flatten().any(|p| p.distance(corner) < 1e-9));
        assert!((length(&line) - 40.0).abs() < 1e-9, "{}", length(&line));
    });
}

#[test]
fn three_lines_meet_in_one_node() {
    let brep = plate(|p| match (p.y > 12.0, p.x > 20.0) {
        (true, _) => 0,
        (false, false) => 1,
        (false, true) => 2,
    });
    let all = [[TOP[0], TOP[1]], [TOP[0], TOP[2]], [TOP[1], TOP[3]]];
    kept(&brep, &all, |complex, kept| {
        let line = creases(complex);
        let fork = DVec3::new(20.0, 12.0, 1.0);
        let there = line.iter().flatten().filter(|p| p.distance(fork) < 1e-9);
        assert_eq!(there.count(), 3);
        assert!((length(&line) - 52.0).abs() < 1e-9);
        let lengths: Vec<f64> = kept.standing(complex).iter().map(|k| k.length).collect();
        assert!((lengths.iter().sum::<f64>() - 52.0).abs() < 1e-9);
    });
    // One of them alone would end inside: the smaller face is kept all round.
    kept(&brep, &all[..1], |complex, kept| {
        assert!((length(&creases(complex)) - 32.0).abs() < 1e-9);
        assert_eq!(kept.standing(complex).len(), 2);
    });
}

#[test]
fn a_wish_for_an_edge_at_a_rim_is_refused_and_one_for_none_changes_nothing() {
    let brep = plate(|p| usize::from(p.x > 16.0));
    let (aag, pairing) = (adjacency(&brep), wall(&brep));
    let medial = Medial::new(&brep, &aag, &pairing);
    let complex = sheet(11, 7, |u, v| DVec3::new(40.0 * u, 24.0 * v, 1.0));
    let ask = |faces: [i32; 2]| {
        keep(
            &complex,
            &brep,
            &aag,
            &pairing,
            &medial,
            &[KeepEdge { faces }],
        )
        .map(|k| k.is_some())
    };
    let (top, rim) = (
        number(&brep, TOP[0]),
        number(&brep, DVec3::new(0.0, 2.0, 1.0)),
    );
    let wish = KeepEdge { faces: [top, rim] };
    assert_eq!(ask([top, rim]), Err((wish, Unkept::Outer)));
    assert_eq!(ask([top, 99]), Ok(false));
}

#[test]
fn edges_that_part_nothing_are_told_with_what_lies_above_them() {
    let complex = sheet(8, 8, |u, v| DVec3::new(8.0 * u, 8.0 * v, 0.0));
    let on = |n: NodeId, most: f64| {
        let p = complex.nodes[n].point;
        (p.x - 4.0).abs() < 1e-9 && p.y < most + 1e-9
    };
    let up_to = |most: f64| -> part::OnLines {
        (complex.edges().into_iter())
            .filter(|e| e.ends.iter().all(|n| on(*n, most)))
            .map(|e| (e.ends, CurveId(7)))
            .collect()
    };
    let mut whole = up_to(8.0);
    assert_eq!(part::idle(&complex, &mut whole), vec![]);
    assert_eq!(whole.len(), 8);
    let mut half = up_to(5.0);
    let told = part::idle(&complex, &mut half);
    assert_eq!(told.iter().map(|t| t.0).collect::<Vec<_>>(), [CurveId(7)]);
    assert!(half.is_empty());
    // A short end is noise.
    assert_eq!(part::idle(&complex, &mut up_to(2.0)), vec![]);
}
