//! Nodes in one place, and nodes on edges of other elements.

use super::edges::Edges;
use super::{AtNodes, ON_EDGE};
use crate::geom::point_tree::PointTree;
use crate::geom::triangle::nearest_on_segment;
use crate::model::disjoint::Disjoint;
use crate::model::ids::{Id, NodeId};
use crate::model::mesh_audit::Found;
use crate::model::shell::ShellMesh;
use rayon::prelude::*;

/// Nodes near one node that are looked at: each of a heap is joined with so many, which joins the heap, and a million nodes in one place stay affordable.
const MOST_NEAR: usize = 32;
/// Nodes near one edge that are looked at: more is a heap, not an edge that others end on.
const MOST_ON_EDGE: usize = 4096;

/// A node farther off an edge than this share of its distance to the nearer end does not lie on it: seen from the node the edge turns by more than 12 degrees.
const BESIDE: f64 = 0.2;

/// Groups of nodes within `reach` of each other, one by one.
pub(super) fn duplicate_nodes(mesh: &ShellMesh, of_node: &AtNodes, reach: f64) -> Vec<Found> {
    let points = mesh.nodes.as_slice();
    let tree = PointTree::new(points);
    let near: Vec<Vec<u32>> = points
        .par_iter()
        .map(|&p| tree.near_segment([p; 2], reach, MOST_NEAR))
        .collect();
    let mut sets = Disjoint::new(points.len());
    for (node, near) in (0u32..).zip(&near) {
        for &other in near {
            sets.join(node, other);
        }
    }
    let mut by_set: Vec<(u32, u32)> = (0..points.len() as u32)
        .map(|node| (sets.find(node), node))
        .collect();
    by_set.sort_unstable();
    by_set
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|run| run.len() > 1)
        .map(|run| {
            let nodes: Vec<NodeId> = run.iter().map(|(_, node)| NodeId(*node)).collect();
            let mut elements: Vec<_> = nodes.iter().flat_map(|&n| &of_node[n]).copied().collect();
            elements.sort_unstable();
            elements.dedup();
            Found {
                at: points[run[0].0 as usize],
                nodes,
                elements,
            }
        })
        .collect()
}

/// Nodes of elements that lie on an edge of others: not at its ends, where they would be duplicates, and not the apex of a flat element that has the edge, which its
/// quality tells.
pub(super) fn t_connections(
    mesh: &ShellMesh,
    edges: &Edges,
    of_node: &AtNodes,
    reach: f64,
) -> Vec<Found> {
    let points = mesh.nodes.as_slice();
    let tree = PointTree::new(points);
    let edges: Vec<_> = edges.iter().collect();
    let found: Vec<Vec<Found>> = edges
        .par_iter()
        .map(|sides| {
            let ends = sides[0].ends;
            let [a, b] = ends.map(|n| mesh.nodes[n]);
            // Between ends in one place there is no place left; in a heap of nodes every edge is such.
            let length = a.distance(b);
            if length <= 2.0 * reach {
                return Vec::new();
            }
            let near = tree.near_segment([a, b], ON_EDGE * length, MOST_ON_EDGE);
            near.into_iter()
                .map(NodeId)
                .filter(|&node| {
                    let p = mesh.nodes[node];
                    let on = nearest_on_segment(a, b, p);
                    let of = &of_node[node];
                    let nearer = p.distance(a).min(p.distance(b));
                    let inside = nearer > reach;
                    // The far corner of a needle lies near the end of an edge, but beside it.
                    let beside = on.distance(p) > BESIDE * nearer;
                    inside
                        && !beside
                        && !of.is_empty()
                        && !ends.contains(&node)
                        && !sides.iter().any(|s| of.contains(&s.element))
                })
                .map(|node| Found {
                    at: mesh.nodes[node],
                    nodes: vec![node, ends[0], ends[1]],
                    elements: sides.iter().map(|s| s.element).collect(),
                })
                .collect()
        })
        .collect();
    let mut found: Vec<Found> = found.into_iter().flatten().collect();
    found.sort_by_key(|f| f.nodes.iter().map(|n| n.index()).collect::<Vec<_>>());
    found
}
