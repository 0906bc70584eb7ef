use super::*;
use crate::model::ids::{SheetId, WallId};
use crate::model::mesh_audit::SheetNormals;
use crate::model::shell::{Corners, Element, Sheet};
use crate::test_parts::plate_mesh;

/// Elements of these corners, all of one sheet.
fn mesh(nodes: &[[f64; 3]], corners: &[&[u32]]) -> ShellMesh {
    let elements = corners.iter().map(|c| {
        let ids: Vec<NodeId> = c.iter().map(|&n| NodeId(n)).collect();
        Element {
            corners: match *ids.as_slice() {
                [a, b, c] => Corners::Triangle([a, b, c]),
                [a, b, c, d] => Corners::Quad([a, b, c, d]),
                _ => unreachable!(),
            },
            sheet: SheetId(0),
            thickness: [1.0; 4],
            source_faces: [0; 2],
            unsure: false,
        }
    });
    ShellMesh {
        nodes: nodes.iter().map(|p| DVec3::from(*p)).collect(),
        elements: elements.collect(),
        sheets: vec![Sheet {
            solid_tag: 1,
            wall: WallId(0),
            sides: [vec![], vec![]],
        }]
        .into(),
        ..ShellMesh::default()
    }
}

fn count(mesh: &ShellMesh, kind: FindingKind) -> usize {
    findings(mesh).of(kind).len()
}

fn push_node(mesh: &mut ShellMesh, at: DVec3) -> NodeId {
    mesh.nodes.push(at)
}

#[test]
fn a_plate_has_its_rim_and_nothing_else() {
    let mesh = plate_mesh(20, 12);
    let found = findings(&mesh);
    let kinds: Vec<FindingKind> = found.found.iter().map(|(k, _)| *k).collect();
    assert_eq!(kinds, [FindingKind::FreeEdge]);
    assert_eq!(found.of(FindingKind::FreeEdge).len(), 64);
    let [sheet] = found.sheets.as_slice() else {
        panic!("{:?}", found.sheets)
    };
    assert_eq!(
        (sheet.elements, sheet.opposite_edges, sheet.turned),
        (240, 0, 0)
    );
    assert!((sheet.area - 6000.0).abs() < 1e-9 && !sheet.one_sided);
}

#[test]
fn a_hanging_node_is_a_t_connection_with_its_edge() {
    // A large quad beside two small ones.
    let nodes = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
        [3.0, 0.0, 0.0],
        [3.0, 1.0, 0.0],
        [3.0, 2.0, 0.0],
        [2.0, 1.0, 0.0],
    ];
    let large: &[u32] = &[0, 1, 2, 3];
    let small: [&[u32]; 2] = [&[1, 4, 5, 7], &[7, 5, 6, 2]];
    let mut hanging = mesh(&nodes, &[large, small[0], small[1]]);
    let found = findings(&hanging);
    let [t] = found.of(FindingKind::TConnection) else {
        panic!("{found:?}")
    };
    assert_eq!(t.nodes, [7, 1, 2].map(NodeId));
    assert_eq!(
        (t.elements.as_slice(), t.at),
        (&[ElementId(0)][..], DVec3::new(2.0, 1.0, 0.0))
    );
    // Off the edge by more than the tolerance it is none; by less it is one.
    hanging.nodes[NodeId(7)].x += 0.021;
    assert_eq!(count(&hanging, FindingKind::TConnection), 0);
    hanging.nodes[NodeId(7)].x -= 0.002;
    assert_eq!(count(&hanging, FindingKind::TConnection), 1);
    // The apex of a flat triangle lies on its own longest side, and on that of its neighbour: bad quality, but no gap.
    let flat = mesh(
        &[
            [0.0; 3],
            [2.0, 0.0, 0.0],
            [1.0, 0.001, 0.0],
            [1.0, -1.0, 0.0],
        ],
        &[&[0, 1, 2], &[1, 0, 3]],
    );
    assert_eq!(count(&flat, FindingKind::TConnection), 0);
    // Nor does the far corner of the next of two needles.
    let needles = mesh(
        &[
            [0.0; 3],
            [10.0, 0.0, 0.0],
            [9.99, 0.03, 0.0],
            [9.98, 0.06, 0.0],
        ],
        &[&[0, 1, 2], &[0, 2, 3]],
    );
    assert_eq!(count(&needles, FindingKind::TConnection), 0);
}

#[test]
fn a_rib_that_only_touches_a_plate_hangs_on_its_edges() {
    let mut mesh = plate_mesh(20, 12);
    let at = |mesh: &ShellMesh, n: u32| mesh.nodes[NodeId(n)];
    // Its two feet lie on edges of the plate, in the middle between their ends.
    let (a, b) = (at(&mesh, 130), at(&mesh, 131));
    let (c, d) = (at(&mesh, 151), at(&mesh, 152));
    let feet = [(a + b) / 2.0, (c + d) / 2.0].map(|p| push_node(&mut mesh, p));
    let heads = feet.map(|n| {
        let p = mesh.nodes[n] + DVec3::Z * 5.0;
        push_node(&mut mesh, p)
    });
    let mut rib = mesh.elements[ElementId(0)].clone();
    rib.corners = Corners::Quad([feet[0], feet[1], heads[1], heads[0]]);
    mesh.elements.push(rib);
    let found = findings(&mesh);
    let on: Vec<NodeId> = (found.of(FindingKind::TConnection).iter())
        .map(|f| f.nodes[0])
        .collect();
    assert_eq!(on, feet);
}

