//! Extract: the mid-complex from the living 2-cells.
//!
//! A living cell has a node on its tet edge. In a triangle with two living edges of one wall the sheet crosses on the straight line between their nodes;
//! in a tet whose crossings close to a ring of three or four it fills the ring: there the dual complex is the usual triangle or quad of a marching-tets surface.
//! Everywhere else (three living edges, walls that meet, sheets that end inside) a node in the triangle and one in the tet are kept, so that the complex is
//! the dual one, up to collapses inside a single wall. Junction curves, creases and rims come out as edges of it.

use crate::geom::placer::Placer;
use crate::geom::rim_loops::open_shut;
use crate::medial::Medial;
use crate::model::brep::Brep;
use crate::model::complex::{MidComplex, MidNode, MidTriangle, Support, Supports};
use crate::model::decomposition::{Decomposition, Passage};
use crate::model::ids::{
    FaceId, Id, IndexVec, NodeId, TetEdgeId, TetFaceId, TetId, VertexId, WallId,
};
use crate::model::tet_graph::TetGraph;
use crate::model::walls::Pairing;
use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

/// The wall of every living cell: that of the opposing labels whose faces are nearest; cells without any take their neighbours'.
pub fn cell_walls(
    brep: &Brep,
    graph: &TetGraph,
    pairing: &Pairing,
    decomposition: &Decomposition,
    cells: &IndexVec<TetEdgeId, bool>,
    medial: &Medial<'_>,
) -> (IndexVec<TetEdgeId, Option<WallId>>, usize) {
    let mut walls_of: IndexVec<FaceId, SmallVec<[(WallId, u8); 2]>> =
        IndexVec::filled(SmallVec::new(), brep.faces.len());
    for (w, wall) in pairing.walls.enumerated() {
        for s in 0..2 {
            for &f in &wall.sides[s] {
                walls_of[f].push((w, s as u8));
            }
        }
    }
    let mut wall: IndexVec<TetEdgeId, Option<WallId>> = graph
        .edges
        .as_slice()
        .par_iter()
        .enumerate()
        .map(|(i, &[u, v])| {
            let id = TetEdgeId::new(i);
            if !cells[id] || decomposition.passage[id] != Passage::Through {
                return None;
            }
            let mut found: SmallVec<[WallId; 4]> = SmallVec::new();
            let mut weaker: SmallVec<[WallId; 4]> = SmallVec::new();
            for &a in &decomposition.labels[u] {
                for &b in &decomposition.labels[v] {
                    if let Some(p) = pairing.pair(a, b) {
                        found.push(p.wall);
                    } else if pairing.opposing(a, b) {
                        weaker.extend(walls_of[a].iter().chain(&walls_of[b]).map(|w| w.0));
                    }
                }
            }
            if found.is_empty() {
                found = weaker;
            }
            found.sort_unstable();
            found.dedup();
            let middle = (brep.vertices[u] + brep.vertices[v]) / 2.0;
            nearest_wall(medial, middle, &found)
        })
        .collect::<Vec<_>>()
        .into();
    let adopted = adopt(graph, cells, &mut wall);
    (wall, adopted)
}

fn nearest_wall(medial: &Medial<'_>, p: DVec3, walls: &[WallId]) -> Option<WallId> {
    if let [only] = walls {
        return Some(*only);
    }
    walls
        .iter()
        .filter_map(|&w| {
            medial
                .feet(p, w)
                .map(|[a, b]| ((a.point - p).length() + (b.point - p).length(), w))
        })
        .min_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)))
        .map(|x| x.1)
}

/// Cells without a wall take that of a neighbour over a triangle, wave by wave; the lowest wall where several offer.
fn adopt(
    graph: &TetGraph,
    cells: &IndexVec<TetEdgeId, bool>,
    wall: &mut IndexVec<TetEdgeId, Option<WallId>>,
) -> usize {
    let mut open: Vec<TetEdgeId> = graph
        .edges
        .ids()
        .filter(|&e| cells[e] && wall[e].is_none())
        .collect();
    let total = open.len();
    let mut around: Vec<(TetEdgeId, TetFaceId)> = Vec::new();
    let mut is_open = IndexVec::filled(false, graph.edges.len());
    for &e in &open {
        is_open[e] = true;
    }
    for (f, es) in graph.face_edges.enumerated() {
        around.extend(es.iter().filter(|&&e| is_open[e]).map(|&e| (e, f)));
    }
    around.sort_unstable();
    while !open.is_empty() {
        let offers: Vec<(TetEdgeId, WallId)> = open
            .iter()
            .filter_map(|&e| {
                let from = around.partition_point(|x| x.0 < e);
                around[from..]
                    .iter()
                    .take_while(|x| x.0 == e)
                    .flat_map(|x| graph.face_edges[x.1])
                    .filter_map(|n| if cells[n] { wall[n] } else { None })
                    .min()
                    .map(|w| (e, w))
            })
            .collect();
        if offers.is_empty() {
            break;
        }
        for (e, w) in offers {
            wall[e] = Some(w);
        }
        open.retain(|&e| wall[e].is_none());
    }
    total
}

