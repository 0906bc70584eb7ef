//! Hand-made meshes: what becomes a piece, and what is refused.

use super::*;
use crate::model::brep::BrepFault;

fn entity(tag: i32, boundary: &[i32]) -> MshEntity {
    MshEntity {
        tag,
        physical: Vec::new(),
        boundary: boundary.to_vec(),
    }
}

fn block(dimension: usize, entity: i32, kind: ElementKind, nodes: &[u32]) -> ElementBlock {
    ElementBlock {
        dimension,
        entity,
        kind,
        nodes: nodes.to_vec(),
    }
}

/// Two tets of volume 1/6 that share the face of nodes 0, 1, 2: node 3 above, node 4 below. One solid each, or one solid of both.
///
/// Curve 1 runs from node 0 to node 1. The triangles of the surfaces are turned at random.
fn two_tets(one_solid: bool) -> Msh {
    let nodes = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1]]
        .map(|[x, y, z]| DVec3::new(f64::from(x), f64::from(y), f64::from(z)));
    let above = [0, 1, 3, 1, 3, 2, 0, 2, 3];
    let below = [0, 1, 4, 1, 4, 2, 0, 2, 4];
    let tri = ElementKind::Triangle3;
    let tet = ElementKind::Tet4;
    let mut msh = Msh {
        nodes: nodes.to_vec(),
        ..Msh::default()
    };
    msh.entities[1] = vec![entity(1, &[])];
    msh.entities[2] = vec![entity(1, &[1]), entity(2, &[-1, 1]), entity(3, &[1])];
    msh.elements = vec![
        block(1, 1, ElementKind::Line2, &[1, 0]),
        block(2, 1, tri, &above),
        block(2, 2, tri, &below),
        block(2, 3, tri, &[0, 1, 2]),
    ];
    if one_solid {
        msh.entities[3] = vec![entity(1, &[1, -2])];
        msh.elements
            .push(block(3, 1, tet, &[0, 1, 2, 3, 0, 2, 1, 4]));
    } else {
        msh.entities[3] = vec![entity(2, &[2, -3]), entity(1, &[3, 1])];
        msh.elements.push(block(3, 1, tet, &[0, 1, 2, 3]));
        msh.elements.push(block(3, 2, tet, &[0, 1, 2, 4]));
    }
    msh
}

#[test]
fn facets_are_turned_outwards_whatever_the_file_says() {
    let pieces = build_pieces(&two_tets(true)).unwrap();
    let brep = &pieces[0].brep;
    assert_eq!(pieces.len(), 1);
    assert_eq!((brep.facets.len(), brep.vertices.len()), (6, 5));
    assert!((brep.volume() - 1.0 / 3.0).abs() < 1e-15);
    assert!(brep.check().is_empty());
}

#[test]
fn a_face_between_two_solids_is_in_both_pieces() {
    let pieces = build_pieces(&two_tets(false)).unwrap();
    let tags: Vec<i32> = pieces.iter().map(|p| p.brep.solid_tag).collect();
    assert_eq!(tags, [1, 2], "in the order of the numbers");
    for piece in &pieces {
        assert!((piece.brep.volume() - 1.0 / 6.0).abs() < 1e-15);
        assert!(piece.brep.faces.iter().any(|f| f.tag == 3));
        assert_eq!(piece.brep.vertices.len(), 4, "only its own vertices");
    }
}

#[test]
fn curves_know_their_faces_once_and_their_segments() {
    let pieces = build_pieces(&two_tets(true)).unwrap();
    let brep = &pieces[0].brep;
    assert_eq!(brep.curves.len(), 1);
    let curve = &brep.curves[CurveId(0)];
    assert_eq!(curve.faces, [FaceId(0), FaceId(1)]);
    assert_eq!(curve.segments, [[VertexId(1), VertexId(0)]]);
    assert_eq!(brep.faces[FaceId(1)].curves, [CurveId(0)]);
}

#[test]
fn inner_vertices_come_last() {
    // A tet split into four around its centre, which is node 0 of the file.
    let corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4]];
    let mut msh = Msh {
        nodes: vec![DVec3::ONE],
        ..Msh::default()
    };
    msh.nodes
        .extend(corners.map(|[x, y, z]| DVec3::new(f64::from(x), f64::from(y), f64::from(z))));
    msh.entities[2] = vec![entity(1, &[])];
    msh.entities[3] = vec![entity(1, &[1])];
    msh.elements = vec![
        block(
            2,
            1,
            ElementKind::Triangle3,
            &[1, 2, 3, 1, 2, 4, 2, 3, 4, 3, 1, 4],
        ),
        block(
            3,
            1,
            ElementKind::Tet4,
            &[1, 2, 3, 0, 1, 4, 2, 0, 2, 4, 3, 0, 3, 4, 1, 0],
        ),
    ];
    let piece = &build_pieces(&msh).unwrap()[0];
    assert_eq!(piece.brep.vertices[VertexId(4)], DVec3::ONE);
    assert_eq!(piece.tets.cells.len(), 4);
    assert!((piece.brep.volume() - 64.0 / 6.0).abs() < 1e-12);
}