#[test]
fn nodes_in_one_place_are_grouped_whatever_their_count() {
    let mut mesh = plate_mesh(20, 12);
    let at = mesh.nodes[NodeId(130)];
    let twin = push_node(&mut mesh, at + DVec3::splat(1e-6));
    if let Corners::Quad(n) = &mut mesh.elements[ElementId(124)].corners {
        for n in n.iter_mut().filter(|n| **n == NodeId(130)) {
            *n = twin;
        }
    }
    let found = findings(&mesh);
    let [pair] = found.of(FindingKind::DuplicateNode) else {
        panic!("{found:?}")
    };
    assert_eq!(pair.nodes, [NodeId(130), twin]);
    assert!(pair.elements.contains(&ElementId(124)) && pair.at == at);
    // The seam opens on both sides.
    assert!(found.of(FindingKind::FreeEdge).len() > 64);

    let mut heap = plate_mesh(20, 12);
    for _ in 0..5000 {
        push_node(&mut heap, at);
    }
    let found = findings(&heap);
    let [group] = found.of(FindingKind::DuplicateNode) else {
        panic!("not one group")
    };
    assert_eq!(group.nodes.len(), 5001);
    assert_eq!(found.of(FindingKind::UnusedNode).len(), 5000);
}

#[test]
fn elements_that_are_there_twice_are_found_whichever_way_they_run() {
    let mut mesh = plate_mesh(20, 12);
    let mut copy = mesh.elements[ElementId(7)].clone();
    if let Corners::Quad(n) = &mut copy.corners {
        n.reverse();
    }
    let copy = mesh.elements.push(copy);
    let found = findings(&mesh);
    let [twice] = found.of(FindingKind::DuplicateElement) else {
        panic!("{found:?}")
    };
    assert_eq!(twice.elements, [ElementId(7), copy]);
    assert!(!found.of(FindingKind::NonManifoldEdge).is_empty());
}

#[test]
fn a_junction_is_an_edge_of_three_elements() {
    let nodes = [
        [0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [-1.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 1.0, 1.0],
    ];
    let tee = mesh(&nodes, &[&[0, 2, 3, 1], &[4, 0, 1, 5], &[0, 1, 7, 6]]);
    let found = findings(&tee);
    let [junction] = found.of(FindingKind::NonManifoldEdge) else {
        panic!("{found:?}")
    };
    assert_eq!(junction.nodes, [0, 1].map(NodeId));
    assert_eq!(
        (junction.elements.len(), junction.at),
        (3, DVec3::new(0.0, 0.5, 0.0))
    );
    assert_eq!(found.of(FindingKind::FreeEdge).len(), 9);
}

#[test]
fn a_corner_that_comes_twice_and_a_node_of_no_element_are_found() {
    let mut mesh = plate_mesh(20, 12);
    if let Corners::Quad(n) = &mut mesh.elements[ElementId(9)].corners {
        n[3] = n[2];
    }
    let spare = push_node(&mut mesh, DVec3::new(-9.0, 0.0, 0.0));
    let found = findings(&mesh);
    assert_eq!(
        found.of(FindingKind::RepeatedCorner)[0].elements,
        [ElementId(9)]
    );
    assert_eq!(found.of(FindingKind::UnusedNode)[0].nodes, [spare]);
}

fn turn(mesh: &mut ShellMesh, element: u32) {
    match &mut mesh.elements[ElementId(element)].corners {
        Corners::Quad(n) => n.reverse(),
        Corners::Triangle(n) => n.reverse(),
    }
}

#[test]
fn the_lesser_part_of_a_sheet_is_turned_over() {
    let mut mesh = plate_mesh(20, 12);
    turn(&mut mesh, 0);
    turn(&mut mesh, 125);
    let found = findings(&mesh);
    assert_eq!(found.of(FindingKind::OppositeNormals).len(), 2 + 4);
    let SheetNormals {
        opposite_edges,
        turned,
        one_sided,
        ..
    } = found.sheets[0];
    assert_eq!((opposite_edges, turned, one_sided), (6, 2, false));
}

#[test]
fn a_moebius_strip_has_one_side() {
    let n = 12;
    let mut nodes = Vec::new();
    for i in 0..n {
        let turn = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        for side in [-1.0, 1.0] {
            let (out, up) = (side * (turn / 2.0).cos(), side * (turn / 2.0).sin());
            nodes.push([(4.0 + out) * turn.cos(), (4.0 + out) * turn.sin(), up]);
        }
    }
    let corners: Vec<[u32; 4]> = (0..n as u32)
        .map(|i| {
            let (a, b) = (2 * i, 2 * i + 1);
            match i + 1 == n as u32 {
                // After a turn the two sides have changed places.
                true => [a, 1, 0, b],
                false => [a, a + 2, b + 2, b],
            }
        })
        .collect();
    let corners: Vec<&[u32]> = corners.iter().map(|c| c.as_slice()).collect();
    let strip = mesh(&nodes, &corners);
    let sheet = &findings(&strip).sheets[0];
    assert!(sheet.one_sided && sheet.opposite_edges == 1, "{sheet:?}");
}

#[test]
fn a_long_strip_costs_no_square() {
    // Forty thousand nodes: all pairs would take minutes.
    let mesh = plate_mesh(400, 100);
    let found = findings(&mesh);
    assert_eq!(found.found.len(), 1);
    assert_eq!(found.of(FindingKind::FreeEdge).len(), 1000);
}
