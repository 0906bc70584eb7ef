use super::*;
use crate::geom::random::Pcg;
use crate::test_parts::homology::of_collapsed;
use crate::test_parts::voxels::{
    Filled, cube, filled, hollow_box, lines, plate, solid_ring, thin_parts,
};
use glam::DVec3;

fn run(
    solid: &Filled,
    protected: impl FnMut(&[VertexId; 2]) -> bool,
    grade: impl FnMut(&[VertexId; 2]) -> Grade,
) -> (TetGraph, Collapsed) {
    let graph = TetGraph::new(&solid.tets);
    let protected = graph.edges.iter().map(protected).collect();
    let grade = graph.edges.iter().map(grade).collect();
    let collapsed = collapse(&graph, solid.brep.vertices.len(), &protected, &grade);
    (graph, collapsed)
}

#[test]
fn pieces_loops_and_voids_stay_whatever_is_protected() {
    let mut parts = thin_parts();
    parts.push(("cube", cube(), [1, 0, 0]));
    parts.push(("ring", solid_ring(), [1, 1, 0]));
    for (name, solid, betti) in parts {
        for (seed, share) in [(1, 0.0), (2, 0.03), (3, 0.3), (4, 0.8), (5, 1.0)] {
            let mut rng = Pcg::new(seed);
            let mut grades = Pcg::new(seed + 100);
            let (graph, collapsed) = run(
                &solid,
                |_| rng.unit() < share,
                // Also grades beyond the last.
                |_| (grades.unit() * (GRADES + 2) as f64) as Grade,
            );
            // A single point is left of a ball, and points are not listed.
            let left = of_collapsed(&graph, &collapsed).unwrap_or([1, 0, 0]);
            assert_eq!(left, betti, "{name}, {share} protected");
        }
    }
}

#[test]
fn a_ball_goes_altogether_and_a_solid_ring_leaves_a_ring_of_bars() {
    for solid in [cube(), plate(1), plate(3)] {
        let (_, left) = run(&solid, |_| false, |_| 0);
        assert!(left.cells.iter().all(|c| !c) && left.bars.is_empty());
    }
    let (graph, left) = run(&solid_ring(), |_| false, |_| 0);
    assert!(left.cells.iter().all(|c| !c));
    let mut degree = IndexVec::filled(0, graph.tet_faces.len());
    for &f in &left.bars {
        assert!(!graph.on_boundary(f), "a bar ends on the boundary");
        for t in graph.face_tets[f] {
            degree[t] += 1;
        }
    }
    assert!(left.bars.len() > 8 && degree.iter().all(|&d| d == 0 || d == 2));
    assert_eq!(of_collapsed(&graph, &left), Some([1, 1, 0]));
}

/// Whether a vertex lies on the outer skin of the hollow box, or on its inner.
fn skins(p: DVec3) -> (bool, bool) {
    let low = p.min(DVec3::new(24.0, 20.0, 16.0) - p).min_element();
    (low == 0.0, low == 2.0)
}

#[test]
fn the_surface_left_of_a_hollow_box_parts_its_outer_skin_from_its_inner() {
    // All vertices lie on the skins: the only closed surface is dual to the edges between the two, whatever the order.
    let solid = hollow_box();
    for seed in 0..4 {
        let mut grades = Pcg::new(seed);
        let (graph, left) = run(&solid, |_| false, |_| (grades.unit() * 4.0) as Grade);
        assert!(left.bars.is_empty());
        for (e, ends) in graph.edges.enumerated() {
            let [u, v] = ends.map(|v| skins(solid.brep.vertices[v]).0);
            assert_eq!(left.cells[e], u != v);
        }
    }
}