#[test]
fn middles_follow_their_sides_when_a_facet_is_turned() {
    for corners in [[0, 1, 2], [0, 2, 1]] {
        let mut msh = two_tets(true);
        // Mid-side nodes of the three triangles above, lifted by less than half a side; each is named after its side.
        let bulge = |a: u32, b: u32| f64::from(a * 10 + b) * 1e-3;
        let mut nodes = Vec::new();
        let [p, q, r] = corners;
        for mut t in [[0, 1, 3], [1, 2, 3], [0, 2, 3]] {
            t = [t[p], t[q], t[r]];
            nodes.extend(t);
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (t[i].min(t[j]), t[i].max(t[j]));
                let mid = msh.nodes[a as usize].midpoint(msh.nodes[b as usize]);
                nodes.push(msh.nodes.len() as u32);
                msh.nodes.push(mid + DVec3::splat(bulge(a, b)));
            }
        }
        msh.elements[1] = block(2, 1, ElementKind::Triangle6, &nodes);
        let piece = &build_pieces(&msh).unwrap()[0];
        for facet in piece.brep.facets.iter().filter(|f| f.face == FaceId(0)) {
            for (k, mid) in facet.mids.iter().enumerate() {
                let (u, v) = (facet.corners[k], facet.corners[(k + 1) % 3]);
                let straight = piece.brep.vertices[u].midpoint(piece.brep.vertices[v]);
                let (a, b) = (u.0.min(v.0), u.0.max(v.0));
                assert!((mid.x - straight.x - bulge(a, b)).abs() < 1e-12);
            }
        }
    }
}

#[test]
fn a_middle_that_is_far_off_is_put_back() {
    let mut msh = two_tets(true);
    msh.nodes.push(DVec3::new(0.5, -0.4, 0.0));
    msh.nodes.push(DVec3::new(0.5, -0.6, 0.0));
    for (node, kept) in [(5, true), (6, false)] {
        let nodes = [0, 1, 3, node, 5, 5];
        let [ab, ..] = middles(&msh, ElementKind::Triangle6, &nodes);
        assert_eq!(ab == msh.nodes[node as usize], kept);
        assert_eq!(ab == DVec3::new(0.5, 0.0, 0.0), !kept);
    }
}

#[test]
fn broken_meshes_are_refused() {
    let mut no_volume = two_tets(true);
    no_volume.entities[3].clear();
    assert_eq!(build_pieces(&no_volume), Err(PieceError::NoVolume));

    let mut empty = two_tets(true);
    empty.elements.pop();
    assert_eq!(
        build_pieces(&empty),
        Err(PieceError::NotFilled { solid: 1 })
    );

    let mut bare = two_tets(true);
    bare.elements[1].nodes.truncate(6);
    assert_eq!(
        build_pieces(&bare),
        Err(PieceError::BareTets { solid: 1, count: 1 })
    );

    let mut loose = two_tets(true);
    loose.elements[1].nodes.extend([0, 1, 2]);
    assert!(matches!(
        build_pieces(&loose),
        Err(PieceError::LooseFacet { face: 1, .. })
    ));

    let mut twice = two_tets(true);
    twice.elements[1].nodes.extend([0, 1, 3]);
    assert!(matches!(
        build_pieces(&twice),
        Err(PieceError::LooseFacet { face: 1, .. })
    ));

    let mut overlap = two_tets(true);
    if let Some(tets) = overlap.elements.last_mut() {
        tets.nodes.extend([0, 1, 2, 3]);
    }
    assert!(matches!(
        build_pieces(&overlap),
        Err(PieceError::Overlap { .. })
    ));

    let mut stray = two_tets(true);
    stray.elements[0].nodes = vec![3, 4];
    assert!(matches!(
        build_pieces(&stray),
        Err(PieceError::LooseSegment { curve: 1, .. })
    ));

    let mut not_finite = two_tets(true);
    not_finite.nodes[4].x = f64::NAN;
    assert!(matches!(
        build_pieces(&not_finite),
        Err(PieceError::Brep { faults, .. }) if faults == [BrepFault::NotFinite(VertexId(4))]
    ));
}

#[test]
fn tets_that_the_file_orients_at_random_are_oriented_alike() {
    let mut msh = two_tets(true);
    if let Some(tets) = msh.elements.last_mut() {
        tets.nodes = vec![0, 1, 2, 3, 0, 1, 2, 4];
    }
    let piece = &build_pieces(&msh).unwrap()[0];
    assert!((piece.brep.volume() - 1.0 / 3.0).abs() < 1e-15);
    for cell in &piece.tets.cells {
        let [a, b, c, d] = cell.map(|v| piece.brep.vertices[v]);
        assert!((b - a).dot((c - a).cross(d - a)) > 0.0);
    }
}

#[test]
fn a_flat_tet_is_oriented_by_its_neighbours() {
    // Node 5 lies in the plane of nodes 0, 1 and 2.
    for flat in [[0, 1, 2, 5], [1, 0, 2, 5]] {
        let mut msh = two_tets(true);
        msh.nodes.push(DVec3::new(1.0, 1.0, 0.0));
        msh.elements = vec![
            block(1, 1, ElementKind::Line2, &[1, 0]),
            block(
                2,
                1,
                ElementKind::Triangle3,
                &[0, 1, 3, 1, 2, 3, 0, 2, 3, 0, 1, 5, 0, 2, 5, 1, 5, 2],
            ),
            block(3, 1, ElementKind::Tet4, &[[0, 1, 2, 3], flat].concat()),
        ];
        msh.entities[3] = vec![entity(1, &[1])];
        let piece = &build_pieces(&msh).unwrap()[0];
        assert!((piece.brep.volume() - 1.0 / 6.0).abs() < 1e-15);
        assert_eq!(piece.brep.facets.len(), 6);
    }
}
