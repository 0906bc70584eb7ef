//! A patch: a piece of one wall's sheet; its chart: the same piece laid flat; its mesh: what is drawn in the chart.
//!
//! Corners are counted within the patch (`u32`, positions in [`Patch::nodes`]): a node of the complex has two corners where the patch
//! touches itself, as on the two banks of a cut.

use super::ids::{NodeId, TriangleId, WallId};
use glam::{DVec2, DVec3};

/// A connected, orientable, two-manifold piece of one wall's sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// The wall that it lies in the middle of.
    pub wall: WallId,
    /// #C nodes of the complex, one a corner.
    pub nodes: Vec<NodeId>,
    /// #C positions, mm.
    pub points: Vec<DVec3>,
    /// #T triangles, all the same way round: that of the first triangle in the complex.
    pub triangles: Vec<[u32; 3]>,
    /// #T triangles of the complex that they come from.
    pub source: Vec<TriangleId>,
    /// Boundary loops with the patch on their left, the longest first.
    pub loops: Vec<Vec<u32>>,
    /// Edges inside the patch that must stay: folds, and feature curves that end inside it. Sorted.
    pub kept_edges: Vec<[u32; 2]>,
    /// Corners inside the patch that must stay. Sorted.
    pub kept_corners: Vec<u32>,
}

/// What can be wrong with a [`Patch`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PatchFault {
    /// A triangle names corners that do not exist, or one twice.
    #[error("triangle {0} of the patch has corners that are missing or equal")]
    BadTriangle(u32),
    /// A directed edge belongs to two triangles.
    #[error("edge {0} to {1} is used twice in one direction")]
    BadEdge(u32, u32),
    /// An edge of a single triangle is in no loop, or a loop has an edge that no single triangle has.
    #[error("edge {0} to {1} of the boundary and the loops disagree")]
    BadLoop(u32, u32),
}

impl Patch {
    /// The boundary edges, loop by loop, with the patch on their left.
    pub fn boundary(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.loops
            .iter()
            .flat_map(|l| (0..l.len()).map(|i| [l[i], l[(i + 1) % l.len()]]))
    }

    /// Euler characteristic V - E + F.
    pub fn euler(&self) -> i64 {
        let boundary: usize = self.loops.iter().map(Vec::len).sum();
        let edges = (3 * self.triangles.len() + boundary) / 2;
        self.nodes.len() as i64 - edges as i64 + self.triangles.len() as i64
    }

    /// Whether a plane can hold it: one boundary loop at least and no handle.
    pub fn is_planar_graph(&self) -> bool {
        let loops = self.loops.len() as i64;
        loops > 0 && self.euler() == 2 - loops
    }

    /// The positions of a triangle's corners, mm.
    pub fn triangle_points(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|c| self.points[c as usize])
    }

    /// Area, mm^2.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.triangle_points(t);
                (b - a).cross(c - a).length() / 2.0
            })
            .sum()
    }

    /// All violations.
    pub fn check(&self) -> Vec<PatchFault> {
        let mut faults = Vec::new();
        let mut half = Vec::with_capacity(3 * self.triangles.len());
        for (i, t) in self.triangles.iter().enumerate() {
            let missing = t.iter().any(|&c| c as usize >= self.nodes.len());
            if missing || t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                faults.push(PatchFault::BadTriangle(i as u32));
            }
            half.extend((0..3).map(|k| [t[k], t[(k + 1) % 3]]));
        }
        half.sort_unstable();
        for pair in half.windows(2) {
            if pair[0] == pair[1] {
                faults.push(PatchFault::BadEdge(pair[0][0], pair[0][1]));
            }
        }
        let mut listed: Vec<[u32; 2]> = self.boundary().collect();
        listed.sort_unstable();
        let open = half
            .iter()
            .filter(|e| half.binary_search(&[e[1], e[0]]).is_err());
        let mut seen = 0;
        for e in open {
            seen += 1;
            if listed.binary_search(e).is_err() {
                faults.push(PatchFault::BadLoop(e[0], e[1]));
            }
        }
        if seen != listed.len() {
            let extra = listed.iter().find(|e| {
                half.binary_search(e).is_err() || half.binary_search(&[e[1], e[0]]).is_ok()
            });
            let e = extra.copied().unwrap_or_default();
            faults.push(PatchFault::BadLoop(e[0], e[1]));
        }
        faults
    }
}