/// Builds the complex and places its nodes.
pub fn extract(
    brep: &Brep,
    graph: &TetGraph,
    pairing: &Pairing,
    wall: &IndexVec<TetEdgeId, Option<WallId>>,
    medial: &Medial<'_>,
) -> MidComplex {
    let mut builder = Builder {
        brep,
        graph,
        wall,
        faces_at: boundary_faces(brep, graph),
        edge_node: IndexVec::filled(None, graph.edges.len()),
        face_node: IndexVec::filled(None, graph.faces.len()),
        complex: MidComplex::default(),
        rim_faces: Vec::new(),
    };
    for t in graph.tet_faces.ids() {
        builder.tet(t);
    }
    builder.finish(pairing, medial)
}

/// Puts every node onto its supports, but for those that would shut a hole.
pub fn place(mut complex: MidComplex, medial: &dyn Placer) -> MidComplex {
    let before = complex.nodes.iter().map(|n| n.point).collect();
    complex
        .nodes
        .as_mut_slice()
        .par_iter_mut()
        .for_each(|n| n.point = medial.place(n.point, &n.supports));
    open_shut(&mut complex, &before, medial);
    complex
}

/// Faces of the solid at every boundary edge and triangle of the filling.
struct BoundaryFaces {
    of_face: IndexVec<TetFaceId, Option<FaceId>>,
    of_edge: IndexVec<TetEdgeId, SmallVec<[FaceId; 2]>>,
}

fn boundary_faces(brep: &Brep, graph: &TetGraph) -> BoundaryFaces {
    let mut facets: Vec<([VertexId; 3], FaceId)> = brep
        .facets
        .iter()
        .map(|f| {
            let mut key = f.corners;
            key.sort_unstable();
            (key, f.face)
        })
        .collect();
    facets.sort_unstable();
    let mut of_face = IndexVec::filled(None, graph.faces.len());
    let mut of_edge: IndexVec<TetEdgeId, SmallVec<[FaceId; 2]>> =
        IndexVec::filled(SmallVec::new(), graph.edges.len());
    for (f, corners) in graph
        .faces
        .enumerated()
        .filter(|(f, _)| graph.on_boundary(*f))
    {
        if let Ok(at) = facets.binary_search_by(|x| x.0.cmp(corners)) {
            of_face[f] = Some(facets[at].1);
            for e in graph.face_edges[f] {
                if !of_edge[e].contains(&facets[at].1) {
                    of_edge[e].push(facets[at].1);
                }
            }
        }
    }
    BoundaryFaces { of_face, of_edge }
}

struct Builder<'a> {
    brep: &'a Brep,
    graph: &'a TetGraph,
    wall: &'a IndexVec<TetEdgeId, Option<WallId>>,
    faces_at: BoundaryFaces,
    edge_node: IndexVec<TetEdgeId, Option<NodeId>>,
    face_node: IndexVec<TetFaceId, Option<NodeId>>,
    complex: MidComplex,
    /// Faces of the solid that a node lies on.
    rim_faces: Vec<(NodeId, FaceId)>,
}

