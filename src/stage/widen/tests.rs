use super::*;
use crate::geom::random::Pcg;
use crate::model::ids::Id;
use crate::stage::collapse::collapse;
use crate::test_parts::homology::of_collapsed;
use crate::test_parts::stages::stages;
use crate::test_parts::voxels::{Filled, plate, solid_ring, square_tube, thin_parts};

/// Pieces of living cells that hang together by lines.
fn pieces(graph: &TetGraph, left: &Collapsed) -> usize {
    let mut root: Vec<usize> = (0..graph.edges.len()).collect();
    fn find(root: &mut [usize], mut x: usize) -> usize {
        while root[x] != x {
            root[x] = root[root[x]];
            x = root[x];
        }
        x
    }
    for es in &graph.face_edges {
        let living: Vec<usize> = (es.iter().filter(|&&e| left.cells[e]))
            .map(|e| e.index())
            .collect();
        for pair in living.windows(2) {
            let (a, b) = (find(&mut root, pair[0]), find(&mut root, pair[1]));
            root[a] = b;
        }
    }
    (graph.edges.ids())
        .filter(|&e| left.cells[e] && find(&mut root, e.index()) == e.index())
        .count()
}

/// Collapses and widens until there is nothing to widen; also the rounds that it took.
fn settle(solid: &Filled, share: f64, seed: u64) -> (TetGraph, Collapsed, usize) {
    let graph = TetGraph::new(&solid.tets);
    let mut rng = Pcg::new(seed);
    let mut protected: IndexVec<TetEdgeId, bool> =
        graph.edges.iter().map(|_| rng.unit() < share).collect();
    let grade = graph
        .edges
        .iter()
        .map(|_| (rng.unit() * 3.0) as Grade)
        .collect();
    let vertices = solid.brep.vertices.len();
    for round in 0.. {
        let left = collapse(&graph, vertices, &protected, &grade);
        let more = widen(&graph, &left, &grade);
        assert!(more.windows(2).all(|p| p[0] < p[1]), "not sorted");
        if more.is_empty() || round == 40 {
            return (graph, left, round);
        }
        for e in more {
            protected[e] = true;
        }
    }
    unreachable!()
}

#[test]
fn a_ring_of_bars_becomes_a_ring_of_sheet() {
    let (graph, left, rounds) = settle(&solid_ring(), 0.0, 1);
    assert!(left.bars.is_empty(), "{rounds} rounds");
    assert_eq!(of_collapsed(&graph, &left), Some([1, 1, 0]));
    assert_eq!(pieces(&graph, &left), 1);
}

#[test]
fn scattered_cells_end_as_one_sheet_without_bars() {
    for (name, solid, betti) in [
        ("plate", plate(1), [1, 0, 0]),
        ("ring", solid_ring(), [1, 1, 0]),
        ("tube", square_tube(), [1, 1, 0]),
    ] {
        for (seed, share) in [(1, 0.01), (2, 0.05), (3, 0.2)] {
            let (graph, left, rounds) = settle(&solid, share, seed);
            assert!(left.bars.is_empty(), "{name} {share}: {rounds} rounds");
            assert_eq!(of_collapsed(&graph, &left), Some(betti), "{name} {share}");
            assert_eq!(pieces(&graph, &left), 1, "{name} {share}");
        }
    }
}

#[test]
fn walls_of_real_labels_hang_together_by_sheet() {
    for (name, solid, betti) in thin_parts() {
        let stages = stages(&solid);
        let left = stages.widened();
        assert!(left.bars.is_empty(), "{name}");
        assert_eq!(pieces(&stages.graph, &left), 1, "{name}");
        assert_eq!(of_collapsed(&stages.graph, &left), Some(betti), "{name}");
    }
}

#[test]
fn nothing_is_widened_where_there_is_no_bar() {
    let solid = plate(1);
    let stages = stages(&solid);
    assert!(stages.collapsed.bars.is_empty());
    assert_eq!(
        widen(&stages.graph, &stages.collapsed, &stages.grade),
        vec![]
    );
}