#[test]
fn cells_of_low_grade_go_first_and_protected_ones_last() {
    // Two layers: the vertices in the middle of the wall join the skin that the cheaper edges lead to.
    let axis = |l: f64, n| lines(&[(2.0, 2), (l - 2.0, n), (l, 2)]);
    let grid = [axis(24.0, 5), axis(20.0, 4), axis(16.0, 3)];
    let solid = filled(grid, |p| {
        p.min(DVec3::new(24.0, 20.0, 16.0) - p).min_element() < 2.0
    });
    let at = |v: VertexId| skins(solid.brep.vertices[v]);
    let outer = |e: &[VertexId; 2]| at(e[0]).0 != at(e[1]).0;
    let inner = |e: &[VertexId; 2]| at(e[0]).1 != at(e[1]).1;
    let by_grade = run(&solid, |_| false, |e| if outer(e) { 3 } else { 0 });
    let by_protection = run(&solid, inner, |_| 0);
    let reverse = run(&solid, |_| false, |e| if inner(e) { 1 } else { 0 });
    for ((graph, left), wanted) in [
        (by_grade, &outer as &dyn Fn(&[VertexId; 2]) -> bool),
        (by_protection, &inner),
        (reverse, &inner),
    ] {
        for (e, ends) in graph.edges.enumerated() {
            assert_eq!(left.cells[e], wanted(ends), "{ends:?}");
        }
    }
}

#[test]
fn protected_cells_stay_where_every_inner_vertex_has_another_way_out() {
    let solid = cube();
    let p = &solid.brep.vertices;
    let along_x = |e: &[VertexId; 2]| {
        let d = p[e[0]] - p[e[1]];
        d.y == 0.0 && d.z == 0.0
    };
    let (graph, left) = run(&solid, |e| !along_x(e), |_| 0);
    for (e, ends) in graph.edges.enumerated() {
        assert!(along_x(ends) || left.cells[e]);
    }
    // Each of the 3 x 3 x 3 inner vertices opens through one of the others.
    let gone = left.cells.iter().filter(|c| !**c).count();
    assert!(gone >= 27, "{gone}");
}

#[test]
fn a_hole_in_the_protection_heals_and_a_missing_rim_does_not() {
    let solid = plate(1);
    let through = |e: &[VertexId; 2]| {
        let p = e.map(|v| solid.brep.vertices[v].z);
        p[0] != p[1]
    };
    let (graph, whole) = run(&solid, through, |e| Grade::from(through(e)));
    let x = |e: &[VertexId; 2]| e.map(|v| solid.brep.vertices[v].x);
    let in_middle = |e: &[VertexId; 2]| x(e).iter().all(|x| (12.0..28.0).contains(x));
    let (_, holed) = run(
        &solid,
        |e| through(e) && !in_middle(e),
        |e| Grade::from(through(e)),
    );
    assert!(graph.edges.iter().any(|e| through(e) && in_middle(e)));
    // The gap reaches both long rims, so the middle is eaten from there; what is left stays in one piece.
    assert_eq!(of_collapsed(&graph, &holed), Some([1, 0, 0]));
    let inside = |e: &[VertexId; 2]| {
        e.iter().all(|&v| {
            let p = solid.brep.vertices[v];
            (8.0..32.0).contains(&p.x) && (8.0..=16.0).contains(&p.y)
        })
    };
    let (_, healed) = run(
        &solid,
        |e| through(e) && !inside(e),
        |e| Grade::from(through(e)),
    );
    assert!(graph.edges.iter().any(|e| through(e) && inside(e)));
    assert_eq!(healed, whole);
    let (_, short) = run(
        &solid,
        |e| through(e) && x(e)[0] < 30.0,
        |e| Grade::from(through(e)),
    );
    for (e, ends) in graph.edges.enumerated() {
        assert_eq!(short.cells[e], whole.cells[e] && x(ends)[0] < 30.0);
    }
}

#[test]
fn the_judge_sees_a_cell_that_is_missing_and_one_too_many() {
    let (graph, left) = run(&hollow_box(), |_| false, |_| 0);
    assert_eq!(of_collapsed(&graph, &left), Some([1, 0, 1]));
    let alive = graph.edges.ids().find(|&e| left.cells[e]).unwrap();
    let mut torn = left.clone();
    torn.cells[alive] = false;
    assert_eq!(of_collapsed(&graph, &torn), Some([1, 0, 0]));
    let (graph, mut left) = run(&solid_ring(), |_| false, |_| 0);
    left.bars.pop();
    assert_eq!(of_collapsed(&graph, &left), Some([1, 0, 0]));
}