/// How a chart was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChartKind {
    /// Projected to its mean plane.
    Plane,
    /// Laid flat with a free boundary, lengths kept as well as can be.
    Free,
    /// Harmonic, onto a disc.
    Disc,
}

/// A patch laid flat.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// #C places in the plane, mm; the chart has the patch's area.
    pub places: Vec<DVec2>,
    /// How it was made.
    pub kind: ChartKind,
}

/// What can be wrong with a [`Chart`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChartFault {
    /// It has not as many places as the patch has corners.
    #[error("the chart has {places} places for {corners} corners")]
    Size {
        /// Places of the chart.
        places: usize,
        /// Corners of the patch.
        corners: usize,
    },
    /// A triangle is folded over, collapsed or not finite in the chart.
    #[error("triangle {triangle} has the signed area {area} in the chart")]
    Fold {
        /// Position of the triangle in the patch.
        triangle: u32,
        /// Its signed area, mm^2.
        area: f64,
    },
}

impl Chart {
    /// All violations; none means that the map is one to one near every point.
    pub fn check(&self, patch: &Patch) -> Vec<ChartFault> {
        if self.places.len() != patch.nodes.len() {
            return vec![ChartFault::Size {
                places: self.places.len(),
                corners: patch.nodes.len(),
            }];
        }
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| self.places[i as usize]);
            (b - a).perp_dot(c - a) / 2.0
        };
        let folded = |area: &f64| !area.is_finite() || *area <= 0.0;
        patch
            .triangles
            .iter()
            .enumerate()
            .map(|(i, t)| (i as u32, area(t)))
            .filter(|(_, area)| folded(area))
            .map(|(triangle, area)| ChartFault::Fold { triangle, area })
            .collect()
    }
}

/// New triangles for a patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchMesh {
    /// Positions of the new corners, mm; they are counted on from the patch's own.
    pub points: Vec<DVec3>,
    /// Triangles the same way round as the patch's. Of the patch's corners only those on its boundary and the kept ones are used.
    pub triangles: Vec<[u32; 3]>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Patch {
        Patch {
            wall: WallId(0),
            nodes: (0..4).map(NodeId).collect(),
            points: vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            source: vec![TriangleId(0), TriangleId(1)],
            loops: vec![vec![0, 1, 2, 3]],
            kept_edges: vec![],
            kept_corners: vec![],
        }
    }

    #[test]
    fn a_square_is_a_disc_of_area_one() {
        let p = square();
        assert_eq!((p.check(), p.euler()), (vec![], 1));
        assert!(p.is_planar_graph());
        assert_eq!(p.area(), 1.0);
    }

    #[test]
    fn planted_faults_are_seen() {
        let mut turned = square();
        turned.triangles[1] = [0, 3, 2];
        assert!(turned.check().contains(&PatchFault::BadEdge(2, 0)));
        let mut short = square();
        short.loops[0].pop();
        assert!(!short.check().is_empty());
        let mut equal = square();
        equal.triangles[0] = [0, 1, 1];
        assert!(equal.check().contains(&PatchFault::BadTriangle(0)));
    }

    #[test]
    fn a_planted_fold_is_seen() {
        let p = square();
        let mut chart = Chart {
            places: p.points.iter().map(|q| q.truncate()).collect(),
            kind: ChartKind::Plane,
        };
        assert_eq!(chart.check(&p), vec![]);
        chart.places[3] = DVec2::new(0.9, 0.1);
        assert!(matches!(
            chart.check(&p)[..],
            [ChartFault::Fold { triangle: 1, .. }]
        ));
        chart.places[3] = DVec2::new(f64::NAN, 0.0);
        assert_eq!(chart.check(&p).len(), 1);
        chart.places.pop();
        assert!(matches!(chart.check(&p)[..], [ChartFault::Size { .. }]));
    }
}