impl Builder<'_> {
    fn node(&mut self, point: DVec3) -> NodeId {
        self.complex.nodes.push(MidNode {
            point,
            supports: Supports::new(),
        })
    }

    fn edge_node(&mut self, e: TetEdgeId) -> NodeId {
        if let Some(n) = self.edge_node[e] {
            return n;
        }
        let [u, v] = self.graph.edges[e];
        let n = self.node((self.brep.vertices[u] + self.brep.vertices[v]) / 2.0);
        self.edge_node[e] = Some(n);
        for &f in &self.faces_at.of_edge[e] {
            self.rim_faces.push((n, f));
        }
        n
    }

    fn face_node(&mut self, f: TetFaceId) -> NodeId {
        if let Some(n) = self.face_node[f] {
            return n;
        }
        let living: SmallVec<[TetEdgeId; 3]> = self.graph.face_edges[f]
            .into_iter()
            .filter(|&e| self.wall[e].is_some())
            .collect();
        let nodes: SmallVec<[NodeId; 3]> = living.iter().map(|&e| self.edge_node(e)).collect();
        let sum: DVec3 = nodes.iter().map(|&n| self.complex.nodes[n].point).sum();
        let centre: DVec3 = self.graph.faces[f]
            .iter()
            .map(|&v| self.brep.vertices[v])
            .sum::<DVec3>()
            / 3.0;
        // A cell that ends in this triangle reaches to its centre.
        let point = if nodes.len() > 1 {
            sum / nodes.len() as f64
        } else {
            centre
        };
        let n = self.node(point);
        self.face_node[f] = Some(n);
        if let Some(face) = self.faces_at.of_face[f] {
            self.rim_faces.push((n, face));
        }
        n
    }

    /// Adds what one tet holds: the cone from its middle over its triangles' crossings, or a plain triangle or quad.
    fn tet(&mut self, t: TetId) {
        let graph = self.graph;
        if graph.tet_edges[t].iter().all(|&e| self.wall[e].is_none()) {
            return;
        }
        // Crossings: (node, node, wall) a triangle of the tet.
        let mut lines: SmallVec<[(NodeId, NodeId, WallId); 12]> = SmallVec::new();
        let mut plain = true;
        for f in graph.tet_faces[t] {
            let living: SmallVec<[(TetEdgeId, WallId); 3]> = graph.face_edges[f]
                .into_iter()
                .filter_map(|e| self.wall[e].map(|w| (e, w)))
                .collect();
            match living.as_slice() {
                [] => {}
                [(a, w), (b, x)] if w == x => {
                    let line = (self.edge_node(*a), self.edge_node(*b), *w);
                    lines.push(line);
                }
                _ => {
                    plain = false;
                    let centre = self.face_node(f);
                    for &(e, w) in &living {
                        let n = self.edge_node(e);
                        lines.push((n, centre, w));
                    }
                }
            }
        }
        let wall = lines[0].2;
        plain &= lines.iter().all(|l| l.2 == wall);
        if plain && let Some(ring) = ring(&lines) {
            self.fill(&ring, wall);
            return;
        }
        let mut around: SmallVec<[NodeId; 12]> = lines.iter().flat_map(|l| [l.0, l.1]).collect();
        around.sort_unstable();
        around.dedup();
        let middle = around
            .iter()
            .map(|&n| self.complex.nodes[n].point)
            .sum::<DVec3>()
            / around.len() as f64;
        let centre = self.node(middle);
        for (a, b, wall) in lines {
            self.complex.triangles.push(MidTriangle {
                nodes: [a, b, centre],
                wall,
            });
        }
    }

    fn fill(&mut self, ring: &[NodeId], wall: WallId) {
        let p = |i: usize| self.complex.nodes[ring[i]].point;
        match *ring {
            [a, b, c] => {
                self.complex.triangles.push(MidTriangle {
                    nodes: [a, b, c],
                    wall,
                });
            }
            [a, b, c, d] => {
                let (first, second) = if p(0).distance_squared(p(2)) <= p(1).distance_squared(p(3))
                {
                    ([a, b, c], [a, c, d])
                } else {
                    ([a, b, d], [b, c, d])
                };
                for nodes in [first, second] {
                    self.complex.triangles.push(MidTriangle { nodes, wall });
                }
            }
            _ => {}
        }
    }

    fn finish(mut self, pairing: &Pairing, medial: &Medial<'_>) -> MidComplex {
        let mut mids: Vec<(NodeId, WallId)> = self
            .complex
            .triangles
            .iter()
            .flat_map(|t| t.nodes.map(|n| (n, t.wall)))
            .collect();
        mids.sort_unstable();
        mids.dedup();
        for (n, w) in mids {
            self.complex.nodes[n].supports.push(Support::Mid(w));
        }
        self.rim_faces.sort_unstable();
        for &(n, f) in &self.rim_faces {
            // A side of the node's own wall holds no rim: there the complex only touches the surface, at a knife edge.
            let own = self.complex.nodes[n].supports.iter().any(|s| {
                matches!(s, Support::Mid(w) if pairing.walls[*w].sides.iter().any(|side| side.binary_search(&f).is_ok()))
            });
            if !own {
                self.complex.nodes[n].supports.push(Support::Face(f));
            }
        }
        for n in self.complex.nodes.as_mut_slice() {
            n.supports.sort_unstable();
            n.supports.dedup();
        }
        place(self.complex, medial)
    }
}

/// The lines as one closed ring of three or four nodes, if they are one.
fn ring(lines: &[(NodeId, NodeId, WallId)]) -> Option<SmallVec<[NodeId; 4]>> {
    if !(3..=4).contains(&lines.len()) {
        return None;
    }
    let mut ring: SmallVec<[NodeId; 4]> = SmallVec::from_slice(&[lines[0].0, lines[0].1]);
    let mut used = [true, false, false, false];
    while ring.len() < lines.len() {
        let last = ring[ring.len() - 1];
        let k =
            (0..lines.len()).find(|&k| !used[k] && (lines[k].0 == last || lines[k].1 == last))?;
        used[k] = true;
        ring.push(if lines[k].0 == last {
            lines[k].1
        } else {
            lines[k].0
        });
    }
    let closing = (0..lines.len()).find(|&k| !used[k])?;
    let (a, b) = (ring[0], ring[ring.len() - 1]);
    let closes = (lines[closing].0, lines[closing].1) == (a, b)
        || (lines[closing].1, lines[closing].0) == (a, b);
    let mut sorted = ring.clone();
    sorted.sort_unstable();
    sorted.dedup();
    (closes && sorted.len() == lines.len()).then_some(ring)
}

#[cfg(test)]
mod tests;
