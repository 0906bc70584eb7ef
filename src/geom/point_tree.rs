//! A tree over points that finds those near a segment.
//!
//! Guarantees: what [`PointTree::near_segment`] finds is what a search through all points finds, in ascending order; points that are not finite are never found.
//! Cost: n log n to build whatever the spread of the points, about log n and the number found for a short segment.
//!
//! Reference: J. L. Bentley, Multidimensional binary search trees used for associative searching, CACM 18 (1975), doi:10.1145/361002.361007.

use super::triangle::nearest_on_segment;
use glam::DVec3;

/// Points of a leaf.
const LEAF: usize = 8;

struct Node {
    low: DVec3,
    high: DVec3,
    /// From and to in the order of the leaves.
    range: [u32; 2],
    /// The second child; the first follows its parent. None for a leaf.
    second: Option<u32>,
}

/// A tree over points.
pub struct PointTree<'a> {
    points: &'a [DVec3],
    order: Vec<u32>,
    nodes: Vec<Node>,
}

impl<'a> PointTree<'a> {
    /// Builds the tree. Any number of points, none too.
    pub fn new(points: &'a [DVec3]) -> Self {
        let order: Vec<u32> = (0..points.len() as u32)
            .filter(|&i| points[i as usize].is_finite())
            .collect();
        let mut tree = Self {
            points,
            order,
            nodes: Vec::new(),
        };
        let count = tree.order.len();
        if count > 0 {
            tree.build(0, count);
        }
        tree
    }

    fn build(&mut self, from: usize, to: usize) {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &i in &self.order[from..to] {
            let p = self.points[i as usize];
            (low, high) = (low.min(p), high.max(p));
        }
        let place = self.nodes.len();
        self.nodes.push(Node {
            low,
            high,
            range: [from as u32, to as u32],
            second: None,
        });
        if to - from <= LEAF {
            return;
        }
        let extent = high - low;
        let axis = (0..3).fold(0, |best, k| if extent[k] > extent[best] { k } else { best });
        let middle = (to - from) / 2;
        let points = self.points;
        // Ties by index: the tree, and with it the order of what is found, is the same every time.
        self.order[from..to].select_nth_unstable_by(middle, |&a, &b| {
            let (x, y) = (points[a as usize][axis], points[b as usize][axis]);
            x.total_cmp(&y).then(a.cmp(&b))
        });
        self.build(from, from + middle);
        self.nodes[place].second = Some(self.nodes.len() as u32);
        self.build(from + middle, to);
    }

    /// Points no farther than `reach` from the segment, ascending; at most `most` of them are looked for.
    pub fn near_segment(&self, [a, b]: [DVec3; 2], reach: f64, most: usize) -> Vec<u32> {
        let mut found = Vec::new();
        let (low, high) = (a.min(b) - reach, a.max(b) + reach);
        let mut open: Vec<u32> = if self.nodes.is_empty() {
            vec![]
        } else {
            vec![0]
        };
        while let Some(place) = open.pop() {
            let node = &self.nodes[place as usize];
            if node.low.cmpgt(high).any() || node.high.cmplt(low).any() {
                continue;
            }
            // A long oblique segment has a large box: the ball round the node decides.
            let centre = (node.low + node.high) / 2.0;
            let radius = (node.high - node.low).length() / 2.0;
            let away = nearest_on_segment(a, b, centre).distance(centre);
            if away > (radius + reach) * (1.0 + 1e-12) {
                continue;
            }
            if let Some(second) = node.second {
                open.extend([second, place + 1]);
                continue;
            }
            let [from, to] = node.range.map(|i| i as usize);
            for &i in &self.order[from..to] {
                let p = self.points[i as usize];
                if nearest_on_segment(a, b, p).distance(p) <= reach {
                    found.push(i);
                }
            }
            if found.len() >= most {
                found.truncate(most);
                break;
            }
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::random::Pcg;

    #[test]
    fn what_is_found_is_what_a_search_through_all_finds() {
        let mut random = Pcg::new(11);
        let mut at = || DVec3::new(random.unit(), random.unit(), 0.1 * random.unit());
        let mut points: Vec<DVec3> = (0..700).map(|_| at()).collect();
        points[3] = DVec3::NAN;
        points[5] = points[6];
        let tree = PointTree::new(&points);
        for _ in 0..200 {
            let (a, b) = (at(), at());
            for reach in [0.0, 0.01, 0.2] {
                let want: Vec<u32> = (0..points.len() as u32)
                    .filter(|&i| {
                        let p = points[i as usize];
                        p.is_finite() && nearest_on_segment(a, b, p).distance(p) <= reach
                    })
                    .collect();
                assert_eq!(tree.near_segment([a, b], reach, usize::MAX), want);
            }
        }
        let twice = points[5];
        assert_eq!(tree.near_segment([twice; 2], 0.0, 10), [5, 6]);
    }

    #[test]
    fn a_thousand_points_in_one_place_cost_no_more_than_was_asked_for() {
        let points = vec![DVec3::ONE; 1000];
        let tree = PointTree::new(&points);
        assert_eq!(tree.near_segment([DVec3::ONE; 2], 0.0, 5).len(), 5);
        assert!(
            PointTree::new(&[])
                .near_segment([DVec3::ONE; 2], 1.0, 5)
                .is_empty()
        );
    }
}
